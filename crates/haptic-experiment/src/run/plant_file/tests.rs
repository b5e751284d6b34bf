//! Each kind of plant against the others, and what is said of bad files.

use super::{MeasuredPoints, PlantModel, parse, read_response};
use num_complex::Complex;
use std::path::Path;
use testkit::Folder;

fn read(text: &str) -> Result<PlantModel, String> {
    let found = parse(Path::new("lab/p.toml"), text);
    found
        .map(|(model, ..)| model)
        .map_err(|error| error.to_string())
}

/// The same plant in four ways.
#[test]
fn a_device_is_its_function_its_matrices_and_its_measured_response() {
    let device = "[device]\nmass_kg = 0.5\ndamping_n_s_per_m = 3\nhand_stiffness_n_per_m = 20\ndelay_s = 0.01\ncurrent_lag_s = 0.002\n";
    let function = "[transfer_function]\nfunction = \"exp(-0.004s)/((0.5s^2+3s+20)(0.002s+1))\"\ndelay_s = 0.006\n";
    let states = "[state_space]\na = [[0, 1], [-40, -6.0]]\nb = [0, 2]\nc = [1, 0]\ndelay_s = 0.01\ncurrent_lag_s = 0.002\n";
    let device = read(device).expect("valid").plant().expect("a plant");
    let folder = Folder::empty();
    let mut rows = String::from("frequency_hz,note,gain_db,phase_deg\n# a comment\n");
    for k in 0..400 {
        let hz = 0.01 * 1.03_f64.powi(k);
        let response = device
            .response(hz * 2.0 * std::f64::consts::PI)
            .expect("there");
        let (gain, phase) = (20.0 * response.norm().log10(), response.arg().to_degrees());
        rows += &format!("{hz},x,{gain},{phase}\n");
    }
    std::fs::write(folder.join("r.csv"), rows).expect("writes");
    let measured = parse(
        &folder.join("p.toml"),
        "[measured_response]\nfile = \"r.csv\"\n[source]\nnote = \"shaker\"",
    );
    let (measured, ..) = measured.expect("valid");
    let others = [function, states].map(|text| read(text).expect("valid"));
    let others = others.iter().map(|other| (other, 1e-12));
    for (other, share) in others.chain([(&measured, 1e-3)]) {
        let plant = other.plant().expect("a plant");
        for omega in [0.1, 1.0, 6.3, 40.0] {
            let want = device.response(omega).expect("there");
            let have = plant.response(omega).expect("there");
            assert!(
                (have - want).norm() < share * want.norm(),
                "{omega}: {have} {want}"
            );
        }
    }
}

#[test]
fn a_response_may_have_semicolons_and_decimal_commas() {
    let folder = Folder::empty();
    let file = folder.join("r.csv");
    let read = |rows: &str| {
        std::fs::write(&file, rows).expect("writes");
        read_response(&file).expect("a response")
    };
    let points = read("omega_rad_s,real,imaginary\n0.5,1.25,-2\n1,1,-1\n");
    assert_eq!(points.points[0], (0.5, Complex::new(1.25, -2.0)));
    assert_eq!(
        read("omega_rad_s;real;imaginary\n0,5;1,25;-2\n1;1;-1\n"),
        points
    );
}

#[test]
fn a_response_keeps_its_coherent_rows_and_has_no_negative_gain() {
    let folder = Folder::empty();
    let file = folder.join("r.csv");
    let read = |rows: &str| {
        let text = format!("omega_rad_s,gain,phase_deg,coherence\n{rows}");
        std::fs::write(&file, text).expect("writes");
        read_response(&file)
    };
    let found = read("1,2,0,0.95\n2,-9,0,0.9499\n3,1,-90,1\n").expect("two rows");
    let frequencies: Vec<f64> = found.points.iter().map(|point| point.0).collect();
    assert_eq!(frequencies, [1.0, 3.0]);
    assert_eq!(
        PlantModel::Measured(found).in_words(),
        "measured at 2 frequencies; 1 row (line 3) of coherence below 0.95 left out"
    );
    let refused = read("1,2,0,1\n2,-9,0,1\n").expect_err("a negative gain");
    assert!(refused.contains("line 3: gain -9 is below 0"), "{refused}");
    let refused = read("1,2,0,0.5\n2,1,0,0.2\n").expect_err("no row");
    assert!(
        refused.contains("2 rows (lines 2, 3) of coherence"),
        "{refused}"
    );
}

#[test]
fn a_function_reads_back_to_the_same() {
    let model = "exp(-0.5s)/(0.8s^2.2+0.5s^0.9+1)".parse();
    let model: PlantModel = model.expect("valid");
    assert_eq!(model.in_words(), "exp(-0.5s)*1/(0.8s^2.2+0.5s^0.9+1)");
    let text = model.clone().to_toml("a \"program\"", "");
    let text = text.expect("a function");
    assert!(
        text.ends_with("[source]\nprogram = 'a \"program\"'\n"),
        "{text}"
    );
    assert_eq!(read(&text), Ok(model), "{text}");
    let measured = PlantModel::Measured(MeasuredPoints::default());
    assert_eq!(measured.to_toml("", ""), None);
}

/// A plant file, and the beginning of what is said of it.
const WRONG: &str = r#"
    [device]\nmass_kg = 0\n | lab/p.toml:2: mass_kg = 0 is not above 0
    [device]\nmass_kg = 1e-16\ndamping_n_s_per_m = 0\nhand_stiffness_n_per_m = 0\n | lab/p.toml:1: mass 1e-16 kg is not at least 1e-15 kg
    [device]\nmass_kg = 1\n | lab/p.toml:1: missing key `damping_n_s_per_m` in [device]
    [transfer_function]\nfunction = "s^2/(s+1)" | lab/p.toml:2: the numerator's order 2 exceeds
    [transfer_function]\nfunction = "1/(0s^2+s)" | lab/p.toml:2: the coefficient of s^2 is 0
    [transfer_function]\nfunction = "s^0.5/(s+s^0.5)" | lab/p.toml:2: numerator and denominator share the factor s^0.5
    [transfer_function]\nfunction = 3 | lab/p.toml:2: function = 3 is an integer, not a string
    [state_space]\na = [[0, 1], [2]]\nb = [0, 1]\nc = [1, 0] | lab/p.toml:1: number of states 0 is not 1 to 16
    [state_space]\na = [0, 1]\nb = [0, 1]\nc = [1, 0] | lab/p.toml:2: a
    [state_space]\na = [[0, 1], [0, inf]]\nb = [0, 1]\nc = [1, 0] | lab/p.toml:2: a has inf, which is not from -1e12 to 1e12
    [measured_response]\nfile = "none.csv" | lab/p.toml:2: cannot read the measured response `lab/none.csv`
    [device]\nmass_kg = 1\n[state_space]\n | lab/p.toml:3: a second plant [state_space]
"#;

/// The columns of a measured response, and a part of what is said of it.
const WRONG_ROWS: &str = r#"
    omega,gain,phase_deg\n1,1,3\n2,1,3\n | no column of the frequency
    omega_rad_s,gain\n1,1\n2,1\n | no column of the phase
    omega_rad_s,gain,phase_deg\n1,1,3\n2,x,3\n3,1,3\n | line 3, column gain: "x" is not a finite number
    omega_rad_s,gain,phase_deg\n | no row with numbers
    omega_rad_s,gain,phase_deg\n1,1,3\n | number of frequencies 1 is not at least 3
"#;

#[test]
fn what_is_wrong_is_said_in_one_line_with_its_place() {
    let refused = |text: &str, want: &str| {
        let message = read(text).expect_err(want);
        assert!(
            message.starts_with(want) && !message.contains('\n'),
            "{message}"
        );
    };
    for [text, want] in testkit::table(WRONG) {
        refused(&text, &want);
    }
    refused(
        "",
        "lab/p.toml:1: no plant: a plant file has one of [transfer_function]",
    );
    let folder = Folder::empty();
    for [rows, want] in testkit::table(WRONG_ROWS) {
        std::fs::write(folder.join("r.csv"), rows).expect("writes");
        let text = "[measured_response]\nfile = \"r.csv\"";
        let message = parse(&folder.join("p.toml"), text).expect_err(&want);
        assert!(message.to_string().contains(&want), "{message}");
    }
}
