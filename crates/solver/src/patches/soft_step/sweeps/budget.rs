//! The number of sweeps in a step, and the stiffness of springs that it allows.
//!
//! The stiffness of springs follows the rate of sweeps ([`SoftStep::sweeps_per_period`]). The stiffness that is needed depends on the
//! structure and not on the step: like Euler's column, a column on springs buckles below a frequency that grows with its courses and with
//! √(load / (mass · size)). So sweeps come at a rate, and a long step has more of them. The rate follows the shape of the structure and its
//! loads at rest. A rate that followed the current impulses would amplify their shaking. In piles it also follows the mean speed, because
//! piles do not sway as walls and towers do.

use super::load_statistics::{BodyLoad, LoadStatistics};
use crate::PatchProblem;
use crate::patches::soft_step::SoftStep;

/// Number of substeps per rigid sweep: the usual one, and the one for at least [`TALL_COURSES`] courses. Soft sweeps let disturbances grow
/// from course to course: a pyramid of 100 trembles by 50 mm/s with three, and one of 50 by 2; of 20 it is steadier with three.
const SUBSTEPS_PER_RIGID_SWEEP: usize = 3;
const TALL_COURSES: usize = 40;
const SUBSTEPS_PER_RIGID_SWEEP_IF_TALL: usize = 2;

/// Number of courses from which on rigid sweeps go down.
///
/// A sweep up passes its changes on to all bodies above, and to one course below. With velocities extrapolated from substep to substep, a
/// change that travels down therefore grows from course to course where bodies stand on several others: in a linear model (walls of 60 and
/// 120 courses) by e¹¹ and e²⁶ before it leaves, so that rounding lets a tower of planks of 60 layers tremble by 11 mm/s. A sweep down
/// before the next substep limits this growth to e¹ and e¹·⁵. Walls of 50 courses are steady without it, and only sweeps that go up can be
/// pipelined.
const VERY_TALL_COURSES: usize = 52;

/// Contacts per body from which on rigid sweeps may go down. Nothing grows in a single column, which stands better with sweeps that go up.
const BRANCHED_CONTACTS: f32 = 1.5;

/// The smallest frequency of springs, Hz, as a factor of courses · √(load / (mass · size)), SI units. With it a column of 100 cubes under a
/// noise of ±2 mm stands, now that it starts in equilibrium; before, it needed twice as much.
const STABLE_FREQUENCY: f32 = 0.02;

/// Structures with fewer courses count as having this many: a cube under a thousand of its weight needs as much as a tower.
const MIN_COURSES: f32 = 24.0;

/// Additional sweeps for structures that are not settled, as a share of the usual rate.
const UNSETTLED_SWEEPS: f32 = 0.5;

/// Share of new load from which on a structure counts as fully unsettled. Piles of round bodies always do, since they have no loads at
/// rest. When a tenth more did not count yet, arches slid 3 % before their limits.
const NEW_LOAD_SHARE: f32 = 0.25;

/// The rate of sweeps in a pile that has come to a stop, as a factor of that of masonry. With the rate of masonry, wedged bodies creep at
/// the limit of friction, and fewer than half of the piles of rubble sleep within 20 s; with this rate they sleep after 5 s in the mean.
const PILE_RATE_FACTOR: f32 = 4.0;

/// The shares of edges and corners among contacts ([`LoadStatistics::edges`]) from which on a structure counts as a pile in part, and in
/// full. Masonry has next to none, a pile more than half. More sweeps for slow masonry would feed its sway.
const PILE_EDGES: [f32; 2] = [0.03, 0.2];

/// The mean speed at which a pile has half of its additional sweeps, m/s. A pile that falls needs none.
const PILE_SPEED: f32 = 0.1;

/// Upper bound of the rate of sweeps, as a factor of the usual rate, before the additional sweeps of piles and of effort.
const MAX_RATE_FACTOR: f32 = 4.0;

/// A step gets another round only if it is longer by more than this share of a round.
const ROUND_SLACK: f32 = 0.1;

/// The sweeps of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepBudget {
    /// Number of substeps; each has one soft sweep.
    pub substeps: usize,
    /// Number of substeps per rigid sweep.
    pub substeps_per_rigid_sweep: usize,
    /// Rigid sweeps go from the last contact to the first.
    pub downwards: bool,
    /// The rate of sweeps that sets the stiffness of springs, 1/s.
    pub rate: f32,
    /// Number of sweeps by which loads at rest follow. A step that is far shorter than the longest recent one has its least number of
    /// sweeps in nearly no time: its forces are the velocities that it stopped, over that time. If loads followed them at once, the next
    /// long step would give these velocities back many times.
    pub followed: f32,
}

impl SweepBudget {
    /// The parts of the budget that decide which sweeps follow each other: all but the rate. Equal plans have equal sweeps.
    pub fn plan(&self) -> (usize, usize, bool) {
        (self.substeps, self.substeps_per_rigid_sweep, self.downwards)
    }

    /// The budget for a problem with its warm-start impulses.
    pub fn new(
        settings: &SoftStep,
        problem: &PatchProblem,
        (statistics, body_loads): (&LoadStatistics, &[BodyLoad]),
        courses: &mut Vec<Course>,
    ) -> Self {
        find_courses(problem, body_loads, courses);
        let courses = &*courses;
        let bodies: usize = courses.iter().map(|course| course.bodies).sum();
        let downwards = courses.len() >= VERY_TALL_COURSES
            && problem.patches.len() as f32 > BRANCHED_CONTACTS * bodies as f32;
        // Joints are solved directly, however many bodies hang on each other.
        let hangs = problem.patches.is_empty() && !problem.joints.is_empty();
        let soft = match courses.len() {
            TALL_COURSES.. if !downwards && !hangs => SUBSTEPS_PER_RIGID_SWEEP_IF_TALL,
            _ => SUBSTEPS_PER_RIGID_SWEEP,
        };
        let round = soft + 1;
        let usual = round as f32 / (soft as f32 * settings.max_substep);
        let most = MAX_RATE_FACTOR * usual;
        let &LoadStatistics {
            unsettled, pressed, ..
        } = statistics;
        let usual = usual * (1.0 + UNSETTLED_SWEEPS * (unsettled / NEW_LOAD_SHARE).min(1.0));
        let rate = (settings.sweeps_per_period * stable(problem, courses, pressed))
            .clamp(usual, most)
            * problem.effort
            * pile(statistics, problem);
        let sweeps = |seconds: f32| {
            let rounds = (rate * seconds / round as f32 - ROUND_SLACK).ceil() as usize;
            (rounds * round)
                .max(settings.min_sweeps)
                .min(settings.max_sweeps)
        };
        let [now, longest] = [problem.dt, problem.max_recent_dt].map(|dt| {
            let substeps = substeps(sweeps(dt), soft);
            (substeps, substeps + substeps.div_ceil(soft))
        });
        // This is not the rate of whole rounds, or stiffness would jump with their number.
        let rate = rate.max(settings.min_sweeps as f32 / problem.max_recent_dt);
        Self {
            substeps: now.0,
            substeps_per_rigid_sweep: soft,
            downwards,
            rate: rate.min(sweeps(problem.max_recent_dt) as f32 / problem.max_recent_dt),
            followed: (now.1 as f32).min(longest.1 as f32 * (problem.dt / problem.max_recent_dt)),
        }
    }
}

/// The rate of sweeps as a factor of that of masonry: 1 to [`PILE_RATE_FACTOR`] for a pile. The additional sweeps let piles sleep, so only
/// worlds in which bodies may sleep have them; in others every step would take 1.15 to 1.6 times as long.
fn pile(statistics: &LoadStatistics, problem: &PatchProblem) -> f32 {
    let [none, all] = PILE_EDGES;
    if problem.stays_awake || statistics.edges <= none {
        return 1.0;
    }
    let pile = ((statistics.edges - none) / (all - none)).min(1.0);
    let speed = mean_speed(problem) / PILE_SPEED;
    1.0 + (PILE_RATE_FACTOR - 1.0) * pile / (1.0 + speed * speed)
}

/// The mean speed of the bodies that move, m/s.
fn mean_speed(problem: &PatchProblem) -> f32 {
    let moving = problem.bodies.iter().filter(|body| body.inverse_mass > 0.0);
    let (mut sum, mut count) = (0.0, 0);
    for body in moving {
        sum += body.start[0].length();
        count += 1;
    }
    sum / count.max(1) as f32
}

/// Number of substeps that, with the rigid sweeps between them and the one that ends the step, make `sweeps` sweeps; at least one.
fn substeps(sweeps: usize, per_rigid_sweep: usize) -> usize {
    let round = per_rigid_sweep + 1;
    let rest = sweeps % round;
    (sweeps / round * per_rigid_sweep + rest.saturating_sub(1)).max(1)
}

/// The smallest frequency of the springs of a structure, Hz; for `pressed`, see [`LoadStatistics::pressed`].
fn stable(problem: &PatchProblem, courses: &[Course], pressed: f32) -> f32 {
    let mut above = 0.0;
    let mut most = pressed;
    for course in courses.iter().rev() {
        above += course.mass;
        let load = problem.gravity.length() * above / course.bodies.max(1) as f32;
        most = most.max(load * course.yielding);
    }
    STABLE_FREQUENCY * MIN_COURSES.max(courses.len() as f32) * most.sqrt()
}

/// The bodies of one level of support.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    bodies: usize,
    /// Total mass, kg.
    mass: f32,
    /// The largest [`BodyLoad::yielding`] among the bodies that support others, 1/(kg·m). A ball that leans on a wall does not carry the
    /// load of its course.
    yielding: f32,
}

/// Finds the courses of bodies that move, from the ground up.
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
    // Bodies that sleep below those that woke hold them as the ground does.
    courses.retain(|course| course.bodies > 0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Memory;
    use crate::patches::soft_step::masonry::Masonry;
    use glam::Vec3;

    /// The budget of a wall of 8 courses that stands on so many courses that sleep.
    fn on(sleeping: u32) -> SweepBudget {
        let mut wall = Masonry::wall(10, 8, 0.0).shaken();
        for (body, at) in wall.bodies.iter_mut().zip(&wall.centers).skip(1) {
            // A course is half a metre high.
            body.level = sleeping + 1 + (2.0 * at.y) as u32;
        }
        let mut memory = Memory::default();
        let mut body_loads = Vec::new();
        let problem = wall.problem(&mut memory);
        let statistics = LoadStatistics::of(&problem, &mut body_loads);
        let loads = (&statistics, &*body_loads);
        SweepBudget::new(&SoftStep::default(), &problem, loads, &mut Vec::new())
    }

    #[test]
    fn courses_that_sleep_below_do_not_make_a_structure_taller() {
        assert_eq!(on(100), on(0));
    }

    /// The rate of sweeps of a wall whose bricks move at this speed, m/s. Its first contacts, `edges` of them, are edges instead of faces.
    fn rate(edges: usize, speed: f32, stays_awake: bool) -> f32 {
        let mut wall = Masonry::wall(10, 8, 0.0);
        for body in &mut wall.bodies[1..] {
            body.start[0] = speed * Vec3::X;
        }
        for patch in &mut wall.patches[..edges] {
            patch.count = 2;
        }
        for point in &mut wall.points {
            (point.normal_impulse, point.rest_impulse) = (5.0, 5.0);
        }
        let mut memory = Memory::default();
        let mut body_loads = Vec::new();
        let mut problem = wall.problem(&mut memory);
        problem.stays_awake = stays_awake;
        let statistics = LoadStatistics::of(&problem, &mut body_loads);
        let loads = (&statistics, &*body_loads);
        SweepBudget::new(&SoftStep::default(), &problem, loads, &mut Vec::new()).rate
    }

    #[test]
    fn piles_that_have_stopped_have_more_sweeps() {
        let masonry = rate(0, 0.0, false);
        assert_eq!(rate(4, 0.0, false), masonry, "a few edges");
        assert_eq!(rate(60, 0.0, true), masonry, "a world without sleeping");
        let pile = rate(60, 0.0, false) / masonry;
        assert_eq!(pile, PILE_RATE_FACTOR);
        let slow = rate(60, PILE_SPEED, false) / masonry;
        assert!(
            (slow - 0.5 * (1.0 + PILE_RATE_FACTOR)).abs() < 1e-3,
            "{slow}"
        );
        let falling = rate(60, 3.0, false) / masonry;
        assert!(falling < 1.01, "{falling}");
    }

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
