//! Hands that hold the body that a ray points at.

use crate::body::{Grab, HeldBy, RigidBody, let_go_of};
use crate::diagnosis::ReportedProblems;
use crate::query::{QueryFilter, Ray3d, SpatialQuery};
use crate::schedule::{PhysicsSchedule, PhysicsSystems, refresh};
use bevy_app::{App, Plugin};
use bevy_ecs::entity::{EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{BVec3, Quat, Vec3};

/// Lets every [`Hand`] hold the body that it points at. The plugin is not part of [`DrystonePlugins`](crate::DrystonePlugins); add it after
/// them.
#[derive(Debug)]
pub struct HandPlugin;

impl Plugin for HandPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            PhysicsSchedule,
            (refresh_for_hands, hands)
                .chain()
                .before(PhysicsSystems::Prepare),
        );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// A hand that closes grabs bodies as they are now, including those that were spawned or moved since the last step.
pub(crate) fn refresh_for_hands(
    world: &mut World,
    hands: &mut QueryState<(Entity, &'static mut Hand, &'static mut HandState)>,
) {
    let mut closes = false;
    for (_, hand, state) in hands.query(world) {
        closes |= hand.closed && *state == HandState::Open && hand.ray.is_some();
    }
    if closes {
        refresh(world);
    }
}

/// A hand that points along a ray of a camera, a player or a pointer. When it is closed it grabs the first dynamic body that the ray hits,
/// and keeps the point that was hit on the ray, at the same distance. When it is opened it releases the body.
///
/// A body is held by one hand at a time: a hand that closes on a body with a [`Grab`] holds nothing. It loses a body that is disabled, or
/// whose `Grab` is removed.
///
/// Numbers that are not finite, out of bounds or negative are logged as an error and have no effect: the hand continues to hold as before,
/// or grabs nothing.
///
/// ```
/// # use bevy_transform::components::Transform;
/// # use drystone::prelude::*;
/// # let mut app = bevy_app::App::new();
/// app.add_plugins((DrystonePlugins::default(), HandPlugin));
/// # let world = app.world_mut();
/// # let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), Mass(500.0));
/// # let brick = world.spawn((brick, Transform::from_xyz(0.0, 0.25, 0.0))).id();
/// # world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// let pointer = Ray3d::new(Vec3::new(0.0, 0.3, 5.0), Dir3::NEG_Z);
/// let hand = world.spawn(Hand { ray: Some(pointer), closed: true, ..Hand::new(10_000.0) }).id();
/// # drystone::step(world, 1.0 / 60.0).unwrap();
/// assert_eq!(world.get::<HandState>(hand).unwrap().held(), Some(brick));
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[require(HandState)]
pub struct Hand {
    /// The ray that it points along. With `None` the body is held where it is.
    pub ray: Option<Ray3d>,
    /// Whether it is closed. A closed hand holds the body that it pointed at when it was closed.
    pub closed: bool,
    /// Maximum distance at which it grabs a body, m. Default: 100.
    pub reach: f32,
    /// Maximum force, N.
    pub max_force: f32,
    /// Maximum torque, N·m.
    pub max_torque: f32,
    /// The world axes along which it pulls. Default: all. See [`Grab::axes`].
    pub axes: BVec3,
    /// The world axes about which it turns the body. Default: all. See [`Grab::turn_axes`].
    pub turn_axes: BVec3,
    /// The orientation to which it turns the body, world. With `None` it only stops the rotation.
    pub rotation: Option<Quat>,
    /// Distance along the ray at which it holds the body, m. It is set when a body is grabbed, and may be changed from then on.
    pub distance: f32,
}

/// The body that a [`Hand`] holds. The clone of a hand holds nothing.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = let_go, clone_behavior = Ignore, map_entities)]
pub enum HandState {
    /// The hand is open.
    #[default]
    Open,
    /// The hand is closed and holds nothing. It must be opened before it can grab a body again.
    Empty,
    /// The hand holds a body at a point in the body's frame, m.
    Holds(Entity, Vec3),
}

impl MapEntities for HandState {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        if let Self::Holds(body, _) = self {
            body.map_entities(mapper);
        }
    }
}

impl Hand {
    /// An open hand with a maximum force (N), a reach of 100 m, and a maximum torque of that force times a quarter of a metre.
    pub fn new(max_force: f32) -> Self {
        Self {
            ray: None,
            closed: false,
            reach: 100.0,
            max_force,
            max_torque: 0.25 * max_force,
            axes: BVec3::TRUE,
            turn_axes: BVec3::TRUE,
            rotation: None,
            distance: 0.0,
        }
    }
}

impl HandState {
    /// The body that is held.
    pub fn held(&self) -> Option<Entity> {
        match *self {
            Self::Holds(body, _) => Some(body),
            Self::Open | Self::Empty => None,
        }
    }
}

/// Releases the body when the hand is removed.
fn let_go(mut world: DeferredWorld, context: HookContext) {
    let hand = context.entity;
    let held = world.get::<HandState>(hand).and_then(HandState::held);
    if let Some(body) = held.filter(|&body| world.get::<HeldBy>(body) == Some(&HeldBy(hand))) {
        let_go_of(&mut world.commands(), body);
    }
}

/// Bodies that a hand may hold.
type Bodies<'w, 's> = Query<
    'w,
    's,
    (
        &'static RigidBody,
        Option<&'static mut Grab>,
        Option<&'static HeldBy>,
    ),
    Allow<Disabled>,
>;

/// Grabs and releases bodies, before every step.
pub fn hands(
    mut commands: Commands,
    world: SpatialQuery,
    mut hands: Query<(Entity, &mut Hand, &mut HandState)>,
    mut bodies: Bodies,
    mut told: ResMut<ReportedProblems>,
) {
    // All releases come first, so that a body can go from one hand to another in one step.
    let mut freed = EntityHashSet::default();
    let mut taken = EntityHashSet::default();
    for (entity, hand, mut state) in &mut hands {
        if hand.closed || *state == HandState::Open {
            continue;
        }
        if let Some(body) = state.held().filter(|&body| holds(&bodies, entity, body)) {
            let_go_of(&mut commands, body);
            freed.insert(body);
        }
        *state = HandState::Open;
        told.hands.remove(&entity);
    }
    for (entity, mut hand, mut state) in &mut hands {
        if !hand.closed {
            continue;
        }
        match (*state, hand.ray) {
            (HandState::Open, Some(ray)) => {
                *state = HandState::Empty;
                let hit = match world.cast_ray(ray, hand.reach, &QueryFilter::default()) {
                    Ok(Some(hit)) => hit,
                    Ok(None) => continue,
                    Err(error) => {
                        tracing::error!("the hand {entity} takes hold of nothing: {error}");
                        continue;
                    }
                };
                let body = hit.entity;
                let (Ok((RigidBody::Dynamic, grab, _)), Some(pose)) =
                    (bodies.get(body), world.pose(body))
                else {
                    continue;
                };
                if (grab.is_some() && !freed.contains(&body)) || !taken.insert(body) {
                    continue;
                }
                let local = pose.inverse_transform_point(hit.point);
                let grab = hand.grab(local, hit.point);
                if !grab.is_valid() {
                    tracing::error!("the hand {entity} takes hold of nothing: {INVALID_MESSAGE}");
                    continue;
                }
                *state = HandState::Holds(body, local);
                hand.distance = hit.distance;
                commands.entity(body).try_insert((grab, HeldBy(entity)));
            }
            (HandState::Holds(body, local), ray) => {
                // The body may have been despawned, or its `Grab` removed or replaced.
                if !holds(&bodies, entity, body) {
                    *state = HandState::Empty;
                    continue;
                }
                let Ok((_, Some(mut grab), _)) = bodies.get_mut(body) else {
                    continue;
                };
                let target = ray.map_or(grab.target, |ray| ray.get_point(hand.distance));
                let wanted = hand.grab(local, target);
                if wanted.is_valid() {
                    grab.set_if_neq(wanted);
                    told.hands.remove(&entity);
                } else if told.hands.insert(entity) {
                    tracing::error!(
                        "the hand {entity} holds on to {body} as before: {INVALID_MESSAGE}"
                    );
                }
            }
            (HandState::Open | HandState::Empty, _) => {}
        }
    }
}

/// The log message for a hand with invalid numbers.
const INVALID_MESSAGE: &str =
    "its ray, distance, rotation, force or torque is not finite, out of bounds or negative";

/// Returns true if the body exists and is held by this hand.
fn holds(bodies: &Bodies, hand: Entity, body: Entity) -> bool {
    let held = bodies.get(body);
    held.is_ok_and(|(_, grab, by)| grab.is_some() && by == Some(&HeldBy(hand)))
}

impl Hand {
    fn grab(&self, local_point: Vec3, target: Vec3) -> Grab {
        Grab {
            rotation: self.rotation,
            max_force: self.max_force,
            max_torque: self.max_torque,
            axes: self.axes,
            turn_axes: self.turn_axes,
            // The values for a body without mass, because the speed of a hand does not depend on the body.
            ..Grab::gentle(0.0, local_point, target)
        }
    }
}
