//! Observers that do anything to the world at any event of drystone's components, while a step runs.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{BodyIndex, Inactive, SpawnOrder};
use drystone::children::{ColliderOf, CompoundCollider, ImplicitBody};
use drystone::contact::ContactPair;
use drystone::joint::JointEdge;
use drystone::mortar::MortarJoint;
use drystone::prelude::*;

/// Number of kinds of what observers do.
pub const KINDS: usize = 12;

/// How often observers act in a step.
const ACTS: usize = 3;

#[derive(Resource)]
struct Mischief {
    state: u64,
    /// How often they may still act in this step.
    left: usize,
    kind: usize,
    /// Bodies that are spared.
    spared: Vec<Entity>,
}

impl Mischief {
    fn roll(&mut self, sides: usize) -> usize {
        let product = self.state.wrapping_mul(0x5851_f42d_4c95_7f2d);
        self.state = product.wrapping_add(0x1405_7b7e_f767_814f);
        (self.state >> 33) as usize % sides.max(1)
    }
}

macro_rules! listen_to {
    ($world:expr, $($Component:ty),+ $(,)?) => {$(
        $world.add_observer(|on: On<Insert<$Component>>, commands: Commands| later(on.entity, commands));
        $world.add_observer(|on: On<Remove<$Component>>, commands: Commands| later(on.entity, commands));
    )+};
}
/// Adds the observers. None listens to `ChildOf`: Bevy's own hook fails if the parent is despawned then. They do what the kind says, or
/// anything if there is no such kind, and spare some bodies.
pub fn listen(world: &mut World, seed: u64, kind: usize, spared: Vec<Entity>) {
    world.insert_resource(Mischief {
        state: seed,
        left: 0,
        kind,
        spared,
    });
    listen_to!(
        world,
        MortarJoint,
        Mortar,
        JointForces,
        JointEdge,
        JointDisabled,
        QuarantinedJoint,
        Quarantined,
        ContactPair,
        Inactive,
        ColliderOf,
        ImplicitBody,
        CompoundCollider,
        BodyIndex,
        RigidBody,
        RigidBodyDisabled,
        Collider,
        SpawnOrder,
        MassProperties,
    );
    world.add_observer(|on: On<ContactStarted>, commands: Commands| later(on.body, commands));
    world.add_observer(|on: On<ContactEnded>, commands: Commands| later(on.body, commands));
    world.add_observer(|on: On<JointBroke>, commands: Commands| later(on.joint, commands));
    world.add_observer(|on: On<SensorEntered>, commands: Commands| later(on.sensor, commands));
    world.add_observer(|on: On<SensorExited>, commands: Commands| later(on.sensor, commands));
}

/// Lets the observers act meanwhile.
pub fn during<T>(world: &mut World, act: impl FnOnce(&mut World) -> T) -> T {
    world.resource_mut::<Mischief>().left = ACTS;
    let result = act(world);
    world.resource_mut::<Mischief>().left = 0;
    result
}

fn later(entity: Entity, mut commands: Commands) {
    commands.queue(move |world: &mut World| act(world, entity));
}

/// Does something to the entity of an event, or to another one.
fn act(world: &mut World, entity: Entity) {
    let Some(mut mischief) = world.get_resource_mut::<Mischief>() else {
        return;
    };
    if mischief.left == 0 || mischief.roll(3) > 0 {
        return;
    }
    mischief.left -= 1;
    let kind = match mischief.kind {
        kind if kind < KINDS => kind,
        _ => mischief.roll(KINDS),
    };
    let rolls = [(); 3].map(|()| mischief.roll(usize::MAX));
    let spared = mischief.spared.clone();
    let is_spared = |world: &World, entity: &Entity| {
        let pair = world.get::<ContactPair>(*entity);
        let bodies = pair.map_or([*entity; 2], |pair| pair.bodies);
        bodies.iter().any(|body| spared.contains(body))
    };
    let mut bodies = world.query_filtered::<Entity, (With<BodyIndex>, Allow<Disabled>)>();
    let mut bodies: Vec<Entity> = bodies.iter(world).collect();
    bodies.retain(|body| !is_spared(world, body));
    let mut others = world
        .query_filtered::<Entity, Or<(With<ContactPair>, With<JointForces>, With<Collider>)>>();
    let mut others: Vec<Entity> = others.iter(world).collect();
    others.retain(|other| !is_spared(world, other));
    let nth = |all: &[Entity], i: usize| all.get(rolls[i].checked_rem(all.len())?).copied();
    let (Some(body), Some(parent), Some(other)) =
        (nth(&bodies, 0), nth(&bodies, 1), nth(&others, 2))
    else {
        return;
    };
    let mut above = Some(parent);
    let mut is_below = false;
    while let Some(at) = above {
        is_below |= at == body;
        above = world.get::<ChildOf>(at).map(ChildOf::parent);
    }
    let target = match kind {
        0 if is_spared(world, &entity) => return,
        0 => entity,
        1 | 2 => other,
        _ => body,
    };
    let Ok(mut target) = world.get_entity_mut(target) else {
        return;
    };
    match kind {
        0 | 1 | 3 => target.despawn(),
        // Nearly all, but not the layers by which bodies are spared.
        2 => {
            _ = target.remove::<(
                RigidBody,
                Collider,
                Pose,
                Velocity,
                Transform,
                ContactPair,
                JointForces,
            )>()
        }
        4 => _ = target.insert(RigidBodyDisabled),
        5 => _ = target.insert(Disabled),
        6 => _ = target.remove::<RigidBody>(),
        7 if !is_below => _ = target.insert(ChildOf(parent)),
        8 => _ = target.insert(Mass(f32::NAN)),
        9 => _ = target.insert(Collider::ball(0.3)),
        10 => _ = target.remove::<(RigidBodyDisabled, Disabled, ChildOf)>(),
        11 => _ = target.remove::<(BodyIndex, Collider)>(),
        _ => (),
    }
}
