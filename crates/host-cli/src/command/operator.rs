//! `weights`: the impulse response of an operator; `differintegrate`: a column of a table to a fractional order.

use crate::output::{Output, note};
use crate::parse::{order, parse_scheme, quantity, whole};
use crate::table;
use clap::Args;
use fracdiff::batch::uneven;
use fracdiff::full_memory::Kernel;
use fracdiff::scheme::DEFAULT_TOLERANCE;
use fracdiff::{Channel, Operator, Order, Scheme, SchemeError, Seconds, grunwald_weights};
use haptic_document::short;
use haptic_experiment::{Failure, parameters};
use haptic_question::analysis::{rate, sample_time_of};
use measured_table::{RecordColumns, read_record};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Print the impulse response of an operator
///
/// The response is that of P in D^mu = T^(-mu) P, without a unit.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli weights --order 0.5 --scheme grunwald:5 --count 5")]
pub(crate) struct Weights {
    /// Order mu, -2 to 2
    #[arg(long, value_parser = order())]
    order: Order,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    scheme: Scheme,
    /// Number of weights, from the newest sample backwards
    #[arg(long, default_value_t = 10, value_parser = whole::<usize>(1..=10_000_000))]
    count: usize,
    /// Sample time, for a scheme with frequencies in Hz
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::SAMPLE_TIME.range()))]
    sample_time: Option<f64>,
}

impl Weights {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mu = self.order;
        let weights: Vec<f64> = if self.scheme == Scheme::Exact {
            grunwald_weights(mu).take(self.count).collect()
        } else {
            let t = sample_time_of(self.scheme, self.sample_time)?;
            let rate = rate(t, mu)?;
            let operator: Operator<f64> = self
                .scheme
                .build(mu, t, 1.05 * self.count as f64)
                .map_err(Failure::input)?;
            let mut channel = Channel::new(operator);
            let impulse = std::iter::once(1.0).chain(std::iter::repeat(0.0));
            impulse
                .take(self.count)
                .map(|x| channel.step(x) / rate)
                .collect()
        };
        let scheme = self.scheme.to_string();
        let result = json!({"order": mu.get(), "scheme": scheme, "weights": weights});
        output.text(&result, |out| {
            writeln!(out, "lag,weight")?;
            let mut weights = weights.iter().enumerate();
            weights.try_for_each(|(lag, weight)| writeln!(out, "{lag},{weight}"))
        })
    }
}

/// Differentiate or integrate a CSV column to a fractional order
///
/// The file needs a header. The signal is zero before its first sample, unless --caputo is given.
/// Uneven times are taken as they are, and stand beside the result.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli differintegrate --order 0.5 --sample-time 1ms signal.csv > half.csv"
)]
pub(crate) struct Differintegrate {
    /// Order mu, -2 to 2: positive differentiates, negative integrates
    #[arg(long, value_parser = order())]
    order: Order,
    /// Time between two rows [default: as the table says]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::SAMPLE_TIME.range()))]
    sample_time: Option<f64>,
    /// Fractional operator, see `host-cli --help`; here `exact` sums the whole history [default:
    /// full; piecewise-linear where the times are uneven, which it takes as they are]
    #[arg(long, value_parser = parse_scheme)]
    scheme: Option<Scheme>,
    /// Subtract the first value: the Caputo derivative, for an order above 0 and at most 1
    #[arg(long)]
    caputo: bool,
    /// Column to take, by the name in the header
    #[arg(long, value_name = "NAME", default_value = "x")]
    column: String,
    /// CSV file; `-` for standard input, the default
    file: Option<PathBuf>,
}

impl Differintegrate {
    /// Runs the command. The whole input is read and checked before anything is printed.
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mu = self.order;
        let path = self.file.as_deref().unwrap_or(Path::new("-"));
        if self.caputo && !(mu.get() > 0.0 && mu.get() <= 1.0) {
            return Err(Failure::bad_input(format_args!(
                "--caputo takes an order above 0 and at most 1, not {mu}: beyond 1 the first slope is needed too; omit it"
            )));
        }
        let columns = ["time_s", &self.column].map(str::to_owned);
        let signal = table::read(path, columns, |columns, bytes| {
            let found = read_record(bytes, columns.each_ref().map(String::as_str));
            let remedy = "give --column the column to take";
            found.map_err(|error| format!("{}; {remedy}", short(&error.to_string())))
        })?;
        if let Some(rows) = signal.gaps() {
            let what = format_args!("{rows}: no value, or NaN: give a number in every row");
            return Err(table::wrong(path, what));
        }
        let t = self.step(path, &signal)?;
        rate(t, mu)?;
        let off = table::uneven_row(path, &signal, t.0)?;
        let [time_s, x] = signal.columns;
        let reference = if self.caputo { x[0] } else { 0.0 };
        let times = off.zip(Some(time_s));
        let kernel = match &times {
            None => Kernel::Grunwald,
            Some(_) => Kernel::PiecewiseLinear,
        };
        let tolerance = DEFAULT_TOLERANCE;
        let scheme = self.scheme.unwrap_or(Scheme::Full { kernel, tolerance });
        let duration_s = t.0 * x.len() as f64;
        // A whole derivative needs no more than its last samples.
        let forgets = mu.get() < 0.0 || mu.get().fract() > 0.0;
        let short = scheme.memory_s(t).filter(|memory_s| *memory_s < duration_s);
        if let Some(memory_s) = short.filter(|_| forgets) {
            let memory_s = (memory_s * 1e6).round() / 1e6;
            output.warn(&format!(
                "{scheme} remembers {memory_s} s, the table lasts {duration_s} s: --scheme full remembers everything"
            ));
        }
        let y = match &times {
            None => differintegrate(scheme, mu, t, &x, reference).map_err(Failure::input)?,
            Some((row, time_s)) => {
                let is_lines = matches!(
                    scheme,
                    Scheme::Full {
                        kernel: Kernel::PiecewiseLinear,
                        ..
                    }
                );
                let line = signal.lines[*row];
                if self.sample_time.is_some() {
                    let what = format_args!(
                        "the times are uneven, most of all at line {line}, and count: omit --sample-time, or remove the column of time"
                    );
                    return Err(table::wrong(path, what));
                }
                if !is_lines || mu.get() >= 1.0 {
                    let what = format_args!(
                        "the times are uneven, most of all at line {line}, and {scheme} of order {mu} needs even ones: give --scheme piecewise-linear, for an order below 1, or resample the table"
                    );
                    return Err(table::wrong(path, what));
                }
                if self.scheme.is_none() {
                    let what = format!(
                        "the times are uneven, most of all at line {line}: straight lines between the rows (piecewise-linear)"
                    );
                    output.warn(&what);
                }
                as_they_are(mu, time_s, &x, reference)?
            }
        };
        if let Some(n) = y.iter().position(|y| !y.is_finite()) {
            return Err(Failure::bad_input(format_args!(
                "the result of row {} is beyond 1.8e308: scale the column down",
                n + 1
            )));
        }
        let result = json!({
            "order": mu.get(),
            "scheme": scheme.to_string(),
            // One of the two is null.
            "sample_time_s": off.is_none().then_some(t.0),
            "time_s": times.as_ref().map(|(_, time_s)| time_s),
            "x": x,
            "y": y,
        });
        output.text(&result, |out| {
            let times = times.as_ref().map(|(_, time_s)| time_s);
            writeln!(out, "{}x,y", times.map_or("", |_| "time_s,"))?;
            for (n, (x, y)) in x.iter().zip(&y).enumerate() {
                let time =
                    times.map_or_else(String::new, |time_s| format!("{},", json!(time_s[n])));
                writeln!(out, "{time}{},{}", json!(x), json!(y))?;
            }
            Ok(())
        })
    }
}

impl Differintegrate {
    /// The time between two rows, as it was given, else as the table has it, on the whole.
    fn step(&self, path: &Path, signal: &RecordColumns<2>) -> Result<Seconds, Failure> {
        let time_s = &signal.columns[0];
        let step = match &time_s[..] {
            [first, .., last] => Some((last - first) / (time_s.len() - 1) as f64),
            _ => None,
        };
        let step = self.sample_time.or(step).map(Seconds);
        step.ok_or_else(|| table::wrong(path, "there are no times in it: give --sample-time"))
    }
}

/// D^μ of x − reference at uneven times.
fn as_they_are(mu: Order, time_s: &[f64], x: &[f64], reference: f64) -> Result<Vec<f64>, Failure> {
    if x.len() > UNEVEN_AT_ONCE {
        let seconds = 2.0 * libm::pow(x.len() as f64 / UNEVEN_AT_ONCE as f64, 2.0);
        let what = format_args!("the times are uneven, so this takes about {seconds:.0} s");
        note("note", what);
    }
    if mu.get() > 0.0 && (x[0] - reference).abs() > 0.0 {
        return Err(Failure::bad_input(format_args!(
            "the signal jumps from 0 to {} in its first row, where its derivative is infinite: give --caputo, or begin the table at 0",
            x[0]
        )));
    }
    uneven(mu, time_s, x, reference).map_err(Failure::input)
}

/// Number of samples at uneven times that need one or two seconds.
const UNEVEN_AT_ONCE: usize = 10_000;

/// Memories of more samples than this are summed by FFT, all at once: from here on that is faster.
const DIRECT_MOST: usize = 512;

/// D^μ of x − reference.
fn differintegrate(
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
    x: &[f64],
    reference: f64,
) -> Result<Vec<f64>, SchemeError> {
    let is_long = |length: usize| length.min(x.len()) > DIRECT_MOST;
    // No filter is exact, but the sum over a whole record is.
    let by_fft =
        scheme == Scheme::Exact || matches!(scheme, Scheme::Grunwald { length } if is_long(length));
    if by_fft && let Some(sum) = scheme.batch(order, sample_time)? {
        return Ok(sum.relative_to(reference).run(x));
    }
    let operator: Operator<f64> = scheme.build(order, sample_time, 1.05 * x.len() as f64)?;
    let mut channel = Channel::new(operator);
    channel.reset_to(reference);
    Ok(x.iter().map(|&x| channel.step(x)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_memories_by_fft_are_the_operator_run_over_the_record() {
        let x: Vec<f64> = (0..6000)
            .map(|n| 1.0 + (f64::from(n) * 0.1).sin())
            .collect();
        let (order, t) = (Order::new(0.4).expect("valid"), Seconds(1e-3));
        for (length, direct) in [(DIRECT_MOST + 1, DIRECT_MOST + 1), (10_000, 6000)] {
            let scheme = Scheme::Grunwald { length };
            let have = differintegrate(scheme, order, t, &x, x[0]).expect("valid");
            let operator = fracdiff::ShortMemoryVec::<f64>::new(order, direct, t).expect("valid");
            let mut channel = Channel::new(operator);
            channel.reset_to(x[0]);
            let exact = differintegrate(Scheme::Exact, order, t, &x, x[0]).expect("valid");
            for (n, &x) in x.iter().enumerate() {
                let want = channel.step(x);
                // Of the largest output, about 16·1.
                assert!((have[n] - want).abs() < 1e-11, "{n}: {} {want}", have[n]);
                let exact = direct < 6000 || (exact[n] - want).abs() < 1e-11;
                assert!(exact, "{n}: {want}");
            }
        }
    }
}
