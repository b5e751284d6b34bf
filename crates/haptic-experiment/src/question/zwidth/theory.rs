//! Verdict of the analysis on the walls that are tried.

use super::specification::ZWidth;
use crate::experiment::trial::dynamics;
use fracdiff::Order;
use haptic_analysis::{AnalysisError, LoopOperator, SampledLoop, SampledPlant, StabilityRegion};

/// Points on the boundary of a region.
const POINTS: usize = 400;
/// Pieces of an edge of an outline.
const PIECES: u32 = 16;
/// Memory for which an operator is judged, samples: longer than any run.
const HORIZON: f64 = 20e6;

/// The stability region of one order on the device, without friction, encoder and force limit.
#[derive(Debug)]
pub(super) struct Theory {
    operator: LoopOperator,
    plant: SampledPlant,
    /// Polygons of (β, α).
    polygons: Vec<Vec<(f64, f64)>>,
}

impl Theory {
    /// `None` for a device that the analysis does not know: a serial one, or numbers that it does not take.
    pub(super) fn new(experiment: &ZWidth, order: Order) -> Option<Self> {
        if experiment.remote.is_some() {
            return None;
        }
        // A wall that cannot be analysed can still be tried.
        Self::of(experiment, order).ok()
    }

    fn of(experiment: &ZWidth, order: Order) -> Result<Self, AnalysisError> {
        let device = &experiment.device;
        let operator = LoopOperator::new(experiment.scheme, order, device.sample_time, HORIZON)?;
        let plant = dynamics(device).plant(device.sample_time.0)?;
        let region = StabilityRegion::new(plant, &operator, 0, POINTS)?;
        let polygons = region.bounded().map_or_else(Vec::new, |area| {
            let points = |points: &[haptic_analysis::BoundaryPoint]| {
                points.iter().map(|p| (p.beta, p.alpha)).collect()
            };
            area.polygons.iter().map(|p| points(&p.points)).collect()
        });
        Ok(Self {
            operator,
            plant,
            polygons,
        })
    }

    /// The polygons one after the other, closed, with a gap between them.
    pub(super) fn outline(&self) -> Vec<(f64, f64)> {
        let mut outline = Vec::new();
        for polygon in &self.polygons {
            if !outline.is_empty() {
                outline.push((f64::NAN, f64::NAN));
            }
            let following = polygon.iter().cycle().skip(1);
            for (a, b) in polygon.iter().zip(following) {
                // Straight edges in pieces, so that they can be bent: on a logarithmic axis.
                outline.extend((0..PIECES).map(|piece| {
                    let way = f64::from(piece) / f64::from(PIECES);
                    (a.0 + way * (b.0 - a.0), a.1 + way * (b.1 - a.1))
                }));
            }
            outline.extend(polygon.first());
        }
        outline
    }

    /// The largest stable α with this β.
    pub(super) fn largest_alpha(&self, beta: f64) -> Option<f64> {
        let mut largest: Option<f64> = None;
        for polygon in &self.polygons {
            let following = polygon.iter().cycle().skip(1);
            for (a, b) in polygon.iter().zip(following) {
                if (a.0 > beta) != (b.0 > beta) {
                    let alpha = a.1 + (beta - a.0) / (b.0 - a.0) * (b.1 - a.1);
                    largest = Some(largest.map_or(alpha, |most| most.max(alpha)));
                }
            }
        }
        largest
    }

    /// True if the edge is within a share of this wall: with its K, or K and B together, made weaker by the
    /// share it is stable, and made stronger unstable. Both ways, because an edge may run along one of them.
    /// `None` if that cannot be told.
    pub(super) fn has_edge_within(&self, alpha: f64, beta: f64, share: f64) -> Option<bool> {
        let stable = |alpha: f64, beta: f64| {
            let closed = SampledLoop::with_plant(self.plant, alpha, beta, &self.operator).ok()?;
            Some(closed.is_stable())
        };
        let (weaker, stronger) = (1.0 - share, 1.0 + share);
        let along_both =
            stable(weaker * alpha, weaker * beta)? && !stable(stronger * alpha, stronger * beta)?;
        Some(along_both || (stable(weaker * alpha, beta)? && !stable(stronger * alpha, beta)?))
    }
}
