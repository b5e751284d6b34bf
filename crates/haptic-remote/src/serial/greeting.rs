//! The first words on a port: finds the speed of a board, and waits for a port that is slow.
//!
//! - *Slow*: QEMU looks for somebody at its pseudo-terminal once a second and throws away what it has to say before;
//!   some boards start anew when their port is opened. So a hello is sent again for [`GREETING`].
//! - *Speed*: where none is asked for, the speeds of [`BAUDS`] take turns.

use super::error::SerialError;
use super::line::Line;
use super::threads::write;
use crate::{Conversation, Incoming, LinkError};
use haptic_link::{FRAME_MAX, Hello, Report, Request};
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher as _, Hasher as _};
use std::io::ErrorKind;
use std::time::{Duration, Instant};

/// Speeds that boards have, bits per second; the first is that of a device without a board.
pub const BAUDS: [u32; 2] = [460_800, 921_600];

/// Time to greet a port. After it without an answer, no device is there.
pub const GREETING: Duration = Duration::from_millis(3500);

/// Time to try one speed before the next.
const TURN: Duration = Duration::from_millis(350);

/// Greets until somebody answers; the first answer, and the speed at which it came.
///
/// # Errors
/// No answer, an echo, another version of the protocol; a port that is gone.
pub(super) fn greet(
    port: &mut dyn Line,
    conversation: &mut Conversation,
    bauds: &[u32],
) -> Result<(Hello, u32), SerialError> {
    let began = Instant::now();
    let nonce = RandomState::new().build_hasher().finish() as u32;
    let mut silent = LinkError::Gone;
    for &baud in bauds.iter().cycle() {
        if began.elapsed() >= GREETING {
            break;
        }
        // A port without speeds, as a pseudo-terminal may be, has the only one.
        port.set_baud_rate(baud);
        match take_turn(port, conversation, nonce) {
            Ok(hello) => return Ok((hello, baud)),
            Err(error @ LinkError::NoAnswer { .. }) => silent = error,
            Err(error) => return Err(error.into()),
        }
    }
    Err(silent.into())
}

/// One turn at the speed that is set.
fn take_turn(
    port: &mut dyn Line,
    conversation: &mut Conversation,
    nonce: u32,
) -> Result<Hello, LinkError> {
    let began = Instant::now();
    let now_us = |began: Instant| began.elapsed().as_micros() as u64;
    let mut line = [0; FRAME_MAX];
    // A zero ends what somebody else has begun, or what was sent at another speed.
    let length = conversation.ask(Request::Hello { nonce }, now_us(began), &mut line[1..]);
    send(port, &line[..=length])?;
    let mut bytes = [0; 1024];
    while began.elapsed() < TURN {
        let count = match port.read(&mut bytes) {
            Ok(0) => return Err(LinkError::Gone),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(_) => return Err(LinkError::Gone),
        };
        for &byte in &bytes[..count] {
            if let Some(Incoming::Answer(Report::Hello(hello))) =
                conversation.receive(byte, now_us(began))
            {
                return Ok(hello);
            }
        }
        let length = conversation.due(now_us(began), &mut line)?;
        send(port, &line[..length])?;
    }
    Err(conversation.no_answer())
}

fn send(port: &mut dyn Line, bytes: &[u8]) -> Result<(), LinkError> {
    if write(port, bytes) {
        Ok(())
    } else {
        Err(LinkError::Gone)
    }
}
