//! Trials on a device that is silent, that fails, and that has had enough.

use super::*;
use haptic_emulator::moteus::EmulatedAdapter;
use haptic_run::remote::bad_line_tests::quiet;
use haptic_run::remote::bad_line_tests::reported;
use std::sync::Arc;

/// An emulated servo in its own time, which runs and tells no sample; and its adapter.
fn running_without_samples() -> (SerialLink, Arc<Mutex<EmulatedAdapter>>) {
    let (mut link, adapter) = quiet();
    link.arm(Duration::from_secs(1)).expect("arms");
    let rarely = Start {
        every: u16::MAX,
        ..Start::ENDLESS
    };
    link.start(rarely).expect("starts");
    (link, adapter)
}

#[test]
fn a_silence_of_a_device_that_answers_is_no_end_of_the_search() {
    let (mut link, ..) = running_without_samples();
    let patience = Duration::from_millis(20);
    let trial = followed(&mut link, "here", 1000, patience, &mut |_, _, _| true);
    let Ok(Trial::Unjudged(failure)) = trial else {
        panic!("it is to be made again");
    };
    assert!(matches!(failure, Failure::Device(_)), "{failure}");
    // It was let go before anything else.
    assert!(link.wait_for_rest());
}

#[test]
fn a_device_that_does_not_answer_ends_it_with_what_to_look_at() {
    let (mut link, adapter) = running_without_samples();
    let stuck = adapter.lock().expect("nobody panicked with it");
    let patience = Duration::from_millis(20);
    let Err(failure) = followed(&mut link, "here", 1000, patience, &mut |_, _, _| true) else {
        panic!("nothing more can be tried");
    };
    let message = failure.to_string();
    assert!(message.contains("check its plug and supply"), "{message}");
    assert!(matches!(failure, Failure::Device(_)), "{message}");
    drop(stuck);
}

#[test]
fn a_board_that_failed_ends_it_with_its_own_words() {
    let (mut link, adapter) = running_without_samples();
    // Its supply is too low.
    (adapter.lock().expect("nobody panicked with it").servo).fail(40);
    let Err(failure) = followed(&mut link, "here", 1000, SILENCE, &mut |_, _, _| true) else {
        panic!("nothing more can be tried");
    };
    let message = failure.to_string();
    let words = link.trouble().expect("it says why").words;
    assert!(
        message.contains(&words) && message.contains("no more trials"),
        "{message}"
    );
    assert!(matches!(failure, Failure::Device(_)), "{message}");
}

#[test]
fn a_fault_of_the_device_is_no_answer_of_a_wall() {
    for fault in Fault::ALL {
        let (link, ..) = running_without_samples();
        let trial = faulted(&link, reported(fault));
        match fault.code() {
            6 | 7 => assert!(matches!(trial, Ok(Trial::Tripped(was)) if was == fault)),
            2 | 3 | 11 => assert!(matches!(trial, Ok(Trial::Unjudged(_))), "{fault}"),
            _ => {
                let failure = trial
                    .err()
                    .unwrap_or_else(|| panic!("{fault} is no answer"));
                assert!(matches!(failure, Failure::Device(_)), "{failure}");
                assert!(
                    failure.to_string().contains(&fault.to_string()),
                    "{failure}"
                );
            }
        }
    }
}
