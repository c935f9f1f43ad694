//! Part of the stage *narrowphase*: bonds bodies that have fresh [`Mortar`] to those that they touch.
//!
//! It makes a joint for each patch in the same step, and ends the pairs of bodies that are bonded, so that they do not fall for a step.
//! Pairs are visited in spawn order, so the bonds do not depend on entities.

use crate::body::{BodyIndex, BodyTable, Quarantined, RigidBodyDisabled, SpawnOrder};
use crate::components::{holders_in, remove};
use crate::graph::{ConstraintGraph, EdgeKind, activate, end_pairs};
use crate::joint;
use crate::joint_types::{Mortar, MortarJoint, Patch};
use crate::pair::{ContactPair, Manifold};
use crate::settings::StabilizationSettings;
use crate::solver::sort;
use bevy_ecs::component::Components;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_math::FloatPow;
use glam::Vec3;

/// Mortar bonds surfaces that are no farther apart, m, and points of the contact envelope at any rate.
const MAX_GAP: f32 = 1e-3;

/// Mortar bonds surfaces that move against each other more slowly, m/s.
pub(super) const MAX_SPEED: f32 = 0.05;

/// The area that a patch must have, as a share of the square of the smaller body's radius.
const LEAST_AREA: f32 = 1e-4;

/// A bond that is to be made.
pub(super) struct Bond {
    pub orders: [SpawnOrder; 2],
    pub pair: Entity,
    pub bodies: [Entity; 2],
    pub patch: Patch,
    pub mortar: Mortar,
}

/// Lays the fresh mortar of bodies.
pub fn lay_mortar(world: &mut World) {
    let all = [
        Components::component_id::<Mortar>,
        Components::component_id::<BodyIndex>,
    ];
    let mut found: Vec<(Entity, u32, Mortar)> = Vec::new();
    for body in holders_in(world, &all) {
        let of = world.entity(body);
        if let (Some(index), Some(mortar)) = (of.get::<BodyIndex>(), of.get::<Mortar>())
            && !of.contains::<Quarantined>()
            && !of.contains::<RigidBodyDisabled>()
        {
            found.push((body, index.0, *mortar));
        }
    }
    found.retain(|(body, _, mortar)| match mortar.is_valid() {
        true => true,
        false => {
            tracing::error!(
                "the mortar of {body} is removed: its strengths must be zero or more: {mortar:?}"
            );
            remove(world, *body, &[Components::component_id::<Mortar>]);
            false
        }
    });
    let bonds = find(world, &found);
    bond(world, bonds);
}

/// Makes bonds, in their order.
pub(super) fn bond(world: &mut World, bonds: Vec<Bond>) {
    if bonds.is_empty() {
        return;
    }
    let mut pairs = EntityHashSet::default();
    for bond in bonds {
        let joint = MortarJoint::new(bond.bodies, &bond.patch, bond.mortar);
        let joint = world.spawn(joint).id();
        joint::update(world, joint);
        pairs.insert(bond.pair);
        // Whoever heard of the bond may have despawned its bodies.
        for body in bond.bodies {
            remove(world, body, &[Components::component_id::<Mortar>]);
        }
    }
    end_pairs(world, &pairs);
    activate(world);
}

/// Largest distance of surfaces that are bonded, m.
pub(super) fn reach(world: &World) -> f32 {
    let outer = world.resource::<StabilizationSettings>().outer_distance();
    outer.max(MAX_GAP)
}

/// The patches that are bonded, in spawn order.
fn find(world: &World, fresh: &[(Entity, u32, Mortar)]) -> Vec<Bond> {
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    let reach = reach(world);
    let mut bonds = Vec::new();
    for &(body, slot, mortar) in fresh {
        for entity in graph.edges_of_kind(slot, EdgeKind::Contact) {
            let Some(pair) = world.get::<ContactPair>(entity) else {
                continue;
            };
            let Some(manifold) = world.get::<Manifold>(entity) else {
                continue;
            };
            let Some(bodies) = table.both(pair.slots) else {
                continue;
            };
            let other = usize::from(pair.bodies[0] == body);
            let mortar = match world.get::<Mortar>(pair.bodies[other]) {
                // It is found from both, and taken from the first.
                Some(_) if other == 0 => continue,
                Some(others) if others.is_valid() => mortar.weaker(others),
                _ => mortar,
            };
            let [a, b] = bodies;
            let least = LEAST_AREA * a.radius.min(b.radius).squared();
            for (_, patch, range) in manifold.patches_with_points() {
                let points = &manifold.points[range];
                let near = points.iter().filter(|point| point.distance <= reach);
                let near: Vec<Vec3> = near.map(|point| a.center + point.arm).collect();
                // From A to B.
                let Some(patch) = Patch::new(&near, -patch.normal, least) else {
                    continue;
                };
                let rate = a.velocity_at(patch.center) - b.velocity_at(patch.center);
                if rate.length() > MAX_SPEED {
                    continue;
                }
                bonds.push(Bond {
                    orders: pair.spawn_orders,
                    pair: entity,
                    bodies: pair.bodies,
                    patch,
                    mortar,
                });
            }
        }
    }
    // The sort is stable: the patches of a pair keep their order.
    sort::by_key(&mut bonds, |bond| bond.orders);
    bonds
}
