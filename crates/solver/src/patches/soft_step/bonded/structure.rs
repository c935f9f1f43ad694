//! A bonded structure: bodies that bonds hold together, at rest relative to each other, and the stiffness of their bonds.

use super::stiffness::{Stiffness, stiffness};
use crate::groups::Groups;
use crate::{BondEnd, Both, JointConstraint, PatchProblem, Section, sort};
use glam::{DQuat, DVec3, Quat, Vec3};

/// The number of a body that does not move, among the members of a structure.
pub const FIXED: usize = usize::MAX;

/// A bond of a structure.
#[derive(Clone, Debug)]
pub struct Bond {
    /// Its number in the order of spawning.
    order: u64,
    /// Its index among the joints of the problem.
    pub joint: usize,
    /// The numbers of its bodies among the members, or [`FIXED`].
    pub ends: [usize; 2],
    /// Arm and frame on each of them.
    held: [(Vec3, Quat); 2],
    section: Section,
}

/// The pose of a member relative to the first one, in the axes of that.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub center: DVec3,
    pub turn: DQuat,
}

/// Bodies that move and hang together by bonds alone.
#[derive(Debug)]
pub struct Structure {
    /// In the order of spawning.
    pub bonds: Vec<Bond>,
    /// By member: its body.
    pub members: Vec<u32>,
    /// By member: the bond and the side from which its pose is taken.
    pub seen_from: Vec<(usize, usize)>,
    /// By member: its place. Found from the bonds that were reached first.
    pub places: Vec<Place>,
    /// Something that does not move holds it.
    pub is_anchored: bool,
    pub stiffness: Stiffness,
}

/// The local data of an end.
fn held(end: &BondEnd) -> (Vec3, Quat) {
    (end.arm, end.frame)
}

/// The section and the ends of a joint, if it is a bond.
fn bond_of(joint: &JointConstraint) -> Option<(&Section, &[BondEnd; 2])> {
    Some((joint.section.as_ref()?, joint.bond.as_ref()?))
}

/// The structures of a problem. Those of the last step are taken over if they have the same bonds.
pub fn find(problem: &PatchProblem, before: Vec<Structure>) -> Vec<Structure> {
    let (bodies, joints) = (&*problem.bodies, &*problem.joints);
    let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
    let is_bond = |joint: &JointConstraint| bond_of(joint).is_some() && joint.acts(bodies);
    let bonds = || {
        joints
            .iter()
            .enumerate()
            .filter(|(_, joint)| is_bond(joint))
    };
    let mut groups = Groups::default();
    groups.begin(bodies.len());
    for (_, bond) in bonds() {
        if bond.bodies.into_iter().all(moves) {
            groups.link(bond.bodies);
        }
    }
    let of_groups = bonds().map(|(number, bond)| {
        let moving = bond.bodies.into_iter().find(|&body| moves(body));
        let group = groups.first_of(moving.unwrap_or(bond.bodies[0]));
        (group, bond.order, number)
    });
    let mut of_groups: Vec<_> = of_groups.collect();
    sort::by_key(&mut of_groups, |&(group, order, number)| {
        (group, order, number)
    });
    let mut before: Vec<Option<Structure>> = before.into_iter().map(Some).collect();
    let mut numbers = vec![FIXED; bodies.len()];
    let mut found = Vec::new();
    for (place, group) in of_groups.chunk_by(|a, b| a.0 == b.0).enumerate() {
        let (bonds, members) = number(group, problem, &mut numbers);
        let is_same = |old: &Option<Structure>| {
            let old = old.as_ref().map(|old| &*old.bonds);
            old.is_some_and(|old| are_same(old, &bonds))
        };
        // Most are where they were.
        let same = match before.get(place).is_some_and(is_same) {
            true => Some(place),
            false => before.iter().position(is_same),
        };
        found.push(match same.and_then(|same| before[same].take()) {
            Some(old) => Structure {
                bonds,
                members,
                ..old
            },
            None => Structure::new(bonds, members),
        });
    }
    found
}

/// The bonds of a group in the order of spawning, and their bodies in the order in which they come there. `numbers` is scratch by body.
fn number(
    group: &[(u32, u64, usize)],
    problem: &PatchProblem,
    numbers: &mut [usize],
) -> (Vec<Bond>, Vec<u32>) {
    let (mut bonds, mut members) = (Vec::new(), Vec::new());
    for &(_, order, joint) in group {
        let of = &problem.joints[joint];
        let Some((section, ends)) = bond_of(of) else {
            continue;
        };
        let numbered = of.bodies.both(|body| {
            if problem.bodies[body as usize].inverse_mass == 0.0 {
                return FIXED;
            }
            let number = &mut numbers[body as usize];
            if *number == FIXED {
                *number = members.len();
                members.push(body);
            }
            *number
        });
        bonds.push(Bond {
            order,
            joint,
            ends: numbered,
            held: [held(&ends[0]), held(&ends[1])],
            section: *section,
        });
    }
    (bonds, members)
}

/// Whether two structures have the same bonds, whatever the indices of their bodies.
fn are_same(old: &[Bond], new: &[Bond]) -> bool {
    let same = |old: &Bond, new: &Bond| {
        let Bond { order, ends, .. } = old;
        (order, ends) == (&new.order, &new.ends)
            && old.held == new.held
            && old.section == new.section
    };
    old.len() == new.len() && old.iter().zip(new).all(|(old, new)| same(old, new))
}

/// The pose of the other body of a bond that holds a body on a `side` at a place.
fn beyond(bond: &Bond, side: usize, from: Place) -> Place {
    let [(arm, frame), (other_arm, other_frame)] = [side, 1 - side].both(|side| bond.held[side]);
    let to = |turn: Quat| turn.as_dquat().normalize();
    let turn = (from.turn * to(frame) * to(other_frame).inverse()).normalize();
    let anchor = from.center + from.turn * arm.as_dvec3();
    Place {
        center: anchor - turn * other_arm.as_dvec3(),
        turn,
    }
}

/// Where members are relative to the first one.
fn places(bonds: &[Bond], members: usize) -> Vec<Place> {
    let mut around = vec![Vec::new(); members];
    for (number, bond) in bonds.iter().enumerate() {
        for (side, &end) in bond.ends.iter().enumerate() {
            if end != FIXED && bond.ends[1 - side] != FIXED {
                around[end].push((number, side));
            }
        }
    }
    let first = Place {
        center: DVec3::ZERO,
        turn: DQuat::IDENTITY,
    };
    let mut found = vec![None; members];
    found[0] = Some(first);
    let mut reached = vec![0];
    let mut next = 0;
    while let Some(&member) = reached.get(next) {
        next += 1;
        let from = found[member].unwrap_or(first);
        for &(bond, side) in &around[member] {
            let other = bonds[bond].ends[1 - side];
            if found[other].is_none() {
                found[other] = Some(beyond(&bonds[bond], side, from));
                reached.push(other);
            }
        }
    }
    found
        .into_iter()
        .map(|place| place.unwrap_or(first))
        .collect()
}

impl Structure {
    fn new(bonds: Vec<Bond>, members: Vec<u32>) -> Self {
        let places = places(&bonds, members.len());
        let mut seen_from = vec![(0, 0); members.len()];
        for (number, bond) in bonds.iter().enumerate().rev() {
            for (side, &end) in bond.ends.iter().enumerate() {
                if end != FIXED {
                    seen_from[end] = (number, side);
                }
            }
        }
        let stiffness = stiffness(&bonds, &places);
        Self {
            is_anchored: bonds.iter().any(|bond| bond.ends.contains(&FIXED)),
            stiffness,
            bonds,
            members,
            seen_from,
            places,
        }
    }
}

impl Bond {
    /// Its section.
    pub fn section(&self) -> &Section {
        &self.section
    }

    /// Its axes and its arms to the anchor, in the axes of the first member; the arm of a body that does not move is zero.
    pub fn geometry(&self, places: &[Place]) -> ([DVec3; 3], [DVec3; 2]) {
        let side = usize::from(self.ends[0] == FIXED);
        let place = places[self.ends[side]];
        let (arm, frame) = self.held[side];
        let turn = place.turn * frame.as_dquat().normalize();
        let own = |side: usize| match self.ends[side] {
            FIXED => DVec3::ZERO,
            member => places[member].center,
        };
        let anchor = match self.ends[1] {
            FIXED => place.center + place.turn * arm.as_dvec3(),
            member => places[member].center + places[member].turn * self.held[1].0.as_dvec3(),
        };
        let arms = [0, 1].both(|side| match self.ends[side] {
            FIXED => DVec3::ZERO,
            _ => anchor - own(side),
        });
        ([turn * DVec3::X, turn * DVec3::Y, turn * DVec3::Z], arms)
    }
}
