//! Flat phases: the overshoot stays while the gain of the plant goes from half to double.

use super::tuning::{bound, plants};
use crate::fixture::every;
use fracdiff::Seconds;
use fractional_control::tuning::{
    GAINS, Sampling, Specification, Tuned, steps, tune, tune_integer,
};
use fractional_control::{Memory, Plant, Rule, SampledLoop, SampledPlant};
use testkit::{assert_close, assert_relative};

#[test]
fn a_mass_is_held_by_a_power_alone_and_its_overshoot_stays() {
    // 1/s² wants s^α, α = margin/90°: the ideal loop of Bode. All else is as small as the hold asks for.
    for (margin_deg, omega) in [(35.0, 1.0), (50.0, 1.0), (60.0, 20.0), (75.0, 8.0)] {
        let plant: Plant = "1/s^2".parse().expect("valid");
        let sampling = every(0.02 / omega);
        let wishes = Specification::new(omega, f64::to_radians(margin_deg));
        let tuned = tune(&plant, Some(sampling), &wishes).expect("a flat phase");
        assert!(tuned.unmet.is_empty() && tuned.measures.stable_over_gains);
        let own = &tuned.parameters;
        let order = own.derivative_order;
        let wanted = margin_deg / 90.0;
        assert_close("order", order, wanted, 0.03);
        let power = own.derivative * omega.powf(order);
        assert_relative("power", power, omega * omega, 0.05);
        let (spread, stable) = spread(&tuned, &plant, sampling.sample_time);
        assert!(stable && spread < 0.01, "{margin_deg}: {spread}");
    }
}

/// Crossover times dead time, rad, up to which a phase can be held flat over an octave to each side.
const FLAT: f64 = 0.35;

/// Simulated spread of the overshoot over ± 6 dB of gain, and true if all five loops are certified stable.
fn spread(tuned: &Tuned, plant: &Plant, t: Seconds) -> (f64, bool) {
    let memory = Memory::new(Rule::Bdf2, 1e-6, 2e4 * t.0).expect("valid");
    let steps = steps(&tuned.parameters, plant, memory, t, 4000).expect("runs");
    let all = steps.iter().map(|step| step.shape().overshoot);
    let (low, high) = all.fold((f64::MAX, f64::MIN), |(l, h), o| (l.min(o), h.max(o)));
    let sampled = SampledPlant::new(plant, memory, t).expect("runs");
    let closed = SampledLoop::new(tuned.parameters.into(), memory, &sampled).expect("a loop");
    let stable = |gain: &f64| closed.with_gain(*gain).verdict().stable;
    (high - low, GAINS.iter().all(stable))
}

/// At twice the gain the dead time has taken the phase: no PI^λD^μ is three times better there than the best PID, not even one whose phase need
/// not be flat.
fn nobody_can(text: &str, plant: &Plant, sampling: Option<Sampling>, wishes: &Specification) {
    let free = Specification {
        iso_damping: false,
        ..*wishes
    };
    let t = sampling.expect("sampled").sample_time;
    let best = tune(plant, sampling, &free).expect("tuned");
    let integer = tune_integer(plant, sampling, wishes).expect("tuned");
    let ((own, stable), (theirs, _)) = (spread(&best, plant, t), spread(&integer, plant, t));
    assert!(
        stable && own > theirs / 3.0,
        "{text}: {own} against {theirs}"
    );
    // The tuner says so.
    assert!(best.measures.overshoot_spread > 0.03, "{text}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_iso_damped_loop_overshoots_alike_where_the_integer_pid_does_not() {
    let fixed = [
        ("1/(0.4s+1)/(s+0.001)", 1.0, 60.0),
        ("exp(-0.1s)/(s+0.05)", 1.0, 60.0),
        ("0.55*exp(-1s)/(62s+1)", 0.1, 65.0),
        ("1/(s^1.5+0.2s^0.7+0.1)", 2.0, 65.0),
        ("1/(s^2+0.4s+0.04)", 1.5, 60.0),
        ("1/(s^1.2+0.3)", 3.0, 65.0),
    ];
    let fixed = fixed.map(|(text, omega, margin)| (text.to_owned(), omega, margin));
    let (mut better, mut alone, mut late) = (0, 0, 0);
    for (text, omega, margin) in fixed.into_iter().chain(plants()) {
        let plant: Plant = text.parse().expect("valid");
        let t = Seconds(0.02 / omega);
        let sampling = Some(every(t.0));
        // Both hold off disturbances: an integral that is next to nothing would leave them.
        let wishes = Specification {
            disturbance: bound(0.1 * omega, 0.1),
            ..Specification::new(omega, f64::to_radians(margin))
        };
        let fractional = tune(&plant, sampling, &wishes);
        let fractional = fractional.unwrap_or_else(|error| panic!("{text}: {error}"));
        let (own, stable) = spread(&fractional, &plant, t);
        assert!(stable, "{text}");
        if plant.delay_s() * omega > FLAT {
            late += 1;
            // The others are these three in another time and gain.
            if late <= 3 {
                nobody_can(&text, &plant, sampling, &wishes);
            }
            continue;
        }
        // The inverse transform on the grid, and the folding that it leaves out.
        let foreseen = fractional.measures.overshoot_spread;
        assert_close(&text, foreseen, own, 5e-3);
        let Ok(integer) = tune_integer(&plant, sampling, &wishes) else {
            alone += 1;
            continue;
        };
        let (theirs, _) = spread(&integer, &plant, t);
        if theirs >= 3.0 * own {
            better += 1;
        } else {
            // Where the integer PID is all but perfect there is nothing to gain.
            assert!(
                own < 2e-3 && theirs < 5e-3,
                "{text}: {own} against {theirs}"
            );
        }
    }
    // Of 56: three times better, without any integer PID beside it, with too long a dead time for either.
    assert_eq!((better, alone, late), (40, 1, 15));
}
