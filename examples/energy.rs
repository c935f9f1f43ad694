//! The energy that loose bodies gain, which should be none: rods that fall crosswise, and overlapping bodies.
//!
//! ```text
//! cargo run --release --example energy -- [--only rods] [--seeds 3] [--seconds 10]
//! ```

use clap::Parser;
use drystone_lab::energy::{Lie, Loose, Shape};
use std::time::Instant;

/// Measures gains.
#[derive(Parser)]
struct Arguments {
    /// Only scenes whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// Seeds of each scene.
    #[arg(long, default_value_t = 1)]
    seeds: u64,
    /// Duration of each run, s. A run ends earlier if all bodies sleep.
    #[arg(long, default_value_t = 10.0)]
    seconds: f32,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0)]
    dt: f32,
}

fn scenes() -> Vec<(String, Loose)> {
    let mut scenes = Vec::new();
    for lie in [Lie::Crossed, Lie::Headings, Lie::Anyhow] {
        for thick in [0.2, 0.1, 0.05] {
            let count = 30;
            scenes.push((
                format!("rods {lie:?} {thick}"),
                Loose::Rods { count, thick, lie },
            ));
        }
    }
    for middle in [None, Some(0.5), Some(3.0)] {
        let side = 1.0;
        for (count, shape) in [
            (300, Shape::Ball(0.1)),
            (100, Shape::Ball(0.25)),
            (300, Shape::Ball(0.25)),
            (300, Shape::Brick),
            (1000, Shape::Brick),
        ] {
            let scene = Loose::Strewn {
                count,
                shape,
                side,
                middle,
            };
            scenes.push((format!("strewn {count} {shape:?} {middle:?}"), scene));
        }
    }
    let cubes = Loose::Strewn {
        count: 1000,
        shape: Shape::Cube,
        side: 0.1,
        middle: Some(3.0),
    };
    scenes.push(("strewn 1000 Cube".to_owned(), cubes));
    scenes
}

fn main() {
    let arguments = Arguments::parse();
    let asked = |name: &str| {
        arguments
            .only
            .as_ref()
            .is_none_or(|only| name.contains(only))
    };
    for (name, scene) in scenes().into_iter().filter(|(name, _)| asked(name)) {
        for seed in 1..=arguments.seeds {
            let start = Instant::now();
            let fall = scene.run(seed, arguments.dt, arguments.seconds);
            let asleep = match fall.asleep {
                Some(seconds) => format!("asleep after {seconds:.1} s"),
                None => "awake".to_owned(),
            };
            println!(
                "{name} #{seed}: {:.0} J at first, {:.0} in the end ({:.0} kinetic), gained {:.1}; at most {:.1} m/s, {:.0} rad/s; \
                 {asleep}, overlap {:.1} mm; took {:.1} s",
                fall.first,
                fall.last,
                fall.kinetic,
                fall.gained,
                fall.fastest,
                fall.spin,
                1e3 * fall.overlap,
                start.elapsed().as_secs_f32(),
            );
        }
    }
}
