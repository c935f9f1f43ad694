//! The list of the properties of a body. To add a property, write its component in a file of its own, and add a line here.
//!
//! A property is a component that a user may write. From the list follow
//! - the required components of a [`RigidBody`](super::RigidBody), and the components that are restored when they are removed,
//! - the change detection of active bodies (`Describing`) and of inactive ones (`Written`),
//! - the properties that the [`BodyTable`](super::BodyTable) copies ([`BodyProperties`](super::BodyProperties)),
//! - the components that a preview copies, those that belong to the [state](crate::state) of a world, and those that are registered for
//!   reflection.
//!
//! A component whose removal must be noticed has the hook [`lost_description`](super::lost_description).

/// The names of the listed components.
pub(in crate::body) mod names {
    pub use crate::body::collider::{
        Collider, CollisionExceptions, CollisionLayers, Friction, Restitution, RollingFriction,
        SurfaceVelocity,
    };
    pub use crate::body::{
        ActiveContactHooks, AngularInertia, BodyIndex, CenterOfMass, ColliderDisabled,
        CompoundCollider, ContactEvents, Damping, Density, Dominance, ExternalForce,
        ExternalImpulse, Grab, GravityScale, LockedAxes, Mass, MassProperties, MaxAngularSpeed,
        MaxLinearSpeed, Motion, Pose, Sleeping, SolverEffort, SpawnOrder, Velocity,
    };
}

/// Passes the list to a macro, which generates items from it. The names of the components are those of
/// [`names`], which every user of the list imports.
///
/// | group | required | restored when removed | checked when written |
/// |---|---|---|---|
/// | `essential` | yes | yes | on inactive bodies; the stages read it of active ones in every step |
/// | `computed` | yes | yes | no: stages write it |
/// | `pushing` | no | no | like `essential` |
/// | `optional` | no | no | like `essential`; previews have none |
/// | `described` | no | no | on all; [`describe`](super::describe) reads it |
/// | `kept` | no | no | on all; the table keeps a copy |
///
/// The expression of a line returns true if the table has the value already: writing an equal value does not activate an inactive body.
/// Without an expression every write does.
macro_rules! body_properties {
    ($macro:ident) => {
        $macro! {
            essential {
                // Inactive bodies have the pose of the table.
                pose: Pose = |body, pose| body.pose == *pose,
                // Inactive bodies have velocity zero.
                velocity: Velocity = |_, velocity| *velocity == Velocity::default(),
                sleeping: Sleeping = |body, sleeping| body.asleep == sleeping.asleep,
                spawn_order: SpawnOrder = |body, order| body.spawn_order == *order,
                // Required because `Forces` adds to it.
                impulse: ExternalImpulse = |_, impulse| *impulse == ExternalImpulse::default(),
                // The body was found by it.
                index: BodyIndex = |_, _| true,
            }
            computed {
                motion: Motion,
                mass_properties: MassProperties,
            }
            pushing {
                force: ExternalForce = |body, force| body.force() == *force,
                damping: Damping = |body, damping| body.damping() == *damping,
                gravity_scale: GravityScale = |body, scale| body.gravity_scale == scale.0,
            }
            optional {
                grab: Grab,
            }
            described {
                collider: Collider = |body, collider| {
                    body.collider.as_ref().is_some_and(|known| known.is_same(collider))
                },
                compound: CompoundCollider,
                density: Density,
                mass: Mass,
                inertia: AngularInertia,
                center: CenterOfMass,
                events: ContactEvents,
                collider_disabled: ColliderDisabled,
            }
            kept {
                /// Coefficient of friction of the surface.
                friction: Friction,
                /// Coefficient of restitution.
                restitution: Restitution,
                /// Rolling resistance.
                rolling: RollingFriction,
                /// Layers that the body is in, and layers that it collides with.
                layers: CollisionLayers,
                /// Bodies that it does not collide with.
                exceptions: CollisionExceptions,
                /// Axes along which it does not move.
                locked_axes: LockedAxes,
                /// Its dominance group.
                dominance: Dominance,
                /// Its maximum linear speed.
                max_linear_speed: MaxLinearSpeed,
                /// Its maximum angular speed.
                max_angular_speed: MaxAngularSpeed,
                /// The multiple of the usual sweeps that it needs.
                solver_effort: SolverEffort,
                /// The velocity of its surface.
                surface_velocity: SurfaceVelocity,
                /// The hooks that are called for its contacts.
                hooks: ActiveContactHooks,
            }
        }
    };
}
pub(in crate::body) use body_properties;
