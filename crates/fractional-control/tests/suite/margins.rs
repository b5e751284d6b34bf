//! Margins and peaks against closed forms, and the notation of controllers.

use crate::fixture::{Draw, bdf2, plant};
use fracdiff::Seconds;
use fractional_control::{
    ControlError, ControllerParameters, FractionalTransferFunction, HeldPlant, PidParameters,
    Plant, SampledControlLoop,
};
use std::str::FromStr as _;
use testkit::{assert_close, assert_refused, assert_relative};

const T: Seconds = Seconds(1e-3);

fn closed(function: &str, controller: &str) -> SampledControlLoop {
    let memory = bdf2(1e-8, 100.0);
    let controller = controller.parse().expect("a controller");
    crate::fixture::closed(controller, &plant(function), memory, T.0)
}

/// A controller that is a function.
fn of_function(plant: &str, controller: &str) -> SampledControlLoop {
    let memory = bdf2(1e-8, 100.0);
    let controller = FractionalTransferFunction::from_str(controller).expect("a function");
    let plant = HeldPlant::new(&self::plant(plant), memory, T).expect("runs");
    SampledControlLoop::new(ControllerParameters::Function(controller), memory, &plant)
        .expect("a loop")
}

/// True if it is stable with so much more delay.
fn stable(later: impl Fn(f64) -> Result<SampledControlLoop, ()>, delay: f64) -> bool {
    later(delay).expect("runs").verdict().stable
}
/// k·e^(−Ls)/s: crossover k, margin π/2 − kL, gain margin π/(2kL), delay margin π/(2k) − L, with L longer by half a sample.
#[test]
fn an_integrator_with_a_dead_time_has_the_margins_of_its_formula() {
    let (k, dead) = (4.0, 0.1 + 0.5 * T.0);
    let margins = closed("exp(-0.1s)/s", "4").margins();
    let phase = margins.phase.expect("a crossover");
    let half = 0.5 * std::f64::consts::PI;
    assert_close("crossover", phase.omega_rad_s, k, 1e-4);
    assert_close("phase", phase.value, half - k * dead, 1e-4);
    let gain = margins.gain_up.expect("a crossing");
    assert_close("gain", gain.value, half / (k * dead), 1e-3);
    let delay = margins.delay_s.expect("a crossover");
    assert_close("delay", delay.value, half / k - dead, 1e-4);
    assert_eq!((margins.crossovers, margins.gain_down), (1, None));
}

/// k/s, held, and h of a sample late: z² − (1 − kT(1 − h))z + kTh. Its poles come to the circle at h = 1/(kT), of which whole samples would give
/// less.
#[test]
fn a_delay_margin_of_a_part_of_a_sample_is_that_of_the_hold() {
    for rate in [1.1, 1.25, 1.6, 1.9] {
        let later = |delay: f64| {
            let gain = rate / T.0;
            Ok::<_, ()>(closed(&format!("{gain}*exp(-{delay}s)/s"), "1"))
        };
        let closed = later(0.0).expect("runs");
        let first = closed.margins().delay_s.expect("a crossover");
        let found = SampledControlLoop::delay_margin(Some(first), &later).expect("runs");
        let found = found.expect("a margin").value;
        let wanted = T.0 / rate;
        assert_relative("found", found, wanted, 1e-6);
        assert!((first.value / wanted - 1.0).abs() > 0.05, "{first:?}");
        assert!(stable(later, 0.999 * found) && !stable(later, 1.001 * found));
    }
}

/// (s² + 1)/((s² + r)(s + 2)): L is next to 1/(s + 2) but for a peak as narrow as the gap between zero and pole, through which L turns once round.
/// Its edge is where the verdict changes, not where a grid looks; the pair is the plant's or the controller's.
#[test]
fn a_narrow_peak_beside_a_zero_has_its_margins() {
    for (gap, is_plants) in [
        (1e-3, true),
        (1e-5, true),
        (1e-8, true),
        (1e-3, false),
        (1e-5, false),
    ] {
        let later = |delay: f64| {
            let (late, pair) = (
                format!("exp(-{delay}s)"),
                format!("(s^2+1)/(s^2+{})", 1.0 + gap),
            );
            Ok::<_, ()>(if is_plants {
                closed(&format!("{late}*{pair}/(s+2)"), "1")
            } else {
                of_function(&format!("{late}/(s+2)"), &pair)
            })
        };
        let prompt = later(0.0).expect("runs");
        let margins = prompt.margins();
        // There L is every real number times 1/(2 + j) behind the hold, whose line passes −1 at the sine of its angle.
        let angle = 0.5_f64.atan() + 0.5 * T.0;
        let peak = margins.sensitivity.value;
        assert_close("peak", peak * angle.sin(), 1.0, 1e-3);
        let phase = margins.phase.expect("a crossover").value;
        assert_close("phase", phase, -angle, 1e-3);
        assert_eq!((margins.crossovers, margins.gain_down), (2, None), "{gap}");
        let delay = SampledControlLoop::delay_margin(margins.delay_s, &later).expect("runs");
        let delay = delay.expect("a crossover").value;
        // Of a pole this near to the circle no verdict tells on which side it is.
        if gap > 1e-7 {
            let edge = stable(later, 0.999 * delay) && !stable(later, 1.001 * delay);
            assert!(edge, "{gap}: {delay}");
        }
    }
}

/// A swing that is fast for its samples is lost for some parts of a sample and back with a whole one: the margin is the first loss.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_delay_within_the_margin_loses_the_loop() {
    let mut draw = Draw(11);
    let mut tried = 0;
    while tried < 12 {
        let (turn, damping) = (draw.from(0.4, 6.0), draw.scale(0.01, 0.5));
        let omega = turn / T.0;
        let gain = draw.scale(0.02, 2.0) * omega * omega;
        let start = draw.from(0.0, 2.0) * T.0;
        let text = |delay: f64| {
            let damped = 2.0 * damping * omega;
            format!("{gain}*exp(-{delay}s)/(s^2+{damped}s+{})", omega * omega)
        };
        let later = |delay: f64| Ok::<_, ()>(closed(&text(start + delay), "1"));
        let now = later(0.0).expect("runs");
        let first = now.margins().delay_s.filter(|_| now.verdict().stable);
        if first.is_none() {
            continue;
        }
        tried += 1;
        let found = SampledControlLoop::delay_margin(first, &later).expect("runs");
        let found = found.expect("a margin").value;
        let lost = lost_before(later, found);
        assert!(
            lost.is_none() && !stable(later, 1.001 * found),
            "{found} {lost:?}"
        );
    }
}

/// A delay before the margin with which the loop is lost.
fn lost_before(later: impl Fn(f64) -> Result<SampledControlLoop, ()>, margin: f64) -> Option<f64> {
    let mut shares = (1..=32).map(|k| f64::from(k) / 32.0 * 0.999 * margin);
    shares.find(|delay| !stable(&later, *delay))
}

/// Near half the sample rate two aliases meet: at whole samples |L| is never 1, and a part of a sample loses the loop.
#[test]
fn a_loop_without_a_crossover_has_the_delay_margin_of_its_parts() {
    for (omega, damping, gain, start) in [
        (3727.613, 0.07004, 2.792_25e6, 1.047_84e-3),
        (3213.58, 0.038_977, 1.975_35e6, 0.695_806e-3),
        (3099.368, 0.073_387, 1.935_11e6, 1.413_553e-3),
    ] {
        let later = |delay: f64| {
            let (damped, square, dead) = (2.0 * damping * omega, omega * omega, start + delay);
            let plant = format!("{gain}*exp(-{dead}s)/(s^2+{damped}s+{square})");
            Ok::<_, ()>(closed(&plant, "1"))
        };
        let now = later(0.0).expect("runs");
        assert!(now.verdict().stable, "{omega}");
        assert_eq!(now.margins().delay_s, None, "{omega}");
        let found = SampledControlLoop::delay_margin(None, &later).expect("runs");
        let found = found.expect("a margin").value;
        let lost = lost_before(later, found);
        assert!(
            lost.is_none() && !stable(later, 1.001 * found),
            "{found} {lost:?}"
        );
    }
    // A loop that no dead time loses.
    let later = |delay: f64| Ok::<_, ()>(closed(&format!("0.5*exp(-{delay}s)/(s+1)"), "1"));
    assert_eq!(SampledControlLoop::delay_margin(None, &later), Ok(None));
}

/// A loop that is lost next to whole samples only.
#[test]
fn a_loss_at_whole_samples_is_found_however_short() {
    // 0.05 + 0.6s of samples of 1 s.
    let controller = format!("{}+0.6s", 0.05 / T.0);
    let later = |delay: f64| {
        let plant = format!("exp(-{}s)/s", 0.99 * T.0 + delay);
        Ok::<_, ()>(closed(&plant, &controller))
    };
    let first = later(0.0).expect("runs").margins().delay_s;
    let found = SampledControlLoop::delay_margin(first, &later).expect("runs");
    let found = found.expect("a margin").value;
    let edge = stable(later, 0.999 * found) && !stable(later, 1.001 * found);
    assert!(found < 0.01 * T.0 && edge, "{found}");
}

/// T = 1/(τs + 1) of a first-order loop: |T| never above 1, |S| at most a hair more by the hold.
#[test]
fn peaks_are_those_of_the_loop_and_bounded_by_the_margin() {
    let closed = |plant, controller| self::closed(plant, controller);
    let margins = closed("exp(-0.1s)/s", "4").margins();
    let at = margins.sensitivity.omega_rad_s;
    let l = closed("exp(-0.1s)/s", "4").open(at * T.0);
    let peak = (l + 1.0).inv().norm();
    assert_relative("peak", peak, margins.sensitivity.value, 1e-12);
    // |S| at the crossover is 1/(2 sin(φ/2)).
    let phase = margins.phase.expect("a crossover").value;
    assert!(margins.sensitivity.value >= 0.5 / libm::sin(0.5 * phase) - 1e-9);
    let slow = closed("1/s", "1").margins();
    assert!(slow.complementary.value < 1.0 + 1e-3 && slow.sensitivity.value < 1.01);
}

#[test]
fn a_controller_is_read_and_printed_alike() {
    let controllers = "20.5+3.7343s^1.15 2+3/s^0.9+0.1s^0.5 3/s -1-2s 1.5 2s^0.5";
    for text in controllers.split(' ') {
        let read: PidParameters = text.parse().expect(text);
        assert_eq!(read.to_string(), text);
    }
}

#[test]
fn what_is_no_pid_is_refused_with_the_form_to_give() {
    for text in "1/(s+1) s+s^0.5 1/s+1/s^0.5 exp(-1s) s^2.5 1/s^3".split(' ') {
        let error = text.parse::<PidParameters>().expect_err(text).to_string();
        assert!(
            error.contains("PI^λD^μ") || error.contains("above 0 and at most 2"),
            "{text}: {error}"
        );
    }
    assert!(matches!(
        "2+".parse::<PidParameters>(),
        Err(ControlError::Notation { .. })
    ));
}

#[test]
fn further_dead_time_adds_and_is_never_negative() {
    let plant: Plant = "exp(-0.1s)/(s+1)".parse().expect("a plant");
    let later = |more| plant.clone().delayed(more);
    assert_close("later", later(0.2).expect("later").delay_s(), 0.3, 1e-15);
    assert_refused(later(-0.05), "-0.05");
}

/// k(s + a)/s on 1/(s/a + 1) is ka/s: crossover ka, a phase margin of π/2, and π/(2ka) s of dead time, however slow that is against 1 ms.
#[test]
fn a_loop_that_is_slow_against_its_samples_has_its_delay_margin() {
    for (plant, controller, crossover) in [
        ("1/(1000s+1)", "4+0.004/s", 4e-3),
        ("1/(1000s+1)", "0.001+0.000001/s", 1e-6),
        ("1/(1000000s+1)", "0.001+0.000000001/s", 1e-9),
    ] {
        let closed = closed(plant, controller);
        assert_eq!(closed.memory_s(), None, "{plant}");
        let margins = closed.margins();
        let phase = margins.phase.expect(plant);
        let half = 0.5 * std::f64::consts::PI;
        assert_relative(plant, phase.omega_rad_s, crossover, 1e-5);
        assert_relative(plant, phase.value, half, 1e-5);
        let delay = margins.delay_s.expect(plant).value;
        assert_relative(plant, delay, half / crossover, 1e-5);
    }
    // Of the controller, and of the plant.
    let of_a_memory = [("1/(1000s+1)", "1+1/s^0.5"), ("1/(s^0.5+1)", "1")];
    for (plant, controller) in of_a_memory {
        assert_eq!(closed(plant, controller).memory_s(), Some(100.0));
    }
}

/// k on 1/(s/a − 1) needs a gain above 1, at rest, however small a is.
#[test]
fn the_least_gain_of_a_plant_that_grows_slowly_is_found_at_rest() {
    for plant in ["1/(10s-1)", "1/(1000s-1)", "1/(10000000s-1)"] {
        let down = closed(plant, "4").margins().gain_down.expect(plant);
        assert_close(plant, down.value, 0.25, 1e-6);
    }
}

/// Two integrators and two poles: what the samples are at low frequency is the plant, with half a sample more dead time.
#[test]
fn integrators_beside_other_poles_stay_integrators_far_down() {
    let memory = bdf2(1e-8, 100.0);
    let plant = plant("1/(s^4+3s^3+2s^2)");
    let closed = crate::fixture::closed(crate::fixture::p(1.0), &plant, memory, 1.0);
    for theta in [1e-3, 1e-6, 1e-9, 1e-12] {
        let moved = closed.open(theta) * -2.0 * theta * theta;
        assert_close("size", moved.norm(), 1.0, 1e-4);
        // −(1.5 + 0.5)θ of the poles and the hold.
        assert_close("angle", moved.arg(), -2.0 * theta, 1e-3 * theta);
    }
}
