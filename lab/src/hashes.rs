//! Hashes of simulations: the bits of the pose and velocity of every body after every step.

use crate::experiment::Run;
use drystone::body::Velocity;

/// The 64-bit FNV-1a hash of a sequence of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds the bits of a number.
    pub fn add(&mut self, value: f32) {
        for byte in value.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The hash of all numbers so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

/// Takes `steps` steps, and returns the hash of the poses and velocities after each.
pub fn hash(run: &mut Run, steps: usize) -> u64 {
    let mut fnv = Fnv::default();
    for _ in 0..steps {
        run.step();
        for pose in run.poses() {
            let numbers = pose.position.to_array().into_iter();
            numbers
                .chain(pose.rotation.to_array())
                .for_each(|number| fnv.add(number));
        }
        for &body in &run.bodies {
            let velocity = run.world.get::<Velocity>(body).copied().unwrap_or_default();
            let numbers = velocity.linear.to_array().into_iter();
            numbers
                .chain(velocity.angular.to_array())
                .for_each(|number| fnv.add(number));
        }
    }
    fnv.value()
}
