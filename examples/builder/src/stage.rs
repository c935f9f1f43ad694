//! The ground, the sun and the sky.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, GlobalAmbientLight};
use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use drystone::prelude::*;

/// Ground, sun and sky.
pub struct StagePlugin;

/// The sky.
pub const SKY: Color = Color::srgb(0.66, 0.77, 0.88);

/// Into which the ground fades; tone mapping, which leaves the sky alone, makes it that.
pub const HAZE: Color = Color::srgb(0.76, 0.90, 1.04);

/// Edge of the ground that is drawn, and of a flagstone, m.
const GROUND: f32 = 1600.0;
const FLAG: f32 = 2.0;

impl Plugin for StagePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(ClearColor(SKY))
            .insert_resource(DirectionalLightShadowMap { size: 2048 })
            .insert_resource(GlobalAmbientLight {
                color: Color::srgb(0.75, 0.85, 1.0),
                brightness: 550.0,
                ..default()
            })
            .add_systems(Startup, (sun, ground));
    }
}

/// The sun: a light that shines from a place to the origin. Its shadows are sharp up to a distance from the camera, and end at another, m.
pub fn sunlight(color: Color, from: Vec3, sharp: f32, end: f32) -> impl Bundle {
    (
        DirectionalLight {
            color,
            illuminance: 9_500.0,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: sharp,
            maximum_distance: end,
            ..default()
        }
        .build(),
        shines(from),
    )
}

fn shines(from: Vec3) -> Transform {
    Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y)
}

fn sun(mut commands: Commands) {
    let color = Color::srgb(1.0, 0.94, 0.84);
    commands.spawn(sunlight(color, Vec3::new(5.0, 9.0, 6.0), 14.0, 60.0));
    // The light that the sky reflects.
    commands.spawn((
        DirectionalLight {
            color: Color::srgb(0.7, 0.82, 1.0),
            illuminance: 1_600.0,
            ..default()
        },
        shines(Vec3::new(-6.0, 4.0, -5.0)),
    ));
}

fn ground(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(GROUND, GROUND))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color_texture: Some(images.add(flagstones())),
            uv_transform: Affine2::from_scale(Vec2::splat(GROUND / (4.0 * FLAG))),
            perceptual_roughness: 0.95,
            reflectance: 0.2,
            ..default()
        })),
    ));
}

/// Four by four flagstones of a little different grey, with joints between them.
fn flagstones() -> Image {
    const PIXELS: usize = 256;
    let mut rng = fastrand::Rng::with_seed(7);
    let tones: Vec<f32> = (0..16).map(|_| rng.f32()).collect();
    let mut data = Vec::with_capacity(4 * PIXELS * PIXELS);
    for y in 0..PIXELS {
        for x in 0..PIXELS {
            let flag = PIXELS / 4;
            let edge = [x, y].map(|at| (at % flag).min(flag - 1 - at % flag));
            let joint = edge[0].min(edge[1]) < 1;
            let tone = 0.44 + 0.05 * tones[x / flag + 4 * (y / flag)] + 0.02 * rng.f32();
            let tone = if joint { tone - 0.09 } else { tone };
            let byte = |share: f32| (255.0 * tone * share) as u8;
            data.extend([byte(0.98), byte(1.0), byte(0.94), 255]);
        }
    }
    let size = Extent3d {
        width: PIXELS as u32,
        height: PIXELS as u32,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        ..default()
    });
    image
}
