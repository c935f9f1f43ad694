//! Solvers from the literature, as baselines for the library's own. They implement its public traits, as a solver of any user does.
//!
//! | solver | source | trait |
//! |---|---|---|
//! | [`Avbd`] | Giles, Diaz, Yuksel 2025, "Augmented Vertex Block Descent" | [`PatchSolver`](drystone::solver::PatchSolver) |
//! | [`Apgd`] | Mazhar, Heyn, Negrut, Tasora 2015, "Using Nesterov's Method" | [`PointSolver`](drystone::solver::PointSolver) |
//!
//! The full title of the second is "Using Nesterov's Method to Accelerate Multibody Dynamics with Friction and Contact". Both are written
//! from the papers, in plain scalar code on one thread. The library's own solvers relax four or eight contacts at once, so
//! compare times of equal results with that in mind.
//!
//! ```
//! use drystone::settings::Preset;
//! use drystone_lab::experiment::Experiment;
//! use drystone_lab::solvers::Avbd;
//!
//! let mut experiment = Experiment::new("stack:3".parse().unwrap(), Preset::Default);
//! experiment.solver.solver = Avbd::default().into();
//! assert!(experiment.run_seconds(1.0).stands);
//! ```

mod apgd;
mod avbd;
mod cone;
#[cfg(test)]
mod tests;

pub use apgd::Apgd;
pub use avbd::Avbd;
