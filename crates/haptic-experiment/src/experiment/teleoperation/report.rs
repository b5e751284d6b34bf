//! Runs a teleoperation with log, table and report, and judges it while it runs: energy, forces, and what was felt.

use super::{
    HandMotion, TeleoperationExperiment,
    pair::{Pair, PairTick},
};
use crate::{
    experiment::{
        kind::{Experiment, conducts},
        reading::metadata,
    },
    judge::{
        Published,
        report::{Files, Report, RunReport, unmet},
        warnings::Warnings,
    },
};
use fracdiff::num_complex::Complex;
use haptic_document::{
    Failure,
    parameters::{SAMPLE_TIME, TISSUE_IN_LOG},
    rows,
};
use haptic_judge::{
    compared::percent,
    curves::{Curves, Drawing},
    decimated::Decimated,
    sensed::SensedForce,
    settling::SATURATED_S,
};
use haptic_loop::Limiters;
use haptic_message::TickMessage;
use haptic_run::{Ran, Watched, folder::RunTable, run_beside};
use haptic_trial::{
    ending::Ending,
    keys::teleoperation::{ARCHITECTURE, MUST_BE_PASSIVE, SLAVE_DAMPING, SLAVE_MASS},
    preflight::note_findings,
    samples::keeps_all,
    simulate::World,
};
use serde::Serialize;
use serde_json::{Value, json};
use std::{collections::BTreeMap, f64::consts::TAU};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TeleoperationVerdict {
    /// Both forces stayed within their limits, the line gave no energy, and the forces that were held from sample to sample gave
    /// no more than the damping of the devices took.
    Passive,
    /// Both forces stayed within their limits, but the line gave energy.
    GaveEnergy,
    /// The line gave none, but the forces held over a sample gave the devices more than their damping took.
    HeldForcesGaveEnergy,
    /// A force was at its limit for more than 50 ms.
    Saturated,
    /// A side heard nothing for too long.
    Silent,
    /// It did not reach its end.
    Unfinished,
}

impl TeleoperationVerdict {
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Passive => {
                "the line gave no energy, and holding forces added no more than damping absorbed"
            }
            Self::GaveEnergy => "the line gave energy",
            Self::HeldForcesGaveEnergy => {
                "held forces gave more than the damping of the devices took"
            }
            Self::Saturated => "a force was at its limit",
            Self::Silent => "a side heard nothing for too long",
            Self::Unfinished => "the run did not finish",
        }
    }
}

/// Impedance that the hand felt at a frequency, as force over position: a phase of 0° is a spring, 90° a damper, 180° a mass.
#[derive(Debug, Serialize)]
pub(super) struct FeltAt {
    pub frequency_hz: f64,
    /// The impedance that the hand met at the master, from the run.
    pub felt_n_per_m: f64,
    pub felt_degrees: f64,
    /// The impedance of the remote environment, from the run.
    pub touched_n_per_m: f64,
    pub touched_degrees: f64,
    /// The impedance of the remote environment in closed form; null if it is not linear.
    pub tissue_n_per_m: Option<f64>,
    pub tissue_degrees: Option<f64>,
    /// The impedance that the hand feels according to the formula; null without a formula, as for
    /// time-domain passivity.
    pub formula_n_per_m: Option<f64>,
    pub formula_degrees: Option<f64>,
    /// Deviation of the run from the formula.
    pub off_formula_db: Option<f64>,
    /// Deviation of the run from the tissue; 0 would be transparent.
    pub off_tissue_db: Option<f64>,
}

const COLUMNS: [&str; 9] = [
    "time_s",
    "hand_m",
    "master_position_m",
    "slave_position_m",
    "master_force_n",
    "slave_force_n",
    "hand_force_n",
    "place_force_n",
    "taken_j",
];

/// A tick as logs have it.
fn message(tick: &PairTick, hand_m: f64) -> TickMessage {
    let [master, slave] = tick.sides;
    TickMessage {
        tick: tick.tick,
        time_s: tick.time_s,
        reference_m: hand_m.into(),
        indenter_position_m: slave.position_m.into(),
        position_m: master.position_m.into(),
        environment_force_n: master.wanted_n.into(),
        commanded_force_n: master.force_n.into(),
        applied_force_n: master.force_n.into(),
        contact_force_n: (0.0 - slave.outside_n).into(),
        sensed_force_n: slave.sensed_n,
        limiters: master.limiters.bits() | slave.limiters.bits(),
        observed_energy_j: 0.0 - tick.given_j,
        ..TickMessage::unknown(1)
    }
}

/// Both sides, and the consumers of each tick besides the log.
struct Hands {
    pair: Pair,
    motion: HandMotion,
    judged: Judge,
    curves: Decimated<6>,
    table: Option<RunTable>,
    newest: Option<(PairTick, f64)>,
}

impl World for Hands {
    type Message = TickMessage;

    fn tick(&mut self) -> TickMessage {
        let tick = self.pair.tick();
        let hand_m = self.motion.at(tick.time_s).0;
        self.newest = Some((tick, hand_m));
        message(&tick, hand_m)
    }

    fn counted(&mut self) {
        let Some((tick, hand_m)) = self.newest else {
            return;
        };
        self.judged.see(&tick);
        let ([master, slave], taken_j) = (tick.sides, 0.0 - tick.given_j);
        let places = [hand_m, master.position_m, slave.position_m];
        let forces = [master.force_n, slave.force_n];
        if let Some(table) = &mut self.table {
            let outside = [master.outside_n, slave.outside_n];
            let values = (places.iter()).chain(&forces).chain(&outside).copied();
            let row = [tick.time_s].into_iter().chain(values).chain([taken_j]);
            table.row(row.collect::<Vec<f64>>());
        }
        let ([hand_m, master_m, slave_m], [master_n, slave_n]) = (places, forces);
        let values = [hand_m, master_m, slave_m, master_n, slave_n, taken_j];
        self.curves.add(tick.time_s, values);
    }

    fn ended(&self) -> Option<Ending> {
        self.pair.ended()
    }

    fn stop(&mut self) {
        self.pair.stop();
    }

    fn is_at_rest(&self) -> bool {
        self.pair.is_at_rest()
    }
}

impl Experiment for TeleoperationExperiment {
    fn check(&self) -> Result<u64, Failure> {
        self.check_waves()?;
        self.pair().map(|_| self.samples())
    }

    fn sample_time_s(&self) -> f64 {
        self.sample_time().0
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let mut metadata = metadata("teleoperation", &self.conduct, self.scheme, &self.safety);
        let frequencies: Vec<String> =
            (self.motion.frequencies_hz.iter().map(f64::to_string)).collect();
        let ran = [
            (SLAVE_MASS.key, self.slave.mass.0.to_string()),
            (SLAVE_DAMPING.key, self.slave.damping.0.to_string()),
            ("frequencies_hz", frequencies.join(" ")),
            ("playout_samples", self.playout().to_string()),
        ];
        metadata.extend(ran.map(|(key, value)| (key.to_owned(), value)));
        let file = self.place.matter.file();
        metadata.extend(file.map(|file| (TISSUE_IN_LOG.to_owned(), file)));
        metadata
    }

    conducts!();

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        let pair = self.pair()?;
        let schedule = self.schedule(self.samples());
        let preflight = self.require_stable()?;
        let mut metadata = self.metadata();
        if let Some(verdict) = &preflight {
            note_findings(&mut metadata, "preflight", verdict);
        }
        let mut hands = Hands {
            pair,
            motion: self.motion.clone(),
            judged: Judge::new(self),
            curves: Decimated::kept(keeps_all(schedule.samples)),
            table: None,
            newest: None,
        };
        let ran = run_beside(
            &mut hands,
            schedule,
            (watched.request, metadata),
            watched.supervisor,
            |hands, folder| {
                hands.table = Some(folder.named_table_beside_log("csv", &COLUMNS));
            },
        )?;
        let ran = Ran { preflight, ..ran };
        let (pair, judged) = (&hands.pair, &hands.judged);
        let whole = ran.record.ended.is_none();
        let files = Files::of_run(&ran, hands.table.filter(|_| whole));
        let felt = if whole {
            judged.felt(self)?
        } else {
            Vec::new()
        };
        let verdict = judged.verdict(pair, whole);
        let curves = whole.then(|| self.drawn(verdict, &felt, hands.curves));
        let report = self.report(&ran, pair, judged, verdict, &felt, files)?;
        Ok(Published::new(report, curves, ran))
    }

    /// The slave in its remote place is looked at.
    fn may_be_refused(&self) -> bool {
        true
    }
}

impl TeleoperationExperiment {
    fn report(
        &self,
        ran: &Ran,
        pair: &Pair,
        judged: &Judge,
        verdict: TeleoperationVerdict,
        felt: &[FeltAt],
        files: Files,
    ) -> Result<Report, Failure> {
        let stability = (self.hands())
            .map(|hands| hands.absolute_stability().map_err(Failure::input))
            .transpose()?;
        let warnings = self.warnings(ran, verdict, judged);
        let [forth, back] = line_counts(pair);
        let most = felt.iter().filter_map(|felt| felt.off_formula_db);
        // The force on the place beside that on the hand.
        let mut sensed = SensedForce::default();
        if self.force_sensor.is_some() {
            ran.samples().for_each(|sample| {
                sensed.add(sample, sample.reaction_n(), None);
                Ok(())
            })?;
        }
        let law = json!({
            "place": self.place.words(),
            "architecture": self.architecture.name(),
        });
        let results = json!({
            "verdict": verdict,
            "verdict_reason": verdict.words(),
            "line_delay_s": self.channel.delay.0,
            // Most that the line had given at any time: at most rounding if it is passive.
            "given_most_j": judged.given_most_j,
            "taken_j": 0.0 - judged.given_j,
            // Above 0 the devices bear the hold no more.
            "beyond_damping_most_j": judged.beyond_damping_most_j,
            "master_peak_n": judged.peaks_n[0],
            "slave_peak_n": judged.peaks_n[1],
            "forth": forth,
            "back": back,
            // Stable with any passive hand and place, by Llewellyn's conditions; null for time-domain passivity, which is no linear law.
            "absolutely_stable": stability.map(|found| found.stable),
            "least_ratio": stability.map(|found| found.least_ratio),
            "worst_hz": stability.map(|found| found.worst_rad_s / TAU),
            "felt": felt,
            "off_formula_most_db": most.map(f64::abs).reduce(f64::max),
        });
        let broken = self.must_be_passive && verdict != TeleoperationVerdict::Passive;
        let remedy = "use a passive architecture, a softer coupler or a smaller motion";
        Ok(Report {
            law: rows([law]),
            run: RunReport::new(ran, "sim".to_owned(), self.sample_time().0, files, warnings),
            results: rows([results, sensed.rows(ran.record.sensor, None)]),
            verdict: Some(verdict.words().to_owned()),
            unmet: broken.then(|| unmet(&MUST_BE_PASSIVE, verdict.words(), remedy)),
        })
    }

    fn warnings(&self, ran: &Ran, verdict: TeleoperationVerdict, judged: &Judge) -> Warnings {
        let mut warnings = Warnings::default();
        let unstable = ran.preflight.filter(|verdict| !verdict.stable);
        if let Some(warning) = unstable.and_then(|verdict| verdict.warning(false)) {
            warnings
                .0
                .push(format!("the slave in its remote environment: {warning}"));
        }
        if verdict == TeleoperationVerdict::GaveEnergy {
            warnings.0.push(format!(
                "the line gave {:.3e} J: a loose hand may be shaken; {ARCHITECTURE} wave or time-domain gives none",
                judged.given_most_j
            ));
        }
        if verdict == TeleoperationVerdict::HeldForcesGaveEnergy {
            warnings.0.push(format!(
                "holding forces added {:.3e} J more than damping absorbed: shorten {SAMPLE_TIME}, or use a softer coupler",
                judged.beyond_damping_most_j
            ));
        }
        if verdict == TeleoperationVerdict::Saturated {
            warnings.0.push(self.saturated());
        }
        warnings
    }

    /// The warning of a force that was at its limit.
    pub(super) fn saturated(&self) -> String {
        format!(
            "a force was at its limit of {} N: what was felt is not what was touched; use a softer coupler, a smaller \
             motion or a passive {ARCHITECTURE}",
            self.force_limit_n
        )
    }

    fn drawn(
        &self,
        verdict: TeleoperationVerdict,
        felt: &[FeltAt],
        curves: Decimated<6>,
    ) -> Curves {
        let subtitle = format!(
            "{} · delay {} ms, jitter {} %, loss {} % · {}\n{}",
            self.architecture.name(),
            percent(10.0 * self.channel.delay.0),
            percent(self.channel.jitter),
            percent(self.channel.loss),
            self.place.words(),
            verdict.words()
        );
        let over_frequency = |value: fn(&FeltAt) -> Option<f64>| {
            let points = felt.iter().map(|at| Some((at.frequency_hz, value(at)?)));
            points.flatten().collect()
        };
        let stiffnesses = vec![
            ("touched", over_frequency(|at| Some(at.touched_n_per_m))),
            ("formula", over_frequency(|at| at.formula_n_per_m)),
            ("felt", over_frequency(|at| Some(at.felt_n_per_m))),
        ];
        let title = "A teleoperation, simulated".to_owned();
        let drawing = Drawing::Pair { stiffnesses };
        curves.named(DRAWN, "simulated", title, subtitle, drawing)
    }
}

/// Curves of hand, master and slave, of the forces on the two, and of the energy taken by the line.
const DRAWN: [&str; 6] = [
    "hand_m",
    "position_m",
    "far_position_m",
    "force_n",
    "far_force_n",
    "taken_j",
];

/// Energy of rounding errors, as a share of what went back and forth.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Debug, Default)]
pub(super) struct Judge {
    /// Master, hand, slave, place: places and forces from outside.
    spectrum: Spectrum<4>,
    from_s: f64,
    sample_time_s: f64,
    saturated: u64,
    last_m: [f64; 2],
    exchanged_j: f64,
    given_most_j: f64,
    given_j: f64,
    beyond_damping_most_j: f64,
    peaks_n: [f64; 2],
}

impl Judge {
    pub(super) fn new(experiment: &TeleoperationExperiment) -> Self {
        let t = experiment.sample_time().0;
        let omegas = experiment.motion.frequencies_hz.iter().map(|f| TAU * f);
        Self {
            spectrum: Spectrum::new(omegas.collect()),
            // Whole samples; times are multiples of T, rounded.
            from_s: experiment.duration_s - experiment.window_s + 0.5 * t,
            sample_time_s: t,
            ..Self::default()
        }
    }

    pub(super) fn see(&mut self, tick: &PairTick) {
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

    fn verdict(&self, pair: &Pair, whole: bool) -> TeleoperationVerdict {
        let silent = pair
            .ports()
            .into_iter()
            .any(|port| port.is_silent() || !port.has_heard());
        let saturated_s = self.saturated as f64 * self.sample_time_s;
        if silent {
            TeleoperationVerdict::Silent
        } else if !whole {
            TeleoperationVerdict::Unfinished
        } else if saturated_s > SATURATED_S {
            TeleoperationVerdict::Saturated
        } else if self.counts(self.given_most_j) {
            TeleoperationVerdict::GaveEnergy
        } else if self.counts(self.beyond_damping_most_j) {
            TeleoperationVerdict::HeldForcesGaveEnergy
        } else {
            TeleoperationVerdict::Passive
        }
    }

    /// Impedances that the master's hand felt, beside those of the tissue and of the formula.
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
            let off = |other: Complex<f64>| 20.0 * libm::log10((felt / other).norm());
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

/// Messages of each way of the line, from the master and back; those that came late or twice were not acted on.
fn line_counts(pair: &Pair) -> [Value; 2] {
    let [master, slave] = pair.ports();
    let [forth, back] = pair.ways();
    [(forth, slave), (back, master)].map(|(way, port)| {
        let (way, port) = (way.counts(), port.counts());
        json!({
            "sent": way.sent,
            "lost": way.lost,
            "doubled": way.doubled,
            "delivered": way.delivered,
            "stale": port.stale,
            "duplicate": port.duplicate,
        })
    })
}

/// Sums of M signals over a window, at each frequency.
///
/// ```text
/// X_i = Σ x[n]·e^(−jω_i t_n)        whole periods of each frequency, so that none leaks into another
/// ```
#[derive(Clone, Debug, Default)]
struct Spectrum<const M: usize> {
    omegas: Vec<f64>,
    sums: Vec<[Complex<f64>; M]>,
}

impl<const M: usize> Spectrum<M> {
    fn new(omegas: Vec<f64>) -> Self {
        let sums = vec![[Complex::new(0.0, 0.0); M]; omegas.len()];
        Self { omegas, sums }
    }

    fn add(&mut self, time_s: f64, values: [f64; M]) {
        for (omega, sums) in self.omegas.iter().zip(&mut self.sums) {
            let turned = Complex::from_polar(1.0, -omega * time_s);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += turned * value;
            }
        }
    }

    fn iter(&self) -> impl Iterator<Item = (f64, &[Complex<f64>; M])> {
        self.omegas.iter().copied().zip(&self.sums)
    }
}
