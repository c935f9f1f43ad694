//! The area of a bonded patch: its centroid and its principal axes.

use crate::solver::{Section, sort};
use glam::{DMat2, DVec2, Mat3, Quat, Vec2, Vec3};

/// A polygon in a plane of the world, in the axes in which a section is described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Patch {
    /// Centroid, world, m.
    pub center: Vec3,
    /// From the axes of the section to the world: x is the normal.
    pub axes: Quat,
    /// Corners along the section's y and z, m.
    pub corners: [Vec2; 4],
}

/// Area and second moments of a polygon.
struct Moments {
    area: f64,
    center: DVec2,
    /// ∫r rᵀ about the centroid.
    second: DMat2,
}

impl Moments {
    /// Of a polygon whose corners go round counterclockwise.
    fn of(corners: &[DVec2]) -> Self {
        let (mut area, mut first, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
        let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let twice = a.perp_dot(b);
            area += twice / 2.0;
            first += twice / 6.0 * (a + b);
            let sum = a + b;
            second += twice / 24.0 * (outer(a, a) + outer(b, b) + outer(sum, sum));
        }
        let center = first / area;
        Self {
            area,
            center,
            second: second - area * outer(center, center),
        }
    }
}

impl Patch {
    /// Its area, m².
    pub fn area(&self) -> f32 {
        section(self.corners).area
    }

    /// The patch between points (world, m) of a plane with this normal, by the four that enclose most of it; none if its area is not larger
    /// than `least`, m².
    pub fn new(points: &[Vec3], normal: Vec3, least: f32) -> Option<Self> {
        let (y, z) = normal.any_orthonormal_pair();
        let y = if y.cross(z).dot(normal) < 0.0 { -y } else { y };
        let start = *points.first()?;
        let flat = |point: &Vec3| {
            let offset = point - start;
            DVec2::new(offset.dot(y).into(), offset.dot(z).into())
        };
        let mut flat: Vec<DVec2> = points.iter().map(flat).collect();
        let mean = flat.iter().sum::<DVec2>() / flat.len() as f64;
        sort::by_key(&mut flat, |point| (point - mean).to_angle());
        leave_four(&mut flat);
        let moments = Moments::of(&flat);
        // A comparison with NaN is false.
        if !(flat.len() >= 3 && moments.area > f64::from(least)) {
            return None;
        }
        let turn = principal(moments.second);
        let [cos, sin] = DVec2::from_angle(turn).as_vec2().to_array();
        let axes = [normal, cos * y + sin * z, cos * z - sin * y];
        let back = DVec2::from_angle(-turn);
        let corner = |i: usize| {
            back.rotate(flat[i.min(flat.len() - 1)] - moments.center)
                .as_vec2()
        };
        let center = moments.center.as_vec2();
        Some(Self {
            center: start + center.x * y + center.y * z,
            axes: Quat::from_mat3(&Mat3::from_cols(axes[0], axes[1], axes[2])).normalize(),
            corners: [0, 1, 2, 3].map(corner),
        })
    }
}

/// Removes the corners of a polygon that contribute the least area, until at most four are left, and all of them are convex.
fn leave_four(corners: &mut Vec<DVec2>) {
    while corners.len() > 3 {
        let count = corners.len();
        let area = |i: usize| {
            let [before, at, after] = [count - 1, 0, 1].map(|step| corners[(i + step) % count]);
            (at - before).perp_dot(after - at)
        };
        let areas = (0..count).map(|i| (area(i), i));
        let least = areas.min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((area, i)) if count > 4 || area <= 0.0 => corners.remove(i),
            _ => break,
        };
    }
}

/// The angle of a principal axis; zero if all axes are alike.
fn principal(second: DMat2) -> f64 {
    let [xx, xy, yy] = [second.x_axis.x, second.x_axis.y, second.y_axis.y];
    match xy.abs() > 1e-6 * (xx + yy) {
        true => 0.5 * DVec2::new(xx - yy, 2.0 * xy).to_angle(),
        false => 0.0,
    }
}

/// The section of a patch with these corners, without strength.
pub(super) fn section(corners: [Vec2; 4]) -> Section {
    let moments = Moments::of(&corners.map(Vec2::as_dvec2));
    Section {
        area: moments.area as f32,
        inertia: DVec2::new(moments.second.x_axis.x, moments.second.y_axis.y).as_vec2(),
        corners,
        tension: 0.0,
        cohesion: 0.0,
        friction: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle of 0.4 m by 0.2 m, anywhere, its corners in any order.
    #[test]
    fn a_rectangle_has_its_moments_about_its_sides() {
        let mut rng = fastrand::Rng::with_seed(5);
        for _ in 0..100 {
            let mut number = || rng.f32() - 0.5;
            let turn = Quat::from_xyzw(number(), number(), number(), number()).normalize();
            let at = Vec3::new(number(), number(), number());
            let mut corners = [[-0.2, -0.1], [0.2, 0.1], [-0.2, 0.1], [0.2, -0.1]]
                .map(|[y, z]| at + turn * Vec3::new(0.0, y, z));
            corners.reverse();
            let patch = Patch::new(&corners, turn * Vec3::X, 0.0).unwrap();
            let found = section(patch.corners);
            assert!(patch.center.distance(at) < 1e-6);
            assert!((patch.axes * Vec3::X).distance(turn * Vec3::X) < 1e-5);
            assert!((found.area - 0.08).abs() < 1e-6);
            let (long, wide) = (0.2 * 0.064 / 12.0, 0.4 * 0.008 / 12.0);
            assert!(
                (found.inertia.max_element() - long).abs() < 1e-7,
                "{found:?}"
            );
            assert!((found.inertia.min_element() - wide).abs() < 1e-7);
            for corner in patch.corners {
                let world = patch.center + patch.axes * Vec3::new(0.0, corner.x, corner.y);
                assert!(corners.iter().any(|c| c.distance(world) < 1e-5));
            }
        }
    }

    #[test]
    fn of_many_points_the_four_that_enclose_most_are_left() {
        let points = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.4, 0.5],
            [0.0, 1.0],
            [0.5, 1.01],
        ];
        let points = points.map(|[x, z]| Vec3::new(x, 0.0, z));
        let patch = Patch::new(&points, Vec3::Y, 0.0).unwrap();
        assert!((section(patch.corners).area - 1.0).abs() < 1e-6);
        // The third of four is inside of the triangle of the others.
        let patch = Patch::new(&[points[0], points[1], points[3], points[4]], Vec3::Y, 0.0);
        assert!((section(patch.unwrap().corners).area - 0.5).abs() < 1e-6);
    }

    #[test]
    fn three_points_make_a_patch_and_two_do_not() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Z];
        let patch = Patch::new(&corners, Vec3::Y, 0.0).unwrap();
        assert!((section(patch.corners).area - 0.5).abs() < 1e-6);
        assert_eq!(Patch::new(&corners[..2], Vec3::Y, 0.0), None);
        assert_eq!(
            Patch::new(&[Vec3::ZERO, Vec3::X, 2.0 * Vec3::X], Vec3::Y, 0.0),
            None
        );
    }
}
