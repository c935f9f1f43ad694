//! The time line of a recording.

use crate::camera::PanelWidth;
use crate::replay::{KEYS, Timeline};
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// Its height with the space below it, logical pixels.
pub(super) const HEIGHT: f32 = 92.0;

/// Height of the bar, logical pixels.
const BAR: f32 = 18.0;

/// Space at either side, logical pixels.
const ASIDE: f32 = 16.0;

pub(super) fn window(
    mut contexts: EguiContexts,
    timeline: Option<ResMut<Timeline>>,
    panel: Res<PanelWidth>,
) -> Result {
    let Some(mut timeline) = timeline else {
        return Ok(());
    };
    let context = contexts.ctx_mut()?;
    let whole = context.viewport_rect();
    let width = (whole.width() - panel.0 - 4.0 * ASIDE).max(200.0);
    egui::Window::new("time line")
        .title_bar(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_BOTTOM, [0.5 * panel.0, -8.0])
        .fixed_size([width, 60.0])
        .show(context, |ui| {
            buttons(ui, &mut timeline);
            bar(ui, &mut timeline, width);
            let text = match timeline.divergence() {
                Some(divergence) => format!("not as it was recorded: {divergence}"),
                None if timeline.is_cut() => format!("the game ended in the middle · {KEYS}"),
                None => KEYS.into(),
            };
            ui.small(text);
        });
    Ok(())
}

fn buttons(ui: &mut egui::Ui, timeline: &mut Timeline) {
    ui.horizontal(|ui| {
        if ui.button("|<").clicked() {
            timeline.go_to(0);
        }
        if ui.button("<").clicked() {
            timeline.go_by(-1);
        }
        let text = if timeline.playing { "Stop" } else { "Play" };
        if super::button(ui, text, 42.0) {
            timeline.toggle();
        }
        if ui.button(">").clicked() {
            timeline.go_by(1);
        }
        for (text, speed) in [("1", 1.0), ("½", 0.5), ("⅛", 0.125)] {
            ui.selectable_value(&mut timeline.speed, speed, text);
        }
        let (shown, target) = (timeline.shown(), timeline.target());
        ui.label(format!("step {shown} of {}", timeline.len()));
        if shown != target {
            ui.small(format!("on the way to {target} …"));
        }
    });
}

/// Click and drag to go to a step. Changes from outside are marked, and the first step that differs from the recording.
fn bar(ui: &mut egui::Ui, timeline: &mut Timeline, width: f32) {
    let size = egui::vec2(width, BAR);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click_and_drag());
    let steps = timeline.len().max(1) as f32;
    if let Some(at) = response.interact_pointer_pos() {
        let share = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
        timeline.playing = false;
        timeline.go_to((share * steps).round() as usize);
    }
    let x = |step: usize| rect.left() + step as f32 / steps * rect.width();
    let painter = ui.painter();
    let visuals = ui.visuals();
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    let past = egui::Rect::from_min_max(rect.min, egui::pos2(x(timeline.shown()), rect.bottom()));
    painter.rect_filled(past, 3.0, visuals.selection.bg_fill);
    let low = egui::Rangef::new(rect.center().y, rect.bottom());
    for &step in timeline.changes() {
        painter.vline(x(step), low, (1.0, visuals.weak_text_color()));
    }
    if let Some(divergence) = timeline.divergence() {
        painter.vline(
            x(divergence.step),
            rect.y_range(),
            (3.0, egui::Color32::RED),
        );
    }
    painter.vline(
        x(timeline.target()),
        rect.y_range(),
        (2.0, visuals.strong_text_color()),
    );
}
