//! What the tests share: impulse responses and golden values, beside the words of `testkit`.

use fractional_control::{FractionalTransferFunction, num_complex::Complex};
pub(crate) use testkit::control::*;

/// `Σ h[j]·e^(−iθj)` of an impulse response.
pub(crate) fn of_impulse_response(weights: &[f64], theta: f64) -> Complex<f64> {
    let terms = weights.iter().enumerate();
    terms
        .map(|(j, h)| Complex::from_polar(*h, -theta * j as f64))
        .sum()
}

/// A function and its step response at some times.
#[derive(Debug)]
pub(crate) struct Golden {
    pub(crate) function: FractionalTransferFunction,
    pub(crate) points: Vec<(f64, f64)>,
}

pub(crate) fn read(text: &str) -> Vec<Golden> {
    let mut all: Vec<(String, Golden)> = Vec::new();
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [name, t, y] = fields[..] else {
            panic!("three fields: {line}");
        };
        let point = (t.parse().expect("a time"), y.parse().expect("a value"));
        match all.last_mut() {
            Some((last, golden)) if last == name => golden.points.push(point),
            _ => {
                let function = name.parse().expect("a transfer function");
                let points = vec![point];
                all.push((name.to_owned(), Golden { function, points }));
            }
        }
    }
    all.into_iter().map(|(_, golden)| golden).collect()
}

pub(crate) fn podlubny() -> [Golden; 2] {
    read(include_str!("../golden/podlubny.csv"))
        .try_into()
        .expect("two functions")
}

pub(crate) fn randoms() -> Vec<Golden> {
    read(include_str!("../golden/random.csv"))
}
