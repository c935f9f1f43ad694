//! Episodes: rolled, done, and cut down where they fail.

use crate::check::{Fault, Watch, innocent};
use crate::dice::{Dice, spoils};
use crate::operation::{Act, EDITS, Operation, Spawn};
use crate::site::Site;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;
use std::time::{Duration, Instant};

/// Operations in an episode.
pub const LENGTH: usize = 400;
/// How often an episode that fails is done again to cut it down.
const CUTS: usize = 400;
/// Longer than any step of so few bodies may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// All faults that were found.
#[derive(Default)]
pub struct Tally {
    operations: usize,
    faults: BTreeMap<String, Found>,
}

/// The first episode that failed in some way.
struct Found {
    seed: u64,
    times: usize,
    fault: Fault,
    acts: Vec<Act>,
}

/// # Panics
/// If something was not as it must be, with everything that is known of it.
pub fn fuzz(seeds: Range<u64>) {
    let start = Instant::now();
    let mut tally = Tally::default();
    for seed in seeds {
        episode(seed, &mut tally);
        if seed % 1000 == 999 {
            tally.count(start);
        }
    }
    tally.count(start);
    tally.tell();
}

pub fn episode(seed: u64, tally: &mut Tally) {
    let mut acts = roll(seed);
    let Some((done, fault)) = fails(seed, &acts) else {
        tally.operations += acts.len();
        return;
    };
    tally.operations += done;
    if let Some(found) = tally.faults.get_mut(&fault.kind) {
        found.times += 1;
        return;
    }
    acts.truncate(done);
    cut(seed, &mut acts, &fault.kind);
    let fault = fails(seed, &acts).map_or(fault, |(_, fault)| fault);
    tally.faults.insert(
        fault.kind.clone(),
        Found {
            seed,
            times: 1,
            fault,
            acts,
        },
    );
}

/// Each episode does only some of what can be done, so that rare things are done often in some.
pub fn roll(seed: u64) -> Vec<Act> {
    let (mut dice, spoils) = (Dice::new(seed), spoils(seed));
    let edits: Vec<usize> = (0..EDITS).filter(|_| dice.chance(0.4)).collect();
    let steps = dice.within(0.2, 0.8);
    let mut next = |i: usize| {
        dice.spoiled = false;
        let operation = if i < 8 || dice.chance(0.02) {
            Operation::Spawn(Spawn::roll(&mut dice))
        } else if edits.is_empty() || dice.chance(steps) {
            Operation::step(&mut dice, spoils)
        } else {
            let edit = dice.pick(&edits);
            Operation::roll(edit, &mut dice, spoils)
        };
        let bad = dice.spoiled;
        Act { operation, bad }
    };
    (0..LENGTH).map(&mut next).collect()
}

/// How many operations were done when something was wrong, and what.
fn fails(seed: u64, acts: &[Act]) -> Option<(usize, Fault)> {
    let mut site = Site::new(spoils(seed));
    let mut watch = Watch::default();
    for (i, act) in acts.iter().enumerate() {
        watch.count(&site);
        let start = Instant::now();
        let found = guarded(|| match site.act(act) {
            true => watch.look(&mut site),
            false => Ok(()),
        });
        if let Err(fault) = found {
            return Some((i + 1, fault));
        }
        if start.elapsed() > PATIENCE {
            let kind = "it takes for ever".to_owned();
            let detail = format!("{:?}", start.elapsed());
            return Some((i + 1, Fault { kind, detail }));
        }
    }
    None
}

/// Episodes in which observers do anything to guests while the world takes a step. What holds for guests otherwise need not hold then; but
/// nothing panics, and the innocent are not affected.
///
/// # Panics
/// If that is not so, with everything that is known of it.
pub fn misbehave(seeds: Range<u64>) {
    for seed in seeds {
        let mut site = Site::new(spoils(seed));
        site.misbehave(seed);
        let acts = roll(seed);
        for (i, act) in acts.iter().enumerate() {
            let found = guarded(|| {
                let is_step = site.act(act);
                site.count();
                match is_step {
                    true => innocent(&mut site),
                    false => Ok(()),
                }
            });
            if let Err(fault) = found {
                _ = panic::take_hook();
                panic!("seed {seed}, operation {i}, {act:?}: {fault:?}");
            }
        }
    }
}

/// Removes operations that are not needed to fail in the same way: halves, quarters, and so on.
fn cut(seed: u64, acts: &mut Vec<Act>, kind: &str) {
    let mut left = CUTS;
    let mut size = acts.len() / 2;
    while size > 0 && left > 0 {
        let mut at = 0;
        while at < acts.len() && left > 0 {
            let end = acts.len().min(at + size);
            let mut fewer = acts.clone();
            fewer.drain(at..end);
            left -= 1;
            match fails(seed, &fewer) {
                Some((done, fault)) if fault.kind == kind => {
                    fewer.truncate(done);
                    *acts = fewer;
                }
                _ => at = end,
            }
        }
        size /= 2;
    }
}

thread_local! {
    /// The location of the last panic.
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// A panic as a fault.
fn guarded(act: impl FnOnce() -> Result<(), Fault>) -> Result<(), Fault> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        panic::set_hook(Box::new(|info| {
            let place = info
                .location()
                .map_or_else(String::new, ToString::to_string);
            // For a file of a dependency, only its path inside the crate.
            let place = place.rsplit("/src/").next().unwrap_or(&place).to_owned();
            PANIC.set(Some(place));
        }));
    });
    match panic::catch_unwind(AssertUnwindSafe(act)) {
        Ok(found) => found,
        Err(cause) => {
            let text = cause
                .downcast_ref::<String>()
                .cloned()
                .or_else(|| cause.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            Err(Fault {
                kind: format!("panic at {}", PANIC.take().unwrap_or_default()),
                detail: text.unwrap_or_default(),
            })
        }
    }
}

impl Tally {
    fn count(&self, start: Instant) {
        let kinds: Vec<&String> = self.faults.keys().collect();
        let time = start.elapsed().as_secs();
        println!(
            "{} operations in {time} s, faults: {kinds:?}",
            self.operations
        );
    }

    /// # Panics
    /// If there is something to tell.
    pub fn tell(&self) {
        let mut text = String::new();
        for Found {
            seed,
            times,
            fault,
            acts,
        } in self.faults.values()
        {
            let Fault { kind, detail } = fault;
            writeln!(
                text,
                "{kind} ({times} times, first in seed {seed}): {detail}"
            )
            .expect("a string takes all");
            for Act { operation, .. } in acts {
                writeln!(text, "    {operation:?}").expect("a string takes all");
            }
        }
        if !text.is_empty() {
            _ = panic::take_hook();
            panic!("{text}");
        }
    }
}
