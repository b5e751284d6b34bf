//! What the device hears, judged beside it.

use haptic_link::{DeviceReport, Direction, Header, Outcome, Receiver, Request, RequestTracker};

/// Who may feed the watchdog, by what device and host say to each other.
pub(crate) struct Mirror {
    requests: Receiver<Request>,
    reports: Receiver<DeviceReport>,
    tracker: RequestTracker,
    connection: u32,
    /// Connection of the host that armed.
    pub(crate) owner: u32,
}

impl Mirror {
    pub(crate) fn new() -> Self {
        Self {
            requests: Receiver::new(Direction::FromHost),
            reports: Receiver::new(Direction::FromDevice),
            tracker: RequestTracker::NEW,
            connection: 0,
            owner: 0,
        }
    }

    /// The request that this byte ended, if it is a new one of its connection.
    pub(crate) fn new_request(&mut self, byte: u8) -> Option<(Header, Request)> {
        let (header, request) = self.requests.push(byte)?;
        if matches!(request, Request::Hello { .. }) {
            return None;
        }
        if header.connection != self.connection {
            self.connection = header.connection;
            self.tracker.restart();
        }
        self.tracker
            .is_new(header.sequence)
            .then_some((header, request))
    }

    /// Whether the device has done this arm.
    pub(crate) fn has_armed(&mut self, request: &Request, answer: &[u8]) -> bool {
        let message = answer.iter().find_map(|&byte| self.reports.push(byte));
        let done =
            matches!(message, Some((_, DeviceReport::Ack(ack))) if ack.outcome == Outcome::Done);
        done && matches!(request, Request::Arm { .. })
    }
}
