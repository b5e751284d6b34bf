//! Answers to requests.

use super::hub::{Hub, blocking};
use super::page::{Outgoing, Page};
use super::panels::Turn;
use crate::dropped::{keep_tissue, looked_at};
use crate::feel::Feel;
use crate::runs::forms;
use haptic_answer::feel::{CHANNELS, felt};
use haptic_answer::hello::Known;
use haptic_answer::live::{ShownLoop, frame};
use haptic_answer::request::{LIVE, PageRequest, ViewRequest};
use haptic_answer::surface::pushed;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_quantity::parse_for_key;
use serde_json::{Value, json};
use std::sync::Arc;
use tokio_tungstenite::tungstenite::Message;

/// Answers a request of a page that may ask it; `id` is its number. What does not take long does not wait.
pub(super) async fn answer(
    id: &Value,
    request: PageRequest,
    turn: Arc<Turn>,
    hub: &Arc<Hub>,
    page: &Page,
) -> Result<Value, Failure> {
    let hub = Arc::clone(hub);
    Ok(match request {
        PageRequest::Hello { version } => {
            let page = page.clone();
            hub.apart(move |hub| hello(version, hub, &page)).await?
        }
        PageRequest::TakeControls { force } => {
            hub.take_controls(page.number, force)?;
            json!({"controls": true})
        }
        PageRequest::ReleaseControls {} => json!(hub.release_controls()),
        PageRequest::FeelStart(start) => hub.start_feel(start).await?,
        PageRequest::FeelSet(change) => hub.change_feel(change).await?,
        PageRequest::FeelHand { position_m, held } => {
            json!({"position_m": hub.felt()?.hand(position_m, held)?})
        }
        PageRequest::FeelPause { paused } => json!(hub.felt()?.pause(paused)?),
        PageRequest::FeelMark { text } => json!(hub.felt()?.mark(text)?),
        PageRequest::FeelRecord { on: true } => json!({"name": hub.on_feel(Feel::record).await?}),
        PageRequest::FeelRecord { on: false } => {
            let (name, samples, missing) = hub.on_feel(Feel::end_record).await?;
            json!({"name": name, "samples": samples, "missing": missing})
        }
        PageRequest::FeelEnd {} => json!(hub.end_feel().await),
        PageRequest::CompareStart(start) => json!(hub.compare(start).await?),
        PageRequest::CompareFeel {} => json!(hub.on_feel(Feel::compare_next).await?),
        PageRequest::CompareRate { rating } => {
            json!(hub.on_feel(move |feel| feel.compare_rate(rating)).await?)
        }
        PageRequest::CompareAnswer { stiffer } => {
            json!(
                hub.on_feel(move |feel| feel.compare_answer(stiffer))
                    .await?
            )
        }
        PageRequest::CompareEnd {} => json!(hub.on_feel(Feel::end_compare).await?),
        PageRequest::Stop {} => json!(hub.stop()),
        PageRequest::Arm {} => json!(hub.on_feel(Feel::arm).await?),
        PageRequest::View(view) => self::view(id, view, hub, page).await?,
        PageRequest::ViewEnd {} => json!(page.send(Outgoing::Live(None))),
        PageRequest::RunsList {} => blocking(move || hub.runs.list()).await?,
        PageRequest::RunsOpen { name } => blocking(move || hub.runs.open(&name)).await?,
        PageRequest::RunsTable(table) => {
            let offered = move || Ok(hub.tables.offer(hub.runs.table(&table)?));
            json!({"address": blocking(offered).await?})
        }
        PageRequest::RunsForms {} => hub.apart(|_| Ok(forms())).await?,
        PageRequest::RunsStart(run) => blocking(move || hub.start_run(&run)).await?,
        PageRequest::RunsStop {} => json!(hub.runs.stop()),
        PageRequest::Ask { panel, question } => {
            let program = hub.options.provenance.get("program").cloned();
            page.panels.ask(panel, question, turn, program).await?
        }
        PageRequest::TissueKeep { name, text } => {
            let keep = move || {
                let library = &mut *locked(&hub.library);
                keep_tissue(library, &hub.options.runs, &name, &text)
            };
            json!({"path": blocking(keep).await?.display().to_string()})
        }
        PageRequest::File(file) => hub.apart(move |_| looked_at(&file)).await?,
        PageRequest::Quantity { key, text } => {
            let read = move |_: &Hub| parse_for_key(&key, &text).map_err(Failure::bad_input);
            json!({"value": hub.apart(read).await?})
        }
        PageRequest::Surface(surface) => {
            let panels = Arc::clone(&page.panels);
            let pushed = move |_: &Hub| pushed(&mut locked(&panels.surface), surface);
            json!({"surface_m": hub.apart(pushed).await?})
        }
    })
}

fn hello(version: u32, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    let options = &hub.options;
    let known = Known {
        controls: hub.has_controls(page.number),
        watching: hub.watching(),
        sample_time_s: locked(&hub.place.kept.state).sample_time_s,
        feel: hub.feel().map(|feel| felt(&feel.felt())["feel"].take()),
        opens: hub.opens.as_ref(),
        device: options.device,
        runs_folder: options.runs.display().to_string(),
    };
    known.hello(version, &locked(&hub.library))
}

async fn view(id: &Value, view: ViewRequest, hub: Arc<Hub>, page: &Page) -> Result<Value, Failure> {
    let number = view.number(id)?;
    if view.source == LIVE {
        let page = page.clone();
        return hub.apart(move |hub| live(number, &view, hub, &page)).await;
    }
    let (frame, channels) = blocking(move || {
        let spanned = |made, sample_time_s| view.span(made, sample_time_s);
        let shown = hub.runs.columns(&view.source, spanned)?;
        let (channels, columns) = view.chosen(shown.channels, shown.columns)?;
        Ok((frame(number, &columns, shown.sample_time_s), channels))
    })
    .await?;
    page.say(Message::binary(frame));
    Ok(json!({"channels": channels}))
}

fn live(request: u32, view: &ViewRequest, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    let t = locked(&hub.place.kept.state).sample_time_s;
    let shown = view.of_loop(request, &locked(&hub.place.kept.pyramid), t)?;
    page.send(match shown {
        ShownLoop::Frame(frame) => Outgoing::Message(Message::binary(frame)),
        ShownLoop::Live(live) => Outgoing::Live(Some(live)),
    });
    Ok(json!({"channels": CHANNELS}))
}
