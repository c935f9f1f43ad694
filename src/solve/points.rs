//! A problem of points: from manifolds, targets and last step's impulses, and back.

use super::Given;
use super::island::Rows;
use super::touch::Touch;
use crate::contact::{Impulse, PatchImpulse};
use crate::settings::StepTime;
use crate::solver::{Body, PointConstraint, PointInput, PointProblem, PointSolver, SolveReport};
use rayon::prelude::*;

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
        self.constraints.clear();
        if threads.share(touches.len()) {
            let touches = touches.par_iter().zip(ends);
            let constraints =
                touches.flat_map_iter(|(touch, ends)| touch.constraints(*ends, bodies, time));
            threads.run(ends.len(), || self.constraints.par_extend(constraints));
        } else {
            let touches = touches.iter().zip(ends);
            self.constraints
                .extend(touches.flat_map(|(touch, ends)| touch.constraints(*ends, bodies, time)));
        }
    }

    fn solve(
        &mut self,
        solver: &dyn PointSolver,
        bodies: &mut [Body],
        given: &Given,
    ) -> SolveReport {
        let mut problem = PointProblem {
            bodies,
            constraints: &mut self.constraints,
            dt: given.time.dt,
            free_merit: 0.0,
            record_history: given.solver.record_history,
        };
        problem.warm_start(solver.warm_start());
        solver.solve(&mut problem)
    }

    fn store(&self, touches: &mut [Touch], given: &Given) {
        let dt = given.time.dt;
        let mut solved = self.constraints.iter();
        for touch in touches {
            // They are a patch solver's.
            touch.impulses.patches.fill(PatchImpulse::default());
            for (impulse, constraint) in touch.impulses.points.iter_mut().zip(&mut solved) {
                let (normal, tangential) = (constraint.impulse.x, constraint.impulse.with_x(0.0));
                let tangential = constraint.world(tangential);
                *impulse = Impulse {
                    normal,
                    tangential,
                    warm_normal: normal / dt,
                    warm_tangential: tangential / dt,
                    load: 0.0,
                };
            }
        }
    }
}

impl Touch<'_> {
    /// The pair's contact points between the bodies at `ends` of a problem.
    fn constraints(
        &self,
        ends: [u32; 2],
        bodies: &[Body],
        time: &StepTime,
    ) -> impl Iterator<Item = PointConstraint> {
        let points = self
            .manifold
            .patches
            .iter()
            .flat_map(|patch| patch.range().map(|i| (patch.normal, i)));
        points.map(move |(normal, i)| {
            let target = self.targets.points.get(i).copied().unwrap_or_default();
            let impulse = self.impulses.points[i];
            let input = PointInput {
                bodies: ends,
                normal,
                arms: self.manifold.points[i].arms,
                friction: self.pair.friction,
                target_normal: target.normal,
                target_tangential: target.tangential,
                impulse_normal: impulse.normal_to_start_from(time),
                impulse_tangential: impulse.warm_tangential * time.carried(),
            };
            PointConstraint::prepare(&input, bodies)
        })
    }
}
