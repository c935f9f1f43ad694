//! Copies of bodies and contacts, in a world with the same settings.

use crate::DrystonePlugins;
use crate::body::{
    BodyState, BodyTable, Pose, Sleeping, Velocity, copy_description, properties_of,
};
use crate::collider::Collider;
use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold, NarrowphaseCache,
};
use crate::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::settings::{
    Gravity, InForce, NarrowphaseSettings, SleepSettings, SolverSettings, SpeedLimits,
    StabilizationSettings, StepTime,
};
use bevy_app::App;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use bevy_transform::components::Transform;

/// What the world knows besides components of bodies, by their copies: where the shadow begins.
#[derive(Resource, Default)]
pub(super) struct Taken {
    pub contacts: HashMap<[Entity; 2], Contact>,
    /// By body: where it is, and whether it has moved in the last step.
    pub poses: HashMap<Entity, (Pose, bool)>,
}

/// What there is of a pair.
pub(super) type Contact = (
    ContactPair,
    Manifold,
    ContactImpulses,
    ContactAnchors,
    ContactTargets,
    NarrowphaseCache,
);

/// What a pair has, by the copies of its bodies.
pub(super) fn contact(
    world: &World,
    pair: Entity,
    copies: &HashMap<Entity, Entity>,
) -> Option<([Entity; 2], Contact)> {
    let pair = world.get_entity(pair).ok()?;
    let ends = *pair.get::<ContactPair>()?;
    let [a, b] = ends.bodies.map(|body| copies.get(&body).copied());
    let contact = (
        ends,
        pair.get::<Manifold>()?.clone(),
        pair.get::<ContactImpulses>()?.clone(),
        pair.get::<ContactAnchors>()?.clone(),
        pair.get::<ContactTargets>()?.clone(),
        pair.get::<NarrowphaseCache>()?.clone(),
    );
    Some(([a?, b?], contact))
}

/// Bodies and the pairs that the shadow has found are no news: they are what the originals are.
fn take_over(
    mut commands: Commands,
    mut taken: ResMut<Taken>,
    mut table: ResMut<BodyTable>,
    mut pairs: Query<(
        &mut ContactPair,
        &mut Manifold,
        &mut ContactImpulses,
        &mut ContactAnchors,
        &mut ContactTargets,
        &mut NarrowphaseCache,
    )>,
) {
    let Taken { contacts, poses } = &mut *taken;
    for slot in 0..table.slots() as u32 {
        let Some(body) = table.get_mut(slot) else {
            continue;
        };
        match poses.get(&body.entity) {
            Some((pose, moved)) if *pose == body.pose => {
                (body.arrived, body.renewed, body.moved) = (false, false, *moved);
            }
            // What an edit has put elsewhere is as new as what it has brought.
            _ => body.disturbed |= poses.remove(&body.entity).is_some(),
        }
    }
    for (mut pair, mut manifold, mut impulses, mut anchors, mut targets, mut cache) in &mut pairs {
        if pair.bodies.iter().all(|body| poses.contains_key(body))
            && let Some(contact) = contacts.remove(&pair.bodies)
        {
            let found = *pair;
            (*pair, *manifold, *impulses, *anchors, *targets, *cache) = contact;
            pair.take_ends(&found);
        }
    }
    // An edit has parted the bodies of contacts that are left: those that sleep there wake, as in the world.
    let parted = contacts.iter().filter(|(_, contact)| contact.0.touching);
    let parted: EntityHashSet = parted.flat_map(|(ends, _)| *ends).collect();
    for slot in 0..table.slots() as u32 {
        if let Some(body) = table.get_mut(slot) {
            body.disturbed |= parted.contains(&body.entity);
        }
    }
    commands.remove_resource::<Taken>();
}

/// A world without bodies, with the settings of another.
pub(super) fn empty(world: &World) -> World {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    app.add_systems(
        PhysicsSchedule,
        take_over
            .run_if(resource_exists::<Taken>)
            .after(PhysicsSystems::Broadphase)
            .before(PhysicsSystems::Narrowphase),
    );
    let mut shadow = std::mem::take(app.world_mut());
    shadow.insert_resource(*world.resource::<Gravity>());
    shadow.insert_resource(*world.resource::<StabilizationSettings>());
    shadow.insert_resource(*world.resource::<NarrowphaseSettings>());
    shadow.insert_resource(*world.resource::<SpeedLimits>());
    shadow.insert_resource(*world.resource::<StepTime>());
    shadow.insert_resource(world.resource::<SolverSettings>().clone());
    shadow.insert_resource(world.resource::<InForce>().clone());
    // Where nothing sleeps it is still told how long it has lain.
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

/// How a copy begins.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Lies {
    /// Asleep where the body sleeps.
    AsItIs,
    /// Asleep, if it does not move: it is near the structures, and not in them.
    UntilHit,
    /// Awake: it has lost what it touched.
    Falls,
}

/// A copy of a body.
pub(super) fn copy(world: &World, body: &BodyState, shadow: &mut World, lies: Lies) -> Entity {
    let original = world.entity(body.entity);
    let pose = original.get::<Pose>().copied().unwrap_or(body.pose);
    let velocity = original.get::<Velocity>().copied().unwrap_or_default();
    let mut sleeping = original.get::<Sleeping>().copied().unwrap_or_default();
    let still = body.is_dynamic() && velocity == Velocity::default();
    match lies {
        Lies::AsItIs => (),
        Lies::UntilHit => sleeping.asleep |= still,
        Lies::Falls => sleeping = Sleeping::default(),
    }
    // Most of it at once: each insertion of its own would move the body to another table.
    let parts = (
        (body.kind, to_transform(pose), velocity, sleeping),
        properties_of(original),
    );
    let mut copy = match original.get::<Collider>() {
        Some(collider) => shadow.spawn((parts, collider.clone())),
        None => shadow.spawn(parts),
    };
    copy_description(original, &mut copy);
    copy.id()
}

pub(super) fn to_transform(pose: Pose) -> Transform {
    let pose = pose.normalized();
    Transform::from_translation(pose.position).with_rotation(pose.rotation)
}
