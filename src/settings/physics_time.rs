//! Pause, slow motion and single steps of physics, beside those of the app.

use crate::diagnosis::StepError;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Pauses physics, and makes it slower or faster, without a change of the app's own time. An app's steps follow it; [`step`](crate::step())
/// and [`advance`](crate::advance()) do not, as they are given a length.
///
/// Each step is as long as the step of the app times the relative speed. So slow motion has short steps, and is as smooth as the app.
/// Default: running at speed 1.
///
/// ```
/// use bevy_app::App;
/// use bevy_ecs::prelude::*;
/// use drystone::prelude::*;
///
/// fn toggle_pause(mut time: ResMut<PhysicsTime>) {
///     match time.is_paused() {
///         true => time.unpause(),
///         false => time.pause(),
///     }
/// }
///
/// fn look_closely(mut time: ResMut<PhysicsTime>) {
///     time.set_relative_speed(0.1).unwrap();
///     // Or one step at a time.
///     time.pause();
///     time.request_steps(1);
/// }
/// # let mut world = World::new();
/// # world.init_resource::<PhysicsTime>();
/// # world.run_system_cached(toggle_pause).unwrap();
/// # assert!(world.resource::<PhysicsTime>().is_paused());
/// # world.run_system_cached(look_closely).unwrap();
/// ```
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct PhysicsTime {
    paused: bool,
    relative_speed: f32,
    requested: u32,
}

impl Default for PhysicsTime {
    fn default() -> Self {
        Self {
            paused: false,
            relative_speed: 1.0,
            requested: 0,
        }
    }
}

impl PhysicsTime {
    /// The largest relative speed. Faster physics needs more steps, not longer ones.
    pub const MAX_SPEED: f32 = 100.0;

    /// Stops physics: no more steps are taken, except those that are [requested](Self::request_steps).
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Lets physics go on. Requested steps that were not taken are forgotten.
    pub fn unpause(&mut self) {
        (self.paused, self.requested) = (false, 0);
    }

    /// Returns true if physics is paused.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Takes this many more steps while physics is paused, one in each step of the app.
    pub fn request_steps(&mut self, steps: u32) {
        self.requested = self.requested.saturating_add(steps);
    }

    /// Length of a step of physics relative to one of the app.
    pub fn relative_speed(&self) -> f32 {
        self.relative_speed
    }

    /// Sets the length of a step of physics relative to one of the app. At 0 no step is taken.
    ///
    /// # Errors
    /// If it is negative, not a number or above [`MAX_SPEED`](Self::MAX_SPEED). The speed stays what it was.
    pub fn set_relative_speed(&mut self, speed: f32) -> Result<(), StepError> {
        if !(0.0..=Self::MAX_SPEED).contains(&speed) {
            return Err(StepError::InvalidSettings {
                resource: "PhysicsTime",
                why: format!(
                    "the relative speed is {speed}, and must be between 0 and {}",
                    Self::MAX_SPEED
                ),
            });
        }
        self.relative_speed = speed;
        Ok(())
    }

    /// Returns true if the next step of the app takes no step of physics.
    fn stands_still(&self) -> bool {
        self.paused && self.requested == 0 || self.relative_speed == 0.0
    }

    /// The length of the next step of physics, from that of the app, s; 0 for none.
    pub(crate) fn next_step(&mut self, delta: f32) -> f32 {
        if self.stands_still() {
            return 0.0;
        }
        self.requested = self.requested.saturating_sub(1);
        delta * self.relative_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requested_steps_are_taken_one_by_one() {
        let mut time = PhysicsTime::default();
        assert_eq!(time.next_step(0.1), 0.1);
        time.pause();
        time.request_steps(2);
        assert_eq!([(); 3].map(|()| time.next_step(0.1)), [0.1, 0.1, 0.0]);
        time.request_steps(5);
        time.unpause();
        time.set_relative_speed(0.5).unwrap();
        assert_eq!(time.next_step(0.1), 0.05);
        time.pause();
        assert_eq!(time.next_step(0.1), 0.0);
    }

    #[test]
    fn an_invalid_speed_changes_nothing_and_says_why() {
        let mut time = PhysicsTime::default();
        for speed in [-1.0, f32::NAN, 1e9] {
            let error = time.set_relative_speed(speed).unwrap_err();
            assert!(error.to_string().contains("between 0 and 100"), "{error}");
        }
        assert_eq!(time.relative_speed(), 1.0);
    }
}
