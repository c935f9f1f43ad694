//! Contacts that parry computes: those of balls, capsules and rounded shapes, and of the parts of meshes, height fields and compounds.

use super::Rules;
use super::candidates::{Candidate, Candidates, max_points, push, sort_deepest_first};
use super::composites::{self, flush, part_of};
use super::dispatcher::Dispatcher;
use super::polyhedra::{Axis, FeatureId};
use super::{reduction, rolling};
use crate::body::{BodyState, collider::is_surface};
use crate::pair::{Manifold, NarrowphaseCache, ParryCache, ParryManifold, PatchParts};
use glam::Vec3;
use parry3d::query::{PersistentQueryDispatcher, TrackedContact};
use parry3d::shape::{PackedFeatureId, Shape, TypedShape};
use smallvec::SmallVec;

/// Points of a patch are merged if they are nearer to each other than this share of the smaller face's size.
const MERGE_DISTANCE: f32 = 0.05;

/// Fills the manifold with the points whose distance is at most `reach`, m. Returns a lower bound of the distance of the two bodies, m; −∞
/// if none is known.
pub(super) fn detect(
    rules: &Rules,
    a: &BodyState,
    b: &BodyState,
    reach: f32,
    cache: &mut NarrowphaseCache,
    manifold: &mut Manifold,
) -> f32 {
    let mut apart = f32::NEG_INFINITY;
    let ParryCache {
        manifolds,
        workspace,
        is_read,
    } = &mut **cache.parry.get_or_insert_default();
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return apart;
    };
    let between = a.pose.to_parry().inv_mul(&b.pose.to_parry());
    let curved = a.is_curved() || b.is_curved();
    let are_ours = composites::are_ours([shape_a, shape_b]);
    if curved && !are_ours {
        // A kept manifold would rotate with the surface, and a cylinder would roll away by itself.
        manifolds.clear();
        *workspace = None;
    }
    let kept = match std::mem::take(is_read) && !are_ours {
        true => std::mem::take(manifolds),
        false => Vec::new(),
    };
    let dispatcher = Dispatcher {
        kept: &kept,
        bodies: [a, b],
        graze: rules.stabilization.outer_distance(),
        most: max_points(rules),
    };
    if are_ours {
        if curved {
            // As above, in the memory that they have.
            for kept in &mut *manifolds {
                kept.data = Axis::Unknown;
                kept.points.clear();
            }
        }
        apart = composites::find(&dispatcher, &between, [shape_a, shape_b], reach, manifolds);
    } else if dispatcher
        .contact_manifolds(&between, shape_a, shape_b, reach, manifolds, workspace)
        .is_err()
    {
        // Parry has no contacts between two surfaces without volume, such as two meshes.
        manifolds.clear();
    }
    let mut faces = faces([a, b], [shape_a, shape_b], manifolds, reach);
    let reduces = rules.manifolds.reduce_manifolds;
    if are_ours && reduces && !curved && faces.len() > 1 {
        faces = flush::join(faces);
    }
    for face in faces {
        let Face {
            normal,
            size,
            mut candidates,
            parts,
            is_joined,
            ..
        } = face;
        if is_joined {
            reduction::keep_corners(&mut candidates, normal, COPLANAR_DISTANCE * size);
        }
        merge(&mut candidates, MERGE_DISTANCE * size);
        // A round side touches along a line. Points in its middle support nothing, and appear and disappear.
        if curved && reduction::is_line(&candidates, size) {
            reduction::keep_ends(&mut candidates);
        }
        if candidates.len() > max_points(rules) && !is_joined {
            reduction::reduce(&mut candidates, normal);
        }
        let radius = a.rolling_radius().min(b.rolling_radius());
        let rolls = curved && rolling::rolls(&candidates, radius, size);
        let known = manifold.patches.len();
        push(manifold, [a, b], normal, rolls, candidates);
        if let Some(patch) = manifold.patches.get_mut(known) {
            patch.parts = parts;
        }
    }
    apart
}

/// The faces in which the manifolds of parry lie, with the points whose distance is at most `reach`, m.
fn faces(
    [a, b]: [&BodyState; 2],
    [shape_a, shape_b]: [&dyn Shape; 2],
    manifolds: &[ParryManifold],
    reach: f32,
) -> SmallVec<[Face; 4]> {
    let curved = a.is_curved() || b.is_curved();
    // The body that is a surface of adjacent triangles, if any.
    let surface = [shape_a, shape_b]
        .iter()
        .position(|shape| is_surface(*shape));
    let mut faces: SmallVec<[Face; 4]> = SmallVec::new();
    for found in manifolds.iter().filter(|found| !found.points.is_empty()) {
        let pieces = [found.subshape1, found.subshape2];
        if !BodyState::pieces_collide([a, b], pieces) {
            continue;
        }
        let (sub_a, sub_b) = (
            part_of((shape_a, found.subshape1)).0,
            part_of((shape_b, found.subshape2)).0,
        );
        let turned = sub_a.map_or(found.local_n1, |sub| sub.rotation * found.local_n1);
        // If a ball's centre is on an edge of another shape there is no normal. The bodies are separated upwards.
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
            parts: PatchParts::new([a.part_of(found.subshape1), b.part_of(found.subshape2)]),
            is_joined: false,
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
                    // The features change while the body rolls.
                    true => FeatureId::NONE,
                    false => feature(contact).of_parts(found.subshape1, found.subshape2),
                },
            });
        }
        face.candidates
            .retain(|c| c.distance.is_finite() && c.distance <= reach);
        match faces.iter_mut().find(|other| other.continues_in(&face)) {
            Some(other) => other.candidates.extend(face.candidates),
            None => faces.push(face),
        }
    }
    faces
}

/// Normals count as equal if the cosine between them is above this.
pub(super) const PARALLEL_COSINE: f32 = 1.0 - 1e-6;

/// Planes count as equal if their distance is less than this share of the smaller face's size.
pub(super) const COPLANAR_DISTANCE: f32 = 1e-3;

/// The contact of two bodies in one plane. It becomes one patch, even if it extends over several triangles or parts.
pub(super) struct Face {
    pub normal: Vec3,
    /// Size of the smaller face, m.
    pub size: f32,
    /// Plane of the triangle, if one of the bodies is a surface.
    pub plane: Option<Plane>,
    pub candidates: Candidates,
    pub parts: PatchParts,
    /// Whether it has the points of several parts of a compound.
    pub is_joined: bool,
}

impl Face {
    /// Returns true if the triangles of both contacts are in one plane. Equal contact normals are not sufficient: a flat body on a ridge
    /// has the same normal on both sides of it, and four points of both sides together may leave out the ridge.
    fn continues_in(&self, other: &Self) -> bool {
        let (Some(here), Some(there)) = (self.plane, other.plane) else {
            return false;
        };
        self.parts == other.parts
            && self.normal.dot(other.normal) > PARALLEL_COSINE
            && here.normal.dot(there.normal) > PARALLEL_COSINE
            && here.normal.dot(there.on - here.on).abs()
                <= COPLANAR_DISTANCE * self.size.min(other.size)
    }
}

/// The plane of a triangle, in the frame of its surface.
#[derive(Clone, Copy)]
pub(super) struct Plane {
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

/// The features that meet at a point, as numbered by parry or by this crate's own contacts.
fn feature(contact: &TrackedContact<()>) -> FeatureId {
    match contact.fid2 {
        PackedFeatureId::UNKNOWN => FeatureId(contact.fid1.0),
        of_b => FeatureId(contact.fid1.0 ^ of_b.0.rotate_left(16)),
    }
}

/// Drops the points that are nearer than `merge` (m) to a deeper point.
fn merge(candidates: &mut Candidates, merge: f32) {
    sort_deepest_first(candidates);
    let mut kept = Candidates::new();
    for &candidate in candidates.iter() {
        let near = |k: &Candidate| k.position.distance_squared(candidate.position) < merge * merge;
        if !kept.iter().any(near) {
            kept.push(candidate);
        }
    }
    *candidates = kept;
}
