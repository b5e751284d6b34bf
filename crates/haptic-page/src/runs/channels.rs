//! Channels of a log: one axis, or several with a channel for each component of a vector.

use haptic_experiment::Failure;
use haptic_log::record::{AXES, AnyTick, TickMessage, VectorTick, column};

/// Channels of a log of one axis.
const ONE_AXIS: [&str; 10] = [
    "position_m",
    "commanded_force_n",
    "applied_force_n",
    "environment_force_n",
    "reference_m",
    "indenter_position_m",
    "contact_force_n",
    "observed_energy_j",
    "limiter",
    "flaws",
];
/// Of several axes, beside the components: what is one number.
const OF_ALL: [&str; 4] = [
    "commanded_force_norm_n",
    "observed_energy_j",
    "limiter",
    "flaws",
];

/// The channels of a log by its number of axes, 1 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channels {
    axes: usize,
}

impl Channels {
    /// Of so many axes.
    pub(super) fn of(axes: usize) -> Self {
        Self {
            axes: axes.clamp(1, AXES.len()),
        }
    }

    /// Of the log that has this tick.
    pub(super) fn of_tick(tick: &AnyTick) -> Self {
        match tick {
            AnyTick::One(_) => Self::of(1),
            AnyTick::Vector(tick) => Self::of(tick.axes()),
        }
    }

    pub(super) const fn axes(self) -> usize {
        self.axes
    }

    /// How many there are.
    pub(super) const fn count(self) -> usize {
        match self.axes {
            1 => ONE_AXIS.len(),
            axes => axes * VectorTick::VECTORS.len() + OF_ALL.len(),
        }
    }

    /// Their names, in the order of a row: `position_x_m`, `position_y_m`, …
    pub(super) fn names(self) -> Vec<String> {
        if self.axes == 1 {
            return ONE_AXIS.map(str::to_owned).to_vec();
        }
        let vectors = VectorTick::VECTORS.iter().flat_map(|(field, _)| {
            let axes = AXES.iter().take(self.axes);
            axes.map(|axis| column(field, axis))
        });
        vectors.chain(OF_ALL.map(str::to_owned)).collect()
    }

    /// The numbers of a tick, one for each name; none of a tick of another number of axes.
    pub(super) fn numbers(self, tick: &AnyTick, numbers: &mut Vec<f64>) {
        numbers.clear();
        match tick {
            AnyTick::One(tick) if self.axes == 1 => numbers.extend(one_axis(tick)),
            AnyTick::Vector(tick) if self.axes == tick.axes() => {
                for (_, field) in VectorTick::VECTORS.iter() {
                    numbers.extend(field(tick).as_slice());
                }
                numbers.extend([
                    tick.commanded_force_n.norm(),
                    tick.observed_energy_j,
                    f64::from(tick.limiters),
                    f64::from(tick.flaws),
                ]);
            }
            _ => {}
        }
    }

    /// A row of a pyramid; none, which is no number, of a tick of another number of axes.
    pub(super) fn row(self, tick: &AnyTick) -> Vec<f32> {
        let mut numbers = Vec::with_capacity(self.count());
        self.numbers(tick, &mut numbers);
        numbers.into_iter().map(|number| number as f32).collect()
    }
}

fn one_axis(tick: &TickMessage) -> [f64; ONE_AXIS.len()] {
    [
        tick.position_m,
        tick.commanded_force_n,
        tick.applied_force_n,
        tick.environment_force_n,
        tick.reference_m,
        tick.indenter_position_m,
        tick.contact_force_n,
        tick.observed_energy_j,
        f64::from(tick.limiters),
        f64::from(tick.flaws),
    ]
}

/// The places of channels among those of a log.
///
/// # Errors
/// A channel that it has not.
pub(crate) fn places(wanted: &[String], names: &[String]) -> Result<Vec<usize>, Failure> {
    let place = |name: &String| {
        let place = names.iter().position(|known| known == name);
        place.ok_or_else(|| {
            Failure::bad_input(format_args!(
                "there is no channel {name:?}: take some of {}",
                names.join(", ")
            ))
        })
    };
    wanted.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_number_for_each_name() {
        for axes in [2, 3] {
            let channels = Channels::of(axes);
            let names = channels.names();
            let place = [0.1, 0.2, 0.3];
            let tick = VectorTick {
                position_m: haptic_log::record::PerAxis::new(&place[..axes]).expect("up to three"),
                commanded_force_n: haptic_log::record::PerAxis::new(&[3.0, 4.0, 0.0][..axes])
                    .expect("up to three"),
                limiters: 2,
                ..VectorTick::at_rest(axes)
            };
            let row = channels.row(&tick.into());
            assert_eq!(
                (names.len(), row.len()),
                (channels.count(), channels.count())
            );
            let of = |name: &str| row[names.iter().position(|n| n == name).expect("there")];
            assert_eq!((of("position_x_m"), of("position_y_m")), (0.1, 0.2));
            assert_eq!((of("commanded_force_norm_n"), of("limiter")), (5.0, 2.0));
            assert_eq!(names.contains(&"position_z_m".to_owned()), axes == 3);
        }
        let one = Channels::of(1);
        let row = one.row(&TickMessage::default().into());
        assert_eq!((one.names().len(), row.len()), (one.count(), one.count()));
    }

    #[test]
    fn a_tick_of_other_axes_is_no_number() {
        assert!(
            Channels::of(1)
                .row(&VectorTick::at_rest(2).into())
                .is_empty()
        );
        assert!(
            Channels::of(3)
                .row(&VectorTick::at_rest(2).into())
                .is_empty()
        );
        assert_eq!(Channels::of_tick(&VectorTick::at_rest(3).into()).axes(), 3);
    }
}
