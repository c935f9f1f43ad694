//! Casts of a shape against another, part by part.

use super::touches::{Touches, contact, start};
use crate::body::collider::{Approach, TOUCHING_DISTANCE, first_touch};
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as ParryPose;
use parry3d::partitioning::BvhNode;
use parry3d::query::{
    Contact, DefaultQueryDispatcher, QueryDispatcher, Ray, RayCast, ShapeCastHit, ShapeCastOptions,
    ShapeCastStatus, Unsupported,
};
use parry3d::shape::{CompositeShape, HeightField, Shape};
use std::cell::Cell;

/// The way of a shape, in the frame of what it may hit.
#[derive(Clone, Debug)]
pub(super) struct Way {
    pub from: ParryPose,
    /// Unit vector.
    pub direction: Vec3,
    /// m
    pub max_distance: f32,
    /// The contacts of the shape at the start.
    pub touches: Touches,
}

/// A hit after some way, m.
fn hit(way: f32, touch: &Contact) -> ShapeCastHit {
    ShapeCastHit {
        time_of_impact: way,
        witness1: touch.point1,
        witness2: touch.point2,
        normal1: touch.normal1,
        normal2: touch.normal2,
        status: ShapeCastStatus::Converged,
        subshape1: 0,
        subshape2: 0,
    }
}

type Found = Result<Option<ShapeCastHit>, Unsupported>;

impl Way {
    /// The first hit of a shape on another one. Its first point and normal are those of the other one, in its frame. Which of the two is
    /// divided into parts first is as in parry.
    pub fn first_hit(&self, shape: &dyn Shape, other: &dyn Shape) -> Found {
        let convex = shape.as_support_map().is_some() && other.as_support_map().is_some();
        let swapped = |hit: Option<ShapeCastHit>| hit.map(|hit| hit.swapped());
        if let Some(field) = other.as_heightfield() {
            self.on_field(shape, field)
        } else if let Some(field) = shape.as_heightfield() {
            self.of_the_other().on_field(other, field).map(swapped)
        } else if convex {
            self.on_convex(shape, other)
        } else if let Some(parts) = other.as_composite_shape() {
            self.on_parts(shape, parts)
        } else if let Some(parts) = shape.as_composite_shape() {
            self.of_the_other().on_parts(other, parts).map(swapped)
        } else {
            self.on_convex(shape, other)
        }
    }

    fn on_convex(&self, shape: &dyn Shape, other: &dyn Shape) -> Found {
        let reach = self.touches.reach;
        if !self.touches.normals.is_empty()
            && let Some(start) = start(other, shape, &self.from, reach)
            && start.dist >= -reach
        {
            let hit = hit(0.0, &start);
            return Ok(self.enters(shape, other, 0.0)?.then_some(hit));
        }
        match self.first_touch(shape, other)? {
            Some(hit) if self.enters(shape, other, hit.time_of_impact)? => Ok(Some(hit)),
            _ => Ok(None),
        }
    }

    /// The first place on its way where a convex shape touches another one.
    fn first_touch(&self, shape: &dyn Shape, other: &dyn Shape) -> Found {
        /// The normal is that of the closest points so much before the hit, m, or where they are so far apart: the smaller the gap, the
        /// less is known about its direction.
        const NORMAL_DISTANCE: f32 = 1e-3;
        const NORMAL_GAP: f32 = 2e-4;
        /// The flattest angle for which this is looked at.
        const MIN_ANGLE: f32 = 0.01;
        let at = |way: f32| {
            let mut at = self.from;
            at.translation += self.direction * way;
            contact(other, shape, &at, f32::MAX)
        };
        let (way, mut touch, closing) = match first_touch(self.direction, self.max_distance, at)? {
            Approach::Passes => return Ok(None),
            Approach::Touches {
                way,
                touch,
                closing,
            } => (way, touch, closing),
            Approach::Lost => {
                let options = ShapeCastOptions {
                    max_time_of_impact: self.max_distance,
                    ..Default::default()
                };
                let (from, direction) = (&self.from, self.direction);
                return DefaultQueryDispatcher.cast_shapes(from, direction, other, shape, options);
            }
        };
        let back = NORMAL_DISTANCE.max(NORMAL_GAP / closing.max(MIN_ANGLE));
        if way > 0.0
            && let Some(before) = at((way - back).max(0.0))?
            && before.dist > TOUCHING_DISTANCE
        {
            (touch.normal1, touch.normal2) = (before.normal1, before.normal2);
        }
        Ok(Some(hit(way, &touch)))
    }

    /// Whether a convex shape that has gone some way (m) comes deeper into another one than shapes that touch. On a straight way the depth
    /// first grows and then decreases, so it is enough to look at some places, at first close to each other.
    fn enters(&self, shape: &dyn Shape, other: &dyn Shape, way: f32) -> Result<bool, Unsupported> {
        /// How far a shape is lifted, as a multiple of the depth of shapes that touch.
        const LIFT_FACTOR: f32 = 1.2;
        /// Distance of the first place, as a multiple of the same, and the ratio of those of subsequent places.
        const FIRST_PLACE: f32 = 3.0;
        const PLACE_RATIO: f32 = 4.0;
        /// A short cast enters what it would enter within so many times the depth of shapes that touch.
        const MAX_CAST_FACTOR: f32 = 1e3;
        /// No two bodies are that large, m.
        const MAX_SIZE: f32 = 1e5;
        if self.touches.normals.is_empty() {
            return Ok(true);
        }
        let reach = self.touches.reach;
        let far = (self.max_distance - way).clamp(MAX_CAST_FACTOR * reach, MAX_SIZE);
        let near = other.compute_local_aabb().loosened(reach);
        let mut on = FIRST_PLACE * reach;
        loop {
            let mut at = self.from;
            at.translation += self.direction * (way + on);
            // Directions are as exact as single precision.
            let rounding = 2.0 * f32::EPSILON * on;
            // Parry takes some shapes that nearly touch for shapes that overlap, and finds a wrong depth of others. Both tests have to
            // agree, and no depth is larger than the way since the shapes touched.
            let depths = reach + rounding..2.0 * reach + on;
            let contact = contact(other, shape, &at, 0.0)?;
            let mut enters = contact.is_some_and(|contact| depths.contains(&-contact.dist));
            for normal in &self.touches.normals {
                let mut lifted = at;
                lifted.translation += normal * (LIFT_FACTOR * reach + rounding);
                enters = enters
                    && (DefaultQueryDispatcher.intersection_test(&lifted, other, shape)?)
                        .intersecting;
            }
            if enters || on >= far || !near.intersects(&shape.compute_aabb(&at)) {
                return Ok(enters);
            }
            on = (PLACE_RATIO * on).min(far);
        }
    }

    fn on_parts(&self, shape: &dyn Shape, parts: &dyn CompositeShape) -> Found {
        let start = shape.compute_aabb(&self.from);
        let failed = Cell::new(false);
        let best = parts.bvh().find_best(
            self.max_distance,
            |node: &BvhNode, best| {
                let way = self.until(&start, &node.aabb(), best);
                way.unwrap_or(f32::MAX)
            },
            |id, best| {
                let mut hit = None;
                parts.map_part_at(id, &mut |at, part, _| {
                    let at = at.unwrap_or(&ParryPose::IDENTITY);
                    match self.in_frame(at, best).first_hit(shape, part) {
                        Ok(found) => hit = found.map(|found| found.transform1_by(at)),
                        Err(Unsupported) => failed.set(true),
                    }
                });
                hit
            },
        );
        match failed.get() {
            true => Err(Unsupported),
            false => Ok(best.map(|(_, hit)| hit)),
        }
    }

    /// Walks over the field in pieces of the way. Parry's own walk stays in the first cells if the way is level.
    fn on_field(&self, shape: &dyn Shape, field: &HeightField) -> Found {
        /// Length of a piece, in cells.
        const PIECE_CELLS: f32 = 4.0;
        let start = shape.compute_aabb(&self.from);
        let Some(enters) = self.until(&start, field.root_aabb(), self.max_distance) else {
            return Ok(None);
        };
        let cells = field.cell_width().max(field.cell_height());
        let piece = (PIECE_CELLS * cells).max(start.extents().max_element());
        let (mut from, mut best) = (enters, None::<ShapeCastHit>);
        loop {
            let to = (from + piece).min(self.max_distance);
            let [first, last] = [from, to].map(|way| start.translated(self.direction * way));
            let swept = first.merged(&last).loosened(self.touches.reach);
            if !swept.intersects(field.root_aabb()) {
                return Ok(best);
            }
            let mut result = Ok(());
            field.map_elements_in_local_aabb(&swept, &mut |_, triangle| {
                let nearest = best.map_or(self.max_distance, |best| best.time_of_impact);
                match self
                    .in_frame(&ParryPose::IDENTITY, nearest)
                    .first_hit(shape, triangle)
                {
                    Ok(Some(hit)) if best.is_none() || hit.time_of_impact < nearest => {
                        best = Some(hit);
                    }
                    Ok(_) => {}
                    Err(error) => result = Err(error),
                }
            });
            result?;
            if to >= self.max_distance || best.is_some_and(|best| best.time_of_impact <= to) {
                return Ok(best);
            }
            from = to;
        }
    }

    /// Distance that a box at the start of the way travels until it touches another, m.
    fn until(&self, start: &Aabb, other: &Aabb, max_distance: f32) -> Option<f32> {
        let half = start.half_extents() + Vec3::splat(self.touches.reach);
        let widened = Aabb::new(other.mins - half, other.maxs + half);
        widened.cast_local_ray(
            &Ray::new(start.center(), self.direction),
            max_distance,
            true,
        )
    }

    /// The way in the frame of a part.
    fn in_frame(&self, part: &ParryPose, max_distance: f32) -> Self {
        let back = part.rotation.inverse();
        Self {
            from: part.inv_mul(&self.from),
            direction: back * self.direction,
            max_distance,
            touches: self.touches.turned(back),
        }
    }

    /// The way of the other shape, in the frame of the shape that moves.
    fn of_the_other(&self) -> Self {
        let mut way = self.in_frame(&self.from, self.max_distance);
        way.from = self.from.inverse();
        way.direction = -way.direction;
        way.touches = way.touches.reversed();
        way
    }
}
