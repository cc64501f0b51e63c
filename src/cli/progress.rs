//! How far the work is, for whoever looks: a bar on a terminal, and now and then a line where the
//! words go into a file.

use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use super::files::say;
use crate::bench::measure::Watch;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(60);

/// Counts steps of the work.
pub struct Progress {
    bar: ProgressBar,
    lines: Option<Lines>,
}

/// What is needed to say how far the work is.
struct Lines {
    unit: &'static str,
    total: u64,
    start: Instant,
    latest: Cell<Instant>,
    /// What is said in place of the steps, if they are nothing to be counted.
    told: RefCell<Option<String>>,
}

impl Progress {
    /// Nothing to be seen.
    pub fn none() -> Self {
        Self { bar: ProgressBar::hidden(), lines: None }
    }

    /// Of so many steps, which are called `unit`; `template` is what a terminal shows.
    pub fn of(total: u64, unit: &'static str, template: &str) -> Self {
        if !std::io::stderr().is_terminal() {
            let (start, latest) = (Instant::now(), Cell::new(Instant::now()));
            let bar = ProgressBar::hidden();
            bar.set_length(total);
            let told = RefCell::default();
            return Self { bar, lines: Some(Lines { unit, total, start, latest, told }) };
        }
        let bar = ProgressBar::new(total);
        let style = ProgressStyle::with_template(template);
        bar.set_style(style.unwrap_or(ProgressStyle::default_bar()));
        Self { bar, lines: None }
    }

    /// What is to be said of what is done in place of the steps; `{msg}` on a terminal.
    pub fn tell(&self, text: String) {
        if let Some(lines) = &self.lines {
            *lines.told.borrow_mut() = Some(text.clone());
        }
        self.bar.set_message(text);
    }

    /// So many steps are done.
    pub fn set(&self, done: u64) {
        self.bar.set_position(done);
        let Some(lines) = &self.lines else { return };
        if lines.latest.get().elapsed() >= INTERVAL {
            lines.latest.set(Instant::now());
            say(lines.text(done, lines.start.elapsed()));
        }
    }

    /// Says something else while the bar stands aside.
    pub fn aside(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Lines {
    fn text(&self, done: u64, since: Duration) -> String {
        let Self { unit, total, .. } = *self;
        let share = done as f64 / total.max(1) as f64;
        let left = since.as_secs_f64() * (1.0 / share - 1.0);
        let left = match Duration::try_from_secs_f64(left) {
            Ok(left) => format!(", about {} left", HumanDuration(left)),
            Err(_) => String::new(),
        };
        let percent = 100.0 * share;
        let told = self.told.borrow().clone();
        let told = told.unwrap_or_else(|| format!("{done} of {total} {unit}"));
        format!("{percent:.1} %: {told} in {}{left}", HumanDuration(since))
    }
}

impl Watch for Progress {
    fn at(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    fn round(&self) {
        self.set(self.bar.position() + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_what_is_left() {
        let (start, latest) = (Instant::now(), Cell::new(Instant::now()));
        let told = RefCell::default();
        let lines = Lines { unit: "iterations", total: 400, start, latest, told };
        let text = lines.text(100, Duration::from_secs(120));
        assert_eq!(text, "25.0 %: 100 of 400 iterations in 2 minutes, about 6 minutes left");
        assert_eq!(lines.text(0, INTERVAL), "0.0 %: 0 of 400 iterations in 60 seconds");
        *lines.told.borrow_mut() = Some("3 of 4 jobs".to_owned());
        assert_eq!(lines.text(0, INTERVAL), "0.0 %: 3 of 4 jobs in 60 seconds");
    }
}
