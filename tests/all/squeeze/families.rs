//! Assemblies that could be held by squeezing themselves.

use crate::squeeze::assembly::{Assembly, block, cuboid, hull, joined};
use drystone::collider::Collider;
use drystone::masonry::{Arch, Block, Bond, Wall};
use glam::{Vec3, vec3};

pub const FRICTIONS: [f32; 3] = [0.3, 0.5, 0.84];

fn assembly(name: String, fixed: Vec<Block>, blocks: Vec<Block>, friction: f32) -> Assembly {
    Assembly {
        name: format!("{name}, friction {friction}"),
        fixed,
        blocks,
        friction,
        down: -Vec3::Y,
    }
}

/// A channel along x: a floor below y = 0, and sides at z = ±0.25.
fn channel() -> Vec<Block> {
    vec![
        cuboid(vec3(-2.0, -0.5, -0.75), vec3(2.0, 0.0, 0.75)),
        cuboid(vec3(-2.0, 0.0, -0.75), vec3(2.0, 0.3, -0.25)),
        cuboid(vec3(-2.0, 0.0, 0.25), vec3(2.0, 0.3, 0.75)),
    ]
}

/// Tongues in grooves, at shares of the angle at which a block on a plain slope slides.
pub fn tongues(shares: &[f32]) -> Vec<Assembly> {
    let tongue = cuboid(vec3(-0.4, 0.0, -0.25), vec3(0.4, 0.3, 0.25));
    let head = cuboid(vec3(-0.4, 0.3, -0.24), vec3(0.4, 0.6, 0.24));
    let front = cuboid(vec3(0.4, 0.0, -0.25), vec3(0.8, 0.6, 0.25));
    let rail = cuboid(vec3(-2.0, 0.0, -0.25), vec3(2.0, 0.3, 0.25));
    let saddle = joined(vec![
        cuboid(vec3(-0.5, 0.3, -0.5), vec3(0.5, 0.6, 0.5)),
        cuboid(vec3(-0.5, 0.05, -0.5), vec3(0.5, 0.3, -0.25)),
        cuboid(vec3(-0.5, 0.05, 0.25), vec3(0.5, 0.3, 0.5)),
    ]);
    let tall = cuboid(vec3(-0.3, 0.3, -0.2), vec3(0.3, 1.0, 0.2));
    let beside = cuboid(vec3(-0.4, 0.3, 0.25), vec3(0.4, 0.6, 0.5));
    let kinds = [
        (
            "a tongue that is tall in a groove",
            channel(),
            joined(vec![tongue.clone(), tall]),
        ),
        (
            "a tongue heavier on one side in a groove",
            channel(),
            joined(vec![tongue.clone(), beside]),
        ),
        ("a box in a groove", channel(), tongue.clone()),
        (
            "a tongue and its head in a groove",
            channel(),
            joined(vec![tongue.clone(), head]),
        ),
        (
            "a tongue of two parts in a groove",
            channel(),
            joined(vec![tongue, front]),
        ),
        ("a saddle on a rail", vec![rail], saddle),
    ];
    let mut all = Vec::new();
    for (name, fixed, body) in kinds {
        for friction in FRICTIONS {
            for share in shares {
                let angle = share * friction.atan();
                let one = assembly(name.into(), fixed.clone(), vec![body.clone()], friction);
                all.extend(ways(one, angle));
            }
        }
    }
    all
}

/// Tilted along x, and somewhat across; and with the assembly turned instead of gravity.
fn ways(assembly: Assembly, angle: f32) -> [Assembly; 3] {
    let askew = vec3(10.0, 0.0, 1.0).normalize();
    [
        assembly.clone().tilted(angle, Vec3::X),
        assembly.clone().tilted(angle, askew),
        assembly.tilted(angle, Vec3::X).turned(),
    ]
}

/// A trapezoid, given by half its width below and above, drawn out along x.
fn keystone(x: [f32; 2], y: [f32; 2], half: [f32; 2]) -> Block {
    let mut corners = Vec::new();
    for x in x {
        for (y, half) in y.into_iter().zip(half) {
            corners.extend([vec3(x, y, -half), vec3(x, y, half)]);
        }
    }
    hull(&corners)
}

/// The blocks beside it: up to z = ±1.
fn jambs(x: [f32; 2], y: [f32; 2], half: [f32; 2]) -> Vec<Block> {
    let jamb = |side: f32| {
        let mut corners = Vec::new();
        for x in x {
            for (y, half) in y.into_iter().zip(half) {
                corners.extend([vec3(x, y, side * half), vec3(x, y, side)]);
            }
        }
        hull(&corners)
    };
    [1.0, -1.0].map(jamb).into()
}

/// Wedges between two blocks, tilted along them; from vertical their sides lean by angles of 5° to 30°.
pub fn wedges(shares: &[f32]) -> Vec<Assembly> {
    let mut all = Vec::new();
    for degrees in [5.0f32, 10.0, 20.0, 30.0] {
        let lean = degrees.to_radians();
        let wider = 0.4 * lean.tan();
        let half = [0.2, 0.2 + wider];
        let wedge = keystone([-0.4, 0.4], [0.0, 0.4], half);
        for friction in FRICTIONS {
            // Sliding along both sides, on each of which it weighs by half over the sine.
            let slides = (friction / lean.sin()).atan();
            for share in shares {
                let name = format!("a wedge of {degrees}°");
                let fixed = jambs([-2.0, 2.0], [0.0, 0.4], half);
                let one = assembly(name, fixed, vec![wedge.clone()], friction);
                all.extend(ways(one, share * slides));
            }
        }
    }
    all
}

/// Tongues that are wider below, in grooves that fit.
pub fn dovetails(shares: &[f32]) -> Vec<Assembly> {
    let mut all = Vec::new();
    for degrees in [10.0f32, 30.0] {
        let half = [0.3, 0.3 - 0.3 * degrees.to_radians().tan()];
        let tail = keystone([-0.4, 0.4], [0.0, 0.3], half);
        let mut fixed = jambs([-2.0, 2.0], [0.0, 0.3], half);
        fixed.push(cuboid(vec3(-2.0, -0.5, -1.0), vec3(2.0, 0.0, 1.0)));
        for friction in FRICTIONS {
            for share in shares {
                let name = format!("a dovetail of {degrees}°");
                let one = assembly(name, fixed.clone(), vec![tail.clone()], friction);
                all.extend(ways(one, share * friction.atan()));
            }
        }
    }
    all
}

fn ground() -> Block {
    block(Collider::half_space(Vec3::Y), Vec3::ZERO)
}

/// Arches tilted along their span and across.
pub fn arches(degrees: &[f32]) -> Vec<Assembly> {
    let mut all = Vec::new();
    for (voussoirs, thickness) in [(9, 0.6), (15, 0.6), (15, 0.8)] {
        let arch = Arch {
            voussoirs,
            thickness,
            ..Default::default()
        };
        let blocks = arch.blocks().expect("an arch");
        for friction in [0.5, 0.84] {
            for (towards, way) in [(Vec3::X, "along"), (Vec3::Z, "across")] {
                for degrees in degrees {
                    let name = format!("an arch of {voussoirs}, {thickness} m thick, {way}");
                    let one = assembly(name, vec![ground()], blocks.clone(), friction);
                    all.push(one.tilted(degrees.to_radians(), towards));
                }
            }
        }
    }
    all
}

/// Walls between two piers, tilted out of their plane, at shares of the angle at which they tip when nothing holds their ends.
pub fn walls(shares: &[f32]) -> Vec<Assembly> {
    let mut all = Vec::new();
    for (length, courses) in [(1.0, 4), (3.0, 6), (5.0, 10)] {
        let wall = Wall {
            courses,
            length,
            ..Wall::new(Bond::Running)
        };
        let blocks = wall.blocks().expect("a wall");
        let (mut least, mut most) = (Vec3::MAX, Vec3::MIN);
        for Block { collider, pose } in &blocks {
            let ends = collider.shape().compute_local_aabb();
            least = least.min(pose.position + ends.mins);
            most = most.max(pose.position + ends.maxs);
        }
        let pier = |from: f32, to: f32| cuboid(vec3(from, 0.0, -1.0), vec3(to, most.y, 1.0));
        let fixed = vec![
            ground(),
            pier(least.x - 1.0, least.x),
            pier(most.x, most.x + 1.0),
        ];
        let tips = ((most.z - least.z) / (most.y - least.y)).atan();
        for friction in FRICTIONS {
            for share in shares {
                let name = format!("a wall {length} m long and {courses} courses high");
                let one = assembly(name, fixed.clone(), blocks.clone(), friction);
                all.push(one.tilted(share * tips.min(friction.atan()), Vec3::Z));
            }
        }
    }
    all
}

/// A box cut into cells by planes, some of them joined to compounds, some cut into two hulls, some fixed; tilted anyhow.
pub fn random(seed: u64) -> Assembly {
    let mut dice = fastrand::Rng::with_seed(seed);
    let friction = FRICTIONS[dice.usize(0..3)];
    let count = [dice.usize(2..4), dice.usize(2..4), dice.usize(1..4)];
    let mut cuts = |count: usize| {
        let mut at = 0.0;
        let mut all = vec![0.0];
        for _ in 0..count {
            at += 0.25 + 0.5 * dice.f32();
            all.push(at);
        }
        all
    };
    let cuts = count.map(&mut cuts);
    let mut cells: Vec<[usize; 3]> = Vec::new();
    for x in 0..count[0] {
        for y in 0..count[1] {
            for z in 0..count[2] {
                cells.push([x, y, z]);
            }
        }
    }
    let corners = |cell: [usize; 3]| {
        [0, 1].map(|end| {
            let at = |axis: usize| cuts[axis][cell[axis] + end];
            vec3(at(0), at(1), at(2))
        })
    };
    dice.shuffle(&mut cells);
    let (mut fixed, mut blocks) = (Vec::new(), Vec::new());
    while let Some(cell) = cells.pop() {
        let beside = |other: &[usize; 3]| {
            let apart = |axis: usize| other[axis].abs_diff(cell[axis]);
            apart(0) + apart(1) + apart(2) == 1
        };
        let [least, most] = corners(cell);
        let mut bodies = Vec::new();
        let lot = dice.f32();
        if lot < 0.5 {
            let mut parts = vec![cuboid(least, most)];
            for _ in 0..dice.usize(1..3) {
                if let Some(other) = cells.iter().position(beside) {
                    let [least, most] = corners(cells.swap_remove(other));
                    parts.push(cuboid(least, most));
                }
            }
            bodies.push(joined(parts));
        } else if lot < 0.75 {
            // A slanting cut from below to above, drawn out along z.
            let mut middle = || 0.2 + 0.6 * dice.f32();
            let [below, above] = [middle(), middle()].map(|at| least.x + at * (most.x - least.x));
            for end in [least.x, most.x] {
                let mut points = Vec::new();
                for z in [least.z, most.z] {
                    points.extend([vec3(end, least.y, z), vec3(below, least.y, z)]);
                    points.extend([vec3(end, most.y, z), vec3(above, most.y, z)]);
                }
                bodies.push(hull(&points));
            }
        } else {
            bodies.push(cuboid(least, most));
        }
        for body in bodies {
            match dice.f32() < 0.3 {
                true => fixed.push(body),
                false => blocks.push(body),
            }
        }
    }
    let far = cuts.map(|cuts| cuts[cuts.len() - 1]);
    fixed.push(cuboid(
        vec3(-1.0, -0.5, -1.0),
        vec3(far[0] + 1.0, 0.0, far[2] + 1.0),
    ));
    let angle = 50f32.to_radians() * dice.f32();
    let (sin, cos) = (std::f32::consts::TAU * dice.f32()).sin_cos();
    let name = format!("pieces of a box, seed {seed}");
    assembly(name, fixed, blocks, friction).tilted(angle, vec3(cos, 0.0, sin))
}
