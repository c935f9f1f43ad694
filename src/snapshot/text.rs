//! Values as `Debug` writes them, taken apart into their fields.
//!
//! Every part of the state has a `Debug` form with all of its fields, reflected or not. Its pretty form has one field a line.

/// Names of types of which each value is used once, so that two of them never agree.
const UNIQUE_TYPES: [&str; 2] = ["Revision(", "Tick {"];

/// A value with its fields.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Tree {
    /// The name of its field, or nothing for an element of a list.
    name: String,
    /// Its type, or its value if it has no fields.
    head: String,
    fields: Vec<Self>,
}

impl Tree {
    /// Takes a pretty `Debug` form apart.
    pub fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        Self::of(first, &mut lines)
    }

    fn of<'a>(line: &str, lines: &mut impl Iterator<Item = &'a str>) -> Self {
        let line = line.trim().trim_end_matches(',');
        let (name, head) = match line.split_once(": ") {
            Some((name, head)) => (name, head),
            None => ("", line),
        };
        let mut fields = Vec::new();
        if head.ends_with(['{', '(', '[']) {
            while let Some(line) = lines.next() {
                if line.trim_start().starts_with(['}', ')', ']']) {
                    // The key of a map may have fields of its own; its value follows.
                    if let Some((_, value)) = line.split_once(": ") {
                        let value = Self::of(value, lines);
                        fields.push(value);
                    }
                    break;
                }
                fields.push(Self::of(line, lines));
            }
        }
        let mut tree = Self {
            name: name.to_owned(),
            head: head.to_owned(),
            fields,
        };
        if UNIQUE_TYPES.contains(&&*tree.head) {
            tree.fields.clear();
        }
        // The order of a set or map has no meaning.
        if tree.head == "{" {
            tree.fields.sort_by_cached_key(|field| format!("{field:?}"));
        }
        tree
    }

    /// The way to the first field that differs, and the two values.
    pub fn first_difference(&self, other: &Self) -> Option<(String, [Option<String>; 2])> {
        // Revisions are not compared, so a missing one is the same as an outdated one.
        if self == other || self.is_optional_revision() || other.is_optional_revision() {
            return None;
        }
        if self.head != other.head || self.fields.len() != other.fields.len() {
            let values = [self, other].map(|tree| Some(tree.short()));
            return Some((String::new(), values));
        }
        let fields = self.fields.iter().zip(&other.fields).enumerate();
        let mut found = fields.filter_map(|(i, (a, b))| Some((i, a, a.first_difference(b)?)));
        let (i, field, (way, values)) = found.next()?;
        let step = match (&*field.name, self.head.ends_with('(')) {
            ("", true) if self.fields.len() == 1 => String::new(),
            ("", true) => format!(".{i}"),
            ("", false) => format!("[{i}]"),
            (name, _) => format!(".{name}"),
        };
        Some((format!("{step}{way}"), values))
    }

    fn is_optional_revision(&self) -> bool {
        self.head == "Some("
            && self
                .fields
                .iter()
                .all(|of| UNIQUE_TYPES.contains(&&*of.head))
    }

    fn short(&self) -> String {
        match self.fields.len() {
            0 => self.head.clone(),
            count => format!("{} {count} fields", self.head),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::revision::Revision;
    use glam::Vec3;
    use std::collections::HashSet;

    #[derive(Debug)]
    #[expect(dead_code, reason = "only `Debug` reads the fields")]
    struct Wall {
        name: &'static str,
        bricks: Vec<Option<Vec3>>,
        revision: Option<Revision>,
        tags: HashSet<u32>,
    }

    fn wall(y: f32, tags: [u32; 3]) -> Wall {
        Wall {
            name: "a: b",
            bricks: vec![None, Some(Vec3::new(1.0, y, 0.0))],
            revision: Some(Revision::next()),
            tags: HashSet::from(tags),
        }
    }

    fn parse(wall: &Wall) -> Tree {
        Tree::parse(&format!("{wall:#?}"))
    }

    #[test]
    fn the_first_field_that_differs_is_named() {
        let trees = [wall(0.0, [1, 2, 3]), wall(-0.0, [1, 2, 3])].map(|wall| parse(&wall));
        let (field, values) = trees[0].first_difference(&trees[1]).unwrap();
        assert_eq!(field, ".bricks[1].1");
        assert_eq!(values.map(Option::unwrap), ["0.0", "-0.0"]);
    }

    #[test]
    fn revisions_and_the_order_of_sets_do_not_matter() {
        let trees = [wall(0.5, [1, 2, 3]), wall(0.5, [3, 1, 2])].map(|wall| parse(&wall));
        assert_eq!(trees[0].first_difference(&trees[1]), None);
    }

    #[test]
    fn lists_of_other_lengths_differ() {
        let mut longer = wall(0.5, [1, 2, 3]);
        longer.bricks.push(None);
        let trees = [wall(0.5, [1, 2, 3]), longer].map(|wall| parse(&wall));
        let (field, values) = trees[0].first_difference(&trees[1]).unwrap();
        assert_eq!(field, ".bricks");
        assert_eq!(values.map(Option::unwrap), ["[ 2 fields", "[ 3 fields"]);
    }
}
