//! Supports: [`Supports`], a system parameter that tells which bodies support which.
//!
//! A body supports another if the total force over all their faces pushes the other against gravity by more than a thousandth of its
//! weight. So does a body that another hangs on by a [joint](crate::joint). A body that hangs on the world is supported by the joint. This
//! is computed from the forces of the last step ([`Contacts`]). Nothing is simulated, so it does not predict what happens when a support is
//! removed: a body with two supports may fall when it loses one. Use [`preview`](crate::preview) for that.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_ecs::system::RunSystemOnce;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! let ground = world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y))).id();
//! let mut brick = |x, y| {
//!     let at = Transform::from_xyz(x, y, 0.0);
//!     world.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)).id()
//! };
//! // Two with a gap between them, one across, and one on that.
//! let [left, right] = [-0.6, 0.6].map(|x| brick(x, 0.25));
//! let [across, top] = [0.75, 1.25].map(|y| brick(0.0, y));
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! let tell = move |supports: Supports| {
//!     let under = supports.supported_by(across).unwrap();
//!     assert_eq!(under.iter().map(|bearing| bearing.below).collect::<Vec<_>>(), [left, right]);
//!     assert!((under[0].share - 0.5).abs() < 0.01);
//!     assert_eq!(supports.supported_only_by(across).unwrap(), [top]);
//!     assert_eq!(supports.supported_only_by(left).unwrap(), []);
//!     let path = supports.load_path(top).unwrap();
//!     assert_eq!(path.len(), 5);
//!     let to_the_ground = path.iter().filter(|bearing| bearing.below == ground);
//!     assert!((to_the_ground.map(|bearing| bearing.share).sum::<f32>() - 1.0).abs() < 1e-3);
//! };
//! world.run_system_once(tell).unwrap();
//! ```

use super::{Contacts, NotABody};
use crate::body::BodyState;
use crate::graph::Islands;
use crate::settings::Gravity;
use crate::solver::sort;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::Vec3;
use smallvec::SmallVec;
use std::collections::VecDeque;
use std::fmt;
use std::ops::Range;

/// Minimum supporting force, as a share of the body's weight. Smaller forces are noise.
const MIN_SUPPORT_SHARE: f32 = 1e-3;

/// Bodies can support each other in a circle, by friction. Then shares are computed in rounds: the maximum number of rounds, and the change
/// below which they end.
const MAX_ROUNDS: usize = 64;
const SETTLED_CHANGE: f32 = 1e-5;

/// One body supports another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing {
    /// The body that is supported.
    pub above: Entity,
    /// The body that supports it; for a body that hangs on the world, the joint.
    pub below: Entity,
    /// The supporting force, against gravity, N.
    pub force: f32,
    /// For [`Supports::supported_by`] and [`Supports::supports`], the share of this force in the total that supports `above`. For
    /// [`Supports::load_path`], the share of the body's weight that passes here.
    pub share: f32,
}

/// System parameter that tells which bodies support which. Outside of a system use [`supports`].
///
/// A body supports another if the total force over all their faces pushes the other against gravity by more than a thousandth of its
/// weight. Nothing is simulated: a body with two supports may fall when it loses one. Use [`preview`](crate::preview) to find out.
#[derive(SystemParam)]
pub struct Supports<'w, 's> {
    contacts: Contacts<'w, 's>,
    islands: Res<'w, Islands>,
    gravity: Res<'w, Gravity>,
}

impl fmt::Debug for Supports<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Supports").finish_non_exhaustive()
    }
}

/// Asks a world which bodies support which, outside of a system: calls `ask` with [`Supports`] and returns its result.
///
/// ```
/// # use drystone::prelude::*;
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// # let body = world.spawn((RigidBody::Dynamic, Collider::ball(0.5))).id();
/// # drystone::step(world, 1.0 / 60.0).unwrap();
/// let below = supports(world, |supports| supports.supported_by(body)).unwrap();
/// assert!(below.is_empty(), "it falls");
/// ```
///
/// # Panics
/// If [`StepPlugin`](crate::StepPlugin) was not added.
pub fn supports<R>(world: &mut World, ask: impl FnOnce(Supports) -> R) -> R {
    crate::ask::ask::<Supports, R>(world, ask)
}

impl Supports<'_, '_> {
    /// The supports of a body, in order of spawning. Static and kinematic bodies have none.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn supported_by(&self, body: Entity) -> Result<Vec<Bearing>, NotABody> {
        let slot = self.contacts.slot(body)?;
        let Some(least) = self.min_force(slot) else {
            return Ok(Vec::new());
        };
        let up = -self.gravity.0.normalize_or_zero();
        let neighbours = self.neighbours(slot).into_iter();
        let forces = neighbours.map(|(by, force)| (by, force.dot(up)));
        let bearing = |(below, force)| Bearing {
            above: body,
            below,
            force,
            share: 0.0,
        };
        let bearings = forces.filter(|&(_, force)| force > least).map(bearing);
        let mut bearings: Vec<Bearing> = bearings.collect();
        let sum: f32 = bearings.iter().map(|bearing| bearing.force).sum();
        for bearing in &mut bearings {
            bearing.share = bearing.force / sum;
        }
        Ok(bearings)
    }

    /// The bodies that a body supports, in order of spawning.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn supports(&self, body: Entity) -> Result<Vec<Bearing>, NotABody> {
        let slot = self.contacts.slot(body)?;
        let down = self.gravity.0.normalize_or_zero();
        let mut bearings = Vec::new();
        let neighbours = self.neighbours(slot).into_iter();
        for (other, _) in neighbours.filter(|(_, force)| force.dot(down) > 0.0) {
            let by = self.supported_by_any(other)?;
            bearings.extend(by.into_iter().filter(|bearing| bearing.below == body));
        }
        Ok(bearings)
    }

    /// The supports of a body. A joint to the world has none.
    fn supported_by_any(&self, below: Entity) -> Result<Vec<Bearing>, NotABody> {
        match self.contacts.joints.contains(below) {
            true => Ok(Vec::new()),
            false => self.supported_by(below),
        }
    }

    /// The bodies that press or pull on the body in a slot, with their total force over all faces and joints, N, world axes. Those that
    /// touch it come first, each kind in spawn order.
    fn neighbours(&self, slot: u32) -> SmallVec<[(Entity, Vec3); 8]> {
        let mut found = self.contacts.neighbours(slot);
        for (by, force) in self.contacts.joined(slot) {
            match found.iter_mut().find(|(known, _)| *known == by) {
                Some((_, sum)) => *sum += force,
                None => found.push((by, force)),
            }
        }
        found
    }

    /// Minimum force of a support of a body, N. `None` for bodies that cannot fall.
    fn min_force(&self, slot: u32) -> Option<f32> {
        let body = self.contacts.table.get(slot)?;
        let weight = self.gravity.0.length() * body.gravity_scale.abs() / body.mass.inverse_mass;
        (body.is_dynamic() && weight.is_finite()).then_some(MIN_SUPPORT_SHARE * weight)
    }

    /// The paths of a body's weight to the ground, from the top down: each support once, with the share of that weight that it carries.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn load_path(&self, body: Entity) -> Result<Vec<Bearing>, NotABody> {
        let mut path = Vec::new();
        // The range of each body's bearings in the path.
        let mut below: EntityHashMap<Range<usize>> = EntityHashMap::default();
        let mut next = VecDeque::from([body]);
        while let Some(body) = next.pop_front() {
            if below.contains_key(&body) {
                continue;
            }
            let first = path.len();
            path.extend(self.supported_by_any(body)?);
            below.insert(body, first..path.len());
            next.extend(path[first..].iter().map(|bearing| bearing.below));
        }
        let (order, circles) = from_the_top(body, &path, &below);
        let fractions: Vec<f32> = path.iter().map(|bearing| bearing.share).collect();
        path.iter_mut().for_each(|bearing| bearing.share = 0.0);
        let mut through = EntityHashMap::from_iter([(body, 1.0)]);
        for _ in 0..if circles { MAX_ROUNDS } else { 1 } {
            let mut change: f32 = 0.0;
            for at in &order {
                let here = through.get(at).copied().unwrap_or(0.0);
                for i in below[at].clone() {
                    let more = here * fractions[i] - path[i].share;
                    path[i].share += more;
                    *through.entry(path[i].below).or_default() += more;
                    change = change.max(more.abs());
                }
            }
            if change < SETTLED_CHANGE {
                break;
            }
        }
        let place: EntityHashMap<usize> = order.iter().copied().zip(0..).collect();
        sort::by_key(&mut path, |bearing| place[&bearing.above]);
        Ok(path)
    }

    /// The bodies that only this body supports, directly or through others: all paths of their weight pass through it. In order of
    /// spawning.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn supported_only_by(&self, body: Entity) -> Result<Vec<Entity>, NotABody> {
        let down = self.gravity.0.normalize_or_zero();
        let mut search = Search {
            supports: self,
            under: body,
            hangs: EntityHashSet::default(),
            stands: EntityHashSet::default(),
        };
        let mut next = vec![body];
        while let Some(lower) = next.pop() {
            let slot = self.contacts.slot(lower)?;
            let neighbours = self.neighbours(slot).into_iter();
            for (above, _) in neighbours.filter(|(_, force)| force.dot(down) > 0.0) {
                if above == body || search.knows(above) {
                    continue;
                }
                // Its force may be below the threshold.
                let by = self.supported_by_any(above)?;
                if by.iter().any(|bearing| bearing.below == lower) {
                    next.extend(search.decide(above)?);
                }
            }
        }
        Ok(self.in_spawn_order(search.hangs.into_iter()))
    }

    /// The structure that a body belongs to: all dynamic bodies that are connected with it by contacts and joints between
    /// dynamic bodies, in spawn order. Empty for static and kinematic bodies, which are in no structure.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn structure(&self, body: Entity) -> Result<Vec<Entity>, NotABody> {
        let slot = self.contacts.slot(body)?;
        let table = &*self.contacts.table;
        if !table.get(slot).is_some_and(BodyState::is_dynamic) {
            return Ok(Vec::new());
        }
        let members = self.islands.structure(slot).iter();
        let members = members.filter_map(|&slot| table.get(slot));
        let members = members.filter(|body| self.contacts.slot(body.entity).is_ok());
        let mut members: Vec<_> = members
            .map(|body| (body.spawn_order, body.entity))
            .collect();
        sort::by_key(&mut members, |&(spawn_order, _)| spawn_order);
        Ok(members.into_iter().map(|(_, body)| body).collect())
    }

    fn in_spawn_order(&self, bodies: impl Iterator<Item = Entity>) -> Vec<Entity> {
        let mut bodies: Vec<Entity> = bodies.collect();
        let spawn_order = |&body: &Entity| {
            let slot = self.contacts.slot(body).ok()?;
            Some(self.contacts.table.get(slot)?.spawn_order)
        };
        sort::by_key(&mut bodies, spawn_order);
        bodies
    }
}

/// A search for bodies that only one body supports.
struct Search<'a, 'w, 's> {
    supports: &'a Supports<'w, 's>,
    under: Entity,
    /// Bodies known to be supported only by it, and bodies known not to be.
    hangs: EntityHashSet,
    stands: EntityHashSet,
}

impl Search<'_, '_, '_> {
    fn knows(&self, body: Entity) -> bool {
        self.hangs.contains(&body) || self.stands.contains(&body)
    }

    /// Searches for a path down that does not pass through the body. If there is none, all bodies visited on the way are supported only by
    /// it, and are returned.
    fn decide(&mut self, body: Entity) -> Result<Vec<Entity>, NotABody> {
        // For each visited body, the body that the search came from.
        let mut from = EntityHashMap::from_iter([(body, body)]);
        let mut next = vec![body];
        while let Some(here) = next.pop() {
            let by = match self.stands.contains(&here) {
                true => Vec::new(),
                false => self.supports.supported_by_any(here)?,
            };
            // A body without supports is the ground, or falls by itself.
            if by.is_empty() {
                let (mut at, mut upper) = (here, from[&here]);
                self.stands.insert(at);
                while upper != at {
                    (at, upper) = (upper, from[&upper]);
                    self.stands.insert(at);
                }
                return Ok(Vec::new());
            }
            for Bearing { below, .. } in by {
                let leads_back = below == self.under || self.hangs.contains(&below);
                if !leads_back && !from.contains_key(&below) {
                    from.insert(below, here);
                    next.push(below);
                }
            }
        }
        let found: Vec<Entity> = from.into_keys().collect();
        self.hangs.extend(&found);
        Ok(found)
    }
}

/// Sorts bodies so that each comes after all bodies that it supports. Also returns whether some support each other in a circle; those are
/// in the order of the path.
fn from_the_top(
    top: Entity,
    path: &[Bearing],
    below: &EntityHashMap<Range<usize>>,
) -> (Vec<Entity>, bool) {
    // The number of bearings on each body that have not been passed yet.
    let mut uppers: EntityHashMap<usize> = EntityHashMap::default();
    for bearing in path {
        *uppers.entry(bearing.below).or_default() += 1;
    }
    // A path that comes back to the body at the top is a circle, too.
    let (mut order, mut circles) = (Vec::new(), uppers.contains_key(&top));
    let mut taken = EntityHashSet::default();
    let mut next = VecDeque::from([top]);
    let mut all = path.iter().map(|bearing| bearing.above);
    loop {
        let Some(body) = next.pop_front() else {
            match all.find(|body| !taken.contains(body)) {
                Some(body) => next.push_back(body),
                None => return (order, circles),
            }
            circles = true;
            continue;
        };
        if !taken.insert(body) {
            continue;
        }
        order.push(body);
        for bearing in &path[below[&body].clone()] {
            if let Some(left) = uppers.get_mut(&bearing.below) {
                *left -= 1;
                if *left == 0 {
                    next.push_back(bearing.below);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bodies from the top, and whether some support each other in a circle. Body 0 is at the top.
    fn sorted(supports: &[(u32, u32)]) -> (Vec<u32>, bool) {
        let body = |number| Entity::from_raw_u32(number).unwrap();
        let (mut path, mut below) = (Vec::new(), EntityHashMap::default());
        for number in 0..5 {
            let first = path.len();
            let by = supports.iter().filter(|&&(above, _)| above == number);
            path.extend(by.map(|&(above, below)| Bearing {
                above: body(above),
                below: body(below),
                force: 1.0,
                share: 0.5,
            }));
            below.insert(body(number), first..path.len());
        }
        let (order, circles) = from_the_top(body(0), &path, &below);
        let order = order.iter().map(|body| body.index_u32()).collect();
        (order, circles)
    }

    #[test]
    fn a_circle_is_found_wherever_it_closes() {
        let tree = [(0, 1), (0, 2), (1, 3), (2, 3), (3, 4)];
        assert_eq!(sorted(&tree), (vec![0, 1, 2, 3, 4], false));
        let (_, at_the_top) = sorted(&[(0, 1), (1, 0), (1, 2), (2, 3), (3, 4)]);
        let (_, further_down) = sorted(&[(0, 1), (1, 2), (2, 1), (2, 3), (3, 4)]);
        assert!(at_the_top && further_down);
    }
}
