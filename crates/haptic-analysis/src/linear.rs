//! A plant given by matrices: checks, natural units, poles and numerator of its samples.

use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::range;
use fracdiff::product;
use nalgebra::{Complex, DMatrix, DVector, RowDVector};

pub(crate) const STATES_MAX: usize = 8;
const FASTEST: f64 = 1e6;
/// Largest accepted difference between the polynomials and the matrices, of the sum of the numerator.
const AGREEMENT: f64 = 1e-9;

/// A plant in units of one sample, with its lag as a state.
pub(crate) type Matrices = (DMatrix<f64>, DVector<f64>, RowDVector<f64>);

/// Checks sizes and numbers, adds the lag as a state, and takes samples as the unit of time, T²/m as that of the gain.
pub(crate) fn scaled(
    [a, b, c]: [&[f64]; 3],
    sample_time_s: f64,
    mass_kg: f64,
    path: ForcePath,
) -> Result<Matrices, AnalysisError> {
    let lag = usize::from(path.lag_samples() > 0.0);
    check_lists(a, b, c, lag)?;
    let n = b.len();
    let size = n + lag;
    let mut matrix = DMatrix::zeros(size, size);
    let mut input = DVector::zeros(size);
    let mut output = RowDVector::zeros(size);
    let rate = if lag == 1 {
        1.0 / path.lag_samples()
    } else {
        0.0
    };
    // y·m/T² for u: the numerator of a mass is then that of (4.1).
    let gain = mass_kg / sample_time_s;
    for row in 0..n {
        for column in 0..n {
            matrix[(row, column)] = a[row * n + column] * sample_time_s;
        }
        output[row] = c[row];
        let driven = b[row] * gain;
        if lag == 1 {
            matrix[(row, n)] = driven;
        } else {
            input[row] = driven;
        }
    }
    if lag == 1 {
        matrix[(n, n)] = -rate;
        input[n] = rate;
    }
    balance(&mut matrix, &mut input, &mut output);
    let fastest = matrix.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let kept = fastest <= FASTEST.max(rate);
    let (what, allowed) = ("fastest motion of the plant", "at most 1e6 {}");
    range(what, fastest, kept, allowed, "per sample")?;
    Ok((matrix, input, output))
}

/// Refuses lists that are not square, not as long as one another or not finite.
fn check_lists(a: &[f64], b: &[f64], c: &[f64], lag: usize) -> Result<(), AnalysisError> {
    let n = b.len();
    let most = STATES_MAX - lag;
    let allowed = if lag == 0 {
        "from 1 to 8"
    } else {
        "from 1 to 7 with a current lag"
    };
    let kept = (1..=most).contains(&n);
    range("states of a plant", n as f64, kept, allowed, "")?;
    for (what, length, wanted) in [
        ("entries of A", a.len(), n * n),
        ("entries of C", c.len(), n),
    ] {
        let allowed = "as many as the entries of B ask for";
        range(what, length as f64, length == wanted, allowed, "")?;
    }
    for (what, list) in [("entry of A", a), ("entry of B", b), ("entry of C", c)] {
        for &value in list {
            range(what, value, true, "finite", "")?;
        }
    }
    Ok(())
}

/// Units of the states, powers of two, in which rows and columns of A are about as large.
pub(crate) fn balance(a: &mut DMatrix<f64>, b: &mut DVector<f64>, c: &mut RowDVector<f64>) {
    let n = a.nrows();
    for _ in 0..20 {
        let mut settled = true;
        for i in 0..n {
            let sum = |list: &mut dyn Iterator<Item = f64>| list.sum::<f64>();
            let row = sum(&mut (0..n).filter(|&j| j != i).map(|j| a[(i, j)].abs()));
            let column = sum(&mut (0..n).filter(|&j| j != i).map(|j| a[(j, i)].abs()));
            if row == 0.0 || column == 0.0 {
                continue;
            }
            let exponent = libm::rint(0.5 * (libm::log2(row) - libm::log2(column)));
            if exponent == 0.0 {
                continue;
            }
            settled = false;
            let unit = libm::exp2(exponent);
            for j in 0..n {
                a[(i, j)] /= unit;
                a[(j, i)] *= unit;
            }
            b[i] /= unit;
            c[i] *= unit;
        }
        if settled {
            return;
        }
    }
}

/// 1 − cw of a real pole s, c = e^s, in powers of w and of v.
fn single(pole: f64) -> (Vec<f64>, Vec<f64>) {
    let decay = libm::exp(pole);
    (vec![1.0, -decay], vec![-libm::expm1(pole), decay])
}

/// (1 − cw)(1 − c̄w) of a pole s and the one conjugate to it, in powers of w and of v; 1 − c without cancellation.
fn pair(pole: Complex<f64>) -> (Vec<f64>, Vec<f64>) {
    let (decay, omega) = (libm::exp(pole.re), pole.im);
    let (sin, cos) = libm::sincos(omega);
    let half_sine = libm::sin(0.5 * omega);
    let gone = -libm::expm1(pole.re) + 2.0 * decay * half_sine * half_sine;
    let swing = decay * sin;
    // (1 − cw)(1 − c̄w), and |1 − c|² + 2Re(c(1 − c̄))v + |c|²v²
    (
        vec![1.0, -2.0 * decay * cos, decay * decay],
        vec![
            gone * gone + swing * swing,
            2.0 * (decay * cos * gone - swing * swing),
            decay * decay,
        ],
    )
}

/// Poles of the plant. Those at rest are 0 itself, as many as directions that A and A² do not move: rounding leaves of a double
/// one a pair of some 1e-8, which grows or falls.
pub(crate) fn poles(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let mut poles: Vec<Complex<f64>> = fracdiff::eigenvalues(a.as_slice(), a.nrows());
    let at_rest = |a: &DMatrix<f64>| {
        let sizes = a.singular_values();
        let least = 1e-14 * sizes.max();
        sizes.iter().filter(|size| **size <= least).count()
    };
    let rests = usize::max(at_rest(a), at_rest(&(a * a)));
    poles.sort_by(|one, other| one.norm().total_cmp(&other.norm()));
    for pole in poles.iter_mut().take(rests) {
        *pole = Complex::new(0.0, 0.0);
    }
    poles
}

/// The polynomials of a sampled plant.
#[derive(Clone, Debug)]
pub(crate) struct Sampled {
    pub(crate) denominator: Vec<f64>,
    pub(crate) denominator_in_v: Vec<f64>,
    pub(crate) numerator: Vec<f64>,
}

impl Sampled {
    pub(crate) fn new(matrices: &Matrices, fraction: f64) -> Result<Self, AnalysisError> {
        let (a, b, c) = matrices;
        let spoiled = |why| AnalysisError::Unresolved {
            what: "the sampled plant",
            why,
        };
        let (mut denominator, mut in_v) = (vec![1.0], vec![1.0]);
        for pole in poles(a) {
            let (sampled, sampled_in_v) = if pole.im == 0.0 {
                single(pole.re)
            } else if pole.im > 0.0 {
                pair(pole)
            } else {
                // With the pole that it is conjugate to.
                continue;
            };
            denominator = product(&denominator, &sampled);
            in_v = product(&in_v, &sampled_in_v);
        }
        if in_v.len() != a.nrows() + 1 {
            return Err(spoiled("its poles do not converge"));
        }
        let numerator = numerator(matrices, fraction, &denominator);
        let sampled = Self {
            denominator,
            denominator_in_v: in_v,
            numerator,
        };
        let size: f64 = sampled.numerator.iter().map(|x| x.abs()).sum();
        if !size.is_finite() {
            return Err(spoiled(
                "a motion in it grows beyond all numbers within a sample",
            ));
        }
        let moved = Motion::new(a, b, 1.0).input;
        let felt: f64 = (c.iter().zip(moved.iter()))
            .map(|(c, x)| (c * x).abs())
            .sum();
        if size <= 1e-12 * felt || size == 0.0 {
            return Err(spoiled("its input does not move its output"));
        }
        if sampled.disagreement(matrices, fraction) > AGREEMENT * size {
            return Err(spoiled(
                "rounding errors spoil its polynomials: leave out motions that the loop cannot feel",
            ));
        }
        Ok(sampled)
    }

    /// The largest |A(w)·C(1 − wΦ)⁻¹(Γ₀ + Γ₁w) − N(w)| at eight angles.
    fn disagreement(&self, (a, b, c): &Matrices, fraction: f64) -> f64 {
        let complex = |x: f64| Complex::new(x, 0.0);
        let sample = Motion::new(a, b, 1.0).state;
        let late = Motion::new(a, b, 1.0 - fraction);
        let early = late.carry(&Motion::new(a, b, fraction).input);
        let mut most: f64 = 0.0;
        for k in 0..8 {
            let theta = 3.0 * libm::pow(0.5, f64::from(k));
            let place = certified_count::Place::new(theta);
            // 1 − wΦ = v − wE
            let system = DMatrix::from_fn(a.nrows(), a.nrows(), |i, j| {
                let identity = if i == j { place.v } else { complex(0.0) };
                identity - place.w * sample[(i, j)]
            });
            let driven = DVector::from_fn(a.nrows(), |i, _| place.w * early[i] + late.input[i]);
            let Some(x) = system.lu().solve(&driven) else {
                return f64::INFINITY;
            };
            let direct = (0..a.nrows()).fold(complex(0.0), |sum, i| sum + x[i] * c[i]);
            let at = |list: &[f64], x: Complex<f64>| {
                let terms = list.iter().rev();
                terms.fold(complex(0.0), |sum, term| sum * x + *term)
            };
            let difference =
                at(&self.denominator_in_v, place.v) * direct - at(&self.numerator, place.w);
            most = if difference.norm() <= most {
                most
            } else {
                difference.norm()
            };
        }
        most
    }
}

/// Motion of a linear plant over part of a sample, by [`fracdiff::linear_motion`].
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// exp(A·t) − 1.
    pub(crate) state: DMatrix<f64>,
    /// The state to which a unit input takes the plant from rest.
    pub(crate) input: DVector<f64>,
}

impl Motion {
    /// Motion for `a` and `b` in units of one sample, `duration` in samples.
    pub(crate) fn new(a: &DMatrix<f64>, b: &DVector<f64>, duration: f64) -> Self {
        let (state, input) = fracdiff::linear_motion(a.as_slice(), b.as_slice(), duration);
        Self {
            state: DMatrix::from_vec(a.nrows(), a.ncols(), state),
            input: input.into(),
        }
    }

    pub(crate) fn carry(&self, x: &DVector<f64>) -> DVector<f64> {
        x + &self.state * x
    }
}

/// The numerator in powers of w of a plant whose input changes at the fraction h of a sample, for the denominator a.
/// ```text
/// N = C·adj(1 − wΦ)·(Γ₀ + Γ₁w) = Σ_j (r_jΓ₀ + r_{j−1}Γ₁)w^j,    r₀ = C,  r_j = r_{j−1}Φ + a_jC
/// Γ₀ = ∫₀^(1−h) e^(As)B ds,    Γ₁ = e^(A(1−h))·∫₀^h e^(As)B ds
/// ```
pub(crate) fn numerator(matrices: &Matrices, fraction: f64, denominator: &[f64]) -> Vec<f64> {
    let (a, b, c) = matrices;
    let n = a.nrows();
    let sample = Motion::new(a, b, 1.0);
    let late = Motion::new(a, b, 1.0 - fraction);
    let early = (fraction > 0.0).then(|| late.carry(&Motion::new(a, b, fraction).input));
    let mut row = c.clone();
    let mut before: Option<RowDVector<f64>> = None;
    let mut terms = Vec::new();
    for j in 0..=n {
        let mut term = if j < n {
            row.dot(&late.input.transpose())
        } else {
            0.0
        };
        if let (Some(before), Some(early)) = (&before, &early) {
            term += before.dot(&early.transpose());
        }
        if j < n || early.is_some() {
            terms.push(term);
        }
        let next = &row + &row * &sample.state + c * denominator[(j + 1).min(n)];
        before = Some(std::mem::replace(&mut row, next));
    }
    terms
}

/// The plant in continuous time, in units of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Continuous {
    /// δ and γ of a mass with damper and hand.
    pub(crate) named: [f64; 2],
    /// Any linear plant instead, its lag among the states.
    pub(crate) linear: Option<Lists>,
}

/// Matrices without an allocation: A by rows, then B and C, for `states` states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lists {
    states: usize,
    a: [[f64; STATES_MAX]; STATES_MAX],
    b: [f64; STATES_MAX],
    c: [f64; STATES_MAX],
}

impl Lists {
    /// Lists of at most `STATES_MAX` states.
    pub(crate) fn new((a, b, c): &Matrices) -> Self {
        let mut lists = Self {
            states: b.len().min(STATES_MAX),
            a: [[0.0; STATES_MAX]; STATES_MAX],
            b: [0.0; STATES_MAX],
            c: [0.0; STATES_MAX],
        };
        for row in 0..lists.states {
            (lists.b[row], lists.c[row]) = (b[row], c[row]);
            for column in 0..lists.states {
                lists.a[row][column] = a[(row, column)];
            }
        }
        lists
    }

    pub(crate) fn matrices(&self) -> Matrices {
        let n = self.states;
        (
            DMatrix::from_fn(n, n, |row, column| self.a[row][column]),
            DVector::from_column_slice(&self.b[..n]),
            RowDVector::from_row_slice(&self.c[..n]),
        )
    }
}

impl Continuous {
    /// About the radians by which the fastest motion turns within a sample, or more.
    pub(crate) fn turn(&self) -> f64 {
        match &self.linear {
            None => libm::sqrt(self.named[1]),
            Some(lists) => {
                let entries = lists.a.iter().flatten();
                entries.fold(0.0, |most: f64, x| most.max(x.abs()))
            }
        }
    }
}
