//! Checkpoints: what a render is taken up from after it was stopped, or ended without a word.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::image::atomic::probe_writable;
use crate::math::text::counted;
use crate::render::statistics::SAMPLES;
use crate::render::{PartError, Progress, Renderer};

use super::CliError;
use super::args::RenderArguments;
use super::files::{refuse_overwriting, say};
use super::job;

/// Time between two checkpoints where none is given.
const INTERVAL: Duration = Duration::from_secs(60);

/// The checkpoints of a render, if they are wanted.
pub(super) struct Checkpoints {
    path: Option<PathBuf>,
    interval: Duration,
    /// When the latest was written, by this process.
    latest: Option<Instant>,
    resume: bool,
    quiet: bool,
}

impl Checkpoints {
    /// Checks what was typed, and that the file can be written: it must not be there, unless the
    /// render is to go on from it.
    pub(super) fn new(arguments: &RenderArguments) -> Result<Self, CliError> {
        let typed = &arguments.checkpoints;
        let every = job::seconds("--checkpoint-every", typed.checkpoint_every)?;
        let (path, resume) = (typed.checkpoint.clone(), typed.resume);
        if let Some(path) = &path {
            refuse_overwriting(path, &[&arguments.scene, &arguments.output])?;
            if path.exists() && !resume {
                return Err(CliError::Usage(format!(
                    "the checkpoint {} is there: go on from it with --resume, or remove it",
                    path.display()
                )));
            }
            probe_writable(path)?;
        }
        let interval = every.unwrap_or(INTERVAL);
        Ok(Self { path, interval, latest: None, resume, quiet: arguments.quiet })
    }

    /// Goes on from the checkpoint, if there is one.
    pub(super) fn resume(&self, renderer: &mut Renderer) -> Result<(), CliError> {
        let Some(path) = self.path.as_ref().filter(|_| self.resume) else { return Ok(()) };
        let from = match path.exists() {
            true => {
                renderer.resume(path)?;
                format!("after {}", counted(renderer.samples() as usize, SAMPLES))
            }
            false => "from the beginning, as it is not there".to_owned(),
        };
        if !self.quiet {
            say(format_args!("note: --resume {}: goes on {from}", path.display()));
        }
        Ok(())
    }

    /// Writes one if it is time, and the first as soon as there is something to go on from. A
    /// render does not end for a failure to do so.
    pub(super) fn write(&mut self, so_far: &Progress) {
        if self.latest.is_none_or(|latest| latest.elapsed() >= self.interval) {
            self.keep(|path| so_far.save(path));
        }
    }

    /// Writes the last one of a render that a signal has ended; beside the output if no place was
    /// named and that is a part, which has no use before it is done.
    pub(super) fn write_last(&mut self, renderer: &mut Renderer, output: &Path) {
        if self.path.is_none() && renderer.settings().part.is_some() {
            let mut name = output.as_os_str().to_owned();
            name.push(".checkpoint");
            self.path = Some(name.into());
        }
        self.keep(|path| renderer.save(path));
    }

    fn keep(&mut self, save: impl FnOnce(&Path) -> Result<(), PartError>) {
        let Some(path) = &self.path else { return };
        if let Err(error) = save(path) {
            say(format_args!("warning: no checkpoint was written: {error}"));
        }
        self.latest = Some(Instant::now());
    }

    /// Removes it, as the output is written.
    pub(super) fn remove(&self) {
        let Some(path) = &self.path else { return };
        if let Err(error) = std::fs::remove_file(path)
            && error.kind() != std::io::ErrorKind::NotFound
        {
            say(format_args!("warning: {} is left: {error}", path.display()));
        }
    }

    /// Says how to go on, if there is something to go on from.
    pub(super) fn say(&self) {
        say_how_to_go_on(self.path.as_deref());
    }
}

/// Says how to go on from a checkpoint, if it is there.
pub(super) fn say_how_to_go_on(path: Option<&Path>) {
    if let Some(path) = path.filter(|path| path.exists()) {
        say(format_args!("note: --checkpoint {} --resume goes on", path.display()));
    }
}
