//! Solving a problem of patches, and storing its impulses.

use crate::pair::{ContactImpulses, Impulse, Manifold, PatchImpulse};
use crate::solver::{
    Body, GrabConstraint, JointConstraint, PatchConstraint, PatchPoint, PatchProblem, PatchSolver,
    SMALL_ISLAND_PATCHES, SoftStep, SolveReport, patches,
};
use crate::warm_start::{Island, LARGE_ISLAND_FACTOR, PatchRows, Rows, SolveContext};

impl PatchRows {
    pub(super) fn solve(
        &mut self,
        solver: &dyn PatchSolver,
        bodies: &mut [Body],
        grabs: &mut [GrabConstraint],
        joints: &mut [JointConstraint],
        (effort, broke, context): (f32, bool, &SolveContext),
    ) -> SolveReport {
        let problem = problem(self, bodies, grabs, joints, context);
        solver.solve(&mut PatchProblem {
            effort,
            broke,
            ..problem
        })
    }

    pub(super) fn is_small(&self, contacts: usize) -> bool {
        contacts < SMALL_ISLAND_PATCHES && self.patches.len() < SMALL_ISLAND_PATCHES
    }

    /// Solves several small islands without grabs and joints, with the usual effort.
    pub(super) fn solve_each<'a>(
        solver: &dyn PatchSolver,
        islands: impl Iterator<Item = (&'a mut Self, &'a mut [Body])>,
        context: &'a SolveContext,
    ) -> Vec<SolveReport> {
        let problems =
            islands.map(|(rows, bodies)| problem(rows, bodies, &mut [], &mut [], context));
        let mut problems: Vec<PatchProblem> = problems.collect();
        solver.solve_each(&mut problems)
    }

    pub(super) fn store(
        &self,
        contact: usize,
        manifold: &Manifold,
        to: &mut ContactImpulses,
        dt: f32,
    ) -> bool {
        // Only point solvers fill this list.
        to.friction.clear();
        let mut solved = self.patches[self.patches_of(contact)].iter();
        for (i, _, range) in manifold.patches_with_points() {
            let Some(found) = solved.next() else {
                return false;
            };
            if range.len() != found.count as usize {
                return false;
            }
            let points = &self.points[found.range()];
            let (patch, impulses) = (&mut to.patches[i], &mut to.points[range]);
            store(found, points, patch, impulses, dt);
        }
        solved.next().is_none()
    }
}

/// Computes static loads of the contacts and joints of an island instead of a solve, and sets the impulses of the step to these loads over
/// the whole step. Returns false if a result is not finite.
pub(crate) fn settle(island: &mut Island, context: &SolveContext) -> bool {
    let Rows::Patches(rows) = &mut island.rows else {
        return false;
    };
    let (bodies, joints) = (&mut island.bodies, &mut island.joints);
    if joints.is_empty() {
        patches::settle(&mut problem(rows, bodies, &mut [], &mut [], context));
    } else {
        settle_joined(rows, bodies, joints, context);
    }
    let finite = |joint: &JointConstraint| joint.forces.iter().all(|force| force.is_finite());
    joints.iter().all(finite) && keep_for_step(rows, context)
}

/// Number of solves in which the loads of an island with joints settle. A table has them after the first.
const SETTLING_SOLVES: usize = 60;

/// Solves an island with joints again and again without moving it, until contacts and joints bear it, whatever the solver of awake islands.
fn settle_joined(
    rows: &mut PatchRows,
    bodies: &mut [Body],
    joints: &mut [JointConstraint],
    context: &SolveContext,
) {
    let start = bodies.to_vec();
    for _ in 0..SETTLING_SOLVES {
        bodies.copy_from_slice(&start);
        let exact = SoftStep {
            sweeps_joints: false,
            ..Default::default()
        };
        exact.solve(&mut problem(rows, bodies, &mut [], joints, context));
    }
}

/// Sets the impulses of all substeps, because later substeps leave these contacts as they are. Returns false if one is not finite.
fn keep_for_step(rows: &mut PatchRows, context: &SolveContext) -> bool {
    let whole = context.time.substeps as f32;
    for patch in &mut rows.patches {
        patch.tangential = whole * patch.friction_impulse;
    }
    for point in &mut rows.points {
        point.normal = whole * point.normal_impulse;
    }
    let finite = |patch: &PatchConstraint| {
        patch.friction_impulse.is_finite() && patch.twist_impulse.is_finite()
    };
    rows.patches.iter().all(finite) && rows.points.iter().all(|point| point.normal.is_finite())
}

fn problem<'a>(
    rows: &'a mut PatchRows,
    bodies: &'a mut [Body],
    grabs: &'a mut [GrabConstraint],
    joints: &'a mut [JointConstraint],
    context: &SolveContext,
) -> PatchProblem<'a> {
    let threads = match context
        .threads
        .runs_in_parallel(rows.points.len() / LARGE_ISLAND_FACTOR)
    {
        true => context.threads.count(),
        false => 1,
    };
    PatchProblem {
        bodies,
        patches: &mut rows.patches,
        points: &mut rows.points,
        grabs,
        joints,
        surfaces: &rows.surfaces,
        dt: context.time.dt,
        max_recent_dt: context.time.max_recent_dt,
        gravity: context.gravity.0,
        effort: 1.0,
        broke: false,
        max_correction_speed: context.stabilization.max_correction_speed,
        settling: context.sleeping.settling(),
        stays_awake: context.sleeping.is_off(),
        record_history: context.solver.record_history,
        threads,
        memory: &mut rows.memory,
    }
}

fn store(
    found: &PatchConstraint,
    points: &[PatchPoint],
    kept: &mut PatchImpulse,
    impulses: &mut [Impulse],
    dt: f32,
) {
    let rate = 1.0 / dt;
    *kept = PatchImpulse {
        tangential: found.tangential,
        friction_force: found.friction_impulse * rate,
        twist_moment: found.twist_impulse * rate,
        rolling_moment: found.rolling_impulse * rate,
        rest_friction_force: found.rest_friction_impulse * rate,
        rest_twist_moment: found.rest_twist_impulse * rate,
        dragged: found.dragged,
    };
    for (impulse, point) in impulses.iter_mut().zip(points) {
        *impulse = Impulse {
            normal: point.normal,
            normal_force: point.normal_impulse * rate,
            rest_force: point.rest_impulse * rate,
        };
    }
}
