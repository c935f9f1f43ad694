//! The rows of joints in a substep.

use super::member::Member;
use crate::Both;
use crate::JointConstraint;
use crate::joint::{Bend, Geometry, Law, Part, Times, is_angular, take_share};
use glam::Vec3;
use std::ops::Range;

/// How much stiffer the rows of joints are than springs of contacts.
const STIFFER: f32 = 1e5;

/// How much stiffer rows of motors and of friction are than that, which have no position to return to.
const DRIVEN: f32 = 1e3;

/// The share of its compliance by which a row of a section yields under a lasting force. Rows of joints yield with their whole compliance,
/// and return by errors of position; those of a section have none within the rounding of poses, and would creep. At this share, creep is
/// below what a pose can show, and what rounding puts into bonds that hold each other is gone after two seconds.
const CREEP: f32 = 5e-4;

/// Directions are refreshed where anchors have moved against each other by more than this share of the arms.
const MOVED: f32 = 1e-4;

/// Rounding of the velocities that an impulse gives, as a share of them.
const ROUNDING: f32 = 1.0 / (1 << 24) as f32;

/// Which bound holds the impulse of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bound {
    /// None: the solve finds it.
    #[default]
    Free,
    Low,
    High,
}

/// The joints between bodies: a joint with its rows.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its index in the problem.
    pub joint: usize,
    /// Indices of A and B among the members.
    pub ends: [usize; 2],
    pub rows: Range<usize>,
    pub geometry: Geometry,
    /// The motions of A and B at the last refresh.
    refreshed: [[Vec3; 2]; 2],
    /// A motion of its anchors against each other by which directions become stale, m.
    bears_move: f32,
}

/// A row of a joint.
#[derive(Clone, Debug)]
pub struct JointRow {
    pub coordinate: usize,
    pub part: Part,
    /// The coordinate now and at the last refresh, m or rad.
    value: f32,
    refreshed: f32,
    /// The rate of its coordinate is the relative velocity of its bodies at the anchor of B along this, or their relative angular velocity.
    pub direction: Vec3,
    pub law: Law,
    /// Compliance γ: deviation from the wanted rate per impulse; and its inverse, or 0 if nothing yields to the row.
    pub compliance: f32,
    pub stiffness: f64,
    /// Inverse effective mass of its two bodies alone.
    pub response: f32,
    /// Its compliance in the scale of `response`, if it is a row of a section; else 0, and it is in proportion to `response`.
    pub softness: f32,
    pub impulse: f32,
    /// The part of it that the rigid sweep of this substep has added because arms have turned.
    pub late: f32,
    /// The rate that a substep of turning makes it lack, m/s.
    turned: f32,
    pub bound: Bound,
    /// It is a part of the factorized system.
    pub is_factorized: bool,
    /// Its border of that system, if it has one.
    pub border: Option<usize>,
    /// It holds nothing for the rest of the step.
    is_released: bool,
    /// The share of its compliance by which it yields under a lasting force.
    yields: f32,
    /// Corrections up to this rate are rounding of poses, m/s and rad/s.
    rounding: f32,
    /// The rate that it lacks in a visit, before the solve.
    pub lack: f32,
    /// The rate that it still lacks after the solve, apart from its own compliance.
    pub left: f64,
}

impl JointRow {
    pub fn new(coordinate: usize, part: Part) -> Self {
        Self {
            coordinate,
            part,
            value: 0.0,
            refreshed: 0.0,
            direction: Vec3::ZERO,
            law: Law::default(),
            compliance: 0.0,
            stiffness: 0.0,
            response: 0.0,
            softness: 0.0,
            impulse: 0.0,
            late: 0.0,
            turned: 0.0,
            bound: Bound::Free,
            is_factorized: false,
            border: None,
            is_released: false,
            yields: 1.0,
            rounding: 0.0,
            lack: 0.0,
            left: 0.0,
        }
    }

    pub fn is_released(&self) -> bool {
        self.is_released
    }

    #[inline]
    pub fn is_angular(&self) -> bool {
        is_angular(self.coordinate)
    }

    /// Its rate for the relative velocities of its bodies.
    #[inline]
    pub fn rate(&self, relative: &[Vec3; 2]) -> f32 {
        self.direction.dot(relative[usize::from(self.is_angular())])
    }

    /// Whether it is solved for and not a part of the factorized system, or the other way round.
    #[inline]
    pub fn is_moved(&self) -> bool {
        self.stiffness > 0.0 && self.is_factorized != (self.bound == Bound::Free)
    }

    /// The change of its impulse, if a bound holds it.
    #[inline]
    pub fn given_change(&self) -> Option<f64> {
        (self.bound != Bound::Free).then(|| self.fixed_change() as f64)
    }

    /// The change of its impulse in the solve.
    #[inline]
    pub fn change(&self) -> f32 {
        match self.bound {
            Bound::Free => (self.left * self.stiffness) as f32,
            _ => self.fixed_change(),
        }
    }

    /// Sets its direction from its coordinate.
    #[inline]
    fn aim(&mut self, geometry: &Geometry) {
        let found = geometry.coordinate(self.coordinate);
        (self.value, self.refreshed) = (found.value, found.value);
        self.direction = found.direction;
    }

    /// Finds the inverse effective mass of its bodies.
    fn find_response(&mut self, geometry: &Geometry, ends: [&Member; 2]) {
        let (linear, angular) = geometry.jacobian(self.coordinate, self.direction);
        let response = |side: usize| ends[side].response(linear, angular[side]);
        self.response = response(0) + response(1);
    }

    /// Takes over the direction of another row of its coordinate.
    fn aim_as(&mut self, other: &Self) {
        (self.value, self.refreshed) = (other.value, other.refreshed);
        self.direction = other.direction;
    }

    /// Updates its law.
    #[inline]
    fn ask(&mut self, joint: &JointConstraint, times: &Times) {
        let before = self.law.bounds;
        // Within a step, nothing of the law of friction changes, and of a locked coordinate only the rate.
        match self.part {
            Part::Friction if before[1] > 0.0 => return,
            Part::Hold if before == [f32::NEG_INFINITY, f32::INFINITY] => {
                let least = joint.axis(self.coordinate).limits[0];
                self.law.rate = times.back(self.error(joint) - least);
                return;
            }
            _ => {}
        }
        let axis = joint.axis(self.coordinate);
        self.law = Law::of(axis, self.part, self.error(joint), times);
        match joint.section {
            Some(_) => self.yields = CREEP,
            None => self.rounding = times.bias_rate * joint.slack[usize::from(self.is_angular())],
        }
        if self.is_released {
            self.law.bounds = [0.0; 2];
        }
        let [low, high] = self.law.bounds;
        if before == [low, high] {
            return;
        }
        self.impulse = self.impulse.clamp(low, high);
        self.bound = if self.impulse == low {
            Bound::Low
        } else if self.impulse == high {
            Bound::High
        } else {
            Bound::Free
        };
    }

    /// Lets go for the rest of the step.
    pub fn release(&mut self) {
        (self.is_released, self.bound) = (true, Bound::Low);
        (self.impulse, self.law.bounds) = (0.0, [0.0; 2]);
    }

    /// The coordinate, beyond the rounding of poses.
    #[inline]
    fn error(&self, joint: &JointConstraint) -> f32 {
        match joint.section {
            Some(_) => {
                let slack = joint.slack[usize::from(self.is_angular())];
                self.value - self.value.clamp(-slack, slack)
            }
            None => self.value,
        }
    }

    /// Sets its compliance.
    fn soften(&mut self, stiffness: f32) {
        let softness = match self.softness > 0.0 {
            true => self.softness,
            false => self.response,
        };
        let least = softness.max(f32::MIN_POSITIVE) / (STIFFER * stiffness);
        self.compliance = match self.part {
            Part::Hold => least,
            _ => self.law.compliance.max(least / DRIVEN),
        };
        // A row between bodies that do not yield to it has no part in the solve.
        self.stiffness = match softness > 0.0 {
            true => 1.0 / self.compliance as f64,
            false => 0.0,
        };
    }

    /// The change that brings its impulse to the bound that holds it.
    #[inline]
    pub fn fixed_change(&self) -> f32 {
        let [low, high] = self.law.bounds;
        match self.bound {
            Bound::Free => 0.0,
            Bound::Low => low - self.impulse,
            Bound::High => high - self.impulse,
        }
    }

    /// Takes over a change of its impulse in a rigid sweep: how much of it is due to the turning of arms.
    #[inline]
    pub fn count_late(&mut self, change: f32) {
        if self.lack != 0.0 {
            self.late += (self.turned / self.lack).abs().min(1.0) * change;
        }
    }

    /// Finds the rate that it lacks, from the relative velocities of its bodies now and the bend of their way.
    #[inline]
    pub fn find_lack(&mut self, soft: bool, h: f32, bend: &Bend, relative: &[Vec3; 2]) {
        let mut wanted = self.law.rigid;
        if soft {
            wanted += self.correction();
        }
        if self.law.is_held {
            let curvature = bend.curvature(self.coordinate, self.direction);
            self.turned = h * curvature;
            wanted -= Bend::inward_rate(curvature, h);
        }
        if self.part != Part::Hold {
            wanted -= self.compliance * self.impulse;
        }
        self.lack = wanted - self.rate(relative);
    }

    /// The rate that it asks for in a soft sweep and not in a rigid one: it corrects an error of position, and yields to its force.
    #[inline]
    fn correction(&self) -> f32 {
        if self.part != Part::Hold {
            return 0.0;
        }
        let yielding = self.yields * self.compliance * self.impulse;
        let wanted = self.law.rate - self.law.rigid - yielding;
        wanted - wanted.clamp(-self.rounding, self.rounding)
    }
}

impl JointRow {
    /// Whether a solve would change nothing that counts, in a soft and in a rigid sweep, given what it lacks in one of them.
    #[inline]
    pub fn is_content(&self, soft: bool, slack: f32) -> bool {
        let slack = slack + ROUNDING * self.response * self.impulse.abs();
        let between = self.correction();
        let other = match soft {
            true => self.lack - between,
            false => self.lack + between,
        };
        match self.bound {
            Bound::Free => self.lack.abs() < slack && other.abs() < slack,
            _ if self.fixed_change() != 0.0 => false,
            Bound::Low => self.lack.max(other) < slack,
            Bound::High => self.lack.min(other) > -slack,
        }
    }
}

impl Link {
    pub fn new(joint: usize, ends: [usize; 2], rows: Range<usize>, geometry: Geometry) -> Self {
        Self {
            joint,
            ends,
            rows,
            geometry,
            refreshed: [[Vec3::ZERO; 2]; 2],
            bears_move: 0.0,
        }
    }

    /// Whether its directions are stale.
    #[inline]
    pub fn is_stale(&self, members: &[Member]) -> bool {
        let [a, b] = self.motions(members);
        let turned = a[1].length_squared().max(b[1].length_squared());
        let [one, other] = self.ends.both(|end| members[end].bears_turn);
        let most = one.min(other);
        let [moved, _] = self.relative([a, b]);
        turned > most * most || moved.length_squared() > self.bears_move * self.bears_move
    }

    /// The motions of A and B since the last refresh, m and rad.
    #[inline]
    fn motions(&self, members: &[Member]) -> [[Vec3; 2]; 2] {
        [0, 1].both(|side| {
            let now = members[self.ends[side]].drifted;
            [0, 1].both(|i| now[i] - self.refreshed[side][i])
        })
    }

    /// The angles with which the next step goes on.
    pub fn angles(&self, joint: &JointConstraint, members: &[Member]) -> Option<Vec3> {
        match self.geometry.hinge() {
            Some(_) => {
                let placements = self.ends.both(|end| members[end].placement);
                Geometry::new(joint, placements).angles()
            }
            // A joint that slowly turns further than since the last refresh still knows its turns.
            None => joint.angles,
        }
    }

    /// Computes directions and coordinates.
    pub fn point(
        &mut self,
        joint: &mut JointConstraint,
        rows: &mut [JointRow],
        members: &[Member],
    ) {
        let ends = self.ends.both(|end| &members[end]);
        self.geometry = Geometry::new(joint, ends.both(|end| end.placement));
        joint.angles = self.geometry.angles();
        self.refreshed = ends.both(|end| end.drifted);
        let Geometry { arms, gap, .. } = self.geometry;
        self.bears_move = MOVED * (arms[0].length() + arms[1].length() + gap.length());
        let rows = &mut rows[self.rows.clone()];
        for i in 0..rows.len() {
            let (before, after) = rows.split_at_mut(i);
            match before.last() {
                Some(before) if before.coordinate == after[0].coordinate => {
                    after[0].aim_as(before);
                }
                _ => after[0].aim(&self.geometry),
            }
        }
    }

    /// Finds the inverse effective masses of its rows. They give rows their compliances, which stay for a step.
    pub fn find_responses(&self, rows: &mut [JointRow], members: &[Member]) {
        let ends = self.ends.both(|end| &members[end]);
        for row in &mut rows[self.rows.clone()] {
            row.find_response(&self.geometry, ends);
        }
    }

    /// Updates coordinates along the directions of the last refresh.
    #[inline]
    pub fn follow(&self, rows: &mut [JointRow], members: &[Member]) {
        let relative = self.relative(self.motions(members));
        for row in &mut rows[self.rows.clone()] {
            row.value = row.refreshed + row.rate(&relative);
        }
    }

    /// The velocity of B relative to A at the anchor of B, and the relative angular velocity, for velocities of A and B.
    #[inline]
    pub fn relative(&self, [a, b]: [[Vec3; 2]; 2]) -> [Vec3; 2] {
        let arms = self.geometry.arms;
        [
            (b[0] + b[1].cross(arms[1])) - (a[0] + a[1].cross(arms[0])),
            b[1] - a[1],
        ]
    }

    /// The impulse and the angular impulse of its rows on B, at the anchor of B.
    #[inline]
    pub fn impulse(&self, rows: &[JointRow]) -> [Vec3; 2] {
        let mut sums = [Vec3::ZERO; 2];
        for row in &rows[self.rows.clone()] {
            sums[usize::from(row.is_angular())] += row.impulse * row.direction;
        }
        sums
    }

    /// The push and the moment on a side, of an impulse and an angular impulse on B at the anchor of B.
    #[inline]
    pub fn wrench(&self, side: usize, [push, turn]: [Vec3; 2]) -> [Vec3; 2] {
        let moment = self.geometry.arms[side].cross(push) + turn;
        match side {
            0 => [-push, -moment],
            _ => [push, moment],
        }
    }

    /// How far its bodies are from where it holds them: the coordinates, and angles times `size` (m), m.
    pub fn misfit(&self, rows: &[JointRow], size: f32) -> f32 {
        let rows = rows[self.rows.clone()].iter();
        let errors = rows.map(|row| match row.is_angular() {
            true => size * row.value.abs(),
            false => row.value.abs(),
        });
        errors.fold(0.0, f32::max)
    }

    /// Divides the forces of the joint among its rows, as impulses to begin with.
    pub fn start(&self, joint: &JointConstraint, rows: &mut [JointRow], times: &Times) {
        let mut left = joint.forces.map(|force| times.h * force);
        let rows = &mut rows[self.rows.clone()];
        for i in 0..rows.len() {
            let number = rows[i].coordinate;
            let is_last = rows.get(i + 1).is_none_or(|next| next.coordinate != number);
            let row = &mut rows[i];
            let law = Law::of(joint.axis(number), row.part, row.value, times);
            row.impulse = take_share(&mut left[number], &law, is_last);
        }
    }

    /// Updates laws.
    pub fn ask(&self, joint: &JointConstraint, rows: &mut [JointRow], times: &Times) {
        for row in &mut rows[self.rows.clone()] {
            row.ask(joint, times);
        }
    }

    /// Updates compliances; `stiffness` is b of the springs of contacts: their effective mass over their compliance.
    pub fn soften(&self, rows: &mut [JointRow], stiffness: f32) {
        for row in &mut rows[self.rows.clone()] {
            row.soften(stiffness);
        }
    }
}
