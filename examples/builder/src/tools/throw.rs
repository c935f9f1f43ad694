//! Throwing a ball.

use super::{Strength, attempt};
use crate::camera::Pointer;
use crate::compare::Comparison;
use crate::journal::{Entry, Journal};
use crate::look::Finish;
use crate::pieces::{Piece, Shape};
use bevy::prelude::*;
use drystone::prelude::*;

/// A ball along a ray, which undo leaves alone; into both copies where there are two.
///
/// # Errors
/// Never: a ball has a size.
pub fn throw(world: &mut World, ray: Ray3d) -> Result {
    let speed = world.resource::<Strength>().throw;
    let ball = Piece::new(Shape::Ball(0.25), Finish::Iron);
    let velocity = Velocity::linear(speed * *ray.direction);
    let pose = Pose {
        position: ray.get_point(0.5),
        ..default()
    };
    if world.resource::<Comparison>().is_on() {
        world.resource_scope(|world, mut comparison: Mut<Comparison>| {
            comparison.spawn(world, &ball, pose, velocity)
        })?;
    } else {
        world.spawn((ball.bundle(pose)?, velocity));
    }
    world.resource::<Journal>().say(&Entry::Threw);
    Ok(())
}

pub(super) fn on_click(
    mut commands: Commands,
    pointer: Res<Pointer>,
    buttons: Res<ButtonInput<MouseButton>>,
) {
    if let Some(ray) = pointer.ray
        && buttons.just_pressed(MouseButton::Left)
    {
        attempt(&mut commands, move |world| throw(world, ray));
    }
}
