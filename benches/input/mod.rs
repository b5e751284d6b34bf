//! What all benches share: the input and the sizes.

use fractional_haptics::fracdiff::{Order, Real, Seconds};
use fractional_haptics::haptic_loop::plant::RampHold;
use fractional_haptics::haptic_loop::units::Metres;

/// Calls between two looks at the clock.
pub(crate) const BATCH: usize = 1000;
/// T of the loop.
pub(crate) const SAMPLE_TIME: Seconds = Seconds(1e-3);
/// Order of the cancerous prostate.
pub(crate) const ORDER: f64 = 0.2247;

/// [`ORDER`] as the library wants it.
pub(crate) fn order() -> Order {
    Order::new(ORDER).expect("0.2247 is an order")
}

/// One press: 0 to 1 mm in 0.2 s, held for 0.8 s. The benches press again and again, and the history
/// goes on.
pub(crate) fn ramp_and_hold<F: Real>() -> [F; BATCH] {
    let press = RampHold::new(Metres(1e-3), Seconds(0.2)).expect("a depth and a time");
    std::array::from_fn(|n| F::from_f64(press.position(n as f64 * SAMPLE_TIME.0)))
}
