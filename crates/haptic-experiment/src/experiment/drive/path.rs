//! The path of the handle in a press.
//!
//! ```text
//! r(t) = from + (to − from)·τ/T − a·(1 − cos(2π·f·τ))        τ the time in a section of length T
//! ```
//! A sine never goes deeper than where it begins, and begins without a jump of its speed.

use std::f64::consts::TAU;

/// A straight part of the path, or a sine at a depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    pub duration_s: f64,
    pub from_m: f64,
    pub to_m: f64,
    /// Frequency, Hz, and amplitude, m; both 0 without a sine.
    pub sine: [f64; 2],
}

impl Section {
    pub(crate) const fn straight(duration_s: f64, from_m: f64, to_m: f64) -> Self {
        Self {
            duration_s,
            from_m,
            to_m,
            sine: [0.0; 2],
        }
    }

    fn at(&self, time_s: f64) -> Motion {
        let [omega, amplitude] = [TAU * self.sine[0], self.sine[1]];
        let speed = (self.to_m - self.from_m) / self.duration_s;
        let (sine, cosine) = (omega * time_s).sin_cos();
        Motion {
            position_m: self.from_m + speed * time_s - amplitude * (1.0 - cosine),
            speed_m_per_s: speed - amplitude * omega * sine,
            held: (speed == 0.0 && amplitude == 0.0).then(|| {
                // From 0 to 1, evenly in the logarithm of time, as a tissue relaxes.
                let share = |time_s: f64| (time_s / HOLD_BEGINS_S).ln_1p();
                share(time_s) / share(self.duration_s)
            }),
        }
    }
}

/// Time after which a hold is long, s.
const HOLD_BEGINS_S: f64 = 0.01;

/// Wanted motion at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub position_m: f64,
    pub speed_m_per_s: f64,
    /// Share of a hold that is over; `None` on the move.
    pub held: Option<f64>,
}

/// Sections one after the other, after a rest in front of the specimen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PressPath {
    pub(crate) rest_s: f64,
    pub(crate) sections: Vec<Section>,
}

impl PressPath {
    /// True while the handle rests in front of the specimen and is not held.
    pub(crate) fn rests(&self, time_s: f64) -> bool {
        time_s < self.rest_s
    }

    /// The wanted motion; the last place is held for ever.
    pub(crate) fn at(&self, time_s: f64) -> Motion {
        let mut begins_s = self.rest_s;
        let mut last = Section::straight(self.rest_s.max(1.0), 0.0, 0.0);
        if time_s < begins_s {
            return last.at(time_s);
        }
        for section in &self.sections {
            last = *section;
            if time_s < begins_s + section.duration_s {
                break;
            }
            begins_s += section.duration_s;
        }
        last.at((time_s - begins_s).clamp(0.0, last.duration_s))
    }

    pub(crate) fn duration_s(&self) -> f64 {
        let sections = self.sections.iter();
        self.rest_s + sections.map(|section| section.duration_s).sum::<f64>()
    }

    pub(crate) fn deepest_m(&self) -> f64 {
        let sections = self.sections.iter();
        sections.map(|section| section.to_m).fold(0.0, f64::max)
    }
}
