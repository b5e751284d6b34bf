//! The 2DIY behind the device's side of the link: with one axis, a line of its plane, or with both.

use super::kinematics::Posture;
use super::model::Model;
use super::name::HaplyName;
use super::planar::Planar;
use super::plane::{Plane, middle};
use super::plausible::Trouble;
use crate::foreign::{is_real, served_host};
use haptic_link::{Capabilities, Refusal, Simulation};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{BoardTrouble, Line, ServedHardware, TroubleCause};
use haptic_remote::{Exchange, Hardware};
use nalgebra::{SMatrix, SVector, Vector2};

/// Largest force along a line, N: both motors make it wherever 40 mm < y < 130 mm and the handle is within 50 mm of the middle.
pub const FORCE_MAX_N: f32 = 1.5;

/// A 2DIY that moves and pushes along D lines of its plane: one unless said, across which there is no force, or both axes.
#[derive(Debug)]
pub struct Haply2Diy<L: Line, const D: usize = 1> {
    planar: Planar<L>,
    /// Unit vectors along the lines.
    along: SMatrix<f64, 2, D>,
    /// Place of the plane that is zero, m.
    zero: Vector2<f64>,
    /// The last place along the lines, m.
    position_m: SVector<f32, D>,
    /// A board in trouble was told once more to let go.
    told: bool,
}

impl<L: Line> Haply2Diy<L> {
    /// A device of one axis that has answered.
    pub(super) fn new(line: L, model: Model, posture: Posture, name: &HaplyName) -> Self {
        let zero = middle(&model) + name.axis.across_and_along(name.zero_m);
        let along = SMatrix::from_columns(&[name.axis.along()]);
        Self::along(Planar::new(line, model, posture), along, zero)
    }
}

impl<L: Line> Haply2Diy<L, 2> {
    /// A device of both axes that has answered: x to the right and y away from the base, from the middle of the workspace.
    pub(super) fn with_both(line: L, model: Model, posture: Posture) -> Self {
        let zero = Plane::of(model).centre();
        Self::along(Planar::new(line, model, posture), SMatrix::identity(), zero)
    }
}

impl<L: Line, const D: usize> Haply2Diy<L, D> {
    fn along(planar: Planar<L>, along: SMatrix<f64, 2, D>, zero: Vector2<f64>) -> Self {
        let mut this = Self {
            planar,
            along,
            zero,
            position_m: SVector::zeros(),
            told: false,
        };
        this.position_m = this.place(this.planar.posture());
        this
    }

    /// Both arms, motors and encoders.
    #[must_use]
    pub const fn planar(&self) -> &Planar<L> {
        &self.planar
    }

    fn place(&self, posture: &Posture) -> SVector<f32, D> {
        let place = self.along.transpose() * (posture.hand_m - self.zero);
        place.map(|axis| axis as f32)
    }

    fn reading(&self) -> Reading<f32, D> {
        Reading {
            tick: 0,
            time_s: 0.0,
            position_m: self.position_m,
        }
    }
}

impl<L: Line, const D: usize> Device<f32, D> for Haply2Diy<L, D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        // A board in trouble fails in each tick: no place is told as if it had been measured.
        let posture = *self.planar.measure().map_err(Trouble::fault)?;
        self.position_m = self.place(&posture);
        Ok(self.reading())
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let force_n = self.along * force.newtons().map(f64::from);
        self.planar.push(force_n).map_err(Trouble::fault)
    }

    fn let_go(&mut self) {
        // A board in trouble is told once more at once, as a byte may be lost again, and at the end; not in each tick between.
        let in_trouble = self.planar.trouble().is_some();
        if !(in_trouble && core::mem::replace(&mut self.told, true)) {
            self.planar.let_go();
        }
    }
}

impl<L: Line, const D: usize> Hardware<D> for Haply2Diy<L, D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        let board = match self.planar.model().version.number() {
            2 => "Haply 2DIY v2",
            _ => "Haply 2DIY v3",
        };
        Capabilities {
            tick_period_max_us: 10_000,
            force_max_n: FORCE_MAX_N,
            // From one end to the other in a tick.
            force_rate_max_n_per_s: 2000.0 * FORCE_MAX_N,
            position_resolution_m: self.planar.model().resolution_m(),
            ..served_host(board, D as u8)
        }
    }

    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        is_real(simulation)
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.planar.ticks_every(1e-6 * f64::from(tick_period_us));
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        Some(self.planar.exchange())
    }

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        let reading = self.read()?;
        let pushed = self.planar.push(Vector2::zeros());
        pushed.map_err(Trouble::fault)?;
        Ok(reading)
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.planar.trouble().map(Trouble::fault)
    }
}

impl<L: Line + 'static, const D: usize> ServedHardware<D> for Haply2Diy<L, D> {
    fn trouble(&self) -> Option<BoardTrouble> {
        let trouble = self.planar.trouble()?;
        let told = match (self.planar.was_told(), trouble.cause()) {
            (false, _) => "the 2DIY cannot be told to let go",
            (true, TroubleCause::Gone) => {
                "the 2DIY does not answer; it was told to let go and to reset itself"
            }
            (true, _) => "the 2DIY was told to let go and to reset itself",
        };
        Some(BoardTrouble {
            words: format!(
                "{told}: {trouble}; the place of its home is not sure any more: hold the handle there when it is opened \
                 again, without home=before"
            ),
            cause: trouble.cause(),
        })
    }
}
