//! Who woke whom, as lines of text.

use crate::graph::{Wake, Wakes};
use crate::settings::StepTime;
use bevy_ecs::prelude::*;

/// Number of lines.
pub(super) const LINES: usize = 6;

/// Number of characters of a name that are shown.
const NAME: usize = 16;

/// How long ago, and what happened; the newest first. Lines without an event are empty.
pub(super) fn lines(world: &World) -> [[String; 2]; LINES] {
    let mut lines = [const { [String::new(), String::new()] }; LINES];
    let (Some(wakes), Some(time)) = (
        world.get_resource::<Wakes>(),
        world.get_resource::<StepTime>(),
    ) else {
        return lines;
    };
    for (line, wake) in lines.iter_mut().zip(wakes.recent().rev()) {
        let ago = (wakes.runs() - wake.run) as f32 * time.dt;
        *line = [ago_of(ago), text_of(world, wake)];
    }
    lines
}

fn ago_of(seconds: f32) -> String {
    match seconds < 100.0 {
        true => format!("{seconds:.1} s"),
        false => format!("{:.0} min", seconds / 60.0),
    }
}

fn text_of(world: &World, wake: &Wake) -> String {
    let more = match wake.count {
        1 => String::new(),
        count => format!(" +{}", count - 1),
    };
    let by = wake.by.map(|by| format!(" by {}", name(world, by)));
    let by = by.unwrap_or_default();
    format!("{}{more}: {}{by}", name(world, wake.first), wake.reason)
}

/// The name of a body, or its number.
fn name(world: &World, body: Entity) -> String {
    match world.get::<Name>(body) {
        Some(name) => name.as_str().chars().take(NAME).collect(),
        None => body.to_string(),
    }
}
