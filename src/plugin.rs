//! The plugins: one for each concern, so that each can be taken out or replaced.

use crate::body::{self, BodyTable, Pending};
use crate::broadphase::{self, Broadphase};
use crate::contact::{self, ContactEnded, ContactForce, ContactStarted, EndedPairs, Untriggered};
use crate::diagnosis::{BodyError, StepError, Suspects, Told};
use crate::islands::Islands;
use crate::profile::{Profile, timed};
use crate::schedule::{
    PhysicsSchedule, PhysicsSystems, RefreshSchedule, advance, physics_schedule, refresh,
};
use crate::settings::{
    Gravity, InForce, NarrowphaseSettings, PhysicsThreads, SleepSettings, SolverSettings,
    SpeedLimits, StabilizationSettings, StepTime, solves_points,
};
use crate::solve::SolveReports;
use crate::stabilization::{anchors, friction, normal};
use crate::{grab, integration, islands, narrowphase, solve};
use bevy_app::{App, FixedPostUpdate, Plugin, PluginGroup, PluginGroupBuilder, PreUpdate};
use bevy_ecs::intern::Interned;
use bevy_ecs::message::signal_message_update_system;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_time::{Time, Virtual};
use bevy_transform::TransformSystems;

/// All of drystone, run in `FixedPostUpdate` or any other schedule.
///
/// ```
/// use bevy_app::{App, Update};
/// use drystone::DrystonePlugins;
///
/// App::new().add_plugins(DrystonePlugins::default());
/// App::new().add_plugins(DrystonePlugins::new(Update));
/// ```
pub struct DrystonePlugins {
    label: Interned<dyn ScheduleLabel>,
}

impl DrystonePlugins {
    /// Steps in this schedule, by the `Time` that it sees.
    pub fn new(label: impl ScheduleLabel) -> Self {
        Self {
            label: label.intern(),
        }
    }
}

impl Default for DrystonePlugins {
    fn default() -> Self {
        Self::new(FixedPostUpdate)
    }
}

impl PluginGroup for DrystonePlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(StepPlugin { label: self.label })
            .add(BodyPlugin)
            .add(CollisionPlugin)
            .add(FrictionStabilizationPlugin)
            .add(NormalStabilizationPlugin)
            .add(SolverPlugin)
            .add(IntegrationPlugin)
            .add(SleepingPlugin)
            .add(ContactEventsPlugin)
            .add(RefreshPlugin)
    }
}

/// The schedule, its resources, and what runs it.
pub struct StepPlugin {
    /// Where steps are taken.
    pub label: Interned<dyn ScheduleLabel>,
}

/// The set in which steps are taken, before transforms are propagated.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StepSystems;

impl Plugin for StepPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Gravity>()
            .init_resource::<StabilizationSettings>()
            .init_resource::<NarrowphaseSettings>()
            .init_resource::<SolverSettings>()
            .init_resource::<SleepSettings>()
            .init_resource::<SpeedLimits>()
            .init_resource::<InForce>()
            .init_resource::<PhysicsThreads>()
            .init_resource::<StepTime>()
            .init_resource::<Profile>()
            .init_resource::<Suspects>()
            .init_resource::<Told>()
            .init_resource::<BodyTable>()
            .init_resource::<Pending>()
            .init_resource::<Broadphase>()
            .init_resource::<Islands>()
            .init_resource::<SolveReports>()
            .init_resource::<EndedPairs>()
            .init_resource::<Untriggered>()
            .add_message::<BodyError>()
            .add_message::<StepError>()
            .add_message::<ContactStarted>()
            .add_message::<ContactEnded>()
            .add_message::<ContactForce>()
            .add_schedule(physics_schedule())
            .add_systems(
                self.label,
                take_step
                    .in_set(StepSystems)
                    .before(TransformSystems::Propagate)
                    // It only says that messages may be updated, which happens elsewhere.
                    .ambiguous_with(signal_message_update_system),
            );
    }
}

fn take_step(world: &mut World) {
    if let Some(time) = world.get_resource::<Time>() {
        // What went wrong has been logged and sent as a message.
        let _ = advance(world, time.delta_secs());
    }
}

/// A stage's system, timed and in its set.
macro_rules! stages {
    ($app:expr, $($set:ident: $name:literal $system:expr),+ $(,)?) => {{
        let profile = $app.world().resource::<Profile>().clone();
        $($app.add_systems(
            PhysicsSchedule,
            timed(&profile, $name, $system).in_set(PhysicsSystems::$set),
        );)+
    }};
}

/// Prepare, quarantine, forces, hands.
pub struct BodyPlugin;

impl Plugin for BodyPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(body::lost_parent)
            .add_observer(grab::let_go_of_disabled);
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "prepare", body::complete),
                timed(&profile, "prepare", body::lift),
                timed(&profile, "prepare", body::prepare),
                timed(&profile, "prepare", body::strays),
                timed(&profile, "prepare", body::quarantine),
                timed(&profile, "prepare", islands::rouse),
            )
                .chain()
                .in_set(PhysicsSystems::Prepare),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "forces", body::forces),
                timed(&profile, "forces", body::quarantine),
            )
                .chain()
                .in_set(PhysicsSystems::Forces),
        );
    }
}

/// Broadphase and narrowphase.
pub struct CollisionPlugin;

impl Plugin for CollisionPlugin {
    fn build(&self, app: &mut App) {
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "broadphase", broadphase::broadphase),
                timed(&profile, "broadphase", broadphase::pair_changes),
            )
                .chain()
                .in_set(PhysicsSystems::Broadphase),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "narrowphase", narrowphase::narrowphase),
                timed(&profile, "narrowphase", narrowphase::crowd),
            )
                .chain()
                .in_set(PhysicsSystems::Narrowphase),
        );
        app.add_systems(
            PhysicsSchedule,
            timed(&profile, "broadphase", broadphase::escaped_aabb)
                .after(PhysicsSystems::Integration)
                .before(PhysicsSystems::Sleeping),
        );
    }
}

/// Friction error and anchors. Without it no slip is corrected.
pub struct FrictionStabilizationPlugin;

impl Plugin for FrictionStabilizationPlugin {
    fn build(&self, app: &mut App) {
        stages!(
            app,
            FrictionError: "friction_error" friction::friction_error,
            Anchors: "anchors" anchors::anchors,
        );
    }
}

/// Normal correction, for solvers of points. Without it contacts bound velocities only, and penetration creeps in.
pub struct NormalStabilizationPlugin;

impl Plugin for NormalStabilizationPlugin {
    fn build(&self, app: &mut App) {
        let profile = app.world().resource::<Profile>().clone();
        // Solvers of patches correct distances themselves, anew in each of their substeps.
        app.add_systems(
            PhysicsSchedule,
            timed(&profile, "normal_correction", normal::normal_correction)
                .run_if(solves_points)
                .in_set(PhysicsSystems::NormalCorrection),
        );
    }
}

/// Islands, solve.
pub struct SolverPlugin;

impl Plugin for SolverPlugin {
    fn build(&self, app: &mut App) {
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "islands", islands::islands),
                timed(&profile, "islands", islands::regroup),
            )
                .chain()
                .in_set(PhysicsSystems::Islands),
        );
        stages!(app, Solve: "solve" solve::solve);
    }
}

/// Integration and `Transform` out.
pub struct IntegrationPlugin;

impl Plugin for IntegrationPlugin {
    fn build(&self, app: &mut App) {
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "integration", integration::integration),
                timed(&profile, "integration", integration::child_transforms),
            )
                .chain()
                .in_set(PhysicsSystems::Integration),
        );
    }
}

/// Sleeping.
pub struct SleepingPlugin;

impl Plugin for SleepingPlugin {
    fn build(&self, app: &mut App) {
        stages!(app, Sleeping: "sleeping" islands::sleeping);
    }
}

/// Contact events.
pub struct ContactEventsPlugin;

impl Plugin for ContactEventsPlugin {
    fn build(&self, app: &mut App) {
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                timed(&profile, "contact_events", contact::whole_step),
                timed(&profile, "contact_events", contact::loads),
                timed(&profile, "contact_events", contact::contact_events),
                timed(&profile, "contact_events", contact::contact_forces),
            )
                .chain()
                .in_set(PhysicsSystems::ContactEvents),
        );
    }
}

/// What brings answers up to date without a step: the [`RefreshSchedule`], and its run in every frame in which time stands still.
pub struct RefreshPlugin;

/// The set in which answers are brought up to date while time stands still, in `PreUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RefreshSystems;

impl Plugin for RefreshPlugin {
    fn build(&self, app: &mut App) {
        app.init_schedule(RefreshSchedule)
            .add_systems(RefreshSchedule, body::refresh)
            .add_systems(
                PreUpdate,
                // Who edits in the same schedule and wants it seen at once has to be put before the set.
                refresh
                    .run_if(time_stands_still)
                    .in_set(RefreshSystems)
                    .ambiguous_with_all(),
            );
    }
}

fn time_stands_still(time: Option<Res<Time<Virtual>>>) -> bool {
    time.is_some_and(|time| time.delta().is_zero())
}
