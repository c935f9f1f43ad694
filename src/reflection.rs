//! Reflection (feature `bevy_reflect`): the types that inspectors, scenes and the remote protocol see.
//!
//! The [plugins](crate::DrystonePlugins) register what a user reads, edits or saves, and the types in the fields of these:
//!
//! | of | types |
//! |---|---|
//! | bodies | `RigidBody`, `Pose`, `Velocity`, `Motion`, `Sleeping`, `SpawnOrder`, `BodyIndex`, `MassProperties`, `Mass`, `AngularInertia`, `CenterOfMass`, `Density`, `Damping`, `GravityScale`, `ExternalForce`, `ExternalImpulse`, `LockedAxes`, `Dominance`, `MaxLinearSpeed`, `MaxAngularSpeed`, `SolverEffort`, `Teleport`, `Quarantined`, `RigidBodyDisabled`, `ColliderDisabled`, `Load`, `Watch`, `Laid`, `Saved` |
//! | colliders | `Collider`, `ColliderShape`, `ColliderOf`, `ImplicitBody`, `CompoundCollider`, `Friction`, `Restitution`, `RollingFriction`, `SurfaceVelocity`, `CollisionLayers`, `CollisionExceptions`, `ContactEvents`, `ContactForceEvents`, `ActiveContactHooks`, `CollidingEntities`, `Sensor`, `SensorOverlaps` |
//! | joints, mortar | `FixedJoint`, `RevoluteJoint`, `PrismaticJoint`, `SphericalJoint`, `DistanceJoint`, `SpringJoint`, `GenericJoint`, `JointAxes`, `JointForces`, `BreakForce`, `JointDisabled`, `QuarantinedJoint`, `Mortar`, `MortarJoint` |
//! | hands | `Grab`, `GrabForce`, `Hand`, `HandState`, `HeldBy` |
//! | characters | `Character`, `CharacterState`, `MoveAndSlide`, `Ground` |
//! | pairs | `ContactPair`, `Manifold`, `ContactTargets`, `ContactImpulses`, `ContactAnchors` |
//! | settings | `Gravity`, `PhysicsTime`, `StepTime`, `SolverSettings`, `ContactSolver`, `SoftStep`, `Pgs`, `Nncg`, `StabilizationSettings`, `NarrowphaseSettings`, `SleepSettings`, `SpeedLimits`, `CollapseSettings` |
//! | messages and reports | `ContactStarted`, `ContactEnded`, `ContactForce`, `SensorEntered`, `SensorExited`, `JointBroke`, `MortarBroke`, `Collapse`, `CollapseEnded`, `BodyError`, `JointError`, `StepError`, `SolveReports` |
//! | Bevy | `Transform`, `ChildOf`, `Children`, `Name`, `Disabled` |
//!
//! Types that belong to one world, hold code or threads, or are computed in every step are not reflected: the table of bodies, the
//! broadphase, the constraint graph, islands, the profile, hooks, threads and the log of edits. A shape is opaque, and is read by its
//! [description](crate::collider::Collider::description). With the feature `serde` the types are also serialized by reflection, as scenes
//! do.

use crate::body::{self, Quarantined, RigidBodyDisabled, Teleport};
use crate::character::{Character, CharacterState};
use crate::children::{ColliderOf, ImplicitBody};
use crate::collapse::{Collapse, CollapseEnded, CollapseSettings, Watch};
use crate::collider::ColliderShape;
use crate::contact::{
    CollidingEntities, ContactAnchors, ContactEnded, ContactForce, ContactForceEvents,
    ContactImpulses, ContactPair, ContactStarted, ContactTargets, Load, Manifold,
};
use crate::diagnosis::{BodyError, StepError};
use crate::grab::{GrabForce, Hand, HandState, HeldBy};
use crate::joint::{
    self, BreakForce, JointAxes, JointBroke, JointDisabled, JointError, JointForces,
    QuarantinedJoint,
};
use crate::masonry::Laid;
use crate::mortar::{Mortar, MortarBroke};
use crate::query::{Ground, MoveAndSlide};
use crate::saving::Saved;
use crate::sensor::{Sensor, SensorEntered, SensorExited, SensorOverlaps};
use crate::settings::{
    ContactSolver, Gravity, NarrowphaseSettings, PhysicsTime, SleepSettings, SolverSettings,
    SpeedLimits, StabilizationSettings, StepTime,
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

/// Registers them.
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
    register!(app, Character, CharacterState, MoveAndSlide, Ground);
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
}
