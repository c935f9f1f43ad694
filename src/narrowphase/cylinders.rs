//! Cylinders as they are.
//!
//! Parry's normals of curved surfaces that touch are off by up to some hundredths of a radian (its search stops at a thousandth of
//! the distance), another in every step, which jolts what lies on its side. But the true one is among few: where faces, caps,
//! edges and curved sides meet each other it is an axis, or square to two. Of these, and parry's, it is that along which the two
//! bodies are furthest apart. And points on a curved side lie where it faces.

use crate::body::BodyState;
use glam::Vec3;

/// A candidate nearer than this to parry's normal, as a cosine, may be the true one.
const NEAR: f32 = 0.99;

/// Steps of the way from the best candidate to the best direction.
const STEPS: usize = 16;

/// A normal is on the side where it is further than this from the axis, as a cosine: parry's rule.
const SIDE: f32 = 0.5;

/// One of the two is a cylinder, and both are convex.
pub(super) fn meet(a: &BodyState, b: &BodyState) -> bool {
    let cylinder = |body: &BodyState| {
        body.shape()
            .is_some_and(|shape| shape.as_cylinder().is_some())
    };
    (cylinder(a) || cylinder(b)) && separation(a, b, Vec3::Y).is_some()
}

/// The normal from B to A.
pub(super) fn normal(a: &BodyState, b: &BodyState, parry: Vec3) -> Vec3 {
    let mut candidates = Vec::with_capacity(16);
    let (axes_a, axes_b) = (axes(a), axes(b));
    candidates.extend(axes_a.iter().chain(&axes_b).copied());
    for &one in &axes_a {
        candidates.extend(axes_b.iter().map(|&two| one.cross(two)));
    }
    // Sides that lie along each other.
    for &along in axes_a.iter().chain(&axes_b) {
        let between = a.center - b.center;
        candidates.push(between - along * between.dot(along));
    }
    let apart = |normal: Vec3| separation(a, b, normal).unwrap_or(f32::NEG_INFINITY);
    let slack = 1e-6 * a.size().min(b.size());
    let mut best = (apart(parry) - slack, parry);
    for candidate in candidates {
        let Some(candidate) = candidate.try_normalize() else {
            continue;
        };
        let along = candidate.dot(parry);
        let candidate = candidate * along.signum();
        if along.abs() > NEAR && apart(candidate) > best.0 {
            best = (apart(candidate), candidate);
        }
    }
    climb(a, b, best.1)
}

/// Towards the direction of greatest separation, as far as it changes smoothly: by its gradient, which is square to the normal's
/// part of the way between the two outermost points.
fn climb(a: &BodyState, b: &BodyState, mut normal: Vec3) -> Vec3 {
    let between = |normal: Vec3| {
        let [on_a, on_b] = [outermost(a, -normal), outermost(b, normal)];
        on_a.zip(on_b)
            .map_or(Vec3::ZERO, |(on_a, on_b)| on_a - on_b)
    };
    let mut way = between(normal);
    let mut step = 0.5 / a.size().min(b.size());
    for _ in 0..STEPS {
        let apart = normal.dot(way);
        let next = (normal + step * (way - apart * normal)).normalize();
        let way_there = between(next);
        if next.dot(way_there) > apart {
            (normal, way) = (next, way_there);
            step *= 1.5;
        } else {
            step *= 0.3;
        }
    }
    normal
}

/// Where a point of parry's lies on a body that faces `direction` there; moved only on curved sides.
pub(super) fn on_surface(body: &BodyState, point: Vec3, direction: Vec3) -> Vec3 {
    let Some(cylinder) = body.shape().and_then(|shape| shape.as_cylinder()) else {
        return point;
    };
    let axis = body.pose.rotation * Vec3::Y;
    let along = direction.dot(axis);
    if along.abs() >= SIDE {
        return point;
    }
    let out = (direction - along * axis).normalize();
    let foot = body.pose.position + axis * (point - body.pose.position).dot(axis);
    foot + cylinder.radius * out
}

/// The directions of a body's edges, faces, or axis.
fn axes(body: &BodyState) -> Vec<Vec3> {
    let Some(shape) = body.shape() else {
        return Vec::new();
    };
    let turned = |axis: Vec3| body.pose.rotation * axis;
    if shape.as_cuboid().is_some() {
        [Vec3::X, Vec3::Y, Vec3::Z].map(turned).to_vec()
    } else if shape.as_cylinder().is_some() || shape.as_cone().is_some() {
        vec![turned(Vec3::Y)]
    } else if let Some(capsule) = shape.as_capsule() {
        vec![turned(capsule.segment.scaled_direction())]
    } else {
        Vec::new()
    }
}

/// How far two bodies are apart along a direction from B to A, m, if their shapes have an outermost point.
fn separation(a: &BodyState, b: &BodyState, direction: Vec3) -> Option<f32> {
    Some(direction.dot(outermost(a, -direction)? - outermost(b, direction)?))
}

fn outermost(body: &BodyState, direction: Vec3) -> Option<Vec3> {
    let shape = body.shape()?.as_support_map()?;
    Some(shape.support_point(&body.pose.to_parry(), direction))
}
