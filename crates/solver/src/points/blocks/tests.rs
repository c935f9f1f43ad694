//! Tests blocks against the rows of [`PointConstraint`], relaxed one by one.

use super::{Blocks, Cone, Conjugate, Disc, Square};
#[cfg(target_arch = "x86_64")]
use crate::lanes::F32x8;
use crate::lanes::{F32x4, F32xN};
use crate::points::{Direction, FrictionCone, Grouping, PointInput, PointProblem};
use crate::{Body, PointConstraint};
use glam::{Mat3, Quat, Vec3};

const SWEEPS: usize = 5;

/// Bodies, the first of which is fixed, and contacts between them. Pairs touch in one to three patches of one to six points, with arms that
/// need not meet.
fn problem(rng: &mut fastrand::Rng) -> (Vec<Body>, Vec<PointConstraint>) {
    let mut bodies = vec![Body::default()];
    bodies.extend((0..30).map(|_| {
        let axes = Mat3::from_quat(Quat::from_scaled_axis(vector(rng, 3.0)));
        let inverse = Mat3::from_diagonal(vector(rng, 1.5) + 2.5);
        Body {
            linear: vector(rng, 2.0),
            angular: vector(rng, 2.0),
            inverse_mass: 0.2 + 2.0 * rng.f32(),
            inverse_inertia: axes * inverse * axes.transpose(),
            ..Default::default()
        }
    }));
    let mut constraints = Vec::new();
    for a in 1..bodies.len() as u32 {
        for b in [rng.u32(0..a), 0] {
            let friction = [0.0, 0.2, 0.8][rng.usize(0..3)];
            for _ in 0..rng.usize(1..4) {
                let normal = (vector(rng, 1.0) + 1.2 * Vec3::Y).normalize();
                for _ in 0..rng.usize(1..7) {
                    let input = PointInput {
                        bodies: [a, b],
                        normal,
                        arms: [vector(rng, 0.5), vector(rng, 0.5)],
                        friction,
                        target_normal: rng.f32() - 0.5,
                        target_tangential: vector(rng, 0.5),
                        impulse_normal: rng.f32(),
                        ..Default::default()
                    };
                    constraints.push(PointConstraint::prepare(&input, &bodies));
                }
            }
        }
    }
    (bodies, constraints)
}

fn vector(rng: &mut fastrand::Rng, size: f32) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| size * (2.0 * rng.f32() - 1.0)))
}

/// The final state of a problem, and the merits of its sweeps.
struct Solved {
    bodies: Vec<Body>,
    constraints: Vec<PointConstraint>,
    changes: Vec<f32>,
}

impl Solved {
    fn by(seed: u64, solve: impl FnOnce(&mut PointProblem) -> Vec<f32>) -> Self {
        let (mut bodies, mut constraints) = problem(&mut fastrand::Rng::with_seed(seed));
        let changes = solve(&mut PointProblem {
            bodies: &mut bodies,
            constraints: &mut constraints,
            grabs: &mut [],
            joints: &mut [],
            dt: 0.1,
            max_recent_dt: 0.1,
            effort: 1.0,
            free_merit: 1.0,
            record_history: false,
        });
        Self {
            bodies,
            constraints,
            changes,
        }
    }

    #[track_caller]
    fn must_be(&self, wanted: &Self) {
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 2e-4, "{a}, not {b}");
        for (found, wanted) in self.constraints.iter().zip(&wanted.constraints) {
            near(found.impulse, wanted.impulse);
        }
        for (found, wanted) in self.bodies.iter().zip(&wanted.bodies) {
            near(found.linear, wanted.linear);
            near(found.angular, wanted.angular);
        }
        assert_eq!(self.changes.len(), wanted.changes.len());
        for (found, wanted) in self.changes.iter().zip(&wanted.changes) {
            assert!((found - wanted).abs() < 1e-3 * wanted, "{found} {wanted}");
        }
    }
}

/// The directions of sweeps back and forth.
fn directions() -> impl Iterator<Item = Direction> {
    (0..SWEEPS).map(|k| Direction::of_sweep(k, SWEEPS))
}

/// β after each sweep, with a restart.
const BETAS: [f32; SWEEPS] = [0.0, 0.7, 0.9, 0.0, 0.4];

fn pgs<L: F32xN, C: Cone>(problem: &mut PointProblem) -> Vec<f32> {
    let mut blocks = Blocks::<L, C>::of(problem);
    let changes = directions()
        .map(|direction| blocks.sweep(direction))
        .collect();
    blocks.store(problem);
    changes
}

fn nncg<L: F32xN, C: Cone>(problem: &mut PointProblem) -> Vec<f32> {
    let mut blocks = Conjugate::<L, C>::of(problem);
    let mut changes = Vec::new();
    for (direction, beta) in directions().zip(BETAS) {
        changes.push(blocks.sweep(direction));
        blocks.turn(beta);
    }
    // One more sweep makes the steps that are postponed until a sweep comes.
    changes.push(blocks.sweep(Direction::Forwards));
    blocks.store(problem);
    changes
}

fn pgs_one_by_one(problem: &mut PointProblem, cone: FrictionCone) -> Vec<f32> {
    directions()
        .map(|direction| problem.sweep(direction, Grouping::Pair, cone))
        .collect()
}

fn nncg_one_by_one(problem: &mut PointProblem, cone: FrictionCone) -> Vec<f32> {
    let mut steps = vec![Vec3::ZERO; problem.constraints.len()];
    let mut changes = Vec::new();
    for (direction, beta) in directions().zip(BETAS) {
        let before: Vec<_> = problem.constraints.iter().map(|c| c.impulse).collect();
        changes.push(problem.sweep(direction, Grouping::Point, cone));
        for ((contact, before), p) in problem.constraints.iter_mut().zip(before).zip(&mut steps) {
            let (r, step) = (contact.impulse - before, beta * *p);
            contact.add(problem.bodies, step);
            *p = step + r;
        }
    }
    changes.push(problem.sweep(Direction::Forwards, Grouping::Point, cone));
    changes
}

fn check<L: F32xN>() {
    use FrictionCone::{Box, Circular};
    for seed in 0..20 {
        let wanted = |cone| Solved::by(seed, |p| pgs_one_by_one(p, cone));
        Solved::by(seed, pgs::<L, Disc>).must_be(&wanted(Circular));
        Solved::by(seed, pgs::<L, Square>).must_be(&wanted(Box));
        let wanted = |cone| Solved::by(seed, |p| nncg_one_by_one(p, cone));
        Solved::by(seed, nncg::<L, Disc>).must_be(&wanted(Circular));
        Solved::by(seed, nncg::<L, Square>).must_be(&wanted(Box));
    }
}

#[test]
fn four_lanes_give_the_results_of_single_rows() {
    check::<F32x4>();
}

#[cfg(target_arch = "x86_64")]
#[test]
fn eight_lanes_give_the_results_of_single_rows() {
    if F32x8::is_available() {
        check::<F32x8>();
    }
}
