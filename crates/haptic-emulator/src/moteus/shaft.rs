//! The shaft of the emulated servo: inertia and damping, or a hand that turns it.

use core::f64::consts::TAU;
use fracdiff::parameter::range;
use haptic_loop::{
    LoopParameterError,
    plant::RampHold,
    units::{Metres, Seconds},
};

/// The shaft of an emulated servo and what holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// J, kg·m², in [1e-9, 1e3].
    pub inertia_kg_m2: f64,
    /// b, N·m·s/rad, in [0, 1e3].
    pub damping_n_m_s_per_rad: f64,
    /// Proportional gain of the servo's own control, N·m per revolution.
    pub kp: f64,
    /// Damping gain of the servo's own control, N·m·s per revolution.
    pub kd: f64,
    /// A hand that turns it as it will from the first torque command on; `None` for a free shaft.
    pub hand: Option<Hand>,
}

impl Shaft {
    /// A lever of 0.1 kg at 20 mm, turned against 0.5 N·s/m there; the servo's own control is off,
    /// as it should be for haptics.
    pub const LEVER: Self = Self {
        inertia_kg_m2: 4e-5,
        damping_n_m_s_per_rad: 2e-4,
        kp: 0.0,
        kd: 0.0,
        hand: None,
    };
}

/// A hand that turns the shaft by an angle in a time and holds it there, whatever the torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Torque commands before the turn begins: a force rises by commands too, however late they come.
    pub wait_commands: u32,
    /// Angle from where the turn begins, in revolutions; below 0 it turns back.
    pub turn_rev: f64,
    /// Time of the turn, s, at constant speed.
    pub ramp_time_s: f64,
}

/// A shaft that turns.
///
/// ```text
/// J·ω′ = τ − b·ω        exactly from one step to the next, as τ is constant there
/// ```
#[derive(Clone, Debug)]
pub(super) struct Turning {
    shaft: Shaft,
    profile: Option<RampHold>,
    pub angle_rad: f64,
    pub speed_rad_per_s: f64,
}

impl Turning {
    /// Shaft at rest at 0.
    pub(super) fn new(shaft: Shaft) -> Result<Self, LoopParameterError> {
        let (inertia, damping) = (shaft.inertia_kg_m2, shaft.damping_n_m_s_per_rad);
        let (what, fits) = ("inertia of the shaft", (1e-9..=1e3).contains(&inertia));
        range(what, inertia, fits, "in [1e-9, 1e3] {}", "kg·m²")?;
        let (what, fits) = ("damping of the shaft", (0.0..=1e3).contains(&damping));
        range(what, damping, fits, "in [0, 1e3] {}", "N·m·s/rad")?;
        let profile = |hand: Hand| RampHold::new(Metres(hand.turn_rev), Seconds(hand.ramp_time_s));
        Ok(Self {
            shaft,
            profile: shaft.hand.map(profile).transpose()?,
            angle_rad: 0.0,
            speed_rad_per_s: 0.0,
        })
    }

    /// Torque commands before the hand begins.
    pub(super) fn wait_commands(&self) -> u32 {
        self.shaft.hand.map_or(0, |hand| hand.wait_commands)
    }

    pub(super) const fn gains(&self) -> (f64, f64) {
        (self.shaft.kp, self.shaft.kd)
    }

    pub(super) const fn place(&mut self, angle_rad: f64) {
        (self.angle_rad, self.speed_rad_per_s) = (angle_rad, 0.0);
    }

    /// Lets time pass at a torque; `turned_s` is the time since the hand began, if it has begun.
    pub(super) fn step(&mut self, torque_nm: f64, passed_s: f64, turned_s: Option<f64>) {
        if let (Some(profile), Some(turned_s)) = (&self.profile, turned_s) {
            let ramp_s = profile.ramp_time().0;
            self.angle_rad = TAU * profile.position(turned_s);
            self.speed_rad_per_s = if (0.0..ramp_s).contains(&turned_s) {
                TAU * profile.depth().0 / ramp_s
            } else {
                0.0
            };
            return;
        }
        let (inertia, damping) = (self.shaft.inertia_kg_m2, self.shaft.damping_n_m_s_per_rad);
        let share = damping * passed_s / inertia;
        // ω = ω₀·e^(−s) + τ/J·t·φ₁(s),   θ = θ₀ + ω₀·t·φ₁(s) + τ/J·t²·φ₂(s),   s = b·t/J
        let (first, second) = (phi_1(share), phi_2(share));
        let push = torque_nm / inertia * passed_s;
        self.angle_rad += passed_s * (self.speed_rad_per_s * first + push * second);
        self.speed_rad_per_s = self.speed_rad_per_s * libm::exp(-share) + push * first;
    }
}

/// φ₁(s) = (1 − e^(−s))/s
fn phi_1(share: f64) -> f64 {
    if share > 0.0 {
        -libm::expm1(-share) / share
    } else {
        1.0
    }
}

/// φ₂(s) = (1 − φ₁(s))/s; for small s by its series 1/2 − s/6 + s²/24 − …, where the difference has no digits.
fn phi_2(share: f64) -> f64 {
    if share > 1e-3 {
        (1.0 - phi_1(share)) / share
    } else {
        0.5 - share * (1.0 / 6.0 - share * (1.0 / 24.0 - share / 120.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shaft_moves_as_its_equation_says() {
        // ω(t) = τ/b·(1 − e^(−bt/J)),  θ(t) = τ/b·(t − J/b·(1 − e^(−bt/J)))
        let Shaft {
            inertia_kg_m2: j,
            damping_n_m_s_per_rad: b,
            ..
        } = Shaft::LEVER;
        let (torque, time_s) = (0.01, 0.09);
        let decay = libm::exp(-b * time_s / j);
        let speed = torque / b * (1.0 - decay);
        let angle = torque / b * (time_s - j / b * (1.0 - decay));
        for steps in [1, 9, 900] {
            let mut turning = Turning::new(Shaft::LEVER).expect("a good shaft");
            for _ in 0..steps {
                turning.step(torque, time_s / f64::from(steps), None);
            }
            assert!(
                (turning.speed_rad_per_s / speed - 1.0).abs() < 1e-11,
                "{turning:?}"
            );
            assert!(
                (turning.angle_rad / angle - 1.0).abs() < 1e-11,
                "{turning:?}"
            );
        }
    }

    #[test]
    fn without_damping_it_falls_freely() {
        let shaft = Shaft {
            damping_n_m_s_per_rad: 0.0,
            ..Shaft::LEVER
        };
        let mut turning = Turning::new(shaft).expect("a good shaft");
        turning.step(0.01, 0.05, None);
        // θ = τ·t²/(2J)
        let angle = 0.01 * 0.05 * 0.05 / 2.0 / 4e-5;
        assert!(
            (turning.angle_rad / angle - 1.0).abs() < 1e-12,
            "{turning:?}"
        );
    }

    #[test]
    fn a_hand_turns_and_holds() {
        let hand = Hand {
            wait_commands: 0,
            turn_rev: 0.02,
            ramp_time_s: 0.4,
        };
        let shaft = Shaft {
            hand: Some(hand),
            ..Shaft::LEVER
        };
        let mut turning = Turning::new(shaft).expect("a good shaft");
        for (turned_s, turned, speed) in [(0.0, 0.0, 0.05), (0.2, 0.01, 0.05), (0.9, 0.02, 0.0)] {
            turning.step(0.05, 0.1, Some(turned_s));
            assert!(
                (turning.angle_rad / TAU - turned).abs() < 1e-12,
                "{turning:?}"
            );
            assert!(
                (turning.speed_rad_per_s / TAU - speed).abs() < 1e-12,
                "{turning:?}"
            );
        }
    }
}
