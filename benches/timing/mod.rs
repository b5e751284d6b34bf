//! How the benches time: the runs of a group are taken in turn, so that a busy machine is so to all of them, and the least counts.

use std::time::Instant;

/// Name, and a run that returns how many times it did what is timed.
pub(crate) type Timed<'a> = (String, Box<dyn FnMut() -> usize + 'a>);

pub(crate) fn timed<'a>(name: &str, run: impl FnMut() -> usize + 'a) -> Timed<'a> {
    (name.to_owned(), Box::new(run))
}

/// Prints ns of each, and over that of the first. An argument of the command chooses the groups that have it in their name.
pub(crate) fn compare(group: &str, rounds: usize, mut runs: Vec<Timed<'_>>) {
    let mut chosen = std::env::args()
        .skip(1)
        .filter(|name| !name.starts_with('-'));
    if chosen.any(|name| !group.contains(&name)) {
        return;
    }
    let mut least = vec![f64::INFINITY; runs.len()];
    for _ in 0..rounds {
        for (least, (_, run)) in least.iter_mut().zip(&mut runs) {
            let before = Instant::now();
            let count = run();
            *least = least.min(1e9 * before.elapsed().as_secs_f64() / count as f64);
        }
    }
    for ((name, _), ns) in runs.iter().zip(&least) {
        println!("{group}, {name}: {ns:.0} ns = {:.2} times", ns / least[0]);
    }
}
