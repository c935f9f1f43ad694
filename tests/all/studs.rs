//! Toy bricks: they click where they are laid or pressed, hold up to a pull, and come apart.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use support::*;

const PITCH: f32 = 0.1;
/// 2 by 4 studs, one and a fifth high, as toy bricks are.
const SIZE: Vec3 = Vec3::new(4.0 * PITCH, 0.12, 2.0 * PITCH);
const PULL: f32 = 50.0;

fn brick(at: Vec3) -> impl Bundle {
    (
        RigidBody::Dynamic,
        Collider::cuboid(SIZE.x, SIZE.y, SIZE.z),
        Mass(0.5),
        Studs::new(PITCH, PULL),
        Transform::from_translation(at),
    )
}

/// A board with studs whose top is at a height of zero.
fn board(lab: &mut Lab) -> Entity {
    lab.spawn((
        RigidBody::Static,
        Collider::cuboid(32.0 * PITCH, 0.1, 32.0 * PITCH),
        Studs::new(PITCH, PULL),
        Transform::from_xyz(0.0, -0.05, 0.0),
    ))
}

/// The place of a brick on the board, in studs from its middle, in a course.
fn place(x: f32, z: f32, course: usize) -> Vec3 {
    Vec3::new(x * PITCH, (course as f32 + 0.5) * SIZE.y, z * PITCH)
}

fn bonds(lab: &mut Lab) -> usize {
    let mut bonds = lab.world.query::<&MortarJoint>();
    bonds.iter(&lab.world).count()
}

fn steps(lab: &mut Lab, count: usize) {
    (0..count).for_each(|_| lab.step());
}

#[test]
fn bricks_click_where_their_studs_fit() {
    let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    // Beside the middle in pitches, turned, and whether it clicks onto a brick of 4 by 2.
    let cases = [
        (0.0, 0.0, Quat::IDENTITY, true),
        (2.0, 1.0, Quat::IDENTITY, true),
        (3.0, 0.0, Quat::IDENTITY, true),
        (1.0, 1.0, quarter, true),
        (0.0, 0.0, quarter, true),
        (0.5, 0.0, Quat::IDENTITY, false),
        (0.0, 0.3, Quat::IDENTITY, false),
        (0.5, 0.5, quarter, false),
        (0.0, 0.0, Quat::from_rotation_y(0.2), false),
        (0.0, 0.0, Quat::from_rotation_x(std::f32::consts::PI), false),
    ];
    for (x, z, turn, clicks) in cases {
        let mut lab = Lab::new();
        board(&mut lab);
        lab.spawn(brick(place(0.0, 0.0, 0)));
        let upper = lab.spawn(brick(place(x, z, 1)));
        let turned = Transform::from_translation(place(x, z, 1)).with_rotation(turn);
        lab.world.entity_mut(upper).insert(turned);
        lab.step();
        assert_eq!(bonds(&mut lab), 1 + usize::from(clicks), "{x} {z} {turn}");
    }
    // Side by side they do not.
    let mut lab = Lab::new();
    board(&mut lab);
    lab.spawn(brick(place(0.0, 0.0, 0)));
    lab.spawn(brick(place(4.0, 0.0, 0)));
    lab.step();
    assert_eq!(bonds(&mut lab), 2);
}

/// The force, as a share of what its studs hold, at which a brick comes off when it is pulled straight up.
#[test]
fn they_hold_up_to_a_pull() {
    for studs in [8.0, 4.0, 2.0] {
        // Of the brick below, so many studs are covered.
        let beside = 4.0 - studs / 2.0;
        let comes_off = |share: f32| {
            let mut lab = Lab::new();
            board(&mut lab);
            let lower = lab.spawn(brick(place(0.0, 0.0, 0)));
            lab.world.entity_mut(lower).insert(RigidBody::Static);
            let upper = lab.spawn(brick(place(beside, 0.0, 1)));
            lab.step();
            // Straight above the studs that hold it.
            let pull = Vec3::Y * (share * studs * PULL + 0.5 * 9.81);
            let mut force = ExternalForce::default();
            force.add_at(pull, Vec3::X * (-0.5 * beside * PITCH));
            // Its weight pulls at its middle.
            force.add_at(Vec3::Y * 0.5 * 9.81, Vec3::ZERO);
            force.add_at(Vec3::NEG_Y * 0.5 * 9.81, Vec3::X * (-0.5 * beside * PITCH));
            lab.world.entity_mut(upper).insert(force);
            steps(&mut lab, 60);
            let height = lab.position(upper).y;
            (height - place(0.0, 0.0, 1).y).abs() > 0.01
        };
        assert!(!comes_off(0.95), "{studs} studs came off");
        assert!(comes_off(1.05), "{studs} studs held");
    }
}

#[test]
fn a_lever_pries_them_apart_more_easily() {
    let mut lab = Lab::new();
    board(&mut lab);
    lab.spawn(brick(place(0.0, 0.0, 0)));
    let upper = lab.spawn(brick(place(0.0, 0.0, 1)));
    lab.step();
    let mut force = ExternalForce::default();
    // Half of what eight studs hold, at the end of the brick.
    force.add_at(Vec3::Y * (0.5 * 8.0 * PULL), Vec3::X * 0.5 * SIZE.x);
    lab.world.entity_mut(upper).insert(force);
    steps(&mut lab, 30);
    assert!(lab.position(upper).y > place(0.0, 0.0, 1).y + 0.05);
}

#[test]
fn they_come_apart_and_may_be_pressed_together_again() {
    let mut lab = Lab::new();
    board(&mut lab);
    lab.spawn(brick(place(0.0, 0.0, 0)));
    let upper = lab.spawn((brick(place(2.0, 0.0, 1)), Name::new("upper")));
    lab.step();
    assert_eq!(bonds(&mut lab), 2);
    let pull = ExternalForce {
        force: Vec3::Y * 1000.0,
        ..Default::default()
    };
    lab.world.entity_mut(upper).insert(pull);
    let mut broke = Vec::new();
    for _ in 0..10 {
        lab.step();
        let mut messages = lab.world.resource_mut::<Messages<MortarBroke>>();
        broke.extend(messages.drain());
    }
    assert_eq!(broke.len(), 1);
    assert!([broke[0].body, broke[0].other].contains(&upper));
    // It is put back, and lies there loosely until it is pressed.
    lab.world.entity_mut(upper).remove::<ExternalForce>();
    lab.world.entity_mut(upper).insert((
        Transform::from_translation(place(0.0, 0.0, 1)),
        Velocity::default(),
        Teleport,
    ));
    steps(&mut lab, 30);
    assert_eq!(
        bonds(&mut lab),
        1,
        "its weight of 5 N is no press of 8 · 50 N"
    );
    let press = |newtons: f32| ExternalForce {
        force: Vec3::NEG_Y * newtons,
        ..Default::default()
    };
    lab.world.entity_mut(upper).insert(press(300.0));
    steps(&mut lab, 10);
    assert_eq!(bonds(&mut lab), 1);
    lab.world.entity_mut(upper).insert(press(500.0));
    steps(&mut lab, 10);
    assert_eq!(bonds(&mut lab), 2);
    // It holds.
    lab.world.entity_mut(upper).insert(press(-300.0));
    steps(&mut lab, 60);
    assert!((lab.position(upper) - place(0.0, 0.0, 1)).length() < 1e-3);
}

/// A tower of forty bricks in bond is lifted by its top brick, with the board's studs left behind.
#[test]
fn a_tower_is_lifted_in_one_piece() {
    let mut lab = Lab::new();
    lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let bricks: Vec<Entity> = (0..40)
        .map(|i| lab.spawn(brick(place([0.0, 1.0][i % 2], 0.0, i))))
        .collect();
    lab.step();
    assert_eq!(bonds(&mut lab), 39);
    let top = bricks[39];
    let at = lab.position(top);
    // The tower weighs 196 N, and six studs hold 300, if they are pulled in their middle.
    let beside = Vec3::NEG_X * 0.5 * PITCH;
    let grab = Grab {
        max_force: 260.0,
        ..Grab::gentle(20.0, beside, at + beside + Vec3::Y * 0.5)
    };
    lab.world.entity_mut(top).insert(grab);
    steps(&mut lab, 120);
    for (i, brick) in bricks.into_iter().enumerate() {
        let expected = place([0.0, 1.0][i % 2], 0.0, i) + Vec3::Y * 0.5;
        let found = lab.position(brick);
        assert!(
            (found - expected).length() < 0.01,
            "{i}: {found} instead of {expected}"
        );
    }
}

#[test]
fn invalid_studs_are_removed() {
    let mut lab = Lab::new();
    board(&mut lab);
    let odd = lab.spawn(brick(place(0.0, 0.0, 0)));
    lab.world.entity_mut(odd).insert(Studs::new(0.0, PULL));
    steps(&mut lab, 2);
    assert!(lab.world.get::<Studs>(odd).is_none());
    assert_eq!(bonds(&mut lab), 0);
}
