//! The command line.

use crate::busy::BusyTable;
use crate::play::Play;
use crate::rocking::Rocking;
use crate::run::RunArguments;
use crate::table::Table;
use clap::{Parser, Subcommand};
use drystone_lab::scenes::{KNOWN, Scene};

/// Simulates scenes in drystone and in other engines and prints what became of them.
#[derive(Parser)]
#[command(after_help = format!("Scenes: {KNOWN}; not those with a hand (pressed:N)."))]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// A scene to simulate; may be given several times.
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

/// Other commands.
#[derive(Subcommand)]
pub enum Command {
    /// Runs the standard scenes and writes one table, as Markdown and CSV, and a plot.
    Table(Table),
    /// Runs the busy scenes, each with the steps of its benchmark, and writes one table of times, overlaps and joints, as Markdown and CSV.
    Busy(BusyTable),
    /// Measures what playing on a scene costs in drystone and Rapier, with sleeping on.
    Play(Play),
    /// Draws how a block rocks in each engine and after Housner.
    Rocking(Rocking),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peer::Peer;

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
