//! The indentation rig whose indenter something else holds: a controller, sample by sample.

use super::facing::{FacingConfig, FacingContact, FacingDevices, FacingSide};
use super::mass_damper::MassDamperConfig;
use super::rig::{IndentationRig, RigConfig, RigContact, RigDrive};
use crate::units::Seconds;
use crate::{Device, LoopParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use fracdiff::parameter::{RangeError, positive};
use nalgebra::SVector;

/// The controller that holds the indenter of a [`HeldRig`]: it turns set point and measurement into
/// a force, once a sample.
pub trait Holder {
    /// The force on the indenter from now until the next sample, N, positive into the tissue. Set point and measurement are positions
    /// in m under [`RigDrive::Position`], contact forces in N under [`RigDrive::Force`].
    fn force(&mut self, set_point: f64, measured: f64) -> f64;

    /// Forgets the motion so far, so that another run begins as the first did.
    fn restart(&mut self);
}

/// Units of time in a sample. At 1 ms one is a nanosecond, in which emulated boards count: both move alike, to the piece of a friction.
const SAMPLE: u64 = 1_000_000;

/// [`FacingDevices`] of which a [`Holder`] drives the indenter, as a device that is the renderer.
///
/// ```text
/// u₁[n] the force written, the tissue's        u₂[n] = holder(r[n], y[n])        both held over the sample
/// ```
/// - *Set point* r: the profile at the sample, y = x₂ (position); or the push, y = F (force).
/// - *Reaction*: the contact force F acts on the holder's mass; the tissue moves as far as that mass does.
/// - *Exact* while in contact or apart, as [`FacingDevices`]. *Start-up*: at rest, both at 0.
/// - *Not finite*: a force that is not finite counts as 0.
/// - *Cost*: that of [`FacingDevices`] and of the holder; no panic.
#[derive(Clone, Debug)]
pub struct HeldRig<H> {
    world: FacingDevices,
    drive: RigDrive,
    sample_time: f64,
    tick: u64,
    holder: H,
    /// S of the last sample, N.
    force: f64,
}

impl RigConfig {
    /// Both actuators of this rig and their contact, without servo or push.
    ///
    /// # Errors
    /// A rigid contact, which has no mass to hold.
    pub fn facing(&self) -> Result<FacingConfig, LoopParameterError> {
        let RigContact::Compliant { stiffness, damping } = self.contact else {
            let allowed =
                "finite where the indenter is a mass that is held: use a compliant contact";
            return Err(RangeError::new("contact stiffness", f64::INFINITY, allowed, "N/m").into());
        };
        let device = |mass, damping| MassDamperConfig::ideal(mass, damping, self.sample_time);
        let renderer = MassDamperConfig {
            saturation: self.saturation,
            ..device(self.renderer_mass, self.renderer_damping)
        };
        Ok(FacingConfig {
            devices: [renderer, device(self.indenter_mass, self.indenter_damping)],
            contact: FacingContact {
                stiffness,
                damping,
                ..FacingContact::COMPLIANT
            },
        })
    }
}

impl<H: Holder> HeldRig<H> {
    /// A rig of this configuration, whose drive gives the holder's set point. The servo is not
    /// used.
    ///
    /// # Errors
    /// As [`IndentationRig::new`]; a rigid contact, which has no mass to hold.
    pub fn new(config: RigConfig, holder: H) -> Result<Self, LoopParameterError> {
        let facing = config.facing()?;
        // A push that is NaN is refused before it is set aside.
        IndentationRig::new(config)?;
        Self::between(facing, config.drive, config.sample_time, holder)
    }

    /// Two devices that differ, each with its own delay, lag and friction, which are commanded once a sample.
    ///
    /// # Errors
    /// As [`FacingDevices::new`]; a sample time that is not above 0.
    pub fn between(
        devices: FacingConfig,
        drive: RigDrive,
        sample_time: Seconds,
        holder: H,
    ) -> Result<Self, LoopParameterError> {
        let sample_time = positive("sample time", sample_time.0, "s")?;
        Ok(Self {
            world: FacingDevices::new(devices, Seconds(sample_time / SAMPLE as f64))?,
            drive,
            sample_time,
            tick: 0,
            holder,
            force: 0.0,
        })
    }

    /// The devices, the indenter of which is held.
    #[must_use]
    pub const fn devices(&self) -> &FacingDevices {
        &self.world
    }

    /// The controller that holds the indenter.
    #[must_use]
    pub const fn holder(&self) -> &H {
        &self.holder
    }

    /// r now: m, or N where a force is the set point.
    #[must_use]
    pub fn set_point(&self) -> f64 {
        match self.drive {
            RigDrive::Position(profile) => profile.position(self.time()),
            RigDrive::Force(push) => push.0,
        }
    }

    /// y now: m, or N where a force is the set point.
    #[must_use]
    pub fn measured(&self) -> f64 {
        match self.drive {
            RigDrive::Position(_) => self.world.position(FacingSide::Indenter),
            RigDrive::Force(_) => self.world.contact_force(),
        }
    }

    /// S over the last sample, N; 0 before the first.
    #[must_use]
    pub const fn drive_force(&self) -> f64 {
        self.force
    }

    /// The position profile now, m; `None` if a force is the set point.
    #[must_use]
    pub fn reference(&self) -> Option<f64> {
        match self.drive {
            RigDrive::Position(_) => Some(self.set_point()),
            RigDrive::Force(_) => None,
        }
    }

    fn time(&self) -> f64 {
        self.tick as f64 * self.sample_time
    }

    /// Back to rest, both at 0, and to time 0; the holder forgets.
    pub fn restart(&mut self) {
        self.world.restart();
        self.tick = 0;
        self.holder.restart();
        self.force = 0.0;
    }
}

impl<F: Real, H: Holder> Device<F, 1> for HeldRig<H> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        let position = self.world.position(FacingSide::Renderer);
        Ok(Reading {
            tick: self.tick,
            time_s: self.time(),
            position_m: SVector::from([F::from_f64(position)]),
        })
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        let (set_point, measured) = (self.set_point(), self.measured());
        let drive = self.holder.force(set_point, measured);
        self.force = if drive.is_finite() { drive } else { 0.0 };
        self.world.command(FacingSide::Indenter, self.force);
        let force = force.newtons()[0].to_f64();
        self.world.command(FacingSide::Renderer, force);
        self.world.advance_to(self.world.now() + SAMPLE);
        self.tick += 1;
        Ok(())
    }
}
