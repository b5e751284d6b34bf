//! Controllers in C against controllers in Rust.

use super::bits::{COMPILERS, Compilers, WARNINGS, for_each};
use super::{SAMPLES, fnv, is_here, output, source};
use fracdiff::{Real, Scheme, Seconds};
use fracdiff_c::{CNumber, Header};
use fractional_control::{
    ControlError, Controller, ControllerList, ControllerParameters, ControllerSetup,
    CroneParameters, FractionalPid, LeadController, LeadLagParameters, PidParameters, SetPoint,
    TidParameters,
};
use std::path::{Path, PathBuf};
use std::process::Command;

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
        all.filter(|(index, _)| [0, 7, 9].contains(index))
            .map(|(_, case)| case)
            .collect()
    }
}

fn case<P: Into<ControllerParameters>>(
    name: &'static str,
    scheme: &str,
    [own, other]: [P; 2],
    limits: Option<[f64; 2]>,
    change: &'static str,
) -> Case {
    let setup = ControllerSetup {
        output_low: limits.map(|[low, _]| low),
        output_high: limits.map(|[_, high]| high),
        scheme: scheme.parse::<Scheme>().expect("a scheme"),
        ..ControllerSetup::new(own, Seconds(1e-3))
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

/// Every law, both rules, orders beyond 1, limits and none, a derivative against the others, and parts that are not there.
pub(crate) fn cases() -> Vec<Case> {
    let limits = Some([-0.8, 1.2]);
    let pid = |own: PidParameters, scheme, limits| {
        let other = PidParameters {
            proportional: 1.25 * own.proportional,
            derivative: -own.derivative,
            ..own
        };
        let mut case = case(
            "pid",
            scheme,
            [own, other],
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
    let steep = PidParameters {
        integral_order: 1.3,
        derivative: 1e-4,
        derivative_order: 1.4,
        ..PID
    };
    let whole = PidParameters {
        integral_order: 1.0,
        derivative: 1e-3,
        derivative_order: 1.0,
        ..PID
    };
    let no_integral = PidParameters {
        integral: 0.0,
        ..PID
    };
    let tid = TidParameters {
        tilt: 2.0,
        tilt_divisor: 3.0,
        integral: 1.5,
        derivative: 1e-3,
    };
    let crone = CroneParameters {
        gain: 2.0,
        order: 0.6,
        low_rad_s: 1.0,
        high_rad_s: 100.0,
    };
    let lead = LeadLagParameters {
        gain: 1.5,
        lambda_s: 0.5,
        x: 0.1,
        order: 1.4,
    };
    vec![
        pid(PID, "full", limits),
        pid(PID, "full-bdf2", limits),
        pid(PID, "full:1e-4", None),
        pid(steep, "full", limits),
        pid(steep, "full-bdf2", None),
        pid(whole, "full", limits),
        pid(no_integral, "full", limits),
        case(
            "tid",
            "full",
            [tid, TidParameters { tilt: 1.0, ..tid }],
            limits,
            "to.tilt = 1",
        ),
        case(
            "crone",
            "full",
            [crone, CroneParameters { gain: 0.7, ..crone }],
            limits,
            "to.gain = 0.7",
        ),
        case(
            "lead",
            "full",
            [lead, LeadLagParameters { gain: 0.7, ..lead }],
            limits,
            "to.gain = 0.7",
        ),
        case(
            "lag",
            "full",
            [2.0, 1.5].map(|gain| LeadLagParameters {
                gain,
                order: -0.7,
                ..lead
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
            ControllerParameters::Pid(own) => {
                FractionalPid::new(own, setup.set_point, actuator, memory, t)
            }
            ControllerParameters::Tid(own) => {
                FractionalPid::tid(own, setup.set_point.derivative, actuator, memory, t)
            }
            _ => unreachable!("looked at before"),
        }
    };
    let lead = |setup: &ControllerSetup| -> Result<LeadController<F, MODES>, ControlError> {
        let (actuator, memory) = (setup.actuator()?, memory(setup)?);
        match setup.law {
            ControllerParameters::Crone(own) => LeadController::crone(own, actuator, memory, t),
            ControllerParameters::LeadLag(own) => {
                LeadController::lead_lag(own, actuator, memory, t)
            }
            _ => unreachable!("looked at before"),
        }
    };
    match setup.law {
        ControllerParameters::Pid(_) | ControllerParameters::Tid(_) => {
            commands([setup, changed].map(|setup| pid(setup).expect("valid")))
        }
        _ => commands([setup, changed].map(|setup| lead(setup).expect("valid"))),
    }
}

fn commands<F: Real, C: Controller<F>>(controllers: [C; 2]) -> String {
    let number = F::from_f64;
    let mut now = &controllers[0];
    let mut history = now.at_rest();
    let (mut state, mut y) = (1_u32, F::ZERO);
    fnv((0..SAMPLES).map(|n| {
        let r = number(if (n / 5000).is_multiple_of(2) {
            1.0
        } else {
            -0.5
        });
        if n % 20_000 == 10_000 {
            let next = &controllers[usize::from(n % 40_000 == 10_000)];
            history = next.take_over(now, &history, r, y);
            now = next;
        }
        let u = now.output(&history, r, y);
        let applied = match (n / 3000) % 4 {
            2 => number(0.5) * u,
            3 => number(0.25),
            _ => u,
        };
        if (n / 3000) % 4 == 3 {
            now.follow(&mut history, r, y, applied);
        } else {
            now.advance(&mut history, r, y, applied);
        }
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = number(f64::from(state >> 16) - 32768.0) / number(16_777_216.0);
        y += (applied - y) / number(128.0) + noise;
        u
    }))
}

/// The header of a controller in a folder.
pub(crate) fn header_of<F: CNumber>(setup: &ControllerSetup, folder: &Path) -> PathBuf {
    let list = ControllerList::<F>::new(setup).expect("a list");
    let header = Header::of_controller("op", &list, &[]).expect("a header");
    let path = folder.join("op.h");
    std::fs::write(&path, header.to_string()).expect("writes");
    path
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
    let folder = tempfile::tempdir().expect("a folder");
    let header = header_of::<F>(&case.setup, folder.path());
    let program = folder.path().join("run");
    let want = hash::<F>(case);
    for (compiler, flags) in compilers.iter().filter(|(compiler, _)| is_here(compiler)) {
        let mut compile = Command::new(compiler);
        compile
            .args(*flags)
            .args(WARNINGS)
            .arg(format!("-DREAL={}", F::TYPE));
        compile
            .arg(format!("-DCHANGE={}", case.change))
            .arg("-include")
            .arg(&header);
        compile.args([source("controller.c"), source("host.c")]);
        output(compile.arg("-o").arg(&program));
        let have = output(&mut Command::new(&program));
        assert_eq!(
            have, want,
            "{} {}, {compiler} {flags:?}",
            case.name, case.setup.scheme
        );
    }
}
