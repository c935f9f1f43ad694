//! The cone program of a structure: the largest load λ for which contact forces f balance it,
//!
//! max λ  so that  Σ Gᵀf + w + λ l = 0 for each body,  f_n ≥ 0 at each corner of a face,  ‖(f_t, f_τ/r)‖ ≤ c + μ' Σ f_n for each face.
//!
//! Forces are counted in the mean weight of a body, lengths in their mean radius, so that the numbers are near 1. The dual variables of the
//! balance are the velocities of a motion in which the load gains what weight and friction lose: the mechanism by which it fails.
//!
//! With c = 0 and μ' = μ that is the theorem of plasticity, in which what slides opens as well, by μ times as much: a brick between others
//! would have to lift the wall to be pulled out of it, and would be held by far too much. So a cone is made as wide as what presses on the face
//! makes it, c = μ (1 − ε) N and μ' = ε μ (Gilbert, Casapulla, Ahmed 2006). They take N from the round before; but of the many N that balance
//! a load their rounds find the one that helps most, a wall that hangs on the brick that is pulled. Here N is what presses now, and what the
//! load adds to it if all gives way alike, which is least squares; rounds go on until the load does not change any more.

use super::structure::{Joint, Structure};
use super::{Giving, How, Margin, Moving, StabilityError};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
    SupportedConeT, ZeroConeT,
};
use glam::{DVec3, Vec3};

/// What moves by less than this share of the fastest does not move.
const MOVES: f64 = 0.01;

/// A load so many times the weight of all is never reached.
const ENDLESS: f64 = 1e4;

/// ε: what is left of the slope of a cone of friction.
const SLOPE: f64 = 0.01;

/// Rounds, at most, and by what share the load of one may differ from that of the one before.
const ROUNDS: usize = 8;
const STEADY: f64 = 2e-3;

/// A force is within a cone that it is outside of by this share of the mean weight of a body.
const WITHIN: f64 = 1e-4;

/// What is made larger.
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

/// What balances at a joint, and what it is worth.
struct Balanced {
    /// What presses, N.
    pressure: f64,
    /// What rubs: the length of friction and its moment as the cone measures them, N.
    friction: f64,
    /// How wide the cone is, where nothing presses, N: c.
    cohesion: f64,
    /// By how much more of the load, as a multiple, there could be for each N more of that.
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

impl Structure {
    /// The largest load, as a multiple, and how it fails then.
    pub fn solve(&self, load: &Load) -> Result<Margin, StabilityError> {
        let live = self.live(load);
        let gains = self.gains(&live)?;
        let now = self.joints.iter().map(|joint| joint.pressure);
        let mut now: Vec<f64> = now.collect();
        let mut found = match self.round(&live, Some(&now)) {
            // What presses now may be that of a blow, or of something that does not stand.
            Err(StabilityError::Falls) => {
                let found = self.round(&live, None)?;
                now = found.joints.iter().map(|joint| joint.pressure).collect();
                found
            }
            found => found?,
        };
        for _ in 0..ROUNDS {
            if found.most.is_infinite() {
                return Ok(Margin {
                    most: f32::INFINITY,
                    moving: Vec::new(),
                    gives: Vec::new(),
                });
            }
            let under_load = now.iter().zip(&gains);
            let under_load: Vec<f64> = under_load
                .map(|(now, gains)| (now + found.most * gains).max(0.0))
                .collect();
            if self.holds(&found, &under_load) {
                break;
            }
            let before = found.most;
            found = match self.round(&live, Some(&under_load)) {
                Err(StabilityError::Falls) => break,
                found => found?,
            };
            if (found.most - before).abs() <= STEADY * before.abs() {
                break;
            }
        }
        // That the load could be taken off by as much is not asked.
        match found.most >= -1e-6 {
            true => Ok(self.mechanism(&found)),
            false => Err(StabilityError::Falls),
        }
    }

    /// By how much one of the load presses more on each joint, if all gave way alike: the least forces that balance it.
    fn gains(&self, live: &[[DVec3; 2]]) -> Result<Vec<f64>, StabilityError> {
        let [force_unit, _] = self.units;
        let mut rows = self.rows();
        for joint in &self.joints {
            self.add(joint, 0.0, 0.0, &mut rows);
        }
        let balance = 6 * self.members.len();
        let largest = live.iter().map(|[force, _]| force.length());
        let load_unit = force_unit / largest.fold(1e-12, f64::max);
        for (body, live) in live.iter().enumerate() {
            for (row, number) in rows.of(body, live.map(|load| load * load_unit)) {
                rows.wanted[row] = -number;
            }
        }
        let forces = rows.least(balance)?;
        let share = force_unit / load_unit;
        Ok(self
            .pressures(&forces)
            .map(|[pressure, _]| pressure * share)
            .collect())
    }

    /// What presses on each joint and what rubs there, as forces have it.
    fn pressures(&self, forces: &[f64]) -> impl Iterator<Item = [f64; 2]> {
        let mut forces = forces.iter();
        self.joints.iter().map(move |joint| {
            let corners = forces.by_ref().take(joint.points.len());
            let pressure: f64 = corners.sum();
            let rubs = if joint.friction > 0.0 { 3 } else { 0 };
            let squares = forces.by_ref().take(rubs).map(|force| force * force);
            [pressure, squares.sum::<f64>().sqrt()]
        })
    }

    /// How wide the cone of a joint is where so much presses on it, N: c.
    fn cohesion(joint: &Joint, pressure: f64) -> f64 {
        joint.friction * (1.0 - SLOPE) * pressure
    }

    /// True where a solution is also one of the round after it, with cones as wide as these pressures make them: its forces are within those
    /// cones, and by its dual variables, which bound the load from above in that round as well, no more load is to be had.
    fn holds(&self, found: &Found, pressures: &[f64]) -> bool {
        let mut more = 0.0;
        let joints = self.joints.iter().zip(pressures).zip(&found.joints);
        for ((joint, &pressure), balanced) in joints {
            if joint.friction <= 0.0 {
                continue;
            }
            let cohesion = Self::cohesion(joint, pressure);
            more += balanced.worth * (cohesion - balanced.cohesion);
            let cone = cohesion + joint.friction * SLOPE * balanced.pressure;
            if balanced.friction > cone + WITHIN * self.units[0] {
                return false;
            }
        }
        more.abs() <= STEADY * found.most.abs()
    }

    /// Of the balance, without a force.
    fn rows(&self) -> Rows {
        let [force_unit, length_unit] = self.units;
        let balance = 6 * self.members.len();
        Rows {
            units: [force_unit, force_unit * length_unit],
            columns: Columns::default(),
            wanted: vec![0.0; balance],
            cones: vec![ZeroConeT(balance)],
        }
    }

    /// With cones of friction as wide as these pressures make them; sloping as they are where there are none.
    fn round(
        &self,
        live: &[[DVec3; 2]],
        pressures: Option<&[f64]>,
    ) -> Result<Found, StabilityError> {
        let [force_unit, length_unit] = self.units;
        // The load is counted so that one of it is as large as a body's weight.
        let largest = live.iter().map(|[force, _]| force.length());
        let load_unit = force_unit / largest.fold(1e-12, f64::max);
        let balance = 6 * self.members.len();
        let mut rows = self.rows();
        for (body, live) in live.iter().enumerate() {
            rows.add(body, live.map(|load| load * load_unit));
        }
        rows.columns.close();
        for (body, member) in self.members.iter().enumerate() {
            for (row, number) in rows.of(body, member.dead) {
                rows.wanted[row] = -number;
            }
        }
        for (number, joint) in self.joints.iter().enumerate() {
            let (cohesion, slope) = match pressures {
                Some(pressures) => {
                    let pressure = pressures[number] / force_unit;
                    (Self::cohesion(joint, pressure), joint.friction * SLOPE)
                }
                None => (0.0, joint.friction),
            };
            self.add(joint, cohesion, slope, &mut rows);
        }
        let (most, forces, dual) = rows.maximize_first()?;
        let mut row = balance;
        let balanced = self.joints.iter().zip(self.pressures(&forces));
        let joints = balanced
            .enumerate()
            .map(|(number, (joint, [pressure, friction]))| {
                let cone = row + joint.points.len();
                let rubs = joint.friction > 0.0;
                row = cone + if rubs { 4 } else { 0 };
                let given = pressures.map_or(0.0, |pressures| pressures[number]);
                Balanced {
                    pressure: pressure * force_unit,
                    friction: friction * force_unit,
                    cohesion: Self::cohesion(joint, given),
                    worth: if rubs {
                        dual[cone] * load_unit / force_unit
                    } else {
                        0.0
                    },
                }
            });
        let joints = joints.collect();
        let (velocities, _) = dual[..balance].as_chunks::<6>();
        let velocity = |[x, y, z, a, b, c]: &[f64; 6]| {
            [DVec3::new(*x, *y, *z), DVec3::new(*a, *b, *c) / length_unit]
        };
        let endless = most > ENDLESS * self.members.len() as f64;
        Ok(Found {
            most: if endless {
                f64::INFINITY
            } else {
                most * load_unit
            },
            joints,
            velocities: velocities.iter().map(velocity).collect(),
        })
    }

    /// The forces of a joint: what presses at each corner; friction at its middle, along two tangents and about the normal.
    fn add(&self, joint: &Joint, cohesion: f64, slope: f64, rows: &mut Rows) {
        let force_unit = self.units[0];
        let first = rows.wanted.len();
        let cone = first + joint.points.len();
        let rubs = joint.friction > 0.0;
        let mut add = |at: DVec3, force: DVec3, moment: DVec3, own: &[(usize, f64)]| {
            let mut ends = [(joint.ends[0], 1.0), (joint.ends[1], -1.0)];
            // Rows of a column must rise.
            ends.sort_by_key(|(end, _)| *end);
            for (end, sign) in ends {
                if let Some(body) = end {
                    let arm = at - self.members[body].center;
                    rows.add(body, [sign * force, sign * (arm.cross(force) + moment)]);
                }
            }
            own.iter()
                .for_each(|&(row, number)| rows.columns.push(row, number));
            rows.columns.close();
        };
        let [normal, one, other] = joint.frame;
        for (i, &point) in joint.points.iter().enumerate() {
            let own = [(first + i, -1.0), (cone, -slope)];
            let own = if rubs { &own[..] } else { &own[..1] };
            add(point, force_unit * normal, DVec3::ZERO, own);
        }
        if rubs {
            let center = joint.center;
            for (row, tangent) in [(cone + 1, one), (cone + 2, other)] {
                add(center, force_unit * tangent, DVec3::ZERO, &[(row, -1.0)]);
            }
            let twist = force_unit * joint.radius * normal;
            add(center, DVec3::ZERO, twist, &[(cone + 3, -1.0)]);
        }
        rows.wanted.resize(cone, 0.0);
        rows.cones.push(NonnegativeConeT(joint.points.len()));
        if rubs {
            rows.wanted.extend([cohesion, 0.0, 0.0, 0.0]);
            rows.cones.push(SecondOrderConeT(4));
        }
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
            Moving {
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
            ((opens + slides) * share > MOVES * fastest).then_some(Giving {
                between: joint.between,
                how: match slides > opens {
                    true => How::Slides,
                    false => How::Tips,
                },
            })
        });
        Margin {
            most: found.most.max(0.0) as f32,
            moving: moving.collect(),
            gives: gives.collect(),
        }
    }
}

/// A program that is being written.
struct Rows {
    /// What forces and moments are counted in, N and N·m.
    units: [f64; 2],
    columns: Columns,
    wanted: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

impl Rows {
    /// Where force and moment on a body stand in its balance, and how large they are there.
    fn of(&self, body: usize, wrench: [DVec3; 2]) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [force, moment] = [wrench[0] / self.units[0], wrench[1] / self.units[1]];
        let numbers = force.to_array().into_iter().chain(moment.to_array());
        (6 * body..).zip(numbers)
    }

    /// Adds it to the column that is being written.
    fn add(&mut self, body: usize, wrench: [DVec3; 2]) {
        for (row, number) in self.of(body, wrench) {
            self.columns.push(row, number);
        }
    }

    /// The least numbers that fulfil the first so many equations.
    fn least(self, equations: usize) -> Result<Vec<f64>, StabilityError> {
        let count = self.columns.count();
        let matrix = self.columns.into_matrix(self.wanted.len());
        let mut kept = vec![true; equations];
        kept.resize(matrix.m, false);
        let matrix = matrix.select_rows(&kept);
        let squares = CscMatrix::identity(count);
        let cost = vec![0.0; count];
        let cones = [ZeroConeT(equations)];
        let wanted = &self.wanted[..equations];
        let solver = DefaultSolver::new(&squares, &cost, &matrix, wanted, &cones, settings());
        let mut solver = solver.map_err(|_| StabilityError::Unsolved)?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(solver.solution.x),
            // Nothing balances it, so that the cones decide alone.
            _ => Ok(vec![0.0; count]),
        }
    }

    /// The largest first number, which may be infinite; the others then, and the dual variables.
    fn maximize_first(self) -> Result<(f64, Vec<f64>, Vec<f64>), StabilityError> {
        let count = self.columns.count();
        let matrix = self.columns.into_matrix(self.wanted.len());
        let mut cost = vec![0.0; count];
        cost[0] = -1.0;
        let nothing = CscMatrix::zeros((count, count));
        let wanted = &self.wanted;
        let solver = DefaultSolver::new(&nothing, &cost, &matrix, wanted, &self.cones, settings());
        let mut solver = solver.map_err(|_| StabilityError::Unsolved)?;
        solver.solve();
        let solution = solver.solution;
        use SolverStatus as Status;
        let most = match solution.status {
            Status::Solved | Status::AlmostSolved => solution.x[0],
            Status::DualInfeasible | Status::AlmostDualInfeasible => f64::INFINITY,
            Status::PrimalInfeasible | Status::AlmostPrimalInfeasible => {
                return Err(StabilityError::Falls);
            }
            _ => return Err(StabilityError::Unsolved),
        };
        Ok((most, solution.x[1..].to_vec(), solution.z))
    }
}

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        ..Default::default()
    }
}

/// A sparse matrix, column by column.
#[derive(Default)]
struct Columns {
    /// Where each ends.
    ends: Vec<usize>,
    rows: Vec<usize>,
    numbers: Vec<f64>,
}

impl Columns {
    fn push(&mut self, row: usize, number: f64) {
        if number != 0.0 {
            self.rows.push(row);
            self.numbers.push(number);
        }
    }

    /// The column is complete.
    fn close(&mut self) {
        self.ends.push(self.rows.len());
    }

    fn count(&self) -> usize {
        self.ends.len()
    }

    fn into_matrix(self, rows: usize) -> CscMatrix<f64> {
        let columns = self.count();
        let starts = std::iter::once(0).chain(self.ends).collect();
        CscMatrix::new(rows, columns, starts, self.rows, self.numbers)
    }
}
