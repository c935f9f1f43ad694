//! A preview of what falls if the piece under the mouse is removed, off the main thread.

use super::Overlays;
use crate::camera::Pointer;
use crate::edits::Edits;
use crate::journal::{Entry, Journal};
use crate::tools::Tool;
use bevy::prelude::*;
use bevy::tasks::{Task, futures::check_ready};
use drystone::prelude::*;

type Answer = Result<Preview, PreviewError>;

/// The last answer, and the question that is on its way.
#[derive(Resource, Default)]
pub struct Falls {
    /// The body of the last question, the number of edits then, and the time, s.
    asked: Option<(Entity, u64, f32)>,
    task: Option<Task<Answer>>,
    answer: Option<Preview>,
}

/// An answer is asked for again after so long, s: the world goes on.
const AGE: f32 = 1.5;

impl Falls {
    /// Whether a body would move.
    pub fn moves(&self, body: Entity) -> bool {
        self.answer
            .as_ref()
            .is_some_and(|preview| preview.moves(body))
    }

    /// How many would, of the piece under the mouse.
    pub fn count(&self) -> Option<usize> {
        Some(self.answer.as_ref()?.moved.len())
    }
}

/// Has to have the whole world, for the copy.
pub(super) fn ask(world: &mut World) {
    world.resource_scope(|world, mut falls: Mut<Falls>| {
        let wanted = world
            .resource::<Overlays>()
            .asks_what_falls(*world.resource::<Tool>());
        let body = world.resource::<Pointer>().body.filter(|_| wanted);
        let edits = world.resource::<Edits>().0;
        let now = world.resource::<Time<Real>>().elapsed_secs();
        let about = falls.asked.map(|(body, edits, _)| (body, edits));
        if about != body.map(|body| (body, edits)) {
            falls.answer = None;
        }
        if let Some(task) = &mut falls.task {
            let Some(answer) = check_ready(task) else {
                return;
            };
            falls.task = None;
            // Answers about a body that is not pointed at any more are dropped.
            if let (Some((of, at, _)), Ok(preview)) = (falls.asked, answer)
                && Some((of, at)) == body.map(|body| (body, edits))
            {
                let moved = preview.moved.iter();
                let entry = Entry::WouldFall {
                    body: of.to_string(),
                    falls: moved.map(|moved| moved.body.to_string()).collect(),
                };
                if falls.answer.as_ref().map(|old| old.moved.len()) != Some(preview.moved.len()) {
                    world.resource::<Journal>().say(&entry);
                }
                falls.answer = Some(preview);
            }
        }
        let Some(body) = body else {
            falls.asked = None;
            return;
        };
        let fresh = falls
            .asked
            .is_some_and(|(of, at, when)| (of, at) == (body, edits) && now - when < AGE);
        if !fresh {
            falls.asked = Some((body, edits, now));
            let edit = Edit::Remove(vec![body]);
            // It is none before the first step that knows it.
            falls.task = preview_task(world, &edit, PreviewSettings::default()).ok();
        }
    });
}
