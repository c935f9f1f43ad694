//! What is printed.

use crate::driver::RolledBack;
use crate::duel::Outcome;
use std::fmt;
use std::time::Duration;

/// Statistics of rollbacks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Number of rollbacks.
    pub count: usize,
    /// Frames of the longest.
    pub longest: i32,
    /// Mean time.
    pub mean: Duration,
    /// The 99th percentile of the times.
    pub p99: Duration,
    /// The longest time.
    pub max: Duration,
    /// Mean time to load, to save, and to simulate.
    pub parts: [Duration; 3],
}

impl Times {
    /// Of these rollbacks. All are zero if there are none.
    pub fn of<'a>(rollbacks: impl IntoIterator<Item = &'a RolledBack>) -> Self {
        let rollbacks: Vec<&RolledBack> = rollbacks.into_iter().collect();
        let mut times: Vec<Duration> = rollbacks.iter().map(|back| back.time).collect();
        times.sort_unstable();
        let count = times.len();
        let mean = |of: fn(&RolledBack) -> Duration| {
            let total: Duration = rollbacks.iter().map(|back| of(back)).sum();
            total / count.max(1) as u32
        };
        let parts = [
            mean(|back| back.load),
            mean(|back| back.save),
            mean(|back| back.time - back.load - back.save),
        ];
        Self {
            count,
            parts,
            longest: rollbacks.iter().map(|back| back.frames).max().unwrap_or(0),
            mean: mean(|back| back.time),
            p99: times.get(count * 99 / 100).copied().unwrap_or_default(),
            max: times.last().copied().unwrap_or_default(),
        }
    }
}

/// `number | frames | mean, ms | of that load + save + simulate | 99th percentile, ms | longest, ms`
impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |time: Duration| 1e3 * time.as_secs_f64();
        let [mean, p99, max] = [self.mean, self.p99, self.max].map(ms);
        let [load, save, steps] = self.parts.map(ms);
        let Self { count, longest, .. } = self;
        write!(
            f,
            "{count} | {longest} | {mean:.2} | {load:.2} + {save:.2} + {steps:.2} | {p99:.2} | {max:.2}"
        )
    }
}

/// The head of a table of rollbacks.
pub const HEAD: &str = "| | rollbacks | frames of the longest | mean, ms | of that: load + save + simulate | 99th percentile, ms | \
    longest, ms |\n|---|---|---|---|---|---|---|";

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEAD}")?;
        for (number, player) in self.players.iter().enumerate() {
            writeln!(f, "| player {number} | {} |", Times::of(&player.rollbacks))?;
        }
        writeln!(f)?;
        for (number, player) in self.players.iter().enumerate() {
            let traffic = player.traffic;
            let share = 100.0 * traffic.lost as f64 / traffic.packets.max(1) as f64;
            writeln!(
                f,
                "player {number}: {} packets sent, {} lost ({share:.1} %), {} bytes a packet; waited {} times in {} frames; frame {} has \
                 the checksum {:016x}",
                traffic.packets,
                traffic.lost,
                traffic.bytes / traffic.packets.max(1),
                player.waited,
                self.frame,
                self.frame,
                player.checksum,
            )?;
        }
        writeln!(f, "without network and rollbacks: {:016x}", self.reference)?;
        for (number, player) in self.players.iter().enumerate() {
            if let Some(desync) = player.desync {
                let frame = desync.frame;
                writeln!(
                    f,
                    "player {number}: ggrs reports a difference in frame {frame}"
                )?;
            }
        }
        match self.differs {
            Some(frame) => write!(f, "DESYNC: the players differ from frame {frame} on"),
            None if !self.is_in_sync() => write!(f, "DESYNC: the game without rollbacks differs"),
            None => write!(f, "in sync: all checksums of both players are equal"),
        }
    }
}
