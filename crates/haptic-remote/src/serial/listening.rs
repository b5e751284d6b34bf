//! Listening side of a line: one host at a time, the others get a notice.
//!
//! ```text
//! comes ─▶ stranger ─ greets ─▶ waiting ─▶ present ─▶ gone
//!              └ one of too many, or speaks of something else: dropped      └ refused while the present one speaks
//! ```
//! A stranger does not block others: the device listens to all of them, and serves the first that greets, with every byte that it
//! has sent.

use super::{
    line::{Line, lock},
    socket::{Stream as _, prompt, set_patience},
};
use crate::Patience;
use haptic_link::{Direction, FRAME_MAX, Receiver, Request};
use haptic_loop::realtime::Moment;
use std::{
    boxed::Box,
    collections::VecDeque,
    format,
    io::{self, ErrorKind, Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{Arc, Mutex},
    time::Duration,
};

/// Longest wait of a read or a write, so that the threads notice the end.
const PATIENCE: Duration = Duration::from_millis(20);
/// Pause without a host: nobody can be kept waiting, so that a longer one is enough.
const NOBODY: Duration = Duration::from_millis(5);
/// A host that is silent for this long gives way to another.
const SILENCE: Duration = Duration::from_secs(2);
/// Time between two looks at the door while a host is served.
const LOOK: Duration = Duration::from_millis(100);
/// Strangers that are listened to; with more of them the oldest goes.
const STRANGERS_MOST: usize = 64;
/// Strangers who come in at one look: each is listened to several times before others take its place.
const AT_A_LOOK: usize = 16;
/// Bytes in which a host has greeted: what a line before it may have left over, and some frames.
const GREETING_MOST: usize = 4 * FRAME_MAX;

/// The way in which a host shows that it is one.
#[derive(Clone, Copy, Debug)]
pub(super) enum Greeting {
    /// A `hello`, the first message of our protocol.
    Hello,
    /// Any bytes, in a protocol that this door does not know.
    Anything,
}

/// A place at which hosts come in, one at a time.
#[derive(Debug)]
pub(super) struct Door {
    listener: TcpListener,
    hosts: Mutex<Hosts>,
    greeting: Greeting,
    silence: Duration,
}

#[derive(Debug)]
struct Hosts {
    present: Option<Host>,
    /// Hosts that have come and have not greeted.
    strangers: VecDeque<Host>,
    waiting: Option<Host>,
    /// All that the present one had said before the other came is read.
    caught_up: bool,
    /// Kept open for a while: a socket that is closed at once may take its last words with it.
    refused: Option<Host>,
    looked: Moment,
}

#[derive(Debug)]
struct Host {
    stream: Arc<TcpStream>,
    address: SocketAddr,
    patience: Patience,
    read: Moment,
    receiver: Receiver<Request>,
    /// Said before it was let in, and not read yet.
    greeting: VecDeque<u8>,
}

impl Host {
    /// Takes what it has said; true if it has greeted. An error if it is gone, or speaks of something else. Does not wait.
    fn look(&mut self, greeting: Greeting) -> io::Result<bool> {
        let mut bytes = [0; FRAME_MAX];
        while self.greeting.len() < GREETING_MOST {
            let count = match self.stream.receive(&mut bytes) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::TimedOut => return Ok(false),
                Err(error) => return Err(error),
            };
            self.greeting.extend(&bytes[..count]);
            if self.greets(&bytes[..count], greeting) {
                return Ok(true);
            }
        }
        Err(ErrorKind::InvalidData.into())
    }

    fn greets(&mut self, bytes: &[u8], greeting: Greeting) -> bool {
        let mut frames = bytes.iter().filter_map(|byte| self.receiver.push(*byte));
        match greeting {
            Greeting::Hello => frames.any(|(_, request)| matches!(request, Request::Hello { .. })),
            Greeting::Anything => true,
        }
    }

    /// It has not read anything yet, so that these words find room. If it has gone, they do not matter.
    fn refuse(&self, present: SocketAddr) {
        let options = self.stream.options();
        let _ = options.set_nonblocking(true);
        let _ = (self.stream).send(format!("busy: it serves {present}\n").as_bytes());
        let _ = options.shutdown(Shutdown::Write);
    }
}

impl Door {
    pub(super) fn new(listener: TcpListener, greeting: Greeting) -> Self {
        Self {
            listener,
            hosts: Mutex::new(Hosts {
                present: None,
                strangers: VecDeque::new(),
                waiting: None,
                caught_up: false,
                refused: None,
                looked: Moment::now(),
            }),
            greeting,
            silence: SILENCE,
        }
    }

    /// The host that is served, or one that waits to be let in.
    fn host_or_next(&self, patience: Duration) -> Option<Arc<TcpStream>> {
        let hosts = &mut *lock(&self.hosts);
        let nobody = hosts.present.is_none();
        if hosts.waiting.is_none() && (nobody || hosts.looked.elapsed() >= LOOK) {
            hosts.looked = Moment::now();
            hosts.caught_up = false;
            self.look_at_strangers(hosts);
        }
        if nobody {
            hosts.let_in(patience);
        }
        hosts.stream()
    }

    /// Lets in who has come, and listens to each until one greets. Does not wait itself.
    fn look_at_strangers(&self, hosts: &mut Hosts) {
        for _ in 0..AT_A_LOOK {
            let Ok(stranger) = self.next() else {
                break;
            };
            if hosts.strangers.len() == STRANGERS_MOST {
                hosts.strangers.pop_front();
            }
            hosts.strangers.push_back(stranger);
        }
        let mut index = 0;
        while let Some(stranger) = hosts.strangers.get_mut(index) {
            match stranger.look(self.greeting) {
                Ok(false) => index += 1,
                Err(_) => drop(hosts.strangers.remove(index)),
                Ok(true) => {
                    hosts.waiting = hosts.strangers.remove(index);
                    return;
                }
            }
        }
    }

    /// The next stranger that has come. Does not wait itself.
    fn next(&self) -> io::Result<Host> {
        let (stream, address) = self.listener.accept()?;
        let stream = prompt(stream)?;
        stream.set_nonblocking(true)?;
        Ok(Host {
            stream: Arc::new(stream),
            address,
            patience: Patience::new(self.silence),
            read: Moment::now(),
            receiver: Receiver::new(Direction::FromHost),
            greeting: VecDeque::new(),
        })
    }

    /// This host has sent `count` bytes; `all` is true if nothing more had come.
    fn heard(&self, speaker: &Arc<TcpStream>, count: usize, all: bool, patience: Duration) {
        let hosts = &mut *lock(&self.hosts);
        let speaks = |host: &&mut Host| Arc::ptr_eq(&host.stream, speaker);
        let Some(present) = hosts.present.as_mut().filter(speaks) else {
            return;
        };
        // Whoever reads may do other things between two reads, but not be held up for longer.
        let now = Moment::now();
        let took = now.saturating_duration_since(core::mem::replace(&mut present.read, now));
        present.patience.waited(PATIENCE, took);
        if count > 0 {
            present.patience.heard();
            // It speaks though another waits, and so has not just left: the other is refused.
            if hosts.caught_up
                && let Some(waiting) = hosts.waiting.take()
            {
                waiting.refuse(present.address);
                hosts.refused = Some(waiting);
            }
        } else if all && hosts.waiting.is_some() && present.patience.is_over() {
            hosts.let_in(patience);
        }
        hosts.caught_up |= all;
    }

    /// This host has gone, unless another is there already.
    fn leave(&self, gone: &Arc<TcpStream>) {
        let mut hosts = lock(&self.hosts);
        let served = hosts.stream();
        if served.is_some_and(|served| Arc::ptr_eq(&served, gone)) {
            hosts.present = None;
        }
    }
}

impl Hosts {
    /// Serves who waits, if somebody does.
    fn let_in(&mut self, patience: Duration) {
        let ready = |host: &Host| {
            let timed = host.stream.options().set_write_timeout(Some(PATIENCE));
            timed.is_ok() && set_patience(host.stream.as_ref(), patience).is_ok()
        };
        self.present = self.waiting.take().filter(ready);
    }

    /// Hands over what the present one said before it was let in.
    fn first_words(&mut self, into: &mut [u8]) -> usize {
        let greeting = self.present.as_mut().map(|present| &mut present.greeting);
        greeting
            .and_then(|greeting| greeting.read(into).ok())
            .unwrap_or(0)
    }

    fn stream(&self) -> Option<Arc<TcpStream>> {
        let present = self.present.as_ref();
        present.map(|present| Arc::clone(&present.stream))
    }
}

/// The device's end of a line at a door.
#[derive(Debug)]
pub(super) struct Listening {
    door: Arc<Door>,
    patience: Duration,
}

impl Listening {
    pub(super) fn new(door: &Arc<Door>) -> Self {
        Self {
            door: Arc::clone(door),
            patience: PATIENCE,
        }
    }
}

impl Read for Listening {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let Some(host) = self.door.host_or_next(self.patience) else {
            std::thread::sleep(NOBODY.min(self.patience));
            return Err(ErrorKind::TimedOut.into());
        };
        let before = lock(&self.door.hosts).first_words(into);
        if before > 0 {
            return Ok(before);
        }
        match host.receive(into) {
            Ok(count @ 1..) => {
                let all = count < into.len();
                self.door.heard(&host, count, all, self.patience);
                Ok(count)
            }
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                let nothing = error.kind() == ErrorKind::TimedOut;
                self.door.heard(&host, 0, nothing, self.patience);
                Err(error)
            }
            Ok(0) | Err(_) => {
                self.door.leave(&host);
                Err(ErrorKind::TimedOut.into())
            }
        }
    }
}

impl Write for Listening {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let host = lock(&self.door.hosts).stream();
        host.ok_or(ErrorKind::NotConnected)?.send(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Listening {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(Self {
            door: Arc::clone(&self.door),
            patience: self.patience,
        }))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        self.patience = patience;
        let host = lock(&self.door.hosts).stream();
        host.map_or(Ok(()), |host| set_patience(host.as_ref(), patience))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;
    use testkit::Tested;

    /// Reads until a host has said something.
    fn heard(device: &mut dyn Line) -> Vec<u8> {
        let mut bytes = [0; 64];
        loop {
            if let Ok(count) = device.read(&mut bytes) {
                return bytes[..count].to_vec();
            }
        }
    }

    /// A door with a silence, and the device's end of it.
    fn door(greeting: Greeting, silence: Duration) -> (Listening, SocketAddr) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
        listener.set_nonblocking(true).expect("it can");
        let address = listener.local_addr().expect("bound");
        let mut door = Door::new(listener, greeting);
        door.silence = silence;
        (Listening::new(&Arc::new(door)), address)
    }

    /// The first words of a host.
    fn hello(nonce: u32) -> Vec<u8> {
        let mut frame = [0; FRAME_MAX];
        let header = haptic_link::Header::from_host(0, 0);
        let length = haptic_link::encode(&Request::Hello { nonce }, header, &mut frame);
        let mut words = std::vec![0];
        words.extend_from_slice(&frame[..length.expect("fits")]);
        words
    }

    #[test]
    fn whoever_has_not_greeted_keeps_nobody_out() -> Tested {
        // A host that never falls silent, so that nothing here is a matter of time.
        let (mut device, address) = door(Greeting::Hello, Duration::MAX);
        let come = || TcpStream::connect(address).expect("listens");
        device.set_patience(Duration::ZERO)?;
        let mut strangers = Vec::new();
        for _ in 0..150 {
            strangers.push(come());
            // The system keeps 128 at the door.
            let nothing = device.read(&mut [0]).expect_err("nobody greets");
            assert_eq!(nothing.kind(), ErrorKind::TimedOut);
        }
        for stranger in strangers.iter_mut().step_by(3) {
            stranger.write_all(b"GET / HTTP/1.1\r\n\r\n")?;
        }
        // One is cut off in its greeting, and one says too much.
        strangers[148].write_all(&hello(1)[..5])?;
        let much = [7; GREETING_MOST];
        strangers[149].write_all(&much)?;
        let mut host = come();
        host.write_all(&hello(2))?;
        assert_eq!(heard(&mut device), hello(2));
        // Those of them that are left, and who comes now, do not disturb it.
        let words = b"and then";
        let _late = come();
        host.write_all(words)?;
        assert_eq!(heard(&mut device), words);
        device.write_all(b"hello")?;
        let mut bytes = [0; 5];
        host.read_exact(&mut bytes)?;
        assert_eq!(&bytes, b"hello");
        Ok(())
    }

    #[test]
    fn a_host_that_has_vanished_gives_way_and_one_that_speaks_does_not() -> Tested {
        for (silence, let_in) in [(Duration::ZERO, true), (Duration::MAX, false)] {
            let (mut device, address) = door(Greeting::Anything, silence);
            let mut first = TcpStream::connect(address)?;
            first.write_all(b"first")?;
            assert_eq!(heard(&mut device), b"first");
            let mut second = TcpStream::connect(address)?;
            second.write_all(b"second")?;
            let mut received = Vec::new();
            if let_in {
                assert_eq!(heard(&mut device), b"second");
                assert!(
                    first
                        .read_to_end(&mut received)
                        .is_ok_and(|count| count == 0)
                );
                device.write_all(b"hello")?;
                let mut bytes = [0; 5];
                second.read_exact(&mut bytes)?;
                assert_eq!(&bytes, b"hello");
            } else {
                let reader =
                    std::thread::spawn(move || second.read_to_end(&mut received).map(|_| received));
                while !reader.is_finished() {
                    first.write_all(b"x")?;
                    let _ = device.read(&mut [0; 8]);
                }
                let received = reader.join().expect("no panic")?;
                let first = first.local_addr()?;
                assert_eq!(received, format!("busy: it serves {first}\n").as_bytes());
            }
        }
        Ok(())
    }
}
