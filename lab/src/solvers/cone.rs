//! The friction cone of a contact point, K = { (λ_n, λ_t): ‖λ_t‖ ≤ μ λ_n }, and the nearest point of it.

use glam::{Vec2, Vec3};

/// The point of the cone that is nearest to `impulse` = (λ_n, λ_t1, λ_t2), N·s.
///
/// A point inside stays where it is. A point of the polar cone, μ ‖λ_t‖ ≤ −λ_n, goes to the tip. Any other goes to the surface, where
/// λ_n' = (λ_n + μ ‖λ_t‖) / (1 + μ²) and ‖λ_t'‖ = μ λ_n' (Mazhar et al. 2015, section 3).
pub fn project(impulse: Vec3, friction: f32) -> Vec3 {
    let tangential = Vec2::new(impulse.y, impulse.z);
    let (normal, length) = (impulse.x, tangential.length());
    if length <= friction * normal {
        return impulse;
    }
    let lifted = normal + friction * length;
    if lifted <= 0.0 {
        return Vec3::ZERO;
    }
    let normal = lifted / (1.0 + friction * friction);
    let tangential = tangential * (friction * normal / length);
    Vec3::new(normal, tangential.x, tangential.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cone is convex, so the nearest point is the one from which no other point of the cone lies in the direction of the given one.
    #[test]
    fn the_projection_is_the_nearest_point_of_the_cone() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut one = || 2.0 * random.f32() - 1.0;
        for _ in 0..10_000 {
            let friction = one().abs();
            let given = Vec3::new(one(), one(), one());
            let found = project(given, friction);
            let inside = |p: Vec3| p.y.hypot(p.z) <= friction * p.x + 1e-6;
            assert!(inside(found), "{given} {friction} {found}");
            let other = Vec3::new(one().abs(), one(), one());
            if inside(other) {
                let beyond = (given - found).dot(other - found);
                assert!(beyond < 1e-5, "{other} is nearer to {given}: {beyond}");
            }
        }
    }

    #[test]
    fn without_friction_the_cone_is_a_ray() {
        assert_eq!(project(Vec3::new(2.0, 1.0, -1.0), 0.0), Vec3::X * 2.0);
        assert_eq!(project(Vec3::new(-2.0, 1.0, -1.0), 0.0), Vec3::ZERO);
        assert_eq!(project(Vec3::ZERO, 0.0), Vec3::ZERO);
    }
}
