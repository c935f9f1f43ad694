//! The figures of the panel.

use crate::body::{BodyState, BodyTable, RigidBody};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint_types::JointEdge;
use crate::pair::ContactPair;
use crate::profile::Profile;
use crate::schedule::PhysicsSystems;
use crate::settings::StepTime;
use crate::state;
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::prelude::*;
use std::collections::HashMap;
use std::time::Duration;

/// What the panel shows, besides who woke whom.
#[derive(Resource, Debug, Default)]
pub(super) struct Figures {
    /// Mean time of a step, ms.
    pub step: Mean,
    /// Length of a step, ms.
    pub length: f32,
    /// Name and mean time of each stage, ms.
    pub stages: Vec<(&'static str, Mean)>,
    pub awake: usize,
    pub asleep: usize,
    pub fixed: usize,
    pub kinematic: usize,
    pub islands: usize,
    /// Number of bodies in the largest island.
    pub largest: usize,
    pub active_pairs: usize,
    pub pairs: usize,
    pub joints: usize,
    /// Bytes of the components of bodies, of those of pairs, and of the table of bodies.
    pub memory: [usize; 3],
}

/// A mean over about a second.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean {
    sum: f32,
    count: u32,
    value: Option<f32>,
}

/// How much of the samples of an interval is taken over.
const NEW: f32 = 0.25;

impl Mean {
    fn add(&mut self, time: Duration) {
        self.sum += 1e3 * time.as_secs_f32();
        self.count += 1;
    }

    /// Takes over the samples since the last call.
    fn settle(&mut self) {
        if self.count > 0 {
            let new = self.sum / self.count as f32;
            let old = self.value.unwrap_or(new);
            self.value = Some(old + NEW * (new - old));
            (self.sum, self.count) = (0.0, 0);
        }
    }

    /// ms
    pub fn get(&self) -> f32 {
        self.value.unwrap_or_default()
    }
}

impl Figures {
    /// Adds the times of the last step.
    pub fn sample(&mut self, world: &World) {
        let Some(profile) = world.get_resource::<Profile>() else {
            return;
        };
        self.step.add(profile.step);
        for (name, time) in profile.systems() {
            match self.stages.iter_mut().find(|(of, _)| *of == name) {
                Some((_, mean)) => mean.add(time),
                None => {
                    let mut mean = Mean::default();
                    mean.add(time);
                    self.stages.push((name, mean));
                    self.stages.sort_by_key(|(name, _)| place_of(name));
                }
            }
        }
    }

    /// Counts bodies, islands, pairs and bytes.
    pub fn count(&mut self, world: &World) {
        self.step.settle();
        self.stages.iter_mut().for_each(|(_, mean)| mean.settle());
        let Some(table) = world.get_resource::<BodyTable>() else {
            return;
        };
        let time = world.get_resource::<StepTime>();
        self.length = time.map_or(0.0, |time| 1e3 * time.dt * time.substeps as f32);
        [self.awake, self.asleep, self.fixed, self.kinematic] = [0; 4];
        for (_, body) in table.iter() {
            *match (body.is_dynamic(), body.asleep, body.is_static()) {
                (true, false, _) => &mut self.awake,
                (true, true, _) => &mut self.asleep,
                (false, _, true) => &mut self.fixed,
                (false, _, false) => &mut self.kinematic,
            } += 1;
        }
        if let Some(islands) = world.get_resource::<Islands>() {
            self.islands = islands.count();
            let sizes = islands.numbered().iter();
            let sizes = sizes.map(|&id| islands.members_of_id(id).len());
            self.largest = sizes.max().unwrap_or(0);
        }
        if let Some(graph) = world.get_resource::<ConstraintGraph>() {
            self.active_pairs = graph.active_pairs().len();
            self.pairs = graph.edge_count();
        }
        let sizes = Sizes::of(world);
        let [bodies, pairs] = [
            Components::component_id::<RigidBody>,
            Components::component_id::<ContactPair>,
        ]
        .map(|find| find(world.components()).map_or(0, |id| sizes.bytes(world, id)));
        let rows = table.slots() * size_of::<Option<BodyState>>();
        self.memory = [bodies, pairs, rows];
        let joint = world.components().component_id::<JointEdge>();
        let with_joint = |id| world.archetypes().iter().filter(move |of| of.contains(id));
        self.joints = joint.map_or(0, |id| with_joint(id).map(|of| of.len() as usize).sum());
    }
}

/// The place of a stage in a step, by its name. Other systems come last.
fn place_of(name: &str) -> usize {
    let name = name.replace('_', "");
    let is_same = |stage: &PhysicsSystems| format!("{stage:?}").eq_ignore_ascii_case(&name);
    let order = PhysicsSystems::ORDER;
    order.iter().position(is_same).unwrap_or(order.len())
}

/// The sizes of drystone's components.
struct Sizes(HashMap<ComponentId, usize>);

impl Sizes {
    fn of(world: &World) -> Self {
        let components = world.components();
        let kinds = state::list().components.iter();
        let sizes = kinds.filter_map(|kind| {
            let id = components.get_id(kind.type_id())?;
            Some((id, components.get_info(id)?.layout().size()))
        });
        Self(sizes.collect())
    }

    /// Bytes of drystone's components on all entities that have a component.
    fn bytes(&self, world: &World, with: ComponentId) -> usize {
        let archetypes = world.archetypes().iter().filter(|of| of.contains(with));
        let bytes = archetypes.map(|archetype| {
            let sizes = archetype.components().iter().map(|id| self.0.get(id));
            archetype.len() as usize * sizes.flatten().sum::<usize>()
        });
        bytes.sum()
    }
}
