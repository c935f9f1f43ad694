//! Loads patches into a block as a step begins, and stores them as it ends. Data is copied lane by lane, and computed in all lanes at once.

use super::block::{Block, Points};
use super::locks::Locks;
use crate::lanes::{F32xN, Frame, Vec3xN};
use crate::{PatchConstraint, PatchProblem, ROCKING_SPEED, Slip};
use glam::Mat3;

/// Rate at which the mean load of friction follows, relative to that of normals. At 1, walls go on drifting.
const FRICTION: f32 = 0.3;

/// Rate at which the loads of single points follow, relative to that of their mean. At 1, a body rocks on its points.
const DIFFERENCE_SHARE: f32 = 0.03;

/// The state of patches at the beginning of a step, by lane.
#[derive(Default)]
struct Beginning<L> {
    /// 1 where friction is anchored.
    anchored: L,
    slip: Vec3xN<L>,
    slip_twist: L,
    tangential: Vec3xN<L>,
    twist: L,
    rolling: Vec3xN<L>,
    load: Vec3xN<L>,
    rest_twist_impulse: L,
}

/// The state of patches at the end of a step, by lane.
struct Found<L> {
    given: Vec3xN<L>,
    tangential: Vec3xN<L>,
    twist: L,
    rolling: Vec3xN<L>,
    dragged: Vec3xN<L>,
    dragged_twist: L,
}

impl<L: F32xN> Block<L> {
    /// Loads the data of a patch that stay the same until it is detected anew. `stiffness` is the share of a spring's stiffness that is
    /// left when its bodies share it.
    pub fn load(
        &mut self,
        points: &mut [Points<L>],
        lane: usize,
        patch: &PatchConstraint,
        problem: &PatchProblem,
        stiffness: f32,
    ) {
        // One assertion replaces a bounds check at each of a hundred numbers.
        assert!(lane < L::LANES);
        self.stiffness[lane] = stiffness;
        self.normal.set(lane, patch.normal);
        for side in 0..2 {
            let body = &problem.bodies[patch.bodies[side] as usize];
            L::set_body(&mut self.bodies[side], lane, patch.bodies[side]);
            self.arms[side].set(lane, patch.arms[side]);
            self.inverse_mass[side][lane] = body.inverse_mass;
            // After its inverse mass.
            if (body.is_locked() || body.is_upright()) && self.locks.is_none() {
                self.locks = Some(Box::new(Locks::free(&self.inverse_mass)));
            }
            if let Some(locks) = &mut self.locks {
                locks.load(lane, side, body);
            }
            self.turn(lane, side, &body.inverse_inertia);
        }
        self.friction[lane] = patch.friction;
        let (t1, t2) = patch.normal.any_orthonormal_pair();
        self.tangent.set(lane, t1);
        let rolls = patch.rolling_friction > 0.0;
        let radius = if rolls { patch.rolling_radius } else { 0.0 };
        self.rolls |= rolls;
        self.rolling_radius[lane] = radius;
        self.rolling_lever[lane] = patch.rolling_friction * radius;
        let mine = &problem.points[patch.range()];
        self.share[lane] = 1.0 / mine.len() as f32;
        for (to, point) in points.iter_mut().zip(mine) {
            to.x[lane] = t1.dot(point.offset);
            to.y[lane] = t2.dot(point.offset);
            // Marks the lane as used, until `prepare` puts the mass here.
            to.mass[lane] = 1.0;
        }
    }

    /// Loads the inverse inertia of a body that has turned, 1/(kg·m²).
    pub fn turn(&mut self, lane: usize, side: usize, inverse_inertia: &Mat3) {
        assert!(lane < L::LANES);
        self.inverse_inertia[side].set(lane, inverse_inertia);
    }

    /// Sets a lane's fastest correction, m/s.
    pub fn set_max_speed(&mut self, lane: usize, max_speed: f32) {
        self.max_speed[lane] = max_speed;
    }

    /// Loads distances, slips, and impulses, which are divided by the number of substeps, and resets the sums over the step. No point is
    /// deeper than the separation `deepest`, m.
    #[inline(always)]
    pub fn begin(
        &mut self,
        points: &mut [Points<L>],
        patches: impl Iterator<Item = (usize, u32)> + Clone,
        problem: &PatchProblem,
        substeps: usize,
        deepest: f32,
    ) {
        self.begin_surfaces(patches.clone(), problem);
        let mut found = Beginning::default();
        for (lane, number) in patches {
            let patch = &problem.patches[number as usize];
            found.read(points, lane, patch, problem);
        }
        let share = L::splat(1.0 / substeps as f32);
        let Frame { t1, t2, .. } = self.frame();
        self.anchored = found.anchored;
        self.slip = [t1.dot(found.slip), t2.dot(found.slip)];
        self.slip_twist = found.slip_twist;
        let held = share * found.anchored;
        self.held = [held * t1.dot(found.load), held * t2.dot(found.load)];
        self.held_twist = held * found.rest_twist_impulse;
        let tangential = found.tangential;
        self.tangential = [share * t1.dot(tangential), share * t2.dot(tangential)];
        self.twist = share * found.twist;
        if self.rolls {
            self.rolling = [share * t1.dot(found.rolling), share * t2.dot(found.rolling)];
        }
        let mut load = L::ZERO;
        let deepest = L::splat(deepest);
        for point in points {
            point.separation = point.separation.max(deepest);
            point.rest_impulse = share * point.rest_impulse;
            point.impulse = share * point.impulse;
            point.given = L::ZERO;
            load += point.rest_impulse;
        }
        self.inverse_load = (self.share * load).inverse();
        (self.given, self.dragged) = ([L::ZERO; 2], [L::ZERO; 2]);
        self.dragged_twist = L::ZERO;
    }

    /// Sets a state of rest: all points touch that are no farther apart than `closed` m, and the others are unused.
    #[inline(always)]
    pub fn rest(&mut self, points: &mut [Points<L>], closed: f32) {
        let closed = L::splat(closed);
        for point in points {
            point.mass = point.separation.select_above(closed, L::ZERO, point.mass);
            point.impulse = point
                .separation
                .select_above(closed, L::ZERO, point.impulse);
            (point.separation, point.gap) = (L::ZERO, L::ZERO);
        }
    }

    /// Stores the impulses, times the number of substeps. The last substep counts once more for each one that was skipped. Loads at rest
    /// follow the impulses by the share `rate`.
    #[inline(always)]
    pub fn end(
        &self,
        points: &[Points<L>],
        patches: impl Iterator<Item = (usize, u32)> + Clone,
        problem: &mut PatchProblem,
        (substeps, skipped): (usize, usize),
        rate: f32,
    ) {
        let whole = L::splat(substeps as f32);
        let last = L::splat((1 + skipped) as f32);
        let found = self.found(whole, last);
        for (lane, number) in patches.clone() {
            found.write(lane, &mut problem.patches[number as usize], FRICTION * rate);
        }
        let handed = Handed::between(points, L::splat(OPEN_SLOPE) * self.radius, || {
            rocking(patches.clone(), problem)
        });
        let (mut held, mut mean) = (L::ZERO, L::ZERO);
        for point in points {
            held += handed.rest_of(point);
            mean += point.impulse;
        }
        let to_whole = self.share * whole;
        let (held, mean) = (to_whole * held, to_whole * mean);
        let (rate, aside) = (L::splat(rate), L::splat(DIFFERENCE_SHARE));
        for (number, point) in points.iter().enumerate() {
            let normal = last.mul_add(point.impulse, point.given);
            let (warm, load) = (whole * point.impulse, whole * handed.rest_of(point));
            let off = aside * ((warm - mean) - (load - held));
            let load = rate.mul_add((mean - held) + off, load).max(L::ZERO);
            for (lane, patch) in patches.clone() {
                let patch = &problem.patches[patch as usize];
                if number < patch.count as usize {
                    let to = &mut problem.points[patch.first as usize + number];
                    to.normal = normal[lane];
                    to.normal_impulse = warm[lane];
                    to.rest_impulse = load[lane];
                }
            }
        }
    }

    #[inline(always)]
    fn found(&self, whole: L, last: L) -> Found<L> {
        let Frame { t1, t2, .. } = self.frame();
        let carried = [whole * self.tangential[0], whole * self.tangential[1]];
        Found {
            given: along(
                t1,
                t2,
                [
                    last.mul_add(self.tangential[0], self.given[0]),
                    last.mul_add(self.tangential[1], self.given[1]),
                ],
            ),
            tangential: along(t1, t2, carried),
            twist: whole * self.twist,
            rolling: along(t1, t2, [whole * self.rolling[0], whole * self.rolling[1]]),
            dragged: along(t1, t2, self.dragged),
            dragged_twist: self.dragged_twist,
        }
    }
}

/// A point has opened if it is farther apart than this times the mean distance of points from the centre of its patch. Points of walls that
/// settle open by less.
const OPEN_SLOPE: f32 = 2e-3;

/// The loads at rest of the points of a patch. If a body rocks, points that have opened hand theirs over to those that carry it: otherwise
/// the new edge would sag under a load that its springs do not know yet. In piles, points open and close slowly, and loads that followed
/// would keep them from resting.
struct Handed<L> {
    /// Points that are farther apart have opened, m.
    gap: L,
    /// The load at rest that each point takes over, as a share of its impulse.
    share: L,
    /// 1 if there are points that can take it over.
    is_any: L,
}

impl<L: F32xN> Handed<L> {
    /// `rocking` returns 1 in lanes in which a body rocks, else 0. It is asked if some point with a load has opened.
    #[inline(always)]
    fn between(points: &[Points<L>], gap: L, rocking: impl FnOnce() -> L) -> Self {
        let is_open = |point: &Points<L>, one: L| point.gap.select_above(gap, one, L::ZERO);
        let mut opened = L::ZERO;
        for point in points {
            opened += is_open(point, point.rest_impulse);
        }
        let (mut share, mut is_any) = (L::ZERO, L::ZERO);
        if opened.any_above(L::ZERO) {
            let rocks = rocking();
            let (mut lost, mut carried) = (L::ZERO, L::ZERO);
            for point in points {
                let open = is_open(point, rocks);
                lost = open.mul_add(point.rest_impulse, lost);
                carried = (L::ONE - open).mul_add(point.impulse, carried);
            }
            is_any = carried.select_above(L::ZERO, rocks, L::ZERO);
            share = is_any * lost * carried.inverse();
        }
        Self { gap, share, is_any }
    }

    #[inline(always)]
    fn rest_of(&self, point: &Points<L>) -> L {
        let taken = self.share.mul_add(point.impulse, point.rest_impulse);
        let left = self
            .is_any
            .select_above(L::ZERO, L::ZERO, point.rest_impulse);
        point.gap.select_above(self.gap, left, taken)
    }
}

/// 1 in the lanes of patches of which a body rocks, else 0.
fn rocking<L: F32xN>(patches: impl Iterator<Item = (usize, u32)>, problem: &PatchProblem) -> L {
    let mut rocking = L::ZERO;
    for (lane, number) in patches {
        let bodies = problem.patches[number as usize].bodies;
        let rocks = |body: u32| {
            let [_, spin] = problem.bodies[body as usize].start;
            spin.length_squared() > ROCKING_SPEED * ROCKING_SPEED
        };
        if bodies.into_iter().any(rocks) {
            rocking[lane] = 1.0;
        }
    }
    rocking
}

/// The vector with components x and y along the two tangents.
#[inline(always)]
fn along<L: F32xN>(t1: Vec3xN<L>, t2: Vec3xN<L>, [x, y]: [L; 2]) -> Vec3xN<L> {
    t2.scale_add(y, t1.scale(x))
}

impl<L: F32xN> Beginning<L> {
    /// Loads one patch into its lane, and its points into theirs.
    #[inline(always)]
    fn read(
        &mut self,
        points: &mut [Points<L>],
        lane: usize,
        patch: &PatchConstraint,
        problem: &PatchProblem,
    ) {
        // One assertion replaces a bounds check at each of a hundred numbers.
        assert!(lane < L::LANES);
        if let Some(slip) = patch.slip {
            self.anchored[lane] = 1.0;
            self.slip.set(lane, slip.shift);
            self.slip_twist[lane] = slip.twist;
        }
        self.tangential.set(lane, patch.friction_impulse);
        self.twist[lane] = patch.twist_impulse;
        if patch.rolling_friction > 0.0 {
            self.rolling.set(lane, patch.rolling_impulse);
        }
        self.load.set(lane, patch.rest_friction_impulse);
        self.rest_twist_impulse[lane] = patch.rest_twist_impulse;
        for (to, point) in points.iter_mut().zip(&problem.points[patch.range()]) {
            to.rest_impulse[lane] = point.rest_impulse;
            to.separation[lane] = point.separation;
            to.impulse[lane] = point.normal_impulse;
        }
    }
}

impl<L: F32xN> Found<L> {
    /// Stores one patch from its lane. Its loads at rest follow by the share `rate`; they start from the values in the patch, since a lane
    /// holds none for friction that is not anchored yet.
    #[inline(always)]
    fn write(&self, lane: usize, patch: &mut PatchConstraint, rate: f32) {
        assert!(lane < L::LANES);
        patch.tangential = self.given.get(lane);
        patch.friction_impulse = self.tangential.get(lane);
        patch.twist_impulse = self.twist[lane];
        patch.rolling_impulse = self.rolling.get(lane);
        patch.rest_friction_impulse +=
            rate * (patch.friction_impulse - patch.rest_friction_impulse);
        patch.rest_twist_impulse += rate * (patch.twist_impulse - patch.rest_twist_impulse);
        patch.dragged = Slip {
            shift: self.dragged.get(lane),
            twist: self.dragged_twist[lane],
        };
    }
}
