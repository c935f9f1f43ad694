//! Eight patches side by side, each solved in the six coordinates of its own contact.
//!
//! Two bodies meet in a patch with a relative motion u = (u_n, u_1, u_2, Ω_n, Ω_1, Ω_2): velocity at the patch's centre and
//! relative spin, along the normal and two tangents. Every row of the patch is a combination of these: a point at (x, y) from
//! the centre approaches with u_n + y Ω_1 − x Ω_2; friction sees u_1 and u_2; twist sees Ω_n. Impulses act through one wrench
//! (F, T) at the centre and change u by W (F, T), with W = J M⁻¹ Jᵀ a symmetric 6 × 6 matrix. So the bodies are read and
//! written once a visit, whatever the number of points, and a row costs a handful of multiplications.

use super::lanes::{LANES, Lane, Symmetric, Wide};
use crate::solver::{Body, Patch, PatchPoint};
use glam::Vec3;

/// Six numbers of a body: linear, angular, and two of padding so that it is one vector register.
pub type State = [f32; 8];

/// What differs from pass to pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// 1/s: of one substep.
    pub rate: Lane,
    /// Speed per distance at which errors are taken back, 1/s.
    pub bias_rate: Lane,
    /// Share of the rigid impulse that a soft row gives.
    pub mass_scale: Lane,
    /// Share of its impulse that a soft row gives back.
    pub impulse_scale: Lane,
    /// Fastest correction, m/s.
    pub max_speed: Lane,
    /// Share of the mean load that a soft row does not give back.
    pub preload: Lane,
    /// Speed that a free body gains in a substep, m/s.
    pub fall: Lane,
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
    load: Lane,
    first: u32,
    count: u32,
}

/// The points of a block: the i-th of each of its patches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Points {
    x: Lane,
    y: Lane,
    /// Distance beyond the ideal when detected, m.
    separation: Lane,
    /// The same in this substep.
    now: Lane,
    /// λ_n, N·s.
    impulse: Lane,
    /// 1/W, kg.
    mass: Lane,
}

impl Block {
    /// An empty block whose lanes point at `nobody`, a body that nothing moves.
    pub fn new(nobody: u32, first: u32) -> Self {
        Self {
            bodies: [[nobody; LANES]; 2],
            first,
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

    /// Puts a patch into a lane. Impulses are cut into `1/share` substeps.
    pub fn load(
        &mut self,
        points: &mut [Points],
        lane: usize,
        patch: &Patch,
        patch_points: &[PatchPoint],
        bodies: &[Body],
        share: f32,
    ) {
        self.normal.set(lane, patch.normal);
        for side in 0..2 {
            let body = &bodies[patch.bodies[side] as usize];
            self.bodies[side][lane] = patch.bodies[side];
            self.arms[side].set(lane, patch.arms[side]);
            self.inverse_mass[side].0[lane] = body.inverse_mass;
            let (i, to) = (&body.inverse_inertia, &mut self.inverse_inertia[side]);
            to.xx.0[lane] = i.x_axis.x;
            to.yy.0[lane] = i.y_axis.y;
            to.zz.0[lane] = i.z_axis.z;
            to.xy.0[lane] = i.x_axis.y;
            to.xz.0[lane] = i.x_axis.z;
            to.yz.0[lane] = i.y_axis.z;
        }
        self.friction.0[lane] = patch.friction;
        let (t1, t2) = patch.normal.any_orthonormal_pair();
        self.tangent.set(lane, t1);
        if let Some(slip) = patch.slip {
            self.anchored.0[lane] = 1.0;
            self.slip[0].0[lane] = t1.dot(slip.shift);
            self.slip[1].0[lane] = t2.dot(slip.shift);
            self.slip_twist.0[lane] = slip.twist;
        }
        self.tangential[0].0[lane] = t1.dot(patch.tangential) * share;
        self.tangential[1].0[lane] = t2.dot(patch.tangential) * share;
        self.twist.0[lane] = patch.twist * share;
        self.load.0[lane] = patch.load * share;
        for (to, point) in points.iter_mut().zip(patch_points) {
            to.x.0[lane] = t1.dot(point.offset);
            to.y.0[lane] = t2.dot(point.offset);
            to.separation.0[lane] = point.separation;
            to.impulse.0[lane] = point.impulse * share;
            // Marks the lane as used, until `prepare` puts the mass here.
            to.mass.0[lane] = 1.0;
        }
    }

    /// Takes a patch's impulses out of a lane again.
    pub fn store(
        &self,
        points: &[Points],
        lane: usize,
        patch: &mut Patch,
        patch_points: &mut [PatchPoint],
        share: f32,
    ) {
        let whole = 1.0 / share;
        let t1 = self.tangent.get(lane);
        let t2 = patch.normal.cross(t1);
        patch.tangential =
            (t1 * self.tangential[0].0[lane] + t2 * self.tangential[1].0[lane]) * whole;
        patch.twist = self.twist.0[lane] * whole;
        patch.load = self.load.0[lane] * whole;
        for (from, point) in points.iter().zip(patch_points) {
            point.impulse = from.impulse.0[lane] * whole;
        }
    }

    /// Computes W and the effective masses.
    #[inline(always)]
    pub fn prepare(&mut self, points: &mut [Points]) {
        let (n, t1) = (self.normal, self.tangent);
        let t2 = n.cross(t1);
        let respond = |force: Wide, torque: Wide| {
            let mass = self.inverse_mass[0] + self.inverse_mass[1];
            let [alpha, beta] = [0, 1].map(|side| {
                self.inverse_inertia[side].apply(torque + self.arms[side].cross(force))
            });
            let linear = force.scale(mass) + alpha.cross(self.arms[0]) + beta.cross(self.arms[1]);
            (linear, alpha + beta)
        };
        let none = Wide::default();
        let (n_lin, n_ang) = respond(n, none);
        let (f1_lin, f1_ang) = respond(t1, none);
        let (f2_lin, f2_ang) = respond(t2, none);
        let (tn_lin, tn_ang) = respond(none, n);
        let (_, t1_ang) = respond(none, t1);
        let (_, t2_ang) = respond(none, t2);
        self.normals = Symmetric {
            xx: n.dot(n_lin),
            yy: t1.dot(t1_ang),
            zz: t2.dot(t2_ang),
            xy: t1.dot(n_ang),
            xz: t2.dot(n_ang),
            yz: t2.dot(t1_ang),
        };
        let on_normals = |lin: Wide, ang: Wide| Wide {
            x: n.dot(lin),
            y: t1.dot(ang),
            z: t2.dot(ang),
        };
        self.twist_mass = n.dot(tn_ang).inverse();
        self.twist_to_tangents = [t1.dot(tn_lin), t2.dot(tn_lin)];
        self.twist_to_normals = on_normals(tn_lin, tn_ang);
        self.tangents_to_normals = [on_normals(f1_lin, f1_ang), on_normals(f2_lin, f2_ang)];
        let (xx, yy, xy) = (t1.dot(f1_lin), t2.dot(f2_lin), t1.dot(f2_lin));
        let determinant = (xx * yy - xy * xy).inverse();
        self.tangent_mass = [yy * determinant, xx * determinant, -xy * determinant];
        let half = Lane::splat(0.5);
        let spread = (half * half * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        self.isotropic_mass = (half * (xx + yy) + spread).inverse();
        for point in points {
            let along = Wide {
                x: Lane::splat(1.0),
                y: point.y,
                z: -point.x,
            };
            point.mass = point.mass * along.dot(self.normals.apply(along)).inverse();
        }
    }

    #[inline(always)]
    fn frame(&self) -> [Wide; 3] {
        [self.normal, self.tangent, self.normal.cross(self.tangent)]
    }

    /// Relative motion at the centre, (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    #[inline(always)]
    fn relative(&self, [n, t1, t2]: [Wide; 3], [a, b]: [(Wide, Wide); 2]) -> (Wide, Wide) {
        let linear = a.0 + a.1.cross(self.arms[0]) - b.0 - b.1.cross(self.arms[1]);
        let angular = a.1 - b.1;
        let local = |v: Wide| Wide {
            x: n.dot(v),
            y: t1.dot(v),
            z: t2.dot(v),
        };
        (local(linear), local(angular))
    }

    /// Changes velocities by a wrench in the patch's frame, and writes them back.
    #[inline(always)]
    fn push(
        &self,
        [n, t1, t2]: [Wide; 3],
        (force, torque): (Wide, Wide),
        [a, b]: [(Wide, Wide); 2],
        velocities: &mut [State],
    ) {
        let world = |v: Wide| n.scale(v.x) + t1.scale(v.y) + t2.scale(v.z);
        let (force, torque) = (world(force), world(torque));
        let turn = |side: usize| {
            self.inverse_inertia[side].apply(torque + self.arms[side].cross(force))
        };
        let a = (a.0 + force.scale(self.inverse_mass[0]), a.1 + turn(0));
        let b = (b.0 - force.scale(self.inverse_mass[1]), b.1 - turn(1));
        scatter(velocities, &self.bodies[0], a);
        scatter(velocities, &self.bodies[1], b);
    }

    /// Gives the bodies the impulses that the patches start with. Returns what the free motion misses before it, J (see
    /// [`crate::solver::merit`]).
    #[inline(always)]
    pub fn warm_start(&self, points: &[Points], velocities: &mut [State], pass: &Pass) -> Lane {
        let frame = self.frame();
        let ends = self.bodies.each_ref().map(|b| gather(velocities, b));
        let (u, spin) = self.relative(frame, ends);
        let mut force = Wide {
            x: Lane::ZERO,
            y: self.tangential[0],
            z: self.tangential[1],
        };
        let mut torque = Wide {
            x: self.twist,
            ..Default::default()
        };
        let mut missing = Lane::ZERO;
        for point in points {
            let approach = u.x + point.y * spin.y - point.x * spin.z;
            let bound = -point.separation.max(Lane::ZERO) * pass.rate;
            let lack = (bound - approach).max(Lane::ZERO);
            missing += lack * lack * point.mass;
            force.x += point.impulse;
            torque.y += point.y * point.impulse;
            torque.z -= point.x * point.impulse;
        }
        self.push(frame, (force, torque), ends, velocities);
        missing
    }

    /// One projected Gauss–Seidel visit: twist, friction, normals. With `BIASED` rows are soft and take errors back; without
    /// they are rigid and only stop the motion. Returns Σ Δλ²/W⁻¹ of the normals, J.
    #[inline(always)]
    pub fn relax<const BIASED: bool>(
        &mut self,
        points: &mut [Points],
        velocities: &mut [State],
        motions: &[State],
        pass: &Pass,
    ) -> Lane {
        let frame = self.frame();
        let ends = self.bodies.each_ref().map(|b| gather(velocities, b));
        let (mut u, mut spin) = self.relative(frame, ends);
        let (moved, turned) = if BIASED {
            let ends = self.bodies.each_ref().map(|b| gather(motions, b));
            self.relative(frame, ends)
        } else {
            Default::default()
        };
        let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
        let mut force = Wide::default();
        let mut torque = Wide::default();

        let (mut carried, mut lever) = (zero, zero);
        for point in points.iter() {
            carried += point.impulse;
            lever += point.impulse * (point.x * point.x + point.y * point.y).sqrt();
        }
        // Anchored friction is soft, any other rigid.
        let (soft, give) = if BIASED {
            (
                one + self.anchored * (pass.mass_scale - one),
                self.anchored * pass.impulse_scale,
            )
        } else {
            (one, zero)
        };

        let twist_bias = if BIASED {
            self.anchored * -pass.bias_rate * (self.slip_twist + turned.x)
        } else {
            zero
        };
        let limit = self.friction * lever;
        let found = self.twist
            - self.twist_mass * soft * (spin.x - twist_bias)
            - give * self.twist;
        let found = found.min(limit).max(-limit);
        torque.x = found - self.twist;
        self.twist = found;
        u.y += self.twist_to_tangents[0] * torque.x;
        u.z += self.twist_to_tangents[1] * torque.x;
        let mut normals = Wide {
            x: u.x,
            y: spin.y,
            z: spin.z,
        } + self.twist_to_normals.scale(torque.x);
        spin.x = zero;

        let limit = self.friction * carried;
        let residual = if BIASED {
            let bias = |slip: Lane, moved: Lane| {
                let speed = self.anchored * -pass.bias_rate * (slip + moved);
                speed.min(pass.max_speed).max(-pass.max_speed)
            };
            [
                u.y - bias(self.slip[0], moved.y),
                u.z - bias(self.slip[1], moved.z),
            ]
        } else {
            [u.y, u.z]
        };
        // The exact step where it stays inside the cone, else an isotropic one, projected (see `rows.rs`).
        let [xx, yy, xy] = self.tangent_mass;
        let start = self.tangential.map(|t| t - give * t);
        let exact = [
            start[0] - soft * (xx * residual[0] + xy * residual[1]),
            start[1] - soft * (xy * residual[0] + yy * residual[1]),
        ];
        let outside = exact[0] * exact[0] + exact[1] * exact[1] - limit * limit;
        let slid = [0, 1].map(|i| start[i] - soft * self.isotropic_mass * residual[i]);
        let length = (slid[0] * slid[0] + slid[1] * slid[1]).sqrt();
        let shorten = (length - limit).positive(limit * length.inverse(), one);
        let found = [0, 1].map(|i| outside.positive(slid[i] * shorten, exact[i]));
        force.y = found[0] - self.tangential[0];
        force.z = found[1] - self.tangential[1];
        self.tangential = found;
        normals = normals
            + self.tangents_to_normals[0].scale(force.y)
            + self.tangents_to_normals[1].scale(force.z);

        let mut change = zero;
        for point in points {
            let approach = normals.x + point.y * normals.y - point.x * normals.z;
            let step = if BIASED {
                let s = point.separation + moved.x + point.y * turned.y - point.x * turned.z;
                point.now = s;
                let push = (-pass.bias_rate * s).min(pass.max_speed);
                let held = pass.preload
                    * (self.load.min(point.impulse) - point.mass * pass.fall).max(zero);
                let soft = pass.mass_scale * point.mass * (approach - push)
                    + pass.impulse_scale * (point.impulse - held);
                s.positive(point.mass * (approach + s * pass.rate), soft)
            } else {
                point.mass * (approach + point.now.max(zero) * pass.rate)
            };
            let found = (point.impulse - step).max(zero);
            let delta = found - point.impulse;
            point.impulse = found;
            let along = Wide {
                x: delta,
                y: point.y * delta,
                z: -point.x * delta,
            };
            normals = normals + self.normals.apply(along);
            force.x += delta;
            torque.y += along.y;
            torque.z += along.z;
            change += delta * delta * point.mass.inverse();
        }
        self.push(frame, (force, torque), ends, velocities);
        change
    }

    /// Follows the load that the patches carry, one step's share `rate` of the way.
    pub fn follow_load(&mut self, points: &[Points], rate: f32) {
        let mut sum = Lane::ZERO;
        let mut count = Lane::ZERO;
        for point in points {
            sum += point.impulse;
            count += point.mass.map(|m| if m > 0.0 { 1.0 } else { 0.0 });
        }
        let mean = sum * count.inverse();
        self.load += Lane::splat(rate) * (mean - self.load);
    }
}

#[inline(always)]
fn gather(states: &[State], bodies: &[u32; LANES]) -> (Wide, Wide) {
    let (mut linear, mut angular) = (Wide::default(), Wide::default());
    for (lane, &body) in bodies.iter().enumerate() {
        let [x, y, z, p, q, r, ..] = states[body as usize];
        linear.set(lane, Vec3::new(x, y, z));
        angular.set(lane, Vec3::new(p, q, r));
    }
    (linear, angular)
}

#[inline(always)]
fn scatter(states: &mut [State], bodies: &[u32; LANES], (linear, angular): (Wide, Wide)) {
    for (lane, &body) in bodies.iter().enumerate() {
        let (v, w) = (linear.get(lane), angular.get(lane));
        states[body as usize] = [v.x, v.y, v.z, w.x, w.y, w.z, 0.0, 0.0];
    }
}
