//! The device under QEMU, spoken to through a socket: its bytes come at once, however busy the machine is.

use super::image::Qemu;
use haptic_link::{EventKind, FRAME_MAX, Report, Request, Start, Status};
use haptic_remote::{Conversation, Incoming};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest wait for anything; an emulator on a busy machine may stand still for a while.
const PATIENCE: Duration = Duration::from_secs(20);
/// Where the stack ends.
const STACK_END: u32 = 0x2000_0000;
/// What the start-up code paints an unused stack with.
const PAINT: [u8; 4] = 0xCCCC_CCCC_u32.to_le_bytes();

/// A device, and the host's half of the conversation with it.
#[derive(Debug)]
pub(crate) struct Board {
    qemu: Qemu,
    line: UnixStream,
    received: Receiver<Vec<u8>>,
    conversation: Conversation,
    began: Instant,
    samples: usize,
    ended: Option<EventKind>,
    stack: u32,
    _folder: TempDir,
}

/// QEMU with the device in it, and its line, which nobody has open.
#[derive(Debug)]
pub(crate) struct Emulator {
    qemu: Qemu,
    path: String,
    /// Of the socket.
    folder: TempDir,
}

impl Emulator {
    pub(crate) fn start(image: &Path) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("line").display().to_string();
        let line = format!("socket,id=line,path={path},server=on,wait=off");
        let mut child = Command::new("qemu-system-arm")
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "stdio"])
            .args(["-chardev", &line, "-serial", "chardev:line", "-kernel"])
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("QEMU starts");
        while UnixStream::connect(&path).is_err() {
            let ended = child.try_wait().expect("a child");
            assert_eq!(ended, None, "QEMU ended at once");
            std::thread::sleep(Duration::from_millis(5));
        }
        let qemu = Qemu(child);
        Self { qemu, path, folder }
    }

    /// What a host opens.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }
}

impl Board {
    pub(crate) fn start(image: &Path, stack: u32) -> Self {
        let Emulator { qemu, path, folder } = Emulator::start(image);
        let line = UnixStream::connect(path).expect("QEMU listens");
        let mut reader = line.try_clone().expect("the same file");
        let (sender, received) = channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 1024];
            // Ends when QEMU does.
            while let Ok(length @ 1..) = reader.read(&mut bytes) {
                if sender.send(bytes[..length].to_vec()).is_err() {
                    break;
                }
            }
        });
        Self {
            qemu,
            line,
            received,
            conversation: Conversation::new(1_000_000),
            began: Instant::now(),
            samples: 0,
            ended: None,
            stack,
            _folder: folder,
        }
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_micros()).expect("less than 500 000 years")
    }

    fn say(&mut self, frame: &[u8]) {
        self.line.write_all(frame).expect("QEMU takes it");
    }

    /// Hears what comes within 20 ms; the answer to a request, if it is there.
    fn hear(&mut self) -> Option<Incoming> {
        let bytes = match self.received.recv_timeout(Duration::from_millis(20)) {
            Ok(bytes) => bytes,
            Err(RecvTimeoutError::Timeout) => Vec::new(),
            Err(RecvTimeoutError::Disconnected) => panic!("QEMU is gone"),
        };
        let mut answer = None;
        for byte in bytes {
            match self.conversation.receive(byte, self.now_us()) {
                Some(Incoming::Told(Report::Sample(_))) => self.samples += 1,
                Some(Incoming::Told(Report::Batch(batch))) => self.samples += batch.items.len(),
                Some(Incoming::Told(Report::Event(event))) => self.ended = Some(event.kind),
                Some(other) => answer = Some(other),
                None => {}
            }
        }
        answer
    }

    /// Asks, and returns the answer.
    pub(crate) fn ask(&mut self, request: Request) -> Report {
        let name = request.name();
        let mut frame = [0; FRAME_MAX];
        let length = self.conversation.ask(request, self.now_us(), &mut frame);
        self.say(&frame[..length]);
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            match self.hear() {
                Some(Incoming::Answer(report)) => return report,
                Some(Incoming::Refused { refusal, .. }) => panic!("{name}: {refusal:?}"),
                Some(other) => panic!("{name}: {other:?}"),
                None => {}
            }
            let due = self.conversation.due(self.now_us(), &mut frame);
            let length = due.unwrap_or_else(|error| panic!("{name}: {error}"));
            self.say(&frame[..length]);
        }
        panic!("{name}: no answer, {:?}", self.conversation.counters());
    }

    /// Asks for something that is only acknowledged.
    pub(crate) fn done(&mut self, request: Request) {
        let name = request.name();
        let answer = self.ask(request);
        assert!(matches!(answer, Report::Ack(_)), "{name}: {answer:?}");
    }

    pub(crate) fn status(&mut self) -> Status {
        let mut frame = [0; FRAME_MAX];
        let keep_alive = Request::KeepAlive { token: 0 };
        let length = self.conversation.tell(&keep_alive, &mut frame);
        self.say(&frame[..length]);
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if let Some(Incoming::Alive { status, .. }) = self.hear() {
                return status;
            }
        }
        panic!("no sign of life");
    }

    /// Samples of a run until its end is told, with the host alive.
    pub(crate) fn samples_of(&mut self, start: Start) -> usize {
        // The first of them may come before the answer to the start.
        self.samples = 0;
        self.ended = None;
        self.done(Request::Start(start));
        let deadline = Instant::now() + PATIENCE;
        while self.ended != Some(EventKind::Finished) {
            assert!(Instant::now() < deadline, "the run does not end");
            self.status();
        }
        self.samples
    }

    /// Bytes of the stack that were ever used, by its paint.
    pub(crate) fn stack_used(&mut self) -> u32 {
        let folder = tempfile::tempdir().expect("a folder");
        let dump = folder.path().join("stack");
        let order = format!(
            "pmemsave {STACK_END} {} \"{}\"\n",
            self.stack,
            dump.display()
        );
        let monitor = self.qemu.0.stdin.as_mut().expect("piped");
        monitor.write_all(order.as_bytes()).expect("QEMU listens");
        let deadline = Instant::now() + PATIENCE;
        loop {
            let bytes = std::fs::read(&dump).unwrap_or_default();
            if bytes.len() == self.stack as usize {
                let painted = bytes.chunks(4).take_while(|word| **word == PAINT).count();
                return self.stack - u32::try_from(4 * painted).expect("small");
            }
            assert!(Instant::now() < deadline, "no dump of the stack");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
