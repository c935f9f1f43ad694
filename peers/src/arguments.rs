//! The command line.

use crate::compare::Course;
use crate::peer::Peer;
use crate::rapier;
use crate::scene::Conditions;
use crate::table::Table;
use clap::{Args, Parser, Subcommand};
use drystone_lab::scenes::{Ground, KNOWN, Scene};

/// Simulates scenes in drystone and in other engines and prints what became of them.
#[derive(Parser)]
#[command(after_help = format!("Scenes: {KNOWN}; not those with a hand (pressed:N)."))]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What to simulate; may be given several times.
    #[arg(long, required = true)]
    pub scene: Vec<Scene>,
    #[command(flatten)]
    pub run: RunArguments,
    /// Seeds of what a scene has at random, one comparison each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    pub seeds: Vec<u64>,
    /// One JSON object a line instead of tables.
    #[arg(long)]
    pub json: bool,
}

/// What else there is to do.
#[derive(Subcommand)]
pub enum Command {
    /// Runs the standard scenes and writes one table, as Markdown and CSV, and a plot.
    Table(Table),
}

/// How engines are run, whatever is done with what becomes of it.
#[derive(Args, Clone)]
pub struct RunArguments {
    /// Another engine; may be given several times. All that this build has if none is.
    #[arg(long, value_enum)]
    engine: Vec<Peer>,
    /// How many steps.
    #[arg(long, default_value_t = 600, value_parser = count)]
    steps: usize,
    /// Steps that an engine takes before it is the next one's turn.
    #[arg(long, default_value_t = 30, value_parser = count)]
    turn: usize,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0, value_parser = length)]
    dt: f32,
    /// What scenes stand on.
    #[arg(long, default_value_t)]
    ground: Ground,
    /// Threads of each engine; of Rapier more than one with the feature `parallel`.
    #[arg(long, default_value_t = 1, value_parser = threads)]
    threads: usize,
    /// Rapier's num_solver_iterations; its default if not given.
    #[arg(long, value_parser = count)]
    rapier_iterations: Option<usize>,
    /// What Rapier gets for a half-space.
    #[arg(long, value_enum, default_value = "slab")]
    rapier_ground: rapier::Ground,
}

impl RunArguments {
    pub fn conditions(&self) -> Conditions {
        Conditions {
            dt: self.dt,
            threads: self.threads,
            ground: self.ground,
        }
    }

    pub fn course(&self) -> Course {
        Course {
            steps: self.steps,
            turn: self.turn,
        }
    }

    /// Each once, in the order in which they were named first.
    pub fn peers(&self) -> Vec<Peer> {
        let named = match self.engine.is_empty() {
            true => Peer::BUILT,
            false => &self.engine,
        };
        let mut peers = Vec::new();
        for &peer in named {
            if !peers.contains(&peer) {
                peers.push(peer);
            }
        }
        peers
    }

    pub fn rapier(&self) -> rapier::Options {
        rapier::Options {
            iterations: self.rapier_iterations,
            ground: self.rapier_ground,
        }
    }
}

pub fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("must be a whole number above 0".into()),
    }
}

fn length(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(dt) if (1e-6..=1.0).contains(&dt) => Ok(dt),
        _ => Err("must be a number from 0.000001 to 1".into()),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=256).contains(&n) => Ok(n),
        _ => Err("must be a whole number from 1 to 256".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Arguments, clap::Error> {
        Arguments::try_parse_from(line.split(' '))
    }

    #[test]
    fn all_engines_of_this_build_or_those_named_once() {
        let all = parsed("peers --scene stack:2").unwrap().run.peers();
        assert_eq!(all, Peer::BUILT);
        let named = parsed("peers --scene stack:2 --engine rapier --engine rapier").unwrap();
        assert_eq!(named.run.peers(), [Peer::Rapier]);
        assert!(parsed("peers --scene stack:2 --engine havok").is_err());
    }

    #[test]
    fn a_scene_is_wanted_but_by_the_table() {
        assert!(parsed("peers").is_err());
        assert!(parsed("peers table").unwrap().command.is_some());
        assert!(parsed("peers --scene stack:2 table").is_err());
    }
}
