//! The component that says whether a body sleeps. The stage *sleeping* puts islands to sleep, and the stage *islands* wakes bodies.

use bevy_ecs::entity::{ComponentCloneCtx, SourceComponent};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Whether a body sleeps, and whether it may. A body can be spawned asleep or put to sleep. The clone of a sleeping body is awake.
///
/// # When bodies fall asleep
///
/// An island of bodies that touch falls asleep when all its bodies have been slower than [`SleepSettings`](crate::settings::SleepSettings)
/// says for [`delay`](crate::settings::SleepSettings::delay) (0.5 s), and are at rest: by how they moved meanwhile, each of them would move
/// by less than 1 mm in the next ten seconds, or by less than a thousandth of its radius if that is more. Bodies that move slowly but
/// steadily, or speed up, stay awake. Bodies that nothing drives and that dry contacts hold may creep evenly by up to
/// [`linear_speed`](crate::settings::SleepSettings::linear_speed), because solvers let heaps creep.
///
/// # What wakes them
///
/// A sleeping body wakes in the step after one of these was inserted, written with another value, or removed. A change of a body that does
/// not sleep itself, such as the ground, wakes all that is connected with it.
///
/// | of | what |
/// |---|---|
/// | the body, its place and motion | `RigidBody`, `Transform`, `Pose`, `Velocity`, `ChildOf`, `Sleeping`, `SpawnOrder` |
/// | forces | `ExternalForce`, `ExternalImpulse`, `Damping` (if there is less), `GravityScale`, `Grab`, `Hand` |
/// | its shape | `Collider`, `ColliderOf` and `CompoundCollider` (colliders on children), `ColliderDisabled`, `Sensor`, `Voxels` |
/// | a fluid in which it is | `Fluid`, or its surface moves |
/// | its wheels | `Wheel` |
/// | its mass | `Density`, `Mass`, `AngularInertia`, `CenterOfMass` |
/// | its surface | `Friction`, `Restitution`, `RollingFriction`, `SurfaceVelocity` |
/// | what it collides with | `CollisionLayers`, `CollisionExceptions`, `ActiveContactHooks`, the resource `ContactHooks` |
/// | how it is solved | `LockedAxes`, `Dominance`, `MaxLinearSpeed`, `MaxAngularSpeed`, `SolverEffort` |
/// | whether a body beside it takes part | `RigidBodyDisabled`, `Disabled`, `Quarantined`; it is despawned |
/// | joints | `FixedJoint`, `RevoluteJoint`, `PrismaticJoint`, `SphericalJoint`, `CylindricalJoint` |
/// | | `DistanceJoint`, `SpringJoint`, `GenericJoint`, `MortarJoint`; `Mortar`, `Studs`, `BreakForce`, `JointDisabled` |
/// | settings, for all bodies | `Gravity`, `SolverSettings`, `StabilizationSettings` |
/// | | `NarrowphaseSettings`, `SleepSettings`, `SpeedLimits` |
///
/// Bodies that awake ones touch wake as [`Waking`](crate::settings::Waking) says. Edits of the [contacts](crate::contact::ContactPair) of
/// two sleeping bodies take effect when one of them wakes. Nobody notices a write that bypasses Bevy's change detection, or a change of
/// data that a [hook](crate::contact::ContactHook) shares.
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
#[component(clone_behavior = Custom(copy_awake), summary_tick)]
pub struct Sleeping {
    /// Whether the body sleeps. Default: false.
    pub asleep: bool,
    /// Time for which the body has been still, s. Default: 0.
    pub still_for: f32,
    /// Whether the body may sleep. False keeps the body and its island awake. Default: true.
    pub allowed: bool,
}

/// A clone overlaps its original, so it must be awake for the two to be pushed apart.
fn copy_awake(source: &SourceComponent, context: &mut ComponentCloneCtx) {
    if let Some(&original) = source.read::<Sleeping>() {
        let mut copy = original;
        copy.wake();
        context.write_target_component(copy);
    }
}

impl Default for Sleeping {
    fn default() -> Self {
        Self {
            asleep: false,
            still_for: 0.0,
            allowed: true,
        }
    }
}

impl Sleeping {
    /// Wakes the body.
    pub fn wake(&mut self) {
        self.asleep = false;
        self.still_for = 0.0;
    }
}
