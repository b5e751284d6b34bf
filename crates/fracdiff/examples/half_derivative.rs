//! The half derivative of a stream, sample by sample, with all of its past.
//!
//! ```text
//! cargo run -p fracdiff --example half_derivative
//! ```

use fracdiff::full_memory::{Design, FullMemory, Kernel};
use fracdiff::{Channel, Order, Seconds};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sample_time = Seconds(1e-3);
    // Up to ten minutes, every weight within 1e-6: some 25 modes, however long the stream runs.
    let design = Design::<16, 40>::closed_form(
        Kernel::PiecewiseLinear,
        Order::new(0.5)?,
        1e-6,
        600.0 / sample_time.0,
    )?;
    let mut stream = Channel::new(FullMemory::<f64, 16, 40>::new(&design, sample_time)?);

    println!(
        "{} modes\n   t in s   of t    wanted, 2·√(t/π)",
        design.modes().len()
    );
    for n in 0..=100_000 {
        let t = f64::from(n) * sample_time.0;
        let half = stream.step(t);
        let wanted = 2.0 * (t / std::f64::consts::PI).sqrt();
        if [1, 10, 100, 1000, 10_000, 100_000].contains(&n) {
            println!("{t:9.3} {half:9.6} {wanted:9.6}");
        }
        if (half - wanted).abs() > 2e-6 * wanted {
            return Err(format!("{half} instead of {wanted} at {t} s").into());
        }
    }
    Ok(())
}
