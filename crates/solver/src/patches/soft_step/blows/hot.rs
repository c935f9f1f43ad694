//! Hot bodies, which take a blow, and the lanes of their patches. They cost time (a heap of 1 000 takes 8 % less without them) and buy
//! truth: the tables of hops and shots in `docs/stability.md`.

use super::SETTLED_CHANGE;
use crate::PatchProblem;
use crate::batches::Batches;
use crate::by_body::ByBody;
use crate::lanes::F32xN;
use crate::patches::soft_step::start::upright::up;
use fixedbitset::FixedBitSet;

/// A patch is steep if the cosine of its normal to the vertical is less than this.
const STEEP_COSINE: f32 = 0.5;

/// Change of the relative velocity at a patch from which on all patches of its bodies are visited, m/s. For smaller changes, only the steep
/// patches are visited: on the others momentum is handed down, and sweeps over all patches make a falling heap a fifth more expensive. At
/// 0.25, or if all changes count as smaller, piles of round bodies come to rest with deeper overlaps: 4.0 and 4.2 mm in the mean instead of
/// 3.4.
const LARGE_CHANGE: f32 = 0.1;

/// A patch of a body, and its place in the blocks.
#[derive(Clone, Copy, Default)]
pub struct Place {
    pub patch: u32,
    pub block: u32,
    pub lane: u32,
    /// The side of the patch on which the body is.
    pub side: u32,
    /// The patch is steep, or a grab holds one of its bodies: sweeps visit it after any change.
    is_steep: bool,
}

/// Masks of the lanes of a block.
#[derive(Clone, Copy)]
struct HotLanes<L> {
    /// 1 where one of its bodies is hot, else 0.
    hot: L,
    /// 1 where the patch is steep and one of its bodies is hot, else 0.
    hot_and_steep: L,
    /// 1 where the last sweep has stirred one of its bodies, so that the next sweep visits it; else 0.
    stirred: L,
    /// 0 where springs hold all that they give, 1 where they yield.
    gives: L,
}

/// A block to visit, with a mask of its lanes.
#[derive(Clone, Copy)]
pub struct Visit<L> {
    pub block: u32,
    pub lanes: L,
    /// 0 where springs hold all that they give, 1 where they yield.
    pub gives: L,
}

/// The patches of a body that the next sweep visits.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Stirred {
    None,
    Steep,
    All,
}

/// The bodies that take a blow, and the blocks of their patches.
#[derive(Default)]
pub struct Hot<L> {
    /// By body: it is hot.
    is: Vec<bool>,
    pub bodies: Vec<u32>,
    /// By body: the patches of it that the next sweep visits.
    stirs: Vec<Stirred>,
    stirred: Vec<u32>,
    places: ByBody<Place>,
    /// By block: its masks.
    lanes: Vec<HotLanes<L>>,
    /// Blocks with hot lanes, and blocks with stirred lanes.
    hot_blocks: FixedBitSet,
    stirred_blocks: FixedBitSet,
    /// The visits of the next sweep, in the order of the blocks.
    pub visits: Vec<Visit<L>>,
    /// Blocks in which the last sweep changed a velocity by more than [`SETTLED_CHANGE`], with the squares of the changes, m²/s².
    pub changes: Vec<(u32, L)>,
}

impl<L: F32xN> Hot<L> {
    /// Begins a step in which no body is hot yet.
    pub fn begin(&mut self, problem: &PatchProblem, batches: &Batches) {
        self.is.clear();
        self.is.resize(problem.bodies.len(), false);
        self.stirs.clear();
        self.stirs.resize(problem.bodies.len(), Stirred::None);
        self.bodies.clear();
        self.lanes.clear();
        let none = HotLanes {
            hot: L::ZERO,
            hot_and_steep: L::ZERO,
            stirred: L::ZERO,
            gives: L::ONE,
        };
        self.lanes.resize(batches.blocks(), none);
        for blocks in [&mut self.hot_blocks, &mut self.stirred_blocks] {
            blocks.clear();
            blocks.grow(batches.blocks());
        }
        let up = up(problem);
        // Sweeps visit grabs every time, so contacts that a grab presses against must respond every time.
        let is_held = |body: u32| problem.grabs.iter().any(|grab| grab.body == body);
        let places = (0..).zip(batches.iter()).flat_map(|(block, patches)| {
            patches.flat_map(move |(lane, patch)| {
                let found = &problem.patches[patch as usize];
                let is_steep = found.normal.dot(up).abs() < STEEP_COSINE
                    || found.bodies.into_iter().any(is_held);
                let ends = (0..).zip(found.bodies);
                ends.map(move |(side, body)| {
                    let place = Place {
                        patch,
                        block,
                        lane: lane as u32,
                        side,
                        is_steep,
                    };
                    (body, place)
                })
            })
        });
        self.places.fill(problem.bodies.len(), places);
    }

    /// The patches of a body, in the order of the blocks.
    pub fn places_of(&self, body: u32) -> &[Place] {
        self.places.of(body)
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
        for place in self.places.of(body) {
            let lanes = &mut self.lanes[place.block as usize];
            lanes.hot[place.lane as usize] = 1.0;
            if place.is_steep {
                lanes.hot_and_steep[place.lane as usize] = 1.0;
            }
            self.hot_blocks.insert(place.block as usize);
        }
    }

    /// Makes a body hot, and lets the next sweep visit its steep patches or all of them.
    fn stir(&mut self, body: u32, stirs: Stirred) {
        let before = self.stirs[body as usize];
        if before >= stirs {
            return;
        }
        self.stirs[body as usize] = stirs;
        if before == Stirred::None {
            self.stirred.push(body);
            self.heat(body);
        }
        for place in self.places.of(body) {
            if place.is_steep || stirs == Stirred::All {
                self.lanes[place.block as usize].stirred[place.lane as usize] = 1.0;
                self.stirred_blocks.insert(place.block as usize);
            }
        }
    }

    /// Lets the springs of a body's patches hold all that they give.
    pub fn hold(&mut self, body: u32) {
        for place in self.places.of(body) {
            self.lanes[place.block as usize].gives[place.lane as usize] = 0.0;
        }
    }

    /// Ends the heat of all bodies.
    pub fn clear(&mut self) {
        for body in self.bodies.drain(..) {
            self.is[body as usize] = false;
        }
        for block in self.hot_blocks.ones() {
            let lanes = &mut self.lanes[block];
            (lanes.hot, lanes.hot_and_steep) = (L::ZERO, L::ZERO);
            lanes.gives = L::ONE;
        }
        self.hot_blocks.clear();
        self.visits.clear();
    }

    /// The next sweep visits all patches of hot bodies.
    pub fn visit_all(&mut self) {
        self.visit(|lanes| lanes.hot);
    }

    /// The next sweep visits the steep patches of hot bodies.
    pub fn visit_steep(&mut self) {
        self.visit(|lanes| lanes.hot_and_steep);
    }

    fn visit(&mut self, of: impl Fn(&HotLanes<L>) -> L) {
        let lanes = &self.lanes;
        let visit = |block: usize| Visit {
            block: block as u32,
            lanes: of(&lanes[block]),
            gives: lanes[block].gives,
        };
        let visits = self.hot_blocks.ones().map(visit);
        let visits = visits.filter(|visit| visit.lanes.any_above(L::ZERO));
        self.visits.clear();
        self.visits.extend(visits);
    }

    /// The next sweep visits the patches of bodies that the last sweep has stirred; these bodies become hot. Returns whether there are any.
    pub fn visit_stirred(&mut self, problem: &PatchProblem, batches: &Batches) -> bool {
        let mut changes = std::mem::take(&mut self.changes);
        for (block, square) in changes.drain(..) {
            for (lane, patch) in batches.block(block as usize) {
                if square[lane] > SETTLED_CHANGE * SETTLED_CHANGE {
                    let stirs = match square[lane] > LARGE_CHANGE * LARGE_CHANGE {
                        true => Stirred::All,
                        false => Stirred::Steep,
                    };
                    for body in problem.patches[patch as usize].bodies {
                        if problem.bodies[body as usize].inverse_mass > 0.0 {
                            self.stir(body, stirs);
                        }
                    }
                }
            }
        }
        self.changes = changes;
        self.visits.clear();
        for block in self.stirred_blocks.ones() {
            let lanes = &mut self.lanes[block];
            self.visits.push(Visit {
                block: block as u32,
                lanes: std::mem::take(&mut lanes.stirred),
                gives: lanes.gives,
            });
        }
        self.stirred_blocks.clear();
        for body in self.stirred.drain(..) {
            self.stirs[body as usize] = Stirred::None;
        }
        !self.visits.is_empty()
    }
}
