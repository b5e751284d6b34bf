//! `docs/performance.md` is as old as the code that it times.

use std::path::Path;

#[path = "../../benches/table/src/kernels.rs"]
mod kernels;

#[test]
fn no_time_is_older_than_its_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = std::fs::read_to_string(root.join("docs/performance.md")).expect("a document");
    let digest = kernels::digest(root).expect("each kernel is there");
    assert!(
        table.contains(&format!("Kernels `{digest}`")),
        "docs/performance.md is not of kernels {digest}: bash benches/table/run measures them, on a quiet machine"
    );
}
