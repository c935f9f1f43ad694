//! What playing costs in drystone and in Rapier: every half second a brick is laid, a ball thrown, a brick laid, a brick taken. Sleeping is
//! on, as it is by default in both.

mod plot;
mod rows;

use crate::rapier::{self, Rapier};
use crate::run::{length, threads};
use crate::scene::{self, Conditions, Start};
use bevy_ecs::world::World;
use clap::Args;
use drystone_lab::play::{Cost, Script, Session};
use drystone_lab::scenes::{Ground, Scene};
use rows::{Row, figures};
use std::path::PathBuf;

/// The arguments of the command.
#[derive(Args)]
pub struct Play {
    /// What is played on; may be given several times. Balls are thrown at scenes other than walls while they fall together.
    #[arg(long, default_values = ["wall:40x25", "wall:100x50"])]
    scene: Vec<Scene>,
    /// How long, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f32,
    /// A ball of 524 kg flies into the wall, and nobody plays.
    #[arg(long)]
    wreck: bool,
    /// Seed of where the player lays and throws.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0, value_parser = length)]
    dt: f32,
    /// Threads of each engine. Rapier uses more than one only with the feature `parallel`.
    #[arg(long, default_value_t = 1, value_parser = threads)]
    threads: usize,
    /// Drystone alone, for walls that are too large for others.
    #[arg(long)]
    alone: bool,
    /// Adds the figures to this CSV file, so that several runs make one plot.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draws time and bodies awake over the size of the scene, of this run and of the rows in the CSV file.
    #[arg(long, value_name = "PICTURE")]
    plot: Option<PathBuf>,
}

/// Steps that an engine takes before the next engine's turn.
const TURN: usize = 30;

impl Play {
    /// Plays in both engines in turns, prints a table for each scene, and writes the files that are asked for.
    ///
    /// # Errors
    /// If an engine cannot have a scene, or a file cannot be read or written.
    pub fn print(&self) -> Result<(), String> {
        let mut rows = match &self.csv {
            Some(csv) => rows::read(csv)?,
            None => Vec::new(),
        };
        for &scene in &self.scene {
            let (own, rapier) = self.costs(scene)?;
            println!("{scene}\n\n{}", Cost::HEAD);
            println!("| drystone | {own}");
            if let Some(rapier) = &rapier {
                println!("| Rapier | {rapier}");
            }
            println!();
            let row = Row {
                scene,
                own: figures(&own),
                rapier: rapier.as_ref().map(figures),
            };
            rows::add(&mut rows, row);
            if let Some(csv) = &self.csv {
                rows::write(csv, &rows)?;
            }
        }
        if let Some(picture) = &self.plot {
            let drawn = plot::draw(&rows, picture);
            drawn.map_err(|error| format!("{}: {error}", picture.display()))?;
        }
        Ok(())
    }

    /// A session of each engine, at rest.
    fn begin(&self, scene: Scene) -> Result<(Session<World>, Option<Session<Rapier>>), String> {
        let script = Script::of(scene, self.wreck)?;
        let conditions = Conditions {
            dt: self.dt,
            threads: self.threads,
            ground: Ground::default(),
            sleeping: true,
        };
        let (run, bodies, joints) = scene::build(scene, self.seed, conditions)?;
        let start = Start::of(&run, &bodies, &joints, conditions);
        let options = rapier::Options {
            iterations: None,
            ground: rapier::Ground::Slab,
        };
        let rapier = match self.alone {
            true => None,
            false => Some(Rapier::new(&start, options)?),
        };
        let mut own = Session::new(run.world, script, self.seed, self.dt);
        let mut rapier = rapier.map(|rapier| Session::new(rapier, script, self.seed, self.dt));
        own.settle();
        rapier.iter_mut().for_each(Session::settle);
        Ok((own, rapier))
    }

    fn costs(&self, scene: Scene) -> Result<(Cost, Option<Cost>), String> {
        let (mut own, mut rapier) = self.begin(scene)?;
        let mut left = (self.seconds / self.dt).round() as usize;
        while left > 0 {
            let turn = TURN.min(left);
            own.steps(turn);
            rapier.iter_mut().for_each(|rapier| rapier.steps(turn));
            left -= turn;
        }
        Ok((own.cost(), rapier.as_ref().map(Session::cost)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn play(wreck: bool) -> Play {
        Play {
            scene: Vec::new(),
            seconds: 0.5,
            wreck,
            seed: 1,
            dt: 1.0 / 60.0,
            threads: 1,
            alone: false,
            csv: None,
            plot: None,
        }
    }

    #[test]
    fn both_engines_sleep_before_they_are_played() {
        let wall = Scene::Wall(4, 4);
        let (mut own, rapier) = play(true).begin(wall).unwrap();
        assert_eq!([own.awake(), rapier.unwrap().awake()], [0, 0]);
        let (own, rapier) = play(true).costs(wall).unwrap();
        for cost in [own, rapier.unwrap()] {
            assert!(cost.awake > 1.0, "{cost:?}");
            assert!(cost.mean <= cost.longest && cost.p99 <= cost.longest);
        }
        assert!(play(true).costs(Scene::Heap(3)).is_err());
    }

    #[test]
    fn drystone_may_play_alone() {
        let play = Play {
            alone: true,
            ..play(false)
        };
        let (own, rapier) = play.costs(Scene::Wall(4, 4)).unwrap();
        assert!(own.awake > 0.5 && rapier.is_none());
    }

    #[test]
    fn balls_are_thrown_at_a_falling_heap() {
        let (own, rapier) = play(false).costs(Scene::Heap(3)).unwrap();
        for cost in [own, rapier.unwrap()] {
            assert_eq!(cost.awake, 4.0);
        }
    }
}
