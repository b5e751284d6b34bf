//! Answers to requests.

use super::hub::{Hub, blocking, felt};
use super::live::{FRAMES_PER_S, LiveView};
use super::page::{Outgoing, Page};
use super::request::{Request, ViewRequest};
use crate::feel::{CHANNELS, SAMPLE_TIME, locked, ranges, specimen_shape};
use crate::frame::frame;
use crate::identify::identified;
use crate::pyramid::{Columns, Span};
use crate::runs::places;
use haptic_experiment::{Failure, ModelledTissue, Named as _};
use haptic_loop::Limiters;
use haptic_tissue::{Material, Model};
use serde_json::{Value, json};
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;

/// The version that is spoken.
const VERSION: u32 = 1;
/// Most columns of a view.
const COLUMNS_MOST: u32 = 8192;

type Later = Pin<Box<dyn Future<Output = Result<Value, Failure>> + Send>>;

/// An answer, now or later.
pub(super) enum Asked {
    Done(Result<Value, Failure>),
    Later(Later),
}

fn later(work: impl Future<Output = Result<Value, Failure>> + Send + 'static) -> Asked {
    Asked::Later(Box::pin(work))
}

fn slow(work: impl FnOnce() -> Result<Value, Failure> + Send + 'static) -> Asked {
    later(blocking(work))
}

fn nothing((): ()) -> Value {
    Value::Null
}

/// Answers a request of a page that may ask it; `id` is its number.
pub(super) fn answer(id: &Value, request: Request, hub: &Arc<Hub>, page: &Page) -> Asked {
    let hub = Arc::clone(hub);
    let now = match request {
        Request::Hello { version } => hello(version, &hub, page),
        Request::TakeControls { force } => {
            let taken = hub.take_controls(page.number, force);
            taken.map(|()| json!({"controls": true}))
        }
        Request::ReleaseControls {} => {
            hub.release_controls();
            Ok(Value::Null)
        }
        Request::Stop {} => {
            hub.stop();
            Ok(Value::Null)
        }
        Request::View(view) => return self::view(id, view, hub, page),
        Request::ViewEnd {} => {
            page.send(Outgoing::Live(None));
            Ok(Value::Null)
        }
        Request::RunsList {} => return slow(move || hub.runs.list()),
        Request::RunsOpen { name } => return slow(move || hub.runs.open(&name)),
        Request::RunsTable(table) => {
            return slow(move || {
                let table = hub.runs.table(&table)?;
                Ok(json!({"address": hub.tables.offer(table)}))
            });
        }
        Request::RunsForms {} => Ok(hub.runs.forms()),
        Request::RunsStart(run) => return slow(move || hub.start_run(&run)),
        Request::RunsStop {} => {
            hub.runs.stop();
            Ok(Value::Null)
        }
        Request::Identify(request) => {
            let gone = Arc::clone(&page.gone);
            return slow(move || identified(&request, &gone));
        }
        felt => return self::feel(felt, hub),
    };
    Asked::Done(now)
}

/// Answers a request that is about what is felt.
fn feel(request: Request, hub: Arc<Hub>) -> Asked {
    match request {
        Request::FeelStart(start) => return later(async move { hub.start_feel(start).await }),
        Request::FeelSet(change) => return later(async move { hub.change_feel(change).await }),
        Request::FeelEnd {} => {
            return later(async move {
                hub.end_feel().await;
                Ok(Value::Null)
            });
        }
        _ => {}
    }
    let feel = match hub.felt() {
        Ok(feel) => feel,
        Err(error) => return Asked::Done(Err(error)),
    };
    Asked::Done(match request {
        Request::FeelHand { position_m, held } => {
            let goes_to = feel.hand(position_m, held);
            goes_to.map(|position_m| json!({"position_m": position_m}))
        }
        Request::FeelPause { paused } => feel.pause(paused).map(nothing),
        Request::FeelMark { text } => feel.mark(text).map(nothing),
        Request::FeelRecord { on: true } => {
            return slow(move || Ok(json!({"name": feel.record()?})));
        }
        Request::FeelRecord { on: false } => {
            return slow(move || {
                let (name, samples, missing) = feel.end_record()?;
                Ok(json!({"name": name, "samples": samples, "missing": missing}))
            });
        }
        // The one that is left.
        _ => return slow(move || feel.arm().map(nothing)),
    })
}

fn hello(version: u32, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    if version != VERSION {
        return Err(Failure::bad_input(format_args!(
            "this page speaks version {version}, the server {VERSION}: reload the page"
        )));
    }
    let options = &hub.options;
    let tissues: Result<Vec<Value>, Failure> =
        options.library.materials().iter().map(tissue).collect();
    Ok(json!({
        "version": VERSION,
        "program": options.provenance.get("program"),
        "controls": hub.has_controls(page.number),
        "watching": hub.watching(),
        "on_close": options.on_close.name(),
        "sample_time_s": SAMPLE_TIME.0,
        "channels": CHANNELS,
        "limiters": Limiters::NAMES,
        "tissues": tissues?,
        "ranges": ranges::with_device(options.device.mass_kg, options.device.damping_n_s_per_m),
        "feel": hub.feel().map(|feel| felt(&feel)["feel"].take()),
        "view_columns_most": COLUMNS_MOST,
        "frames_per_s": FRAMES_PER_S,
        "runs_folder": options.runs.display().to_string(),
    }))
}

fn tissue(material: &Material) -> Result<Value, Failure> {
    let tissue = ModelledTissue::new(material.clone())?;
    let (stiffness, dissipation) = tissue.spring_and_damper(specimen_shape());
    Ok(json!({
        "name": material.name,
        "title": material.description,
        "model": material.model.kind().name(),
        "citation": material.source.citation,
        "checked": material.source.checked,
        "order": tissue.order().get(),
        "order_free": tissue.composed().is_none(),
        "stiffness_n_per_m": stiffness,
        "dissipation_n_s_mu_per_m": dissipation,
        "parameters": parameters(&material.model),
    }))
}

fn parameters(model: &Model) -> Vec<Value> {
    let parameters = model.parameters().into_iter();
    let parameter = parameters.map(|(parameter, value)| {
        json!({
            "name": parameter.name,
            "unit": parameter.unit,
            "value": value,
            "help": parameter.help,
        })
    });
    parameter.collect()
}

/// A span of seconds, s.
fn span(view: &ViewRequest, columns: u32, made: u64, sample_time_s: f64) -> Result<Span, Failure> {
    let tick = |time_s: Option<f64>, otherwise: u64| match time_s {
        None => Ok(otherwise),
        Some(time_s) if time_s.is_finite() => Ok((time_s / sample_time_s).round().max(0.0) as u64),
        Some(_) => Err(Failure::bad_input("`from_s` and `to_s` have to be numbers")),
    };
    let (from, to) = (tick(view.from_s, 0)?, tick(view.to_s, made)?);
    if from >= to {
        return Err(Failure::bad_input("`from_s` has to be before `to_s`"));
    }
    Ok(Span::new(from, to, columns))
}

fn view(id: &Value, view: ViewRequest, hub: Arc<Hub>, page: &Page) -> Asked {
    // Its frames carry the number in four bytes.
    let Some(number) = id.as_u64().and_then(|id| u32::try_from(id).ok()) else {
        return Asked::Done(Err(Failure::bad_input(format_args!(
            "the `id` {id} of a view is not a whole number below 2^32: its frames carry it"
        ))));
    };
    if !(1..=COLUMNS_MOST).contains(&view.columns) {
        return Asked::Done(Err(Failure::bad_input(format_args!(
            "`columns` = {} is not in [1, {COLUMNS_MOST}]: ask for as many as there are pixels",
            view.columns
        ))));
    }
    if view.source != "live" {
        let page = page.clone();
        return slow(move || {
            let shown = hub.runs.columns(&view.source, |made, sample_time_s| {
                span(&view, view.columns, made, sample_time_s)
            })?;
            let (channels, columns) = chosen(&view, &shown.channels, shown.columns)?;
            page.send(Outgoing::Frame(frame(
                number,
                &columns,
                shown.sample_time_s,
            )));
            Ok(json!({"channels": channels}))
        });
    }
    Asked::Done(live(number, &view, &hub, page))
}

/// The channels that a view names, of those that there are.
fn chosen(
    view: &ViewRequest,
    names: &[String],
    columns: Columns,
) -> Result<(Vec<String>, Columns), Failure> {
    let Some(wanted) = &view.channels else {
        return Ok((names.to_vec(), columns));
    };
    let places = places(wanted, names)?;
    let columns = columns.chosen(&places);
    let names = places.iter().map(|&place| names[place].clone());
    Ok((names.collect(), columns))
}

fn live(request: u32, view: &ViewRequest, hub: &Hub, page: &Page) -> Result<Value, Failure> {
    if view.channels.is_some() {
        return Err(Failure::bad_input(
            "a live view has all channels: leave `channels` out",
        ));
    }
    let answer = json!({"channels": CHANNELS});
    let t = SAMPLE_TIME.0;
    let Some(last_s) = view.last_s else {
        let pyramid = locked(&hub.kept.pyramid);
        let span = span(view, view.columns, pyramid.made(), t)?;
        let columns = pyramid.columns(span);
        drop(pyramid);
        page.send(Outgoing::Frame(frame(request, &columns, t)));
        return Ok(answer);
    };
    if !(last_s > 0.0 && last_s.is_finite()) || view.from_s.is_some() || view.to_s.is_some() {
        return Err(Failure::bad_input(
            "`last_s` has to be a number above 0, without `from_s` and `to_s`",
        ));
    }
    let last = (last_s / t).ceil().min(1e15) as u64;
    page.send(Outgoing::Live(Some(LiveView {
        request,
        last,
        columns: view.columns,
    })));
    Ok(answer)
}
