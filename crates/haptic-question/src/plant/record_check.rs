//! Checks that a table of input and output can be a record of a plant; errors name lines and columns.

use control_identification::model_search::InputOutput;
use fracdiff::parameter::Shown;
use measured_table::rows_named;

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

/// Typical distances of a row from the middle of its neighbours, and share of the others' range, beyond which an output cannot be.
const FAR: f64 = 20.0;
const SHARE: f64 = 0.3;
/// One row in so many may be wrong, and three.
const RARE: usize = 50;

/// Rows that are further than these bounds from the middle of two neighbours that are alike.
/// ```text
/// d_n = y_n − (y_(n−1) + y_(n+1))/2,   |d_n| > 20·median |d|, 0.3·range of the other rows, 3·|y_(n+1) − y_(n−1)|
/// ```
fn lone(signal: &[f64]) -> Vec<usize> {
    let far = |three: &[f64]| (three[1] - 0.5 * (three[0] + three[2])).abs();
    let mut typical: Vec<f64> = signal.windows(3).map(far).collect();
    typical.retain(|far| far.is_finite());
    typical.sort_by(f64::total_cmp);
    let typical = typical.get(typical.len() / 2).copied().unwrap_or(0.0);
    let is_lone = |three: &[f64]| {
        far(three) > FAR * typical && (three[2] - three[0]).abs() < SHARE * far(three)
    };
    let lone = signal.windows(3).zip(1..);
    let lone: Vec<(usize, f64)> = lone
        .filter(|(three, _)| is_lone(three))
        .map(|(three, row)| (row, far(three)))
        .collect();
    let others = signal.iter().enumerate();
    let others = others.filter(|(n, _)| lone.iter().all(|(row, _)| row != n));
    let (least, most) = others.fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), (_, y)| (y.min(least), y.max(most)),
    );
    let out = lone
        .into_iter()
        .filter(|(_, far)| *far > SHARE * (most - least));
    out.map(|(row, _)| row).collect()
}

/// Rows within which an output may answer a pulse of the input.
const ANSWER: usize = 10;

/// Leaves out, as NaN, the outputs of rows that cannot be, as a line that a serial port has spoilt; `None` without such rows. Just behind a row of
/// the input that is such too they are its answer, and where there are many they are what was recorded.
pub(crate) fn leave_out_lone_outputs(record: &mut InputOutput, lines: &[u64]) -> Option<String> {
    let pulses = lone(&record.input);
    let answers = |row: &usize| pulses.iter().any(|at| (*at..=at + ANSWER).contains(row));
    let mut rows = lone(&record.output);
    rows.retain(|row| !answers(row));
    if rows.len() > 3 + record.output.len() / RARE {
        return None;
    }
    rows.iter().for_each(|row| record.output[*row] = f64::NAN);
    let lines: Vec<u64> = rows.iter().map(|row| lines[*row]).collect();
    rows_named(&lines)
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
    fn a_row_that_cannot_be_is_left_out_and_a_pulse_of_the_input_is_not() {
        let rises = |n: u32| 1.0 - (-0.05 * f64::from(n)).exp() + 0.01 * f64::from(n % 3);
        let output: Vec<f64> = (0..200).map(rises).collect();
        let lines: Vec<u64> = (2..202).collect();
        let spoilt = |rows: &[(usize, f64)], input: Vec<f64>| {
            let mut record = InputOutput {
                input,
                output: output.clone(),
                ..InputOutput::default()
            };
            rows.iter().for_each(|(row, y)| record.output[*row] = *y);
            let said = leave_out_lone_outputs(&mut record, &lines);
            let out = (0..200).filter(|row| record.output[*row].is_nan());
            (said, out.collect::<Vec<usize>>())
        };
        let steady = vec![1.0; 200];
        assert_eq!(spoilt(&[], steady.clone()), (None, vec![]));
        let (said, out) = spoilt(&[(90, -12_854.0), (150, 0.1)], steady.clone());
        assert_eq!(
            (said.as_deref(), out),
            (Some("2 rows (lines 92, 152)"), vec![90, 150])
        );
        let mut pulse = steady.clone();
        pulse[89] = 50.0;
        assert_eq!(spoilt(&[(90, 10.0)], pulse.clone()), (None, vec![]));
        assert_eq!(spoilt(&[(150, 10.0)], pulse).1, [150]);
        // A step stays, and what happens again and again is the plant.
        let step: Vec<(usize, f64)> = (100..200).map(|row| (row, 30.0)).collect();
        assert_eq!(spoilt(&step, steady.clone()), (None, vec![]));
        let beats: Vec<(usize, f64)> = (2..19).map(|n| (10 * n, 8.0)).collect();
        assert_eq!(spoilt(&beats, steady), (None, vec![]));
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
