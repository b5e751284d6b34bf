//! An emulated Inverse Service for its maker's client.

use haptic_emulator::inverse3::{Body, Hand, Service, serve};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;

/// Number of the device.
pub const ID: &str = "04BA";

/// A service at a free port of this machine, until it is dropped.
#[derive(Debug)]
pub struct Running {
    /// The port.
    pub address: SocketAddr,
    service: Arc<Mutex<Service>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    /// Service with one device that nobody holds.
    pub fn start() -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let address = listener.local_addr().expect("an address");
        let devices = [(ID.to_owned(), Body::held_by(Hand::Free))];
        let service = Arc::new(Mutex::new(Service::new("3.5.0", devices)));
        let stop = Arc::new(AtomicBool::new(false));
        let (serving, stopping) = (Arc::clone(&service), Arc::clone(&stop));
        let thread = std::thread::spawn(move || {
            serve(&listener, &serving, None, &stopping).expect("serves");
        });
        Self {
            address,
            service,
            stop,
            thread: Some(thread),
        }
    }

    /// The service itself.
    pub fn service(&self) -> MutexGuard<'_, Service> {
        self.service.lock().expect("nobody panicked with it")
    }

    /// Its address for HTTP.
    pub fn http(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Its address for a WebSocket.
    pub fn ws(&self) -> String {
        format!("ws://{}/", self.address)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
