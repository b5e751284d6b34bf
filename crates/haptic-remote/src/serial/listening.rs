//! The listening side of a line: one host at a time, the others are told so.

use super::line::{Line, lock};
use super::socket::{Stream as _, prompt, set_patience};
use haptic_loop::realtime::Moment;
use std::boxed::Box;
use std::format;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Longest wait of a read or a write, so that the threads notice the end.
const PATIENCE: Duration = Duration::from_millis(20);
/// Nobody can be kept waiting while nobody is there, so that a longer pause is enough.
const NOBODY: Duration = Duration::from_millis(5);
/// A host that has said nothing for so long gives way to another.
const SILENCE: Duration = Duration::from_secs(2);
/// Time between two looks at the door while a host is served.
const LOOK: Duration = Duration::from_millis(100);

/// A place at which hosts come in, one at a time.
#[derive(Debug)]
pub(super) struct Door {
    listener: TcpListener,
    hosts: Mutex<Hosts>,
    silence: Duration,
}

#[derive(Debug)]
struct Hosts {
    present: Option<Host>,
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
    heard: Moment,
}

impl Door {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            hosts: Mutex::new(Hosts {
                present: None,
                waiting: None,
                caught_up: false,
                refused: None,
                looked: Moment::now(),
            }),
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
            hosts.waiting = self.next().ok();
        }
        if nobody {
            hosts.let_in(patience);
        }
        hosts.stream()
    }

    /// The next host that waits. Does not wait itself.
    fn next(&self) -> io::Result<Host> {
        let (stream, address) = self.listener.accept()?;
        Ok(Host {
            stream: Arc::new(prompt(stream)?),
            address,
            heard: Moment::now(),
        })
    }

    /// This host has said so much; it was `all` that had come.
    fn heard(&self, speaker: &Arc<TcpStream>, count: usize, all: bool, patience: Duration) {
        let hosts = &mut *lock(&self.hosts);
        let speaks = |host: &&mut Host| Arc::ptr_eq(&host.stream, speaker);
        let Some(present) = hosts.present.as_mut().filter(speaks) else {
            return;
        };
        if count > 0 {
            present.heard = Moment::now();
            // It speaks though another waits, and so has not just left: the other is refused.
            if hosts.caught_up
                && let Some(waiting) = hosts.waiting.take()
            {
                waiting.refuse(present.address);
                hosts.refused = Some(waiting);
            }
        } else if all && hosts.waiting.is_some() && present.heard.elapsed() >= self.silence {
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

impl Host {
    /// It has not read anything yet, so that these words find room. If it has gone, nobody misses them.
    fn refuse(&self, present: SocketAddr) {
        let options = self.stream.options();
        let _ = options.set_nonblocking(true);
        let _ = (self.stream).send(format!("busy: it serves {present}\n").as_bytes());
        let _ = options.shutdown(Shutdown::Write);
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

    /// Reads until a host has said something.
    fn heard(device: &mut dyn Line) -> Vec<u8> {
        let mut bytes = [0; 64];
        loop {
            if let Ok(count) = device.read(&mut bytes) {
                return bytes[..count].to_vec();
            }
        }
    }

    #[test]
    fn a_host_that_has_vanished_gives_way_and_one_that_speaks_does_not() {
        for (silence, let_in) in [(Duration::ZERO, true), (Duration::MAX, false)] {
            let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
            listener.set_nonblocking(true).expect("it can");
            let address = listener.local_addr().expect("bound");
            let mut door = Door::new(listener);
            door.silence = silence;
            let mut device = Listening::new(&Arc::new(door));
            let mut first = TcpStream::connect(address).expect("listens");
            first.write_all(b"first").expect("takes it");
            assert_eq!(heard(&mut device), b"first");
            let mut second = TcpStream::connect(address).expect("listens");
            second.write_all(b"second").expect("takes it");
            let mut told = Vec::new();
            if let_in {
                assert_eq!(heard(&mut device), b"second");
                assert!(first.read_to_end(&mut told).is_ok_and(|count| count == 0));
                device.write_all(b"hello").expect("it is there");
                let mut bytes = [0; 5];
                second.read_exact(&mut bytes).expect("comes");
                assert_eq!(&bytes, b"hello");
            } else {
                let reader =
                    std::thread::spawn(move || second.read_to_end(&mut told).map(|_| told));
                while !reader.is_finished() {
                    first.write_all(b"x").expect("takes it");
                    let _ = device.read(&mut [0; 8]);
                }
                let told = reader
                    .join()
                    .expect("no panic")
                    .expect("no reset before the words");
                let first = first.local_addr().expect("bound");
                assert_eq!(told, format!("busy: it serves {first}\n").as_bytes());
            }
        }
    }
}
