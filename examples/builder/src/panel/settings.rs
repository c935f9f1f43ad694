//! Physics as the panel sets it.

use bevy::prelude::*;
use bevy_egui::egui;
use drystone::prelude::*;
use drystone::settings::{NormalStabilization, Preset};
use drystone::solver::{Nncg, Pgs, SoftStep};

/// Settings that can be changed while it runs.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    solver: Solver,
    /// Sweeps of Soft Step at most, or iterations of the others.
    sweeps: usize,
    friction: bool,
    normal: bool,
    sleep: bool,
    /// Tilt of the ground, °, by the direction of gravity.
    tilt: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Solver {
    SoftStep,
    Pgs,
    Nncg,
}

impl Solver {
    const ALL: [Self; 3] = [Self::SoftStep, Self::Pgs, Self::Nncg];

    fn name(self) -> &'static str {
        match self {
            Self::SoftStep => "Soft Step",
            Self::Pgs => "PGS",
            Self::Nncg => "NNCG",
        }
    }

    fn sweeps(self) -> usize {
        match self {
            Self::SoftStep => SoftStep::default().max_sweeps,
            Self::Pgs => Pgs::default().iterations,
            Self::Nncg => Nncg::default().iterations,
        }
    }
}

impl Default for Physics {
    fn default() -> Self {
        Self {
            solver: Solver::SoftStep,
            sweeps: Solver::SoftStep.sweeps(),
            friction: true,
            normal: true,
            sleep: true,
            tilt: 0.0,
        }
    }
}

impl Physics {
    pub(super) fn show(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            for solver in Solver::ALL {
                let response = ui.selectable_label(self.solver == solver, solver.name());
                if response.clicked() {
                    (self.solver, self.sweeps) = (solver, solver.sweeps());
                }
            }
        });
        let sweeps = egui::Slider::new(&mut self.sweeps, 1..=400);
        ui.add(sweeps.logarithmic(true).text("sweeps"));
        ui.small("stabilization");
        ui.horizontal(|ui| {
            ui.toggle_value(&mut self.friction, "friction");
            ui.toggle_value(&mut self.normal, "normal");
            ui.toggle_value(&mut self.sleep, "sleep");
        });
        let tilt = egui::Slider::new(&mut self.tilt, 0.0..=30.0);
        ui.add(super::with_unit(tilt, 1, "°").text("tilt"));
        if ui.small_button("as delivered").clicked() {
            *self = Self::default();
        }
    }

    fn solver(&self) -> ContactSolver {
        match self.solver {
            Solver::SoftStep => SoftStep {
                max_sweeps: self.sweeps,
                ..default()
            }
            .into(),
            Solver::Pgs => Pgs {
                iterations: self.sweeps,
                ..default()
            }
            .into(),
            Solver::Nncg => Nncg {
                iterations: self.sweeps,
                ..default()
            }
            .into(),
        }
    }
}

pub(super) fn apply(
    physics: Res<Physics>,
    mut solver: ResMut<SolverSettings>,
    mut stabilization: ResMut<StabilizationSettings>,
    mut sleeping: ResMut<SleepSettings>,
    mut gravity: ResMut<Gravity>,
) {
    if !physics.is_changed() || physics.is_added() {
        return;
    }
    *solver = SolverSettings::new(physics.solver());
    let mut wanted = Preset::Default.stabilization();
    wanted.friction.enabled = physics.friction;
    if !physics.normal {
        wanted.normal = NormalStabilization::None;
    }
    stabilization.set_if_neq(wanted);
    sleeping.enabled = physics.sleep;
    let tilt = Quat::from_rotation_x(physics.tilt.to_radians());
    gravity.set_if_neq(Gravity(tilt.inverse() * Gravity::default().0));
}
