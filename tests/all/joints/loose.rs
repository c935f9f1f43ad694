//! Structures with joints that stand on loose bodies.

use super::body;
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use support::Lab;

/// Steps of 60, 30 and 10 Hz, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// Where the legs of a table stand, m.
const FEET: [(f32, f32); 4] = [(-0.9, -0.9), (-0.9, 0.9), (0.9, -0.9), (0.9, 0.9)];

/// A top of a ton on four legs of a kilogram, whose feet are this high above the ground, m.
fn table(lab: &mut Lab, height: f32) -> Vec<Entity> {
    let top = Vec3::Y * (height + 0.9);
    let top = body(lab, Collider::cuboid(2.0, 0.2, 2.0), 1000.0, top);
    let mut bodies = vec![top];
    for (x, z) in FEET {
        let leg = Vec3::new(x, height + 0.4, z);
        let leg = body(lab, Collider::cuboid(0.1, 0.8, 0.1), 1.0, leg);
        let foot = Vec3::new(x, height + 0.8, z);
        lab.spawn(FixedJoint::new(top, leg).with_anchor(foot));
        bodies.push(leg);
    }
    bodies
}

/// Loose bricks of 12.8 kg under each foot, in columns of so many, from this height, m.
fn columns(lab: &mut Lab, courses: usize, height: f32) -> Vec<Entity> {
    let mut bricks = Vec::new();
    for (x, z) in FEET {
        for course in 0..courses {
            let at = Vec3::new(x, height + 0.1 + 0.2 * course as f32, z);
            bricks.push(body(lab, Collider::cuboid(0.4, 0.2, 0.4), 12.8, at));
        }
    }
    bricks
}

/// Two bricks under each foot, on one that lies across them.
fn pairs(lab: &mut Lab) -> Vec<Entity> {
    let mut bricks = columns(lab, 1, 0.0);
    for (x, z) in FEET {
        for side in [-0.1, 0.1] {
            let at = Vec3::new(x + side, 0.3, z);
            bricks.push(body(lab, Collider::cuboid(0.2, 0.2, 0.4), 6.4, at));
        }
    }
    bricks
}

/// The speed of the fastest body, m/s or rad/s.
fn fastest(lab: &Lab, bodies: &[Entity]) -> f32 {
    let speed = |&body: &Entity| {
        let Velocity { linear, angular } = lab.velocity(body);
        linear.length().max(angular.length())
    };
    bodies.iter().map(speed).fold(0.0, f32::max)
}

/// Builds bodies in an empty world, which must be at rest after so many steps and not have moved by 0.1 mm.
fn rests(what: &str, steps: usize, build: impl Fn(&mut Lab) -> Vec<Entity>) {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let bodies = build(&mut lab);
        let places: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
        let (mut most, mut late, mut furthest, mut moving) = (0f32, 0f32, 0f32, 0);
        for step in 0..(3.0 / dt) as usize {
            lab.step();
            let speed = fastest(&lab, &bodies);
            most = most.max(speed);
            if speed > 1e-5 {
                moving = step + 1;
            }
            if step >= steps {
                late = late.max(speed);
            }
            let moved = bodies.iter().zip(&places);
            let moved = moved.map(|(&body, was)| lab.position(body).distance(*was));
            furthest = moved.fold(furthest, f32::max);
        }
        println!(
            "{what}, {dt}: fastest {} mm/s, moving for {moving} steps, then {} mm/s, moves by {} mm",
            1e3 * most,
            1e3 * late,
            1e3 * furthest
        );
        assert!(late < 1e-5, "{what}, {dt}: {} mm/s", 1e3 * late);
        assert!(furthest < 1e-4, "{what}, {dt}: {} mm", 1e3 * furthest);
    }
}

#[test]
fn a_table_on_loose_bricks_rests_where_it_is_placed() {
    for courses in [1, 3] {
        rests(&format!("columns of {courses}"), 3, |lab| {
            let mut bodies = columns(lab, courses, 0.0);
            bodies.extend(table(lab, 0.2 * courses as f32));
            bodies
        });
    }
    rests("pairs of bricks", 3, |lab| {
        let mut bodies = pairs(lab);
        bodies.extend(table(lab, 0.4));
        bodies
    });
}

/// Each table bears those above it, through loose bricks between them.
#[test]
fn tables_on_bricks_on_tables_rest_where_they_are_placed() {
    rests("three tables", 12, |lab| {
        let mut bodies = Vec::new();
        for floor in 0..3 {
            let height = 1.2 * floor as f32;
            bodies.extend(columns(lab, 1, height));
            bodies.extend(table(lab, height + 0.2));
        }
        bodies
    });
}

/// Bricks that lie there already carry it as soon as it is placed on them.
#[test]
fn a_table_that_is_placed_on_bricks_at_rest_rests() {
    rests("bricks at rest", 3, |lab| {
        let mut bodies = columns(lab, 3, 0.0);
        lab.run(1.0);
        bodies.extend(table(lab, 0.6));
        bodies
    });
}

/// A mortared beam on loose columns.
#[test]
fn a_bonded_beam_on_loose_columns_rests_where_it_is_placed() {
    rests("beam", 3, |lab| {
        let mut bodies = Vec::new();
        for x in [-1.6, 1.6] {
            for course in 0..3 {
                let at = Vec3::new(x, 0.1 + 0.2 * course as f32, 0.0);
                bodies.push(body(lab, Collider::cuboid(0.4, 0.2, 0.4), 64.0, at));
            }
        }
        let mut last = None;
        for i in 0..9 {
            let at = Vec3::new(-1.6 + 0.4 * i as f32, 0.7, 0.0);
            let brick = body(lab, Collider::cuboid(0.4, 0.2, 0.4), 64.0, at);
            if let Some(last) = last {
                lab.spawn(FixedJoint::new(last, brick).with_anchor(at - Vec3::X * 0.2));
            }
            last = Some(brick);
            bodies.push(brick);
        }
        bodies
    });
}
