//! Parts of a compound that adjoin and touch another body in one plane: their contacts become one patch. A row of cubes on a floor is then
//! held up by the corners of the row, as one long box would be, and not by four points of every cube. Feet that stand apart keep a patch
//! each: a patch limits force and twist of friction apart, and a ring on feet that slides and spins would slide and spin for too long.

use crate::narrowphase::candidates::Candidate;
use crate::narrowphase::parry::{COPLANAR_DISTANCE, Face, PARALLEL_COSINE};
use glam::Vec3;
use smallvec::SmallVec;

/// Joins contacts in one plane that adjoin.
pub(in crate::narrowphase) fn join(faces: SmallVec<[Face; 4]>) -> SmallVec<[Face; 4]> {
    let mut joined = SmallVec::<[Face; 4]>::new();
    let mut planes = SmallVec::<[Option<ContactPlane>; 4]>::new();
    for face in faces {
        let known = joined.iter_mut().zip(&planes).find(|(known, plane)| {
            known.parts == face.parts
                && known.normal.dot(face.normal) > PARALLEL_COSINE
                && plane
                    .as_ref()
                    .is_some_and(|plane| plane.continues_in(&face))
                && adjoin(known, &face)
        });
        match known {
            Some((known, _)) => {
                known.candidates.extend(face.candidates);
                known.is_joined = true;
            }
            None if face.candidates.is_empty() => {}
            None => {
                planes.push(ContactPlane::of(&face));
                joined.push(face);
            }
        }
    }
    joined
}

/// Returns true if two contacts have a point in common.
fn adjoin(one: &Face, other: &Face) -> bool {
    let near = COPLANAR_DISTANCE * one.size;
    let is_near =
        |a: &Candidate, b: &Candidate| a.position.distance_squared(b.position) <= near * near;
    let points = &other.candidates;
    points
        .iter()
        .any(|b| one.candidates.iter().any(|a| is_near(a, b)))
}

/// The plane in which both bodies touch: height and distance of its points change evenly along it. If both are even over all points, then
/// those at the corners bear all that the others would.
struct ContactPlane {
    normal: Vec3,
    first: Candidate,
    /// From the first point to two others, or to one and aside, along the plane, m.
    edges: [Vec3; 2],
    /// How height and distance change along these edges, m.
    heights: [f32; 2],
    distances: [f32; 2],
    /// The points of a line only fix the plane along it.
    is_line: bool,
    /// m
    tolerance: f32,
}

impl ContactPlane {
    /// The plane of the points of a contact, or a line of it if they are on a line. `None` for a single point.
    fn of(face: &Face) -> Option<Self> {
        let points = &face.candidates;
        let (normal, first) = (face.normal, *points.first()?);
        let tolerance = COPLANAR_DISTANCE * face.size;
        let from_first = |point: &Candidate| point.position - first.position;
        let along = |point: &Candidate| from_first(point).reject_from_normalized(normal);
        let farthest = |way: &dyn Fn(&Candidate) -> f32| {
            points.iter().max_by(|a, b| way(a).total_cmp(&way(b)))
        };
        let second = farthest(&|point| along(point).length_squared())?;
        let edge = along(second);
        if edge.length() <= tolerance {
            return None;
        }
        let across = normal.cross(edge).normalize();
        let third = farthest(&|point| across.dot(along(point)).abs())?;
        let is_line = across.dot(along(third)).abs() <= tolerance;
        let change = |point: &Candidate| {
            (
                normal.dot(from_first(point)),
                point.distance - first.distance,
            )
        };
        let ((height_b, distance_b), (height_c, distance_c)) = match is_line {
            true => (change(second), (0.0, 0.0)),
            false => (change(second), change(third)),
        };
        Some(Self {
            normal,
            first,
            edges: [edge, if is_line { across } else { along(third) }],
            heights: [height_b, height_c],
            distances: [distance_b, distance_c],
            is_line,
            tolerance,
        })
    }

    fn continues_in(&self, face: &Face) -> bool {
        face.candidates.iter().all(|point| self.holds(point))
    }

    fn holds(&self, point: &Candidate) -> bool {
        let from_first = point.position - self.first.position;
        let [b, c] = self.edges;
        let area = self.normal.dot(b.cross(c));
        let s = self.normal.dot(from_first.cross(c)) / area;
        let t = self.normal.dot(b.cross(from_first)) / area;
        let even = |of: [f32; 2]| s * of[0] + t * of[1];
        let height = self.normal.dot(from_first) - even(self.heights);
        let distance = point.distance - self.first.distance - even(self.distances);
        // Beside a line `t` is a length.
        height.abs() <= self.tolerance
            && distance.abs() <= self.tolerance
            && !(self.is_line && t.abs() > self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::{FeatureId, PatchParts};

    fn face(points: &[(f32, f32, f32)]) -> Face {
        let point = |&(x, z, distance): &(f32, f32, f32)| Candidate {
            position: Vec3::new(x, 0.5 * distance, z),
            distance,
            feature: FeatureId::NONE,
        };
        Face {
            normal: Vec3::Y,
            size: 1.0,
            plane: None,
            candidates: points.iter().map(point).collect(),
            parts: PatchParts::default(),
            is_joined: false,
        }
    }

    fn joined(faces: &[&[(f32, f32, f32)]]) -> Vec<usize> {
        let joined = join(faces.iter().map(|points| face(points)).collect());
        joined.iter().map(|face| face.candidates.len()).collect()
    }

    #[test]
    fn contacts_that_adjoin_in_one_plane_are_joined_and_others_are_not() {
        let square = |x: f32, tilt: f32, up: f32| {
            [(x, 0.0), (x + 1.0, 0.0), (x, 1.0), (x + 1.0, 1.0)].map(|(x, z)| (x, z, tilt * x + up))
        };
        for tilt in [0.0, 0.01, -0.02] {
            let [first, second, third] = [0.0, 1.0, 2.0].map(|x| square(x, tilt, 0.0));
            assert_eq!(joined(&[&first, &second, &third]), [12]);
            // A foot that stands apart, and a part that is higher by a centimetre.
            assert_eq!(joined(&[&first, &third]), [4, 4]);
            assert_eq!(joined(&[&first, &square(1.0, tilt, 0.01), &second]), [8, 4]);
        }
        // The bottoms of a tilted and of a level part.
        assert_eq!(
            joined(&[&square(0.0, 0.0, 0.0), &square(1.0, 0.01, -0.01)]),
            [4, 4]
        );
    }

    #[test]
    fn edges_are_joined_along_their_line_and_points_stay_alone() {
        let edge = |x: f32, z: f32| [(x, z, 0.1 * x), (x + 1.0, z, 0.1 * x + 0.1)];
        assert_eq!(
            joined(&[&edge(0.0, 0.0), &edge(1.0, 0.0), &edge(2.0, 0.0)]),
            [6]
        );
        let aside = [(1.0, 0.0, 0.1), (1.0, 0.2, 0.1)];
        assert_eq!(joined(&[&edge(0.0, 0.0), &aside]), [2, 2]);
        assert_eq!(joined(&[&edge(0.0, 0.0), &edge(5.0, 0.0)]), [2, 2]);
        assert_eq!(joined(&[&[(0.0, 0.0, 0.0)], &[(0.0, 0.0, 0.0)]]), [1, 1]);
        assert_eq!(joined(&[&[], &[(1.0, 0.0, 0.0)]]), [1]);
    }
}
