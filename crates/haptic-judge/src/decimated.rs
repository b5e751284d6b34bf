//! The points of long curves that a picture needs: no peak is lost, memory is bounded.
//!
//! ```text
//! sample n < dense          kept
//! later                     of each n/2000 samples the first, the last, and the extremes of each curve
//! ```
//! Groups that grow with n are equally wide on a logarithmic axis of time, and narrower than a pixel
//! on both a logarithmic and a linear one.

use crate::curves::{Curves, Drawing};
use haptic_trial::samples::WHOLE_MOST;

/// Groups are this share of the samples before them.
const SHARE: u64 = 2000;

/// M curves over one time.
#[derive(Clone, Debug)]
pub struct Decimated<const M: usize> {
    dense: u64,
    count: u64,
    /// The group that is being filled, and with which sample it ends.
    group: Vec<Point<M>>,
    group_end: u64,
    /// Time of each point, s.
    time_s: Vec<f64>,
    /// The curves at these times.
    curves: [Vec<f64>; M],
}

#[derive(Clone, Copy, Debug)]
struct Point<const M: usize> {
    sample: u64,
    time_s: f64,
    values: [f64; M],
}

impl<const M: usize> Decimated<M> {
    /// Empty, for a run whose samples are all kept in memory, or not: so many points are kept of the curves.
    #[must_use]
    pub fn kept(all: bool) -> Self {
        Self::new(if all { WHOLE_MOST } else { 0 })
    }

    /// Empty; the first `dense` samples are all kept.
    #[must_use]
    pub fn new(dense: u64) -> Self {
        Self {
            dense: dense.max(SHARE),
            count: 0,
            group: Vec::new(),
            group_end: 0,
            time_s: Vec::new(),
            curves: [const { Vec::new() }; M],
        }
    }

    /// Adds the next sample; times must increase.
    pub fn add(&mut self, time_s: f64, values: [f64; M]) {
        let point = Point {
            sample: self.count,
            time_s,
            values,
        };
        self.count += 1;
        if point.sample < self.dense {
            self.keep(point);
            return;
        }
        if point.sample >= self.group_end {
            self.close();
            self.group_end = point.sample + point.sample / SHARE;
        }
        self.group_add(point);
    }

    /// The number of samples so far, and the times and curves kept from them.
    #[must_use]
    pub fn curves(mut self) -> (u64, Vec<f64>, [Vec<f64>; M]) {
        self.close();
        (self.count, self.time_s, self.curves)
    }

    /// The curves under these names; one without a name is left out.
    pub fn named(
        self,
        names: [&'static str; M],
        origin: &'static str,
        title: String,
        subtitle: String,
        drawing: Drawing,
    ) -> Curves {
        let (_, time_s, curves) = self.curves();
        let columns = names.into_iter().zip(curves);
        Curves {
            title,
            subtitle,
            origin,
            time_s,
            columns: columns.filter(|(name, _)| !name.is_empty()).collect(),
            drawing,
        }
    }

    /// The group holds first, last, then lowest and highest of each curve.
    fn group_add(&mut self, point: Point<M>) {
        if self.group.is_empty() {
            self.group = vec![point; 2 + 2 * M];
            return;
        }
        self.group[1] = point;
        for (curve, value) in point.values.into_iter().enumerate() {
            let (low, high) = (2 + 2 * curve, 3 + 2 * curve);
            // NaN gives way to any number.
            if value < self.group[low].values[curve] || self.group[low].values[curve].is_nan() {
                self.group[low] = point;
            }
            if value > self.group[high].values[curve] || self.group[high].values[curve].is_nan() {
                self.group[high] = point;
            }
        }
    }

    fn close(&mut self) {
        let mut group = std::mem::take(&mut self.group);
        group.sort_by_key(|point| point.sample);
        group.dedup_by_key(|point| point.sample);
        group.into_iter().for_each(|point| self.keep(point));
    }

    fn keep(&mut self, point: Point<M>) {
        self.time_s.push(point.time_s);
        for (curve, value) in self.curves.iter_mut().zip(point.values) {
            curve.push(value);
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "points are kept as they are")]
mod tests {
    use crate::decimated::*;

    fn thinned(samples: u64, dense: u64, curve: impl Fn(u64) -> f64) -> Decimated<1> {
        let mut thinned = Decimated::new(dense);
        (0..samples).for_each(|n| thinned.add(1e-3 * n as f64, [curve(n)]));
        thinned.close();
        thinned
    }

    #[test]
    fn a_short_curve_is_kept_as_it_is() {
        let kept = thinned(5000, 5000, |n| (n as f64).sin());
        assert_eq!(kept.time_s.len(), 5000);
        assert!((0..5000).all(|n| kept.curves[0][n] == (n as f64).sin()));
    }

    #[test]
    fn no_peak_of_a_long_curve_is_lost_and_its_points_stay_few() {
        let peaks = [2_001, 77_777, 123_456, 2_999_998];
        let curve = |n: u64| {
            if peaks.contains(&n) {
                1e3 + n as f64
            } else if n.is_multiple_of(7) {
                f64::NAN
            } else {
                (n as f64 * 0.01).sin()
            }
        };
        let kept = thinned(3_000_000, 0, curve);
        for peak in peaks {
            let value = 1e3 + peak as f64;
            let found = kept.curves[0].iter().position(|&have| have == value);
            let index = found.unwrap_or_else(|| panic!("{peak} is lost"));
            assert_eq!(kept.time_s[index], 1e-3 * peak as f64);
        }
        assert!(kept.time_s.len() < 70_000, "{}", kept.time_s.len());
        assert!(kept.time_s.is_sorted());
        // The ends of the curve are ends of the picture.
        assert_eq!(kept.time_s.first(), Some(&0.0));
        assert_eq!(kept.time_s.last(), Some(&(1e-3 * 2_999_999.0)));
    }
}
