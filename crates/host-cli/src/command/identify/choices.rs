//! Options that are one of several names.

use haptic_experiment::Named;
use haptic_tissue::ModelKind;
use haptic_tissue::identify::{CANDIDATES, RecordKind, Weighting};

/// A kind of record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct KindChoice(pub(super) RecordKind);

impl KindChoice {
    const fn of(kind: RecordKind, words: &'static str) -> (Self, &'static str, &'static str) {
        (Self(kind), kind.name(), words)
    }
}

impl Named for KindChoice {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        Self::of(RecordKind::Relaxation, "stress after a step of strain"),
        Self::of(RecordKind::Creep, "strain after a step of stress"),
        Self::of(
            RecordKind::Oscillation,
            "storage and loss modulus over frequency",
        ),
        Self::of(
            RecordKind::History,
            "strain and stress of any motion from rest",
        ),
    ];
}

/// The model to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ModelChoice {
    Auto,
    One(ModelKind),
}

impl Named for ModelChoice {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Auto, "auto", "the simplest that the record supports"),
        Self::of(ModelKind::SpringPot),
        Self::of(ModelKind::FractionalKelvinVoigt),
        Self::of(ModelKind::FractionalMaxwell),
        Self::of(ModelKind::FractionalZener),
        Self::of(ModelKind::FractionalPoyntingThomson),
    ];
}

impl ModelChoice {
    const fn of(kind: ModelKind) -> (Self, &'static str, &'static str) {
        (Self::One(kind), kind.name(), kind.description())
    }

    /// The models to fit: all, or the one and those with fewer parameters, to say if one of these is as good.
    pub(super) fn candidates(self) -> Vec<ModelKind> {
        let wanted = |candidate: &ModelKind| match self {
            Self::Auto => true,
            Self::One(one) => {
                *candidate == one || candidate.parameters().len() < one.parameters().len()
            }
        };
        CANDIDATES.into_iter().filter(wanted).collect()
    }

    /// The model that was asked for, if it is one.
    pub(super) const fn only(self) -> Option<ModelKind> {
        match self {
            Self::Auto => None,
            Self::One(one) => Some(one),
        }
    }
}

/// The weights of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WeightChoice(pub(super) Weighting);

impl Named for WeightChoice {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self(Weighting::Equal),
            "equal",
            "all samples count the same",
        ),
        (
            Self(Weighting::LogSpacing),
            "log-spacing",
            "by spacing in log time or frequency",
        ),
    ];
}
