//! A game that is rolled back ends with the same bits, and a broken one is found out.

use bevy_ecs::prelude::*;
use drystone::contact::ContactImpulses;
use drystone::prelude::*;
use drystone_rollback::duel::{Duel, Outcome};
use drystone_rollback::game::{SavedWall, Setup, WallGame};
use drystone_rollback::input::{Action, Input, PLAYERS};
use drystone_rollback::link::Conditions;
use drystone_rollback::player::LONGEST;
use drystone_rollback::rollback::Rollback;
use drystone_rollback::script::Script;
use drystone_rollback::sync_test::sync_test;
use ggrs::{Frame, GgrsError};

/// Small, because the tests are compiled without optimization.
const SETUP: Setup = Setup {
    columns: 5,
    courses: 4,
    ball: 0.25,
    sleeping: true,
    settle: 60,
};

const DUEL: Duel = Duel {
    frames: 120,
    conditions: Conditions {
        delay: std::time::Duration::from_millis(100),
        jitter: std::time::Duration::from_millis(20),
        loss: 0.05,
    },
    seed: 3,
};

const SCRIPT: Script = Script { seed: 5, delay: 0 };

/// A game that loses something each time it is loaded.
struct Broken {
    game: WallGame,
    lose: Fault,
}

impl Broken {
    fn new(lose: Fault) -> Self {
        Self {
            game: WallGame::new(SETUP),
            lose,
        }
    }
}

impl Rollback for Broken {
    type Saved = SavedWall;

    fn save(&self, to: &mut SavedWall) {
        self.game.save(to);
    }

    fn load(&mut self, from: &SavedWall) {
        self.game.load(from);
        (self.lose)(&mut self.game.world);
    }

    fn advance(&mut self, inputs: [Input; PLAYERS]) {
        self.game.advance(inputs);
    }

    fn checksum(&mut self) -> u64 {
        self.game.checksum()
    }
}

fn lose_nothing(_: &mut World) {}

/// The forces of the last step, with which the solver starts.
fn lose_forces(world: &mut World) {
    let mut pairs = world.query::<&mut ContactImpulses>();
    for mut impulses in pairs.iter_mut(world) {
        for point in &mut impulses.points {
            point.normal_force = 0.0;
        }
    }
}

/// How long bodies have been still.
fn lose_rest(world: &mut World) {
    let mut bodies = world.query::<&mut Sleeping>();
    for mut sleeping in bodies.iter_mut(world) {
        sleeping.still_for = 0.0;
    }
}

/// The last bit of the velocities.
fn lose_a_bit(world: &mut World) {
    let mut bodies = world.query::<&mut Velocity>();
    for mut velocity in bodies.iter_mut(world) {
        if velocity.linear.y != 0.0 {
            let bits = velocity.linear.y.to_bits() ^ 1;
            velocity.linear.y = f32::from_bits(bits);
        }
    }
}

type Fault = fn(&mut World);

const FAULTS: [(&str, Fault); 3] = [
    ("forces", lose_forces),
    ("rest", lose_rest),
    ("a bit", lose_a_bit),
];

/// A duel in which the second player loses something in each rollback.
fn duel(duel: Duel, lose: Fault) -> Outcome {
    let games = [Broken::new(lose_nothing), Broken::new(lose)];
    duel.play(games, WallGame::new(SETUP)).unwrap()
}

#[test]
fn a_game_that_is_rolled_back_in_every_frame() {
    const FRAMES: Frame = 80;
    let game = WallGame::new(SETUP);
    let mut driver = sync_test(game, FRAMES, |frame| SCRIPT.inputs(frame)).unwrap();
    assert_eq!(driver.rollbacks.len(), FRAMES as usize - LONGEST - 1);
    assert!(
        driver
            .rollbacks
            .iter()
            .all(|back| back.frames == LONGEST as Frame)
    );
    let [_, bodies] = driver.game.awake();
    let [_, before] = WallGame::new(SETUP).awake();
    assert!(bodies > before + 2, "{bodies} bodies, {before} before");
}

/// Old balls are despawned, and are there again after a rollback, as other entities.
#[test]
fn balls_that_were_despawned_come_back() {
    let shoot: Input = Action::Shoot { aim: [0, 100] }.into();
    let inputs = |frame| match frame {
        2 | 5 => [shoot; PLAYERS],
        _ => [Input::default(); PLAYERS],
    };
    let mut driver = sync_test(WallGame::new(SETUP), 140, inputs).unwrap();
    let [_, bodies] = driver.game.awake();
    assert_eq!(bodies, WallGame::new(SETUP).awake()[1]);
}

#[test]
fn two_players_over_a_bad_connection_end_with_the_same_bits() {
    let outcome = duel(DUEL, lose_nothing);
    assert!(outcome.is_in_sync(), "{outcome}");
    let [a, b] = &outcome.players;
    assert_eq!(a.checksum, b.checksum);
    // Some timers of `ggrs` show real time, so which player waits when, and rolls back how far, differs from run to run.
    let rollbacks = || a.rollbacks.iter().chain(&b.rollbacks);
    let longest = rollbacks().map(|back| back.frames).max();
    assert!(rollbacks().count() >= 6, "{outcome}");
    assert!(longest >= Some(5), "{outcome}");
    for player in [a, b] {
        assert!(player.traffic.lost > 0, "{outcome}");
        // A dozen frames at the start, and a dozen each time that the last packets of both are lost.
        assert!(player.waited < DUEL.frames as usize / 2, "{outcome}");
    }
}

/// On a connection that loses half of the packets, the players wait for each other.
#[test]
fn a_connection_that_is_hardly_one() {
    let mut bad = DUEL;
    bad.frames = 60;
    bad.conditions.loss = 0.5;
    let outcome = duel(bad, lose_nothing);
    assert!(outcome.is_in_sync(), "{outcome}");
    assert!(outcome.players.iter().all(|player| player.waited > 0));
}

#[test]
fn sync_tests_find_what_is_lost() {
    for (name, lose) in FAULTS {
        let found = sync_test(Broken::new(lose), 100, |frame| SCRIPT.inputs(frame));
        let is_found = matches!(found, Err(GgrsError::MismatchedChecksum { .. }));
        assert!(is_found, "{name}");
    }
}

/// `ggrs` tells both players, and the checksums at the end differ.
#[test]
fn players_find_it_out_if_one_of_them_loses_something() {
    let outcome = duel(DUEL, lose_forces);
    assert!(!outcome.is_in_sync(), "{outcome}");
    assert!(outcome.differs.is_some(), "{outcome}");
    let [a, b] = &outcome.players;
    assert_ne!(a.checksum, b.checksum);
    assert_eq!(a.checksum, outcome.reference);
    assert!(a.desync.is_some() && b.desync.is_some(), "{outcome}");
}
