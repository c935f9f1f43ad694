//! The system that lifts and drags bodies in fluids.

use super::wet::{Around, Wet};
use super::{Fluid, FluidField, FluidPoint, FluidState};
use crate::body::{
    BodyState, BodyTable, ExternalImpulse, MassProperties, Pose, SensorOverlaps, Simulated,
    Sleeping, SpawnOrder, Velocity,
};
use crate::diagnosis::{BodyProblem, FoundProblems};
use crate::sensor::{PlacedZone, Sensors};
use crate::settings::{Gravity, StepTime};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;

/// Largest (ω Δt)² of a body that bobs with the angular frequency ω as it should. A body that would bob faster bobs more slowly: an
/// explicit step is unstable from 4 on.
const STIFFEST: f32 = 2.0;

/// The mass of fluid that a body moves with it, as a share of the fluid that it displaces: that of a ball. Only bodies that are lighter
/// than that feel it.
const ADDED_MASS: f32 = 0.5;

/// Slopes are measured over this share of the radius of a body, but over no less than this many metres.
const SLOPE_SHARE: f32 = 0.5;
const LEAST_SLOPE_STEP: f32 = 0.05;

type Fluids<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Fluid,
        &'static mut FluidState,
        &'static SensorOverlaps,
        Option<&'static FluidField>,
    ),
>;

type Floating<'w, 's> = Query<
    'w,
    's,
    (
        (&'static Pose, &'static Velocity, &'static MassProperties),
        &'static mut ExternalImpulse,
        &'static mut Sleeping,
    ),
    Simulated,
>;

/// Lifts and drags the bodies in each fluid: adds to their impulses.
pub fn push(
    (time, gravity): (Res<StepTime>, Res<Gravity>),
    (table, sensors): (Res<BodyTable>, Res<Sensors>),
    mut fluids: Fluids,
    mut bodies: Floating,
    mut problems: ResMut<FoundProblems>,
    mut pools: Local<Vec<Pool>>,
) {
    pools.clear();
    for (sensor, fluid, mut state, inside, field) in &mut fluids {
        let state = state.bypass_change_detection();
        if !fluid.is_valid() {
            if !state.is_reported {
                problems.0.push((sensor, BodyProblem::InvalidFluid));
            }
            state.is_reported = true;
            continue;
        }
        let Some(zone) = sensors.zone(sensor, &table) else {
            continue;
        };
        let pool = Pool::new((*fluid, field), zone, gravity.0, (state.age, time.dt));
        let changed = state.known != Some(*fluid) || state.surface != pool.surface;
        state.age = pool.age;
        state.surface = pool.surface;
        state.known = Some(*fluid);
        state.is_reported = false;
        if changed || field.is_some() {
            for body in inside.bodies() {
                stir(&mut bodies, body);
            }
        }
        pools.push(pool);
    }
    if pools.is_empty() {
        return;
    }
    // Sums that are rounded depend on their order.
    sort::by_key(&mut pools, |pool| pool.rank);
    for (slot, body) in table.active().filter(|(_, body)| body.is_awake()) {
        let zones = sensors.zones_of(slot);
        for pool in pools.iter().filter(|pool| zones.contains(&pool.zone)) {
            let Ok(((pose, velocity, mass), mut impulse, _)) = bodies.get_mut(body.entity) else {
                continue;
            };
            let swimmer = Swimmer {
                body,
                pose,
                velocity,
                mass,
            };
            let is_inside = |part: u16| sensors.contains(pool.zone, (slot, body), part);
            let [linear, angular] = pool.impulse(&swimmer, is_inside);
            let impulse = impulse.bypass_change_detection();
            impulse.linear += linear;
            impulse.angular += angular;
        }
    }
}

/// Keeps a body awake, and wakes one that sleeps.
fn stir(bodies: &mut Floating, body: Entity) {
    if let Ok((_, _, mut sleeping)) = bodies.get_mut(body) {
        match sleeping.asleep {
            true => sleeping.wake(),
            false => sleeping.bypass_change_detection().still_for = 0.0,
        }
    }
}

/// A body in a fluid.
struct Swimmer<'a> {
    body: &'a BodyState,
    pose: &'a Pose,
    velocity: &'a Velocity,
    mass: &'a MassProperties,
}

/// A fluid in this step.
#[derive(Debug)]
pub struct Pool {
    fluid: Fluid,
    field: Option<FluidField>,
    /// The zone of its sensor, and the place of that in the order of all.
    zone: u32,
    rank: (SpawnOrder, u32),
    gravity: Vec3,
    /// Unit vector against gravity.
    up: Vec3,
    surface: f32,
    /// Simulated time since it came in, s.
    age: f32,
    dt: f32,
}

impl Pool {
    fn new(
        (fluid, field): (Fluid, Option<&FluidField>),
        of: PlacedZone,
        gravity: Vec3,
        (age, dt): (f32, f32),
    ) -> Self {
        let up = (-gravity).normalize_or(Vec3::Y);
        let (place, shape) = (of.place, of.shape.shape());
        let top = || match shape.as_halfspace() {
            Some(_) => place.translation.dot(up),
            None => {
                let upright = Quat::from_rotation_arc(up, Vec3::Y);
                let upright = ParryPose::from_parts(Vec3::ZERO, upright);
                shape.compute_aabb(&(upright * place)).maxs.y
            }
        };
        Self {
            surface: fluid.level.unwrap_or_else(top),
            fluid,
            field: field.cloned(),
            zone: of.number,
            rank: of.rank,
            gravity,
            up,
            age: age + dt,
            dt,
        }
    }

    /// The surface at a place, and how steep it is: the change of its height along the horizon.
    fn surface_at(&self, place: Vec3, step: f32) -> (FluidPoint, Vec3) {
        let Some(field) = &self.field else {
            return (FluidPoint::default(), Vec3::ZERO);
        };
        let (x, y) = self.up.any_orthonormal_pair();
        let rise = |way: Vec3| field.at(place + way, self.age).rise;
        let slope = |way: Vec3| (rise(step * way) - rise(-step * way)) / (2.0 * step) * way;
        let slope = slope(x) + slope(y);
        let point = field.at(place, self.age);
        match point.rise.is_finite() && point.flow.is_finite() && slope.is_finite() {
            true => (point, slope),
            false => (FluidPoint::default(), Vec3::ZERO),
        }
    }

    /// The impulse and angular impulse on a body in the step. Parts of it are in the fluid, by their numbers.
    fn impulse(&self, of: &Swimmer, is_inside: impl Fn(u16) -> bool) -> [Vec3; 2] {
        let Some(collider) = of.body.collider.as_ref() else {
            return [Vec3::ZERO; 2];
        };
        // Where it is in the middle of the step. Integration moves bodies as if forces were constant in a step, so with forces from its
        // beginning they would gain energy as they bob, and with those from its middle they neither gain nor lose any.
        let half = 0.5 * self.dt;
        let center = of.pose.transform_point(of.mass.local_center) + half * of.velocity.linear;
        let rotation = Quat::from_scaled_axis(half * of.velocity.angular) * of.pose.rotation;
        let at = ParryPose::from_parts(-(rotation * of.mass.local_center), rotation);
        let mut sum = Sum::default();
        let compound = collider.shape().as_compound();
        let pieces = compound.map_or(1, |compound| compound.shapes().len() as u32);
        for piece in (0..pieces).filter(|&piece| is_inside(of.body.part_of(piece))) {
            let place = match compound {
                Some(compound) => {
                    let (local, shape) = &compound.shapes()[piece as usize];
                    shape.compute_aabb(&(at * *local)).center()
                }
                None => Vec3::ZERO,
            };
            let (around, slope, flow) = self.around(of, center, place);
            let mut wet = Wet::default();
            wet.add_piece(collider, piece, &at, &around);
            sum.add(&wet, self.up - slope, flow);
        }
        self.sum_up(of, &sum)
    }

    /// The fluid around a piece that is at `place` from the centre of mass, with the slope of its surface and its velocity there.
    fn around(&self, of: &Swimmer, center: Vec3, place: Vec3) -> (Around, Vec3, Vec3) {
        let step = (SLOPE_SHARE * of.body.radius).max(LEAST_SLOPE_STEP);
        let (point, slope) = self.surface_at(center + place, step);
        let flow = self.fluid.flow + point.flow;
        let normal = (self.up - slope).normalize();
        let depth = self.surface + point.rise - (center + place).dot(self.up);
        let offset = normal.dot(place + depth * self.up);
        // In the surface if that cuts the body, and otherwise near the body, where rounding is small.
        let origin = match offset.abs() < of.body.radius {
            true => offset * normal,
            false => Vec3::ZERO,
        };
        let around = Around {
            normal,
            offset,
            origin,
            velocity: Velocity {
                linear: of.velocity.linear - flow,
                angular: of.velocity.angular,
            },
            pressure: 0.5 * self.fluid.density * self.fluid.drag,
        };
        (around, slope, flow)
    }

    fn sum_up(&self, of: &Swimmer, sum: &Sum) -> [Vec3; 2] {
        let (mass, dt, density) = (of.mass.mass(), self.dt, self.fluid.density);
        if sum.volume <= 0.0 || of.mass.inverse_mass <= 0.0 {
            return [Vec3::ZERO; 2];
        }
        let weight = density * self.gravity.length();
        let mut lift = [weight * sum.lift, weight * sum.lift_torque];
        let softening = self.softening(of, sum.volume);
        if softening < 1.0 {
            let bears = mass * of.body.gravity_scale * -self.gravity;
            lift[0] = bears + softening * (lift[0] - bears);
            lift[1] *= softening;
        }
        let inverse_inertia = of.mass.world_inverse_inertia(of.pose.rotation);
        let flow = sum.flow / sum.volume;
        let [linear, angular] = [of.velocity.linear - flow, of.velocity.angular];
        // Drag takes no more than the motion that it acts against.
        let power = sum.drag.dot(linear) + sum.drag_torque.dot(angular);
        let gain = of.mass.inverse_mass * sum.drag.length_squared()
            + sum.drag_torque.dot(inverse_inertia * sum.drag_torque);
        let share = match dt * gain > -power {
            true => (-power / (dt * gain)).max(0.0),
            false => 1.0,
        };
        let rate = self.fluid.damping * density * sum.volume / mass;
        // What cannot be followed is damped.
        let kept = 0.5 * (1.0 + softening) / (1.0 + dt * rate);
        let damped = (1.0 - kept) / dt;
        let inertia = match inverse_inertia.determinant() > 0.0 {
            true => inverse_inertia.inverse(),
            false => glam::Mat3::ZERO,
        };
        [
            dt * (lift[0] + share * sum.drag - damped * mass * linear),
            dt * (lift[1] + share * sum.drag_torque - damped * (inertia * angular)),
        ]
    }

    /// The share of the lift beyond its weight that a body is given: less than one for a body that is much lighter than the fluid that it
    /// displaces, which has to move that fluid too, and for one that would bob more often than a step can follow.
    fn softening(&self, of: &Swimmer, volume: f32) -> f32 {
        let half = of.body.half;
        let sides = 4.0 * Vec3::new(half.y * half.z, half.x * half.z, half.x * half.y);
        let area = sides.dot((of.pose.rotation.inverse() * self.up).abs());
        let stiffness = self.fluid.density * self.gravity.length() * area;
        let square = self.dt * self.dt * stiffness * of.mass.inverse_mass;
        let moved = ADDED_MASS * self.fluid.density * volume * of.mass.inverse_mass;
        (STIFFEST / square).min(moved.recip()).min(1.0)
    }
}

/// What a fluid does to all colliders of a body in it, about its centre of mass.
#[derive(Default)]
struct Sum {
    /// Volume in the fluid, m³.
    volume: f32,
    /// Volume times the direction of the lift, and its moment.
    lift: Vec3,
    lift_torque: Vec3,
    /// Force and torque of the drag, N and N·m.
    drag: Vec3,
    drag_torque: Vec3,
    /// Volume times the velocity of the fluid.
    flow: Vec3,
}

impl Sum {
    fn add(&mut self, wet: &Wet, direction: Vec3, flow: Vec3) {
        self.volume += wet.volume;
        self.lift += wet.volume * direction;
        self.lift_torque += wet.moment.cross(direction);
        self.drag += wet.force;
        self.drag_torque += wet.torque;
        self.flow += wet.volume * flow;
    }
}
