//! Numbers that others have printed, each within its digits.

use crate::fixture::{bdf2, closed, plant};
use testkit::{assert_close, assert_relative};

/// Gain and phase margin, distance to −1, and their frequencies, of plants behind a hold: python-control's `control/tests/margin_test.py`,
/// `test_stability_margins_discrete`, which holds its own numbers to 1e-5, the middle two to 1e-4.
#[test]
fn margins_of_held_plants_are_those_of_python_control() {
    let tau = 2.0 * core::f64::consts::PI;
    let square = tau * tau;
    let swing = format!("{}/(s^2+{}s+{square})", 1.1 * square, 0.4 * tau);
    type Printed = ([f64; 6], f64);
    let examples: [(&str, f64, Printed); 4] = [
        (
            "2/(s^3+3s^2+2s)",
            0.01,
            (
                [2.955761, 32.398492, 0.429535, 1.403725, 0.749367, 0.923898],
                1e-5,
            ),
        ),
        (
            "2/(s^3+3s^2+3s+1)",
            0.1,
            ([3.4927, 65.4212, 0.5763, 1.6283, 0.76625, 1.2019], 1e-4),
        ),
        (
            &swing,
            0.05,
            ([2.3842, 18.161, 0.26953, 11.712, 8.7478, 9.1504], 1e-4),
        ),
        (
            "50000/(s^4+101s^3+10101s^2+10100s+10000)",
            0.001,
            (
                [18.8766, 26.3564, 0.406841, 9.76358, 2.32933, 2.55986],
                1e-5,
            ),
        ),
    ];
    for (function, t, (want, within)) in examples {
        let memory = bdf2(1e-8, 100.0);
        let alone = "1".parse().expect("a controller");
        let margins = closed(alone, &plant(function), memory, t).margins();
        let (gain, phase) = (
            margins.gain_up.expect(function),
            margins.phase.expect(function),
        );
        let peak = margins.sensitivity;
        let have = [
            gain.value,
            phase.value.to_degrees(),
            1.0 / peak.value,
            gain.omega_rad_s,
            phase.omega_rad_s,
            peak.omega_rad_s,
        ];
        for (have, want) in have.into_iter().zip(want) {
            assert_relative(function, have, want, within);
        }
    }
}

/// Gain and phase margin and their frequencies of plants without a hold, from the same file, `test_zmore_margin`: degrees within its 1e-4, but 1e-2 of
/// the first. A hold of 1 µs turns them by less than 3e-5°.
#[test]
fn margins_of_plants_are_those_of_python_control() {
    type Printed = (Option<(f64, f64)>, (f64, f64), f64);
    let examples: [(&str, Printed); 3] = [
        ("2/(s+1)^3", (Some((4.0, 1.7322)), (67.6058, 0.7663), 1e-2)),
        ("(s+0.1)/(s(s+1))", (None, (144.9032, 0.3162), 1e-4)),
        ("(s+0.1)/(s^2(s+1))", (None, (44.4594, 0.7907), 1e-4)),
    ];
    for (function, (gain, (phase, omega), within)) in examples {
        let memory = bdf2(1e-8, 1e-2);
        let alone = "1".parse().expect("a controller");
        let margins = closed(alone, &plant(function), memory, 1e-6).margins();
        let margin = margins.phase.expect(function);
        assert_close(function, margin.value.to_degrees(), phase, within);
        assert_close(function, margin.omega_rad_s, omega, within);
        if let Some((gain, omega)) = gain {
            let margin = margins.gain_up.expect(function);
            assert_close(function, margin.value, gain, within);
            assert_close(function, margin.omega_rad_s, omega, within);
        }
    }
}

/// The table of the guide: each printed number within one of its last digits, and ours as they stand there.
#[test]
fn the_guide_holds_its_margins_against_those_that_are_printed() {
    let page = include_str!("../../../../docs/guide/src/a-fractional-pid.md");
    let (_, table) = page.split_once("## Compared with others").expect("there");
    let mut rows = 0;
    for row in table.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row
            .split('|')
            .map(|cell| cell.trim().trim_matches('`'))
            .collect();
        let numbers = |cell: &str| -> [String; 2] {
            let (phase, crossover) = cell.split_once("°, ").expect(row);
            [phase, crossover.trim_end_matches(" rad/s")].map(str::to_owned)
        };
        let t: f64 = cells[3].trim_end_matches(" s").parse().expect(row);
        let memory = bdf2(1e-8, 1e6 * t);
        let controller = cells[2].parse().expect(row);
        let margin = closed(controller, &plant(cells[1]), memory, t)
            .margins()
            .phase;
        let margin = margin.expect(row);
        let have = [margin.value.to_degrees(), margin.omega_rad_s];
        for ((have, printed), shown) in have
            .into_iter()
            .zip(numbers(cells[4]))
            .zip(numbers(cells[5]))
        {
            let digits = |text: &str| text.split_once('.').map_or(0, |(_, behind)| behind.len());
            assert_eq!(format!("{have:.*}", digits(&shown)), shown, "{row}");
            let unit = 10f64.powi(-(digits(&printed) as i32));
            assert_close(row, have, printed.parse().expect(row), unit);
        }
        rows += 1;
    }
    assert_eq!(rows, 6);
}
