//! The way of a character: casts, slides and steps.

use super::{Ground, MoveAndSlide};
use crate::body::{Pose, collider::Collider};
use crate::query::{CastHit, QueryError, QueryFilter, SpatialQuery};
use bevy_ecs::prelude::*;
use bevy_math::Dir3;
use glam::Vec3;

/// Ways shorter than this are none, m.
const MIN_WAY: f32 = 1e-5;

/// Number of times that a character is moved out of bodies that it overlaps.
const MAX_PARTINGS: usize = 4;

/// A body that a character ran into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterHit {
    /// The body.
    pub entity: Entity,
    /// The point of contact, world, m.
    pub point: Vec3,
    /// Outward unit normal of the body's surface there, world.
    pub normal: Vec3,
    /// The part of the character's way that the body blocked, m, world: it points into the body.
    pub blocked: Vec3,
    /// Inverse mass of the body, 1/kg; 0 if it is not dynamic.
    pub inverse_mass: f32,
}

impl CharacterHit {
    /// The impulse (N·s) by which a character pushes the body with a force of at most `max_force` (N) in a step of `seconds`, and with no
    /// more than brings the body to the speed at which the character came. Apply it at [`point`](Self::point), such as with
    /// [`Forces`](crate::body::Forces).
    pub fn push(&self, max_force: f32, seconds: f32) -> Vec3 {
        if self.inverse_mass <= 0.0 {
            return Vec3::ZERO;
        }
        let wanted = self.blocked / (seconds * self.inverse_mass);
        wanted.clamp_length_max(max_force * seconds)
    }
}

/// A character on its way.
pub(super) struct Walk<'a, 'w, 's> {
    query: &'a SpatialQuery<'w, 's>,
    pub collider: &'a Collider,
    pub rules: &'a MoveAndSlide,
    pub filter: &'a QueryFilter<'a>,
    pub pose: Pose,
    pub hits: Vec<CharacterHit>,
}

impl<'a, 'w, 's> Walk<'a, 'w, 's> {
    pub fn new(
        query: &'a SpatialQuery<'w, 's>,
        collider: &'a Collider,
        pose: Pose,
        rules: &'a MoveAndSlide,
        filter: &'a QueryFilter<'a>,
    ) -> Self {
        Self {
            query,
            collider,
            rules,
            filter,
            pose,
            hits: Vec::new(),
        }
    }

    /// Moves the character out of bodies that it overlaps.
    pub fn leave_overlaps(&mut self) -> Result<(), QueryError> {
        for _ in 0..MAX_PARTINGS {
            let overlaps = self
                .query
                .overlaps(self.collider, self.pose, 0.0, self.filter)?;
            let deepest = overlaps.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
            let Some(deepest) = deepest else {
                break;
            };
            self.pose.position += deepest.normal * (deepest.depth + self.rules.margin);
        }
        Ok(())
    }

    /// How far the character gets along a way from a pose: the distance that is free (m), and the obstacle.
    fn free(&self, from: Pose, way: Vec3) -> Result<(f32, Option<CastHit>), QueryError> {
        /// Cosine of the flattest angle at which a character comes to a surface; flatter ways end nearer than the margin.
        const MIN_COSINE: f32 = 0.1;
        let Ok((direction, length)) = Dir3::new_and_length(way) else {
            return Ok((0.0, None));
        };
        let margin = self.rules.margin;
        let reach = length + margin / MIN_COSINE;
        let hit = self
            .query
            .cast_shape(self.collider, from, direction, reach, self.filter)?;
        let Some(hit) = hit else {
            return Ok((length, None));
        };
        let against = -direction.dot(hit.normal);
        if against <= 0.0 {
            // It goes away from what it touches.
            return Ok((length, None));
        }
        let free = (hit.distance - margin / against.max(MIN_COSINE)).max(0.0);
        match free < length {
            true => Ok((free, Some(hit))),
            false => Ok((length, None)),
        }
    }

    /// Goes along a way as far as it is free. Returns the obstacle and the rest of the way.
    fn go(&mut self, way: Vec3) -> Result<(Vec3, Option<CastHit>), QueryError> {
        let (free, hit) = self.free(self.pose, way)?;
        let done = way.normalize_or_zero() * free;
        self.pose.position += done;
        Ok((way - done, hit))
    }

    /// Goes along a way, and along the surfaces of obstacles with what is left of it.
    pub fn slide(&mut self, way: Vec3, stood: Option<&Ground>) -> Result<(), QueryError> {
        let mut left = way;
        let mut planes: Vec<Vec3> = Vec::new();
        for _ in 0..self.rules.max_slides {
            if left.length() < MIN_WAY {
                break;
            }
            let (rest, hit) = self.go(left)?;
            let Some(hit) = hit else {
                break;
            };
            // The edge of a step counts as a wall, until the character stands on it.
            if let Some(stood) = stood
                && !self.rules.is_walkable(hit.normal)
                && self.climb(rest, stood)?
            {
                break;
            }
            self.note(&hit, rest);
            planes.push(self.plane(hit.normal));
            left = along(rest, &planes);
            // A character does not slide against its wanted direction.
            if left.dot(way) < 0.0 {
                break;
            }
        }
        Ok(())
    }

    /// The normal of the plane along which the character slides. At ground that is too steep to stand on it does not climb: for its way
    /// such ground is a wall, unless it comes down on it.
    fn plane(&self, normal: Vec3) -> Vec3 {
        let up = normal.dot(*self.rules.up);
        match !self.rules.is_walkable(normal) && up > 0.0 {
            true => self.rules.level(normal).try_normalize().unwrap_or(normal),
            false => normal,
        }
    }

    fn note(&mut self, hit: &CastHit, rest: Vec3) {
        let blocked = hit.normal * rest.dot(hit.normal).min(0.0);
        let known = self.hits.iter_mut().find(|of| of.entity == hit.entity);
        if let Some(known) = known {
            // One push for each body, or it would be several times as strong.
            known.blocked += blocked;
            return;
        }
        let inverse_mass = self.query.inverse_mass(hit.entity);
        self.hits.push(CharacterHit {
            entity: hit.entity,
            point: hit.point,
            normal: hit.normal,
            blocked,
            inverse_mass,
        });
    }

    /// Climbs a step that is in the way of a character that stood on some ground. Returns false, and stays, if there is none.
    fn climb(&mut self, rest: Vec3, stood: &Ground) -> Result<bool, QueryError> {
        let rules = self.rules;
        let (up, forth) = (*rules.up, rules.level(rest));
        let Ok((ahead, length)) = Dir3::new_and_length(forth) else {
            return Ok(false);
        };
        if rules.step_height <= 0.0 {
            return Ok(false);
        }
        let start = self.pose;
        let at = |position: Vec3| Pose { position, ..start };
        let (raised, _) = self.free(start, up * (rules.step_height + rules.margin))?;
        let raised = at(start.position + up * raised);
        // The step must be deep enough to stand on, even if the character goes on only a little now.
        let probe = length.max(rules.step_depth);
        let (free, _) = self.free(raised, *ahead * probe)?;
        if free < length.min(rules.step_depth) - MIN_WAY {
            return Ok(false);
        }
        let over = at(raised.position + *ahead * free);
        let drop = (raised.position - start.position).dot(up);
        let below = self
            .query
            .ground_within(self.collider, over, drop, rules, self.filter)?;
        let Some(below) = below else {
            return Ok(false);
        };
        // A round shape gets over the edge of a step that is too high.
        let step = (below.point - stood.point).dot(up);
        let height = drop - below.distance + rules.margin;
        if height <= MIN_WAY || step > rules.step_height + rules.margin {
            return Ok(false);
        }
        // No higher than the step is, or a ceiling behind it would be met.
        self.pose = at(start.position + up * height);
        self.go(*ahead * length)?;
        Ok(true)
    }

    /// Keeps the character at its distance from ground that falls away or rises.
    pub fn snap(&mut self) -> Result<(), QueryError> {
        let rules = self.rules;
        let reach = rules.snap_distance + rules.margin;
        let below =
            self.query
                .ground_within(self.collider, self.pose, reach, rules, self.filter)?;
        if let Some(below) = below {
            let down = below.distance - rules.margin;
            let way = match down >= 0.0 {
                true => -down,
                false => self.free(self.pose, *rules.up * -down)?.0,
            };
            self.pose.position += *rules.up * way;
        }
        Ok(())
    }
}

impl SpatialQuery<'_, '_> {
    /// Inverse mass of a body, 1/kg; 0 if it is not dynamic.
    fn inverse_mass(&self, body: Entity) -> f32 {
        let known = self.state(body).filter(|body| body.is_dynamic());
        known.map_or(0.0, |body| body.mass.inverse_mass)
    }
}

/// The part of a way that leads along all planes.
fn along(way: Vec3, planes: &[Vec3]) -> Vec3 {
    let free = |way: Vec3| planes.iter().all(|plane| way.dot(*plane) >= -MIN_WAY);
    let Some((last, before)) = planes.split_last() else {
        return way;
    };
    let slid = way - *last * way.dot(*last).min(0.0);
    if free(slid) {
        return slid;
    }
    // Along the crease of two planes.
    for plane in before {
        if let Some(crease) = last.cross(*plane).try_normalize() {
            let slid = crease * way.dot(crease);
            if free(slid) {
                return slid;
            }
        }
    }
    Vec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_leads_along_planes_and_creases() {
        let way = Vec3::new(1.0, -1.0, 0.5);
        assert_eq!(along(way, &[Vec3::Y]), Vec3::new(1.0, 0.0, 0.5));
        assert_eq!(
            along(way, &[Vec3::Y, Vec3::NEG_X]),
            Vec3::new(0.0, 0.0, 0.5)
        );
        assert_eq!(along(way, &[Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z]), Vec3::ZERO);
    }

    #[test]
    fn a_push_is_limited_by_force_and_by_speed() {
        let hit = CharacterHit {
            entity: Entity::PLACEHOLDER,
            point: Vec3::ZERO,
            normal: Vec3::NEG_X,
            blocked: Vec3::X * 0.05,
            inverse_mass: 0.1,
        };
        assert!(hit.push(1e6, 0.1).distance(Vec3::X * 5.0) < 1e-5);
        assert!(hit.push(20.0, 0.1).distance(Vec3::X * 2.0) < 1e-5);
        let fixed = CharacterHit {
            inverse_mass: 0.0,
            ..hit
        };
        assert_eq!(fixed.push(1e6, 0.1), Vec3::ZERO);
    }
}
