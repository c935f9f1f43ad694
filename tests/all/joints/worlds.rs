//! Copies continue to the same bits; the result does not depend on threads or other entities; previews copy joints; clones refer to clones.

use super::{body, chain};
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use support::Lab;
use support::copy::copy_state;

/// A chain that swings into a stack of bricks, a rope, a motor and a spring, all kicked.
fn scene(lab: &mut Lab) -> Vec<Entity> {
    lab.ground();
    let (links, joints) = chain(lab, 6, 2.0, Vec3::new(0.0, 3.5, 0.0));
    lab.world
        .entity_mut(joints[3])
        .insert(BreakForce::new(60.0));
    lab.set_velocity(links[5], Vec3::new(4.0, 0.0, 1.0), Vec3::ZERO);
    let bricks = [0.25, 0.75, 1.25].map(|y| {
        let brick = Collider::cuboid(1.0, 0.5, 0.5);
        body(lab, brick, 50.0, Vec3::new(1.5, y, 0.0))
    });
    let wheel = body(
        lab,
        Collider::cylinder(0.4, 0.2),
        5.0,
        Vec3::new(-3.0, 1.0, 0.0),
    );
    lab.spawn(
        RevoluteJoint::new(None, wheel)
            .with_hinge_axis(Vec3::Y)
            .with_motor(JointMotor::velocity(3.0, 5.0)),
    );
    let bob = body(lab, Collider::ball(0.2), 1.0, Vec3::new(-3.0, 2.0, 1.0));
    lab.spawn(
        SpringJoint::new(wheel, bob)
            .with_stiffness(80.0)
            .with_damping(1.0),
    );
    let bucket = body(
        lab,
        Collider::cuboid(0.3, 0.3, 0.3),
        4.0,
        Vec3::new(2.0, 3.0, 0.5),
    );
    lab.spawn(DistanceJoint::new(bricks[2], bucket).with_max_distance(1.0));
    let mut all = links;
    all.extend(bricks);
    all.extend([wheel, bob, bucket]);
    all
}

#[test]
fn a_copy_continues_to_the_same_bits() {
    for steps in [0, 1, 20, 60, 200, 500] {
        for substeps in [1, 2] {
            let mut lab = Lab::new();
            lab.dt = 1.0 / 60.0;
            lab.world.resource_mut::<SolverSettings>().outer_substeps = substeps;
            scene(&mut lab);
            for _ in 0..steps {
                lab.step();
            }
            let mut copy = Lab::new();
            copy.dt = lab.dt;
            copy.spawn(Name::new("junk"));
            chain(&mut copy, 2, 1.0, Vec3::X);
            copy.run(0.1);
            let map: EntityHashMap<Entity> = copy_state(&lab.world, &mut copy.world);
            assert!(map.iter().any(|(from, to)| from != to));
            for step in 0..200 {
                if step == 100 {
                    // Both lose the same joint.
                    let mut joints = lab.world.query_filtered::<Entity, With<SphericalJoint>>();
                    let mut joints: Vec<_> = joints.iter(&lab.world).collect();
                    joints.sort_by_key(|&joint| *lab.world.get::<SpawnOrder>(joint).unwrap());
                    lab.world.despawn(joints[1]);
                    copy.world.despawn(map[&joints[1]]);
                }
                lab.step();
                copy.step();
                assert_eq!(lab.bits(), copy.bits(), "{steps} steps, then {step}");
            }
        }
    }
}

#[test]
fn threads_and_other_entities_change_no_bit() {
    let play = |threads: usize, junk: bool, backwards: bool| {
        let mut lab = Lab::new();
        lab.dt = 1.0 / 60.0;
        lab.world
            .insert_resource(PhysicsThreads::new(threads).unwrap().with_min_items(1));
        if junk {
            for i in 0..37 {
                let junk = lab.spawn(Name::new("junk"));
                if i % 3 == 0 {
                    lab.world.despawn(junk);
                }
            }
        }
        scene(&mut lab);
        if backwards {
            // The joints lie in their tables in another order.
            let mut joints = lab.world.query_filtered::<Entity, With<JointForces>>();
            for joint in joints
                .iter(&lab.world)
                .collect::<Vec<_>>()
                .into_iter()
                .rev()
            {
                lab.world.entity_mut(joint).insert(Name::new("moved"));
            }
        }
        lab.run(3.0);
        lab.bits()
    };
    let expected = play(1, false, false);
    assert_eq!(play(3, false, false), expected);
    assert_eq!(play(2, true, true), expected);
}

#[test]
fn a_preview_copies_joints() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    lab.ground();
    let (links, _) = chain(&mut lab, 4, 2.0, Vec3::Y * 3.0);
    let shelf = body(
        &mut lab,
        Collider::cuboid(1.0, 0.1, 0.5),
        10.0,
        Vec3::new(2.0, 1.0, 0.0),
    );
    lab.spawn(FixedJoint::new(None, shelf));
    let pot = body(
        &mut lab,
        Collider::cuboid(0.2, 0.2, 0.2),
        1.0,
        Vec3::new(2.0, 1.15, 0.0),
    );
    lab.run(2.0);
    // Nothing falls when the pot is taken away, nor the chain when its lowest link is.
    for taken in [pot, links[3]] {
        let preview = preview(&lab.world, &Edit::Remove(vec![taken])).unwrap();
        assert_eq!(preview.moved, []);
        assert!(preview.at_rest);
    }
    let falls = |taken: Entity| {
        let preview = preview(&lab.world, &Edit::Remove(vec![taken])).unwrap();
        preview
            .moved
            .iter()
            .map(|moved| moved.body)
            .collect::<Vec<_>>()
    };
    assert_eq!(falls(links[1]), links[2..]);
    assert_eq!(falls(shelf), [pot]);
}

#[test]
fn a_clone_of_a_jointed_pair_is_joined_to_its_own() {
    use bevy_ecs::entity::{EntityCloner, SceneEntityMapper};
    let mut lab = Lab::shipped(1.0 / 60.0);
    let (links, joints) = chain(&mut lab, 2, 1.0, Vec3::Y * 3.0);
    lab.run(0.5);
    let mut map = EntityHashMap::<Entity>::default();
    for &original in links.iter().chain(&joints) {
        let copy = lab.world.spawn_empty().id();
        map.insert(original, copy);
    }
    for (&original, &copy) in &map.clone() {
        EntityCloner::build_opt_out(&mut lab.world).clone_entity(original, copy);
    }
    let world = &mut lab.world;
    SceneEntityMapper::world_scope(&mut map, world, |world, mapper| {
        for joint in &joints {
            let copy = mapper.get_mapped_of(*joint);
            let mut of = world.get::<SphericalJoint>(copy).unwrap().clone();
            SphericalJoint::map_entities(&mut of, mapper);
            world.entity_mut(copy).insert(of);
        }
    });
    let second = lab.world.get::<SphericalJoint>(map[&joints[1]]).unwrap();
    assert_eq!(
        (second.body1, second.body2),
        (Some(map[&links[0]]), Some(map[&links[1]]))
    );
    lab.run(0.5);
    assert!(lab.position(map[&links[1]]).y > 2.0);
}

trait Mapped {
    fn get_mapped_of(&mut self, entity: Entity) -> Entity;
}

impl Mapped for bevy_ecs::entity::SceneEntityMapper<'_> {
    fn get_mapped_of(&mut self, entity: Entity) -> Entity {
        use bevy_ecs::entity::EntityMapper;
        self.get_mapped(entity)
    }
}
