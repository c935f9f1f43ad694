//! The stage **sleeping**: puts islands to sleep whose bodies have all been still for a while and are [at rest](drift), so that they
//! cost no time.
//!
//! A sleeping body keeps its contacts, impulses and anchors, so that it continues from the same state when it wakes. It becomes
//! [inactive](crate::body::Inactive) in the next step. It wakes when the user moves, pushes, holds or changes it, when settings change,
//! when an awake body hits it or changes what it bears, and when a body that it touched is removed; see
//! [`islands`](crate::graph::islands()).

mod drift;
mod held;

pub(crate) use drift::Drift;
pub(in crate::graph) use drift::Drifts;

use crate::body::{ActiveBodies, BodyIndex, BodyState, BodyTable, Velocity};
use crate::graph::Islands;
use crate::settings::{SleepSettings, StepTime};
use bevy_ecs::prelude::*;
use bevy_math::FloatPow;
use drift::Drifting;
use held::Holding;

/// Puts islands to sleep whose bodies have been still for [`SleepSettings::delay`], and are at rest.
pub fn sleeping(
    time: Res<StepTime>,
    settings: Res<SleepSettings>,
    (table, mut islands): (Res<BodyTable>, ResMut<Islands>),
    holding: Holding,
    mut bodies: ActiveBodies,
    mut restless: Local<Vec<bool>>,
) {
    if !settings.enabled {
        return;
    }
    let islands = &mut *islands;
    restless.clear();
    restless.resize(islands.count(), false);
    let state_of = |entity: Entity, index: &BodyIndex| {
        let is_awake = |body: &&BodyState| body.entity == entity && !body.asleep;
        table.get(index.0).filter(is_awake)
    };
    for mut body in &mut bodies {
        let slot = body.index.0;
        let Some((state, island)) = state_of(body.entity, body.index).zip(islands.of(slot)) else {
            continue;
        };
        let (velocity, sleeping) = (body.velocity, &mut body.sleeping);
        let sleeping = sleeping.bypass_change_detection();
        let still = velocity.linear.length_squared() < settings.linear_speed.squared()
            && velocity.angular.length_squared() < settings.angular_speed.squared();
        let before = sleeping.still_for;
        sleeping.still_for = if still { before + time.dt } else { 0.0 };
        if still {
            let times = [before, sleeping.still_for];
            let seen = (slot, state, &*body.pose);
            islands.drifts.look(seen, settings.delay, times);
        }
        if sleeping.still_for < settings.delay || !sleeping.allowed {
            restless[island] = true;
        }
    }
    if !restless.contains(&false) {
        return;
    }
    let mut driven = vec![None; restless.len()];
    for body in &bodies {
        let slot = body.index.0;
        let Some((state, island)) = state_of(body.entity, body.index).zip(islands.of(slot)) else {
            continue;
        };
        if restless[island] {
            continue;
        }
        let rests =
            match islands
                .drifts
                .of(slot, state.radius, settings.linear_speed, settings.delay)
            {
                Drifting::Rests => true,
                Drifting::Goes => false,
                Drifting::Creeps => {
                    let is_driven = || holding.is_driven(islands, island);
                    holding.holds(slot, state) && !*driven[island].get_or_insert_with(is_driven)
                }
            };
        restless[island] = !rests;
    }
    for mut body in &mut bodies {
        let slot = body.index.0;
        let island = state_of(body.entity, body.index).and_then(|_| islands.of(slot));
        if island.is_some_and(|island| !restless[island]) {
            *body.velocity = Velocity::default();
            body.sleeping.asleep = true;
            islands.drifts.forget(slot);
        }
    }
}
