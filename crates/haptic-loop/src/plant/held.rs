//! The indentation rig whose indenter something else holds: a controller, sample by sample.

use super::rig::{IndentationRig, RigConfig, RigContact, RigDrive};
use crate::units::Newtons;
use crate::{Device, ParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use fracdiff::parameter::RangeError;

/// The controller that holds the indenter of a [`HeldRig`]: it turns set point and measurement into
/// a force, once a sample.
pub trait Holder {
    /// The force on the indenter from now until the next sample, N, positive into the tissue. Set point and measurement are positions
    /// in m under [`RigDrive::Position`], contact forces in N under [`RigDrive::Force`].
    fn force(&mut self, set_point: f64, measured: f64) -> f64;

    /// Forgets everything.
    fn restart(&mut self);
}

/// An [`IndentationRig`] whose indenter is a mass that a [`Holder`] drives, instead of a servo or a
/// constant push.
///
/// ```text
/// renderer:  m₁·x₁'' + b₁·x₁' = F + f        f written: the tissue's force
/// indenter:  m₂·x₂'' + b₂·x₂' = S − F        S = holder(r[n], y[n]), held over the sample
/// ```
/// - *Set point* r: the profile at the sample, y = x₂ (position); or the push, y = F (force).
/// - *Reaction*: the contact force F acts on the holder's mass; the tissue moves as far as that mass does.
/// - *Exact* while in contact or apart, as [`IndentationRig`]. *Start-up*: at rest, just touching.
/// - *Not finite*: a force that is not finite is none.
/// - *Cost*: that of [`IndentationRig`] and of the holder; no allocation, no panic.
#[derive(Clone, Debug)]
pub struct HeldRig<H> {
    rig: IndentationRig,
    drive: RigDrive,
    holder: H,
    /// S of the last sample, N.
    force: f64,
}

impl<H: Holder> HeldRig<H> {
    /// A rig of this configuration, whose drive gives the holder's set point. The servo is not
    /// used.
    ///
    /// # Errors
    /// As [`IndentationRig::new`]; a rigid contact, which has no mass to hold.
    pub fn new(config: RigConfig, holder: H) -> Result<Self, ParameterError> {
        if config.contact == RigContact::Rigid {
            let allowed =
                "finite where the indenter is a mass that is held: take a compliant contact";
            return Err(RangeError::new("contact stiffness", f64::INFINITY, allowed, "N/m").into());
        }
        // A push that is no number is refused before it is set aside.
        IndentationRig::new(config)?;
        let pushed = RigConfig {
            drive: RigDrive::Force(Newtons(0.0)),
            ..config
        };
        Ok(Self {
            rig: IndentationRig::new(pushed)?,
            drive: config.drive,
            holder,
            force: 0.0,
        })
    }

    /// The rig whose indenter is held.
    #[must_use]
    pub const fn rig(&self) -> &IndentationRig {
        &self.rig
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
            RigDrive::Position(profile) => profile.position(self.rig.now()),
            RigDrive::Force(push) => push.0,
        }
    }

    /// y now: m, or N where a force is the set point.
    #[must_use]
    pub fn measured(&self) -> f64 {
        match self.drive {
            RigDrive::Position(_) => self.rig.indenter_position(),
            RigDrive::Force(_) => self.rig.contact_force(),
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

    /// Back to rest, just touching, and to time 0; the holder forgets.
    pub fn restart(&mut self) {
        self.rig.restart();
        self.holder.restart();
        self.force = 0.0;
    }
}

impl<F: Real, H: Holder> Device<F, 1> for HeldRig<H> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        self.rig.read()
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        let (set_point, measured) = (self.set_point(), self.measured());
        let drive = self.holder.force(set_point, measured);
        self.force = if drive.is_finite() { drive } else { 0.0 };
        self.rig.push(Newtons(self.force));
        self.rig.write(force)
    }
}
