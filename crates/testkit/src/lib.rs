//! Shared by the tests of several crates. For integration tests only: a unit test would see its own crate twice.
//! ```
//! use testkit::{Random, assert_close};
//!
//! let mut random = Random(1);
//! assert_close("a mean", 0.5 * (random.between(0.0, 1.0) + 1.0), 0.75, 0.25);
//! ```
#![forbid(unsafe_code)]

#[cfg(feature = "book")]
pub mod book;
#[cfg(feature = "browser")]
pub mod browser;
#[cfg(feature = "control")]
pub mod control;
pub mod device;
pub mod golden;
pub mod operator;
mod tested;
pub mod tissue;

pub use tested::{Never, Tested};

use std::fmt::{Debug, Display};
use std::io::Write as _;
use std::ops::Deref;
use std::path::Path;
use std::str::FromStr;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A test that waits for longer than this hangs. The longest wait takes 30 s on an idle machine, and five times that beside eight
/// busy loops on two cores.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// Waits until there is something, and returns it. This is how a test waits for another process or thread: a sleep of a second
/// is a guess about a machine that it does not know.
///
/// # Panics
/// If it has not come within [`PATIENCE`].
#[track_caller]
pub fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(began.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A folder of a test's own, empty at first; it goes with the test.
#[derive(Debug)]
pub struct Folder(TempDir);

impl Folder {
    /// A new one.
    ///
    /// # Panics
    /// Where the system has no room for it.
    #[must_use]
    pub fn empty() -> Self {
        Self(TempDir::new().expect("a folder"))
    }
}

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        self.0.path()
    }
}

/// Cases to try: `CAMPAIGN_CASES`, or `usual` without it.
///
/// # Panics
/// If `CAMPAIGN_CASES` is not a number.
#[must_use]
pub fn cases<T: FromStr<Err: Debug>>(usual: T) -> T {
    std::env::var("CAMPAIGN_CASES").map_or(usual, |cases| cases.parse().expect("CAMPAIGN_CASES"))
}

/// The rows of a table, cells between ` | `, `\n` for the end of a line. Empty rows and remarks, `# …`, do not count.
///
/// # Panics
/// If a row has another number of cells.
pub fn table<const N: usize>(text: &str) -> impl Iterator<Item = [String; N]> {
    let rows = text.lines().map(str::trim);
    let rows = rows.filter(|row| !row.is_empty() && !row.starts_with("# "));
    rows.map(|row| {
        let cells = row.split(" | ").map(|cell| cell.replace("\\n", "\n"));
        let cells: Vec<String> = cells.collect();
        cells.try_into().unwrap_or_else(|_| panic!("{row}"))
    })
}

/// |have − want| ≤ tolerance.
///
/// # Panics
/// Otherwise; a NaN too.
#[track_caller]
pub fn assert_close(what: &str, have: f64, want: f64, tolerance: f64) {
    let error = (have - want).abs();
    assert!(
        error <= tolerance,
        "{what}: have {have:.15e}, want {want:.15e}, error {error:e} above {tolerance:e}"
    );
}

/// |have − want| ≤ tolerance·|want|.
///
/// # Panics
/// Otherwise; a NaN too.
#[track_caller]
pub fn assert_relative(what: &str, have: f64, want: f64, tolerance: f64) {
    assert!(
        (have - want).abs() <= tolerance * want.abs(),
        "{what}: have {have:.15e}, want {want:.15e}, off by {:.1e}",
        have / want - 1.0
    );
}

/// The text has all of these words, ` & ` between them.
///
/// # Panics
/// Otherwise, with the beginning of the text.
#[track_caller]
pub fn assert_says(text: &(impl Display + ?Sized), words: &str) {
    let text = text.to_string();
    let start = || text.chars().take(2000).collect::<String>();
    for words in words.split(" & ") {
        assert!(text.contains(words), "\"{words}\" is missing: {}", start());
    }
}

/// Refused in one line that has all of these words, ` & ` between them.
///
/// # Panics
/// Otherwise.
#[track_caller]
pub fn assert_refused<T, E: Display>(answer: Result<T, E>, words: &str) {
    let Err(refusal) = answer else {
        panic!("not refused: {words}");
    };
    assert_says(&refusal, words);
    let refusal = refusal.to_string();
    assert!(!refusal.contains('\n'), "{refusal}");
}

/// Says on standard error that this test is skipped, and why.
///
/// # Panics
/// Where `REQUIRE_ALL_CHECKS` is set, as in CI.
pub fn skip(why: &str) {
    assert!(std::env::var_os("REQUIRE_ALL_CHECKS").is_none(), "{why}");
    skip_for_load(why);
}

/// Says what [`skip`] says, but never panics: for a check by the clock on a machine that is too busy for it, which CI may be too.
pub fn skip_for_load(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("part of a test");
    // One write: lines of other tests do not come between.
    let line = format!("skipped: {test}: {}\n", why.trim());
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// `SplitMix64`.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// Uniform in [0, 1).
    pub fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Uniform in the logarithm: each decade is as likely as any other.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(libm::log(low) + libm::log(high / low) * self.share())
    }

    /// 0 in a third of all cases, uniform in [0, high) in the others.
    pub fn or_nothing(&mut self, high: f64) -> f64 {
        if self.share() < 1.0 / 3.0 {
            0.0
        } else {
            self.between(0.0, high)
        }
    }

    /// One of them.
    ///
    /// # Panics
    /// Without any.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.bits() % choices.len() as u64) as usize]
    }

    /// True in this share of all cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }
}

/// The bytes of a file with one damage: cut, grown, flipped, a part moved, or a length forged.
pub fn broken(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    let mut below = |most: usize| (random.bits() % most.max(1) as u64) as usize;
    let (kind, at) = (below(5), below(bytes.len()));
    let end = (at + 1 + below(64)).min(bytes.len());
    match kind {
        0 => bytes.truncate(at),
        1 => drop(bytes.splice(at..at, (at..end).map(|_| below(256) as u8))),
        2 => (0..=below(3)).for_each(|_| bytes[below(whole.len())] ^= 1 << below(8)),
        3 => bytes[at..].rotate_left(end - at),
        _ => bytes[at..end.min(at + 8)].fill([0, 1, 0x7f, 0xff][below(4)]),
    }
    bytes
}
