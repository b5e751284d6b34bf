//! Thins curves to what a panel can show.
//!
//! Points that an axis cannot show (not finite, or not positive on a logarithmic axis) are left out for all panels. Where the place of
//! every point on the paper is known, [`simplify`] leaves out those on straight stretches (D. H. Douglas and T. K. Peucker, "Algorithms for
//! the reduction of the number of points required to represent a digitized line", 1973), which no one can see, and only then coarsens.

use crate::axis::{Scale, extremes};
use std::collections::{HashMap, HashSet};

/// A point this far from a straight line, px, is seen on it: a tenth of a pixel of the PNG.
const INVISIBLE: f64 = 0.05;
/// The narrowest columns of points of which only the extremes stay, px.
const FINEST_COLUMN: f64 = 0.125;
/// Most points among which straight stretches are searched: in the worst case the cost grows with the square of their number.
const LONGEST_EXACT: usize = 6_000;

/// Points of a curve, x and y.
pub(crate) type Points = Vec<Place>;

/// A place, px to the right and down, or as shares of a box.
pub(crate) type Place = (f64, f64);

/// The highest point of each of `bins` equal bins of the axis, in order: an upper envelope.
///
/// A curve through the changes of sign of an error would be a hedge of spikes on a logarithmic axis.
#[must_use]
pub fn envelope(points: &[(f64, f64)], x_scale: Scale, bins: usize) -> Vec<(f64, f64)> {
    if points.len() <= bins {
        return points.to_vec();
    }
    let forward = |point: &(f64, f64)| x_scale.forward(point.0);
    let (low, high) = extremes(points.iter().map(forward));
    let per_unit = bins as f64 / (high - low);
    let mut highest = vec![None::<(f64, f64)>; bins];
    for point in points {
        // All points at one place make `per_unit` infinite and the product NaN, which casts to 0.
        let bin = ((forward(point) - low) * per_unit) as usize;
        let highest = highest[bin.min(bins - 1)].get_or_insert(*point);
        if point.1 > highest.1 {
            *highest = *point;
        }
    }
    highest.into_iter().flatten().collect()
}

/// Thins a curve on the paper, in px, to at most `most` points, or 4 where that is less.
pub(crate) fn simplify(points: Points, most: usize) -> Points {
    let most = most.max(4);
    let mut kept = points;
    let mut column = FINEST_COLUMN;
    loop {
        if kept.len() <= LONGEST_EXACT {
            kept = without_straight(&kept);
            if kept.len() <= most {
                return kept;
            }
        }
        kept = by_column(&kept, column);
        column *= 2.0;
    }
}

/// Thins dots on the paper to at most `most` of them, or 1: of dots that cover each other one stays.
pub(crate) fn scatter(points: Points, most: usize) -> Points {
    let mut kept = points;
    let mut cell = FINEST_COLUMN;
    loop {
        let mut taken = HashSet::new();
        kept.retain(|(x, y)| taken.insert(((x / cell) as i64, (y / cell) as i64)));
        if kept.len() <= most.max(1) {
            return kept;
        }
        cell *= 2.0;
    }
}

/// First, lowest, highest and last point of each run of points through one column of the paper.
fn by_column(points: &Points, width: f64) -> Points {
    let left = extremes(points.iter().map(|point| point.0)).0;
    let column = |point: &(f64, f64)| ((point.0 - left) / width) as u64;
    let mut thinned = Points::new();
    for run in points.chunk_by(|a, b| column(a) == column(b)) {
        let (mut lowest, mut highest) = (0, 0);
        for (index, point) in run.iter().enumerate() {
            if point.1 < run[lowest].1 {
                lowest = index;
            }
            if point.1 > run[highest].1 {
                highest = index;
            }
        }
        let mut kept = vec![0, lowest, highest, run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        thinned.extend(kept.into_iter().map(|index| run[index]));
    }
    thinned
}

/// The curve without points that lie on it anyway.
fn without_straight(points: &Points) -> Points {
    if points.len() < 3 {
        return points.clone();
    }
    let mut stays = vec![false; points.len()];
    let last = points.len() - 1;
    (stays[0], stays[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let distances = (from + 1..to).map(|i| (distance(points[i], points[from], points[to]), i));
        let farthest = distances.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, index)) = farthest.filter(|found| found.0 > INVISIBLE) {
            stays[index] = true;
            stretches.extend([(from, index), (index, to)]);
        }
    }
    let kept = points.iter().zip(stays).filter(|(_, stays)| *stays);
    kept.map(|(point, _)| *point).collect()
}

/// Distance of a point from the straight stretch between two others.
fn distance(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (along_x, along_y) = (to.0 - from.0, to.1 - from.1);
    let (x, y) = (point.0 - from.0, point.1 - from.1);
    let length_squared = along_x * along_x + along_y * along_y;
    let share = if length_squared > 0.0 {
        ((x * along_x + y * along_y) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(x - share * along_x, y - share * along_y)
}

/// Distance of the cut from the box, as a share of its sides: more than half a line's width.
const BEYOND: f64 = 0.1;

/// The part of a curve inside and just outside the box; `closed` if its last point leads back to
/// its first. Empty if the curve passes the box by.
pub(crate) fn clip(points: &[(f64, f64)], closed: bool) -> Points {
    let mut kept = points.to_vec();
    for depth in DEPTHS {
        kept = cut(&kept, closed, depth);
    }
    // A remainder that lies wholly beyond one side is a walk outside it.
    let outside = |depth: Depth| kept.iter().all(|point| depth(*point) < BEYOND);
    if DEPTHS.into_iter().any(outside) {
        kept.clear();
    }
    kept
}

/// Distance of a point from a cut, positive towards the box.
type Depth = fn((f64, f64)) -> f64;

const DEPTHS: [Depth; 4] = [
    |point| BEYOND + point.0,
    |point| BEYOND + (1.0 - point.0),
    |point| BEYOND + point.1,
    |point| BEYOND + (1.0 - point.1),
];

/// The part of a curve on the inner side of one cut, whose ends on the cut are joined.
fn cut(points: &[(f64, f64)], closed: bool, depth_of: Depth) -> Points {
    let mut kept = Points::with_capacity(points.len());
    let mut before = if closed { points.last() } else { None };
    for point in points {
        let depth = depth_of(*point);
        if let Some(before) = before {
            let depth_before = depth_of(*before);
            if (depth < 0.0) != (depth_before < 0.0) {
                let share = depth_before / (depth_before - depth);
                let between = |from: f64, to: f64| from + share * (to - from);
                kept.push((between(before.0, point.0), between(before.1, point.1)));
            }
        }
        if depth >= 0.0 {
            kept.push(*point);
        }
        before = Some(point);
    }
    kept
}

/// Length of path, over the width, after which a return to a place counts; before, the path is only slow.
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
    /// True if all of a piece of the path, which begins `walked` along it, lies where the path was long before; and its length.
    fn passes(&mut self, from: Place, to: Place, walked: f64) -> (bool, f64) {
        let (x, y) = (to.0 - from.0, to.1 - from.1);
        let length = libm::hypot(x, y);
        if !length.is_finite() {
            return (false, 0.0);
        }
        let steps = (length / self.width).ceil().max(1.0);
        let mut again = true;
        for step in 1..=steps as u64 {
            let share = step as f64 / steps;
            let here = (from.0 + share * x, from.1 + share * y);
            again &= self.was_here(here, walked + share * length);
        }
        (again, length)
    }

    fn was_here(&mut self, here: Place, walked: f64) -> bool {
        let cell = |at: f64| (at / self.width).floor() as i64;
        let (column, row) = (cell(here.0), cell(here.1));
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

    #[test]
    fn thinning_keeps_ends_peaks_and_order() {
        let mut points: Points = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[54_400].1 = -7.0;
        let thinned = simplify(points.clone(), 1_200);
        assert!(thinned.len() <= 1_200);
        for wanted in [points[0], points[54_321], points[54_400], points[99_999]] {
            assert!(thinned.contains(&wanted), "{wanted:?} is lost");
        }
        assert!(thinned.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn an_envelope_has_each_peak_and_as_many_points_in_the_first_decade_as_in_the_last() {
        let mut points: Points = (1..=200_000).map(|i| (f64::from(i) * 1e-3, 1.0)).collect();
        points[54_321].1 = 7.0;
        let thinned = envelope(&points, Scale::Log, 500);
        assert!(thinned.len() <= 500 && thinned.contains(&points[54_321]));
        let in_decade = |low: f64| {
            let within = thinned.iter().filter(|p| p.0 >= low && p.0 < 10.0 * low);
            within.count()
        };
        assert!(in_decade(0.1) > 80 && in_decade(10.0) > 80, "{thinned:?}");
    }

    #[test]
    fn a_smooth_loop_needs_few_points_and_is_nowhere_off() {
        let place = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 20_000.0;
            (100.0 + 80.0 * angle.cos(), 100.0 + 60.0 * angle.sin())
        };
        let points: Points = (0..20_000).map(place).collect();
        let kept = simplify(points.clone(), 4_000);
        assert!(kept.len() < 400, "{}", kept.len());
        for point in points {
            let stretches = kept.windows(2);
            let off = stretches.map(|pair| distance(point, pair[0], pair[1]));
            assert!(off.fold(f64::INFINITY, f64::min) < 0.2, "{point:?}");
        }
    }

    #[test]
    fn noise_becomes_as_few_points_as_wanted() {
        let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 12) * 1e-4;
        for most in [0, 50, 500] {
            let cloud: Points = (0..50_000).map(|i| (noise(i), noise(i + 7))).collect();
            assert!(scatter(cloud.clone(), most).len() <= most.max(1));
            let kept = simplify(cloud, most);
            assert!((2..=most.max(4)).contains(&kept.len()), "{}", kept.len());
        }
        let decaying = |i: u32| {
            let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            (
                f64::from(i) * 1e-3,
                sign * 300.0 * (-1e-5 * f64::from(i)).exp(),
            )
        };
        assert!(simplify((0..200_000).map(decaying).collect(), 2_000).len() <= 2_000);
    }

    #[test]
    fn points_at_one_place_do_not_divide_by_zero() {
        let points: Points = (0..10_000).map(|i| (1.0, f64::from(i))).collect();
        assert_eq!(envelope(&points, Scale::Log, 100), [(1.0, 9_999.0)]);
    }

    const ENDS: std::ops::RangeInclusive<f64> = -BEYOND - 1e-9..=1.0 + BEYOND + 1e-9;

    #[test]
    fn what_is_inside_stays_as_it_is() {
        let curve = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.2)];
        assert_eq!(clip(&curve, false), curve);
        assert_eq!(clip(&curve, true), curve);
    }

    #[test]
    fn a_line_through_the_box_keeps_its_slope_however_long_it_is() {
        let kept = clip(&[(-1e30, -1e30), (1e30, 1e30)], false);
        assert_eq!(kept.len(), 2);
        for (x, y) in kept {
            assert!((x - y).abs() < 1e-9 && ENDS.contains(&x), "{x} {y}");
        }
    }

    #[test]
    fn a_polygon_around_the_box_fills_it() {
        let kept = clip(&[(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)], true);
        assert_eq!(kept.len(), 4);
        assert!(
            kept.iter()
                .all(|(x, y)| ENDS.contains(x) && ENDS.contains(y))
        );
    }

    #[test]
    fn what_passes_the_box_by_is_gone() {
        assert!(clip(&[(2.0, 0.0), (3.0, 1.0)], false).is_empty());
        assert!(clip(&[(-1.0, 0.5), (0.5, 3.0), (2.0, 2.4)], true).is_empty());
        assert!(clip(&[], true).is_empty());
    }

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
