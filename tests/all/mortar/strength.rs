//! Bonds break where statics says.

use super::*;
use support::{G, assert_near, bisect};

/// M/W at the root: M = m g n · n l/2, W = b h²/6.
fn root_stress(cubes: usize) -> f32 {
    let n = cubes as f32;
    MASS * G * n * n * EDGE / 2.0 / (EDGE.powi(3) / 6.0)
}

fn holds(lab: &mut Lab, seconds: f32) -> bool {
    for _ in 0..(seconds / lab.dt).round() as usize {
        lab.step();
        if !broken(lab).is_empty() {
            return false;
        }
    }
    true
}

#[test]
fn a_cantilever_breaks_at_its_root_by_its_moment() {
    for dt in STEPS {
        for cubes in [3, 10, 20] {
            let wanted = root_stress(cubes);
            let found = bisect(1.2 * wanted, 0.8 * wanted, 2e-3 * wanted, |strength| {
                let mut lab = Lab::shipped(dt);
                cantilever(&mut lab, cubes, tensile(strength));
                holds(&mut lab, 1.0)
            });
            assert_near(found, wanted, 0.03, &format!("{cubes} cubes, dt {dt}"));
        }
    }
}
