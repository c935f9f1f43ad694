//! Debris: bodies that go after a while, or when there are too many.

use crate::body::SpawnOrder;
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// A body that is removed after a while, or when there is too much debris. The oldest goes first, whether it sleeps or not; what lay on it
/// wakes. Put it on any body, or into [`Fracturable::debris`](super::Fracturable::debris).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
pub struct Debris {
    /// Time after which it is removed, s. Default: 20.
    pub lifetime: f32,
    /// Time before its end in which its [`opacity`](Self::opacity) falls from 1 to 0, s. Default: 1.
    pub fade: f32,
    /// It begins to fade as soon as so much younger debris is there. Default: 1000.
    pub most: u32,
    /// Time for which it has been debris, s. Steps count it.
    pub age: f32,
}

impl Default for Debris {
    fn default() -> Self {
        Self {
            lifetime: 20.0,
            fade: 1.0,
            most: 1000,
            age: 0.0,
        }
    }
}

impl Debris {
    /// How opaque it should be drawn: 1 until it fades, 0 at its end. Drystone draws nothing: a system of the game sets the colour.
    pub fn opacity(&self) -> f32 {
        let left = self.lifetime - self.age;
        match self.fade > 0.0 {
            true => (left / self.fade).clamp(0.0, 1.0),
            false => 1.0,
        }
    }

    fn is_over(&self) -> bool {
        // Debris whose lifetime is no number goes at once.
        self.age >= self.lifetime || self.lifetime.is_nan()
    }
}

/// Removes debris that is too old, and begins to fade the oldest if there is too much. Part of [`FractureSystems`](super::FractureSystems).
pub fn debris(
    mut commands: Commands,
    time: Res<StepTime>,
    mut all: Query<(Entity, &SpawnOrder, &mut Debris)>,
) {
    let (mut count, mut most) = (0, u32::MAX);
    for (entity, _, mut debris) in &mut all {
        let debris = debris.bypass_change_detection();
        debris.age += time.dt;
        if debris.is_over() {
            commands.entity(entity).try_despawn();
        } else {
            count += 1;
            most = most.min(debris.most);
        }
    }
    if count <= most {
        return;
    }
    let standing = all.iter().filter(|(.., debris)| !debris.is_over());
    let mut by_age: Vec<_> = standing
        .map(|(entity, order, debris)| (debris.age, *order, entity))
        .collect();
    // The youngest first; of those that came at once, the last.
    sort::by_key(&mut by_age, |(age, order, _)| (*age, u64::MAX - order.0));
    for (younger, (.., entity)) in by_age.into_iter().enumerate() {
        let Ok((_, _, mut debris)) = all.get_mut(entity) else {
            continue;
        };
        if (younger as u32) < debris.most || debris.age >= debris.lifetime - debris.fade {
            continue;
        }
        debris.lifetime = debris.age + debris.fade.max(0.0);
        if debris.is_over() {
            commands.entity(entity).try_despawn();
        }
    }
}
