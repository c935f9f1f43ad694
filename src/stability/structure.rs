//! A structure as input of the cone program: bodies with the forces on them, and the faces in which they touch.

use crate::body::{BodyState, BodyTable, ExternalForce};
use crate::contact::{ContactImpulses, ContactPair, Manifold};
use crate::graph::ConstraintGraph;
use crate::settings::Gravity;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use glam::DVec3;

/// Points that are farther apart than this share of the smaller body's size do not touch.
const TOUCHES: f32 = 2e-3;

/// The bodies and joints of a structure.
pub(super) struct Structure {
    pub members: Vec<Member>,
    pub joints: Vec<Joint>,
    /// The mean weight of a body, N, and the mean radius, m.
    pub units: [f64; 2],
}

/// A body of it.
pub(super) struct Member {
    pub entity: Entity,
    /// Centre of mass, m.
    pub center: DVec3,
    /// kg
    pub mass: f64,
    /// Weight and other forces, N, and their moment, N·m.
    pub dead: [DVec3; 2],
}

/// A face in which two bodies touch, one of them of the structure at least.
pub(super) struct Joint {
    /// A and B.
    pub between: [Entity; 2],
    /// Their places in the structure.
    pub ends: [Option<usize>; 2],
    /// The normal, from B to A, and two tangents.
    pub frame: [DVec3; 3],
    /// μ
    pub friction: f64,
    /// Its corners, m.
    pub points: Vec<DVec3>,
    /// The middle of them, and how far they are from it, m.
    pub center: DVec3,
    pub radius: f64,
    /// Current normal force, N.
    pub pressure: f64,
}

impl Structure {
    /// Of the bodies in some slots.
    pub fn new(world: &World, slots: &[u32]) -> Self {
        let table = world.resource::<BodyTable>();
        let gravity = world.resource::<Gravity>().0;
        let state = |&slot: &u32| table.get(slot).expect("it has been looked up");
        let member = |body: &BodyState| {
            let mass = 1.0 / body.mass.inverse_mass as f64;
            let pushed = world.get::<ExternalForce>(body.entity).copied();
            let pushed = pushed.unwrap_or_default();
            let weight = (gravity * body.gravity_scale).as_dvec3() * mass;
            Member {
                entity: body.entity,
                center: body.center.as_dvec3(),
                mass,
                dead: [weight + pushed.force.as_dvec3(), pushed.torque.as_dvec3()],
            }
        };
        let members: Vec<Member> = slots.iter().map(state).map(member).collect();
        let share = 1.0 / members.len() as f64;
        let mass = members.iter().map(|member| member.mass).sum::<f64>() * share;
        let radii = slots.iter().map(state).map(|body| body.radius as f64);
        Self {
            joints: joints(world, slots),
            units: [
                mass * (gravity.length() as f64).max(1e-3),
                radii.sum::<f64>() * share,
            ],
            members,
        }
    }
}

fn joints(world: &World, slots: &[u32]) -> Vec<Joint> {
    let table = world.resource::<BodyTable>();
    let graph = world.resource::<ConstraintGraph>();
    let places: HashMap<u32, usize> = slots.iter().copied().zip(0..).collect();
    let mut joints = Vec::new();
    for &slot in slots {
        for pair in graph.edges_of(slot) {
            let found = world.get_entity(pair).ok().and_then(|pair| {
                pair.get_components::<(&ContactPair, &Manifold, &ContactImpulses)>()
                    .ok()
            });
            let Some(contact @ (pair, ..)) = found else {
                continue;
            };
            // One between two of the structure is found twice.
            let ends = pair.slots.map(|slot| places.get(&slot).copied());
            let again = pair.slots[1] == slot && ends[0].is_some();
            // Bodies that were removed since the last step carry no load.
            let there = |&body: &Entity| table.slot_of(world, body).is_some();
            if !again
                && pair.bodies.iter().all(there)
                && let Some(bodies) = table.both(pair.slots)
            {
                joints.extend(faces(contact, ends, bodies));
            }
        }
    }
    joints
}

/// The faces of a pair, with the points that touch.
fn faces(
    (pair, manifold, impulses): (&ContactPair, &Manifold, &ContactImpulses),
    ends: [Option<usize>; 2],
    [a, b]: [&BodyState; 2],
) -> impl Iterator<Item = Joint> {
    let far = TOUCHES * a.size.min(b.size);
    manifold.patches.iter().filter_map(move |patch| {
        let range = manifold.range(patch);
        let touching = range.clone();
        let touching = touching.filter(|&i| manifold.points[i].distance < far);
        let point = |i: usize| (a.center + manifold.points[i].arm).as_dvec3();
        let points: Vec<DVec3> = touching.map(point).collect();
        let share = 1.0 / points.len() as f64;
        let center = points.iter().sum::<DVec3>() * share;
        let arms = points.iter().map(|point| point.distance(center));
        let radius = arms.sum::<f64>() * share;
        let normal = patch.normal.as_dvec3().normalize();
        let (one, other) = normal.any_orthonormal_pair();
        let pressures = impulses.points.get(range).unwrap_or_default();
        let pressures = pressures.iter().map(|point| point.normal_force as f64);
        (!points.is_empty()).then(|| Joint {
            between: pair.bodies,
            ends,
            frame: [normal, one, other],
            friction: pair.friction as f64,
            points,
            center,
            radius,
            pressure: pressures.sum(),
        })
    })
}
