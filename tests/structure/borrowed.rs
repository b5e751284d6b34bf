//! Code that two crates need is a crate, so that an arrow leads to it: no file is included from another folder of sources.

use super::files;
use std::path::PathBuf;

#[test]
fn no_source_is_included_from_another_crate() {
    let mut found = Vec::new();
    for (_, folder) in super::crates() {
        files(&folder.join("src"), &mut found);
    }
    files(&super::root().join("page/wasm/src"), &mut found);
    let borrows = |file: &PathBuf| {
        let text = std::fs::read_to_string(file).expect("a text");
        let mut paths = text.lines().filter(|line| line.starts_with("#[path"));
        paths.any(|path| path.contains("../"))
    };
    assert!(found.len() > 100, "{}", found.len());
    found.retain(borrows);
    assert!(found.is_empty(), "{found:#?}");
}
