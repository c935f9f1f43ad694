//! The order of a step. It is defined here, and only here.
//!
//! Every stage is a module, a system and a set of the same name. To run your own system between two stages, put it between their sets:
//! `.after(PhysicsSystems::NormalCorrection).before(PhysicsSystems::Forces)`. To replace a stage, disable its plugin in
//! [`DrystonePlugins`](crate::DrystonePlugins) and add your own system to its set.

use crate::contact::{self, ContactEnded, ContactForce, ContactStarted};
use crate::diagnosis::{BodyError, StepError};
use crate::joint::{self, JointBroke};
use crate::joint_types::JointError;
use crate::mortar::{self, MortarBroke};
use crate::profile::{Ends, Profile};
use crate::sensor::{self, SensorEntered, SensorExited};
pub use crate::settings::STEP_LENGTHS;
use crate::settings::{self, PhysicsThreads, SolverSettings, StepTime};
use bevy_app::{App, Plugin};
use bevy_ecs::error::{BevyError, ErrorContext};
use bevy_ecs::message::{Message, Messages};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{
    ApplyDeferred, ScheduleLabel, SingleThreadedExecutor, SystemExecutor, SystemSchedule,
};
use bevy_ecs::system::ScheduleSystem;
use bevy_platform::time::Instant;
use fixedbitset::FixedBitSet;
use std::any::TypeId;
use std::sync::Arc;

/// The schedule of one step, or of one substep if there are several. It runs single-threaded; the systems in it are parallel inside.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsSchedule;

/// The schedule of a [`refresh`], which updates queries without a step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct RefreshSchedule;

/// The system sets of the stages of a step, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhysicsSystems {
    /// Reads and checks the components that the user changed, and fills the [`BodyTable`](crate::body::BodyTable).
    Prepare,
    /// Reads and checks joints, and adds and removes their edges.
    Joints,
    /// Adds and removes contact pairs.
    Broadphase,
    /// Computes the contact points at xᵗ, and matches them with the previous ones.
    Narrowphase,
    /// Groups bodies that touch into islands, finds which body stands on which, and wakes sleeping bodies that were disturbed.
    Islands,
    /// Measures the slip e and the correction c_t, equations (11)–(15).
    FrictionError,
    /// Computes the correction c_n, equations (1)–(9).
    NormalCorrection,
    /// Applies forces: v += Δt M⁻¹ f.
    Forces,
    /// Prepares the problem of each island, and the impulses λ that it starts from: those of the last step.
    WarmStart,
    /// Computes impulses λ and velocities v of each island.
    Solve,
    /// Classifies contacts by their new impulses, equation (10), and writes or deletes anchors.
    Anchors,
    /// Moves the bodies: xᵗ⁺¹ = xᵗ + Δt v.
    Integration,
    /// Puts islands that are at rest to sleep.
    Sleeping,
    /// Finds which bodies are inside sensors.
    Sensors,
    /// Sends messages and events about contacts that have begun, ended or carried a force.
    ContactEvents,
}

impl PhysicsSystems {
    /// All sets, in the order in which they run.
    pub const ORDER: [Self; 15] = [
        Self::Prepare,
        Self::Joints,
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
        Self::Sensors,
        Self::ContactEvents,
    ];
}

/// Puts the sets of a [`PhysicsSchedule`] in order, whatever systems are in it already.
pub(crate) fn order_stages(schedule: &mut Schedule, profile: &Profile) {
    schedule.set_executor(StepExecutor {
        executor: SingleThreadedExecutor::new(),
        ends: profile.ends().clone(),
    });
    for [earlier, later] in PhysicsSystems::ORDER.array_windows() {
        schedule.configure_sets(earlier.before(*later));
    }
}

/// Messages of plugins beside the step, which [`step`] updates as an app does by itself.
#[derive(Resource, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct StepMessages(Vec<fn(&mut World)>);

impl StepMessages {
    /// Messages of this kind live until the step after the next, too.
    pub(crate) fn add<M: Message>(&mut self) {
        self.0.push(|world| {
            if let Some(mut messages) = world.get_resource_mut::<Messages<M>>() {
                messages.update();
            }
        });
    }
}

/// Functions of plugins beside the step, which run after it, when its own observers have run.
#[derive(Resource, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct AfterStep(pub Vec<fn(&mut World)>);

/// Functions that run before and after the stages of every step, while the world is recorded.
#[cfg(feature = "serde")]
#[derive(Resource, Clone, Copy)]
#[component(clone_behavior = Ignore)]
pub(crate) struct AroundStep {
    /// Is told the length of the step, s.
    pub before: fn(&mut World, f32),
    /// Runs before observers of the step.
    pub after: fn(&mut World),
}

/// Takes a step of `dt` seconds in a world without an app. The step is a frame of its own: drystone's messages are kept until the step
/// after the next, and removal detection is reset ([`World::clear_trackers`]). A `dt` of 0 takes no step.
///
/// In an app the plugin takes steps, and the app does the rest; use [`advance`] there to take steps by hand.
///
/// # Errors
/// [`StepError::InvalidTimeStep`] if `dt` is negative, not finite or not in [`STEP_LENGTHS`]; nothing moves then. It is also logged and
/// sent as a message. [`StepError::MissingPlugin`] if [`StepPlugin`](crate::StepPlugin) was not added; it is also logged.
pub fn step(world: &mut World, dt: f32) -> Result<(), StepError> {
    check_plugins(world)?;
    world.resource_mut::<Messages<BodyError>>().update();
    world.resource_mut::<Messages<StepError>>().update();
    world.resource_mut::<Messages<ContactStarted>>().update();
    world.resource_mut::<Messages<ContactEnded>>().update();
    world.resource_mut::<Messages<ContactForce>>().update();
    world.resource_mut::<Messages<JointBroke>>().update();
    world.resource_mut::<Messages<JointError>>().update();
    world.resource_mut::<Messages<MortarBroke>>().update();
    world.resource_mut::<Messages<SensorEntered>>().update();
    world.resource_mut::<Messages<SensorExited>>().update();
    run_all(world, |others: &StepMessages| &others.0);
    let result = advance(world, dt);
    world.clear_trackers();
    result
}

/// Calls the functions that plugins have put into a resource.
fn run_all<R: Resource>(world: &mut World, list: impl Fn(&R) -> &[fn(&mut World)]) {
    for i in 0.. {
        let run = world.get_resource().and_then(|all| list(all).get(i));
        let Some(run) = run else {
            return;
        };
        run(world);
    }
}

/// Checks that [`StepPlugin`](crate::StepPlugin) has been added.
fn check_plugins(world: &World) -> Result<(), StepError> {
    if world.contains_resource::<StepTime>() {
        return Ok(());
    }
    let error = StepError::MissingPlugin("StepPlugin");
    tracing::error!("{error}");
    Err(error)
}

/// Takes a step of `dt` seconds, in as many substeps as [`SolverSettings`] asks for, and does nothing else. For apps that take steps by
/// hand, or that clear messages themselves.
///
/// # Errors
/// As [`step`].
pub fn advance(world: &mut World, dt: f32) -> Result<(), StepError> {
    check_plugins(world)?;
    if dt == 0.0 {
        return Ok(());
    }
    if !STEP_LENGTHS.contains(&dt) {
        let error = StepError::InvalidTimeStep(dt);
        tracing::error!("{error}");
        world.write_message(error.clone());
        return Err(error);
    }
    let start = Instant::now();
    #[cfg(feature = "serde")]
    let around = world.get_resource::<AroundStep>().copied();
    #[cfg(feature = "serde")]
    if let Some(around) = around {
        (around.before)(world, dt);
    }
    contact::note_hooks(world);
    settings::check(world);
    let substeps = world.resource::<SolverSettings>().outer_substeps;
    for substep in 0..substeps {
        let mut time = world.resource_mut::<StepTime>();
        *time = time.next(dt, substep, substeps);
        let may_change_threads = MayChangeThreads(may_change_threads(world));
        if world.get_resource::<MayChangeThreads>() != Some(&may_change_threads) {
            world.insert_resource(may_change_threads);
        }
        world.run_schedule(PhysicsSchedule);
        let profile = world.resource::<Profile>();
        if profile.ends().all_own().is_none() {
            profile
                .ends()
                .set_all_own(Some(has_only_own_systems(world)));
        }
    }
    #[cfg(feature = "serde")]
    if let Some(around) = around {
        (around.after)(world);
    }
    contact::trigger(world);
    joint::trigger(world);
    mortar::trigger(world);
    sensor::trigger(world);
    run_all(world, |after: &AfterStep| &after.0);
    world.resource_mut::<Profile>().end_step(start.elapsed());
    Ok(())
}

/// Runs one system after the other; in a large step, on a thread of the pool of [`PhysicsThreads`].
struct StepExecutor {
    executor: SingleThreadedExecutor,
    ends: Arc<Ends>,
}

impl SystemExecutor for StepExecutor {
    fn init(&mut self, schedule: &SystemSchedule) {
        self.executor.init(schedule);
        self.ends.set_all_own(None);
    }

    fn run(
        &mut self,
        schedule: &mut SystemSchedule,
        world: &mut World,
        skip: Option<&FixedBitSet>,
        error_handler: fn(BevyError, ErrorContext),
    ) {
        let may_change = world.get_resource::<MayChangeThreads>();
        let may_change = may_change.is_some_and(|may_change| may_change.0);
        let threads = world.get_resource::<PhysicsThreads>();
        let threads = threads.filter(|_| may_change).cloned();
        let Self { executor, ends } = self;
        let mut run = || {
            ends.begin_run();
            executor.run(schedule, world, skip, error_handler);
            ends.end_run();
        };
        match threads {
            Some(threads) => threads.run_step(run),
            None => run(),
        }
    }

    fn set_apply_final_deferred(&mut self, value: bool) {
        self.executor.set_apply_final_deferred(value);
    }
}

/// The result of [`may_change_threads`] for the step.
#[derive(Resource, PartialEq)]
struct MayChangeThreads(bool);

/// Whether a step may run on another thread than this one: work of the last step was divided, and no system needs this thread, as one of
/// the user's may. (Run conditions are not looked at.)
fn may_change_threads(world: &World) -> bool {
    let threads = world.get_resource::<PhysicsThreads>();
    // Systems are looked at only if it matters: small steps take some microseconds.
    threads.is_some_and(PhysicsThreads::has_divided)
        && all_systems(world, |system, is_own| {
            // Bevy counts exclusive systems as bound to a thread.
            is_own || system.is_send()
        })
}

/// Whether only drystone's own systems are in the [`PhysicsSchedule`].
fn has_only_own_systems(world: &World) -> bool {
    all_systems(world, |_, is_own| is_own)
}

/// Whether something holds for all systems of the [`PhysicsSchedule`], of which some are drystone's own. False if they are not known yet.
fn all_systems(world: &World, holds: impl Fn(&ScheduleSystem, bool) -> bool) -> bool {
    let schedules = world.get_resource::<Schedules>();
    let schedule = schedules.and_then(|schedules| schedules.get(PhysicsSchedule));
    let systems = schedule.and_then(|schedule| schedule.systems().ok());
    let profile = world.resource::<Profile>();
    // Points where commands are applied.
    let applies = TypeId::of::<ApplyDeferred>();
    systems.is_some_and(|mut systems| {
        systems.all(|(_, system)| {
            let found = system.system_type();
            holds(system, found == applies || profile.is_own(found))
        })
    })
}

/// Updates spatial queries without a step. From then on [`SpatialQuery`](crate::query::SpatialQuery) finds bodies that were spawned since
/// the last step, and finds bodies that were moved or changed as they are now. Nothing moves, and the simulation continues with the same
/// bits as without the refresh.
///
/// The plugin does this in `PreUpdate` of every frame, and [`spatial_query`](crate::query::spatial_query) does it before it asks. Only a
/// system that queries in the same frame as an edit needs more: this function is a system, so put it between the two. It runs the
/// [`RefreshSchedule`]. It costs 1 to 4 % of a step of bodies that move, and as much as a step of a world that is asleep (0.04 ms for
/// 100 000 bodies). Without [`StepPlugin`](crate::StepPlugin) or [`RefreshPlugin`](crate::RefreshPlugin) it only logs an error.
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
    if !world.contains_resource::<StepTime>() {
        tracing::error!("nothing is refreshed: `StepPlugin` is missing");
    } else if world.try_run_schedule(RefreshSchedule).is_err() {
        tracing::error!("nothing is refreshed: `RefreshPlugin` is missing");
    }
}

/// Updates spatial queries, unless a step is running or [`RefreshPlugin`](crate::RefreshPlugin) is missing.
pub(crate) fn refresh_between_steps(world: &mut World) {
    // The world does not have a schedule that is running.
    let schedules = world.get_resource::<Schedules>();
    if schedules.is_some_and(|schedules| schedules.contains(PhysicsSchedule)) {
        _ = world.try_run_schedule(RefreshSchedule);
    }
}

/// Checks at [`Plugin::finish`], when all plugins are there, that the resources of a step exist.
///
/// # Panics
/// With a sentence that names [`StepPlugin`](crate::StepPlugin) if they do not.
pub(crate) fn check_step_plugin<P: Plugin>(app: &App) {
    let path = std::any::type_name::<P>();
    let name = path.rsplit("::").next().unwrap_or(path);
    assert!(
        app.world().contains_resource::<StepTime>(),
        "`{name}` needs `StepPlugin`, which adds the schedule and the resources of a step: add `DrystonePlugins`, or `StepPlugin` as well"
    );
}
