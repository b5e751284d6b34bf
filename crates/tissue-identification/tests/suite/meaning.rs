//! What a record means: rheometers' other moduli, the sign of compression, a ramp that no column tells.

use super::{candidate, is_inside, one, said, understood, values};
use haptic_loop::{Loading, LoadingKind};
use testkit::{assert_refused, assert_relative, assert_says};
use tissue_identification::{ContactPoint, Identification, RecordKind, TableDetails, Understood};

fn fitted(understood: &Understood) -> Identification {
    one(&understood.record, candidate("spring-pot"))
}

fn assert_fit(found: &Identification, [viscosity, order]: [f64; 2], tolerance: f64) {
    assert_relative("V", values(found)[0], viscosity, tolerance);
    assert_relative("order", values(found)[1], order, tolerance);
}

/// 5000 Pa·s^0.25, as |G*| with δ, as G′ with tan δ, and as the other pairs.
#[test]
fn other_moduli_of_a_rheometer_are_storage_and_loss() {
    let phase = include_str!("../golden/meaning/complex-and-phase.csv");
    let tangent = include_str!("../golden/meaning/storage-and-tan-delta.csv");
    let size = |line: &str| -> f64 {
        line.split(',')
            .nth(1)
            .and_then(|x| x.parse().ok())
            .expect("a size")
    };
    let tangents = |name: &str, table: &str, factor: f64| -> String {
        let rows = table.lines().skip(1);
        let rows = rows.map(|row| {
            format!(
                "{},{},0.41421356\n",
                row.split(',').next().expect("one"),
                factor * size(row)
            )
        });
        format!(
            "omega_rad_s,{name},loss_tangent\n{}",
            rows.collect::<String>()
        )
    };
    let phases = tangent
        .replace("Tan(delta)", "Phase angle (rad)")
        .replace("0.414214", "0.39269908");
    for table in [
        phase.to_owned(),
        tangent.to_owned(),
        tangents("complex_modulus_pa", phase, 1.0),
        tangents("Complex modulus |E*| (kPa)", phase, 1e-3),
        phases,
    ] {
        let read = understood(&table, &TableDetails::default()).expect("a sweep");
        assert_eq!(read.record.kind(), RecordKind::Oscillation);
        assert_says(
            &read.notes.join("\n"),
            "storage and loss modulus are made of",
        );
        assert_fit(&fitted(&read), [5000.0, 0.25], 1e-5);
    }
    // Measured ones are taken as they are.
    let both = "omega_rad_s,storage_modulus_pa,loss_modulus_pa,loss_tangent\n1,3,2,9\n10,5,3,9\n100,9,6,9\n";
    let read = understood(both, &TableDetails::default()).expect("a sweep");
    assert_eq!(read.record.second(), [2.0, 3.0, 6.0]);
    let touched = TableDetails {
        contact: ContactPoint::Fitted,
        ..TableDetails::default()
    };
    assert_refused(
        understood(both, &touched),
        "`contact_point_m` has no effect on this record",
    );
    let beyond = "omega_rad_s,complex_modulus_pa,phase_rad\n1,3,0.3\n10,5,2\n";
    assert_refused(
        understood(beyond, &TableDetails::default()),
        "line 3: loss modulus & is not above 0 Pa",
    );
}

#[test]
fn compression_may_be_written_below_0() {
    let table = include_str!("../golden/meaning/negative-relaxation.csv");
    let reading = TableDetails {
        strain: Some(0.05),
        loading: Loading {
            area_m2: Some(4e-4),
            ..Loading::new(LoadingKind::Compression)
        },
        ..TableDetails::default()
    };
    let [down, up] = [table.to_owned(), table.replace(",-", ",")]
        .map(|table| understood(&table, &reading).expect("read"));
    assert_eq!(down.record, up.record);
    let message = "the stress is read with the other sign, so that the modulus is above 0";
    assert_eq!(down.notes.iter().filter(|note| *note == message).count(), 1);
    assert!(!up.notes.iter().any(|note| note == message));
    let rows: Vec<(f64, f64)> = (0..40)
        .map(|n| 0.1 * f64::from(n))
        .map(|t| (t, 0.05 * t.min(1.0)))
        .collect();
    let motion = |sign: f64| -> String {
        let rows = rows
            .iter()
            .map(|(t, strain)| format!("{t},{strain},{}\n", sign * 2e3 * strain));
        format!("time_s,strain,stress_pa\n{}", rows.collect::<String>())
    };
    let [down, up] =
        [-1.0, 1.0].map(|sign| understood(&motion(sign), &TableDetails::default()).expect("read"));
    assert_eq!(down.record, up.record);
    let creep = "time_s,strain\n1,-0.001\n2,-0.0012\n4,-0.0015\n8,-0.0019\n";
    let reading = TableDetails {
        stress_pa: Some(100.0),
        ..TableDetails::default()
    };
    let [down, up] = [creep.to_owned(), creep.replace(",-", ",")]
        .map(|table| understood(&table, &reading).expect("read"));
    assert_eq!(down.record, up.record);
}

#[test]
fn a_ramp_that_no_column_tells_is_told_by_its_time() {
    let table = include_str!("../golden/meaning/ramp-in-relaxation.csv");
    let reading = |ramp_time_s| TableDetails {
        strain: Some(0.05),
        ramp_time_s,
        ..TableDetails::default()
    };
    let step = understood(table, &reading(None)).expect("a step");
    assert_says(
        &said(&fitted(&step)),
        "the modulus rises 9 times before it falls, as in a ramp to the held strain: give `ramp_time_s`, or a strain column",
    );
    let read = understood(table, &reading(Some(1.0))).expect("a ramp");
    let ramp = fitted(&read);
    // Noise of 0.5 % in 130 samples.
    assert_fit(&ramp, RAMP, 0.005);
    for (found, truth) in ramp.fits[0].parameters.iter().zip(RAMP) {
        assert!(is_inside(found, truth), "{found:?}");
    }
    for (ramp, message) in [
        (0.0, "`ramp_time_s` 0 s is not above 0 s"),
        (60.0, "below the last time 60 s"),
        (f64::NAN, "NaN s is not above"),
    ] {
        assert_refused(understood(table, &reading(Some(ramp))), message);
    }
    let creep = "time_s,creep_compliance_per_pa\n1,1e-3\n2,2e-3\n";
    let ramp = TableDetails {
        strain: None,
        ..reading(Some(1.0))
    };
    assert_refused(understood(creep, &ramp), "`ramp_time_s` 1 s has no effect");
}

const RAMP: [f64; 2] = [3000.0, 0.2];
