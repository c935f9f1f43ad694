//! Waves and currents: functions of place and time.

use bevy_ecs::prelude::*;
use glam::Vec3;
use std::sync::Arc;

/// Waves and currents of a [`Fluid`](super::Fluid): a function that says how high the surface is and how the fluid flows, by place and
/// time. It is code, so it is not saved; give it again to a fluid that was loaded. The sensor must reach over the crests: set the
/// [`level`](super::Fluid::level) of the fluid below its top.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use bevy_transform::components::Transform;
/// use drystone::fluid::{FluidField, FluidPoint};
/// use drystone::prelude::*;
///
/// fn fill(mut commands: Commands) {
///     // Waves of 12 m, half a metre high, that come along x.
///     let waves = FluidField::new(|at, seconds| {
///         let length = std::f32::consts::TAU / 12.0;
///         FluidPoint { rise: 0.25 * (length * (at.x - 4.3 * seconds)).sin(), ..Default::default() }
///     });
///     // The sensor reaches over the crests.
///     let sea = Fluid { level: Some(0.0), ..Fluid::water() };
///     commands.spawn((Collider::half_space(Vec3::Y), sea, waves, Transform::from_xyz(0.0, 1.0, 0.0)));
/// }
/// ```
#[derive(Component, Clone)]
pub struct FluidField(Arc<Function>);

type Function = dyn Fn(Vec3, f32) -> FluidPoint + Send + Sync;

/// A fluid in one place at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluidPoint {
    /// How much higher than the level of the [`Fluid`](super::Fluid) its surface is here, m. Default: 0.
    pub rise: f32,
    /// What is added to the velocity of the fluid here, world, m/s. Default: zero.
    pub flow: Vec3,
}

impl FluidField {
    /// A field from a function of the place, world, m, and of the time since the fluid came in, s. The surface should not be steeper than
    /// upright. The function is called up to seven times for each collider in a step; the same arguments must always give the same values.
    pub fn new(field: impl Fn(Vec3, f32) -> FluidPoint + Send + Sync + 'static) -> Self {
        Self(Arc::new(field))
    }

    /// The fluid at a place, world, m, at a time, s.
    pub fn at(&self, place: Vec3, seconds: f32) -> FluidPoint {
        (self.0)(place, seconds)
    }
}

impl std::fmt::Debug for FluidField {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FluidField").finish_non_exhaustive()
    }
}
