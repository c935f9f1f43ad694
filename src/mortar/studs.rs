//! Part of the stage *narrowphase*: clicks bricks with [`Studs`] together.

use super::lay::{Bond, MAX_SPEED, bond, reach};
use crate::body::{BodyState, BodyTable};
use crate::components::remove;
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::joint_types::{Patch, Studs};
use crate::pair::{ContactImpulses, ContactPair, Manifold};
use crate::solver::sort;
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;
use glam::{Vec2, Vec3};

/// Faces and sides may be turned against each other by so much: the cosine of 3°.
const PARALLEL: f32 = 0.9986;

/// Studs may be beside their tubes by this share of the pitch.
const SLACK: f32 = 0.15;

/// Smaller patches than this share of the place of a stud hold nothing.
const LEAST_STUD: f32 = 0.5;

/// Clicks bricks together that were spawned on each other, or are pressed together. Only bricks that are active are looked at.
pub fn click_studs(world: &mut World) {
    let table = world.resource::<BodyTable>();
    let mut bricks: Vec<(Entity, u32, Studs)> = Vec::new();
    let mut invalid = Vec::new();
    for (slot, body) in table.active() {
        match world.get::<Studs>(body.entity) {
            Some(studs) if !studs.is_valid() => invalid.push((body.entity, *studs)),
            Some(studs) if body.is_awake() => bricks.push((body.entity, slot, *studs)),
            _ => (),
        }
    }
    for (brick, studs) in invalid {
        tracing::error!(
            "the studs of {brick} are removed: their pitch must be more than zero, and their forces not less: {studs:?}"
        );
        remove(world, brick, &[Components::component_id::<Studs>]);
    }
    let bonds = find(world, &bricks);
    for (brick, ..) in bricks.iter().filter(|(_, _, studs)| !studs.laid) {
        if let Some(mut studs) = world.get_mut::<Studs>(*brick) {
            studs.bypass_change_detection().laid = true;
        }
    }
    bond(world, bonds);
}

/// The patches at which bricks click onto others, in spawn order.
fn find(world: &World, bricks: &[(Entity, u32, Studs)]) -> Vec<Bond> {
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    let mut bonds = Vec::new();
    for &(brick, slot, _) in bricks {
        for entity in graph.edges_of_kind(slot, EdgeKind::Contact) {
            let Some(pair) = world.get::<ContactPair>(entity) else {
                continue;
            };
            let Some(bodies) = table.both(pair.slots) else {
                continue;
            };
            let studs = pair.bodies.map(|of| world.get::<Studs>(of));
            let [Some(a), Some(b)] = studs.map(|of| of.filter(|studs| studs.is_valid())) else {
                continue;
            };
            // A pair that is found from both is taken from the first.
            if pair.bodies[0] != brick && bodies[0].is_awake() {
                continue;
            }
            let contact = (
                world.get::<Manifold>(entity),
                world.get::<ContactImpulses>(entity),
            );
            let (Some(manifold), Some(impulses)) = contact else {
                continue;
            };
            let clicks = Click {
                bodies,
                studs: [a, b],
                manifold,
                impulses,
            };
            bonds.extend(clicks.patches(reach(world)).map(|patch| Bond {
                orders: pair.spawn_orders,
                pair: entity,
                bodies: pair.bodies,
                patch,
                mortar: a.bond(b),
            }));
        }
    }
    // The sort is stable: the patches of a pair keep their order.
    sort::by_key(&mut bonds, |bond| bond.orders);
    bonds
}

/// Two bricks with studs that touch.
struct Click<'a> {
    bodies: [&'a BodyState; 2],
    studs: [&'a Studs; 2],
    manifold: &'a Manifold,
    impulses: &'a ContactImpulses,
}

impl Click<'_> {
    /// The patches at which they click together.
    fn patches(&self, reach: f32) -> impl Iterator<Item = Patch> {
        let [a, b] = self.bodies;
        let [pitch, other] = self.studs.map(|studs| studs.pitch);
        let are_alike = (pitch - other).abs() < SLACK * pitch;
        let is_fresh = |i: usize| self.bodies[i].is_dynamic() && !self.studs[i].laid;
        let is_fresh = is_fresh(0) || is_fresh(1);
        let press = self.studs[0].press.max(self.studs[1].press);
        let patches = self.manifold.patches_with_points();
        patches.filter_map(move |(_, patch, range)| {
            // From B to A.
            let order = self.stacked(patch.normal).filter(|_| are_alike)?;
            let on_grid = fits(order[0], order[1], pitch);
            let points = &self.manifold.points[range.clone()];
            let near = points.iter().filter(|point| point.distance <= reach);
            let near: Vec<Vec3> = near.map(|point| a.center + point.arm).collect();
            let least = LEAST_STUD * pitch * pitch;
            let found = Patch::new(&near, -patch.normal, least).filter(|_| on_grid)?;
            let rate = a.velocity_at(found.center) - b.velocity_at(found.center);
            let pressing = self.impulses.points.get(range).unwrap_or_default();
            let force: f32 = pressing.iter().map(|point| point.normal_force).sum();
            let studs = (found.area() / (pitch * pitch)).round().max(1.0);
            let clicks = is_fresh || force >= press * studs;
            (clicks && rate.length() < MAX_SPEED).then_some(found)
        })
    }

    /// The lower and the upper one, if one lies on the other with its bottom on the other's top.
    fn stacked(&self, normal: Vec3) -> Option<[&BodyState; 2]> {
        let [a, b] = self.bodies;
        let along = self
            .bodies
            .map(|of| (of.pose.rotation * Vec3::Y).dot(normal));
        match along {
            [a_up, b_up] if a_up > PARALLEL && b_up > PARALLEL => Some([b, a]),
            [a_up, b_up] if a_up < -PARALLEL && b_up < -PARALLEL => Some([a, b]),
            _ => None,
        }
    }
}

/// Whether the studs of the lower brick are under the tubes of the upper one.
fn fits(lower: &BodyState, upper: &BodyState, pitch: f32) -> bool {
    let middle = |of: &BodyState| {
        let bounds = of.shape().map(|shape| shape.compute_local_aabb());
        of.pose
            .transform_point(bounds.map_or(Vec3::ZERO, |bounds| bounds.center()))
    };
    let back = lower.pose.rotation.inverse();
    let side = back * (upper.pose.rotation * Vec3::X);
    let flat = |of: Vec3| Vec2::new(of.x, of.z);
    let half = match flat(side).abs() {
        side if side.x > PARALLEL => flat(upper.half),
        side if side.y > PARALLEL => Vec2::new(upper.half.z, upper.half.x),
        _ => return false,
    };
    let corner = flat(back * (middle(upper) - middle(lower))) + flat(lower.half) - half;
    let beside = corner / pitch - (corner / pitch).round();
    beside.abs().max_element() < SLACK
}
