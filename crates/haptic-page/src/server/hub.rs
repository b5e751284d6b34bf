//! State that the sockets share: the felt loop, the run in progress, the page with the controls.

use super::tables::Tables;
use crate::dropped::TISSUES;
use crate::feel::{Feel, FeelPlace, Kept, Opened, opened};
use crate::runs::Runs;
use crate::{Announce, OnClose};
use haptic_answer::TextFile;
use haptic_answer::dropped::can_be_felt;
use haptic_answer::feel::{
    DeviceNumbers, FeelChange, FeelSettings, FeelState, FeltThing, felt, pyramid_size,
};
use haptic_answer::pyramid::Pyramid;
use haptic_answer::request::{CompareStart, StartRun};
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_run::RealtimeOptions;
use haptic_run::read_document;
use haptic_tissue::Library;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex};
use tokio::sync::{Semaphore, broadcast, watch};
use tokio::task::spawn_blocking;

/// Texts for all pages that wait for a slow one; it then misses the oldest.
const SAID: usize = 256;

/// Requests that are worked on at a time.
const AT_ONCE: usize = 16;
/// Short works beside the reactor at a time, however many pages ask: the loop and a stop have the rest of the machine.
const AT_DESK: usize = 2;
/// Said when there is no place for another.
pub(super) const BUSY: &str = "sixteen requests are being worked on: wait for an answer";

/// Options of a server, which it keeps until it ends.
#[derive(Clone, Debug)]
pub struct ServerOptions {
    /// The port; 0 for any that is free.
    pub port: u16,
    /// Folder of the runs, made when the first is recorded.
    pub runs: PathBuf,
    /// Effect on a loop or run of closing the page that controls it.
    pub on_close: OnClose,
    /// Options for the thread of the loop.
    pub realtime: RealtimeOptions,
    /// The tissues that can be felt.
    pub library: Library,
    /// The simulated device, but for the numbers that a page asks for.
    pub device: DeviceNumbers,
    /// The experiment file, log or tissue file whose wall or tissue a page that comes first feels.
    pub opens: Option<PathBuf>,
    /// Maker of the logs, for their metadata: program, command line.
    pub provenance: BTreeMap<String, String>,
}

#[derive(Debug)]
pub(super) struct Hub {
    pub(super) options: ServerOptions,
    /// Settings of the first loop, unless a page asks for others.
    pub(super) opens: Option<FeelSettings>,
    /// Place of the loop that is felt, and of the next.
    pub(super) place: FeelPlace,
    pub(super) runs: Runs,
    pub(super) tables: Tables,
    /// The tissues that can be felt, with those of files that were opened and those that were kept.
    pub(super) library: Mutex<Library>,
    /// A place for each request that is worked on, of whatever page.
    pub(super) work: Arc<Semaphore>,
    /// A place for each short work beside the reactor, in the order of asking.
    desk: Semaphore,
    /// Set to the reason when the server ends.
    pub(super) ending: watch::Receiver<Option<&'static str>>,
    feel: Mutex<Option<Arc<Feel>>>,
    /// Held while a loop or law is being made.
    making: tokio::sync::Mutex<()>,
    wanted: Mutex<Wanted>,
    pages: Mutex<Pages>,
    /// Stops that were asked for: one that comes while something is being started wins.
    stops: AtomicU64,
}

#[derive(Debug, Default)]
struct Wanted {
    settings: Option<FeelSettings>,
    number: u64,
}

#[derive(Debug, Default)]
struct Pages {
    newest: u64,
    open: BTreeSet<u64>,
    controls: Option<u64>,
}

impl Hub {
    pub(super) fn new(
        options: ServerOptions,
        terminal: SyncSender<String>,
        ending: watch::Receiver<Option<&'static str>>,
    ) -> Result<Self, Failure> {
        let (pages, _) = broadcast::channel(SAID);
        let announce = Announce { pages, terminal };
        let (folder, provenance) = (options.runs.clone(), options.provenance.clone());
        let runs = Runs::new(folder, provenance, options.realtime, announce.clone());
        let mut library = options.library.clone();
        // None was kept yet if the folder is not there.
        let _ = library.add_folder(&options.runs.join(TISSUES));
        let place = FeelPlace {
            kept: Arc::new(Kept {
                pyramid: Mutex::new(Pyramid::new(pyramid_size())),
                state: Mutex::new(FeelState::of(options.device.sample_time())),
                comparison: Mutex::default(),
            }),
            runs: options.runs.clone(),
            provenance: Arc::new(options.provenance.clone()),
            announce,
            realtime: options.realtime,
        };
        let mut hub = Self {
            opens: None,
            place,
            runs,
            tables: Tables::default(),
            library: Mutex::new(library),
            work: Arc::new(Semaphore::new(AT_ONCE)),
            desk: Semaphore::new(AT_DESK),
            options,
            ending,
            feel: Mutex::new(None),
            making: tokio::sync::Mutex::new(()),
            wanted: Mutex::default(),
            pages: Mutex::default(),
            stops: AtomicU64::new(0),
        };
        if let Some(path) = &hub.options.opens {
            let (environment, device) = hub.open(&read_document(path)?)?;
            let start = FeelChange {
                environment: Some(environment),
                ..FeelChange::default()
            };
            let settings = FeelSettings::new(&locked(&hub.library), device, start);
            let judged = settings.and_then(FeelSettings::judged);
            let of_file = |error| Failure::bad_input(format_args!("{}: {error}", path.display()));
            hub.opens = Some(judged.map_err(of_file)?.settings);
        }
        Ok(hub)
    }

    /// The wall of a document, and the device that it is for; or its tissue, which is known from now on.
    fn open(&self, document: &Document) -> Result<(FeltThing, DeviceNumbers), Failure> {
        Ok(match opened(document)? {
            Opened::Wall(wall, device) => (FeltThing::Wall(wall), device),
            Opened::Tissue(material) => {
                let name = material.name.clone();
                can_be_felt(&material)?;
                let mut library = locked(&self.library);
                // It may be a file of the library, or be opened again.
                if !library.materials().contains(&material) {
                    let added = library.add(document.path(), *material);
                    added.map_err(Failure::input)?;
                }
                (FeltThing::Tissue(name), self.options.device)
            }
        })
    }

    /// Does short work whose size a page chooses, as reading what it sent.
    pub(super) async fn apart<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Self) -> Result<T, Failure> + Send + 'static,
    ) -> Result<T, Failure> {
        // It is never closed.
        let _place = self.desk.acquire().await;
        let hub = Arc::clone(self);
        blocking(move || work(&hub)).await
    }

    /// All announcements to pages from now on.
    pub(super) fn hear(&self) -> broadcast::Receiver<Arc<str>> {
        self.place.announce.pages.subscribe()
    }

    /// A new page, which gets the controls if they are free.
    pub(super) fn enter(&self) -> u64 {
        let mut pages = locked(&self.pages);
        pages.newest += 1;
        let page = pages.newest;
        pages.open.insert(page);
        pages.controls.get_or_insert(page);
        page
    }

    /// A page is gone. If it had the controls, the loop and the run that it controlled end, unless they are to continue.
    pub(super) async fn leave(self: &Arc<Self>, page: u64) {
        let (held, last) = {
            let mut pages = locked(&self.pages);
            pages.open.remove(&page);
            let held = pages.controls.take_if(|holder| *holder == page);
            (held.is_some(), pages.open.is_empty())
        };
        if self.options.on_close == OnClose::Continue {
            return;
        }
        if held {
            self.stop();
        }
        if last {
            self.end_feel().await;
        }
    }

    pub(super) fn has_controls(&self, page: u64) -> bool {
        locked(&self.pages).controls == Some(page)
    }

    pub(super) fn watching(&self) -> usize {
        locked(&self.pages).open.len().saturating_sub(1)
    }

    pub(super) fn take_controls(&self, page: u64, force: bool) -> Result<(), Failure> {
        let mut pages = locked(&self.pages);
        match pages.controls {
            Some(holder) if holder != page && !force => Err(Failure::bad_input(
                "another page holds the controls: let them go there, or take them with `force`",
            )),
            holder => {
                pages.controls = Some(page);
                if holder.is_some_and(|holder| holder != page) {
                    let taken = "another page has taken the controls";
                    self.place.announce.notice(taken.to_owned());
                }
                Ok(())
            }
        }
    }

    pub(super) fn release_controls(&self) {
        locked(&self.pages).controls = None;
    }

    pub(super) fn feel(&self) -> Option<Arc<Feel>> {
        locked(&self.feel).clone()
    }

    pub(super) fn felt(&self) -> Result<Arc<Feel>, Failure> {
        self.feel()
            .ok_or_else(|| Failure::bad_input("nothing is felt yet: send `feel.start`"))
    }

    /// Does something with the loop that is felt, beside the reactor.
    pub(super) async fn on_feel<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Feel) -> Result<T, Failure> + Send + 'static,
    ) -> Result<T, Failure> {
        let feel = self.felt()?;
        blocking(move || work(&feel)).await
    }

    /// The force is zero first, then all else.
    pub(super) fn stop(&self) {
        self.stops.fetch_add(1, Ordering::Relaxed);
        if let Some(feel) = self.feel() {
            feel.stop();
        }
        self.runs.stop();
    }

    /// Starts a loop; one that was there is stopped.
    pub(super) async fn start_feel(self: &Arc<Self>, start: FeelChange) -> Result<Value, Failure> {
        let stops = self.stops.load(Ordering::Relaxed);
        let hub = Arc::clone(self);
        // A log is read whole, which would keep other pages from their stop.
        let settings = blocking(move || hub.settings(start)).await?;
        let _making = self.making.lock().await;
        // The old loop continues if the new one is refused.
        let old = self.feel();
        let place = self.place.clone();
        let made = blocking(move || Feel::start(place, settings.judged()?, old.as_deref()));
        let feel = made.await?;
        locked(&self.wanted).settings = None;
        let answer = felt(&feel.felt());
        *locked(&self.feel) = Some(Arc::new(feel));
        if self.stops.load(Ordering::Relaxed) != stops {
            self.stop();
        }
        self.place.announce.say(&answer);
        Ok(answer)
    }

    /// Settings of a start; of a file or a log the wall or tissue in it.
    fn settings(&self, mut start: FeelChange) -> Result<FeelSettings, Failure> {
        let mut device = self.options.device;
        let document = match &start.environment {
            Some(FeltThing::File(TextFile { name, text })) => {
                Document::of_text(Path::new(name), text).into()
            }
            Some(FeltThing::Run(name)) => self.runs.document(name)?.into(),
            Some(FeltThing::Tissue(_) | FeltThing::Wall(_)) | None => None,
        };
        if let Some(document) = document {
            let environment;
            (environment, device) = self.open(&document)?;
            start.environment = Some(environment);
        }
        FeelSettings::new(&locked(&self.library), device, start)
    }

    /// Changes what is felt. While one change is made, later ones add up, and the last of them is made next.
    pub(super) async fn change_feel(&self, change: FeelChange) -> Result<Value, Failure> {
        let feel = self.felt()?;
        let (next, number) = {
            let mut wanted = locked(&self.wanted);
            let base = wanted
                .settings
                .clone()
                .unwrap_or_else(|| feel.felt().settings);
            let next = base.changed(&locked(&self.library), &change)?;
            wanted.settings = Some(next.clone());
            wanted.number += 1;
            (next, wanted.number)
        };
        let _making = self.making.lock().await;
        if locked(&self.wanted).number != number {
            return Ok(felt(&feel.felt()));
        }
        let changing = Arc::clone(&feel);
        let made = blocking(move || changing.change(next)).await;
        let mut wanted = locked(&self.wanted);
        if wanted.number == number {
            wanted.settings = None;
        }
        made?;
        let answer = felt(&feel.felt());
        self.place.announce.say(&answer);
        Ok(answer)
    }

    /// Begins to compare what is felt with that and a change.
    pub(super) async fn compare(self: &Arc<Self>, start: CompareStart) -> Result<(), Failure> {
        let feel = self.felt()?;
        let _making = self.making.lock().await;
        let hub = Arc::clone(self);
        blocking(move || {
            let library = locked(&hub.library).clone();
            feel.compare(start, &library)
        })
        .await
    }

    /// Ends the loop: the force is zero, all is kept.
    pub(super) async fn end_feel(&self) {
        let _making = self.making.lock().await;
        let feel = locked(&self.feel).take();
        if let Some(feel) = feel {
            // It can only fail by a panic, which has been reported.
            let _ = spawn_blocking(move || feel.end()).await;
        }
    }

    pub(super) fn start_run(&self, run: &StartRun) -> Result<Value, Failure> {
        let stops = self.stops.load(Ordering::Relaxed);
        let started = self.runs.start(&run.kind, &run.parameters, run.realtime)?;
        if self.stops.load(Ordering::Relaxed) != stops {
            self.runs.stop();
        }
        Ok(started)
    }

    pub(super) async fn end_run(self: &Arc<Self>) {
        let hub = Arc::clone(self);
        // It can only fail by a panic, which has been reported.
        let _ = spawn_blocking(move || hub.runs.end()).await;
    }
}

pub(super) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    let panicked = "the server could not finish this: see the terminal";
    let done = spawn_blocking(work).await;
    done.unwrap_or_else(|_| Err(Failure::bad_input(panicked)))
}
