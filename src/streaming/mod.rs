//! Streaming: regions of a large world are taken out of the simulation and put back, standing as they stood.
//!
//! A region is a set of bodies at rest: sleeping, static or standing still. [`take_out`] removes them from the simulation, with their
//! contacts, and returns a [`Region`] that holds what the simulation knew about them. [`put_back`] adds them again, in the next frame or an
//! hour later. They sleep as they slept: same contacts, anchors, forces and loads, to the bit. Nothing is detected or solved anew, no
//! [`ContactStarted`](crate::contact::ContactStarted) or [`ContactEnded`](crate::contact::ContactEnded) is sent, and nothing moves if the
//! bodies are woken afterwards. Both cost as much as the region is large, whatever the size of the world: some milliseconds for a thousand
//! bricks.
//!
//! ```
//! use bevy_app::App;
//! use bevy_ecs::prelude::*;
//! use drystone::masonry::{Bond, Wall};
//! use drystone::prelude::*;
//! use drystone::streaming;
//!
//! let mut app = App::new();
//! app.add_plugins(DrystonePlugins::default());
//! let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let blocks = Wall::new(Bond::Running).blocks().unwrap();
//! let asleep = Sleeping { asleep: true, ..Default::default() };
//! let wall: Vec<Entity> = blocks
//!     .into_iter()
//!     .map(|block| world.spawn((block.bundle(), asleep, Load::default())).id())
//!     .collect();
//! for _ in 0..4 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! let load = *world.get::<Load>(wall[0]).unwrap();
//!
//! // The player goes away.
//! let region = streaming::take_out(world, wall.iter().copied()).unwrap();
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! assert!(contacts(world, |contacts| contacts.on(wall[0])).is_err(), "nothing is there");
//!
//! // The player comes back.
//! let left_out = streaming::put_back(world, region);
//! assert!(left_out.is_empty());
//! let faces = contacts(world, |contacts| contacts.on(wall[0])).unwrap();
//! assert!(faces.iter().any(|face| face.normal_force > 0.0));
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! assert_eq!(*world.get::<Load>(wall[0]).unwrap(), load);
//! assert!(world.get::<Sleeping>(wall[0]).unwrap().asleep);
//! ```
//!
//! # What is kept
//!
//! - The entities of the bodies stay, with all of their components, yours included: meshes, names, children. They get the marker
//!   [`RigidBodyDisabled`](crate::body::RigidBodyDisabled), so that no stage and no query sees them. Hide them with
//!   `Visibility`. The entities of their contacts are despawned, and their components are in the [`Region`].
//! - Edits of a body that is out take effect when it is back: a brick that was moved is moved then, as if you had moved it in that frame.
//! - Bodies that were despawned while they were out stay away, and what touched them wakes, as if you had despawned them in that frame. The
//!   same holds for bodies that you have enabled yourself, by removing the marker: they came back awake and without their contacts.
//! - A dropped [`Region`] loses the contacts. Its bodies stay disabled until you remove their markers.
//!
//! # Neighbours
//!
//! - A border may go through a wall. Neighbours that sleep stay asleep while a region is out, without it under them. When it is back, the
//!   contacts across the border are as they were, unless the neighbour was moved, changed, woken or despawned: then the bodies of the
//!   region that touched it wake. If the neighbour is in a region that is out too, the contact waits until that is back.
//! - An awake body must not touch the region when it is taken out, since it would fall: [`StreamingError::BesideAwake`].
//! - Joints, bonds of mortar and hands hold their bodies in the world: [`StreamingError::Joined`], [`StreamingError::Held`].
//! - What was put into the space of the region meanwhile is in contact with it from the next step on.
//! - If settings such as [`Gravity`](crate::settings::Gravity) were changed while a region was out, its bodies wake when they are back, as
//!   all others did then.

mod arrivals;
mod error;
mod put_back;
mod region;
mod suspended;
mod take_out;

pub use arrivals::spawn_asleep;
#[doc(hidden)]
pub use arrivals::{Arrivals, any_arrivals, arrive};
pub use error::StreamingError;
pub use put_back::put_back;
pub use region::Region;
#[doc(hidden)]
pub use suspended::Suspended;
pub use take_out::take_out;
