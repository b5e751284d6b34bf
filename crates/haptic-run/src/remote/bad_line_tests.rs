//! Both sessions of a pair in virtual time: samples and keep-alives over lines that stand still, the devices' clocks, and a host that takes what
//! arrives, by the code of a run. Only the links behind the sessions are quiet ones.

use super::{
    RemoteDevice,
    partner::{Both, Clock, Partner, Side, aligned},
    session::{HostSession, Ready, blank},
};
use crate::{
    device::{LinkedName, SerialName},
    ran::{DriveRan, Ran},
    record::RunRecord,
    recorder,
    schedule::{Pace, Schedule},
    supervisor::Watched,
};
use haptic_devices::moteus::{MoteusAxis, MoteusSettings};
use haptic_emulator::{
    FaultyLine, LineFaults, NearLine,
    moteus::{EmulatedAdapter, EmulatedServo, Shaft},
};
use haptic_link::{BatchItem, FaultReport, Sample, State, Status};
use haptic_loop::{Fault, realtime::Moment};
use haptic_message::TickMessage;
use haptic_remote::serial::{DeviceTime, Ping, Pings, SerialLink, Served};
use haptic_trial::samples::RunStart;
use std::{
    collections::BTreeMap,
    sync::{Arc, LazyLock, Mutex, atomic::AtomicBool},
    time::Duration,
};

const TICK_US: u64 = 1000;
const T: f64 = 1e-3;
/// Time from one keep-alive to the next, as on a link.
const ALIVE_US: u64 = 100_000;

/// A fault of a device, as it reports it.
pub fn reported(fault: Fault) -> FaultReport {
    let status = Status {
        state: State::Fault,
        fault: fault.code(),
        faults: 1,
        ..Status::default()
    };
    FaultReport {
        status,
        tick: 7,
        time_us: 7000,
    }
}

/// A run of a pair whose devices speak over bad lines.
pub struct BadPair<'a> {
    /// Faults of the lines of the tissue and of the drive.
    pub faults: [LineFaults; 2],
    /// Random bits for lines and clocks.
    pub bits: &'a mut dyn FnMut() -> u64,
    /// Samples from the drive's beginning on.
    pub samples: u64,
    /// The tissue's place so long after the true beginning of the drive, m.
    pub place_m: &'a dyn Fn(f64) -> f64,
    /// The force that the tissue's device makes at its next place, N.
    pub force_n: &'a mut dyn FnMut(f64) -> f64,
}

/// A device's end of a line, and what is on the way.
struct Device {
    /// Time by its own clock when the host's is 0, µs, and its rate.
    offset_us: u64,
    rate: f64,
    /// Time of tick 0 by the host's clock, µs.
    begins_us: u64,
    next_tick: u64,
    to_host: FaultyLine,
    to_device: FaultyLine,
    pings: Arc<Mutex<Pings>>,
    made: Vec<Sample>,
}

impl Device {
    fn at(&self, host_us: u64) -> u64 {
        self.offset_us + (self.rate * host_us as f64) as u64
    }

    /// When a tick is due by the host's clock, µs.
    fn due_us(&self, tick: u64) -> u64 {
        self.begins_us + ((tick * TICK_US) as f64 / self.rate) as u64
    }

    fn makes(&mut self, until_us: u64, mut axis: impl FnMut(u64) -> BatchItem) {
        while self.due_us(self.next_tick) <= until_us {
            let (tick, due_us) = (self.next_tick, self.due_us(self.next_tick));
            let mut sample = Sample {
                tick: tick as u32,
                time_us: self.at(due_us) as u32,
                ..Sample::default()
            };
            sample.axes.push(axis(due_us)).expect("one");
            self.made.push(sample);
            self.to_host
                .send(&[&[0], &tick.to_le_bytes()[..]].concat(), due_us);
            self.next_tick += 1;
        }
    }

    /// Samples that have arrived at the host by now; keep-alives go to its clock.
    fn arrived(&mut self, now_us: u64) -> Vec<Sample> {
        if now_us.is_multiple_of(ALIVE_US) {
            self.to_device.send(&now_us.to_le_bytes(), now_us);
        }
        while let Some(frame) = self.to_device.receive(now_us) {
            let message = [&[1], &frame[..], &self.at(now_us).to_le_bytes()[..]].concat();
            self.to_host.send(&message, now_us);
        }
        let number = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("eight"));
        let mut samples = Vec::new();
        while let Some(frame) = self.to_host.receive(now_us) {
            match frame[0] {
                0 => samples.push(self.made[number(&frame[1..]) as usize].clone()),
                _ => self.pings.lock().expect("one thread").add(Ping {
                    sent_us: number(&frame[1..9]),
                    heard_us: now_us,
                    device_us: number(&frame[9..]),
                }),
            }
        }
        samples
    }
}

/// A link to an emulated servo in its own time, which answers; and the servo's adapter.
///
/// # Panics
/// If the emulated servo does not answer.
pub fn quiet() -> (SerialLink, Arc<Mutex<EmulatedAdapter>>) {
    let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
    let adapter = Arc::new(Mutex::new(EmulatedAdapter::new(servo)));
    let time = DeviceTime::default();
    let line = NearLine::new(Arc::clone(&adapter), time.clone());
    let axis = MoteusAxis::open(line, MoteusSettings::DEFAULT, true).expect("answers");
    let served = Served::in_its_own_time(axis, time).expect("serves");
    let link = SerialLink::to_served(served, "moteus:emulated").expect("answers");
    (link, adapter)
}

static GOES_ON: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

pub(crate) fn remote() -> RemoteDevice {
    let path = "device".to_owned();
    RemoteDevice::new(LinkedName::Serial(SerialName { path, baud: None }))
}

/// Behind a quiet link, of which nothing of the run is asked.
pub(super) fn ready<'a>(
    device: &'a RemoteDevice,
    samples: u64,
    blank: &'a (dyn Fn(f64) -> TickMessage + Sync),
) -> Ready<'a, TickMessage> {
    Ready {
        link: quiet().0,
        before: Default::default(),
        device,
        schedule: Schedule {
            samples,
            sample_time_s: T,
            pace: Pace::Virtual,
        },
        start: RunStart::default(),
        rise_ticks: 10,
        blank,
        metadata: BTreeMap::new(),
        found: None,
        push: None,
        tap: None,
        force_limit_n: 10.0,
        tares: false,
        stop: &GOES_ON,
    }
}

/// Uniform in [0, 1).
fn share(bits: &mut dyn FnMut() -> u64) -> f64 {
    (bits() >> 11) as f64 / (1_u64 << 53) as f64
}

impl Device {
    fn behind(faults: LineFaults, bits: &mut dyn FnMut() -> u64) -> Device {
        let mut line = || FaultyLine::new(faults, bits()).expect("good faults");
        let (to_host, to_device) = (line(), line());
        Device {
            offset_us: (1e9 * share(bits)) as u64,
            rate: 1.0 + 1e-4 * (share(bits) - 0.5),
            begins_us: 250_137,
            next_tick: 0,
            to_host,
            to_device,
            pings: Arc::default(),
            made: Vec::new(),
        }
    }
}

impl std::fmt::Debug for BadPair<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BadPair")
            .field("faults", &self.faults)
            .finish_non_exhaustive()
    }
}

impl BadPair<'_> {
    /// The run as it is judged, and how much later than the truth the record of the tissue begins to count, s.
    ///
    /// # Panics
    /// If a part of the test itself fails.
    pub fn run(self, watched: Watched<'_>) -> (Ran, f64) {
        let mut devices = [Side::Tissue, Side::Drive]
            .map(|side| Device::behind(self.faults[side as usize], self.bits));
        // The drive waits until the tissue's force has risen.
        devices[1].begins_us += 300_000 + (400_000.0 * share(self.bits)) as u64;
        let epoch = Moment::now();
        let clocks = devices.each_ref().map(|device| {
            let pings = Arc::clone(&device.pings);
            let clock: Clock = Arc::new(move || pings.lock().expect("one thread").clock(epoch));
            clock
        });
        let remote = remote();
        let both = Both::default();
        let blank = |_: f64| blank(0.0);
        let Watched {
            request,
            supervisor,
        } = watched;
        let made = request.prepare().expect("a folder");
        let log = recorder(request, &made, BTreeMap::new(), true, supervisor);
        let mut first_log = log.expect("a log");
        let second_log = first_log.second();
        let partner = |side| {
            let watchdog = Duration::from_secs(1);
            let mut partner = Partner::new(&both, side, clocks.clone(), watchdog, Arc::default());
            (partner.rise_ticks, partner.samples) = (10, self.samples);
            partner
        };
        let sessions = [(Side::Tissue, first_log), (Side::Drive, second_log)];
        let sessions = sessions.map(|(side, log)| {
            ready(&remote, self.samples, &blank).session::<1>(log, Some(partner(side)))
        });
        let [mut tissue, mut drive]: [HostSession<'_, TickMessage, 1>; 2] =
            sessions.map(|session| session.expect("a session"));
        let begins_us = devices[1].begins_us;
        let end_us = begins_us + self.samples * TICK_US;
        // Whatever stood still comes in the end.
        for now_us in (0..end_us + 20_000_000).step_by(TICK_US as usize / 2) {
            let [first, second] = &mut devices;
            first.makes(now_us.min(end_us + 3_000_000), |due_us| {
                let since_s = 1e-6 * (due_us as f64 - begins_us as f64);
                let position_m = (self.place_m)(since_s) as f32;
                let force_n = -(self.force_n)(position_m.into()) as f32;
                BatchItem {
                    position_m,
                    environment_force_n: force_n,
                    force_n,
                    ..BatchItem::default()
                }
            });
            second.makes(now_us.min(end_us - TICK_US), |_| BatchItem::default());
            for (device, session) in [(first, &mut tissue), (second, &mut drive)] {
                for sample in device.arrived(now_us) {
                    session.take_sample(&sample);
                }
            }
        }
        let aligned = aligned(&both, &clocks);
        let (record, recorded): (RunRecord, _) = drive.finish_drive();
        let fault_log = recorded.expect("a log").fault_log;
        let ran = tissue.finish(made).expect("a log");
        // As the tissue's clock counts from its tick 0.
        let [first, _] = &devices;
        let truth_s = 1e-6 * first.rate * (begins_us - first.begins_us) as f64;
        let late_s = ran.record.start.begun_s() - truth_s;
        let second = Some(DriveRan {
            device: "serial:white".to_owned(),
            record,
            aligned,
            fault_log,
            may_rise_s: 0.0,
        });
        (Ran { second, ..ran }, late_s)
    }
}
