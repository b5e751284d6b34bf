//! Records of known plants: none gains or loses an integrator.
//!
//! The records are closed forms: sums of modes behind a hold and a dead time, noise and the last digit of a file upon them.
//! `CAMPAIGN_CASES` sets how many; 25 unless it is given.

use fractional_control::FractionalTransferFunction;
use fractional_control::model_search::{
    InputOutput, candidates, identify, settles_as_well, shifted,
};
use rayon::prelude::*;
use testkit::Random;

/// r/(s − p).
struct Mode {
    rate: f64,
    residue: f64,
}

/// A plant, what is known of it, and how it was recorded.
struct Case {
    modes: Vec<Mode>,
    /// What passes at once.
    direct: f64,
    integrators: usize,
    /// Dead time, samples; told to the identification or not.
    delay: f64,
    is_told: bool,
    samples: usize,
    /// Noise over the largest output.
    noise: f64,
    /// Digits behind the first that the file keeps of the largest output; `None` for all.
    digits: Option<i32>,
    input: Input,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Input {
    Step,
    Pulses,
    Levels,
}

const T: f64 = 0.01;

impl Input {
    fn signal(self, samples: usize, random: &mut Random) -> Vec<f64> {
        let level = random.one_of(&[1.0, 0.5, 3.0]);
        let mut now = level;
        let mut left = 0;
        let mut next = |_| match self {
            Self::Step => level,
            Self::Pulses | Self::Levels => {
                if left == 0 {
                    left = 1 + (random.share() * 20.0) as usize;
                    now = match self {
                        Self::Pulses => level * random.one_of(&[0.0, 1.0]),
                        _ => level * random.between(-1.0, 1.0),
                    };
                }
                left -= 1;
                now
            }
        };
        (0..samples).map(&mut next).collect()
    }
}

/// (e^(pt) − 1)/p.
fn grown(rate: f64, t: f64) -> f64 {
    if rate == 0.0 {
        t
    } else {
        libm::expm1(rate * t) / rate
    }
}

impl Case {
    fn drawn(kind: u64, random: &mut Random) -> Self {
        let gain = random.log_between(0.05, 20.0);
        let noise = random.chance(0.5);
        let mut case = Self {
            modes: Vec::new(),
            direct: 0.0,
            integrators: 0,
            delay: 0.0,
            is_told: true,
            samples: random.one_of(&[120, 250, 400]),
            noise: if noise {
                random.log_between(1e-4, 0.03)
            } else {
                0.0
            },
            digits: random.one_of(&[None, Some(3), Some(5)]),
            input: random.one_of(&[Input::Step, Input::Pulses, Input::Levels]),
        };
        let lag = |case: &mut Self, time: f64| {
            let rate = -1.0 / time;
            case.modes.push(Mode {
                rate,
                residue: -gain * rate,
            });
        };
        match kind % 7 {
            // At rest within a sample.
            0 => lag(&mut case, T * random.log_between(0.005, 0.2)),
            1 => lag(&mut case, T * random.log_between(0.2, 20.0)),
            2 => {
                case.integrators = 1;
                case.modes.push(Mode {
                    rate: 0.0,
                    residue: gain,
                });
                if random.chance(0.5) {
                    // k/(s(τs + 1))
                    let rate = -1.0 / (T * random.log_between(1.0, 20.0));
                    case.modes.push(Mode {
                        rate,
                        residue: -gain,
                    });
                }
            }
            // Behind a dead time that is known, and one that is not.
            3 => {
                case.delay = random.between(0.0, 5.0);
                lag(&mut case, T * random.log_between(0.05, 20.0));
            }
            4 => {
                case.delay = f64::from((random.share() * 4.0) as u32);
                case.is_told = false;
                lag(&mut case, T * random.log_between(0.05, 20.0));
            }
            // As slow as the record is long, and slower.
            5 => {
                let length = T * case.samples as f64;
                lag(&mut case, length * random.log_between(0.1, 30.0));
            }
            _ => {
                case.direct = gain * random.between(-1.0, 1.0);
                if random.chance(0.5) {
                    lag(&mut case, T * random.log_between(0.2, 20.0));
                }
            }
        }
        case
    }

    fn record(&self, random: &mut Random) -> InputOutput {
        let input = self.input.signal(self.samples, random);
        let (whole, part) = (self.delay.floor() as usize, self.delay.fract());
        let at = |n: usize, lag: usize| n.checked_sub(lag).map_or(0.0, |n| input[n]);
        let mut states = vec![0.0; self.modes.len()];
        let mut output = Vec::new();
        for (n, now) in input.iter().enumerate() {
            output.push(states.iter().sum::<f64>() + self.direct * now);
            for (x, mode) in states.iter_mut().zip(&self.modes) {
                let (early, late) = (part * T, (1.0 - part) * T);
                let before = (mode.rate * late).exp() * grown(mode.rate, early) * at(n, whole + 1);
                let fed = before + grown(mode.rate, late) * at(n, whole);
                *x = (mode.rate * T).exp() * *x + mode.residue * fed;
            }
        }
        let largest = output.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        for y in &mut output {
            *y += self.noise * largest * (1..=12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
            if let Some(digits) = self.digits {
                let unit = 10f64.powi(largest.log10().floor() as i32 - digits);
                let places = 0.max(-unit.log10().round() as i32) as usize;
                let written = format!("{:.places$}", (*y / unit).round() * unit);
                *y = written.parse().expect("a number");
            }
        }
        InputOutput {
            time_s: (0..self.samples).map(|n| T * n as f64).collect(),
            input,
            output,
            late_s: 0.0,
        }
    }
}

/// The wrong function, in words. Right is also to say of a pole slower than the record that it may be at rest, and to refuse what no function of
/// more poles than zeros explains, or to leave much of it and say so.
fn wrong(number: u64, case: &Case, record: &InputOutput) -> Option<String> {
    let delay = if case.is_told { case.delay * T } else { 0.0 };
    let record = shifted(record, delay).expect("shorter than the record");
    let length_s = T * record.output.len() as f64;
    let is_slow = |mode: &Mode| mode.rate < 0.0 && mode.rate * length_s > -1.0;
    let is_slow = case.modes.iter().any(is_slow);
    let found = identify(&record, &candidates(&record, true), true);
    let order = |function: &FractionalTransferFunction| {
        function.denominator().lowest() - function.numerator().lowest()
    };
    let is_right = match &found {
        Ok(found) => {
            let own = &found[0].identified;
            let is_right = (order(&own.function) - case.integrators as f64).abs() == 0.0;
            let is_said = is_slow && settles_as_well(found, &record).is_some();
            is_right || is_said || case.direct != 0.0 && own.fit < 0.95
        }
        Err(_) => case.direct != 0.0,
    };
    (!is_right).then(|| {
        let rates: Vec<f64> = case.modes.iter().map(|mode| mode.rate * T).collect();
        let found = found.map(|found| found[0].identified.function.to_string());
        format!(
            "{number}: {:?}, {} samples, delay {}, direct {}, noise {:.1e}, {:?} digits, rates {rates:?}: {found:?}",
            case.input, case.samples, case.delay, case.direct, case.noise, case.digits,
        )
    })
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_record_gains_or_loses_an_integrator() {
    let count: u64 = testkit::cases(25);
    let wrong = (0..count).into_par_iter().filter_map(|number| {
        let mut random = Random(number);
        let case = Case::drawn(number, &mut random);
        let record = case.record(&mut random);
        let wrong = wrong(number, &case, &record);
        wrong.inspect(|wrong| println!("{wrong}"))
    });
    let wrong = wrong.count();
    assert_eq!(wrong, 0, "of {count}");
}
