//! One message for each collapse, with who gave way first, and how.

use bevy_app::App;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{Mass, RigidBody, Sleeping};
use drystone::collapse::{Collapse, CollapseEnded, CollapsePlugin, FailureMode, Watch};
use drystone::collider::{Collider, Friction};
use drystone::grab::Grab;
use drystone::masonry::{Bond, Wall};
use drystone::mortar::{Mortar, MortarFailure};
use drystone::settings::{Gravity, SleepSettings};
use glam::Vec3;
use support::*;

/// A world with ground, in which collapses are told.
fn site(sleeps: bool) -> Lab {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), CollapsePlugin));
    let mut world = std::mem::take(app.world_mut());
    world.resource_mut::<SleepSettings>().enabled = sleeps;
    let mut lab = Lab {
        world,
        dt: 1.0 / 60.0,
    };
    lab.ground();
    lab
}

fn watch(lab: &mut Lab, body: Entity) -> Entity {
    lab.world.entity_mut(body).insert(Watch::default());
    body
}

fn wall(lab: &mut Lab) -> Vec<Entity> {
    let bricks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
    let bricks: Vec<Entity> = bricks
        .map(|brick| lab.spawn((brick.bundle(), Watch::default())))
        .collect();
    lab.run(1.0);
    bricks
}

/// Runs, and what is told in the meantime.
fn told(lab: &mut Lab, seconds: f32) -> Vec<Collapse> {
    let mut told = Vec::new();
    for _ in 0..(seconds / lab.dt).round() as usize {
        lab.step();
        told.extend(lab.world.resource_mut::<Messages<Collapse>>().drain());
    }
    told
}

fn ends(lab: &mut Lab) -> Vec<CollapseEnded> {
    let mut ended = lab.world.resource_mut::<Messages<CollapseEnded>>();
    ended.drain().collect()
}

fn ways(told: &[Collapse]) -> Vec<(Entity, FailureMode)> {
    told.iter().map(|one| (one.first, one.how)).collect()
}

#[test]
fn a_wall_that_loses_its_corner_is_told_of_once() {
    for sleeps in [true, false] {
        let mut lab = site(sleeps);
        let bricks = wall(&mut lab);
        assert_eq!(told(&mut lab, 2.0), []);
        lab.world.despawn(bricks[0]);
        let all = told(&mut lab, 4.0);
        assert_eq!(all.len(), 1, "{all:?}");
        assert!([bricks[5], bricks[6]].contains(&all[0].first));
        assert!(matches!(
            all[0].how,
            FailureMode::Fell | FailureMode::Tipped
        ));
        assert_eq!(all[0].mortar, None);
        assert!(all[0].rest.len() > 20 && !all[0].rest.contains(&all[0].first));
        // The remaining structure stands again, and if it falls later this is another collapse.
        let standing = |lab: &Lab, i: usize| (lab.position(bricks[i]).y - 0.25).abs() < 0.01;
        assert!(standing(&lab, 4));
        lab.world.despawn(bricks[4]);
        assert_eq!(told(&mut lab, 4.0).len(), 1);
    }
}

/// A cantilever out of a wall breaks at its root under a brick.
#[test]
fn the_bond_that_broke_first_is_told_of() {
    for sleeps in [true, false] {
        let mut lab = site(sleeps);
        let cube = || Collider::cuboid(0.5, 0.5, 0.5);
        let at = |x: f32, y: f32| Transform::from_xyz(x, y, 0.0);
        let root = lab.spawn((RigidBody::Static, cube(), at(0.0, 3.0)));
        let bricks = [0.5, 1.0].map(|x| {
            let brick = (RigidBody::Dynamic, cube(), Mass(125.0), at(x, 3.0));
            lab.spawn((brick, Mortar::default(), Watch::default()))
        });
        assert_eq!(told(&mut lab, 2.0), []);
        lab.spawn((RigidBody::Dynamic, cube(), Mass(250.0), at(1.0, 3.501)));
        let all = told(&mut lab, 2.0);
        assert_eq!(all.len(), 1, "{all:?}");
        let mortar = all[0].mortar.expect("a bond broke");
        assert_eq!([mortar.body, mortar.other], [root, bricks[0]]);
        assert_eq!(mortar.how, MortarFailure::Tension);
        assert!(bricks.contains(&all[0].first) && all[0].bodies == 2);
    }
}

#[test]
fn how_it_gave_way_is_told() {
    // Gravity is tilted by a degree a second. The low structure slides at 16.7°, and the high one tips at 11.3°.
    for (cubes, friction, how) in [(1, 0.3, FailureMode::Slid), (5, 0.8, FailureMode::Tipped)] {
        let mut lab = site(true);
        let stack: Vec<Entity> = (0..cubes)
            .map(|i| {
                let cube = lab.cube(Vec3::Y * (i as f32 + 0.5));
                lab.world.entity_mut(cube).insert(Friction::new(friction));
                watch(&mut lab, cube)
            })
            .collect();
        lab.run(1.0);
        let mut all = Vec::new();
        for step in 0..1800 {
            let angle = (step as f32 / 60.0).to_radians();
            let down = Vec3::new(angle.sin(), -angle.cos(), 0.0);
            lab.world.insert_resource(Gravity(G * down));
            all.extend(told(&mut lab, 1.0 / 60.0));
            if !all.is_empty() {
                break;
            }
        }
        let found = ways(&all);
        assert!(stack.contains(&found[0].0));
        // The top of what tips goes farthest aside.
        let expected: &[FailureMode] = match how {
            FailureMode::Tipped => &[FailureMode::Tipped, FailureMode::Slid],
            _ => &[how],
        };
        assert!(expected.contains(&found[0].1), "{found:?}");
    }
}

#[test]
fn a_collapse_names_the_brick_that_was_pulled() {
    let mut lab = site(true);
    let base = lab.cube(Vec3::Y * 0.5);
    let pillar = lab.body(Collider::cuboid(0.3, 1.0, 0.3), Vec3::Y * 1.5);
    let top = lab.cube(Vec3::Y * 2.5);
    for body in [base, pillar, top] {
        watch(&mut lab, body);
    }
    lab.run(1.0);
    let grab = Grab {
        max_force: 1e5,
        max_speed: 8.0,
        ..Grab::gentle(90.0, Vec3::ZERO, Vec3::new(4.0, 1.5, 0.0))
    };
    lab.world.entity_mut(pillar).insert(grab);
    let all = told(&mut lab, 3.0);
    assert_eq!(ways(&all), [(pillar, FailureMode::Pulled)]);
}

#[test]
fn building_and_taking_off_is_no_collapse() {
    let mut lab = site(true);
    let bricks = wall(&mut lab);
    let top = *bricks.last().unwrap();
    let mass = lab.mass(top).mass();
    let at = lab.position(top);
    for target in [
        at + Vec3::Y,
        at + Vec3::new(0.0, 1.0, 3.0),
        at + Vec3::Y,
        at,
    ] {
        lab.world
            .entity_mut(top)
            .insert(Grab::gentle(mass, Vec3::ZERO, target));
        assert_eq!(told(&mut lab, 1.0), []);
    }
    lab.world.entity_mut(top).remove::<Grab>();
    assert_eq!(told(&mut lab, 2.0), []);
    // Another on top.
    let brick = Collider::cuboid(1.0, 0.5, 0.5);
    let laid = lab.body(brick, Vec3::new(0.0, 3.25, 0.0));
    watch(&mut lab, laid);
    assert_eq!(told(&mut lab, 2.0), []);
    // A body that is dropped beside it stands as a structure of its own.
    let beside = lab.cube(Vec3::new(0.0, 2.0, 5.0));
    watch(&mut lab, beside);
    assert_eq!(told(&mut lab, 2.0), []);
    lab.set_velocity(beside, Vec3::X * 3.0, Vec3::ZERO);
    let all = told(&mut lab, 2.0);
    assert_eq!(ways(&all), [(beside, FailureMode::Slid)]);
    assert_eq!(all[0].rest, []);
}

#[test]
fn overloaded_bodies_are_crushed() {
    let mut lab = site(true);
    let under = lab.cube(Vec3::Y * 0.5);
    let weak = Watch { strength: 30_000.0 };
    lab.world.entity_mut(under).insert(weak);
    let lies = lab.cube(Vec3::Y * 1.5);
    watch(&mut lab, lies);
    assert_eq!(told(&mut lab, 2.0), []);
    // Its own weight, the other's and this make 39 kN.
    let load = lab.cube(Vec3::Y * 2.5);
    lab.world.entity_mut(load).insert(Mass(2000.0));
    assert_eq!(ways(&told(&mut lab, 2.0)), [(under, FailureMode::Crushed)]);
}

#[test]
fn bodies_put_elsewhere_or_held_stood_nowhere() {
    let mut lab = site(true);
    let bricks = wall(&mut lab);
    let lies = lab.cube(Vec3::new(0.0, 0.5, 5.0));
    watch(&mut lab, lies);
    assert_eq!(told(&mut lab, 1.0), []);
    // The user places it beside the wall, and then the brick on top beside it.
    let top = *bricks.last().unwrap();
    for (body, place) in [
        (lies, Vec3::new(4.0, 0.5, 0.0)),
        (top, Vec3::new(6.0, 0.25, 0.0)),
    ] {
        let mut body = lab.world.entity_mut(body);
        body.get_mut::<Transform>().unwrap().translation = place;
    }
    assert_eq!(told(&mut lab, 1.0), []);
    // A grab holds it in the air for a while, and releases it.
    let mass = lab.mass(lies).mass();
    let grab = Grab::gentle(mass, Vec3::ZERO, Vec3::new(4.0, 2.0, 3.0));
    lab.world.entity_mut(lies).insert(grab);
    assert_eq!(told(&mut lab, 3.0), []);
    lab.world.entity_mut(lies).remove::<Grab>();
    assert_eq!(told(&mut lab, 2.0), []);
    // It stands again at its new place.
    lab.set_velocity(lies, Vec3::X * 3.0, Vec3::ZERO);
    assert_eq!(ways(&told(&mut lab, 2.0)), [(lies, FailureMode::Slid)]);
}

#[test]
fn a_strength_lowered_while_asleep_counts() {
    let mut lab = site(true);
    let under = lab.cube(Vec3::Y * 0.5);
    let upper = lab.cube(Vec3::Y * 1.5);
    for body in [under, upper] {
        watch(&mut lab, body);
    }
    assert_eq!(told(&mut lab, 2.0), []);
    assert!(lab.world.get::<Sleeping>(under).unwrap().asleep);
    // It bears its own weight and the other's, 10 kN each.
    let weak = Watch { strength: 15_000.0 };
    lab.world.entity_mut(under).insert(weak);
    let crushed = told(&mut lab, 0.1);
    assert_eq!(ways(&crushed), [(under, FailureMode::Crushed)]);
    assert_eq!(crushed[0].rest, [upper]);
    // Nothing has moved.
    let [ended] = &ends(&mut lab)[..] else {
        panic!("one collapse has ended");
    };
    assert_eq!((ended.first, &ended.moved[..]), (under, &[][..]));
    // The reported structure stands again, so that it can fall.
    lab.world.despawn(under);
    assert_eq!(ways(&told(&mut lab, 2.0)), [(upper, FailureMode::Fell)]);
}

#[test]
fn structures_watched_only_once_asleep_stand() {
    let mut lab = site(true);
    let wall = Wall::new(Bond::Running).blocks().unwrap().into_iter();
    let bricks: Vec<Entity> = wall.map(|brick| lab.spawn(brick.bundle())).collect();
    // One of them is watched from the start.
    watch(&mut lab, bricks[20]);
    lab.run(3.0);
    assert!(lab.world.get::<Sleeping>(bricks[0]).unwrap().asleep);
    for &brick in &bricks {
        if brick != bricks[20] {
            watch(&mut lab, brick);
        }
    }
    assert_eq!(told(&mut lab, 1.0), []);
    lab.world.despawn(bricks[0]);
    let all = told(&mut lab, 4.0);
    assert_eq!(all.len(), 1, "{all:?}");
    assert!([bricks[5], bricks[6]].contains(&all[0].first));
    assert!(all[0].rest.len() > 20);
}

#[test]
fn how_many_fall_and_how_heavy_they_are_is_told() {
    for sleeps in [true, false] {
        let mut lab = site(sleeps);
        // Two columns far from each other, one of which falls.
        let columns = [0.0, 20.0].map(|x| {
            [0.5, 1.5, 2.5].map(|y| {
                let cube = lab.cube(Vec3::new(x, y, 0.0));
                watch(&mut lab, cube)
            })
        });
        lab.run(1.0);
        let [[base, middle, top], _] = columns;
        lab.world.despawn(base);
        let all = told(&mut lab, 4.0);
        assert_eq!(all.len(), 1, "{all:?}");
        // The base is gone.
        assert_eq!((all[0].bodies, all[0].mass.round()), (2, 2000.0));
        let [ended] = &ends(&mut lab)[..] else {
            panic!("one collapse has ended");
        };
        assert_eq!((ended.first, ended.how), (all[0].first, FailureMode::Fell));
        assert_eq!(ended.moved, [middle, top]);
        assert_eq!(ended.mass, all[0].mass);
    }
}
