//! Edits: making, undoing and saving them.

use crate::compare;
use crate::journal::{Entry, Journal};
use crate::pieces::{Piece, to_transform};
use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use drystone::masonry::EditLog;
use drystone::prelude::*;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::PathBuf;

/// The log of edits.
pub struct EditsPlugin;

impl Plugin for EditsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EditLog>()
            .init_resource::<Edits>()
            .init_resource::<SaveFile>();
    }
}

/// Number of edits so far: answers from before an edit are outdated.
#[derive(Resource, Default)]
pub struct Edits(pub u64);

/// Where scenes are saved.
#[derive(Resource)]
pub struct SaveFile(pub PathBuf);

impl Default for SaveFile {
    fn default() -> Self {
        Self("builder.ron".into())
    }
}

/// A piece and where it is, as it is saved.
#[derive(Serialize, Deserialize)]
struct Saved {
    piece: Piece,
    position: Vec3,
    rotation: Quat,
}

/// With the log at hand, and the original in sight.
fn with_log<T>(world: &mut World, edit: impl FnOnce(&mut World, &mut EditLog) -> T) -> T {
    compare::end(world);
    let done = world.resource_scope(|world, mut log: Mut<EditLog>| edit(world, &mut log));
    world.resource_mut::<Edits>().0 += 1;
    // Queries in the same frame must see the edit.
    drystone::refresh(world);
    done
}

/// Lays a piece.
///
/// # Errors
/// If it has no size.
pub fn place(world: &mut World, piece: &Piece, pose: Pose) -> Result<Entity> {
    let body = world.spawn(piece.bundle(pose)?).id();
    with_log(world, |world, log| log.record_placed(world, &[body]))?;
    world.resource::<Journal>().say(&Entry::Placed {
        body: body.to_string(),
        at: pose.position,
    });
    Ok(body)
}

/// Puts a piece elsewhere.
///
/// # Errors
/// If it is gone.
pub fn put(world: &mut World, body: Entity, pose: Pose) -> Result {
    with_log(world, |world, log| {
        log.move_to(world, body, to_transform(pose))
    })?;
    world.resource::<Journal>().say(&Entry::Moved {
        body: body.to_string(),
        at: pose.position,
    });
    Ok(())
}

/// Takes pieces away.
///
/// # Errors
/// If one is gone already.
pub fn take(world: &mut World, bodies: &[Entity]) -> Result {
    with_log(world, |world, log| log.remove(world, bodies))?;
    world.resource::<Journal>().say(&Entry::Took {
        bodies: bodies.iter().map(Entity::to_string).collect(),
    });
    Ok(())
}

/// Takes the last edit back.
///
/// # Errors
/// If a body of it is gone.
pub fn undo(world: &mut World) -> Result {
    if with_log(world, |world, log| log.undo(world))?.is_some() {
        world.resource::<Journal>().say(&Entry::Undid);
    }
    Ok(())
}

/// Makes the edit again that was taken back last.
///
/// # Errors
/// If a body of it is gone.
pub fn redo(world: &mut World) -> Result {
    if with_log(world, |world, log| log.redo(world))?.is_some() {
        world.resource::<Journal>().say(&Entry::Redid);
    }
    Ok(())
}

/// Takes all pieces away, for good.
pub fn clear(world: &mut World) {
    with_log(world, |world, log| log.clear(world));
    let mut pieces =
        world.query_filtered::<Entity, (With<Piece>, Or<(With<Disabled>, Without<Disabled>)>)>();
    let pieces: Vec<Entity> = pieces.iter(world).collect();
    for piece in pieces {
        world.despawn(piece);
    }
}

/// Writes the scene to the [`SaveFile`].
///
/// # Errors
/// If it cannot be written.
pub fn save(world: &mut World) -> Result {
    let path = world.resource::<SaveFile>().0.clone();
    let mut pieces = world.query::<(&Piece, &Pose)>();
    let saved = pieces.iter(world).map(|(piece, pose)| Saved {
        piece: piece.clone(),
        position: pose.position,
        rotation: pose.rotation,
    });
    let saved: Vec<Saved> = saved.collect();
    // Write to a temporary file first, so that the old file is not lost if this fails.
    let beside = path.with_extension("ron.new");
    fs::write(&beside, ron::ser::to_string_pretty(&saved, default())?)?;
    fs::rename(&beside, path)?;
    let pieces = saved.len();
    world.resource::<Journal>().say(&Entry::Saved { pieces });
    Ok(())
}

/// Replaces the scene by that in the [`SaveFile`].
///
/// # Errors
/// If it cannot be read, or contains something that is not a piece. The scene stays as it is then.
pub fn load(world: &mut World) -> Result {
    let path = world.resource::<SaveFile>().0.clone();
    let saved =
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let saved: Vec<Saved> = ron::from_str(&saved)?;
    let mut bundles = Vec::with_capacity(saved.len());
    for Saved {
        piece,
        position,
        rotation,
    } in saved
    {
        bundles.push(piece.bundle(Pose { position, rotation })?);
    }
    clear(world);
    let pieces = bundles.len();
    for bundle in bundles {
        world.spawn(bundle);
    }
    world.resource::<Journal>().say(&Entry::Loaded { pieces });
    Ok(())
}
