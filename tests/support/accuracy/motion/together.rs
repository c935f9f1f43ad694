//! Row 26: columns, walls and blocks on a floor that turns, which rock as a whole.

use super::at_step;
use crate::Lab;
use crate::accuracy::{Settings, Values};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec3};

/// Height and thickness of what rocks, m.
const HEIGHT: f32 = 1.0;
const THICKNESS: f32 = 0.25;

/// The step of the reference, s.
const FINE: f32 = 1.0 / 1920.0;

/// What rocks. All of it leans about the x axis, on the edge at −z.
#[derive(Clone, Copy, Debug)]
enum Thing {
    /// So many blocks on each other.
    Column(usize),
    /// So many courses of bricks, four in each.
    Wall(usize),
    /// A block on a floor that turns about the vertical, rad/s.
    Turned(f32),
}

impl Thing {
    fn name(self) -> String {
        match self {
            Self::Column(blocks) => format!("column of {blocks} rocks"),
            Self::Wall(courses) => format!("wall of {courses} courses rocks on its foot"),
            Self::Turned(speed) => format!("box rocks on a floor that turns by {speed} rad/s"),
        }
    }

    /// Sizes and centres of its bodies when it stands upright.
    fn bodies(self) -> Vec<(Vec3, Vec3)> {
        let layer = |i: usize, count: usize| HEIGHT * (i as f32 + 0.5) / count as f32;
        match self {
            Self::Column(count) => (0..count)
                .map(|i| {
                    let size = Vec3::new(1.0, HEIGHT / count as f32, THICKNESS);
                    (size, layer(i, count) * Vec3::Y)
                })
                .collect(),
            Self::Turned(_) => Self::Column(1).bodies(),
            Self::Wall(courses) => (0..courses)
                .flat_map(|i| {
                    let brick = 0.4;
                    let half = 0.5 * brick;
                    let widths = match i % 2 {
                        0 => vec![brick; 4],
                        _ => vec![half, brick, brick, brick, half],
                    };
                    let mut left = -2.0 * brick;
                    widths.into_iter().map(move |width| {
                        let x = left + 0.5 * width;
                        left += width;
                        let size = Vec3::new(width, HEIGHT / courses as f32, THICKNESS);
                        (size, Vec3::new(x, layer(i, courses), 0.0))
                    })
                })
                .collect(),
        }
    }

    /// Lets it rock from a lean, rad. Returns how far its top leans to the other side after the first impact over the first lean.
    fn swing(self, settings: Settings, dt: f32, start: f32) -> f32 {
        let mut lab = settings(dt);
        let speed = match self {
            Self::Turned(speed) => speed,
            _ => 0.0,
        };
        let kind = if speed == 0.0 {
            RigidBody::Static
        } else {
            RigidBody::Kinematic
        };
        let spin = speed * Vec3::Y;
        lab.spawn((
            (kind, Collider::cuboid(6.0, 1.0, 6.0), Friction::new(2.0)),
            Velocity {
                linear: Vec3::ZERO,
                angular: spin,
            },
            Transform::from_translation(-0.5 * Vec3::Y),
        ));
        let turn = Quat::from_rotation_x(-start);
        let edge = -0.5 * THICKNESS * Vec3::Z;
        let bodies: Vec<Entity> = self
            .bodies()
            .into_iter()
            .map(|(size, center)| {
                let at = edge + turn * (center - edge);
                lab.spawn((
                    (
                        RigidBody::Dynamic,
                        Collider::cuboid(size.x, size.y, size.z),
                        Friction::new(2.0),
                    ),
                    Velocity {
                        linear: spin.cross(at),
                        angular: spin,
                    },
                    Transform::from_translation(at).with_rotation(turn),
                ))
            })
            .collect();
        let top = bodies[bodies.len() - 1];
        // How far it leans towards its own −z.
        let lean = |lab: &Lab| {
            let rotation = lab.pose(top).rotation;
            let up = rotation * Vec3::Y;
            let away = (rotation * Vec3::NEG_Z).with_y(0.0).normalize();
            up.dot(away).atan2(up.y)
        };
        let mut most = 0.0f32;
        for _ in 0..(3.0 / dt) as usize {
            lab.step();
            let now = lean(&lab);
            most = most.max(-now);
            if most > 0.0 && now > -0.9 * most {
                break;
            }
        }
        most / start
    }

    /// The mean over five starts, since an impact comes at any time within a step.
    fn swings(self, settings: Settings, dt: f32) -> f32 {
        let alpha = (THICKNESS / HEIGHT).atan();
        let starts = [0.5f32, 0.49, 0.48, 0.47, 0.46];
        let swings = starts.map(|share| self.swing(settings, dt, share * alpha));
        swings.iter().sum::<f32>() / swings.len() as f32
    }
}

/// Row 26: the first swing back of columns, walls and blocks on a floor that turns. The reference is the same at 1/1920 s.
pub fn rocks_together(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for thing in [
        Thing::Column(2),
        Thing::Column(3),
        Thing::Wall(6),
        Thing::Turned(1.0),
    ] {
        let what = format!("26: {}, first swing back", thing.name());
        let (found, expected) = (thing.swings(settings, dt), thing.swings(settings, FINE));
        values.add_near(
            what,
            (found, expected),
            at_step(dt, [0.05, 0.02, 0.01, 0.005]),
        );
    }
    values
}
