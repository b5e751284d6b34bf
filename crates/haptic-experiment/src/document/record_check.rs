//! Checks that a table of input and output can be a record of a plant; errors name lines and columns.

use fracdiff::parameter::Shown;
use fractional_control::model_search::InputOutput;

/// Largest value of a record, and 1 over the least: the sum of their squares is a number.
const MOST: f64 = 1e100;
/// Least and largest ratio of output to input: so far a function has coefficients.
const RATIOS: [f64; 2] = [1e-50, 1e50];

/// Keeps one of the rows that have one time, with the first output and the last input, which acts from then on; the lines of the others.
///
/// # Errors
/// With the line of a row whose time falls, or if all are at one time.
pub(crate) fn one_row_a_time(
    record: &mut InputOutput,
    lines: &mut Vec<u64>,
) -> Result<Vec<u64>, String> {
    let pairs = record.time_s.windows(2);
    if let Some(row) = pairs.into_iter().position(|pair| pair[1] < pair[0]) {
        return Err(format!(
            "line {}: {} s comes after {} s: sort the rows by time",
            lines[row + 1],
            Shown(record.time_s[row + 1]),
            Shown(record.time_s[row])
        ));
    }
    for row in (1..record.time_s.len()).rev() {
        let (last, first) = (record.input[row], &mut record.input[row - 1]);
        if record.time_s[row] <= record.time_s[row - 1] && last.is_finite() {
            *first = last;
        }
    }
    let time_s = &record.time_s;
    let is_new: Vec<bool> = (0..time_s.len())
        .map(|row| row == 0 || time_s[row] > time_s[row - 1])
        .collect();
    let keep = |signal: &mut Vec<f64>| {
        let mut new = is_new.iter();
        signal.retain(|_| new.next().copied().unwrap_or(false));
    };
    for signal in [&mut record.time_s, &mut record.input, &mut record.output] {
        keep(signal);
    }
    let pairs = lines.iter().zip(&is_new);
    let repeated = pairs.filter(|(_, new)| !**new).map(|(line, _)| *line);
    let repeated = repeated.collect();
    let mut new = is_new.iter();
    lines.retain(|_| new.next().copied().unwrap_or(false));
    if record.time_s.len() < 2 {
        return Err("the time does not increase: give at least two rows in order".to_owned());
    }
    Ok(repeated)
}

/// Samples next to each other that may be missing.
const GAP: usize = 3;

/// Puts straight lines between the neighbours of outputs that are missing, NaN, up to three at a time.
///
/// # Errors
/// A missing input, because its effect cannot be known; a longer gap, or one at an end.
/// With column and line.
pub(crate) fn fill_gaps(
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
            let time = |row: usize| record.time_s[row] - record.time_s[begin - 1];
            let share = time(begin + n) / time(begin + count);
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
pub(crate) fn check_signals(
    record: &InputOutput,
    lines: &[u64],
    [input, output]: [&str; 2],
) -> Result<(), String> {
    for (name, signal) in [(input, &record.input), (output, &record.output)] {
        if let Some(row) = signal.iter().position(|value| value.abs() > MOST) {
            return Err(format!(
                "line {}: column `{name}` is {}, above {MOST:e}: correct the row, or use a larger unit",
                lines[row],
                Shown(signal[row])
            ));
        }
        let largest = largest(signal);
        if largest > 0.0 && largest < 1.0 / MOST {
            return Err(format!(
                "column `{name}` is {} at most, below {:e}: use a smaller unit",
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
    fn the_first_output_and_the_last_input_of_a_time_count_and_a_time_that_falls_is_named_with_its_line()
     {
        let record_at = |time_s: &[f64]| InputOutput {
            time_s: time_s.to_vec(),
            input: (0..time_s.len()).map(|n| n as f64).collect(),
            output: (10..10 + time_s.len()).map(|n| n as f64).collect(),
            ..InputOutput::default()
        };
        let mut lines: Vec<u64> = (2..7).collect();
        let mut record = record_at(&[0.0, 0.0, 1.0, 2.5, 2.5]);
        assert_eq!(one_row_a_time(&mut record, &mut lines), Ok(vec![3, 6]));
        assert_eq!(record.time_s, [0.0, 1.0, 2.5]);
        assert_eq!(record.input, [1.0, 2.0, 4.0]);
        assert_eq!(record.output, [10.0, 12.0, 13.0]);
        assert_eq!(lines, [2, 4, 5]);
        let error =
            one_row_a_time(&mut record_at(&[0.0, 1.0, 0.5]), &mut lines).expect_err("falls");
        assert!(
            error.starts_with("line 5: 0.5 s comes after 1 s"),
            "{error}"
        );
        let error = one_row_a_time(&mut record_at(&[1.0, 1.0]), &mut lines).expect_err("one time");
        assert!(error.contains("does not increase"), "{error}");
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
                time_s: (0..6).map(f64::from).collect(),
                input: signal(input),
                output: signal(output),
                ..InputOutput::default()
            };
            fill_gaps(&mut record, &lines, ["valve", "level"]).map(|()| record.output)
        };
        let between = filled("1 1 1 1 1 1", "0 NaN 2 NaN NaN 8");
        assert_eq!(between, Ok(signal("0 1 2 4 6 8")));
        for (input, output, reason) in [
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
            assert!(refused.starts_with(reason), "{refused}");
        }
    }
}
