//! Facts of a machine, and what could be better.

use super::rate::Rate;
use crate::document::parameters::PIN;
use haptic_loop::realtime::Fallback;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// An idle processor that takes longer to wake, µs, costs jitter.
const DEEP_SLEEP_US: u32 = 30;
/// Time stolen by the host that is worth a sentence, ms.
const STOLEN_NOTABLE_MS: u64 = 10;

/// Facts of the machine. Those that a system does not tell are null or empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Machine {
    /// Release of the kernel.
    pub kernel: Option<String>,
    /// True if the kernel is `PREEMPT_RT`.
    pub preempt_rt: Option<bool>,
    /// Processors that this process may use.
    pub cores: usize,
    /// True if the processor says that it is virtual.
    pub virtual_machine: bool,
    /// Frequency governors in use.
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
    #[must_use]
    pub(crate) fn inspect(root: &Path) -> Self {
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
            kernel: line("proc/sys/kernel/osrelease"),
            preempt_rt: version.map(|version| realtime || version.contains("PREEMPT_RT")),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
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

    /// Changes to make, the most useful first.
    #[must_use]
    pub(crate) fn advice(
        &self,
        fallback: Option<Fallback>,
        rates: &[Rate],
        stolen_ms: u64,
    ) -> Vec<String> {
        let mut advice = Vec::new();
        let unfit = rates.iter().any(|rate| !rate.fit);
        advice.extend(fallback.map(|fallback| format!("permissions: {fallback}")));
        for (name, ms) in &self.latency_timers_ms {
            advice.push(format!(
                "latency timer: the adapter {name} holds bytes back for {ms} ms: as root, \
                 echo 1 > /sys/bus/usb-serial/devices/{name}/latency_timer"
            ));
        }
        let slow: Vec<&str> = self
            .governors
            .iter()
            .map(String::as_str)
            .filter(|governor| *governor != "performance")
            .collect();
        if !slow.is_empty() {
            advice.push(format!(
                "governor: {} changes the frequency while the loop runs: as root, cpupower frequency-set -g \
                 performance",
                slow.join(", ")
            ));
        }
        if unfit {
            advice.extend(self.costly_advice(stolen_ms));
        }
        advice
    }

    /// Changes that cost something: said only where a rate is not fit.
    fn costly_advice(&self, stolen_ms: u64) -> Vec<String> {
        let mut advice = Vec::new();
        if self.preempt_rt == Some(false) {
            advice.push(
                "kernel: not PREEMPT_RT, so drivers and other system calls may hold the loop up: install a \
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
            advice.push(format!(
                "virtual machine: its host may stop it for milliseconds, whatever is set here{stolen}: measure and \
                 run on the machine itself"
            ));
        }
        if let Some(us) = self.idle_exit_us.filter(|us| *us > DEEP_SLEEP_US) {
            advice.push(format!(
                "idle states: a processor may take {us} µs to wake: as root, cpupower idle-set -D {DEEP_SLEEP_US}"
            ));
        }
        if let Some(runtime_us) = self.rt_runtime_us.filter(|us| *us >= 0) {
            advice.push(format!(
                "RT throttling: real-time threads that compute and spin for more than {} ms of a second are stopped \
                 for the rest of it: keep the tick short, or, as root, sysctl -w kernel.sched_rt_runtime_us=-1",
                runtime_us / 1000
            ));
        }
        if self.cores > 1 {
            advice.push(
                format!("interrupts: keep a core free for the loop with the kernel's isolcpus=N irqaffinity=…, and give \
                 {pin_n}", pin_n = PIN.set_to("N")),
            );
        }
        if let Some(load) = self.load.filter(|load| *load > self.cores as f64) {
            advice.push(format!(
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
pub(super) fn stolen_ms(root: &Path) -> Option<u64> {
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
    use crate::run::realtime::Microseconds;
    use haptic_loop::realtime::Refusal;

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
            fit,
            plain: None,
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
            priority: Some((80, Refusal::NotPermitted)),
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
            let said = advice.iter().any(|sentence| sentence.contains(part));
            assert!(said, "\"{part}\" in {advice:#?}");
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
