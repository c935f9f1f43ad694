//! Blows: substeps in which contacts stop bodies abruptly, or set them in motion.
//!
//! One soft sweep leaves a part of the speed of a blow. The springs store it and give it back in later substeps. Since impulses carry over,
//! the next substep would also begin with the impulses of the blow. A stack would hop when a body falls on it. So a substep in which
//! contacts change the velocity of some body by more than [`BLOW_SPEED`] continues after its soft sweep:
//!
//! 1. Bodies that take the blow are [hot](hot); bodies become hot as the blow reaches them.
//! 2. The momentum of falling bodies is [handed down](hand_down) to the ground, which stops a column in one pass.
//! 3. Up to 12 soft sweeps follow, first over steep patches, on which little is handed down. Where momentum was handed down, springs hold
//!    all that they give, since they would yield by more than they can take back: the load is far above the one at rest. Elsewhere they
//!    yield as usual: with rigid rows, a ball that is shot through a wall drags two to three times as many bricks along.
//! 4. Bodies drift, so that overlap is corrected with the velocities of the springs.
//! 5. Up to 16 rigid sweeps over normals remove the velocities that springs have left. Before the drift they would undo the correction of
//!    overlap, and heaps would jam; with friction they would drag along the bodies beside a shot.
//! 6. The next substep, or step, begins without the blow: with no more than the impulses that contacts had before it or have at rest.
//!
//! The rigid sweeps are over-relaxed. All of these sweeps visit the patches that the one before has changed, and end when the changes are
//! small. A step goes this way if its free motion [predicts](expected) that bodies will hit each other.

mod forget;
mod hand_down;
mod hot;

use crate::Both;
use crate::body::{speed_of, trace};
use crate::contact_row::rate;
use crate::lanes::{F32xN, Kernel, cells};
use crate::patches::soft_step::contact::kinds::{MoreRigid, MoreSoft, Soft};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::gaps::Gaps;
use crate::patches::soft_step::island::Island;
use crate::{Body, PatchConstraint, PatchProblem};
use bevy_math::FloatPow;
use forget::Forget;
use glam::Vec3;
use hand_down::HandDown;
use hot::Hot;
use std::cell::Cell;

/// A change of a body's velocity in one substep counts as a blow from this value on, m/s.
pub const BLOW_SPEED: f32 = 0.25;

/// A change of the relative velocity at a patch below which sweeps end and a blow spreads no farther, m/s.
const SETTLED_CHANGE: f32 = 0.02;

/// A body that turns by more than this in a step takes no blow, rad: arms are frozen during a step, and more sweeps over wrong arms gain
/// energy.
const MAX_TURN: f32 = 0.75;

/// A body that is more slender than this takes no blow, as a ratio of radii of gyration: the ends of a beam of 10 × 0.2 × 0.2 m (20) move
/// by its thickness when it turns by a hundredth.
const MAX_SLENDERNESS: f32 = 6.0;

/// Upper bounds of additional soft and rigid sweeps.
const MAX_SOFT_SWEEPS: usize = 12;
const MAX_RIGID_SWEEPS: usize = 16;

/// Over-relaxation: the share of the change of each normal impulse that a rigid sweep adds to it.
const OVER_RELAXATION: f32 = 0.55;

/// Whether the free motion predicts that some bodies will hit each other in this step.
pub fn expected(problem: &PatchProblem, gaps: &Gaps) -> bool {
    // The approach speed of two bodies is at most the sum of their speeds, and a body at rest gains speed only over a gap.
    let gap = 0.5 * BLOW_SPEED * BLOW_SPEED / problem.gravity.length();
    (problem.bodies.iter().any(is_fast) || gaps.widest > gap)
        && problem.patches.iter().any(|patch| hits(problem, patch))
}

/// Whether a body moves or turns with at least half of the speed of a blow, before the forces of this step.
fn is_fast(body: &Body) -> bool {
    let [linear, angular] = body.start.both(Vec3::length_squared);
    let limit = 0.25 * BLOW_SPEED * BLOW_SPEED;
    linear + angular * body.square_gyration() > limit
}

/// Whether the free motion closes a patch in this step with the speed of a blow. Patches that bounce are left out: their bodies are thrown
/// back after the substeps.
fn hits(problem: &PatchProblem, patch: &PatchConstraint) -> bool {
    let bodies = patch.bodies.both(|body| &problem.bodies[body as usize]);
    let points = &problem.points[patch.range()];
    patch.restitution == 0.0
        && points.iter().any(|point| {
            let arms = patch.arms.both(|arm| arm + point.offset);
            let along = |velocities| -rate(patch.normal, arms, velocities);
            let before = along(bodies.both(|body| body.start));
            let gained = along(bodies.both(Body::push));
            let apart = point.separation.max(0.0);
            // The squared speed gained by a constant force on the way to the surface.
            let gathered = 2.0 * gained.max(0.0) / problem.dt * apart;
            before.max(0.0).squared() + gathered > BLOW_SPEED * BLOW_SPEED
                && apart < (before + gained) * problem.dt
        })
}

/// Whether a body is too slender to take a blow.
fn is_slender(body: &Body) -> bool {
    longest_square_gyration(body) > MAX_SLENDERNESS * MAX_SLENDERNESS * body.square_gyration()
}

/// Whether a body that takes no blow, because it is slender, may hit others in this step.
pub fn lands_slender(body: &Body) -> bool {
    body.inverse_mass > 0.0 && is_fast(body) && is_slender(body)
}

/// The square of the largest radius of gyration, m².
fn longest_square_gyration(body: &Body) -> f32 {
    0.5 * trace(&body.inverse_inertia.inverse()) * body.inverse_mass
}

/// The state of blows in an island.
#[derive(Default)]
pub struct Blows<L> {
    hot: Hot<L>,
    hand_down: HandDown,
    /// By body: the square of its mean radius of gyration, m²; 0 for a body that takes no blow, as one with joints: these are solved
    /// directly, with the contacts that carry it.
    square_gyrations: Vec<f32>,
    /// Bodies that may take a blow: those that hit others in this step, and the neighbours of bodies that have taken one.
    candidates: Vec<u32>,
    /// By body: it is in `candidates`.
    is_candidate: Vec<bool>,
    /// By point: its impulse at the beginning of the substep, N·s.
    earlier: Vec<L>,
    /// By point: its impulse before the visit to its patch, N·s.
    was: Vec<L>,
}

impl<L: F32xN> Blows<L> {
    fn begin(&mut self, problem: &PatchProblem, island: &Island<L>) {
        self.square_gyrations.clear();
        let square_gyrations = problem.bodies.iter().enumerate().map(|(number, body)| {
            let square = body.square_gyration();
            let turns_little = body.angular.length() * problem.dt <= MAX_TURN;
            match turns_little && !is_slender(body) && !island.joints.hold(number) {
                true => square,
                false => 0.0,
            }
        });
        self.square_gyrations.extend(square_gyrations);
        self.was.resize(island.points.len(), L::ZERO);
        self.hot.begin(problem, &island.batches);
        self.hand_down.begin();
        self.candidates.clear();
        self.is_candidate.clear();
        self.is_candidate.resize(problem.bodies.len(), false);
        for patch in problem.patches.iter() {
            if hits(problem, patch) {
                patch.bodies.into_iter().for_each(|body| self.add(body));
            }
        }
    }

    /// Adds a body to the candidates.
    fn add(&mut self, body: u32) {
        if self.square_gyrations[body as usize] > 0.0
            && !std::mem::replace(&mut self.is_candidate[body as usize], true)
        {
            self.candidates.push(body);
        }
    }

    /// Finds the bodies that take a blow in this substep. Returns whether there are any.
    fn find(&mut self, problem: &PatchProblem, island: &Island<L>) -> bool {
        // Bodies that took a blow in the last substep may have passed it on.
        for i in 0..self.hot.bodies.len() {
            let body = self.hot.bodies[i];
            self.add(body);
            for j in 0..self.hot.places_of(body).len() {
                let patch = self.hot.places_of(body)[j].patch;
                let bodies = problem.patches[patch as usize].bodies;
                bodies.into_iter().for_each(|body| self.add(body));
            }
        }
        self.hot.clear();
        for &body in &self.candidates {
            let [now, before] =
                [&island.velocities, &island.before].both(|list| list[body as usize]);
            let [linear, angular] = [0, 1].both(|i| (now[i] - before[i]).truncate());
            if speed_of(linear, angular, self.square_gyrations[body as usize]) > BLOW_SPEED {
                self.hot.heat(body);
            }
        }
        !self.hot.bodies.is_empty()
    }
}

impl<L: F32xN> Island<L> {
    /// Runs all sweeps one after the other, with additional ones where there are blows. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each regular sweep,
    /// J.
    pub fn sweep_through_blows(
        &mut self,
        blows: &mut Blows<L>,
        problem: &PatchProblem,
        passes: &[Pass],
        tell: &mut dyn FnMut(f32),
    ) {
        blows.begin(problem, self);
        let mut takes_blow = false;
        for (number, pass) in passes.iter().enumerate() {
            if pass.soft {
                let held_change = self.visit_grabs();
                let impulses = self.points.iter().map(|point| point.impulse);
                blows.earlier.clear();
                blows.earlier.extend(impulses);
                let soft = Soft { first: pass.first };
                let swept = self.sweep_as(soft, pass);
                tell(held_change + swept + self.visit_joints(pass));
                takes_blow = blows.find(problem, self);
                if takes_blow {
                    let Blows { hot, hand_down, .. } = &mut *blows;
                    hand_down.run(problem, self, hot, pass.rate);
                    self.sweep_more(problem, blows, pass, MAX_SOFT_SWEEPS);
                }
                self.drift(pass);
                self.drift_joints(pass, false);
                if takes_blow {
                    let rigid = Pass {
                        soft: false,
                        ..*pass
                    };
                    self.sweep_more(problem, blows, &rigid, MAX_RIGID_SWEEPS);
                }
            } else {
                let swept = self.visit_grabs() + self.sweep_rigidly(pass);
                tell(swept + self.visit_joints(pass));
            }
            let is_last = number + 1 == passes.len();
            self.extrapolate(pass);
            self.end_joints(pass);
            if takes_blow && (pass.extrapolates || is_last) {
                blows.hot.visit_all();
                L::run(Forget {
                    island: self,
                    blows,
                    pushes: !is_last,
                });
            }
        }
    }

    /// Sweeps over patches of hot bodies until the changes are small.
    fn sweep_more(
        &mut self,
        problem: &PatchProblem,
        blows: &mut Blows<L>,
        pass: &Pass,
        sweeps: usize,
    ) {
        let Blows { hot, was, .. } = blows;
        let was = Cell::from_mut(&mut **was).as_slice_of_cells();
        hot.visit_steep();
        for sweep in 1..=sweeps {
            self.visit_grabs();
            L::run(SweepMore {
                island: self,
                hot,
                was,
                // The last sweep is not over-relaxed, since no sweep corrects it.
                over: if sweep < sweeps { OVER_RELAXATION } else { 0.0 },
                pass,
            });
            self.visit_joints(pass);
            if !hot.visit_stirred(problem, &self.batches) {
                break;
            }
        }
    }

    fn drift(&mut self, pass: &Pass) {
        let bodies = self.inertias.len();
        let velocities = cells(&mut self.velocities).iter().take(bodies);
        let others = cells(&mut self.before).iter().zip(cells(&mut self.motions));
        for (velocity, (before, motion)) in velocities.zip(others) {
            pass.drift(velocity, before, motion);
        }
    }

    fn extrapolate(&mut self, pass: &Pass) {
        let bodies = self.inertias.len();
        let velocities = cells(&mut self.velocities).iter().take(bodies);
        for (velocity, before) in velocities.zip(cells(&mut self.before)) {
            pass.extrapolate(velocity, before);
        }
    }
}

/// One additional sweep over patches of hot bodies.
struct SweepMore<'a, L: F32xN> {
    island: &'a mut Island<L>,
    hot: &'a mut Hot<L>,
    was: &'a [Cell<L>],
    /// Over-relaxation of rigid sweeps.
    over: f32,
    pass: &'a Pass,
}

impl<L: F32xN> Kernel for SweepMore<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Island {
            blocks,
            points,
            velocities,
            motions,
            ..
        } = self.island;
        let (velocities, motions) = (cells(velocities), cells(motions));
        let (over, was, pass) = (L::splat(self.over), self.was, self.pass);
        let limit = L::splat(SETTLED_CHANGE * SETTLED_CHANGE);
        for visit in &self.hot.visits {
            let block = &mut blocks[visit.block as usize];
            let points = &mut points[block.range()];
            let change = match pass.soft {
                true => {
                    let kinds = MoreSoft {
                        lanes: visit.lanes,
                        gives: visit.gives,
                    };
                    block.relax(kinds, points, velocities, motions, pass)
                }
                false => {
                    let kinds = MoreRigid {
                        lanes: visit.lanes,
                        over,
                        was,
                    };
                    block.relax(kinds, points, velocities, motions, pass)
                }
            };
            // Σ W Δλ² times W is the square of a change of the relative velocity.
            let square = change * block.normals.xx;
            if square.any_above(limit) {
                self.hot.changes.push((visit.block, square));
            }
        }
    }
}
