//! Paths that pass a place again and again, drawn once: the second lap of a dashed line would fill the gaps of the first.

use std::collections::HashMap;

/// A path that comes back to a place after so many times the width has come again; before, it is only slow.
const LATER: f64 = 6.0;
/// Shorter stretches, as multiples of the width, stay: a path that crosses itself has no gap there.
const CROSSING: f64 = 20.0;

/// The path without the stretches that lie within about `width` of an earlier part of it; in place of each a gap, a point that is not finite.
pub(crate) fn once(path: &[(f64, f64)], width: f64) -> Vec<(f64, f64)> {
    let mut seen = Seen {
        width,
        first: HashMap::new(),
    };
    let (mut walked, mut marks) = (0.0, Vec::with_capacity(path.len()));
    for (n, &point) in path.iter().enumerate() {
        let before = n.checked_sub(1).map_or(point, |n| path[n]);
        let (again, length) = seen.passes(before, point, walked);
        walked += length;
        marks.push((again, walked));
    }
    let mut drawn = Vec::with_capacity(path.len());
    let mut n = 0;
    while n < path.len() {
        let end = n + marks[n..].iter().take_while(|mark| mark.0).count();
        let from = n.checked_sub(1).map_or(0.0, |n| marks[n].1);
        if end > n && marks[end - 1].1 - from > CROSSING * width {
            drawn.push((f64::NAN, f64::NAN));
            // The next stretch begins where this one ends.
            if end < path.len() {
                drawn.push(path[end - 1]);
            }
        } else {
            drawn.extend(&path[n..end]);
        }
        drawn.extend(path.get(end));
        n = end + 1;
    }
    drawn
}

/// Cells of the paper, each with the way that had been walked when the path was first there.
struct Seen {
    width: f64,
    first: HashMap<(i64, i64), f64>,
}

impl Seen {
    /// True if all of a piece of the path, which begins after so long a way, lies where the path was long before; and its length.
    fn passes(&mut self, (x0, y0): (f64, f64), (x1, y1): (f64, f64), walked: f64) -> (bool, f64) {
        let length = (x1 - x0).hypot(y1 - y0);
        if !length.is_finite() {
            return (false, 0.0);
        }
        let steps = (length / self.width).ceil().max(1.0);
        let mut again = true;
        for step in 1..=steps as u64 {
            let share = step as f64 / steps;
            let place = (x0 + share * (x1 - x0), y0 + share * (y1 - y0));
            again &= self.was_here(place, walked + share * length);
        }
        (again, length)
    }

    fn was_here(&mut self, (x, y): (f64, f64), walked: f64) -> bool {
        let cell = |place: f64| (place / self.width).floor() as i64;
        let (column, row) = (cell(x), cell(y));
        let long_ago = walked - LATER * self.width;
        let near = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (column + i, row + j)));
        let again = near
            .filter_map(|cell| self.first.get(&cell))
            .any(|&first| first < long_ago);
        self.first.entry((column, row)).or_insert(walked);
        again
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn length(path: &[(f64, f64)]) -> f64 {
        let pieces = path.windows(2);
        let lengths = pieces.map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1));
        lengths.filter(|length| length.is_finite()).sum()
    }

    fn circle(laps: f64, points: u32, radius: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let shares = (0..=points).map(|n| f64::from(n) / f64::from(points));
        let place = |share: f64| {
            let (angle, radius) = (laps * TAU * share, radius(share));
            (radius * angle.cos(), radius * angle.sin())
        };
        shares.map(place).collect()
    }

    #[test]
    fn a_circle_of_many_laps_is_drawn_once() {
        for (laps, points) in [(1.0, 500), (2.5, 777), (40.0, 4001)] {
            let drawn = length(&once(&circle(laps, points, |_| 100.0), 1.0));
            assert!(
                (drawn / (100.0 * TAU) - 1.0).abs() < 0.03,
                "{laps}: {drawn}"
            );
        }
    }

    #[test]
    fn a_way_there_and_back_is_drawn_once() {
        let along = (0..=400).map(|n| (200.0 - (f64::from(n) - 200.0).abs(), 0.0));
        let drawn = length(&once(&along.collect::<Vec<_>>(), 1.0));
        assert!((drawn - 200.0).abs() < 2.0 * LATER, "{drawn}");
    }

    #[test]
    fn a_path_that_crosses_itself_or_winds_stays_whole() {
        let eight: Vec<_> = (0..=1000)
            .map(|n| TAU * f64::from(n) / 1000.0)
            .map(|turn| (100.0 * turn.sin(), 100.0 * (2.0 * turn).sin()))
            .collect();
        // Ten windings, 10 widths apart.
        let spiral = circle(10.0, 4000, |share| 100.0 + 100.0 * share);
        // Standing still is no second visit.
        let still = [vec![(0.0, 0.0); 500], vec![(50.0, 0.0)]].concat();
        for path in [eight, spiral, still, Vec::new()] {
            assert_eq!(once(&path, 1.0), path);
        }
    }
}
