//! What is felt: a tissue or a wall, a device, ghosts; and changes of it.

use super::ranges;
use haptic_experiment::parameters;
use haptic_experiment::{Failure, Imperfections, ModelledTissue};
use haptic_tissue::{Library, Material, Model};
use serde::{Deserialize, Serialize};

/// A tissue of the library, or a wall of three numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum FeltThing {
    /// By name.
    Tissue(String),
    /// A one-sided wall.
    Wall(WallNumbers),
}

/// K, B and μ of a wall; the defaults of the ranges where nothing is said.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WallNumbers {
    /// μ.
    pub order: f64,
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
}

impl Default for WallNumbers {
    fn default() -> Self {
        Self {
            order: ranges::ORDER.default,
            stiffness_n_per_m: ranges::STIFFNESS.default,
            dissipation_n_s_mu_per_m: ranges::DISSIPATION.default,
        }
    }
}

/// The simulated device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeviceNumbers {
    /// m, kg.
    pub mass_kg: f64,
    /// b, N·s/m.
    pub damping_n_s_per_m: f64,
}

impl Default for DeviceNumbers {
    fn default() -> Self {
        Self {
            mass_kg: ranges::MASS.default,
            damping_n_s_per_m: ranges::DAMPING.default,
        }
    }
}

/// The same motion felt by another operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ghost {
    /// The last second alone.
    Short,
    /// The dissertation's A₃.
    A3,
}

impl Ghost {
    /// Both, in the order of the channels.
    pub const ALL: [Self; 2] = [Self::Short, Self::A3];
}

/// All that `feel.start` says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeelStart {
    /// The tissue or wall.
    pub environment: FeltThing,
    /// The device.
    #[serde(default)]
    pub device: Option<DeviceNumbers>,
    /// The ghosts.
    #[serde(default = "all_ghosts")]
    pub ghosts: Vec<Ghost>,
    /// μ, if it is not that of the environment.
    #[serde(default)]
    pub order: Option<f64>,
    /// K, N/m, likewise.
    #[serde(default)]
    pub stiffness_n_per_m: Option<f64>,
    /// B, N·s^μ/m, likewise.
    #[serde(default)]
    pub dissipation_n_s_mu_per_m: Option<f64>,
    /// Factor on K and B.
    #[serde(default)]
    pub scale: Option<f64>,
}

impl FeelStart {
    /// A tissue or wall as it is.
    #[must_use]
    pub fn new(environment: FeltThing) -> Self {
        Self {
            environment,
            device: None,
            ghosts: all_ghosts(),
            order: None,
            stiffness_n_per_m: None,
            dissipation_n_s_mu_per_m: None,
            scale: None,
        }
    }
}

fn all_ghosts() -> Vec<Ghost> {
    Ghost::ALL.to_vec()
}

/// A change of it; what is not named stays. Another environment brings its own numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FeelChange {
    /// Another tissue or wall.
    pub environment: Option<FeltThing>,
    /// μ.
    pub order: Option<f64>,
    /// K, N/m.
    pub stiffness_n_per_m: Option<f64>,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: Option<f64>,
    /// Factor on K and B.
    pub scale: Option<f64>,
    /// The ghosts.
    pub ghosts: Option<Vec<Ghost>>,
}

/// What is felt, checked but for its stability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeelSettings {
    /// The tissue or wall.
    pub environment: FeltThing,
    /// A few words for people.
    pub title: String,
    /// μ.
    pub order: f64,
    /// True if the order can be changed: of one spring-pot beside a spring, not of a model with more elements.
    pub order_free: bool,
    /// K, N/m, before the factor.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, before the factor.
    pub dissipation_n_s_mu_per_m: f64,
    /// Factor on K and B.
    pub scale: f64,
    /// The device.
    #[serde(flatten)]
    pub device: DeviceNumbers,
    /// The ghosts that there are.
    pub ghosts: Vec<Ghost>,
    /// The model of a tissue with more elements, whose memory is felt; `None` for D^μ.
    #[serde(skip)]
    pub model: Option<Model>,
    /// Friction, delay, lag and sensors of the device: those of the server's device file.
    #[serde(skip)]
    pub imperfections: Imperfections,
}

impl FeelSettings {
    /// As asked for.
    ///
    /// # Errors
    /// A tissue that there is not, a number outside its range.
    pub fn new(library: &Library, start: FeelStart) -> Result<Self, Failure> {
        let device = start.device.unwrap_or_default();
        let DeviceNumbers {
            mass_kg,
            damping_n_s_per_m,
        } = device;
        ranges::MASS.checked("mass_kg", mass_kg)?;
        ranges::DAMPING.checked("damping_n_s_per_m", damping_n_s_per_m)?;
        let change = FeelChange {
            order: start.order,
            stiffness_n_per_m: start.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: start.dissipation_n_s_mu_per_m,
            scale: start.scale,
            ..FeelChange::default()
        };
        Self::of(library, start.environment, device, start.ghosts)?.changed(library, &change)
    }

    fn of(
        library: &Library,
        environment: FeltThing,
        device: DeviceNumbers,
        ghosts: Vec<Ghost>,
    ) -> Result<Self, Failure> {
        let settings = match &environment {
            FeltThing::Tissue(name) => {
                let material = library_material(library, name)?;
                let title = material.description.clone();
                let tissue = ModelledTissue::new(material)?;
                let (stiffness, dissipation) = tissue.spring_and_damper(specimen_shape());
                Self {
                    environment,
                    title,
                    order: tissue.order().get(),
                    order_free: tissue.composed().is_none(),
                    stiffness_n_per_m: stiffness,
                    dissipation_n_s_mu_per_m: dissipation,
                    scale: ranges::SCALE.default,
                    device,
                    ghosts,
                    model: tissue.composed().cloned(),
                    imperfections: Imperfections::NONE,
                }
            }
            FeltThing::Wall(wall) => Self {
                title: "a wall".to_owned(),
                order: wall.order,
                order_free: true,
                stiffness_n_per_m: wall.stiffness_n_per_m,
                dissipation_n_s_mu_per_m: wall.dissipation_n_s_mu_per_m,
                scale: ranges::SCALE.default,
                device,
                ghosts,
                model: None,
                imperfections: Imperfections::NONE,
                environment,
            },
        };
        settings.checked()
    }

    /// Itself, if its numbers are in their ranges; without the ghosts that a model with more elements has not.
    fn checked(mut self) -> Result<Self, Failure> {
        if self.model.is_none() {
            ranges::ORDER.checked("order", self.order)?;
            ranges::STIFFNESS.checked("stiffness_n_per_m", self.stiffness_n_per_m)?;
            ranges::DISSIPATION
                .checked("dissipation_n_s_mu_per_m", self.dissipation_n_s_mu_per_m)?;
        } else {
            self.ghosts.clear();
        }
        ranges::SCALE.checked("scale", self.scale)?;
        let asked = std::mem::take(&mut self.ghosts);
        self.ghosts = Ghost::ALL
            .into_iter()
            .filter(|ghost| asked.contains(ghost))
            .collect();
        Ok(self)
    }

    /// The same with a change.
    ///
    /// # Errors
    /// A tissue that there is not, a number outside its range, a number that this tissue's model has not.
    pub fn changed(&self, library: &Library, change: &FeelChange) -> Result<Self, Failure> {
        let ghosts = change.ghosts.clone().unwrap_or_else(|| self.ghosts.clone());
        let mut next = match &change.environment {
            Some(environment) => Self {
                imperfections: self.imperfections,
                ..Self::of(library, environment.clone(), self.device, ghosts)?
            },
            None => Self {
                ghosts,
                ..self.clone()
            },
        };
        let numbers = [
            ("order", change.order),
            ("stiffness_n_per_m", change.stiffness_n_per_m),
            ("dissipation_n_s_mu_per_m", change.dissipation_n_s_mu_per_m),
        ];
        if let (Some(model), Some((name, _))) = (
            &next.model,
            numbers.iter().find(|(_, number)| number.is_some()),
        ) {
            return Err(Failure::bad_input(format_args!(
                "`{name}` belongs to one spring-pot beside a spring, and this tissue is a {}: change `scale`, or take \
                 another tissue",
                model.kind().name()
            )));
        }
        next.order = change.order.unwrap_or(next.order);
        next.stiffness_n_per_m = change.stiffness_n_per_m.unwrap_or(next.stiffness_n_per_m);
        let dissipation = change.dissipation_n_s_mu_per_m;
        next.dissipation_n_s_mu_per_m = dissipation.unwrap_or(next.dissipation_n_s_mu_per_m);
        next.scale = change.scale.unwrap_or(next.scale);
        // A wall is its three numbers.
        if let FeltThing::Wall(wall) = &mut next.environment {
            *wall = WallNumbers {
                order: next.order,
                stiffness_n_per_m: next.stiffness_n_per_m,
                dissipation_n_s_mu_per_m: next.dissipation_n_s_mu_per_m,
            };
        }
        next.checked()
    }
}

/// A tissue of the library by its name; a path is none.
fn library_material(library: &Library, name: &str) -> Result<Material, Failure> {
    let named = library
        .materials()
        .iter()
        .find(|material| material.name == name);
    named.cloned().ok_or_else(|| {
        let known: Vec<&str> = library
            .materials()
            .iter()
            .map(|m| m.name.as_str())
            .collect();
        Failure::bad_input(format_args!(
            "tissue {name:?} is not in the library: take one of {}",
            known.join(", ")
        ))
    })
}

/// A/ℓ of the usual specimen, m.
pub(crate) fn specimen_shape() -> f64 {
    parameters::AREA.default_number() / parameters::THICKNESS.default_number()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn library() -> Library {
        Library::load(None).expect("built in")
    }

    fn tissue(name: &str) -> FeelStart {
        FeelStart::new(FeltThing::Tissue(name.to_owned()))
    }

    #[test]
    fn a_tissue_brings_its_numbers_and_a_change_keeps_the_others() {
        let library = library();
        let felt = FeelSettings::new(&library, tissue("prostate-cancerous")).expect("known");
        assert_eq!((felt.order, felt.stiffness_n_per_m), (0.2247, 0.0));
        assert!((felt.dissipation_n_s_mu_per_m - 173.0).abs() < 1e-9);
        let change = FeelChange {
            order: Some(0.4),
            ..FeelChange::default()
        };
        let next = felt.changed(&library, &change).expect("in range");
        let want = FeelSettings {
            order: 0.4,
            ..felt.clone()
        };
        assert_eq!(next, want);
        let other = FeelChange {
            environment: Some(FeltThing::Tissue("prostate-healthy".to_owned())),
            ..FeelChange::default()
        };
        let healthy = next.changed(&library, &other).expect("known");
        assert_eq!((healthy.order, healthy.scale), (0.2154, 1.0));
    }

    #[test]
    fn a_start_with_its_numbers_is_a_start_and_a_change() {
        let library = library();
        let change = FeelChange {
            order: Some(0.4),
            scale: Some(2.0),
            ..FeelChange::default()
        };
        let felt = FeelSettings::new(&library, tissue("prostate-cancerous")).expect("known");
        let start = FeelStart {
            order: Some(0.4),
            scale: Some(2.0),
            ..tissue("prostate-cancerous")
        };
        let at_once = FeelSettings::new(&library, start).expect("in range");
        assert_eq!(at_once, felt.changed(&library, &change).expect("in range"));
        let muscle = FeelStart {
            order: Some(0.4),
            ..tissue("fish-muscle")
        };
        assert!(
            FeelSettings::new(&library, muscle).is_err(),
            "no single order"
        );
    }

    #[test]
    fn what_is_out_of_range_or_unknown_is_refused_in_a_sentence() {
        let library = library();
        let error = FeelSettings::new(&library, tissue("../secret.toml")).expect_err("a path");
        assert!(
            error.to_string().contains("take one of prostate-cancerous"),
            "{error}"
        );
        let felt = FeelSettings::new(&library, tissue("prostate-cancerous")).expect("known");
        for wrong in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            let change = FeelChange {
                order: Some(wrong),
                ..FeelChange::default()
            };
            let error = felt.changed(&library, &change).expect_err("out of range");
            assert!(error.to_string().contains("not in [0, 1]"), "{error}");
        }
    }

    #[test]
    fn a_model_with_more_elements_has_its_own_memory_and_no_ghosts() {
        let library = library();
        let muscle = FeelSettings::new(&library, tissue("fish-muscle")).expect("known");
        assert!(!muscle.order_free && muscle.ghosts.is_empty() && muscle.model.is_some());
        let change = FeelChange {
            order: Some(0.4),
            ..FeelChange::default()
        };
        let error = muscle
            .changed(&library, &change)
            .expect_err("no single order");
        assert!(error.to_string().contains("change `scale`"), "{error}");
    }
}
