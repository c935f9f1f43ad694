//! One step of all characters.

use super::ground::Carried;
use super::{Character, CharacterState};
use crate::body::{BodyState, Forces, Pose, RigidBody, SpawnOrder, collider::Collider};
use crate::collider::LayerMask;
use crate::diagnosis::ReportedProblems;
use crate::query::{CharacterHit, Ground, QueryError, QueryFilter, SpatialQuery};
use crate::settings::{Gravity, StepTime};
use crate::solver::sort;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::NameOrEntity;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// The components of a character.
type Parts = (
    NameOrEntity,
    &'static SpawnOrder,
    &'static mut Character,
    &'static mut CharacterState,
    &'static mut Transform,
    Has<ChildOf>,
);

/// Moves all characters by a step, and pushes what they run into.
pub fn characters(
    world: SpatialQuery,
    (time, gravity): (Res<StepTime>, Res<Gravity>),
    mut characters: Query<Parts>,
    mut bodies: Query<Forces, Without<Character>>,
    mut told: ResMut<ReportedProblems>,
) {
    let dt = time.whole();
    let mut pushes: Vec<(SpawnOrder, CharacterHit, Vec3)> = Vec::new();
    for (name, &order, mut character, mut state, mut transform, is_child) in &mut characters {
        let entity = name.entity;
        let wants = *character;
        if wants.jump != 0.0 {
            character.jump = 0.0;
        }
        let from = Pose {
            position: transform.translation,
            rotation: transform.rotation,
        };
        let frame = Frame {
            gravity: gravity.0,
            dt,
        };
        let next = match is_child {
            true => Err("it has a parent".into()),
            false => wants.advance(&world, entity, *state, from, frame),
        };
        match next {
            Ok(None) => {}
            Ok(Some((next, to, hits))) => {
                told.characters.remove(&entity);
                state.set_if_neq(next);
                if (to.position, to.rotation) != (transform.translation, transform.rotation) {
                    (transform.translation, transform.rotation) = (to.position, to.rotation);
                }
                for hit in hits {
                    let push = hit.push(wants.push, dt);
                    if push != Vec3::ZERO {
                        pushes.push((order, hit, push));
                    }
                }
            }
            Err(error) => {
                if told.characters.insert(entity) {
                    tracing::error!("the character {name} does not move: {error}");
                }
            }
        }
    }
    // A sum of three depends on its order.
    sort::by_key(&mut pushes, |&(order, ..)| order);
    for (_, hit, push) in pushes {
        if let Ok(mut body) = bodies.get_mut(hit.entity) {
            body.apply_linear_impulse_at_point(push, hit.point);
        }
    }
}

/// Puts the bodies of characters where they went. They do not go there by a velocity: on a straight way they would run into the edges of
/// stairs, with any force.
pub fn take_places(
    mut characters: Query<(&Transform, &mut Pose), (With<Character>, Without<ChildOf>)>,
) {
    for (transform, mut pose) in &mut characters {
        pose.set_if_neq(Pose {
            position: transform.translation,
            rotation: transform.rotation,
        });
    }
}

/// A character after a step, and what it ran into. `None` while its body is not in the simulation.
type Advanced = Option<(CharacterState, Pose, Vec<CharacterHit>)>;

/// The parameters of a step besides the character and the world.
struct Frame {
    gravity: Vec3,
    dt: f32,
}

impl Character {
    fn advance(
        &self,
        world: &SpatialQuery,
        entity: Entity,
        mut state: CharacterState,
        from: Pose,
        frame: Frame,
    ) -> Result<Advanced, String> {
        let Some(body) = world.state(entity) else {
            return Ok(None);
        };
        let (RigidBody::Kinematic, Some(shape)) = (body.kind, &body.collider) else {
            return Err("it is no kinematic body with a collider".into());
        };
        if !(self.is_finite() && state.fall.is_finite()) {
            return Err("one of its numbers is not finite".into());
        }
        let failed = |error: QueryError| error.to_string();
        let rules = &self.rules;
        let up = *rules.up;
        let Frame { gravity, dt } = frame;
        let gravity = gravity * self.gravity_scale;
        let pull = -gravity.dot(up);
        let layers = body.properties.layers;

        let (start, carried) = self
            .carry(world, (body, shape), &mut state, from, (pull, dt))
            .map_err(failed)?;

        // By itself.
        let takes_off = self.jump > 0.0 || state.fall != Vec3::ZERO;
        let stands = carried.is_some() && !takes_off && !self.climbs;
        let walk = match self.climbs {
            true => self.walk,
            false => rules.level(self.walk),
        };
        let mut own = walk;
        if self.climbs {
            state.fall = Vec3::ZERO;
        } else if let Some(by) = &carried {
            own += by.belt;
            if takes_off {
                state.fall += up * self.jump.max(0.0);
            }
        } else if state.ground.is_some() {
            // Its ground is gone, and it goes on as it went.
            state.fall += state.carried;
        }
        if !stands && !self.climbs {
            state.fall += gravity * dt;
        }
        let alone = [entity];
        let way = (own + state.fall) * dt;
        let reach = way.length() + rules.step_height + rules.snap_distance;
        let stops = |other| self.is_stopped_by(world, other, (shape, start), reach);
        let mut filter = QueryFilter::default().excluding(&alone).with_layers(layers);
        if self.one_way != LayerMask::NONE {
            filter = filter.with_predicate(&stops);
        }
        let slide = (world.go(shape, start, way, stands, rules, &filter)).map_err(failed)?;

        let kept = carried.as_ref().filter(|_| !self.climbs);
        let kept = kept.map_or(Vec3::ZERO, Carried::surface);
        let mut ground = slide.ground.filter(|_| !self.climbs);
        if stands {
            // Over an edge.
            state.fall = kept;
        } else {
            // It keeps the velocity of what it took off from.
            state.fall += kept;
            ground = ground.filter(|ground| state.lands(world, ground, up, (pull, dt)));
            state.hit(world, &slide.hits);
        }
        let to = Pose {
            position: slide.position,
            ..start
        };
        state.velocity = (to.position - from.position) / dt;
        state.stand_on(ground, carried.filter(|_| stands), world, dt);
        Ok(Some((state, to, slide.hits)))
    }
}

impl Character {
    fn is_finite(&self) -> bool {
        let numbers = [self.jump, self.gravity_scale, self.push, self.crouch_height];
        numbers.into_iter().all(f32::is_finite) && self.walk.is_finite()
    }

    /// Moves a character with its ground, in a step of `dt` s in which gravity pulls it down at `pull`, m/s². Returns where it is then, and
    /// how its ground carries it, unless it leaves its ground.
    fn carry(
        &self,
        world: &SpatialQuery,
        (body, shape): (&BodyState, &Collider),
        state: &mut CharacterState,
        from: Pose,
        (pull, dt): (f32, f32),
    ) -> Result<(Pose, Option<Carried>), QueryError> {
        let rules = &self.rules;
        let up = *rules.up;
        let carried = state.carried(world, from.position, dt);
        let carried = carried
            .filter(|by| !state.leaves(up, by.velocity.dot(up), pull, rules.snap_distance, dt));
        let mut start = from;
        if let Some(by) = &carried {
            let own = [body.entity, by.ground];
            let layers = body.properties.layers;
            let others = QueryFilter::default().excluding(&own).with_layers(layers);
            let way = by.velocity * dt;
            let stops = |other| self.is_stopped_by(world, other, (shape, from), way.length());
            let others = others.with_predicate(&stops);
            start.position = world.carry(shape, from, way, rules, &others)?;
            start.rotation = (about(by.turn, up) * from.rotation).normalize();
        }
        Ok((start, carried))
    }
}

impl CharacterState {
    /// Whether a character that falls lands on what it comes down on, in a step of `dt` s in which gravity pulls it down at `pull`, m/s².
    /// Bodies that fall with it are no ground.
    fn lands(
        &self,
        world: &SpatialQuery,
        ground: &Ground,
        up: Vec3,
        (pull, dt): (f32, f32),
    ) -> bool {
        /// Faster than this upwards from its ground it does not stand where nothing pulls it down, m/s.
        const RISING_SPEED: f32 = 1e-3;
        let most = match pull > 0.0 {
            true => -0.5 * pull * dt,
            false => RISING_SPEED,
        };
        let rises = self.fall - world.went(ground.entity, ground.point);
        rises.dot(up) < most
    }

    /// Obstacles that it ran into take the part of its velocity that led there.
    fn hit(&mut self, world: &SpatialQuery, hits: &[CharacterHit]) {
        for hit in hits {
            let into = self.fall - world.went(hit.entity, hit.point);
            self.fall -= hit.normal * into.dot(hit.normal).min(0.0);
        }
    }
}

/// The part of a turn that is about an axis.
fn about(turn: Quat, axis: Vec3) -> Quat {
    let along = axis * turn.xyz().dot(axis);
    let twist = Quat::from_vec4(along.extend(turn.w));
    match twist.length_squared() > 1e-6 {
        true => twist.normalize(),
        false => Quat::IDENTITY,
    }
}
