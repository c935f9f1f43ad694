//! What the report was made with: the commit, the compiler and the machine.

use std::fs;
use std::process::Command;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The first line that a command prints. `None` if it cannot be run or fails.
fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let mut command = Command::new(program);
    let output = command.args(arguments).current_dir(root).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output
        .status
        .success()
        .then(|| text.lines().next().unwrap_or_default().to_owned())
}

/// The commit, and whether files differ from it.
fn commit() -> Option<String> {
    let hash = first_line("git", &["log", "-1", "--format=%H, %cs"])?;
    let changed = first_line("git", &["status", "--porcelain"])?;
    Some(match changed.is_empty() {
        true => hash,
        false => format!("{hash}, with changes that are not committed"),
    })
}

fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Names and values. What cannot be found out is called unknown.
pub fn facts(took: Duration) -> Vec<Vec<String>> {
    let unknown = || "unknown".to_owned();
    let cores = thread::available_parallelism().map_or_else(|_| unknown(), |n| n.to_string());
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let date = now.ok().and_then(|now| {
        let at = format!("@{}", now.as_secs());
        first_line("date", &["-u", "-d", &at, "+%Y-%m-%d %H:%M UTC"])
    });
    let profile = match cfg!(debug_assertions) {
        true => "dev, which optimizes the library",
        false => "release",
    };
    let facts = [
        ("commit", commit().unwrap_or_else(unknown)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        (
            "compiler",
            first_line("rustc", &["--version"]).unwrap_or_else(unknown),
        ),
        ("profile", profile.to_owned()),
        ("processor", processor().unwrap_or_else(unknown)),
        ("cores", cores),
        (
            "system",
            format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        ),
        ("date", date.unwrap_or_else(unknown)),
        (
            "command",
            std::env::args()
                .skip(1)
                .fold("paper".into(), |a, b| a + " " + &b),
        ),
        ("time of all runs", format!("{:.1} s", took.as_secs_f32())),
    ];
    facts.map(|(name, value)| vec![name.into(), value]).into()
}
