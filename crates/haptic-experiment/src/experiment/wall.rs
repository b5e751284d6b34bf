//! A wall that a device hits and is pushed into, as an experiment: see [`haptic_judge::wall`].

use super::trial::{Conducted, OffN, Trial, conducted, incomparable, law_of};
use haptic_document::{Failure, FileError, Table};
pub(crate) use haptic_judge::wall::WallTrial;
use haptic_judge::{preflight::WallContact, reference::ReferenceWeights, setup::Beside};
use haptic_link::LoopMode;
use haptic_run::{
    Ran,
    remote::{RemoteLaw, portable},
};

/// A wall, and how it is run.
pub(crate) type WallExperiment = Conducted<WallTrial>;

/// `[wall]`: device, wall and trial, with the table of a second device that pushes.
pub(crate) fn wall(table: &Table<'_>, beside: Beside<'_>) -> Result<WallExperiment, FileError> {
    conducted(table, beside.drive, |at_port| {
        haptic_judge::wall::wall(table, beside, at_port)
    })
}

impl Trial for WallTrial {
    fn law_there(&self, samples: u64) -> Result<RemoteLaw, Failure> {
        let law = law_of(&self.setup);
        let operator = match self.setup.at_port {
            Some(LoopMode::Device) => portable(&self.look(samples).operator()?)?,
            Some(LoopMode::Host) | None => law.operator,
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.contact == WallContact::OneSided,
            operator,
            tap: self.tapped(),
            ..law
        })
    }

    fn tissue_file(&self) -> Option<String> {
        self.tissue.as_ref().map(|piece| piece.material.to_toml())
    }

    /// The force is −(K·x + B·D^μ x) by the full history of x, or its push alone.
    fn off_n(&self, ran: &Ran) -> Result<OffN<'_>, Failure> {
        let kernel = ReferenceWeights::of(self.scheme);
        let depth = self.contact == WallContact::OneSided;
        let pulls = self.contact == WallContact::Linear;
        let reason = (depth.then_some("a one-sided wall is not compared"))
            .or_else(|| incomparable(kernel, self.order, &ran.record));
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let planned = self.setup.plan().samples(self.setup.device.sample_time)?;
        let samples = ran.samples();
        let mut derivative = (self.look(planned)).felt_of(samples, ran.record.before())?;
        Ok(Ok(Box::new(move |sample| {
            let (x, d) = (sample.position_m, derivative.at(sample));
            let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
            let wanted = if pulls { wanted } else { wanted.min(0.0) };
            sample.force_n - wanted
        })))
    }
}
