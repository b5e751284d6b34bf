//! Powers of a bracket and diffusion in plants, against closed forms, golden values and brute force.

use super::fixture::{bdf2, held, p, pi, plant};
use fractional_control::{
    FractionalTransferFunction, HeldPlant, PidParameters, Plant, SampledControlLoop,
    num_complex::Complex,
};
use testkit::{assert_close, assert_refused, assert_says, table};

/// The output so many samples after a step.
fn step(plant: &HeldPlant, samples: usize) -> f64 {
    let mut state = plant.at_rest();
    let outputs = (0..=samples).map(|_| plant.step(&mut state, 1.0));
    outputs.last().expect("a sample")
}

fn closed(plant: &str, t: f64, law: PidParameters) -> SampledControlLoop {
    let memory = bdf2(1e-9, 1e6 * t);
    let plant = held(&self::plant(plant), memory, t);
    SampledControlLoop::new(law.into(), memory, &plant).expect("a loop")
}

/// P(a, x) as x^a·e^(−x)·Σ x^n/Γ(a + n + 1).
fn incomplete_gamma(a: f64, x: f64) -> f64 {
    let terms = (1..400).scan(1.0, |term, n| {
        *term *= x / (a + f64::from(n));
        Some(*term)
    });
    x.powf(a) * (-x).exp() / libm::tgamma(a + 1.0) * (1.0 + terms.sum::<f64>())
}

/// Step of exp(−√(τs)).
fn diffused(tau: f64, t: f64) -> f64 {
    libm::erfc(0.5 * (tau / t).sqrt())
}

#[test]
fn what_is_typed_is_printed_and_means_the_same() {
    for [text, printed] in table(
        "
        1.5/(0.2*s + 1)^0.6 | 1.5/(0.2s+1)^0.6
        exp(-sqrt(3*s))/(s + 1) | exp(-sqrt(3s))/(s+1)
        exp(-0.5s)*exp(-2s^0.5) | exp(-0.5s)*exp(-2sqrt(s))
        3*exp(-sqrt(2s+0.5)) | exp(-sqrt(2s+0.5))*3
        exp(-sqrt(s))*exp(-2sqrt(4s)) | exp(-5sqrt(s))
        2/(s+1)^1.6 | 2/(s+1)/(s+1)^0.6
        (s+2)^0.5/(s^1.5+s+1) | (s+2)/(s^1.5+s+1)/(s+2)^0.5
        ((s+1)/(s+2))^(1/2) | 1*(s+1)^0.5/(s+2)^0.5
        s/((s+1)^0.6(s+2)^0.7) | s/(s+1)*(s+1)^0.4/(s+2)^0.7
        1/sqrt(s+1)/sqrt(4s+4) | 0.5/(s+1)
        4/(4s)^0.5 | 4/(2s^0.5)
        3(s+1)^-2 | 3/(s^2+2s+1)
        sqrt(4)/(s+1) | 2/(s+1)
        ",
    ) {
        let plant = plant(&text);
        assert_eq!(plant.to_string(), printed, "{text}");
        assert_eq!(printed.parse().as_ref(), Ok(&plant), "{printed}");
    }
    let (s, rod) = (
        Complex::new(0.0, 0.7),
        "2exp(-3sqrt(s+0.5))(s+2)^0.5/(s+1)^1.2",
    );
    let want = (s + 0.5).sqrt().scale(-3.0).exp() * (s + 2.0).sqrt() / (s + 1.0).powf(1.2) * 2.0;
    let have = plant(rod).response(0.7).expect("at any frequency");
    assert!((have / want - 1.0).norm() < 1e-14, "{have} {want}");
}

#[test]
fn a_refusal_names_the_value_and_the_remedy() {
    for [text, part] in table(
        "
        s/(s+1)^0.5 | the numerator's order 1 exceeds the denominator's order 0.5: add a faster pole
        s^0.5/(s+1)^0.7 | order 0.5 above and 0.7 below: beside a power of a bracket the plant must fall faster
        (s+3)/(s+4)*((s+1)/(s+2))^0.5 | order 1.5 above and 1.5 below: beside
        1/(s-1)^0.5 | character 8 of the transfer function should be 0, 1, 2, 3 or 4 as the power of this bracket: any
        1/(s+1)^5 | power of a bracket 5 is not from -4 to 4, the highest order: write a further lag as a dead time
        1/(s^2+1)^0.5 | both numbers above 0
        1/(s+1)^5.5 | order of a term 5 is not in [0, 4]
        exp(sqrt(s)) | factor of the root in exp 1 is not below 0: diffusion does not grow
        1/exp(-2sqrt(s)) | factor of the root in exp 2 is not below 0
        exp(-s^0.3) | should be exp(-0.5s), a dead time, or exp(-sqrt(0.5s)), diffusion
        exp(-sqrt(s^2+1)) | diffusion
        1+1/(s+1)^0.5 | as must exp(-sqrt(s)) or (s+1)^0.6
        1/((s+1)^0.5+2) | character 12 of the transfer function should be a factor
        1/(1e-70s+1)^0.5 | number before s 1e-70 is not 0, or from 1e-60
        1/sqrt(s+1)/sqrt(s+2)/sqrt(s+3)/sqrt(s+4)/sqrt(s+5) | 5 terms are more than the largest number, 4
        ",
    ) {
        assert_refused(text.parse::<Plant>(), &part);
    }
    let far: Plant = plant("exp(-sqrt(1e9s))");
    let far = HeldPlant::with_usual_memory(&far, fracdiff::Seconds(1e-3));
    assert_refused(far, "is not at most 10000 samples: sample more slowly");
    for text in ["2/(s+1)^0.5", "exp(-sqrt(s))"] {
        let refused = "stands only in a plant: write powers of s";
        assert_refused(text.parse::<FractionalTransferFunction>(), refused);
        assert_refused(text.parse::<PidParameters>(), refused);
    }
    let rod = plant("exp(-sqrt(s))/(s-1)").stable_by_itself();
    assert_says(
        &rod.expect_err("grows").to_string(),
        "a pole that does not decay",
    );
}

/// However many samples it takes, and with the dead time between two of them.
#[test]
fn a_step_is_that_of_the_closed_forms() {
    for (alpha, a) in [(0.03, 2.0_f64), (0.6, 5.0), (0.98, 0.3), (0.9995, 2.0)] {
        for (t, samples) in [(0.01, 1_u16), (0.4, 7), (3.0, 200)] {
            let late = 0.37 * t;
            let plant = plant(&format!("exp(-{late}s)/(s+{a})^{alpha}"));
            let held = held(&plant, bdf2(1e-9, 1e4), (t + late) / f64::from(samples));
            let have = step(&held, samples.into()) * a.powf(alpha);
            let want = incomplete_gamma(alpha, a * t);
            assert_close(&format!("{plant} at {t}"), have, want, 1e-12);
        }
    }
    for (tau, t, samples) in [
        (3.0, 0.02, 1_u16),
        (3.0, 10.0, 1000),
        (1e3, 20.0, 300),
        (1e-4, 5.0, 9),
    ] {
        let plant = plant(&format!("exp(-sqrt({tau}s))"));
        let held = held(&plant, bdf2(1e-9, 1e4), t / f64::from(samples));
        let have = step(&held, samples.into());
        assert_close(&format!("{plant} at {t}"), have, diffused(tau, t), 1e-12);
    }
}

/// Those that follow a rule beside their factors come nearer with the samples.
#[test]
fn a_step_is_that_of_the_golden_values() {
    let (mut exact, mut by_rule) = (0, 0);
    for line in include_str!("../golden/implicit.csv").lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let [text, t, y] = cells[..] else {
            panic!("{line}")
        };
        let (t, want): (f64, f64) = (t.parse().expect("t"), y.parse().expect("y"));
        let off = |samples: usize| {
            let held = held(&plant(text), bdf2(1e-9, 1e4), t / samples as f64);
            ((step(&held, samples) - want).abs(), held.is_exact())
        };
        match off(100) {
            (error, true) => {
                assert!(error < 1e-12 && off(1).0 < 1e-12, "{line}: {error:e}");
                exact += 1;
            }
            (error, false) => {
                let finer = off(400).0;
                assert!(
                    error < 4e-4 && finer < 0.2 * error + 1e-7,
                    "{line}: {error:e} {finer:e}"
                );
                by_rule += 1;
            }
        }
    }
    assert_eq!((exact, by_rule), (55, 15));
}

/// The sum over the aliases behind a hold against the decays in time, of one function that is written in two ways.
#[test]
fn a_function_behind_a_factor_is_run_in_parts_of_a_slow_sample() {
    // 1/(s^2+0.2s+1)/(s+1)^0.5 after 1 s and 2 s, by quadrature and by Talbot's contour, at some 60 and 12 samples a period.
    let swings = plant("1/(s^2+0.2s+1)/(s+1)^0.5");
    for (t, most) in [(0.1, 2e-4), (0.5, 2e-3)] {
        let held = held(&swings, bdf2(1e-9, 1e6 * t), t);
        for (second, want) in [(1.0, 0.23343), (2.0, 0.90833)] {
            let samples = libm::round(second / t) as usize;
            assert_close("output", step(&held, samples), want, most);
        }
    }
}

#[test]
fn two_ways_to_the_plant_behind_its_hold_agree() {
    for (t, text) in [
        (0.1, "exp(-sqrt(3s))"),
        (0.02, "1.5/(0.2s+1)^0.6"),
        (0.1, "exp(-0.15s)*exp(-2sqrt(s+0.5))"),
        (0.3, "exp(-0.04s)/((s+1)^0.4*(100s+1)^0.3)"),
    ] {
        let law = pi(1.0, 0.5, 1.0);
        let exact = closed(text, t, law);
        let twin = closed(&format!("{text}*((s+1)/(s+1))"), t, law);
        let twin = twin.of_plant().expect("follows a rule");
        for theta in [1e-4, 0.01, 0.5, 2.0, core::f64::consts::PI] {
            let off = twin.open(theta) / exact.open(theta) - 1.0;
            assert!(off.norm() < 1e-8, "{text} at {theta}: {off:e}");
        }
        let edge = exact.margins().gain_up.expect("an edge").value;
        for (gain, is_stable) in [(0.99, true), (1.01, false)] {
            for closed in [&exact, &twin] {
                let verdict = closed.with_gain(gain * edge).verdict();
                assert_eq!(verdict.stable, is_stable, "{text}: {verdict:?}");
                assert!(verdict.unstable_poles.is_some(), "{text}");
            }
        }
    }
}

type Step<'a> = &'a dyn Fn(f64) -> f64;

/// How much larger the end of a run with u = −Ky is than its middle, after a kick; `step` is that of the plant.
fn growth(step: Step<'_>, gain: f64, t: f64) -> f64 {
    const SAMPLES: usize = 3000;
    let at = |m: usize| if m == 0 { 0.0 } else { step(m as f64 * t) };
    let answers: Vec<f64> = (1..=SAMPLES).map(|m| at(m) - at(m - 1)).collect();
    let (mut commands, mut outputs) = (vec![1.0], vec![0.0_f64]);
    for n in 1..SAMPLES {
        let past = commands.iter().zip(answers[..n].iter().rev());
        let output: f64 = past.map(|(u, answer)| u * answer).sum();
        outputs.push(output);
        commands.push(-gain * output);
    }
    let most = |part: &[f64]| part.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    most(&outputs[SAMPLES * 4 / 5..]) / most(&outputs[SAMPLES * 2 / 5..SAMPLES * 3 / 5])
}

/// Below its gain margin a loop decays in a run by closed forms, above it grows; diffusion at 1 kHz leaves 1e-30 of L at half the rate.
#[test]
fn the_gain_margin_is_where_a_run_begins_to_grow() {
    let lag = |t: f64| 2.0 * incomplete_gamma(1.5, t);
    let cases: [(&str, f64, Step<'_>); 4] = [
        ("exp(-sqrt(3s))", 0.05, &|t| diffused(3.0, t)),
        ("2/(s+1)^1.5", 0.1, &|t| {
            if t < 200.0 { lag(t) } else { 2.0 }
        }),
        ("1/(s+4)^0.3", 0.02, &|t| {
            incomplete_gamma(0.3, 4.0 * t.min(40.0)) / 4f64.powf(0.3)
        }),
        ("exp(-sqrt(0.1s))", 1e-3, &|t| diffused(0.1, t)),
    ];
    for (text, t, step) in cases {
        let closed = closed(text, t, p(1.0));
        let closed = closed.of_plant().unwrap_or(closed);
        let edge = closed.margins().gain_up.expect("an edge").value;
        let [below, above] = [0.97, 1.03].map(|share| growth(step, share * edge, t));
        assert!(below < 1.0 && above > 1.0, "{text} {edge}: {below} {above}");
        for share in [0.97, 1.03] {
            let verdict = closed.with_gain(share * edge).verdict();
            assert_eq!(verdict.stable, share < 1.0, "{text}: {verdict:?}");
        }
    }
}
