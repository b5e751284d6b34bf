//! Configurations on their way: staged piece by piece, checked, and put in force all at once.

use super::{DeviceSession, Side};
use crate::{
    hardware::Hardware,
    prepared::{COEFFICIENTS_MAX, Prepared, digest, prepare},
};
#[cfg(feature = "controllers")]
use haptic_link::ControllerLaw;
use haptic_link::{COEFFICIENTS_PER_BLOCK, CoefficientBlock, Configuration, Field, Refusal, Scope};
#[cfg(feature = "several-axes")]
use haptic_link::{SurfaceShape, WorkspaceBox};

/// A configuration that is prepared for the board of S.
type PreparedFor<S, const D: usize> = Prepared<<<S as Side<D>>::Board as Hardware<D>>::Setup>;

impl DeviceSession {
    /// Begins to stage a configuration in the place of what was staged before.
    pub(super) fn configure<const D: usize>(
        &mut self,
        configuration: Configuration,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        self.put_back(device)?;
        self.staged = Some(configuration);
        self.values = [0.0; COEFFICIENTS_MAX];
        self.blocks = 0;
        #[cfg(feature = "several-axes")]
        {
            (self.workspace, self.surface) = (None, None);
        }
        #[cfg(feature = "controllers")]
        {
            self.controller = None;
        }
        Ok(())
    }

    /// Stages a controller beside the configuration.
    #[cfg(feature = "controllers")]
    pub(super) fn stage_controller<const D: usize>(
        &mut self,
        law: ControllerLaw,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        self.staging()?;
        if device.with(|device| device.controller_cost()).is_none() {
            return Err(Refusal::Unsupported(Field::Other));
        }
        self.controller = Some(law);
        Ok(())
    }

    /// Stages a box beside the configuration.
    #[cfg(feature = "several-axes")]
    pub(super) fn stage_workspace<const D: usize>(
        &mut self,
        workspace: WorkspaceBox,
    ) -> Result<(), Refusal> {
        self.staging()?;
        if D == 1 || workspace.axes.len() != D {
            return Err(Refusal::Unsupported(Field::WorkspaceLow));
        }
        self.workspace = Some(workspace);
        Ok(())
    }

    /// Stages a surface beside the configuration.
    #[cfg(feature = "several-axes")]
    pub(super) fn stage_surface<const D: usize>(
        &mut self,
        surface: SurfaceShape,
    ) -> Result<(), Refusal> {
        self.staging()?;
        if D == 1 {
            return Err(Refusal::Unsupported(Field::Surface));
        }
        self.surface = Some(surface);
        Ok(())
    }

    /// Refuses what has no configuration to stand beside.
    fn staging(&self) -> Result<(), Refusal> {
        if self.staged.is_none() || self.run_of != 0 {
            return Err(Refusal::Incomplete);
        }
        Ok(())
    }

    pub(super) fn stage(&mut self, block: &CoefficientBlock) -> Result<(), Refusal> {
        let start = usize::from(block.offset);
        self.staging()?;
        let slots = self.values.get_mut(start..start + COEFFICIENTS_PER_BLOCK);
        let aligned = start.is_multiple_of(COEFFICIENTS_PER_BLOCK);
        let Some(slots) = slots.filter(|_| aligned) else {
            return Err(Refusal::range(
                Field::Offset,
                f32::from(block.offset),
                0.0,
                (COEFFICIENTS_MAX - COEFFICIENTS_PER_BLOCK) as f32,
            ));
        };
        slots.copy_from_slice(&block.values);
        self.blocks |= 1 << (start / COEFFICIENTS_PER_BLOCK);
        Ok(())
    }

    pub(super) fn commit<const D: usize>(
        &mut self,
        digest: u32,
        scope: Scope,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        let in_force = device.with(|device| device.configuration().1);
        let for_run = scope == Scope::Run;
        let Some(configuration) = self.whole(digest, in_force, for_run)? else {
            return Ok(());
        };
        if for_run {
            return self.install_for_run(&configuration, device);
        }
        self.install(&configuration, device)?;
        self.staged = None;
        Ok(())
    }

    /// Staged configuration, if all of it is there; `None` if it is in force already.
    #[inline(never)]
    fn whole(
        &self,
        wanted: u32,
        in_force: u32,
        for_run: bool,
    ) -> Result<Option<Configuration>, Refusal> {
        let Some(configuration) = self.staged.filter(|_| self.run_of == 0) else {
            // Sent again because the answer was lost: true already.
            return if in_force == wanted && for_run == (self.run_of != 0) {
                Ok(None)
            } else {
                Err(Refusal::Incomplete)
            };
        };
        let count = configuration.operator.count;
        let Some(values) = self.values.get(..usize::from(count)) else {
            return Err(Refusal::range(
                Field::CoefficientCount,
                f32::from(count),
                1.0,
                COEFFICIENTS_MAX as f32,
            ));
        };
        let needed = haptic_link::block_count(count);
        if (0..needed).any(|block| self.blocks >> block & 1 == 0) {
            return Err(Refusal::Incomplete);
        }
        if self.digest(&configuration, values) != wanted {
            return Err(Refusal::Digest);
        }
        #[cfg(feature = "several-axes")]
        if !for_run && self.workspace.is_some() {
            return Err(Refusal::Unsupported(Field::WorkspaceLow));
        }
        #[cfg(feature = "several-axes")]
        if !for_run && self.surface.is_some() {
            return Err(Refusal::Unsupported(Field::Surface));
        }
        #[cfg(feature = "controllers")]
        if !for_run && self.controller.is_some() {
            return Err(Refusal::Unsupported(Field::Other));
        }
        Ok(Some(configuration))
    }

    #[inline(never)]
    fn digest(&self, configuration: &Configuration, values: &[f32]) -> u32 {
        let digest = digest(configuration, values);
        #[cfg(feature = "several-axes")]
        let digest = match &self.workspace {
            Some(workspace) => digest.workspace(workspace),
            None => digest,
        };
        #[cfg(feature = "several-axes")]
        let digest = match &self.surface {
            Some(surface) => digest.surface(surface),
            None => digest,
        };
        #[cfg(feature = "controllers")]
        let digest = match &self.controller {
            Some(law) => digest.controller(law),
            None => digest,
        };
        digest.finish()
    }

    /// Makes what is staged the configuration in force. On its own, so that only this needs room for what it prepares.
    #[inline(never)]
    fn install<const D: usize>(
        &mut self,
        configuration: &Configuration,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        let values = used(configuration, &self.values);
        let mut prepared = prepared(configuration, values, device)?;
        device.with(|device| {
            device.hardware().fit(&mut prepared.setup)?;
            device.install(prepared, values)
        })
    }

    /// Installs as [`install`](Self::install) does, for a run: keeps the set configuration in place of the staged one.
    #[inline(never)]
    fn install_for_run<const D: usize>(
        &mut self,
        configuration: &Configuration,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        let set = device.with(|device| *device.configuration().0);
        not_looser(configuration, &set)?;
        let values = used(configuration, &self.values);
        let mut prepared = prepared(configuration, values, device)?;
        device.with(|device| device.hardware().fit(&mut prepared.setup))?;
        // With all that is staged beside it.
        #[cfg(any(feature = "several-axes", feature = "controllers"))]
        let digest = self.digest(configuration, values);
        #[cfg(feature = "several-axes")]
        let prepared = match self.workspace.take() {
            Some(workspace) => {
                let capabilities = device.with(|device| device.hardware().capabilities());
                prepared.within(&workspace, digest, &capabilities)?
            }
            None => prepared,
        };
        #[cfg(feature = "several-axes")]
        let prepared = match self.surface.take() {
            Some(surface) => prepared.behind::<D>(surface, digest)?,
            None => prepared,
        };
        #[cfg(feature = "controllers")]
        let prepared = match self.controller.take() {
            Some(law) => {
                let capabilities = device.with(|device| device.hardware().capabilities());
                let cost = device.with(|device| device.controller_cost());
                prepared.holding(law, values, digest, &capabilities, cost)?
            }
            None => prepared,
        };
        self.staged = Some(set);
        self.exchange(prepared, device)
    }

    /// Puts staged values in force, and those in force in their place. On its own: nothing else has to be copied.
    #[inline(never)]
    fn exchange<const D: usize, S: Side<D>>(
        &mut self,
        prepared: PreparedFor<S, D>,
        device: &S,
    ) -> Result<(), Refusal> {
        let values = self.values;
        for (index, slot) in self.values.iter_mut().enumerate() {
            *slot = device
                .with(|device| device.coefficient(index))
                .unwrap_or_default();
        }
        self.run_of = self.connections.current;
        let used = used(&prepared.configuration, &values);
        device.with(|device| device.install(prepared, used))
    }

    /// Puts what was set to last in force again, if a run has replaced it.
    pub(super) fn put_back<const D: usize>(
        &mut self,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        if self.run_of == 0 {
            return Ok(());
        }
        if let Some(set) = self.staged {
            self.install(&set, device)?;
        }
        (self.staged, self.run_of) = (None, 0);
        Ok(())
    }
}

/// Those of the staged values that a configuration takes.
fn used<'a>(configuration: &Configuration, values: &'a [f32]) -> &'a [f32] {
    let count = usize::from(configuration.operator.count);
    values.get(..count).unwrap_or_default()
}

/// Prepares staged values, so that they can take effect now.
#[inline]
fn prepared<const D: usize, S: Side<D>>(
    configuration: &Configuration,
    values: &[f32],
    device: &S,
) -> Result<PreparedFor<S, D>, Refusal> {
    device.with(|device| device.may_install())?;
    let capabilities = device.with(|device| device.hardware().capabilities());
    prepare::<S::Board, D>(*configuration, values, &capabilities)
}

#[inline(never)]
fn not_looser(run: &Configuration, set: &Configuration) -> Result<(), Refusal> {
    let (_, looser) = run.tightened(set);
    looser.map_or(Ok(()), |field| Err(Refusal::Looser(field)))
}
