//! A problem in which each structure is one body.
//!
//! Bodies keep their indices: a structure takes that of its first member, and the others have no contact left. A structure that something
//! holds is a body that does not move. Contacts within a structure, and between structures that do not move, are open, and left out.

use super::structure::Structure;
use super::whole::Whole;
use crate::revision::Revision;
use crate::{
    Body, Both, GrabConstraint, JointConstraint, Memory, PatchConstraint, PatchPoint, PatchProblem,
};
use glam::Vec3;

/// The data of a patch from which its revision follows, besides its own.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    revision: Option<Revision>,
    arms: [Vec3; 2],
    inverse_masses: [f32; 2],
}

/// The data that a problem has in common with that of the last step as long as its memory is valid.
#[derive(Clone, Debug, Default, PartialEq)]
struct Layout {
    problem: Option<Revision>,
    /// By patch: its bodies, whether they move, its number of points.
    patches: Vec<([u32; 2], [bool; 2], u32)>,
}

/// The lists of a problem.
#[derive(Debug, Default)]
pub struct Reduced {
    pub bodies: Vec<Body>,
    pub patches: Vec<PatchConstraint>,
    pub points: Vec<PatchPoint>,
    pub joints: Vec<JointConstraint>,
    grabs: Vec<GrabConstraint>,
    surfaces: Vec<(u32, Vec3)>,
    /// By patch: its index in the whole problem.
    pub source: Vec<u32>,
    /// By joint: its index in the whole problem.
    pub joint_source: Vec<u32>,
    /// By patch.
    seen: Vec<Seen>,
    layout: Layout,
    memory: Memory,
}

/// The structure of each body that is solved as a part of it, and its number among the members.
pub type MemberOf = Vec<Option<(u32, u32)>>;

/// The body that an end of a contact or a joint acts on, and the arm from the centre of mass of that, m.
fn end(
    body: u32,
    arm: Vec3,
    (structures, wholes): (&[Structure], &[Option<Whole>]),
    member_of: &MemberOf,
) -> (u32, Vec3) {
    let Some((structure, member)) = member_of[body as usize] else {
        return (body, arm);
    };
    let of = &structures[structure as usize];
    match &wholes[structure as usize] {
        Some(whole) if !of.is_anchored => {
            let far = whole.arms[member as usize].as_vec3();
            (of.members[0], far + arm)
        }
        _ => (body, arm),
    }
}

impl Reduced {
    /// Takes the data of a problem. `wholes` are the structures that are solved as one body.
    pub fn gather(
        &mut self,
        problem: &PatchProblem,
        structures: &[Structure],
        wholes: &[Option<Whole>],
        member_of: &MemberOf,
    ) {
        self.bodies.clear();
        self.bodies.extend_from_slice(problem.bodies);
        for (structure, whole) in structures.iter().zip(wholes) {
            let Some(whole) = whole else {
                continue;
            };
            for &member in &structure.members {
                self.bodies[member as usize] = Body::default();
            }
            if !structure.is_anchored {
                let first = structure.members[0] as usize;
                self.bodies[first] = whole.body(&structure.members, problem.bodies);
            }
        }
        self.joints.clear();
        self.joint_source.clear();
        let mut is_inside = vec![false; problem.joints.len()];
        for (structure, _) in structures.iter().zip(wholes).filter(|(_, of)| of.is_some()) {
            for bond in &structure.bonds {
                is_inside[bond.joint] = true;
            }
        }
        let end = |body: u32, arm: Vec3| end(body, arm, (structures, wholes), member_of);
        for (number, joint) in problem.joints.iter().enumerate() {
            if is_inside[number] {
                continue;
            }
            let [(a, arm), (b, other_arm)] =
                [0, 1].both(|side| end(joint.bodies[side], joint.arms[side]));
            self.joint_source.push(number as u32);
            self.joints.push(JointConstraint {
                bodies: [a, b],
                arms: [arm, other_arm],
                ..*joint
            });
        }
        self.grabs.clear();
        self.grabs.extend_from_slice(problem.grabs);
        self.gather_patches(problem, structures, wholes, member_of);
        self.revise(problem);
    }

    fn gather_patches(
        &mut self,
        problem: &PatchProblem,
        structures: &[Structure],
        wholes: &[Option<Whole>],
        member_of: &MemberOf,
    ) {
        self.patches.clear();
        self.points.clear();
        self.surfaces.clear();
        self.source.clear();
        let end = |body: u32, arm: Vec3| end(body, arm, (structures, wholes), member_of);
        let mut surfaces = problem.surfaces.iter().peekable();
        for (number, patch) in (0..).zip(problem.patches.iter()) {
            let surface = surfaces.next_if(|(of, _)| *of == number);
            let [(a, arm), (b, other_arm)] =
                [0, 1].both(|side| end(patch.bodies[side], patch.arms[side]));
            let moves = [a, b].both(|body| self.bodies[body as usize].inverse_mass > 0.0);
            if a == b || moves == [false; 2] {
                continue;
            }
            if let Some(&(_, velocity)) = surface {
                self.surfaces.push((self.patches.len() as u32, velocity));
            }
            let first = self.points.len() as u32;
            self.points
                .extend_from_slice(&problem.points[patch.range()]);
            self.source.push(number);
            self.patches.push(PatchConstraint {
                bodies: [a, b],
                arms: [arm, other_arm],
                first,
                ..*patch
            });
        }
    }

    /// Keeps the revisions of patches that are as they were in the last step, and gives the others new ones.
    fn revise(&mut self, problem: &PatchProblem) {
        let moves = |body: u32| self.bodies[body as usize].inverse_mass > 0.0;
        let patches = self
            .patches
            .iter()
            .map(|patch| (patch.bodies, patch.bodies.both(moves), patch.count));
        let layout = Layout {
            problem: Some(problem.memory.revision()),
            patches: patches.collect(),
        };
        let revisions = problem.memory.patches();
        if layout != self.layout || revisions.is_empty() {
            self.layout = layout;
            self.memory.renew();
            self.seen.clear();
        }
        self.seen.truncate(self.patches.len());
        for (number, patch) in self.patches.iter().enumerate() {
            let seen = Seen {
                revision: revisions.get(self.source[number] as usize).copied(),
                arms: patch.arms,
                inverse_masses: patch
                    .bodies
                    .both(|body| self.bodies[body as usize].inverse_mass),
            };
            let known = self.memory.patches_mut();
            match self.seen.get_mut(number) {
                Some(before) if *before == seen => {}
                Some(before) => (*before, known[number]) = (seen, Revision::next()),
                None => {
                    self.seen.push(seen);
                    known.push(Revision::next());
                }
            }
        }
    }

    /// As a problem of a solver, with the settings of the whole one.
    pub fn problem<'a>(&'a mut self, like: &PatchProblem) -> PatchProblem<'a> {
        PatchProblem {
            bodies: &mut self.bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            grabs: &mut self.grabs,
            joints: &mut self.joints,
            surfaces: &self.surfaces,
            memory: &mut self.memory,
            ..*like
        }
    }

    /// Whether some body moves.
    pub fn moves(&self) -> bool {
        self.bodies.iter().any(|body| body.inverse_mass > 0.0)
    }

    /// Stores the results of contacts, grabs and joints in the whole problem, and of bodies that are no part of a structure.
    pub fn store(&self, problem: &mut PatchProblem, member_of: &MemberOf) {
        for (number, body) in problem.bodies.iter_mut().enumerate() {
            if member_of[number].is_none() {
                *body = self.bodies[number];
            }
        }
        problem.grabs.copy_from_slice(&self.grabs);
        for (joint, &source) in self.joints.iter().zip(&self.joint_source) {
            let to = &mut problem.joints[source as usize];
            *to = JointConstraint {
                bodies: to.bodies,
                arms: to.arms,
                ..*joint
            };
        }
        let mut solved = self.patches.iter().zip(&self.source).peekable();
        for (number, patch) in (0..).zip(problem.patches.iter_mut()) {
            let points = &mut problem.points[patch.range()];
            match solved.next_if(|(_, source)| **source == number) {
                Some((found, _)) => {
                    points.copy_from_slice(&self.points[found.range()]);
                    *patch = PatchConstraint {
                        bodies: patch.bodies,
                        arms: patch.arms,
                        first: patch.first,
                        ..*found
                    };
                }
                None => forget(patch, points),
            }
        }
    }
}

/// An open contact has no impulses.
fn forget(patch: &mut PatchConstraint, points: &mut [PatchPoint]) {
    for point in points {
        (point.normal_impulse, point.normal, point.rest_impulse) = (0.0, 0.0, 0.0);
    }
    *patch = PatchConstraint {
        bodies: patch.bodies,
        normal: patch.normal,
        arms: patch.arms,
        friction: patch.friction,
        restitution: patch.restitution,
        slip: patch.slip,
        first: patch.first,
        count: patch.count,
        rolling_friction: patch.rolling_friction,
        rolling_radius: patch.rolling_radius,
        ..PatchConstraint::default()
    };
}
