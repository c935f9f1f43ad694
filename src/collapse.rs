//! Telling when a structure loses its hold: [`Collapse`], one message for all of it, with the first body that gave way, and how.
//!
//! Put [`Watch`] on bodies, and add [`CollapsePlugin`]. A watched body that has been still for a moment stands where it is then, together with what
//! it touches: a structure. When one that nobody holds or pushes has left its place, the structure has collapsed: the message names the first of it that
//! did, be it held or pushed, and the rest follows without a word, until it stands again; [`CollapseEnded`] then says what has come down.
//! Removing a brick from the top does not count as a collapse.
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
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::message::{Message, MessageWriter};
use bevy_ecs::prelude::*;
use bevy_platform::collections::{HashMap, HashSet};
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Sends [`Collapse`]. It is in none of the plugins of [`DrystonePlugins`](crate::DrystonePlugins); add it after them.
pub struct CollapsePlugin;

impl Plugin for CollapsePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CollapseSettings>()
            .init_resource::<Structures>()
            .add_message::<Collapse>()
            .add_message::<CollapseEnded>()
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
    /// How many watched bodies the structure has, `first` and `rest` together.
    pub bodies: usize,
    /// Their mass, kg.
    pub mass: f32,
}

/// What has come down in a collapse: sent once all that is left of the structure stands again, or after [`CollapseSettings::longest`].
#[derive(Message, Clone, Debug, PartialEq)]
pub struct CollapseEnded {
    /// The first of it that gave way, as in [`Collapse`].
    pub first: Entity,
    /// How that did.
    pub how: GaveWay,
    /// Those of the structure that have left their places, the eldest first. Bodies that have been despawned since are not among them.
    pub moved: Vec<Entity>,
    /// Their mass, kg.
    pub mass: f32,
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
    /// A collapse has ended after so long, s, whatever still moves then; 30 by default.
    pub longest: f32,
}

impl Default for CollapseSettings {
    fn default() -> Self {
        Self {
            moved: 0.05,
            still_for: 0.25,
            memory: 2.0,
            longest: 30.0,
        }
    }
}

/// What is known of structures.
#[derive(Resource, Clone, Default)]
#[component(map_entities)]
pub struct Structures {
    last: u64,
    /// s
    now: f64,
    /// Who was pulled out of each, and when.
    pulled: HashMap<u64, Pulled>,
    /// Those that have collapsed, and do not all stand yet.
    falling: Vec<Falling>,
}

impl MapEntities for Structures {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for pulled in self.pulled.values_mut() {
            pulled.body.map_entities(mapper);
        }
        for falling in &mut self.falling {
            falling.first.map_entities(mapper);
            for (body, _) in &mut falling.bodies {
                body.map_entities(mapper);
            }
        }
    }
}

/// A body that was held as it left its structure.
#[derive(Clone)]
struct Pulled {
    body: Entity,
    how: GaveWay,
    stood: Pose,
    /// s
    when: f64,
}

/// A structure that has collapsed.
#[derive(Clone)]
struct Falling {
    first: Entity,
    how: GaveWay,
    /// When it did, s.
    since: f64,
    /// Its bodies, and where they stood.
    bodies: Vec<(Entity, Pose)>,
}

type Watched<'w, 's> = Query<
    'w,
    's,
    (
        (Entity, &'static BodyIndex),
        (&'static Pose, &'static Velocity),
        (&'static Watch, &'static mut Stands),
        (
            Option<&'static Grab>,
            Option<&'static ExternalForce>,
            Has<Resting>,
        ),
    ),
    (
        Without<Quarantined>,
        // Of a body at rest only what is asked of it can change. What comes to rest stands.
        Or<(Without<Resting>, Added<Resting>, Changed<Watch>)>,
    ),
>;

type AllWatched<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyIndex,
        &'static Pose,
        &'static mut Stands,
        Has<Resting>,
    ),
    With<RigidBody>,
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
    mut structures: ResMut<Structures>,
    mut watched: ParamSet<(Watched, AllWatched)>,
    mut begun: MessageWriter<Collapse>,
    mut ended: MessageWriter<CollapseEnded>,
) {
    let put = |index: &BodyIndex| {
        table
            .get(index.0)
            .is_some_and(|body| body.put_from.is_some())
    };
    for ((_, index), _, (_, mut stands), _) in &mut watched.p0() {
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
    // By structure: who has gone farthest beyond what counts, of those that do so in this step, and where all of those stood.
    let mut gone: HashMap<u64, (f32, Age, Entity, GaveWay)> = HashMap::default();
    let mut left: HashMap<u64, Vec<(Entity, Pose)>> = HashMap::default();
    let mut settled: Vec<(usize, Entity, u32, Pose)> = Vec::new();
    let mut known: HashMap<usize, u64> = HashMap::default();
    for ((entity, index), (pose, velocity), (watch, mut stands), state) in &mut watched.p0() {
        let (grab, force, rests) = state;
        let Some(body) = table.get(index.0).filter(|body| body.entity == entity) else {
            continue;
        };
        let island = islands.number(&table, index.0);
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
            if (rests || stands.still_for >= settings.still_for)
                && let Some(island) = island
            {
                settled.push((island, entity, index.0, *pose));
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
        if !has_left(place, *pose, body.radius, &settings) && !crushed {
            continue;
        }
        stands.crushed |= crushed;
        stands.leave();
        left.entry(structure).or_default().push((entity, place));
        let how = match () {
            () if crushed => GaveWay::Crushed,
            () if held => GaveWay::Pulled,
            () if turned > went.length() => GaveWay::Tipped,
            () if went.dot(down) > 0.7 * went.length() => GaveWay::Fell,
            () => GaveWay::Slid,
        };
        if held && !crushed {
            let pulled = Pulled {
                body: entity,
                how,
                stood: place,
                when: structures.now,
            };
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
    structures.end(&settings, &table, &watched.p1(), &mut ended);
    let since = structures.now - f64::from(settings.memory);
    structures.pulled.retain(|_, pulled| pulled.when > since);
    let mut told: Vec<_> = gone.into_iter().collect();
    told.sort_unstable_by_key(|(structure, _)| *structure);
    let fallen: HashSet<u64> = told.iter().map(|(structure, _)| *structure).collect();
    if !told.is_empty() {
        let mut rest: HashMap<u64, Vec<(Entity, Pose)>> = HashMap::default();
        for (entity, .., mut stands, _) in &mut watched.p1() {
            if let Some((place, structure)) = stands.at.filter(|(_, of)| fallen.contains(of)) {
                rest.entry(structure).or_default().push((entity, place));
                stands.leave();
            }
        }
        for (structure, (.., first, how)) in told {
            let mut bodies = left.remove(&structure).unwrap_or_default();
            let (mut first, mut how) = (first, how);
            if let Some(pulled) = structures.pulled.remove(&structure) {
                (first, how) = (pulled.body, pulled.how);
                if !bodies.iter().any(|(body, _)| *body == first) {
                    bodies.push((first, pulled.stood));
                }
            }
            let rest = rest.remove(&structure).unwrap_or_default();
            bodies.extend(&rest);
            begun.write(Collapse {
                first,
                how,
                rest: rest.into_iter().map(|(body, _)| body).collect(),
                bodies: bodies.len(),
                mass: mass(&table, &watched.p1(), bodies.iter().map(|(body, _)| *body)),
            });
            // Those at rest stand on, as another structure: nothing will move them before something else happens.
            structures.last += 1;
            let anew = structures.last;
            for &(body, place) in &bodies {
                if let Ok((.., mut stands, true)) = watched.p1().get_mut(body) {
                    stands.at = Some((place, anew));
                }
            }
            structures.falling.push(Falling {
                first,
                how,
                since: structures.now,
                bodies,
            });
        }
    }
    settled.sort_unstable_by_key(|(island, ..)| *island);
    for (island, entity, slot, pose) in settled {
        let structure = known.get(&island).copied().unwrap_or_else(|| {
            let all = watched.p1();
            let others = islands.members(&table, slot).into_iter();
            let stands = others.filter_map(|slot| all.get(table.get(slot)?.entity).ok()?.3.at);
            stands
                .map(|(_, structure)| structure)
                .min()
                .unwrap_or_else(|| {
                    structures.last += 1;
                    structures.last
                })
        });
        known.insert(island, structure);
        if fallen.contains(&structure) {
            continue;
        }
        if let Ok((.., mut stands, _)) = watched.p1().get_mut(entity) {
            stands.at = Some((pose, structure));
        }
    }
}

/// Whether a body of this radius, m, has gone from its place.
fn has_left(place: Pose, pose: Pose, radius: f32, settings: &CollapseSettings) -> bool {
    let turned = pose.rotation.angle_between(place.rotation) * radius;
    (pose.position - place.position).length() + turned > settings.moved * radius
}

/// The mass of those that are still there, kg.
fn mass(table: &BodyTable, all: &AllWatched, bodies: impl Iterator<Item = Entity>) -> f32 {
    let states = bodies.filter_map(|body| table.get(all.get(body).ok()?.1.0));
    states.map(|body| body.mass.mass()).sum()
}

impl Structures {
    /// Tells of collapses that are over.
    fn end(
        &mut self,
        settings: &CollapseSettings,
        table: &BodyTable,
        all: &AllWatched,
        ended: &mut MessageWriter<CollapseEnded>,
    ) {
        let now = self.now;
        self.falling.retain(|falling| {
            let mut left = falling
                .bodies
                .iter()
                .filter_map(|(body, _)| all.get(*body).ok());
            let stand = left.all(|(.., stands, _)| stands.at.is_some());
            if !stand && now - falling.since < f64::from(settings.longest) {
                return true;
            }
            let moved = falling.bodies.iter().filter_map(|&(entity, place)| {
                let (_, index, pose, ..) = all.get(entity).ok()?;
                let body = table.get(index.0).filter(|body| body.entity == entity)?;
                has_left(place, *pose, body.radius, settings).then_some((body.age, entity))
            });
            let mut moved: Vec<_> = moved.collect();
            moved.sort_unstable();
            let moved: Vec<Entity> = moved.into_iter().map(|(_, body)| body).collect();
            ended.write(CollapseEnded {
                first: falling.first,
                how: falling.how,
                mass: mass(table, all, moved.iter().copied()),
                moved,
            });
            false
        });
    }
}
