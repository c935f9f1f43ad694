//! An orbiting camera, and the body under the mouse.

use crate::BuilderSystems;
use crate::compare::Comparison;
use crate::tools::Tool;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit};
use bevy::light::ShadowFilteringMethod;
use bevy::pbr::{DistanceFog, FogFalloff};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::input::EguiWantsInput;
use drystone::prelude::*;

/// The camera and the [`Pointer`].
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Pointer>()
            .init_resource::<View>()
            .init_resource::<PanelWidth>()
            .add_systems(Startup, spawn)
            .add_systems(
                Update,
                (orbit, place, point).chain().in_set(BuilderSystems::Point),
            );
    }
}

/// Where the camera looks from.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The point that it looks at, m.
    pub target: Vec3,
    /// From there, m.
    pub distance: f32,
    /// About the vertical, from +z towards +x, rad.
    pub yaw: f32,
    /// Above the horizon, rad.
    pub pitch: f32,
}

impl Default for View {
    fn default() -> Self {
        Self {
            target: Vec3::Y * 2.0,
            distance: 14.0,
            yaw: 0.45,
            pitch: 0.3,
        }
    }
}

impl View {
    /// The camera's transform.
    pub fn transform(&self) -> Transform {
        let turn = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0);
        Transform::from_translation(self.target + turn * Vec3::Z * self.distance)
            .looking_at(self.target, Vec3::Y)
    }

    /// Turns about the target, for a movement of the mouse in pixels.
    pub fn turn(&mut self, mouse: Vec2) {
        self.yaw -= 0.006 * mouse.x;
        self.pitch = (self.pitch + 0.006 * mouse.y).clamp(-0.05, 1.5);
    }

    /// Goes nearer, for so many notches of the wheel.
    pub fn zoom(&mut self, notches: f32) {
        self.distance = (self.distance * 0.88f32.powf(notches)).clamp(1.5, 120.0);
    }
}

/// The builder's camera.
#[derive(Component)]
pub struct Eye;

/// How wide the panel is at the left, logical pixels. Bodies behind it are not pointed at.
#[derive(Resource, Default)]
pub struct PanelWidth(pub f32);

/// The body under the mouse.
#[derive(Resource, Default)]
pub struct Pointer {
    /// `None` if the pointer is outside of the window or over the panel.
    pub ray: Option<Ray3d>,
    /// The first body there.
    pub hit: Option<RayHit>,
    /// The first dynamic body there, if nothing is before it.
    pub body: Option<Entity>,
}

/// The components of a camera besides its pose and target.
pub fn lens() -> impl Bundle {
    (
        Camera3d::default(),
        Projection::Perspective(PerspectiveProjection {
            fov: 0.7,
            ..default()
        }),
        Tonemapping::AcesFitted,
        ShadowFilteringMethod::Gaussian,
        DistanceFog {
            color: crate::stage::HAZE,
            falloff: FogFalloff::Linear {
                start: 40.0,
                end: 160.0,
            },
            ..default()
        },
        Eye,
    )
}

fn spawn(mut commands: Commands, eyes: Query<(), With<Eye>>) {
    // A camera that draws to an image exists already.
    if eyes.is_empty() {
        commands.spawn(lens());
    }
}

/// The right button turns, the middle one shifts, the wheel goes nearer.
fn orbit(
    mut view: ResMut<View>,
    buttons: Res<ButtonInput<MouseButton>>,
    (motion, scroll): (Res<AccumulatedMouseMotion>, Res<AccumulatedMouseScroll>),
    (pointer, tool): (Res<Pointer>, Res<Tool>),
) {
    // Over the panel, or outside of the window; what began in the scene goes on.
    let dragged = buttons.any_pressed([MouseButton::Right, MouseButton::Middle]);
    if pointer.ray.is_none() && !dragged {
        return;
    }
    let turn = Quat::from_euler(EulerRot::YXZ, view.yaw, -view.pitch, 0.0);
    if buttons.pressed(MouseButton::Right) {
        view.turn(motion.delta);
    }
    if buttons.pressed(MouseButton::Middle) {
        let shift = turn * Vec3::new(-motion.delta.x, motion.delta.y, 0.0);
        let far = 0.0014 * view.distance;
        view.target += far * shift;
        view.target.y = view.target.y.max(0.0);
    }
    // A hand that holds something moves that with the wheel.
    let holds = *tool == Tool::Hand && buttons.pressed(MouseButton::Left);
    if scroll.delta.y != 0.0 && !holds {
        view.zoom(notches(&scroll));
    }
}

/// Notches of the wheel, whatever it is.
pub fn notches(scroll: &AccumulatedMouseScroll) -> f32 {
    match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / 50.0,
    }
}

/// Moves the camera to the [`View`] when that has changed.
pub fn place(view: Res<View>, mut eyes: Query<&mut Transform, With<Eye>>) {
    if view.is_changed() {
        for mut eye in &mut eyes {
            *eye = view.transform();
        }
    }
}

fn point(
    mut pointer: ResMut<Pointer>,
    world: SpatialQuery,
    (panel, width): (Option<Res<EguiWantsInput>>, Res<PanelWidth>),
    comparison: Res<Comparison>,
    windows: Query<&Window, With<PrimaryWindow>>,
    eyes: Query<(&Camera, &GlobalTransform), With<Eye>>,
    kinds: Query<&RigidBody>,
) {
    // Without a window whoever draws pictures points.
    if windows.is_empty() {
        return;
    }
    let over_panel = panel.is_some_and(|panel| panel.wants_any_pointer_input());
    let cursor = windows.single().ok().and_then(Window::cursor_position);
    let cursor = cursor.filter(|cursor| !over_panel && cursor.x >= width.0);
    let ray = eyes.single().ok().zip(cursor);
    let ray = ray.and_then(|((camera, at), cursor)| camera.viewport_to_world(at, cursor).ok());
    // While copies are shown nothing is where it is seen.
    let aim = ray.filter(|_| !comparison.is_on());
    let hit = aim.and_then(|ray| {
        let hit = world.cast_ray(ray, 500.0, &QueryFilter::default());
        hit.ok().flatten()
    });
    let body = hit.map(|hit| hit.entity);
    let is_dynamic = |body: &Entity| kinds.get(*body) == Ok(&RigidBody::Dynamic);
    *pointer = Pointer {
        ray,
        hit,
        body: body.filter(is_dynamic),
    };
}
