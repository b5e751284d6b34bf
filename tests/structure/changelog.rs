//! A merge leaves lines twice, and nobody reads them twice.

use std::collections::BTreeSet;

#[test]
fn no_line_of_the_changelog_stands_twice() {
    let text = std::fs::read_to_string(super::root().join("CHANGELOG.md")).expect("a changelog");
    let mut seen = BTreeSet::new();
    let mut changes = text
        .lines()
        .filter(|line| line.starts_with("- "))
        .peekable();
    assert!(changes.peek().is_some());
    let twice: Vec<&str> = changes.filter(|line| !seen.insert(*line)).collect();
    assert!(twice.is_empty(), "{twice:#?}");
}
