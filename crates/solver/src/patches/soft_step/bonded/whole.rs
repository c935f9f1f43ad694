//! A structure as one rigid body: its mass, its inertia and its velocities, and the motion of its bricks.

use super::structure::Structure;
use crate::patches::soft_step::joints::principal;
use crate::spin::{self, Rotor};
use crate::{Body, Both, PatchProblem};
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// Rounding of a pose in single precision, as a share of the distance from the origin, and rad.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// A share of the energy of a spin that is rounding of single precision.
const GAIN: f64 = 1e-6;

/// The motion of a structure in a step, or the velocities of it or of a brick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Twist {
    pub linear: DVec3,
    pub angular: DVec3,
}

/// A structure as one body, at the beginning of a step.
#[derive(Clone, Debug)]
pub struct Whole {
    /// Total mass, kg.
    pub mass: f64,
    /// Rotation from the axes of the first member to those of the world.
    pub turn: DQuat,
    /// Inertia about the centre of mass, world axes, kg·m².
    pub inertia: DMat3,
    /// By member: from the centre of mass to its own, world axes, m.
    pub arms: Vec<DVec3>,
    /// By member: its mass, kg, and its inertia, world axes, kg·m².
    pub masses: Vec<(f64, DMat3)>,
    /// By member.
    strayed: Vec<Strayed>,
}

/// How far a member is from its place.
#[derive(Clone, Copy, Debug)]
struct Strayed {
    /// From where it is to its place, m and rad.
    off: DVec3,
    turned: DVec3,
    /// Rounding of its position, m.
    slack: f64,
}

impl Strayed {
    /// The part of it that is corrected while it moves along a way, m: all, or what is beyond rounding if it rests.
    fn back(&self, way: DVec3) -> [DVec3; 2] {
        match way.length() > self.slack {
            true => [self.off, self.turned],
            false => [
                beyond(self.off, self.slack),
                beyond(self.turned, 2.0 * ROUNDING),
            ],
        }
    }
}

/// Beyond rounding.
fn beyond(vector: DVec3, slack: f64) -> DVec3 {
    vector - vector.clamp(DVec3::splat(-slack), DVec3::splat(slack))
}

/// The rotation vector of a small rotation, rad.
fn small(turn: DQuat) -> DVec3 {
    2.0 * turn.xyz() * turn.w.signum()
}

/// The cross product with a vector, as a matrix.
fn cross(v: DVec3) -> DMat3 {
    DMat3::from_cols(v.cross(DVec3::X), v.cross(DVec3::Y), v.cross(DVec3::Z))
}

impl Whole {
    pub fn of(structure: &Structure, problem: &PatchProblem) -> Self {
        let seen = |member: usize| {
            let (bond, side) = structure.seen_from[member];
            let end = problem.joints[structure.bonds[bond].joint]
                .bond
                .map(|ends| ends[side]);
            end.map_or((DVec3::ZERO, DQuat::IDENTITY), |end| {
                (end.center.as_dvec3(), end.rotation.as_dquat().normalize())
            })
        };
        let members = 0..structure.members.len();
        let poses: Vec<_> = members.map(seen).collect();
        let body = |&number: &u32| &problem.bodies[number as usize];
        let masses: Vec<_> = structure
            .members
            .iter()
            .map(body)
            .map(|body| (1.0 / f64::from(body.inverse_mass), body.inertia()))
            .collect();
        let mass: f64 = masses.iter().map(|(mass, _)| mass).sum();
        let mean = |of: &dyn Fn(usize) -> DVec3| {
            let sum: DVec3 = masses
                .iter()
                .enumerate()
                .map(|(i, (mass, _))| *mass * of(i))
                .sum();
            sum / mass
        };
        let center = mean(&|i| poses[i].0);
        let middle = mean(&|i| structure.places[i].center);
        let turn = poses[0].1;
        let arms: Vec<DVec3> = poses.iter().map(|(at, _)| *at - center).collect();
        let mut inertia = DMat3::ZERO;
        for (arm, (mass, own)) in arms.iter().zip(&masses) {
            inertia += *own - *mass * cross(*arm) * cross(*arm);
        }
        let strayed = structure.places.iter().zip(&poses);
        let strayed = strayed.map(|(place, (at, turned))| {
            let out = place.center - middle;
            Strayed {
                off: center + turn * out - *at,
                turned: small(turn * place.turn * turned.inverse()),
                slack: ROUNDING * (at.abs().max_element() + out.length()),
            }
        });
        Self {
            strayed: strayed.collect(),
            mass,
            turn,
            inertia,
            arms,
            masses,
        }
    }

    /// The velocities of the whole that have the momentum of given velocities of its members.
    pub fn velocities(&self, of: impl Fn(usize) -> [Vec3; 2]) -> Twist {
        let (mut momentum, mut spin) = (DVec3::ZERO, DVec3::ZERO);
        for (member, (arm, (mass, inertia))) in self.arms.iter().zip(&self.masses).enumerate() {
            let [linear, angular] = of(member).both(|v| v.as_dvec3());
            momentum += *mass * linear;
            spin += *mass * arm.cross(linear) + *inertia * angular;
        }
        Twist {
            linear: momentum / self.mass,
            angular: self.inertia.inverse() * spin,
        }
    }

    /// As a body of a solver. `members` are its members among `bodies`.
    pub fn body(&self, members: &[u32], bodies: &[Body]) -> Body {
        let of = |member: usize| &bodies[members[member] as usize];
        let now = self.velocities(|member| [of(member).linear, of(member).angular]);
        let start = self.velocities(|member| of(member).start);
        let mut found = Body {
            linear: now.linear.as_vec3(),
            angular: now.angular.as_vec3(),
            start: [start.linear, start.angular].both(|v| v.as_vec3()),
            inverse_mass: (1.0 / self.mass) as f32,
            inverse_inertia: self.inertia.inverse().as_mat3(),
            still_below: [f32::INFINITY; 2],
            level: u32::MAX,
            ..Body::default()
        };
        for (member, arm) in self.arms.iter().enumerate() {
            let of = of(member);
            let [linear, angular] = of.still_below;
            let far = (arm.length() as f32).max(f32::MIN_POSITIVE);
            found.still_below[0] = found.still_below[0].min(linear);
            found.still_below[1] = found.still_below[1].min(angular).min(linear / far);
            if of.level > 0 {
                found.level = found.level.min(of.level);
            }
        }
        if found.level == u32::MAX {
            found.level = 0;
        }
        found
    }

    /// Its rotation in a step that ends with the velocities of `solved`, and its angular velocity then, with the gyroscopic change.
    fn turned(&self, solved: &Body, dt: f32) -> (DQuat, DVec3) {
        let [_, motion] = solved.motion.unwrap_or([solved.linear, solved.angular]);
        if solved.motion_is_exact {
            let turn = DQuat::from_scaled_axis((dt * motion).as_dvec3());
            return (turn, solved.angular.as_dvec3());
        }
        let (axes, moments) = principal(&self.inertia);
        let rotor = Rotor {
            inverse_inertia: moments.recip().as_vec3(),
            local_frame: Quat::from_mat3(&axes),
        };
        // First as if it were free; then what contacts have changed during the step turns it further.
        let (free, spun) = spin::rotate(&rotor, Quat::IDENTITY, solved.angular, dt);
        let further = spin::turn((motion - solved.angular).as_dvec3(), dt);
        let turn = (further * free.as_dquat()).normalize();
        let momentum = self.inertia * solved.angular.as_dvec3();
        let kept = turn * (self.inertia.inverse() * (turn.inverse() * momentum));
        // That must gain no energy.
        let spun = further * spun.as_dvec3();
        let before = spun.dot(further * momentum);
        let angular = match kept.dot(momentum) <= (1.0 + GAIN) * before {
            true => kept,
            false => spun,
        };
        (turn, angular)
    }

    /// Keeps its members where they are.
    pub fn hold(members: &[u32], bodies: &mut [Body]) {
        for &member in members {
            let body = &mut bodies[member as usize];
            (body.linear, body.angular) = (Vec3::ZERO, Vec3::ZERO);
            body.motion = Some([Vec3::ZERO; 2]);
            body.motion_is_exact = true;
        }
    }

    /// Moves its members with it. `solved` is the whole after the step.
    pub fn carry(&self, solved: &Body, dt: f32, members: &[u32], bodies: &mut [Body]) {
        let [linear, _] = solved.motion.unwrap_or([solved.linear, solved.angular]);
        let moved = (dt * linear).as_dvec3();
        let (turn, spin) = self.turned(solved, dt);
        let velocity = solved.linear.as_dvec3();
        for (member, arm) in self.arms.iter().enumerate() {
            let there = turn * *arm;
            let way = moved + (there - *arm);
            let [strayed, strayed_turn] = self.strayed[member].back(way);
            let way = way + strayed;
            let turned = turn * DQuat::from_scaled_axis(strayed_turn);
            let turned = if turned.w < 0.0 { -turned } else { turned };
            let body = &mut bodies[members[member] as usize];
            body.linear = (velocity + spin.cross(there)).as_vec3();
            body.angular = spin.as_vec3();
            let mean = [way, turned.to_scaled_axis()];
            body.motion = Some(mean.both(|part| (part / f64::from(dt)).as_vec3()));
            body.motion_is_exact = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cross_product_is_a_matrix() {
        let [a, b] = [DVec3::new(1.0, -2.0, 0.5), DVec3::new(0.3, 0.7, -1.1)];
        assert!((cross(a) * b - a.cross(b)).length() < 1e-12);
    }
}
