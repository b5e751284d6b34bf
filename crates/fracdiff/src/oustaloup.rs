//! Band-limited operator after Oustaloup, as a cascade of first-order sections.

use crate::differintegrator::past_is_kept;
use crate::integer_part::{IntegerHistory, WithIntegerPart, operator_from_its_core};
use crate::list::{ListError, check_decay};
use crate::order::check_length;
use crate::real::approach;
use crate::response::low_pass;
use crate::{Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds};
use core::f64::consts::PI;
use num_complex::Complex;

/// D^μ between two corner frequencies, from m ≤ N first-order sections, μ = n + φ with the integer part n towards zero.
/// ```text
/// s^φ ≈ ω_h^φ · Π_{i=1}^{m} (s + ω'_i)/(s + ω_i),   r = ω_h/ω_l,
/// ω'_i = ω_l·r^((2i − 1 − φ)/(2m)),   ω_i = ω_l·r^((2i − 1 + φ)/(2m))
/// ```
/// Each section is discretised by the Tustin rule s = (2/T)(1 − w)/(1 + w); the integer part is (1 − w)^n T^(−n).
///
/// - *Units*: as [`ShortMemory`](crate::ShortMemory); corners in Hz, ω = 2πf.
/// - *Accuracy*: with two sections a decade about 3.5 %·|φ| at a decade and a half inside either corner, and 10 %·|φ| at one decade, the
///   edge of the band, whatever the number of sections. Outside the band the gain is flat: no memory beyond about 1/`ω_l`. The Tustin rule
///   bends the top decade below half the sample rate.
/// - *Why sections*: poles lie close together on a logarithmic scale; one polynomial of degree m
///   would lose them to rounding, a cascade does not.
/// - *Start-up*: zero for ever before. *Not finite*: no output is finite until reset.
/// - *Cost*: `output` one multiply-add, `advance` about 5m. Memory m samples.
///
/// Source: A. Oustaloup, F. Levron, B. Mathieu, F. Nanot, *Frequency-band complex noninteger
/// differentiator*, IEEE Trans. Circuits Syst. I 47(1), 2000.
#[derive(Clone, Debug, PartialEq)]
pub struct Oustaloup<F, const N: usize>(WithIntegerPart<Cascade<F, N>>);

/// A frequency band in Hz, lower corner first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Band {
    /// Lower corner, Hz, above 0.
    pub low_hz: f64,
    /// Upper corner, Hz, above the lower, below half the sample rate.
    pub high_hz: f64,
}

/// History of [`Oustaloup`].
pub type OustaloupHistory<F, const N: usize> = IntegerHistory<F, CascadeHistory<F, N>>;

impl<F: Real, const N: usize> Oustaloup<F, N> {
    /// All N sections.
    ///
    /// # Errors
    /// As [`with_sections`](Self::with_sections).
    pub fn new(order: Order, band: Band, sample_time: Seconds) -> Result<Self, ParameterError> {
        Self::with_sections(order, N, band, sample_time)
    }

    /// m ≤ N sections, chosen at run time. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless 1 ≤ m ≤ N; [`ParameterError::SampleTime`];
    /// [`ParameterError::Band`] unless 0 < low < high < half the sample rate.
    pub fn with_sections(
        order: Order,
        sections: usize,
        band: Band,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        check_length("number of sections", sections, N)?;
        let rate = sample_time.rate_to_the(order)?;
        let Band { low_hz, high_hz } = band;
        let nyquist_hz = 0.5 / sample_time.0;
        if !(low_hz > 0.0 && low_hz < high_hz && high_hz < nyquist_hz) {
            return Err(ParameterError::Band {
                low_hz,
                high_hz,
                nyquist_hz,
            });
        }
        let (integer, fraction) = order.split();
        // Corner frequencies in rad/sample: the whole design is dimensionless.
        let low = 2.0 * PI * low_hz * sample_time.0;
        let high = 2.0 * PI * high_hz * sample_time.0;
        let corner = |i: usize, sign: f64| {
            let exponent = (2.0 * i as f64 + 1.0 + sign * fraction) / (2.0 * sections as f64);
            low * libm::pow(high / low, exponent)
        };
        let gain = rate * libm::pow(high, fraction);
        let mut direct = gain;
        let mut all = [Section::default(); N];
        for (i, section) in all.iter_mut().enumerate().take(sections) {
            let (zero, pole) = (0.5 * corner(i, -1.0), 0.5 * corner(i, 1.0));
            // (s + ω')/(s + ω) under s/2 = (1 − w)/(1 + w), z and p half of ω' and ω:
            // (1+z)/(1+p) + (z − p)/(p(1+p)) · d·w/(1 − (1 − d)w),   d = 2p/(1 + p)
            *section = Section {
                direct: F::from_f64((1.0 + zero) / (1.0 + pole)),
                decay: F::from_f64(2.0 * pole / (1.0 + pole)),
                slow: F::from_f64((zero - pole) / (pole * (1.0 + pole))),
            };
            direct *= (1.0 + zero) / (1.0 + pole);
        }
        let cascade = Cascade {
            rate,
            used: sections,
            gain: F::from_f64(gain),
            direct: F::from_f64(direct),
            sections: all,
        };
        Ok(Self(WithIntegerPart {
            integer,
            core: cascade,
        }))
    }
}

operator_from_its_core!(Oustaloup<N>, OustaloupHistory);

/// y = direct·x + slow·v,   v ← v + decay·(x − v): a section whose slow state keeps its increments in single precision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Section<F> {
    direct: F,
    decay: F,
    slow: F,
}

/// Sections in series, then a gain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cascade<F, const N: usize> {
    rate: f64,
    used: usize,
    gain: F,
    /// From input to output within a tick: the gain times all direct parts.
    direct: F,
    sections: [Section<F>; N],
}

impl<F: Real, const N: usize> Cascade<F, N> {
    /// From gain and g, then direct, decay and slow of each section, all finite. The response is not to be
    /// asked for: the rate is not in the list.
    pub(crate) fn from_list(values: &[F]) -> Result<Self, ListError> {
        let (count, most) = (values.len(), 2 + 3 * N);
        let wrong = ListError::Count { count, most };
        let (&[gain, direct], rest) = values.split_first_chunk().ok_or(wrong)?;
        let (triples, rest) = rest.as_chunks::<3>();
        if !rest.is_empty() || !(1..=N).contains(&triples.len()) {
            return Err(wrong);
        }
        let mut sections = [Section::default(); N];
        for (i, &[direct, decay, slow]) in triples.iter().enumerate() {
            let decay = check_decay(decay, 3 + 3 * i)?;
            sections[i] = Section {
                direct,
                decay,
                slow,
            };
        }
        Ok(Self {
            rate: 1.0,
            used: triples.len(),
            gain,
            direct,
            sections,
        })
    }

    /// Value `index` of the list that [`from_list`](Self::from_list) takes.
    pub(crate) fn value(&self, index: usize) -> Option<F> {
        if index < 2 {
            return Some([self.gain, self.direct][index]);
        }
        let section = self.sections[..self.used.min(N)].get((index - 2) / 3)?;
        Some([section.direct, section.decay, section.slow][(index - 2) % 3])
    }
}

#[cfg(feature = "std")]
impl<F: Real, const N: usize> Oustaloup<F, N> {
    /// Integer part, and the values of [`Form::Sections`](crate::portable::Form::Sections).
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        self.0.list(Cascade::value)
    }
}

/// One slow state a section, with its compensation word, and S\[n\].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct CascadeHistory<F, const N: usize> {
    #[cfg_attr(feature = "serde", serde(with = "crate::saved"))]
    slow: [(F, F); N],
    past: F,
}

impl<F: Real, const N: usize> Differintegrator<F> for Cascade<F, N> {
    type History = CascadeHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        CascadeHistory {
            slow: [(F::ZERO, F::ZERO); N],
            past: F::ZERO,
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        // v = x in each section, whose output goes into the next.
        let mut signal = x;
        for (section, (slow, _)) in self.sections.iter().zip(&mut history.slow).take(self.used) {
            *slow = signal;
            signal = (section.direct + section.slow) * signal;
        }
        self.advance(&mut history, x);
        Some(history)
    }

    past_is_kept!(direct);

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let mut signal = x;
        // Output of the cascade at the next tick for an input of zero.
        let mut rest = F::ZERO;
        let states = history.slow.iter_mut();
        for (section, (slow, carry)) in self.sections.iter().zip(states).take(self.used) {
            let y = section.direct * signal + section.slow * *slow;
            approach(slow, carry, section.decay, signal);
            signal = y;
            rest = section.direct * rest + section.slow * *slow;
        }
        history.past = self.gain * rest;
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real, const N: usize> FrequencyResponse for Cascade<F, N> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let gain = Complex::new(self.gain.to_f64() / self.rate, 0.0);
        let sections = self.sections.iter().take(self.used);
        sections.fold(gain, |product, section| {
            let slow = low_pass(theta, section.decay.to_f64()) * section.slow.to_f64();
            product * (slow + section.direct.to_f64())
        })
    }
}
