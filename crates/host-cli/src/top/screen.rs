//! The terminal: taken, drawn into some times a second, given back.

use super::draw::draw;
use super::follow::Run;
use haptic_experiment::failure::Failure;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time from one picture to the next.
const PICTURE: Duration = Duration::from_millis(100);

/// Shows a run, or the next that begins, until a key or a signal ends it.
///
/// # Errors
/// No terminal; a log that cannot be read any more.
pub fn show(mut run: Option<Run>, stop: &AtomicBool) -> Result<(), Failure> {
    if !std::io::stdout().is_terminal() {
        return Err(Failure::bad_input(
            "this view needs a terminal: run it in one, or give --json for the figures of the moment",
        ));
    }
    let taken = ratatui::try_init();
    let mut terminal = taken.map_err(|error| cannot("take", error))?;
    let shown = loop {
        if let Err(error) = look(&mut run) {
            break Err(error);
        }
        if let Err(error) = terminal.draw(|frame| draw(frame, run.as_ref())) {
            break Err(cannot("draw into", error));
        }
        match wait(stop) {
            Ok(true) => {}
            Ok(false) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    let given_back = ratatui::try_restore().map_err(|error| cannot("give back", error));
    shown.and(given_back)
}

/// Reads what has come; looks for a run while there is none.
fn look(run: &mut Option<Run>) -> Result<(), Failure> {
    match run {
        Some(run) => run.read().map(drop),
        None => {
            *run = Run::newest()?;
            Ok(())
        }
    }
}

fn cannot(what: &str, error: std::io::Error) -> Failure {
    Failure::writing(error, format_args!("cannot {what} the terminal"))
}

/// Waits for the next picture; false if a key or a signal ends the view.
fn wait(stop: &AtomicBool) -> Result<bool, Failure> {
    let until = Instant::now() + PICTURE;
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let left = until.saturating_duration_since(Instant::now());
        let heard = event::poll(left).and_then(|heard| heard.then(event::read).transpose());
        match heard.map_err(|error| cannot("read", error))? {
            Some(Event::Key(key)) if ends(key) => return Ok(false),
            Some(_) => {}
            None if left.is_zero() => return Ok(true),
            None => {}
        }
    }
}

/// True for q, Escape and Ctrl-C, which is a key and no signal here.
#[must_use]
pub fn ends(key: KeyEvent) -> bool {
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind != KeyEventKind::Release
        && match key.code {
            KeyCode::Char('q') | KeyCode::Esc => true,
            KeyCode::Char('c') => control,
            _ => false,
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn q_escape_and_control_c_end_the_view_and_nothing_else_does() {
        let key = |code, modifiers| ends(KeyEvent::new(code, modifiers));
        assert!(key(KeyCode::Char('q'), KeyModifiers::NONE));
        assert!(key(KeyCode::Esc, KeyModifiers::NONE));
        assert!(key(KeyCode::Char('c'), KeyModifiers::CONTROL));
        assert!(!key(KeyCode::Char('c'), KeyModifiers::NONE));
        assert!(!key(KeyCode::Enter, KeyModifiers::NONE));
    }
}
