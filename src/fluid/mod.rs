//! Water and wind: sensors that are filled with a fluid, in which bodies float, and which drags them along.
//!
//! Put [`Fluid`] on a collider. It becomes a [sensor](crate::sensor), and what overlaps it is lifted by the weight of the fluid that it
//! displaces, and dragged towards the velocity of the fluid. The surface is the top of the sensor, or a [level](Fluid::level), and with
//! [`FluidField`] it has waves. Air is a fluid too: [`Fluid::air`] is wind.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! // A pool of 4 m by 4 m whose surface is at a height of 1 m.
//! world.spawn((Collider::cuboid(4.0, 2.0, 4.0), Fluid::water(), Transform::default()));
//! let crate_ = (RigidBody::Dynamic, Collider::cuboid(0.5, 0.5, 0.5), Density(300.0));
//! let crate_ = world.spawn((crate_, Transform::from_xyz(0.0, 1.2, 0.0))).id();
//! for _ in 0..1200 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! // Three tenths of it are below the surface.
//! let height = world.get::<Transform>(crate_).unwrap().translation.y;
//! assert!((height - (1.0 + 0.2 * 0.5)).abs() < 0.005, "{height}");
//! ```
//!
//! # What acts on a body
//!
//! - **Buoyancy**: the weight of the displaced fluid, at the centroid of the volume below the surface. Volume and centroid are those of
//!   the shape itself: polyhedra and meshes are cut by the surface, and balls, cylinders, cones and capsules are integrated. So a beam
//!   floats flat, a keel rights a boat, and a barrel rolls freely. A body has the volume of its colliders: a hollow ship is one of plates,
//!   or one of a solid hull whose [`Mass`](crate::body::Mass) is that of the ship.
//! - **Drag**: the pressure on each face that moves into the fluid, ½ ρ C (u·n)² on its wet area, which slows a flat board more than an
//!   arrow, and makes keels, rudders and sails work. It is applied so that no step overshoots.
//! - **Damping**: what waves and friction in the fluid take, in proportion to the speed and to the displaced mass.
//!
//! The surface is flat across each collider, at the height and with the slope that it has at the collider's centre. A body that is partly
//! outside of the sensor's sides counts as if it were inside. Where fluids overlap, all act.
//!
//! # Sleep
//!
//! Bodies in a fluid sleep like others, and a change of the [`Fluid`] or of its surface wakes them. A fluid with a [`FluidField`] keeps all
//! bodies in it awake.
//!
//! # Source
//! Buoyancy is Archimedes' principle; the pressure on faces is Newton's (*Principia*, book II, proposition 34), who found half the drag of
//! a disc for a ball.

mod clip;
mod field;
mod push;
mod revolved;
mod wet;

pub use field::{FluidField, FluidPoint};

use crate::body::{Sensor, SensorOverlaps, Sleeping, limits};
use crate::components::{any_with, init};
use crate::profile::{Profile, own};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Lifts and drags the bodies in every [`Fluid`]. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct FluidPlugin;

/// The system set in which fluids push bodies: before *forces*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FluidSystems;

impl Plugin for FluidPlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "forces", push::push)
                .run_if(any_with(Components::component_id::<Fluid>))
                .after(PhysicsSystems::NormalCorrection)
                .before(PhysicsSystems::Forces)
                .in_set(FluidSystems),
        );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// Fills a collider with a fluid that lifts and drags the bodies inside; see the [module](self). The collider becomes a
/// [`Sensor`]. The default is still water.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
#[component(on_remove = drained)]
#[require(Sensor, FluidState)]
pub struct Fluid {
    /// Density, kg/m³. Default: 1000, that of water.
    pub density: f32,
    /// Height of the surface against gravity, world, m. `None` is the top of the sensor, which moves with it. Default: `None`.
    pub level: Option<f32>,
    /// Velocity of the fluid, world, m/s. Default: zero.
    pub flow: Vec3,
    /// Drag coefficient C of a plate that faces the flow. A cube has as much then, a long cylinder two thirds, and a ball half. 0 is no
    /// drag. Default: 1.
    pub drag: f32,
    /// Share of its speed in the fluid that a body of the density of the fluid loses in a second, 1/s. Default: 0.5.
    pub damping: f32,
}

impl Default for Fluid {
    fn default() -> Self {
        Self::water()
    }
}

impl Fluid {
    /// Still water.
    pub const fn water() -> Self {
        Self {
            density: 1000.0,
            level: None,
            flow: Vec3::ZERO,
            drag: 1.0,
            damping: 0.5,
        }
    }

    /// Wind: air with this velocity, world, m/s. A wind that blows everywhere fills a half-space whose surface is above everything.
    pub const fn air(velocity: Vec3) -> Self {
        Self {
            density: 1.2,
            flow: velocity,
            ..Self::water()
        }
    }

    /// Returns true if all numbers are finite and within [`limits`], and none but `level` and `flow` is negative. A fluid with other
    /// numbers does nothing, which is reported once.
    pub fn is_valid(&self) -> bool {
        let amounts = [self.density, self.drag, self.damping];
        amounts
            .iter()
            .all(|amount| (0.0..=limits::DAMPING).contains(amount))
            && limits::within(self.flow, limits::SPEED)
            && self
                .level
                .is_none_or(|level| level.abs() <= limits::POSITION)
    }
}

/// What a [`Fluid`] was in the last step.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(clone_behavior = Ignore)]
pub struct FluidState {
    /// Height of the surface against gravity without its waves, world, m.
    pub surface: f32,
    /// Simulated time since the fluid came in, s. [`FluidField`] is told this time.
    pub age: f32,
    /// Bodies sleep if it stays so.
    known: Option<Fluid>,
    is_reported: bool,
}

/// Hook of [`Fluid`]: wakes what floated in it.
fn drained(mut world: DeferredWorld, context: HookContext) {
    let inside = world.get::<SensorOverlaps>(context.entity);
    let inside: Vec<Entity> = inside.map_or_else(Vec::new, |inside| inside.bodies().collect());
    for body in inside {
        if let Some(mut sleeping) = world.get_mut::<Sleeping>(body) {
            sleeping.wake();
        }
    }
    if let Some(mut state) = world.get_mut::<FluidState>(context.entity) {
        *state = FluidState::default();
    }
}
