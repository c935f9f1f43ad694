//! What the document has as missed.

use crate::runs::Missed;

/// Mark of a value that is missed.
pub const MARK: &str = "**";

/// The cells of a line of a table.
fn cells(line: &str) -> impl Iterator<Item = &str> {
    let line = line.trim().trim_start_matches('|').trim_end_matches('|');
    line.split('|').map(str::trim)
}

/// Returns true if a document has this value as missed: its cell, in the column of the step, is marked. What a document does not have is
/// not.
pub fn is_missed(document: &str, missed: &Missed) -> bool {
    let tables = document.lines().filter(|line| line.starts_with('|'));
    let mut column = None;
    for line in tables {
        if let Some(i) = cells(line).position(|cell| cell == missed.step) {
            column = Some(i);
        }
        let mut start = cells(line);
        let named = start.next() == Some(&missed.what) && start.next() == Some(missed.solver);
        if let (true, Some(i)) = (named, column) {
            return cells(line).nth(i).is_some_and(|cell| cell.contains(MARK));
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = "
| row | solver | reference | tolerance | 0.1 s | 1/60 s |
|---|---|---|---|---|---|
| 3: box stops, m | Soft Step | 2.5484 | 0.0153 | 2.547 | 2.548 |
| 3: box stops, m | NNCG | 2.5484 | 0.0153 | **2.3022** | 2.548 |
";

    fn missed(what: &str, solver: &'static str, step: &'static str) -> bool {
        let what = what.to_owned();
        is_missed(DOCUMENT, &Missed { what, solver, step })
    }

    #[test]
    fn what_is_marked_was_missed() {
        assert!(missed("3: box stops, m", "NNCG", "0.1 s"));
    }

    #[test]
    fn nothing_else_was_missed() {
        assert!(!missed("3: box stops, m", "NNCG", "1/60 s"));
        assert!(!missed("3: box stops, m", "NNCG", "1/240 s"));
        assert!(!missed("3: box stops, m", "Soft Step", "0.1 s"));
        assert!(!missed("3: disk stops, m", "NNCG", "0.1 s"));
        let found = Missed {
            what: "3: box stops, m".into(),
            solver: "NNCG",
            step: "0.1 s",
        };
        assert!(!is_missed("", &found));
    }
}
