//! The live view of a page: frames as they are due, and what of the loop they have shown.

use crate::feel::{Kept, SAMPLE_TIME, locked};
use crate::frame::frame;
use crate::pyramid::Span;

/// Frames of a live view in a second, at most.
pub(super) const FRAMES_PER_S: u32 = 60;

/// A view that goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LiveView {
    /// The number of its request, which its frames carry.
    pub(super) request: u32,
    /// Ticks of it.
    pub(super) last: u64,
    pub(super) columns: u32,
}

/// What a page has been shown of the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    /// The tick after the last that was in a frame; `None` before the first frame.
    until: Option<u64>,
    /// Samples that were in a frame.
    pub(super) sent: u64,
    /// Samples that passed by.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_was_shown_or_missed() {
        let mut shown = Shown::default();
        shown.show(50, 100);
        assert_eq!(
            (shown.sent, shown.missed),
            (50, 0),
            "what went before the view is not its own"
        );
        shown.show(60, 130);
        assert_eq!((shown.sent, shown.missed), (80, 0));
        shown.show(200, 300);
        assert_eq!((shown.sent, shown.missed), (180, 70));
        // The loop began anew.
        shown.show(0, 20);
        assert_eq!((shown.sent, shown.missed), (200, 70));
    }
}
