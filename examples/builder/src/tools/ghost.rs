//! A ghost that shows the pose that the piece in hand would get.

use super::{Carried, Choice, Tool};
use crate::camera::Pointer;
use crate::look::{Materials, Meshes};
use crate::pieces::{Piece, Shape, to_transform};
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::prelude::*;
use drystone::masonry::snap;
use drystone::prelude::*;
use std::f32::consts::FRAC_PI_2;

/// The place of the piece at the mouse, if it has one.
#[derive(Resource, Default)]
pub struct Ghost(pub Option<(Piece, Spot)>);

/// A place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where.
    pub pose: Pose,
    /// There is room.
    pub fits: bool,
}

/// Overlap that settled bodies may have, m.
const TOLERANCE: f32 = 5e-3;

/// On bare ground pieces keep to a grid, m.
const GRID: f32 = 0.25;

/// A body that leans farther than this cannot carry a course.
const UPRIGHT: f32 = 0.998;

/// The mesh of it.
#[derive(Component)]
pub(super) struct Outline;

pub(super) fn spawn(mut commands: Commands) {
    commands.spawn((
        Outline,
        NotShadowCaster,
        NotShadowReceiver,
        Visibility::Hidden,
    ));
}

pub(super) fn find(
    mut ghost: ResMut<Ghost>,
    world: SpatialQuery,
    pointer: Res<Pointer>,
    keys: Res<ButtonInput<KeyCode>>,
    (tool, choice, carried): (Res<Tool>, Res<Choice>, Res<Carried>),
    pieces: Query<(&Piece, &Pose)>,
) {
    ghost.0 = None;
    let Some(ray) = pointer.ray.filter(|_| pointer.hit.is_some()) else {
        return;
    };
    let (piece, excluded) = match (*tool, carried.0) {
        (Tool::Lay, _) => (&choice.piece, None),
        (Tool::Move, Some(body)) => match pieces.get(body) {
            Ok((piece, _)) => (piece, Some(body)),
            Err(_) => return,
        },
        _ => return,
    };
    let filter = QueryFilter::default().excluding(excluded.as_slice());
    let Ok(Some(hit)) = world.cast_ray(ray, 200.0, &filter) else {
        return;
    };
    let free = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let under = pieces.get(hit.entity).ok();
    let pose = place_for(&piece.shape, choice.yaw, &hit, under, free);
    let fits = piece.shape.collider().ok().is_some_and(|collider| {
        let fits = world.fits(&collider, pose, TOLERANCE, &filter);
        fits.unwrap_or(false)
    });
    ghost.0 = Some((piece.clone(), Spot { pose, fits }));
}

/// In the bond of the body under the mouse, if both are boxes and that one is level; otherwise where it touches.
fn place_for(
    shape: &Shape,
    yaw: f32,
    hit: &RayHit,
    under: Option<(&Piece, &Pose)>,
    free: bool,
) -> Pose {
    if !free
        && let Shape::Box(size) = *shape
        && let Some((piece, pose)) = under
        && let Shape::Box(other) = piece.shape
        && (pose.rotation * Vec3::Y).y > UPRIGHT
    {
        let across = (yaw / FRAC_PI_2).round() as i32 % 2 != 0;
        let (point, normal) = (hit.point, hit.normal);
        if let Some(snapped) = snap(size, across, pose, other, point, normal) {
            return snapped.pose;
        }
    }
    let rotation = Quat::from_rotation_y(yaw);
    let half = shape.half_extents(rotation);
    let normal = hit.normal;
    let mut position = hit.point + normal * half.dot(normal.abs());
    if !free && under.is_none() {
        // Its edges on the grid, not its middle.
        let on_grid = |at: f32, half: f32| ((at - half) / GRID).round() * GRID + half;
        position.x = on_grid(position.x, half.x);
        position.z = on_grid(position.z, half.z);
    }
    position.y = position.y.max(half.y);
    Pose { position, rotation }
}

pub(super) fn draw(
    mut commands: Commands,
    ghost: Res<Ghost>,
    materials: Res<Materials>,
    mut meshes: ResMut<Meshes>,
    mut assets: ResMut<Assets<Mesh>>,
    outline: Single<Entity, With<Outline>>,
) {
    let mut outline = commands.entity(*outline);
    let Some((piece, spot)) = &ghost.0 else {
        outline.insert(Visibility::Hidden);
        return;
    };
    let material = match spot.fits {
        true => &materials.fits,
        false => &materials.blocked,
    };
    outline.insert((
        Visibility::Visible,
        Mesh3d(meshes.of(&piece.shape, &mut assets)),
        MeshMaterial3d(material.clone()),
        // A little larger: what it would replace does not show through.
        to_transform(spot.pose).with_scale(Vec3::splat(1.004)),
    ));
}
