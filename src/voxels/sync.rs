//! Brings bodies up to date with their grids.

use super::{VoxelChunk, Voxels, split};
use crate::body::collider::Collider;
use crate::body::{Density, Mass, MassProperties, Pose, RigidBody, Velocity, kept_components};
use crate::components::holders_in;
use crate::stored::erased::Values;
use bevy_ecs::component::Components;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{IVec3, Quat, Vec3};

/// Splits off what is no longer joined, and makes the colliders of chunks that were edited. Part of [`VoxelSystems`](super::VoxelSystems).
pub fn voxels(world: &mut World) {
    for body in holders_in(world, &[Components::component_id::<Voxels>]) {
        let of = world.entity(body);
        let (Some(voxels), Some(kind)) = (of.get::<Voxels>(), of.get::<RigidBody>()) else {
            continue;
        };
        let is_static = *kind == RigidBody::Static;
        if voxels.divided && is_static {
            place_chunks(world, body);
        }
        let Some(voxels) = world.get::<Voxels>(body) else {
            continue;
        };
        if voxels.dirty.is_empty() && voxels.divided == is_static {
            continue;
        }
        if !(voxels.size() > 0.0 && voxels.size().is_finite()) {
            tracing::error!("the voxels of {body} are removed: their size must be positive");
            world.entity_mut(body).remove::<Voxels>();
            continue;
        }
        update(world, body, is_static);
    }
}

fn update(world: &mut World, body: Entity, is_static: bool) {
    let Some(mut voxels) = world.get_mut::<Voxels>(body) else {
        return;
    };
    // Nothing that users have written.
    let mut grid = std::mem::replace(voxels.bypass_change_detection(), Voxels::new(1.0));
    let emptied = std::mem::take(&mut grid.emptied);
    let parts = match emptied.is_empty() {
        true => Vec::new(),
        false => split::detached(&grid, &emptied, grid.ground().filter(|_| is_static)),
    };
    let before = match parts.is_empty() {
        true => 0,
        false => grid.count(),
    };
    for part in &parts {
        for &cell in part {
            grid.take(cell);
        }
    }
    if grid.divided != is_static {
        divide(world, body, &mut grid);
    }
    let mut dirty = std::mem::take(&mut grid.dirty);
    dirty.sort_unstable();
    dirty.dedup();
    let was = Motion::of(world, body);
    let had_shape = world.entity(body).contains::<Collider>();
    let mass = world
        .get::<Mass>(body)
        .map(|mass| mass.0 / before.max(1) as f32);
    if is_static {
        for key in dirty {
            make_chunk(world, body, &mut grid, key);
        }
    } else {
        make_whole(world, body, &grid);
    }
    let size = grid.size();
    let left = before - parts.iter().map(Vec::len).sum::<usize>();
    if let Some(mut voxels) = world.get_mut::<Voxels>(body) {
        *voxels.bypass_change_detection() = grid;
        if !parts.is_empty() {
            voxels.set_changed();
        }
    }
    for part in &parts {
        let mass = mass.map(|mass| Mass(mass * part.len() as f32));
        spawn_part(world, body, (part, size), &was, mass);
    }
    if let (Some(mass), false) = (mass, parts.is_empty()) {
        world.entity_mut(body).insert(Mass(mass * left as f32));
    }
    // The centre of mass has another velocity than the old one.
    if !is_static
        && had_shape
        && let Some(center) = world
            .get::<MassProperties>(body)
            .map(|mass| mass.local_center)
        && let Some(mut velocity) = world.get_mut::<Velocity>(body)
    {
        velocity.linear = was.velocity_at(center);
    }
}

/// The motion of a body before an edit.
struct Motion {
    rotation: Quat,
    velocity: Velocity,
    /// In the frame of the body, m.
    center: Vec3,
}

impl Motion {
    fn of(world: &World, body: Entity) -> Self {
        let of = world.entity(body);
        let velocity = of.get::<Velocity>().copied().unwrap_or_default();
        let mass = of.get::<MassProperties>();
        Self {
            rotation: of
                .get::<Pose>()
                .map_or(Quat::IDENTITY, |pose| pose.rotation),
            velocity,
            center: mass.map_or(Vec3::ZERO, |mass| mass.local_center),
        }
    }

    /// The velocity of a point of the body's frame, m/s, world.
    fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(self.rotation * (point - self.center))
    }
}

/// Moves the chunks of a body to where it is.
fn place_chunks(world: &mut World, body: Entity) {
    let to = place_of(world, body);
    let Some(mut voxels) = world.get_mut::<Voxels>(body) else {
        return;
    };
    if voxels.placed == to {
        return;
    }
    let voxels = voxels.bypass_change_detection();
    voxels.placed = to;
    let chunks = voxels.chunks.values().filter_map(|chunk| chunk.entity);
    let chunks: Vec<Entity> = chunks.collect();
    for chunk in chunks {
        if let Some(mut at) = world.get_mut::<Transform>(chunk) {
            *at = to_transform(to);
        }
    }
}

/// Where the user has put a body, without scale.
fn place_of(world: &World, body: Entity) -> Pose {
    let at = |entity: Entity| world.get::<Transform>(entity).copied().unwrap_or_default();
    let (mut frame, mut below) = (at(body), body);
    while let Some(&ChildOf(above)) = world.get::<ChildOf>(below) {
        frame = at(above) * frame;
        below = above;
    }
    Pose {
        position: frame.translation,
        rotation: frame.rotation,
    }
}

fn to_transform(pose: Pose) -> Transform {
    Transform::from_translation(pose.position).with_rotation(pose.rotation)
}

/// Has the chunks of a body become bodies of their own, or no longer be.
fn divide(world: &mut World, body: Entity, grid: &mut Voxels) {
    grid.divided = !grid.divided;
    if grid.divided {
        world.entity_mut(body).remove::<Collider>();
        grid.placed = place_of(world, body);
    }
    for chunk in grid.chunks.values_mut() {
        if let Some(entity) = chunk.entity.take() {
            world.try_despawn(entity).ok();
        }
    }
    grid.dirty.extend(grid.chunks.keys());
}

/// Makes the body of a chunk of a static body anew, or removes it if it has none.
fn make_chunk(world: &mut World, body: Entity, grid: &mut Voxels, key: [i32; 3]) {
    let Some(chunk) = grid.chunks.get(&key) else {
        return;
    };
    let (is_empty, entity) = (chunk.cells.is_empty(), chunk.entity);
    let entity = entity.filter(|&entity| world.get_entity(entity).is_ok());
    let collider = match is_empty || grid.is_buried(key) {
        true => None,
        false => compound(grid.boxes_of(key)),
    };
    let made = match (entity, collider) {
        (Some(entity), Some(collider)) => {
            world.entity_mut(entity).insert(collider);
            Some(entity)
        }
        (Some(entity), None) => {
            world.despawn(entity);
            None
        }
        (None, Some(collider)) => {
            let at = to_transform(grid.placed);
            let chunk = (RigidBody::Static, collider, at, VoxelChunk(body));
            let chunk = world.spawn(chunk).id();
            take_over(world, body, chunk);
            Some(chunk)
        }
        (None, None) => None,
    };
    match grid.chunks.get_mut(&key) {
        Some(_) if is_empty => _ = grid.chunks.remove(&key),
        Some(chunk) => chunk.entity = made,
        None => (),
    }
}

/// Makes the collider of a body that moves anew, or removes it if no cell is filled.
fn make_whole(world: &mut World, body: Entity, grid: &Voxels) {
    let boxes = grid.chunks.keys().flat_map(|key| grid.boxes_of(*key));
    match compound(boxes) {
        Some(collider) => _ = world.entity_mut(body).insert(collider),
        None => _ = world.entity_mut(body).remove::<Collider>(),
    }
}

fn compound(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Option<Collider> {
    let parts = boxes.map(|(at, size)| {
        let part = Collider::cuboid(size.x, size.y, size.z);
        (at, Quat::IDENTITY, part)
    });
    Collider::compound(parts.collect()).ok()
}

/// Gives a body the surface, layers and so on of another one.
fn take_over(world: &mut World, from: Entity, to: Entity) {
    let mut copies = kept_components(world, from);
    if !copies.is_empty() {
        Values::insert_all_into(&mut copies, &mut world.entity_mut(to));
    }
}

/// Spawns a part that came off, as a dynamic body with a grid of its own.
fn spawn_part(
    world: &mut World,
    from: Entity,
    (cells, size): (&[IVec3], f32),
    was: &Motion,
    mass: Option<Mass>,
) {
    let least = cells.iter().copied().reduce(IVec3::min).unwrap_or_default();
    let mut grid = Voxels::new(size);
    for &cell in cells {
        grid.set(cell - least, true);
    }
    let corner = least.as_vec3() * size;
    let of = world.entity(from);
    let placed = match (of.get::<Transform>(), of.get::<Pose>()) {
        (Some(transform), _) if of.contains::<ChildOf>() => *transform,
        (_, Some(pose)) => Transform::from_translation(pose.position).with_rotation(pose.rotation),
        (Some(transform), None) => *transform,
        (None, None) => Transform::IDENTITY,
    };
    let parent = of.get::<ChildOf>().map(|parent| parent.0);
    let density = of.get::<Density>().copied();
    let sum: Vec3 = cells.iter().map(|cell| cell.as_vec3() + 0.5).sum();
    let center = sum / cells.len() as f32 * size;
    let velocity = Velocity {
        linear: was.velocity_at(center),
        angular: was.velocity.angular,
    };
    let at =
        Transform::from_translation(placed.transform_point(corner)).with_rotation(placed.rotation);
    let part = world.spawn((RigidBody::Dynamic, grid, at, velocity)).id();
    take_over(world, from, part);
    let mut part = world.entity_mut(part);
    if let Some(parent) = parent {
        part.insert(ChildOf(parent));
    }
    if let Some(mass) = mass {
        part.insert(mass);
    } else if let Some(density) = density {
        part.insert(density);
    }
    let part = part.id();
    update(world, part, false);
}
