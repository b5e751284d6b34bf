//! The set that a tissue remembers: where its surface stands after it was pushed in.

use crate::bench::refused;
use fracdiff::{Channel, Operator, Order, Scheme, Seconds};
use wasm_bindgen::prelude::*;

/// Memory of the picture, samples.
const HORIZON: f64 = 1e4;

/// A tissue's memory of the depths it was pushed to.
///
/// ```text
/// K·x₀ + B·D^μ x = 0 for the depth x₀ that follows the history: there it pushes with nothing
/// ```
#[wasm_bindgen]
#[derive(Debug)]
pub struct Remembered {
    channel: Channel<f64, Operator<f64>>,
    stiffness_n_per_m: f64,
    dissipation_n_s_mu_per_m: f64,
}

#[wasm_bindgen]
impl Remembered {
    /// Untouched; `step_s` is the time between two depths.
    ///
    /// # Errors
    /// An order or a step outside its range.
    #[wasm_bindgen(constructor)]
    pub fn new(
        order: f64,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
        step_s: f64,
    ) -> Result<Self, JsError> {
        let scheme: Scheme = "full".parse().map_err(refused)?;
        let order = Order::new(order).map_err(refused)?;
        let operator = scheme
            .build(order, Seconds(step_s), HORIZON)
            .map_err(refused)?;
        Ok(Self {
            channel: Channel::new(operator),
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
        })
    }

    /// It was pushed to these depths, m, one after the other.
    pub fn pushed(&mut self, depths_m: &[f64]) {
        for depth in depths_m {
            self.channel.advance(*depth);
        }
    }

    /// x₀, m, at least 0.
    #[must_use]
    pub fn set_m(&self) -> f64 {
        // The output is linear in the newest sample: y(x) = y(0) + (y(1) − y(0))·x.
        let before = self.channel.output(0.0);
        let slope = self.channel.output(1.0) - before;
        let b = self.dissipation_n_s_mu_per_m;
        let set = -b * before / (self.stiffness_n_per_m + b * slope);
        if set.is_finite() { set.max(0.0) } else { 0.0 }
    }
}
