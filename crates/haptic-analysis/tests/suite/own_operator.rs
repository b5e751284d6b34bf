//! Operators of one's own, judged as those that have names.

use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{FrequencyResponse, FullMemory, Seconds};
use haptic_analysis::{AnalysisError, LoopOperator};
use testkit::operator::{operator, order};

const T: Seconds = Seconds(1e-3);

fn assert_same_response(a: &LoopOperator, b: &LoopOperator, tolerance: f64) {
    for k in 0..=200_u32 {
        let theta = std::f64::consts::PI * f64::from(k) / 200.0;
        let (a, b) = (a.response(theta), b.response(theta));
        assert!((a - b).norm() <= tolerance, "{theta}: {a} {b}");
    }
}

#[test]
fn a_design_of_ones_own_is_judged_as_the_operator_that_runs_it() {
    for mu in [0.2247, 0.9, 1.5] {
        let design = Design::<16, 48>::pruned(Kernel::Grunwald, order(mu), 1e-6, 1e5);
        let design = design.expect("modes");
        let judged = LoopOperator::from_design(&design).expect("in range");
        let runs = FullMemory::<f64, 16, 48>::new(&design, T).expect("in range");
        for k in 0..=200_u32 {
            let theta = std::f64::consts::PI * f64::from(k) / 200.0;
            let (have, want) = (judged.response(theta), runs.response(theta));
            assert!((have - want).norm() <= 1e-13, "{theta}: {have} {want}");
        }
        assert_same_response(&judged, &operator("full:1e-6", mu), 1e-5);
    }
    let integral = Design::<16, 48>::closed_form(Kernel::Grunwald, order(-0.5), 1e-6, 1e5);
    let error = LoopOperator::from_design(&integral.expect("modes")).expect_err("a pole at rest");
    let range = |error: &AnalysisError| matches!(error, AnalysisError::Range(range) if range.what == "order");
    assert!(range(&error), "{error}");
}
