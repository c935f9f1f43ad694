//! Accelerated projected gradient descent (Mazhar, Heyn, Negrut, Tasora 2015, "Using Nesterov's Method to Accelerate Multibody Dynamics
//! with Friction and Contact", ACM Transactions on Graphics 34/3).
//!
//! The impulses γ of all points minimize q(γ) = ½ γᵀ N γ + γᵀ r over the product of the friction cones, where N = Dᵀ M⁻¹ D and r is the
//! velocity of the points in free motion, less its target. This is the *cone complementarity problem*, a convex relaxation of contact with
//! Coulomb friction (Anitescu, Tasora 2010): the velocity of a point lies in the dual cone, so a point that slips at w_t also parts at μ
//! ‖w_t‖. Points that stick are not affected. A body that slides rises by Δt μ ‖w_t‖ in a step, until the correction of its distance brings
//! it down again.
//!
//! An iteration (the paper's Algorithm 2) is a projected gradient step from y, with a length of 1/L. L estimates the largest eigenvalue of
//! N: it is doubled until the step decreases q as much as it must, and multiplied by 0.9 afterwards. Then Nesterov's momentum carries y on.
//! If the step went uphill against the last one, momentum starts anew (O'Donoghue, Candès 2012). As iterations are not monotone, the one
//! with the least residual is the result.
//!
//! N is never computed. It is linear, so one pass over all points that scatters impulses to the bodies and one that gathers velocities are
//! all that an iteration costs, with momentum included. Three things differ from the paper. The decrease of q is tested by Δᵀ N Δ ≤ L ‖Δ‖²,
//! which is the same for a quadratic function and loses no digits. The residual is that of a step of 1/W for each point, W being the
//! largest element of the diagonal of N there; it can be compared with that of a first Gauss–Seidel sweep. And L is bounded by the trace of
//! N, which it reaches only by rounding.
//!
//! Joints and grabs are relaxed by Gauss–Seidel sweeps: [rounds](ROUND) of sweeps over them and of iterations over the contacts follow each
//! other. Momentum begins anew in each round.

use super::cone::project;
use drystone::settings::ContactSolver;
use drystone::solver::{
    Body, Direction, FrictionCone, Grouping, PointConstraint, PointProblem, PointSolver,
    SolveReport,
};
use glam::Vec3;
use std::sync::Arc;

/// The accelerated projected gradient solver, a point solver. Its friction cone is always circular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apgd {
    /// Maximum number of iterations.
    pub iterations: usize,
    /// Share of the last step's impulses that a solve starts from, 0..1.
    pub warm_start: f32,
    /// Residual below which a solve ends early. The default 0 means never.
    pub tolerance: f32,
}

impl Default for Apgd {
    /// As many iterations as the paper's preset has of NNCG, and no warm start.
    fn default() -> Self {
        Self {
            iterations: 75,
            warm_start: 0.0,
            tolerance: 0.0,
        }
    }
}

impl From<Apgd> for ContactSolver {
    fn from(solver: Apgd) -> Self {
        Self::Points(Arc::new(solver))
    }
}

/// Number of sweeps over joints and grabs, and then of iterations over contacts, in a round.
const ROUND: usize = 8;

/// By how much L is increased if a step was too long, and its factor afterwards (Mazhar et al. 2015, Algorithm 2).
const SHORTEN: f32 = 2.0;
const LENGTHEN: f32 = 0.9;

impl PointSolver for Apgd {
    fn name(&self) -> &str {
        "apgd"
    }

    fn problem(&self) -> Option<String> {
        if self.iterations == 0 {
            return Some("iterations is 0, and must be at least 1".into());
        }
        if !(0.0..=1.0).contains(&self.warm_start) {
            return Some(format!(
                "warm_start is {}, and must be between 0.0 and 1.0",
                self.warm_start
            ));
        }
        (!(0.0..=f32::INFINITY).contains(&self.tolerance)).then(|| {
            format!(
                "tolerance is {}, and must be between 0.0 and inf",
                self.tolerance
            )
        })
    }

    fn warm_start(&self) -> f32 {
        self.warm_start
    }

    fn solve(&self, problem: &mut PointProblem) -> SolveReport {
        let mut report = problem.report();
        let mut left = (self.iterations as f32 * problem.effort).round() as usize;
        let is_held = !(problem.joints.is_empty() && problem.grabs.is_empty());
        while left > 0 {
            let mut round = left;
            if is_held {
                round = ROUND.min(left);
                sweep_joints_and_grabs(problem, round);
            }
            left -= round;
            let (bodies, constraints) = (&mut *problem.bodies, &mut *problem.constraints);
            let ends = Descent::new(bodies, constraints).run(round, self.tolerance, &mut report);
            for (constraint, end) in constraints.iter_mut().zip(ends) {
                constraint.add(bodies, end - constraint.impulse);
            }
        }
        report
    }
}

/// Does so many Gauss–Seidel sweeps over the joints and grabs of a problem, and over no contact.
fn sweep_joints_and_grabs(problem: &mut PointProblem, sweeps: usize) {
    let mut without_contacts = PointProblem {
        bodies: &mut *problem.bodies,
        constraints: &mut [],
        grabs: &mut *problem.grabs,
        joints: &mut *problem.joints,
        dt: problem.dt,
        max_recent_dt: problem.max_recent_dt,
        effort: problem.effort,
        free_merit: problem.free_merit,
        record_history: false,
    };
    let cone = FrictionCone::Circular;
    for _ in 0..sweeps {
        without_contacts.sweep(Direction::Forwards, Grouping::Point, cone);
    }
}

/// Linear and angular velocity of a body, m/s and rad/s; or linear and angular impulse, N·s and N·m·s.
type Twist = [Vec3; 2];

/// A descent. Vectors with an entry for each point are in the frame of the point (n, t1, t2).
struct Descent<'a> {
    bodies: &'a [Body],
    constraints: &'a [PointConstraint],
    /// γ, N·s, its gradient N γ + r, m/s, and the velocities of the bodies that it causes.
    impulses: Vec<Vec3>,
    gradient: Vec<Vec3>,
    velocities: Vec<Twist>,
    /// The same of y, the point that steps start from.
    ahead: Vec<Vec3>,
    ahead_gradient: Vec<Vec3>,
    ahead_velocities: Vec<Twist>,
    /// Impulses of a step, summed for each body.
    pushes: Vec<Twist>,
    /// The next γ.
    next: Vec<Vec3>,
}

impl<'a> Descent<'a> {
    /// Starts from the impulses of the points, whose effect the velocities include.
    fn new(bodies: &'a [Body], constraints: &'a [PointConstraint]) -> Self {
        let impulses: Vec<Vec3> = constraints.iter().map(|c| c.impulse).collect();
        let velocities: Vec<Twist> = bodies.iter().map(|b| [b.linear, b.angular]).collect();
        let gradient: Vec<Vec3> = constraints
            .iter()
            .map(|c| seen(c, &velocities) - c.target)
            .collect();
        Self {
            bodies,
            constraints,
            ahead: impulses.clone(),
            ahead_gradient: gradient.clone(),
            ahead_velocities: velocities.clone(),
            pushes: vec![[Vec3::ZERO; 2]; bodies.len()],
            next: impulses.clone(),
            impulses,
            gradient,
            velocities,
        }
    }

    /// Returns the best impulses that were found.
    fn run(mut self, iterations: usize, tolerance: f32, report: &mut SolveReport) -> Vec<Vec3> {
        let steepest = self.trace();
        let mut curvature = self.first_curvature().min(steepest);
        let mut momentum = 1.0f32;
        let (mut best, mut least) = (self.impulses.clone(), f32::INFINITY);
        for _ in 0..iterations {
            loop {
                let [bent, moved] = self.step(1.0 / curvature);
                if bent <= curvature * moved || curvature >= steepest {
                    break;
                }
                curvature = (SHORTEN * curvature).min(steepest);
            }
            let (carry, went_uphill) = {
                let next = 0.5 * (momentum * (momentum * momentum + 4.0).sqrt() - momentum.powi(2));
                let carry = momentum * (1.0 - momentum) / (momentum * momentum + next);
                momentum = next;
                (carry, self.went_uphill())
            };
            let carry = if went_uphill { 0.0 } else { carry };
            if went_uphill {
                momentum = 1.0;
            }
            let merit = self.advance(carry);
            if merit < least {
                least = merit;
                best.copy_from_slice(&self.impulses);
            }
            if report.record(merit) <= tolerance {
                break;
            }
            curvature *= LENGTHEN;
        }
        best
    }

    /// The sum of the eigenvalues of N, 1/kg: no step need be shorter than its inverse.
    fn trace(&self) -> f32 {
        let sum = |c: &PointConstraint| c.diagonal.element_sum();
        self.constraints.iter().map(sum).sum()
    }

    /// ‖N d‖ / ‖d‖ for d = γ − (1, 1, 1, …), the paper's first estimate of the largest eigenvalue, 1/kg.
    fn first_curvature(&mut self) -> f32 {
        let from_ones = |impulse: Vec3| impulse - Vec3::ONE;
        self.pushes.fill([Vec3::ZERO; 2]);
        for (constraint, &impulse) in self.constraints.iter().zip(&self.impulses) {
            scatter(constraint, from_ones(impulse), &mut self.pushes);
        }
        for (push, body) in self.pushes.iter_mut().zip(self.bodies) {
            *push = answer(body, *push);
        }
        let (mut response, mut length) = (0.0, 0.0);
        for (constraint, &impulse) in self.constraints.iter().zip(&self.impulses) {
            response += seen(constraint, &self.pushes).length_squared();
            length += from_ones(impulse).length_squared();
        }
        match response > 0.0 && length > 0.0 {
            true => (response / length).sqrt(),
            false => 1.0,
        }
    }

    /// Steps from y against the gradient there by `length` (kg), and projects. Returns Δᵀ N Δ and ‖Δ‖² of the step.
    fn step(&mut self, length: f32) -> [f32; 2] {
        self.pushes.fill([Vec3::ZERO; 2]);
        let mut moved = 0.0;
        for (i, constraint) in self.constraints.iter().enumerate() {
            let start = self.ahead[i];
            let end = match constraint.diagonal.x > 0.0 {
                true => project(start - length * self.ahead_gradient[i], constraint.friction),
                // Neither body reacts.
                false => Vec3::ZERO,
            };
            self.next[i] = end;
            moved += (end - start).length_squared();
            scatter(constraint, end - start, &mut self.pushes);
        }
        let mut bent = 0.0;
        for (push, body) in self.pushes.iter_mut().zip(self.bodies) {
            let [linear, angular] = answer(body, *push);
            bent += push[0].dot(linear) + push[1].dot(angular);
            *push = [linear, angular];
        }
        [bent, moved]
    }

    /// Returns true if the gradient at y points along the way from the last γ to the next.
    fn went_uphill(&self) -> bool {
        let ways = self.next.iter().zip(&self.impulses);
        let slopes = self.ahead_gradient.iter().zip(ways);
        slopes
            .map(|(g, (next, last))| g.dot(*next - *last))
            .sum::<f32>()
            > 0.0
    }

    /// Makes the next γ the current one, and carries y beyond it by a share of the way from the last γ. Returns the merit of γ, √J.
    fn advance(&mut self, carry: f32) -> f32 {
        let beyond = |now: Vec3, last: Vec3| now + carry * (now - last);
        for (i, change) in self.pushes.iter().enumerate() {
            let last = self.velocities[i];
            for (part, change) in change.iter().enumerate() {
                let now = self.ahead_velocities[i][part] + change;
                self.velocities[i][part] = now;
                self.ahead_velocities[i][part] = beyond(now, last[part]);
            }
        }
        let mut merit = 0.0;
        for (i, constraint) in self.constraints.iter().enumerate() {
            let (impulse, gradient) = (
                self.next[i],
                seen(constraint, &self.velocities) - constraint.target,
            );
            self.ahead[i] = beyond(impulse, self.impulses[i]);
            self.ahead_gradient[i] = beyond(gradient, self.gradient[i]);
            (self.impulses[i], self.gradient[i]) = (impulse, gradient);
            let largest = constraint.diagonal.max_element();
            if largest > 0.0 {
                let nearer = project(impulse - gradient / largest, constraint.friction);
                let missing = nearer - impulse;
                merit += constraint.diagonal.dot(missing * missing);
            }
        }
        merit.sqrt()
    }
}

/// The velocity of A relative to B at a point, in its frame, m/s: Dᵀ v.
#[inline]
fn seen(constraint: &PointConstraint, velocities: &[Twist]) -> Vec3 {
    let [a, b] = constraint.bodies.map(|body| velocities[body as usize]);
    let [arm_a, arm_b] = constraint.arms;
    let relative = a[0] - b[0] + a[1].cross(arm_a) - b[1].cross(arm_b);
    let [t1, t2] = constraint.tangents;
    Vec3::new(
        constraint.normal.dot(relative),
        t1.dot(relative),
        t2.dot(relative),
    )
}

/// Adds an impulse at a point, in its frame, N·s, to the sums of its two bodies: D γ.
#[inline]
fn scatter(constraint: &PointConstraint, impulse: Vec3, pushes: &mut [Twist]) {
    let world = constraint.world(impulse);
    let [a, b] = constraint.bodies.map(|body| body as usize);
    pushes[a][0] += world;
    pushes[a][1] += constraint.arms[0].cross(world);
    pushes[b][0] -= world;
    pushes[b][1] -= constraint.arms[1].cross(world);
}

/// The change of velocity by a sum of impulses: M⁻¹ p.
#[inline]
fn answer(body: &Body, [linear, angular]: Twist) -> Twist {
    [
        body.inverse_mass * linear * body.free_axes,
        body.inverse_inertia * angular,
    ]
}
