//! The Mittag-Leffler function of the library that `haptic-experiment` uses, against mpmath (`golden/make_golden.py`), at the
//! arguments that the models have for 10⁻⁶ ≤ t/τ ≤ 10⁶. Its error is absolute (1.6e-11): it keeps 1e-10 of the value up to a first
//! index of 0.98, and loses digits in the long tail of models that are nearly classical, and below the smallest double.
//! The models here do not use it.

use mittagleffler::MittagLeffler as _;

#[test]
fn the_library_keeps_ten_digits_but_for_nearly_classical_models() {
    let (mut rows, mut worst_absolute) = (0, 0.0_f64);
    for line in include_str!("golden/mittag_leffler.csv").lines().skip(1) {
        let cells: Vec<f64> = line
            .split(',')
            .map(|c| c.parse().expect("number"))
            .collect();
        let &[a, b, z, want] = &cells[..] else {
            panic!("{line}");
        };
        let have = z.mittag_leffler(a, b).map_or(f64::NAN, |v| v.re);
        worst_absolute = worst_absolute.max((have - want).abs());
        if a <= 0.98 {
            assert!((have / want - 1.0).abs() < 1e-10, "{line}: {have}");
            rows += 1;
        }
    }
    assert!(rows > 300, "{rows}");
    assert!(worst_absolute < 1e-10, "{worst_absolute:e}");
}
