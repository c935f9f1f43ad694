//! The types that are registered for reflection: all public components, resources, settings and messages, and the types in their fields.
//!
//! Types that are only names here are opaque and cannot be inserted through reflection: they belong to one world, hold code or threads, or are
//! computed in every step. So a scene that is saved does not contain them.

use crate::body::{self, Inactive, Quarantined, RigidBodyDisabled, Teleport};
use crate::broadphase::Broadphase;
use crate::children::{ColliderOf, ImplicitBody};
use crate::collapse::{Collapse, CollapseEnded, CollapseSettings, Watch};
use crate::collider::ColliderShape;
use crate::contact::{
    CollidingEntities, ContactAnchors, ContactEnded, ContactForce, ContactForceEvents,
    ContactHooks, ContactImpulses, ContactPair, ContactStarted, ContactTargets, Load, Manifold,
    MovingSurfaces,
};
use crate::diagnosis::{BodyError, StepError, Told};
use crate::grab::{GrabForce, Hand, HandState, HeldBy};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint::{
    self, BreakForce, JointAxes, JointBroke, JointDisabled, JointEdge, JointError, JointForces,
    QuarantinedJoint,
};
use crate::masonry::{EditLog, Laid};
use crate::mortar::{Mortar, MortarBroke};
use crate::profile::Profile;
use crate::saving::Saved;
use crate::sensor::{Sensor, SensorEntered, SensorExited, SensorOverlaps};
use crate::settings::{
    ActiveSettings, ContactSolver, Gravity, NarrowphaseSettings, PhysicsThreads, PhysicsTime,
    SleepSettings, SolverSettings, SpeedLimits, StabilizationSettings, StepTime,
};
use crate::solve::SolveReports;
use crate::solver::{Nncg, Pgs, SoftStep};
use bevy_app::App;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;

macro_rules! register {
    ($app:expr, $($type:ty),+ $(,)?) => {
        $($app.register_type::<$type>();)+
    };
}

/// Registers all of them.
pub(crate) fn register(app: &mut App) {
    // Bodies and colliders.
    body::register(app);
    register!(
        app,
        Quarantined,
        RigidBodyDisabled,
        Teleport,
        Load,
        Watch,
        Laid
    );
    register!(
        app,
        ColliderShape,
        ColliderOf,
        ImplicitBody,
        Sensor,
        SensorOverlaps
    );
    register!(app, CollidingEntities, ContactForceEvents, Saved);
    register!(app, GrabForce, Hand, HandState, HeldBy);
    // Joints.
    joint::register(app);
    register!(
        app,
        BreakForce,
        JointAxes,
        JointDisabled,
        JointForces,
        QuarantinedJoint,
        Mortar
    );
    // Pairs.
    register!(
        app,
        ContactPair,
        Manifold,
        ContactTargets,
        ContactImpulses,
        ContactAnchors
    );
    // Settings.
    register!(
        app,
        Gravity,
        StabilizationSettings,
        NarrowphaseSettings,
        SolverSettings
    );
    register!(app, ContactSolver, SoftStep, Pgs, Nncg);
    register!(
        app,
        SleepSettings,
        SpeedLimits,
        CollapseSettings,
        PhysicsTime,
        StepTime
    );
    // Messages and reports.
    register!(
        app,
        BodyError,
        StepError,
        JointError,
        JointBroke,
        SolveReports
    );
    register!(
        app,
        ContactStarted,
        ContactEnded,
        ContactForce,
        Collapse,
        CollapseEnded
    );
    register!(app, SensorEntered, SensorExited, MortarBroke);
    // Components of Bevy that bodies have, which it registers only with plugins of its own.
    register!(app, Transform, ChildOf, Children, Name, Disabled);
    // Names.
    register!(app, Inactive, JointEdge, body::BodyTable, Broadphase);
    register!(
        app,
        ConstraintGraph,
        Islands,
        ActiveSettings,
        MovingSurfaces,
        Told
    );
    register!(app, ContactHooks, PhysicsThreads, Profile, EditLog);
}
