//! Limit analysis against closed forms.

use support::masonry::drawings::*;
use support::masonry::statics::*;

#[track_caller]
fn near(found: f64, expected: f64, share: f64) {
    println!("found {found}, expected {expected}");
    assert!(
        (found / expected - 1.0).abs() < share,
        "{found} instead of {expected}"
    );
}

/// tan θ = 1/n over the edge, μ down the slope.
#[test]
fn a_column_tips_or_slides() {
    for n in 1..=8 {
        near(limit_tilt(&stack(n, 1.5)), (1.0 / n as f64).atan(), 1e-6);
        near(limit_tilt(&stack(n, 0.1)), 0.1f64.atan(), 1e-6);
    }
}

/// A wedge in a V leaves it along a side, which is a slope of 90° − α and has friction up to φ.
#[test]
fn a_wedge_leaves_its_groove_along_a_side() {
    for (half, friction) in [(30.0, 0.3f64), (45.0, 0.3), (60.0, 0.84)] {
        let limit = 90.0 - half + friction.atan().to_degrees();
        near(
            limit_tilt(&groove(half, friction)).to_degrees(),
            limit,
            1e-6,
        );
    }
}

/// Two blocks of weight G under a wedge of weight W: each side is pushed by W/2 / tan(α + φ) and holds μ (G + W/2).
#[test]
fn a_wedge_parts_two_blocks() {
    let (half, friction) = (20.0f64, 0.3f64);
    let masonry = splitter(half, friction);
    let [block, wedge] = [2, 3].map(|i| masonry.blocks[i].mass());
    let thrust = 0.5 / (half.to_radians() + friction.atan()).tan();
    let limit = friction * block / (thrust - 0.5 * friction);
    near(limit_load(&masonry, 3) * wedge, limit, 1e-6);
}

/// Milankovitch's arch of joints everywhere, t/R 0.1075.
#[test]
fn a_semicircular_arch_has_a_least_thickness() {
    let least = threshold(0.05, 0.2, |share| arch(80, share, 10.0));
    near(least, 0.1075, 0.01);
    // Fewer joints let less thrust lines out.
    let few = threshold(0.05, 0.2, |share| arch(12, share, 10.0));
    assert!(few < least, "{few}");
}

/// Without friction, the joints of a flat arch that point to one centre carry the whole weight above each.
#[test]
fn a_flat_arch_of_joints_to_one_centre_needs_no_friction() {
    assert!(stands(&flat_arch(5, 0.0, None)));
}

/// The keystone sinks and pushes the others out and up: P + w on its two joints, P + W on those of the abutments, one thrust.
#[test]
fn a_load_on_the_crown_drives_the_keystone_in() {
    let (n, friction) = (5, 0.05f64);
    let masonry = flat_arch(n, friction, Some(2));
    let mass = |i: usize| masonry.blocks[i].mass();
    let arch: f64 = (2..2 + n).map(mass).sum();
    let turned = |joint, by: f64| (lean(n, joint).atan() + by).tan();
    let (crown, springer) = (turned(3, friction.atan()), turned(n, -friction.atan()));
    let limit = (arch * crown - mass(4) * springer) / (springer - crown);
    near(limit_load(&masonry, 2 + n) * mass(2 + n), limit, 1e-6);
}
