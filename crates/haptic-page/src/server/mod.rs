//! The server: one address on this machine, one page, one socket for each browser.

mod answer;
mod http;
mod hub;
mod page;
mod panels;
mod response;
mod socket;
mod tables;

pub use hub::ServerOptions;

use haptic_experiment::Failure;
use haptic_quantity::Key;
use http::Door;
use hub::Hub;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rand::TryRng as _;
use rand::rngs::SysRng;
use std::convert::Infallible;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{mpsc, watch};

const PORT: Key = Key("port");

/// The reason that a socket is given when the server ends.
const STOPPED: &str = "the server was stopped";
/// Time granted to what still runs when the server ends: the force is zero after 0.1 s, and a log is closed soon after. Whatever
/// takes longer moves nothing and is abandoned.
const LAST: Duration = Duration::from_millis(700);
/// Sentences that wait for the terminal; later ones are for the pages alone.
const NOTICES: usize = 64;
const WORKERS: usize = 2;
/// Pause after a connection could not be accepted, as when this process has too many files open.
const AGAIN: Duration = Duration::from_millis(100);

/// The head of a request has to arrive within this time of the previous request: half-open and idle connections are closed.
const HEADERS: Duration = Duration::from_secs(5);
/// Longest head of a request, with the cookies of every other server on this machine.
const HEAD_BYTES: usize = 64 << 10;

/// A running server. Dropping it stops it: first the force goes to zero, then the sockets close.
#[derive(Debug)]
pub struct PageServer {
    address: String,
    /// The file that a browser opens, if one did.
    opener: Option<PathBuf>,
    notices: Receiver<String>,
    ending: watch::Sender<Option<&'static str>>,
    thread: Option<JoinHandle<()>>,
}

impl PageServer {
    /// Starts the server in a thread of its own.
    ///
    /// # Errors
    /// A port that is taken; a system that gives no random numbers or threads; a file whose wall cannot be felt.
    pub fn start(options: ServerOptions) -> Result<Self, Failure> {
        let listener = listener(options.port)?;
        let port = listener
            .local_addr()
            .map_err(|error| no_socket(&error))?
            .port();
        let token = token()?;
        let address = format!("http://127.0.0.1:{port}/{token}/");
        let (ending, ended) = watch::channel(None);
        let (terminal, notices) = sync_channel(NOTICES);
        let hub = Arc::new(Hub::new(options, terminal, ended)?);
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(WORKERS)
            .thread_name("page")
            .enable_all()
            .build()
            .map_err(|error| no_socket(&error))?;
        let listener = {
            let _inside = runtime.enter();
            tokio::net::TcpListener::from_std(listener).map_err(|error| no_socket(&error))?
        };
        let thread = std::thread::spawn(move || {
            runtime.block_on(serve(listener, Door::new(port, token), hub));
            runtime.shutdown_background();
        });
        Ok(Self {
            address,
            opener: None,
            notices,
            ending,
            thread: Some(thread),
        })
    }

    /// The address to open in a browser, with its token.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// A file, readable by its owner alone, that leads a browser to the address. As an argument of the browser the address could be read by
    /// everybody on this machine. The server removes the file when it ends.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn opener(&mut self) -> std::io::Result<&Path> {
        let name = format!("haptic-page-{}.html", std::process::id());
        let path = std::env::temp_dir().join(name);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(&path)?;
        let path = self.opener.insert(path);
        let address = &self.address;
        let leads = format!("<meta http-equiv=\"refresh\" content=\"0; url={address}\">");
        write!(
            file,
            "<!doctype html>{leads}<a href=\"{address}\">The page</a>"
        )?;
        Ok(path)
    }

    /// The next message for people, if one comes within this time.
    #[must_use]
    pub fn notice(&self, within: Duration) -> Option<String> {
        self.notices.recv_timeout(within).ok()
    }

    /// Stops: the force goes to zero first, then the pages are informed and their sockets closed.
    /// Returns when all is done, with the last sentences for people.
    pub fn stop(mut self) -> Vec<String> {
        self.end();
        self.notices.try_iter().collect()
    }

    fn end(&mut self) {
        self.ending.send_replace(Some(STOPPED));
        if let Some(opener) = self.opener.take() {
            // It leads nowhere any more.
            let _ = std::fs::remove_file(opener);
        }
        if let Some(thread) = self.thread.take() {
            // A panic in it is a defect that its own message has reported.
            let _ = thread.join();
        }
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        self.end();
    }
}

async fn serve(listener: tokio::net::TcpListener, door: Door, hub: Arc<Hub>) {
    let ended = || {
        let mut ending = hub.ending.clone();
        // An error means that the hub is gone: stop too.
        async move { drop(ending.wait_for(Option::is_some).await) }
    };
    let service = connections(listener, door, &hub, ended);
    let force_zero_first = async {
        ended().await;
        hub.stop();
        hub.end_feel().await;
    };
    let rest = async {
        let run = async {
            ended().await;
            hub.end_run().await;
        };
        tokio::join!(service, run);
    };
    // An idle connection, or an endless answer, does not delay the end.
    let bounded = async {
        tokio::select! {
            () = rest => {}
            () = async { ended().await; tokio::time::sleep(LAST).await } => {}
        }
    };
    tokio::join!(force_zero_first, bounded);
    // One that was started meanwhile.
    hub.end_feel().await;
}

/// Takes connections until it has `ended`, and ends when the last of them and of their sockets does.
async fn connections<E>(
    listener: tokio::net::TcpListener,
    door: Door,
    hub: &Arc<Hub>,
    ended: impl Fn() -> E,
) where
    E: Future<Output = ()> + Send + 'static,
{
    let door = Arc::new(door);
    // Each connection and each socket has a sender, and nothing is sent.
    let (open, mut all) = mpsc::channel::<Infallible>(1);
    let mut end = pin!(ended());
    loop {
        let taken = tokio::select! {
            taken = listener.accept() => taken,
            () = &mut end => break,
        };
        let Ok((stream, _)) = taken else {
            tokio::time::sleep(AGAIN).await;
            continue;
        };
        let (door, hub, open) = (Arc::clone(&door), Arc::clone(hub), open.clone());
        let service = service_fn(move |request| {
            let answer = http::answer(&door, &hub, &open, request);
            async { Ok::<_, Infallible>(http::with_headers(answer)) }
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(HEADERS)
            .max_buf_size(HEAD_BYTES)
            .serve_connection(TokioIo::new(stream), service);
        let end = ended();
        // Errors of single connections are theirs.
        tokio::spawn(async move {
            let mut connection = pin!(connection.with_upgrades());
            tokio::select! {
                _ = connection.as_mut() => {}
                () = end => {
                    connection.as_mut().graceful_shutdown();
                    let _ = connection.await;
                }
            }
        });
    }
    drop((listener, open));
    all.recv().await;
}

fn listener(port: u16) -> Result<TcpListener, Failure> {
    let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|error| {
        if error.kind() == std::io::ErrorKind::AddrInUse {
            Failure::bad_input(format_args!(
                "{PORT} {port} is taken by another program: use another, or 0 for any that is free"
            ))
        } else {
            Failure::input_with_advice(
                format_args!("cannot listen at {PORT} {port}: {error}"),
                "use a port above 1023, or 0 for any that is free",
            )
        }
    })?;
    listener
        .set_nonblocking(true)
        .map_err(|error| no_socket(&error))?;
    Ok(listener)
}

fn no_socket(error: &std::io::Error) -> Failure {
    Failure::bad_input(format_args!(
        "this system gives the server no socket or thread: {error}"
    ))
}

/// 128 random bits.
fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    SysRng.try_fill_bytes(&mut bytes).map_err(|error| {
        Failure::bad_input(format_args!(
            "this system gives no random numbers for the token: {error}"
        ))
    })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
