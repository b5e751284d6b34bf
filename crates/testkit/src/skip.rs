//! Checks that cannot be done here: what is missing or too slow is said, past the harness, which hides what a passing test
//! prints.

use std::io::Write as _;

/// Says on standard error that this test is skipped, and why.
///
/// # Panics
/// Where `REQUIRE_ALL_CHECKS` is set, as in CI.
pub fn skip(why: &str) {
    assert!(std::env::var_os("REQUIRE_ALL_CHECKS").is_none(), "{why}");
    skip_for_load(why);
}

/// The same of a check by the clock on a machine that is too busy for it, which CI may be too.
pub fn skip_for_load(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("part of a test");
    // One write: lines of other tests do not come between.
    let line = format!("skipped: {test}: {}\n", why.trim());
    let _ = std::io::stderr().write_all(line.as_bytes());
}
