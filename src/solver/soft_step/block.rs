//! Eight patches side by side, each solved in the six coordinates of its own contact.
//!
//! Two bodies meet in a patch with a relative motion u = (u_n, u_1, u_2, Ω_n, Ω_1, Ω_2): velocity at the patch's centre and
//! relative spin, along the normal and two tangents. Every row of the patch is a combination of these: a point at (x, y) from
//! the centre approaches with u_n + y Ω_1 − x Ω_2; friction sees u_1 and u_2; twist sees Ω_n. Impulses act through one wrench
//! (F, T) at the centre and change u by W (F, T), with W = J M⁻¹ Jᵀ a symmetric 6 × 6 matrix. So the bodies are read and
//! written once a visit, whatever the number of points, and a row costs a handful of multiplications.

use super::lanes::{Frame, LANES, Lane, Screw, State, Symmetric, Wide, gather, scatter};
use crate::solver::{Patch, PatchPoint, Problem};

/// What differs from pass to pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// 1/s: of one substep.
    pub rate: Lane,
    /// Fastest correction, m/s.
    pub max_speed: Lane,
    /// Share of the mean load that a soft row does not give back.
    pub preload: Lane,
    /// Speed that a free body gains in a substep, m/s.
    pub fall: Lane,
}

/// How a row gives way: as a damped spring would, solved implicitly (Catto, "Soft Constraints", GDC 2011; Box2D v3).
#[derive(Clone, Copy, Debug, Default)]
struct Softness {
    /// Speed per distance at which errors are taken back, 1/s.
    bias_rate: Lane,
    /// Share of the rigid impulse that a row gives.
    mass_scale: Lane,
    /// Share of its impulse that a row gives back.
    impulse_scale: Lane,
}

/// Faster than this (m/s) a patch is landing, not resting.
const LANDING: f32 = 0.25;

/// How often the points of a patch that lands are visited.
const LANDING_VISITS: usize = 8;

/// The spring that a soft row is where a body has two neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    /// ω, rad/s.
    pub omega: f32,
    /// ζ
    pub damping_ratio: f32,
    /// Length of a substep, s.
    pub h: f32,
}

impl Spring {
    /// Of springs that are softer by a factor.
    #[inline(always)]
    fn softness(&self, stiffness: Lane) -> Softness {
        let omega = Lane::splat(self.omega) * stiffness.sqrt();
        let a = Lane::splat(2.0 * self.damping_ratio) + omega * Lane::splat(self.h);
        let b = omega * Lane::splat(self.h) * a;
        let impulse_scale = (b + Lane::ONE).inverse();
        Softness {
            bias_rate: omega * a.inverse(),
            mass_scale: b * impulse_scale,
            impulse_scale,
        }
    }
}

/// See the module's text.
#[derive(Clone, Debug, Default)]
pub struct Block {
    bodies: [[u32; LANES]; 2],
    normal: Wide,
    tangent: Wide,
    arms: [Wide; 2],
    inverse_inertia: [Symmetric; 2],
    inverse_mass: [Lane; 2],
    friction: Lane,
    /// W over (F_n, T_1, T_2), the coordinates of normals.
    normals: Symmetric,
    /// 1/W of the twist.
    twist_mass: Lane,
    /// What a twist does to u_1 and u_2, and to (u_n, Ω_1, Ω_2).
    twist_to_tangents: [Lane; 2],
    twist_to_normals: Wide,
    /// What the two tangents do to (u_n, Ω_1, Ω_2).
    tangents_to_normals: [Wide; 2],
    /// The inverse of the tangential block: xx, yy, xy; and 1/λ_max of it.
    tangent_mass: [Lane; 3],
    isotropic_mass: Lane,
    /// 1 where friction is anchored.
    anchored: Lane,
    slip: [Lane; 2],
    slip_twist: Lane,
    tangential: [Lane; 2],
    twist: Lane,
    stiffness: Lane,
    softness: Softness,
    first: u32,
    count: u32,
}

/// The points of a block: the i-th of each of its patches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Points {
    x: Lane,
    y: Lane,
    /// √(x² + y²), m.
    radius: Lane,
    /// Distance beyond the ideal when detected, m.
    separation: Lane,
    /// The same in this substep.
    now: Lane,
    /// λ_n, N·s.
    impulse: Lane,
    /// What it carries at rest, N·s.
    load: Lane,
    /// 1/W, kg.
    mass: Lane,
    /// What an impulse does to (u_n, Ω_1, Ω_2).
    effect: Wide,
}

impl Block {
    /// An empty block whose lanes point at `nobody`, a body that nothing moves.
    pub fn new(nobody: u32) -> Self {
        Self {
            bodies: [[nobody; LANES]; 2],
            ..Default::default()
        }
    }

    /// The indices of its points.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Makes room for patches with up to so many points.
    pub fn hold(&mut self, count: u32) {
        self.count = self.count.max(count);
    }

    /// Moves its points behind those of the blocks before it; where they end.
    pub fn place(&mut self, first: u32) -> u32 {
        self.first = first;
        first + self.count
    }

    /// Puts a patch into a lane. Impulses are cut into so many substeps; `stiffness` is what is left of a spring's when its bodies
    /// share it.
    pub fn load(
        &mut self,
        points: &mut [Points],
        lane: usize,
        patch: &Patch,
        problem: &Problem,
        substeps: usize,
        stiffness: f32,
    ) {
        let share = 1.0 / substeps as f32;
        self.stiffness[lane] = stiffness;
        self.normal.set(lane, patch.normal);
        for side in 0..2 {
            let body = &problem.bodies[patch.bodies[side] as usize];
            self.bodies[side][lane] = patch.bodies[side];
            self.arms[side].set(lane, patch.arms[side]);
            self.inverse_mass[side][lane] = body.inverse_mass;
            let (i, to) = (&body.inverse_inertia, &mut self.inverse_inertia[side]);
            to.xx[lane] = i.x_axis.x;
            to.yy[lane] = i.y_axis.y;
            to.zz[lane] = i.z_axis.z;
            to.xy[lane] = i.x_axis.y;
            to.xz[lane] = i.x_axis.z;
            to.yz[lane] = i.y_axis.z;
        }
        self.friction[lane] = patch.friction;
        let (t1, t2) = patch.normal.any_orthonormal_pair();
        self.tangent.set(lane, t1);
        if let Some(slip) = patch.slip {
            self.anchored[lane] = 1.0;
            self.slip[0][lane] = t1.dot(slip.shift);
            self.slip[1][lane] = t2.dot(slip.shift);
            self.slip_twist[lane] = slip.twist;
        }
        self.tangential[0][lane] = t1.dot(patch.tangential) * share;
        self.tangential[1][lane] = t2.dot(patch.tangential) * share;
        self.twist[lane] = patch.twist * share;
        let mine = &problem.points[patch.range()];
        let mean = mine.iter().map(|p| p.load).sum::<f32>() / mine.len() as f32;
        for (to, point) in points.iter_mut().zip(mine) {
            to.load[lane] = mean * share;
            to.x[lane] = t1.dot(point.offset);
            to.y[lane] = t2.dot(point.offset);
            to.separation[lane] = point.separation;
            to.now[lane] = point.separation;
            to.impulse[lane] = point.impulse * share;
            // Marks the lane as used, until `prepare` puts the mass here.
            to.mass[lane] = 1.0;
        }
    }

    /// Takes a patch's impulses out of a lane again.
    pub fn store(
        &self,
        points: &[Points],
        lane: usize,
        patch: &mut Patch,
        patch_points: &mut [PatchPoint],
        substeps: usize,
        rate: f32,
    ) {
        let whole = substeps as f32;
        let t1 = self.tangent.get(lane);
        let t2 = patch.normal.cross(t1);
        patch.tangential = (t1 * self.tangential[0][lane] + t2 * self.tangential[1][lane]) * whole;
        patch.twist = self.twist[lane] * whole;
        for (from, point) in points.iter().zip(patch_points) {
            point.impulse = from.impulse[lane] * whole;
            point.load += rate * (point.impulse - point.load);
        }
    }

    /// How the patch's relative motion answers to a wrench at its centre, world axes.
    #[inline(always)]
    fn respond(&self, force: Wide, torque: Wide) -> Screw {
        let a = self.inverse_inertia[0].apply(torque + self.arms[0].cross(force));
        let b = self.inverse_inertia[1].apply(torque + self.arms[1].cross(force));
        Screw {
            linear: force.scale(self.inverse_mass[0] + self.inverse_mass[1])
                + a.cross(self.arms[0])
                + b.cross(self.arms[1]),
            angular: a + b,
        }
    }

    /// Computes W and the effective masses.
    #[inline(always)]
    pub fn prepare(&mut self, points: &mut [Points], spring: &Spring) {
        self.softness = spring.softness(self.stiffness);
        let frame = self.frame();
        let Frame { n, t1, t2 } = frame;
        let none = Wide::default();
        let along_n = self.respond(n, none);
        let along_1 = self.respond(t1, none);
        let along_2 = self.respond(t2, none);
        let about_n = self.respond(none, n);
        let about_1 = self.respond(none, t1);
        let about_2 = self.respond(none, t2);
        self.normals = Symmetric {
            xx: n.dot(along_n.linear),
            yy: t1.dot(about_1.angular),
            zz: t2.dot(about_2.angular),
            xy: t1.dot(along_n.angular),
            xz: t2.dot(along_n.angular),
            yz: t2.dot(about_1.angular),
        };
        self.twist_mass = n.dot(about_n.angular).inverse();
        self.twist_to_tangents = [t1.dot(about_n.linear), t2.dot(about_n.linear)];
        self.twist_to_normals = on_normals(&frame, about_n);
        self.tangents_to_normals = [on_normals(&frame, along_1), on_normals(&frame, along_2)];
        let (xx, yy) = (t1.dot(along_1.linear), t2.dot(along_2.linear));
        let xy = t1.dot(along_2.linear);
        let determinant = (xx * yy - xy * xy).inverse();
        self.tangent_mass = [yy * determinant, xx * determinant, -xy * determinant];
        let half = Lane::splat(0.5);
        let spread = (half * half * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        self.isotropic_mass = (half * (xx + yy) + spread).inverse();
        for point in points {
            let along = point.direction();
            point.radius = (point.x * point.x + point.y * point.y).sqrt();
            point.effect = self.normals.apply(along);
            point.mass = point.mass * along.dot(point.effect).inverse();
        }
    }

    #[inline(always)]
    fn frame(&self) -> Frame {
        Frame {
            n: self.normal,
            t1: self.tangent,
            t2: self.normal.cross(self.tangent),
        }
    }

    /// Relative motion at the centre in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    #[inline(always)]
    fn relative(&self, frame: &Frame, a: Screw, b: Screw) -> Screw {
        let at_a = a.linear + a.angular.cross(self.arms[0]);
        let at_b = b.linear + b.angular.cross(self.arms[1]);
        Screw {
            linear: frame.local(at_a - at_b),
            angular: frame.local(a.angular - b.angular),
        }
    }

    /// Changes velocities by a wrench in the patch's frame, and writes them back.
    #[inline(always)]
    fn push(&self, frame: &Frame, wrench: Screw, a: Screw, b: Screw, velocities: &mut [State]) {
        let (force, torque) = (frame.world(wrench.linear), frame.world(wrench.angular));
        let turn_a = self.inverse_inertia[0].apply(torque + self.arms[0].cross(force));
        let turn_b = self.inverse_inertia[1].apply(torque + self.arms[1].cross(force));
        let a = Screw {
            linear: a.linear + force.scale(self.inverse_mass[0]),
            angular: a.angular + turn_a,
        };
        let b = Screw {
            linear: b.linear - force.scale(self.inverse_mass[1]),
            angular: b.angular - turn_b,
        };
        scatter(velocities, &self.bodies[0], &a);
        scatter(velocities, &self.bodies[1], &b);
    }

    /// What the free motion misses, J (see [`crate::solver::merit`]).
    #[inline(always)]
    pub fn missing(&self, points: &[Points], velocities: &[State], pass: &Pass) -> Lane {
        let a = gather(velocities, &self.bodies[0]);
        let b = gather(velocities, &self.bodies[1]);
        let normals = on_normals_local(&self.relative(&self.frame(), a, b));
        let mut missing = Lane::ZERO;
        for point in points {
            let bound = -point.separation.max(Lane::ZERO) * pass.rate;
            let lack = (bound - point.direction().dot(normals)).max(Lane::ZERO);
            missing += lack * lack * point.mass;
        }
        missing
    }

    /// Gives the bodies the impulses that the patches start with.
    #[inline(always)]
    pub fn warm_start(&self, points: &[Points], velocities: &mut [State]) {
        let a = gather(velocities, &self.bodies[0]);
        let b = gather(velocities, &self.bodies[1]);
        let mut wrench = Screw {
            linear: Wide {
                x: Lane::ZERO,
                y: self.tangential[0],
                z: self.tangential[1],
            },
            angular: Wide {
                x: self.twist,
                ..Default::default()
            },
        };
        for point in points {
            wrench.linear.x += point.impulse;
            wrench.angular.y += point.y * point.impulse;
            wrench.angular.z -= point.x * point.impulse;
        }
        self.push(&self.frame(), wrench, a, b, velocities);
    }

    /// One projected Gauss–Seidel visit: twist, friction, normals. With `SOFT` rows are springs and take errors back; without
    /// they are rigid and only stop the motion. Σ W Δλ² of the normals, J.
    #[inline(always)]
    pub fn relax<const SOFT: bool>(
        &mut self,
        points: &mut [Points],
        velocities: &mut [State],
        motions: &[State],
        pass: &Pass,
    ) -> Lane {
        let frame = self.frame();
        let a = gather(velocities, &self.bodies[0]);
        let b = gather(velocities, &self.bodies[1]);
        let relative = self.relative(&frame, a, b);
        let moved = if SOFT {
            let a = gather(motions, &self.bodies[0]);
            let b = gather(motions, &self.bodies[1]);
            self.relative(&frame, a, b)
        } else {
            Screw::default()
        };
        let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
        let mut force = Wide::default();
        let mut torque = Wide::default();

        let (mut carried, mut lever) = (zero, zero);
        for point in points.iter() {
            carried += point.impulse;
            lever += point.impulse * point.radius;
        }
        // Anchored friction is soft, any other rigid.
        let (soft, give) = if SOFT {
            (
                one + self.anchored * (self.softness.mass_scale - one),
                self.anchored * self.softness.impulse_scale,
            )
        } else {
            (one, zero)
        };

        let twist_bias = if SOFT {
            self.anchored * -self.softness.bias_rate * (self.slip_twist + moved.angular.x)
        } else {
            zero
        };
        let limit = self.friction * lever;
        let found = self.twist
            - self.twist_mass * soft * (relative.angular.x - twist_bias)
            - give * self.twist;
        let found = found.min(limit).max(-limit);
        torque.x = found - self.twist;
        self.twist = found;
        let mut normals = on_normals_local(&relative) + self.twist_to_normals.scale(torque.x);

        let limit = self.friction * carried;
        let mut residual = [
            relative.linear.y + self.twist_to_tangents[0] * torque.x,
            relative.linear.z + self.twist_to_tangents[1] * torque.x,
        ];
        if SOFT {
            let rate = self.anchored * self.softness.bias_rate;
            let back_1 = rate * (self.slip[0] + moved.linear.y);
            let back_2 = rate * (self.slip[1] + moved.linear.z);
            residual[0] += back_1.min(pass.max_speed).max(-pass.max_speed);
            residual[1] += back_2.min(pass.max_speed).max(-pass.max_speed);
        }
        // The exact step where it stays inside the cone, else an isotropic one, projected (see `rows.rs`).
        let [xx, yy, xy] = self.tangent_mass;
        let keep = one - give;
        let start = [self.tangential[0] * keep, self.tangential[1] * keep];
        let exact = [
            start[0] - soft * (xx * residual[0] + xy * residual[1]),
            start[1] - soft * (xy * residual[0] + yy * residual[1]),
        ];
        let mut found = exact;
        let square = exact[0] * exact[0] + exact[1] * exact[1];
        if square.any_above(limit * limit) {
            let slid = [
                start[0] - soft * self.isotropic_mass * residual[0],
                start[1] - soft * self.isotropic_mass * residual[1],
            ];
            let length = (slid[0] * slid[0] + slid[1] * slid[1]).sqrt();
            let shorten = length.above(limit, limit * length.inverse(), one);
            found = [
                square.above(limit * limit, slid[0] * shorten, exact[0]),
                square.above(limit * limit, slid[1] * shorten, exact[1]),
            ];
        }
        force.y = found[0] - self.tangential[0];
        force.z = found[1] - self.tangential[1];
        self.tangential = found;
        normals = normals
            + self.tangents_to_normals[0].scale(force.y)
            + self.tangents_to_normals[1].scale(force.z);

        let moved_normals = on_normals_local(&moved);
        let mut change = zero;
        // What lands on a face, or still has the impulse of landing, would be turned by the point that is first: all points are
        // stopped together, and then each is visited more than once.
        let lands = normals.x.max(-normals.x).any_above(Lane::splat(LANDING));
        if SOFT && lands {
            let mut all = Wide::default();
            let mut missing = zero;
            for point in points.iter_mut() {
                let along = point.direction();
                let s = point.separation + along.dot(moved_normals);
                let lack = -(along.dot(normals) + s.max(zero) * pass.rate);
                point.now = lack;
                let active = lack.max(point.impulse).above(zero, one, zero)
                    * point.mass.above(zero, one, zero);
                missing += active * lack;
                all = all + along.scale(active);
            }
            let share = missing * all.dot(self.normals.apply(all)).inverse();
            for point in points.iter_mut() {
                let active = point.now.max(point.impulse).above(zero, one, zero)
                    * point.mass.above(zero, one, zero);
                let found = (point.impulse + active * share).max(zero);
                let delta = found - point.impulse;
                point.impulse = found;
                normals = normals + point.effect.scale(delta);
                force.x += delta;
                torque.y += point.y * delta;
                torque.z -= point.x * delta;
            }
        }
        let visits = if lands { LANDING_VISITS } else { 1 };
        for _ in 0..visits {
            for point in points.iter_mut() {
                let along = point.direction();
                let approach = along.dot(normals);
                let step = if SOFT {
                    let s = point.separation + along.dot(moved_normals);
                    point.now = s;
                    let push = (-self.softness.bias_rate * s).min(pass.max_speed);
                    let held = pass.preload
                        * (point.load.min(point.impulse) - point.mass * pass.fall).max(zero);
                    let soft = self.softness.mass_scale * point.mass * (approach - push)
                        + self.softness.impulse_scale * (point.impulse - held);
                    let apart = point.mass * (approach + s * pass.rate);
                    s.above(zero, apart, soft)
                } else {
                    let excess = approach + point.now.max(zero) * pass.rate;
                    point.mass * excess
                };
                let found = (point.impulse - step).max(zero);
                let delta = found - point.impulse;
                point.impulse = found;
                normals = normals + point.effect.scale(delta);
                force.x += delta;
                torque.y += point.y * delta;
                torque.z -= point.x * delta;
                change -= delta * approach;
            }
        }
        let wrench = Screw {
            linear: force,
            angular: torque,
        };
        self.push(&frame, wrench, a, b, velocities);
        change
    }
}

/// What normals see of a motion: (u_n, Ω_1, Ω_2).
#[inline(always)]
fn on_normals_local(motion: &Screw) -> Wide {
    Wide {
        x: motion.linear.x,
        y: motion.angular.y,
        z: motion.angular.z,
    }
}

/// The same of a motion in world axes.
#[inline(always)]
fn on_normals(frame: &Frame, motion: Screw) -> Wide {
    Wide {
        x: frame.n.dot(motion.linear),
        y: frame.t1.dot(motion.angular),
        z: frame.t2.dot(motion.angular),
    }
}

impl Points {
    /// The row of this point over (u_n, Ω_1, Ω_2).
    #[inline(always)]
    fn direction(&self) -> Wide {
        Wide {
            x: Lane::splat(1.0),
            y: self.y,
            z: -self.x,
        }
    }
}
