//! The tilt at which structures on a slope fall, at short and long steps. They are built there, with all their weight at once, or built
//! upright and tipped so slowly that speed does not matter.
//!
//! All have friction enough to tip rather than slide. `cargo run --release --example limits -- tilts` writes where each of them falls.

use drystone::settings::SolverSettings;
use drystone::solver::SoftStep;
use glam::Vec3;
use support::masonry::site::End;
use support::masonry::slope::{FAST, NEAR, SLOW, STEPS, Slope, Structure};
use support::masonry::tables::Tilted;

/// Asserts that all stand short of their limits and fall past them at steps of so many seconds, as they are built there.
#[track_caller]
fn fresh_met(structures: &[Structure], (dt, share): (f32, f64)) {
    met(structures, dt, |structure| {
        [1.0 - share, 1.0 + share].map(|tilt| Slope::new(structure, dt, tilt).end())
    });
}

/// Asserts that all stand short of their limits and fall past them at steps of so many seconds, as they are tipped.
#[track_caller]
fn settled_met(structures: &[Structure], (dt, share): (f32, f64)) {
    met(structures, dt, |structure| {
        let mut slope = Slope::new(structure, dt, 0.0);
        [1.0 - share, 1.0 + share].map(|to| {
            let tipped = slope.turn(to.min(NEAR), FAST) && slope.turn(to, SLOW);
            if tipped { slope.end() } else { End::Falls }
        })
    });
}

#[track_caller]
fn met(structures: &[Structure], dt: f32, ends: impl Fn(&Structure) -> [End; 2]) {
    let mut missed = Vec::new();
    for structure in structures {
        let [short, past] = ends(structure);
        let what = &structure.what;
        let found = format!("{what}, Δt {dt:.4}: {short:?} short of it, {past:?} past it");
        println!("{found}");
        if !(short == End::Stands && past == End::Falls) {
            missed.push(found);
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// How falling is judged, and the closed form: with sweeps enough they agree.
#[test]
fn with_many_sweeps_a_stack_falls_at_its_limit() {
    let structure = Structure::stack(5);
    let ends = [0.98, 1.02].map(|tilt| {
        let mut slope = Slope::new(&structure, 1.0 / 60.0, tilt);
        let world = &mut slope.site.lab.world;
        let solver = SoftStep {
            max_sweeps: 400,
            ..Default::default()
        };
        world.insert_resource(SolverSettings::new(solver));
        slope.end()
    });
    println!("{ends:?}");
    assert_eq!(ends, [End::Stands, End::Falls]);
}

fn stacks() -> Vec<Structure> {
    [3, 5, 8].map(Structure::stack).into()
}

/// The last is that of 10 along.
fn walls() -> Vec<Structure> {
    let both = |courses| {
        [
            Structure::wall_across(courses),
            Structure::wall_along(courses),
        ]
    };
    [6, 10].into_iter().flat_map(both).collect()
}

#[test]
fn stacks_built_on_a_slope_fall_at_their_limits_at_60_hz() {
    fresh_met(&stacks(), STEPS[0]);
}

#[test]
fn stacks_built_on_a_slope_fall_at_their_limits_at_30_hz() {
    fresh_met(&stacks(), STEPS[1]);
}

#[test]
fn stacks_built_on_a_slope_fall_at_their_limits_at_a_tenth_of_a_second() {
    fresh_met(&stacks(), STEPS[2]);
}

#[test]
fn stacks_tipped_slowly_fall_at_their_limits_at_60_hz() {
    settled_met(&stacks(), STEPS[0]);
}

#[test]
fn stacks_tipped_slowly_fall_at_their_limits_at_30_hz() {
    settled_met(&stacks(), STEPS[1]);
}

#[test]
fn stacks_tipped_slowly_fall_at_their_limits_at_a_tenth_of_a_second() {
    settled_met(&stacks(), STEPS[2]);
}

#[test]
fn walls_built_on_a_slope_fall_at_their_limits_at_60_hz() {
    fresh_met(&walls(), STEPS[0]);
}

#[test]
fn walls_built_on_a_slope_fall_at_their_limits_at_30_hz() {
    fresh_met(&walls(), STEPS[1]);
}

#[test]
fn walls_built_on_a_slope_fall_at_their_limits_at_a_tenth_of_a_second() {
    fresh_met(&walls(), STEPS[2]);
}

#[test]
fn walls_tipped_slowly_fall_at_their_limits_at_60_hz() {
    settled_met(&walls()[..3], STEPS[0]);
}

#[test]
fn walls_tipped_slowly_fall_at_their_limits_at_30_hz() {
    settled_met(&walls()[..3], STEPS[1]);
}

#[test]
#[ignore = "missed: falls at 96.5 % of its limit, wanted 97 %; built on the slope at 99.3 %"]
fn a_wall_of_10_along_tipped_slowly_falls_at_its_limit() {
    settled_met(&walls()[3..], STEPS[0]);
    settled_met(&walls()[3..], STEPS[1]);
}

#[test]
fn walls_tipped_slowly_fall_at_their_limits_at_a_tenth_of_a_second() {
    settled_met(&walls(), STEPS[2]);
}

#[test]
fn an_arch_built_on_a_slope_falls_at_its_limit_at_60_hz() {
    fresh_met(&[Structure::arch()], STEPS[0]);
}

#[test]
fn an_arch_built_on_a_slope_falls_at_its_limit_at_30_hz() {
    fresh_met(&[Structure::arch()], STEPS[1]);
}

#[test]
fn an_arch_built_on_a_slope_falls_at_its_limit_at_a_tenth_of_a_second() {
    fresh_met(&[Structure::arch()], STEPS[2]);
}

#[test]
fn an_arch_tipped_slowly_falls_at_its_limit_at_60_hz() {
    settled_met(&[Structure::arch()], STEPS[0]);
}

#[test]
fn an_arch_tipped_slowly_falls_at_its_limit_at_30_hz() {
    settled_met(&[Structure::arch()], STEPS[1]);
}

#[test]
fn an_arch_tipped_slowly_falls_at_its_limit_at_a_tenth_of_a_second() {
    settled_met(&[Structure::arch()], STEPS[2]);
}

/// The share of the limit by which a wall on a table may fall too early or too late.
const TABLE: f64 = 0.03;

/// Asserts that walls on a tilting table fall at the angle of limit analysis. The springs of their joints let them lean and slide before
/// that, so the solver takes four times as many sweeps.
#[track_caller]
fn tables_met(is_in: impl Fn(&Tilted) -> bool) {
    let mut missed = Vec::new();
    for wall in Tilted::all().into_iter().filter(is_in) {
        let mut table = wall.build(1.0 / 60.0, 4.0);
        let stands = [1.0 - TABLE, 1.0 + TABLE].map(|share| table.tilt(share));
        let degrees = table.limit.to_degrees();
        println!("{}, limit {degrees:.2}°: {stands:?}", wall.name());
        if stands != [true, false] {
            missed.push(wall.name());
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// These tip as one, or slide.
fn is_simple(wall: &Tilted) -> bool {
    match wall.towards == Vec3::X {
        true => wall.returns == (wall.leaves == 2),
        false => !wall.returns,
    }
}

#[test]
fn a_single_leaf_on_a_tilting_table_falls_where_limit_analysis_says() {
    tables_met(|wall| is_simple(wall) && wall.leaves == 1);
}

#[test]
#[ignore = "long"]
fn a_double_leaf_on_a_tilting_table_falls_where_limit_analysis_says() {
    tables_met(|wall| is_simple(wall) && wall.leaves == 2);
}

#[test]
#[ignore = "missed: a double leaf in its plane falls at 96.5 %; walls with return walls out of the plane at 96.5 %, as at 1/1920 s; a \
    single leaf with return walls in its plane at 88.5 %, at 1/1920 s at 92.5 %"]
fn walls_that_crack_fall_where_limit_analysis_says() {
    tables_met(|wall| !is_simple(wall));
}
