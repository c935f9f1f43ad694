//! The tools of the left button.

mod carry;
mod ghost;
mod hand;
pub mod keys;
mod lay;
mod press;
mod take;
mod throw;

pub use carry::Carried;
pub use ghost::{Ghost, Spot};
pub use press::Pressed;
pub use throw::throw;

use crate::BuilderSystems;
use crate::journal::{Entry, Journal};
use crate::pieces::{Piece, palette};
use bevy::prelude::*;

/// The tools and their keys.
pub struct ToolsPlugin;

impl Plugin for ToolsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Tool>()
            .init_resource::<Choice>()
            .init_resource::<Strength>()
            .init_resource::<Ghost>()
            .init_resource::<Carried>()
            .init_resource::<Pressed>()
            .init_resource::<Notice>()
            .add_systems(Startup, (ghost::spawn, hand::spawn))
            .add_systems(
                Update,
                (
                    keys::keys,
                    carry::take_up,
                    ghost::find,
                    lay::lay.run_if(resource_equals(Tool::Lay)),
                    carry::put_down,
                    hand::hold,
                    press::press,
                    take::take.run_if(resource_equals(Tool::Take)),
                    throw::on_click.run_if(resource_equals(Tool::Throw)),
                )
                    .chain()
                    .in_set(BuilderSystems::Act),
            )
            .add_systems(
                Update,
                (ghost::draw, hand::draw, press::draw).in_set(BuilderSystems::Show),
            );
    }
}

/// The tool of the left button.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tool {
    /// Lays the piece that is chosen from the palette.
    #[default]
    Lay,
    /// Drags a piece to another place.
    Move,
    /// Lifts with a hand of limited force.
    Hand,
    /// Presses where it points, and drags aside.
    Press,
    /// Removes a piece, and shows beforehand what would fall.
    Take,
    /// Throws a ball.
    Throw,
}

impl Tool {
    /// All, in the order of their keys, from 1.
    pub const ALL: [Self; 6] = [
        Self::Lay,
        Self::Move,
        Self::Hand,
        Self::Press,
        Self::Take,
        Self::Throw,
    ];

    /// Its name and function.
    pub fn about(self) -> [&'static str; 2] {
        match self {
            Self::Lay => ["Lay", "click: lay the piece · Q, E: turn · Shift: freely"],
            Self::Move => [
                "Move",
                "drag a piece to its place · Q, E: turn · Shift: freely",
            ],
            Self::Hand => [
                "Hand",
                "drag: lift and pull · wheel: nearer, farther · Q, E: turn",
            ],
            Self::Press => ["Press", "hold: press on a face · drag aside: tip"],
            Self::Take => ["Take", "point: what would fall · click: take"],
            Self::Throw => ["Throw", "click: throw a ball"],
        }
    }
}

/// The piece that is laid next.
#[derive(Resource, Clone, Debug)]
pub struct Choice {
    /// It.
    pub piece: Piece,
    /// Its name in the palette; a copy of another piece has none.
    pub name: Option<&'static str>,
    /// About the vertical, rad.
    pub yaw: f32,
}

impl Default for Choice {
    fn default() -> Self {
        let (name, piece) = palette().swap_remove(0);
        Self {
            piece,
            name: Some(name),
            yaw: 0.0,
        }
    }
}

/// How strong one is.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Maximum force of the hand, N.
    pub hand: f32,
    /// Pressing force, N.
    pub press: f32,
    /// Speed of thrown balls, m/s.
    pub throw: f32,
}

impl Default for Strength {
    fn default() -> Self {
        Self {
            hand: 12_000.0,
            press: 8_000.0,
            throw: 14.0,
        }
    }
}

/// The last error, for the panel.
#[derive(Resource, Default)]
pub struct Notice(pub Option<(String, f32)>);

/// Does something, and says so where it cannot be done.
pub fn attempt(commands: &mut Commands, act: impl FnOnce(&mut World) -> Result + Send + 'static) {
    commands.queue(move |world: &mut World| {
        if let Err(error) = act(world) {
            refuse(world, error.to_string().trim().to_owned());
        }
    });
}

/// Says why something is not done.
pub fn refuse(world: &mut World, why: String) {
    warn!("{why}");
    let now = world.resource::<Time<Real>>().elapsed_secs();
    world.resource_mut::<Notice>().0 = Some((why.clone(), now));
    world.resource::<Journal>().say(&Entry::Refused { why });
}
