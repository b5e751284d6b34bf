//! Records at several temperatures: the shifts that made them come out, and those that others publish.

use haptic_tissue::identify::table::{Reader, Reading, read_table};
use haptic_tissue::identify::{MasterCurve, Record, master_curve};
use haptic_tissue::{Model, ModelKind};

const TEMPERATURES_C: [f64; 6] = [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0];

/// `log₁₀ a_T` of C₁ = 8 and C₂ = 100 K at 20 °C.
fn wlf(celsius: f64) -> f64 {
    -8.0 * (celsius - 20.0) / (80.0 + celsius)
}

fn zener() -> Model {
    Model::from_parameters(ModelKind::FractionalZener, &[3e5, 0.7, 1e5, 0.1, 2e3]).expect("valid")
}

/// 40 samples of three decades.
fn grid() -> impl Iterator<Item = f64> {
    (0..40).map(|n| 0.1 * 1000_f64.powf(f64::from(n) / 39.0))
}

fn assert_shifts(curve: &MasterCurve, tolerance: f64) {
    assert_eq!(curve.shifts.len(), TEMPERATURES_C.len());
    for (shift, celsius) in curve.shifts.iter().zip(TEMPERATURES_C) {
        assert_eq!(shift.temperature_c.to_bits(), celsius.to_bits());
        assert!(
            (shift.log10 - wlf(celsius)).abs() < tolerance,
            "{shift:?}, {}",
            wlf(celsius)
        );
    }
    let law = &curve.laws[0];
    assert_eq!(law.name, "wlf");
    let [c1, c2] = [&law.parameters[0], &law.parameters[1]];
    assert!(
        (c1.value - 8.0).abs() < 20.0 * tolerance && (c2.value - 100.0).abs() < 200.0 * tolerance,
        "{law:?}"
    );
}

#[test]
fn relaxations_and_sweeps_at_temperatures_are_one() {
    let relaxation = TEMPERATURES_C.map(|celsius| {
        let times: Vec<f64> = grid().collect();
        let reduced: Vec<f64> = times
            .iter()
            .map(|t| t / 10_f64.powf(wlf(celsius)))
            .collect();
        (
            celsius,
            Record::relaxation(times, zener().relaxation_moduli(&reduced)).expect("valid"),
        )
    });
    let sweep = TEMPERATURES_C.map(|celsius| {
        let moduli = grid().map(|omega| zener().complex_modulus(omega * 10_f64.powf(wlf(celsius))));
        let moduli: Vec<_> = moduli.collect();
        let [storage, loss] = [
            |m: &num_complex::Complex64| m.re,
            |m: &num_complex::Complex64| m.im,
        ]
        .map(|part| moduli.iter().map(part).collect());
        (
            celsius,
            Record::oscillation(grid().collect(), storage, loss).expect("valid"),
        )
    });
    for records in [relaxation, sweep] {
        // In any order.
        let mut turned = records.to_vec();
        turned.reverse();
        let curve = master_curve(turned, 20.0).expect("one curve");
        assert_shifts(&curve, 0.01);
        assert_eq!(curve.record.samples(), 240);
        // All samples lie on the curve at the reference temperature.
        for (x, value) in curve.record.x().iter().zip(curve.record.first()) {
            let wanted = match curve.record.second().is_empty() {
                true => zener().relaxation_moduli(&[*x])[0],
                false => zener().complex_modulus(*x).re,
            };
            assert!((value / wanted - 1.0).abs() < 0.02, "{x}: {value} {wanted}");
        }
        // Between two temperatures in proportion.
        let between = master_curve(records.to_vec(), 25.0).expect("one curve");
        let zero = 0.5 * (curve.shifts[3].log10 + curve.shifts[4].log10);
        for (one, other) in between.shifts.iter().zip(&curve.shifts) {
            assert!((one.log10 - other.log10 + zero).abs() < 1e-9);
        }
    }
}

#[test]
fn what_makes_no_master_curve_is_refused_with_a_remedy() {
    let at = |modulus: f64| {
        Record::relaxation(
            vec![1.0, 2.0, 4.0, 8.0],
            [4.0, 3.0, 2.5, 2.0].map(|x| modulus * x).to_vec(),
        )
        .expect("valid")
    };
    let times: Vec<f64> = (0..9).map(f64::from).collect();
    let motion = Record::history(times.clone(), times.clone(), times.clone()).expect("valid");
    for (records, celsius, said) in [
        (vec![], 20.0, "needs records of two temperatures"),
        (vec![(20.0, at(1.0))], 20.0, "not between 1 records"),
        (
            vec![(20.0, at(1.0)), (30.0, at(0.9))],
            40.0,
            "`master_curve` 40 degC is not between 2 records from 20 to 30 degC",
        ),
        (
            vec![(20.0, at(1.0)), (30.0, at(0.9))],
            f64::NAN,
            "NaN degC is not between",
        ),
        (
            vec![(20.0, at(1.0)), (20.05, at(0.9))],
            20.0,
            "two records are at 20 degC",
        ),
        (
            vec![(20.0, motion.clone()), (30.0, motion)],
            20.0,
            "records of one kind",
        ),
    ] {
        let refused = master_curve(records, celsius)
            .expect_err("refused")
            .to_string();
        assert!(refused.contains(said), "{refused}");
    }
}

/// The public record of NIST's pyvisco, and the shifts that it publishes, which are of another method: power laws through a few points.
#[test]
fn shifts_are_those_that_pyvisco_publishes() {
    let Some([table, published]) = super::read_public([
        "pyvisco-relaxations-at-temperatures.csv",
        "pyvisco-shift-factors.csv",
    ]) else {
        return;
    };
    let reader = Reader {
        segments: vec!["all".to_owned()],
        ..Reader::default()
    };
    let all = reader
        .read_all(&read_table(table.as_bytes()).expect("a table"))
        .expect("segments");
    let records = all.into_iter().map(|columns| {
        let celsius = columns.temperature_c.expect("a temperature");
        (
            celsius,
            columns
                .record(&Reading::default())
                .expect("a record")
                .record,
        )
    });
    let curve = master_curve(records.collect(), 3.0).expect("one curve");
    let published: Vec<[f64; 2]> = published
        .lines()
        .skip(2)
        .map(|row| {
            let (celsius, log10) = row.split_once(',').expect("two columns");
            [celsius, log10].map(|cell| cell.parse().expect("a number"))
        })
        .collect();
    assert_eq!(curve.shifts.len(), published.len());
    let off = curve
        .shifts
        .iter()
        .rev()
        .zip(&published)
        .map(|(ours, theirs)| ours.log10 - theirs[1]);
    let off: Vec<f64> = off.collect();
    // Of 28.6 decades; from one temperature to the next within a quarter of a decade, the most in the glass transition.
    for (n, pair) in off.windows(2).enumerate() {
        assert!(
            (pair[1] - pair[0]).abs() < 0.25,
            "{}: {pair:?}",
            published[n][0]
        );
    }
    assert!(off.iter().all(|off| off.abs() < 0.7), "{off:?}");
    println!("{off:.2?} {:?}", curve.laws);
}
