//! Curves of a finished run, for whoever draws it.

/// Curves of a finished run, for drawing; long ones are thinned without losing a peak. An
/// experiment draws nothing itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The experiment, and whether it was simulated or rendered.
    pub title: String,
    /// The law, the device and the operator that ran, and the verdict: what distinguishes this
    /// picture from others.
    pub subtitle: String,
    /// Origin of the force: `simulated`, or `rendered` for a device's own record of what it
    /// commanded and read.
    pub origin: &'static str,
    /// Times from the start of the run, s; unevenly spaced where a long curve is thinned.
    pub time_s: Vec<f64>,
    /// Values at these times, each with its name.
    pub columns: Vec<(&'static str, Vec<f64>)>,
    /// The experiment chooses it, because only the experiment knows what its curves mean.
    pub drawing: Drawing,
}

/// Description of a run that has a closed form, for drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Theory {
    /// Compared quantity: `force`, `strain` or `depth`.
    pub quantity: &'static str,
    /// Axis label of the quantity, with its unit.
    pub label: &'static str,
    /// A measured record of the same quantity, if one is laid over the run.
    pub record: Option<Overlay>,
}

/// A measured record on the clock of a run, at its own times.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Time since the start of the ramp or push, s.
    pub time_s: Vec<f64>,
    /// The measured quantity, in the unit of the run.
    pub values: Vec<f64>,
    /// The run less the record, over the record.
    pub relative_error: Vec<f64>,
    /// The rms of the run less the record, over that of the record.
    pub rms: f64,
}

/// The picture of the curves, and what it shows besides them. A kind of experiment chooses one of
/// these, or brings one more.
#[derive(Clone, Debug, PartialEq)]
pub enum Drawing {
    /// A quantity beside its closed form.
    Theory(Theory),
    /// A device that comes to rest.
    Trial {
        /// Expected rest position, m; `None` if nothing holds the push.
        expected_deflection_m: Option<f64>,
    },
    /// Both sides of a teleoperation, and stiffnesses over the frequency in Hz, N/m: `touched` by the slave, by the `formula`, `felt`.
    Pair {
        /// Each curve has its name, as the three above.
        stiffnesses: Vec<(&'static str, Vec<(f64, f64)>)>,
    },
    /// One side of a teleoperation.
    Side,
    /// A specimen that is pressed, by a device as a testing machine.
    Press,
    /// A path in the plane of the first two axes.
    Plane {
        /// Outline of what is touched, m; empty if it does not end.
        outline_m: Vec<(f64, f64)>,
    },
}

impl Curves {
    /// The values of this name; absent if it has no such curve.
    #[must_use]
    pub fn column(&self, name: &str) -> &[f64] {
        let mut columns = self.columns.iter();
        let found = columns.find(|(known, _)| *known == name);
        found.map_or(&[], |(_, values)| values)
    }
}
