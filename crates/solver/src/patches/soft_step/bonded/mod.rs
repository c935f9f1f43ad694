//! Bodies that bonds hold together are solved as one rigid body.
//!
//! While its bonds hold, a [structure](structure) of bonded bodies moves as one. So contacts see [one body](whole) with the mass and the
//! inertia of all, in a [problem](reduced) with one body for each structure. A visit of a sweep costs what its contacts cost, poses
//! relative to each other are kept to rounding, and a spin strains nothing by errors of the solve. A structure that a body holds which does
//! not move does not move either.
//!
//! After the sweeps, the [loads](loads) on each body are known, and the forces in the bonds follow from their [stiffness](stiffness) by one
//! solve. If some bonds may [break](strength) by them, the results are dropped, and that structure is solved by its
//! [joints](super::joints), in which bonds break substep by substep. So a structure is stiff as long as it holds, and breaks as it would in
//! any case.
//!
//! [Some](alone) structures are always solved by their joints: those that something holds that moves, or a grab.
//!
//! Where a bond broke within a structure that still hangs together, its bodies touch, and the contact carries nothing as long as the bonds
//! hold without it. So it is where a structure touches the ground that it is bonded to elsewhere.

mod alone;
mod loads;
mod reduced;
mod stiffness;
mod strength;
mod structure;
#[cfg(test)]
mod tests;
mod whole;

use super::SoftStep;
use crate::lanes::has_fused;
use crate::patches::PatchProblem;
use crate::{Lanes, SolveReport};
use loads::loads;
use reduced::{MemberOf, Reduced};
use strength::Forces;
use structure::Structure;
use whole::Whole;

/// The structures of an island, and the problem in which each is one body.
#[derive(Debug, Default)]
struct Bonded {
    structures: Vec<Structure>,
    reduced: Reduced,
}

impl SoftStep {
    /// Solves a problem with each structure as one body. Returns `None`, and changes no result, if there are none.
    pub(super) fn solve_bonded(&self, problem: &mut PatchProblem) -> Option<SolveReport> {
        let has_bonds = problem.joints.iter().any(|joint| joint.bond.is_some());
        if !self.sweeps_joints || !has_bonds {
            return None;
        }
        let mut kept = problem.memory.take_lasting::<Bonded>().unwrap_or_default();
        let report = self.solve_whole(problem, &mut kept);
        problem.memory.keep_lasting(kept);
        report
    }

    fn solve_whole(&self, problem: &mut PatchProblem, kept: &mut Bonded) -> Option<SolveReport> {
        let Bonded {
            structures,
            reduced,
        } = kept;
        *structures = structure::find(problem, std::mem::take(structures));
        let are_whole = alone::are_whole(structures, problem);
        let is_fused = self.lanes != Lanes::Four && has_fused();
        let whole = |(of, &is_whole): (&Structure, &bool)| is_whole.then(|| Whole::of(of, problem));
        let mut wholes: Vec<Option<Whole>> = structures.iter().zip(&are_whole).map(whole).collect();
        loop {
            if wholes.iter().all(Option::is_none) {
                return None;
            }
            let member_of = member_of(structures, &wholes, problem.bodies.len());
            reduced.gather(problem, structures, &wholes, &member_of);
            let report = match reduced.moves() {
                true => self.solve_plain(&mut reduced.problem(problem)),
                false => SolveReport::default(),
            };
            let loads = loads(problem, (structures, &wholes), reduced, &member_of);
            let mut holds = true;
            let mut found: Vec<Forces> = Vec::new();
            for ((of, whole), loads) in structures.iter_mut().zip(&mut wholes).zip(&loads) {
                let forces = match &*whole {
                    Some(whole) => of.forces(whole, loads, problem.dt, is_fused),
                    None => Forces::default(),
                };
                if whole.is_some() && forces.may_break(of, problem) {
                    *whole = None;
                    holds = false;
                }
                found.push(forces);
            }
            if !holds {
                continue;
            }
            reduced.store(problem, &member_of);
            for ((of, whole), forces) in structures.iter().zip(&wholes).zip(found) {
                if let Some(whole) = whole {
                    forces.store(of, problem);
                    let body = &reduced.bodies[of.members[0] as usize];
                    match of.is_anchored {
                        true => Whole::hold(&of.members, problem.bodies),
                        false => whole.carry(body, problem.dt, &of.members, problem.bodies),
                    }
                }
            }
            return Some(report);
        }
    }
}

/// The structure and the member of each body, of those structures that are solved as one body.
fn member_of(structures: &[Structure], wholes: &[Option<Whole>], bodies: usize) -> MemberOf {
    let mut found = vec![None; bodies];
    for ((number, of), whole) in (0..).zip(structures).zip(wholes) {
        if whole.is_some() {
            for (member, &body) in (0..).zip(&of.members) {
                found[body as usize] = Some((number, member));
            }
        }
    }
    found
}
