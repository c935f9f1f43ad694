//! The cost of every stage.

use crate::overlays::Overlays;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use drystone::prelude::*;

/// Milliseconds of each stage, smoothed.
#[derive(Resource, Default)]
pub(super) struct Costs {
    /// The whole step.
    pub step: f32,
    stages: Vec<(&'static str, f32)>,
}

/// How much of a new figure is taken over.
const NEW: f32 = 0.1;

pub(super) fn follow(mut costs: ResMut<Costs>, profile: Res<Profile>) {
    let mix = |old: &mut f32, new: std::time::Duration| {
        *old += NEW * (1e3 * new.as_secs_f32() - *old);
    };
    mix(&mut costs.step, profile.step);
    for (name, time) in profile.systems() {
        match costs.stages.iter_mut().find(|(of, _)| *of == name) {
            Some((_, old)) => mix(old, time),
            None => costs.stages.push((name, 1e3 * time.as_secs_f32())),
        }
    }
}

pub(super) fn window(
    mut contexts: EguiContexts,
    mut overlays: ResMut<Overlays>,
    costs: Res<Costs>,
    bodies: Query<&RigidBody>,
    pairs: Query<(), With<ContactPair>>,
) -> Result {
    let mut open = overlays.costs;
    egui::Window::new("Costs")
        .open(&mut open)
        .resizable(false)
        .default_width(220.0)
        .anchor(egui::Align2::RIGHT_TOP, [-8.0, 8.0])
        .show(contexts.ctx_mut()?, |ui| {
            let most = costs.stages.iter().map(|(_, time)| *time);
            let most = most.fold(0.01, f32::max);
            egui::Grid::new("stages").num_columns(3).show(ui, |ui| {
                for (name, time) in &costs.stages {
                    ui.small(name.replace('_', " "));
                    ui.add(
                        egui::ProgressBar::new(time / most)
                            .desired_width(80.0)
                            .desired_height(8.0),
                    );
                    ui.small(format!("{time:.3} ms"));
                    ui.end_row();
                }
            });
            let bodies = bodies.iter().filter(|kind| **kind == RigidBody::Dynamic);
            let (bodies, pairs) = (bodies.count(), pairs.iter().count());
            ui.small(format!(
                "{:.2} ms a step, {bodies} bodies, {pairs} pairs",
                costs.step
            ));
        });
    if open != overlays.costs {
        overlays.costs = open;
    }
    Ok(())
}
