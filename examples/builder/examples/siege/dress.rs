//! The look of the game: a mesh of each collider, cells of the hill, water, ropes, and debris that fades.

use crate::castle::Brick;
use crate::drawbridge::Deck;
use crate::guard::{Guard, Obstacle};
use crate::lift::Platform;
use crate::moat::Barrel;
use crate::raiders::Raider;
use crate::trebuchet::{Beam, Stone};
use bevy::asset::RenderAssetUsages;
use bevy::ecs::query::QueryData;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use drystone::prelude::*;
use drystone_builder::look::mesh_of;
use drystone_builder::pieces::Shape;

/// Draws bodies as they are.
pub struct DressPlugin;

impl Plugin for DressPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, ground)
            .add_systems(Update, (dress, dig, fade, draw_ropes).chain());
    }
}

const STONES: [[f32; 3]; 4] = [
    [0.56, 0.50, 0.40],
    [0.48, 0.43, 0.36],
    [0.63, 0.57, 0.46],
    [0.42, 0.39, 0.34],
];
const WOOD: [f32; 3] = [0.36, 0.21, 0.10];
const IRON: [f32; 3] = [0.16, 0.16, 0.18];
const EARTH: [f32; 3] = [0.28, 0.25, 0.12];
const RED: [f32; 3] = [0.55, 0.08, 0.06];
const BLUE: [f32; 3] = [0.10, 0.20, 0.50];

/// Who somebody is, for the colour.
#[derive(QueryData)]
struct Who {
    entity: Entity,
    brick: Has<Brick>,
    debris: Has<Debris>,
    grid: Has<Voxels>,
    raider: Has<Raider>,
    guard: Has<Guard>,
    stone: Has<Stone>,
    deck: Has<Deck>,
    platform: Has<Platform>,
    barrel: Has<Barrel>,
    obstacle: Has<Obstacle>,
    beam: Has<Beam>,
    sensor: Has<Sensor>,
}

impl WhoItem<'_, '_> {
    fn tint(&self) -> [f32; 3] {
        let is_wooden = self.deck || self.platform || self.barrel || self.obstacle || self.beam;
        match () {
            () if self.grid => EARTH,
            () if self.brick || self.debris => {
                STONES[self.entity.index_u32() as usize % STONES.len()]
            }
            () if self.raider => RED,
            () if self.guard => BLUE,
            () if self.stone => IRON,
            () if is_wooden => WOOD,
            () => STONES[3],
        }
    }
}

/// Colliders that were added, except those of grids of cells.
type NewBody = (Added<Collider>, Without<VoxelChunk>, Without<Voxels>);

fn material([red, green, blue]: [f32; 3]) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(red, green, blue),
        perceptual_roughness: 0.9,
        reflectance: 0.2,
        ..default()
    }
}

fn ground(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mesh = meshes.add(Plane3d::default().mesh().size(400.0, 400.0));
    let grass = materials.add(material([0.30, 0.38, 0.20]));
    commands.spawn((Mesh3d(mesh), MeshMaterial3d(grass)));
}

/// Gives new bodies and fluids a mesh.
fn dress(
    new: Query<(&Collider, Option<&Fluid>, Who), NewBody>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut commands: Commands,
) {
    for (collider, fluid, who) in &new {
        if who.sensor && fluid.is_none() {
            continue;
        }
        let Some(mesh) = mesh(collider) else { continue };
        let material = match fluid {
            Some(_) => StandardMaterial {
                base_color: Color::srgba(0.12, 0.30, 0.45, 0.75),
                alpha_mode: AlphaMode::Blend,
                perceptual_roughness: 0.1,
                ..default()
            },
            None => material(who.tint()),
        };
        let look = (
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(materials.add(material)),
        );
        commands.entity(who.entity).insert(look);
    }
}

/// The mesh of a collider. The ground has one of its own.
fn mesh(collider: &Collider) -> Option<Mesh> {
    let shape = collider.shape();
    if let Some(cuboid) = shape.as_cuboid() {
        Some(mesh_of(&Shape::Box(2.0 * cuboid.half_extents)))
    } else if let Some(ball) = shape.as_ball() {
        Some(mesh_of(&Shape::Ball(ball.radius)))
    } else if let Some(hull) = shape.as_convex_polyhedron() {
        Some(mesh_of(&Shape::Hull(hull.points().to_vec())))
    } else if let Some(cylinder) = shape.as_cylinder() {
        Some(Cylinder::new(cylinder.radius, 2.0 * cylinder.half_height).into())
    } else {
        let capsule = shape.as_capsule()?;
        Some(Capsule3d::new(capsule.radius, 2.0 * capsule.half_height()).into())
    }
}

/// Draws the hill, and what came off it, anew after each charge: a square for each open side of a cell.
fn dig(
    changed: Query<(&Voxels, Option<&Mesh3d>, Who), Changed<Voxels>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut commands: Commands,
) {
    for (grid, drawn, who) in &changed {
        let mesh = cells(grid);
        if let Some(mut old) = drawn.and_then(|drawn| meshes.get_mut(drawn)) {
            *old = mesh;
            continue;
        }
        let material = materials.add(material(who.tint()));
        let look = (Mesh3d(meshes.add(mesh)), MeshMaterial3d(material));
        commands.entity(who.entity).insert(look);
    }
}

fn cells(grid: &Voxels) -> Mesh {
    let half = 0.5 * grid.size();
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (cell, side) in grid.faces() {
        let normal = side.as_vec3();
        let along = Vec3::new(normal.y, normal.z, normal.x);
        let across = normal.cross(along);
        let middle = grid.center_of(cell) + half * normal;
        let first = positions.len() as u32;
        for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            positions.push(middle + half * (u * along + v * across));
            normals.push(normal);
        }
        triangles.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_indices(Indices::U32(triangles))
}

/// Debris fades before it goes.
fn fade(
    debris: Query<(&Debris, &MeshMaterial3d<StandardMaterial>)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (debris, drawn) in &debris {
        let opacity = debris.opacity();
        if opacity < 1.0
            && let Some(mut material) = materials.get_mut(drawn)
        {
            material.base_color.set_alpha(opacity);
            material.alpha_mode = AlphaMode::Blend;
        }
    }
}

fn draw_ropes(
    ropes: Query<&DistanceJoint, Without<JointDisabled>>,
    places: Query<&Transform>,
    mut gizmos: Gizmos,
) {
    for rope in &ropes {
        let end = |body: Option<Entity>, frame: &JointFrame| {
            let JointAnchor::Local(point) = frame.anchor else {
                return None;
            };
            match body {
                Some(body) => Some(places.get(body).ok()?.transform_point(point)),
                None => Some(point),
            }
        };
        if let (Some(from), Some(to)) =
            (end(rope.body1, &rope.frame1), end(rope.body2, &rope.frame2))
        {
            gizmos.line(from, to, Color::srgb(0.25, 0.18, 0.10));
        }
    }
}
