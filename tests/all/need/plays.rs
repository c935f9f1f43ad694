//! Random plays, by need and awake: the same bricks fall, and what stands is where it is awake.
//!
//! `cargo test --release --test all need::plays:: -- --ignored --nocapture` plays two hundred times.

use super::*;
use drystone::body::{ExternalForce, ExternalImpulse};
use fastrand::Rng;

/// A brick has fallen if it is so far from where it was, m.
const FALLEN: f32 = 0.25;

/// The end of a play.
struct End {
    /// Positions of the bricks of the scene; `None` if they were taken.
    places: Vec<Option<Vec3>>,
    fallen: Vec<usize>,
    /// How far a brick moves when all are woken, m.
    woken: f32,
}

fn play(scene: &str, seed: u64, mode: Mode, dt: f32) -> End {
    let mut site = Site::of(scene, mode, dt);
    let before = site.places();
    let mut rng = Rng::with_seed(seed);
    let mut laid = Vec::new();
    for _ in 0..8 {
        let alive: Vec<usize> = (0..site.bricks.len())
            .filter(|&i| site.lab.world.get_entity(site.bricks[i]).is_ok())
            .collect();
        let brick = alive[rng.usize(0..alive.len())];
        let upper = alive[rng.usize(2 * alive.len() / 3..alive.len())];
        let at = before[brick].expect("it was there");
        let angle = rng.f32() * std::f32::consts::TAU;
        let aside = Vec3::new(angle.cos(), 0.0, angle.sin());
        let strength = rng.f32();
        let kind = rng.u8(0..5);
        match kind {
            0 => {
                // On a brick of the highest course, if nothing has been laid there yet.
                let height = before.iter().flatten().map(|at| at.y).fold(0.0, f32::max);
                let is_top = |&&i: &&usize| before[i].is_some_and(|at| at.y > height - 0.1);
                let top = alive
                    .iter()
                    .filter(is_top)
                    .map(|&i| before[i].expect("it was there"));
                let free =
                    top.filter(|at| laid.iter().all(|other: &Vec3| other.distance(*at) > 1.1));
                let free: Vec<Vec3> = free.collect();
                if !free.is_empty() {
                    let at = free[rng.usize(0..free.len())];
                    laid.push(at);
                    site.lay(at + Vec3::Y * 0.5);
                }
            }
            1 => _ = site.lab.world.despawn(site.bricks[upper]),
            2 => {
                let push = ExternalImpulse {
                    linear: 100.0 * strength * aside,
                    ..Default::default()
                };
                site.lab.world.entity_mut(site.bricks[brick]).insert(push);
            }
            3 => {
                let from = at + Vec3::new(0.0, 0.2, 2.0);
                site.throw(0.1, from, Vec3::new(0.0, 0.0, -10.0 * strength));
            }
            _ => {
                let body = site.bricks[upper];
                let force = 0.4 * strength * G * site.lab.mass(body).mass() * aside;
                site.push(body, force);
                site.lab.run(0.5);
                site.lab.world.entity_mut(body).remove::<ExternalForce>();
            }
        }
        site.lab.run(0.5);
    }
    site.lab.run(2.0);
    let places = site.places();
    let off = |i: usize| before[i].zip(places[i]).map(|(a, b)| a.distance(b));
    let fallen = (0..before.len()).filter(|&i| off(i).is_some_and(|off| off > FALLEN));
    let fallen: Vec<usize> = fallen.collect();
    // What has fallen may still roll.
    for &i in fallen.iter().rev() {
        site.bricks.remove(i);
    }
    End {
        fallen,
        woken: site.all_woken(),
        places,
    }
}

/// Walls and pyramids, and structures that collapse in another way after each rounding error.
const SOLID: [&str; 3] = ["wall:12x10", "wall:20x8", "pyramid:8"];
const ALL: [&str; 6] = [
    "wall:12x10",
    "wall:20x8",
    "pyramid:8",
    "arch:15",
    "tower:6",
    "cardhouse:3",
];

/// Plays with these seeds, and counts the plays in which other bricks fall than awake, those in which a brick ends more than a millimetre
/// elsewhere though none falls, and those in which a brick that stands moves by more than a millimetre when all are woken.
fn compare(scenes: &[&str], seeds: std::ops::Range<u64>, mode: Mode) -> [usize; 3] {
    let mut missed = [0; 3];
    for seed in seeds {
        let scene = scenes[seed as usize % scenes.len()];
        let dt = if seed % 4 == 3 { 0.1 } else { 1.0 / 60.0 };
        let [awake, need] = [Mode::Awake, mode].map(|mode| play(scene, seed, mode, dt));
        let pairs = awake.places.iter().zip(&need.places);
        let stands = |i: &usize| !awake.fallen.contains(i);
        let off = pairs.enumerate().filter(|(i, _)| stands(i));
        let off = off.filter_map(|(_, (a, b))| Some(a.as_ref()?.distance(*b.as_ref()?)));
        let off = off.fold(0.0, f32::max);
        let same = awake.fallen == need.fallen;
        let is_off = same && awake.fallen.is_empty() && off > 1e-3;
        let is_loose = need.woken > 1e-3 && awake.woken < 1e-3;
        println!(
            "{scene}, seed {seed}, Δt {dt:.3}: fallen {} and {}{}, off by {:.2} mm, woken {:.2} and {:.2} mm",
            awake.fallen.len(),
            need.fallen.len(),
            if same { "" } else { " (others)" },
            1e3 * off,
            1e3 * awake.woken,
            1e3 * need.woken,
        );
        missed[0] += usize::from(!same);
        missed[1] += usize::from(is_off);
        missed[2] += usize::from(is_loose);
    }
    missed
}

/// Rounding decides what a brick does that is about to fall: of a hundred plays, four to six miss.
#[test]
fn plays_by_need_end_as_they_do_awake() {
    let missed = compare(&SOLID, 0..24, Mode::Need);
    assert!(missed.into_iter().sum::<usize>() <= 3, "{missed:?}");
}

/// Rounding decides how an arch and a house of cards collapse, so that whole islands that sleep and wake miss, too.
#[test]
#[ignore = "long"]
fn two_hundred_plays_end_as_they_do_awake() {
    let islands = compare(&ALL, 0..200, Mode::Islands);
    let need = compare(&ALL, 0..200, Mode::Need);
    println!("by islands {islands:?}, by need {need:?}");
    assert!(need[2] <= islands[2]);
    assert!(need[0] <= 25 && need[1] <= 25, "{need:?}");
}

/// A castle has a door on a hinge and a keep in mortar.
const VAULTED: [&str; 2] = ["dome:4", "castle:5"];

#[test]
#[ignore = "long"]
fn castles_and_domes_end_as_they_do_awake() {
    let islands = compare(&VAULTED, 0..60, Mode::Islands);
    let need = compare(&VAULTED, 0..60, Mode::Need);
    println!("by islands {islands:?}, by need {need:?}");
    assert!(need[2] <= islands[2]);
}
