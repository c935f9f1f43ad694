//! Writes a glTF file: meshes of flat faces, materials of one colour, and nodes with extras, as Blender would export them.

use bevy::math::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::fmt::Write as _;

/// A polygon with the normals of its corners.
type Polygon = Vec<(Vec3, Vec3)>;

/// The parts of a file.
#[derive(Default)]
pub struct Model {
    bin: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
    materials: Vec<String>,
    meshes: Vec<(String, String)>,
    nodes: Vec<String>,
    roots: Vec<usize>,
}

/// A node.
pub struct Node<'a> {
    pub name: &'a str,
    pub mesh: Option<usize>,
    pub at: Vec3,
    pub turn: Quat,
    /// JSON.
    pub extras: &'a str,
    pub children: Vec<usize>,
}

impl Default for Node<'_> {
    fn default() -> Self {
        Self {
            name: "",
            mesh: None,
            at: Vec3::ZERO,
            turn: Quat::IDENTITY,
            extras: "",
            children: Vec::new(),
        }
    }
}

fn list<T: ToString>(of: &[T]) -> String {
    let all: Vec<String> = of.iter().map(T::to_string).collect();
    format!("[{}]", all.join(","))
}

fn extras(text: &str) -> String {
    match text {
        "" => String::new(),
        text => format!(r#","extras":{text}"#),
    }
}

impl Model {
    /// A material of a linear colour.
    pub fn material(&mut self, name: &str, color: [f32; 3], rough: f32, of_extras: &str) -> usize {
        let [r, g, b] = color;
        let metal = if rough < 0.5 { 0.8 } else { 0.0 };
        self.materials.push(format!(
            r#"{{"name":"{name}","pbrMetallicRoughness":{{{}{}}}{}}}"#,
            format_args!(r#""baseColorFactor":[{r},{g},{b},1],"#),
            format_args!(r#""metallicFactor":{metal},"roughnessFactor":{rough}"#),
            extras(of_extras)
        ));
        self.materials.len() - 1
    }

    /// A mesh of parts, each of one material; the known one of this name if there is one.
    pub fn mesh(&mut self, name: &str, of_extras: &str, parts: &[(Vec<Polygon>, usize)]) -> usize {
        if let Some(known) = self.meshes.iter().position(|(of, _)| of == name) {
            return known;
        }
        let mut primitives = Vec::new();
        for (polygons, material) in parts {
            let (mut vertices, mut indices) = (Vec::<(Vec3, Vec3)>::new(), Vec::<u16>::new());
            for polygon in polygons {
                let corner = |vertex: &(Vec3, Vec3), vertices: &mut Vec<(Vec3, Vec3)>| {
                    let known = vertices.iter().position(|of| of == vertex);
                    known.unwrap_or_else(|| {
                        vertices.push(*vertex);
                        vertices.len() - 1
                    }) as u16
                };
                let corners: Vec<u16> =
                    polygon.iter().map(|of| corner(of, &mut vertices)).collect();
                for i in 1..corners.len() - 1 {
                    indices.extend([corners[0], corners[i], corners[i + 1]]);
                }
            }
            let bounds = vertices
                .iter()
                .fold((Vec3::MAX, Vec3::MIN), |(least, most), of| {
                    (least.min(of.0), most.max(of.0))
                });
            let floats = |of: fn(&(Vec3, Vec3)) -> Vec3| {
                let all = vertices.iter().flat_map(|vertex| of(vertex).to_array());
                all.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()
            };
            let ends = format!(
                r#","min":{},"max":{}"#,
                list(&bounds.0.to_array()),
                list(&bounds.1.to_array())
            );
            let position = self.accessor(&floats(|of| of.0), (5126, "VEC3", vertices.len()), &ends);
            let normal = self.accessor(&floats(|of| of.1), (5126, "VEC3", vertices.len()), "");
            let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            let index = self.accessor(&bytes, (5123, "SCALAR", indices.len()), "");
            primitives.push(format!(
                r#"{{"attributes":{{"POSITION":{position},"NORMAL":{normal}}},"indices":{index},"material":{material}}}"#
            ));
        }
        let text = format!(
            r#"{{"name":"{name}","primitives":{}{}}}"#,
            list(&primitives),
            extras(of_extras)
        );
        self.meshes.push((name.into(), text));
        self.meshes.len() - 1
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        (kind, of, count): (u32, &str, usize),
        more: &str,
    ) -> usize {
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0);
        }
        let (offset, length) = (self.bin.len(), bytes.len());
        self.bin.extend(bytes);
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#
        ));
        let view = self.views.len() - 1;
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{kind},"count":{count},"type":"{of}"{more}}}"#
        ));
        self.accessors.len() - 1
    }

    /// A node that is to be a child of another.
    pub fn child(&mut self, node: Node) -> usize {
        let mut text = format!(r#"{{"name":"{}""#, node.name);
        let mut add = |part: String| text.write_str(&part).expect("a string takes all");
        if let Some(mesh) = node.mesh {
            add(format!(r#","mesh":{mesh}"#));
        }
        if node.at != Vec3::ZERO {
            add(format!(r#","translation":{}"#, list(&node.at.to_array())));
        }
        if node.turn != Quat::IDENTITY {
            add(format!(r#","rotation":{}"#, list(&node.turn.to_array())));
        }
        if !node.children.is_empty() {
            add(format!(r#","children":{}"#, list(&node.children)));
        }
        add(extras(node.extras) + "}");
        self.nodes.push(text);
        self.nodes.len() - 1
    }

    /// A node of the scene.
    pub fn root(&mut self, node: Node) {
        let root = self.child(node);
        self.roots.push(root);
    }

    /// The text of the file, and the data beside it.
    pub fn finish(self, bin: &str) -> (String, Vec<u8>) {
        let block = |of: Vec<String>| format!("[\n{}\n]", of.join(",\n"));
        let meshes = self.meshes.into_iter().map(|(_, mesh)| mesh).collect();
        let asset = r#"{"version":"2.0","generator":"drystone, examples/builder/examples/scene"}"#;
        let scenes = format!(r#"[{{"nodes":{}}}]"#, list(&self.roots));
        let buffer = format!(r#"[{{"uri":"{bin}","byteLength":{}}}]"#, self.bin.len());
        let parts = [
            ("asset", asset.to_owned()),
            ("scene", "0".to_owned()),
            ("scenes", scenes),
            ("nodes", block(self.nodes)),
            ("materials", block(self.materials)),
            ("meshes", block(meshes)),
            ("accessors", block(self.accessors)),
            ("bufferViews", block(self.views)),
            ("buffers", buffer),
        ];
        let parts = parts.map(|(name, value)| format!(r#""{name}":{value}"#));
        let text = format!("{{{}}}\n", parts.join(",\n"));
        (text, self.bin)
    }
}

/// A flat face.
fn face(corners: &[Vec3]) -> Polygon {
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    corners.iter().map(|&corner| (corner, normal)).collect()
}

/// A convex outline, counterclockwise, with all its edges moved inwards.
fn inset(outline: &[Vec2], by: f32) -> Vec<Vec2> {
    let count = outline.len();
    let edge = |i: usize| {
        let (a, b) = (outline[i % count], outline[(i + 1) % count]);
        let along = (b - a).normalize();
        (a + by * along.perp(), along)
    };
    let corner = |i: usize| {
        let ((a, u), (b, v)) = (edge(i + count - 1), edge(i));
        a + u * ((b - a).perp_dot(v) / u.perp_dot(v))
    };
    (0..count).map(corner).collect()
}

/// A convex outline, counterclockwise, as thick as `depth` along z. The edges of its front and back are chamfered.
pub fn prism(outline: &[Vec2], depth: f32, chamfer: f32) -> Vec<Polygon> {
    let small = inset(outline, chamfer);
    let (near, far) = (0.5 * depth - chamfer, 0.5 * depth);
    let at = |points: &[Vec2], i: usize, z: f32| points[i % points.len()].extend(z);
    let count = outline.len();
    let ring = |points: &[Vec2], z: f32| (0..count).map(|i| at(points, i, z)).collect::<Vec<_>>();
    let mut back = ring(&small, -far);
    back.reverse();
    let mut faces = vec![face(&ring(&small, far)), face(&back)];
    for i in 0..count {
        let bands = [
            (outline, -near, outline, near),
            (outline, near, &small[..], far),
            (&small[..], -far, outline, -near),
        ];
        for (from, back, to, front) in bands {
            let corners = [
                at(from, i, back),
                at(from, i + 1, back),
                at(to, i + 1, front),
                at(to, i, front),
            ];
            faces.push(face(&corners));
        }
    }
    faces
}

/// A rectangle about the origin.
pub fn rectangle(width: f32, height: f32) -> Vec<Vec2> {
    let half = 0.5 * Vec2::new(width, height);
    let signs = [
        Vec2::NEG_ONE,
        Vec2::new(1.0, -1.0),
        Vec2::ONE,
        Vec2::new(-1.0, 1.0),
    ];
    signs.map(|sign| sign * half).to_vec()
}

/// An outline of radii and heights, from below upwards on the outside, turned about the y axis. `smooth` shades it as a curve around.
pub fn lathe(profile: &[Vec2], around: usize, smooth: bool) -> Vec<Polygon> {
    let point = |of: Vec2, i: usize| {
        let angle = TAU * (i % around) as f32 / around as f32;
        Vec3::new(of.x * angle.sin(), of.y, of.x * angle.cos())
    };
    let mut faces = Vec::new();
    for pair in profile.windows(2) {
        for i in 0..around {
            let corners = [
                point(pair[0], i),
                point(pair[0], i + 1),
                point(pair[1], i + 1),
                point(pair[1], i),
            ];
            let mut corners: Vec<Vec3> = corners.to_vec();
            corners.dedup_by(|a, b| a.distance(*b) < 1e-6);
            if corners.len() == 4 && corners[0].distance(corners[3]) < 1e-6 {
                corners.pop();
            }
            if corners.len() < 3 {
                continue;
            }
            let mut polygon = face(&corners);
            if smooth {
                let slope = pair[1] - pair[0];
                for (corner, normal) in &mut polygon {
                    let out = Vec3::new(corner.x, 0.0, corner.z).normalize_or_zero();
                    let curved = (out * slope.y - Vec3::Y * slope.x).normalize_or_zero();
                    *normal = if out == Vec3::ZERO { *normal } else { curved };
                }
            }
            faces.push(polygon);
        }
    }
    faces
}

/// A ball.
pub fn ball(radius: f32) -> Vec<Polygon> {
    let rings = 12;
    let angle = |i: usize| PI * (i as f32 / rings as f32 - 0.5);
    let profile = (0..=rings).map(|i| radius * Vec2::new(angle(i).cos().max(0.0), angle(i).sin()));
    let mut faces = lathe(&profile.collect::<Vec<_>>(), 24, false);
    for (corner, normal) in faces.iter_mut().flatten() {
        *normal = corner.normalize();
    }
    faces
}

/// A square of ground with this height at each place.
pub fn ground(size: f32, cells: usize, height: impl Fn(f32, f32) -> f32) -> Vec<Polygon> {
    let at = |i: usize, k: usize| {
        let [x, z] = [i, k].map(|n| size * (n as f32 / cells as f32 - 0.5));
        let slope = |dx: f32, dz: f32| (height(x + dx, z + dz) - height(x - dx, z - dz)) / 0.2;
        let normal = Vec3::new(-slope(0.1, 0.0), 1.0, -slope(0.0, 0.1)).normalize();
        (Vec3::new(x, height(x, z), z), normal)
    };
    let cells = 0..cells;
    let all = cells
        .clone()
        .flat_map(|i| cells.clone().map(move |k| (i, k)));
    all.map(|(i, k)| vec![at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)])
        .collect()
}
