//! A law behind a surface that a device of several axes renders by itself: the bits of the host's, within the device's own limits.

use crate::line::{Bench, START, beyond, transaction};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_emulator::LineFaults;
use haptic_link::{
    Capabilities, Configuration, DeviceReport, DigestBuilder, Direction, FRAME_MAX, Field, Limits,
    LoopMode, Receiver, Refusal, Request, Sample, Scope, Simulation, Start, State, SurfaceKind,
    SurfaceShape, WorkspaceBox, encode,
};
use haptic_loop::{
    Ball, Contact, DepthMap, Device, Environment, Fault, Plane, Reading, SafeForce, Shape,
    SpringDamper, Surface as _, units::Metres,
};
use haptic_remote::{
    DeviceSession, Hardware, SimulatedAxes, TickSide, abilities, operator_shape,
    serial::{Companions, Pipe, SerialLink},
    wire_surface,
};
use nalgebra::SVector;
use std::{
    cell::RefCell,
    io::{Read as _, Write as _},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};
use testkit::{Tested, assert_refused};

const T: Seconds = Seconds(1e-3);
const K: f64 = 300.0;
const B: f64 = 5.0;
const LIMITS: Limits = Limits {
    watchdog_ms: 20,
    start_force_n: 1.0,
    ..Limits::bare(2.0, 1000.0)
};

/// A board that is led along a path, whatever the force.
#[derive(Debug)]
struct Led<const D: usize> {
    path: Path<D>,
    tick: u32,
}

/// Where it is in each tick, m.
type Path<const D: usize> = fn(u32) -> [f32; D];

impl<const D: usize> Device<f32, D> for Led<D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: (self.path)(self.tick).into(),
        })
    }

    fn write(&mut self, _: SafeForce<f32, D>) -> Result<(), Fault> {
        self.tick += 1;
        Ok(())
    }

    fn let_go(&mut self) {}
}

impl<const D: usize> Hardware<D> for Led<D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: 100.0,
            force_rate_max_n_per_s: 1e6,
            ..abilities("led", D as u8)
        }
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.tick = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.read()
    }
}

/// All that a run is set to.
#[derive(Clone, Debug)]
struct Run {
    configuration: Configuration,
    values: Vec<f32>,
    workspace: Option<WorkspaceBox>,
    surface: Option<SurfaceShape>,
}

/// The tissue's own law; its memory is of modes, as a long one is.
fn operator() -> Operator<f32> {
    let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
    let order = Order::new(0.5).expect("valid");
    scheme.build(order, T, 4000.0).expect("valid")
}

/// That of a sphere of 10 mm that presses.
fn map() -> DepthMap<f32> {
    let numbers = [100.0, 0.0, 0.8, 0.1, 0.0, 0.0, 0.0, 20.0];
    DepthMap::of(numbers).expect("a map")
}

fn run<const D: usize>(shape: &Shape<f64, D>, map: Option<DepthMap<f32>>) -> Run {
    let (operator, values) = operator_shape(&operator()).expect("a device's");
    Run {
        configuration: Configuration {
            stiffness_n_per_m: K as f32,
            dissipation_n_s_mu_per_m: B as f32,
            one_sided: true,
            operator,
            limits: LIMITS,
            depth_map: map.map(|map| map.numbers()),
            ..Configuration::PASSIVE
        },
        values,
        workspace: None,
        surface: Some(wire_surface(shape)),
    }
}

fn plane<const D: usize>(normal: [f64; D], surface_m: f64) -> Shape<f64, D> {
    Shape::Plane(Plane::new(normal, Metres(surface_m)).expect("valid"))
}

fn ball<const D: usize>(centre_m: [f64; D], radius_m: f64) -> Shape<f64, D> {
    let ball = Ball::solid(centre_m.map(Metres), Metres(radius_m));
    Shape::Ball(ball.expect("valid"))
}

fn hollow<const D: usize>(centre_m: [f64; D], radius_m: f64) -> Shape<f64, D> {
    let ball = Ball::hollow(centre_m.map(Metres), Metres(radius_m));
    Shape::Ball(ball.expect("valid"))
}

impl<H: Hardware<D>, const D: usize> Bench<H, D> {
    fn on(hardware: H) -> Self {
        let device = TickSide::new(hardware).expect("starts");
        let mut bench = Self::with(device, LineFaults::default(), 1);
        bench.loosen();
        bench
    }

    /// Connects, and sets the limits of all runs here to last.
    fn loosen(&mut self) {
        self.hello();
        let bare = Configuration {
            limits: LIMITS,
            ..Configuration::PASSIVE
        };
        self.set(bare, &[0.0]).expect("good");
    }

    /// Sets it; what is staged beside the configuration goes before the commit.
    fn set_to(&mut self, run: &Run, scope: Scope) -> Result<DeviceReport, Refusal> {
        for request in transaction(run.configuration, &run.values) {
            self.answered(request)?;
        }
        let mut digest = DigestBuilder::new(&run.configuration).coefficients(&run.values);
        if let Some(workspace) = &run.workspace {
            self.answered(Request::Workspace(workspace.clone()))?;
            digest = digest.workspace(workspace);
        }
        if let Some(surface) = &run.surface {
            self.answered(Request::Surface(surface.clone()))?;
            digest = digest.surface(surface);
        }
        let digest = digest.finish();
        self.answered(Request::Commit { digest, scope })
    }

    fn runs(&mut self, run: &Run, ticks: u32) {
        self.set_to(run, Scope::Run).expect("good");
        self.arm();
        self.done(Request::Start(Start { ticks, ..START }));
    }
}

/// The host's own, in single precision, of the numbers in double precision that were sent: another way to them than the device's.
fn on_host<const D: usize>(shape: &Shape<f64, D>) -> Shape<f32, D> {
    let numbers = shape.numbers();
    let distance = Metres(numbers.distance);
    match shape {
        Shape::Plane(_) => Shape::Plane(Plane::new(numbers.place, distance).expect("valid")),
        Shape::Ball(_) => Shape::Ball(
            if numbers.kind == haptic_loop::ShapeKind::HollowBall {
                Ball::hollow(numbers.place.map(Metres), distance)
            } else {
                Ball::solid(numbers.place.map(Metres), distance)
            }
            .expect("valid"),
        ),
    }
}

/// Holds each force of a run against that of the host's contact for the positions that the device told; largest force and ticks outside.
fn same_bits<H: Hardware<D>, const D: usize>(
    hardware: H,
    shape: &Shape<f64, D>,
    map: Option<DepthMap<f32>>,
) -> (f32, u32) {
    const TICKS: u32 = 3000;
    let mut plan = run(shape, map);
    if hardware.capabilities().simulated {
        plan.configuration.simulation = pushed();
    }
    let mut bench = Bench::on(hardware);
    bench.runs(&plan, TICKS);
    bench.run_ms(u64::from(TICKS) + 300);
    let law = SpringDamper::new(K, B, operator()).expect("valid");
    let contact = Contact::behind(on_host(shape), law).with_depth_map(map);
    let mut history = Environment::<f32, D>::at_rest(&contact);
    let (mut next, mut largest_n, mut outside) = (0, 0.0_f32, 0);
    for sample in bench.samples().filter(|sample| sample.tick < TICKS) {
        assert_eq!(sample.tick, next);
        let position_m = SVector::from_fn(|axis, _| sample.axes[axis].position_m);
        let want: SVector<f32, D> = contact.force(&history, &position_m);
        for (axis, want) in sample.axes.iter().zip(&want) {
            let have = axis.environment_force_n;
            assert_eq!(have.to_bits(), want.to_bits(), "tick {next}: {have} {want}");
            if axis.limiters == 0 {
                assert_eq!(axis.force_n.to_bits(), want.to_bits());
            }
        }
        contact.advance(&mut history, &position_m);
        largest_n = largest_n.max(want.norm());
        outside += u32::from(contact.surface().depth(&position_m) < 0.0);
        next += 1;
    }
    assert_eq!(next, TICKS, "{:?}", bench.told_fault());
    (largest_n, outside)
}

/// The testbed in a soft hand, pushed along x.
fn pushed() -> Simulation {
    Simulation {
        hand_stiffness_n_per_m: 20.0,
        push_n: 0.5,
        ..Simulation::TESTBED
    }
}

/// Path in and out of all shapes below, and round them: millimetres.
fn path<const D: usize>(tick: u32) -> [f32; D] {
    let s = 0.004 * tick as f32;
    let all = [
        4e-3 * s.sin(),
        3e-3 * (1.7 * s).sin(),
        2e-3 * (0.6 * s).sin(),
    ];
    core::array::from_fn(|axis| all[axis])
}

fn shapes<const D: usize>() -> [(Shape<f64, D>, bool); 4] {
    let axes = |all: [f64; 3]| core::array::from_fn(|axis| all[axis]);
    [
        // Away from 0 all are outside; the last is passed through in the middle.
        (plane(axes([0.3, -0.5, 0.9]), 1e-4), true),
        (ball(axes([0.022, 0.003, -0.001]), 0.02), true),
        (hollow(axes([1e-4, -2e-4, 1e-4]), 0.003), true),
        (ball(axes([0.0, 0.0, 0.0]), 0.01), false),
    ]
}

fn has_the_bits<const D: usize>() {
    for map in [None, Some(map())] {
        for (number, (shape, closes)) in shapes::<D>().iter().enumerate() {
            let led = Led { path, tick: 0 };
            let (largest_n, outside) = if *closes {
                same_bits(led, shape, map)
            } else {
                // It begins in the middle, at full depth, where a start would be a blow.
                let from_outside = |tick: u32| match tick {
                    0..1000 => {
                        let mut place = [0.0; D];
                        place[1] = 0.02 - 2e-5 * tick as f32;
                        place
                    }
                    _ => path(tick),
                };
                let led = Led {
                    path: from_outside,
                    tick: 0,
                };
                same_bits(led, shape, map)
            };
            assert!(
                largest_n > 0.2 && outside > 100,
                "{number}: {largest_n} N, {outside}"
            );
            if *closes {
                let (largest_n, outside) = same_bits(SimulatedAxes::<D>::new("axes"), shape, map);
                assert!(
                    largest_n > 0.05 && outside > 0,
                    "{number}: {largest_n} N, {outside}"
                );
            }
        }
    }
}

#[test]
fn two_axes_render_each_shape_with_the_bits_of_the_host() {
    has_the_bits::<2>();
}

#[test]
fn three_axes_render_each_shape_with_the_bits_of_the_host() {
    has_the_bits::<3>();
}

#[test]
fn a_start_deep_inside_is_refused_even_in_the_middle_of_a_ball() {
    let at = |place: Path<2>| Led {
        path: place,
        tick: 0,
    };
    let disc = run(&ball([0.0, 0.0], 0.02), None);
    let cases: [(Path<2>, bool); 4] = [
        (|_| [0.0, 0.0], false),
        (|_| [0.0, 0.01], false),
        (|_| [0.0, 0.021], true),
        // 0.9 N at most: a start within the limit.
        (|_| [0.0, 0.0199], true),
    ];
    for (number, (place, starts)) in cases.into_iter().enumerate() {
        let mut bench = Bench::on(at(place));
        bench.set_to(&disc, Scope::Run).expect("good");
        bench.arm();
        let started = bench.answered(Request::Start(START));
        match started {
            Ok(_) => assert!(starts, "{number}"),
            Err(Refusal::ForceNotSmall { allowed_n, .. }) => {
                assert!(!starts, "{number}");
                assert_eq!((allowed_n, bench.state()), (1.0, State::Armed));
            }
            Err(refusal) => panic!("{number}: {refusal:?}"),
        }
        bench.run_ms(20);
        assert!(starts || bench.norms.iter().all(|norm| *norm == 0.0));
    }
}

#[test]
fn what_is_no_surface_of_this_device_is_refused_before_a_force() {
    let edge = run(&plane([0.6, 0.8], 0.0), None);
    let disc = run(&ball([0.05, 0.0], 0.02), None);
    let room = run(&hollow([0.0, 0.0], 0.02), None);
    let mut bench = Bench::on(SimulatedAxes::<2>::new("axes"));
    let before = bench.done(Request::GetConfiguration);
    type Change = fn(&mut SurfaceShape);
    let mut cases: Vec<(&Run, Change)> = vec![
        (&edge, |surface| surface.axes[0] = 0.7),
        (&edge, |surface| surface.axes[1] = 0.0),
        (&edge, |surface| surface.axes[1] = f32::NAN),
        (&edge, |surface| surface.axes[1] = f32::INFINITY),
        (&edge, |surface| {
            surface.axes.iter_mut().for_each(|n| *n = 0.0);
        }),
        (&edge, |surface| surface.distance_m = f32::NAN),
        (&edge, |surface| surface.distance_m = f32::INFINITY),
    ];
    for round in [&disc, &room] {
        let bad: [Change; 6] = [
            |surface| surface.distance_m = 0.0,
            |surface| surface.distance_m = -0.02,
            |surface| surface.distance_m = f32::NAN,
            |surface| surface.distance_m = 2e6,
            |surface| surface.axes[0] = f32::NAN,
            |surface| surface.axes[1] = f32::NEG_INFINITY,
        ];
        cases.extend(bad.map(|change| (round, change)));
    }
    for (number, (good, change)) in cases.into_iter().enumerate() {
        let mut bad = good.clone();
        change(bad.surface.as_mut().expect("one"));
        let refused = bench.set_to(&bad, Scope::Run);
        assert_eq!(
            beyond(&refused),
            Some(Field::Surface),
            "{number}: {refused:?}"
        );
        assert_eq!(bench.done(Request::GetConfiguration), before);
    }
    let unsupported = Err(Refusal::Unsupported(Field::Surface));
    for axes in [0, 1, 3] {
        let mut bad = edge.clone();
        let surface = bad.surface.as_mut().expect("one");
        surface.axes = [1.0, 0.0, 0.0][..axes].iter().copied().collect();
        assert_eq!(bench.set_to(&bad, Scope::Run), unsupported, "{axes}");
    }
    let mut host_loop = edge.clone();
    host_loop.configuration.loop_mode = LoopMode::Host;
    assert_eq!(bench.set_to(&host_loop, Scope::Run), unsupported);
    assert_eq!(bench.set_to(&edge, Scope::Lasting), unsupported);
    assert_eq!(
        (bench.state(), bench.norms.last()),
        (State::Idle, Some(&0.0))
    );
    bench.set_to(&edge, Scope::Run).expect("good");
}

#[test]
fn it_belongs_to_a_configuration_and_is_part_of_its_digest() {
    let edge = run(&plane([1.0, 0.0], 0.0), None);
    let surface = edge.surface.clone().expect("one");
    let mut bench = Bench::on(SimulatedAxes::<2>::new("axes"));
    let staged = Request::Surface(surface.clone());
    assert_eq!(bench.refused(staged), Refusal::Incomplete);
    // Damaged on the way, or forgotten by the host.
    for other in [
        Some(SurfaceShape {
            kind: SurfaceKind::Ball,
            ..surface
        }),
        None,
    ] {
        for request in transaction(edge.configuration, &edge.values) {
            bench.done(request);
        }
        bench.done(Request::Surface(edge.surface.clone().expect("one")));
        let digest = DigestBuilder::new(&edge.configuration).coefficients(&edge.values);
        let digest = match &other {
            Some(other) => digest.surface(other),
            None => digest,
        };
        let commit = Request::Commit {
            digest: digest.finish(),
            scope: Scope::Run,
        };
        assert_eq!(bench.refused(commit), Refusal::Digest);
    }
    // Another configuration forgets it.
    let bare = Run {
        surface: None,
        ..edge.clone()
    };
    bench.set_to(&bare, Scope::Run).expect("good");
}

#[test]
fn a_device_of_one_axis_takes_none() {
    let mut bench = Bench::ideal();
    bench.loosen();
    let mut line = run(&plane([1.0], 0.0), None);
    let unsupported = Err(Refusal::Unsupported(Field::Surface));
    assert_eq!(bench.set_to(&line, Scope::Run), unsupported);
    line.surface = None;
    bench.set_to(&line, Scope::Run).expect("a wall");
}

/// A device of two axes from before surfaces: its keys end before them.
fn from_before() -> (SerialLink, Arc<AtomicBool>) {
    let (here, mut far_end) = Pipe::pair();
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    std::thread::spawn(move || {
        let device = TickSide::new(SimulatedAxes::<2>::new("old")).expect("starts");
        let device = RefCell::new(device);
        let mut session = DeviceSession::new([0, 1, 0], 1);
        let mut reports = Receiver::<DeviceReport>::new(Direction::FromDevice);
        let mut bytes = [0; FRAME_MAX];
        while !stopped.load(Ordering::Relaxed) {
            let count = far_end.read(&mut bytes).unwrap_or(0);
            for byte in &bytes[..count] {
                let mut line = [0; FRAME_MAX];
                let mut length = session.receive(*byte, 0, &device, &mut line);
                let frame = line;
                for byte in &frame[..length] {
                    if let Some((header, DeviceReport::Keys(mut keys))) = reports.push(*byte) {
                        keys.requests.truncate(18);
                        length =
                            encode(&DeviceReport::Keys(keys), header, &mut line).expect("fits");
                    }
                }
                // It ends with the link.
                let _ = far_end.write_all(&line[..length]);
            }
        }
    });
    let link = SerialLink::to_line(Box::new(here), "old", None).expect("connects");
    (link, stop)
}

#[test]
fn a_device_from_before_surfaces_is_told_of_before_anything_is_set() -> Tested {
    let (mut link, stop) = from_before();
    let before = link.configuration()?;
    let edge = run(&plane([1.0, 0.0], 0.0), None);
    let companions = Companions {
        surface: edge.surface.as_ref(),
        ..Companions::default()
    };
    let refused = link.set_run(edge.configuration, &edge.values, companions);
    assert_refused(refused, "cannot render a shape on its own & flash");
    assert_eq!(link.configuration()?, before);
    // A loop on the host needs no more than it has.
    let mut hosts = edge.configuration;
    hosts.loop_mode = LoopMode::Host;
    hosts.limits = before.0.limits;
    let set = link.set_run(hosts, &edge.values, Companions::default());
    set?;
    drop(link);
    stop.store(true, Ordering::Relaxed);
    Ok(())
}

#[test]
fn without_a_surface_the_law_acts_along_the_first_axis() {
    let led = || Led::<2> { path, tick: 0 };
    let mut bare = run(&plane([1.0, 0.0], 0.0), None);
    let along_x = {
        let mut bench = Bench::on(led());
        bench.runs(&bare, 500);
        bench.run_ms(700);
        bench.samples().cloned().collect::<Vec<_>>()
    };
    bare.surface = None;
    let mut bench = Bench::on(led());
    bench.runs(&bare, 500);
    bench.run_ms(700);
    let samples: Vec<Sample> = bench.samples().cloned().collect();
    assert_eq!(samples, along_x);
    assert!(samples.iter().any(|sample| sample.axes[0].force_n < -0.5));
    assert!(samples.iter().all(|sample| sample.axes[1].force_n == 0.0));
}
