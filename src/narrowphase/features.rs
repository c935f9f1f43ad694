//! Where sides and ends of cylinders lie on each other and on the faces of boxes.
//!
//! Parry takes an end for a square that turns with the deepest point, and of two cylinders that lie along each other it often
//! has one point, now at this end and now at that; what lies there rocks. Here a side is a segment, an end is its rim, and the
//! points are those of each that lie over the other.

use super::cylinders;
use crate::body::BodyState;
use bevy_math::ops;
use glam::Vec3;
use std::f32::consts::TAU;

/// A feature counts up to so far from the plane of contact, as the sine of the angle.
const FLAT: f32 = 0.15;

/// Points of a rim.
const RIM: usize = 8;

/// A part of a surface that faces the other body.
enum Feature {
    /// A side, from end to end.
    Segment([Vec3; 2]),
    /// An end: its middle, the way out, and points on its rim.
    Disc(Vec3, Vec3, [Vec3; RIM]),
    /// A face: its middle, the way out, and half its edges.
    Face(Vec3, Vec3, [Vec3; 2]),
}

/// Points on A and on B where the two lie on each other, with the normal from B to A; none where they meet otherwise.
pub(super) fn contacts(a: &BodyState, b: &BodyState, normal: Vec3) -> Vec<[Vec3; 2]> {
    let (Some(of_a), Some(of_b)) = (Feature::of(a, -normal), Feature::of(b, normal)) else {
        return Vec::new();
    };
    if let (Feature::Segment(one), Feature::Segment(two)) = (&of_a, &of_b) {
        return along(*one, *two, normal);
    }
    let slack = 1e-4 * a.size().min(b.size());
    let [on_a, on_b] = [
        of_a.over(&of_b, normal, slack),
        of_b.over(&of_a, normal, slack),
    ];
    let on_a = on_a
        .into_iter()
        .map(|point| [point, of_b.below(point, normal)]);
    let on_b = on_b
        .into_iter()
        .map(|point| [of_a.below(point, normal), point]);
    on_a.chain(on_b).collect()
}

impl Feature {
    fn of(body: &BodyState, direction: Vec3) -> Option<Self> {
        let shape = body.shape()?;
        let (center, turn) = (body.pose.position, body.pose.rotation);
        if let Some(cylinder) = shape.as_cylinder() {
            let axis = turn * Vec3::Y;
            let along = direction.dot(axis);
            let end = cylinder.half_height * axis;
            if along.abs() < FLAT {
                let side = cylinders::on_surface(body, center, direction);
                return Some(Self::Segment([side - end, side + end]));
            }
            let out = axis * along.signum();
            let middle = center + cylinder.half_height * out;
            let rim = std::array::from_fn(|i| {
                let (sin, cos) = ops::sin_cos(i as f32 * TAU / RIM as f32);
                middle + cylinder.radius * (turn * Vec3::new(cos, 0.0, sin))
            });
            let flat = direction.cross(axis).length() < FLAT;
            return flat.then_some(Self::Disc(middle, out, rim));
        }
        let half = shape.as_cuboid()?.half_extents;
        let local = turn.inverse() * direction;
        let i = local.abs().max_position();
        let mut out = Vec3::ZERO;
        out[i] = local[i].signum();
        let edge = |i: usize| turn * (Vec3::AXES[i] * half[i]);
        let (middle, edges) = (
            center + turn * (out * half),
            [edge((i + 1) % 3), edge((i + 2) % 3)],
        );
        let flat = local.cross(out).length() < FLAT;
        flat.then_some(Self::Face(middle, turn * out, edges))
    }

    /// The points of this that lie over another flat one.
    fn over(&self, other: &Self, normal: Vec3, slack: f32) -> Vec<Vec3> {
        match self {
            Self::Segment([from, to]) => {
                let (mut first, mut last) = (0.0f32, 1.0f32);
                for (low, high) in other.spans(*from, *to, normal) {
                    (first, last) = (first.max(low), last.min(high));
                }
                match first <= last {
                    true => vec![from.lerp(*to, first), from.lerp(*to, last)],
                    false => Vec::new(),
                }
            }
            Self::Disc(_, _, rim) => {
                let mut over = rim.to_vec();
                over.retain(|p| other.holds(*p, normal, slack));
                if over.len() == RIM {
                    // Four of them do, and always the same.
                    over = rim.iter().step_by(RIM / 4).copied().collect();
                }
                over
            }
            Self::Face(middle, _, [x, y]) => [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
                .map(|(i, j)| middle + i * x + j * y)
                .into_iter()
                .filter(|p| other.holds(*p, normal, slack))
                .collect(),
        }
    }

    /// From where to where a segment is over this, as shares of its length.
    fn spans(&self, from: Vec3, to: Vec3, normal: Vec3) -> Vec<(f32, f32)> {
        let flat = |v: Vec3| v - normal * normal.dot(v);
        let way = flat(to - from);
        match self {
            Self::Segment(_) => vec![(1.0, 0.0)],
            Self::Disc(middle, _, rim) => {
                // |start + t way| = radius
                let start = flat(from - middle);
                let (square, half) = (way.length_squared(), way.dot(start));
                let radius = (rim[0] - middle).length_squared();
                let root = (half * half - square * (start.length_squared() - radius)).sqrt();
                match root.is_nan() || square == 0.0 {
                    true => vec![(1.0, 0.0)],
                    false => vec![((-half - root) / square, (-half + root) / square)],
                }
            }
            Self::Face(middle, _, edges) => {
                let span = |edge: &Vec3| {
                    let axis = edge.normalize();
                    let (at, speed) = (axis.dot(from - middle), axis.dot(to - from));
                    if speed.abs() < 1e-6 * way.length() {
                        return match at.abs() <= edge.length() {
                            true => (0.0, 1.0),
                            false => (1.0, 0.0),
                        };
                    }
                    let (one, two) = ((-edge.length() - at) / speed, (edge.length() - at) / speed);
                    (one.min(two), one.max(two))
                };
                edges.iter().map(span).collect()
            }
        }
    }

    /// A point is over this flat feature.
    fn holds(&self, point: Vec3, normal: Vec3, slack: f32) -> bool {
        let there = self.below(point, normal);
        match self {
            Self::Segment(_) => false,
            Self::Disc(middle, _, rim) => {
                (there - middle).length() <= (rim[0] - middle).length() + slack
            }
            Self::Face(middle, _, edges) => edges
                .iter()
                .all(|edge| (there - middle).dot(edge.normalize()).abs() <= edge.length() + slack),
        }
    }

    /// Where the line through a point along the normal meets the plane of this.
    fn below(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let (Self::Disc(middle, out, _) | Self::Face(middle, out, _)) = self else {
            return point;
        };
        point - normal * (out.dot(point - middle) / out.dot(normal))
    }
}

/// The ends of what two sides have in common that lie along each other.
fn along(one: [Vec3; 2], two: [Vec3; 2], normal: Vec3) -> Vec<[Vec3; 2]> {
    let flat = |v: Vec3| v - normal * normal.dot(v);
    let way = flat(one[1] - one[0]);
    let axis = way.normalize();
    let other = flat(two[1] - two[0]);
    if axis.cross(other).length() > FLAT * other.length() {
        return Vec::new();
    }
    let at = |p: Vec3| axis.dot(p - one[0]);
    let (low, high) = (at(two[0]).min(at(two[1])), at(two[0]).max(at(two[1])));
    let (first, last) = (low.max(0.0), high.min(way.length()));
    if first > last {
        return Vec::new();
    }
    let place = |[from, to]: [Vec3; 2], there: f32| {
        let share = (there - at(from)) / (at(to) - at(from));
        from.lerp(to, share)
    };
    [first, last]
        .map(|t| [place(one, t), place(two, t)])
        .to_vec()
}
