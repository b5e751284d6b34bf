//! Axes: what they can show and how far they reach.

/// No axis needs its ticks made fewer more often than this to have one at most.
const MOST_THINNED: u32 = 60;
/// Room beyond the values, as a share of a linear axis or a factor on a logarithmic one.
const LINEAR_ROOM: f64 = 0.06;
const LOG_ROOM: f64 = 1.15;

/// Beyond any quantity of this project; sums and differences of what lies within are finite.
const LARGEST: f64 = 1e30;
/// An axis is not narrower than this share of its values, or its ticks would not differ in `f64`.
const NARROWEST: f64 = 1e-9;

/// Linear or logarithmic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal lengths.
    Linear,
    /// Equal ratios are equal lengths; what is not positive has no place.
    Log,
}

impl Scale {
    /// True if a value has a place on such an axis.
    pub(crate) fn can_show(self, value: f64) -> bool {
        match self {
            Self::Linear => value.abs() <= LARGEST,
            Self::Log => (1.0 / LARGEST..=LARGEST).contains(&value),
        }
    }

    /// The value in units of equal length on the paper.
    pub(crate) fn forward(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }
}

/// One axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// With the unit; empty where a neighbour or the page says it.
    pub(crate) label: String,
    pub(crate) scale: Scale,
    /// The ends.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Length on the paper, px; infinite until [`Axis::fit`] knows it.
    pub(crate) length: f64,
    /// Number of times that ticks were made fewer so that their labels fit.
    pub(crate) thinned: u32,
}

impl Axis {
    fn new(label: &str, scale: Scale, (low, high): (f64, f64)) -> Self {
        Self {
            label: label.to_owned(),
            scale,
            low,
            high,
            length: f64::INFINITY,
            thinned: 0,
        }
    }

    /// An axis from one end to the other; `None` if it cannot show one of them, or they are too
    /// close or in the wrong order.
    pub(crate) fn between(label: &str, scale: Scale, low: f64, high: f64) -> Option<Self> {
        let ends = scale.can_show(low) && scale.can_show(high);
        let span = scale.forward(high) - scale.forward(low);
        let narrowest = NARROWEST * scale.forward(low).abs().max(scale.forward(high).abs());
        (ends && span > narrowest).then(|| Self::new(label, scale, (low, high)))
    }

    /// An axis that begins and ends with the values, or with 0 if that is near.
    pub(crate) fn tight(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let (wide_low, wide_high) = match scale {
            Scale::Linear => linear_range(low, high),
            Scale::Log => log_range(low, high),
        };
        // Zero is the only edge that is much nearer to zero than the values.
        let end = |edge: f64, value: f64| {
            if edge.abs() < 0.5 * value.abs() {
                edge
            } else {
                value
            }
        };
        let ends = match scale {
            Scale::Linear => (end(wide_low, low), end(wide_high, high)),
            Scale::Log if high / low < 10.0 => (wide_low, wide_high),
            Scale::Log => (low, high),
        };
        Self::between(label, scale, ends.0, ends.1)
            .unwrap_or_else(|| Self::new(label, scale, (wide_low, wide_high)))
    }

    /// An axis of time: it ends with the values, and a linear one begins a little before them, so
    /// that what happens at the start is not hidden by the edge.
    pub(crate) fn time(scale: Scale, low: f64, high: f64) -> Self {
        let (low, high) = match scale {
            Scale::Linear => match high - low {
                span if span > NARROWEST * high.abs() => (low - 0.02 * span, high),
                _ => (
                    low - 0.5 * low.abs().max(1.0),
                    high + 0.5 * high.abs().max(1.0),
                ),
            },
            // Less than a decade may hold no tick at all, so it grows to the next ones.
            Scale::Log if high / low < 10.0 => (step_below(low), step_above(high)),
            Scale::Log => (low, high),
        };
        Self::new("time / s", scale, (low, high))
    }

    /// An axis with room around the values: from 0 if that is near, or to the next ticks on a
    /// logarithmic axis.
    pub(crate) fn around(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let ends = match scale {
            Scale::Linear => linear_range(low, high),
            Scale::Log => log_range(low, high),
        };
        Self::new(label, scale, ends)
    }

    /// Gives the axis its length on the paper, and no more ticks than their labels have room for;
    /// `extent` is what a label takes along the axis with the gap to the next one.
    pub(crate) fn fit(&mut self, length: f64, extent: impl Fn(&str) -> f64) {
        self.length = length;
        let crowded = |axis: &Self| {
            let labels = axis.labels();
            labels.windows(2).any(|pair| {
                let needed = (extent(&pair[0].1) + extent(&pair[1].1)) / 2.0;
                (pair[1].0 - pair[0].0) * length < needed
            })
        };
        while crowded(self) && self.thinned < MOST_THINNED {
            self.thinned += 1;
        }
    }

    /// Place of a value, 0 at the low end of the axis and 1 at the high end.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        let (low, high) = self.range();
        (self.scale.forward(value) - low) / (high - low)
    }

    /// The ends in units of equal length on the paper.
    pub(crate) fn range(&self) -> (f64, f64) {
        (self.scale.forward(self.low), self.scale.forward(self.high))
    }
}

/// The least and the largest value; infinite if there is none.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// Ends of a logarithmic axis around these values: the next powers of ten or, over few decades,
/// the next 1, 2 or 5 times one.
fn log_range(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = (low / LOG_ROOM, high * LOG_ROOM);
    if high / low > 1e3 {
        let decade = |exponent: f64| 10f64.powf(exponent);
        (decade(low.log10().floor()), decade(high.log10().ceil()))
    } else {
        (step_below(low), step_above(high))
    }
}

/// Ends of a linear axis around these values: 0 if that is near, or with some room.
fn linear_range(low: f64, high: f64) -> (f64, f64) {
    let zero_is_near = |near: f64, far: f64| near >= 0.0 && near < 0.5 * far;
    let largest = low.abs().max(high.abs());
    let span = match high - low {
        _ if largest == 0.0 => 1.0,
        span if span > NARROWEST * largest => span,
        _ => largest,
    };
    let low_edge = if zero_is_near(low, high) {
        0.0
    } else {
        low - LINEAR_ROOM * span
    };
    let high_edge = if zero_is_near(-high, -low) {
        0.0
    } else {
        high + LINEAR_ROOM * span
    };
    (low_edge, high_edge)
}

/// The next of 1, 2, 5 times a power of ten at or below a positive value.
fn step_below(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let step = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|step| step * decade <= value * (1.0 + 1e-9));
    step.unwrap_or(1.0) * decade
}

/// The next of 1, 2, 5 times a power of ten at or above a positive value.
fn step_above(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let step = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|step| step * decade >= value * (1.0 - 1e-9));
    step.unwrap_or(10.0) * decade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_place_however_small() {
        let axis = Axis::around("relative error", Scale::Log, 1e-15, 1e-12);
        let decade = axis.fraction(1e-13) - axis.fraction(1e-14);
        let decades = (axis.high / axis.low).log10();
        assert!((decade * decades - 1.0).abs() < 1e-12, "{decade}");
    }

    #[test]
    fn an_axis_that_cannot_be_drawn_is_refused() {
        let between = |scale, low, high| Axis::between("", scale, low, high).is_some();
        assert!(between(Scale::Linear, -1.0, 1.0) && between(Scale::Log, 0.1, 1.0));
        for (low, high) in [
            (1.0, 1.0),
            (1.0, 0.5),
            (f64::NAN, 1.0),
            (0.0, f64::INFINITY),
        ] {
            assert!(!between(Scale::Linear, low, high), "{low} {high}");
        }
        assert!(!between(Scale::Log, 0.0, 1.0) && !between(Scale::Log, -1.0, 1.0));
    }

    #[test]
    fn a_tight_axis_ends_with_its_values_but_is_never_empty() {
        let ends = |scale, low, high| {
            let axis = Axis::tight("", scale, low, high);
            (axis.low, axis.high)
        };
        assert_eq!(ends(Scale::Linear, 0.1, 3.0), (0.0, 3.0));
        assert_eq!(ends(Scale::Linear, 2.0, 3.0), (2.0, 3.0));
        assert_eq!(ends(Scale::Log, 0.003, 3.0), (0.003, 3.0));
        assert_eq!(ends(Scale::Log, 3.0, 6.0), (2.0, 10.0));
        for value in [-2.0, 0.0, 2.0] {
            let (low, high) = ends(Scale::Linear, value, value);
            assert!(low < high && (low..=high).contains(&value), "{low} {high}");
        }
    }

    #[test]
    fn a_linear_axis_of_a_constant_is_not_empty() {
        for value in [0.0, 3.0, -3.0] {
            let axis = Axis::around("force / N", Scale::Linear, value, value);
            assert!(axis.low < axis.high, "{value}");
            assert!((axis.low..=axis.high).contains(&value), "{value}");
        }
    }
}
