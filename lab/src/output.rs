//! The output folder of an example. It is tested before anything is computed, and an error names it.

use std::fs::{self, File};
use std::path::Path;

/// Makes the folder, and `runs.jsonl` in it.
///
/// # Errors
/// A sentence with the folder's name, where it cannot be written.
pub fn begin(out: &Path) -> Result<File, String> {
    fs::create_dir_all(out)
        .and_then(|()| File::create(out.join("runs.jsonl")))
        .map_err(|why| {
            format!(
                "--out {}: nothing can be written there: {why}",
                out.display()
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_is_named() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        // The second is there, but takes no files.
        for out in [file.join("x"), file, "/proc/x".into(), "/proc".into()] {
            let error = begin(&out).expect_err("no folder");
            assert!(error.contains(&out.display().to_string()), "{error}");
        }
    }
}
