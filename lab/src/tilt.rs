//! Tilt limits: the slope at which a box slides, and those at which a block and a column topple, under any settings.

use crate::experiment::Experiment;
use crate::metrics::Displacement;
use bevy_transform::components::Transform;
use drystone::body::{Pose, RigidBody};
use drystone::collider::{Collider, Friction};
use drystone::schedule::step;
use glam::{Quat, Vec3};

/// Equal boxes on top of each other, on a slope that is tilted about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilted {
    /// Full lengths of the edges of a box, m.
    pub size: Vec3,
    /// How many boxes.
    pub count: u32,
    /// Coefficient of friction of all surfaces.
    pub friction: f32,
}

/// Slopes are tried within so many degrees of the limit of statics.
pub const RANGE: f32 = 4.0;
/// The bracket is halved so often: to 8° / 2⁷ = 0.06°.
const HALVINGS: u32 = 7;
/// How long it must stand, s. A tenth of a degree beyond the limit a box slides by 0.2 m in this time.
const SECONDS: f32 = 5.0;
/// Larger displacements, m, and rotations, rad, are falls.
const MOVED: f32 = 0.05;
const TURNED: f32 = 0.1;

impl Tilted {
    /// A cube of 1 m that slides.
    pub const SLIDING: Self = Self {
        size: Vec3::ONE,
        count: 1,
        friction: 0.5,
    };
    /// A block twice as high as wide that topples.
    pub const TOPPLING: Self = Self {
        size: Vec3::new(1.0, 2.0, 1.0),
        count: 1,
        friction: 1.0,
    };
    /// A column of five cubes that topples as one.
    pub const COLUMN: Self = Self {
        size: Vec3::ONE,
        count: 5,
        friction: 0.5,
    };

    /// The limit by statics: tan θ is μ or width over height, whichever is less, °.
    pub fn limit(&self) -> f32 {
        let slender = self.size.x / (self.count as f32 * self.size.y);
        self.friction.min(slender).atan().to_degrees()
    }

    /// Returns true if it stands on a slope of so many degrees under the settings of an experiment.
    pub fn stands(&self, settings: &Experiment, degrees: f32) -> bool {
        let mut world = settings.world();
        let turn = Quat::from_rotation_z(-degrees.to_radians());
        let friction = Friction::new(self.friction);
        world.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            friction,
            Transform::from_rotation(turn),
        ));
        let gap = settings.stabilization.rest_distance().max(0.0);
        let Vec3 { x, y, z } = self.size;
        let height = |i: u32| (i as f32 + 0.5) * y + (i + 1) as f32 * gap;
        let start: Vec<Pose> = (0..self.count)
            .map(|i| Pose {
                position: turn * Vec3::Y * height(i),
                rotation: turn,
            })
            .collect();
        let boxes: Vec<_> = start
            .iter()
            .map(|pose| {
                let place = Transform::from_translation(pose.position).with_rotation(turn);
                let shape = Collider::cuboid(x, y, z);
                world
                    .spawn((RigidBody::Dynamic, shape, friction, place))
                    .id()
            })
            .collect();
        for _ in 0..(SECONDS / settings.dt).round() as usize {
            step(&mut world, settings.dt).expect("the experiment's time step is positive");
            let now: Vec<Pose> = boxes
                .iter()
                .map(|&body| crate::metrics::watch(&world, body).0)
                .collect();
            let Displacement {
                drift, sag, tilt, ..
            } = Displacement::between(&start, &now);
            if !(drift <= MOVED && sag <= MOVED && tilt <= TURNED) {
                return false;
            }
        }
        true
    }

    /// The steepest slope on which it stands under the settings of an experiment, °. Sleeping should be off, or a box that creeps falls
    /// asleep. `None` if it stands nowhere, or everywhere, within [`RANGE`] of the limit.
    pub fn steepest(&self, settings: &Experiment) -> Option<f32> {
        let (mut low, mut high) = (self.limit() - RANGE, self.limit() + RANGE);
        if !self.stands(settings, low) || self.stands(settings, high) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match self.stands(settings, middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        Some(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::Scene;
    use drystone::settings::Preset;

    #[test]
    fn the_default_solver_has_the_limits_of_statics() {
        let mut settings = Experiment::new(Scene::Stack(1), Preset::Default);
        settings.sleeping.enabled = false;
        for tilted in [Tilted::SLIDING, Tilted::TOPPLING, Tilted::COLUMN] {
            let found = tilted.steepest(&settings).expect("it is within 4°");
            let limit = tilted.limit();
            println!("{tilted:?}: {found}°, by statics {limit}°");
            assert!((found - limit).abs() < 0.3, "{found} {limit}");
        }
    }
}
