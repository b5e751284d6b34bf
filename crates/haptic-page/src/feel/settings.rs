//! What is felt: a tissue or a wall, a device, ghosts; changes of it, and the ranges of its numbers.

use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use haptic_experiment::parameters;
use haptic_experiment::{Failure, Imperfections, ModelledTissue, TissuePiece};
use haptic_loop::DepthMap;
use haptic_tissue::{Library, Material, Model};
use serde::{Deserialize, Serialize};

/// T of the loop, s.
pub(crate) const SAMPLE_TIME: Seconds = Seconds(parameters::SAMPLE_TIME.default_number());

/// Range of a number, what it is where nothing is said, and a step of its slider.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct NumberRange {
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) default: f64,
    step: f64,
}

const fn range(least: f64, most: f64, default: f64, step: f64) -> NumberRange {
    NumberRange {
        least,
        most,
        default,
        step,
    }
}

/// Ranges by the names of the numbers; order and gains default to those of a wall.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Ranges {
    order: NumberRange,
    stiffness_n_per_m: NumberRange,
    dissipation_n_s_mu_per_m: NumberRange,
    /// Factor on K and B.
    scale: NumberRange,
    mass_kg: NumberRange,
    pub(super) damping_n_s_per_m: NumberRange,
    pub(super) hand_m: NumberRange,
}

pub(crate) const RANGES: Ranges = Ranges {
    order: range(0.0, 1.0, 0.5, 0.001),
    stiffness_n_per_m: range(0.0, 5000.0, 300.0, 1.0),
    dissipation_n_s_mu_per_m: range(0.0, 2000.0, 10.0, 0.1),
    scale: range(0.01, 100.0, 1.0, 0.01),
    mass_kg: range(0.005, 2.0, parameters::MASS.default_number(), 0.001),
    damping_n_s_per_m: range(0.0, 50.0, parameters::DAMPING.default_number(), 0.1),
    hand_m: range(-0.03, 0.03, 0.0, 1e-4),
};

impl Ranges {
    pub(crate) const fn with_device(mut self, device: DeviceNumbers) -> Self {
        self.mass_kg.default = device.mass_kg;
        self.damping_n_s_per_m.default = device.damping_n_s_per_m;
        self
    }
}

impl NumberRange {
    fn check(self, name: &str, value: f64) -> Result<(), Failure> {
        let Self { least, most, .. } = self;
        if (least..=most).contains(&value) {
            return Ok(());
        }
        Err(Failure::bad_input(format_args!(
            "`{name}` = {} is not in [{least}, {most}]: change it",
            Shown(value)
        )))
    }

    /// The number, or the end of the range that is nearest to it.
    pub(super) const fn nearest(self, value: f64) -> f64 {
        value.clamp(self.least, self.most)
    }
}

/// A tissue of the library, or a one-sided wall of three numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum FeltThing {
    Tissue(String),
    Wall(WallNumbers),
}

/// The numbers of a law, K + B·D^μ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct WallNumbers {
    pub(super) order: f64,
    pub(super) stiffness_n_per_m: f64,
    pub(super) dissipation_n_s_mu_per_m: f64,
}

impl Default for WallNumbers {
    fn default() -> Self {
        Self {
            order: RANGES.order.default,
            stiffness_n_per_m: RANGES.stiffness_n_per_m.default,
            dissipation_n_s_mu_per_m: RANGES.dissipation_n_s_mu_per_m.default,
        }
    }
}

/// Mass and damping of the simulated device; its other numbers come from the server's device file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeviceNumbers {
    /// m, kg, in [0.005, 2].
    pub mass_kg: f64,
    /// b, N·s/m, in [0, 50]: what stability requires depends on the law.
    pub damping_n_s_per_m: f64,
}

impl Default for DeviceNumbers {
    fn default() -> Self {
        Self {
            mass_kg: RANGES.mass_kg.default,
            damping_n_s_per_m: RANGES.damping_n_s_per_m.default,
        }
    }
}

/// The same motion felt by another operator: the last second alone, or A₃, which remembers three samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Ghost {
    Short,
    A3,
}

impl Ghost {
    /// Both, in the order of the channels.
    pub(super) const ALL: [Self; 2] = [Self::Short, Self::A3];
}

/// What `feel.start` and `feel.set` say. What is not named stays, or is that of the environment.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FeelChange {
    pub(super) environment: Option<FeltThing>,
    pub(super) device: Option<DeviceNumbers>,
    pub(crate) order: Option<f64>,
    pub(super) stiffness_n_per_m: Option<f64>,
    pub(super) dissipation_n_s_mu_per_m: Option<f64>,
    pub(super) scale: Option<f64>,
    pub(super) ghosts: Option<Vec<Ghost>>,
}

/// What is felt, checked but for its stability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FeelSettings {
    pub(super) environment: FeltThing,
    /// A few words for people.
    title: String,
    /// True if the order can be changed: of one spring-pot beside a spring, not of a model with more elements.
    order_free: bool,
    /// Order, and K and B before the factor.
    #[serde(flatten)]
    pub(super) law: WallNumbers,
    pub(super) scale: f64,
    #[serde(flatten)]
    pub(super) device: DeviceNumbers,
    pub(super) ghosts: Vec<Ghost>,
    /// The model of a tissue with more elements, whose memory is felt; `None` for D^μ.
    #[serde(skip)]
    pub(super) model: Option<Model>,
    /// The map of depth of a tissue that stiffens.
    #[serde(skip)]
    pub(super) map: Option<DepthMap<f64>>,
    /// Friction, delay, lag and sensors of the device: those of the server's device file.
    #[serde(skip)]
    pub(super) imperfections: Imperfections,
}

impl FeelSettings {
    /// What `feel.start` asks for, on a device with these imperfections; the device is `usual` if none is named.
    pub(crate) fn new(
        library: &Library,
        usual: DeviceNumbers,
        imperfections: Imperfections,
        mut start: FeelChange,
    ) -> Result<Self, Failure> {
        let device = start.device.take().unwrap_or(usual);
        RANGES.mass_kg.check("mass_kg", device.mass_kg)?;
        let (range, damping) = (RANGES.damping_n_s_per_m, device.damping_n_s_per_m);
        range.check("damping_n_s_per_m", damping)?;
        let environment = start.environment.take().ok_or_else(|| {
            Failure::bad_input("`environment` is missing: name a tissue or a wall")
        })?;
        let ghosts = start.ghosts.take().unwrap_or_else(|| Ghost::ALL.to_vec());
        Self::of(library, environment, device, imperfections, ghosts)?.changed(library, &start)
    }

    fn of(
        library: &Library,
        environment: FeltThing,
        device: DeviceNumbers,
        imperfections: Imperfections,
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
                };
                (title, law, model)
            }
            FeltThing::Wall(wall) => ("a wall".to_owned(), *wall, None),
        };
        Self {
            environment,
            title,
            order_free: model.is_none(),
            law,
            scale: RANGES.scale.default,
            device,
            ghosts,
            model,
            map,
            imperfections,
        }
        .checked()
    }

    /// Itself, if its numbers are in their ranges; without the ghosts that a model with more elements has not.
    fn checked(mut self) -> Result<Self, Failure> {
        if self.model.is_none() {
            let (ranges, law) = (RANGES, self.law);
            let (k, b) = (law.stiffness_n_per_m, law.dissipation_n_s_mu_per_m);
            ranges.order.check("order", law.order)?;
            ranges.stiffness_n_per_m.check("stiffness_n_per_m", k)?;
            let range = ranges.dissipation_n_s_mu_per_m;
            range.check("dissipation_n_s_mu_per_m", b)?;
        } else {
            self.ghosts.clear();
        }
        RANGES.scale.check("scale", self.scale)?;
        let mut ghosts = Ghost::ALL.to_vec();
        ghosts.retain(|ghost| self.ghosts.contains(ghost));
        self.ghosts = ghosts;
        Ok(self)
    }

    /// The same with a change; another environment brings its own numbers.
    pub(crate) fn changed(&self, library: &Library, change: &FeelChange) -> Result<Self, Failure> {
        if change.device.is_some() {
            return Err(Failure::bad_input(
                "`device` cannot change while it is felt: give it with `feel.start`",
            ));
        }
        let ghosts = change.ghosts.clone().unwrap_or_else(|| self.ghosts.clone());
        let mut next = match &change.environment {
            Some(environment) => {
                let environment = environment.clone();
                Self::of(
                    library,
                    environment,
                    self.device,
                    self.imperfections,
                    ghosts,
                )?
            }
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
            *changed = number;
        }
        next.scale = change.scale.unwrap_or(next.scale);
        // A wall is its three numbers.
        if let FeltThing::Wall(wall) = &mut next.environment {
            *wall = next.law;
        }
        next.checked()
    }
}

/// A tissue of the library by its name; a path is none.
fn library_material(library: &Library, name: &str) -> Result<Material, Failure> {
    let materials = library.materials();
    let named = materials.iter().find(|material| material.name == name);
    named.cloned().ok_or_else(|| {
        let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        Failure::bad_input(format_args!(
            "tissue {name:?} is not in the library: take one of {}",
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
        FeelSettings::new(&library(), device, Imperfections::NONE, start)
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
        want.law.order = 0.4;
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
        refused(secret, "take one of prostate-cancerous");
        refused(started(order(0.5)), "`environment` is missing");
        let felt = started(tissue("prostate-cancerous")).expect("known");
        for wrong in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            refused(felt.changed(&library(), &order(wrong)), "not in [0, 1]");
        }
        let device = FeelChange {
            device: Some(DeviceNumbers::default()),
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
