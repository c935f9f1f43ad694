use super::*;
use crate::Memory;
use crate::lanes::F32x4;
use crate::patches::soft_step::masonry::{DT, G, Masonry};
use crate::patches::soft_step::sweeps::load_statistics::LoadStatistics;
use glam::Vec3;

impl Masonry {
    /// Returns whether some loads were new.
    fn start(&mut self) -> bool {
        let mut memory = Memory::default();
        let mut problem = self.problem(&mut memory);
        let mut body_loads = Vec::new();
        LoadStatistics::of(&problem, &mut body_loads);
        cold_start::<F32x4>(&mut problem, &body_loads)
    }

    /// Starts it at rest. Returns whether handing down was enough.
    fn start_at_rest(&mut self) -> bool {
        let mut memory = Memory::default();
        let mut problem = self.problem(&mut memory);
        let mut body_loads = Vec::new();
        LoadStatistics::of(&problem, &mut body_loads);
        start_at_rest(&mut problem, &body_loads).is_none()
    }

    /// The largest remaining acceleration, as a share of gravity; rotations count on an arm of a metre.
    fn unbalanced(&self) -> f32 {
        let mut bodies = self.bodies.clone();
        for patch in &self.patches {
            let mut push = |impulse: Vec3, offset: Vec3| {
                for (side, impulse) in [impulse, -impulse].into_iter().enumerate() {
                    bodies[patch.bodies[side] as usize].apply(impulse, patch.arms[side] + offset);
                }
            };
            push(patch.friction_impulse, Vec3::ZERO);
            for point in &self.points[patch.range()] {
                push(point.normal_impulse * patch.normal, point.offset);
            }
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let body = &mut bodies[patch.bodies[side] as usize];
                body.angular +=
                    sign * (body.inverse_inertia * (patch.twist_impulse * patch.normal));
            }
        }
        let speed = |body: &Body| body.linear.length().max(body.angular.length());
        bodies.iter().map(speed).fold(0.0, f32::max) / (G * DT)
    }

    /// Asserts that the impulses of a cold start keep the structure still, that contacts can give them, and that they are the loads at
    /// rest.
    #[track_caller]
    fn rests(mut self) {
        self.start();
        self.is_at_rest();
    }

    #[track_caller]
    fn is_at_rest(&self) {
        let unbalanced = self.unbalanced();
        println!("{unbalanced:e} of gravity is left");
        assert!(unbalanced < 0.01, "{unbalanced} of gravity is left");
        for patch in &self.patches {
            let points = &self.points[patch.range()];
            let carried: f32 = points.iter().map(|point| point.normal_impulse).sum();
            assert!(
                points
                    .iter()
                    .all(|p| p.normal_impulse >= 0.0 && p.rest_impulse == p.normal_impulse)
            );
            assert!(patch.friction_impulse.length() <= 1.001 * patch.friction * carried);
        }
    }
}

/// Nothing is to be handed down then, and it would be tried in every step until the load at rest has followed.
#[test]
fn a_load_at_rest_that_pushes_no_longer_does_not_count_as_removed() {
    let mut stack = Masonry::stack(3, 0.0);
    assert!(stack.start() && !stack.start());
    let top = stack.patches.len() - 1;
    let point = stack.patches[top].range().start;
    stack.points[point].rest_impulse *= 100.0;
    assert!(!stack.start(), "the supports push as before");
    stack.points[point].normal_impulse *= 100.0;
    assert!(stack.start(), "the supports would throw the cube");
}

#[test]
fn a_leaning_stack_is_in_balance_from_the_start() {
    for n in [8, 20] {
        for share in [0.0, 0.5, 0.98] {
            Masonry::stack(n, share * (1.0 / n as f32).atan()).rests();
        }
    }
}

#[test]
fn a_leaning_wall_is_in_balance_from_the_start() {
    for share in [0.0, 0.5, 0.95] {
        Masonry::wall(20, 10, share * 0.1f32.atan()).rests();
    }
}

#[test]
fn an_arch_is_in_balance_from_the_start() {
    for degrees in [0.0f32, 5.0, 15.0] {
        Masonry::arch(15, degrees.to_radians()).rests();
    }
}

#[test]
fn a_wall_at_rest_needs_no_search() {
    let mut wall = Masonry::wall(20, 10, 0.0);
    assert!(wall.start_at_rest());
    wall.is_at_rest();
    assert!(wall.unbalanced() < STILL_MOTION);
    assert!(!Masonry::arch(15, 0.0).start_at_rest());
}

/// A block of 1 × 0.5 × 0.5 m in a channel along x that it touches below and on both sides.
fn tongue(tilt: f32) -> Masonry {
    let mut masonry = Masonry::new(tilt, Vec3::X);
    let tongue = masonry.block(Vec3::Y * 0.25, Vec3::new(1.0, 0.5, 0.5), 0.0);
    masonry.bed([tongue, 0], Vec3::ZERO, 0.5, 0.25);
    for z in [Vec3::Z, Vec3::NEG_Z] {
        let middle = 0.25 * (Vec3::Y - z);
        masonry.joint([tongue, 0], middle, z, [0.5 * Vec3::X, 0.25 * Vec3::Y]);
    }
    masonry
}

/// Friction of 0.9 holds the tongue up to 42°. Beyond that only its sides could hold it, and nothing presses on them.
#[test]
fn a_tongue_is_not_squeezed_by_its_groove() {
    for (degrees, stands) in [(30.0f32, true), (40.0, true), (44.0, false), (54.0, false)] {
        let mut masonry = tongue(degrees.to_radians());
        masonry.start();
        let unbalanced = masonry.unbalanced();
        assert_eq!(
            unbalanced < 0.01,
            stands,
            "at {degrees}° {unbalanced} of gravity is left"
        );
        let sides = masonry.points[4..].iter().map(|point| point.normal_impulse);
        let squeezed = sides.sum::<f32>() / (250.0 * G * DT);
        assert!(
            squeezed < 0.01,
            "at {degrees}° its sides carry {squeezed} of its weight"
        );
    }
}

/// The weight of the brick goes down to the ground, and nothing else changes.
#[test]
fn a_brick_put_on_a_stack_is_carried_by_all_below() {
    let mut masonry = Masonry::stack(5, 0.05);
    masonry.start();
    let before = masonry.points.clone();
    let cube = masonry.block(Vec3::Y * 5.5, Vec3::ONE, 0.0);
    masonry.bed([cube, cube - 1], Vec3::Y * 5.0, 0.5, 0.5);
    masonry.start();
    let unbalanced = masonry.unbalanced();
    assert!(unbalanced < 0.01, "{unbalanced} of gravity is left");
    let weight = 1e3 * G * DT * 0.05f32.cos();
    for points in [0..4, 16..20]
        .map(|range| range.map(|i| masonry.points[i].rest_impulse - before[i].rest_impulse))
    {
        let more: f32 = points.sum();
        assert!(
            (more / weight - 1.0).abs() < 0.01,
            "{more} N·s instead of {weight}"
        );
    }
}

#[test]
fn falling_and_hanging_bodies_hand_nothing_down() {
    let mut thrown = Masonry::stack(2, 0.0);
    thrown.bodies[2].start[0] = -Vec3::Y;
    thrown.bodies[2].linear -= Vec3::Y;
    let mut hanging = Masonry::stack(2, 0.0);
    hanging.points[..4]
        .iter_mut()
        .for_each(|point| point.separation = 1.0);
    for mut masonry in [thrown, hanging] {
        masonry.start();
        assert!(
            masonry.points[4..]
                .iter()
                .all(|point| point.rest_impulse == 0.0)
        );
    }
}

/// Round bodies have no loads at rest and still weigh. Their supports have lost no load, although their current impulses shake and are
/// smaller than the loads at rest.
#[test]
fn supports_of_round_bodies_keep_their_loads() {
    let mut masonry = Masonry::stack(4, 0.0);
    masonry.start();
    for point in &mut masonry.points[4..] {
        point.rest_impulse = 0.0;
        point.normal_impulse *= 0.9;
    }
    let before = masonry.points.clone();
    masonry.start();
    for (point, before) in masonry.points.iter().zip(before) {
        assert_eq!(
            (point.rest_impulse, point.normal_impulse),
            (before.rest_impulse, before.normal_impulse)
        );
    }
}
