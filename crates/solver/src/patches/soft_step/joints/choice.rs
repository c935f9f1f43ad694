//! Which pieces are [swept](super::swept), and which are solved directly.
//!
//! Sweeps suffice where no body carries many times its own weight: a ragdoll that falls, and not a chain with a ball at its end. A *strain*
//! says how much a body carries: the sum of the forces of its joints and contacts, over the force that accelerates it or its weight. A link
//! of a chain under a hundred times its weight has a strain of two hundred.
//!
//! Nets, with many more joints than bodies, are always swept, since their factorization fills up.

use super::Joints;
use super::piece::Piece;
use crate::body::trace;
use crate::joint::COORDINATES;
use crate::{Body, Both, JointAxis, JointConstraint, PatchProblem};
use glam::Vec3;

/// Pieces with a strain of at most this are swept.
const MAX_STRAIN: f32 = 40.0;

/// Pieces with more loops of bodies than this are nets.
const NET_LOOPS: usize = 24;

/// Bodies that turn further than this in a step are solved directly, rad: rotations are counted from the beginning of the step.
const MAX_TURN: f32 = 1.5;

/// Smaller pieces are solved directly, which costs little.
const MIN_MEMBERS: usize = 8;

/// Ratio of the masses of two jointed bodies.
const MAX_MASS_RATIO: f32 = 30.0;

/// How much easier a push at an anchor turns a body than it moves it: an anchor a hundred radii of gyration away leaves single precision
/// no digits for the translation.
const MAX_LEVER: f32 = 1000.0;

/// The weight of bodies without gravity, m/s².
const LEAST_GRAVITY: f32 = 1.0;

/// The forces on a body: the sum of their sizes, and their sum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Strain {
    sizes: f32,
    sum: Vec3,
}

impl Strain {
    fn add_moment(&mut self, moment: f32, arm: f32) {
        self.sizes += moment / arm.max(f32::MIN_POSITIVE);
    }

    fn add(&mut self, force: Vec3) {
        self.sizes += force.length();
        self.sum += force;
    }
}

/// Whether sweeps can hold a joint.
fn can_be_swept(joint: &JointConstraint) -> bool {
    let [x, y, z, turns @ ..] = &joint.axes;
    joint.section.is_none()
        && joint.distance.is_none()
        && [x, y, z].into_iter().all(|axis| *axis == JointAxis::LOCKED)
        && turns.iter().all(|axis| axis.motor.is_none())
        // Bodies that joints fix to each other are structures, which bend like beams.
        && turns.iter().any(|axis| !axis.is_locked())
}

/// Whether its bodies are of similar masses, and its anchors near them.
fn is_well_conditioned(joint: &JointConstraint, bodies: &[Body]) -> bool {
    let bodies = joint.bodies.both(|body| &bodies[body as usize]);
    let [a, b] = bodies.both(|body| body.inverse_mass);
    let is_near = |side: usize| {
        let lever = joint.arms[side].length_squared() * trace(&bodies[side].inverse_inertia);
        lever <= MAX_LEVER * bodies[side].inverse_mass
    };
    let is_alike = a <= MAX_MASS_RATIO * b && b <= MAX_MASS_RATIO * a || a == 0.0 || b == 0.0;
    is_alike && is_near(0) && is_near(1)
}

/// Whether something limits or slows its free rotations. Chains, bridges of planks and doors swing freely, which shows what energy they
/// lose.
fn is_limited(joint: &JointConstraint) -> bool {
    let mut turns = joint.axes[3..].iter();
    joint.swing.is_some() || turns.any(|axis| *axis != JointAxis::FREE && !axis.is_locked())
}

impl Piece {
    /// Whether it has so many loops that a factorization would fill up.
    fn is_net(&self) -> bool {
        self.loops > NET_LOOPS
    }
}

impl Joints {
    /// Finds which pieces are swept in this step.
    pub fn choose(&mut self, problem: &PatchProblem, may_sweep: bool) {
        if may_sweep {
            self.find_strains(problem);
        }
        let mut has_changed = false;
        for number in 0..self.pieces.len() {
            let is_swept = may_sweep && self.suits(number, problem);
            has_changed |=
                std::mem::replace(&mut self.pieces[number].is_swept, is_swept) != is_swept;
        }
        self.has_new_swept = has_changed;
        if has_changed {
            self.swept.clear();
            let pieces = self.pieces.iter().filter(|piece| piece.is_swept);
            let links = pieces.flat_map(|piece| &self.links[piece.links.clone()]);
            self.swept.extend(links.map(|link| link.joint as u32));
            crate::sort::values(&mut self.swept);
        }
    }

    /// Whether a joint belongs to a net.
    pub fn is_in_net(&self, joint: &JointConstraint) -> bool {
        let members = joint.bodies.both(|body| self.member_of[body as usize]);
        let member = members[0].min(members[1]) as usize;
        let piece = self
            .pieces
            .partition_point(|piece| piece.members.end <= member);
        self.pieces[piece].is_net()
    }

    /// Whether the swept joints or their bodies are others than in the last step. Pieces that were found anew are swept for the first time.
    pub fn has_new_swept(&self) -> bool {
        self.has_new_swept
    }

    /// The swept joints, by index in the problem.
    pub fn swept(&self) -> &[u32] {
        &self.swept
    }

    fn find_strains(&mut self, problem: &PatchProblem) {
        self.strains.clear();
        self.strains.resize(problem.bodies.len(), Strain::default());
        for joint in &*problem.joints {
            let [x, y, z, ..] = joint.forces;
            let force = joint.frames[0] * Vec3::new(x, y, z);
            let [a, b] = joint.bodies.both(|body| body as usize);
            self.strains[a].add(-force);
            self.strains[b].add(force);
            let [.., x, y, z, _, swing] = joint.forces;
            let moment = Vec3::new(x, y, z).length() + swing.abs();
            if moment > 0.0 {
                let [own, other] = joint.arms.both(Vec3::length);
                self.strains[a].add_moment(moment, own);
                self.strains[b].add_moment(moment, other);
            }
        }
        for patch in &*problem.patches {
            let [a, b] = patch.bodies.both(|body| body as usize);
            if !self.hold(a) && !self.hold(b) {
                continue;
            }
            let points = problem.points[patch.range()].iter();
            let impulse: f32 = points.map(|point| point.normal_impulse).sum();
            let force = impulse / problem.dt * patch.normal;
            self.strains[a].add(force);
            self.strains[b].add(-force);
        }
    }

    fn suits(&self, number: usize, problem: &PatchProblem) -> bool {
        let piece = &self.pieces[number];
        let links = &self.links[piece.links.clone()];
        let joints = || links.iter().map(|link| &problem.joints[link.joint]);
        let members = || {
            let members = self.members[piece.members.clone()].iter();
            members.map(|member| member.body as usize)
        };
        let can_turn = members().all(|body| {
            let body = &problem.bodies[body];
            let turn = body.angular.length() * problem.dt;
            body.free_axes == Vec3::ONE && turn < MAX_TURN
        });
        if !can_turn || !joints().all(can_be_swept) {
            return false;
        }
        if !joints().all(|joint| is_well_conditioned(joint, problem.bodies)) {
            return false;
        }
        if piece.is_net() {
            return true;
        }
        if piece.members.len() < MIN_MEMBERS || !joints().all(is_limited) {
            return false;
        }
        let is_new = joints().all(|joint| joint.forces == [0.0; COORDINATES]);
        let gravity = problem.gravity.length().max(LEAST_GRAVITY);
        !is_new
            && members().all(|body| {
                let weight = gravity / problem.bodies[body].inverse_mass;
                let Strain { sizes, sum } = self.strains[body];
                sizes <= MAX_STRAIN * weight.max(sum.length())
            })
    }
}

/// The number of loops of bodies in a piece: of pairs of bodies that joints connect, more than a tree has.
pub fn loops(members: usize, edges: &mut Vec<[usize; 2]>) -> usize {
    for edge in &mut *edges {
        *edge = [edge[0].min(edge[1]), edge[0].max(edge[1])];
    }
    crate::sort::by_key(edges, |&[a, b]| (a, b));
    edges.dedup();
    (edges.len() + 1).saturating_sub(members)
}
