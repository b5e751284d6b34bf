//! Modes that decay, a step at a time.
//! ```text
//! mode e^(−rt):       h ← h + m·(h − ε'/r),               m = e^(−rΔ) − 1
//! mode 1 − e^(−rt):   d ← d + m·(d − σ) + σ'·(rΔ + m)/r
//! ```

/// Modes after which the rates of a ladder have doubled.
pub const LANES: usize = 3;

/// m and (rΔ + m)/r of each mode for a step; with the inverses of rates that double from lane to lane, by doubling.
pub fn decays(
    rates: &[f64],
    inverse_rates: Option<&[f64]>,
    step: f64,
    [decay, lag]: [&mut [f64]; 2],
) {
    let values = decay.iter_mut().zip(&mut *lag);
    let Some(inverse_rates) = inverse_rates else {
        for ((decay, out), rate) in values.zip(rates) {
            *decay = libm::expm1(-rate * step);
            *out = excess(rate * step, *decay) / rate;
        }
        return;
    };
    // m(2x) = m·(2 + m) and f(2x) = 2f + m² for f = x + m.
    let (mut m, mut f) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..usize::min(LANES, rates.len()) {
        let x = rates[lane] * step;
        m[lane] = libm::expm1(-x);
        f[lane] = excess(x, m[lane]);
    }
    let chunks = decay.chunks_mut(LANES).zip(lag.chunks_mut(LANES));
    for ((decay, lag), inverse) in chunks.zip(inverse_rates.chunks(LANES)) {
        for lane in 0..decay.len() {
            decay[lane] = m[lane];
            lag[lane] = f[lane] * inverse[lane];
            f[lane] = 2.0 * f[lane] + m[lane] * m[lane];
            m[lane] *= 2.0 + m[lane];
        }
    }
}

/// Takes each mode h a step on; Σ w·h.
pub fn relaxed(
    modes: &mut [f64],
    decay: &[f64],
    inverse_rates: &[f64],
    weights: &[f64],
    slope: f64,
) -> f64 {
    advance(modes, decay, inverse_rates, weights, |h, m, inverse| {
        h + m * (h - slope * inverse)
    })
}

/// Takes each mode d a step on, from this input with this slope; Σ w·d.
pub fn crept(
    modes: &mut [f64],
    decay: &[f64],
    lag: &[f64],
    weights: &[f64],
    [begin, slope]: [f64; 2],
) -> f64 {
    advance(modes, decay, lag, weights, |d, m, lag| {
        d + m * (d - begin) + slope * lag
    })
}

/// Sums that run beside each other, so that none waits for the one before it.
const PARTS: usize = 4;

/// Takes each mode a step on; Σ w·mode.
fn advance(
    modes: &mut [f64],
    decay: &[f64],
    other: &[f64],
    weights: &[f64],
    next: impl Fn(f64, f64, f64) -> f64,
) -> f64 {
    let mut sums = [0.0; PARTS];
    let (modes, last_modes) = modes.as_chunks_mut::<PARTS>();
    let (decay, last_decay) = decay.as_chunks::<PARTS>();
    let (other, last_other) = other.as_chunks::<PARTS>();
    let (weights, last_weights) = weights.as_chunks::<PARTS>();
    for (((mode, m), x), w) in modes.iter_mut().zip(decay).zip(other).zip(weights) {
        for part in 0..PARTS {
            mode[part] = next(mode[part], m[part], x[part]);
            sums[part] += w[part] * mode[part];
        }
    }
    let last = last_modes.iter_mut().zip(last_decay);
    for ((mode, m), (x, w)) in last.zip(last_other.iter().zip(last_weights)) {
        *mode = next(*mode, *m, *x);
        sums[0] += w * *mode;
    }
    sums.iter().sum()
}

/// x + m for m = e^(−x) − 1, without cancellation.
#[must_use]
pub fn excess(x: f64, m: f64) -> f64 {
    if x > 0.1 {
        return x + m;
    }
    // x²/2 − x³/6 + …: twelve terms reach rounding at 0.1.
    let mut sum = 0.0;
    for n in (2..14).rev() {
        sum = (1.0 - sum) * (x / f64::from(n));
    }
    sum * x
}
