//! How far a measurement is, for whoever looks.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use crate::bench::measure::Watch;

/// Counts rounds.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of so many rounds, where somebody sees it.
    pub fn of(rounds: u64) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(rounds);
        let template = "{msg} {wide_bar} {pos}/{len} rounds, {eta} left";
        let style = ProgressStyle::with_template(template);
        bar.set_style(style.unwrap_or(ProgressStyle::default_bar()));
        Self(bar)
    }

    /// Takes the bar away.
    pub fn finish(self) {
        self.0.finish_and_clear();
    }
}

impl Watch for Progress {
    fn at(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    fn round(&self) {
        self.0.inc(1);
    }
}
