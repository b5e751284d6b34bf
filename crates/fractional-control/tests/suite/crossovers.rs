//! Loops with more than one crossover: the wished one has the least margin, or it is told.

use crate::fixture::{every, not_flat};
use fracdiff::Seconds;
use fractional_control::tuning::{Specification, Tuned, WishName, tune, tune_integer};
use fractional_control::{Memory, Plant, Rule, SampledLoop, SampledPlant};

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
fn the_wished_crossover_is_the_one_with_the_least_margin() {
    for text in ["1/(0.8s^2.2+0.5s^0.9+1)", "1/(s^2+0.05s+1)", "1/(s^1.8+1)"] {
        let plant: Plant = text.parse().expect("valid");
        for (omega, margin) in [(2.0, 55.0_f64), (3.0, 70.0), (5.0, 55.0), (8.0, 40.0)] {
            let wishes = Specification::new(omega, margin.to_radians());
            let sampling = every(0.02 / omega);
            let tuned = tune(&plant, Some(sampling), &wishes).expect("tuned");
            assert!(tuned.unmet.is_empty(), "{text} {omega} {:?}", tuned.unmet);
            let least = least_margin(&tuned, &plant, omega);
            assert!(
                least > 0.97 * wishes.phase_margin_rad,
                "{text} {omega} {least}"
            );
        }
    }
}

#[test]
fn easy_designs_are_found() {
    // An unstable lag whose phase rises at the crossover; a swing that hardly decays, above the crossover.
    for (text, omega, margin, t) in [
        ("1/(s-1)", 3.0, 70.0_f64, 5e-3),
        ("1/(s-1)", 1.5, 60.0, 0.01),
        ("1/(s-1)", 2.0, 70.0, 0.01),
        ("1.02832exp(-0.4s)/(s^2+0.021s+0.291)", 0.25, 60.0, 0.05),
    ] {
        let plant: Plant = text.parse().expect("valid");
        let wishes = not_flat(omega, margin.to_radians());
        let sampling = every(t);
        let tuned = tune(&plant, Some(sampling), &wishes);
        let tuned = tuned.unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(tuned.unmet.is_empty(), "{text} {:?}", tuned.unmet);
        assert!(tuned.measures.stable_over_gains, "{text}");
    }
}

#[test]
fn a_plant_that_falls_slowly_is_judged_with_its_aliases() {
    // Near half the sample rate these see more than twice the gain that 1/ω alone has there.
    let plant: Plant = "(s^2+0.4s+2)/(s(s^2+0.3s+1))".parse().expect("valid");
    let sample_time = Seconds(0.02);
    let sampling = every(sample_time.0);
    let wishes = Specification::new(1.0, 40_f64.to_radians());
    for tuned in [
        tune(&plant, Some(sampling), &wishes),
        tune_integer(&plant, Some(sampling), &wishes),
    ] {
        let tuned = tuned.expect("tuned");
        let memory = Memory::new(Rule::Bdf2, 1e-6, 100.0).expect("valid");
        let sampled = SampledPlant::new(&plant, memory, sample_time).expect("valid");
        let closed = SampledLoop::new(tuned.parameters.into(), memory, &sampled).expect("valid");
        assert!(tuned.measures.stable && closed.verdict().stable);
        let least = closed.margins().phase.expect("a crossover").value;
        // Another crossover with less margin is told.
        let told = tuned
            .unmet
            .iter()
            .find(|unmet| unmet.name == WishName::PhaseMargin);
        let foreseen = told.map_or(wishes.phase_margin_rad, |unmet| unmet.reached);
        // To the points of the tuner's grid.
        assert!((least - foreseen).abs() < 0.1, "{least} {foreseen}");
    }
}
