//! Mortar: bonds between bricks that hold tension and shear, and break patch by patch.
//!
//! Put [`Mortar`] on a brick and lay it: in the first step in which a face of it rests on faces of other bodies, it is bonded to them, and
//! the component is removed. Each patch of contact is a bond of its own, an entity with [`MortarJoint`]. When the stress in a patch exceeds
//! its strength the bond breaks: [`MortarBroke`] is sent, and the bricks touch as dry stone from then on.
//!
//! ```
//! use bevy_ecs::message::Messages;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! // Two bricks of 125 kg stick out of a wall.
//! let cube = Collider::cuboid(0.5, 0.5, 0.5);
//! let at = |x, y| Transform::from_xyz(x, y, 0.0);
//! world.spawn((RigidBody::Static, cube.clone(), at(0.0, 3.0)));
//! let [root, end] = [0.5, 1.0].map(|x| {
//!     let brick = (RigidBody::Dynamic, cube.clone(), Mass(125.0), Mortar::default());
//!     world.spawn((brick, at(x, 3.0))).id()
//! });
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! // At the root, M/W is 59 kPa. The mortar bears 100.
//! assert!(world.get::<Transform>(end).unwrap().translation.y > 2.999);
//!
//! // A brick of 250 kg is laid on the end: 147 kPa.
//! world.spawn((RigidBody::Dynamic, cube, Mass(250.0), at(1.0, 3.501)));
//! let mut broke = Vec::new();
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//!     broke.extend(world.resource_mut::<Messages<MortarBroke>>().drain());
//! }
//! assert_eq!(broke.len(), 1);
//! assert_eq!((broke[0].other, broke[0].how), (root, MortarFailure::Tension));
//! assert!(world.get::<Transform>(end).unwrap().translation.y < 2.5);
//! ```
//!
//! # What is bonded
//! Mortar bonds faces: patches of three or more points, at most a millimetre apart, that move against each other by less than 5 cm/s. Of
//! two bodies that touch, one with fresh mortar is enough; if both have some, the lesser strengths count. A brick that falls or is carried
//! keeps its mortar until it rests. Static bodies may have mortar as well as dynamic ones. Structures from [`masonry`](crate::masonry) are
//! laid with mortar by spawning `(block.bundle(), Mortar::default())`.
//!
//! [`Studs`] are the bond of toy bricks, which may be pressed together again.
//!
//! # The law
//! The bodies are rigid and the mortar is thin and even, so the stress is linear over a patch, as in a beam. With the force N, V and the
//! moments M, T about the centroid of the patch:
//!
//! | breaks by | when, at some corner |
//! |---|---|
//! | [tension](MortarFailure::Tension) | −N/A + M₁/W₁ + M₂/W₂ > tensile strength |
//! | [shear](MortarFailure::Shear) | V/A + T·r/I_p > cohesion + friction · N/A |
//!
//! Mortar is not crushed. Forces are filtered by a low-pass of 10 ms ([`BreakForce::response`](crate::joint::BreakForce::response), of a
//! `BreakForce` on the joint), so that a bond breaks at the same load at every length of a step. Of neighbours that would break, the one
//! nearest to breaking goes first, since that relieves the others: an overloaded cantilever breaks at its root and falls in one piece.
//! Several bonds may break in a step, one after another.
//!
//! Bonds of a structure share its load by their areas. A bond also breaks if an edit moves its bodies apart ([`MortarFailure::Misfit`]).
//! Bodies that are despawned take their bonds along; those of a disabled body come back with it.
//!
//! # Bonds are joints
//! A bond is an edge of the constraint graph of the kind *joint*: bonded bodies sleep and wake together, and loads, supports, previews and
//! queries of [`joint`](crate::joint) treat it like any other joint. A bonded pair has no contact; it is found again in the step after its
//! last bond broke. So of a pair with several patches, those that broke do not bear pressure until all have broken.
//!
//! While its bonds hold, a structure moves as one rigid body: it costs what its contacts cost, and neither creeps nor strains itself by
//! spinning. The forces of its bonds follow from their stiffness. In a step in which some may break, all of them are solved together,
//! directly, which takes five to fifty times as long (410 bricks: 10 to 50 ms). At rest a structure sleeps and costs nothing.
//!
//! A structure is always solved directly while a [`Grab`](crate::body::Grab) or something that moves by itself holds one of its bodies.
//! Under [the point solvers](crate::solver::points) bonds are weak.

mod events;
mod lay;
mod studs;

pub use crate::joint_types::{Mortar, MortarJoint, Studs};
pub use crate::solver::MortarFailure;
pub(crate) use events::trigger;
#[doc(hidden)]
pub use events::{BrokenMortar, any_broke};
pub use events::{MortarBroke, mortar_events};
pub use lay::lay_mortar;
pub use studs::click_studs;
