//! The exact comparison of a sensor with a body.

use super::zones::{Content, placed};
use crate::body::{BodyState, Pose, RigidBody};
use crate::children::Zone;
use crate::solver::sort;
use parry3d::math::Pose as ParryPose;
use parry3d::query::intersection_test;
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

    fn overlaps(&self, at: &ParryPose, shape: &dyn Shape) -> bool {
        let here = placed(self.zone, self.pose);
        let zone = &**self.zone.shape.shape();
        // Two surfaces without an inside cannot be compared.
        intersection_test(&here, zone, at, shape).is_ok_and(|found| found.intersecting)
    }

    /// Adds the colliders of a body that are inside.
    pub fn detect(&self, other: &BodyState, slot: u32, pose: Pose, found: &mut Vec<Content>) {
        let Some(shape) = other.shape().filter(|_| self.may_detect(other)) else {
            return;
        };
        let at = pose.to_parry();
        let content = |part| Content {
            spawn_order: other.spawn_order,
            part,
            slot,
            body: other.entity,
            collider: other.collider_entity(part),
        };
        let parts = other.parts.as_ref().filter(|parts| parts.has_pieces());
        let (Some(parts), Some(compound)) = (parts, shape.as_compound()) else {
            if self.overlaps(&at, shape) {
                found.push(content(0));
            }
            return;
        };
        let first = found.len();
        for (piece, (local, shape)) in (0..).zip(compound.shapes()) {
            let part = parts.owner(piece);
            if found[first..].iter().all(|known| known.part != part)
                && self.zone.layers().collides_with(parts.layers(piece))
                && self.overlaps(&(at * *local), &**shape)
            {
                found.push(content(part));
            }
        }
        sort::by_key(&mut found[first..], Content::rank);
    }
}
