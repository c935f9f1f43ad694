//! The game: its app, its clock, the order of its parts, and what is measured.

#[cfg(feature = "ui")]
use crate::panel;
use crate::{castle, drawbridge, guard, hill, keeper, lift, moat, raiders, save, trebuchet};
use bevy_app::App;
use bevy_ecs::message::{Message, Messages};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use drystone::collision_layers;
use drystone::mortar::MortarBroke;
use drystone::prelude::*;
use std::fmt::{Display, Write};
use std::time::{Duration, Instant};

collision_layers! {
    /// Who a zone looks for.
    pub enum Layer { Things, Raiders, Guards, Platforms }
}

/// Time of the game, which is saved with it.
#[derive(Resource, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Resource)]
pub struct Clock {
    /// Steps since the beginning.
    pub step: u32,
    /// Length of a step, s.
    pub dt: f32,
}

impl Clock {
    /// Seconds since the beginning.
    pub fn seconds(&self) -> f32 {
        self.step as f32 * self.dt
    }

    /// Whether this is the first step at or after a time, s, in a period, s.
    pub fn strikes(&self, at: f32, period: f32) -> bool {
        let phase = |step: u32| ((step as f32 * self.dt - at) / period).floor();
        self.step > 0 && phase(self.step) != phase(self.step - 1) && self.seconds() >= at
    }
}

/// What happened, which is saved with the game.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource)]
pub struct Tally {
    pub shots: u32,
    pub raiders: u32,
    pub captured: u32,
    pub repaired: u32,
    pub undone: u32,
    pub bonds_broken: u32,
    pub bricks_broken: u32,
    pub collapses: u32,
    /// Barrels that float.
    pub afloat: u32,
    /// Cells that were blown out of the hill.
    pub dug: u32,
    /// Rounds of the guard.
    pub rounds: u32,
    /// The farthest that a shot came, m.
    pub range: f32,
    /// The highest position of the lift, m.
    pub lifted: f32,
}

/// A game in progress.
pub struct Game {
    pub app: App,
    /// What must not happen.
    pub faults: Vec<String>,
    keeper: keeper::Keeper,
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
    app.init_resource::<Tally>()
        .init_resource::<Clock>()
        .init_resource::<castle::Broken>()
        .add_observer(castle::note_broken);
    save::register(&mut app);
    app
}

impl Game {
    pub fn new(dt: f32) -> Self {
        let mut app = app();
        let world = app.world_mut();
        world.insert_resource(Clock { step: 0, dt });
        castle::build(world);
        drawbridge::build(world);
        lift::build(world);
        trebuchet::build(world);
        raiders::build(world);
        moat::build(world);
        hill::build(world);
        guard::build(world);
        Self {
            app,
            faults: Vec::new(),
            keeper: keeper::Keeper::default(),
            times: Vec::new(),
            #[cfg(feature = "ui")]
            panel_times: Vec::new(),
            bytes: 0,
        }
    }

    /// Plays one step.
    pub fn step(&mut self) {
        let world = self.app.world_mut();
        let clock = *world.resource::<Clock>();
        raiders::step(world, clock);
        trebuchet::step(world, clock);
        drawbridge::step(world, clock);
        lift::step(world, clock);
        moat::step(world, clock);
        hill::step(world, clock);
        guard::step(world, clock);
        self.keeper.step(world, clock, &mut self.faults);
        let start = Instant::now();
        if let Err(error) = drystone::step(world, clock.dt) {
            self.faults.push(error.to_string());
        }
        self.times.push(start.elapsed());
        #[cfg(feature = "ui")]
        self.panel_times.push(panel::frame(world));
        drain::<BodyError>(world, &mut self.faults);
        drain::<JointError>(world, &mut self.faults);
        let bonds = count::<MortarBroke>(world);
        let bricks = count::<Fractured>(world);
        let collapses = count::<Collapse>(world);
        let mut tally = world.resource_mut::<Tally>();
        tally.bonds_broken += bonds;
        tally.bricks_broken += bricks;
        tally.collapses += collapses;
        look_for_lost(world, clock, &mut self.faults);
        world.resource_mut::<Clock>().step += 1;
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
            keeper: keeper::Keeper::default(),
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

/// Counts messages.
fn count<M: Message>(world: &mut World) -> u32 {
    world.resource_mut::<Messages<M>>().drain().count() as u32
}

/// Takes errors as faults.
fn drain<M: Message + Display>(world: &mut World, faults: &mut Vec<String>) {
    let mut messages = world.resource_mut::<Messages<M>>();
    faults.extend(messages.drain().map(|error| error.to_string()));
}

/// Every second: no body is below the ground or beyond all reach.
fn look_for_lost(world: &mut World, clock: Clock, faults: &mut Vec<String>) {
    if !clock.strikes(0.0, 1.0) {
        return;
    }
    let mut bodies = world.query::<(Entity, &Pose, &RigidBody)>();
    for (body, pose, kind) in bodies.iter(world) {
        let lost = !pose.is_finite() || pose.position.y < -0.2 || pose.position.length() > 300.0;
        if lost && *kind == RigidBody::Dynamic {
            faults.push(format!(
                "{body} is lost at {} after {:.0} s",
                pose.position,
                clock.seconds()
            ));
        }
    }
}
