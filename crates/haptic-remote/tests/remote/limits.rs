//! The safety chain of a device, set and told over the line.

mod ranges;

use crate::line::{Bench, START, spring};
use haptic_link::{
    Configuration, DeviceReport, Guard, GuardKind, Limits, LoopMode, OperatorShape, Refusal,
    Request, Start, State,
};
use haptic_loop::Fault;

/// A plain spring on the testbed that a hand pushes with 1 N, with these limits.
fn plain(stiffness_n_per_m: f32, limits: Limits) -> Configuration {
    Configuration {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m: 0.0,
        operator: OperatorShape {
            count: 1,
            ..Configuration::PASSIVE.operator
        },
        limits,
        ..spring().0
    }
}

fn set(bench: &mut Bench, configuration: Configuration) -> Result<DeviceReport, Refusal> {
    bench.hello();
    bench.set(configuration, &[0.0])
}

fn armed(configuration: Configuration) -> Bench {
    let mut bench = Bench::configured(configuration, &[0.0]);
    bench.arm();
    bench
}

/// Runs for so long.
fn ran(configuration: Configuration, milliseconds: u64) -> Bench {
    let mut bench = armed(configuration);
    bench.done(Request::Start(START));
    bench.run_ms(milliseconds);
    bench
}

const GUARD: Guard = Guard {
    kind: GuardKind::EnergyBounding,
    damping_n_s_per_m: 3.5,
    ..Guard::OFF
};

/// Standard deviation of the last 400 positions, m.
fn restlessness(bench: &Bench) -> f64 {
    let positions = bench
        .samples()
        .map(|sample| f64::from(sample.axes[0].position_m));
    let positions: Vec<f64> = positions.collect();
    let last = &positions[positions.len() - 400..];
    let mean = last.iter().sum::<f64>() / 400.0;
    let squares: f64 = last.iter().map(|x| (x - mean) * (x - mean)).sum();
    (squares / 400.0).sqrt()
}

#[test]
fn a_guard_on_the_device_keeps_an_unstable_wall_calm() {
    // 2b/T is 7000 N/m: this wall shakes.
    let limits = |guard| Limits {
        guard,
        ..Limits::bare(100.0, 1e6)
    };
    let shaking = ran(plain(20_000.0, limits(Guard::OFF)), 2000);
    assert!(restlessness(&shaking) > 1e-4, "{}", restlessness(&shaking));
    assert_eq!(shaking.energy_j, Some(0.0));
    let observer = Guard {
        kind: GuardKind::Observer,
        // m/(2T)
        damping_n_s_per_m: 32.5,
        ..Guard::OFF
    };
    for guard in [GUARD, observer] {
        let calm = ran(plain(20_000.0, limits(guard)), 2000);
        assert_eq!(calm.state(), State::Running);
        let left = restlessness(&calm);
        assert!(left < 1e-6, "{:?}: {left}", guard.kind);
        // The guard acted, and what it observed is told.
        let acted = calm
            .samples()
            .any(|sample| sample.axes[0].limiters & 128 != 0);
        assert!(acted, "{:?}", guard.kind);
        let energy = calm.energy_j.expect("keep-alives were answered");
        assert!(
            energy.is_finite() && energy != 0.0,
            "{:?}: {energy}",
            guard.kind
        );
    }
}

#[test]
fn a_device_that_leaves_its_workspace_or_is_too_fast_latches_its_fault() {
    // 1 N on 100 N/m: 10 mm at rest.
    let workspace = Limits {
        workspace_low_m: -0.01,
        workspace_high_m: 0.005,
        ..Limits::bare(10.0, 1e4)
    };
    let speed = Limits {
        speed_hard_m_per_s: 0.05,
        ..Limits::bare(10.0, 1e4)
    };
    for (limits, want) in [(workspace, Fault::Workspace), (speed, Fault::Velocity)] {
        let bench = ran(plain(100.0, limits), 500);
        assert_eq!(bench.told_fault().map(|(fault, _)| fault), Some(want));
        assert_eq!((bench.state(), bench.force_n()), (State::Fault, 0.0));
        let status = bench.device.borrow().status();
        assert_eq!((status.fault, status.faults), (want.code(), 1));
    }
    let within = ran(
        plain(
            100.0,
            Limits {
                workspace_high_m: 0.02,
                speed_hard_m_per_s: 1.0,
                ..workspace
            },
        ),
        500,
    );
    assert_eq!(
        (within.told_fault(), within.state()),
        (None, State::Running)
    );
}

#[test]
fn a_run_that_would_begin_with_a_blow_is_refused() {
    // The device starts 10 mm deep in a wall of 1000 N/m.
    let inside = |start_force_n| Configuration {
        one_sided: true,
        surface_m: -0.01,
        ..plain(
            1000.0,
            Limits {
                start_force_n,
                ..Limits::bare(20.0, 1e4)
            },
        )
    };
    let mut bench = armed(inside(1.0));
    let (wanted_n, allowed_n) = not_small(bench.refused(Request::Start(START)));
    assert!((wanted_n - 10.0).abs() < 1e-5, "{wanted_n}");
    assert_eq!(allowed_n, 1.0);
    assert_eq!((bench.state(), bench.force_n()), (State::Armed, 0.0));
    // A limit that allows it, or none.
    for allowed in [10.5, 0.0] {
        let bench = ran(inside(allowed), 5);
        assert_eq!(bench.state(), State::Running, "{allowed}");
        assert!(bench.force_n() < -5.0);
    }
    // A host begins with no force.
    let mut bench = armed(Configuration {
        loop_mode: LoopMode::Host,
        ..inside(1.0)
    });
    bench.done(Request::Start(Start { run: 3, ..START }));
    // Not a number is not small either.
    let mut bench = armed(Configuration {
        stiffness_n_per_m: f32::MAX,
        surface_m: -1e3,
        ..inside(0.0)
    });
    let (wanted_n, allowed_n) = not_small(bench.refused(Request::Start(START)));
    assert!(!wanted_n.is_finite() && allowed_n.is_infinite());
}

#[test]
fn a_device_pushes_by_itself_only_within_force_workspace_and_speed() {
    let limits = Limits {
        workspace_low_m: -0.1,
        workspace_high_m: 0.1,
        speed_hard_m_per_s: 1.0,
        rise_time_s: 0.0,
        start_force_n: 0.1,
        ..Limits::bare(5.0, 1e4)
    };
    let tapped = |own_push_n, tap_n, limits| Configuration {
        own_push_n,
        tap_n,
        tap_ticks: 500,
        simulation: haptic_link::Simulation::TESTBED,
        ..plain(1000.0, limits)
    };
    // At rest 2 mm deep, and 1 mm deeper where it taps.
    for (tap_n, deep_m) in [(0.0, 2e-3), (1.0, 3e-3)] {
        let bench = ran(tapped(2.0, tap_n, limits), 2000);
        let deep = bench.samples().last().map(|sample| sample.axes[0]);
        let deep = deep.expect("it ran");
        assert!((deep.position_m - deep_m).abs() < 1e-5, "{deep:?}");
        assert!(deep.force_n.abs() < 0.05, "{deep:?}");
    }
    let none = Limits {
        workspace_low_m: 0.0,
        workspace_high_m: 0.0,
        ..limits
    };
    let fast = Limits {
        speed_hard_m_per_s: 0.0,
        ..limits
    };
    for (push, tap, limits) in [
        (2.0, 0.0, none),
        (2.0, 0.0, fast),
        (0.0, 2.0, none),
        (0.0, 2.0, fast),
        (5.1, 0.0, limits),
        (-5.1, 0.0, limits),
        (f32::NAN, 0.0, limits),
        (3.0, 2.1, limits),
        (0.0, f32::NAN, limits),
    ] {
        let refused = set(&mut Bench::ideal(), tapped(push, tap, limits));
        assert!(refused.is_err(), "{push} {tap} {limits:?}: {refused:?}");
    }
}

/// Wanted and allowed force of a refused start, N.
fn not_small(refusal: Refusal) -> (f32, f32) {
    let Refusal::ForceNotSmall {
        wanted_n,
        allowed_n,
    } = refusal
    else {
        panic!("{refusal:?}");
    };
    (wanted_n, allowed_n)
}
