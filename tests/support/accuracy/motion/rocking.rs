//! Blocks that rock freely.

use super::at_step;
use super::housner::{Block, Lean};
use crate::accuracy::{Settings, Values};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use glam::{DVec3, Quat, Vec3};

/// Height of the blocks, m.
pub(super) const HEIGHT: f32 = 1.0;

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

/// The block of a slenderness, in double precision.
pub(super) fn block_of(slenderness: f32) -> Block {
    Block::new((HEIGHT * slenderness) as f64, HEIGHT as f64, G as f64)
}

/// What Housner's block does that starts with this share of α.
fn truth(slenderness: f32, share: f64) -> Rocked {
    let block = block_of(slenderness);
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
fn leaning(settings: Settings, dt: f32, slenderness: f32, start: f32) -> (Lab, Entity) {
    let mut lab = settings(dt);
    lab.slope(0.0, 2.0);
    let size = Vec3::new(HEIGHT * slenderness, HEIGHT, 1.0);
    let turn = Quat::from_rotation_z(start);
    let edge = Vec3::new(-0.5 * size.x, -0.5 * size.y, 0.0);
    let at = -(turn * edge) + Vec3::X * edge.x;
    let block = lab.spawn((
        (
            RigidBody::Dynamic,
            Collider::cuboid(size.x, size.y, size.z),
            Friction::new(2.0),
        ),
        Transform::from_translation(at).with_rotation(turn),
    ));
    (lab, block)
}

/// How far a body leans about z, rad.
pub(super) fn lean_of(lab: &Lab, body: Entity) -> f64 {
    let turn = lab.pose(body).rotation.as_dquat();
    2.0 * turn.z.atan2(turn.w)
}

/// Lets a block rock.
fn rock(settings: Settings, dt: f32, slenderness: f32, share: f32) -> Rocked {
    let block = block_of(slenderness);
    let start = share as f64 * block.alpha;
    let (mut lab, body) = leaning(settings, dt, slenderness, start as f32);
    let inertia = inertia(slenderness);
    let total = |lab: &Lab| {
        let (pose, velocity) = (lab.pose(body), lab.velocity(body));
        let (v, w) = (velocity.linear.as_dvec3(), velocity.angular.as_dvec3());
        let height = pose.position.y as f64 - 0.5 * HEIGHT as f64;
        G as f64 * height + 0.5 * v.length_squared() + 0.5 * inertia * w.dot(DVec3::Z).powi(2)
    };
    let first = total(&lab);
    let (mut side, mut most) = (1.0, start);
    let mut swings = Vec::new();
    let (mut energy, mut before, mut late) = (1.0, 1.0, 0.0);
    for i in 0..(30.0 / dt).round() as usize {
        lab.step();
        let angle = lean_of(&lab, body);
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
fn inertia(slenderness: f32) -> f64 {
    let (width, height) = ((HEIGHT * slenderness) as f64, HEIGHT as f64);
    (width * width + height * height) / 12.0
}

/// How blocks rock from edge to edge that start with about half of the angle at which they fall: means of five starts, since an impact
/// comes at any time within a step.
pub fn rocks_on(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (slenderness, name) in [(0.25f32, "1 : 4"), (0.125, "1 : 8")] {
        let mut means = [Rocked::default(); 2];
        for i in 0..5 {
            let share = 0.5 - 0.01 * i as f32;
            means[0].add(rock(settings, dt, slenderness, share));
            means[1].add(truth(slenderness, share as f64));
        }
        let mut add = |what: &str, of: fn(&Rocked) -> f64, most: [f32; 4]| {
            let [found, expected] = means.map(|mean| (of(&mean) / 5.0) as f32);
            let what = format!("21: box of {name} rocks, {what}");
            values.add_near(what, (found, expected), at_step(dt, most));
        };
        add(
            "ω⁺/ω⁻, mean of ten",
            |all| all.kept,
            [0.02, 0.005, 0.003, 0.001],
        );
        add(
            "tenth swing over the first",
            |all| all.tenth,
            [0.12, 0.12, 0.05, 0.05],
        );
        add("swings above 2 %, s", |all| all.swings, [0.2; 4]);
        add(
            "energy at the first impact",
            |all| all.before,
            [0.015, 0.003, 0.003, 0.003],
        );
    }
    values
}
