//! The path of the handle in a press.
//!
//! ```text
//! r(t) = from + (to − from)·τ/T − a·(1 − cos(2π·f·τ))        τ the time in a section of length T
//! ```
//! A rest before it, and one after the way back to 0, in which the handle is not held: there a force sensor shows its zero. A sine never goes deeper than where it begins, and begins without a jump of its speed.

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
        Motion {
            position_m: self.from_m + speed * time_s
                - amplitude * (1.0 - libm::cos(omega * time_s)),
            held: speed == 0.0 && amplitude == 0.0,
        }
    }
}

/// Wanted motion at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub position_m: f64,
    /// True while the path stays at one depth.
    pub held: bool,
}

/// Sections one after the other, after a rest in front of the specimen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PressPath {
    pub rest_s: f64,
    pub sections: Vec<Section>,
    /// Time of the way back to 0, after which it rests once more, s; `None` if it stays where it is.
    pub back_s: Option<f64>,
}

impl PressPath {
    /// True while the handle rests in front of the specimen and is not held.
    pub(crate) fn rests(&self, time_s: f64) -> bool {
        time_s < self.rest_s
            || self
                .back_s
                .is_some_and(|back_s| time_s >= self.pressed_s() + back_s)
    }

    /// The wanted motion; the last place is held for ever.
    pub(crate) fn at(&self, time_s: f64) -> Motion {
        let mut begins_s = self.rest_s;
        let mut last = Section::straight(self.rest_s.max(1.0), 0.0, 0.0);
        if time_s < begins_s {
            return last.at(time_s);
        }
        let back = self.back_s.map(|back_s| {
            let from_m = self.sections.last().map_or(0.0, |last| last.to_m);
            Section::straight(back_s, from_m, 0.0)
        });
        for section in self.sections.iter().chain(&back) {
            last = *section;
            if time_s < begins_s + section.duration_s {
                break;
            }
            begins_s += section.duration_s;
        }
        last.at((time_s - begins_s).clamp(0.0, last.duration_s))
    }

    /// Time at which the way back begins, s.
    pub(crate) fn pressed_s(&self) -> f64 {
        let sections = self.sections.iter();
        self.rest_s + sections.map(|section| section.duration_s).sum::<f64>()
    }

    pub(crate) fn duration_s(&self) -> f64 {
        let back_s = self.back_s.map_or(0.0, |back_s| back_s + self.rest_s);
        self.pressed_s() + back_s
    }

    pub(crate) fn deepest_m(&self) -> f64 {
        let sections = self.sections.iter();
        sections.map(|section| section.to_m).fold(0.0, f64::max)
    }
}
