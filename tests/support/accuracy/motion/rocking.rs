//! Rows 14 and 21: blocks that rock freely.

use super::at_step;
use crate::accuracy::shapes::hull_box;
use crate::accuracy::{Settings, Values};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use drystone::settings::Gravity;
use drystone_lab::housner::{Block, Lean};
use glam::{EulerRot, Quat, Vec3};

/// Height of the blocks, m.
pub(super) const HEIGHT: f32 = 1.0;

/// Where and how large a block rocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub name: &'static str,
    /// Turns gravity, the floor and the block.
    pub turn: Quat,
    /// The place of the floor, m.
    pub at: Vec3,
    /// The height of the block, m.
    pub height: f32,
}

impl Place {
    pub const HERE: Self = Self {
        name: "",
        turn: Quat::IDENTITY,
        at: Vec3::ZERO,
        height: HEIGHT,
    };
}

/// What a block does that rocks.
#[derive(Clone, Copy, Debug, Default)]
struct Rocked {
    /// Mean of ω⁺/ω⁻ over ten impacts, by energies of the swings between them.
    kept: f64,
    /// How far it leans after ten impacts, as a share of the first lean.
    tenth: f64,
    /// Until when it swings by more than a fiftieth of the first lean, s.
    swings: f64,
    /// The share of its energy that it has just before the first impact.
    before: f64,
}

impl Rocked {
    fn add(&mut self, other: Self) {
        self.kept += other.kept;
        self.tenth += other.tenth;
        self.swings += other.swings;
        self.before += other.before;
    }
}

/// The block of a slenderness and height, in double precision.
pub(super) fn block_of(slenderness: f32, height: f32) -> Block {
    Block::new((height * slenderness) as f64, height as f64, G as f64)
}

/// What Housner's block does that starts with this share of α.
fn truth(block: Block, share: f64) -> Rocked {
    let start = share * block.alpha;
    let energy = block.energy(start) * block.kept().powi(20);
    let lean = Lean {
        angle: start,
        speed: 0.0,
    };
    let (mut swings, mut last, mut most) = (0.0, 1.0, 0.0f64);
    block.rock(
        lean,
        60.0,
        |_| 0.0,
        |t, lean| {
            let side = lean.angle.signum();
            if side != last {
                if most < 0.02 * start && most > 0.0 {
                    return false;
                }
                (most, last) = (0.0, side);
            }
            most = most.max(lean.angle.abs());
            if lean.angle.abs() > 0.02 * start {
                swings = t;
            }
            true
        },
    );
    Rocked {
        kept: block.kept(),
        tenth: block.angle_of(energy) / start,
        swings,
        before: 1.0,
    }
}

/// A laboratory with a block that leans by `start`, rad, on its left lower edge, and the block.
fn leaning(
    settings: Settings,
    dt: f32,
    place: Place,
    (size, collider): (Vec3, Collider),
    start: f32,
) -> (Lab, Entity) {
    let mut lab = settings(dt);
    lab.world
        .insert_resource(Gravity(place.turn * (-G * Vec3::Y)));
    lab.spawn((
        (
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Friction::new(2.0),
        ),
        Transform::from_translation(place.at).with_rotation(place.turn),
    ));
    let turn = Quat::from_rotation_z(start);
    let edge = Vec3::new(-0.5 * size.x, -0.5 * size.y, 0.0);
    let at = -(turn * edge) + Vec3::X * edge.x;
    let block = lab.spawn((
        (RigidBody::Dynamic, collider, Friction::new(2.0)),
        Transform::from_translation(place.at + place.turn * at).with_rotation(place.turn * turn),
    ));
    (lab, block)
}

/// How far a body leans about z, rad.
pub(super) fn lean_of(lab: &Lab, body: Entity) -> f64 {
    lean(lab.pose(body).rotation)
}

/// The angle of a rotation about z, rad.
fn lean(turn: Quat) -> f64 {
    let turn = turn.as_dquat();
    2.0 * turn.z.atan2(turn.w)
}

/// Lets a block rock.
fn rock(settings: Settings, dt: f32, place: Place, slenderness: f32, share: f32) -> Rocked {
    let block = block_of(slenderness, place.height);
    let start = share as f64 * block.alpha;
    let size = place.height * Vec3::new(slenderness, 1.0, 1.0);
    let collider = Collider::cuboid(size.x, size.y, size.z);
    let (mut lab, body) = leaning(settings, dt, place, (size, collider), start as f32);
    let inertia = inertia(size);
    let up = place.turn * Vec3::Y;
    let total = |lab: &Lab| {
        let (pose, velocity) = (lab.pose(body), lab.velocity(body));
        let (v, w) = (velocity.linear.as_dvec3(), velocity.angular.as_dvec3());
        let height = up.dot(pose.position - place.at) as f64 - 0.5 * size.y as f64;
        G as f64 * height + 0.5 * v.length_squared() + 0.5 * inertia * w.length_squared()
    };
    let lean_of = |lab: &Lab| lean(place.turn.inverse() * lab.pose(body).rotation);
    let first = total(&lab);
    let (mut side, mut most) = (1.0, start);
    let mut swings = Vec::new();
    let (mut energy, mut before, mut late) = (1.0, 1.0, 0.0);
    for i in 0..(30.0 / dt).round() as usize {
        lab.step();
        let angle = lean_of(&lab);
        if angle.signum() != side && angle.abs() > 1e-4 * start {
            if swings.is_empty() {
                before = energy;
            }
            swings.push(most);
            (side, most) = (angle.signum(), 0.0);
        }
        energy = total(&lab) / first;
        most = most.max(angle.abs());
        if angle.abs() > 0.02 * start {
            late = (i + 1) as f64 * dt as f64;
        }
        if (i + 1) as f64 * dt as f64 > late + 1.0 {
            break;
        }
    }
    swings.push(most);
    swings.resize(swings.len().max(11), 0.0);
    let left = block.energy(swings[10]) / block.energy(start);
    Rocked {
        kept: left.powf(0.05),
        tenth: swings[10] / start,
        swings: late,
        before,
    }
}

/// The moment of inertia about the axis of rocking over the mass, m².
fn inertia(size: Vec3) -> f64 {
    let (width, height) = (size.x as f64, size.y as f64);
    (width * width + height * height) / 12.0
}

/// Row 14: how much of its angular velocity a block keeps when it rocks from one edge over to the other. It starts on one edge, leaning by
/// half of the angle at which it would fall, α. How far it leans after the impact tells its energy, which grows with cos(α − θ) − cos α.
pub fn rocks(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (share, name) in [(0.25f32, "1 : 4"), (0.125, "1 : 8")] {
        let size = Vec3::new(2.0 * share, 2.0, 1.0);
        let alpha = share.atan();
        for (shape, collider) in [
            ("box", Collider::cuboid(size.x, size.y, size.z)),
            ("hull", hull_box(size)),
        ] {
            let start = 0.5 * alpha;
            let (mut lab, block) = leaning(settings, dt, Place::HERE, (size, collider), start);
            let mut lowest = f32::INFINITY;
            for _ in 0..(2.0 / dt).round() as usize {
                lab.step();
                let (_, angle) = lab.pose(block).rotation.to_axis_angle();
                let side = lab.pose(block).rotation.z.signum();
                lowest = lowest.min(side * angle);
                if side < 0.0 && lab.velocity(block).angular.z > 0.0 {
                    break;
                }
            }
            let energy = |lean: f32| (alpha - lean).cos() - alpha.cos();
            let kept = (energy(-lowest).max(0.0) / energy(start)).sqrt();
            let expected = 1.0 - 1.5 * alpha.sin().powi(2);
            let what = format!("14: {shape} of {name} rocks, ω⁺/ω⁻");
            values.add(what, (kept, expected), 0.01);
        }
    }
    values
}

/// The number of starts of which the mean is taken, since an impact comes at any time within a step.
const STARTS: usize = 20;

/// What a block does that starts with about half of the angle at which it falls, and what it should do.
fn means(settings: Settings, dt: f32, place: Place, slenderness: f32) -> [Rocked; 2] {
    let mut sums = [Rocked::default(); 2];
    for i in 0..STARTS {
        let share = 0.5 - 0.004 * i as f32;
        sums[0].add(rock(settings, dt, place, slenderness, share));
        let block = block_of(slenderness, place.height);
        sums[1].add(truth(block, share as f64));
    }
    sums.map(|sum| Rocked {
        kept: sum.kept / STARTS as f64,
        tenth: sum.tenth / STARTS as f64,
        swings: sum.swings / STARTS as f64,
        before: sum.before / STARTS as f64,
    })
}

/// Row 21: how blocks rock from edge to edge.
pub fn rocks_on(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (slenderness, name) in [(0.25f32, "1 : 4"), (0.125, "1 : 8")] {
        let means = means(settings, dt, Place::HERE, slenderness);
        let mut add = |what: &str, of: fn(&Rocked) -> f64, most: [f32; 4]| {
            let [found, expected] = means.map(|mean| of(&mean) as f32);
            let what = format!("21: box of {name} rocks, {what}");
            values.add_near(what, (found, expected), at_step(dt, most));
        };
        add(KEPT, |all| all.kept, MOST_KEPT);
        add(TENTH, |all| all.tenth, MOST_TENTH);
        add("swings above 2 %, s", |all| all.swings, [0.2; 4]);
        add(
            "energy at the first impact",
            |all| all.before,
            [0.015, 0.003, 0.003, 0.003],
        );
    }
    values
}

/// Names and tolerances, as a share, at steps of 0.1 s, 1/60 s, 1/240 s and less.
const KEPT: &str = "ω⁺/ω⁻, mean of ten";
const MOST_KEPT: [f32; 4] = [0.02, 0.005, 0.003, 0.001];
const TENTH: &str = "tenth swing over the first";
const MOST_TENTH: [f32; 4] = [0.12, 0.12, 0.05, 0.05];

/// Row 25: how blocks of 1 : 4 rock that are turned, far from the origin, small and large.
pub fn rocks_elsewhere(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for place in [
        Place {
            name: "turned",
            turn: Quat::from_euler(EulerRot::YXZ, 0.7, 0.4, 1.1),
            ..Place::HERE
        },
        Place {
            name: "at 1 km",
            at: Vec3::new(1000.0, 0.0, 300.0),
            ..Place::HERE
        },
        Place {
            name: "of 5 cm",
            height: 0.05,
            ..Place::HERE
        },
        Place {
            name: "of 5 m",
            height: 5.0,
            ..Place::HERE
        },
    ] {
        let means = means(settings, dt, place, 0.25);
        let mut add = |what: &str, of: fn(&Rocked) -> f64, most: [f32; 4]| {
            let [found, expected] = means.map(|mean| of(&mean) as f32);
            let what = format!("25: box {} rocks, {what}", place.name);
            values.add_near(what, (found, expected), at_step(dt, most));
        };
        add(KEPT, |all| all.kept, MOST_KEPT);
        add(TENTH, |all| all.tenth, MOST_TENTH);
    }
    values
}
