//! One thing that a game does, as a value that can be printed and done again.

use crate::dice::Dice;
use crate::part::{KINDS, Part};
use crate::shape::Shape;
use drystone::body::RigidBody;
use drystone::settings::{
    AnchorRule, Classifier, ContactSolver, FrictionStabilization, NarrowphaseSettings,
    NormalStabilization, SleepSettings, SolverSettings, SpeedLimits, StabilizationSettings, Waking,
};
use drystone::solver::{FrictionCone, Lanes, Nncg, Pgs, SoftStep};
use glam::{Quat, Vec3};

/// An operation, and whether one of its numbers is bad.
#[derive(Clone, Debug)]
pub struct Act {
    pub operation: Operation,
    pub bad: bool,
}

/// Bodies and pairs are counted through; a number beyond the last begins anew.
#[derive(Clone, Debug)]
pub enum Operation {
    Step(f32),
    Spawn(Spawn),
    Despawn(usize),
    Clone(usize),
    DespawnPair(usize),
    /// Takes one component off a pair.
    StripPair(usize, usize),
    MoveTransform(usize, Vec3, Quat),
    MovePose(usize, Vec3, Quat),
    Insert(usize, Part),
    Remove(usize, Part),
    Touch(usize, Part),
    /// Takes off what every body has.
    Bare(usize, usize),
    /// Takes all components off.
    Clear(usize),
    /// Puts a body below another.
    Adopt(usize, usize),
    Orphan(usize),
    /// Takes bad numbers off, and the body out of quarantine.
    Mend(usize),
    /// Despawns all bodies and pairs at once.
    Reset,
    Gravity(Vec3),
    Solver(Solver),
    Stabilization(Box<StabilizationSettings>),
    Narrowphase(NarrowphaseSettings),
    Sleep(SleepSettings),
    Speeds(SpeedLimits),
    /// Takes one of the settings away.
    Forget(usize),
    /// All settings as they were.
    Defaults,
}

#[derive(Clone, Debug)]
pub struct Spawn {
    pub kind: RigidBody,
    pub shape: Shape,
    pub at: Vec3,
    pub turn: Quat,
    pub asleep: bool,
}

#[derive(Clone, Debug)]
pub struct Solver {
    method: Method,
    iterations: usize,
    substeps: usize,
    warm_start: f32,
    tolerance: f32,
    cone: FrictionCone,
    /// Lanes of point solvers.
    lanes: Lanes,
}

#[derive(Clone, Debug)]
enum Method {
    SoftStep(SoftStep),
    Pgs,
    Nncg,
}

impl Solver {
    pub fn settings(&self) -> SolverSettings {
        SolverSettings {
            outer_substeps: self.substeps,
            ..SolverSettings::new(self.solver())
        }
    }

    fn solver(&self) -> ContactSolver {
        match &self.method {
            Method::SoftStep(method) => SoftStep {
                max_sweeps: self.iterations,
                ..*method
            }
            .into(),
            Method::Pgs => Pgs {
                iterations: self.iterations,
                cone: self.cone,
                warm_start: self.warm_start,
                tolerance: self.tolerance,
                lanes: self.lanes,
            }
            .into(),
            Method::Nncg => Nncg {
                iterations: self.iterations,
                cone: self.cone,
                warm_start: self.warm_start,
                tolerance: self.tolerance,
                lanes: self.lanes,
            }
            .into(),
        }
    }
}

/// The number of kinds of operations between two steps, without spawning.
pub const EDITS: usize = 22;

impl Operation {
    pub fn roll(edit: usize, dice: &mut Dice, spoils: bool) -> Self {
        let i = dice.index(64);
        match edit {
            0 => Self::Despawn(i),
            1 => Self::Clone(i),
            2 => Self::DespawnPair(i),
            3 => Self::StripPair(i, dice.index(64)),
            4 => Self::MoveTransform(i, dice.vector(3.0) + 3.0 * Vec3::Y, dice.turn()),
            5 => Self::MovePose(i, dice.vector(3.0) + 3.0 * Vec3::Y, dice.turn()),
            6..=9 => Self::Insert(i, Part::roll(dice)),
            10 => match Part::roll(dice) {
                // Bodies that fly at any speed would reach the innocent stack.
                Part::Layers(_) if spoils => Self::Orphan(i),
                part => Self::Remove(i, part),
            },
            11 => Self::Touch(i, Part::roll(dice)),
            12 => Self::Adopt(i, dice.index(64)),
            13 => Self::Orphan(i),
            14 => Self::Mend(i),
            15 => match dice.chance(0.1) {
                true => Self::Reset,
                false => Self::Spawn(Spawn::roll(dice)),
            },
            16 => Self::Gravity(Vec3::NEG_Y * dice.number(0.0, 15.0) + 0.3 * dice.vector(1.0)),
            17 => match dice.index(5) {
                0 => Self::Solver(Solver::roll(dice)),
                1 => Self::Stabilization(Box::new(stabilization(dice))),
                2 => Self::Narrowphase(narrowphase(dice)),
                3 => Self::Speeds(SpeedLimits {
                    linear: dice.number(20.0, 1000.0),
                    angular: dice.number(20.0, 1000.0),
                }),
                _ => Self::Sleep(SleepSettings {
                    enabled: dice.chance(0.8),
                    linear_speed: dice.number(0.0, 0.02),
                    angular_speed: dice.number(0.0, 0.04),
                    delay: dice.number(0.0, 1.0),
                    settling: dice.number(0.0, 2.0),
                    waking: match dice.chance(0.3) {
                        true => Waking::Islands,
                        false => Waking::ByNeed {
                            share: dice.number(0.0, 0.1),
                        },
                    },
                }),
            },
            18 => Self::Forget(i),
            19 => Self::Bare(i, dice.index(64)),
            20 => Self::Clear(i),
            _ => Self::Defaults,
        }
    }

    /// Mostly that of 60 Hz.
    pub fn step(dice: &mut Dice, spoils: bool) -> Self {
        if dice.chance(0.8) {
            return Self::Step(1.0 / 60.0);
        }
        if spoils && dice.chance(0.1) {
            let bad = [f32::NAN, f32::INFINITY, -1.0, 1e-30, 1e30, 1e-7, 60.0];
            return Self::Step(dice.pick(&bad));
        }
        Self::Step(dice.pick(&[0.0, 1e-4, 1e-3, 1.0 / 240.0, 1.0 / 30.0, 0.1, 0.25]))
    }
}

impl Spawn {
    pub fn roll(dice: &mut Dice) -> Self {
        let (kind, shape) = (dice.pick(&KINDS), Shape::roll(dice));
        Self {
            kind: if shape.is_solid() {
                kind
            } else {
                RigidBody::Static
            },
            shape,
            at: dice.vector(3.0) + 3.5 * Vec3::Y,
            turn: dice.turn(),
            asleep: dice.chance(0.1),
        }
    }
}

impl Solver {
    fn roll(dice: &mut Dice) -> Self {
        let method = match dice.index(3) {
            0 => Method::SoftStep(SoftStep {
                damping_ratio: dice.number(5.0, 20.0),
                sweeps_per_period: dice.number(9.0, 11.0),
                preload: dice.number(0.0, 1.0),
                preload_sweeps: dice.number(1600.0, 1e5),
                max_substep: dice.number(5e-4, 1e-2),
                min_sweeps: dice.index(12),
                lanes: dice.pick(&[Lanes::Auto, Lanes::Four]),
                ..Default::default()
            }),
            1 => Method::Pgs,
            _ => Method::Nncg,
        };
        Self {
            method,
            iterations: if dice.spoils() { 0 } else { 1 + dice.index(40) },
            substeps: if dice.spoils() { 0 } else { 1 + dice.index(3) },
            warm_start: dice.number(0.0, 0.5),
            tolerance: dice.number(0.0, 1e-3),
            cone: dice.pick(&[FrictionCone::Circular, FrictionCone::Box]),
            lanes: dice.pick(&[Lanes::Auto, Lanes::Four]),
        }
    }
}

fn stabilization(dice: &mut Dice) -> StabilizationSettings {
    let normals = [
        NormalStabilization::None,
        NormalStabilization::Baumgarte {
            gain: dice.number(0.0, 0.9),
        },
        NormalStabilization::BaumgarteOneSided {
            gain: dice.number(0.0, 0.9),
        },
        NormalStabilization::Envelope,
    ];
    let anchors = [
        AnchorRule::Literal,
        AnchorRule::Persistent,
        AnchorRule::PairPose,
        AnchorRule::Trackless,
    ];
    let classifiers = [
        Classifier::PerPoint,
        Classifier::Any,
        Classifier::All,
        Classifier::Sum,
        Classifier::Hysteresis,
    ];
    StabilizationSettings {
        envelope: dice.number(0.01, 0.06),
        ideal_distance: dice.number(0.0, 0.03),
        normal: dice.pick(&normals),
        max_correction_speed: dice.number(0.5, 3.0),
        friction: FrictionStabilization {
            enabled: dice.chance(0.8),
            anchors: dice.pick(&anchors),
            classifier: dice.pick(&classifiers),
            gain: dice.number(0.4, 1.0),
            tolerance: dice.number(0.0, 1e-4),
            max_error: dice.number(0.05, 0.3),
            max_separation: dice.number(0.02, 0.1),
            max_turn: dice.number(0.05, 0.2),
            creep_speed: dice.number(0.0, 1e-2),
        },
    }
}

fn narrowphase(dice: &mut Dice) -> NarrowphaseSettings {
    NarrowphaseSettings {
        recycle_share: dice.number(0.0, 0.03),
        reduce_manifolds: dice.chance(0.5),
        match_radius: dice.number(0.0, 0.06),
    }
}
