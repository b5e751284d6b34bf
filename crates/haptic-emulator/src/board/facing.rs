//! Two emulated boards whose masses meet, each behind a line of its own.
//!
//! Both are ticked by one thread from one clock, in the order of their times, and the world between two ticks is that of [`FacingDevices`],
//! exact: so what they do depends on no load of this machine. Each has the sample time of its own run.
//!
//! - *They are no simulations* to a host: like real boards they refuse a configuration that asks for a plant.
//! - *Idle*, a mass is free: no force, and it moves on. *Start of a run*: both masses go back to their 0 if the other board makes no force;
//!   while it does, nothing moves.

use super::{Body, Embodied, Emulated, Emulation, EmulatorError, TickTime, Touched, run};
use haptic_link::{Capabilities, ControllerCost};
use haptic_loop::{
    Device, Fault, Reading, SafeForce,
    nalgebra::SVector,
    plant::{
        FacingConfig, FacingContact, FacingDevices, FacingSide, ForceSensorConfig, MassDamperConfig,
    },
    units::{Kilograms, NewtonSecondsPerMetre, Seconds},
};
use haptic_remote::{CONTROLLER_COST, Hardware, abilities, serial::Line};
use std::{cell::RefCell, rc::Rc, sync::atomic::AtomicBool};

/// Units of the world in a microsecond: it counts nanoseconds.
const PER_MICROSECOND: u64 = 1000;

/// Runs a renderer and an indenter, see [`FacingSide`], until they are stopped or the time of the first is over. The speed of the first
/// is that of both. Each has one axis, whatever its emulation says; one without a body is a voice coil of 65 g and 3.5 N·s/m.
///
/// # Errors
/// Faults, a body or a contact outside their range; a line that cannot be shared.
pub fn emulate_facing(
    lines: [Box<dyn Line>; 2],
    emulations: &[Emulation; 2],
    contact: FacingContact,
    stop: &AtomicBool,
) -> Result<[Emulated; 2], EmulatorError> {
    let now = TickTime::default();
    let bodies = emulations.each_ref().map(|emulation| emulation.body);
    let sensors = emulations.each_ref().map(|emulation| emulation.sensor);
    let [blue, white] = facing(bodies, sensors, contact, &now)?;
    let ([first, second], [of_first, of_second]) = (lines, emulations);
    run(
        [(first, of_first, blue), (second, of_second, white)],
        &now,
        stop,
    )
}

const VOICE_COIL: MassDamperConfig =
    MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(0.0));

/// Both boards of a world, which moves on to the time of each tick.
fn facing(
    bodies: [Option<Body>; 2],
    sensors: [Option<ForceSensorConfig>; 2],
    contact: FacingContact,
    now: &TickTime,
) -> Result<[Embodied<FacingBoard, 1>; 2], EmulatorError> {
    let unit = Seconds(1e-6 / PER_MICROSECOND as f64);
    let config = FacingConfig {
        devices: bodies.map(|body| body.map_or(VOICE_COIL, |body| body.plant)),
        contact,
    };
    let world = Rc::new(RefCell::new(World {
        devices: FacingDevices::new(config, unit)?,
        forced: [false; 2],
    }));
    let board = |side: FacingSide| {
        let board = FacingBoard {
            world: Rc::clone(&world),
            side,
            now: Rc::clone(now),
        };
        Embodied::new(board, bodies[side as usize], sensors[side as usize])
    };
    Ok([board(FacingSide::Renderer)?, board(FacingSide::Indenter)?])
}

/// Shared by both boards, whose ticks take turns.
struct World {
    devices: FacingDevices,
    /// Boards that make a force.
    forced: [bool; 2],
}

struct FacingBoard {
    world: Rc<RefCell<World>>,
    side: FacingSide,
    now: TickTime,
}

impl Touched<1> for FacingBoard {
    /// Both axes point the same way: the contact pushes one mass along its own, the other against it.
    fn touched(&self) -> [f64; 1] {
        let force_n = self.world.borrow().devices.contact_force();
        match self.side {
            FacingSide::Renderer => [force_n],
            FacingSide::Indenter => [0.0 - force_n],
        }
    }
}

impl Device<f32, 1> for FacingBoard {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let now_us = self.now.get();
        let devices = &mut self.world.borrow_mut().devices;
        devices.advance_to(PER_MICROSECOND * now_us);
        Ok(Reading {
            tick: 0,
            time_s: 1e-6 * now_us as f64,
            position_m: SVector::from([devices.position(self.side) as f32]),
        })
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let mut world = self.world.borrow_mut();
        world.forced[self.side as usize] = true;
        let force = f64::from(force.newtons()[0]);
        world.devices.command(self.side, force);
        Ok(())
    }

    fn let_go(&mut self) {
        let mut world = self.world.borrow_mut();
        world.forced[self.side as usize] = false;
        world.devices.let_go(self.side);
    }
}

impl Hardware for FacingBoard {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            // More than desktop devices can do; nothing here would break.
            force_max_n: 100.0,
            force_rate_max_n_per_s: 1e6,
            ..abilities("emulated", 1)
        }
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        Some(CONTROLLER_COST)
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        let mut world = self.world.borrow_mut();
        if !world.forced[1 - self.side as usize] {
            world.devices.restart();
        }
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.let_go();
        self.read()
    }
}

#[cfg(test)]
mod tests;
