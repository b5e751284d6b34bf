//! Walls in any order, most of them asked for while another still fades, in a hand that roves; all is held to the log of its session.

use super::*;
use haptic_judge::{
    preflight::WallContact,
    setup::TrialSetup,
    trial::{TrialPlan, VirtualWall},
    wall::WallTrial,
};
use testkit::Tested;

/// The law that a session makes of an order, K, N/m, and B, N·s^μ/m.
fn made((order, k, b, contact): (f64, f64, f64, WallContact)) -> Pushing<VirtualWall> {
    let ideal = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), T);
    let setup = TrialSetup::new(ideal, crate::Sensors::NONE, TrialPlan::DEFAULT);
    let (order, scheme) = (Order::new(order).expect("valid"), "full".parse());
    let trial = WallTrial {
        contact,
        ..WallTrial::linear(setup, order, scheme.expect("a scheme"), k, b)
    };
    let judged = trial.judged_law(HORIZON, trial.setup.dynamics(), 0);
    judged.expect("judged").0
}

/// Ticks of a fade.
const FADE: f64 = 200.0;

/// What a log says of a tick.
enum Said {
    /// From it on this law is felt behind a surface, m, or none.
    Law(Option<(usize, f64)>),
    /// What was felt until before it.
    Certificate(String),
}

/// What the events of a log say, with their ticks.
fn said(events: &[(f64, String, String)]) -> Vec<(usize, Said)> {
    let of = |(time_s, kind, text): &(f64, String, String)| {
        let number = |before: &str, after: char| -> f64 {
            let rest = text.split_once(before).expect("its words").1;
            let number = rest.split(after).next().expect("a number");
            number.parse().expect("a number")
        };
        let said = match kind.as_str() {
            "feel" => {
                let law = (number("wall ", ':') as usize, number("surface ", ' '));
                Said::Law(Some(law))
            }
            "certificate" => Said::Certificate(text.clone()),
            _ => Said::Law(None),
        };
        // An event of a law is written behind the last tick before it.
        let later = usize::from(matches!(said, Said::Law(_)));
        ((time_s / T.0).round() as usize + later, said)
    };
    events.iter().map(of).collect()
}

/// Counts of a certificate.
#[derive(Default)]
struct Counts {
    ticks: u64,
    exact: u64,
    fade: u64,
    energy: u64,
}

impl Counts {
    fn words(&self) -> String {
        let share = self.exact as f64 / self.ticks as f64;
        let exact = match self.ticks {
            0 => "no force".to_owned(),
            _ => format!("exact {:.2} %", (1e4 * share).floor() / 100.0),
        };
        let Self { fade, energy, .. } = self;
        format!("{exact}; ticks reduced by fade {fade}, by energy {energy} (")
    }
}

/// Loop of a log, beside which all of its laws hear what it read.
struct Replay<'a> {
    ticks: &'a [TickMessage],
    laws: &'a [Pushing<VirtualWall>],
    /// The tick from which on laws remember.
    begun: usize,
    old: Option<Alone>,
    new: Option<Alone>,
    share: f64,
    counts: Counts,
}

impl Replay<'_> {
    fn place_m(&self, tick: usize) -> f64 {
        self.ticks[tick].position_m[0]
    }

    /// True of a change in the hand.
    fn becomes(&mut self, from: usize, law: Option<(usize, f64)>) -> bool {
        let changes = self.new.is_some();
        if !changes {
            self.begun = from;
        }
        let begun = self.begun;
        let next = law.map(|(wall, surface_m)| {
            let law = Placed::new(self.laws[wall].clone(), surface_m);
            let mut alone = Alone::begun(&law, self.place_m(begun - 1));
            (begun..from).for_each(|tick| alone.0.hear(self.place_m(tick)));
            alone
        });
        self.old = std::mem::replace(&mut self.new, next);
        // A wall that comes without one before it fades in where the hand is behind its surface already.
        let fades_in = self.new.as_ref().is_some_and(|law| {
            let x = nalgebra::Vector1::new(self.place_m(from - 1));
            law.0.environment.force(&law.0.history, &x)[0] != 0.0
        });
        self.share = if changes || fades_in { 0.0 } else { 1.0 };
        self.counts = Counts::default();
        changes
    }

    /// Forces of the old law, of the new one, and of both, N.
    fn wanted(&mut self, tick: usize) -> [f64; 3] {
        let x = self.place_m(tick);
        let [old_n, new_n] =
            [&mut self.old, &mut self.new].map(|law| law.as_mut().map_or(0.0, |law| law.force(x)));
        let mixed_n = if self.share >= 1.0 {
            new_n
        } else {
            old_n * (1.0 - self.share) + new_n * self.share
        };
        [old_n, new_n, mixed_n]
    }

    fn count(&mut self, [_, new_n, mixed_n]: [f64; 3], sent_n: f64) {
        let counts = &mut self.counts;
        if new_n == 0.0 && sent_n == 0.0 {
            return;
        }
        let differ = |a: f64, b: f64| u64::from((a - b).abs() > 1e-8);
        counts.ticks += 1;
        counts.exact += 1 - differ(sent_n, new_n);
        counts.fade += differ(mixed_n, new_n);
        counts.energy += differ(sent_n, mixed_n);
    }
}

/// Number of changes in the hand of a log, each tick of which is looked at.
fn looked_at(log: &Path, laws: &[Pushing<VirtualWall>], case: u32) -> u32 {
    let (ticks, events) = entries(log);
    let events = said(&events);
    let mut replay = Replay {
        ticks: &ticks,
        laws,
        begun: 0,
        old: None,
        new: None,
        share: 1.0,
        counts: Counts::default(),
    };
    let mut waiting = events.iter().peekable();
    let (mut changes, mut changed) = (0, false);
    let (mut taken_j, mut exit_m, mut begins_n) = (0.0_f64, f64::INFINITY, 0.0_f64);
    let (mut before_n, mut before_m, mut before) = (0.0_f64, 0.0_f64, [0.0_f64; 2]);
    let (mut apart_n, mut lent) = (0.0_f64, 1.0_f64);
    for (n, tick) in ticks.iter().enumerate() {
        let (at_m, sent_n) = (tick.position_m[0], tick.commanded_force_n[0]);
        let at = format!("case {case}, tick {n}");
        while let Some((_, said)) = waiting.next_if(|(tick, _)| *tick == n) {
            match said {
                Said::Certificate(words) => {
                    let found = replay.counts.words();
                    assert!(words.starts_with(&found), "{at}: {words}, not {found}");
                }
                Said::Law(law) => {
                    assert!(replay.share >= 1.0, "{at}: another still fades");
                    let surface_m = law.map_or(f64::INFINITY, |(_, surface_m)| surface_m);
                    if replay.becomes(n, *law) {
                        (changes, changed, begins_n) = (changes + 1, true, before_n.abs());
                        exit_m = exit_m.min(surface_m);
                        let held_j = begins_n * (before_m - exit_m).max(0.0);
                        lent = (held_j / (4.0 * taken_j.max(1e-12))).max(1.0);
                        // The law that was new is the old one; the newest was not heard before.
                        before = [before[1], f64::NAN];
                    } else {
                        (changed, exit_m) = (false, surface_m);
                    }
                }
            }
        }
        let [old_n, new_n, mixed_n] = replay.wanted(n);
        let is_reduced = (mixed_n - 1e-9..=1e-9).contains(&sent_n);
        assert!(is_reduced, "{at}: {sent_n} of {mixed_n} N");
        let moved = at_m - before_m;
        taken_j -= 0.5 * (before_n + sent_n) * moved;
        if sent_n == 0.0 && at_m <= exit_m {
            (taken_j, changed) = (0.0, false);
        }
        if changed {
            assert!(taken_j > -1e-9, "{at}: {taken_j:e} J");
            // The laws' own steps by that motion, and a 200th of s and of c, or of the force for which the touch had no energy. On the way
            // out c falls too. Two ticks of f·(d + L·|Δx|) = L·(A − ½·f_before·|Δx|) differ by (3/2·L − 1)·|Δx|/d of f at most, in which L
            // is 4 if the touch had the energy for the force when its law changed, and up to `lent` times that if it had not.
            let own = f64::max((old_n - before[0]).abs(), (new_n - before[1]).abs());
            let most_n = begins_n.max(before_n.abs()).max(mixed_n.abs());
            let steep = (6.0 * lent - 1.0) * before_n.abs() * moved.abs();
            let fade = (apart_n.max((old_n - new_n).abs()) + most_n) / FADE;
            let most = own + fade + steep / (before_m - exit_m).max(1e-8) + 1e-9;
            let step = (sent_n - before_n).abs();
            assert!(step < most, "{at}: {step} N, not {most}");
        }
        replay.count([old_n, new_n, mixed_n], sent_n);
        let is_over = mixed_n == 0.0 && new_n == 0.0;
        replay.share = if is_over {
            1.0
        } else {
            (replay.share + 1.0 / FADE).min(1.0)
        };
        (before_n, before_m, before) = (sent_n, at_m, [old_n, new_n]);
        apart_n = (old_n - new_n).abs();
    }
    assert!(waiting.next().is_none());
    changes
}

/// `CAMPAIGN_CASES` sets how many sequences, 10 by default.
#[test]
fn a_change_that_is_asked_for_while_another_fades_waits_and_nothing_jumps() -> Tested {
    let mut random = Random(861);
    let (mut changes, mut early) = (0, 0);
    for case in 0..testkit::cases(10_u32) {
        let folder = Folder::empty();
        let keys = [("force_limit_n", 20.0.into())];
        let stop = Arc::new(AtomicBool::new(false));
        let session = Session::open(options(folder.as_ref(), &keys), &stop, (), GOES_ON);
        let session = session?;
        let laws = [(); 5].map(|()| {
            let (order, k) = (random.share(), random.between(30.0, 500.0));
            let signed = random.chance(0.3);
            let contact = if signed {
                WallContact::Signed
            } else {
                WallContact::of(true)
            };
            (order, k, random.between(0.0, 8.0), contact)
        });
        let walls = laws.map(|(order, k, b, contact)| {
            let mut wall = law(order, k, b);
            if contact == WallContact::Signed {
                wall.set("wall", "contact", "signed", "").expect("once");
            }
            wall
        });
        session.allow(&walls)?;
        let mut way = vec![(0.0, -5e-3)];
        for n in 1..33 {
            let out = random.chance(0.2);
            let place_m = random.between(if out { -5e-3 } else { 1e-3 }, 8e-3);
            way.push((0.15 * f64::from(n), place_m));
        }
        way.push((5.0, -5e-3));
        session.hand(way)?;
        for _ in 0..16 {
            if random.chance(0.1) {
                session.pause(GOES_ON)?;
            } else if random.chance(0.1) {
                session.rest(0.1, GOES_ON)?;
            }
            let wall = (5.0 * random.share()) as usize;
            let surface_m = random.between(-5e-4, 5e-4);
            let came = session.feel(wall, surface_m, None, 9.0, GOES_ON);
            assert!(came?, "case {case}");
            // Most go on before the fade is over.
            let ticks = random.between(1.0, 300.0) as u64;
            early += u32::from(ticks < 200);
            session.go_on(ticks, GOES_ON, &|_| ())?;
        }
        assert!(session.rest(9.0, GOES_ON)?);
        session.close()?;
        changes += looked_at(session.log(), &laws.map(made), case);
    }
    assert!(changes > 50 && early > 50, "{changes} {early}");
    Ok(())
}
