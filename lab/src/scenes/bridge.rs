//! A bridge of planks that hangs between two piers, laid in the shape in which it rests.

use super::{Hand, Site};
use bevy_ecs::prelude::*;
use drystone::collider::Collider;
use drystone::joint::SphericalJoint;
use glam::{Quat, Vec3};

/// A plank, m, and its mass, kg.
const PLANK: Vec3 = Vec3::new(0.5, 0.1, 2.0);
const MASS: f32 = 30.0;

/// The load on the middle plank, m, and its mass, kg. It is shorter than a plank, so that it stands on one alone and statics is
/// determinate.
const LOAD: Vec3 = Vec3::new(0.4, 0.5, 1.8);
const LOAD_MASS: f32 = 10_000.0;

/// The span as a share of the length of the planks. A straight bridge would bear its load by stretching alone.
const SPAN: f32 = 0.975;

/// Steps of a bisection: as many as a double has digits.
const HALVINGS: usize = 60;

/// A polygon of hinged planks of equal length, with a load that stands on one of them.
struct Polygon {
    planks: usize,
    /// The plank under the load.
    loaded: usize,
}

impl Polygon {
    /// The slope of each plank, and where the last one ends, m, for a horizontal and a vertical force on the first hinge. Forces are in kg.
    ///
    /// A plank with the vertical force V on its left hinge has V − W on its right one, W being its weight with its load. Moments about its
    /// left hinge are in balance if tan θ (H L − P h) = −((V − W) L + m L/2 + P L/2), for a load P whose centre is h above the plank's.
    fn laid(&self, pull: f64, lift: f64) -> (Vec<f64>, [f64; 2]) {
        let (length, height) = (PLANK.x as f64, 0.5 * (PLANK.y + LOAD.y) as f64);
        let mut lift = lift;
        let [mut x, mut y] = [0.0; 2];
        let slopes = (0..self.planks).map(|plank| {
            let load = if plank == self.loaded {
                LOAD_MASS as f64
            } else {
                0.0
            };
            let weight = MASS as f64 + load;
            lift -= weight;
            let slope = -(lift + 0.5 * weight) * length / (pull * length - load * height);
            let along = length / (1.0 + slope * slope).sqrt();
            x += along;
            y += along * slope;
            slope
        });
        (slopes.collect(), [x, y])
    }

    /// The slopes at rest: the last plank ends at the height of the first, a span away.
    fn at_rest(&self) -> Vec<f64> {
        let weight = (MASS * self.planks as f32 + LOAD_MASS) as f64;
        let span = (SPAN * PLANK.x) as f64 * self.planks as f64;
        let level = |pull: f64| halve([0.0, weight], |lift| self.laid(pull, lift).1[1] > 0.0);
        // A pull below the first would let the load topple.
        let topples = (LOAD_MASS * 0.5 * (PLANK.y + LOAD.y) / PLANK.x) as f64;
        let pull = halve([1.01 * topples, 100.0 * weight], |pull| {
            self.laid(pull, level(pull)).1[0] < span
        });
        self.laid(pull, level(pull)).0
    }
}

/// Where a condition stops to hold.
fn halve([mut least, mut most]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        match holds(middle) {
            true => least = middle,
            false => most = middle,
        }
    }
    0.5 * (least + most)
}

impl Site<'_> {
    /// Along x, 5 m above the ground.
    pub(super) fn bridge(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let height = 5.0;
        let half = 0.5 * SPAN * PLANK.x * n as f32;
        for side in [-1.0, 1.0] {
            let size = Vec3::new(2.0, height, 4.0);
            let center = Vec3::new(side * (half + 1.05), 0.5 * height, 0.0);
            self.fixed("pier", size, center);
        }
        let loaded = n as usize / 2;
        let planks = n as usize;
        let slopes = Polygon { planks, loaded }.at_rest();
        let (mut hinge, mut last) = (Vec3::new(-half, height, 0.0), None);
        let mut load = None;
        for (i, slope) in slopes.into_iter().enumerate() {
            let turn = Quat::from_rotation_z(slope.atan() as f32);
            let center = hinge + turn * (0.5 * PLANK.x * Vec3::X);
            let shape = Collider::cuboid(PLANK.x - 0.02, PLANK.y, PLANK.z);
            let plank = self.weighing("plank", shape, MASS, center, turn);
            self.hinge(last, Some(plank), hinge);
            hinge += turn * (PLANK.x * Vec3::X);
            last = Some(plank);
            if i == loaded {
                load = Some((center + turn * (0.5 * (PLANK.y + LOAD.y) * Vec3::Y), turn));
            }
        }
        self.hinge(last, None, hinge);
        if let Some((center, turn)) = load {
            let shape = Collider::cuboid(LOAD.x, LOAD.y, LOAD.z);
            self.weighing("load", shape, LOAD_MASS, center, turn);
        }
        None
    }

    /// Two joints at the edges of the bridge.
    fn hinge(&mut self, last: Option<Entity>, next: Option<Entity>, at: Vec3) {
        for z in [-0.9, 0.9] {
            let joint = SphericalJoint::new(last, next).with_anchor(at + z * Vec3::Z);
            self.world.spawn(joint);
        }
    }
}
