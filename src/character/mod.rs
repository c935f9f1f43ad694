//! Characters that the step moves: they walk, jump, climb stairs, and go with what they stand on.
//!
//! A [`Character`] says how it wants to move, and [`CharacterState`] what came of it. Once per step, after all bodies have moved, the step
//! moves each character with its ground, then by its own velocity, by the rules of [`MoveAndSlide`], and pushes the bodies that it runs
//! into. So a lift that was moved in this step, by its `Velocity` or its `Transform`, counts already. A game that wants other rules calls
//! [`move_and_slide`](crate::query::SpatialQuery::move_and_slide) itself.
//!
//! A character is a kinematic body: others bump into it, queries find it, and sensors notice it. It keeps a distance from everything, so it
//! weighs nothing on what it stands on. It is put from place to place: its [`Velocity`](crate::body::Velocity) stays zero, so it pushes
//! bodies with a limited force only, and does not carry what lies on it. Bodies that its
//! [`CollisionLayers`](crate::collider::CollisionLayers) do not let it collide with are no obstacles.
//!
//! ```
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let hero = (Character::default(), Collider::capsule(0.3, 1.0), Transform::from_xyz(0.0, 0.81, 0.0));
//! let hero = world.spawn(hero).id();
//! for _ in 0..60 {
//!     // What a player presses.
//!     world.get_mut::<Character>(hero).unwrap().walk = Vec3::X * 2.0;
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! assert!((world.get::<Transform>(hero).unwrap().translation.x - 2.0).abs() < 0.01);
//! assert!(world.get::<CharacterState>(hero).unwrap().stands());
//! ```

mod advance;
mod crouch;
mod ground;
mod one_way;

pub use advance::{characters, take_places};
pub use crouch::crouch;

use crate::body::{Pose, RigidBody};
use crate::broadphase::escaped_aabb;
use crate::collider::LayerMask;
use crate::components::{any_with, init};
use crate::grab::{hands, refresh_for_hands};
use crate::profile::{Profile, own};
use crate::query::{Ground, MoveAndSlide};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::settings::is_last;
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Moves every [`Character`]. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct CharacterPlugin;

/// The system set in which characters move: in the last substep of each step, after *integration* and before *sensors*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterSystems;

/// The system set in which characters crouch and get up: before *prepare*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CrouchSystems;

impl Plugin for CharacterPlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "prepare", crouch)
                .run_if(any_with(Components::component_id::<Character>))
                .before(PhysicsSystems::Prepare)
                // What a hand closes on is the character as it stands now.
                .before(refresh_for_hands)
                .before(hands)
                .in_set(CrouchSystems),
        );
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "integration", characters),
                own(&profile, "integration", take_places),
                own(&profile, "broadphase", escaped_aabb),
            )
                .chain()
                .run_if(any_with(Components::component_id::<Character>))
                .run_if(is_last)
                .after(PhysicsSystems::Integration)
                .before(PhysicsSystems::Sleeping)
                .in_set(CharacterSystems),
        );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// A character that the step moves, and how it wants to move; see the [module](self). The game writes it, and reads [`CharacterState`].
///
/// It is a kinematic body with a [`Collider`](crate::collider::Collider) and no parent. A game may write its `Transform` between steps, to
/// turn the character or to put it elsewhere.
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
#[require(CharacterState, RigidBody = RigidBody::Kinematic)]
pub struct Character {
    /// The velocity at which it walks, m/s, world, relative to its ground. In the air it adds to the velocity of its jump or fall. Its part
    /// along [`up`](MoveAndSlide::up) counts only while the character [climbs](Self::climbs). Default: zero.
    pub walk: Vec3,
    /// The speed at which it jumps in the next step if it stands, m/s. The step sets it to zero, whether it jumps or not. Default: 0.
    pub jump: f32,
    /// Whether it climbs, swims or flies: it does not fall, and `walk` counts in all directions. Set it while it is at a ladder. Default:
    /// false.
    pub climbs: bool,
    /// Factor on gravity. Default: 1.
    pub gravity_scale: f32,
    /// Whether it crouches: its collider, an upright capsule, cylinder or cuboid, is lowered to
    /// [`crouch_height`](Self::crouch_height), and its feet stay where they are. If this is false again, it gets up as soon as there is
    /// room. Default: false.
    pub crouches: bool,
    /// Its height while it crouches, m; a capsule stays as high as it is wide. Default: 1.
    pub crouch_height: f32,
    /// Layers of platforms that it passes from below and from the sides, and stands on. A platform is in no other layer. Default: none.
    pub one_way: LayerMask,
    /// Whether it drops through platforms in those layers. Default: false.
    pub drops: bool,
    /// The largest force with which it pushes dynamic bodies that are in its way, N. Default: 300.
    pub push: f32,
    /// The rules by which it moves.
    pub rules: MoveAndSlide,
}

impl Default for Character {
    fn default() -> Self {
        Self {
            walk: Vec3::ZERO,
            jump: 0.0,
            climbs: false,
            gravity_scale: 1.0,
            crouches: false,
            crouch_height: 1.0,
            one_way: LayerMask::NONE,
            drops: false,
            push: 300.0,
            rules: MoveAndSlide::default(),
        }
    }
}

/// How a [`Character`] moved in the last step.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(map_entities)]
pub struct CharacterState {
    /// Its ground, if it stands.
    pub ground: Option<Ground>,
    /// Its velocity in the last step, m/s, world.
    pub velocity: Vec3,
    /// The part of its velocity that is not by walking, m/s, world: that of falls and jumps, and that which it took along from its last
    /// ground. Zero while it stands. A game may add to it; a character that stands then takes off, with the velocity of its ground in
    /// addition.
    pub fall: Vec3,
    /// Time since it stood, s; 0 while it stands.
    pub airborne: f32,
    /// The pose of the ground after the last step.
    ground_pose: Pose,
    /// Velocity of the body that it stood on in the last step, where it stood, m/s.
    carried: Vec3,
    /// Time for which the ground has fallen away faster than the character falls, s.
    falling: f32,
    /// The height of its collider when it does not crouch, m, while it crouches.
    full_height: Option<f32>,
}

impl CharacterState {
    /// Whether it stands on something.
    pub fn stands(&self) -> bool {
        self.ground.is_some()
    }

    /// Whether its collider is lowered: it crouches, or has no room to get up.
    pub fn crouches(&self) -> bool {
        self.full_height.is_some()
    }
}

impl MapEntities for CharacterState {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        if let Some(ground) = &mut self.ground {
            ground.entity.map_entities(mapper);
        }
    }
}
