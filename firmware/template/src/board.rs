//! Sensor and actuator. As it is: a position that never changes, and no motor.

use haptic_board::haptic_link::Capabilities;
use haptic_board::haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_board::haptic_remote::{Hardware, abilities};
use haptic_board::nalgebra::Vector1;

/// TODO: the name that the host sees, 16 bytes at most.
pub(crate) const NAME: &str = "my-board";

/// TODO: position of a count of your sensor, m. A wheel of 5 mm with 2000 counts a turn: 2π · 5 mm / 2000.
const METRES_PER_COUNT: f32 = 1.570_796_3e-5;
/// TODO: the largest force that your actuator can make, N.
const FORCE_MAX_N: f32 = 2.0;
/// TODO: its largest change, N/s.
const FORCE_RATE_MAX_N_PER_S: f32 = 4000.0;

/// Disables the motor by its register, whoever has the pin: [`let_go`](Device::let_go) and the end after a panic both come here.
pub(crate) fn disable_motor() {
    // TODO: the enable pin of your amplifier, as `disable_motor` of `firmware/examples/rp2040/src/axis.rs` has it. 10 kΩ to ground keep it
    // low while the chip is in reset.
}

/// One axis.
#[derive(Debug)]
pub(crate) struct Board {
    // TODO: your pins, for instance
    // encoder: Qei<TIM2>,
    // command: PwmChannel<TIM1, 0>,
    // enable: PC8<Output>,
    now_us: fn() -> u64,
    tick: u64,
}

impl Board {
    /// Board at power-up. TODO: takes the pins, the motor disabled.
    pub(crate) fn new(now_us: fn() -> u64) -> Self {
        Self { now_us, tick: 0 }
    }
}

impl Device<f32, 1> for Board {
    type Error = Fault;

    /// Once a tick, first thing. A fault that you find here (emergency stop, encoder) latches, and the board lets go at once.
    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        // TODO: the count of your sensor, such as
        // let count = self.encoder.count() as i32;
        let count = 0_i32;
        let tick = self.tick;
        self.tick += 1;
        Ok(Reading {
            tick,
            time_s: (self.now_us)() as f64 * 1e-6,
            position_m: Vector1::new(count as f32 * METRES_PER_COUNT),
        })
    }

    /// Once a tick, with the force that the safety chain has let through. Only here the motor is enabled.
    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let share = force.newtons()[0] / FORCE_MAX_N; // −1 to 1
        // TODO: to your amplifier, such as
        // self.command.set_duty(to_duty(share));
        // self.enable.set_high();
        let _ = share;
        Ok(())
    }

    /// No force, whatever was written last: called after every error, too.
    fn let_go(&mut self) {
        disable_motor();
        // TODO: and no command, such as
        // self.command.set_duty(to_duty(0.0));
    }
}

impl Hardware for Board {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: FORCE_MAX_N,
            force_rate_max_n_per_s: FORCE_RATE_MAX_N_PER_S,
            position_resolution_m: METRES_PER_COUNT,
            ..abilities(NAME, 1)
        }
    }

    // TODO: the unique number of your chip or its flash, under which a host keeps the limits of this board, such as
    // fn serial_number(&self) -> SerialNumber {
    //     SerialNumber::of_chip(&chip::unique_number())
    // }

    fn install(&mut self, (): (), _: u32) {}

    /// A run begins.
    fn restart(&mut self) {
        self.tick = 0;
    }

    /// A tick in which no force may act.
    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.let_go();
        self.read()
    }

    // TODO: with a force sensor, N, positive along the position; its range goes into `sensed_force_max_n` above. Latch it in `read`:
    // fn sense(&mut self) -> [f32; 1] {
    //     [self.latched_count as f32 * NEWTONS_PER_COUNT]
    // }

    // TODO: with an emergency stop, so that nobody arms while it is open; and with an encoder that can lose counts, as nobody may arm
    // again before its zero is known, which is after the next start:
    // fn persisting_fault(&self) -> Option<Fault> {
    //     let stopped = self.stop.is_high().then_some(Fault::EmergencyStop);
    //     self.encoder.lost().or(stopped)
    // }
}
