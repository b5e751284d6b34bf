//! A library that is not built for tests of its own has none.

use super::length::files;

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
