//! Friction of bouncing patches: the normal impulse that a bounce adds allows more friction, within the same cone as that of the substeps.

use super::Row;
use crate::solver::{Body, PatchProblem};
use glam::Vec3;

/// The friction of a patch of which a point bounces.
pub struct Friction {
    pub patch: usize,
    pub bodies: [usize; 2],
    normal: Vec3,
    /// From the centres of mass to the patch's centre, m.
    arms: [Vec3; 2],
    /// Coefficient of friction μ.
    coefficient: f32,
    /// Tangential velocity that friction demands of A against B, m/s.
    pub demanded: Vec3,
    /// The impulses of the substeps, N·s: the sum of the normal ones, and that of friction.
    normal_impulse: f32,
    tangential: Vec3,
    /// The impulse that the bounce adds, N·s.
    pub impulse: Vec3,
}

impl Friction {
    /// The friction of the patch of some rows, none if it has no friction.
    pub fn of(rows: &[Row], problem: &PatchProblem) -> Option<Self> {
        let row = &rows[0];
        let patch = &problem.patches[row.patch];
        let key = row.patch as u32;
        let surface = problem.surfaces.binary_search_by_key(&key, |of| of.0);
        (patch.friction > 0.0).then(|| Self {
            patch: row.patch,
            bodies: row.bodies,
            normal: patch.normal,
            arms: patch.arms,
            coefficient: patch.friction,
            demanded: surface.map_or(Vec3::ZERO, |found| problem.surfaces[found].1),
            normal_impulse: problem.points[patch.range()]
                .iter()
                .map(|point| point.normal)
                .sum(),
            tangential: patch.tangential,
            impulse: Vec3::ZERO,
        })
    }

    /// Velocity of A against B at the patch's centre, m/s.
    pub fn velocity(&self, [a, b]: [[Vec3; 2]; 2]) -> Vec3 {
        let at = |[linear, angular]: [Vec3; 2], arm: Vec3| linear + angular.cross(arm);
        at(a, self.arms[0]) - at(b, self.arms[1])
    }

    /// Slows the slip as far as the cone allows. `bounce` is the normal impulse that the bounce adds, N·s.
    pub fn slow(&mut self, bounce: f32, bodies: &mut [Body]) {
        let ends = self.bodies.map(|body| &bodies[body]);
        let velocity = self.velocity(ends.map(|end| [end.linear, end.angular])) - self.demanded;
        let slip = velocity.reject_from_normalized(self.normal);
        let Some(direction) = slip.try_normalize() else {
            return;
        };
        let responses = [0, 1].map(|i| ends[i].response(direction, self.arms[i]));
        let response = responses[0] + responses[1];
        if response <= 0.0 {
            return;
        }
        // What the substeps have given stays within the cone whatever the bounce adds, so a bounce that takes impulses off gives nothing back.
        let most = self.coefficient * (self.normal_impulse + bounce.max(0.0));
        let most = most.max(self.tangential.length());
        let all = self.tangential - slip / response;
        let found = all.clamp_length_max(most) - self.tangential;
        self.impulse = found;
        bodies[self.bodies[0]].apply(found, self.arms[0]);
        bodies[self.bodies[1]].apply(-found, self.arms[1]);
    }
}
