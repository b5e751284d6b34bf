//! Surface of a tissue after it was pushed in: the set that it remembers.
//!
//! ```text
//! K·x₀ + B·D^μ x = 0 for the depth x₀ that follows the history: there it pushes with nothing
//! ```

use crate::words::Number;
use fracdiff::{Channel, Operator, Order, Scheme, Seconds};
use haptic_document::Failure;
use serde::Deserialize;

/// Memory of the picture, samples.
const HORIZON: f64 = 1e4;
/// Depths in one request at most: a minute of them.
const DEPTHS: usize = 3000;

/// Report of a page about the tissue that it draws.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRequest {
    /// The law, of a tissue that is untouched; without it the last one continues.
    law: Option<SurfaceLaw>,
    depths_m: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceLaw {
    order: Number,
    stiffness_n_per_m: Number,
    dissipation_n_s_mu_per_m: Number,
    step_s: Number,
}

/// The tissue that a page draws.
#[derive(Debug)]
pub struct TissueSurface {
    channel: Channel<f64, Operator<f64>>,
    law: SurfaceLaw,
}

impl TissueSurface {
    fn untouched(law: SurfaceLaw) -> Result<Self, Failure> {
        let scheme: Scheme = "full".parse().map_err(Failure::input)?;
        let order = Order::new(law.order.0).map_err(Failure::input)?;
        let operator = scheme.build(order, Seconds(law.step_s.0), HORIZON);
        Ok(Self {
            channel: Channel::new(operator.map_err(Failure::input)?),
            law,
        })
    }

    /// x₀, m, at least 0.
    fn set_m(&self) -> f64 {
        // The output is linear in the newest sample: y(x) = y(0) + (y(1) − y(0))·x.
        let before = self.channel.output(0.0);
        let slope = self.channel.output(1.0) - before;
        let b = self.law.dissipation_n_s_mu_per_m.0;
        let set = -b * before / (self.law.stiffness_n_per_m.0 + b * slope);
        if set.is_finite() { set.max(0.0) } else { 0.0 }
    }
}

/// The surface of a page's tissue after these depths, m.
///
/// # Errors
/// A law that is wrong, or missing; too many depths.
pub fn pushed(
    surface: &mut Option<TissueSurface>,
    request: SurfaceRequest,
) -> Result<f64, Failure> {
    if request.depths_m.len() > DEPTHS {
        return Err(Failure::bad_input(format_args!(
            "`depths_m` has {} numbers: send at most {DEPTHS} at a time",
            request.depths_m.len()
        )));
    }
    if let Some(law) = request.law {
        *surface = Some(TissueSurface::untouched(law)?);
    }
    let surface = surface
        .as_mut()
        .ok_or_else(|| Failure::bad_input("the tissue has no `law` yet: send it first"))?;
    for depth in request.depths_m {
        surface.channel.advance(depth);
    }
    Ok(surface.set_m())
}
