//! Files that read back to the same, and what is said of bad ones.

use super::ControllerFile;
use fracdiff::Seconds;
use fractional_control::{
    ControllerParameters, ControllerSetup, CroneParameters, FractionalTransferFunction, HeldPlant,
    LeadLagParameters, PidParameters, Plant, PowerMemory, Rule, TidParameters,
};
use std::path::Path;
use testkit::Tested;

const PID: &str = "[pid]\nproportional_gain = 2\nintegral_gain_per_s_lambda = 1\nintegral_order = 0.8\n\
                   [loop]\nsample_time_s = 0.01\noutput_low = -3\noutput_high = 3\n";

fn read(text: &str) -> Result<ControllerFile, String> {
    ControllerFile::parse(Path::new("lab/c.toml"), text).map_err(|error| error.to_string())
}

fn setup(law: impl Into<ControllerParameters>, sample_time: Seconds) -> ControllerFile {
    ControllerSetup::new(law, sample_time).into()
}

fn one_of_each() -> Vec<ControllerFile> {
    let t = Seconds(0.01);
    let function: FractionalTransferFunction = "3(s^0.5+1)/(0.01s+1)".parse().expect("valid");
    let mut pid = setup(
        PidParameters {
            proportional: 2.0,
            derivative: 0.1,
            derivative_order: 0.6,
            ..PidParameters::NONE
        },
        t,
    );
    pid.setup.set_point.proportional = 0.7;
    pid.setup.output_low = Some(-1.0 / 3.0);
    pid.setup.memory_s = Some(50.0);
    pid.origin.plant = "a \"plant\"\nof two lines".to_owned();
    vec![
        pid,
        setup(
            TidParameters {
                tilt: 2.0,
                tilt_divisor: 3.0,
                integral: 0.5,
                derivative: 0.1,
            },
            t,
        ),
        setup(
            CroneParameters {
                gain: 2.0,
                order: 0.6,
                low_rad_s: 1.0,
                high_rad_s: 100.0,
            },
            t,
        ),
        setup(
            LeadLagParameters {
                gain: 5.0,
                lambda_s: 0.5,
                x: 0.1,
                order: 0.7,
            },
            t,
        ),
        setup(function, t),
    ]
}

#[test]
fn every_controller_reads_back_to_the_same_and_runs() -> Tested {
    let memory = PowerMemory::new(Rule::Bdf2, 1e-6, 100.0)?;
    let plant: Plant = "exp(-0.05s)/(s+1)".parse()?;
    let plant = HeldPlant::new(&plant, memory, Seconds(0.01))?;
    for file in one_of_each() {
        let text = file.to_toml();
        assert_eq!(read(&text).as_ref(), Ok(&file), "{text}");
        let run = file.setup.simulate(&plant, &[1.0; 400])?;
        assert!(run.measured[399] > 0.2 && run.measured[399] < 1.5, "{text}");
        let verdict = file.setup.closed_with(&plant)?.verdict();
        assert!(verdict.stable, "{text}");
    }
    Ok(())
}

#[test]
fn a_function_as_a_controller_is_the_pid_it_is_equal_to_within_its_limits() -> Tested {
    let memory = PowerMemory::new(Rule::Bdf2, 1e-9, 100.0)?;
    let plant: Plant = "1/(s+1)".parse()?;
    let plant = HeldPlant::new(&plant, memory, Seconds(0.01))?;
    let controller = |file: &str| {
        let text = format!(
            "{file}\n[loop]\nsample_time_s = 0.01\noutput_high = 5\noutput_low = -5\nscheme = \"full-bdf2:1e-9\""
        );
        let file = read(&text).expect("valid");
        file.setup
            .simulate(&plant, &[1.0; 600])
            .expect("runs")
            .measured
    };
    let pid = controller(
        "[pid]\nproportional_gain = 3\nintegral_gain_per_s_lambda = 2\nintegral_order = 0.7\nset_point_weight = 1",
    );
    let function = controller("[transfer_function]\nfunction = \"(3s^0.7+2)/s^0.7\"");
    let apart = pid.iter().zip(&function).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart}");
    Ok(())
}

#[test]
fn what_is_wrong_is_said_in_one_line_with_its_place() {
    for [from, to, want] in testkit::table(
        r#"
        integral_order = 0.8 | integral_order = 2.5 | lab/c.toml:4: integral_order = 2.5 is not above 0 and at most 2
        sample_time_s = 0.01 |  | lab/c.toml:5: missing key `sample_time_s` in [loop]
        [pid] | [pdi] | lab/c.toml:1: unknown table [pdi]
        [loop] | [crone] | lab/c.toml:5: a second controller [crone]
        output_low = -3 | output_low = 4 | lab/c.toml:7: lower limit of the command 4 is not below
        output_low = -3 | scheme = "muir:3" | lab/c.toml:7: scheme "muir:3" is not for a controller
        [pid]\nproportional_gain = 2\nintegral_gain_per_s_lambda = 1\nintegral_order = 0.8\n | [transfer_function]\nfunction = "s^2/(s+1)"\n | lab/c.toml:2: the numerator's order 2 exceeds
        [pid]\nproportional_gain = 2\nintegral_gain_per_s_lambda = 1\nintegral_order = 0.8\n | [transfer_function]\nfunction = "(1-s)/(s+1)"\n | lab/c.toml:1: number of unstable zeros of a limited controller 1 is not 0
        "#,
    ) {
        let text = PID.replace(&from, &to);
        assert_ne!(text, PID, "{from}");
        let error = read(&text).expect_err(&want);
        assert!(error.starts_with(&want) && !error.contains('\n'), "{error}");
    }
}
