//! A fractional law at 500 Hz and 1 kHz against the exact sum over the motion that was recorded.

use super::world::{Rig, Wire};
use crate::exact::off_from_the_sum;
use fracdiff::{Order, Scheme, Seconds};
use haptic_devices::moteus::MoteusSettings;
use haptic_emulator::moteus::Shaft;
use haptic_link::{Configuration, State};

/// α of cancerous prostate, and a dissipation, N·s^α/m.
const ORDER: f64 = 0.2247;
const DISSIPATION: f64 = 100.0;

#[test]
fn a_fractional_force_is_the_sum_over_the_recorded_motion() {
    for tick_us in [2000, 1000] {
        let t = Seconds(1e-6 * f64::from(tick_us));
        let order = Order::new(ORDER).expect("an order");
        let ticks = 3000_u32;
        let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
        let operator = scheme.build::<f32>(order, t, 2.0 * f64::from(ticks));
        let operator = operator.expect("an operator");
        let (shape, coefficients) = haptic_remote::operator_shape(&operator).expect("portable");
        let law = Configuration {
            tick_period_us: tick_us,
            dissipation_n_s_mu_per_m: DISSIPATION as f32,
            order: ORDER as f32,
            operator: shape,
            ..Configuration::PASSIVE
        };
        let mut rig = Rig::with(Wire::new(Shaft::LEVER), law, &coefficients);
        rig.start();
        let (mut positions, mut forces) = (Vec::new(), Vec::new());
        for tick in 0..ticks {
            // A hand leads the lever by 4 mm at 1.5 Hz.
            let turned = core::f64::consts::TAU * 1.5 * t.0 * f64::from(tick);
            rig.place(4e-3 * libm::sin(turned));
            rig.tick();
            let sample = *rig.device.newest();
            assert_eq!(rig.state(), State::Running);
            assert_eq!(sample.limiters, 0, "{sample:?}");
            positions.push(f64::from(sample.position_m[0]));
            forces.push(f64::from(sample.force_n[0]));
            // The servo makes it.
            let made_n = rig.torque_nm() / MoteusSettings::DEFAULT.radius_m;
            let wanted_n = f64::from(sample.force_n[0]);
            assert!((made_n - wanted_n).abs() < 1e-6, "{made_n} of {wanted_n} N");
        }
        let (error, largest) = off_from_the_sum(DISSIPATION, order, t, &positions, &forces);
        println!("at {tick_us} µs: {:e} of {largest} N", error / largest);
        assert!(largest > 0.2, "{largest} N");
        assert!(error < 1e-3 * largest, "{error} of {largest} N");
    }
}
