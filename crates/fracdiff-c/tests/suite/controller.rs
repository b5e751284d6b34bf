//! Controllers in C against controllers in Rust.

use super::{
    SAMPLES,
    bits::{COMPILERS, Compilers, WARNINGS, for_each},
    fnv, is_here, output, said_by, source, written,
};
use fracdiff::{Real, Scheme, Seconds};
use fracdiff_c::{CHeader, CNumber};
use fractional_control::{
    ControlError, Controller, ControllerList, ControllerParameters, ControllerSetup,
    CroneParameters, FractionalPid, LeadController, LeadLagParameters, Mode, PidParameters,
    SetPoint, Station, TidParameters,
};
use std::{
    path::{Path, PathBuf},
    process::Command,
};
use testkit::Folder;

const MODES: usize = 112;

/// A controller, and another one of its kind with what C calls the difference.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) setup: ControllerSetup,
    changed: ControllerSetup,
    pub(crate) change: &'static str,
}

impl Case {
    /// Those that run on the target too, the plain PI^λD^μ first.
    pub(crate) fn on_target() -> Vec<Self> {
        let all = cases().into_iter().enumerate();
        all.filter(|(index, _)| [0, 9, 11].contains(index))
            .map(|(_, case)| case)
            .collect()
    }
}

fn case<P: Into<ControllerParameters>>(
    name: &'static str,
    scheme: &str,
    [parameters, other]: [P; 2],
    limits: Option<[f64; 2]>,
    change: &'static str,
) -> Case {
    let setup = ControllerSetup {
        output_low: limits.map(|[low, _]| low),
        output_high: limits.map(|[_, high]| high),
        scheme: scheme.parse::<Scheme>().expect("a scheme"),
        ..ControllerSetup::new(parameters, Seconds(1e-3))
    };
    let changed = ControllerSetup {
        law: other.into(),
        ..setup.clone()
    };
    Case {
        name,
        setup,
        changed,
        change,
    }
}

/// PI^λD^μ with 200 s of memory at 1 kHz.
const PID: PidParameters = PidParameters {
    proportional: 2.0,
    integral: 3.0,
    integral_order: 0.8,
    derivative: 0.1,
    derivative_order: 0.6,
};

const STEEP: PidParameters = PidParameters {
    integral_order: 1.3,
    derivative: 1e-4,
    derivative_order: 1.4,
    ..PID
};
const WHOLE: PidParameters = PidParameters {
    integral_order: 1.0,
    derivative: 1e-3,
    derivative_order: 1.0,
    ..PID
};
const NO_INTEGRAL: PidParameters = PidParameters {
    integral: 0.0,
    ..PID
};
const TID: TidParameters = TidParameters {
    tilt: 2.0,
    tilt_divisor: 3.0,
    integral: 1.5,
    derivative: 1e-3,
};
const CRONE: CroneParameters = CroneParameters {
    gain: 2.0,
    order: 0.6,
    low_rad_s: 1.0,
    high_rad_s: 100.0,
};
const LEAD: LeadLagParameters = LeadLagParameters {
    gain: 1.5,
    lambda_s: 0.5,
    x: 0.1,
    order: 1.4,
};

/// Every law, both rules, orders beyond 1, limits and none, a derivative against the others, and parts that are not there.
pub(crate) fn cases() -> Vec<Case> {
    let limits = Some([-0.8, 1.2]);
    let pid = |parameters: PidParameters, scheme, limits| {
        let other = PidParameters {
            proportional: 1.25 * parameters.proportional,
            derivative: -parameters.derivative,
            ..parameters
        };
        let mut case = case(
            "pid",
            scheme,
            [parameters, other],
            limits,
            "to.proportional *= 1.25; to.derivative *= -1; to.derivative_weight = 0.5; to.low = -0.5",
        );
        case.changed.set_point = SetPoint {
            derivative: 0.5,
            ..case.setup.set_point
        };
        case.changed.output_low = Some(-0.5);
        case
    };
    vec![
        pid(PID, "full", limits),
        pid(PID, "full-bdf2", limits),
        pid(PID, "full:1e-4", None),
        pid(STEEP, "full", limits),
        pid(STEEP, "full-bdf2", None),
        pid(WHOLE, "full", limits),
        pid(NO_INTEGRAL, "full", limits),
        case(
            "gain",
            "full",
            [2.0, 2.5].map(|proportional| PidParameters {
                proportional,
                ..PidParameters::NONE
            }),
            limits,
            "to.proportional *= 1.25",
        ),
        // Parts of opposite signs, whose integral stands at a limit.
        case(
            "against",
            "full-bdf2",
            [-0.2, -1.0].map(|proportional| PidParameters {
                proportional,
                derivative: 0.0,
                ..WHOLE
            }),
            limits,
            "to.proportional = -1",
        ),
        case(
            "tid",
            "full",
            [TID, TidParameters { tilt: 1.0, ..TID }],
            limits,
            "to.tilt = 1",
        ),
        case(
            "crone",
            "full",
            [CRONE, CroneParameters { gain: 0.7, ..CRONE }],
            limits,
            "to.gain = 0.7",
        ),
        case(
            "lead",
            "full",
            [LEAD, LeadLagParameters { gain: 0.7, ..LEAD }],
            limits,
            "to.gain = 0.7",
        ),
        case(
            "lag",
            "full",
            [2.0, 1.5].map(|gain| LeadLagParameters {
                gain,
                order: -0.7,
                ..LEAD
            }),
            None,
            "to.gain = 1.5",
        ),
    ]
}

/// The hash of all commands, as `controller.c` has it.
pub(crate) fn hash<F: Real>(case: &Case) -> String {
    let (setup, changed) = (&case.setup, &case.changed);
    let t = setup.sample_time();
    let memory = |setup: &ControllerSetup| setup.memory().map(|memory| memory.fewest_modes());
    let pid = |setup: &ControllerSetup| -> Result<FractionalPid<F, MODES>, ControlError> {
        let (actuator, memory) = (setup.actuator()?, memory(setup)?);
        match setup.law {
            ControllerParameters::Pid(parameters) => {
                FractionalPid::new(parameters, setup.set_point, actuator, memory, t)
            }
            ControllerParameters::Tid(parameters) => {
                FractionalPid::tid(parameters, setup.set_point.derivative, actuator, memory, t)
            }
            ControllerParameters::Crone(_)
            | ControllerParameters::LeadLag(_)
            | ControllerParameters::Function(_)
            | _ => unreachable!("looked at before"),
        }
    };
    let lead = |setup: &ControllerSetup| -> Result<LeadController<F, MODES>, ControlError> {
        let (actuator, memory) = (setup.actuator()?, memory(setup)?);
        match setup.law {
            ControllerParameters::Crone(parameters) => {
                LeadController::crone(parameters, actuator, memory, t)
            }
            ControllerParameters::LeadLag(parameters) => {
                LeadController::lead_lag(parameters, actuator, memory, t)
            }
            ControllerParameters::Pid(_)
            | ControllerParameters::Tid(_)
            | ControllerParameters::Function(_)
            | _ => unreachable!("looked at before"),
        }
    };
    let setups = [setup, changed];
    if matches!(
        setup.law,
        ControllerParameters::Pid(_) | ControllerParameters::Tid(_)
    ) {
        commands(setups.map(|setup| pid(setup).expect("valid")))
    } else {
        commands(setups.map(|setup| lead(setup).expect("valid")))
    }
}

fn commands<F: Real, C: Controller<F> + Clone>(controllers: [C; 2]) -> String {
    let number = F::from_f64;
    let mut station = Station::new(controllers[0].clone());
    let (mut state, mut y) = (1_u32, F::ZERO);
    fnv((0..SAMPLES).map(|n| {
        let r = number(if (n / 5000).is_multiple_of(2) {
            1.0
        } else {
            -0.5
        });
        if n % 20_000 == 10_000 {
            let next = &controllers[usize::from(n % 40_000 == 10_000)];
            station.set_controller(next.clone(), r, y);
        }
        if n % 20_000 == 15_000 {
            let command = if n % 40_000 == 15_000 { 0.4 } else { f64::NAN };
            y += station.settle(y, y, number(command)).expect("settles") / number(1024.0);
        }
        let manner = (n / 3000) % 4;
        station.set_mode(match manner {
            3 => Mode::Manual(number(0.25)),
            _ => Mode::Automatic,
        });
        let fails = n % 1000 < 15 && (n / 1000) % 7 == 3;
        let read = if fails { number(f64::NAN) } else { y };
        let u = station.output(r, read);
        let applied = if manner == 2 { number(0.5) * u } else { u };
        let lost = match n % 100 {
            49 => Some(f64::NAN),
            99 => Some(f64::NEG_INFINITY),
            _ => None,
        };
        station.advance(r, read, lost.map_or(applied, number));
        assert!(u.is_finite(), "{n}");
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = number(f64::from(state >> 16) - 32768.0) / number(16_777_216.0);
        y += (applied - y) / number(128.0) + noise;
        u
    }))
}

/// 0.55exp(-s)/(62s+1) with the controller of the guide, whatever its actuator makes of a command.
#[test]
fn the_oven_of_the_guide_rests_at_its_reference_in_c() {
    let gains = "9.8+0.607/s^0.9-2.84s^0.606".parse::<PidParameters>();
    let setup = ControllerSetup {
        output_low: Some(0.0),
        output_high: Some(10.0),
        ..ControllerSetup::new(gains.expect("a controller"), Seconds(0.2))
    };
    let folder = Folder::empty();
    let header = header_of::<f32>(&setup, &folder);
    let program = folder.join("oven");
    if !is_here("cc") {
        return;
    }
    let mut compile = Command::new("cc");
    compile.args(COMPILERS[0].1).args(WARNINGS);
    compile.arg("-include").arg(header).arg(source("oven.c"));
    output(compile.arg("-o").arg(&program));
    for drive in [
        "1 0",
        "1 -1",
        "0.98 0",
        "0.85 0",
        "1 255",
        "1 1023",
        "0.98 4095",
    ] {
        let message = output(Command::new(&program).args(drive.split(' ')));
        let numbers: Vec<f64> = message
            .split(' ')
            .map(|n| n.parse().expect("a number"))
            .collect();
        assert!((numbers[0] - 3.0).abs() < 0.025 * 3.0, "{drive}: {message}");
        assert!(numbers[1] < 1e-6 * 3.0, "{drive}: {message}");
    }
}

/// The header of a controller in a folder.
pub(crate) fn header_of<F: CNumber>(setup: &ControllerSetup, folder: &Path) -> PathBuf {
    let list = ControllerList::<F>::new(setup).expect("a list");
    written(
        &CHeader::of_controller("op", &list, &[]).expect("a header"),
        folder,
    )
}

/// Case drawn in an order of its own: a controller with its set-point weights, whose loop is that of `controller.c`. Some signs are opposite.
fn drawn(index: u32) -> Case {
    let mut state = 0x9E37_79B9_u32.wrapping_mul(index + 1);
    let mut draw = |low: f64, high: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low + (high - low) * f64::from(state >> 8) / 16_777_216.0
    };
    let gains = PidParameters {
        proportional: draw(-2.0, 4.0),
        integral: draw(0.5, 6.0),
        integral_order: if index.is_multiple_of(3) {
            1.0
        } else {
            draw(0.4, 1.6)
        },
        derivative: draw(-0.05, 0.1),
        derivative_order: if index.is_multiple_of(4) {
            1.0
        } else {
            draw(0.3, 1.2)
        },
    };
    let scheme = if index.is_multiple_of(2) {
        "full:1e-4"
    } else {
        "full-bdf2:1e-4"
    };
    let high = draw(0.3, 1.2);
    let mut drawn = case("drawn", scheme, [gains; 2], Some([-high, high]), "(void)to");
    let set_point = SetPoint {
        proportional: f64::from(index % 5) / 4.0,
        derivative: f64::from(index % 7 / 6),
    };
    (drawn.setup.set_point, drawn.changed.set_point) = (set_point, set_point);
    drawn
}

/// `CAMPAIGN_CASES`: designs to try, 12 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn drawn_controllers_have_the_bits_of_rust_at_their_limits() {
    let all: Vec<Case> = (0..testkit::cases(12)).map(drawn).collect();
    for_each(&all, |case| has_the_same_bits::<f32>(case, &COMPILERS[..1]));
}

/// What a P-controller does not need is not there; all the others are compiled with the same warnings where their bits are compared.
#[test]
fn a_gain_alone_compiles_without_a_warning() {
    let gain = cases().into_iter().find(|case| case.name == "gain");
    has_the_same_bits::<f32>(&gain.expect("a case"), &COMPILERS[..1]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn controllers_have_the_same_bits_by_every_compiler() {
    for_each(&cases(), |case| {
        has_the_same_bits::<f32>(case, COMPILERS);
        has_the_same_bits::<f64>(case, &COMPILERS[..1]);
    });
}

fn has_the_same_bits<F: CNumber>(case: &Case, compilers: &Compilers) {
    let folder = Folder::empty();
    let header = header_of::<F>(&case.setup, &folder);
    let want = hash::<F>(case);
    let change = [format!("-DCHANGE={}", case.change)];
    for (have, by) in said_by::<F>(compilers, "controller.c", &header, &change) {
        assert_eq!(have, want, "{} {}, {by}", case.name, case.setup.scheme);
    }
}
