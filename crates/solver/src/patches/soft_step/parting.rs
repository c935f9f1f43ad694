//! Parting: bodies that overlap deeply are moved apart by their positions, and gain no velocity.
//!
//! A spring corrects an overlap by a velocity, and bodies keep that velocity. This hardly matters where bodies rest, since they overlap by
//! less than a millimetre. But if three hundred balls are in one place, each pushes on its neighbours, and these on theirs: the outer balls
//! would leave with the sum of all velocities. So where bodies overlap by more than [`NEEDED_DEPTH`], springs see no more of an overlap
//! than [`SPRING_DEPTH`], and positions alone correct the rest: at the end of a step the bodies are moved apart at each deeper point, along
//! its normal, shared as an impulse would be. The sum of this and the motion of the step is no faster than the fastest correction.
//!
//! Bodies that are joined move as one and do not turn: each by itself, they would open their joints.

use super::gaps::Gaps;
use super::island::Island;
use crate::Both;
use crate::contact_row::{ContactRow, add_to};
use crate::lanes::{F32xN, State};
use crate::{Body, PatchConstraint, PatchProblem};
use glam::{Vec3, Vec4};

/// The depth from which on bodies are moved apart, m. Bodies that land hard in a heap come nearly as deep, and springs alone part them.
const NEEDED_DEPTH: f32 = 0.05;

/// The part of a depth that is left to springs in that case, m.
const SPRING_DEPTH: f32 = 0.02;

/// Number of visits to each point.
const VISITS: usize = 4;

/// Limit of the speed of a body, as a factor of the fastest correction, for a body that overlaps many others.
const MAX_SPEED_FACTOR: f32 = 1.5;

/// Limit of the rotation of a body in a step, rad: arms are not updated.
const MAX_TURN: f32 = 0.1;

/// Whether some bodies overlap by more than [`NEEDED_DEPTH`].
pub fn is_needed(gaps: &Gaps) -> bool {
    gaps.deepest < -NEEDED_DEPTH
}

/// The separation beyond which springs see no depth, m.
pub fn deepest(gaps: &Gaps) -> f32 {
    match is_needed(gaps) {
        true => -SPRING_DEPTH,
        false => f32::NEG_INFINITY,
    }
}

/// The bodies that move together with a body.
struct Movers {
    /// By body: itself, or the first body of its piece.
    first: Vec<usize>,
    /// By that body: the inverse mass of the piece, 1/kg.
    whole: Vec<Option<f32>>,
}

impl Movers {
    fn new<L: F32xN>(island: &Island<L>, all: &[Body]) -> Self {
        let bodies = all.len();
        let mut movers = Self {
            first: (0..bodies).collect(),
            whole: vec![None; bodies],
        };
        for (bodies, inverse_mass) in island.joints.wholes(all) {
            let mut first = None;
            for body in bodies {
                let first = *first.get_or_insert(body);
                movers.first[body] = first;
                movers.whole[first] = Some(inverse_mass);
            }
        }
        movers
    }

    /// Inverse effective mass against an impulse along a normal, 1/kg.
    fn response(&self, bodies: &[Body], mover: usize, normal: Vec3, arm: Vec3) -> f32 {
        self.whole[mover].unwrap_or_else(|| bodies[mover].response(normal, arm))
    }

    /// The motion by an impulse.
    fn answer(&self, bodies: &[Body], mover: usize, impulse: Vec3, arm: Vec3) -> [Vec3; 2] {
        match self.whole[mover] {
            Some(inverse_mass) => [inverse_mass * impulse, Vec3::ZERO],
            None => bodies[mover].answer(impulse, arm),
        }
    }
}

/// A point at which bodies are moved apart.
struct Deep {
    /// Its impulse is that of a motion, kg·m.
    row: ContactRow,
    /// Those that move for its bodies.
    bodies: [usize; 2],
    /// The motion that it still needs beyond its motion in this step, m.
    way: f32,
}

impl Deep {
    /// The deep points of a patch; each moves by at most `fastest` m in the step.
    fn of<'a>(
        problem: &'a PatchProblem,
        patch: &'a PatchConstraint,
        (movers, moved): (&'a Movers, &'a [State]),
        fastest: f32,
    ) -> impl Iterator<Item = Self> + 'a {
        let points = &problem.points[patch.range()];
        points.iter().filter_map(move |point| {
            let deep = -point.separation - SPRING_DEPTH;
            let bodies = patch.bodies.both(|body| body as usize);
            let arms = patch.arms.both(|arm| arm + point.offset);
            let ends = bodies.both(|body| movers.first[body]);
            let response =
                |side: usize| movers.response(problem.bodies, ends[side], patch.normal, arms[side]);
            let response = match ends[0] == ends[1] {
                true => 0.0,
                false => response(0) + response(1),
            };
            let row = ContactRow {
                direction: patch.normal,
                arms,
                response,
                impulse: 0.0,
            };
            let came = row.rate(bodies.both(|body| moved[body].both(Vec4::truncate)));
            (deep > 0.0 && response > 0.0).then(|| Self {
                row,
                bodies: ends,
                way: (deep.min(fastest) - came).min(fastest),
            })
        })
    }

    /// Moves both bodies so that the point moves as far as it needs.
    fn visit(&mut self, bodies: &[Body], movers: &Movers, motions: &mut [[Vec3; 2]]) {
        let lack = self.way - self.row.rate(self.bodies.both(|body| motions[body]));
        let change = self.row.add(lack / self.row.response, 0.0) * self.row.direction;
        for (side, change) in [change, -change].into_iter().enumerate() {
            let body = self.bodies[side];
            let answer = movers.answer(bodies, body, change, self.row.arms[side]);
            add_to(&mut motions[body], answer);
        }
    }
}

impl<L: F32xN> Island<L> {
    /// Moves bodies that overlap deeply apart, after all sweeps.
    pub fn part(&mut self, problem: &PatchProblem) {
        let fastest = problem.max_correction_speed * problem.dt;
        let patches = problem.patches.iter();
        let movers = Movers::new(self, problem.bodies);
        let given = (&movers, &*self.motions);
        let rows = patches.flat_map(|patch| Deep::of(problem, patch, given, fastest));
        let mut rows: Vec<Deep> = rows.collect();
        let mut motions = vec![[Vec3::ZERO; 2]; problem.bodies.len()];
        for _ in 0..VISITS {
            for row in &mut rows {
                row.visit(problem.bodies, &movers, &mut motions);
            }
        }
        for (motion, &first) in self.motions.iter_mut().zip(&movers.first) {
            let [linear, angular] = motions[first];
            motion[0] += linear
                .clamp_length_max(MAX_SPEED_FACTOR * fastest)
                .extend(0.0);
            motion[1] += angular.clamp_length_max(MAX_TURN).extend(0.0);
        }
    }
}
