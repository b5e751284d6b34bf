//! Judges a coupler that was run: does it settle, was each force right, and where was the object?

use super::report::CouplerReport;
use super::running::Law;
use super::specification::CouplerExperiment;
use crate::curves::{CouplerCurves, Origin};
use crate::failure::Failure;
use crate::judge::{Compared, Reference, full_history};
use crate::kept::{KeptSample, Record, Samples, WHOLE_MOST};
use crate::outcome::origin;
use crate::pushed::{Setup, six_digits, warnings};
use crate::remote::device_name;
use crate::report::{Errors, Files, RunReport};
use crate::run::Ran;
use crate::safety::GuardChoice;
use crate::settling::{Judge, Settling};
use crate::thinned::Thinned;
use crate::track::{TOLERANCE, operator};
use fracdiff::full_memory::Kernel;
use fracdiff::{Channel, Operator, Order};
use haptic_loop::Environment;
use nalgebra::Vector1;
use serde::Serialize;

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    position_m: f64,
    object_position_m: f64,
    reaction_force_n: f64,
}

/// The object again, from the positions that the loop read. Those that a link lost lie on a straight line.
struct Replay {
    law: Law,
    history: <Law as Environment<f64, 1>>::History,
    next_tick: u64,
    last_m: f64,
}

impl Replay {
    fn new(law: Law) -> Self {
        Self {
            history: Environment::<f64, 1>::at_rest(&law),
            law,
            next_tick: 0,
            last_m: 0.0,
        }
    }

    /// Place of the object at this sample, m.
    fn at(&mut self, sample: &KeptSample) -> f64 {
        let x = sample.position_m;
        let from = if self.next_tick == 0 { x } else { self.last_m };
        let missing = sample.tick.saturating_sub(self.next_tick);
        let slope = (x - from) / (missing + 1) as f64;
        for n in 1..=missing {
            self.step(from + n as f64 * slope);
        }
        self.step(x);
        self.next_tick = sample.tick + 1;
        self.last_m = x;
        self.law.object_position_m(&self.history)[0]
    }

    fn step(&mut self, x: f64) {
        self.law.advance(&mut self.history, &Vector1::new(x));
    }
}

/// The object by its own equation from the forces that were commanded, and from it the deflection of the coupler: nothing of
/// the coupler that ran is in it.
///
/// ```text
/// m_o > 0:  v ← v + (T/2m_o)(a + a'),  a = F − b_o·v − k_o·p,   p ← p + (T/2)(v + v')
/// m_o = 0:  F = b_o·v + k_o·p;          q = p + (T/2)·v,   y = x − q
/// ```
#[derive(Clone, Copy, Debug, Default)]
struct Object {
    velocity: f64,
    place: f64,
    net: f64,
}

impl Object {
    /// The deflection after this sample.
    fn deflection(&mut self, law: &CouplerExperiment, x: f64, force: f64) -> f64 {
        let (t, object) = (law.device.sample_time.0, law.object);
        let (m, b, k) = (
            object.mass_kg,
            object.damping_n_s_per_m,
            object.stiffness_n_per_m,
        );
        let Self {
            velocity,
            place,
            net,
        } = *self;
        let half = 0.5 * t;
        let ahead = place + half * velocity;
        let next = if m > 0.0 {
            (velocity + half / m * (net + force - k * ahead)) / (1.0 + half / m * (b + half * k))
        } else {
            (force - k * ahead) / (b + half * k)
        };
        self.velocity = next;
        self.place = ahead + half * next;
        self.net = force - b * next - k * self.place;
        x - (self.place + half * next)
    }
}

/// D^(1−μ) of the deflection, sample by sample.
enum History {
    Whole(std::vec::IntoIter<f64>),
    Streamed(Channel<f64, Operator<f64>>),
}

impl CouplerExperiment {
    /// Judges a run again.
    #[cfg(test)]
    pub(crate) fn report(
        &self,
        ran: &Ran,
    ) -> Result<(CouplerReport, Option<CouplerCurves>), Failure> {
        let parts = self.parts()?;
        self.publish(ran, parts.judge, parts.rest_m)
    }

    /// D^(1−μ) of the deflection by its full history, or why the force is not the coupler's of it.
    fn history(&self, ran: &Ran) -> Result<Result<History, &'static str>, Failure> {
        let record = &ran.record;
        let reference = Reference::of(self.scheme);
        let order = Order::new(1.0 - self.order.get()).map_err(Failure::input)?;
        let t = self.device.sample_time;
        let reason = if record.limited > 0 {
            Some("the safety chain limited the force")
        } else if record.dropped > 0 {
            Some("samples are missing, so the object is not known")
        } else if self.remote.is_some() {
            Some("a serial device makes each force some samples after its position")
        } else if reference == Reference::Kernel(Kernel::PiecewiseLinear) && order.get() >= 1.0 {
            Some("the weights of this kernel are known in closed form below order 1 only")
        } else if record.largest_force_n() == 0.0 {
            Some("no force was commanded")
        } else {
            None
        };
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let Some(whole) = &record.whole else {
            let planned = self.setup().plan().samples(t)?;
            return Ok(Ok(History::Streamed(operator(
                reference, order, t, planned,
            )?)));
        };
        let mut object = Object::default();
        let deflection: Vec<f64> = (whole.iter())
            .map(|sample| object.deflection(self, sample.position_m, -sample.force_n))
            .collect();
        let values = full_history(reference, order, t, &deflection).map_err(Failure::Run)?;
        Ok(Ok(History::Whole(values.into_iter())))
    }

    /// Mean deflection over the window at the end against the springs in series.
    fn deflection_error(&self, record: &Record, settling: Settling) -> Compared {
        let (window_s, judged) = self.setup().window(record);
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), window_s, judged)
            }
            (Some(_), None) => Compared::without_meaning(
                "the coupler creeps or nothing holds the object, so there is no place of rest"
                    .to_owned(),
            ),
            _ => Compared::without_meaning("the coupler did not come to rest".to_owned()),
        }
    }

    pub(super) fn publish(
        &self,
        ran: &Ran,
        judge: Judge,
        rest_m: Option<f64>,
    ) -> Result<(CouplerReport, Option<CouplerCurves>), Failure> {
        let Ran { record, folder, .. } = ran;
        let whole = record.ended.is_none();
        let settling = self.named(Setup::settling(judge, ran, rest_m)?)?;
        let agrees =
            (ran.preflight.filter(|_| whole)).map(|analysis| analysis.stable == settling.stable);
        let mut warnings = warnings("coupler", &settling, agrees, record);
        // A serial device heard it before it was armed.
        let analysis = ran.preflight.filter(|_| self.remote.is_none());
        // Energy bounding promises passivity for the damping of the device.
        let guarded = self.safety.guard == GuardChoice::EnergyBounding;
        warnings
            .0
            .extend(analysis.and_then(|analysis| analysis.warning(guarded)));
        let mut files = Files::default();
        let mut curves = None;
        let mut object_position_m = None;
        let mut operator_error = Compared::without_meaning("the run was cut short".to_owned());
        if whole {
            let judged = self.judge(ran)?;
            operator_error = judged.operator_error;
            object_position_m = judged.object_m;
            files.csv = Some(judged.csv);
            curves = Some(self.drawn(origin(record), judged.curves, settling));
        } else {
            folder.remove_stale_results();
        }
        let report = CouplerReport {
            tissue: None,
            order: self.order.get(),
            scheme: self.scheme.to_string(),
            run: RunReport::new(
                ran,
                device_name(self.remote.as_ref()),
                self.device.sample_time.0,
                files,
                warnings,
            ),
            errors: Errors::new(operator_error, self.deflection_error(record, settling)),
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            settling,
            analysis_agrees: agrees,
            coupler_stiffness_n_s_per_m: self.coupler_stiffness_n_s_per_m,
            coupler_dissipation_n_s_1_minus_mu_per_m: self.coupler_dissipation_n_s_1_minus_mu_per_m,
            object_mass_kg: self.object.mass_kg,
            object_damping_n_s_per_m: self.object.damping_n_s_per_m,
            object_stiffness_n_per_m: self.object.stiffness_n_per_m,
            object_position_m,
        };
        Ok((report, curves))
    }

    /// Writes the table of a run that reached its end, and holds each force against theory.
    fn judge(&self, ran: &Ran) -> Result<Judged, Failure> {
        let record = &ran.record;
        let t = self.device.sample_time.0;
        let mut history = self.history(ran)?;
        let planned = self.setup().plan().samples(self.device.sample_time)?;
        let mut replay = Replay::new(self.law(planned)?);
        let mut table = ran.folder.table_beside_log("csv")?;
        let dense = if record.whole.is_some() {
            WHOLE_MOST
        } else {
            0
        };
        let mut curves = Thinned::new(dense);
        let (mut object, mut last, mut off): (Object, f64, f64) = (Object::default(), 0.0, 0.0);
        let mut object_m = None;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            if let Ok(history) = &mut history {
                let y = object.deflection(self, x, reaction_force_n);
                let d = match history {
                    History::Whole(values) => values.next().unwrap_or(f64::NAN),
                    History::Streamed(channel) => channel.step(y),
                };
                // F = k_c·(y[n] − y[n−1])/T + b_c·D^(1−μ) y
                let wanted = self.coupler_stiffness_n_s_per_m * (y - last) / t
                    + self.coupler_dissipation_n_s_1_minus_mu_per_m * d;
                off = off.max((reaction_force_n - wanted).abs());
                last = y;
            }
            let object_position_m = replay.at(sample);
            object_m = Some(object_position_m);
            curves.add(sample.time_s, [x, object_position_m, reaction_force_n]);
            table.row(&Row {
                time_s: sample.time_s,
                position_m: x,
                object_position_m,
                reaction_force_n,
            })
        })?;
        curves.finish();
        let operator_error = match history {
            Ok(_) => Compared::of_window(
                off / record.largest_force_n(),
                [0.0, record.duration_s()],
                record.samples,
            ),
            Err(reason) => Compared::without_meaning(reason.to_owned()),
        };
        Ok(Judged {
            csv: table.finish()?,
            curves,
            operator_error,
            object_m,
        })
    }

    /// The curves, and what to say of them.
    fn drawn(&self, origin: Origin, curves: Thinned<3>, settling: Settling) -> CouplerCurves {
        let object = self.object;
        let subtitle = format!(
            "order μ = {} · k_c = {} N·s/m · b_c = {} N·s^(1−μ)/m · object {} kg, {} N·s/m, {} N/m · {}",
            self.order,
            six_digits(self.coupler_stiffness_n_s_per_m),
            six_digits(self.coupler_dissipation_n_s_1_minus_mu_per_m),
            six_digits(object.mass_kg),
            six_digits(object.damping_n_s_per_m),
            six_digits(object.stiffness_n_per_m),
            self.setup().words(self.scheme, &settling)
        );
        let [position_m, object_position_m, force_n] = curves.curves;
        CouplerCurves {
            subtitle,
            origin,
            expected_deflection_m: settling.expected_deflection_m,
            time_s: curves.time_s,
            position_m,
            object_position_m,
            force_n,
        }
    }
}

/// Results of a run that reached its end.
struct Judged {
    csv: String,
    curves: Thinned<3>,
    /// See [`Errors::max_relative_error`].
    operator_error: Compared,
    /// Place of the object at the end, m.
    object_m: Option<f64>,
}
