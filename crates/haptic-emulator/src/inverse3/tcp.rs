//! The service at a port, in real time.

use super::{connection::Connection, service::Service};
use crate::{AtLine as _, at_line::NOBODY};
use haptic_loop::realtime::Moment;
use std::{
    io::{ErrorKind, Read as _, Result, Write as _},
    net::{TcpListener, TcpStream},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// Longest wait of a read: the service advances at least once in this time.
const PATIENCE: Duration = Duration::from_millis(20);

/// Serves whoever connects, each on a thread, until it is stopped or its time is over.
///
/// # Errors
/// In the words of the system: a port of which it takes no connections any more.
pub fn serve(
    listener: &TcpListener,
    service: &Arc<Mutex<Service>>,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<()> {
    listener.set_nonblocking(true)?;
    let began = Moment::now();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let taken = loop {
            let is_late = duration.is_some_and(|most| began.elapsed() >= most);
            if stop.load(Ordering::Relaxed) || is_late {
                break Ok(());
            }
            match listener.accept() {
                Ok((stream, _)) => {
                    let (service, over) = (Arc::clone(service), &over);
                    // Whoever goes has gone: the others stay.
                    scope.spawn(move || talk(stream, Connection::new(service), began, over));
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::sleep(NOBODY),
                Err(error) => break Err(error),
            }
        };
        over.store(true, Ordering::Relaxed);
        taken
    })
}

fn talk(
    mut stream: TcpStream,
    mut connection: Connection,
    began: Moment,
    over: &AtomicBool,
) -> Result<()> {
    // On some systems it is as its listener.
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut bytes = [0; 4096];
    let mut answer = Vec::new();
    while !over.load(Ordering::Relaxed) && !connection.is_over() {
        let count = match stream.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => 0,
            Err(error) => return Err(error),
        };
        let now_us = began.elapsed().as_micros() as u64;
        connection.advance(now_us);
        for &byte in &bytes[..count] {
            connection.receive(byte, now_us, &mut answer);
        }
        stream.write_all(&answer)?;
        answer.clear();
    }
    Ok(())
}
