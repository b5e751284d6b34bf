//! A control tick of one, two or three axes, and the one list of its fields: it makes the message, schema, bytes, CSV and the columns
//! of every other program. A field with an element an axis is `position_m` of one axis,
//! `position_x_m`, `position_y_m` and `position_z_m` of several.

use super::message::{ColumnValue, Item, Layout, LogMessage, MessageError, begin, put};
use std::{fmt, ops::Deref};

/// The axis letters, which column names have before the unit.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A number for each of one to three axes; a slice of them.
#[derive(Clone, Copy, PartialEq)]
pub struct PerAxis {
    values: [f64; 3],
    count: u8,
}

impl PerAxis {
    /// A vector of the first three numbers at most; without any it is 0 on one axis.
    #[must_use]
    pub fn new(numbers: &[f64]) -> Self {
        numbers.iter().copied().collect()
    }

    /// The numbers, to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values[..usize::from(self.count)]
    }

    /// √Σ xᵢ², the length of the vector.
    #[must_use]
    pub fn norm(&self) -> f64 {
        self.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

impl Default for PerAxis {
    /// 0 on one axis.
    fn default() -> Self {
        0.0.into()
    }
}

impl FromIterator<f64> for PerAxis {
    /// Numbers for the axes, as [`new`](Self::new) takes them.
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let (mut values, mut count) = ([0.0; 3], 0);
        for (value, number) in values.iter_mut().zip(numbers) {
            *value = number;
            count += 1;
        }
        let count = count.max(1);
        Self { values, count }
    }
}

impl Deref for PerAxis {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[..usize::from(self.count)]
    }
}

impl From<f64> for PerAxis {
    fn from(x: f64) -> Self {
        Self::new(&[x])
    }
}

impl fmt::Debug for PerAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

/// Access to a field by its kind.
#[derive(Clone, Copy, Debug)]
enum Reach {
    Count(fn(&mut TickMessage) -> &mut u64),
    Number(fn(&mut TickMessage) -> &mut f64),
    Axes(fn(&mut TickMessage) -> &mut PerAxis),
    /// Access as in `Axes`, where there may be nothing to tell.
    Perhaps(fn(&mut TickMessage) -> &mut Option<PerAxis>),
    Bits(fn(&mut TickMessage) -> &mut u8),
    /// No field, but made of some.
    Derived(fn(&TickMessage) -> f64),
}

/// A field of a message.
struct Field {
    /// Its name with its unit.
    name: &'static str,
    what: &'static str,
    reach: Reach,
}

/// Type of a field by its kind, and the field of a tick whose numbers are all this one.
macro_rules! kind {
    (type Count) => { u64 };
    (type Number) => { f64 };
    (type Axes) => { PerAxis };
    (type Perhaps) => { Option<PerAxis> };
    (type Bits) => { u8 };
    (Count $number:ident $axes:ident) => { 0 };
    (Number $number:ident $axes:ident) => { $number };
    (Axes $number:ident $axes:ident) => { $axes };
    (Perhaps $number:ident $axes:ident) => { None };
    (Bits $number:ident $axes:ident) => { 0 };
}

/// The message, its fields in their order, and a tick whose numbers are all the same. A new field stands here once: then it is written
/// and read, and NaN in a tick that does not know it.
macro_rules! message {
    ($(#[$about:meta])* struct $($(#[$doc:meta])* $name:ident: $kind:ident, $what:literal;)*) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct TickMessage {
            $($(#[$doc])* pub $name: kind!(type $kind),)*
        }

        static FIELDS: [Field; [$(stringify!($name)),*].len()] = [$(Field {
            name: stringify!($name),
            what: $what,
            reach: Reach::$kind(|tick| &mut tick.$name),
        }),*];

        impl TickMessage {
            fn filled(number: f64, axes: PerAxis) -> Self {
                Self { $($name: kind!($kind number axes),)* }
            }
        }
    };
}

message! {
    /// One control tick. Lengths in m, forces in N, time in s; forces as the recorder was given them, NaN included.
    ///
    /// ```
    /// use haptic_message::{Layout, LogMessage as _, PerAxis, TickMessage};
    ///
    /// let commanded_force_n = PerAxis::new(&[0.3, -0.4]);
    /// let tick = TickMessage { commanded_force_n, ..TickMessage::at_rest(2) };
    /// let mut bytes = Vec::new();
    /// tick.encode_into(&mut bytes)?;
    /// let layout = Layout::of(&tick.schema().1, TickMessage::slot);
    /// assert_eq!(TickMessage::decode(&layout, &bytes)?, tick);
    /// assert_eq!(tick.commanded_force_n.norm(), 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    struct

    /// Number of the tick, counted by the device from the start of the run.
    tick: Count, "number of the tick, from the start of the run";
    /// Time on the clock of the device, s, from its first tick.
    time_s: Number, "device time, s";
    /// Commanded position of the hand or indenter, m.
    reference_m: Axes, "commanded place of hand or indenter, m";
    /// True position of the hand or indenter, m.
    indenter_position_m: Axes, "its true place, m";
    /// Position of the device as the loop read it, m.
    position_m: Axes, "place of the device as the loop read it, m";
    /// Force that the environment wanted, N.
    environment_force_n: Axes, "wanted by the environment, N";
    /// Force that left the safety chain and was commanded, in answer to this position, N.
    commanded_force_n: Axes, "after the safety chain, N";
    /// Force that the device made in this tick, N: in a loop on the host it answers an earlier position.
    applied_force_n: Axes, "made by the device in this tick, N";
    /// Force between indenter and device, or that the actuators really made, N.
    contact_force_n: Axes, "of the contact, or really made, N";
    /// Limiters that acted, as bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace,
    /// 64 velocity, 128 passivity guard.
    limiters: Bits, "bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace, 64 velocity, 128 passivity guard";
    /// Flaws of this tick, bits of [`flaw`](crate::flaw); 0 for a good tick.
    flaws: Bits, "bits: 1 the board did not answer, so the position is old, 2 it may not have taken the force of the tick before, \
         4 an older force of the host acted, 8 what the device told cannot be";
    /// Energy that the passivity guard has observed, J: positive if the device gave it to the loop. NaN
    /// without a guard, and from a device that does not send it.
    observed_energy_j: Number, "seen by the passivity guard, J; NaN if there is none";
    /// Force of the hand or indenter on the device as its force sensor shows it, N, positive along the position; `None`, in a file NaN,
    /// without a sensor.
    sensed_force_n: Perhaps, "of the hand on the device by its force sensor, N; NaN if there is none";
}

/// Destination of a column: a field, and its axis.
#[derive(Clone, Copy, Debug)]
pub struct TickSlot(Reach, usize);

/// A column of a table of ticks: one number for each.
#[derive(Clone, Debug)]
pub struct TickColumn {
    /// Its name, with its unit at the end.
    pub name: String,
    what: &'static str,
    axis: usize,
    reach: Reach,
}

impl TickColumn {
    /// A value that is not in a tick but computed from it.
    #[must_use]
    pub fn derived(name: &str, read: fn(&TickMessage) -> f64) -> Self {
        Self {
            name: name.to_owned(),
            what: "",
            axis: 0,
            reach: Reach::Derived(read),
        }
    }

    /// The number of a tick; NaN on an axis that the tick lacks.
    #[must_use]
    pub fn value(&self, tick: &TickMessage) -> ColumnValue {
        let tick = &mut tick.clone();
        match self.reach {
            Reach::Count(field) => ColumnValue::Count(*field(tick)),
            Reach::Bits(field) => ColumnValue::Bits(*field(tick)),
            Reach::Number(field) => ColumnValue::Number(*field(tick)),
            Reach::Derived(number) => ColumnValue::Number(number(tick)),
            Reach::Axes(field) => {
                let number = field(tick).get(self.axis).copied();
                ColumnValue::Number(number.unwrap_or(f64::NAN))
            }
            Reach::Perhaps(field) => {
                let number = field(tick).as_ref().and_then(|axes| axes.get(self.axis));
                ColumnValue::Number(number.copied().unwrap_or(f64::NAN))
            }
        }
    }
}

/// Numbers of so many axes, 1 to 3, none of which is known.
fn nothing(axes: usize) -> PerAxis {
    PerAxis::new(&[f64::NAN; 3][..axes.clamp(1, 3)])
}

/// Name of a field on one of `axes` axes: `contact_force_x_n` of `contact_force_n`, if it is not the only one.
#[must_use]
pub fn column_name(field: &str, axis: usize, axes: usize) -> String {
    match field.rsplit_once('_') {
        Some((name, unit)) if axes > 1 => format!("{name}_{}_{unit}", AXES[axis]),
        _ => field.to_owned(),
    }
}

impl TickMessage {
    /// A tick of which nothing is known yet, with this many axes, 1 to 3: whoever leaves a number out logs NaN and not a rest that
    /// nobody saw.
    #[must_use]
    pub fn unknown(axes: usize) -> Self {
        Self::filled(f64::NAN, nothing(axes))
    }

    /// A tick with this many axes, 1 to 3, all zero.
    #[must_use]
    pub fn at_rest(axes: usize) -> Self {
        Self::filled(0.0, PerAxis::new(&[0.0; 3][..axes.clamp(1, 3)]))
    }

    /// Number of axes, 1 to 3.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.position_m.len()
    }

    /// Columns of a table of ticks with `axes` axes, 1 to 3, in order.
    #[must_use]
    pub fn columns(axes: usize) -> Vec<TickColumn> {
        let of = |field: &Field| {
            let axes = match field.reach {
                Reach::Axes(_) | Reach::Perhaps(_) => axes.clamp(1, AXES.len()),
                Reach::Count(_) | Reach::Number(_) | Reach::Bits(_) | Reach::Derived(_) => 1,
            };
            let column = |axis| TickColumn {
                name: column_name(field.name, axis, axes),
                what: field.what,
                axis,
                reach: field.reach,
            };
            (0..axes).map(column).collect::<Vec<_>>()
        };
        FIELDS.iter().flat_map(of).collect()
    }
}

impl LogMessage for TickMessage {
    const TOPIC: &'static str = "/haptics/tick";

    /// `Tick` of one axis, `Tick2` and `Tick3` of more: ROS knows a type by its name.
    fn schema(&self) -> (String, String) {
        let axes = self.axes();
        let number = ["", "2", "3"][axes - 1];
        let mut text = "# One control tick of a haptic experiment.\n".to_owned();
        for TickColumn {
            name, what, reach, ..
        } in Self::columns(axes)
        {
            let kind = match reach {
                Reach::Count(_) => "uint64",
                Reach::Number(_) | Reach::Axes(_) | Reach::Perhaps(_) | Reach::Derived(_) => {
                    "float64"
                }
                Reach::Bits(_) => "uint8",
            };
            text += &format!("{kind} {name}  # {what}\n");
        }
        (format!("haptics_msgs/msg/Tick{number}"), text)
    }

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn encode_into(&self, buffer: &mut Vec<u8>) -> Result<(), MessageError> {
        begin(buffer);
        let (axes, tick) = (self.axes(), &mut self.clone());
        for field in &FIELDS {
            match field.reach {
                Reach::Count(field) => put(buffer, field(tick).to_le_bytes()),
                Reach::Bits(field) => put(buffer, [*field(tick)]),
                Reach::Number(field) => put(buffer, field(tick).to_le_bytes()),
                Reach::Axes(field) => {
                    let numbers = field(tick);
                    if numbers.len() != axes {
                        return Err(MessageError::Axes);
                    }
                    numbers.iter().for_each(|x| put(buffer, x.to_le_bytes()));
                }
                Reach::Perhaps(field) => {
                    let numbers = field(tick).unwrap_or(nothing(axes));
                    if numbers.len() != axes {
                        return Err(MessageError::Axes);
                    }
                    numbers.iter().for_each(|x| put(buffer, x.to_le_bytes()));
                }
                Reach::Derived(_) => {}
            }
        }
        Ok(())
    }

    type Slot = TickSlot;

    fn slot(name: &str) -> Option<TickSlot> {
        let columns = [1, AXES.len()].map(Self::columns);
        let column = columns.iter().flatten().find(|column| column.name == name);
        column.map(|column| TickSlot(column.reach, column.axis))
    }

    /// Numbers that are not in the schema are not numbers, and bits are 0.
    fn decode(layout: &Layout<TickSlot>, bytes: &[u8]) -> Result<Self, MessageError> {
        let none = PerAxis {
            values: [f64::NAN; 3],
            count: 0,
        };
        let mut tick = Self::filled(f64::NAN, none);
        layout.read(bytes, |TickSlot(reach, axis), places, item| {
            // No column of ours is a list.
            if !places.is_empty() {
                return;
            }
            match (reach, item) {
                (Reach::Count(field), Item::Number(number)) => *field(&mut tick) = number.to_u64(),
                (Reach::Number(field), Item::Number(number)) => *field(&mut tick) = number.to_f64(),
                (Reach::Bits(field), Item::Number(number)) => {
                    *field(&mut tick) = number.to_u64() as u8;
                }
                (Reach::Axes(field), Item::Number(number)) => {
                    let numbers = field(&mut tick);
                    if let Some(value) = numbers.values.get_mut(axis) {
                        *value = number.to_f64();
                    }
                    numbers.count = numbers.count.max((axis + 1).min(4) as u8);
                }
                (Reach::Perhaps(field), Item::Number(number)) => {
                    let number = number.to_f64();
                    // A tick without a sensor is one of whose axes none has a number.
                    if !number.is_nan() {
                        let axes = field(&mut tick).get_or_insert(nothing(AXES.len()));
                        if let Some(value) = axes.values.get_mut(axis) {
                            *value = number;
                        }
                    }
                }
                (Reach::Derived(_), _) | (_, Item::Text(_)) => {}
            }
        })?;
        let axes = tick.position_m.count;
        for field in &FIELDS {
            if let Reach::Axes(field) = field.reach {
                let numbers = field(&mut tick);
                if !(1..=3).contains(&axes) || ![0, axes].contains(&numbers.count) {
                    return Err(MessageError::Axes);
                }
                numbers.count = axes;
                numbers.values[usize::from(axes)..].fill(0.0);
            }
        }
        if let Some(sensed) = &mut tick.sensed_force_n {
            *sensed = PerAxis::new(&sensed[..usize::from(axes)]);
        }
        Ok(tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(axes: usize) -> TickMessage {
        let numbers = |numbers: [f64; 3]| PerAxis::new(&numbers[..axes]);
        TickMessage {
            tick: 0x0102_0304_0506_0708,
            time_s: 0.5,
            reference_m: numbers([1.0, 1.5, 1.6]),
            indenter_position_m: numbers([-2.0, -0.0, 2.5]),
            position_m: numbers([3.0, 3.5, 3.6]),
            environment_force_n: numbers([4.0, f64::INFINITY, 4.5]),
            commanded_force_n: numbers([5.0, 5.1, 5.2]),
            applied_force_n: numbers([5.5, 5.6, 5.7]),
            contact_force_n: numbers([-0.0, 6.0, 6.5]),
            limiters: 9,
            flaws: 3,
            observed_energy_j: -6.0,
            sensed_force_n: Some(numbers([7.0, f64::NEG_INFINITY, -0.5])),
        }
    }

    #[test]
    fn a_tick_is_its_columns_in_little_endian_cdr() {
        let mut bytes = vec![0xff; 3];
        for (axes, length) in [(1, 100), (2, 164), (3, 228)] {
            let tick = tick(axes);
            tick.encode_into(&mut bytes).expect("encodes");
            let mut expected = vec![0, 1, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1];
            for column in &TickMessage::columns(axes)[1..2 + 7 * axes] {
                expected.extend(column.value(&tick).to_f64().to_le_bytes());
            }
            // Six bytes bring the last number to a multiple of its size.
            expected.extend([9, 3, 0, 0, 0, 0, 0, 0]);
            expected.extend((-6.0_f64).to_le_bytes());
            let sensed = tick.sensed_force_n.expect("a sensor");
            sensed.iter().for_each(|x| expected.extend(x.to_le_bytes()));
            assert_eq!(bytes, expected);
            assert_eq!(bytes.len(), length);
            let layout = Layout::of(&tick.schema().1, TickMessage::slot);
            assert_eq!(TickMessage::decode(&layout, &bytes).expect("decodes"), tick);
            for length in 0..bytes.len() {
                assert!(
                    TickMessage::decode(&layout, &bytes[..length]).is_err(),
                    "{length}"
                );
            }
            // Of a log without its schema, the length tells the axes.
            let fits = |layout: &Layout<_>| TickMessage::decode(layout, &bytes).ok();
            let schemas = [1, 2, 3].map(|axes| TickMessage::at_rest(axes).schema().1);
            let layouts = schemas.map(|schema| Layout::of(&schema, TickMessage::slot));
            let found: Vec<_> = layouts.iter().filter_map(fits).collect();
            assert_eq!(found, [tick]);
            bytes[1] = 0;
            let error = TickMessage::decode(&layout, &bytes).expect_err("another byte order");
            assert!(matches!(error, MessageError::Encapsulation));
        }
    }

    #[test]
    fn without_a_sensor_a_file_has_no_force_of_it_and_never_zero() {
        for axes in 1..=3 {
            let schema = tick(axes).schema().1;
            let layout = Layout::of(&schema, TickMessage::slot);
            let plain = TickMessage::at_rest(axes);
            assert_eq!(plain.sensed_force_n, None);
            for column in &TickMessage::columns(1)[12..] {
                assert!(column.value(&plain).to_f64().is_nan(), "{}", column.name);
            }
            let mut bytes = Vec::new();
            let blind = TickMessage {
                sensed_force_n: None,
                ..tick(axes)
            };
            blind.encode_into(&mut bytes).expect("encodes");
            let nan = bytes[bytes.len() - 8 * axes..].chunks_exact(8);
            assert!(nan.eq([f64::NAN.to_le_bytes(); 3][..axes].iter()));
            assert_eq!(
                TickMessage::decode(&layout, &bytes).expect("decodes"),
                blind
            );
            let uneven = TickMessage {
                sensed_force_n: Some(PerAxis::new(&[1.0; 3][..4 - axes])),
                ..tick(axes)
            };
            let refused = uneven.encode_into(&mut bytes).is_err();
            assert_eq!(refused, axes != 2, "{axes}");
        }
    }

    #[test]
    fn a_number_that_nobody_knows_is_none_and_at_rest_each_is_zero() {
        let schema = "uint64 tick\nfloat64 position_m\n";
        let layout = Layout::of(schema, TickMessage::slot);
        let bytes = [&[0, 1, 0, 0][..], &[0; 16]].concat();
        let read = TickMessage::decode(&layout, &bytes).expect("decodes");
        for column in TickMessage::columns(1) {
            let number = |tick: &TickMessage| match column.value(tick) {
                ColumnValue::Number(number) => Some(number),
                ColumnValue::Count(_) | ColumnValue::Bits(_) => None,
            };
            let (name, is_sensed) = (&*column.name, column.name == "sensed_force_n");
            if let Some(unknown) = number(&TickMessage::unknown(1)) {
                assert!(unknown.is_nan(), "{name}");
                assert_eq!(
                    number(&read).map(f64::is_nan),
                    Some(name != "position_m"),
                    "{name}"
                );
                assert_eq!(
                    number(&TickMessage::at_rest(1)) == Some(0.0),
                    !is_sensed,
                    "{name}"
                );
            }
        }
    }

    #[test]
    fn vectors_of_several_lengths_are_not_a_tick() {
        let wrong = TickMessage {
            commanded_force_n: PerAxis::new(&[1.0, 2.0, 3.0]),
            ..tick(2)
        };
        let error = wrong.encode_into(&mut Vec::new()).expect_err("refused");
        assert!(matches!(error, MessageError::Axes));
        assert_eq!(PerAxis::new(&[]).len(), 1);
        assert_eq!(PerAxis::new(&[0.0; 4]).len(), 3);
    }

    #[test]
    fn the_schema_names_the_columns_and_a_debugger_the_fields_in_the_same_order() {
        let names = |axes| -> Vec<String> {
            let columns = TickMessage::columns(axes).into_iter();
            columns.map(|column| column.name).collect()
        };
        for axes in 1..=3 {
            let (_, text) = tick(axes).schema();
            let lines = text.lines().filter(|line| !line.starts_with('#'));
            let fields: Vec<&str> = lines.filter_map(|line| line.split(' ').nth(1)).collect();
            assert_eq!(fields, names(axes));
            assert_eq!(fields.len(), 5 + 8 * axes);
        }
        let shown = format!("{:#?}", tick(1));
        let place = |name: &String| shown.find(&format!(" {name}:")).expect("is a field");
        assert!(names(1).iter().map(place).is_sorted());
        assert_eq!(names(2)[2..4], ["reference_x_m", "reference_y_m"]);
        assert_eq!(names(3)[12], "environment_force_y_n");
    }
}
