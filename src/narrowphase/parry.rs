//! Contacts computed by parry: of balls, capsules and rounded shapes, and of the parts of meshes, height fields and compounds.

use super::Rules;
use super::candidates::{Candidate, Candidates, max_points, push};
use super::dispatcher::Dispatcher;
use super::polyhedra::FeatureId;
use super::{reduction, rolling};
use crate::body::BodyState;
use crate::collider::is_surface;
use crate::contact::{Manifold, NarrowphaseCache, ParryCache};
use glam::Vec3;
use parry3d::query::{PersistentQueryDispatcher, TrackedContact};
use parry3d::shape::{PackedFeatureId, Shape, TypedShape};
use smallvec::SmallVec;

/// Points of a patch nearer to each other than this share of the smaller face's size become one.
const MERGE: f32 = 0.05;

/// Fills the manifold with the points no further apart than `reach`, m.
pub(super) fn detect(
    rules: &Rules,
    a: &BodyState,
    b: &BodyState,
    reach: f32,
    cache: &mut NarrowphaseCache,
    manifold: &mut Manifold,
) {
    let ParryCache {
        manifolds,
        workspace,
    } = &mut **cache.parry.get_or_insert_default();
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return;
    };
    let between = a.pose.to_parry().inv_mul(&b.pose.to_parry());
    let curved = a.is_curved() || b.is_curved();
    if curved {
        // A manifold that is kept turns with the surface, and a cylinder would roll off by itself.
        manifolds.clear();
        *workspace = None;
    }
    let dispatcher = Dispatcher {
        bodies: [a, b],
        graze: rules.stabilization.outer_distance(),
        most: max_points(rules),
    };
    let found =
        dispatcher.contact_manifolds(&between, shape_a, shape_b, reach, manifolds, workspace);
    if found.is_err() {
        // Parry has no contacts between two surfaces without volume, such as two meshes.
        manifolds.clear();
    }
    // Which of the two is a surface, whose triangles lie beside each other.
    let surface = [shape_a, shape_b]
        .iter()
        .position(|shape| is_surface(*shape));
    let mut faces: SmallVec<[Face; 4]> = SmallVec::new();
    for found in manifolds.iter() {
        let (sub_a, sub_b) = (
            found.subshape_pos1().copied(),
            found.subshape_pos2().copied(),
        );
        let turned = sub_a.map_or(found.local_n1, |sub| sub.rotation * found.local_n1);
        // A ball's centre inside another shape's edge has no normal: part the bodies upwards.
        let normal = -(a.pose.rotation * turned);
        let normal = normal.try_normalize().unwrap_or(Vec3::Y);

        let size = a.face_size(normal).min(b.face_size(normal));
        let mut face = Face {
            normal,
            size,
            plane: surface.and_then(|side| match side {
                0 => Plane::of(shape_a, found.subshape1),
                _ => Plane::of(shape_b, found.subshape2),
            }),
            candidates: Candidates::new(),
        };
        for contact in &found.points {
            let local_a = sub_a.map_or(contact.local_p1, |sub| sub * contact.local_p1);
            let local_b = sub_b.map_or(contact.local_p2, |sub| sub * contact.local_p2);
            let on = [
                a.pose.transform_point(local_a),
                b.pose.transform_point(local_b),
            ];
            face.candidates.push(Candidate {
                position: 0.5 * (on[0] + on[1]),
                distance: contact.dist,
                feature: match curved && contact.fid2 != PackedFeatureId::UNKNOWN {
                    // It rolls on.
                    true => FeatureId::NONE,
                    false => feature(contact).of_parts(found.subshape1, found.subshape2),
                },
            });
        }
        face.candidates
            .retain(|c| c.distance.is_finite() && c.distance <= reach);
        match faces.iter_mut().find(|other| other.goes_on_in(&face)) {
            Some(other) => other.candidates.extend(face.candidates),
            None => faces.push(face),
        }
    }
    for face in faces {
        let Face {
            normal,
            size,
            mut candidates,
            ..
        } = face;
        merge(&mut candidates, MERGE * size);
        // A round side touches along a line, whose middle adds nothing and comes and goes.
        if curved && reduction::is_line(&candidates, size) {
            reduction::keep_ends(&mut candidates);
        }
        if candidates.len() > max_points(rules) {
            reduction::reduce(&mut candidates, normal);
        }
        let radius = a.rolling_radius().min(b.rolling_radius());
        let rolls = curved && rolling::rolls(&candidates, radius, size);
        push(manifold, [a, b], normal, rolls, candidates);
    }
}

/// Normals whose cosine is above this are one, and planes nearer to each other than this share of the smaller face's size.
const PARALLEL: f32 = 1.0 - 1e-6;
const EVEN: f32 = 1e-3;

/// Where the two touch in one plane: one patch, over however many triangles it goes.
struct Face {
    normal: Vec3,
    /// Of the smaller face, m.
    size: f32,
    /// Of the triangle, where one of the two is a surface.
    plane: Option<Plane>,
    candidates: Candidates,
}

impl Face {
    /// The surface is flat from one to the other. It does not suffice that the normals of the contact are one: a flat body on a ridge has
    /// its own normal on either side of it, and four points of both sides together may leave out the ridge.
    fn goes_on_in(&self, other: &Self) -> bool {
        let (Some(here), Some(there)) = (self.plane, other.plane) else {
            return false;
        };
        self.normal.dot(other.normal) > PARALLEL
            && here.normal.dot(there.normal) > PARALLEL
            && here.normal.dot(there.on - here.on).abs() <= EVEN * self.size.min(other.size)
    }
}

/// The plane of a triangle, in the frame of its surface.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vec3,
    on: Vec3,
}

impl Plane {
    fn of(surface: &dyn Shape, number: u32) -> Option<Self> {
        let triangle = match surface.as_typed_shape() {
            TypedShape::TriMesh(mesh) => mesh.triangle(number),
            TypedShape::HeightField(field) => field.triangle_at_id(number)?,
            _ => return None,
        };
        Some(Self {
            normal: triangle.normal()?,
            on: triangle.center(),
        })
    }
}

/// The features that meet at a point, from parry or from our own contacts.
fn feature(contact: &TrackedContact<()>) -> FeatureId {
    match contact.fid2 {
        PackedFeatureId::UNKNOWN => FeatureId(contact.fid1.0),
        of_b => FeatureId(contact.fid1.0 ^ of_b.0.rotate_left(16)),
    }
}

/// Drops what is nearer than `merge` (m) to a deeper point.
fn merge(candidates: &mut Candidates, merge: f32) {
    candidates.sort_by(|x, y| x.distance.total_cmp(&y.distance));
    let mut kept = Candidates::new();
    for &candidate in candidates.iter() {
        let near = |k: &Candidate| k.position.distance_squared(candidate.position) < merge * merge;
        if !kept.iter().any(near) {
            kept.push(candidate);
        }
    }
    *candidates = kept;
}
