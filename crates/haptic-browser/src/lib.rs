#![doc = include_str!("../README.md")]

use haptic_answer::alone::{Alone, ToPage};
use std::cell::RefCell;

/// The server, and the message that goes in or out.
#[derive(Default)]
struct Desk {
    server: Option<Alone>,
    message: Vec<u8>,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

fn with<T>(work: impl FnOnce(&mut Desk) -> T) -> T {
    DESK.with_borrow_mut(work)
}

/// Does something with the server and the text of the message that came in.
fn heard(work: impl FnOnce(&mut Desk, String)) {
    with(|desk| {
        let message = std::mem::take(&mut desk.message);
        // The worker writes UTF-8; anything else is refused as no request.
        work(desk, String::from_utf8_lossy(&message).into_owned());
    });
}

/// Exports functions under their names.
macro_rules! exported {
    ($($(#[$doc:meta])* fn $name:ident($($given:ident: $type:ty)?) $(-> $out:ty)? $body:block)*) => { $(
        $(#[$doc])*
        #[expect(unsafe_code, reason = "the name of an export, which no other symbol has")]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($given: $type)?) $(-> $out)? $body
    )* };
}

exported! {
    /// Room for a message of so many bytes that comes in.
    fn room(bytes: usize) -> *mut u8 {
        with(|desk| {
            desk.message = vec![0; bytes];
            desk.message.as_mut_ptr()
        })
    }

    /// Begins: the message is the day, as 2026-12-01.
    fn begin() {
        heard(|desk, day| desk.server = Alone::new(day).ok());
    }

    /// The message is a request.
    fn hear() {
        heard(|desk, text| if let Some(server) = &mut desk.server { server.hear(&text); });
    }

    /// The message that was put in acknowledges frames.
    fn hear_bytes() {
        with(|desk| if let Some(server) = &mut desk.server { server.hear_bytes(&desk.message); });
    }

    /// Goes on until this time, ms.
    fn advance(now_ms: f64) {
        with(|desk| if let Some(server) = &mut desk.server { server.advance(now_ms); });
    }

    /// Answers a question of a panel, if one waits: 1, else 0.
    fn work() -> u32 {
        with(|desk| u32::from(desk.server.as_mut().is_some_and(Alone::work)))
    }

    /// Takes the next message out: 1 for a text, 2 for a frame, 0 without one.
    fn take() -> u32 {
        with(|desk| {
            let (kind, message) = match desk.server.as_mut().and_then(Alone::next_message) {
                None => (0, Vec::new()),
                Some(ToPage::Text(text)) => (1, text.into_bytes()),
                Some(ToPage::Frame(bytes)) => (2, bytes),
            };
            desk.message = message;
            kind
        })
    }

    /// The place of the message that was taken out.
    fn taken() -> *const u8 {
        with(|desk| desk.message.as_ptr())
    }

    /// Length of that message in bytes.
    fn taken_bytes() -> usize {
        with(|desk| desk.message.len())
    }
}
