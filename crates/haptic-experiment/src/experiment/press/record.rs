//! The record of a press: depth, and the force of the specimen as far as the device knows it.

use super::Press;
use crate::document::parameters::{DAMPING, FRICTION, MASS, Parameter};
use crate::experiment::drive::Motion;
use crate::run::plant_file::Interval;
use crate::run::tick::KeptSample;
use haptic_loop::plant::MassDamperConfig;
use measured_table::{Column, Columns};

/// Shares of friction at the beginning and at the end of a hold, of which nobody knows more than their size.
const FRICTIONS: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];

/// A device that the motor may have moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct PossibleDevice {
    mass_kg: f64,
    damping_n_s_per_m: f64,
    /// Friction at the beginning and at the end of a hold, N.
    friction_n: [f64; 2],
}

impl PossibleDevice {
    /// The likeliest, with no friction in a hold; then those that differ in friction, mass or damping, as far as its file leaves them open.
    pub(super) fn all(device: &MassDamperConfig, intervals: &[Interval]) -> Vec<Self> {
        let ends = |parameter: Parameter, value: f64| {
            let mut found = intervals.iter().filter(|ends| ends.key == parameter.key);
            let found = found.find(|ends| (ends.low..=ends.high).contains(&value));
            found.map(|ends| [ends.low, ends.high])
        };
        let (mass_kg, damping) = (device.mass.0, device.damping.0);
        let friction_n =
            ends(FRICTION, device.friction.0).map_or(device.friction.0, |ends| ends[1]);
        let likeliest = Self {
            mass_kg,
            damping_n_s_per_m: damping,
            friction_n: [0.0; 2],
        };
        let rubbing = FRICTIONS.iter().filter(|_| friction_n > 0.0);
        let rubbing = rubbing.map(|shares| Self {
            friction_n: shares.map(|share| share * friction_n),
            ..likeliest
        });
        let heavy = ends(MASS, mass_kg).into_iter().flatten();
        let heavy = heavy.map(|mass_kg| Self {
            mass_kg,
            ..likeliest
        });
        let damped = ends(DAMPING, damping).into_iter().flatten();
        let damped = damped.map(|damping_n_s_per_m| Self {
            damping_n_s_per_m,
            ..likeliest
        });
        let others = rubbing.chain(heavy).chain(damped);
        [likeliest].into_iter().chain(others).collect()
    }
}

/// Samples by which the filter of a sensor may show its force later, if nothing is known of it.
const LAGS: usize = 2;

/// Depths and forces of a press.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressRecord {
    /// From the end of the rest on, s.
    pub time_s: Vec<f64>,
    /// Depth in the specimen, m.
    pub depth_m: Vec<f64>,
    /// Force on the specimen, N: the likeliest first, then what friction, mass and damping or the lag of a sensor may make of it.
    pub forces_n: Vec<Vec<f64>>,
    /// That of the motor, N: the likeliest too where no sensor measured it.
    pub motor_n: Vec<f64>,
    /// True if a sensor measured it.
    pub is_sensed: bool,
}

impl PressRecord {
    /// A table for each force, as an instrument would have written it.
    pub fn columns(&self) -> impl Iterator<Item = Columns> {
        let source = match self.is_sensed {
            true => "the force is that of the sensor",
            false => "the force is the motor's, less friction, inertia and damping of the device",
        };
        self.forces_n.iter().map(move |force_n| {
            let columns = [
                (Column::Time, "time_s", &self.time_s),
                (Column::Position, "position_m", &self.depth_m),
                (Column::Force, "force_n", force_n),
            ];
            let columns =
                columns.map(|(column, name, values)| (column, name.to_owned(), values.clone()));
            Columns {
                values: columns.into(),
                notes: vec![source.to_owned()],
                ..Columns::default()
            }
        })
    }
}

/// Samples to each side of a difference: so many that a step of an encoder is no force, so few that a corner of the path stays one.
const SIDE: usize = 3;

impl Press {
    /// The record of these samples.
    pub(crate) fn record(&self, samples: &[KeptSample]) -> PressRecord {
        let begins = samples.partition_point(|sample| self.path.rests(sample.time_s));
        let is_sensed = samples[begins..]
            .iter()
            .all(|sample| sample.sensed_force_n.is_some());
        let doubts = match is_sensed {
            true => 1 + LAGS,
            false => self.possible.len(),
        };
        let mut record = PressRecord {
            is_sensed,
            forces_n: vec![Vec::new(); doubts],
            ..PressRecord::default()
        };
        let sensed = |n: usize| samples[n].sensed_force_n;
        for (n, sample) in samples.iter().enumerate().skip(begins) {
            let motor_n = |doubt: usize| {
                let device = &self.possible[doubt];
                self.force_n(samples, n, device) - self.friction_n(sample.time_s, device.friction_n)
            };
            let force_n = |doubt: usize| match is_sensed {
                true => 0.0 - sensed((n + doubt).min(samples.len() - 1)).unwrap_or(f64::NAN),
                false => motor_n(doubt),
            };
            let bent_m = (self.frame_n_per_m).map_or(0.0, |frame| force_n(0) / frame);
            record.time_s.push(sample.time_s);
            record.depth_m.push(sample.position_m - bent_m);
            record.motor_n.push(motor_n(0));
            for (doubt, forces) in record.forces_n.iter_mut().enumerate() {
                forces.push(force_n(doubt));
            }
        }
        record
    }

    /// Force of the motor that is left for specimen and friction, N: u − m·x'' − b·x'. A force that is held has acted on both sides of a sample.
    fn force_n(&self, samples: &[KeptSample], n: usize, device: &PossibleDevice) -> f64 {
        let made = |n: usize| samples[n].applied_force_n;
        let made_n = 0.5 * (made(n) + made(n.saturating_sub(1)));
        let (Some(before), Some(after)) = (n.checked_sub(SIDE), samples.get(n + SIDE)) else {
            return made_n;
        };
        let (before, now) = (&samples[before], &samples[n]);
        let side_s = 0.5 * (after.time_s - before.time_s);
        let speed = 0.5 * (after.position_m - before.position_m) / side_s;
        let bend = after.position_m - 2.0 * now.position_m + before.position_m;
        let acceleration = bend / (side_s * side_s);
        made_n - device.mass_kg * acceleration - device.damping_n_s_per_m * speed
    }

    fn friction_n(&self, time_s: f64, [first, last]: [f64; 2]) -> f64 {
        let Motion {
            speed_m_per_s,
            held,
            ..
        } = self.path.at(time_s);
        match held {
            Some(over) => first + (last - first) * over,
            None if speed_m_per_s == 0.0 => 0.0,
            None => self.device.friction.0 * speed_m_per_s.signum(),
        }
    }
}
