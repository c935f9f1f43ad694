//! Pseudorandom points that are part of the simulation's bits.

use glam::Vec3;

/// A pseudorandom point of the unit cube for a number, by wyhash: <https://github.com/wangyi-fudan/wyhash>. It is written out here because
/// its results are part of the simulation's bits, which a release of another crate must not change.
pub(crate) fn scattered(number: u64) -> Vec3 {
    const STRIDE: u64 = 0x2d35_8dcc_aa6c_78a5;
    const MIX: u64 = 0x8bb8_4b93_962e_acc9;
    let coordinate = |i: usize| {
        let state = number.wrapping_add(STRIDE.wrapping_mul(i as u64 + 1));
        let product = u128::from(state) * u128::from(state ^ MIX);
        let bits = product as u64 ^ (product >> 64) as u64;
        (bits >> 1) as f32 / (1u64 << 63) as f32
    };
    Vec3::from_array(std::array::from_fn(coordinate))
}
