//! The order of a step stands here, and only here.
//!
//! Every stage is a module, a system and a set of the same name. Put your own systems between sets with
//! `.after(PhysicsSystems::NormalCorrection).before(PhysicsSystems::Forces)`; replace one by taking its plugin out of
//! [`DrystonePlugins`](crate::DrystonePlugins) and adding a system of your own to its set.

use crate::diagnosis::StepError;
use crate::profile::Profile;
use crate::settings::{SolverSettings, StepTime};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use std::time::Instant;

/// The schedule of one step (of one substep, where there are several). Runs single-threaded; the parallelism is inside
/// the systems.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsSchedule;

/// The stages of a step, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhysicsSystems {
    /// Reads what the user changed, checks it, fills the [`BodyTable`](crate::body::BodyTable).
    Prepare,
    /// Begins and ends contact pairs.
    Broadphase,
    /// Contact points at xᵗ, matched with those before.
    Narrowphase,
    /// e and c_t, equations (11)–(15).
    FrictionError,
    /// c_n, equations (1)–(9).
    NormalCorrection,
    /// v += Δt M⁻¹ f.
    Forces,
    /// Groups bodies, gathers the solver's problems.
    Islands,
    /// λ from the last step.
    WarmStart,
    /// λ and v.
    Solve,
    /// Equation (10) with the λ just found; writes or deletes anchors.
    Anchors,
    /// xᵗ⁺¹ = xᵗ + Δt v.
    Integration,
    /// Puts islands at rest to sleep.
    Sleeping,
    /// Tells who began and ceased to touch.
    ContactEvents,
}

impl PhysicsSystems {
    /// All of them, in the order in which they run.
    pub const ORDER: [Self; 13] = [
        Self::Prepare,
        Self::Broadphase,
        Self::Narrowphase,
        Self::FrictionError,
        Self::NormalCorrection,
        Self::Forces,
        Self::Islands,
        Self::WarmStart,
        Self::Solve,
        Self::Anchors,
        Self::Integration,
        Self::Sleeping,
        Self::ContactEvents,
    ];
}

/// An empty [`PhysicsSchedule`] with its sets in order.
pub(crate) fn physics_schedule() -> Schedule {
    let mut schedule = Schedule::new(PhysicsSchedule);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    });
    for [earlier, later] in PhysicsSystems::ORDER.array_windows() {
        schedule.configure_sets(earlier.before(*later));
    }
    schedule
}

/// Advances physics by `dt` seconds, in as many substeps as [`SolverSettings`] asks for.
///
/// The plugin calls this from its schedule; a headless user may call it directly. Zero is a pause.
///
/// # Errors
/// [`StepError::InvalidTimeStep`] (also sent as a message and logged) where `dt` is negative or not finite; nothing moves
/// then.
pub fn step(world: &mut World, dt: f32) -> Result<(), StepError> {
    if !dt.is_finite() || dt < 0.0 {
        let error = StepError::InvalidTimeStep(dt);
        tracing::error!("{error}");
        world.write_message(error);
        return Err(error);
    }
    if dt == 0.0 {
        return Ok(());
    }
    let start = Instant::now();
    let substeps = world.resource::<SolverSettings>().substeps.max(1);
    world.insert_resource(StepTime {
        dt: dt / substeps as f32,
    });
    for _ in 0..substeps {
        world.run_schedule(PhysicsSchedule);
    }
    crate::contact::trigger(world);
    world.resource_mut::<Profile>().end_step(start.elapsed());
    Ok(())
}
