//! The grabs on the bodies of an island, and their places among its blocks.

pub mod places;

use crate::batches::Batches;
use crate::by_body::ByBody;
use crate::grab::ActiveGrab;
use crate::lanes::State;
use crate::sort;
use crate::walls::{self, Walls};
use crate::{GrabConstraint, PatchProblem};
use places::{EdgePlaces, Group, Visits};
use std::cell::Cell;

/// The places of grabs. They are found when bodies are grabbed, and kept while the same bodies are held and the blocks live.
#[derive(Default)]
pub struct GrabPlaces {
    /// The bodies that are held.
    held: Vec<u32>,
    /// By body: its patches.
    patches: ByBody<u32>,
    pub places: EdgePlaces,
}

impl GrabPlaces {
    /// Finds the places of grabs if other bodies are held than in the last step; returns whether it did. A grab reads its body and the
    /// bodies that it touches, since it may [lean](walls) against them.
    pub fn place(&mut self, batches: &Batches, problem: &PatchProblem) -> bool {
        let held = problem.grabs.iter().map(|grab| grab.body);
        if self.held.iter().copied().eq(held.clone()) {
            return false;
        }
        if self.held.is_empty() {
            let pairs = problem.patches.iter().map(|patch| patch.bodies);
            self.patches = walls::by_body(problem.bodies.len(), pairs);
        }
        self.held.clear();
        self.held.extend(held);
        let moves = |body: &u32| problem.bodies[*body as usize].inverse_mass > 0.0;
        let mut edges: Vec<Vec<u32>> = Vec::with_capacity(self.held.len());
        for &body in &self.held {
            let mut bodies = vec![body];
            for &patch in self.patches.of(body) {
                bodies.extend(problem.patches[patch as usize].bodies);
            }
            bodies.retain(moves);
            sort::values(&mut bodies);
            bodies.dedup();
            edges.push(bodies);
        }
        self.places = match edges.is_empty() {
            true => EdgePlaces::default(),
            false => EdgePlaces::new(&edges, &Visits::new(batches, problem)),
        };
        true
    }

    /// Whether sweeps may run in segments.
    pub fn fit_segments(&self) -> bool {
        self.places.is_empty() || self.places.fits_segments
    }

    /// Prepares the grabs for the first substep, of `h` s.
    pub fn begin(&self, problem: &PatchProblem, h: f32, grabs: &mut Vec<ActiveGrab>) {
        grabs.clear();
        if problem.grabs.is_empty() {
            return;
        }
        let contact = |patch: usize| {
            let patch = &problem.patches[patch];
            (patch.bodies, patch.normal)
        };
        let walls = Walls::new(&self.patches, problem.bodies, contact);
        grabs.extend(problem.grabs.iter().map(|grab: &GrabConstraint| {
            let held = ActiveGrab::new(grab, &problem.bodies[grab.body as usize], h);
            held.in_step(problem.dt, walls.among_patches(grab.body, problem))
        }));
    }
}

impl EdgePlaces {
    /// Visits the grabs of a group. Returns Σ W Δλ², J.
    #[inline(never)]
    pub fn visit(
        &self,
        group: &Group,
        grabs: &mut [ActiveGrab],
        velocities: &[Cell<State>],
        motions: &[Cell<State>],
        fastest: f32,
    ) -> f32 {
        let mut change = 0.0;
        for &edge in self.edges_of(group) {
            change += grabs[edge as usize].visit_among(velocities, motions, fastest);
        }
        change
    }
}
