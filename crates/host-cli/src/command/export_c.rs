//! `export-c`: an operator, the law of a tissue, or a controller, as one header in C99.

mod controller;

use crate::files::TextFile;
use crate::names::option_of;
use crate::options::Options;
use crate::options::keys;
use crate::output::Output;
use crate::parse::{choice, order, parse_scheme, quantity};
use clap::Args;
use clap::builder::ArgPredicate;
use fracdiff::full_memory::Kernel;
use fracdiff::scheme::DEFAULT_TOLERANCE;
use fracdiff::{Operator, OperatorList, Order, Scheme, Seconds};
use fracdiff_c::{CHeader, CNumber, HeaderError, WallLaw};
use haptic_document::Document;
use haptic_experiment::{Failure, Named as _, Precision, parameters as p};
use haptic_judge::modelled_tissue::ModelledTissue;
use haptic_judge::modelled_tissue::operator;
use haptic_loop::Specimen;
use haptic_quantity::{digits, label, without_unit, written};
use haptic_question::analysis::rate;
use haptic_question::control_loop::controller_of;
use serde_json::{Value, json};

/// Write an operator or a controller as a C99 header, for any microcontroller
///
/// The header needs only stdint.h, no heap and no libm, and gives the same bits as the crate
/// fracdiff. With --name half: `half_init(&h)` once, then y = `half_output(&h, x)` and
/// `half_advance(&h, x)` per sample.
///
/// A tissue also has `half_force(&h, x)`, N at a displacement in m, and `half_push(&h, x)` behind a
/// surface at 0, with `half_advance(&h, half_depth(x))` after it. A controller has
/// `half_output(&c, r, y)` and `half_advance(&c, r, y, applied)`.
///
/// Compile with -ffp-contract=off; -ffast-math and -Ofast are refused.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli export-c --order 0.5 --sample-time 1ms --horizon 1h --name half --out half.h"
)]
pub(crate) struct Arguments {
    /// Order mu, -2 to 2: positive differentiates, negative integrates
    #[arg(long, value_parser = order(), conflicts_with = "controller")]
    order: Option<Order>,
    #[command(flatten)]
    tissue: Options<keys::ExportC>,
    /// Controller file (*.toml), or notation, as in '2+3/s^0.9+0.1s^0.5'
    #[arg(
        long,
        value_name = "FILE|FUNCTION",
        allow_hyphen_values = true,
        help_heading = "Controller"
    )]
    controller: Option<String>,
    /// Time between two samples [default: from the controller file]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", p::SAMPLE_TIME.range()))]
    sample_time: Option<f64>,
    /// Fractional operator, see `host-cli --help` [default: full, or from the controller file]
    #[arg(long, value_parser = parse_scheme)]
    scheme: Option<Scheme>,
    /// How far back a full memory keeps its accuracy [default: 1h, or from the controller file]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", p::MEMORY.range()))]
    horizon: Option<f64>,
    /// Number type of the header, float or double
    #[arg(long, value_parser = choice::<Precision>(), default_value = "f32")]
    precision: Precision,
    /// Prefix of all names in the header
    #[arg(
        long,
        default_value = "operator_d",
        default_value_if("controller", ArgPredicate::IsPresent, "controller")
    )]
    name: String,
    #[command(flatten)]
    file: TextFile,
}

/// Memory of an operator where none is given, s.
const HORIZON_S: f64 = 3600.0;

struct What<'a> {
    tissue: Option<&'a Tissue>,
    order: Order,
    scheme: Scheme,
    sample_time_s: f64,
    /// Samples for which a full memory keeps its accuracy.
    horizon: f64,
    error_bound: Option<f64>,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let pressed = self.tissue.clone().over(Document::new("relax"))?;
        if let Some(text) = &self.controller {
            let mut setup = controller_of(text, self.sample_time)?;
            setup.scheme = self.scheme.unwrap_or(setup.scheme);
            alone(&pressed, "--controller")?;
            return self.controller(setup, output);
        }
        if self.order.is_some() {
            alone(&pressed, "--order")?;
        }
        let tissue = tissue(&pressed)?;
        let of_tissue = tissue.as_ref().map(|tissue| tissue.material.order());
        let mu = of_tissue
            .or(self.order)
            .ok_or_else(|| Failure::bad_input("no order: give --order or --tissue"))?;
        let kernel = Kernel::Grunwald;
        let tolerance = DEFAULT_TOLERANCE;
        let scheme = self.scheme.unwrap_or(Scheme::Full { kernel, tolerance });
        let t = (self.sample_time.map(Seconds))
            .ok_or_else(|| Failure::bad_input("no sample time: give --sample-time, as in 1ms"))?;
        rate(t, mu)?;
        let horizon = self.horizon_samples(scheme, t)?;
        let error_bound = match (&tissue, scheme) {
            // Of all of its weights, by the design.
            (Some(tissue), Scheme::Full { tolerance, .. }) if tissue.is_composed() => {
                Some(tolerance)
            }
            _ => (scheme.error_bound(mu, horizon))
                .map_err(|error| Failure::input_with_advice(error, "give another --scheme"))?,
        };
        let what = What {
            tissue: tissue.as_ref(),
            order: mu,
            scheme,
            sample_time_s: t.0,
            horizon,
            error_bound,
        };
        let (header, coefficients) = match self.precision {
            Precision::F32 => self.header::<f32>(&what)?,
            Precision::F64 => self.header::<f64>(&what)?,
        };
        self.write(
            header,
            output,
            json!({
                "tissue": tissue.as_ref().map(|tissue| &tissue.material.name),
                "stiffness_n_per_m": tissue.as_ref().map(|tissue| tissue.law.stiffness),
                "dissipation_n_s_mu_per_m": tissue.as_ref().map(|tissue| tissue.law.dissipation),
                "depth_map": tissue.as_ref().and_then(|tissue| tissue.law.depth_map),
                "order": mu.get(),
                "sample_time_s": t.0,
                "scheme": scheme.to_string(),
                // Of a full memory, as the error of the output in units of the sum of its weighted increments.
                "horizon_s": error_bound.map(|_| self.horizon_s()),
                "coefficients": coefficients,
                "error_bound": error_bound,
            }),
        )
    }

    /// Writes the header, and says what it is.
    fn write(&self, header: String, output: Output, mut what: Value) -> Result<(), Failure> {
        let file = self.file.write(&header)?;
        if file.is_none() && !output.json {
            return output.text(&(), |out| out.write_all(header.as_bytes()));
        }
        let header = file.is_none().then_some(header);
        what["name"] = json!(self.name);
        what["precision"] = json!(self.precision.name());
        what["file"] = json!(file);
        what["header"] = json!(header);
        output.report(&what)
    }

    fn horizon_s(&self) -> f64 {
        self.horizon.unwrap_or(HORIZON_S)
    }

    fn horizon_samples(&self, scheme: Scheme, sample_time: Seconds) -> Result<f64, Failure> {
        let full = matches!(scheme, Scheme::Full { .. } | Scheme::FullBdf2 { .. });
        if self.horizon.is_some() && !full {
            return Err(Failure::bad_input(format_args!(
                "--horizon has no effect on scheme {scheme}: omit it"
            )));
        }
        let samples = self.horizon_s() / sample_time.0;
        if !full || (1.0..=1e12).contains(&samples) {
            return Ok(samples);
        }
        Err(Failure::bad_input(format_args!(
            "horizon {} at a sample time of {} is {} samples, not 1 to 1e12: give --horizon, as in 1h",
            written("horizon_s", self.horizon_s()),
            written("sample_time_s", sample_time.0),
            digits(samples, 4)
        )))
    }

    /// The text, and the number of coefficients in it.
    fn header<F: CNumber>(&self, what: &What<'_>) -> Result<(String, usize), Failure> {
        let model = what.tissue.and_then(|tissue| tissue.material.composed());
        let t = Seconds(what.sample_time_s);
        let operator: Operator<F> = operator(model, what.scheme, what.order, t, what.horizon)
            .map_err(|error| Failure::input_with_advice(error, "give another --scheme"))?;
        let list = OperatorList::from(&operator);
        let notes = self.notes(what);
        let law = what.tissue.map(|tissue| &tissue.law);
        let header = CHeader::new(&self.name, &list, law, &notes);
        let coefficients = list.values.len() + list.filter.len();
        Ok((header.map_err(named)?.to_string(), coefficients))
    }

    /// Lines for the comment: what it is, its error, how it was made.
    fn notes(&self, what: &What<'_>) -> Vec<String> {
        let (mu, t) = (what.order, what.sample_time_s);
        let mut notes = match what.tissue {
            Some(tissue) => tissue.notes(&self.name, mu, t),
            None => vec![format!(
                "y = D^{mu} x, sample time {t} s; y has the unit of x times s^-({mu})."
            )],
        };
        notes.push(format!(
            "Scheme {}, {}.",
            what.scheme,
            self.precision.name()
        ));
        if let Some(bound) = what.error_bound {
            notes.push(format!(
                "Error up to {} s: {bound:.1e} of the sum of all weighted increments of x, and rounding.",
                self.horizon_s()
            ));
        }
        let source = match what.tissue {
            Some(tissue) => tissue.options(),
            None => format!("--order {mu}"),
        };
        let horizon = (what.error_bound)
            .map_or_else(String::new, |_| format!("--horizon {}s ", self.horizon_s()));
        notes.push(format!(
            "Made by host-cli {} export-c {source} --sample-time {t}s --scheme {} {horizon}--precision {} --name {}",
            env!("CARGO_PKG_VERSION"),
            what.scheme,
            self.precision.name(),
            self.name
        ));
        notes
    }
}

/// A name that is refused.
fn named(error: HeaderError) -> Failure {
    Failure::input_with_advice(error, "give --name, as in half")
}

struct Tissue {
    material: ModelledTissue,
    law: WallLaw,
    specimen: Specimen,
}

/// Refuses keys of a tissue if another option chooses the law to write.
fn alone(pressed: &Document, other: &str) -> Result<(), Failure> {
    pressed.given().next().map_or(Ok(()), |of_tissue| {
        Err(Failure::bad_input(format_args!(
            "`{of_tissue}` is of a tissue and has no effect with {other}: omit one of them"
        )))
    })
}

/// The tissue that is named, pressed as the other options say.
fn tissue(pressed: &Document) -> Result<Option<Tissue>, Failure> {
    let piece = haptic_experiment::pressed(pressed)?;
    Ok(piece.map(|piece| {
        let (stiffness, dissipation) = piece.spring_and_damper();
        Tissue {
            material: *piece.material,
            law: WallLaw {
                stiffness,
                dissipation,
                depth_map: piece.specimen.depth_map().map(|map| map.numbers()),
            },
            specimen: piece.specimen,
        }
    }))
}

impl Tissue {
    /// True for a model of more elements than a spring-pot beside a spring.
    const fn is_composed(&self) -> bool {
        self.material.composed().is_some()
    }

    fn notes(&self, name: &str, order: Order, sample_time_s: f64) -> Vec<String> {
        let WallLaw {
            stiffness,
            dissipation,
            depth_map,
        } = self.law;
        let seen = if depth_map.is_some() { "e(x)" } else { "x" };
        let memory = match self.material.composed() {
            Some(model) => format!("y = P {seen}, the one memory of the model {}", model.kind()),
            None => format!("y = D^{order} {seen}"),
        };
        let loading = self.specimen.loading();
        let sizes = self.sizes();
        let sizes = sizes.map(|(key, size, unit)| format!(", {size} {unit} {}", label(key)));
        let (kind, sizes) = (loading.kind.name(), sizes.collect::<String>());
        let bonded = if loading.bonded { ", bonded" } else { "" };
        let use_of = match depth_map {
            None => format!("{name}_force(&h, x), or {name}_push(&h, x) behind a surface at 0"),
            Some(_) => {
                format!("{name}_push(&h, x) behind a surface at 0, e(x) = {name}_depth_map(x),")
            }
        };
        vec![
            format!(
                "The tissue {}, {kind}{sizes}{bonded}, sample time {sample_time_s} s.",
                self.material.name
            ),
            format!(
                "f = -(K {seen} + B y) in N at the displacement x in m: K = {stiffness} N/m, B = {dissipation} N s^{order}/m, {memory}."
            ),
            format!("{use_of} and {name}_advance(&h, {name}_depth(x)) after it."),
        ]
    }

    /// Each size that is given: its key, and the unit in that.
    fn sizes(&self) -> impl Iterator<Item = (&'static str, f64, &'static str)> {
        let loading = self.specimen.loading();
        let sizes = [
            (p::AREA.key, loading.area_m2),
            (p::THICKNESS.key, loading.thickness_m),
            (p::INDENTER_RADIUS.key, loading.radius_m),
            (p::HALF_ANGLE.key, loading.half_angle_rad),
        ];
        let given = sizes.into_iter();
        given.filter_map(|(key, size)| Some((key, size?, &key[without_unit(key).len() + 1..])))
    }

    fn options(&self) -> String {
        let loading = self.specimen.loading();
        let sizes = self.sizes();
        let sizes = sizes.map(|(key, size, unit)| format!(" --{} {size}{unit}", option_of(key)));
        let sizes: String = sizes.collect();
        let bonded = if loading.bonded { " --bonded" } else { "" };
        let (name, kind) = (&self.material.name, loading.kind.name());
        format!("--tissue {name} --loading {kind}{sizes}{bonded}")
    }
}
