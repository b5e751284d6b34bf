//! Options of a fit: the candidates of a record, and parameters that are held.
//! ```text
//! V between low and high:  ln V = a + α·ln t₀ is between their logarithms, with t₀ = 1 s a range of one variable
//! ```
//! A model that lacks a held parameter is not a candidate, nor is one that a record of this kind cannot show: a dashpot has
//! no stress after a step of strain, a spring no loss.
//!
//! *Errors*: an unknown name, a range that is empty or outside that of the parameter, no candidate left.

use super::elements::{CANDIDATES, Candidate};
use super::error::IdentifyError;
use super::keys::{MODEL, STIFFENING};
use super::record::{Baseline, Record, RecordKind};
use super::target::{Target, Weighting};
use fracdiff::parameter::Shown;
use haptic_loop::Specimen;
use haptic_tissue::{ModelKind, ModelParameter, ParameterRange};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::sync::atomic::AtomicBool;

/// Candidates and effort of a fit to a record; see [`identify`](crate::identify()).
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The candidates, of [`CANDIDATES`].
    pub candidates: Vec<ModelKind>,
    /// The one to choose, whatever the record says for others; without it, the record chooses.
    pub chosen: Option<ModelKind>,
    /// The weights of the samples.
    pub weighting: Weighting,
    /// Starts for each candidate, [`Options::STARTS_ALLOWED`].
    pub starts: usize,
    /// Records of the bootstrap, [`Options::BOOTSTRAP_ALLOWED`]; 0 for intervals by profiles.
    pub bootstrap: usize,
    /// Seed of the bootstrap: equal seeds draw equal records, whatever the number of threads.
    pub seed: u64,
    /// True to find b of tissue that stiffens too, see `haptic_loop::loading`: the last parameter of the chosen fit, from 0 to 100.
    pub stiffening: bool,
    /// The part of the force of a motion that is not the tissue's, to be fitted with it.
    pub baseline: Option<Baseline>,
    /// Parameters that are held at a value or within a range; models without one of them are no candidates.
    pub held: Vec<HeldParameter>,
}

impl Options {
    /// Enough that no golden record is fitted worse than by 40 starts of `SciPy`.
    pub const STARTS: usize = 40;
    /// Starts that are worth their time.
    pub const STARTS_ALLOWED: RangeInclusive<u32> = 1..=10_000;
    /// A number of bootstrap records that is worth its time.
    pub const BOOTSTRAP_ALLOWED: RangeInclusive<u32> = 0..=100_000;
}

impl Default for Options {
    /// All candidates, weights by errors, 40 starts, no bootstrap.
    fn default() -> Self {
        Self {
            candidates: CANDIDATES.to_vec(),
            chosen: None,
            weighting: Weighting::Errors,
            starts: Self::STARTS,
            bootstrap: 0,
            seed: 1,
            stiffening: false,
            baseline: None,
            held: Vec::new(),
        }
    }
}

/// A parameter that is held at a value, or within a range.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldParameter {
    /// Its name, as in a tissue file.
    pub name: String,
    /// The lowest value, in the parameter's SI unit.
    pub low: f64,
    /// The highest value: the lowest one again to hold it there.
    pub high: f64,
}

/// The candidates that a record of this kind can be fitted by, with what is held.
pub(super) fn candidates(
    options: &Options,
    record: &Record,
) -> Result<Vec<Candidate>, IdentifyError> {
    let kind = record.kind;
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    for (index, held) in options.held.iter().enumerate() {
        held.check(options)?;
        let mut others = options.held[..index].iter();
        if others.any(|one| one.name == held.name) {
            return wrong(format!("`{}` is held twice: hold it once", held.name));
        }
    }
    let stiffening = stiffening(options);
    let nuisance = usize::from(options.stiffening && stiffening.0 < stiffening.1);
    let mut candidates = Vec::new();
    for &model in &options.candidates {
        if !CANDIDATES.contains(&model) {
            return wrong(format!(
                "{model} is not fitted by itself: use one of {}",
                CANDIDATES.map(ModelKind::name).join(", ")
            ));
        }
        if model.is_sum() {
            continue;
        }
        let mut memory = options.held.iter().filter(|held| held.name != STIFFENING.0);
        let candidate = memory
            .try_fold(Candidate::of(model), |candidate, held| {
                candidate.with_held(&held.name, held.low, held.high)
            })
            .filter(|_| shows(model, kind));
        if let Some((order, second)) = candidate.and_then(Candidate::exchanged) {
            return wrong(format!(
                "order, at most {}, is held below second_order, at least {}: exchange the two elements",
                Shown(order),
                Shown(second)
            ));
        }
        match candidate {
            Some(candidate) => candidates.push(candidate.with_nuisance(nuisance)),
            None if options.chosen == Some(model) => {
                return wrong(if shows(model, kind) {
                    format!(
                        "{model} lacks a parameter that is held: hold others, or give another model"
                    )
                } else {
                    format!(
                        "a record of kind {} cannot show a {model}, whose response is zero or without end: give another model",
                        kind.name()
                    )
                });
            }
            None => {}
        }
    }
    if let Some(why) = &record.untimed
        && !candidates.iter().all(|one| one.is_static())
    {
        return wrong(format!(
            "{why}, which only a model without memory does without: give times that rise, or {}",
            MODEL.set_to(ModelKind::Spring.name())
        ));
    }
    let is_alone = options.candidates.iter().all(|model| model.is_sum());
    if candidates.is_empty() && !is_alone {
        return wrong(
            "no model has all the parameters that are held: hold fewer of them".to_owned(),
        );
    }
    Ok(candidates)
}

/// The sums of Maxwell elements that such a record can be fitted by.
pub(super) fn sums_wanted(options: &Options, record: &Record) -> Vec<ModelKind> {
    let all = options.candidates.iter().copied();
    let is_known = |kind: &ModelKind| kind.is_sum() && shows(*kind, record.kind);
    let is_free = options.held.is_empty() && record.untimed.is_none();
    all.filter(|kind| is_free && is_known(kind)).collect()
}

/// True if a record of this kind can be that of a model: no value of it is 0 or infinite throughout.
const fn shows(model: ModelKind, kind: RecordKind) -> bool {
    use RecordKind::{Creep, History, Oscillation, Relaxation};
    let (relaxes, oscillates) = model.relaxes_and_oscillates();
    match kind {
        Relaxation => relaxes,
        Oscillation => oscillates,
        Creep | History => true,
    }
}

/// Low and high end of b.
pub(super) fn stiffening(options: &Options) -> (f64, f64) {
    let held = options.held.iter().find(|held| held.name == STIFFENING.0);
    held.map_or((0.0, Specimen::STIFFENING_MAX), |held| {
        (held.low, held.high)
    })
}

/// The record, in seconds where a modulus is held.
pub(super) fn target_of<'a>(
    record: &Record,
    options: &Options,
    stop: &'a AtomicBool,
) -> Target<'a> {
    let target = Target::new(record, options.weighting, stop);
    let mut parameters = of_elements();
    let is_held = |name: &str| options.held.iter().any(|held| held.name == name);
    if parameters.any(|one| one.range != ParameterRange::Order && is_held(one.name)) {
        target.in_seconds()
    } else {
        target
    }
}

/// Parameters that can be held.
fn of_elements() -> impl Iterator<Item = &'static ModelParameter> {
    let all = CANDIDATES.iter().filter(|kind| !kind.is_sum());
    all.flat_map(|kind| kind.parameters())
}

impl HeldParameter {
    /// Checks name and range; the error names the remedy.
    fn check(&self, options: &Options) -> Result<(), IdentifyError> {
        let Self { name, low, high } = self;
        let wrong = |reason: String| Err(IdentifyError::Record(reason));
        let mut parameters = of_elements();
        let of_memory: Option<&ModelParameter> = parameters.find(|one| one.name == name);
        let (contains, allowed) = match of_memory {
            Some(known) => {
                let inside = [low, high].iter().all(|end| known.range.contains(**end));
                (inside, known.range.words().to_owned())
            }
            None if name == STIFFENING.0 && options.stiffening => {
                let most = Specimen::STIFFENING_MAX;
                let inside = [low, high].iter().all(|end| (0.0..=most).contains(*end));
                (inside, format!("in [0, {most}]"))
            }
            None if name == STIFFENING.0 => {
                return wrong(format!(
                    "{name} is held but not looked for: give {STIFFENING} too"
                ));
            }
            None => {
                let parameters = of_elements();
                let names: BTreeSet<&str> = parameters.map(|one| one.name).collect();
                let names = Vec::from_iter(names).join(", ");
                return wrong(format!(
                    "no model has a parameter `{name}`: hold one of {names}"
                ));
            }
        };
        let shown = if low.to_bits() == high.to_bits() {
            Shown(*low).to_string()
        } else {
            format!("{}..{}", Shown(*low), Shown(*high))
        };
        if !contains {
            return wrong(format!(
                "{name} {shown} is not {allowed}: hold it within that"
            ));
        }
        if low > high {
            return wrong(format!(
                "{name} {shown} begins above its end: exchange the two"
            ));
        }
        Ok(())
    }
}
