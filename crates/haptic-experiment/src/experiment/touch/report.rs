//! Judges a touch: each force against the full history of the depth, and the energy of the hand.

use super::{
    TOUCH_MUST_BE_PASSIVE, TouchExperiment,
    device::{HandEnergy, depth},
    shape::TouchShape,
};
use crate::{
    experiment::trial::{Seen, incomparable},
    judge::{
        Published, origin,
        report::{Files, Report, RunReport, closed_form_error, full_history_error, unmet},
        warnings::Warnings,
    },
};
use haptic_document::{Failure, parameters::SAMPLE_TIME, rows};
use haptic_judge::{
    compared::Compared,
    curves::{Curves, Drawing},
    decimated::Decimated,
    modelled_tissue::effective,
    preflight::Matter,
    reference::ReferenceWeights,
    sensed::SensedForce,
    settling::SATURATED_S,
};
use haptic_log::record::{Entry, LogReader};
use haptic_loop::{Limit, Limiters, LoadingKind};
use haptic_message::{TickMessage, column_name};
use haptic_run::{Ran, record::RunRecord, remote::device_name};
use haptic_tissue::indentation::ting;
use haptic_trial::{
    GuardChoice,
    safety::keys::{GUARD, RISE_TIME},
    sensor_offset::{SensorOffset, Tare},
    tick::{KeptSample, judged_force_n},
};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::TAU;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum TouchVerdict {
    /// The hand was given no energy, and the force stayed within its limits.
    Passive,
    /// The hand was given energy.
    GaveEnergy,
    /// The shape was rendered within its limits, on a device whose hand nobody measures.
    Rendered,
    /// A limiter of the safety chain other than the guard acted for more than 50 ms.
    Saturated,
    /// It did not reach its end.
    Unfinished,
}

impl TouchVerdict {
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Passive => "the hand was given no energy",
            Self::GaveEnergy => "the hand was given energy",
            Self::Rendered => "rendered within limits; the energy given is not measured",
            Self::Saturated => "the force was limited",
            Self::Unfinished => "the run did not finish",
        }
    }
}

/// Curves of a touch: hand and device in the plane, depth, and the force of each axis.
const CURVES: usize = 8;
/// A share of the energy that went through the hand that is rounding.
const ROUNDING: f64 = 1e-9;
/// Largest number of samples of a retraction: Ting's contact costs their square.
const RETRACED: usize = 4000;
/// Points of the outline of a disc.
const OUTLINE: u32 = 180;

impl TouchExperiment {
    pub(super) fn publish<const D: usize>(
        &self,
        ran: Ran,
        energy: Option<HandEnergy>,
        posture: PostureVerdict,
    ) -> Result<Published<Report>, Failure> {
        let record = &ran.record;
        let whole = record.ended.is_none();
        let verdict = self.verdict(record, energy);
        let mut curves = None;
        let mut compared = Compared::without_meaning("the run was cut short");
        let mut retraction = None;
        let files = if whole {
            compared = self.compare::<D>(record)?;
            retraction = self.retraction(record);
            let (files, drawn) = self.draw::<D>(&ran)?;
            curves = Some(self.curves(drawn, origin(record), verdict));
            files
        } else {
            Files::of_run(&ran, None)
        };
        let mut run = RunReport::new(
            &ran,
            device_name(self.conduct.remote.as_ref()),
            self.sample_time().0,
            files,
            self.warnings(&ran, verdict, energy),
        );
        if let Matter::Tissue(piece) = &self.matter {
            let times_s = (self.sample_time().0, record.duration_s());
            run.warnings
                .extend(piece.leaves(times_s, record.farthest_m()));
        }
        let kept = record.whole.as_deref().unwrap_or_default();
        let (sensed, doubts) = sensed_rows(kept, record.sensor);
        run.warnings.extend(doubts);
        let law = json!({
            "axes": D,
            "shape": self.shape.words(),
            "matter": self.matter.words(),
            "order": self.look(0).order.get(),
            "scheme": self.scheme.to_string(),
        });
        let no_closed_form =
            Compared::without_meaning("there is no closed form while the hand moves");
        let results = json!({
            // Of a sphere or cone that is pulled back: the largest difference of the force from T. C. T. Ting's contact, which shrinks, as a
            // share of the largest force, up to where the contact grows again. The loop renders Lee and Radok's contact, which grows.
            "retraction_error": retraction.map(|of| of.0),
            "retraction_samples": retraction.map_or(0, |of| of.1),
            "verdict": verdict,
            "verdict_reason": verdict.words(),
            "largest_depth_m": record.farthest_m(),
            // Energy that the hand was given in all, negative if it gave more, and the most at any time; null where nobody measures the hand.
            "given_j": energy.map(|energy| energy.given_j),
            "given_most_j": energy.map(|energy| energy.most_j),
        });
        let off_law = run.hold_to_law(compared.largest, self.scheme);
        let broken = self.must_be_passive && verdict != TouchVerdict::Passive;
        let remedy = "use a softer shape, a shorter sample time or a guard";
        let report = Report {
            law: rows([law]),
            run,
            results: rows([
                full_history_error(&compared),
                closed_form_error(&no_closed_form),
                results,
                json!(posture),
                sensed,
            ]),
            verdict: Some(verdict.words().to_owned()),
            unmet: off_law
                .or_else(|| broken.then(|| unmet(&TOUCH_MUST_BE_PASSIVE, verdict.words(), remedy))),
        };
        Ok(Published::new(report, curves, ran))
    }

    fn verdict(&self, record: &RunRecord, energy: Option<HandEnergy>) -> TouchVerdict {
        // A guard is a limiter too, and there to act, as is the start ramp of a device; the limit of the force is not.
        let limited = match (self.safety.guard, &self.conduct.remote) {
            (GuardChoice::Off, None) => record.limited,
            _ => self.at_limit(record),
        };
        let limited_s = limited as f64 * self.sample_time().0;
        if record.ended.is_some() {
            TouchVerdict::Unfinished
        } else if energy.is_some_and(|energy| energy.most_j > ROUNDING * energy.moved_j) {
            TouchVerdict::GaveEnergy
        } else if limited_s > SATURATED_S {
            TouchVerdict::Saturated
        } else if energy.is_none() {
            TouchVerdict::Rendered
        } else {
            TouchVerdict::Passive
        }
    }

    /// Samples whose force is as large as it may be.
    fn at_limit(&self, record: &RunRecord) -> u64 {
        let most = (1.0 - ROUNDING) * self.force_limit_n;
        // A device may have a lower limit, and rounds to single precision.
        let at_limit = |sample: &&KeptSample| {
            sample.force_n.abs() >= most || sample.limiters & Limiters::MAGNITUDE.bits() != 0
        };
        record.whole.iter().flatten().filter(at_limit).count() as u64
    }

    fn warnings(&self, ran: &Ran, verdict: TouchVerdict, energy: Option<HandEnergy>) -> Warnings {
        let mut warnings = Warnings::default();
        let guarded = self.safety.guard == GuardChoice::EnergyBounding;
        let analysis = ran.preflight.as_ref();
        // A device's analysis was reported before the run.
        let analysis = analysis.filter(|_| self.conduct.remote.is_none());
        (warnings.0).extend(analysis.and_then(|verdict| verdict.warning(guarded)));
        // The start ramp of a device is not the shape's.
        let may_rise_s = (self.conduct.remote.as_ref()).map_or(0.0, |_| f64::INFINITY);
        warnings.limited_after(&ran.record, may_rise_s);
        if let (TouchVerdict::GaveEnergy, Some(energy)) = (verdict, energy) {
            let remedy = if self.risen_j(&ran.record) > 0.5 * energy.most_j {
                &format!(
                    "the shape grew stiff while it was pressed: use a shorter {RISE_TIME}, or let the hand touch after it"
                )
            } else {
                &format!("use a softer K and less B, a shorter {SAMPLE_TIME}, or a {GUARD}")
            };
            warnings.0.push(format!(
                "the hand was given {:.3e} J more than it gave: {remedy}",
                energy.most_j
            ));
        }
        warnings
    }

    /// Energy that came in because the force rose from the start on while the device was inside, J.
    ///
    /// ```text
    /// E = ½·Σ f·x·Δs,   s the share of the force that is used, from 0 to 1 in the rise time, f the force for s = 1
    /// ```
    fn risen_j(&self, record: &RunRecord) -> f64 {
        let Some(rise_s) = self.safety.number(Limit::RiseTime) else {
            return 0.0;
        };
        let step = self.sample_time().0 / rise_s;
        let samples = record.whole.iter().flatten();
        let rising = samples.take_while(|sample| sample.time_s < rise_s);
        let stiffness = self.look(0).stiffness_n_per_m;
        let effective = effective(self.matter.depth_map());
        let energies = rising.map(|sample| {
            let share = (sample.time_s / rise_s).max(step);
            // A force held at a place exceeds that of its spring if the law remembers the way there.
            // A map is convex, so the spring takes less than half of force times way.
            let spring = stiffness * effective(sample.position_m);
            let force = (sample.reaction_n() / share).max(spring);
            0.5 * force * sample.position_m * step
        });
        energies.sum()
    }

    /// The force that the full history of the depth asks for, at least 0, N: next to the centre of a ball as much of it as the normal is
    /// long.
    fn full_history<const D: usize>(&self, depths: &[f64]) -> Result<Vec<f64>, Failure> {
        let shape = self.shape.of::<D>()?;
        let look = self.look(depths.len() as u64);
        let (k, b) = (look.stiffness_n_per_m, look.dissipation_n_s_mu_per_m);
        let effective = effective(self.matter.depth_map());
        let rates = look.felt(&depths.iter().copied().map(&effective).collect::<Vec<f64>>())?;
        let force = depths.iter().zip(rates).map(|(p, rate)| {
            // Outside nothing pushes, inside nothing pulls.
            if *p > 0.0 {
                shape.normal_length(*p) * (k * effective(*p) + b * rate).max(0.0)
            } else {
                0.0
            }
        });
        Ok(force.collect())
    }

    /// The force of the first touch against Ting's contact, and over how many samples, see `retraction_error`.
    fn retraction(&self, record: &RunRecord) -> Option<(f64, usize)> {
        let Matter::Tissue(piece) = &self.matter else {
            return None;
        };
        let kind = piece.specimen.loading().kind;
        let indents = matches!(kind, LoadingKind::Sphere | LoadingKind::Cone);
        let map = piece.specimen.depth_map().filter(|_| indents)?;
        let samples = record.whole.as_deref()?;
        let thin = samples.len() / RETRACED + 1;
        let samples: Vec<&KeptSample> = samples.iter().step_by(thin).collect();
        let times: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
        let depths: Vec<f64> = samples.iter().map(|sample| sample.position_m).collect();
        let theory = ting(&piece.material.model, Some(&map), &times, &depths);
        let pairs = samples.iter().zip(&theory.force_per_shape);
        let shape = piece.shape_m();
        let error = (pairs.skip(theory.shrinks_from))
            .map(|(sample, force)| (sample.reaction_n() - shape * force).abs())
            .reduce(f64::max)?;
        let share = Some(error / record.largest_force_n()).filter(|error| error.is_finite())?;
        Some((share, theory.force_per_shape.len() - theory.shrinks_from))
    }

    /// The commanded force against the full history of what was read.
    fn compare<const D: usize>(&self, record: &RunRecord) -> Result<Compared, Failure> {
        let reference = ReferenceWeights::of(self.scheme);
        let samples: &[KeptSample] = record.whole.as_deref().unwrap_or_default();
        let missing = samples
            .windows(2)
            .any(|pair| pair[1].tick != pair[0].tick + 1);
        let reason = missing.then_some("samples did not come");
        let look = self.look(0);
        let reason = reason.or_else(|| match look.model {
            Some(_) => None,
            None => incomparable(reference, look.order, record),
        });
        let reason = match reason {
            _ if record.largest_force_n() == 0.0 => Some("no force was commanded"),
            reason => reason,
        };
        if let Some(reason) = reason {
            return Ok(Compared::without_meaning(reason));
        }
        let depths: Vec<f64> = samples.iter().map(|sample| sample.position_m).collect();
        let wanted = self.full_history::<D>(&depths)?;
        let mut seen = Seen::default();
        for (sample, wanted) in samples.iter().zip(&wanted) {
            seen.add(sample, (sample.reaction_n() - wanted).abs());
        }
        Ok(seen.over(record))
    }

    /// Writes the table of the log, and keeps what is to be drawn.
    fn draw<const D: usize>(&self, ran: &Ran) -> Result<(Files, Decimated<CURVES>), Failure> {
        let shape = self.shape.of::<D>()?;
        let fields = ["reference_m", "position_m", "force_n"];
        let columns = fields
            .iter()
            .flat_map(|field| (0..D).map(|axis| column_name(field, axis, D)));
        let columns: Vec<String> = columns.collect();
        let mut header = vec!["time_s"];
        header.extend(columns.iter().map(String::as_str));
        header.push("depth_m");
        let mut table = ran.folder.named_table_beside_log("csv", &header);
        let mut curves = Decimated::kept(ran.record.whole.is_some());
        // The way of the force to zero is no part of the result.
        let last = ran.record.last.map_or(0, |last| last.tick);
        for log in &ran.log.paths {
            for entry in LogReader::open(log)? {
                let Entry::Tick(tick) = entry? else {
                    continue;
                };
                if tick.tick > last {
                    continue;
                }
                let depth_m = depth(&shape, &tick.position_m);
                let mut row = vec![tick.time_s];
                for vector in [tick.reference_m, tick.position_m, judged_force_n(&tick)] {
                    row.extend_from_slice(&vector);
                }
                row.push(depth_m);
                table.row(row);
                curves.add(tick.time_s, drawn(&tick, depth_m));
            }
        }
        Ok((Files::of_run(ran, Some(table)), curves))
    }

    fn curves(
        &self,
        curves: Decimated<CURVES>,
        origin: &'static str,
        verdict: TouchVerdict,
    ) -> Curves {
        let hand = match &self.conduct.remote {
            Some(_) => format!("device {}", device_name(self.conduct.remote.as_ref())),
            None => self.path.words(),
        };
        let subtitle = format!(
            "{} · {} · scheme {} · {hand} · {}",
            self.shape.words(),
            self.matter.words(),
            self.scheme,
            verdict.words()
        );
        let third = if self.axes == 3 { "force_z_n" } else { "" };
        let names = [
            "hand_x_m",
            "hand_y_m",
            "x_m",
            "y_m",
            "depth_m",
            "force_x_n",
            "force_y_n",
            third,
        ];
        let title = format!("A touch, {origin}");
        let outline_m = self.outline();
        curves.named(names, origin, title, subtitle, Drawing::Plane { outline_m })
    }

    /// Outline of a ball in the plane of the first two axes, through its centre.
    fn outline(&self) -> Vec<(f64, f64)> {
        let TouchShape::Ball(ball) = &self.shape else {
            return Vec::new();
        };
        let point = |n: u32| {
            let angle = TAU * f64::from(n) / f64::from(OUTLINE);
            let [x, y] = [ball.centre_m[0], ball.centre_m[1]];
            (
                x + ball.radius_m * libm::cos(angle),
                y + ball.radius_m * libm::sin(angle),
            )
        };
        (0..=OUTLINE).map(point).collect()
    }
}

/// Rows and doubts of a force sensor; none without one. Along the rendered force there is a sign to compare.
fn sensed_rows(samples: &[KeptSample], tare: Tare) -> (Value, Vec<String>) {
    let (mut sensed, mut partial) = (SensedForce::default(), false);
    for sample in samples {
        match sample.sensed_force_n {
            Some(force_n) if force_n.is_nan() => partial = true,
            Some(_) | None => sensed.add(sample, sample.reaction_n(), None),
        }
    }
    let rows = sensed.rows(tare, None);
    let is_unread = partial && rows == json!({}) && matches!(tare.offset, SensorOffset::Known(_));
    let doubts = if is_unread {
        vec![
        "the force sensor reads some axes alone, and a force along the normal needs all: compare both in the log, axis by axis".to_owned(),
    ]
    } else {
        sensed.warnings(tare, true)
    };
    (rows, doubts)
}

/// The values of a tick that are drawn.
fn drawn(tick: &TickMessage, depth_m: f64) -> [f64; CURVES] {
    let axis = |vector: &[f64], axis: usize| vector.get(axis).copied().unwrap_or(0.0);
    let (hand, position, force) = (&tick.reference_m, &tick.position_m, &judged_force_n(tick));
    [
        axis(hand, 0),
        axis(hand, 1),
        axis(position, 0),
        axis(position, 1),
        depth_m,
        axis(force, 0),
        axis(force, 1),
        axis(force, 2),
    ]
}

/// Mass that is felt along the normal, in the postures that come up, and the worst of them.
#[derive(Debug, Serialize)]
pub(crate) struct PostureVerdict {
    /// Least 1/(nᵀ M⁻¹ n), kg.
    pub effective_mass_least_kg: f64,
    pub effective_mass_most_kg: f64,
    /// The mass that the pre-flight reports, kg: an unstable one if there is one, else the one with
    /// the smaller margin.
    pub judged_mass_kg: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::touch::device::TouchTick;
    use haptic_message::PerAxis;
    use haptic_trial::tick::TickRecord as _;

    /// Sample with a force of 5 N that pushes the hand out along (−3, −4)/5.
    fn kept(sensed_n: [f64; 2]) -> KeptSample {
        let plane = TouchShape::Plane {
            normal: vec![3.0, 4.0],
            surface_m: 0.0,
        };
        let mut tick = TouchTick::<2>::unknown(plane.of().expect("a plane"));
        *tick.logged_mut() = TickMessage {
            commanded_force_n: PerAxis::new(&[-3.0, -4.0]),
            sensed_force_n: Some(PerAxis::new(&sensed_n)),
            ..TickMessage::unknown(2)
        };
        tick.kept()
    }

    #[test]
    fn a_sensed_vector_is_compared_along_the_rendered_one_and_a_sensor_of_one_axis_is_named() {
        let known = Tare::from(SensorOffset::Known([0.0; 3]));
        // Across the force nothing counts, along it 0.5 N are too much.
        let (rows, doubts) = sensed_rows(&[kept([3.0 - 4.0 + 0.3, 4.0 + 3.0 + 0.4])], known);
        let off_n = rows["sensed"]["from_rendered"]["largest_n"].as_f64();
        assert!((off_n.expect("a number") - 0.5).abs() < 1e-12, "{rows}");
        assert!(doubts.is_empty());
        let (rows, doubts) = sensed_rows(&[kept([3.0, f64::NAN])], known);
        assert_eq!((rows, doubts.len()), (json!({}), 1));
        assert!(doubts[0].contains("some axes alone"), "{doubts:?}");
    }
}
