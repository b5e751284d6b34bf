//! A workspace of its own for each axis of a device of several.

use crate::prepared::Prepared;
use haptic_link::{Capabilities, Refusal, WorkspaceBox};

impl<S> Prepared<S> {
    /// Confines the run to a box; `digest` covers all.
    #[cfg(feature = "std")]
    pub(crate) fn within(
        self,
        workspace: &WorkspaceBox,
        digest: u32,
        capabilities: &Capabilities,
    ) -> Result<Self, Refusal> {
        use crate::limits::{Fields, box_ranges};
        use crate::prepared::{checked, safety_chain};
        use haptic_loop::units::Seconds;
        let configuration = &self.configuration;
        let mut fields = Fields::default();
        let limits = haptic_loop::SafetyLimits {
            workspace_box: box_ranges(&configuration.limits, workspace, &mut fields),
            ..checked(configuration, capabilities)?
        };
        fields.done()?;
        let t = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
        Ok(Self {
            chain: safety_chain(&limits, t)?,
            digest,
            ..self
        })
    }

    /// The chain of a microcontroller has no room for a box.
    #[cfg(not(feature = "std"))]
    pub(crate) fn within(
        self,
        _: &WorkspaceBox,
        _: u32,
        _: &Capabilities,
    ) -> Result<Self, Refusal> {
        Err(Refusal::Unsupported(haptic_link::Field::WorkspaceLow))
    }
}
