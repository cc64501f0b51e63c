//! A page of a batch: one HTML file with everything in it, opened from the disk.
//!
//! Records -> their images, read and forgotten one by one (`entry`), of which figures and a small
//! copy stay (`figures`, `thumbnail`) -> `report.html` with its style and scripts, and those that
//! all pages have ([`crate::image::page`]). The page computes degrees, angles and maps itself.

mod entry;
mod figures;
mod link;
mod thumbnail;

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use serde::Serialize;

use super::gate::Gate;
use super::results::Record;
use crate::image::page::{self, Colors};
use crate::image::{OutputError, atomic, folder_of};
use entry::{Entry, Place};

/// Longest sides that small copies may have.
pub const EDGES: std::ops::RangeInclusive<usize> = 8..=512;
/// Pixels of all small copies together, from which their size follows: 64 x 64 of a thousand.
const PIXELS: usize = 1 << 22;
/// The longest sides that follow from it; the shorter one is for as long as three times as many
/// pixels suffice.
const SHORT: usize = 24;
const LONG: usize = 160;
/// Most jobs: a browser reads what is known of them as one text.
const JOBS_MAX: usize = 100_000;
/// Bytes of files that are read at once; a larger one is read alone.
const BYTES_AT_ONCE: u64 = 32 << 20;

const PAGE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");
/// The scripts behind those of all pages, in the order in which they stand there.
const SCRIPTS: [&str; 6] = [
    include_str!("figures.js"),
    include_str!("maps.js"),
    include_str!("filters.js"),
    include_str!("plot.js"),
    include_str!("cards.js"),
    include_str!("report.js"),
];

/// What a page is made of.
#[derive(Clone, Debug)]
pub struct Report<'a> {
    /// What it is called.
    pub name: String,
    /// What has become of the jobs.
    pub records: &'a [Record],
    /// Lines of the file that are no records.
    pub broken: usize,
    /// What the paths of images are relative to.
    pub folder: PathBuf,
    /// Whether images outside of it are read.
    pub allow_outside: bool,
    /// The longest side of small copies, in [`EDGES`]; what fits their number if there is none.
    pub edge: Option<usize>,
}

/// What has been written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Bytes of the page.
    pub bytes: u64,
    /// Jobs that have failed.
    pub failed: usize,
    /// Those of them under whose names there are images of former runs.
    pub former: usize,
    /// Images that cannot be shown: gone, damaged, in a format that cannot be read.
    pub missing: usize,
    /// Images that are shown and not those that were rendered.
    pub changed: usize,
}

/// All that the page knows beside pixels.
#[derive(Serialize)]
struct Data<'a> {
    name: &'a str,
    version: &'static str,
    broken: usize,
    jobs: &'a [Entry],
    #[serde(flatten)]
    colors: Colors,
}

impl Report<'_> {
    /// Reads the images and writes the page. `tell` hears how many have been read, on the thread
    /// of the caller.
    ///
    /// # Errors
    /// When the page cannot be written, or there are more jobs than a browser holds. What is wrong
    /// with an image stands in the page.
    pub fn write(&self, path: &Path, tell: impl FnMut(usize)) -> Result<Written, OutputError> {
        let count = self.records.len();
        if count > JOBS_MAX {
            let reason = format!(
                "a browser would have to hold {count} jobs, and {JOBS_MAX} are the most; make a \
                 page each of some of the lines of results"
            );
            return Err(OutputError::unwritable(path, reason));
        }
        // Before what may take long.
        atomic::probe_writable(path)?;
        let entries = self.entries(&folder_of(path), tell);
        let count = |is: &dyn Fn(&Entry) -> bool| entries.iter().filter(|entry| is(entry)).count();
        let mut written = Written {
            bytes: 0,
            failed: count(&|entry| entry.error.is_some()),
            former: count(&|entry| entry.former),
            missing: count(&|entry| entry.problem.is_some()),
            changed: count(&|entry| entry.changed && entry.problem.is_none()),
        };
        atomic::write_with(path, |file| {
            self.push_page(file, &entries)?;
            written.bytes = file.stream_position()?;
            Ok(())
        })?;
        Ok(written)
    }

    /// What the page has of every job. Small images are read side by side, large ones one by one.
    fn entries(&self, page_folder: &Path, mut tell: impl FnMut(usize)) -> Vec<Entry> {
        let edge = self.edge.unwrap_or_else(|| fitting_edge(self.records.len()));
        let place = Place::new(&self.folder, page_folder, self.allow_outside, edge);
        let gate = Gate::new(BYTES_AT_ONCE);
        let next = AtomicUsize::new(0);
        let count = thread::available_parallelism().map_or(1, usize::from);
        let mut entries: Vec<Option<Entry>> = self.records.iter().map(|_| None).collect();
        let (sender, receiver) = mpsc::channel();
        let read_all = |sender: mpsc::Sender<(usize, Entry)>| {
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(record) = self.records.get(at) else { return };
                let entry = {
                    let _permit = gate.enter(place.bytes_of(record));
                    Entry::new(record, &place)
                };
                if sender.send((at, entry)).is_err() {
                    return;
                }
            }
        };
        thread::scope(|scope| {
            let read_all = &read_all;
            for _ in 0..count.min(self.records.len()) {
                let sender = sender.clone();
                // With fewer threads than asked for it takes longer.
                drop(thread::Builder::new().spawn_scoped(scope, move || read_all(sender)));
            }
            drop(sender);
            for (done, (at, entry)) in (1..).zip(receiver) {
                entries[at] = Some(entry);
                tell(done);
            }
        });
        // Where no thread could be started.
        let missing = entries.into_iter().zip(self.records);
        missing.map(|(entry, record)| entry.unwrap_or_else(|| Entry::new(record, &place))).collect()
    }

    fn push_page(&self, out: &mut impl Write, entries: &[Entry]) -> io::Result<()> {
        page::push_filled(out, PAGE, |out, place| match place {
            "title" => out.write_all(page::escaped_text(&self.name).as_bytes()),
            "style" => write!(out, "{}\n{STYLE}", page::STYLE),
            "data" => out.write_all(self.json(entries).as_bytes()),
            "pixels" => push_pixels(out, entries),
            "scripts" => {
                let mut scripts = page::SCRIPTS.iter().chain(&SCRIPTS);
                scripts.try_for_each(|text| writeln!(out, "{text}"))
            }
            _ => {
                debug_assert!(false, "report.html has no place for {place}");
                Ok(())
            }
        })
    }

    fn json(&self, entries: &[Entry]) -> String {
        let scales = entries.iter().filter_map(Entry::scales);
        // All images share their scales.
        let scales = scales.reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)));
        page::json_text(&Data {
            name: &self.name,
            version: env!("CARGO_PKG_VERSION"),
            broken: self.broken,
            jobs: entries,
            colors: Colors::new(scales),
        })
    }
}

/// The longest side of the small copies of so many images.
fn fitting_edge(images: usize) -> usize {
    let images = images.max(1);
    let edge = (PIXELS / images).isqrt() / 8 * 8;
    let short = (3 * PIXELS / images).isqrt().min(SHORT);
    edge.clamp(short.max(*EDGES.start()), LONG)
}

/// An element for every small copy.
fn push_pixels<W: Write>(out: &mut W, entries: &[Entry]) -> io::Result<()> {
    for (at, entry) in entries.iter().enumerate() {
        if let Some(pixels) = entry.pixels() {
            let id = format!("pixels-{at}");
            page::push_element(out, &id, |out| page::push_bytes(out, pixels))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_of_the_page_is_filled_once() {
        for place in ["title", "style", "data", "pixels", "scripts"] {
            assert_eq!(PAGE.matches(&format!("{{{{{place}}}}}")).count(), 1, "{place}");
        }
        assert_eq!(PAGE.matches("{{").count(), 5);
    }

    #[test]
    fn many_images_have_small_copies() {
        let edges = [0, 1, 100, 1000, 10_000, 20_000, JOBS_MAX, 1 << 40].map(fitting_edge);
        assert_eq!(edges, [160, 160, 160, 64, 24, 24, 11, 8]);
    }
}
