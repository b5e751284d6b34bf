//! The force at a sensor beside the rendered force and the closed form.
//!
//! ```text
//! rms(a − b) = √(Σ(a − b)²/n)        r = Σ(s − s̄)(f − f̄)/√(Σ(s − s̄)²·Σ(f − f̄)²)        k = √(Σ(s − s̄)²/Σ(f − f̄)²)
//! ```
//! - *Symbols*: s is the sensed force, f the rendered one, both opposed to the indentation, in N; n counts the samples in which no limiter
//!   acted and the sensor gave a force.
//! - *In contact* alone, where a force was rendered, k and r are taken: in the air a sensor shows its drift.
//! - *Wrong sign*: r < −0.5. *Wrong unit*: |r| > 0.5 and k within a factor of 3 of 1000 or of 1/1000. *Drift*: in the air, beyond its noise
//!   and a hundredth of the largest force that was sensed.
//! - *Cost*: some twenty operations a sample.

use haptic_quantity::written;
use haptic_trial::{
    sensor_offset::{OFFSET_SAMPLES, SensorOffset, Tare},
    tick::KeptSample,
};
use serde_json::{Value, json};

/// Share of the largest sensed force up to which a drift is not worth a sentence.
const DRIFT: f64 = 0.01;

/// Root mean square and largest size of a difference, N.
#[derive(Clone, Copy, Debug, Default)]
struct Difference {
    squares: f64,
    largest: f64,
}

impl Difference {
    fn add(&mut self, difference: f64) {
        self.squares += difference * difference;
        self.largest = self.largest.max(difference.abs());
    }
}

/// Sums over a run with a force sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensedForce {
    samples: f64,
    /// Sensed less rendered, sensed less closed form, rendered less closed form.
    differences: [Difference; 3],
    /// There was no closed form in a sample.
    without_closed_form: bool,
    /// Largest size of a sensed force, N.
    largest_n: f64,
    /// Number of samples in contact, and for them the means of sensed and rendered force, squares about them, and products.
    touching: f64,
    means: [f64; 2],
    squares: [f64; 2],
    products: f64,
}

impl SensedForce {
    /// The next sample, with the force that opposes the indentation as it was rendered and in closed form, N.
    pub fn add(&mut self, sample: &KeptSample, rendered_n: f64, closed_form_n: Option<f64>) {
        let Some(sensed_n) = sample.sensed_force_n.filter(|_| sample.is_comparable()) else {
            return;
        };
        self.without_closed_form |= closed_form_n.is_none();
        let closed_form_n = closed_form_n.unwrap_or(f64::NAN);
        let pairs = [
            (sensed_n, rendered_n),
            (sensed_n, closed_form_n),
            (rendered_n, closed_form_n),
        ];
        for (difference, (have, want)) in self.differences.iter_mut().zip(pairs) {
            difference.add(have - want);
        }
        self.samples += 1.0;
        self.largest_n = self.largest_n.max(sensed_n.abs());
        if rendered_n == 0.0 {
            return;
        }
        // B. P. Welford, Technometrics 4 (1962) 419: no difference of large sums.
        self.touching += 1.0;
        let before = [sensed_n - self.means[0], rendered_n - self.means[1]];
        (self.means.iter_mut().zip(before)).for_each(|(mean, off)| *mean += off / self.touching);
        let after = [sensed_n - self.means[0], rendered_n - self.means[1]];
        self.products += before[0] * after[1];
        self.squares = [0, 1].map(|of| self.squares[of] + before[of] * after[of]);
    }

    /// Rows of a report, with the rms and the largest difference of the sensed force from a record, N; empty without a sensor.
    pub fn rows(&self, tare: Tare, from_record: Option<[f64; 2]>) -> Value {
        if self.samples == 0.0 {
            return json!({});
        }
        let of = |difference: Difference| {
            json!({
                "rms_n": (difference.squares / self.samples).sqrt(),
                "largest_n": difference.largest,
            })
        };
        let [rendered, closed_form, rendered_off] = self.differences;
        let of_closed_form = |difference| (!self.without_closed_form).then(|| of(difference));
        let offset_n = match tare.offset {
            SensorOffset::Known(axes) => Some(axes[0]),
            SensorOffset::Measuring | SensorOffset::Touched { .. } => None,
        };
        let [rms, largest] = ["rms_n", "largest_n"];
        let from_record =
            from_record.map(|[rms_n, largest_n]| json!({ rms: rms_n, largest: largest_n }));
        json!({ "sensed": {
            "samples": self.samples,
            // Null if it could not be measured: then nothing was taken off.
            "offset_n": offset_n,
            // Its drift since, in the air; null if the handle was not still there once more.
            "drift_n": tare.drift_n.map(|axes| axes[0]),
            "from_rendered": of(rendered),
            // Null where a force has no closed form.
            "from_closed_form": of_closed_form(closed_form),
            "rendered_from_closed_form": of_closed_form(rendered_off),
            // Null without a record of forces.
            "from_record": from_record,
        }})
    }

    /// Doubts about the sensor, a line each. A simulated rig touches from its first tick on, so no offset is missed there.
    pub fn warnings(&self, tare: Tare, on_device: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.samples == 0.0 {
            return warnings;
        }
        if let SensorOffset::Touched { samples } = tare.offset
            && on_device
        {
            warnings.push(format!(
                "the offset of the force sensor is not known: contact came after {samples} samples, and it is the mean of the first \
                 {OFFSET_SAMPLES} of a still handle in the air; begin outside, and hold it still"
            ));
        }
        let drift = tare
            .drifted_n()
            .filter(|drift_n| drift_n.abs() > DRIFT * self.largest_n);
        warnings.extend(drift.map(|drift_n| {
            format!(
                "the force sensor moved by {} in the air after it was tared: something leaned on it then, or it drifts; let it warm up, and \
                 start again with nothing on it",
                written("force_n", drift_n)
            )
        }));
        let [sensed, rendered] = self.squares.map(f64::sqrt);
        let r = self.products / (sensed * rendered);
        if r < -0.5 {
            warnings.push(format!(
                "the sensed force has the sign opposite to the rendered one (correlation {r:.2} is not in [−0.5, 1]): unless something leaned on it, turn its sign on the board"
            ));
        }
        let size = sensed / rendered;
        for (unit, factor) in [("mN", 1e3), ("kN", 1e-3)] {
            if r.abs() > 0.5 && (1.0 / 3.0..=3.0).contains(&(size / factor)) {
                let deviation = |squares: f64| written("force_n", (squares / self.touching).sqrt());
                let [sensed, rendered] = self.squares.map(deviation);
                warnings.push(format!(
                    "the sensed force varies by {sensed}, the rendered one by {rendered}, not within a factor of 300: it may be in {unit}, \
                     let the board send N"
                ));
            }
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use crate::sensed::*;
    use haptic_message::TickMessage;
    use haptic_trial::tick::KeptSample;
    use proptest::prelude::*;

    fn judged(samples: &[[f64; 3]]) -> SensedForce {
        let mut judge = SensedForce::default();
        for (tick, &[sensed_n, rendered_n, closed_form_n]) in (0..).zip(samples) {
            let message = TickMessage {
                tick,
                sensed_force_n: Some(sensed_n.into()),
                ..TickMessage::at_rest(1)
            };
            judge.add(&KeptSample::of(&message), rendered_n, Some(closed_form_n));
        }
        judge
    }

    proptest! {
        #[test]
        fn differences_are_those_of_their_definition_and_only_a_wrong_sign_or_unit_is_doubted(
            forces in prop::collection::vec((-5.0..5.0_f64, -0.05..0.05_f64, -0.2..0.2_f64), 20..60),
            factor in prop::sample::select(vec![1.0, 0.5, 3.0, -1.0, 1000.0, 1e-3, -1000.0])
        ) {
            prop_assume!(forces.iter().map(|force| force.0.abs()).fold(0.0, f64::max) > 1.0);
            let samples: Vec<[f64; 3]> = forces.iter().map(|(f, noise, off)| [factor * (f + noise), *f, f + off]).collect();
            let judge = judged(&samples);
            let known = Tare::from(SensorOffset::Known([0.25; 3]));
            let rows = judge.rows(known, None);
            let sensed = &rows["sensed"];
            for (name, [have, want]) in [("from_rendered", [0, 1]), ("from_closed_form", [0, 2]), ("rendered_from_closed_form", [1, 2])] {
                let off = samples.iter().map(|sample| sample[have] - sample[want]);
                let rms = (off.clone().map(|off| off * off).sum::<f64>() / samples.len() as f64).sqrt();
                let largest = off.map(f64::abs).fold(0.0, f64::max);
                for (key, value) in [("rms_n", rms), ("largest_n", largest)] {
                    let shown = sensed[name][key].as_f64().expect("a number");
                    prop_assert!((shown - value).abs() <= 1e-9 * value, "{} {}: {} {}", name, key, shown, value);
                }
            }
            let warnings = judge.warnings(known, true);
            let want = usize::from(factor < 0.0) + usize::from(!(0.1..=10.0).contains(&factor.abs()));
            prop_assert_eq!(warnings.len(), want, "{:?}", warnings);
        }
    }

    #[test]
    fn without_a_sensor_there_is_no_row_and_an_offset_that_is_not_known_is_told() {
        let known = Tare::from(SensorOffset::Known([0.0; 3]));
        let mut none = SensedForce::default();
        none.add(&KeptSample::of(&TickMessage::at_rest(1)), 1.0, None);
        assert_eq!(
            (none.rows(known, None), none.warnings(known, true)),
            (json!({}), vec![])
        );
        let touched = Tare::from(SensorOffset::Touched { samples: 12 });
        let judge = judged(&[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]);
        assert_eq!(judge.warnings(touched, false), Vec::<String>::new());
        let warnings = judge.warnings(touched, true);
        assert!(
            warnings.len() == 1 && warnings[0].contains("12 samples"),
            "{warnings:?}"
        );
        assert!(judge.rows(touched, None)["sensed"]["offset_n"].is_null());
    }
}
