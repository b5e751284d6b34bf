//! Saturation: a limited step recovers as well as an unlimited one.

use crate::fixture::{Draw, bdf2};
use fracdiff::{Real, Seconds};
use fractional_control::{
    Actuator, Controller, FractionalPid, HeldPlant, PidParameters, Plant, PowerMemory, Rule,
    SampledControlLoop, SetPoint, simulate,
};
use testkit::Tested;

/// The overshoot where the command is cut without the knowledge of the controller: the history winds up.
fn wound_up(pid: &FractionalPid<f64, 64>, plant: &HeldPlant, high: f64) -> f64 {
    let (mut history, mut state, mut most) = (pid.at_rest(), plant.at_rest(), 1.0_f64);
    for _ in 0..6000 {
        let y = plant.past(&state);
        let u = pid.output(&history, 1.0, y);
        pid.advance(&mut history, 1.0, y, u);
        plant.advance(&mut state, u.clamp(-high, high));
        most = most.max(y);
    }
    most - 1.0
}

#[test]
fn a_saturated_step_overshoots_no_more_than_an_unlimited_one() -> Tested {
    let (t, memory) = (Seconds(0.01), PowerMemory::new(Rule::Grunwald, 1e-6, 60.0)?);
    let gains =
        |proportional, integral, integral_order, derivative, derivative_order| PidParameters {
            proportional,
            integral,
            integral_order,
            derivative,
            derivative_order,
        };
    let mut naives = 0;
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
        let plant: Plant = plant.parse()?;
        let plant = HeldPlant::new(&plant, memory, t)?;
        let make = |actuator| {
            FractionalPid::<f64, 64>::new(gains, SetPoint::DEFAULT, actuator, memory, t)
                .expect("valid")
        };
        let free = simulate(&make(Actuator::UNLIMITED), &plant, |_| 1.0, 6000).shape();
        for high in [1.1, 1.3, 2.0] {
            let limited = make(Actuator::new(-high, high)?);
            let shape = simulate(&limited, &plant, |_| 1.0, 6000).shape();
            let naive = wound_up(&make(Actuator::UNLIMITED), &plant, high);
            println!(
                "{plant_text} at ±{high}: free {:.4}, exact {:.4}, wound up {naive:.4}",
                free.overshoot, shape.overshoot
            );
            naives += i32::from(naive > free.overshoot + 0.02);
            assert!(
                shape.overshoot <= free.overshoot + 0.02,
                "{plant_text} {high}"
            );
            assert!(shape.final_error < 0.02, "{plant_text} {high}: {shape:?}");
        }
    }
    // The test can fail: without it many do.
    assert!(naives >= 8, "{naives}");
    Ok(())
}

const STEP: f64 = 0.01;

/// Actuators: the share of the command that they give, of their limits that they reach, counts over the range, and 0.5 where those are rounded.
type Drive = [f64; 4];

const EXACT: Drive = [1.0, 1.0, 1e12, 0.5];
const DRIVES: [Drive; 12] = [
    EXACT,
    [0.98, 1.0, 1e12, 0.5],
    [0.85, 1.0, 1e12, 0.5],
    [1.15, 1.0, 1e12, 0.5],
    [1.0, 0.8, 1e12, 0.5],
    [1.0, 1.0, 255.0, 0.5],
    [1.0, 1.0, 1023.0, 0.5],
    [1.0, 1.0, 4095.0, 0.5],
    [1.0, 1.0, 16.0, 0.0],
    [1.0, 1.0, 255.0, 0.0],
    [1.0, 1.0, 1023.0, 0.0],
    [1.0, 1.0, 4095.0, 0.0],
];

/// A design whose loop is stable with a margin and comes to its reference where nothing limits it.
struct Design {
    text: String,
    plant: HeldPlant,
    gains: PidParameters,
    set_point: SetPoint,
    crossover_rad_s: f64,
    limit: f64,
    noise: f64,
    samples: usize,
}

fn drawn(draw: &mut Draw) -> Option<Design> {
    let (t, memory) = (Seconds(STEP), bdf2(1e-5, 200.0));
    let (gain, lag, late) = (
        draw.scale(0.3, 3.0),
        draw.scale(0.3, 3.0),
        draw.from(0.0, 0.3),
    );
    let text = match draw.from(0.0, 4.0) as u32 {
        0 => format!("{gain:.3}/({lag:.3}s+1)"),
        1 => format!("{gain:.3}exp(-{late:.2}s)/({lag:.3}s+1)"),
        2 => format!(
            "{gain:.3}/({:.3}s^2+{lag:.3}s+1)",
            lag * lag * draw.from(0.1, 0.6)
        ),
        _ => format!("{gain:.3}/({lag:.3}s^{:.2}+1)", draw.from(0.7, 1.4)),
    };
    let mut half = |share: f64, size: f64| {
        if draw.from(0.0, 1.0) < share {
            -size
        } else {
            size
        }
    };
    let signs = [half(0.3, 1.0), half(0.4, 1.0)];
    let gains = PidParameters {
        proportional: signs[0] * draw.scale(0.1, 6.0) / gain,
        integral: draw.scale(0.3, 6.0) / gain,
        integral_order: if draw.from(0.0, 1.0) < 0.4 {
            1.0
        } else {
            draw.from(0.7, 1.3)
        },
        derivative: signs[1] * draw.scale(0.005, 0.5) / gain,
        derivative_order: if draw.from(0.0, 1.0) < 0.4 {
            1.0
        } else {
            draw.from(0.4, 1.0)
        },
    };
    let set_point = SetPoint {
        proportional: [0.0, 0.5, 1.0][draw.from(0.0, 3.0) as usize],
        derivative: [0.0, 0.0, 1.0][draw.from(0.0, 3.0) as usize],
    };
    let (limit, share) = (draw.from(1.3, 3.0) / gain, draw.from(0.01, 0.25));
    let plant = HeldPlant::new(&text.parse().expect("a plant"), memory, t).expect("runs");
    let closed = SampledControlLoop::new(gains.into(), memory, &plant).expect("a loop");
    let margins = closed.verdict().stable.then(|| closed.margins())?;
    let crossover_rad_s = margins.phase?.omega_rad_s;
    if margins.sensitivity.value > 2.5 || !(0.3..10.0).contains(&crossover_rad_s) {
        return None;
    }
    let samples = (60.0 / crossover_rad_s / STEP) as usize;
    let free = Actuator::UNLIMITED;
    let pid = FractionalPid::<f64, 64>::new(gains, set_point, free, memory, t).expect("valid");
    // Of fractional orders some creep for ever.
    let run = simulate(&pid, &plant, |_| 1.0, samples).measured;
    let rest = run[samples / 2..].iter().sum::<f64>() / (samples - samples / 2) as f64;
    let noise = (share * limit / noise_gain(&pid)).min(0.2);
    ((rest - 1.0).abs() < 0.01).then(|| Design {
        text: format!("{text} with {gains}, {set_point:?}, limits ±{limit:.3}, noise {noise:.4}"),
        plant,
        gains,
        set_point,
        crossover_rad_s,
        limit,
        noise,
        samples,
    })
}

/// The deviation of the command for a measurement of even noise of deviation 1.
fn noise_gain(pid: &FractionalPid<f64, 64>) -> f64 {
    let mut history = pid.at_rest();
    let pulse = (0..100).map(|n| {
        let y = if n == 0 { 1.0 } else { 0.0 };
        let u = pid.output(&history, 0.0, y);
        pid.advance(&mut history, 0.0, y, u);
        u * u
    });
    pulse.sum::<f64>().sqrt()
}

impl Design {
    fn pid<F: Real>(&self) -> FractionalPid<F, 64> {
        let memory = bdf2(1e-5, 200.0);
        let actuator = Actuator::new(-self.limit, self.limit).expect("valid");
        let pid = FractionalPid::new(self.gains, self.set_point, actuator, memory, Seconds(STEP));
        pid.expect("valid")
    }

    /// Distance of the mean of the output from this reference over the last half, with this noise in what is measured.
    fn error<F: Real>(&self, reference: f64, noise: f64, drive: Drive) -> f64 {
        let (pid, mut draw) = (self.pid::<F>(), Draw(7));
        let [share, reached, counts, rounding] = drive;
        let count = 2.0 * self.limit / counts;
        let (mut history, mut state, mut sum) = (pid.at_rest(), self.plant.at_rest(), 0.0);
        for n in 0..self.samples {
            let y = self.plant.past(&state);
            let (r, read) = (F::from_f64(reference), F::from_f64(y + draw.normal(noise)));
            let u = pid.output(&history, r, read);
            let most = reached * self.limit;
            let given = (share * u.to_f64()).clamp(-most, most);
            let given = (given / count + rounding.copysign(given)).trunc() * count;
            pid.advance(&mut history, r, read, F::from_f64(given));
            self.plant.advance(&mut state, given);
            sum += if n < self.samples / 2 { 0.0 } else { y };
        }
        (sum / (self.samples - self.samples / 2) as f64 - reference).abs()
    }

    /// The actuators with which the output does not come to its reference: all errors, in the order of [`DRIVES`].
    fn wrong_drives(&self) -> Option<String> {
        let errors = DRIVES.map(|drive| self.error::<f32>(1.0, 0.0, drive));
        let is_wrong = errors.iter().any(|error| !(0.0..0.025).contains(error));
        is_wrong.then(|| format!("{}: {errors:.3?}", self.text))
    }

    /// How long the command stays at the limit to which an error of 1 has driven it for 20 s once the error has turned, s.
    fn recovery_s<F: Real>(&self, error: f64) -> f64 {
        let (pid, zero) = (self.pid::<F>(), F::ZERO);
        let (mut history, mut u) = (pid.at_rest(), zero);
        let tick = |history: &mut _, e: f64| {
            let y = F::from_f64(-e);
            let u = pid.output(history, zero, y);
            pid.advance(history, zero, y, u);
            u.to_f64()
        };
        for _ in 0..2000 {
            u = F::from_f64(tick(&mut history, error));
        }
        let at = u.to_f64();
        if at.abs() < 0.999 * self.limit {
            return 0.0;
        }
        let most = (30.0 / self.crossover_rad_s / STEP) as usize;
        let left = (0..most).position(|_| (tick(&mut history, -error) - at).abs() > 1e-6);
        left.map_or(f64::INFINITY, |n| n as f64 * STEP)
    }
}

/// Each with noise, at both limits, in both kinds of numbers; and each with every actuator; `CAMPAIGN_CASES`: designs, 200 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn drawn_designs_rest_at_their_reference_and_come_back_from_both_limits() {
    let count = testkit::cases(200);
    let mut draw = Draw(11);
    let designs = std::iter::from_fn(|| Some(drawn(&mut draw)))
        .flatten()
        .take(count);
    let (mut worst, mut latest, mut against) = (0.0_f64, 0.0_f64, 0);
    let mut wrong = Vec::new();
    for design in designs {
        wrong.extend(design.wrong_drives());
        against += usize::from(design.gains.proportional < 0.0 || design.gains.derivative < 0.0);
        for sign in [1.0, -1.0] {
            let error = design
                .error::<f64>(sign, design.noise, EXACT)
                .max(design.error::<f32>(sign, design.noise, EXACT));
            let late = [
                design.recovery_s::<f64>(sign),
                design.recovery_s::<f32>(sign),
            ];
            let late = late.into_iter().fold(0.0, f64::max) * design.crossover_rad_s;
            (worst, latest) = (worst.max(error), latest.max(late));
            if !(error < 0.03 && late <= 1.5) {
                wrong.push(format!(
                    "{}: off by {error:.3}, back after {late:.2}/ω_c",
                    design.text
                ));
            }
        }
    }
    println!(
        "{count} designs, {against} with opposite signs: off by {worst:.3} at most, back within {latest:.2}/ω_c"
    );
    assert!(4 * against > count, "{against}");
    assert_eq!(wrong, [""; 0]);
}
