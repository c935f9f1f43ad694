//! Movement since the last edit: which bodies have moved or gone besides those that were edited.

use crate::body::{BodyIndex, BodyTable, Moved, Pose, RigidBody};
use crate::solver::sort;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;

/// Minimum movement that counts, as a share of a body's radius; as in [previews](crate::preview::PreviewSettings::movement_threshold).
const MIN_MOVEMENT_SHARE: f32 = 0.05;

/// The poses of bodies at the last look.
#[derive(Clone, Debug, Default)]
pub(super) struct Watched {
    poses: EntityHashMap<Pose>,
}

/// The changes of bodies since a look.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    /// Bodies that have moved, with their radii, m.
    moved: EntityHashMap<(Moved, f32)>,
    gone: EntityHashSet,
}

impl Watched {
    /// Notes all poses, and returns the changes since the last look.
    pub fn look(&mut self, world: &mut World) -> Drift {
        let mut drift = Drift::default();
        let mut seen = EntityHashSet::default();
        let mut bodies = world.query::<(Entity, &RigidBody, &BodyIndex, &Pose)>();
        let table = world.resource::<BodyTable>();
        for (body, kind, index, &to) in bodies.iter(world) {
            // It is nowhere before its first step.
            let Some(state) = table.get(index.0).filter(|state| state.entity == body) else {
                continue;
            };
            if *kind != RigidBody::Dynamic {
                continue;
            }
            seen.insert(body);
            let known = self.poses.entry(body).or_insert(to);
            let from = *known;
            let moved = Moved { body, from, to };
            if has_moved(&moved, state.radius) {
                drift.moved.insert(body, (moved, state.radius));
                *known = to;
            }
        }
        let gone = self.poses.keys().filter(|body| !seen.contains(*body));
        drift.gone.extend(gone);
        self.poses.retain(|body, _| seen.contains(body));
        drift
    }

    /// Forgets these bodies, so that their changes are not reported: an edit is about them.
    pub fn forget(&mut self, bodies: &[Entity]) {
        for body in bodies {
            self.poses.remove(body);
        }
    }
}

impl Drift {
    /// Adds later changes to these, and drops those of the bodies `but`.
    pub fn go_on(&mut self, next: Self, but: &[Entity]) {
        for (body, moved) in next.moved {
            let known = self.moved.entry(body).or_insert(moved);
            known.0.to = moved.0.to;
        }
        self.gone.extend(next.gone);
        for body in but {
            self.moved.remove(body);
            self.gone.remove(body);
        }
    }

    /// The bodies that are elsewhere now and the bodies that are gone, except those in `but`.
    pub fn told(&self, but: &[Entity]) -> (Vec<Moved>, Vec<Entity>) {
        let is_other = |body: &Entity| !but.contains(body);
        let moved = self.moved.values();
        let moved = moved.filter(|(moved, radius)| has_moved(moved, *radius));
        let moved = moved.map(|(moved, _)| *moved);
        let moved = moved.filter(|moved| is_other(&moved.body) && !self.gone.contains(&moved.body));
        let gone = self.gone.iter().copied().filter(is_other);
        let (mut moved, mut gone): (Vec<Moved>, Vec<Entity>) = (moved.collect(), gone.collect());
        sort::by_key(&mut moved, |moved| {
            (moved.body.index_u32(), moved.body.to_bits())
        });
        sort::by_key(&mut gone, |body| (body.index_u32(), body.to_bits()));
        (moved, gone)
    }
}

fn has_moved(Moved { from, to, .. }: &Moved, radius: f32) -> bool {
    let far =
        to.position.distance(from.position) + to.rotation.angle_between(from.rotation) * radius;
    // A body without a shape has no radius.
    far > MIN_MOVEMENT_SHARE * radius.max(1e-2)
}
