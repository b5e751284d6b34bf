//! Hardware that pushes with no force that is too old.

use crate::{Exchange, Hardware};
use haptic_link::{Capabilities, Refusal, Simulation};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use std::time::Instant;

/// Hardware behind a deadline. This process may be stopped in the middle of a tick, for as long as somebody likes: a force that was
/// computed before that belongs to a place of then, and does not go out. The tick fails instead, and the hardware lets go.
#[derive(Debug)]
pub(super) struct Punctual<H> {
    pub(super) hardware: H,
    /// None for hardware in its own time, which nothing holds up.
    latest: Option<Instant>,
}

impl<H> Punctual<H> {
    pub(super) const fn new(hardware: H) -> Self {
        Self {
            hardware,
            latest: None,
        }
    }

    /// Later than this the force of the next tick does not go out.
    pub(super) const fn at_latest(&mut self, latest: Instant) {
        self.latest = Some(latest);
    }
}

impl<H: Hardware<D>, const D: usize> Device<f32, D> for Punctual<H> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.hardware.read()
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let pushes = force.newtons().iter().any(|&axis| axis != 0.0);
        if pushes && self.latest.is_some_and(|latest| Instant::now() > latest) {
            return Err(Fault::HostSilent);
        }
        self.hardware.write(force)
    }

    fn let_go(&mut self) {
        self.hardware.let_go();
    }
}

impl<H: Hardware<D>, const D: usize> Hardware<D> for Punctual<H> {
    type Setup = H::Setup;

    fn capabilities(&self) -> Capabilities {
        self.hardware.capabilities()
    }

    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self::Setup, Refusal> {
        H::prepare(simulation, tick_period_us)
    }

    fn fit(&self, setup: &mut Self::Setup) -> Result<(), Refusal> {
        self.hardware.fit(setup)
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.hardware.install(setup, tick_period_us);
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        self.hardware.exchange()
    }

    fn restart(&mut self) {
        self.hardware.restart();
    }

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.hardware.idle()
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.hardware.persisting_fault()
    }

    fn cycles(&self) -> u32 {
        self.hardware.cycles()
    }
}
