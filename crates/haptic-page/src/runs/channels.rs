//! Channels of a log: the columns of its ticks behind the time, and of several axes how large the force is.

use haptic_experiment::Failure;
use haptic_message::{AXES, TickColumn, TickMessage};
use haptic_quantity::short;

/// Drawn besides: the position where the force is least in a column, and where it is largest.
const POSITION_AT_FORCE: &str = "position_at_force_m";
const FORCE: &str = "commanded_force_n";

/// The channels of a log by its number of axes, 1 to 3.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    pub(super) axes: usize,
    columns: Vec<TickColumn>,
}

impl Channels {
    pub(super) fn of(axes: usize) -> Self {
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

    pub(super) const fn count(&self) -> usize {
        self.columns.len()
    }

    /// Names of what is drawn, in the order of a row: `position_x_m`, `position_y_m`, …
    pub(super) fn drawn(&self) -> Vec<String> {
        let columns = self.columns.iter();
        columns.map(|column| column.name.clone()).collect()
    }

    /// Their names in the log.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names = self.drawn();
        names.retain(|name| name != POSITION_AT_FORCE);
        names
    }

    /// The channel that the last of them follows, if one does.
    pub(super) fn followed(&self) -> Option<usize> {
        let force = self.columns.iter().position(|column| column.name == FORCE);
        force.filter(|_| self.axes == 1)
    }

    /// The numbers of a tick, one for each name; empty for a tick of another number of axes.
    pub(super) fn numbers(&self, tick: &TickMessage) -> impl Iterator<Item = f64> {
        let columns = self.columns.iter().filter(|_| tick.axes() == self.axes);
        columns.map(|column| column.value(tick).to_f64())
    }
}

/// The places of channels among those of a log.
pub(crate) fn places(wanted: &[String], names: &[String]) -> Result<Vec<usize>, Failure> {
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
