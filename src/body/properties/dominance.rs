//! Dominance: which of two bodies in contact is not moved by the other.

use crate::body::{BodyProperties, BodyState, KeptProperty, LockedAxes};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The dominance group of a dynamic body. In a contact of two dynamic bodies, the one in the higher group is not moved by the other, as if
/// it were infinitely heavy. Bodies in the same group push each other as usual. Static and kinematic bodies dominate all. Default: 0.
///
/// In such a contact the dominant body moves on with the velocity that it had at the beginning of the step, as a kinematic body does. Since
/// nothing pushes it back, the two together gain momentum, and energy whenever the other one is accelerated.
///
/// Nothing is pressed through static and kinematic bodies: if they keep the other body from giving way, its contact with the dominant one
/// is as any other, with the masses of both. They do if their contacts with it are against the push, within 45°, directly or through more
/// bodies. So the ground carries a feather that lies on a ton, and a bulldozer that presses a block against a wall stops; but over the
/// floor, it pushes the block at its own speed. A sleeping body that does not [wake](crate::settings::Waking) counts as static; one that a
/// dominant body hits wakes, with all that is connected with it. Joints do not count: a dominant body pulls at the joints of what it pushes
/// without limit.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let ball = |x: f32| (RigidBody::Dynamic, Collider::ball(0.5), Transform::from_xyz(x, 0.0, 0.0), GravityScale(0.0));
/// // A light ball that a heavy one does not stop.
/// let light = world.spawn((ball(0.0), Mass(1.0), Velocity::linear(Vec3::X), Dominance(1))).id();
/// let heavy = world.spawn((ball(1.5), Mass(1000.0))).id();
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert_eq!(world.get::<Velocity>(light).unwrap().linear, Vec3::X);
/// assert!(world.get::<Velocity>(heavy).unwrap().linear.x > 0.9);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct Dominance(pub i8);

impl KeptProperty for Dominance {}

impl BodyState {
    /// Returns true if both bodies are dynamic and the other one cannot move this one.
    #[inline]
    pub(crate) fn dominates(&self, other: &Self) -> bool {
        self.properties.dominance > other.properties.dominance
            && self.is_dynamic()
            && other.is_dynamic()
    }
}

impl BodyProperties {
    /// The properties that decide how the contacts of a body are solved.
    pub(in crate::body) fn solved_as(&self) -> (LockedAxes, Dominance) {
        (self.locked_axes, self.dominance)
    }
}
