//! Cold start: impulses and loads at rest for contacts that have none yet, in a structure that was just built or under a brick that was
//! just placed.
//!
//! Without warm-start impulses, the number of sweeps to find the load at the foot of a tower grows with the height squared, and with a
//! higher power of it where joints carry moments; until then the tower sinks and leans. So loads are [handed down](hand_down). A structure
//! that was built as a whole, and is not in balance with these loads, gets those under a [growing weight](grow) instead: statics alone
//! would let it lean on a squeeze that does not exist. If these forces hold the structure, it is [brought to rest](statics): impulses that
//! keep it still become its loads at rest, and so they are held. A structure that is spawned asleep skips all that if the loads that were
//! handed down keep it still. The removal of a body from the top is handed down like a new load; otherwise its supports would be thrown.
//! [Structures with joints](jointed) press on loose bodies with the loads that their joints give them.

mod grow;
mod hand_down;
mod jointed;
mod statics;
pub mod upright;

use crate::Both;
use crate::contact_row::rate;
use crate::lanes::F32xN;
use crate::patches::soft_step::sweeps::load_statistics::BodyLoad;
use crate::{Body, PatchPoint, PatchProblem};
use glam::Vec3;
use grow::Grown;
use hand_down::Limits;

/// Upper bound of the speed of a body that was placed, m/s; a faster one was thrown.
const MAX_PLACED_SPEED: f32 = 0.01;

/// Upper bound of the speed of a body at rest, m/s: the bodies of a pile take up loads and leave them as they move.
const MAX_REST_SPEED: f32 = 0.001;

/// Accuracy with which new bodies are placed at their rest position, m.
const PLACED_ACCURACY: f32 = 0.005;

/// A structure is in balance if no body moves by more than this share of its motion under gravity. Rotations count on an arm of a metre.
const BALANCED_MOTION: f32 = 1e-3;

/// A structure is still if no body moves by more than this share of its motion under gravity, and if a sweep changes no more than this
/// share of what gravity changes.
const STILL_MOTION: f32 = 3e-4;

/// Upper bound of sweeps back and forth that bring a structure to rest, per course.
const MAX_SWEEPS_PER_COURSE: usize = 150;

/// Upper bound of visits to patches in these sweeps: no step of a large structure that never comes to rest may take seconds.
const MAX_PATCH_VISITS: usize = 1_000_000;

/// Bodies that stand on another one and carry nothing yet, or from which load was removed.
struct New {
    bodies: Vec<bool>,
    /// More than half of the bodies are new, and none of the others moves: the structure was built as a whole.
    all: bool,
}

impl New {
    /// Finds new bodies. In most steps there are none, which one pass over the points finds.
    fn find(
        problem: &PatchProblem,
        closed: f32,
        body_loads: &[BodyLoad],
        jointed: &[bool],
    ) -> Option<Self> {
        let fall = problem.gravity.length() * problem.dt;
        let slower = |body: &Body, most: f32| body.start[0].length_squared() <= most * most;
        let moves = |body: &&Body| body.inverse_mass > 0.0;
        let is_jointed = |body: usize| !jointed.is_empty() && jointed[body];
        let pairs = || {
            let pairs = problem.bodies.iter().zip(body_loads).enumerate();
            pairs.filter_map(|(number, pair)| {
                (moves(&pair.0) && !is_jointed(number)).then_some(pair)
            })
        };
        let unloaded =
            |(body, body_loads): &(&Body, &BodyLoad)| body_loads.is_unloaded(body, problem);
        if pairs().all(|(_, body_loads)| body_loads.carries) && !pairs().any(|pair| unloaded(&pair))
        {
            return None;
        }
        let stands = hand_down::standing(problem, closed, jointed);
        // Bodies that were spawned while they slide. In a heap that falls, some always carry.
        let slides = match pairs().any(|(_, body_loads)| body_loads.carries) {
            true => Vec::new(),
            false => sliding(problem, closed),
        };
        let bodies = problem.bodies.iter().zip(body_loads).zip(stands);
        let bodies: Vec<[bool; 3]> = bodies
            .enumerate()
            .map(|(number, ((body, body_loads), stands))| {
                let stands = moves(&body) && stands && !is_jointed(number);
                let still = stands && slower(body, MAX_PLACED_SPEED);
                [
                    still && !body_loads.carries,
                    stands && !still && slides.get(number) == Some(&true),
                    slower(body, MAX_REST_SPEED) && still && unloaded(&(body, body_loads)),
                ]
            })
            .collect();
        let new = bodies.iter().filter(|[new, ..]| *new).count();
        let moved = problem.bodies.iter().filter(moves);
        // Statics knows neither joints nor bodies that slide.
        let all = 2 * new > moved.count()
            && jointed.is_empty()
            && !problem.broke
            && !bodies.iter().any(|[_, slides, _]| *slides)
            && problem.bodies.iter().all(|body| slower(body, fall));
        let bodies: Vec<bool> = bodies
            .into_iter()
            .map(|states| states.contains(&true))
            .collect();
        bodies.contains(&true).then_some(Self { bodies, all })
    }
}

/// By body: it slides on what it touches, and neither comes to it nor leaves it.
fn sliding(problem: &PatchProblem, closed: f32) -> Vec<bool> {
    // What rolls carries nothing by sliding.
    let turns_little =
        |body: &Body| body.start[1].length_squared() < MAX_PLACED_SPEED * MAX_PLACED_SPEED;
    let mut slides: Vec<bool> = problem.bodies.iter().map(turns_little).collect();
    for patch in problem.patches.iter() {
        let starts = patch
            .bodies
            .both(|body| problem.bodies[body as usize].start);
        let parts = |point: &PatchPoint| {
            let arms = patch.arms.both(|arm| arm + point.offset);
            let speed = rate(patch.normal, arms, starts).abs();
            point.separation <= closed && speed > MAX_PLACED_SPEED
        };
        if problem.points[patch.range()].iter().any(parts) {
            for body in patch.bodies {
                slides[body as usize] = false;
            }
        }
    }
    slides
}

/// By body: a joint holds it; empty if there are no joints. Such bodies are never new: a direct solve finds the loads of their contacts.
fn jointed(problem: &PatchProblem) -> Vec<bool> {
    let mut jointed = Vec::new();
    for joint in problem.joints.iter() {
        jointed.resize(problem.bodies.len(), false);
        for body in joint.bodies {
            jointed[body as usize] = true;
        }
    }
    jointed
}

/// Gives contacts that carry nothing yet their impulses and loads at rest in equilibrium. Returns whether there were any.
pub fn cold_start<L: F32xN>(problem: &mut PatchProblem, body_loads: &[BodyLoad]) -> bool {
    let limits = limits(problem);
    let jointed = jointed(problem);
    let new = New::find(problem, limits.closed, body_loads, &jointed);
    if let Some(new) = &new
        && let Some(search) = load(problem, limits, new)
    {
        search.run::<L>(problem);
    }
    let is_borne = jointed::bear::<L>(problem, limits, &jointed);
    new.is_some() || is_borne
}

/// Hands down the loads of a structure at rest without joints. Returns a search if that does not keep it still. Most walls need none, and
/// the blocks for its sweeps take longer to build than loads to hand down. Awake structures are always searched, because they would move by
/// what is left.
pub fn start_at_rest(problem: &mut PatchProblem, body_loads: &[BodyLoad]) -> Option<Search> {
    let limits = limits(problem).at_rest(problem);
    let new = New::find(problem, limits.closed, body_loads, &[])?;
    let search = load(problem, limits, &new)?;
    if search.left <= STILL_MOTION {
        hold(problem, &new.bodies);
        return None;
    }
    Some(search)
}

/// The limits for awake bodies.
fn limits(problem: &PatchProblem) -> Limits {
    // The distance that a body falls from rest in a step.
    let fallen = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    Limits {
        closed: fallen.max(PLACED_ACCURACY),
        still: 0.0,
    }
}

/// Hands down the loads of new bodies. Returns a search if the structure was built as a whole.
fn load(problem: &mut PatchProblem, limits: Limits, new: &New) -> Option<Search> {
    let courses = hand_down::hand_down(problem, limits, &new.bodies);
    if !problem.joints.is_empty() {
        hold(problem, &new.bodies);
    }
    new.all.then(|| Search {
        closed: limits.closed,
        courses,
        left: hand_down::largest_motion(problem) / (problem.gravity.length() * problem.dt),
    })
}

/// A search by sweeps for impulses that keep a structure still, from those that were handed down.
pub struct Search {
    closed: f32,
    /// Number of bodies on the longest path down.
    courses: usize,
    /// The largest motion that is left to a body, as a share of its motion under gravity.
    left: f32,
}

impl Search {
    /// Replaces the impulses and loads at rest by those that it finds.
    pub fn run<L: F32xN>(self, problem: &mut PatchProblem) {
        let grown = match self.left <= BALANCED_MOTION {
            true => Grown::Rest,
            false => grow::grow::<L>(problem, self.closed),
        };
        if grown != Grown::Go {
            let most = MAX_PATCH_VISITS / problem.patches.len().max(1);
            let most = most.min(MAX_SWEEPS_PER_COURSE * self.courses);
            statics::settle::<L>(problem, self.closed, most);
        }
    }
}

/// Makes the friction of new bodies a load at rest, where no search does. Springs that begin without it slip: ten tons on a plank of a
/// bridge, which is hardly tilted, by 0.06 mm.
fn hold(problem: &mut PatchProblem, new: &[bool]) {
    for patch in problem.patches.iter_mut() {
        let is_new = patch.bodies.iter().any(|&body| new[body as usize]);
        if is_new && patch.rest_friction_impulse == Vec3::ZERO {
            patch.rest_friction_impulse = patch.friction_impulse;
        }
    }
}

#[cfg(test)]
mod tests;
