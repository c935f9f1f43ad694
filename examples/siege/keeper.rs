//! The keeper of the castle: watches a wall that nobody touches, puts fallen bricks back, and undoes an edit.

use crate::castle::{Brick, Broken, moved, replace};
use crate::game::{Clock, Tally};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::masonry::EditLog;
use drystone::prelude::*;

/// The keeper's tools.
#[derive(Default)]
pub struct Keeper {
    log: EditLog,
    /// The brick that was taken, and where it was.
    taken: Option<(Entity, Transform)>,
}

/// Largest movement that is allowed of the wall that nobody touches, m.
const STANDS: f32 = 1e-3;
/// Movement from which on a brick is put back, m.
const FALLEN: f32 = 0.3;

impl Keeper {
    pub fn step(&mut self, world: &mut World, clock: Clock, faults: &mut Vec<String>) {
        if clock.strikes(1.0, 5.0) {
            watch(world, clock, faults);
        }
        if clock.strikes(12.0, 40.0) {
            self.take(world);
        }
        if clock.strikes(14.0, 40.0) {
            self.put_back(world, faults);
        }
        if clock.strikes(22.0, 20.0) {
            repair(world);
        }
    }

    /// Takes a brick from the top of the wall that nobody touches.
    fn take(&mut self, world: &mut World) {
        let mut bricks = world.query::<(Entity, &Brick, &Transform)>();
        let aside = bricks.iter(world).filter(|(_, brick, _)| brick.aside);
        let top = aside.max_by(|one, other| one.1.home.y.total_cmp(&other.1.home.y));
        self.taken = top.map(|(brick, _, at)| (brick, *at));
        if let Some((brick, _)) = self.taken {
            self.log.remove(world, &[brick]).expect("it is a body");
        }
    }

    /// Undoes that.
    fn put_back(&mut self, world: &mut World, faults: &mut Vec<String>) {
        let Some((brick, before)) = self.taken.take() else {
            return;
        };
        let undone = self.log.undo(world).ok().flatten();
        if undone.is_none_or(|report| report.bodies != [brick])
            || world.get::<Transform>(brick) != Some(&before)
        {
            faults.push(format!("undo has not brought {brick} back"));
        }
        world.resource_mut::<Tally>().undone += 1;
    }
}

/// Checks that the wall that nobody touches stands as it was laid.
fn watch(world: &mut World, clock: Clock, faults: &mut Vec<String>) {
    let mut bricks = world.query::<(Entity, &Brick, &Transform)>();
    let aside = bricks.iter(world).filter(|(_, brick, _)| brick.aside);
    let most = aside.map(|(entity, brick, at)| (moved(brick, at), entity));
    if let Some((most, brick)) = most.max_by(|one, other| one.0.total_cmp(&other.0))
        && most > STANDS
    {
        faults.push(format!(
            "{brick} of the untouched wall has moved by {:.2} mm after {:.0} s",
            1e3 * most,
            clock.seconds()
        ));
    }
}

/// Puts bricks back that have fallen, and new ones in the place of those that broke, from below, where there is room for them.
fn repair(world: &mut World) {
    let mut bricks = world.query::<(Entity, &Brick, &Transform, &Collider)>();
    let fallen = bricks
        .iter(world)
        .filter(|(_, brick, at, _)| moved(brick, at) > FALLEN);
    let fallen =
        fallen.map(|(entity, brick, _, collider)| (*brick, Some(entity), collider.clone()));
    let mut missing: Vec<(Brick, Option<Entity>, Collider)> = fallen.collect();
    let broken = std::mem::take(&mut world.resource_mut::<Broken>().bricks);
    missing.extend(broken.into_iter().map(|(brick, size)| {
        let collider = Collider::cuboid(size.x, size.y, size.z);
        (brick, None, collider)
    }));
    missing.sort_by(|one, other| {
        let order = one.0.home.y.total_cmp(&other.0.home.y);
        order.then(one.1.cmp(&other.1))
    });
    let mut repaired = 0;
    for (brick, entity, collider) in missing {
        let pose = Pose {
            position: brick.home,
            rotation: brick.turn,
        };
        let filter = QueryFilter::default();
        let fits = spatial_query(world, |query| {
            query.fits(&collider, pose, 0.01, &filter.excluding(entity.as_slice()))
        });
        match (fits.unwrap_or(false), entity) {
            (true, Some(entity)) => {
                let place = Transform::from_translation(brick.home).with_rotation(brick.turn);
                world
                    .entity_mut(entity)
                    .insert((place, Velocity::default()));
            }
            (true, None) => replace(world, brick, collider),
            (false, Some(_)) => continue,
            (false, None) => {
                let size = 2.0 * collider.half_extents();
                world.resource_mut::<Broken>().bricks.push((brick, size));
                continue;
            }
        }
        repaired += 1;
    }
    world.resource_mut::<Tally>().repaired += repaired;
}
