//! A sphere that slides into rolling.

use super::Settings;
use drystone::collider::Collider;
use glam::Vec3;

/// A sphere of 5 m/s on a ground of μ 0.5.
pub struct IntoRolling {
    /// Its speed after a second, m/s.
    pub speed: f32,
    /// When and where it begins to roll, s and m.
    pub rolls_at: Option<(f32, f32)>,
}

/// Row 5.
pub fn slide_into_rolling(settings: Settings, dt: f32) -> IntoRolling {
    let mut lab = settings(dt);
    lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 0.5);
    lab.set_velocity(ball, Vec3::X * 5.0, Vec3::ZERO);
    let mut rolls_at = None;
    for i in 1..(1.0 / dt).round() as usize {
        lab.step();
        let v = lab.velocity(ball);
        let slip = v.linear.x + 0.5 * v.angular.z;
        if slip < 1e-3 && rolls_at.is_none() {
            rolls_at = Some((i as f32 * dt, lab.position(ball).x));
        }
    }
    IntoRolling {
        speed: lab.velocity(ball).linear.x,
        rolls_at,
    }
}
