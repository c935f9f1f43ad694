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
//! load adds to it if all gives way alike, which is least squares. The second is a multiple of λ, and stands in the program as such, c = c₀ + λ d: a round
//! only has to know which joints the load takes all pressure off. The first knows nothing of the load, and most often is enough.

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
    /// How wide the cone is where nothing presses, N: c.
    width: f64,
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

/// What presses on the joints where friction is asked how far it goes, by joint: so much, N, and so much for each one of the load.
#[derive(Clone, Copy)]
struct Pressed {
    now: f64,
    gains: f64,
}

impl Structure {
    /// The largest load, as a multiple, and how it fails then.
    pub fn solve(&self, load: &Load) -> Result<Margin, StabilityError> {
        let live = self.live(load);
        let gains = self.gains(&live)?;
        let still = |now: f64| Pressed { now, gains: 0.0 };
        let now = self.joints.iter().map(|joint| joint.pressure);
        let mut now: Vec<f64> = now.collect();
        let first: Vec<Pressed> = now.iter().copied().map(still).collect();
        let mut found = match self.round(&live, Some(&first)) {
            // What presses now may be that of a blow, or of something that does not stand.
            Err(StabilityError::Falls) => {
                let found = self.round(&live, None)?;
                now = found.joints.iter().map(|joint| joint.pressure).collect();
                found
            }
            found => found?,
        };
        let mut before = Vec::new();
        for _ in 0..ROUNDS {
            if found.most.is_infinite() {
                return Ok(Margin {
                    most: f32::INFINITY,
                    moving: Vec::new(),
                    gives: Vec::new(),
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
            found = match self.round(&live, Some(&pressed)) {
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

    /// By how much one of the load presses more on each joint, if all gave way alike: the least forces that balance it.
    fn gains(&self, live: &[[DVec3; 2]]) -> Result<Vec<f64>, StabilityError> {
        let [force_unit, _] = self.units;
        let load_unit = self.load_unit(live);
        let mut columns = Columns::default();
        for joint in &self.joints {
            for force in joint.forces() {
                self.add(force, 1.0, &mut columns);
                columns.close();
            }
        }
        let wanted: Vec<f64> = live
            .iter()
            .flat_map(|&live| self.counted(live, -load_unit / force_unit))
            .collect();
        let forces = least(columns, &wanted)?;
        let mut forces = forces.iter();
        let share = force_unit / load_unit;
        let pressure = |joint: &Joint| {
            let pressure: f64 = forces.by_ref().take(joint.points.len()).sum();
            let rubs = if joint.friction > 0.0 { 3 } else { 0 };
            forces.by_ref().take(rubs).for_each(drop);
            pressure * share
        };
        Ok(self.joints.iter().map(pressure).collect())
    }

    /// How wide the cone of a joint is where so much presses on it, N: c.
    fn width(joint: &Joint, pressure: f64) -> f64 {
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

    /// A unit of a force of a joint, on both its bodies, times a number.
    fn add(&self, force: Force, times: f64, columns: &mut Columns) {
        let mut ends = [(force.ends[0], times), (force.ends[1], -times)];
        // Rows of a column must rise.
        ends.sort_by_key(|(end, _)| *end);
        for (end, sign) in ends {
            if let Some(body) = end {
                let arm = force.at - self.members[body].center;
                let wrench = [force.force, arm.cross(force.force) + force.moment];
                for (row, number) in (6 * body..).zip(self.counted(wrench, sign)) {
                    columns.push(row, number);
                }
            }
        }
    }

    /// With cones of friction as wide as these pressures make them; sloping as they are where there are none.
    ///
    /// It is the dual program that is handed over, of which the unknowns are velocities and how fast each joint slides:
    ///
    /// min  −w·u + Σ c τ  so that  l·u − Σ d τ = 1,  Gᵀu ≥ μ' τ at each corner,  ‖(Gᵀu)_t‖ ≤ τ for each joint
    ///
    /// with cones as wide as c + λ d. Unknowns and rows together are two thirds of those of the other (32 500 instead of 50 200 for a thousand bricks),
    /// and none of them is there only to be set equal to another, which is where the last steps of the other were lost in rounding.
    fn round(
        &self,
        live: &[[DVec3; 2]],
        pressed: Option<&[Pressed]>,
    ) -> Result<Found, StabilityError> {
        let [force_unit, length_unit] = self.units;
        let load_unit = self.load_unit(live);
        let dead = self
            .members
            .iter()
            .flat_map(|member| self.counted(member.dead, -1.0 / force_unit));
        let mut cost: Vec<f64> = dead.collect();
        let balance = cost.len();
        // Its rows are written as columns.
        let mut rows = Columns::default();
        let power = live
            .iter()
            .flat_map(|&live| self.counted(live, load_unit / force_unit));
        power
            .enumerate()
            .for_each(|(row, number)| rows.push(row, number));
        let mut slopes = Vec::with_capacity(self.joints.len());
        for (number, joint) in self
            .joints
            .iter()
            .enumerate()
            .filter(|(_, joint)| joint.friction > 0.0)
        {
            let pressed = pressed.map(|pressed| pressed[number]);
            let width = |pressure: f64| Self::width(joint, pressure / force_unit);
            let grows = pressed.map_or(0.0, |pressed| width(pressed.gains * load_unit));
            rows.push(cost.len(), -grows);
            cost.push(pressed.map_or(0.0, |pressed| width(pressed.now)));
            slopes.push(joint.friction * if pressed.is_some() { SLOPE } else { 1.0 });
        }
        rows.close();
        let mut cones = vec![ZeroConeT(1)];
        let mut slide = balance;
        for joint in &self.joints {
            let corners = joint.points.len();
            cones.push(NonnegativeConeT(corners));
            for (number, force) in joint.forces().enumerate() {
                if number == corners {
                    rows.push(slide, -1.0);
                    rows.close();
                    cones.push(SecondOrderConeT(4));
                }
                self.add(force, -1.0, &mut rows);
                if number < corners && joint.friction > 0.0 {
                    rows.push(slide, slopes[slide - balance]);
                }
                rows.close();
            }
            if joint.friction > 0.0 {
                slide += 1;
            }
        }
        let Some([unknowns, worth]) = minimize(rows, cost, &cones)? else {
            return Ok(Found {
                most: f64::INFINITY,
                joints: Vec::new(),
                velocities: Vec::new(),
            });
        };
        let most = -worth[0];
        let mut forces = worth[1..].iter();
        let (velocities, slides) = unknowns.split_at(balance);
        let mut slides = slides.iter();
        let joints = self.joints.iter().enumerate().map(|(number, joint)| {
            let corners = forces.by_ref().take(joint.points.len());
            let pressure = corners.sum::<f64>() * force_unit;
            let rubs = joint.friction > 0.0;
            // How wide the cone is, and what it holds.
            let cone = forces.by_ref().take(if rubs { 4 } else { 0 }).skip(1);
            let friction = cone.map(|force| force * force).sum::<f64>().sqrt();
            let slide = slides.by_ref().take(rubs as usize).sum::<f64>();
            let pressed = pressed.map_or(0.0, |pressed| {
                pressed[number].now + most * load_unit * pressed[number].gains
            });
            Balanced {
                pressure,
                friction: friction * force_unit,
                width: Self::width(joint, pressed),
                worth: slide * load_unit / force_unit,
            }
        });
        let joints = joints.collect();
        let (velocities, _) = velocities.as_chunks::<6>();
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

/// A unit of one of the forces of a joint.
struct Force {
    ends: [Option<usize>; 2],
    at: DVec3,
    force: DVec3,
    moment: DVec3,
}

impl Joint {
    /// What presses at each corner; friction at its middle, along two tangents and about the normal.
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

/// The least numbers that fulfil equations.
fn least(equations: Columns, wanted: &[f64]) -> Result<Vec<f64>, StabilityError> {
    let count = equations.count();
    let matrix = equations.into_matrix(wanted.len());
    let squares = CscMatrix::identity(count);
    let cost = vec![0.0; count];
    let cones = [ZeroConeT(wanted.len())];
    let solver = DefaultSolver::new(&squares, &cost, &matrix, wanted, &cones, settings());
    let mut solver = solver.map_err(|_| StabilityError::Unsolved)?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(solver.solution.x),
        // Nothing balances it, so that the cones decide alone.
        _ => Ok(vec![0.0; count]),
    }
}

/// The unknowns of least cost where the first row is 1 and the others are within cones, and what each row is worth. None where nothing fulfils that.
fn minimize(
    rows: Columns,
    cost: Vec<f64>,
    cones: &[SupportedConeT<f64>],
) -> Result<Option<[Vec<f64>; 2]>, StabilityError> {
    let count = rows.count();
    let rows = rows.into_matrix(cost.len());
    let matrix = CscMatrix::from(rows.t());
    let nothing = CscMatrix::zeros((cost.len(), cost.len()));
    let mut wanted = vec![0.0; count];
    wanted[0] = 1.0;
    let solver = DefaultSolver::new(&nothing, &cost, &matrix, &wanted, cones, settings());
    let mut solver = solver.map_err(|_| StabilityError::Unsolved)?;
    solver.solve();
    let solution = solver.solution;
    use SolverStatus as Status;
    match solution.status {
        Status::Solved | Status::AlmostSolved => Ok(Some([solution.x, solution.z])),
        Status::PrimalInfeasible | Status::AlmostPrimalInfeasible => Ok(None),
        Status::DualInfeasible | Status::AlmostDualInfeasible => Err(StabilityError::Falls),
        _ => Err(StabilityError::Unsolved),
    }
}

/// A margin is known to a ten-thousandth; asked for more, the last steps are lost in rounding.
const EXACT: f64 = 1e-6;

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        tol_gap_rel: EXACT,
        tol_gap_abs: EXACT,
        tol_feas: EXACT,
        iterative_refinement_reltol: 1e-2 * EXACT,
        iterative_refinement_abstol: 1e-2 * EXACT,
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
