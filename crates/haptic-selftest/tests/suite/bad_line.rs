//! The self-test of a board on a line that loses, damages and repeats frames.

use crate::at_once::at_once;
use crate::board::{Board, Flaw};
use crate::tested;
use haptic_emulator::{FaultyLine, LineDamage, LineFaults};
use haptic_experiment::Failure;
use haptic_remote::serial::{Line, Pipe, SerialLink};
use haptic_selftest::SelfTest;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Lines; the promise is of 30, which `CAMPAIGN_CASES=30` tries in half a minute.
const LINES: u64 = 2;
/// Lines that are tried at the same time.
const AT_ONCE: usize = 5;
/// Chance that a frame is lost, of another that it is damaged, of a third that it comes twice.
const CHANCE: f64 = 0.01;
/// A greeting may be lost as often as it is said again; not so many in a row.
const GREETINGS: usize = 20;

/// One direction: bytes go in, frames come through or not.
struct Way {
    line: FaultyLine,
    /// Bytes since the end of a frame.
    frame: Vec<u8>,
    through: VecDeque<u8>,
}

impl Way {
    fn new(seed: u64) -> Arc<Mutex<Self>> {
        let faults = LineFaults {
            drop: CHANCE,
            corrupt: CHANCE,
            duplicate: CHANCE,
            ..LineFaults::default()
        };
        Arc::new(Mutex::new(Self {
            line: FaultyLine::new(faults, seed).expect("good chances"),
            frame: Vec::new(),
            through: VecDeque::new(),
        }))
    }

    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.frame.push(byte);
            if byte == 0 {
                self.line.send(&self.frame, 0);
                self.frame.clear();
            }
        }
        while let Some(frame) = self.line.receive(0) {
            self.through.extend(frame);
        }
    }
}

/// The host's end of a line to a board, with faults in both directions.
#[derive(Clone)]
struct BadLine {
    line: Pipe,
    to_board: Arc<Mutex<Way>>,
    to_host: Arc<Mutex<Way>>,
}

impl BadLine {
    fn damage(&self) -> [LineDamage; 2] {
        [&self.to_board, &self.to_host].map(|way| way.lock().expect("no panic").line.damage())
    }
}

impl Read for BadLine {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut way = self.to_host.lock().expect("no panic");
        if way.through.is_empty() {
            let mut bytes = [0; 1024];
            let count = self.line.read(&mut bytes)?;
            if count == 0 {
                return Ok(0);
            }
            way.take(&bytes[..count]);
        }
        match way.through.read(into)? {
            0 => Err(ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for BadLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut way = self.to_board.lock().expect("no panic");
        way.take(bytes);
        let through: Vec<u8> = way.through.drain(..).collect();
        self.line.write_all(&through)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.line.flush()
    }
}

impl Line for BadLine {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(self.clone()))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        self.line.set_patience(patience)
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn whatever_a_bad_line_loses_every_promise_is_seen_to_be_kept() {
    let lines = std::env::var("CAMPAIGN_CASES").map_or(LINES, |cases| {
        cases.parse::<u64>().expect("a number").min(30)
    });
    let seeds: Vec<u64> = (0..lines).collect();
    for seeds in seeds.chunks(AT_ONCE) {
        at_once(seeds.iter().map(|&seed| {
            let case = move || every_promise_is_kept(seed);
            (format!("line {seed}"), case)
        }));
    }
}

fn every_promise_is_kept(seed: u64) {
    let board = Board::start(Flaw::None);
    let line = BadLine {
        line: board.line(),
        to_board: Way::new(2 * seed),
        to_host: Way::new(2 * seed + 1),
    };
    let connect = || {
        let greeted = || SerialLink::to_line(Box::new(line.clone()), "bad line");
        let link = (1..GREETINGS).find_map(|_| greeted().ok());
        link.map_or_else(greeted, Ok).map_err(Failure::input)
    };
    let report = tested(&connect, SelfTest::DEFAULT, &|_| {});
    assert!(report.holds, "{report:#?}");
    for damage in line.damage() {
        let LineDamage {
            dropped, corrupted, ..
        } = damage;
        assert!(dropped > 0 && corrupted > 0, "{damage:?}");
    }
}
