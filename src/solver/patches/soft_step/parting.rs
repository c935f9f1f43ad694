//! Bodies that lie deep in each other are moved apart, instead of being made faster.
//!
//! A spring takes an overlap back by a velocity, and what has a velocity keeps it. That is as nothing where bodies rest, and rest
//! within a millimetre. But of three hundred balls in one place each would push on its neighbours, and they on theirs: those outside
//! would leave with the sum. So where something is that deep springs see no more of an overlap than [`DEEP`], and the rest is taken back here, by positions alone:
//! at the end of a step each point that is deeper is moved apart along its normal, no faster than the fastest correction with what it has
//! come by itself, shared as impulses would be.

use super::gaps::Gaps;
use super::island::Island;
use crate::solver::lanes::{F32xN, State};
use crate::solver::{Body, PatchConstraint, PatchProblem};
use glam::{Vec3, Vec4};

/// Where something lies so deep, m. What lands hard in a heap comes nearly as deep, and springs alone take it back.
const NEEDED: f32 = 0.05;

/// What is deeper is not left to springs then, m.
const DEEP: f32 = 0.02;

/// Visits to each point.
const SWEEPS: usize = 4;

/// Nothing is moved faster than this times the fastest correction, whatever it lies in.
const FASTEST: f32 = 1.5;

/// Nor turned by more than this in a step, rad: arms are those of before.
const TURN: f32 = 0.1;

/// Whether anything lies so deep.
pub fn is_needed(gaps: &Gaps) -> bool {
    gaps.deepest < -NEEDED
}

/// No point is deeper to its spring than this, a separation, m.
pub fn deepest(gaps: &Gaps) -> f32 {
    match is_needed(gaps) {
        true => -DEEP,
        false => f32::NEG_INFINITY,
    }
}

/// A point that is to be moved apart.
struct Row {
    bodies: [usize; 2],
    normal: Vec3,
    arms: [Vec3; 2],
    /// W, 1/kg.
    response: f32,
    /// How much farther it shall come than it has come in this step, m.
    way: f32,
    /// What moves it, kg·m.
    given: f32,
}

impl Row {
    /// The points of a patch that lie deep, each as fast as `fastest` m in the step.
    fn of<'a>(
        problem: &'a PatchProblem,
        patch: &'a PatchConstraint,
        moved: &'a [State],
        fastest: f32,
    ) -> impl Iterator<Item = Self> + 'a {
        let points = &problem.points[patch.range()];
        points.iter().filter_map(move |point| {
            let deep = -point.separation - DEEP;
            let bodies = patch.bodies.map(|body| body as usize);
            let arms = patch.arms.map(|arm| arm + point.offset);
            let response = |side: usize| {
                let body: &Body = &problem.bodies[bodies[side]];
                body.response(patch.normal, arms[side])
            };
            let response = response(0) + response(1);
            let came = |side: usize| {
                let [linear, angular] = moved[bodies[side]].map(Vec4::truncate);
                linear + angular.cross(arms[side])
            };
            let came = patch.normal.dot(came(0) - came(1));
            (deep > 0.0 && response > 0.0).then(|| Self {
                bodies,
                normal: patch.normal,
                arms,
                response,
                way: (deep.min(fastest) - came).min(fastest),
                given: 0.0,
            })
        })
    }

    /// Moves both bodies so that it comes as far as it shall.
    fn visit(&mut self, bodies: &[Body], motions: &mut [[Vec3; 2]]) {
        let at = |side: usize| {
            let [linear, angular] = motions[self.bodies[side]];
            linear + angular.cross(self.arms[side])
        };
        let lack = self.way - self.normal.dot(at(0) - at(1));
        let given = (self.given + lack / self.response).max(0.0);
        let change = (given - self.given) * self.normal;
        self.given = given;
        for (side, change) in [change, -change].into_iter().enumerate() {
            let body = self.bodies[side];
            let answer = bodies[body].answer(change, self.arms[side]);
            for (motion, change) in motions[body].iter_mut().zip(answer) {
                *motion += change;
            }
        }
    }
}

impl<L: F32xN> Island<L> {
    /// Moves what lies deep in something apart, after all sweeps.
    pub fn part(&mut self, problem: &PatchProblem) {
        let fastest = problem.max_correction_speed * problem.dt;
        let patches = problem.patches.iter();
        let rows = patches.flat_map(|patch| Row::of(problem, patch, &self.motions, fastest));
        let mut rows: Vec<Row> = rows.collect();
        let mut motions = vec![[Vec3::ZERO; 2]; problem.bodies.len()];
        for _ in 0..SWEEPS {
            for row in &mut rows {
                row.visit(problem.bodies, &mut motions);
            }
        }
        for (motion, [linear, angular]) in self.motions.iter_mut().zip(motions) {
            motion[0] += linear.clamp_length_max(FASTEST * fastest).extend(0.0);
            motion[1] += angular.clamp_length_max(TURN).extend(0.0);
        }
    }
}
