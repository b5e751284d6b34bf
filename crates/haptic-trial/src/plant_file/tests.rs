//! Each kind of plant against the others, and what is said of bad files.

use super::{PlantModel, function_file, parse, response_in};
use num_complex::Complex;
use std::path::Path;
use testkit::{Folder, Tested};

fn read(text: &str) -> Result<PlantModel, String> {
    let found = parse(Path::new("lab/p.toml"), text);
    found
        .map(|(model, ..)| model)
        .map_err(|error| error.to_string())
}

/// The same plant in four ways.
#[test]
fn a_device_is_its_function_its_matrices_and_its_measured_response() -> Tested {
    let device = "[device]\nmass_kg = 0.5\ndamping_n_s_per_m = 3\nhand_stiffness_n_per_m = 20\ndelay_s = 0.01\ncurrent_lag_s = 0.002\n";
    let function = "[transfer_function]\nfunction = \"exp(-0.004s)/((0.5s^2+3s+20)(0.002s+1))\"\ndelay_s = 0.006\n";
    let states = "[state_space]\na = [[0, 1], [-40, -6.0]]\nb = [0, 2]\nc = [1, 0]\ndelay_s = 0.01\ncurrent_lag_s = 0.002\n";
    let device = read(device).expect("valid").plant()?;
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
    std::fs::write(folder.join("r.csv"), rows)?;
    let measured = parse(
        &folder.join("p.toml"),
        "[measured_response]\nfile = \"r.csv\"\n[source]\nnote = \"shaker\"",
    );
    let (measured, ..) = measured?;
    let others = [function, states].map(|text| read(text).expect("valid"));
    let others = others.iter().map(|other| (other, 1e-12));
    for (other, share) in others.chain([(&measured, 1e-3)]) {
        let plant = other.plant()?;
        for omega in [0.1, 1.0, 6.3, 40.0] {
            let want = device.response(omega).expect("there");
            let have = plant.response(omega).expect("there");
            assert!(
                (have - want).norm() < share * want.norm(),
                "{omega}: {have} {want}"
            );
        }
    }
    Ok(())
}

#[test]
fn a_response_may_have_semicolons_and_decimal_commas() {
    let folder = Folder::empty();
    let file = folder.join("r.csv");
    let read = |rows: &str| {
        std::fs::write(&file, rows).expect("writes");
        response_in(&file).expect("a response")
    };
    let points = read("omega_rad_s,real,imaginary\n0.5,1.25,-2\n1,1,-1\n");
    assert_eq!(points.points[0], (0.5, Complex::new(1.25, -2.0)));
    assert_eq!(
        read("omega_rad_s;real;imaginary\n0,5;1,25;-2\n1;1;-1\n"),
        points
    );
}

/// Tables as instruments of impedances write them, of one cell at 10 kHz, 100 Hz and 1 Hz.
const LAYOUTS: [&str; 10] = [
    "EXPLAIN\r\nTAG\tEISPOT\r\nVDC\tPOTEN\t0.00000E+000\tT\tDC &Voltage (V)\r\nZCURVE\tTABLE\r\n\tPt\tTime\tFreq\tZreal\tZimag\tZsig\tZmod\r\n\t#\ts\tHz\tohm\tohm\tV\tohm\r\n\t0\t3\t1E4\t2.01E-2\t-3E-4\t1\t7\r\n\t1\t4\t100\t2.5E-2\t-4E-3\t1\t7\r\n\t2\t5\t1\t3.4E-2\t-9E-3\t1\t7\r\n",
    "EC-Lab ASCII FILE\nNb header lines : 5       \n\nfreq/Hz\tRe(Z)/Ohm\t-Im(Z)/Ohm\t|Z|/Ohm\ttime/s\n1E4\t2.01E-2\t3E-4\t7\t0\n100\t2.5E-2\t4E-3\t7\t1\n1\t3.4E-2\t9E-3\t7\t2\n",
    "\"ZPLOT2 ASCII\"\n\"Date: 1/2/2003\"\n  Freq(Hz)     Ampl     Z'(a)         Z''(b)      Err\nEnd Comments\n 1E4, 1, 2.01E-2, -3E-4, 0\n 100, 1, 2.5E-2, -4E-3, 0\n 1, 1, 3.4E-2, -9E-3, 0\n",
    "Index\tFrequency (Hz)\tZ' (Ω)\t-Z'' (Ω)\tZ (Ω)\n1\t10000\t0.0201\t0.0003\t7\n2\t100\t0.025\t0.004\t7\n3\t1\t0.034\t0.009\t7\n",
    "June 3, 2010\nA.C. Impedance\nInit E (V) = 0\n\nFreq/Hz, Z'/ohm, Z\"/ohm, Z/ohm, Phase/deg\n\n1e+4, 0.0201, -0.0003, 7, 7\n100, 0.025, -0.004, 7, 7\n1, 0.034, -0.009, 7, 7\n",
    "Number    Frequency/Hz    Impedance/Ohm    Phase/deg\n0    1e4    0.020102238681    -0.8550973963\n1    100    0.025317977802    -9.0902769208\n2    1    0.035171010790    -14.8264799704\n",
    " Freq. [Hz]   Zs' [Ohms]   Zs'' [Ohms]\n 1e4   2.01e-2   -3e-4\n 100   2.5e-2   -4e-3\n 1   3.4e-2   -9e-3\n",
    "Prüfling: Zelle 4\nFrequenz [Hz];|Z| [mΩ];Phasenwinkel [°]\n10000;20,102238681;-0,8550973963\n100;25,317977802;-9,0902769208\n1;35,171010790;-14,8264799704\n",
    "log10(f/Hz),log10(|Z|/ohm),-phase_deg\n4,-1.696755574779,0.8550973963\n2,-1.596570985241,9.0902769208\n0,-1.453815150185,14.8264799704\n",
    "f in kHz,Z_real [kOhm],Z_imag [kOhm]\n10,2.01e-5,-3e-7\n0.1,2.5e-5,-4e-6\n1e-3,3.4e-5,-9e-6\n",
];

#[test]
fn tables_of_impedance_instruments_are_read_by_name_and_unit() {
    let cell = [
        (1e4, 0.0201, -3e-4),
        (100.0, 0.025, -4e-3),
        (1.0, 0.034, -9e-3),
    ];
    for text in LAYOUTS {
        let read = super::response_of(Path::new("cell.dta"), text.as_bytes());
        let points = read.unwrap_or_else(|why| panic!("{text}: {why}")).points;
        assert_eq!(points.len(), 3, "{text}");
        for ((omega, z), (hz, re, im)) in points.into_iter().zip(cell) {
            let off = (z - Complex::new(re, im)).norm() / z.norm();
            let of_omega = (omega / (hz * std::f64::consts::TAU) - 1.0).abs();
            assert!(off < 1e-8 && of_omega < 1e-8, "{text}: {omega} {z}");
        }
    }
}

#[test]
fn a_response_keeps_its_coherent_rows_and_has_no_negative_gain() {
    let folder = Folder::empty();
    let file = folder.join("r.csv");
    let read = |rows: &str| {
        let text = format!("omega_rad_s,gain,phase_deg,coherence\n{rows}");
        std::fs::write(&file, text).expect("writes");
        response_in(&file)
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
    let text = function_file(&model.in_words(), 0.0, "a \"program\"", "");
    assert!(
        text.ends_with("[source]\nprogram = 'a \"program\"'\n"),
        "{text}"
    );
    assert_eq!(read(&text), Ok(model), "{text}");
    let rod: PlantModel = "exp(-sqrt(3s))/(s+1)^1.6".parse().expect("valid");
    assert_eq!(rod.in_words(), "exp(-sqrt(3s))/(s+1)/(s+1)^0.6");
    assert_eq!(rod.in_words().parse(), Ok(rod));
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
    speed,gain,phase_deg\n1,1,3\n2,1,3\n | no column of the frequency
    omega_rad_s,gain\n1,1\n2,1\n | no column of the phase
    omega_rad_s,gain,phase_deg\n1,1,3\n2,x,3\n3,1,3\n | line 3, column gain: "x" is not a finite number
    f (Hz),|Z|,theta\n1,1,0.3\n2,1,0.3\n | may be in ° or rad: name it phase_deg
    f (V),gain,phase_deg\n1,1,3\n2,1,3\n | unit "V" is not a unit of omega
    f (Hz),z',zreal,z''\n1,1,3,1\n2,1,3,1\n | the columns z' and zreal both look like the real
    f (Hz),z'\n1,1\n2,1\n | no column of the imaginary
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
