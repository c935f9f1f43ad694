//! A journal of events, line by line, for scripts: with `--journal` each [`Entry`] is a line of RON after the word `journal`.

use crate::BuilderSystems;
use crate::camera::Eye;
use crate::pieces::Piece;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use drystone::prelude::*;
use serde::{Deserialize, Serialize};

/// Prints events.
pub struct JournalPlugin;

impl Plugin for JournalPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Journal>()
            .init_resource::<Widgets>()
            .add_systems(
                Update,
                (collapses, look.run_if(wants_to_look)).in_set(BuilderSystems::Show),
            );
    }
}

/// Whether anybody listens.
#[derive(Resource, Default)]
pub struct Journal {
    /// By `--journal`.
    pub on: bool,
}

/// The positions of the panel's buttons, logical pixels.
#[derive(Resource, Default)]
pub struct Widgets(pub HashMap<String, [f32; 2]>);

/// A line.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Entry {
    /// A scene has been opened, with so many pieces.
    Opened { scene: String, pieces: usize },
    /// The answer to the key `L`.
    Sees(Box<Sight>),
    /// A piece was laid.
    Placed { body: String, at: Vec3 },
    /// A piece was put elsewhere.
    Moved { body: String, at: Vec3 },
    /// Pieces were taken.
    Took { bodies: Vec<String> },
    /// The last edit was taken back.
    Undid,
    /// The last edit taken back was made again.
    Redid,
    /// A hand took hold.
    Held { body: String },
    /// A piece is pressed with so many newtons.
    Pressed { body: String, force: f32 },
    /// It is pressed no more.
    Released { body: String },
    /// A ball was thrown.
    Threw,
    /// The bodies that would fall if a piece were removed.
    WouldFall { body: String, falls: Vec<String> },
    /// The least tilt, °, that a structure bears.
    Margin { tilt: f32, moving: usize },
    /// A structure has lost its hold.
    Collapsed { first: String, how: String },
    /// The scene was saved or loaded.
    Saved { pieces: usize },
    /// See `Saved`.
    Loaded { pieces: usize },
    /// A picture has been asked for.
    Picture { path: String },
    /// Something could not be done.
    Refused { why: String },
}

/// The positions of all bodies.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Sight {
    /// Whether all bodies are at rest.
    pub rests: bool,
    /// Bodies, their places, m, and their turns.
    pub bodies: Vec<(String, Vec3, Quat)>,
    /// From the world to clip space.
    pub clip_from_world: Mat4,
    /// Size of the window, logical pixels.
    pub viewport: Vec2,
    /// Buttons of the panel, logical pixels.
    pub widgets: Vec<(String, [f32; 2])>,
}

impl Sight {
    /// The position of a point of the world in the window, logical pixels.
    pub fn on_screen(&self, place: Vec3) -> Vec2 {
        let clip = self.clip_from_world.project_point3(place);
        let unit = Vec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
        unit * self.viewport
    }
}

impl Journal {
    /// Prints an event, if the journal is on.
    pub fn say(&self, entry: &Entry) {
        if self.on {
            match ron::to_string(entry) {
                Ok(line) => println!("journal {line}"),
                Err(error) => error!("the journal has no words for {entry:?}: {error}"),
            }
        }
    }
}

fn collapses(journal: Res<Journal>, mut messages: MessageReader<Collapse>) {
    for collapse in messages.read() {
        journal.say(&Entry::Collapsed {
            first: collapse.first.to_string(),
            how: format!("{:?}", collapse.how),
        });
    }
}

fn wants_to_look(journal: Res<Journal>, keys: Res<ButtonInput<KeyCode>>) -> bool {
    journal.on && keys.just_pressed(KeyCode::KeyL)
}

fn look(
    journal: Res<Journal>,
    widgets: Res<Widgets>,
    bodies: Query<(Entity, &RigidBody, &Pose, &Sleeping), With<Piece>>,
    eye: Single<(&Camera, &GlobalTransform), With<Eye>>,
) {
    let (camera, at) = *eye;
    let seen = bodies.iter();
    let seen = seen.map(|(entity, _, pose, _)| (entity.to_string(), pose.position, pose.rotation));
    let rests = bodies.iter().all(|(_, kind, _, sleeping)| {
        *kind != RigidBody::Dynamic || sleeping.asleep || sleeping.still_for > 0.25
    });
    journal.say(&Entry::Sees(Box::new(Sight {
        rests,
        bodies: seen.collect(),
        clip_from_world: camera.clip_from_view() * at.to_matrix().inverse(),
        viewport: camera.logical_viewport_size().unwrap_or_default(),
        widgets: widgets
            .0
            .iter()
            .map(|(name, at)| (name.clone(), *at))
            .collect(),
    })));
}
