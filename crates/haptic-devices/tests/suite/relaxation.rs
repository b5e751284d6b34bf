//! A fractional law at 500 Hz and 1 kHz on devices of other makers, against the exact sum over the motion that was recorded.

use crate::{
    haply::wire::{Law, Running, stroked},
    moteus::world::{Rig, Wire},
};
use fracdiff::{Scheme, Seconds, batch::Batch, full_memory::Kernel};
use haptic_devices::{haply::Version, moteus::MoteusSettings};
use haptic_emulator::moteus::Shaft;
use haptic_link::{Configuration, OperatorShape, State};
use testkit::{assert_close, operator::order};

/// α of cancerous prostate.
const ORDER: f64 = 0.2247;
const TICKS: u32 = 3000;
const PERIODS_US: [u32; 2] = [2000, 1000];

fn operator(t: Seconds) -> (OperatorShape, Vec<f32>) {
    let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
    let operator = scheme.build::<f32>(order(ORDER), t, 2.0 * f64::from(TICKS));
    haptic_remote::operator_shape(&operator.expect("an operator")).expect("portable")
}

/// Forces, N, of a device at its positions, m: within a thousandth of −B·D^μ x.
fn is_the_sum(dissipation: f64, t: Seconds, motion: &[(f64, f64)]) {
    let (positions, forces): (Vec<f64>, Vec<f64>) = motion.iter().copied().unzip();
    let sum = Batch::full_history(Kernel::Grunwald, order(ORDER), t).expect("a sum");
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for (sum, have) in sum.run(&positions).into_iter().zip(forces) {
        let want = -dissipation * sum;
        error = error.max((want - have).abs());
        largest = largest.max(want.abs());
    }
    println!("at {} s: {:e} of {largest} N", t.0, error / largest);
    assert!(largest > 0.2, "{largest} N");
    assert!(error < 1e-3 * largest, "{error} of {largest} N");
}

#[test]
fn the_force_of_a_2diy_is_the_sum_over_the_recorded_motion() {
    const DISSIPATION: f64 = 20.0;
    for (version, tick_us) in Version::ALL.map(|v| PERIODS_US.map(|t| (v, t))).concat() {
        let t = Seconds(1e-6 * f64::from(tick_us));
        let law = Law {
            dissipation: DISSIPATION as f32,
            order: ORDER as f32,
            operator: operator(t),
            tick_us,
            ..Law::default()
        };
        let mut running = Running::with(stroked(version, 1_200_000), version, 1_200_000, &law);
        let motion = (0..TICKS).map(|_| {
            running.tick();
            let sample = *running.device.newest();
            assert_eq!(running.device.status().state, State::Running);
            assert_eq!(sample.limiters, 0, "{sample:?}");
            let force = f64::from(sample.force_n[0]);
            // The motors make it, along y and nowhere else.
            let made = running.force();
            assert_close("made.y", made.y, force, 0.01 * made.y.abs() + 1e-6);
            (f64::from(sample.position_m[0]), force)
        });
        is_the_sum(DISSIPATION, t, &motion.collect::<Vec<_>>());
    }
}

#[test]
fn the_force_of_a_servo_is_the_sum_over_the_recorded_motion() {
    const DISSIPATION: f64 = 100.0;
    for tick_us in PERIODS_US {
        let t = Seconds(1e-6 * f64::from(tick_us));
        let (operator, coefficients) = operator(t);
        let law = Configuration {
            tick_period_us: tick_us,
            dissipation_n_s_mu_per_m: DISSIPATION as f32,
            order: ORDER as f32,
            operator,
            ..Configuration::PASSIVE
        };
        let mut rig = Rig::with(Wire::new(Shaft::LEVER), law, &coefficients);
        rig.start();
        let motion = (0..TICKS).map(|tick| {
            // A hand leads the lever by 4 mm at 1.5 Hz.
            let turned = core::f64::consts::TAU * 1.5 * t.0 * f64::from(tick);
            rig.place(4e-3 * libm::sin(turned));
            rig.tick();
            let sample = *rig.device.newest();
            assert_eq!(rig.state(), State::Running);
            assert_eq!(sample.limiters, 0, "{sample:?}");
            // The servo makes it.
            let wanted_n = f64::from(sample.force_n[0]);
            let made_n = rig.torque_nm() / MoteusSettings::DEFAULT.radius_m;
            assert_close("force", made_n, wanted_n, 1e-6);
            (f64::from(sample.position_m[0]), wanted_n)
        });
        is_the_sum(DISSIPATION, t, &motion.collect::<Vec<_>>());
    }
}
