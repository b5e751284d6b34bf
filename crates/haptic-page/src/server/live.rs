//! What a page is shown of the loop: frames of a view, byte by byte as `docs/page-protocol.md` has it, and the status.

use super::hub::Hub;
use crate::feel::{Kept, SAMPLE_TIME, locked};
use crate::pyramid::{Columns, Span};
use haptic_loop::Limiters;
use serde_json::{Value, json};

const MAGIC: u32 = 0x3150_4846;
const HEADER_BYTES: usize = 40;

pub(super) const FRAMES_PER_S: u32 = 60;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LiveView {
    /// The number of its request, which its frames carry.
    pub(super) request: u32,
    pub(super) last: u64,
    pub(super) columns: u32,
}

/// What a page has been shown of the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    /// The tick after the last that was in a frame; `None` before the first frame.
    until: Option<u64>,
    pub(super) sent: u64,
    pub(super) missed: u64,
}

impl Shown {
    /// A frame shows the ticks from `first` to before `end`.
    fn show(&mut self, first: u64, end: u64) {
        // A loop that began anew starts from 0.
        let until = self.until.filter(|&until| until <= end).unwrap_or(first);
        self.missed += first.saturating_sub(until);
        self.sent += end - until.max(first).min(end);
        self.until = Some(end);
    }
}

/// The next frame; `None` as long as nothing is new.
pub(super) fn next_frame(kept: &Kept, view: LiveView, shown: &mut Shown) -> Option<Vec<u8>> {
    let columns = {
        let pyramid = locked(&kept.pyramid);
        let made = pyramid.made();
        if shown.until == Some(made) || made == 0 {
            return None;
        }
        let start = made.saturating_sub(view.last);
        let columns = pyramid.columns(Span::new(start, made, view.columns));
        shown.show(columns.first_tick().min(made), made);
        columns
    };
    Some(frame(view.request, &columns, SAMPLE_TIME.0))
}

/// The frame that answers the request of this number.
pub(super) fn frame(request: u32, columns: &Columns, sample_time_s: f64) -> Vec<u8> {
    let numbers = columns.numbers();
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 * numbers.len());
    // A view has thousands of columns at most, and few channels.
    let (channels, count) = (columns.channels() as u32, columns.count() as u32);
    for word in [MAGIC, request, channels, count] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    let (first, width) = (columns.first_tick() as f64, columns.width() as f64);
    for number in [first, width, sample_time_s] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for number in numbers {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes
}

pub(super) fn status(hub: &Hub, page: u64, shown: &Shown) -> Value {
    let mut status = json!({
        "running": false,
        "armed": false,
        "paused": false,
        "stopped": false,
    });
    if let Some(feel) = hub.feel() {
        let state = locked(&hub.place.kept.state).clone();
        let (made, lost) = feel.counts();
        let kept = locked(&hub.place.kept.pyramid).made();
        let limiters = (0..8).filter(|bit| state.limiter & (1 << bit) != 0);
        let limiters: Vec<&str> = limiters.map(|bit| Limiters::NAMES[bit]).collect();
        status = json!(state);
        for (key, value) in [
            ("running", json!(true)),
            ("sample_time_s", json!(SAMPLE_TIME.0)),
            ("lost", json!(lost)),
            ("limiters", json!(limiters)),
            ("fault", json!(state.fault.map(|fault| fault.to_string()))),
            ("armed", json!(!state.stopping && state.fault.is_none())),
            ("paused", json!(feel.is_paused())),
            ("samples_made", json!(made)),
            ("samples_kept", json!(kept.saturating_sub(lost))),
        ] {
            status[key] = value;
        }
    }
    status["watching"] = json!(hub.watching());
    status["controls"] = json!(hub.has_controls(page));
    status["samples_sent"] = json!(shown.sent);
    status["samples_missed"] = json!(shown.missed);
    json!({"status": status})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::{Pyramid, PyramidSize};

    #[test]
    fn every_sample_was_shown_or_missed() {
        let mut shown = Shown::default();
        shown.show(50, 100);
        // What went before the view is not its own.
        assert_eq!((shown.sent, shown.missed), (50, 0));
        shown.show(60, 130);
        assert_eq!((shown.sent, shown.missed), (80, 0));
        shown.show(200, 300);
        assert_eq!((shown.sent, shown.missed), (180, 70));
        // The loop began anew.
        shown.show(0, 20);
        assert_eq!((shown.sent, shown.missed), (200, 70));
    }

    #[test]
    fn a_frame_is_what_the_protocol_says_byte_by_byte() {
        let mut pyramid = Pyramid::new(PyramidSize {
            channels: 2,
            samples: 8,
            entries: 8,
            coarser: 1,
        });
        for sample in [[1.0, f32::NAN], [-2.0, 5.0], [0.5, f32::NAN]] {
            pyramid.push(&sample);
        }
        let bytes = frame(7, &pyramid.columns(Span::new(0, 4, 2)), 1e-3);
        let mut want = vec![0x46, 0x48, 0x50, 0x31, 7, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0];
        for number in [0.0, 2.0, 1e-3_f64] {
            want.extend(number.to_le_bytes());
        }
        let nan = f32::NAN;
        for number in [-2.0, 0.5, 1.0, 0.5, 5.0, nan, 5.0, nan] {
            want.extend(number.to_le_bytes());
        }
        assert_eq!(bytes, want);
    }
}
