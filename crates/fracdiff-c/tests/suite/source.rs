//! The header as a text: what compiles it, how it is laid out, and lists that give none.

use super::{CASES, build, controller, header_of, is_here, laws};
use fracdiff::{OperatorList, Seconds};
use fracdiff_c::{CHeader, CNumber, HeaderError};
use fractional_control::{ControllerList, ControllerSetup, PidParameters};
use std::{
    path::{Path, PathBuf},
    process::Command,
};
use testkit::{Folder, assert_says};

#[test]
fn no_compiler_takes_it_with_fast_math() {
    let folder = Folder::empty();
    let header = header_of(&build::<f32>("full", 0.5), &folder);
    for language in ["c", "c++"] {
        for compiler in ["cc", "clang"].into_iter().filter(|one| is_here(one)) {
            let compile = |flags: &[&str]| {
                let mut compile = Command::new(compiler);
                compile.args(["-x", language, "-fsyntax-only"]).args(flags);
                let output = compile.arg(&header).output().expect("starts");
                let message = String::from_utf8_lossy(&output.stderr).into_owned();
                (output.status.success(), message)
            };
            let (taken, message) = compile(&["-O3"]);
            assert!(taken, "{compiler} {language}: {message}");
            // Wider numbers round elsewhere: other bits.
            let (taken, message) = compile(&["-mfpmath=387"]);
            let why = "op computes as written: compile without the x87's wider numbers";
            let is_x86 = cfg!(target_arch = "x86_64") && compiler == "cc";
            assert!(
                !is_x86 || (!taken && message.contains(why)),
                "{language}: {message}"
            );
            for flag in ["-ffast-math", "-Ofast"] {
                let (taken, message) = compile(&[flag]);
                assert!(!taken, "{compiler} {language} {flag}");
                let why = "op computes as written: compile without -ffast-math and -Ofast";
                assert!(
                    message.contains(why),
                    "{compiler} {language} {flag}: {message}"
                );
            }
        }
    }
}

#[test]
fn clang_format_leaves_it_as_it_is() {
    if !is_here("clang-format") {
        return;
    }
    let folder = Folder::empty();
    let style = Path::new(env!("CARGO_MANIFEST_DIR")).join(".clang-format");
    std::fs::copy(style, folder.join(".clang-format")).expect("copies");
    let mut files = headers::<f32>(&folder);
    files.extend(headers::<f64>(&folder));
    let mut format = Command::new("clang-format");
    format.args(["--dry-run", "-Werror", "--style=file"]);
    let output = format.args(&files).output().expect("starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
}

/// All operators, as they are and with a law.
fn headers<F: CNumber>(folder: &Path) -> Vec<PathBuf> {
    let [law, pressed] = laws();
    let notes = ["a line of a note that is longer than a line of code ought to be, as notes of a tissue are, and no less".to_owned()];
    let mut files = Vec::new();
    for (index, &(scheme, order)) in CASES.iter().enumerate() {
        let list = OperatorList::from(&build::<F>(scheme, order));
        let plain = CHeader::new("op", &list, None, &notes).expect("a header");
        let with_law = CHeader::new("op", &list, Some(&law), &notes).expect("a header");
        let with_map = CHeader::new("op", &list, Some(&pressed), &notes).expect("a header");
        for (kind, header) in [("plain", plain), ("law", with_law), ("map", with_map)] {
            let file = folder.join(format!("{}-{index}-{kind}.h", F::TYPE));
            std::fs::write(&file, header.to_string()).expect("writes");
            files.push(file);
        }
    }
    for (index, case) in controller::cases().iter().enumerate() {
        let place = folder.join(format!("{}-controller-{index}", F::TYPE));
        std::fs::create_dir(&place).expect("a folder");
        files.push(controller::header_of::<F>(&case.setup, &place));
    }
    files
}

#[test]
fn a_list_that_is_none_is_refused() {
    let good = build::<f32>("full", 0.5).list().expect("a list");
    assert!(CHeader::new("half", &good, None, &[]).is_ok());
    let mut short = good.clone();
    short.values.pop();
    let mut integer = good.clone();
    integer.integer = 3;
    for wrong in [short, integer] {
        let error = CHeader::new("half", &wrong, None, &[]).expect_err("no operator");
        assert!(matches!(error, HeaderError::List { .. }), "{error}");
    }
    let mut infinite = good;
    infinite.values[3] = f32::INFINITY;
    let error = CHeader::new("half", &infinite, None, &[]).expect_err("no number");
    assert_eq!(
        error.to_string(),
        "coefficient 3 is inf, which is not finite"
    );
    let mut taps = build::<f32>("muir:3", 0.5).list().expect("a list");
    taps.integer = 1;
    assert!(CHeader::new("half", &taps, None, &[]).is_err());
}

#[test]
fn a_controller_is_written_in_numbers_that_every_compiler_takes() {
    let law: PidParameters = "2+1/s^0.9".parse().expect("a controller");
    let setup = ControllerSetup::new(law, Seconds(1e-3));
    let list = ControllerList::<f32>::new(&setup).expect("a list");
    let header = CHeader::of_controller("oven", &list, &[]).expect("a header");
    let header = header.to_string();
    assert_says(&header, "self->high = 3.4028235e38f;");
    assert!(
        !header.contains("/ 0e0") && !header.contains("inf"),
        "{header}"
    );
}
