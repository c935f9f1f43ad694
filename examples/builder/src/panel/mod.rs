//! The panel: choices and information.

mod costs;
mod settings;
mod timeline;

pub use settings::Physics;

use crate::camera::{PanelWidth, Pointer};
use crate::clock::Clock;
use crate::compare::Comparison;
use crate::edits;
use crate::gallery::Scene;
use crate::journal::Widgets;
use crate::overlays::{Falls, Legend, Margins, Overlays, Paint};
use crate::pieces::palette;
use crate::replay::Timeline;
use crate::tools::{Choice, Notice, Strength, Tool, attempt, keys::HELP};
use bevy::ecs::component::Mutable;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};
use clap::ValueEnum;
use drystone::body::MassProperties;
use drystone::masonry::EditLog;
use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin, PhysicsPanelSystems};
use drystone::prelude::*;

/// The panel, through `bevy_egui`.
pub struct PanelPlugin;

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(EguiPlugin::default())
            .init_resource::<Physics>()
            .init_resource::<costs::Costs>()
            .add_systems(Update, (settings::apply, costs::follow))
            .add_systems(
                EguiPrimaryContextPass,
                (side, timeline::window, banner, help).chain(),
            );
        // The panel of physics is switched here like the other overlays.
        app.insert_resource(PhysicsPanel {
            key: None,
            ..default()
        })
        .add_plugins(PhysicsPanelPlugin)
        .add_systems(Update, costs::switch.before(PhysicsPanelSystems));
    }
}

/// The resources that the panel changes.
#[derive(SystemParam)]
struct Set<'w> {
    scene: ResMut<'w, Scene>,
    tool: ResMut<'w, Tool>,
    choice: ResMut<'w, Choice>,
    strength: ResMut<'w, Strength>,
    clock: ResMut<'w, Clock>,
    physics: ResMut<'w, Physics>,
    overlays: ResMut<'w, Overlays>,
    widgets: ResMut<'w, Widgets>,
    width: ResMut<'w, PanelWidth>,
}

/// The data that the panel shows.
#[derive(SystemParam)]
struct Known<'w, 's> {
    pointer: Res<'w, Pointer>,
    log: Res<'w, EditLog>,
    falls: Res<'w, Falls>,
    margins: Res<'w, Margins>,
    legend: Res<'w, Legend>,
    comparison: Res<'w, Comparison>,
    supports: Supports<'w, 's>,
    timeline: Option<Res<'w, Timeline>>,
    bodies: Query<'w, 's, (&'static Load, &'static MassProperties, &'static Sleeping)>,
    costs: Res<'w, costs::Costs>,
}

/// A part of the panel of this height, logical pixels, so that nothing below it moves when its content changes.
fn fixed(ui: &mut egui::Ui, height: f32, show: impl FnOnce(&mut egui::Ui)) {
    let size = egui::vec2(ui.available_width(), height);
    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let inside = egui::UiBuilder::new()
        .max_rect(rect)
        .layout(egui::Layout::top_down(egui::Align::Min));
    show(&mut ui.new_child(inside));
}

/// A slider that shows its value with a unit. Egui would put a gap before a suffix.
fn with_unit<'a>(
    slider: egui::Slider<'a>,
    decimals: usize,
    unit: &'static str,
) -> egui::Slider<'a> {
    slider
        .custom_formatter(move |value, _| format!("{value:.decimals$}{unit}"))
        .custom_parser(move |text| {
            text.trim()
                .trim_end_matches(unit.trim())
                .trim()
                .parse()
                .ok()
        })
}

/// A button that is as wide as the longest of its texts, so that nothing beside it moves.
fn button(ui: &mut egui::Ui, text: &str, width: f32) -> bool {
    let size = egui::vec2(width, 0.0);
    ui.add(egui::Button::new(text).min_size(size)).clicked()
}

/// A value that is written only if it was changed, so that showing it does not trigger change detection.
fn edit<T>(value: &mut ResMut<T>, show: impl FnOnce(&mut T))
where
    T: Resource<Mutability = Mutable> + Clone + PartialEq,
{
    let mut copy = (**value).clone();
    show(&mut copy);
    value.set_if_neq(copy);
}

fn side(mut contexts: EguiContexts, mut commands: Commands, mut set: Set, known: Known) -> Result {
    let context = contexts.ctx_mut()?;
    context.all_styles_mut(|style| {
        let small = style.text_styles.get_mut(&egui::TextStyle::Small);
        small.into_iter().for_each(|font| font.size = 11.0);
    });
    let mut whole = egui::Ui::new(
        context.clone(),
        "whole".into(),
        egui::UiBuilder::new()
            .layer_id(egui::LayerId::background())
            .max_rect(context.viewport_rect()),
    );
    let panel = egui::Panel::left("side").exact_size(236.0).resizable(false);
    let panel = panel.show(&mut whole, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            // Whoever changes a world that is replayed sees something that was not recorded.
            if known.timeline.is_some() {
                overlays(ui, &mut set, &known);
                return;
            }
            scenes(ui, &mut set);
            tools(ui, &mut set);
            history(ui, &mut commands, &known.log);
            time(ui, &mut commands, &mut set, &known.comparison);
            overlays(ui, &mut set, &known);
            ui.separator();
            edit(&mut set.physics, |physics| physics.show(ui));
        });
    });
    set.width.0 = panel.response.rect.right();
    Ok(())
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(4.0);
    ui.strong(text);
}

fn scenes(ui: &mut egui::Ui, set: &mut Set) {
    heading(ui, "Gallery");
    let shown = *set.scene;
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        for &scene in Scene::value_variants() {
            if ui.selectable_label(scene == shown, scene.name()).clicked() {
                chosen = Some(scene);
            }
        }
    });
    // The one that is shown begins anew.
    if let Some(scene) = chosen {
        *set.scene = scene;
    }
}

/// Notes where a button is, for the journal.
fn note(widgets: &mut Widgets, name: &str, response: &egui::Response) {
    let middle = response.rect.center();
    widgets.0.insert(name.into(), [middle.x, middle.y]);
}

/// Heights of the parts that change, logical pixels: a tool with its settings; the legend of the colours; what is known of a piece.
const TOOL_HEIGHT: f32 = 80.0;
const LEGEND_HEIGHT: f32 = 28.0;
const PIECE_HEIGHT: f32 = 72.0;

fn tools(ui: &mut egui::Ui, set: &mut Set) {
    heading(ui, "Tools");
    ui.horizontal_wrapped(|ui| {
        for tool in Tool::ALL {
            let [name, _] = tool.about();
            let response = ui.selectable_label(*set.tool == tool, name);
            note(&mut set.widgets, name, &response);
            if response.clicked() {
                *set.tool = tool;
            }
        }
    });
    fixed(ui, TOOL_HEIGHT, |ui| tool(ui, set));
}

/// What the tool does, and its settings.
fn tool(ui: &mut egui::Ui, set: &mut Set) {
    ui.small(set.tool.about()[1]);
    match *set.tool {
        Tool::Lay => {
            ui.horizontal_wrapped(|ui| {
                for (name, piece) in palette() {
                    let response = ui.selectable_label(set.choice.name == Some(name), name);
                    note(&mut set.widgets, name, &response);
                    if response.clicked() {
                        (set.choice.piece, set.choice.name) = (piece, Some(name));
                    }
                }
            });
            if set.choice.name.is_none() {
                ui.small("a copy");
            }
        }
        tool @ (Tool::Hand | Tool::Press | Tool::Throw) => {
            edit(&mut set.strength, |strength| match tool {
                Tool::Hand => force(ui, &mut strength.hand, "hand"),
                Tool::Press => force(ui, &mut strength.press, "pressure"),
                _ => {
                    let slider = egui::Slider::new(&mut strength.throw, 2.0..=40.0);
                    ui.add(with_unit(slider, 1, " m/s"));
                }
            })
        }
        Tool::Move | Tool::Take => {}
    }
}

/// A slider in kilonewtons.
fn force(ui: &mut egui::Ui, newtons: &mut f32, text: &str) {
    let mut kilo = 1e-3 * *newtons;
    let slider = egui::Slider::new(&mut kilo, 0.5..=100.0).logarithmic(true);
    if ui.add(with_unit(slider, 1, " kN").text(text)).changed() {
        *newtons = 1e3 * kilo;
    }
}

fn history(ui: &mut egui::Ui, commands: &mut Commands, log: &EditLog) {
    let [done, undone] = log.len();
    ui.horizontal(|ui| {
        let button = |text: &str, is_on: bool, ui: &mut egui::Ui| {
            ui.add_enabled(is_on, egui::Button::new(text)).clicked()
        };
        if button("Undo", done > 0, ui) {
            attempt(commands, edits::undo);
        }
        if button("Redo", undone > 0, ui) {
            attempt(commands, edits::redo);
        }
        if button("Save", true, ui) {
            attempt(commands, edits::save);
        }
        if button("Load", true, ui) {
            attempt(commands, edits::load);
        }
    });
}

fn time(ui: &mut egui::Ui, commands: &mut Commands, set: &mut Set, comparison: &Comparison) {
    heading(ui, "Time");
    edit(&mut set.clock, |clock| {
        ui.horizontal(|ui| {
            let text = if clock.paused { "Go on" } else { "Pause" };
            if button(ui, text, 48.0) {
                clock.paused = !clock.paused;
            }
            if ui.button("Step").clicked() {
                (clock.paused, clock.step) = (true, true);
            }
            for (text, speed) in [("1", 1.0), ("½", 0.5), ("⅛", 0.125)] {
                ui.selectable_value(&mut clock.speed, speed, text);
            }
        });
        ui.horizontal(|ui| {
            ui.label("Hz");
            for hz in [120.0, 60.0, 30.0, 20.0, 10.0] {
                ui.selectable_value(&mut clock.hz, hz, format!("{hz}"));
            }
        });
    });
    let text = match comparison.is_on() {
        true => "One scene again",
        false => "60 and 10 Hz side by side",
    };
    let response = ui.button(text);
    if response.clicked() {
        attempt(commands, crate::compare::toggle);
    }
    response.on_hover_text("left 60 Hz, right 10 Hz; balls go into both");
}

fn overlays(ui: &mut egui::Ui, set: &mut Set, known: &Known) {
    heading(ui, "Look inside");
    edit(&mut set.overlays, |overlays| {
        ui.horizontal_wrapped(|ui| {
            for paint in Paint::ALL {
                ui.selectable_value(&mut overlays.paint, paint, paint.name());
            }
        });
        fixed(ui, LEGEND_HEIGHT, |ui| {
            if let Some(text) = &known.legend.0 {
                let scaled = matches!(overlays.paint, Paint::Loads | Paint::Friction);
                if scaled {
                    scale(ui);
                }
                ui.small(text);
            }
            if overlays.paint == Paint::Sleep {
                ui.small(format!("{:.2} ms a step", known.costs.step));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.toggle_value(&mut overlays.contacts, "contacts");
            ui.toggle_value(&mut overlays.anchors, "anchors");
            ui.toggle_value(&mut overlays.path, "load path");
            ui.toggle_value(&mut overlays.falls, "what falls");
            ui.toggle_value(&mut overlays.margin, "margin");
            ui.toggle_value(&mut overlays.costs, "costs");
            ui.toggle_value(&mut overlays.help, "help");
        });
    });
    fixed(ui, PIECE_HEIGHT, |ui| piece(ui, known));
}

/// What is known of the piece under the mouse.
fn piece(ui: &mut egui::Ui, known: &Known) {
    // Each at its place.
    let mut lines = vec![String::new(); 4];
    if let Some(body) = known.pointer.body
        && let Ok((load, mass, sleeping)) = known.bodies.get(body)
    {
        let own = 1.0 / mass.inverse_mass.max(1e-9);
        lines[0] = format!(
            "{own:.0} kg, carries {:.2} kN",
            1e-3 * load.supported_weight
        );
        let bearings = known.supports.supported_by(body).unwrap_or_default();
        let rest = if sleeping.asleep { ", sleeps" } else { "" };
        let friction = 100.0 * load.friction_use;
        lines[1] = format!("on {}, friction {friction:.0} %{rest}", bearings.len());
        if let Some(count) = known.falls.count() {
            lines[2] = match count {
                0 => "taken: nothing falls".into(),
                1 => "taken: one piece falls".into(),
                count => format!("taken: {count} pieces fall"),
            };
        }
    }
    lines[3] = match known.margins.answer() {
        Some(Ok(weakest)) => {
            let (tilt, moving) = (weakest.tilt.to_degrees(), weakest.moving.len());
            format!(
                "stands to {tilt:.1}°; then {moving} move: it {}",
                weakest.how
            )
        }
        Some(Err(why)) => why.into(),
        None if known.margins.is_asking() => "asking for its margin …".into(),
        None => String::new(),
    };
    for line in lines {
        ui.small(line);
    }
}

/// From blue to red.
fn scale(ui: &mut egui::Ui) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(200.0, 8.0), egui::Sense::hover());
    let parts = 24;
    for i in 0..parts {
        let share = i as f32 / (parts - 1) as f32;
        let color = Srgba::from(Color::hsl(235.0 * (1.0 - share), 0.75, 0.5)).to_u8_array();
        let width = rect.width() / parts as f32;
        let left = rect.left() + i as f32 * width;
        let part = egui::Rect::from_min_size(
            egui::pos2(left, rect.top()),
            egui::vec2(width + 0.5, rect.height()),
        );
        let color = egui::Color32::from_rgb(color[0], color[1], color[2]);
        ui.painter().rect_filled(part, 0.0, color);
    }
}

/// How long the banner stays, s.
const STAYS: f32 = 5.0;

/// Collapses and errors.
fn banner(
    mut contexts: EguiContexts,
    mut collapses: MessageReader<Collapse>,
    mut told: Local<Option<(String, f32)>>,
    (notice, time): (Res<Notice>, Res<Time<Real>>),
    timeline: Option<Res<Timeline>>,
    poses: Query<&Pose>,
) -> Result {
    let now = time.elapsed_secs();
    if let Some(collapse) = collapses.read().last() {
        let how = match collapse.how {
            FailureMode::Pulled => "was pulled",
            FailureMode::Crushed => "was crushed",
            FailureMode::Fell => "lost what bore it",
            FailureMode::Slid => "slid",
            FailureMode::Tipped => "tipped",
        };
        let height = poses
            .get(collapse.first)
            .map_or(0.0, |pose| pose.position.y);
        let text = format!("It lost its hold: first a piece {height:.1} m up, which {how}");
        *told = Some((text, now));
    }
    let fresh = |what: &Option<(String, f32)>| {
        let what = what.clone().filter(|(_, when)| now - when < STAYS);
        what.map(|(text, _)| text)
    };
    let texts: Vec<String> = [&*told, &notice.0].into_iter().filter_map(fresh).collect();
    if !texts.is_empty() {
        let above = if timeline.is_some() {
            timeline::HEIGHT
        } else {
            0.0
        };
        egui::Window::new("banner")
            .title_bar(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_BOTTOM, [110.0, -16.0 - above])
            .show(contexts.ctx_mut()?, |ui| {
                for text in texts {
                    ui.strong(text);
                }
            });
    }
    Ok(())
}

fn help(mut contexts: EguiContexts, mut overlays: ResMut<Overlays>) -> Result {
    let mut open = overlays.help;
    egui::Window::new("Help")
        .open(&mut open)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, [110.0, 0.0])
        .show(contexts.ctx_mut()?, |ui| {
            egui::Grid::new("keys").num_columns(2).show(ui, |ui| {
                for (key, what) in HELP {
                    ui.strong(*key);
                    ui.label(*what);
                    ui.end_row();
                }
            });
        });
    if open != overlays.help {
        overlays.help = open;
    }
    Ok(())
}
