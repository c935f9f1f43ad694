//! The rows of joints in a substep.

use super::member::Member;
use crate::solver::JointConstraint;
use crate::solver::joint::{Bend, Geometry, Law, Part, Times, is_angular, take_share};
use glam::Vec3;
use std::ops::Range;

/// How much stiffer the rows of joints are than springs of contacts.
const STIFFER: f32 = 1e5;

/// How much stiffer rows of motors and of friction are than that, which have no position to return to.
const DRIVEN: f32 = 1e3;

/// The share of its compliance by which a row of a section yields under a lasting force. Rows of joints yield with their whole compliance, and
/// return by errors of position; those of a section have none within the rounding of poses, and would creep. At this share, creep is below what
/// a pose can show, and what rounding puts into bonds that hold each other is gone after two seconds.
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
}

/// A row of a joint.
#[derive(Clone, Debug)]
pub struct Row {
    pub coordinate: usize,
    pub part: Part,
    /// Its joint lists the bodies in the order that is not that of the pair.
    pub is_reversed: bool,
    /// The coordinate now and at the last refresh, m or rad.
    value: f32,
    refreshed: f32,
    direction: Vec3,
    /// The rate of its coordinate is that of B's centre less that of A's along `linear`, and of their rotations along `angular`.
    pub linear: Vec3,
    pub angular: [Vec3; 2],
    pub law: Law,
    /// Compliance γ: deviation from the wanted rate per impulse.
    pub compliance: f32,
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
    /// Its place among the unknowns of its pair, if it has one in the factorized system.
    pub place: Option<usize>,
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
}

impl Row {
    pub fn new(coordinate: usize, part: Part, is_reversed: bool) -> Self {
        Self {
            coordinate,
            part,
            is_reversed,
            value: 0.0,
            refreshed: 0.0,
            direction: Vec3::ZERO,
            linear: Vec3::ZERO,
            angular: [Vec3::ZERO; 2],
            law: Law::default(),
            compliance: 0.0,
            response: 0.0,
            softness: 0.0,
            impulse: 0.0,
            late: 0.0,
            turned: 0.0,
            bound: Bound::Free,
            place: None,
            border: None,
            is_released: false,
            yields: 1.0,
            rounding: 0.0,
            lack: 0.0,
        }
    }

    pub fn is_released(&self) -> bool {
        self.is_released
    }

    pub fn is_angular(&self) -> bool {
        is_angular(self.coordinate)
    }

    /// Its row over the velocities of a side.
    pub fn numbers(&self, side: usize) -> [f64; 6] {
        let sign = if side == 0 { -1.0 } else { 1.0 };
        let [a, b] = [self.linear, self.angular[side]].map(|v| (sign * v).as_dvec3());
        [a.x, a.y, a.z, b.x, b.y, b.z]
    }

    /// Its rate for linear and angular velocities of A and B.
    pub fn rate(&self, [a, b]: [[Vec3; 2]; 2]) -> f32 {
        self.linear.dot(b[0] - a[0]) + (self.angular[1].dot(b[1]) - self.angular[0].dot(a[1]))
    }

    /// The push and the moment of an impulse on a side.
    pub fn wrench(&self, side: usize, impulse: f32) -> [Vec3; 2] {
        let impulse = if side == 0 { -impulse } else { impulse };
        [impulse * self.linear, impulse * self.angular[side]]
    }

    /// Whether it is solved for and has no place in the factorized system, or the other way round.
    pub fn is_moved(&self) -> bool {
        self.place.is_some() != (self.bound == Bound::Free)
    }

    /// Sets its direction from its coordinate.
    fn aim(&mut self, geometry: &Geometry, ends: [&Member; 2]) {
        let found = geometry.coordinate(self.coordinate);
        (self.value, self.refreshed) = (found.value, found.value);
        self.direction = found.direction;
        (self.linear, self.angular) = geometry.jacobian(self.coordinate, self.direction);
        let response = |side: usize| ends[side].response(self.linear, self.angular[side]);
        self.response = response(0) + response(1);
    }

    /// Takes over the direction of another row of its coordinate.
    fn aim_as(&mut self, other: &Self) {
        (self.value, self.refreshed) = (other.value, other.refreshed);
        self.direction = other.direction;
        (self.linear, self.angular) = (other.linear, other.angular);
        self.response = other.response;
    }

    /// Updates its law.
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
    }

    /// The change that brings its impulse to the bound that holds it.
    pub fn fixed_change(&self) -> f32 {
        let [low, high] = self.law.bounds;
        match self.bound {
            Bound::Free => 0.0,
            Bound::Low => low - self.impulse,
            Bound::High => high - self.impulse,
        }
    }

    /// Takes over a change of its impulse in a rigid sweep: how much of it is due to the turning of arms.
    pub fn count_late(&mut self, change: f32) {
        if self.lack != 0.0 {
            self.late += (self.turned / self.lack).abs().min(1.0) * change;
        }
    }

    /// Finds the rate that it lacks, from the velocities of A and B now and the bend of their way.
    pub fn find_lack(&mut self, soft: bool, h: f32, bend: &Bend, velocities: [[Vec3; 2]; 2]) {
        let mut wanted = self.law.rigid;
        if soft {
            wanted += self.correction();
        }
        if self.law.is_held {
            self.turned = h * bend.curvature(self.coordinate, self.direction);
            wanted -= bend.inward_rate(self.coordinate, self.direction, h);
        }
        if self.part != Part::Hold {
            wanted -= self.compliance * self.impulse;
        }
        self.lack = wanted - self.rate(velocities);
    }

    /// The rate that it asks for in a soft sweep and not in a rigid one: it corrects an error of position, and yields to its force.
    fn correction(&self) -> f32 {
        if self.part != Part::Hold {
            return 0.0;
        }
        let yielding = self.yields * self.compliance * self.impulse;
        let wanted = self.law.rate - self.law.rigid - yielding;
        wanted - wanted.clamp(-self.rounding, self.rounding)
    }
}

impl Row {
    /// Whether a solve would change nothing that counts, in a soft and in a rigid sweep, given what it lacks in one of them.
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
        }
    }

    /// Whether its directions are stale.
    pub fn is_stale(&self, members: &[Member]) -> bool {
        let [a, b] = self.motions(members);
        let turned = a[1].length_squared().max(b[1].length_squared());
        let [one, other] = self.ends.map(|end| members[end].bears_turn);
        let most = one.min(other);
        let Geometry { arms, gap, .. } = self.geometry;
        let moved = (b[0] + b[1].cross(arms[1])) - (a[0] + a[1].cross(arms[0]));
        let size = arms[0].length() + arms[1].length() + gap.length();
        turned > most * most || moved.length_squared() > (MOVED * size).powi(2)
    }

    /// The motions of A and B since the last refresh, m and rad.
    fn motions(&self, members: &[Member]) -> [[Vec3; 2]; 2] {
        [0, 1].map(|side| {
            let now = members[self.ends[side]].drifted;
            [0, 1].map(|i| now[i] - self.refreshed[side][i])
        })
    }

    /// Computes directions and coordinates.
    pub fn point(&mut self, joint: &JointConstraint, rows: &mut [Row], members: &[Member]) {
        let ends = self.ends.map(|end| &members[end]);
        self.geometry = Geometry::new(joint, ends.map(|end| end.placement));
        self.refreshed = ends.map(|end| end.drifted);
        let rows = &mut rows[self.rows.clone()];
        for i in 0..rows.len() {
            let (before, after) = rows.split_at_mut(i);
            match before.last() {
                Some(before) if before.coordinate == after[0].coordinate => {
                    after[0].aim_as(before);
                }
                _ => after[0].aim(&self.geometry, ends),
            }
        }
    }

    /// Updates coordinates along the directions of the last refresh.
    pub fn follow(&self, rows: &mut [Row], members: &[Member]) {
        let motions = self.motions(members);
        for row in &mut rows[self.rows.clone()] {
            row.value = row.refreshed + row.rate(motions);
        }
    }

    /// How far its bodies are from where it holds them: the coordinates, and angles times `size` (m), m.
    pub fn misfit(&self, rows: &[Row], size: f32) -> f32 {
        let rows = rows[self.rows.clone()].iter();
        let errors = rows.map(|row| match row.is_angular() {
            true => size * row.value.abs(),
            false => row.value.abs(),
        });
        errors.fold(0.0, f32::max)
    }

    /// Divides the forces of the joint among its rows, as impulses to begin with.
    pub fn start(&self, joint: &JointConstraint, rows: &mut [Row], times: &Times) {
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
    pub fn ask(&self, joint: &JointConstraint, rows: &mut [Row], times: &Times) {
        for row in &mut rows[self.rows.clone()] {
            row.ask(joint, times);
        }
    }

    /// Updates compliances; `stiffness` is b of the springs of contacts: their effective mass over their compliance.
    pub fn soften(&self, rows: &mut [Row], stiffness: f32) {
        for row in &mut rows[self.rows.clone()] {
            row.soften(stiffness);
        }
    }
}
