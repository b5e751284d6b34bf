//! The tissue whose law is exported.

use crate::command::materials::folder::library;
use crate::within::within;
use clap::Args;
use fracdiff::Order;
use fracdiff_c::Law;
use haptic_experiment::Failure;
use haptic_experiment::ModelledTissue;
use haptic_experiment::parameters as p;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_quantity::{Area, Length};
use std::path::PathBuf;

/// Options of the tissue.
#[derive(Debug, Args)]
pub(super) struct TissueArguments {
    /// Tissue by name or file, instead of an order
    #[arg(long, value_name = "NAME")]
    #[arg(conflicts_with = "order", help_heading = "Tissue")]
    tissue: Option<String>,
    #[arg(long, help = p::LIBRARY.help, value_name = "DIR", requires = "tissue", help_heading = "Tissue")]
    library: Option<PathBuf>,
    #[arg(long, value_parser = within::<Area>(p::AREA.range()), help = p::AREA.help, default_value = p::AREA.shown, requires = "tissue", allow_hyphen_values = true, help_heading = "Tissue")]
    area: Area,
    #[arg(long, value_parser = within::<Length>(p::THICKNESS.range()), help = p::THICKNESS.help, default_value = p::THICKNESS.shown, requires = "tissue", allow_hyphen_values = true, help_heading = "Tissue")]
    thickness: Length,
}

/// A piece of tissue.
pub(super) struct Tissue {
    pub(super) material: ModelledTissue,
    pub(super) law: Law,
    area_m2: f64,
    thickness_m: f64,
}

impl TissueArguments {
    /// The piece, if one is asked for.
    ///
    /// # Errors
    /// A tissue that there is not; a piece without size.
    pub(super) fn resolve(&self) -> Result<Option<Tissue>, Failure> {
        let Some(name) = &self.tissue else {
            return Ok(None);
        };
        let library = library(self.library.as_deref())?;
        let material = ModelledTissue::new(library.find(name).map_err(Failure::input)?)?;
        let piece = Specimen::new(SquareMetres(self.area.0), Metres(self.thickness.0));
        let piece = piece
            .map_err(|error| Failure::input_with_advice(error, "change --area or --thickness"))?;
        let (stiffness, dissipation) =
            material.spring_and_damper(piece.area().0 / piece.thickness().0);
        Ok(Some(Tissue {
            material,
            law: Law {
                stiffness,
                dissipation,
            },
            area_m2: self.area.0,
            thickness_m: self.thickness.0,
        }))
    }
}

impl Tissue {
    /// True for a model of more elements than a spring-pot beside a spring.
    pub(super) const fn is_composed(&self) -> bool {
        self.material.composed().is_some()
    }

    /// What the header is of.
    pub(super) fn notes(&self, name: &str, order: Order, sample_time_s: f64) -> Vec<String> {
        let Law {
            stiffness,
            dissipation,
        } = self.law;
        let memory = match self.material.composed() {
            Some(model) => format!("y = P x, the one memory of the model {}", model.kind()),
            None => format!("y = D^{order} x"),
        };
        vec![
            format!(
                "The tissue {}, a piece of {} m2 and {} m thickness, sample time {sample_time_s} s.",
                self.material.name, self.area_m2, self.thickness_m
            ),
            format!(
                "f = -(K x + B y) in N at the displacement x in m: K = {stiffness} N/m, B = {dissipation} N s^{order}/m, {memory}."
            ),
            format!(
                "{name}_force(&h, x), or {name}_push(&h, x) behind a surface at 0 and {name}_advance(&h, {name}_depth(x)) after it."
            ),
        ]
    }

    /// The options that made it.
    pub(super) fn options(&self) -> String {
        format!(
            "--tissue {} --area {}m2 --thickness {}m",
            self.material.name, self.area_m2, self.thickness_m
        )
    }
}
