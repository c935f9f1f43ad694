//! Soft Step.

mod batches;
mod block;
mod cold_start;
mod lanes;

use super::{Body, ContactSolver, Problem, Rows, SolveReport};
use batches::Batches;
use block::{Block, Pass, Points};
use glam::Vec4;
use lanes::{Lane, State};

/// See the module's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftStep {
    /// Damping ratio ζ of soft rows.
    pub damping_ratio: f32,
    /// Sweeps per period of the spring that a soft row is.
    pub sweeps_per_period: f32,
    /// Share of the mean load that soft rows carry without giving way.
    pub preload: f32,
    /// Share of the way by which the mean follows the load in a step.
    pub preload_rate: f32,
}

impl Default for SoftStep {
    fn default() -> Self {
        Self {
            damping_ratio: 10.0,
            sweeps_per_period: 16.0,
            preload: 0.9,
            preload_rate: 0.005,
        }
    }
}

impl ContactSolver for SoftStep {
    fn name(&self) -> &str {
        "soft-step"
    }

    fn rows(&self) -> Rows {
        Rows::Patches
    }

    fn solve(&self, problem: &mut Problem) -> SolveReport {
        let env = |n: &str, d: f32| std::env::var(n).map_or(d, |s| s.parse().unwrap());
        let per: f32 = env("PER", 2.0);
        let substeps = ((problem.iterations as f32 / per) as usize).max(1);
        let env = |n: &str, d: f32| std::env::var(n).map_or(d, |s| s.parse().unwrap());
        let tuned = SoftStep { damping_ratio: env("ZETA", 10.0), sweeps_per_period: env("SPP", 16.0), preload: env("PRELOAD", 0.9), preload_rate: env("RATE", 0.005) };
        let this = &tuned;
        BD.store(env("BD", 0.0) as usize, std::sync::atomic::Ordering::Relaxed);
        DIR.store(env("DIR", 0.0) as usize, std::sync::atomic::Ordering::Relaxed);
        let cold = env("COLD", 1.0) > 0.0 && cold_start::cold_start(problem);
        if cold && env("NOLOAD", 0.0) > 0.0 { for p in problem.patches.iter_mut() { p.load = 0.0; } }
        let mut island = Island::new(problem, substeps);
        island.cold = cold;
        let report = pulp::Arch::new().dispatch(Advance {
            island: &mut island,
            settings: this,
            problem,
            substeps,
        });
        island.store(problem, substeps);
        report
    }
}

/// [`Island::advance`], compiled for each kind of processor.
struct Advance<'a, 'b> {
    island: &'a mut Island,
    settings: &'a SoftStep,
    problem: &'a Problem<'b>,
    substeps: usize,
}

impl pulp::NullaryFnOnce for Advance<'_, '_> {
    type Output = SolveReport;

    #[inline(always)]
    fn call(self) -> SolveReport {
        self.island
            .advance(self.settings, self.problem, self.substeps)
    }
}

static BD: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
static DIR: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
struct Island {
    batches: Batches,
    blocks: Vec<Block>,
    points: Vec<Points>,
    velocities: Vec<State>,
    motions: Vec<State>,
    before: Vec<State>,
    cold: bool,
}

impl Island {
    fn new(problem: &Problem, substeps: usize) -> Self {
        let bodies = &*problem.bodies;
        let nobody = bodies.len() as u32;
        let batches = Batches::new(
            problem.patches.iter().map(|patch| patch.bodies),
            bodies.len(),
            |body| bodies[body as usize].inverse_mass > 0.0,
        );
        if std::env::var_os("DBG").is_some() { eprintln!("patches {} blocks {} size {} {}", problem.patches.len(), batches.blocks, size_of::<Block>(), size_of::<Points>()); }
        let mut blocks = vec![Block::new(nobody, 0); batches.blocks];
        for (patch, &(block, _)) in problem.patches.iter().zip(&batches.places) {
            blocks[block as usize].hold(patch.count);
        }
        let count = blocks
            .iter_mut()
            .fold(0, |first, block| block.place(first));
        let mut points = vec![Points::default(); count as usize];
        let share = 1.0 / substeps as f32;
        for (patch, &(block, lane)) in problem.patches.iter().zip(&batches.places) {
            let block = &mut blocks[block as usize];
            let range = block.range();
            block.load(
                &mut points[range],
                lane as usize,
                patch,
                &problem.points[patch.range()],
                bodies,
                share,
            );
        }
        let state = |body: &Body| {
            let (v, w) = (
                body.linear - body.push[0],
                body.angular - body.push[1],
            );
            [v.extend(0.0), w.extend(0.0)]
        };
        let mut velocities: Vec<State> = bodies.iter().map(state).collect();
        velocities.push(State::default());
        Self {
            batches,
            blocks,
            points,
            motions: vec![State::default(); velocities.len()],
            before: velocities.clone(),
            cold: false,
            velocities,
        }
    }

    #[inline(always)]
    fn advance(&mut self, settings: &SoftStep, problem: &Problem, substeps: usize) -> SolveReport {
        let h = problem.dt / substeps as f32;
        let hz = problem.iterations as f32 / problem.dt / settings.sweeps_per_period;
        let omega = std::f32::consts::TAU * hz;
        let a1 = 2.0 * settings.damping_ratio + h * omega;
        let a2 = h * omega * a1;
        let pass = Pass {
            rate: Lane::splat(1.0 / h),
            bias_rate: Lane::splat(omega / a1),
            mass_scale: Lane::splat(a2 / (1.0 + a2)),
            impulse_scale: Lane::splat(1.0 / (1.0 + a2)),
            max_speed: Lane::splat(problem.max_correction_speed),
            preload: Lane::splat(settings.preload),
            fall: Lane::splat(problem.gravity.length() * h),
        };
        let mut report = SolveReport::default();
        let share = 1.0 / substeps as f32;
        for block in &mut self.blocks {
            block.prepare(&mut self.points[block.range()]);
        }
        // The first substep: forces, then the impulses of the last step.
        for (state, body) in self.velocities.iter_mut().zip(&*problem.bodies) {
            for (velocity, push) in state.iter_mut().zip(body.push) {
                *velocity += (push * share).extend(0.0);
            }
        }
        let mut free = Lane::ZERO;
        for block in &mut self.blocks {
            free += block.warm_start(&self.points[block.range()], &mut self.velocities, &pass);
        }
        let free = free.sum().sqrt();
        if self.cold {
            let n: usize = std::env::var("POLISH").map_or(0, |s| s.parse().unwrap());
            for _ in 0..n {
                for block in &mut self.blocks {
                    let points = &mut self.points[block.range()];
                    block.relax::<false>(points, &mut self.velocities, &self.motions, &pass);
                }
                for block in self.blocks.iter_mut().rev() {
                    let points = &mut self.points[block.range()];
                    block.relax::<false>(points, &mut self.velocities, &self.motions, &pass);
                }
            }
        }
        for substep in 0..substeps {
            if substep > 0 {
                extrapolate(&mut self.velocities, &mut self.before);
            }
            let mut change = Lane::ZERO;
            let bd = BD.load(std::sync::atomic::Ordering::Relaxed);
            if bd == 0 || (bd == 2 && substep % 2 == 0) {
            for block in &mut self.blocks {
                let points = &mut self.points[block.range()];
                change +=
                    block.relax::<true>(points, &mut self.velocities, &self.motions, &pass);
            } } else {
            for block in self.blocks.iter_mut().rev() {
                let points = &mut self.points[block.range()];
                change +=
                    block.relax::<true>(points, &mut self.velocities, &self.motions, &pass);
            } }
            drift(&mut self.motions, &self.velocities, h);
            change = Lane::ZERO;
            let dir = DIR.load(std::sync::atomic::Ordering::Relaxed);
            if dir == 4 { continue; }
            if dir == 0 || (dir == 2 && substep % 2 == 0) {
            for block in self.blocks.iter_mut().rev() {
                let points = &mut self.points[block.range()];
                change +=
                    block.relax::<false>(points, &mut self.velocities, &self.motions, &pass);
            }
            } else {
            for block in self.blocks.iter_mut() {
                let points = &mut self.points[block.range()];
                change +=
                    block.relax::<false>(points, &mut self.velocities, &self.motions, &pass);
            }
            }
            report.sweeps += 2;
            let change = change.sum().sqrt();
            report.residual = if free > 0.0 { change / free } else { 0.0 };
            if problem.record_history {
                report.history.push(report.residual);
            }
        }
        for block in &mut self.blocks {
            let rate = settings.preload_rate;
            block.follow_load(&self.points[block.range()], rate);
        }
        report
    }

    fn store(self, problem: &mut Problem, substeps: usize) {
        let share = 1.0 / substeps as f32;
        for (patch, &(block, lane)) in problem.patches.iter_mut().zip(&self.batches.places) {
            let block = &self.blocks[block as usize];
            let points = &mut problem.points[patch.range()];
            block.store(&self.points[block.range()], lane as usize, patch, points, share);
        }
        let states = self.velocities.iter().zip(&self.motions);
        for (body, (velocity, motion)) in problem.bodies.iter_mut().zip(states) {
            [body.linear, body.angular] = velocity.map(Vec4::truncate);
            body.motion = Some(motion.map(|m| m.truncate() / problem.dt));
        }
    }
}

/// Forces and warm start of a further substep in one: with arms frozen, what they did in the last one they do again.
#[inline(always)]
fn extrapolate(velocities: &mut [State], before: &mut [State]) {
    for (state, before) in velocities.iter_mut().zip(before) {
        let end = *state;
        for i in 0..2 {
            state[i] += end[i] - before[i];
        }
        *before = end;
    }
}

#[inline(always)]
fn drift(motions: &mut [State], velocities: &[State], h: f32) {
    for (motion, state) in motions.iter_mut().zip(velocities) {
        for i in 0..2 {
            motion[i] += h * state[i];
        }
    }
}
