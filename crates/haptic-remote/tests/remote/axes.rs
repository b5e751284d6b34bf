//! A device of two axes: vectors, limits of the norm, a box, enemies.

use crate::{
    line::beyond,
    plane::{FORCE_N, Plane, configuration},
};
use haptic_emulator::LineFaults;
use haptic_link::{
    AxisWorkspace, DeviceReport, DigestBuilder, Field, Refusal, Request, Sample, SampleBatch,
    Scope, State, WorkspaceBox,
};
use haptic_loop::Fault;

fn forces(tick: u32, force_n: &[f32]) -> Request {
    Request::Force {
        tick,
        force_n: force_n.iter().copied().collect(),
    }
}

/// A spring to 0 of 200 N/m, the same on each axis, and a push along y.
fn spring(sample: &Sample) -> Request {
    let force: Vec<f32> = (sample.axes.iter().zip([0.0, 0.5]))
        .map(|(axis, push)| push - 200.0 * axis.position_m)
        .collect();
    forces(sample.tick, &force)
}

#[test]
fn a_spring_of_the_host_holds_both_axes_where_it_should() {
    let mut bench = Plane::running(spring);
    bench.run_ms(2000);
    assert_eq!(bench.state(), State::Running);
    let samples: Vec<&Sample> = bench.samples().collect();
    let last = samples.last().expect("came");
    assert_eq!(last.axes.len(), 2);
    // 1 N of the hand along x, 0.5 N of the host along y, on 200 N/m.
    for (axis, rest_m) in last.axes.iter().zip([1.0 / 200.0, 0.5 / 200.0]) {
        assert!((axis.position_m - rest_m).abs() < 1e-6, "{last:?}");
    }
    // Each tick is told once, with the force that answers the position of a tick before.
    for pair in samples.windows(2) {
        assert_eq!(pair[1].tick, pair[0].tick + 1);
        let wanted = 0.5 - 200.0 * pair[0].axes[1].position_m;
        assert_eq!(pair[1].axes[1].environment_force_n, wanted);
        assert_eq!(pair[1].axes[1].force_n, wanted);
    }
}

#[test]
fn the_norm_is_limited_and_the_direction_kept() {
    let law = |sample: &Sample| forces(sample.tick, &[1.5, -2.0]);
    let mut bench = Plane::running(law);
    bench.run_ms(20);
    let newest = bench.device.borrow().newest().force_n;
    assert!((newest[0] - 0.6 * FORCE_N).abs() < 1e-5, "{newest:?}");
    assert!((newest[1] + 0.8 * FORCE_N).abs() < 1e-5, "{newest:?}");
    let largest = bench.norms.iter().copied().fold(0.0, f32::max);
    assert!(largest <= FORCE_N * (1.0 + f32::EPSILON), "{largest} N");
}

#[test]
fn what_is_not_finite_on_one_axis_is_a_fault_of_both() {
    for bad in [f32::NAN, f32::INFINITY] {
        let law = move |sample: &Sample| match sample.tick {
            0..100 => forces(sample.tick, &[1.0, -1.0]),
            _ => forces(sample.tick, &[1.0, bad]),
        };
        let mut bench = Plane::running(law);
        bench.falls_to_zero(Fault::NonFiniteForce);
    }
}

#[test]
fn forces_of_another_number_of_axes_are_none_and_the_watchdog_sees_it() {
    let wrong: [fn(u32) -> Request; 3] = [
        |tick| forces(tick, &[1.0]),
        |tick| forces(tick, &[1.0, -1.0, 1.0]),
        |tick| forces(tick, &[]),
    ];
    for wrong in wrong {
        let law = move |sample: &Sample| match sample.tick {
            0..100 => forces(sample.tick, &[1.0, -1.0]),
            tick => wrong(tick),
        };
        let mut bench = Plane::running(law);
        bench.falls_to_zero(Fault::HostSilent);
        let (_, tick) = bench.told_fault().expect("told");
        assert!((118..=124).contains(&tick), "{tick}");
    }
}

#[test]
fn a_host_that_falls_silent_leaves_no_force() {
    // A force that is too old is a fault of its own.
    for fault in [Fault::HostSilent, Fault::StaleForce] {
        let law = |sample: &Sample| forces(sample.tick.min(100), &[1.0, -1.0]);
        let mut bench = Plane::running(law);
        if fault == Fault::HostSilent {
            bench.run_ms(50);
            bench.vector_law = None;
        }
        bench.falls_to_zero(fault);
    }
}

#[test]
fn on_a_bad_line_no_force_is_beyond_its_limit() {
    let faults = LineFaults {
        drop: 0.05,
        corrupt: 0.1,
        duplicate: 0.05,
        reorder: 0.05,
        ..LineFaults::default()
    };
    let mut n = 0_u32;
    let law = move |sample: &Sample| {
        // Forces that change wildly, and are no limit's friends.
        n = n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let part = |shift: u32| f32::from((n >> shift) as u8) - 128.0;
        forces(sample.tick, &[part(8), part(16)])
    };
    let mut bench = Plane::on_line(faults, law);
    bench.run_ms(5000);
    let largest = bench.norms.iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.9 * FORCE_N, "{largest} N");
    assert!(largest <= FORCE_N * (1.0 + f32::EPSILON), "{largest} N");
}

#[test]
fn ticks_come_in_batches_and_the_recorder_tells_vectors() {
    let mut bench = Plane::running(spring);
    bench.run_ms(200);
    bench.vector_law = None;
    bench.run_ms(300);
    assert_eq!(bench.fault(), Some(Fault::HostSilent));
    let first = bench.flight(0);
    assert_eq!((first.index, first.count), (0, 96));
    let samples: Vec<Sample> = bench.samples().cloned().collect();
    for index in 0..first.count {
        let flight = bench.flight(index);
        assert_eq!(flight.sample.tick, first.sample.tick + u32::from(index));
        assert!(samples.contains(&flight.sample), "{flight:?}");
    }
    bench.reports.clear();
    bench
        .answered(Request::Stream {
            every: 1,
            batch: 16,
        })
        .expect("streams");
    bench.run_ms(100);
    let batches: Vec<&SampleBatch> = (bench.reports.iter())
        .filter_map(|report| {
            if let DeviceReport::Batch(batch) = report {
                Some(batch)
            } else {
                None
            }
        })
        .collect();
    assert!(!batches.is_empty());
    for batch in batches {
        assert!(batch.items.len() <= 16 && batch.axes == 2);
        let ticks: Vec<u32> = batch.samples(1000).map(|sample| sample.tick).collect();
        assert!(ticks.len() <= SampleBatch::ticks_most(2, false));
        assert!(ticks.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
}

fn square(half_m: f32) -> WorkspaceBox {
    let axis = AxisWorkspace {
        low_m: -half_m,
        high_m: half_m,
        soft_m: 0.0,
    };
    WorkspaceBox {
        axes: [axis; 2].into_iter().collect(),
    }
}

#[test]
fn beyond_its_own_range_of_places_an_axis_is_in_a_fault() {
    let mut bench = Plane::set_to_last(LineFaults::default());
    let mut narrow = square(0.05);
    narrow.axes[0].high_m = 0.004;
    bench
        .set_within(configuration(), Some(narrow), Scope::Run)
        .expect("a box");
    bench.starts(spring);
    // It comes to rest at 5 mm.
    bench.falls_to_zero(Fault::Workspace);
    let mut samples = bench.samples();
    let breach = samples.find(|sample| sample.axes[0].position_m > 0.004);
    let fault = bench.told_fault().map(|(_, tick)| tick);
    assert_eq!(breach.map(|sample| sample.tick), fault);
}

#[test]
fn a_box_that_is_none_or_would_last_is_refused() {
    let mut bench = Plane::set_to_last(LineFaults::default());
    let unsupported = Refusal::Unsupported(Field::WorkspaceLow);
    // Nothing is staged.
    assert_eq!(
        bench.answered(Request::Workspace(square(0.05))),
        Err(Refusal::Incomplete)
    );
    let lasting = bench.set_within(configuration(), Some(square(0.05)), Scope::Lasting);
    assert_eq!(lasting, Err(unsupported));
    let mut line = square(0.05);
    line.axes.truncate(1);
    assert_eq!(
        bench.set_within(configuration(), Some(line), Scope::Run),
        Err(unsupported)
    );
    let mut turned = square(0.05);
    turned.axes[1].low_m = 0.06;
    let refused = bench.set_within(configuration(), Some(turned), Scope::Run);
    assert_eq!(beyond(&refused), Some(Field::WorkspaceHigh));
    // Wider than that of all axes.
    let mut bounded = configuration();
    bounded.limits.workspace_low_m = -0.04;
    bounded.limits.workspace_high_m = 0.04;
    let refused = bench.set_within(bounded, Some(square(0.05)), Scope::Run);
    assert_eq!(beyond(&refused), Some(Field::WorkspaceLow));
    bench
        .set_within(bounded, Some(square(0.04)), Scope::Run)
        .expect("within");
}

#[test]
fn the_digest_has_to_know_of_a_box() {
    let mut bench = Plane::set_to_last(LineFaults::default());
    let bounded = configuration();
    bench.answered(Request::Configure(bounded)).expect("staged");
    let block = haptic_link::CoefficientBlock::of(&[0.0], 0);
    bench
        .answered(Request::Coefficients(block))
        .expect("staged");
    bench
        .answered(Request::Workspace(square(0.03)))
        .expect("staged");
    let digest = DigestBuilder::new(&bounded).coefficients(&[0.0]).finish();
    let scope = Scope::Run;
    let refused = bench.answered(Request::Commit { digest, scope });
    assert_eq!(refused, Err(Refusal::Digest));
}
