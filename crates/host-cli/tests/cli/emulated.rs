//! An emulated device in a process of its own.

use crate::process::{Place, signal};
use serde_json::Value;
use std::process::{Child, Stdio};

/// An emulated device in a place; gone when dropped.
pub(crate) struct Emulated {
    pub(crate) place: Place,
    /// Name of its port in the place.
    link: &'static str,
    child: Child,
}

impl Emulated {
    /// At `device`.
    pub(crate) fn new(options: &str) -> Self {
        Self::at("device", options)
    }

    pub(crate) fn at(link: &'static str, options: &str) -> Self {
        let place = Place::new();
        let child = spawned(&place, link, options);
        Self { place, link, child }
    }

    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    /// Pulls the plug.
    pub(crate) fn kill(&mut self) {
        // The link first: its number is soon that of another device, which whoever waits for this one would take.
        std::fs::remove_file(self.place.path(self.link)).expect("its link");
        self.child.kill().expect("can be killed");
        self.child.wait().expect("ends");
    }

    /// Another one in the place of one that was killed.
    pub(crate) fn plug_in(&mut self, options: &str) {
        self.child = spawned(&self.place, self.link, options);
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
            "device set --device serial:device --force-limit 100N --force-rate-limit 200kN/s --rise-time 0s \
             --start-force 0N --speed-limit 0m/s",
        );
    }

    /// It hangs: its port is there, and it says nothing.
    #[cfg(unix)]
    pub(crate) fn hang(&mut self) {
        signal(&self.child, "STOP");
    }

    pub(crate) fn json(&self, line: &str) -> Value {
        let ended = self.place.run(&format!("{line} --json"));
        ended.succeeded_with_warnings().json()
    }
}

/// The process, when its link is there.
fn spawned(place: &Place, link: &str, options: &str) -> Child {
    let mut command = place.command(&format!("device emulate {options} --link"));
    command.arg(place.path(link)).stdout(Stdio::null());
    let child = command.stderr(Stdio::piped()).spawn().expect("runs");
    place.wait_for(link);
    child
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
