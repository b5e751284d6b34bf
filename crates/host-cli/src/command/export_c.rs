//! `export-c`: an operator, or the law of a tissue, as one header in C99.

mod tissue;

use super::words::{order, parse_order, parse_scheme, rate};
use crate::choice::choice;
use crate::output::Output;
use crate::within::within;
use clap::Args;
use fracdiff::{Operator, OperatorList, Order, Scheme, Seconds};
use fracdiff_c::{CNumber, Header};
use haptic_experiment::Failure;
use haptic_experiment::judge::operator;
use haptic_experiment::parameters::range;
use haptic_experiment::run::write_text;
use haptic_experiment::{Named as _, Precision};
use haptic_quantity::{Time, digits, written};
use serde::Serialize;
use std::path::PathBuf;
use tissue::{Tissue, TissueArguments};

/// Arguments of `export-c`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli export-c --order 0.5 --sample-time 1ms --horizon 1h --name half --out half.h\n\
                  The header needs only stdint.h, no heap and no libm, and gives the same bits as the crate fracdiff: half_init(&h), then \
                  y = half_output(&h, x) and half_advance(&h, x) per sample. A tissue also has muscle_force(&h, x), N at a displacement in m, and \
                  muscle_push(&h, x) behind a surface at 0, with muscle_advance(&h, muscle_depth(x)) after it. \
                  Compile with -ffp-contract=off; -ffast-math and -Ofast are refused."
)]
pub struct Arguments {
    /// Order mu, -2 to 2: positive differentiates, negative integrates
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order, required_unless_present = "tissue")]
    order: Option<f64>,
    #[command(flatten)]
    tissue: TissueArguments,
    /// Time between two samples
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Time,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "full")]
    scheme: Scheme,
    /// How far back a full memory keeps its accuracy [default: 1h]
    #[arg(long, value_parser = within::<Time>(range::MEMORIES), value_name = "TIME", allow_hyphen_values = true)]
    horizon: Option<Time>,
    /// Number type
    #[arg(long, value_parser = choice::<Precision>(), default_value = "f32")]
    precision: Precision,
    /// Prefix of all names in the header
    #[arg(long, default_value = "operator_d")]
    name: String,
    /// Header to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an existing header
    #[arg(long, requires = "out")]
    overwrite: bool,
}

/// The result.
#[derive(Serialize)]
struct Exported {
    name: String,
    /// Its name; null for an operator alone.
    tissue: Option<String>,
    /// K and B of the law.
    stiffness_n_per_m: Option<f64>,
    dissipation_n_s_mu_per_m: Option<f64>,
    order: f64,
    sample_time_s: f64,
    scheme: String,
    /// Of a full memory.
    horizon_s: Option<f64>,
    precision: &'static str,
    coefficients: usize,
    /// Of a full memory: the error of the output in units of the sum of its weighted increments.
    error_bound: Option<f64>,
    /// The file; null if the header is in `header`.
    file: Option<String>,
    header: Option<String>,
}

/// The operator that is exported.
struct What<'a> {
    tissue: Option<&'a Tissue>,
    order: Order,
    /// Samples.
    horizon: f64,
    error_bound: Option<f64>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad parameters; a file that is there, or cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let tissue = self.tissue.resolve()?;
        let mu = match (&tissue, self.order) {
            (Some(tissue), _) => tissue.material.order(),
            (None, given) => order(given.unwrap_or_default())?,
        };
        let t = Seconds(self.sample_time.0);
        rate(t, mu)?;
        let horizon = self.horizon_samples()?;
        let error_bound = match (&tissue, self.scheme) {
            // Of all of its weights, by the design.
            (Some(tissue), Scheme::Full { tolerance, .. }) if tissue.is_composed() => {
                Some(tolerance)
            }
            _ => (self.scheme.error_bound(mu, horizon))
                .map_err(|error| Failure::input_with_advice(error, "give another --scheme"))?,
        };
        let what = What {
            tissue: tissue.as_ref(),
            order: mu,
            horizon,
            error_bound,
        };
        let (header, coefficients) = match self.precision {
            Precision::F32 => self.header::<f32>(&what)?,
            Precision::F64 => self.header::<f64>(&what)?,
        };
        if let Some(path) = &self.out {
            write_text(path, &header, self.overwrite)?;
        }
        let horizon_s = self.horizon_s();
        let in_file = self.out.is_some();
        let exported = Exported {
            name: self.name,
            stiffness_n_per_m: tissue.as_ref().map(|tissue| tissue.law.stiffness),
            dissipation_n_s_mu_per_m: tissue.as_ref().map(|tissue| tissue.law.dissipation),
            tissue: tissue.map(|tissue| tissue.material.name.clone()),
            order: mu.get(),
            sample_time_s: t.0,
            scheme: self.scheme.to_string(),
            horizon_s: error_bound.map(|_| horizon_s),
            precision: self.precision.name(),
            coefficients,
            error_bound,
            file: self.out.map(|path| path.display().to_string()),
            header: (!in_file).then_some(header),
        };
        if let Some(header) = exported.header.as_deref().filter(|_| !output.json) {
            return output.text(&exported, |out| out.write_all(header.as_bytes()));
        }
        output.summary(&exported)
    }

    /// The horizon, s.
    fn horizon_s(&self) -> f64 {
        self.horizon.map_or(3600.0, |horizon| horizon.0)
    }

    /// The horizon in samples.
    fn horizon_samples(&self) -> Result<f64, Failure> {
        let full = matches!(self.scheme, Scheme::Full { .. });
        if self.horizon.is_some() && !full {
            return Err(Failure::bad_input(format_args!(
                "--horizon has no effect on scheme {}: omit it",
                self.scheme
            )));
        }
        let samples = self.horizon_s() / self.sample_time.0;
        if !full || (1.0..=1e12).contains(&samples) {
            return Ok(samples);
        }
        Err(Failure::bad_input(format_args!(
            "horizon {} at a sample time of {} is {} samples, not 1 to 1e12: give --horizon, as in 1h",
            written("horizon_s", self.horizon_s()),
            written("sample_time_s", self.sample_time.0),
            digits(samples, 4)
        )))
    }

    /// The text, and the number of coefficients in it.
    fn header<F: CNumber>(&self, what: &What<'_>) -> Result<(String, usize), Failure> {
        let model = what.tissue.and_then(|tissue| tissue.material.composed());
        let t = Seconds(self.sample_time.0);
        let operator: Operator<F> = operator(model, self.scheme, what.order, t, what.horizon)
            .map_err(|error| Failure::input_with_advice(error, "give another --scheme"))?;
        let list: OperatorList<F> = operator.list().ok_or_else(|| {
            Failure::bad_input(format_args!(
                "scheme {} cannot be exported: give another, as --scheme full",
                self.scheme
            ))
        })?;
        let notes = self.notes(what);
        let header = match what.tissue {
            Some(tissue) => Header::of_law(&self.name, &list, &tissue.law, &notes),
            None => Header::new(&self.name, &list, &notes),
        };
        let header =
            header.map_err(|error| Failure::input_with_advice(error, "give --name, as in half"));
        Ok((header?.to_string(), list.values.len()))
    }

    /// Lines for the comment: what it is, its error, how it was made.
    fn notes(&self, what: &What<'_>) -> Vec<String> {
        let (mu, t) = (what.order, self.sample_time.0);
        let mut notes = match what.tissue {
            Some(tissue) => tissue.notes(&self.name, mu, t),
            None => vec![format!(
                "y = D^{mu} x, sample time {t} s; y has the unit of x times s^-({mu})."
            )],
        };
        notes.push(format!(
            "Scheme {}, {}.",
            self.scheme,
            self.precision.name()
        ));
        if let Some(bound) = what.error_bound {
            notes.push(format!(
                "Error up to {} s: {bound:.1e} of the sum of all weighted increments of x, and rounding.",
                self.horizon_s()
            ));
        }
        let of = match what.tissue {
            Some(tissue) => tissue.options(),
            None => format!("--order {mu}"),
        };
        let horizon = (what.error_bound)
            .map_or_else(String::new, |_| format!("--horizon {}s ", self.horizon_s()));
        notes.push(format!(
            "Made by host-cli {} export-c {of} --sample-time {t}s --scheme {} {horizon}--precision {} --name {}",
            env!("CARGO_PKG_VERSION"),
            self.scheme,
            self.precision.name(),
            self.name
        ));
        notes
    }
}
