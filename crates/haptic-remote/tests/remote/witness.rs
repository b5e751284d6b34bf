//! A simulated board that remembers what force acts on its plant.

use haptic_link::{Capabilities, ControllerCost};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{Hardware, SimulatedPlant};

/// The simulated board, watched from outside the device's own code.
#[derive(Debug)]
pub(crate) struct Witness {
    plant: SimulatedPlant,
    force_n: f32,
    /// The sensor gives nothing while this is set.
    pub(crate) broken: bool,
    /// The actuator takes nothing while this is set.
    pub(crate) stuck: bool,
    /// It is off by this, m.
    pub(crate) offset_m: f32,
    /// It tells what it told last while this is set.
    pub(crate) sticks: bool,
    told_m: f32,
    /// Reading of its force sensor at tick 0, N, from where it rises by 1 N a tick; NaN without one.
    pub(crate) sensed_n: f32,
    ticks: u32,
    /// The time that a controller takes.
    pub(crate) controller_cost: Option<ControllerCost>,
}

impl Witness {
    pub(crate) fn new(board: &str) -> Self {
        Self {
            plant: SimulatedPlant::new(board, || 0),
            force_n: 0.0,
            broken: false,
            stuck: false,
            offset_m: 0.0,
            sticks: false,
            told_m: 0.0,
            sensed_n: f32::NAN,
            ticks: 0,
            controller_cost: Some(ControllerCost {
                tick_us: 200,
                coefficient_ns: 3_500,
            }),
        }
    }

    /// The force on the plant since the last tick, N.
    pub(crate) fn force_n(&self) -> f32 {
        self.force_n
    }
}

impl Device<f32, 1> for Witness {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        if self.broken {
            return Err(Fault::EmergencyStop);
        }
        let mut reading = self.plant.read()?;
        self.ticks += 1;
        if !self.sticks {
            self.told_m = reading.position_m[0] + self.offset_m;
        }
        reading.position_m[0] = self.told_m;
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        if self.stuck {
            return Err(Fault::CurrentMismatch);
        }
        self.force_n = force.newtons()[0];
        self.plant.write(force)
    }

    fn let_go(&mut self) {
        self.force_n = 0.0;
    }
}

impl Hardware for Witness {
    type Setup = <SimulatedPlant as Hardware>::Setup;

    fn capabilities(&self) -> Capabilities {
        self.plant.capabilities()
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        self.controller_cost
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.plant.install(setup, tick_period_us);
    }

    fn sense(&mut self) -> [f32; 1] {
        [self.sensed_n + (self.ticks - 1) as f32]
    }

    fn restart(&mut self) {
        self.ticks = 0;
        self.plant.restart();
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.force_n = 0.0;
        self.read()
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.broken.then_some(Fault::EmergencyStop)
    }
}
