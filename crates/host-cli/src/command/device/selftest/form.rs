//! The form for a first time on real hardware, in Markdown: what the self-test found is filled in, what a person has to try, see and
//! feel is a blank.
//!
//! The limits of a first time bound what a mistake can do: 0.5 N is what two fingers hold, 20 N/s takes 25 ms to get there, and at
//! 0.25 m/s a hand that lets go stops within the workspace. The device shows what it is set to, so nobody has to remember it.

use crate::files::PROGRAM;
use crate::output::joined;
use haptic_experiment::{ReportLine, lines};
use haptic_link::Limits;
use haptic_loop::Limit;
use haptic_quantity::{label, written};
use haptic_selftest::SelfTestReport;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Instructions for a person, step by step, and the conditions that end them; DEVICE stands for the name of the device.
const BY_HAND: &str = include_str!("form.md");

pub(super) fn of(report: &SelfTestReport) -> String {
    let board = in_cell(&report.board);
    let mut form = format!("# First time on real hardware: {board}\n");
    let found = serde_json::to_value(report).unwrap_or_default();
    form += &tables(&joined([json!({"program": PROGRAM}), found]));
    form += "\n## Limits\n";
    form += &tables(&json!({"limits": limits(&report.limits)}));
    form + &BY_HAND.replace("DEVICE", &in_cell(&report.device))
}

/// A row for each limit: what is set, the largest magnitude of it at a first time, and what is to be done.
fn limits(set: &Limits) -> Vec<Value> {
    let mut limits = *set;
    let numbers = Limit::ALL.into_iter().filter_map(|limit| {
        let most = match limit {
            Limit::Force => 0.5,
            Limit::ForceRate => 20.0,
            Limit::Speed => 0.25,
            Limit::StopTime => 0.1,
            Limit::StartForce
            | Limit::RiseTime
            | Limit::VelocityBandwidth
            | Limit::Braking
            | Limit::BrakeForce
            | Limit::StuckForce
            | Limit::StuckTime
            | Limit::Jump
            | Limit::DeviceMass => return None,
        };
        let value = *limits.number(limit).0;
        Some((limit.key(), (!limit.is_off(value)).then_some(value), most))
    });
    let within = set.workspace_low_m < set.workspace_high_m;
    let end = |end: f32| within.then_some(end);
    let others = [
        ("workspace_low_m", end(set.workspace_low_m), 0.02),
        ("workspace_high_m", end(set.workspace_high_m), 0.02),
        ("watchdog_s", Some(1e-3 * f32::from(set.watchdog_ms)), 0.5),
    ];
    let rows = numbers.chain(others).map(|(key, set, most)| {
        let set = set.map(f64::from);
        // Set values are in single precision.
        let is_tight = set.is_some_and(|set| set.abs() <= most * (1.0 + 1e-6));
        let first_time = if key.ends_with("low_m") {
            format!("{} or above", written(key, -most))
        } else {
            format!("{} or less", written(key, most))
        };
        json!({
            "limit": label(key),
            "set": set.map_or_else(|| "none".to_owned(), |set| written(key, set)),
            "first time": first_time,
            "do": if is_tight { "keep it" } else { "tighten it first" },
        })
    });
    rows.collect()
}

/// The lines of a report as tables of Markdown: rows that follow each other are one.
fn tables(report: &impl serde::Serialize) -> String {
    let mut text = String::new();
    let mut is_in_table = false;
    for line in lines(report) {
        let was_in_table = std::mem::replace(&mut is_in_table, matches!(line, ReportLine::Row(_)));
        match line {
            ReportLine::Row(row) => {
                if !was_in_table {
                    text += "\n| | |\n|---|---|\n";
                }
                write_row(&mut text, &[row.label, row.value]);
            }
            ReportLine::Table(table) => {
                text.push('\n');
                write_row(&mut text, &table.columns);
                text += &"|---".repeat(table.columns.len());
                text += "|\n";
                table.rows.iter().for_each(|row| write_row(&mut text, row));
            }
        }
    }
    text
}

fn write_row(text: &mut String, cells: &[String]) {
    for cell in cells {
        // A text takes whatever is written.
        let _ = write!(text, "| {} ", in_cell(cell));
    }
    *text += "|\n";
}

/// A text that a device or a file gave, as a cell: it ends neither line nor cell, and is not taken for HTML.
fn in_cell(text: &str) -> String {
    let mut cell = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '|' | '<' | '`' | '\\' => cell.extend(['\\', c]),
            c if c.is_control() => cell.push(' '),
            c => cell.push(c),
        }
    }
    cell
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_stays_one_whatever_a_device_calls_itself() {
        assert_eq!(
            in_cell("a|b\n<script>`c`\\\u{1b}[31m"),
            "a\\|b \\<script>\\`c\\`\\\\ [31m"
        );
    }

    #[test]
    fn a_limit_is_to_be_tightened_unless_it_is_as_tight_as_a_first_time_asks() {
        let tight = Limits {
            workspace_low_m: -0.02,
            workspace_high_m: 0.01,
            speed_hard_m_per_s: 0.25,
            ..Limits::bare(0.5, 20.0)
        };
        let words = |set: &Limits| limits(set).into_iter().map(|row| row["do"].clone());
        assert!(
            words(&tight).all(|word| word == "keep it"),
            "{:#?}",
            limits(&tight)
        );
        // Each that is looser, or off, by itself.
        let looser: [fn(&mut Limits); 7] = [
            |set| set.force_n = 0.51,
            |set| set.force_rate_n_per_s = 21.0,
            |set| set.speed_hard_m_per_s = 0.0,
            |set| set.stop_time_s = 0.11,
            |set| set.workspace_low_m = -0.021,
            |set| set.workspace_high_m = 0.021,
            |set| set.watchdog_ms = 501,
        ];
        for (index, loosen) in looser.into_iter().enumerate() {
            let mut set = tight;
            loosen(&mut set);
            let found: Vec<usize> = (words(&set).enumerate())
                .filter(|(_, word)| word == "tighten it first")
                .map(|(index, _)| index)
                .collect();
            assert_eq!(found, [index], "{:#?}", limits(&set));
        }
        // Without a workspace neither end is set.
        let none = Limits {
            workspace_low_m: 0.0,
            workspace_high_m: 0.0,
            ..tight
        };
        assert_eq!(
            words(&none)
                .filter(|word| word == "tighten it first")
                .count(),
            2
        );
    }
}
