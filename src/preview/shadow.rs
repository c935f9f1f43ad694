//! The shadow: a copy of part of a world.

use super::copy::{Activity, OriginalState, copy, copy_joint, empty, to_transform};
use super::region::Region;
use super::{Edit, Moved, Preview, PreviewError, PreviewSettings};
use crate::body::collider::{Collider, CollisionExceptions};
use crate::body::{BodyState, Pose, RigidBody, Sleeping, Velocity, parts::shape_of};
use crate::graph::Islands;
use crate::schedule::step;
use crate::settings::{Preset, STEP_LENGTHS, SleepSettings, StepTime};
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use bevy_platform::collections::hash_map::Entry;
use bevy_time::{Fixed, Time};
use parry3d::bounding_volume::Aabb;

/// A body that has been still for this time counts as at rest, s.
const REST_TIME: f32 = 0.25;

/// A body counts as not falling if it has hardly moved since the beginning and its speed is below this share of the speed limits of
/// sleeping. Before the time [`REST_TIME`] has passed, the share is proportionally lower. To fall nevertheless, the body would have to
/// accelerate faster than a tipping body does.
const SPEED_SHARE: f32 = 0.4;

/// Before the time [`REST_TIME`] has passed, the full share [`SPEED_SHARE`] holds for a body whose speed is below this multiple of that in
/// the step before: it comes to rest, because a body that begins to fall gains speed. The springs of contacts that were unloaded push
/// bodies away with some mm/s, and a quarter less in each step.
const SLOWING_FACTOR: f32 = 0.9;

/// No world counts as at rest before this time, s: two steps at 60 Hz. In a shorter time nothing gets fast enough to be told from what
/// rests.
const MIN_REST_TIME: f32 = 0.03;

/// Number of steps beyond which steps are lengthened, but not beyond those of 60 Hz. It is that of ten seconds at 240 Hz.
const MOST_STEPS: f32 = 2400.0;

/// A copy of part of a world, which can be stepped on its own and sent to another thread.
#[derive(Debug)]
pub struct Shadow {
    world: World,
    /// In spawn order.
    bodies: Vec<Copied>,
    /// Copies of joints, and the bodies of the originals.
    joints: Vec<(Entity, [Option<Entity>; 2])>,
    /// The copy of the body that the edit moves or adds.
    edited: Option<Entity>,
    /// Length of a step of the original world, s.
    dt: f32,
}

/// The pose of a body when it slept, or after the first step, and its linear (m/s) and angular speed (rad/s) after the last one.
struct Seen {
    first: Pose,
    speeds: [f32; 2],
}

/// The distance (m) and the angle (rad) between two poses.
fn way(from: &Pose, to: &Pose) -> [f32; 2] {
    // For small angles the cosine of the angle has no significant digits left.
    let turned = 2.0 * (to.rotation - from.rotation).length();
    [from.position.distance(to.position), turned]
}

/// Returns true if both are less than at the speed limits of sleeping times some time (s), or share.
fn is_less(limits: &SleepSettings, times: [f32; 2], [linear, angular]: [f32; 2]) -> bool {
    linear < times[0] * limits.linear_speed && angular < times[1] * limits.angular_speed
}

/// A body and its copy.
#[derive(Clone, Copy, Debug)]
struct Copied {
    original: Entity,
    copy: Entity,
    from: Pose,
    radius: f32,
    dynamic: bool,
}

impl Shadow {
    /// Copies the structures that an edit affects, and the bodies near them, and applies the edit to the copy. A body is near if it is not
    /// farther away than the structures are large.
    ///
    /// # Errors
    /// As [`preview`](super::preview()).
    pub fn of(world: &World, edit: &Edit) -> Result<Self, PreviewError> {
        match edit {
            Edit::Remove(bodies) => {
                if bodies.is_empty() {
                    return Err(PreviewError::Nothing);
                }
                let mut shadow = Self::around(world, bodies)?;
                for &body in bodies {
                    shadow.remove_joints_of(body);
                    if let Some(copy) = shadow.copy_of(body) {
                        shadow.world.despawn(copy);
                    }
                }
                Ok(shadow)
            }
            Edit::Move(body, pose) => {
                let collider = shape_of(world, *body);
                let there = collider
                    .map(|collider| extent(collider, *pose))
                    .transpose()?;
                let mut shadow = Self::copied(world, &[*body], there)?;
                shadow.edited = shadow.copy_of(*body);
                if let Some(copy) = shadow.edited {
                    shadow.world.entity_mut(copy).insert(to_transform(*pose));
                }
                Ok(shadow)
            }
            Edit::Place(collider, pose) => {
                let mut shadow = Self::copied(world, &[], Some(extent(collider, *pose)?))?;
                let body = (RigidBody::Dynamic, collider.clone(), to_transform(*pose));
                shadow.edited = Some(shadow.world.spawn(body).id());
                Ok(shadow)
            }
        }
    }

    /// Copies the structures that some bodies belong to, and the bodies near them. A body is near if it is not farther away than the
    /// structures are large.
    ///
    /// # Errors
    /// [`PreviewError::NotABody`] if one of them is not a body.
    pub fn around(world: &World, bodies: &[Entity]) -> Result<Self, PreviewError> {
        Self::copied(world, bodies, None)
    }

    /// The copy of a body, in the world of the copies.
    pub fn copy_of(&self, body: Entity) -> Option<Entity> {
        let mut bodies = self.bodies.iter();
        Some(bodies.find(|copied| copied.original == body)?.copy)
    }

    /// The world of the copies, for further edits.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// The world of the copies, for your own steps.
    pub fn into_world(self) -> World {
        self.world
    }

    /// Takes steps until all bodies are at rest or [`PreviewSettings::max_time`] is over.
    ///
    /// If no body has begun to move after a few steps, the world counts as at rest: in one step of 1/60 s a falling body reaches a speed
    /// that a body at rest may have after a quarter of a second.
    ///
    /// # Errors
    /// [`PreviewError::InvalidSettings`] if the settings are invalid.
    pub fn run(mut self, settings: &PreviewSettings) -> Result<Preview, PreviewError> {
        settings.check()?;
        let shortest = (settings.max_time / MOST_STEPS).min(Preset::Default.dt());
        let dt = settings.dt.unwrap_or(self.dt).max(shortest);
        let slow = *self.world.resource::<SleepSettings>();
        // In double precision, because many short steps would not add up exactly in single precision.
        let mut time = 0.0_f64;
        let mut rests = false;
        let mut bodies = (self.world).query::<(Entity, &RigidBody, &Sleeping, &Pose, &Velocity)>();
        let mut seen: EntityHashMap<Seen> = EntityHashMap::default();
        while time < f64::from(settings.max_time) && !rests {
            step(&mut self.world, dt).expect("the length of a step has been checked");
            time += f64::from(dt);
            let passed = time as f32;
            let share_now = SPEED_SHARE * (passed / REST_TIME).min(1.0);
            rests = passed >= MIN_REST_TIME;
            for (body, kind, sleeping, pose, velocity) in bodies.iter(&self.world) {
                if *kind != RigidBody::Dynamic {
                    continue;
                }
                let speeds = [velocity.linear.length(), velocity.angular.length()];
                let now = Seen {
                    first: *pose,
                    speeds,
                };
                if sleeping.asleep {
                    seen.insert(body, now);
                    continue;
                }
                // Bodies that were awake before the edit may have been still for a long time already.
                let was_still = passed >= REST_TIME && sleeping.still_for >= REST_TIME;
                let stays = match seen.entry(body) {
                    Entry::Occupied(mut entry) => {
                        let seen = entry.get_mut();
                        let before = std::mem::replace(&mut seen.speeds, speeds);
                        let share = |i: usize| match speeds[i] < SLOWING_FACTOR * before[i] {
                            true => SPEED_SHARE,
                            false => share_now,
                        };
                        is_less(&slow, [share(0), share(1)], speeds)
                            && is_less(&slow, [passed.min(REST_TIME); 2], way(&seen.first, pose))
                    }
                    Entry::Vacant(entry) => {
                        entry.insert(now);
                        false
                    }
                };
                rests &= was_still || stays;
            }
        }
        let others = self.bodies.iter();
        let others = others.filter(|body| body.dynamic && self.edited != Some(body.copy));
        let moved = others.filter_map(|body| {
            let to = *self.world.get::<Pose>(body.copy)?;
            let far = to.position.distance(body.from.position)
                + to.rotation.angle_between(body.from.rotation) * body.radius;
            (far > settings.movement_threshold * body.radius).then_some(Moved {
                body: body.original,
                from: body.from,
                to,
            })
        });
        Ok(Preview {
            moved: moved.collect(),
            end_pose: self.edited.and_then(|copy| self.world.get(copy).copied()),
            at_rest: rests,
            time: time as f32,
        })
    }

    /// Copies the surroundings of some bodies, and of a box that a body will occupy.
    fn copied(world: &World, bodies: &[Entity], there: Option<Aabb>) -> Result<Self, PreviewError> {
        let region = Region::of(world, bodies, there)?;
        let mut shadow = Self {
            world: empty(world),
            bodies: Vec::new(),
            joints: Vec::new(),
            edited: None,
            dt: length_of_a_step(world),
        };
        let (mut copies, mut poses) = (HashMap::default(), HashMap::default());
        let (mut accounts, mut bereft) = (HashMap::default(), Vec::new());
        let mut drifts = HashMap::default();
        let islands = world.resource::<Islands>();
        for &slot in &region.slots {
            let body = region.table.get(slot).expect("it is in the region");
            let activity = match region.structure.contains(&slot) {
                true => Activity::AsOriginal,
                false => Activity::Asleep,
            };
            let from = world.get::<Pose>(body.entity).copied().unwrap_or(body.pose);
            let copy = shadow.add(world, body, from, activity);
            copies.insert(body.entity, copy);
            poses.insert(copy, (from, from != body.pose));
            accounts.extend(islands.account(slot).map(|forces| (copy, forces)));
            drifts.extend(islands.drift(slot).map(|drift| (copy, drift)));
            bereft.extend(region.bereft.contains(&slot).then_some(copy));
        }
        let contacts = region.contacts(world, &copies);
        for (joint, bodies) in region.joints(world) {
            shadow.join(world, joint, bodies);
        }
        for body in region.pending {
            shadow.bring_up_to_date(world, body);
        }
        // As in the next step, bodies that are joined wake.
        for (joint, bodies) in region.added {
            if shadow.join(world, joint, bodies) {
                shadow.wake(bodies);
            }
        }
        shadow.copy_exceptions(world);
        shadow.world.insert_resource(OriginalState {
            contacts,
            poses,
            accounts,
            drifts,
            bereft,
        });
        Ok(shadow)
    }

    /// Removes the copies of a body's joints, and wakes the bodies at their other ends.
    fn remove_joints_of(&mut self, body: Entity) {
        let removed = self
            .joints
            .extract_if(.., |(_, bodies)| bodies.contains(&Some(body)));
        for (joint, bodies) in removed.collect::<Vec<_>>() {
            self.world.despawn(joint);
            self.wake(bodies);
        }
    }

    /// Copies a joint, if its bodies are copied. Returns whether they are.
    fn join(&mut self, world: &World, joint: Entity, bodies: [Option<Entity>; 2]) -> bool {
        let ends = bodies.map(|body| body.and_then(|body| self.copy_of(body)));
        if ends.map(|end| end.is_none()) != bodies.map(|body| body.is_none()) {
            return false;
        }
        let copy = copy_joint(world, joint, &mut self.world, ends);
        self.joints.extend(copy.map(|copy| (copy, bodies)));
        copy.is_some()
    }

    /// Wakes the copies of bodies.
    fn wake(&mut self, bodies: [Option<Entity>; 2]) {
        for body in bodies.into_iter().flatten() {
            if let Some(copy) = self.copy_of(body)
                && let Some(mut sleeping) = self.world.get_mut::<Sleeping>(copy)
            {
                sleeping.wake();
            }
        }
    }

    /// Copies the collision exceptions between bodies.
    fn copy_exceptions(&mut self, world: &World) {
        let bodies = self.bodies.iter();
        let copies: EntityHashMap<Entity> = bodies
            .map(|copied| (copied.original, copied.copy))
            .collect();
        for copied in &self.bodies {
            if let Some(exceptions) = world.get::<CollisionExceptions>(copied.original) {
                let others = exceptions.0.iter().filter_map(|body| copies.get(body));
                let others: CollisionExceptions = others.copied().collect();
                self.world.entity_mut(copied.copy).insert(others);
            }
        }
    }

    /// Adds a copy of a body that starts at a pose.
    fn add(&mut self, world: &World, body: &BodyState, from: Pose, activity: Activity) -> Entity {
        let copy = copy(world, body, &mut self.world, activity);
        self.bodies.push(Copied {
            original: body.entity,
            copy,
            from,
            radius: body.radius,
            dynamic: body.is_dynamic(),
        });
        copy
    }

    /// Moves the copy of a body that was spawned or moved since the last step to where the next step will find it.
    fn bring_up_to_date(&mut self, world: &World, body: &BodyState) {
        let mut copies = self.bodies.iter_mut();
        let copy = match copies.find(|copied| copied.original == body.entity) {
            Some(copied) => {
                copied.from = body.pose;
                copied.copy
            }
            None => self.add(world, body, body.pose, Activity::AsOriginal),
        };
        let transform = to_transform(body.pose);
        self.world.entity_mut(copy).insert(transform);
    }
}

/// Length of the last step, s. Before the first step it is that of the app's fixed time step, or that of the default preset if there is no
/// clock.
fn length_of_a_step(world: &World) -> f32 {
    let last = world.resource::<StepTime>().whole();
    let clock = world.get_resource::<Time<Fixed>>();
    let fixed = clock.map(|clock| clock.timestep().as_secs_f32());
    let known = [Some(last), fixed].into_iter().flatten();
    let mut known = known.filter(|dt| STEP_LENGTHS.contains(dt));
    known.next().unwrap_or_else(|| Preset::Default.dt())
}

/// The bounding box of a collider at a pose.
fn extent(collider: &Collider, pose: Pose) -> Result<Aabb, PreviewError> {
    let pose = pose.normalized();
    if !pose.is_finite() {
        return Err(PreviewError::NotFinite);
    }
    if collider.is_degenerate() || collider.shape().as_halfspace().is_some() {
        return Err(PreviewError::InvalidShape);
    }
    Ok(collider.shape().compute_aabb(&pose.to_parry()))
}
