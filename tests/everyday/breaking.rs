//! Overloaded structures tear where they are loaded most.

use super::*;
use bevy_ecs::message::Messages;

/// The joints that break within a second, in the order of breaking.
fn broken(world: &mut World, dt: f32) -> Vec<Entity> {
    let mut found = Vec::new();
    for _ in 0..(1.0 / dt) as usize {
        steps_of(world, 1, dt);
        let mut broke = world.resource_mut::<Messages<JointBroke>>();
        found.extend(broke.drain().map(|broke| broke.joint));
    }
    found
}

/// A chain of ten links that hangs from the world, with 100 kg at its end. Its joints break at 3 kN. Returns the joints from above, and the
/// load.
fn chain(world: &mut World, links: usize) -> (Vec<Entity>, Entity) {
    let mut above: Option<Entity> = None;
    let mut joints = Vec::new();
    let mut hang = |world: &mut World, above: Option<Entity>, y: f32, shape: f32, mass: f32| {
        let body = world
            .spawn((
                RigidBody::Dynamic,
                Collider::ball(shape),
                Mass(mass),
                at(0.0, y - 0.15, 0.0),
            ))
            .id();
        let joint = SphericalJoint::new(above, body).with_anchor(Vec3::new(0.0, y, 0.0));
        joints.push(world.spawn((joint, BreakForce::new(3000.0))).id());
        Some(body)
    };
    for i in 0..links {
        above = hang(world, above, 9.0 - 0.3 * i as f32, 0.05, 1.0);
    }
    let load = hang(world, above, 9.0 - 0.3 * links as f32, 0.1, 100.0).unwrap();
    (joints, load)
}

#[test]
fn an_overloaded_chain_tears_at_its_top() {
    for (links, dt) in [
        (10, 1.0 / 60.0),
        (10, 1.0 / 240.0),
        (10, 0.1),
        (25, 1.0 / 60.0),
    ] {
        let mut app = app();
        let world = app.world_mut();
        let (joints, load) = chain(world, links);
        steps_of(world, 60, dt);
        world.entity_mut(load).insert(ExternalForce {
            force: Vec3::NEG_Y * 4000.0,
            ..Default::default()
        });
        assert_eq!(broken(world, dt), [joints[0]], "{links} links, {dt} s");
    }
}

/// A weak link in the middle tears, and the others hold.
#[test]
fn a_chain_tears_at_its_weakest_link() {
    for dt in [1.0 / 60.0, 1.0 / 240.0, 0.1] {
        let mut app = app();
        let world = app.world_mut();
        let (joints, load) = chain(world, 10);
        world.entity_mut(joints[6]).insert(BreakForce::new(1500.0));
        steps_of(world, 60, dt);
        world.entity_mut(load).insert(ExternalForce {
            force: Vec3::NEG_Y * 4000.0,
            ..Default::default()
        });
        assert_eq!(broken(world, dt), [joints[6]], "{dt} s");
    }
}

/// A bridge of planks between two walls is pulled down in its middle. Nearly flat it is overloaded; its halves bear the load once it has
/// torn.
#[test]
fn an_overloaded_bridge_tears_once() {
    let mut app = app();
    let world = app.world_mut();
    let mut planks: Vec<Option<Entity>> = vec![None];
    for i in 0..12 {
        let plank = (
            RigidBody::Dynamic,
            Collider::cuboid(0.5, 0.1, 1.0),
            Mass(10.0),
            at(0.5 * i as f32, 5.0, 0.0),
        );
        planks.push(Some(world.spawn(plank).id()));
    }
    planks.push(None);
    for (i, pair) in planks.windows(2).enumerate() {
        let anchor = Vec3::new(0.5 * i as f32 - 0.25, 5.0, 0.0);
        let (one, other) = match pair {
            [one, Some(other)] => (*one, *other),
            [Some(one), None] => (None, *one),
            _ => unreachable!("there are planks between the walls"),
        };
        let hinge = RevoluteJoint::new(one, other)
            .with_anchor(anchor)
            .with_hinge_axis(Vec3::Z);
        world.spawn((hinge, BreakForce::new(20_000.0)));
    }
    steps(world, 120);
    world.entity_mut(planks[6].unwrap()).insert(ExternalForce {
        force: Vec3::NEG_Y * 3000.0,
        ..Default::default()
    });
    let broken = broken(world, DT).len();
    assert_eq!(broken, 1);
}
