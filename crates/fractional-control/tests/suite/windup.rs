//! Saturation: a limited step recovers as well as an unlimited one.

use crate::fixture::Draw;
use fracdiff::{Real, Seconds};
use fractional_control::{
    Actuator, Controller, FractionalPid, Memory, PidParameters, Plant, Rule, SampledPlant,
    SetPoint, simulate,
};

/// Advances with what was wanted, as if nothing had been limited: the history winds up.
#[derive(Clone)]
struct WindsUp(FractionalPid<f64, 64>);

impl Controller<f64> for WindsUp {
    type History = <FractionalPid<f64, 64> as Controller<f64>>::History;

    fn at_rest(&self) -> Self::History {
        self.0.at_rest()
    }
    fn wanted(&self, history: &Self::History, r: f64, y: f64) -> f64 {
        self.0.wanted(history, r, y)
    }
    fn output(&self, history: &Self::History, r: f64, y: f64) -> f64 {
        self.0.output(history, r, y)
    }
    fn advance(&self, history: &mut Self::History, r: f64, y: f64, _: f64) {
        let wanted = self.0.wanted(history, r, y);
        self.0.advance(history, r, y, wanted);
    }
    fn follow(&self, history: &mut Self::History, r: f64, y: f64, applied: f64) {
        self.0.follow(history, r, y, applied);
    }
    fn feedback_gain(&self) -> f64 {
        self.0.feedback_gain()
    }
    fn settled(&self, r: f64, y: f64, command: f64) -> Option<Self::History> {
        self.0.settled(r, y, command)
    }
    fn take_over(&self, other: &Self, history: &Self::History, r: f64, y: f64) -> Self::History {
        self.0.take_over(&other.0, history, r, y)
    }
}

#[test]
fn a_saturated_step_overshoots_no_more_than_an_unlimited_one() {
    let (t, memory) = (
        Seconds(0.01),
        Memory::new(Rule::Grunwald, 1e-6, 60.0).expect("valid"),
    );
    let gains =
        |proportional, integral, integral_order, derivative, derivative_order| PidParameters {
            proportional,
            integral,
            integral_order,
            derivative,
            derivative_order,
        };
    let mut wound_up = 0;
    for (plant, gains) in [
        ("1/(s+1)", gains(4.0, 6.0, 1.0, 0.0, 1.0)),
        ("1/(s+1)", gains(3.0, 5.0, 0.7, 0.0, 1.0)),
        ("1/(s^2+1.4s+1)", gains(3.0, 2.5, 1.0, 2.0, 1.0)),
        ("1/(s^2+1.4s+1)", gains(3.0, 2.5, 0.9, 2.0, 0.8)),
        ("1/(0.8s^2.2+0.5s^0.9+1)", gains(4.0, 2.0, 1.1, 3.0, 1.1)),
        ("exp(-0.2s)/(s+1)", gains(2.0, 2.0, 1.0, 0.0, 1.0)),
        ("exp(-0.2s)/(s^1.5+1)", gains(1.5, 1.0, 1.2, 0.5, 0.7)),
        ("1/(s^1.3+s^0.4)", gains(2.0, 1.0, 0.8, 0.5, 0.6)),
    ] {
        let plant_text = plant;
        let plant: Plant = plant.parse().expect("valid");
        let plant = SampledPlant::new(&plant, memory, t).expect("valid");
        let make = |actuator| {
            FractionalPid::<f64, 64>::new(gains, SetPoint::DEFAULT, actuator, memory, t)
                .expect("valid")
        };
        let free = simulate(&make(Actuator::UNLIMITED), &plant, |_| 1.0, 6000).shape();
        for high in [1.1, 1.3, 2.0] {
            let limited = make(Actuator::new(-high, high).expect("valid"));
            let shape = simulate(&limited, &plant, |_| 1.0, 6000).shape();
            let naive = simulate(&WindsUp(limited), &plant, |_| 1.0, 6000).shape();
            println!(
                "{plant_text} at ±{high}: free {:.4}, exact {:.4}, wound up {:.4}",
                free.overshoot, shape.overshoot, naive.overshoot
            );
            wound_up += i32::from(naive.overshoot > free.overshoot + 0.02);
            assert!(
                shape.overshoot <= free.overshoot + 0.02,
                "{plant_text} {high}"
            );
            assert!(shape.final_error < 0.02, "{plant_text} {high}: {shape:?}");
        }
    }
    // The test can fail: without it many do.
    assert!(wound_up >= 8, "{wound_up}");
}

/// A derivative against the other gains is a lag; by the inverse of the whole controller nothing would come back from a limit.
#[test]
fn a_derivative_of_the_other_sign_recovers_from_limits_too() {
    let (t, memory) = (
        Seconds(0.2),
        Memory::new(Rule::Bdf2, 1e-6, 1000.0).expect("valid"),
    );
    let plant: Plant = "0.55exp(-s)/(62s+1)".parse().expect("valid");
    let plant = SampledPlant::new(&plant, memory, t).expect("valid");
    for (integral, integral_order, derivative, derivative_order) in
        [(0.607, 0.9, -2.84, 0.606), (0.36, 1.0, -17.35, 1.0)]
    {
        let gains = PidParameters {
            proportional: 9.8,
            integral,
            integral_order,
            derivative,
            derivative_order,
        };
        for set_point in [SetPoint::DEFAULT, SetPoint::ERROR] {
            let make = |actuator| {
                FractionalPid::<f64, 64>::new(gains, set_point, actuator, memory, t).expect("valid")
            };
            let free = simulate(&make(Actuator::UNLIMITED), &plant, |_| 1.0, 3000).shape();
            for high in [2.0, 3.0, 5.0] {
                let limited = make(Actuator::new(0.0, high).expect("valid"));
                let shape = simulate(&limited, &plant, |_| 1.0, 3000).shape();
                assert!(
                    shape.overshoot <= free.overshoot + 0.02 && shape.final_error < 0.02,
                    "{derivative} {set_point:?} {high}: {shape:?} {free:?}"
                );
            }
        }
    }
}

/// A loop around 1/(s + 1) whose measurement carries even noise of this size; the mean of the output over the last half.
fn noisy_mean<F: Real>(
    gains: PidParameters,
    set_point: SetPoint,
    reference: f64,
    noise: f64,
) -> f64 {
    let (t, memory) = (
        Seconds(1e-3),
        Memory::new(Rule::Bdf2, 1e-6, 60.0).expect("valid"),
    );
    let actuator = Actuator::new(-1.0, 1.0).expect("valid");
    let pid = FractionalPid::<F, 64>::new(gains, set_point, actuator, memory, t).expect("valid");
    let (mut history, mut y, mut sum, mut draw) = (pid.at_rest(), 0.0_f64, 0.0, Draw(1));
    let fall = (-t.0).exp();
    for n in 0..40_000 {
        let read = F::from_f64(y + draw.normal(noise));
        let u = pid.output(&history, F::from_f64(reference), read);
        pid.advance(&mut history, F::from_f64(reference), read, u);
        y = fall * y + (1.0 - fall) * u.to_f64();
        sum += if n < 20_000 { 0.0 } else { y };
    }
    sum / 20_000.0
}

/// The derivative saturates single samples; whoever took a conditioned reference into the integral for each of them lost it.
#[test]
fn noise_that_saturates_single_samples_leaves_the_integral_alone() {
    let gains = PidParameters {
        proportional: 2.0,
        integral: 3.0,
        derivative: 0.05,
        ..PidParameters::NONE
    };
    for proportional in [0.0, 0.5, 1.0] {
        let weights = SetPoint {
            proportional,
            ..SetPoint::DEFAULT
        };
        for mean in [
            noisy_mean::<f64>(gains, weights, 0.5, 0.005),
            noisy_mean::<f32>(gains, weights, 0.5, 0.005),
        ] {
            println!("b = {proportional}: {mean:.4}");
            assert!((mean - 0.5).abs() < 0.025, "b = {proportional}: {mean}");
        }
    }
}

/// (1 − w)^λ·R has a zero in the circle there, or at w = 0: nothing may be inverted.
#[test]
fn gains_of_opposite_signs_neither_latch_nor_blow_up() {
    for (text, reference, t) in [
        ("-0.2+1/s", 0.9, 0.01),
        ("-1+10/s^0.5", 0.5, 0.01),
        ("-1+10/s^0.5", 5.0, 0.01),
    ] {
        let gains: PidParameters = text.parse().expect("a controller");
        let (t, memory) = (
            Seconds(t),
            Memory::new(Rule::Bdf2, 1e-6, 60.0).expect("valid"),
        );
        let plant: Plant = "1/(s+1)".parse().expect("valid");
        let plant = SampledPlant::new(&plant, memory, t).expect("valid");
        let actuator = Actuator::new(-1.0, 1.0).expect("valid");
        let pid = FractionalPid::<f64, 64>::new(gains, SetPoint::DEFAULT, actuator, memory, t);
        let run = simulate(&pid.expect("valid"), &plant, |_| reference, 6000);
        // A limit of 1 lets the output come to 1 at most.
        let (last, rest) = (run.measured[5999], reference.min(1.0));
        println!("{text}: {last}");
        assert!((last - rest).abs() < 0.02, "{text}: {last}, not {rest}");
    }
}
