//! Words of a command line as values: orders, schemes, numbers, sizes.

use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme, Seconds};
use haptic_experiment::Failure;
use haptic_log::record::ROLL_LEAST;
use haptic_quantity::Bytes;
pub use haptic_quantity::parse_number;

/// The size that `--roll` gives, if it does.
///
/// # Errors
/// A size outside its range.
pub fn roll_bytes(size: Option<Bytes>) -> Result<Option<u64>, Failure> {
    /// No disk has more.
    const MOST: f64 = 1e15;
    let least = ROLL_LEAST as f64;
    match size {
        None => Ok(None),
        Some(Bytes(bytes)) if (least..=MOST).contains(&bytes) => Ok(Some(bytes as u64)),
        Some(Bytes(bytes)) => Err(Failure::bad_input(format_args!(
            "size {bytes} bytes is not in [{least:e}, {MOST:e}]: give --roll, as in 1GB",
            bytes = Shown(bytes)
        ))),
    }
}

/// The sample time for an operator without units, which matters only to a scheme with frequencies in Hz.
///
/// # Errors
/// Such a scheme without one.
pub fn sample_time_of(scheme: Scheme, given_s: Option<f64>) -> Result<Seconds, Failure> {
    match (scheme, given_s) {
        (Scheme::Oustaloup { .. }, None) => Err(Failure::bad_input(format_args!(
            "scheme {scheme} has frequencies in Hz, which mean nothing without a sample time: give --sample-time, as in 1ms"
        ))),
        _ => Ok(Seconds(given_s.unwrap_or(1.0))),
    }
}

/// Checks an order.
///
/// # Errors
/// Outside −2 ≤ μ ≤ 2.
pub fn order(mu: f64) -> Result<Order, Failure> {
    Order::new(mu).map_err(|error| Failure::input_with_advice(error, "give --order within it"))
}

/// T^(−μ), if the sample time is in the range that operators take.
///
/// # Errors
/// Outside that range.
pub fn rate(sample_time: Seconds, mu: Order) -> Result<f64, Failure> {
    sample_time
        .rate_to_the(mu)
        .map_err(|error| Failure::input_with_advice(error, "give --sample-time, as in 1ms"))
}

/// Reads an order; its range is checked by [`order`].
///
/// # Errors
/// If it is no number, or not finite.
pub fn parse_order(text: &str) -> Result<f64, String> {
    parse_number(text).map_err(|error| format!("{error} in [{}, {}]", Order::MIN, Order::MAX))
}

/// Reads a SCHEME.
///
/// # Errors
/// In the scheme's own words.
pub fn parse_scheme(text: &str) -> Result<Scheme, String> {
    text.parse()
        .map_err(|error: fracdiff::SchemeError| error.to_string())
}
