//! Order one against two masses with springs and dampers, in closed form.

use super::object;
use fracdiff::{Seconds, ShortMemory};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, Environment, SafetyChain, VirtualCoupler};
use nalgebra::{SMatrix, SVector, vector};
use testkit::device::{ideal, plant};
use testkit::operator::order;

/// A device of 0.1 kg that is pushed with 1 N for 0.3 s into a coupler of order 1 and an object: its place and the object's
/// at the end, m.
fn pushed(t: f64, [k_c, b_c]: [f64; 2], [m, b, k]: [f64; 3]) -> [f64; 2] {
    let sample_time = Seconds(t);
    let spring = ShortMemory::<f64, 1>::new(order(0.0), sample_time).expect("valid");
    let coupler = VirtualCoupler::new(k_c, b_c, spring, object([m, b, k]), sample_time);
    let chain = SafetyChain::new(Newtons(1e3), NewtonsPerSecond(1e9), sample_time).expect("valid");
    let mut controller = Controller::new(coupler.expect("valid"), chain);
    let mut device = plant(ideal(0.1, 0.8, t));
    device.set_external_force(vector![1.0]);
    let mut replay = controller.environment().at_rest();
    let mut engaged = controller.engage(device);
    for _ in 0..(0.3 / t).round() as usize {
        let Ok(sample) = engaged.tick();
        let x = sample.reading.position_m;
        engaged.controller().environment().advance(&mut replay, &x);
    }
    let behind = engaged.controller().environment();
    [
        engaged.device().position()[0],
        behind.object_position_m(&replay)[0],
    ]
}

#[test]
fn at_order_one_it_tends_to_two_masses_with_springs_and_dampers() {
    let ([k_c, b_c], [m, b, k]) = ([0.5, 300.0], [0.15, 0.1, 200.0]);
    let (m_d, b_d) = (0.1, 0.8);
    // x' = v,  m_d·v' = 1 − b_d·v − c(v − u) − s(x − p),  p' = u,  m·u' = c(v − u) + s(x − p) − b·u − k·p,  1' = 0
    #[rustfmt::skip]
    let a = SMatrix::<f64, 5, 5>::from_row_slice(&[
        0.0, 1.0, 0.0, 0.0, 0.0,
        -b_c / m_d, -(b_d + k_c) / m_d, b_c / m_d, k_c / m_d, 1.0 / m_d,
        0.0, 0.0, 0.0, 1.0, 0.0,
        b_c / m, k_c / m, -(b_c + k) / m, -(k_c + b) / m, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0,
    ]);
    // e^(a·0.3 s) by many short Taylor steps.
    let mut end = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 0.0, 1.0]);
    for _ in 0..1000 {
        let mut term = end;
        for k in 1..20 {
            term = a * term * (0.3e-3 / f64::from(k));
            end += term;
        }
    }
    let off = |t: f64| {
        let [x, p] = pushed(t, [k_c, b_c], [m, b, k]);
        (x - end[0]).abs().max((p - end[2]).abs())
    };
    let errors = [2e-4, 1e-4, 5e-5].map(off);
    // Of first order in T: hold, difference and running sum.
    assert!(
        errors[2] < 1e-3 * end[0].abs(),
        "{errors:?} of {} m",
        end[0]
    );
    for pair in errors.windows(2) {
        assert!((1.8..2.2).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}
