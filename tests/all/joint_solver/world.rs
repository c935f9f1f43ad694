//! A small world of bodies, joints and a ground, for tests.

use drystone::solver::{
    Body, JointAxis, JointConstraint, Memory, PatchConstraint, PatchPoint, PatchProblem,
    PatchSolver, Slip, SoftStep,
};
use glam::{Mat3, Quat, Vec3};

pub const G: f32 = 9.81;

/// A body; one without mass does not move.
#[derive(Clone, Copy, Debug)]
pub struct Thing {
    pub mass: f32,
    /// Principal inertias in its own axes, kg·m².
    pub inertia: Vec3,
    pub position: Vec3,
    pub rotation: Quat,
    pub linear: Vec3,
    pub angular: Vec3,
}

impl Thing {
    pub fn fixed() -> Self {
        Self {
            mass: 0.0,
            inertia: Vec3::ZERO,
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            linear: Vec3::ZERO,
            angular: Vec3::ZERO,
        }
    }

    /// A cuboid with these sides, m.
    pub fn cuboid(mass: f32, size: Vec3, position: Vec3) -> Self {
        let square = size * size;
        Self {
            mass,
            inertia: mass / 12.0 * (Vec3::splat(square.element_sum()) - square),
            position,
            ..Self::fixed()
        }
    }

    pub fn at(&self, local: Vec3) -> Vec3 {
        self.position + self.rotation * local
    }

    fn inverse_inertia(&self) -> Mat3 {
        if self.mass == 0.0 {
            return Mat3::ZERO;
        }
        let turn = Mat3::from_quat(self.rotation);
        turn * Mat3::from_diagonal(self.inertia.recip()) * turn.transpose()
    }

    fn energy(&self) -> f64 {
        let local = (self.rotation.inverse() * self.angular).as_dvec3();
        let turns = (local * local * self.inertia.as_dvec3()).element_sum();
        let speed = self.linear.as_dvec3().length_squared();
        0.5 * (self.mass as f64 * speed + turns)
    }
}

/// A joint between anchors on two things.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub anchors: [Vec3; 2],
    pub frames: [Quat; 2],
    pub constraint: JointConstraint,
}

/// Four corners of a thing on another, or on the ground.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    pub bodies: [u32; 2],
    /// The centre of the patch on A, and half its sides.
    pub center: Vec3,
    pub half: Vec3,
    anchor: Option<Vec3>,
}

pub struct World {
    pub things: Vec<Thing>,
    pub links: Vec<Link>,
    pub feet: Vec<Foot>,
    patches: Vec<PatchConstraint>,
    points: Vec<PatchPoint>,
    memory: Memory,
    pub gravity: Vec3,
    pub solver: SoftStep,
    pub time: f32,
}

impl World {
    /// A world with a fixed body, number 0, at the origin.
    pub fn new() -> Self {
        Self {
            things: vec![Thing::fixed()],
            links: Vec::new(),
            feet: Vec::new(),
            patches: Vec::new(),
            points: Vec::new(),
            memory: Memory::default(),
            gravity: Vec3::NEG_Y * G,
            solver: SoftStep::default(),
            time: 0.0,
        }
    }

    pub fn add(&mut self, thing: Thing) -> u32 {
        self.things.push(thing);
        self.things.len() as u32 - 1
    }

    /// Joins two bodies at a point, with the frames aligned to these axes now.
    pub fn join(&mut self, bodies: [u32; 2], at: Vec3, axes: [JointAxis; 6]) -> usize {
        self.join_in(bodies, [at; 2], Quat::IDENTITY, axes)
    }

    pub fn join_in(
        &mut self,
        bodies: [u32; 2],
        at: [Vec3; 2],
        frame: Quat,
        axes: [JointAxis; 6],
    ) -> usize {
        let ends = bodies.map(|body| self.things[body as usize]);
        let local = |side: usize| ends[side].rotation.inverse() * (at[side] - ends[side].position);
        self.links.push(Link {
            anchors: [local(0), local(1)],
            frames: ends.map(|end| end.rotation.inverse() * frame),
            constraint: JointConstraint {
                bodies,
                axes,
                ..Default::default()
            },
        });
        self.links.len() - 1
    }

    /// A patch at the bottom of a thing.
    pub fn stand(&mut self, bodies: [u32; 2], center: Vec3, half: Vec3) {
        self.feet.push(Foot {
            bodies,
            center,
            half,
            anchor: None,
        });
        self.patches.push(PatchConstraint {
            bodies,
            normal: Vec3::Y,
            friction: 0.6,
            first: self.points.len() as u32,
            count: 4,
            ..Default::default()
        });
        self.points.extend([PatchPoint::default(); 4]);
    }

    /// The height of what a foot stands on.
    fn ground(&self, foot: &Foot) -> f32 {
        let other = &self.things[foot.bodies[1] as usize];
        match other.mass > 0.0 {
            true => other.position.y + 0.5 * other.size_y(),
            false => 0.0,
        }
    }

    /// A step of Δt: refreshes joints and contacts, solves, and moves the bodies.
    pub fn step(&mut self, dt: f32) {
        let mut bodies = self.bodies(dt);
        let mut joints = self.joints();
        self.refresh_contacts();
        self.memory.revise_patches(self.patches.len());
        self.solver.solve(&mut PatchProblem {
            bodies: &mut bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            grabs: &mut [],
            joints: &mut joints,
            surfaces: &[],
            dt,
            max_recent_dt: dt,
            gravity: self.gravity,
            effort: 1.0,
            broke: false,
            max_correction_speed: 2.0,
            settling: None,
            stays_awake: false,
            record_history: false,
            threads: 1,
            memory: &mut self.memory,
        });
        self.take_over(&bodies, &joints, dt);
        self.time += dt;
    }

    fn bodies(&self, dt: f32) -> Vec<Body> {
        self.things
            .iter()
            .map(|thing| {
                let moves = thing.mass > 0.0;
                let gained = if moves { dt * self.gravity } else { Vec3::ZERO };
                Body {
                    linear: thing.linear + gained,
                    angular: thing.angular,
                    inverse_mass: if moves { 1.0 / thing.mass } else { 0.0 },
                    inverse_inertia: thing.inverse_inertia(),
                    start: [thing.linear, thing.angular],
                    ..Default::default()
                }
            })
            .collect()
    }

    fn joints(&self) -> Vec<JointConstraint> {
        self.links
            .iter()
            .map(|link| {
                let ends = link
                    .constraint
                    .bodies
                    .map(|body| &self.things[body as usize]);
                let [a, b] = [0, 1].map(|side| ends[side].at(link.anchors[side]));
                JointConstraint {
                    arms: [0, 1].map(|side| ends[side].rotation * link.anchors[side]),
                    gap: b - a,
                    frames: [0, 1].map(|side| ends[side].rotation * link.frames[side]),
                    ..link.constraint
                }
            })
            .collect()
    }

    fn refresh_contacts(&mut self) {
        for (number, foot) in self.feet.clone().iter().enumerate() {
            let ends = foot.bodies.map(|body| self.things[body as usize]);
            let ground = self.ground(foot);
            let center = ends[0].at(foot.center);
            let touches = center.with_y(ground);
            let patch = &mut self.patches[number];
            patch.arms = [center - ends[0].position, touches - ends[1].position];
            let anchor = *self.feet[number].anchor.get_or_insert(touches);
            let rides = ends[1].position.with_y(0.0);
            let anchor_now = anchor
                + if ends[1].mass > 0.0 {
                    rides
                } else {
                    Vec3::ZERO
                };
            if foot.anchor.is_none() && ends[1].mass > 0.0 {
                self.feet[number].anchor = Some(touches - rides);
            }
            patch.slip = Some(Slip {
                shift: (touches - anchor_now).with_y(0.0),
                twist: 0.0,
            });
            for (i, (x, z)) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
                .into_iter()
                .enumerate()
            {
                let offset = ends[0].rotation * (foot.half * Vec3::new(x, 0.0, z));
                let point = &mut self.points[4 * number + i];
                point.offset = offset;
                point.separation = (center + offset).y - ground;
            }
        }
    }

    /// Takes over what was solved, and moves the bodies.
    fn take_over(&mut self, bodies: &[Body], joints: &[JointConstraint], dt: f32) {
        for (link, joint) in self.links.iter_mut().zip(joints) {
            link.constraint = *joint;
        }
        for (foot, patch) in self.feet.iter_mut().zip(&self.patches) {
            if let Some(anchor) = &mut foot.anchor {
                *anchor += patch.dragged.shift;
            }
        }
        for (thing, body) in self.things.iter_mut().zip(bodies) {
            if thing.mass == 0.0 {
                thing.position += dt * thing.linear;
                thing.rotation = Quat::from_scaled_axis(dt * thing.angular) * thing.rotation;
                continue;
            }
            let [linear, angular] = body.motion.unwrap_or([body.linear, body.angular]);
            thing.position += dt * linear;
            thing.rotation = (Quat::from_scaled_axis(dt * angular) * thing.rotation).normalize();
            (thing.linear, thing.angular) = (body.linear, body.angular);
        }
    }

    /// Drops what the solver keeps.
    pub fn forget(&mut self) {
        self.memory.discard();
    }

    /// Steps for some seconds.
    pub fn run(&mut self, seconds: f32, dt: f32) {
        self.run_with(seconds, dt, |_| ());
    }

    pub fn run_with(&mut self, seconds: f32, dt: f32, mut after: impl FnMut(&Self)) {
        for _ in 0..(seconds / dt).round() as usize {
            self.step(dt);
            after(self);
        }
    }

    /// The distance of a joint's anchors, m.
    pub fn gap(&self, link: usize) -> f32 {
        let link = &self.links[link];
        let ends = link
            .constraint
            .bodies
            .map(|body| &self.things[body as usize]);
        (ends[1].at(link.anchors[1]) - ends[0].at(link.anchors[0])).length()
    }

    /// The largest distance of any joint's anchors, m.
    pub fn widest(&self) -> f32 {
        (0..self.links.len())
            .map(|link| self.gap(link))
            .fold(0.0, f32::max)
    }

    /// Kinetic and potential energy, J. Velocities are those of the end of the step.
    pub fn energy(&self) -> f64 {
        let moved = self.things.iter().filter(|thing| thing.mass > 0.0);
        moved
            .map(|thing| {
                let height = -self.gravity.dot(thing.position);
                thing.energy() + (thing.mass * height) as f64
            })
            .sum()
    }

    /// The largest speed of any body, m/s and rad/s.
    pub fn fastest(&self) -> [f32; 2] {
        let speeds = self.things.iter();
        speeds.fold([0.0, 0.0], |[linear, angular], thing| {
            [
                linear.max(thing.linear.length()),
                angular.max(thing.angular.length()),
            ]
        })
    }
}

impl Thing {
    /// The height of a cuboid.
    fn size_y(&self) -> f32 {
        // x² + z² … : I_x + I_z − I_y = m/12 · 2 y².
        (6.0 * (self.inertia.x + self.inertia.z - self.inertia.y) / self.mass).sqrt()
    }
}
