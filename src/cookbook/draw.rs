// Draws the pictures of the cookbook. The test of a page includes this file, draws its world from the side, and compares the drawing with
// the file that the page shows. To write the files anew:
// `DRYSTONE_PICTURES=write cargo test --package drystone --doc --all-features cookbook`.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use std::collections::HashMap;

/// Maximum size of a frame, pixels.
const FRAME: (f32, f32) = (310.0, 170.0);

/// Height of the line above a frame, pixels.
const CAPTION: f32 = 24.0;

/// How far a corner may be from where it was drawn, pixels. Processors and features differ in the last bits, and what falls in more.
const TOLERANCE: f32 = 5.0;

/// Frames beside each other.
pub struct Picture {
    name: &'static str,
    /// The part of the world that is shown, m: from, to.
    view: [(f32, f32); 2],
    /// Turns the world so that it is seen along −z.
    turn: Quat,
    colors: HashMap<Entity, &'static str>,
    svg: String,
    frames: usize,
}

/// A collider to draw.
struct Part {
    body: Entity,
    pose: Pose,
    collider: Collider,
    color: &'static str,
    /// Whether it is drawn over the others.
    is_clear: bool,
}

impl Picture {
    /// A picture of this part of the world, m: left and bottom, right and top.
    pub fn new(name: &'static str, from: (f32, f32), to: (f32, f32)) -> Self {
        Self {
            name,
            view: [from, to],
            turn: Quat::IDENTITY,
            colors: HashMap::new(),
            svg: String::new(),
            frames: 0,
        }
    }

    /// The same seen along −x: what goes towards −z goes to the right.
    pub fn from_the_right(mut self) -> Self {
        self.turn = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        self
    }

    /// Draws a body in another colour from now on.
    pub fn color(&mut self, body: Entity, color: &'static str) {
        self.colors.insert(body, color);
    }

    /// Pixels of a metre.
    fn scale(&self) -> f32 {
        let [(left, bottom), (right, top)] = self.view;
        (FRAME.0 / (right - left)).min(FRAME.1 / (top - bottom))
    }

    /// Size of a frame with its caption, pixels.
    fn size(&self) -> (f32, f32) {
        let [(left, bottom), (right, top)] = self.view;
        let scale = self.scale();
        (scale * (right - left), CAPTION + scale * (top - bottom))
    }

    /// A point of the frame, pixels.
    fn point(&self, at: Vec3) -> (f32, f32) {
        let at = self.turn * at;
        let [(left, _), (_, top)] = self.view;
        (
            self.scale() * (at.x - left),
            CAPTION + self.scale() * (top - at.y),
        )
    }

    fn line(&mut self, line: String) {
        self.svg += &line;
        self.svg.push('\n');
    }

    /// Draws the world as it is now.
    pub fn frame(&mut self, world: &mut World, caption: &str) {
        let (width, height) = self.size();
        let offset = self.frames as f32 * (width + 8.0);
        let id = format!("drystone-{}-{}", self.name, self.frames);
        let panel = format!("<rect width=\"{width:.1}\" height=\"{height:.1}\"");
        self.line(format!("<g transform=\"translate({offset:.1} 0)\">"));
        self.line(format!(
            "<clipPath id=\"{id}\">{panel} rx=\"6\"></rect></clipPath>"
        ));
        self.line(format!(
            "<g clip-path=\"url(#{id})\" stroke=\"#333\" stroke-width=\"0.7\">"
        ));
        self.line(format!("{panel} fill=\"#e8eef4\" stroke=\"none\"></rect>"));
        let mut parts = parts(world);
        // Depths are rounded to centimetres, so that the last bits do not change the order of bodies beside each other.
        // Equal depths are in the order of entities: that of a query follows the archetypes, which change with the library.
        let depth = |pose: &Pose| (100.0 * (self.turn * pose.position).z).round() as i32;
        parts.sort_by_key(|part| (part.is_clear, depth(&part.pose), part.body));
        for part in parts {
            let color = self.colors.get(&part.body).copied();
            self.shape(&part.collider, &part.pose, color.unwrap_or(part.color));
        }
        let mut grids = world.query::<(&Voxels, &Pose, &RigidBody)>();
        for (grid, pose, kind) in grids.iter(world) {
            self.slice(grid, pose, color(*kind));
        }
        for (at, radius) in wheels(world) {
            self.circle(at, radius, "#6b6f76");
        }
        for rope in ropes(world) {
            let [(x1, y1), (x2, y2)] = rope.map(|end| self.point(end));
            self.line(format!(
                "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\"></path>"
            ));
        }
        let font = "font-size=\"13\" font-family=\"sans-serif\" fill=\"#333\" stroke=\"none\"";
        self.line(format!(
            "<text x=\"8\" y=\"17\" {font}>{caption}</text></g></g>"
        ));
        self.frames += 1;
    }

    fn circle(&mut self, at: Vec3, radius: f32, color: &str) {
        let ((x, y), radius) = (self.point(at), self.scale() * radius);
        let circle = format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"");
        self.line(format!("{circle} fill=\"{color}\"></circle>"));
    }

    /// The cells of a grid in the plane of its middle cell, by rows.
    fn slice(&mut self, grid: &Voxels, pose: &Pose, color: &str) {
        let mut cells: Vec<IVec3> = grid.cells().collect();
        cells.sort_by_key(|cell| (cell.z, cell.y, cell.x));
        let Some(middle) = cells.get(cells.len() / 2).map(|cell| cell.z) else {
            return;
        };
        let cells: Vec<IVec3> = cells.into_iter().filter(|cell| cell.z == middle).collect();
        let half = 0.5 * grid.size();
        for row in cells.chunk_by(|a, b| *b - *a == IVec3::X) {
            let [from, to] = [row[0], row[row.len() - 1]].map(|cell| grid.center_of(cell));
            let sides = [from.x - half, to.x + half].into_iter();
            let corners = sides.flat_map(|x| [-half, half].map(|y| from.with_x(x) + y * Vec3::Y));
            let corners = corners.map(|corner| self.point(pose.transform_point(corner)));
            self.outline(corners.collect(), color);
        }
    }

    fn shape(&mut self, collider: &Collider, pose: &Pose, color: &str) {
        let shape = collider.shape();
        let place = |point: Vec3| pose.position + pose.rotation * point;
        if let Some(ball) = shape.as_ball() {
            self.circle(pose.position, ball.radius, color);
            return;
        }
        let points: Vec<Vec3> = if let Some(cuboid) = shape.as_cuboid() {
            corners(cuboid.half_extents)
        } else if let Some(hull) = shape.as_convex_polyhedron() {
            hull.points().to_vec()
        } else if let Some(cylinder) = shape.as_cylinder() {
            rings(
                cylinder.radius,
                [-1.0, 1.0].map(|side| side * cylinder.half_height),
            )
        } else if let Some(capsule) = shape.as_capsule() {
            let half = capsule.half_height();
            let arcs = (0..=6).flat_map(|i| {
                let (y, r) = (0.26 * i as f32).sin_cos();
                rings(
                    capsule.radius * r,
                    [-1.0, 1.0].map(|side| side * (half + capsule.radius * y)),
                )
            });
            arcs.collect()
        } else {
            // The ground.
            let [(left, bottom), (right, _)] = self.view;
            let depth = pose.position.y - bottom.min(0.0) + 0.1;
            let middle = Vec3::new(0.5 * (left + right), -0.5 * depth, 0.0);
            let wide = right - left;
            corners(Vec3::new(wide, -middle.y, wide))
                .into_iter()
                .map(|corner| corner + self.turn.inverse() * middle)
                .collect()
        };
        let points = points.into_iter().map(|point| self.point(place(point)));
        self.outline(points.collect(), color);
    }

    fn outline(&mut self, points: Vec<(f32, f32)>, color: &str) {
        let outline = outline(points);
        let corners: Vec<String> = outline
            .iter()
            .map(|(x, y)| format!("{x:.1} {y:.1}"))
            .collect();
        self.line(format!(
            "<path d=\"M{}Z\" fill=\"{color}\"></path>",
            corners.join("L")
        ));
    }

    /// Compares the drawing with the file, or writes it.
    pub fn finish(self) {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/cookbook/pictures");
        let path = format!("{folder}/{}.svg", self.name);
        let (width, height) = self.size();
        let width = self.frames as f32 * (width + 8.0) - 8.0;
        let tag = format!("viewBox=\"0 0 {width:.1} {height:.1}\" width=\"{width:.0}\"");
        let space = "xmlns=\"http://www.w3.org/2000/svg\" style=\"max-width: 100%\"";
        // The empty line ends the text of the page.
        let svg = format!("\n<svg {space} {tag}>\n{}</svg>\n", self.svg);
        if std::env::var_os("DRYSTONE_PICTURES").is_some() {
            std::fs::write(&path, svg).unwrap();
            return;
        }
        let drawn = std::fs::read_to_string(&path).unwrap_or_default();
        // The order of lines does not count, because the last bits decide which of two bodies is nearer.
        let mut left: Vec<_> = drawn.lines().map(taken_apart).collect();
        let is_same = svg.lines().map(taken_apart).all(|line| {
            let distances = left.iter().map(|other| distance(&line, other));
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            nearest.is_some_and(|(nearest, distance)| {
                left.swap_remove(nearest);
                distance <= TOLERANCE
            })
        }) && left.is_empty();
        assert!(
            is_same,
            "{path} shows something else: write it anew with DRYSTONE_PICTURES=write"
        );
    }
}

fn color(kind: RigidBody) -> &'static str {
    match kind {
        RigidBody::Static => "#9aa3ad",
        RigidBody::Kinematic => "#7d9cc4",
        RigidBody::Dynamic => "#cf8f68",
    }
}

/// The colliders of all bodies but grids and air.
fn parts(world: &mut World) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut bodies = world.query_filtered::<(
        Entity,
        &RigidBody,
        &Pose,
        Option<&Collider>,
        Option<&Children>,
        (Option<&Fluid>, Has<Sensor>),
    ), (Without<Voxels>, Without<VoxelChunk>)>();
    let mut children = world.query_filtered::<(&Transform, &Collider), Without<RigidBody>>();
    for (body, &kind, &pose, collider, below, (fluid, is_sensor)) in bodies.iter(world) {
        if fluid.is_some_and(|fluid| fluid.density < 10.0) {
            continue;
        }
        let color = match is_sensor {
            _ if fluid.is_some() => "#4f8fd070",
            true => "#e8c84060",
            false => color(kind),
        };
        let mut add = |pose: Pose, collider: &Collider| {
            parts.push(Part {
                body,
                pose,
                collider: collider.clone(),
                color,
                is_clear: is_sensor,
            });
        };
        if let Some(collider) = collider {
            add(pose, collider);
        }
        for part in below.into_iter().flat_map(|below| below.iter()) {
            if let Ok((at, collider)) = children.get(world, part) {
                let position = pose.position + pose.rotation * at.translation;
                let rotation = pose.rotation * at.rotation;
                add(Pose { position, rotation }, collider);
            }
        }
    }
    parts
}

/// The places and radii of the wheels of vehicles.
fn wheels(world: &mut World) -> Vec<(Vec3, f32)> {
    use drystone::vehicle::WheelState;
    let mut wheels = world.query::<(&Wheel, &WheelState, &Transform, &ChildOf)>();
    let wheels = wheels.iter_manual(world).filter_map(|of| {
        let (wheel, state, mount, above) = of;
        let body = world.get::<Pose>(above.parent())?;
        let place = mount.transform_point(state.place(wheel).translation);
        Some((body.transform_point(place), wheel.radius))
    });
    wheels.collect()
}

/// The ends of ropes and rods.
fn ropes(world: &mut World) -> Vec<[Vec3; 2]> {
    let mut ropes = world.query_filtered::<&DistanceJoint, Without<JointDisabled>>();
    let end = |body: Option<Entity>, frame: &JointFrame| {
        let JointAnchor::Local(point) = frame.anchor else {
            return Vec3::ZERO;
        };
        let pose = body
            .and_then(|body| world.get::<Pose>(body).copied())
            .unwrap_or_default();
        pose.position + pose.rotation * point
    };
    let ends =
        |rope: &DistanceJoint| [end(rope.body1, &rope.frame1), end(rope.body2, &rope.frame2)];
    ropes.iter_manual(world).map(ends).collect()
}

fn corners(half: Vec3) -> Vec<Vec3> {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
    (0..8)
        .map(|i| half * Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2)))
        .collect()
}

/// Circles about the y axis.
fn rings(radius: f32, heights: [f32; 2]) -> Vec<Vec3> {
    let point = |y: f32, i: usize| {
        let (x, z) = (std::f32::consts::TAU * i as f32 / 24.0).sin_cos();
        Vec3::new(radius * x, y, radius * z)
    };
    heights
        .into_iter()
        .flat_map(|y| (0..24).map(move |i| point(y, i)))
        .collect()
}

/// The convex outline of points.
fn outline(mut points: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut hull = chain(points.iter().copied());
    hull.extend(chain(points.iter().rev().copied()));
    hull
}

/// Half of an outline, without its last point.
fn chain(points: impl Iterator<Item = (f32, f32)>) -> Vec<(f32, f32)> {
    let mut hull: Vec<(f32, f32)> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..]
            && (b.0 - a.0) * (point.1 - a.1) - (b.1 - a.1) * (point.0 - a.0) <= 0.3
        {
            hull.pop();
        }
        hull.push(point);
    }
    hull.pop();
    hull
}

/// How far the extents of two lines are from each other, pixels; without end if their texts differ. The number of corners may differ.
fn distance((text, extents): &(String, [f32; 4]), (other, others): &(String, [f32; 4])) -> f32 {
    if text != other {
        return f32::INFINITY;
    }
    let distances = extents.iter().zip(others).map(|(a, b)| (a - b).abs());
    distances.fold(0.0, f32::max)
}

/// The text of a line without its numbers, and the smallest and largest of its first, third and so on numbers, and of the others.
fn taken_apart(line: &str) -> (String, [f32; 4]) {
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let (mut text, mut extents, mut count) = (String::new(), [1e9, -1e9, 1e9, -1e9], 0);
    for word in line.split_inclusive(|c| !is_part(c)) {
        let number = word.trim_end_matches(|c| !is_part(c));
        match number.parse::<f32>() {
            Ok(value) => {
                let axis = 2 * (count % 2);
                extents[axis] = value.min(extents[axis]);
                extents[axis + 1] = value.max(extents[axis + 1]);
                count += 1;
            }
            Err(_) => text += word.trim_matches(['L', ' ']),
        }
    }
    (text, extents)
}
