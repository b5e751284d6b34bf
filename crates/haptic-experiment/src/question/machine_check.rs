//! Check of this machine for a loop at some rate: measures as `cyclictest` does, with the loop's own runner.

use haptic_document::{
    Failure,
    parameters::{PIN, RATE},
};
use haptic_loop::realtime::{Fallback, Periodic, PeriodicConfig, Timing};
use haptic_run::realtime::{Microseconds, RealtimeOptions, WorstTick, microseconds};
use serde::Serialize;
use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// A check of this machine: the loop's own runner at several rates.
#[derive(Clone, Debug, PartialEq)]
pub struct RtCheck {
    /// Time for which each rate is measured; a verdict needs 1000 cycles.
    pub duration: Duration,
    /// The rates to try, Hz, one after the other.
    pub rates_hz: Vec<f64>,
    /// The priority and the core that the measured thread asks for.
    pub thread: RealtimeOptions,
    /// Busy threads beside it, at normal priority.
    pub busy: usize,
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct RtReport {
    pub machine: Machine,
    pub duration_s: f64,
    pub busy: usize,
    #[serde(flatten)]
    pub granted: Granted,
    /// Time that the host of a virtual machine gave to others, summed over all processors, ms.
    pub stolen_ms: Option<u64>,
    pub rates: Vec<Rate>,
    /// Changes to make, a sentence each; empty if nothing is left to change.
    pub advice: Vec<String>,
}

impl RtCheck {
    /// Measures. `progress` hears the share that is done.
    ///
    /// # Errors
    /// A rate outside its range; interrupted.
    pub fn run(
        &self,
        stop: &AtomicBool,
        progress: &dyn Fn(f64),
    ) -> Result<impl Serialize + use<>, Failure> {
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            // Before any thread is raised, so that they are normal.
            for _ in 0..self.busy {
                scope.spawn(|| {
                    while !over.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                });
            }
            let measured = self.measure(stop, progress);
            over.store(true, Ordering::Relaxed);
            measured
        })
    }

    fn measure(&self, stop: &AtomicBool, progress: &dyn Fn(f64)) -> Result<RtReport, Failure> {
        let root = std::path::Path::new("/");
        let machine = Machine::inspect(root);
        let stolen_before = stolen_ms(root);
        let (mut rates, mut granted) = (Vec::new(), Granted::default());
        for (index, &hz) in self.rates_hz.iter().enumerate() {
            let done = |share: f64| progress((index as f64 + share) / self.rates_hz.len() as f64);
            rates.push(self.rate(hz, &mut granted, stop, &done)?);
        }
        let stolen_ms = stolen_before
            .zip(stolen_ms(root))
            .map(|(before, after)| after.saturating_sub(before));
        Ok(RtReport {
            advice: machine.advice(granted.fallback, &rates, stolen_ms.unwrap_or(0)),
            rates,
            granted,
            busy: self.busy,
            duration_s: self.duration.as_secs_f64(),
            machine,
            stolen_ms,
        })
    }

    fn rate(
        &self,
        hz: f64,
        granted: &mut Granted,
        stop: &AtomicBool,
        progress: &dyn Fn(f64),
    ) -> Result<Rate, Failure> {
        let period = Duration::try_from_secs_f64(1.0 / hz).map_err(Failure::input)?;
        let cycles = (self.duration.as_secs_f64() * hz).ceil().max(1.0) as u64;
        let config = PeriodicConfig {
            thread: self.thread,
            ..PeriodicConfig::new(period)
        };
        let mut periodic = Periodic::new(config).map_err(|error| {
            Failure::input_with_advice(error, format_args!("give {RATE}, as in 1000"))
        })?;
        let (thread, margin) = (periodic.thread(), periodic.spin_margin());
        *granted = Granted {
            fallback: thread.fallback(),
            priority: thread.priority(),
            pin: thread.core(),
            memory_locked: thread.memory_is_locked(),
        };
        let mut periods = 0;
        // A skipped period is over, too: a machine that is late does not take longer.
        while periods < cycles {
            let cycle = periodic.wait();
            periods += 1 + cycle.skipped;
            if stop.load(Ordering::Relaxed) {
                return Err(Failure::interrupted());
            }
            if cycle.number.is_multiple_of(256) {
                progress(periods as f64 / cycles as f64);
            }
        }
        Ok(Rate::of(hz, &periodic.finish().0, margin))
    }
}

/// Options that the system granted.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Granted {
    #[serde(skip)]
    fallback: Option<Fallback>,
    /// Null for a normal thread.
    priority: Option<u8>,
    /// The core that it was pinned to.
    pin: Option<usize>,
    memory_locked: bool,
}

/// A rate is fit if 999 of 1000 cycles begin within this share of the period, and none a period late.
const FIT_SHARE: f64 = 0.1;
/// Fewer cycles cannot show the slowest in a thousand.
const FIT_CYCLES: u64 = 1000;

#[derive(Clone, Debug, Serialize)]
pub(crate) struct Rate {
    pub hz: f64,
    /// True if a loop at this rate is safe here; null if too few cycles ran to judge it.
    pub fit: Option<bool>,
    pub fit_reason: Option<String>,
    /// Time from when a cycle was due to when it began.
    pub lateness_us: Microseconds,
    /// Number of cycles that began at least a whole period late.
    pub overruns: u64,
    /// Number of periods skipped because of that.
    pub skipped_periods: u64,
    pub cycles: u64,
    /// The cycle that ended latest.
    pub worst_cycle: Option<WorstTick>,
    /// Time before each cycle that the thread waits without sleeping, µs.
    pub spin_margin_us: f64,
}

impl Rate {
    /// Verdict on a rate by what the runner did, which spun for `margin` before each cycle.
    fn of(hz: f64, runner: &Timing, margin: Duration) -> Self {
        let lateness_us = Microseconds::of(&runner.lateness_ns);
        let overruns = runner.overruns;
        let cycles = runner.lateness_ns.len();
        // A cycle that was a period late is one too many, however few ran.
        let fit = match overruns.cycles() {
            0 if cycles < FIT_CYCLES => None,
            late => Some(late == 0 && lateness_us.p999 <= FIT_SHARE * 1e6 / hz),
        };
        let needed = || {
            format!(
                "{cycles} cycles ran, and a verdict needs {FIT_CYCLES}: measure for at least {} s",
                FIT_CYCLES as f64 / hz
            )
        };
        Self {
            hz,
            lateness_us,
            overruns: overruns.cycles(),
            skipped_periods: overruns.skipped_periods,
            cycles,
            worst_cycle: runner.worst.map(WorstTick::from),
            spin_margin_us: microseconds(margin),
            fit_reason: fit.is_none().then(needed),
            fit,
        }
    }
}

/// An idle processor that takes longer to wake, µs, costs jitter.
const DEEP_SLEEP_US: u32 = 30;
/// Time stolen by the host that is worth a sentence, ms.
const STOLEN_NOTABLE_MS: u64 = 10;

/// Facts of the machine. Those that a system does not report are null or empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Machine {
    /// The operating system, as Rust names it: `linux`, `macos`, `windows`.
    pub system: &'static str,
    pub kernel: Option<String>,
    /// True if the kernel is `PREEMPT_RT`.
    pub preempt_rt: Option<bool>,
    /// Processors that this process may use.
    pub cores: usize,
    /// True if the processor says that it is virtual.
    pub virtual_machine: bool,
    pub governors: Vec<String>,
    /// Time that real-time threads may run in each 1 s, µs; −1 for always.
    pub rt_runtime_us: Option<i64>,
    /// Longest time to wake from an idle state that is enabled, µs.
    pub idle_exit_us: Option<u32>,
    /// USB serial adapters that hold bytes back for more than 1 ms: name, ms.
    pub latency_timers_ms: Vec<(String, u32)>,
    /// Processes that wanted to run, mean of the last minute.
    pub load: Option<f64>,
}

impl Machine {
    /// Looks into `proc` and `sys` in this folder, `/` but for tests.
    fn inspect(root: &Path) -> Self {
        let (system, cores) = (
            std::env::consts::OS,
            std::thread::available_parallelism().map_or(1, usize::from),
        );
        if system != "linux" {
            // A folder `/proc` of another system says nothing of it.
            return Self {
                system,
                cores,
                ..Self::default()
            };
        }
        let text = |path: &str| fs::read_to_string(root.join(path)).ok();
        let line = |path: &str| text(path).map(|text| text.trim().to_owned());
        let version = text("proc/version");
        let realtime = line("sys/kernel/realtime").is_some_and(|flag| flag == "1");
        let cpus = children(root, "sys/devices/system/cpu", "cpu");
        let governors: BTreeSet<String> = cpus
            .iter()
            .filter_map(|cpu| line(&format!("{cpu}/cpufreq/scaling_governor")))
            .collect();
        let idle_states = cpus
            .iter()
            .flat_map(|cpu| children(root, &format!("{cpu}/cpuidle"), "state"));
        let adapters = children(root, "sys/bus/usb-serial/devices", "tty");
        Self {
            system,
            kernel: line("proc/sys/kernel/osrelease"),
            preempt_rt: version.map(|version| realtime || version.contains("PREEMPT_RT")),
            cores,
            virtual_machine: text("proc/cpuinfo").is_some_and(|text| {
                let mut words = text.lines().filter(|line| line.starts_with("flags"));
                words.any(|flags| flags.split_whitespace().any(|flag| flag == "hypervisor"))
            }),
            governors: governors.into_iter().collect(),
            rt_runtime_us: line("proc/sys/kernel/sched_rt_runtime_us")
                .and_then(|us| us.parse().ok()),
            idle_exit_us: idle_states
                .filter(|state| line(&format!("{state}/disable")).is_none_or(|flag| flag == "0"))
                .filter_map(|state| line(&format!("{state}/latency"))?.parse().ok())
                .max(),
            latency_timers_ms: adapters
                .iter()
                .filter_map(|adapter| {
                    let ms: u32 = line(&format!("{adapter}/latency_timer"))?.parse().ok()?;
                    let name = adapter.rsplit('/').next()?.to_owned();
                    (ms > 1).then_some((name, ms))
                })
                .collect(),
            load: line("proc/loadavg").and_then(|load| load.split(' ').next()?.parse().ok()),
        }
    }

    /// Changes to make, the most useful first; those that cost something only where a rate is not fit.
    fn advice(&self, fallback: Option<Fallback>, rates: &[Rate], stolen_ms: u64) -> Vec<String> {
        let mut advice = Vec::new();
        let mut say = |sentence: String| advice.push(sentence);
        if let Some(fallback) = fallback {
            say(format!("permissions: {fallback}"));
        }
        for (name, ms) in &self.latency_timers_ms {
            say(format!(
                "latency timer: the adapter {name} holds bytes back for {ms} ms: as root, \
                 echo 1 > /sys/bus/usb-serial/devices/{name}/latency_timer"
            ));
        }
        let governors = self.governors.iter().map(String::as_str);
        let slow: Vec<&str> = governors.filter(|name| *name != "performance").collect();
        if !slow.is_empty() {
            say(format!(
                "governor: {} changes the frequency while the loop runs: as root, cpupower frequency-set -g \
                 performance",
                slow.join(", ")
            ));
        }
        if rates.iter().all(|rate| rate.fit != Some(false)) {
            return advice;
        }
        if self.preempt_rt == Some(false) {
            say(
                "kernel: not PREEMPT_RT, so drivers and other system calls may delay the loop: install a \
                 real-time kernel (linux-image-rt on Debian, the real-time kernel of Ubuntu Pro)"
                    .to_owned(),
            );
        }
        if self.virtual_machine {
            let stolen = if stolen_ms >= STOLEN_NOTABLE_MS {
                format!("; it did for {stolen_ms} ms in this measurement")
            } else {
                String::new()
            };
            say(format!(
                "virtual machine: its host may stop it for milliseconds, whatever its settings{stolen}: measure and \
                 run on the machine itself"
            ));
        }
        if let Some(us) = self.idle_exit_us.filter(|us| *us > DEEP_SLEEP_US) {
            say(format!(
                "idle states: a processor may take {us} µs to wake: as root, cpupower idle-set -D {DEEP_SLEEP_US}"
            ));
        }
        if let Some(runtime_us) = self.rt_runtime_us.filter(|us| *us >= 0) {
            say(format!(
                "RT throttling: no thread may spin for more than {} ms of a second: keep the tick short",
                runtime_us / 1000
            ));
        }
        if self.system == "windows" {
            say(
                "power: Windows slows processors and USB ports down to save power: plug the charger in, choose the plan \
                 High performance (powercfg /setactive SCHEME_MIN) and switch off USB selective suspend in it"
                    .to_owned(),
            );
        } else if self.system == "macos" {
            say(
                "power: macOS delays wake-ups to save power: plug the charger in, switch off Low Power Mode, and start \
                 this program with caffeinate -i"
                    .to_owned(),
            );
        }
        if self.system != "linux" {
            say(
                "system: it keeps no core and no memory for one program: close what is not needed, let the device run \
                 the loop if it can, or use Linux"
                    .to_owned(),
            );
        } else if self.cores > 1 {
            say(format!(
                "interrupts: keep a core free for the loop with the kernel's isolcpus=N irqaffinity=…, and give {}",
                PIN.set_to("N")
            ));
        }
        if let Some(load) = self.load.filter(|load| *load > self.cores as f64) {
            say(format!(
                "load: {load} processes wanted to run on {} cores in the last minute: stop what is not needed",
                self.cores
            ));
        }
        advice
    }
}

/// Paths in a folder whose name is `prefix` and something that starts with a digit or letter, in order, relative to the root.
fn children(root: &Path, folder: &str, prefix: &str) -> Vec<String> {
    let numbered = |name: &str| {
        let rest = name.strip_prefix(prefix)?;
        // "cpufreq" and "cpuidle" are no processors.
        let last = rest.chars().next_back()?;
        last.is_ascii_digit().then(|| format!("{folder}/{name}"))
    };
    let entries = fs::read_dir(root.join(folder)).into_iter().flatten();
    let mut found: Vec<String> = entries
        .filter_map(|entry| numbered(entry.ok()?.file_name().to_str()?))
        .collect();
    found.sort();
    found
}

/// Time that the host of a virtual machine gave to others, ms; all processors together, since the start.
fn stolen_ms(root: &Path) -> Option<u64> {
    let text = fs::read_to_string(root.join("proc/stat")).ok()?;
    let ticks: u64 = text
        .lines()
        .next()?
        .split_whitespace()
        .nth(8)?
        .parse()
        .ok()?;
    // In hundredths of a second, by the definition of this file.
    Some(10 * ticks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_loop::realtime::SystemRefusal;
    use haptic_run::realtime::Microseconds;

    fn rate(fit: bool) -> Rate {
        Rate {
            hz: 1000.0,
            lateness_us: Microseconds {
                p50: 0.0,
                p99: 0.0,
                p999: 0.0,
                max: 0.0,
            },
            overruns: 0,
            skipped_periods: 0,
            cycles: 1,
            worst_cycle: None,
            spin_margin_us: 0.0,
            fit: Some(fit),
            fit_reason: None,
        }
    }

    /// A folder like `/` with these files.
    fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        for (path, text) in files {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().expect("not the root")).expect("makes");
            fs::write(path, text).expect("writes");
        }
        root
    }

    #[test]
    fn what_a_bad_machine_says_of_itself_becomes_advice() {
        let root = root(&[
            ("proc/version", "Linux version 6.1 #1 SMP PREEMPT_DYNAMIC\n"),
            ("proc/sys/kernel/osrelease", "6.1\n"),
            ("proc/sys/kernel/sched_rt_runtime_us", "950000\n"),
            (
                "proc/cpuinfo",
                "processor: 0\nflags\t\t: fpu hypervisor sse\n",
            ),
            ("proc/loadavg", "9999.50 1 1 1/2 3\n"),
            (
                "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
                "powersave\n",
            ),
            (
                "sys/devices/system/cpu/cpu1/cpufreq/scaling_governor",
                "powersave\n",
            ),
            ("sys/devices/system/cpu/cpu0/cpuidle/state0/latency", "0\n"),
            (
                "sys/devices/system/cpu/cpu0/cpuidle/state2/latency",
                "170\n",
            ),
            (
                "sys/devices/system/cpu/cpu0/cpuidle/state3/latency",
                "900\n",
            ),
            ("sys/devices/system/cpu/cpu0/cpuidle/state3/disable", "1\n"),
            ("sys/devices/system/cpu/cpufreq/boost", "1\n"),
            ("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n"),
            ("sys/bus/usb-serial/devices/ttyUSB1/latency_timer", "1\n"),
        ]);
        let machine = Machine::inspect(root.path());
        assert_eq!(machine.kernel.as_deref(), Some("6.1"));
        assert_eq!(machine.preempt_rt, Some(false));
        assert_eq!(machine.governors, ["powersave"]);
        assert_eq!(machine.idle_exit_us, Some(170));
        assert_eq!(machine.latency_timers_ms, [("ttyUSB0".to_owned(), 16)]);
        let fallback = Fallback {
            priority: Some((80, SystemRefusal::NotPermitted)),
            ..Fallback::default()
        };
        let advice = machine.advice(Some(fallback), &[rate(true), rate(false)], 20);
        for part in [
            "permissions: no real-time priority 80",
            "latency timer: the adapter ttyUSB0 holds bytes back for 16 ms",
            "governor: powersave",
            "kernel: not PREEMPT_RT",
            "it did for 20 ms",
            "may take 170 µs",
            "more than 950 ms of a second",
            "9999.5 processes",
        ] {
            let is_advised = advice.iter().any(|sentence| sentence.contains(part));
            assert!(is_advised, "\"{part}\" in {advice:#?}");
        }
    }

    #[test]
    fn each_system_hears_what_can_be_done_on_it() {
        for (system, advised, omitted) in [
            ("windows", "powercfg", "isolcpus"),
            ("macos", "caffeinate", "isolcpus"),
            ("linux", "isolcpus", "powercfg"),
        ] {
            let machine = Machine {
                system,
                cores: 2,
                ..Machine::default()
            };
            let advice = machine.advice(None, &[rate(false)], 0).join("\n");
            assert!(advice.contains(advised), "{system}: {advice}");
            assert!(!advice.contains(omitted), "{system}: {advice}");
            assert_eq!(machine.advice(None, &[rate(true)], 0), [""; 0]);
        }
    }

    #[test]
    fn a_machine_that_is_fit_hears_only_what_costs_nothing() {
        let root = root(&[
            ("proc/version", "Linux version 6.1 #1 SMP PREEMPT_DYNAMIC\n"),
            ("proc/sys/kernel/sched_rt_runtime_us", "950000\n"),
            ("proc/cpuinfo", "flags : hypervisor\n"),
            (
                "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
                "performance\n",
            ),
        ]);
        let machine = Machine::inspect(root.path());
        assert_eq!(machine.advice(None, &[rate(true)], 1000), [""; 0]);
    }

    #[test]
    fn a_real_time_kernel_is_known_by_its_version_or_its_flag() {
        let by_version = root(&[("proc/version", "Linux version 6.12 #1 SMP PREEMPT_RT\n")]);
        let by_flag = root(&[
            ("proc/version", "Linux 5.15\n"),
            ("sys/kernel/realtime", "1\n"),
        ]);
        for root in [by_version, by_flag] {
            assert_eq!(Machine::inspect(root.path()).preempt_rt, Some(true));
        }
        // Another system says nothing, and is not told to change its kernel.
        let nothing = Machine::inspect(root(&[]).path());
        assert_eq!(nothing.preempt_rt, None);
        let advice = nothing.advice(None, &[rate(false)], 0);
        assert!(!advice.iter().any(|sentence| sentence.contains("kernel:")));
    }

    #[test]
    fn stolen_time_is_the_eighth_number() {
        let root = root(&[("proc/stat", "cpu  1 2 3 4 5 6 7 833 0 0\ncpu0 1 2\n")]);
        assert_eq!(stolen_ms(root.path()), Some(8330));
    }
}
