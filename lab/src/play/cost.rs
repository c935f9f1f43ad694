//! What playing costs: the times of steps, and how many bodies are awake.

use super::PAUSE;
use super::game::{Ball, Game, Player, ball};
use crate::scenes::Scene;
use crate::scenes::castle::FRONT;
use glam::Vec3;
use std::fmt;
use std::time::{Duration, Instant};

/// What is done to a scene while its steps are timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Script {
    /// A [player](Player) at a wall, or the front of a castle, of so many bricks in a course and so many courses.
    Build([u32; 2]),
    /// Every half second a ball of 4 kg is thrown at what falls together.
    Throw,
    /// A ball of 524 kg flies at 20 m/s into the middle of a wall of so many courses, once.
    Wreck(u32),
}

impl Script {
    /// What is done to this scene: a wall is built on or, if so asked, wrecked; balls are thrown at others.
    ///
    /// # Errors
    /// If something other than a wall is to be wrecked.
    pub fn of(scene: Scene, wreck: bool) -> Result<Self, String> {
        match (scene, wreck) {
            (Scene::Wall(columns, courses), false) => Ok(Self::Build([columns, courses])),
            (Scene::Castle(courses), false) => Ok(Self::Build([FRONT as u32, courses])),
            (Scene::Wall(_, courses), true) => Ok(Self::Wreck(courses)),
            (_, false) => Ok(Self::Throw),
            (_, true) => Err(format!(
                "{scene} is not a wall, so there is nothing to wreck"
            )),
        }
    }

    /// Whether the scene comes to rest before the script begins.
    fn settles(self) -> bool {
        self != Self::Throw
    }
}

/// Time in which a scene comes to rest, s.
pub(super) const SETTLES: f32 = 3.0;

/// A game under way, and the times of its steps.
pub struct Session<G: Game> {
    game: G,
    script: Script,
    player: Player<G::Body>,
    rng: fastrand::Rng,
    dt: f32,
    times: Vec<Duration>,
    /// By step: the number of dynamic bodies awake.
    counts: Vec<usize>,
}

impl<G: Game> Session<G> {
    /// A session that has not begun. `dt` is the length of a step, s.
    pub fn new(game: G, script: Script, seed: u64, dt: f32) -> Self {
        let wall = match script {
            Script::Build(wall) => wall,
            Script::Throw | Script::Wreck(_) => [2, 2],
        };
        Self {
            game,
            script,
            player: Player::new(wall, seed),
            rng: fastrand::Rng::with_seed(seed),
            dt,
            times: Vec::new(),
            counts: Vec::new(),
        }
    }

    /// Lets the scene come to rest and fall asleep, if its script asks for that.
    pub fn settle(&mut self) {
        if self.script.settles() {
            for _ in 0..(SETTLES / self.dt).round() as usize {
                self.game.step(self.dt);
            }
        }
    }

    /// Takes so many steps, and does before each what the script says.
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.act();
            let start = Instant::now();
            self.game.step(self.dt);
            self.times.push(start.elapsed());
            let awake = self.awake();
            self.counts.push(awake);
        }
    }

    fn act(&mut self) {
        let number = self.times.len();
        let is_turn = number.is_multiple_of((PAUSE / self.dt).round().max(1.0) as usize);
        match self.script {
            Script::Build(_) if is_turn => {
                self.player.act(&mut self.game);
            }
            Script::Throw if is_turn => {
                let mut aside = || 2.0 * self.rng.f32() - 1.0;
                let at = Vec3::new(aside(), 1.5 + aside(), 6.0);
                self.game.throw(&ball(at));
            }
            Script::Wreck(courses) if number == 0 => self.game.throw(&Ball {
                radius: 0.5,
                at: Vec3::new(0.0, 0.25 * courses as f32, 5.0),
                velocity: Vec3::new(0.0, 1.0, -20.0),
            }),
            _ => (),
        }
    }

    /// Number of dynamic bodies that are awake.
    pub fn awake(&mut self) -> usize {
        self.game.awake()
    }

    /// Statistics of the steps so far.
    pub fn cost(&self) -> Cost {
        let mut times = self.times.clone();
        times.sort_unstable();
        let count = times.len().max(1);
        Cost {
            mean: times.iter().sum::<Duration>() / count as u32,
            p99: times.get(count * 99 / 100).copied().unwrap_or_default(),
            longest: times.last().copied().unwrap_or_default(),
            awake: self.counts.iter().sum::<usize>() as f32 / count as f32,
        }
    }
}

/// The statistics of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Mean time of a step.
    pub mean: Duration,
    /// The 99th percentile.
    pub p99: Duration,
    /// The longest step.
    pub longest: Duration,
    /// Mean number of dynamic bodies awake.
    pub awake: f32,
}

impl Cost {
    /// The head of a table of costs.
    pub const HEAD: &str =
        "| engine | mean, ms | 99th percentile | longest | bodies awake |\n|---|---|---|---|---|";
}

/// The columns of a table after the name.
impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mean, p99, longest] =
            [self.mean, self.p99, self.longest].map(|t| 1e3 * t.as_secs_f64());
        write!(
            f,
            "{mean:.3} | {p99:.2} | {longest:.2} | {:.0} |",
            self.awake
        )
    }
}
