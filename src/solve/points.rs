//! A problem of points: from manifolds, targets and last step's impulses, and back.

use super::Given;
use super::island::Rows;
use super::touch::Touch;
use crate::contact::{ContactImpulses, Impulse, PatchImpulse, PointFriction};
use crate::settings::StepTime;
use crate::solver::{
    Body, Grip, PatchFrame, PointConstraint, PointInput, PointProblem, PointSolver, SolveReport,
};
use rayon::prelude::*;

/// Touches that one thread gathers at a time.
const SHARE: usize = 64;

#[derive(Default)]
pub(super) struct PointRows {
    constraints: Vec<PointConstraint>,
}

impl Rows for PointRows {
    type Solver = dyn PointSolver;
    const SUBSTEPS: bool = false;

    fn clear(&mut self) {
        self.constraints.clear();
    }

    fn points(&self) -> usize {
        self.constraints.len()
    }

    fn gather(&mut self, touches: &[Touch], ends: &[[u32; 2]], bodies: &[Body], given: &Given) {
        let (threads, time) = (&*given.threads, &*given.time);
        let gather = |touches: &[Touch], ends: &[[u32; 2]], to: &mut Vec<PointConstraint>| {
            for (touch, &ends) in touches.iter().zip(ends) {
                touch.gather(ends, bodies, time, to);
            }
        };
        self.constraints.clear();
        if threads.share(touches.len()) {
            let shares = touches.par_chunks(SHARE).zip(ends.par_chunks(SHARE));
            let constraints = shares.flat_map_iter(|(touches, ends)| {
                let mut constraints = Vec::new();
                gather(touches, ends, &mut constraints);
                constraints
            });
            threads.run(ends.len(), || self.constraints.par_extend(constraints));
        } else {
            gather(touches, ends, &mut self.constraints);
        }
    }

    fn solve(
        &mut self,
        solver: &dyn PointSolver,
        bodies: &mut [Body],
        grips: &mut [Grip],
        given: &Given,
    ) -> SolveReport {
        let mut problem = PointProblem {
            bodies,
            constraints: &mut self.constraints,
            grips,
            dt: given.time.dt,
            free_merit: 0.0,
            record_history: given.solver.record_history,
        };
        problem.warm_start(solver.warm_start());
        solver.solve(&mut problem)
    }

    fn is_small(_: &[Touch]) -> bool {
        false
    }

    fn solve_each(
        solver: &Self::Solver,
        islands: &mut [(&mut Self, &mut [Body])],
        given: &Given,
    ) -> Vec<SolveReport> {
        let islands = islands.iter_mut();
        islands
            .map(|(rows, bodies)| rows.solve(solver, bodies, &mut [], given))
            .collect()
    }

    fn store(&self, touches: &mut [Touch], given: &Given) {
        let dt = given.time.dt;
        let mut solved = self.constraints.iter();
        for touch in touches {
            // They are a patch solver's.
            touch.impulses.patches.fill(PatchImpulse::default());
            let ContactImpulses {
                points, friction, ..
            } = &mut *touch.impulses;
            friction.resize(points.len(), PointFriction::default());
            let numbers = touch.manifold.patches_with_points();
            let numbers = numbers.flat_map(|(.., range)| range);
            for (i, constraint) in numbers.zip(&mut solved) {
                let (impulse, friction) = (&mut points[i], &mut friction[i]);
                let (normal, tangential) = (constraint.impulse.x, constraint.impulse.with_x(0.0));
                let tangential = constraint.world(tangential);
                *impulse = Impulse {
                    normal,
                    warm_normal: normal / dt,
                    load: 0.0,
                };
                *friction = PointFriction {
                    tangential,
                    warm_tangential: tangential / dt,
                };
            }
        }
    }
}

impl Touch<'_> {
    /// Adds the pair's contact points, between the bodies at `ends` of a problem.
    fn gather(
        &self,
        ends: [u32; 2],
        bodies: &[Body],
        time: &StepTime,
        to: &mut Vec<PointConstraint>,
    ) {
        for (_, patch, range) in self.manifold.patches_with_points() {
            let frame = PatchFrame::new(ends, patch.normal, bodies);
            for i in range {
                let target = self.targets.points.get(i).copied().unwrap_or_default();
                let impulse = self.impulses.points[i];
                let friction = self.impulses.friction.get(i).copied();
                let friction = friction.unwrap_or_default();
                to.push(frame.prepare(&PointInput {
                    bodies: ends,
                    normal: patch.normal,
                    arms: self.manifold.arms(i),
                    friction: self.pair.friction,
                    target_normal: target.normal,
                    target_tangential: target.tangential,
                    impulse_normal: impulse.normal_to_start_from(time),
                    impulse_tangential: friction.warm_tangential * time.carried(),
                }));
            }
        }
    }
}
