//! The system that drives wheels: finds their ground, solves the wheels of each body, and pushes body and ground.

use super::grip::{self, Mover, Spin, Spring, Touch};
use super::mount::{Mount, Places, mount};
use super::state::{Known, WheelContact};
use super::{Wheel, WheelState};
use crate::body::collider::Friction;
use crate::body::{
    BodyIndex, BodyState, BodyTable, ExternalImpulse, Inactive, MassProperties, Simulated,
    Sleeping, SpawnOrder, Velocity, limits,
};
use crate::diagnosis::{BodyProblem, FoundProblems};
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::query::{Dir3, QueryFilter, Ray3d, RayHit, SpatialQuery};
use crate::settings::{Gravity, SleepSettings, StepTime};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::ops;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Share of a slip, or of a compression beyond the travel, that is taken back in a step.
const TAKEN_BACK: f32 = 0.2;

/// The tread is at most so far from where it would be without slip, m: farther, it slides.
const MOST_STRAIN: f32 = 0.005;

/// The tread forgets where it was when the wheel has turned by this angle, rad.
const MEMORY: f32 = 1.0;

/// The suspension at the end of its travel is pushed back with this speed at most, m/s.
const STOP_SPEED: f32 = 2.0;

/// The least cosine of the angle between the suspension and the normal of the ground. Steeper ground counts as being so steep.
const LEAST_COSINE: f32 = 0.3;

/// How far beside its place a wheel looks again if it finds no ground, as a share of its radius.
const BESIDE: f32 = 1e-3;

/// The bodies that wheels are on, and those that are ground.
type Bodies<'w, 's> = Query<
    'w,
    's,
    (
        &'static BodyIndex,
        &'static MassProperties,
        &'static mut ExternalImpulse,
        &'static mut Sleeping,
        Has<Inactive>,
    ),
    Simulated,
>;

type Wheels<'w, 's> = Query<'w, 's, (Entity, &'static Wheel, &'static mut WheelState)>;

/// What is known about the step and the world.
#[derive(SystemParam)]
pub struct Site<'w, 's> {
    time: Res<'w, StepTime>,
    gravity: Res<'w, Gravity>,
    sleep: Res<'w, SleepSettings>,
    table: Res<'w, BodyTable>,
    graph: Res<'w, ConstraintGraph>,
    world: SpatialQuery<'w, 's>,
    places: Places<'w, 's>,
    frictions: Query<'w, 's, &'static Friction>,
}

impl std::fmt::Debug for Site<'_, '_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Site").finish_non_exhaustive()
    }
}

/// Lists that are kept between steps, so that a steady step allocates nothing.
#[derive(Debug, Default)]
pub struct Lists {
    /// The wheels of awake bodies, those of a body one after the other.
    mounted: Vec<Mounted>,
    /// The wheels of a body that touch, and which of its wheels they are.
    touching: Vec<Touch>,
    touching_numbers: Vec<usize>,
}

/// A wheel of a body that is awake.
#[derive(Clone, Copy, Debug)]
struct Mounted {
    wheel: Entity,
    order: SpawnOrder,
    mount: Mount,
}

/// Drives all wheels.
pub fn drive(
    site: Site,
    mut wheels: Wheels,
    mut bodies: Bodies,
    mut problems: ResMut<FoundProblems>,
    mut lists: Local<Lists>,
) {
    let Lists {
        mounted,
        touching,
        touching_numbers,
    } = &mut *lists;
    mounted.clear();
    for (entity, wheel, mut state) in &mut wheels {
        let state = state.bypass_change_detection();
        if !wheel.is_valid() {
            if !state.is_reported {
                problems.0.push((entity, BodyProblem::InvalidWheel));
                site.wake(state.body, &mut bodies);
            }
            *state = WheelState {
                is_reported: true,
                ..Default::default()
            };
            continue;
        }
        match mount(&site.places, entity) {
            Some(mount) => mounted.extend(site.look(entity, (wheel, state), mount, &mut bodies)),
            None => *state = WheelState::default(),
        }
    }
    // Sums that are rounded depend on their order, and entities differ between worlds: in the order of their places.
    sort::by_key(mounted, |of| (of.mount.place.x, of.mount.place.y));
    sort::by_key(mounted, |of| (of.order.0, of.mount.place.z));
    for of in mounted.chunk_by(|one, other| one.mount.body == other.mount.body) {
        touching.clear();
        touching_numbers.clear();
        let Some(vehicle) = site.vehicle(of[0].mount.body, &bodies) else {
            continue;
        };
        let mut is_busy = false;
        for (number, wheel) in of.iter().enumerate() {
            let Ok((_, wheel_of, mut state)) = wheels.get_mut(wheel.wheel) else {
                continue;
            };
            let state = state.bypass_change_detection();
            match vehicle.touch((wheel_of, state), &wheel.mount, of.len(), &bodies) {
                Some(touch) => {
                    touching.push(touch);
                    touching_numbers.push(number);
                }
                // An engine that turns a wheel in the air.
                None => is_busy |= wheel_of.engine.abs() > wheel_of.brake,
            }
        }
        let mut mover = vehicle.mover;
        grip::solve(&mut mover, touching);
        let mut sum = ExternalImpulse::default();
        for (touch, &number) in touching.iter().zip(&*touching_numbers) {
            let Ok((_, _, mut state)) = wheels.get_mut(of[number].wheel) else {
                continue;
            };
            let state = state.bypass_change_detection();
            touch.store(state, site.time.dt);
            is_busy |= state.slip.length() > site.sleep.linear_speed;
            sum.add_at(touch.impulse(), touch.arms[0]);
            site.push_ground(state, vehicle.is_still, touch.arms[1], &mut bodies);
        }
        if let Ok((_, _, mut impulse, mut sleeping, _)) = bodies.get_mut(vehicle.state.entity) {
            let impulse = impulse.bypass_change_detection();
            impulse.linear += sum.linear;
            impulse.angular += sum.angular;
            if is_busy {
                sleeping.bypass_change_detection().still_for = 0.0;
            }
        }
    }
}

impl Site<'_, '_> {
    /// Looks at a wheel before anything is pushed. Returns it if its body is awake. Otherwise wakes the body if something has changed.
    fn look(
        &self,
        wheel_entity: Entity,
        (wheel, state): (&Wheel, &mut WheelState),
        mount: Mount,
        bodies: &mut Bodies,
    ) -> Option<Mounted> {
        let known = Known {
            wheel: *wheel,
            place: mount.place,
            turn: mount.turn,
        };
        let was_reported = std::mem::take(&mut state.is_reported);
        let has_changed = was_reported || state.known.is_some_and(|before| before != known);
        state.known = Some(known);
        if state.body != Some(mount.body) {
            self.wake(state.body.replace(mount.body), bodies);
            state.lift();
        }
        let (index, _, _, mut sleeping, is_inactive) = bodies.get_mut(mount.body).ok()?;
        let body = self.table.body(mount.body, *index)?;
        if !body.is_dynamic() {
            return None;
        }
        if sleeping.asleep || is_inactive {
            if has_changed || self.has_ground_changed(state) {
                sleeping.wake();
                // Its ground gets its push from the first step on.
                self.wake(state.contact.map(|contact| contact.body), bodies);
            } else {
                self.press(state, bodies);
            }
            return None;
        }
        Some(Mounted {
            wheel: wheel_entity,
            order: body.spawn_order,
            mount,
        })
    }

    fn wake(&self, body: Option<Entity>, bodies: &mut Bodies) {
        if let Some(body) = body
            && let Ok((_, _, _, mut sleeping, _)) = bodies.get_mut(body)
            && sleeping.asleep
        {
            sleeping.wake();
        }
    }

    /// The body with an entity, if it is in the simulation, and its slot.
    fn body(&self, entity: Entity) -> Option<(u32, &BodyState)> {
        let body = self.world.state(entity)?;
        let slot = self.world.slot(entity)?;
        Some((slot, body))
    }

    /// Whether the ground of a sleeping vehicle is not what it was.
    fn has_ground_changed(&self, state: &WheelState) -> bool {
        let Some(contact) = state.contact else {
            return false;
        };
        let Some((slot, ground)) = self.body(contact.body) else {
            return true;
        };
        if self.table.is_inactive(slot) {
            return false;
        }
        match ground.is_dynamic() {
            // One that is about to sleep may go on.
            true => !ground.asleep && !self.is_still(ground),
            false => ground.moved || ground.renewed,
        }
    }

    /// Whether a body is slow enough to sleep.
    fn is_still(&self, body: &BodyState) -> bool {
        let velocity = &body.velocity;
        velocity.linear.length() < self.sleep.linear_speed
            && velocity.angular.length() < self.sleep.angular_speed
    }

    /// A sleeping vehicle presses on its ground, which may be awake.
    fn press(&self, state: &WheelState, bodies: &mut Bodies) {
        if let Some(contact) = state.contact
            && let Some((_, ground)) = self.body(contact.body)
        {
            let arm = ground.pose.transform_point(state.anchor) - ground.center;
            self.push_ground(state, true, arm, bodies);
        }
    }

    /// Pushes the ground of a wheel, if that is dynamic.
    fn push_ground(
        &self,
        state: &WheelState,
        vehicle_is_still: bool,
        arm: Vec3,
        bodies: &mut Bodies,
    ) {
        let Some(contact) = state.contact else {
            return;
        };
        let ground = self.body(contact.body);
        if ground.is_none_or(|(_, ground)| !ground.is_dynamic()) {
            return;
        }
        let Ok((_, _, mut impulse, mut sleeping, is_inactive)) = bodies.get_mut(contact.body)
        else {
            return;
        };
        if !sleeping.asleep && !is_inactive {
            let impulse = impulse.bypass_change_detection();
            impulse.add_at(self.time.dt * state.reaction, arm);
        } else if !vehicle_is_still {
            sleeping.wake();
        }
    }

    /// How the ground moves.
    fn ground(&self, slot: u32, ground: &BodyState, bodies: &Bodies) -> Mover {
        let surface = ground.surface_velocity();
        let mut velocity = ground.velocity;
        velocity.linear += surface;
        let is_held = || {
            let mut links = self.graph.links_of(slot);
            links.any(|link| matches!(link.kind, EdgeKind::Contact | EdgeKind::Joint))
        };
        if !ground.is_dynamic() || ground.asleep || is_held() {
            return Mover::held(velocity);
        }
        let mass = &ground.mass;
        let mut mover = Mover {
            velocity,
            inverse_mass: mass.inverse_mass,
            inverse_inertia: mass.world_inverse_inertia(ground.pose.rotation),
        };
        // Its own wheels may hold it, and have pushed it already if it was spawned before.
        if let Ok((_, _, impulse, ..)) = bodies.get(ground.entity)
            && *impulse != ExternalImpulse::default()
        {
            mover.velocity = ground.pushed(self.gravity.0, self.time.dt);
            mover.velocity.linear += surface;
            mover.push(impulse.linear, Vec3::ZERO);
            mover.velocity.angular += mover.inverse_inertia * impulse.angular;
        }
        mover
    }

    /// A body with wheels, as it moves at the end of the step without them.
    fn vehicle(&self, body: Entity, bodies: &Bodies) -> Option<Vehicle<'_>> {
        let (index, mass, impulse, sleeping, _) = bodies.get(body).ok()?;
        let state = self.table.body(body, *index)?;
        let locks = state.properties.locked_axes;
        let mut mover = Mover {
            velocity: state.pushed(self.gravity.0, self.time.dt),
            inverse_mass: mass.inverse_mass,
            inverse_inertia: locks.restrict(mass.world_inverse_inertia(state.pose.rotation)),
        };
        mover.push(impulse.linear, Vec3::ZERO);
        mover.velocity.angular += mover.inverse_inertia * impulse.angular;
        Some(Vehicle {
            site: self,
            state,
            mover,
            mass: mass.mass(),
            is_still: sleeping.still_for > 0.0,
        })
    }
}

/// A body with wheels in this step.
struct Vehicle<'a> {
    site: &'a Site<'a, 'a>,
    state: &'a BodyState,
    mover: Mover,
    mass: f32,
    is_still: bool,
}

impl Vehicle<'_> {
    /// Finds the ground of a wheel, of which the body has so many. `None` in the air.
    fn touch(
        &self,
        (wheel, state): (&Wheel, &mut WheelState),
        mount: &Mount,
        count: usize,
        bodies: &Bodies,
    ) -> Option<Touch> {
        let dt = self.site.time.dt;
        let pose = self.state.pose;
        let inertia = 0.5 * wheel.mass_share * self.mass * wheel.radius * wheel.radius;
        let spin = |load: f32| Spin {
            speed: (state.spin + dt * wheel.engine / inertia).clamp(-limits::SPIN, limits::SPIN),
            inertia,
            radius: wheel.radius,
            brake: dt * (wheel.brake + wheel.rolling_resistance * wheel.radius * load),
        };
        let from = pose.transform_point(mount.place);
        let turn = pose.rotation * mount.turn;
        let hit = self.hit(wheel, from, turn * Vec3::NEG_Y);
        let ground = hit.and_then(|hit| Some((hit, self.site.body(hit.entity)?)));
        let Some((hit, (slot, ground))) = ground else {
            let spin = spin(0.0).after(0.0);
            state.lift();
            state.turn_to(spin, dt);
            return None;
        };
        let spin = spin(state.load);
        let up = turn * Vec3::Y;
        let normal = hit.normal.try_normalize().unwrap_or(up);
        let axle = turn * (Quat::from_rotation_y(wheel.steering) * Vec3::X);
        let forward = normal.cross(axle).try_normalize();
        let forward = forward.unwrap_or_else(|| normal.any_orthonormal_vector());
        let axes = [normal, forward, forward.cross(normal)];
        let arms = [hit.point - self.state.center, hit.point - ground.center];
        let slipped = self.slipped(state, wheel, &hit, (ground, axes));
        let mover = self.site.ground(slot, ground, bodies);
        let compression = wheel.suspension + wheel.radius - hit.distance;
        let before = self.state.velocity.at(arms[0]) - mover.velocity.at(arms[1]);
        let cosine = normal.dot(up).max(LEAST_COSINE);
        let share = self.mass / count as f32;
        let spring = spring(wheel, (compression, before.dot(normal) / cosine), share, dt);
        let surface = self.site.frictions.get(hit.collider);
        let surface = surface.copied().unwrap_or(ground.properties.friction);
        let friction = wheel.grip.combine(surface);
        state.contact = Some(WheelContact {
            body: hit.entity,
            collider: hit.collider,
            point: hit.point,
            normal,
        });
        state.compression = compression.max(0.0);
        state.anchor = ground.pose.inverse_transform_point(hit.point);
        state.slip = slipped / self.site.time.previous_dt;
        let most = Vec2::splat(MOST_STRAIN);
        let kept = ops::exp(-state.rolled.abs() / MEMORY);
        state.strain = kept * (state.strain + slipped).clamp(-most, most);
        Some(Touch {
            arms,
            axes,
            ground: mover,
            spring: Spring {
                push: spring.push / cosine,
                gain: spring.gain / (cosine * cosine),
                least_speed: spring.least_speed * cosine,
            },
            friction: friction * Vec2::new(1.0, wheel.grip_across),
            bias: TAKEN_BACK / dt * state.strain,
            spin,
            // Those of the last step, to start from: zero in the air.
            impulses: dt * Vec3::new(state.load, state.force.x, state.force.y),
            slides: false,
        })
    }

    /// What the ray of a wheel hits.
    fn hit(&self, wheel: &Wheel, from: Vec3, down: Vec3) -> Option<RayHit> {
        let excluded = [self.state.entity];
        let filter = QueryFilter::default()
            .excluding(&excluded)
            .with_layers(self.state.properties.layers);
        let (down, far) = (Dir3::new(down).ok()?, wheel.suspension + wheel.radius);
        let cast = |from: Vec3| {
            let ray = Ray3d::new(from, down);
            self.site.world.cast_ray(ray, far, &filter).ok()?
        };
        // A ray that runs exactly into the seam of two tiles may miss both by rounding.
        let (x, y) = down.any_orthonormal_pair();
        let beside = wheel.radius * BESIDE * Vec2::new(1.0, 0.6);
        cast(from).or_else(|| cast(from + beside.x * x + beside.y * y))
    }

    /// How far the tread has slipped since the last step, m: forwards and to the right.
    fn slipped(
        &self,
        state: &WheelState,
        wheel: &Wheel,
        hit: &RayHit,
        (ground, [_, forward, right]): (&BodyState, [Vec3; 3]),
    ) -> Vec2 {
        let before = match state.contact {
            Some(contact) if contact.body == hit.entity => {
                ground.pose.transform_point(state.anchor)
            }
            // From one tile of the ground to the next.
            Some(contact) if !ground.is_dynamic() && ground.velocity == Velocity::default() => {
                contact.point
            }
            _ => return Vec2::ZERO,
        };
        let carried = self.site.time.previous_dt * ground.surface_velocity();
        let way = hit.point - before - carried;
        Vec2::new(
            way.dot(forward) - wheel.radius * state.rolled,
            way.dot(right),
        )
    }
}

/// The spring of a wheel that bears a share of the mass of its body, along itself: how far it is compressed, m, and with which speed it
/// lengthens at the beginning of the step, m/s.
fn spring(wheel: &Wheel, (compression, speed): (f32, f32), share: f32, dt: f32) -> Spring {
    let rate = TAU * wheel.frequency;
    let (stiffness, damping) = (
        share * rate * rate,
        2.0 * wheel.damping_ratio * share * rate,
    );
    let beyond = compression - wheel.travel;
    Spring {
        // The force is that in the middle of the step, when the compression is less by Δt/4 times the sum of the speeds before and after.
        // With the force from its beginning, a body would gain energy as it bobs.
        push: dt * stiffness * (compression - 0.25 * dt * speed),
        gain: dt * (0.25 * dt * stiffness + damping),
        least_speed: match beyond > 0.0 {
            true => (TAKEN_BACK * beyond / dt).min(STOP_SPEED),
            false => beyond / dt,
        },
    }
}

impl Touch {
    /// Stores what the wheel did.
    fn store(&self, state: &mut WheelState, dt: f32) {
        let force = self.impulses / dt;
        state.load = force.x;
        state.force = Vec2::new(force.y, force.z);
        state.reaction = -self.impulse() / dt;
        state.turn_to(self.spin.after(self.impulses.y), dt);
        if self.slides {
            state.strain = Vec2::ZERO;
        }
    }
}

impl WheelState {
    /// Turns the wheel over a step, at whose end it has this spin, rad/s.
    fn turn_to(&mut self, spin: f32, dt: f32) {
        self.rolled = 0.5 * dt * (self.spin + spin);
        self.angle = (self.angle + self.rolled).rem_euclid(TAU);
        self.spin = spin;
    }
}
