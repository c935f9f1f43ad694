//! The bodies that have left their boxes, and their new ones.

use super::flight::Flight;
use super::{BOX_MARGIN, Broadphase, fat_box, room_around, shape_box, way_beside};
use crate::body::collider::Collider;
use crate::body::{BodyState, BodyTable};
use crate::settings::StabilizationSettings;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};

/// What the motion of bodies in this step depends on.
pub(super) struct Motion<'a> {
    pub settings: &'a StabilizationSettings,
    pub gravity: Vec3,
    pub dt: f32,
}

impl Motion<'_> {
    /// How far around its shape a body may touch something within the step, m, but for its velocity: the collision envelope, and its
    /// motion by rotation and forces.
    fn beside(&self, body: &BodyState) -> f32 {
        self.settings.outer_distance().max(0.0) + way_beside(body, self.gravity, self.dt)
    }

    /// How far around its shape a body may touch something within the step, m.
    fn around(&self, body: &BodyState) -> f32 {
        super::reach(body, self.settings, self.gravity, self.dt)
    }
}

impl Broadphase {
    /// Finds the bodies that have left their boxes or have other shapes, and gives them new boxes.
    pub(super) fn find_moved(&mut self, table: &BodyTable, motion: &Motion) -> Vec<u32> {
        let mut moved = Vec::new();
        for (slot, body) in table.active() {
            let resting =
                (body.asleep || !body.is_dynamic()) && body.velocity == Default::default();
            let flies = self.flights.get(slot).is_some();
            if resting && !body.moved && !body.renewed && !flies {
                continue;
            }
            let Some(collider) = &body.collider else {
                // Its collider may have been removed in this step.
                if body.renewed {
                    self.unbounded.retain(|u| *u != slot);
                    self.drop_box(slot);
                    self.found.disturbed.push(slot);
                }
                continue;
            };
            if !body.radius.is_finite() {
                if !self.unbounded.contains(&slot) {
                    self.unbounded.push(slot);
                }
                // It may have been a shape with a box before.
                self.drop_box(slot);
                if body.moved || body.renewed {
                    moved.push(slot);
                }
                continue;
            }
            if body.renewed {
                self.unbounded.retain(|u| *u != slot);
            }
            let is_new = match flies {
                true => self.leaves_flight(slot, body, collider, motion),
                false => self.leaves_box(slot, body, collider, motion),
            };
            if is_new {
                moved.push(slot);
            }
        }
        self.end_flights_of_inactive(table, motion, &mut moved);
        moved
    }

    /// A body that flew and was put to sleep by the user does not move on.
    fn end_flights_of_inactive(
        &mut self,
        table: &BodyTable,
        motion: &Motion,
        moved: &mut Vec<u32>,
    ) {
        let first = moved.len();
        moved.extend(self.flights.slots().filter(|&slot| table.is_inactive(slot)));
        for &slot in &moved[first..] {
            let body = table.get(slot);
            if let Some((body, collider)) =
                body.and_then(|body| Some((body, body.collider.as_ref()?)))
            {
                let shape = shape_box(body, collider);
                self.renew_box(slot, body, &shape, motion);
            }
        }
    }

    /// Takes the box of a body from the tree.
    fn drop_box(&mut self, slot: u32) {
        self.flights.remove(slot);
        if self.fat[slot as usize].take().is_some() {
            self.tree.remove(slot);
        }
    }

    /// Whether a fast body has left its moving box, or its box has ended; then it gets a new one.
    fn leaves_flight(
        &mut self,
        slot: u32,
        body: &BodyState,
        collider: &Collider,
        motion: &Motion,
    ) -> bool {
        let shape = shape_box(body, collider);
        let flight = self.flights.get(slot);
        let holds = |flight: &Flight| flight.holds(body, &shape, motion.beside(body), motion.dt);
        let leaves = body.renewed || !flight.is_some_and(holds);
        if leaves {
            self.renew_box(slot, body, &shape, motion);
        }
        leaves
    }

    /// Whether a body may leave its box in this step; then it gets a new one.
    fn leaves_box(
        &mut self,
        slot: u32,
        body: &BodyState,
        collider: &Collider,
        motion: &Motion,
    ) -> bool {
        let reach = motion.around(body);
        let room = &mut self.room[slot as usize];
        if !body.moved && !body.renewed && reach < *room {
            return false;
        }
        let shape = shape_box(body, collider);
        let tight = shape.loosened(reach);
        if let Some(fat) = self.fat[slot as usize]
            && !body.renewed
            && fat.contains(&tight)
        {
            *room = room_around(&shape, &fat);
            return false;
        }
        self.renew_box(slot, body, &shape, motion);
        true
    }

    /// Gives a body a new box, which moves along with it if it is fast.
    fn renew_box(&mut self, slot: u32, body: &BodyState, shape: &Aabb, motion: &Motion) {
        let way = body.velocity.linear * motion.dt;
        let is_fast = way.length() > BOX_MARGIN;
        let around = if is_fast {
            let core = shape.loosened(motion.beside(body) + BOX_MARGIN);
            let flight = Flight::new(slot, body, &core, motion.dt);
            self.flights.set(flight);
            flight.path()
        } else {
            self.flights.remove(slot);
            fat_box(&shape.loosened(motion.around(body)), way)
        };
        self.fat[slot as usize] = Some(around);
        self.room[slot as usize] = match is_fast {
            true => 0.0,
            false => room_around(shape, &around),
        };
    }
}
