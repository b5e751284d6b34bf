//! Judges a coupler that was run: does it settle, was each force right, and where was the object?

use super::report::{CouplerCurves, CouplerReport};
use super::running::Law;
use super::specification::CouplerExperiment;
use crate::document::failure::Failure;
use crate::experiment::trial::{Trial as _, Verdict, incomparable, limited, six_digits, verdict};
use crate::judge::curves::Origin;
use crate::judge::decimated::Decimated;
use crate::judge::reference::operator;
use crate::judge::settling::{Judge, Settling};
use crate::judge::{Reference, full_history};
use crate::run::Ran;
use crate::run::tick::KeptSample;
use fracdiff::{Channel, Operator, Order};
use haptic_loop::Environment;
use nalgebra::Vector1;

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
        let (t, object) = (law.setup.device.sample_time.0, law.object);
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
        let t = self.setup.device.sample_time;
        let reason = limited(record)
            .or_else(|| {
                (record.dropped > 0).then_some("samples are missing, so the object is not known")
            })
            .or_else(|| {
                let serial = self.setup.remote.is_some();
                serial.then_some("a serial device makes each force some samples after its position")
            })
            .or_else(|| incomparable(reference, order, record));
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let Some(whole) = &record.whole else {
            let planned = self.setup.plan().samples(t)?;
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

    pub(super) fn publish(
        &self,
        ran: &Ran,
        judge: Judge,
        rest_m: Option<f64>,
    ) -> Result<(CouplerReport, Option<CouplerCurves>), Failure> {
        let mut object_position_m = None;
        let (trial, curves) = self.reported(ran, (judge, rest_m), || {
            self.judge(ran, &mut object_position_m)
        })?;
        let settling = trial.settling;
        let report = CouplerReport {
            trial,
            coupler_stiffness_n_s_per_m: self.coupler_stiffness_n_s_per_m,
            coupler_dissipation_n_s_1_minus_mu_per_m: self.coupler_dissipation_n_s_1_minus_mu_per_m,
            object_mass_kg: self.object.mass_kg,
            object_damping_n_s_per_m: self.object.damping_n_s_per_m,
            object_stiffness_n_per_m: self.object.stiffness_n_per_m,
            object_position_m,
        };
        let curves = curves.map(|(origin, curves)| self.drawn(origin, curves, settling));
        Ok((report, curves))
    }

    /// Writes the table of a run that reached its end, holds each force against theory, and tells the last place of the object.
    fn judge(&self, ran: &Ran, object_m: &mut Option<f64>) -> Result<Verdict<3>, Failure> {
        let t = self.setup.device.sample_time.0;
        let mut history = self.history(ran)?;
        let reason = history.as_ref().err().copied();
        let planned = self.setup.plan().samples(self.setup.device.sample_time)?;
        let mut replay = Replay::new(self.law(planned)?);
        let (mut object, mut last) = (Object::default(), 0.0);
        let names = ["position_m", "object_position_m", "reaction_force_n"];
        verdict(ran, names, reason, |sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            let off = history.as_mut().map_or(0.0, |history| {
                let y = object.deflection(self, x, reaction_force_n);
                let d = match history {
                    History::Whole(values) => values.next().unwrap_or(f64::NAN),
                    History::Streamed(channel) => channel.step(y),
                };
                // F = k_c·(y[n] − y[n−1])/T + b_c·D^(1−μ) y
                let wanted = self.coupler_stiffness_n_s_per_m * (y - last) / t
                    + self.coupler_dissipation_n_s_1_minus_mu_per_m * d;
                last = y;
                (reaction_force_n - wanted).abs()
            });
            let object_position_m = replay.at(sample);
            *object_m = Some(object_position_m);
            (off, [x, object_position_m, reaction_force_n])
        })
    }

    /// The curves, and what to say of them.
    fn drawn(&self, origin: Origin, curves: Decimated<3>, settling: Settling) -> CouplerCurves {
        let object = self.object;
        let subtitle = format!(
            "order μ = {} · damper {} N·s/m · spring {} N·s^{{1−μ}}/m\nobject {} kg, {} N·s/m, {} N/m · {}",
            self.order,
            six_digits(self.coupler_stiffness_n_s_per_m),
            six_digits(self.coupler_dissipation_n_s_1_minus_mu_per_m),
            six_digits(object.mass_kg),
            six_digits(object.damping_n_s_per_m),
            six_digits(object.stiffness_n_per_m),
            self.setup.words(self.scheme, &settling)
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
