//! Errors of the rows of a table as weights: made tables whose noise differs from row to row, from closed forms that need no library.

use super::{among, fit, normal, understood};
use haptic_tissue::ModelKind;
use measured_table::{Reader, read_table};
use testkit::{Random, assert_refused, assert_relative, assert_says};
use tissue_identification::{
    Baseline, Estimate, Identification, Options, Record, TableDetails, Weighting,
};

/// A made table, its model and its parameters.
struct Made {
    text: String,
    kind: ModelKind,
    truth: Vec<f64>,
}

const ROWS: usize = 60;

/// Table for a seed, by quarters: a power law and a Zener model relax, a spring and a dashpot are swept, a spring-pot creeps and recovers.
fn made(seed: u64) -> Made {
    of_kind(seed % 4, seed)
}

/// A spring-pot, swept by size and phase. Phases are ten times as good: the errors of both moduli are mostly that of the size.
fn polar(seed: u64) -> Made {
    of_kind(4, seed)
}

fn of_kind(number: u64, seed: u64) -> Made {
    let (mut random, mut draw) = (Random(seed), normal(seed));
    let step = 4.0 / (ROWS - 1) as f64;
    let place = |n: usize| 10_f64.powf(-2.0 + step * n as f64);
    // One row in two is good to some permille, the others to some per cent.
    let mut share = |n: usize| {
        let good = if n.is_multiple_of(2) { 1.0 } else { 20.0 };
        good * random.log_between(1e-3, 5e-3)
    };
    let mut text = String::new();
    let mut row = |head: &str, values: &[f64]| {
        let cells = values.iter().map(|value| format!(",{value:e}"));
        text += &format!("{head}{}\n", cells.collect::<String>());
    };
    let gamma = libm::tgamma;
    let (kind, truth) = match number {
        0 => {
            row("time_s,relaxation_modulus_pa,SD", &[]);
            for n in 0..ROWS {
                let (t, error) = (place(n), share(n));
                let value = 4e3 * t.powf(-0.22) / gamma(0.78);
                row(
                    &format!("{t}"),
                    &[value * (1.0 + error * draw()), 3.0 * error * value],
                );
            }
            (ModelKind::SpringPot, vec![4e3, 0.22])
        }
        1 => {
            row("time_s,modulus (kPa),modulus error (Pa)", &[]);
            for n in 0..ROWS {
                let (t, error) = (place(n), share(n));
                let value = 2.0 + 3.0 * (-t / 1.5).exp();
                row(
                    &format!("{t}"),
                    &[value * (1.0 + error * draw()), 1e3 * error * value],
                );
            }
            (ModelKind::Zener, vec![2e3, 3e3, 4.5e3])
        }
        2 => {
            row("omega_rad_s,G' (Pa),u(G') (%),G'' (Pa),u(G'') (%)", &[]);
            for n in 0..ROWS {
                let (w, errors) = (place(n), [share(n), share(n + 1)]);
                let values = [
                    900.0 * (1.0 + errors[0] * draw()),
                    30.0 * w * (1.0 + errors[1] * draw()),
                ];
                row(
                    &format!("{w}"),
                    &[values[0], 1e2 * errors[0], values[1], 1e2 * errors[1]],
                );
            }
            (ModelKind::KelvinVoigt, vec![900.0, 30.0])
        }
        4 => {
            row("omega_rad_s,|G*| (Pa),SD,phase (deg),SD", &[]);
            for n in 0..ROWS {
                let (w, errors) = (place(n), [share(n), 0.1 * share(n + 1)]);
                let size = 900.0 * w.powf(0.3);
                let phase = 0.15 * std::f64::consts::PI + errors[1] * draw();
                row(
                    &format!("{w}"),
                    &[
                        size * (1.0 + errors[0] * draw()),
                        size * errors[0],
                        phase.to_degrees(),
                        errors[1].to_degrees(),
                    ],
                );
            }
            (ModelKind::SpringPot, vec![900.0, 0.3])
        }
        _ => {
            row("time_s,strain,strain_std,stress_pa", &[]);
            row("0", &[0.0, 1e-5, 0.0]);
            for n in 1..=2 * ROWS {
                let (t, error) = (0.5 * n as f64, 5e-2 * share(n));
                let creep = |t: f64| 100.0 * t.max(0.0).powf(0.3) / (5e3 * gamma(1.3));
                let end = 0.5 * ROWS as f64;
                let held = if t <= end { 100.0 } else { 0.0 };
                let value = creep(t) - creep(t - end) + error * draw();
                row(&format!("{t}"), &[value, error, held]);
            }
            (ModelKind::SpringPot, vec![5e3, 0.3])
        }
    };
    Made { text, kind, truth }
}

fn identified(text: &str, options: &Options) -> Identification {
    let read = understood(text, &TableDetails::default());
    let read = read.unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_says(&read.notes.join("\n"), "is taken for the errors of the");
    fit(&read.record, options)
}

/// Parameters inside their intervals, and the sum of the logarithms of their widths.
fn inside(found: &Identification, truth: &[f64]) -> (usize, f64) {
    let estimates = found.fits[0].parameters.iter().zip(truth);
    let ends = estimates.map(|(one, truth): (&Estimate, _)| {
        let [low, high] = [one.low_95, one.high_95].map(|end| end.expect("an end"));
        let holds = usize::from((low..=high).contains(truth));
        (holds, libm::log((high - low) / truth))
    });
    ends.fold((0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

/// The share of the parameters that are inside their intervals, and the mean width of these over the truth, of so many tables.
fn coverage(tables: impl Iterator<Item = Made>, weighting: Weighting) -> (f64, f64) {
    let (mut held, mut widths, mut all) = (0, 0.0, 0);
    for made in tables {
        let options = Options {
            starts: 4,
            weighting,
            ..among(&[made.kind])
        };
        let found = identified(&made.text, &options);
        let (count, width) = inside(&found, &made.truth);
        (held, widths, all) = (held + count, widths + width, all + made.truth.len());
        let says = found.warnings.concat().contains("weighed by the errors");
        assert_eq!(says, weighting == Weighting::Errors, "{:?}", found.warnings);
    }
    (held as f64 / all as f64, libm::exp(widths / all as f64))
}

#[test]
fn intervals_hold_and_are_tighter_by_errors() {
    for made in [made, polar] {
        let (with, width) = coverage((0..200).map(made), Weighting::Errors);
        let (without, wide) = coverage((0..40).map(made), Weighting::Equal);
        println!("{with} with errors, of width {width}; {without} of width {wide} without");
        assert!((0.93..=0.97).contains(&with), "{with}");
        assert!(width < 0.15 * wide, "{width} {wide}");
    }
}

#[test]
fn the_model_that_made_a_table_with_errors_is_chosen() {
    let is_right = |seed: &u64| {
        let made = made(*seed);
        let options = Options {
            starts: 8,
            ..Options::default()
        };
        identified(&made.text, &options).fits[0].kind == made.kind
    };
    let right = (1000..1020).filter(is_right).count();
    assert!(right >= 19, "{right} of 20");
}

/// Weights 1/σ² of a straight line, by the normal equations: slope and offset.
fn line(x: &[f64], y: &[f64], errors: &[f64]) -> [f64; 2] {
    let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
        (0..x.len()).map(|n| of(n) / errors[n].powi(2)).sum()
    };
    let [one, by_x, by_y] = [sum(&|_| 1.0), sum(&|n| x[n]), sum(&|n| y[n])];
    let [xx, xy] = [sum(&|n| x[n] * x[n]), sum(&|n| x[n] * y[n])];
    let slope = (one * xy - by_x * by_y) / (one * xx - by_x * by_x);
    [slope, (by_y - slope * by_x) / one]
}

/// A spring under any motion, with the offset of a load cell: a straight line.
#[test]
fn a_spring_is_the_straight_line_of_weighted_least_squares() {
    let mut draw = normal(5);
    let strain: Vec<f64> = (0..40).map(|n| 1e-3 * f64::from(n)).collect();
    let errors: Vec<f64> = (0..40)
        .map(|n| if n % 3 == 0 { 0.1 } else { 2.0 })
        .collect();
    let stress = strain
        .iter()
        .zip(&errors)
        .map(|(e, error)| 800.0 * e + 3.0 + error * draw());
    let stress: Vec<f64> = stress.collect();
    let mut text = "time_s,strain,stress_pa,±\n".to_owned();
    for n in 0..40 {
        text += &format!("{n},{},{},{}\n", strain[n], stress[n], errors[n]);
    }
    let options = Options {
        baseline: Some(Baseline::Constant),
        ..among(&[ModelKind::Spring])
    };
    let found = identified(&text, &options);
    // The first row, at rest, is not compared.
    let [modulus, offset] = line(&strain[1..], &stress[1..], &errors[1..]);
    // As near as a search ends to its minimum.
    assert_relative("modulus", found.fits[0].parameters[0].value, modulus, 1e-6);
    assert_relative("offset", found.placement[0].value, offset, 1e-6);
}

#[test]
fn the_bootstrap_draws_each_row_by_its_own_error() {
    let made = made(0);
    let [drawn, plain] = [300, 0].map(|bootstrap| {
        let options = Options {
            bootstrap,
            ..among(&[made.kind])
        };
        inside(&identified(&made.text, &options), &made.truth).1
    });
    // Logarithms of the widths of two parameters.
    assert!((drawn - plain).abs() < 2.0 * 0.2, "{drawn} {plain}");
}

#[test]
fn errors_that_are_none_are_refused_with_row_and_remedy() {
    for (error, row) in [
        ("0", "error 0 is not"),
        ("-2", "error -2 is not"),
        ("1e999", "\"1e999\" is not a finite"),
    ] {
        let text = format!(
            "time_s,modulus_pa,SD\n1,9,1\n2,8,1\n3,7,{error}\n4,6,1\n5,5,1\n6,4,1\n7,4,1\n8,4,1\n9,4,1\n10,3,1\n11,3,1\n12,3,1\n"
        );
        let words = format!("line 4 & {row} & omit the row, or give");
        assert_refused(understood(&text, &TableDetails::default()), &words);
        let skipping = Reader {
            skip_bad_rows: true,
            ..Reader::default()
        };
        let columns = skipping.read(read_table(text.as_bytes()).expect("a table"));
        let read = TableDetails::default().record(columns.expect("columns"));
        assert_eq!(read.expect("the other rows").record.samples(), 11);
    }
}

/// A table with errors, and what is said of them.
const SAID: &str = r"
    time_s,strain,strain error,stress_pa\n0,0,1,0\n1,0.1,-1,4\n2,0.2,1,9 | strain error looks like errors of the strain, which do not count
    omega_rad_s,G' (Pa),SD,G'' (Pa)\n1,9,1,2\n2,8,1,2\n3,7,1,3 | SD looks like errors of the storage, which do not count
    time_s,force_n,force_sd_n,position_m\n0,0,1,0\n1,2,1,0.001\n2,4,1,0.002 | force_sd_n is taken for the errors of the stress
";

#[test]
fn what_errors_are_taken_for_is_said() {
    let mut details = TableDetails::default();
    (details.loading.area_m2, details.loading.thickness_m) = (Some(1e-4), Some(0.01));
    for [text, words] in testkit::table(SAID) {
        let details = if text.contains("force") {
            details
        } else {
            TableDetails::default()
        };
        let read = understood(&text, &details).expect(&text);
        assert_says(&read.notes.join("\n"), &words);
    }
    let record = Record::relaxation(vec![1.0, 2.0], vec![2.0, 1.0]).expect("valid");
    assert_refused(
        record.with_errors(&[1.0], &[]),
        "there is not an error for each sample",
    );
}
