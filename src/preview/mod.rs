//! Previews of edits: [`preview()`] runs an edit on a copy of the world, and reports which bodies would move and where to.
//!
//! A [`Shadow`] is a small world of its own: a copy of the structures that the edit affects, and of the bodies near them, with their
//! contact impulses. It takes steps until everything in it is at rest, which takes milliseconds for a hundred bricks. With the default step
//! length, that of the world, it moves exactly as the world would, to the bit, as long as no other body comes near. With longer steps it
//! finishes sooner, but falling bodies end up only roughly where they would. Where the world's steps are shorter than 1/240 s, those of a
//! preview are longer, so that it ends in time.
//!
//! The copy has none of your own systems, and no hands. It leaves out bodies that were despawned or disabled since the last step. Bodies
//! that were spawned or moved since then are where they are now, if the world has been [refreshed](crate::refresh()); joints that were
//! added since then hold.
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
//! The functions take the whole world, `&World`. In a system use the parameter [`Previews`]. [`preview_task`] copies the world at once,
//! and runs the copy in a task.

mod copy;
mod error;
mod region;
mod shadow;

pub use crate::body::Moved;
pub use error::PreviewError;
pub use shadow::Shadow;

use crate::body::{Pose, collider::Collider};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_tasks::{AsyncComputeTaskPool, Task};

/// An edit to preview.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Removes these bodies.
    Remove(Vec<Entity>),
    /// Moves a body to a pose.
    Move(Entity, Pose),
    /// Adds a dynamic body with this shape at a pose, with the default surface and density.
    Place(Collider, Pose),
}

/// How long a preview runs, and how far a body must move to count as moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewSettings {
    /// Length of a step, s. `None` uses that of the world's last step, or before the first step that of `Time<Fixed>`, or 1/60 s if there
    /// is no such clock. Default: `None`.
    ///
    /// Steps that would be more than 2400 in the maximum time are lengthened to that number, but not beyond 1/60 s: a preview in slow
    /// motion takes no more steps than one at 240 Hz.
    pub dt: Option<f32>,
    /// Maximum simulated time, s. Bodies that still move then are left where they are. Default: 10.
    pub max_time: f32,
    /// Minimum movement of a body that counts as moved, as a share of its bounding radius: how far its centre moves plus how far the
    /// rotation moves a point at that radius. Default: 0.05.
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

/// The result of a preview.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preview {
    /// The bodies that would move, in order of spawning. Bodies that the edit itself removes, moves or places are not among them.
    pub moved: Vec<Moved>,
    /// The final pose of the body that was moved or placed.
    pub end_pose: Option<Pose>,
    /// Whether everything was at rest in the end. False if the preview stopped at [`PreviewSettings::max_time`].
    pub at_rest: bool,
    /// The simulated time, s.
    pub time: f32,
}

impl Preview {
    /// Returns true if this body would move.
    pub fn moves(&self, body: Entity) -> bool {
        self.moved.iter().any(|moved| moved.body == body)
    }
}

/// Runs an edit on a copy of the world with the default [`PreviewSettings`], and returns what would happen. In a system use [`Previews`].
///
/// # Errors
/// [`PreviewError`] if the edit names an entity that is not a body, or no body at all, or contains a number that is not finite.
pub fn preview(world: &World, edit: &Edit) -> Result<Preview, PreviewError> {
    Shadow::of(world, edit)?.run(&PreviewSettings::default())
}

/// Runs a preview in a task on the [`AsyncComputeTaskPool`]. The world is copied at once; poll or await the task for the result.
///
/// # Errors
/// As [`preview()`], and [`PreviewError::InvalidSettings`].
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
        let is_length = |dt: f32| crate::settings::STEP_LENGTHS.contains(&dt);
        let numbers = [self.max_time, self.movement_threshold];
        (self.dt.is_none_or(is_length) && numbers.iter().all(|number| (0.0..=1e6).contains(number)))
            .then_some(())
            .ok_or(PreviewError::InvalidSettings)
    }
}
