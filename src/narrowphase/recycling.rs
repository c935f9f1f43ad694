//! Recycling: a manifold is kept while its two bodies have hardly moved relative to each other since it was detected.
//!
//! Normal and lever arms stay fixed in the world; only distances are updated. This saves most of collision detection at rest, and it makes
//! stacks steadier: lever arms that are computed anew in every step pump energy into tall stacks. Box2D, Box3D and Rapier recycle contacts
//! for the same reasons.
//!
//! Arms of bodies that rock are carried along with them: a block that rocks would lose much of its energy by arms that lag behind.
//!
//! Bodies on a turntable, in a drum or in a toppling tower turn together. Their manifold is turned with them, with the larger of the two.
//!
//! For bodies that are apart only their distance is kept. Until they have approached each other by that distance, they need not be checked.
//! In a falling heap this applies to nine pairs of ten.

use super::candidates::without_rounding;
use crate::body::BodyState;
use crate::pair::{CachedRelativePose, Manifold, NarrowphaseCache, ParryManifold};
use crate::solver::Both;
use glam::{Quat, Vec3};

impl CachedRelativePose {
    /// Stores the current relative pose. The manifold must not be recycled yet.
    pub(crate) fn take(&mut self, a: &BodyState, b: &BodyState) {
        self.between = a.center - b.center;
        self.rotations = [a, b].both(|body| body.pose.rotation.to_array());
        self.forget();
    }

    /// Marks the manifold as not recyclable.
    pub(crate) fn forget(&mut self) {
        (self.reach, self.apart) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    }

    /// Returns true if the manifold may be recycled.
    pub(crate) fn is_known(&self) -> bool {
        self.reach > f32::NEG_INFINITY
    }

    /// The rotation of each body since the detection.
    #[inline]
    pub(crate) fn turns(&self, bodies: [&BodyState; 2]) -> [Quat; 2] {
        std::array::from_fn(|i| {
            let was = Quat::from_array(self.rotations[i]);
            bodies[i].pose.rotation * was.inverse()
        })
    }

    /// The relative motion of the bodies since the detection.
    #[inline]
    pub(crate) fn since(&self, a: &BodyState, b: &BodyState) -> Since {
        let turn = |body: &BodyState, was: [f32; 4]| {
            let (now, was) = (body.pose.rotation, Quat::from_array(was));
            // The radius of a half-space is infinite, so it must not be multiplied by a rotation of zero.
            if now == was {
                return (Turn::default(), 0.0);
            }
            let turn = now * was.inverse();
            let turn = Turn {
                axis: turn.xyz(),
                w: turn.w,
            };
            (turn, 2.0 * turn.axis.length() * body.radius)
        };
        let shift = a.center - b.center - self.between;
        let (turn_a, way_a) = turn(a, self.rotations[0]);
        let (turn_b, way_b) = turn(b, self.rotations[1]);
        Since {
            shift,
            turns: [turn_a, turn_b],
            way: shift.length() + way_a + way_b,
        }
    }

    /// Returns true if the bodies moved by at most `limit` (m), and everything within `reach` now was within the reach of the search.
    /// `moved` is the distance that they moved, m.
    #[inline]
    pub(crate) fn holds(&self, moved: f32, limit: f32, reach: f32) -> bool {
        moved <= limit && reach + moved <= self.reach
    }

    /// The detection as if it had been made in axes that have turned with the larger body since, and how far these have turned. Bodies that
    /// turn together have hardly moved relative to each other since then.
    fn turned(&self, a: &BodyState, b: &BodyState) -> (Self, Quat) {
        let larger = usize::from(a.radius < b.radius);
        let turn = self.turns([a, b])[larger].normalize();
        let mut turned = *self;
        turned.between = turn * self.between;
        turned.rotations = self
            .rotations
            .both(|was| (turn * Quat::from_array(was)).normalize().to_array());
        // Rounding would leave a rotation of the larger body, whose radius may be infinite.
        turned.rotations[larger] = [a, b][larger].pose.rotation.to_array();
        (turned, turn)
    }

    /// Turns a manifold with its bodies if they have moved by more than `limit` (m), but hardly relative to each other, so that it may be
    /// recycled within `reach` (m). Returns their motion relative to each other then.
    pub(crate) fn turn(
        &mut self,
        [a, b]: [&BodyState; 2],
        (reach, limit): (f32, f32),
        manifold: &mut Manifold,
    ) -> Option<Since> {
        if !self.is_known() {
            return None;
        }
        let (turned, turn) = self.turned(a, b);
        let since = turned.since(a, b);
        turned.holds(since.way, limit, reach).then(|| {
            *self = turned;
            manifold.turn(turn);
            since
        })
    }

    /// Carries a manifold along with its bodies, as if it had been detected where they are now. `since` is their motion since
    /// the detection, which counts against how far the manifold may be kept.
    pub(crate) fn carry(
        &mut self,
        [a, b]: [&BodyState; 2],
        since: &Since,
        manifold: &mut Manifold,
    ) {
        since.refresh(manifold);
        let between = a.center - b.center;
        let was = manifold.between;
        // A point goes with both bodies. Where they slide on each other, it is midway.
        let carried = |arm: Vec3| {
            let [on_a, on_b] = [arm, arm + was];
            let [turn_a, turn_b] = &since.turns;
            let of_a = on_a + turn_a.on(on_a);
            let of_b = on_b + turn_b.on(on_b) - between;
            0.5 * (of_a + of_b)
        };
        for point in &mut manifold.points {
            point.arm = carried(point.arm);
            point.detected = point.distance;
        }
        manifold.center_on_load();
        manifold.between = between;
        let [reach, apart] = [self.reach, self.apart].both(|distance| distance - since.way);
        self.take(a, b);
        (self.reach, self.apart) = (reach, apart);
    }

    /// Returns true if the two are known to be farther apart than `reach`, m. This is so if their bounding spheres are, or if their
    /// distance at the last detection was greater than `reach` and the motion `since` then.
    pub(crate) fn is_apart(
        &self,
        a: &BodyState,
        b: &BodyState,
        reach: f32,
        since: impl FnOnce() -> Since,
    ) -> bool {
        let near = |since: &Since| reach + since.way >= self.apart;
        a.spheres_are_apart(b, reach)
            || self.apart > reach && (!near(&since()) || !near(&self.turned(a, b).0.since(a, b)))
    }
}

/// The relative motion of two bodies since their manifold was detected.
#[derive(Clone, Copy)]
pub(crate) struct Since {
    /// The motion of A's centre of mass relative to B's, m.
    shift: Vec3,
    turns: [Turn; 2],
    /// Upper bound of the relative motion of two points of the surfaces, m.
    way: f32,
}

/// A rotation as a quaternion. It gives the change of a vector, which stays accurate for small rotations.
#[derive(Clone, Copy, Default)]
struct Turn {
    axis: Vec3,
    w: f32,
}

impl Turn {
    /// The change of a vector by the rotation.
    #[inline]
    fn on(&self, vector: Vec3) -> Vec3 {
        let across = self.axis.cross(vector);
        2.0 * (self.axis.cross(across) + self.w * across)
    }

    /// The change of a vector by the inverse rotation.
    #[inline]
    fn back(&self, vector: Vec3) -> Vec3 {
        let inverse = Self {
            w: -self.w,
            ..*self
        };
        inverse.on(vector)
    }
}

/// A point counts less for the centre of a patch that carries load the more the surfaces open towards it, from the deepest point on; not at
/// all from this slope on, rad.
const OPEN_SLOPE: f32 = 0.01;

impl Manifold {
    /// Moves the centre of each patch to the mean of the points that touch, at the height of the deepest one. A body that rocks on an edge
    /// is held by friction there, and turns about it.
    pub(crate) fn center_on_load(&mut self) {
        for patch in &mut self.patches {
            let points = &self.points[patch.range_in(self.points.len())];
            let deepest = points
                .iter()
                .min_by(|a, b| a.distance.total_cmp(&b.distance));
            let Some(deepest) = deepest else { continue };
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for point in points {
                let aside = point.arm - deepest.arm;
                let opens = OPEN_SLOPE * aside.length();
                let weight = match opens > 0.0 {
                    true => (1.0 - (point.distance - deepest.distance) / opens).max(0.0),
                    false => 1.0,
                };
                sum += weight * aside;
                weights += weight;
            }
            let aside = sum / weights;
            patch.center = deepest.arm + aside - patch.normal * patch.normal.dot(aside);
        }
    }

    /// Turns the manifold in the world.
    fn turn(&mut self, by: Quat) {
        self.between = by * self.between;
        for patch in &mut self.patches {
            patch.normal = without_rounding((by * patch.normal).normalize());
            patch.center = by * patch.center;
            patch.ahead = by * patch.ahead;
        }
        for point in &mut self.points {
            point.arm = by * point.arm;
        }
    }
}

impl Since {
    /// The larger of the angles by which the bodies have turned, rad.
    #[inline]
    pub(crate) fn turned(&self) -> f32 {
        let [a, b] = self
            .turns
            .each_ref()
            .both(|turn| turn.axis.length_squared());
        2.0 * a.max(b).sqrt()
    }

    /// Bound on how far two points of the surfaces have moved against each other, m.
    pub(crate) fn way(&self) -> f32 {
        self.way
    }

    /// Brings the distances of a kept manifold up to date.
    ///
    /// A point has gone with A and with B, by R_A a and R_B b with its arms a and b; along the normal they are apart by n·(R_A a − R_B b),
    /// and a turned by R_A sees as much of n as a of n turned back.
    #[inline]
    pub(crate) fn refresh(&self, manifold: &mut Manifold) {
        for patch in &manifold.patches {
            let [a, b] = self.turns.each_ref().both(|turn| turn.back(patch.normal));
            let (apart, tilted) = (
                patch.normal.dot(self.shift) - b.dot(manifold.between),
                a - b,
            );
            let range = patch.range_in(manifold.points.len());
            for point in &mut manifold.points[range] {
                point.distance = point.detected + (apart + tilted.dot(point.arm));
            }
        }
    }

    /// The points that the two touched in, still within `limit` of each other, where parry has found none although nothing has moved
    /// by more than that: its search may fail where surfaces just touch.
    pub(crate) fn lost(
        &self,
        old: &Manifold,
        cache: &NarrowphaseCache,
        limit: f32,
    ) -> Option<Manifold> {
        let found = |m: &ParryManifold| !m.points.is_empty();
        let manifolds = &cache.parry.as_ref()?.manifolds;
        if manifolds.is_empty() || manifolds.iter().any(found) || self.way > limit {
            return None;
        }
        let mut old = old.clone();
        self.refresh(&mut old);
        let touches = old.points.iter().any(|point| point.distance <= limit);
        touches.then_some(old)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Pose, Velocity};
    use crate::pair::{ContactPoint, FeatureId, ManifoldPatch, PatchParts};
    use bevy_ecs::entity::Entity;

    const LIMIT: f32 = 0.01;
    const REACH: f32 = 0.1;

    /// A large body in the origin, and a smaller one above it.
    fn two() -> [BodyState; 2] {
        [(Vec3::ZERO, 3.0), (2.0 * Vec3::Y, 0.5)].both(|(position, radius)| {
            let rotation = Quat::from_rotation_y(radius);
            let pose = Pose { position, rotation };
            let mut body = BodyState::new(Entity::PLACEHOLDER, pose, Velocity::default());
            body.radius = radius;
            body
        })
    }

    fn touching([a, b]: [&BodyState; 2]) -> (CachedRelativePose, Manifold) {
        let point = ContactPoint {
            arm: Vec3::new(0.3, 1.6, 0.2),
            distance: -0.02,
            detected: -0.02,
            feature: FeatureId::NONE,
        };
        let patch = ManifoldPatch {
            normal: Vec3::NEG_Y,
            center: point.arm,
            first: 0,
            count: 1,
            curved: false,
            parts: PatchParts::default(),
            ahead: Vec3::ZERO,
        };
        let mut last = CachedRelativePose::default();
        last.take(a, b);
        last.reach = REACH + 2.0 * LIMIT;
        let manifold = Manifold {
            patches: smallvec::smallvec![patch],
            points: smallvec::smallvec![point],
            between: a.center - b.center,
        };
        (last, manifold)
    }

    /// Turns a body about a point of the world, and moves it.
    fn carry(body: &mut BodyState, about: Vec3, by: Quat, way: Vec3) {
        body.center = about + by * (body.center - about) + way;
        body.pose.position = body.center;
        body.pose.rotation = by * body.pose.rotation;
    }

    #[test]
    fn a_manifold_turns_with_bodies_that_turn_together() {
        let [mut a, mut b] = two();
        let (mut last, mut manifold) = touching([&a, &b]);
        let about = Vec3::new(0.5, -1.0, 0.3);
        let mut turned = Quat::IDENTITY;
        for step in 1..=20 {
            let by = Quat::from_scaled_axis(Vec3::new(0.1, 0.05, 0.2));
            turned = by * turned;
            carry(&mut a, about, by, Vec3::ZERO);
            // Seen from A, B rises by 8 mm in all.
            carry(&mut b, about, by, turned * (4e-4 * Vec3::Y));
            let way = last.since(&a, &b).way();
            assert!(!last.holds(way, LIMIT, REACH), "they have moved by {way} m");
            let since = last.turn([&a, &b], (REACH, LIMIT), &mut manifold);
            since
                .expect("they hardly move relative to each other")
                .refresh(&mut manifold);
            let (patch, point) = (&manifold.patches[0], &manifold.points[0]);
            let off = (patch.normal - turned * Vec3::NEG_Y).length();
            let [arm_a, arm_b] = manifold.arms(0).both(|arm| turned.inverse() * arm);
            assert!(off < 1e-5 && patch.normal.is_normalized());
            assert!(
                (arm_a - Vec3::new(0.3, 1.6, 0.2)).length() < 1e-5,
                "{arm_a}"
            );
            assert!(
                (arm_b - Vec3::new(0.3, -0.4, 0.2)).length() < 1e-5,
                "{arm_b}"
            );
            let expected = -0.02 + 4e-4 * step as f32;
            assert!(
                (point.distance - expected).abs() < 1e-5,
                "{}",
                point.distance
            );
        }
        carry(&mut b, Vec3::ZERO, Quat::IDENTITY, 3e-3 * Vec3::X);
        let since = last.turn([&a, &b], (REACH, LIMIT), &mut manifold);
        assert!(since.is_none(), "they slide on each other");
    }

    #[test]
    fn bodies_that_turn_together_stay_apart() {
        let [mut a, mut b] = two();
        let (mut last, _) = touching([&a, &b]);
        last.apart = 0.2;
        let by = Quat::from_rotation_z(1.0);
        carry(&mut a, Vec3::ZERO, by, Vec3::ZERO);
        carry(&mut b, Vec3::ZERO, by, 0.05 * Vec3::X);
        let is_apart = |last: &CachedRelativePose, b: &BodyState| {
            last.is_apart(&a, b, REACH, || last.since(&a, b))
        };
        assert!(is_apart(&last, &b));
        carry(&mut b, Vec3::ZERO, Quat::IDENTITY, 0.06 * Vec3::X);
        assert!(!is_apart(&last, &b));
    }
}
