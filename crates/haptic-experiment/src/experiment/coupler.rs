//! A fractional virtual coupler, as an experiment: see [`haptic_judge::coupler`].

use super::trial::{Conducted, OfSample, OffN, Trial, conducted, incomparable, law_of, limited};
use fracdiff::Order;
use haptic_document::{Failure, FileError, Table};
pub(crate) use haptic_judge::setup::Beside;
use haptic_judge::{
    coupler::CouplerTrial,
    reference::{ReferenceSeries, ReferenceWeights, operator},
};
use haptic_run::{Ran, remote::RemoteLaw};
use haptic_trial::GuardChoice;

/// A coupler, and how it is run.
pub(crate) type CouplerExperiment = Conducted<CouplerTrial>;

/// `[coupler]`: device, coupler, object and trial, with the table of a second device that pushes.
pub(crate) fn coupler(
    table: &Table<'_>,
    beside: Beside<'_>,
) -> Result<CouplerExperiment, FileError> {
    conducted(table, beside.drive, |at_port| {
        haptic_judge::coupler::coupler(table, beside, at_port)
    })
}

impl Trial for CouplerTrial {
    /// The analysis has its say here on the simulated device alone: a serial one heard it before it was armed.
    fn warning(&self, ran: &Ran) -> Option<String> {
        let analysis = ran.preflight.filter(|_| self.setup.at_port.is_none());
        // Energy bounding promises passivity for the damping of the device.
        let guarded = self.setup.safety.guard == GuardChoice::EnergyBounding;
        analysis.and_then(|analysis| analysis.warning(guarded))
    }

    /// Only a loop on the host carries a coupler: the device renders nothing.
    fn law_there(&self, _: u64) -> Result<RemoteLaw, Failure> {
        Ok(law_of(&self.setup))
    }

    fn object_m(&self, ran: &Ran) -> Result<Option<OfSample<'_>>, Failure> {
        let planned = self.setup.plan().samples(self.setup.device.sample_time)?;
        let samples = ran.samples();
        let mut step = self.replayed(planned)?;
        for sample in &ran.record.approach {
            step(sample.position_m);
        }
        let mut object = ReferenceSeries::stepped(samples, step)?;
        Ok(Some(Box::new(move |sample| object.at(sample))))
    }

    /// The force by the full history of the deflection, which follows from the forces.
    fn off_n(&self, ran: &Ran) -> Result<OffN<'_>, Failure> {
        let record = &ran.record;
        let reference = ReferenceWeights::of(self.scheme);
        let order = Order::new(1.0 - self.order.get()).map_err(Failure::input)?;
        let t = self.setup.device.sample_time;
        let push_n = self.setup.plan.own_push_n().unwrap_or(0.0);
        let serial = self.setup.at_port.is_some();
        let reason = limited(record)
            .or_else(|| {
                (record.dropped > 0).then_some("samples are missing, so the object is not known")
            })
            .or_else(|| {
                serial.then_some("a serial device makes each force some samples after its position")
            })
            .or_else(|| incomparable(reference, order, record));
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        // D^(1−μ) of each deflection.
        let mut derivative: Box<dyn FnMut(f64) -> f64> = match &record.whole {
            Some(whole) => {
                let mut object = Object::default();
                let deflection: Vec<f64> = (whole.iter())
                    .map(|sample| {
                        object.deflection(self, sample.position_m, push_n - sample.force_n)
                    })
                    .collect();
                let values = reference.full_history(order, t, &deflection);
                let mut values = values?.into_iter();
                Box::new(move |_| values.next().unwrap_or(f64::NAN))
            }
            None => {
                let planned = self.setup.plan().samples(t)?;
                let mut channel = operator(reference, order, t, planned)?;
                Box::new(move |y| channel.step(y))
            }
        };
        let (mut object, mut last) = (Object::default(), 0.0);
        Ok(Ok(Box::new(move |sample| {
            let reaction_force_n = sample.reaction_n();
            let y = object.deflection(self, sample.position_m, reaction_force_n);
            // F = k_c·(y[n] − y[n−1])/T + b_c·D^(1−μ) y
            let wanted = self.coupler_damping_n_s_per_m * (y - last) / t.0
                + self.coupler_spring_n_s_1_minus_mu_per_m * derivative(y);
            last = y;
            wanted - reaction_force_n
        })))
    }
}

/// The object by its own equation from the forces that were commanded, and from it the deflection of the coupler: nothing of
/// the coupler that ran is in it.
///
/// ```text
/// m_o > 0:  v ← v + (T/2m_o)(a + a'),  a = F − b_o·v − k_o·p,   p ← p + (T/2)(v + v')
/// m_o = 0:  F = b_o·v + k_o·p;          q = p + (T/2)·v,   y = x − q
/// ```
#[derive(Debug, Default)]
struct Object {
    velocity: f64,
    position: f64,
    net: f64,
}

impl Object {
    /// The deflection after this sample.
    fn deflection(&mut self, law: &CouplerTrial, x: f64, force: f64) -> f64 {
        let (t, object) = (law.setup.device.sample_time.0, law.object);
        let (m, b) = (object.mass_kg, object.damping_n_s_per_m);
        let (k, half) = (object.stiffness_n_per_m, 0.5 * t);
        let ahead = self.position + half * self.velocity;
        let next = if m > 0.0 {
            (self.velocity + half / m * (self.net + force - k * ahead))
                / (1.0 + half / m * (b + half * k))
        } else {
            (force - k * ahead) / (b + half * k)
        };
        self.velocity = next;
        self.position = ahead + half * next;
        self.net = force - b * next - k * self.position;
        x - (self.position + half * next)
    }
}
