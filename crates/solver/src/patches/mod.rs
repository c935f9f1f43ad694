//! Solvers of patches: every contact point has a normal impulse of its own, but one friction force and one twist serve all points of a
//! patch.
//!
//! A patch solver takes substeps of its own: it begins at [`Body::start`], and returns in [`Body::motion`] how bodies moved. [`SoftStep`]
//! is the default.

mod constraint;
mod memory;
mod restitution;
mod soft_step;

use super::{Body, GrabConstraint, JointConstraint, SolveReport};
pub use constraint::{PatchConstraint, PatchPoint, Slip};
use glam::Vec3;
pub use memory::Memory;
pub use soft_step::SoftStep;
pub use soft_step::settle;

/// Islands of fewer patches than this are solved together.
pub const SMALL_ISLAND_PATCHES: usize = 4;

/// The angular speed from which on a body that presses on others rocks, rad/s. In structures that settle, slower rotations are mostly those
/// of springs.
pub const ROCKING_SPEED: f32 = 0.1;

/// A method that finds the impulses of patches. Must be deterministic; islands are solved side by side.
pub trait PatchSolver: Send + Sync {
    /// A short name for reports.
    fn name(&self) -> &str;

    /// Describes invalid settings of the solver in a sentence. The solver is not called then.
    fn problem(&self) -> Option<String> {
        None
    }

    /// Finds impulses, velocities and motions.
    fn solve(&self, problem: &mut PatchProblem) -> SolveReport;

    /// Solves several problems of [few](SMALL_ISLAND_PATCHES) patches each, without grabs. The result of each must be that of
    /// [`Self::solve`].
    fn solve_each(&self, problems: &mut [PatchProblem]) -> Vec<SolveReport> {
        problems
            .iter_mut()
            .map(|problem| self.solve(problem))
            .collect()
    }
}

/// How a tall structure that sways comes to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settling {
    /// Rate at which its bodies lose speed, 1/s.
    pub rate: f32,
    /// The linear and angular speed from which on its bodies lose none, m/s, rad/s.
    pub below: [f32; 2],
}

/// One island, ready to be solved.
#[derive(Debug)]
pub struct PatchProblem<'a> {
    /// All bodies of the island, and copies of the static and kinematic ones it touches. Velocities hold this step's forces.
    pub bodies: &'a mut [Body],
    /// All patches, in the order in which they are swept.
    pub patches: &'a mut [PatchConstraint],
    /// The points of all patches.
    pub points: &'a mut [PatchPoint],
    /// Grabs that hold some of the bodies.
    pub grabs: &'a mut [GrabConstraint],
    /// Joints between some of the bodies.
    pub joints: &'a mut [JointConstraint],
    /// Tangential velocities that friction demands of A against B, m/s, world axes, by the index of the patch, in ascending order. Patches
    /// that are not in the list demand zero.
    pub surfaces: &'a [(u32, Vec3)],
    /// Length of the step, s.
    pub dt: f32,
    /// The longest of recent steps, s; at least `dt`. It sets a stiffness that must not increase for a step that is short by chance.
    pub max_recent_dt: f32,
    /// Acceleration of free fall, m/s².
    pub gravity: Vec3,
    /// Multiple of the usual number of sweeps, at least 1.
    pub effort: f32,
    /// Some of its bodies have just broken off others. They are no structure that was built, so none is searched for the forces that hold
    /// it.
    pub broke: bool,
    /// Fastest correction of an error of position, m/s.
    pub max_correction_speed: f32,
    /// How a tall structure that sways comes to rest. `None` in worlds without sleeping.
    pub settling: Option<Settling>,
    /// Islands at rest are never put to sleep, so the solver should save work on them itself.
    pub stays_awake: bool,
    /// Keep [`SolveReport::history`].
    pub record_history: bool,
    /// Number of threads that the solver may use, of the pool in which it is called; at least 1. Results must not depend on it.
    pub threads: usize,
    /// The state that the solver keeps of this island.
    pub memory: &'a mut Memory,
}

impl PatchProblem<'_> {
    /// Whether only contacts act on the bodies, and no surface moves along itself.
    fn has_only_contacts(&self) -> bool {
        self.joints.is_empty() && self.grabs.is_empty() && self.surfaces.is_empty()
    }
}
