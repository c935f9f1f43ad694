//! The world under test: guests, which the operations change, on a ground that no operation changes; and far away the innocent, a small
//! stack. The innocent also stand in a second world without guests.

use crate::operation::{Act, Operation, Spawn};
use crate::part::{INNOCENT, Part};
use crate::shape::Shape;
use bevy_app::App;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{
    BodyIndex, Damping, ExternalForce, ExternalImpulse, GravityScale, Mass, MassProperties, Pose,
    Quarantined, RigidBody, Teleport, Velocity,
};
use drystone::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use drystone::contact::{ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold};
use drystone::grab::Grab;
use drystone::settings::{
    Gravity, NarrowphaseSettings, PhysicsThreads, SleepSettings, SolverSettings, SpeedLimits,
    StabilizationSettings,
};
use glam::Vec3;
use parry3d::shape::ShapeType;
use std::collections::HashSet;
use support::mischief;

/// There are never more guests.
const CROWD: usize = 20;
/// Guests further from the origin than this are taken away, as a game would, m.
const EDGE: f32 = 100.0;
/// The position of the innocent stack, m.
const AWAY: Vec3 = Vec3::new(500.0, 0.0, 0.0);

/// A world, and the innocent in it: their ground, and the bodies on it.
pub struct Half {
    pub world: World,
    pub innocent: Vec<Entity>,
}

pub struct Site {
    pub noisy: Half,
    pub quiet: Half,
    pub guests: Vec<Entity>,
    /// Whether numbers may be bad.
    pub spoils: bool,
    /// Guests that are invalid, or below an invalid one.
    pub tainted: HashSet<Entity>,
    /// Guests that the ground did not always hold.
    pub free: HashSet<Entity>,
    /// Returns true if the settings of solver and stabilization have always been the defaults, and no half-space presses on bodies on the
    /// ground.
    pub plain: bool,
    /// Whether observers act while the noisy world takes a step.
    misbehaves: bool,
}

impl Half {
    fn new() -> Self {
        let mut app = App::new();
        app.add_plugins(DrystonePlugins::default());
        let mut world = std::mem::take(app.world_mut());
        let threads = PhysicsThreads::new(1).expect("one thread can be had");
        world.insert_resource(threads);
        let layers = CollisionLayers {
            memberships: INNOCENT,
            filters: INNOCENT,
        };
        let slab = (
            RigidBody::Static,
            Collider::cuboid(20.0, 1.0, 20.0),
            Transform::from_translation(AWAY - 0.5 * Vec3::Y),
            layers,
        );
        let mut innocent = vec![world.spawn(slab).id()];
        for (x, y) in [(0.0, 0.25), (1.0, 0.25), (0.5, 0.75), (0.5, 1.25)] {
            let brick = (
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 0.5, 0.5),
                Transform::from_translation(AWAY + Vec3::new(x, y, 0.0)),
                layers,
            );
            innocent.push(world.spawn(brick).id());
        }
        Self { world, innocent }
    }
}

impl Site {
    pub fn new(spoils: bool) -> Self {
        let mut noisy = Half::new();
        let ground = (RigidBody::Static, Collider::half_space(Vec3::Y), GUEST);
        noisy.world.spawn(ground);
        Self {
            noisy,
            quiet: Half::new(),
            guests: Vec::new(),
            spoils,
            tainted: HashSet::new(),
            free: HashSet::new(),
            plain: true,
            misbehaves: false,
        }
    }

    /// Does it; a step in both worlds, and only settings else in the quiet one. False where no step was taken.
    pub fn act(&mut self, Act { operation, bad }: &Act) -> bool {
        match operation {
            Operation::Step(dt) => return self.step(*dt),
            Operation::Gravity(_)
            | Operation::Solver(_)
            | Operation::Stabilization(_)
            | Operation::Narrowphase(_)
            | Operation::Forget(_)
            | Operation::Sleep(_)
            | Operation::Speeds(_)
            | Operation::Defaults => self.change_settings(operation),
            Operation::Spawn(spawn) => self.spawn(spawn, *bad),
            Operation::Reset => {
                for pair in self.guests_pairs() {
                    self.noisy.world.despawn(pair);
                }
                for guest in std::mem::take(&mut self.guests) {
                    // It may have gone with its parent.
                    _ = self.noisy.world.try_despawn(guest);
                }
            }
            Operation::DespawnPair(i) => {
                if let Some(pair) = nth(&self.guests_pairs(), *i) {
                    self.noisy.world.despawn(pair);
                }
            }
            Operation::StripPair(i, part) => {
                if let Some(pair) = nth(&self.guests_pairs(), *i) {
                    let mut pair = self.noisy.world.entity_mut(pair);
                    match part % 5 {
                        0 => pair.remove::<ContactPair>(),
                        1 => pair.remove::<Manifold>(),
                        2 => pair.remove::<ContactTargets>(),
                        3 => pair.remove::<ContactImpulses>(),
                        _ => pair.remove::<ContactAnchors>(),
                    };
                }
            }
            Operation::Adopt(child, parent) => {
                let [child, parent] = [child, parent].map(|i| nth(&self.guests, *i));
                if let (Some(child), Some(parent)) = (child, parent)
                    && !self.is_above(child, parent)
                {
                    self.noisy.world.entity_mut(child).insert(ChildOf(parent));
                }
            }
            Operation::Despawn(i)
            | Operation::Clone(i)
            | Operation::MoveTransform(i, ..)
            | Operation::MovePose(i, ..)
            | Operation::Insert(i, _)
            | Operation::Remove(i, _)
            | Operation::Touch(i, _)
            | Operation::Bare(i, _)
            | Operation::Clear(i)
            | Operation::Orphan(i)
            | Operation::Mend(i) => {
                if let Some(guest) = nth(&self.guests, *i) {
                    if *bad {
                        self.tainted.insert(guest);
                    }
                    self.edit(guest, operation);
                }
            }
        }
        self.count();
        if !self.spoils {
            self.teleport();
        }
        false
    }

    /// Changes settings, in both worlds.
    fn change_settings(&mut self, operation: &Operation) {
        match operation {
            Operation::Gravity(gravity) => {
                self.set(|world| world.insert_resource(Gravity(*gravity)))
            }
            Operation::Solver(solver) => {
                self.plain = false;
                self.set(|world| world.insert_resource(solver.settings()));
            }
            Operation::Stabilization(settings) => {
                self.plain = false;
                self.set(|world| world.insert_resource(**settings));
            }
            Operation::Narrowphase(settings) => {
                self.plain = false;
                self.set(|world| world.insert_resource(*settings));
            }
            Operation::Forget(i) => self.set(|world| match i % 6 {
                0 => _ = world.remove_resource::<Gravity>(),
                1 => _ = world.remove_resource::<SolverSettings>(),
                2 => _ = world.remove_resource::<StabilizationSettings>(),
                3 => _ = world.remove_resource::<SleepSettings>(),
                4 => _ = world.remove_resource::<NarrowphaseSettings>(),
                _ => _ = world.remove_resource::<SpeedLimits>(),
            }),
            Operation::Sleep(settings) => self.set(|world| world.insert_resource(*settings)),
            Operation::Speeds(limits) => self.set(|world| world.insert_resource(*limits)),
            Operation::Defaults => self.set(|world| {
                world.insert_resource(Gravity::default());
                world.insert_resource(SolverSettings::default());
                world.insert_resource(StabilizationSettings::default());
                world.insert_resource(NarrowphaseSettings::default());
                world.insert_resource(SleepSettings::default());
                world.insert_resource(SpeedLimits::default());
            }),
            _ => unreachable!("{operation:?} changes no settings"),
        }
    }

    /// Has observers do anything to guests in the steps of the noisy world; see [`mischief`].
    pub fn misbehave(&mut self, seed: u64) {
        let spared = self.noisy.innocent.clone();
        mischief::listen(&mut self.noisy.world, seed, usize::MAX, spared);
        self.misbehaves = true;
    }

    /// Counts the bodies, and records which body is below which.
    pub fn count(&mut self) {
        let world = &self.noisy.world;
        self.guests.retain(|&guest| world.get_entity(guest).is_ok());
        for &guest in &self.guests {
            let body = world.entity(guest);
            let layers = body.get().copied().unwrap_or(CollisionLayers::default());
            let held = layers.collides_with(GUEST)
                && body.contains::<Collider>()
                && body.get() != Some(&RigidBody::Kinematic);
            if !held || body.contains::<ChildOf>() {
                self.free.insert(guest);
            }
            let mut above = guest;
            while let Some(&ChildOf(parent)) = world.get(above) {
                if self.tainted.contains(&parent) {
                    self.tainted.insert(guest);
                }
                above = parent;
            }
        }
    }

    /// A kinematic that is taken metres away within a step would otherwise throw what it meets there.
    fn teleport(&mut self) {
        for &guest in &self.guests {
            let mut guest = self.noisy.world.entity_mut(guest);
            if guest.get() == Some(&RigidBody::Kinematic) {
                guest.insert(Teleport);
            }
        }
    }

    /// Bodies in the noisy world besides the guests: the innocent, and the ground.
    pub fn residents(&self) -> usize {
        self.noisy.innocent.len() + 1
    }

    fn set(&mut self, set: impl Fn(&mut World)) {
        set(&mut self.noisy.world);
        set(&mut self.quiet.world);
    }

    fn step(&mut self, dt: f32) -> bool {
        for guest in self.guests.clone() {
            let pose = self.noisy.world.get::<Pose>(guest);
            if pose.is_some_and(|pose| pose.position.abs().max_element() > EDGE) {
                _ = self.noisy.world.try_despawn(guest);
            }
        }
        self.count();
        let step = |world: &mut World| drystone::step(world, dt).is_ok();
        let taken = [
            match self.misbehaves {
                true => mischief::during(&mut self.noisy.world, step),
                false => step(&mut self.noisy.world),
            },
            step(&mut self.quiet.world),
        ];
        assert_eq!(taken[0], taken[1]);
        taken[0] && dt > 0.0
    }

    fn spawn(&mut self, spawn: &Spawn, bad: bool) {
        if self.guests.len() >= CROWD {
            return;
        }
        let guest = (
            spawn.kind,
            Collider::from(spawn.shape.clone()),
            Transform::from_translation(spawn.at).with_rotation(spawn.turn),
            GUEST,
        );
        let mut guest = self.noisy.world.spawn(guest);
        // Between two half-spaces there may be no place at all.
        self.plain &= !matches!(spawn.shape, Shape::HalfSpace(_));
        if spawn.asleep {
            guest.insert(drystone::body::Sleeping {
                asleep: true,
                ..Default::default()
            });
        }
        let guest = guest.id();
        self.guests.push(guest);
        if bad {
            self.tainted.insert(guest);
        }
    }

    fn edit(&mut self, guest: Entity, operation: &Operation) {
        let mut body = self.noisy.world.entity_mut(guest);
        // A surface has no mass.
        if matches!(
            operation,
            Operation::Insert(_, Part::Kind(RigidBody::Dynamic))
        ) && body.get::<Collider>().is_some_and(is_surface)
        {
            if !self.spoils {
                return;
            }
            self.tainted.insert(guest);
        }
        match operation {
            Operation::Despawn(_) => body.despawn(),
            Operation::Clone(_) if self.guests.len() < CROWD => {
                let twin = body.clone_and_spawn();
                self.guests.push(twin);
                for marked in [&mut self.tainted, &mut self.free] {
                    if marked.contains(&guest) {
                        marked.insert(twin);
                    }
                }
            }
            Operation::MoveTransform(_, position, rotation) => {
                body.insert(Transform::from_translation(*position).with_rotation(*rotation));
            }
            Operation::MovePose(_, position, rotation) => {
                body.insert(Pose {
                    position: *position,
                    rotation: *rotation,
                });
            }
            // Far from its middle what spins is as fast as can be.
            Operation::Insert(_, Part::Velocity(_))
                if !self.spoils && body.get::<Collider>().is_some_and(is_half_space) => {}
            // The innocent are inside some half-space.
            Operation::Remove(_, Part::Layers(_))
                if body.get::<Collider>().is_some_and(is_half_space) => {}
            Operation::Insert(_, part) => part.insert(&mut body),
            Operation::Remove(_, part) => part.remove(&mut body),
            Operation::Touch(_, part) => part.touch(&mut body),
            Operation::Bare(_, part) => {
                match part % 5 {
                    0 => body.remove::<Transform>(),
                    1 => body.remove::<Pose>(),
                    2 => body.remove::<MassProperties>(),
                    3 => body.remove::<BodyIndex>(),
                    _ => body.remove::<CollisionLayers>().insert(GUEST),
                };
            }
            Operation::Clear(_) => {
                body.clear().insert(GUEST);
            }
            Operation::Orphan(_) => {
                body.remove::<ChildOf>();
            }
            Operation::Mend(_) => {
                self.tainted.remove(&guest);
                body.remove::<(ChildOf, Mass, Grab, RollingFriction, Quarantined)>();
                body.remove::<(
                    drystone::body::Density,
                    drystone::body::AngularInertia,
                    drystone::body::CenterOfMass,
                )>();
                body.insert((
                    RigidBody::Dynamic,
                    Collider::cuboid(0.5, 0.5, 0.5),
                    Transform::from_translation(4.0 * Vec3::Y),
                    Pose::default(),
                    Velocity::default(),
                    ExternalForce::default(),
                    ExternalImpulse::default(),
                    Damping::default(),
                    GravityScale::default(),
                    Friction::default(),
                    Restitution::default(),
                ));
            }
            _ => {}
        }
    }

    /// Pairs of guests with each other and the ground, in an order of their own.
    fn guests_pairs(&mut self) -> Vec<Entity> {
        let world = &mut self.noisy.world;
        let innocent = &self.noisy.innocent;
        let mut pairs = world.query::<(Entity, &ContactPair)>();
        let mut pairs: Vec<_> = pairs
            .iter(world)
            .filter(|(_, pair)| !pair.bodies.iter().any(|body| innocent.contains(body)))
            .map(|(entity, pair)| (pair.spawn_orders, entity))
            .collect();
        pairs.sort_unstable();
        pairs.into_iter().map(|(_, entity)| entity).collect()
    }

    /// True where a body is the other, or above it in its hierarchy.
    fn is_above(&self, body: Entity, mut other: Entity) -> bool {
        loop {
            if body == other {
                return true;
            }
            match self.noisy.world.get::<ChildOf>(other) {
                Some(ChildOf(parent)) => other = *parent,
                None => return false,
            }
        }
    }
}

/// The layer of all guests and their ground.
pub const GUEST: CollisionLayers = CollisionLayers {
    memberships: !INNOCENT,
    filters: !INNOCENT,
};

/// Without volume.
fn is_surface(collider: &Collider) -> bool {
    matches!(
        collider.shape().shape_type(),
        ShapeType::HalfSpace | ShapeType::Triangle | ShapeType::TriMesh | ShapeType::HeightField
    )
}

fn is_half_space(collider: &Collider) -> bool {
    collider.shape().as_halfspace().is_some()
}

fn nth(all: &[Entity], i: usize) -> Option<Entity> {
    all.get(i.checked_rem(all.len())?).copied()
}
