//! Impulses that keep everything still: statics, where there is any.
//!
//! Rigid sweeps over closed contacts, a whole step long, in which nothing moves but by its forces. To and fro, since a structure has
//! no preferred way, and then the differences that sweeps make are search directions of a merit function, as in
//! [`Nncg`](crate::solver::Nncg), which has the reasons: an arch of 15 needs a tenth of the sweeps. It begins with loads handed down, and
//! any equilibrium is as good as another; so what stands without friction stays without.

use super::super::Island;
use super::super::block::{Block, Pass, Spring};
use super::super::lanes::Lane;
use crate::solver::PatchProblem;

/// It ends when a sweep makes less than this share of the difference that gravity makes.
const STILL: f32 = 3e-4;

/// Impulses, or changes of them, N·s and N·m·s.
struct Impulses {
    /// Along both tangents and about the normal, by block.
    friction: Vec<[Lane; 3]>,
    normal: Vec<Lane>,
}

impl Impulses {
    fn of(island: &Island) -> Self {
        let friction = |block: &Block| [block.tangential[0], block.tangential[1], block.twist];
        Self {
            friction: island.blocks.iter().map(friction).collect(),
            normal: island.points.iter().map(|point| point.impulse).collect(),
        }
    }

    fn scale(&mut self, share: f32) {
        let friction = self.friction.as_flattened_mut().iter_mut();
        for x in friction.chain(&mut self.normal) {
            *x = Lane::splat(share) * *x;
        }
    }

    /// Each of them and its like among others.
    fn zip<'a>(&'a mut self, others: &'a Self) -> impl Iterator<Item = (&'a mut Lane, Lane)> {
        let friction = self.friction.as_flattened_mut().iter_mut();
        let others_friction = others.friction.as_flattened().iter();
        let friction = friction.zip(others_friction.copied());
        friction.chain(self.normal.iter_mut().zip(others.normal.iter().copied()))
    }

    /// Σ W Δλ², J.
    fn energy(&self, island: &Island) -> f32 {
        let mut sum = Lane::ZERO;
        for (block, [x, y, twist]) in island.blocks.iter().zip(&self.friction) {
            sum += (*x * *x + *y * *y) * block.isotropic_mass.inverse();
            sum += *twist * *twist * block.twist_mass.inverse();
        }
        for (point, change) in island.points.iter().zip(&self.normal) {
            sum += *change * *change * point.mass.inverse();
        }
        sum.sum()
    }
}

/// Changes impulses by what is missing to keep all still, in so many sweeps to and fro at most, and makes them the loads at rest. Points
/// farther apart than `closed` m stay without.
pub fn settle(problem: &mut PatchProblem, closed: f32, most: usize) {
    let (mut island, free) = Island::at_rest(problem, closed);
    let pass = Pass::whole(problem.dt);
    let mut direction: Option<Impulses> = None;
    let mut last = f32::INFINITY;
    for _ in 0..most {
        let before = Impulses::of(&island);
        island.sweep::<false>(&pass);
        island.sweep_back(&pass);
        let mut step = Impulses::of(&island);
        step.zip(&before).for_each(|(now, before)| *now -= before);
        let energy = step.energy(&island);
        if energy <= STILL * STILL * free {
            break;
        }
        let beta = energy / last;
        last = energy;
        // Above 1 it has gone stale, and begins anew.
        if let Some(mut along) = direction.take().filter(|_| beta <= 1.0) {
            along.scale(beta);
            island.add(&along);
            step.zip(&along).for_each(|(x, along)| *x += along);
        }
        direction = Some(step);
    }
    // What was added may have left the cone.
    island.sweep::<false>(&pass);
    island.keep(problem);
}

impl Pass {
    /// All of a step at once.
    fn whole(dt: f32) -> Self {
        Self {
            first: true,
            rate: Lane::splat(1.0 / dt),
            preload: Lane::ZERO,
        }
    }
}

impl Island {
    /// As if everything stood still and touched where it is not open; and what the forces do unopposed, J.
    fn at_rest(problem: &PatchProblem, closed: f32) -> (Self, f32) {
        let mut island = Self::new(problem, 1);
        for (velocity, body) in island.velocities.iter_mut().zip(&*problem.bodies) {
            *velocity = body.push().map(|push| push.extend(0.0));
        }
        let limit = Lane::splat(closed);
        for point in &mut island.points {
            point.mass = point.separation.above(limit, Lane::ZERO, point.mass);
            point.impulse = point.separation.above(limit, Lane::ZERO, point.impulse);
            (point.separation, point.now) = (Lane::ZERO, Lane::ZERO);
        }
        let (pass, spring) = (Pass::whole(problem.dt), Spring::default());
        let mut free = Lane::ZERO;
        for block in &mut island.blocks {
            let points = &mut island.points[block.range()];
            block.prepare(points, &spring);
            free += block.missing(points, &island.velocities, &pass);
        }
        for block in &island.blocks {
            block.warm_start(&island.points[block.range()], &mut island.velocities);
        }
        (island, free.sum())
    }

    /// From the last block to the first.
    fn sweep_back(&mut self, pass: &Pass) {
        for block in self.blocks.iter_mut().rev() {
            let points = &mut self.points[block.range()];
            block.relax::<false>(points, &mut self.velocities, &self.motions, pass);
        }
    }

    fn add(&mut self, change: &Impulses) {
        for (block, friction) in self.blocks.iter_mut().zip(&change.friction) {
            let range = block.range();
            let normal = &change.normal[range.clone()];
            block.add(
                &mut self.points[range],
                *friction,
                normal,
                &mut self.velocities,
            );
        }
    }

    fn keep(&self, problem: &mut PatchProblem) {
        for (patch, &(block, lane)) in problem.patches.iter_mut().zip(&self.batches.places) {
            let (block, lane) = (&self.blocks[block as usize], lane as usize);
            let t1 = block.tangent.get(lane);
            let t2 = patch.normal.cross(t1);
            let [x, y] = block.tangential;
            patch.tangential = t1 * x[lane] + t2 * y[lane];
            patch.twist = block.twist[lane];
            (patch.load_tangential, patch.load_twist) = (patch.tangential, patch.twist);
            let found = &self.points[block.range()];
            for (point, found) in problem.points[patch.range()].iter_mut().zip(found) {
                point.impulse = found.impulse[lane];
                point.load = point.impulse;
            }
        }
    }
}
