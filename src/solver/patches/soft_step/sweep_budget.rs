//! How many sweeps a step gets, and how stiff springs may be with them.
//!
//! Springs are as stiff as sweeps come often ([`SoftStep::sweeps_per_period`]), and how stiff they must be is the structure's matter,
//! not the step's: a column on springs buckles below a frequency that grows with its courses and with √(load / (mass · size)), as
//! Euler's does. So sweeps come at a rate, and a long step has more of them. The rate follows what the structure is and what it has
//! carried for long; one that followed impulses of the moment would excite what they shake.

use super::SoftStep;
use super::load_statistics::{BodyLoad, LoadStatistics};
use crate::solver::PatchProblem;

/// Substeps to one rigid sweep: most, and where so many courses stand on each other. Soft sweeps let disturbances grow from course
/// to course: a pyramid of 100 trembles by 50 mm/s with three, and one of 50 by 2; of 20 it is steadier with three.
const SUBSTEPS_PER_RIGID_SWEEP: usize = 3;
const TALL: usize = 40;
const SUBSTEPS_PER_RIGID_SWEEP_IF_TALL: usize = 2;

/// Where so many courses stand on each other, rigid sweeps go down.
///
/// A sweep up hands what it finds on to all that stands above, and to one course below. With velocities extrapolated from substep to
/// substep, what goes down so grows from course to course where bodies stand on several others: in a linear model (walls of 60 and 120
/// courses) by e¹¹ and e²⁶ before it leaves, so that rounding lets a tower of planks of 60 layers tremble by 11 mm/s. A sweep down before
/// the next substep takes it back: e¹ and e¹·⁵. Walls of 50 courses are steady without, and sweeps that all go up may follow each other on
/// several threads.
const VERY_TALL: usize = 52;

/// There are so many times as many contacts as bodies. Nothing grows in a single column, which stands the better for sweeps that go up.
const BRANCHED: f32 = 1.5;

/// The frequency of springs, Hz, is at least so many times courses · √(load / (mass · size)), SI units. A column of 100
/// cubes under a noise of ±2 mm stands with it, now that it starts in equilibrium; before, it needed twice as much.
const STABLE: f32 = 0.02;

/// Fewer courses count as so many: a cube under a thousand of its weight needs as much as a tower.
const FEW: f32 = 24.0;

/// Where things are not as they were, sweeps come more often than usual by this share.
const UNSETTLED: f32 = 0.5;

/// They are not where so much of what contacts carry is new. Piles of round things are always so: nothing is held for them. Where a
/// tenth more was nothing yet, arches slid 3 % before their limits.
const NEW: f32 = 0.25;

/// What is too much for sweeps that come so many times as often as usual is too much.
const MOST: f32 = 4.0;

/// A step that is longer by this share of a round is no reason for a round more.
const A_LITTLE: f32 = 0.1;

/// A step's sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepBudget {
    /// One soft sweep each.
    pub substeps: usize,
    /// A rigid sweep follows so many.
    pub substeps_per_rigid_sweep: usize,
    /// Rigid sweeps go from the last contact to the first.
    pub downwards: bool,
    /// Sweeps that springs may count on, 1/s.
    pub rate: f32,
}

impl SweepBudget {
    /// An order in which those that are the same stand together.
    pub fn compare(&self, other: &Self) -> std::cmp::Ordering {
        let whole = |budget: &Self| {
            let &Self {
                substeps,
                substeps_per_rigid_sweep,
                downwards,
                ..
            } = budget;
            (substeps, substeps_per_rigid_sweep, downwards)
        };
        whole(self)
            .cmp(&whole(other))
            .then(self.rate.total_cmp(&other.rate))
    }

    /// What a problem needs whose impulses are those it starts from.
    pub fn new(
        settings: &SoftStep,
        problem: &PatchProblem,
        (statistics, body_loads): (&LoadStatistics, &[BodyLoad]),
        courses: &mut Vec<Course>,
    ) -> Self {
        find_courses(problem, body_loads, courses);
        let courses = &*courses;
        let bodies: usize = courses.iter().map(|course| course.bodies).sum();
        let downwards =
            courses.len() >= VERY_TALL && problem.patches.len() as f32 > BRANCHED * bodies as f32;
        let soft = match courses.len() {
            TALL.. if !downwards => SUBSTEPS_PER_RIGID_SWEEP_IF_TALL,
            _ => SUBSTEPS_PER_RIGID_SWEEP,
        };
        let round = soft + 1;
        let usual = round as f32 / (soft as f32 * settings.max_substep);
        let most = MOST * usual;
        let &LoadStatistics {
            unsettled, pressed, ..
        } = statistics;
        let usual = usual * (1.0 + UNSETTLED * (unsettled / NEW).min(1.0));
        let rate =
            (settings.sweeps_per_period * stable(problem, courses, pressed)).clamp(usual, most);
        let sweeps = |seconds: f32| {
            let rounds = (rate * seconds / round as f32 - A_LITTLE).ceil() as usize;
            (rounds * round)
                .max(settings.min_sweeps)
                .min(settings.max_sweeps)
        };
        // Not all of what whole rounds come to, or stiffness would jump with their number.
        let rate = rate.max(settings.min_sweeps as f32 / problem.longest);
        Self {
            substeps: substeps(sweeps(problem.dt), soft),
            substeps_per_rigid_sweep: soft,
            downwards,
            rate: rate.min(sweeps(problem.longest) as f32 / problem.longest),
        }
    }

    /// How many sweeps a step takes, rigid ones included.
    pub fn sweeps(&self) -> usize {
        self.substeps + self.substeps.div_ceil(self.substeps_per_rigid_sweep)
    }
}

/// How many substeps, with the rigid sweeps between them and the one that ends the step, make so many sweeps. At least one.
fn substeps(sweeps: usize, per_rigid_sweep: usize) -> usize {
    let round = per_rigid_sweep + 1;
    let rest = sweeps % round;
    (sweeps / round * per_rigid_sweep + rest.saturating_sub(1)).max(1)
}

/// The frequency that the springs of a structure must have, Hz, where this much is pressed (see [`LoadStatistics::pressed`]).
fn stable(problem: &PatchProblem, courses: &[Course], pressed: f32) -> f32 {
    let mut above = 0.0;
    let mut most = pressed;
    for course in courses.iter().rev() {
        above += course.mass;
        let load = problem.gravity.length() * above / course.bodies.max(1) as f32;
        most = most.max(load * course.yielding);
    }
    STABLE * FEW.max(courses.len() as f32) * most.sqrt()
}

/// The bodies of one level of support.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    bodies: usize,
    /// kg
    mass: f32,
    /// Of the one that gives way most among those that bear others, 1/(kg·m). A ball that leans on a wall does not carry the load of
    /// its course.
    yielding: f32,
}

/// From the ground up.
fn find_courses(problem: &PatchProblem, body_loads: &[BodyLoad], courses: &mut Vec<Course>) {
    courses.clear();
    let bodies = problem.bodies.iter().zip(body_loads);
    for (body, body_loads) in bodies.filter(|(body, _)| body.inverse_mass > 0.0) {
        let Some(course) = (body.level as usize).checked_sub(1) else {
            continue;
        };
        if courses.len() <= course {
            courses.resize(course + 1, Course::default());
        }
        let course = &mut courses[course];
        course.bodies += 1;
        course.mass += 1.0 / body.inverse_mass;
        if body_loads.bears {
            course.yielding = course.yielding.max(body_loads.yielding);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_counted_rigid_ones_included() {
        for per_rigid_sweep in [2, 3] {
            for sweeps in 2..50 {
                let substeps = substeps(sweeps, per_rigid_sweep);
                let taken = substeps + substeps.div_ceil(per_rigid_sweep);
                assert!(
                    (sweeps - 1..=sweeps).contains(&taken),
                    "{taken} of {sweeps}"
                );
            }
        }
    }
}
