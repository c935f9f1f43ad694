//! Contact solvers on plain slices: this folder depends neither on the ECS nor on shapes.
//!
//! A problem is one island: bodies with velocities and inverse inertias, and the contacts and grabs that act on them. There are two kinds
//! of problems, and each solver works on one of them: [`points`], as the paper's [`Pgs`] and [`Nncg`] do, or [`patches`], as the default
//! [`SoftStep`] does.

mod batches;
mod body;
mod by_body;
mod grab;
mod groups;
mod joint;
mod lanes;
pub mod patches;
pub mod points;
mod report;
mod rounds;
mod walls;
mod width;

pub use body::Body;
pub use grab::GrabConstraint;
pub(crate) use joint::COORDINATES;
pub use joint::{JointAxis, JointConstraint, JointMotor, MortarFailure, Section, Utilization};
pub use patches::{
    FEW, Memory, PatchConstraint, PatchPoint, PatchProblem, PatchSolver, Settling, Slip, SoftStep,
};
pub(crate) use points::PatchFrame;
pub use points::{
    Direction, FrictionCone, Grouping, Nncg, Pgs, PointConstraint, PointInput, PointProblem,
    PointSolver, merit, tangents,
};
pub use report::SolveReport;
pub use width::Lanes;
