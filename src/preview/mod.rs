//! What would happen if: [`preview`] tries an edit on a copy, and says which bodies would move, and where to.
//!
//! A [`Shadow`] is a small world of its own: the structures that an edit is about, and what is near enough to be hit, with all that their
//! contacts carry. It takes steps until all of it lies still, which is a matter of milliseconds for a hundred bricks. With steps as long as the
//! world's own, the default, it goes where the world would go, to the bit as long as nothing new comes near; with long ones it is there
//! sooner, and what falls on what is rough. Systems of yours are not in the shadow, and nobody's hands. Nor are bodies that were despawned or
//! disabled since the last step. Bodies that were spawned or moved since then are where they are now, if the world has been
//! [refreshed](crate::refresh).
//!
//! ```
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let mut brick = |x, y| {
//!     let at = Transform::from_xyz(x, y, 0.0);
//!     world.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)).id()
//! };
//! // Three in a row, one across the left two, and one on that.
//! let [left, middle, right] = [-1.0, 0.0, 1.0].map(|x| brick(x, 0.25));
//! let [across, top] = [0.75, 1.25].map(|y| brick(-0.5, y));
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! let falls = |body| {
//!     let preview = preview(world, &Edit::Remove(vec![body])).unwrap();
//!     preview.moved.iter().map(|moved| moved.body).collect::<Vec<_>>()
//! };
//! assert_eq!(falls(right), []);
//! assert_eq!(falls(top), []);
//! assert_eq!(falls(across), [top]);
//! assert_eq!(falls(left), [across, top]);
//!
//! // A brick laid half on `right` and half on nothing stays there; farther out it does not.
//! let ends = |x| {
//!     let pose = Pose { position: Vec3::new(x, 0.75, 0.0), ..Pose::default() };
//!     let edit = Edit::Place(Collider::cuboid(1.0, 0.5, 0.5), pose);
//!     preview(world, &edit).unwrap().end_pose.unwrap().position
//! };
//! assert!(ends(1.4).distance(Vec3::new(1.4, 0.75, 0.0)) < 1e-3);
//! assert!(ends(1.6).y < 0.7);
//! ```
//!
//! It wants the whole world, `&World`, as exclusive systems have it; [`preview_task`] takes a copy and lets a task find out.

mod copy;
mod error;
mod region;
mod shadow;

pub use error::PreviewError;
pub use shadow::Shadow;

use crate::body::Pose;
use crate::collider::Collider;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_tasks::{AsyncComputeTaskPool, Task};

/// What is tried.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Bodies are taken away.
    Remove(Vec<Entity>),
    /// A body is put elsewhere.
    Move(Entity, Pose),
    /// A body is added, with the default surface and density.
    Place(Collider, Pose),
}

/// How it is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewSettings {
    /// Length of a step, s. By default that of the world's last step; before the first one that of `Time<Fixed>`, or 1/60 s where there is no
    /// such clock.
    pub dt: Option<f32>,
    /// What has not come to rest by then is left as it is, s.
    pub max_time: f32,
    /// A body has moved when a point of it has come farther than this share of its radius.
    pub movement_threshold: f32,
}

impl Default for PreviewSettings {
    fn default() -> Self {
        Self {
            dt: None,
            max_time: 10.0,
            movement_threshold: 0.05,
        }
    }
}

/// What would happen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preview {
    /// The bodies that would move, the eldest first. Those that are taken or placed are not among them.
    pub moved: Vec<Moved>,
    /// Where what was moved or placed is in the end.
    pub end_pose: Option<Pose>,
    /// All lies still in the end. False where it was given up before that.
    pub at_rest: bool,
    /// After how long, s.
    pub time: f32,
}

/// A body that would move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Which.
    pub body: Entity,
    /// Where it is now.
    pub from: Pose,
    /// Where it would be in the end.
    pub to: Pose,
}

impl Preview {
    /// Whether this body would move.
    pub fn moves(&self, body: Entity) -> bool {
        self.moved.iter().any(|moved| moved.body == body)
    }
}

/// Tries an edit, with the default [`PreviewSettings`].
///
/// # Errors
/// Where it names what is no body, or a body twice, or has a number that is not finite.
pub fn preview(world: &World, edit: &Edit) -> Result<Preview, PreviewError> {
    Shadow::of(world, edit)?.run(&PreviewSettings::default())
}

/// The same as a task, which is polled or awaited. The copy is taken at once.
///
/// # Errors
/// As [`preview`].
pub fn preview_task(
    world: &World,
    edit: &Edit,
    settings: PreviewSettings,
) -> Result<Task<Result<Preview, PreviewError>>, PreviewError> {
    settings.check()?;
    let shadow = Shadow::of(world, edit)?;
    let pool = AsyncComputeTaskPool::get_or_init(Default::default);
    Ok(pool.spawn(async move { shadow.run(&settings) }))
}

/// Previews for systems: the system parameter beside [`preview()`] and [`preview_task()`].
///
/// It reads the whole world. A system that has it may not write anything but through [`Commands`].
///
/// ```
/// # use bevy_ecs::prelude::*;
/// # use drystone::prelude::*;
/// # #[derive(Component)] struct Suspect;
/// fn is_safe_to_remove(previews: Previews, suspect: Single<Entity, With<Suspect>>) {
///     let preview = previews.preview(&Edit::Remove(vec![*suspect])).unwrap();
///     println!("{} bodies would move", preview.moved.len());
/// }
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default()).add_systems(bevy_app::Update, is_safe_to_remove);
/// # app.world_mut().spawn((RigidBody::Dynamic, Collider::ball(0.5), Suspect));
/// # drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
/// # app.update();
/// ```
#[derive(SystemParam, Clone, Copy, Debug)]
pub struct Previews<'w> {
    world: &'w World,
}

impl Previews<'_> {
    /// Runs an edit on a copy, as [`preview()`] does.
    ///
    /// # Errors
    /// As [`preview()`].
    pub fn preview(&self, edit: &Edit) -> Result<Preview, PreviewError> {
        preview(self.world, edit)
    }

    /// Runs an edit on a copy in a task, as [`preview_task()`] does.
    ///
    /// # Errors
    /// As [`preview()`].
    pub fn preview_task(
        &self,
        edit: &Edit,
        settings: PreviewSettings,
    ) -> Result<Task<Result<Preview, PreviewError>>, PreviewError> {
        preview_task(self.world, edit, settings)
    }
}

impl PreviewSettings {
    fn check(&self) -> Result<(), PreviewError> {
        let is_length = |dt: f32| crate::schedule::STEP_LENGTHS.contains(&dt);
        let numbers = [self.max_time, self.movement_threshold];
        (self.dt.is_none_or(is_length) && numbers.iter().all(|number| (0.0..=1e6).contains(number)))
            .then_some(())
            .ok_or(PreviewError::InvalidSettings)
    }
}
