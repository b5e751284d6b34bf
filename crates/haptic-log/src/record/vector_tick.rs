//! A tick of a device with two or three axes: the second version of the tick, with a vector in place of each number.
//!
//! A log has ticks of one version, under a topic of its own for each. The number of axes is the length of the vectors, the same
//! in every field and every tick of a log.

use super::message::{LogMessage, MessageError, decode_fields, named};
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Names of the axes, in the columns of tables.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A number for each of up to three axes.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct PerAxis {
    values: [f64; 3],
    count: u8,
}

impl PerAxis {
    /// The numbers; `None` for more than three.
    #[must_use]
    pub fn new(numbers: &[f64]) -> Option<Self> {
        let mut values = [0.0; 3];
        values.get_mut(..numbers.len())?.copy_from_slice(numbers);
        Some(Self {
            values,
            count: numbers.len() as u8,
        })
    }

    /// As a slice, an element an axis.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..usize::from(self.count)]
    }

    /// √Σ xᵢ².
    #[must_use]
    pub fn norm(&self) -> f64 {
        let squares = self.as_slice().iter().map(|x| x * x);
        squares.sum::<f64>().sqrt()
    }
}

impl From<[f64; 2]> for PerAxis {
    fn from([x, y]: [f64; 2]) -> Self {
        Self {
            values: [x, y, 0.0],
            count: 2,
        }
    }
}

impl From<[f64; 3]> for PerAxis {
    fn from(values: [f64; 3]) -> Self {
        Self { values, count: 3 }
    }
}

impl fmt::Debug for PerAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl Serialize for PerAxis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.as_slice())
    }
}

impl<'de> Deserialize<'de> for PerAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numbers;

        impl<'de> Visitor<'de> for Numbers {
            type Value = PerAxis;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number for each of up to three axes")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<PerAxis, A::Error> {
                let mut read = PerAxis::default();
                while let Some(item) = items.next_element()? {
                    let place = read.values.get_mut(usize::from(read.count));
                    *place.ok_or_else(|| A::Error::custom("more than three axes"))? = item;
                    read.count += 1;
                }
                Ok(read)
            }
        }

        deserializer.deserialize_seq(Numbers)
    }
}

/// One control tick of a device with two or three axes. Fields as those of [`TickMessage`](super::TickMessage), each vector with
/// an element an axis.
///
/// ```
/// use haptic_log::record::{Entry, LogReader, LogWriter, VectorTick};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.mcap");
/// let mut log = LogWriter::create(&path)?;
/// let tick = VectorTick { commanded_force_n: [0.3, -0.4].into(), observed_energy_j: 0.0, ..VectorTick::at_rest(2) };
/// log.vector_tick(&tick)?;
/// log.finish()?;
/// let entry = LogReader::open(&path)?.next().transpose()?;
/// assert_eq!(entry, Some(Entry::Vector(tick)));
/// assert_eq!(tick.commanded_force_n.norm(), 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VectorTick {
    /// Number of the tick, counted by the device from the start of the run.
    pub tick: u64,
    /// Device time, s.
    pub time_s: f64,
    /// Commanded position of the hand or indenter, m.
    pub reference_m: PerAxis,
    /// True position of the device, m.
    pub indenter_position_m: PerAxis,
    /// Position as the loop read it, m.
    pub position_m: PerAxis,
    /// Force the environment asked for, N.
    pub environment_force_n: PerAxis,
    /// Force that left the safety chain and was commanded, in answer to this position, N.
    pub commanded_force_n: PerAxis,
    /// Force that the device made in this tick, N.
    pub applied_force_n: PerAxis,
    /// Force that the actuators really made, N.
    pub contact_force_n: PerAxis,
    /// Limiters that acted, as bits.
    pub limiters: u8,
    /// What is wrong with this tick, as bits.
    pub flaws: u8,
    /// Energy that the passivity guard has observed, J; NaN if there is none.
    pub observed_energy_j: f64,
}

/// Name of a field, and the field.
pub type VectorField = (&'static str, fn(&VectorTick) -> PerAxis);

impl VectorTick {
    /// The vectors in their order.
    pub const VECTORS: [VectorField; 7] = named![;];

    /// A tick of so many axes, 3 at most, with zeros.
    #[must_use]
    pub fn at_rest(axes: usize) -> Self {
        let zeros = PerAxis {
            count: axes.min(3) as u8,
            ..PerAxis::default()
        };
        Self {
            reference_m: zeros,
            indenter_position_m: zeros,
            position_m: zeros,
            environment_force_n: zeros,
            commanded_force_n: zeros,
            applied_force_n: zeros,
            contact_force_n: zeros,
            observed_energy_j: f64::NAN,
            ..Self::default()
        }
    }

    /// Number of axes.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.position_m.as_slice().len()
    }

    /// Columns of a table of such ticks, with the axis before the unit: `position_m` is `position_x_m`, `position_y_m`, ….
    #[must_use]
    pub fn columns(axes: usize) -> Vec<String> {
        let vectors = Self::VECTORS.iter().flat_map(|(field, _)| {
            let axes = AXES.iter().take(axes);
            axes.map(|axis| column(field, axis))
        });
        let own = str::to_owned;
        (["tick", "time_s"].map(own).into_iter())
            .chain(vectors)
            .chain(["limiters", "flaws", "observed_energy_j"].map(own))
            .collect()
    }
}

/// Name of an axis of a field: `contact_force_x_n` of `contact_force_n`.
#[must_use]
pub fn column(field: &str, axis: &str) -> String {
    match field.rsplit_once('_') {
        Some((name, unit)) => format!("{name}_{axis}_{unit}"),
        None => format!("{field}_{axis}"),
    }
}

impl LogMessage for VectorTick {
    const TOPIC: &'static str = "/haptics/vector_tick";
    const SCHEMA_NAME: &'static str = "haptics_msgs/msg/VectorTick";
    const SCHEMA: &'static str = "\
# One control tick of a haptic experiment with two or three axes; an element of each vector an axis.
uint64 tick                    # number of the tick, counted by the device from the start of the run
float64 time_s                 # device time, s
float64[] reference_m          # where the hand or indenter was told to be, m
float64[] indenter_position_m  # where the device was, m
float64[] position_m           # where the loop read it to be, m
float64[] environment_force_n  # force the environment asked for, N
float64[] commanded_force_n    # force that left the safety chain, in answer to this position, N
float64[] applied_force_n      # force that the device made in this tick, N
float64[] contact_force_n      # force that the actuators made, N
uint8 limiters                 # limiters that acted, bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, \
16 start-up, 32 workspace, 64 velocity, 128 passivity guard
uint8 flaws                    # bits: 1 the board did not answer, so the position is old, 2 it may not have taken the force \
of the tick before, 4 an older force of the host acted, 8 what the device told cannot be
float64 observed_energy_j      # energy that the passivity guard has observed, J; NaN if there is none
";

    fn decode(bytes: &[u8]) -> Result<Self, MessageError> {
        let tick: Self = decode_fields(bytes)?;
        let axes = tick.axes();
        let same = |(_, field): &VectorField| field(&tick).as_slice().len() == axes;
        if (2..=3).contains(&axes) && Self::VECTORS.iter().all(same) {
            Ok(tick)
        } else {
            Err(MessageError::Axes { axes })
        }
    }
}

/// A tick of either version.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyTick {
    /// One axis.
    One(super::TickMessage),
    /// Two or three.
    Vector(VectorTick),
}

impl AnyTick {
    /// Its number.
    #[must_use]
    pub const fn tick(&self) -> u64 {
        match self {
            Self::One(tick) => tick.tick,
            Self::Vector(tick) => tick.tick,
        }
    }

    /// Device time, s.
    #[must_use]
    pub const fn time_s(&self) -> f64 {
        match self {
            Self::One(tick) => tick.time_s,
            Self::Vector(tick) => tick.time_s,
        }
    }

    /// What is wrong with it, as bits.
    #[must_use]
    pub const fn flaws(&self) -> u8 {
        match self {
            Self::One(tick) => tick.flaws,
            Self::Vector(tick) => tick.flaws,
        }
    }

    /// True if its position is a number.
    pub(crate) fn has_place(&self) -> bool {
        match self {
            Self::One(tick) => tick.position_m.is_finite(),
            Self::Vector(tick) => {
                let place = tick.position_m.as_slice();
                place.iter().all(|axis| axis.is_finite())
            }
        }
    }
}

impl From<super::TickMessage> for AnyTick {
    fn from(tick: super::TickMessage) -> Self {
        Self::One(tick)
    }
}

impl From<VectorTick> for AnyTick {
    fn from(tick: VectorTick) -> Self {
        Self::Vector(tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick() -> VectorTick {
        VectorTick {
            tick: 0x0102_0304_0506_0708,
            time_s: 0.5,
            reference_m: [1.0, 2.0].into(),
            indenter_position_m: [3.0, -0.0].into(),
            position_m: [5.0, 6.0].into(),
            environment_force_n: [f64::INFINITY, 8.0].into(),
            commanded_force_n: [9.0, 10.0].into(),
            applied_force_n: [9.5, 10.5].into(),
            contact_force_n: [11.0, 12.0].into(),
            limiters: 9,
            flaws: 3,
            observed_energy_j: -6.0,
        }
    }

    #[test]
    fn a_vector_is_its_length_and_its_numbers_in_cdr() {
        let mut bytes = Vec::new();
        tick().encode_into(&mut bytes).expect("encodes");
        let mut expected = vec![0, 1, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1];
        expected.extend(0.5_f64.to_le_bytes());
        for (_, field) in VectorTick::VECTORS {
            // A length of four bytes, and four that bring the numbers to a multiple of their size.
            expected.extend([2, 0, 0, 0, 0, 0, 0, 0]);
            for x in field(&tick()).as_slice() {
                expected.extend(x.to_le_bytes());
            }
        }
        expected.extend([9, 3, 0, 0, 0, 0, 0, 0]);
        expected.extend((-6.0_f64).to_le_bytes());
        assert_eq!(bytes, expected);
        assert_eq!(VectorTick::decode(&bytes).expect("decodes"), tick());
        for length in 0..bytes.len() {
            assert!(VectorTick::decode(&bytes[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn axes_that_differ_or_are_none_or_many_are_no_tick() {
        let mut bytes = Vec::new();
        for wrong in [
            VectorTick {
                commanded_force_n: [1.0, 2.0, 3.0].into(),
                ..tick()
            },
            VectorTick::at_rest(0),
            VectorTick::at_rest(1),
        ] {
            wrong.encode_into(&mut bytes).expect("encodes");
            let error = VectorTick::decode(&bytes).expect_err("refused");
            assert!(matches!(error, MessageError::Axes { .. }), "{error}");
        }
        // A length of four in the first vector.
        tick().encode_into(&mut bytes).expect("encodes");
        bytes[20] = 4;
        assert!(VectorTick::decode(&bytes).is_err());
        bytes[20..24].copy_from_slice(&[0xff; 4]);
        assert!(VectorTick::decode(&bytes).is_err());
        assert_eq!(PerAxis::new(&[0.0; 4]), None);
    }

    #[test]
    fn the_schema_names_the_fields_in_order_and_tables_their_axes() {
        let fields: Vec<&str> = VectorTick::SCHEMA
            .lines()
            .filter(|line| !line.starts_with('#'))
            .filter_map(|line| line.split_whitespace().nth(1))
            .collect();
        let vectors = VectorTick::VECTORS.map(|(name, _)| name);
        assert_eq!(fields[..2], ["tick", "time_s"]);
        assert_eq!(fields[2..9], vectors);
        assert_eq!(fields[9..], ["limiters", "flaws", "observed_energy_j"]);
        let columns = VectorTick::columns(2);
        assert_eq!(columns.len(), 5 + 2 * 7);
        assert_eq!(columns[2..4], ["reference_x_m", "reference_y_m"]);
        assert_eq!(VectorTick::columns(3)[12], "environment_force_y_n");
    }
}
