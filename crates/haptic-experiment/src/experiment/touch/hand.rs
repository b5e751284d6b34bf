//! The hand: a path, and how it holds the device on it.

use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::experiment::touch::keys::{
    TOUCH_CIRCLE_CENTRE, TOUCH_CIRCLE_PERIOD, TOUCH_CIRCLE_RADIUS, TOUCH_CIRCLE_START, TOUCH_WAY,
};
use fracdiff::parameter::Shown;
use std::f64::consts::{PI, TAU};

/// How the hand moves the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// By a spring to the point of the path, N/m, above 0.
    Spring(f64),
    /// By the force that is the point of the path, N.
    Force,
}

/// The same by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GripName {
    /// A spring.
    Spring,
    /// A force.
    Force,
}

impl Named for GripName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Spring,
            "spring",
            "A spring to a point that moves along the path",
        ),
        (Self::Force, "force", "A force that follows the path"),
    ];
}

/// Path of the hand over time, m or N.
#[derive(Clone, Debug, PartialEq)]
pub enum HandPath {
    /// Straight from row to row: time in s, then a number an axis. Before the first and behind the last row it stands.
    WayPoints(Vec<(f64, Vec<f64>)>),
    /// A circle in the plane of the first two axes, m, beginning along the first. From `start_radius` the hand spirals to
    /// `radius` in 1 s.
    Circle {
        /// Centre, a number an axis.
        centre: Vec<f64>,
        /// Radius at the start, above 0.
        start_radius: f64,
        /// Radius, above 0.
        radius: f64,
        /// Time of a turn, s, above 0.
        period_s: f64,
    },
}

impl HandPath {
    /// Time in which a circle is reached, s.
    pub(crate) const APPROACH_S: f64 = 1.0;

    /// Refuses a path that is none for so many axes.
    ///
    /// # Errors
    /// No rows, rows of another length, times that do not rise; a centre of another length.
    pub(super) fn check(&self, axes: usize) -> Result<(), Failure> {
        match self {
            Self::WayPoints(rows) => {
                if rows.is_empty() {
                    return Err(Failure::bad_input(format_args!(
                        "{TOUCH_WAY} is empty: give a row at least"
                    )));
                }
                for (n, (time_s, place)) in rows.iter().enumerate() {
                    if place.len() != axes {
                        return Err(Failure::bad_input(format_args!(
                            "row {} of {TOUCH_WAY} has {} numbers behind its time, not one for each of {axes} axes",
                            n + 1,
                            place.len()
                        )));
                    }
                    let before = n.checked_sub(1).map_or(f64::NEG_INFINITY, |n| rows[n].0);
                    if *time_s <= before || *time_s < 0.0 {
                        return Err(Failure::bad_input(format_args!(
                            "row {} of {TOUCH_WAY} is at {time_s} s, which is not at least 0 and later than the row before",
                            n + 1,
                            time_s = Shown(*time_s)
                        )));
                    }
                }
                Ok(())
            }
            Self::Circle { centre, .. } if centre.len() != axes => {
                Err(Failure::bad_input(format_args!(
                    "{TOUCH_CIRCLE_CENTRE} has {} numbers, not one for each of {axes} axes",
                    centre.len()
                )))
            }
            Self::Circle {
                start_radius,
                radius,
                period_s,
                ..
            } => {
                if [start_radius, radius, period_s].iter().all(|x| **x > 0.0) {
                    return Ok(());
                }
                Err(Failure::bad_input(format_args!(
                    "a circle has sizes that are not above 0: change {TOUCH_CIRCLE_START}, {TOUCH_CIRCLE_RADIUS} or \
                     {TOUCH_CIRCLE_PERIOD}"
                )))
            }
        }
    }

    /// Coordinate of an axis at a time, s.
    #[must_use]
    pub fn at(&self, time_s: f64, axis: usize) -> f64 {
        match self {
            Self::Circle {
                centre,
                start_radius,
                radius,
                period_s,
            } => {
                // (1 − cos)/2 of the way in.
                let share = (time_s / Self::APPROACH_S).clamp(0.0, 1.0);
                let risen = 0.5 * (1.0 - (PI * share).cos());
                let radius = start_radius + risen * (radius - start_radius);
                let angle = TAU * time_s / period_s;
                let round = match axis {
                    0 => angle.cos(),
                    1 => angle.sin(),
                    _ => 0.0,
                };
                centre.get(axis).copied().unwrap_or(0.0) + radius * round
            }
            Self::WayPoints(rows) => {
                let place = |row: &(f64, Vec<f64>)| row.1.get(axis).copied().unwrap_or(0.0);
                let next = rows.partition_point(|row| row.0 <= time_s);
                match (next.checked_sub(1).map(|n| &rows[n]), rows.get(next)) {
                    (Some(from), Some(to)) => {
                        let share = (time_s - from.0) / (to.0 - from.0);
                        place(from) + share * (place(to) - place(from))
                    }
                    (Some(row), None) | (None, Some(row)) => place(row),
                    (None, None) => 0.0,
                }
            }
        }
    }

    /// In a few words.
    #[must_use]
    pub(crate) fn words(&self) -> String {
        match self {
            Self::WayPoints(rows) => format!("{} way points", rows.len()),
            Self::Circle {
                radius, period_s, ..
            } => {
                format!("a circle of {} mm in {period_s} s", 1e3 * radius)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn way_points_are_joined_by_straight_lines_and_end_where_they_end() {
        let path = HandPath::WayPoints(vec![
            (0.5, vec![0.0, 1.0]),
            (1.5, vec![2.0, 1.0]),
            (2.0, vec![2.0, -1.0]),
        ]);
        path.check(2).expect("a path");
        for (time_s, want) in [
            (0.0, [0.0, 1.0]),
            (0.5, [0.0, 1.0]),
            (1.0, [1.0, 1.0]),
            (1.75, [2.0, 0.0]),
            (9.0, [2.0, -1.0]),
        ] {
            for (axis, want) in want.into_iter().enumerate() {
                let have = path.at(time_s, axis);
                assert!((have - want).abs() < 1e-15, "{time_s} s, {axis}: {have}");
            }
        }
    }

    #[test]
    fn a_circle_begins_along_the_first_axis_and_comes_back() {
        let path = HandPath::Circle {
            centre: vec![0.1, 0.2, 0.3],
            start_radius: 0.06,
            radius: 0.05,
            period_s: 2.0,
        };
        path.check(3).expect("a path");
        for (time_s, want) in [
            (0.0, [0.16, 0.2, 0.3]),
            (0.5, [0.1, 0.255, 0.3]),
            (1.0, [0.05, 0.2, 0.3]),
            (1.5, [0.1, 0.15, 0.3]),
            (3.0, [0.05, 0.2, 0.3]),
        ] {
            for (axis, want) in want.into_iter().enumerate() {
                assert!((path.at(time_s, axis) - want).abs() < 1e-15);
            }
        }
        assert!(path.check(2).is_err());
    }

    #[test]
    fn rows_that_are_no_path_are_refused() {
        for (rows, word) in [
            (vec![], "is empty"),
            (vec![(0.0, vec![1.0])], "row 1"),
            (vec![(0.0, vec![1.0, 2.0]), (0.0, vec![1.0, 2.0])], "row 2"),
            (vec![(-1.0, vec![1.0, 2.0])], "row 1"),
        ] {
            let error = HandPath::WayPoints(rows).check(2).expect_err("refused");
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
