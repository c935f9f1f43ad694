//! Normal stabilization, equations (1)–(9) of the paper, and the stage **normal correction**.
//!
//! A contact point demands of its normal velocity v_n ≥ u_collision + c_n. The solver satisfies (1a)–(1c) with that bound: λ_n ≥ 0, and
//! λ_n > 0 only where the bound is reached. With [`NormalStabilization::Envelope`], c_n pushes points below the ideal plane out, and
//! *lets points come down* that are above it but inside the envelope. Every contact settles on the ideal plane, and none flickers.

use crate::body::BodyTable;
use crate::graph::ConstraintGraph;
use crate::pair::{Lists, PairsMut, Part, fit};
use crate::settings::{NormalStabilization, PhysicsThreads, StabilizationSettings, StepTime};
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;

/// The normal velocity after a collision, equation (2b), m/s. `u_n` is the normal velocity before it, without the forces of this step, so
/// that resting bodies do not bounce. Never negative.
pub fn collision_velocity(restitution: f32, u_n: f32) -> f32 {
    -restitution * u_n.min(0.0)
}

/// The normal velocity that moves a point from the distance `d` to `ideal` (m) within `dt` (s), equation (5), m/s.
pub fn correction_velocity(ideal: f32, d: f32, dt: f32) -> f32 {
    (ideal - d) / dt
}

/// The lower bound of a contact point's normal velocity, u_collision + c_n, m/s.
///
/// `d` is the signed distance of the surfaces, m; `u_n` the normal velocity before forces, m/s; `dt` the length of the step, s.
pub fn normal_target(
    settings: &StabilizationSettings,
    restitution: f32,
    d: f32,
    u_n: f32,
    dt: f32,
) -> f32 {
    let u_collision = collision_velocity(restitution, u_n);
    let u_correction = correction_velocity(settings.rest_distance(), d, dt);
    // A bounce happens where the surfaces meet. Bodies that would arrive within the step bounce now, or the speed to bounce with
    // would be lost; what would not may come on, or the envelope would brake it first.
    if u_collision > 0.0 && u_correction < 0.0 {
        return if u_n < u_correction {
            u_collision
        } else {
            u_correction
        };
    }
    if d > settings.outer_distance() {
        // Outside the envelope: a speculative row keeps fast bodies from jumping through it. It is not clamped.
        return u_correction;
    }
    let clamp = settings.max_correction_speed;
    let c_n = match settings.normal {
        NormalStabilization::None => 0.0,
        // (9)
        NormalStabilization::Baumgarte { gain } => -gain * d / dt,
        NormalStabilization::BaumgarteOneSided { gain } if d < 0.0 => {
            // Only what the bounce does not do already.
            (-gain * d / dt - u_collision).max(0.0)
        }
        NormalStabilization::BaumgarteOneSided { .. } => 0.0,
        NormalStabilization::Envelope => {
            if leaves_envelope(settings, d, u_n, u_collision, dt) {
                0.0
            } else if u_correction >= 0.0 {
                // (8a)
                (u_correction - u_collision).max(0.0)
            } else {
                // (8b)
                u_correction
            }
        }
    };
    u_collision + c_n.clamp(-clamp, clamp)
}

/// Returns true if a contact leaves the envelope by itself within the step, equation (7). It is not corrected then.
///
/// As printed, (7) compares u_correction with its own definition and can never hold. The comparison here is with the outer boundary of
/// the envelope, at the velocity that the point has anyway.
pub fn leaves_envelope(
    settings: &StabilizationSettings,
    d: f32,
    u_n: f32,
    u_collision: f32,
    dt: f32,
) -> bool {
    u_n.max(u_collision) > (settings.outer_distance() - d) / dt
}

/// Writes the normal velocities that contact points must reach to the [`ContactTargets`](crate::contact::ContactTargets) of all pairs.
pub fn normal_correction(
    table: Res<BodyTable>,
    (graph, places): (Res<ConstraintGraph>, &Entities),
    time: Res<StepTime>,
    settings: Res<StabilizationSettings>,
    threads: Res<PhysicsThreads>,
    mut pairs: PairsMut,
) {
    let (table, settings, dt) = (&*table, &*settings, time.dt);
    let (rest, share) = (settings.rest_distance(), dt / time.max_recent_dt);
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let (pairs, _, manifolds, _, _, mut targets) = columns.part(rows);
            let columns = (&*pairs, &*manifolds, targets.bypass_change_detection());
            threads.each(columns, |(pair, manifold, targets)| {
                let Some([a, b]) = table.both(pair.slots) else {
                    return;
                };
                let lists = Lists {
                    targets: Some((&mut *targets, true)),
                    ..Default::default()
                };
                fit(manifold, lists);
                for patch in &manifold.patches {
                    let range = manifold.range(patch);
                    let points = &manifold.points[range.clone()];
                    let targets = &mut targets.points[range];
                    let restitution = pair.surface(patch, table).restitution;
                    for (point, target) in points.iter().zip(targets) {
                        let position = a.center + point.arm;
                        let u = a.velocity_at(position) - b.velocity_at(position);
                        let u_n = u.dot(patch.normal);
                        // The share of the overlap that is taken back in this step.
                        let d = point.distance.max(rest + share * (point.distance - rest));
                        target.normal = normal_target(settings, restitution, d, u_n, dt);
                    }
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    const DT: f32 = 0.1;

    fn paper() -> StabilizationSettings {
        Preset::Paper.stabilization()
    }

    #[test]
    fn a_resting_point_is_led_to_the_ideal_plane_from_both_sides() {
        let settings = paper();
        let half = 0.03125;
        // (8a) below the plane: out; (8b) above it, inside the envelope: come down; on it: stay.
        assert!((normal_target(&settings, 0.0, 0.01, 0.0, DT) - (half - 0.01) / DT).abs() < 1e-6);
        assert!((normal_target(&settings, 0.0, 0.05, 0.0, DT) - (half - 0.05) / DT).abs() < 1e-6);
        assert_eq!(normal_target(&settings, 0.0, half, 0.0, DT), 0.0);
    }

    #[test]
    fn corrections_are_clamped_but_speculative_rows_are_not() {
        let settings = paper();
        assert_eq!(normal_target(&settings, 0.0, -1.0, 0.0, DT), 2.0);
        let far = normal_target(&settings, 0.0, 1.0, -20.0, DT);
        assert!((far - (0.03125 - 1.0) / DT).abs() < 1e-5);
    }

    #[test]
    fn equation_7_spares_what_leaves_the_envelope_by_itself() {
        let settings = paper();
        // At d = 0.05 the envelope's edge is 0.0125 m away: leaving takes more than 0.125 m/s.
        assert_eq!(normal_target(&settings, 0.0, 0.05, 0.2, DT), 0.0);
        assert!(normal_target(&settings, 0.0, 0.05, 0.1, DT) < 0.0);
        // The other reading, against the ideal plane, would spare this one too and let stacks fall.
        let slowly = 0.01;
        assert!(slowly > correction_velocity(0.03125, 0.05, DT));
        assert!(normal_target(&settings, 0.0, 0.05, slowly, DT) < 0.0);
        // A bounce counts as leaving too.
        assert!(leaves_envelope(
            &settings,
            0.02,
            -3.0,
            collision_velocity(0.5, -3.0),
            DT
        ));
    }

    #[test]
    fn restitution_asks_for_no_more_than_the_greater_of_bounce_and_correction() {
        let settings = paper();
        // (8a): correction 0.2125 m/s, bounce 0.05 m/s: together 0.2125.
        let both = normal_target(&settings, 0.5, 0.01, -0.1, DT);
        assert!((both - 0.2125).abs() < 1e-6);
        assert_eq!(collision_velocity(0.5, 3.0), 0.0);
    }

    #[test]
    fn a_bounce_loses_nothing_to_the_envelope() {
        let settings = paper();
        // At 1 kHz it takes many steps to fall through the envelope: nothing brakes before the surfaces meet.
        let (d, dt) = (0.05, 1e-3);
        assert!(normal_target(&settings, 0.5, d, -3.0, dt) <= -3.0);
        assert_eq!(normal_target(&settings, 0.5, 0.0313, -3.0, dt), 1.5);
        // And what bounces without arriving would do so in the air.
        assert!(normal_target(&settings, 0.5, 0.0624, -3.0, dt) <= -3.0);
    }

    #[test]
    fn baumgarte_is_equation_9_on_one_or_both_sides() {
        let mut settings = paper();
        settings.normal = NormalStabilization::Baumgarte { gain: 0.5 };
        assert!((normal_target(&settings, 0.0, -0.01, 0.0, DT) - 0.05).abs() < 1e-7);
        assert!((normal_target(&settings, 0.0, 0.01, 0.0, DT) + 0.05).abs() < 1e-7);
        settings.normal = NormalStabilization::BaumgarteOneSided { gain: 0.5 };
        assert!((normal_target(&settings, 0.0, -0.01, 0.0, DT) - 0.05).abs() < 1e-7);
        assert_eq!(normal_target(&settings, 0.0, 0.01, 0.0, DT), 0.0);
    }
}
