//! `differintegrate`: a column of a CSV file to a fractional order.

use super::experiment::{order, parse_order, parse_scheme, rate};
use crate::failure::Failure;
use crate::output::Output;
use crate::quantity::Time;
use clap::Args;
use fracdiff::{Channel, Operator, Scheme, Seconds};
use serde::Serialize;
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

/// Arguments of `differintegrate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli differintegrate --order 0.5 --sample-time 1ms signal.csv > half.csv\n\
                  The file needs a header with a column x; all other columns are ignored. The signal \
                  counts as zero before its first sample, unless --caputo is given."
)]
pub struct Arguments {
    /// Order mu, -2 to 2: positive differentiates, negative integrates
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: f64,
    /// Time between two rows
    #[arg(long, allow_hyphen_values = true)]
    sample_time: Time,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "full")]
    scheme: Scheme,
    /// Act on x minus its first value: the Caputo derivative for an order between 0 and 1
    #[arg(long)]
    caputo: bool,
    /// CSV file; standard input if absent or `-`
    file: Option<PathBuf>,
}

/// The result.
#[derive(Serialize)]
struct Signals {
    order: f64,
    scheme: String,
    sample_time_s: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Arguments {
    /// Runs the command. The whole input is read and checked before anything is printed.
    ///
    /// # Errors
    /// Bad parameters; a missing column, a missing or non-numeric cell, with its line.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mu = order(self.order)?;
        let t = Seconds(self.sample_time.0);
        rate(t, mu)?;
        let x = match self.file.as_deref() {
            Some(path) if path.as_os_str() != "-" => {
                let name = path.display().to_string();
                let file = File::open(path).map_err(|error| {
                    Failure::bad_input(format_args!("cannot read `{name}`: {error}"))
                })?;
                read_column(file, &name)?
            }
            _ => read_column(io::stdin().lock(), "standard input")?,
        };
        let operator: Operator<f64> = self
            .scheme
            .build(mu, t, 1.05 * x.len() as f64)
            .map_err(Failure::input)?;
        let mut channel = Channel::new(operator);
        if self.caputo {
            channel.reset_to(x[0]);
        }
        let y = x.iter().map(|&x| channel.step(x)).collect();
        let result = Signals {
            order: mu.get(),
            scheme: self.scheme.to_string(),
            sample_time_s: t.0,
            x,
            y,
        };
        output.print(&result, |out| {
            let mut table = csv::Writer::from_writer(out);
            table.write_record(["x", "y"])?;
            for row in result.x.iter().zip(&result.y) {
                table.serialize(row).map_err(io::Error::from)?;
            }
            table.flush()
        })
    }
}

/// The numbers of column `x`, at least one; `name` is that of the source, for messages.
///
/// # Errors
/// A missing column, a missing or non-numeric cell, with its line.
pub fn read_column(source: impl Read, name: &str) -> Result<Vec<f64>, Failure> {
    let bad = |text: String| Failure::bad_input(format_args!("{name}: {text}"));
    let mut table = csv::ReaderBuilder::new()
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(source);
    let header = table.headers().map_err(|error| bad(error.to_string()))?;
    if header.is_empty() {
        return Err(bad(
            "the input is empty; give a header with a column x and a number in each row".to_owned(),
        ));
    }
    let column = header.iter().position(|cell| cell == "x").ok_or_else(|| {
        let names: Vec<&str> = header.iter().collect();
        bad(format!(
            "line 1: no column x in the header {:?}; name the column to take x",
            names.join(",")
        ))
    })?;
    if header.iter().filter(|cell| *cell == "x").count() > 1 {
        return Err(bad(
            "line 1: more than one column is named x; rename all but the one to take".to_owned(),
        ));
    }
    let width = header.len();
    let mut x = Vec::new();
    let mut row = csv::StringRecord::new();
    while table
        .read_record(&mut row)
        .map_err(|error| bad(error.to_string()))?
    {
        let line = row.position().map_or(0, csv::Position::line);
        // The reader skips empty lines before a row; a row's own lines are one and those in its cells.
        let breaks: usize = row.iter().map(|cell| cell.matches('\n').count()).sum();
        let skipped = table.position().line() > line + 1 + breaks as u64;
        if row.len() > width {
            return Err(bad(format!(
                "line {line}: {} cells under a header of {width}; is a comma meant as a decimal point?",
                row.len()
            )));
        }
        let cell = row.get(column).unwrap_or("");
        if cell.is_empty() || skipped {
            return Err(bad(format!(
                "line {line}: no value in column x; give a number in every row"
            )));
        }
        let value: Option<f64> = cell.parse().ok();
        match value.filter(|value| value.is_finite()) {
            Some(value) => x.push(value),
            None => {
                return Err(bad(format!(
                    "line {line}: {cell:?} in column x is not a finite number"
                )));
            }
        }
    }
    if x.is_empty() {
        return Err(bad(
            "no rows below the header; there is nothing to do".to_owned()
        ));
    }
    Ok(x)
}
