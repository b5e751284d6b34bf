//! Channels of a log: the columns of its ticks behind the time, and of several axes how large the force is.

use crate::pyramid::{Pyramid, PyramidSize};
use haptic_document::Failure;
use haptic_message::{AXES, TickColumn, TickMessage};
use haptic_quantity::short;
use std::fmt::Write as _;

/// Drawn besides: the position where the force is least in a column, and where it is largest.
const POSITION_AT_FORCE: &str = "position_at_force_m";
const FORCE: &str = "commanded_force_n";

/// Numbers of a pyramid that are kept one by one, and those of each of its coarser levels: half a million samples of one axis.
const NUMBERS: usize = 1 << 22;
const COARSE_NUMBERS: usize = 1 << 20;
/// Levels above: the last has 65 536 samples in an entry, enough for eight billion.
const COARSER: u32 = 8;

/// The channels of a log by its number of axes, 1 to 3.
#[derive(Clone, Debug)]
pub struct Channels {
    /// Axes of the device, 1 to 3.
    pub axes: usize,
    columns: Vec<TickColumn>,
}

impl Channels {
    /// Channels for this number of axes.
    #[must_use]
    pub fn of(axes: usize) -> Self {
        let axes = axes.clamp(1, AXES.len());
        let mut columns = TickMessage::columns(axes);
        columns.retain(|column| !["tick", "time_s"].contains(&column.name.as_str()));
        if axes > 1 {
            let norm = |tick: &TickMessage| tick.commanded_force_n.norm();
            columns.push(TickColumn::derived("commanded_force_norm_n", norm));
        } else {
            let position = |tick: &TickMessage| tick.position_m.iter().sum();
            columns.push(TickColumn::derived(POSITION_AT_FORCE, position));
        }
        Self { axes, columns }
    }

    /// Numbers in a row of a pyramid or table.
    pub const fn count(&self) -> usize {
        self.columns.len()
    }

    /// An empty pyramid for `samples` samples, no larger than it has to be.
    #[must_use]
    pub fn pyramid(&self, samples: u64) -> Pyramid {
        let up_to = |numbers: usize, wanted: u64| {
            let most = numbers / self.count();
            usize::try_from(wanted).unwrap_or(most).clamp(1, most)
        };
        Pyramid::new(PyramidSize {
            channels: self.count(),
            follows: self.followed().as_slice(),
            samples: up_to(NUMBERS, samples),
            entries: up_to(COARSE_NUMBERS, samples.div_ceil(4)),
            coarser: COARSER,
        })
    }

    /// A row of a pyramid.
    #[must_use]
    pub fn row(&self, tick: &TickMessage) -> Vec<f32> {
        self.numbers(tick).map(|number| number as f32).collect()
    }

    /// The head of a table of these channels.
    #[must_use]
    pub fn head(channels: &[String]) -> String {
        format!("time_s,{}\n", channels.join(","))
    }

    /// Adds a line to a table: the time, and the numbers at these places, each with all of its digits.
    pub fn line(&self, table: &mut String, tick: &TickMessage, places: &[usize]) {
        let numbers: Vec<f64> = self.numbers(tick).collect();
        // Writing to a string cannot fail.
        let _ = write!(table, "{}", tick.time_s);
        for &place in places {
            let _ = write!(table, ",{}", numbers.get(place).unwrap_or(&f64::NAN));
        }
        table.push('\n');
    }

    /// Names of what is drawn, in the order of a row: `position_x_m`, `position_y_m`, …
    #[must_use]
    pub fn drawn(&self) -> Vec<String> {
        let columns = self.columns.iter();
        columns.map(|column| column.name.clone()).collect()
    }

    /// Their names in the log.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let mut names = self.drawn();
        names.retain(|name| name != POSITION_AT_FORCE);
        names
    }

    /// The channel that the last of them follows, if one does.
    #[must_use]
    pub fn followed(&self) -> Option<usize> {
        let force = self.columns.iter().position(|column| column.name == FORCE);
        force.filter(|_| self.axes == 1)
    }

    /// The numbers of a tick, one for each name; empty for a tick of another number of axes.
    pub fn numbers(&self, tick: &TickMessage) -> impl Iterator<Item = f64> {
        let columns = self.columns.iter().filter(|_| tick.axes() == self.axes);
        columns.map(|column| column.value(tick).to_f64())
    }
}

/// The places of channels among those of a log.
///
/// # Errors
/// A channel that is not there.
pub fn places(wanted: &[String], names: &[String]) -> Result<Vec<usize>, Failure> {
    let place = |name: &String| {
        let place = names.iter().position(|known| known == name);
        place.ok_or_else(|| {
            Failure::bad_input(format_args!(
                "there is no channel {:?}: use some of {}",
                short(name),
                names.join(", ")
            ))
        })
    };
    wanted.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_message::PerAxis;

    #[test]
    fn a_row_has_a_number_for_each_name() {
        for axes in [2, 3] {
            let channels = Channels::of(axes);
            let names = channels.drawn();
            let tick = TickMessage {
                position_m: PerAxis::new(&[0.1, 0.2, 0.3][..axes]),
                commanded_force_n: PerAxis::new(&[3.0, 4.0, 0.0][..axes]),
                limiters: 2,
                ..TickMessage::at_rest(axes)
            };
            let row: Vec<f64> = channels.numbers(&tick).collect();
            assert_eq!(names.len(), row.len());
            let value = |name: &str| row[names.iter().position(|n| n == name).expect("there")];
            assert_eq!((value("position_x_m"), value("position_y_m")), (0.1, 0.2));
            assert_eq!(
                (value("commanded_force_norm_n"), value("limiters")),
                (5.0, 2.0)
            );
            assert_eq!(names.contains(&"position_z_m".to_owned()), axes == 3);
            // A tick of other axes is no number.
            assert_eq!(channels.numbers(&TickMessage::at_rest(1)).count(), 0);
        }
        let one = Channels::of(1);
        let numbers = one.numbers(&TickMessage::at_rest(1)).count();
        assert_eq!(one.names().len() + 1, numbers);
    }
}
