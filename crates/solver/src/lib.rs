//! Contact and joint solvers on plain slices, without an ECS and without shapes. [Drystone](https://docs.rs/drystone) uses them, and so can
//! anybody who has contacts of their own.
//!
//! A problem is one island: bodies with velocities and inverse inertias, and the contacts and grabs that act on them. There are two kinds
//! of problems, and each solver works on one of them: [`points`], as the paper's [`Pgs`] and [`Nncg`] do, or [`patches`], as the default
//! [`SoftStep`] does.

#![deny(missing_debug_implementations)]
#![deny(missing_docs)]
#![deny(unsafe_code)]
#![warn(clippy::too_many_lines)]
#![cfg_attr(
    test,
    allow(clippy::disallowed_methods, reason = "tests compare with tolerances")
)]

mod batches;
mod body;
mod both;
mod by_body;
mod contact_row;
mod grab;
#[doc(hidden)]
pub mod groups;
#[doc(hidden)]
pub mod join;
mod joint;
mod lanes;
pub mod patches;
pub mod points;
mod report;
pub mod revision;
mod rounds;
#[doc(hidden)]
pub mod sort;
#[doc(hidden)]
pub mod spin;
mod walls;
mod width;

pub use body::Body;
#[doc(hidden)]
pub use both::Both;
pub use grab::GrabConstraint;
pub use joint::{
    BondEnd, COORDINATES, JointAxis, JointConstraint, JointMotor, MortarFailure, Section,
    Utilization,
};
pub use patches::{
    Memory, PatchConstraint, PatchPoint, PatchProblem, PatchSolver, ROCKING_SPEED,
    SMALL_ISLAND_PATCHES, Settling, Slip, SoftStep,
};
pub use points::{
    Direction, FrictionCone, Grouping, Nncg, PatchFrame, Pgs, PointConstraint, PointInput,
    PointProblem, PointSolver, merit, tangents,
};
pub use report::SolveReport;
pub use width::Lanes;
