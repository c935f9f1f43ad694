//! A run of the game without a window: its app, the times of its steps, and a report.

use crate::game::{self, Clock, Tally};
use crate::keeper::Keeper;
#[cfg(feature = "ui")]
use crate::panel;
use crate::save;
use bevy_app::App;
use drystone::prelude::*;
use std::fmt::{Display, Write};
use std::time::{Duration, Instant};

/// A game in progress.
pub struct Game {
    pub app: App,
    /// What must not happen.
    pub faults: Vec<String>,
    keeper: Keeper,
    times: Vec<Duration>,
    /// Times of the frames, in which the panel is shown.
    #[cfg(feature = "ui")]
    panel_times: Vec<Duration>,
    bytes: usize,
}

/// An app with everything that the game needs, and nothing in it.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), CollapsePlugin));
    #[cfg(feature = "ui")]
    panel::add(&mut app);
    game::add(&mut app);
    save::register(&mut app);
    app
}

impl Game {
    pub fn new(dt: f32) -> Self {
        let mut app = app();
        game::build(app.world_mut(), dt);
        Self {
            app,
            faults: Vec::new(),
            keeper: Keeper::default(),
            times: Vec::new(),
            #[cfg(feature = "ui")]
            panel_times: Vec::new(),
            bytes: 0,
        }
    }

    /// Plays one step.
    pub fn step(&mut self) {
        let world = self.app.world_mut();
        game::act(world, &mut self.keeper, &mut self.faults);
        let dt = world.resource::<Clock>().dt;
        let start = Instant::now();
        if let Err(error) = drystone::step(world, dt) {
            self.faults.push(error.to_string());
        }
        self.times.push(start.elapsed());
        #[cfg(feature = "ui")]
        self.panel_times.push(panel::frame(world));
        game::note(world, &mut self.faults);
    }

    /// The same game, written to text and read into another app.
    pub fn saved_and_loaded(mut self) -> Self {
        let text = save::write(self.app.world_mut());
        let mut app = app();
        save::read(app.world_mut(), &text);
        let before = save::poses(self.app.world_mut());
        let after = save::poses(app.world_mut());
        if before != after {
            self.faults.push("a body is elsewhere after loading".into());
        }
        let asleep = save::asleep(self.app.world_mut());
        let world = app.world_mut();
        let dt = world.resource::<Clock>().dt;
        drystone::advance(world, dt).expect("the step is valid");
        world.resource_mut::<Clock>().step += 1;
        let still = save::asleep(app.world_mut());
        if still < asleep {
            self.faults.push(format!(
                "{} of {asleep} sleepers woke by loading",
                asleep - still
            ));
        }
        Self {
            app,
            bytes: text.len(),
            keeper: Keeper::default(),
            ..self
        }
    }

    /// What happened, what a step cost, and the faults.
    pub fn report(&self) -> String {
        let world = self.app.world();
        let (clock, tally) = (world.resource::<Clock>(), world.resource::<Tally>());
        let mut text = format!("{:.0} s at {:.0} Hz.\n", clock.seconds(), 1.0 / clock.dt);
        let mut line = |what: &str, value: &dyn Display| {
            writeln!(text, "{what:<28}{value}").expect("a string grows")
        };
        line("shots", &tally.shots);
        line("farthest shot, m", &format!("{:.1}", tally.range));
        line(
            "raiders / captured",
            &format!("{} / {}", tally.raiders, tally.captured),
        );
        line("bricks put back", &tally.repaired);
        line("edits undone", &tally.undone);
        line("bonds of mortar broken", &tally.bonds_broken);
        line("bricks broken", &tally.bricks_broken);
        line("collapses", &tally.collapses);
        line("barrels afloat", &tally.afloat);
        line("cells blown away", &tally.dug);
        line("rounds of the guard", &tally.rounds);
        line("highest lift, m", &format!("{:.2}", tally.lifted));
        line("saved game, kB", &(self.bytes / 1000));
        let mut times: Vec<f64> = self
            .times
            .iter()
            .map(|time| 1e3 * time.as_secs_f64())
            .collect();
        times.sort_unstable_by(f64::total_cmp);
        let mean = times.iter().sum::<f64>() / times.len().max(1) as f64;
        let quantile = |share: f64| {
            times
                .get((share * times.len() as f64) as usize)
                .or(times.last())
        };
        line("a step, ms: mean", &format!("{mean:.2}"));
        for (name, share) in [("50 %", 0.5), ("99 %", 0.99), ("longest", 1.0)] {
            let value = quantile(share).copied().unwrap_or_default();
            line(&format!("a step, ms: {name}"), &format!("{value:.2}"));
        }
        #[cfg(feature = "ui")]
        line(
            "the panel, ms a frame: mean",
            &panel::mean(&self.panel_times),
        );
        line("faults", &self.faults.len());
        for fault in self.faults.iter().take(20) {
            line("", fault);
        }
        text
    }
}
