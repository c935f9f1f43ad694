//! Vehicles: wheels on springs, with steering, engine and brake, that are rays and not bodies.
//!
//! Put [`Wheel`] on a child of a dynamic body. In every step it casts a ray from its place along its own −y. What the ray hits is its
//! ground: a spring with a damper holds the body above it, and friction drives, brakes and guides the body. A wheel rolls towards its own
//! −z, as Bevy's cameras look. A game writes [`steering`](Wheel::steering), [`engine`](Wheel::engine) and [`brake`](Wheel::brake), and
//! reads [`WheelState`]. A body may have any number of wheels.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let car = (RigidBody::Dynamic, Collider::cuboid(1.6, 0.5, 3.6), Mass(1200.0), Transform::from_xyz(0.0, 0.9, 0.0));
//! let car = world.spawn(car).id();
//! for (x, z) in [(-0.7, -1.3), (0.7, -1.3), (-0.7, 1.3), (0.7, 1.3)] {
//!     let wheel = Wheel { engine: 200.0, ..Default::default() };
//!     world.spawn((wheel, ChildOf(car), Transform::from_xyz(x, -0.1, z)));
//! }
//! for _ in 0..120 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! // Four wheels of 0.35 m with 200 N·m each: 2286 N, and 1200 kg.
//! let speed = -world.get::<Velocity>(car).unwrap().linear.z;
//! assert!((3.0..3.8).contains(&speed), "{speed}");
//! ```
//!
//! # The model
//!
//! - **Suspension**: a spring of a [frequency](Wheel::frequency) and a [damping ratio](Wheel::damping_ratio) for the share of the body's
//!   mass that is on the wheel, 1/n of it for n wheels; so the same numbers fit a toy and a lorry. At rest the springs of a body whose
//!   centre of mass is in their middle are compressed by g / (2π f)², and it bobs with the frequency f. At the end of its
//!   [travel](Wheel::travel) the suspension is rigid. Its force is along the normal of the ground, and never pulls.
//! - **Grip**: dry friction, of the combined [`Friction`] of wheel and ground, against the slip of the tread: along the
//!   wheel and across it together at most μ times the load. Below that the tread does not slip at all. The wheel has an
//!   [inertia](Wheel::mass_share) of its own, so the engine can spin it, and the brake can lock it.
//! - **Brake and rolling resistance** hold the wheel like dry friction. A braked vehicle stands on a slope and does not creep: each
//!   wheel remembers where its tread is.
//!
//! The wheels of a body are solved together, as constraints on velocities, so that they are stable in long steps and with any brake.
//! What they do to the ground they also do to a dynamic body that is the ground, except that a body which touches others counts as held by
//! them. A wheel collides with nothing: give the body a collider that reaches where walls should stop it. The ray sees the bodies that the
//! body collides with by its [`CollisionLayers`](crate::collider::CollisionLayers). The force of friction acts where the wheel touches, so
//! a wheel that spins in the air does not turn the body.
//!
//! # Sleep
//!
//! A parked vehicle sleeps like other bodies. It wakes if its [`Wheel`]s are written with other values, and if its ground moves, changes or
//! is despawned. What is put between a sleeping vehicle's wheel and its ground is noticed when the vehicle wakes.

mod drive;
mod grip;
mod mount;
mod state;

pub use state::{WheelContact, WheelState};

use crate::body::Sleeping;
use crate::body::collider::Friction;
use crate::body::limits;
use crate::components::{any_with, init};
use crate::fluid::FluidSystems;
use crate::profile::{Profile, own};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_math::ops;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;

/// Drives every [`Wheel`]. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct VehiclePlugin;

/// The system set in which wheels push their bodies and the ground: before *forces*, and after [`FluidSystems`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VehicleSystems;

impl Plugin for VehiclePlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "forces", drive::drive)
                .run_if(any_with(Components::component_id::<Wheel>))
                .after(PhysicsSystems::NormalCorrection)
                .after(FluidSystems)
                .before(PhysicsSystems::Forces)
                .in_set(VehicleSystems),
        );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// A wheel of a vehicle: a ray with a spring, on a child of a dynamic body or on the body itself; see the [module](self).
///
/// Its `Transform` says where the suspension is mounted: the ray starts there, along its −y. Forwards is its −z, and its axle is along x.
/// To draw the wheel, put its mesh on a child of this entity, with the `Transform` that [`WheelState::place`] gives.
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
#[component(on_remove = taken_off)]
#[require(Transform, WheelState)]
pub struct Wheel {
    /// Radius, m. Default: 0.35.
    pub radius: f32,
    /// Distance from the mount to the axle while nothing presses on the wheel, m. Default: 0.4.
    pub suspension: f32,
    /// How far the suspension can be compressed, m. Default: 0.3.
    pub travel: f32,
    /// Frequency at which the body would bob on its springs without damping, Hz. Default: 1.5, that of a car.
    pub frequency: f32,
    /// Damping as a share of that with which the body does not bob, without unit. Default: 0.4.
    pub damping_ratio: f32,
    /// Mass of the wheel, a disc, as a share of that of the body. It counts only against changes of its spin. Default: 0.02.
    pub mass_share: f32,
    /// Friction of the tread. It is combined with that of the ground as that of two bodies. Default: a coefficient of 1.
    pub grip: Friction,
    /// Grip across the wheel as a multiple of that along it. With less than 1 a vehicle drifts. Default: 1.
    pub grip_across: f32,
    /// Rolling resistance as a share of the load, without unit. Default: 0.015.
    pub rolling_resistance: f32,
    /// Angle about the wheel's y axis, rad: positive is to the left. [`ackermann`] computes it for the two wheels of an axle. Default: 0.
    pub steering: f32,
    /// Torque of the engine on this wheel, N·m: positive is forwards. Default: 0.
    pub engine: f32,
    /// Torque with which the brake holds the wheel at most, N·m. Default: 0.
    pub brake: f32,
}

impl Default for Wheel {
    fn default() -> Self {
        Self {
            radius: 0.35,
            suspension: 0.4,
            travel: 0.3,
            frequency: 1.5,
            damping_ratio: 0.4,
            mass_share: 0.02,
            grip: Friction::new(1.0),
            grip_across: 1.0,
            rolling_resistance: 0.015,
            steering: 0.0,
            engine: 0.0,
            brake: 0.0,
        }
    }
}

/// Largest frequency, Hz, angle of steering, rad, and other numbers without a limit of their own.
const MOST: f32 = 1e3;

/// Least frequency, Hz, and least share of the mass.
const LEAST: f32 = 1e-4;

impl Wheel {
    /// Returns true if all numbers are finite and within [`limits`], none but `steering` and `engine` is negative, and radius, frequency
    /// and share of the mass are not zero. A wheel with other numbers does nothing, which is reported once.
    pub fn is_valid(&self) -> bool {
        let shares = [self.damping_ratio, self.grip_across];
        limits::share_of(self.radius, limits::LARGEST)
            && self.radius >= limits::SMALLEST
            && limits::share_of(self.suspension, limits::LARGEST)
            && limits::share_of(self.travel, limits::LARGEST)
            && (LEAST..=MOST).contains(&self.frequency)
            && (LEAST..=MOST).contains(&self.mass_share)
            && shares.iter().all(|share| limits::share_of(*share, MOST))
            && limits::share_of(self.rolling_resistance, MOST)
            && self.grip.is_valid()
            && self.steering.abs() <= MOST
            && self.engine.abs() <= limits::FORCE
            && limits::share_of(self.brake, limits::FORCE)
    }
}

/// The [`steering`](Wheel::steering), rad, of a wheel that is `across` metres to the right of the middle of its axle (negative: to the
/// left), so that no wheel slips in a turn in which the middle of the axle is steered by `steering`. `wheel_base` is the distance to the
/// axle that is not steered, m.
///
/// The inner wheel turns in more than the outer one: this is Ackermann's geometry.
pub fn ackermann(steering: f32, wheel_base: f32, across: f32) -> f32 {
    let slope = ops::tan(steering);
    ops::atan2(slope * wheel_base, wheel_base + slope * across)
}

/// Hook of [`Wheel`]: the body stands on its other wheels.
fn taken_off(mut world: DeferredWorld, context: HookContext) {
    let body = world.get_mut::<WheelState>(context.entity);
    let body = body.and_then(|mut state| std::mem::take(&mut *state).body());
    if let Some(body) = body
        && let Some(mut sleeping) = world.get_mut::<Sleeping>(body)
    {
        sleeping.wake();
    }
}
