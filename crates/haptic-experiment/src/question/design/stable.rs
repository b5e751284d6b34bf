//! The largest stable walls of one order, with a gain margin, from the stability region.

use super::bench::{Bench, INSIDE};
use super::candidate::Point;
use super::question::Wish;
use haptic_analysis::{AnalysisError, StabilityRegion, StableArea};

/// Points on the boundary of a region.
const POINTS: usize = 600;
/// Shares of the largest β that are tried for the most damping.
const SHARES: [f64; 6] = [0.99, 0.97, 0.9, 0.8, 0.6, 0.3];
/// Times that a wall is halved until it is stable.
const HALVINGS: usize = 40;

impl Bench<'_> {
    pub(super) fn stable_wall(&self, gain_margin: f64) -> Result<Point, AnalysisError> {
        let region = StabilityRegion::new(self.plant, &self.operator, 0, POINTS)?;
        let Some(area) = region.bounded() else {
            return Ok(Point::None(
                "no wall of this order is stable on this device".to_owned(),
            ));
        };
        let factor = INSIDE / gain_margin;
        // On the boundary, before the margin is taken.
        let quiet = self.quiet_beta() / factor;
        let edge = if matches!(self.design.wish, Wish::MostDamping { .. }) {
            most_damping(area, quiet)
        } else {
            stiffest(area, quiet)
        };
        // The region need not hold the whole way from no wall to its edge.
        for (alpha, beta) in edge {
            let (alpha, beta) = (factor * alpha, factor * beta);
            if alpha > 0.0 && self.has_margin(alpha, beta, gain_margin)? {
                return Ok(Point::Wall {
                    alpha,
                    beta,
                    scale: None,
                });
            }
        }
        Ok(Point::None(self.nothing()))
    }

    /// True if a wall is stable, also when all of it is weaker or stronger by up to g. A device with
    /// delay may need the wall in order to be stable at high order, so both ways count.
    fn has_margin(&self, alpha: f64, beta: f64, g: f64) -> Result<bool, AnalysisError> {
        let closed = self.closed(alpha, beta)?;
        if !closed.is_stable() {
            return Ok(false);
        }
        let margins = closed.margins()?;
        Ok(margins.gain_up.is_none_or(|gain| gain.value >= g)
            && margins.gain_down.is_none_or(|gain| gain.value <= 1.0 / g))
    }

    /// The factor on a wall at which it ceases to be stable, from below; `None` if it is not stable
    /// at any size.
    pub(super) fn largest_stable_scale(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        let mut scale = 1.0;
        for _ in 0..HALVINGS {
            let closed = self.closed(scale * alpha, scale * beta)?;
            if closed.is_stable() {
                // Without a limit there is no edge; no sampled wall is like that.
                return Ok(closed.margins()?.gain_up.map(|gain| scale * gain.value));
            }
            scale *= 0.5;
        }
        Ok(None)
    }
}

/// The boundary from the largest α down, as far as β is small enough: of all walls on one ray from the origin
/// the one whose g-fold lies on the boundary is the stiffest.
fn stiffest(area: &StableArea, quiet: f64) -> Vec<(f64, f64)> {
    let points = area.polygons.iter().flat_map(|polygon| &polygon.points);
    let mut edge: Vec<(f64, f64)> = points.map(|p| (p.alpha, p.beta)).collect();
    edge.push((area.alpha_max, area.beta_at_alpha_max));
    edge.retain(|(_, beta)| *beta <= quiet);
    if quiet < area.beta_max {
        edge.extend(crossings(area, quiet).last().map(|alpha| (*alpha, quiet)));
    }
    edge.sort_by(|a, b| b.0.total_cmp(&a.0));
    edge
}

/// Values of α at which the boundary has this β, the least first.
fn crossings(area: &StableArea, beta: f64) -> Vec<f64> {
    let mut crossings: Vec<f64> = Vec::new();
    for polygon in &area.polygons {
        let following = polygon.points.iter().cycle().skip(1);
        for (a, b) in polygon.points.iter().zip(following) {
            if (a.beta > beta) != (b.beta > beta) {
                let way = (beta - a.beta) / (b.beta - a.beta);
                crossings.push(a.alpha + way * (b.alpha - a.alpha));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings
}

/// Points with almost the largest β, or the largest that is small enough, each in the middle of the widest
/// interval of α that it leaves.
fn most_damping(area: &StableArea, quiet: f64) -> Vec<(f64, f64)> {
    let middle = |beta: f64| {
        let crossings = crossings(area, beta);
        let intervals = crossings.chunks_exact(2);
        let widest = intervals.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
        Some((0.5 * (widest[0] + widest[1]), beta))
    };
    let shares = SHARES.into_iter().map(|share| share * area.beta_max);
    let quiet_ones = SHARES.into_iter().map(|share| share * quiet);
    let first = [quiet].into_iter().chain(quiet_ones);
    let mut betas: Vec<f64> = first.chain(shares).collect();
    betas.retain(|beta| *beta <= quiet && *beta <= SHARES[0] * area.beta_max);
    betas.sort_by(|a, b| b.total_cmp(a));
    betas.into_iter().filter_map(middle).collect()
}
