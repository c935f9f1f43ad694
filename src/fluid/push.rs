//! The system that lifts and drags bodies in fluids.

use super::wet::{Around, Wet};
use super::{Fluid, FluidField, FluidPoint, FluidState};
use crate::body::{
    BodyIndex, BodyState, BodyTable, ExternalImpulse, Inactive, MassProperties, Pose,
    SensorOverlap, SensorOverlaps, Simulated, Sleeping, Velocity,
};
use crate::diagnosis::{BodyProblem, FoundProblems};
use crate::sensor::Sensors;
use crate::settings::{Gravity, StepTime};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;

/// An angular frequency of bobbing, times the length of the step and squared, up to which a body bobs as it should. Above, it bobs more
/// slowly, so that the step is stable: up to four an explicit step is.
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
        Ref<'static, Fluid>,
        &'static mut FluidState,
        &'static SensorOverlaps,
        Option<&'static FluidField>,
    ),
>;

type Floating<'w, 's> = Query<
    'w,
    's,
    (
        (&'static BodyIndex, &'static Pose, &'static Velocity),
        &'static MassProperties,
        (&'static mut ExternalImpulse, &'static mut Sleeping),
        Has<Inactive>,
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
    mut order: Local<Vec<(u64, u32, Entity)>>,
) {
    order.clear();
    order.extend(fluids.iter().filter_map(|(sensor, ..)| {
        let (body, number) = sensors.rank_of(sensor)?;
        Some((body.0, number, sensor))
    }));
    // Sums that are rounded depend on their order.
    sort::by_key(&mut order, |(body, number, _)| (*body, *number));
    for &(_, _, sensor) in &*order {
        let Ok((_, fluid, mut state, inside, field)) = fluids.get_mut(sensor) else {
            continue;
        };
        let (state, fluid) = (state.bypass_change_detection(), *fluid);
        if !fluid.is_valid() {
            if !state.is_reported {
                problems.0.push((sensor, BodyProblem::InvalidFluid));
            }
            state.is_reported = true;
            continue;
        }
        let Some(pool) = Pool::new(
            &fluid,
            field,
            (&sensors, &table, sensor),
            gravity.0,
            time.dt,
        ) else {
            continue;
        };
        let changed = state.known != Some(fluid) || state.surface != pool.surface;
        state.age += time.dt;
        state.surface = pool.surface;
        state.known = Some(fluid);
        state.is_reported = false;
        for parts in inside.0.chunk_by(|one, other| one.body == other.body) {
            let Ok((motion, mass, (mut impulse, mut sleeping), is_inactive)) =
                bodies.get_mut(parts[0].body)
            else {
                continue;
            };
            let (index, pose, velocity) = motion;
            let body = table.get(index.0);
            let Some(body) = body.filter(|of| of.entity == parts[0].body && of.is_dynamic()) else {
                continue;
            };
            if sleeping.asleep || is_inactive {
                if changed || field.is_some() {
                    sleeping.wake();
                }
                continue;
            }
            if field.is_some() {
                sleeping.bypass_change_detection().still_for = 0.0;
            }
            let floating = Swimmer {
                body,
                pose,
                velocity,
                mass,
                parts,
            };
            let [linear, angular] = pool.impulse(&floating, state.age);
            let impulse = impulse.bypass_change_detection();
            impulse.linear += linear;
            impulse.angular += angular;
        }
    }
}

/// A body in a fluid.
struct Swimmer<'a> {
    body: &'a BodyState,
    pose: &'a Pose,
    velocity: &'a Velocity,
    mass: &'a MassProperties,
    /// Its colliders in the fluid.
    parts: &'a [SensorOverlap],
}

impl Swimmer<'_> {
    /// Whether a piece of its shape belongs to a collider in the fluid.
    fn is_inside(&self, piece: u32) -> bool {
        let parts = self.body.parts.as_ref();
        parts
            .filter(|parts| parts.has_pieces())
            .is_none_or(|parts| {
                let collider = self.body.collider_entity(parts.owner(piece));
                self.parts.iter().any(|part| part.collider == collider)
            })
    }
}

/// A fluid in this step.
struct Pool<'a> {
    fluid: &'a Fluid,
    field: Option<&'a FluidField>,
    gravity: Vec3,
    /// Unit vector against gravity.
    up: Vec3,
    surface: f32,
    dt: f32,
}

impl<'a> Pool<'a> {
    fn new(
        fluid: &'a Fluid,
        field: Option<&'a FluidField>,
        (sensors, table, sensor): (&Sensors, &BodyTable, Entity),
        gravity: Vec3,
        dt: f32,
    ) -> Option<Self> {
        let (place, shape) = sensors.placed(sensor, table)?;
        let up = (-gravity).normalize_or(Vec3::Y);
        let top = || match shape.shape().as_halfspace() {
            Some(_) => place.translation.dot(up),
            None => {
                let upright = Quat::from_rotation_arc(up, Vec3::Y);
                let upright = ParryPose::from_parts(Vec3::ZERO, upright);
                shape.shape().compute_aabb(&(upright * place)).maxs.y
            }
        };
        Some(Self {
            fluid,
            field,
            gravity,
            up,
            surface: fluid.level.unwrap_or_else(top),
            dt,
        })
    }

    /// The surface at a place, and how steep it is: the change of its height along the horizon.
    fn surface_at(&self, place: Vec3, step: f32, age: f32) -> (FluidPoint, Vec3) {
        let Some(field) = self.field else {
            return (FluidPoint::default(), Vec3::ZERO);
        };
        let (x, y) = self.up.any_orthonormal_pair();
        let rise = |way: Vec3| field.at(place + way, age).rise;
        let slope = |way: Vec3| (rise(step * way) - rise(-step * way)) / (2.0 * step) * way;
        let slope = slope(x) + slope(y);
        let point = field.at(place, age);
        match point.rise.is_finite() && point.flow.is_finite() && slope.is_finite() {
            true => (point, slope),
            false => (FluidPoint::default(), Vec3::ZERO),
        }
    }

    /// The impulse and angular impulse on a body in the step.
    fn impulse(&self, of: &Swimmer, age: f32) -> [Vec3; 2] {
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
        for piece in (0..pieces).filter(|piece| of.is_inside(*piece)) {
            let place = match compound {
                Some(compound) => {
                    let (local, shape) = &compound.shapes()[piece as usize];
                    center + shape.compute_aabb(&(at * *local)).center()
                }
                None => center,
            };
            let step = (SLOPE_SHARE * of.body.radius).max(LEAST_SLOPE_STEP);
            let (point, slope) = self.surface_at(place, step, age);
            let flow = self.fluid.flow + point.flow;
            let normal = (self.up - slope).normalize();
            let height = self.surface + point.rise;
            let on_surface = place + (height - place.dot(self.up)) * self.up - center;
            let offset = normal.dot(on_surface);
            let around = Around {
                normal,
                offset,
                // Anywhere in the surface if that cuts the body, and near the body otherwise, where rounding is small.
                origin: if offset.abs() < of.body.radius {
                    offset
                } else {
                    0.0
                } * normal,
                velocity: Velocity {
                    linear: of.velocity.linear - flow,
                    angular: of.velocity.angular,
                },
                pressure: 0.5 * self.fluid.density * self.fluid.drag,
            };
            let mut wet = Wet::default();
            match compound {
                Some(_) => wet.add_piece(collider, piece, &at, &around),
                None => wet.add_collider(collider, &at, &around),
            }
            sum.add(&wet, self.up - slope, flow);
        }
        self.sum_up(of, &sum)
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
