//! Amplitudes at the frequencies of the motion.

use fracdiff::num_complex::Complex;

/// Sums of M signals over a window, at each frequency.
///
/// ```text
/// X_i = Σ x[n]·e^(−jω_i t_n)        whole periods of each frequency, so that none leaks into another
/// ```
#[derive(Clone, Debug)]
pub(super) struct Spectrum<const M: usize> {
    omegas: Vec<f64>,
    sums: Vec<[Complex<f64>; M]>,
}

impl<const M: usize> Spectrum<M> {
    /// Empty.
    pub(super) fn new(omegas: Vec<f64>) -> Self {
        let sums = vec![[Complex::new(0.0, 0.0); M]; omegas.len()];
        Self { omegas, sums }
    }

    /// Adds a sample.
    pub(super) fn add(&mut self, time_s: f64, values: [f64; M]) {
        for (omega, sums) in self.omegas.iter().zip(&mut self.sums) {
            let turned = Complex::from_polar(1.0, -omega * time_s);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += turned * value;
            }
        }
    }

    /// Frequency, rad/s, and sums.
    pub(super) fn iter(&self) -> impl Iterator<Item = (f64, &[Complex<f64>; M])> {
        self.omegas.iter().copied().zip(&self.sums)
    }
}
