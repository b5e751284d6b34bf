//! Z-width: how stiff a wall can be rendered, by trying (the dissertation's section 4.4).
//!
//! The device is pushed into a wall at its start position with a constant force. The interaction is
//! unstable if the position still moves at the end:
//!
//! ```text
//! standard deviation of x over the last window > threshold        (0.1 mm over the last 0.4 s of 5 s)
//! ```
//! For each dissipation B the largest stable stiffness K is bracketed from above on a coarse scale and
//! then bisected. Cells are independent and run on all cores; each has a seed of its own, made from the
//! seed of the experiment and the cell's place, so the result does not depend on the number of cores.
//! *Cost*: about 60 runs of a quarter of a millisecond a cell.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

use super::pushed::{GONE_M, VirtualWall, force_alone, force_limit, pushed, wall_at_start};
use super::remote::{Kept, RemoteDevice, RemoteLaw, device_name, portable, push};
use super::sensed::{Sensed, Sensors};
use super::trials::Trials;
use crate::failure::Failure;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{OperatorShape, Simulation};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::{Controller, SafetyChain};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};

/// A Z-width experiment.
#[derive(Clone, Debug)]
pub struct ZWidth {
    /// The device, with whatever makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// A wall that pushes but never pulls, instead of the linear one that the theory assumes. An
    /// unstable one then bounces, perhaps by less than the threshold.
    pub one_sided: bool,
    /// Operator of the wall.
    pub scheme: Scheme,
    /// Orders to try.
    pub orders: Vec<Order>,
    /// Dissipations to try for each order, from 0 to the largest stable one.
    pub points: usize,
    /// Push, N.
    pub push_n: f64,
    /// Length of a run, s.
    pub duration_s: f64,
    /// Window at the end in which the position is judged, s.
    pub window_s: f64,
    /// Largest standard deviation of a stable position, m.
    pub threshold_m: f64,
    /// Force limit of the safety chain, N; on a serial device at most what that can do.
    pub force_limit_n: f64,
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
    /// Largest α that was looked at: a point this high is a bound of the search, not of the device.
    pub alpha_searched: f64,
    /// Runs made.
    pub runs: u64,
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
}

/// Bisections after the coarse search: 2e-4 of the value found, or better.
const BISECTIONS: u32 = 12;

impl ZWidth {
    /// Runs the experiment; `progress` hears of each cell that is done.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<ZWidthReport, Failure> {
        self.check()?;
        let trials = self.remote.as_ref().map(Trials::new).transpose()?;
        let walls: Vec<Wall> = self
            .orders
            .iter()
            .enumerate()
            .map(|(place, &order)| Wall::new(self, order, place, trials.as_ref()))
            .collect::<Result<_, _>>()?;
        let orders: Vec<OrderBoundary> = walls
            .par_iter()
            .map(|wall| {
                let beta_most = wall.largest_dissipation();
                let boundary = (0..self.points).into_par_iter().filter_map(|point| {
                    let beta = beta_most * point as f64 / (self.points - 1) as f64;
                    let alpha = wall.largest_stiffness(beta, 1 + point as u64);
                    progress(1);
                    alpha.map(|alpha| wall.point(alpha, beta))
                });
                OrderBoundary {
                    order: wall.order.get(),
                    dissipation_unit: dissipation_unit(wall.order),
                    boundary: boundary.collect(),
                }
            })
            .collect();
        let runs = walls.iter().map(|wall| wall.runs.load(Ordering::Relaxed));
        let runs = runs.sum();
        drop(walls);
        if let Some(failure) = trials.and_then(Trials::failure) {
            return Err(failure);
        }
        let config = &self.device;
        Ok(ZWidthReport {
            orders,
            scheme: self.scheme.to_string(),
            device: device_name(self.remote.as_ref()),
            sample_time_s: config.sample_time.0,
            delta: config.damping.0 * config.sample_time.0 / config.mass.0,
            alpha_searched: search_limit(config.damping.0 * config.sample_time.0 / config.mass.0),
            runs,
        })
    }

    /// Cells of the experiment, for a progress bar.
    #[must_use]
    pub fn cells(&self) -> u64 {
        (self.orders.len() * self.points) as u64
    }

    fn check(&self) -> Result<(), Failure> {
        let t = self.device.sample_time.0;
        let bad = |what: &str, value: f64, range: &str, advice: &str| {
            Err(Failure::bad_input(format_args!(
                "{what} {value} is not {range}: {advice}"
            )))
        };
        if !(2..=1000).contains(&self.points) {
            let points = self.points as f64;
            return bad("number of points", points, "in [2, 1000]", "give --points");
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(
                "no order was given: give --orders 0,0.5,1",
            ));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return bad(
                "order",
                order.get(),
                "in [0, 2]",
                "a wall has no integral; change --orders",
            );
        }
        if !(self.push_n > 0.0 && self.push_n <= 1e3) {
            return bad(
                "push",
                self.push_n,
                "in (0, 1000] N",
                "give --push, as in 1N",
            );
        }
        if !(self.window_s >= 10.0 * t && self.window_s <= self.duration_s) {
            let range = format!("in [{}, {}] s", 10.0 * t, self.duration_s);
            return bad("window", self.window_s, &range, "give --window, as in 0.4s");
        }
        if self.duration_s / t > 1e7 {
            return bad(
                "duration",
                self.duration_s,
                "at most 1e7 samples",
                "give --duration",
            );
        }
        if !(self.threshold_m > 0.0 && self.threshold_m.is_finite()) {
            return bad(
                "threshold",
                self.threshold_m,
                "above 0 m",
                "give --threshold, as in 0.1mm",
            );
        }
        Ok(())
    }
}

/// How far a search goes: beyond the largest α and β of any region that was computed, which are 4 without
/// damping and below 4(1 + δ) with it.
fn search_limit(delta: f64) -> f64 {
    f64::max(5.0, 4.0 * (1.0 + delta))
}

/// The coarse scale from `most` down: fifty even steps, then ten a decade down to 1e-4, then 0. A wall
/// far softer than the softest of the even steps is still found.
fn coarse(most: f64) -> impl Iterator<Item = f64> {
    let even = (1..=50)
        .rev()
        .map(move |step| most * f64::from(step) / 50.0);
    let fine = (1..=24).map(move |step| most / 50.0 * 10f64.powf(-f64::from(step) / 10.0));
    even.chain(fine).chain([0.0])
}

/// The largest value up to `most` that is stable; `None` if no value of the coarse scale is.
fn largest(most: f64, stable: impl Fn(f64) -> bool) -> Option<f64> {
    let mut above = most;
    let found = coarse(most).find(|&value| {
        let found = stable(value);
        if !found {
            above = value;
        }
        found
    })?;
    let (mut low, mut high) = (found, above);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if stable(middle) { &mut low } else { &mut high }) = middle;
    }
    Some(low)
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

/// A wall of one order that lacks only its stiffness and dissipation.
struct Wall<'a> {
    experiment: &'a ZWidth,
    order: Order,
    operator: Operator<f64>,
    device: MassDamper<1>,
    chain: SafetyChain<f64>,
    /// Largest α or β that is looked at.
    most: f64,
    /// K of α = 1, N/m, and B of β = 1.
    stiffness_unit: f64,
    dissipation_factor: f64,
    /// Seed of this order's cells.
    seed: u64,
    /// The operator for the serial device, and the device.
    remote: Option<((OperatorShape, Vec<f32>), &'a Trials)>,
    /// Runs made.
    runs: AtomicU64,
}

impl<'a> Wall<'a> {
    fn new(
        experiment: &'a ZWidth,
        order: Order,
        place: usize,
        trials: Option<&'a Trials>,
    ) -> Result<Self, Failure> {
        let config = experiment.device;
        let t = config.sample_time;
        let samples = experiment.duration_s / t.0;
        let operator = experiment
            .scheme
            .build(order, t, 1.05 * samples)
            .map_err(Failure::input)?;
        let remote = match trials {
            Some(trials) => {
                let built = experiment.scheme.build(order, t, 1.05 * samples);
                Some((portable(&built.map_err(Failure::input)?)?, trials))
            }
            None => None,
        };
        let device = pushed(config, experiment.push_n)?;
        let chain = force_limit(experiment.force_limit_n, t)?;
        // Sensors that cannot be made are refused before the first run.
        Sensed::new(device.clone(), experiment.sensors)?;
        let stiffness_unit = config.mass.0 / (t.0 * t.0);
        let dissipation_factor = config.mass.0 / t.0.powf(2.0 - order.get());
        Ok(Self {
            experiment,
            order,
            operator,
            device,
            chain,
            most: search_limit(config.damping.0 * t.0 / config.mass.0),
            stiffness_unit,
            dissipation_factor,
            seed: experiment.sensors.seed.wrapping_add((place as u64) << 32),
            remote,
            runs: AtomicU64::new(0),
        })
    }

    fn point(&self, alpha: f64, beta: f64) -> BoundaryPoint {
        BoundaryPoint {
            dissipation: beta * self.dissipation_factor,
            stiffness_max: alpha * self.stiffness_unit,
            alpha,
            beta,
        }
    }

    /// The largest α that is stable with this β; `None` if none of the coarse scale is.
    fn largest_stiffness(&self, beta: f64, cell: u64) -> Option<f64> {
        largest(self.most, |alpha| self.is_stable(alpha, beta, cell))
    }

    /// The largest β that is stable with any α, 0 if there is none. Not with α = 0: a pure damper of
    /// order 1 and more gives way for ever, which the criterion takes for a motion; and with A₃ at
    /// μ > 1 a wall needs stiffness to be stable at all.
    fn largest_dissipation(&self) -> f64 {
        // The pure damper, α = 0, is left out.
        let any_stiffness = |beta| {
            let walls = coarse(self.most).filter(|alpha| *alpha > 0.0);
            walls
                .into_iter()
                .any(|alpha| self.is_stable(alpha, beta, 0))
        };
        largest(self.most, any_stiffness).unwrap_or(0.0)
    }

    /// One run. Whatever goes wrong on the way is not stable.
    fn is_stable(&self, alpha: f64, beta: f64, cell: u64) -> bool {
        self.runs.fetch_add(1, Ordering::Relaxed);
        let sensors = self.experiment.sensors;
        let BoundaryPoint {
            dissipation,
            stiffness_max: stiffness,
            ..
        } = self.point(alpha, beta);
        if let Some((operator, trials)) = &self.remote {
            return self
                .deviation_on(trials, stiffness, dissipation, operator)
                .is_some_and(|deviation| deviation <= self.experiment.threshold_m);
        }
        let seed = self.seed.wrapping_add(cell);
        let device = Sensed::new(self.device.clone(), Sensors { seed, ..sensors });
        let one_sided = self.experiment.one_sided;
        let wall = wall_at_start(stiffness, dissipation, self.operator.clone(), one_sided);
        let (Ok(wall), Ok(device)) = (wall, device) else {
            return false;
        };
        self.deviation(wall, device)
            .is_some_and(|deviation| deviation <= self.experiment.threshold_m)
    }

    /// The same on the serial device, of the position that it measured.
    fn deviation_on(
        &self,
        trials: &Trials,
        stiffness: f64,
        dissipation: f64,
        operator: &(OperatorShape, Vec<f32>),
    ) -> Option<f64> {
        let ZWidth {
            device,
            duration_s,
            window_s,
            push_n,
            force_limit_n,
            ..
        } = *self.experiment;
        let t = device.sample_time.0;
        let law = RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.order.get(),
            one_sided: self.experiment.one_sided,
            operator: operator.clone(),
            limits: force_alone(force_limit_n, device.sample_time),
            kept: Kept::default(),
            guard: Default::default(),
            simulation: Simulation {
                mass_kg: device.mass.0 as f32,
                damping_n_s_per_m: device.damping.0 as f32,
                hand_stiffness_n_per_m: device.stiffness.0 as f32,
                ..push(push_n)
            },
        };
        let samples = (duration_s / t).round() as u64;
        let positions = trials.positions(&law, samples, t)?;
        let window = (window_s / t).round() as usize;
        let judged = &positions[positions.len().saturating_sub(window)..];
        if positions.iter().any(|x| x.abs() > GONE_M) {
            return None;
        }
        let count = judged.len() as f64;
        let mean = judged.iter().sum::<f64>() / count;
        let squares: f64 = judged.iter().map(|x| (x - mean) * (x - mean)).sum();
        Some((squares / count).sqrt())
    }

    /// Standard deviation of the position over the window, m; `None` if the device has left or the
    /// force was not finite.
    fn deviation(&self, wall: VirtualWall, mut device: Sensed<MassDamper<1>>) -> Option<f64> {
        let ZWidth {
            duration_s,
            window_s,
            ..
        } = *self.experiment;
        let mut controller = Controller::<f64, 1, _>::new(wall, self.chain);
        let t = self.experiment.device.sample_time.0;
        let samples = (duration_s / t).round() as u64;
        let judged = samples.saturating_sub((window_s / t).round() as u64);
        let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
        for n in 0..samples {
            match controller.tick(&mut device) {
                Ok(_) => {}
                Err(never) => match never {},
            }
            let x = device.device().position()[0];
            if x.abs() > GONE_M || x.is_nan() {
                return None;
            }
            if n >= judged {
                // Welford's running variance.
                count += 1.0;
                let change = x - mean;
                mean += change / count;
                squares += change * (x - mean);
            }
        }
        let fault = controller.safety().fault();
        fault.is_none().then(|| (squares / count).sqrt())
    }
}

/// The device of the dissertation's section 4.4: 65 g, 3.5 N·s/m, sampled at 2 ms, ideal.
#[must_use]
pub fn dissertation_device(sample_time: Seconds) -> MassDamperConfig {
    use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
    MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), sample_time)
}
