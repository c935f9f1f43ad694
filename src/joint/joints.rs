//! The stage **joints**: reads joints that were written, checks them, and adds and removes their edges in the constraint graph.
//!
//! A joint has an edge while it takes part in the simulation. It has none while it is disabled, while its input is invalid
//! ([`QuarantinedJoint`]), and while one of its bodies does not take part: it waits for that body. Joints without an edge are looked at in
//! every step, those with one only if they were written, or if something happened to their bodies.
//!
//! Every component that is inserted or removed here runs hooks and observers of the user, which may despawn the joint or its bodies. So
//! nothing that was found before is taken for granted afterwards, and the edge is inserted into the graph only when no more of them can run
//! before the joint has it.

use crate::body::{BodyState, BodyTable, Pose, RigidBody, SpawnOrder, WORLD};
use crate::diagnosis::{BodyProblem, EXTREME_JOINT_RATIO, FoundProblems};
use crate::graph::{ConstraintGraph, EdgeKind, activate};
use crate::joint_types::{
    self, BreakForce, DetachedJoints, JointBasis, JointChanges, JointDefinition, JointDisabled,
    JointEdge, JointError, JointForces, JointFrame, JointProblem, MortarJoint, QuarantinedJoint,
    WrittenJoints, definition, resolve,
};
use crate::solver::{Both, sort};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;

/// The action that a joint needs.
enum Finding {
    /// It takes part: its bodies are in these slots.
    Ready(Box<JointDefinition>, [u32; 2]),
    /// It is disabled, or waits for a body.
    Idle,
    /// Its input is invalid.
    Invalid(JointProblem),
}

/// The system of the stage.
pub fn joints(
    world: &mut World,
    written: &mut QueryState<Entity, WrittenJoints>,
    detached: &mut QueryState<Entity, DetachedJoints>,
) {
    let mut found = std::mem::take(&mut world.resource_mut::<JointChanges>().written);
    found.extend(written.iter(world));
    found.extend(detached.iter(world));
    found.extend(of_changed_bodies(world));
    if !found.is_empty() {
        let mut found: Vec<(SpawnOrder, Entity)> = found
            .into_iter()
            .filter_map(|joint| Some((order_of(world.get_entity(joint).ok()?), joint)))
            .collect();
        // Joints without a number were spawned before the plugins were added.
        sort::by_key(&mut found, |&(order, joint)| {
            (order, joint.index_u32(), joint.to_bits())
        });
        found.dedup();
        for (_, joint) in found {
            update(world, joint);
        }
    }
    forget_lost(world);
    activate(world);
}

fn order_of(joint: EntityRef) -> SpawnOrder {
    joint.get().copied().unwrap_or(SpawnOrder::NONE)
}

/// The joints of bodies that left, or are not dynamic any more.
fn of_changed_bodies(world: &World) -> Vec<Entity> {
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    if !graph.has_joints() {
        return Vec::new();
    }
    let changed = table.active().filter(|(_, body)| body.renewed);
    let changed = changed.map(|(slot, _)| slot).chain(table.removed_slots());
    changed
        .flat_map(|slot| graph.edges_of_kind(slot, EdgeKind::Joint))
        .collect()
}

/// Adds, changes or removes the edge of a joint.
pub(crate) fn update(world: &mut World, joint: Entity) {
    match examine(world, joint) {
        Finding::Ready(definition, slots) => {
            attach(world, joint, *definition, slots);
            if let Ok(mut joint) = world.get_entity_mut(joint)
                && joint.contains::<QuarantinedJoint>()
            {
                joint.remove::<QuarantinedJoint>();
                tracing::info!(
                    "joint {} works again: its input has been mended",
                    joint.id()
                );
            }
        }
        Finding::Idle => {
            detach(world, joint);
            if let Ok(mut joint) = world.get_entity_mut(joint) {
                joint.remove::<QuarantinedJoint>();
            }
        }
        Finding::Invalid(JointProblem::NotABody { entity })
            if is_bond_of_despawned(world, joint, entity) =>
        {
            world.try_despawn(joint).ok();
        }
        Finding::Invalid(problem) => {
            detach(world, joint);
            report(world, joint, problem);
        }
    }
}

/// Returns true if the joint is a bond of mortar and the body was despawned. Drystone made the bond, so nobody else would despawn it.
fn is_bond_of_despawned(world: &World, joint: Entity, body: Entity) -> bool {
    let bond = world.get_entity(joint);
    world.get_entity(body).is_err() && bond.is_ok_and(|bond| bond.contains::<MortarJoint>())
}

/// Finds out whether a joint can take part in the simulation.
fn examine(world: &mut World, joint: Entity) -> Finding {
    let Ok(of) = world.get_entity(joint) else {
        return Finding::Idle;
    };
    let (count, Some(definition)) = definition(of) else {
        return Finding::Idle;
    };
    if of.contains::<JointDisabled>() || of.contains::<Disabled>() {
        return Finding::Idle;
    }
    if count > 1 {
        return Finding::Invalid(JointProblem::SeveralJoints);
    }
    if let Err(problem) = definition.check() {
        return Finding::Invalid(problem);
    }
    if of
        .get()
        .is_some_and(|breaks: &BreakForce| !breaks.is_valid())
    {
        return Finding::Invalid(JointProblem::InvalidBreakForce);
    }
    let [one, other] = definition.bodies;
    if let Some(body) = one
        && one == other
    {
        return Finding::Invalid(JointProblem::SameBody { body });
    }
    let table = world.resource::<BodyTable>();
    let mut slots = [WORLD; 2];
    for (slot, body) in slots.iter_mut().zip(definition.bodies) {
        let Some(body) = body else {
            continue;
        };
        match table.slot_of(world, body) {
            Some(known) => *slot = known,
            None if may_return(world, body) => return Finding::Idle,
            None => return Finding::Invalid(JointProblem::NotABody { entity: body }),
        }
    }
    let is_dynamic = |&slot: &u32| table.get(slot).is_some_and(BodyState::is_dynamic);
    match slots.iter().any(is_dynamic) {
        true => Finding::Ready(Box::new(definition), slots),
        false => Finding::Invalid(JointProblem::NothingMoves),
    }
}

/// Whether an entity is a body, also one that does not take part for the moment: new, disabled in any way, taken out, or quarantined.
fn may_return(world: &World, body: Entity) -> bool {
    let body = world.get_entity(body);
    body.is_ok_and(|body| body.contains::<RigidBody>())
}

/// Gives a joint its edge, or takes over what has changed about it.
fn attach(world: &mut World, joint: Entity, found: JointDefinition, slots: [u32; 2]) {
    let definition = settle(world, joint, found, slots);
    if let Err(problem) = definition.check() {
        detach(world, joint);
        report(world, joint, problem);
        return;
    }
    let known_orders = spawn_orders(world, slots);
    let breaks = world.get::<BreakForce>(joint).copied();
    if let Some(mut known) = world.get_mut::<JointEdge>(joint) {
        let has_bodies = known.definition.bodies == definition.bodies;
        let is_same = has_bodies
            && known.slots == slots
            && known.spawn_orders == known_orders
            && known.definition.collision == definition.collision;
        if is_same {
            if known.definition != definition || known.breaks != breaks {
                (known.definition, known.breaks) = (definition, breaks);
                wake(&mut world.resource_mut::<BodyTable>(), slots);
            }
            return;
        }
        detach(world, joint);
        forget_lost(world);
        if !has_bodies && let Ok(mut joint) = world.get_entity_mut(joint) {
            // Its angles are those of other bodies.
            joint.insert(JointForces::default());
        }
    }
    let Ok(of) = world.get_entity(joint) else {
        return;
    };
    let mut order = order_of(of);
    let has_forces = of.contains::<JointForces>();
    if order == SpawnOrder::NONE {
        order = world.resource_mut::<BodyTable>().next_spawn_order();
        world.entity_mut(joint).insert(order);
    }
    if !has_forces && let Ok(mut joint) = world.get_entity_mut(joint) {
        joint.insert(JointForces::default());
    }
    // Whoever heard of these may have despawned something, or have written the joint anew; the next step looks at it then.
    let table = world.resource::<BodyTable>();
    let is_gone = |(body, slot): (Option<Entity>, u32)| {
        body.is_some_and(|body| table.slot_of(world, body) != Some(slot))
    };
    if world.get_entity(joint).is_err() || { definition.bodies.into_iter().zip(slots) }.any(is_gone)
    {
        return;
    }
    let spawn_orders = spawn_orders(world, slots);
    warn(world, slots);
    let mut graph = world.resource_mut::<ConstraintGraph>();
    let edge = graph.insert(EdgeKind::Joint, slots);
    graph.name(edge, joint);
    graph.set_links(edge, true);
    let mut table = world.resource_mut::<BodyTable>();
    if !definition.collision {
        except(&mut table, slots, true);
    }
    // Bodies that are added asleep together with their joint stay asleep.
    let arrives = |&slot: &u32| table.get(slot).is_none_or(|body| body.arrived);
    if !slots.iter().all(arrives) {
        wake(&mut table, slots);
    }
    world.entity_mut(joint).insert(JointEdge {
        slots,
        edge,
        spawn_orders,
        order,
        definition,
        breaks,
    });
}

/// Warns of a new joint between dynamic bodies of which one is much heavier.
fn warn(world: &mut World, slots: [u32; 2]) {
    let table = world.resource::<BodyTable>();
    let dynamic = |slot: u32| table.get(slot).filter(|body| body.is_dynamic());
    let [Some(a), Some(b)] = slots.both(dynamic) else {
        return;
    };
    let (heavy, light) = match a.mass.inverse_mass < b.mass.inverse_mass {
        true => (a, b),
        false => (b, a),
    };
    if light.mass.inverse_mass > EXTREME_JOINT_RATIO * heavy.mass.inverse_mass {
        let other = light.entity;
        let warning = (heavy.entity, BodyProblem::ExtremeJointRatio { other });
        world.resource_mut::<FoundProblems>().0.push(warning);
    }
}

fn spawn_orders(world: &World, slots: [u32; 2]) -> [SpawnOrder; 2] {
    let table = world.resource::<BodyTable>();
    slots.both(|slot| table.get(slot).map_or(SpawnOrder::NONE, |b| b.spawn_order))
}

/// Replaces frames that are not local by local ones, in the component too.
fn settle(
    world: &mut World,
    joint: Entity,
    found: JointDefinition,
    slots: [u32; 2],
) -> JointDefinition {
    let is_local = found.frames.iter().all(JointFrame::is_local);
    if is_local && !found.takes_length() {
        return normalized(found);
    }
    let table = world.resource::<BodyTable>();
    let bodies = slots.both(|slot| table.get(slot));
    let poses = bodies.both(|body| body.map_or(Pose::default(), |body| body.pose));
    let centers = bodies.both(|body| body.map(|body| body.center));
    let frames = resolve(found.frames, poses, centers, found.is_apart());
    let local = JointDefinition { frames, ..found };
    let anchors = local.anchors();
    let [a, b]: [_; 2] = std::array::from_fn(|i| poses[i].transform_point(anchors[i]));
    // Writing to components runs no hooks.
    let mut joint = world.entity_mut(joint);
    joint_types::settle(&mut joint, frames, a.distance(b));
    let (_, settled) = definition(joint.as_readonly());
    normalized(settled.unwrap_or(local))
}

/// With rotations of unit length.
fn normalized(mut definition: JointDefinition) -> JointDefinition {
    for frame in &mut definition.frames {
        if let JointBasis::Local(turn) = &mut frame.basis
            && !turn.is_normalized()
        {
            *turn = turn.normalize();
        }
    }
    definition
}

/// Takes a joint out of the simulation.
fn detach(world: &mut World, joint: Entity) {
    let remove = |world: &mut World| {
        let mut joint = world.get_entity_mut(joint).ok()?;
        let forces = joint.get::<JointForces>().copied().unwrap_or_default();
        joint
            .contains::<JointEdge>()
            .then(|| joint.remove::<JointEdge>())?;
        Some(forces.without_forces())
    };
    if let Some(forces) = remove(world)
        && let Ok(mut joint) = world.get_entity_mut(joint)
    {
        joint.insert(forces);
    }
}

/// Removes the edges of joints that were despawned or detached, and wakes their bodies.
fn forget_lost(world: &mut World) {
    let lost = std::mem::take(&mut world.resource_mut::<JointChanges>().lost);
    for (joint, edge) in lost {
        let mut graph = world.resource_mut::<ConstraintGraph>();
        graph.remove(edge.edge, joint);
        let mut table = world.resource_mut::<BodyTable>();
        if !edge.definition.collision {
            except(&mut table, edge.slots, false);
        }
        // A slot may be empty by now; it does not belong to another body before the next stage.
        wake(&mut table, edge.slots);
    }
}

/// Counts a joint whose bodies do not collide. If that changes anything, *broadphase* looks at one of the bodies again.
fn except(table: &mut BodyTable, slots: [u32; 2], more: bool) {
    if slots.contains(&WORLD) || !table.count_exception(slots, more) {
        return;
    }
    let dynamic = slots.into_iter().rev().find(|&slot| {
        let body = table.get(slot);
        body.is_some_and(BodyState::is_dynamic)
    });
    if let Some(slot) = dynamic
        && let Some(body) = table.get_mut(slot)
    {
        body.renewed = true;
        table.mark_dirty(slot);
    }
}

/// Wakes the dynamic ones of two bodies.
fn wake(table: &mut BodyTable, slots: [u32; 2]) {
    for slot in slots {
        let body = table.get_mut(slot);
        if let Some(body) = body.filter(|body| body.is_dynamic()) {
            body.disturbed = true;
            table.mark_dirty(slot);
        }
    }
}

/// Reports a joint once for each problem.
fn report(world: &mut World, joint: Entity, problem: JointProblem) {
    let Ok(mut of) = world.get_entity_mut(joint) else {
        return;
    };
    if of.get() == Some(&QuarantinedJoint { problem }) {
        return;
    }
    let name = of.get::<Name>().map(|name| name.as_str().to_owned());
    let (_, found) = definition(of.as_readonly());
    of.insert(QuarantinedJoint { problem });
    let error = JointError {
        joint,
        name,
        bodies: found.map_or([None; 2], |found| found.bodies),
        problem,
    };
    match problem {
        // Despawning a body is nothing unusual.
        JointProblem::NotABody { .. } => tracing::warn!("{error}"),
        _ => tracing::error!("{error}"),
    }
    world.write_message(error);
}
