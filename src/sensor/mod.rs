//! The stage **sensors**: which bodies are inside a zone.
//!
//! A collider with the component [`Sensor`] touches nothing. It detects the bodies whose shape overlaps its own, wakes nobody and has no
//! place in the [constraint graph](crate::graph). It may be a body, a part of a body, or stand alone.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! # world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! #[derive(Resource, Default)]
//! struct Score(i32);
//!
//! world.init_resource::<Score>();
//! let goal = world
//!     .spawn((Collider::cuboid(2.0, 2.0, 2.0), Sensor, Transform::from_xyz(0.0, 1.0, 0.0)))
//!     .observe(|_: On<SensorEntered>, mut score: ResMut<Score>| score.0 += 1)
//!     .id();
//! let ball = (RigidBody::Dynamic, Collider::ball(0.2), Transform::from_xyz(0.0, 3.0, 0.0));
//! let ball = world.spawn(ball).id();
//! for _ in 0..90 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! assert_eq!(world.resource::<Score>().0, 1);
//! let inside = world.get::<SensorOverlaps>(goal).unwrap();
//! assert!(inside.contains(ball));
//! assert_eq!(inside.bodies().count(), 1);
//!
//! world.despawn(ball);
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! assert!(world.get::<SensorOverlaps>(goal).unwrap().is_empty());
//! ```
//!
//! # What a sensor detects
//!
//! - Dynamic and kinematic bodies, asleep or awake, at their poses at the end of the step. Static bodies only if the sensor belongs to a
//!   body that is not static: a zone does not report its floor, a foot does.
//! - Solid colliders, not other sensors, and not those of its own body.
//! - Bodies whose [`CollisionLayers`](crate::collider::CollisionLayers) and [`CollisionExceptions`](crate::collider::CollisionExceptions)
//!   would let them collide with it. The layers are those of the part and of the sensor, or else of their bodies.
//! - Bodies that fly through it within a step, on the straight way between their poses at its start and its end. They are inside for that
//!   step. Bodies that move by less than their thickness cannot.
//!
//! Shapes are compared exactly, and touching counts as overlap. Meshes and height fields are surfaces: they overlap what crosses them.
//! [Spatial queries](crate::query) do not find sensors.
//!
//! # Cost
//!
//! Only what moved is compared: bodies that moved with the sensors near them, and sensors that moved with the bodies near them. Bodies at
//! rest in a sensor at rest cost nothing, however many they are (`cargo bench --bench sensors`).

mod detect;
mod events;
mod overlaps;
mod stage;
mod zones;

pub(crate) use events::trigger;
pub use events::{SensorEntered, SensorExited, UntriggeredSensorEvents};
pub use overlaps::{SensorOverlap, SensorOverlaps};
pub use stage::sensors;
pub use zones::Sensors;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a collider that detects bodies and touches nothing; see the [module](self). [`SensorOverlaps`] says who is inside.
///
/// On a body it applies to the body's own collider: a dynamic body without other colliders falls through everything, with the mass of its
/// sensors. On a part of a body it applies to that part, which then has no mass.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = crate::children::sensor_changed, on_remove = removed)]
#[require(SensorOverlaps)]
pub struct Sensor;

/// Hook of [`Sensor`]: the collider is solid from the next step on.
fn removed(mut world: DeferredWorld, context: HookContext) {
    crate::children::mark(&mut world, context.entity);
}
