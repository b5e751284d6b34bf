//! The names that a parameter may take.

use crate::design::{DesignWish, RequireName};
use crate::tissue::{KIND, TISSUE_MODEL, models};
use haptic_document::Named;
use haptic_document::parameters::Parameter;
use haptic_judge::preflight::WallContact;
use haptic_judge::rendering::{IndenterContact, Precision};
use haptic_judge::settling::Criterion;
use haptic_link::{Architecture, LoopMode};
use haptic_loop::LoadingKind;
use haptic_measurement::MeasuredAxis;
use haptic_trial::GuardChoice;
use haptic_trial::keys::trial::PushBy;
use haptic_trial::keys::wall::WALL_CONTACT;
use tissue_identification::{Baseline, RecordKind, ShiftBy, Weighting};

/// A name, and what it stands for in a few words.
pub type NamedChoice = (&'static str, &'static str);

/// The names of a type.
#[must_use]
pub fn names<T: Named>() -> Vec<NamedChoice> {
    words(T::CHOICES)
}

fn words<T>(choices: &[(T, &'static str, &'static str)]) -> Vec<NamedChoice> {
    let choices = choices.iter();
    choices.map(|(_, name, help)| (*name, *help)).collect()
}

/// The names that a parameter accepts, each with a short explanation; empty if it accepts any text.
#[must_use]
pub fn choices(parameter: &Parameter) -> Vec<NamedChoice> {
    match parameter.key {
        "axis" => names::<MeasuredAxis>(),
        "baseline" => words(&Baseline::CHOICES),
        "kind" if *parameter == KIND => words(&RecordKind::CHOICES),
        "model" if *parameter == TISSUE_MODEL => words(&models()),
        "shift_by" => words(&ShiftBy::CHOICES),
        "weights" => words(&Weighting::CHOICES),
        "architecture" => names::<Architecture>(),
        "contact" if *parameter == WALL_CONTACT => names::<WallContact>(),
        "contact" => names::<IndenterContact>(),
        "precision" => names::<Precision>(),
        "criterion" => names::<Criterion>(),
        "guard" => names::<GuardChoice>(),
        "loading" => names::<LoadingKind>(),
        "loop" | "drive_loop" => names::<LoopMode>(),
        "push_by" => names::<PushBy>(),
        "require" => names::<RequireName>(),
        "wish" => names::<DesignWish>(),
        _ => Vec::new(),
    }
}
