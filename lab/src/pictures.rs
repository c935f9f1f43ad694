//! Pictures of a scene on the CPU: `euc` fills triangles against a depth buffer, the ground is cast ray by ray.

use crate::plots::Canvas;
use drystone::body::Pose;
use drystone::collider::Collider;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, BackfaceCullingEnabled, Triangles};
use euc::{Pipeline, Target};
use glam::camera::rh::proj::opengl::perspective;
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3};
use parry3d::shape::TypedShape;
use plotters_backend::{DrawingBackend, DrawingErrorKind};
use std::error::Error;
use std::fs;
use std::path::Path;

/// Size of a frame, pixels.
pub const SIZE: (u32, u32) = (400, 300);
/// Samples a pixel, along each axis.
const SAMPLES: usize = 4;

const SKY: Vec3 = Vec3::new(0.93, 0.95, 0.97);
const GROUND: Vec3 = Vec3::new(0.80, 0.81, 0.79);
const GRID: Vec3 = Vec3::new(0.70, 0.71, 0.69);
const SHADOW: Vec3 = Vec3::new(0.60, 0.61, 0.60);
const EDGE: Vec3 = Vec3::new(0.16, 0.12, 0.10);
const HAND: Vec3 = Vec3::new(0.85, 0.10, 0.10);
/// m
const HAND_LENGTH: f32 = 1.2;
/// A cylinder is drawn as a prism with so many sides.
const CYLINDER_SIDES: u32 = 32;
/// Towards the light.
const LIGHT: Vec3 = Vec3::new(0.35, 0.80, 0.50);

/// The camera of a picture of a scene.
#[derive(Clone, Copy)]
pub struct Camera {
    /// The point in the middle of the picture, m.
    pub target: Vec3,
    /// How much of the height of the scene the picture shows there, m.
    pub height: f32,
}

impl Camera {
    /// From the front, a little from the side and above.
    const FROM: Vec3 = Vec3::new(0.42, 0.36, 1.0);
    const FIELD: f32 = 0.5;

    fn eye(&self) -> Vec3 {
        let distance = 0.5 * self.height / (0.5 * Self::FIELD).tan();
        self.target + distance * Self::FROM.normalize()
    }

    fn matrix(&self) -> Mat4 {
        let aspect = SIZE.0 as f32 / SIZE.1 as f32;
        let near = 0.2 * self.height;
        perspective(Self::FIELD, aspect, near, 50.0 * self.height)
            * look_at_mat4(self.eye(), self.target, Vec3::Y)
    }
}

/// Writes a frame as a PNG, into a folder that is made where it is missing.
///
/// # Errors
/// If it cannot be written.
pub fn save(path: &Path, pixels: &[u8]) -> Result<(), Box<dyn Error>> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut canvas = Canvas::new(path, SIZE);
    let blit = |why: DrawingErrorKind<_>| format!("{}: {why}", path.display());
    canvas.blit_bitmap((0, 0), SIZE, pixels).map_err(blit)?;
    canvas.present().map_err(blit)?;
    Ok(())
}

/// A corner of a triangle: where it is, m; the face's colour; distances to the triangle's three sides, m, infinite in
/// effect for a side that is no edge of the body.
type Corner = (Vec3, Vec3, Vec3);
type Triple = (f32, f32, f32);

/// Flat faces with dark edges.
struct Faces {
    matrix: Mat4,
    edge_width: f32,
}

impl Pipeline for Faces {
    type Vertex = Corner;
    type VsOut = (Triple, Triple);
    type Pixel = Vec3;

    fn vert(&self, (position, color, sides): &Corner) -> ([f32; 4], Self::VsOut) {
        let clip = self.matrix * position.extend(1.0);
        (clip.to_array(), ((*color).into(), (*sides).into()))
    }

    fn frag(&self, (color, sides): &Self::VsOut) -> Vec3 {
        if Vec3::from(*sides).min_element() < self.edge_width {
            EDGE
        } else {
            Vec3::from(*color)
        }
    }
}

/// A frame of bodies that stand on the ground as 8-bit RGB, row by row; and the hand, where one holds a point, m.
pub fn frame<'a>(
    standing: impl IntoIterator<Item = (&'a Collider, &'a Pose)>,
    hand: Option<Vec3>,
    camera: &Camera,
) -> Vec<u8> {
    let size = [SIZE.0 as usize * SAMPLES, SIZE.1 as usize * SAMPLES];
    let mut color = Buffer2d::new(size, SKY);
    let mut depth = Buffer2d::new(size, 1.0);
    ground(camera, &mut color, &mut depth);

    let mut bodies = Vec::new();
    for (i, (collider, pose)) in standing.into_iter().enumerate() {
        faces(collider, pose, brick_color(i), &mut bodies);
    }
    if let Some(hand) = hand {
        // A rod that ends where it holds, so that it shows above a block held in its middle.
        let pose = Pose {
            position: hand + Vec3::Y * (0.5 * HAND_LENGTH),
            ..Pose::default()
        };
        let rod = Collider::cuboid(0.1, HAND_LENGTH, 0.1);
        faces(&rod, &pose, HAND, &mut bodies);
    }
    // The shadow is every face laid flat along the light, just above the ground.
    let flat = |p: Vec3| (p - LIGHT * (p.y.max(0.0) / LIGHT.y)).with_y(0.003);
    let shadow: Vec<Corner> = bodies
        .iter()
        .map(|&(p, _, _)| (flat(p), SHADOW, Vec3::splat(NO_EDGE)))
        .collect();
    let pipeline = Faces {
        matrix: camera.matrix(),
        edge_width: 0.0028 * camera.height,
    };
    pipeline.draw::<Triangles<_, BackfaceCullingDisabled>, _>(
        &shadow,
        &mut color,
        Some(&mut depth),
    );
    pipeline.draw::<Triangles<_, BackfaceCullingEnabled>, _>(&bodies, &mut color, Some(&mut depth));
    shrink(color.as_ref(), size[0])
}

/// Further from any side than a triangle is large, m.
const NO_EDGE: f32 = 1e3;

/// The triangles of a convex body in the world, lit.
fn faces(collider: &Collider, pose: &Pose, color: Vec3, corners: &mut Vec<Corner>) {
    let shape = collider.shape();
    let (points, triangles) = match shape.as_typed_shape() {
        TypedShape::Cuboid(cuboid) => cuboid.to_trimesh(),
        TypedShape::ConvexPolyhedron(hull) => hull.to_trimesh(),
        TypedShape::Cylinder(cylinder) => cylinder.to_trimesh(CYLINDER_SIDES),
        // No scene that is drawn has others.
        _ => return,
    };
    let points: Vec<Vec3> = points.iter().map(|&p| pose.transform_point(p)).collect();
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    for triangle in &triangles {
        let n = normal(triangle);
        // A side shared with a triangle of the same plane is the seam of a face, not an edge.
        let is_seam = |from: u32, to: u32| {
            triangles.iter().any(|t| {
                t != triangle && t.contains(&from) && t.contains(&to) && normal(t).dot(n) > 0.999
            })
        };
        let lit = color * (0.50 + 0.50 * n.dot(LIGHT.normalize()).max(0.0));
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        let twice_area = (b - a).cross(c - a).length();
        for k in 0..3 {
            // Side k lies opposite to corner k: this corner is its height away from that one and on the other two.
            let mut sides = [0.0; 3];
            for side in 0..3 {
                let (from, to) = (triangle[(side + 1) % 3], triangle[(side + 2) % 3]);
                let length = (points[to as usize] - points[from as usize]).length();
                sides[side] = match (is_seam(from, to), side == k) {
                    (true, _) => NO_EDGE,
                    (false, true) => twice_area / length,
                    (false, false) => 0.0,
                };
            }
            corners.push((points[triangle[k] as usize], lit, sides.into()));
        }
    }
}

/// Sandstone, each brick a little different.
fn brick_color(i: usize) -> Vec3 {
    // The golden ratio spreads neighbours.
    let t = (i as f32 * 0.618_034).fract();
    Vec3::new(0.98, 0.74, 0.52).lerp(Vec3::new(0.80, 0.52, 0.40), t)
}

/// The plane y = 0 with a grid of 1 m that fades into the sky.
fn ground(camera: &Camera, color: &mut Buffer2d<Vec3>, depth: &mut Buffer2d<f32>) {
    let [width, height] = color.size();
    let matrix = camera.matrix();
    let (eye, back) = (camera.eye(), matrix.inverse());
    let line = 0.004 * camera.height;
    for y in 0..height {
        for x in 0..width {
            let across = 2.0 * (x as f32 + 0.5) / width as f32 - 1.0;
            let up = 1.0 - 2.0 * (y as f32 + 0.5) / height as f32;
            let ray = back.project_point3(Vec3::new(across, up, 0.0)) - eye;
            if ray.y >= 0.0 {
                continue;
            }
            let point = eye - ray * (eye.y / ray.y);
            let near_line = |u: f32| (u - u.round()).abs() < line;
            let tint = match near_line(point.x) || near_line(point.z) {
                true => GRID,
                false => GROUND,
            };
            let far = (point - camera.target).length() / (4.0 * camera.height);
            let at = y * width + x;
            color.as_mut()[at] = tint.lerp(SKY, far.min(1.0));
            depth.as_mut()[at] = matrix.project_point3(point).z.min(1.0);
        }
    }
}

/// Averages the samples of every pixel.
fn shrink(samples: &[Vec3], width: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * (SIZE.0 * SIZE.1) as usize);
    for y in 0..SIZE.1 as usize {
        for x in 0..SIZE.0 as usize {
            let rows = (0..SAMPLES).map(|j| (y * SAMPLES + j) * width + x * SAMPLES);
            let sum: Vec3 = rows.flat_map(|at| &samples[at..at + SAMPLES]).sum();
            let mean = sum / (SAMPLES * SAMPLES) as f32;
            bytes.extend(mean.to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0) as u8));
        }
    }
    bytes
}
