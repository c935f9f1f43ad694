//! The other solvers, long steps, and outer substeps.

use super::*;
use drystone::settings::Preset;
use drystone::solver::{Nncg, Pgs};

/// Length of a step of the paper, s.
const PAPER: f32 = 0.1;

/// A scene of the laboratory with the settings of the paper.
fn of_paper(world: &mut World, name: &str, solver: impl Into<ContactSolver>) -> Vec<Entity> {
    let preset = Preset::Paper;
    assert_eq!(preset.dt(), PAPER);
    world.insert_resource(preset.stabilization());
    world.insert_resource(preset.narrowphase());
    let mut settings = preset.solver();
    settings.solver = solver.into();
    world.insert_resource(settings);
    let bodies = build(world, name);
    for _ in 0..15 {
        drystone::step(world, PAPER).unwrap();
    }
    bodies
}

fn paper(start: fn(&mut World) -> Vec<Entity>) -> Scene {
    Scene {
        start,
        dt: PAPER,
        ..Scene::default()
    }
}

pub fn wall_of_pgs() -> Scene {
    paper(|world| of_paper(world, "wall:4x4", Pgs::default()))
}

pub fn arch_of_pgs() -> Scene {
    paper(|world| of_paper(world, "arch:9", Pgs::default()))
}

pub fn wall_of_nncg() -> Scene {
    paper(|world| of_paper(world, "wall:4x4", Nncg::default()))
}

pub fn arch_of_nncg() -> Scene {
    paper(|world| of_paper(world, "arch:9", Nncg::default()))
}

pub fn heap_of_the_paper() -> Scene {
    paper(|world| of_paper(world, "heap:40", Nncg::default()))
}

/// Other settings than the last step had wake what sleeps.
pub fn outer_substeps() -> Scene {
    Scene {
        start: |world| {
            build(world, "wall:4x4");
            world.resource_mut::<SolverSettings>().outer_substeps = 3;
            steps(world, 20);
            Vec::new()
        },
        edit: |world, _, step| match step {
            30 => world.resource_mut::<SolverSettings>().outer_substeps = 1,
            60 => world.resource_mut::<Gravity>().0.y = -9.0,
            _ => (),
        },
        steps: 120,
        ..Scene::default()
    }
}
