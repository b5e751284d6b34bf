//! The record of a press: depth, and the force of the specimen as far as the device knows it.
//!
//! ```text
//! motor    F = ⟨u⟩ − m·⟨x''⟩ − b·⟨x'⟩ − F_c·⟨s⟩      δ = ⟨x⟩      ⟨y⟩ the mean of y under a triangle of SIDE samples to each side
//!          ⟨x''⟩ = (x₊ − 2x + x₋)/h²                 ⟨x'⟩ = (∫₊x − ∫₋x)/h²,   h the time of SIDE samples
//! sensor   F = sensed, less the drift of its zero
//! ```
//! - *Triangle*: the second difference is the mean of the acceleration under it, so force and depth are averaged alike; a specimen whose force is
//!   linear in the depth keeps its law, and the corners of a ramp leave no peak.
//! - *Drift*: where the handle rested in the air once more behind the press, what the sensor showed there grew evenly from the rest before.
//! - *Friction*: s is the way that the handle really slid, however slowly; while it sticks s goes evenly from one to the other.
//! - *Left*: a specimen cannot pull. Where a handle that slides back finds no force, it has left it, and nothing later is of the specimen.
//! - *Doubts*: friction of a handle that sticks or turns is any share of its size, and few samples of it are compared; friction on the move, mass and
//!   damping lie within the intervals of the device file. Each is a column beside the force, over its noise, with a share of deviation 1.

use super::{
    Press,
    doubts::{back_m, known, slides},
};
use crate::experiment::kind::Experiment as _;
use haptic_quantity::written;
use haptic_trial::{sensor_offset::OFFSET_SAMPLES, tick::KeptSample};
use measured_table::{Column, Columns};
use tissue_identification::{Record, sensor_noise, white_noise};

/// Share of the largest force by which the zero of a sensor may have moved.
const MOVED_MOST: f64 = 0.05;
/// Share of the largest force by which sensor and motor may be apart beside friction.
const APART_MOST: f64 = 0.1;

/// Depths and forces of a press.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressRecord {
    /// Time since the end of the rest, s.
    pub time_s: Vec<f64>,
    /// Depth in the specimen, m.
    pub depth_m: Vec<f64>,
    /// Force on the specimen, N.
    pub force_n: Vec<f64>,
    /// Columns of the force that friction, mass and damping leave open, see [`Record::with_doubts`](tissue_identification::Record::with_doubts).
    pub doubts: Vec<Vec<f64>>,
    /// Samples in which the motor knows the force, by how the handle slides; `None` for all.
    pub known: Option<Vec<usize>>,
    /// Least and largest lag of the sensor, s; `None` without one.
    pub lag_s: Option<[f64; 2]>,
    /// That of the motor, N: the likeliest too where no sensor measured it.
    pub motor_n: Vec<f64>,
    /// Number of samples of the first ramp.
    pub ramp_samples: usize,
    /// Number of samples until the handle left the specimen; `None` if it never did.
    pub left: Option<usize>,
    /// Friction of the device, N.
    pub friction_n: f64,
    /// True if a sensor measured it.
    pub is_sensed: bool,
    /// Force by which the zero of the sensor moved from the rest before to that behind the press, N, where it is known.
    pub zero_moved_n: Option<f64>,
}

impl PressRecord {
    /// Its table, as an instrument would have written it.
    #[must_use]
    pub fn columns(&self) -> Columns {
        let [source, open] = if self.is_sensed {
            ["that of the sensor", "the lag of the sensor"]
        } else {
            [
                "the motor's, less friction, inertia and damping of the device",
                "friction, mass and damping",
            ]
        };
        let columns = [
            (Column::Time, "time_s", &self.time_s),
            (Column::Position, "position_m", &self.depth_m),
            (Column::Force, "force_n", &self.force_n),
        ];
        let pressed = self.left.unwrap_or(self.time_s.len());
        let values =
            columns.map(|(column, name, all)| (column, name.to_owned(), all[..pressed].to_vec()));
        let left = self.has_left();
        let left = left.map(|left| format!("{left}: what is later is left out"));
        let notes = [
            format!("the force is {source}"),
            format!(
                "what {open} may do to the force is in the choice of the model and in the intervals"
            ),
        ];
        Columns {
            values: values.into(),
            notes: notes.into_iter().chain(left).collect(),
            ..Columns::default()
        }
    }

    /// The record with what its instrument leaves open.
    #[must_use]
    pub fn with_doubts(&self, record: Record) -> Record {
        record.with_doubts(self.doubts.clone(), self.lag_s, self.known.as_deref())
    }

    /// A handle that left its specimen, in words.
    pub(super) fn has_left(&self) -> Option<String> {
        let since_s = self.time_s[self.left?] - self.time_s[0];
        Some(format!(
            "the handle left the specimen, which cannot pull it, {} after it began to press",
            written("time_s", since_s)
        ))
    }

    /// The sample in which a handle slides back by so much and there is no force beyond this noise, less a time that covers any lag of a sensor.
    fn left(&self, back_m: f64, noise_n: f64) -> Option<usize> {
        const BACK: usize = 100;
        const LATE: usize = 20;
        let last = self.force_n.len().saturating_sub(SIDE);
        let left = (self.ramp_samples.max(BACK)..last).find(|&n| {
            let near = &self.force_n[n - SIDE..=n + SIDE];
            let before = self.depth_m[n - BACK..n].iter();
            near.iter().sum::<f64>() < noise_n * near.len() as f64
                && before.fold(0.0, |far: f64, place| far.max(*place)) > self.depth_m[n] + back_m
        });
        left.map(|n| n - LATE)
    }

    /// Noise of the force, N.
    pub(super) fn noise_n(&self) -> f64 {
        if self.is_sensed {
            sensor_noise(&self.force_n)
        } else {
            white_noise(&self.force_n)
        }
    }

    /// Largest force on the specimen but for its noise, N.
    #[must_use]
    pub fn peak_n(&self) -> f64 {
        let means = self.force_n.windows(2 * SIDE + 1);
        let means = means.map(|some| (some.iter().sum::<f64>() / some.len() as f64).abs());
        means.fold(0.0, f64::max)
    }

    /// A sensor whose zero is not what it was when it was tared, in a sentence: by what it shows behind the press, and by the motor.
    ///
    /// # Errors
    /// If it moved by more than a twentieth of the largest force; if it differs from the motor at the end of a hold as friction cannot make it
    /// that differs by less on the ramp, whatever the gain of the motor.
    pub fn check_zero(&self) -> Result<(), String> {
        let peak_n = self.peak_n();
        let why = if let Some(moved_n) = self
            .zero_moved_n
            .filter(|moved_n| moved_n.abs() > MOVED_MOST * peak_n)
        {
            format!(
                "the zero of the force sensor moved by {}, more than {MOVED_MOST} of the largest force of {}",
                written("force_n", moved_n),
                written("force_n", peak_n)
            )
        } else if let Some([ramp_n, hold_n]) = self.against_motor().filter(|_| self.is_sensed)
            && hold_n.abs() > ramp_n.abs() + self.friction_n + APART_MOST * peak_n
        {
            format!(
                "the force sensor is off the motor by {} in the hold and by {} on the ramp, and friction is as large in both",
                written("force_n", hold_n),
                written("force_n", ramp_n)
            )
        } else {
            return Ok(());
        };
        Err(format!(
            "{why}: something leaned on it while it was tared, or it drifts: take that away, let it warm up, and press again"
        ))
    }

    /// Force of the sensor beyond that of the motor, N, on the first ramp and at the end: by the straight line through both on the ramp, which knows
    /// gain and friction of the motor. `None` if the ramp is too short, or its force too small to tell a gain.
    fn against_motor(&self) -> Option<[f64; 2]> {
        /// Samples of a ramp, and part of the samples at the end.
        const LEAST: usize = 20;
        const LAST: usize = 10;
        let ramp = self.ramp_samples.min(self.motor_n.len());
        // At first friction holds the handle.
        let [x, y] = [&self.motor_n, &self.force_n].map(|values| &values[ramp / 2..ramp]);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (mean_x, mean_y) = (mean(x), mean(y));
        let square = x.iter().map(|a| (a - mean_x) * (a - mean_x)).sum::<f64>();
        let both = x.iter().zip(y).map(|(a, b)| (a - mean_x) * (b - mean_y));
        let is_seen = (2.0 * square / ramp as f64).sqrt() > MOVED_MOST * self.peak_n();
        let gain = both.sum::<f64>() / square;
        let last = self.force_n.len() - self.force_n.len() / LAST..;
        let hold = mean(&self.force_n[last.clone()]) - gain * mean(&self.motor_n[last]);
        (ramp >= LEAST && is_seen && gain > 0.0).then_some([mean_y - gain * mean_x, hold])
    }
}

/// Times its noise that a force has to be for its end to be seen.
const SEEN: f64 = 10.0;
/// Share of the largest force below which a noise is not believed.
const EXACT: f64 = 5e-4;
/// Samples to each side of a difference: so many that a step of an encoder is no force, so few that a corner of the path stays one.
const SIDE: usize = 3;

/// The mean under a triangle around a sample of what neighbours are.
fn mean(at: impl Fn(isize) -> f64) -> f64 {
    let side = SIDE as isize;
    let parts = (1 - side..side).map(|n| (side - n.abs()) as f64 * at(n));
    parts.sum::<f64>() / (SIDE * SIDE) as f64
}

impl Press {
    /// The record of these samples.
    pub(crate) fn record(&self, samples: &[KeptSample]) -> PressRecord {
        let begins = samples.partition_point(|sample| sample.time_s < self.path.rest_s);
        let ends = samples.partition_point(|sample| sample.time_s < self.path.pressed_s());
        let pressed = begins.min(ends)..ends;
        let is_sensed = samples[pressed.clone()]
            .iter()
            .all(|sample| sample.sensed_force_n.is_some());
        let zero_moved_n = self.zero_moved_n(samples).filter(|_| is_sensed);
        let mut record = PressRecord {
            is_sensed,
            zero_moved_n,
            lag_s: is_sensed.then_some(self.lag_s),
            friction_n: self.device.friction.0,
            ..PressRecord::default()
        };
        let (whole_s, t, device) = (self.path.duration_s(), self.sample_time_s(), &self.device);
        let moved_n = zero_moved_n.unwrap_or(0.0);
        let mut doubts = vec![Vec::new(); 3];
        let places: Vec<f64> = samples[pressed.clone()]
            .iter()
            .map(|sample| sample.position_m)
            .collect();
        let back_m = back_m(self.sensors.deviation_m());
        let (shares, unseen) = slides(&places, back_m);
        for (n, moves) in pressed.zip(shares) {
            let sample = &samples[n];
            let near = neighbours(samples, n);
            let [made_n, acceleration, speed] =
                near.map_or([sample.applied_force_n, 0.0, 0.0], |near| motion(near, t));
            let motor_n = made_n
                - device.mass.0 * acceleration
                - device.damping.0 * speed
                - device.friction.0 * moves;
            let force_n = match sample.sensed_force_n.filter(|_| is_sensed) {
                Some(sensed_n) => moved_n * sample.time_s / whole_s - sensed_n,
                None => motor_n,
            };
            let place_m = match near.filter(|_| !is_sensed) {
                Some(near) => mean(|by| near[SIDE.saturating_add_signed(by)].position_m),
                None => sample.position_m,
            };
            let bent_m = (self.frame_n_per_m).map_or(0.0, |frame| force_n / frame);
            record.time_s.push(sample.time_s);
            record.depth_m.push(place_m - bent_m);
            record.motor_n.push(motor_n);
            record.force_n.push(force_n);
            let open = [
                self.open.friction_n * moves,
                self.open.mass_kg * acceleration,
                self.open.damping_n_s_per_m * speed,
            ];
            (doubts.iter_mut().zip(open)).for_each(|(column, open)| column.push(open));
        }
        let ramp = (record.time_s.iter()).take_while(|time_s| !self.path.at(**time_s).held);
        record.ramp_samples = ramp.count();
        let mut noise_n = record.noise_n().max(EXACT * record.peak_n());
        if is_sensed {
            // Both zeros are means of readings with its noise, and behind the press friction may hold the handle in the specimen.
            let mean = 1.0 / f64::from(OFFSET_SAMPLES).sqrt();
            let drift = libm::hypot(2.0_f64.sqrt() * mean, moved_n / noise_n) / whole_s;
            let drift = record.time_s.iter().map(|time_s| drift * time_s);
            record.doubts = vec![vec![mean; record.time_s.len()], drift.collect()];
        } else {
            if record.friction_n > 0.0 {
                let (known, open) = known(&record.time_s, &unseen, record.friction_n);
                doubts.extend(open);
                record.known = Some(known);
            }
            // Apart, since neighbours share samples; what sticks has no noise.
            let slides = |n: &usize| !unseen.iter().any(|some| some.contains(n));
            let apart = (0..record.force_n.len()).filter(slides).step_by(2 * SIDE);
            let apart: Vec<f64> = apart.map(|n| record.force_n[n]).collect();
            noise_n = noise_n.max(white_noise(&apart));
            doubts.retain(|column| column.iter().any(|open| *open != 0.0));
            doubts
                .iter_mut()
                .flatten()
                .for_each(|open| *open /= noise_n);
            record.doubts = doubts;
        }
        if record.peak_n() > SEEN * noise_n {
            record.left = record.left(back_m, noise_n);
        }
        record
    }

    /// Force that the sensor shows in the air behind the press, N, by its last readings.
    fn zero_moved_n(&self, samples: &[KeptSample]) -> Option<f64> {
        let back_s = self.path.back_s?;
        let rests_s = self.path.pressed_s() + back_s;
        let begins = samples.partition_point(|sample| sample.time_s < rests_s);
        let ends = samples.partition_point(|sample| sample.time_s < self.path.duration_s());
        let last = samples.get(ends.checked_sub(OFFSET_SAMPLES as usize)?.max(begins)..ends)?;
        if last.len() < OFFSET_SAMPLES as usize {
            return None;
        }
        let shown = last.iter().map(|sample| sample.sensed_force_n);
        Some(shown.sum::<Option<f64>>()? / last.len() as f64)
    }
}

/// Force that the motor made, N, acceleration, m/s², and speed, m/s, as means of these neighbours.
fn motion(near: &[KeptSample], t: f64) -> [f64; 3] {
    let square = (SIDE * SIDE) as f64;
    // A force is held until the next one: each holds over a step of the triangle.
    let made_n = (0..SIDE).map(|k| {
        let share = (SIDE - k) as f64 - 0.5;
        share * (near[SIDE + k].applied_force_n + near[SIDE - 1 - k].applied_force_n)
    });
    let place_m = |k: usize| near[k].position_m;
    let [before, now, after] = [place_m(0), place_m(SIDE), place_m(2 * SIDE)];
    let sides = (1..SIDE).map(|k| place_m(SIDE + k) - place_m(SIDE - k));
    let way = sides.sum::<f64>() + 0.5 * (after - before);
    [
        made_n.sum::<f64>() / square,
        (after - 2.0 * now + before) / (square * t * t),
        way / (square * t),
    ]
}

/// The samples that a mean around this one is of.
fn neighbours(samples: &[KeptSample], n: usize) -> Option<&[KeptSample]> {
    samples.get(n.checked_sub(SIDE)?..=n + SIDE)
}
