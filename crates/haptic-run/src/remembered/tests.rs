use super::*;
use crate::identity::{Told, tests::port};
use haptic_link::SerialNumber;
use tempfile::tempdir;
use testkit::{Random, Tested, assert_refused, assert_says};

/// A device by its number, or by nothing.
fn identity(board: &str, number: Option<&str>) -> DeviceIdentity {
    let number = number.map(|number| SerialNumber::named(number).expect("a number"));
    let told = Told {
        board,
        number: number.unwrap_or(SerialNumber::NONE),
        simulated: false,
        path: "/dev/ttyACM0",
        shares_port: false,
    };
    DeviceIdentity::of(told, &[])
}

fn force(force_n: f32) -> Configuration {
    let limits = Limits {
        force_n,
        ..Limits::DEFAULT
    };
    Configuration {
        limits,
        ..Configuration::PASSIVE
    }
}

#[test]
fn whatever_was_set_is_read_again_bit_for_bit() {
    let device = identity("a \"board\"", Some("E6612483CB1B9221"));
    let mut random = Random(84);
    for _ in 0..500 {
        let mut kept = Kept {
            board: device.board.clone(),
            turn: 3,
            set: Configuration {
                tick_period_us: 250,
                ..Configuration::PASSIVE
            },
        };
        let limits = &mut kept.set.limits;
        for limit in Limit::ALL {
            let [least, most] = limit.range();
            *limits.number(limit).0 = random.log_between(least.max(1e-37), most) as f32;
        }
        limits.workspace_low_m = -random.log_between(1e-6, 100.0) as f32;
        limits.guard.kind = GuardKind::Observer;
        limits.guard.noise_m = random.log_between(1e-9, 1e-2) as f32;
        limits.device_delay_ticks = random.bits() as u8;
        let text = kept.text(&device);
        assert!(
            Limit::ALL.iter().all(|limit| text.contains(limit.key())),
            "{text}"
        );
        assert_eq!(Kept::read(&text), Ok(kept));
    }
}

#[test]
fn what_is_missing_has_its_default_and_what_is_unknown_is_refused_with_all_that_there_is() -> Tested
{
    let kept = Kept::read("format = 1\nforce_limit_n = 0.5\nworkspace_low_m = -1\n");
    let limits = kept.expect("reads").set.limits;
    let expected = Limits {
        workspace_low_m: -1.0,
        ..force(0.5).limits
    };
    assert_eq!(limits, expected);
    let folder = tempdir()?;
    let place = Remembered::within(
        identity("board", Some("E6612483CB1B9221")),
        Some(folder.path().to_owned()),
    );
    let file = place.file(folder.path());
    for (text, words) in [
        ("force_limit_n = 0.5", "no format & force_limit_n = 0.5"),
        (
            "format = 2\ntorque_nm = 1",
            "format = 2 is not of & torque_nm = 1",
        ),
        (
            "format = 1\ntorque_nm = 1\nforce_limit_n = 0.5",
            "torque_nm = 1 is not of & force_limit_n = 0.5",
        ),
        ("format = 1\nforce_limit_n = -1", "a limit is below 0"),
        ("format = 1\nforce_limit_n = nan", "force_limit_n = nan"),
        ("format = 1\nguard_kind = \"Strict\"", "Strict & guard_kind"),
        (
            "format = 1\nworkspace_low_m = 2\nworkspace_high_m = 1",
            "ends before it begins & workspace_low_m = 2",
        ),
        ("half a li", "not a file of limits & half a li"),
    ] {
        fs::write(&file, text)?;
        let refusal = place.set();
        assert_refused(
            refusal,
            &format!("E6612483CB1B9221 & {words} & device forget"),
        );
        // Whoever has another number does not mind; whoever has none may be this one.
        let other = Remembered::within(identity("board", Some("B0B0B0")), place.folder.clone());
        assert_eq!(other.set()?, None);
        let nameless = Remembered::within(identity("board", None), place.folder.clone());
        assert_refused(nameless.set(), "remove that file");
        assert_says(&place.forget()?.expect("some"), &text.replace('\n', ", "));
    }
    let older = folder.path().join("board-20-at-20-x.json");
    fs::write(
        &older,
        "{\n  \"device\": \"board at x\",\n  \"force_n\": 0.5\n}",
    )?;
    assert_refused(
        place.set(),
        "earlier version & \"force_n\": 0.5 & remove that file & device set",
    );
    Ok(())
}

#[test]
fn who_cannot_be_told_apart_has_the_tighter_of_all_of_its_name_and_loosens_none() -> Tested {
    let folder = tempdir()?;
    let place = |number| Remembered::within(identity("board", number), Some(folder.path().into()));
    let all = [Some("B0B0B1"), Some("B0B0B2"), None].map(place);
    let [one, two, nameless] = &all;
    let have_n = |expected: [f32; 3]| {
        let have = all
            .each_ref()
            .map(|place| place.set().expect("reads").expect("some"));
        let same =
            |(have, expected): (&Configuration, f32)| (have.limits.force_n - expected).abs() <= 0.0;
        assert!(have.iter().zip(expected).all(same), "{expected:?}");
    };
    assert!(one.keep(&force(2.0))? && two.keep(&force(0.5))?);
    have_n([2.0, 0.5, 0.5]);
    let words = "board without a serial number & from 500 mN to 1 N & device forget";
    assert_refused(nameless.admits(&force(1.0)), words);
    one.admits(&force(9.0))?;
    nameless.admits(&force(0.2))?;
    nameless.keep(&force(0.2))?;
    // They may have been the one without a number, until they are set themselves.
    have_n([0.2, 0.2, 0.2]);
    one.keep(&force(3.0))?;
    have_n([3.0, 0.2, 0.2]);
    let gone = nameless.forget()?.expect("some");
    assert_says(&gone, "force_limit_n = 0.2");
    have_n([3.0, 0.5, 0.5]);
    Ok(())
}

#[test]
fn two_devices_are_two_files() {
    let devices = [
        "at x/y",
        "At x/y",
        "at X/y",
        "at x-2f-y",
        "at-20-x/y",
        "number x",
    ];
    let mut names = devices.map(|device| file_name(device).to_lowercase());
    names.sort();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    assert!(names.iter().all(|name| name.chars().all(is_plain)));
}

/// `CAMPAIGN_CASES`: orders of events, 20 by default: replugged, exchanged, power cut, flashed without a number, set, forgotten, run.
#[test]
fn no_board_runs_with_a_looser_limit_than_was_set_on_it_wherever_it_is_plugged_in() -> Tested {
    /// Number that the board tells, and that of its USB port; limits that it has, and those that were set last, with their file.
    struct Board {
        name: &'static str,
        numbers: [Option<&'static str>; 2],
        port: usize,
        has: Configuration,
        set: Option<(f32, PathBuf)>,
    }
    let (mut runs, mut limited) = (0, 0);
    for order in 0..testkit::cases(20) {
        let mut random = Random(8200 + order);
        let mut pick = |below: usize| random.bits() as usize % below;
        let folder = tempdir()?;
        let kinds = [
            ("rp2040", [Some("E6612483CB1B9221"), None]),
            ("rp2040", [Some("E6612483CB1B9222"), None]),
            ("mine", [None, Some("A50285BI")]),
            ("mine", [None, None]),
            ("mine", [None, None]),
        ];
        let mut boards: Vec<Board> = (kinds.into_iter().enumerate())
            .map(|(port, (name, numbers))| Board {
                name,
                numbers,
                port,
                has: Configuration::PASSIVE,
                set: None,
            })
            .collect();
        for _ in 0..60 {
            let usb = boards
                .iter()
                .filter_map(|board| Some((board.port, board.numbers[1]?)));
            let ports: Vec<_> = usb
                .map(|(at, number)| port(&format!("/dev/ttyACM{at}"), number))
                .collect();
            let which = pick(boards.len());
            let (to, event) = (pick(boards.len()), pick(10));
            let board = &mut boards[which];
            let number = board.numbers[0].and_then(SerialNumber::named);
            let told = Told {
                board: board.name,
                number: number.unwrap_or(SerialNumber::NONE),
                simulated: false,
                path: &format!("/dev/ttyACM{}", board.port),
                shares_port: false,
            };
            let identity = DeviceIdentity::of(told, &ports);
            let place = Remembered::within(identity, Some(folder.path().to_owned()));
            let file = place.file(folder.path());
            match event {
                0 => board.has = Configuration::PASSIVE,
                // With the board there, or with another port's.
                1 | 2 => {
                    let (from, at) = (boards[which].port, boards[to].port);
                    for (index, port) in [(to, from), (which, at)] {
                        boards[index].port = port;
                        boards[index].has = Configuration::PASSIVE;
                    }
                }
                // The firmware of before, and the new one again.
                3 if which < 2 => {
                    let told = kinds[which].1[0];
                    board.numbers[0] = told.filter(|_| board.numbers[0].is_none());
                    board.has = Configuration::PASSIVE;
                }
                4..6 => {
                    let force_n = [0.1, 0.5, 2.0, 5.0][to % 4];
                    let mut next = board.has;
                    next.limits = place.tightened(&next)?.unwrap_or(next.limits);
                    next.limits.force_n = force_n;
                    if place.admits(&next).is_ok() {
                        place.keep(&next)?;
                        (board.has, board.set) = (next, Some((force_n, file)));
                    }
                }
                6 if to == 0 => {
                    place.forget()?;
                    // Whoever has no number shares the file.
                    for board in &mut boards {
                        board.set.take_if(|(_, under)| *under == file);
                    }
                }
                _ => {
                    let limits = place.tightened(&board.has)?;
                    board.has.limits = limits.unwrap_or(board.has.limits);
                    let has_n = board.has.limits.force_n;
                    let most_n = board.set.as_ref().map_or(f32::MAX, |(most_n, _)| *most_n);
                    let device = place.identity();
                    assert!(
                        has_n <= most_n,
                        "order {order}: {has_n} N on {device}, {most_n} N were set"
                    );
                    runs += 1;
                    limited += u32::from(most_n < 10.0);
                }
            }
        }
    }
    println!("{runs} runs, {limited} of them on a board that was set: none with a looser limit");
    assert!(limited > runs / 5, "{limited} of {runs}");
    Ok(())
}
