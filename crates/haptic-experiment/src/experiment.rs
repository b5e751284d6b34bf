//! The kinds of experiment: a folder each, with what it asks of a document, its law, and how it is judged.

#[cfg(test)]
mod bounded_tests;
pub(crate) mod coupler;
pub(crate) mod drive;
pub(crate) mod indentation;
pub(crate) mod kind;
pub(crate) mod press;
pub(crate) mod reading;
pub(crate) mod teleoperation;
pub(crate) mod touch;
pub(crate) mod trial;
pub(crate) mod wall;

use haptic_document::parameters::{KeyTable, ON_DEVICE};
use haptic_judge::{coupler as judged, rendering};
use haptic_trial::{keys, robot::ADMITTANCE, safety::keys::SAFETY};
use kind::{Companion, Kind};
pub use teleoperation::{End, FarReport, Terms};

const COUPLER_REQUIRED: KeyTable = ("required", judged::COUPLER_REQUIRED);
const COUPLER: KeyTable = ("coupler", judged::COUPLER);
const TELEOPERATION: KeyTable = ("teleoperation", keys::teleoperation::TELEOPERATION);
const TOUCH: KeyTable = ("touch", touch::TOUCH);
const PRESS: KeyTable = ("press", press::PRESS);
const DEVICE: KeyTable = ("device", ON_DEVICE);
const CHAIN: KeyTable = ("safety", SAFETY);

/// All that there is to say of each kind. A new one has a row here, its keys in [`HEADINGS`], and a file of its own.
const ALL: &[Kind] = &[
    Kind {
        name: "relax",
        keys: rendering::RELAX_TABLES,
        companion: Companion::Drive,
        read: |table, beside| Ok(Box::new(indentation::relax(table, beside.drive)?)),
    },
    Kind {
        name: "creep",
        keys: rendering::CREEP_TABLES,
        companion: Companion::Drive,
        read: |table, beside| Ok(Box::new(indentation::creep(table, beside.drive)?)),
    },
    Kind {
        name: "wall",
        keys: keys::wall::WALL_TABLES,
        companion: Companion::DriveAndDeviceFile,
        read: |table, beside| Ok(Box::new(wall::wall(table, beside)?)),
    },
    Kind {
        name: "coupler",
        keys: &[COUPLER_REQUIRED, COUPLER, DEVICE, CHAIN],
        companion: Companion::DriveAndDeviceFile,
        read: |table, beside| Ok(Box::new(coupler::coupler(table, beside)?)),
    },
    Kind {
        name: "teleoperation",
        // Both devices are simulated.
        keys: &[TELEOPERATION, CHAIN],
        companion: Companion::Nothing,
        read: |table, _| Ok(Box::new(teleoperation::teleoperation(table)?)),
    },
    Kind {
        name: "touch",
        keys: &[TOUCH, DEVICE, CHAIN],
        companion: Companion::Nothing,
        read: |table, _| Ok(Box::new(touch::touch(table)?)),
    },
    Kind {
        name: "press",
        keys: &[PRESS, DEVICE, CHAIN],
        companion: Companion::DriveAndDeviceFile,
        read: |table, beside| Ok(Box::new(press::press(table, beside.drive)?)),
    },
];

/// The keys of the kinds, as help and guide show them: those that two kinds share stand once.
pub(crate) const HEADINGS: &[KeyTable] = &[
    ("[relax]", rendering::RELAX),
    ("[creep]", rendering::CREEP),
    ("[relax] and [creep]", rendering::RENDERING),
    (
        "[drive], beside [relax], [creep], [press], [wall] or [coupler]",
        keys::drive::DRIVE,
    ),
    (
        "[admittance], beside [wall], or in a device file",
        keys::admittance::ADMITTANCE_TABLE,
    ),
    ("[wall], required", keys::wall::WALL_REQUIRED),
    (
        "[wall], its law: order, K and B, or a piece of tissue",
        keys::wall::WALL_LAW,
    ),
    ("[wall]", keys::wall::WALL),
    ("[coupler], required", judged::COUPLER_REQUIRED),
    ("[coupler]", judged::COUPLER),
    ("[teleoperation]", keys::teleoperation::TELEOPERATION),
    ("[touch]", touch::TOUCH),
    ("[press]", press::PRESS),
    ("Every table but [teleoperation], the device", ON_DEVICE),
    ("Every table, the safety chain", SAFETY),
];

/// Kinds of experiments, the names of their tables in files.
pub const KINDS: [&str; ALL.len()] = {
    let mut names = [""; ALL.len()];
    let mut n = 0;
    while n < ALL.len() {
        names[n] = ALL[n].name;
        n += 1;
    }
    names
};

/// The table beside an experiment that a controller drives.
pub const DRIVE_TABLE: &str = "drive";

/// Tables that may stand beside an experiment.
pub const BESIDE: [&str; 2] = [DRIVE_TABLE, ADMITTANCE];

/// The kind of this name.
pub(crate) fn find(name: &str) -> Option<&'static Kind> {
    ALL.iter().find(|kind| kind.name == name)
}

/// Tables of a kind, or of the drive beside one: heading and parameters; `None` if it is not one.
pub(crate) fn tables(name: &str) -> Option<&'static [KeyTable]> {
    match name {
        DRIVE_TABLE => Some(&[(DRIVE_TABLE, keys::drive::DRIVE)]),
        ADMITTANCE => Some(&[(ADMITTANCE, keys::admittance::ADMITTANCE_TABLE)]),
        _ => find(name).map(|kind| kind.keys),
    }
}
