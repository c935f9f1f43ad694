//! Locked axes: world axes along which a body does not move, or about which it does not turn.

use crate::body::{BodyState, KeptProperty, Velocity};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{BVec3, Mat3, Vec3};

/// World axes along which a dynamic body does not move, and about which it does not turn. Default: none.
///
/// A locked axis is exact: forces, contacts and grabs do not change the velocity along it, the component of the
/// [`Velocity`] there is set to zero in every step, and the coordinate of the centre of mass keeps every bit. The other axes react as if
/// the lock were a bearing without friction. Static and kinematic bodies ignore the component. A change of the `Transform` moves the body
/// along locked axes too.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// // A ball in a game that is played in the plane of x and y.
/// let ball = world
///     .spawn((
///         RigidBody::Dynamic,
///         Collider::ball(0.5),
///         Velocity::linear(Vec3::new(1.0, 0.0, 5.0)),
///         LockedAxes::new().lock_translation_z().lock_rotation_x().lock_rotation_y(),
///     ))
///     .id();
/// drystone::step(world, 1.0 / 60.0).unwrap();
/// let at = world.get::<Transform>(ball).unwrap().translation;
/// assert!(at.x > 0.0 && at.z == 0.0);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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
pub struct LockedAxes(u8);

/// Defines a constant or builder methods for each axis.
macro_rules! axes {
    ($($bit:literal $lock:ident $unlock:ident $what:literal,)*) => {
        $(
            #[doc = concat!("Locks ", $what, ".")]
            #[must_use]
            pub const fn $lock(self) -> Self {
                Self(self.0 | 1 << $bit)
            }

            #[doc = concat!("Unlocks ", $what, ".")]
            #[must_use]
            pub const fn $unlock(self) -> Self {
                Self(self.0 & !(1 << $bit))
            }
        )*
    };
}

impl LockedAxes {
    /// Locks all translations.
    pub const TRANSLATION_LOCKED: Self = Self(0b111);
    /// Locks all rotations.
    pub const ROTATION_LOCKED: Self = Self(0b111_000);
    /// Locks everything: forces and contacts do not move the body.
    pub const ALL_LOCKED: Self = Self(0b111_111);

    /// Locks nothing.
    pub const fn new() -> Self {
        Self(0)
    }

    axes! {
        0 lock_translation_x unlock_translation_x "translation along x",
        1 lock_translation_y unlock_translation_y "translation along y",
        2 lock_translation_z unlock_translation_z "translation along z",
        3 lock_rotation_x unlock_rotation_x "rotation about x",
        4 lock_rotation_y unlock_rotation_y "rotation about y",
        5 lock_rotation_z unlock_rotation_z "rotation about z",
    }

    /// The axes along which translation is locked.
    pub const fn locked_translations(self) -> BVec3 {
        BVec3::new(self.0 & 1 != 0, self.0 & 2 != 0, self.0 & 4 != 0)
    }

    /// The axes about which rotation is locked.
    pub const fn locked_rotations(self) -> BVec3 {
        BVec3::new(self.0 & 8 != 0, self.0 & 16 != 0, self.0 & 32 != 0)
    }

    /// Returns true if no axis is locked.
    pub const fn is_unlocked(self) -> bool {
        self.0 == 0
    }

    /// Returns true if some rotation is locked.
    pub(crate) fn locks_rotation(self) -> bool {
        self.0 & Self::ROTATION_LOCKED.0 != 0
    }

    /// 1 for axes along which the body may move, 0 for locked ones.
    pub(crate) fn free_translations(self) -> Vec3 {
        free(self.locked_translations())
    }

    /// The inverse inertia that impulses see, world axes: that of the inertia's restriction to the axes that are not locked. (The
    /// restriction of the inverse would be that of a body that turns about locked axes too.)
    pub(crate) fn restrict(self, inverse_inertia: Mat3) -> Mat3 {
        let free = free(self.locked_rotations());
        if free == Vec3::ONE {
            return inverse_inertia;
        }
        // By Schur complements, one axis after the other. An inverse of the inertia would lose accuracy for long bodies.
        let mut inverse = inverse_inertia;
        for axis in 0..3 {
            if free[axis] == 0.0 {
                let row = inverse.col(axis);
                for column in 0..3 {
                    let share = row[column] / row[axis];
                    *inverse.col_mut(column) -= share * row;
                }
                *inverse.col_mut(axis) = Vec3::ZERO;
                (0..3).for_each(|column| inverse.col_mut(column)[axis] = 0.0);
            }
        }
        inverse
    }

    /// Sets the components of a velocity along locked axes to zero.
    pub(crate) fn stop(self, velocity: &mut Velocity) {
        velocity.linear = Vec3::select(self.locked_translations(), Vec3::ZERO, velocity.linear);
        velocity.angular = Vec3::select(self.locked_rotations(), Vec3::ZERO, velocity.angular);
    }
}

/// 1 for axes that are not locked, 0 for others.
fn free(locked: BVec3) -> Vec3 {
    Vec3::select(locked, Vec3::ZERO, Vec3::ONE)
}

impl KeptProperty for LockedAxes {}

impl BodyState {
    /// The inverse inertia that impulses see, world axes, 1/(kg·m²).
    pub(crate) fn world_inverse_inertia(&self) -> Mat3 {
        let inertia = self.mass.world_inverse_inertia(self.pose.rotation);
        self.properties.locked_axes.restrict(inertia)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    /// Torques along locked axes keep the body from turning about them, and have the effect that the inverse restricted inertia says.
    #[test]
    fn a_lock_is_the_torque_that_holds_the_axis() {
        let axes = Mat3::from_quat(Quat::from_rotation_x(0.7) * Quat::from_rotation_z(0.4));
        let inverse = axes * Mat3::from_diagonal(Vec3::new(1.0, 2.0, 5.0)) * axes.transpose();
        let torque = Vec3::new(0.3, -0.2, 0.5);
        let locks = LockedAxes::new().lock_rotation_y();
        let turned = locks.restrict(inverse) * torque;
        assert_eq!(turned.y, 0.0);
        let found = inverse.inverse() * turned;
        assert!((found.x - torque.x).abs() < 1e-5 && (found.z - torque.z).abs() < 1e-5);
        let none = LockedAxes::ROTATION_LOCKED.restrict(inverse);
        assert_eq!(none, Mat3::ZERO);
    }

    #[test]
    fn axes_are_locked_and_unlocked() {
        let locks = LockedAxes::ALL_LOCKED
            .unlock_translation_y()
            .unlock_rotation_z();
        assert_eq!(locks.locked_translations(), BVec3::new(true, false, true));
        assert_eq!(locks.locked_rotations(), BVec3::new(true, true, false));
        assert!(LockedAxes::new().is_unlocked());
    }
}
