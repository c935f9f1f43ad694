//! Undo and redo of edits.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use std::collections::VecDeque;
use thiserror::Error;

use super::drift::{Drift, Watched};
use crate::body::{BodyTable, Grab, Moved, Pose, RigidBody, Velocity, local_pose};

/// A list of edits to bodies with undo and redo. Edits made through it can be taken back.
///
/// A removed body is disabled and not despawned, together with its descendants. Undo therefore brings back the same entity in the same
/// state, to the bit; the bodies around it are unaffected as well if they have not moved in the meantime.
///
/// Undo restores the bodies that the edit removed, moved or placed, however far they or others have moved since. It leaves other bodies
/// where they are, and [reports](EditReport) which of them have moved since the edit.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::masonry::EditLog;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let mut log = EditLog::default();
/// let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5));
/// let brick = world.spawn((brick, Transform::from_xyz(0.0, 0.25, 0.0))).id();
/// log.record_placed(world, &[brick]).unwrap();
/// log.move_to(world, brick, Transform::from_xyz(3.0, 0.25, 0.0)).unwrap();
/// log.remove(world, &[brick]).unwrap();
/// log.undo(world).unwrap();
/// let undone = log.undo(world).unwrap().unwrap();
/// assert_eq!(undone.bodies, [brick]);
/// assert_eq!(world.get::<Transform>(brick).unwrap().translation.x, 0.0);
/// log.redo(world).unwrap();
/// assert_eq!(world.get::<Transform>(brick).unwrap().translation.x, 3.0);
/// ```
#[derive(Resource, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct EditLog {
    done: VecDeque<Entry>,
    undone: Vec<Operation>,
    watched: Watched,
}

/// An edit that has been made.
#[derive(Clone, Debug)]
struct Entry {
    edit: Operation,
    /// The changes of other bodies since this edit, until the next one.
    since: Drift,
}

/// One edit, with what is needed to undo and redo it.
#[derive(Clone, Debug)]
enum Operation {
    Placed {
        /// The poses and velocities of the bodies when they were placed.
        bodies: Vec<(Entity, Transform, Velocity)>,
        /// The entities that undoing it has disabled.
        disabled: Vec<Entity>,
    },
    Removed {
        bodies: Vec<Entity>,
        /// The entities that it has disabled, without those that were disabled before.
        disabled: Vec<Entity>,
    },
    Moved {
        body: Entity,
        before: (Transform, Velocity),
        after: Transform,
    },
}

/// The bodies of an edit that was undone or redone, and the other bodies that have changed since.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditReport {
    /// The bodies that the edit removed, moved or placed.
    pub bodies: Vec<Entity>,
    /// Other dynamic bodies that have moved by more than a twentieth of their radius: since the edit was made, or for a redo since the
    /// last use of the log. They are left at `to`. To move them back, call [`EditLog::move_to`] with `from`.
    pub moved: Vec<Moved>,
    /// Other dynamic bodies that were despawned or disabled since then.
    pub gone: Vec<Entity>,
}

/// Why an edit cannot be made or undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EditError {
    /// The entity has no [`RigidBody`], or no longer exists.
    #[error("{0} is no body, or is gone")]
    NotABody(Entity),
    /// The list of bodies is empty.
    #[error("an edit of no body")]
    Nothing,
    /// The transform is not finite.
    #[error("a body is to be put where no place is: its `Transform` is not finite")]
    NotFinite,
}

impl EditLog {
    /// Maximum number of edits that are kept. Older ones are forgotten.
    pub const MAX_EDITS: usize = 1000;

    /// Records that bodies have been spawned, as one edit.
    ///
    /// # Errors
    /// [`EditError`] if an entity is not a body, or the list is empty.
    pub fn record_placed(&mut self, world: &mut World, bodies: &[Entity]) -> Result<(), EditError> {
        check(world, bodies)?;
        self.look(world);
        let place = |&body: &Entity| {
            let velocity = world.get(body).copied().unwrap_or_default();
            (body, placement(world, body), velocity)
        };
        let bodies = bodies.iter().map(place).collect();
        let disabled = Vec::new();
        self.note(world, Operation::Placed { bodies, disabled });
        Ok(())
    }

    /// Removes bodies, as one edit.
    ///
    /// # Errors
    /// [`EditError`] if an entity is not a body, or the list is empty. Nothing is removed then.
    pub fn remove(&mut self, world: &mut World, bodies: &[Entity]) -> Result<(), EditError> {
        check(world, bodies)?;
        self.look(world);
        let disabled = disable(world, bodies);
        let bodies = bodies.into();
        self.note(world, Operation::Removed { bodies, disabled });
        Ok(())
    }

    /// Moves a body to a transform, at rest. For a child this is its local transform. A [`Grab`](crate::grab::Grab) of the body is removed.
    ///
    /// # Errors
    /// [`EditError`] if the entity is not a body, or the transform is not finite.
    pub fn move_to(
        &mut self,
        world: &mut World,
        body: Entity,
        after: Transform,
    ) -> Result<(), EditError> {
        check(world, &[body])?;
        if !after.is_finite() {
            return Err(EditError::NotFinite);
        }
        self.look(world);
        let velocity = world.get(body).copied().unwrap_or_default();
        let before = (placement(world, body), velocity);
        set(world, body, after, Velocity::default())?;
        self.note(
            world,
            Operation::Moved {
                body,
                before,
                after,
            },
        );
        Ok(())
    }

    /// Undoes the last edit: its bodies are where they were before it. Returns `None` if there is no edit.
    ///
    /// # Errors
    /// [`EditError`] if one of its bodies has been despawned. The rest of the edit is undone, and the edit is forgotten.
    pub fn undo(&mut self, world: &mut World) -> Result<Option<EditReport>, EditError> {
        self.look(world);
        let Some(Entry { mut edit, since }) = self.done.pop_back() else {
            return Ok(None);
        };
        let bodies = edit.bodies();
        let edited = EditReport::new(&bodies, &since);
        if let Some(before) = self.done.back_mut() {
            before.since.go_on(since, &bodies);
        }
        self.watched.forget(&bodies);
        edit.turn(world, false)?;
        self.undone.push(edit);
        Ok(Some(edited))
    }

    /// Redoes the edit that was undone last: its bodies are where it put them. Returns `None` if there is no such edit.
    ///
    /// # Errors
    /// As [`Self::undo`].
    pub fn redo(&mut self, world: &mut World) -> Result<Option<EditReport>, EditError> {
        let drift = self.look(world);
        let Some(mut edit) = self.undone.pop() else {
            return Ok(None);
        };
        let bodies = edit.bodies();
        let edited = EditReport::new(&bodies, &drift);
        self.watched.forget(&bodies);
        edit.turn(world, true)?;
        self.push(edit);
        Ok(Some(edited))
    }

    /// The numbers of edits that can be undone and redone.
    pub fn len(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    /// Returns true if nothing can be undone or redone.
    pub fn is_empty(&self) -> bool {
        self.len() == [0; 2]
    }

    /// Forgets all edits. Removed bodies are despawned.
    pub fn clear(&mut self, world: &mut World) {
        self.forget_undone(world);
        for entry in std::mem::take(&mut self.done) {
            entry.edit.forget(world, true);
        }
        self.watched = Watched::default();
    }

    /// Notes what has changed since the last use of the log.
    fn look(&mut self, world: &mut World) -> Drift {
        let drift = self.watched.look(world);
        if let Some(last) = self.done.back_mut() {
            last.since.go_on(drift.clone(), &[]);
        }
        drift
    }

    fn note(&mut self, world: &mut World, edit: Operation) {
        self.forget_undone(world);
        self.watched.forget(&edit.bodies());
        self.push(edit);
        if self.done.len() > Self::MAX_EDITS
            && let Some(oldest) = self.done.pop_front()
        {
            oldest.edit.forget(world, true);
        }
    }

    fn push(&mut self, edit: Operation) {
        let since = Drift::default();
        self.done.push_back(Entry { edit, since });
    }

    fn forget_undone(&mut self, world: &mut World) {
        for edit in std::mem::take(&mut self.undone) {
            edit.forget(world, false);
        }
    }
}

impl EditReport {
    fn new(bodies: &[Entity], drift: &Drift) -> Self {
        let (moved, gone) = drift.told(bodies);
        Self {
            bodies: bodies.into(),
            moved,
            gone,
        }
    }
}

impl Operation {
    fn bodies(&self) -> Vec<Entity> {
        match self {
            Self::Placed { bodies, .. } => bodies.iter().map(|(body, ..)| *body).collect(),
            Self::Removed { bodies, .. } => bodies.clone(),
            Self::Moved { body, .. } => vec![*body],
        }
    }

    /// Redoes the edit (`make`) or undoes it.
    fn turn(&mut self, world: &mut World, make: bool) -> Result<(), EditError> {
        let named = self.bodies();
        match self {
            Self::Placed { bodies, disabled } if make => {
                enable(world, std::mem::take(disabled));
                for &(body, at, velocity) in &*bodies {
                    // Bodies that do not exist any more are reported below.
                    set(world, body, at, velocity).ok();
                }
            }
            Self::Placed { disabled, .. } => *disabled = disable(world, &named),
            Self::Removed { disabled, .. } if make => *disabled = disable(world, &named),
            Self::Removed { disabled, .. } => enable(world, std::mem::take(disabled)),
            Self::Moved {
                body,
                before,
                after,
            } => match make {
                true => set(world, *body, *after, Velocity::default())?,
                false => set(world, *body, before.0, before.1)?,
            },
        }
        check(world, &named)
    }

    /// Despawns the bodies that it has disabled, which can no longer come back.
    fn forget(self, world: &mut World, made: bool) {
        let named = self.bodies();
        let disabled = match (self, made) {
            (Self::Removed { disabled, .. }, true) | (Self::Placed { disabled, .. }, false) => {
                disabled
            }
            _ => return,
        };
        for body in disabled.into_iter().filter(|body| named.contains(body)) {
            if let Ok(body) = world.get_entity_mut(body)
                && body.contains::<Disabled>()
            {
                body.despawn();
            }
        }
    }
}

fn check(world: &World, bodies: &[Entity]) -> Result<(), EditError> {
    if bodies.is_empty() {
        return Err(EditError::Nothing);
    }
    let mut missing = bodies.iter();
    match missing.find(|body| world.get::<RigidBody>(**body).is_none()) {
        Some(&body) => Err(EditError::NotABody(body)),
        None => Ok(()),
    }
}

/// Disables bodies and all below them: those that were not disabled before.
fn disable(world: &mut World, bodies: &[Entity]) -> Vec<Entity> {
    let mut disabled = Vec::new();
    let mut next: Vec<Entity> = bodies.iter().rev().copied().collect();
    while let Some(entity) = next.pop() {
        let Ok(mut entity) = world.get_entity_mut(entity) else {
            continue;
        };
        if !entity.contains::<Disabled>() {
            disabled.push(entity.id());
            entity.insert(Disabled);
        }
        if let Some(children) = entity.get::<Children>() {
            next.extend(children.iter().rev());
        }
    }
    disabled
}

fn enable(world: &mut World, disabled: Vec<Entity>) {
    for entity in disabled {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<Disabled>();
        }
    }
}

/// The pose of a body in the simulation, as a `Transform`. Between two steps its own `Transform` may be interpolated for rendering.
fn placement(world: &mut World, body: Entity) -> Transform {
    let drawn: Transform = world.get(body).copied().unwrap_or_default();
    let table = world.get_resource::<BodyTable>();
    let known = world.get(body).zip(table);
    let known = known.is_some_and(|(index, table)| table.holds(body, *index));
    let Some(&pose) = world.get::<Pose>(body).filter(|_| known) else {
        return drawn;
    };
    let mut placed = world.query::<(&Transform, Option<&ChildOf>)>();
    let local = local_pose(pose, world.get(body), placed.query(world));
    Transform {
        translation: local.position,
        rotation: local.rotation,
        ..drawn
    }
}

fn set(
    world: &mut World,
    body: Entity,
    transform: Transform,
    velocity: Velocity,
) -> Result<(), EditError> {
    let mut entity = world
        .get_entity_mut(body)
        .map_err(|_| EditError::NotABody(body))?;
    entity.insert((transform, velocity)).remove::<Grab>();
    Ok(())
}
