//! The stage **prepare**: reads the user's changes, validates them, and fills the [`BodyTable`].

mod complete;
mod describe;
mod pending;
mod quarantine;
#[expect(
    missing_debug_implementations,
    reason = "`derive(QueryData)` generates state types without `Debug`"
)]
mod queries;
mod rows;
mod written_transforms;

pub use complete::complete;
pub use pending::{Pending, refresh};
pub use quarantine::{Quarantined, any_suspects, lift, quarantine};
pub(crate) use queries::{ActiveBodies, ActiveBodyItem, PlacedActive, PlacedBodies};
pub(in crate::body) use rows::Rows;
pub(crate) use rows::{new_rows, newer_than, written_rows};
pub use written_transforms::{WrittenTransforms, find_written_transforms};

use super::inactive::{InactiveBodies, InactiveChildren, find_carried, find_written};
use super::listed::DescribedBodies;
use super::placement::{Placed, user_pose};
use super::{
    BodyIndex, BodyProperties, BodyState, BodyTable, Damping, ExternalForce, ExternalImpulse,
    GravityScale, Inactive, MassProperties, Pose, RigidBody, Simulated, Sleeping, SpawnOrder,
    Teleport, Velocity, limits,
};
use crate::body::{ActiveContactHooks, Grab};
use crate::components::{holders, remove_later};
use crate::diagnosis::{BodyProblem, FoundProblems};
use crate::settings::{ActiveSettings, SpeedLimits, StepTime};
use crate::solver::sort;
use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::Components;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::{SystemChangeTick, SystemParam};
use bevy_ecs::{entity::EntityHashSet, hierarchy::ChildOf, prelude::*};
use bevy_transform::components::Transform;
use describe::{DescribingBodies, describe, find_described};
use glam::Vec3;

/// The item of a query.
type Item<'w, 's, D> = <D as QueryData>::Item<'w, 's>;

pub(crate) type Moving<'w> = (
    (Entity, &'w RigidBody, &'w SpawnOrder, &'w Sleeping),
    &'w mut BodyIndex,
    &'w mut Pose,
    &'w mut Velocity,
    (&'w Transform, Option<&'w ChildOf>, Has<Teleport>),
    Pushed<'w>,
);

/// The components that accelerate a body. Each of them is optional.
pub(in crate::body) type Pushed<'w> = (
    Option<&'w ExternalForce>,
    Option<&'w ExternalImpulse>,
    Option<&'w Damping>,
    Option<&'w GravityScale>,
    Option<&'w Grab>,
);

/// Reads the user's changes, validates them, and fills the [`BodyTable`].
pub fn prepare(
    mut commands: Commands,
    (mut table, mut suspects, mut transforms): (
        ResMut<BodyTable>,
        ResMut<FoundProblems>,
        ResMut<WrittenTransforms>,
    ),
    rules: Rules,
    mut bodies: ParamSet<(
        DescribingBodies,
        InactiveBodies,
        InactiveChildren,
        Query<Moving, (Simulated, Without<Inactive>)>,
        Query<Moving, Simulated>,
    )>,
    (components, archetypes): (&Components, &Archetypes),
    mut described: DescribedBodies,
    placed: Placed,
) {
    let reduced = table.take_reduced();
    let mut changed = find_described(bodies.p0());
    changed.extend(&reduced);
    let visited_at = table.visited_at();
    let visit = table.begin_visit(rules.ticks.this_run());
    table.take_left();
    let mut joining: Vec<(SpawnOrder, Entity)> = Vec::new();
    let mut visitor = Visitor {
        commands: &mut commands,
        table: &mut table,
        suspects: &mut suspects,
        rules: &rules,
        visit,
        changed: &changed,
    };
    for body in &mut bodies.p3() {
        joining.extend(visitor.visit(body, &mut described, placed));
    }
    let mut dirty = match rules.active_settings.changed {
        true => bodies.p1().iter().map(|of| of.entity).collect(),
        false => find_written(visitor.table, bodies.p1(), visited_at),
    };
    dirty.append(&mut transforms.moved);
    dirty.extend(find_carried(bodies.p2(), placed));
    // Those that are not simulated are left out below.
    if rules.active_settings.hooks_changed {
        let hooked = [
            Components::component_id::<ActiveContactHooks>,
            Components::component_id::<Inactive>,
        ];
        dirty.extend(holders(components, archetypes, &hooked));
    }
    let teleported = [
        Components::component_id::<Teleport>,
        Components::component_id::<Inactive>,
    ];
    dirty.extend(holders(components, archetypes, &teleported));
    let resting = bodies.p1();
    dirty.extend(reduced.into_iter().filter(|body| resting.contains(*body)));
    sort::by_key(&mut dirty, |body| body.to_bits());
    dirty.dedup();
    let known = joining.len();
    for entity in dirty {
        if let Ok(body) = bodies.p4().get_mut(entity) {
            joining.extend(visitor.visit(body, &mut described, placed));
        }
    }
    // An inactive body that is about to join again is still counted, and would hide that another one has left.
    let recount = joining.len() > known || bodies.p1().count() != table.inactive_count();
    leave(
        &mut table,
        &mut commands,
        visit,
        recount.then(|| bodies.p1()),
    );
    let join = Joining {
        commands: &mut commands,
        table: &mut table,
        suspects: &mut suspects,
        rules: &rules,
        visit,
    };
    join.all(joining, bodies.p4(), &mut described);
}

/// Adds bodies to the table.
struct Joining<'a, 'w, 's> {
    commands: &'a mut Commands<'w, 's>,
    table: &'a mut BodyTable,
    suspects: &'a mut FoundProblems,
    rules: &'a Rules<'a>,
    visit: u64,
}

impl Joining<'_, '_, '_> {
    fn all(
        self,
        mut joining: Vec<(SpawnOrder, Entity)>,
        mut moving: Query<Moving, Simulated>,
        described: &mut DescribedBodies,
    ) {
        let Self {
            commands,
            table,
            suspects,
            rules,
            visit,
        } = self;
        // Bodies without a spawn order were spawned before the plugins were added. They are sorted by index, because `Entity`'s own order
        // is the reverse of the order of spawning.
        sort::by_key(&mut joining, |(spawn_order, entity)| {
            (
                *spawn_order,
                entity.index_u32(),
                entity.generation().to_bits(),
            )
        });
        table.reserve(joining.len());
        for (spawn_order, entity) in joining {
            let Ok((of, mut index, pose, velocity, _, pushed)) = moving.get_mut(entity) else {
                continue;
            };
            let Ok(description) = described.get_mut(entity) else {
                continue;
            };
            let mut body = BodyState::new(entity, *pose, *velocity);
            body.visited = visit;
            body.spawn_order = spawn_order;
            if spawn_order == SpawnOrder::NONE {
                body.spawn_order = table.next_spawn_order();
                let spawn_order = body.spawn_order;
                commands.queue(move |world: &mut World| {
                    if let Ok(mut body) = world.get_entity_mut(entity) {
                        body.insert(spawn_order);
                    }
                });
            }
            body.gravity_scale = pushed.3.map_or(1.0, |scale| scale.0);
            body.set_pushes(pushed.0, pushed.2);
            match describe(&mut body, description) {
                Ok(()) => {
                    let gains = gains(&body, pushed, rules);
                    body.set_velocity(*velocity, gains, rules.time.dt);
                    // A body that is spawned asleep stays asleep; a body that was disabled and enabled again wakes.
                    body.asleep = of.3.asleep && body.is_dynamic();
                    body.disturbed = is_disturbed(&velocity, pushed) || *index != BodyIndex::NONE;
                    *index.bypass_change_detection() = table.insert(body);
                }
                Err(problem) => suspects.0.push((entity, problem)),
            }
        }
    }
}

/// The settings that a visit reads.
#[derive(SystemParam, Debug)]
#[doc(hidden)]
pub struct Rules<'w> {
    time: Res<'w, StepTime>,
    speeds: Res<'w, SpeedLimits>,
    active_settings: Res<'w, ActiveSettings>,
    ticks: SystemChangeTick,
}

/// The components that are read of bodies that were spawned asleep in a [batch](crate::streaming::spawn_asleep).
pub(crate) type NewBodies = (
    Rules<'static>,
    Query<'static, 'static, Moving<'static>, Simulated>,
    DescribedBodies<'static, 'static>,
    Placed<'static, 'static>,
);

/// Adds bodies that were spawned asleep to the table, as if they had been inactive for long. Returns the slots of those that were added;
/// the others are to be visited by *prepare*, because more than their contacts has to be found.
pub(crate) fn add_asleep(
    table: &mut BodyTable,
    list: &[Entity],
    (rules, mut bodies, mut described, placed): <NewBodies as SystemParam>::Item<'_, '_>,
) -> (Vec<u32>, Vec<Entity>) {
    let (mut slots, mut others) = (Vec::with_capacity(list.len()), Vec::new());
    table.reserve(list.len());
    for &entity in list {
        let (Ok(moving), Ok(description)) = (bodies.get_mut(entity), described.get_mut(entity))
        else {
            // A disabled body must lose the marker `Inactive`, or it would still have it when it is enabled.
            others.push(entity);
            continue;
        };
        let (of, mut index, mut pose, velocity, placement, pushed) = moving;
        let (_, kind, &spawn_order, sleeping) = of;
        let (transform, parent, teleported) = placement;
        let is_plain = *index == BodyIndex::NONE
            && spawn_order != SpawnOrder::NONE
            && parent.is_none()
            && !teleported
            && description.compound.is_none()
            && (*kind == RigidBody::Static || *kind == RigidBody::Dynamic && sleeping.asleep)
            && !is_disturbed(&velocity, pushed);
        let to = user_pose((transform, parent), *pose, true, placed).unwrap_or(*pose);
        if !is_plain || check(&to, &velocity, pushed).is_some() {
            others.push(entity);
            continue;
        }
        let pose = pose.bypass_change_detection();
        *pose = to.normalized();
        let mut body = BodyState::new(entity, *pose, *velocity);
        body.spawn_order = spawn_order;
        body.gravity_scale = pushed.3.map_or(1.0, |scale| scale.0);
        body.set_pushes(pushed.0, pushed.2);
        let is_described = describe(&mut body, description).is_ok();
        if !is_described || body.parts.is_some() || body.events || body.asks_for_hooks() {
            others.push(entity);
            continue;
        }
        body.set_velocity(*velocity, gains(&body, pushed, &rules), rules.time.dt);
        body.asleep = body.is_dynamic();
        (body.moved, body.renewed, body.arrived) = (false, false, false);
        let slot = table.put_back(body);
        *index.bypass_change_detection() = BodyIndex(slot);
        slots.push(slot);
    }
    (slots, others)
}

/// Visits the bodies one by one.
struct Visitor<'a, 'w, 's> {
    commands: &'a mut Commands<'w, 's>,
    table: &'a mut BodyTable,
    suspects: &'a mut FoundProblems,
    rules: &'a Rules<'a>,
    visit: u64,
    /// Active bodies whose description was written.
    changed: &'a EntityHashSet,
}

impl Visitor<'_, '_, '_> {
    /// Updates the state of a body in the table. Returns spawn order and entity of a body that is not in the table yet.
    fn visit(
        &mut self,
        (of, index, mut pose, mut velocity, placement, pushed): Item<Moving>,
        described: &mut DescribedBodies,
        placed: Placed,
    ) -> Option<(SpawnOrder, Entity)> {
        let (entity, kind, spawn_order, sleeping) = of;
        let (transform, parent, teleported) = placement;
        let (time, speeds) = (&self.rules.time, &self.rules.speeds);
        if teleported {
            remove_later(self.commands, entity, Components::component_id::<Teleport>);
        }
        let pose = pose.bypass_change_detection();
        let written = self.changed.contains(&entity) || self.table.is_inactive(index.0);
        let body = self.table.body_mut(entity, *index);
        let moved_to = user_pose((transform, parent), *pose, body.is_none(), placed);
        let goes_to = moved_to.unwrap_or(*pose);
        if let Some(problem) = check(&goes_to, &velocity, pushed) {
            self.suspects.0.push((entity, problem));
            return None;
        }
        let goes_to = goes_to.normalized();
        let Some(body) = body.filter(|body| body.spawn_order == *spawn_order) else {
            *pose = goes_to;
            remove_later(self.commands, entity, Components::component_id::<Inactive>);
            // The slot may belong to another body by now. If only the spawn order changed, the body gets a new slot.
            self.table.remove(entity, *index);
            return Some((*spawn_order, entity));
        };
        body.visited = self.visit;
        body.put_from = None;
        // The target holds until the end of the whole step. The velocity towards it ends with it.
        let was_sent = time.substep == 0 && body.target.take().is_some();
        let is_sent = moved_to.is_some()
            && !teleported
            && *kind == RigidBody::Kinematic
            && body.send(*pose, goes_to, &mut velocity, time, speeds);
        if !is_sent {
            body.put_from = moved_to.map(|_| Box::new(*pose));
            *pose = goes_to;
        }
        if !is_sent && was_sent && *velocity == body.velocity {
            *velocity = Velocity::default();
        }

        body.arrived = false;
        body.renewed = false;
        body.moved = body.pose != *pose;
        body.pose = *pose;
        body.center = pose.transform_point(body.mass.local_center);
        let asleep = sleeping.asleep && *kind == RigidBody::Dynamic;
        let woken = body.asleep && !asleep;
        body.asleep = asleep;
        let gravity_scale = pushed.3.map_or(1.0, |scale| scale.0);
        let listened = body.events;
        let solved_as = written.then(|| body.properties.solved_as());
        if written
            && let Ok(description) = described.get_mut(entity)
            && let Err(problem) = describe(body, description)
        {
            self.suspects.0.push((entity, problem));
        }
        let solved_anew =
            solved_as.is_some_and(|as_before| body.properties.solved_as() != as_before);
        if *kind == RigidBody::Kinematic {
            body.note_gain(&velocity, time.dt);
        }
        // This comes after `describe`, because the radius may be new.
        body.set_velocity(*velocity, gains(body, pushed, self.rules), time.dt);
        body.disturbed = self.rules.active_settings.changed
            || body.put_from.is_some()
            || body.renewed
            || gravity_scale != body.gravity_scale
            || is_disturbed(&velocity, pushed)
            || self.rules.active_settings.hooks_changed && body.properties.hooks.asks();
        body.disturbed |= body.set_pushes(pushed.0, pushed.2);
        body.gravity_scale = gravity_scale;
        // An inactive body stays inactive if the written values are those that it had already.
        let listens = body.events && !listened;
        let changed = body.disturbed || body.moved || woken || body.target.is_some();
        if changed {
            self.table.mark_dirty(index.0);
        }
        if solved_anew {
            self.table.solve_anew(index.0);
        }
        if listens {
            self.table.listening.push(index.0);
        }
        None
    }
}

/// Removes bodies from the table that no longer exist: despawned, disabled, or without a component that every body has. Inactive bodies are
/// searched only if some may be missing.
fn leave(
    table: &mut BodyTable,
    commands: &mut Commands,
    visit: u64,
    resting: Option<InactiveBodies>,
) {
    if let Some(resting) = resting {
        for of in &resting {
            if let Some(body) = table.body_mut(of.entity, *of.slot) {
                body.visited = visit;
            }
        }
        for body in table.take_unvisited(visit, true) {
            // Otherwise it would be inactive when it comes back.
            remove_later(commands, body, Components::component_id::<Inactive>);
        }
    }
    table.take_unvisited(visit, false);
}

/// Returns true if the body cannot stay asleep: it has a velocity, an impulse, or a [`Grab`].
fn is_disturbed(velocity: &Velocity, (_, impulse, _, _, grab): Item<Pushed>) -> bool {
    let is_hit = impulse.is_some_and(|impulse| *impulse != ExternalImpulse::default());
    *velocity != Velocity::default() || is_hit || grab.is_some()
}

/// Maximum speed that a [`Grab`] gives the surface of a body by turning it, m/s. In one step it turns the body by half a turn at most.
fn turned(body: &BodyState, grab: &Grab, dt: f32) -> f32 {
    let inertia = body.mass.inverse_inertia;
    let spin = match grab.rotation {
        Some(_) => (grab.max_torque * inertia.max_element() * dt).min(2.0 / dt),
        None => 0.0,
    };
    match spin > 0.0 {
        true => spin * body.radius,
        false => 0.0,
    }
}

/// Maximum gain of speed in the step by forces and by a [`Grab`], m/s at the surface.
fn gains(body: &BodyState, (force, impulse, _, _, grab): Item<Pushed>, rules: &Rules) -> f32 {
    if !body.is_dynamic() {
        return 0.0;
    }
    let dt = rules.time.dt;
    let force = force.map_or(0.0, |force| {
        force.force.length() + force.local_force.length()
    });
    let impulse = impulse.map_or(0.0, |impulse| impulse.linear.length());
    let pulled = grab.map_or(0.0, |grab| {
        (dt * body.mass.inverse_mass * grab.max_force).min(grab.max_speed)
    });
    let gained = body.mass.inverse_mass * (dt * force + impulse) + pulled;
    gained.min(rules.speeds.linear) + grab.map_or(0.0, |grab| turned(body, grab, dt))
}

pub(in crate::body) fn check(
    pose: &Pose,
    velocity: &Velocity,
    (force, impulse, damping, scale, grab): Item<Pushed>,
) -> Option<BodyProblem> {
    // Most bodies have neither.
    let are_within = |forces: &[Vec3]| forces.iter().all(|v| limits::within(*v, limits::FORCE));
    let is_valid = force.is_none_or(|force| are_within(&force.parts()))
        && impulse.is_none_or(|impulse| are_within(&[impulse.linear, impulse.angular]));
    if !limits::within(pose.position, limits::POSITION) || !limits::is_turn(pose.rotation) {
        Some(BodyProblem::NonFinitePose)
    } else if !velocity.is_within_limits() {
        Some(BodyProblem::NonFiniteVelocity)
    } else if !is_valid {
        Some(BodyProblem::NonFiniteForce)
    } else if damping.is_some_and(|damping| !damping.is_valid()) {
        Some(BodyProblem::InvalidDamping)
    } else if scale.is_some_and(|scale| !limits::share_of(scale.0.abs(), limits::GRAVITY_SCALE)) {
        Some(BodyProblem::InvalidGravityScale)
    } else if grab.is_some_and(|grab| !grab.is_valid()) {
        Some(BodyProblem::InvalidGrab)
    } else {
        None
    }
}

impl BodyState {
    pub(crate) fn new(entity: Entity, pose: Pose, velocity: Velocity) -> Self {
        Self {
            entity,
            spawn_order: SpawnOrder::NONE,
            kind: RigidBody::Static,
            asleep: false,
            pose,
            center: pose.position,
            velocity,
            mass: MassProperties::default(),
            size: 0.0,
            swept_margin: 0.0,
            curved: false,
            collider: None,
            properties: BodyProperties::shared_default(),
            events: false,
            gravity_scale: 1.0,
            radius: 0.0,
            half: Vec3::ZERO,
            moved: true,
            renewed: true,
            arrived: true,
            disturbed: false,
            put_from: None,
            target: None,
            gained: None,
            pushes: None,
            parts: None,
            visited: 0,
        }
    }
}
