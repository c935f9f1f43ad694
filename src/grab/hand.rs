//! A hand at the end of a ray.

use super::Grab;
use crate::body::{Pose, RigidBody};
use crate::query::{QueryFilter, Ray3d, SpatialQuery};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::{Quat, Vec3};

/// Lets every [`Hand`] hold what it points at. It is in none of the plugins of [`DrystonePlugins`](crate::DrystonePlugins); add it after them.
pub struct HandPlugin;

impl Plugin for HandPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PhysicsSchedule, hands.before(PhysicsSystems::Prepare));
    }
}

/// A hand that points along a ray: on a camera, a player, a pointer. Closed it takes hold of the first dynamic body that the ray hits, where it hits it,
/// and holds that point on the ray, as far away as it was; open it lets go.
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
/// # drystone::step(world, 1.0 / 60.0).unwrap();
/// let pointer = Ray3d::new(Vec3::new(0.0, 0.3, 5.0), Dir3::NEG_Z);
/// let hand = world.spawn(Hand { ray: Some(pointer), closed: true, ..Hand::new(10_000.0) }).id();
/// # for _ in 0..2 { drystone::step(world, 1.0 / 60.0).unwrap(); }
/// assert_eq!(world.get::<Grasp>(hand).unwrap().held(), Some(brick));
/// ```
#[derive(Component, Clone, Copy, Debug)]
#[require(Grasp)]
pub struct Hand {
    /// Where it points; nowhere, and what it holds stays where it is held.
    pub ray: Option<Ray3d>,
    /// It holds what it pointed at when it was closed.
    pub closed: bool,
    /// How far it reaches, m.
    pub reach: f32,
    /// How strong it is, N.
    pub max_force: f32,
    /// N·m
    pub max_torque: f32,
    /// How it would have turned what it holds; where there is none it keeps that from spinning.
    pub rotation: Option<Quat>,
    /// How far along the ray it holds, m: found when it takes hold, and may be changed then.
    pub distance: f32,
}

/// What a [`Hand`] holds.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(on_remove = let_go)]
pub enum Grasp {
    /// It is open.
    #[default]
    Open,
    /// It closed on nothing, or lost what it held, and must be opened before it takes hold again.
    Empty,
    /// A body, at a point of it, in its frame, m.
    Holds(Entity, Vec3),
}

impl Hand {
    /// An open hand of so many newtons that reaches 100 m, and turns as hard as with a quarter of a metre for a lever.
    pub fn new(max_force: f32) -> Self {
        Self {
            ray: None,
            closed: false,
            reach: 100.0,
            max_force,
            max_torque: 0.25 * max_force,
            rotation: None,
            distance: 0.0,
        }
    }
}

impl Grasp {
    /// The body that is held.
    pub fn held(&self) -> Option<Entity> {
        match *self {
            Self::Holds(body, _) => Some(body),
            Self::Open | Self::Empty => None,
        }
    }
}

/// The hand is gone.
fn let_go(mut world: DeferredWorld, context: HookContext) {
    let held = world.get::<Grasp>(context.entity).and_then(Grasp::held);
    if let Some(body) = held {
        world.commands().entity(body).try_remove::<Grab>();
    }
}

/// Takes hold and lets go, before every step.
pub fn hands(
    mut commands: Commands,
    world: SpatialQuery,
    mut hands: Query<(Entity, &mut Hand, &mut Grasp)>,
    mut bodies: Query<(&RigidBody, &Pose, Option<&mut Grab>)>,
) {
    for (entity, mut hand, mut grasp) in &mut hands {
        match (hand.closed, *grasp, hand.ray) {
            (false, Grasp::Holds(body, _), _) => {
                commands.entity(body).try_remove::<Grab>();
                *grasp = Grasp::Open;
            }
            (false, Grasp::Empty, _) => *grasp = Grasp::Open,
            (true, Grasp::Open, Some(ray)) => {
                *grasp = Grasp::Empty;
                match world.cast_ray(ray, hand.reach, &QueryFilter::default()) {
                    Ok(Some(hit)) => {
                        if let Ok((RigidBody::Dynamic, pose, _)) = bodies.get(hit.entity) {
                            let local = pose.inverse_transform_point(hit.point);
                            *grasp = Grasp::Holds(hit.entity, local);
                            hand.distance = hit.distance;
                            commands
                                .entity(hit.entity)
                                .try_insert(hand.grab(local, hit.point));
                        }
                    }
                    Ok(None) => {}
                    Err(error) => {
                        tracing::error!("the hand {entity} takes hold of nothing: {error}")
                    }
                }
            }
            (true, Grasp::Holds(body, local), ray) => {
                // Somebody else may have taken it, or taken it away.
                let Ok((_, _, Some(mut grab))) = bodies.get_mut(body) else {
                    *grasp = Grasp::Empty;
                    continue;
                };
                let target = ray.map_or(grab.target, |ray| ray.get_point(hand.distance));
                grab.set_if_neq(hand.grab(local, target));
            }
            (_, Grasp::Open | Grasp::Empty, _) => {}
        }
    }
}

impl Hand {
    fn grab(&self, local_point: Vec3, target: Vec3) -> Grab {
        Grab {
            rotation: self.rotation,
            max_force: self.max_force,
            max_torque: self.max_torque,
            // What it takes for a body without weight: how fast a hand is does not depend on what it holds.
            ..Grab::gentle(0.0, local_point, target)
        }
    }
}
