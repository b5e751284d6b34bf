//! A board whose sensor fails in the middle of a run.

use crate::line::START;
use crate::witness::Witness;
use haptic_link::{Refusal, State};
use haptic_loop::Fault;
use haptic_remote::{Hardware, TickSide};

#[test]
fn a_board_that_cannot_measure_lets_go_at_once_and_can_be_armed_when_it_is_mended() {
    let mut device = TickSide::new(Witness::new("broken")).expect("works");
    let (configuration, values) = crate::line::spring();
    let capabilities = device.hardware().capabilities();
    let prepared = haptic_remote::prepare::<Witness, 1>(configuration, &values, &capabilities);
    device
        .install(prepared.expect("good"), &values)
        .expect("idle");
    device.arm(0).expect("idle");
    device.start(START).expect("armed");
    let mut now_us = 0;
    let mut tick = |device: &mut TickSide<Witness>| {
        now_us += 1000;
        device.heard(now_us, true);
        device.tick(now_us);
    };
    for _ in 0..100 {
        tick(&mut device);
    }
    assert!(device.hardware().force_n() < -0.5);
    device.hardware_mut().broken = true;
    tick(&mut device);
    assert_eq!(device.hardware().force_n(), 0.0);
    assert_eq!(device.status().state, State::Fault);
    assert_eq!(device.status().fault, Fault::EmergencyStop.code());
    tick(&mut device);
    let persists = Refusal::FaultPersists(Fault::EmergencyStop.code());
    assert_eq!(device.arm(1), Err(persists));
    device.hardware_mut().broken = false;
    tick(&mut device);
    device.arm(1).expect("mended");
    assert_eq!(device.status().state, State::Armed);
}
