//! A floor of many boxes with few bodies on it.

use crate::scenes::Site;
use drystone::collider::Collider;
use glam::{Quat, Vec3};

/// Edges of a box of the floor, m.
const BOX: Vec3 = Vec3::new(10.0, 0.5, 10.0);

/// Number of balls on a floor of so many boxes.
pub fn balls(n: u32) -> u32 {
    (n / 100).max(10)
}

impl Site<'_> {
    /// Box3D drops a ball every five steps, from 1.5 m. Here each is 0.5 m higher than the one before, up to 10 m.
    pub(super) fn large_world(&mut self, n: u32) {
        let side = (n as f32).sqrt().ceil() as u32;
        let span = BOX.x * side as f32;
        for i in 0..n {
            let cell = Vec3::new((i / side) as f32 + 0.5, 0.0, (i % side) as f32 + 0.5);
            let corner = 0.5 * span * Vec3::new(1.0, 0.0, 1.0);
            self.fixed("floor", BOX, BOX.x * cell - corner);
        }
        let count = balls(n);
        // The inner 80 % of the floor, of which no row is left out.
        let across = (count as f32).sqrt().ceil() as u32;
        let pitch = 0.8 * span * (n / side) as f32 / side as f32 / across as f32;
        for i in 0..count {
            let cell = [i % across, i / across].map(|x| x as f32 - 0.5 * (across - 1) as f32);
            let high = 1.5 + 0.5 * (i % 18) as f32;
            let at = Vec3::new(pitch * cell[0], high, pitch * cell[1]);
            self.put("ball", Collider::ball(0.5), at, Quat::IDENTITY);
        }
    }
}
