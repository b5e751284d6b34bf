//! The largest passive walls of one order, by Theorem 1.

use super::bench::{Bench, INSIDE};
use super::candidate::Point;
use super::question::Wish;
use haptic_analysis::{AnalysisError, Largest};

/// Share of the largest β that a wall with the most damping has.
const MOST_DAMPING: f64 = 0.99;
/// Golden sections: (0.618)^60 of a quarter turn.
const SECTIONS: usize = 60;

impl Bench<'_> {
    pub(super) fn passive_wall(&self) -> Result<Point, AnalysisError> {
        let port = self.port()?;
        let required = |alpha: f64, beta: f64| port.required_delta(alpha, beta).map(|r| r.delta);
        let quiet = self.quiet_beta();
        let wall = |alpha, beta| Point::Wall {
            alpha: INSIDE * alpha,
            beta: INSIDE * beta,
            scale: None,
        };
        if self.delta <= 0.0 {
            return Ok(Point::None(self.nothing()));
        }
        if let Wish::MostDamping { .. } = self.design.wish {
            let (mut ratio, mut least) = minimum(|s| required(s, 1.0))?;
            // The set of passive walls is convex: where the best ratio leaves a negative spring, the bound is best.
            if let Some(softest) = port.largest_ratio().map(|most| 1.0 / (INSIDE * most))
                && ratio < softest
            {
                (ratio, least) = (softest, required(softest, 1.0)?);
            }
            if least <= 0.0 {
                return Ok(Point::None(self.nothing()));
            }
            let beta = (MOST_DAMPING * self.delta / least).min(quiet);
            return Ok(match port.largest_alpha(self.delta, beta)? {
                // The set of passive walls is convex, so the middle is passive.
                Largest::Below { value, .. } => wall(0.5 * (ratio * beta + value), beta),
                _ => Point::None(self.nothing()),
            });
        }
        let (mut ratio, mut least) = minimum(|t| required(1.0, t))?;
        if let Some(most) = port.largest_ratio().map(|most| INSIDE * most)
            && ratio > most
        {
            (ratio, least) = (most, required(1.0, most)?);
        }
        if least <= 0.0 {
            return Ok(Point::None(self.nothing()));
        }
        let alpha = self.delta / least;
        if ratio * alpha <= quiet {
            return Ok(wall(alpha, ratio * alpha));
        }
        // The set of passive walls is convex, so the stiffest quiet wall is as noisy as it may be.
        Ok(match port.largest_alpha(self.delta, quiet)? {
            Largest::Below { value, .. } => wall(value, quiet),
            _ => Point::None(self.nothing()),
        })
    }

    /// The factor up to which a wall stays passive; `None` if a device without damping bears none.
    pub(super) fn largest_passive_scale(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        // sup(α·u + β·v) grows in proportion to the wall.
        let required = self.port()?.required_delta(alpha, beta)?;
        let scale = self.delta / required.delta;
        let sound = scale > 0.0 && scale.is_finite() && !required.negative_at_rest;
        Ok(Some(scale).filter(|_| sound))
    }
}

/// Minimum of a convex function of t ≥ 0: its place and its value; t = 0 if nothing else is better by 1e-9.
fn minimum(
    function: impl Fn(f64) -> Result<f64, AnalysisError>,
) -> Result<(f64, f64), AnalysisError> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    // t = tan φ; a convex function of t falls and rises at most once in φ too.
    let at = |phi: f64| function(phi.tan());
    let (mut low, mut high) = (0.0, 0.5 * std::f64::consts::PI);
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (at(a)?, at(b)?);
    for _ in 0..SECTIONS {
        if at_a <= at_b {
            high = b;
            (b, at_b) = (a, at_a);
            a = high - golden * (high - low);
            at_a = at(a)?;
        } else {
            low = a;
            (a, at_a) = (b, at_b);
            b = low + golden * (high - low);
            at_b = at(b)?;
        }
    }
    let (phi, least) = if at_a <= at_b { (a, at_a) } else { (b, at_b) };
    let alone = function(0.0)?;
    if alone <= least * (1.0 + 1e-9) {
        Ok((0.0, alone))
    } else {
        Ok((phi.tan(), least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_minimum_of_a_convex_function_is_found() {
        let (t, value) = minimum(|t| Ok((t - 3.0).abs() + 1.0)).expect("finite");
        assert!(
            (t - 3.0).abs() < 1e-9 && (value - 1.0).abs() < 1e-9,
            "{t} {value}"
        );
        let (t, value) = minimum(|t| Ok(2.0 + t)).expect("finite");
        assert!(
            t.abs() < f64::EPSILON && (value - 2.0).abs() < f64::EPSILON,
            "{t} {value}"
        );
    }
}
