//! The drift of bodies that count as still: slow is not at rest.
//!
//! A body may be slower than the speed below which it counts as still, and yet get anywhere: the hand of a clock, a crate on a slow
//! conveyor, a tower that begins to topple. So a body that is still is looked at four times within the time after which it may sleep. It is
//! *at rest* if, by what was seen, it would move by less than 1 mm in the next ten seconds (at the default
//! [`linear_speed`](crate::settings::SleepSettings::linear_speed), to which that is proportional; by more if its radius is larger than
//! [`LARGE_RADIUS`]):
//! - It moves by no more than that now, and does not speed up. Places are compared, not velocities, because contacts make bodies tremble on
//!   the spot.
//! - Or it slows down, so that it stops before it has moved by as much.
//! - Or contacts hold it, and it creeps without speeding up. The solver lets heaps and walls creep by some tenths of a millimetre in a
//!   second. Nothing real moves like that: dry friction stops what is not driven. A body that rolls, that a force, a moving surface or a
//!   speed limit drives, or whose island has a joint that turns or slides, is not held in this sense.

use crate::body::{BodyState, Pose};
use bevy_platform::collections::HashMap;
use glam::Vec3;

/// Number of looks at a body within the time after which it may sleep.
const LOOKS_PER_REST: usize = 4;

/// A body at rest moves in [`LOOK_AHEAD`] by this times the speed below which bodies count as still, s.
const REST_WAY: f32 = 0.1;

/// A body with a larger radius than this, m, may move farther in proportion to it: the end of a rod of ten metres that turns by 0.1 mrad/s
/// is as fast as a body at rest may be five times over. Of 45 piles of such rods 39 sleep within ten seconds, and 29 without this.
const LARGE_RADIUS: f32 = 1.0;

/// A body that contacts hold speeds up only if it is faster than this times the speed of a body at rest: slower ones tremble.
const SPEEDING_UP_FACTOR: f32 = 2.0;

/// s.
const LOOK_AHEAD: f32 = 10.0;

/// A body speeds up if each look finds it faster than the one before: over four looks by this factor,
const GROWTH_OVER_FOUR: f32 = 1.02;

/// over three looks by this factor,
const GROWTH_OVER_THREE: f32 = 1.1;

/// and its last speed is more than this share of the speed that a body at rest may have.
const MIN_SPEED_SHARE: f32 = 0.1;

/// Earlier velocities of bodies that are still, by slot.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::graph) struct Drifts(
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    HashMap<u32, Drift>,
);

impl Clone for Drifts {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }

    fn clone_from(&mut self, from: &Self) {
        self.0.clone_from(&from.0);
    }
}

/// Earlier velocities of a body.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Drift {
    /// Its pose at the last look. The first one is at the end of the first step in which it was still.
    pose: Pose,
    /// For how long it had been still at the last look, s.
    at: f32,
    /// Mean speeds of its surface between looks, from the last one back, m/s. Negative where nothing is known.
    speeds: [f32; LOOKS_PER_REST],
}

/// How a body that is still moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::graph) enum Drifting {
    /// It is at rest.
    Rests,
    /// It is at rest if contacts hold it.
    Creeps,
    /// It goes on, speeds up, or is not known yet.
    Goes,
}

impl Drifts {
    /// Takes a look at a body if it is time for one. `still_for` is for how long it has been still before this step, and after it, s.
    pub fn look(
        &mut self,
        (slot, body, pose): (u32, &BodyState, &Pose),
        delay: f32,
        [before, still_for]: [f32; 2],
    ) {
        let quarters = |time: f32| (time * LOOKS_PER_REST as f32 / delay).floor();
        if before > 0.0 && delay > 0.0 && quarters(still_for) <= quarters(before) {
            return;
        }
        let known = self
            .0
            .get(&slot)
            .filter(|known| before > 0.0 && known.at < still_for);
        let speeds = known.map_or([-1.0; LOOKS_PER_REST], |known| {
            let way = way(&known.pose, pose, body);
            let [a, b, c, _] = known.speeds;
            [way / (still_for - known.at), a, b, c]
        });
        let seen = Drift {
            pose: *pose,
            at: still_for,
            speeds,
        };
        self.0.insert(slot, seen);
    }

    /// How a body with this radius, m, moves. Bodies count as still below `speed`, m/s, and may sleep after `delay`, s.
    pub fn of(&self, slot: u32, radius: f32, speed: f32, delay: f32) -> Drifting {
        let Some(Drift { speeds, .. }) = self.0.get(&slot) else {
            return Drifting::Goes;
        };
        let far = REST_WAY * speed * radius.max(LARGE_RADIUS) / LARGE_RADIUS;
        let slow = far / LOOK_AHEAD;
        let [a, b, c, d] = *speeds;
        if d < 0.0 {
            // Too few looks to see more.
            return match (0.0..=slow).contains(&a) {
                true => Drifting::Rests,
                false => Drifting::Goes,
            };
        }
        let grows = a > b && b > c && c > d && a > GROWTH_OVER_FOUR * d;
        if grows && a > SPEEDING_UP_FACTOR * slow {
            return Drifting::Goes;
        }
        if grows && a > MIN_SPEED_SHARE * slow {
            return Drifting::Creeps;
        }
        if a + b <= 2.0 * slow || a + b + c + d <= 4.0 * slow {
            return Drifting::Rests;
        }
        // Each half of the time takes it by this share of the way of the half before: a geometric series. The last quarter shows it if
        // something else goes on when that has ended.
        let share = ((a + b) / (c + d)).max(a * a / (b * b));
        let last = (a + b) * delay / LOOKS_PER_REST as f32;
        if share < 1.0 && last * share <= far * (1.0 - share) {
            return Drifting::Rests;
        }
        let jumps = a > b && b > c && a > GROWTH_OVER_THREE * c && a > SPEEDING_UP_FACTOR * slow;
        // A faster motion has ended, and something else goes on.
        let turns = a > 0.9 * b && b < c && c < d && c > slow && d > f32::max(2.0 * b, 4.0 * slow);
        match jumps || turns {
            true => Drifting::Goes,
            false => Drifting::Creeps,
        }
    }

    pub fn get(&self, slot: u32) -> Option<Drift> {
        self.0.get(&slot).copied()
    }

    pub fn set(&mut self, slot: u32, drift: Drift) {
        self.0.insert(slot, drift);
    }

    /// Forgets a body that sleeps, wakes or is removed.
    pub fn forget(&mut self, slot: u32) {
        if !self.0.is_empty() {
            self.0.remove(&slot);
        }
    }
}

/// How far the surface of a body gets from one pose to another at most, m, beyond what rounding may do to the poses. Far from the origin
/// rotations are much more exact than places.
fn way(from: &Pose, to: &Pose, body: &BodyState) -> f32 {
    let center = |pose: &Pose| pose.transform_point(body.mass.local_center);
    let way = (center(to) - center(from)).length();
    let turn = to.rotation * from.rotation.inverse();
    let turned = 2.0 * Vec3::new(turn.x, turn.y, turn.z).length();
    let rounding = f32::EPSILON * to.position.abs().max_element();
    (way - rounding).max(0.0) + (turned - 2.0 * f32::EPSILON).max(0.0) * body.radius
}
