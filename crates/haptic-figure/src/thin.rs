//! Thins curves to what a panel can show.
//!
//! The axis is divided into equal bins (equal in log t on a logarithmic axis). Of each bin the
//! first, lowest, highest and last point stay or, for an envelope, the highest alone. So no peak
//! is lost, and the picture is the same as with all points as long as bins are narrower than a
//! line. Points that an axis cannot show (not finite, or not positive on a logarithmic axis) are
//! left out here, for all panels.
//!
//! That needs curves that are functions of their axis. When the place of every point on the paper
//! is known, [`simplify`] thins curves of any form: it leaves out points on straight stretches
//! (D. H. Douglas and T. K. Peucker, "Algorithms for the reduction of the number of points
//! required to represent a digitized line", 1973), which no one can see, and only then coarsens.

use std::collections::HashSet;

use crate::axis::Scale;

/// A point this far from a straight line, px, is seen on it: a tenth of a pixel of the PNG.
const INVISIBLE: f64 = 0.05;
/// The narrowest columns of points of which only the extremes stay, px.
const FINEST_COLUMN: f64 = 0.125;
/// Up to so many points straight stretches are looked for: in the worst case that takes the
/// square of their number.
const LONGEST_EXACT: usize = 6_000;

/// Points of a curve, x and y.
pub(crate) type Points = Vec<(f64, f64)>;

/// The points of a bin that stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keep {
    /// First, lowest, highest, last: the curve as it is.
    Shape,
    /// The highest: an upper envelope.
    Highest,
}

/// The points of `(x, y)` that axes of these scales can show.
pub(crate) fn showable(x: &[f64], y: &[f64], x_scale: Scale, y_scale: Scale) -> Points {
    (x.iter().zip(y))
        .filter(|(x, y)| x_scale.can_show(**x) && y_scale.can_show(**y))
        .map(|(x, y)| (*x, *y))
        .collect()
}

/// Thins points to at most `4·bins` of them, or `bins` for an envelope, ordered by bin.
pub(crate) fn thin(points: &Points, x_scale: Scale, bins: usize, keep: Keep) -> Points {
    let most = match keep {
        Keep::Shape => 4 * bins,
        Keep::Highest => bins,
    };
    if points.len() <= most {
        return points.clone();
    }
    let place = |point: &(f64, f64)| x_scale.forward(point.0);
    let low = points.iter().map(place).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(place).fold(f64::NEG_INFINITY, f64::max);
    let per_unit = bins as f64 / (high - low);
    let mut kept = vec![Bin::default(); bins];
    for (index, point) in points.iter().enumerate() {
        // All points at one place make `per_unit` infinite and the product NaN, which casts to 0.
        let bin = ((place(point) - low) * per_unit) as usize;
        kept[bin.min(bins - 1)].add(index, points);
    }
    let mut thinned = Points::new();
    for bin in &kept {
        match keep {
            Keep::Shape => thinned.extend(bin.shape().map(|index| points[index])),
            Keep::Highest => thinned.extend(bin.0.map(|bin| points[bin.highest])),
        }
    }
    thinned
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

/// Thins dots on the paper to at most `most` of them, or 1: of those that cover each other one stays.
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

/// Of each run of points through one column of the paper the first, lowest, highest and last.
fn by_column(points: &Points, width: f64) -> Points {
    let left = points
        .iter()
        .map(|point| point.0)
        .fold(f64::INFINITY, f64::min);
    let column = |point: &(f64, f64)| ((point.0 - left) / width) as u64;
    let mut thinned = Points::new();
    let mut start = 0;
    for run in points.chunk_by(|a, b| column(a) == column(b)) {
        let mut bin = Bin::default();
        for index in start..start + run.len() {
            bin.add(index, points);
        }
        start += run.len();
        thinned.extend(bin.shape().map(|index| points[index]));
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
    (x - share * along_x).hypot(y - share * along_y)
}

/// Indices of the points of a bin that may stay; `None` while it is empty.
#[derive(Clone, Copy, Debug, Default)]
struct Bin(Option<Extremes>);

#[derive(Clone, Copy, Debug)]
struct Extremes {
    first: usize,
    lowest: usize,
    highest: usize,
    last: usize,
}

impl Bin {
    fn add(&mut self, index: usize, points: &Points) {
        let extremes = self.0.get_or_insert(Extremes {
            first: index,
            lowest: index,
            highest: index,
            last: index,
        });
        extremes.last = index;
        if points[index].1 < points[extremes.lowest].1 {
            extremes.lowest = index;
        }
        if points[index].1 > points[extremes.highest].1 {
            extremes.highest = index;
        }
    }

    /// The points that show the shape of the curve in this bin, in order.
    fn shape(&self) -> impl Iterator<Item = usize> + use<> {
        let mut indices = self.0.map_or(Vec::new(), |bin| {
            vec![bin.first, bin.lowest, bin.highest, bin.last]
        });
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_ends_peaks_and_order() {
        let mut points: Points = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[54_400].1 = -7.0;
        let thinned = thin(&points, Scale::Linear, 300, Keep::Shape);
        assert!(thinned.len() <= 1_200);
        for wanted in [points[0], points[54_321], points[54_400], points[99_999]] {
            assert!(thinned.contains(&wanted), "{wanted:?} is lost");
        }
        assert!(thinned.is_sorted_by(|a, b| a.0 < b.0));
        let envelope = thin(&points, Scale::Linear, 300, Keep::Highest);
        assert!(envelope.len() <= 300 && envelope.contains(&points[54_321]));
    }

    #[test]
    fn bins_of_a_logarithmic_axis_show_the_first_decade_as_well_as_the_last() {
        let points: Points = (1..=200_000).map(|i| (f64::from(i) * 1e-3, 1.0)).collect();
        let thinned = thin(&points, Scale::Log, 500, Keep::Shape);
        let in_decade = |low: f64| {
            thinned
                .iter()
                .filter(|p| p.0 >= low && p.0 < 10.0 * low)
                .count()
        };
        assert!(
            in_decade(0.1) > 80 && in_decade(10.0) > 80,
            "{}",
            thinned.len()
        );
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
        let thinned = thin(&points, Scale::Log, 100, Keep::Shape);
        assert_eq!(thinned, [(1.0, 0.0), (1.0, 9_999.0)]);
    }
}
