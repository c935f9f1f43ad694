//! Edits that can be taken back.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use std::collections::VecDeque;
use std::fmt;

use crate::body::{BodyTable, Pose, RigidBody, Velocity, local_pose};

/// A list of edits to bodies, with undo and redo. What is taken is not despawned but disabled, with all below it, so that it comes back as it was, as the same
/// entity: to the bit, and what stands around it as well if it has not moved in the meantime.
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
/// log.placed(world, &[brick]).unwrap();
/// log.put(world, brick, Transform::from_xyz(3.0, 0.25, 0.0)).unwrap();
/// log.take(world, &[brick]).unwrap();
/// assert_eq!(log.undo(world), Ok(true));
/// assert_eq!(log.undo(world), Ok(true));
/// assert_eq!(world.get::<Transform>(brick).unwrap().translation.x, 0.0);
/// assert_eq!(log.redo(world), Ok(true));
/// assert_eq!(world.get::<Transform>(brick).unwrap().translation.x, 3.0);
/// ```
#[derive(Resource, Debug, Default)]
pub struct EditLog {
    done: VecDeque<Edit>,
    undone: Vec<Edit>,
}

/// One edit.
#[derive(Clone, Debug)]
enum Edit {
    Placed(Vec<Entity>),
    Taken(Vec<Entity>),
    Put {
        body: Entity,
        before: (Transform, Velocity),
        after: Transform,
    },
}

/// Why an edit is not made, or not taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditError {
    /// No body: it has no [`RigidBody`], or is gone.
    NoBody(Entity),
    /// No body is named.
    Nothing,
    /// A place or turn that is not finite.
    NotFinite,
}

impl fmt::Display for EditError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBody(entity) => write!(f, "{entity} is no body, or is gone"),
            Self::Nothing => f.write_str("an edit of no body"),
            Self::NotFinite => {
                f.write_str("a body is to be put where no place is: its `Transform` is not finite")
            }
        }
    }
}

impl std::error::Error for EditError {}

impl EditLog {
    /// Edits that are kept; the oldest are forgotten.
    pub const LONGEST: usize = 1000;

    /// Notes that bodies have been spawned, as one edit.
    ///
    /// # Errors
    /// Where one is no body, or there is none.
    pub fn placed(&mut self, world: &mut World, bodies: &[Entity]) -> Result<(), EditError> {
        check(world, bodies)?;
        self.note(world, Edit::Placed(bodies.into()));
        Ok(())
    }

    /// Takes bodies away, as one edit.
    ///
    /// # Errors
    /// Where one is no body, or there is none; nothing is taken then.
    pub fn take(&mut self, world: &mut World, bodies: &[Entity]) -> Result<(), EditError> {
        check(world, bodies)?;
        disable(world, bodies);
        self.note(world, Edit::Taken(bodies.into()));
        Ok(())
    }

    /// Puts a body elsewhere, at rest; where it is the child of another, in the frame of that.
    ///
    /// # Errors
    /// Where it is no body, or is put where no place is.
    pub fn put(
        &mut self,
        world: &mut World,
        body: Entity,
        after: Transform,
    ) -> Result<(), EditError> {
        check(world, &[body])?;
        if !after.is_finite() {
            return Err(EditError::NotFinite);
        }
        let velocity = world.get(body).copied().unwrap_or_default();
        let before = (placement(world, body), velocity);
        set(world, body, after, Velocity::default())?;
        self.note(
            world,
            Edit::Put {
                body,
                before,
                after,
            },
        );
        Ok(())
    }

    /// Takes the last edit back; false where there is none.
    ///
    /// # Errors
    /// Where somebody has despawned one of its bodies; the edit is forgotten then, and what is left of it taken back.
    pub fn undo(&mut self, world: &mut World) -> Result<bool, EditError> {
        let Some(edit) = self.done.pop_back() else {
            return Ok(false);
        };
        edit.turn(world, false)?;
        self.undone.push(edit);
        Ok(true)
    }

    /// Makes the edit again that was taken back last; false where there is none.
    ///
    /// # Errors
    /// As [`Self::undo`].
    pub fn redo(&mut self, world: &mut World) -> Result<bool, EditError> {
        let Some(edit) = self.undone.pop() else {
            return Ok(false);
        };
        edit.turn(world, true)?;
        self.done.push_back(edit);
        Ok(true)
    }

    /// How many edits can be taken back, and made again.
    pub fn len(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    /// True where nothing can be taken back or made again.
    pub fn is_empty(&self) -> bool {
        self.len() == [0; 2]
    }

    /// Forgets all edits: what was taken is gone for good.
    pub fn clear(&mut self, world: &mut World) {
        self.forget_undone(world);
        for edit in std::mem::take(&mut self.done) {
            edit.forget(world, true);
        }
    }

    fn note(&mut self, world: &mut World, edit: Edit) {
        self.forget_undone(world);
        self.done.push_back(edit);
        if self.done.len() > Self::LONGEST
            && let Some(oldest) = self.done.pop_front()
        {
            oldest.forget(world, true);
        }
    }

    fn forget_undone(&mut self, world: &mut World) {
        for edit in std::mem::take(&mut self.undone) {
            edit.forget(world, false);
        }
    }
}

impl Edit {
    /// Makes it, or takes it back.
    fn turn(&self, world: &mut World, make: bool) -> Result<(), EditError> {
        match self {
            Self::Placed(bodies) if make => enable(world, bodies),
            Self::Placed(bodies) => disable(world, bodies),
            Self::Taken(bodies) if make => disable(world, bodies),
            Self::Taken(bodies) => enable(world, bodies),
            Self::Put {
                body,
                before,
                after,
            } => match make {
                true => set(world, *body, *after, Velocity::default())?,
                false => set(world, *body, before.0, before.1)?,
            },
        }
        match self {
            Self::Placed(bodies) | Self::Taken(bodies) => check(world, bodies),
            Self::Put { .. } => Ok(()),
        }
    }

    /// Nobody can call back what it has disabled.
    fn forget(self, world: &mut World, made: bool) {
        let gone = match (self, made) {
            (Self::Taken(bodies), true) | (Self::Placed(bodies), false) => bodies,
            _ => return,
        };
        for body in gone {
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
        Some(&body) => Err(EditError::NoBody(body)),
        None => Ok(()),
    }
}

fn disable(world: &mut World, bodies: &[Entity]) {
    for &body in bodies {
        if let Ok(mut body) = world.get_entity_mut(body) {
            body.insert_recursive::<Children>(Disabled);
        }
    }
}

fn enable(world: &mut World, bodies: &[Entity]) {
    for &body in bodies {
        if let Ok(mut body) = world.get_entity_mut(body) {
            body.remove_recursive::<Children, Disabled>();
        }
    }
}

/// Where physics has a body, as its `Transform` says it after a step: between two it may be drawn elsewhere.
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
        .map_err(|_| EditError::NoBody(body))?;
    entity.insert((transform, velocity));
    Ok(())
}
