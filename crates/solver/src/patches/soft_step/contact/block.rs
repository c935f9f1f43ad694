//! A block: several patches side by side, each solved in the six coordinates of its own contact.
//!
//! Two bodies meet in a patch with a relative motion u = (u_n, u_1, u_2, Ω_n, Ω_1, Ω_2): velocity at the patch's centre and relative spin,
//! along the normal and two tangents. Every row of the patch is a combination of these: a point at (x, y) from the centre approaches with
//! u_n + y Ω_1 − x Ω_2; friction sees u_1 and u_2; twist sees Ω_n, rolling friction Ω_1 and Ω_2. Impulses act through one wrench (F, T) at
//! the centre and change u by W (F, T), with W = J M⁻¹ Jᵀ a symmetric 6 × 6 matrix. So the bodies are read and written once per visit,
//! whatever the number of points, and a row costs a handful of multiplications.
//!
//! The module [`carry`](super::carry) loads patches into a block and stores them.

use super::locks::{Ease, Locks, PushLocked};
use super::pass::Pass;
use super::spring::{Softness, Spring};
use crate::lanes::{F32xN, Frame, SpatialVec, State, Symmetric, Vec3xN};
use std::cell::Cell;

/// The smallest radius of a point, as a share of the radius of gyration about its normal. A body that is pinched between two points turns
/// about them, and without any friction there it would never come to rest.
const MIN_RADIUS_SHARE: f32 = 0.003;

/// Patches side by side, one in each lane, with the data that their rows need in a visit.
#[derive(Clone, Debug, Default)]
pub struct Block<L: F32xN> {
    pub bodies: [L::Bodies; 2],
    /// Indices to which velocities are written. Bodies that nothing moves get `null_target`, or visits that share one would wait for each
    /// other. A body with rounds ([`Rounds`](crate::rounds::Rounds)) gets a seat of its own.
    pub targets: [L::Bodies; 2],
    pub normal: Vec3xN<L>,
    pub tangent: Vec3xN<L>,
    pub arms: [Vec3xN<L>; 2],
    pub inverse_inertia: [Symmetric<L>; 2],
    pub inverse_mass: [L; 2],
    /// The inverse masses of its bodies along each axis, if some axis of them is locked. Nearly all blocks have none.
    pub locks: Option<Box<Locks<L>>>,
    /// Velocities that friction demands along both tangents, m/s, if a surface moves.
    pub surface: Option<Box<[L; 2]>>,
    pub friction: L,
    /// W over (F_n, T_1, T_2), the coordinates of normals.
    pub normals: Symmetric<L>,
    /// 1/W of the twist.
    pub twist_mass: L,
    /// Response of (u_1, u_2) to a twist, and of (u_n, Ω_1, Ω_2) to it.
    pub twist_to_tangents: [L; 2],
    pub twist_to_normals: Vec3xN<L>,
    /// Response of (u_n, Ω_1, Ω_2) to each tangent.
    pub tangents_to_normals: [Vec3xN<L>; 2],
    /// The inverse of the tangential block of W: xx, yy, xy. Then 1/λ_max of that block.
    pub tangent_mass: [L; 3],
    pub isotropic_mass: L,
    /// Some patches may roll.
    pub rolls: bool,
    /// Factor of λ_n that bounds moments against rolling and spinning, m.
    pub rolling_lever: L,
    /// Rolling radius, m.
    pub rolling_radius: L,
    /// The inverse of W over (T_1, T_2): xx, yy, xy.
    pub rolling_mass: [L; 3],
    /// Moments against rolling, N·m·s.
    pub rolling: [L; 2],
    /// 1 where friction is anchored.
    pub anchored: L,
    /// Slip of the patch since its anchor was set, as detected, less the motion of the anchor since: m, rad.
    pub slip: [L; 2],
    pub slip_twist: L,
    /// Motion of the anchor in this step, m, rad.
    pub dragged: [L; 2],
    pub dragged_twist: L,
    /// Stretch of the springs of friction per impulse, m/(N·s) and rad/(N·m·s).
    pub compliance: L,
    pub compliance_twist: L,
    /// Mean distance of its points from its centre, m.
    pub radius: L,
    /// 1 where points have a finite size, 0 under [spinners](crate::patches::soft_step::spinners).
    pub has_spots: L,
    pub tangential: [L; 2],
    pub twist: L,
    /// Friction impulses of the substeps before this one, summed, N·s.
    pub given: [L; 2],
    /// Impulses of anchored friction and twist at rest, N·s and N·m·s.
    pub held: [L; 2],
    pub held_twist: L,
    /// 1/n for n points.
    pub share: L,
    /// The inverse of the mean impulse at rest of its points, 1/(N·s); 0 if that mean is zero.
    pub inverse_load: L,
    pub stiffness: L,
    /// Fastest correction, m/s.
    pub max_speed: L,
    pub softness: Softness<L>,
    /// Stretch of its springs per velocity (impulse over effective mass), s.
    pub gives: L,
    pub first: u32,
    pub count: u32,
}

/// Points of a block: the i-th point of each of its patches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Points<L> {
    pub x: L,
    pub y: L,
    /// Distance from the centre, m; at least the radius of a point of finite size.
    pub radius: L,
    /// Distance beyond the ideal one, as detected, m.
    pub separation: L,
    /// Separation in this substep where its spring no longer reaches, and 0 where the spring pushes, m.
    pub gap: L,
    /// Normal impulse λ_n, N·s.
    pub impulse: L,
    /// Impulses of the substeps before this one, summed, N·s.
    pub given: L,
    /// Impulse at rest, N·s.
    pub rest_impulse: L,
    /// Effective mass 1/W, kg.
    pub mass: L,
    /// Response of (u_n, Ω_1, Ω_2) to a unit impulse.
    pub effect: Vec3xN<L>,
}

/// Sizes matter, because each sweep reads all blocks and their points. With four points, a patch takes 550 bytes: an island of 5 000
/// patches fits no cache of a core.
const _: () = {
    let lanes = size_of::<crate::lanes::F32x4>();
    assert!(size_of::<Block<crate::lanes::F32x4>>() <= 90 * lanes);
    assert!(size_of::<Points<crate::lanes::F32x4>>() == 12 * lanes);
};

impl<L: F32xN> Block<L> {
    /// An empty block. Its lanes read a body that nothing moves, and write to an entry that nothing reads.
    pub fn new(null_body: u32, null_target: u32) -> Self {
        Self {
            bodies: [L::bodies(null_body); 2],
            targets: [L::bodies(null_target); 2],
            has_spots: L::ONE,
            ..Default::default()
        }
    }

    /// Sets the index to which the velocity of a lane's body is written.
    pub fn write_to(&mut self, lane: usize, side: usize, target: u32) {
        L::set_body(&mut self.targets[side], lane, target);
    }

    /// The range of its points in the island.
    #[inline(always)]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Sets the index of its first point, and the number of points in each lane.
    pub fn place(&mut self, first: usize, count: u32) {
        (self.first, self.count) = (first as u32, count);
    }

    /// Change of the patch's relative motion by a wrench at its centre, in world axes.
    #[inline(always)]
    fn respond(&self, force: Vec3xN<L>, torque: Vec3xN<L>) -> SpatialVec<L> {
        let a = self.inverse_inertia[0].apply(torque + self.arms[0].cross(force));
        let b = self.inverse_inertia[1].apply(torque + self.arms[1].cross(force));
        let mass = self.inverse_mass[0] + self.inverse_mass[1];
        let turned = a.cross(self.arms[0]);
        let linear = match &self.locks {
            None => force.scale_add(mass, turned),
            Some(locks) => locks.respond(force, turned),
        };
        SpatialVec {
            linear: linear + b.cross(self.arms[1]),
            angular: a + b,
        }
    }

    /// Computes W and the effective masses. This must follow after a lane was loaded or a body has turned.
    #[inline(always)]
    pub fn prepare(&mut self, points: &mut [Points<L>]) {
        let frame = self.frame();
        let Frame { n, t1, t2 } = frame;
        let none = Vec3xN::default();
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
        let turned = n.dot(about_n.angular);
        self.twist_mass = turned.inverse();
        self.twist_to_tangents = [t1.dot(about_n.linear), t2.dot(about_n.linear)];
        self.twist_to_normals = on_normals(&frame, about_n);
        self.tangents_to_normals = [on_normals(&frame, along_1), on_normals(&frame, along_2)];
        let (mut xx, mut yy) = (t1.dot(along_1.linear), t2.dot(along_2.linear));
        let xy = t1.dot(along_2.linear);
        let mut ease = Ease::default();
        if self.locks.is_some() {
            ease = Ease::of_locks(&self.inverse_mass, &self.normals);
            (xx, yy) = (xx + ease.linear, yy + ease.linear);
            self.twist_mass = (turned + ease.angular).inverse();
        }
        let determinant = xx.mul_sub(yy, xy * xy).inverse();
        self.tangent_mass = [yy * determinant, xx * determinant, -xy * determinant];
        let half = L::splat(0.5);
        let spread = (half * half * (xx - yy)).mul_add(xx - yy, xy * xy).sqrt();
        self.isotropic_mass = (half * (xx + yy) + spread).inverse();
        if self.rolls {
            let Symmetric { yy, zz, yz, .. } = self.normals;
            let (yy, zz) = (yy + ease.angular, zz + ease.angular);
            let determinant = yy.mul_sub(zz, yz * yz).inverse();
            self.rolling_mass = [zz * determinant, yy * determinant, -yz * determinant];
        }
        self.radius = L::ZERO;
        let spot = self.has_spots
            * L::splat(MIN_RADIUS_SHARE)
            * (self.twist_mass * self.normals.xx).sqrt();
        for point in points {
            let along = point.direction();
            point.radius = point.x.mul_add(point.x, point.y * point.y).sqrt();
            self.radius = self.share.mul_add(point.radius, self.radius);
            point.radius = point.radius.max(spot);
            point.effect = self.normals.apply(along);
            let used = point.mass.select_above(L::ZERO, L::ONE, L::ZERO);
            point.mass = used * (along.dot(point.effect) + ease.linear).inverse();
        }
    }

    /// Sets the softness of its springs, whose frequencies are `omega`, rad/s.
    #[inline(always)]
    pub fn soften(&mut self, spring: &Spring, omega: L) {
        self.softness = spring.softness(omega, self.stiffness);
        let soft = &self.softness;
        self.gives = soft.impulse_scale * (soft.mass_scale * soft.bias_rate).inverse();
        self.compliance = self.anchored * self.gives * self.isotropic_mass.inverse();
        self.compliance_twist = self.anchored * self.gives * self.twist_mass.inverse();
    }

    #[inline(always)]
    pub fn frame(&self) -> Frame<L> {
        Frame::of(self.normal, self.tangent)
    }

    /// Relative motion at the centre in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    #[inline(always)]
    pub fn relative(&self, frame: &Frame<L>, a: SpatialVec<L>, b: SpatialVec<L>) -> SpatialVec<L> {
        let at_a = a.angular.cross_add(self.arms[0], a.linear);
        let at_b = b.angular.cross_add(self.arms[1], b.linear);
        SpatialVec {
            linear: frame.local(at_a - at_b),
            angular: frame.local(a.angular - b.angular),
        }
    }

    /// Changes velocities by a wrench in the patch's frame, and writes them back.
    #[inline(always)]
    pub fn push(
        &self,
        frame: &Frame<L>,
        wrench: SpatialVec<L>,
        a: SpatialVec<L>,
        b: SpatialVec<L>,
        velocities: &[Cell<State>],
    ) {
        let (force, torque) = (frame.world(wrench.linear), frame.world(wrench.angular));
        if let Some(locks) = &self.locks {
            return L::run_rarely(PushLocked {
                locks,
                inverse_inertia: &self.inverse_inertia,
                arms: &self.arms,
                targets: &self.targets,
                force,
                torque,
                motions: [a, b],
                velocities,
            });
        }
        let at_a = self.arms[0].cross_add(force, torque);
        let at_b = self.arms[1].cross_add(force, torque);
        let a = SpatialVec {
            linear: force.scale_add(self.inverse_mass[0], a.linear),
            angular: self.inverse_inertia[0].apply_add(at_a, a.angular),
        };
        let b = SpatialVec {
            linear: force.scale_neg_add(self.inverse_mass[1], b.linear),
            angular: self.inverse_inertia[1].apply_neg_add(at_b, b.angular),
        };
        L::scatter(velocities, &self.targets[0], &a);
        L::scatter(velocities, &self.targets[1], &b);
    }

    /// Merit of the free motion, J (see [`crate::merit`]).
    #[inline(always)]
    pub fn missing(&self, points: &[Points<L>], velocities: &[State], pass: &Pass) -> L {
        let a = L::read(velocities, &self.bodies[0]);
        let b = L::read(velocities, &self.bodies[1]);
        let normals = on_normals_local(&self.relative(&self.frame(), a, b));
        let rate = L::splat(pass.rate);
        let mut missing = L::ZERO;
        for point in points {
            let bound = -point.separation.max(L::ZERO) * rate;
            let lack = (bound - point.approach(&normals)).max(L::ZERO);
            missing = (lack * lack).mul_add(point.mass, missing);
        }
        missing
    }

    /// Applies the warm-start impulses of some lanes to the bodies; `lanes` is 1 in those lanes and 0 in others.
    #[inline(always)]
    pub fn warm_start(&self, points: &[Points<L>], velocities: &[Cell<State>], lanes: L) {
        let [x, y] = self.tangential;
        let friction = [lanes * x, lanes * y, lanes * self.twist];
        let rolling = [lanes * self.rolling[0], lanes * self.rolling[1]];
        let mut wrench = wrench(friction, rolling);
        for point in points {
            point.push(lanes * point.impulse, &mut wrench);
        }
        self.give(wrench, velocities);
    }

    /// Adds to the impulses along both tangents and about the normal, and to those of the points.
    #[inline(always)]
    pub fn add(
        &mut self,
        points: &mut [Points<L>],
        friction: [L; 3],
        normal: &[L],
        velocities: &[Cell<State>],
    ) {
        self.tangential[0] += friction[0];
        self.tangential[1] += friction[1];
        self.twist += friction[2];
        let mut wrench = wrench(friction, [L::ZERO; 2]);
        for (point, &change) in points.iter_mut().zip(normal) {
            point.impulse += change;
            point.push(change, &mut wrench);
        }
        self.give(wrench, velocities);
    }

    /// Changes velocities by a wrench in the patch's frame.
    #[inline(always)]
    pub fn give(&self, wrench: SpatialVec<L>, velocities: &[Cell<State>]) {
        let a = L::gather(velocities, &self.bodies[0]);
        let b = L::gather(velocities, &self.bodies[1]);
        self.push(&self.frame(), wrench, a, b, velocities);
    }
}

/// The wrench of impulses along both tangents and about the normal, and of moments against rolling.
#[inline(always)]
pub fn wrench<L: F32xN>(friction: [L; 3], rolling: [L; 2]) -> SpatialVec<L> {
    SpatialVec {
        linear: Vec3xN {
            x: L::ZERO,
            y: friction[0],
            z: friction[1],
        },
        angular: Vec3xN {
            x: friction[2],
            y: rolling[0],
            z: rolling[1],
        },
    }
}

/// The coordinates of a motion that normals depend on: (u_n, Ω_1, Ω_2).
#[inline(always)]
pub fn on_normals_local<L: F32xN>(motion: &SpatialVec<L>) -> Vec3xN<L> {
    Vec3xN {
        x: motion.linear.x,
        y: motion.angular.y,
        z: motion.angular.z,
    }
}

/// [`on_normals_local`] of a motion in world axes.
#[inline(always)]
fn on_normals<L: F32xN>(frame: &Frame<L>, motion: SpatialVec<L>) -> Vec3xN<L> {
    Vec3xN {
        x: frame.n.dot(motion.linear),
        y: frame.t1.dot(motion.angular),
        z: frame.t2.dot(motion.angular),
    }
}

impl<L: F32xN> Points<L> {
    /// The row of this point over (u_n, Ω_1, Ω_2).
    #[inline(always)]
    pub fn direction(&self) -> Vec3xN<L> {
        Vec3xN {
            x: L::ONE,
            y: self.y,
            z: -self.x,
        }
    }

    /// Velocity at this point along the normal, for a motion (u_n, Ω_1, Ω_2).
    #[inline(always)]
    pub fn approach(&self, normals: &Vec3xN<L>) -> L {
        let tilted = self.y.mul_add(normals.y, normals.x);
        self.x.neg_mul_add(normals.z, tilted)
    }

    /// Adds its impulse to a wrench at the centre. The product is rounded before the sum, on purpose: equal impulses on both sides of the
    /// centre then leave no moment. A fused operation leaves one, by which a box that bounces straight would begin to turn.
    #[inline(always)]
    pub fn push(&self, impulse: L, wrench: &mut SpatialVec<L>) {
        wrench.linear.x += impulse;
        wrench.angular.y += self.y * impulse;
        wrench.angular.z -= self.x * impulse;
    }
}
