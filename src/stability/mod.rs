//! Safety margins by limit analysis: [`stability()`] computes how far a structure can be tilted, pulled or loaded before it fails, and
//! how it fails. Needs the feature `stability`.
//!
//! Limit analysis rests on the static theorem (Heyman 1966; with friction, Livesley 1978): a structure of rigid blocks stands if there are
//! joint forces that balance the loads, lie within the polygons in which faces touch, and lie within the cones of friction. A cone program
//! (`interior.rs`) finds the largest load for which there are such forces. Its dual variables are the motion with which the structure
//! fails. Nothing is simulated.
//!
//! The theorem assumes that sliding joints also open. A joint that is held from both sides cannot open, so the result is corrected in
//! several rounds (`program.rs`), which start from the current normal forces. A brick that is pulled out of a wall is therefore held by the
//! force that presses on it, and not by the weight of the whole wall.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use drystone::masonry::{Bond, Wall};
//! use drystone::prelude::*;
//! use drystone::stability::{Trial, stability};
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let wall = Wall { length: 4.0, courses: 10, ..Wall::new(Bond::Running) };
//! let bricks = wall.blocks().unwrap().into_iter();
//! let bricks: Vec<Entity> = bricks.map(|brick| world.spawn(brick.bundle()).id()).collect();
//! drystone::step(world, 1.0 / 60.0).unwrap();
//!
//! // The wall is 0.5 m deep and 5 m high. It tips over its lower edge at 5.7°.
//! let margin = stability(world, &bricks, &Trial::Tilt(Vec3::Z)).unwrap();
//! assert!((margin.limit.to_degrees() - 5.71).abs() < 0.05);
//! assert_eq!(margin.moving.len(), bricks.len());
//! ```

mod cholesky;
mod cone;
mod cone_program;
mod error;
mod interior;
mod order;
mod program;
mod scaled;
mod structure;

pub use error::StabilityError;

use crate::body::BodyTable;
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::settings::Gravity;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::ops;
use bevy_tasks::{AsyncComputeTaskPool, Task};
use glam::Vec3;
use program::Load;
use structure::Structure;

/// The load that a structure is tested with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trial {
    /// Tilts the ground so that the structure leans in this direction (world). Only its horizontal part counts.
    Tilt(Vec3),
    /// Pulls or presses a body with a force in some direction.
    Pull {
        /// The body; it must belong to the structure.
        body: Entity,
        /// The point at which the force acts, world, m.
        point: Vec3,
        /// The direction of the force, world, of any length but zero.
        direction: Vec3,
    },
}

/// The largest load that a structure can take, and how it fails at that load.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// The tilt (rad) or force (N) at which the structure fails. If it never fails it is infinite, or π/2 for a tilt.
    pub limit: f32,
    /// The bodies that begin to move, in the order of the structure. Empty if it never fails.
    pub moving: Vec<MovingBody>,
    /// The joints that fail.
    pub failing: Vec<FailingJoint>,
}

/// The velocity with which a body begins to move. Only the ratios between bodies have a meaning: the fastest body has 1 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingBody {
    /// The body.
    pub body: Entity,
    /// Velocity of its centre of mass, world, m/s.
    pub linear: Vec3,
    /// Angular velocity, world, rad/s.
    pub angular: Vec3,
}

/// A joint that fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailingJoint {
    /// The bodies on both sides, in spawn order.
    pub between: [Entity; 2],
    /// How the joint fails.
    pub how: JointFailure,
}

/// How a joint between two blocks fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointFailure {
    /// One face slides along the other.
    Slides,
    /// One body tips over an edge or corner of the other, or lifts off.
    Tips,
}

/// Maximum number of bodies in a structure: 5000. The time grows faster than their number: on one core, a wall of 100 bricks takes about
/// 0.01 s, one of 1000 bricks 0.2 to 0.8 s, and one of 5000 bricks 3 to 10 s. Structures that fail by sliding take longest. A few loads
/// that press inside a wall need eight rounds instead of one or two, and take that many times as long.
pub const MAX_BODIES: usize = 5000;

/// Computes how much of a load a structure can take. Bodies that are not in `structure` are assumed not to move.
///
/// It blocks until the answer is known, up to a second for a thousand bricks. [`stability_task`] does not block. In a system, use
/// [`Stability`].
///
/// # Errors
/// [`StabilityError`] if the structure is empty, larger than [`MAX_BODIES`], or contains an entity that is not a dynamic body; if a
/// direction is zero or not finite; or if the structure does not stand without the load.
pub fn stability(
    world: &World,
    structure: &[Entity],
    trial: &Trial,
) -> Result<Margin, StabilityError> {
    Question::new(world, structure, trial)?.answer()
}

/// Computes how much of a load a structure can take, in a task on the [`AsyncComputeTaskPool`]. The structure is copied at once, so the
/// world may change in the meantime.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use bevy_tasks::block_on;
/// use drystone::masonry::{Bond, Wall};
/// use drystone::prelude::*;
/// use drystone::stability::{Trial, stability_task};
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// let wall = Wall::new(Bond::Running).blocks().unwrap().into_iter();
/// let bricks: Vec<Entity> = wall.map(|brick| world.spawn(brick.bundle()).id()).collect();
/// drystone::step(world, 1.0 / 60.0).unwrap();
///
/// let task = stability_task(world, &bricks, &Trial::Tilt(Vec3::Z)).unwrap();
/// // In a game, check `task.is_finished()` in later frames instead.
/// let margin = block_on(task).unwrap();
/// assert!(margin.limit > 0.0);
/// ```
///
/// # Errors
/// As [`stability()`]: at once if the question is invalid, in the task if the structure does not stand.
pub fn stability_task(
    world: &World,
    structure: &[Entity],
    trial: &Trial,
) -> Result<Task<Result<Margin, StabilityError>>, StabilityError> {
    let question = Question::new(world, structure, trial)?;
    let pool = AsyncComputeTaskPool::get_or_init(Default::default);
    Ok(pool.spawn(async move { question.answer() }))
}

/// The system parameter for [`stability()`] and [`stability_task()`].
///
/// It reads the whole world, so a system with this parameter can only write through [`Commands`].
///
/// ```
/// # use bevy_ecs::prelude::*;
/// # use drystone::prelude::*;
/// use drystone::stability::{Stability, Trial};
///
/// fn report(stability: Stability, bodies: Query<(Entity, &RigidBody)>) {
///     let dynamic = bodies.iter().filter(|(_, kind)| **kind == RigidBody::Dynamic);
///     let bodies: Vec<Entity> = dynamic.map(|(body, _)| body).collect();
///     let margin = stability.stability(&bodies, &Trial::Tilt(Vec3::X)).unwrap();
///     println!("it stands up to a tilt of {}°", margin.limit.to_degrees());
/// }
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default()).add_systems(bevy_app::Update, report);
/// # app.world_mut().spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// # let at = bevy_transform::components::Transform::from_xyz(0.0, 0.5, 0.0);
/// # app.world_mut().spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), at));
/// # drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
/// # app.update();
/// ```
#[derive(SystemParam, Clone, Copy, Debug)]
pub struct Stability<'w> {
    world: &'w World,
}

impl Stability<'_> {
    /// Computes how much a structure can take, as [`stability()`] does.
    ///
    /// # Errors
    /// As [`stability()`].
    pub fn stability(&self, structure: &[Entity], trial: &Trial) -> Result<Margin, StabilityError> {
        stability(self.world, structure, trial)
    }

    /// Computes how much a structure can take in a task, as [`stability_task()`] does.
    ///
    /// # Errors
    /// As [`stability_task()`].
    pub fn stability_task(
        &self,
        structure: &[Entity],
        trial: &Trial,
    ) -> Result<Task<Result<Margin, StabilityError>>, StabilityError> {
        stability_task(self.world, structure, trial)
    }
}

/// A structure and its load, copied out of a world.
struct Question {
    structure: Structure,
    load: Load,
    is_tilt: bool,
}

impl Question {
    fn new(world: &World, structure: &[Entity], trial: &Trial) -> Result<Self, StabilityError> {
        if structure.is_empty() {
            return Err(StabilityError::Nothing);
        }
        if structure.len() > MAX_BODIES {
            return Err(StabilityError::TooMany(structure.len()));
        }
        let (table, graph) = (
            world.resource::<BodyTable>(),
            world.resource::<ConstraintGraph>(),
        );
        let mut slots = Vec::with_capacity(structure.len());
        for &body in structure {
            let slot = table.slot_of(world, body);
            let slot = slot.ok_or(StabilityError::NotABody(body))?;
            let state = table.get(slot).ok_or(StabilityError::NotABody(body))?;
            if !state.is_dynamic() {
                return Err(StabilityError::Fixed(body));
            }
            let mut joints = graph.edges_of_kind(slot, EdgeKind::Joint);
            if joints.next().is_some() {
                return Err(StabilityError::Jointed(body));
            }
            slots.push(slot);
        }
        Ok(Self {
            load: load(world, structure, trial)?,
            structure: Structure::new(world, &slots),
            is_tilt: matches!(trial, Trial::Tilt(_)),
        })
    }

    fn answer(&self) -> Result<Margin, StabilityError> {
        let mut margin = self.structure.solve(&self.load)?;
        if self.is_tilt {
            margin.limit = ops::atan(margin.limit);
        }
        Ok(margin)
    }
}

/// The load that the trial increases.
fn load(world: &World, structure: &[Entity], trial: &Trial) -> Result<Load, StabilityError> {
    let gravity = world.resource::<Gravity>().0;
    match *trial {
        Trial::Tilt(direction) => {
            let down = gravity.try_normalize().ok_or(StabilityError::NoGravity)?;
            let level = direction.reject_from_normalized(down);
            let level = level.try_normalize().ok_or(StabilityError::NoDirection)?;
            Ok(Load::Everywhere(gravity.length() * level))
        }
        Trial::Pull {
            body,
            point,
            direction,
        } => {
            let number = structure.iter().position(|&of| of == body);
            if !point.is_finite() {
                return Err(StabilityError::NotFinite);
            }
            Ok(Load::At {
                body: number.ok_or(StabilityError::NotOfStructure(body))?,
                point,
                direction: direction
                    .try_normalize()
                    .ok_or(StabilityError::NoDirection)?,
            })
        }
    }
}
