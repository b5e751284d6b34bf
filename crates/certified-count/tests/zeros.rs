//! Both walks against products of factors whose zeros are known.

use certified_count::num_complex::Complex;
use certified_count::{
    Bounds, Curve, Enclosed, Jet, LoopTerms, NodeValue, OpenLoop, Peak, Place, count, is_clear,
};
use std::cell::Cell;

/// `Π(1 − c_k w)` with its zeros at `1/c_k`.
struct Factors(Vec<f64>);

impl Factors {
    fn value(&self, w: Complex<f64>) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        self.0.iter().fold(one, |value, c| value * (1.0 - w * c))
    }

    fn in_arcs(&self) -> Option<usize> {
        let found = count(|arc| {
            let one = Enclosed::new(Complex::new(1.0, 0.0), 0.0, arc);
            let factors = self.0.iter();
            factors.fold(one, |value, c| {
                value.times(Enclosed::new(1.0 - arc.w * c, c.abs(), arc))
            })
        });
        found.unstable_poles
    }

    fn between_samples(&self) -> Option<usize> {
        let (begin, end) = (Place::new(0.0), Place::new(core::f64::consts::PI));
        let whole = self.span(&begin, &end);
        Curve::count(self, &begin, 0.0, [(&whole, &end)]).unstable_poles
    }
}

impl Curve for Factors {
    type Node = Place;
    type Span = f64;

    fn node(&self, theta: f64) -> Place {
        Place::new(theta)
    }

    fn span(&self, a: &Place, b: &Place) -> f64 {
        let most: f64 = self.0.iter().map(|c| 1.0 + c.abs()).product();
        let rate: f64 = self.0.iter().map(|c| c.abs() / (1.0 + c.abs())).sum();
        most * rate * (b.theta - a.theta)
    }

    fn sample(&self, node: &Place) -> NodeValue {
        let value = self.value(node.w);
        NodeValue {
            theta: node.theta,
            value,
            size: value.norm(),
            noise: 1e-13,
        }
    }

    fn path(&self, _: &Place, _: &Place, length: &f64) -> f64 {
        *length
    }
}

#[test]
fn both_walks_find_the_zeros_that_are_there() {
    for (factors, zeros) in [
        (vec![], Some(0)),
        (vec![0.99], Some(0)),
        (vec![1.01], Some(1)),
        (vec![-3.0, 2.0, 0.5, -0.2], Some(2)),
        (vec![1.5, 1.5, -1.5, -1.5, 0.9], Some(4)),
        // On the circle.
        (vec![0.5, -1.0], None),
    ] {
        let polynomial = Factors(factors);
        assert_eq!(polynomial.in_arcs(), zeros, "{:?}", polynomial.0);
        assert_eq!(polynomial.between_samples(), zeros, "{:?}", polynomial.0);
    }
}

/// 1 − kw has its zero inside from k = 1 on.
#[test]
fn an_interval_is_clear_unless_a_zero_meets_the_circle() {
    let clear = |gains| {
        is_clear(
            |arc| {
                let one = Enclosed::new(Complex::new(1.0, 0.0), 0.0, arc);
                (one, Enclosed::new(-arc.w, 1.0, arc))
            },
            gains,
        )
    };
    assert!(clear([0.1, 0.9]) && clear([1.1, 5.0]));
    assert!(!clear([0.5, 1.5]) && !clear([1.0, 2.0]));
}

/// A loop that is no number anywhere, and how often it was asked.
struct Nowhere(Cell<u32>);

impl OpenLoop for Nowhere {
    type Node = ();

    fn terms(&self, theta: f64) -> LoopTerms<()> {
        self.0.set(self.0.get() + 1);
        let nothing = Jet::ONE.over(Jet::ONE.plus(Jet::new((-1.0).into(), 0.0.into())));
        let parts = [Jet::ONE, nothing];
        LoopTerms {
            theta,
            parts,
            node: (),
        }
    }

    fn bounds(&self, _: &LoopTerms<()>, _: &LoopTerms<()>) -> [Bounds; 2] {
        [Bounds::ONE; 2]
    }

    fn least(&self) -> f64 {
        1e-8
    }

    fn angles(&self) -> Vec<f64> {
        vec![1e-8, 1e-3, 1.0]
    }

    fn ends(&self) -> Vec<f64> {
        Vec::new()
    }

    fn narrow(&self, theta: f64) -> f64 {
        1e-6 * theta
    }

    fn noise(&self) -> f64 {
        0.0
    }
}

#[test]
fn a_peak_is_not_looked_for_where_a_loop_is_no_number() {
    let nowhere = Nowhere(Cell::new(0));
    assert!(nowhere.peak(Peak::Sensitivity, 1e-3).value <= 0.0);
    assert_eq!(nowhere.0.get(), 3);
}
