//! The 2DIY with one axis: a line of its plane.

use super::kinematics::Posture;
use super::model::Model;
use super::name::HaplyName;
use super::planar::Planar;
use super::plausible::Trouble;
use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{Line, ServedHardware};
use haptic_remote::{COEFFICIENTS_MAX, DEGREE_MAX, FLIGHT_SAMPLES, Hardware, MODES_MAX};
use nalgebra::{SVector, Vector2};

/// Largest force along a line, N: both motors make it wherever 40 mm < y < 130 mm and the handle is within 50 mm of the middle.
pub const FORCE_MAX_N: f32 = 1.5;
/// A 2DIY that moves and pushes along one line of its plane; across it there is no force.
#[derive(Debug)]
pub struct Haply2Diy<L: Line> {
    planar: Planar<L>,
    /// Unit vector along the line.
    along: Vector2<f64>,
    /// Place of the line that is zero, m.
    zero: Vector2<f64>,
    /// The last place along the line, m.
    position_m: f32,
    /// Words of the last trouble were told as a fault.
    told: bool,
}

impl<L: Line> Haply2Diy<L> {
    /// A device that has answered.
    pub(super) fn new(line: L, model: Model, posture: Posture, name: &HaplyName) -> Self {
        let along = name.axis.along();
        // The line goes through the middle between the arms.
        let middle = Vector2::new(0.5 * model.pantograph.base_m(), 0.0);
        let mut this = Self {
            planar: Planar::new(line, model, posture),
            along,
            zero: middle + name.axis.across_and_along(name.zero_m),
            position_m: 0.0,
            told: false,
        };
        this.position_m = this.place(&posture);
        this
    }

    /// The same device with both axes.
    #[must_use]
    pub const fn planar(&self) -> &Planar<L> {
        &self.planar
    }

    fn place(&self, posture: &Posture) -> f32 {
        (posture.hand_m - self.zero).dot(&self.along) as f32
    }

    fn reading(&self) -> Reading<f32, 1> {
        Reading {
            tick: 0,
            time_s: 0.0,
            position_m: SVector::from([self.position_m]),
        }
    }

    /// A board that fails says so once: then the loop lets go, and looks on.
    fn once(&mut self, trouble: Trouble) -> Result<(), Fault> {
        if core::mem::replace(&mut self.told, true) {
            return Ok(());
        }
        Err(trouble.fault())
    }
}

impl<L: Line> Device<f32, 1> for Haply2Diy<L> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        match self.planar.measure() {
            Ok(posture) => {
                let posture = *posture;
                self.position_m = self.place(&posture);
            }
            Err(trouble) => self.once(trouble)?,
        }
        Ok(self.reading())
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let force_n = self.along * f64::from(force.newtons()[0]);
        match self.planar.push(force_n) {
            Ok(()) => Ok(()),
            Err(trouble) => self.once(trouble),
        }
    }
}

impl<L: Line> Hardware for Haply2Diy<L> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        let board = match self.planar.model().version.number() {
            2 => "Haply 2DIY v2",
            _ => "Haply 2DIY v3",
        };
        Capabilities {
            board: Capabilities::board_name(board),
            axes: 1,
            simulated: false,
            // The board looks for a frame each 50 µs; a USB port of full speed moves bytes each millisecond.
            tick_period_min_us: 500,
            tick_period_max_us: 10_000,
            force_max_n: FORCE_MAX_N,
            // From one end to the other in a tick.
            force_rate_max_n_per_s: 2000.0 * FORCE_MAX_N,
            position_resolution_m: self.planar.model().resolution_m(),
            coefficients_max: COEFFICIENTS_MAX as u16,
            modes_max: MODES_MAX as u16,
            degree_max: DEGREE_MAX as u16,
            flight_samples: FLIGHT_SAMPLES as u16,
        }
    }

    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        match simulation.kind {
            SimulationKind::Real => Ok(()),
            _ => Err(Refusal::Unsupported(Field::SimulationKind)),
        }
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.planar.ticks_every(1e-6 * f64::from(tick_period_us));
    }

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let reading = self.read()?;
        if self.planar.trouble().is_none()
            && let Err(trouble) = self.planar.push(Vector2::zeros())
        {
            self.once(trouble)?;
        }
        Ok(reading)
    }

    fn let_go(&mut self) {
        self.planar.let_go();
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.planar.trouble().map(Trouble::fault)
    }
}

impl<L: Line + 'static> ServedHardware for Haply2Diy<L> {
    fn trouble(&self) -> Option<String> {
        let trouble = self.planar.trouble()?;
        Some(format!(
            "the 2DIY was told to let go and was reset: {trouble}. The next command looks for the handle at its home again"
        ))
    }
}
