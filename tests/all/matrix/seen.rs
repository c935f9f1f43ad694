//! What is seen of a world in a step: the bits of bodies, joints and contacts, and all that is reported.

use super::Scene;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::contact::ContactImpulses;
use drystone::prelude::*;
use std::fmt::Debug;

/// What one step shows. Things are in spawn order and named by it, because entities differ from world to world.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shown {
    pub things: Vec<Thing>,
    pub reports: Vec<String>,
}

/// A body, a joint or a contact.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Thing {
    kind: &'static str,
    orders: Vec<SpawnOrder>,
    bits: Vec<u32>,
}

/// Takes the steps of a scene.
pub(super) fn take_steps(scene: &Scene, world: &mut World, named: &[Entity]) -> Vec<Shown> {
    take_steps_with(scene, world, named, &mut |_| ())
}

/// Takes the steps of a scene, and does something before each.
pub(super) fn take_steps_with(
    scene: &Scene,
    world: &mut World,
    named: &[Entity],
    before: &mut dyn FnMut(&mut World),
) -> Vec<Shown> {
    let mut viewer = Viewer::new(world);
    let steps = (0..scene.steps).map(|step| {
        before(world);
        (scene.edit)(world, named, step);
        drystone::step(world, scene.dt).unwrap();
        viewer.look(world)
    });
    steps.collect()
}

/// The events that observers received.
#[derive(Resource, Default)]
pub(super) struct Heard(Vec<(Entity, f32)>);

/// Observer: a contact of a body with `ContactEvents` has begun.
pub(super) fn hear(started: On<ContactStarted>, mut heard: ResMut<Heard>) {
    heard.0.push((started.body, started.impulse));
}

/// Sees what happens in a world from when it was made.
pub(super) struct Viewer {
    /// The entities that were seen, also those that were despawned since.
    orders: EntityHashMap<SpawnOrder>,
}

impl Viewer {
    pub fn new(world: &mut World) -> Self {
        let mut viewer = Self {
            orders: EntityHashMap::default(),
        };
        viewer.reports(world);
        viewer
    }

    /// What the last step shows.
    pub fn look(&mut self, world: &mut World) -> Shown {
        Shown {
            reports: self.reports(world),
            things: things(world),
        }
    }

    /// Takes the messages of a world.
    fn reports(&mut self, world: &mut World) -> Vec<String> {
        let mut numbered = world.query_filtered::<(Entity, &SpawnOrder), Allow<Disabled>>();
        let numbered = numbered.iter(world);
        self.orders
            .extend(numbered.map(|(entity, &order)| (entity, order)));
        let name = |entity: Entity| self.orders.get(&entity).copied();
        let names = |entities: &[Entity]| {
            let mut names: Vec<_> = entities.iter().map(|&entity| name(entity)).collect();
            names.sort();
            names
        };
        let all = &mut Vec::new();
        for (body, impulse) in std::mem::take(&mut world.resource_mut::<Heard>().0) {
            all.push(format!("{:?}", ("heard", name(body), impulse.to_bits())));
        }
        take(world, all, |of: ContactStarted| {
            let at = of.point.to_array().map(f32::to_bits);
            (
                "started",
                name(of.body),
                name(of.other),
                at,
                of.impulse.to_bits(),
            )
        });
        take(world, all, |of: ContactEnded| {
            ("ended", name(of.body), name(of.other))
        });
        take(world, all, |of: ContactForce| {
            let force = of.force.to_array().map(f32::to_bits);
            ("force", name(of.body), name(of.other), force)
        });
        take(world, all, |of: SensorEntered| {
            ("entered", name(of.sensor), name(of.body), name(of.collider))
        });
        take(world, all, |of: SensorExited| {
            ("exited", name(of.sensor), name(of.body), name(of.collider))
        });
        // A problem that names another body does so in its sentence.
        take(world, all, |of: BodyError| {
            (
                "error",
                name(of.entity),
                of.name,
                std::mem::discriminant(&of.problem),
            )
        });
        take(world, all, |of: JointBroke| ("joint broke", name(of.joint)));
        take(world, all, |of: MortarBroke| {
            let [body, other, joint] = [of.body, of.other, of.joint].map(name);
            (
                "mortar broke",
                body,
                other,
                joint,
                of.how,
                of.stress.to_bits(),
            )
        });
        take(world, all, |of: Collapse| {
            ("collapse", name(of.first), of.how, names(&of.rest))
        });
        take(world, all, |of: CollapseEnded| {
            ("collapse ended", name(of.first), of.how, names(&of.moved))
        });
        std::mem::take(all)
    }
}

fn take<T: Message, D: Debug>(world: &mut World, all: &mut Vec<String>, line: impl Fn(T) -> D) {
    let messages = world
        .resource_mut::<Messages<T>>()
        .drain()
        .collect::<Vec<T>>();
    all.extend(
        messages
            .into_iter()
            .map(|message| format!("{:?}", line(message))),
    );
}

/// Bodies, contacts and joints.
fn things(world: &mut World) -> Vec<Thing> {
    let mut things = bodies(world);
    things.extend(contacts(world));
    things.extend(joints(world));
    things.sort_by(|a, b| (a.kind, &a.orders, &a.bits).cmp(&(b.kind, &b.orders, &b.bits)));
    things
}

fn bits(vectors: &[Vec3]) -> impl Iterator<Item = u32> {
    vectors
        .iter()
        .flat_map(|of| of.to_array().map(f32::to_bits))
}

fn bodies(world: &mut World) -> Vec<Thing> {
    type Body<'a> = (
        &'a SpawnOrder,
        (
            &'a Pose,
            &'a Velocity,
            &'a Sleeping,
            &'a Transform,
            Option<&'a Load>,
        ),
        (Has<Inactive>, Has<Quarantined>, Has<Disabled>),
    );
    let mut bodies = world.query_filtered::<Body, Allow<Disabled>>();
    let things = bodies.iter(world).map(|(&order, values, flags)| {
        let (pose, velocity, sleeping, drawn, load) = values;
        let (is_inactive, is_invalid, is_disabled) = flags;
        let load = load.map_or(Vec3::ZERO, |load| load.force);
        let vectors = [
            pose.position,
            velocity.linear,
            velocity.angular,
            drawn.translation,
            load,
        ];
        let turns = [pose.rotation, drawn.rotation].map(|turn| turn.to_array().map(f32::to_bits));
        let flags = [sleeping.asleep, is_inactive, is_invalid, is_disabled].map(u32::from);
        let more = turns
            .as_flattened()
            .iter()
            .copied()
            .chain([sleeping.still_for.to_bits()]);
        Thing {
            kind: "body",
            orders: vec![order],
            bits: bits(&vectors).chain(more).chain(flags).collect(),
        }
    });
    things.collect()
}

fn contacts(world: &mut World) -> Vec<Thing> {
    let mut pairs = world.query::<(&ContactPair, &ContactImpulses)>();
    let things = pairs.iter(world).map(|(pair, impulses)| {
        let points = impulses.points.iter();
        let points = points.map(|of| Vec3::new(of.normal, of.normal_force, of.rest_force));
        let patches = impulses.patches.iter();
        let patches = patches.map(|of| of.friction_force + of.rest_friction_force);
        let vectors: Vec<Vec3> = points.chain(patches).collect();
        Thing {
            kind: "contact",
            orders: pair.spawn_orders.to_vec(),
            bits: bits(&vectors).collect(),
        }
    });
    things.collect()
}

fn joints(world: &mut World) -> Vec<Thing> {
    type Joint<'a> = (&'a SpawnOrder, &'a JointForces, Has<JointDisabled>);
    let mut joints = world.query_filtered::<Joint, Allow<Disabled>>();
    let things = joints
        .iter(world)
        .map(|(&order, forces, is_disabled)| Thing {
            kind: "joint",
            orders: vec![order],
            bits: bits(&[forces.force, forces.torque])
                .chain([is_disabled.into()])
                .collect(),
        });
    things.collect()
}

/// The first step that differs, and the first thing in it, or the first report. Bodies come first, because contacts follow from them.
pub(super) fn first_difference(one: &[Shown], other: &[Shown]) -> Option<String> {
    assert_eq!(one.len(), other.len(), "as many steps");
    let mut steps = one.iter().zip(other).enumerate();
    let (step, (one, other)) = steps.find(|(_, (one, other))| one != other)?;
    let mut things = one.things.iter().zip(&other.things);
    let found = match things.find(|(one, other)| one != other) {
        Some((one, other)) => one.difference(other),
        None if one.things.len() != other.things.len() => {
            let [one, other] = [one, other].map(|of| of.things.len());
            format!("{other} bodies, joints and contacts, not {one}")
        }
        None => format!("reports are {:?}, not {:?}", other.reports, one.reports),
    };
    Some(format!("step {step}: {found}"))
}

impl Thing {
    fn name(&self) -> String {
        let orders: Vec<String> = self
            .orders
            .iter()
            .map(|order| order.0.to_string())
            .collect();
        format!("{}, number {}", self.kind, orders.join(" and "))
    }

    fn difference(&self, other: &Self) -> String {
        let name = self.name();
        if (self.kind, &self.orders) != (other.kind, &other.orders) {
            return format!("there is {}, not {name}", other.name());
        }
        let bits = self.bits.iter().zip(&other.bits);
        let at = bits.take_while(|(one, other)| one == other).count();
        let [one, other] =
            [self, other].map(|of| of.bits.get(at).map(|&bits| f32::from_bits(bits)));
        format!("{name}: value {at} is {other:?}, not {one:?}")
    }
}
