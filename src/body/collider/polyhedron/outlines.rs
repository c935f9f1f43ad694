//! Merges the triangles of a hull into faces: triangles that lie in one plane up to rounding become one face with one outline.

use super::quickhull::Facet;
use crate::solver::sort;
use glam::{DVec3, I64Vec3};

const NONE: u32 = u32::MAX;

/// How many times a face is grown again, with the plane of its previous facets.
const TIMES_GROWN: usize = 2;

struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Fits a plane to facets. Normals are weighted by area, because thin facets have inaccurate normals and small areas.
    fn of(points: &[I64Vec3], facets: &[Facet], some: &[u32]) -> Self {
        let some = some.iter().map(|&i| &facets[i as usize]);
        let normal: DVec3 = some.clone().map(|f| f.normal.as_dvec3()).sum();
        let normal = normal.normalize_or_zero();
        let heights = some
            .flat_map(|f| f.corners)
            .map(|i| normal.dot(points[i as usize].as_dvec3()));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        Self {
            normal,
            offset: 0.5 * (low + high),
        }
    }

    fn contains(&self, points: &[I64Vec3], facet: &Facet, slack: f64) -> bool {
        let on = |i: u32| {
            let height = self.normal.dot(points[i as usize].as_dvec3()) - self.offset;
            height.abs() <= slack
        };
        facet.corners.into_iter().all(on)
    }
}

/// Computes the outline of each face, counterclockwise as seen from outside, with every vertex on it.
///
/// A face grows from its largest facet to all neighbours whose corners are in its plane. The test uses distances instead of angles, because
/// thin facets have arbitrary angles, and on a finely divided curved surface all angles are small.
pub(super) fn outlines(points: &[I64Vec3], facets: &[Facet], slack: f64) -> Vec<Vec<u32>> {
    let area = |i: &u32| facets[*i as usize].normal.as_dvec3().length_squared();
    let mut by_area: Vec<u32> = (0..facets.len() as u32).collect();
    sort::by_key(&mut by_area, |i| -area(i));
    let mut face_of = vec![NONE; facets.len()];
    let mut outlines = Vec::new();
    for seed in by_area {
        if face_of[seed as usize] != NONE {
            continue;
        }
        let face = outlines.len() as u32;
        let mut part = vec![seed];
        for _ in 0..=TIMES_GROWN {
            let plane = Plane::of(points, facets, &part);
            let before = part.len();
            part.drain(..).for_each(|i| face_of[i as usize] = NONE);
            part = grow(facets, seed, face, &mut face_of, |facet| {
                plane.contains(points, facet, slack)
            });
            if part.len() == 1 || part.len() == before {
                break;
            }
        }
        let outline = outline(facets, &part, &face_of).unwrap_or_else(|| {
            // The face has a hole, or meets itself in a point.
            part.iter().for_each(|&i| face_of[i as usize] = NONE);
            face_of[seed as usize] = face;
            facets[seed as usize].corners.into()
        });
        outlines.push(outline);
    }
    outlines
}

/// Collects the facets that can be reached from a facet through facets that belong to its face.
fn grow(
    facets: &[Facet],
    seed: u32,
    face: u32,
    face_of: &mut [u32],
    belongs: impl Fn(&Facet) -> bool,
) -> Vec<u32> {
    let mut part = vec![seed];
    face_of[seed as usize] = face;
    let mut done = 0;
    while let Some(&i) = part.get(done) {
        done += 1;
        for other in facets[i as usize].beside {
            if face_of[other as usize] == NONE && belongs(&facets[other as usize]) {
                face_of[other as usize] = face;
                part.push(other);
            }
        }
    }
    part
}

/// Returns the vertices around some facets, or `None` if they have more than one outline.
fn outline(facets: &[Facet], part: &[u32], face_of: &[u32]) -> Option<Vec<u32>> {
    let is_rim = |i: u32, side: usize| {
        let other = facets[i as usize].beside[side];
        face_of[other as usize] != face_of[i as usize]
    };
    let rim = part
        .iter()
        .flat_map(|&i| (0..3).map(move |side| (i, side)))
        .filter(|&(i, side)| is_rim(i, side));
    let length = rim.clone().count();
    let (start, mut side) = rim.clone().next()?;
    let mut facet = start;
    let mut outline = Vec::with_capacity(length);
    while outline.len() < length {
        outline.push(facets[facet as usize].corners[side]);
        // Turn around the end of this edge, to the next edge of the rim.
        side = (side + 1) % 3;
        while !is_rim(facet, side) {
            let corner = facets[facet as usize].corners[side];
            facet = facets[facet as usize].beside[side];
            let there = facets[facet as usize].corners;
            side = there.iter().position(|&c| c == corner)?;
        }
    }
    let mut distinct = outline.clone();
    distinct.sort_unstable();
    distinct.dedup();
    (distinct.len() == length).then_some(outline)
}

/// Returns the vertices that are corners. The others lie inside a face or between two faces, or on an outline that is straight or bent
/// inwards there. Two adjacent vertices are not removed in the same pass, because on a finely divided curve every vertex is almost
/// straight.
///
/// Vertices with fewer than three faces go first. If one of them lies a little beside an edge, the outline bends inwards at its neighbour,
/// which may be a corner far outside the hull of the others.
pub(super) fn corners(
    points: &[I64Vec3],
    facets: &[Facet],
    outlines: &[Vec<u32>],
    slack: f64,
) -> Vec<u32> {
    let mut faces = vec![0u32; points.len()];
    let mut straight = vec![false; points.len()];
    for outline in outlines {
        let place = |k: usize| points[outline[k % outline.len()] as usize].as_dvec3();
        let normal = newell(outline.len(), place);
        for (k, &i) in outline.iter().enumerate() {
            faces[i as usize] += 1;
            let [before, at, after] = [k + outline.len() - 1, k, k + 1].map(place);
            let inward = (at - before).cross(after - at).dot(normal) < 0.0;
            straight[i as usize] |= inward || is_between(at, before, after, slack);
        }
    }
    let mut kept = vec![false; points.len()];
    let mut beside = vec![Vec::new(); points.len()];
    for facet in facets {
        for k in 0..3 {
            beside[facet.corners[k] as usize].push(facet.corners[(k + 1) % 3]);
        }
    }
    let is_vertex = |i: &usize| !beside[*i].is_empty();
    let (flat, rest): (Vec<usize>, Vec<usize>) = (0..points.len())
        .filter(is_vertex)
        .partition(|&i| faces[i] < 3);
    let bent = rest.into_iter().filter(|&i| straight[i]);
    let mut left_out: Vec<bool> = beside.iter().map(Vec::is_empty).collect();
    for i in flat.into_iter().chain(bent) {
        if faces[i] == 0 {
            left_out[i] = true;
        } else if !kept[i] {
            left_out[i] = true;
            beside[i].iter().for_each(|&j| kept[j as usize] = true);
        }
    }
    (0..points.len() as u32)
        .filter(|&i| !left_out[i as usize])
        .collect()
}

/// Twice the area of a polygon, as a vector (the normal of M. E. Newell). It is also correct if three corners lie on one line.
pub(super) fn newell(count: usize, place: impl Fn(usize) -> DVec3) -> DVec3 {
    let first = place(0);
    (1..count)
        .map(|k| (place(k) - first).cross(place((k + 1) % count) - first))
        .sum()
}

fn is_between(at: DVec3, before: DVec3, after: DVec3, slack: f64) -> bool {
    let (way, here) = (after - before, at - before);
    let share = (here.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    (here - share * way).length() <= slack
}
