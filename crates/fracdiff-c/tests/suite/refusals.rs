//! Lists that are of no operator.

use super::build;
use fracdiff_c::{Header, HeaderError};

#[test]
fn a_list_that_is_none_is_refused() {
    let good = build::<f32>("full", 0.5).list().expect("a list");
    assert!(Header::new("half", &good, &[]).is_ok());
    let mut short = good.clone();
    short.values.pop();
    let mut integer = good.clone();
    integer.integer = 3;
    for wrong in [short, integer] {
        let error = Header::new("half", &wrong, &[]).expect_err("no operator");
        assert!(matches!(error, HeaderError::List { .. }), "{error}");
    }
    let mut infinite = good;
    infinite.values[3] = f32::INFINITY;
    let error = Header::new("half", &infinite, &[]).expect_err("no number");
    assert_eq!(
        error.to_string(),
        "coefficient 3 is inf, which is not finite"
    );
    let mut taps = build::<f32>("muir:3", 0.5).list().expect("a list");
    taps.integer = 1;
    assert!(Header::new("half", &taps, &[]).is_err());
}
