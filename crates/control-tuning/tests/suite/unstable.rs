//! Plants that do not hold themselves, tuned and proved.

use crate::fixture::{bdf2, every, not_flat, states};
use control_tuning::{Sampling, Specification, tune, tune_integer};
use fracdiff::Seconds;
use fractional_control::{PidParameters, Plant, SampledControlLoop};
use testkit::{assert_close, assert_refused, assert_relative};

fn closed(gains: PidParameters, plant: &Plant, t: Seconds) -> SampledControlLoop {
    let memory = bdf2(1e-6, 1e5 * t.0);
    crate::fixture::closed(gains, plant, memory, t.0)
}

/// Checks crossover, margin and verdict of the sampled loop; true if it is proved for half to double the gain.
fn certified(text: &str, gains: PidParameters, sampling: Sampling, wishes: &Specification) -> bool {
    let plant: Plant = text.parse().expect("valid");
    let t = sampling.sample_time;
    let closed = closed(gains, &plant, t);
    let open = closed.open(wishes.crossover_rad_s * t.0);
    assert!((open.norm() - 1.0).abs() < 0.02, "{text}: {open}");
    let margin = (-open).arg() - wishes.phase_margin_rad;
    assert!(margin.abs() < 0.02, "{text}: {margin}");
    assert!(closed.verdict().stable, "{text}");
    closed.is_stable_over(0.5, 2.0)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn unstable_plants_are_tuned_and_every_verdict_is_proved() {
    // Real poles, a fast one beside them, a pole at 0, a pendulum, poles on the axis, fractional, either sign, a dead time.
    for (text, flat) in [
        ("1/(s-1)", true),
        ("-3/(s-1)", true),
        ("1/(s-1)/(0.01s+1)", true),
        ("2exp(-0.01s)/(0.5s-1)", true),
        ("2/(s^0.8-0.5)", true),
        ("1/(s^1.3-1)", false),
        ("1/(s^2-1)", true),
        ("1/(s^2-0.2s+1)", true),
        ("1/(s^2+1)", false),
        ("1/(s*(s-1))", true),
    ] {
        let plant: Plant = text.parse().expect("valid");
        let wishes = Specification {
            iso_damping: flat,
            ..Specification::new(10.0, 60_f64.to_radians())
        };
        let sampling = every(2e-3);
        let tuned = tune(&plant, Some(sampling), &wishes);
        let tuned = tuned.unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(tuned.measures.stable_over_gains, "{text}");
        assert!(
            certified(text, tuned.parameters, sampling, &wishes),
            "{text}"
        );
        let integer = tune_integer(&plant, Some(sampling), &wishes);
        let integer = integer.unwrap_or_else(|error| panic!("{text}: {error}"));
        // What the grid promises for other gains is not yet a proof: near half the sample rate it does not see what is folded.
        let robust = certified(text, integer.parameters, sampling, &wishes);
        assert!(integer.measures.stable_over_gains || !robust, "{text}");
    }
}

#[test]
fn matrices_of_an_unstable_plant_are_tuned_as_its_function_is() {
    let states = states([[0.0, 1.0], [1.0, 0.0]], [0.0, 1.0], [1.0, 0.0]);
    let states = Plant::state_space(states, 0.0).expect("valid");
    let function: Plant = "1/(s^2-1)".parse().expect("valid");
    let wishes = not_flat(5.0, 1.0);
    let [a, b] = [states, function].map(|plant| tune(&plant, None, &wishes).expect("tuned"));
    let (have, want) = (a.parameters.response(5.0), b.parameters.response(5.0));
    assert!((have - want).norm() < 1e-6 * want.norm(), "{have} {want}");
    assert!(a.measures.stable && a.measures.stable_over_gains);
}

/// G(jω) of 1/(s² − a²) is −1/(ω² + a²): C has the margin as its phase at the crossover, there it stands still, and in another time all is the same.
#[test]
fn a_pendulum_is_held_with_a_flat_phase() {
    let margin = 60_f64.to_radians();
    let designs = [1.0, 4.0].map(|a: f64| {
        let text = format!("1/(s^2-{})", a * a);
        let plant: Plant = text.parse().expect("valid");
        let (omega, sampling) = (3.0 * a, every(5e-3 / a));
        let wishes = Specification::new(omega, margin);
        let tuned = tune(&plant, Some(sampling), &wishes).expect("tuned");
        assert!(tuned.unmet.is_empty(), "{:?}", tuned.unmet);
        assert!(certified(&text, tuned.parameters, sampling, &wishes));
        let parameters = tune(&plant, None, &wishes).expect("tuned").parameters;
        let size = parameters.response(omega).norm() / (omega * omega + a * a);
        assert_close("size", size, 1.0, 1e-9);
        for (factor, most) in [(1.0, 1e-9), (1.01, 1e-4), (0.99, 1e-4)] {
            let phase = parameters.response(factor * omega).arg();
            assert!((phase - margin).abs() < most, "{factor}: {phase}");
        }
        (a, parameters)
    });
    let [(_, one), (a, four)] = designs;
    let orders =
        |parameters: &PidParameters| [parameters.integral_order, parameters.derivative_order];
    assert_eq!(orders(&one), orders(&four));
    for (have, want) in [
        (four.proportional, one.proportional * a * a),
        (
            four.integral,
            one.integral * a.powf(2.0 + one.integral_order),
        ),
        (
            four.derivative,
            one.derivative * a.powf(2.0 - one.derivative_order),
        ),
    ] {
        assert_relative("have", have, want, 1e-6);
    }
}

/// Where there is nothing, the wish that excludes it is named.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_wish_that_excludes_a_controller_is_named() {
    let flat = |omega, margin: f64| Specification::new(omega, margin.to_radians());
    for (text, wishes, message) in [
        ("1/(s-1)", flat(3.0, 70.0), "give up the flat phase"),
        ("1/(s^2-1)", flat(0.5, 60.0), "give up the flat phase"),
        (
            "exp(-0.2s)/(s-1)",
            not_flat(9.0, 1.0),
            "lower the crossover",
        ),
        (
            "exp(-0.2s)/(s-1)",
            not_flat(0.4, 1.0),
            "raise the crossover",
        ),
        ("exp(-0.5s)/(s-1)", not_flat(1.4, 1.5), "half that margin"),
        (
            "exp(-0.5s)/(s-1)",
            not_flat(0.1, 1.0),
            "above the unstable poles",
        ),
    ] {
        let plant: Plant = text.parse().expect("valid");
        assert_refused(tune(&plant, None, &wishes), message);
    }
}
