//! A joint row by row, for solvers of points: each row is relaxed by itself, as a contact is. Such a joint yields under load, and the more
//! so the more bodies hang on each other; Soft Step solves joints directly.

use super::rows::{Times, is_angular, take_share};
use super::{Bend, COORDINATES, Geometry, JointConstraint, Law, Part, Placement, rows_of};
use crate::Body;
use crate::Both;
use crate::lanes::State;
use glam::{Mat3, Vec3, Vec4};
use std::cell::Cell;

/// The share of an error of position that is corrected in the longest of recent steps. A short one corrects less: it would give the error
/// of a long one a speed that the next long one follows.
const CORRECTED_SHARE: f32 = 0.2;

/// Fastest correction, m/s and rad/s.
const MAX_CORRECTION: f32 = 2.0;

/// A joint during a step.
#[derive(Clone, Debug)]
pub struct PlainJoint {
    pub joint: JointConstraint,
    h: f32,
    inverse: [(Vec3, Mat3); 2],
    rows: Vec<PlainRow>,
}

#[derive(Clone, Debug)]
struct PlainRow {
    coordinate: usize,
    /// Velocity along and about these is the rate of the coordinate: of both bodies' centres, and of the rotation of A and B.
    linear: Vec3,
    angular: [Vec3; 2],
    law: Law,
    /// Inverse effective mass and compliance.
    response: f32,
    /// N·s or N·m·s.
    impulse: f32,
}

impl PlainJoint {
    /// The joint in a step of `h` s, where the longest of recent ones took `longest`; none if it has no effect.
    pub fn new(joint: &JointConstraint, bodies: &[Body], [h, longest]: [f32; 2]) -> Option<Self> {
        if !joint.acts(bodies) {
            return None;
        }
        let ends = joint.bodies.both(|body| &bodies[body as usize]);
        let geometry = Geometry::new(joint, [Placement::START; 2]);
        let bend = geometry.bend(ends.both(|body| [body.linear, body.angular]));
        let times = Times {
            h,
            left: longest,
            bias_rate: CORRECTED_SHARE / longest,
            fastest: MAX_CORRECTION,
        };
        let mut left = joint.forces.map(|force| h * force);
        let kinds: Vec<(usize, Part)> = rows_of(joint).collect();
        let rows = kinds.iter().enumerate().map(|(i, &(coordinate, part))| {
            let found = geometry.coordinate(coordinate);
            let mut law = Law::of(joint.axis(coordinate), part, found.value, &times);
            if law.is_held {
                let curvature = bend.curvature(coordinate, found.direction);
                law.rate -= Bend::inward_rate(curvature, h);
            }
            let (linear, angular) = geometry.jacobian(coordinate, found.direction);
            let response = |side: usize| {
                let body = ends[side];
                body.inverse_mass * (linear * body.free_axes).length_squared()
                    + angular[side].dot(body.inverse_inertia * angular[side])
            };
            let is_last = kinds.get(i + 1).is_none_or(|next| next.0 != coordinate);
            PlainRow {
                coordinate,
                linear,
                angular,
                law,
                response: response(0) + response(1) + law.compliance,
                impulse: take_share(&mut left[coordinate], &law, is_last),
            }
        });
        Some(Self {
            h,
            inverse: ends.both(|body| (body.inverse_mass * body.free_axes, body.inverse_inertia)),
            rows: rows.collect(),
            joint: JointConstraint {
                angles: geometry.angles(),
                ..*joint
            },
        })
    }

    /// Changes of the velocities of A and B by the impulses to begin with.
    pub fn warm_start(&self) -> [[Vec3; 2]; 2] {
        let mut change = [[Vec3::ZERO; 2]; 2];
        for row in &self.rows {
            row.push(row.impulse, &self.inverse, &mut change);
        }
        change
    }

    /// Relaxes each row once. `velocities` are linear and angular ones of A and B, and are changed. Returns Σ W Δλ², J.
    pub fn relax(&mut self, velocities: &mut [[Vec3; 2]; 2]) -> f32 {
        let mut sum = 0.0;
        for row in &mut self.rows {
            if row.response <= 0.0 {
                continue;
            }
            let [a, b] = *velocities;
            let rate =
                row.linear.dot(b[0] - a[0]) + row.angular[1].dot(b[1]) - row.angular[0].dot(a[1]);
            let lack = row.law.rate - rate - row.law.compliance * row.impulse;
            let [low, high] = row.law.bounds;
            let impulse = (row.impulse + lack / row.response).clamp(low, high);
            let change = impulse - row.impulse;
            row.impulse = impulse;
            row.push(change, &self.inverse, velocities);
            sum += row.response * change * change;
        }
        sum
    }

    /// [`relax`](Self::relax) with the velocities of all bodies.
    pub fn visit(&mut self, velocities: &[Cell<State>]) -> f32 {
        let ends = self.joint.bodies.both(|body| &velocities[body as usize]);
        let mut found = ends.both(|end| end.get().map(Vec4::truncate));
        let change = self.relax(&mut found);
        for (end, found) in ends.into_iter().zip(found) {
            end.set(found.both(|velocity| velocity.extend(0.0)));
        }
        change
    }

    /// The impulses of its rows.
    pub fn impulses(&mut self) -> impl Iterator<Item = &mut f32> {
        self.rows.iter_mut().map(|row| &mut row.impulse)
    }

    /// The joint with its forces.
    pub fn found(&self) -> JointConstraint {
        let mut joint = self.joint;
        joint.forces = [0.0; COORDINATES];
        let [mut force, mut torque] = [Vec3::ZERO; 2];
        for row in &self.rows {
            let along = row.impulse / self.h;
            joint.forces[row.coordinate] += along;
            match row.coordinate {
                coordinate if is_angular(coordinate) => torque += along * row.angular[1],
                _ => force += along * row.linear,
            }
        }
        joint.mean = [force, torque];
        joint.filter_forces(self.h);
        joint
    }
}

impl PlainRow {
    fn push(&self, impulse: f32, inverse: &[(Vec3, Mat3); 2], to: &mut [[Vec3; 2]; 2]) {
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (mass, inertia) = &inverse[side];
            to[side][0] += sign * impulse * *mass * self.linear;
            to[side][1] += *inertia * (sign * impulse * self.angular[side]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointAxis, Nncg, Pgs, PointProblem, PointSolver};
    use glam::Quat;

    const DT: f32 = 1.0 / 60.0;

    /// Five links of 1 kg and 0.5 m, let go from horizontal; warm-started with `solver`. Returns the largest gap and the largest speed.
    fn whip(solver: &dyn PointSolver) -> (f32, f32) {
        let mut places: Vec<(Vec3, Quat)> = vec![(Vec3::ZERO, Quat::IDENTITY)];
        let mut velocities = vec![[Vec3::ZERO; 2]; 6];
        places.extend((0..5).map(|i| (Vec3::X * (0.5 * i as f32 + 0.25), Quat::IDENTITY)));
        let mut joints = vec![JointConstraint::default(); 5];
        let (mut gap, mut speed) = (0f32, 0f32);
        for _ in 0..300 {
            let inverse = Mat3::from_diagonal(Vec3::splat(48.0));
            let mut bodies: Vec<Body> = velocities
                .iter()
                .enumerate()
                .map(|(i, &[linear, angular])| match i {
                    0 => Body::default(),
                    _ => Body {
                        linear: linear + Vec3::NEG_Y * 9.81 * DT,
                        angular,
                        inverse_mass: 1.0,
                        inverse_inertia: inverse,
                        start: [linear, angular],
                        ..Default::default()
                    },
                })
                .collect();
            for (i, joint) in joints.iter_mut().enumerate() {
                let [(a, turn), (b, spin)] = [places[i], places[i + 1]];
                let first = if i == 0 {
                    Vec3::ZERO
                } else {
                    turn * (0.25 * Vec3::X)
                };
                let arms = [first, spin * (-0.25 * Vec3::X)];
                *joint = JointConstraint {
                    bodies: [i as u32, i as u32 + 1],
                    arms,
                    gap: b + arms[1] - a - arms[0],
                    frames: [turn, spin],
                    ..*joint
                };
                joint.axes[..3].fill(JointAxis::LOCKED);
                gap = gap.max(joint.gap.length());
            }
            let mut problem = PointProblem {
                bodies: &mut bodies,
                constraints: &mut [],
                grabs: &mut [],
                joints: &mut joints,
                dt: DT,
                max_recent_dt: DT,
                effort: 1.0,
                free_merit: 1.0,
                record_history: false,
            };
            problem.warm_start(solver.warm_start());
            solver.solve(&mut problem);
            for ((place, velocity), body) in places.iter_mut().zip(&mut velocities).zip(&bodies) {
                place.0 += DT * body.linear;
                place.1 = (Quat::from_scaled_axis(DT * body.angular) * place.1).normalize();
                *velocity = [body.linear, body.angular];
                speed = speed.max(body.linear.length());
            }
        }
        (gap, speed)
    }

    #[test]
    fn chains_hold_under_point_solvers() {
        let solvers: [&dyn PointSolver; 4] = [
            &Pgs::default(),
            &Pgs {
                warm_start: 1.0,
                ..Default::default()
            },
            &Nncg::default(),
            &Nncg {
                warm_start: 1.0,
                ..Default::default()
            },
        ];
        for solver in solvers {
            let (gap, speed) = whip(solver);
            assert!(
                gap < 0.3 && speed < 12.0,
                "{}: {gap} m, {speed} m/s",
                solver.name()
            );
        }
    }
}
