//! Bodies that are spawned asleep by the thousand.
//!
//! Bodies that a user spawns asleep one by one are active in their first step: all stages process them and their pairs, and then both move
//! to the tables of what is inactive. Those of [`spawn_asleep`] are inactive from the beginning, and the next step, in *prepare*, does all
//! at once what its stages would do: boxes, pairs, contacts, structures and loads. The bodies are divided into *groups* whose boxes
//! overlap, such as the walls of a town. Contacts and loads of a group are found one after the other while they are in the cache, and
//! groups are shared among threads. The results have the same bits as those of bodies that are spawned asleep one by one.
//!
//! Bodies that need more than that are left to the stages, with all that is near them ([`groups`]): those that are joined, composite,
//! moving or disturbed, that have hooks, mortar or contact events, or that are near a dynamic body which was there before.

mod contacts;
mod groups;
mod loads;

use super::region::Contact;
use crate::body::{
    BodyIndex, BodyTable, Inactive, InactiveBodies, NewBodies, RigidBody, Simulated, Sleeping,
    add_asleep, collider::Collider, note_written, with_table,
};
use crate::broadphase::{Broadphase, rest_box};
use crate::collapse::Watch;
use crate::diagnosis::BodyProblem;
use crate::graph::{ConstraintGraph, Islands, report, with_room};
use crate::joint_types::{self, Mortar};
use crate::sensor::Sensors;
use crate::settings::{Columns, Gravity, PhysicsThreads, StabilizationSettings, StepTime};
use crate::warm_start::SolveContext;
use bevy_ecs::bundle::NoBundleEffect;
use bevy_ecs::entity::{EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use contacts::{Contacts, Found};
use groups::{Group, Groups};

/// Bodies that were spawned by [`spawn_asleep`] since the last step.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
#[doc(hidden)]
pub struct Arrivals(Vec<Entity>);

impl MapEntities for Arrivals {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.0.map_entities(mapper);
    }
}

/// Spawns many bodies asleep, with the loads that keep them still: a town of a million bricks in seconds. The bundles must not contain
/// [`Sleeping`].
///
/// The next step finds their contacts and loads, as it does for bodies that are spawned with [`Sleeping::asleep`] one by one, but in a
/// fraction of the time and memory. No [`ContactStarted`](crate::contact::ContactStarted) is sent for contacts among them. The time is that
/// of one step; spawn parts of a very large town in several steps to divide it. Bodies that are not at rest where they are put are not
/// moved: they fall when they are woken.
///
/// # Panics
/// If a bundle contains [`Sleeping`].
///
/// ```
/// use bevy_app::App;
/// use drystone::masonry::{Bond, Wall};
/// use drystone::prelude::*;
/// use drystone::streaming::spawn_asleep;
///
/// let mut app = App::new();
/// app.add_plugins(DrystonePlugins::default());
/// let world = app.world_mut();
/// world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// let wall = Wall::new(Bond::Running).blocks().unwrap();
/// let street = (0..20).flat_map(|i| {
///     let place = Pose { position: 3.0 * i as f32 * Vec3::Z, ..Pose::default() };
///     wall.iter().map(move |block| block.clone().moved(&place).bundle())
/// });
/// let bricks = spawn_asleep(world, street);
/// drystone::step(world, 1.0 / 60.0).unwrap();
/// let faces = contacts(world, |contacts| contacts.on(bricks[0])).unwrap();
/// assert!(faces.iter().any(|face| face.normal_force > 0.0));
/// assert!(world.get::<Sleeping>(bricks[0]).unwrap().asleep);
/// ```
pub fn spawn_asleep<B>(world: &mut World, bodies: impl IntoIterator<Item = B>) -> Vec<Entity>
where
    B: Bundle<Effect: NoBundleEffect>,
{
    let asleep = Sleeping {
        asleep: true,
        ..Sleeping::default()
    };
    let bodies = bodies.into_iter();
    if !world.contains_resource::<Arrivals>() {
        return world
            .spawn_batch(bodies.map(|body| (body, asleep)))
            .collect();
    }
    let bodies = bodies.map(|body| (body, asleep, Inactive::new()));
    let spawned: Vec<Entity> = world.spawn_batch(bodies).collect();
    world.resource_mut::<Arrivals>().0.extend(&spawned);
    spawned
}

/// Run condition: bodies were spawned by [`spawn_asleep`] since the last step.
pub fn any_arrivals(arrivals: Res<Arrivals>) -> bool {
    !arrivals.0.is_empty()
}

/// Number of pairs whose contacts are found at a time by each thread. They pass through several lists, which stay in the caches.
const PAIRS_PER_PORTION: usize = 1 << 13;

/// On several threads a portion has at least so many times [`PAIRS_PER_PORTION`] pairs. A group is not divided among threads, so with few
/// groups in a portion some threads would wait for others at its end.
const PORTIONS_PER_THREAD: usize = 8;

/// Takes up the bodies; a part of the stage *prepare*.
pub fn arrive(
    world: &mut World,
    new: &mut SystemState<NewBodies>,
    inactive: &mut SystemState<InactiveBodies>,
) {
    let mut list = std::mem::take(&mut world.resource_mut::<Arrivals>().0);
    let grounds = take_grounds(world);
    list.extend(&grounds);
    let (mut list, mut others) = divide(world, list);
    if !grounds.is_empty() && !others.is_empty() {
        // Bodies that are left to the stages must arrive together with their ground, and so must all that stands on it.
        others.append(&mut list);
    }
    let (slots, unfit) = with_table(world, |world, mut table| {
        let now = world.change_tick();
        let known = inactive.get(world).expect("bodies can always be read");
        note_written(&mut table, known, now);
        let found = new.get_mut(world).expect("bodies can always be read");
        let found = add_asleep(&mut table, &list, found);
        new.apply(world);
        found
    });
    others.extend(unfit);
    if let Some(mut sensors) = world.get_resource_mut::<Sensors>() {
        sensors.note_arrived(slots.iter().copied());
    }
    world.resource_scope(|world, mut broadphase: Mut<Broadphase>| {
        add_boxes(world, &mut broadphase, &slots);
        let groups = Groups::find(
            &broadphase,
            world.resource(),
            &slots,
            world.resource::<PhysicsThreads>(),
        );
        others.extend(leave(world, &mut broadphase, &groups.left_out));
        world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
            with_table(world, |world, mut table| {
                connect(world, &mut graph, &mut table, &groups);
            });
        });
    });
    // The stages process the others, as if they had been spawned one by one.
    for body in others {
        if let Ok(mut body) = world.get_entity_mut(body) {
            body.remove::<Inactive>();
        }
    }
}

/// Marks static bodies that were spawned since the last step, so that they arrive together with what stands on them: a ground that arrives
/// later would wake it. A half-space is left to the stages if there are dynamic bodies already, which it may touch.
fn take_grounds(world: &mut World) -> Vec<Entity> {
    let mut new = world.query_filtered::<(Entity, &RigidBody, &BodyIndex, Option<&Collider>), (Simulated, Without<Inactive>)>();
    let table = world.resource::<BodyTable>();
    let is_empty = !table.iter().any(|(_, body)| body.is_dynamic());
    let new = new.iter(world).filter(|(_, kind, index, collider)| {
        let is_bounded = collider.is_none_or(|collider| collider.shape().as_halfspace().is_none());
        **kind == RigidBody::Static && **index == BodyIndex::NONE && (is_bounded || is_empty)
    });
    let grounds: Vec<Entity> = new.map(|(entity, ..)| entity).collect();
    let marked = grounds.iter().map(|&ground| (ground, Inactive::new()));
    _ = world.try_insert_batch(marked.collect::<Vec<_>>());
    grounds
}

/// Divides bodies into those that need contacts and loads only, as far as their components tell, and the others.
fn divide(world: &World, list: Vec<Entity>) -> (Vec<Entity>, Vec<Entity>) {
    let joined = joint_types::added(world).into_iter();
    let joined: EntityHashSet = joined.flat_map(|(_, bodies)| bodies).flatten().collect();
    let special = world.try_query_filtered::<Entity, Or<(With<Mortar>, With<Watch>)>>();
    let special: EntityHashSet = special.map_or_else(EntityHashSet::default, |mut special| {
        special.iter(world).collect()
    });
    let list = list.into_iter();
    list.partition(|body| !joined.contains(body) && !special.contains(body))
}

fn add_boxes(world: &World, broadphase: &mut Broadphase, slots: &[u32]) {
    let table = world.resource::<BodyTable>();
    let (gravity, dt) = (
        world.resource::<Gravity>().0,
        world.resource::<StepTime>().dt,
    );
    let settings = world.resource::<StabilizationSettings>();
    let threads = world.resource::<PhysicsThreads>();
    let boxes = each(threads, slots.len(), slots, |&slot| {
        let fat = rest_box(table.get(slot)?, settings, gravity, dt);
        Some((slot, fat?))
    });
    let boxes: Vec<_> = boxes.into_iter().flatten().collect();
    broadphase.add_boxes(&boxes, table.slots());
    let is_unbounded = |slot: &u32| {
        let body = table.get(*slot);
        body.is_some_and(|body| body.collider.is_some() && !body.radius.is_finite())
    };
    let unbounded = slots.iter().copied().filter(is_unbounded);
    unbounded.for_each(|slot| broadphase.add_unbounded(slot));
}

/// Removes bodies again that are left to the stages.
fn leave(world: &mut World, broadphase: &mut Broadphase, slots: &[u32]) -> Vec<Entity> {
    broadphase.take_boxes(slots);
    let mut left = Vec::with_capacity(slots.len());
    for &slot in slots {
        let mut table = world.resource_mut::<BodyTable>();
        if let Some(body) = table.get(slot).map(|body| body.entity) {
            table.take_out(body, BodyIndex(slot));
            left.push(body);
            if let Some(mut index) = world.get_mut::<BodyIndex>(body) {
                *index.bypass_change_detection() = BodyIndex::NONE;
            }
        }
    }
    left
}

/// Finds the contacts and loads of all groups, and spawns their pairs. Pairs are spawned on one thread; the others find those of the next
/// portion at the same time.
fn connect(world: &mut World, graph: &mut ConstraintGraph, table: &mut BodyTable, groups: &Groups) {
    let count = groups.pairs.len();
    graph.reserve(count, table.slots());
    let threads = world.resource::<PhysicsThreads>().clone();
    let portion = match threads.count() {
        1 => PAIRS_PER_PORTION,
        count => PAIRS_PER_PORTION * count.max(PORTIONS_PER_THREAD),
    };
    // The world is written while loads are found.
    let mut settings = SolveContext::copy_resources(world);
    let mut context = SystemState::<SolveContext>::new(&mut settings);
    let mut finder = Finder {
        contacts: Contacts::new(world, table),
        context: context.get(&settings).expect("it has all settings"),
        local: vec![u32::MAX; table.slots()],
        portion,
    };
    // The first batch reserves the rows of all: a batch allocates an entity for each row that it reserves, and frees those that it does not
    // use.
    let mut to_reserve = Some(count);
    let mut warnings = Vec::new();
    let mut portions = groups.portions(portion).into_iter();
    let mut next = portions.next().map(|groups| finder.find(&groups));
    while let Some(found) = next {
        let ahead = || portions.next().map(|groups| finder.find(&groups));
        (next, _) = threads.beside(portion, ahead, || {
            let found = spawn(world, graph, table, found, to_reserve.take());
            warnings.extend(found);
        });
    }
    world.resource_scope(|_, mut islands: Mut<Islands>| {
        islands.add_structures(table, groups.fixed.iter().map(std::slice::from_ref));
    });
    report(world, warnings);
}

/// Finds contacts and loads.
struct Finder<'a> {
    contacts: Contacts<'a>,
    context: SolveContext<'a>,
    /// By slot: scratch, the index of a body in its structure.
    local: Vec<u32>,
    /// Number of pairs that are found together.
    portion: usize,
}

impl Finder<'_> {
    /// Finds the contacts of some groups, and the forces that keep these still.
    fn find(&mut self, groups: &[Group]) -> Vec<Found> {
        let Self {
            contacts,
            context,
            local,
            portion,
        } = self;
        let threads = &*context.threads;
        let mut found = each(threads, *portion, groups, |group| contacts.find(group));
        for group in &found {
            group.number(local);
        }
        let load = |group: &mut Found| loads::load(group, contacts.table, local, context);
        match threads.runs_in_parallel(*portion) {
            true => threads.run(*portion, || {
                (&mut *found,).share(1, &|(group,)| load(group))
            }),
            false => found.iter_mut().for_each(load),
        }
        found
    }
}

/// Spawns the pairs of some groups, and adds their structures. Rows are reserved for `to_reserve` pairs, if that is more. Returns what is
/// to be reported of their bodies.
fn spawn(
    world: &mut World,
    graph: &mut ConstraintGraph,
    table: &BodyTable,
    found: Vec<Found>,
    to_reserve: Option<usize>,
) -> Vec<(Entity, BodyProblem)> {
    world.resource_scope(|_, mut islands: Mut<Islands>| {
        let structures = found.iter().flat_map(|group| group.islands.iter());
        islands.add_structures(table, structures.map(|island| &*island.members));
    });
    let number: usize = found.iter().map(|group| group.contacts.len()).sum();
    let mut edges = Vec::with_capacity(number);
    let mut warnings = Vec::new();
    let contacts = found.into_iter().flat_map(|mut group| {
        warnings.append(&mut group.warnings);
        group.contacts
    });
    let bundles = contacts.map(|contact| {
        let Contact {
            mut pair,
            parts,
            links,
        } = contact;
        pair.edge = graph.insert_inactive(pair.slots);
        edges.push((pair.edge, links));
        (pair, parts)
    });
    let room = to_reserve.unwrap_or(number);
    let pairs: Vec<Entity> = world.spawn_batch(with_room(bundles, room)).collect();
    for ((edge, links), pair) in edges.into_iter().zip(pairs) {
        graph.name(edge, pair);
        graph.set_links(edge, links);
    }
    graph.forget_linked();
    warnings
}

/// Applies a function to each item, on several threads if these are said to be enough items. The results are in order.
fn each<T: Sync, R: Send>(
    threads: &PhysicsThreads,
    work: usize,
    items: &[T],
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    if !threads.runs_in_parallel(work) {
        return items.iter().map(function).collect();
    }
    let mut found: Vec<Option<R>> = items.iter().map(|_| None).collect();
    threads.run(work, || {
        (items, &mut *found).share(1, &|(item, found)| *found = Some(function(item)));
    });
    found.into_iter().flatten().collect()
}
