//! A structure as the input of the cone program: its bodies with the forces on them, and the joints in which they touch.

use crate::body::{BodyState, BodyTable, ExternalForce};
use crate::graph::ConstraintGraph;
use crate::pair::{ContactImpulses, ContactPair, Manifold};
use crate::settings::Gravity;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use glam::DVec3;

/// Points touch if their distance is less than this share of the smaller body's size.
const TOUCHING_DISTANCE: f32 = 2e-3;

/// The bodies and joints of a structure.
pub(super) struct Structure {
    pub members: Vec<Member>,
    pub joints: Vec<Joint>,
    /// The mean weight of a body, N, and the mean radius, m.
    pub units: [f64; 2],
}

/// A body of a structure.
pub(super) struct Member {
    pub entity: Entity,
    /// Centre of mass, m.
    pub center: DVec3,
    /// Mass, kg.
    pub mass: f64,
    /// Sum of the weight and other forces, N, and of their moments, N·m.
    pub dead: [DVec3; 2],
}

/// A face in which two bodies touch, at least one of which belongs to the structure.
pub(super) struct Joint {
    /// The bodies A and B.
    pub between: [Entity; 2],
    /// Their indices in the structure.
    pub ends: [Option<usize>; 2],
    /// The normal, from B to A, and two tangents.
    pub frame: [DVec3; 3],
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Its corners, m.
    pub points: Vec<DVec3>,
    /// The mean of the corners, m.
    pub center: DVec3,
    /// The mean distance of the corners from their mean, m.
    pub radius: f64,
    /// Current normal force, N.
    pub normal_force: f64,
}

impl Structure {
    /// The structure of the bodies in some slots.
    pub fn new(world: &World, slots: &[u32]) -> Self {
        let table = world.resource::<BodyTable>();
        let gravity = world.resource::<Gravity>().0;
        let state = |&slot: &u32| table.get(slot).expect("it has been looked up");
        let member = |body: &BodyState| {
            let mass = 1.0 / body.mass.inverse_mass as f64;
            let external = world.get::<ExternalForce>(body.entity).copied();
            let external = external.unwrap_or_default();
            let weight = (gravity * body.gravity_scale).as_dvec3() * mass;
            Member {
                entity: body.entity,
                center: body.center.as_dvec3(),
                mass,
                dead: [
                    weight + external.force.as_dvec3(),
                    external.torque.as_dvec3(),
                ],
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

/// Finds the joints of the bodies in some slots.
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
            // A pair of two bodies of the structure is found twice.
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

/// Returns the faces of a pair, with the points that touch.
fn faces(
    (pair, manifold, impulses): (&ContactPair, &Manifold, &ContactImpulses),
    ends: [Option<usize>; 2],
    [a, b]: [&BodyState; 2],
) -> impl Iterator<Item = Joint> {
    let far = TOUCHING_DISTANCE * a.size.min(b.size);
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
        let forces = impulses.points.get(range).unwrap_or_default();
        let forces = forces.iter().map(|point| point.normal_force as f64);
        (!points.is_empty()).then(|| Joint {
            between: pair.bodies,
            ends,
            frame: [normal, one, other],
            friction: pair.friction as f64,
            points,
            center,
            radius,
            normal_force: forces.sum(),
        })
    })
}
