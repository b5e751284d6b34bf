//! One socket: a task that reads requests and one that writes, so that a page which does not read can still stop.

use super::answer::answer;
use super::hub::{BUSY, Hub};
use super::page::{Outgoing, Page, QUEUE};
use crate::OnClose;
use crate::feel::Comparison;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use haptic_answer::feel::state::idle;
use haptic_answer::live::{Acknowledged, FRAMES_PER_S, LivePicture};
use haptic_answer::request::{self, PageRequest};
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use hyper::body::Bytes;
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{mpsc, watch};
use tokio::time::{MissedTickBehavior, interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Message, Utf8Bytes};

/// Messages in a row that are no requests.
const GARBAGE: u32 = 3;
/// Longest message that is read on the reactor, bytes; a stop is shorter.
const SHORT: usize = 4096;
/// Messages of a page that wait for the answers to those before them. The page is not read beyond.
const WAITING: usize = 16;
/// Time without a sign of the page, after which it is gone.
const SILENCE: Duration = Duration::from_secs(5);
/// Time between two signs that are asked for.
const PING: Duration = Duration::from_secs(1);
const STATUS: Duration = Duration::from_millis(100);
/// Messages of the status of which one is sent without a loop.
const IDLE: u32 = 10;
/// Time for a last word.
const FAREWELL: Duration = Duration::from_secs(1);

pub(super) type WebSocket = WebSocketStream<TokioIo<Upgraded>>;

/// Serves a socket until it is closed. What the page controlled is stopped before all else.
pub(super) async fn serve(stream: WebSocket, hub: Arc<Hub>) {
    let number = hub.enter();
    let (sink, mut source) = stream.split();
    let (out, queue) = mpsc::channel(QUEUE);
    let page = Page::new(number, out);
    let (desk, asked) = mpsc::channel(WAITING);
    let clerk = tokio::spawn(work(asked, Arc::clone(&hub), page.clone()));
    let acknowledged = Acknowledged::default();
    let live = LivePicture::new(acknowledged.clone());
    let writer = tokio::spawn(write(sink, queue, live, Arc::clone(&hub), number));
    let reason = read(&mut source, &acknowledged, &hub, &page, &desk).await;
    drop(desk);
    page.panels.give_up();
    // Not after the writer: a page that does not read would hold it.
    let leaving = tokio::spawn({
        let hub = Arc::clone(&hub);
        async move {
            // All that the page has requested is to continue.
            if hub.options.on_close == OnClose::Continue {
                let _ = clerk.await;
            }
            hub.leave(number).await;
        }
    });
    if let Some((code, reason)) = reason {
        let reason = Utf8Bytes::from_static(reason);
        page.say(Message::Close(Some(CloseFrame { code, reason })));
    }
    drop(page);
    let stop_writer = writer.abort_handle();
    if timeout(FAREWELL, writer).await.is_err() {
        stop_writer.abort();
    }
    if reason.is_some() {
        // The remaining messages are read: a socket closed over unread bytes is reset, and the page would not get the reason.
        let rest = async { while source.next().await.is_some_and(|message| message.is_ok()) {} };
        let _ = timeout(FAREWELL, rest).await;
    }
    // It can only fail by a panic, which has been reported.
    let _ = leaving.await;
}

/// A message that waits for the answers to those before it.
#[expect(clippy::large_enum_variant, reason = "at most sixteen of a page wait")]
enum Asked {
    Read(Result<(Value, PageRequest), (Value, String)>),
    /// It is long, and was not read yet.
    Text(Utf8Bytes),
}

/// The reason, as soon as there is one.
async fn ending(mut reason: watch::Receiver<Option<&'static str>>) -> &'static str {
    let reason = reason.wait_for(Option::is_some).await;
    reason.ok().and_then(|reason| *reason).unwrap_or_default()
}

/// Reads until the end; code and reason, if it is the server that ends it.
async fn read(
    source: &mut SplitStream<WebSocket>,
    acknowledged: &Acknowledged,
    hub: &Arc<Hub>,
    page: &Page,
    desk: &mpsc::Sender<Asked>,
) -> Option<(CloseCode, &'static str)> {
    loop {
        // Other pages are read too before the next message of this one.
        tokio::task::yield_now().await;
        let message = tokio::select! {
            message = timeout(SILENCE, source.next()) => message,
            reason = ending(hub.ending.clone()) => return Some((CloseCode::Away, reason)),
            reason = ending(page.closing.subscribe()) => return Some((CloseCode::Policy, reason)),
            () = page.out.closed() => return None,
        };
        let asked = match message {
            Err(_) => return Some((CloseCode::Policy, "the page was silent for 5 s")),
            Ok(None | Some(Err(_) | Ok(Message::Close(_)))) => return None,
            Ok(Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)))) => continue,
            Ok(Some(Ok(Message::Text(text)))) if text.len() > SHORT => Asked::Text(text),
            Ok(Some(Ok(Message::Text(text)))) => match request::parse(&text) {
                Ok((id, request)) if request.is_urgent() => {
                    obey(id, request, hub, page).await;
                    continue;
                }
                read => Asked::Read(read),
            },
            Ok(Some(Ok(Message::Binary(bytes)))) if acknowledged.take(&bytes) => continue,
            Ok(Some(Ok(Message::Binary(_)))) => Asked::Read(Err((
                Value::Null,
                "requests are text; only the eight bytes that acknowledge a frame are none"
                    .to_owned(),
            ))),
        };
        // It is there as long as the page is read.
        let _ = desk.send(asked).await;
    }
}

/// Does what a page asks in the order of asking.
async fn work(mut asked: mpsc::Receiver<Asked>, hub: Arc<Hub>, page: Page) {
    let mut garbage = 0;
    while let Some(asked) = asked.recv().await {
        let read = match asked {
            Asked::Read(read) => read,
            Asked::Text(text) => {
                let read = hub.apart(move |_| Ok(request::parse(&text))).await;
                read.unwrap_or_else(|failure| Err((Value::Null, failure.to_string())))
            }
        };
        match read {
            Ok((id, request)) => {
                garbage = 0;
                obey(id, request, &hub, &page).await;
            }
            Err((id, error)) => {
                garbage = if id.is_null() { garbage + 1 } else { 0 };
                page.refuse(&id, &error);
                if garbage == GARBAGE {
                    page.close("three messages in a row were no requests");
                }
            }
        }
    }
}

/// Does what is asked; what takes time beside the next requests.
async fn obey(id: Value, request: PageRequest, hub: &Arc<Hub>, page: &Page) {
    if request.needs_controls() && !hub.has_controls(page.number) {
        let refused = Failure::bad_input(
            "this page is only watching: take the controls first (`controls.take`); stop always works",
        );
        return page.answer(&id, Err(refused));
    }
    if !request.takes_long() {
        return page.answer(&id, answer(&id, request, Arc::default(), hub, page).await);
    }
    let Ok(place) = Arc::clone(&hub.work).try_acquire_owned() else {
        return page.answer(&id, Err(Failure::bad_input(BUSY)));
    };
    // In the order of reading: a task may begin before one that was spawned earlier.
    let turn = if let PageRequest::Ask { panel, .. } = &request {
        page.panels.take_turn(*panel)
    } else {
        Arc::default()
    };
    let (hub, page) = (Arc::clone(hub), page.clone());
    tokio::spawn(async move {
        page.answer(&id, answer(&id, request, turn, &hub, &page).await);
        drop(place);
    });
}

/// Writes answers, what is said to all, the status, and frames as they are due.
async fn write(
    mut sink: SplitSink<WebSocket, Message>,
    mut queue: mpsc::Receiver<Outgoing>,
    mut live: LivePicture,
    hub: Arc<Hub>,
    page: u64,
) {
    let mut broadcast = hub.hear();
    let [mut frames, mut states, mut pings] = [Duration::from_secs(1) / FRAMES_PER_S, STATUS, PING]
        .map(|period| {
            let mut interval = interval(period);
            interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
            interval
        });
    let mut idle = 0;
    loop {
        let message = tokio::select! {
            biased;
            outgoing = queue.recv() => match outgoing {
                None => break,
                Some(Outgoing::Message(message)) => message,
                Some(Outgoing::Live(view)) => {
                    live.show(view);
                    continue;
                }
            },
            text = broadcast.recv() => match text {
                Ok(text) => Message::text(text.to_string()),
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => break,
            },
            _ = states.tick() => {
                idle += 1;
                if hub.feel().is_none() && idle < IDLE {
                    continue;
                }
                idle = 0;
                Message::text(status(&hub, page, &mut live).to_string())
            }
            _ = pings.tick() => Message::Ping(Bytes::new()),
            _ = frames.tick(), if live.is_on() => {
                let feel = hub.feel();
                let t = locked(&hub.place.kept.state).sample_time_s;
                let next = |_| live.next_frame(&locked(&hub.place.kept.pyramid), t);
                match feel.and_then(next) {
                    Some(frame) => Message::binary(frame),
                    None => continue,
                }
            }
        };
        let last = matches!(message, Message::Close(_));
        if sink.send(message).await.is_err() || last {
            break;
        }
        // Other pages are answered too before the next answer to this one.
        tokio::task::yield_now().await;
    }
    let _ = sink.close().await;
}

/// Status of the loop, of the page and of its picture.
fn status(hub: &Hub, page: u64, live: &mut LivePicture) -> Value {
    let kept = &hub.place.kept;
    let mut status = idle();
    if let Some(feel) = hub.feel() {
        let made = locked(&kept.pyramid).made();
        status = locked(&kept.state).status(feel.counts(), made);
        status["paused"] = feel.is_paused().into();
        let comparison = locked(&kept.comparison);
        status["compare"] = json!(comparison.as_ref().map(Comparison::status));
    }
    status["watching"] = json!(hub.watching());
    status["controls"] = json!(hub.has_controls(page));
    let t = locked(&kept.state).sample_time_s;
    live.add_to(&mut status, &locked(&kept.pyramid), t);
    json!({"status": status})
}
