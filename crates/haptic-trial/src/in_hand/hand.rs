//! The hand: a spring and a damper between the pointer and a simulated device.
//! ```text
//! pointer ─limited, smoothed twice─▶ x_h, v_h        m·x'' + (b + b_h)·x' + k_h·x = f + k_h·x_h + b_h·v_h
//! ```
//! Spring and damper are part of the plant, so they are exact between samples and stable whatever their values. Without a hand
//! the device is a mass on its own damper.

use crate::Sensors;
use haptic_document::Failure;
use haptic_loop::{
    Device, Reading, SafeForce,
    plant::{MassDamper, MassDamperConfig, Sensed},
    units::{NewtonSecondsPerMetre, NewtonsPerMetre},
};
use nalgebra::Vector1;
use std::convert::Infallible;

/// `k_h`, N/m: a finger's.
pub const HAND_STIFFNESS: NewtonsPerMetre = NewtonsPerMetre(300.0);
/// `b_h`, N·s/m: with 65 g the hand is damped at ζ = 1.
pub const HAND_DAMPING: NewtonSecondsPerMetre = NewtonSecondsPerMetre(5.5);
/// Ends of the places that the hand goes to, m.
pub const HAND_M: (f64, f64) = (-0.03, 0.03);
/// Fastest motion of the hand, m/s: below the soft limit of the safety chain, so that a fast pointer is no fault.
const HAND_SPEED_M_PER_S: f64 = 0.5;
/// Time constant of each of the two smoothings, s: a pointer reports its position 60 times a second.
const SMOOTHING_S: f64 = 0.006;
/// Place of the device before it is touched, m: in front of the surface.
pub(crate) const START_M: f64 = -5e-3;

#[derive(Clone, Copy, Debug)]
struct Pointer {
    target_m: f64,
    smoothed_m: f64,
    position_m: f64,
    velocity_m_per_s: f64,
    /// 1 − e^(−T/τ).
    gain: f64,
    sample_time_s: f64,
}

impl Pointer {
    fn at(position_m: f64, sample_time_s: f64) -> Self {
        Self {
            target_m: position_m,
            smoothed_m: position_m,
            position_m,
            velocity_m_per_s: 0.0,
            gain: -libm::expm1(-sample_time_s / SMOOTHING_S),
            sample_time_s,
        }
    }

    fn aim(&mut self, target_m: f64) {
        // A pointer that is not a number stays where it is.
        if target_m.is_finite() {
            self.target_m = target_m.clamp(HAND_M.0, HAND_M.1);
        }
    }

    fn step(&mut self) {
        let furthest = HAND_SPEED_M_PER_S * self.sample_time_s;
        self.smoothed_m += self.gain * (self.target_m - self.smoothed_m);
        let moved = self.gain * (self.smoothed_m - self.position_m);
        let moved = moved.clamp(-furthest, furthest);
        self.position_m += moved;
        self.velocity_m_per_s = moved / self.sample_time_s;
    }
}

#[derive(Clone, Copy, Debug)]
struct Place(Reading<f64, 1>);

impl Device<f64, 1> for Place {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        Ok(self.0)
    }

    fn write(&mut self, _: SafeForce<f64, 1>) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A simulated device with a hand that holds it or not. Both plants are given each force, so that what is on its way arrives whatever
/// the hand does meanwhile; the one that is not felt follows the other.
#[derive(Clone, Debug)]
pub struct HeldDevice {
    free: MassDamper<1>,
    held: MassDamper<1>,
    sensors: Sensed<Place>,
    is_held: bool,
    pointer: Pointer,
    hand_force_n: f64,
    tick: u64,
}

impl HeldDevice {
    /// A device in front of the surface, no hand on it.
    ///
    /// # Errors
    /// A number that no device or sensor has.
    pub fn new(free: MassDamperConfig, sensors: Sensors) -> Result<Self, Failure> {
        let sample_time_s = free.sample_time.0;
        let place = Place(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: Vector1::new(START_M),
        });
        let held = MassDamperConfig {
            damping: NewtonSecondsPerMetre(free.damping.0 + HAND_DAMPING.0),
            stiffness: HAND_STIFFNESS,
            ..free
        };
        let mut device = Self {
            free: MassDamper::new(free).map_err(Failure::input)?,
            held: MassDamper::new(held).map_err(Failure::input)?,
            sensors: sensors.before(place)?,
            is_held: false,
            pointer: Pointer::at(START_M, sample_time_s),
            hand_force_n: 0.0,
            tick: 0,
        };
        device.put_back();
        Ok(device)
    }

    const fn plant(&self) -> &MassDamper<1> {
        if self.is_held { &self.held } else { &self.free }
    }

    fn position_m(&self) -> f64 {
        self.plant().position()[0]
    }

    /// Position of the hand, m; NaN without one.
    pub const fn hand_m(&self) -> f64 {
        if self.is_held {
            self.pointer.position_m
        } else {
            f64::NAN
        }
    }

    /// Force of the hand on the device in the tick before, N; 0 without one.
    pub const fn hand_force_n(&self) -> f64 {
        self.hand_force_n
    }

    /// The pointer is there, m; the hand takes hold of the device where that is, or lets go of it.
    pub fn hand(&mut self, position_m: f64, held: bool) {
        if held != self.is_held {
            self.follow();
            self.is_held = held;
            if held {
                self.pointer = Pointer::at(self.position_m(), self.pointer.sample_time_s);
            }
        }
        self.pointer.aim(position_m);
    }

    /// The plant that is not felt is where the other one is.
    fn follow(&mut self) {
        let (position, velocity) = (self.plant().position(), self.plant().velocity());
        let other = if self.is_held {
            &mut self.free
        } else {
            &mut self.held
        };
        other.set_state(position, velocity);
    }

    /// Nobody holds it any more.
    pub fn hand_lets_go(&mut self) {
        self.hand(f64::NAN, false);
    }

    /// The device is in front of the surface again, at rest, without a hand.
    pub fn put_back(&mut self) {
        self.hand_lets_go();
        (self.free).set_state(Vector1::new(START_M), Vector1::new(0.0));
    }

    fn pull(&mut self) {
        self.pointer.step();
        let (stiffness, damping) = (HAND_STIFFNESS.0, HAND_DAMPING.0);
        let pull = stiffness * self.pointer.position_m + damping * self.pointer.velocity_m_per_s;
        let (position, velocity) = (self.position_m(), self.held.velocity()[0]);
        self.hand_force_n = pull - stiffness * position - damping * velocity;
        self.held.set_external_force(Vector1::new(pull));
    }
}

impl Device<f64, 1> for HeldDevice {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        self.sensors.device_mut().0 = Reading {
            tick: self.tick,
            time_s: self.tick as f64 * self.pointer.sample_time_s,
            position_m: self.plant().position(),
        };
        self.sensors.read()
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        self.tick += 1;
        self.hand_force_n = 0.0;
        if self.is_held {
            self.pull();
        }
        self.free.write(force)?;
        self.held.write(force)?;
        self.follow();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{DeviceValues, in_hand::hand::*};
    use haptic_document::parameters::{DAMPING, MASS};
    use haptic_loop::{
        SafetyChain, SafetyState,
        units::{Kilograms, Newtons, NewtonsPerSecond, Seconds},
    };

    fn ideal() -> MassDamperConfig {
        MassDamperConfig::ideal(
            Kilograms(MASS.default_number()),
            NewtonSecondsPerMetre(DAMPING.default_number()),
            Seconds(1e-3),
        )
    }

    fn device() -> HeldDevice {
        HeldDevice::new(ideal(), Sensors::NONE).expect("valid")
    }

    #[test]
    fn the_device_of_a_file_has_its_delay_friction_and_encoder() {
        let late = DeviceValues {
            mass_kg: MASS.default_number(),
            damping_n_s_per_m: DAMPING.default_number(),
            friction_n: 0.1,
            delay_s: 3e-3,
            current_lag_s: 1e-3,
            encoder_resolution_m: 1e-4,
            ..DeviceValues::default()
        };
        let config = late.free(Seconds(1e-3));
        let t = config.sample_time;
        let chain = SafetyChain::<f64>::new(Newtons(5.0), NewtonsPerSecond(1e4), t);
        let chain = chain.expect("limits");
        let mut safety = SafetyState::default();
        let mut device = HeldDevice::new(config, late.sensors());
        let device = device.as_mut().expect("valid");
        let mut alone = MassDamper::<1>::new(config).expect("valid");
        alone.set_state(Vector1::new(START_M), Vector1::new(0.0));
        for tick in 0..400 {
            // Forces on their way arrive, whoever takes hold and lets go; a hand at the place of the device pulls at nothing.
            if tick == 2 {
                device.hand(START_M, true);
                device.hand_lets_go();
            }
            let wanted = Vector1::new(if tick < 5 { 2.0 } else { 0.0 });
            let (force, _) = chain.apply(&mut safety, &Vector1::new(0.0), &wanted);
            let Ok(reading) = device.read();
            let place = alone.position()[0];
            let counts = (place / 1e-4).round();
            let read = reading.position_m[0];
            assert!((read - counts * 1e-4).abs() < 1e-15, "tick {tick}: {read}");
            // Delay and lag: nothing moves for three samples.
            assert_eq!(place > START_M, tick > 3, "tick {tick}: {place}");
            let (Ok(()), Ok(())) = (device.write(force), alone.write(force));
        }
        // Friction has stopped it.
        assert!(device.free.velocity()[0].abs() < 1e-15);
        assert!(device.position_m() > START_M + 1e-3);
    }

    fn run(device: &mut HeldDevice, ticks: u32) -> Vec<f64> {
        let tick = |_| {
            let Ok(()) = device.write(SafeForce::zero());
            device.position_m()
        };
        (0..ticks).map(tick).collect()
    }

    #[test]
    fn a_held_device_follows_the_pointer_and_is_there_within_100_ms() {
        let mut device = device();
        device.hand(2e-3, true);
        let positions = run(&mut device, 300);
        assert!((positions[100] - 2e-3).abs() < 2e-4, "{}", positions[100]);
        assert!((positions[299] - 2e-3).abs() < 1e-6, "{}", positions[299]);
        assert!(device.hand_force_n().abs() < 1e-3);
    }

    #[test]
    fn taking_hold_and_letting_go_moves_nothing() {
        let mut device = device();
        device.hand(10e-3, true);
        run(&mut device, 30);
        let at = (device.position_m(), device.held.velocity()[0]);
        device.hand_lets_go();
        assert_eq!((device.position_m(), device.free.velocity()[0]), at);
        assert!(device.hand_m().is_nan());
        device.hand(0.0, true);
        assert_eq!((device.position_m(), device.held.velocity()[0]), at);
        assert_eq!(device.hand_m().to_bits(), at.0.to_bits());
    }

    #[test]
    fn no_pointer_moves_the_device_faster_than_the_hand_does() {
        let mut device = device();
        let mut fastest = 0.0_f64;
        for n in 0..2000_u32 {
            // From end to end within a tick, and nonsense in between.
            let wild = [1e9, -1e9, f64::NAN, f64::INFINITY][(n / 100 % 4) as usize];
            device.hand(wild, true);
            let Ok(()) = device.write(SafeForce::zero());
            fastest = fastest.max(device.held.velocity()[0].abs());
            assert!(device.position_m().abs() < 1.2 * HAND_M.1);
        }
        assert!(fastest < 1.05 * HAND_SPEED_M_PER_S, "{fastest}");
    }
}
