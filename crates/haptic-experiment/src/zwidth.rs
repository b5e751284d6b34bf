//! Z-width: how stiff a wall can be rendered, by trying (after the dissertation's section 4.4).
//!
//! The device hits a wall at its start position and is pushed into it; the rule by which it comes to rest is
//! that of [`settling`](super::settling). For each dissipation B the largest stable stiffness K is bracketed
//! from above on a coarse scale and then bisected. Beside it stands what the analysis says.
//! Cells are independent and run on all cores; each has a seed of its own, made from the
//! seed of the experiment and the cell's place, so the result does not depend on the number of cores.
//! - *Friction* can hold a wall that would shake. So a device with friction is tried with and without: stable is
//!   what settles both ways, and how far friction alone holds it stands beside.
//! - *Cost*: about 60 runs of a quarter of a millisecond a cell, twice that with friction.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

mod search;
mod theory;

use super::pushed::TrialPlan;
use super::remote::{RemoteDevice, device_name};
use super::sensed::Sensors;
use super::settling::CriterionName;
use super::trials::Trials;
use crate::device::Warn;
use crate::failure::Failure;
use crate::parameters;
use fracdiff::{Order, Scheme, Seconds};
use haptic_loop::plant::MassDamperConfig;
use rayon::prelude::*;
use search::{Search, search_limit};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// A Z-width experiment.
#[derive(Clone, Debug)]
pub struct ZWidth {
    /// The device, with whatever makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// A wall that pushes but never pulls, instead of the linear one that the theory assumes.
    pub one_sided: bool,
    /// Operator of the wall.
    pub scheme: Scheme,
    /// Orders to try.
    pub orders: Vec<Order>,
    /// Dissipations to try for each order, from 0 to the largest stable one.
    pub points: usize,
    /// How each wall is tried and judged; on a serial device the force limit is at most what that can do.
    pub plan: TrialPlan,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
}

/// The result. The keys are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct ZWidthReport {
    /// One entry an order.
    pub orders: Vec<OrderBoundary>,
    /// Operator.
    pub scheme: String,
    /// Device.
    pub device: String,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// δ = bT/m of the device.
    pub delta: f64,
    /// By which rule walls were judged.
    pub criterion: CriterionName,
    /// Speed at which the device hit them, m/s.
    pub impact_m_per_s: f64,
    /// Constant push, N.
    pub push_n: f64,
    /// Largest α that was looked at: a point this high is a bound of the search, not of the device.
    pub alpha_searched: f64,
    /// Runs made.
    pub runs: u64,
    /// Points where trial and analysis disagree by more than 5 % of the wall.
    pub disagreements: usize,
    /// Why the search ended early; null if it did not. The points that are there are whole.
    pub ended_early: Option<&'static str>,
}

/// The boundary of one order.
#[derive(Clone, Debug, Serialize)]
pub struct OrderBoundary {
    /// μ.
    pub order: f64,
    /// Unit of the dissipation.
    pub dissipation_unit: &'static str,
    /// The largest stable stiffness for each dissipation; dissipations without one are left out.
    pub boundary: Vec<BoundaryPoint>,
    /// Outline of the stable region by the analysis, as (β, α); empty if it has none.
    #[serde(skip)]
    pub outline: Vec<(f64, f64)>,
    /// N/m of α = 1 and N·s^μ/m of β = 1.
    #[serde(skip)]
    pub units: (f64, f64),
}

/// One point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundaryPoint {
    /// B, N·s^μ/m.
    pub dissipation: f64,
    /// Largest stable K, N/m.
    pub stiffness_max: f64,
    /// K·T²/m.
    pub alpha: f64,
    /// B·T^(2−μ)/m.
    pub beta: f64,
    /// The largest stable K for this B by the analysis, N/m; null if it knows none.
    pub analysis_stiffness_n_per_m: Option<f64>,
    /// Whether the analysis calls this wall (its K, or K and B together) stable made 5 % weaker and unstable
    /// made 5 % stronger; null if the search ended before, or the analysis does not know such a device.
    pub analysis_agrees: Option<bool>,
    /// The K up to which friction alone holds the device still, N/m; null without friction, and if it holds
    /// nothing beyond `stiffness_max`.
    pub held_by_friction_up_to_n_per_m: Option<f64>,
}

impl ZWidthReport {
    /// Whether there is a point to draw.
    #[must_use]
    pub fn has_points(&self) -> bool {
        self.orders.iter().any(|order| !order.boundary.is_empty())
    }
}

impl ZWidth {
    /// Runs the experiment; `progress` hears of each cell that is done, `stop` ends it with those, and `warn` hears what a
    /// user should know before the end.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<ZWidthReport, Failure> {
        self.check()?;
        let remote = self.remote.as_ref();
        let trials = remote.map(|remote| Trials::new(remote, warn)).transpose()?;
        let searches: Vec<Search> = self
            .orders
            .iter()
            .enumerate()
            .map(|(place, &order)| Search::new(self, order, place, trials.as_ref(), stop))
            .collect::<Result<_, _>>()?;
        let orders: Vec<OrderBoundary> = searches
            .par_iter()
            .map(|search| self.boundary(search, progress))
            .collect();
        let runs = searches.iter().map(|search| search.runs()).sum();
        drop(searches);
        if let Some(failure) = trials.and_then(Trials::failure) {
            return Err(failure);
        }
        let config = &self.device;
        let plan = self.plan();
        let delta = config.damping.0 * config.sample_time.0 / config.mass.0;
        let points = orders.iter().flat_map(|order| &order.boundary);
        Ok(ZWidthReport {
            disagreements: points
                .filter(|point| point.analysis_agrees == Some(false))
                .count(),
            orders,
            scheme: self.scheme.to_string(),
            device: device_name(self.remote.as_ref()),
            sample_time_s: config.sample_time.0,
            delta,
            criterion: plan.criterion.name(),
            impact_m_per_s: plan.impact_m_per_s,
            push_n: plan.push_n,
            alpha_searched: search_limit(delta),
            runs,
            ended_early: stop.load(Ordering::Relaxed).then_some("interrupted"),
        })
    }

    fn boundary(&self, search: &Search<'_>, progress: &(dyn Fn(u64) + Sync)) -> OrderBoundary {
        let beta_most = search.largest_dissipation();
        let boundary = (0..self.points).into_par_iter().filter_map(|point| {
            let beta = beta_most? * point as f64 / (self.points - 1) as f64;
            let found = search.cell(beta, 1 + point as u64);
            progress(1);
            found.map(|cell| search.point(beta, cell))
        });
        OrderBoundary {
            order: search.order.get(),
            dissipation_unit: dissipation_unit(search.order),
            boundary: boundary.collect(),
            outline: search.outline(),
            units: search.units,
        }
    }

    /// As it is really tried: a serial device cannot be thrown.
    fn plan(&self) -> TrialPlan {
        match self.remote {
            Some(_) => self.plan.from_rest(),
            None => self.plan,
        }
    }

    /// Cells of the experiment, for a progress bar.
    #[must_use]
    pub fn cells(&self) -> u64 {
        (self.orders.len() * self.points) as u64
    }

    fn check(&self) -> Result<(), Failure> {
        if !(2..=1000).contains(&self.points) {
            return Err(Failure::bad_input(format_args!(
                "number of points {} is not in [2, 1000]: give as many dissipations an order",
                self.points
            )));
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(
                "no order was given: give one or more in [0, 2], as in 0,0.5,1",
            ));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return Err(Failure::bad_input(format_args!(
                "order {order} is not in [0, 2]: a wall has no integral; leave it out"
            )));
        }
        self.plan().samples(self.device.sample_time).map(|_| ())
    }
}

/// N/m at 0, N·s/m at 1, kg at 2, and what lies between.
fn dissipation_unit(order: Order) -> &'static str {
    let mu = order.get();
    match order.split() {
        (0, _) if mu.abs() < f64::EPSILON => "N/m",
        (1, phi) if phi.abs() < f64::EPSILON => "N·s/m",
        (2, _) => "kg",
        _ => "N·s^μ/m",
    }
}

/// The device of the dissertation's section 4.4: 65 g, 3.5 N·s/m, sampled at 2 ms, ideal.
#[must_use]
pub fn dissertation_device(sample_time: Seconds) -> MassDamperConfig {
    use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
    let mass = Kilograms(parameters::MASS.default_number());
    let damping = NewtonSecondsPerMetre(parameters::DAMPING.default_number());
    MassDamperConfig::ideal(mass, damping, sample_time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Imperfections;

    #[test]
    fn an_interrupted_search_keeps_the_points_that_were_done() {
        let experiment = ZWidth {
            device: dissertation_device(Seconds(2e-3)),
            sensors: Imperfections::NONE.sensors,
            one_sided: false,
            scheme: Scheme::Muir { degree: 3 },
            orders: vec![Order::new(1.0).expect("in range")],
            points: 9,
            plan: TrialPlan::DEFAULT,
            remote: None,
        };
        let never = AtomicBool::new(false);
        let whole = experiment.run(&|_| {}, &never, &|_| {}).expect("runs");
        assert_eq!(
            (whole.ended_early, whole.orders[0].boundary.len()),
            (None, 9)
        );
        let stop = AtomicBool::new(false);
        let first = |_| stop.store(true, Ordering::Relaxed);
        let cut = experiment.run(&first, &stop, &|_| {}).expect("runs");
        assert_eq!(cut.ended_early, Some("interrupted"));
        let kept = &cut.orders[0].boundary;
        assert!((1..9).contains(&kept.len()), "{kept:?}");
        assert!(
            kept.iter()
                .all(|point| whole.orders[0].boundary.contains(point))
        );
    }
}
