//! Characters: stairs of loose bricks, slopes, walls, platforms and pushing.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::*;
use drystone::collider::Collider;
use drystone::query::{MoveAndSlide, QueryError, QueryFilter, Slide, spatial_query};
use glam::{Quat, Vec3};
use support::Lab;

#[expect(dead_code, reason = "its `main` is for people")]
#[path = "../../examples/character.rs"]
mod example;

#[test]
fn a_character_climbs_stairs_of_bricks_that_stay_put() {
    // The crate is pushed over the edge later.
    let outcome = example::play(3.2);
    println!("{outcome:?}");
    assert!((outcome.highest - 1.61).abs() < 0.03, "it is on top");
    assert!(
        outcome.moved < 1e-4,
        "a brick has moved by {} m",
        outcome.moved
    );
    assert!(outcome.airborne < 0.1);
    assert!(outcome.pushed < 0.3);
    let outcome = example::play(6.0);
    assert!(outcome.pushed > 0.5, "{outcome:?}");
}

/// A capsule that is 1.6 m high.
struct Walker {
    lab: Lab,
    shape: Collider,
    at: Pose,
    rules: MoveAndSlide,
}

impl Walker {
    fn new(lab: Lab, position: Vec3) -> Self {
        let at = Pose {
            position,
            ..Pose::default()
        };
        let mut walker = Self {
            lab,
            shape: Collider::capsule(0.3, 1.0),
            at,
            rules: MoveAndSlide::default(),
        };
        walker.lab.step();
        walker
    }

    fn go(&mut self, way: Vec3) -> Slide {
        let slide = self.ask(way).unwrap();
        self.at.position = slide.position;
        slide
    }

    fn ask(&mut self, way: Vec3) -> Result<Slide, QueryError> {
        let Self {
            lab,
            shape,
            at,
            rules,
        } = self;
        spatial_query(&mut lab.world, |query| {
            query.move_and_slide(shape, *at, way, rules, &QueryFilter::default())
        })
    }
}

fn fixed(lab: &mut Lab, size: Vec3, at: Transform) -> Entity {
    lab.spawn((
        RigidBody::Static,
        Collider::cuboid(size.x, size.y, size.z),
        at,
    ))
}

#[test]
fn slopes_are_climbed_up_to_the_limit() {
    for (angle, climbs) in [(0.3f32, true), (0.7, true), (0.9, false), (1.2, false)] {
        let mut lab = Lab::new();
        lab.ground();
        let at =
            Transform::from_rotation(Quat::from_rotation_z(angle)).with_translation(Vec3::X * 2.0);
        fixed(&mut lab, Vec3::new(20.0, 1.0, 4.0), at);
        let mut walker = Walker::new(lab, Vec3::new(-1.0, 0.81, 0.0));
        let mut slide = walker.go(Vec3::ZERO);
        for _ in 0..120 {
            slide = walker.go(Vec3::new(0.04, -0.02, 0.0));
        }
        assert_eq!(
            slide.position.y > 1.5,
            climbs,
            "{angle}: {}",
            slide.position
        );
        assert!(slide.ground.is_some(), "{angle}");
        // Down again, it keeps to the ground.
        for _ in 0..60 {
            slide = walker.go(Vec3::X * -0.04);
            assert!(slide.ground.is_some(), "{angle}: {}", slide.position);
        }
    }
}

#[test]
fn a_step_that_is_too_high_or_too_narrow_is_a_wall() {
    for (height, climbs) in [(0.1, true), (0.28, true), (0.4, false)] {
        let mut lab = Lab::new();
        lab.ground();
        fixed(
            &mut lab,
            Vec3::new(4.0, 2.0 * height, 4.0),
            Transform::from_xyz(3.0, 0.0, 0.0),
        );
        let mut walker = Walker::new(lab, Vec3::new(0.0, 0.81, 0.0));
        for _ in 0..60 {
            walker.go(Vec3::new(0.03, -0.005, 0.0));
        }
        let expected = if climbs { height } else { 0.0 };
        assert!(
            (walker.at.position.y - 0.81 - expected).abs() < 0.02,
            "{height}: {}",
            walker.at.position
        );
        assert_eq!(walker.at.position.x > 1.0, climbs);
    }
}

#[test]
fn a_corner_stops_it_and_a_gap_lets_it_through() {
    let mut lab = Lab::new();
    lab.ground();
    fixed(
        &mut lab,
        Vec3::new(1.0, 4.0, 8.0),
        Transform::from_xyz(2.0, 0.0, 0.0),
    );
    fixed(
        &mut lab,
        Vec3::new(8.0, 4.0, 1.0),
        Transform::from_xyz(0.0, 0.0, 2.0),
    );
    let mut walker = Walker::new(lab, Vec3::new(0.0, 0.81, 0.0));
    for _ in 0..120 {
        walker.go(Vec3::new(0.05, -0.01, 0.03));
    }
    let at = walker.at.position;
    assert!(at.distance(Vec3::new(1.19, 0.81, 1.19)) < 0.02, "{at}");
    // It is pushed out of a body that it is put into.
    walker.at.position.x = 1.4;
    let slide = walker.go(Vec3::ZERO);
    assert!(slide.position.x < 1.2, "{}", slide.position);
}

#[test]
fn a_platform_carries_it() {
    let mut lab = Lab::new();
    let platform = lab.spawn((
        RigidBody::Kinematic,
        Collider::cuboid(2.0, 0.2, 2.0),
        Velocity {
            linear: Vec3::new(1.0, 0.5, 0.0),
            angular: Vec3::Y * 0.5,
        },
    ));
    let mut walker = Walker::new(lab, Vec3::new(0.3, 0.92, 0.0));
    let mut slide = walker.go(Vec3::ZERO);
    for _ in 0..120 {
        walker.lab.step();
        let ground = slide.ground.expect("it stands");
        assert_eq!(ground.entity, platform);
        slide = walker.go(ground.velocity * walker.lab.dt);
    }
    let local = walker
        .lab
        .pose(platform)
        .inverse_transform_point(walker.at.position);
    assert!((local.with_y(0.0).length() - 0.3).abs() < 0.03, "{local}");
    assert!((local.y - 0.91).abs() < 0.03, "{local}");
}

#[test]
fn invalid_questions_have_answers_that_say_why() {
    let mut walker = Walker::new(Lab::new(), Vec3::ZERO);
    assert!(
        walker
            .ask(Vec3::NAN)
            .unwrap_err()
            .to_string()
            .contains("translation")
    );
    walker.rules.margin = -1.0;
    assert!(walker.ask(Vec3::X).unwrap_err().to_string().contains("-1"));
}

/// Loose columns of eight bricks side by side, and a crate on them that is pushed along by `push` N. Returns how far a brick moves, and how
/// far from its place it is when the crate has come to rest, m.
fn columns_under_a_crate(push: f32) -> [f32; 2] {
    let mut lab = Lab::new();
    lab.ground();
    let mut bricks = Vec::new();
    for (column, course) in (0..8).flat_map(|column| (0..8).map(move |course| (column, course))) {
        let at = Vec3::new(0.4 * column as f32, 0.2 * course as f32 + 0.1, 0.0);
        bricks.push(lab.body(Collider::cuboid(0.4, 0.2, 1.5), at));
    }
    let crate_at = Vec3::new(0.4, 1.85, 0.0);
    let pushed = lab.body(Collider::cuboid(0.5, 0.5, 0.5), crate_at);
    lab.world.entity_mut(pushed).insert(Density(400.0));
    lab.run(1.0);
    let put: Vec<Vec3> = bricks.iter().map(|&brick| lab.position(brick)).collect();
    let (mut most, mut now) = (0f32, 0f32);
    for _ in 0..240 {
        let force = match lab.position(pushed).x < 2.4 {
            true => Vec3::X * push,
            false => Vec3::ZERO,
        };
        lab.world.entity_mut(pushed).insert(ExternalForce {
            force,
            ..ExternalForce::default()
        });
        lab.step();
        let moved = bricks.iter().zip(&put);
        let moved = moved.map(|(&brick, put)| lab.position(brick).distance(*put));
        now = moved.fold(0.0, f32::max);
        most = most.max(now);
    }
    [most, now]
}

/// The friction of a crate of 50 kg is 245 N on top of columns of 1.6 m, which lean on the springs of their contacts. The last one, which
/// leans on no other, moves by 4.0 mm, and comes back when the crate is gone.
#[test]
fn columns_lean_under_a_crate_that_slides_and_come_back() {
    let [still, _] = columns_under_a_crate(0.0);
    assert!(still < 1e-6, "{still} m without a push");
    let [most, end] = columns_under_a_crate(320.0);
    println!("{} mm, and {} mm in the end", 1e3 * most, 1e3 * end);
    assert!(most < 6e-3, "{most} m");
    assert!(end < 5e-4, "{end} m in the end");
}
