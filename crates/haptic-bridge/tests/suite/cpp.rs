//! The example in C++: it compiles without a warning, and is a device for our host.

use crate::host::Host;
use haptic_loop::Fault;
use std::{
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};
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
    fn start(program: &Path, libraries: &Path, what: &Path) -> Self {
        let mut command = Command::new(program);
        command.env("LD_LIBRARY_PATH", libraries);
        command.arg("127.0.0.1:0").arg(what);
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

    fn tell(&mut self, line: &str) {
        let input = self.child.stdin.as_mut().expect("piped");
        writeln!(input, "{line}").expect("listens");
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

/// An example as a program, and where its library is.
fn compiled(folder: &Path, example: &str) -> (PathBuf, PathBuf) {
    let (program, libraries) = (folder.join(example), libraries());
    let mut compile = strict("c++", "-std=c++17");
    let flags = std::env::var("EXAMPLE_FLAGS").unwrap_or_default();
    compile.args(flags.split_whitespace());
    compile.arg("-pthread");
    compile.arg(here("examples").join(example).with_extension("cpp"));
    compile.arg("-L").arg(&libraries);
    compile.arg("-lhaptic_bridge").arg("-o").arg(&program);
    run(&mut compile);
    (program, libraries)
}

#[test]
fn the_example_in_cpp_compiles_without_a_warning_and_is_a_device() {
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let (program, libraries) = compiled(&folder, "simulated_device");
    // The header is C too.
    let source = folder.join("header.c");
    std::fs::write(&source, "#include <haptic_bridge.h>\nhb_device device;\n").expect("writes");
    let mut compile = strict("cc", "-std=c99");
    compile.arg("-c").arg("-o").arg(folder.join("header.o"));
    run(compile.arg(&source));

    let example = Example::start(&program, &libraries, Path::new("3"));
    let mut host = Host::connect(example.port);
    // Its hand holds it 2 mm beside a spring of 100 N/m, or presses.
    let largest_n = host.presses(1000);
    assert!(largest_n > 0.1, "{largest_n} N");
    assert_eq!(host.fault, None);
    drop(host);
    // The next host finds it as it was.
    let mut host = Host::connect(example.port);
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
fn the_robot_in_cpp_renders_a_wall_exactly_at_the_virtual_port_and_comes_to_rest_in_every_trouble()
{
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let (program, libraries) = compiled(&folder, "simulated_robot");
    let robot = here("examples/robot.toml");
    for (trouble, fault) in [
        ("", None),
        ("nan", Some(Fault::ForceSensor)),
        ("silence", Some(Fault::ForceSensor)),
    ] {
        let mut example = Example::start(&program, &libraries, &robot);
        let mut host = Host::connect(example.port);
        // Nobody pushes while its sensor rests.
        host.starts_the_robot();
        example.tell("3");
        // 3 N at 1000 N/m, behind a surface at 1 cm.
        let port = host.until(if trouble.is_empty() { 5000 } else { 500 });
        if trouble.is_empty() {
            let (depth_m, force_n) = (port.position_m - 0.01, port.force_n);
            assert!((depth_m / 3e-3 - 1.0).abs() < 0.01, "{depth_m} m");
            assert!((force_n / -3.0 - 1.0).abs() < 0.01, "{force_n} N");
        } else {
            // Away from the wall, and in motion when its sensor fails.
            example.tell("-10");
            host.until(100);
            example.tell(trouble);
            host.until_a_fault();
            let held = host.until(200);
            assert!(held.position_m < 0.01, "it moved");
            // The command stands; the robot itself has a last micrometre to go.
            let later = host.until(50);
            assert!(
                (later.position_m - held.position_m).abs() < 1e-6,
                "it holds"
            );
        }
        assert_eq!(host.fault, fault);
        drop(host);
        let message = example.end();
        let braked = message.split_whitespace().nth(2).expect("a number");
        let braked: u32 = braked.parse().expect("a number");
        // 0.5 m/s at 20 m/s².
        assert!(braked <= 25 && (braked > 0) == fault.is_some(), "{message}");
    }
}

#[test]
fn a_host_that_does_not_know_the_robot_does_not_arm_it() {
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let (program, libraries) = compiled(&folder, "simulated_robot");
    let example = Example::start(&program, &libraries, &here("examples/robot.toml"));
    let reason = Host::connect(example.port).armed().to_string();
    for word in [
        "device_model=robot.toml",
        "[admittance]",
        "bandwidth_hz",
        "dead_time_s",
    ] {
        assert!(reason.contains(word), "{reason}");
    }
    assert!(example.end().starts_with("at rest 0 ms"));
}

#[test]
fn the_lines_for_ros2_control_compile_with_get_value_and_without_and_write_three_axes() {
    if !is_here("c++") {
        return;
    }
    let folder = Folder::empty();
    let guide = std::fs::read_to_string(here("../../docs/guide/src/bridge.md")).expect("a page");
    let block = |heading: &str, before: &str| {
        let (_, lines) = guide.split_once(heading).expect("a section");
        let (_, lines) = lines.split_once(before).expect("a place");
        let (_, lines) = lines.split_once("```cpp\n").expect("a block");
        lines.split("```").next().expect("lines").to_owned()
    };
    let pushes = block("\n## ROS 2\n", "");
    let (value, _) = pushes.split_once("\n\n").expect("a helper");
    let moves = block("\n## A robot that takes a velocity\n", "ros2_control");
    std::fs::write(folder.join("motion.hpp"), format!("{value}\n{moves}")).expect("writes");
    std::fs::write(folder.join("lines.hpp"), &pushes).expect("writes");
    for version in ["-DGET_VALUE", "-DGET_OPTIONAL"] {
        for kind in ["-DFORCE", "-DMOTION"] {
            let program = folder.join(format!("{version}{kind}"));
            let mut compile = strict("c++", "-std=c++17");
            compile.args([version, kind]).arg("-I").arg(&*folder);
            compile.arg(here("tests/ros2_control.cpp"));
            run(compile.arg("-o").arg(&program));
            run(&mut Command::new(&program));
        }
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
    Example::start(
        &build.join("simulated_device"),
        &prefix.join("lib"),
        Path::new("3"),
    )
    .end();
    let robot = here("examples/robot.toml");
    Example::start(&build.join("simulated_robot"), &prefix.join("lib"), &robot).end();
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
        Example::start(&program, &prefix.join("lib"), Path::new("3")).end();
    }
}
