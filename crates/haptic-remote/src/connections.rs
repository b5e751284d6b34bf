//! Connections: whose frames a device acts on.
//!
//! - *Offered* with each hello: a number that nobody has had. A hello changes nothing else, so replaying one does
//!   nothing.
//! - *Current* from the first frame that carries it. Frames of any other are a stranger's.
//! - *Owner* is the connection that armed: only its frames feed the watchdog, start runs, and are forces.
//!
//! A number hashes the boot number, the times of all hellos since in µs and the hosts' nonces: one of an earlier boot
//! comes again by chance alone, once in 4·10⁹. It keeps off replayed and lost frames, not somebody who listens and
//! answers.

use haptic_link::{Header, RequestTracker};

#[derive(Debug, PartialEq, Eq)]
pub(super) enum Arrived {
    /// Request to be acted on; the first of its connection, or a later one.
    New {
        first: bool,
    },
    Old,
    /// Request of a connection that the device does not know.
    Stranger,
}

/// The connections that a device knows, by their numbers; 0 stands for no connection.
#[derive(Debug)]
pub(super) struct Connections {
    pool: u32,
    nonce: u32,
    offered: u32,
    pub current: u32,
    owner: u32,
    pub tracker: RequestTracker,
    pub strangers: u32,
}

impl Connections {
    pub(super) const fn new(boot: u32) -> Self {
        Self {
            pool: boot,
            nonce: 0,
            offered: 0,
            current: 0,
            owner: 0,
            tracker: RequestTracker::NEW,
            strangers: 0,
        }
    }

    /// The number for a hello at this time. One that is sent again before another comes gets the same.
    pub(super) fn offer(&mut self, nonce: u32, now_us: u64) -> u32 {
        if self.offered == 0 || nonce != self.nonce {
            for word in [nonce, now_us as u32, (now_us >> 32) as u32] {
                self.pool = mixed(self.pool ^ word);
            }
            while [0, self.offered, self.current, self.owner].contains(&self.pool) {
                self.pool = mixed(self.pool);
            }
            (self.nonce, self.offered) = (nonce, self.pool);
        }
        self.offered
    }

    pub(super) fn arrive(&mut self, header: Header) -> Arrived {
        let number = header.connection;
        let first = number != self.current;
        if number == 0 || (first && number != self.offered) {
            self.strangers = self.strangers.wrapping_add(1);
            return Arrived::Stranger;
        }
        if first {
            self.current = number;
            self.tracker.restart();
        }
        if self.tracker.is_new(header.sequence) {
            Arrived::New { first }
        } else {
            Arrived::Old
        }
    }

    /// The current connection has armed the device.
    pub(super) const fn claim(&mut self) {
        self.owner = self.current;
    }

    /// True if the current connection armed the device.
    pub(super) const fn is_owner(&self) -> bool {
        self.owner != 0 && self.owner == self.current
    }
}

/// Spreads the bits of a word, one to one: `MurmurHash3`'s finaliser (A. Appleby, 2011) behind the step of
/// `SplitMix`.
const fn mixed(word: u32) -> u32 {
    let word = word.wrapping_add(0x9e37_79b9);
    let word = (word ^ (word >> 16)).wrapping_mul(0x85eb_ca6b);
    let word = (word ^ (word >> 13)).wrapping_mul(0xc2b2_ae35);
    word ^ (word >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_differ_at_each_hello_and_after_a_reset() {
        let mut seen = std::collections::BTreeSet::new();
        // Hosts without any chance, all greeting at the same time after a reset: the boot number differs.
        for boot in 0..100 {
            let mut connections = Connections::new(boot);
            for hello in 0..100 {
                let number = connections.offer(hello & 1, 1000);
                assert!(number != 0 && seen.insert(number), "boot {boot}, {hello}");
            }
        }
        // A boot number that came again: the time of the hello differs by a microsecond.
        let offer = |now_us| Connections::new(7).offer(5, now_us);
        assert!(seen.insert(offer(1)) && seen.insert(offer(2)));
        // Sent again because the answer was lost.
        let mut connections = Connections::new(1);
        assert_eq!(connections.offer(5, 1), connections.offer(5, 150_000));
    }

    #[test]
    fn a_hello_changes_nothing_until_its_number_is_used() {
        let mut connections = Connections::new(1);
        let first = connections.offer(1, 10);
        let header = |sequence, connection| Header::from_host(sequence, connection);
        assert_eq!(connections.arrive(header(0, 0)), Arrived::Stranger);
        assert_eq!(
            connections.arrive(header(7, first)),
            Arrived::New { first: true }
        );
        connections.claim();
        let second = connections.offer(2, 20);
        assert_eq!(
            connections.arrive(header(8, first)),
            Arrived::New { first: false }
        );
        assert_eq!(connections.arrive(header(8, first)), Arrived::Old);
        assert!(connections.is_owner());
        assert_eq!(
            connections.arrive(header(0, second)),
            Arrived::New { first: true }
        );
        assert!(!connections.is_owner());
        assert_eq!(connections.arrive(header(9, first)), Arrived::Stranger);
        assert_eq!(connections.strangers, 2);
    }
}
