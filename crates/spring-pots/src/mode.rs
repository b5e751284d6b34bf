//! One mode of a positive spectrum, of which a response is a sum.
//! ```text
//! relaxation  1, e^(−t/τ)     its integral  t, 1, τ(1 − e^(−t/τ))     creep  1, t, 1 − e^(−t/τ)     M(iω)  1, iω, iωτ/(1 + iωτ)
//! ```

use crate::contour::Quantity;

/// A mode of a positive spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectralMode {
    /// A spring beside the others; of creep in series with them.
    Spring,
    /// A dashpot beside the others; of creep in series with them.
    Dashpot,
    /// A decay, by the logarithm of its time.
    Decay(f64),
}

impl SpectralMode {
    /// Its share in a function of time at ln t, or without one its storage and loss modulus at ln ω, of unit size.
    #[must_use]
    pub fn at(self, quantity: Option<Quantity>, ln_x: f64) -> [f64; 2] {
        let x = libm::exp(ln_x);
        let left = |ln_time: f64| libm::exp(-libm::exp(ln_x - ln_time));
        let gone = |ln_time: f64| -libm::expm1(-libm::exp(ln_x - ln_time));
        let one = match (quantity, self) {
            (None, Self::Spring) => return [1.0, 0.0],
            (None, Self::Dashpot) => return [0.0, x],
            (None, Self::Decay(ln_time)) => {
                let turns = libm::exp(ln_x + ln_time);
                let loss = turns / (1.0 + turns * turns);
                return [turns * loss, loss];
            }
            (Some(Quantity::Relaxation), Self::Dashpot) => 0.0,
            (Some(Quantity::Relaxation | Quantity::Creep), Self::Spring)
            | (Some(Quantity::Integral), Self::Dashpot) => 1.0,
            (Some(Quantity::Integral), Self::Spring) | (Some(Quantity::Creep), Self::Dashpot) => x,
            (Some(Quantity::Relaxation), Self::Decay(ln_time)) => left(ln_time),
            (Some(Quantity::Creep), Self::Decay(ln_time)) => gone(ln_time),
            (Some(Quantity::Integral), Self::Decay(ln_time)) => libm::exp(ln_time) * gone(ln_time),
        };
        [one, 0.0]
    }
}
