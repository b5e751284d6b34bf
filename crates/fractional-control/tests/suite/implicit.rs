//! Powers of a bracket and diffusion in plants, against closed forms, golden values and brute force.

use super::fixture::{bdf2, held};
use fractional_control::{HeldPlant, Plant};

fn plant(text: &str) -> Plant {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The output at these samples after a step.
fn step(plant: &HeldPlant, samples: usize) -> Vec<f64> {
    let mut state = plant.at_rest();
    (0..=samples).map(|_| plant.step(&mut state, 1.0)).collect()
}

#[test]
fn a_step_is_that_of_the_golden_values() {
    let memory = bdf2(1e-9, 1e4);
    for line in include_str!("../golden/implicit.csv").lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let [text, t, y] = cells[..] else { panic!("{line}") };
        let (t, want): (f64, f64) = (t.parse().expect("t"), y.parse().expect("y"));
        let plant = plant(text);
        for samples in [1, 10, 100] {
            let held = held(&plant, memory, t / samples as f64);
            let have = step(&held, samples)[samples];
            println!("{text} {t} {samples} {} {have:e} {:e}", held.is_exact(), have - want);
        }
    }
}

#[test]
fn explore() {
    let memory = bdf2(1e-9, 1e4);
    for (t, text) in [(0.1, "exp(-sqrt(3s))"), (0.02, "1.5/(0.2s+1)^0.6"), (0.1, "exp(-0.15s)*exp(-2sqrt(s+0.5))"),(0.3,"exp(-0.04s)/((s+1)^0.4*(100s+1)^0.3)"), (1e-3, "exp(-sqrt(3s))")] {
        let exact = held(&plant(text), memory, t);
        let twin = held(&plant(&format!("{text}*((s+1)/(s+1))")), memory, t);
        let gains = fractional_control::PidParameters { proportional: 1.0, integral: 0.5, integral_order: 1.0, ..fractional_control::PidParameters::NONE };
        let closed = |held| fractional_control::SampledControlLoop::new(gains.into(), memory, held).expect("runs");
        let now = std::time::Instant::now();
        let exact = closed(&exact);
        let m = exact.margins();
        println!("{text} {t} margins {:?} {:?}", now.elapsed(), m);
        let rule = closed(&twin);
        let twin = rule.of_plant().expect("follows a rule");
        for theta in [1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 3.0, 3.14159] {
            println!("   {theta} {:e} {:e} rule {:e}", exact.open(theta), (twin.open(theta) / exact.open(theta) - 1.0).norm(), (rule.open(theta) / exact.open(theta) - 1.0).norm());
        }
        let now = std::time::Instant::now();
        let up = m.gain_up.map_or(1.0, |c| c.value);
        for gain in [0.1, 0.9, 0.99, 1.01, 1.1, 2.0] {
            let now = std::time::Instant::now();
            let a = exact.with_gain(gain * up).verdict();
            let e1 = now.elapsed();
            let now = std::time::Instant::now();
            let b = twin.with_gain(gain * up).verdict();
            println!("   {gain} {:?} {:?} {e1:?} {:?}", a, b, now.elapsed());
        }
        let _ = now;
    }
}
