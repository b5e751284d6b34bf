//! Analysis against simulation at the boundary: devices with delay that is no whole number of samples and a
//! motor current that lags, 0.5 % inside the nearest edge and 0.5 % outside it. Neither may be on the wrong side.
//!
//! The default run takes 24 devices, some seconds. `CAMPAIGN_CASES=300` asks for more, of the same sequence.

use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{Dynamics, Environment, LoopOperator};
use haptic_loop::{Device, SafeForce, SpringDamper};
use nalgebra::Vector1;
use testkit::Random;
use testkit::device::{of_dynamics, safe, settles};

const T: f64 = 1e-3;
/// Memory of a full-memory operator, samples.
const HORIZON: f64 = 2e6;
/// Distance from the edge, as a share of the gain.
const BESIDE: f64 = 5e-3;

/// One device, operator and direction of the wall.
#[derive(Clone, Copy, Debug)]
struct Case {
    device: Dynamics,
    order: Order,
    /// What runs.
    scheme: Scheme,
    /// What is analysed: the exact operator for a full memory.
    analysed: Scheme,
    /// Shares of stiffness and dissipation.
    direction: [f64; 2],
}

impl Case {
    fn random(number: usize, random: &mut Random) -> Self {
        let mass_kg = random.log_between(0.02, 1.0);
        let delta = random.log_between(2e-3, 1.0);
        let gamma = if random.share() < 0.5 {
            0.0
        } else {
            random.between(0.0, 0.05)
        };
        let delay = random.between(0.0, 3.0);
        let delay = if number.is_multiple_of(4) {
            delay.round()
        } else {
            delay
        };
        let lag = if number.is_multiple_of(5) {
            0.0
        } else {
            random.between(0.0, 3.0)
        };
        let order = match number % 7 {
            0 => 0.0,
            1 => 1.0,
            2 => 2.0,
            _ => random.between(0.0, 2.0),
        };
        let (scheme, analysed) = match number % 3 {
            0 => ("full:1e-6", "exact"),
            1 => ("grunwald:20", "grunwald:20"),
            _ => ("muir:3", "muir:3"),
        };
        let angle = random.between(0.05, 1.45);
        Self {
            device: Dynamics {
                mass_kg,
                damping_n_s_per_m: delta * mass_kg / T,
                hand_stiffness_n_per_m: gamma * mass_kg / (T * T),
                delay_s: delay * T,
                current_lag_s: lag * T,
            },
            order: Order::new(order).expect("in range"),
            scheme: scheme.parse().expect("a scheme"),
            analysed: analysed.parse().expect("a scheme"),
            direction: [angle.cos(), angle.sin()],
        }
    }

    /// α and β are `gain` times the direction.
    fn wall(&self, gain: f64) -> Environment {
        let m = self.device.mass_kg;
        let [alpha, beta] = self.direction;
        Environment {
            stiffness_n_per_m: gain * alpha * m / (T * T),
            dissipation_n_s_mu_per_m: gain * beta * m / T.powf(2.0 - self.order.get()),
            order: self.order,
            sample_time_s: T,
        }
    }

    /// The edge next to a weak wall, with the angle at which its pole crosses; `None` if no weak wall is stable.
    fn edge(&self, operator: &LoopOperator) -> Option<(f64, f64)> {
        let weak = 1e-4;
        let closed = self
            .device
            .closed(&self.wall(weak), operator)
            .expect("in range");
        let up = closed.margins().ok()?.gain_up?;
        Some((weak * up.value, up.theta))
    }

    /// Whether a push of the device dies out.
    fn settles(&self, gain: f64, theta: f64) -> bool {
        let wall = self.wall(gain);
        let operator: Operator<f64> = self
            .scheme
            .build(self.order, Seconds(T), HORIZON)
            .expect("builds");
        let law = SpringDamper::new(
            wall.stiffness_n_per_m,
            wall.dissipation_n_s_mu_per_m,
            operator,
        )
        .expect("in range");
        settles(law, &self.device, Seconds(T), theta)
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_device_is_on_the_wrong_side_of_its_boundary() {
    let cases = testkit::cases(24);
    let mut random = Random(12_010);
    let (mut tried, mut number, mut wrong) = (0, 0, Vec::new());
    while tried < cases {
        number += 1;
        let case = Case::random(number, &mut random);
        let operator =
            LoopOperator::new(case.analysed, case.order, Seconds(T), HORIZON).expect("an operator");
        let Some((edge, theta)) = case.edge(&operator) else {
            continue;
        };
        tried += 1;
        for (gain, want) in [
            ((1.0 - BESIDE) * edge, true),
            ((1.0 + BESIDE) * edge, false),
        ] {
            let closed = case
                .device
                .closed(&case.wall(gain), &operator)
                .expect("in range");
            assert_eq!(
                closed.is_stable(),
                want,
                "the margin is not an edge: {case:?}"
            );
            if case.settles(gain, theta) != want {
                wrong.push(format!(
                    "{number}: should settle {want}, edge {edge}, θ = {theta}, {case:?}"
                ));
            }
        }
    }
    println!("{tried} devices of {number}, {} wrong", wrong.len());
    assert!(
        number < 3 * cases,
        "{number} tried: most have no stable wall"
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_simulated_plant_moves_as_the_analysed_one_does() {
    let mut random = Random(4);
    for number in 0..60 {
        let case = Case::random(number, &mut random);
        let sampled = case.device.plant(T).expect("in range");
        let mut plant = of_dynamics(&case.device, Seconds(T));
        // The response to one unit force, by A·x = w^(d+1)·N·u.
        let delay = sampled.path().whole_samples() + 1;
        let scale = T * T / case.device.mass_kg;
        let mut x: Vec<f64> = Vec::new();
        let mut most: f64 = 0.0;
        for n in 0..200_usize {
            let driven = n
                .checked_sub(delay)
                .and_then(|j| sampled.numerator().get(j))
                .copied();
            let past = (1..sampled.denominator().len()).filter(|j| *j <= n);
            let past: f64 = past.map(|j| sampled.denominator()[j] * x[n - j]).sum();
            x.push(driven.unwrap_or(0.0) * scale - past);
            most = most.max(x[n].abs());
            let have = plant.position()[0];
            assert!(
                (have - x[n]).abs() < 1e-10 * (most + scale),
                "{number}, {n}: {have} {}",
                x[n]
            );
            let force = if n == 0 {
                safe(Vector1::new(1.0))
            } else {
                SafeForce::<f64, 1>::zero()
            };
            match plant.write(force) {
                Ok(()) => {}
                Err(never) => match never {},
            }
        }
    }
}
