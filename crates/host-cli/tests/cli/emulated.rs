//! An emulated device in a process of its own.

use crate::process::{Place, signal};
use serde_json::Value;
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
    /// A socket.
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
        std::io::Read::read_to_string(&mut stderr, &mut said).expect("is text");
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
    let option = match port {
        Port::Socket(_) => "--socket",
        Port::Terminal(_) => "--link",
    };
    let name = port.name();
    let line = format!("device emulate {options} {option} {name}");
    let mut command = place.command(&line);
    command.stdout(Stdio::null());
    let mut child = command.stderr(Stdio::piped()).spawn().expect("runs");
    place.wait_for(name, &mut child);
    child
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
