//! Reads the sources of the library: a module imports only modules that stand before it in `docs/layers.md`.
//!
//! An import is a path that begins with `crate::`, wherever it stands in the code. Unit tests may import anything.

use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The modules, in the order of the list.
fn layers() -> Vec<String> {
    let page = read(&root().join("docs/layers.md"));
    let list = page.split("```").nth(1).expect("the list is in a block");
    let lines = list.lines().filter(|line| line.starts_with(' '));
    let names = lines.filter_map(|line| line.split_whitespace().next());
    names.map(str::to_owned).collect()
}

/// The files with code in a folder, without unit tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|of| of == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
}

/// The code of a file: without comments and without unit tests. Line breaks stay.
fn code(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod tests {");
    let lines = text[..end.unwrap_or(text.len())].lines();
    let lines = lines.map(|line| {
        let comments = line.match_indices("//").map(|(at, _)| at);
        let in_code = |at: &usize| line[..*at].matches('"').count() % 2 == 0;
        let end = comments.into_iter().find(in_code);
        &line[..end.unwrap_or(line.len())]
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn name_at(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// The names that follow `crate::` at the start of a text: one, or several in braces.
fn names(text: &str) -> Vec<&str> {
    let Some(group) = text.strip_prefix('{') else {
        return vec![name_at(text)];
    };
    let (mut names, mut depth, mut is_next) = (Vec::new(), 0, true);
    for (at, c) in group.char_indices() {
        match c {
            '}' if depth == 0 => break,
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => is_next = true,
            _ if is_next && !c.is_whitespace() => {
                names.push(name_at(&group[at..]));
                is_next = false;
            }
            _ => (),
        }
    }
    names
}

/// What a file imports, with the line.
fn imports(code: &str) -> Vec<(usize, &str)> {
    let paths = code.match_indices("crate::");
    let paths = paths.filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric()));
    let found = paths.flat_map(|(at, path)| {
        let line = 1 + code[..at].matches('\n').count();
        let names = names(&code[at + path.len()..]);
        names.into_iter().map(move |name| (line, name))
    });
    found.collect()
}

/// The module that a name at the root of the library comes from.
fn owner<'a>(layers: &'a [String], lib: &str, name: &str) -> Option<&'a String> {
    if let Some(module) = layers.iter().find(|module| **module == name) {
        return Some(module);
    }
    layers.iter().find(|module| {
        let named = format!("pub use {module}::");
        let reexports = lib.lines().filter_map(|line| line.strip_prefix(&named));
        let file = root().join(format!("src/{module}.rs"));
        let defines = |kind| read(&file).contains(&format!("pub {kind} {name}"));
        reexports.into_iter().any(|names| match names {
            "*;" => ["struct", "fn"].into_iter().any(defines),
            names => names
                .split(|c: char| !c.is_alphanumeric())
                .any(|of| of == name),
        })
    })
}

#[test]
fn imports_lead_to_modules_that_stand_before() {
    let src = root().join("src");
    let (layers, lib) = (layers(), read(&src.join("lib.rs")));
    let rank = |module: &str| layers.iter().position(|of| of == module);
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut wrong = Vec::new();
    let mut count = 0;
    for path in files {
        let file = path.strip_prefix(&src).unwrap();
        let module = file.iter().next().unwrap().to_str().unwrap();
        let module = module.trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        for (line, name) in imports(&code(&read(&path))) {
            let Some(owner) = owner(&layers, &lib, name).filter(|owner| *owner != module) else {
                continue;
            };
            count += 1;
            if rank(owner) > rank(module) {
                wrong.push(format!(
                    "src/{}:{line}: {module} -> {owner}",
                    file.display()
                ));
            }
        }
    }
    assert!(count > 500, "only {count} imports were found");
    wrong.sort();
    assert!(wrong.is_empty(), "imports lead back:\n{}", wrong.join("\n"));
}

#[test]
fn every_module_is_on_the_list() {
    let lib = read(&root().join("src/lib.rs"));
    let lines = lib.lines().map(|line| line.trim_start_matches("pub "));
    let modules = lines.filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    let mut modules: Vec<&str> = modules.collect();
    let mut listed = layers();
    modules.sort_unstable();
    listed.sort_unstable();
    assert_eq!(listed, modules);
}

#[test]
fn imports_are_found_in_groups_and_attributes_but_not_in_comments() {
    let text = "use crate::{body::{Pose, Velocity}, graph};\n\
        // crate::plugin\n\
        #[serde(with = \"crate::stored::tree\")] // crate::plugin\n\
        let link = \"https://\" + crate::ask();\n\
        #[cfg(test)]\nmod tests {\n    use crate::plugin;\n}";
    let text = code(text);
    assert_eq!(
        imports(&text),
        [(1, "body"), (1, "graph"), (3, "stored"), (4, "ask")]
    );
}
