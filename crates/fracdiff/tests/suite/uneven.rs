//! D^μ at uneven times: 50-digit values of the lines between the samples, and closed forms of the curves behind them.

use crate::oracle::order;
use fracdiff::batch::uneven;

const GOLDEN: &str = include_str!("../golden/uneven.csv");

/// Times and samples of a record of the golden file.
fn record(name: &str) -> (Vec<f64>, Vec<f64>) {
    let rows = GOLDEN
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>());
    let samples = rows.filter(|row| row[0] == name && row[1] == "sample");
    let number = |cell: &str| cell.parse::<f64>().expect("a number");
    samples.map(|row| (number(row[2]), number(row[3]))).unzip()
}

#[test]
fn uneven_times_give_the_lines_to_the_rounding() {
    let mut compared = 0;
    for name in ["geometric", "jittered"] {
        let (times, x) = record(name);
        assert_eq!(times.len(), 121);
        for line in GOLDEN.lines().skip(1) {
            let row: Vec<&str> = line.split(',').collect();
            if row[0] != name || row[1] == "sample" {
                continue;
            }
            let [mu, reference, want] =
                [1, 2, 4].map(|at| row[at].parse::<f64>().expect("a number"));
            let n: usize = row[3].parse().expect("a number");
            let have = uneven(order(mu), &times, &x, reference).expect("valid")[n];
            // Each line is a difference of powers, which leaves few digits of a short and steep one long ago.
            let steps = || (0..n).map(|j| (times[j + 1] - times[j], (x[j + 1] - x[j]).abs()));
            let power = (times[n] - times[0]).powf(1.0 - mu);
            let rounding: f64 = steps().map(|(step, rise)| rise / step * power).sum();
            let error = (have - want).abs();
            let allowed = 2.5e-16 * rounding + 1e-13 * want.abs();
            assert!(
                error <= allowed,
                "{name} {mu} {reference} {n}: {have} {want}"
            );
            compared += 1;
        }
    }
    assert_eq!(compared, 120);
}

/// t^p at these times, whose D^μ is Γ(p + 1)/Γ(p + 1 − μ)·t^(p − μ): the rms of the relative error of the later half.
fn error(times: &[f64], p: f64, mu: f64) -> f64 {
    let x: Vec<f64> = times.iter().map(|t| t.powf(p)).collect();
    let have = uneven(order(mu), times, &x, 0.0).expect("valid");
    let factor = libm::tgamma(p + 1.0) / libm::tgamma(p + 1.0 - mu);
    let rows = std::iter::zip(times, &have).skip(times.len() / 2);
    let off = rows.map(|(t, y)| (y / (factor * t.powf(p - mu)) - 1.0).powi(2));
    (off.sum::<f64>() / times.len() as f64).sqrt()
}

#[test]
fn powers_of_time_are_approached_as_lines_approach_them() {
    // From 1e-6 to 1e3, and about even steps with a jitter of a third.
    let geometric = |count: u32| -> Vec<f64> {
        let at = |n| 1e-6 * 10_f64.powf(9.0 * f64::from(n) / f64::from(count));
        std::iter::once(0.0).chain((0..=count).map(at)).collect()
    };
    let jittered = |count: u32| -> Vec<f64> {
        let jitter = |n: u32| f64::from((n * 7919) % 101) / 303.0;
        let at = |n: u32| (f64::from(n) + if n == 0 { 0.0 } else { jitter(n) }) / f64::from(count);
        (0..=count).map(at).collect()
    };
    let ways: [&dyn Fn(u32) -> Vec<f64>; 2] = [&geometric, &jittered];
    for times in ways {
        for (p, mu) in [(1.0, 0.5), (1.5, 0.5), (2.0, -0.7), (2.5, 0.3), (1.2, -1.5)] {
            let [coarse, fine] = [400, 1600].map(|count| error(&times(count), p, mu));
            assert!(coarse < 0.03, "{p} {mu}: {coarse:e}");
            // Of order 2 − μ for μ > 0, and 2 below; 4^1.5 is 8, and the jitter is drawn anew.
            assert!(
                fine < coarse / 5.5 || coarse < 1e-12,
                "{p} {mu}: {coarse:e} {fine:e}"
            );
        }
    }
}
