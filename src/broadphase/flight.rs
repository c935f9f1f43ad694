//! Boxes that move with fast bodies. The box of a fast body in the tree contains its path of the next steps, so it overlaps those of
//! many bodies that it does not come near to: those in front of it in a clump that flies, and those that fall beside it. A *flight* is a
//! box that moves along with the body, with the velocity that the body had when the box was made. Two bodies can touch only if their
//! moving boxes meet, which depends on their relative motion alone. A body that leaves its moving box, since it was hit or turns, gets
//! a new one.

use crate::body::BodyState;
use crate::stored::clone_fields;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};

/// Number of steps that a flight lasts.
const FLIGHT_STEPS: u32 = 3;

/// A pair is fast if it moves at least this share of the smaller body's size in a step. The narrowphase has no contacts of fast pairs that
/// pass each other. Slower bodies may be hit and pushed aside before the end of the step, so they have contacts with all that is as near
/// as they move in a step.
pub(crate) const FAST_MOTION: f32 = 0.25;

/// The moving box of a body.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Flight {
    slot: u32,
    /// Corners of the box at the start of the step, m.
    mins: Vec3,
    maxs: Vec3,
    /// Of the box, m/s.
    velocity: Vec3,
    /// How far beside the moving box the body may touch something, m.
    aside: f32,
    /// Number of steps that it still lasts.
    steps: u32,
    /// Largest length of these steps, s.
    dt: f32,
}

impl Flight {
    /// The flight of a body from a box that contains all that it may touch in this step, but for its velocity, and that is a bit larger.
    pub fn new(slot: u32, body: &BodyState, around: &Aabb, dt: f32) -> Self {
        let velocity = body.velocity.linear;
        Self {
            slot,
            mins: around.mins,
            maxs: around.maxs,
            velocity,
            aside: (velocity.length() * dt).min(FAST_MOTION * body.size),
            steps: FLIGHT_STEPS,
            dt,
        }
    }

    /// The box that a body has been given, which rests.
    fn resting(around: &Aabb) -> Self {
        Self {
            slot: u32::MAX,
            mins: around.mins,
            maxs: around.maxs,
            velocity: Vec3::ZERO,
            aside: 0.0,
            steps: 1,
            dt: f32::INFINITY,
        }
    }

    /// How long it still lasts, s.
    fn time(&self) -> f32 {
        self.steps as f32 * self.dt
    }

    /// A box that contains the moving box as long as it lasts, and what is beside it.
    pub fn path(&self) -> Aabb {
        let way = self.velocity * self.time();
        let mins = self.mins + way.min(Vec3::ZERO);
        let maxs = self.maxs + way.max(Vec3::ZERO);
        Aabb::new(mins, maxs).loosened(self.aside)
    }

    /// Whether a body stays in the moving box in a step of `dt` seconds. `shape` is the box of its shape, and `margin` what it may touch
    /// around it, but for its velocity, m.
    pub fn holds(&self, body: &BodyState, shape: &Aabb, margin: f32, dt: f32) -> bool {
        let deviation = (body.velocity.linear - self.velocity).length() * dt;
        let tight = shape.loosened(margin + deviation);
        self.steps > 0 && dt <= self.dt && Aabb::new(self.mins, self.maxs).contains(&tight)
    }

    /// Whether two moving boxes come so near to each other, as long as both last, that their bodies may touch.
    fn meets(&self, other: &Self) -> bool {
        let velocity = self.velocity - other.velocity;
        let step = velocity.length() * self.dt.min(other.dt);
        let near = step.min(self.aside + other.aside);
        let nearest = other.mins - self.maxs - near;
        let farthest = other.maxs - self.mins + near;
        let (mut from, mut to) = (0.0_f32, self.time().min(other.time()));
        for axis in 0..3 {
            let (speed, nearest, farthest) = (velocity[axis], nearest[axis], farthest[axis]);
            if speed == 0.0 {
                if nearest > 0.0 || farthest < 0.0 {
                    return false;
                }
                continue;
            }
            let (a, b) = (nearest / speed, farthest / speed);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        from <= to
    }
}

/// The flights of all bodies that have one.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Flights {
    list: Vec<Flight>,
    /// Place in the list by slot; [`NONE`] for other bodies. May be shorter than the list of slots.
    places: Vec<u32>,
    /// Length of the last step, s.
    last_dt: f32,
}

clone_fields!(Flights {
    list,
    places,
    last_dt,
});

const NONE: u32 = u32::MAX;

impl Flights {
    pub fn get(&self, slot: u32) -> Option<&Flight> {
        let place = self.places.get(slot as usize)?;
        self.list.get(*place as usize)
    }

    pub fn set(&mut self, flight: Flight) {
        let slot = flight.slot as usize;
        if self.places.len() <= slot {
            self.places.resize(slot + 1, NONE);
        }
        match self.list.get_mut(self.places[slot] as usize) {
            Some(known) => *known = flight,
            None => {
                self.places[slot] = self.list.len() as u32;
                self.list.push(flight);
            }
        }
    }

    pub fn remove(&mut self, slot: u32) {
        let Some(place) = self.places.get_mut(slot as usize) else {
            return;
        };
        let place = std::mem::replace(place, NONE) as usize;
        if place < self.list.len() {
            self.list.swap_remove(place);
            if let Some(last) = self.list.get(place) {
                self.places[last.slot as usize] = place as u32;
            }
        }
    }

    pub fn slots(&self) -> impl Iterator<Item = u32> {
        self.list.iter().map(|flight| flight.slot)
    }

    /// Moves the boxes by the last step.
    pub fn begin_step(&mut self, dt: f32) {
        let last_dt = std::mem::replace(&mut self.last_dt, dt);
        for flight in &mut self.list {
            let way = flight.velocity * last_dt;
            flight.mins += way;
            flight.maxs += way;
            flight.steps = flight.steps.saturating_sub(1);
        }
    }

    /// Whether two bodies whose boxes in the tree overlap may touch as far as they move as expected.
    pub fn meet(&self, slots: [u32; 2], boxes: [&Aabb; 2]) -> bool {
        match slots.map(|slot| self.get(slot)) {
            [None, None] => true,
            [Some(a), Some(b)] => a.meets(b),
            [Some(a), None] => a.meets(&Flight::resting(boxes[1])),
            [None, Some(b)] => b.meets(&Flight::resting(boxes[0])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(slot: u32, at: Vec3, velocity: Vec3) -> Flight {
        Flight {
            slot,
            mins: at - 0.5,
            maxs: at + 0.5,
            velocity,
            aside: 0.1,
            steps: 3,
            dt: 0.1,
        }
    }

    #[test]
    fn boxes_that_fly_together_do_not_meet_and_others_do() {
        let at = 3.0 * Vec3::X;
        let (still, ahead) = (flight(0, Vec3::ZERO, Vec3::ZERO), 20.0 * Vec3::X);
        for velocity in [Vec3::ZERO, ahead, Vec3::new(3.0, -40.0, 7.0)] {
            assert!(!flight(0, Vec3::ZERO, velocity).meets(&flight(1, at, velocity)));
        }
        assert!(flight(0, Vec3::ZERO, ahead).meets(&flight(1, at, Vec3::ZERO)));
        assert!(still.meets(&flight(1, at, -ahead)));
        assert!(!still.meets(&flight(1, at, ahead)));
        // It passes at a corner.
        let aslant = Vec3::new(20.0, 20.0, 0.0);
        assert!(!flight(0, Vec3::ZERO, aslant).meets(&flight(1, at, Vec3::ZERO)));
        assert!(flight(0, Vec3::ZERO, aslant).meets(&flight(1, at + 3.0 * Vec3::Y, Vec3::ZERO)));
        // In 0.3 s it comes 1.5 m nearer, of 2 m.
        assert!(!flight(0, Vec3::ZERO, 5.0 * Vec3::X).meets(&flight(1, at, Vec3::ZERO)));
    }

    /// Sampled: at every time at which two moving boxes are near, they meet, and their paths overlap.
    #[test]
    fn no_two_boxes_that_come_near_are_missed() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut vector =
            |scale: f32| Vec3::from_array(std::array::from_fn(|_| scale * (random.f32() - 0.5)));
        let mut met = 0;
        for _ in 0..20_000 {
            let [a, b] = [0, 1].map(|slot| flight(slot, vector(6.0), vector(40.0)));
            let near = (0..=60).map(|i| 0.005 * i as f32).any(|time| {
                let at = |of: &Flight, corner: Vec3| corner + time * of.velocity;
                let apart = (at(&b, b.mins) - at(&a, a.maxs)).max(at(&a, a.mins) - at(&b, b.maxs));
                apart.max_element() <= 0.0
            });
            assert!(
                !near || a.meets(&b) && a.path().intersects(&b.path()),
                "{a:?} {b:?}"
            );
            met += usize::from(near);
        }
        assert!((1000..19_000).contains(&met), "{met}");
    }

    #[test]
    fn flights_are_found_by_their_slots_after_others_were_removed() {
        let mut flights = Flights::default();
        for slot in [4, 9, 2, 7] {
            flights.set(flight(slot, slot as f32 * Vec3::X, Vec3::ZERO));
        }
        flights.remove(9);
        flights.remove(9);
        flights.remove(100);
        flights.set(flight(2, 20.0 * Vec3::X, Vec3::Y));
        flights.begin_step(0.5);
        flights.begin_step(0.1);
        let at = |slot| flights.get(slot).map(|flight| flight.maxs);
        assert_eq!(at(9), None);
        assert_eq!(at(2), Some(Vec3::new(20.5, 1.0, 0.5)));
        assert_eq!(at(4), Some(Vec3::new(4.5, 0.5, 0.5)));
        assert_eq!(at(7), Some(Vec3::new(7.5, 0.5, 0.5)));
    }
}
