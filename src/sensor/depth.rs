//! How deep bodies are inside sensors: [`SensorDepths`], a system parameter.

use super::zones::Sensors;
use crate::ask::ask;
use crate::body::{BodyTable, Pose};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use parry3d::query::contact;
use std::fmt;

/// System parameter that says how deep a collider is inside a [`Sensor`](super::Sensor). Outside of a system use [`sensor_depth`]. It
/// knows the colliders that the last step found inside, and measures them where they are.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use drystone::prelude::*;
/// use drystone::sensor::SensorDepths;
///
/// #[derive(Component)]
/// struct Quicksand;
///
/// /// The deeper something is in it, the less it moves.
/// fn hold(pits: Query<(Entity, &SensorOverlaps), With<Quicksand>>, depths: SensorDepths, mut bodies: Query<Forces>) {
///     for (pit, inside) in &pits {
///         for overlap in inside.iter() {
///             let depth = depths.depth(pit, overlap.collider).unwrap_or_default();
///             if let Ok(mut body) = bodies.get_mut(overlap.body) {
///                 body.apply_linear_impulse(Vec3::Y * 10.0 * depth);
///             }
///         }
///     }
/// }
/// ```
#[derive(SystemParam)]
pub struct SensorDepths<'w, 's> {
    sensors: Res<'w, Sensors>,
    table: Res<'w, BodyTable>,
    poses: Query<'w, 's, &'static Pose>,
}

impl fmt::Debug for SensorDepths<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SensorDepths").finish_non_exhaustive()
    }
}

impl SensorDepths<'_, '_> {
    /// How far a collider would have to move to leave the sensor, m: 0 if it only touches it. `None` if the last step did not find it
    /// inside.
    pub fn depth(&self, sensor: Entity, collider: Entity) -> Option<f32> {
        let content = self.sensors.content(sensor, collider)?;
        let zone = self.sensors.zone(sensor, &self.table)?;
        let body = self.table.get(content.slot)?;
        let pose = self.poses.get(body.entity).ok()?.to_parry();
        let depth = |(at, shape): (_, &parry3d::shape::SharedShape)| {
            let found = contact(
                &zone.place,
                &**zone.shape.shape(),
                &(pose * at),
                &**shape,
                0.0,
            );
            found.ok().flatten().map_or(0.0, |found| -found.dist)
        };
        let depths = body.pieces_of(content.part).map(depth);
        Some(depths.fold(0.0, f32::max))
    }
}

/// How far a collider would have to move to leave a sensor, m; see [`SensorDepths::depth`].
///
/// # Panics
/// If the world has no physics.
pub fn sensor_depth(world: &mut World, sensor: Entity, collider: Entity) -> Option<f32> {
    ask::<SensorDepths, _>(world, |depths| depths.depth(sensor, collider))
}
