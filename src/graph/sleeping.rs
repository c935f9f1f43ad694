//! The stage **sleeping**: puts islands to sleep whose bodies have all been still for a while, so that they cost no time.
//!
//! A sleeping body keeps its contacts, impulses and anchors, so that it continues from the same state when it wakes. It becomes
//! [inactive](crate::body::Inactive) in the next step. It wakes when the user moves, pushes, holds or changes it, when settings change, when
//! an awake body hits it or changes what it bears, and when a body that it touched is removed; see [`islands`](super::islands()).

use super::Islands;
use crate::body::{ActiveBodies, BodyIndex, BodyState, BodyTable, Velocity};
use crate::settings::{SleepSettings, StepTime};
use bevy_ecs::prelude::*;
use bevy_math::FloatPow;

/// Puts islands to sleep whose bodies have been still for [`SleepSettings::delay`].
pub fn sleeping(
    time: Res<StepTime>,
    settings: Res<SleepSettings>,
    (table, islands): (Res<BodyTable>, Res<Islands>),
    mut bodies: ActiveBodies,
    mut restless: Local<Vec<bool>>,
) {
    if !settings.enabled {
        return;
    }
    restless.clear();
    restless.resize(islands.count(), false);
    let island_of = |entity: Entity, index: &BodyIndex| {
        let is_awake = |body: &BodyState| body.entity == entity && !body.asleep;
        table.get(index.0).filter(|body| is_awake(body))?;
        islands.of(index.0)
    };
    for mut body in &mut bodies {
        let Some(island) = island_of(body.entity, body.index) else {
            continue;
        };
        let (velocity, sleeping) = (body.velocity, &mut body.sleeping);
        let sleeping = sleeping.bypass_change_detection();
        let still = velocity.linear.length_squared() < settings.linear_speed.squared()
            && velocity.angular.length_squared() < settings.angular_speed.squared();
        sleeping.still_for = if still {
            sleeping.still_for + time.dt
        } else {
            0.0
        };
        if sleeping.still_for < settings.delay || !sleeping.allowed {
            restless[island] = true;
        }
    }
    for mut body in &mut bodies {
        let island = island_of(body.entity, body.index);
        if island.is_some_and(|island| !restless[island]) {
            *body.velocity = Velocity::default();
            body.sleeping.asleep = true;
        }
    }
}
