//! Measurements of this program, as tables, JSON, plots and figures that are kept.
//!
//! | module | holds |
//! |---|---|
//! | [`measure`] | what is done to measure: renders on the clock |
//! | [`costs`] | scalar against polarized in rounds that alternate, stage by stage |
//! | [`table1`] | that, as the paper's Table 1 reports it |
//! | [`overhead`] | that, for any scenes and integrators |
//! | [`wavelengths`] | one, three, four and eight wavelengths, in both modes |
//! | [`scaling`] | time over threads, samples, photons, pixels and wavelengths |
//! | [`convergence`] | error over time |
//! | [`record`], [`figures`] | one line a measurement in a file that grows |
//! | [`history`] | the trends in such a file |
//! | [`plot`] | curves as SVG |

pub mod convergence;
pub mod costs;
pub mod figures;
pub mod history;
pub mod measure;
pub mod overhead;
pub mod plot;
pub mod record;
pub mod scaling;
pub mod table1;
pub mod wavelengths;

use std::fmt;

use serde::Serialize;

use self::figures::Figures;
use self::plot::Panel;
use crate::math::statistics::Interval;

/// A measurement that can be shown and kept. What is printed is its text or its JSON.
pub trait Report: fmt::Display + Serialize {
    /// What to draw.
    fn panels(&self) -> Vec<Panel>;
    /// What to keep, by name.
    fn figures(&self) -> Figures;
}

/// What was measured, and on what machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Version of the program.
    pub version: String,
    /// Model of the processor, where the system tells.
    pub processor: Option<String>,
    /// Processors that the program may use.
    pub processors: usize,
    /// Worker threads.
    pub threads: usize,
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, processor, processors, threads } = self;
        let processor = processor.as_deref().unwrap_or("unknown processor");
        write!(f, "sunstone {version}, {threads} threads, {processors} of {processor}")
    }
}

/// An interval with some digits after the point.
fn interval_in_words(interval: &Option<Interval>, digits: usize) -> String {
    interval.map_or("-".into(), |Interval { low, high, .. }| {
        let separator = if low < 0.0 { " to " } else { "-" };
        format!("{low:.digits$}{separator}{high:.digits$}")
    })
}

/// A count as the paper writes it.
fn thousands(count: f64) -> String {
    if count < 10_000.0 { format!("{count:.0}") } else { format!("{:.0}K", count / 1000.0) }
}

/// The greatest length of some words, and `least` at least: the width of their column.
fn column_width<'a>(words: impl Iterator<Item = &'a str>, least: usize) -> usize {
    words.map(|word| word.chars().count()).fold(least, usize::max)
}
