//! A kernel of one's own: a tissue that relaxes by a power law at first, and all the way after ten seconds.
//!
//! ```text
//! F[n] = T^(−μ)·Σ_j c_j·e^(−λj)·Δx[n−j],    c_j the weights of the integral of order 1 − μ,    λ = T/10 s
//!
//! cargo run -p fracdiff --example own_kernel
//! ```
//! The weights of D^μ are a sum of decaying modes; tempering makes every one of them faster by λ.

use fracdiff::full_memory::{DecayingMode, Design, FullMemory, Kernel};
use fracdiff::{Channel, Order, Seconds, grunwald_weight};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (order, sample_time) = (Order::new(0.2247)?, Seconds(1e-3));
    let integral = Order::new(order.get() - 1.0)?;
    let lambda = sample_time.0 / 10.0;

    let plain = Design::<16, 40>::closed_form(Kernel::Grunwald, order, 1e-6, 1e5)?;
    let tempered: Vec<DecayingMode> = plain
        .modes()
        .iter()
        .map(|mode| DecayingMode {
            rate: mode.rate + lambda,
            ..*mode
        })
        .collect();
    let weight = |lag: u64| grunwald_weight(integral, lag) * (-lambda * lag as f64).exp();
    // It measures the modes against the weights, so a wrong kernel does not go unseen.
    let design = Design::<16, 40>::from_modes(order, weight, &tempered, 1e5)?;
    println!("error of any weight at most {:.1e}", design.error_bound());

    let operator = FullMemory::<f64, 16, 40>::new(&design, sample_time)?;
    let mut tissue = Channel::new(&operator);
    let mut powerlaw = Channel::new(FullMemory::<f64, 16, 40>::new(&plain, sample_time)?);
    println!("a step held:   t in s   power law    tempered");
    for n in 0..=50_000_u32 {
        let (fades, stays) = (tissue.step(1.0), powerlaw.step(1.0));
        if [1, 100, 1000, 10_000, 50_000].contains(&n) {
            println!(
                "{:22.3} {stays:10.5} {fades:11.5}",
                f64::from(n) * sample_time.0
            );
        }
        // The response to a step is the weight itself.
        let wanted = sample_time.0.powf(-order.get()) * weight(n.into());
        if (fades - wanted).abs() > 2e-6 * wanted {
            return Err(format!("{fades} instead of {wanted} at sample {n}").into());
        }
    }
    Ok(())
}
