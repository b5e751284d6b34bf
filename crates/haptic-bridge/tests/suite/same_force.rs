//! The force of a bridge, bit for bit that of the same law and chain in a loop of this process.

use crate::bench::{Bench, TICK_US, description, wall};
use fracdiff::portable::Form;
use haptic_link::DeviceReport;
use haptic_loop::{
    Controller, Device, Reading, SafeForce, SafetyChain, Wall,
    units::{Newtons, NewtonsPerSecond, Seconds},
};
use haptic_remote::DeviceOperator;
use nalgebra::SVector;
use std::convert::Infallible;

/// A device whose hand does as it is told.
struct Led {
    position_m: SVector<f32, 1>,
    force_n: SVector<f32, 1>,
}

impl Device<f32, 1> for Led {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f32, 1>, Infallible> {
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: self.position_m,
        })
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Infallible> {
        self.force_n = *force.newtons();
        Ok(())
    }
}

#[test]
fn full_memory_pushes_as_in_a_loop_of_ones_own_and_samples_tell_it() {
    let mut bench = Bench::armed(&description(3));
    bench.position_m = [0.0; 3];
    bench.done(haptic_link::Request::Start(haptic_link::Start::ENDLESS));
    // From here on no limiter acts: the force has risen, and stays small.
    bench.steps(1000);
    bench.reports.clear();
    let (configuration, values) = wall();
    let operator = DeviceOperator::new(Form::Modes, configuration.operator.integer, &values);
    let law = Wall::new(100.0, 2.0, operator.expect("good"), None).expect("good");
    let chain = SafetyChain::<f32>::new(Newtons(3.0), NewtonsPerSecond(1000.0), Seconds(1e-3));
    let controller = Controller::<f32, 1, _>::new(law, chain.expect("good"));
    let mut engaged = controller.into_engaged(Led {
        position_m: SVector::zeros(),
        force_n: SVector::zeros(),
    });
    for _ in 0..1000 {
        let Ok(_) = engaged.tick();
    }
    let mut wanted = Vec::new();
    for tick in 0..3000_u32 {
        let time = f64::from(tick) * 1e-3;
        let lift = |rate: f64| 0.002 * (1.0 - (rate * time).cos());
        bench.position_m = [lift(7.0), lift(11.0), -lift(3.0)];
        engaged.device_mut().position_m = SVector::from([bench.position_m[0] as f32]);
        let Ok(_) = engaged.tick();
        bench.step();
        let mine = engaged.device().force_n[0];
        wanted.push(mine);
        // Without a surface the law acts along the first axis.
        let same = [f64::from(mine), 0.0, 0.0];
        assert_eq!(bench.force_n, same, "tick {tick}");
    }
    assert!(wanted.iter().any(|force| force.abs() > 0.3));
    // The host has each of them.
    for _ in 0..20 {
        bench.time_us += TICK_US;
        bench.step();
    }
    let samples = bench.reports.iter().filter_map(|report| {
        if let DeviceReport::Sample(sample) = report {
            Some(sample)
        } else {
            None
        }
    });
    let sent: Vec<f32> = samples.map(|sample| sample.axes[0].force_n).collect();
    let first = sent
        .iter()
        .position(|force| force.to_bits() == wanted[1].to_bits())
        .expect("told");
    assert_eq!(sent[first..first + 2000], wanted[1..2001]);
    assert_eq!(bench.allocations, 0);
}
