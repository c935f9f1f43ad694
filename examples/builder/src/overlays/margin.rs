//! How safe the structure under the mouse stands, by limit analysis on a copy, off the main thread.

use super::Overlays;
use crate::camera::Pointer;
use crate::edits::Edits;
use crate::journal::{Entry, Journal};
use bevy::ecs::system::RunSystemOnce;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, futures::check_ready};
use drystone::prelude::*;
use drystone::stability::{JointFailure, Trial, stability};

/// The last answer, and the question that is on its way.
#[derive(Resource, Default)]
pub struct Margins {
    asked: Option<(Vec<Entity>, u64)>,
    task: Option<Task<Result<Weakest, String>>>,
    answer: Option<Result<Weakest, String>>,
}

/// Where a structure is weakest.
#[derive(Clone, Debug)]
pub struct Weakest {
    /// The tilt at which it fails, rad.
    pub tilt: f32,
    /// Towards which it is tilted then.
    pub towards: Vec3,
    /// The bodies that move then.
    pub moving: HashSet<Entity>,
    /// How its joints give way.
    pub how: &'static str,
}

/// A tilt is tried in so many directions.
const DIRECTIONS: usize = 8;

/// Larger structures take too long.
const LARGEST: usize = 400;

impl Margins {
    /// Whether a body is among those that fail first.
    pub fn moves(&self, body: Entity) -> bool {
        matches!(&self.answer, Some(Ok(weakest)) if weakest.moving.contains(&body))
    }

    /// The margin of the structure under the mouse, if known.
    pub fn answer(&self) -> Option<Result<&Weakest, &str>> {
        Some(self.answer.as_ref()?.as_ref().map_err(String::as_str))
    }

    /// It is on its way.
    pub fn is_asking(&self) -> bool {
        self.task.is_some()
    }
}

/// Has to have the whole world, for the copy.
pub(super) fn ask(world: &mut World) {
    let wanted = world.resource::<Overlays>().margin;
    let body = world.resource::<Pointer>().body.filter(|_| wanted);
    let structure = body.and_then(|body| {
        let structure = move |supports: Supports| supports.structure(body);
        world.run_system_once(structure).ok()?.ok()
    });
    world.resource_scope(|world, mut margins: Mut<Margins>| {
        if !wanted {
            *margins = Margins::default();
            return;
        }
        if let Some(task) = &mut margins.task {
            let Some(answer) = check_ready(task) else {
                return;
            };
            margins.task = None;
            if let Ok(weakest) = &answer {
                world.resource::<Journal>().say(&Entry::Margin {
                    tilt: weakest.tilt.to_degrees(),
                    moving: weakest.moving.len(),
                });
            }
            margins.answer = Some(answer);
        }
        let Some(structure) = structure else {
            return;
        };
        let question = (structure, world.resource::<Edits>().0);
        if margins.asked.as_ref() != Some(&question) {
            margins.answer = None;
            if question.0.len() > LARGEST {
                let size = question.0.len();
                margins.answer = Some(Err(format!("{size} pieces are too many to ask about")));
            } else if let Ok(shadow) = Shadow::around(world, &question.0) {
                let structure = question.0.clone();
                let pool = AsyncComputeTaskPool::get();
                margins.task = Some(pool.spawn(async move { weakest(shadow, &structure) }));
            }
            margins.asked = Some(question);
        }
    });
}

/// Tries all directions.
fn weakest(shadow: Shadow, structure: &[Entity]) -> Result<Weakest, String> {
    let copies = structure.iter();
    let copies: Vec<(Entity, Entity)> = copies
        .filter_map(|&body| Some((shadow.copy_of(body)?, body)))
        .collect();
    let mut world = shadow.into_world();
    // Its contacts are known after a step; in so short a one nothing moves.
    drystone::step(&mut world, 1e-5).map_err(|error| error.to_string())?;
    let bodies: Vec<Entity> = copies.iter().map(|(copy, _)| *copy).collect();
    let originals: HashMap<Entity, Entity> = copies.into_iter().collect();
    let mut weakest: Option<Weakest> = None;
    for number in 0..DIRECTIONS {
        let angle = number as f32 / DIRECTIONS as f32 * std::f32::consts::TAU;
        let towards = Vec3::new(angle.sin(), 0.0, angle.cos());
        let margin = stability(&world, &bodies, &Trial::Tilt(towards));
        let margin = margin.map_err(|error| error.to_string())?;
        if weakest
            .as_ref()
            .is_none_or(|weakest| margin.limit < weakest.tilt)
        {
            let moving = margin.moving.iter();
            let slides = margin
                .failing
                .iter()
                .filter(|joint| joint.how == JointFailure::Slides);
            weakest = Some(Weakest {
                tilt: margin.limit,
                towards,
                moving: moving
                    .filter_map(|m| originals.get(&m.body).copied())
                    .collect(),
                how: match (slides.count(), margin.failing.len()) {
                    (0, _) => "tips",
                    (slides, all) if slides == all => "slides",
                    _ => "slides and tips",
                },
            });
        }
    }
    weakest.ok_or_else(|| "nothing to ask about".into())
}
