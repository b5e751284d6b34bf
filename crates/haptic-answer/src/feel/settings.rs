//! Settings of a felt loop: a tissue or a wall, a device, ghosts; changes of it, and the ranges of its numbers.

#![expect(missing_docs, reason = "the protocol has them, by these names")]

use crate::scheme::judged_scheme;
use crate::words::{Number, TextFile};
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds, enumerated};
use haptic_document::Failure;
use haptic_document::parameters::{self, Range};
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece};
use haptic_loop::DepthMap;
use haptic_quantity::short;
use haptic_tissue::{Library, Material, Model};
use haptic_trial::DeviceValues;
use haptic_trial::in_hand::hand::{HAND_M, HeldDevice};
use haptic_trial::keys::wall::{
    DISSIPATION as WALL_DISSIPATION, ORDER as WALL_ORDER, STIFFNESS as WALL_STIFFNESS,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Ends of a slider, and where it begins. What is typed may lie beyond them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slider {
    least: f64,
    most: f64,
    default: f64,
}

const fn slider(least: f64, most: f64, default: f64) -> Slider {
    Slider {
        least,
        most,
        default,
    }
}

const ORDER: Slider = slider(0.0, 2.0, 0.5);
const STIFFNESS: Slider = slider(0.0, 20e3, 300.0);
const DISSIPATION: Slider = slider(0.0, 2000.0, 10.0);

/// Sliders by the names of their numbers; `scale` is a factor on K and B.
pub const SLIDERS: [(&str, Slider); 5] = [
    (WALL_ORDER.key, ORDER),
    (WALL_STIFFNESS.key, STIFFNESS),
    (WALL_DISSIPATION.key, DISSIPATION),
    ("scale", slider(0.01, 100.0, 1.0)),
    ("hand_m", slider(HAND_M.0, HAND_M.1, 0.0)),
];

/// A tissue at a billionth of its size gives nothing that a hand feels.
const SCALES: Range = Range::Within(1e-9, 100.0);
/// Sample times that a loop by the clock of a computer keeps, s.
const SAMPLE_TIMES: Range = Range::Within(1e-4, 1e-2);

/// Refuses a number outside its range. The name comes first, so that a page finds the field.
fn check(name: &str, range: Range, value: f64) -> Result<(), Failure> {
    if range.contains(value) {
        return Ok(());
    }
    Err(Failure::bad_input(format_args!(
        "`{name}` = {} is not {range}: change it",
        Shown(value)
    )))
}

/// A tissue of the library, or a wall that only pushes; or where such a thing is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum FeltThing {
    Tissue(String),
    Wall(WallNumbers),
    /// An experiment or tissue file that a page was given.
    File(TextFile),
    /// A log of the folder of the runs.
    Run(String),
}

/// The law K + B·D^μ of a wall, and how it is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WallNumbers {
    pub order: f64,
    pub stiffness_n_per_m: f64,
    pub dissipation_n_s_mu_per_m: f64,
    /// Scheme as on the command line; `exact` stands for `full`.
    pub scheme: String,
    /// True if its memory is fed with the position in front of the surface too.
    pub signed: bool,
}

impl Default for WallNumbers {
    fn default() -> Self {
        Self {
            order: ORDER.default,
            stiffness_n_per_m: STIFFNESS.default,
            dissipation_n_s_mu_per_m: DISSIPATION.default,
            scheme: parameters::SCHEME.shown.to_owned(),
            signed: false,
        }
    }
}

/// A simulated device and the sample time of its loop. The hand of the values has no effect, because the pointer is the hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeviceNumbers {
    /// Mass, damping, and what is less than ideal.
    #[serde(flatten)]
    pub values: DeviceValues,
    /// T of the loop, s, in [0.0001, 0.01].
    pub sample_time_s: f64,
}

impl Default for DeviceNumbers {
    fn default() -> Self {
        Self::from(DeviceValues {
            mass_kg: parameters::MASS.default_number(),
            damping_n_s_per_m: parameters::DAMPING.default_number(),
            ..DeviceValues::default()
        })
    }
}

impl From<DeviceValues> for DeviceNumbers {
    fn from(values: DeviceValues) -> Self {
        Self {
            values,
            sample_time_s: parameters::SAMPLE_TIME.default_number(),
        }
    }
}

impl DeviceNumbers {
    /// Names of all of its numbers.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let values = DeviceValues::default().named().map(|(known, _)| known.key);
        let all = values.into_iter().chain([parameters::SAMPLE_TIME.key]);
        all.filter(|name| *name != parameters::HAND_STIFFNESS.key)
    }

    /// Replaces these of its numbers.
    ///
    /// # Errors
    /// A name or a number that no device has.
    pub fn with(mut self, numbers: &BTreeMap<String, Number>) -> Result<Self, Failure> {
        for (name, Number(number)) in numbers {
            if !Self::names().any(|known| known == name) {
                let known = Self::names().collect::<Vec<_>>().join(", ");
                return Err(Failure::bad_input(format_args!(
                    "`device` has no number `{}`: give some of {known}",
                    short(name)
                )));
            }
            let values = self.values.named();
            let Some((known, _)) = values.iter().find(|(known, _)| known.key == name) else {
                check(name, SAMPLE_TIMES, *number)?;
                self.sample_time_s = *number;
                continue;
            };
            check(name, known.range(), *number)?;
            self.values.set(known, *number);
        }
        Ok(self)
    }

    pub const fn sample_time(&self) -> Seconds {
        Seconds(self.sample_time_s)
    }

    /// The device itself, in front of the surface.
    ///
    /// # Errors
    /// A number that no device has.
    pub fn simulated(&self) -> Result<HeldDevice, Failure> {
        HeldDevice::new(self.values.free(self.sample_time()), self.values.sensors())
    }
}

enumerated! {
    /// Another operator for the motion that is felt: the last second alone, or A₃, which remembers three samples.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Ghost {
        Short,
        A3,
    }
}

/// Fields of `feel.start` and `feel.set`. A missing one stays, or is that of the environment.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FeelChange {
    pub environment: Option<FeltThing>,
    pub device: Option<BTreeMap<String, Number>>,
    pub order: Option<f64>,
    pub stiffness_n_per_m: Option<f64>,
    pub dissipation_n_s_mu_per_m: Option<f64>,
    pub scale: Option<f64>,
    pub ghosts: Option<Vec<Ghost>>,
}

/// Settings of a felt loop, checked but for its stability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeelSettings {
    pub environment: FeltThing,
    /// A few words for people.
    title: String,
    /// Why a tissue is not felt in its full size.
    pub note: Option<String>,
    /// True if the order can be changed: of one spring-pot beside a spring, not of a model with more elements.
    order_free: bool,
    /// Order, and K and B before the factor.
    #[serde(flatten)]
    pub law: WallNumbers,
    pub scale: f64,
    /// True if neither this factor nor a number of the law was requested, so that it may become one that is stable.
    #[serde(skip)]
    pub may_scale: bool,
    #[serde(flatten)]
    pub device: DeviceNumbers,
    pub ghosts: Vec<Ghost>,
    /// The model of a tissue with more elements, whose memory is felt; `None` for D^μ.
    #[serde(skip)]
    pub model: Option<Model>,
    /// The map of depth of a tissue that stiffens.
    #[serde(skip)]
    pub map: Option<DepthMap<f64>>,
}

impl FeelSettings {
    /// Settings of `feel.start`; `usual` fills in the device.
    ///
    /// # Errors
    /// A number outside its range; an unknown tissue; no environment.
    pub fn new(
        library: &Library,
        usual: DeviceNumbers,
        mut start: FeelChange,
    ) -> Result<Self, Failure> {
        let device = usual.with(&start.device.take().unwrap_or_default())?;
        let environment = start.environment.take().ok_or_else(|| {
            Failure::bad_input("`environment` is missing: name a tissue or a wall")
        })?;
        let ghosts = start.ghosts.take().unwrap_or_else(|| Ghost::ALL.to_vec());
        Self::of(library, environment, device, ghosts)?.changed(library, &start)
    }

    fn of(
        library: &Library,
        environment: FeltThing,
        device: DeviceNumbers,
        ghosts: Vec<Ghost>,
    ) -> Result<Self, Failure> {
        let mut map = None;
        let (title, law, model) = match &environment {
            FeltThing::Tissue(name) => {
                let material = library_material(library, name)?;
                let title = material.description.clone();
                let tissue = ModelledTissue::new(material)?;
                let piece = TissuePiece::usual(tissue).map_err(Failure::input)?;
                let model = piece.material.composed().cloned();
                map = piece.specimen.depth_map();
                let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = piece.spring_and_damper();
                let law = WallNumbers {
                    order: piece.material.order().get(),
                    stiffness_n_per_m,
                    dissipation_n_s_mu_per_m,
                    ..WallNumbers::default()
                };
                (title, law, model)
            }
            FeltThing::Wall(wall) => ("a wall".to_owned(), wall.clone(), None),
            FeltThing::File(_) | FeltThing::Run(_) => {
                return Err(Failure::bad_input(
                    "`environment` is a file or a run, which only `feel.start` opens",
                ));
            }
        };
        Self {
            may_scale: matches!(environment, FeltThing::Tissue(_)),
            environment,
            title,
            note: None,
            order_free: model.is_none(),
            law,
            scale: 1.0,
            device,
            ghosts,
            model,
            map,
        }
        .checked()
    }

    /// Itself, if its numbers are in their ranges; without the ghosts that a model with more elements has not.
    fn checked(mut self) -> Result<Self, Failure> {
        if self.model.is_none() {
            let law = &self.law;
            for (parameter, value) in [
                (WALL_ORDER, law.order),
                (WALL_STIFFNESS, law.stiffness_n_per_m),
                (WALL_DISSIPATION, law.dissipation_n_s_mu_per_m),
            ] {
                check(parameter.key, parameter.range(), value)?;
            }
        } else {
            self.ghosts.clear();
        }
        if self.law.signed && self.gains().0 <= 0.0 {
            return Err(Failure::bad_input(
                "`stiffness_n_per_m` = 0 of a signed wall would push anywhere in front of it: give it above 0",
            ));
        }
        let (scheme, usual) = (self.scheme()?, parameters::SCHEME.shown);
        // `exact` is of the analysis alone.
        if scheme == Scheme::Exact || scheme == judged_scheme(usual)? {
            usual.clone_into(&mut self.law.scheme);
        }
        check("scale", SCALES, self.scale)?;
        // A wall is its numbers.
        if let FeltThing::Wall(wall) = &mut self.environment {
            wall.clone_from(&self.law);
        }
        let mut ghosts = Ghost::ALL.to_vec();
        ghosts.retain(|ghost| self.ghosts.contains(ghost));
        self.ghosts = ghosts;
        Ok(self)
    }

    /// The operator that makes the force, as its scheme names it.
    ///
    /// # Errors
    /// A scheme that is not judged while a person waits.
    pub fn scheme(&self) -> Result<Scheme, Failure> {
        judged_scheme(&self.law.scheme)
    }

    /// Applies a change; another environment brings its own numbers.
    ///
    /// # Errors
    /// As for [`new`](Self::new); another device.
    pub fn changed(&self, library: &Library, change: &FeelChange) -> Result<Self, Failure> {
        if change.device.is_some() {
            return Err(Failure::bad_input(
                "`device` cannot change while it is felt: give it with `feel.start`",
            ));
        }
        let ghosts = change.ghosts.clone().unwrap_or_else(|| self.ghosts.clone());
        let mut next = match &change.environment {
            Some(environment) => Self::of(library, environment.clone(), self.device, ghosts)?,
            None => Self {
                ghosts,
                ..self.clone()
            },
        };
        let law = &mut next.law;
        let (k, b) = (change.stiffness_n_per_m, change.dissipation_n_s_mu_per_m);
        for (name, number, changed) in [
            ("order", change.order, &mut law.order),
            ("stiffness_n_per_m", k, &mut law.stiffness_n_per_m),
            (
                "dissipation_n_s_mu_per_m",
                b,
                &mut law.dissipation_n_s_mu_per_m,
            ),
        ] {
            let Some(number) = number else { continue };
            if let Some(model) = &next.model {
                return Err(Failure::bad_input(format_args!(
                    "`{name}` has no effect on a tissue that is a {}: change `scale`",
                    model.kind().name()
                )));
            }
            // A number that was given is felt as it is, or refused.
            (*changed, next.may_scale) = (number, false);
        }
        if let Some(scale) = change.scale {
            (next.scale, next.may_scale, next.note) = (scale, false, None);
        }
        next.checked()
    }
}

/// A tissue of the library by its name; a path is not accepted.
fn library_material(library: &Library, name: &str) -> Result<Material, Failure> {
    let materials = library.materials();
    let named = materials.iter().find(|material| material.name == name);
    named.cloned().ok_or_else(|| {
        let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        Failure::bad_input(format_args!(
            "tissue {:?} is not in the library: use one of {}",
            short(name),
            known.join(", ")
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tissue(name: &str) -> FeelChange {
        FeelChange {
            environment: Some(FeltThing::Tissue(name.to_owned())),
            ..FeelChange::default()
        }
    }

    fn started(start: FeelChange) -> Result<FeelSettings, Failure> {
        let device = DeviceNumbers::default();
        FeelSettings::new(&library(), device, start)
    }

    fn library() -> Library {
        Library::load(None).expect("built in")
    }

    fn order(order: f64) -> FeelChange {
        FeelChange {
            order: Some(order),
            ..FeelChange::default()
        }
    }

    #[test]
    fn a_tissue_brings_its_numbers_a_change_keeps_the_others_and_a_start_may_be_both() {
        let library = library();
        let felt = started(tissue("prostate-cancerous")).expect("known");
        assert_eq!((felt.law.order, felt.law.stiffness_n_per_m), (0.2247, 0.0));
        assert!((felt.law.dissipation_n_s_mu_per_m - 173.0).abs() < 1e-9);
        let next = felt.changed(&library, &order(0.4)).expect("in range");
        let mut want = felt.clone();
        (want.law.order, want.may_scale) = (0.4, false);
        assert_eq!(next, want);
        let at_once = FeelChange {
            order: Some(0.4),
            ..tissue("prostate-cancerous")
        };
        assert_eq!(started(at_once).expect("in range"), want);
        let healthy = next.changed(&library, &tissue("prostate-healthy"));
        let healthy = healthy.expect("known");
        assert_eq!((healthy.law.order, healthy.scale), (0.2154, 1.0));
    }

    #[test]
    fn what_is_out_of_range_or_unknown_is_refused_in_a_sentence() {
        let refused = |asked: Result<FeelSettings, Failure>, words: &str| {
            let error = asked.expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        };
        let secret = started(tissue("../secret.toml"));
        refused(secret, "use one of prostate-cancerous");
        refused(started(order(0.5)), "`environment` is missing");
        let felt = started(tissue("prostate-cancerous")).expect("known");
        for wrong in [-0.1, 2.1, f64::NAN, f64::INFINITY] {
            refused(felt.changed(&library(), &order(wrong)), "not from 0 to 2");
        }
        let device = FeelChange {
            device: Some(BTreeMap::new()),
            ..FeelChange::default()
        };
        refused(felt.changed(&library(), &device), "`feel.start`");
    }

    #[test]
    fn a_model_with_more_elements_has_its_own_memory_and_no_ghosts() {
        let muscle = started(tissue("fish-muscle")).expect("known");
        assert!(!muscle.order_free && muscle.ghosts.is_empty() && muscle.model.is_some());
        let error = muscle.changed(&library(), &order(0.4));
        let error = error.expect_err("no single order").to_string();
        assert!(error.contains("change `scale`"), "{error}");
    }
}
