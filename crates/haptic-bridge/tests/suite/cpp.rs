//! The example in C++: it compiles without a warning, and is a device for our host.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use testkit::Folder;

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Runs a command to its good end.
fn run(command: &mut Command) {
    let output = command.output().expect("starts");
    let message = String::from_utf8_lossy(&output.stderr);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{command:?}: {printed}{message}");
}

/// The library as cargo has built it for this test, or as `.ci/nightly` has with a sanitizer.
fn libraries() -> PathBuf {
    match std::env::var_os("EXAMPLE_LIBRARIES") {
        Some(folder) => folder.into(),
        None => {
            let test = std::env::current_exe().expect("a path");
            test.parent().expect("a folder").to_owned()
        }
    }
}

/// True if a program is here; a test without it is skipped. Where libraries are found in another way it is too.
fn is_here(program: &str) -> bool {
    let found =
        cfg!(target_os = "linux") && Command::new(program).arg("--version").output().is_ok();
    if !found {
        testkit::skip(&format!("{program} is not installed"));
    }
    found
}

/// A compiler to which each warning is an error, with our header.
fn strict(compiler: &str, standard: &str) -> Command {
    let mut compile = Command::new(compiler);
    compile.args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]);
    compile.arg(here("include"));
    compile
}

/// A running example, which ends with its input.
struct Example {
    child: Child,
    port: u16,
    output: BufReader<std::process::ChildStdout>,
}

impl Example {
    fn start(program: &Path, libraries: &Path) -> Self {
        let mut command = Command::new(program);
        command.env("LD_LIBRARY_PATH", libraries);
        command.args(["127.0.0.1:0", "3"]);
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = piped.spawn().expect("starts");
        let mut output = BufReader::new(child.stdout.take().expect("piped"));
        let mut line = String::new();
        output.read_line(&mut line).expect("says its port");
        let port = line.trim().rsplit(' ').next().expect("a number");
        Self {
            port: port.parse().unwrap_or_else(|_| panic!("{line}")),
            child,
            output,
        }
    }

    /// What it printed last.
    fn end(mut self) -> String {
        drop(self.child.stdin.take());
        let mut line = String::new();
        self.output.read_line(&mut line).expect("says its force");
        assert!(self.child.wait().expect("ends").success());
        line
    }
}

#[test]
fn the_example_in_cpp_compiles_without_a_warning_and_is_a_device() {
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let program = folder.join("simulated_device");
    let libraries = libraries();
    let mut compile = strict("c++", "-std=c++17");
    let flags = std::env::var("EXAMPLE_FLAGS").unwrap_or_default();
    compile.args(flags.split_whitespace());
    compile.arg("-pthread");
    compile.arg(here("examples/simulated_device.cpp"));
    compile.arg("-L").arg(&libraries);
    compile.arg("-lhaptic_bridge").arg("-o").arg(&program);
    run(&mut compile);
    // The header is C too.
    let source = folder.join("header.c");
    std::fs::write(&source, "#include <haptic_bridge.h>\nhb_device device;\n").expect("writes");
    let mut compile = strict("cc", "-std=c99");
    compile.arg("-c").arg("-o").arg(folder.join("header.o"));
    run(compile.arg(&source));

    let example = Example::start(&program, &libraries);
    let mut host = crate::host::Host::connect(example.port);
    // Its hand holds it 2 mm beside a spring of 100 N/m, or presses.
    let largest_n = host.presses(1000);
    assert!(largest_n > 0.1, "{largest_n} N");
    assert_eq!(host.fault, None);
    drop(host);
    // The next host finds it as it was.
    let mut host = crate::host::Host::connect(example.port);
    assert!(host.presses(1000) > 0.1);
    // It calls hb_stop at its end, which is no end of a run like any other.
    let message = example.end();
    assert!(message.starts_with("largest force "), "{message}");
    assert_eq!(
        host.over().to_string(),
        "stopped by the program of the device"
    );
}

#[test]
fn the_lines_for_ros2_control_compile_with_get_value_and_without_and_write_three_axes() {
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let guide = std::fs::read_to_string(here("../../docs/guide/src/bridge.md")).expect("a page");
    let (_, lines) = guide.split_once("## ROS 2").expect("a section");
    let (_, lines) = lines.split_once("```cpp\n").expect("a block");
    let lines = lines.split("```").next().expect("lines");
    std::fs::write(folder.join("lines.hpp"), lines).expect("writes");
    for version in ["-DGET_VALUE", "-DGET_OPTIONAL"] {
        let program = folder.join(version);
        let mut compile = strict("c++", "-std=c++17");
        compile.arg(version).arg("-I").arg(&*folder);
        compile.arg(here("tests/ros2_control.cpp"));
        run(compile.arg("-o").arg(&program));
        run(&mut Command::new(&program));
    }
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_it_is_installed_and_found_by_cmake_and_pkg_config() {
    let folder = Folder::empty();
    let prefix = folder.join("prefix");
    run(Command::new(here("packaging/install"))
        .arg(&prefix)
        .env("PROFILE", "dev"));
    let build = folder.join("build");
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(here("examples"))
        .arg("-B")
        .arg(&build);
    configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    run(&mut configure);
    run(Command::new("cmake").arg("--build").arg(&build));
    Example::start(&build.join("simulated_device"), &prefix.join("lib")).end();
    for flags in [
        &["--cflags", "--libs"][..],
        &["--cflags", "--libs", "--static"],
    ] {
        let mut ask = Command::new("pkg-config");
        ask.args(flags).arg("haptic-bridge");
        ask.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
        let answer = ask.output().expect("starts");
        let message = String::from_utf8(answer.stdout).expect("a text");
        let program = folder.join("by_pkg_config");
        let mut compile = Command::new("c++");
        compile
            .args(["-std=c++17", "-pthread"])
            .arg(here("examples/simulated_device.cpp"));
        run(compile
            .args(message.split_whitespace())
            .arg("-o")
            .arg(&program));
        Example::start(&program, &prefix.join("lib")).end();
    }
}
