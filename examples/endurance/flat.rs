//! Whether memory and time stay flat.

use drystone_lab::memory;
use std::error::Error;
use std::time::Instant;

/// Number of parts that a simulation is divided into.
pub const PARTS: usize = 12;

/// Parts at the beginning that are not compared: memory grows until all of it is in use for the first time.
const WARM: usize = 2;

/// Growth that does not count, as a share. The machine does other work too, so that times vary.
const GROWTH: f64 = 0.05;
const SLOWDOWN: f64 = 0.25;

/// Memory and time of each part of a long simulation.
pub struct Parts {
    start: Instant,
    parts: Vec<Part>,
}

struct Part {
    /// Resident, MB.
    memory: f64,
    /// A step, ms.
    step: f64,
}

impl Parts {
    /// Begins the first part, and prints the head of a table.
    pub fn begin() -> Self {
        println!("| part | bodies | resident, MB | a step, ms |\n|---|---|---|---|");
        Self {
            start: Instant::now(),
            parts: Vec::new(),
        }
    }

    /// Ends a part of so many steps, prints its row, and begins the next.
    ///
    /// # Errors
    /// If the memory of this process cannot be read.
    pub fn end(&mut self, steps: usize, bodies: usize) -> Result<(), Box<dyn Error>> {
        let part = Part {
            memory: 1e-3 * memory::resident()?,
            step: 1e3 * self.start.elapsed().as_secs_f64() / steps as f64,
        };
        println!(
            "| {} | {bodies} | {:.1} | {:.3} |",
            self.parts.len() + 1,
            part.memory,
            part.step
        );
        self.parts.push(part);
        self.start = Instant::now();
        Ok(())
    }

    /// Compares the last half with the first parts after the warm-up.
    ///
    /// # Errors
    /// If memory or time has grown.
    pub fn are_flat(&self) -> Result<(), Box<dyn Error>> {
        let (early, late) = self.parts[WARM..].split_at((self.parts.len() - WARM) / 2);
        let most = |parts: &[Part]| parts.iter().map(|part| part.memory).fold(0.0, f64::max);
        let median = |parts: &[Part]| {
            let mut steps: Vec<f64> = parts.iter().map(|part| part.step).collect();
            steps.sort_by(f64::total_cmp);
            steps[steps.len() / 2]
        };
        let (memory, time) = (most(late) / most(early), median(late) / median(early));
        println!("\nlate over early: memory {memory:.3}, time {time:.3}");
        if memory > 1.0 + GROWTH {
            return Err(format!("memory grew to {memory:.3} times").into());
        }
        if time > 1.0 + SLOWDOWN {
            return Err(format!("a step takes {time:.3} times as long").into());
        }
        Ok(())
    }
}
