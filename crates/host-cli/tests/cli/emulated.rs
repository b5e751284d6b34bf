//! An emulated device in a process of its own.

use crate::process::{Place, signal};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixListener;
use std::path::PathBuf;
use std::process::{Child, Stdio};

/// An emulator in a process of its own, and what it says at its start; gone when dropped.
pub(crate) struct Emulator {
    pub(crate) child: Child,
    pub(crate) announced: Value,
}

impl Emulator {
    pub(crate) fn start(place: &Place, options: &str) -> Self {
        let mut command = place.command(&format!("device emulate {options} --json"));
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = piped.spawn().expect("runs");
        let mut line = String::new();
        let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
        stdout.read_line(&mut line).expect("is text");
        let announced = serde_json::from_str(&line).expect("JSON");
        Self { child, announced }
    }

    /// The device's name for other commands.
    pub(crate) fn name(&self) -> &str {
        self.announced["device"].as_str().expect("a name")
    }

    /// Its address, without a scheme.
    pub(crate) fn address(&self) -> &str {
        let path = self.announced["path"].as_str().expect("a path");
        path.strip_prefix("tcp:").unwrap_or(path)
    }

    /// Stops it as Ctrl-C does; what it said at the end.
    pub(crate) fn ends(&mut self) -> String {
        signal(&self.child, "INT");
        let mut message = String::new();
        let mut stderr = self.child.stderr.take().expect("piped");
        stderr.read_to_string(&mut message).expect("is text");
        message
    }

    fn kill(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.kill();
    }
}

/// An emulated device in a place; gone when dropped.
pub(crate) struct Emulated {
    pub(crate) place: Place,
    port: Port,
    emulator: Emulator,
}

/// The name of its port in the place.
#[derive(Clone, Copy)]
enum Port {
    /// A socket that stands for the TCP address at which it listens.
    Socket(&'static str),
    /// A pseudo-terminal: a port as real ones are. Its bytes pass through a worker of the system, for which a busy machine may let
    /// them wait for seconds.
    Terminal(&'static str),
}

impl Port {
    const fn name(self) -> &'static str {
        let (Self::Socket(name) | Self::Terminal(name)) = self;
        name
    }
}

impl Emulated {
    /// Device at the socket `device`.
    pub(crate) fn new(options: &str) -> Self {
        Self::at(Port::Socket("device"), options)
    }

    /// Device at a pseudo-terminal, for tests whose subject is the port, and for hosts that know no other.
    pub(crate) fn at_terminal(name: &'static str, options: &str) -> Self {
        Self::at(Port::Terminal(name), options)
    }

    fn at(port: Port, options: &str) -> Self {
        let place = Place::new();
        let emulator = spawned(&place, port, options);
        Self {
            place,
            port,
            emulator,
        }
    }

    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    /// Pulls the plug.
    pub(crate) fn kill(&mut self) {
        // Its name first: the number of a terminal is soon that of another device, which whoever waits for this one would take.
        std::fs::remove_file(self.place.path(self.port.name())).expect("its name");
        self.emulator.kill();
    }

    /// Until something of this name is there.
    pub(crate) fn wait_for(&mut self, name: &str) {
        self.place.wait_for(name, &mut self.emulator.child);
    }

    /// Another one in the place of one that was killed.
    pub(crate) fn plug_in(&mut self, options: &str) {
        self.emulator = spawned(&self.place, self.port, options);
    }

    pub(crate) fn ends(&mut self) -> String {
        self.emulator.ends()
    }

    /// Limits that no experiment here reaches.
    pub(crate) fn loosen(&self) {
        self.json(
            "device set --device serial:device force_limit=100N force_rate_limit=200kN/s rise_time=0s \
             start_force=0N speed_limit=0m/s",
        );
    }

    /// It hangs: its port is there, and it says nothing.
    pub(crate) fn hang(&mut self) {
        signal(&self.emulator.child, "STOP");
    }

    pub(crate) fn json(&self, line: &str) -> Value {
        let ended = self.place.run(&format!("{line} --json"));
        ended.succeeded_with_warnings().json()
    }
}

/// The emulator, when its port is there.
fn spawned(place: &Place, port: Port, options: &str) -> Emulator {
    let Port::Socket(name) = port else {
        return Emulator::start(place, &format!("{options} --link {}", port.name()));
    };
    let options = options.replace("--facing white", "--facing 127.0.0.1:0");
    let emulator = Emulator::start(place, &format!("{options} --listen 127.0.0.1:0"));
    let facing = emulator.announced["facing"]["path"].as_str();
    let facing = facing.map(|path| ("white", path.replacen("tcp:", "", 1)));
    for (name, address) in [(name, emulator.address().to_owned())]
        .into_iter()
        .chain(facing)
    {
        relays(place.path(name), address);
    }
    emulator
}

/// A socket before an address, whose name no other test can have.
fn relays(path: PathBuf, address: String) {
    // That of a device that was pulled.
    let _ = std::fs::remove_file(&path);
    let listener = UnixListener::bind(path).expect("a socket");
    std::thread::spawn(move || {
        while let Ok((host, _)) = listener.accept() {
            // Without a device the host is alone.
            let Ok(device) = TcpStream::connect(&address) else {
                continue;
            };
            device.set_nodelay(true).expect("a socket");
            let ends = (host.try_clone(), device.try_clone());
            let (from_host, from_device) = (ends.0.expect("a handle"), ends.1.expect("a handle"));
            std::thread::spawn(move || {
                each(from_host, &device);
                // What it still says is read, so that nothing is cut off that it has yet to hear.
                let _ = device.shutdown(Shutdown::Write);
            });
            std::thread::spawn(move || {
                each(from_device, &host);
                let _ = host.shutdown(Shutdown::Both);
            });
        }
    });
}

/// Passes on what comes, to its end; whoever is gone does not hear it.
fn each(mut from: impl Read, mut to: impl Write) {
    let mut bytes = [0; 4096];
    loop {
        match from.read(&mut bytes) {
            Ok(count @ 1..) => drop(to.write_all(&bytes[..count])),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => return,
        }
    }
}
