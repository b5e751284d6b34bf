//! The certified verdict against simulation at the boundary: random devices with delay that is no whole number of samples and a
//! motor current that lags, a little inside the nearest edge and a little outside it. None may be on the wrong side.
//!
//! The default runs take 24 walls and 100 coupled objects, some seconds. `CAMPAIGN_CASES=300` asks for more, of the same sequence.

use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{
    CoupledLoop, CoupledObject, Coupler, Dynamics, LoopOperator, SampledLoop, SampledWall,
};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{
    Device, SafeForce, SpringDamper, VirtualCoupler, VirtualObject, deflection_order,
};
use nalgebra::Vector1;
use std::fmt::Debug;
use testkit::Random;
use testkit::device::{of_dynamics, safe, settles};

const T: Seconds = Seconds(1e-3);
/// Memory of a full-memory operator, samples.
const HORIZON: f64 = 2e6;

/// A device under a law of one free gain.
trait Case: Debug {
    fn random(number: usize, random: &mut Random) -> Self;

    /// The edge next to a weak law, with the angle at which its pole crosses; `None` if no weak law is stable.
    fn edge(&self) -> Option<(f64, f64)>;

    /// True if it is stable by analysis.
    fn is_stable(&self, gain: f64) -> bool;

    /// Whether a push of the device dies out, by simulation.
    fn settles(&self, gain: f64, theta: f64) -> bool;
}

/// So many cases from a seed, each by a share of the gain inside its edge and outside it.
fn none_is_on_the_wrong_side<C: Case>(seed: u64, cases: usize, distance: f64) {
    let cases = testkit::cases(cases);
    let mut random = Random(seed);
    let (mut tried, mut number, mut wrong) = (0, 0, Vec::new());
    while tried < cases {
        number += 1;
        let case = C::random(number, &mut random);
        let Some((edge, theta)) = case.edge() else {
            continue;
        };
        tried += 1;
        for (gain, want) in [
            ((1.0 - distance) * edge, true),
            ((1.0 + distance) * edge, false),
        ] {
            let stable = case.is_stable(gain);
            assert_eq!(stable, want, "the margin is not an edge: {case:?}");
            if case.settles(gain, theta) != want {
                wrong.push(format!(
                    "{number}: should settle {want}, edge {edge}, θ = {theta}, {case:?}"
                ));
            }
        }
    }
    println!("{tried} devices of {number}, {} wrong", wrong.len());
    assert!(number < 3 * cases, "{number} tried: most have no edge");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_device_is_on_the_wrong_side_of_its_boundary() {
    none_is_on_the_wrong_side::<WallCase>(12_010, 24, 5e-3);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_coupled_device_is_on_the_wrong_side_of_its_boundary() {
    none_is_on_the_wrong_side::<CoupledCase>(13_002, 100, 1e-2);
}

/// One device, operator and direction of the wall.
#[derive(Clone, Copy, Debug)]
struct WallCase {
    device: Dynamics,
    order: Order,
    /// What runs.
    scheme: Scheme,
    /// What is analysed: the exact operator for a full memory.
    analysed: Scheme,
    /// Shares of stiffness and dissipation.
    direction: [f64; 2],
}

impl Case for WallCase {
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
                damping_n_s_per_m: delta * mass_kg / T.0,
                hand_stiffness_n_per_m: gamma * mass_kg / (T.0 * T.0),
                delay_s: delay * T.0,
                current_lag_s: lag * T.0,
            },
            order: Order::new(order).expect("in range"),
            scheme: scheme.parse().expect("a scheme"),
            analysed: analysed.parse().expect("a scheme"),
            direction: [angle.cos(), angle.sin()],
        }
    }

    fn edge(&self) -> Option<(f64, f64)> {
        let weak = 1e-4;
        let up = self.closed(weak, |closed| closed.margins().ok()?.gain_up)?;
        Some((weak * up.value, up.theta))
    }

    fn is_stable(&self, gain: f64) -> bool {
        self.closed(gain, |closed| closed.is_stable())
    }

    fn settles(&self, gain: f64, theta: f64) -> bool {
        let wall = self.wall(gain);
        let operator: Operator<f64> = (self.scheme).build(self.order, T, HORIZON).expect("builds");
        let (stiffness, dissipation) = (wall.stiffness_n_per_m, wall.dissipation_n_s_mu_per_m);
        let law = SpringDamper::new(stiffness, dissipation, operator).expect("in range");
        settles(law, &self.device, T, theta)
    }
}

impl WallCase {
    /// α and β are `gain` times the direction.
    fn wall(&self, gain: f64) -> SampledWall {
        let m = self.device.mass_kg;
        let [alpha, beta] = self.direction;
        SampledWall {
            stiffness_n_per_m: gain * alpha * m / (T.0 * T.0),
            dissipation_n_s_mu_per_m: gain * beta * m / T.0.powf(2.0 - self.order.get()),
            order: self.order,
            sample_time_s: T.0,
        }
    }

    fn closed<R>(&self, gain: f64, look: impl Fn(&SampledLoop<'_>) -> R) -> R {
        let operator = LoopOperator::new(self.analysed, self.order, T, HORIZON);
        let operator = operator.expect("an operator");
        let closed = self.device.closed(&self.wall(gain), &operator);
        look(&closed.expect("in range"))
    }
}

/// A device, an object, and the shares of `k_c` and `b_c`.
#[derive(Clone, Copy, Debug)]
struct CoupledCase {
    device: Dynamics,
    object: CoupledObject,
    order: Order,
    shares: [f64; 2],
}

impl Case for CoupledCase {
    fn random(number: usize, random: &mut Random) -> Self {
        let mass_kg = random.log_between(0.02, 1.0);
        let order = [0.0, 0.25, 0.5, 0.75, 1.0][number % 5];
        let share = random.share();
        // k_c and b_c·T^μ alike in size.
        let unit = mass_kg / T.0;
        Self {
            device: Dynamics {
                mass_kg,
                damping_n_s_per_m: random.log_between(2e-2, 0.5) * unit,
                hand_stiffness_n_per_m: random.or_nothing(0.05) * unit / T.0,
                delay_s: random.or_nothing(2.5) * T.0,
                current_lag_s: random.or_nothing(2.0) * T.0,
            },
            object: CoupledObject {
                mass_kg: random.or_nothing(5.0 * mass_kg),
                damping_n_s_per_m: random.log_between(1e-3, 0.1) * unit,
                stiffness_n_per_m: random.log_between(1e-3, 10.0) * unit / T.0,
            },
            order: Order::new(order).expect("in range"),
            shares: [share * unit, (1.0 - share) * unit * T.0.powf(-order)],
        }
    }

    fn edge(&self) -> Option<(f64, f64)> {
        let weak = 1e-3;
        let edge = self.closed(weak, |closed| closed.gain_margin().ok()?)?;
        Some((weak * edge.value, edge.theta))
    }

    fn is_stable(&self, gain: f64) -> bool {
        self.closed(gain, |closed| closed.is_stable())
    }

    fn settles(&self, gain: f64, theta: f64) -> bool {
        let CoupledObject {
            mass_kg,
            damping_n_s_per_m,
            stiffness_n_per_m,
        } = self.object;
        let object = VirtualObject::new(
            Kilograms(mass_kg),
            NewtonSecondsPerMetre(damping_n_s_per_m),
            NewtonsPerMetre(stiffness_n_per_m),
        );
        let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
        let order = deflection_order(self.order).expect("in range");
        let operator: Operator<f64> = scheme.build(order, T, HORIZON).expect("builds");
        let [k_c, b_c] = self.gains(gain);
        let coupler = VirtualCoupler::new(k_c, b_c, operator, object.expect("in range"), T);
        settles(coupler.expect("in range"), &self.device, T, theta)
    }
}

impl CoupledCase {
    fn gains(&self, gain: f64) -> [f64; 2] {
        self.shares.map(|share| gain * share)
    }

    fn closed<R>(&self, gain: f64, look: impl Fn(&CoupledLoop<'_>) -> R) -> R {
        let order = deflection_order(self.order).expect("in range");
        let operator = LoopOperator::new(Scheme::Exact, order, T, HORIZON).expect("an operator");
        let [k_c, b_c] = self.gains(gain);
        let coupler = Coupler::exact(self.order, T.0, k_c, b_c).expect("in range");
        let closed = CoupledLoop::new(&self.device, &coupler, &self.object, &operator);
        look(&closed.expect("in range"))
    }
}

#[test]
fn the_simulated_plant_moves_as_the_analysed_one_does() {
    let mut random = Random(4);
    for number in 0..60 {
        let case = WallCase::random(number, &mut random);
        let sampled = case.device.plant(T.0).expect("in range");
        let mut plant = of_dynamics(&case.device, T);
        // The response to one unit force, by A·x = w^(d+1)·N·u.
        let delay = sampled.path().whole_samples() + 1;
        let scale = T.0 * T.0 / case.device.mass_kg;
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
            let Ok(()) = plant.write(force);
        }
    }
}
