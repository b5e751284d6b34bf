//! Records that grow so far that what a function lacks is nothing beside their end.

use control_identification::DeadTime;
use control_identification::model_search::{Found, InputOutput, Wanted, candidates, identify};
use std::sync::atomic::{AtomicUsize, Ordering};
use testkit::assert_close;

/// The step of 2/((s − r)(s + 1)) by its closed form, and noise of such a standard deviation.
fn grown(rate: f64, samples: u32, noise: f64) -> InputOutput {
    let mut random = testkit::Random(11);
    let time_s: Vec<f64> = (0..samples).map(|n| 0.05 * f64::from(n)).collect();
    let output = time_s.iter().map(|t| {
        // 2/(r(1 + r))·(e^(rt) − 1) + 2/(1 + r)·(e^(−t) − 1)
        let grows = 2.0 / (rate * (1.0 + rate)) * libm::expm1(rate * t);
        let settles = 2.0 / (1.0 + rate) * libm::expm1(-t);
        grows + settles + noise * random.between(-1.0, 1.0) * libm::sqrt(3.0)
    });
    InputOutput {
        input: vec![1.0; time_s.len()],
        output: output.collect(),
        time_s,
        ..InputOutput::default()
    }
}

fn found(record: &InputOutput) -> Vec<Found> {
    let (guesses, done) = (
        candidates(record, true, None, Wanted::default()),
        AtomicUsize::new(0),
    );
    let count = |more| {
        done.fetch_add(more, Ordering::Relaxed);
    };
    let found = identify(record, &guesses, true, Wanted::default(), &count).expect("found");
    // Every guess is told of, those that others made superfluous too.
    assert_eq!(done.into_inner(), guesses.len());
    found
}

#[test]
fn a_record_that_grows_far_gives_both_of_its_poles_back() {
    for (rate, samples) in [(0.4, 300), (0.4, 600), (0.2, 1000), (0.4, 1200), (1.0, 300)] {
        let record = grown(rate, samples, 0.0);
        let best = &found(&record)[0];
        let function = best.identified.function;
        let what = format!("{rate}, {samples} samples: {function}");
        // 2/(r·(s²/r + (1/r − 1)·s − 1))
        let below = function.denominator().terms();
        let want: &[f64] = if (rate - 1.0).abs() > 0.0 {
            &[1.0 / rate, 1.0 / rate - 1.0, -1.0]
        } else {
            &[1.0, -1.0]
        };
        assert_eq!(below.len(), want.len(), "{what}");
        for (term, want) in below.iter().zip(want) {
            assert!((term.coefficient - want).abs() < 1e-6, "{what}");
        }
        let gain = function.numerator().terms();
        assert_eq!(gain.len(), 1, "{what}");
        assert_close(&what, gain[0].coefficient, 2.0 / rate, 1e-5);
        assert_eq!(best.unexplained, None, "{what}");
    }
}

/// The function without the slower pole is the better one while that pole is in the noise.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_simpler_function_wins_where_noise_hides_the_rest() {
    let best = found(&grown(0.4, 600, 200.0)).remove(0);
    let function = best.identified.function;
    assert_eq!(function.denominator().terms().len(), 2, "{function}");
    assert_eq!(function.unstable_poles(), Some(1), "{function}");
    assert_eq!(best.unexplained, None);
    // A tenth of what the slower pole adds: far below the end of the record, but plain.
    let best = found(&grown(0.4, 600, 0.14)).remove(0);
    let function = best.identified.function;
    assert_eq!(function.denominator().terms().len(), 3, "{function}");
    assert_close("residual", best.identified.rms_residual, 0.14, 0.02);
}

#[test]
fn a_function_that_lacks_a_pole_is_less_sure_and_says_where() {
    let record = grown(0.4, 600, 0.0);
    let mut guess = candidates(&record, true, None, Wanted::default()).remove(0);
    guess.function = "3.5/(2.5s-1)".parse().expect("a function");
    guess.dead_time = DeadTime::NONE;
    let lacks = &identify(&record, &[guess], true, Wanted::default(), &|_| ()).expect("fits")[0];
    assert_close("residual", lacks.identified.rms_residual, 1.12, 0.02);
    let at = lacks.unexplained.expect("much is left");
    assert!(at.to_s < 10.0 && at.share > 0.2, "{at:?}");
    // The gain of this mode is 2/(0.4·1.4) = 25/7: what was found is within three standard errors of it.
    let gain = lacks.identified.function.numerator().terms()[0].coefficient;
    let error = lacks.identified.standard_errors[0].1 * gain;
    assert_close("gain", gain, 25.0 / 7.0, 3.0 * error);
    assert!(error < 0.01, "{error}");
}
