//! The nodes of the panel. All widths and numbers of lines are fixed, so that nothing moves when a figure changes.

use super::PhysicsPanel;
use super::figures::Figures;
use super::wakes;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_text::{FontSize, TextColor, TextFont, TextLayout};
use bevy_ui::widget::Text;
use bevy_ui::{
    AlignItems, BackgroundColor, BorderRadius, FlexDirection, GlobalZIndex, JustifyContent, Node,
    Overflow, PositionType, UiRect, Val,
};

/// The entities of the panel.
#[derive(Resource, Debug, Default)]
pub(super) struct Nodes {
    pub root: Option<Entity>,
    step: Option<Row>,
    stages: Vec<Row>,
    counts: Vec<Entity>,
    wakes: Vec<[Entity; 2]>,
}

/// Where a text stands in its cell.
#[derive(Clone, Copy)]
enum Side {
    Left,
    Right,
}

/// A line with a bar.
#[derive(Clone, Copy, Debug)]
struct Row {
    bar: Entity,
    time: Entity,
}

/// Widths of the columns, and heights of a line and of a bar, logical pixels.
const NAMES: f32 = 128.0;
const BARS: f32 = 110.0;
const TIMES: f32 = 118.0;
const AGO: f32 = 54.0;
const LINE: f32 = 15.0;
const BAR: f32 = 7.0;
const WHOLE: f32 = NAMES + BARS + TIMES;

const FONT: f32 = 12.0;
const BACK: Color = Color::srgba(0.05, 0.06, 0.08, 0.92);
const DIM: Color = Color::srgb(0.62, 0.67, 0.74);
const BRIGHT: Color = Color::srgb(0.94, 0.95, 0.97);
const TROUGH: Color = Color::srgba(1.0, 1.0, 1.0, 0.09);
const STAGE: Color = Color::srgb(0.36, 0.62, 0.92);
const EASY: Color = Color::srgb(0.38, 0.76, 0.44);
const HARD: Color = Color::srgb(0.95, 0.72, 0.25);
const LATE: Color = Color::srgb(0.93, 0.33, 0.27);

/// The names of the counts, in the order of [`counts`].
const COUNTS: [&str; 7] = [
    "bodies", "fixed", "islands", "pairs", "joints", "memory", "",
];

/// The counts as text.
fn counts(figures: &Figures) -> [String; COUNTS.len()] {
    let f = figures;
    let [bodies, pairs, table] = f.memory.map(bytes);
    [
        format!("{} awake, {} asleep", f.awake, f.asleep),
        format!("{} static, {} kinematic", f.fixed, f.kinematic),
        match f.islands {
            0 => "none awake".into(),
            count => format!("{count} awake, largest {}", f.largest),
        },
        format!("{} visited of {}", f.active_pairs, f.pairs),
        format!("{}", f.joints),
        format!("bodies {bodies}, pairs {pairs}"),
        format!("table {table}"),
    ]
}

fn bytes(count: usize) -> String {
    let kib = count as f32 / 1024.0;
    match kib < 1000.0 {
        true => format!("{kib:.0} KiB"),
        false => format!("{:.1} MiB", kib / 1024.0),
    }
}

/// Despawns the panel.
pub(super) fn despawn(world: &mut World) {
    let nodes = std::mem::take(&mut *world.resource_mut::<Nodes>());
    if let Some(root) = nodes.root
        && let Ok(root) = world.get_entity_mut(root)
    {
        root.despawn();
    }
}

/// Writes the figures. Spawns the panel if it is not there, or lacks a stage.
pub(super) fn write(world: &mut World, panel: &PhysicsPanel, figures: &Figures) {
    let nodes = world.resource::<Nodes>();
    let is_there = nodes
        .root
        .is_some_and(|root| world.entities().contains(root));
    if !is_there || nodes.stages.len() != figures.stages.len() {
        despawn(world);
        let nodes = spawn(world, panel, figures);
        world.insert_resource(nodes);
    }
    world.resource_scope(|world, nodes: Mut<Nodes>| {
        if let Some(mut root) = nodes.root.and_then(|root| world.get_mut::<Node>(root)) {
            let place = panel.place;
            let wanted = [place.left, place.right, place.top, place.bottom];
            if [root.left, root.right, root.top, root.bottom] != wanted {
                [root.left, root.right, root.top, root.bottom] = wanted;
            }
        }
        let step = figures.step.get();
        if let Some(row) = nodes.step {
            let share = step / figures.length.max(1e-3);
            set_bar(world, row.bar, share);
            set_color(
                world,
                row.bar,
                match share {
                    ..0.5 => EASY,
                    ..1.0 => HARD,
                    _ => LATE,
                },
            );
            let text = format!("{step:.2} of {:.1} ms", figures.length);
            set_text(world, row.time, text);
        }
        for (row, (_, mean)) in nodes.stages.iter().zip(&figures.stages) {
            set_bar(world, row.bar, mean.get() / step.max(1e-6));
            set_text(world, row.time, format!("{:.3} ms", mean.get()));
        }
        for (&node, text) in nodes.counts.iter().zip(counts(figures)) {
            set_text(world, node, text);
        }
        let lines = wakes::lines(world);
        for (line, texts) in nodes.wakes.iter().zip(lines) {
            for (&node, text) in line.iter().zip(texts) {
                set_text(world, node, text);
            }
        }
    });
}

fn set_text(world: &mut World, node: Entity, text: String) {
    if let Some(mut shown) = world.get_mut::<Text>(node)
        && shown.0 != text
    {
        shown.0 = text;
    }
}

/// A bar of a share from 0 to 1.
fn set_bar(world: &mut World, node: Entity, share: f32) {
    // A tenth of a percent is less than a pixel.
    let width = Val::Percent((1000.0 * share.clamp(0.0, 1.0)).round() * 0.1);
    if let Some(mut bar) = world.get_mut::<Node>(node)
        && bar.width != width
    {
        bar.width = width;
    }
}

fn set_color(world: &mut World, node: Entity, color: Color) {
    if let Some(mut known) = world.get_mut::<BackgroundColor>(node) {
        known.set_if_neq(BackgroundColor(color));
    }
}

fn spawn(world: &mut World, panel: &PhysicsPanel, figures: &Figures) -> Nodes {
    let place = panel.place;
    let root = Node {
        position_type: PositionType::Absolute,
        left: place.left,
        right: place.right,
        top: place.top,
        bottom: place.bottom,
        flex_direction: FlexDirection::Column,
        padding: UiRect::all(Val::Px(8.0)),
        border_radius: BorderRadius::all(Val::Px(5.0)),
        ..Default::default()
    };
    let name = Name::new("physics panel");
    let above = GlobalZIndex(i32::MAX / 2);
    let root = world.spawn((root, BackgroundColor(BACK), above, name)).id();
    let step = bar_row(world, root, "step", EASY, BRIGHT);
    let stages = figures.stages.iter().map(|(name, _)| {
        let name = name.replace('_', " ");
        bar_row(world, root, &name, STAGE, DIM)
    });
    let stages = stages.collect();
    gap(world, root);
    let counts = COUNTS.map(|name| {
        let line = line(world, root);
        text(world, line, name, NAMES, DIM, Side::Left);
        text(world, line, "", BARS + TIMES, BRIGHT, Side::Left)
    });
    gap(world, root);
    let title = line(world, root);
    text(world, title, "woke", WHOLE, DIM, Side::Left);
    let wakes = (0..wakes::LINES).map(|_| {
        let line = line(world, root);
        [
            text(world, line, "", AGO, DIM, Side::Left),
            text(world, line, "", WHOLE - AGO, BRIGHT, Side::Left),
        ]
    });
    Nodes {
        root: Some(root),
        step: Some(step),
        stages,
        counts: counts.to_vec(),
        wakes: wakes.collect(),
    }
}

/// A line of the panel.
fn line(world: &mut World, root: Entity) -> Entity {
    let node = Node {
        height: Val::Px(LINE),
        width: Val::Px(WHOLE),
        align_items: AlignItems::Center,
        ..Default::default()
    };
    world.spawn((node, ChildOf(root))).id()
}

/// Space between parts of the panel.
fn gap(world: &mut World, root: Entity) {
    let node = Node {
        height: Val::Px(0.5 * LINE),
        ..Default::default()
    };
    world.spawn((node, ChildOf(root)));
}

/// A line with a name, a bar and a time.
fn bar_row(world: &mut World, root: Entity, name: &str, color: Color, of_name: Color) -> Row {
    let line = line(world, root);
    text(world, line, name, NAMES, of_name, Side::Left);
    let size = |width| Node {
        width,
        height: Val::Px(BAR),
        border_radius: BorderRadius::all(Val::Px(2.0)),
        ..Default::default()
    };
    let trough = (size(Val::Px(BARS)), BackgroundColor(TROUGH), ChildOf(line));
    let trough = world.spawn(trough).id();
    let bar = (
        size(Val::Percent(0.0)),
        BackgroundColor(color),
        ChildOf(trough),
    );
    let bar = world.spawn(bar).id();
    let time = text(world, line, "", TIMES, BRIGHT, Side::Right);
    Row { bar, time }
}

/// A text of a fixed width in a line. What is longer is cut off.
fn text(
    world: &mut World,
    line: Entity,
    text: &str,
    width: f32,
    color: Color,
    side: Side,
) -> Entity {
    // Text that must not wrap is as wide as it is: the cell places and cuts it.
    let cell = Node {
        width: Val::Px(width),
        height: Val::Px(LINE),
        align_items: AlignItems::Center,
        justify_content: match side {
            Side::Left => JustifyContent::FlexStart,
            Side::Right => JustifyContent::FlexEnd,
        },
        overflow: Overflow::clip(),
        ..Default::default()
    };
    let cell = world.spawn((cell, ChildOf(line))).id();
    let font = TextFont::from_font_size(FontSize::Px(FONT));
    let layout = TextLayout::no_wrap();
    let text = (Text::new(text), font, layout, TextColor(color));
    world.spawn((text, ChildOf(cell))).id()
}
