//! All orders and dissipations, on all cores.

use super::report::{OrderBoundary, ZWidthReport};
use super::search::{Search, search_limit};
use super::specification::ZWidth;
use crate::document::failure::Failure;
use crate::question::asked_device::AskedDevice;
use crate::question::zwidth::trials::Trials;
use crate::run::device::Warn;
use crate::run::remote::device_name;
use fracdiff::Order;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

impl ZWidth {
    /// Runs the experiment; `progress` hears of each cell that is done, `stop` ends it with those, and `warn` hears what a
    /// user should know before the end.
    ///
    /// # Errors
    /// A parameter outside its range; on a device the first failure, if no point was found before it, or that no wall came to rest.
    pub fn run(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<ZWidthReport, Failure> {
        self.check()?;
        let remote = self.remote.as_ref();
        let trials = remote
            .map(|remote| Trials::new(remote, warn, stop))
            .transpose()?;
        let searches: Vec<Search> = self
            .orders
            .iter()
            .enumerate()
            .map(|(place, &order)| Search::new(self, order, place, trials.as_ref(), stop))
            .collect::<Result<_, _>>()?;
        let orders: Vec<OrderBoundary> = searches
            .par_iter()
            .with_min_len(self.at_once())
            .map(|search| self.boundary(search, progress))
            .collect();
        let runs = searches.iter().map(|search| search.runs()).sum();
        drop(searches);
        let found = orders.iter().any(|order| !order.boundary.is_empty());
        let interrupted = || Failure::Run(anyhow::anyhow!("interrupted"));
        let ended_early = match trials {
            Some(trials) => trials.ended(found, stop)?,
            None => None,
        };
        let ended_early = ended_early.or_else(|| stop.load(Ordering::Relaxed).then(interrupted));
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
            asked: AskedDevice::of(config),
            delta,
            criterion: plan.criterion,
            impact_m_per_s: plan.impact_m_per_s,
            push_n: plan.push_n,
            alpha_searched: search_limit(delta),
            runs,
            ended_early,
        })
    }

    /// Orders or dissipations that one core takes at least: all of them where there is a device, which tries one wall after another.
    fn at_once(&self) -> usize {
        self.remote.as_ref().map_or(1, |_| usize::MAX)
    }

    fn boundary(&self, search: &Search<'_>, progress: &(dyn Fn(u64) + Sync)) -> OrderBoundary {
        let extent = search.extent();
        let points = (0..self.points)
            .into_par_iter()
            .with_min_len(self.at_once());
        let boundary = points.filter_map(|point| {
            let extent = extent.as_ref()?;
            let beta = extent.largest_dissipation() * point as f64 / (self.points - 1) as f64;
            let found = search.cell(beta, extent, 1 + point as u64);
            progress(1);
            found.map(|cell| search.point(beta, cell))
        });
        OrderBoundary {
            order: search.order.get(),
            dissipation_unit: dissipation_unit(search.order),
            stiffness_max_unit: "N/m",
            boundary: boundary.collect(),
            outline: search.outline(),
            units: search.units,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::question::zwidth::dissertation_device;
    use crate::{Imperfections, TrialPlan};
    use fracdiff::{Scheme, Seconds};

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
        assert!(whole.ended_early.is_none());
        assert_eq!(whole.orders[0].boundary.len(), 9);
        let stop = AtomicBool::new(false);
        let first = |_| stop.store(true, Ordering::Relaxed);
        let cut = experiment.run(&first, &stop, &|_| {}).expect("runs");
        let why = cut.ended_early.expect("a reason");
        assert_eq!(
            (why.to_string().as_str(), why.exit_code()),
            ("interrupted", 1)
        );
        let kept = &cut.orders[0].boundary;
        assert!((1..9).contains(&kept.len()), "{kept:?}");
        assert!(
            kept.iter()
                .all(|point| whole.orders[0].boundary.contains(point))
        );
    }
}
