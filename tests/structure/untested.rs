//! A library that is not built for tests of its own has none; a test that `cargo test` leaves out is done elsewhere.

use super::files;

#[test]
fn no_test_stands_where_none_is_run() {
    let mut looked_at = 0;
    for (name, folder) in super::crates() {
        let manifest = super::manifest(&folder);
        let run = manifest.get("lib").and_then(|lib| lib.get("test"));
        if run.and_then(toml::Value::as_bool) != Some(false) {
            continue;
        }
        looked_at += 1;
        let mut sources = Vec::new();
        files(&folder.join("src"), &mut sources);
        for file in sources {
            let text = std::fs::read_to_string(&file).expect("a text");
            assert!(
                !text.contains("#[test]"),
                "{name}: {} holds tests, and `test = false` leaves them out",
                file.display()
            );
        }
    }
    assert!(looked_at > 3, "{looked_at}");
}

/// Why a test is left out of `cargo test`, and the words of the script that does it.
const LEFT_OUT: [(&str, &str, &str); 2] = [
    (
        "long: `.ci/run` does it, or --include-ignored",
        "run",
        "-- --ignored --skip by_night",
    ),
    (
        "by night: `.ci/nightly` does it",
        "nightly",
        "-- --include-ignored --nocapture",
    ),
];

#[test]
fn a_test_that_is_left_out_is_done_elsewhere() {
    let root = super::root();
    let mut sources = Vec::new();
    for folder in ["crates", "tests"] {
        files(&root.join(folder), &mut sources);
    }
    let mut counts = [0; 2];
    for file in sources {
        let text = std::fs::read_to_string(&file).expect("a text");
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for (at, line) in lines.iter().enumerate() {
            let Some(reason) = line.strip_prefix("#[ignore = \"") else {
                continue;
            };
            let reason = reason.trim_end_matches("\"]");
            let known = LEFT_OUT.iter().position(|(why, ..)| *why == reason);
            let kind = known.unwrap_or_else(|| panic!("{}: {reason}", file.display()));
            counts[kind] += 1;
            let name = lines[at..].iter().find(|line| line.contains("fn "));
            let named = name.is_some_and(|line| line.starts_with("fn by_night_"));
            assert_eq!(named, kind == 1, "{}: {name:?}", file.display());
        }
    }
    for ((_, script, words), count) in LEFT_OUT.iter().zip(counts) {
        let text = std::fs::read_to_string(root.join(".ci").join(script)).expect("a script");
        assert!(count > 0 && text.contains(words), "{script}: {count}");
    }
}
