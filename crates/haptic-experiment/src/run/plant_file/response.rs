//! A measured frequency response out of a CSV file.

use crate::document::input::{Rows, short};
use haptic_tissue::open_file;
use num_complex::Complex;
use std::path::Path;

/// Frequencies at most.
const POINTS_MOST: usize = 1_000_000;
const COLUMNS: &str = "omega_rad_s or frequency_hz; gain or gain_db, with phase_deg or phase_rad; or real and imaginary";

/// ω in rad/s and G(jω), from a CSV with a header: `omega_rad_s` or `frequency_hz`, and `gain` or `gain_db` with `phase_deg` or
/// `phase_rad`, or `real` and `imaginary`. Other columns are passed over.
///
/// # Errors
/// A file that cannot be read, a column or a number that is missing: in one line, with file and line.
pub fn read_response(path: &Path) -> Result<Vec<(f64, Complex<f64>)>, String> {
    let shown = path.display();
    let bad = |text: String| format!("{shown}: {text}");
    let file = open_file(path).map_err(|error| {
        format!("cannot read the measured response `{shown}`: {error}; give the path of a CSV file")
    })?;
    let (rows, length) = Rows::new(file);
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(rows);
    let header = table.headers().map_err(|error| bad(error.to_string()))?;
    let columns = Columns::find(header).map_err(bad)?;
    let mut points = Vec::new();
    for row in table.records() {
        let row = row.map_err(|error| bad(error.to_string()))?;
        length.next_row();
        let line = row.position().map_or(0, csv::Position::line);
        let bad = |text: String| bad(format!("line {line}: {text}"));
        if points.len() == POINTS_MOST {
            return Err(bad(format!(
                "more than {POINTS_MOST} frequencies: leave some out"
            )));
        }
        let number = |place: usize| {
            let cell = row.get(place).unwrap_or("");
            let number = cell.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| bad(format!("{:?} is not a finite number", short(cell))))
        };
        points.push(columns.point(number)?);
    }
    Ok(points)
}

/// Places of the columns.
struct Columns {
    frequency: usize,
    in_hz: bool,
    first: usize,
    second: usize,
    form: Form,
}

/// Form of the two columns of G.
enum Form {
    Cartesian,
    Polar { in_db: bool, in_degrees: bool },
}

impl Columns {
    fn find(header: &csv::StringRecord) -> Result<Self, String> {
        let place = |name: &str| header.iter().position(|cell| cell == name);
        let missing = |what: &str| {
            let names: Vec<&str> = header.iter().collect();
            format!(
                "line 1: no column of {what} in the header {:?}; give {COLUMNS}",
                short(&names.join(","))
            )
        };
        let (frequency, in_hz) = place("omega_rad_s")
            .map(|at| (at, false))
            .or(place("frequency_hz").map(|at| (at, true)))
            .ok_or_else(|| missing("the frequency"))?;
        if let (Some(first), Some(second)) = (place("real"), place("imaginary")) {
            return Ok(Self {
                frequency,
                in_hz,
                first,
                second,
                form: Form::Cartesian,
            });
        }
        let gain = place("gain")
            .map(|at| (at, false))
            .or(place("gain_db").map(|at| (at, true)));
        let (first, in_db) = gain.ok_or_else(|| missing("the gain"))?;
        let phase = place("phase_deg")
            .map(|at| (at, true))
            .or(place("phase_rad").map(|at| (at, false)));
        let (second, in_degrees) = phase.ok_or_else(|| missing("the phase"))?;
        Ok(Self {
            frequency,
            in_hz,
            first,
            second,
            form: Form::Polar { in_db, in_degrees },
        })
    }

    fn point(
        &self,
        number: impl Fn(usize) -> Result<f64, String>,
    ) -> Result<(f64, Complex<f64>), String> {
        let turn = if self.in_hz {
            2.0 * core::f64::consts::PI
        } else {
            1.0
        };
        let omega = turn * number(self.frequency)?;
        let (first, second) = (number(self.first)?, number(self.second)?);
        let response = match self.form {
            Form::Cartesian => Complex::new(first, second),
            Form::Polar { in_db, in_degrees } => {
                let gain = if in_db {
                    libm::pow(10.0, first / 20.0)
                } else {
                    first
                };
                let phase = if in_degrees {
                    second.to_radians()
                } else {
                    second
                };
                let (sin, cos) = libm::sincos(phase);
                Complex::new(gain * cos, gain * sin)
            }
        };
        Ok((omega, response))
    }
}
