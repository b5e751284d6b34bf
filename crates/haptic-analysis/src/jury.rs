//! Stability of a polynomial: the Schur–Cohn (Jury) recursion, and its poles.

use num_complex::Complex;

/// The outcome of the recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Jury {
    /// All zeros are outside the closed unit disc of w: all poles in z inside.
    Stable,
    /// At least one is not.
    NotStable,
    /// A reflection coefficient is so close to ±1 that rounding errors could decide.
    Undecided,
}

/// Decides if Σ `x_j` w^j has no zero in |w| ≤ 1, by the recursion of Schur and Cohn.
///
/// ```text
/// k = x_n/x₀,   x_j ← (x_j − k·x_{n−j})/(1 − k²),   n ← n − 1;    no such zero ⇔ all |k| < 1
/// ```
/// In f64 the recursion loses a factor 1/(1 − |k|) a step; it says so ([`Jury::Undecided`]) when the
/// estimated loss reaches the next 1 − |k|, which happens within about 1e-8 of the boundary, or
/// farther for several slow poles at once. Cost: n² multiply-adds.
/// Source: E. I. Jury, *Theory and Application of the z-Transform Method*, Wiley, 1964, ch. 3.
///
pub(crate) fn jury(coefficients: &[f64]) -> Jury {
    let Some((&first, _)) = coefficients.split_first() else {
        return Jury::Undecided;
    };
    if !coefficients.iter().all(|x| x.is_finite()) {
        return Jury::Undecided;
    }
    if first == 0.0 {
        return Jury::NotStable;
    }
    let mut x: Vec<f64> = coefficients.iter().map(|x| x / first).collect();
    let size = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut error = 4.0 * f64::EPSILON * size;
    while x.len() > 1 {
        let n = x.len() - 1;
        let k = x[n];
        if (1.0 - k.abs()).abs() <= error {
            return Jury::Undecided;
        }
        if k.abs() > 1.0 {
            return Jury::NotStable;
        }
        error = error / (1.0 - k.abs()) + f64::EPSILON;
        let scale = 1.0 / ((1.0 - k) * (1.0 + k));
        let next = (0..n).map(|j| {
            if j == 0 {
                1.0
            } else {
                (x[j] - k * x[n - j]) * scale
            }
        });
        x = next.collect();
    }
    Jury::Stable
}

/// The zeros in z = 1/w of Σ `x_j` w^j, those at z = 0 left out; `None` if a coefficient is no number.
pub(crate) fn poles(mut polynomial: Vec<f64>) -> Option<Vec<Complex<f64>>> {
    let used = polynomial.iter().rposition(|&x| x != 0.0)? + 1;
    polynomial.truncate(used);
    polynomial.reverse();
    let poles = fracdiff::roots(&polynomial);
    poles.iter().all(|pole| pole.is_finite()).then_some(poles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::multiply;

    fn from_poles(poles: &[f64]) -> Vec<f64> {
        // Π (1 − p·w)
        (poles.iter()).fold(vec![1.0], |product, p| multiply(&product, &[1.0, -p]))
    }

    #[test]
    fn a_polynomial_is_stable_when_all_its_poles_are_inside() {
        assert_eq!(jury(&from_poles(&[0.9, -0.5, 0.99])), Jury::Stable);
        assert_eq!(jury(&from_poles(&[0.9, -0.5, 1.01])), Jury::NotStable);
        assert_eq!(jury(&from_poles(&[0.9, -1.5, 0.3])), Jury::NotStable);
        assert_eq!(jury(&from_poles(&[0.9, 1.0])), Jury::Undecided);
        assert_eq!(jury(&[1.0]), Jury::Stable);
        assert_eq!(jury(&[0.0, 1.0]), Jury::NotStable);
        assert_eq!(jury(&[1.0, f64::NAN]), Jury::Undecided);
    }

    #[test]
    fn a_multiple_pole_is_counted_as_often_as_it_stands() {
        // A triple pole splits by the rounding of the coefficients.
        for pole in [0.3, 0.9, 0.99, 1.01] {
            let values = poles(from_poles(&[pole; 3])).expect("finite");
            let far = |value: &Complex<f64>| (value - pole).norm() > 1e-4;
            assert!(values.len() == 3 && !values.iter().any(far), "{values:?}");
        }
    }

    #[test]
    fn a_polynomial_gives_back_the_poles_it_was_made_from() {
        let mut have: Vec<f64> = poles(from_poles(&[0.9, -0.5, 1.2, 0.0]))
            .expect("finite")
            .iter()
            .map(|pole| pole.re)
            .collect();
        have.sort_by(f64::total_cmp);
        for (have, want) in have.iter().zip([-0.5, 0.9, 1.2]) {
            assert!((have - want).abs() < 1e-14, "{have} {want}");
        }
    }
}
