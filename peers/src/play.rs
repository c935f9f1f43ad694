//! What playing costs in drystone and in Rapier: every half second a brick is laid, a ball thrown, a brick laid, a brick taken. Sleeping is on,
//! as it is by default in both.

use crate::rapier::{self, Rapier};
use crate::run::{length, threads};
use crate::scene::{self, Conditions, Start};
use bevy_ecs::world::World;
use clap::Args;
use drystone::settings::Gravity;
use drystone_lab::play::{Cost, Script, Session};
use drystone_lab::scenes::{Ground, Scene};

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
}

/// Steps that an engine takes before the next engine's turn.
const TURN: usize = 30;

impl Play {
    /// Plays in both engines in turns, and prints a table for each scene.
    ///
    /// # Errors
    /// If an engine cannot have a scene.
    pub fn print(&self) -> Result<(), String> {
        for &scene in &self.scene {
            let [own, rapier] = self.costs(scene)?;
            println!("{scene}\n\n{}", Cost::HEAD);
            println!("| drystone | {own}\n| Rapier | {rapier}\n");
        }
        Ok(())
    }

    /// A session of each engine, at rest.
    fn begin(&self, scene: Scene) -> Result<(Session<World>, Session<Rapier>), String> {
        let script = Script::of(scene, self.wreck)?;
        let conditions = Conditions {
            dt: self.dt,
            threads: self.threads,
            ground: Ground::default(),
            sleeping: true,
        };
        let (run, bodies, joints) = scene::build(scene, self.seed, conditions)?;
        let start = Start {
            bodies: &bodies,
            joints: &joints,
            gravity: run.world.resource::<Gravity>().0,
            conditions,
        };
        let options = rapier::Options {
            iterations: None,
            ground: rapier::Ground::Slab,
        };
        let rapier = Rapier::new(&start, options)?;
        let mut own = Session::new(run.world, script, self.seed, self.dt);
        let mut rapier = Session::new(rapier, script, self.seed, self.dt);
        own.settle();
        rapier.settle();
        Ok((own, rapier))
    }

    fn costs(&self, scene: Scene) -> Result<[Cost; 2], String> {
        let (mut own, mut rapier) = self.begin(scene)?;
        let mut left = (self.seconds / self.dt).round() as usize;
        while left > 0 {
            let turn = TURN.min(left);
            own.steps(turn);
            rapier.steps(turn);
            left -= turn;
        }
        Ok([own.cost(), rapier.cost()])
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
        }
    }

    #[test]
    fn both_engines_sleep_before_they_are_played() {
        let wall = Scene::Wall(4, 4);
        let (mut own, mut rapier) = play(true).begin(wall).unwrap();
        assert_eq!([own.awake(), rapier.awake()], [0, 0]);
        for cost in play(true).costs(wall).unwrap() {
            assert!(cost.awake > 1.0, "{cost:?}");
            assert!(cost.mean <= cost.longest && cost.p99 <= cost.longest);
        }
        assert!(play(true).costs(Scene::Heap(3)).is_err());
    }

    #[test]
    fn balls_are_thrown_at_a_falling_heap() {
        for cost in play(false).costs(Scene::Heap(3)).unwrap() {
            assert_eq!(cost.awake, 4.0);
        }
    }
}
