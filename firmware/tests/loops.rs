//! Loops of controllers whose commands have the same bits on the target and on the host: compiled by both.

use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc};
use fracdiff::{Real, Seconds};
use fractional_control::{
    Actuator, Controller, FractionalPid, PidParameters, PowerMemory, Rule, SetPoint,
};

const T: Seconds = Seconds(1e-3);
/// 10 s: the set point is reached, left and reached again, and the command is at its limit in between.
const SAMPLES: u32 = 10_000;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// PI^λD^μ with 200 s of memory at 1 kHz, from position in m to force in N: the drive of a mass of 65 g on 3.5 N·s/m.
pub(crate) fn pid<F: Real>(rule: Rule, tolerance: f64) -> FractionalPid<F, 48> {
    let gains = PidParameters {
        proportional: 400.0,
        integral: 2500.0,
        integral_order: 0.8,
        derivative: 12.0,
        derivative_order: 0.9,
    };
    let memory = PowerMemory::new(rule, tolerance, 200.0).expect("200 s");
    let actuator = Actuator::new(-2.0, 2.0).expect("limits");
    FractionalPid::new(gains, SetPoint::DEFAULT, actuator, memory, T).expect("48 modes are enough")
}

/// The set point of tick n, m.
pub(crate) fn set_point(n: u32) -> f64 {
    if n % 4000 < 2000 { 0.01 } else { -0.005 }
}

/// The mass in its loop.
#[derive(Debug)]
pub(crate) struct Mass<F> {
    pub(crate) position_m: F,
    velocity_m_per_s: F,
}

impl<F: Real> Mass<F> {
    pub(crate) const AT_REST: Self = Self {
        position_m: F::ZERO,
        velocity_m_per_s: F::ZERO,
    };

    /// v ← v + (T/m)(f − b·v), x ← x + T·v
    pub(crate) fn push(&mut self, force_n: F) {
        let (t, mass, damping) = (F::from_f64(T.0), F::from_f64(0.065), F::from_f64(3.5));
        let net = force_n - damping * self.velocity_m_per_s;
        self.velocity_m_per_s += t / mass * net;
        self.position_m += t * self.velocity_m_per_s;
    }
}

/// CRC-32 over the commands' bits, as `f64` (exact), little-endian.
fn digest<F: Real>(controller: &FractionalPid<F, 48>) -> u32 {
    let (mut history, mut mass) = (controller.at_rest(), Mass::<F>::AT_REST);
    let mut digest = CRC.digest();
    for n in 0..SAMPLES {
        let (r, y) = (F::from_f64(set_point(n)), mass.position_m);
        let command = controller.output(&history, r, y);
        digest.update(&command.to_f64().to_le_bytes());
        controller.advance(&mut history, r, y, command);
        mass.push(command);
    }
    digest.finalize()
}

/// Tells each case by its name.
pub(crate) fn digests(mut tell: impl FnMut(fmt::Arguments<'_>, u32)) {
    for (rule, name) in [(Rule::Grunwald, "grunwald"), (Rule::Bdf2, "bdf2")] {
        tell(
            format_args!("pid {name} f32"),
            digest(&pid::<f32>(rule, 1e-6)),
        );
    }
    tell(
        format_args!("pid grunwald f64"),
        digest(&pid::<f64>(Rule::Grunwald, 1e-6)),
    );
}
