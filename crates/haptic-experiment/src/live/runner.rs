//! The loop of a session: a run like any other, on a simulated device or steered on one at a port.

use super::{
    ticking::{Around, FadingFelt, FeltController, HandPath, LoopOrder, Looping},
    waiting::Gate,
};
use haptic_loop::{Controller, Engaged, LoopSample};
use haptic_message::{EventMessage, TickMessage};
use haptic_run::remote::{Steered, Steers};
use haptic_trial::{ending::Ending, in_hand::hand::HeldDevice, simulate::World, tick::by_loop};
use std::sync::{Arc, atomic::AtomicBool};

/// A simulated device with a hand that goes a way.
pub(super) struct HeldWorld<'a> {
    engaged: Engaged<f64, 1, FadingFelt, &'a mut HeldDevice, &'a mut FeltController>,
    looping: Looping,
    /// Lets time go on; `None` by the clock.
    gate: Option<Arc<Gate>>,
    stop: &'a AtomicBool,
    path: HandPath,
    path_from_s: f64,
    time_s: f64,
    ending: bool,
}

impl<'a> HeldWorld<'a> {
    pub(super) fn new(
        controller: &'a mut FeltController,
        device: &'a mut HeldDevice,
        looping: Looping,
        gate: Option<Arc<Gate>>,
        stop: &'a AtomicBool,
    ) -> Self {
        Self {
            engaged: controller.engage(device),
            looping,
            gate,
            stop,
            path: HandPath::default(),
            path_from_s: 0.0,
            time_s: 0.0,
            ending: false,
        }
    }

    fn obey(&mut self) {
        while let Some(order) = self.looping.order() {
            if let LoopOrder::Path(path) = order {
                let before = std::mem::replace(&mut self.path, path);
                self.looping.spend(Box::new(before));
                self.path_from_s = self.time_s;
            }
        }
        if self.looping.is_done() && !self.ending {
            self.ending = true;
            self.engaged.controller_mut().stop();
        }
        let since_s = self.time_s - self.path_from_s;
        if let Some(place_m) = place_at(&self.path, since_s) {
            self.engaged.device_mut().hand(place_m, true);
        }
    }
}

/// Place on a way at a time, s; its last from then on.
fn place_at(path: &[(f64, f64)], time_s: f64) -> Option<f64> {
    let next = path.partition_point(|(at_s, _)| *at_s <= time_s);
    let Some(&(to_s, to_m)) = path.get(next) else {
        return path.last().map(|(_, place_m)| *place_m);
    };
    let Some(&(from_s, from_m)) = next.checked_sub(1).and_then(|before| path.get(before)) else {
        return Some(to_m);
    };
    Some(from_m + (to_m - from_m) * (time_s - from_s) / (to_s - from_s))
}

impl World for HeldWorld<'_> {
    type Message = TickMessage;

    fn tick(&mut self) -> TickMessage {
        if let Some(gate) = &self.gate {
            gate.pass(self.looping.next(), self.stop);
        }
        self.obey();
        let hand_m = self.engaged.device().hand_m();
        let Ok(sample) = self.engaged.tick();
        self.looping.heard(self.engaged.controller_mut(), &sample);
        let hand_force_n = self.engaged.device().hand_force_n();
        let around = Around {
            hand_m,
            hand_force_n,
            ..Around::UNKNOWN
        };
        self.looping
            .report(self.engaged.controller(), &sample, around);
        self.time_s = sample.reading.time_s;
        let message = TickMessage {
            reference_m: hand_m.into(),
            indenter_position_m: hand_m.into(),
            contact_force_n: hand_force_n.into(),
            ..TickMessage::unknown(1)
        };
        by_loop(message, &sample, None)
    }

    fn ended(&self) -> Option<Ending> {
        let fault = self.engaged.controller().safety().fault();
        fault.map(Ending::Fault)
    }

    fn stop(&mut self) {
        self.looping.stopping = true;
        self.engaged.controller_mut().stop();
        self.engaged.device_mut().hand_lets_go();
        self.path = HandPath::default();
    }

    fn is_at_rest(&self) -> bool {
        self.engaged.controller().safety().is_at_rest()
    }

    fn event(&mut self) -> Option<EventMessage> {
        self.looping.event(self.time_s)
    }

    fn is_over(&self) -> bool {
        self.ending && self.is_at_rest()
    }
}

/// The law of a device at a port, changed between its ticks.
pub(super) struct Steering(pub Looping);

impl Steers<f64, FadingFelt, 1> for Steering {
    fn steer(
        &mut self,
        controller: &mut Controller<f64, 1, FadingFelt>,
        sample: &LoopSample<f64, 1>,
    ) -> Steered {
        let looping = &mut self.0;
        looping.heard(controller, sample);
        looping.report(controller, sample, Around::UNKNOWN);
        // Nobody here has the hand of somebody.
        while looping.order().is_some() {}
        if looping.is_done() {
            Steered::Over
        } else {
            Steered::On(looping.event(sample.reading.time_s))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::place_at;

    #[test]
    fn a_hand_goes_evenly_from_place_to_place_and_stays_at_the_last() {
        let path = [(0.5, 1.0), (1.0, 3.0), (2.0, 2.0)];
        for (time_s, want) in [(0.0, 1.0), (0.5, 1.0), (0.75, 2.0), (1.5, 2.5), (9.0, 2.0)] {
            assert_eq!(place_at(&path, time_s), Some(want), "{time_s} s");
        }
        assert_eq!(place_at(&[], 1.0), None);
    }
}
