//! Limits that `device set` gave a device, kept on this computer: a board forgets them when it is switched off, a device that
//! is served from here with every command. Before it is armed it gets those that are tighter than what it has.
//!
//! *Place*: a file for each [identity](DeviceIdentity) in `limits` below the folder of [`Remembered::VARIABLE`], else below
//! `fractional-haptics` in the user's folder of states. A file is replaced as a whole, so the last of two writers counts.
//!
//! ```toml
//! format = 1
//! device = "rp2040 E6612483CB1B9221"
//! board = "rp2040"
//! turn = 3                   # it was set after those with less
//! tick_period_us = 1000
//! force_limit_n = 0.5        # limits by key; one that is missing has its default
//! ```
//! | device | has the tighter of |
//! |---|---|
//! | with a number, or at a link | its own limits; with a number, also those without one of its name that were set after them: they may be its own |
//! | real, without a number | all limits of its name, and cannot loosen one: it may be another device's |
//! | simulated, at a nameless pseudo-terminal | none |
//!
//! *Errors*: a file that is there and cannot be read, or is in the way of an older version, keeps the device from being armed.

use crate::identity::{DeviceIdentity, Known};
use haptic_document::{Failure, bad_input};
use haptic_link::{Configuration, GuardKind, Limits};
use haptic_log::record::NewFile;
use haptic_loop::Limit;
use haptic_quantity::{digits, label, written};
use serde_json::{Map, Value, json};
use std::{
    env::{home_dir, var_os},
    fmt::Display,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

/// Format of the files; a file of another one is refused.
const FORMAT: u64 = 1;
/// Files in the folder are these; others are of versions that came before, or of unfinished writes.
const ENDING: &str = "toml";

/// The place where the limits of a device are remembered.
#[derive(Debug)]
pub struct Remembered {
    identity: DeviceIdentity,
    /// `None` where nothing is to be remembered.
    folder: Option<PathBuf>,
}

/// The limits that a file keeps.
#[derive(Clone, Debug, PartialEq)]
struct Kept {
    board: String,
    turn: u64,
    /// Configuration with the tick for which it was set.
    set: Configuration,
}

impl Remembered {
    /// Names the folder in which limits are remembered; empty, nothing is.
    pub const VARIABLE: &'static str = "FRACTIONAL_HAPTICS_STATE";

    pub(crate) fn of(identity: DeviceIdentity) -> Self {
        let folder = folder().map(|folder| folder.join("limits"));
        Self::within(identity, folder)
    }

    fn within(identity: DeviceIdentity, folder: Option<PathBuf>) -> Self {
        let folder = folder.filter(|_| identity.known != Known::Not);
        Self { identity, folder }
    }

    /// Device on which the limits were set.
    #[must_use]
    pub const fn identity(&self) -> &DeviceIdentity {
        &self.identity
    }

    /// The limits of a configuration, each replaced by a tighter one that is remembered; `None` if none is.
    ///
    /// # Errors
    /// A file that cannot be read, or is not one of these.
    pub fn tightened(&self, present: &Configuration) -> Result<Option<Limits>, Failure> {
        let set = self.set()?;
        let tightened = set.map(|set| present.tightened(&set));
        Ok(tightened.and_then(|(limits, looser)| looser.map(|_| limits)))
    }

    /// The limits that are remembered, with the tick for which they were set; `None` if none are.
    ///
    /// # Errors
    /// As [`tightened`](Self::tightened).
    pub fn set(&self) -> Result<Option<Configuration>, Failure> {
        let tighter = |all: Configuration, next: &Kept| Configuration {
            limits: all.tightened(&next.set).0,
            ..all
        };
        let mut kept = self.kept()?.into_iter();
        Ok(kept
            .next()
            .map(|first| kept.fold(first.set, |all, next| tighter(all, &next))))
    }

    /// Refuses a limit that is looser than that of another device which this one may be.
    ///
    /// # Errors
    /// As [`tightened`](Self::tightened); a looser limit.
    pub fn admits(&self, next: &Configuration) -> Result<(), Failure> {
        let tight = match self.identity.known {
            Known::ByName => self.tightened(next)?,
            Known::Number(_) | Known::Link(_) | Known::Not => None,
        };
        tight.map_or(Ok(()), |tight| {
            Err(bad_input!(
                "{} may be any of its name, and one of them was set tighter ({}): end that with host-cli device forget on it, or \
                 flash firmware that tells a serial number",
                self.identity,
                loosened(&tight, &next.limits).join(", ")
            ))
        })
    }

    /// Words for a device that has these limits again, of which it had others.
    pub(crate) fn words(&self, lost: &str) -> Result<String, Failure> {
        let device = &self.identity;
        let board = &device.board;
        let own = (self.folder.as_ref()).map(|folder| self.read(&self.file(folder)));
        let has_own = own.transpose()?.flatten().is_some();
        Ok(if has_own && device.known != Known::ByName {
            format!(
                "{device} had forgotten limits that host-cli device set gave it, and has them again ({lost}); host-cli device \
                 forget ends them"
            )
        } else {
            format!(
                "{device} may be any {board} that was set without a serial number or has the same name, and has the tightest limits \
                 of them ({lost})"
            )
        })
    }

    /// All limits that may have been set on this device.
    fn kept(&self) -> Result<Vec<Kept>, Failure> {
        let Some(folder) = &self.folder else {
            return Ok(Vec::new());
        };
        let files = self.files(folder)?;
        let board = &self.identity.board;
        if self.identity.known == Known::ByName {
            let all = files.iter().map(|file| self.read(file));
            let all = all.filter_map(Result::transpose);
            return all
                .filter(|kept| !matches!(kept, Ok(kept) if kept.board != *board))
                .collect();
        }
        let own = self.read(&self.file(folder))?;
        let nameless = match self.identity.known {
            Known::Number(_) => self.read(&folder.join(file_name(&nameless(board))))?,
            Known::Link(_) | Known::ByName | Known::Not => None,
        };
        let after = own.as_ref().map_or(0, |own| own.turn);
        let later = nameless.filter(|nameless| nameless.turn > after);
        Ok(own.into_iter().chain(later).collect())
    }

    /// The files of limits. One of a version that came before may be of any device.
    fn files(&self, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        let found = match fs::read_dir(folder) {
            Ok(found) => found.collect::<Result<Vec<_>, _>>(),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => Err(error),
        };
        let found = found.map_err(|error| self.unreadable(folder, &error))?;
        let mut files: Vec<PathBuf> = found.into_iter().map(|entry| entry.path()).collect();
        files.sort();
        let older = |file: &&PathBuf| file.extension().is_some_and(|ending| ending == "json");
        if let Some(older) = files.iter().find(older) {
            return Err(Failure::device(format_args!(
                "`{}` has limits that an earlier version set on a device ({}): remove that file, then set them anew with host-cli \
                 device set",
                older.display(),
                content(older)
            )));
        }
        files.retain(|file| file.extension().is_some_and(|ending| ending == ENDING));
        Ok(files)
    }

    /// The file of this device.
    fn file(&self, folder: &Path) -> PathBuf {
        folder.join(file_name(&match &self.identity.known {
            Known::Number(number) => format!("number {number}"),
            Known::Link(link) => format!("at {link}"),
            Known::ByName | Known::Not => nameless(&self.identity.board),
        }))
    }

    fn read(&self, file: &Path) -> Result<Option<Kept>, Failure> {
        let text = match file.symlink_metadata() {
            Ok(found) if found.is_file() => fs::read_to_string(file),
            Ok(_) => Err(ErrorKind::InvalidInput.into()),
            // No limit was ever remembered under a name that is too long.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::NotFound | ErrorKind::InvalidFilename
                ) =>
            {
                return Ok(None);
            }
            Err(error) => Err(error),
        };
        let text = text.map_err(|error| self.unreadable(file, &error))?;
        let kept = Kept::read(&text).map(Some);
        kept.map_err(|why| self.unreadable(file, &format_args!("{why}; it has {}", content(file))))
    }

    fn unreadable(&self, file: &Path, why: &dyn Display) -> Failure {
        Failure::device(format_args!(
            "the limits that were set on {} cannot be read from `{}` ({why}): remove that file, or end them with host-cli device \
             forget, then set them anew",
            self.identity,
            file.display()
        ))
    }

    /// Remembers what was set; false if nothing is to be remembered.
    ///
    /// # Errors
    /// A file that cannot be written; limits that cannot be read.
    pub fn keep(&self, set: &Configuration) -> Result<bool, Failure> {
        let Some(folder) = &self.folder else {
            return Ok(false);
        };
        let turns = self.kept()?.into_iter().map(|kept| kept.turn);
        let kept = Kept {
            board: self.identity.board.clone(),
            turn: 1 + turns.max().unwrap_or(0),
            set: *set,
        };
        let text = kept.text(&self.identity);
        fs::create_dir_all(folder).map_err(|error| self.unwritten(&error))?;
        let written = NewFile::filled(&self.file(folder), text.as_bytes(), true);
        let written = written.and_then(NewFile::publish);
        written.map_err(|error| self.unwritten(&error))?;
        Ok(true)
    }

    fn unwritten(&self, why: &dyn Display) -> Failure {
        Failure::device(format_args!(
            "the limits hold until {} is switched off, and cannot be remembered ({why}): set {} to another folder",
            self.identity,
            Self::VARIABLE
        ))
    }

    /// Ends what is remembered of this device, and returns it in one line; `None` if nothing is.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn forget(&self) -> Result<Option<String>, Failure> {
        let Some(file) = self.folder.as_ref().map(|folder| self.file(folder)) else {
            return Ok(None);
        };
        let had = content(&file);
        match fs::remove_file(&file) {
            Ok(()) => Ok(Some(had)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::device(format_args!(
                "the limits that were set on {} cannot be forgotten ({error}): remove `{}`",
                self.identity,
                file.display()
            ))),
        }
    }
}

/// Limits of real devices of this name that have no number.
fn nameless(board: &str) -> String {
    format!("any {board}")
}

/// The lines of a file in one, for a message.
fn content(file: &Path) -> String {
    let is_file = file.symlink_metadata().is_ok_and(|found| found.is_file());
    let text = is_file.then(|| fs::read(file).unwrap_or_default());
    let text = String::from_utf8_lossy(&text.unwrap_or_default()).into_owned();
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(", ")
}

/// Each limit that is remembered, by its key, in the limits as the wire names them; those of a run are not.
fn each(limits: &mut Value, prefix: &str, visit: &mut dyn FnMut(&str, &mut Value)) {
    for (name, value) in limits.as_object_mut().into_iter().flatten() {
        let key = match name.as_str() {
            "watchdog_ms" | "late_ticks" | "max_age_ticks" => continue,
            "guard" => {
                each(value, "guard_", visit);
                continue;
            }
            "force_n" => Limit::Force.key(),
            "force_rate_n_per_s" => Limit::ForceRate.key(),
            "speed_hard_m_per_s" => Limit::Speed.key(),
            name => name,
        };
        visit(&format!("{prefix}{key}"), value);
    }
}

/// The limits that are remembered, by their keys.
fn by_key(limits: &Limits) -> Map<String, Value> {
    let mut map = Map::new();
    each(&mut json!(limits), "", &mut |key, value| {
        // In its shortest form: 0.1, not 0.10000000149.
        let single = value.as_f64().filter(|_| value.is_f64());
        let single = single.and_then(|number| (number as f32).to_string().parse::<f64>().ok());
        map.insert(
            key.to_owned(),
            single.map_or_else(|| value.clone(), Value::from),
        );
    });
    map
}

impl Kept {
    fn text(&self, identity: &DeviceIdentity) -> String {
        let head = json!({
            "format": FORMAT,
            "device": identity.to_string(),
            "board": self.board,
            "turn": self.turn,
            "tick_period_us": self.set.tick_period_us,
        });
        let head = head.as_object().cloned().unwrap_or_default();
        // A number or a text of JSON is one of TOML.
        let lines = head.into_iter().chain(by_key(&self.set.limits));
        lines
            .map(|(key, value)| format!("{key} = {value}\n"))
            .collect()
    }

    /// The limits of a file; an unknown key could be a limit that this program would not keep.
    fn read(text: &str) -> Result<Self, String> {
        let not_ours = |key: &str, value: &Value| format!("{key} = {value} is not of this version");
        let table: toml::Table = (text.parse()).map_err(|_| "it is not a file of limits")?;
        let mut given = json!(table).as_object().cloned().unwrap_or_default();
        let [format, board, turn, period, _] =
            ["format", "board", "turn", "tick_period_us", "device"].map(|key| given.remove(key));
        let format = format.ok_or("it has no format")?;
        if format != FORMAT {
            return Err(not_ours("format", &format));
        }
        let mut limits = json!(Limits::DEFAULT);
        each(&mut limits, "", &mut |key, value| {
            if let Some(given) = given.remove(key) {
                *value = given;
            }
        });
        if let Some((key, value)) = given.iter().next() {
            return Err(not_ours(key, value));
        }
        let limits = serde_json::from_value(in_order(&limits));
        let limits: Limits = limits.map_err(|error| error.to_string())?;
        let (low, high, mut least) = (limits.workspace_low_m, limits.workspace_high_m, limits);
        let mut all = Limit::ALL.into_iter();
        if low > high || all.any(|limit| *least.number(limit).0 < 0.0) {
            return Err("a limit is below 0, or the workspace ends before it begins".to_owned());
        }
        let board = board.as_ref().and_then(Value::as_str).unwrap_or_default();
        let whole = |value: Option<Value>| value.as_ref().and_then(Value::as_u64);
        let period_us = whole(period).and_then(|us| u32::try_from(us).ok());
        Ok(Self {
            board: board.to_owned(),
            turn: whole(turn).unwrap_or(0),
            set: Configuration {
                tick_period_us: period_us.unwrap_or(1000),
                limits,
                ..Configuration::PASSIVE
            },
        })
    }
}

/// The values of objects without their names: limits are read in order only.
fn in_order(value: &Value) -> Value {
    let Some(fields) = value.as_object() else {
        return value.clone();
    };
    fields.values().map(in_order).collect()
}

/// The name of a device's file. Two devices have two files, even on a file system that ignores case.
fn file_name(device: &str) -> String {
    let encoded = device.chars().map(|c| match c {
        'a'..='z' | '0'..='9' | '.' => c.to_string(),
        c => format!("-{:x}-", u32::from(c)),
    });
    format!("{}.{ENDING}", encoded.collect::<String>())
}

/// The folder for states of this program, if there is one.
fn folder() -> Option<PathBuf> {
    if let Some(given) = var_os(Remembered::VARIABLE) {
        return Some(PathBuf::from(given)).filter(|given| !given.as_os_str().is_empty());
    }
    let states = if cfg!(windows) {
        PathBuf::from(var_os("LOCALAPPDATA")?)
    } else if cfg!(target_os = "macos") {
        home_dir()?.join("Library/Application Support")
    } else {
        let given = var_os("XDG_STATE_HOME").map(PathBuf::from);
        // A path that is not absolute is to be ignored.
        match given.filter(|given| given.is_absolute()) {
            Some(given) => given,
            None => home_dir()?.join(".local/state"),
        }
    };
    Some(states.join("fractional-haptics"))
}

/// The limits that are looser than before, a sentence each.
#[must_use]
pub fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    const NONE: f32 = f32::INFINITY;
    let (mut then, mut now) = (*before, *after);
    let chain = Limit::ALL.into_iter().filter_map(|limit| {
        let both = [&mut then, &mut now].map(|limits| *limits.number(limit).0);
        let shown = both.map(|value| if limit.is_off(value) { NONE } else { value });
        (!limit.is_tight(both[1], both[0])).then_some((limit.key(), shown))
    });
    let both = [before, after];
    let late = |limits: &Limits| Some(f32::from(limits.late_ticks)).filter(|late| *late > 0.0);
    let of_run = [
        ("watchdog_ms", both.map(|limits| limits.watchdog_ms.into())),
        (
            "late_ticks",
            both.map(|limits| late(limits).unwrap_or(NONE)),
        ),
        (
            "max_age_ticks",
            both.map(|limits| limits.max_age_ticks.into()),
        ),
    ];
    let of_run = of_run
        .into_iter()
        .filter(|(_, [before, after])| after > before);
    let in_words = |key, value: f32| {
        if value.is_infinite() {
            "none".to_owned()
        } else {
            written(key, value.into())
        }
    };
    let words = chain.chain(of_run).map(|(key, both)| {
        let [before, after] = both.map(|value| in_words(key, value));
        format!("{} from {before} to {after}", label(key))
    });
    let mut words: Vec<String> = words.collect();
    let ends = both.map(|limits| [limits.workspace_low_m, limits.workspace_high_m]);
    let [[had_low, had_high], [low, high]] = ends;
    if had_low < had_high && (low >= high || low < had_low || high > had_high) {
        let [before, after] = ends.map(|[low, high]| {
            if low >= high {
                return "none".to_owned();
            }
            let [low, high] = [low, high].map(|end| digits(1e3 * f64::from(end), 4));
            format!("{low}:{high} mm")
        });
        words.push(format!("workspace from {before} to {after}"));
    }
    if before.guard.kind != GuardKind::Off && after.guard != before.guard {
        let is = match after.guard.kind {
            GuardKind::Off => "off",
            GuardKind::Observer | GuardKind::EnergyBounding => "another one",
        };
        words.push(format!("the passivity guard is {is}"));
    }
    words
}

#[cfg(test)]
mod tests;
