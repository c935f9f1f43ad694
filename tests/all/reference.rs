//! Compares the simulation with closed-form solutions. Numbers in names are rows of the table of reference values. `docs/accuracy.md` has
//! the same measurements at more steps.
//!
//! Rows with contacts run twice: with [`Lab::exact`], whose solver converges, so that only the errors of the method and of Δt remain, and
//! with [`Lab::shipped`], which has the default solver and its sweeps. The tolerances follow from the step and are the same for both: the
//! error of semi-implicit Euler is the motion of one step, and a threshold can only be found as accurately as motion beyond it differs from
//! rest in the given time.

use glam::Vec3;
use support::accuracy::*;
use support::*;

/// The steps of most tests, s. The default solver is measured at 1/60 s by `accuracy --quick`, which `.ci/run` runs.
const STEPS: [f32; 3] = [0.1, 1.0 / 60.0, 1.0 / 240.0];

/// The steps at which only tests measure the default solver, s.
const COARSE_AND_FINE: [f32; 2] = [0.1, 1.0 / 240.0];

/// For measurements that take long, or miss at other steps: `docs/accuracy.md` has those.
const SIXTIETH: [f32; 1] = [1.0 / 60.0];

/// A measurement as a test at these steps.
macro_rules! test {
    ($row:ident, $measure:ident, $settings:expr, $steps:expr $(, $attribute:meta)?) => {
        #[test]
        $(#[$attribute])?
        fn $row() {
            for dt in $steps {
                println!("steps of {dt} s");
                $measure($settings, dt).assert_met();
            }
        }
    };
}

/// Measurements as tests under both settings of [`Lab`], at the steps of each.
macro_rules! rows {
    ($(
        $row:ident: $measure:ident,
        exact at $exact:expr $(, $of_exact:meta)?;
        shipped at $shipped:expr $(, $of_shipped:meta)?;
    )+) => {
        mod exact {
            use super::*;
            $(test!($row, $measure, Lab::exact, $exact $(, $of_exact)?);)+
        }

        mod shipped {
            use super::*;
            $(test!($row, $measure, Lab::shipped, $shipped $(, $of_shipped)?);)+
        }
    };
}

rows! {
    row_1_a_slab_starts_to_slide_where_the_tangent_of_the_slope_is_the_friction: slides,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_2_a_slab_slides_down_with_g_sin_minus_mu_g_cos: slides_down,
        exact at STEPS;
        shipped at [0.1];
    row_3_a_sliding_slab_stops_after_v_squared_over_two_mu_g: stops,
        exact at [1.0 / 240.0];
        shipped at COARSE_AND_FINE;
    row_4_spheres_and_cylinders_roll_without_slip_while_friction_suffices: rolls,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_4_beyond_the_limit_they_slip: rollers_slip,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_5_a_sliding_sphere_rolls_at_five_sevenths_of_its_speed: slides_into_rolling,
        exact at [1.0 / 480.0];
        shipped at [1.0 / 480.0];
    row_6_a_tower_topples_where_the_tangent_of_the_slope_is_width_over_height: topples,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_7_a_body_pushed_above_half_its_width_over_mu_tips: tips,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_8_three_logs_stand_while_friction_suffices: logs_stand,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_9_four_spheres_stand_while_friction_suffices: spheres_stand,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_12_a_ring_slides_and_spins_until_both_end: ring_slides_and_spins,
        exact at SIXTIETH;
        shipped at SIXTIETH;
    row_12_a_disk_slides_and_spins_until_both_end: disk_slides_and_spins,
        exact at SIXTIETH, ignore = "missed: the pressure of the disk is not uniform, and the ratio of the cylinder does not stay";
        shipped at SIXTIETH, ignore = "missed: the pressure of the disk is not uniform; the cylinder spins half as long as it slides, \
            because a patch limits force and twist apart";
    row_13_a_pure_spin_slows_by_friction_at_its_feet: spin_slows,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_13_the_spin_of_a_disk_slows_as_under_uniform_pressure: disk_spin_slows,
        exact at SIXTIETH, ignore = "missed: 2.67 instead of 2.62 rad/s², as the pressure is not uniform";
        shipped at SIXTIETH, ignore = "missed: 2.21 instead of 2.62 rad/s², as the pressure is not uniform";
    row_14_a_rocking_block_keeps_what_housner_says: rocks,
        exact at SIXTIETH, ignore = "missed: 0.83 instead of 0.91 and 0.98; the far edge is stopped in two steps";
        shipped at SIXTIETH, ignore = "missed: 0.896 instead of 0.912, 0.960 instead of 0.977";
    row_15_a_slab_slips_on_a_jerked_base_as_newmark_says: base_slips,
        exact at [1.0 / 960.0];
        shipped at COARSE_AND_FINE;
    row_16_a_ladder_slips_below_its_angle: ladder_slips,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_17_a_body_bounces_to_e_squared_of_its_height_and_comes_to_rest_in_time: bounces,
        exact at [1e-3];
        shipped at [1e-3];
    row_18_every_interface_carries_the_weight_above_it: stack_carries,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_19_a_free_brick_keeps_momentum_and_energy_while_it_tumbles: tumbles,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_20_a_projectile_flies_a_parabola: flies,
        exact at STEPS;
        shipped at COARSE_AND_FINE;
    row_20_collisions_keep_the_momentum_of_a_closed_group: group_keeps_momentum,
        exact at STEPS;
        shipped at SIXTIETH, ignore = "missed: arms are those of the start of a step, and angular momentum is off by 2.4e-3, wanted 1e-4";
    a_ball_that_grazes_a_wall_loses_speed_by_friction: grazes,
        exact at [1.0 / 960.0];
        shipped at [1.0 / 960.0], ignore = "missed: restitution has no friction, and a ball that arrives late in a step leaves without any";
}

test!(
    row_10_blocks_hang_over_by_half_the_harmonic_number,
    overhangs,
    Lab::exact,
    SIXTIETH
);
test!(
    two_bodies_that_hit_keep_momentum_and_lose_energy_as_newton_says,
    hits,
    Lab::exact,
    SIXTIETH
);

/// The thickness of arches of few and many voussoirs, row 11.
#[test]
fn row_11_an_arch_stands_down_to_the_thickness_of_limit_analysis() {
    arches(Lab::shipped, 1.0 / 60.0, &[9, 21]).assert_met();
}

/// Limit analysis of ever more voussoirs comes to the thicknesses of the formula.
#[test]
fn row_11_limit_analysis_converges_to_the_formula() {
    for (friction, limit) in ARCH_FRICTIONS.into_iter().zip(ARCH_LIMITS) {
        let off = [11, 21, 31].map(|n| {
            let found = arch_by_statics(n, friction, limit).expect("some thickness stands");
            found / limit - 1.0
        });
        println!("μ {friction}: {off:?} of {limit}");
        assert!(off.is_sorted() && off[2].abs() < 0.015, "{off:?}");
    }
}

/// Joints and bonds are for the default solver.
#[test]
fn a_chain_hangs_in_a_catenary() {
    chain_hangs(Lab::shipped, 1.0 / 60.0).assert_met();
}

#[test]
fn a_cantilever_of_mortar_breaks_at_its_length() {
    for dt in STEPS {
        cantilever_breaks(Lab::shipped, dt).assert_met();
    }
}

/// The loss of row 20 under the default solver is that of lever arms that are those of the start of a step, and nothing else.
#[test]
fn a_glancing_hit_loses_at_most_the_moment_of_one_step() {
    for dt in STEPS {
        for i in 0..10 {
            let phase = 0.1 * i as f32 + 0.05;
            let Glance { off, most } = glance(Lab::shipped, dt, phase);
            let exact = glance(Lab::exact, dt, phase).off;
            println!(
                "step {dt} s, phase {phase:.2}: off by {off:.2e}, at most {most:.2e}; NNCG {exact:.1e}"
            );
            assert!(off <= 1.01 * most + 1e-6, "{off} {most}");
            assert!(exact < 1e-5, "{exact}");
        }
    }
}

/// Otherwise a simulation that explodes would meet everything.
#[test]
fn a_value_that_is_off_or_not_a_number_is_missed() {
    let mut values = Values::at(0.1);
    for measured in [f32::NAN, f32::INFINITY, 1.02, 0.98] {
        values.add("off", (measured, 1.0), 0.01);
    }
    values.add("not found", (None, 1.0), 0.01);
    values.add(
        "off by more than a step",
        (1.02, 1.0),
        Tolerance::PerStep(0.1),
    );
    assert!(values.list().iter().all(Value::is_missed));
    let mut values = Values::at(0.1);
    values.add("near", (1.005, 1.0), 0.01);
    values.add(
        "off by less than a step",
        (1.02, 1.0),
        Tolerance::PerStep(0.3),
    );
    values.add_near("near", (-2.01, -2.0), 0.01);
    assert!(!values.list().iter().any(Value::is_missed));
}

#[test]
fn a_cube_that_falls_flat_stays_where_it_lands() {
    for settings in [Lab::exact, Lab::shipped] {
        falls_flat(settings);
    }
}

/// By symmetry. Nothing bounces (e = 0): up to 1 % of the speed with which it came.
fn falls_flat(settings: Settings) {
    for height in [0.1f32, 1.0, 3.0] {
        let mut lab = settings(1.0 / 60.0);
        lab.ground();
        let cube = lab.cube(Vec3::Y * (0.5 + height));
        let (mut up, mut aside) = (0.0f32, 0.0f32);
        for _ in 0..180 {
            lab.step();
            assert!(lab.pose(cube).is_finite() && lab.velocity(cube).is_finite());
            up = up.max(lab.velocity(cube).linear.y);
            aside = aside.max(lab.position(cube).with_y(0.0).length());
        }
        println!("from {height} m: up {up} m/s, {aside} m aside");
        assert!(up < 0.01 * (2.0 * G * height).sqrt(), "{up} m/s up");
        assert!(aside < 1e-3, "{aside} m aside");
    }
}
