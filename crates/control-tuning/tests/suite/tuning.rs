//! Tuning: every wish met or named, robustness against the integer PID, refusals.

use crate::fixture::{bdf2, every, held, states};
use control_tuning::{Bound, Sampling, Specification, Tuned, WishName, tune, tune_integer};
use fracdiff::Seconds;
use fractional_control::{HeldPlant, Plant, PowerMemory, Rule, SampledControlLoop};
use testkit::{Tested, assert_close, assert_refused, assert_relative};

/// Plant, crossover in rad/s, margin in degrees: 20 of first order with dead time, 15 of second order, 15 fractional.
pub(crate) fn plants() -> Vec<(String, f64, f64)> {
    let mut all = Vec::new();
    for (k, tau) in [0.5_f64, 1.0, 4.0, 20.0, 62.0].into_iter().enumerate() {
        for (i, late) in [0.05, 0.1, 0.2, 0.4].into_iter().enumerate() {
            let delay = late * tau;
            // Below the dead time, above the lag.
            let omega = (0.45 / delay).min(6.0 / tau);
            let gain = 0.5 + 0.7 * (k + i) as f64;
            let text = format!("{gain:.2}*exp(-{delay}s)/({tau}s+1)");
            all.push((text, omega, 55.0 + 5.0 * i as f64));
        }
    }
    for (k, damping) in [0.3, 0.5, 0.7, 1.0, 1.6].into_iter().enumerate() {
        for (i, omega) in [0.5_f64, 2.0, 10.0].into_iter().enumerate() {
            let (a, b) = (1.0 / (omega * omega), 2.0 * damping / omega);
            let gain = 0.8 + 0.4 * k as f64;
            let text = format!("{gain}/({a}s^2+{b}s+1)");
            all.push((text, 2.5 * omega, 50.0 + 7.0 * i as f64));
        }
    }
    for (k, order) in [0.6, 0.9, 1.2, 1.5, 1.9].into_iter().enumerate() {
        for (i, coefficient) in [0.3, 0.8, 2.0].into_iter().enumerate() {
            let inner = 0.4 * order;
            let gain = 1.0 + 0.3 * i as f64;
            let text = format!("{gain:.1}/(s^{order}+{coefficient}s^{inner:.2}+1)");
            all.push((text, 3.0, 60.0 + 2.0 * k as f64));
        }
    }
    all
}

fn wishes(omega: f64, margin: f64) -> Specification {
    Specification {
        noise: bound(30.0 * omega, 0.2),
        disturbance: bound(0.01 * omega, 0.1),
        ..Specification::new(omega, margin.to_radians())
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn fifty_plants_are_tuned_to_every_wish_or_told_why_not() {
    let all = plants();
    assert_eq!(all.len(), 50);
    let mut met = 0;
    for (text, omega, margin) in &all {
        let plant: Plant = text.parse().expect("valid");
        let wishes = wishes(*omega, *margin);
        match tune(&plant, None, &wishes) {
            Ok(tuned) => {
                checked(&tuned, &plant, &wishes);
                met += usize::from(tuned.unmet.is_empty());
            }
            Err(error) => println!("{text} at {omega:.3}, {margin}°: {error}"),
        }
    }
    assert!(met >= 40, "{met}");
}

/// Crossover, margin and flatness from the plant and the controller alone, and the bounds on a fine grid.
fn checked(tuned: &Tuned, plant: &Plant, wishes: &Specification) {
    let open = |omega: f64| tuned.parameters.response(omega) * plant.response(omega).expect("any");
    let here = wishes.crossover_rad_s;
    assert_close("crossover", open(here).norm(), 1.0, 0.01);
    let asked = wishes.phase_margin_rad;
    assert_relative("margin", (-open(here)).arg(), asked, 0.01);
    let slope = (open(1.001 * here) / open(here / 1.001)).arg() / (2.0 * 1.001_f64.ln());
    assert!(slope.abs() < 0.01, "{slope}");
    let missed = |what| tuned.unmet.iter().any(|unmet| unmet.name == what);
    let least = least_margin(tuned, plant, here);
    let held = missed(WishName::PhaseMargin) || least > 0.97 * asked;
    assert!(held, "{least}");
    for k in 0..=400 {
        let omega = here * 10f64.powf(f64::from(k) / 100.0 - 1.0) * 30.0 / 10.0;
        let t = open(omega) / (open(omega) + 1.0);
        if let Some(bound) = wishes.noise
            && omega >= bound.omega_rad_s
            && omega <= 900.0 * here
        {
            // 1 % and the distance of two points of the tuner's grid.
            let held = missed(WishName::Noise) || t.norm() <= 1.02 * bound.at_most;
            assert!(held, "{omega} {t}");
        }
        let omega = here * 0.01 * 10f64.powf(-f64::from(k) / 300.0);
        let s = (open(omega) + 1.0).inv();
        if let Some(bound) = wishes.disturbance {
            let held = missed(WishName::Disturbance) || s.norm() <= 1.02 * bound.at_most;
            assert!(held, "{omega} {s}");
        }
    }
}

#[test]
fn the_sampled_loop_that_was_tuned_is_certified_stable_and_has_its_margin() -> Tested {
    let states = states([[0.0, 1.0], [0.0, -53.8]], [0.0, 15.4], [1.0, 0.0]);
    let states = states.behind_lag(1e-3)?;
    let plants = [
        Plant::state_space(states, 0.5e-3)?,
        "15.4*exp(-0.0005s)/(s^2+53.8s)".parse()?,
    ];
    for plant in plants {
        let (t, omega) = (Seconds(1e-3), 80.0);
        let sampling = Sampling {
            sample_time: t,
            rule: Rule::Grunwald,
        };
        let tuned = tune(&plant, Some(sampling), &Specification::new(omega, 1.0))?;
        assert!(tuned.unmet.is_empty(), "{:?}", tuned.unmet);
        let memory = PowerMemory::new(Rule::Grunwald, 1e-6, 50.0)?;
        let second = bdf2(1e-6, 50.0);
        let sampled = HeldPlant::new(&plant, second, t)?;
        let closed = SampledControlLoop::new(tuned.parameters.into(), memory, &sampled)?;
        assert!(closed.verdict().stable);
        // What the plant folds back from above half the sample rate is not in the design.
        let open = closed.open(omega * t.0);
        assert_close("crossover", open.norm(), 1.0, 0.01);
        assert_close("margin", (-open).arg(), 1.0, 0.01);
    }
    Ok(())
}

#[test]
fn a_measured_response_is_tuned_for_as_its_plant_is() {
    let plant: Plant = "2*exp(-0.2s)/(3s+1)".parse().expect("valid");
    let points: Vec<_> = (0..=300)
        .map(|k| 1e-3 * 10f64.powf(f64::from(k) / 60.0))
        .map(|omega| (omega, plant.response(omega).expect("any")))
        .collect();
    let measured = Plant::measured(&points).expect("valid");
    let wishes = Specification::new(1.0, 1.1);
    let [a, b] = [&plant, &measured].map(|plant| tune(plant, None, &wishes).expect("tuned"));
    let (have, want) = (b.parameters.response(1.0), a.parameters.response(1.0));
    assert!((have - want).norm() < 0.01 * want.norm(), "{have} {want}");
}

pub(crate) fn bound(omega_rad_s: f64, at_most: f64) -> Option<Bound> {
    Some(Bound {
        omega_rad_s,
        at_most,
    })
}

#[test]
fn wishes_that_contradict_each_other_are_named() {
    let plant: Plant = "exp(-0.1s)/(s+1)".parse().expect("valid");
    type Wish = fn(&mut Specification);
    const CASES: [(Wish, [&str; 2]); 9] = [
        (
            |wish| wish.noise = bound(0.5, 0.1),
            ["`noise` 0.1", "`crossover_rad_s` 1"],
        ),
        (
            |wish| wish.disturbance = bound(2.0, 0.1),
            ["`disturbance` 0.1", "`crossover_rad_s` 1"],
        ),
        (
            |wish| wish.sensitivity_peak = Some(1.01),
            ["`sensitivity_peak` 1.01", "`phase_margin_rad` 1"],
        ),
        (
            |wish| wish.complementary_peak = Some(0.9),
            ["`complementary_peak` 0.9", "`phase_margin_rad` 1"],
        ),
        (
            |wish| wish.phase_margin_rad = 4.0,
            ["phase margin 4 rad", "below π"],
        ),
        (
            |wish| wish.crossover_rad_s = -1.0,
            ["crossover -1 rad/s", "above 0"],
        ),
        (
            |wish| wish.crossover_rad_s = f64::NAN,
            ["crossover NaN", "above 0"],
        ),
        (
            |wish| wish.crossover_rad_s = 60.0,
            ["60", "lower one of the two"],
        ),
        (
            |wish| wish.crossover_rad_s = 20.0,
            ["was not found", "lower the crossover"],
        ),
    ];
    for (wish, parts) in CASES {
        let mut wishes = Specification::new(1.0, 1.0);
        wish(&mut wishes);
        let error = tune(&plant, None, &wishes)
            .expect_err("refused")
            .to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert!(!error.contains('\n'));
    }
}

#[test]
fn a_wish_that_is_out_of_reach_is_told_with_what_was_reached() {
    let plant: Plant = "exp(-0.1s)/(s+1)".parse().expect("valid");
    let base = Specification::new(1.0, 1.0);
    let slow = Some(Sampling {
        sample_time: Seconds(2.0),
        rule: Rule::Bdf2,
    });
    assert_refused(tune(&plant, slow, &base), "samples a period");
    let far = Specification {
        crossover_rad_s: 5.0,
        noise: bound(10.0, 1e-3),
        ..base
    };
    let tuned = tune(&plant, None, &far).expect("tuned as well as can be");
    let missed = &tuned.unmet[0];
    assert!(
        missed.name == WishName::Noise && missed.reached > 1e-3,
        "{missed}"
    );
    let words = missed.to_string();
    assert!(
        words.starts_with("`noise` 0.0010 is not reached"),
        "{words}"
    );
}

/// The least phase margin in size of all crossovers from a thousandth to a thousand times this frequency, rad.
pub(crate) fn least_margin(tuned: &Tuned, plant: &Plant, here: f64) -> f64 {
    let open = |omega: f64| tuned.parameters.response(omega) * plant.response(omega).expect("any");
    let grid: Vec<f64> = (0..=30_000)
        .map(|k| here * 10f64.powf(f64::from(k) / 5000.0 - 3.0))
        .collect();
    let crossings = grid.windows(2).filter(|pair| {
        let [a, b] = [open(pair[0]), open(pair[1])];
        (a.norm() < 1.0) != (b.norm() < 1.0)
    });
    let margins = crossings.map(|pair| (-open(pair[0])).arg().abs());
    margins.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_plant_that_falls_slowly_is_judged_with_its_aliases() -> Tested {
    // Near half the sample rate these see more than twice the gain that 1/ω alone has there.
    let plant: Plant = "(s^2+0.4s+2)/(s(s^2+0.3s+1))".parse()?;
    let sample_time = Seconds(0.02);
    let sampling = every(sample_time.0);
    let wishes = Specification::new(1.0, 40_f64.to_radians());
    for tuned in [
        tune(&plant, Some(sampling), &wishes),
        tune_integer(&plant, Some(sampling), &wishes),
    ] {
        let tuned = tuned?;
        let memory = bdf2(1e-6, 100.0);
        let sampled = HeldPlant::new(&plant, memory, sample_time)?;
        let closed = SampledControlLoop::new(tuned.parameters.into(), memory, &sampled)?;
        assert!(tuned.measures.stable && closed.verdict().stable);
        let least = closed.margins().phase.expect("a crossover").value;
        // Another crossover with less margin is told.
        let mut unmet = tuned.unmet.iter();
        let phase_margin = unmet.find(|unmet| unmet.name == WishName::PhaseMargin);
        let foreseen = phase_margin.map_or(wishes.phase_margin_rad, |unmet| unmet.reached);
        // To the points of the tuner's grid.
        assert_close("least", least, foreseen, 0.1);
    }
    Ok(())
}

/// Two lags, the fast one hidden at the crossover, and the plant with a dead time in its place: what leads by more than the second allows is chosen
/// by the flatness of the first alone.
#[test]
fn a_design_holds_where_a_fast_lag_is_a_dead_time() -> Tested {
    for (lags, late, omega, t) in [
        (
            "0.644/(3942.5s^2+171.1s+1)",
            "0.641exp(-24s)/(155s+1)",
            0.01,
            2.0,
        ),
        ("2/((10s+1)(0.5s+1))", "2exp(-0.5s)/(10s+1)", 0.3, 0.05),
    ] {
        let sampling = every(t);
        let wishes = Specification::new(omega, 60_f64.to_radians());
        let plant: Plant = lags.parse()?;
        let tuned = tune(&plant, Some(sampling), &wishes)?;
        assert!(tuned.measures.stable_with_dead_time, "{lags}");
        for text in [lags, late] {
            let plant: Plant = text.parse()?;
            let memory = bdf2(1e-6, 2000.0 * t);
            let plant = held(&plant, memory, t);
            let closed = SampledControlLoop::new(tuned.parameters.into(), memory, &plant)?;
            assert!(closed.verdict().stable, "{text}: {:?}", tuned.parameters);
        }
    }
    Ok(())
}
