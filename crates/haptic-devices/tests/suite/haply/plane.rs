//! Both axes: a shape in the plane against the exact sum over the depth along its normal, and the plane itself.

use super::wire::{Running, TICK_US, stroked};
use fracdiff::{Operator, Order, Scheme, Seconds, batch::Batch, full_memory::Kernel};
use haptic_devices::haply::{HaplyPlane, Unreachable, Version};
use haptic_link::State;
use haptic_loop::{
    Ball, Contact, Controller, Device, Reading, SafeForce, SafetyChain, Shape, SpringDamper,
    Surface as _,
    units::{Metres, Newtons, NewtonsPerSecond},
};
use haptic_remote::Tick;
use nalgebra::{SVector, Vector2};
use testkit::assert_relative;

/// α of cancerous prostate, and a stiffness and a dissipation that these motors can bear, N/m and N·s^α/m.
const ORDER: f64 = 0.2247;
const STIFFNESS: f64 = 20.0;
const DISSIPATION: f64 = 15.0;

/// The host's end of a device, one tick long.
struct Link {
    reading: Reading<f64, 2>,
    force_n: SVector<f64, 2>,
}

impl Device<f64, 2> for Link {
    type Error = core::convert::Infallible;

    fn read(&mut self) -> Result<Reading<f64, 2>, Self::Error> {
        Ok(self.reading)
    }

    fn write(&mut self, force: SafeForce<f64, 2>) -> Result<(), Self::Error> {
        self.force_n = *force.newtons();
        Ok(())
    }
}

/// A disc, felt from outside: its centre is beside the way of the hand, which strokes along y.
fn disc() -> Shape<f64, 2> {
    let centre = [Metres(-0.012), Metres(0.016)];
    Shape::Ball(Ball::solid(centre, Metres(0.02)).expect("a disc"))
}

/// Renders that disc on a host, for so many ticks and as many again.
fn host(order: Order, t: Seconds, ticks: u32) -> impl FnMut(&Tick<2>) -> [f32; 2] {
    let scheme: Scheme = "full:1e-6".parse().expect("a scheme");
    let operator: Operator<f64> = scheme
        .build(order, t, 2.0 * f64::from(ticks))
        .expect("an operator");
    let law = SpringDamper::new(STIFFNESS, DISSIPATION, operator).expect("a law");
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e6), t).expect("a chain");
    let controller = Controller::new(Contact::behind(disc(), law), chain);
    let mut engaged = controller.into_engaged(Link {
        reading: Reading {
            tick: 0,
            time_s: 0.0,
            position_m: Vector2::zeros(),
        },
        force_n: Vector2::zeros(),
    });
    move |tick| {
        let reading = &mut engaged.device_mut().reading;
        reading.tick = u64::from(tick.tick);
        reading.position_m = Vector2::from(tick.position_m).map(f64::from);
        let Ok(_) = engaged.tick();
        engaged.device().force_n.map(|axis| axis as f32).into()
    }
}

#[test]
fn the_force_is_the_sum_over_the_depth_along_the_normal() {
    for (version, tick_us) in [
        (Version::V2, 2 * TICK_US),
        (Version::V3, 2 * TICK_US),
        (Version::V2, TICK_US),
        (Version::V3, TICK_US),
    ] {
        let board = stroked(version, 1_200_000);
        let t = Seconds(1e-6 * f64::from(tick_us));
        let order = Order::new(ORDER).expect("an order");
        let ticks = 3000_u32;
        let (shape, host) = (disc(), host(order, t, ticks));
        let mut running = Running::both(board, version, 1_200_000, tick_us, Box::new(host));
        // The first tick has nothing to answer.
        running.tick();
        let mut places = Vec::new();
        let mut forces = Vec::new();
        for _ in 0..ticks {
            let answered = *running.device.newest();
            running.tick();
            let sample = *running.device.newest();
            assert_eq!(running.device.status().state, State::Running);
            assert_eq!(sample.limiters, 0, "{sample:?}");
            places.push(Vector2::from(answered.position_m).map(f64::from));
            let force = Vector2::from(sample.force_n).map(f64::from);
            forces.push(force);
            // The motors make it, along both axes; the Jacobian is that of a tick ago.
            let off = (running.force() - force).norm();
            assert!(off < 0.01 * force.norm() + 1e-6, "{off} of {force}");
        }
        let depths: Vec<f64> = places.iter().map(|at| shape.depth(at).max(0.0)).collect();
        let rates = Batch::full_history(Kernel::Grunwald, order, t)
            .expect("a sum")
            .run(&depths);
        let (mut largest, mut error) = (0.0_f64, 0.0_f64);
        let (mut touched, mut left) = (0, 0);
        for (((at, depth), rate), have) in places.iter().zip(&depths).zip(rates).zip(&forces) {
            let reaction = match depth {
                0.0 => 0.0,
                depth => (STIFFNESS * depth + DISSIPATION * rate).max(0.0),
            };
            let centre = Vector2::new(-0.012, 0.016);
            let outwards = (at - centre).normalize();
            largest = largest.max(reaction);
            error = error.max((have - outwards * reaction).norm());
            touched += u32::from(*depth > 0.0);
            left += u32::from(*depth <= 0.0);
        }
        println!(
            "{version:?} at {tick_us} µs: {:e} of {largest} N",
            error / largest
        );
        assert!(touched > 500 && left > 500, "in {touched}, out {left}");
        assert!(largest > 0.1, "{largest} N");
        assert!(error < 1e-3 * largest, "{error} of {largest} N");
    }
}

#[test]
fn the_middle_of_the_plane_is_reached_and_what_is_far_is_not() {
    for version in Version::ALL {
        let plane = HaplyPlane::of(version.model());
        let (low, high) = HaplyPlane::HANDY_M;
        let [least, most] = plane.masses(low, high).expect("within reach");
        println!("{version:?}: {least} to {most} kg");
        // 1 kg in the mean of the directions in the middle lies between.
        assert!(0.0 < least && least <= 1.0 && 1.0 <= most);
        // A larger box has lighter and heavier postures.
        let [inner_least, inner_most] = plane
            .masses(low.map(|x| 0.5 * x), high.map(|x| 0.5 * x))
            .expect("within reach");
        assert!(least <= inner_least && inner_most <= most);
        for (low, high) in [
            // Stretched arms, beside the base, behind it.
            ([-0.02, 0.05], [0.02, 0.09]),
            ([-0.2, -0.05], [0.0, 0.05]),
            ([-0.02, -0.13], [0.02, 0.0]),
        ] {
            let refused = plane.masses(low, high);
            assert!(refused.is_err(), "{low:?} {high:?}: {refused:?}");
        }
        for high in [[-0.01, 0.01], [f64::NAN, 0.01], [0.9, 0.01]] {
            let refused = plane.masses([0.0, 0.0], high);
            assert!(
                matches!(refused, Err(Unreachable::Side { .. })),
                "{refused:?}"
            );
        }
    }
}

/// The mass along a direction is that of the kinetic energy: of two equal inertias that turn as the arms do.
#[test]
fn masses_are_those_of_the_kinetic_energy_by_difference_quotients() {
    for version in Version::ALL {
        let model = version.model();
        let plane = HaplyPlane::of(model);
        let step = 1e-6;
        // ½·I·|Δθ|²/Δt² is ½·m·|Δx|²/Δt²: m/I = |Δθ|²/|Δx|².
        let mass = |place: Vector2<f64>, angle: f64| {
            let direction = Vector2::new(angle.cos(), angle.sin());
            let at = |side: f64| {
                let hand = plane.centre() + place + direction * (side * step);
                Vector2::from(model.pantograph.angles(hand).expect("in reach"))
            };
            ((at(1.0) - at(-1.0)) / (2.0 * step)).norm_squared()
        };
        let extremes = |place| {
            let masses =
                (0..3600).map(|n| mass(place, f64::from(n) * core::f64::consts::PI / 3600.0));
            masses.fold((f64::INFINITY, 0.0_f64), |(least, most), mass| {
                (least.min(mass), most.max(mass))
            })
        };
        let (least, most) = extremes(Vector2::zeros());
        let mean = (least * most).sqrt();
        let half = 1e-4;
        let [have_least, have_most] = plane
            .masses([-half; 2], [half; 2])
            .expect("a small box in the middle");
        // The box is 0.2 mm wide, the masses change by a per cent in a mm.
        assert_relative("have_least", have_least, least / mean, 0.01);
        assert_relative("have_most", have_most, most / mean, 0.01);
    }
}
