//! Friction of bounces: the normal impulse that a bounce adds allows more friction, within the same cone as that of the substeps.
//!
//! It comes after the normal impulses, patch by patch. So it only takes energy, unless a surface moves.

use super::Row;
use crate::solver::PatchProblem;
use glam::Vec3;

/// Slows the slip of a patch as far as its cone allows. `rows` are those of its points; none may bounce.
pub fn rub(rows: &[Row], problem: &mut PatchProblem) {
    let row = &rows[0];
    let (a, b) = (row.bodies[0], row.bodies[1]);
    let patch = &mut problem.patches[row.patch];
    if patch.friction <= 0.0 || rows.iter().all(|row| row.leave <= 0.0) {
        return;
    }
    let number = row.patch as u32;
    let surface = problem.surfaces.binary_search_by_key(&number, |of| of.0);
    let demanded = surface.map_or(Vec3::ZERO, |found| problem.surfaces[found].1);
    let velocity = |body: usize, arm: Vec3| {
        let body = &problem.bodies[body];
        body.linear + body.angular.cross(arm)
    };
    let velocity = velocity(a, patch.arms[0]) - velocity(b, patch.arms[1]);
    let slip = (velocity - demanded).reject_from_normalized(patch.normal);
    let Some(direction) = slip.try_normalize() else {
        return;
    };
    let response = problem.bodies[a].response(direction, patch.arms[0])
        + problem.bodies[b].response(direction, patch.arms[1]);
    if response <= 0.0 {
        return;
    }
    let of_substeps: f32 = problem.points[patch.range()]
        .iter()
        .map(|point| point.normal)
        .sum();
    let of_bounce: f32 = rows.iter().map(|row| row.impulse).sum();
    let most = patch.friction * (of_substeps + of_bounce.max(0.0));
    // What the substeps have given is never taken back.
    let most = most.max(patch.tangential.length());
    let all = (patch.tangential - slip / response).clamp_length_max(most);
    let given = all - patch.tangential;
    patch.tangential = all;
    problem.bodies[a].apply(given, patch.arms[0]);
    problem.bodies[b].apply(-given, patch.arms[1]);
}
