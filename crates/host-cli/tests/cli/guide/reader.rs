//! A chapter as its reader follows it, in an empty folder: files are written, commands run, what they print is compared.
//!
//! | fence | done with it |
//! |---|---|
//! | `sh` | each line runs and ends with exit code 0 |
//! | `sh exit N` | each line runs and ends with that exit code |
//! | `sh in another terminal` | each line runs beside what follows, and is ended by Ctrl-C after the last block |
//! | `sh not run: WHY` | arguments of `host-cli` are parsed; nothing runs |
//! | `toml NAME`, `python NAME`, … | is written to the file of that name |
//! | `text output` | is what the last command printed; a line `…` stands for any number of lines |
//!
//! On a page with output each code span that begins with a digit must stand in one of its blocks too, so no number is
//! typed by hand.

use crate::process::{Ended, PATIENCE, Place, binary, until};
use haptic_run::Remembered;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use testkit::{
    book::{self, Block, Markdown},
    skip,
};

/// Variable with which output on the pages is replaced by what the commands print.
const UPDATE: &str = "UPDATE_GUIDE";
/// Variable with the shell that reads the commands, if not `sh`.
const SHELL: &str = "GUIDE_SHELL";
/// A line that stands for any number of lines.
const LEFT_OUT: &str = "…";

/// A command in another terminal.
struct Behind {
    command: String,
    child: Child,
    stdout: PathBuf,
    stderr: PathBuf,
}

impl Behind {
    /// The address at which it listens.
    fn address(&self) -> Option<String> {
        let message = std::fs::read_to_string(&self.stdout).ok()?;
        let mut words = message.split_whitespace();
        let address = words.find_map(|word| word.strip_prefix("tcp:"));
        address.map(str::to_owned)
    }
}

/// The address of a device in the guide.
const ADDRESS: &str = "127.0.0.1:4250";

struct Reader<'a> {
    place: &'a Place,
    file: &'a str,
    /// What the last command printed, if it ran.
    printed: Option<String>,
    behind: Vec<Behind>,
    /// Output on the page, and what the commands printed instead.
    stale: Vec<(String, String)>,
}

/// The commands of a block: its lines, of which each means the same in any shell.
pub(super) fn commands(block: &Block) -> Vec<String> {
    let lines = block.text.lines().filter(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

/// True if the block has commands that run.
pub(super) fn runs_something(block: &Block) -> bool {
    block.language == "sh" && !block.note.starts_with("not run: ")
}

/// Follows a chapter, which leaves these files among others.
pub(super) fn follows(file: &str, wanted: &[&str]) {
    let place = Place::with_examples();
    let text = book::chapter(file);
    let page = Markdown::new(&text);
    let mut reader = Reader {
        place: &place,
        file,
        printed: None,
        behind: Vec::new(),
        stale: Vec::new(),
    };
    let began = Instant::now();
    for block in &page.blocks {
        reader.follow(block);
    }
    reader.close_other_terminals();
    println!("{file}: {:.1} s", began.elapsed().as_secs_f64());
    reader.compare(&text);
    assert_numbers_stand_in_blocks(file, &Markdown::new(&book::chapter(file)));
    let files = place.files();
    for wanted in wanted {
        assert!(
            files.iter().any(|file| file == wanted),
            "{file}: no {wanted}: {files:?}"
        );
    }
}

/// The folders of the command and of the Python of the checks come first.
fn search_path() -> OsString {
    let mut folders: Vec<PathBuf> = Vec::new();
    folders.extend(binary().parent().map(Path::to_owned));
    let python = std::env::var_os("PYTHON").map(PathBuf::from);
    folders.extend(python.as_deref().and_then(Path::parent).map(Path::to_owned));
    let path = std::env::var_os("PATH").unwrap_or_default();
    folders.extend(std::env::split_paths(&path));
    std::env::join_paths(folders).expect("a path")
}

impl Reader<'_> {
    fn follow(&mut self, block: &Block) {
        let note = block.note.as_str();
        match block.language.as_str() {
            "sh" if note.starts_with("not run: ") => self.parse(block),
            "sh" if note == "in another terminal" => self.start(block),
            "sh" => {
                let code = note.strip_prefix("exit ").unwrap_or("0");
                let code = code.parse().unwrap_or_else(|_| panic!("{block:?}"));
                for command in commands(block) {
                    self.run(&command, code);
                }
            }
            "text" => {
                let printed = self.printed.as_ref().filter(|_| note == "output");
                if let Some(printed) = printed.filter(|printed| !matches(&block.text, printed)) {
                    self.stale.push((block.text.clone(), printed.clone()));
                }
            }
            _ if note.is_empty() => {}
            _ => {
                // A busy machine may be silent for longer than a line.
                let silence = if block.text.contains("[teleoperation]") {
                    "silence_s = 60\n"
                } else {
                    ""
                };
                self.place.write(note, format!("{}{silence}", block.text));
            }
        }
    }

    fn shell(&self, command: &str) -> Command {
        let mut shell = Command::new(std::env::var_os(SHELL).unwrap_or("sh".into()));
        // However busy this machine is.
        let command = command.replace("teleoperate ", "teleoperate --skipped-most 100% ");
        // Another test may listen at the port of the guide: a free one stands for it.
        let free = self.behind.iter().find_map(Behind::address);
        let command = command.replace(ADDRESS, free.as_deref().unwrap_or("127.0.0.1:0"));
        shell.args(["-c", &command]).env("PATH", search_path());
        shell.env(Remembered::VARIABLE, self.place.path("state"));
        shell.current_dir(self.place.path("")).stdin(Stdio::null());
        shell
    }

    fn run(&mut self, command: &str, code: i32) {
        if command.starts_with("python3 ") && std::env::var_os("PYTHON").is_none() {
            self.printed = None;
            return skip(&format!("{}: {command}: PYTHON is not set", self.file));
        }
        let output = assert_cmd::Command::from_std(self.shell(command))
            .timeout(PATIENCE)
            .output();
        let ended = Ended::new(command.to_owned(), &output.expect("runs and ends in time"));
        let ended = match code {
            0 if command.starts_with("host-cli ") => ended.succeeded_with_warnings(),
            0 => ended,
            code => ended.failed(code),
        };
        assert_eq!(ended.code, Some(code), "{}: {ended}", self.file);
        self.printed = Some(ended.stdout);
    }

    /// Starts the commands, and waits until each has said something or made its link.
    fn start(&mut self, block: &Block) {
        for command in commands(block) {
            let number = self.behind.len();
            let stdout = self.place.path(&format!("terminal-{number}.out"));
            let stderr = self.place.path(&format!("terminal-{number}.err"));
            let create = |path: &Path| std::fs::File::create(path).expect("creates");
            let child = self
                .shell(&format!("exec {command}"))
                .stdout(create(&stdout))
                .stderr(create(&stderr))
                .spawn()
                .expect("starts");
            let mut words = command.split_whitespace();
            let link = words.find(|word| *word == "--link").and(words.next());
            until(&command, || match link {
                Some(link) => self.place.path(link).exists().then_some(()),
                None => {
                    let message = std::fs::metadata(&stdout).is_ok_and(|file| file.len() > 0);
                    message.then_some(())
                }
            });
            self.behind.push(Behind {
                command,
                child,
                stdout,
                stderr,
            });
        }
    }

    /// Ctrl-C in the other terminals, unless their command ends by itself.
    fn close_other_terminals(&mut self) {
        for behind in self.behind.drain(..) {
            let mut child = behind.child;
            if !behind.command.contains("--duration") {
                let kill = format!("kill -INT {}", child.id());
                let sent = Command::new("sh").args(["-c", &kill]).status();
                assert!(sent.expect("sh runs").success(), "{}", behind.command);
            }
            let status = until(&behind.command, || child.try_wait().expect("waits"));
            let read = |path: &Path| std::fs::read(path).expect("reads");
            let output = std::process::Output {
                status,
                stdout: read(&behind.stdout),
                stderr: read(&behind.stderr),
            };
            // What it tells of itself when it ends is no warning.
            let ended = Ended::new(behind.command, &output);
            assert_eq!(ended.code, Some(0), "{}: {ended}", self.file);
        }
    }

    /// The arguments of commands that do not run here.
    fn parse(&self, block: &Block) {
        for command in commands(block) {
            println!("{}: {command}: {}", self.file, block.note);
            // An option of builds with this feature.
            let known = cfg!(feature = "foxglove") || !command.contains("--foxglove");
            if command.starts_with("host-cli ") && known {
                let end = command.find(['|', '>', '&']).unwrap_or(command.len());
                let words = command[..end].split_whitespace();
                let parsed = host_cli::parser().try_get_matches_from(words);
                assert!(parsed.is_ok(), "{}: {command}: {parsed:?}", self.file);
            }
        }
    }

    /// Output on the page that no command printed: a failure, or written anew.
    fn compare(&self, text: &str) {
        if self.stale.is_empty() {
            return;
        }
        let mut new = text.to_owned();
        let mut by_hand = Vec::new();
        for (shown, printed) in &self.stale {
            let fence = |text: &str| format!("```text output\n{text}```");
            if shown.lines().any(|line| line == LEFT_OUT) {
                by_hand.push(format!("on the page:\n{shown}\nprinted:\n{printed}"));
            } else {
                new = new.replacen(&fence(shown), &fence(printed), 1);
            }
        }
        if std::env::var_os(UPDATE).is_some() && new != text {
            std::fs::write(book::folder().join(self.file), &new).expect("writes the page");
            assert!(by_hand.is_empty(), "{}: {}", self.file, by_hand.join("\n"));
            return;
        }
        let all = self.stale.iter();
        let all = all.map(|(shown, printed)| format!("on the page:\n{shown}\nprinted:\n{printed}"));
        panic!(
            "{} shows what no command prints; {UPDATE}=1 in the environment writes blocks without {LEFT_OUT} anew\n{}",
            self.file,
            all.collect::<Vec<_>>().join("\n")
        );
    }
}

impl Drop for Reader<'_> {
    fn drop(&mut self) {
        for behind in &mut self.behind {
            let _ = behind.child.kill();
            let _ = behind.child.wait();
        }
    }
}

/// True if the lines of `printed` are those of `shown`, where `…` stands for any number of lines.
fn matches(shown: &str, printed: &str) -> bool {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let shown: Vec<&str> = shown.lines().map(str::trim_end).collect();
    let mut parts = shown.split(|line| *line == LEFT_OUT);
    let first = parts.next().unwrap_or_default();
    if !printed.starts_with(first) {
        return false;
    }
    let mut at = first.len();
    let mut last = None;
    for part in parts {
        let rest = &printed[at..];
        let found = (0..=rest.len().saturating_sub(part.len()))
            .find(|start| rest[*start..].starts_with(part));
        let Some(start) = found else { return false };
        at += start + part.len();
        last = Some(part);
    }
    match last {
        None => at == printed.len(),
        Some(last) => last.is_empty() || printed.ends_with(last),
    }
}

/// Asserts that on a page with output no number in the text is made up.
fn assert_numbers_stand_in_blocks(file: &str, page: &Markdown) {
    if !page.blocks.iter().any(|block| block.note == "output") {
        return;
    }
    for (span, line) in &page.spans {
        if !span.starts_with(|c: char| c.is_ascii_digit()) {
            continue;
        }
        let stands = page.blocks.iter().any(|block| block.text.contains(span));
        assert!(stands, "{file}:{line}: `{span}` stands in no block");
    }
}

#[test]
fn output_on_a_page_is_compared_line_by_line() {
    let printed = "a\nb\nc\nd\n";
    for (shown, same) in [
        ("a\nb\nc\nd\n", true),
        ("a\nb\nc\n", false),
        ("a\n…\nd\n", true),
        ("…\nb\nc\n…\n", true),
        ("…\nc\nb\n…\n", false),
        ("b\n…\n", false),
        ("a\n…\n", true),
        ("a\n…\nc\n", false),
    ] {
        assert_eq!(matches(shown, printed), same, "{shown}");
    }
}
