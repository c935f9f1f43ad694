//! The cone program of a structure: the largest load λ for which contact forces f balance it,
//!
//! max λ  so that  Σ Gᵀf + w + λ l = 0 for each body,  f_n ≥ 0 at each corner of a face,  ‖(f_t, f_τ/r)‖ ≤ c + μ' Σ f_n for each face.
//!
//! Forces are in units of the mean weight of a body and lengths in units of the mean radius, so that the numbers are near 1. The dual
//! variables of the balance are the velocities of the mechanism by which the structure fails: a motion in which the load does the work that
//! weight and friction consume.
//!
//! With c = 0 and μ' = μ this is the theorem of plasticity, in which a sliding joint also opens, by μ times the sliding distance. A brick
//! between others could then be pulled out only by lifting the wall, and would be held far too strongly. Therefore the width of a cone is
//! set by the normal force N on the face: c = μ (1 − ε) N and μ' = ε μ (Gilbert, Casapulla, Ahmed 2006). They take N from the previous
//! round. Many distributions N balance a load, and their rounds find the most favourable one, in which the wall hangs on the brick that is
//! pulled. Here N is the current normal force plus the part that the load adds if all joints are equally soft (least squares). The second
//! part is a multiple of λ, so the width in the program is c = c₀ + λ d. The only unknown of a round is which joints the load relieves
//! completely. The first round assumes none, and usually is sufficient.

use super::cone_program::{Face, Program, Six};
use super::interior::{self, Outcome};
use super::scaled::Scaled;
use super::structure::{Joint, Structure};
use super::{FailingJoint, JointFailure, Margin, MovingBody, StabilityError};
use crate::solver::Both;
use glam::{DVec3, Vec3};

/// Bodies slower than this share of the fastest count as not moving.
const MOVING_SHARE: f64 = 0.01;

/// A load of this many times the total weight counts as infinite.
const INFINITE_LOAD: f64 = 1e4;

/// ε: the share of the slope of a cone of friction that is kept.
const SLOPE_SHARE: f64 = 0.01;

/// Maximum number of rounds.
const MAX_ROUNDS: usize = 8;

/// Rounds end if the load changes by no more than this share.
const SETTLED_CHANGE: f64 = 2e-3;

/// Tolerance of the cones, as a share of the mean weight of a body.
const CONE_TOLERANCE: f64 = 1e-4;

/// The load that is increased.
pub(super) enum Load {
    /// An acceleration of all bodies, m/s².
    Everywhere(Vec3),
    /// A force of 1 N on one of them.
    At {
        body: usize,
        point: Vec3,
        direction: Vec3,
    },
}

/// The forces at a joint in a solution, and the sensitivity of the load to the width of its cone.
struct JointForces {
    /// Normal force, N.
    normal_force: f64,
    /// Friction: the norm of the friction force and its moment, as in the cone, N.
    friction: f64,
    /// Width c of the cone without a normal force, N.
    width: f64,
    /// Increase of the largest load, as a multiple, for each N of additional width.
    sensitivity: f64,
}

/// The solution of a round.
struct RoundSolution {
    /// The largest load, as a multiple.
    load: f64,
    /// By joint.
    joints: Vec<JointForces>,
    /// Linear and angular velocity of the mechanism, by body.
    velocities: Vec<[DVec3; 2]>,
}

/// The normal force that limits the friction of a joint.
#[derive(Clone, Copy)]
struct NormalForce {
    /// Normal force without the load, N.
    initial: f64,
    /// Increase for each unit of the load, N.
    gain: f64,
}

impl Structure {
    /// Computes the largest load, as a multiple, and the mechanism by which the structure fails.
    pub fn solve(&self, load: &Load) -> Result<Margin, StabilityError> {
        let live = self.live(load);
        let mut program = self.program(&live);
        let mut scaled = Scaled::new(&program);
        let gains = self.gains(&live, &program, &mut scaled);
        let mut round = |forces: Option<&[NormalForce]>| {
            self.set_cones(&mut program, &live, forces);
            self.round(&program, &mut scaled, &live, forces)
        };
        let constant = |initial: f64| NormalForce { initial, gain: 0.0 };
        let initial = self.joints.iter().map(|joint| joint.normal_force);
        let mut initial: Vec<f64> = initial.collect();
        let first: Vec<NormalForce> = initial.iter().copied().map(constant).collect();
        let mut found = match round(Some(&first)) {
            // The current normal forces may be those of an impact, or of a structure that does not stand.
            Err(StabilityError::Falls) => {
                let found = round(None)?;
                let joints = found.joints.iter();
                initial = joints.map(|joint| joint.normal_force).collect();
                found
            }
            found => found?,
        };
        let mut before = Vec::new();
        for _ in 0..MAX_ROUNDS {
            if found.load.is_infinite() {
                return Ok(Margin {
                    limit: f32::INFINITY,
                    moving: Vec::new(),
                    failing: Vec::new(),
                });
            }
            let joints = initial.iter().zip(&gains);
            let under_load: Vec<f64> = joints
                .clone()
                .map(|(initial, gain)| (initial + found.load * gain).max(0.0))
                .collect();
            if self.is_consistent(&found, &under_load) {
                break;
            }
            let relieved: Vec<bool> = under_load
                .iter()
                .map(|&normal_force| normal_force <= CONE_TOLERANCE * self.units[0])
                .collect();
            if relieved == before {
                break;
            }
            let forces = joints.zip(&relieved);
            let forces = forces.map(|((&initial, &gain), relieved)| match relieved {
                true => constant(0.0),
                false => NormalForce { initial, gain },
            });
            let forces: Vec<NormalForce> = forces.collect();
            before = relieved;
            let load = found.load;
            found = match round(Some(&forces)) {
                Err(StabilityError::Falls) => break,
                found => found?,
            };
            if (found.load - load).abs() <= SETTLED_CHANGE * load.abs() {
                break;
            }
        }
        // A negative load means that the structure only stands if the load is reversed.
        match found.load >= -1e-6 {
            true => Ok(self.mechanism(&found)),
            false => Err(StabilityError::Falls),
        }
    }

    /// The normal force that a unit of the load adds at each joint if all joints are equally soft: the least-squares forces that balance
    /// it. Returns zeros if no forces balance it.
    fn gains(&self, live: &[[DVec3; 2]], program: &Program, scaled: &mut Scaled) -> Vec<f64> {
        let [force_unit, _] = self.units;
        let share = -force_unit / self.load_unit(live);
        let Some(forces) = scaled.least_squares(program, &program.load) else {
            return vec![0.0; self.joints.len()];
        };
        let mut forces = forces.iter();
        let gain = |face: &Face| {
            let normal_force: f64 = forces.by_ref().take(face.corners).sum();
            let friction = face.rows.len() - face.corners;
            forces.by_ref().take(friction).for_each(drop);
            normal_force * share
        };
        program.faces.iter().map(gain).collect()
    }

    /// Width c of the cone of a joint with this normal force, N.
    fn width(joint: &Joint, normal_force: f64) -> f64 {
        joint.friction * (1.0 - SLOPE_SHARE) * normal_force
    }

    /// Returns true if a solution also solves the next round, whose cones have the width that these normal forces give. This is so if its
    /// forces are within those cones, and if the bound on the load that follows from its dual variables does not change.
    fn is_consistent(&self, found: &RoundSolution, normal_forces: &[f64]) -> bool {
        let mut more = 0.0;
        let joints = self.joints.iter().zip(normal_forces).zip(&found.joints);
        for ((joint, &normal_force), forces) in joints {
            if joint.friction <= 0.0 {
                continue;
            }
            let width = Self::width(joint, normal_force);
            more += forces.sensitivity * (width - forces.width);
            let cone = width + joint.friction * SLOPE_SHARE * forces.normal_force;
            if forces.friction > cone + CONE_TOLERANCE * self.units[0] {
                return false;
            }
        }
        more.abs() <= SETTLED_CHANGE * found.load.abs()
    }

    /// The factor of the load in the program. It makes the largest force of a load of 1 as large as the mean weight of a body.
    fn load_unit(&self, live: &[[DVec3; 2]]) -> f64 {
        let largest = live.iter().map(|[force, _]| force.length());
        self.units[0] / largest.fold(1e-12, f64::max)
    }

    /// A force and a moment times a number, in units of the program.
    fn to_units(&self, [force, moment]: [DVec3; 2], times: f64) -> [f64; 6] {
        let [force, moment] = [force * times, moment * (times / self.units[1])];
        [force.x, force.y, force.z, moment.x, moment.y, moment.z]
    }

    /// The resultant of a unit force of a joint on both its bodies.
    fn row(&self, force: Force) -> [Six; 2] {
        [(force.ends[0], 1.0), (force.ends[1], -1.0)].both(|(end, sign)| {
            end.map_or([0.0; 6], |body| {
                let arm = force.at - self.members[body].center;
                let wrench = [force.force, arm.cross(force.force) + force.moment];
                self.to_units(wrench, sign)
            })
        })
    }

    /// Creates the program that all rounds solve, without the widths of the cones.
    ///
    /// It is the dual of the program above. Its unknowns are the velocities of the bodies and the sliding speed of each joint
    /// (`cone_program.rs`).
    fn program(&self, live: &[[DVec3; 2]]) -> Program {
        let [force_unit, _] = self.units;
        let load_unit = self.load_unit(live);
        let dead = self.members.iter().map(|member| member.dead);
        let face = |joint: &Joint| Face {
            ends: joint.ends,
            rows: joint.forces().map(|force| self.row(force)).collect(),
            corners: joint.points.len(),
            slope: 0.0,
            width: 0.0,
            growth: 0.0,
        };
        let scaled = |wrench, times| self.to_units(wrench, times / force_unit);
        Program {
            cost: dead.map(|dead| scaled(dead, -1.0)).collect(),
            load: live.iter().map(|&live| scaled(live, load_unit)).collect(),
            faces: self.joints.iter().map(face).collect(),
        }
    }

    /// Sets the widths and slopes of the friction cones according to these normal forces; without normal forces, to width 0 and slope μ.
    fn set_cones(
        &self,
        program: &mut Program,
        live: &[[DVec3; 2]],
        forces: Option<&[NormalForce]>,
    ) {
        let [force_unit, _] = self.units;
        let load_unit = self.load_unit(live);
        for (number, (joint, face)) in self.joints.iter().zip(&mut program.faces).enumerate() {
            let width = |normal_force: f64| Self::width(joint, normal_force / force_unit);
            [face.slope, face.width, face.growth] = match forces.map(|forces| forces[number]) {
                None => [joint.friction, 0.0, 0.0],
                Some(NormalForce { initial, gain }) => [
                    joint.friction * SLOPE_SHARE,
                    width(initial),
                    width(gain * load_unit),
                ],
            };
        }
    }

    /// Solves the program of a round.
    fn round(
        &self,
        program: &Program,
        scaled: &mut Scaled,
        live: &[[DVec3; 2]],
        normal_forces: Option<&[NormalForce]>,
    ) -> Result<RoundSolution, StabilityError> {
        let [force_unit, length_unit] = self.units;
        let load_unit = self.load_unit(live);
        let endless = RoundSolution {
            load: f64::INFINITY,
            joints: Vec::new(),
            velocities: Vec::new(),
        };
        let solution = match interior::solve(program, scaled) {
            Outcome::Solved(solution) => solution,
            Outcome::Endless => return Ok(endless),
            Outcome::Falls => return Err(StabilityError::Falls),
            Outcome::Unsolved => return Err(StabilityError::Unsolved),
        };
        if solution.load > INFINITE_LOAD * self.members.len() as f64 {
            return Ok(endless);
        }
        let load = solution.load * load_unit;
        let joint_forces = |(number, (face, start)): (usize, (&Face, usize))| {
            let forces = &solution.forces[start..start + face.count()];
            let (corners, cone) = forces.split_at(face.corners);
            let friction = cone.iter().skip(1).map(|force| force * force).sum::<f64>();
            let normal_force = normal_forces.map_or(0.0, |forces| {
                forces[number].initial + load * forces[number].gain
            });
            JointForces {
                normal_force: corners.iter().sum::<f64>() * force_unit,
                friction: friction.sqrt() * force_unit,
                width: Self::width(&self.joints[number], normal_force),
                sensitivity: solution.motion.slides[number] * load_unit / force_unit,
            }
        };
        let velocity =
            |&[x, y, z, a, b, c]: &Six| [DVec3::new(x, y, z), DVec3::new(a, b, c) / length_unit];
        Ok(RoundSolution {
            load,
            joints: program.starts().enumerate().map(joint_forces).collect(),
            velocities: solution.motion.bodies.iter().map(velocity).collect(),
        })
    }

    /// The load on each body, N and N·m.
    fn live(&self, load: &Load) -> Vec<[DVec3; 2]> {
        match *load {
            Load::Everywhere(acceleration) => {
                let forces = self.members.iter();
                let forces = forces.map(|member| member.mass * acceleration.as_dvec3());
                forces.map(|force| [force, DVec3::ZERO]).collect()
            }
            Load::At {
                body,
                point,
                direction,
            } => {
                let mut live = vec![[DVec3::ZERO; 2]; self.members.len()];
                let arm = point.as_dvec3() - self.members[body].center;
                let force = direction.as_dvec3();
                live[body] = [force, arm.cross(force)];
                live
            }
        }
    }

    /// The margin of a solution, with the bodies that move and the joints that fail.
    fn mechanism(&self, found: &RoundSolution) -> Margin {
        let velocities = &found.velocities;
        let fast =
            |[linear, angular]: &[DVec3; 2]| linear.length() + angular.length() * self.units[1];
        let fastest = velocities.iter().map(fast).fold(1e-300, f64::max);
        let moving = self.members.iter().zip(velocities);
        let moving = moving.filter(|(_, velocity)| fast(velocity) > MOVING_SHARE * fastest);
        let moving = moving.map(|(member, velocity)| {
            let [linear, angular] = velocity.map(|v| (v / fastest).as_vec3());
            MovingBody {
                body: member.entity,
                linear,
                angular,
            }
        });
        let at = |end: Option<usize>, point: DVec3| {
            end.map_or(DVec3::ZERO, |body| {
                let [linear, angular] = velocities[body];
                linear + angular.cross(point - self.members[body].center)
            })
        };
        let failing = self.joints.iter().filter_map(|joint| {
            let (mut opens, mut slides) = (0.0, 0.0);
            for &point in &joint.points {
                let apart = at(joint.ends[0], point) - at(joint.ends[1], point);
                let open = apart.dot(joint.frame[0]);
                opens += open.abs();
                slides += (apart - open * joint.frame[0]).length();
            }
            let share = 1.0 / joint.points.len() as f64;
            ((opens + slides) * share > MOVING_SHARE * fastest).then_some(FailingJoint {
                between: joint.between,
                how: match slides > opens {
                    true => JointFailure::Slides,
                    false => JointFailure::Tips,
                },
            })
        });
        Margin {
            limit: found.load.max(0.0) as f32,
            moving: moving.collect(),
            failing: failing.collect(),
        }
    }
}

/// A unit force or moment of a joint.
struct Force {
    ends: [Option<usize>; 2],
    at: DVec3,
    force: DVec3,
    moment: DVec3,
}

impl Joint {
    /// The forces of a joint: a normal force at each corner, and friction at its centre, along two tangents and about the normal.
    fn forces(&self) -> impl Iterator<Item = Force> {
        let of = |at: DVec3, force: DVec3, moment: DVec3| Force {
            ends: self.ends,
            at,
            force,
            moment,
        };
        let [normal, one, other] = self.frame;
        let normal_forces = self
            .points
            .iter()
            .map(move |&point| of(point, normal, DVec3::ZERO));
        let friction = [
            of(self.center, one, DVec3::ZERO),
            of(self.center, other, DVec3::ZERO),
            of(self.center, DVec3::ZERO, self.radius * normal),
        ];
        let friction = friction
            .into_iter()
            .take(if self.friction > 0.0 { 3 } else { 0 });
        normal_forces.chain(friction)
    }
}
