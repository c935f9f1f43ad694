//! The order of a step stands here, and only here.
//!
//! Every stage is a module, a system and a set of the same name. Put your own systems between sets with
//! `.after(PhysicsSystems::NormalCorrection).before(PhysicsSystems::Forces)`; replace one by taking its plugin out of
//! [`DrystonePlugins`](crate::DrystonePlugins) and adding a system of your own to its set.

use crate::collapse::{Collapse, CollapseEnded};
use crate::contact::{ContactEnded, ContactForce, ContactStarted};
use crate::diagnosis::{BodyError, StepError};
use crate::profile::Profile;
use crate::settings::{self, SolverSettings, StepTime};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy_platform::time::Instant;

/// The schedule of one step (of one substep, where there are several). Runs single-threaded; the parallelism is inside
/// the systems.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsSchedule;

/// The schedule of a [`refresh`]: what brings answers up to date without a step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct RefreshSchedule;

/// The stages of a step, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhysicsSystems {
    /// Reads what the user changed, checks it, fills the [`BodyTable`](crate::body::BodyTable).
    Prepare,
    /// Begins and ends contact pairs.
    Broadphase,
    /// Contact points at xᵗ, matched with those before.
    Narrowphase,
    /// Links bodies that push on each other, finds what stands on what, and wakes what must not sleep on.
    Islands,
    /// e and c_t, equations (11)–(15).
    FrictionError,
    /// c_n, equations (1)–(9).
    NormalCorrection,
    /// v += Δt M⁻¹ f.
    Forces,
    /// The problem of each island, and the λ that it starts from.
    WarmStart,
    /// λ and v, island by island.
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
        Self::Islands,
        Self::FrictionError,
        Self::NormalCorrection,
        Self::Forces,
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
    for [earlier, later] in PhysicsSystems::ORDER.array_windows() {
        schedule.configure_sets(earlier.before(*later));
    }
    schedule
}

/// How long a step may be, s. Shorter ones can't be divided by in single precision, longer ones are none.
pub const LENGTHS: std::ops::RangeInclusive<f32> = 1e-7..=60.0;

/// Takes a step of `dt` seconds in a world without an app around it, whose every step is a frame: messages of drystone's live until
/// the step after the next, and the world forgets what was removed ([`World::clear_trackers`]). Zero is a pause.
///
/// In an app the plugin takes steps, and the app does the rest.
///
/// # Errors
/// [`StepError::InvalidTimeStep`] (also sent as a message and logged) where `dt` is negative, not finite or not in [`LENGTHS`]; nothing
/// moves then.
pub fn step(world: &mut World, dt: f32) -> Result<(), StepError> {
    world.resource_mut::<Messages<BodyError>>().update();
    world.resource_mut::<Messages<StepError>>().update();
    world.resource_mut::<Messages<ContactStarted>>().update();
    world.resource_mut::<Messages<ContactEnded>>().update();
    world.resource_mut::<Messages<ContactForce>>().update();
    if let Some(mut collapses) = world.get_resource_mut::<Messages<Collapse>>() {
        collapses.update();
    }
    if let Some(mut collapses) = world.get_resource_mut::<Messages<CollapseEnded>>() {
        collapses.update();
    }
    let result = advance(world, dt);
    world.clear_trackers();
    result
}

/// Takes a step of `dt` seconds, in as many substeps as [`SolverSettings`] asks for, and nothing else: for who steps by hand inside an
/// app, or clears messages in a way of their own.
///
/// # Errors
/// As [`step`].
pub fn advance(world: &mut World, dt: f32) -> Result<(), StepError> {
    if dt == 0.0 {
        return Ok(());
    }
    if !LENGTHS.contains(&dt) {
        let error = StepError::InvalidTimeStep(dt);
        tracing::error!("{error}");
        world.write_message(error.clone());
        return Err(error);
    }
    let start = Instant::now();
    settings::check(world);
    let substeps = world.resource::<SolverSettings>().outer_substeps;
    for substep in 0..substeps {
        let before = *world.resource::<StepTime>();
        world.insert_resource(before.next(dt, substep, substeps));
        world.run_schedule(PhysicsSchedule);
    }
    crate::contact::trigger(world);
    world.resource_mut::<Profile>().end_step(start.elapsed());
    Ok(())
}

/// Brings answers up to date without a step: from now on [`SpatialQuery`](crate::query::SpatialQuery) finds bodies that were spawned since the
/// last step, and finds those that were moved or changed where and as they are now. Nothing moves, and the simulation goes on to the same
/// bits as without it.
///
/// The plugin does this in every frame in which time stands still, in `PreUpdate`. Do it yourself to ask in the frame of an edit: it is a
/// system, to be put between the one that edits and the one that asks. It runs the [`RefreshSchedule`], and costs as much as bodies
/// are active or have been written to.
///
/// ```
/// # use bevy_app::{App, Update};
/// # use bevy_ecs::prelude::*;
/// # use drystone::prelude::*;
/// # fn lay_bricks() {}
/// # fn look_around() {}
/// # let mut app = App::new();
/// app.add_plugins(DrystonePlugins::default())
///     .add_systems(Update, (lay_bricks, drystone::refresh, look_around).chain());
/// ```
pub fn refresh(world: &mut World) {
    world.run_schedule(RefreshSchedule);
}
