//! Comparisons that say by how much they fail.

/// |have − want| ≤ tolerance.
///
/// # Panics
/// Otherwise; a NaN too.
#[track_caller]
pub fn assert_close(what: &str, have: f64, want: f64, tolerance: f64) {
    let error = (have - want).abs();
    assert!(
        error <= tolerance,
        "{what}: have {have:.15e}, want {want:.15e}, error {error:e} above {tolerance:e}"
    );
}

/// |have − want| ≤ tolerance·|want|.
///
/// # Panics
/// Otherwise; a NaN too.
#[track_caller]
pub fn assert_relative(what: &str, have: f64, want: f64, tolerance: f64) {
    assert!(
        (have - want).abs() <= tolerance * want.abs(),
        "{what}: have {have:.15e}, want {want:.15e}, off by {:.1e}",
        have / want - 1.0
    );
}
