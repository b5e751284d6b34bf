//! The arms of an emulated Inverse3, felt as one mass at its cursor, and a hand that holds it.

use crate::lead::lead;
use core::f64::consts::TAU;
use nalgebra::Vector3;

/// Middle of the workspace from the device's base, m: about where the maker's examples have it.
pub const CENTRE_M: [f64; 3] = [0.0, -0.12, 0.15];
/// Mass of cursor and arms, kg, and what moving them costs, N·s/m.
const MASS_KG: f64 = 0.15;
const DAMPING_N_S_PER_M: f64 = 0.5;
/// Stiffness and damping of a hand, N/m and N·s/m.
const GRIP: (f64, f64) = (400.0, 10.0);
/// Depth of a stroke, m, and its time there and back, s.
const STROKE: (f64, f64) = (0.015, 4.0);
/// A hand takes this time to a place, s.
const LEAD_S: f64 = 1.0;
/// Longest step of the simulation, s: far below every time constant here.
const STEP_S: f64 = 2.5e-4;

/// The hand at the cursor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Hand {
    /// Strokes downwards from the middle of the workspace and back, softly.
    #[default]
    Strokes,
    /// Nobody holds the cursor: it drifts.
    Free,
    /// Leads the cursor to a place, m from the middle of the workspace, and holds it there, softly.
    At([f64; 3]),
}

/// The mass, at rest in the middle of the workspace at first.
#[derive(Clone, Debug, Default)]
pub struct Body {
    hand: Hand,
    /// Place, m from the middle of the workspace, and its speed, m/s.
    pub(super) place_m: Vector3<f64>,
    pub(super) speed_m_per_s: Vector3<f64>,
    time_s: f64,
    /// When the hand began to lead it.
    led_s: Option<f64>,
}

impl Body {
    /// A mass in this hand.
    #[must_use]
    pub fn held_by(hand: Hand) -> Self {
        Self {
            hand,
            ..Self::default()
        }
    }

    /// Puts the cursor somewhere, m from the middle of the workspace, at rest.
    pub fn place(&mut self, place_m: [f64; 3]) {
        (self.place_m, self.speed_m_per_s) = (place_m.into(), Vector3::zeros());
    }

    /// A program has begun to command it, which the hand waits for.
    pub(super) fn begin(&mut self) {
        self.led_s.get_or_insert(self.time_s);
    }

    /// Moves on to a time, s, under a force, N, and a damping of the service, N·s/m.
    pub(super) fn advance(&mut self, time_s: f64, force_n: Vector3<f64>, damping: f64) {
        while self.time_s < time_s {
            let step_s = (time_s - self.time_s).min(STEP_S);
            let mut sum = force_n - self.speed_m_per_s * (DAMPING_N_S_PER_M + damping);
            if let Some(target) = self.target() {
                sum += (target - self.place_m) * GRIP.0 - self.speed_m_per_s * GRIP.1;
            }
            self.speed_m_per_s += sum * (step_s / MASS_KG);
            self.place_m += self.speed_m_per_s * step_s;
            self.time_s += step_s;
        }
    }

    /// Place that the hand wants for the cursor; `None` without a hand.
    fn target(&self) -> Option<Vector3<f64>> {
        let since_s = self.led_s.map_or(0.0, |led_s| self.time_s - led_s);
        match self.hand {
            Hand::Free => None,
            Hand::At(place) => Some(Vector3::from(place) * lead(since_s, LEAD_S).0),
            Hand::Strokes => {
                let phase = TAU * since_s / STROKE.1;
                let depth_m = 0.5 * STROKE.0 * (1.0 - libm::cos(phase));
                Some(Vector3::new(0.0, 0.0, -depth_m))
            }
        }
    }
}
