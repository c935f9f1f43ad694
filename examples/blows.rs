//! How far bodies hop when something falls on them, and how many bricks a shot takes out of a wall, for several step lengths.
//!
//! ```text
//! cargo run --release --example blows -- [--quick]
//! ```

use clap::Parser;
use drystone_lab::blows::{
    Drop, Row, Target, bricks_lost_to_a_ball, bricks_lost_with_one, column_shot_at_its_foot,
    settle, speed_beyond_a_wall,
};

/// Measures blows.
#[derive(Parser)]
struct Arguments {
    /// Fewer heights and no shorter steps than 1/120 s: ends within ten seconds.
    #[arg(long)]
    quick: bool,
    /// Only the named group: drops, convergence, shots, row.
    #[arg(long)]
    only: Option<String>,
}

/// The falling body and its target, for one row of the table.
struct Group {
    name: &'static str,
    cubes: u32,
    density: f32,
    onto: &'static [Target],
}

const STACKS: &[Target] = &[
    Target::Stack(1),
    Target::Stack(2),
    Target::Stack(5),
    Target::Stack(10),
];

const GROUPS: [Group; 5] = [
    Group {
        name: "1 cube on 1, 2, 5, 10",
        cubes: 1,
        density: 1000.0,
        onto: STACKS,
    },
    Group {
        name: "3 cubes on the same",
        cubes: 3,
        density: 1000.0,
        onto: STACKS,
    },
    Group {
        name: "1 cube of 10 × the density",
        cubes: 1,
        density: 1e4,
        onto: STACKS,
    },
    Group {
        name: "1 cube of 100 × the density",
        cubes: 1,
        density: 1e5,
        onto: STACKS,
    },
    Group {
        name: "a brick on a 10 × 10 wall",
        cubes: 1,
        density: 1000.0,
        onto: &[Target::Wall],
    },
];

impl Group {
    /// The mean and the largest hop, mm, and the most energy left, of all heights and targets.
    fn run(&self, heights: &[f32], dt: f32) -> String {
        let (mut sum, mut most, mut left, mut count) = (0.0, 0f32, 0f64, 0);
        for &onto in self.onto {
            for &height in heights {
                let drop = Drop {
                    cubes: self.cubes,
                    density: self.density,
                    onto,
                    height,
                };
                let hop = drop.run(dt);
                let mm = 1e3 * hop.rise;
                (sum, most, count) = (sum + mm, most.max(mm), count + 1);
                left = left.max(hop.energy_left);
            }
        }
        format!(
            "{:.1} / {most:.1} ({:.2} %)",
            sum / count as f32,
            100.0 * left
        )
    }
}

fn main() {
    let Arguments { quick, only } = Arguments::parse();
    let wants = |group: &str| only.as_deref().is_none_or(|only| only == group);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("one thread can be had");
    pool.install(|| {
        if wants("drops") {
            drops(quick);
        }
        if wants("convergence") && !quick {
            convergence();
        }
        if wants("shots") && !quick {
            shots();
        }
        if wants("row") {
            row();
        }
        if wants("heaps") && !quick {
            heaps();
        }
    });
}

fn drops(quick: bool) {
    let heights: &[f32] = if quick {
        &[0.3, 2.0]
    } else {
        &[0.1, 0.3, 0.8, 2.0]
    };
    println!(
        "Hops, mean / largest over all heights and targets, mm (kinetic energy left, at most)\n"
    );
    println!("| scene | 1/120 s | 1/60 s | 1/30 s | 0.1 s |\n|---|---|---|---|---|");
    for group in GROUPS {
        let cells = [1.0 / 120.0, 1.0 / 60.0, 1.0 / 30.0, 0.1].map(|dt| group.run(heights, dt));
        println!("| {} | {} |", group.name, cells.join(" | "));
    }
}

fn convergence() {
    println!("\nHops from 2 m onto two cubes, mm\n");
    println!(
        "| scene | 1/60 s | 1/120 s | 1/240 s | 1/480 s | 1/960 s |\n|---|---|---|---|---|---|"
    );
    for group in &GROUPS[..4] {
        let drop = Drop {
            cubes: group.cubes,
            density: group.density,
            onto: Target::Stack(2),
            height: 2.0,
        };
        let cells = [60.0, 120.0, 240.0, 480.0, 960.0]
            .map(|hz| format!("{:.2}", 1e3 * drop.run(1.0 / hz).rise));
        println!("| {} | {} |", group.name, cells.join(" | "));
    }
}

fn shots() {
    let steps = [60.0, 240.0, 960.0].map(|hz| 1.0 / hz);
    println!(
        "\nBricks more than 25 cm off after 6 s, and speeds along the shot, m/s (of a ball, beyond the wall)\n"
    );
    println!("| shot | 60 Hz | 240 Hz | 960 Hz |\n|---|---|---|---|");
    for [x, y] in [
        [0.0, 2.0],
        [0.1, 2.1],
        [-0.3, 1.9],
        [0.05, 2.05],
        [0.2, 2.2],
    ] {
        let cells = steps.map(|dt| {
            let lost = bricks_lost_to_a_ball(x, y, dt);
            format!("{lost}, {:.2}", speed_beyond_a_wall(x, y, dt))
        });
        println!(
            "| a ball at a wall, at x {x}, y {y} m | {} |",
            cells.join(" | ")
        );
    }
    let cells = steps.map(|dt| bricks_lost_with_one(dt).to_string());
    println!("| a brick out of a wall | {} |", cells.join(" | "));
    let cells = steps.map(|dt| {
        let [foot, above] = column_shot_at_its_foot(dt);
        format!("{foot:.2}, {above:.3}")
    });
    println!(
        "| a ball at the foot of a column: the foot, all above | {} |",
        cells.join(" | ")
    );
}

fn row() {
    println!("\nTen cubes on ice, the first struck with 1 m/s: slowest and fastest, m/s\n");
    println!("| e | 1/960 s | 1/60 s | 1/30 s | 0.1 s |\n|---|---|---|---|---|");
    for restitution in [0.0, 1.0] {
        let cells = [1.0 / 960.0, 1.0 / 60.0, 1.0 / 30.0, 0.1].map(|dt| {
            let speeds = Row { restitution }.run(dt, 1);
            let (least, most) = speeds
                .iter()
                .fold((f32::MAX, f32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
            let momentum: f32 = speeds.iter().sum();
            let energy: f32 = speeds.iter().map(|v| v * v).sum();
            format!("{least:.4} – {most:.4} (Σv {momentum:.5}, Σv² {energy:.4})")
        });
        println!("| {restitution} | {} |", cells.join(" | "));
    }
}

fn heaps() {
    println!(
        "\nHeaps at 60 Hz: steps until all sleep, overlap at the end and at most, mm, seconds for the first 300 steps\n"
    );
    println!("| heap | seed | asleep | overlap | at most | time |\n|---|---|---|---|---|---|");
    for (name, seeds) in [("heap:300", 1..=6), ("heap:1000", 1..=2)] {
        for seed in seeds {
            let scene = name.parse().expect("it is known");
            let found = settle(scene, seed, 1.0 / 60.0, 1500);
            let asleep = found
                .steps
                .map_or("–".to_owned(), |steps| steps.to_string());
            let [overlap, most] = [found.overlap, found.overlap_max].map(|m| 1e3 * m);
            println!(
                "| {name} | {seed} | {asleep} | {overlap:.2} | {most:.0} | {:.2} |",
                found.seconds
            );
        }
    }
}
