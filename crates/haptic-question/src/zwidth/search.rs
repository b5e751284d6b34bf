//! The search for the stiffest wall, of all orders and dissipations on all cores.

use crate::bench::{AskedDevice, crossings, largest_scales, last, units};
use crate::zwidth::campaign::{Campaign, Cell, Extent, Line, Open};
use crate::zwidth::rig::{Rig, WallThere};
use crate::zwidth::upward::{Settled, upward};
use crate::zwidth::{BoundaryPoint, OrderBoundary, Scales, ZWidth, ZWidthReport};
use fracdiff::{Differintegrator as _, Operator, Order};
use haptic_analysis::{LoopOperator, SampledLoop, SampledPlant, StabilityRegion, StableArea};
use haptic_document::{Failure, Named as _};
use haptic_judge::modelled_tissue::{loop_operator, operator};
use haptic_judge::position_controller::PositionController;
use haptic_judge::position_law::PositionLaw;
use haptic_judge::settling::{Criterion, TrialVerdict};
use haptic_judge::trial::{TrialPlan, force_limit, thrown, try_out, wall_at_start};
use haptic_loop::plant::{MassDamper, MassDamperConfig, run_wall};
use haptic_loop::units::{Newtons, Seconds};
use haptic_loop::{Controller, OwnPush, Pushing, SafetyChain};
use haptic_trial::Sensors;
use haptic_trial::device_table::{dynamics, encoder_step};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Bisections after the coarse search: 2e-4 of the value found, or better.
const BISECTIONS: u32 = 12;
/// Share by which the wall of a trial may be off from the boundary of the analysis, up or down.
pub(super) const AGREES_WITHIN: f64 = 0.05;
/// Fine steps down from the coarse ones: to 1e-4 of the most. The newest sample of a lag or an integral weighs little in its force, so that
/// the most of a controller may be far above what is stable: to 2e-9.
const FINE: i32 = 24;
const FINE_OF_CONTROLLERS: i32 = 70;
/// Rise of the force of a device that pushes by itself, unless a longer one is set on it.
const RISE_TIME: Seconds = Seconds(0.1);
/// Shares of an edge at which its wall is tapped once more.
const TOLD: [f64; 6] = [1.0, 0.99, 0.97, 0.9, 0.75, 0.5];
/// Friction holds a wall that rests so far beyond a stable one, or an edge further away than the second.
const HELD_BEYOND: f64 = 1.1;
const NEAR: f64 = 1.05;
/// Share of the push from which on the force of a step of the encoder shakes a wall.
const ENCODER_SHARE: f64 = 0.005;
/// Points on the boundary of a region.
const POINTS: usize = 400;
/// Pieces of an edge of an outline.
const PIECES: u32 = 16;
/// Memory for which an operator is judged, samples: longer than any run.
pub(super) const HORIZON: f64 = 20e6;

impl ZWidth {
    /// Runs the search, on a device at a port or on the simulated one; `progress` hears of each cell that is done, `stop` ends it with those.
    ///
    /// # Errors
    /// Parameters of which no trial can be made; a device that failed before anything was found; a campaign that cannot be kept.
    pub fn searched(
        &self,
        rig: Option<&dyn Rig>,
        open: Open<'_>,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<ZWidthReport, Failure> {
        if let Some(robot) = &self.robot {
            return self.searched_in_hands(robot, progress, stop);
        }
        let searches = (0..self.orders.len()).map(|index| Search::new(self, index, rig, stop));
        let mut searches = searches.collect::<Result<Vec<_>, _>>()?;
        // A search that is refused makes no file.
        let whose = rig.map_or("", Rig::whose);
        let opened = |path| open(path, &self.in_full(whose));
        let campaign = self.campaign.as_deref().map(opened).transpose()?;
        for search in &mut searches {
            search.campaign = campaign.as_ref();
        }
        let orders: Vec<OrderBoundary> = searches
            .par_iter()
            .with_min_len(self.at_once())
            .map(|search| self.boundary(search, progress))
            .collect();
        let runs = searches
            .iter()
            .map(|search| search.runs.load(Ordering::Relaxed))
            .sum();
        drop(searches);
        let found = orders.iter().any(|order| !order.boundary.is_empty());
        let rise_time_s = rig.and_then(|rig| rig.rise_time_s(RISE_TIME.0));
        let failed = rig.map(|rig| rig.ended(found, stop)).transpose()?;
        let stopped = || stop.load(Ordering::Relaxed).then(Failure::interrupted);
        let unkept = campaign.and_then(|campaign| campaign.failure().take());
        let ended_early = failed.flatten().or(unkept).or_else(stopped);
        let config = &self.device;
        let plan = self.plan();
        let delta = config.damping.0 * config.sample_time.0 / config.mass.0;
        let points = orders.iter().flat_map(|order| &order.boundary);
        Ok(ZWidthReport {
            disagreements: points
                .filter(|point| point.analysis_agrees == Some(false))
                .count(),
            tissue: self.piece().map(|piece| piece.material.name.clone()),
            controller: (self.controller()).map(|controller| controller.setup.law.to_string()),
            scales: (orders.first()).and_then(|order| order.boundary.first()?.scales),
            // A controller is no point among walls.
            orders: self.controller().map_or(orders, |_| Vec::new()),
            scheme: self.scheme.to_string(),
            device: (self.at_port.as_ref())
                .map_or_else(|| "sim".to_owned(), |at_port| at_port.name.clone()),
            calibration: (self.at_port.as_ref()).map(|at_port| at_port.calibration.clone()),
            asked: AskedDevice::of(config),
            hands: None,
            delta,
            criterion: plan.criterion,
            impact_m_per_s: plan.impact_m_per_s,
            push_n: plan.push_n,
            push_by: plan.push_by.name(),
            rise_time_s,
            alpha_searched: search_limit(delta),
            runs,
            ended_early,
        })
    }

    /// Orders or dissipations that one core takes at least: all of them where there is a device, which tries one wall after another.
    fn at_once(&self) -> usize {
        self.at_port.as_ref().map_or(1, |_| usize::MAX)
    }

    /// A wall for the device at a port that lacks only stiffness and dissipation.
    fn wall_there(
        &self,
        order: Order,
        horizon: f64,
        plan: &TrialPlan,
    ) -> Result<WallThere, Failure> {
        let (device, t) = (self.device, self.device.sample_time);
        Ok(WallThere {
            device,
            plan: *plan,
            contact: self.contact,
            order,
            operator: operator(self.model(), self.scheme, order, t, horizon)?,
            // Short beside every trial: its taps do not wait for it. The limit of the device is the tighter one.
            rise_time: plan.own_push_n().map(|_| RISE_TIME),
            stiffness_n_per_m: 0.0,
            dissipation_n_s_mu_per_m: 0.0,
            tap: None,
        })
    }

    /// The largest α of the simulated device with this β, of an order by its number.
    pub fn simulated(&self, index: usize, beta: f64, cell: u64, stop: &AtomicBool) -> Option<f64> {
        let search = Search::new(self, index, None, stop).ok()?;
        Some(search.cell(beta, None, cell)?.stable)
    }

    fn boundary(&self, search: &Search<'_>, progress: &(dyn Fn(u64) + Sync)) -> OrderBoundary {
        let extent = search.kept_extent();
        let points = (0..self.points)
            .into_par_iter()
            .with_min_len(self.at_once());
        let boundary = points.filter_map(|point| {
            let extent = extent.as_ref()?;
            let beta = extent.dissipation * point as f64 / (self.points - 1).max(1) as f64;
            let found = search.kept_cell(point, beta, extent);
            progress(1);
            found.map(|cell| search.point(beta, cell))
        });
        OrderBoundary {
            order: search.order.get(),
            dissipation_unit: dissipation_unit(search.order),
            stiffness_max_unit: "N/m",
            boundary: boundary.collect(),
            outline: search
                .theory
                .as_ref()
                .map_or_else(Vec::new, Theory::outline),
            units: search.units,
        }
    }
}

/// N/m at 0, N·s/m at 1, kg at 2, and what lies between.
pub(super) fn dissipation_unit(order: Order) -> &'static str {
    let mu = order.get();
    match order.split() {
        (0, _) if mu.abs() < f64::EPSILON => "N/m",
        (1, phi) if phi.abs() < f64::EPSILON => "N·s/m",
        (2, _) => "kg",
        _ => "N·s^μ/m",
    }
}

/// Limit of a search: beyond the largest α and β of any region that was computed. These are 4 without
/// damping and below 4(1 + δ) with it.
fn search_limit(delta: f64) -> f64 {
    f64::max(5.0, 4.0 * (1.0 + delta))
}

/// The coarse scale from `most` down: fifty even steps, then so many, ten a decade, then 0. A wall
/// far softer than the softest of the even steps is still found.
fn coarse(most: f64, fine: i32) -> impl Iterator<Item = f64> {
    let even = (1..=50)
        .rev()
        .map(move |step| most * f64::from(step) / 50.0);
    let fine = (1..=fine).map(move |step| most / 50.0 * libm::exp10(-f64::from(step) / 10.0));
    even.chain(fine).chain([0.0])
}

/// The largest value up to `most` that is stable; `None` if no value of the coarse scale is.
fn largest(most: f64, fine: i32, stable: impl Fn(f64) -> bool) -> Option<f64> {
    let mut above = most;
    let found = coarse(most, fine).find(|&value| {
        let found = stable(value);
        if !found {
            above = value;
        }
        found
    })?;
    Some(last(found, above, BISECTIONS, stable))
}

/// Part of a law beside its spring.
enum Tried<'a> {
    /// Operator that is multiplied by the B that is tried.
    Memory(Operator<f64>),
    Controller(&'a PositionController),
}

/// A wall of one order that lacks only its stiffness and dissipation.
struct Search<'a> {
    experiment: &'a ZWidth,
    plan: TrialPlan,
    order: Order,
    law: Tried<'a>,
    /// α and β of a law that only grows: with one, an α that is tried is a scale of it, and β is not used.
    growing: Option<[f64; 2]>,
    /// Force per displacement that stands, of a controller, N/m.
    standing_n_per_m: f64,
    /// The device as it is.
    device: MassDamper<1>,
    /// The device without friction, if it has some.
    smooth: Option<MassDamper<1>>,
    chain: SafetyChain<f64>,
    samples: u64,
    rate: f64,
    encoder_step_m: f64,
    theory: Option<Theory>,
    /// Largest α or β that is tried, and the number of fine steps down from it.
    most: f64,
    fine: i32,
    /// N/m of α = 1, and N·s^μ/m of β = 1.
    units: (f64, f64),
    /// Seed of this order's cells.
    seed: u64,
    /// The serial device, and a wall for it that lacks as much.
    remote: Option<(WallThere, &'a dyn Rig)>,
    /// Ranges and points found before, and the place for more.
    campaign: Option<&'a Campaign>,
    /// Number of the order in the question.
    index: usize,
    stop: &'a AtomicBool,
    runs: AtomicU64,
}

impl<'a> Search<'a> {
    fn new(
        experiment: &'a ZWidth,
        index: usize,
        rig: Option<&'a dyn Rig>,
        stop: &'a AtomicBool,
    ) -> Result<Self, Failure> {
        let (config, order) = (experiment.device, experiment.orders[index]);
        let t = config.sample_time;
        let mut plan = experiment.plan();
        let samples = plan.samples(t)?;
        let (scheme, horizon) = (experiment.scheme, haptic_trial::samples::horizon(samples));
        let mut encoder_step_m = encoder_step(experiment.sensors);
        if let Some(rig) = rig {
            let (step_m, most_n) = rig.encoder_and_force();
            encoder_step_m = step_m;
            plan.force_limit_n = plan.force_limit_n.min(most_n);
        }
        let device = thrown(config, &plan)?;
        // Sensors that cannot be made are refused before the first run.
        experiment.sensors.before(device.clone())?;
        let smooth = MassDamperConfig {
            friction: Newtons(0.0),
            ..config
        };
        let remote = rig.map(|rig| {
            let wall = experiment.wall_there(order, horizon, &plan)?;
            let tap = plan.tapped(&config, [1.0, 0.0], order, experiment.contact);
            let tapped = WallThere {
                tap,
                ..wall.clone()
            };
            rig.accepts(&tapped, samples)?;
            Ok::<_, Failure>((wall, rig))
        });
        let asked = config.friction.0 > 0.0 && plan.criterion == Criterion::Settling;
        let smooth = asked.then(|| thrown(smooth, &plan));
        Ok(Self {
            experiment,
            plan,
            order,
            law: match experiment.controller() {
                Some(controller) => Tried::Controller(controller),
                None => Tried::Memory(operator(experiment.model(), scheme, order, t, horizon)?),
            },
            growing: None,
            standing_n_per_m: match experiment.controller() {
                Some(controller) => controller.stiffness_n_per_m(plan.window_s)?,
                None => 0.0,
            },
            smooth: smooth.transpose()?,
            device,
            chain: force_limit(plan.force_limit_n, t)?,
            samples,
            rate: t.rate_to_the(order).map_err(Failure::input)?,
            encoder_step_m,
            // A wall that cannot be analysed can still be tried.
            theory: (experiment.analysed.as_ref())
                .and_then(|device| Theory::new(device, experiment, order)),
            most: search_limit(config.damping.0 * t.0 / config.mass.0),
            fine: match experiment.controller() {
                Some(_) => FINE_OF_CONTROLLERS,
                None => FINE,
            },
            units: units(&config, order),
            seed: experiment.sensors.seed.wrapping_add((index as u64) << 32),
            remote: remote.transpose()?,
            campaign: None,
            index,
            stop,
            runs: AtomicU64::new(0),
        }
        .on_growing())
    }

    /// Tries scales of a law that only grows, if there is one.
    fn on_growing(self) -> Self {
        let Some(growing) = &self.experiment.growing else {
            return self;
        };
        let (k, b) = growing.spring_and_damper();
        let gain = match &self.law {
            Tried::Memory(operator) => operator.direct_gain(),
            Tried::Controller(controller) => controller.operator.direct_gain().abs() / b,
        };
        Self {
            growing: Some([k / self.units.0, b / self.units.1]),
            // Of what it resists in a sample, so that laws that are equal are tried at the same scales: between two there may be a limit cycle.
            most: self.most * self.units.0 / (k + b * gain),
            rate: gain,
            ..self
        }
    }

    fn point(&self, beta: f64, cell: Cell) -> BoundaryPoint {
        let theory = self.theory.as_ref();
        let (alpha, beta) = self.wall(cell.stable, beta);
        let (stiffness, dissipation) = self.units;
        let scales = (theory.zip(self.growing))
            .and_then(|(theory, growing)| theory.largest_scales(growing, self.most));
        let analysed = match self.growing {
            Some(_) => scales.map(|(_, to)| to),
            None => theory.and_then(|theory| theory.largest_alpha(beta)),
        };
        let stiffness_at = |tried| self.wall(tried, beta).0 * stiffness;
        BoundaryPoint {
            dissipation: beta * dissipation,
            stiffness_max: alpha * stiffness,
            alpha,
            beta,
            analysis_stiffness_n_per_m: analysed.map(stiffness_at),
            analysis_agrees: theory
                .filter(|_| cell.stable < 0.999 * self.most)
                .and_then(|theory| theory.has_edge_within(alpha, beta, AGREES_WITHIN)),
            held_by_friction_up_to_n_per_m: cell.held.map(stiffness_at),
            simulated_without_friction_n_per_m: cell.without_friction.map(stiffness_at),
            in_hands: None,
            scales: self.growing.map(|_| Scales {
                largest_scale: cell.stable,
                analysis_scale: analysed,
                analysis_scale_from: scales.and_then(|(from, _)| from),
                held_by_friction_up_to_scale: cell.held,
            }),
        }
    }

    /// α and β of a wall, or of a scale of the law that grows.
    fn wall(&self, tried: f64, beta: f64) -> (f64, f64) {
        (self.growing).map_or((tried, beta), |[alpha, beta]| (tried * alpha, tried * beta))
    }

    /// The largest α that is stable with this β; `None` if none that is tried is, or the search has ended.
    fn cell(&self, beta: f64, settled: Option<&Settled>, cell: u64) -> Option<Cell> {
        if let Some(settled) = settled {
            return self.cell_there(beta, settled, cell);
        }
        // If no wall comes to rest, the scale and the noise of the extent: with them one does at the largest dissipation.
        let edge = |most, stable: &dyn Fn(f64, u64) -> bool| {
            largest(most, self.fine, |alpha| stable(alpha, cell))
                .or_else(|| largest(self.most, self.fine, |alpha| stable(alpha, 0)))
        };
        let as_it_is = edge(self.most, &|alpha, cell| self.rests(alpha, beta, cell))?;
        let stable = match &self.smooth {
            Some(_) => edge(as_it_is, &|alpha, cell| self.is_stable(alpha, beta, cell))?,
            None => as_it_is,
        };
        self.whole(Cell {
            stable,
            // Two bisections end where they end: closer than a thousandth is the same.
            held: Some(as_it_is).filter(|held| *held > 1.001 * stable),
            without_friction: None,
        })
    }

    /// The largest α of a real device with this β, and the one up to which friction may hold it.
    fn cell_there(&self, beta: f64, settled: &Settled, cell: u64) -> Option<Cell> {
        let rests = |alpha| self.rests(alpha, beta, cell);
        let settles = |alpha: &f64| self.settles(&self.device, *alpha, beta, cell);
        let edge = settled.largest(beta, self.most, |alpha| settles(&alpha));
        if !self.is_tapped() {
            return self.whole(Cell {
                stable: edge?,
                ..Cell::default()
            });
        }
        // Friction keeps still what the steps of an encoder would shake: a simulation knows at which share of the edge, here and where walls
        // are a little weaker.
        let quiet = |edge: f64| {
            let (alpha, damped) = self.wall(edge, beta);
            let step_n_per_m = alpha * self.units.0 + damped * self.units.1 * self.rate;
            if self.encoder_step_m * step_n_per_m < ENCODER_SHARE * self.plan.push_n {
                return edge;
            }
            let shares = [beta, beta / NEAR].into_iter().filter_map(|beta| {
                let at = |step_m| self.without_friction(beta, cell, step_m);
                at(0.0).map(|smooth| at(self.encoder_step_m).unwrap_or(0.0) / smooth)
            });
            shares.fold(1.0, f64::min) * edge
        };
        // The range may have begun with walls that only rest: the edge is tapped twice.
        let told = |edge| TOLD.map(|share| share * edge).into_iter().find(settles);
        let stable = edge.map(quiet).filter(|edge| *edge > 0.0).and_then(told);
        let held = match (stable, edge) {
            (Some(stable), Some(edge)) if NEAR * stable < edge => Some(edge),
            (Some(stable), _) => {
                let beyond = (HELD_BEYOND * stable).min(self.most);
                rests(beyond).then(|| upward(beyond, self.most, rests))
            }
            (None, _) => Some(settled.largest(beta, self.most, rests)?),
        };
        self.whole(Cell {
            stable: stable.unwrap_or(0.0),
            held,
            without_friction: held
                .and_then(|_| self.without_friction(beta, cell, self.encoder_step_m)),
        })
    }

    /// The largest α with this β of the device as its file describes it, simulated without friction.
    fn without_friction(&self, beta: f64, cell: u64, encoder_step_m: f64) -> Option<f64> {
        let asked = self.experiment;
        let file = ZWidth {
            device: MassDamperConfig {
                friction: Newtons(0.0),
                ..asked.analysed?
            },
            analysed: None,
            sensors: Sensors {
                encoder_resolution_m: encoder_step_m,
                ..Sensors::NONE
            },
            at_port: None,
            campaign: None,
            ..asked.clone()
        };
        file.simulated(self.index, beta, cell, self.stop)
    }

    /// The result, unless the search has ended on the way.
    fn whole<T>(&self, found: T) -> Option<T> {
        (!self.is_over()).then_some(found)
    }

    /// True if nothing more is tried: it was stopped, or its device failed.
    fn is_over(&self) -> bool {
        let failed = |(_, rig): &(_, &dyn Rig)| rig.has_failed();
        let unkept = |campaign: &&Campaign| campaign.failure().is_some();
        self.stop.load(Ordering::Relaxed)
            || self.remote.as_ref().is_some_and(failed)
            || self.campaign.as_ref().is_some_and(unkept)
    }

    /// [`extent`](Self::extent), once in a campaign.
    fn kept_extent(&self) -> Option<Extent> {
        if let Some(found) = (self.campaign).and_then(|kept| kept.extents.get(&self.index)) {
            return found.clone();
        }
        let found = self.extent();
        if let Some(campaign) = self.campaign.filter(|_| !self.is_over()) {
            campaign.keep(&Line::Extent(self.index, found.clone()));
        }
        found
    }

    /// [`cell`](Self::cell), once in a campaign.
    fn kept_cell(&self, point: usize, beta: f64, extent: &Extent) -> Option<Cell> {
        let place = (self.index, point);
        if let Some(found) = self.campaign.and_then(|kept| kept.cells.get(&place)) {
            return *found;
        }
        let found = self.cell(beta, extent.settled.as_ref(), 1 + point as u64);
        if let Some(campaign) = self.campaign.filter(|_| found.is_some() || !self.is_over()) {
            campaign.keep(&Line::Point(self.index, point, found));
        }
        found
    }

    /// The range to search; `None` if no wall of a real device comes to rest, or the search has ended.
    fn extent(&self) -> Option<Extent> {
        if self.remote.is_none() {
            return self.largest_dissipation().map(|dissipation| Extent {
                dissipation,
                settled: None,
            });
        }
        let settles = |alpha, beta| self.settles(&self.device, alpha, beta, 0);
        let rests = |alpha, beta| self.rests(alpha, beta, 0);
        // α = β·(T/τ)^μ: τ, the time constant of the approach, is an eighth of the time for it.
        let plan = &self.plan;
        let tau_s = (plan.duration_s - plan.window_s) / 8.0;
        let soft = (self.rate * libm::pow(tau_s, self.order.get())).recip();
        let look = |rests: &dyn Fn(f64, f64) -> bool| match self.growing {
            Some(_) => Settled::softest(self.most, |scale| rests(scale, 0.0)),
            None => Settled::look(self.most, |beta| beta * soft, rests),
        };
        // Walls that rest, if no tap is large beside friction.
        let mut settled = look(&settles);
        if settled.largest_dissipation().is_none() && self.is_tapped() {
            settled = look(&rests);
        }
        self.whole(Extent {
            dissipation: settled.largest_dissipation()?,
            settled: Some(settled),
        })
    }

    /// True if the motor that pushes taps the walls.
    fn is_tapped(&self) -> bool {
        self.plan.tapping_push_n().is_some()
    }

    /// The largest β that is stable with any α, or 0; `None` if the search was stopped. α = 0 is excluded:
    /// a pure damper of order 1 and more yields for ever; and with A₃ at μ > 1 a wall needs stiffness to be stable at all.
    fn largest_dissipation(&self) -> Option<f64> {
        if self.growing.is_some() {
            return Some(0.0);
        }
        let any_stiffness = |beta| {
            let mut walls = coarse(self.most, self.fine).filter(|alpha| *alpha > 0.0);
            walls.any(|alpha| self.is_stable(alpha, beta, 0))
        };
        self.whole(largest(self.most, self.fine, any_stiffness).unwrap_or(0.0))
    }

    /// True if a wall settles, also without friction.
    fn is_stable(&self, alpha: f64, beta: f64, cell: u64) -> bool {
        let smooth = self.smooth.as_ref();
        smooth.is_none_or(|device| self.settles(device, alpha, beta, cell))
            && self.rests(alpha, beta, cell)
    }

    /// True if a wall settles.
    fn settles(&self, device: &MassDamper<1>, alpha: f64, beta: f64, cell: u64) -> bool {
        self.tried(device, alpha, beta, cell) == TrialVerdict::Stable
    }

    /// True if a wall settles, or friction may hold it.
    fn rests(&self, alpha: f64, beta: f64, cell: u64) -> bool {
        self.tried(&self.device, alpha, beta, cell) <= TrialVerdict::HeldByFriction
    }

    /// One run. Whatever goes wrong on the way is not stable.
    fn tried(&self, device: &MassDamper<1>, alpha: f64, beta: f64, cell: u64) -> TrialVerdict {
        const WRONG: TrialVerdict = TrialVerdict::Unfinished;
        if self.is_over() {
            return WRONG;
        }
        self.runs.fetch_add(1, Ordering::Relaxed);
        let (alpha, beta) = self.wall(alpha, beta);
        let (stiffness, dissipation) = (alpha * self.units.0, beta * self.units.1);
        let t = self.experiment.device.sample_time.0;
        let hand = self.experiment.device.stiffness.0;
        let (plan, encoder_step_m) = (&self.plan, self.encoder_step_m);
        let contact = self.experiment.contact;
        let known = self.experiment.analysed.unwrap_or(self.experiment.device);
        // A simulated device is tried without friction instead.
        let wall = [stiffness, dissipation];
        let tapped =
            (self.remote.as_ref()).and_then(|_| plan.tapped(&known, wall, self.order, contact));
        let judge = match &self.law {
            Tried::Controller(controller) => {
                let scale = [dissipation / t, self.standing_n_per_m];
                PositionLaw::judge(controller, scale, plan, hand, encoder_step_m)
            }
            Tried::Memory(_) => {
                let step = stiffness + dissipation * self.rate;
                let judge = plan.judge(stiffness + hand, step, encoder_step_m, t);
                Some(judge.tapped(tapped.as_ref(), encoder_step_m, step))
            }
        };
        let Some(judge) = judge else {
            return WRONG;
        };
        if let Some((wall, rig)) = &self.remote {
            let wall = WallThere {
                stiffness_n_per_m: stiffness,
                dissipation_n_s_mu_per_m: dissipation,
                tap: tapped,
                ..wall.clone()
            };
            let settling = rig.judged(&wall, self.samples, judge);
            return settling.map_or(WRONG, |settling| settling.verdict);
        }
        let sensors = Sensors {
            seed: self.seed.wrapping_add(cell),
            ..self.experiment.sensors
        };
        let tried = |impact_m_per_s: f64| {
            let (mut device, mut judge) = (device.clone(), judge.clone());
            device.set_state([0.0].into(), [impact_m_per_s].into());
            let Ok(mut device) = sensors.before(device) else {
                return WRONG;
            };
            let (push_n, samples) = (self.plan.own_push_n(), self.samples);
            let whole = match &self.law {
                Tried::Memory(operator) => {
                    let wall = wall_at_start(stiffness, dissipation, operator.clone(), contact);
                    let Ok(wall) = wall else {
                        return WRONG;
                    };
                    let wall = Pushing::new(wall, true);
                    let mut wall = Controller::new(OwnPush::new(wall, push_n), self.chain);
                    let see = &mut |time_s, x, f| judge.see(time_s, x, f);
                    run_wall(&mut wall, &mut device, samples, see)
                }
                Tried::Controller(controller) => {
                    let Ok(law) = PositionLaw::new(controller, dissipation / t) else {
                        return WRONG;
                    };
                    let mut law = Controller::new(OwnPush::new(law, push_n), self.chain);
                    try_out(&mut law, &mut device, samples, &mut judge)
                }
            };
            judge.settling(whole, None).verdict
        };
        let first = core::iter::once(self.plan.impact_m_per_s);
        let mut worst = TrialVerdict::Stable;
        for impact_m_per_s in first.chain(self.plan.hits(contact)) {
            worst = worst.max(tried(impact_m_per_s));
            if worst > TrialVerdict::HeldByFriction {
                break;
            }
        }
        worst
    }
}

/// The stability region of one order on the device, without friction, encoder and force limit.
struct Theory {
    operator: LoopOperator,
    plant: SampledPlant,
    area: Option<StableArea>,
}

impl Theory {
    fn new(device: &MassDamperConfig, asked: &ZWidth, order: Order) -> Option<Self> {
        let (model, t) = (asked.model(), device.sample_time);
        let plant = dynamics(device).plant(t.0).ok()?;
        if let Some(controller) = asked.controller() {
            return Some(Self {
                area: None,
                operator: controller.operator.clone(),
                plant,
            });
        }
        let operator = loop_operator(model, asked.scheme, order, t, HORIZON).ok()?;
        let region = StabilityRegion::new(plant, &operator, 0, POINTS).ok()?;
        Some(Self {
            area: region.bounded().cloned(),
            operator,
            plant,
        })
    }

    /// The polygons as (β, α) one after the other, closed, with a gap between them.
    fn outline(&self) -> Vec<(f64, f64)> {
        let mut outline = Vec::new();
        for polygon in self.area.iter().flat_map(|area| &area.polygons) {
            if !outline.is_empty() {
                outline.push((f64::NAN, f64::NAN));
            }
            for (a, b) in polygon.edges() {
                // Straight edges in pieces, so that they can be bent: on a logarithmic axis.
                outline.extend((0..PIECES).map(|piece| {
                    let way = f64::from(piece) / f64::from(PIECES);
                    (
                        a.beta + way * (b.beta - a.beta),
                        a.alpha + way * (b.alpha - a.alpha),
                    )
                }));
            }
            outline.extend(polygon.points.first().map(|p| (p.beta, p.alpha)));
        }
        outline
    }

    /// The largest stable α with this β.
    fn largest_alpha(&self, beta: f64) -> Option<f64> {
        crossings(self.area.as_ref()?, beta).last().copied()
    }

    /// The [`largest_scales`] of a law that grows, of α and β, if their edge is below the end of a search.
    fn largest_scales(&self, [alpha, beta]: [f64; 2], most: f64) -> Option<(Option<f64>, f64)> {
        let closed = SampledLoop::with_plant(self.plant, alpha, beta, &self.operator).ok()?;
        largest_scales(&closed.beside_rest(), most).filter(|(_, edge)| *edge < most)
    }

    /// True if the edge is within a share of this wall: with its K, or K and B together, made weaker by the
    /// share it is stable, and made stronger unstable. Both ways, because an edge may run along one of them.
    /// `None` if the loop cannot be analysed.
    fn has_edge_within(&self, alpha: f64, beta: f64, share: f64) -> Option<bool> {
        let stable = |alpha: f64, beta: f64| {
            let closed = SampledLoop::with_plant(self.plant, alpha, beta, &self.operator).ok()?;
            Some(closed.beside_rest().is_stable())
        };
        let (weaker, stronger) = (1.0 - share, 1.0 + share);
        let along_both =
            stable(weaker * alpha, weaker * beta)? && !stable(stronger * alpha, stronger * beta)?;
        Some(along_both || (stable(weaker * alpha, beta)? && !stable(stronger * alpha, beta)?))
    }
}

#[cfg(test)]
mod tests {
    use crate::bench::BENCH;
    use crate::one_table::read;
    use crate::zwidth::ZWIDTH;
    use crate::zwidth::search::*;
    use fracdiff::{Scheme, Seconds};
    use haptic_judge::preflight::WallContact;
    use haptic_judge::trial::TrialPlan;
    use std::path::Path;
    use std::sync::Arc;
    use testkit::device::dissertation;

    fn no_file(path: &Path, _: &str) -> Result<Campaign, Failure> {
        panic!("a campaign at {}", path.display());
    }

    #[test]
    fn an_interrupted_search_keeps_the_points_that_were_done() {
        let experiment = ZWidth {
            device: dissertation(Seconds(2e-3)),
            robot: None,
            analysed: None,
            sensors: Sensors::NONE,
            contact: WallContact::Linear,
            scheme: Scheme::Muir { degree: 3 },
            growing: None,
            orders: vec![Order::new(1.0).expect("in range")],
            points: 5,
            plan: TrialPlan {
                duration_s: 2.0,
                ..TrialPlan::DEFAULT
            },
            at_port: None,
            campaign: None,
        };
        let never = Arc::<AtomicBool>::default();
        let whole = experiment
            .searched(None, &no_file, &|_| {}, &never)
            .expect("runs");
        assert!(whole.ended_early.is_none());
        assert_eq!(whole.orders[0].boundary.len(), 5);
        let stop = Arc::<AtomicBool>::default();
        let first = |_| stop.store(true, Ordering::Relaxed);
        let cut = experiment
            .searched(None, &no_file, &first, &stop)
            .expect("runs");
        let why = cut.ended_early.expect("a reason");
        assert!(matches!(why, Failure::Run(_)), "{why}");
        assert_eq!(why.to_string(), "interrupted");
        let kept = &cut.orders[0].boundary;
        assert!((1..5).contains(&kept.len()), "{kept:?}");
        assert!(
            kept.iter()
                .all(|point| whole.orders[0].boundary.contains(point))
        );
    }

    /// Largest stable K, N/m, at the second of two dissipations: 40 % of the largest.
    fn largest_stable(keys: &str) -> Vec<f64> {
        let text = format!("[zwidth]\nsample_time_s = 2e-3\norders = [1.0]\npoints = 2\n{keys}");
        let tables = [("Z-width", ZWIDTH), ("bench", BENCH)];
        let zwidth = read(&text, ("zwidth", &tables), |table| ZWidth::of(table, None));
        let report = zwidth.searched(None, &no_file, &|_| {}, &AtomicBool::default());
        let report = report.expect("answers");
        let points = report.orders[0].boundary.iter();
        points.map(|point| point.stiffness_max).collect()
    }

    #[test]
    fn the_dissertations_rule_looks_at_the_position_alone_and_against_its_threshold() {
        // Friction that holds the device counts as rest by this rule, which tries no device without it.
        let device = "friction_n = 0.05\nencoder_resolution_m = 1e-6\nduration_s = 1.0\n";
        let usual = largest_stable(device);
        let keys_with = |threshold: &str| {
            largest_stable(&format!(
                "criterion = \"dissertation\"\n{threshold}{device}"
            ))
        };
        let (strict, his, lax) = (
            keys_with("threshold_m = 1e-6\n"),
            keys_with(""),
            keys_with("threshold_m = 1e-3\n"),
        );
        assert!(usual[0] < his[0], "{usual:?} and {his:?}");
        assert!(
            strict[0] < his[0] && his[0] <= lax[0],
            "{strict:?} {his:?} {lax:?}"
        );
    }
}
