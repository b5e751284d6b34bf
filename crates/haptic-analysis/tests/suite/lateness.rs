//! Delay margins against verdicts on the same loop with other delays, of any part of a sample.

use haptic_analysis::{Dynamics, ForcePath, LoopOperator, SampledLoop, SampledPlant, SampledWall};
use std::f64::consts::PI;
use testkit::Random;
use testkit::operator::{operator, order};

/// Margins above this are not tried: verdicts so late take long.
const LATE: f64 = 1000.0;

/// A wall on a device, judged with more delay, in samples.
struct Subject<'a> {
    device: Dynamics,
    wall: SampledWall,
    operator: &'a LoopOperator,
}

impl Subject<'_> {
    fn later(&self, samples: f64) -> SampledLoop<'_> {
        let delay_s = self.device.delay_s + samples * self.wall.sample_time_s;
        let device = Dynamics {
            delay_s,
            ..self.device
        };
        let closed = device.closed(&self.wall, self.operator);
        closed.expect("in range").beside_rest()
    }

    fn is_stable(&self, samples: f64) -> bool {
        self.later(samples).is_stable()
    }

    /// Stable at 0.99 of the margin and at delays before it, not at 1.01; returns the margin.
    fn check(&self, what: &str) -> Option<f64> {
        let margins = self.later(0.0).margins().expect("stable");
        let Some(delay) = margins.delay else {
            for k in 0..40_u32 {
                assert!(self.is_stable(0.33 * f64::from(k)), "{what}: no margin");
            }
            return None;
        };
        let most = delay.value;
        if most > LATE {
            return Some(most);
        }
        assert!(self.is_stable(0.99 * most), "{what}: {delay:?}");
        assert!(!self.is_stable(1.01 * most), "{what}: {delay:?}");
        assert!(self.is_stable((1.0 - 1e-4) * most), "{what}: {delay:?}");
        assert!(!self.is_stable((1.0 + 1e-4) * most), "{what}: {delay:?}");
        for k in 0..24_u32 {
            let less = most * f64::from(k) / 24.0;
            assert!(self.is_stable(less), "{what}: {less} of {delay:?}");
        }
        // F = 0 there, at the angle that is said.
        let edge = self.later(most);
        let left = (edge.loop_gain(delay.theta) + 1.0).norm();
        assert!(left < 1e-5, "{what}: {left} at {delay:?}");
        Some(most)
    }
}

#[test]
fn a_hold_that_switches_inside_a_sample_has_its_own_margin() {
    // The phase at the crossover alone gave 0.310 samples.
    let operator = operator("exact", 1.0);
    let subject = Subject {
        device: Dynamics::ideal(0.018, 3.5),
        wall: SampledWall {
            stiffness_n_per_m: 1850.0,
            dissipation_n_s_mu_per_m: 20.0,
            order: order(1.0),
            sample_time_s: 1.3e-3,
        },
        operator: &operator,
    };
    let most = subject.check("18 g").expect("a margin");
    assert!((0.25..0.28).contains(&most), "{most}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn random_walls_are_stable_up_to_their_delay_margin_and_not_beyond() {
    let mut random = Random(2505);
    let [mut short, mut long, mut none] = [0; 3];
    for case in 0..400 {
        let mu = match case % 4 {
            0 => 1.0,
            _ => random.between(0.0, 2.0),
        };
        let schemes = ["exact", "muir:3", "grunwald:20", "full:1e-3"];
        let operator = operator(schemes[case % 4], mu);
        let t = 1e-3;
        let if_so = |so: bool, value: f64| value * f64::from(u8::from(so));
        let softer = libm::pow(10.0, -if_so(case % 4 == 3, random.between(0.0, 1.5)));
        let mass_kg = random.between(0.01, 0.1);
        // B·T^(2−μ)/m
        let beta = softer * random.between(0.1, 0.9);
        let subject = Subject {
            device: Dynamics {
                mass_kg,
                damping_n_s_per_m: random.between(0.0, 20.0),
                hand_stiffness_n_per_m: if_so(case % 7 == 0, random.between(0.0, 500.0)),
                delay_s: t * if_so(case % 3 == 2, random.between(0.0, 2.0)),
                current_lag_s: t * if_so(case % 5 == 0, random.between(0.0, 2.0)),
            },
            wall: SampledWall {
                stiffness_n_per_m: softer * random.between(100.0, 5000.0),
                dissipation_n_s_mu_per_m: beta * mass_kg * t.powf(mu - 2.0),
                order: order(mu),
                sample_time_s: t,
            },
            operator: &operator,
        };
        if !subject.is_stable(0.0) {
            continue;
        }
        match subject.check(&format!("case {case}")) {
            None => none += 1,
            Some(most) if most < 1.0 => short += 1,
            Some(_) => long += 1,
        }
    }
    assert!(short > 50 && long > 50, "{short} {long} {none}");
}

/// A swing behind a spring: with more delay the loop is lost and comes back, again and again.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_first_of_several_edges_counts_where_stability_comes_back() {
    let mut random = Random(77);
    let operator = operator("exact", 0.8);
    let (mut checked, mut returned) = (0, 0);
    for case in 0..600 {
        let omega = random.between(0.3, 2.5);
        let damping = 0.4 * omega * random.between(0.05, 1.0);
        #[rustfmt::skip]
        let a = [
            0.0,            1.0,
            -omega * omega, -damping,
        ];
        let (alpha, beta) = (random.between(0.001, 0.3), random.between(0.0, 0.3));
        let at = |delay: f64| {
            let path = ForcePath::new(delay, 0.0).expect("in range");
            let plant = SampledPlant::linear(&a, &[0.0, 1.0], &[1.0, 0.0], 1.0, 1.0, path);
            let plant = plant.expect("samples");
            SampledLoop::with_plant(plant, alpha, beta, &operator).expect("in range")
        };
        let first = random.between(0.0, 5.0);
        if !at(first).is_stable() {
            continue;
        }
        let Some(delay) = at(first).margins().expect("stable").delay else {
            continue;
        };
        let what = format!("case {case}: {delay:?}");
        for k in 0..60_u32 {
            let less = 0.999_999 * delay.value * f64::from(k) / 59.0;
            assert!(at(first + less).is_stable(), "{what}: {less}");
        }
        assert!(!at(first + delay.value * 1.000_001).is_stable(), "{what}");
        let turn = 2.0 * PI / delay.theta;
        let back = (1..20_u32).any(|k| {
            let more = delay.value + turn * f64::from(k) / 20.0;
            at(first + more).is_stable()
        });
        checked += 1;
        returned += usize::from(back);
    }
    assert!(checked > 100 && returned > 40, "{checked} {returned}");
}
