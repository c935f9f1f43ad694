//! The arguments of a run: engines, steps, threads and ground.

use crate::peer::Peer;
use crate::rapier;
use crate::scene::Conditions;
use clap::Args;
use drystone_lab::scenes::{Ground, Scene};

/// The arguments of a run, for all commands.
#[derive(Args, Clone)]
pub struct RunArguments {
    /// Another engine; may be given several times. Default: all engines of this build.
    #[arg(long, value_enum)]
    engine: Vec<Peer>,
    /// Number of steps. Default: 600, and of busy scenes that of their benchmark.
    #[arg(long, value_parser = count)]
    steps: Option<usize>,
    /// Number of steps that an engine takes before the next engine's turn.
    #[arg(long, default_value_t = 30, value_parser = count)]
    turn: usize,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0, value_parser = length)]
    dt: f32,
    /// The ground of the scenes.
    #[arg(long, default_value_t)]
    ground: Ground,
    /// Threads of each engine. Rapier uses more than one only with the feature `parallel`.
    #[arg(long, default_value_t = 1, value_parser = threads)]
    threads: usize,
    /// Rapier's num_solver_iterations. Default: Rapier's.
    #[arg(long, value_parser = count)]
    rapier_iterations: Option<usize>,
    /// The shape that replaces a half-space in Rapier.
    #[arg(long, value_enum, default_value = "slab")]
    rapier_ground: rapier::Ground,
}

/// The length of a run, and how engines take turns.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Number of steps of each engine.
    pub steps: usize,
    /// Number of steps that an engine takes before the next engine's turn. In turns, other load of the machine affects all engines alike.
    /// Turns of one step would be unfair to the faster engine: after each long step of another engine its caches and its core are cold.
    /// Rapier takes up to twice its time then.
    pub turn: usize,
}

impl RunArguments {
    /// Busy scenes say whether their bodies sleep.
    pub fn conditions(&self, scene: Scene) -> Conditions {
        Conditions {
            dt: self.dt,
            threads: self.threads,
            ground: self.ground,
            sleeping: matches!(scene, Scene::Busy(busy) if busy.sleeps()),
        }
    }

    pub fn course(&self, scene: Scene) -> Course {
        let usual = match scene {
            Scene::Busy(busy) => busy.steps(),
            _ => 600,
        };
        Course {
            steps: self.steps.unwrap_or(usual),
            turn: self.turn,
        }
    }

    /// The engines without duplicates, in the order in which they were named.
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

pub fn length(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(dt) if (1e-6..=1.0).contains(&dt) => Ok(dt),
        _ => Err("must be a number from 0.000001 to 1".into()),
    }
}

pub fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=256).contains(&n) => Ok(n),
        _ => Err("must be a whole number from 1 to 256".into()),
    }
}
