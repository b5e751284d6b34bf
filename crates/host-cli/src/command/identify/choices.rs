//! Options that are one of several names.

use haptic_experiment::Named;
use haptic_tissue::ModelKind;
use haptic_tissue::identify::{CANDIDATES, RecordKind, Weighting};

/// A kind of record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct KindChoice(pub(super) RecordKind);

impl Named for KindChoice {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self(RecordKind::Relaxation),
            "relaxation",
            "stress after a step of strain",
        ),
        (
            Self(RecordKind::Creep),
            "creep",
            "strain after a step of stress",
        ),
        (
            Self(RecordKind::Oscillation),
            "oscillation",
            "storage and loss modulus over frequency",
        ),
        (
            Self(RecordKind::History),
            "record",
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
        (
            Self::Auto,
            "auto",
            "the simplest of those that the record supports best",
        ),
        (
            Self::One(ModelKind::SpringPot),
            "spring-pot",
            "one spring-pot",
        ),
        (
            Self::One(ModelKind::FractionalKelvinVoigt),
            "fractional-kelvin-voigt",
            "two spring-pots side by side",
        ),
        (
            Self::One(ModelKind::FractionalMaxwell),
            "fractional-maxwell",
            "two spring-pots in series",
        ),
        (
            Self::One(ModelKind::FractionalZener),
            "fractional-zener",
            "a spring beside a fractional Maxwell model",
        ),
        (
            Self::One(ModelKind::FractionalPoyntingThomson),
            "fractional-poynting-thomson",
            "a spring in series with a fractional Kelvin-Voigt model",
        ),
    ];
}

impl ModelChoice {
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
        (Self(Weighting::Equal), "equal", "each sample counts alike"),
        (
            Self(Weighting::LogSpacing),
            "log-spacing",
            "each counts as much as it covers of the logarithm of time or frequency",
        ),
    ];
}
