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
/// With the line of the row.
pub fn check_times(record: &InputOutput, lines: &[u64]) -> Result<(), String> {
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
        return Err("the time does not increase: give at least two rows in order".to_owned());
    }
    let uneven = |pair: &[f64]| ((pair[1] - pair[0]) / t - 1.0).abs() > EVEN;
    match record.time_s.windows(2).position(uneven) {
        None => Ok(()),
        Some(row) => Err(format!(
            "line {}: a step of {} s among steps of {} s: put the record on equal steps first",
            lines[row + 1],
            Shown(record.time_s[row + 1] - record.time_s[row]),
            Shown(t)
        )),
    }
}

/// Samples next to each other that may be missing.
const GAP: usize = 3;

/// Puts straight lines between the neighbours of outputs that are missing, NaN, up to three at a time.
///
/// # Errors
/// A missing input, because its effect cannot be known; a longer gap, or one at an end.
/// With column and line.
pub fn fill_gaps(
    record: &mut InputOutput,
    lines: &[u64],
    [input, output]: [&str; 2],
) -> Result<(), String> {
    let missing = |row: usize, column: &str, remedy: &str| {
        format!(
            "line {}: column `{column}` has no value: {remedy}",
            lines[row]
        )
    };
    if let Some(row) = record.input.iter().position(|value| value.is_nan()) {
        return Err(missing(
            row,
            input,
            "give what acted there, or cut the record",
        ));
    }
    let mut row = 0;
    while let Some(begin) = record.output[row..].iter().position(|value| value.is_nan()) {
        let begin = row + begin;
        let left = &record.output[begin..];
        let count = left.iter().take_while(|value| value.is_nan()).count();
        let end = record.output.get(begin + count).copied();
        let before = begin.checked_sub(1).map(|last| record.output[last]);
        let (Some(before), Some(end), true) = (before, end, count <= GAP) else {
            let remedy = format!(
                "at most {GAP} rows in a row may lack one, inside the record: cut the record"
            );
            return Err(missing(begin, output, &remedy));
        };
        for n in 0..count {
            let share = (n + 1) as f64 / (count + 1) as f64;
            record.output[begin + n] = before + share * (end - before);
        }
        row = begin + count;
    }
    Ok(())
}

/// Refuses an input or an output that reveals nothing about a plant, naming its column.
///
/// # Errors
/// With the column, the value and, where there is one, the line of the row.
pub fn check_signals(
    record: &InputOutput,
    lines: &[u64],
    [input, output]: [&str; 2],
) -> Result<(), String> {
    for (name, signal) in [(input, &record.input), (output, &record.output)] {
        if let Some(row) = signal.iter().position(|value| value.abs() > MOST) {
            return Err(format!(
                "line {}: column `{name}` is {}, above {MOST:e}: correct the row, or take a larger unit",
                lines[row],
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
            time_s,
            ..InputOutput::default()
        };
        let lines: Vec<u64> = (2..402).collect();
        assert_eq!(check_times(&record, &lines), Ok(()));
        record.time_s[7] += 0.01;
        let said = check_times(&record, &lines).expect_err("uneven");
        assert!(said.starts_with("line 9:"), "{said}");
    }

    #[test]
    fn outputs_that_are_missing_are_put_between_their_neighbours_and_inputs_are_not() {
        let signal = |text: &str| -> Vec<f64> {
            text.split(' ')
                .map(|cell| cell.parse().expect("a number"))
                .collect()
        };
        let lines: Vec<u64> = (5..11).collect();
        let filled = |input: &str, output: &str| {
            let mut record = InputOutput {
                time_s: vec![0.0; 6],
                input: signal(input),
                output: signal(output),
                ..InputOutput::default()
            };
            fill_gaps(&mut record, &lines, ["valve", "level"]).map(|()| record.output)
        };
        let between = filled("1 1 1 1 1 1", "0 NaN 2 NaN NaN 8");
        assert_eq!(between, Ok(signal("0 1 2 4 6 8")));
        for (input, output, said) in [
            ("1 NaN 1 1 1 1", "0 1 2 3 4 5", "line 6: column `valve`"),
            (
                "1 1 1 1 1 1",
                "0 NaN NaN NaN NaN 5",
                "line 6: column `level`",
            ),
            ("1 1 1 1 1 1", "NaN 1 2 3 4 5", "line 5: column `level`"),
            ("1 1 1 1 1 1", "0 1 2 3 4 NaN", "line 10: column `level`"),
        ] {
            let refused = filled(input, output).expect_err(output);
            assert!(refused.starts_with(said), "{refused}");
        }
    }
}
