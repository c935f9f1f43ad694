//! The exact comparison of a sensor with a body.

use super::zones::{Content, placed};
use crate::body::{BodyState, Pose, RigidBody, parts::Zone};
use crate::solver::sort;
use glam::Vec3;
use parry3d::math::Pose as ParryPose;
use parry3d::query::{ShapeCastOptions, cast_shapes, intersection_test};
use parry3d::shape::Shape;

/// A sensor, its body, and the pose of that body.
#[derive(Clone, Copy)]
pub(super) struct Detector<'a> {
    pub body: &'a BodyState,
    pub zone: &'a Zone,
    pub pose: Pose,
}

impl Detector<'_> {
    /// Whether the rules let it detect a body.
    fn may_detect(&self, other: &BodyState) -> bool {
        let excepts = |one: &BodyState, named| one.properties.exceptions.0.contains(&named);
        let both_static = self.body.kind == RigidBody::Static && other.kind == RigidBody::Static;
        self.body.entity != other.entity
            && !both_static
            && !excepts(self.body, other.entity)
            && !excepts(other, self.body.entity)
            && !excepts(other, self.zone.entity)
            && self.zone.layers().collides_with(other.properties.layers)
    }

    /// Whether a shape of another body overlaps the zone at the end of the step, at `to`, or has flown through it on the way `from` its
    /// pose at the start.
    fn overlaps(&self, from: &ParryPose, to: &ParryPose, shape: &dyn Shape) -> bool {
        let here = placed(self.zone, self.pose);
        let zone = &**self.zone.shape.shape();
        // Two surfaces without an inside cannot be compared.
        intersection_test(&here, zone, to, shape).is_ok_and(|found| found.intersecting)
            || self.flown_through(&here, from, to, shape)
    }

    /// Whether a shape has come into the zone and left it within the step. Shapes that move by less than their thickness cannot.
    fn flown_through(
        &self,
        here: &ParryPose,
        from: &ParryPose,
        to: &ParryPose,
        shape: &dyn Shape,
    ) -> bool {
        let was = placed(self.zone, self.body.pose).inv_mul(from);
        let at = here.inv_mul(to);
        let way = at.translation - was.translation;
        let thickness = 2.0 * shape.compute_local_aabb().half_extents().min_element();
        if way.length() <= thickness {
            return false;
        }
        let zone = &**self.zone.shape.shape();
        let still = ParryPose::IDENTITY;
        // A shape that overlaps the zone at the start is leaving it.
        if intersection_test(&still, zone, &was, shape).is_ok_and(|found| found.intersecting) {
            return false;
        }
        let start = ParryPose::from_parts(was.translation, at.rotation);
        let options = ShapeCastOptions {
            max_time_of_impact: 1.0,
            ..Default::default()
        };
        cast_shapes(&still, Vec3::ZERO, zone, &start, way, shape, options)
            .is_ok_and(|hit| hit.is_some())
    }

    /// Adds the colliders of a body that are inside.
    pub fn detect(&self, other: &BodyState, slot: u32, pose: Pose, found: &mut Vec<Content>) {
        let Some(shape) = other.shape().filter(|_| self.may_detect(other)) else {
            return;
        };
        let (from, to) = (other.pose.to_parry(), pose.to_parry());
        let content = |part| Content {
            spawn_order: other.spawn_order,
            part,
            slot,
            body: other.entity,
            collider: other.collider_entity(part),
        };
        let parts = other.parts.as_ref().filter(|parts| parts.has_pieces());
        let (Some(parts), Some(compound)) = (parts, shape.as_compound()) else {
            if self.overlaps(&from, &to, shape) {
                found.push(content(0));
            }
            return;
        };
        let first = found.len();
        for (piece, (local, shape)) in (0..).zip(compound.shapes()) {
            let part = parts.owner(piece);
            if found[first..].iter().all(|known| known.part != part)
                && self.zone.layers().collides_with(parts.layers(piece))
                && self.overlaps(&(from * *local), &(to * *local), &**shape)
            {
                found.push(content(part));
            }
        }
        sort::by_key(&mut found[first..], Content::rank);
    }
}
