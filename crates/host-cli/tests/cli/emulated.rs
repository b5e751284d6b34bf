//! An emulated device in a process of its own.

use crate::process::{Place, signal};
use serde_json::Value;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixListener;
use std::path::PathBuf;
use std::process::{Child, Stdio};

/// An emulated device in a place; gone when dropped.
pub(crate) struct Emulated {
    pub(crate) place: Place,
    port: Port,
    child: Child,
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
    /// At the socket `device`.
    pub(crate) fn new(options: &str) -> Self {
        Self::at(Port::Socket("device"), options)
    }

    /// At a pseudo-terminal, for tests whose subject is the port, and for hosts that know no other.
    pub(crate) fn at_terminal(name: &'static str, options: &str) -> Self {
        Self::at(Port::Terminal(name), options)
    }

    fn at(port: Port, options: &str) -> Self {
        let place = Place::new();
        let child = spawned(&place, port, options);
        Self { place, port, child }
    }

    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    /// Pulls the plug.
    pub(crate) fn kill(&mut self) {
        // Its name first: the number of a terminal is soon that of another device, which whoever waits for this one would take.
        std::fs::remove_file(self.place.path(self.port.name())).expect("its name");
        self.child.kill().expect("can be killed");
        self.child.wait().expect("ends");
    }

    /// Until something of this name is there.
    pub(crate) fn wait_for(&mut self, name: &str) {
        self.place.wait_for(name, &mut self.child);
    }

    /// Another one in the place of one that was killed.
    pub(crate) fn plug_in(&mut self, options: &str) {
        self.child = spawned(&self.place, self.port, options);
    }

    /// Stops it as Ctrl-C does; what it said at the end.
    pub(crate) fn ends(&mut self) -> String {
        signal(&self.child, "INT");
        let mut said = String::new();
        let mut stderr = self.child.stderr.take().expect("piped");
        stderr.read_to_string(&mut said).expect("is text");
        said
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
        signal(&self.child, "STOP");
    }

    pub(crate) fn json(&self, line: &str) -> Value {
        let ended = self.place.run(&format!("{line} --json"));
        ended.succeeded_with_warnings().json()
    }
}

/// The process, when its port is there.
fn spawned(place: &Place, port: Port, options: &str) -> Child {
    let mut words = options.to_owned();
    match port {
        Port::Terminal(name) => words += &format!(" --link {name}"),
        Port::Socket(_) => {
            words = words.replace("--facing white", "--facing 127.0.0.1:0");
            words += " --listen 127.0.0.1:0 --json";
        }
    }
    let mut command = place.command(&format!("device emulate {words}"));
    command.stderr(Stdio::piped()).stdout(match port {
        Port::Terminal(_) => Stdio::null(),
        Port::Socket(_) => Stdio::piped(),
    });
    let mut child = command.spawn().expect("runs");
    if let Port::Socket(name) = port {
        let stdout = child.stdout.as_mut().expect("piped");
        let told = serde_json::Deserializer::from_reader(stdout)
            .into_iter()
            .next();
        let told: Value = told.expect("it says where it is").expect("JSON");
        for (name, path) in [(name, &told["path"]), ("white", &told["facing"]["path"])] {
            if let Some(address) = path.as_str().and_then(|path| path.strip_prefix("tcp:")) {
                relays(place.path(name), address.to_owned());
            }
        }
    }
    place.wait_for(port.name(), &mut child);
    child
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

impl Drop for Emulated {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
