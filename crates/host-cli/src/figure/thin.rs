//! Thins curves to what a panel can show.
//!
//! The axis is divided into equal bins (equal in log t on a logarithmic axis). Of each bin the
//! first, lowest, highest and last point stay or, for an envelope, the highest alone. So no peak
//! is lost, and the picture is the same as with all points as long as bins are narrower than a
//! line. Points that an axis cannot show (not finite, or not positive on a logarithmic axis) are
//! left out here, for all panels.

use super::axis::Scale;

/// Points of a curve, x and y.
pub(super) type Points = Vec<(f64, f64)>;

/// Which points of a bin stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    /// First, lowest, highest, last: the curve as it is.
    Shape,
    /// The highest: an upper envelope.
    Highest,
}

/// The points of `(x, y)` that axes of these scales can show.
pub(super) fn showable(x: &[f64], y: &[f64], x_scale: Scale, y_scale: Scale) -> Points {
    (x.iter().zip(y))
        .filter(|(x, y)| x_scale.can_show(**x) && y_scale.can_show(**y))
        .map(|(x, y)| (*x, *y))
        .collect()
}

/// Thins points to at most `4·bins` of them, or `bins` for an envelope, ordered by bin.
pub(super) fn thin(points: &Points, x_scale: Scale, bins: usize, keep: Keep) -> Points {
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
    for bin in kept.iter().filter_map(|bin| bin.0) {
        let mut indices = match keep {
            Keep::Shape => vec![bin.first, bin.lowest, bin.highest, bin.last],
            Keep::Highest => vec![bin.highest],
        };
        indices.sort_unstable();
        indices.dedup();
        thinned.extend(indices.into_iter().map(|index| points[index]));
    }
    thinned
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
    fn points_at_one_place_do_not_divide_by_zero() {
        let points: Points = (0..10_000).map(|i| (1.0, f64::from(i))).collect();
        let thinned = thin(&points, Scale::Log, 100, Keep::Shape);
        assert_eq!(thinned, [(1.0, 0.0), (1.0, 9_999.0)]);
    }
}
