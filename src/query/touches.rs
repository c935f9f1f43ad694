//! Shapes that touch something where a cast begins.
//!
//! Bodies at rest overlap those below them by some micrometres, and rounding of positions adds to that. A cast from rest must not be
//! stopped by this: not by the body below when it goes away from it or along it, and not by the neighbours of that body, whose sides are as
//! much too high. So a cast asks first what its shape [touches](Touches) at the start. If there is something, it hits only what it comes
//! deeper into than shapes that touch: what it would overlap as well if it was lifted off what it touches.

use super::{QueryFilter, SpatialQuery};
use crate::body::{Pose, collider::Collider};
use glam::{Quat, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as ParryPose;
use parry3d::query::{Contact, DefaultQueryDispatcher, QueryDispatcher, Unsupported};
use parry3d::shape::Shape;
use smallvec::SmallVec;

/// Overlaps and gaps up to this count as touching, m. Bodies at rest overlap by up to 0.02 mm.
const TOUCHING_DISTANCE: f32 = 5e-5;

/// The directions off what a shape touches at the start of a cast.
#[derive(Clone, Debug)]
pub(super) struct Touches {
    /// Unit vectors.
    pub normals: SmallVec<[Vec3; 4]>,
    /// Overlaps and gaps up to this count as touching, m.
    pub reach: f32,
}

impl Touches {
    /// None yet, for a shape about a place of the world. Single precision knows positions no better than to some 10⁻⁷ of the distance from
    /// the origin.
    fn at(place: Vec3) -> Self {
        Self {
            normals: SmallVec::new(),
            reach: TOUCHING_DISTANCE + 2.0 * f32::EPSILON * place.abs().max_element(),
        }
    }

    fn add(&mut self, normal: Vec3) {
        /// Cosine of the angle between directions that are the same.
        const SAME_DIRECTION_COSINE: f32 = 0.99;
        if self
            .normals
            .iter()
            .all(|known| known.dot(normal) < SAME_DIRECTION_COSINE)
        {
            self.normals.push(normal);
        }
    }

    /// Turns the directions into another frame.
    pub fn turned(&self, rotation: Quat) -> Self {
        let mut turned = self.clone();
        for normal in &mut turned.normals {
            *normal = rotation * *normal;
        }
        turned
    }

    /// The directions in which the other shapes are lifted off this one.
    pub fn reversed(mut self) -> Self {
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        self
    }
}

impl SpatialQuery<'_, '_> {
    /// The contacts of a shape at a pose.
    pub(super) fn touches(&self, collider: &Collider, at: &Pose, filter: &QueryFilter) -> Touches {
        let mut touches = Touches::at(at.position);
        let reach = touches.reach;
        let shape = &**collider.shape();
        let place = at.to_parry();
        let mut near = (self.view()).near(&shape.compute_aabb(&place).loosened(reach));
        self.view().each_outside(&mut |number| near.push(number));
        for number in near {
            if let Some(target) = self.target(number, filter) {
                target.any_piece(filter, &mut |piece| {
                    let from = piece.at.inv_mul(&place);
                    each_touch(piece.shape, shape, &from, reach, &mut |normal| {
                        touches.add(piece.at.rotation * normal);
                    });
                    false
                });
            }
        }
        touches
    }
}

/// Calls a function with the directions off the parts of a shape that the parts of another one touch, which is at a pose in the frame of
/// the first.
fn each_touch(
    shape: &dyn Shape,
    other: &dyn Shape,
    at: &ParryPose,
    reach: f32,
    found: &mut dyn FnMut(Vec3),
) {
    let there = other.compute_aabb(at).loosened(reach);
    each_part(shape, &there, &mut |part, of_part| {
        let from = of_part.inv_mul(at);
        let here = part.compute_aabb(&from.inverse()).loosened(reach);
        each_part(other, &here, &mut |own, of_own| {
            if let Some(start) = start(part, own, &(from * *of_own), reach)
                && start.dist >= -reach
            {
                found(of_part.rotation * start.normal1);
            }
        });
    });
}

/// The contact of two convex shapes that touch or overlap, the second one at a pose in the frame of the first.
pub(super) fn start(
    shape: &dyn Shape,
    other: &dyn Shape,
    at: &ParryPose,
    reach: f32,
) -> Option<Contact> {
    /// Parry knows gaps of curved shapes to some tenths of a millimetre only, and overlaps of all shapes to some micrometres.
    const CURVED_FACTOR: f32 = 10.0;
    let mut contact = contact(shape, other, at, CURVED_FACTOR * reach).ok()??;
    let push = contact.dist + 2.0 * reach;
    if push > 0.0 {
        let mut pushed = *at;
        pushed.translation -= contact.normal1 * push;
        if let Ok(Some(overlap)) = self::contact(shape, other, &pushed, 0.0) {
            contact = overlap;
            contact.dist += push;
        }
    }
    (contact.dist <= reach).then_some(contact)
}

/// The deepest contact of two shapes, the second one at a pose in the frame of the first, if they are no farther apart than `reach`, m.
pub(super) fn contact(
    shape: &dyn Shape,
    other: &dyn Shape,
    at: &ParryPose,
    reach: f32,
) -> Result<Option<Contact>, Unsupported> {
    // Parry places a half-space wrongly if it comes second.
    if other.as_halfspace().is_some() {
        let contact = contact(other, shape, &at.inverse(), reach)?;
        return Ok(contact.map(Contact::flipped));
    }
    // So it does within if it is compared with the parts of a shape.
    if shape.as_halfspace().is_some() && other.as_support_map().is_none() {
        let (mut deepest, mut failed) = (None::<Contact>, false);
        each_part(other, &other.compute_local_aabb(), &mut |part, of_part| {
            let found = DefaultQueryDispatcher.contact(&(at * *of_part), shape, part, reach);
            failed |= found.is_err();
            if let Ok(Some(mut found)) = found
                && deepest.is_none_or(|deepest| found.dist < deepest.dist)
            {
                found.transform_by_mut(&ParryPose::IDENTITY, of_part);
                deepest = Some(found);
            }
        });
        return if failed {
            Err(Unsupported)
        } else {
            Ok(deepest)
        };
    }
    if shape.as_support_map().is_none() || other.as_support_map().is_none() {
        return DefaultQueryDispatcher.contact(at, shape, other, reach);
    }
    /// Inner shapes that are closer meet, m.
    const MEETING_DISTANCE: f32 = 1e-4;
    let (mut found, mut meet) = (Ok(None), false);
    with_core(shape, &mut |inner, border| {
        with_core(other, &mut |other_inner, other_border| {
            let borders = border + other_border;
            found = DefaultQueryDispatcher.contact(at, inner, other_inner, reach + borders);
            if let Ok(Some(contact)) = &mut found
                && borders > 0.0
            {
                meet = contact.dist < MEETING_DISTANCE;
                contact.dist -= borders;
                contact.point1 += contact.normal1 * border;
                contact.point2 += contact.normal2 * other_border;
            }
        });
    });
    // The direction between inner shapes that meet is not known.
    match meet {
        true => DefaultQueryDispatcher.contact(at, shape, other, reach),
        false => found,
    }
}

/// Calls a function with the shape within a shape that is rounded, and by how much it is enlarged, m. Parry knows the distance of capsules
/// and rounded shapes less well than that of what is within.
fn with_core(shape: &dyn Shape, found: &mut dyn FnMut(&dyn Shape, f32)) {
    if let Some(capsule) = shape.as_capsule() {
        found(&capsule.segment, capsule.radius);
    } else if let Some(round) = shape.as_round_cuboid() {
        found(&round.inner_shape, round.border_radius);
    } else if let Some(round) = shape.as_round_triangle() {
        found(&round.inner_shape, round.border_radius);
    } else if let Some(round) = shape.as_round_convex_polyhedron() {
        found(&round.inner_shape, round.border_radius);
    } else if let Some(round) = shape.as_round_cylinder() {
        found(&round.inner_shape, round.border_radius);
    } else if let Some(round) = shape.as_round_cone() {
        found(&round.inner_shape, round.border_radius);
    } else {
        found(shape, 0.0);
    }
}

/// Calls a function with the convex parts of a shape near a box, and their poses in the frame of the shape, in which the box is.
fn each_part(shape: &dyn Shape, near: &Aabb, found: &mut dyn FnMut(&dyn Shape, &ParryPose)) {
    if let Some(field) = shape.as_heightfield() {
        field.map_elements_in_local_aabb(near, &mut |_, triangle| {
            found(triangle, &ParryPose::IDENTITY);
        });
    } else if let Some(parts) = shape.as_composite_shape() {
        for id in parts.bvh().intersect_aabb(near) {
            parts.map_part_at(id, &mut |at, part, _| {
                found(part, at.unwrap_or(&ParryPose::IDENTITY));
            });
        }
    } else {
        found(shape, &ParryPose::IDENTITY);
    }
}
