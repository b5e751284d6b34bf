//! The far end of a sum over the aliases of a frequency, whose terms fall as a power and turn with a part of a sample of dead time.
//!
//! ```text
//! Σ_{k≥0} f(k) = ∫₀^∞ f dk + f(0)/2 − f′(0)/12 + f‴(0)/720 − …,   f(k) = g(a + k)·e^(−jck)     (L. Euler, C. Maclaurin)
//! ```
//! The integral is taken octave by octave while f turns slowly, and from A on along the path on which e^(−jck) falls,
//! with g the power that it is there:
//!
//! ```text
//! ∫₀^∞ (1 + k/A)^(−β)·e^(−jck) dk = −j·sgn(c)/|c|·∫₀^∞ e^(−u)·(1 − j·sgn(c)·u/(|c|A))^(−β) du
//! ```

use core::f64::consts::PI;
use num_complex::Complex;

/// Orders of the terms from which their sum is known.
const ORDER_LEAST: f64 = 1.02;
/// Parts of a sample up to which the terms turn slowly enough for an integral.
const SLOW: f64 = 0.1;
/// Parts of a sample that are none.
const NONE: f64 = 1e-9;
/// Octaves at most, and the angle by which f turns in one at most, rad.
const OCTAVES: i32 = 10;
const TURN: f64 = 4.0;
/// Half of the places and weights of C. F. Gauss for six points of (−1, 1).
const GAUSS: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];
/// Steps of ln u: an error of e^(−π²/step).
const STEP: f64 = 0.5;
/// What is left out of the integral on either side, as ln u.
const NOTHING: f64 = 23.0;
const END: f64 = 3.75;

/// The sum of g(a)·1 + g(a + 1)·z + g(a + 2)·z² + …, z = e^(−2πj·part), −1/2 ≤ part ≤ 1/2; not finite where it does not end.
///
/// `g` is smooth, and from a on nearly a power of its place.
pub(crate) fn sum(g: impl Fn(f64) -> Complex<f64>, a: f64, part: f64) -> Complex<f64> {
    let begin = g(a);
    if begin.norm() == 0.0 {
        return begin;
    }
    let order = order(&g, a);
    if part.abs() > SLOW {
        return begin * by_parts(a, order, part);
    }
    let c = if part.abs() < NONE {
        0.0
    } else {
        2.0 * PI * part
    };
    let turn = Complex::new(0.0, c);
    let first = order / a;
    let second = first * (order + 1.0) / a;
    let third = second * (order + 2.0) / a;
    // f′ and f‴ over −f.
    let once = turn + first;
    let thrice = turn * turn * turn + turn * turn * first * 3.0 + turn * second * 3.0 + third;
    begin * (once / 12.0 - thrice / 720.0 + 0.5) + integral(&g, a, c)
}

/// β of g ~ place^(−β) at this place.
fn order(g: &impl Fn(f64) -> Complex<f64>, place: f64) -> f64 {
    -libm::log(g(1.1 * place).norm() / g(place).norm()) / libm::log(1.1)
}

/// ∫₀^∞ g(a + k)·e^(−jck) dk
fn integral(g: &impl Fn(f64) -> Complex<f64>, a: f64, c: f64) -> Complex<f64> {
    let late = |place: f64| Complex::from_polar(1.0, -c * (place - a));
    let (mut sum, mut low) = (Complex::new(0.0, 0.0), a);
    for _ in 0..OCTAVES {
        if c.abs() * low > TURN {
            break;
        }
        let half = 0.5 * low;
        for (place, weight) in GAUSS {
            for place in [low + half * (1.0 - place), low + half * (1.0 + place)] {
                sum += g(place) * late(place) * (weight * half);
            }
        }
        low *= 2.0;
    }
    let order = order(g, low);
    if order.is_nan() || order < ORDER_LEAST {
        return Complex::new(f64::NAN, f64::NAN);
    }
    sum + g(low) * late(low) * of_power(order, low, c)
}

/// ∫₀^∞ (1 + k/a)^(−β)·e^(−jck) dk, by equal steps of ln u.
fn of_power(order: f64, a: f64, c: f64) -> Complex<f64> {
    if c == 0.0 {
        return Complex::new(a / (order - 1.0), 0.0);
    }
    let wide = 1.0 / (c.abs() * a);
    let low = -NOTHING - libm::log(wide.max(1.0));
    let steps = libm::ceil((END - low) / STEP) as usize;
    let values = (0..=steps).map(|n| {
        let u = libm::exp(low + STEP * n as f64);
        let (across, angle) = (u * wide, libm::atan(u * wide));
        let size = u * libm::exp(-u) * libm::pow(across * across + 1.0, -0.5 * order);
        Complex::from_polar(size, c.signum() * order * angle)
    });
    values.sum::<Complex<f64>>() * Complex::new(0.0, -STEP / c)
}

/// Σ (1 + k/a)^(−β)·z^k by parts: z turns, the size hardly changes.
fn by_parts(a: f64, order: f64, part: f64) -> Complex<f64> {
    let size = |k: f64| libm::pow((a + k) / a, -order);
    let z = Complex::from_polar(1.0, -2.0 * PI * part);
    let (once, by) = (size(1.0) - 1.0, (-z + 1.0).inv());
    let twice = size(2.0) - 2.0 * size(1.0) + 1.0;
    by * (z * by * (z * by * twice + once) + 1.0)
}
