//! The scenes, laid by `drystone::masonry`.

use crate::camera::View;
use crate::edits;
use crate::journal::{Entry, Journal};
use crate::look::Finish;
use crate::pieces::{Piece, Shape};
use crate::replay::Timeline;
use bevy::prelude::*;
use clap::ValueEnum;
use drystone::body::MassProperties;
use drystone::masonry::{
    Arch, BRICK, Block, Bond, CardHouse, Corner, Dome, MasonryError, Opening, Pyramid, Tower, Wall,
};
use drystone::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Opens a [`Scene`] when one is asked for.
pub struct GalleryPlugin;

impl Plugin for GalleryPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Scene>()
            .add_systems(
                Update,
                open.run_if(resource_changed::<Scene>)
                    .run_if(not(resource_exists::<Timeline>)),
            )
            .add_systems(FixedUpdate, rope);
    }
}

/// The scenes to choose from. Write the resource to open one.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, ValueEnum)]
pub enum Scene {
    /// A wall with a door and a window under lintels.
    #[default]
    Wall,
    /// Two walls that hold each other.
    Corner,
    /// Fifteen voussoirs.
    Arch,
    /// Six rings of sixteen.
    Dome,
    /// Flat arches side by side between abutments.
    Bridge,
    /// Three levels of leaning cards.
    CardHouse,
    /// Four bricks to a course, round and round.
    Tower,
    /// A row of plates that winds.
    Dominoes,
    /// Cubes.
    Pyramid,
    /// Boxes that fall on each other.
    Heap,
    /// A wall, and a load on a crane.
    WreckingBall,
    /// Three planks to a layer.
    Jenga,
    /// Bare ground, and a few bricks that lie about.
    Yard,
}

impl Scene {
    /// As it is shown.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wall => "Wall",
            Self::Corner => "Corner",
            Self::Arch => "Arch",
            Self::Dome => "Dome",
            Self::Bridge => "Bridge",
            Self::CardHouse => "Card house",
            Self::Tower => "Tower",
            Self::Dominoes => "Dominoes",
            Self::Pyramid => "Pyramid",
            Self::Heap => "Heap",
            Self::WreckingBall => "Wrecking ball",
            Self::Jenga => "Jenga",
            Self::Yard => "Yard",
        }
    }

    /// The structure at the start.
    ///
    /// # Errors
    /// If a scene is badly laid: its lengths do not fit its bond, for instance.
    pub fn pieces(self) -> Result<Vec<(Piece, Pose)>, MasonryError> {
        let blocks = match self {
            Self::Wall => wall(9.0, 9)?,
            Self::Corner => Corner {
                lengths: [5.0, 4.0],
                courses: 7,
                ..default()
            }
            .blocks()?,
            Self::Arch => Arch::default().blocks()?,
            Self::Dome => Dome::default().blocks()?,
            Self::Bridge => return bridge(),
            Self::CardHouse => CardHouse::default().blocks()?,
            Self::Tower => tower(20),
            Self::Dominoes => dominoes(44),
            Self::Pyramid => Pyramid::new(8).blocks()?,
            Self::Heap => heap(160),
            Self::WreckingBall => wall(8.0, 10)?,
            Self::Jenga => Tower::default().blocks()?,
            Self::Yard => yard(),
        };
        let finish = match self {
            Self::Arch | Self::Dome | Self::Pyramid => Finish::Stone,
            Self::CardHouse | Self::Jenga | Self::Dominoes => Finish::Wood,
            _ => Finish::Brick,
        };
        let pieces = blocks.into_iter().filter_map(|block| {
            let (mut piece, pose) = Piece::of_block(block, finish)?;
            // Beams are of stone.
            if let Shape::Box(size) = piece.shape
                && size.max_element() > 1.25
                && finish == Finish::Brick
            {
                piece.finish = Finish::Stone;
            }
            Some((piece, pose))
        });
        Ok(pieces.collect())
    }

    /// From where it is seen.
    pub fn view(self) -> View {
        let (height, distance) = match self {
            Self::Wall | Self::WreckingBall => (2.2, 13.0),
            Self::Corner => (1.6, 14.0),
            Self::Arch => (1.6, 11.0),
            Self::Dome => (1.2, 12.0),
            Self::Bridge => (1.4, 14.0),
            Self::CardHouse => (1.5, 8.5),
            Self::Tower => (5.0, 22.0),
            Self::Dominoes => (0.4, 15.0),
            Self::Pyramid => (3.2, 20.0),
            Self::Heap => (1.6, 14.0),
            Self::Jenga => (1.4, 7.0),
            Self::Yard => (1.2, 11.0),
        };
        View {
            target: Vec3::Y * height,
            distance,
            pitch: match self {
                Self::Dominoes => 0.7,
                Self::Corner | Self::Dome | Self::Yard => 0.45,
                _ => 0.25,
            },
            ..default()
        }
    }
}

/// With a door and a window.
fn wall(length: f32, courses: u32) -> Result<Vec<Block>, MasonryError> {
    Wall {
        length,
        courses,
        openings: vec![
            Opening {
                from: 1.5,
                to: 3.0,
                courses: 0..5,
                bearing: 0.5,
            },
            Opening {
                from: length - 3.5,
                to: length - 2.0,
                courses: 3..6,
                bearing: 0.5,
            },
        ],
        ..Wall::new(Bond::Running)
    }
    .blocks()
}

/// Each course four bricks about a hole, the other way round than the one below.
fn tower(courses: u32) -> Vec<Block> {
    let brick = |course: u32, side: u32| {
        let turn = Quat::from_rotation_y(side as f32 * FRAC_PI_2);
        let mirror = if course.is_multiple_of(2) { 1.0 } else { -1.0 };
        let at = Vec3::new(mirror * 0.5 * BRICK.z, 0.0, 0.5 * BRICK.x);
        Block {
            collider: Collider::cuboid(BRICK.x, BRICK.y, BRICK.z),
            pose: Pose {
                position: turn * at + Vec3::Y * (course as f32 + 0.5) * BRICK.y,
                rotation: turn,
            },
        }
    };
    let courses = (0..courses).flat_map(|course| (0..4).map(move |side| brick(course, side)));
    courses.collect()
}

fn dominoes(count: u32) -> Vec<Block> {
    let plate = |i: u32| {
        let along = (i as f32 - 0.5 * (count - 1) as f32) * 0.42;
        let winds = |x: f32| 1.6 * (0.45 * x).sin();
        let slope = (winds(along + 0.01) - winds(along - 0.01)) / 0.02;
        Block {
            collider: Collider::cuboid(0.16, 1.0, 0.5),
            pose: Pose {
                position: Vec3::new(along, 0.5, winds(along)),
                rotation: Quat::from_rotation_y(-slope.atan()),
            },
        }
    };
    (0..count).map(plate).collect()
}

fn heap(count: u32) -> Vec<Block> {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut between = |low: f32, high: f32| low + (high - low) * rng.f32();
    let boxes = (0..count).map(|i| {
        let [x, z, y] = [i % 4, i / 4 % 4, i / 16].map(|i| i as f32);
        let size = [0.6, 0.4, 0.5].map(|size| size * between(0.7, 1.2));
        let turn = [1.0, 1.0, 1.0].map(|most| between(-most, most));
        Block {
            collider: Collider::cuboid(size[0], size[1], size[2]),
            pose: Pose {
                position: Vec3::new(x - 1.5, 0.6 + 0.8 * y, z - 1.5) * Vec3::new(0.95, 1.0, 0.95),
                rotation: Quat::from_scaled_axis(turn.into()),
            },
        }
    });
    boxes.collect()
}

/// A stack of five, the beginning of a wall, and loose bricks.
fn yard() -> Vec<Block> {
    let brick = |x: f32, y: f32, z: f32| Block {
        collider: Collider::cuboid(BRICK.x, BRICK.y, BRICK.z),
        pose: Pose {
            position: Vec3::new(x, y, z),
            ..default()
        },
    };
    let mut blocks: Vec<Block> = (0..5)
        .map(|i| Block {
            collider: Collider::cuboid(0.8, 0.8, 0.8),
            ..brick(3.0, 0.4 + 0.8 * i as f32, 0.0)
        })
        .collect();
    blocks.extend([-2.5, -1.5, -0.5].map(|x| brick(x, 0.25, 0.0)));
    blocks.extend([-2.0, -1.0].map(|x| brick(x, 0.75, 0.0)));
    blocks.extend([-2.5, 0.0, 1.5].map(|x| brick(x, 0.25, 2.0)));
    blocks
}

/// Three flat arches side by side, between blocks that nothing moves, and a parapet's beginning on top.
fn bridge() -> Result<Vec<(Piece, Pose)>, MasonryError> {
    let arch = Arch {
        radius: 4.0,
        thickness: 0.5,
        depth: 0.7,
        voussoirs: 13,
        angle: 1.9,
        gap: 0.0,
    };
    let first = 0.5 * (PI - arch.angle);
    // The ring's middle lies below the ground; its springings a little above.
    let down = arch.radius * first.sin() - 0.9;
    let mut pieces = Vec::new();
    for row in [-1.0f32, 0.0, 1.0] {
        let frame = Pose {
            position: Vec3::new(0.0, -down, row * arch.depth),
            ..default()
        };
        let blocks = arch.blocks()?.into_iter().map(|block| block.moved(&frame));
        pieces.extend(blocks.filter_map(|block| Piece::of_block(block, Finish::Stone)));
    }
    for side in [-1.0f32, 1.0] {
        // A block whose upper side is the springing.
        let size = Vec3::new(1.6, 1.6, 3.0 * arch.depth + 0.4);
        let turn = Quat::from_rotation_z(side * (first));
        let springing = turn * Vec3::X * side * arch.radius - Vec3::Y * down;
        let piece = Piece {
            fixed: true,
            ..Piece::new(Shape::Box(size), Finish::Stone)
        };
        let pose = Pose {
            position: springing - turn * Vec3::Y * 0.5 * size.y,
            rotation: turn,
        };
        pieces.push((piece, pose));
    }
    Ok(pieces)
}

/// A body on a rope that only pulls.
#[derive(Component, Clone, Copy, Debug)]
#[require(ExternalForce)]
pub struct Rope {
    /// Where it hangs, m.
    pub from: Vec3,
    /// m
    pub length: f32,
}

/// Held aside, and let go.
fn wrecking_ball() -> (Piece, Pose, Rope) {
    let rope = Rope {
        from: Vec3::Y * 9.0,
        length: 6.4,
    };
    let (sin, cos) = 1.14f32.sin_cos();
    let pose = Pose {
        position: rope.from + rope.length * Vec3::new(0.0, -cos, sin),
        ..default()
    };
    let ball = Piece::new(Shape::Ball(0.55), Finish::Iron);
    (ball, pose, rope)
}

/// The point from which they hang.
pub fn draw_ropes(mut gizmos: Gizmos, bodies: Query<(&Rope, &Transform)>) {
    for (rope, at) in &bodies {
        gizmos.line(rope.from, at.translation, Color::srgb(0.15, 0.15, 0.17));
    }
}

/// A spring as stiff as a step of this length allows, with damping along the rope.
fn rope(
    time: Res<Time>,
    mut bodies: Query<(&Rope, &Pose, &Velocity, &MassProperties, &mut ExternalForce)>,
) {
    let dt = time.delta_secs().max(1e-3);
    for (rope, pose, velocity, mass, mut force) in &mut bodies {
        // Before the first step its pose and mass are unknown.
        if mass.inverse_mass == 0.0 {
            continue;
        }
        let way = rope.from - pose.position;
        let stretch = way.length() - rope.length;
        let along = way.normalize_or(Vec3::Y);
        let mass = 1.0 / mass.inverse_mass;
        let pull = 0.2 * mass / (dt * dt) * stretch - 0.4 * mass / dt * velocity.linear.dot(along);
        let pull = if stretch > 0.0 { pull.max(0.0) } else { 0.0 };
        force.set_if_neq(ExternalForce {
            force: along * pull,
            ..default()
        });
    }
}

/// Removes the current scene, and lays the new one.
fn open(world: &mut World) -> Result {
    let scene = *world.resource::<Scene>();
    edits::clear(world);
    let pieces = scene.pieces()?;
    let count = pieces.len();
    for (piece, pose) in pieces {
        world.spawn(piece.bundle(pose)?);
    }
    if scene == Scene::WreckingBall {
        let (ball, pose, rope) = wrecking_ball();
        world.spawn((ball.bundle(pose)?, rope));
    }
    world.insert_resource(scene.view());
    world.resource::<Journal>().say(&Entry::Opened {
        scene: format!("{scene:?}"),
        pieces: count,
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Clock;
    use crate::compare::Comparison;
    use bevy::time::{TimePlugin, TimeUpdateStrategy};
    use drystone::masonry::EditLog;

    /// Every scene can be laid, and bodies that should not move do not move in three seconds.
    #[test]
    fn scenes_stand() {
        for &scene in Scene::value_variants() {
            let mut app = App::new();
            app.add_plugins(DrystonePlugins::default());
            let world = app.world_mut();
            world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
            let pieces = scene.pieces().unwrap();
            let spawn = |(piece, pose): (Piece, Pose)| {
                (world.spawn(piece.bundle(pose).unwrap()).id(), pose)
            };
            let bodies: Vec<_> = pieces.into_iter().map(spawn).collect();
            for _ in 0..180 {
                drystone::step(world, 1.0 / 60.0).unwrap();
            }
            for (body, from) in bodies {
                let to = world.get::<Pose>(body).unwrap();
                let went = to.position.distance(from.position);
                let may = scene == Scene::Heap;
                assert!(may || went < 0.01, "{scene:?}: {body} went {went} m");
            }
        }
    }

    /// It swings on its rope, and is in the wall after a quarter of a period; nothing moves before.
    #[test]
    fn the_wrecking_ball_swings_into_the_wall() {
        let mut app = App::new();
        app.add_plugins((TimePlugin, DrystonePlugins::default(), GalleryPlugin))
            .insert_resource(Scene::WreckingBall)
            .insert_resource(TimeUpdateStrategy::ManualDuration(
                Time::<Fixed>::default().timestep(),
            ))
            .init_resource::<EditLog>()
            .init_resource::<edits::Edits>()
            .init_resource::<Clock>()
            .init_resource::<Journal>()
            .init_resource::<Comparison>();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let mut bricks = world.query_filtered::<&Velocity, Without<Rope>>();
        let mut balls = world.query::<(&Rope, &Pose)>();
        let mut hit = None;
        for frame in 0..150 {
            app.update();
            let (rope, pose) = balls.single(app.world()).unwrap();
            let far = pose.position.distance(rope.from);
            assert!(frame < 2 || (far - rope.length).abs() < 0.6, "{far} m");
            let velocities = bricks.iter(app.world());
            let fastest = velocities.map(|v| v.linear.length()).fold(0.0, f32::max);
            assert!(fastest < 30.0, "{fastest} m/s");
            if hit.is_none() && fastest > 0.5 {
                hit = Some(frame);
                assert!(pose.position.z < 1.2, "{pose:?}");
            }
        }
        // 5 s for small swings, longer for wide ones.
        assert!(
            hit.is_some_and(|frame| (60..100).contains(&frame)),
            "{hit:?}"
        );
    }
}
