//! Ghost contacts: what slides or rolls over surfaces that lie flush side by side must not hit the edges between them.
//!
//! The contact of a ball with a floor brick ahead of it is that brick's nearest edge, and its normal leans against the motion. Alone the
//! brick would be an obstacle there. But the brick on which the ball rolls ends at the same edge, and its top lies in the same plane: the
//! two together have no edge. At large steps such contacts lie ahead of the body, and stop it before it is there.
//!
//! A contact at point p with normal n is a ghost if another piece covers it. The piece has a face through p; the obstacle does not rise
//! above that face; and the piece extends beyond p along n, so that n leads through the piece. Pieces are bodies, and the parts of
//! compounds, meshes and height fields. A step, a gap, the edge of a table and a convex ridge are no ghosts: there is no such face, or the
//! piece ends at p along n.
//!
//! Other engines remove such contacts within a mesh: see *ghost vertices* in Box2D and *enhanced internal edge removal* in Jolt.

use crate::body::{BodyState, BodyTable};
use crate::graph::ConstraintGraph;
use crate::pair::{ContactPoint, Manifold};
use glam::{Vec3, Vec3Swizzles};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;

use parry3d::shape::{ConvexPolyhedron, Shape, Triangle, TypedShape};
use smallvec::SmallVec;

/// Largest height of a step between flush surfaces, as a share of the smaller body's size.
const FLUSH_HEIGHT: f32 = 2e-3;

/// The same, as a share of the distance beyond which a contact is outside of the envelope.
const FLUSH_OF_ENVELOPE: f32 = 0.1;

/// A normal belongs to a face if it leans from the face's normal by less than this angle, as a sine.
const FACE_LEAN: f32 = 1e-4;

/// A normal is along a face if the cosine between it and the face's normal is below this.
const ALONG_FACE_COSINE: f32 = 0.1;

/// Bodies with flat faces that tilt against each other touch with the normal of a face of one of them. It is no ghost if the cosine between
/// it and the covering face is larger than this (3°).
const TILTED_COSINE: f32 = 0.9986;

/// A body with more edges than this is ground, which does not slide over the bodies on it.
const MAX_EDGES: usize = 512;

/// The neighbours of a body are asked instead of those of another one if they are so many times fewer.
const FEWER_EDGES: usize = 4;

/// The bodies that may cover an edge.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub table: &'a BodyTable,
    pub graph: &'a ConstraintGraph,
}

impl Surroundings<'_> {
    /// Removes the ghost contacts of a pair. `outer` is the distance beyond which a contact is outside of the envelope, m, and
    /// `dt` the length of the step, s.
    pub fn remove_ghosts(
        &self,
        slots: [u32; 2],
        bodies: [&BodyState; 2],
        (outer, dt): (f32, f32),
        manifold: &mut Manifold,
    ) {
        let is_curved = bodies.iter().any(|body| body.is_curved());
        let are_convex = bodies
            .iter()
            .all(|body| body.shape().is_some_and(Shape::is_convex));
        // Seams between flat faces of convex bodies were looked at when the contact was detected: see `polyhedra/seams.rs`.
        if are_convex && !is_curved {
            return;
        }
        let sides = [0, 1].map(|obstacle| Side::new(bodies, slots, obstacle, (outer, dt)));
        // Bodies that hardly move are not stopped.
        let [a, b] = bodies.map(|body| body.velocity.linear);
        let is_slow = (a - b).length() * dt < sides[0].flush;
        if is_slow || sides.iter().all(|side| side.is_smooth()) {
            return;
        }
        let Manifold {
            patches, points, ..
        } = manifold;
        let before = points.len();
        let mut kept = 0;
        let around = Around::of(points, bodies[0].center);
        // Found when they are first asked for: most contacts are of faces.
        let mut beside = [None, None];
        for patch in &mut *patches {
            let range = patch.range_in(before);
            // A ball may be a part of a compound.
            let is_round = patch.curved || is_curved || patch.count == 1 && !are_convex;
            let max_cosine = if is_round {
                f32::INFINITY
            } else {
                TILTED_COSINE
            };
            patch.first = kept as u32;
            for i in range {
                let point = points[i];
                let middle = bodies[0].center + point.arm;
                let is_ghost = sides.iter().zip(&mut beside).any(|(side, beside)| {
                    let normal = side.sign * patch.normal;
                    side.has_edge_along(normal) && {
                        let beside =
                            beside.get_or_insert_with(|| self.bodies_beside(side, &around));
                        let at = middle - 0.5 * point.distance * normal;
                        is_ghost(side, beside.as_deref(), at, (normal, max_cosine))
                    }
                });
                if !is_ghost {
                    points[kept] = point;
                    kept += 1;
                }
            }
            patch.count = kept as u32 - patch.first;
        }
        points.truncate(kept);
        patches.retain(|patch| patch.count > 0);
        for patch in patches {
            let of_it = &points[patch.range_in(kept)];
            patch.center = of_it.iter().map(|point| point.arm).sum::<Vec3>() / of_it.len() as f32;
        }
    }

    /// The bodies beside the obstacle that may cover one of these points. `None` if the other body has too many neighbours.
    fn bodies_beside(&self, side: &Side, around: &Around) -> Option<SmallVec<[&BodyState; 8]>> {
        if self.graph.edges_of(side.other_slot).len() > MAX_EDGES {
            return None;
        }
        let rounding = 4.0 * f32::EPSILON * (around.middle.abs().max_element() + around.radius);
        let slack = around.radius + 2.0 * (side.flush + rounding);
        let is_near = |slot: u32| {
            let body = self.table.get(slot)?;
            let is_near = (body.center - around.middle).length() <= body.radius + slack;
            (is_near && body.entity != side.obstacle.entity).then_some(body)
        };
        let ends = |of: u32| self.graph.edges_at(of).map(move |(link, _)| link.other(of));
        let edges = self.graph.edges_of(side.other_slot).len();
        // Hundreds may be in a drum, and few beside one of them. A body that moves has an edge with each that it may touch.
        if side.obstacle.is_dynamic() && self.graph.edges_of(side.slot).len() < edges / FEWER_EDGES
        {
            let meets = |slot: u32| ends(slot).any(|other| other == side.other_slot);
            let near = ends(side.slot).filter_map(|slot| is_near(slot).filter(|_| meets(slot)));
            return Some(near.collect());
        }
        Some(ends(side.other_slot).filter_map(is_near).collect())
    }
}

/// A sphere around the points of a pair on both surfaces, world, m.
struct Around {
    middle: Vec3,
    radius: f32,
}

impl Around {
    fn of(points: &[ContactPoint], center: Vec3) -> Self {
        let arms = points.iter().map(|point| point.arm);
        let mins = arms.clone().fold(Vec3::INFINITY, Vec3::min);
        let maxs = arms.fold(Vec3::NEG_INFINITY, Vec3::max);
        let depths = points.iter().map(|point| 0.5 * point.distance.abs());
        Self {
            middle: center + 0.5 * (mins + maxs),
            radius: 0.5 * (maxs - mins).length() + depths.fold(0.0, f32::max),
        }
    }
}

/// Returns true if a contact at a point of the obstacle's surface is covered by another piece: of the obstacle, or of a body `beside` it.
/// A normal is that of a face if the cosine between the two is larger than `max_cosine`.
fn is_ghost(
    side: &Side,
    beside: Option<&[&BodyState]>,
    at: Vec3,
    (normal, max_cosine): (Vec3, f32),
) -> bool {
    let Some(beside) = beside else { return false };
    let flush = side.flush + 4.0 * f32::EPSILON * at.abs().max_element();
    let site = Site {
        at,
        normal,
        towards: side.other.center - at,
        flush,
    };
    let others = beside.iter().copied();
    let near: SmallVec<[&BodyState; 4]> = others.filter(|body| site.may_lie_on(body)).collect();
    // For most contacts the answer is found here.
    if near.is_empty() && side.obstacle.shape().is_some_and(Shape::is_convex) {
        return false;
    }
    // The pieces of the obstacle that have this contact, and all others nearby.
    let mut touched: SmallVec<[Piece; 4]> = SmallVec::new();
    let mut covers: SmallVec<[Piece; 8]> = SmallVec::new();
    site.pieces_of(side.obstacle, &mut |piece| match piece.extends(&site) {
        true => covers.push(piece),
        false => touched.push(piece),
    });
    // A flat box that is beside a triangle may have points in the triangle's middle, with a normal along its plane.
    let is_inside = touched.is_empty();
    if is_inside {
        site.pieces_of(side.obstacle, &mut |piece| touched.push(piece));
        if !touched.iter().all(Piece::is_triangle) {
            return false;
        }
    }
    for body in near {
        if !body.asks_for_hooks() {
            site.pieces_of(body, &mut |piece| {
                if piece.extends(&site) {
                    covers.push(piece);
                }
            });
        }
    }
    covers.iter().any(|cover| {
        let mut covered = false;
        cover.faces(&site, |face| {
            let rises = |piece: &Piece| piece.height_over(at, face) > flush;
            let limit = if is_inside {
                ALONG_FACE_COSINE
            } else {
                max_cosine
            };
            // A body that is struck gives way, and then the edge beside it is an obstacle.
            let strikes = cover.velocity.is_some_and(|velocity| {
                (velocity - side.other.velocity.linear).dot(face) * side.dt > flush
            });
            covered |= face.dot(normal) < limit && !strikes && !touched.iter().any(rises);
        });
        covered
    })
}

/// A pair, seen from one of its two bodies.
struct Side<'a> {
    /// The body whose edges may be covered.
    obstacle: &'a BodyState,
    other: &'a BodyState,
    /// Length of the step, s.
    dt: f32,
    /// The slots of the two bodies.
    slot: u32,
    other_slot: u32,
    /// The normal of the pair times this points away from the obstacle.
    sign: f32,
    /// Largest height of a step between flush surfaces, m.
    flush: f32,
}

impl<'a> Side<'a> {
    fn new(
        bodies: [&'a BodyState; 2],
        slots: [u32; 2],
        obstacle: usize,
        (outer, dt): (f32, f32),
    ) -> Self {
        let size = bodies[0].size.min(bodies[1].size);
        Self {
            obstacle: bodies[obstacle],
            other: bodies[1 - obstacle],
            dt,
            slot: slots[obstacle],
            other_slot: slots[1 - obstacle],
            sign: [-1.0, 1.0][obstacle],
            flush: (FLUSH_HEIGHT * size).min(FLUSH_OF_ENVELOPE * outer.max(0.0)),
        }
    }

    /// Returns true if the obstacle has no edges.
    fn is_smooth(&self) -> bool {
        let shape = self.obstacle.shape().map(Shape::as_typed_shape);
        matches!(
            shape,
            None | Some(TypedShape::HalfSpace(_) | TypedShape::Ball(_) | TypedShape::Capsule(_))
        )
    }

    /// Returns false if the normal is certainly not that of an edge. This is the quick answer for most contacts of boxes. Faces of convex
    /// bodies that another body hits sideways are left out when the contact is detected: see `polyhedra/seams.rs`.
    fn has_edge_along(&self, normal: Vec3) -> bool {
        let local = || self.obstacle.pose.rotation.inverse() * normal;
        if !self.other.shape().is_some_and(Shape::is_convex) {
            return !self.is_smooth();
        }
        // A half-space touches edges and corners with its own normal.
        if self.other.radius == f32::INFINITY {
            return false;
        }
        match self.obstacle.shape().map(Shape::as_typed_shape) {
            Some(TypedShape::Cuboid(_)) => {
                let mut across = local();
                let along = across.abs().max_position();
                across[along] = 0.0;
                across.length_squared() > FACE_LEAN * FACE_LEAN
            }
            Some(TypedShape::Cylinder(_)) => local().xz().length_squared() > FACE_LEAN * FACE_LEAN,
            _ => !self.is_smooth(),
        }
    }
}

/// A contact that may be a ghost.
struct Site {
    /// The point of the obstacle's surface, world, m.
    at: Vec3,
    /// The normal away from the obstacle, world.
    normal: Vec3,
    /// The direction to the centre of the other body, world, m.
    towards: Vec3,
    /// Tolerance, m.
    flush: f32,
}

impl Site {
    /// Returns false if the point is certainly not at the surface of a body.
    fn may_lie_on(&self, body: &BodyState) -> bool {
        if (body.center - self.at).length() > body.radius + self.flush {
            return false;
        }
        match body.shape().map(Shape::as_typed_shape) {
            Some(TypedShape::Cuboid(cuboid)) => {
                let local = body.pose.inverse_transform_point(self.at);
                let beyond = local.abs() - cuboid.half_extents;
                // Inside of it there is no face either.
                (-self.flush..=self.flush).contains(&beyond.max_element())
            }
            shape => shape.is_some(),
        }
    }

    /// Visits the convex pieces of a body at the point.
    fn pieces_of<'a>(&self, body: &'a BodyState, visit: &mut impl FnMut(Piece<'a>)) {
        let Some(shape) = body.shape() else { return };
        let pose = body.pose.to_parry();
        let at = pose.inverse_transform_point(self.at);
        let near = Aabb::new(at - self.flush, at + self.flush);
        match shape.as_typed_shape() {
            TypedShape::Compound(compound) => {
                for part in compound.bvh().intersect_aabb(&near) {
                    let (place, part) = &compound.shapes()[part as usize];
                    self.piece(body, Form::Convex(&**part), pose * *place, visit);
                }
            }
            TypedShape::TriMesh(mesh) => {
                for triangle in mesh.bvh().intersect_aabb(&near) {
                    self.piece(body, Form::Triangle(mesh.triangle(triangle)), pose, visit);
                }
            }
            TypedShape::HeightField(field) => {
                field.map_elements_in_local_aabb(&near, &mut |_, triangle| {
                    self.piece(body, Form::Triangle(*triangle), pose, visit);
                });
            }
            _ => self.piece(body, Form::Convex(shape), pose, visit),
        }
    }

    /// Visits a piece if it is at the point.
    fn piece<'a>(
        &self,
        body: &BodyState,
        form: Form<'a>,
        pose: Pose,
        visit: &mut impl FnMut(Piece<'a>),
    ) {
        let velocity = body.is_dynamic().then_some(body.velocity.linear);
        let piece = Piece {
            form,
            pose,
            velocity,
        };
        let at = pose.inverse_transform_point(self.at);
        let is_here = match piece.shape().as_typed_shape() {
            // In front of an edge its planes are nearer than the hull is. Within the tolerance that makes no difference.
            TypedShape::ConvexPolyhedron(hull) => {
                planes(hull).all(|(normal, on)| normal.dot(at - on) <= self.flush)
            }
            _ => piece.shape().distance_to_local_point(at, true) <= self.flush,
        };
        if is_here {
            visit(piece);
        }
    }
}

/// The outward normal of each face of a hull, and a point of the face.
fn planes(hull: &ConvexPolyhedron) -> impl Iterator<Item = (Vec3, Vec3)> {
    hull.faces().iter().map(|face| {
        let corner = hull.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
        (face.normal, hull.points()[corner as usize])
    })
}

enum Form<'a> {
    Convex(&'a dyn Shape),
    Triangle(Triangle),
}

/// A convex piece of a body: its shape, one part of it, or a triangle of its surface.
struct Piece<'a> {
    form: Form<'a>,
    pose: Pose,
    /// Velocity of its body, m/s, if contacts can move it.
    velocity: Option<Vec3>,
}

impl Piece<'_> {
    fn is_triangle(&self) -> bool {
        matches!(self.form, Form::Triangle(_))
    }

    fn shape(&self) -> &dyn Shape {
        match &self.form {
            Form::Convex(shape) => *shape,
            Form::Triangle(triangle) => triangle,
        }
    }

    /// How far the piece extends beyond a point along a unit vector, m.
    fn height_over(&self, at: Vec3, along: Vec3) -> f32 {
        let (local, way) = self.local(at, along);
        if let TypedShape::HalfSpace(half_space) = self.shape().as_typed_shape() {
            return match (way - half_space.normal).length() < FACE_LEAN {
                true => -local.dot(way),
                false => f32::INFINITY,
            };
        }
        match self.shape().as_support_map() {
            Some(map) => (map.local_support_point(way) - local).dot(way),
            None => f32::INFINITY,
        }
    }

    /// Returns true if the normal leads through the piece.
    fn extends(&self, site: &Site) -> bool {
        self.height_over(site.at, site.normal) > site.flush
    }

    /// Visits the outward normals, in the world, of the faces whose plane contains the point and that look towards the other body.
    fn faces(&self, site: &Site, mut visit: impl FnMut(Vec3)) {
        let (at, towards) = self.local(site.at, site.towards);
        let mut face = |normal: Vec3, on: Vec3| {
            if normal.dot(at - on).abs() <= site.flush && normal.dot(towards) > 0.0 {
                visit(self.pose.rotation * normal);
            }
        };
        match self.shape().as_typed_shape() {
            TypedShape::Cuboid(cuboid) => {
                for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                    let out = axis * at.dot(axis).signum();
                    face(out, out * cuboid.half_extents);
                }
            }
            TypedShape::ConvexPolyhedron(hull) => {
                for (normal, on) in planes(hull) {
                    face(normal, on);
                }
            }
            TypedShape::Cylinder(cylinder) => {
                let end = Vec3::Y * at.y.signum();
                face(end, end * cylinder.half_height);
            }
            TypedShape::Cone(cone) => face(Vec3::NEG_Y, Vec3::NEG_Y * cone.half_height),
            TypedShape::HalfSpace(half_space) => face(half_space.normal, Vec3::ZERO),
            TypedShape::Triangle(triangle) => {
                if let Some(normal) = triangle.normal() {
                    face(normal, triangle.a);
                    face(-normal, triangle.a);
                }
            }
            _ => {}
        }
    }

    /// A point and a direction of the world in the frame of the piece.
    fn local(&self, at: Vec3, along: Vec3) -> (Vec3, Vec3) {
        let at = self.pose.inverse_transform_point(at);
        (at, self.pose.rotation.inverse() * along)
    }
}
