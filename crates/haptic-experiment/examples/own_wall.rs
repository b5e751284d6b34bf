//! A wall of one's own law on a plant of one's own, tried and judged as every wall is.
//!
//! ```text
//! cargo run -p haptic-experiment --example own_wall
//! ```

use fracdiff::Seconds;
use haptic_experiment::{Line, TrialPlan, lines};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, Device, Environment, Reading, SafeForce, SafetyChain};
use nalgebra::Vector1;
use std::convert::Infallible;

const T: f64 = 1e-3;
const STIFFNESS: f64 = 500.0;

/// f = −K·x − B·(x − x of the tick before)/T
struct OwnWall;

impl Environment<f64, 1> for OwnWall {
    type History = Vector1<f64>;

    fn at_rest(&self) -> Vector1<f64> {
        Vector1::zeros()
    }

    fn force(&self, before: &Vector1<f64>, x: &Vector1<f64>) -> Vector1<f64> {
        -STIFFNESS * x - 2.0 / T * (x - before)
    }

    fn advance(&self, before: &mut Vector1<f64>, x: &Vector1<f64>) {
        *before = *x;
    }
}

/// 80 g on 4 N·s/m that hit the wall with 0.1 m/s and are pushed with 1 N.
struct OwnPlant {
    tick: u64,
    position_m: f64,
    speed_m_per_s: f64,
}

impl Device<f64, 1> for OwnPlant {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * T,
            position_m: Vector1::new(self.position_m),
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        let total_n = 1.0 + force.newtons()[0] - 4.0 * self.speed_m_per_s;
        self.speed_m_per_s += total_n / 0.08 * T;
        self.position_m += self.speed_m_per_s * T;
        self.tick += 1;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e5), Seconds(T))?;
    let mut plant = OwnPlant {
        tick: 0,
        position_m: 0.0,
        speed_m_per_s: 0.1,
    };
    let settling = TrialPlan::DEFAULT.try_law(
        &mut Controller::new(OwnWall, chain),
        &mut plant,
        Seconds(T),
        STIFFNESS,
    )?;
    for line in lines(&settling) {
        if let Line::Row(row) = line {
            println!("{}: {}", row.label, row.value);
        }
    }
    assert!(settling.stable);
    Ok(())
}
