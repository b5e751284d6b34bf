//! An environment of one's own: a spring that stiffens, with a fractional damper, on two axes.
//!
//! ```text
//! f = −(K·x + C·x³) − B·D^μ x
//! cargo run -p haptic-loop --example own_environment
//! ```

use fracdiff::{Differintegrator, Order, Real, Seconds, ShortMemory};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, Environment, SafetyChain};
use nalgebra::{SVector, vector};
use std::error::Error;

struct Stiffening<F, O> {
    /// K, N/m.
    stiffness: F,
    hardening: F,
    /// B, N·s^μ/m.
    dissipation: F,
    operator: O,
}

impl<F: Real, O: Differintegrator<F>, const D: usize> Environment<F, D> for Stiffening<F, O> {
    // The operator is immutable; each axis has a history of its own.
    type History = [O::History; D];

    fn at_rest(&self) -> Self::History {
        std::array::from_fn(|_| self.operator.at_rest())
    }

    // Between sensor and force: no more than this.
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        SVector::from(std::array::from_fn(|axis| {
            let x = position_m[axis];
            let spring = self.stiffness * x + self.hardening * x * x * x;
            -(spring + self.dissipation * self.operator.output(&history[axis], x))
        }))
    }

    // After the force has been sent.
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        for (history, &x) in history.iter_mut().zip(position_m) {
            self.operator.advance(history, x);
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let t = Seconds(1e-3);
    let environment = Stiffening {
        stiffness: 100.0,
        hardening: 5e6,
        dissipation: 3.0,
        operator: ShortMemory::<f64, 256>::new(Order::new(0.7)?, t)?,
    };
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e4), t)?;
    let mut controller = Controller::<f64, 2, _>::new(environment, chain);
    let testbed = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), t);
    let mut device = MassDamper::<2>::new(testbed)?;
    device.set_external_force(vector![1.0, 0.25]);
    let mut engaged = controller.engage(device);
    for _ in 0..5000 {
        let Ok(_) = engaged.tick();
    }
    let rest = engaged.device().position();
    println!(
        "at rest at {:.2} mm and {:.2} mm",
        1e3 * rest[0],
        1e3 * rest[1]
    );
    for (x, push) in rest.iter().zip([1.0, 0.25]) {
        let spring = 100.0 * x + 5e6 * x * x * x;
        assert!(
            (spring - push).abs() < 0.05 * push,
            "{spring} N of {push} N"
        );
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
