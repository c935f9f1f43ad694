//! Code that the tests share: a world without an app, functions that spawn bodies, the state of a world in another one ([`copy`]),
//! [`masonry`] with its limits by statics, and observers that do [`mischief`].

pub mod accuracy;
pub mod copy;
pub mod masonry;
pub mod mischief;

use bevy_app::App;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{BodyIndex, BodyTable, MassProperties, Pose, RigidBody, SpawnOrder, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::contact::{ContactImpulses, ContactPair};
use drystone::diagnosis::BodyError;
use drystone::schedule::PhysicsSchedule;
use drystone::settings::{
    ContactSolver, Preset, SleepSettings, SolverSettings, StabilizationSettings,
};
use drystone::solver::Nncg;
use glam::{Quat, Vec3};

pub const G: f32 = 9.81;

/// A world with every plugin, stepped by hand.
pub struct Lab {
    pub world: World,
    pub dt: f32,
}

impl Default for Lab {
    fn default() -> Self {
        Self::new()
    }
}

impl Lab {
    /// The settings that a Bevy user gets.
    pub fn new() -> Self {
        Self::with_preset(Preset::Default)
    }

    pub fn with_preset(preset: Preset) -> Self {
        let mut app = App::new();
        app.add_plugins(DrystonePlugins::default());
        let mut world = std::mem::take(app.world_mut());
        // Two systems of ours that could run either way round are an error here, and a user's business elsewhere.
        let mut schedules = world.resource_mut::<Schedules>();
        let physics = schedules.get_mut(PhysicsSchedule).expect("it was added");
        physics.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            ..Default::default()
        });
        world.insert_resource(preset.stabilization());
        world.insert_resource(preset.narrowphase());
        world.insert_resource(preset.solver());
        world.insert_resource(preset.sleeping());
        Self {
            world,
            dt: preset.dt(),
        }
    }

    /// The default settings with NNCG, which converges: to compare with closed forms, what counts is the model, not how
    /// many sweeps a game can afford. No sleeping; one substep, so that impulses are those of a whole step.
    pub fn exact(dt: f32) -> Self {
        let solver = Nncg {
            iterations: 300,
            warm_start: 0.3,
            tolerance: 1e-6,
            ..Default::default()
        };
        Self::solved_by(dt, solver)
    }

    /// As [`Self::shipped`], with another solver.
    pub fn solved_by(dt: f32, solver: impl Into<ContactSolver>) -> Self {
        let mut lab = Self::shipped(dt);
        lab.world.insert_resource(SolverSettings::new(solver));
        lab
    }

    /// The default settings without sleeping, because thresholds are tested with slow motion.
    pub fn shipped(dt: f32) -> Self {
        let mut lab = Self::new();
        lab.dt = dt;
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        lab
    }

    pub fn without_friction_stabilization(mut self) -> Self {
        let mut settings = self.world.resource_mut::<StabilizationSettings>();
        settings.friction.enabled = false;
        self
    }

    /// Messages stay until they are read.
    pub fn step(&mut self) {
        drystone::advance(&mut self.world, self.dt).expect("the step is positive");
    }

    pub fn run(&mut self, seconds: f32) {
        for _ in 0..(seconds / self.dt).round() as usize {
            self.step();
        }
    }

    pub fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world.spawn(bundle).id()
    }

    /// The half-space below y = 0 with μ 0.5.
    pub fn ground(&mut self) -> Entity {
        self.slope(0.0, 0.5)
    }

    /// A half-space that falls towards +x by this angle, rad.
    pub fn slope(&mut self, angle: f32, friction: f32) -> Entity {
        self.spawn((
            Name::new("ground"),
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Friction::new(friction),
            Transform::from_rotation(Quat::from_rotation_z(-angle)),
        ))
    }

    /// A dynamic body.
    pub fn body(&mut self, collider: Collider, position: Vec3) -> Entity {
        self.spawn((
            RigidBody::Dynamic,
            collider,
            Transform::from_translation(position),
        ))
    }

    pub fn cube(&mut self, position: Vec3) -> Entity {
        self.body(Collider::cuboid(1.0, 1.0, 1.0), position)
    }

    /// The pose of a body. Before its first step, that of its `Transform`.
    pub fn pose(&self, body: Entity) -> Pose {
        let new = self.world.get::<BodyIndex>(body) == Some(&BodyIndex::NONE);
        if new && let Some(transform) = self.world.get::<Transform>(body) {
            return Pose {
                position: transform.translation,
                rotation: transform.rotation,
            };
        }
        *self.world.get::<Pose>(body).expect("it is a body")
    }

    pub fn position(&self, body: Entity) -> Vec3 {
        self.pose(body).position
    }

    pub fn velocity(&self, body: Entity) -> Velocity {
        *self.world.get::<Velocity>(body).expect("it is a body")
    }

    pub fn mass(&self, body: Entity) -> MassProperties {
        *self.world.get::<MassProperties>(body).expect("a body")
    }

    pub fn set_velocity(&mut self, body: Entity, linear: Vec3, angular: Vec3) {
        *self.world.get_mut::<Velocity>(body).expect("a body") = Velocity { linear, angular };
    }

    /// Σλ_n and Σλ_t on the first of two bodies from the second, N·s.
    pub fn impulse(&mut self, on: Entity, from: Entity) -> (f32, Vec3) {
        let mut pairs = self.world.query::<(&ContactPair, &ContactImpulses)>();
        let mut sums = (0.0, Vec3::ZERO);
        for (pair, impulses) in pairs.iter(&self.world) {
            let sign = match pair.bodies {
                [a, b] if (a, b) == (on, from) => 1.0,
                [a, b] if (b, a) == (on, from) => -1.0,
                _ => continue,
            };
            sums.0 += impulses.normal();
            sums.1 += sign * impulses.tangential();
        }
        sums
    }

    /// The errors sent since the last call.
    pub fn errors(&mut self) -> Vec<BodyError> {
        let mut messages = self.world.resource_mut::<Messages<BodyError>>();
        messages.drain().collect()
    }

    /// Poses and velocities of all bodies in the order in which they came, to the bit.
    pub fn bits(&self) -> Vec<[u32; 13]> {
        let table = self.world.resource::<BodyTable>();
        let mut bodies: Vec<_> = table
            .iter()
            .map(|(_, b)| (b.spawn_order, b.entity))
            .collect();
        bodies.sort_unstable();
        let of = |&(_, body): &(SpawnOrder, Entity)| {
            let (p, v) = (self.pose(body), self.velocity(body));
            let (x, q, l, a) = (p.position, p.rotation, v.linear, v.angular);
            [
                x.x, x.y, x.z, q.x, q.y, q.z, q.w, l.x, l.y, l.z, a.x, a.y, a.z,
            ]
            .map(f32::to_bits)
        };
        bodies.iter().map(of).collect()
    }
}

/// The largest parameter known to hold and the smallest known to give way, bracketed to `width`.
pub fn bisect(holds: f32, gives: f32, width: f32, stands: impl Fn(f32) -> bool) -> f32 {
    assert!(stands(holds), "must hold at {holds}");
    assert!(!stands(gives), "must give way at {gives}");
    narrow(holds, gives, width, stands)
}

/// Halves a bracket until it is `width` wide, and returns its middle.
fn narrow(mut holds: f32, mut gives: f32, width: f32, stands: impl Fn(f32) -> bool) -> f32 {
    while (gives - holds).abs() > width {
        let middle = 0.5 * (holds + gives);
        if stands(middle) {
            holds = middle;
        } else {
            gives = middle;
        }
    }
    0.5 * (holds + gives)
}

/// Asserts that two numbers agree within a share of the second.
#[track_caller]
pub fn assert_near(found: f32, expected: f32, share: f32, what: &str) {
    let off = (found - expected).abs() / expected.abs();
    println!(
        "{what}: found {found}, expected {expected}, off by {:.3} %",
        100.0 * off
    );
    assert!(
        off <= share,
        "{what}: {found} instead of {expected}, off by {off} of it"
    );
}
