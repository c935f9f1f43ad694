//! The connected pieces of joints, and the contacts that carry them.

use super::Joints;
use super::leaf::LeafPatch;
use super::member::Member;
use super::piece::Piece;
use super::row::{JointRow, Link};
use crate::Both;
use crate::batches::Batches;
use crate::groups::Groups;
use crate::joint::{Geometry, Part, Placement, rows_of};
use crate::sort;
use crate::{Body, JointConstraint, PatchProblem};
use glam::Vec3;
use std::ops::Range;

/// The bodies of a joint and which rows it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    bodies: [u32; 2],
    rows: u32,
}

impl Shape {
    fn of(joint: &JointConstraint, problem: &PatchProblem) -> Self {
        let rows = match joint.acts(problem.bodies) {
            true => rows_of(joint).fold(0, |rows, (number, part)| {
                rows | 1 << (3 * number + part as usize)
            }),
            false => 0,
        };
        Self {
            bodies: joint.bodies,
            rows,
        }
    }
}

impl Joints {
    /// The bodies of each piece, and its inverse mass as a whole, 1/kg; 0 if something holds it that does not move.
    pub fn wholes<'a>(
        &'a self,
        bodies: &'a [Body],
    ) -> impl Iterator<Item = (impl Iterator<Item = usize> + 'a, f32)> + 'a {
        self.pieces.iter().map(|piece| {
            let members = &self.members[piece.members.clone()];
            let body = |member: &Member| &bodies[member.body as usize];
            let links = self.links[piece.links.clone()].iter();
            let is_free = links
                .flat_map(|link| link.ends)
                .all(|end| piece.members.contains(&end))
                && members
                    .iter()
                    .all(|member| body(member).free_axes == Vec3::ONE);
            let mass: f32 = members
                .iter()
                .map(|member| 1.0 / body(member).inverse_mass)
                .sum();
            let bodies = members.iter().map(|member| member.body as usize);
            (bodies, if is_free { 1.0 / mass } else { 0.0 })
        })
    }

    /// Finds the pieces, if the joints are not those of the last step.
    pub fn place(&mut self, problem: &PatchProblem, batches: &Batches) {
        let shape = problem.joints.iter().map(|joint| Shape::of(joint, problem));
        let moves = problem.bodies.iter().map(|body| body.inverse_mass > 0.0);
        if self.shape.iter().copied().eq(shape.clone())
            && (problem.joints.is_empty() || self.moves.iter().copied().eq(moves.clone()))
        {
            return;
        }
        *self = Self {
            shape: shape.collect(),
            moves: moves.collect(),
            ..Self::default()
        };
        self.find_pieces(problem);
        let member_of = |body: u32| {
            let member = self.member_of[body as usize];
            (member != u32::MAX).then_some(member as usize)
        };
        let mut patches = LeafPatch::find(problem, batches, member_of);
        let piece_of = |patch: &LeafPatch| {
            let pieces = &self.pieces;
            pieces.partition_point(|piece| piece.members.end <= patch.member)
        };
        sort::by_key(&mut patches, piece_of);
        for piece in &mut self.pieces {
            let Range { start, end } = piece.members;
            let [first, end] =
                [start, end].both(|end| patches.partition_point(|patch| patch.member < end));
            piece.patches = first..end;
        }
        self.patches = patches;
    }

    fn find_pieces(&mut self, problem: &PatchProblem) {
        let (bodies, joints) = (&*problem.bodies, &*problem.joints);
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        let acting = joints.iter().enumerate();
        let acting = acting.filter(|(number, _)| self.shape[*number].rows != 0);
        let acting: Vec<(usize, [u32; 2])> = acting
            .map(|(number, joint)| (number, joint.bodies))
            .collect();
        let mut groups = Groups::default();
        groups.begin(bodies.len());
        for &(_, ends) in &acting {
            if ends.into_iter().all(moves) {
                groups.link(ends);
            }
        }
        let mut ends: Vec<u32> = acting.iter().flat_map(|(_, ends)| *ends).collect();
        sort::values(&mut ends);
        ends.dedup();
        // Piece by piece, and fixed bodies last.
        sort::by_key(&mut ends, |&body| match moves(body) {
            true => groups.first_of(body),
            false => u32::MAX,
        });
        let mut place = vec![0; bodies.len()];
        self.member_of.resize(bodies.len(), u32::MAX);
        for (member, &body) in ends.iter().enumerate() {
            place[body as usize] = member;
            if moves(body) {
                self.member_of[body as usize] = member as u32;
            }
        }
        self.members = ends.iter().map(|&body| Member::new(body)).collect();
        // The joints of a piece, those between the same bodies together, in the order in which they came.
        let mut sorted: Vec<_> = acting
            .iter()
            .map(|&(number, ends)| {
                let moved = ends.into_iter().find(|&body| moves(body));
                let piece = groups.first_of(moved.unwrap_or(ends[0]));
                let pair = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                (piece, pair, number)
            })
            .collect();
        sort::by_key(&mut sorted, |&(piece, [a, b], number)| {
            (piece, u64::from(a) << 32 | u64::from(b), number)
        });
        let mut member = 0;
        for piece in sorted.chunk_by(|a, b| a.0 == b.0) {
            let first_link = self.links.len();
            for &(_, _, number) in piece {
                let joint = &joints[number];
                let first = self.rows.len();
                let rows = rows_of(joint);
                self.rows
                    .extend(rows.map(|(number, part)| JointRow::new(number, part)));
                let ends = joint.bodies.both(|body| place[body as usize]);
                let geometry = Geometry::new(joint, [Placement::START; 2]);
                let rows = first..self.rows.len();
                self.links.push(Link::new(number, ends, rows, geometry));
            }
            let first = member;
            while member < ends.len()
                && moves(ends[member])
                && groups.first_of(ends[member]) == piece[0].0
            {
                member += 1;
            }
            let links = first_link..self.links.len();
            let is_driven = self.rows[self.links[first_link].rows.start..]
                .iter()
                .any(|row| row.part == Part::Motor);
            let piece = Piece::new(first..member, links, &self.links, is_driven);
            self.pieces.push(piece);
        }
    }
}
