//! View of the loop for a page: frames, byte by byte as `docs/page-protocol.md` has it, and the status.
//!
//! A frame holds the columns that are new since the newest frame that the page has acknowledged. So a frame that the page never
//! saw is made up for by the next, and a page far behind gets all that it has missed at once, at the width of the picture.

use crate::channels::places;
use crate::hello::COLUMNS_MOST;
use crate::pyramid::{Pyramid, ViewColumns, ViewSpan};
use crate::request::ViewRequest;
use haptic_document::Failure;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const MAGIC: u32 = 0x3250_4846;
const HEADER_BYTES: usize = 52;

/// Frames of a live view in a second, at most.
pub const FRAMES_PER_S: u32 = 60;

/// Bytes on their way to a page, at which it gets no further frame until it has acknowledged some: 65 ms of a line of 0.5 MB/s.
/// Buffers along the line would take megabytes, and the page would see what happened seconds ago.
const ON_THE_WAY: usize = 32 << 10;

/// A view of the newest of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveView {
    /// The number of its request, which its frames carry.
    pub request: u32,
    /// Length of the picture, s.
    pub last_s: f64,
    /// Columns of the picture, about.
    pub columns: u32,
}

#[derive(Clone, Copy, Debug)]
struct SentFrame {
    number: u32,
    bytes: usize,
    /// The loop that it shows, as the pyramid counts them.
    begun: u64,
    /// The tick after the last that it shows.
    end: u64,
    /// Ticks of its columns; columns of another width do not go into the same picture.
    width: u64,
}

/// The live view of a page, if it has one.
#[derive(Debug, Default)]
pub struct LivePicture {
    view: Option<LiveView>,
    newest: Option<SentFrame>,
    /// The newest frame that the page has acknowledged.
    seen: Option<SentFrame>,
    /// Those after it, oldest first.
    on_the_way: VecDeque<SentFrame>,
    /// Samples in frames, and those left out because the page was behind by more than its view is long.
    sent: u64,
    missed: u64,
    acknowledged: Acknowledged,
}

/// The newest frame that a page says it has, with the number of its request in the upper half: from the task that reads.
#[derive(Clone, Debug, Default)]
pub struct Acknowledged(Arc<AtomicU64>);

impl Acknowledged {
    /// Takes the bytes of an acknowledgement; false if their number is wrong.
    pub fn take(&self, bytes: &[u8]) -> bool {
        // The request comes first, so it is in the lower half.
        let numbers = bytes
            .try_into()
            .map(|bytes| u64::from_le_bytes(bytes).rotate_left(32));
        let store = |numbers| self.0.store(numbers, Ordering::Relaxed);
        numbers.map(store).is_ok()
    }
}

impl LivePicture {
    /// No view yet.
    pub fn new(acknowledged: Acknowledged) -> Self {
        Self {
            acknowledged,
            ..Self::default()
        }
    }

    /// Begins another view with a whole picture, or ends this one.
    pub fn show(&mut self, view: Option<LiveView>) {
        *self = Self {
            view,
            ..Self::new(self.acknowledged.clone())
        };
    }

    /// True with a view.
    pub const fn is_on(&self) -> bool {
        self.view.is_some()
    }

    fn hear(&mut self, view: LiveView) {
        let acknowledged = self.acknowledged.0.load(Ordering::Relaxed);
        if acknowledged >> 32 != u64::from(view.request) {
            return;
        }
        while let Some(frame) = self.on_the_way.front()
            && u64::from(frame.number) <= acknowledged & u64::from(u32::MAX)
        {
            self.seen = self.on_the_way.pop_front();
        }
    }

    /// The next frame; `None` as long as nothing is new, or too much is on its way.
    pub fn next_frame(&mut self, pyramid: &Pyramid, sample_time_s: f64) -> Option<Vec<u8>> {
        let view = self.view?;
        self.hear(view);
        if self
            .on_the_way
            .iter()
            .map(|frame| frame.bytes)
            .sum::<usize>()
            >= ON_THE_WAY
        {
            return None;
        }
        let last = (view.last_s / sample_time_s - 1e-9).ceil().min(1e15) as u64;
        let (made, begun) = (pyramid.made(), pyramid.begun());
        let of_this_loop = |frame: &SentFrame| frame.begun == begun;
        let until = self.newest.filter(of_this_loop).map(|frame| frame.end);
        if made == 0 || until == Some(made) {
            return None;
        }
        let start = made.saturating_sub(last);
        // As wide in the first second of a loop as later, so that increments fit.
        let span = ViewSpan::new(start, start + last, view.columns);
        let increment = self.seen.filter(of_this_loop).and_then(|seen| {
            let columns = pyramid.columns(span.since(seen.end));
            (columns.width == seen.width).then_some(columns)
        });
        let is_whole = increment.is_none();
        let columns = increment.unwrap_or_else(|| pyramid.columns(span));
        // One whole picture at a time: others continue it.
        let goes_on = |frame: &SentFrame| of_this_loop(frame) && frame.width == columns.width;
        if is_whole && self.on_the_way.iter().any(goes_on) {
            return None;
        }
        let picture = if is_whole {
            columns.first_tick
        } else {
            start / columns.width * columns.width
        };
        let until = until.unwrap_or(start);
        self.missed += start.saturating_sub(until);
        self.sent += made - until.max(start);
        let number = self.newest.map_or(1, |frame| frame.number + 1);
        let bytes = framed(view.request, number, picture, &columns, sample_time_s);
        let frame = SentFrame {
            number,
            bytes: bytes.len(),
            begun,
            end: made,
            width: columns.width,
        };
        self.newest = Some(frame);
        self.on_the_way.push_back(frame);
        Some(bytes)
    }

    /// Time by which the page is known to be behind the loop, s.
    fn late_s(&mut self, pyramid: &Pyramid, sample_time_s: f64) -> f64 {
        if let Some(view) = self.view {
            self.hear(view);
        }
        let Some(waiting) = self.on_the_way.front() else {
            return 0.0;
        };
        let seen = self.seen.filter(|seen| seen.begun == waiting.begun);
        let behind = pyramid.made().saturating_sub(seen.unwrap_or(*waiting).end);
        behind as f64 * sample_time_s
    }

    /// Adds to a status what was sent, and how late it is.
    pub fn add_to(&mut self, status: &mut Value, pyramid: &Pyramid, sample_time_s: f64) {
        status["samples_sent"] = json!(self.sent);
        status["samples_missed"] = json!(self.missed);
        status["picture_late_s"] = json!(self.late_s(pyramid, sample_time_s));
    }
}

/// The frame that answers the request of this number, once.
pub fn frame(request: u32, columns: &ViewColumns, sample_time_s: f64) -> Vec<u8> {
    framed(request, 0, columns.first_tick, columns, sample_time_s)
}

/// The frame with this number of a request, whose picture begins at the tick `picture`.
fn framed(
    request: u32,
    number: u32,
    picture: u64,
    columns: &ViewColumns,
    sample_time_s: f64,
) -> Vec<u8> {
    let numbers = &columns.numbers;
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 * numbers.len());
    // A view has thousands of columns at most, and few channels.
    let (channels, count) = (columns.channels as u32, columns.count as u32);
    for word in [MAGIC, request, channels, count] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    let (first, width) = (columns.first_tick as f64, columns.width as f64);
    for value in [first, width, sample_time_s, picture as f64] {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    bytes.extend_from_slice(&number.to_le_bytes());
    for value in numbers {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// The answer to a view of the loop: one frame, or those that follow.
#[derive(Debug)]
pub enum ShownLoop {
    /// One frame, which is the whole answer.
    Frame(Vec<u8>),
    /// The live view, which sends frames until another is asked for.
    Live(LiveView),
}

impl ViewRequest {
    /// The number of a view, which its frames carry.
    ///
    /// # Errors
    /// Another `id`; a wrong number of columns.
    pub fn number(&self, id: &Value) -> Result<u32, Failure> {
        // Its frames carry the number in four bytes.
        let Some(number) = id.as_u64().and_then(|id| u32::try_from(id).ok()) else {
            return Err(Failure::bad_input(format_args!(
                "the `id` {id} of a view is not a whole number below 2^32: its frames carry it"
            )));
        };
        if !(1..=COLUMNS_MOST).contains(&self.columns) {
            return Err(Failure::bad_input(format_args!(
                "`columns` = {} is not in [1, {COLUMNS_MOST}]: ask for as many as there are pixels",
                self.columns
            )));
        }
        Ok(number)
    }

    /// Its span among so many samples.
    ///
    /// # Errors
    /// Times that are no numbers, or in the wrong order.
    pub fn span(&self, made: u64, sample_time_s: f64) -> Result<ViewSpan, Failure> {
        let tick = |time_s: Option<f64>, otherwise: u64| match time_s {
            None => Ok(otherwise),
            Some(time_s) if time_s.is_finite() => {
                Ok((time_s / sample_time_s).round().max(0.0) as u64)
            }
            Some(_) => Err(Failure::bad_input("`from_s` and `to_s` have to be numbers")),
        };
        let (from, to) = (tick(self.from_s, 0)?, tick(self.to_s, made)?);
        if from >= to {
            return Err(Failure::bad_input("`from_s` has to be before `to_s`"));
        }
        Ok(ViewSpan::new(from, to, self.columns))
    }

    /// The channels that it asks for, or all of these, with their columns.
    ///
    /// # Errors
    /// A channel that is not there.
    pub fn chosen(
        &self,
        channels: Vec<String>,
        columns: ViewColumns,
    ) -> Result<(Vec<String>, ViewColumns), Failure> {
        Ok(match &self.channels {
            None => (channels, columns),
            Some(wanted) => (wanted.clone(), columns.chosen(&places(wanted, &channels)?)),
        })
    }

    /// A view of the loop.
    ///
    /// # Errors
    /// Channels, which it has all; times in the wrong order.
    pub fn of_loop(&self, request: u32, pyramid: &Pyramid, t: f64) -> Result<ShownLoop, Failure> {
        if self.channels.is_some() {
            return Err(Failure::bad_input(
                "a live view has all channels: omit `channels`",
            ));
        }
        Ok(match self.last_s {
            None => {
                let columns = pyramid.columns(self.span(pyramid.made(), t)?);
                ShownLoop::Frame(frame(request, &columns, t))
            }
            Some(last_s)
                if last_s > 0.0
                    && last_s.is_finite()
                    && self.from_s.is_none()
                    && self.to_s.is_none() =>
            {
                ShownLoop::Live(LiveView {
                    request,
                    last_s,
                    columns: self.columns,
                })
            }
            Some(_) => {
                return Err(Failure::bad_input(
                    "`last_s` has to be a number above 0, without `from_s` and `to_s`",
                ));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::PyramidSize;
    use proptest::prelude::*;

    const VIEW: LiveView = LiveView {
        request: 7,
        last_s: 30.0,
        columns: 600,
    };

    const T: f64 = 1e-3;

    fn pyramid() -> Pyramid {
        Pyramid::new(PyramidSize {
            follows: &[],
            channels: 7,
            samples: 1 << 16,
            entries: 1 << 14,
            coarser: 2,
        })
    }

    fn live(view: LiveView) -> (LivePicture, Acknowledged) {
        let acknowledged = Acknowledged::default();
        let mut live = LivePicture::new(acknowledged.clone());
        live.show(Some(view));
        (live, acknowledged)
    }

    fn number_of(frame: &[u8]) -> [u8; 8] {
        let mut bytes = [0; 8];
        bytes[..4].copy_from_slice(&frame[4..8]);
        bytes[4..].copy_from_slice(&frame[48..52]);
        bytes
    }

    /// The bytes that a minute of a live view sends in a second, and by how much the picture lags at most, ms: over a line of so
    /// many bytes a millisecond, 20 ms long each way, whose buffers take 4 MiB. It looks at no clock.
    fn over_a_line(view: LiveView, bytes_per_ms: f64) -> (usize, u64, f64) {
        let (mut pyramid, (mut live, acknowledged)) = (pyramid(), live(view));
        let (mut sent, mut lag, mut late_s) = (0, 0, 0.0_f64);
        // The page comes when the loop has gone on for longer than it shows.
        (0..40_000).for_each(|_| pyramid.push(&[0.5; 7]));
        let (mut free_ms, mut seen) = (0.0_f64, 0);
        let mut line: VecDeque<(u64, u64, [u8; 8])> = VecDeque::new();
        let mut back = line.clone();
        for now in 0..60_000_u64 {
            pyramid.push(&[now as f32; 7]);
            let fits = (free_ms - now as f64) * bytes_per_ms < f64::from(4 << 20);
            if now % 17 == 0
                && fits
                && let Some(frame) = live.next_frame(&pyramid, T)
            {
                sent += frame.len();
                free_ms = free_ms.max(now as f64) + frame.len() as f64 / bytes_per_ms;
                line.push_back((free_ms as u64 + 20, now + 1, number_of(&frame)));
            }
            while let Some((at, end, number)) = line.front().copied().filter(|it| it.0 <= now) {
                line.pop_front();
                seen = end;
                back.push_back((at + 20, end, number));
            }
            while let Some((.., number)) = back.front().filter(|it| it.0 <= now) {
                assert!(acknowledged.take(number));
                back.pop_front();
            }
            lag = lag.max(now + 1 - seen);
            late_s = late_s.max(live.late_s(&pyramid, T));
        }
        (sent / 60, lag, late_s)
    }

    #[test]
    fn over_half_a_megabyte_a_second_the_picture_lags_by_less_than_0_3_s() {
        // Whole pictures, as they were sent before, lag by 8540 ms here.
        let (bytes_per_s, lag_ms, late_s) = over_a_line(VIEW, 500.0);
        assert!(bytes_per_s < 25_000, "{bytes_per_s} bytes/s");
        assert!(lag_ms <= 300, "{lag_ms} ms");
        assert!(late_s < 0.3, "{late_s} s");
        // As many columns as a large screen has pixels.
        let wide = LiveView {
            columns: 2000,
            ..VIEW
        };
        let (_, lag_ms, _) = over_a_line(wide, 500.0);
        assert!(lag_ms <= 300, "{lag_ms} ms");
    }

    #[test]
    fn a_line_that_is_too_slow_is_told_of_and_never_behind_by_more_than_what_is_on_the_way() {
        let (bytes_per_s, lag_ms, late_s) = over_a_line(VIEW, 5.0);
        assert!(
            bytes_per_s <= 5000 + ON_THE_WAY / 30,
            "{bytes_per_s} bytes/s"
        );
        // Twice what may be on the way: what is, and the frame that then begins.
        assert!(lag_ms < 2 * ON_THE_WAY as u64 / 5, "{lag_ms} ms");
        assert!(late_s >= 1e-3 * lag_ms as f64, "{late_s} s of {lag_ms} ms");
    }

    #[test]
    fn a_page_that_acknowledges_nothing_gets_no_more_than_may_be_on_the_way() {
        let (mut pyramid, (mut live, acknowledged)) = (pyramid(), live(VIEW));
        let mut frames_of = |ticks: u64| -> Vec<Vec<u8>> {
            let next = |_| {
                pyramid.push(&[1.0; 7]);
                live.next_frame(&pyramid, T)
            };
            (0..ticks).filter_map(next).collect()
        };
        let first = frames_of(1000);
        assert_eq!(first.len(), 1, "nothing to go on from");
        // An acknowledgement of another view is not heard, and other bytes are none.
        assert!(acknowledged.take(&[9, 0, 0, 0, 1, 0, 0, 0]));
        assert!(!acknowledged.take(&[1; 7]) && !acknowledged.take(&[1; 9]));
        assert_eq!(frames_of(10).len(), 0);
        assert!(acknowledged.take(&number_of(&first[0])));
        let frames = frames_of(10_000);
        let sent: usize = frames.iter().map(Vec::len).sum();
        assert!(
            (ON_THE_WAY..ON_THE_WAY + 56 * 200).contains(&sent),
            "{sent} bytes"
        );
        // It goes on where the page says that it is, with all that came since.
        assert!(acknowledged.take(&number_of(&frames[frames.len() - 1])));
        let next = frames_of(1).pop().expect("goes on");
        assert!(next.len() > 56 * 100 && live.missed == 0, "{}", next.len());
    }

    /// First ticks of columns, each with its numbers.
    type Picture = Vec<(u64, Vec<f32>)>;

    fn picture(first: u64, width: u64, count: usize, numbers: &[f32]) -> Picture {
        let column_values = |column: usize| numbers.iter().skip(column).step_by(count).copied();
        let ticks = (first..).step_by(width as usize);
        (0..count)
            .zip(ticks)
            .map(|(column, tick)| (tick, column_values(column).collect()))
            .collect()
    }

    proptest! {
        #[test]
        fn increments_over_what_was_acknowledged_make_the_whole_picture(
            steps in prop::collection::vec((1_u64..300, 0_usize..4, 0_u8..20), 1..60),
            last in 1_u64..3000,
            columns in 1_u32..300,
        ) {
            let last_s = last as f64 * 1e-3;
            let view = LiveView { last_s, columns, ..VIEW };
            let (mut pyramid, (mut live, acknowledged)) = (pyramid(), live(view));
            let (mut line, mut seen) = (VecDeque::new(), Picture::new());
            for (ticks, arrive, anew) in steps {
                                if anew == 0 {
                    pyramid.clear();
                }
                (0..ticks).for_each(|tick| pyramid.push(&[(tick * 37 % 101) as f32; 7]));
                let start = pyramid.made().saturating_sub(last);
                let whole = pyramid.columns(ViewSpan::new(start, start + last, columns));
                let whole = picture(whole.first_tick, whole.width, whole.count, &whole.numbers);
                line.extend(live.next_frame(&pyramid, T).map(|frame| (frame, whole)));
                for (frame, whole) in line.drain(..arrive.min(line.len())) {
                    let tick = |at: usize| f64::from_le_bytes(frame[at..at + 8].try_into().expect("8")) as u64;
                    let count = u32::from_le_bytes(frame[12..16].try_into().expect("4")) as usize;
                    let numbers = frame[HEADER_BYTES..].chunks_exact(4);
                    let numbers: Vec<f32> = numbers.map(|four| f32::from_le_bytes(four.try_into().expect("4"))).collect();
                    seen.retain(|column| (tick(40)..tick(16)).contains(&column.0));
                    seen.extend(picture(tick(16), tick(24), count, &numbers));
                    prop_assert!(acknowledged.take(&number_of(&frame)));
                    prop_assert_eq!(&seen, &whole);
                }
            }
        }
    }

    #[test]
    fn every_sample_was_shown_or_missed() {
        let view = LiveView {
            last_s: 0.05,
            ..VIEW
        };
        let (mut pyramid, (mut live, acknowledged)) = (pyramid(), live(view));
        let mut shown = |anew: bool, ticks: u64| {
            if anew {
                pyramid.clear();
            }
            (0..ticks).for_each(|_| pyramid.push(&[0.0; 7]));
            let frame = live.next_frame(&pyramid, T).expect("new");
            assert!(acknowledged.take(&number_of(&frame)));
            (live.sent, live.missed)
        };
        // What went before the view is not its own.
        assert_eq!(shown(false, 100), (50, 0));
        assert_eq!(shown(false, 30), (80, 0));
        assert_eq!(shown(false, 120), (130, 70));
        // The loop began anew, and has already made more than the one before.
        assert_eq!(shown(true, 300), (180, 70));
    }

    #[test]
    fn a_frame_is_what_the_protocol_says_byte_by_byte() {
        let mut pyramid = Pyramid::new(PyramidSize {
            follows: &[],
            channels: 2,
            samples: 8,
            entries: 8,
            coarser: 1,
        });
        for sample in [[1.0, f32::NAN], [-2.0, 5.0], [0.5, f32::NAN]] {
            pyramid.push(&sample);
        }
        let bytes = frame(7, &pyramid.columns(ViewSpan::new(0, 4, 2)), 1e-3);
        let mut want = vec![0x46, 0x48, 0x50, 0x32, 7, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0];
        for number in [0.0, 2.0, 1e-3_f64, 0.0] {
            want.extend(number.to_le_bytes());
        }
        want.extend([0; 4]);
        let nan = f32::NAN;
        for number in [-2.0, 0.5, 1.0, 0.5, 5.0, nan, 5.0, nan] {
            want.extend(number.to_le_bytes());
        }
        assert_eq!(bytes, want);
    }
}
