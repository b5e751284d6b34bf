//! The same bits over 100 000 samples, by every compiler that is here, without a warning or undefined behaviour.

use super::{CASES, build, hash, hash_of, hash_of_push, header_of, laws, said_by, written};
use fracdiff::{Differintegrator as _, OperatorList, PortableOperator, portable::Form};
use fracdiff_c::{CHeader, CNumber, WallLaw};
use std::{
    num::NonZero,
    sync::atomic::{AtomicUsize, Ordering},
    thread::available_parallelism,
};
use testkit::Folder;

/// Every warning that C programmers look at.
pub(crate) const WARNINGS: &[&str] = &[
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wshadow",
    "-Wconversion",
    "-Werror",
];

pub(crate) const COMPILERS: &Compilers = &[
    ("cc", &["-std=c99", "-O2"]),
    (
        "cc",
        &[
            "-std=c99",
            "-O1",
            "-fsanitize=undefined",
            "-fno-sanitize-recover",
        ],
    ),
    (
        "clang",
        &[
            "-std=gnu99",
            "-O3",
            "-fsanitize=undefined,address",
            "-fno-sanitize-recover",
        ],
    ),
    (
        "c++",
        &["-x", "c++", "-std=c++11", "-O3", "-ffp-contract=off"],
    ),
];

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn float_has_the_same_bits_by_every_compiler() {
    check::<f32>(COMPILERS);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn double_has_the_same_bits() {
    check::<f64>(&COMPILERS[..1]);
}

/// Compilers and their ways.
pub(crate) type Compilers = [(&'static str, &'static [&'static str])];

fn check<F: CNumber>(compilers: &Compilers) {
    for_each(CASES, |case| has_the_same_bits::<F>(*case, compilers));
}

/// Tries all cases, as many at the same time as there are processors.
pub(crate) fn for_each<T: Sync>(cases: &[T], test: impl Fn(&T) + Sync) {
    let next = AtomicUsize::new(0);
    let threads = available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    test(case);
                }
            });
        }
    });
    assert!(next.into_inner() >= cases.len());
}

fn has_the_same_bits<F: CNumber>((scheme, order): (&str, f64), compilers: &Compilers) {
    let folder = Folder::empty();
    let operator = build::<F>(scheme, order);
    let want = hash(&operator);
    let header = header_of(&operator, &folder);
    for (have, by) in said_by::<F>(compilers, "run.c", &header, &[]) {
        assert_eq!(have, want, "{scheme} {order}, {by}");
    }
}

/// A recursive filter of any origin, which does not run as Tustin and Muir's does.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_recursion_of_free_coefficients_has_the_same_bits() {
    let values: [&[f32]; 2] = [&[1.5, 0.5, -0.3], &[0.7, 0.5, -0.9, 0.25, 0.3, -0.1, 0.05]];
    for values in values {
        let operator = PortableOperator::<f32, 1, 8, 3>::new(Form::Recursion, 0, values);
        let operator = operator.expect("an operator");
        let mut history = operator.at_rest();
        let want = hash_of(|x| operator.step(&mut history, x));
        let mut list = build::<f32>("tustin-muir:1", 0.5).list().expect("a list");
        list.values = values.to_vec();
        let folder = Folder::empty();
        let header = CHeader::new("op", &list, None, &[]).expect("a header");
        let header = written(&header, &folder);
        for (have, by) in said_by::<f32>(COMPILERS, "run.c", &header, &[]) {
            assert_eq!(have, want, "{values:?}, {by}");
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_law_of_a_tissue_has_the_same_bits() {
    for law in laws() {
        pushes_with_the_same_bits::<f32>(&law);
        pushes_with_the_same_bits::<f64>(&law);
    }
}

fn pushes_with_the_same_bits<F: CNumber>(law: &WallLaw) {
    let folder = Folder::empty();
    let operator = build::<F>("full", 0.2247);
    let list = OperatorList::from(&operator);
    let header = CHeader::new("op", &list, Some(law), &[]).expect("a header");
    let header = written(&header, &folder);
    for (have, by) in said_by::<F>(COMPILERS, "run.c", &header, &["-DLAW".to_owned()]) {
        assert_eq!(have, hash_of_push(&operator, law), "{by}");
    }
}

#[test]
fn numbers_of_a_law_that_are_none_are_refused() {
    let list = build::<f32>("muir:3", 0.5).list().expect("a list");
    let [_, law] = laws();
    let refused = |law: WallLaw| {
        let header = CHeader::new("op", &list, Some(&law), &[]);
        header.expect_err("a bad number").to_string()
    };
    let message = refused(WallLaw {
        stiffness: -1.0,
        ..law
    });
    assert!(
        message.starts_with("stiffness or dissipation -1"),
        "{message}"
    );
    for (at, value, text) in [(0, 0.0, "0"), (3, -1.0, "-1"), (7, f64::NAN, "NaN")] {
        let mut map = law.depth_map.expect("a map");
        map[at] = value;
        let message = refused(WallLaw {
            depth_map: Some(map),
            ..law
        });
        assert!(
            message.starts_with(&format!("a number of {text} in a map")),
            "{message}"
        );
    }
}
