//! Whether a table of input and output can be a record of a plant, said with its lines and columns.

use fracdiff::parameter::Shown;
use fractional_control::model_search::InputOutput;

/// Largest value of a record, and 1 over the least: the sum of their squares is a number.
const MOST: f64 = 1e100;
/// Least and largest ratio of output to input: so far a function has coefficients.
const RATIOS: [f64; 2] = [1e-50, 1e50];
/// Steps of time may differ by this share.
const EVEN: f64 = 1e-3;

/// Refuses times that do not run in equal steps.
///
/// # Errors
/// With the line, the header being the first.
pub fn check_times(record: &InputOutput) -> Result<(), String> {
    let mut steps: Vec<f64> = record
        .time_s
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    steps.sort_by(f64::total_cmp);
    // The step in the middle: one that is wrong does not move it.
    let middle = steps.get(steps.len().max(1).div_ceil(2) - 1).copied();
    let t = middle.unwrap_or(0.0);
    if t <= 0.0 {
        return Err("the time does not grow: give at least two rows in order".to_owned());
    }
    let uneven = |pair: &[f64]| ((pair[1] - pair[0]) / t - 1.0).abs() > EVEN;
    match record.time_s.windows(2).position(uneven) {
        None => Ok(()),
        Some(row) => Err(format!(
            "line {}: a step of {} s among steps of {} s: put the record on equal steps first",
            row + 3,
            Shown(record.time_s[row + 1] - record.time_s[row]),
            Shown(t)
        )),
    }
}

/// Refuses an input or an output that says nothing of a plant, under the names of their columns.
///
/// # Errors
/// With the column, the value and, where there is one, the line, the header being the first.
pub fn check_signals(record: &InputOutput, [input, output]: [&str; 2]) -> Result<(), String> {
    for (name, signal) in [(input, &record.input), (output, &record.output)] {
        if let Some(row) = signal.iter().position(|value| value.abs() > MOST) {
            return Err(format!(
                "line {}: column `{name}` is {}, above {MOST:e}: mend the row, or take a larger unit",
                row + 2,
                Shown(signal[row])
            ));
        }
        let largest = largest(signal);
        if largest > 0.0 && largest < 1.0 / MOST {
            return Err(format!(
                "column `{name}` is {} at most, below {:e}: take a smaller unit",
                Shown(largest),
                1.0 / MOST
            ));
        }
    }
    let first = |signal: &[f64]| signal.first().copied().unwrap_or(0.0);
    let rests = |signal: &[f64]| {
        signal
            .iter()
            .all(|value| (value - first(signal)).abs() == 0.0)
    };
    if largest(&record.input) == 0.0 {
        return Err(format!(
            "column `{input}` is 0 in every row: name the input, or record while it changes"
        ));
    }
    if rests(&record.output) {
        return Err(format!(
            "column `{output}` is {} in every row: name the output, or record for longer",
            Shown(first(&record.output))
        ));
    }
    check_ratio(record, [input, output])
}

fn check_ratio(record: &InputOutput, [input, output]: [&str; 2]) -> Result<(), String> {
    let ratio = largest(&record.output) / largest(&record.input);
    let [least, most] = RATIOS;
    if ratio > most || (ratio > 0.0 && ratio < least) {
        return Err(format!(
            "column `{output}` is {ratio:.1e} times `{input}`, not {least:e} to {most:e}: change a unit",
        ));
    }
    Ok(())
}

fn largest(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |most: f64, y| most.max(y.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_another_length_is_named_with_its_line() {
        let time_s: Vec<f64> = (0..400).map(|n| f64::from(n) * 0.1).collect();
        let mut record = InputOutput {
            input: vec![1.0; time_s.len()],
            output: vec![1.0; time_s.len()],
            late_s: 0.0,
            time_s,
        };
        assert_eq!(check_times(&record), Ok(()));
        record.time_s[7] += 0.01;
        let said = check_times(&record).expect_err("uneven");
        assert!(said.starts_with("line 9:"), "{said}");
    }
}
