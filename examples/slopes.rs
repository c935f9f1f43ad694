//! Mixed bodies that are dropped on hilly ground: how many sleep after how long, and who does not.
//!
//! ```text
//! cargo run --release --example slopes -- [--only mesh] [--seeds 3] [--seconds 20] [--damping 4]
//! ```

use clap::Parser;
use drystone_lab::slopes::{Hills, Slopes};

/// Counts who sleeps.
#[derive(Parser)]
struct Arguments {
    /// Only this ground: `mesh` or `field`.
    #[arg(long)]
    only: Option<String>,
    /// Seeds of each.
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// How many bodies.
    #[arg(long, default_value_t = 300)]
    count: u32,
    /// Angular damping of round bodies, 1/s.
    #[arg(long, default_value_t = 0.0)]
    damping: f32,
    /// Duration of each run, s. A run ends earlier if all bodies sleep.
    #[arg(long, default_value_t = 20.0)]
    seconds: f32,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0)]
    dt: f32,
    /// How many of those that do not sleep are told of.
    #[arg(long, default_value_t = 8)]
    tell: usize,
}

fn main() {
    let arguments = Arguments::parse();
    for (name, hills) in [("mesh", Hills::Mesh), ("field", Hills::HeightField)] {
        if arguments.only.as_ref().is_none_or(|only| only == name) {
            for seed in 1..=arguments.seeds {
                run(name, hills, seed, &arguments);
            }
        }
    }
}

fn run(name: &str, hills: Hills, seed: u64, arguments: &Arguments) {
    let slopes = Slopes {
        hills,
        count: arguments.count,
        damping: arguments.damping,
    };
    let mut field = slopes.build(seed);
    let each = (1.0 / arguments.dt).round() as u32;
    println!("{name} #{seed}:");
    for second in 1..=arguments.seconds.round() as u32 {
        (0..each).for_each(|_| field.step(arguments.dt));
        let awake = field.awake().len();
        if second % 4 == 0 || awake == 0 {
            let asleep = field.bodies.len() - awake;
            println!(
                "  {asleep} asleep after {second} s, {:.1} J",
                field.energy()
            );
        }
        if awake == 0 {
            break;
        }
    }
    // An island sleeps as a whole, so most of those that are awake are still.
    for body in field.awake().iter().take(arguments.tell) {
        println!(
            "  {} {}: {:.1} mm/s, {:.1} mrad/s, touches {}, {} points in {} planes on the ground",
            body.shape,
            body.body,
            1e3 * body.speed,
            1e3 * body.spin,
            body.neighbours,
            body.on_ground.0,
            body.on_ground.1,
        );
    }
}
