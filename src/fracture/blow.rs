//! Finds the blows that break bodies, before the step in which they happen.

use super::Fracturable;
use super::break_up::break_all;
use crate::body::{BodyState, BodyTable, MassProperties, Pose, RigidBody, Velocity};
use crate::broadphase::Broadphase;
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::query::{Contact, DefaultQueryDispatcher, QueryDispatcher};

/// Slower bodies give no blows, m/s: they do not even fall onto something.
const LEAST_SPEED: f32 = 0.25;

/// Bodies are looked for so much farther than a body moves, m: its box in the tree may be that of the last step.
const MARGIN: f32 = 0.05;

/// Breaks the bodies that are about to be hit hard enough. Part of [`FractureSystems`](super::FractureSystems).
pub fn break_at_blows(world: &mut World) {
    let mut blows = find(world);
    if blows.is_empty() {
        return;
    }
    sort::by_key(&mut blows, |blow| {
        (blow.time, blow.orders[0], blow.orders[1])
    });
    let mut moved = EntityHashMap::<Velocity>::default();
    let mut broken: Vec<(Entity, Vec3, f32)> = Vec::new();
    for blow in blows {
        blow.strike(world, &mut moved, &mut broken);
    }
    for (body, velocity) in moved {
        if let Some(mut of) = world.get_mut::<Velocity>(body) {
            of.set_if_neq(velocity);
        }
    }
    break_all(world, broken);
}

/// Two bodies that are about to touch, one of which at least may break.
struct Blow {
    /// Share of the step after which they touch.
    time: f32,
    orders: [u64; 2],
    bodies: [Entity; 2],
    /// Where they touch, world, m.
    point: Vec3,
    /// Unit normal out of the second one.
    normal: Vec3,
}

fn find(world: &World) -> Vec<Blow> {
    let (table, broadphase) = (
        world.resource::<BodyTable>(),
        world.resource::<Broadphase>(),
    );
    let dt = world.resource::<StepTime>().dt;
    let mut pairs = Vec::new();
    for (slot, body) in table.active() {
        if let Some(mover) = Mover::new(world, body)
            && mover.speed() > LEAST_SPEED
        {
            pairs.extend(broadphase.beside(table, slot, &mover.path(dt)));
        }
    }
    // A pair of two that move is found from both.
    sort::values(&mut pairs);
    pairs.dedup();
    let breaks = |body: &BodyState| world.get::<Fracturable>(body.entity).is_some();
    let blows = pairs.into_iter().filter_map(|slots| {
        let bodies = table.both(slots)?;
        if !bodies.into_iter().any(breaks) {
            return None;
        }
        let [one, other] = bodies.map(|body| Mover::new(world, body));
        one?.blow(&other?, dt)
    });
    blows.collect()
}

/// A body as it will be at the beginning of the step.
struct Mover<'a> {
    body: &'a BodyState,
    pose: Pose,
    velocity: Velocity,
    center: Vec3,
}

impl<'a> Mover<'a> {
    fn new(world: &World, body: &'a BodyState) -> Option<Self> {
        let of = world.get_entity(body.entity).ok()?;
        let pose = *of.get::<Pose>()?;
        let velocity = *of.get::<Velocity>()?;
        let center = pose.transform_point(of.get::<MassProperties>()?.local_center);
        body.collider.as_ref()?;
        Some(Self {
            body,
            pose,
            velocity,
            center,
        })
    }

    /// Largest speed of its points, m/s.
    fn speed(&self) -> f32 {
        let turning = match self.body.radius.is_finite() {
            true => self.velocity.angular.length() * self.body.radius,
            false => 0.0,
        };
        self.velocity.linear.length() + turning
    }

    fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(point - self.center)
    }

    /// A box around all that it may touch in the step.
    fn path(&self, dt: f32) -> Aabb {
        let shape = self.body.shape().expect("it has a collider");
        let aabb = shape.compute_aabb(&self.pose.to_parry());
        aabb.loosened(self.speed() * dt + MARGIN)
    }

    /// The closest points of two bodies after this one has moved, with a normal out of the other one, if they are within `reach`, m.
    fn touch(&self, other: &Self, way: Vec3, reach: f32) -> Option<Contact> {
        let (shape, on) = (self.body.shape()?, other.body.shape()?);
        let mut from = self.pose.to_parry();
        from.translation += way;
        let to = other.pose.to_parry();
        let found = DefaultQueryDispatcher.contact(&to.inv_mul(&from), on, shape, reach);
        let mut found = found.ok()??;
        found.transform_by_mut(&to, &from);
        Some(found)
    }

    /// The blow on another body in the step, if the two touch in it. The way is straight.
    fn blow(&self, other: &Self, dt: f32) -> Option<Blow> {
        /// Bodies that are no farther apart touch, m.
        const NEAR: f32 = 1e-3;
        const MAX_STEPS: usize = 30;
        let reach = (self.speed() + other.speed()) * dt + MARGIN;
        let mut touch = self.touch(other, Vec3::ZERO, reach)?;
        let middle = |touch: &Contact| 0.5 * (touch.point1 + touch.point2);
        let at = middle(&touch);
        let velocity = self.velocity_at(at) - other.velocity_at(at);
        let speed = velocity.length();
        let longest = speed * dt;
        let mut way = 0.0;
        for _ in 0..MAX_STEPS {
            if touch.dist <= NEAR {
                break;
            }
            // No part of one comes nearer to the other by more than the way.
            way += touch.dist;
            if way > longest + NEAR {
                return None;
            }
            touch = self.touch(other, velocity * (way / speed), reach)?;
        }
        let normal = touch.normal1;
        let closes = -velocity.dot(normal) > LEAST_SPEED;
        // The way is that of this body as the other one sees it, which moves on meanwhile.
        let moved = other.velocity.linear * (way / speed.max(f32::MIN_POSITIVE));
        (closes && touch.dist <= 10.0 * NEAR).then(|| Blow {
            time: way / longest.max(f32::MIN_POSITIVE),
            orders: [self, other].map(|mover| mover.body.spawn_order.0),
            bodies: [self, other].map(|mover| mover.body.entity),
            point: middle(&touch) + moved,
            normal,
        })
    }
}

/// A body in a blow: how it moves, and how it gives way.
struct Struck {
    body: Entity,
    velocity: Velocity,
    /// From its centre of mass to the point, m.
    arm: Vec3,
    /// 0 if nothing moves it.
    inverse_mass: f32,
    mass: MassProperties,
    rotation: Quat,
}

impl Struck {
    fn new(world: &World, moved: &EntityHashMap<Velocity>, body: Entity, at: Vec3) -> Option<Self> {
        let of = world.get_entity(body).ok()?;
        let pose = of.get::<Pose>()?;
        let mass = *of.get::<MassProperties>()?;
        let is_dynamic = *of.get::<RigidBody>()? == RigidBody::Dynamic;
        let velocity = moved.get(&body).or_else(|| of.get::<Velocity>())?;
        Some(Self {
            body,
            velocity: *velocity,
            arm: at - pose.transform_point(mass.local_center),
            inverse_mass: if is_dynamic { mass.inverse_mass } else { 0.0 },
            mass,
            rotation: pose.rotation,
        })
    }

    /// The change of its spin by a unit impulse along a direction.
    fn spin(&self, direction: Vec3) -> Vec3 {
        match self.inverse_mass > 0.0 {
            true => self.mass.world_inverse_inertia(self.rotation) * self.arm.cross(direction),
            false => Vec3::ZERO,
        }
    }

    /// How its surface gives way along a direction, 1/kg.
    fn compliance(&self, direction: Vec3) -> f32 {
        self.inverse_mass + self.spin(direction).cross(self.arm).dot(direction)
    }

    fn push(&mut self, impulse: f32, direction: Vec3) {
        self.velocity.linear += self.inverse_mass * impulse * direction;
        self.velocity.angular += impulse * self.spin(direction);
    }
}

impl Blow {
    /// Breaks what this blow breaks, and takes the energy for that out of the motion of the two.
    fn strike(
        &self,
        world: &World,
        moved: &mut EntityHashMap<Velocity>,
        broken: &mut Vec<(Entity, Vec3, f32)>,
    ) {
        let struck = self
            .bodies
            .map(|body| Struck::new(world, moved, body, self.point));
        let [Some(mut one), Some(mut other)] = struck else {
            return;
        };
        let normal = self.normal;
        let compliance = one.compliance(normal) + other.compliance(normal);
        let closing = -(one.velocity.at(one.arm) - other.velocity.at(other.arm)).dot(normal);
        if closing <= LEAST_SPEED || compliance <= 0.0 {
            return;
        }
        let energy = 0.5 * closing * closing / compliance;
        let mut rules = self.bodies.map(|body| {
            let needed = world.get::<Fracturable>(body).map(|of| of.energy);
            // An energy that is no number breaks nothing, and is no lesser one.
            let needed = needed.filter(|energy| !energy.is_nan());
            (needed.map_or(f32::INFINITY, |energy| energy.max(0.0)), body)
        });
        if rules[1].0 < rules[0].0 {
            rules.swap(0, 1);
        }
        let mut spent = 0.0;
        for (needed, body) in rules {
            if broken.iter().any(|(known, ..)| *known == body) {
                continue;
            }
            if spent + needed <= energy {
                spent += needed;
                broken.push((body, self.point, energy));
            }
        }
        if spent == 0.0 {
            return;
        }
        // An impulse of this share of that which would stop them takes the energy: (2 s − s²) of all of it.
        let share = 1.0 - (1.0 - spent / energy).max(0.0).sqrt();
        let impulse = share * closing / compliance;
        one.push(impulse, normal);
        other.push(-impulse, normal);
        for struck in [one, other] {
            moved.insert(struck.body, struck.velocity);
        }
    }
}
