//! Joints: doors, chains, bridges, sliders, ropes, springs. A joint is an entity of its own that connects two bodies, or a body and the
//! world.
//!
//! | to | use |
//! |---|---|
//! | hold two bodies together | [`FixedJoint`] |
//! | hang a door, turn a wheel | [`RevoluteJoint`] |
//! | slide a lift or a drawer | [`PrismaticJoint`] |
//! | slide a bolt that also turns | [`CylindricalJoint`] |
//! | link a chain, let a pendulum swing | [`SphericalJoint`] |
//! | tie with a rope, keep apart with a rod | [`DistanceJoint`] |
//! | connect with a spring | [`SpringJoint`] |
//! | choose what each of the six axes does | [`GenericJoint`] |
//! | drive or hold in place | [`JointMotor`], with `with_motor` |
//! | bound the motion | `with_limits`, `with_angle_limits`, `with_twist_limits`, `with_swing_cone`, … |
//! | brake by dry friction | `with_friction` |
//! | bond two faces with mortar | [`Mortar`](crate::mortar::Mortar), which makes joints of its own |
//! | let it break | [`BreakForce`]; [`JointBroke`] reports it |
//! | switch it off and on | [`JointDisabled`] |
//! | read its force | [`JointForces`], [`Joints`] |
//! | read its angle, with all turns | [`JointForces::angle`] |
//! | find out why it does nothing | [`QuarantinedJoint`], [`JointError`] |
//!
//! # Bodies
//! `new(body1, body2)` takes two entities. `None` is the world: `RevoluteJoint::new(None, door)` hangs a door in the air, and a rope to
//! `None` is tied to a point in the world. A static or kinematic body does as well; at least one of the two must be dynamic. Angles,
//! positions and forces are those of body 2 relative to body 1.
//!
//! The bodies may be spawned later than the joint. If one is disabled in any way, taken out or quarantined, the joint
//! waits for it. If one is despawned, the joint is
//! reported and does nothing until it gets another body. The joint is not despawned: with Bevy's `ChildOf` you decide whose end is its own.
//!
//! # Frames
//! A joint is attached to each body by an anchor and a basis ([`JointFrame`]). Parts that you do not give are found when the joint is
//! added, from where the bodies are then: so place the bodies, and spawn the joint. `with_anchor` takes a point in the world for both,
//! `with_local_anchor1` and `with_local_anchor2` points of the bodies. In the step that adds the joint its frames become local, and stay so
//! if the scene is saved.
//!
//! # Contacts, sleep and edits
//! Two jointed bodies do not collide with each other, unless the joint says so (`with_collision`); no list of
//! [`CollisionExceptions`](crate::collider::CollisionExceptions) is changed for that. Jointed bodies belong to one island: they sleep and
//! wake together. Adding, changing, disabling or removing a joint wakes its bodies. Everything about a joint may be changed at any time,
//! and takes effect in the next step. Several joints between two bodies are allowed.
//!
//! A clone of a joint, or one in a scene, refers to the clones of its bodies.
//!
//! # Bad input
//! A joint whose numbers or bodies are invalid gets the marker [`QuarantinedJoint`] and is reported by a [`JointError`] message and in the
//! log. It does nothing; its bodies are simulated on. When its input is corrected it works again.
//!
//! # From Avian and Rapier
//! Types and builder methods have Avian's names. Differences: a joint to the world needs no static body; an anchor that is not given is
//! where the bodies are, and not at the origin of each; jointed bodies do not collide unless asked; there is no compliance or damping to
//! tune, because joints are solved directly; Avian's `swing_limit` is `swing_cone`. From bevy_rapier: a joint is an entity and not a
//! component of one of its bodies; `locked_axes` is [`GenericJoint::with_locked_axes`], `motor_velocity` and `motor_position` are
//! [`JointMotor::velocity`] and [`JointMotor::position`].
//!
//! Under the point solvers ([`Pgs`](crate::solver::Pgs), [`Nncg`](crate::solver::Nncg)) joints are plain rows, which heavy loads stretch.
//!
//! # In a step
//! The stage [`joints`](joints()), after *prepare*, adds and removes edges of the constraint graph ([`graph`](crate::graph)), of the kind
//! *joint*. *Warm start* gathers the joints of each island, in the order of their bodies and then in spawn order. *Solve* computes them
//! together with contacts, and writes [`JointForces`]. Joints that break are disabled at the end of the step.

mod events;
mod joints;
mod query;

#[doc(hidden)]
pub use crate::joint_types::JointChanges;
pub use crate::joint_types::types::*;
pub use crate::joint_types::{
    BreakForce, JointAnchor, JointAxis, JointBasis, JointDisabled, JointEdge, JointError,
    JointForces, JointFrame, JointLimits, JointMotor, JointProblem, QuarantinedJoint,
};
pub(crate) use events::trigger;
#[doc(hidden)]
pub use events::{BrokenJoints, any_broke};
pub use events::{JointBroke, joint_events};
pub use joints::joints;
pub(crate) use joints::update;
pub use query::{BodyJoint, Joints, joints_of};
