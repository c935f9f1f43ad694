//! The cone program of a structure: the largest load λ for which contact forces f balance it,
//!
//! max λ  so that  Σ Gᵀf + w + λ l = 0 for each body,  f_n ≥ 0 at each corner of a face,  ‖(f_t, f_τ/r)‖ ≤ c + μ' Σ f_n for each face.
//!
//! Forces are in units of the mean weight of a body, lengths in units of the mean radius, so that the numbers are near 1. The dual variables of the
//! balance are the velocities of the mechanism by which the structure fails: a motion in which the load does the work that weight and friction consume.
//!
//! With c = 0 and μ' = μ this is the theorem of plasticity, in which sliding joints also open, by μ times as much. A brick between others
//! would have to lift the wall to be pulled out, and would be held far too strongly. Therefore the width of a cone is set by the normal force N on the
//! face: c = μ (1 − ε) N and μ' = ε μ (Gilbert, Casapulla, Ahmed 2006). They take N from the previous round; but of the many N that balance
//! a load, their rounds find the most favourable one, a wall that hangs on the brick that is pulled. Here N is the current normal force, plus the
//! part that the load adds if all joints are equally soft (least squares). The second part is a multiple of λ and is in the program as such, c = c₀ + λ d.
//! A round only has to know which joints the load relieves completely. The first round assumes none, and usually is enough.

use super::cone_program::{Face, Program, Six};
use super::interior::{self, Outcome};
use super::scaled::Scaled;
use super::structure::{Joint, Structure};
use super::{FailingJoint, JointFailure, Margin, MovingBody, StabilityError};
use glam::{DVec3, Vec3};

/// Bodies slower than this share of the fastest count as not moving.
const MOVES: f64 = 0.01;

/// A load of this many times the total weight counts as infinite.
const ENDLESS: f64 = 1e4;

/// ε: the share of the slope of a cone of friction that is kept.
const SLOPE: f64 = 0.01;

/// Rounds, at most, and by what share the load of one may differ from that of the one before.
const ROUNDS: usize = 8;
const STEADY: f64 = 2e-3;

/// Tolerance of the cones, as a share of the mean weight of a body.
const WITHIN: f64 = 1e-4;

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

/// The forces at a joint in a solution, and the sensitivity of the load to them.
struct Balanced {
    /// Normal force, N.
    pressure: f64,
    /// Friction: the norm of the friction force and its moment, as in the cone, N.
    friction: f64,
    /// Width c of the cone without a normal force, N.
    width: f64,
    /// Increase of the load, as a multiple, for each N of additional width.
    worth: f64,
}

/// A solution.
struct Found {
    /// As a multiple of the load.
    most: f64,
    /// By joint.
    joints: Vec<Balanced>,
    /// By body: linear and angular, of the mechanism.
    velocities: Vec<[DVec3; 2]>,
}

/// The normal forces that limit friction, by joint: a constant part, N, and a part for each unit of the load.
#[derive(Clone, Copy)]
struct Pressed {
    now: f64,
    gains: f64,
}

impl Structure {
    /// The largest load, as a multiple, and how it fails then.
    pub fn solve(&self, load: &Load) -> Result<Margin, StabilityError> {
        let live = self.live(load);
        let mut program = self.program(&live);
        let mut scaled = Scaled::new(&program);
        let gains = self.gains(&live, &program, &mut scaled);
        let mut round = |pressed: Option<&[Pressed]>| {
            self.widen(&mut program, &live, pressed);
            self.round(&program, &mut scaled, &live, pressed)
        };
        let still = |now: f64| Pressed { now, gains: 0.0 };
        let now = self.joints.iter().map(|joint| joint.pressure);
        let mut now: Vec<f64> = now.collect();
        let first: Vec<Pressed> = now.iter().copied().map(still).collect();
        let mut found = match round(Some(&first)) {
            // The current normal forces may be those of an impact, or of a structure that does not stand.
            Err(StabilityError::Falls) => {
                let found = round(None)?;
                now = found.joints.iter().map(|joint| joint.pressure).collect();
                found
            }
            found => found?,
        };
        let mut before = Vec::new();
        for _ in 0..ROUNDS {
            if found.most.is_infinite() {
                return Ok(Margin {
                    limit: f32::INFINITY,
                    moving: Vec::new(),
                    failing: Vec::new(),
                });
            }
            let joints = now.iter().zip(&gains);
            let under_load: Vec<f64> = joints
                .clone()
                .map(|(now, gains)| (now + found.most * gains).max(0.0))
                .collect();
            if self.holds(&found, &under_load) {
                break;
            }
            let bare: Vec<bool> = under_load
                .iter()
                .map(|&pressure| pressure <= WITHIN * self.units[0])
                .collect();
            if bare == before {
                break;
            }
            let pressed = joints.zip(&bare).map(|((&now, &gains), bare)| match bare {
                true => still(0.0),
                false => Pressed { now, gains },
            });
            let pressed: Vec<Pressed> = pressed.collect();
            before = bare;
            let most = found.most;
            found = match round(Some(&pressed)) {
                Err(StabilityError::Falls) => break,
                found => found?,
            };
            if (found.most - most).abs() <= STEADY * most.abs() {
                break;
            }
        }
        // That the load could be taken off by as much is not asked.
        match found.most >= -1e-6 {
            true => Ok(self.mechanism(&found)),
            false => Err(StabilityError::Falls),
        }
    }

    /// The normal force that a unit of the load adds at each joint, if all joints are equally soft: the least-squares forces that balance it. If
    /// no forces balance it, only the cones decide.
    fn gains(&self, live: &[[DVec3; 2]], program: &Program, scaled: &mut Scaled) -> Vec<f64> {
        let [force_unit, _] = self.units;
        let share = -force_unit / self.load_unit(live);
        let Some(forces) = scaled.least(program, &program.load) else {
            return vec![0.0; self.joints.len()];
        };
        let mut forces = forces.iter();
        let pressure = |face: &Face| {
            let pressure: f64 = forces.by_ref().take(face.corners).sum();
            let rubs = face.rows.len() - face.corners;
            forces.by_ref().take(rubs).for_each(drop);
            pressure * share
        };
        program.faces.iter().map(pressure).collect()
    }

    /// Width c of the cone of a joint with this normal force, N.
    fn width(joint: &Joint, pressure: f64) -> f64 {
        joint.friction * (1.0 - SLOPE) * pressure
    }

    /// Returns true if a solution is also one of the next round, with cones as wide as these pressures make them: its forces are within those
    /// cones, and by its dual variables, which bound the load from above in that round as well, no more load is to be had.
    fn holds(&self, found: &Found, pressures: &[f64]) -> bool {
        let mut more = 0.0;
        let joints = self.joints.iter().zip(pressures).zip(&found.joints);
        for ((joint, &pressure), balanced) in joints {
            if joint.friction <= 0.0 {
                continue;
            }
            let width = Self::width(joint, pressure);
            more += balanced.worth * (width - balanced.width);
            let cone = width + joint.friction * SLOPE * balanced.pressure;
            if balanced.friction > cone + WITHIN * self.units[0] {
                return false;
            }
        }
        more.abs() <= STEADY * found.most.abs()
    }

    /// The load is counted so that one of it is as large as a body's weight: by so many.
    fn load_unit(&self, live: &[[DVec3; 2]]) -> f64 {
        let largest = live.iter().map(|[force, _]| force.length());
        self.units[0] / largest.fold(1e-12, f64::max)
    }

    /// Force and moment as they are counted, times a number.
    fn counted(&self, [force, moment]: [DVec3; 2], times: f64) -> [f64; 6] {
        let [force, moment] = [force * times, moment * (times / self.units[1])];
        [force.x, force.y, force.z, moment.x, moment.y, moment.z]
    }

    /// The resultant of a unit force of a joint on both its bodies.
    fn row(&self, force: Force) -> [Six; 2] {
        [(force.ends[0], 1.0), (force.ends[1], -1.0)].map(|(end, sign)| {
            end.map_or([0.0; 6], |body| {
                let arm = force.at - self.members[body].center;
                let wrench = [force.force, arm.cross(force.force) + force.moment];
                self.counted(wrench, sign)
            })
        })
    }

    /// The program that all rounds solve; how wide cones are is still to be said.
    ///
    /// It is the dual of the one above, of which the unknowns are velocities and how fast each joint slides (`cone_program.rs`).
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
            grows: 0.0,
        };
        let counted = |wrench, times| self.counted(wrench, times / force_unit);
        Program {
            cost: dead.map(|dead| counted(dead, -1.0)).collect(),
            load: live.iter().map(|&live| counted(live, load_unit)).collect(),
            faces: self.joints.iter().map(face).collect(),
        }
    }

    /// Makes cones of friction as wide as these pressures make them; sloping as they are where there are none.
    fn widen(&self, program: &mut Program, live: &[[DVec3; 2]], pressed: Option<&[Pressed]>) {
        let [force_unit, _] = self.units;
        let load_unit = self.load_unit(live);
        for (number, (joint, face)) in self.joints.iter().zip(&mut program.faces).enumerate() {
            let width = |pressure: f64| Self::width(joint, pressure / force_unit);
            [face.slope, face.width, face.grows] = match pressed.map(|pressed| pressed[number]) {
                None => [joint.friction, 0.0, 0.0],
                Some(Pressed { now, gains }) => {
                    [joint.friction * SLOPE, width(now), width(gains * load_unit)]
                }
            };
        }
    }

    /// Solves the program of a round.
    fn round(
        &self,
        program: &Program,
        scaled: &mut Scaled,
        live: &[[DVec3; 2]],
        pressed: Option<&[Pressed]>,
    ) -> Result<Found, StabilityError> {
        let [force_unit, length_unit] = self.units;
        let load_unit = self.load_unit(live);
        let endless = Found {
            most: f64::INFINITY,
            joints: Vec::new(),
            velocities: Vec::new(),
        };
        let solution = match interior::solve(program, scaled) {
            Outcome::Solved(solution) => solution,
            Outcome::Endless => return Ok(endless),
            Outcome::Falls => return Err(StabilityError::Falls),
            Outcome::Unsolved => return Err(StabilityError::Unsolved),
        };
        if solution.most > ENDLESS * self.members.len() as f64 {
            return Ok(endless);
        }
        let most = solution.most * load_unit;
        let balanced = |(number, (face, start)): (usize, (&Face, usize))| {
            let forces = &solution.forces[start..start + face.count()];
            let (corners, cone) = forces.split_at(face.corners);
            let friction = cone.iter().skip(1).map(|force| force * force).sum::<f64>();
            let pressed = pressed.map_or(0.0, |pressed| {
                pressed[number].now + most * pressed[number].gains
            });
            Balanced {
                pressure: corners.iter().sum::<f64>() * force_unit,
                friction: friction.sqrt() * force_unit,
                width: Self::width(&self.joints[number], pressed),
                worth: solution.motion.slides[number] * load_unit / force_unit,
            }
        };
        let velocity =
            |&[x, y, z, a, b, c]: &Six| [DVec3::new(x, y, z), DVec3::new(a, b, c) / length_unit];
        Ok(Found {
            most,
            joints: program.starts().enumerate().map(balanced).collect(),
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

    fn mechanism(&self, found: &Found) -> Margin {
        let velocities = &found.velocities;
        let fast =
            |[linear, angular]: &[DVec3; 2]| linear.length() + angular.length() * self.units[1];
        let fastest = velocities.iter().map(fast).fold(1e-300, f64::max);
        let moving = self.members.iter().zip(velocities);
        let moving = moving.filter(|(_, velocity)| fast(velocity) > MOVES * fastest);
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
        let gives = self.joints.iter().filter_map(|joint| {
            let (mut opens, mut slides) = (0.0, 0.0);
            for &point in &joint.points {
                let apart = at(joint.ends[0], point) - at(joint.ends[1], point);
                let open = apart.dot(joint.frame[0]);
                opens += open.abs();
                slides += (apart - open * joint.frame[0]).length();
            }
            let share = 1.0 / joint.points.len() as f64;
            ((opens + slides) * share > MOVES * fastest).then_some(FailingJoint {
                between: joint.between,
                how: match slides > opens {
                    true => JointFailure::Slides,
                    false => JointFailure::Tips,
                },
            })
        });
        Margin {
            limit: found.most.max(0.0) as f32,
            moving: moving.collect(),
            failing: gives.collect(),
        }
    }
}

/// A unit of one of the forces of a joint.
struct Force {
    ends: [Option<usize>; 2],
    at: DVec3,
    force: DVec3,
    moment: DVec3,
}

impl Joint {
    /// The forces of a joint: normal forces at each corner; friction at its middle, along two tangents and about the normal.
    fn forces(&self) -> impl Iterator<Item = Force> {
        let of = |at: DVec3, force: DVec3, moment: DVec3| Force {
            ends: self.ends,
            at,
            force,
            moment,
        };
        let [normal, one, other] = self.frame;
        let presses = self
            .points
            .iter()
            .map(move |&point| of(point, normal, DVec3::ZERO));
        let rubs = [
            of(self.center, one, DVec3::ZERO),
            of(self.center, other, DVec3::ZERO),
            of(self.center, DVec3::ZERO, self.radius * normal),
        ];
        let rubs = rubs
            .into_iter()
            .take(if self.friction > 0.0 { 3 } else { 0 });
        presses.chain(rubs)
    }
}
