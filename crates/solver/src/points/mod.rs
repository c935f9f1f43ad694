//! Point solvers: every contact point has one normal impulse and two friction impulses, as in the paper (Silcowitz-Hansen, Niebe, Erleben
//! 2010).
//!
//! A [`PointProblem`] is one island. It consists of bodies, whose velocities include the forces of this step, and of contact points. Each
//! point has a lower bound on its normal velocity and a target for its tangential velocity. A [`PointSolver`] finds impulses λ so that
//!
//! - w_n ≥ b_n, λ_n ≥ 0, λ_n (w_n − b_n) = 0 for each normal, and
//! - λ_t is the vector inside the friction cone ‖λ_t‖ ≤ μ λ_n that brings w_t nearest to b_t,
//!
//! and adds their effect to the velocities. Bodies then move with these velocities. [`Pgs`] and [`Nncg`] are the two solvers of the paper.
//! Users may add others:
//!
//! ```
//! use drystone_solver::{Body, Direction, FrictionCone, Grouping, PointConstraint, PointInput, PointProblem, PointSolver, SolveReport};
//! use glam::{Mat3, Vec3};
//!
//! /// Plain Gauss–Seidel, three sweeps.
//! struct ThreeSweeps;
//!
//! impl PointSolver for ThreeSweeps {
//!     fn name(&self) -> &str {
//!         "three-sweeps"
//!     }
//!
//!     fn solve(&self, problem: &mut PointProblem) -> SolveReport {
//!         let mut report = problem.report();
//!         for _ in 0..3 {
//!             let change = problem.sweep(Direction::Forwards, Grouping::Pair, FrictionCone::Circular);
//!             report.record(change.sqrt());
//!         }
//!         report
//!     }
//! }
//!
//! // A ball of 2 kg and radius 0.1 m on the ground, which is body 1. Gravity has acted on it for a sixtieth of a second.
//! let dt = 1.0 / 60.0;
//! let ball = Body {
//!     linear: Vec3::new(0.0, -9.81 * dt, 0.0),
//!     inverse_mass: 0.5,
//!     inverse_inertia: Mat3::from_diagonal(Vec3::splat(1.0 / 0.008)),
//!     ..Body::default()
//! };
//! let mut bodies = [ball, Body::default()];
//! let contact = PointInput {
//!     bodies: [0, 1],
//!     normal: Vec3::Y,
//!     arms: [Vec3::new(0.0, -0.1, 0.0), Vec3::ZERO],
//!     friction: 0.5,
//!     ..PointInput::default()
//! };
//! let mut problem = PointProblem {
//!     constraints: &mut [PointConstraint::prepare(&contact, &bodies)],
//!     bodies: &mut bodies,
//!     grabs: &mut [],
//!     joints: &mut [],
//!     dt,
//!     max_recent_dt: dt,
//!     effort: 1.0,
//!     free_merit: 0.0,
//!     record_history: false,
//! };
//! problem.warm_start(0.0);
//! let report = ThreeSweeps.solve(&mut problem);
//! let impulse = problem.constraints[0].impulse.x;
//! assert_eq!(report.sweeps, 3);
//! assert!((impulse - 2.0 * 9.81 * dt).abs() < 1e-6);
//! assert!(problem.bodies[0].linear.length() < 1e-6);
//! ```
//!
//! In drystone, `SolverSettings` takes it as `ContactSolver::Points(Arc::new(ThreeSweeps))`.

mod blocks;
mod constraint;
pub mod merit;
mod nncg;
mod pgs;

use super::grab::ActiveGrab;
use super::joint::PlainJoint;
#[cfg(target_arch = "x86_64")]
use super::lanes::F32x8;
use super::lanes::{F32x4, F32xN};
use super::walls::{self, Walls};
use super::width::Width;
use super::{Body, GrabConstraint, JointConstraint, Lanes, SolveReport};
use crate::Both;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use blocks::{Cone, Disc, Square};
pub use constraint::PatchFrame;
pub use constraint::{PointConstraint, PointInput, tangents};
pub use nncg::Nncg;
pub use pgs::Pgs;

/// A method that computes the impulses of points. It must be deterministic. Islands are solved in parallel.
pub trait PointSolver: Send + Sync {
    /// A short name for reports.
    fn name(&self) -> &str;

    /// Describes invalid settings of the solver in a sentence. If it returns one, the solver is not called.
    fn problem(&self) -> Option<String> {
        None
    }

    /// Share of the last step's impulses that a solve starts from, 0..1.
    fn warm_start(&self) -> f32 {
        0.0
    }

    /// Changes impulses and velocities of `problem` towards a solution.
    fn solve(&self, problem: &mut PointProblem) -> SolveReport;
}

/// The set that the friction impulses of one point are projected to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FrictionCone {
    /// ‖λ_t‖ ≤ μ λ_n.
    #[default]
    Circular,
    /// |λ_t1|, |λ_t2| ≤ μ λ_n on two fixed tangents. It is simpler, and up to √2 times too strong along the diagonal.
    Box,
}

/// Upper limit of the setting `iterations`.
const MAX_ITERATIONS: usize = 1_000_000;

/// Describes invalid values of the settings that [`Pgs`] and [`Nncg`] share.
fn problem(iterations: usize, warm_start: f32, tolerance: f32, lanes: Lanes) -> Option<String> {
    if !(1..=MAX_ITERATIONS).contains(&iterations) {
        return Some(format!(
            "iterations is {iterations}, and must be between 1 and {MAX_ITERATIONS}"
        ));
    }
    if !(0.0..=1.0).contains(&warm_start) {
        return Some(format!(
            "warm_start is {warm_start}, and must be between 0.0 and 1.0"
        ));
    }
    if !(0.0..=f32::INFINITY).contains(&tolerance) {
        return Some(format!(
            "tolerance is {tolerance}, and must be between 0.0 and inf"
        ));
    }
    lanes.problem()
}

/// A solver whose sweeps use lanes, written once for all widths and both cones.
trait Method {
    fn solve_as<L: F32xN, C: Cone>(&self, problem: &mut PointProblem) -> SolveReport;

    fn solve_in(
        &self,
        lanes: Lanes,
        cone: FrictionCone,
        problem: &mut PointProblem,
    ) -> SolveReport {
        match (width(lanes, problem), cone) {
            (Width::Four, FrictionCone::Circular) => self.solve_as::<F32x4, Disc>(problem),
            (Width::Four, FrictionCone::Box) => self.solve_as::<F32x4, Square>(problem),
            #[cfg(target_arch = "x86_64")]
            (Width::Eight, FrictionCone::Circular) => self.solve_as::<F32x8, Disc>(problem),
            #[cfg(target_arch = "x86_64")]
            (Width::Eight, FrictionCone::Box) => self.solve_as::<F32x8, Square>(problem),
        }
    }
}

/// Mean number of pairs in a block of eight lanes from which on eight lanes are faster than four. In a wall of 10 × 10 bricks it is 4.5,
/// and eight lanes take a fifth less time. In a wall of 5 × 5 it is 2.4, and eight lanes would take a tenth more.
#[cfg(target_arch = "x86_64")]
const EIGHT_LANES_FILL: usize = 3;

#[cfg(target_arch = "x86_64")]
fn width(lanes: Lanes, problem: &PointProblem) -> Width {
    lanes.width(|| blocks::batches(F32x8::LANES, problem).holds(EIGHT_LANES_FILL))
}

#[cfg(not(target_arch = "x86_64"))]
fn width(_: Lanes, _: &PointProblem) -> Width {
    Width::Four
}

/// One island that is ready to be solved. Constraints are prepared ([`PointConstraint::prepare`]), and velocities include the effect of the
/// warm-start impulses.
#[derive(Debug)]
pub struct PointProblem<'a> {
    /// All bodies of the island, and copies of the static and kinematic bodies that it touches.
    pub bodies: &'a mut [Body],
    /// All contact points, in the order in which they are swept.
    pub constraints: &'a mut [PointConstraint],
    /// Grabs that hold some of the bodies.
    pub grabs: &'a mut [GrabConstraint],
    /// Joints between some of the bodies.
    pub joints: &'a mut [JointConstraint],
    /// Length of the step, s.
    pub dt: f32,
    /// The longest of recent steps, s; at least `dt`. Errors of position are corrected at the rate that it allows.
    pub max_recent_dt: f32,
    /// Multiple of the usual number of sweeps, at least 1.
    pub effort: f32,
    /// The merit of the free motion, √J, to which residuals are relative. See [`merit`].
    pub free_merit: f32,
    /// Whether to record [`SolveReport::history`].
    pub record_history: bool,
}

impl PointProblem<'_> {
    /// The number of sweeps, where this many are usual.
    fn sweeps(&self, usual: usize) -> usize {
        (usual as f32 * self.effort).round() as usize
    }

    /// Measures the merit of the free motion, then scales the impulses of the constraints by `share` and applies them to the bodies.
    pub fn warm_start(&mut self, share: f32) {
        let contacts = merit::free_merit(self.bodies, self.constraints);
        let alone = |grab: &GrabConstraint| {
            let body = &self.bodies[grab.body as usize];
            ActiveGrab::new(grab, body, self.dt).missing([body.linear, body.angular])
        };
        let grabs: f32 = self.grabs.iter().map(alone).sum();
        self.free_merit = (contacts * contacts + grabs).sqrt();
        for constraint in &mut *self.constraints {
            constraint.impulse *= share;
            if share != 0.0 {
                constraint.push(self.bodies, constraint.world(constraint.impulse));
            }
        }
        for grab in &mut *self.grabs {
            grab.force *= share;
            grab.torque *= share;
            let body = &mut self.bodies[grab.body as usize];
            let held = ActiveGrab::new(grab, body, self.dt);
            body.add(held.warm_start());
        }
        for joint in &mut *self.joints {
            joint.forces = joint.forces.map(|force| share * force);
        }
        if share != 0.0 {
            for joint in self.plain_joints() {
                let ends = joint.joint.bodies;
                for (body, change) in ends.into_iter().zip(joint.warm_start()) {
                    self.bodies[body as usize].add(change);
                }
            }
        }
    }

    /// The joints that have an effect, ready to be visited.
    fn plain_joints(&self) -> Vec<PlainJoint> {
        let joints = self.joints.iter();
        joints
            .filter_map(|joint| PlainJoint::new(joint, self.bodies, [self.dt, self.max_recent_dt]))
            .collect()
    }

    /// The grabs, prepared for a sweep, each with the contacts that limit the motion of its body.
    fn held(&self) -> Vec<ActiveGrab> {
        if self.grabs.is_empty() {
            return Vec::new();
        }
        let points = &*self.constraints;
        let pairs = points.iter().map(|point| point.bodies);
        let of_bodies = walls::by_body(self.bodies.len(), pairs);
        let contact = |point: usize| (points[point].bodies, points[point].normal);
        let walls = Walls::new(&of_bodies, self.bodies, contact);
        let held = |grab: &GrabConstraint| {
            let held = ActiveGrab::new(grab, &self.bodies[grab.body as usize], self.dt);
            let walls = walls.among_points(grab.body, points, self.dt);
            held.in_step(self.dt, walls)
        };
        self.grabs.iter().map(held).collect()
    }

    /// Creates a report to record sweeps in.
    pub fn report(&self) -> SolveReport {
        SolveReport::new(self.free_merit, self.record_history)
    }

    /// Returns true if some body has a locked translation. Blocks of lanes have one inverse mass for each body, and cannot solve it.
    fn has_locks(&self) -> bool {
        self.bodies.iter().any(Body::is_locked)
    }

    /// Sweeps back and forth over one contact after the other, until the residual is at most `tolerance`.
    fn sweep_alone(
        &mut self,
        iterations: usize,
        tolerance: f32,
        cone: FrictionCone,
    ) -> SolveReport {
        let mut report = self.report();
        for k in 0..iterations {
            let direction = Direction::of_sweep(k, iterations);
            let change = self.sweep(direction, Grouping::Pair, cone);
            if report.record(change.sqrt()) <= tolerance {
                break;
            }
        }
        report
    }

    /// Does one projected Gauss–Seidel sweep over all grabs, all joints and then all contacts, pair after pair. Returns Σ Wᵢᵢ Δλᵢ², J.
    pub fn sweep(&mut self, direction: Direction, grouping: Grouping, cone: FrictionCone) -> f32 {
        let mut change = 0.0;
        for (i, mut held) in self.held().into_iter().enumerate() {
            let of = |body: u32| {
                let body = &self.bodies[body as usize];
                [body.linear, body.angular]
            };
            let (moved, changed) = held.relax(of(held.grab.body), of);
            self.bodies[held.grab.body as usize].add(moved);
            change += changed;
            self.grabs[i] = held.found();
        }
        for joint in &mut *self.joints {
            let Some(mut plain) =
                PlainJoint::new(joint, self.bodies, [self.dt, self.max_recent_dt])
            else {
                continue;
            };
            let ends = joint.bodies.both(|body| body as usize);
            let mut velocities =
                ends.both(|end| [self.bodies[end].linear, self.bodies[end].angular]);
            change += plain.relax(&mut velocities);
            for (end, velocity) in ends.into_iter().zip(velocities) {
                [self.bodies[end].linear, self.bodies[end].angular] = velocity;
            }
            // The low-pass follows once a step, and not in each sweep.
            let filtered = joint.filtered;
            *joint = plain.found();
            joint.filtered = filtered;
        }
        let bodies = &mut *self.bodies;
        for pair in self.constraints.chunk_by_mut(|a, b| a.bodies == b.bodies) {
            match grouping {
                Grouping::Pair => {
                    direction.visit(pair, |c| change += c.relax_normal(bodies));
                    direction.visit(pair, |c| change += c.relax_friction(bodies, cone));
                }
                Grouping::Point => direction.visit(pair, |c| {
                    change += c.relax_normal(bodies);
                    change += c.relax_friction(bodies, cone);
                }),
            }
        }
        change
    }
}

/// The order of the points of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// In their stored order: deepest first.
    Forwards,
    /// In reverse order.
    Backwards,
}

impl Direction {
    /// The direction of sweep `k` of `n`, counted from 0. Directions alternate, and the last sweep goes forwards.
    ///
    /// With one direction only, the first points of each manifold keep more than their share of the load. Stacks then rock, and the search
    /// directions of conjugate gradients become useless.
    pub fn of_sweep(k: usize, n: usize) -> Self {
        if (n - k) % 2 == 1 {
            Self::Forwards
        } else {
            Self::Backwards
        }
    }

    fn visit(self, pair: &mut [PointConstraint], relax: impl FnMut(&mut PointConstraint)) {
        match self {
            Self::Forwards => pair.iter_mut().for_each(relax),
            Self::Backwards => pair.iter_mut().rev().for_each(relax),
        }
    }
}

/// The order in which the normal and friction impulses of a pair are relaxed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// All normal impulses of the pair, then all friction impulses. This is better for few plain sweeps. Friction is bounded by the normal
    /// impulses, and the first points would otherwise be bounded by loads that they are about to pass on.
    Pair,
    /// The normal impulse of each point, then its friction impulse. This is smoother, and better for conjugate gradients.
    Point,
}
