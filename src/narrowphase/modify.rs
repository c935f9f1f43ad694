//! Part of the stage *narrowphase*: calls [`ContactHooks`], and finds the pairs whose surfaces move ([`SurfaceVelocity`]).
//!
//! It visits only pairs of bodies that have one of these components, on several threads if they are many. A pair that loses points is
//! detected anew in the next step, so that a hook always sees all points.

use crate::body::{
    ActiveContactHooks, BodyIndex, BodyState, BodyTable, Simulated, collider::SurfaceVelocity,
    limits,
};
use crate::contact::{ContactHook, ContactHooks, ContactModification};
use crate::graph::ConstraintGraph;
use crate::pair::{Manifold, MovingSurfaces, Origins, PairColumns, PairState, PairsMut, reorder};
use crate::revision::Revision;
use crate::settings::{PhysicsThreads, StabilizationSettings, StepTime};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use glam::Vec3;

/// Bodies that change the contacts of their pairs.
type Modifying = (
    Or<(With<ActiveContactHooks>, With<SurfaceVelocity>)>,
    Simulated,
);

/// Changes the contacts of pairs as hooks and surface velocities ask.
pub fn modify_contacts(
    (table, mut graph, mut surfaces): (
        Res<BodyTable>,
        ResMut<ConstraintGraph>,
        ResMut<MovingSurfaces>,
    ),
    (hooks, time, settings, threads): (
        Option<Res<ContactHooks>>,
        Res<StepTime>,
        Res<StabilizationSettings>,
        Res<PhysicsThreads>,
    ),
    modifying: Query<&BodyIndex, Modifying>,
    mut pairs: PairsMut,
) {
    let before = surfaces.take();
    if modifying.is_empty() {
        return;
    }
    // The pairs do not depend on each other, so neither their order nor the number of threads matters.
    let mut found = EntityHashSet::default();
    for index in &modifying {
        found.extend(graph.edges_of(index.0));
    }
    let context = Context {
        hook: hooks.as_deref().map(ContactHooks::hook),
        dt: time.dt,
        outer: settings.outer_distance(),
        first: time.substep == 0,
    };
    let rows = pairs.iter_many_unique_mut(found).filter_map(|columns| {
        let (_, columns) = columns.ok()?;
        let bodies = table.both(columns.0.slots)?;
        (!columns.0.is_idle()).then(|| (columns, bodies, Modified::default()))
    });
    let mut rows: Vec<_> = rows.collect();
    threads.each((&mut *rows,), |((columns, bodies, modified),)| {
        *modified = context.modify(columns, *bodies, &before);
    });
    let mut reports = Vec::new();
    for (columns, _, modified) in rows {
        if let Some(velocity) = modified.velocity {
            surfaces.insert(columns.0.edge, velocity);
        }
        reports.extend(modified.report);
    }
    graph.report(reports);
}

struct Context<'a> {
    hook: Option<&'a dyn ContactHook>,
    dt: f32,
    /// Points up to this distance touch, m.
    outer: f32,
    /// This is the first substep.
    first: bool,
}

/// The data of a pair that hooks and moving surfaces read.
#[derive(Default)]
struct Modified {
    /// The velocity that friction demands, m/s, if it is not zero.
    velocity: Option<Vec3>,
    /// For the graph, if the pair has lost all its points or ceased to touch.
    report: Option<(u32, bool)>,
}

impl Context<'_> {
    /// Changes the contacts of a pair.
    fn modify(
        &self,
        (pair, cache, manifold, impulses, anchors, targets): &mut <PairColumns<'static> as QueryData>::Item<'_, '_>,
        bodies: [&BodyState; 2],
        before: &MovingSurfaces,
    ) -> Modified {
        let pair = pair.bypass_change_detection();
        let manifold = manifold.bypass_change_detection();
        let impulses = impulses.bypass_change_detection();
        let targets = targets.bypass_change_detection();
        let before_hooks = (pair.friction, pair.restitution, pair.hooked());
        pair.combine(bodies);
        let combined = (pair.friction, pair.restitution);
        let pressed = impulses.normal() > 0.0;
        let mut contacts = ContactModification::new(pair, bodies, manifold, (pressed, self.dt));
        if let Some(hook) = self.hook {
            let asks = |asked: fn(&ActiveContactHooks) -> bool| {
                bodies.iter().any(|body| asked(&body.properties.hooks))
            };
            if asks(|hooks| hooks.filter_pairs) && !hook.filter_pair(bodies) {
                contacts.ignore();
            } else if asks(|hooks| hooks.modify_contacts) && !manifold.points.is_empty() {
                hook.modify_contacts(&mut contacts);
            }
        }
        if limits::share_of(contacts.friction, limits::FRICTION) {
            pair.friction = contacts.friction;
        }
        if limits::share_of(contacts.restitution, limits::RESTITUTION) {
            pair.restitution = contacts.restitution;
        }
        pair.set_hooked((pair.friction, pair.restitution) != combined);
        let mut changed = (pair.friction, pair.restitution, pair.hooked()) != before_hooks;
        let velocity = contacts.surface_velocity;
        let moves = velocity != Vec3::ZERO && limits::within(velocity, limits::SPEED);
        let velocity = moves.then_some(velocity);
        if velocity != before.get(pair.edge) {
            // Anchored contacts slide from now on, or the other way round.
            anchors.bypass_change_detection().measured = None;
            changed = true;
        }
        let kept = contacts.kept;
        let drops = kept.contains(&false);
        if drops {
            let (points, patches) = drop_points(manifold, &kept);
            let anchors = anchors.bypass_change_detection();
            reorder(&points, &patches, impulses, anchors, targets);
            cache.bypass_change_detection().last_pose.forget();
        }
        if changed || drops {
            pair.revision = Revision::next();
        }
        if !drops {
            return Modified {
                velocity,
                report: None,
            };
        }
        pair.touching = manifold
            .points
            .iter()
            .any(|point| point.distance <= self.outer);
        pair.state = match manifold.points.is_empty() && self.first {
            true => PairState::Apart,
            false => PairState::Live,
        };
        let ends = manifold.points.is_empty() || pair.announced() && !pair.touching;
        Modified {
            velocity,
            report: ends.then_some((pair.edge, pair.announced() && !pair.touching)),
        }
    }
}

/// Removes points that are not kept, and patches without points. Returns the origins of those that are left.
fn drop_points(manifold: &mut Manifold, kept: &[bool]) -> (Origins, Origins) {
    let old = std::mem::take(manifold);
    manifold.between = old.between;
    let (mut points, mut patches) = (Origins::new(), Origins::new());
    for (number, patch, range) in old.patches_with_points() {
        let first = manifold.points.len() as u32;
        for i in range.filter(|&i| kept[i]) {
            manifold.points.push(old.points[i]);
            points.push(Some(i as u16));
        }
        let count = manifold.points.len() as u32 - first;
        if count > 0 {
            let mut patch = *patch;
            (patch.first, patch.count) = (first, count);
            let arms = manifold.points[first as usize..]
                .iter()
                .map(|point| point.arm);
            patch.center = arms.sum::<Vec3>() / count as f32;
            manifold.patches.push(patch);
            patches.push(Some(number as u16));
        }
    }
    (points, patches)
}
