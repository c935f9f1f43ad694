//! Brings bodies up to date with their grids.

use super::{VoxelChunk, Voxels, split};
use crate::body::collider::Collider;
use crate::body::{
    Beside, Density, Mass, MassProperties, Pose, RigidBody, Velocity, kept_components, pose_of,
    take_over, transform_of,
};
use crate::components::{holders_in, put, remove};
use crate::stored::erased::Values;
use bevy_ecs::component::Components;
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
        let (is_divided, is_edited) = (voxels.divided, !voxels.dirty.is_empty());
        let size = voxels.size();
        if is_divided && is_static {
            place_chunks(world, body);
        }
        if !is_edited && is_divided == is_static {
            continue;
        }
        if !(size > 0.0 && size.is_finite()) {
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
    // Taken out while the world is changed by it. That is no change for the user.
    let mut grid = std::mem::replace(voxels.bypass_change_detection(), Voxels::new(1.0));
    let was = Was::new(world, body);
    let emptied = std::mem::take(&mut grid.emptied);
    let parts = match emptied.is_empty() {
        true => Vec::new(),
        false => split::detached(&grid, &emptied, grid.ground().filter(|_| is_static)),
    };
    // Of each cell, if the user has set that of the body.
    let mass = was.mass.filter(|_| !parts.is_empty());
    let mass = mass.map(|mass| mass / grid.count() as f32);
    for cell in parts.iter().flatten() {
        grid.put(*cell, false);
    }
    if grid.divided != is_static {
        divide(world, body, &mut grid);
    }
    let mut dirty = std::mem::take(&mut grid.dirty);
    dirty.sort_unstable();
    dirty.dedup();
    if is_static {
        for key in dirty {
            make_chunk(world, body, (&mut grid, &was.kept), key);
        }
    } else {
        make_whole(world, body, &grid);
    }
    let size = grid.size();
    if let Some(mass) = mass {
        put(world, body, Mass(mass * grid.count() as f32));
    }
    // Observers may have despawned the body meanwhile.
    let Some(mut voxels) = world.get_mut::<Voxels>(body) else {
        for chunk in grid.chunk_bodies() {
            world.try_despawn(chunk).ok();
        }
        return;
    };
    *voxels.bypass_change_detection() = grid;
    if !parts.is_empty() {
        voxels.set_changed();
    }
    if !is_static && was.has_shape {
        keep_moving(world, body, &was);
    }
    for part in &parts {
        spawn_part(world, (part, size), &was, mass);
    }
}

/// Gives a body the velocity of its new centre of mass.
fn keep_moving(world: &mut World, body: Entity, was: &Was) {
    let mass = world.get::<MassProperties>(body);
    if let Some(center) = mass.map(|mass| mass.local_center)
        && let Some(mut velocity) = world.get_mut::<Velocity>(body)
    {
        velocity.linear = was.velocity_at(center);
    }
}

/// A body before an edit.
struct Was {
    beside: Beside,
    pose: Pose,
    velocity: Velocity,
    /// Its centre of mass in its frame, m.
    center: Vec3,
    has_shape: bool,
    /// Set by the user, kg.
    mass: Option<f32>,
    density: Option<Density>,
    /// Its surface, layers and so on.
    kept: Vec<Values>,
}

impl Was {
    fn new(world: &World, body: Entity) -> Self {
        let of = world.entity(body);
        let pose = pose_of(world, body);
        let mass = of.get::<MassProperties>();
        Self {
            beside: Beside::new(world, body, pose),
            pose,
            velocity: of.get::<Velocity>().copied().unwrap_or_default(),
            center: mass.map_or(Vec3::ZERO, |mass| mass.local_center),
            has_shape: of.contains::<Collider>(),
            mass: of.get::<Mass>().map(|mass| mass.0),
            density: of.get::<Density>().copied(),
            kept: kept_components(world, body),
        }
    }

    /// The velocity of a point of the body's frame, m/s, world.
    fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(self.pose.rotation * (point - self.center))
    }
}

/// Moves the chunks of a body to where it is.
fn place_chunks(world: &mut World, body: Entity) {
    let to = transform_of(world, body);
    let Some(mut voxels) = world.get_mut::<Voxels>(body) else {
        return;
    };
    if voxels.placed == to {
        return;
    }
    let voxels = voxels.bypass_change_detection();
    voxels.placed = to;
    let chunks: Vec<Entity> = voxels.chunk_bodies().collect();
    for chunk in chunks {
        if let Some(mut at) = world.get_mut::<Transform>(chunk) {
            *at = to.to_transform();
        }
    }
}

/// Has the chunks of a body become bodies of their own, or no longer be.
fn divide(world: &mut World, body: Entity, grid: &mut Voxels) {
    grid.divided = !grid.divided;
    if grid.divided {
        remove(world, body, &[Components::component_id::<Collider>]);
        grid.placed = transform_of(world, body);
    }
    for chunk in grid.chunks.values_mut() {
        if let Some(entity) = chunk.entity.take() {
            world.try_despawn(entity).ok();
        }
    }
    grid.dirty.extend(grid.chunks.keys());
}

/// Makes the body of a chunk of a static body anew, or removes it if it has none.
fn make_chunk(
    world: &mut World,
    body: Entity,
    (grid, kept): (&mut Voxels, &[Values]),
    key: [i32; 3],
) {
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
            let at = grid.placed.to_transform();
            let chunk = (RigidBody::Static, collider, at, VoxelChunk(body));
            let chunk = world.spawn(chunk).id();
            take_over(world, kept, chunk);
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
        Some(collider) => put(world, body, collider),
        None => remove(world, body, &[Components::component_id::<Collider>]),
    }
}

fn compound(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Option<Collider> {
    let parts = boxes.map(|(at, size)| {
        let part = Collider::cuboid(size.x, size.y, size.z);
        (at, Quat::IDENTITY, part)
    });
    Collider::compound(parts.collect()).ok()
}

/// Spawns a part that came off, as a dynamic body with a grid of its own. `mass` is that of a cell, kg, if the user has set it.
fn spawn_part(world: &mut World, (cells, size): (&[IVec3], f32), was: &Was, mass: Option<f32>) {
    let least = cells.iter().copied().reduce(IVec3::min).unwrap_or_default();
    let mut grid = Voxels::new(size);
    for &cell in cells {
        grid.set(cell - least, true);
    }
    let sum: Vec3 = cells.iter().map(|cell| cell.as_vec3() + 0.5).sum();
    let center = sum / cells.len() as f32 * size;
    let velocity = Velocity {
        linear: was.velocity_at(center),
        angular: was.velocity.angular,
    };
    let at = was.beside.transform(least.as_vec3() * size);
    let part = world.spawn((RigidBody::Dynamic, grid, at, velocity)).id();
    take_over(world, &was.kept, part);
    was.beside.join(world, part);
    match (mass, was.density) {
        (Some(mass), _) => put(world, part, Mass(mass * cells.len() as f32)),
        (None, Some(density)) => put(world, part, density),
        (None, None) => (),
    }
    update(world, part, false);
}
