//! Solving a problem of points, and storing its impulses.

use crate::pair::{ContactImpulses, Impulse, Lists, Manifold, PatchImpulse, PointFriction, fit};
use crate::solver::{
    Body, GrabConstraint, JointConstraint, PointProblem, PointSolver, SolveReport,
};
use crate::warm_start::{PointRows, SolveContext};

impl PointRows {
    pub(super) fn solve(
        &mut self,
        solver: &dyn PointSolver,
        bodies: &mut [Body],
        grabs: &mut [GrabConstraint],
        joints: &mut [JointConstraint],
        (effort, context): (f32, &SolveContext),
    ) -> SolveReport {
        // As for contacts, a force of the last step continues no longer than that step took.
        let continues = context.time.carried() / context.time.dt;
        for joint in &mut *joints {
            joint.forces = joint.forces.map(|force| continues * force);
        }
        let mut problem = PointProblem {
            bodies,
            constraints: &mut self.constraints,
            grabs,
            joints,
            dt: context.time.dt,
            max_recent_dt: context.time.max_recent_dt,
            effort,
            free_merit: 0.0,
            record_history: context.solver.record_history,
        };
        problem.warm_start(solver.warm_start());
        let report = solver.solve(&mut problem);
        for joint in problem.joints.iter_mut() {
            joint.turn_on(problem.bodies, problem.dt);
        }
        report
    }

    pub(super) fn store(
        &self,
        contact: usize,
        manifold: &Manifold,
        to: &mut ContactImpulses,
        dt: f32,
    ) -> bool {
        let lists = Lists {
            impulses: Some((&mut *to, true)),
            ..Default::default()
        };
        fit(manifold, lists);
        let ContactImpulses {
            points,
            friction,
            patches,
            ..
        } = to;
        // Only patch solvers fill these.
        patches.fill(PatchImpulse::default());
        let mut solved = self.constraints[self.points_of(contact)].iter();
        let numbers = manifold.patches_with_points();
        for i in numbers.flat_map(|(.., range)| range) {
            let Some(constraint) = solved.next() else {
                return false;
            };
            let (normal, tangential) = (constraint.impulse.x, constraint.impulse.with_x(0.0));
            let tangential = constraint.world(tangential);
            points[i] = Impulse {
                normal,
                normal_force: normal / dt,
                rest_force: 0.0,
            };
            friction[i] = PointFriction {
                tangential,
                friction_force: tangential / dt,
            };
        }
        solved.next().is_none()
    }
}
