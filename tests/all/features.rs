//! The table of features: the tests, examples and pages that it names are there.

use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The sources of the modules of a name, in all binaries.
fn modules(path: &str) -> Vec<String> {
    let names = [
        format!("all/{path}.rs"),
        format!("all/{path}/mod.rs"),
        format!("everyday/{path}.rs"),
        format!("scenes/{path}.rs"),
        format!("{path}.rs"),
    ];
    let files = names.map(|name| root().join("tests").join(name));
    let sources = files.iter().filter_map(|file| read_to_string(file).ok());
    sources.collect()
}

/// Whether a path, or a test as `module::test`, is in the repository.
fn exists(evidence: &str) -> bool {
    match evidence.rsplit_once("::") {
        Some((path, test)) => {
            let sources = modules(&path.replace("::", "/"));
            let function = format!("fn {test}()");
            sources.iter().any(|source| {
                // The scenes of the matrix are on a list, and their tests are made from it.
                let listed = source.split_once("\nmatrix! {").map(|(_, list)| list);
                let mut listed = listed
                    .into_iter()
                    .flat_map(|list| list.split([' ', ',', ';', '\n']));
                source.contains(&function) || listed.any(|name| name == test)
            })
        }
        None => root().join(evidence).exists(),
    }
}

#[test]
fn all_evidence_exists() {
    let page = read_to_string(root().join("docs/features.md")).expect("the page is there");
    let mut rows = 0;
    for line in page.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [_, has, evidence, ..] = cells[..] else {
            panic!("{line}");
        };
        assert_eq!(cells.len(), 5, "{line}");
        if has == "drystone" {
            continue;
        }
        rows += 1;
        let named: Vec<&str> = evidence.split('`').skip(1).step_by(2).collect();
        assert!(has.starts_with("no") || !named.is_empty(), "{line}");
        for named in named {
            assert!(exists(named), "{named} of {line}");
        }
    }
    assert!(rows > 80, "{rows}");
}
