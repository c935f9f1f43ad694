//! Contact hooks: a user's code that decides which pairs have contacts, and changes their contacts, between detection and solve.

use crate::body::BodyState;
use crate::pair::{ContactPair, Manifold};
use crate::settings::ActiveSettings;
use bevy_ecs::prelude::*;
use glam::Vec3;
use std::fmt;
use std::sync::Arc;

/// Decides about contacts. It is called for pairs in which a body has [`ActiveContactHooks`](super::ActiveContactHooks), in every step in
/// which the pair is active.
///
/// Two worlds agree bit by bit only if a hook's answer depends on its arguments and on its own data alone. It must not rely on the order of
/// calls, and several [threads](crate::settings::PhysicsThreads) may call it at the same time, for different pairs. To give it data of the
/// game, replace the resource [`ContactHooks`] when the data change: this wakes the bodies whose contacts it decides about. Data that it
/// shares through an `Arc` may change without that, and sleeping bodies do not notice. Previews call it too, for copies that have the
/// numbers of their originals ([`ActiveContactHooks::user_data`](super::ActiveContactHooks::user_data)) and other entities.
pub trait ContactHook: Send + Sync + 'static {
    /// Returns false for a pair that has no contact now. It is called whenever the boxes of the two bodies overlap.
    fn filter_pair(&self, _bodies: [&BodyState; 2]) -> bool {
        true
    }

    /// Changes the contacts of a pair that has some.
    fn modify_contacts(&self, _contacts: &mut ContactModification) {}
}

/// The hook of the world. Without this resource there is none.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// /// Platforms that bodies fall on and jump through from below.
/// struct OneWay;
///
/// impl ContactHook for OneWay {
///     fn modify_contacts(&self, contacts: &mut ContactModification) {
///         contacts.one_way(Vec3::Y);
///     }
/// }
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// world.insert_resource(ContactHooks::new(OneWay));
/// world.spawn((RigidBody::Static, Collider::cuboid(4.0, 0.2, 4.0), ActiveContactHooks::MODIFY_CONTACTS));
/// let ball = world
///     .spawn((
///         RigidBody::Dynamic,
///         Collider::ball(0.25),
///         Transform::from_xyz(0.0, -1.0, 0.0),
///         Velocity::linear(Vec3::Y * 7.0),
///     ))
///     .id();
/// for _ in 0..180 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!((world.get::<Transform>(ball).unwrap().translation.y - 0.35).abs() < 0.01);
/// ```
#[derive(Resource, Clone)]
#[component(clone_behavior = Ignore)]
pub struct ContactHooks(Arc<dyn ContactHook>);

impl ContactHooks {
    /// The hook of the world.
    pub fn new(hook: impl ContactHook) -> Self {
        Self(Arc::new(hook))
    }

    pub(crate) fn hook(&self) -> &dyn ContactHook {
        &*self.0
    }
}

/// Notes whether the hook is another one than in the last step.
pub(crate) fn note_hooks(world: &mut World) {
    let hooks = world.get_resource::<ContactHooks>();
    let now = hooks.map(|hooks| Arc::clone(&hooks.0) as Arc<dyn Send + Sync>);
    world.resource_mut::<ActiveSettings>().note_hooks(now);
}

impl fmt::Debug for ContactHooks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ContactHooks")
    }
}

/// The contacts of a pair, for a hook to change. They are combined from the two bodies anew in every step.
#[derive(Debug)]
pub struct ContactModification<'a> {
    /// Coefficient of friction. Values that are negative or not finite are ignored.
    pub friction: f32,
    /// Coefficient of restitution. Values that are not between 0 and 1 are ignored.
    pub restitution: f32,
    /// Velocity of the surface of B against that of A, m/s, world axes: friction carries A along with it. See
    /// [`SurfaceVelocity`](crate::collider::SurfaceVelocity). Values that are not finite are ignored.
    pub surface_velocity: Vec3,
    pub(crate) bodies: [&'a BodyState; 2],
    pub(crate) manifold: &'a Manifold,
    /// Whether the two pressed on each other in the last step.
    pub(crate) pressed: bool,
    pub(crate) dt: f32,
    /// By point: whether it stays.
    pub(crate) kept: Vec<bool>,
}

/// A contact point in a hook.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HookedPoint {
    /// Position between the two surfaces, world, m.
    pub position: Vec3,
    /// Unit vector from B to A.
    pub normal: Vec3,
    /// Signed distance of the surfaces, m. Negative: overlap.
    pub distance: f32,
}

impl<'a> ContactModification<'a> {
    pub(crate) fn new(
        pair: &ContactPair,
        bodies: [&'a BodyState; 2],
        manifold: &'a Manifold,
        (pressed, dt): (bool, f32),
    ) -> Self {
        Self {
            friction: pair.friction,
            restitution: pair.restitution,
            surface_velocity: bodies[1].surface_velocity() - bodies[0].surface_velocity(),
            bodies,
            manifold,
            pressed,
            dt,
            kept: vec![true; manifold.points.len()],
        }
    }

    /// A and B: the second was spawned later. Their poses and velocities are those of the beginning of the step.
    pub fn bodies(&self) -> [&'a BodyState; 2] {
        self.bodies
    }

    /// Returns true if the two pressed on each other in the last step.
    pub fn pressed(&self) -> bool {
        self.pressed
    }

    /// The points.
    pub fn points(&self) -> impl Iterator<Item = HookedPoint> {
        numbered_points(self.bodies[0], self.manifold).map(|(_, point)| point)
    }

    /// Drops the points for which a function returns false.
    pub fn retain(&mut self, mut keeps: impl FnMut(&HookedPoint) -> bool) {
        for (i, point) in numbered_points(self.bodies[0], self.manifold) {
            self.kept[i] &= keeps(&point);
        }
    }

    /// Drops all points: the bodies pass through each other.
    pub fn ignore(&mut self) {
        self.kept.fill(false);
    }

    /// Makes the body that has [`ActiveContactHooks`](super::ActiveContactHooks) (B, if both have) a one-way platform: other bodies stand
    /// on its side that looks in this direction (a unit vector, world axes) and pass it from the other side.
    ///
    /// A contact counts if the two pressed on each other in the last step, or if the surfaces overlap by no more than they approach each
    /// other in one step, against the direction.
    pub fn one_way(&mut self, direction: Vec3) {
        /// Overlap of bodies at rest, m.
        const REST_OVERLAP: f32 = 0.01;
        /// Cosine of the largest angle between a normal and the direction.
        const FACING_COSINE: f32 = 0.5;
        let platform = usize::from(self.bodies[1].properties.hooks.modify_contacts);
        let [on, of] = [self.bodies[1 - platform], self.bodies[platform]];
        let sign = if platform == 1 { 1.0 } else { -1.0 };
        let (pressed, dt) = (self.pressed, self.dt);
        self.retain(|point| {
            let faces = sign * point.normal.dot(direction) > FACING_COSINE;
            let came = on.velocity_at(point.position) - of.velocity_at(point.position);
            let came = -dt * came.dot(direction);
            faces && (pressed || came >= 0.0 && -point.distance <= came + REST_OVERLAP)
        });
    }
}

/// The points of a manifold with their numbers, for hooks. `a` is body A.
fn numbered_points<'a>(
    a: &'a BodyState,
    manifold: &'a Manifold,
) -> impl Iterator<Item = (usize, HookedPoint)> + 'a {
    manifold
        .patches_with_points()
        .flat_map(move |(_, patch, range)| {
            range.map(move |i| {
                let point = &manifold.points[i];
                let hooked = HookedPoint {
                    position: a.center + point.arm,
                    normal: patch.normal,
                    distance: point.distance,
                };
                (i, hooked)
            })
        })
}
