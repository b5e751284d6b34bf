//! Runs a teleoperation with log, table and report.

use super::curves::TeleoperationCurves;
use super::judge::{Judge, line_counts};
use super::pair::{Pair, PairTick};
use super::report::{TeleoperationReport, TeleoperationVerdict};
use super::specification::{HandMotion, TeleoperationExperiment};
use crate::document::failure::Failure;
use crate::document::parameters::SAMPLE_TIME;
use crate::experiment::teleoperation::keys::ARCHITECTURE;
use crate::judge::curves::Published;
use crate::judge::decimated::Decimated;
use crate::judge::report::{Files, RunReport};
use crate::judge::warnings::Warnings;
use crate::run::ending::Ending;
use crate::run::folder::{FolderRequest, OutputFolder, Table};
use crate::run::schedule::Schedule;
use crate::run::{Ran, Supervisor, World, run_logged};
use haptic_log::record::TickMessage;
use serde::Serialize;

/// A row of the table.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    hand_m: f64,
    master_position_m: f64,
    slave_position_m: f64,
    master_force_n: f64,
    slave_force_n: f64,
    hand_force_n: f64,
    place_force_n: f64,
    taken_j: f64,
}

impl Row {
    fn of(tick: &PairTick, hand_m: f64) -> Self {
        let [master, slave] = tick.sides;
        Self {
            time_s: tick.time_s,
            hand_m,
            master_position_m: master.position_m,
            slave_position_m: slave.position_m,
            master_force_n: master.force_n,
            slave_force_n: slave.force_n,
            hand_force_n: master.outside_n,
            place_force_n: slave.outside_n,
            taken_j: 0.0 - tick.given_j,
        }
    }
}

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
        limiters: master.limiters.bits() | slave.limiters.bits(),
        observed_energy_j: 0.0 - tick.given_j,
        ..TickMessage::default()
    }
}

/// Both sides, and what is told of each tick beside the log.
struct Hands {
    pair: Pair,
    motion: HandMotion,
    judged: Judge,
    curves: Decimated<6>,
    table: Option<Table>,
    newest: Option<(PairTick, f64)>,
}

impl World for Hands {
    type Message = TickMessage;

    fn begins(&mut self, folder: &OutputFolder) {
        self.table = Some(folder.table_beside_log("csv"));
    }

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
        if let Some(table) = &mut self.table {
            table.row(Row::of(&tick, hand_m));
        }
        let [master, slave] = tick.sides;
        let values = [
            hand_m,
            master.position_m,
            slave.position_m,
            master.force_n,
            slave.force_n,
            0.0 - tick.given_j,
        ];
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

impl TeleoperationExperiment {
    /// Runs the experiment; log, table and report go into the folder.
    ///
    /// # Errors
    /// Bad parameters, or a slave that is not stable in its remote place, before any file is made; a log or table that cannot be
    /// written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<TeleoperationReport, TeleoperationCurves>, Failure> {
        self.check_waves()?;
        let pair = self.pair()?;
        let schedule = Schedule {
            samples: self.samples(),
            sample_time_s: self.sample_time().0,
            pace: self.pace,
        };
        let preflight = self.require_stable()?;
        let mut metadata = self.metadata();
        if let Some(verdict) = &preflight {
            verdict.describe(&mut metadata);
        }
        let mut hands = Hands {
            pair,
            motion: self.motion.clone(),
            judged: Judge::new(self),
            curves: Decimated::for_samples(schedule.samples),
            table: None,
            newest: None,
        };
        let ran = run_logged(&mut hands, schedule, (request, metadata), supervisor)?;
        let ran = Ran { preflight, ..ran };
        let Hands {
            pair,
            judged,
            mut curves,
            table,
            ..
        } = hands;
        let whole = ran.record.ended.is_none();
        let files = Files::of_run(&ran, table.filter(|_| whole));
        curves.finish();
        let report = self.report(&ran, (&pair, &judged), files)?;
        let drawn = whole.then(|| self.drawn(&report, curves));
        Ok(Published::new((report, drawn), ran.folder))
    }

    fn report(
        &self,
        ran: &Ran,
        (pair, judged): (&Pair, &Judge),
        files: Files,
    ) -> Result<TeleoperationReport, Failure> {
        let whole = ran.record.ended.is_none();
        let verdict = judged.verdict(pair, whole);
        let felt = match whole {
            true => judged.felt(self)?,
            false => Vec::new(),
        };
        let stability = (self.hands())
            .map(|hands| hands.absolute_stability().map_err(Failure::input))
            .transpose()?;
        let warnings = self.warnings(ran, verdict, judged);
        let [forth, back] = line_counts(pair);
        let most = felt.iter().filter_map(|felt| felt.off_formula_db);
        Ok(TeleoperationReport {
            place: self.place.words(),
            architecture: self.architecture.name().to_owned(),
            run: RunReport::new(ran, "sim".to_owned(), self.sample_time().0, files, warnings),
            verdict,
            verdict_reason: verdict.words(),
            line_delay_s: self.channel.delay.0,
            given_most_j: judged.given_most_j,
            taken_j: 0.0 - judged.given_j,
            beyond_damping_most_j: judged.beyond_damping_most_j,
            master_peak_n: judged.peaks_n[0],
            slave_peak_n: judged.peaks_n[1],
            forth,
            back,
            absolutely_stable: stability.map(|found| found.stable),
            least_ratio: stability.map(|found| found.least_ratio),
            worst_hz: stability.map(|found| found.worst_rad_s / std::f64::consts::TAU),
            off_formula_most_db: most.map(f64::abs).reduce(f64::max),
            felt,
        })
    }

    fn warnings(&self, ran: &Ran, verdict: TeleoperationVerdict, judged: &Judge) -> Warnings {
        let mut warnings = Warnings::default();
        let unstable = ran.preflight.filter(|verdict| !verdict.stable);
        if let Some(warning) = unstable.and_then(|verdict| verdict.warning(false)) {
            warnings
                .0
                .push(format!("the slave in its remote place: {warning}"));
        }
        if verdict == TeleoperationVerdict::GaveEnergy {
            warnings.0.push(format!(
                "the line gave {:.3e} J: a hand that holds less tightly may be shaken; {ARCHITECTURE} wave or time-domain \
                 gives none at any delay",
                judged.given_most_j
            ));
        }
        if verdict == TeleoperationVerdict::HeldForcesGaveEnergy {
            warnings.0.push(format!(
                "forces held over a sample gave the devices {:.3e} J more than their damping took: take a shorter \
                 {SAMPLE_TIME}, a softer coupler, or devices with more damping",
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
            "a force was at its limit of {} N: what was felt is not what was touched; take a softer coupler, a smaller \
             motion or a passive {ARCHITECTURE}",
            self.force_limit_n
        )
    }

    fn drawn(&self, report: &TeleoperationReport, curves: Decimated<6>) -> TeleoperationCurves {
        let [hand_m, master_m, slave_m, master_n, slave_n, taken_j] = curves.curves;
        TeleoperationCurves {
            subtitle: format!(
                "{} · delay {} ms, jitter {} %, loss {} % · {}\n{}",
                report.architecture,
                crate::judge::percent(10.0 * self.channel.delay.0),
                crate::judge::percent(self.channel.jitter),
                crate::judge::percent(self.channel.loss),
                report.place,
                report.verdict.words()
            ),
            time_s: curves.time_s,
            hand_m,
            master_m,
            slave_m,
            master_n,
            slave_n,
            taken_j,
            felt: report.felt.clone(),
        }
    }
}
