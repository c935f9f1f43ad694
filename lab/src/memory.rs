//! The memory of this process, as the operating system counts it. Linux only.

use std::fs;
use std::io::{Error, ErrorKind};

/// Memory of this process that is resident, kB.
///
/// # Errors
/// If `/proc/self/status` cannot be read.
pub fn resident() -> Result<f64, Error> {
    status("VmRSS")
}

/// The most memory of this process that has been resident, kB.
///
/// # Errors
/// If `/proc/self/status` cannot be read.
pub fn peak() -> Result<f64, Error> {
    status("VmHWM")
}

/// A number of this process in `/proc/self/status`.
fn status(name: &str) -> Result<f64, Error> {
    let text = fs::read_to_string("/proc/self/status")?;
    let line = text.lines().find(|line| line.starts_with(name));
    let number = line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
    number.ok_or_else(|| Error::new(ErrorKind::InvalidData, "this system counts no memory"))
}
