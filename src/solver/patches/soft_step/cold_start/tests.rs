use super::*;
use crate::solver::lanes::F32x4;
use crate::solver::{Memory, PatchConstraint, PatchPoint};
use glam::{Mat3, Quat, Vec3};
use std::f32::consts::PI;

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

/// Blocks on something that nothing moves, which is body 0.
struct Masonry {
    bodies: Vec<Body>,
    centers: Vec<Vec3>,
    patches: Vec<PatchConstraint>,
    points: Vec<PatchPoint>,
    gravity: Vec3,
}

impl Masonry {
    /// On a slope of this angle towards there, rad.
    fn new(tilt: f32, towards: Vec3) -> Self {
        Self {
            bodies: vec![Body::default()],
            centers: vec![Vec3::ZERO],
            patches: Vec::new(),
            points: Vec::new(),
            gravity: G * (tilt.sin() * towards - tilt.cos() * Vec3::Y),
        }
    }

    /// Of 1000 kg/m³ and the inertia of a cuboid.
    fn block(&mut self, center: Vec3, size: Vec3, turn: f32) -> usize {
        let mass = 1e3 * size.element_product();
        let square = size * size;
        let inertia = mass / 12.0 * (Vec3::splat(square.element_sum()) - square);
        let rotation = Mat3::from_quat(Quat::from_rotation_z(turn));
        self.bodies.push(Body {
            linear: self.gravity * DT,
            inverse_mass: 1.0 / mass,
            inverse_inertia: rotation * Mat3::from_diagonal(inertia.recip()) * rotation.transpose(),
            ..Default::default()
        });
        self.centers.push(center);
        self.bodies.len() - 1
    }

    /// Two faces that meet there in a rectangle with these two half sides.
    fn joint(&mut self, [a, b]: [usize; 2], center: Vec3, normal: Vec3, half: [Vec3; 2]) {
        self.patches.push(PatchConstraint {
            bodies: [a as u32, b as u32],
            normal,
            arms: [center - self.centers[a], center - self.centers[b]],
            friction: 0.9,
            first: self.points.len() as u32,
            count: 4,
            ..Default::default()
        });
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
            self.points.push(PatchPoint {
                offset: x * half[0] + y * half[1],
                ..Default::default()
            });
        }
    }

    /// Cubes of 1 m.
    fn stack(n: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::X);
        for i in 0..n {
            let cube = masonry.block(Vec3::Y * (i as f32 + 0.5), Vec3::ONE, 0.0);
            masonry.bed([cube, cube - 1], Vec3::Y * i as f32, 0.5, 0.5);
        }
        masonry
    }

    fn bed(&mut self, bodies: [usize; 2], center: Vec3, half_length: f32, half_depth: f32) {
        let half = [half_length * Vec3::X, half_depth * Vec3::Z];
        self.joint(bodies, center, Vec3::Y, half);
    }

    /// Bricks of 1 × ½ × ½ m in a stretcher bond that steps in at both ends, tilted across.
    fn wall(width: usize, courses: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::Z);
        let mut below = Vec::new();
        for course in 0..courses {
            let y = 0.5 * course as f32;
            let bricks: Vec<usize> = (0..width - course)
                .map(|i| {
                    let x = i as f32 + 0.5 * course as f32;
                    masonry.block(Vec3::new(x, y + 0.25, 0.0), Vec3::new(1.0, 0.5, 0.5), 0.0)
                })
                .collect();
            for (i, &brick) in bricks.iter().enumerate() {
                let x = i as f32 + 0.5 * course as f32;
                if course == 0 {
                    masonry.bed([brick, 0], Vec3::new(x, y, 0.0), 0.5, 0.25);
                } else {
                    for (side, carrier) in [(-0.25, below[i]), (0.25, below[i + 1])] {
                        masonry.bed([brick, carrier], Vec3::new(x + side, y, 0.0), 0.25, 0.25);
                    }
                }
            }
            below = bricks;
        }
        masonry
    }

    /// A half circle of a mean radius of 3 m, 0.6 m thick.
    fn arch(n: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::X);
        let angle = PI / n as f32;
        let mut last = 0;
        for i in 0..=n {
            let at = i as f32 * angle;
            let [out, along] = [Vec3::X, Vec3::Y].map(|v| Quat::from_rotation_z(at) * v);
            let next = if i == n {
                0
            } else {
                let middle = at + 0.5 * angle;
                let center = 3.0 * Vec3::new(middle.cos(), middle.sin(), 0.0);
                masonry.block(center, Vec3::new(0.6, 3.0 * angle, 1.0), middle)
            };
            masonry.joint([next, last], 3.0 * out, along, [0.3 * out, 0.5 * Vec3::Z]);
            last = next;
        }
        masonry
    }

    fn start(&mut self) {
        cold_start::<F32x4>(&mut PatchProblem {
            bodies: &mut self.bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            dt: DT,
            longest: DT,
            gravity: self.gravity,
            max_correction_speed: 2.0,
            record_history: false,
            memory: &mut Memory::default(),
        });
    }

    /// The greatest acceleration that is left, as a share of gravity; turns on an arm of a metre.
    fn unbalanced(&self) -> f32 {
        let mut bodies = self.bodies.clone();
        for patch in &self.patches {
            let mut push = |impulse: Vec3, offset: Vec3| {
                for (side, impulse) in [impulse, -impulse].into_iter().enumerate() {
                    bodies[patch.bodies[side] as usize].apply(impulse, patch.arms[side] + offset);
                }
            };
            push(patch.warm_tangential, Vec3::ZERO);
            for point in &self.points[patch.range()] {
                push(point.warm_normal * patch.normal, point.offset);
            }
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let body = &mut bodies[patch.bodies[side] as usize];
                body.angular += sign * (body.inverse_inertia * (patch.warm_twist * patch.normal));
            }
        }
        let speed = |body: &Body| body.linear.length().max(body.angular.length());
        bodies.iter().map(speed).fold(0.0, f32::max) / (G * DT)
    }

    /// Asserts that a cold start keeps it still, with pushes and friction that contacts can give, and holds what is pushed with.
    #[track_caller]
    fn rests(mut self) {
        self.start();
        let unbalanced = self.unbalanced();
        println!("{unbalanced:e} of gravity is left");
        assert!(unbalanced < 0.01, "{unbalanced} of gravity is left");
        for patch in &self.patches {
            let points = &self.points[patch.range()];
            let carried: f32 = points.iter().map(|point| point.warm_normal).sum();
            assert!(
                points
                    .iter()
                    .all(|p| p.warm_normal >= 0.0 && p.load == p.warm_normal)
            );
            assert!(patch.warm_tangential.length() <= 1.001 * patch.friction * carried);
        }
    }
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

/// Its weight goes down to the ground, and nothing else changes.
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
    for points in [0..4, 16..20].map(|range| range.map(|i| masonry.points[i].load - before[i].load))
    {
        let more: f32 = points.sum();
        assert!(
            (more / weight - 1.0).abs() < 0.01,
            "{more} N·s instead of {weight}"
        );
    }
}

#[test]
fn what_falls_or_hangs_in_the_air_hands_nothing_down() {
    let mut thrown = Masonry::stack(2, 0.0);
    thrown.bodies[2].start[0] = -Vec3::Y;
    thrown.bodies[2].linear -= Vec3::Y;
    let mut hanging = Masonry::stack(2, 0.0);
    hanging.points[..4]
        .iter_mut()
        .for_each(|point| point.separation = 1.0);
    for mut masonry in [thrown, hanging] {
        masonry.start();
        assert!(masonry.points[4..].iter().all(|point| point.load == 0.0));
    }
}

/// What is round holds no load, and yet it weighs: what bears it has lost nothing, although its impulses of the moment, which shake,
/// come short of it.
#[test]
fn what_bears_something_round_is_not_relieved() {
    let mut masonry = Masonry::stack(4, 0.0);
    masonry.start();
    for point in &mut masonry.points[4..] {
        point.load = 0.0;
        point.warm_normal *= 0.9;
    }
    let before = masonry.points.clone();
    masonry.start();
    for (point, before) in masonry.points.iter().zip(before) {
        assert_eq!(
            (point.load, point.warm_normal),
            (before.load, before.warm_normal)
        );
    }
}
