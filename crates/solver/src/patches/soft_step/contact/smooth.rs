//! Smooth motions: those in which bodies drift by the mean of their velocities at the beginning and at the end of a substep.
//!
//! With the velocity at the end alone, a body that swings down onto an edge arrives there with less energy than it has lost in height.
//! Other bodies drift with it all the same, because the damping of the springs that hold them counts on it.

use crate::lanes::State;
use crate::{Body, PatchProblem, ROCKING_SPEED};
use glam::Vec3;

/// The acceleration below which a motion is smooth, over that of free fall. A blow is more.
const MAX_ACCELERATION: f32 = 1.5;

/// The speed from which on a motion is smooth, over that gained in a substep of free fall. Slower bodies are at rest on their springs.
const MIN_SPEED: f32 = 2.0;

/// The angular speed up to which a body rocks, rad/s. What turns faster rolls or tumbles.
const MAX_ROCKING_SPEED: f32 = 4.0;

/// Which motions of a step are smooth. By default none is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Smooth {
    /// The acceleration of free fall, m/s²; 0 if no motion is smooth.
    gravity: f32,
    /// What bodies stand on accelerates, so that also those are smooth that do not rock.
    shaken: bool,
}

impl Smooth {
    /// The smooth motions of a problem without round bodies: these roll in valleys, and come to rest only if drift damps them. If joints,
    /// grabs or moving surfaces act on the bodies, none is smooth.
    pub fn of(problem: &PatchProblem) -> Self {
        let accelerates = |body: &Body| body.inverse_mass == 0.0 && body.push() != [Vec3::ZERO; 2];
        match problem.has_only_contacts() {
            true => Self {
                gravity: problem.gravity.length(),
                shaken: problem.bodies.iter().any(accelerates),
            },
            false => Self::default(),
        }
    }

    /// A number that is the same for problems in which the same motions are smooth, in one world.
    pub fn kind(&self) -> u64 {
        u64::from(self.gravity > 0.0) << 1 | u64::from(self.shaken)
    }

    /// Whether a body moves smoothly that has a velocity `now`, and has `gained` velocity in a substep of `h` s.
    #[inline(always)]
    pub fn is(&self, now: State, gained: State, h: f32) -> bool {
        let fall = self.gravity * h;
        let square = fall * fall;
        gained[0].length_squared() < MAX_ACCELERATION * MAX_ACCELERATION * square
            && (self.shaken || {
                let square = now[1].length_squared();
                square > ROCKING_SPEED * ROCKING_SPEED
                    && square < MAX_ROCKING_SPEED * MAX_ROCKING_SPEED
            })
            && now[0].length_squared() > MIN_SPEED * MIN_SPEED * square
    }
}
