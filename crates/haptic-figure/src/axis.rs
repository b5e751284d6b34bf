//! Axes: what they can show and how far they reach.

/// No axis needs its ticks made fewer more often than this to have one at most.
const MOST_THINNED: u32 = 60;
/// Room beyond the values, as a share of a linear axis or a factor on a logarithmic one.
const LINEAR_ROOM: f64 = 0.06;
/// A tight axis begins with 0 if that is nearer to its values than this share of them.
const NEAR: f64 = 0.05;
const LOG_ROOM: f64 = 1.15;

/// Beyond any quantity of this project; sums and differences of what lies within are finite.
const LARGEST: f64 = 1e30;
/// An axis is not narrower than this share of its values, or its ticks would not differ in `f64`.
const NARROWEST: f64 = 1e-9;

/// Spread of the values along an axis; a logarithmic axis omits values that are not above 0.
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
            Self::Log => libm::log10(value),
        }
    }

    /// The ends of an axis with some room around these values.
    fn range_around(self, low: f64, high: f64) -> (f64, f64) {
        match self {
            Self::Linear => linear_range(low, high),
            Self::Log => log_range(low, high),
        }
    }
}

/// One axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// Quantity and unit, with the prefix that the values ask for.
    pub(crate) label: String,
    /// True where a neighbour or the page shows it.
    pub(crate) is_redundant: bool,
    /// One of the label's units, in those of the values.
    pub(crate) unit: f64,
    pub(crate) scale: Scale,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Length on the paper, px; infinite until [`Axis::fit`] knows it.
    pub(crate) length: f64,
    /// Number of times that ticks were made fewer so that their labels fit.
    pub(crate) thinned: u32,
}

impl Axis {
    fn new(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let found = match scale {
            Scale::Linear => prefixed(label, low.abs().max(high.abs())),
            Scale::Log => None,
        };
        let (label, unit) = found.unwrap_or_else(|| (label.to_owned(), 1.0));
        Self {
            label,
            is_redundant: false,
            unit,
            scale,
            low,
            high,
            length: f64::INFINITY,
            thinned: 0,
        }
    }

    /// An axis from one end to the other; `None` if it cannot show one of them, or they are too close or in the wrong order.
    pub(crate) fn between(label: &str, scale: Scale, low: f64, high: f64) -> Option<Self> {
        let ends = scale.can_show(low) && scale.can_show(high);
        let span = scale.forward(high) - scale.forward(low);
        let largest = scale.forward(low).abs().max(scale.forward(high).abs());
        (ends && span > narrowest(largest)).then(|| Self::new(label, scale, low, high))
    }

    /// An axis that begins and ends with the values, or with 0 if that is very near.
    pub(crate) fn tight(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let (wide_low, wide_high) = scale.range_around(low, high);
        // Zero is the only edge that is much nearer to zero than the values; from afar it would leave a part of the box empty.
        let end = |edge: f64, value: f64| {
            let is_zero = edge.abs() < 0.5 * value.abs();
            if is_zero && value.abs() < NEAR * (high - low) {
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
            .unwrap_or_else(|| Self::new(label, scale, wide_low, wide_high))
    }

    /// An axis with room around the values: from 0 if that is near, or to the next ticks on a logarithmic axis.
    pub(crate) fn around(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let (low, high) = scale.range_around(low, high);
        Self::new(label, scale, low, high)
    }

    /// The label; empty where a neighbour or the page shows it.
    pub(crate) fn own_label(&self) -> &str {
        if self.is_redundant { "" } else { &self.label }
    }

    /// Gives the axis its length on the paper, and no more ticks than their labels have room for;
    /// `extent` is what a label takes along the axis with the gap to the next one.
    pub(crate) fn fit(&mut self, length: f64, extent: impl Fn(&str) -> f64) {
        (self.length, self.thinned) = (length, 0);
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

/// The span that an axis is wider than, around values of this size: below the smallest that any quantity has, ticks have no decade in `f64`.
fn narrowest(largest: f64) -> f64 {
    (NARROWEST * largest).max(1.0 / LARGEST)
}

/// The least and the largest value; infinite if the iterator is empty.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// Ends of a logarithmic axis around these values: the next powers of ten or, over few decades, the next 1, 2 or 5 times one.
fn log_range(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = (low / LOG_ROOM, high * LOG_ROOM);
    if high / low > 1e3 {
        let decade = |exponent: f64| libm::exp10(exponent);
        (
            decade(libm::log10(low).floor()),
            decade(libm::log10(high).ceil()),
        )
    } else {
        (step_below(low), step_above(high))
    }
}

/// Ends of a linear axis around these values: 0 if that is near, or with some room.
fn linear_range(low: f64, high: f64) -> (f64, f64) {
    let zero_is_near = |near: f64, far: f64| near >= 0.0 && near < 0.5 * far;
    let largest = low.abs().max(high.abs());
    let span = match high - low {
        _ if largest < 1.0 / LARGEST => 1.0,
        span if span > narrowest(largest) => span,
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
    let decade = libm::exp10(libm::log10(value).floor());
    let step = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|step| step * decade <= value * (1.0 + 1e-9));
    step.unwrap_or(1.0) * decade
}

/// The next of 1, 2, 5 times a power of ten at or above a positive value.
fn step_above(value: f64) -> f64 {
    let decade = libm::exp10(libm::log10(value).floor());
    let step = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|step| step * decade >= value * (1.0 - 1e-9));
    step.unwrap_or(10.0) * decade
}

/// Most decades that each have a label; beyond, every other one.
const LABELLED_DECADES: f64 = 8.0;
/// Most decades in which 2 and 5 times each power of ten have a label too.
const FINE_DECADES: f64 = 3.0;
/// Decades whose ticks are written in plain digits, 0.001 to 10000.
const PLAIN_DECADES: std::ops::RangeInclusive<i32> = -3..=4;
/// Approximate number of ticks on a linear axis.
const LINEAR_TICKS: f64 = 5.0;
/// A decade shorter than this, px, has no small ticks.
const NARROWEST_DECADE: f64 = 18.0;
/// A tick this far beyond an end, as a share of the axis, is at the end: places are rounded.
const AT_END: f64 = 1e-9;

/// A tick; all large ones have a label, and some small ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    /// Place on the axis, 0 at the low end of the axis and 1 at the high end.
    pub(crate) fraction: f64,
    /// Between the powers of ten of a logarithmic axis.
    pub(crate) is_small: bool,
    pub(crate) label: Option<String>,
}

impl Axis {
    /// All ticks, from the low end to the high one.
    pub(crate) fn ticks(&self) -> Vec<Tick> {
        let mut ticks = self.large_ticks();
        if self.scale == Scale::Log {
            ticks.append(&mut self.small_ticks());
        }
        ticks.retain(|tick| (-AT_END..=1.0 + AT_END).contains(&tick.fraction));
        ticks.sort_by(|a, b| a.fraction.total_cmp(&b.fraction));
        ticks
    }

    /// The labels of the ticks with their places, from the low end to the high one.
    pub(crate) fn labels(&self) -> Vec<(f64, String)> {
        let ticks = self.ticks().into_iter();
        ticks
            .filter_map(|tick| Some((tick.fraction, tick.label?)))
            .collect()
    }

    /// Ticks with labels, those just beyond the ends too.
    fn large_ticks(&self) -> Vec<Tick> {
        let ((low, high), step) = (self.range(), self.tick_step());
        let largest = self.low.abs().max(self.high.abs());
        let (first, last) = ((low / step).floor() as i64, (high / step).ceil() as i64);
        let tick = |count| {
            let value = count as f64 * step;
            let label = match self.scale {
                Scale::Linear => {
                    linear_label(value / self.unit, step / self.unit, largest / self.unit)
                }
                Scale::Log => log_label(value.round() as i32, 1, self.is_plain()),
            };
            Tick {
                fraction: (value - low) / (high - low),
                is_small: false,
                label: Some(label),
            }
        };
        (first..=last).map(tick).collect()
    }

    /// Ticks of a logarithmic axis between the large ones, those beyond the ends too.
    fn small_ticks(&self) -> Vec<Tick> {
        let decades = self.decades();
        let step = self.tick_step() as i32;
        let multiples = match step {
            2.. => 1..=1,
            _ if self.length < NARROWEST_DECADE * decades => return Vec::new(),
            _ => 2..=9,
        };
        let is_plain = self.is_plain();
        let is_short = decades <= 1.0 || (decades <= FINE_DECADES && is_plain);
        let is_fine = is_short && self.thinned == 0;
        let (low, high) = self.range();
        let exponents = low.floor() as i32..=high.floor() as i32;
        let places = exponents.flat_map(|exponent| multiples.clone().map(move |m| (exponent, m)));
        let places = places.filter(|(exponent, multiple)| *multiple > 1 || exponent % step != 0);
        let tick = |at: (i32, i32)| {
            let (exponent, multiple) = at;
            let forward = f64::from(exponent) + libm::log10(f64::from(multiple));
            let has_label = is_fine && matches!(multiple, 2 | 5);
            Tick {
                fraction: (forward - low) / (high - low),
                is_small: true,
                label: has_label.then(|| log_label(exponent, multiple, is_plain)),
            }
        };
        places.map(tick).collect()
    }

    /// Step from one large tick to the next, in units of equal length on the paper.
    fn tick_step(&self) -> f64 {
        match self.scale {
            Scale::Linear => {
                let step = nice_step((self.high - self.low) / LINEAR_TICKS);
                (0..self.thinned).fold(step, |step, _| nice_step(2.0 * step))
            }
            Scale::Log => {
                let most = (self.decades() / LABELLED_DECADES).ceil().clamp(1.0, 2.0);
                most + f64::from(self.thinned.saturating_sub(1))
            }
        }
    }

    fn decades(&self) -> f64 {
        libm::log10(self.high / self.low)
    }

    /// True if all powers of ten on the axis are short enough in plain digits.
    fn is_plain(&self) -> bool {
        let (low, high) = self.range();
        let lowest = (low + 1e-9).floor() as i32;
        let highest = (high + 1e-9).floor() as i32;
        PLAIN_DECADES.contains(&lowest) && PLAIN_DECADES.contains(&highest)
    }
}

/// Units that take prefixes, and the prefixes, a factor of a thousand from each to the next; the unit alone is in the middle.
const UNITS: [&str; 6] = ["Pa", "Hz", "N", "J", "m", "s"];
const PREFIXES: [&str; 7] = ["n", "µ", "m", "", "k", "M", "G"];
/// Values up to such a one are written without another prefix.
const WITHOUT_PREFIX: std::ops::Range<f64> = 1e-2..1e5;

/// The label with a prefix to its unit at which values up to `largest` have few digits, and how many units of before that one
/// is; `None` if it is to stay.
fn prefixed(label: &str, largest: f64) -> Option<(String, f64)> {
    if WITHOUT_PREFIX.contains(&largest) || largest == 0.0 {
        return None;
    }
    let (quantity, unit) = label.rsplit_once(" / ")?;
    let (first, rest) = unit.split_at(unit.find(['·', '/']).unwrap_or(unit.len()));
    let base = UNITS.into_iter().find(|unit| first.ends_with(unit))?;
    let prefix = first.strip_suffix(base)?;
    let from = PREFIXES.iter().position(|known| *known == prefix)? as i32;
    // Nobody reads kiloseconds.
    let most = if base == "s" { 3 } else { 6 };
    let to = (from + (libm::log10(largest) / 3.0).floor() as i32).clamp(0, most);
    let label = format!("{quantity} / {}{base}{rest}", PREFIXES[to as usize]);
    Some((label, libm::pow(1e3, f64::from(to - from))))
}

/// A value of an axis in four digits, with its minus sign.
pub(crate) fn four_digits(value: f64) -> String {
    let decimals = 3 - libm::log10(value.abs()).floor() as i32;
    // A large number is rounded too: 6415000.
    let step = libm::exp10(f64::from(-decimals.min(0)));
    let (rounded, decimals) = ((value / step).round() * step, decimals.clamp(0, 9) as usize);
    let value = if step > 1.0 { rounded } else { value };
    let text = format!("{value:.decimals$}");
    text.replace('-', "−")
}

/// The nearest of 1, 2, 5, 10 times a power of ten, for ticks about this far apart.
fn nice_step(distance: f64) -> f64 {
    let decade = libm::exp10(libm::log10(distance).floor());
    let step = match distance / decade {
        mantissa if mantissa < 1.5 => 1.0,
        mantissa if mantissa < 3.5 => 2.0,
        mantissa if mantissa < 7.5 => 5.0,
        _ => 10.0,
    };
    step * decade
}

/// A multiple of a power of ten, as `0.02` or as `2·10⁻²`.
fn log_label(exponent: i32, multiple: i32, plain: bool) -> String {
    if plain {
        let value = f64::from(multiple) * libm::exp10(f64::from(exponent));
        linear_label(value, value, value)
    } else if multiple == 1 {
        power_of_ten(exponent)
    } else {
        format!("{multiple}·{}", power_of_ten(exponent))
    }
}

/// `10⁻³` and the like.
fn power_of_ten(exponent: i32) -> String {
    format!("10{}", superscript(exponent))
}

/// A tick label on an axis whose ticks are `step` apart and whose largest value is `largest`:
/// plain digits with as many decimals as the step has, or powers of ten where that would be long.
fn linear_label(value: f64, step: f64, largest: f64) -> String {
    // Half a step is zero as well: the sum of steps that led here is not exact.
    if value.abs() < 0.5 * step && value.abs() < 1e-9 * largest {
        return "0".to_owned();
    }
    let text = if (1e-4..1e6).contains(&largest) {
        let decimals = (-(libm::log10(step) + 1e-9).floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        let exponent = libm::log10(largest).floor() as i32;
        let mantissa = value / libm::exp10(f64::from(exponent));
        let decimals = (exponent - (libm::log10(step) + 1e-9).floor() as i32).max(0) as usize;
        format!("{mantissa:.decimals$}·{}", power_of_ten(exponent))
    };
    text.replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    (exponent.to_string().chars())
        .map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            other => char::from_u32(u32::from(other) - u32::from('0') + 0x2070).unwrap_or(other),
        })
        .collect()
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
        // A part of a run, from 0.5 s on.
        assert_eq!(ends(Scale::Linear, 0.5, 2.0), (0.5, 2.0));
        assert_eq!(ends(Scale::Linear, -2.0, -0.5), (-2.0, -0.5));
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

    fn labels(axis: &Axis) -> Vec<String> {
        axis.labels().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn an_axis_of_less_than_a_decade_has_labels() {
        let axis = Axis::around("force / N", Scale::Log, 2.9, 3.1);
        assert_eq!((axis.low, axis.high), (2.0, 5.0));
        assert_eq!(labels(&axis), ["2", "5"]);
        let axis = Axis::around("relative error", Scale::Log, 2.9e-8, 3.1e-8);
        assert_eq!(labels(&axis), ["2·10⁻⁸", "5·10⁻⁸"]);
    }

    #[test]
    fn labels_of_one_axis_are_all_plain_or_all_powers() {
        let time = Axis::tight("time / s", Scale::Log, 1e-3, 200.0);
        assert_eq!(labels(&time), ["0.001", "0.01", "0.1", "1", "10", "100"]);
        let error = Axis::around("relative error", Scale::Log, 3e-9, 2e-5);
        assert_eq!(
            labels(&error),
            ["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴"]
        );
        let wide = Axis::around("relative error", Scale::Log, 3e-15, 2e-5);
        assert_eq!(
            labels(&wide),
            ["10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴"]
        );
    }

    #[test]
    fn labels_of_a_linear_axis_have_equal_decimals_and_all_differ() {
        let axis = Axis::around("force / N", Scale::Linear, 2.8, 3.0);
        assert_eq!(labels(&axis), ["2.80", "2.85", "2.90", "2.95", "3.00"]);
        let axis = Axis::around("force / N", Scale::Linear, 3.000_010, 3.000_013);
        let mut labels = labels(&axis);
        let count = labels.len();
        labels.dedup();
        assert!(count >= 3 && labels.len() == count, "{labels:?}");
    }

    #[test]
    fn ticks_become_fewer_until_their_labels_fit() {
        let fitted = |mut axis: Axis, length: f64| {
            axis.fit(length, |label| 10.0 * label.chars().count() as f64);
            labels(&axis)
        };
        let linear = Axis::around("force / N", Scale::Linear, 0.0, 0.99);
        assert_eq!(fitted(linear.clone(), 400.0).len(), 6);
        assert_eq!(fitted(linear.clone(), 100.0), ["0", "0.5", "1.0"]);
        assert!(fitted(linear, 1.0).len() <= 1);
        let log = Axis::around("force / N", Scale::Log, 1.5e-3, 80.0);
        assert_eq!(
            fitted(log.clone(), 300.0),
            ["0.001", "0.01", "0.1", "1", "10", "100"]
        );
        assert_eq!(fitted(log.clone(), 100.0), ["0.01", "1", "100"]);
        assert!(fitted(log, 1.0).len() <= 1);
    }

    #[test]
    fn numbers_read_as_in_a_journal() {
        assert_eq!(linear_label(0.0, 0.1, 1.0), "0");
        assert_eq!(linear_label(0.1 + 0.2, 0.1, 1.0), "0.3");
        assert_eq!(linear_label(-2.5, 0.5, 3.0), "−2.5");
        assert_eq!(linear_label(80_000.0, 2e4, 86_400.0), "80000");
        assert_eq!(linear_label(2e-7, 1e-7, 3e-7), "2·10⁻⁷");
        assert_eq!(linear_label(-3e9, 5e8, 3e9), "−3.0·10⁹");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }
}
