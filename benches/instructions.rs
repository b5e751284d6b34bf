//! Instructions per tick, counted by valgrind and compared with `benches/instructions.toml`.
//!
//! ```text
//! cargo benches --bench instructions                       compare, one minute
//! cargo benches --bench instructions -- --write REASON     accept what has changed, and say why
//! ```
//! - *Why this way*: counts do not depend on the load of the machine. This program runs itself under
//!   cachegrind, once for TICKS and once for twice as many; the difference is the ticks alone, to the instruction.
//!   That needs valgrind, which Debian has, and no runner to be compiled for three minutes in CI.
//! - *Counts depend* on compiler and target features, and the table names both. Elsewhere this prints
//!   `skipped: …`; with `REQUIRE_ALL_CHECKS` in the environment it fails instead.
//! - *A change over 3 %*, up or down, fails until it is declared: `--write` puts the new count, the old one
//!   and the reason into the table.
//! - *Idle loops*: a tick of a full memory whose input is exactly constant takes at most [`IDLE`] instructions more than
//!   one whose input moves: it looks at one state, however many there are. A share would grow as the rest gets faster.
//!   That none of its numbers becomes subnormal, and slow, is tested in `fracdiff`.

mod catalogue;
mod input;

use catalogue::Visitor;
use fractional_haptics::fracdiff::{Differintegrator, Real};
use input::ramp_and_hold;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Ticks of the shorter run: whole periods of the longest block of the catalogue, 2048.
const TICKS: usize = 4096;
/// Changes below this need no reason.
const TOLERANCE: f64 = 0.03;
/// Axes of the third count.
const AXES: usize = 3;
const PHASES: [&str; 3] = ["output", "tick", "tick of 3 axes"];
/// Not in the table: an input that moves in each tick, and one that never does.
const MOTIONS: [&str; 2] = ["busy tick", "idle tick"];
/// Most instructions of an idle tick beyond those of a busy one: it looks at one state, whether that has decayed.
/// The compiler of the table makes 18.8 to 19.2 of it in `f32`, 20.6 to 20.9 in `f64`.
const IDLE: f64 = 21.0;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// One line of the table.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    /// Instructions per tick, to a tenth.
    instructions: f64,
    /// The count before the last declared change, and why it changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    before: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

#[derive(Debug, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    rustc: String,
    target: String,
    tick: BTreeMap<String, Row>,
}

fn main() -> Outcome<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--child", name, phase, ticks] => child(name, phase, ticks.parse()?),
        [.., "--write", reason] | ["--write", reason, ..] => parent(Some(reason)),
        _ => parent(None),
    }
}

fn parent(reason: Option<&str>) -> Outcome<ExitCode> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("instructions.toml");
    let table: Option<Table> = match std::fs::read_to_string(&path) {
        Ok(text) => Some(toml::from_str(&text)?),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
        Err(error) => return Err(error.into()),
    };
    let here = (rustc()?, target());
    if let (Some(table), None) = (&table, reason) {
        let listed = (table.rustc.clone(), table.target.clone());
        if here != listed {
            return skip(&format!("the table is for {listed:?}, this is {here:?}"));
        }
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        return skip("valgrind is not installed (Debian: apt-get install valgrind)");
    }
    let mut rows = table.map(|table| table.tick).unwrap_or_default();
    let mut names = Names::default();
    catalogue::visit_all(&mut names)?;
    let (seen, mut complaints) = counted(&names, &mut rows, reason)?;
    if reason.is_some() {
        rows.retain(|key, _| seen.contains(key));
        return write(&path, here, rows);
    }
    for key in rows.keys().filter(|key| !seen.contains(key)) {
        complaints.push(format!("{key}: in the table, but no such operator"));
    }
    judge(&complaints)
}

/// Counts each phase of each operator: the keys that were counted, and what is not as in the table. With a reason the rows take what is new.
fn counted(
    names: &Names,
    rows: &mut BTreeMap<String, Row>,
    reason: Option<&str>,
) -> Outcome<(Vec<String>, Vec<String>)> {
    let mut complaints = Vec::new();
    let mut seen = Vec::new();
    for name in &names.0 {
        for phase in PHASES {
            let key = format!("{name}, {phase}");
            let count = count(name, phase)?;
            let old = rows.get(&key).map(|row| row.instructions);
            println!("{key:<48} {count:>9.1} {}", change(old, count));
            let same = old.is_some_and(|old| (count / old - 1.0).abs() <= TOLERANCE);
            if !same && reason.is_some() {
                let reason = old.and(reason.map(str::to_owned));
                let row = Row {
                    instructions: count,
                    before: old,
                    reason,
                };
                rows.insert(key.clone(), row);
            } else if !same {
                complaints.push(match old {
                    Some(old) => format!("{key}: {old} in the table, {count} now"),
                    None => format!("{key}: not in the table, {count} now"),
                });
            }
            seen.push(key);
        }
        if name.starts_with("FullMemory") {
            complaints.extend(idle(name)?);
        }
    }
    Ok((seen, complaints))
}

/// Writes the table.
fn write(
    path: &Path,
    (rustc, target): (String, String),
    tick: BTreeMap<String, Row>,
) -> Outcome<ExitCode> {
    let table = Table {
        rustc,
        target,
        tick,
    };
    std::fs::write(path, format!("{HEADER}{}", toml::to_string(&table)?))?;
    println!("written: {}", path.display());
    Ok(ExitCode::SUCCESS)
}

/// Says what has changed; a failure unless nothing has.
fn judge(complaints: &[String]) -> Outcome<ExitCode> {
    if complaints.is_empty() {
        println!("all within {} % of the table", 100.0 * TOLERANCE);
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!(
        "instructions changed by more than {} %:\n",
        100.0 * TOLERANCE
    );
    for complaint in complaints {
        writeln!(text, "  {complaint}")?;
    }
    eprintln!("{text}declare it: cargo benches --bench instructions -- --write 'why'");
    Ok(ExitCode::FAILURE)
}

const HEADER: &str = "# Instructions per tick, written by `cargo benches --bench instructions -- --write REASON`.\n\
    # A change over 3 % fails until it is declared that way: `before` is the old count, `reason` says why.\n\n";

/// Prints why nothing was compared; a failure where all checks are required.
fn skip(why: &str) -> Outcome<ExitCode> {
    println!("skipped: {why}");
    Ok(if std::env::var_os("REQUIRE_ALL_CHECKS").is_some() {
        eprintln!("REQUIRE_ALL_CHECKS is set, so a skipped check is a failure");
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// A complaint, if an idle tick takes more than a busy one and what is allowed.
fn idle(name: &str) -> Outcome<Option<String>> {
    let [busy, idle] = [count(name, MOTIONS[0])?, count(name, MOTIONS[1])?];
    println!(
        "{name:<36} idle − busy {:>9.1} (at most {IDLE})",
        idle - busy
    );
    let over = idle > busy + IDLE;
    Ok(over.then(|| format!("{name}: {idle} idle, {busy} busy")))
}

fn change(old: Option<f64>, new: f64) -> String {
    match old {
        Some(old) => format!("{:+.1} %", 100.0 * (new / old - 1.0)),
        None => "new".to_owned(),
    }
}

/// "1.95.0".
fn rustc() -> Outcome<String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("--version").output()?;
    let text = String::from_utf8(output.stdout)?;
    let version = text.split_whitespace().nth(1);
    Ok(version.ok_or("rustc tells no version")?.to_owned())
}

/// Architecture, and the widest vectors it was compiled for.
fn target() -> String {
    let vectors = if cfg!(target_feature = "avx512f") {
        "avx512f"
    } else if cfg!(target_feature = "avx2") {
        "avx2"
    } else if cfg!(target_feature = "avx") {
        "avx"
    } else {
        "baseline"
    };
    format!("{} {vectors}", std::env::consts::ARCH)
}

/// Instructions per tick, by the difference of two runs.
fn count(name: &str, phase: &str) -> Outcome<f64> {
    let run = |ticks: usize| -> Outcome<f64> {
        let output = Command::new("valgrind")
            .args(["--tool=cachegrind", "--cache-sim=no"])
            .arg("--cachegrind-out-file=/dev/null")
            .arg(std::env::current_exe()?)
            .args(["--child", name, phase, &ticks.to_string()])
            .output()?;
        let text = String::from_utf8_lossy(&output.stderr);
        // ==1234== I   refs:      1,234,567  (newer: "I refs:")
        let line = text.lines().find(|line| line.contains("refs:"));
        let digits = line.and_then(|line| line.rsplit(':').next());
        match digits.map(|text| text.replace(',', "").trim().parse()) {
            Some(Ok(count)) if output.status.success() => Ok(count),
            _ => Err(format!("valgrind failed for {name}, {phase}:\n{text}").into()),
        }
    };
    let count = (run(2 * TICKS)? - run(TICKS)?) / TICKS as f64;
    Ok((10.0 * count).round() / 10.0)
}

/// Makes no operator, only notes their names.
#[derive(Default)]
struct Names(Vec<String>);

impl Visitor for Names {
    fn visit<F: Real, O: Differintegrator<F>>(&mut self, _: &str, _: &O) -> Outcome<()> {
        Ok(())
    }

    fn wants(&mut self, name: &str) -> bool {
        self.0.push(name.to_owned());
        false
    }
}

/// What runs under valgrind: one operator, one phase.
fn child(name: &str, phase: &str, ticks: usize) -> Outcome<ExitCode> {
    catalogue::visit_all(&mut Child { name, phase, ticks })?;
    Ok(ExitCode::SUCCESS)
}

struct Child<'a> {
    name: &'a str,
    phase: &'a str,
    ticks: usize,
}

impl Visitor for Child<'_> {
    fn visit<F: Real, O: Differintegrator<F>>(&mut self, _: &str, operator: &O) -> Outcome<()> {
        let input = ramp_and_hold::<F>();
        let samples = input.iter().cycle().take(self.ticks);
        let mut histories: [O::History; AXES] = std::array::from_fn(|_| operator.at_rest());
        match PHASES
            .iter()
            .chain(&MOTIONS)
            .position(|phase| *phase == self.phase)
        {
            Some(0) => {
                for &x in samples {
                    black_box(black_box(operator).output(black_box(&histories[0]), x));
                }
            }
            Some(1) => {
                for &x in samples {
                    black_box(black_box(operator).step(black_box(&mut histories[0]), x));
                }
            }
            Some(2) => {
                for &x in samples {
                    let operator = black_box(operator);
                    for history in &histories {
                        black_box(operator.output(black_box(history), x));
                    }
                    operator.advance_many(black_box(&mut histories).each_mut(), [x; AXES]);
                }
            }
            Some(phase) => {
                // To and fro by a micrometre, or not at all.
                let x = [1e-3, if phase == 3 { 1.001e-3 } else { 1e-3 }].map(F::from_f64);
                for n in 0..self.ticks {
                    let x = x[n % 2];
                    black_box(black_box(operator).step(black_box(&mut histories[0]), x));
                }
            }
            None => return Err(format!("no phase {:?}", self.phase).into()),
        }
        Ok(())
    }

    fn wants(&mut self, name: &str) -> bool {
        name == self.name
    }
}
