//! The body of an emulated 2DIY: a mass at the handle, moved by both motors and by a hand.

use crate::lead::lead;
use haptic_devices::haply::{HaplyModel, Pantograph};
use nalgebra::Vector2;

/// Mass of handle and arms, felt at the handle, kg.
const MASS_KG: f64 = 0.1;
/// Damping of the joints, felt at the handle, N·s/m.
const DAMPING_N_S_PER_M: f64 = 1.0;
/// Stiffness and damping of a hand that leads the handle, N/m and N·s/m.
const GRIP: (f64, f64) = (400.0, 8.0);
/// Longest step of the simulation, s: far below every time constant here.
const STEP_S: f64 = 1e-4;
/// Time in which a hand leads the handle from its home to where it begins, s.
const LEAD_S: f64 = 1.0;

/// The hand at the handle of an emulated device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hand {
    /// Nobody holds the handle, once the device is open.
    Free,
    /// Leads the handle to a place within a second, m, and holds it there, softly.
    At([f64; 2]),
    /// The handle is at this place whatever the motors do.
    Fixed([f64; 2]),
    /// Leads the handle to a place, m, and strokes away from the base and back, softly.
    Strokes {
        /// Place to begin at, m.
        from: [f64; 2],
        /// Way of a stroke, m.
        depth_m: f64,
        /// Time of a stroke, there and back, s.
        time_s: f64,
    },
}

/// A mass in the plane of the pantograph. It stops where the arms end.
#[derive(Clone, Debug)]
pub struct Body {
    pantograph: Pantograph,
    home: Vector2<f64>,
    home_angles: [f64; 2],
    hand: Hand,
    place_m: Vector2<f64>,
    speed_m_per_s: Vector2<f64>,
    angles: [f64; 2],
    time_s: f64,
    torques_nm: Vector2<f64>,
    /// When the hand began to lead.
    led_s: Option<f64>,
}

impl Body {
    /// A handle at its home, at rest.
    #[must_use]
    pub fn at_home(model: &HaplyModel, hand: Hand) -> Self {
        let angles = model.home();
        // The home of both versions is a posture in order, as a test shows.
        let place = model.pantograph.posture(angles);
        let home = place.map_or_else(|_| Vector2::zeros(), |posture| posture.hand_m);
        Self {
            pantograph: model.pantograph,
            home,
            home_angles: angles,
            hand,
            place_m: home,
            speed_m_per_s: Vector2::zeros(),
            angles,
            time_s: 0.0,
            torques_nm: Vector2::zeros(),
            led_s: None,
        }
    }

    /// Angles of both joints, rad.
    #[must_use]
    pub const fn angles(&self) -> [f64; 2] {
        self.angles
    }

    /// Place of the handle, m.
    #[must_use]
    pub const fn place_m(&self) -> Vector2<f64> {
        self.place_m
    }

    /// The torques of both motors from now on, N·m.
    pub fn turn(&mut self, torques_nm: Vector2<f64>) {
        self.torques_nm = torques_nm;
    }

    /// The device is configured. Whoever opens it holds the handle at its home, as they must; then
    /// the hand takes it from there. Nothing opens it while a motor drives: the handle stays where
    /// it is.
    pub fn opened(&mut self) {
        if self.torques_nm == Vector2::zeros() {
            (self.place_m, self.angles) = (self.home, self.home_angles);
            self.speed_m_per_s = Vector2::zeros();
            self.led_s = Some(self.time_s);
        }
        self.led_s.get_or_insert(self.time_s);
    }

    /// Moves on to a time, s.
    pub fn advance(&mut self, time_s: f64) {
        while self.time_s < time_s {
            let step_s = (time_s - self.time_s).min(STEP_S);
            self.step(step_s);
            self.time_s += step_s;
        }
    }

    fn step(&mut self, step_s: f64) {
        let target = self
            .led_s
            .map(|led_s| self.target(self.time_s + step_s - led_s));
        if let (Hand::Fixed(_), Some((place, speed))) = (self.hand, target) {
            self.moves_to(place, speed);
            return;
        }
        let Ok(posture) = self.pantograph.posture(self.angles) else {
            return;
        };
        let mut force = posture.force(self.torques_nm) - self.speed_m_per_s * DAMPING_N_S_PER_M;
        if let Some((place, speed)) = target {
            let (stiffness, damping) = GRIP;
            force += (place - self.place_m) * stiffness + (speed - self.speed_m_per_s) * damping;
        }
        let speed = self.speed_m_per_s + force * (step_s / MASS_KG);
        self.moves_to(self.place_m + speed * step_s, speed);
    }

    /// Goes to a place, if the arms reach it; stops at their end.
    fn moves_to(&mut self, place: Vector2<f64>, speed: Vector2<f64>) {
        if let Ok(angles) = self.pantograph.angles(place)
            && self.pantograph.posture(angles).is_ok()
        {
            (self.place_m, self.speed_m_per_s) = (place, speed);
            self.angles = angles;
        } else {
            self.speed_m_per_s = Vector2::zeros();
        }
    }

    /// Place and velocity that the hand wants for the handle, `since_s` after it began.
    fn target(&self, since_s: f64) -> (Vector2<f64>, Vector2<f64>) {
        let nowhere = (self.place_m, self.speed_m_per_s);
        match self.hand {
            Hand::Free => nowhere,
            Hand::At(place) | Hand::Fixed(place) => self.led(place.into(), since_s),
            Hand::Strokes { from, .. } if since_s < LEAD_S => self.led(from.into(), since_s),
            Hand::Strokes {
                from,
                depth_m,
                time_s,
            } => {
                let rate = core::f64::consts::TAU / time_s;
                let phase = rate * (since_s - LEAD_S);
                let depth = 0.5 * depth_m * (1.0 - libm::cos(phase));
                let speed = 0.5 * depth_m * rate * libm::sin(phase);
                (
                    Vector2::from(from) + Vector2::new(0.0, depth),
                    Vector2::new(0.0, speed),
                )
            }
        }
    }

    /// Place and velocity on the way from home to a place, smoothly: half a cosine.
    fn led(&self, to: Vector2<f64>, since_s: f64) -> (Vector2<f64>, Vector2<f64>) {
        let (share, rate) = lead(since_s, LEAD_S);
        let way = to - self.home;
        (self.home + way * share, way * rate)
    }
}
