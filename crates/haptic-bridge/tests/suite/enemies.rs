//! Hosts that are killed, flood, fall mute or speak another version: the force is zero within watchdog and stop time.

use crate::{
    bench::{Bench, STOP_TICKS, WATCHDOG_MS, description, wall},
    mutants::framed,
};
use haptic_link::{
    Configuration, FRAME_MAX, Header, LoopMode, PROTOCOL_VERSION, Request, Start, encode,
};
use haptic_loop::Fault;
use testkit::Random;

#[derive(Clone, Copy, Debug)]
enum Enemy {
    /// It is gone, and nobody reads.
    Killed,
    /// Requests without end, and nobody reads the answers.
    Floods,
    /// Garbage without end.
    Babbles,
    /// It reads, and says nothing.
    Mute,
    /// Frames of another version.
    OtherVersion,
}

const ENEMIES: [Enemy; 5] = [
    Enemy::Killed,
    Enemy::Floods,
    Enemy::Babbles,
    Enemy::Mute,
    Enemy::OtherVersion,
];

/// A frame of a stranger, with the CRC of its own version.
fn foreign() -> Vec<u8> {
    framed(vec![PROTOCOL_VERSION + 1, 0, 0, 0, 0, 0, 0, 0, 0, 1])
}

fn attack(bench: &mut Bench, enemy: Enemy, random: &mut Random) {
    let mut frame = [0; FRAME_MAX];
    match enemy {
        Enemy::Killed => {}
        Enemy::Floods => {
            for _ in 0..20 {
                let length = bench.host.tell(&Request::GetStatistics, &mut frame);
                bench.line.take(&frame[..length]);
            }
        }
        Enemy::Babbles => {
            let bytes: Vec<u8> = (0..200).map(|_| random.bits() as u8).collect();
            bench.line.take(&bytes);
        }
        Enemy::Mute => while bench.line.next(&mut frame) > 0 {},
        Enemy::OtherVersion => bench.line.take(&foreign()),
    }
}

/// Runs as many episodes as it takes for so many ticks.
fn campaign(ticks_most: u64) {
    let mut random = Random(58);
    let mut bench = Bench::running(&description(3));
    let begun_us = bench.time_us;
    let mut episodes = 0;
    while bench.time_us - begun_us < 1000 * ticks_most {
        let enemy = ENEMIES[episodes % ENEMIES.len()];
        let before = bench.norm_n();
        assert!(before > 0.5, "{enemy:?}");
        bench.is_there = false;
        let mut silent_ticks = 0;
        while bench.norm_n() > 0.0 {
            attack(&mut bench, enemy, &mut random);
            bench.tick();
            silent_ticks += 1;
            // A flood of the owner feeds the watchdog until its answers find no room.
            let feeding = 400 * u32::from(matches!(enemy, Enemy::Floods));
            let most = u32::from(WATCHDOG_MS) + STOP_TICKS + feeding + 2;
            assert!(silent_ticks <= most, "{enemy:?}: {} N", bench.norm_n());
        }
        assert_eq!(bench.handle.fault(), Some(Fault::HostSilent), "{enemy:?}");
        for _ in 0..random.bits() % 500 {
            attack(&mut bench, enemy, &mut random);
            bench.tick();
            assert_eq!(bench.force_n, [0.0; 3], "{enemy:?}");
        }
        // The next host finds a device that works.
        bench.is_there = true;
        bench.line.take(&[0]);
        bench.steps(2000);
        episodes += 1;
        bench.arm();
        bench.start();
        if matches!(enemy, Enemy::OtherVersion) {
            let statistics = bench.statistics();
            assert!(statistics.foreign > 10, "{statistics:?}");
        }
    }
    assert!(episodes >= ENEMIES.len());
    assert_eq!(bench.allocations, 0);
}

#[test]
fn bad_hosts_leave_no_force_and_the_next_one_finds_a_device() {
    campaign(15_000);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_million_ticks_with_bad_hosts_leave_no_force() {
    campaign(1_000_000);
}

#[test]
fn a_frame_that_this_version_knows_is_not_foreign() {
    // The enemy's frame differs from a good one by its version alone.
    let mut good = [0; FRAME_MAX];
    let length = encode(
        &Request::GetCapabilities,
        Header::from_host(0, 0),
        &mut good,
    )
    .expect("fits");
    assert_eq!(good[..length].len(), foreign().len());
}

#[test]
fn a_silence_that_the_program_does_not_allow_ends_a_run_before_the_watchdog_of_its_host() {
    let mut bench = Bench::running(&haptic_bridge::Description {
        watchdog_ms: 20,
        ..description(1)
    });
    bench.is_there = false;
    let ticks = bench.falls(Fault::HostSilent, 22);
    assert!(ticks >= 10, "{ticks}");
}

#[test]
fn a_host_that_is_to_compute_the_force_and_only_says_that_it_is_there_is_silent() {
    let mut bench = Bench::new(&haptic_bridge::Description {
        watchdog_ms: 20,
        ..description(1)
    });
    let configuration = Configuration {
        loop_mode: LoopMode::Host,
        ..wall().0
    };
    bench.configure(&configuration, &wall().1);
    bench.arm();
    bench.done(Request::Start(Start {
        run: 1,
        ..Start::ENDLESS
    }));
    let mut frame = [0; FRAME_MAX];
    let mut push = |bench: &mut Bench| {
        let newest = crate::mutants::newest(&bench.reports);
        let force = Request::Force {
            tick: newest,
            force_n: [1.0].into_iter().collect(),
        };
        let length = bench.host.tell(&force, &mut frame);
        bench.line.take(&frame[..length]);
        bench.step();
    };
    for _ in 0..100 {
        push(&mut bench);
    }
    assert!(bench.norm_n() > 0.5, "{:?}", bench.force_n);
    // Its keep-alives come every 10 ms.
    bench.falls(Fault::HostSilent, 22);
}
