//! Which bodies take a blow, and the lanes of their patches.

use crate::solver::PatchProblem;
use crate::solver::batches::Batches;
use crate::solver::lanes::F32xN;
use fixedbitset::FixedBitSet;

/// A patch of a body, and where it is in the blocks.
#[derive(Clone, Copy, Default)]
pub struct Place {
    pub patch: u32,
    pub block: u32,
    pub lane: u32,
    /// On which side of the patch the body is.
    pub side: u32,
}

/// The lanes of a block that are visited.
#[derive(Clone, Copy)]
pub struct HotLanes<L> {
    /// 1 where a body is hot, else 0.
    pub hot: L,
    /// 0 where springs hold all that they give, else 1.
    pub gives: L,
}

/// Bodies that take a blow.
#[derive(Default)]
pub struct Hot<L> {
    /// By body.
    is: Vec<bool>,
    bodies: Vec<u32>,
    /// The patches of each body: where they begin among `places`, by body, and where the last one's end.
    starts: Vec<u32>,
    places: Vec<Place>,
    /// By block.
    pub lanes: Vec<HotLanes<L>>,
    blocks: FixedBitSet,
    /// The blocks that are visited, in their order.
    pub visits: Vec<u32>,
    /// Blocks that the last sweep has changed much, and by how much: squares of velocities, m²/s².
    pub stirred: Vec<(u32, L)>,
}

impl<L: F32xN> Hot<L> {
    /// For a step in which nothing is hot yet.
    pub fn begin(&mut self, problem: &PatchProblem, batches: &Batches) {
        self.is.clear();
        self.is.resize(problem.bodies.len(), false);
        self.bodies.clear();
        self.lanes.clear();
        let none = HotLanes {
            hot: L::ZERO,
            gives: L::ONE,
        };
        self.lanes.resize(batches.blocks(), none);
        self.blocks.clear();
        self.blocks.grow(batches.blocks());
        self.find_places(problem, batches);
    }

    /// Sorts the patches by body.
    fn find_places(&mut self, problem: &PatchProblem, batches: &Batches) {
        self.starts.clear();
        self.starts.resize(problem.bodies.len() + 1, 0);
        for body in problem.patches.iter().flat_map(|patch| patch.bodies) {
            self.starts[body as usize] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.places.resize(end as usize, Place::default());
        // From the back, so that each ends where its patches begin, in the order of the blocks.
        for block in (0..batches.blocks()).rev() {
            for (lane, patch) in batches.block(block) {
                for (side, body) in (0..).zip(problem.patches[patch as usize].bodies) {
                    let start = &mut self.starts[body as usize];
                    *start -= 1;
                    self.places[*start as usize] = Place {
                        patch,
                        block: block as u32,
                        lane: lane as u32,
                        side,
                    };
                }
            }
        }
    }

    /// The patches of a body.
    pub fn places_of(&self, body: u32) -> &[Place] {
        let [first, end] = [0, 1].map(|next| self.starts[body as usize + next] as usize);
        &self.places[first..end]
    }

    pub fn is(&self, body: u32) -> bool {
        self.is[body as usize]
    }

    /// Makes a body hot.
    pub fn heat(&mut self, body: u32) {
        if std::mem::replace(&mut self.is[body as usize], true) {
            return;
        }
        self.bodies.push(body);
        let [first, end] = [0, 1].map(|next| self.starts[body as usize + next] as usize);
        for place in &self.places[first..end] {
            self.lanes[place.block as usize].hot[place.lane as usize] = 1.0;
            self.blocks.insert(place.block as usize);
        }
    }

    /// Lets the springs of a body's patches hold all that they give.
    pub fn hold(&mut self, body: u32) {
        let [first, end] = [0, 1].map(|next| self.starts[body as usize + next] as usize);
        for place in &self.places[first..end] {
            self.lanes[place.block as usize].gives[place.lane as usize] = 0.0;
        }
    }

    /// Nothing is hot any more.
    pub fn clear(&mut self) {
        for body in self.bodies.drain(..) {
            self.is[body as usize] = false;
            let [first, end] = [0, 1].map(|next| self.starts[body as usize + next] as usize);
            for place in &self.places[first..end] {
                let lanes = &mut self.lanes[place.block as usize];
                lanes.hot[place.lane as usize] = 0.0;
                lanes.gives[place.lane as usize] = 1.0;
            }
        }
        self.blocks.clear();
        self.visits.clear();
    }

    /// Brings the list of visits up to date.
    pub fn find_visits(&mut self) {
        self.visits.clear();
        self.visits
            .extend(self.blocks.ones().map(|block| block as u32));
    }

    /// Makes the bodies hot whose patches the last sweep has changed by more than `settled`, m/s. Whether it has changed any.
    pub fn spread(&mut self, problem: &PatchProblem, batches: &Batches, settled: f32) -> bool {
        let any = !self.stirred.is_empty();
        let mut stirred = std::mem::take(&mut self.stirred);
        for (block, square) in stirred.drain(..) {
            for (lane, patch) in batches.block(block as usize) {
                if square[lane] > settled * settled {
                    for body in problem.patches[patch as usize].bodies {
                        if problem.bodies[body as usize].inverse_mass > 0.0 {
                            self.heat(body);
                        }
                    }
                }
            }
        }
        self.stirred = stirred;
        any
    }
}
