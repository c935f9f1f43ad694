//! Telling when a structure loses its hold: [`Collapse`], one message for all of it, with the first body that gave way, and how.
//!
//! Put [`Watch`] on bodies, and add [`CollapsePlugin`]. A watched body that has been still for a moment stands where it is then, together with what
//! it touches: a structure. When one that nobody holds or pushes has left its place, the structure has collapsed: the message names the first of it that
//! did, be it held or pushed, and the rest follows without a word, until it stands again. That somebody takes a brick off the top is none.
//!
//! ```
//! use bevy_ecs::message::Messages;
//! use drystone::masonry::{Bond, Wall};
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! app.add_plugins((DrystonePlugins::default(), CollapsePlugin));
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let wall = Wall::new(Bond::Running).blocks().unwrap().into_iter();
//! let bricks: Vec<_> = wall.map(|brick| world.spawn((brick.bundle(), Watch::default())).id()).collect();
//! # for _ in 0..60 { drystone::step(world, 1.0 / 60.0).unwrap(); }
//! // The corner is taken away.
//! world.despawn(bricks[0]);
//! let mut told = Vec::new();
//! for _ in 0..120 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//!     told.extend(world.resource_mut::<Messages<Collapse>>().drain());
//! }
//! assert_eq!(told.len(), 1);
//! assert_eq!(told[0].first, bricks[5]); // the half brick that lay on it
//! ```

use crate::body::{
    Age, BodyIndex, BodyTable, ExternalForce, Pose, Quarantined, Resting, RigidBody, Velocity,
};
use crate::contact::Contacts;
use crate::grab::Grab;
use crate::islands::Islands;
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::settings::{Gravity, SleepSettings, StepTime};
use bevy_app::{App, Plugin};
use bevy_ecs::message::{Message, MessageWriter};
use bevy_ecs::prelude::*;
use bevy_platform::collections::{HashMap, HashSet};
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Sends [`Collapse`]. It is in none of the plugins of [`DrystonePlugins`](crate::DrystonePlugins); add it after them.
pub struct CollapsePlugin;

impl Plugin for CollapsePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CollapseSettings>()
            .add_message::<Collapse>()
            .add_systems(
                PhysicsSchedule,
                collapses.after(PhysicsSystems::ContactEvents),
            );
    }
}

/// A structure has lost its hold.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct Collapse {
    /// The first of it that gave way.
    pub first: Entity,
    /// How that did.
    pub how: GaveWay,
    /// Those of it that still stand where they stood, or rather did until now; in no order of meaning.
    pub rest: Vec<Entity>,
}

/// How a body gave way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
pub enum GaveWay {
    /// A hand or a force of the user's was on it.
    Pulled,
    /// More pressed on a face of it than its [`Watch::strength`].
    Crushed,
    /// What bore it gave way, or was taken: it went down.
    Fell,
    /// It went aside, or was thrown up.
    Slid,
    /// It turned more than it went.
    Tipped,
}

/// A body whose structure is watched.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[require(Stands)]
pub struct Watch {
    /// More than this on one of its faces crushes it, N; infinite by default.
    pub strength: f32,
}

impl Default for Watch {
    fn default() -> Self {
        Self {
            strength: f32::INFINITY,
        }
    }
}

/// Where a watched body stands, if it does. Internal.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(clone_behavior = Ignore)]
pub struct Stands {
    at: Option<(Pose, u64)>,
    still_for: f32,
    /// It has been told, and will not be again.
    crushed: bool,
}

impl Stands {
    fn leave(&mut self) {
        (self.at, self.still_for) = (None, 0.0);
    }
}

/// What counts.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct CollapseSettings {
    /// A body has left its place when a point of it has come farther than this share of its radius; 0.05 by default.
    pub moved: f32,
    /// It stands when it has been still for so long, s; 0.25 by default. (How slow that is say [`SleepSettings`].)
    pub still_for: f32,
    /// A body that was pulled away so long ago, s, has nothing to do with what falls now; 2 by default.
    pub memory: f32,
}

impl Default for CollapseSettings {
    fn default() -> Self {
        Self {
            moved: 0.05,
            still_for: 0.25,
            memory: 2.0,
        }
    }
}

/// What is known of structures.
#[derive(Default)]
pub struct Structures {
    last: u64,
    /// s
    now: f64,
    /// Who was pulled out of each, and when.
    pulled: HashMap<u64, (Entity, GaveWay, f64)>,
}

type Watched<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyIndex,
        &'static Pose,
        &'static Velocity,
        &'static Watch,
        &'static mut Stands,
        Option<&'static Grab>,
        Option<&'static ExternalForce>,
    ),
    (Without<Quarantined>, Without<Resting>),
>;

/// See the module's text. After every step.
pub fn collapses(
    (settings, sleep, gravity, time): (
        Res<CollapseSettings>,
        Res<SleepSettings>,
        Res<Gravity>,
        Res<StepTime>,
    ),
    (table, islands, contacts): (Res<BodyTable>, Res<Islands>, Contacts),
    mut structures: Local<Structures>,
    mut watched: ParamSet<(Watched, Query<(Entity, &mut Stands), With<RigidBody>>)>,
    mut messages: MessageWriter<Collapse>,
) {
    let put = |index: &BodyIndex| {
        table
            .get(index.0)
            .is_some_and(|body| body.put_from.is_some())
    };
    for (_, index, .., mut stands, _, _) in &mut watched.p0() {
        // Somebody has put it where it is: before the first substep.
        if time.substep == 0 && put(index) {
            stands.leave();
        }
    }
    if !time.is_last() {
        return;
    }
    let structures = &mut *structures;
    structures.now += f64::from(time.whole());
    let down = gravity.0.normalize_or_zero();
    // By structure: who has gone farthest beyond what counts, of those that do so in this step.
    let mut gone: HashMap<u64, (f32, Age, Entity, GaveWay)> = HashMap::default();
    let mut settled: Vec<(usize, Entity, Pose)> = Vec::new();
    let mut known: HashMap<usize, u64> = HashMap::default();
    for (entity, index, pose, velocity, watch, mut stands, grab, force) in &mut watched.p0() {
        let Some(body) = table.get(index.0).filter(|body| body.entity == entity) else {
            continue;
        };
        let island = islands.of(index.0);
        let Some((place, structure)) = stands.at else {
            // What is held still stands on nothing.
            let still = grab.is_none()
                && velocity.linear.length() < sleep.linear_speed
                && velocity.angular.length() < sleep.angular_speed;
            stands.still_for = if still {
                stands.still_for + time.whole()
            } else {
                0.0
            };
            if stands.still_for >= settings.still_for
                && let Some(island) = island
            {
                settled.push((island, entity, *pose));
            }
            continue;
        };
        if let Some(island) = island {
            let id = known.entry(island).or_insert(structure);
            *id = structure.min(*id);
        }
        let went = pose.position - place.position;
        let turned = pose.rotation.angle_between(place.rotation) * body.radius;
        let held = grab.is_some() || force.is_some_and(|force| *force != ExternalForce::default());
        let crushed = !stands.crushed
            && watch.strength.is_finite()
            && contacts
                .on(entity)
                .is_ok_and(|faces| faces.iter().any(|face| face.pressure > watch.strength));
        let moved = went.length() + turned > settings.moved * body.radius;
        if !moved && !crushed {
            continue;
        }
        stands.crushed |= crushed;
        stands.leave();
        let how = match () {
            () if crushed => GaveWay::Crushed,
            () if held => GaveWay::Pulled,
            () if turned > went.length() => GaveWay::Tipped,
            () if went.dot(down) > 0.7 * went.length() => GaveWay::Fell,
            () => GaveWay::Slid,
        };
        if held && !crushed {
            let pulled = (entity, how, structures.now);
            structures.pulled.entry(structure).or_insert(pulled);
        } else {
            let far = (went.length() + turned) / body.radius;
            let before = gone
                .entry(structure)
                .or_insert((far, body.age, entity, how));
            if far > before.0 || far == before.0 && body.age < before.1 {
                *before = (far, body.age, entity, how);
            }
        }
    }
    let since = structures.now - f64::from(settings.memory);
    structures.pulled.retain(|_, (.., when)| *when > since);
    let mut told: Vec<_> = gone.into_iter().collect();
    told.sort_unstable_by_key(|(structure, _)| *structure);
    let fallen: HashSet<u64> = told.iter().map(|(structure, _)| *structure).collect();
    if !told.is_empty() {
        let mut rest: HashMap<u64, Vec<Entity>> = HashMap::default();
        for (entity, mut stands) in &mut watched.p1() {
            if let Some((_, structure)) = stands.at.filter(|(_, of)| fallen.contains(of)) {
                rest.entry(structure).or_default().push(entity);
                stands.leave();
            }
        }
        for (structure, (.., first, how)) in told {
            let pulled = structures.pulled.remove(&structure);
            let (first, how) = pulled.map_or((first, how), |(first, how, _)| (first, how));
            let rest = rest.remove(&structure).unwrap_or_default();
            messages.write(Collapse { first, how, rest });
        }
    }
    settled.sort_unstable_by_key(|(island, ..)| *island);
    for (island, entity, pose) in settled {
        let known = known.entry(island);
        let structure = *known.or_insert_with(|| {
            structures.last += 1;
            structures.last
        });
        if fallen.contains(&structure) {
            continue;
        }
        if let Ok((_, mut stands)) = watched.p1().get_mut(entity) {
            stands.at = Some((pose, structure));
        }
    }
}
