//! The position loop of a press that is given none: a PID on a mass with damping.
//!
//! ```text
//! P(s) = 1/(ms² + bs),   K(jω)·P(jω) = −e^(jφ)   ⇒   K_p = mω²/2 + (√3/2)·b·ω      φ = 60°
//!                                                    ω·K_d = (√3/2)·mω² − b·ω/2 + K_i/ω,   K_i = K_p·ω/10
//! ω = min(0.2/T, 0.3/(T/2 + d))                      T the sample time, d delay and lag, s
//! ```
//! - *Symbols*: m mass, kg; b damping, N·s/m; ω the crossover, rad/s; gains from m to N.
//! - *Crossover*: as high as the samples allow, so that a stiff specimen moves it little. Delays cost at most 0.3 rad of the margin.
//! - *A device of much damping* would need a derivative below 0: it gets 0, and more margin.

use fractional_control::{ControllerSetup, PidParameters, SetPoint};
use haptic_loop::plant::MassDamperConfig;
use haptic_quantity::digits;
use haptic_trial::controller_file::{ControllerFile, ControllerOrigin};

/// The loop of this device, whose line delays a force by this many samples.
pub(super) fn position_loop(device: &MassDamperConfig, line: f64) -> ControllerFile {
    let (m, b, t) = (device.mass.0, device.damping.0, device.sample_time.0);
    let late_s = (0.5 + line) * t + device.delay.0 + device.current_lag.0;
    let omega = f64::min(0.2 / t, 0.3 / late_s);
    let (sine, cosine) = (0.75_f64.sqrt(), 0.5);
    let proportional = cosine * m * omega * omega + sine * b * omega;
    let derivative = sine * m * omega - cosine * b + 0.1 * proportional / omega;
    let pid = PidParameters {
        proportional,
        integral: 0.1 * proportional * omega,
        derivative: derivative.max(0.0),
        ..PidParameters::NONE
    };
    let plant = format!("1/({m}s^2+{b}s)");
    ControllerFile {
        setup: ControllerSetup {
            // Its path has no jump, and the whole error makes the handle follow it closely.
            set_point: SetPoint {
                derivative: 1.0,
                ..SetPoint::DEFAULT
            },
            ..ControllerSetup::new(pid, device.sample_time)
        },
        origin: ControllerOrigin {
            plant,
            wishes: format!("{} rad/s, 60 degrees of margin", digits(omega, 4)),
            note: "made by [press] from mass and damping".to_owned(),
            ..ControllerOrigin::default()
        },
    }
}
