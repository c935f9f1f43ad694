//! Builds a [`Polyhedron`] from the outlines of its faces, and checks that they form a closed convex surface.

use super::lattice::Lattice;
use super::outlines::newell;
use super::{Edge, Face, Moments, Polyhedron};
use crate::body::collider::ColliderError;
use crate::solver::sort;
use glam::{DVec3, Vec3};
use parry3d::mass_properties::MassProperties;

/// Tolerance for a corner outside the plane of a face, as a multiple of the lattice's slack. It is larger than 1 because a plane was fitted
/// to more vertices than the corners that are left.
const CORNER_TOLERANCE: f64 = 2.0;

/// Builds a polyhedron from the outlines of its faces.
///
/// # Errors
/// [`ColliderError::TooManyCorners`] if there are too many corners. [`ColliderError::DegenerateHull`] if the outlines are not those of a
/// convex polyhedron, or if it is so thin that only rounding gives it a volume.
pub(super) fn join(
    points: &[Vec3],
    lattice: &Lattice,
    outlines: &[impl AsRef<[u32]>],
) -> Result<Polyhedron, ColliderError> {
    let mut used: Vec<u32> = outlines.iter().flat_map(AsRef::as_ref).copied().collect();
    used.sort_unstable();
    used.dedup();
    if used.len() > Polyhedron::MAX_CORNERS {
        return Err(ColliderError::TooManyCorners(used.len()));
    }
    let place = |i: &u32| used.binary_search(i).unwrap_or_default() as u16;
    let corners: Box<[u16]> = outlines.iter().flat_map(AsRef::as_ref).map(place).collect();
    let points: Box<[Vec3]> = used.iter().map(|&i| points[i as usize]).collect();

    let slack = lattice.slack * lattice.step;
    let mut first = 0;
    let faces: Option<Box<[Face]>> = outlines
        .iter()
        .map(|outline| {
            let range = first..first + outline.as_ref().len();
            first = range.end;
            face(&points, &corners, range, slack)
        })
        .collect();
    let faces = faces.ok_or(ColliderError::DegenerateHull)?;
    let (edges, sides) = edges(&faces, &corners).ok_or(ColliderError::DegenerateHull)?;
    if points.len() + faces.len() != edges.len() + 2 {
        return Err(ColliderError::DegenerateHull);
    }
    let (around, first_around) = around(&faces, &corners, points.len());
    let mut polyhedron = Polyhedron {
        points,
        faces,
        corners,
        sides,
        edges,
        around,
        first_around,
        center: Vec3::ZERO,
        inner: 0.0,
        outer: 0.0,
        has_given_faces: false,
        moments: Moments::default(),
        mass: MassProperties::default(),
    };
    polyhedron.moments = Moments::of(&polyhedron);
    polyhedron.mass = polyhedron.moments.rounded();
    polyhedron.center = polyhedron.moments.centroid.as_vec3();
    let center = polyhedron.center.as_dvec3();
    let depth_of_center = |face: &Face| {
        let on = polyhedron.points[usize::from(polyhedron.corners[face.first as usize])];
        face.normal.as_dvec3().dot(on.as_dvec3() - center)
    };
    let depths = polyhedron.faces.iter().map(depth_of_center);
    polyhedron.inner = depths.fold(f64::INFINITY, f64::min) as f32;
    let away = polyhedron
        .points
        .iter()
        .map(|point| point.distance(polyhedron.center));
    polyhedron.outer = away.fold(0.0, f32::max);
    // A comparison with NaN is false.
    match polyhedron.inner > 0.0 && polyhedron.inner.is_finite() {
        true => Ok(polyhedron),
        false => Err(ColliderError::DegenerateHull),
    }
}

/// Returns the face with these corners. Returns `None` if they do not form a polygon, if some points are outside its plane, or if all
/// points are almost in its plane.
fn face(
    points: &[Vec3],
    corners: &[u16],
    range: std::ops::Range<usize>,
    slack: f64,
) -> Option<Face> {
    let own = &corners[range.clone()];
    let place = |k: usize| points[own[k % own.len()] as usize].as_dvec3();
    let normal = newell(own.len(), place).try_normalize()?.as_vec3();
    let height = |p: DVec3| normal.as_dvec3().dot(p);
    let heights = points.iter().map(|p| height(p.as_dvec3()));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    let lowest = (0..own.len())
        .map(|k| height(place(k)))
        .fold(high, f64::min);
    let is_face = own.len() >= 3
        && high - lowest <= CORNER_TOLERANCE * slack
        && high - low >= CORNER_TOLERANCE * slack;
    is_face.then_some(Face {
        normal,
        offset: high as f32,
        first: range.start as u32,
        count: range.len() as u32,
        depth: (high - low) as f32,
    })
}

/// Returns the edges, and for each corner of a face the index of the edge to the next corner. Returns `None` if some edge does not have two
/// faces.
fn edges(faces: &[Face], corners: &[u16]) -> Option<(Box<[Edge]>, Box<[u16]>)> {
    let mut halves = Vec::with_capacity(corners.len());
    for (i, face) in faces.iter().enumerate() {
        let range = face.range();
        for k in range.clone() {
            let next = if k + 1 == range.end {
                range.start
            } else {
                k + 1
            };
            let (from, to) = (corners[k], corners[next]);
            // The two halves of an edge come one after the other, the first from the lesser end.
            halves.push((from.min(to), from.max(to), from > to, i as u16, k));
        }
    }
    sort::by_key(&mut halves, |&(from, to, back, face, k)| {
        let edge = u32::from(from) << 16 | u32::from(to);
        (u64::from(edge) << 1 | u64::from(back), face, k)
    });
    let mut sides = vec![0; corners.len()];
    let mut edges = Vec::with_capacity(halves.len() / 2);
    for pair in halves.chunks(2) {
        let &[one, two] = pair else { return None };
        if (one.0, one.1, one.2, two.2) != (two.0, two.1, false, true) {
            return None;
        }
        sides[one.4] = edges.len() as u16;
        sides[two.4] = edges.len() as u16;
        edges.push(Edge {
            ends: [one.0, one.1],
            faces: [one.3, two.3],
        });
    }
    Some((edges.into(), sides.into()))
}

/// Returns the faces around each point, one point after another, and the index at which those of each point begin.
fn around(faces: &[Face], corners: &[u16], points: usize) -> (Box<[u16]>, Box<[u32]>) {
    let mut pairs: Vec<(u16, u16)> = Vec::with_capacity(corners.len());
    for (i, face) in faces.iter().enumerate() {
        pairs.extend(corners[face.range()].iter().map(|&point| (point, i as u16)));
    }
    sort::values(&mut pairs);
    let begin = |point: usize| pairs.partition_point(|pair| usize::from(pair.0) < point) as u32;
    let first = (0..=points).map(begin).collect();
    (pairs.iter().map(|pair| pair.1).collect(), first)
}
