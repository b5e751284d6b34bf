//! Records that do not begin at rest at zero, and outputs that no input moves.
//!
//! `CAMPAIGN_CASES` sets how many; 20 to 30 unless it is given.

use crate::fixture::{begun, normal, record, searched};
use control_identification::StartState;
use control_identification::model_search::{Found, InputOutput, find_start};
use fracdiff::Seconds;
use fractional_control::{HeldPlant, Plant};
use rayon::prelude::*;
use testkit::{Random, assert_close, assert_relative};

/// Noise of this standard deviation.
fn noise(random: &mut Random, deviation: f64) -> f64 {
    deviation * normal(random)
}

/// Levels that change every now and then.
fn levels(random: &mut Random, samples: usize) -> Vec<f64> {
    let mut level = 0.0;
    let level = (0..samples).map(|_| {
        if random.chance(0.05) {
            level = random.between(-1.0, 1.0);
        }
        level
    });
    level.collect()
}

/// c + K/(τs + 1)·e^(−Ls)·(u − `u_p`) by its recursion, L a whole number of samples; before the record u was `before`.
fn lag(input: &[f64], (gain, rate, late): (f64, f64, usize), before: f64) -> Vec<f64> {
    let mut y = 0.0;
    let outputs = (0..input.len()).map(|n| {
        let now = y;
        let acting = n.checked_sub(late).map_or(before, |n| input[n]);
        y += (1.0 - rate) * (gain * (acting - before) - y);
        now
    });
    outputs.collect()
}

fn found(record: &mut InputOutput) -> Vec<Found> {
    begun(record).expect("found")
}

/// What is printed, run by other code, is what the fit is of.
fn assert_printed_is_fitted(found: &[Found], record: &InputOutput) {
    for identified in found.iter().map(|found| &found.identified) {
        let (above, below) = (
            identified.function.numerator(),
            identified.function.denominator(),
        );
        let plant =
            Plant::transfer(identified.function, identified.dead_time.seconds()).expect("a plant");
        let t = Seconds(record.sample_time_s());
        let mut terms = above.terms().iter().chain(below.terms());
        if terms.any(|term| term.order.fract() != 0.0) || above.degree() >= below.degree() {
            continue;
        }
        let sampled = HeldPlant::with_usual_memory(&plant, t).expect("it runs");
        let mut state = sampled.at_rest();
        let shown = record.input.iter().zip(&identified.model);
        let most = record
            .output
            .iter()
            .fold(0.0, |most: f64, y| most.max(y.abs()));
        for (n, (u, shown)) in shown.enumerate() {
            let u = u - identified.input_before;
            let exact = identified.offset + sampled.step(&mut state, u);
            let left = (exact - shown).abs();
            assert!(
                left < 1e-6 * most,
                "{}, sample {n}: {exact} {shown}",
                identified.function
            );
        }
    }
}

/// A heater that is switched on in the first row: a lag of 155 s behind 24 s, from room temperature, as 61 samples of a teaching log have it.
#[test]
fn a_heater_from_room_temperature_is_a_lag_that_comes_to_rest() {
    for seed in 0..5 {
        let mut random = Random(seed + 61);
        let (t, tau, late) = (10.0, 155.0, 24.0);
        let output = (0..61).map(|n| {
            let since = (t * f64::from(n) - late).max(0.0);
            let rises = 0.641 * 50.0 * (1.0 - (-since / tau).exp());
            21.6 + rises + noise(&mut random, 0.2)
        });
        let mut record = record(t, vec![50.0; 61], output.collect());
        let found = found(&mut record);
        assert_eq!(record.start, StartState::Offset);
        assert_printed_is_fitted(&found, &record);
        let best = &found[0].identified;
        let what = best.function.to_string();
        assert_eq!(best.function.unstable_poles(), Some(0), "{what}");
        assert!(best.fit > 0.999, "{what}: {}", best.fit);
        let gain = best.function.numerator().terms().last().expect("a gain");
        assert_close(&what, gain.order, best.function.denominator().lowest(), 0.0);
        assert_relative(&what, gain.coefficient, 0.641, 0.02);
        assert_close(&what, best.offset, 21.6, 0.3);
        assert!(found[0].shows_a_response(&record), "{what}");
    }
}

/// Noise whose neighbours are alike says less than its samples: what a larger function explains of it is no dynamics.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn noise_that_is_alike_asks_for_no_larger_function() {
    let mut larger = 0;
    for seed in 0..4 {
        let mut random = Random(seed + 4_300);
        let mut walk = 0.0;
        let input = levels(&mut random, 300);
        let output = lag(&input, (2.0, (-0.05_f64).exp(), 0), 0.0);
        let output = output.iter().map(|y| {
            walk = 0.95 * walk + noise(&mut random, 0.03);
            y + walk
        });
        let record = record(0.1, input, output.collect());
        let best = &searched(&record, None).expect("found")[0].identified;
        let is_larger = best.function.denominator().degree() > 1.5;
        println!("{seed}: {}", best.function);
        larger += usize::from(is_larger);
    }
    assert!(larger <= 1, "{larger} of 4 are of a larger function");
}

/// A step test whose recorder was switched on before the step: the step is what moves the output, and not the input from 0.
#[test]
fn one_step_soon_after_the_beginning_is_counted_from_the_input_before_it() {
    for (seed, before) in [1, 5, 12, 24].into_iter().enumerate() {
        let mut random = Random(seed as u64 + 7_300);
        let step = |n: usize| if n < before { 5.0 } else { 5.5 };
        let input: Vec<f64> = (0..500).map(step).collect();
        // A plant that was off until the record began does not rest before the step.
        for (at, start, zero) in [(5.0, 2.1, 5.0), (0.0, 2.1, 0.0)] {
            if zero == 0.0 && before < 5 {
                continue;
            }
            let output = lag(&input, (4.75, (-1.0_f64 / 75.0).exp(), 0), at);
            let output = output.iter().map(|y| start + y + noise(&mut random, 0.02));
            let mut record = record(1.0, input.clone(), output.collect());
            let best = &found(&mut record)[0].identified;
            let what = format!("{before} from {at}: {}", best.function);
            assert_eq!(record.start, StartState::Offset, "{what}");
            assert_close(&what, record.input_zero, zero, 0.0);
            assert_eq!(record.clone().as_recorded().input, input, "{what}");
            assert_close(&what, best.offset, start, 0.02);
            let gain = best.function.numerator().terms().last().expect("a gain");
            assert_relative(&what, gain.coefficient, 4.75, 0.02);
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_plant_that_had_settled_gives_the_input_before_its_record() {
    for seed in 0..4 {
        let mut random = Random(seed + 900);
        let before = random.between(2.0, 5.0);
        let input = levels(&mut random, 400)
            .into_iter()
            .map(|u| before + 1.5 + u);
        let input: Vec<f64> = input.collect();
        let output = lag(&input, (2.0, (-0.05_f64).exp(), 3), before);
        let output = output.iter().map(|y| 40.0 + y + noise(&mut random, 0.01));
        let mut record = record(0.1, input, output.collect());
        let found = found(&mut record);
        assert_eq!(record.start, StartState::Settled);
        assert_printed_is_fitted(&found, &record);
        let best = &found[0].identified;
        let what = best.function.to_string();
        assert_close(&what, best.input_before, before, 0.02);
        assert_close(&what, best.offset, 40.0, 0.05);
        let below = best.function.denominator().terms();
        assert_relative(&what, below[0].coefficient, 2.0, 0.02);
    }
}

/// One that begins at rest at zero stays so, whatever its orders.
#[test]
fn a_record_that_begins_at_rest_has_no_offset() {
    let half = |t: f64| 1.0 - t.exp() * libm::erfc(t.sqrt());
    let output = |deviation: f64| {
        let mut random = Random(5);
        let output = (0..200).map(|n| half(0.05 * f64::from(n)) + noise(&mut random, deviation));
        output.collect()
    };
    for deviation in [0.0, 0.01] {
        let mut record = record(0.05, vec![1.0; 200], output(deviation));
        find_start(&mut record, true, None);
        assert_eq!(record.start, StartState::Rest);
    }
}

/// A made record of 0.555·exp(−1.91 s)/(1.18 s + 1): a pole and a zero, both at 0.849, are in no plant.
#[test]
fn a_pole_and_a_zero_that_are_one_within_their_errors_are_none() {
    let mut columns = [vec![], vec![], vec![]];
    for line in include_str!("unstable-pole.csv").lines().skip(1) {
        let cells = line.split(',').map(|cell| cell.parse().expect("a number"));
        columns
            .iter_mut()
            .zip(cells)
            .for_each(|(column, cell): (_, f64)| column.push(cell));
    }
    let [time_s, input, output] = columns;
    let record = InputOutput {
        time_s,
        input,
        output,
        ..InputOutput::default()
    };
    let found = searched(&record, None).expect("found");
    let best = &found[0].identified;
    let what = best.function.to_string();
    let (above, below) = (best.function.numerator(), best.function.denominator());
    assert_eq!((above.terms().len(), below.terms().len()), (1, 2), "{what}");
    assert_close(&what, above.terms()[0].coefficient, 0.555, 0.001);
    assert_close(&what, below.terms()[0].coefficient, 1.18, 0.005);
    assert_close(&what, below.degree(), 1.0, 0.0);
    assert_close(&what, best.dead_time.seconds(), 1.91, 0.005);
    assert!(best.rms_residual < 0.00475, "{}", best.rms_residual);
}

/// Random walks and drifts beside an input that moves are told; lags behind a dead time are found, and none of them grows.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_output_that_no_input_moves_is_told() {
    let count: u64 = testkit::cases(20);
    let accepted = (0..count).into_par_iter().filter(|number| {
        let mut random = Random(number + 77_000);
        let input = levels(&mut random, 300);
        let (slope, mut walk) = (random.between(-1.0, 1.0), 0.0);
        let output = (0..300).map(|n| {
            walk += noise(&mut random, 0.1);
            match number % 3 {
                0 => walk,
                1 => slope * 0.05 * f64::from(n) + noise(&mut random, 0.1),
                _ => slope * 0.05 * f64::from(n) + walk,
            }
        });
        let output: Vec<f64> = output.collect();
        let mut record = record(0.1, input, output);
        let found = begun(&mut record);
        let Some(best) = found.ok().and_then(|found| found.into_iter().next()) else {
            return false;
        };
        let has_response = best.shows_a_response(&record);
        if has_response {
            println!("{number}: {}", best.identified.function);
        }
        has_response
    });
    let accepted = accepted.count() as u64;
    assert!(
        accepted * 30 <= count,
        "{accepted} of {count} are taken for an answer"
    );
}

/// A start explains what the input does not: a hum of two sines, and the input that somebody gave for the output of a lag.
#[test]
fn what_the_start_explains_alone_is_no_response() {
    for seed in 0..testkit::cases(2) {
        let mut random = Random(seed + 99_000);
        let [slow, fast] = [(1.5, 3.0), (5.0, 9.0)].map(|(low, high)| random.between(low, high));
        let hum = (0..800).map(|n| {
            let t = 0.01 * f64::from(n);
            let hum = 0.7 * (slow * t).sin() + 0.4 * (fast * t + 1.0).cos();
            (1e4 * hum).round() / 1e4
        });
        let levels = levels(&mut random, 800);
        let steps: Vec<f64> = (0..300).map(|n| if n < 10 { 30.0 } else { 40.0 }).collect();
        let warm: Vec<f64> = lag(&steps, (0.7, (-2.0f64 / 80.0).exp(), 3), 30.0);
        let warm = warm.iter().map(|y| 20.0 + y + noise(&mut random, 0.02));
        let warm: Vec<f64> = warm.collect();
        let records = [
            ("hum", record(0.01, levels, hum.collect())),
            ("swapped", record(2.0, warm.clone(), steps.clone())),
        ];
        for (what, mut record) in records {
            let found = begun(&mut record).unwrap_or_default();
            let closest = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
            assert!(
                closest.is_none_or(|closest| !closest.shows_a_response(&record)),
                "{what} {seed}: {:?}",
                closest.map(|closest| closest.identified.function.to_string())
            );
        }
        let mut right = record(2.0, steps, warm);
        assert!(found(&mut right)[0].shows_a_response(&right), "{seed}");
    }
}

/// A motor's speed in counts, without a dither: what is left of it is the count, and no pole draws that.
#[test]
fn an_output_in_counts_has_no_more_poles_than_its_plant() {
    let count: u64 = testkit::cases(12);
    let more = (0..count).into_par_iter().filter(|number| {
        let mut random = Random(number + 66_000);
        let (gain, tau) = (random.log_between(1.0, 50.0), random.log_between(3.0, 30.0));
        let input: Vec<f64> = (0..400).map(|n| f64::from((n / 50) % 2)).collect();
        let output = lag(&input, (gain, (-1.0 / tau).exp(), 0), 0.0);
        let sensor = gain / random.log_between(15.0, 150.0);
        let output = output.iter().map(|y| sensor * (y / sensor).round());
        let mut record = record(0.01, input, output.collect());
        let best = found(&mut record).swap_remove(0).identified;
        let poles = best.function.denominator().degree();
        let steady = best.function.numerator().terms().last().expect("a gain");
        let is_true = poles <= 1.0 && (steady.coefficient / gain - 1.0).abs() < 0.05;
        if !is_true {
            println!("{number}: {} for {gain}, {tau}, in {sensor}", best.function);
        }
        !is_true
    });
    let more = more.count() as u64;
    assert!(10 * more <= count, "{more} of {count}");
}
