//! Casters: components that cast a ray or a shape at the end of every step and keep what they hit.
//!
//! Put [`RayCaster`] or [`ShapeCaster`] on any entity with a `Transform`: on a body, on a child of one (the muzzle of a gun, the feet of a
//! robot), or on something that is no body, such as a camera. Origin and direction are in its frame. Unless it is told otherwise, a caster
//! does not hit the body that it is on or below. For a question at another time, ask [`SpatialQuery`].
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let drone = (RigidBody::Dynamic, Collider::ball(0.2), GravityScale(0.0), Transform::from_xyz(0.0, 3.0, 0.0));
//! let feeler = world.spawn((RayCaster::new(Vec3::NEG_Y * 0.2, Dir3::NEG_Y), Transform::default())).id();
//! world.spawn(drone).add_child(feeler);
//! drystone::step(world, 1.0 / 60.0).unwrap();
//!
//! fn altitude(feelers: Query<&RayCaster>) -> Option<f32> {
//!     feelers.iter().find_map(|feeler| Some(feeler.first()?.distance))
//! }
//! # use bevy_ecs::system::RunSystemOnce;
//! let altitude = world.run_system_once(altitude).unwrap().unwrap();
//! assert!((altitude - 2.8).abs() < 1e-5);
//! ```

use crate::body::{Pose, RigidBody, collider::Collider, collider::CollisionLayers};
use crate::components::{any_with, init};
use crate::profile::{Profile, own};
use crate::query::{CastHit, Dir3, QueryError, QueryFilter, Ray3d, RayHit, SpatialQuery};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::settings::is_last;
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// Casts the rays and shapes of all casters. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct CasterPlugin;

/// The system set in which casters cast: in the last substep of each step, after *sensors*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CasterSystems;

impl Plugin for CasterPlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        let profile = app.world().resource::<Profile>().clone();
        app.add_systems(
            PhysicsSchedule,
            (
                own(&profile, "sensors", cast_rays)
                    .run_if(any_with(Components::component_id::<RayCaster>)),
                own(&profile, "sensors", cast_shapes)
                    .run_if(any_with(Components::component_id::<ShapeCaster>)),
            )
                .chain()
                .run_if(is_last)
                .after(PhysicsSystems::Sensors)
                .before(PhysicsSystems::ContactEvents)
                .in_set(CasterSystems),
        );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// What a caster may hit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, PartialEq, Default)
)]
pub struct CasterRules {
    /// How far it reaches, m; may be infinite. Default: infinite.
    pub max_distance: f32,
    /// How many bodies it may hit, the nearest first. Default: 1.
    pub max_hits: usize,
    /// It hits only what a body with these layers would collide with. Default: everything.
    pub layers: Option<CollisionLayers>,
    /// Bodies and colliders that it ignores. Default: none.
    pub excluded: Vec<Entity>,
    /// Whether it ignores the body that it is on or below. Default: `true`.
    pub ignores_own_body: bool,
    /// Whether it casts. Without, it keeps its last hits. Default: `true`.
    pub enabled: bool,
}

impl Default for CasterRules {
    fn default() -> Self {
        Self {
            max_distance: f32::INFINITY,
            max_hits: 1,
            layers: None,
            excluded: Vec::new(),
            ignores_own_body: true,
            enabled: true,
        }
    }
}

/// Casts a ray at the end of every step, and keeps what it hits; see the [module](self). It counts as changed when its hits change.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
pub struct RayCaster {
    /// Where the ray begins, in the frame of the entity, m.
    pub origin: Vec3,
    /// Its direction in the frame of the entity.
    pub direction: Dir3,
    /// What it may hit.
    pub rules: CasterRules,
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    hits: Vec<RayHit>,
}

impl RayCaster {
    /// A ray from a point, m, in the frame of the entity.
    pub fn new(origin: Vec3, direction: Dir3) -> Self {
        Self {
            origin,
            direction,
            rules: CasterRules::default(),
            hits: Vec::new(),
        }
    }

    /// Sets what it may hit.
    #[must_use]
    pub fn with_rules(mut self, rules: CasterRules) -> Self {
        self.rules = rules;
        self
    }

    /// What it hit in the last step, the nearest first.
    pub fn hits(&self) -> &[RayHit] {
        &self.hits
    }

    /// The nearest hit of the last step.
    pub fn first(&self) -> Option<RayHit> {
        self.hits.first().copied()
    }
}

/// Casts a shape at the end of every step, and keeps what it hits; see the [module](self). It counts as changed when its hits change.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
pub struct ShapeCaster {
    /// The shape.
    pub collider: Collider,
    /// Where it begins, in the frame of the entity, m.
    pub origin: Vec3,
    /// How it is turned in the frame of the entity.
    pub rotation: Quat,
    /// Its direction in the frame of the entity.
    pub direction: Dir3,
    /// What it may hit.
    pub rules: CasterRules,
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    hits: Vec<CastHit>,
}

impl ShapeCaster {
    /// A shape that begins at a point, m, in the frame of the entity.
    pub fn new(collider: Collider, origin: Vec3, direction: Dir3) -> Self {
        Self {
            collider,
            origin,
            rotation: Quat::IDENTITY,
            direction,
            rules: CasterRules::default(),
            hits: Vec::new(),
        }
    }

    /// Turns the shape in the frame of the entity.
    #[must_use]
    pub fn with_rotation(mut self, rotation: Quat) -> Self {
        self.rotation = rotation;
        self
    }

    /// Sets what it may hit.
    #[must_use]
    pub fn with_rules(mut self, rules: CasterRules) -> Self {
        self.rules = rules;
        self
    }

    /// What it hit in the last step, the nearest first.
    pub fn hits(&self) -> &[CastHit] {
        &self.hits
    }

    /// The nearest hit of the last step.
    pub fn first(&self) -> Option<CastHit> {
        self.hits.first().copied()
    }
}

/// Where entities are in the hierarchy, and whether they are bodies.
type Places<'w, 's> = Query<'w, 's, (&'static Transform, Option<&'static ChildOf>, Has<RigidBody>)>;

/// Casts the rays of all [`RayCaster`]s.
pub fn cast_rays(
    world: SpatialQuery,
    places: Places,
    mut casters: Query<(Entity, &mut RayCaster)>,
) {
    for (entity, mut caster) in &mut casters {
        let hits = cast(entity, &caster.rules, places, |frame, most, filter| {
            let origin = frame.transform_point(caster.origin);
            let ray = Ray3d::new(origin, turned(frame, caster.direction)?);
            let far = caster.rules.max_distance;
            match most {
                1 => Ok(world.cast_ray(ray, far, filter)?.into_iter().collect()),
                _ => world.cast_ray_through(ray, far, filter),
            }
        });
        let Some(hits) = hits else { continue };
        let hits = hits.unwrap_or_else(|error| switch_off(entity, &mut caster.rules, &error));
        if hits != caster.hits {
            caster.hits = hits;
        }
    }
}

/// Casts the shapes of all [`ShapeCaster`]s.
pub fn cast_shapes(
    world: SpatialQuery,
    places: Places,
    mut casters: Query<(Entity, &mut ShapeCaster)>,
) {
    for (entity, mut caster) in &mut casters {
        let hits = cast(entity, &caster.rules, places, |frame, most, filter| {
            let from = Pose {
                position: frame.transform_point(caster.origin),
                rotation: (frame.rotation * caster.rotation).normalize(),
            };
            let direction = turned(frame, caster.direction)?;
            let (shape, far) = (&caster.collider, caster.rules.max_distance);
            match most {
                1 => {
                    let hit = world.cast_shape(shape, from, direction, far, filter)?;
                    Ok(hit.into_iter().collect())
                }
                _ => world.cast_shape_through(shape, from, direction, far, filter),
            }
        });
        let Some(hits) = hits else { continue };
        let hits = hits.unwrap_or_else(|error| switch_off(entity, &mut caster.rules, &error));
        if hits != caster.hits {
            caster.hits = hits;
        }
    }
}

/// Casts with the rules of a caster: `ask` is told where the caster is, how many hits are wanted, and the filter. `None` if the caster is
/// switched off or is nowhere.
fn cast<H>(
    entity: Entity,
    rules: &CasterRules,
    places: Places,
    ask: impl FnOnce(Transform, usize, &QueryFilter) -> Result<Vec<H>, QueryError>,
) -> Option<Result<Vec<H>, QueryError>> {
    if !rules.enabled {
        return None;
    }
    let (&own, mut parent, mut is_body) = places.get(entity).ok()?;
    let (mut frame, mut at) = (own, entity);
    let mut excluded = rules.excluded.clone();
    loop {
        if is_body && rules.ignores_own_body {
            excluded.push(at);
        }
        let Some(&ChildOf(above)) = parent else { break };
        let Ok((&of_parent, grandparent, above_is_body)) = places.get(above) else {
            break;
        };
        frame = of_parent * frame;
        (parent, is_body, at) = (grandparent, above_is_body, above);
    }
    let mut filter = QueryFilter::default().excluding(&excluded);
    if let Some(layers) = rules.layers {
        filter = filter.with_layers(layers);
    }
    let mut hits = ask(frame, rules.max_hits, &filter);
    if let Ok(hits) = &mut hits {
        hits.truncate(rules.max_hits);
    }
    Some(hits)
}

/// A direction of a frame in the world.
fn turned(frame: Transform, direction: Dir3) -> Result<Dir3, QueryError> {
    Dir3::new(frame.rotation * *direction).map_err(|_| QueryError::NotFinite("the direction"))
}

/// Has a caster cast no more because of an error. It hits nothing.
fn switch_off<H>(caster: Entity, rules: &mut CasterRules, error: &QueryError) -> Vec<H> {
    tracing::error!("the caster {caster} is switched off: {error}; correct it and set `enabled`");
    rules.enabled = false;
    Vec::new()
}
