//! Rolling friction of a patch in a visit.

use super::block::Block;
use super::friction::shorten;
use super::kinds::Kinds;
use super::visit::{Carried, Visit};
use crate::lanes::{F32xN, Kernel, Vec3xN, square_length};

/// Rolling and slipping slower than this (m/s) count as creep.
const CREEP_SPEED: f32 = 0.1;

/// Stops creep: relaxes Ω_1 and Ω_2 together, within the limit of the current normal impulses. The limit decreases with speed.
pub struct Roll<'a, L: F32xN, K> {
    pub block: &'a mut Block<L>,
    pub kinds: K,
    pub carried: Carried<L>,
    pub visit: Visit<L>,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Roll<'_, L, K> {
    type Output = Visit<L>;

    #[inline(always)]
    fn run(self) -> Visit<L> {
        let Self {
            block,
            kinds,
            carried,
            mut visit,
        } = self;
        let spin = [visit.velocity.angular.y, visit.velocity.angular.z];
        let slip = [visit.velocity.linear.y, visit.velocity.linear.z];
        let rolling = block.rolling_radius * block.rolling_radius;
        let square = rolling.mul_add(square_length(spin), square_length(slip));
        let fast = square.mul_add(L::splat(1.0 / (CREEP_SPEED * CREEP_SPEED)), L::ONE);
        let limit = block.rolling_lever * carried.all * (fast * fast).inverse();
        let [xx, yy, xy] = block.rolling_mass;
        let exact = [
            block.rolling[0] - xx.mul_add(spin[0], xy * spin[1]),
            block.rolling[1] - xy.mul_add(spin[0], yy * spin[1]),
        ];
        let found = shorten(exact, limit);
        let [x, y] = block.rolling;
        block.rolling = [
            kinds.soft(found[0], kinds.rigid(found[0], x)),
            kinds.soft(found[1], kinds.rigid(found[1], y)),
        ];
        let change = [block.rolling[0] - x, block.rolling[1] - y];

        visit.wrench.angular.y += change[0];
        visit.wrench.angular.z += change[1];
        let seen = block.normals.apply(Vec3xN {
            x: L::ZERO,
            y: change[0],
            z: change[1],
        });
        visit.velocity.linear.x += seen.x;
        visit.velocity.angular.y += seen.y;
        visit.velocity.angular.z += seen.z;
        visit
    }
}
