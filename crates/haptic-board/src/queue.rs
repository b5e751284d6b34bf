//! Bytes between an interrupt and the main loop.

use core::cell::RefCell;
use critical_section::Mutex;
use heapless::Deque;

/// Bytes that go in at once at most, so that a tick waits for no more than a few.
const PIECE: usize = 16;

/// A queue of up to N bytes that interrupts and the main loop share.
///
/// *Cost*: each call is a critical section of some ten instructions a byte, 16 bytes at most.
///
/// ```
/// use haptic_board::Queue;
///
/// static RECEIVED: Queue<4> = Queue::new();
/// for byte in 1..=5 {
///     RECEIVED.push(byte); // an interrupt has received it
/// }
/// assert_eq!((RECEIVED.pop(), RECEIVED.room()), (Some(1), 1));
/// assert_eq!(RECEIVED.take_lost(), 1); // the fifth found no room
/// ```
#[derive(Debug)]
pub struct Queue<const N: usize>(Mutex<RefCell<Bytes<N>>>);

#[derive(Debug)]
struct Bytes<const N: usize> {
    waiting: Deque<u8, N>,
    lost: u32,
}

impl<const N: usize> Bytes<N> {
    fn push(&mut self, byte: u8) {
        if self.waiting.push_back(byte).is_err() {
            self.lost = self.lost.wrapping_add(1);
        }
    }
}

impl<const N: usize> Queue<N> {
    /// A queue without bytes, and none lost, for a static.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Bytes {
            waiting: Deque::new(),
            lost: 0,
        })))
    }

    fn with<R>(&self, user: impl FnOnce(&mut Bytes<N>) -> R) -> R {
        critical_section::with(|token| user(&mut self.0.borrow_ref_mut(token)))
    }

    /// Takes a byte in. A byte that does not fit is lost and counted.
    pub fn push(&self, byte: u8) {
        self.with(|queue| queue.push(byte));
    }

    /// Adds several bytes, each as [`push`](Self::push) does.
    pub fn extend(&self, bytes: &[u8]) {
        for piece in bytes.chunks(PIECE) {
            self.with(|queue| piece.iter().for_each(|&byte| queue.push(byte)));
        }
    }

    /// Takes the oldest byte out; `None` if nothing waits.
    pub fn pop(&self) -> Option<u8> {
        self.with(|queue| queue.waiting.pop_front())
    }

    /// Offers the oldest byte to a function, and removes it only if that returns true. If it is
    /// empty, nothing is called. Returns whether a byte was removed.
    pub fn offer(&self, taken: impl FnOnce(u8) -> bool) -> bool {
        self.with(|queue| {
            let Some(&byte) = queue.waiting.front() else {
                return false;
            };
            if taken(byte) {
                queue.waiting.pop_front();
            }
            true
        })
    }

    /// Number of bytes that still fit.
    #[must_use]
    pub fn room(&self) -> usize {
        self.with(|queue| N - queue.waiting.len())
    }

    /// Reports bytes that the hardware lost before they arrived here.
    pub fn count_lost(&self, bytes: u32) {
        self.with(|queue| queue.lost = queue.lost.wrapping_add(bytes));
    }

    /// Number of bytes lost since the last call.
    pub fn take_lost(&self) -> u32 {
        self.with(|queue| core::mem::take(&mut queue.lost))
    }
}

impl<const N: usize> Default for Queue<N> {
    fn default() -> Self {
        Self::new()
    }
}
