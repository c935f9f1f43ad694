//! Waking by need: what is touched on a sleeping structure wakes what must move, and nothing else. The structure stands, falls and answers
//! as it does awake.

mod limits;
mod plays;
mod reach;

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{ExternalForce, Sleeping, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::prelude::RigidBody;
use drystone::settings::{SleepSettings, Waking};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// How bodies sleep.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// They never sleep.
    Awake,
    /// They wake by islands.
    Islands,
    /// They wake by need.
    Need,
}

/// A scene that has come to rest.
struct Site {
    lab: Lab,
    bricks: Vec<Entity>,
}

impl Site {
    /// A world without bodies.
    fn empty(mode: Mode, dt: f32) -> Lab {
        let mut lab = Lab::new();
        lab.dt = dt;
        let mut settings = lab.world.resource_mut::<SleepSettings>();
        settings.enabled = mode != Mode::Awake;
        if mode == Mode::Islands {
            settings.waking = Waking::Islands;
        }
        lab
    }

    /// A scene after three seconds.
    fn of(scene: &str, mode: Mode, dt: f32) -> Self {
        Self::with(scene, &SceneOptions::default(), mode, dt)
    }

    fn with(scene: &str, options: &SceneOptions, mode: Mode, dt: f32) -> Self {
        let mut lab = Self::empty(mode, dt);
        let scene: Scene = scene.parse().expect("a scene");
        let bricks = scene.build(&mut lab.world, options).bodies;
        lab.run(3.0);
        let site = Self { lab, bricks };
        if mode != Mode::Awake {
            assert_eq!(site.awake(), 0, "{scene:?} sleeps");
        }
        site
    }

    fn is_awake(&self, body: Entity) -> bool {
        let sleeping = self.lab.world.get::<Sleeping>(body);
        sleeping.is_some_and(|sleeping| !sleeping.asleep)
    }

    /// Number of bricks of the scene that are awake.
    fn awake(&self) -> usize {
        let bricks = self.bricks.iter();
        bricks.filter(|&&brick| self.is_awake(brick)).count()
    }

    fn places(&self) -> Vec<Option<Vec3>> {
        let place = |&brick: &Entity| {
            let lives = self.lab.world.get_entity(brick).is_ok();
            lives.then(|| self.lab.position(brick))
        };
        self.bricks.iter().map(place).collect()
    }

    /// The largest distance of a brick from where it was, m.
    fn moved(&self, from: &[Option<Vec3>]) -> f32 {
        let pairs = from.iter().zip(self.places());
        let moved = pairs.filter_map(|(from, now)| Some(now?.distance((*from)?)));
        moved.fold(0.0, f32::max)
    }

    /// Lays a brick of 1 × 0.5 × 0.5 m.
    fn lay(&mut self, at: Vec3) -> Entity {
        self.lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.5, 0.5),
            Friction::new(0.5),
            Transform::from_translation(at),
        ))
    }

    /// Pushes a body with a force, N, until that is changed or its `ExternalForce` is removed.
    fn push(&mut self, body: Entity, force: Vec3) {
        self.lab.world.entity_mut(body).insert(ExternalForce {
            force,
            ..Default::default()
        });
    }

    fn throw(&mut self, radius: f32, from: Vec3, velocity: Vec3) -> Entity {
        self.lab.spawn((
            RigidBody::Dynamic,
            Collider::ball(radius),
            Friction::new(0.5),
            Transform::from_translation(from),
            Velocity::linear(velocity),
        ))
    }

    /// Wakes all bricks for five seconds, and returns how far one of them moves at most, m.
    fn all_woken(&mut self) -> f32 {
        let before = self.places();
        self.lab.world.resource_mut::<SleepSettings>().enabled = false;
        for &brick in &self.bricks {
            if let Some(mut sleeping) = self.lab.world.get_mut::<Sleeping>(brick) {
                sleeping.wake();
            }
        }
        self.lab.run(5.0);
        assert_eq!(self.awake(), before.iter().flatten().count());
        self.moved(&before)
    }
}
