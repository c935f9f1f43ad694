//! The normal rows of a patch in a visit.

use super::block::{Block, Points, on_normals_local};
use super::kinds::Kinds;
use super::landing::{LANDING_SPEED, Land};
use super::pass::Pass;
use super::visit::{Carried, Visit};
use crate::lanes::{F32xN, SpatialVec, Vec3xN};

/// The held load of a point is at most its load at rest times this times the share of its load that the patch still carries. Where a load
/// is removed at once, the slow mean would throw the body that carried it.
pub const UNLOADED_FACTOR: f32 = 3.0;

/// The springs of a patch's points in one visit.
#[derive(Clone, Copy, Default)]
pub struct Springs<L> {
    /// Motion of the patch since detection, in the coordinates of normals.
    pub moved: Vec3xN<L>,
    pub bias_rate: L,
    /// The fastest correction, as a negative velocity, m/s.
    pub fastest: L,
    pub mass_scale: L,
    pub impulse_scale: L,
    /// The share of its load that the patch still carries, at most 1.
    pub left: L,
    /// Factors of the load that a point holds, and of the part of its load that it has lost; both include `impulse_scale`.
    pub held: L,
    pub preload: L,
    /// Factor from the load of a spring to its reach times its mass, s.
    pub reach: L,
}

impl<L: F32xN> Block<L> {
    /// The springs of the normals. In rigid lanes they do not yield and hold nothing; in idle lanes they have no effect.
    #[inline(always)]
    pub fn springs<K: Kinds<L>>(
        &self,
        kinds: K,
        carried: &Carried<L>,
        moved: &SpatialVec<L>,
        pass: &Pass,
    ) -> Springs<L> {
        let soft = &self.softness;
        let impulse_scale = kinds.given_back(soft.impulse_scale);
        let left = carried.all * self.share * self.inverse_load;
        // The largest share of a load that is held.
        let most = (left * L::splat(UNLOADED_FACTOR)).min(L::ONE);
        Springs {
            moved: on_normals_local(moved),
            bias_rate: soft.bias_rate,
            fastest: -self.max_speed,
            mass_scale: kinds.soft(soft.mass_scale, kinds.if_rigid(L::ONE)),
            impulse_scale,
            left: left.min(L::ONE),
            held: impulse_scale * most,
            preload: impulse_scale * L::splat(pass.preload),
            reach: kinds.if_soft(most * self.gives),
        }
    }
}

/// The normal rows of a patch.
#[derive(Clone, Copy)]
pub struct NormalRows<L, K> {
    pub kinds: K,
    /// The springs of soft lanes.
    pub springs: Springs<L>,
    /// Inverse length of a substep, 1/s.
    pub rate: L,
}

impl<L: F32xN, K: Kinds<L>> NormalRows<L, K> {
    /// Returns (mass, constant). A visit takes mass · approach + constant from the point's impulse.
    #[inline(always)]
    pub fn row(&self, point: &mut Points<L>) -> (L, L) {
        match K::SOFT {
            true => self.spring(point),
            // A rigid row only stops motion, or closes the gap beyond the reach of its spring.
            false => {
                let mass = self.kinds.if_rigid(point.mass);
                (mass, mass * point.gap * self.rate)
            }
        }
    }

    #[inline(always)]
    pub fn spring(&self, point: &mut Points<L>) -> (L, L) {
        let springs = &self.springs;
        let s = point.separation + point.approach(&springs.moved);
        let s = self.kinds.distance(s, point.gap);
        let lost = point
            .rest_impulse
            .mul_sub(springs.left, point.impulse)
            .max(L::ZERO);
        let soft_mass = springs.mass_scale * point.mass;
        let held = springs
            .held
            .neg_mul_add(point.rest_impulse, springs.impulse_scale * point.impulse);
        let held = springs.preload.mul_add(lost, held);
        let closed = soft_mass.mul_add((springs.bias_rate * s).max(springs.fastest), held);
        // The spring with all of its load rests where the surfaces meet, and reaches as far beyond as that load stretches it.
        let (stretch, reach) = (s * point.mass, springs.reach * point.rest_impulse);
        let gap = stretch.select_above(reach, s, L::ZERO);
        point.gap = self.kinds.visited(gap, point.gap);
        (
            stretch.select_above(reach, point.mass, soft_mass),
            stretch.select_above(reach, stretch * self.rate, closed),
        )
    }

    #[inline(always)]
    pub fn relax_normals(&self, points: &mut [Points<L>], mut visit: Visit<L>) -> Visit<L> {
        if K::LANDS {
            // Other lanes must get the result that they would get without this one.
            let u = visit.velocity.linear.x;
            let lands = self.kinds.soft(u.max(-u), L::ZERO);
            let landing = L::splat(LANDING_SPEED);
            if lands.any_above(landing) {
                let lands = lands.select_above(landing, L::ONE, L::ZERO);
                return L::run_rarely(Land {
                    rows: *self,
                    points,
                    visit,
                    lands,
                });
            }
        }
        let mut normals = on_normals_local(&visit.velocity);
        relax_points::<_, _, false>(self, points, &mut normals, &mut visit);
        visit
    }
}

/// Visits the points of a patch one after another, in groups of four. The result for a point does not depend on the number of points in its
/// block.
#[inline(always)]
pub fn relax_points<L: F32xN, K: Kinds<L>, const ON: bool>(
    rows: &NormalRows<L, K>,
    mut points: &mut [Points<L>],
    normals: &mut Vec3xN<L>,
    visit: &mut Visit<L>,
) {
    while points.len() > 4 {
        let (some, others) = points.split_at_mut(4);
        relax_n::<_, _, 4, true>(rows, some, normals, visit);
        points = others;
    }
    match points.len() {
        4 => relax_n::<_, _, 4, ON>(rows, points, normals, visit),
        3 => relax_n::<_, _, 3, ON>(rows, points, normals, visit),
        2 => relax_n::<_, _, 2, ON>(rows, points, normals, visit),
        1 => relax_n::<_, _, 1, ON>(rows, points, normals, visit),
        _ => (),
    }
}

/// Visits N points. Each impulse is passed at once to the wanted impulses of the later points: each then waits for three operations of the
/// one before, instead of seven by way of the patch's motion. This pays in a stack, in which no other work fills the wait. The motion
/// itself is updated only if more visits follow (`ON`).
#[inline(always)]
fn relax_n<L: F32xN, K: Kinds<L>, const N: usize, const ON: bool>(
    rows: &NormalRows<L, K>,
    points: &mut [Points<L>],
    normals: &mut Vec3xN<L>,
    visit: &mut Visit<L>,
) {
    let Ok(points): Result<&mut [Points<L>; N], _> = points.try_into() else {
        unreachable!("the caller passes N points");
    };
    let (mut wanted, mut masses) = ([L::ZERO; N], [L::ZERO; N]);
    let mut approaches = [L::ZERO; N];
    let mut i = 0;
    while i < N {
        let (mass, constant) = rows.row(&mut points[i]);
        approaches[i] = points[i].approach(normals);
        wanted[i] = mass.neg_mul_add(approaches[i], points[i].impulse - constant);
        masses[i] = mass;
        i += 1;
    }
    i = 0;
    while i < N {
        let left = wanted[i].max(L::ZERO);
        let taken = points[i].impulse - left;
        points[i].impulse = left;
        let mut j = i + 1;
        while j < N {
            let seen = points[j].approach(&points[i].effect);
            wanted[j] = (masses[j] * seen).mul_add(taken, wanted[j]);
            approaches[j] = seen.neg_mul_add(taken, approaches[j]);
            j += 1;
        }
        if ON {
            *normals = points[i].effect.scale_neg_add(taken, *normals);
        }
        visit.change = taken.mul_add(approaches[i], visit.change);
        points[i].push(-taken, &mut visit.wrench);
        i += 1;
    }
}

impl<L: F32xN> Points<L> {
    /// Takes from λ_n, which stays ≥ 0, and returns the amount. The amount is the difference of the rounded impulses: differences too small
    /// for λ_n would otherwise act on the bodies alone, and make boxes that bounce straight begin to turn.
    #[inline(always)]
    pub fn take(&mut self, step: L, normals: &mut Vec3xN<L>, wrench: &mut SpatialVec<L>) -> L {
        let left = (self.impulse - step).max(L::ZERO);
        let taken = self.impulse - left;
        self.impulse = left;
        *normals = self.effect.scale_neg_add(taken, *normals);
        self.push(-taken, wrench);
        taken
    }
}
