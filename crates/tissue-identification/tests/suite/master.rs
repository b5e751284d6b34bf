//! Records at several temperatures: the shifts that made them come out, and those that others publish.

use super::{candidate, one, said};
use haptic_tissue::{Model, ModelKind};
use measured_table::{Reader, read_table};
use testkit::{assert_close, assert_refused, assert_says};
use tissue_identification::{MasterCurve, Record, ShiftBy, TableDetails, master_curve};

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

fn relaxed(celsius: f64) -> Record {
    let times: Vec<f64> = grid().collect();
    let reduced = times.iter().map(|t| t / 10_f64.powf(wlf(celsius)));
    let reduced: Vec<f64> = reduced.collect();
    Record::relaxation(times, zener().relaxation_moduli(&reduced)).expect("valid")
}

/// A sweep whose moduli are shifted by these decades.
fn swept(storage: f64, loss: f64) -> Record {
    let at =
        |shift: f64| grid().map(move |omega| zener().complex_modulus(omega * 10_f64.powf(shift)));
    let storage = at(storage).map(|m| m.re).collect();
    let loss = at(loss).map(|m| m.im).collect();
    Record::oscillation(grid().collect(), storage, loss).expect("valid")
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
    let relaxation = TEMPERATURES_C.map(|celsius| (celsius, relaxed(celsius)));
    let sweep = TEMPERATURES_C.map(|celsius| (celsius, swept(wlf(celsius), wlf(celsius))));
    for records in [relaxation, sweep] {
        // In any order.
        let mut turned = records.to_vec();
        turned.reverse();
        let curve = master_curve(turned, 20.0, ShiftBy::Both).expect("one curve");
        assert_shifts(&curve, 0.01);
        assert_eq!(curve.record.samples(), 240);
        // All samples lie on the curve at the reference temperature.
        for (x, value) in curve.record.x().iter().zip(curve.record.first()) {
            let wanted = if curve.record.second().is_empty() {
                zener().relaxation_moduli(&[*x])[0]
            } else {
                zener().complex_modulus(*x).re
            };
            assert!((value / wanted - 1.0).abs() < 0.02, "{x}: {value} {wanted}");
        }
        // Between two temperatures in proportion.
        let between = master_curve(records.to_vec(), 25.0, ShiftBy::Both).expect("one curve");
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
    for (records, celsius, message) in [
        (
            vec![],
            20.0,
            "needs records of two temperatures, and there is none",
        ),
        (vec![(20.0, at(1.0))], 20.0, "and there is one: give more"),
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
            "and there is one: give more",
        ),
        (
            vec![(20.0, at(1.0)), (30.0, at(0.9))],
            30.6,
            "`master_curve` 30.6 degC is not between 2 records from 20 to 30 degC",
        ),
        (
            vec![(20.0, motion.clone()), (30.0, motion)],
            20.0,
            "records of one kind",
        ),
    ] {
        let refused = master_curve(records, celsius, ShiftBy::Both);
        assert_refused(refused, message);
    }
    let pair = vec![(20.0, at(1.0)), (30.0, at(0.9))];
    let refused = master_curve(pair, 20.0, ShiftBy::Storage);
    assert_refused(refused, "`shift_by` has no effect");
}

/// Halves of a record at one temperature are that record: the short times and the long ones, of which only one overlaps a neighbour far away.
#[test]
fn several_records_of_one_temperature_are_one() {
    let halves = TEMPERATURES_C.into_iter().flat_map(|celsius| {
        let whole = relaxed(celsius);
        let half = |range: std::ops::Range<usize>| {
            let [x, y] = [whole.x(), whole.first()].map(|all| all[range.clone()].to_vec());
            Record::relaxation(x, y).expect("valid")
        };
        [(celsius, half(0..22)), (celsius + 0.04, half(18..40))]
    });
    // Half a degree beyond the end is the end.
    let curve = master_curve(halves.collect(), 40.5, ShiftBy::Both).expect("one curve");
    assert_close("curve.reference_c", curve.reference_c, 40.02, 1e-9);
    assert_eq!(curve.shifts.len(), TEMPERATURES_C.len());
    assert_eq!(curve.record.samples(), 264);
    for (shift, celsius) in curve.shifts.iter().zip(TEMPERATURES_C) {
        let wanted = wlf(celsius) - wlf(40.0);
        assert_close("shift.log10", shift.log10, wanted, 0.02);
    }
    assert!(curve.is_lawful && curve.overlaps.iter().all(|one| one.misfit < 5e-3));
}

/// A loss modulus that moves by a fifth more than the storage modulus: each is found alone, and the error is half of what they differ by.
#[test]
fn storage_and_loss_that_disagree_are_said_and_widen_the_errors() {
    let records = TEMPERATURES_C.map(|celsius| (celsius, swept(wlf(celsius), 1.2 * wlf(celsius))));
    for by in [ShiftBy::Storage, ShiftBy::Loss, ShiftBy::Both] {
        let curve = master_curve(records.to_vec(), 20.0, by).expect("one curve");
        for (shift, celsius) in curve.shifts.iter().zip(TEMPERATURES_C) {
            let [storage, loss] = shift.alone.expect("a sweep");
            let wanted = [wlf(celsius), 1.2 * wlf(celsius)];
            assert!((storage - wanted[0]).abs() < 0.02 && (loss - wanted[1]).abs() < 0.02);
            let shifts = match by {
                ShiftBy::Storage => wanted[0]..=wanted[0],
                ShiftBy::Loss => wanted[1]..=wanted[1],
                ShiftBy::Both => wanted[0].min(wanted[1])..=wanted[0].max(wanted[1]),
            };
            let near = shifts.start() - 0.02..=shifts.end() + 0.02;
            assert!(near.contains(&shift.log10), "{by:?} {shift:?}");
            let half = 0.1 * wlf(celsius).abs();
            assert!(
                (shift.standard_error / half.max(0.01) - 1.0).abs() < 0.2 || half == 0.0,
                "{shift:?} {half}"
            );
        }
        let found = one(&curve.record, candidate("fractional-zener"));
        let message = said(&found);
        assert_says(
            &message,
            "at -10 degC the storage modulus alone is shifted by 3.43 decades",
        );
        assert_eq!(
            message.contains("`shift_by`"),
            by == ShiftBy::Both,
            "{message}"
        );
        assert!(curve.is_lawful);
    }
}

/// The same material: its sweeps below the glass transition are flat, and only the storage modulus knows the way.
#[test]
fn shifts_that_no_law_fits_are_no_result() {
    let Some([table]) = super::read_public(["pyvisco-sweeps-at-temperatures.csv"]) else {
        return;
    };
    let records = segments(&table);
    let both = master_curve(records.clone(), 3.0, ShiftBy::Both).expect("one curve");
    assert!(!both.is_lawful && both.shifts[0].log10 < 1.0);
    // 11.1 decades are published for the coldest.
    assert!(
        both.shifts[0].log10 + 2.0 * both.shifts[0].standard_error > 11.1,
        "{:?}",
        both.shifts[0]
    );
    assert_says(
        &said(&one(&both.record, candidate("fractional-zener"))),
        "the shifts are no result & `shift_by` = storage",
    );
    let storage = master_curve(records, 3.0, ShiftBy::Storage).expect("one curve");
    assert!(
        storage.is_lawful && (storage.shifts[0].log10 - 11.1).abs() < 1.0,
        "{:?}",
        storage.shifts[0]
    );
    assert_eq!(storage.laws[0].name, "wlf");
    assert!(
        storage.overlaps.iter().all(|one| one.misfit < 0.02),
        "{:?}",
        storage.overlaps
    );
}

/// All segments of a table, with their temperatures.
fn segments(table: &str) -> Vec<(f64, Record)> {
    let reader = Reader {
        segments: vec!["all".to_owned()],
        ..Reader::default()
    };
    let all = reader.read_all(&read_table(table.as_bytes()).expect("a table"));
    let records = all.expect("segments").into_iter().map(|columns| {
        let celsius = columns.temperature_c.expect("a temperature");
        let read = TableDetails::default().record(columns).expect("a record");
        (celsius, read.record)
    });
    records.collect()
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
    let records = segments(&table);
    let curve = master_curve(records, 3.0, ShiftBy::Both).expect("one curve");
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
