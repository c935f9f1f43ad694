//! Tables as markdown and JSON.

use serde_json::{Value, json};
use std::fmt::{self, Display};

/// A table with a heading.
#[derive(Clone)]
pub struct Table {
    pub title: String,
    /// The contents of the cells, and the conditions.
    pub note: String,
    /// The first heads the names of the rows.
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn json(&self) -> Value {
        json!({ "title": self.title, "note": self.note, "columns": self.columns, "rows": self.rows })
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "### {}\n\n{}\n", self.title, self.note)?;
        writeln!(f, "| {} |", self.columns.join(" | "))?;
        writeln!(f, "|{}", "---|".repeat(self.columns.len()))?;
        for row in &self.rows {
            writeln!(f, "| {} |", row.join(" | "))?;
        }
        Ok(())
    }
}

/// A length in mm, to three digits or a hundredth.
pub fn mm(length: f32) -> String {
    let mm = 1e3 * length;
    match mm.abs() {
        x if x >= 100.0 => format!("{mm:.0}"),
        x if x >= 10.0 => format!("{mm:.1}"),
        _ => format!("{mm:.2}"),
    }
}
