//! Round trips with the messages of a tick, by the maker's client and by `tungstenite`, and what each allocates; and a tick of our driver.
//!
//! ```sh
//! host-cli device emulate --kind inverse3 &
//! cargo run --release --example round_trip
//! ```

use haply::HaplyDevice;
use haply::device_model::{Force, ForceInput};
use haptic_devices::inverse3::{Inverse3, Inverse3Name};
use haptic_remote::Hardware as _;
use std::alloc::{GlobalAlloc, Layout, System};
use std::net::TcpStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tungstenite::Message;

struct Counting;

static ALLOCATED: AtomicU64 = AtomicU64::new(0);

// SAFETY: everything is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const TICKS: u32 = 8000;
const ADDRESS: &str = "localhost:10001";
const ID: &str = "04BA";

fn tell(what: &str, period: Duration, mut took: Vec<Duration>, allocations: u64) {
    took.sort();
    let at = |share: f64| took[(share * (took.len() - 1) as f64) as usize];
    println!(
        "{what} at {period:?}: median {:?}, 99.9th percentile {:?}, {:.2} allocations a tick",
        at(0.5),
        at(0.999),
        allocations as f64 / f64::from(TICKS)
    );
}

fn wait_until(due: Instant) {
    let left = due.saturating_duration_since(Instant::now());
    std::thread::sleep(left.saturating_sub(Duration::from_micros(80)));
    while Instant::now() < due {
        std::hint::spin_loop();
    }
}

fn by_tungstenite(period: Duration) {
    let stream = TcpStream::connect(ADDRESS).expect("connects");
    stream.set_nodelay(true).expect("set");
    let (mut socket, _) =
        tungstenite::client(format!("ws://{ADDRESS}/"), stream).expect("a WebSocket");
    socket.read().expect("the inventory");
    let mut took = Vec::with_capacity(TICKS as usize);
    let (mut due, before) = (Instant::now(), ALLOCATED.load(Ordering::Relaxed));
    for _ in 0..TICKS {
        // A tick that comes too late is not made up for.
        due = (due + period).max(Instant::now());
        wait_until(due);
        let began = Instant::now();
        let text = format!(
            r#"{{"inverse3":[{{"device_id":"{ID}","commands":{{"set_cursor_force":{{"vector":{{"x":0,"y":0,"z":0}}}}}}}}]}}"#
        );
        socket.send(Message::text(text)).expect("sent");
        while !socket.read().expect("an answer").is_text() {}
        took.push(began.elapsed());
    }
    tell(
        "tungstenite",
        period,
        took,
        ALLOCATED.load(Ordering::Relaxed) - before,
    );
}

/// Measures the driver, without a round trip: it reads what has come, and does not wait.
fn by_the_driver(period: Duration) {
    let stream = TcpStream::connect(ADDRESS).expect("connects");
    stream.set_nodelay(true).expect("set");
    let waits = stream.try_clone().expect("shared");
    let name = Inverse3Name::parse(",lost=1000").expect("a name");
    let (mut device, _) = Inverse3::<_, 3>::greet(stream, &name, || false).expect("opens");
    waits.set_nonblocking(true).expect("set");
    let mut took = Vec::with_capacity(TICKS as usize);
    let (mut due, before) = (Instant::now(), ALLOCATED.load(Ordering::Relaxed));
    for _ in 0..TICKS {
        // A tick that comes too late is not made up for.
        due = (due + period).max(Instant::now());
        wait_until(due);
        let began = Instant::now();
        device.idle().expect("no trouble");
        took.push(began.elapsed());
    }
    tell(
        "a tick of the driver",
        period,
        took,
        ALLOCATED.load(Ordering::Relaxed) - before,
    );
}

async fn by_the_maker(period: Duration) {
    let device = HaplyDevice::new(&format!("http://{ADDRESS}"), &format!("ws://{ADDRESS}/")).await;
    let mut device = device.expect("connects");
    tokio::time::sleep(Duration::from_millis(200)).await;
    let mut took = Vec::with_capacity(TICKS as usize);
    let (mut due, before) = (Instant::now(), ALLOCATED.load(Ordering::Relaxed));
    for _ in 0..TICKS {
        // A tick that comes too late is not made up for.
        due = (due + period).max(Instant::now());
        wait_until(due);
        let began = Instant::now();
        let force = ForceInput {
            device_id: ID.to_owned(),
            forces: Force::default(),
        };
        device
            .update_force(vec![force], Some(true), Some(true))
            .await
            .expect("sent");
        while device.state.lock().await.timestamp < began {
            tokio::task::yield_now().await;
        }
        took.push(began.elapsed());
    }
    tell(
        "haply",
        period,
        took,
        ALLOCATED.load(Ordering::Relaxed) - before,
    );
}

#[tokio::main]
async fn main() {
    for period in [Duration::from_millis(1), Duration::from_micros(250)] {
        by_tungstenite(period);
        by_the_driver(period);
        by_the_maker(period).await;
    }
}
