//! A board whose sensor fails in the middle of a run.

use crate::line::START;
use haptic_link::{Capabilities, Refusal, Simulation, State};
use haptic_loop::remote::{Hardware, SimulatedPlant, TickSide};
use haptic_loop::{Device, Fault, Reading, SafeForce};

/// A simulated board that can be broken, and that remembers the last force.
struct Broken {
    plant: SimulatedPlant,
    broken: bool,
    force_n: f32,
}

impl Device<f32, 1> for Broken {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        if self.broken {
            return Err(Fault::EmergencyStop);
        }
        self.plant.read()
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.force_n = force.newtons()[0];
        self.plant.write(force)
    }
}

impl Hardware for Broken {
    type Setup = <SimulatedPlant as Hardware>::Setup;

    fn capabilities(&self) -> Capabilities {
        self.plant.capabilities()
    }

    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self::Setup, Refusal> {
        SimulatedPlant::prepare(simulation, tick_period_us)
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.plant.install(setup, tick_period_us);
    }

    fn restart(&mut self) {
        self.plant.restart();
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.force_n = 0.0;
        self.read()
    }

    fn let_go(&mut self) {
        self.force_n = 0.0;
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.broken.then_some(Fault::EmergencyStop)
    }
}

#[test]
fn a_board_that_cannot_measure_lets_go_at_once_and_can_be_armed_when_it_is_mended() {
    let board = Broken {
        plant: SimulatedPlant::new("broken", || 0),
        broken: false,
        force_n: 0.0,
    };
    let mut device = TickSide::new(board).expect("works");
    let (configuration, values) = crate::line::spring();
    let capabilities = device.hardware().capabilities();
    let prepared = haptic_loop::remote::prepare::<Broken>(configuration, &values, &capabilities);
    device.install(prepared.expect("good")).expect("idle");
    device.arm(0).expect("idle");
    device.start(START).expect("armed");
    let mut now_us = 0;
    let mut tick = |device: &mut TickSide<Broken>| {
        now_us += 1000;
        device.heard(now_us, true);
        device.tick(now_us);
    };
    for _ in 0..100 {
        tick(&mut device);
    }
    assert!(device.hardware().force_n < -0.5);
    device.hardware_mut().broken = true;
    tick(&mut device);
    assert_eq!(device.hardware().force_n, 0.0);
    assert_eq!(device.status().state, State::Fault);
    assert_eq!(device.status().fault, Fault::EmergencyStop.code());
    tick(&mut device);
    let persists = Refusal::FaultPersists(Fault::EmergencyStop.code());
    assert_eq!(device.arm(1), Err(persists));
    device.hardware_mut().broken = false;
    tick(&mut device);
    device.arm(1).expect("mended");
    assert_eq!(device.status().state, State::Armed);
}
