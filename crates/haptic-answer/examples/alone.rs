//! The page's server without a machine, through a script: messages, and the times at which it goes on. What it says, line by line.
//!
//! ```text
//! cargo run -p haptic-answer --example alone
//! ```
//! `tests/pure` holds it against the same program in Node, `page/tests` against the page in a browser.

use haptic_answer::alone::{Alone, ToPage};

fn main() {
    let mut server = Alone::new("2026-12-01".to_owned()).expect("built in");
    for line in include_str!("alone.txt").lines() {
        match line.strip_prefix("at ") {
            Some(ms) => server.advance(ms.parse().expect("ms")),
            None => server.hear(line),
        }
        while server.work() {}
        while let Some(message) = server.next_message() {
            match message {
                ToPage::Text(text) => println!("{text}"),
                ToPage::Frame(bytes) => {
                    let digits = bytes.iter().map(|byte| format!("{byte:02x}"));
                    println!("{}", digits.collect::<String>());
                }
            }
        }
    }
}
