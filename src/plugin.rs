//! The plugins: one for each concern, so that each can be disabled or replaced.
//!
//! [`DrystonePlugins`] adds them all. They may also be added one by one and in any order. All of them need [`StepPlugin`]: without it the
//! app panics at [`Plugin::finish`] with a message that names it, and [`step`](crate::step()) returns [`StepError::MissingPlugin`].

use crate::body::{self, BodyTable, Pending, parts::Unassembled};
use crate::broadphase::{self, Broadphase};
use crate::caster::CasterPlugin;
use crate::character::{CharacterPlugin, CharacterSystems};
use crate::children;
use crate::components::{any_with, init};
use crate::contact::{self, ContactEnded, ContactForce, ContactStarted, Untriggered};
use crate::diagnosis::{BodyError, FoundProblems, ReportedProblems, StepError};
use crate::fluid::FluidPlugin;
use crate::fracture::FracturePlugin;
use crate::graph::{self, ConstraintGraph, Islands, Wakes};
use crate::joint::{BrokenJoints, JointBroke};
use crate::joint_types::{self, JointChanges, JointError, Mortar, Studs};
use crate::mortar::{self, BrokenMortar, MortarBroke};
use crate::pair::{EndedPairs, LostPairs};
use crate::profile::{Profile, own};
use crate::restored::Restored;
use crate::saving;
use crate::schedule::{
    PhysicsSchedule, PhysicsSystems, RefreshSchedule, advance, check_step_plugin, order_stages,
    refresh,
};
use crate::sensor::{self, SensorEntered, SensorExited, Sensors, UntriggeredSensorEvents};
use crate::settings::{
    ActiveSettings, Gravity, NarrowphaseSettings, PhysicsThreads, PhysicsTime, SleepSettings,
    SolverSettings, SpeedLimits, StabilizationSettings, StepTime, uses_point_solver,
};
use crate::solve::SolveReports;
use crate::stabilization::{anchors, friction, normal};
use crate::streaming::{self, Arrivals, Suspended};
use crate::vehicle::VehiclePlugin;
use crate::voxels::{VoxelPlugin, VoxelSystems};
use crate::warm_start::{self, IslandProblems};
use crate::{integration, joint, narrowphase, solve};
use bevy_app::{App, FixedPostUpdate, Plugin, PluginGroup, PluginGroupBuilder, PreUpdate};
use bevy_ecs::component::Components;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::intern::Interned;
use bevy_ecs::message::signal_message_update_system;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::world::DeferredWorld;
use bevy_time::Time;
use bevy_transform::TransformSystems;

/// The plugin group that adds all of drystone. It takes steps in `FixedPostUpdate`, or in the schedule given to [`new`](Self::new).
///
/// Not included, because not every app needs them: [`CollapsePlugin`](crate::collapse::CollapsePlugin),
/// [`HandPlugin`](crate::grab::HandPlugin), and the plugins for gizmos, picking and diagnostics behind the features of those names.
///
/// ```
/// use bevy_app::{App, Update};
/// use drystone::DrystonePlugins;
///
/// App::new().add_plugins(DrystonePlugins::default());
/// App::new().add_plugins(DrystonePlugins::new(Update));
/// ```
#[derive(Debug)]
pub struct DrystonePlugins {
    label: Interned<dyn ScheduleLabel>,
}

impl DrystonePlugins {
    /// Takes a step in each run of this schedule. The length of the step is the delta of the [`Time`] resource in that schedule.
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
        let group = PluginGroupBuilder::start::<Self>()
            .add(StepPlugin { label: self.label })
            .add(BodyPlugin)
            .add(CollisionPlugin)
            .add(FrictionStabilizationPlugin)
            .add(NormalStabilizationPlugin)
            .add(WarmStartPlugin)
            .add(SolverPlugin)
            .add(JointPlugin)
            .add(IntegrationPlugin)
            .add(SleepingPlugin)
            .add(SensorPlugin)
            .add(ContactEventsPlugin)
            .add(RefreshPlugin)
            .add(CharacterPlugin)
            .add(FluidPlugin)
            .add(VehiclePlugin)
            .add(FracturePlugin)
            .add(CasterPlugin)
            .add(VoxelPlugin);
        #[cfg(feature = "mesh")]
        let group = group.add(crate::mesh_colliders::MeshColliderPlugin);
        group
    }
}

/// Adds the [`PhysicsSchedule`], the settings and all other resources of a step, and the system that takes steps. Every other plugin needs
/// it.
#[derive(Debug)]
pub struct StepPlugin {
    /// The schedule in which steps are taken.
    pub label: Interned<dyn ScheduleLabel>,
}

/// The system set in which steps are taken, before `TransformSystems::Propagate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StepSystems;

impl Plugin for StepPlugin {
    fn build(&self, app: &mut App) {
        #[cfg(feature = "bevy_reflect")]
        crate::reflection::register(app);
        let profile = profile(app);
        let world = app.world_mut();
        init::<Gravity>(world);
        init::<StabilizationSettings>(world);
        init::<NarrowphaseSettings>(world);
        init::<SolverSettings>(world);
        init::<SleepSettings>(world);
        init::<SpeedLimits>(world);
        init::<ActiveSettings>(world);
        init::<PhysicsThreads>(world);
        init::<PhysicsTime>(world);
        init::<StepTime>(world);
        init::<FoundProblems>(world);
        init::<ReportedProblems>(world);
        init::<BodyTable>(world);
        init::<Pending>(world);
        init::<Broadphase>(world);
        init::<ConstraintGraph>(world);
        init::<Islands>(world);
        init::<Wakes>(world);
        init::<IslandProblems>(world);
        init::<SolveReports>(world);
        init::<LostPairs>(world);
        init::<EndedPairs>(world);
        init::<Untriggered>(world);
        init::<JointChanges>(world);
        init::<BrokenJoints>(world);
        init::<BrokenMortar>(world);
        init::<contact::MovingSurfaces>(world);
        init::<body::WrittenTransforms>(world);
        init::<Unassembled>(world);
        init::<Sensors>(world);
        init::<UntriggeredSensorEvents>(world);
        init::<Restored>(world);
        init::<Suspended>(world);
        init::<Arrivals>(world);
        app.add_message::<BodyError>()
            .add_message::<StepError>()
            .add_message::<ContactStarted>()
            .add_message::<ContactEnded>()
            .add_message::<ContactForce>()
            .add_message::<JointBroke>()
            .add_message::<JointError>()
            .add_message::<MortarBroke>()
            .add_message::<SensorEntered>()
            .add_message::<SensorExited>()
            // Other plugins may have put systems into the schedule already.
            .edit_schedule(PhysicsSchedule, |schedule| order_stages(schedule, &profile))
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
    let Some(time) = world.get_resource::<Time>() else {
        return;
    };
    let delta = time.delta_secs();
    let physics = world.get_resource_mut::<PhysicsTime>();
    // `next_step` counts requested steps down, and nothing else.
    let delta = physics.map_or(delta, |mut time| {
        time.bypass_change_detection().next_step(delta)
    });
    // Errors have been logged and sent as a message.
    let _ = advance(world, delta);
}

/// The profile with which stages are timed, made by whichever plugin comes first.
fn profile(app: &mut App) -> Profile {
    init::<Profile>(app.world_mut());
    app.world().resource::<Profile>().clone()
}

/// A stage's system, timed and in its set.
macro_rules! stages {
    ($app:expr, $($set:ident: $name:literal $system:expr),+ $(,)?) => {{
        let profile = profile($app);
        $($app.add_systems(
            PhysicsSchedule,
            own(&profile, $name, $system).in_set(PhysicsSystems::$set),
        );)+
    }};
}

/// Adds the stages *prepare* and *forces*: it reads what the user changed, disables bodies with invalid input, and applies forces.
#[derive(Debug)]
pub struct BodyPlugin;

impl Plugin for BodyPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(children::child_joined)
            .add_observer(children::child_left)
            .add_observer(disabled)
            .add_observer(children::child_enabled);
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "prepare", saving::restore).run_if(saving::any_saved),
                own(&profile, "prepare", body::find_written_transforms),
                own(&profile, "prepare", children::assemble),
                own(&profile, "prepare", body::complete),
                own(&profile, "prepare", body::lift)
                    .run_if(any_with(Components::component_id::<body::Quarantined>)),
                own(&profile, "prepare", streaming::arrive).run_if(streaming::any_arrivals),
                own(&profile, "prepare", children::stay).run_if(integration::any_children),
                own(&profile, "prepare", body::prepare),
                own(&profile, "prepare", body::quarantine).run_if(body::any_suspects),
                own(&profile, "prepare", graph::activate).run_if(graph::any_disturbed),
            )
                .chain()
                .in_set(PhysicsSystems::Prepare),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "forces", body::forces),
                own(&profile, "forces", body::quarantine).run_if(body::any_suspects),
            )
                .chain()
                .in_set(PhysicsSystems::Forces),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Observer: an entity was disabled. Its body must be assembled again without it, hands let go of it, and *joints* looks at it.
fn disabled(disabled: On<Insert<Disabled>>, mut world: DeferredWorld) {
    body::mark_if_part(&mut world, disabled.entity);
    body::let_go_of_disabled(&mut world, disabled.entity);
    joint_types::look_at_disabled(&mut world, disabled.entity);
}

/// Adds the stages *broadphase* and *narrowphase*, which find contacts.
#[derive(Debug)]
pub struct CollisionPlugin;

impl Plugin for CollisionPlugin {
    fn build(&self, app: &mut App) {
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "broadphase", broadphase::broadphase),
                own(&profile, "broadphase", graph::pair_changes),
            )
                .chain()
                .in_set(PhysicsSystems::Broadphase),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "narrowphase", narrowphase::narrowphase),
                own(&profile, "narrowphase", narrowphase::crowd),
                own(&profile, "narrowphase", narrowphase::modify_contacts),
            )
                .chain()
                .in_set(PhysicsSystems::Narrowphase),
        );
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "broadphase", broadphase::escaped_aabb)
                .after(PhysicsSystems::Integration)
                .before(CharacterSystems)
                .before(PhysicsSystems::Sleeping),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stages *friction error* and *anchors*. Without this plugin, slip is not corrected and structures creep.
#[derive(Debug)]
pub struct FrictionStabilizationPlugin;

impl Plugin for FrictionStabilizationPlugin {
    fn build(&self, app: &mut App) {
        stages!(
            app,
            FrictionError: "friction_error" friction::friction_error,
            Anchors: "anchors" anchors::anchors,
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *normal correction*, which runs for point solvers only. Without this plugin, such solvers do not correct penetration.
#[derive(Debug)]
pub struct NormalStabilizationPlugin;

impl Plugin for NormalStabilizationPlugin {
    fn build(&self, app: &mut App) {
        let profile = profile(app);
        // Solvers of patches correct distances themselves, anew in each of their substeps.
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "normal_correction", normal::normal_correction)
                .run_if(uses_point_solver)
                .in_set(PhysicsSystems::NormalCorrection),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *warm start*: the problems of islands, and the impulses that they start from. Without it nothing is solved, and bodies
/// fall through each other.
#[derive(Debug)]
pub struct WarmStartPlugin;

impl Plugin for WarmStartPlugin {
    fn build(&self, app: &mut App) {
        stages!(app, WarmStart: "warm_start" warm_start::warm_start);
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stages *islands* and *solve*.
#[derive(Debug)]
pub struct SolverPlugin;

impl Plugin for SolverPlugin {
    fn build(&self, app: &mut App) {
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "islands", graph::islands),
                own(&profile, "islands", graph::activation),
            )
                .chain()
                .in_set(PhysicsSystems::Islands),
        );
        stages!(app, Solve: "solve" solve::solve);
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *joints*, what bonds bodies with fresh [`Mortar`], and what reports joints that break. Without this plugin, joints do
/// nothing.
#[derive(Debug)]
pub struct JointPlugin;

impl Plugin for JointPlugin {
    fn build(&self, app: &mut App) {
        stages!(
            app,
            Joints: "joints" joint::joints,
        );
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "contact_events", joint::joint_events).run_if(joint::any_broke),
                own(&profile, "contact_events", mortar::mortar_events).run_if(mortar::any_broke),
            )
                .in_set(PhysicsSystems::ContactEvents),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "narrowphase", mortar::lay_mortar)
                    .run_if(any_with(Components::component_id::<Mortar>)),
                own(&profile, "narrowphase", mortar::click_studs)
                    .run_if(any_with(Components::component_id::<Studs>)),
            )
                .chain()
                .after(narrowphase::modify_contacts)
                .in_set(PhysicsSystems::Narrowphase),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *integration*, which moves bodies and writes their `Transform`.
#[derive(Debug)]
pub struct IntegrationPlugin;

impl Plugin for IntegrationPlugin {
    fn build(&self, app: &mut App) {
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "integration", integration::integration),
                own(&profile, "integration", integration::child_transforms)
                    .run_if(integration::any_children),
            )
                .chain()
                .in_set(PhysicsSystems::Integration),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *sleeping*. Without this plugin, no body falls asleep.
#[derive(Debug)]
pub struct SleepingPlugin;

impl Plugin for SleepingPlugin {
    fn build(&self, app: &mut App) {
        stages!(app, Sleeping: "sleeping" graph::sleeping);
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *sensors*, which finds the bodies that are inside [sensors](crate::sensor). Without this plugin, sensors detect nothing.
#[derive(Debug)]
pub struct SensorPlugin;

impl Plugin for SensorPlugin {
    fn build(&self, app: &mut App) {
        stages!(app, Sensors: "sensors" sensor::sensors);
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the stage *contact events*, which sends contact messages and keeps [`Load`](crate::contact::Load) up to date.
#[derive(Debug)]
pub struct ContactEventsPlugin;

impl Plugin for ContactEventsPlugin {
    fn build(&self, app: &mut App) {
        let profile = profile(app);
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "contact_events", contact::whole_step)
                    .run_if(contact::any_earlier_substeps),
                own(&profile, "contact_events", contact::loads)
                    .run_if(any_with(Components::component_id::<contact::Load>)),
                own(&profile, "contact_events", contact::contact_events),
                own(&profile, "contact_events", contact::colliding_entities).run_if(any_with(
                    Components::component_id::<contact::CollidingEntities>,
                )),
                own(&profile, "contact_events", contact::contact_forces).run_if(any_with(
                    Components::component_id::<contact::ContactForceEvents>,
                )),
            )
                .chain()
                .in_set(PhysicsSystems::ContactEvents),
        );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

/// Adds the [`RefreshSchedule`], and runs it in `PreUpdate` of every frame, so that queries find bodies that were spawned or moved since
/// the last step.
#[derive(Debug)]
pub struct RefreshPlugin;

/// The system set in `PreUpdate` that runs [`refresh`](crate::refresh()).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RefreshSystems;

impl Plugin for RefreshPlugin {
    fn build(&self, app: &mut App) {
        #[cfg(feature = "mesh")]
        app.configure_sets(
            PreUpdate,
            RefreshSystems.after(crate::mesh_colliders::MeshColliderSystems),
        );
        app.init_schedule(RefreshSchedule)
            .add_systems(
                RefreshSchedule,
                (
                    saving::restore.run_if(saving::any_saved),
                    body::find_written_transforms,
                    children::assemble,
                    body::refresh,
                )
                    .chain()
                    .after(VoxelSystems),
            )
            .add_systems(
                PreUpdate,
                // A system that edits in the same schedule and wants its edits seen at once must run before the set.
                refresh.in_set(RefreshSystems).ambiguous_with_all(),
            );
    }

    fn finish(&self, app: &mut App) {
        check_step_plugin::<Self>(app);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::collider::Collider;
    use crate::body::{Pose, RigidBody};
    use crate::collapse::CollapsePlugin;
    use crate::grab::HandPlugin;
    use crate::schedule::step;
    use bevy_app::Update;
    use bevy_transform::components::Transform;
    use glam::Vec3;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    type Add = fn(&mut App);

    fn step_plugin(app: &mut App) {
        let label = Update.intern();
        app.add_plugins(StepPlugin { label });
    }

    /// Every plugin but `StepPlugin`, by its name.
    const OTHERS: [(&str, Add); 20] = [
        ("BodyPlugin", |app| _ = app.add_plugins(BodyPlugin)),
        ("CollisionPlugin", |app| {
            _ = app.add_plugins(CollisionPlugin)
        }),
        ("FrictionStabilizationPlugin", |app| {
            _ = app.add_plugins(FrictionStabilizationPlugin)
        }),
        ("NormalStabilizationPlugin", |app| {
            _ = app.add_plugins(NormalStabilizationPlugin)
        }),
        ("WarmStartPlugin", |app| {
            _ = app.add_plugins(WarmStartPlugin)
        }),
        ("SolverPlugin", |app| _ = app.add_plugins(SolverPlugin)),
        ("JointPlugin", |app| _ = app.add_plugins(JointPlugin)),
        ("IntegrationPlugin", |app| {
            _ = app.add_plugins(IntegrationPlugin)
        }),
        ("SleepingPlugin", |app| _ = app.add_plugins(SleepingPlugin)),
        ("SensorPlugin", |app| _ = app.add_plugins(SensorPlugin)),
        ("ContactEventsPlugin", |app| {
            _ = app.add_plugins(ContactEventsPlugin)
        }),
        ("RefreshPlugin", |app| _ = app.add_plugins(RefreshPlugin)),
        ("CharacterPlugin", |app| {
            _ = app.add_plugins(CharacterPlugin)
        }),
        ("FluidPlugin", |app| _ = app.add_plugins(FluidPlugin)),
        ("VehiclePlugin", |app| _ = app.add_plugins(VehiclePlugin)),
        ("FracturePlugin", |app| _ = app.add_plugins(FracturePlugin)),
        ("CasterPlugin", |app| _ = app.add_plugins(CasterPlugin)),
        ("VoxelPlugin", |app| _ = app.add_plugins(VoxelPlugin)),
        ("CollapsePlugin", |app| _ = app.add_plugins(CollapsePlugin)),
        ("HandPlugin", |app| _ = app.add_plugins(HandPlugin)),
    ];

    /// Three bricks dropped onto each other askew: their poses after a second.
    fn play(app: &mut App) -> Vec<Pose> {
        app.finish();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let brick = |i: usize| {
            let at = Transform::from_xyz(0.1 * i as f32, 0.3 + 0.6 * i as f32, 0.0);
            (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)
        };
        let bricks = [0, 1, 2].map(|i| world.spawn(brick(i)).id());
        for _ in 0..60 {
            step(world, 1.0 / 60.0).unwrap();
        }
        bricks
            .map(|brick| *world.get::<Pose>(brick).unwrap())
            .to_vec()
    }

    /// The last orders put systems into the schedule before `StepPlugin` makes it; each but the first used to panic, or to lose them.
    #[test]
    fn plugins_take_the_same_steps_in_any_order() {
        let mut usual = App::new();
        usual.add_plugins((DrystonePlugins::new(Update), CollapsePlugin, HandPlugin));
        let expected = play(&mut usual);
        let systems = |app: &App| app.get_schedule(PhysicsSchedule).unwrap().systems_len();
        let count = systems(&usual);
        assert!((expected[2].position.y - 1.25).abs() < 0.01, "{expected:?}");
        for first in [0, 1, 5, OTHERS.len()] {
            let mut app = App::new();
            OTHERS[..first]
                .iter()
                .rev()
                .for_each(|(_, add)| add(&mut app));
            step_plugin(&mut app);
            OTHERS[first..]
                .iter()
                .rev()
                .for_each(|(_, add)| add(&mut app));
            assert_eq!(play(&mut app), expected, "{first} before `StepPlugin`");
            assert_eq!(systems(&app), count, "{first} before `StepPlugin`");
        }
    }

    /// A game may replace a stage, or do without it.
    #[test]
    fn any_plugin_but_the_step_plugin_may_be_left_out() {
        for (left_out, _) in OTHERS {
            let mut app = App::new();
            step_plugin(&mut app);
            let others = OTHERS.iter().filter(|(name, _)| *name != left_out);
            others.for_each(|(_, add)| add(&mut app));
            let poses = play(&mut app);
            assert!(poses.iter().all(Pose::is_finite), "without {left_out}");
            let comes_down = poses[2].position.y < 1.45;
            let nothing_moves = ["BodyPlugin", "IntegrationPlugin"].contains(&left_out);
            assert!(comes_down || nothing_moves, "without {left_out}: {poses:?}");
        }
    }

    #[test]
    fn a_plugin_without_the_step_plugin_says_so() {
        for (name, add) in OTHERS {
            let mut app = App::new();
            add(&mut app);
            let panicked = catch_unwind(AssertUnwindSafe(|| app.finish())).unwrap_err();
            let message = panicked.downcast_ref::<String>().unwrap();
            let expected = format!("`{name}` needs `StepPlugin`");
            assert!(message.starts_with(&expected), "{name}: {message}");
        }
    }

    #[test]
    fn a_step_without_the_step_plugin_is_an_error() {
        let missing = Err(StepError::MissingPlugin("StepPlugin"));
        let mut app = App::new();
        assert_eq!(step(app.world_mut(), 0.01), missing);
        assert_eq!(advance(app.world_mut(), 0.01), missing);
        refresh(app.world_mut());
        app.add_plugins((BodyPlugin, SolverPlugin, RefreshPlugin));
        assert_eq!(step(app.world_mut(), 0.01), missing);
        refresh(app.world_mut());
        step_plugin(&mut app);
        assert_eq!(step(app.world_mut(), 0.01), Ok(()));
        refresh(app.world_mut());
    }
}
