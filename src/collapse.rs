//! Collapse detection: a [`Collapse`] message when a structure fails, with the body that failed first and how it failed.
//!
//! Put [`Watch`] on bodies and add [`CollapsePlugin`]. When a watched body has been still for a moment, its pose and the structure it
//! touches are remembered. When a body of the structure leaves its place, and is not held or pushed, the structure has collapsed. The
//! message names the first body that left its place, including one that was held or pushed. The rest of the structure then falls without
//! further messages until it stands again, and [`CollapseEnded`] reports which bodies have moved. Removing a brick does not count as a
//! collapse.
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
    BodyIndex, BodyTable, ExternalForce, Grab, Inactive, Pose, Quarantined, RigidBody,
    RigidBodyDisabled, SpawnOrder, Velocity,
};
use crate::components::init;
use crate::contact::{Contacts, FaceForce};
use crate::graph::Islands;
use crate::mortar::{BrokenMortar, MortarBroke};
use crate::schedule::{PhysicsSchedule, PhysicsSystems, StepMessages};
use crate::settings::{Gravity, SleepSettings, StepTime};
use crate::solver::sort;
use bevy_app::{App, Plugin};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::message::{Message, MessageWriter};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_platform::collections::{HashMap, HashSet};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Sends [`Collapse`] and [`CollapseEnded`]. It is not part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct CollapsePlugin;

impl Plugin for CollapsePlugin {
    fn build(&self, app: &mut App) {
        let world = app.world_mut();
        init::<CollapseSettings>(world);
        init::<Structures>(world);
        app.add_message::<Collapse>()
            .add_message::<CollapseEnded>()
            .add_systems(
                PhysicsSchedule,
                collapses.after(PhysicsSystems::ContactEvents),
            );
        let world = app.world_mut();
        init::<StepMessages>(world);
        let mut messages = world.resource_mut::<StepMessages>();
        messages.add::<Collapse>();
        messages.add::<CollapseEnded>();
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// A message: a structure of watched bodies has collapsed.
#[derive(Message, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
pub struct Collapse {
    /// The body that failed first.
    pub first: Entity,
    /// How it failed.
    pub how: FailureMode,
    /// The mortar joint of the structure that broke first, if one did within [`CollapseSettings::memory`] before.
    pub mortar: Option<MortarBroke>,
    /// The bodies of the structure that had not left their places yet, in no particular order.
    pub rest: Vec<Entity>,
    /// Number of watched bodies in the structure, [`first`](Self::first) and [`rest`](Self::rest) included.
    pub bodies: usize,
    /// Mass of these bodies, kg.
    pub mass: f32,
}

/// A message: a collapse has ended. It is sent when everything left of the structure stands again, or after
/// [`CollapseSettings::max_time`].
#[derive(Message, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
pub struct CollapseEnded {
    /// The body that failed first, as in [`Collapse`].
    pub first: Entity,
    /// How it failed.
    pub how: FailureMode,
    /// The bodies of the structure that have left their places, in order of spawning, without those that have been despawned since.
    pub moved: Vec<Entity>,
    /// Mass of these bodies, kg.
    pub mass: f32,
}

/// How a body failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FailureMode {
    /// A [`Grab`] held it, or an external force acted on it.
    Pulled,
    /// The normal force on one of its faces exceeded its [`Watch::strength`].
    Crushed,
    /// It moved down: its support failed or was removed.
    Fell,
    /// It moved sideways or upwards.
    Slid,
    /// It rotated more than it moved.
    Tipped,
}

/// Component of bodies whose structure is watched for collapse.
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
#[require(Stands)]
pub struct Watch {
    /// Normal force on one of its faces that crushes the body, N. Default: infinite.
    pub strength: f32,
}

impl Default for Watch {
    fn default() -> Self {
        Self {
            strength: f32::INFINITY,
        }
    }
}

/// The place where a watched body stands, if it stands.
#[doc(hidden)]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// Thresholds of collapse detection.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct CollapseSettings {
    /// Movement at which a body has left its place, as a share of its bounding radius. Default: 0.05.
    pub movement_threshold: f32,
    /// Time for which a body must be still to stand, s. Default: 0.25. [`SleepSettings`] defines the speeds that count as still.
    pub still_for: f32,
    /// Time after which a body that was pulled out, or a bond that broke, is no longer taken as the cause of a collapse, s. Default: 2.
    pub memory: f32,
    /// Time after which a collapse ends even if bodies still move, s. Default: 30.
    pub max_time: f32,
}

impl Default for CollapseSettings {
    fn default() -> Self {
        Self {
            movement_threshold: 0.05,
            still_for: 0.25,
            memory: 2.0,
            max_time: 30.0,
        }
    }
}

/// The state of all structures.
#[doc(hidden)]
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
pub struct Structures {
    last: u64,
    /// s
    now: f64,
    /// The bodies that were pulled out of each, and when.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    pulled: HashMap<u64, Pulled>,
    /// Bonds that broke, and when, s.
    broken: Vec<(f64, MortarBroke)>,
    /// Structures that have collapsed, and whose bodies do not all stand yet.
    falling: Vec<Falling>,
}

impl MapEntities for Structures {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for pulled in self.pulled.values_mut() {
            pulled.body.map_entities(mapper);
        }
        for (_, broke) in &mut self.broken {
            broke.map_entities(mapper);
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
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Pulled {
    body: Entity,
    how: FailureMode,
    stood: Pose,
    /// s
    when: f64,
}

/// A structure that has collapsed.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Falling {
    first: Entity,
    how: FailureMode,
    /// When it did, s.
    since: f64,
    /// Its bodies, and where they stood.
    bodies: Vec<(Entity, Pose)>,
}

/// The components of a watched body.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct WatchedBody {
    entity: Entity,
    index: &'static BodyIndex,
    pose: &'static Pose,
    velocity: &'static Velocity,
    watch: Option<Ref<'static, Watch>>,
    stands: &'static mut Stands,
    grab: Option<&'static Grab>,
    force: Option<&'static ExternalForce>,
    inactive: Option<Ref<'static, Inactive>>,
    is_quarantined: Has<Quarantined>,
    is_disabled: Has<RigidBodyDisabled>,
}

/// The bodies that are watched, or were.
type Watched<'w, 's> = Query<'w, 's, WatchedBody, With<RigidBody>>;

impl WatchedBodyItem<'_, '_> {
    /// The threshold of a body that is looked at in this step. Inactive bodies only matter when they become inactive, because they then
    /// stand, and when their [`Watch`] changes.
    fn watch(&self) -> Option<Watch> {
        let watch = self.watch.as_ref()?;
        let inactive = self.inactive.as_ref();
        let is_looked_at = !self.is_quarantined
            && !self.is_disabled
            && (inactive.is_none_or(DetectChanges::is_added) || watch.is_changed());
        is_looked_at.then_some(**watch)
    }
}

/// Detects collapses, at the end of every step.
pub(crate) fn collapses(
    (settings, sleep, gravity, time): (
        Res<CollapseSettings>,
        Res<SleepSettings>,
        Res<Gravity>,
        Res<StepTime>,
    ),
    (table, islands, contacts): (Res<BodyTable>, Res<Islands>, Contacts),
    (mut structures, broken): (ResMut<Structures>, Res<BrokenMortar>),
    mut watched: Watched,
    mut begun: MessageWriter<Collapse>,
    mut ended: MessageWriter<CollapseEnded>,
) {
    if time.substep == 0 {
        forget_placed(&table, &mut watched);
    }
    if !time.is_last() {
        return;
    }
    let structures = &mut *structures;
    let step = f64::from(time.whole());
    structures.begin_step(step, &broken.of_step);
    let scene = Scene {
        settings: &settings,
        sleep: &sleep,
        table: &table,
        islands: &islands,
        contacts: &contacts,
        down: gravity.0.normalize_or_zero(),
        step: time.whole(),
    };
    let mut found = Found::default();
    for of in &mut watched {
        if let Some(watch) = of.watch() {
            found.look(&scene, structures, watch, of);
        }
    }
    structures.end(&settings, &table, &watched, &mut ended);
    structures.forget(settings.memory);
    let fallen = structures.fall(&table, &mut found, &mut watched, &mut begun);
    structures.settle(&scene, found, &fallen, &mut watched);
}

/// Bodies that the user has placed stand no more. This happens before the first substep.
fn forget_placed(table: &BodyTable, watched: &mut Watched) {
    let put = |index: &BodyIndex| {
        table
            .get(index.0)
            .is_some_and(|body| body.put_from.is_some())
    };
    for mut of in watched {
        if of.watch().is_some() && put(of.index) {
            of.stands.leave();
        }
    }
}

/// What watched bodies are compared with.
struct Scene<'a, 'w, 's> {
    settings: &'a CollapseSettings,
    sleep: &'a SleepSettings,
    table: &'a BodyTable,
    islands: &'a Islands,
    contacts: &'a Contacts<'w, 's>,
    /// The direction of gravity.
    down: Vec3,
    /// Length of the step, s.
    step: f32,
}

/// What a step finds of watched bodies.
#[derive(Default)]
struct Found {
    /// By structure: who has gone farthest beyond what counts, of those that do so in this step.
    gone: HashMap<u64, (f32, SpawnOrder, Entity, FailureMode)>,
    /// By structure: where all of those stood.
    left: HashMap<u64, Vec<(Entity, Pose)>>,
    /// Bodies that stand from now on: their island, entity, slot and pose.
    settled: Vec<(u32, Entity, u32, Pose)>,
    /// By island: the structure.
    known: HashMap<u32, u64>,
}

impl Found {
    /// Looks at a body.
    fn look(
        &mut self,
        scene: &Scene,
        structures: &mut Structures,
        watch: Watch,
        of: WatchedBodyItem,
    ) {
        let WatchedBodyItem {
            entity,
            index,
            pose,
            velocity,
            mut stands,
            grab,
            force,
            inactive,
            ..
        } = of;
        let body = scene.table.get(index.0);
        let Some(body) = body.filter(|body| body.entity == entity) else {
            return;
        };
        let island = scene.islands.structure_id(index.0);
        let Some((place, structure)) = stands.at else {
            // A body that is held by a `Grab` does not count as standing, even if it is still.
            let still = grab.is_none()
                && velocity.linear.length() < scene.sleep.linear_speed
                && velocity.angular.length() < scene.sleep.angular_speed;
            stands.still_for = if still {
                stands.still_for + scene.step
            } else {
                0.0
            };
            if (inactive.is_some() || stands.still_for >= scene.settings.still_for)
                && let Some(island) = island
            {
                self.settled.push((island, entity, index.0, *pose));
            }
            return;
        };
        if let Some(island) = island {
            let id = self.known.entry(island).or_insert(structure);
            *id = structure.min(*id);
        }
        let crushed = !stands.crushed && scene.crushes(entity, watch);
        if !has_left(place, *pose, body.radius, scene.settings) && !crushed {
            return;
        }
        stands.crushed |= crushed;
        stands.leave();
        self.left
            .entry(structure)
            .or_default()
            .push((entity, place));
        let held = grab.is_some() || force.is_some_and(|force| *force != ExternalForce::default());
        let went = pose.position - place.position;
        let turned = pose.rotation.angle_between(place.rotation) * body.radius;
        let how = match () {
            () if crushed => FailureMode::Crushed,
            () if held => FailureMode::Pulled,
            () if turned > went.length() => FailureMode::Tipped,
            () if went.dot(scene.down) > 0.7 * went.length() => FailureMode::Fell,
            () => FailureMode::Slid,
        };
        if held && !crushed {
            let pulled = Pulled {
                body: entity,
                how,
                stood: place,
                when: structures.now,
            };
            structures.pulled.entry(structure).or_insert(pulled);
            return;
        }
        let far = (went.length() + turned) / body.radius;
        let before = self
            .gone
            .entry(structure)
            .or_insert((far, body.spawn_order, entity, how));
        if far > before.0 || far == before.0 && body.spawn_order < before.1 {
            *before = (far, body.spawn_order, entity, how);
        }
    }
}

impl Scene<'_, '_, '_> {
    /// Whether some face presses on a body with more than its strength.
    fn crushes(&self, body: Entity, watch: Watch) -> bool {
        let above = |faces: Vec<FaceForce>| {
            let mut faces = faces.iter();
            faces.any(|face| face.normal_force > watch.strength)
        };
        watch.strength.is_finite() && self.contacts.on(body).is_ok_and(above)
    }
}

impl Structures {
    /// A step of this length, s, has ended, in which this mortar broke.
    fn begin_step(&mut self, step: f64, broken: &[MortarBroke]) {
        self.now += step;
        let now = self.now;
        self.broken.extend(broken.iter().map(|broke| (now, *broke)));
    }

    /// Forgets what happened longer ago than this, s.
    fn forget(&mut self, memory: f32) {
        let since = self.now - f64::from(memory);
        self.pulled.retain(|_, pulled| pulled.when > since);
        self.broken.retain(|&(when, _)| when > since);
    }

    /// Reports the structures of which a body has gone, and returns them. None of their bodies stands any more.
    fn fall(
        &mut self,
        table: &BodyTable,
        found: &mut Found,
        watched: &mut Watched,
        begun: &mut MessageWriter<Collapse>,
    ) -> HashSet<u64> {
        let mut told: Vec<_> = found.gone.drain().collect();
        sort::by_key(&mut told, |(structure, _)| *structure);
        let fallen: HashSet<u64> = told.iter().map(|(structure, _)| *structure).collect();
        if told.is_empty() {
            return fallen;
        }
        let mut rest: HashMap<u64, Vec<(Entity, Pose)>> = HashMap::default();
        for of in &mut *watched {
            let (entity, mut stands) = (of.entity, of.stands);
            if let Some((place, structure)) = stands.at.filter(|(_, of)| fallen.contains(of)) {
                rest.entry(structure).or_default().push((entity, place));
                stands.leave();
            }
        }
        for (structure, (.., first, how)) in told {
            let mut bodies = found.left.remove(&structure).unwrap_or_default();
            let (mut first, mut how) = (first, how);
            if let Some(pulled) = self.pulled.remove(&structure) {
                (first, how) = (pulled.body, pulled.how);
                if !bodies.iter().any(|(body, _)| *body == first) {
                    bodies.push((first, pulled.stood));
                }
            }
            let rest = rest.remove(&structure).unwrap_or_default();
            bodies.extend(&rest);
            let is_of = |broke: &MortarBroke| {
                let mut bodies = bodies.iter();
                bodies.any(|(body, _)| [broke.body, broke.other].contains(body))
            };
            let mut broken = self.broken.iter();
            begun.write(Collapse {
                first,
                how,
                mortar: broken
                    .find(|(_, broke)| is_of(broke))
                    .map(|&(_, broke)| broke),
                rest: rest.into_iter().map(|(body, _)| body).collect(),
                bodies: bodies.len(),
                mass: mass(table, watched, bodies.iter().map(|(body, _)| *body)),
            });
            // Inactive bodies still stand, as another structure, because they do not move until something else happens.
            self.last += 1;
            let anew = self.last;
            for &(body, place) in &bodies {
                if let Ok(mut of) = watched.get_mut(body)
                    && of.inactive.is_some()
                {
                    of.stands.at = Some((place, anew));
                }
            }
            self.falling.push(Falling {
                first,
                how,
                since: self.now,
                bodies,
            });
        }
        fallen
    }

    /// Adds the bodies that stand from now on to their structures, unless these fall.
    fn settle(
        &mut self,
        scene: &Scene,
        found: Found,
        fallen: &HashSet<u64>,
        watched: &mut Watched,
    ) {
        let Found {
            mut settled,
            mut known,
            ..
        } = found;
        sort::by_key(&mut settled, |(island, ..)| *island);
        for (island, entity, slot, pose) in settled {
            let structure = known.get(&island).copied().unwrap_or_else(|| {
                let others = scene.islands.structure(slot).iter();
                let stands = others.filter_map(|&slot| {
                    let body = scene.table.get(slot)?.entity;
                    watched.get(body).ok()?.stands.at
                });
                stands
                    .map(|(_, structure)| structure)
                    .min()
                    .unwrap_or_else(|| {
                        self.last += 1;
                        self.last
                    })
            });
            known.insert(island, structure);
            if fallen.contains(&structure) {
                continue;
            }
            if let Ok(mut of) = watched.get_mut(entity) {
                of.stands.at = Some((pose, structure));
            }
        }
    }
}

/// Whether a body of this radius, m, has gone from its place.
fn has_left(place: Pose, pose: Pose, radius: f32, settings: &CollapseSettings) -> bool {
    let turned = pose.rotation.angle_between(place.rotation) * radius;
    (pose.position - place.position).length() + turned > settings.movement_threshold * radius
}

/// The mass of those that are still there, kg.
fn mass(table: &BodyTable, all: &Watched, bodies: impl Iterator<Item = Entity>) -> f32 {
    let states = bodies.filter_map(|body| table.get(all.get(body).ok()?.index.0));
    states.map(|body| body.mass.mass()).sum()
}

impl Structures {
    /// Tells of collapses that are over.
    fn end(
        &mut self,
        settings: &CollapseSettings,
        table: &BodyTable,
        all: &Watched,
        ended: &mut MessageWriter<CollapseEnded>,
    ) {
        let now = self.now;
        self.falling.retain(|falling| {
            let mut left = falling
                .bodies
                .iter()
                .filter_map(|(body, _)| all.get(*body).ok());
            let stand = left.all(|of| of.stands.at.is_some());
            if !stand && now - falling.since < f64::from(settings.max_time) {
                return true;
            }
            let moved = falling.bodies.iter().filter_map(|&(entity, place)| {
                let of = all.get(entity).ok()?;
                let (index, pose) = (of.index, of.pose);
                let body = table.get(index.0).filter(|body| body.entity == entity)?;
                has_left(place, *pose, body.radius, settings).then_some((body.spawn_order, entity))
            });
            let mut moved: Vec<_> = moved.collect();
            sort::by_key(&mut moved, |&(order, body)| (order, body.to_bits()));
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
