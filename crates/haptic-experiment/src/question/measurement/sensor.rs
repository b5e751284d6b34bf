//! Encoder step and noise of the position.

/// Steps are whole multiples of the smallest one within this share of it.
const WHOLE: f64 = 0.05;
/// Differences below this are rounding, m.
const ROUNDING_M: f64 = 1e-12;
/// Levels below which nothing is said about steps.
const LEVELS: usize = 5;

/// q: the step of which all differences of positions are multiples, m; `None` if they have none.
///
/// The smallest difference of two positions is the first guess. Counting the levels up from the lowest, all differences must be whole multiples of
/// it; the way from the lowest to the highest level, divided by the count, is q. *Cost*: a sort.
pub(super) fn encoder_step(positions_m: &[f64]) -> Option<f64> {
    let mut levels: Vec<f64> = positions_m
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() < ROUNDING_M);
    let (lowest, highest) = (levels.first()?, levels.last()?);
    if levels.len() < LEVELS {
        return None;
    }
    let gaps = || levels.windows(2).map(|pair| pair[1] - pair[0]);
    let smallest = gaps().fold(f64::INFINITY, f64::min);
    let mut count = 0.0;
    for gap in gaps() {
        let steps = gap / smallest;
        if (steps - steps.round()).abs() > WHOLE * steps.round().clamp(1.0, 3.0) {
            return None;
        }
        count += steps.round();
    }
    Some((highest - lowest) / count)
}

/// Noise beside the rounding to steps of q, from what is left of a fit: value, low and high, m.
///
/// ```text
/// σ² = mean r² − q²/12        its error by blocks of the record
/// ```
pub(super) fn noise_m(left: &[f64], free: usize, step_m: f64, sides: f64) -> [f64; 3] {
    let squares: f64 = left.iter().map(|r| r * r).sum();
    let variance = squares / free.max(1) as f64;
    let block = (left.len() / 40).max(10);
    let means: Vec<f64> = left
        .chunks(block)
        .map(|chunk| chunk.iter().map(|r| r * r).sum::<f64>() / chunk.len() as f64)
        .collect();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let spread = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>();
    let error = (spread / (count * (count - 1.0).max(1.0))).sqrt();
    let rounding = step_m * step_m / 12.0;
    let beside = (variance - rounding).max(0.0);
    [beside, beside - sides * error, beside + sides * error]
        .map(|variance| variance.max(0.0).sqrt())
}

/// Standard deviation, m; 0 of fewer than two.
pub(super) fn deviation_m(positions_m: &[f64]) -> f64 {
    let known: Vec<f64> = positions_m
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    if known.len() < 2 {
        return 0.0;
    }
    let count = known.len() as f64;
    let mean = known.iter().sum::<f64>() / count;
    (known.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_found_where_there_are_steps_alone() {
        let wave = |n: usize| 1.7e-3 * (0.037 * n as f64).sin() + 3e-4 * (0.011 * n as f64).cos();
        let smooth: Vec<f64> = (0..5000).map(wave).collect();
        assert_eq!(encoder_step(&smooth), None);
        for step in [1e-6, 1e-5, 3.3e-5] {
            let rounded: Vec<f64> = smooth.iter().map(|x| (x / step).round() * step).collect();
            let found = encoder_step(&rounded).expect("has steps");
            assert!((found / step - 1.0).abs() < 1e-9, "{found} for {step}");
            // As they come over the wire.
            let single: Vec<f64> = rounded.iter().map(|x| f64::from(*x as f32)).collect();
            let found = encoder_step(&single).expect("has steps");
            assert!((found / step - 1.0).abs() < 1e-3, "{found} for {step}");
        }
        assert_eq!(encoder_step(&[0.0; 100]), None);
    }

    #[test]
    fn the_noise_is_what_rounding_does_not_explain() {
        // ±1 and ±3 alternate: the variance is 5.
        let left: Vec<f64> = (0..4000).map(|n| [1.0, -1.0, 3.0, -3.0][n % 4]).collect();
        let [value, low, high] = noise_m(&left, left.len(), 0.0, 1.96);
        assert!((value - 5_f64.sqrt()).abs() < 1e-12);
        assert!(low <= value && value <= high);
        let [value, ..] = noise_m(&left, left.len(), 12_f64.sqrt(), 1.96);
        assert!((value - 2.0).abs() < 1e-12);
        assert!(deviation_m(&[1.0, f64::NAN, 3.0]) - 2_f64.sqrt() < 1e-12);
    }
}
