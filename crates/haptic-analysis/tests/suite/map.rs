//! Maps of verdicts: the same as wall by wall, at a cost that goes with the boundary.

use haptic_analysis::{LoopOperator, SampledLoop, SampledPlant, StabilityMap, StabilityRegion};
use testkit::Random;
use testkit::operator::{operator, path};

/// A device, and walls up to beyond its region.
struct Case {
    what: String,
    plant: SampledPlant,
    operator: LoopOperator,
    most: [f64; 2],
}

impl Case {
    fn drawn(random: &mut Random, case: usize) -> Self {
        let schemes = "exact muir:3 grunwald:20 tustin-muir:5 full:1e-4 full-bdf2:1e-4 muir:9";
        let scheme = schemes.split(' ').nth(case % 7).expect("seven");
        let order = match case % 5 {
            0 => 0.5 * random.between(0.0, 5.0).floor(),
            _ => random.between(0.02, 2.0),
        };
        let delta = match case % 3 {
            0 => 0.0,
            _ => random.between(0.0, 2.0),
        };
        let gamma = match case % 4 {
            0 | 1 => 0.0,
            _ => random.between(0.0, 1.5),
        };
        let (delay, lag) = match case % 2 {
            0 => (0.0, 0.0),
            _ => (random.between(0.0, 4.0), random.between(0.0, 3.0)),
        };
        let plant = SampledPlant::behind(delta, gamma, path(delay, lag)).expect("in range");
        let operator = operator(scheme, order);
        let region = StabilityRegion::new(plant, &operator, 0, 100).expect("closes");
        let most = region.bounded().map_or([2.0, 2.0], |area| {
            [1.3 * area.alpha_max, 1.3 * area.beta_max]
        });
        Self {
            what: format!("case {case}: {scheme} {order}, δ {delta}, γ {gamma}, {delay} + {lag}"),
            plant,
            operator,
            most,
        }
    }

    fn map(&self, alphas: &[f64], betas: &[f64]) -> StabilityMap {
        StabilityMap::new(self.plant, &self.operator, alphas, betas).expect("in range")
    }

    fn assert_as_one_by_one(&self, alphas: &[f64], betas: &[f64]) {
        let map = self.map(alphas, betas);
        for (i, &alpha) in alphas.iter().enumerate() {
            for (j, &beta) in betas.iter().enumerate() {
                let one = SampledLoop::with_plant(self.plant, alpha, beta, &self.operator);
                let one = one.expect("in range");
                let what = format!("{}, α {alpha}, β {beta}", self.what);
                assert_eq!(map.is_stable(i, j), one.is_stable(), "{what}");
                // A whole verdict finds the poles too, which takes its time.
                if (i + j) % 16 == 0 {
                    let poles = one.verdict().unstable_poles;
                    assert_eq!(map.unstable_poles(i, j), poles, "{what}");
                }
            }
        }
    }
}

fn evenly(most: f64, number: u32) -> Vec<f64> {
    let share = |k| f64::from(k) / f64::from(number);
    (0..number).map(|k| most * share(k)).collect()
}

#[test]
fn every_wall_has_the_verdict_that_it_has_alone() {
    let mut random = Random(36);
    for case in 0..20 {
        let case = Case::drawn(&mut random, case);
        let [alpha, beta] = case.most;
        case.assert_as_one_by_one(&evenly(alpha, 13), &evenly(beta, 18));
        // By decades, far beyond the region, with one value twice.
        let decades = |most: f64| {
            let at = |k: i32| most * 10_f64.powf(0.7 * f64::from(k / 2));
            (-20..=10).map(at).collect::<Vec<_>>()
        };
        case.assert_as_one_by_one(&decades(alpha), &[0.4 * beta]);
        case.assert_as_one_by_one(&[0.4 * alpha], &decades(beta));
    }
}

/// Without damping of the device, order 1: stable for α < 2β(2 − β)/(2 + β).
fn spring_and_damper() -> Case {
    Case {
        what: "μ = 1".to_owned(),
        plant: SampledPlant::new(0.0, 0.0).expect("in range"),
        operator: operator("exact", 1.0),
        most: [0.8, 2.0],
    }
}

#[test]
fn walls_on_the_boundary_are_not_stable() {
    let case = spring_and_damper();
    let edge = 2.0 / 3.0;
    let alphas = [0.0, 1e-9, edge * (1.0 - 1e-7), edge, edge * (1.0 + 1e-7)];
    let map = case.map(&alphas, &[0.5, 1.0]);
    let poles: Vec<_> = (0..5).map(|row| map.unstable_poles(row, 1)).collect();
    // α = 0 drifts, and 1e-9 cannot be told from it.
    assert_eq!(poles, [None, None, Some(0), None, Some(2)]);
}

#[test]
fn a_map_costs_as_much_as_its_boundary_is_long() {
    let case = spring_and_damper();
    let counts = |number: u32| {
        let [alpha, beta] = case.most;
        case.map(&evenly(alpha, number), &evenly(beta, number))
            .counts()
    };
    let [coarse, fine, finest] = [125, 250, 500].map(counts);
    assert!(finest < 10_000, "{finest} for 250 000 walls");
    // Twice as fine is twice the work, not four times.
    assert!(
        fine < 22 * coarse / 10 && finest < 22 * fine / 10,
        "{coarse} {fine} {finest}"
    );
    let one = case.map(&[0.1], &[1.0]);
    assert_eq!((one.counts(), one.is_stable(0, 0)), (1, true));
    assert_eq!(case.map(&[], &[1.0]).counts(), 0);
}

#[test]
fn gains_that_make_no_grid_are_refused_in_words() {
    let case = spring_and_damper();
    let refused = |alphas: &[f64], betas: &[f64]| {
        let map = StabilityMap::new(case.plant, &case.operator, alphas, betas);
        map.expect_err("refused").to_string()
    };
    let words = "alpha 0.1 is not at least the one before it";
    assert_eq!(refused(&[0.2, 0.1], &[1.0]), words);
    assert_eq!(refused(&[0.2], &[-1.0]), "beta -1 is not from 0 to 1e12");
    let words = "beta inf is not finite and from 0 to 1e12";
    assert_eq!(refused(&[0.2], &[f64::INFINITY]), words);
}
