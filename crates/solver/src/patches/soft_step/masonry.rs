//! Stacks, walls and arches as problems, for tests.

use super::SoftStep;
use super::contact::pass::Pass;
use super::contact::smooth::Smooth;
use super::contact::spring::Spring;
use super::island::Island;
use super::sweeps::budget::SweepBudget;
use crate::batches::Batches;
use crate::lanes::F32xN;
use crate::{Body, GrabConstraint, Memory, PatchConstraint, PatchPoint, PatchProblem};
use glam::{Mat3, Quat, Vec3};
use std::f32::consts::PI;

pub const DT: f32 = 1.0 / 60.0;
pub const G: f32 = 9.81;

/// Blocks on a fixed base, which is body 0.
pub struct Masonry {
    pub bodies: Vec<Body>,
    pub centers: Vec<Vec3>,
    pub patches: Vec<PatchConstraint>,
    pub points: Vec<PatchPoint>,
    pub gravity: Vec3,
    pub grabs: Vec<GrabConstraint>,
}

impl Masonry {
    /// A slope of `tilt` rad that falls in the direction `towards`.
    pub fn new(tilt: f32, towards: Vec3) -> Self {
        Self {
            bodies: vec![Body::default()],
            centers: vec![Vec3::ZERO],
            patches: Vec::new(),
            points: Vec::new(),
            gravity: G * (tilt.sin() * towards - tilt.cos() * Vec3::Y),
            grabs: Vec::new(),
        }
    }

    /// Adds a block of 1000 kg/m³ with the inertia of a cuboid.
    pub fn block(&mut self, center: Vec3, size: Vec3, turn: f32) -> usize {
        let mass = 1e3 * size.element_product();
        let square = size * size;
        let inertia = mass / 12.0 * (Vec3::splat(square.element_sum()) - square);
        let rotation = Mat3::from_quat(Quat::from_rotation_z(turn));
        self.bodies.push(Body {
            linear: self.gravity * DT,
            inverse_mass: 1.0 / mass,
            inverse_inertia: rotation * Mat3::from_diagonal(inertia.recip()) * rotation.transpose(),
            ..Default::default()
        });
        self.centers.push(center);
        self.bodies.len() - 1
    }

    /// Adds a contact of two faces, in a rectangle with these two half sides.
    pub fn joint(&mut self, [a, b]: [usize; 2], center: Vec3, normal: Vec3, half: [Vec3; 2]) {
        self.patches.push(PatchConstraint {
            bodies: [a as u32, b as u32],
            normal,
            arms: [center - self.centers[a], center - self.centers[b]],
            friction: 0.9,
            first: self.points.len() as u32,
            count: 4,
            ..Default::default()
        });
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
            self.points.push(PatchPoint {
                offset: x * half[0] + y * half[1],
                ..Default::default()
            });
        }
    }

    /// A stack of cubes of 1 m.
    pub fn stack(n: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::X);
        for i in 0..n {
            let cube = masonry.block(Vec3::Y * (i as f32 + 0.5), Vec3::ONE, 0.0);
            masonry.bed([cube, cube - 1], Vec3::Y * i as f32, 0.5, 0.5);
        }
        masonry
    }

    pub fn bed(&mut self, bodies: [usize; 2], center: Vec3, half_length: f32, half_depth: f32) {
        let half = [half_length * Vec3::X, half_depth * Vec3::Z];
        self.joint(bodies, center, Vec3::Y, half);
    }

    /// Bricks of 1 × ½ × ½ m in a stretcher bond that steps in at both ends, tilted across.
    pub fn wall(width: usize, courses: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::Z);
        let mut below = Vec::new();
        for course in 0..courses {
            let y = 0.5 * course as f32;
            let bricks: Vec<usize> = (0..width - course)
                .map(|i| {
                    let x = i as f32 + 0.5 * course as f32;
                    masonry.block(Vec3::new(x, y + 0.25, 0.0), Vec3::new(1.0, 0.5, 0.5), 0.0)
                })
                .collect();
            for (i, &brick) in bricks.iter().enumerate() {
                let x = i as f32 + 0.5 * course as f32;
                if course == 0 {
                    masonry.bed([brick, 0], Vec3::new(x, y, 0.0), 0.5, 0.25);
                } else {
                    for (side, carrier) in [(-0.25, below[i]), (0.25, below[i + 1])] {
                        masonry.bed([brick, carrier], Vec3::new(x + side, y, 0.0), 0.25, 0.25);
                    }
                }
            }
            below = bricks;
        }
        masonry
    }

    /// A square of n × n cubes of 1 m, 2 m apart, on a plate 1 m thick.
    pub fn plate(n: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::X);
        let half = n as f32;
        let plate = masonry.block(0.5 * Vec3::Y, Vec3::new(2.0 * half, 1.0, 2.0 * half), 0.0);
        masonry.bed([plate, 0], Vec3::ZERO, half, half);
        for i in 0..n * n {
            let [x, z] = [i % n, i / n].map(|n| 2.0 * n as f32 + 1.0 - half);
            let cube = masonry.block(Vec3::new(x, 1.5, z), Vec3::ONE, 0.0);
            masonry.bed([cube, plate], Vec3::new(x, 1.0, z), 0.5, 0.5);
        }
        masonry
    }

    /// A half circle of a mean radius of 3 m, 0.6 m thick.
    pub fn arch(n: usize, tilt: f32) -> Self {
        let mut masonry = Self::new(tilt, Vec3::X);
        let angle = PI / n as f32;
        let mut last = 0;
        for i in 0..=n {
            let at = i as f32 * angle;
            let [out, along] = [Vec3::X, Vec3::Y].map(|v| Quat::from_rotation_z(at) * v);
            let next = if i == n {
                0
            } else {
                let middle = at + 0.5 * angle;
                let center = 3.0 * Vec3::new(middle.cos(), middle.sin(), 0.0);
                masonry.block(center, Vec3::new(0.6, 3.0 * angle, 1.0), middle)
            };
            masonry.joint([next, last], 3.0 * out, along, [0.3 * out, 0.5 * Vec3::Z]);
            last = next;
        }
        masonry
    }

    /// Shakes the bodies, so that friction slides, normals land and impulses grow.
    pub fn shaken(mut self) -> Self {
        let mut rng = fastrand::Rng::with_seed(7);
        let mut random = |most: f32| most * (2.0 * rng.f32() - 1.0);
        for body in self.bodies.iter_mut().skip(1) {
            body.start = [0.3, 0.5].map(|most| Vec3::from_array([0; 3].map(|_| random(most))));
            body.linear += body.start[0];
            body.angular += body.start[1];
        }
        for point in &mut self.points {
            point.separation = random(2e-3);
            point.normal_impulse = 5.0 + random(5.0);
        }
        self
    }

    /// Adds grabs that pull bodies sideways, strong enough to lift some of the load on them.
    pub fn held(mut self, bodies: impl IntoIterator<Item = usize>) -> Self {
        for body in bodies {
            let mass = 1.0 / self.bodies[body].inverse_mass;
            self.grabs.push(GrabConstraint {
                body: body as u32,
                arm: Vec3::new(0.2, 0.1, 0.0),
                error: Vec3::new(0.1, -0.2, 0.1),
                axes: [Vec3::ONE; 2],
                response: 0.1,
                max_speed: 4.0,
                max_force: 3.0 * mass * G,
                max_torque: 0.2 * mass * G,
                ..Default::default()
            });
        }
        self
    }

    /// The problem of one step.
    pub fn problem<'a>(&'a mut self, memory: &'a mut Memory) -> PatchProblem<'a> {
        PatchProblem {
            bodies: &mut self.bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            surfaces: &[],
            grabs: &mut self.grabs,
            joints: &mut [],
            dt: DT,
            max_recent_dt: DT,
            gravity: self.gravity,
            effort: 1.0,
            broke: false,
            max_correction_speed: 2.0,
            settling: None,
            stays_awake: false,
            record_history: false,
            threads: 1,
            memory,
        }
    }
}

/// An island in such blocks that is ready for the first sweep, and its sweeps.
pub fn started<L: F32xN>(problem: &PatchProblem, batches: Batches) -> (Island<L>, Vec<Pass>) {
    let (mut island, passes, spring) = placed(problem, batches);
    island.start(problem, SUBSTEPS, &spring, &passes);
    (island, passes)
}

/// Number of substeps of a step of such an island.
pub const SUBSTEPS: usize = 7;

/// An island in such blocks whose step has not begun, its sweeps, and its spring.
pub fn placed<L: F32xN>(
    problem: &PatchProblem,
    batches: Batches,
) -> (Island<L>, Vec<Pass>, Spring) {
    let mut island = Island::<L>::new(problem, batches);
    island.place_grabs(problem);
    let budget = SweepBudget {
        substeps: SUBSTEPS,
        substeps_per_rigid_sweep: 3,
        downwards: false,
        followed: 0.0,
        rate: 700.0,
    };
    let mut passes = Vec::new();
    SoftStep::default().plan(budget, DT, Smooth::of(problem), &mut passes);
    let spring = Spring {
        omega: 300.0,
        damping_ratio: 5.0,
        h: DT / SUBSTEPS as f32,
    };
    (island, passes, spring)
}
