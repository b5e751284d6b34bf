//! A wall experiment as metadata of its log.

use super::specification::WallExperiment;
use crate::pushed::Trial as _;
use std::collections::BTreeMap;

impl WallExperiment {
    /// Everything needed to repeat the run.
    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let law = vec![
            ("stiffness_n_per_m", self.stiffness_n_per_m.to_string()),
            (
                "dissipation_n_s_mu_per_m",
                self.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("one_sided", self.one_sided.to_string()),
        ];
        self.setup
            .metadata(Self::KIND, (self.order, self.scheme), law)
    }
}
