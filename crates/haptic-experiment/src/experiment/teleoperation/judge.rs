//! Judges a teleoperation while it runs: energy, forces, and what was felt.

use super::pair::{Pair, PairTick};
use super::report::{FeltAt, LineCounts, TeleoperationVerdict};
use super::specification::TeleoperationExperiment;
use crate::document::failure::Failure;
use fracdiff::num_complex::Complex;
use haptic_loop::Limiters;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Share of the samples in which a force may be at its limit.
pub(super) const SATURATED_SHARE: f64 = 0.01;
/// Energy of rounding errors, as a share of what went back and forth.
pub(super) const ROUNDING: f64 = 1e-12;

/// Sums over a run.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    /// Master, hand, slave, place: places and forces from outside.
    spectrum: Spectrum<4>,
    from_s: f64,
    samples: u64,
    saturated: u64,
    last_m: [f64; 2],
    exchanged_j: f64,
    pub(super) given_most_j: f64,
    pub(super) given_j: f64,
    pub(super) beyond_damping_most_j: f64,
    pub(super) peaks_n: [f64; 2],
}

impl Judge {
    pub(super) fn new(experiment: &TeleoperationExperiment) -> Self {
        let t = experiment.sample_time().0;
        let omegas = experiment.motion.frequencies_hz.iter().map(|f| TAU * f);
        Self {
            spectrum: Spectrum::new(omegas.collect()),
            // Whole samples; times are multiples of T, rounded.
            from_s: experiment.duration_s - experiment.window_s + 0.5 * t,
            samples: 0,
            saturated: 0,
            last_m: [0.0; 2],
            exchanged_j: 0.0,
            given_most_j: 0.0,
            given_j: 0.0,
            beyond_damping_most_j: 0.0,
            peaks_n: [0.0; 2],
        }
    }

    pub(super) fn see(&mut self, tick: &PairTick) {
        self.samples += 1;
        let [master, slave] = tick.sides;
        for (n, side) in tick.sides.iter().enumerate() {
            self.peaks_n[n] = self.peaks_n[n].max(side.force_n.abs());
            self.exchanged_j += (side.force_n * (side.position_m - self.last_m[n])).abs();
            self.last_m[n] = side.position_m;
        }
        let limited = |limiters: Limiters| limiters.contains(Limiters::MAGNITUDE);
        self.saturated += u64::from(limited(master.limiters) || limited(slave.limiters));
        self.given_j = tick.given_j;
        self.given_most_j = self.given_most_j.max(tick.given_j);
        self.beyond_damping_most_j = (self.beyond_damping_most_j).max(tick.held_j - tick.damped_j);
        if tick.time_s > self.from_s {
            let values = [
                master.position_m,
                master.outside_n,
                slave.position_m,
                slave.outside_n,
            ];
            self.spectrum.add(tick.time_s, values);
        }
    }

    /// True if so much is more than rounding.
    fn counts(&self, energy_j: f64) -> bool {
        energy_j > ROUNDING * self.exchanged_j
    }

    pub(super) fn verdict(&self, pair: &Pair, whole: bool) -> TeleoperationVerdict {
        let silent = pair
            .ports()
            .into_iter()
            .any(|port| port.is_silent() || !port.has_heard());
        let share = self.saturated as f64 / self.samples.max(1) as f64;
        if silent {
            TeleoperationVerdict::Silent
        } else if !whole {
            TeleoperationVerdict::Unfinished
        } else if share > SATURATED_SHARE {
            TeleoperationVerdict::Saturated
        } else if self.counts(self.given_most_j) {
            TeleoperationVerdict::GaveEnergy
        } else if self.counts(self.beyond_damping_most_j) {
            TeleoperationVerdict::HeldForcesGaveEnergy
        } else {
            TeleoperationVerdict::Passive
        }
    }

    /// What was felt, frequency by frequency.
    pub(super) fn felt(
        &self,
        experiment: &TeleoperationExperiment,
    ) -> Result<Vec<FeltAt>, Failure> {
        let hands = experiment.hands();
        let at = |(omega, &[master, hand, slave, place]): (f64, &[Complex<f64>; 4])| {
            let s = Complex::new(0.0, omega);
            let (felt, touched) = (hand / master, -place / slave);
            let tissue = experiment.place.stiffness(omega);
            let formula = (hands.zip(tissue))
                .map(|(hands, tissue)| hands.transmitted(omega, tissue / s))
                .transpose()
                .map_err(Failure::input)?
                .map(|impedance| impedance * s);
            let off = |other: Complex<f64>| 20.0 * (felt / other).norm().log10();
            let degrees = |of: Complex<f64>| of.arg().to_degrees();
            Ok(FeltAt {
                frequency_hz: omega / TAU,
                felt_n_per_m: felt.norm(),
                felt_degrees: degrees(felt),
                touched_n_per_m: touched.norm(),
                touched_degrees: degrees(touched),
                tissue_n_per_m: tissue.map(Complex::norm),
                tissue_degrees: tissue.map(degrees),
                formula_n_per_m: formula.map(Complex::norm),
                formula_degrees: formula.map(degrees),
                off_formula_db: formula.map(off),
                off_tissue_db: tissue.map(off),
            })
        };
        self.spectrum.iter().map(at).collect()
    }
}

impl TeleoperationExperiment {
    /// Runs it in virtual time without log or files, and says what was felt.
    ///
    /// # Errors
    /// A parameter outside its range, or a run that a fault or silence ended.
    pub fn felt(&self) -> Result<Vec<FeltAt>, Failure> {
        let mut judged = Judge::new(self);
        let whole = self.simulate(&mut |tick| {
            judged.see(tick);
            ControlFlow::Continue(())
        })?;
        if !whole {
            return Err(Failure::Run(anyhow::anyhow!(
                "a side heard nothing for too long, or a fault ended the run"
            )));
        }
        judged.felt(self)
    }
}

/// Messages of both ways.
pub(super) fn line_counts(pair: &Pair) -> [LineCounts; 2] {
    let [master, slave] = pair.ports();
    let [forth, back] = pair.ways();
    [(forth, slave), (back, master)].map(|(way, port)| {
        let (way, port) = (way.counts(), port.counts());
        LineCounts {
            sent: way.sent,
            lost: way.lost,
            doubled: way.doubled,
            delivered: way.delivered,
            stale: u64::from(port.stale),
            duplicate: u64::from(port.duplicate),
        }
    })
}

/// Sums of M signals over a window, at each frequency.
///
/// ```text
/// X_i = Σ x[n]·e^(−jω_i t_n)        whole periods of each frequency, so that none leaks into another
/// ```
#[derive(Clone, Debug)]
struct Spectrum<const M: usize> {
    omegas: Vec<f64>,
    sums: Vec<[Complex<f64>; M]>,
}

impl<const M: usize> Spectrum<M> {
    /// Empty.
    fn new(omegas: Vec<f64>) -> Self {
        let sums = vec![[Complex::new(0.0, 0.0); M]; omegas.len()];
        Self { omegas, sums }
    }

    /// Adds a sample.
    fn add(&mut self, time_s: f64, values: [f64; M]) {
        for (omega, sums) in self.omegas.iter().zip(&mut self.sums) {
            let turned = Complex::from_polar(1.0, -omega * time_s);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += turned * value;
            }
        }
    }

    /// Frequency, rad/s, and sums.
    fn iter(&self) -> impl Iterator<Item = (f64, &[Complex<f64>; M])> {
        self.omegas.iter().copied().zip(&self.sums)
    }
}
