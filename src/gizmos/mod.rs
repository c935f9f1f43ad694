//! Debug rendering: shapes, bounding boxes, contacts, impulses, anchors, joints, islands, sleep and loads as lines, with [`bevy_gizmos`].
//! Needs the feature `gizmos`.
//!
//! Add [`PhysicsGizmosPlugin`] to an app that draws gizmos. The gizmo config group [`PhysicsGizmos`] switches each kind of drawing:
//!
//! ```no_run
//! use bevy_app::prelude::*;
//! use bevy_ecs::prelude::*;
//! use bevy_gizmos::prelude::*;
//! use drystone::gizmos::{PhysicsGizmos, PhysicsGizmosPlugin};
//! use drystone::prelude::*;
//!
//! fn toggle(mut config: ResMut<GizmoConfigStore>) {
//!     let (_, physics) = config.config_mut::<PhysicsGizmos>();
//!     physics.contacts = !physics.contacts;
//! }
//!
//! App::new()
//!     .add_plugins((DrystonePlugins::default(), PhysicsGizmosPlugin))
//!     .add_systems(Update, toggle)
//!     .run();
//! ```

mod joints;
mod outline;

use crate::body::{
    BodyIndex, BodyState, BodyTable, Pose, RigidBody, Sleeping, collider::Collider,
    parts::CompoundCollider,
};
use crate::broadphase::Broadphase;
use crate::contact::Contacts;
use crate::graph::Islands;
use crate::pair::{ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold};
use crate::settings::Gravity;
use bevy_app::{App, Plugin, PostUpdate};
use bevy_color::{Alpha, Color};
use bevy_ecs::prelude::*;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy_gizmos::gizmos::Gizmos;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::TransformSystems;
use glam::Vec3;

/// Draws the kinds of gizmos that [`PhysicsGizmos`] enables, in `PostUpdate`. It is not part of
/// [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct PhysicsGizmosPlugin;

impl Plugin for PhysicsGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<PhysicsGizmos>().add_systems(
            PostUpdate,
            (shapes, boxes, contacts, joints::joints).after(TransformSystems::Propagate),
        );
    }
}

/// The gizmo config group of physics: which kinds of gizmos are drawn. By default the shapes, with sleeping bodies paler.
#[derive(Clone, Copy, Debug, PartialEq, GizmoConfigGroup)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Default))]
pub struct PhysicsGizmos {
    /// Draw the outlines of all shapes. Default: true.
    pub shapes: bool,
    /// Draw sleeping bodies paler. Default: true.
    pub sleep: bool,
    /// Colour the bodies of each island that is awake. Default: false.
    pub islands: bool,
    /// Colour each body by the weight that it supports: from blue for nothing to red for ten times its own weight. Default: false.
    pub loads: bool,
    /// Draw the bounding boxes of the broadphase. Default: false.
    pub boxes: bool,
    /// Draw contact points with their normals: green if they stick, red if they slip. Default: false.
    pub contacts: bool,
    /// Draw the normal force at each point, and the friction force at each face. Default: false.
    pub impulses: bool,
    /// Draw the slip of each anchored face, from its middle. Default: false.
    pub anchors: bool,
    /// Draw the joints: their anchors, with the axes and limits of each, and the outlines of bonded patches. Default: false.
    pub joints: bool,
    /// Length of the ray for a force, m/N. Default: 5e-5.
    pub metres_per_newton: f32,
    /// Magnification of slips, without unit. Default: 100.
    pub slip_scale: f32,
}

impl Default for PhysicsGizmos {
    /// Shapes, with sleeping bodies paler.
    fn default() -> Self {
        Self {
            shapes: true,
            sleep: true,
            islands: false,
            loads: false,
            boxes: false,
            contacts: false,
            impulses: false,
            anchors: false,
            joints: false,
            metres_per_newton: 5e-5,
            slip_scale: 100.0,
        }
    }
}

const DYNAMIC: Color = Color::srgb(0.95, 0.65, 0.25);
const KINEMATIC: Color = Color::srgb(0.70, 0.45, 0.95);
const STATIC: Color = Color::srgb(0.45, 0.50, 0.50);
const SENSOR: Color = Color::srgb(0.85, 0.80, 0.25);
const BOX: Color = Color::srgb(0.30, 0.30, 0.60);
const STICKS: Color = Color::srgb(0.20, 0.85, 0.30);
const SLIPS: Color = Color::srgb(0.95, 0.20, 0.15);
const PRESSES: Color = Color::srgb(0.95, 0.90, 0.30);
const RUBS: Color = Color::srgb(0.30, 0.80, 0.95);
const SLIPPED: Color = Color::srgb(0.95, 0.30, 0.85);

/// Golden angle, °: consecutive numbers are far apart in hue.
const GOLDEN: f32 = 137.508;

/// Half length of the cross at a point, and length of its normal, m.
const POINT: f32 = 0.02;
const NORMAL: f32 = 0.1;

/// Draws the shapes of bodies.
fn shapes(
    mut gizmos: Gizmos<PhysicsGizmos>,
    config: Res<GizmoConfigStore>,
    (islands, gravity, contacts): (Res<Islands>, Res<Gravity>, Contacts),
    table: Res<BodyTable>,
    bodies: Query<(Entity, &RigidBody, &BodyIndex, Shapes, &Pose, &Sleeping)>,
) {
    let (_, show) = config.config::<PhysicsGizmos>();
    if !show.shapes {
        return;
    }
    for (entity, kind, index, (collider, compound), pose, sleeping) in &bodies {
        let mut color = match kind {
            RigidBody::Dynamic => DYNAMIC,
            RigidBody::Kinematic => KINEMATIC,
            RigidBody::Static => STATIC,
        };
        if *kind == RigidBody::Dynamic {
            if show.islands
                && let Some(island) = islands.of(index.0)
            {
                color = Color::hsl(island as f32 * GOLDEN % 360.0, 0.8, 0.55);
            }
            if show.loads
                && let Some(body) = table.get(index.0)
            {
                color = load_color(&contacts, &gravity, entity, body);
            }
            if show.sleep && sleeping.asleep {
                color = color.with_alpha(0.35);
            }
        }
        if let Some(solid) = compound.map_or(collider, CompoundCollider::shape) {
            outline::lines(solid, |[a, b]| {
                gizmos.line(pose.transform_point(a), pose.transform_point(b), color);
            });
        }
        let parts = table.get(index.0).and_then(|body| body.parts.as_ref());
        for zone in parts.map_or(&[][..], |parts| parts.zones()) {
            let place = |point| pose.transform_point(zone.at.transform_point(point));
            outline::lines(&zone.shape, |[a, b]| {
                gizmos.line(place(a), place(b), SENSOR)
            });
        }
    }
}

type Shapes<'w> = (Option<&'w Collider>, Option<&'w CompoundCollider>);

fn load_color(contacts: &Contacts, gravity: &Gravity, entity: Entity, body: &BodyState) -> Color {
    let faces = contacts.on(entity).unwrap_or_default();
    let down = gravity.0.normalize_or_zero();
    let bears: f32 = faces.iter().map(|face| face.force.dot(down).max(0.0)).sum();
    let weight = gravity.0.length() / body.mass.inverse_mass;
    let share = match weight > 0.0 {
        true => (bears / (10.0 * weight)).clamp(0.0, 1.0),
        false => 0.0,
    };
    Color::hsl(240.0 * (1.0 - share.sqrt()), 0.9, 0.5)
}

/// Draws the boxes of the broadphase.
fn boxes(
    mut gizmos: Gizmos<PhysicsGizmos>,
    config: Res<GizmoConfigStore>,
    broadphase: Res<Broadphase>,
) {
    if !config.config::<PhysicsGizmos>().1.boxes {
        return;
    }
    for aabb in broadphase.boxes() {
        outline::box_lines(aabb.mins, aabb.maxs, |[a, b]| gizmos.line(a, b, BOX));
    }
}

/// Draws the points, forces and slips of contact pairs.
fn contacts(
    mut gizmos: Gizmos<PhysicsGizmos>,
    config: Res<GizmoConfigStore>,
    table: Res<BodyTable>,
    pairs: Query<(
        &ContactPair,
        &Manifold,
        &ContactImpulses,
        &ContactAnchors,
        &ContactTargets,
    )>,
) {
    let (_, show) = config.config::<PhysicsGizmos>();
    if !(show.contacts || show.impulses || show.anchors) {
        return;
    }
    for (pair, manifold, impulses, anchors, targets) in &pairs {
        let Some(a) = table.get(pair.slots[0]) else {
            continue;
        };
        for (number, patch) in manifold.patches.iter().enumerate() {
            let sticks = match anchors.patches.get(number) {
                Some(anchor) => anchor.sticking,
                None => {
                    let points = anchors
                        .points
                        .get(manifold.range(patch))
                        .unwrap_or_default();
                    points.iter().any(|anchor| anchor.sticking)
                }
            };
            let color = if sticks { STICKS } else { SLIPS };
            for i in manifold.range(patch) {
                let point = a.center + manifold.points[i].arm;
                if show.contacts {
                    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                        gizmos.line(point - POINT * axis, point + POINT * axis, color);
                    }
                    gizmos.ray(point, NORMAL * patch.normal, color);
                }
                if show.impulses
                    && let Some(impulse) = impulses.points.get(i)
                {
                    let force = impulse.normal_force * show.metres_per_newton;
                    gizmos.ray(point, force * patch.normal, PRESSES);
                }
            }
            let center = a.center + patch.center;
            if show.impulses
                && let Some(impulse) = impulses.patches.get(number)
            {
                let force = impulse.friction_force * show.metres_per_newton;
                gizmos.ray(center, force, RUBS);
            }
            if show.anchors
                && let Some(Some(slip)) = targets.patches.get(number)
            {
                gizmos.ray(center, show.slip_scale * slip.shift, SLIPPED);
            }
        }
    }
}
