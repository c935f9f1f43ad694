//! Platforms that a character passes from below and from the side, and stands on.

use super::Character;
use crate::body::{BodyState, Pose, collider::Collider};
use crate::collider::LayerMask;
use crate::query::SpatialQuery;
use bevy_ecs::entity::Entity;
use parry3d::query::contact;

/// A character stands above a platform if the way to it leads down at least so steeply: the sine of 6°.
const ABOVE: f32 = 0.1;

impl Character {
    /// Whether a body is an obstacle for a character that starts at a pose and goes up to `reach` m. Platforms in its
    /// [`one_way`](Self::one_way) layers are only for one that is above them.
    pub(super) fn is_stopped_by(
        &self,
        world: &SpatialQuery,
        other: Entity,
        (shape, from): (&Collider, Pose),
        reach: f32,
    ) -> bool {
        if self.one_way == LayerMask::NONE {
            return true;
        }
        let found = world.state(other).zip(world.pose(other));
        let Some((body, pose)) = found.filter(|(body, _)| self.passes(body)) else {
            return true;
        };
        if self.drops {
            return false;
        }
        let Some(platform) = body.shape() else {
            return true;
        };
        let (at, to) = (pose.to_parry(), from.to_parry());
        match contact(&at, platform, &to, &**shape.shape(), reach) {
            Ok(Some(touch)) => {
                let is_apart = touch.dist > -self.rules.margin;
                is_apart && touch.normal1.dot(*self.rules.up) > ABOVE
            }
            _ => true,
        }
    }

    /// Whether it is in such layers only: a body without `CollisionLayers` is in all.
    fn passes(&self, body: &BodyState) -> bool {
        let layers = body.properties.layers.memberships;
        layers != 0 && layers & !self.one_way.0 == 0
    }
}
