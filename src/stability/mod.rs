//! How safe a structure stands: [`stability`] says by how much it may be tilted, pulled or loaded before it gives way, and what gives way first.
//!
//! It is limit analysis, by the static theorem (Heyman 1966; for friction Livesley 1978): a structure of rigid blocks stands as long as there are
//! forces in its joints, within the polygons in which faces touch and within the cones of friction, that balance what acts on it. The most of a
//! load for which there are such forces is found by a cone program (`interior.rs`), and its dual variables are the motion by which the structure
//! fails. Nothing is stepped, and what contacts carry now does not matter; only where they are.
//!
//! The theorem lets what slides open as well, which nothing does that is held from both sides. That is mended round by round (`program.rs`), so that
//! a brick that is pulled out of a wall is held by what presses on it, and not by the wall's weight.
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
//! // Half a metre deep and five high, it falls out of its plane at 5.7°, about its foot.
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
use crate::settings::Gravity;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_tasks::{AsyncComputeTaskPool, Task};
use glam::Vec3;
use program::Load;
use structure::Structure;

/// What a structure is put to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trial {
    /// The ground is tilted, so that what stands on it would go in this direction, of which the level part counts.
    Tilt(Vec3),
    /// A body is pulled along a direction, or pressed, or loaded where that is down.
    Pull {
        /// Which of the structure's.
        body: Entity,
        /// Where, world, m.
        point: Vec3,
        /// Which way, world.
        direction: Vec3,
    },
}

/// How much a structure can take, and what happens then.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// The tilt, rad, or the force, N, at which it fails; infinite where it never does by it, and for a tilt then π/2.
    pub limit: f32,
    /// The bodies that begin to move then, in the order of the structure. None where it never fails.
    pub moving: Vec<MovingBody>,
    /// The joints that give way.
    pub failing: Vec<FailingJoint>,
}

/// A body that begins to move: a velocity, of which only the proportions to those of others mean something; the fastest has 1 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingBody {
    /// Which.
    pub body: Entity,
    /// Of its centre of mass, world.
    pub linear: Vec3,
    /// World, rad/s.
    pub angular: Vec3,
}

/// A joint that gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailingJoint {
    /// The bodies on both sides, the elder first.
    pub between: [Entity; 2],
    /// How.
    pub how: JointFailure,
}

/// How a joint gives way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointFailure {
    /// One face slides on the other.
    Slides,
    /// One body tips over an edge or corner of the other, or is lifted off it.
    Tips,
}

/// Most bodies of a structure that may be asked about. Time grows faster than their number: walls of a hundred bricks take some 0.01 s of one core,
/// of a thousand 0.2 to 0.8 s, of five thousand 3 to 10 s, those longest that fail by sliding. A few loads that press within a wall take eight rounds
/// instead of one or two, and as many times longer.
pub const MAX_BODIES: usize = 5000;

/// How much of something a structure can take. Bodies that are not in the list are taken to stand fast.
///
/// It blocks until it is known, which takes up to a second for a thousand bricks; [`stability_task`] does not.
///
/// # Errors
/// Where the list is empty, longer than [`MAX_BODIES`], or names what is no dynamic body; where a direction is none; and where the structure does
/// not stand as it is.
pub fn stability(
    world: &World,
    structure: &[Entity],
    trial: &Trial,
) -> Result<Margin, StabilityError> {
    Question::new(world, structure, trial)?.answer()
}

/// The same as a task, which is polled or awaited. What is asked about is copied at once, so that the world may go on.
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
/// // Frames go by, until `task.is_finished()`.
/// let margin = block_on(task).unwrap();
/// assert!(margin.limit > 0.0);
/// ```
///
/// # Errors
/// As [`stability`]: at once where the question is wrong, in the task where the structure does not stand.
pub fn stability_task(
    world: &World,
    structure: &[Entity],
    trial: &Trial,
) -> Result<Task<Result<Margin, StabilityError>>, StabilityError> {
    let question = Question::new(world, structure, trial)?;
    let pool = AsyncComputeTaskPool::get_or_init(Default::default);
    Ok(pool.spawn(async move { question.answer() }))
}

/// Stability for systems: the system parameter beside [`stability()`] and [`stability_task()`].
///
/// It reads the whole world. A system that has it may not write anything but through [`Commands`].
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
    pub fn stability(
        &self,
        structure: &[Entity],
        trial: &Trial,
    ) -> Result<Margin, StabilityError> {
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

/// A structure and what it is put to, copied out of a world.
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
        let table = world.resource::<BodyTable>();
        let mut slots = Vec::with_capacity(structure.len());
        for &body in structure {
            let slot = table.slot_of(world, body);
            let slot = slot.ok_or(StabilityError::NotABody(body))?;
            let state = table.get(slot).ok_or(StabilityError::NotABody(body))?;
            if !state.is_dynamic() {
                return Err(StabilityError::Fixed(body));
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
            margin.limit = margin.limit.atan();
        }
        Ok(margin)
    }
}

/// What a trial makes larger.
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
