//! Fracture: bodies that break into pieces at a blow, and debris that goes after a while.
//!
//! Put [`Fracturable`] on a body. When something hits it, or it hits something, with more than its energy, it is replaced by pieces before
//! the blow is solved: a ball goes on through a pane, as far as what is left of its energy takes it. [`Fractured`] tells of it, as a
//! message and as an event. [`shatter`] breaks a body by hand, and [`fracture`] only computes the pieces of a shape.
//!
//! ```
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! let pane = Fracturable { energy: 20.0, pieces: 16, ..Default::default() };
//! world.spawn((RigidBody::Static, Collider::cuboid(0.02, 1.0, 1.0), Density(2500.0), pane));
//! let ball = (RigidBody::Dynamic, Collider::ball(0.1), Velocity::linear(Vec3::X * 12.0), Transform::from_xyz(-1.0, 0.0, 0.0));
//! let ball = world.spawn(ball).id();
//! // An observer gives the pieces what the game draws.
//! world.add_observer(|broken: On<Fractured>, mut commands: Commands| {
//!     for &piece in &broken.pieces {
//!         commands.entity(piece).insert(Name::new("shard"));
//!     }
//! });
//! # use bevy_ecs::prelude::*;
//! for _ in 0..30 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! assert!(world.query::<&Name>().iter(world).count() > 10);
//! assert!(world.get::<Transform>(ball).unwrap().translation.x > 0.5);
//! ```
//!
//! # What is kept
//! The pieces fill the body. They have its mass, its linear and its angular momentum, its friction, layers and other properties, and its
//! parent. The blow takes the body's [energy](Fracturable::energy) out of the motion of the two bodies, by an impulse between them, and
//! nothing else; so momentum is kept. Joints of the body end with it, as when it is despawned.
//!
//! # What is a blow
//! The energy of a blow is what two free bodies would lose if they did not bounce: ½ u² m, with the speed u at which the surfaces approach
//! each other, and the mass m that they oppose to it (of both bodies, where they are hit). It is found before the step in which they touch.
//! Weight that rests on a body, however heavy, is no blow: see [`Load`](crate::contact::Load) and [`shatter`] for that. A body that
//! is spawned so near to another one that it hits it in its first step does not break it.

mod blow;
mod break_up;
mod cell;
mod debris;
mod patterns;
mod pieces;

pub use blow::break_at_blows;
pub use break_up::{Fractured, Fractures, shatter};
pub use debris::{Debris, debris};
pub use pieces::{FractureError, Piece, fracture, seeds};

use crate::character::CrouchSystems;
use crate::components::{any_with, init};
use crate::grab::{hands, refresh_for_hands};
use crate::joint_types::Mortar;
use crate::profile::{Profile, own};
use crate::schedule::{AfterStep, PhysicsSchedule, PhysicsSystems, StepMessages};
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Breaks every [`Fracturable`] body at a blow, and removes old [`Debris`]. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct FracturePlugin;

/// The system set in which bodies break and debris goes: before *prepare*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FractureSystems;

impl Plugin for FracturePlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        init::<Fractures>(app.world_mut());
        app.add_message::<Fractured>();
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "prepare", debris)
                    .run_if(any_with(Components::component_id::<Debris>)),
                own(&profile, "prepare", break_at_blows)
                    .run_if(any_with(Components::component_id::<Fracturable>)),
            )
                .chain()
                .before(PhysicsSystems::Prepare)
                .after(CrouchSystems)
                // A hand that closes on a body that breaks grabs a piece.
                .before(refresh_for_hands)
                .before(hands)
                .in_set(FractureSystems),
        );
        let world = app.world_mut();
        init::<StepMessages>(world);
        world.resource_mut::<StepMessages>().add::<Fractured>();
        init::<AfterStep>(world);
        world.resource_mut::<AfterStep>().0.push(break_up::trigger);
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// A body that breaks into pieces at a blow; see the [module](self). It may be dynamic, kinematic or static; its pieces are dynamic.
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
pub struct Fracturable {
    /// The energy that breaks it, J. A blow of less does nothing, and one of more loses so much. Default: 100.
    pub energy: f32,
    /// Number of pieces; now and then there are some fewer. They are small near the point of impact. Default: 8.
    pub pieces: u32,
    /// How often its pieces break again, each at the energy that its share of the volume, to the power of ⅔, has of `energy`. Default: 0.
    pub again: u32,
    /// Mortar between the pieces, and between them and what they touch: a blow then loosens only some. Default: none.
    pub mortar: Option<Mortar>,
    /// What becomes of the pieces. Default: they stay.
    pub debris: Option<Debris>,
}

impl Default for Fracturable {
    fn default() -> Self {
        Self {
            energy: 100.0,
            pieces: 8,
            again: 0,
            mortar: None,
            debris: None,
        }
    }
}
