//! Contact solvers on plain slices: this folder knows neither the ECS nor shapes.
//!
//! A problem is one island: bodies with velocities and inverse inertias, and what acts between them. There are two kinds, and a solver
//! works on one of them: by [`points`], as the paper's [`Pgs`] and [`Nncg`] do, or by [`patches`], as [`SoftStep`] does, the default.

mod batches;
mod body;
mod by_body;
mod grip;
mod groups;
mod lanes;
pub mod patches;
pub mod points;
mod report;
mod rounds;
mod walls;
mod width;

pub use body::Body;
pub use grip::Grip;
pub use patches::{
    FEW, Memory, PatchConstraint, PatchPoint, PatchProblem, PatchSolver, Slip, SoftStep,
};
pub(crate) use points::PatchFrame;
pub use points::{
    Direction, FrictionCone, Grouping, Nncg, Pgs, PointConstraint, PointInput, PointProblem,
    PointSolver, merit, tangents,
};
pub use report::SolveReport;
pub use width::Lanes;
