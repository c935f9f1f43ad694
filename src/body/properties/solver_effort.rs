//! Additional sweeps for the bodies that need them.

use crate::body::{BodyProperties, KeptProperty, limits};
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// How much work the solver puts into a body, as a multiple of the usual number of sweeps, from 1 to [`SolverEffort::MAX`]. Default: 1.
///
/// All bodies that touch each other or are joined are solved together, with the largest effort among them. The number of sweeps grows with
/// the effort up to the maximum of the solver ([`SoftStep::max_sweeps`](crate::solver::SoftStep::max_sweeps)), and so does the time. Walls,
/// stacks and arches need no more than the default; a light body between heavy ones, or a machine that a player looks at closely, may.
/// Other values are an error ([`BodyProblem::InvalidSolverEffort`]).
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// world.spawn((
///     RigidBody::Dynamic,
///     Collider::cuboid(1.0, 1.0, 1.0),
///     Mass(100_000.0),
///     Transform::from_xyz(0.0, 5.0, 0.0),
///     SolverEffort(4.0),
/// ));
/// ```
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct SolverEffort(pub f32);

impl SolverEffort {
    /// The largest effort.
    pub const MAX: f32 = limits::SOLVER_EFFORT;
}

impl Default for SolverEffort {
    fn default() -> Self {
        Self(1.0)
    }
}

impl KeptProperty for SolverEffort {
    fn check(&self) -> Result<(), BodyProblem> {
        match (1.0..=Self::MAX).contains(&self.0) {
            true => Ok(()),
            false => Err(BodyProblem::InvalidSolverEffort),
        }
    }
}

impl BodyProperties {
    /// The multiple of the usual sweeps that this body needs.
    #[inline]
    pub(crate) fn effort(&self) -> f32 {
        self.solver_effort.0
    }
}
