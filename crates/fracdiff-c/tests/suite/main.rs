//! Headers in C against operators in Rust.

mod bits;
mod controller;
mod source;
mod target;

use fracdiff::{Differintegrator as _, Operator, OperatorList, Order, Real, Scheme, Seconds};
use fracdiff_c::{CHeader, CNumber, WallLaw};
use haptic_loop::DepthMap;
use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// Samples of a run, as in `run.c`.
const SAMPLES: u32 = 100_000;

/// One operator of each form, of each integer part, with and without compensated modes.
const CASES: &[(&str, f64)] = &[
    ("grunwald:1", 0.5),
    ("grunwald:7", 0.5),
    ("grunwald:100", -0.4),
    ("muir:5", 0.3),
    ("tustin-muir:1", 0.5),
    ("tustin-muir:2", 0.5),
    ("tustin-muir:4", 1.3),
    ("tustin-muir:5", -0.7),
    ("oustaloup:4:0.1:100", 0.6),
    ("oustaloup:3:0.1:100", -1.6),
    ("full", 0.05),
    ("full", 0.5),
    ("full", 1.0),
    ("full", 1.7),
    ("full", 2.0),
    ("full", 0.0),
    ("full", -0.5),
    ("full", -1.0),
    ("full", -1.5),
    ("full:1e-3", 0.2247),
    ("piecewise-linear", 0.5),
    ("full-bdf2", 0.5),
    ("full-bdf2", 1.7),
    ("full-bdf2", -1.5),
];

/// An operator at 1 kHz, for an hour.
fn build<F: CNumber>(scheme: &str, order: f64) -> Operator<F> {
    let scheme: Scheme = scheme.parse().expect("a scheme");
    let order = Order::new(order).expect("an order");
    scheme
        .build(order, Seconds(1e-3), 3.6e6)
        .expect("an operator")
}

/// Its header in a folder.
fn header_of<F: CNumber>(operator: &Operator<F>, folder: &Path) -> PathBuf {
    // Notes that would spoil the header, were they not only notes.
    let notes = ["D^0.5 */ #error @ ZERO real ".to_owned()];
    let list = OperatorList::from(operator);
    written(
        &CHeader::new("op", &list, None, &notes).expect("a header"),
        folder,
    )
}

fn written(header: &CHeader, folder: &Path) -> PathBuf {
    let path = folder.join("op.h");
    std::fs::write(&path, header.to_string()).expect("writes");
    path
}

/// What a program in C says, by each of these compilers that is here, and by which.
fn said_by<F: CNumber>(
    compilers: &bits::Compilers,
    program: &str,
    header: &Path,
    defined: &[String],
) -> Vec<(String, String)> {
    let here = compilers.iter().filter(|(compiler, _)| is_here(compiler));
    let message = here.map(|(compiler, flags)| {
        let built = header.with_extension("run");
        let mut compile = Command::new(compiler);
        compile.args(*flags).args(bits::WARNINGS).args(defined);
        compile.arg(format!("-DREAL={}", F::TYPE));
        compile.arg("-include").arg(header);
        compile.args([source(program), source("host.c")]);
        output(compile.arg("-o").arg(&built));
        (
            output(&mut Command::new(&built)),
            format!("{compiler} {flags:?}"),
        )
    });
    message.collect()
}

/// A file of `tests/c`.
fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/c")
        .join(name)
}

/// True if a program is here. Where `REQUIRE_COMPILERS` is set, all have to be.
fn is_here(program: &str) -> bool {
    let here = Command::new(program).arg("--version").output().is_ok();
    assert!(
        here || std::env::var_os("REQUIRE_COMPILERS").is_none(),
        "{program} is not installed"
    );
    if !here {
        println!("skipped: {program} is not installed");
    }
    here
}

/// What a program says, by either channel; it must succeed.
fn output(command: &mut Command) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("starts");
    let message = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{command:?}: {message}");
    let printed = String::from_utf8_lossy(&stdout);
    format!("{printed}{message}").trim().to_owned()
}

/// FNV-1a of the bits of all outputs, for the input of `run.c`.
fn hash<F: CNumber>(operator: &Operator<F>) -> String {
    let mut history = operator.at_rest();
    hash_of(|x| operator.step(&mut history, x))
}

/// A law as of tissue, and the same pressed by a sphere on a base, stiffening, to x = 6 or so.
fn laws() -> [WallLaw; 2] {
    let law = WallLaw {
        stiffness: 120.0,
        dissipation: 17.3,
        depth_map: None,
    };
    let pressed = WallLaw {
        depth_map: Some([0.4, 0.1, 1.0, 1.133, 1.283, 0.769, 0.0975, 0.7]),
        ..law
    };
    [law, pressed]
}

/// The same of the force of a law behind a surface.
fn hash_of_push<F: CNumber>(operator: &Operator<F>, law: &WallLaw) -> String {
    let mut history = operator.at_rest();
    let map = law.depth_map.map(|map| DepthMap::new(map).expect("a map"));
    let (k, b) = (F::from_f64(law.stiffness), F::from_f64(law.dissipation));
    hash_of(|x| {
        let depth = if x < F::ZERO { F::ZERO } else { x };
        let depth = map.map_or(depth, |map| map.at(depth));
        let force = -(k * depth + b * operator.output(&history, depth));
        operator.advance(&mut history, depth);
        if depth <= F::ZERO || force > F::ZERO {
            F::ZERO
        } else {
            force
        }
    })
}

fn hash_of<F: CNumber>(mut tick: impl FnMut(F) -> F) -> String {
    let (mut state, mut x) = (1_u32, F::ZERO);
    fnv((0..SAMPLES).map(|n| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if (n / 4000).is_multiple_of(2) {
            x += F::from_f64((f64::from(state >> 16) - 32768.0) / 1_048_576.0);
        }
        tick(x)
    }))
}

/// FNV-1a of the bits of numbers.
fn fnv<F: Real>(numbers: impl Iterator<Item = F>) -> String {
    let mut hash = 14_695_981_039_346_656_037_u64;
    for number in numbers {
        let number = number.to_f64();
        let bytes = if F::COMPENSATED {
            (number as f32).to_le_bytes().to_vec()
        } else {
            number.to_le_bytes().to_vec()
        };
        for byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(1_099_511_628_211);
        }
    }
    format!("{hash:016x}")
}
