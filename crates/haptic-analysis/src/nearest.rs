//! The two coefficients ≥ 0 of a law that come nearest to given numbers, where the worst counts.
//!
//! ```text
//! K*, B* = argmin over K, B ≥ 0 of  max_i |a_i·K + b_i·B − c_i| / w_i
//! ```
//! The function is convex in both, so that golden sections of one, within those of the other, find its least value. Each takes a number to
//! 1e-10 of where the function turns; a long flat valley ends anywhere in it. Cost: some 10⁴ visits of each row.

/// Golden sections: they shrink a bracket by 0.618^48 = 1e-10.
const SECTIONS: usize = 48;
/// Doublings of a bracket: a row that no number reaches is left after them.
const DOUBLINGS: usize = 60;

/// A number that is wanted, and its weight: a, b, c and w above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WantedNumber {
    /// a and b, the factors of K and B.
    pub parts: [f64; 2],
    /// c, which a·K + b·B should reach.
    pub value: f64,
    /// w, above 0.
    pub weight: f64,
}

/// K* and B*, in the units of c/a and c/b; zeros of no rows.
#[must_use]
pub fn nearest(rows: &[WantedNumber]) -> [f64; 2] {
    let worst = |[k, b]: [f64; 2]| {
        let off = |row: &WantedNumber| {
            let [of_k, of_b] = row.parts;
            (of_k * k + of_b * b - row.value).abs() / row.weight
        };
        rows.iter().map(off).fold(0.0, f64::max)
    };
    let size = |part: usize| {
        let largest = |number: fn(&WantedNumber, usize) -> f64| {
            rows.iter()
                .map(|row| number(row, part).abs())
                .fold(0.0, f64::max)
        };
        let ratio = largest(|row, _| row.value) / largest(|row, part| row.parts[part]);
        if ratio.is_finite() { ratio } else { 0.0 }
    };
    let sizes = [size(0), size(1)];
    let beside = |k: f64| least(sizes[1], &|b| worst([k, b]));
    let k = least(sizes[0], &|k| worst([k, beside(k)]));
    [k, beside(k)]
}

/// The x ≥ 0 of the least value of a convex function, by golden sections.
fn least(size: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_894_8;
    let mut high = size;
    for _ in 0..DOUBLINGS {
        if f(2.0 * high) >= f(high) {
            break;
        }
        high *= 2.0;
    }
    let (mut from, mut to) = (0.0, 2.0 * high);
    let (mut low, mut up) = (to - SHARE * (to - from), from + SHARE * (to - from));
    let (mut at_low, mut at_up) = (f(low), f(up));
    for _ in 0..SECTIONS {
        if at_low <= at_up {
            (to, up, at_up) = (up, low, at_low);
            low = to - SHARE * (to - from);
            at_low = f(low);
        } else {
            (from, low, at_low) = (low, up, at_up);
            up = from + SHARE * (to - from);
            at_up = f(up);
        }
    }
    let middle = 0.5 * (from + to);
    if f(0.0) <= f(middle) { 0.0 } else { middle }
}

#[cfg(test)]
mod tests {
    use super::{WantedNumber, nearest};

    #[test]
    fn no_other_two_numbers_are_nearer_and_a_law_that_fits_is_found() {
        let mut seed = 1_u64;
        let mut draw = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for round in 0..60 {
            let truth = [3.0 * draw(), 2.0 * draw()];
            let rows: Vec<WantedNumber> = (0..9)
                .map(|_| {
                    let parts = [draw() + 0.2, draw() - 0.5];
                    let exact = parts[0] * truth[0] + parts[1] * truth[1];
                    WantedNumber {
                        parts,
                        value: exact
                            + if round % 2 == 0 {
                                0.0
                            } else {
                                2.0 * draw() - 1.5
                            },
                        weight: 0.1 + draw(),
                    }
                })
                .collect();
            let found = nearest(&rows);
            let worst = |[k, b]: [f64; 2]| {
                let off = |row: &WantedNumber| {
                    (row.parts[0] * k + row.parts[1] * b - row.value).abs() / row.weight
                };
                rows.iter().map(off).fold(0.0, f64::max)
            };
            if round % 2 == 0 {
                assert!(worst(found) < 1e-7, "{found:?} for {truth:?}");
            }
            for n in 0..10_000 {
                let other = [0.06 * f64::from(n % 100), 0.06 * f64::from(n / 100)];
                assert!(worst(found) <= worst(other) + 1e-7, "{found:?}, {other:?}");
            }
        }
        assert!(nearest(&[]).iter().all(|number| number.abs() < 1e-300));
    }
}
