//! One comparison: all engines from the same start, in turns.

use crate::engine::{Effort, Engine};
use crate::meter::{Metered, Outcome};
use crate::own::Drystone;
use crate::run::{Course, RunArguments};
use crate::scene::{self, Conditions, Start};
use drystone::prelude::RigidBody;
use drystone_lab::scenes::Scene;

/// The results of a scene in all engines.
pub struct Comparison {
    pub scene: Scene,
    pub seed: u64,
    pub conditions: Conditions,
    pub course: Course,
    /// How many are dynamic.
    pub bodies: usize,
    pub joints: usize,
    /// Drystone first.
    pub engines: Vec<Entry>,
    /// Why other engines cannot have the scene.
    pub refused: Vec<String>,
}

/// The result of a scene in one engine.
pub struct Entry {
    pub name: &'static str,
    pub effort: Option<Effort>,
    pub outcome: Outcome,
}

/// # Errors
/// If no other engine can have the scene.
pub fn compare(scene: Scene, seed: u64, arguments: &RunArguments) -> Result<Comparison, String> {
    let (conditions, course) = (arguments.conditions(scene), arguments.course(scene));
    let (run, bodies, joints) = scene::build(scene, seed, conditions)?;
    let start = Start::of(&run, &bodies, &joints, conditions);
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    let mut refused = Vec::new();
    for peer in arguments.peers() {
        match peer.start(&start, arguments.rapier()) {
            Ok(engine) => engines.push(engine),
            Err(why) => refused.push(why),
        }
    }
    if engines.is_empty() {
        return Err(format!("--scene {scene}: {}", refused.join("; ")));
    }
    let own = Drystone::new(run.world, &bodies, conditions.dt);
    engines.insert(0, Box::new(own));
    let mut metered: Vec<_> = engines
        .into_iter()
        .map(|engine| Metered::new(engine, &start))
        .collect();
    let mut left = course.steps;
    while left > 0 {
        let turn = left.min(course.turn);
        for engine in &mut metered {
            engine.steps(turn);
        }
        left -= turn;
    }
    let entry = |metered: &Metered<Box<dyn Engine>>| Entry {
        name: metered.engine.name(),
        effort: metered.engine.effort(),
        outcome: metered.outcome(),
    };
    let dynamic = bodies.iter().filter(|b| b.kind == RigidBody::Dynamic);
    Ok(Comparison {
        scene,
        seed,
        conditions,
        course,
        bodies: dynamic.count(),
        joints: joints.len(),
        engines: metered.iter().map(entry).collect(),
        refused,
    })
}

impl Comparison {
    pub fn drystone(&self) -> &Entry {
        &self.engines[0]
    }

    /// All but drystone.
    pub fn peers(&self) -> &[Entry] {
        &self.engines[1..]
    }

    /// Drystone's median time over another's; below 1 drystone is the faster.
    pub fn ratio(&self, other: &Entry) -> f64 {
        let seconds = |entry: &Entry| entry.outcome.step_time.median.as_secs_f64();
        seconds(self.drystone()) / seconds(other)
    }

    /// As [`ratio`](Self::ratio), of mean times once settled.
    pub fn settled_ratio(&self, other: &Entry) -> f64 {
        let seconds = |entry: &Entry| entry.outcome.settled_time.as_secs_f64();
        seconds(self.drystone()) / seconds(other)
    }
}
