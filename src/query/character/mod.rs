//! Characters: shapes that a game moves itself, that slide along what they meet, climb steps and stand on slopes.
//!
//! The component [`Character`](crate::character::Character) does all of this in each step. The methods here are for games with rules of
//! their own.
//!
//! A character is not a dynamic body: it goes where its player wants. [`move_and_slide`](SpatialQuery::move_and_slide) says how far it gets
//! in one step of the game, and [`ground`](SpatialQuery::ground) what it stands on. Both only ask: they move nothing. The answer has the
//! obstacles of the character, with the impulse by which it [pushes](CharacterHit::push) each.
//!
//! The method is that of most engines: the shape is cast along the way, stops a little before the first obstacle, and goes on along its
//! surface with what is left. At a wall it looks whether there is a step behind it.

mod ground;
mod slide;

pub use ground::Ground;
pub use slide::CharacterHit;

use super::{QueryError, QueryFilter, SpatialQuery};
use crate::body::{Pose, collider::Collider};
use bevy_math::{Dir3, ops};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;
use slide::Walk;

/// How a character moves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, Default, PartialEq)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MoveAndSlide {
    /// Up. Default: y.
    pub up: Dir3,
    /// Distance that the character keeps from all surfaces, m. Default: 0.01.
    pub margin: f32,
    /// Steepest slope that it stands on and climbs, rad. Default: 45°.
    pub max_slope: f32,
    /// Highest step that it climbs, m. Default: 0.3.
    pub step_height: f32,
    /// Depth that a step must have to stand on, m. Default: 0.1.
    pub step_depth: f32,
    /// A character that stands and does not move up from its ground is kept on ground that falls away by no more than this, m. Default:
    /// 0.3.
    pub snap_distance: f32,
    /// Upper bound of the obstacles that it slides along in one call. Default: 6.
    pub max_slides: u32,
}

impl Default for MoveAndSlide {
    fn default() -> Self {
        Self {
            up: Dir3::Y,
            margin: 0.01,
            max_slope: std::f32::consts::FRAC_PI_4,
            step_height: 0.3,
            step_depth: 0.1,
            snap_distance: 0.3,
            max_slides: 6,
        }
    }
}

impl MoveAndSlide {
    /// Returns true if a surface with this normal is flat enough to stand on.
    pub fn is_walkable(&self, normal: Vec3) -> bool {
        /// Rounding of normals.
        const ROUNDING: f32 = 1e-4;
        normal.dot(*self.up) >= ops::cos(self.max_slope) - ROUNDING
    }

    /// The part of a vector that is not up or down.
    pub(crate) fn level(&self, vector: Vec3) -> Vec3 {
        vector - *self.up * vector.dot(*self.up)
    }

    fn check(&self) -> Result<(), QueryError> {
        let lengths = [
            self.margin,
            self.max_slope,
            self.step_height,
            self.step_depth,
            self.snap_distance,
        ];
        if !self.up.is_finite() {
            return Err(QueryError::NotFinite("`MoveAndSlide::up`"));
        }
        let invalid = lengths.into_iter().find(|x| !(0.0..f32::MAX).contains(x));
        invalid.map_or(Ok(()), |length| Err(QueryError::InvalidDistance(length)))
    }
}

/// Where a character gets to.
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// Its position then, m.
    pub position: Vec3,
    /// The ground that it stands on then, if it stands. A jump leaves the ground if its first step is longer than [`MoveAndSlide::margin`].
    pub ground: Option<Ground>,
    /// The bodies that it met, in order, each once.
    pub hits: Vec<CharacterHit>,
}

impl SpatialQuery<'_, '_> {
    /// Moves a shape from a pose by a translation (m), and lets it slide along obstacles, climb steps, and keep to the ground when it goes
    /// down. The filter must exclude the character's own body. Where the shape overlaps bodies at the start it is moved out first.
    ///
    /// On a moving platform add [`Ground::velocity`] times the length of the step to the translation; what counts as going up is relative
    /// to the ground. The component [`Character`](crate::character::Character) goes with its ground by itself.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    /// // A step of 0.2 m, and a wall.
    /// world.spawn((RigidBody::Static, Collider::cuboid(2.0, 0.4, 9.0), Transform::from_xyz(2.0, 0.0, 0.0)));
    /// world.spawn((RigidBody::Static, Collider::cuboid(1.0, 9.0, 9.0), Transform::from_xyz(3.0, 0.0, 0.0)));
    /// drystone::step(world, 1.0 / 60.0).unwrap();
    ///
    /// let shape = Collider::capsule(0.3, 1.0);
    /// let mut at = Pose { position: Vec3::new(0.0, 0.81, 0.0), ..Pose::default() };
    /// for _ in 0..120 {
    ///     let walk = Vec3::new(0.05, -0.01, 0.02);
    ///     let slide = spatial_query(world, |query| {
    ///         query.move_and_slide(&shape, at, walk, &MoveAndSlide::default(), &QueryFilter::default())
    ///     });
    ///     at.position = slide.unwrap().position;
    /// }
    /// assert!((at.position.y - 1.01).abs() < 0.01, "on the step");
    /// assert!((at.position.x - 2.19).abs() < 0.01, "at the wall");
    /// assert!(at.position.z > 2.0, "along the wall");
    /// ```
    ///
    /// # Errors
    /// [`QueryError`] if the pose, the translation or a setting is not finite or negative, the shape is degenerate or unbounded, or it
    /// cannot be compared with that of a body on its way.
    pub fn move_and_slide(
        &self,
        collider: &Collider,
        from: Pose,
        translation: Vec3,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Slide, QueryError> {
        rules.check()?;
        if !translation.is_finite() {
            return Err(QueryError::NotFinite("the translation"));
        }
        let mut walk = Walk::new(self, collider, from, rules, filter);
        walk.leave_overlaps()?;
        let stood = self.stood(collider, walk.pose, rules, filter)?;
        walk.slide(translation, stood.as_ref())?;
        if stood.is_some_and(|stood| !self.goes_up(&stood, translation, rules)) {
            walk.snap()?;
        }
        self.arrived(walk)
    }

    /// Moves a shape as [`move_and_slide`](Self::move_and_slide) does. It `snaps` if it stood and does not take off.
    pub(crate) fn go(
        &self,
        collider: &Collider,
        from: Pose,
        translation: Vec3,
        snaps: bool,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Slide, QueryError> {
        rules.check()?;
        let mut walk = Walk::new(self, collider, from, rules, filter);
        walk.leave_overlaps()?;
        let stood = match snaps {
            true => self.ground(collider, walk.pose, rules, filter)?,
            false => None,
        };
        walk.slide(translation, stood.as_ref())?;
        if stood.is_some() {
            walk.snap()?;
        }
        self.arrived(walk)
    }

    /// Where a shape gets to that its ground carries along a way, m. The filter must exclude the ground.
    pub(crate) fn carry(
        &self,
        collider: &Collider,
        from: Pose,
        way: Vec3,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Vec3, QueryError> {
        rules.check()?;
        let mut walk = Walk::new(self, collider, from, rules, filter);
        walk.slide(way, None)?;
        Ok(walk.pose.position)
    }

    fn arrived(&self, walk: Walk) -> Result<Slide, QueryError> {
        let ground = self.ground(walk.collider, walk.pose, walk.rules, walk.filter)?;
        Ok(Slide {
            position: walk.pose.position,
            ground,
            hits: walk.hits,
        })
    }

    /// The ground of a character at a pose before the last step, which may have moved that ground away.
    fn stood(
        &self,
        collider: &Collider,
        pose: Pose,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Option<Ground>, QueryError> {
        let reach = 2.0 * rules.margin;
        let below =
            self.ground_within(collider, pose, reach + rules.snap_distance, rules, filter)?;
        Ok(below.filter(|below| {
            let sank = -below.velocity.dot(*rules.up) * self.step.whole();
            below.distance - sank.max(0.0) <= reach
        }))
    }

    /// Whether a character takes off from its ground: it goes up faster than the ground does, by more than the ground's velocity can change
    /// in a step, if the ground moves.
    fn goes_up(&self, stood: &Ground, translation: Vec3, rules: &MoveAndSlide) -> bool {
        /// m
        const ROUNDING: f32 = 1e-6;
        /// m/s²
        const MOST: f32 = 10.0;
        let dt = self.step.whole();
        let ground = stood.velocity.dot(*rules.up) * dt;
        let doubt = match ground == 0.0 {
            true => 0.0,
            false => 0.5 * ground.abs() + MOST * dt * dt,
        };
        translation.dot(*rules.up) - ground > ROUNDING + doubt
    }
}
