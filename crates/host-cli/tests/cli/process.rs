//! Runs the binary in a folder of its own and judges how it ended.

use haptic_run::Remembered;
use std::ffi::OsStr;
use std::fmt;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use testkit::Folder;
pub(crate) use testkit::{PATIENCE, until};

/// A fresh folder that commands run in; gone when dropped.
pub(crate) struct Place(Folder);

/// A command that has ended.
pub(crate) struct Ended {
    command: String,
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// The binary, ready for arguments.
pub(crate) fn binary() -> &'static Path {
    assert_cmd::cargo::cargo_bin!("host-cli")
}

/// A program that finds each signal as behind a terminal: under `nohup` these tests ignore hangups, and no shell can undo that.
fn with_all_signals(program: impl AsRef<OsStr>) -> Command {
    if !cfg!(target_os = "linux") {
        return Command::new(program);
    }
    // By its path: some tests empty that of their child.
    let mut command = Command::new("/usr/bin/env");
    command.arg("--default-signal").arg(program);
    command
}

/// Splits at blanks; no argument of these tests holds one.
pub(crate) fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

impl Place {
    pub(crate) fn new() -> Self {
        Self(Folder::empty())
    }

    /// One with the folder `experiments` and a record of fish muscle.
    pub(crate) fn with_examples() -> Self {
        let place = Self::new();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        std::fs::create_dir(place.path("experiments")).expect("a folder");
        for entry in std::fs::read_dir(root.join("experiments")).expect("a folder") {
            let entry = entry.expect("an entry");
            let copy = place.path("experiments").join(entry.file_name());
            std::fs::copy(entry.path(), copy).expect("copies");
        }
        let record = "fish-muscle-relaxation.tsv";
        let records = root.join("crates/haptic-tissue/records");
        std::fs::copy(records.join(record), place.path(record)).expect("copies");
        place
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Runs `host-cli LINE` here.
    pub(crate) fn run(&self, line: &str) -> Ended {
        self.run_with(line, &[])
    }

    /// What `host-cli LINE --json` tells, without a warning.
    pub(crate) fn json(&self, line: &str) -> serde_json::Value {
        self.run(&format!("{line} --json")).succeeded().json()
    }

    /// Runs `host-cli LINE` here, with `input` on standard input.
    pub(crate) fn run_with(&self, line: &str, input: &[u8]) -> Ended {
        self.run_arguments(&words(line), input)
    }

    /// Runs `host-cli ARGUMENTS` here, or that of another platform: `PLATFORM_CLI="qemu-aarch64 -L FOLDER PATH"`.
    pub(crate) fn run_arguments(&self, arguments: &[impl AsRef<OsStr>], input: &[u8]) -> Ended {
        let other = std::env::var("PLATFORM_CLI").unwrap_or_default();
        let mut other = words(&other).into_iter();
        let program = other.next().map_or(binary(), Path::new);
        let mut command = assert_cmd::Command::new(program);
        let command = command.args(other).args(arguments).current_dir(&*self.0);
        let command = command.env(Remembered::VARIABLE, self.path("state"));
        let output = command.write_stdin(input).timeout(PATIENCE).output();
        Ended::new(
            format!("{command:?}"),
            &output.expect("the binary runs and ends in time"),
        )
    }

    /// Runs a shell script here; `$0` is the binary.
    pub(crate) fn shell(&self, script: &str) -> Ended {
        let mut command = assert_cmd::Command::from_std(with_all_signals("sh"));
        let command = command.args(["-c", script]).arg(binary());
        let command = command.env(Remembered::VARIABLE, self.path("state"));
        let command = command.current_dir(&*self.0).timeout(PATIENCE);
        let output = command.output().expect("sh runs and ends in time");
        Ended::new(script.to_owned(), &output)
    }

    /// `host-cli LINE` in this folder, with nothing on standard input.
    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = with_all_signals(binary());
        command.args(words(line)).current_dir(&*self.0);
        command.env(Remembered::VARIABLE, self.path("state"));
        command.stdin(Stdio::null());
        command
    }

    /// The same in a process of its own, whose output waits to be read.
    pub(crate) fn start(&self, line: &str) -> Child {
        let mut command = self.command(line);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("the binary starts")
    }

    /// Waits until this process has made this file, not longer than it lives.
    pub(crate) fn wait_for(&self, name: &str, maker: &mut Child) {
        if !self.grows(name, 0, maker) {
            let mut message = String::new();
            if let Some(stderr) = &mut maker.stderr {
                stderr.read_to_string(&mut message).expect("is text");
            }
            panic!("nobody made {name}: {message}");
        }
    }

    /// Waits until a file has so many bytes; false if its maker has ended before. Of a log 8 kB are 100 samples.
    pub(crate) fn grows(&self, name: &str, bytes: u64, maker: &mut Child) -> bool {
        let path = self.path(name);
        let is_there = || std::fs::metadata(&path).is_ok_and(|file| file.len() >= bytes);
        until(name, || {
            let ended = maker.try_wait().expect("can be asked").is_some();
            (is_there() || ended).then(is_there)
        })
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("writes");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    /// The names of [`files`](Self::files), with blanks between them.
    pub(crate) fn listing(&self) -> String {
        self.files().join(" ")
    }

    /// All files and folders here, by path, in order.
    pub(crate) fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, prefix: &str, found: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).expect("lists") {
                let entry = entry.expect("lists");
                let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
                if entry.path().is_dir() {
                    found.push(format!("{name}/"));
                    walk(&entry.path(), &format!("{name}/"), found);
                } else {
                    found.push(name);
                }
            }
        }
        let mut found = Vec::new();
        walk(&self.0, "", &mut found);
        found.sort();
        found
    }
}

impl Ended {
    pub(crate) fn new(command: String, output: &std::process::Output) -> Self {
        Self {
            command,
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout.clone()).expect("standard output is UTF-8"),
            stderr: String::from_utf8(output.stderr.clone()).expect("standard error is UTF-8"),
        }
    }

    /// Exit code 0 and nothing on standard error, not even a warning.
    pub(crate) fn succeeded(self) -> Self {
        let fault = self.fault_in_success(true);
        self.without(fault)
    }

    /// Exit code 0; on standard error nothing but warnings.
    pub(crate) fn succeeded_with_warnings(self) -> Self {
        let fault = self.fault_in_success(false);
        self.without(fault)
    }

    /// Panics with this fault, if there is one.
    fn without(self, fault: Option<String>) -> Self {
        if let Some(fault) = fault {
            panic!("{fault}: {self}");
        }
        self
    }

    /// The same, or exit code 4 of a machine so busy that it skipped periods of the device that it serves: they are missing in the
    /// log.
    pub(crate) fn ended_by_the_clock(self) -> Self {
        if self.code == Some(4) {
            println!("this machine was busy: {}", self.error());
            return self.failed(4);
        }
        self.succeeded_with_warnings()
    }

    /// This exit code, and one line that starts with `error: ` at the end of standard error.
    pub(crate) fn failed(self, code: i32) -> Self {
        let fault = self.fault_in_failure(code);
        self.without(fault)
    }

    /// The mistake in this success, if there is one; silent ones do not warn either.
    pub(crate) fn fault_in_success(&self, is_silent: bool) -> Option<String> {
        if self.code != Some(0) {
            Some(format!("exit code is {:?}, not 0", self.code))
        } else if is_silent && !self.stderr.is_empty() {
            Some("something on standard error".to_owned())
        } else {
            let line = self.strange_line()?;
            Some(format!("\"{line}\" is neither error nor warning"))
        }
    }

    /// The mistake in this failure, if there is one: its exit code, or an error that is not exactly one
    /// line `error: …` behind warnings.
    pub(crate) fn fault_in_failure(&self, code: i32) -> Option<String> {
        let is_error = |line: &&str| line.starts_with("error: ");
        let errors = self.stderr.lines().filter(is_error).count();
        if self.code != Some(code) {
            Some(format!("exit code is {:?}, not {code}", self.code))
        } else if let Some(line) = self.strange_line() {
            Some(format!("\"{line}\" is neither error nor warning"))
        } else if errors != 1 || !self.error().starts_with("error: ") {
            Some(format!("{errors} errors, wanted one at the end"))
        } else {
            None
        }
    }

    /// Complaint if it did not end as in [`failed`](Self::failed), with all of `words` in the error and nothing on standard output;
    /// `None` if it did.
    pub(crate) fn complaint(&self, code: i32, words: &[&str]) -> Option<String> {
        let missing = || words.iter().find(|word| !self.error().contains(**word));
        if let Some(fault) = self.fault_in_failure(code) {
            Some(format!("{fault}: {self}"))
        } else if !self.stdout.is_empty() {
            Some(format!("something on standard output: {self}"))
        } else {
            missing().map(|word| format!("the error does not say \"{word}\": {self}"))
        }
    }

    /// Panics with the [`complaint`](Self::complaint), if there is one.
    pub(crate) fn refused(self, code: i32, words: &[&str]) -> Self {
        let fault = self.complaint(code, words);
        self.without(fault)
    }

    /// The last line of standard error, but for the line of a file that is shown under it.
    pub(crate) fn error(&self) -> &str {
        self.message().last().unwrap_or("")
    }

    /// Lines of standard error without the lines of a file.
    fn message(&self) -> impl Iterator<Item = &str> {
        let shown = |line: &str| {
            line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit())
                .starts_with('|')
        };
        self.stderr.lines().filter(move |line| !shown(line))
    }

    /// A line of standard error that is neither error nor warning.
    fn strange_line(&self) -> Option<&str> {
        let known = |line: &str| line.starts_with("error: ") || line.starts_with("warning: ");
        self.message().find(|line| !known(line))
    }

    /// The one JSON object on standard output.
    pub(crate) fn json(&self) -> serde_json::Value {
        assert_eq!(self.stdout.lines().count(), 1, "one line: {self}");
        assert!(self.stdout.ends_with('\n'), "{self}");
        let value: serde_json::Value = serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("not JSON, {error}: {self}"));
        assert!(value.is_object(), "{self}");
        value
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            command,
            code,
            stdout,
            stderr,
        } = self;
        // Enough to see what happened; a table may have a million lines.
        let start: String = stdout.chars().take(2000).collect();
        write!(
            f,
            "\n$ {command}\nexit code {code:?}\nstdout: {start}\nstderr: {stderr}"
        )
    }
}

/// The numbers of a column of a CSV text.
pub(crate) fn column(text: &str, name: &str) -> Vec<f64> {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let names = rows.headers().expect("a header").clone();
    let at = names.iter().position(|column| column == name);
    let at = at.unwrap_or_else(|| panic!("no column {name} in {names:?}"));
    let number = |row: csv::StringRecord| row[at].parse().expect("a number");
    rows.records()
        .map(|row| number(row.expect("a row")))
        .collect()
}

/// This is so; else what was said is shown.
#[track_caller]
pub(crate) fn holds(is_so: bool, message: &impl fmt::Display) {
    assert!(is_so, "{message}");
}

/// A number in a JSON object.
pub(crate) fn number(object: &serde_json::Value, key: &str) -> f64 {
    object[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} is a number: {object}"))
}

/// Sends a process a signal by its name; the shell has `kill` built in.
pub(crate) fn signal(child: &Child, name: &str) {
    let script = format!("kill -{name} {}", child.id());
    let sent = Command::new("sh").args(["-c", &script]).status();
    assert!(sent.expect("sh runs").success());
}

/// The value of the first row of a report with this label; empty if there is none.
pub(crate) fn row<'a>(text: &'a str, label: &str) -> &'a str {
    let rows = text.lines().map(str::trim_start);
    let values = rows.filter_map(|row| row.strip_prefix(label)?.strip_prefix("  "));
    values.map(str::trim).next().unwrap_or_default()
}

/// The keys of a JSON object, sorted.
pub(crate) fn keys(object: &serde_json::Value) -> String {
    let object = object.as_object().expect("an object");
    let mut keys: Vec<&str> = object.keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys.join(" ")
}

/// A run of 3001 samples: ramp until 0.5 s, hold until 3 s.
pub(crate) const SHORT: &str = "relax --duration 3s --ramp-time 0.5s --out run";
