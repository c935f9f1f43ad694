//! The look of bodies.

mod mesh;

pub use mesh::mesh_of;

use crate::BuilderSystems;
use crate::pieces::{Piece, Shape};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Gives every new [`Piece`] a mesh and a material.
pub struct LookPlugin;

impl Plugin for LookPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Meshes>()
            .init_resource::<Materials>()
            .add_systems(Update, dress.in_set(BuilderSystems::Show));
    }
}

/// The material of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Finish {
    /// Burnt clay.
    Brick,
    /// Limestone.
    Stone,
    /// Planks.
    Wood,
    /// Balls.
    Iron,
}

impl Finish {
    const ALL: [Self; 4] = [Self::Brick, Self::Stone, Self::Wood, Self::Iron];

    /// kg/m³
    pub fn density(self) -> f32 {
        match self {
            Self::Brick => 1800.0,
            Self::Stone => 2400.0,
            Self::Wood => 700.0,
            Self::Iron => 7800.0,
        }
    }

    /// The finish whose density is nearest, kg/m³.
    pub fn of_density(density: f32) -> Self {
        let distance = |finish: &Self| (finish.density() - density).abs();
        let nearest = Self::ALL
            .into_iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(Self::Brick)
    }

    /// Its tints, in hue (°), saturation and lightness.
    fn tints(self) -> &'static [[f32; 3]] {
        match self {
            Self::Brick => &[
                [13.0, 0.46, 0.42],
                [15.0, 0.48, 0.45],
                [11.0, 0.42, 0.38],
                [18.0, 0.46, 0.48],
                [14.0, 0.38, 0.40],
                [20.0, 0.42, 0.51],
                [9.0, 0.36, 0.36],
                [16.0, 0.50, 0.43],
            ],
            Self::Stone => &[
                [42.0, 0.24, 0.68],
                [38.0, 0.20, 0.60],
                [46.0, 0.18, 0.74],
                [34.0, 0.16, 0.55],
                [40.0, 0.28, 0.64],
                [48.0, 0.14, 0.66],
            ],
            Self::Wood => &[
                [32.0, 0.52, 0.52],
                [36.0, 0.48, 0.58],
                [29.0, 0.50, 0.45],
                [38.0, 0.55, 0.62],
            ],
            Self::Iron => &[[215.0, 0.08, 0.26], [205.0, 0.06, 0.32]],
        }
    }

    fn material(self, [hue, saturation, lightness]: [f32; 3]) -> StandardMaterial {
        StandardMaterial {
            base_color: Color::hsl(hue, saturation, lightness),
            perceptual_roughness: if self == Self::Iron { 0.35 } else { 0.85 },
            metallic: if self == Self::Iron { 0.7 } else { 0.0 },
            reflectance: 0.3,
            ..default()
        }
    }
}

/// Shades of a scale from nothing, blue, to all, red.
pub const SHADES: usize = 48;

/// All materials are made once: bodies of one material are drawn together.
#[derive(Resource)]
pub struct Materials {
    tints: HashMap<Finish, Vec<Handle<StandardMaterial>>>,
    /// From blue to red.
    pub scale: Vec<Handle<StandardMaterial>>,
    /// One for each island, by turns.
    pub hues: Vec<Handle<StandardMaterial>>,
    /// Bodies that would fall.
    pub falls: Handle<StandardMaterial>,
    /// Bodies that fail first.
    pub gives: Handle<StandardMaterial>,
    /// Sleeping bodies, and those awake.
    pub asleep: Handle<StandardMaterial>,
    /// See `asleep`.
    pub awake: Handle<StandardMaterial>,
    /// Sleeping bodies that awake ones have touched, which wake if the forces on them change by some more.
    pub touched: Handle<StandardMaterial>,
    /// The material of a ghost that could be laid; the next is that of one that could not.
    pub fits: Handle<StandardMaterial>,
    /// See `fits`.
    pub blocked: Handle<StandardMaterial>,
}

impl FromWorld for Materials {
    fn from_world(world: &mut World) -> Self {
        let mut assets = world.resource_mut::<Assets<StandardMaterial>>();
        let mut plain = |color: Color| {
            assets.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: 0.8,
                alpha_mode: match color.alpha() {
                    1.0 => AlphaMode::Opaque,
                    _ => AlphaMode::Blend,
                },
                ..default()
            })
        };
        let share = |i: usize| i as f32 / (SHADES - 1) as f32;
        let scale = (0..SHADES).map(|i| plain(Color::hsl(235.0 * (1.0 - share(i)), 0.75, 0.5)));
        let scale = scale.collect();
        // Golden angle: neighbours in number are far apart in hue.
        let hues = (0..24).map(|i| plain(Color::hsl(i as f32 * 137.508 % 360.0, 0.6, 0.55)));
        let hues = hues.collect();
        let falls = plain(Color::srgb(0.95, 0.16, 0.12));
        let gives = plain(Color::srgb(0.98, 0.62, 0.10));
        let asleep = plain(Color::srgb(0.42, 0.48, 0.58));
        let awake = plain(Color::srgb(0.98, 0.80, 0.30));
        let touched = plain(Color::srgb(0.25, 0.62, 0.88));
        let fits = plain(Color::srgba(0.35, 0.95, 0.45, 0.55));
        let blocked = plain(Color::srgba(0.98, 0.25, 0.20, 0.55));
        let tints = Finish::ALL.map(|finish| {
            let tints = finish.tints().iter();
            let tints = tints.map(|&tint| assets.add(finish.material(tint)));
            (finish, tints.collect())
        });
        Self {
            tints: tints.into_iter().collect(),
            scale,
            hues,
            falls,
            gives,
            asleep,
            awake,
            touched,
            fits,
            blocked,
        }
    }
}

impl Materials {
    /// One of the tints of a finish.
    pub fn tint(&self, finish: Finish, number: usize) -> Handle<StandardMaterial> {
        let tints = &self.tints[&finish];
        tints[number % tints.len()].clone()
    }

    /// A share from 0 to 1 as a colour.
    pub fn shade(&self, share: f32) -> &Handle<StandardMaterial> {
        let last = (SHADES - 1) as f32;
        &self.scale[(share.clamp(0.0, 1.0) * last).round() as usize]
    }
}

/// Meshes by shape; of equal pieces there is one.
#[derive(Resource, Default)]
pub struct Meshes(Vec<(Shape, Handle<Mesh>)>);

impl Meshes {
    /// The mesh of a shape.
    pub fn of(&mut self, shape: &Shape, assets: &mut Assets<Mesh>) -> Handle<Mesh> {
        if let Some((_, mesh)) = self.0.iter().find(|(of, _)| of == shape) {
            return mesh.clone();
        }
        let mesh = assets.add(mesh_of(shape));
        self.0.push((shape.clone(), mesh.clone()));
        mesh
    }
}

/// The material that a body has while no overlay gives it another.
#[derive(Component, Clone)]
pub struct Own(pub Handle<StandardMaterial>);

fn dress(
    mut commands: Commands,
    materials: Res<Materials>,
    mut meshes: ResMut<Meshes>,
    mut assets: ResMut<Assets<Mesh>>,
    new: Query<(Entity, &Piece, &Transform), Without<Own>>,
) {
    for (entity, piece, at) in &new {
        // Neighbours differ, and a scene looks the same every time.
        let [x, y, z] = (at.translation * 100.0)
            .to_array()
            .map(|x| x.round() as i64);
        let number = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)) as usize
            ^ z.wrapping_mul(83_492_791) as usize;
        let own = materials.tint(piece.finish, (number >> 3) % 1_000_003);
        commands.entity(entity).insert((
            Mesh3d(meshes.of(&piece.shape, &mut assets)),
            MeshMaterial3d(own.clone()),
            Own(own),
        ));
    }
}
