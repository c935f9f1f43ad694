//! What a user can set: gravity, stabilization, solver. The defaults are what a Bevy user gets; [`Preset::Paper`]
//! is the setting of the paper's Table 1. All of it may be changed between any two steps; what cannot be is refused (`StepError::InvalidSettings`).

mod check;

pub use check::InForce;
pub(crate) use check::check;

use crate::body::Velocity;
use crate::solver::{ContactSolver, FrictionCone, Nncg, Pgs, SoftStep};
use bevy_ecs::prelude::*;
use bevy_math::ops;
use glam::Vec3;
use std::sync::Arc;

/// Acceleration of free fall, m/s²; (0, −9.81, 0) by default.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// How fast a body may be. What forces and contacts make faster is slowed down to this, so that nothing gets lost in one step.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimits {
    /// m/s; 1000 by default.
    pub linear: f32,
    /// rad/s; 10 000 by default.
    pub angular: f32,
}

impl Default for SpeedLimits {
    fn default() -> Self {
        Self {
            linear: 1000.0,
            angular: 10_000.0,
        }
    }
}

impl SpeedLimits {
    /// True for a velocity that a body may have.
    pub fn allow(&self, velocity: &Velocity) -> bool {
        velocity.linear.length() <= self.linear && velocity.angular.length() <= self.angular
    }

    /// The velocity that a body has instead.
    pub(crate) fn cap(&self, velocity: &mut Velocity) {
        velocity.linear = velocity.linear.clamp_length_max(self.linear);
        velocity.angular = velocity.angular.clamp_length_max(self.angular);
    }
}

/// The step at hand; a substep of it where there are several. Written by [`step`](crate::step).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct StepTime {
    /// Length of the substep at hand, s.
    pub dt: f32,
    /// Length of the one before, s; of this one if it is the first.
    pub last: f32,
    /// The longest of recent substeps, s: this one, or a longer one that fades within half a second. Errors of position are taken
    /// back as fast as it allows, so that a short step among long ones does not make a blow of what the long ones left. With
    /// steps of one length it is that.
    pub longest: f32,
    /// Number of the substep at hand, from 0.
    pub substep: usize,
    /// How many there are.
    pub substeps: usize,
}

impl Default for StepTime {
    fn default() -> Self {
        Self {
            dt: 0.0,
            last: 0.0,
            longest: 0.0,
            substep: 0,
            substeps: 1,
        }
    }
}

impl StepTime {
    /// The substep after this one, of a step of `dt` s in so many.
    pub(crate) fn next(&self, dt: f32, substep: usize, substeps: usize) -> Self {
        let dt = dt / substeps as f32;
        let faded = self.longest * ops::exp(-dt / Self::FADES);
        Self {
            dt,
            last: if self.dt > 0.0 { self.dt } else { dt },
            longest: dt.max(faded),
            substep,
            substeps,
        }
    }

    /// The time for which a force of the last step is taken to go on, s.
    pub(crate) fn carried(&self) -> f32 {
        self.dt.min(self.last)
    }

    /// How long it takes the longest step to fade to 1/e, s.
    const FADES: f32 = 0.5;

    /// Length of the whole step, s.
    pub fn whole(&self) -> f32 {
        self.dt * self.substeps as f32
    }

    /// True in the last substep.
    pub fn is_last(&self) -> bool {
        self.substep + 1 == self.substeps
    }
}

/// How normals are corrected (paper, section 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalStabilization {
    /// Non-penetration of velocities only; penetration creeps in.
    None,
    /// Equation (9), two-sided: demands −k·d/Δt for overlap and for gap. Ideal distance 0.
    Baumgarte {
        /// Error reduction k_n, 0 ≤ k < 1 (Table 1: 0.5).
        gain: f32,
    },
    /// Equation (9) for overlap only, as most engines have it; shows the paper's artefacts.
    BaumgarteOneSided {
        /// Error reduction k_n.
        gain: f32,
    },
    /// The paper's own, equations (5)–(8): contacts settle in the middle of a collision envelope.
    Envelope,
}

/// Where a contact's anchor comes from (paper, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnchorRule {
    /// Equation (11) to the letter: written anew in every step. Divides the drift by about 1 + k_t.
    Literal,
    /// Written when sticking starts, kept while it lasts. Bounds the drift.
    Persistent,
    /// The relative pose of the bodies at the onset of sticking, one for each patch; needs no tracking of points.
    PairPose,
    /// Last step's slip velocity times Δt, as the paper's section 3 speculates; needs no bookkeeping.
    Trackless,
}

/// What counts as sticking, equation (10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classifier {
    /// ‖λ_t‖ < μ λ_n, each point for itself.
    PerPoint,
    /// The manifold sticks if any of its points does.
    Any,
    /// The manifold sticks if all of its loaded points do.
    All,
    /// ‖Σλ_t‖ < μ Σλ_n over the manifold.
    Sum,
    /// On sums, with memory: sticking begins below 0.6 of the cone and ends at the cone.
    Hysteresis,
}

/// Friction stabilization (paper, section 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionStabilization {
    /// On or off.
    pub enabled: bool,
    /// Where anchors come from.
    pub anchors: AnchorRule,
    /// What counts as sticking.
    pub classifier: Classifier,
    /// k_t of equation (15); 0.4 to 1.0 works.
    pub gain: f32,
    /// ε of equation (14), m. At 1e-3 it jitters already.
    pub tolerance: f32,
    /// Anchors further apart than this along the surface are given up, m.
    pub max_error: f32,
    /// Anchors further apart than this along the normal are given up, in collision envelopes.
    pub max_separation: f32,
    /// Anchors are given up when the normal has turned by more than this in either body's frame, rad.
    pub max_turn: f32,
}

/// Both stabilizations and the collision envelope they live in.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct StabilizationSettings {
    /// Size δ of the collision envelope, m.
    pub envelope: f32,
    /// Distance at which surfaces come to rest, m. The paper: δ/2, so that real surfaces never overlap. 0: they
    /// touch, and the envelope lies half inside.
    pub ideal_distance: f32,
    /// How normals are corrected.
    pub normal: NormalStabilization,
    /// Clamp of all corrections, m/s (Table 1: 2).
    pub max_correction_speed: f32,
    /// How friction is corrected.
    pub friction: FrictionStabilization,
    /// A contact manifold is kept, with normal and arms frozen, until its bodies have moved against each other by this share of
    /// the smaller one's size (its bounding radius, or 2.5 times half its least thickness where that is less). 0: found anew in
    /// every step.
    pub recycle_share: f32,
    /// Keep four points of a patch that has more: the corners of the largest quadrangle.
    pub reduce_manifolds: bool,
}

impl StabilizationSettings {
    /// The distance at which a contact rests under the chosen normal correction, m.
    pub fn rest_distance(&self) -> f32 {
        match self.normal {
            NormalStabilization::Envelope => self.ideal_distance,
            _ => 0.0,
        }
    }

    /// The distance beyond which a contact is outside the envelope, m.
    pub fn outer_distance(&self) -> f32 {
        self.rest_distance() + 0.5 * self.envelope
    }
}

/// Which solver, and how hard it tries.
#[derive(Resource, Clone)]
pub struct SolverSettings {
    /// [`SoftStep`], [`Pgs`], [`Nncg`], or a user's own.
    pub solver: Arc<dyn ContactSolver>,
    /// Sweeps over all contacts in a solve, at most. [`Pgs`] and [`Nncg`] take them all, but for their tolerance; [`SoftStep`] as many
    /// as the step's length and the structure need, and softer springs where that is more.
    pub iterations: usize,
    /// Whole steps of Δt/n that one step is cut into, detection included.
    pub substeps: usize,
    /// The shape of the friction cone, for solvers of points; that of a patch is circular.
    pub cone: FrictionCone,
    /// Share of last step's impulses that a solve starts from, 0..1. With position feedback in the same velocities it
    /// is unstable when under-converged, so the paper's setting is 0. [`SoftStep`] starts from all of them, always.
    pub warm_start: f32,
    /// A solve ends early when its merit (see [`crate::solver::merit`]) falls below this. 0: never. [`SoftStep`] takes all its
    /// substeps.
    pub tolerance: f32,
    /// Keep the merit after every sweep (see [`crate::solve::SolveReports`]).
    pub record_history: bool,
}

/// Bodies at rest stop costing time.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct SleepSettings {
    /// On or off.
    pub enabled: bool,
    /// A body slower than this counts as still, m/s.
    pub linear_speed: f32,
    /// A body that turns slower than this counts as still, rad/s.
    pub angular_speed: f32,
    /// An island sleeps when all of it has been still this long, s.
    pub delay: f32,
}

/// Complete settings with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// What a Bevy user gets: 60 Hz, surfaces touch.
    Default,
    /// Table 1, row 2 with friction stabilization: Δt 0.1, envelope 0.0625, NNCG 75, no warm start, no sleeping.
    Paper,
}

impl Preset {
    /// The step this preset is meant for, s.
    pub fn dt(self) -> f32 {
        match self {
            Preset::Default => 1.0 / 60.0,
            Preset::Paper => 0.1,
        }
    }

    /// Its stabilization.
    pub fn stabilization(self) -> StabilizationSettings {
        let friction = FrictionStabilization {
            enabled: true,
            anchors: AnchorRule::Persistent,
            classifier: Classifier::Sum,
            gain: 0.8,
            tolerance: 1e-5,
            max_error: 0.25,
            max_separation: 3.0,
            max_turn: 0.1,
        };
        match self {
            Preset::Default => StabilizationSettings {
                envelope: 0.02,
                ideal_distance: 0.0,
                normal: NormalStabilization::Envelope,
                max_correction_speed: 2.0,
                friction: FrictionStabilization {
                    anchors: AnchorRule::PairPose,
                    ..friction
                },
                recycle_share: 0.016,
                reduce_manifolds: true,
            },
            Preset::Paper => StabilizationSettings {
                envelope: 0.0625,
                ideal_distance: 0.0625 / 2.0,
                normal: NormalStabilization::Envelope,
                max_correction_speed: 2.0,
                friction,
                recycle_share: 0.0,
                reduce_manifolds: false,
            },
        }
    }

    /// Its solver.
    pub fn solver(self) -> SolverSettings {
        match self {
            Preset::Default => SolverSettings {
                solver: Arc::new(SoftStep::default()),
                iterations: 192,
                substeps: 1,
                cone: FrictionCone::Circular,
                warm_start: 0.3,
                tolerance: 0.0,
                record_history: false,
            },
            Preset::Paper => SolverSettings {
                solver: Arc::new(Nncg),
                iterations: 75,
                substeps: 1,
                cone: FrictionCone::Circular,
                warm_start: 0.0,
                tolerance: 0.0,
                record_history: false,
            },
        }
    }

    /// Whether its bodies sleep.
    pub fn sleeping(self) -> SleepSettings {
        SleepSettings {
            enabled: self == Preset::Default,
            linear_speed: 0.01,
            angular_speed: 0.02,
            delay: 0.5,
        }
    }
}

impl Default for StabilizationSettings {
    fn default() -> Self {
        Preset::Default.stabilization()
    }
}

impl Default for SolverSettings {
    fn default() -> Self {
        Preset::Default.solver()
    }
}

impl Default for SleepSettings {
    fn default() -> Self {
        Preset::Default.sleeping()
    }
}

impl SolverSettings {
    /// These settings with projected Gauss–Seidel.
    pub fn with_pgs(mut self, iterations: usize) -> Self {
        self.solver = Arc::new(Pgs);
        self.iterations = iterations;
        self
    }

    /// These settings with the nonsmooth nonlinear conjugate gradient solver.
    pub fn with_nncg(mut self, iterations: usize) -> Self {
        self.solver = Arc::new(Nncg);
        self.iterations = iterations;
        self
    }
}

/// The threads that physics may use. By default rayon's global pool.
#[derive(Resource, Clone, Default)]
pub struct PhysicsThreads(Option<Arc<rayon::ThreadPool>>);

impl PhysicsThreads {
    /// A pool of its own with `n` threads; 0 means rayon's default number.
    ///
    /// # Errors
    /// Where the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build()?;
        Ok(Self(Some(Arc::new(pool))))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        match &self.0 {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// Whether so many items are worth handing over to other threads, which costs some 20 µs.
    pub fn share(&self, items: usize) -> bool {
        items >= Self::SMALL && self.count() > 1
    }

    /// Runs work on these threads, or on this one where sharing does not pay. Rayon's iterators in it must then be kept from
    /// splitting: by [`Self::grain`], or by being plain ones.
    pub fn run<R: Send>(&self, items: usize, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) if self.share(items) => pool.install(work),
            _ => work(),
        }
    }

    /// The least number of items that a thread takes of so many.
    pub fn grain(&self, items: usize) -> usize {
        if self.share(items) {
            Self::SMALL / 2
        } else {
            usize::MAX
        }
    }

    /// What is not worth handing over.
    pub const SMALL: usize = 128;
}
