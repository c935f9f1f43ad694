//! The game: a wall between two players, who lay bricks on it and shoot at it.

use crate::checksum::Checksum;
use crate::input::{Action, Input, PLAYERS};
use crate::rollback::Rollback;
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::masonry::{BRICK, Bond, Wall};
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use drystone::snapshot::Snapshot;

/// Length of a frame, s.
pub const DT: f32 = 1.0 / 60.0;

/// Speed of a ball, m/s.
const SPEED: f32 = 20.0;

/// Distance of the players from the wall, m.
const DISTANCE: f32 = 6.0;

/// Frames after which a ball is despawned.
const LIFE: u64 = 120;

/// Height above its support at which a brick is laid, m.
const DROP: f32 = 0.01;

/// The first [`SpawnOrder`] of bodies that players spawn. It is above those of the wall.
const FIRST: u64 = 1 << 32;

/// A wall, and the settings of its world.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Bricks in a course.
    pub columns: u8,
    /// Courses.
    pub courses: u8,
    /// Radius of the balls, m. They weigh 1 000 kg/m³, as bricks do.
    pub ball: f32,
    /// Whether bodies may fall asleep.
    pub sleeping: bool,
    /// Steps before the first frame.
    pub settle: u32,
}

/// A wall of 40 × 25 bricks, which is 1 012 with the half ones, and balls of 4 kg. The wall sleeps when the game begins.
impl Default for Setup {
    fn default() -> Self {
        Self {
            columns: 40,
            courses: 25,
            ball: 0.1,
            sleeping: true,
            settle: 120,
        }
    }
}

/// A ball that was shot.
#[derive(Clone, Copy, Debug)]
struct Ball {
    entity: Entity,
    /// The frame in which it was shot.
    shot: u64,
}

/// The game of one player.
pub struct WallGame {
    /// The world of the physics.
    pub world: World,
    setup: Setup,
    checksum: Checksum,
    frame: u64,
    /// From the oldest to the newest.
    balls: Vec<Ball>,
}

/// A state of the game: that of drystone, and what the game remembers beside it.
#[derive(Debug, Default)]
pub struct SavedWall {
    snapshot: Snapshot,
    frame: u64,
    balls: Vec<Ball>,
}

impl WallGame {
    /// A new game. All players begin with the same one.
    pub fn new(setup: Setup) -> Self {
        let mut app = App::new();
        app.add_plugins(DrystonePlugins::default());
        let mut world = std::mem::take(app.world_mut());
        // Two games run side by side here. The results are the same on any number of threads.
        world.insert_resource(PhysicsThreads::new(1).expect("one thread can be started"));
        world.resource_mut::<SleepSettings>().enabled = setup.sleeping;
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let wall = Wall {
            length: BRICK.x * f32::from(setup.columns),
            courses: setup.courses.into(),
            ..Wall::new(Bond::Running)
        };
        for brick in wall.blocks().expect("the wall has a valid size") {
            world.spawn(brick.bundle());
        }
        let checksum = Checksum::new(&mut world);
        let mut game = Self {
            world,
            setup,
            checksum,
            frame: 0,
            balls: Vec::new(),
        };
        for _ in 0..setup.settle {
            game.step();
        }
        game
    }

    /// Number of dynamic bodies that are awake, and of all.
    pub fn awake(&mut self) -> [usize; 2] {
        let mut bodies = self.world.query::<(&RigidBody, &Sleeping)>();
        let bodies = bodies.iter(&self.world);
        let dynamic = bodies.filter(|(kind, _)| **kind == RigidBody::Dynamic);
        dynamic.fold([0; 2], |[awake, all], (_, sleeping)| {
            [awake + usize::from(!sleeping.asleep), all + 1]
        })
    }

    fn step(&mut self) {
        drystone::step(&mut self.world, DT).expect("the length of a frame is positive");
    }

    /// Half the length, and the height of the wall as it was built, m.
    fn extents(&self) -> [f32; 2] {
        let Setup {
            columns, courses, ..
        } = self.setup;
        [
            0.5 * BRICK.x * f32::from(columns),
            BRICK.y * f32::from(courses),
        ]
    }

    /// The number of a body that a player spawns in this frame.
    ///
    /// It follows from the inputs alone, so it is the same in the worlds of all players, and the same again after a rollback. The `Entity`
    /// is not: use this number to find the mesh or the sound of a body.
    fn number(&self, player: usize) -> SpawnOrder {
        SpawnOrder(FIRST + self.frame * PLAYERS as u64 + player as u64)
    }

    fn act(&mut self, player: usize, action: Action) {
        match action {
            Action::Lay { column } => self.lay(player, column),
            Action::Shoot { aim } => self.shoot(player, aim),
        }
    }

    fn lay(&mut self, player: usize, column: u8) {
        let [half, height] = self.extents();
        let x = BRICK.x * (0.5 + f32::from(column % self.setup.columns)) - half;
        // Nobody builds that high.
        let above = 2.0 * height + 10.0;
        let ray = Ray3d::new(Vec3::new(x, above, 0.0), Dir3::NEG_Y);
        let hit = spatial_query(&mut self.world, |query| {
            query.cast_ray(ray, above, &QueryFilter::default())
        });
        let support = hit
            .expect("the ray is valid")
            .map_or(0.0, |hit| hit.point.y);
        let at = Vec3::new(x, support + 0.5 * BRICK.y + DROP, 0.0);
        self.world.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(BRICK.x, BRICK.y, BRICK.z),
            Transform::from_translation(at),
            self.number(player),
        ));
    }

    fn shoot(&mut self, player: usize, aim: [i8; 2]) {
        let [half, height] = self.extents();
        let [x, y] = aim.map(|aim| f32::from(aim) / 127.0);
        let target = Vec3::new(x * half, (0.5 + 0.5 * y) * height, 0.0);
        let side = if player == 0 { 1.0 } else { -1.0 };
        let from = Vec3::new(0.5 * target.x, 0.5 * height + 1.0, side * DISTANCE);
        let ball = (
            RigidBody::Dynamic,
            Collider::ball(self.setup.ball),
            Transform::from_translation(from),
            Velocity::linear(SPEED * (target - from).normalize()),
            self.number(player),
        );
        let entity = self.world.spawn(ball).id();
        let shot = self.frame;
        self.balls.push(Ball { entity, shot });
    }

    /// Despawns old balls.
    fn clear(&mut self) {
        let is_old = |ball: &Ball| self.frame >= ball.shot + LIFE;
        let old = self.balls.iter().take_while(|ball| is_old(ball)).count();
        for ball in self.balls.drain(..old) {
            self.world.despawn(ball.entity);
        }
    }
}

impl Rollback for WallGame {
    type Saved = SavedWall;

    fn save(&self, to: &mut SavedWall) {
        to.snapshot.take_into(&self.world);
        to.frame = self.frame;
        to.balls.clone_from(&self.balls);
    }

    fn load(&mut self, from: &SavedWall) {
        let renamed = from
            .snapshot
            .restore(&mut self.world)
            .expect("the snapshot is of this world");
        self.frame = from.frame;
        self.balls.clone_from(&from.balls);
        // A ball that was despawned since is another entity now.
        for ball in &mut self.balls {
            ball.entity = renamed.get(&ball.entity).copied().unwrap_or(ball.entity);
        }
    }

    fn advance(&mut self, inputs: [Input; PLAYERS]) {
        self.clear();
        // In the order of the players, whoever sits at this computer.
        for (player, input) in inputs.into_iter().enumerate() {
            if let Some(action) = input.action() {
                self.act(player, action);
            }
        }
        self.step();
        self.frame += 1;
    }

    fn checksum(&mut self) -> u64 {
        self.checksum.of(&self.world)
    }
}
