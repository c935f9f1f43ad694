//! The places of edges among the blocks of an island. Edges are constraints that are not contacts, such as grabs.
//! [Joints](crate::patches::soft_step::joints) have no places: they are solved after all contacts of a sweep.
//!
//! Contacts are relaxed in blocks. An edge is relaxed by itself, right before the first block that holds a body which the edge reads or
//! changes. So in every sweep an edge comes before all contacts of its bodies. The result equals that of a sweep over all edges and then
//! all blocks, to the bit, because no earlier block holds one of its bodies.
//!
//! Sweeps that overlap, in [segments](crate::patches::soft_step::sweeps::skewed) or in a
//! [pipeline](crate::patches::soft_step::sweeps::pipeline), visit a block only where the sweep before has finished with its bodies. They
//! treat an edge as a part of its block, with all of its bodies, so the same holds for edges.
//!
//! Edges that share a body form a group. A group stands before the first block of any of its bodies, with its edges in their order.

use crate::PatchProblem;
use crate::batches::Batches;
use crate::sort;
use std::ops::Range;

/// Positions in a sweep at which the contacts of each body are visited.
pub struct Visits {
    /// By body: its first and last visit, counted in visits to blocks since the sweep began.
    of: Vec<[u32; 2]>,
    /// Blocks in a segment.
    blocks: u32,
}

impl Visits {
    pub fn new(batches: &Batches, problem: &PatchProblem) -> Self {
        let blocks = batches.blocks() as u32;
        let mut of = vec![[u32::MAX, 0]; problem.bodies.len()];
        for (block, lanes) in (0..).zip(batches.iter()) {
            for (lane, patch) in lanes {
                let visit = batches.segment_of(lane) as u32 * blocks + block;
                for body in problem.patches[patch as usize].bodies {
                    let [first, last] = &mut of[body as usize];
                    (*first, *last) = (visit.min(*first), visit.max(*last));
                }
            }
        }
        // The sweep has finished with a body without contacts after the first block.
        for [first, _] in &mut of {
            if *first == u32::MAX {
                *first = 0;
            }
        }
        Self { of, blocks }
    }
}

/// Edges that share no body with edges of other groups.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The block before which its edges are relaxed.
    pub block: u32,
    /// The segment whose sweep its edges belong to.
    pub segment: u32,
    edges: Range<usize>,
    bodies: Range<usize>,
}

/// The groups of an island, in the order of blocks.
#[derive(Clone, Debug, Default)]
pub struct EdgePlaces {
    groups: Vec<Group>,
    /// The edges of all groups, one group after another.
    edges: Vec<u32>,
    bodies: Vec<u32>,
    /// In segments, each sweep has finished with the bodies of a group before the next sweep reaches the group.
    pub fits_segments: bool,
}

impl EdgePlaces {
    /// Places edges. `edges` lists for each edge the moving bodies that it reads or changes.
    pub fn new(edges: &[Vec<u32>], visits: &Visits) -> Self {
        let mut places = Self {
            fits_segments: true,
            ..Self::default()
        };
        for (edges, bodies) in groups(edges) {
            let visits_of = bodies.iter().map(|&body| visits.of[body as usize]);
            let span = visits_of.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
            let [first, last] = span.unwrap_or_default();
            let blocks = visits.blocks.max(1);
            places.fits_segments &= last - first < blocks;
            let group = Group {
                block: first % blocks,
                segment: first / blocks,
                edges: places.edges.len()..places.edges.len() + edges.len(),
                bodies: places.bodies.len()..places.bodies.len() + bodies.len(),
            };
            places.groups.push(group);
            places.edges.extend(edges);
            places.bodies.extend(bodies);
        }
        sort::by_key(&mut places.groups, |group| group.block);
        places
    }

    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// The groups that stand before a block.
    pub fn before(&self, block: usize) -> &[Group] {
        let first = self.groups.partition_point(|g| (g.block as usize) < block);
        let groups = &self.groups[first..];
        &groups[..groups.partition_point(|g| g.block as usize == block)]
    }

    /// The edges of a group, in their order.
    pub fn edges_of(&self, group: &Group) -> &[u32] {
        &self.edges[group.edges.clone()]
    }

    pub fn bodies_of(&self, group: &Group) -> &[u32] {
        &self.bodies[group.bodies.clone()]
    }
}

/// Edges that share bodies, each set with all of its bodies.
fn groups(edges: &[Vec<u32>]) -> Vec<(Vec<u32>, Vec<u32>)> {
    let mut groups: Vec<(Vec<u32>, Vec<u32>)> = Vec::new();
    for (edge, bodies) in (0..).zip(edges) {
        let mut merged = (vec![edge], bodies.clone());
        groups.retain(|(edges, others)| {
            let shares = others.iter().any(|body| bodies.contains(body));
            if shares {
                merged.0.extend(edges);
                merged.1.extend(others);
            }
            !shares
        });
        sort::values(&mut merged.0);
        sort::values(&mut merged.1);
        merged.1.dedup();
        groups.push(merged);
    }
    groups
}

#[cfg(test)]
mod tests;
