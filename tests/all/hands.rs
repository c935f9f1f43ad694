//! Tests of grabs: loads do not sag, strength is limited, and no body is pulled through a wall.

use bevy_app::App;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{ExternalForce, ExternalImpulse, GravityScale, Mass, RigidBody};
use drystone::collider::Collider;
use drystone::contact::Load;
use drystone::grab::{Grab, GrabForce, Hand, HandPlugin, HandState, hands};
use drystone::masonry::EditLog;
use drystone::query::{Dir3, Ray3d};
use drystone::schedule::{PhysicsSchedule, PhysicsSystems};
use drystone::settings::{PhysicsThreads, Preset, SolverSettings};
use drystone::solver::{Nncg, Pgs};
use glam::{BVec3, Quat, Vec3, Vec3Swizzles};
use support::*;

const WEIGHT: f32 = 1000.0 * G;

fn hold(lab: &mut Lab, body: Entity, grab: Grab) {
    lab.world.entity_mut(body).insert(grab);
}

fn force(lab: &Lab, body: Entity) -> GrabForce {
    *lab.world.get::<GrabForce>(body).unwrap()
}

/// Worlds with each solver and with short and long steps.
fn each(check: impl Fn(&str, Lab)) {
    for dt in [1.0 / 60.0, 1.0 / 30.0, 0.1] {
        for name in ["soft-step", "pgs", "nncg"] {
            let mut lab = Lab::shipped(dt);
            match name {
                "pgs" => lab.world.insert_resource(SolverSettings::new(Pgs {
                    iterations: 50,
                    ..Default::default()
                })),
                "nncg" => lab
                    .world
                    .insert_resource(SolverSettings::new(Nncg::default())),
                _ => {}
            }
            check(&format!("{name} at {dt} s"), lab);
        }
    }
}

#[test]
fn a_load_does_not_sag() {
    each(|name, mut lab| {
        lab.ground();
        let cube = lab.cube(Vec3::Y * 0.5);
        lab.run(0.5);
        let target = Vec3::new(1.0, 3.0, -1.0);
        hold(&mut lab, cube, Grab::gentle(1000.0, Vec3::ZERO, target));
        lab.run(4.0);
        let off = lab.position(cube).distance(target);
        assert!(off < 1e-4, "{name}: {off}");
        assert_near(force(&lab, cube).force.y, WEIGHT, 1e-3, name);
    });
}

/// By its side: without fingers it swings below the point, with them it stays level.
#[test]
fn fingers_keep_it_level() {
    each(|name, mut lab| {
        let cube = lab.cube(Vec3::Y * 5.0);
        let point = Vec3::new(0.5, 0.0, 0.0);
        let grab = Grab {
            max_torque: 0.6 * WEIGHT,
            ..Grab::gentle(1000.0, point, Vec3::new(0.5, 5.0, 0.0))
        };
        hold(&mut lab, cube, grab);
        lab.run(2.0);
        let off = lab.position(cube).distance(Vec3::Y * 5.0);
        assert!(off < 0.02, "{name}: {off}");
        assert_near(force(&lab, cube).torque.length(), 0.5 * WEIGHT, 0.01, name);
        let loose = Grab {
            max_torque: 0.0,
            ..grab
        };
        hold(&mut lab, cube, loose);
        let lowest = (0..(2.0 / lab.dt) as usize).map(|_| {
            lab.step();
            lab.position(cube).y
        });
        let lowest = lowest.fold(f32::INFINITY, f32::min);
        // Half a metre below the point, and no thread that gives.
        assert!((4.4..4.7).contains(&lowest), "{name}: {lowest}");
    });
}

#[test]
fn it_is_turned_as_the_hand_would_have_it() {
    each(|name, mut lab| {
        let cube = lab.cube(Vec3::Y * 5.0);
        let wanted = Quat::from_scaled_axis(Vec3::new(0.5, -2.0, 1.0));
        let grab = Grab {
            rotation: Some(wanted),
            ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 5.0)
        };
        hold(&mut lab, cube, grab);
        lab.run(4.0);
        let off = lab.pose(cube).rotation.angle_between(wanted);
        assert!(off < 1e-3, "{name}: {off}");
        let moved = lab.position(cube).distance(Vec3::Y * 5.0);
        assert!(moved < 1e-3, "{name}: {moved}");
    });
}

#[test]
fn strength_has_an_end() {
    each(|name, mut lab| {
        lab.ground();
        let cube = lab.cube(Vec3::Y * 0.5);
        lab.world.entity_mut(cube).insert(Load::default());
        lab.run(0.5);
        let grab = Grab {
            max_force: 0.75 * WEIGHT,
            ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 3.0)
        };
        hold(&mut lab, cube, grab);
        lab.run(2.0);
        let lifted = lab.position(cube).y - 0.5;
        assert!(lifted.abs() < 1e-3, "{name}: {lifted}");
        assert_near(force(&lab, cube).force.y, 0.75 * WEIGHT, 1e-3, name);
        let bears = lab.world.get::<Load>(cube).unwrap().force.y;
        assert_near(bears, 0.25 * WEIGHT, 0.02, name);
    });
}

/// Pulled by fifty times its weight, at something behind a wall.
#[test]
fn a_wall_is_not_torn_through() {
    each(|name, mut lab| {
        lab.ground();
        let wall = Collider::cuboid(0.5, 4.0, 4.0);
        let wall = lab.body(wall, Vec3::new(2.0, 2.0, 0.0));
        lab.world.entity_mut(wall).insert(RigidBody::Static);
        let cube = lab.cube(Vec3::Y * 0.5);
        lab.run(0.5);
        let grab = Grab {
            max_force: 50.0 * WEIGHT,
            max_speed: 20.0,
            ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(6.0, 1.5, 0.0))
        };
        hold(&mut lab, cube, grab);
        let mut deepest = 0f32;
        for _ in 0..(4.0 / lab.dt) as usize {
            lab.step();
            deepest = deepest.max(lab.position(cube).x - 1.25);
        }
        assert!(deepest < 0.01, "{name}: {deepest}");
    });
}

/// From rest, in one step, by whatever pushes: what a velocity of the step before does not tell.
#[test]
fn held_bodies_pushed_hard_do_not_get_into_a_wall() {
    for push in ["force", "impulse", "hand"] {
        each(|name, mut lab| {
            let wall = Collider::cuboid(0.5, 4.0, 4.0);
            let wall = lab.body(wall, Vec3::new(2.0, 2.0, 0.0));
            lab.world.entity_mut(wall).insert(RigidBody::Static);
            let cube = lab.cube(Vec3::new(0.8, 2.0, 0.0));
            lab.world.entity_mut(cube).insert(GravityScale(0.0));
            lab.step();
            let strong = Vec3::X * 50.0 * WEIGHT;
            let dt = lab.dt;
            let mut cubes = lab.world.entity_mut(cube);
            match push {
                "force" => cubes.insert(ExternalForce {
                    force: strong,
                    torque: Vec3::ZERO,
                    ..Default::default()
                }),
                "impulse" => cubes.insert(ExternalImpulse {
                    linear: strong * dt,
                    angular: Vec3::ZERO,
                }),
                _ => cubes.insert(Grab {
                    max_force: strong.x,
                    max_speed: 50.0,
                    ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(9.0, 2.0, 0.0))
                }),
            };
            let mut deepest = 0f32;
            for _ in 0..(0.5 / dt) as usize {
                lab.step();
                deepest = deepest.max(lab.position(cube).x - 1.25);
            }
            assert!(deepest < 0.01, "{push}, {name}: {deepest}");
        });
    }
}

/// A fixed box of 1 m, hit at 4 m/s and then pressed against by ten thousand weights, or by all that a hand may have.
#[test]
fn however_strong_a_hand_nothing_passes_what_is_static() {
    for weights in [1e4, f32::INFINITY] {
        each(|name, mut lab| {
            lab.ground();
            let wall = Collider::cuboid(1.0, 4.0, 4.0);
            let wall = lab.body(wall, Vec3::new(3.0, 2.0, 0.0));
            lab.world.entity_mut(wall).insert(RigidBody::Static);
            let cube = lab.cube(Vec3::Y * 0.5);
            lab.run(0.5);
            let grab = Grab {
                max_force: weights * WEIGHT,
                ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(6.0, 1.5, 0.0))
            };
            hold(&mut lab, cube, grab);
            let deepest = deepest(&mut lab, cube, 4.0, |at| at.x - 2.0);
            assert!(deepest < 0.01, "{weights} weights, {name}: {deepest}");
        });
    }
}

/// By a corner too, so that it is pressed askew.
#[test]
fn however_strong_a_hand_nothing_goes_into_the_ground() {
    for arm in [Vec3::ZERO, Vec3::new(0.5, 0.5, 0.3)] {
        for speed in [4.0, f32::INFINITY] {
            each(|name, mut lab| {
                lab.ground();
                let cube = lab.cube(Vec3::Y * 0.5);
                lab.run(0.5);
                let grab = Grab {
                    max_force: f32::INFINITY,
                    max_speed: speed,
                    ..Grab::gentle(1000.0, arm, Vec3::new(0.0, -3.0, 0.0))
                };
                hold(&mut lab, cube, grab);
                // Its centre is nowhere nearer to the ground than when it lies flat.
                let deepest = deepest(&mut lab, cube, 3.0, |at| 0.5 - at.y);
                assert!(deepest < 0.01, "{arm}, {speed} m/s, {name}: {deepest}");
            });
        }
    }
}

/// Between the held body and the wall is a body that is not held.
#[test]
fn a_body_pushed_by_what_is_held_does_not_pass_either() {
    each(|name, mut lab| {
        lab.ground();
        let wall = Collider::cuboid(1.0, 4.0, 4.0);
        let wall = lab.body(wall, Vec3::new(3.0, 2.0, 0.0));
        lab.world.entity_mut(wall).insert(RigidBody::Static);
        let cube = lab.cube(Vec3::new(-0.5, 0.5, 0.0));
        let between = lab.cube(Vec3::new(1.5, 0.5, 0.0));
        lab.run(0.5);
        let grab = Grab {
            max_force: 1e4 * WEIGHT,
            ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(6.0, 0.5, 0.0))
        };
        hold(&mut lab, cube, grab);
        let (mut held, mut pushed) = (0f32, 0f32);
        for _ in 0..(3.0 / lab.dt) as usize {
            lab.step();
            held = held.max(lab.position(cube).x - 1.0);
            pushed = pushed.max(lab.position(between).x - 2.0);
        }
        assert!(pushed < 0.03 && held < 0.06, "{name}: {pushed}, {held}");
    });
}

/// In the air, and into the ground: it is there in no time, and stays.
#[test]
fn a_hand_without_any_limit_does_not_shake_what_it_holds() {
    for arm in [Vec3::ZERO, Vec3::new(0.5, 0.5, 0.3)] {
        for (rotation, torque) in [
            (None, f32::INFINITY),
            (Some(Quat::from_rotation_y(2.0)), f32::INFINITY),
            (None, 0.0),
        ] {
            each(|name, mut lab| {
                lab.ground();
                let cube = lab.cube(Vec3::Y * 0.5);
                lab.run(0.5);
                let what = format!("{arm}, {rotation:?}, {torque} N m, {name}");
                for target in [Vec3::new(1.0, 3.0, -1.0), Vec3::new(-1.0, -2.0, 0.0)] {
                    let grab = Grab {
                        target,
                        local_point: arm,
                        rotation,
                        response: 0.0,
                        max_speed: f32::INFINITY,
                        max_force: f32::INFINITY,
                        max_torque: torque,
                        axes: BVec3::TRUE,
                        turn_axes: BVec3::TRUE,
                    };
                    hold(&mut lab, cube, grab);
                    let mut farthest = 0f32;
                    for _ in 0..(3.0 / lab.dt) as usize {
                        lab.step();
                        let at = lab.position(cube);
                        // Swung by its corner, a corner of it may strike the ground at 30 rad/s.
                        let swings = arm != Vec3::ZERO && torque == 0.0;
                        let least = if swings { 0.25 } else { 0.49 };
                        assert!(at.is_finite() && at.y > least, "{what}: {at}");
                        farthest = farthest.max(at.distance(target));
                    }
                    assert!(farthest < 6.0, "{what}: {farthest}");
                    assert!(
                        lab.position(cube).y > 0.49,
                        "{what}: {}",
                        lab.position(cube)
                    );
                    let velocity = lab.velocity(cube);
                    let still = velocity.linear.length().max(velocity.angular.length());
                    let off = lab.pose(cube).transform_point(arm).distance(target);
                    if target.y > 0.0 && (torque > 0.0 || arm == Vec3::ZERO) {
                        assert!(still < 1e-2 && off < 1e-3, "{what}: {still} m/s, {off} m");
                    }
                }
            });
        }
    }
}

/// A beam that a hand turns is stopped by a fixed post beside it, even where it would be turned through that in one step.
#[test]
fn a_turned_beam_does_not_pass_a_post() {
    for response in [0.1, 0.0] {
        each(|name, mut lab| {
            let post = lab.body(Collider::cuboid(0.4, 2.0, 0.4), Vec3::new(2.0, 0.0, 1.0));
            lab.world.entity_mut(post).insert(RigidBody::Static);
            let beam = lab.body(Collider::cuboid(6.0, 0.2, 0.2), Vec3::ZERO);
            lab.world.entity_mut(beam).insert(GravityScale(0.0));
            let grab = Grab {
                rotation: Some(Quat::from_rotation_y(-1.5)),
                max_force: f32::INFINITY,
                max_torque: f32::INFINITY,
                response,
                ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::ZERO)
            };
            hold(&mut lab, beam, grab);
            let mut deepest = 0f32;
            for _ in 0..(3.0 / lab.dt) as usize {
                lab.step();
                let pose = lab.pose(beam);
                let post = pose.inverse_transform_point(Vec3::new(2.0, 0.0, 1.0));
                // As the beam sees it: its own half width, and that of the post, which is turned.
                let [x, z] = [pose.rotation * Vec3::X, pose.rotation * Vec3::Z];
                assert!(
                    post.x.abs() < 3.0 && x.y.abs() < 0.01,
                    "{name}: it slipped off, {post}"
                );
                deepest = deepest.max(0.1 + 0.2 * (z.x.abs() + z.z.abs()) - post.z);
            }
            assert!(deepest < 0.02, "{response} s, {name}: {deepest}");
        });
    }
}

/// How far it ever gets in so many seconds.
fn deepest(lab: &mut Lab, body: Entity, seconds: f32, depth: impl Fn(Vec3) -> f32) -> f32 {
    let steps = 0..(seconds / lab.dt) as usize;
    let depths = steps.map(|_| {
        lab.step();
        depth(lab.position(body))
    });
    depths.fold(f32::NEG_INFINITY, |a, b| match b.is_nan() {
        true => f32::INFINITY,
        false => a.max(b),
    })
}

#[test]
fn released_bodies_fall_from_rest() {
    each(|name, mut lab| {
        let cube = lab.cube(Vec3::Y * 5.0);
        hold(
            &mut lab,
            cube,
            Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 5.0),
        );
        lab.run(1.0);
        lab.world.entity_mut(cube).remove::<Grab>();
        assert_eq!(force(&lab, cube), GrabForce::default());
        lab.step();
        let velocity = lab.velocity(cube).linear;
        let fallen = velocity.distance(Vec3::NEG_Y * G * lab.dt);
        assert!(fallen < 1e-3, "{name}: {velocity}");
    });
}

/// A brick put on a wall by hand, and let go there, leaves the wall as it was.
#[test]
fn a_brick_is_laid_without_a_jolt() {
    let mut lab = Lab::new();
    lab.ground();
    let brick = || Collider::cuboid(1.0, 0.5, 0.5);
    let wall: Vec<Entity> = [(-0.5, 0.25), (0.5, 0.25), (0.0, 0.75)]
        .map(|(x, y)| lab.body(brick(), Vec3::new(x, y, 0.0)))
        .into();
    let laid = lab.body(brick(), Vec3::new(2.0, 0.25, 0.0));
    lab.run(1.0);
    let mass = lab.mass(laid).mass();
    let place = Vec3::new(0.3, 1.25, 0.0);
    let ways = [Vec3::new(2.0, 2.0, 0.0), place + Vec3::Y * 0.1, place];
    for target in ways {
        hold(&mut lab, laid, Grab::gentle(mass, Vec3::ZERO, target));
        lab.run(1.0);
    }
    lab.world.entity_mut(laid).remove::<Grab>();
    lab.run(2.0);
    let off = lab.position(laid).distance(place);
    assert!(off < 1e-3, "{off}");
    for (brick, at) in wall
        .into_iter()
        .zip([(-0.5, 0.25), (0.5, 0.25), (0.0, 0.75)])
    {
        let off = lab.position(brick).distance(Vec3::new(at.0, at.1, 0.0));
        assert!(off < 1e-4, "{off}");
    }
}

/// A stack on a plate that a hand holds by its middle: the hand bears them all.
#[test]
fn a_held_plate_bears_a_stack() {
    for dt in [1.0 / 60.0, 0.1] {
        let mut lab = Lab::shipped(dt);
        let plate = lab.body(Collider::cuboid(1.0, 0.2, 1.0), Vec3::Y * 2.0);
        let stack: Vec<Entity> = (0..3)
            .map(|i| {
                let at = Vec3::Y * (2.1 + 0.25 + 0.5 * i as f32);
                let cube = lab.body(Collider::cuboid(0.5, 0.5, 0.5), at);
                lab.world.entity_mut(cube).insert(Mass(100.0));
                cube
            })
            .collect();
        lab.world.entity_mut(plate).insert(Mass(100.0));
        let grab = Grab {
            rotation: Some(Quat::IDENTITY),
            ..Grab::gentle(400.0, Vec3::ZERO, Vec3::Y * 2.0)
        };
        hold(&mut lab, plate, grab);
        lab.run(3.0);
        assert_near(
            force(&lab, plate).force.y,
            400.0 * G,
            1e-3,
            "four of 100 kg",
        );
        assert!((lab.position(plate).y - 2.0).abs() < 1e-4);
        for (i, cube) in stack.into_iter().enumerate() {
            let y = lab.position(cube).y - (2.35 + 0.5 * i as f32);
            assert!(y.abs() < 1e-3, "{i} at {dt}: {y}");
        }
    }
}

/// Also where sweeps would chase one another, or go in laps.
#[test]
fn held_bodies_move_alike_on_any_number_of_threads() {
    let run = |threads: usize| {
        let mut lab = Lab::with_preset(Preset::Default);
        let pool = PhysicsThreads::new(threads).unwrap().with_min_items(1);
        lab.world.insert_resource(pool);
        lab.ground();
        let mut wall = Vec::new();
        for course in 0..5 {
            for i in 0..12 {
                let x = i as f32 + 0.5 * (course % 2) as f32;
                let at = Vec3::new(x, 0.5 * course as f32 + 0.25, 0.0);
                wall.push(lab.body(Collider::cuboid(1.0, 0.5, 0.5), at));
            }
        }
        lab.run(0.2);
        for (body, to) in [
            (20, Vec3::new(7.0, 1.0, 3.0)),
            (55, Vec3::new(6.0, 4.0, 0.0)),
        ] {
            let mass = lab.mass(wall[body]).mass();
            hold(
                &mut lab,
                wall[body],
                Grab::gentle(mass, Vec3::new(0.1, 0.0, 0.25), to),
            );
        }
        lab.run(1.5);
        lab.bits()
    };
    let one = run(1);
    for threads in [2, 4] {
        assert_eq!(run(threads), one);
    }
}

fn lab_with_hands() -> Lab {
    let mut lab = Lab::new();
    let mut schedules = lab.world.resource_mut::<Schedules>();
    let physics = schedules.get_mut(PhysicsSchedule).unwrap();
    physics.add_systems(hands.before(PhysicsSystems::Prepare));
    lab.ground();
    lab
}

fn hand<'a>(lab: &'a mut Lab, entity: Entity) -> Mut<'a, Hand> {
    lab.world.get_mut::<Hand>(entity).unwrap()
}

fn held(lab: &Lab, hand: Entity) -> Option<Entity> {
    lab.world.get::<HandState>(hand).unwrap().held()
}

#[test]
fn a_hand_takes_what_it_points_at_and_carries_it() {
    let mut lab = lab_with_hands();
    let cube = lab.cube(Vec3::Y * 0.5);
    let behind = lab.cube(Vec3::new(0.0, 0.5, -3.0));
    lab.run(0.5);
    let at = |x: f32, y: f32| Some(Ray3d::new(Vec3::new(x, y, 10.0), Dir3::NEG_Z));
    let pointer = lab.world.spawn(Hand {
        ray: at(0.2, 0.6),
        ..Hand::new(5.0 * WEIGHT)
    });
    let pointer = pointer.id();
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), None);
    hand(&mut lab, pointer).closed = true;
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), Some(cube));
    assert_near(hand(&mut lab, pointer).distance, 9.5, 1e-3, "in front");
    hand(&mut lab, pointer).ray = at(3.2, 2.6);
    lab.run(3.0);
    let grab = *lab.world.get::<Grab>(cube).unwrap();
    assert!(grab.target.distance(Vec3::new(3.2, 2.6, 0.5)) < 1e-3);
    let held_at = lab.pose(cube).transform_point(grab.local_point);
    assert!(held_at.distance(grab.target) < 1e-3, "{held_at}");
    hand(&mut lab, pointer).closed = false;
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), None);
    assert!(lab.world.get::<Grab>(cube).is_none());
    assert!(lab.velocity(cube).linear.y < -0.5);
    // The one behind, now that nothing is before it.
    hand(&mut lab, pointer).ray = at(0.2, 0.6);
    hand(&mut lab, pointer).closed = true;
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), Some(behind));
    lab.world.despawn(pointer);
    lab.world.flush();
    assert!(lab.world.get::<Grab>(behind).is_none());
}

#[test]
fn a_hand_holds_nothing_that_it_cannot() {
    let mut lab = lab_with_hands();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(0.5);
    let down = |x: f32| Some(Ray3d::new(Vec3::new(x, 5.0, 0.0), Dir3::NEG_Y));
    // The ground, nothing at all, and nowhere.
    let nan = Some(Ray3d::new(Vec3::new(f32::NAN, 0.0, 0.0), Dir3::NEG_Y));
    let up = Some(Ray3d::new(Vec3::ONE * 5.0, Dir3::Y));
    for ray in [down(5.0), up, None, nan] {
        let new = Hand {
            ray,
            closed: true,
            ..Hand::new(WEIGHT)
        };
        let pointer = lab.world.spawn(new).id();
        lab.run(0.1);
        assert_eq!(held(&lab, pointer), None);
        // Closed, it takes nothing that comes by; but one that pointed nowhere has not closed on anything yet.
        hand(&mut lab, pointer).ray = down(0.0);
        lab.run(0.1);
        let takes = ray.is_none().then_some(cube);
        assert_eq!(held(&lab, pointer), takes);
        lab.world.despawn(pointer);
    }
    // The held body is despawned.
    let new = Hand {
        ray: down(0.0),
        closed: true,
        ..Hand::new(WEIGHT)
    };
    let pointer = lab.world.spawn(new).id();
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), Some(cube));
    lab.world.despawn(cube);
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), None);
}

/// An app whose hands hold a cube of 1 m from above, after half a second.
fn held_cube() -> (Lab, Entity, Entity) {
    let mut lab = lab_with_hands();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(0.5);
    let pointer = Ray3d::new(Vec3::new(0.0, 3.0, 0.0), Dir3::NEG_Y);
    let pointer = Hand {
        ray: Some(pointer),
        closed: true,
        ..Hand::new(5.0 * WEIGHT)
    };
    let pointer = lab.spawn(pointer);
    lab.run(0.1);
    hand(&mut lab, pointer).distance = 1.0;
    lab.run(2.0);
    assert!((lab.position(cube).y - 1.5).abs() < 1e-2);
    assert_eq!(held(&lab, pointer), Some(cube));
    (lab, cube, pointer)
}

/// It falls, and nothing holds it.
#[track_caller]
fn falls(lab: &mut Lab, cube: Entity, how: &str) {
    assert!(lab.world.get::<Grab>(cube).is_none(), "{how}: still held");
    lab.run(1.0);
    let height = lab.position(cube).y;
    assert!((height - 0.5).abs() < 1e-2, "{how}: at {height} m");
}

#[test]
fn a_body_that_is_disabled_while_held_is_let_go() {
    let (mut lab, cube, pointer) = held_cube();
    lab.world.entity_mut(cube).insert(Disabled);
    lab.run(0.1);
    assert_eq!(held(&lab, pointer), None);
    lab.world.entity_mut(cube).remove::<Disabled>();
    falls(&mut lab, cube, "by a hand");
    // By a game's own grab as well.
    hold(
        &mut lab,
        cube,
        Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 2.0),
    );
    lab.run(1.0);
    lab.world.entity_mut(cube).insert(Disabled);
    lab.world.entity_mut(cube).remove::<Disabled>();
    falls(&mut lab, cube, "by a grab");
}

#[test]
fn a_body_that_is_taken_and_brought_back_is_not_held_any_more() {
    let (mut lab, cube, pointer) = held_cube();
    let mut log = EditLog::default();
    log.remove(&mut lab.world, &[cube]).unwrap();
    lab.run(0.5);
    log.undo(&mut lab.world).unwrap();
    falls(&mut lab, cube, "taken");
    assert_eq!(held(&lab, pointer), None);
    // It was put up here, is held, and the edit is undone.
    log.move_to(&mut lab.world, cube, Transform::from_xyz(3.0, 0.5, 0.0))
        .unwrap();
    let grab = Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(3.0, 3.0, 0.0));
    hold(&mut lab, cube, grab);
    lab.run(1.0);
    log.undo(&mut lab.world).unwrap();
    falls(&mut lab, cube, "put");
    assert!(lab.position(cube).x.abs() < 0.01);
}

#[test]
fn a_hand_with_invalid_numbers_holds_on_and_hurts_nobody() {
    type Spoil = (&'static str, fn(&mut Hand));
    let spoils: [Spoil; 8] = [
        ("ray", |hand| {
            hand.ray = Some(Ray3d::new(Vec3::NAN, Dir3::NEG_Y));
        }),
        ("distance", |hand| hand.distance = f32::NAN),
        ("far", |hand| hand.distance = 1e9),
        ("force", |hand| hand.max_force = f32::NAN),
        ("torque", |hand| hand.max_torque = -1.0),
        ("turn", |hand| {
            hand.rotation = Some(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0))
        }),
        ("zero turn", |hand| {
            hand.rotation = Some(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0))
        }),
        ("long turn", |hand| {
            hand.rotation = Some(Quat::IDENTITY * 1.001)
        }),
    ];
    for (what, spoil) in spoils {
        let (mut lab, cube, pointer) = held_cube();
        let sound = *hand(&mut lab, pointer);
        spoil(&mut hand(&mut lab, pointer));
        lab.run(1.0);
        assert_eq!(lab.errors(), [], "{what}");
        assert!((lab.position(cube).y - 1.5).abs() < 1e-2, "{what}");
        assert_eq!(held(&lab, pointer), Some(cube), "{what}");
        *hand(&mut lab, pointer) = Hand {
            distance: 0.5,
            ..sound
        };
        lab.run(2.0);
        assert!((lab.position(cube).y - 2.0).abs() < 1e-2, "{what}");
        // So it closes on nothing.
        hand(&mut lab, pointer).closed = false;
        lab.run(1.0);
        spoil(&mut hand(&mut lab, pointer));
        hand(&mut lab, pointer).closed = true;
        lab.run(0.5);
        assert_eq!(lab.errors(), [], "{what}");
    }
}

/// In the step in which the body comes into the world.
#[test]
fn a_hand_that_is_closed_before_the_first_step_takes_hold() {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin));
    let mut lab = Lab::new();
    lab.world = std::mem::take(app.world_mut());
    for round in 0..2 {
        let x = 5.0 * round as f32;
        let cube = lab.cube(Vec3::new(x, 0.5, 0.0));
        let pointer = Hand {
            ray: Some(Ray3d::new(Vec3::new(x + 0.1, 3.0, 0.0), Dir3::NEG_Y)),
            closed: true,
            ..Hand::new(5.0 * WEIGHT)
        };
        let pointer = lab.spawn(pointer);
        lab.step();
        assert_eq!(held(&lab, pointer), Some(cube), "round {round}");
        let at = lab.world.get::<Grab>(cube).unwrap().local_point;
        assert!(at.distance(Vec3::new(0.1, 0.5, 0.0)) < 1e-3, "{at}");
        lab.run(1.0);
        assert!((lab.position(cube).y - 0.5).abs() < 0.01);
    }
}

#[test]
fn a_clone_of_a_hand_holds_nothing_and_lets_nothing_go() {
    let (mut lab, cube, pointer) = held_cube();
    let clone = lab.world.entity_mut(pointer).clone_and_spawn();
    lab.run(0.5);
    assert_eq!(held(&lab, clone), None);
    hand(&mut lab, clone).closed = false;
    lab.run(0.5);
    // It closes on what the first one holds already.
    hand(&mut lab, clone).closed = true;
    lab.run(0.5);
    assert_eq!(held(&lab, clone), None);
    lab.world.despawn(clone);
    lab.run(0.5);
    assert_eq!(held(&lab, pointer), Some(cube));
    assert!(lab.world.get::<Grab>(cube).is_some());
    assert!((lab.position(cube).y - 1.5).abs() < 1e-2);
    // The clone of a held body is not held.
    let twin = lab.world.entity_mut(cube).clone_and_spawn();
    let beside = Transform::from_xyz(3.0, 1.5, 0.0);
    lab.world.entity_mut(twin).insert(beside);
    falls(&mut lab, twin, "a clone");
}

#[test]
fn a_body_goes_from_hand_to_hand() {
    let (mut lab, cube, first) = held_cube();
    let sound = *hand(&mut lab, first);
    let second = lab.spawn(Hand {
        closed: false,
        ..sound
    });
    hand(&mut lab, first).closed = false;
    hand(&mut lab, second).closed = true;
    lab.run(1.0);
    assert_eq!(held(&lab, second), Some(cube));
    assert_eq!(held(&lab, first), None);
    assert!((lab.position(cube).y - 1.5).abs() < 1e-2);
}

/// A finger that pulls a hanging cube to the side: level, so that it bears nothing of its weight, and about no axis.
#[test]
fn a_hand_pulls_along_its_axes_only() {
    each(|name, mut lab| {
        lab.ground();
        let cube = lab.cube(Vec3::Y * 5.0);
        let level = BVec3::new(true, false, true);
        let grab = Grab {
            axes: level,
            turn_axes: BVec3::new(false, true, false),
            ..Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(1.0, 5.0, 0.0))
        };
        hold(&mut lab, cube, grab);
        lab.set_velocity(cube, Vec3::ZERO, Vec3::new(0.0, 2.0, 0.5));
        let mut time = 0.0;
        while time < 0.45 {
            lab.step();
            time += lab.dt;
            assert_eq!(force(&lab, cube).force.y, 0.0, "{name}");
            let torque = force(&lab, cube).torque;
            assert_eq!((torque.x, torque.z), (0.0, 0.0), "{name}");
        }
        // As fast as nothing holds it, and not round its own axis any more.
        let velocity = lab.velocity(cube);
        assert_near(velocity.linear.y, -G * time, 1e-3, name);
        assert!(velocity.angular.y.abs() < 1e-3, "{name}: {velocity:?}");
        assert!(velocity.angular.xz().length() > 0.3, "{name}: {velocity:?}");
        lab.run(3.0);
        let at = lab.position(cube);
        assert!(at.with_y(0.0).distance(Vec3::X) < 0.02, "{name}: {at}");
        assert!(at.y < 0.9, "{name}: {at}");
        // All axes are the same as no mask.
        assert_eq!(Grab::gentle(1.0, at, at).axes, BVec3::TRUE);
    });
}

/// Pulled at its foot over the ground, towards a place high above it.
#[test]
fn a_finger_that_pulls_level_does_not_hold_level() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(0.2);
    let mut pointer = Hand::new(5.0 * WEIGHT);
    pointer.axes = BVec3::new(true, false, true);
    pointer.max_torque = 0.0;
    let grab = Grab {
        axes: pointer.axes,
        max_torque: 0.0,
        max_force: pointer.max_force,
        ..Grab::gentle(1000.0, Vec3::new(0.5, -0.3, 0.0), Vec3::new(4.0, 9.0, 0.0))
    };
    hold(&mut lab, cube, grab);
    lab.run(3.0);
    let at = lab.position(cube);
    // It follows over the ground, and is not lifted.
    assert!((at.x - 3.5).abs() < 0.2, "{at}");
    assert!(at.y < 0.75, "{at}");
    assert_eq!(force(&lab, cube).force.y, 0.0);
}
