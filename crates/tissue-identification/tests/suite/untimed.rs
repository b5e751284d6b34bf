//! Motions without times, and others that tell less than they seem to.

use super::{among, candidate, fit, one, said, sphere, told, understood, values};
use testkit::{assert_refused, assert_relative, assert_says};
use tissue_identification::{HeldParameter, Options, Record, TableDetails, identify};

/// A sphere of 5 mm on a spring of 3 kPa, f = (16/9)·√R·E·δ^1.5, at depths alone.
fn depths(samples: u32) -> String {
    let rows = (0..samples).map(|n| {
        let depth = 1e-5 * f64::from(n);
        let force = 16.0 / 9.0 * 5e-3_f64.sqrt() * 3e3 * depth.powf(1.5);
        format!("{},{force}\n", 1e6 * depth)
    });
    "Depth (um),Force (N)\n".to_owned() + &rows.collect::<String>()
}

#[test]
fn a_table_of_depth_and_force_alone_gives_a_spring() {
    for samples in [50, 3000] {
        let read = understood(&depths(samples), &told(sphere(5e-3))).expect("a record");
        let found = one(&read.record, candidate("spring"));
        assert_relative("E", values(&found)[0], 3e3, 1e-4);
        assert!(!found.is_timed);
        assert_refused(
            identify(&read.record, &Options::default(), &|_| ()),
            "the samples have no times & `model` = spring",
        );
    }
}

/// Modulus of a spring, and of a spring-pot whose order is held at 0: V = Σεσ/Σε², whatever the times.
#[test]
fn a_motion_with_equal_times_is_fitted_without_memory() {
    let times = vec![0.0, 0.1, 0.1, 0.3, 0.3, 0.3, 0.7];
    let strain = vec![0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06];
    let stress = vec![0.0, 11.0, 19.0, 31.0, 38.0, 52.0, 60.0];
    let both = || strain.iter().zip(&stress);
    let wanted = both().map(|(e, s)| e * s).sum::<f64>() / both().map(|(e, _)| e * e).sum::<f64>();
    let record = Record::history(times, strain.clone(), stress.clone()).expect("valid");
    let found = one(&record, candidate("spring"));
    assert_relative("E", values(&found)[0], wanted, 1e-6);
    let held = Options {
        held: vec![HeldParameter {
            name: "order".to_owned(),
            low: 0.0,
            high: 0.0,
        }],
        ..among(&[candidate("spring-pot")])
    };
    let found = fit(&record, &held);
    assert_relative("V", values(&found)[0], wanted, 1e-6);
    assert_refused(
        identify(&record, &Options::default(), &|_| ()),
        "samples 2 and 3 have the same time, 0.1 s",
    );
    // Times that fall stay refused.
    let falls = Record::history(
        vec![0.0, 0.2, 0.1, 0.1],
        vec![0.0, 1.0, 2.0, 3.0],
        vec![0.0, 1.0, 2.0, 3.0],
    );
    assert_refused(falls, "comes after");
}

#[test]
fn a_sweep_of_amplitude_is_told_from_one_of_frequency() {
    let message = |omega: Vec<f64>| {
        let storage = vec![2000.0, 1990.0, 1900.0, 1700.0, 1500.0];
        let loss = vec![500.0, 505.0, 510.0, 520.0, 500.0];
        let record = Record::oscillation(omega, storage, loss).expect("valid");
        let found = one(&record, candidate("spring-pot"));
        said(&found).contains("all samples are of one frequency, 3.5 rad/s")
    };
    assert!(message(vec![3.5, 3.502, 3.5, 3.503, 3.5]));
    assert!(!message(vec![3.5, 7.0, 8.0, 9.0, 10.0]));
}

/// Compression that is written below 0 is the strain that was given.
#[test]
fn a_held_strain_may_have_either_sign() {
    let rows = (1..20).map(|n| format!("{n},-0.05,{}\n", -50.0 * f64::from(n).powf(-0.2)));
    let table = "time_s,strain,stress_pa\n".to_owned() + &rows.collect::<String>();
    let reading = |strain: f64| TableDetails {
        strain: Some(strain),
        ..TableDetails::default()
    };
    for strain in [0.05, -0.05] {
        let read = understood(&table, &reading(strain)).expect("a relaxation");
        assert_relative("G(1 s)", read.record.first()[0], 1000.0, 1e-12);
    }
    assert_refused(understood(&table, &reading(0.06)), "contradicts its column");
}

/// What is said is what widens: neighbours of a slow and of a fast swing are alike by the same, and count by another number.
#[test]
fn the_number_that_widens_the_intervals_is_said() {
    let time: Vec<f64> = (0..200).map(|n| 1e-2 * 1.03_f64.powi(n)).collect();
    let modulus = time.iter().enumerate().map(|(n, t)| {
        let swing = libm::sin(0.3 * n as f64);
        1000.0 * t.powf(-0.2) * (0.01 * swing).exp()
    });
    let record = Record::relaxation(time.clone(), modulus.collect()).expect("valid");
    let found = one(&record, candidate("spring-pot"));
    let fit = &found.fits[0];
    let ratio = fit.predicted.len() as f64 / fit.independent;
    assert!(ratio > 1.0);
    let shown: f64 = format!("{ratio:.2e}").parse().expect("a number");
    let wanted = format!("alike, over {shown} samples on average");
    assert_says(&said(&found), &wanted);
}
