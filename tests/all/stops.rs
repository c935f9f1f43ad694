//! A body that slides and stops within a step stays at the point where it stopped, not where the step began.

use drystone::collider::Collider;
use glam::{Quat, Vec3};
use support::*;

/// The distance (m) and the rotation about the vertical (rad) of a slab within two seconds after a blow.
fn after(dt: f32, linear: Vec3, angular: Vec3) -> (f32, f32) {
    let mut lab = Lab::shipped(dt);
    lab.ground();
    let slab = lab.body(Collider::cuboid(0.4, 0.1, 0.4), Vec3::Y * 0.05);
    lab.run(1.0);
    let start = lab.pose(slab);
    lab.set_velocity(slab, linear, angular);
    lab.run(2.0);
    let end = lab.pose(slab);
    let turn: Quat = end.rotation * start.rotation.inverse();
    (
        end.position.distance(start.position),
        turn.to_scaled_axis().y.abs(),
    )
}

/// At 0.4 m/s it takes 80 ms and 16 mm to stop at μ = 0.5.
#[test]
fn a_slab_that_slides_lies_where_it_stopped() {
    let truth = 0.4 * 0.4 / (2.0 * 0.5 * G);
    for dt in [0.1, 1.0 / 30.0, 1.0 / 60.0] {
        for direction in [Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            let (slid, _) = after(dt, 0.4 * direction, Vec3::ZERO);
            println!("Δt {dt:.4}: {:.2} mm of {:.2}", 1e3 * slid, 1e3 * truth);
            assert!(
                (slid / truth - 1.0).abs() < 0.15,
                "Δt {dt}: {slid} m of {truth}"
            );
        }
    }
}

#[test]
fn a_slab_that_turns_lies_as_it_stopped() {
    let spin = 2.0 * Vec3::Y;
    let (_, truth) = after(1.0 / 960.0, Vec3::ZERO, spin);
    for dt in [0.1, 1.0 / 30.0, 1.0 / 60.0] {
        let (_, turned) = after(dt, Vec3::ZERO, spin);
        println!("Δt {dt:.4}: {turned:.4} of {truth:.4}");
        assert!(
            (turned / truth - 1.0).abs() < 0.15,
            "Δt {dt}: {turned} of {truth}"
        );
    }
}
