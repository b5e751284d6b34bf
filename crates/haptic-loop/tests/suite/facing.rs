//! Two devices that face each other, against closed forms, their energy, and each alone.

use crate::plant_parameters::{Change, refuses};
use fracdiff::Seconds;
use haptic_loop::plant::{
    FacingConfig, FacingContact, FacingDevices, FacingSide, MassDamper, MassDamperConfig,
};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use nalgebra::SVector;
use testkit::assert_close;
use testkit::device::{ideal, read, write};

const NANOSECOND: Seconds = Seconds(1e-9);
const MILLISECOND: u64 = 1_000_000;
const SIDES: [FacingSide; 2] = [FacingSide::Renderer, FacingSide::Indenter];

fn device(mass_kg: f64, damping: f64) -> MassDamperConfig {
    ideal(mass_kg, damping, 1e-3)
}

/// 50 g and 80 g, and this contact.
fn config(stiffness: f64, damping: f64, gap_m: f64) -> FacingConfig {
    FacingConfig {
        devices: [device(0.05, 0.0), device(0.08, 0.0)],
        contact: FacingContact {
            stiffness: NewtonsPerMetre(stiffness),
            damping: NewtonSecondsPerMetre(damping),
            gap: Metres(gap_m),
            friction: Newtons(0.0),
        },
    }
}

fn made(config: FacingConfig) -> FacingDevices {
    FacingDevices::new(config, NANOSECOND).expect("valid")
}

/// Velocities over the next microsecond, m/s.
fn speeds(world: &FacingDevices) -> [f64; 2] {
    let mut ahead = world.clone();
    ahead.advance_to(world.now() + 1000);
    SIDES.map(|side| (ahead.position(side) - world.position(side)) / 1e-6)
}

/// The indenter thrown at the resting renderer, with no force from 1 ms on: its velocity then, m/s.
fn thrown(world: &mut FacingDevices, force: f64) -> f64 {
    world.command(FacingSide::Indenter, force);
    world.advance_to(MILLISECOND);
    world.command(FacingSide::Indenter, 0.0);
    force * 1e-3 / 0.08
}

/// m₁v₁ + m₂v₂ stays, and (v₁ − v₂) is −e times what it was: e = 1 without a damper; else by half a damped turn, to where F = 0.
#[test]
fn a_collision_gives_the_velocities_of_its_closed_form() {
    let (m1, m2): (f64, f64) = (0.05, 0.08);
    let reduced = m1 * m2 / (m1 + m2);
    for stiffness in [1e3, 1e5, 2e6] {
        for ratio in [0.0, 0.05, 0.3, 0.8] {
            let omega = (stiffness / reduced).sqrt();
            let mut world = made(config(stiffness, 2.0 * ratio * omega * reduced, 2e-3));
            let before = thrown(&mut world, 16.0);
            // 0.2 m/s: there after 10 ms, with it for some 0.1 s at most.
            world.advance_to(200 * MILLISECOND);
            // F = 0 at tan(ω_d·t) = … : p = e^(−ζωt)·sin(ω_d t)/ω_d, e = exp(−ζ/√(1−ζ²)·(π − atan(2ζ√(1−ζ²)/(2ζ²−1)) …))
            let damped = (1.0 - ratio * ratio).sqrt();
            let turn = (2.0 * ratio * damped).atan2(2.0 * ratio * ratio - 1.0);
            let restitution = (-ratio / damped * turn).exp();
            let common = m2 * before / (m1 + m2);
            let want = [
                common + restitution * m2 * before / (m1 + m2),
                common - restitution * m1 * before / (m1 + m2),
            ];
            for (have, want) in speeds(&world).into_iter().zip(want) {
                // Noticed a nanosecond late: ω·1e-9 of it.
                assert_close(
                    &format!("k {stiffness} ζ {ratio}"),
                    have,
                    want,
                    (1e-9 + 2e-9 * omega) * before,
                );
            }
        }
    }
}

/// A renderer on a spring is hit again and again: energy never grows, and without dampers none is lost.
#[test]
fn a_contact_creates_no_energy_and_without_a_damper_loses_none() {
    for (damping, friction) in [(0.0, 0.0), (5.0, 0.0), (80.0, 0.0), (0.0, 0.2), (20.0, 0.5)] {
        let mut config = config(1e5, damping, 1e-3);
        config.contact.friction = Newtons(friction);
        config.devices[0].stiffness = NewtonsPerMetre(400.0);
        config.devices[1].stiffness = NewtonsPerMetre(150.0);
        let mut world = made(config);
        thrown(&mut world, 40.0);
        let energy = |world: &FacingDevices| {
            let [v1, v2] = speeds(world);
            let [x1, x2] = SIDES.map(|side| world.position(side));
            let pressed = (x2 - x1 - 1e-3).max(0.0);
            0.5 * (0.05 * v1 * v1 + 0.08 * v2 * v2)
                + 0.5 * (400.0 * x1 * x1 + 150.0 * x2 * x2 + 1e5 * pressed * pressed)
        };
        let first = energy(&world);
        let (mut last, mut hits, mut pressed) = (first, 0, false);
        for n in 1..20_000_u64 {
            world.advance_to(MILLISECOND + n * 100_000);
            let now = energy(&world);
            // The velocity is that of a difference over a microsecond.
            let (touches, slack) = (world.contact_force() > 0.0, 1e-3 * first);
            assert!(
                now <= last + slack,
                "{damping} {friction} {n}: {now} {last}"
            );
            hits += u32::from(touches && !pressed);
            (last, pressed) = (now, touches);
        }
        assert!(hits > 10, "{damping}: {hits}");
        if damping + friction > 0.0 {
            assert!(last < 0.9 * first, "{damping} {friction}: {last} {first}");
        } else {
            assert_close("energy", last, first, 2e-3 * first);
        }
    }
}

/// Apart, each is the mass-damper that it is alone, with delay, lag, saturation and hand.
#[test]
fn apart_each_device_moves_as_it_does_alone() {
    let mut config = config(1e5, 80.0, 1.0);
    config.devices = [
        MassDamperConfig {
            delay: Seconds(1.37e-3),
            current_lag: Seconds(0.4e-3),
            ..device(0.065, 3.5)
        },
        MassDamperConfig {
            delay: Seconds(0.25e-3),
            stiffness: NewtonsPerMetre(200.0),
            saturation: Some(Newtons(0.6)),
            ..device(0.2, 1.0)
        },
    ];
    let mut world = made(config);
    let mut alone = config
        .devices
        .map(|one| MassDamper::<1>::new(one).expect("valid"));
    for n in 0..2000 {
        for ((side, alone), sign) in SIDES.into_iter().zip(&mut alone).zip([-1.0, 1.0]) {
            let want = read(alone).position_m[0];
            assert_close("x", world.position(side), want, 1e-12 + 1e-10 * want.abs());
            let force = sign * (f64::from(n) * 0.37).sin();
            write(alone, force);
            world.command(side, force);
        }
        world.advance_to((n as u64 + 1) * MILLISECOND);
    }
}

/// One slides to rest on its friction, v²/(2·Fc/m): right to one piece, whose error halves with it.
#[test]
fn friction_stops_a_device_where_its_closed_form_says_and_the_better_the_shorter_its_pieces() {
    let mut config = config(1e5, 80.0, 1.0);
    config.devices[1].friction = Newtons(0.3);
    let slid = |unit: f64| {
        let mut world = FacingDevices::new(config, Seconds(unit)).expect("valid");
        world.command(FacingSide::Indenter, 2.3);
        let units = |time_s: f64| (time_s / unit).round() as u64;
        world.advance_to(units(0.01));
        world.command(FacingSide::Indenter, 0.0);
        world.advance_to(units(0.2));
        let rest = world.position(FacingSide::Indenter);
        world.advance_to(units(0.3));
        assert_close("at rest", world.position(FacingSide::Indenter), rest, 1e-15);
        rest
    };
    // 2 N on 80 g for 10 ms, then −0.3 N.
    let (v, friction) = (2.0 * 0.01 / 0.08, 0.3 / 0.08);
    let want = 0.5 * v * 0.01 + v * v / (2.0 * friction);
    let error = |unit| (slid(unit) - want).abs();
    // A piece is 2^17 units: 131 µs, 13 µs; stopping is right to the velocity lost in one.
    assert!(
        error(1e-9) < 131e-6 * 131e-6 * friction,
        "{:e}",
        error(1e-9)
    );
    assert!(
        error(1e-10) < 14e-6 * 14e-6 * friction,
        "{:e}",
        error(1e-10)
    );
}

/// Under the friction of both nothing moves by a bit; beyond it the contact hands the rest on.
#[test]
fn a_push_below_the_friction_of_both_moves_nothing() {
    let mut config = config(1e5, 80.0, 0.0);
    config.devices[0].friction = Newtons(0.2);
    config.devices[1].friction = Newtons(0.5);
    let mut world = made(config);
    world.command(FacingSide::Indenter, 0.49);
    world.advance_to(300 * MILLISECOND);
    assert!(SIDES.iter().all(|side| world.position(*side).abs() < 1e-15));
    world.command(FacingSide::Indenter, 0.65);
    world.advance_to(600 * MILLISECOND);
    // Friction is held over a piece, in which the contact's force changes: some nanometres at the blow, and none afterwards.
    let moved = world.position(FacingSide::Renderer);
    assert!(moved.abs() < 5e-9, "{moved}");
    world.advance_to(1000 * MILLISECOND);
    assert_close("x₁", world.position(FacingSide::Renderer), moved, 1e-13);
    // 0.15 N compress the contact by 1.5 µm; friction holds it where it swung to.
    let pressed = world.position(FacingSide::Indenter) * 1e5;
    assert!((0.15..0.2).contains(&pressed), "{pressed}");
    world.command(FacingSide::Indenter, 0.9);
    world.advance_to(1100 * MILLISECOND);
    assert!(world.position(FacingSide::Renderer) > 1e-3);
}

/// The times at which somebody looks change nothing but rounding, whatever they are.
#[test]
fn a_world_that_is_looked_at_moves_as_one_that_is_not() {
    let mut config = config(1e5, 10.0, 1e-4);
    config.devices[0].stiffness = NewtonsPerMetre(3000.0);
    let end = 60 * MILLISECOND;
    let run = |stops: &[u64]| {
        let mut world = made(config);
        world.command(FacingSide::Indenter, 3.0);
        for step in stops.iter().cycle() {
            world.advance_to((world.now() + step).min(end));
            if world.now() == end {
                break;
            }
        }
        SVector::from(SIDES.map(|side| world.position(side)))
    };
    let whole = run(&[end]);
    for stops in [
        &[700_001, 999_983, 13][..],
        &[1_000_000, 300_000],
        &[77_777],
    ] {
        assert!((run(stops) - whole).amax() < 1e-9, "{stops:?}");
    }
}

#[test]
fn a_device_that_lets_go_makes_no_force_not_even_one_on_its_way() {
    let mut config = config(1e5, 80.0, 0.0);
    config.devices[0].delay = Seconds(5e-3);
    config.devices[0].current_lag = Seconds(1e-3);
    let mut world = made(config);
    world.command(FacingSide::Renderer, 1.0);
    world.advance_to(4 * MILLISECOND);
    world.let_go(FacingSide::Renderer);
    world.advance_to(50 * MILLISECOND);
    assert_eq!(world.position(FacingSide::Renderer).to_bits(), 0);
    world.command(FacingSide::Renderer, 1.0);
    world.advance_to(60 * MILLISECOND);
    assert!(world.position(FacingSide::Renderer) > 1e-6);
    world.restart();
    assert_eq!(SIDES.map(|side| world.position(side).to_bits()), [0; 2]);
    assert_eq!(world.contact_force().to_bits(), 0);
}

#[test]
fn what_no_contact_or_device_can_be_is_refused_with_its_range() {
    let refused: [(Change<FacingConfig>, &str); 8] = [
        (
            |c| c.contact.gap = Metres(-1e-3),
            "gap -0.001 m is not at least 0 m",
        ),
        (
            |c| c.contact.gap = Metres(f64::NAN),
            "gap NaN m is not at least 0 m",
        ),
        (
            |c| c.contact.stiffness = NewtonsPerMetre(0.0),
            "contact stiffness 0 N/m is not above 0 N/m",
        ),
        (
            |c| c.contact.damping = NewtonSecondsPerMetre(f64::INFINITY),
            "contact damping inf N·s/m is not finite and at least 0 N·s/m",
        ),
        (
            |c| c.contact.friction = Newtons(-0.1),
            "contact friction -0.1 N is not at least 0 N",
        ),
        (
            |c| c.contact.stiffness = NewtonsPerMetre(1e13),
            "fastest motion of the contact 1.80278e7 rad/s is not at most 1e6 rad/s",
        ),
        (
            |c| c.devices[1].mass = Kilograms(0.0),
            "mass 0 kg is not above 0 kg",
        ),
        (
            |c| c.devices[0].delay = Seconds(f64::NAN),
            "delay NaN s is not at least 0 s",
        ),
    ];
    let good = config(1e5, 80.0, 0.0);
    refuses(good, &refused, |it| FacingDevices::new(it, NANOSECOND));
    FacingDevices::new(good, Seconds(0.0)).expect_err("no time");
}
