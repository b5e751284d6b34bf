//! Residuals of a record, with their derivatives.
//! ```text
//! relaxation, creep  rᵢ = ln f(tᵢ) − ln fᵢ
//! oscillation        rᵢ = ln Re M(iω_i) − ln G'_i,  then the same of Im M and G''
//! any motion         rᵢ = (σ(tᵢ) − σᵢ)/σ_rms
//! ```
//! each times √wᵢ, where w is 1, or the square of the geometric mean of the errors (of logarithms their shares) over the own one, or the spacing of the samples in ln t over its mean, or of several motions, whose noise differs,
//! the noise of the mean over that of the own motion, squared.

use super::elements::Candidate;
use super::record::{Motion, Record, RecordKind};
use control_identification::autoregression::Autoregression;
use haptic_tissue::indentation::mapped;
use spring_pots::{
    Binned, Contour, Doubts, Elements, History, Moved, Quantity, Slope, SpectralMode, VARIABLES,
    chosen, oscillation,
};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

fracdiff::enumerated! {
    /// The weights of the samples.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Weighting {
        /// Each sample counts by its error, where the record has errors; else all count the same.
        #[default]
        Errors "errors" "by the errors in a column beside the measured one; without it all count the same",
        /// Each sample counts the same, so that crowded samples count together.
        Equal "equal" "all samples count the same",
        /// Each sample counts as much as it covers of ln t (or ln ω): for samples that crowd at one end.
        LogSpacing "log-spacing" "by spacing in log time or frequency",
    }
}

/// Fewest points of a mapped motion from end to end of its range: the map deviates between them by 1e-6 of the largest value.
const POINTS: usize = 1000;

/// No force transducer is better than this share of its reading (ISO 376, class 00): a smaller residual of a motion, between whose samples
/// the strain is not known, or of what a loop rendered, does not justify another parameter.
pub(super) const EXACT: f64 = 5e-4;
/// Least square of a share of an error that another one does not tell.
const ALIKE: f64 = 1e-12;
/// Accuracy of calculated moduli and compliances, whose noise is as small as it shows itself.
const CALCULATED: f64 = 1e-6;

/// A record made ready for a fit.
#[derive(Clone, Debug)]
pub(super) struct Target<'a> {
    rows: Rows,
    /// Target values: logarithms, of an oscillation all storage and then all loss moduli; or stresses over their scale.
    wanted: Vec<f64>,
    /// The root of the weight of each residual.
    roots: Vec<f64>,
    /// Geometric mean of the errors by which residuals are weighted, in their unit; none if they are not.
    pub(super) error: Option<f64>,
    /// Unit of time, s: 1/t₀ is in the middle of the record.
    pub(super) unit_s: f64,
    /// Unit of the residuals: 1, or the root of the mean square of the stress, Pa.
    pub(super) scale: f64,
    /// ln of a modulus in the middle of the record, and of the span of moduli.
    pub(super) middle: f64,
    pub(super) span: f64,
    /// Numbers that are fitted beside those of the model.
    pub(super) nuisance: usize,
    /// ln of the middle of the record over the unit of time: 0 but in seconds.
    pub(super) shift: f64,
    /// A sum of squares that counts as 0.
    pub(super) exact: f64,
    /// Root of the mean square of a residual below which less of it decides nothing.
    pub(super) floor: f64,
    /// Lengths of the series of residuals; each is independent of the next.
    lengths: Vec<usize>,
    /// Parts of the residuals that are taken out of them, and what of these is expected and is no part of the target values; none if nothing is.
    doubts: Doubts,
    expected: Vec<f64>,
    /// Correlation of the errors of storage and loss modulus of each sample; none if they are independent.
    shared: Vec<f64>,
    /// The noise through whose filter the residuals go.
    noise: Autoregression,
    /// Nobody waits for the fit any more.
    stop: &'a AtomicBool,
}

#[derive(Clone, Debug)]
enum Rows {
    /// ln of times and a quantity, or ln of frequencies and none: storage and loss modulus.
    Sampled(Option<Quantity>, Vec<f64>),
    History(History),
    Binned(Binned),
    Stepped(Stepped),
}

/// A creep under several steps of stress, or with differences as its residuals.
#[derive(Clone, Debug)]
struct Stepped {
    /// ln of the time since each step before a sample, and the size of the step, for each sample.
    since: Vec<Vec<[f64; 2]>>,
    chosen: Vec<usize>,
    is_logarithmic: bool,
}

impl Stepped {
    fn new(record: &Record, middle: f64) -> Self {
        let all = 0..record.x.len();
        let chosen = if all.len() > SAMPLES_OF_STEPS {
            chosen(&record.x, 0.0, SAMPLES_OF_STEPS)
        } else {
            all.collect()
        };
        let since = chosen.iter().map(|&n| {
            let before = record.steps.iter().filter(|step| step[0] < record.x[n]);
            before
                .map(|step| [libm::log(record.x[n] - step[0]) - middle, step[1]])
                .collect()
        });
        Self {
            since: since.collect(),
            is_logarithmic: !record.is_absolute(),
            chosen,
        }
    }
}

/// Samples of a record that is compared with filtered residuals, at most.
const AVERAGED: usize = 4000;
/// Samples of a creep by steps that are compared, at most.
const SAMPLES_OF_STEPS: usize = 2000;

impl<'a> Target<'a> {
    pub(super) fn new(record: &Record, weighting: Weighting, stop: &'a AtomicBool) -> Self {
        if record.kind == RecordKind::History {
            return Self::of_history(record, weighting, stop);
        }
        let ln_x: Vec<f64> = record.x.iter().map(|&x| libm::log(x)).collect();
        let middle = 0.5 * (ln_x[0] + ln_x[ln_x.len() - 1]);
        let relative: Vec<f64> = ln_x.iter().map(|x| x - middle).collect();
        let parts = 1 + usize::from(!record.second.is_empty());
        let roots = roots(&relative, weighting, parts);
        let errors = Some(&record.errors).filter(|_| weighting == Weighting::Errors);
        let stepped = (record.has_steps()).then(|| Stepped::new(record, middle));
        let values = [&record.first[..], &record.second].concat();
        let chosen = stepped.as_ref().map(|stepped| stepped.chosen.clone());
        let chosen = chosen.unwrap_or_else(|| (0..values.len()).collect());
        let (values, roots) = (
            chosen.iter().map(|&n| values[n]),
            chosen.iter().map(|&n| roots[n]),
        );
        let (values, roots): (Vec<f64>, Vec<f64>) = (values.collect(), roots.collect());
        let count = values.len() as f64;
        let size = libm::sqrt(values.iter().map(|x| x * x).sum::<f64>() / count);
        let is_absolute = record.is_absolute();
        let scale = if is_absolute { size } else { 1.0 };
        let errors = errors.filter(|errors| !errors.is_empty()).map(|errors| {
            let pairs = chosen.iter().zip(&values);
            by_errors(pairs.map(|(&n, value)| errors[n] / if is_absolute { scale } else { *value }))
        });
        let (error, roots) = errors.map_or((None, roots), |(error, roots)| (Some(error), roots));
        let wanted = values.iter().map(|x| {
            if is_absolute {
                x / scale
            } else {
                libm::log(*x)
            }
        });
        let mut wanted: Vec<f64> = wanted.collect();
        let expected = chosen
            .iter()
            .filter_map(|&n| record.expected.get(n).copied());
        let expected: Vec<f64> = expected.collect();
        let (low, high) = if is_absolute {
            (libm::log(size) - 1.0, libm::log(size) + 1.0)
        } else {
            ends(&wanted)
        };
        let (unit, sign, quantity) = match record.kind {
            RecordKind::Oscillation => (-middle, 1.0, None),
            RecordKind::Creep => (middle, -1.0, Some(Quantity::Creep)),
            RecordKind::Relaxation | RecordKind::History => {
                (middle, 1.0, Some(Quantity::Relaxation))
            }
        };
        let of_chosen = |column: &Vec<f64>| {
            let rows = chosen.iter().zip(&roots);
            rows.map(|(&n, root)| root * column[n]).collect()
        };
        let pairs = wanted.iter_mut().zip(&expected);
        pairs.for_each(|(wanted, expected)| *wanted -= expected);
        let open: Vec<Vec<f64>> = record.bounded.iter().map(of_chosen).collect();
        let shared = if error.is_some() {
            &record.shared[..]
        } else {
            &[]
        };
        Self {
            doubts: Doubts::new(roots.len(), &[], &open),
            expected,
            shared: shared.to_vec(),
            rows: match stepped {
                Some(stepped) => Rows::Stepped(stepped),
                None => Rows::Sampled(quantity, relative),
            },
            wanted,
            roots,
            error,
            unit_s: libm::exp(unit),
            scale,
            middle: 0.5 * (low + high) * sign,
            span: high - low,
            nuisance: 0,
            shift: 0.0,
            exact: EXACT * EXACT * count,
            floor: if record.is_own_log { EXACT } else { CALCULATED },
            lengths: vec![count as usize / parts; parts],
            noise: Autoregression::default(),
            stop,
        }
    }

    fn of_history(record: &Record, weighting: Weighting, stop: &'a AtomicBool) -> Self {
        let mut begin = 0;
        let samples = record.motions.iter().map(|motion| {
            begin += motion.samples;
            begin - motion.samples..begin
        });
        let samples: Vec<Range<usize>> = samples.collect();
        let parts = || record.motions.iter().zip(&samples);
        let mapped: Vec<Option<(Vec<f64>, Vec<f64>)>> = parts()
            .map(|(motion, range)| {
                let plain = (&record.x[range.clone()], &record.first[range.clone()]);
                let way = motion.way.as_ref();
                let (time_s, strain) = way.map_or(plain, |(time, way)| (&time[..], &way[..]));
                let map = motion.map.as_ref();
                let mapped = map.map(|map| mapped(time_s, strain, map, POINTS));
                mapped.or_else(|| motion.way.clone())
            })
            .collect();
        let motions: Vec<Moved<'_>> = (samples.iter().zip(&mapped))
            .map(|(range, mapped)| {
                let time_s = &record.x[range.clone()];
                let plain = (time_s, &record.first[range.clone()]);
                let (motion_s, strain) = (mapped.as_ref()).map_or(plain, |(t, e)| (t, e));
                Moved {
                    time_s,
                    stress_pa: &record.second[range.clone()],
                    motion_s,
                    strain,
                }
            })
            .collect();
        let has_errors = weighting == Weighting::Errors && !record.errors.is_empty();
        let errors: &[f64] = if has_errors { &record.errors } else { &[] };
        let history = History::new(&motions, &record.nuisance, &record.bounded, errors);
        let (scale, count) = (history.stress_scale, history.chosen.len() as f64);
        let compared = |range: &Range<usize>| {
            let before = |end: usize| history.chosen.partition_point(|&n| n < end);
            before(range.end) - before(range.start)
        };
        let weighed = has_errors.then(|| {
            let chosen = history.chosen.iter();
            by_errors(chosen.map(|&n| errors[n] / scale))
        });
        let of_motions = || (None, roots_of_motions(record, &history.chosen, scale));
        let (error, roots) = weighed.map_or_else(of_motions, |(error, roots)| (Some(error), roots));
        Self {
            wanted: history.wanted.clone(),
            roots,
            error,
            unit_s: history.unit_s,
            scale,
            middle: libm::log(scale / history.strain_scale),
            span: 2.0,
            nuisance: record.nuisance.len(),
            shift: 0.0,
            exact: EXACT * EXACT * count,
            floor: EXACT,
            lengths: samples.iter().map(compared).collect(),
            doubts: Doubts::default(),
            expected: Vec::new(),
            shared: Vec::new(),
            noise: Autoregression::default(),
            stop,
            rows: Rows::History(history),
        }
    }

    /// Target with 1 s as the unit of time, in which the variable of a modulus is ln V.
    pub(super) fn in_seconds(mut self) -> Self {
        let shift = libm::log(self.unit_s);
        match &mut self.rows {
            Rows::Sampled(quantity, ln_x) => {
                let shift = if quantity.is_some() { shift } else { -shift };
                ln_x.iter_mut().for_each(|x| *x += shift);
            }
            Rows::History(history) => history.in_seconds(),
            Rows::Stepped(stepped) => {
                let all = stepped.since.iter_mut().flatten();
                all.for_each(|since| since[0] += shift);
            }
            Rows::Binned(_) => return self,
        }
        (self.unit_s, self.shift) = (1.0, shift);
        self
    }

    /// True once the fit is to end.
    pub(super) fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(super) fn len(&self) -> usize {
        self.roots.len()
    }

    /// Number of samples that are compared.
    pub(super) fn samples(&self) -> usize {
        match &self.rows {
            Rows::Sampled(_, ln_x) => ln_x.len(),
            Rows::History(_) | Rows::Binned(_) | Rows::Stepped(_) => self.len(),
        }
    }

    /// An equal sum of squares by as many rows as it needs: for a long history far fewer than samples. Its residuals do not correspond
    /// to samples.
    pub(super) fn compressed(&self) -> Self {
        let (wanted, roots) = (&self.wanted, &self.roots);
        let compressed = match &self.rows {
            Rows::Sampled(..) if !self.shared.is_empty() => None,
            Rows::Sampled(quantity, ln_x) => Binned::new(*quantity, ln_x, wanted, roots)
                .map(|(binned, wanted)| (Rows::Binned(binned), wanted)),
            Rows::History(history) => (history.compressed(wanted, roots))
                .map(|(history, wanted)| (Rows::History(history), wanted)),
            Rows::Binned(_) | Rows::Stepped(_) => None,
        };
        match compressed {
            None => self.clone(),
            Some((rows, wanted)) => Self {
                rows,
                roots: vec![1.0; wanted.len()],
                wanted,
                lengths: Vec::new(),
                doubts: Doubts::default(),
                expected: Vec::new(),
                shared: Vec::new(),
                noise: Autoregression::default(),
                ..*self
            },
        }
    }

    /// Fewer values for a first pass: at most about `most` samples, evenly chosen; for a motion fewer nodes.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let (wanted, roots) = (&self.wanted, &self.roots);
        let (rows, wanted, roots) = match &self.rows {
            Rows::Binned(_) => return self.clone(),
            Rows::History(history) => {
                let (coarse, wanted) = history.coarse(wanted, roots);
                let roots = vec![1.0; wanted.len()];
                (Rows::History(coarse), wanted, roots)
            }
            Rows::Sampled(..) | Rows::Stepped(_) => {
                let samples = self.samples();
                let step = samples.div_ceil(most).max(1);
                let last = (!(samples - 1).is_multiple_of(step)).then_some(samples - 1);
                let chosen: Vec<usize> = (0..samples).step_by(step).chain(last).collect();
                let chosen_of = |values: &[f64]| -> Vec<f64> {
                    let part = |n: usize| chosen.iter().map(move |&i| values[n * samples + i]);
                    (0..values.len() / samples).flat_map(part).collect()
                };
                let rows = match &self.rows {
                    Rows::Sampled(quantity, ln_x) => Rows::Sampled(*quantity, chosen_of(ln_x)),
                    Rows::Stepped(stepped) => Rows::Stepped(Stepped {
                        since: chosen.iter().map(|&i| stepped.since[i].clone()).collect(),
                        chosen: chosen.iter().map(|&i| stepped.chosen[i]).collect(),
                        ..*stepped
                    }),
                    other @ (Rows::History(_) | Rows::Binned(_)) => other.clone(),
                };
                (rows, chosen_of(wanted), chosen_of(roots))
            }
        };
        Self {
            rows,
            wanted,
            roots,
            lengths: Vec::new(),
            doubts: Doubts::default(),
            expected: Vec::new(),
            shared: Vec::new(),
            noise: Autoregression::default(),
            ..*self
        }
    }

    /// Residuals of each series, cut from those of all.
    pub(super) fn series<'b>(&self, all: &'b [f64]) -> Vec<&'b [f64]> {
        let mut rest = all;
        let part = |length: &usize| {
            let part;
            (part, rest) = rest.split_at(*length);
            part
        };
        self.lengths.iter().map(part).collect()
    }

    /// Filters the residuals by a model of the noise.
    pub(super) fn filtered(&self, noise: Autoregression) -> Self {
        Self {
            noise,
            ..self.clone()
        }
    }

    /// Averages neighbours of a long sampled record, so that about [`AVERAGED`] values remain.
    pub(super) fn averaged(&self) -> Self {
        let (samples, mut averaged) = (self.samples(), self.clone());
        let Rows::Sampled(quantity, ln_x) = &self.rows else {
            return averaged;
        };
        if samples <= AVERAGED {
            return averaged;
        }
        let block = samples.div_ceil(AVERAGED);
        let means = |values: &[f64]| -> Vec<f64> {
            let parts = values.chunks(samples).flat_map(|part| part.chunks(block));
            parts
                .map(|part| part.iter().sum::<f64>() / part.len() as f64)
                .collect()
        };
        averaged.rows = Rows::Sampled(*quantity, means(ln_x));
        (averaged.wanted, averaged.roots) = (means(&self.wanted), means(&self.roots));
        averaged.shared = means(&self.shared);
        averaged.lengths = self.lengths.iter().map(|n| n.div_ceil(block)).collect();
        averaged.exact = EXACT * EXACT * averaged.roots.len() as f64;
        averaged
    }

    /// Calls `each` with number, weight root, residual and its derivatives; false if a number is not finite, or the fit is to end.
    pub(super) fn residuals(
        &self,
        candidate: Candidate,
        elements: &Elements,
        mut each: impl FnMut(usize, f64, Slope),
    ) -> bool {
        if self.stops() {
            return false;
        }
        if self.is_plain() {
            return self.plain_residuals(candidate, elements, each);
        }
        let mut columns = vec![vec![0.0; self.len()]; VARIABLES + 1];
        let finite = self.plain_residuals(candidate, elements, |n, root, slope| {
            columns[VARIABLES][n] = root * slope.value;
            for (column, by) in columns.iter_mut().zip(slope.by) {
                column[n] = root * by;
            }
        });
        for column in columns.iter_mut().take(candidate.variables()) {
            *column = self.through_filter(column);
        }
        columns[VARIABLES] = self.through_filter(&columns[VARIABLES]);
        for (n, (value, root)) in columns[VARIABLES].iter().zip(&self.roots).enumerate() {
            // A filter mixes rows, of which none has a weight of its own.
            let root = if self.noise.order() == 0 { *root } else { 1.0 };
            let slope = Slope {
                value: value / root,
                by: std::array::from_fn(|variable| columns[variable][n] / root),
            };
            each(n, root, slope);
        }
        finite
    }

    const fn is_plain(&self) -> bool {
        self.noise.order() == 0 && self.doubts.is_empty() && self.shared.is_empty()
    }

    fn through_filter(&self, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        // Of two errors that share a part, the second less what the first tells of it.
        let (first, second) = column.split_at_mut(self.shared.len());
        for ((first, second), shared) in first.iter().zip(second).zip(&self.shared) {
            *second = (*second - shared * first) / own(*shared);
        }
        self.doubts.take_out(&mut column, &[]);
        if self.noise.order() == 0 {
            return column;
        }
        let series = self.series(&column).into_iter();
        series.flat_map(|part| self.noise.whitened(part)).collect()
    }

    /// Residuals with their own errors of draws of errors that share nothing.
    pub(super) fn sharing(&self, mut drawn: Vec<f64>) -> Vec<f64> {
        let (first, second) = drawn.split_at_mut(self.shared.len());
        for ((first, second), shared) in first.iter().zip(second).zip(&self.shared) {
            *second = own(*shared) * *second + shared * first;
        }
        drawn
    }

    /// Residuals of values that share an error, each by itself, as what the model misses there is shown; nothing of others.
    pub(super) fn apart(
        &self,
        candidate: Candidate,
        elements: &Elements,
        mut each: impl FnMut(usize, f64),
    ) {
        if !self.shared.is_empty() {
            self.plain_residuals(candidate, elements, |n, _, slope| each(n, slope.value));
        }
    }

    fn plain_residuals(
        &self,
        candidate: Candidate,
        elements: &Elements,
        mut each: impl FnMut(usize, f64, Slope),
    ) -> bool {
        let mut finite = true;
        self.model(candidate, elements, |n, model| {
            let wanted = self.wanted(n);
            let mut slope = model;
            match &self.rows {
                Rows::Stepped(stepped) if stepped.is_logarithmic => {
                    slope = model.logarithm(wanted);
                }
                Rows::History(_) | Rows::Binned(_) | Rows::Stepped(_) => slope.value -= wanted,
                Rows::Sampled(..) => slope = model.logarithm(wanted),
            }
            finite &= slope.value.is_finite();
            each(n, self.roots[n], slope);
        });
        finite
    }

    /// Size of the noise of a residual, over that of another: 1 unless its error is known.
    pub(super) fn noise_size(&self, n: usize) -> f64 {
        self.error.map_or(1.0, |_| 1.0 / self.roots[n])
    }

    /// Target value: a logarithm, or a stress over its scale.
    pub(super) fn wanted(&self, n: usize) -> f64 {
        self.wanted[n]
    }

    /// Σ ln y² over the values whose logarithms are compared: criteria of differences and of logarithms, each with its own, compare.
    pub(super) fn ln_sizes(&self) -> f64 {
        match &self.rows {
            Rows::Stepped(stepped) if stepped.is_logarithmic => {
                2.0 * self.wanted.iter().sum::<f64>()
            }
            Rows::Sampled(..) | Rows::Stepped(_) | Rows::History(_) | Rows::Binned(_) => 0.0,
        }
    }

    /// The model at a sample of which this is the residual, in the unit of the record.
    pub(super) fn modelled(&self, n: usize, residual: f64) -> f64 {
        let expected = self.expected.get(n).copied().unwrap_or_default();
        let value = residual + self.wanted[n] + expected;
        match &self.rows {
            Rows::Stepped(stepped) if stepped.is_logarithmic => libm::exp(value),
            Rows::History(_) | Rows::Stepped(_) => value * self.scale,
            Rows::Sampled(..) | Rows::Binned(_) => libm::exp(value),
        }
    }

    /// Numbers of the samples that are compared.
    pub(super) fn chosen(&self) -> Vec<usize> {
        match &self.rows {
            Rows::History(history) => history.chosen.clone(),
            Rows::Stepped(stepped) => stepped.chosen.clone(),
            Rows::Sampled(..) | Rows::Binned(_) => (0..self.samples()).collect(),
        }
    }

    /// Times or frequencies, and values as they were measured, of what is compared.
    pub(super) fn values(&self, record: &Record) -> (Vec<f64>, Vec<f64>) {
        match &self.rows {
            Rows::History(history) => {
                let chosen_of =
                    |values: &[f64]| history.chosen.iter().map(|&i| values[i]).collect();
                (chosen_of(&record.x), chosen_of(&record.second))
            }
            Rows::Stepped(stepped) => {
                let chosen_of =
                    |values: &[f64]| stepped.chosen.iter().map(|&i| values[i]).collect();
                (chosen_of(&record.x), chosen_of(&record.first))
            }
            Rows::Sampled(..) | Rows::Binned(_) => {
                let values = [&record.first[..], &record.second].concat();
                (record.x.repeat(values.len() / record.x.len()), values)
            }
        }
    }

    /// Splits `all`, one number for each compared value, into those of each motion.
    pub(super) fn of_motions<'b>(&self, record: &Record, all: &'b [f64]) -> Vec<&'b [f64]> {
        let Rows::History(history) = &self.rows else {
            return vec![all];
        };
        let (mut rest, mut begin) = (all, 0);
        let part = |motion: &Motion| {
            begin += motion.samples;
            let end = history.chosen.partition_point(|&i| i < begin);
            let count = end - (all.len() - rest.len());
            let residuals;
            (residuals, rest) = rest.split_at(count);
            residuals
        };
        record.motions.iter().map(part).collect()
    }

    /// Replaces the target values: logarithms, or stresses over their scale.
    pub(super) fn with_values(&self, values: Vec<f64>) -> Self {
        Self {
            wanted: values,
            ..self.clone()
        }
    }

    /// Calls `each` with number and value of the model, no logarithm taken; stresses over their scale.
    pub(super) fn model(
        &self,
        candidate: Candidate,
        elements: &Elements,
        mut each: impl FnMut(usize, Slope),
    ) {
        if let Rows::History(history) = &self.rows {
            return history.model(candidate.joint(), elements, &mut each);
        }
        let quantity = self.quantity();
        let contour = quantity.map(|quantity| Contour::new(candidate.joint(), quantity, *elements));
        let at = |ln_x: f64| match &contour {
            Some(contour) => [contour.at(ln_x), Slope::default()],
            None => oscillation(candidate.joint(), elements, ln_x),
        };
        self.sampled(&at, &mut each);
    }

    /// The function of time, which is that of the samples; `None` of storage and loss modulus.
    pub(super) const fn quantity(&self) -> Option<Quantity> {
        match &self.rows {
            Rows::History(_) => Some(Quantity::Integral),
            Rows::Sampled(quantity, _) => *quantity,
            Rows::Binned(binned) => binned.quantity,
            Rows::Stepped(_) => Some(Quantity::Creep),
        }
    }

    /// A mode of a positive spectrum, of unit size, at each sample: no logarithm taken; stresses over their scale.
    pub(super) fn mode(&self, mode: SpectralMode) -> Vec<f64> {
        if let Rows::History(history) = &self.rows {
            return history.mode(mode);
        }
        let quantity = self.quantity();
        let at = |ln_x: f64| {
            let slope = |value: f64| Slope {
                value,
                ..Slope::default()
            };
            mode.at(quantity, ln_x).map(slope)
        };
        let mut values = vec![0.0; self.len()];
        self.sampled(&at, &mut |n, slope| values[n] = slope.value);
        values
    }

    /// Least and largest ln of a time, or of 1/ω, in units of time.
    pub(super) fn ln_times(&self) -> [f64; 2] {
        let of_all = |all: &mut dyn Iterator<Item = f64>| {
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            })
        };
        match &self.rows {
            Rows::History(history) => history.ends(),
            Rows::Sampled(Some(_), ln_x) => of_all(&mut ln_x.iter().copied()),
            Rows::Sampled(None, ln_x) => of_all(&mut ln_x.iter().map(|x| -x)),
            Rows::Stepped(stepped) => {
                of_all(&mut stepped.since.iter().flatten().map(|since| since[0]))
            }
            Rows::Binned(_) => [0.0; 2],
        }
    }

    /// True if logarithms are compared.
    pub(super) const fn is_logarithmic(&self) -> bool {
        match &self.rows {
            Rows::Sampled(..) | Rows::Binned(_) => true,
            Rows::Stepped(stepped) => stepped.is_logarithmic,
            Rows::History(_) => false,
        }
    }

    /// A column, one number a residual, with the weights and through the filter.
    pub(super) fn through(&self, column: &[f64]) -> Vec<f64> {
        let weighted = column.iter().zip(&self.roots).map(|(x, root)| x * root);
        let weighted: Vec<f64> = weighted.collect();
        if self.is_plain() {
            weighted
        } else {
            self.through_filter(&weighted)
        }
    }

    /// A column without what the doubts make of it, one number a residual.
    pub(super) fn undoubted(&self, column: &[f64]) -> Vec<f64> {
        if !self.shared.is_empty() {
            return column.to_vec();
        }
        let weighted = self.through(column).into_iter().zip(&self.roots);
        weighted.map(|(value, root)| value / root).collect()
    }

    fn sampled(&self, at: &dyn Fn(f64) -> [Slope; 2], each: &mut dyn FnMut(usize, Slope)) {
        match &self.rows {
            Rows::History(_) => {}
            Rows::Stepped(stepped) => {
                for (n, since) in stepped.since.iter().enumerate() {
                    let (answers, sizes): (Vec<Slope>, Vec<f64>) =
                        since.iter().map(|step| (at(step[0])[0], step[1])).unzip();
                    let mut sum = Slope::sum(&sizes, &answers);
                    if !stepped.is_logarithmic {
                        sum.value /= self.scale;
                        sum.by.iter_mut().for_each(|by| *by /= self.scale);
                    }
                    each(n, sum);
                }
            }
            Rows::Sampled(_, ln_x) => {
                for (n, &ln_x) in ln_x.iter().enumerate() {
                    let parts = at(ln_x).into_iter().take(self.len() / self.samples());
                    let numbers = (n..).step_by(self.samples());
                    numbers.zip(parts).for_each(|(n, part)| each(n, part));
                }
            }
            Rows::Binned(binned) => {
                binned.model(&mut |ln_x| at(ln_x).map(|part| part.logarithm(0.0)), each);
            }
        }
    }
}

/// Share of a second error that the first does not tell.
fn own(shared: f64) -> f64 {
    libm::sqrt(((1.0 - shared) * (1.0 + shared)).max(ALIKE))
}

fn ends(values: &[f64]) -> (f64, f64) {
    let [low, high] = [f64::min, f64::max].map(|end| values.iter().copied().reduce(end));
    low.zip(high).unwrap_or_default()
}

/// √w of each sample, repeated for each part of the residuals.
fn roots(ln_x: &[f64], weighting: Weighting, parts: usize) -> Vec<f64> {
    let n = ln_x.len();
    let one: Vec<f64> = match weighting {
        Weighting::Errors | Weighting::Equal => vec![1.0; n],
        Weighting::LogSpacing => {
            let covered = |i: usize| 0.5 * (ln_x[(i + 1).min(n - 1)] - ln_x[i.saturating_sub(1)]);
            let mean = (0..n).map(covered).sum::<f64>() / n as f64;
            (0..n).map(|i| libm::sqrt(covered(i) / mean)).collect()
        }
    };
    one.repeat(parts)
}

/// Geometric mean of these errors, and √w of each: that mean over it, so that the weights leave the product of the errors as it is and criteria of
/// two readings compare.
fn by_errors(errors: impl Iterator<Item = f64> + Clone) -> (f64, Vec<f64>) {
    let count = errors.clone().count() as f64;
    let mean = libm::exp(errors.clone().map(libm::log).sum::<f64>() / count);
    (mean, errors.map(|error| mean / error).collect())
}

/// √w of each sample: 1, or of several motions by the noise of each. The sum of squares is about that of errors relative to the own
/// stress of each, so that BIC says the same of records in other units.
fn roots_of_motions(record: &Record, chosen: &[usize], scale: f64) -> Vec<f64> {
    if record.motions.len() < 2 {
        return vec![1.0; chosen.len()];
    }
    let (mut noise, mut ln_share, mut begin, mut first) = (Vec::new(), 0.0, 0, 0);
    for motion in &record.motions {
        begin += motion.samples;
        let end = chosen.partition_point(|&i| i < begin);
        let stresses = chosen[first..end].iter().map(|&i| record.second[i]);
        let square = stresses.map(|stress| stress * stress).sum::<f64>();
        let count = (end - first) as f64;
        let size = motion.noise.unwrap_or(1.0);
        let stress = libm::sqrt(square / count).max(f64::MIN_POSITIVE);
        ln_share += count * libm::log(size / stress);
        noise.extend(std::iter::repeat_n(size, end - first));
        first = end;
    }
    let share = libm::exp(ln_share / chosen.len() as f64);
    noise.iter().map(|size| share * scale / size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes of an oscillation and of any motion; the contour's own are tested with it.
    #[test]
    fn derivatives_of_residuals_are_those_of_the_values() {
        const STEP: f64 = 1e-6;
        let times: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let strain: Vec<f64> = times.iter().map(|t| 0.05 * libm::sin(*t)).collect();
        let stress: Vec<f64> = strain.iter().map(|e| 2e4 * e).collect();
        let history = Record::history(times, strain, stress).expect("valid");
        let sweep = Record::oscillation(
            vec![0.1, 1.0, 10.0],
            vec![1e3, 2e3, 3e3],
            vec![5e2, 1e3, 2e3],
        );
        for record in [history, sweep.expect("valid")] {
            let never = AtomicBool::new(false);
            let target = Target::new(&record, Weighting::LogSpacing, &never);
            for candidate in Candidate::fractional() {
                let values = [9.0, 0.7, 8.5, 0.2, 8.0];
                let at = |values: &[f64]| {
                    let mut slopes = vec![Slope::default(); target.len()];
                    let elements = Elements::from_variables(values);
                    assert!(
                        target.residuals(candidate, &elements, |n, _, slope| slopes[n] = slope)
                    );
                    slopes
                };
                for v in 0..candidate.parameters() {
                    let neighbours = [-STEP, STEP].map(|step| {
                        let mut values = values;
                        values[v] += step;
                        at(&values)
                    });
                    for (n, slope) in at(&values).iter().enumerate() {
                        let want = (neighbours[1][n].value - neighbours[0][n].value) / (2.0 * STEP);
                        let error = (slope.by[v] - want).abs();
                        assert!(
                            error < 1e-7,
                            "{candidate:?} {v} {n}: {} {want}",
                            slope.by[v]
                        );
                    }
                }
            }
        }
    }
}
