//! One HTML file with everything: settings, tables, plots and pictures.

use crate::figures;
use crate::html::{page, picture, table, text};
use crate::rows::ROWS;
use crate::runs::Record;
use crate::{claims, machine, numbers, plots, prototype, table as results};
use drystone_lab::metrics::FALLEN;
use serde_json::Value;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Name of the file.
pub const FILE: &str = "report.html";

/// Writes the report into the folder in which plots and figures have been drawn.
pub fn write(records: &[Record], took: Duration, out: &Path) -> Result<(), Box<dyn Error>> {
    let mut body = String::new();
    let mut section = |title: &str, content: String| {
        body += &format!("<h2>{}</h2>\n{content}", text(title));
    };
    section("Subject", subject());
    section("Machine", table(&["", ""], &machine::facts(took)));
    section("The paper's numbers", paper_numbers());
    section("The paper's findings", findings(records));
    section("Results", all_results(records));
    let prototype = prototype::rows(records);
    if !prototype.is_empty() {
        section("Beside a prototype", beside_prototype(&prototype));
    }
    let mut pictures = String::new();
    for (file, caption) in figures::files() {
        pictures += &picture(&out.join(file), caption)?;
    }
    section("Figures", pictures);
    let mut drawn = String::new();
    for (file, caption) in plots::files() {
        drawn += &picture(&out.join(file), &caption)?;
    }
    section("Plots", drawn);
    section("Settings", settings(records));
    let title = "Normal and friction stabilization: the experiments of 2010, repeated";
    fs::write(out.join(FILE), page(title, &body))?;
    Ok(())
}

fn paragraph(plain: &str) -> String {
    format!("<p>{}</p>\n", text(plain))
}

fn subject() -> String {
    paragraph(
        "M. Silcowitz-Hansen, S. Niebe, K. Erleben: Normal and Friction Stabilization Techniques for Interactive Rigid Body \
         Constraint-based Contact Force Computations. VRIPHYS 2010.",
    ) + &paragraph(
        "drystone repeats the experiments of its section 4: stacks, walls, and the task of Figure 1, under the settings of Table 1. \
         Rows 1 to 4 are those of Table 1. A letter marks a row that the paper does not have: it turns on one idea at a time (f: \
         with friction stabilization; s: one-sided Baumgarte, which only pushes).",
    ) + &table(
        &["row", "settings"],
        &ROWS
            .iter()
            .map(|row| vec![row.id.to_owned(), row.label.to_owned()])
            .collect::<Vec<_>>(),
    )
}

fn paper_numbers() -> String {
    paragraph(
        "Every number of the paper's Table 1 and its caption, and the gain of its equation (15). Ours are read from the settings of the \
         runs. The paper prints no measured numbers: it judges its results by eye.",
    ) + &table(&numbers::HEADS, &numbers::rows())
}

fn findings(records: &[Record]) -> String {
    paragraph(
        "The paper compares by eye. Each line takes one of its sentences and a quantity by which it can be judged. A ratio below 1 agrees \
         with the paper. Runs are judged after the first second, in which they settle, and up to where they fall.",
    ) + &table(&claims::HEADS, &claims::rows(records))
}

fn all_results(records: &[Record]) -> String {
    let fallen = format!(
        "Fell: a body was off by more than {} m sideways, {} m down or {} rad. Drift, ideal error, rms speed and tilt are those of the \
         end. In the task (pressed) displacements count from when the hand begins to press. A step's time is the median on one \
         thread, with other runs on the other cores.",
        FALLEN.drift, FALLEN.sag, FALLEN.tilt
    );
    paragraph(&fallen) + &table(&results::HEADS, &results::rows(records))
}

fn beside_prototype(rows: &[Vec<String>]) -> String {
    paragraph(
        "Drift after 60 s, or the time of the fall, beside an independent prototype of the method in double precision with a \
         collision detection of its own. Seeds of the noise differ, so falls are comparable only in kind; – where one falls and the \
         other stands.",
    ) + &table(&prototype::HEADS, rows)
}

/// All settings of the runs, as `runs.jsonl` has them: one column for each row, a line for each setting that is not the same in all scenes.
fn settings(records: &[Record]) -> String {
    let of_row = |id: &str| {
        let record = records.iter().find(|record| record.job.row.id == id)?;
        record.json().get("settings").cloned()
    };
    let columns: Vec<(&str, Value)> = ROWS
        .iter()
        .filter_map(|row| Some((row.id, of_row(row.id)?)))
        .collect();
    let Some(first) = columns.first().and_then(|(_, value)| value.as_object()) else {
        return String::new();
    };
    let mut heads = vec!["setting"];
    heads.extend(columns.iter().map(|(id, _)| *id));
    let lines = first.keys().map(|key| {
        let values = columns.iter().map(|(_, settings)| plain(&settings[key]));
        [key.clone()].into_iter().chain(values).collect()
    });
    let lines: Vec<Vec<String>> = lines.collect();
    let first_scene = records
        .first()
        .map_or_else(String::new, |r| r.job.scene.to_string());
    paragraph(&format!(
        "Settings of each row, here of the scene {first_scene}; other scenes differ in the number of steps alone."
    )) + &table(&heads, &lines)
}

/// A setting as text. Fractions are single precision.
fn plain(value: &Value) -> String {
    match (value, value.as_f64()) {
        (Value::String(plain), _) => plain.clone(),
        (_, Some(number)) if value.is_f64() => (number as f32).to_string(),
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page that loads something is not self-contained.
    #[test]
    fn a_page_loads_nothing() {
        let folder = std::env::temp_dir().join(format!("drystone-paper-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let files = figures::files()
            .into_iter()
            .map(|(file, _)| file.to_owned());
        for file in files.chain(plots::files().into_iter().map(|(file, _)| file)) {
            fs::write(folder.join(file), b"png").unwrap();
        }
        write(&[], Duration::ZERO, &folder).unwrap();
        let page = fs::read_to_string(folder.join(FILE)).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        let sources = page.matches("src=").count();
        assert_eq!(sources, figures::files().len() + plots::files().len());
        assert_eq!(
            page.matches("src=\"data:image/png;base64,").count(),
            sources
        );
        for word in ["<link", "<script", "@import", "url(", "http"] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
