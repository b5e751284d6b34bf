//! An Inverse3 by name.

use crate::name::{NameError, Settings};
use nalgebra::{SMatrix, Vector3};
use std::fmt;

/// Lines through the middle of the workspace, for experiments with one axis.
const LINES: [(&str, [f64; 3]); 6] = [
    ("x", [1.0, 0.0, 0.0]),
    ("y", [0.0, 1.0, 0.0]),
    ("z", [0.0, 0.0, 1.0]),
    ("-x", [-1.0, 0.0, 0.0]),
    ("-y", [0.0, -1.0, 0.0]),
    ("-z", [0.0, 0.0, -1.0]),
];
/// Downwards, so that a hand presses into a tissue as into one on a table.
const DOWN: [f64; 3] = LINES[5].1;
const LOST: u32 = 20;

/// An Inverse3 by name: `inverse3:[HOST[:PORT]][,id=ID][,axis=-z][,lost=20]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Inverse3Name {
    /// Host and port at which the service speaks HTTP and WebSocket.
    pub(super) address: String,
    /// The device's number at the service; `None` for the only one.
    pub(super) id: Option<String>,
    /// Number of ticks in a row without an answer that causes a fault in a run, 2 to 1000; at rest 2 s do.
    pub(super) lost_most: u32,
    /// Unit vector along the line of an experiment with one axis.
    pub(super) along: [f64; 3],
}

impl Inverse3Name {
    /// First word of the name.
    pub const KIND: &'static str = "inverse3";
    /// Port of the service unless another is given.
    pub const PORT: u16 = 10_001;
    pub(crate) const FORM: &'static str =
        "inverse3:[HOST[:PORT]][,id=ID][,axis=x|y|z|-x|-y|-z][,lost=20]";

    /// Reads what stands behind `inverse3:`.
    ///
    /// # Errors
    /// A port, key or value that cannot be.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let at_home = text.is_empty() || text.starts_with(',');
        let text = if at_home {
            format!("localhost{text}")
        } else {
            text.to_owned()
        };
        let given = Settings::parse(Self::KIND, &text, &["id", "axis", "lost"])?;
        // An address of IPv6 has colons of its own, within brackets.
        let split = given.path.rsplit_once(':');
        let address = match split.filter(|(_, port)| !port.contains(']')) {
            Some((host, port)) => {
                let port = whole("port", port, 1, u16::MAX.into())?;
                format!("{host}:{port}")
            }
            None => format!("{}:{}", given.path, Self::PORT),
        };
        let lost = given.text("lost");
        Ok(Self {
            address,
            id: given.text("id").map(str::to_owned),
            lost_most: lost.map_or(Ok(LOST), |lost| whole("lost", lost, 2, 1000))?,
            along: given.choice("axis", &LINES, DOWN)?,
        })
    }

    /// The lines of an experiment with D axes: with one the line of the name, with three all axes.
    pub(super) fn lines<const D: usize>(&self) -> SMatrix<f64, 3, D> {
        if D == 1 {
            SMatrix::from_fn(|row, _| self.along[row])
        } else {
            SMatrix::identity()
        }
    }

    /// True if it chooses a line, which an experiment with all axes has no use for.
    pub(crate) fn chooses_line(&self) -> bool {
        Vector3::from(self.along) != Vector3::from(DOWN)
    }
}

fn whole(key: &'static str, value: &str, least: u32, most: u32) -> Result<u32, NameError> {
    let number = value.parse().ok();
    let number = number.filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| NameError::Number {
        key,
        value: value.to_owned(),
        least: least.into(),
        most: most.into(),
        unit: "",
    })
}

impl fmt::Display for Inverse3Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", Self::KIND, self.address)?;
        if let Some(id) = &self.id {
            write!(f, ",id={id}")?;
        }
        if self.chooses_line() {
            let along = Vector3::from(self.along);
            let mut lines = LINES.iter();
            let line = lines.find(|(_, line)| Vector3::from(*line) == along);
            write!(f, ",axis={}", line.map_or("", |(name, _)| name))?;
        }
        if self.lost_most != LOST {
            write!(f, ",lost={}", self.lost_most)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_host_port_and_device() {
        for (given, text) in [
            ("", "inverse3:localhost:10001"),
            (",id=049D", "inverse3:localhost:10001,id=049D"),
            ("desk", "inverse3:desk:10001"),
            ("desk:7,axis=-y,lost=9", "inverse3:desk:7,axis=-y,lost=9"),
            ("[::1]", "inverse3:[::1]:10001"),
            ("[::1]:8,axis=-z", "inverse3:[::1]:8"),
        ] {
            let name = Inverse3Name::parse(given).expect(given);
            assert_eq!(name.to_string(), text);
            let again = text.strip_prefix("inverse3:").expect("its kind");
            assert_eq!(Inverse3Name::parse(again), Ok(name), "{text}");
        }
        for (bad, text) in [
            ("desk:0", "port = \"0\" is not in [1, 65535]"),
            ("desk:99999", "port = \"99999\" is not in [1, 65535]"),
            ("desk:", "port = \"\" is not in [1, 65535]"),
            ("desk,lost=1", "lost = \"1\" is not in [2, 1000]"),
            (
                "desk,axis=up",
                "axis = \"up\" is not one of x, y, z, -x, -y, -z",
            ),
            (
                "desk,uuid=5",
                "\"uuid=5\" is not a setting: write key=value; the keys of inverse3 are id, axis, lost",
            ),
            ("desk,id=1,id=2", "id is given twice"),
        ] {
            let error = Inverse3Name::parse(bad).expect_err(bad);
            assert_eq!(error.to_string(), text);
        }
    }
}
