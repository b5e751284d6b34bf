//! A device of one's own: an encoder that counts and a motor that takes whole numbers.
//!
//! ```text
//! cargo run -p haptic-loop --example own_device
//! ```

use fracdiff::{Order, Seconds, ShortMemory};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{
    Contact, Controller, Device, LoopSample, Reading, SafeForce, SafetyChain, SpringDamper,
};
use nalgebra::vector;
use std::error::Error;

const SAMPLE_TIME_S: f32 = 1e-3;
const METRES_PER_COUNT: f32 = 5e-6;
/// Digital-to-analogue converter of the motor: 12 bits and a sign, 8 N at the end.
const CODES_PER_NEWTON: f32 = 4095.0 / 8.0;

/// The registers of a board, and a hand that pushes the handle of 80 g in this place of a real one.
#[derive(Debug, Default)]
struct Board {
    encoder_counts: i32,
    motor_code: i16,
    ticks: u64,
    push_n: f32,
    position_m: f32,
    speed_m_per_s: f32,
}

#[derive(Debug)]
struct EncoderAtItsEnd;

impl Device<f32, 1> for Board {
    type Error = EncoderAtItsEnd;

    fn read(&mut self) -> Result<Reading<f32, 1>, EncoderAtItsEnd> {
        if self.encoder_counts.abs() > 20_000 {
            return Err(EncoderAtItsEnd);
        }
        Ok(Reading {
            tick: self.ticks,
            time_s: self.ticks as f64 * f64::from(SAMPLE_TIME_S),
            position_m: vector![self.encoder_counts as f32 * METRES_PER_COUNT],
        })
    }

    // Only a force that has passed the safety chain can be written.
    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), EncoderAtItsEnd> {
        self.motor_code = (force.newtons()[0] * CODES_PER_NEWTON) as i16;
        self.pass_a_sample();
        Ok(())
    }
}

impl Board {
    fn pass_a_sample(&mut self) {
        let hand_n = self.push_n - 4.0 * self.speed_m_per_s;
        let motor_n = f32::from(self.motor_code) / CODES_PER_NEWTON;
        self.speed_m_per_s += (hand_n + motor_n) / 0.08 * SAMPLE_TIME_S;
        self.position_m += self.speed_m_per_s * SAMPLE_TIME_S;
        self.encoder_counts = (self.position_m / METRES_PER_COUNT) as i32;
        self.ticks += 1;
    }
}

/// The loop. Whatever ends it, no force is left on the motor.
fn render(board: &mut Board) -> Result<Option<LoopSample<f32, 1>>, Box<dyn Error>> {
    let t = Seconds(f64::from(SAMPLE_TIME_S));
    let half = ShortMemory::<f32, 256>::new(Order::new(0.5)?, t)?;
    let wall = Contact::at(Metres(2e-3), SpringDamper::new(400.0, 4.0, half)?)?;
    let chain = SafetyChain::new(Newtons(6.0), NewtonsPerSecond(2000.0), t)?;
    let mut controller = Controller::new(wall, chain);
    let mut engaged = controller.engage(board);
    let mut last = None;
    for _ in 0..3000 {
        // The sensor first: after an error of the device it has let go.
        let sample = engaged.tick().map_err(|end| format!("{end:?}"))?;
        if let Some(fault) = sample.fault {
            return Err(fault.to_string().into());
        }
        last = Some(sample);
    }
    Ok(last)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut board = Board {
        push_n: 1.0,
        ..Board::default()
    };
    let last = render(&mut board)?.ok_or("no tick")?;
    let depth_mm = 1e3 * board.position_m - 2.0;
    let force_n = last.force.newtons()[0];
    println!("{depth_mm:.2} mm deep in the wall, {:.2} N back", -force_n);
    // 1 N of the hand against 400 N/m, and what is left of the damper.
    assert!((depth_mm - 2.5).abs() < 0.3, "{depth_mm} mm");
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}

/// A hand that is stronger than the wall pushes the encoder to its end, against all that the motor has.
#[test]
fn no_force_stays_on_the_motor_when_the_device_fails() {
    let mut board = Board {
        push_n: 20.0,
        ..Board::default()
    };
    let ended = render(&mut board).expect_err("the encoder is at its end");
    assert_eq!(ended.to_string(), "EncoderAtItsEnd");
    assert!(board.position_m > 0.1);
    assert_eq!(board.motor_code, 0);
}
