//! Copies of bodies and contacts, in a world with the same settings.

use crate::DrystonePlugins;
use crate::body::{
    BodyState, BodyTable, ExternalImpulse, Pose, Sleeping, Velocity, parts::CompoundCollider,
};
use crate::contact::ContactHooks;
use crate::graph::{ConstraintGraph, Drift, Islands};
use crate::joint_types;
use crate::pair::{ContactPair, PairParts, PairsMut, Wrench, clone_pair};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::settings::{ActiveSettings, SleepSettings, StepTime};
use crate::state::{self, Role, copy_settings, parts_of};
use crate::stored::erased::Values;
use bevy_app::App;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use bevy_transform::components::Transform;
use std::any::TypeId;

/// State of the original world besides components of bodies, keyed by the copies. The shadow starts from it.
#[derive(Resource, Default)]
pub(super) struct OriginalState {
    pub contacts: HashMap<[Entity; 2], Contact>,
    /// By body: its pose, and whether it moved in the last step.
    pub poses: HashMap<Entity, (Pose, bool)>,
    /// The forces with which sleeping bodies fell asleep, where they are on record.
    pub accounts: HashMap<Entity, Wrench>,
    /// Earlier velocities of bodies that are still.
    pub drifts: HashMap<Entity, Drift>,
    /// Bodies that lost a contact because a body was removed since the last step.
    pub bereft: Vec<Entity>,
}

/// The components of a pair.
pub(super) type Contact = (ContactPair, PairParts);

/// The components of a pair, and the copies of its bodies.
pub(super) fn contact(
    world: &World,
    pair: Entity,
    copies: &HashMap<Entity, Entity>,
) -> Option<([Entity; 2], Contact)> {
    let contact = clone_pair(world.get_entity(pair).ok()?)?;
    let [a, b] = contact.0.bodies.map(|body| copies.get(&body).copied());
    Some(([a?, b?], contact))
}

/// Sets bodies and pairs of the shadow to the state of the originals, so that the first step does not treat them as new.
fn take_over(
    mut commands: Commands,
    mut original: ResMut<OriginalState>,
    mut table: ResMut<BodyTable>,
    (mut graph, mut islands): (ResMut<ConstraintGraph>, ResMut<Islands>),
    mut pairs: PairsMut,
) {
    let OriginalState {
        contacts,
        poses,
        accounts,
        drifts,
        bereft,
    } = &mut *original;
    for slot in 0..table.slots() as u32 {
        let Some(body) = table.get_mut(slot) else {
            continue;
        };
        if let Some(&forces) = accounts.get(&body.entity) {
            islands.open_account(slot, forces);
        }
        if let Some(&drift) = drifts.get(&body.entity) {
            islands.set_drift(slot, drift);
        }
        match poses.get(&body.entity) {
            Some((pose, moved)) if *pose == body.pose => {
                (body.arrived, body.renewed, body.moved) = (false, false, *moved);
            }
            // A body that the edit has moved counts as new, as a body that it has added does.
            _ => body.disturbed |= poses.remove(&body.entity).is_some(),
        }
    }
    for (_, columns) in &mut pairs {
        let (mut pair, mut cache, mut manifold, mut impulses, mut anchors, mut targets) = columns;
        if pair.bodies.iter().all(|body| poses.contains_key(body))
            && let Some(contact) = contacts.remove(&pair.bodies)
        {
            let found = *pair;
            let parts;
            (*pair, parts) = contact;
            (*manifold, *targets, *impulses, *anchors, *cache) = parts;
            pair.take_ends(&found);
        }
    }
    // These contacts ended because the edit has separated their bodies. Their sleeping bodies wake, as in the original world.
    let parted = contacts.iter().filter(|(_, contact)| contact.0.touching);
    let parted = parted.flat_map(|(ends, _)| *ends);
    let parted: EntityHashSet = parted.chain(bereft.drain(..)).collect();
    for slot in 0..table.slots() as u32 {
        if let Some(body) = table.get_mut(slot)
            && parted.contains(&body.entity)
        {
            body.disturbed = true;
            graph.part(slot);
        }
    }
    commands.remove_resource::<OriginalState>();
}

/// An empty world with the settings of another.
pub(super) fn empty(world: &World) -> World {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    app.add_systems(
        PhysicsSchedule,
        take_over
            .run_if(resource_exists::<OriginalState>)
            .after(PhysicsSystems::Broadphase)
            .before(PhysicsSystems::Narrowphase),
    );
    let mut shadow = std::mem::take(app.world_mut());
    copy_settings(world, &mut shadow);
    shadow.insert_resource(*world.resource::<StepTime>());
    if let Some(hooks) = world.get_resource::<ContactHooks>() {
        shadow.insert_resource(hooks.clone());
    }
    shadow.insert_resource(world.resource::<ActiveSettings>().clone());
    // If the settings do not allow sleeping, no copy falls asleep, but the time for which it has been still is recorded all the same.
    let sleeping = *world.resource::<SleepSettings>();
    shadow.insert_resource(SleepSettings {
        enabled: true,
        delay: if sleeping.enabled {
            sleeping.delay
        } else {
            f32::INFINITY
        },
        ..sleeping
    });
    shadow
}

/// The initial activity of a copy.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Activity {
    /// Asleep if the body sleeps.
    AsOriginal,
    /// Asleep if the body does not move, for bodies near the structures that are not part of them.
    Asleep,
}

/// A copy of a body.
pub(super) fn copy(
    world: &World,
    body: &BodyState,
    shadow: &mut World,
    activity: Activity,
) -> Entity {
    let original = world.entity(body.entity);
    let pose = original.get::<Pose>().copied().unwrap_or(body.pose);
    let velocity = original.get::<Velocity>().copied().unwrap_or_default();
    let impulse: ExternalImpulse = original.get().copied().unwrap_or_default();
    let mut sleeping = original.get::<Sleeping>().copied().unwrap_or_default();
    let still = body.is_dynamic() && velocity == Velocity::default();
    match activity {
        Activity::AsOriginal => (),
        Activity::Asleep => sleeping.asleep |= still,
    }
    // All components are inserted at once: each further insertion would move the entity to another table.
    let mut parts = vec![
        with(body.kind),
        with(to_transform(pose)),
        with(velocity),
        with(impulse),
        with(sleeping),
    ];
    parts.extend(parts_of(world, body.entity, Role::Body));
    // The parts of the original are not copied.
    for part in &mut parts {
        if let Some([compound]) = part.as_mut().typed::<CompoundCollider>() {
            compound.detach();
        }
    }
    let mut copy = shadow.spawn_empty();
    Values::insert_all_into(&mut parts, &mut copy);
    copy.id()
}

fn with<T: 'static>(value: T) -> Values {
    Values::with(state::list().component(TypeId::of::<T>()), value)
}

/// A copy of a joint between these bodies of the copy.
pub(super) fn copy_joint(
    world: &World,
    joint: Entity,
    shadow: &mut World,
    bodies: [Option<Entity>; 2],
) -> Option<Entity> {
    world.get_entity(joint).ok()?;
    let mut parts = parts_of(world, joint, Role::Joint);
    for part in &mut parts {
        joint_types::set_bodies(part, bodies);
    }
    let mut copy = shadow.spawn_empty();
    Values::insert_all_into(&mut parts, &mut copy);
    Some(copy.id())
}

pub(super) fn to_transform(pose: Pose) -> Transform {
    pose.normalized().to_transform()
}
