//! A contact solver of your own, outside of drystone's crates: `cargo run --release --example own_solver`.
//!
//! It relaxes one contact after the other, in a fixed number of sweeps. A stack of five cubes stands on it.

use bevy_app::App;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use drystone::settings::ContactSolver;
use drystone::solver::{Direction, FrictionCone, Grouping, PointProblem, PointSolver, SolveReport};
use std::sync::Arc;

/// Gauss–Seidel over the points of contact, in the order in which they come.
pub struct PlainSweeps {
    /// Number of sweeps in a step.
    pub sweeps: usize,
}

impl PointSolver for PlainSweeps {
    fn name(&self) -> &str {
        "plain-sweeps"
    }

    fn problem(&self) -> Option<String> {
        (self.sweeps == 0).then(|| "sweeps is 0, and must be at least 1".into())
    }

    fn solve(&self, problem: &mut PointProblem) -> SolveReport {
        let mut report = problem.report();
        for sweep in 0..self.sweeps {
            let direction = Direction::of_sweep(sweep, self.sweeps);
            let change = problem.sweep(direction, Grouping::Pair, FrictionCone::Circular);
            // The norm of the change decides whether a solve has converged.
            report.record(change.sqrt());
        }
        report
    }
}

/// The heights of a stack of five cubes after some seconds, m.
pub fn stack(solver: PlainSweeps, seconds: f32) -> Vec<f32> {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.resource_mut::<SolverSettings>().solver = ContactSolver::Points(Arc::new(solver));
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let cubes = [0, 1, 2, 3, 4].map(|course| {
        let at = Transform::from_xyz(0.0, 0.5 + course as f32, 0.0);
        world
            .spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), at))
            .id()
    });
    for _ in 0..(60.0 * seconds) as usize {
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    cubes
        .map(|cube| world.get::<Pose>(cube).unwrap().position.y)
        .to_vec()
}

fn main() {
    for sweeps in [5, 10, 50] {
        let heights = stack(PlainSweeps { sweeps }, 5.0);
        println!("{sweeps} sweeps: the cubes of the stack are at {heights:.4?} m after 5 s");
    }
}
