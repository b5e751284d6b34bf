//! The ratio of a fraction on the circle: one that no loop can bear is refused before a verdict is asked for.

use crate::ControlError;
use crate::enclosure::{Factor, Fraction, Product, Sum};
use fracdiff::parameter::range;

/// Largest ratio of above to below, or of below to above, as a power of two: of two such fractions the square of the product is still a number.
const RATIO_MAX: i32 = 249;

impl Fraction {
    /// Itself, if above and below are numbers of which a loop can be made.
    ///
    /// # Errors
    /// Above and below that are more than 1e75 times apart. `what` is their ratio.
    pub(crate) fn bearable(self, what: &'static str) -> Result<Self, ControlError> {
        // A controller of nothing has no product above.
        if let (Some(above), Some(below)) = (power(&self.above), power(&self.below)) {
            let apart = above - below;
            let ratio = libm::ldexp(1.0, apart.clamp(-1022, 1023));
            let allowed = "from 1e-75 to 1e75 in size: give plant and controller in other units";
            range(what, ratio, apart.abs() <= RATIO_MAX, allowed, "")?;
        }
        Ok(self)
    }
}

/// log₂ of the largest product, about; `None` if there is none but 0.
fn power(sum: &Sum) -> Option<i32> {
    let of_numbers = |numbers: &[f64]| {
        let largest = numbers.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        (largest > 0.0).then(|| libm::ilogb(largest))
    };
    let of_product = |product: &Product| {
        let first = of_numbers(&[product.scale])?;
        product.factors.iter().try_fold(first, |sum, factor| {
            Some(match factor {
                Factor::InW(c) | Factor::InV(c) => sum + of_numbers(c)?,
                // About 1.
                _ => sum,
            })
        })
    };
    sum.0.iter().filter_map(of_product).max()
}
