//! Stress and strain of records: closed forms of ramps from mpmath, sums of ramps, records that make no sense.

use haptic_tissue::{Model, ModelKind};
use testkit::{assert_close, assert_relative};

fn model(kind: &str, numbers: &[f64]) -> Model {
    let kind = ModelKind::from_name(kind).expect("known");
    testkit::tissue::model(kind, &numbers[..kind.parameters().len()])
}

/// Golden ramps: parameters, and (time, stress, strain) of a unit ramp.
fn golden() -> Vec<(String, Model, Vec<[f64; 3]>)> {
    let mut ramps: Vec<(String, Model, Vec<[f64; 3]>)> = Vec::new();
    let lines = include_str!("../golden/closed_forms.csv").lines();
    for line in lines.filter(|line| line.contains(",ramp-")) {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = (2..9).map(|i| cells[i].parse().expect("number")).collect();
        let label = format!("{},{}", cells[0], cells[2..7].join(","));
        let [time, value] = [numbers[5], numbers[6]];
        if !ramps.iter().any(|(known, ..)| *known == label) {
            ramps.push((label, model(cells[0], &numbers), Vec::new()));
        }
        // Strain follows stress, line by line.
        let rows = &mut ramps.last_mut().expect("one").2;
        match rows.last_mut() {
            Some(row) if cells[1] == "ramp-strain" => row[2] = value,
            _ => rows.push([time, value, f64::NAN]),
        }
    }
    ramps
}

#[test]
fn ramps_agree_with_mpmath_whatever_the_samples() {
    for (label, model, rows) in golden() {
        // Every golden time in one record, with samples between them at uneven distances.
        let mut times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        times.extend((0..400).map(|i| 5e-4 * libm::pow(10.0, f64::from(i) * 0.0131)));
        times.push(0.0);
        times.sort_by(f64::total_cmp);
        times.dedup();
        let (stress, strain) = (model.stress(&times, &times), model.strain(&times, &times));
        for [time, want_stress, want_strain] in rows {
            let at = times.partition_point(|t| *t < time);
            assert_relative(&label, stress[at], want_stress, 1e-10);
            assert_relative(&label, strain[at], want_strain, 1e-10);
        }
    }
}

#[test]
fn a_ramp_and_hold_is_a_difference_of_ramps_and_a_step_is_the_modulus() {
    for (label, model, _) in golden() {
        let times: Vec<f64> = (0..1001).map(|i| f64::from(i) * 0.01).collect();
        let hold: Vec<f64> = times.iter().map(|t| t.min(1.0)).collect();
        let late: Vec<f64> = times.iter().map(|t| (t - 1.0).max(0.0)).collect();
        let step = vec![1.0; times.len()];
        for stress in [true, false] {
            let respond = |input: &[f64]| {
                if stress {
                    model.stress(&times, input)
                } else {
                    model.strain(&times, input)
                }
            };
            let (whole, ramp, late) = (respond(&hold), respond(&times), respond(&late));
            let most = whole.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for at in 0..times.len() {
                let error = whole[at] - (ramp[at] - late[at]);
                let scale = most.max(ramp[at].abs());
                assert!(error.abs() < 1e-12 * scale, "{label} {at}: {error:e}");
            }
            let stepped = respond(&step);
            for at in [1, 2, 30, 1000] {
                let (want, scale) = if stress {
                    (
                        model.relaxation_moduli(&[times[at]])[0],
                        model.relaxation_moduli(&[times[1]])[0],
                    )
                } else {
                    (
                        model.creep_compliances(&[times[at]])[0],
                        model.creep_compliances(&[times[at]])[0],
                    )
                };
                let error = (stepped[at] - want).abs();
                assert!(error < 1e-11 * scale, "{label} {stress} {at}: {error:e}");
            }
        }
    }
}

#[test]
fn stress_undoes_strain() {
    let muscle = model("fractional-zener", &[876e3, 0.675, 22.1e3, 0.11, 1e5]);
    // Creep under a smooth load, then the stress of that strain; straight lines between samples differ by their curvature.
    let mut errors = Vec::new();
    for samples in [201, 401, 801] {
        let times: Vec<f64> = (0..samples)
            .map(|i| 10.0 * f64::from(i) / f64::from(samples - 1))
            .collect();
        let load: Vec<f64> = times.iter().map(|t| t * t * (10.0 - t)).collect();
        let back = muscle.stress(&times, &muscle.strain(&times, &load));
        let error = (load.iter().zip(&back)).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        errors.push(error);
    }
    let falls = errors[0] > 3.0 * errors[1] && errors[1] > 3.0 * errors[2];
    assert!(errors[0] < 0.1 && falls, "{errors:?}");
}

#[test]
fn a_prony_series_is_exact() {
    for elastic_modulus_pa in [0.0, 500.0] {
        let branches = [[2000.0, 0.01], [900.0, 0.5], [50.0, 30.0]];
        let values = [&[elastic_modulus_pa], branches.as_flattened()].concat();
        let model = testkit::tissue::model(ModelKind::Prony, &values);
        let modulus = |t: f64| {
            let branches = branches.iter();
            branches.fold(elastic_modulus_pa, |sum, [e, tau]| {
                sum + e * libm::exp(-t / tau)
            })
        };
        for t in [0.0, 1e-3, 0.1, 5.0, 100.0] {
            assert_relative(
                "model.relaxation_moduli(&[t])[0]",
                model.relaxation_moduli(&[t])[0],
                modulus(t),
                1e-14,
            );
        }
        // ∫ G(t − s)·J(s) ds = t: the strain of a stress that is the modulus is a step, so its stress response is too.
        let times: Vec<f64> = (0..4001).map(|i| f64::from(i) * 0.005).collect();
        let compliance = model.creep_compliances(&times);
        let stress = model.stress(&times, &compliance);
        // A step of 1 Pa; straight lines between samples leave the curvature of J.
        for stress in &stress[1..] {
            assert_close("step", *stress, 1.0, 0.02);
        }
        let mut at_ramp = elastic_modulus_pa * 20.0;
        for [e, tau] in branches {
            at_ramp -= e * tau * libm::expm1(-20.0 / tau);
        }
        let ramp = model.stress(&times, &times);
        assert_relative("ramp", ramp[4000], at_ramp, 1e-13);
    }
}

#[test]
fn records_that_make_no_sense_give_no_numbers() {
    let model = model("fractional-maxwell", &[876e3, 0.675, 22.1e3, 0.11]);
    assert!(model.stress(&[], &[]).is_empty());
    assert_eq!(model.stress(&[0.0], &[0.0]), [0.0]);
    assert!(model.stress(&[0.0, 1.0], &[0.1, 0.1])[0].is_infinite());
    let broken = model.stress(&[0.0, 1.0, 1.0, 2.0], &[0.0, 0.1, 0.1, 0.1]);
    assert!(broken[1] > 0.0 && broken[2].is_nan() && broken[3].is_nan());
    assert!(model.stress(&[f64::NAN, 1.0], &[0.0, 0.1])[0].is_nan());
    assert_eq!(model.stress(&[0.0, 1.0, 2.0], &[0.0, 0.1]).len(), 2);
}
