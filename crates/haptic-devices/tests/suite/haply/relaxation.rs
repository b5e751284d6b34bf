//! A fractional law at 500 Hz and 1 kHz against the exact sum over the motion that was recorded.

use super::wire::{Law, Running, stroking};
use crate::exact::off_from_the_sum;
use fracdiff::{Order, Scheme, Seconds};
use haptic_devices::haply::{Version, configuration};
use haptic_emulator::AtLine as _;
use haptic_link::State;

/// α of cancerous prostate, and a dissipation that these motors can bear, N·s^α/m.
const ORDER: f64 = 0.2247;
const DISSIPATION: f64 = 20.0;

#[test]
fn a_fractional_force_is_the_sum_over_the_recorded_motion() {
    for (version, tick_us) in [
        (Version::V2, 2000),
        (Version::V3, 2000),
        (Version::V2, 1000),
        (Version::V3, 1000),
    ] {
        let mut board = stroking(version);
        for byte in configuration(&version.model()) {
            board.receive(byte, 0, &mut Vec::new());
        }
        board.advance(1_200_000);
        let t = Seconds(1e-6 * tick_us as f64);
        let order = Order::new(ORDER).expect("an order");
        let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
        let ticks = 3000_u32;
        let operator = scheme.build::<f32>(order, t, 2.0 * f64::from(ticks));
        let operator = operator.expect("an operator");
        let law = Law {
            dissipation: DISSIPATION as f32,
            order: ORDER as f32,
            operator: haptic_remote::operator_shape(&operator).expect("portable"),
            tick_us,
            ..Law::default()
        };
        let mut running = Running::with(board, version, 1_200_000, &law);
        let (mut positions, mut forces) = (Vec::new(), Vec::new());
        for _ in 0..ticks {
            running.tick();
            let sample = *running.device.newest();
            assert_eq!(running.device.status().state, State::Running);
            assert_eq!(sample.limiters, 0, "{sample:?}");
            positions.push(f64::from(sample.position_m[0]));
            forces.push(f64::from(sample.force_n[0]));
            // The motors make it, along y and nowhere else.
            let made = running.force();
            assert!((made.y - forces[forces.len() - 1]).abs() < 0.01 * made.y.abs() + 1e-6);
        }
        let (error, largest) = off_from_the_sum(DISSIPATION, order, t, &positions, &forces);
        println!(
            "{version:?} at {tick_us} µs: {:e} of {largest} N",
            error / largest
        );
        assert!(largest > 0.2, "{largest} N");
        assert!(error < 1e-3 * largest, "{error} of {largest} N");
    }
}
