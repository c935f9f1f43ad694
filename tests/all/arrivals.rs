//! Bodies that are spawned asleep by the thousand are as those that are spawned asleep one by one.

use crate::streaming::{asleep_and_awake_alike, sleeps};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{BodyIndex, Inactive};
use drystone::masonry::{Arch, Block, Bond, Dome, Pyramid, Wall};
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use drystone::streaming::spawn_asleep;
use drystone_lab::play::Player;
use support::Lab;

const ASLEEP: Sleeping = Sleeping {
    asleep: true,
    still_for: 0.0,
    allowed: true,
};

/// A world on a ground, before its first step.
fn ground() -> Lab {
    let mut lab = Lab::new();
    lab.ground();
    lab
}

/// Spawns blocks asleep, all at once or one by one.
fn spawn(lab: &mut Lab, blocks: &[Block], at_once: bool) -> Vec<Entity> {
    let bundles = blocks.iter().map(|block| {
        let block = block.clone();
        (block.bundle(), Load::default())
    });
    if at_once {
        return spawn_asleep(&mut lab.world, bundles);
    }
    bundles
        .map(|bundle| lab.world.spawn((bundle, ASLEEP)).id())
        .collect()
}

fn moved(blocks: Vec<Block>, x: f32, z: f32) -> impl Iterator<Item = Block> {
    let place = Pose {
        position: Vec3::new(x, 0.0, z),
        ..Pose::default()
    };
    blocks.into_iter().map(move |block| block.moved(&place))
}

/// Walls in several bonds, an arch, a pyramid and a dome.
fn town() -> Vec<Block> {
    let mut blocks = Vec::new();
    for (i, bond) in [Bond::Running, Bond::Flemish, Bond::English]
        .into_iter()
        .enumerate()
    {
        let wall = Wall {
            courses: 5 + i as u32,
            ..Wall::new(bond)
        };
        blocks.extend(moved(wall.blocks().unwrap(), 0.0, 5.0 * i as f32));
    }
    blocks.extend(moved(Arch::default().blocks().unwrap(), 20.0, 0.0));
    blocks.extend(moved(Pyramid::new(6).blocks().unwrap(), 20.0, 5.0));
    blocks.extend(moved(Dome::default().blocks().unwrap(), 40.0, 0.0));
    blocks
}

#[test]
fn a_town_is_as_if_it_was_spawned_one_by_one() {
    let blocks = town();
    let [mut at_once, mut one_by_one] = [ground(), ground()];
    let bodies = spawn(&mut at_once, &blocks, true);
    assert_eq!(bodies, spawn(&mut one_by_one, &blocks, false));
    at_once.step();
    one_by_one.step();
    for &body in &bodies {
        assert!(at_once.world.get::<Inactive>(body).is_some());
        assert!(at_once.world.get::<Load>(body).unwrap().normal_force > 0.0);
    }
    asleep_and_awake_alike(&mut at_once, &mut one_by_one, &bodies);
}

#[test]
fn it_is_the_same_on_any_number_of_threads() {
    let blocks = town();
    let mut labs = [1, 4].map(|threads| {
        let mut lab = ground();
        let threads = PhysicsThreads::new(threads).unwrap().with_min_items(2);
        lab.world.insert_resource(threads);
        lab
    });
    let bodies = labs.each_mut().map(|lab| spawn(lab, &blocks, true));
    let [one, four] = &mut labs;
    asleep_and_awake_alike(one, four, &bodies[0]);
}

/// The search for written components passes over bodies that arrive, which all have new change ticks.
#[test]
fn writes_while_others_arrive_are_noticed() {
    let mut lab = ground();
    let wall = Wall::new(Bond::Running).blocks().unwrap();
    let bodies = spawn(&mut lab, &wall, true);
    lab.run(0.1);
    let top = bodies[bodies.len() - 1];
    lab.world.get_mut::<Velocity>(top).unwrap().linear = Vec3::X;
    let moved_wall: Vec<Block> = moved(wall, 0.0, 7.0).collect();
    let others = spawn(&mut lab, &moved_wall, true);
    let pushed = bodies[bodies.len() - 3];
    let place = lab.world.get::<Transform>(pushed).unwrap().translation;
    lab.world.get_mut::<Transform>(pushed).unwrap().translation += 0.01 * Vec3::Z;
    lab.step();
    assert!(!sleeps(&lab, top) && !sleeps(&lab, pushed));
    let now = lab.world.get::<Pose>(pushed).unwrap().position;
    assert!((now - place).z > 0.005, "{now} instead of {place}");
    assert!(others.iter().all(|&body| sleeps(&lab, body)));
}

#[test]
fn a_second_town_joins_the_first() {
    // One of its walls stands on a wall that is there already, and another beside it.
    let wall = |at: Vec3| {
        let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
        let place = Pose {
            position: at,
            ..Pose::default()
        };
        blocks.map(move |block| block.moved(&place))
    };
    let height = {
        let blocks = Wall::new(Bond::Running).blocks().unwrap();
        blocks
            .iter()
            .map(|block| block.pose.position.y + 0.25)
            .fold(0.0, f32::max)
    };
    let first: Vec<Block> = wall(Vec3::ZERO).collect();
    let second: Vec<Block> = wall(height * Vec3::Y).chain(wall(7.0 * Vec3::Z)).collect();
    let build = |at_once: bool| {
        let mut lab = ground();
        let mut bodies = spawn(&mut lab, &first, at_once);
        lab.run(0.1);
        bodies.extend(spawn(&mut lab, &second, at_once));
        lab.run(0.1);
        (lab, bodies)
    };
    let [mut at_once, mut one_by_one] = [build(true), build(false)];
    // The entities differ, because pairs have been spawned in between.
    let loads = |(lab, bodies): &(Lab, Vec<Entity>)| -> Vec<(bool, Load)> {
        let load = |&body: &Entity| (sleeps(lab, body), *lab.world.get::<Load>(body).unwrap());
        bodies.iter().map(load).collect()
    };
    assert_eq!(loads(&at_once), loads(&one_by_one));
    assert!(
        loads(&at_once)
            .iter()
            .all(|(asleep, load)| *asleep && load.normal_force > 0.0)
    );
    for (lab, bodies) in [&mut at_once, &mut one_by_one] {
        for &body in &*bodies {
            lab.world.get_mut::<Sleeping>(body).unwrap().wake();
        }
    }
    for step in 0..120 {
        at_once.0.step();
        one_by_one.0.step();
        assert_eq!(at_once.0.bits(), one_by_one.0.bits(), "step {step}");
    }
}

#[test]
fn special_bodies_are_left_to_the_stages() {
    let brick = |x: f32, y: f32| {
        (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.5, 0.5),
            Transform::from_xyz(x, y, 0.0),
        )
    };
    let build = |lab: &mut Lab, at_once: bool| -> Vec<Entity> {
        let mut bodies = Vec::new();
        let mut add = |lab: &mut Lab, x: f32, upper: fn(&mut EntityWorldMut)| {
            let two = [brick(x, 0.25), brick(x, 0.75)];
            let two: Vec<Entity> = match at_once {
                true => spawn_asleep(&mut lab.world, two),
                false => { two.into_iter() }
                    .map(|brick| lab.world.spawn((brick, ASLEEP)).id())
                    .collect(),
            };
            upper(&mut lab.world.entity_mut(two[1]));
            bodies.extend(two);
        };
        add(lab, 0.0, |_| ());
        add(lab, 3.0, |brick| _ = brick.insert(ContactEvents));
        add(lab, 6.0, |brick| {
            _ = brick.insert(ExternalImpulse {
                linear: Vec3::Y,
                ..Default::default()
            })
        });
        add(lab, 9.0, |brick| _ = brick.insert(Mortar::default()));
        add(lab, 12.0, |brick| {
            _ = brick.insert(SurfaceVelocity::default())
        });
        add(lab, 15.0, |brick| _ = brick.insert(Watch::default()));
        add(lab, 18.0, |brick| {
            let body = brick.id();
            brick.world_scope(|world| _ = world.spawn(FixedJoint::new(body, None)));
        });
        add(lab, 21.0, |brick| {
            brick.with_child((Collider::ball(0.1), Transform::from_xyz(0.0, 0.5, 0.0)));
        });
        add(lab, 24.0, |brick| _ = brick.insert(Density(f32::NAN)));
        add(lab, 27.0, |brick| _ = brick.insert(Sleeping::default()));
        add(lab, 30.0, |brick| _ = brick.insert(RigidBody::Kinematic));
        add(lab, 33.0, |brick| brick.world_scope(|_| ()));
        let last = *bodies.last().unwrap();
        lab.world.despawn(last);
        bodies.pop();
        bodies
    };
    let [mut at_once, mut one_by_one] = [ground(), ground()];
    let bodies = build(&mut at_once, true);
    assert_eq!(build(&mut one_by_one, false), bodies);
    for step in 0..180 {
        at_once.step();
        one_by_one.step();
        assert_eq!(at_once.bits(), one_by_one.bits(), "step {step}");
        for &body in &bodies {
            let both = [&at_once, &one_by_one].map(|lab| sleeps(lab, body));
            assert_eq!(both[0], both[1], "{body}, step {step}");
        }
        assert_eq!(at_once.errors(), one_by_one.errors());
    }
}

#[test]
fn an_awake_body_wakes_what_is_put_under_it() {
    let [mut at_once, mut one_by_one] = [ground(), ground()];
    let blocks = Wall::new(Bond::Running).blocks().unwrap();
    let top = blocks
        .iter()
        .map(|block| block.pose.position.y)
        .fold(0.0, f32::max);
    let mut all = Vec::new();
    for (lab, is_at_once) in [(&mut at_once, true), (&mut one_by_one, false)] {
        let ball = lab.body(Collider::ball(0.25), Vec3::new(0.0, top + 0.52, 0.0));
        lab.step();
        all = spawn(lab, &blocks, is_at_once);
        all.push(ball);
    }
    for _ in 0..120 {
        at_once.step();
        one_by_one.step();
        assert_eq!(at_once.bits(), one_by_one.bits());
    }
    for &body in &all {
        assert_eq!(sleeps(&at_once, body), sleeps(&one_by_one, body));
    }
}

#[test]
fn queries_see_them_after_a_refresh() {
    let mut lab = ground();
    lab.step();
    let blocks = Wall::new(Bond::Running).blocks().unwrap();
    let bodies = spawn(&mut lab, &blocks, true);
    drystone::refresh(&mut lab.world);
    let at = blocks.last().unwrap().pose.position;
    let ray = Ray3d::new(at + 3.0 * Vec3::Y, Dir3::NEG_Y);
    let hit = |lab: &mut Lab| {
        let hit = spatial_query(&mut lab.world, |query| {
            query.cast_ray(ray, 5.0, &QueryFilter::default())
        });
        hit.unwrap().map(|hit| hit.entity)
    };
    assert_eq!(hit(&mut lab), bodies.last().copied());
    lab.step();
    assert_eq!(hit(&mut lab), bodies.last().copied());
}

#[test]
fn without_plugins_they_are_spawned_asleep() {
    let mut world = World::new();
    let blocks = Wall::new(Bond::Running).blocks().unwrap();
    let bodies = spawn_asleep(&mut world, blocks.into_iter().map(Block::bundle));
    assert!(
        bodies
            .iter()
            .all(|&body| world.get::<Sleeping>(body) == Some(&ASLEEP))
    );
    assert!(
        bodies
            .iter()
            .all(|&body| world.get::<Inactive>(body).is_none())
    );
}

/// A disabled body is no part of the simulation. It must not stay inactive when it is enabled.
#[test]
fn bodies_that_are_disabled_before_they_arrive_come_when_they_are_enabled() {
    let mut lab = ground();
    let cube = |y: f32| {
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
        (RigidBody::Dynamic, cube, Transform::from_xyz(0.0, y, 0.0))
    };
    let spawned = spawn_asleep(&mut lab.world, [0.5, 1.5, 2.5, 3.5].map(cube));
    lab.world.entity_mut(spawned[2]).insert(Disabled);
    lab.world.entity_mut(spawned[3]).insert(RigidBodyDisabled);
    lab.run(0.1);
    lab.world.entity_mut(spawned[2]).remove::<Disabled>();
    lab.world
        .entity_mut(spawned[3])
        .remove::<RigidBodyDisabled>();
    lab.step();
    for &body in &spawned[2..] {
        assert!(!lab.world.entity(body).contains::<Inactive>(), "{body}");
        assert_ne!(*lab.world.get::<BodyIndex>(body).unwrap(), BodyIndex::NONE);
    }
    lab.run(2.0);
    assert!(lab.world.get::<Sleeping>(spawned[3]).unwrap().asleep);
    assert_eq!(lab.position(spawned[3]).y, 3.5);
}

/// A tree of many boxes is kept tight box by box, a small one by refitting it. Nothing at one wall depends on that.
#[test]
fn playing_on_a_wall_is_the_same_in_a_large_town() {
    let courses = 8;
    let wall = Wall {
        length: 10.0,
        courses,
        ..Wall::new(Bond::Running)
    };
    let wall = wall.blocks().unwrap();
    let play = |others: usize| {
        let mut lab = ground();
        let mut blocks = wall.clone();
        for i in 0..others {
            let (x, z) = (50.0 + 20.0 * (i / 10) as f32, 4.0 * (i % 10) as f32);
            blocks.extend(moved(wall.clone(), x, z));
        }
        let bodies = spawn(&mut lab, &blocks, true);
        lab.run(0.1);
        let mut player = Player::new([10, courses], 1);
        let mut awake = 0;
        for step in 0..240 {
            if step % 20 == 0 {
                player.act(&mut lab.world);
            }
            lab.step();
            let mut sleeping = lab.world.query::<&Sleeping>();
            let sleeping = sleeping.iter(&lab.world);
            awake += sleeping.filter(|body| !body.asleep).count();
        }
        assert!(awake > 1_000, "{awake}");
        let bricks = bodies[..wall.len()].iter();
        let poses = bricks.map(|&brick| lab.world.get::<Pose>(brick).copied());
        (blocks.len(), poses.collect::<Vec<_>>())
    };
    let ((_, alone), (count, in_town)) = (play(0), play(110));
    assert!(count > 9_000, "{count}");
    assert_eq!(alone, in_town);
}
