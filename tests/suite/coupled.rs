//! The certified verdict on device, coupler and object against simulation at the boundary: random devices with delay, lag
//! and hand, 1 % inside the nearest edge and 1 % outside it. Neither may be on the wrong side.
//!
//! The default run takes 100 devices, some seconds. `CAMPAIGN_CASES=1000` asks for more, of the same sequence.

use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{CoupledLoop, CoupledObject, Coupler, Dynamics, LoopOperator};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{VirtualCoupler, VirtualObject, deflection_order};
use testkit::Random;
use testkit::device::settles;

const T: Seconds = Seconds(1e-3);
/// Memory of the operator, samples.
const HORIZON: f64 = 2e6;
/// Distance from the edge, as a share of the gain.
const BESIDE: f64 = 1e-2;

/// A device, an object, and the shares of `k_c` and `b_c`.
#[derive(Clone, Copy, Debug)]
struct Case {
    device: Dynamics,
    object: CoupledObject,
    order: Order,
    shares: [f64; 2],
}

impl Case {
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

    fn gains(&self, gain: f64) -> [f64; 2] {
        self.shares.map(|share| gain * share)
    }

    fn closed<'a>(&self, gain: f64, operator: &'a LoopOperator) -> CoupledLoop<'a> {
        let [k_c, b_c] = self.gains(gain);
        let coupler = Coupler::exact(self.order, T.0, k_c, b_c).expect("in range");
        CoupledLoop::new(&self.device, &coupler, &self.object, operator).expect("in range")
    }

    /// Whether a push of the device dies out.
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

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_coupled_device_is_on_the_wrong_side_of_its_boundary() {
    let cases = testkit::cases(100);
    let mut random = Random(13_002);
    let (mut tried, mut number, mut wrong) = (0, 0, Vec::new());
    while tried < cases {
        number += 1;
        let case = Case::random(number, &mut random);
        let order = deflection_order(case.order).expect("in range");
        let operator = LoopOperator::new(Scheme::Exact, order, T, HORIZON).expect("an operator");
        let weak = 1e-3;
        let Ok(Some(edge)) = case.closed(weak, &operator).gain_margin() else {
            continue;
        };
        tried += 1;
        for (factor, want) in [(1.0 - BESIDE, true), (1.0 + BESIDE, false)] {
            let gain = factor * weak * edge.value;
            let stable = case.closed(gain, &operator).is_stable();
            assert_eq!(stable, want, "the margin is not an edge: {case:?}");
            if case.settles(gain, edge.theta) != want {
                wrong.push(format!(
                    "{number}: should settle {want}, {edge:?}, {case:?}"
                ));
            }
        }
    }
    println!("{tried} devices of {number}, {} wrong", wrong.len());
    assert!(number < 3 * cases, "{number} tried: most have no edge");
    assert!(wrong.is_empty(), "{wrong:#?}");
}
