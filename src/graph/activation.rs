//! Rest and activity: what sleeps or stands still gets the marker [`Resting`], island by island, and with it leaves what the stages go through;
//! what something is done to is active again.
//!
//! A body goes to rest in the step after it has fallen asleep. A pair goes to rest in the step after both of its bodies have, once what they
//! last did has been told. A body that is roused becomes active with all of its pairs, so a pair rests only where both of its bodies do.

use super::ConstraintGraph;
use super::islands::{Islands, Pairs};
use crate::body::{BodyTable, Resting};
use crate::settings::StepTime;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;

/// What is to go to rest.
#[derive(Default)]
pub(super) struct Tired {
    pub bodies: Vec<(u32, Entity)>,
    pub pairs: Vec<(Entity, [u32; 2])>,
}

impl Tired {
    fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.pairs.is_empty()
    }
}

/// Second part of the stage *islands*: bodies and pairs go to rest, or are roused; islands follow.
pub fn activation(world: &mut World, pairs: &mut SystemState<Pairs>) {
    let tired = std::mem::take(&mut world.resource_mut::<Islands>().tired);
    if tired.is_empty() && world.resource::<BodyTable>().stirred.is_empty() {
        return;
    }
    rouse(world);
    lay_down(world, tired);
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        world.resource_scope(|world, mut islands: Mut<Islands>| {
            let pairs = pairs.get(world).expect("pairs can always be read");
            let table = world.resource::<BodyTable>();
            islands.look(&mut graph, &pairs);
            islands.update(&mut graph, table);
            islands.find_arriving(table);
        });
    });
}

/// Lays down what is to rest.
fn lay_down(world: &mut World, Tired { bodies, pairs }: Tired) {
    let mut table = world.resource_mut::<BodyTable>();
    for &(slot, _) in &bodies {
        table.set_resting(slot, true);
    }
    // Some of their bodies may just have been roused.
    let rest = |slots: [u32; 2]| slots.into_iter().all(|slot| table.rests(slot));
    let pairs = pairs.into_iter().filter(|&(_, slots)| rest(slots));
    let all = bodies.iter().map(|&(_, body)| body);
    let all: Vec<Entity> = all.chain(pairs.map(|(pair, _)| pair)).collect();
    // Who is gone by now is missed by *prepare*.
    let _ = world.try_insert_batch(all.into_iter().map(|entity| (entity, Resting::new())));
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let table = world.resource::<BodyTable>();
        for (slot, _) in bodies {
            graph.settle(slot, |other| table.rests(other));
        }
    });
}

/// Part of the stages *prepare*, *broadphase* and *islands*: bodies that something was done to while they rested do so no more, nor do
/// their pairs.
pub fn rouse(world: &mut World) {
    let mut table = world.resource_mut::<BodyTable>();
    if table.stirred.is_empty() {
        return;
    }
    let stirred = std::mem::take(&mut table.stirred);
    let mut risen = Vec::new();
    for slot in stirred {
        let Some(entity) = table.get(slot).map(|body| body.entity) else {
            continue;
        };
        if table.set_resting(slot, false) {
            risen.push((slot, entity));
        }
    }
    let mut graph = world.resource_mut::<ConstraintGraph>();
    let mut marked: Vec<Entity> = Vec::new();
    for &(slot, body) in &risen {
        marked.push(body);
        marked.extend(graph.edges_of(slot));
        // Nobody has looked at what was edited while it rested.
        graph.report_all_of(slot);
    }
    for entity in marked {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<Resting>();
        }
    }
}

impl ConstraintGraph {
    /// The pairs that are to go to rest after their bodies: nothing about them changes any more.
    pub(super) fn take_idle(
        &mut self,
        table: &BodyTable,
        pairs: &Pairs,
        time: &StepTime,
    ) -> Vec<(Entity, [u32; 2])> {
        let mut idle = Vec::new();
        let mut settling = std::mem::take(&mut self.settling);
        settling.retain(|&(edge, entity)| {
            let pair = pairs.get(entity).ok();
            let pair = pair.filter(|_| self.entity(edge) == Some(entity));
            let Some((_, pair, _)) = pair else {
                return false;
            };
            if !pair.slots.iter().all(|&slot| table.rests(slot)) {
                return false;
            }
            // What touches has been told by the end of the step.
            let settled = pair.idle && time.substep == 0;
            if settled {
                idle.push((entity, pair.slots));
            }
            !settled
        });
        self.settling = settling;
        idle
    }
}
