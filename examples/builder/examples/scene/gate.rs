//! What is in the file: a gate of loose stones, barrels, a kettle with balls, a tree and a banner.

use crate::model::{Model, Node, ball, ground, lathe, prism, rectangle};
use bevy::math::{Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Radius of the opening and of the back of the arch, height of its springing and of a course, half the width of the gate, and depth, m.
const INNER: f32 = 1.45;
const OUTER: f32 = 2.0;
const SPRINGING: f32 = 1.5;
const COURSE: f32 = 0.5;
const HALF: f32 = 3.05;
const DEPTH: f32 = 0.8;

/// Number of stones in the arch.
const VOUSSOIRS: usize = 13;

const CHAMFER: f32 = 0.025;

/// On each object in Blender.
const DYNAMIC: &str = r#"{"drystone.body":"dynamic"}"#;

struct Gate {
    model: Model,
    stones: Vec<usize>,
    tints: Vec<usize>,
    count: usize,
}

/// The text of the glTF file, and the data beside it.
pub fn model(bin: &str) -> (String, Vec<u8>) {
    let mut model = Model::default();
    let tints = [
        [0.56, 0.50, 0.40],
        [0.48, 0.43, 0.36],
        [0.63, 0.57, 0.46],
        [0.42, 0.39, 0.34],
    ];
    let tints = tints.map(|tint| model.material("Stone", tint, 0.9, ""));
    let mut gate = Gate {
        model,
        stones: Vec::new(),
        tints: tints.to_vec(),
        count: 0,
    };
    gate.piers();
    gate.arch();
    gate.spandrels();
    gate.top();
    let Gate {
        mut model, stones, ..
    } = gate;
    model.root(Node {
        name: "Gate",
        children: stones,
        ..Default::default()
    });
    surroundings(&mut model);
    barrels(&mut model);
    kettle(&mut model);
    model.finish(bin)
}

impl Gate {
    /// A stone of an outline about `at`.
    fn stone(&mut self, mesh: &str, outline: &[Vec2], rule: &str, at: Vec3, turn: Quat) {
        // Neighbours differ, and the file is the same every time.
        let tint = [0, 2, 1, 0, 3, 2, 0, 1, 2, 3, 1][self.count % 11];
        let extras =
            format!(r#"{{"drystone":{{"collider":"{rule}","density":2400,"friction":0.7}}}}"#);
        let parts = [(prism(outline, DEPTH, CHAMFER), self.tints[tint])];
        let mesh = self.model.mesh(&format!("{mesh} {tint}"), &extras, &parts);
        self.count += 1;
        let stone = self.model.child(Node {
            name: &format!("Stone.{:03}", self.count),
            mesh: Some(mesh),
            at,
            turn,
            extras: DYNAMIC,
            ..Default::default()
        });
        self.stones.push(stone);
    }

    /// A course of boxes between two places, with these shares of its length, on one side of the gate or on both.
    fn course(
        &mut self,
        sides: &[f32],
        [from, to]: [f32; 2],
        [low, high]: [f32; 2],
        shares: &[f32],
    ) {
        let whole: f32 = shares.iter().sum();
        for &side in sides {
            let mut start = from;
            for share in shares {
                let length = (to - from) * share / whole;
                let at = Vec3::new(side * (start + 0.5 * length), 0.5 * (low + high), 0.0);
                let name = format!("Block {:.0} x {:.0}", 1e3 * length, 1e3 * (high - low));
                let outline = rectangle(length, high - low);
                self.stone(&name, &outline, "cuboid", at, Quat::IDENTITY);
                start += length;
            }
        }
    }

    fn piers(&mut self) {
        for (k, shares) in [&[1.0, 1.0][..], &[0.5, 1.0, 0.5], &[1.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            let low = COURSE * k as f32;
            self.course(&[-1.0, 1.0], [INNER, HALF], [low, low + COURSE], shares);
        }
    }

    fn arch(&mut self) {
        let half = 0.5 * PI / VOUSSOIRS as f32;
        // The back is tangential to the radius, so that what lies on it lies on a face.
        let (inner, outer) = (INNER, OUTER / half.cos());
        let corner = |radius: f32, angle: f32| radius * Vec2::new(angle.sin(), angle.cos());
        let outline = [
            corner(inner, half),
            corner(outer, half),
            corner(outer, -half),
            corner(inner, -half),
        ];
        let middle = Vec2::new(0.0, 0.5 * (INNER + OUTER));
        let outline = outline.map(|corner| corner - middle);
        for i in 0..VOUSSOIRS {
            let turn = Quat::from_rotation_z(FRAC_PI_2 - half * (2 * i + 1) as f32);
            let at = Vec3::Y * SPRINGING + turn * middle.extend(0.0);
            self.stone("Voussoir", &outline, "hull", at, turn);
        }
    }

    /// Courses beside the arch, lower and lower, so that little is open between them and it. Each begins at its back.
    fn spandrels(&mut self) {
        let outer = OUTER / (0.5 * PI / VOUSSOIRS as f32).cos();
        let courses: [(f32, &[f32]); 6] = [
            (0.5, &[1.0]),
            (0.4, &[1.0, 1.0]),
            (0.35, &[1.4, 1.0]),
            (0.3, &[1.0, 1.0]),
            (0.25, &[1.2, 1.0]),
            (0.2, &[1.4, 1.0, 1.0]),
        ];
        let mut low = 0.0;
        for (height, shares) in courses {
            let from = (outer * outer - low * low).sqrt() + 1e-3;
            let ends = [SPRINGING + low, SPRINGING + low + height];
            self.course(&[-1.0, 1.0], [from, HALF], ends, shares);
            low += height;
        }
    }

    fn top(&mut self) {
        // The two in the middle rest on the keystone and on the courses beside the arch.
        let low = SPRINGING + OUTER;
        let shares = [1.2, 0.9, 0.95];
        self.course(&[-1.0, 1.0], [0.0, HALF], [low, low + 0.3], &shares);
        for i in 0..6 {
            let middle = HALF * (-0.9 + 0.36 * i as f32);
            let ends = [middle - 0.3, middle + 0.3];
            self.course(&[1.0], ends, [low + 0.3, low + 0.75], &[1.0]);
        }
    }
}

/// What stands still: it has no body, so its colliders are static.
fn surroundings(model: &mut Model) {
    let grass = model.material(
        "Grass",
        [0.17, 0.26, 0.09],
        0.95,
        r#"{"drystone.friction":0.8}"#,
    );
    let height = |x: f32, z: f32| {
        let away = ((x * x + z * z).sqrt() - 9.0).max(0.0);
        0.1 * away * (1.0 + 0.6 * (0.3 * x).sin() * (0.25 * z).cos())
    };
    let mesh = model.mesh("Ground", "", &[(ground(48.0, 32, height), grass)]);
    model.root(Node {
        name: "Ground",
        mesh: Some(mesh),
        ..Default::default()
    });
    let bark = model.material("Bark", [0.16, 0.10, 0.06], 0.95, "");
    // No collider: the extras of a material hold for its part of a mesh.
    let leaves = model.material("Leaves", [0.10, 0.20, 0.05], 0.9, r#"{"drystone":"none"}"#);
    let trunk = [(0.0, 0.0), (0.26, 0.0), (0.19, 2.6), (0.0, 2.6)].map(Vec2::from);
    let mut crown = Vec::new();
    for (at, radius) in [
        (Vec3::new(0.0, 3.6, 0.0), 1.5),
        (Vec3::new(0.8, 3.1, 0.5), 1.0),
        (Vec3::new(-0.8, 3.2, 0.3), 1.1),
    ] {
        crown.extend(ball(radius).into_iter().map(|face| {
            let moved = |(corner, normal): (Vec3, Vec3)| (at + corner, normal);
            face.into_iter().map(moved).collect::<Vec<_>>()
        }));
    }
    let parts = [(lathe(&trunk, 12, true), bark), (crown, leaves)];
    let mesh = model.mesh("Tree", r#"{"drystone":"cylinder"}"#, &parts);
    model.root(Node {
        name: "Tree",
        mesh: Some(mesh),
        at: Vec3::new(-5.6, 0.0, -3.0),
        ..Default::default()
    });
    let cloth = model.material("Cloth", [0.45, 0.03, 0.03], 0.9, "");
    let outline = [
        (0.42, 0.9),
        (-0.42, 0.9),
        (-0.42, -0.5),
        (0.0, -0.9),
        (0.42, -0.5),
    ]
    .map(Vec2::from);
    let mesh = model.mesh("Banner", "", &[(prism(&outline, 0.02, 0.004), cloth)]);
    for x in [-2.3, 2.3] {
        model.root(Node {
            name: if x < 0.0 { "Banner.L" } else { "Banner.R" },
            mesh: Some(mesh),
            at: Vec3::new(x, 2.55, 0.5 * DEPTH + 0.03),
            ..Default::default()
        });
    }
}

fn barrels(model: &mut Model) {
    let wood = model.material("Wood", [0.32, 0.17, 0.07], 0.8, "");
    // The barrel is a cylinder; its hoops are only to be seen.
    let iron = model.material("Hoops", [0.08, 0.08, 0.09], 0.45, r#"{"drystone":"none"}"#);
    let bulge = |y: f32| 0.36 - 0.28 * y * y;
    let mut profile = vec![Vec2::new(0.0, -0.45)];
    profile.extend(
        (0..=8)
            .map(|i| -0.45 + 0.1125 * i as f32)
            .map(|y| Vec2::new(bulge(y), y)),
    );
    profile.push(Vec2::new(0.0, 0.45));
    let mut hoops = Vec::new();
    for y in [-0.36_f32, -0.16, 0.16, 0.36] {
        let out = |y: f32, by: f32| Vec2::new(bulge(y) + by, y);
        let band = [
            out(y - 0.03, -0.01),
            out(y - 0.03, 0.008),
            out(y + 0.03, 0.008),
            out(y + 0.03, -0.01),
        ];
        hoops.extend(lathe(&band, 24, true));
    }
    let parts = [(lathe(&profile, 24, true), wood), (hoops, iron)];
    let extras = r#"{"drystone":{"collider":"cylinder","density":450,"friction":0.5}}"#;
    let mesh = model.mesh("Barrel", extras, &parts);
    let lies = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(FRAC_PI_2);
    for (i, (at, turn)) in [
        (Vec3::new(3.1, 0.46, 2.0), Quat::IDENTITY),
        (Vec3::new(3.9, 0.46, 1.7), Quat::from_rotation_y(0.4)),
        (Vec3::new(3.5, 1.37, 1.85), Quat::from_rotation_y(0.9)),
        (Vec3::new(2.1, 0.37, 2.9), lies),
    ]
    .into_iter()
    .enumerate()
    {
        model.root(Node {
            name: &format!("Barrel.{:03}", i + 1),
            mesh: Some(mesh),
            at,
            turn,
            extras: DYNAMIC,
            ..Default::default()
        });
    }
}

fn kettle(model: &mut Model) {
    let copper = model.material("Copper", [0.60, 0.26, 0.13], 0.35, "");
    let shot = model.material("Shot", [0.10, 0.10, 0.11], 0.4, "");
    // Outside from below upwards, over the rim, and down again.
    let outside = [
        (0.0, 0.0),
        (0.34, 0.0),
        (0.50, 0.16),
        (0.54, 0.40),
        (0.50, 0.60),
    ];
    let inside = [
        (0.42, 0.60),
        (0.45, 0.40),
        (0.42, 0.19),
        (0.28, 0.08),
        (0.0, 0.08),
    ];
    let profile: Vec<Vec2> = outside.into_iter().chain(inside).map(Vec2::from).collect();
    let extras = r#"{"drystone":{"collider":"decomposition","density":3000,"friction":0.5}}"#;
    let mesh = model.mesh("Kettle", extras, &[(lathe(&profile, 24, true), copper)]);
    let at = Vec3::new(-2.6, 0.01, 2.3);
    model.root(Node {
        name: "Kettle",
        mesh: Some(mesh),
        at,
        extras: DYNAMIC,
        ..Default::default()
    });
    let extras = r#"{"drystone":{"collider":"ball","density":7800}}"#;
    let mesh = model.mesh("Shot", extras, &[(ball(0.13), shot)]);
    // Three layers.
    let layer = |y: f32, turn: f32, count: usize| {
        let angle = move |i: usize| turn + TAU * i as f32 / 3.0;
        let out = if count == 1 { 0.0 } else { 0.17 };
        let place = move |i| Vec3::new(out * angle(i).sin(), y, out * angle(i).cos());
        (0..count).map(place)
    };
    let layers = layer(0.3, 0.5, 3)
        .chain(layer(0.57, 1.6, 3))
        .chain(layer(0.84, 0.0, 1));
    for (i, place) in layers.enumerate() {
        model.root(Node {
            name: &format!("Shot.{:03}", i + 1),
            mesh: Some(mesh),
            at: at + place,
            extras: DYNAMIC,
            ..Default::default()
        });
    }
}
