//! A problem of patches: from manifolds, slips and last step's impulses, and back.

use super::island::Rows;
use super::touch::{Touch, to_start_from};
use super::{Given, LARGE};
use crate::contact::{ContactPoint, Impulse, ManifoldPatch, PatchImpulse};
use crate::solver::{
    Body, FEW, Grip, Memory, PatchConstraint, PatchPoint, PatchProblem, PatchSolver, Slip,
    SolveReport, patches,
};
use glam::Vec3;
use std::ops::Range;

#[derive(Default)]
pub(super) struct PatchRows {
    patches: Vec<PatchConstraint>,
    points: Vec<PatchPoint>,
    /// By touch: the first of its patches.
    firsts: Vec<u32>,
    /// Length of the step in which they were solved, s.
    dt: f32,
    memory: Memory,
}

impl Rows for PatchRows {
    type Solver = dyn PatchSolver;
    const SUBSTEPS: bool = true;

    fn clear(&mut self) {
        self.patches.clear();
        self.points.clear();
        self.firsts.clear();
        self.memory.forget();
    }

    fn points(&self) -> usize {
        self.points.len()
    }

    fn gather(&mut self, touches: &[Touch], ends: &[[u32; 2]], _: &[Body], given: &Given) {
        if !self.refresh(touches, given) {
            self.clear();
            self.rebuild(touches, ends, given);
        }
        self.dt = given.time.dt;
    }

    fn solve(
        &mut self,
        solver: &dyn PatchSolver,
        bodies: &mut [Body],
        grips: &mut [Grip],
        given: &Given,
    ) -> SolveReport {
        solver.solve(&mut self.problem(bodies, grips, given))
    }

    fn is_small(touches: &[Touch]) -> bool {
        let patches = touches.iter().map(|touch| touch.manifold.patches.len());
        touches.len() < FEW && patches.sum::<usize>() < FEW
    }

    fn solve_each(
        solver: &dyn PatchSolver,
        islands: &mut [(&mut Self, &mut [Body])],
        given: &Given,
    ) -> Vec<SolveReport> {
        let problems = islands.iter_mut();
        let problems = problems.map(|(rows, bodies)| rows.problem(bodies, &mut [], given));
        let mut problems: Vec<PatchProblem> = problems.collect();
        solver.solve_each(&mut problems)
    }

    fn store(&self, touches: &mut [Touch], given: &Given) {
        let dt = given.time.dt;
        let store_one = |(touch, &first): (&mut Touch, &u32)| {
            let impulses = &mut *touch.impulses;
            // They are a point solver's.
            impulses.friction.clear();
            let patches = touch.manifold.patches_with_points();
            for ((i, _, range), found) in patches.zip(&self.patches[first as usize..]) {
                let points = &self.points[found.range()];
                let (kept, to) = (&mut impulses.patches[i], &mut impulses.points[range]);
                store(found, points, kept, to, dt);
            }
        };
        if given.threads.share(self.points.len() / LARGE) {
            given.threads.each((touches, &*self.firsts), store_one);
        } else {
            touches.iter_mut().zip(&self.firsts).for_each(store_one);
        }
    }
}

impl PatchRows {
    /// Instead of a solve: finds what the contacts carry while nothing moves, and says that they gave it all through the step. False where
    /// some of it is not finite.
    pub fn settle(&mut self, bodies: &mut [Body], given: &Given) -> bool {
        patches::settle(&mut self.problem(bodies, &mut [], given));
        // Of a step whose substeps after this one leave contacts as they are.
        let whole = given.time.substeps as f32;
        for patch in &mut self.patches {
            patch.tangential = whole * patch.warm_tangential;
        }
        for point in &mut self.points {
            point.normal = whole * point.warm_normal;
        }
        let finite = |patch: &PatchConstraint| {
            patch.warm_tangential.is_finite() && patch.warm_twist.is_finite()
        };
        self.patches.iter().all(finite) && self.points.iter().all(|point| point.normal.is_finite())
    }

    fn problem<'a>(
        &'a mut self,
        bodies: &'a mut [Body],
        grips: &'a mut [Grip],
        given: &Given,
    ) -> PatchProblem<'a> {
        let threads = match given.threads.share(self.points.len() / LARGE) {
            true => given.threads.count(),
            false => 1,
        };
        PatchProblem {
            bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            grips,
            dt: given.time.dt,
            longest: given.time.max_recent_dt,
            gravity: given.gravity.0,
            max_correction_speed: given.stabilization.max_correction_speed,
            record_history: given.solver.record_history,
            threads,
            memory: &mut self.memory,
        }
    }

    fn rebuild(&mut self, touches: &[Touch], ends: &[[u32; 2]], given: &Given) {
        for (touch, ends) in touches.iter().zip(ends) {
            self.firsts.push(self.patches.len() as u32);
            for (i, patch, range) in touch.manifold.patches_with_points() {
                let (constraint, points) = touch.patch(i, patch, range, given);
                let first = self.points.len() as u32;
                self.points.extend(points);
                self.patches.push(PatchConstraint {
                    bodies: *ends,
                    first,
                    ..constraint
                });
            }
        }
    }

    /// Brings what is kept from the last step up to date: distances and slips, and all of what was detected anew. False where there is
    /// nothing, or other patches than there were.
    fn refresh(&mut self, touches: &[Touch], given: &Given) -> bool {
        self.memory.expect_same();
        let mut at = 0;
        for touch in touches {
            for (i, patch, range) in touch.manifold.patches_with_points() {
                let Some(kept) = self.patches.get_mut(at) else {
                    return false;
                };
                let number = at as u32;
                at += 1;
                if range.len() != kept.count as usize {
                    return false;
                }
                let points = &mut self.points[kept.range()];
                if touch.changed {
                    let (constraint, found) = touch.patch(i, patch, range, given);
                    *kept = PatchConstraint {
                        bodies: kept.bodies,
                        first: kept.first,
                        ..constraint
                    };
                    for (to, point) in points.iter_mut().zip(found) {
                        *to = point;
                    }
                    self.memory.push_changed(number);
                } else {
                    let found = &touch.manifold.points[range];
                    let slip = touch.slip(i);
                    refresh((patch, found, slip), kept, points, self.dt, given);
                }
            }
        }
        at == self.patches.len()
    }
}

/// A patch with its points and its slip that was solved in the last step, of `last` s. To the bit what [`Touch::patch`] would make of it.
fn refresh(
    (patch, found, slip): (&ManifoldPatch, &[ContactPoint], Option<Slip>),
    kept: &mut PatchConstraint,
    points: &mut [PatchPoint],
    last: f32,
    given: &Given,
) {
    let time = &*given.time;
    let ideal = given.stabilization.rest_distance();
    kept.slip = slip;
    let held = if kept.slip.is_some() { time.dt } else { 0.0 };
    let (rate, carried) = (1.0 / last, time.carried());
    kept.warm_tangential = kept.warm_tangential * rate * carried;
    kept.warm_twist = kept.warm_twist * rate * carried;
    kept.warm_rolling = kept.warm_rolling * rate * carried;
    kept.load_tangential = kept.load_tangential * rate * held;
    kept.load_twist = kept.load_twist * rate * held;
    kept.dragged = Default::default();
    kept.tangential = Vec3::ZERO;
    let held = if patch.curved { 0.0 } else { time.dt };
    for (kept, point) in points.iter_mut().zip(found) {
        let (warm, load) = (kept.warm_normal * rate, kept.load * rate);
        kept.separation = point.distance - ideal;
        kept.warm_normal = to_start_from(warm, load, time);
        kept.normal = 0.0;
        kept.load = load * held;
    }
}

impl Touch<'_> {
    /// How far a patch has slipped, where friction holds it.
    fn slip(&self, i: usize) -> Option<Slip> {
        self.targets.patches.get(i).copied().flatten()
    }

    /// One of the pair's patches, and its points.
    fn patch(
        &self,
        i: usize,
        patch: &ManifoldPatch,
        range: Range<usize>,
        given: &Given,
    ) -> (PatchConstraint, impl Iterator<Item = PatchPoint>) {
        let time = &*given.time;
        let ideal = given.stabilization.rest_distance();
        let points = &self.manifold.points[range.clone()];
        let impulse = self.impulses.patches[i];
        let slip = self.slip(i);
        // What friction holds on to is given up with its anchor.
        let held = if slip.is_some() { time.dt } else { 0.0 };
        let constraint = PatchConstraint {
            normal: patch.normal,
            arms: [patch.center, patch.center + self.manifold.between],
            friction: self.pair.friction,
            restitution: self.pair.restitution,
            slip,
            count: points.len() as u32,
            warm_tangential: impulse.warm_tangential * time.carried(),
            warm_twist: impulse.warm_twist * time.carried(),
            rolling_friction: match patch.curved {
                true => self.pair.rolling_friction,
                false => 0.0,
            },
            rolling_radius: self.pair.rolling_radius,
            warm_rolling: impulse.warm_rolling * time.carried(),
            load_tangential: impulse.load_tangential * held,
            load_twist: impulse.load_twist * held,
            ..Default::default()
        };
        // What is round carries its load elsewhere in the next moment, and would be pushed on by the mean of where it was.
        let kept = if patch.curved { 0.0 } else { time.dt };
        let solved = &self.impulses.points[range];
        let points = points.iter().zip(solved);
        let points = points.map(move |(point, impulse)| PatchPoint {
            offset: point.arm - patch.center,
            separation: point.distance - ideal,
            warm_normal: impulse.normal_to_start_from(time),
            normal: 0.0,
            load: impulse.load * kept,
        });
        (constraint, points)
    }
}

fn store(
    found: &PatchConstraint,
    points: &[PatchPoint],
    kept: &mut PatchImpulse,
    impulses: &mut [Impulse],
    dt: f32,
) {
    let rate = 1.0 / dt;
    *kept = PatchImpulse {
        tangential: found.tangential,
        warm_tangential: found.warm_tangential * rate,
        warm_twist: found.warm_twist * rate,
        warm_rolling: found.warm_rolling * rate,
        load_tangential: found.load_tangential * rate,
        load_twist: found.load_twist * rate,
        dragged: found.dragged,
    };
    for (impulse, point) in impulses.iter_mut().zip(points) {
        *impulse = Impulse {
            normal: point.normal,
            warm_normal: point.warm_normal * rate,
            load: point.load * rate,
        };
    }
}
