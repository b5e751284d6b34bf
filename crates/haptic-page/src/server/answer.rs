//! Answers to requests.

use super::hub::{Hub, blocking, felt};
use super::live::{LiveView, frame};
use super::page::{Outgoing, Page};
use super::request::{LIVE, Request, ViewRequest};
use crate::dropped::{keep_tissue, looked_at};
use crate::feel::{CHANNELS, SLIDERS};
use crate::pyramid::Span;
use crate::runs::{forms, places};
use crate::surface::pushed;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece};
use haptic_loop::Limiters;
use haptic_quantity::parse_for_key;
use haptic_tissue::Material;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio_tungstenite::tungstenite::Message;

const VERSION: u32 = 1;
const COLUMNS_MOST: u32 = 8192;

/// Answers a request of a page that may ask it; `id` is its number. What does not take long does not wait.
pub(super) async fn answer(
    id: &Value,
    request: Request,
    hub: &Arc<Hub>,
    page: &Page,
) -> Result<Value, Failure> {
    let hub = Arc::clone(hub);
    Ok(match request {
        Request::Hello { version } => {
            let page = page.clone();
            hub.apart(move |hub| hello(version, hub, &page)).await?
        }
        Request::TakeControls { force } => {
            hub.take_controls(page.number, force)?;
            json!({"controls": true})
        }
        Request::ReleaseControls {} => json!(hub.release_controls()),
        Request::FeelStart(start) => hub.start_feel(start).await?,
        Request::FeelSet(change) => hub.change_feel(change).await?,
        Request::FeelHand { position_m, held } => {
            json!({"position_m": hub.felt()?.hand(position_m, held)?})
        }
        Request::FeelPause { paused } => json!(hub.felt()?.pause(paused)?),
        Request::FeelMark { text } => json!(hub.felt()?.mark(text)?),
        Request::FeelRecord { on: true } => {
            let feel = hub.felt()?;
            json!({"name": blocking(move || feel.record()).await?})
        }
        Request::FeelRecord { on: false } => {
            let feel = hub.felt()?;
            let (name, samples, missing) = blocking(move || feel.end_record()).await?;
            json!({"name": name, "samples": samples, "missing": missing})
        }
        Request::FeelEnd {} => json!(hub.end_feel().await),
        Request::CompareStart(start) => json!(hub.compare(start).await?),
        Request::CompareFeel {} => {
            let feel = hub.felt()?;
            json!(blocking(move || feel.compare_next()).await?)
        }
        Request::CompareAnswer { stiffer } => {
            let feel = hub.felt()?;
            json!(blocking(move || feel.compare_answer(stiffer)).await?)
        }
        Request::CompareEnd {} => {
            let feel = hub.felt()?;
            json!(blocking(move || feel.end_compare()).await?)
        }
        Request::Stop {} => json!(hub.stop()),
        Request::Arm {} => {
            let feel = hub.felt()?;
            json!(blocking(move || feel.arm()).await?)
        }
        Request::View(view) => self::view(id, view, hub, page).await?,
        Request::ViewEnd {} => json!(page.send(Outgoing::Live(None))),
        Request::RunsList {} => blocking(move || hub.runs.list()).await?,
        Request::RunsOpen { name } => blocking(move || hub.runs.open(&name)).await?,
        Request::RunsTable(table) => {
            let offered = move || Ok(hub.tables.offer(hub.runs.table(&table)?));
            json!({"address": blocking(offered).await?})
        }
        Request::RunsForms {} => hub.apart(|_| Ok(forms())).await?,
        Request::RunsStart(run) => blocking(move || hub.start_run(&run)).await?,
        Request::RunsStop {} => json!(hub.runs.stop()),
        Request::Ask {
            panel,
            question,
            turn,
        } => {
            let program = hub.options.provenance.get("program").cloned();
            page.panels.ask(panel, question, turn, program).await?
        }
        Request::TissueKeep { name, text } => {
            let keep = move || {
                let library = &mut *locked(&hub.library);
                keep_tissue(library, &hub.options.runs, &name, &text)
            };
            json!({"path": blocking(keep).await?.display().to_string()})
        }
        Request::File(file) => hub.apart(move |_| looked_at(&file)).await?,
        Request::Quantity { key, text } => {
            let read = move |_: &Hub| parse_for_key(&key, &text).map_err(Failure::bad_input);
            json!({"value": hub.apart(read).await?})
        }
        Request::Surface(surface) => {
            let panels = Arc::clone(&page.panels);
            let pushed = move |_: &Hub| pushed(&mut locked(&panels.surface), surface);
            json!({"surface_m": hub.apart(pushed).await?})
        }
    })
}

fn hello(version: u32, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    if version != VERSION {
        return Err(Failure::bad_input(format_args!(
            "this page speaks version {version}, the server {VERSION}: reload the page"
        )));
    }
    let options = &hub.options;
    // A file of the folder that cannot be felt does not hide the others; the reason comes when it is asked for.
    let tissues: Vec<Value> = (locked(&hub.library).materials().iter())
        .flat_map(tissue)
        .collect();
    Ok(json!({
        "version": VERSION,
        "controls": hub.has_controls(page.number),
        "watching": hub.watching(),
        "sample_time_s": locked(&hub.place.kept.state).sample_time_s,
        "channels": CHANNELS,
        "limiters": Limiters::NAMES,
        "tissues": tissues,
        "ranges": SLIDERS.into_iter().collect::<BTreeMap<_, _>>(),
        "feel": hub.feel().map(|feel| felt(&feel)["feel"].take()),
        "opens": hub.opens,
        "device": options.device,
        "view_columns_most": COLUMNS_MOST,
        "runs_folder": options.runs.display().to_string(),
    }))
}

fn tissue(material: &Material) -> Result<Value, Failure> {
    let tissue = ModelledTissue::new(material.clone())?;
    let piece = TissuePiece::usual(tissue).map_err(Failure::input)?;
    let (stiffness, dissipation) = piece.spring_and_damper();
    let tissue = &piece.material;
    Ok(json!({
        "name": material.name,
        "title": material.description,
        "model": material.model.kind().name(),
        "order": tissue.order().get(),
        "order_free": tissue.composed().is_none(),
        "stiffness_n_per_m": stiffness,
        "dissipation_n_s_mu_per_m": dissipation,
    }))
}

fn span(view: &ViewRequest, made: u64, sample_time_s: f64) -> Result<Span, Failure> {
    let tick = |time_s: Option<f64>, otherwise: u64| match time_s {
        None => Ok(otherwise),
        Some(time_s) if time_s.is_finite() => Ok((time_s / sample_time_s).round().max(0.0) as u64),
        Some(_) => Err(Failure::bad_input("`from_s` and `to_s` have to be numbers")),
    };
    let (from, to) = (tick(view.from_s, 0)?, tick(view.to_s, made)?);
    if from >= to {
        return Err(Failure::bad_input("`from_s` has to be before `to_s`"));
    }
    Ok(Span::new(from, to, view.columns))
}

async fn view(id: &Value, view: ViewRequest, hub: Arc<Hub>, page: &Page) -> Result<Value, Failure> {
    // Its frames carry the number in four bytes.
    let Some(number) = id.as_u64().and_then(|id| u32::try_from(id).ok()) else {
        return Err(Failure::bad_input(format_args!(
            "the `id` {id} of a view is not a whole number below 2^32: its frames carry it"
        )));
    };
    if !(1..=COLUMNS_MOST).contains(&view.columns) {
        return Err(Failure::bad_input(format_args!(
            "`columns` = {} is not in [1, {COLUMNS_MOST}]: ask for as many as there are pixels",
            view.columns
        )));
    }
    if view.source == LIVE {
        let page = page.clone();
        return hub.apart(move |hub| live(number, &view, hub, &page)).await;
    }
    let (frame, channels) = blocking(move || {
        let spanned = |made, sample_time_s| span(&view, made, sample_time_s);
        let shown = hub.runs.columns(&view.source, spanned)?;
        let (mut channels, mut columns) = (shown.channels, shown.columns);
        if let Some(wanted) = &view.channels {
            columns = columns.chosen(&places(wanted, &channels)?);
            channels.clone_from(wanted);
        }
        Ok((frame(number, &columns, shown.sample_time_s), channels))
    })
    .await?;
    page.say(Message::binary(frame));
    Ok(json!({"channels": channels}))
}

fn live(request: u32, view: &ViewRequest, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    if view.channels.is_some() {
        return Err(Failure::bad_input(
            "a live view has all channels: omit `channels`",
        ));
    }
    let t = locked(&hub.place.kept.state).sample_time_s;
    page.send(match view.last_s {
        None => {
            let pyramid = locked(&hub.place.kept.pyramid);
            let columns = pyramid.columns(span(view, pyramid.made(), t)?);
            drop(pyramid);
            Outgoing::Message(Message::binary(frame(request, &columns, t)))
        }
        Some(last_s)
            if last_s > 0.0
                && last_s.is_finite()
                && view.from_s.is_none()
                && view.to_s.is_none() =>
        {
            Outgoing::Live(Some(LiveView {
                request,
                last_s,
                columns: view.columns,
            }))
        }
        Some(_) => {
            return Err(Failure::bad_input(
                "`last_s` has to be a number above 0, without `from_s` and `to_s`",
            ));
        }
    });
    Ok(json!({"channels": CHANNELS}))
}
