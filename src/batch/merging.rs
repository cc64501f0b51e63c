//! Images of the parts that tasks have rendered, which are removed when the images are there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::known::Known;
use super::leftovers::Leftovers;
use super::order::{Checksums, Order};
use super::share::{piece_of, pieces_of};
use crate::film::Developed;
use crate::math::text::listed;
use crate::render::{PartError, SettingsError, merge_as_asked_for};

/// What images are made of.
pub struct Merging<'a> {
    /// What tasks have done.
    pub known: &'a Known,
    /// Parts of each image; one if tasks have rendered images.
    pub parts: u32,
    /// Parts that are there, of whatever division.
    pub there: &'a Leftovers,
}

/// An image whose parts have become one.
pub struct Merged {
    /// The image.
    pub image: Developed<'static>,
    /// What its scene was read from, with checksums.
    pub inputs: BTreeMap<String, String>,
    /// How long its parts took, one after the other.
    pub seconds: f64,
}

/// Why parts do not become an image.
#[derive(Debug, thiserror::Error)]
pub enum MergingError {
    /// Some could not be rendered.
    #[error("{0}")]
    Failed(String),
    /// Some are not there, or not those of the job.
    #[error("{0}; run the tasks again, which do what is left")]
    Missing(String),
    /// The settings allow of no parts.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// They cannot be read.
    #[error(transparent)]
    Part(#[from] PartError),
}

impl Merging<'_> {
    /// The file of the first piece of a job, which tells how large they are.
    ///
    /// # Errors
    /// When the settings of the job allow of no parts.
    pub fn file_of_first(&self, order: &Order) -> Result<PathBuf, MergingError> {
        Ok(piece_of(order, 0, self.parts)?.output)
    }

    /// The image of a job that has not been done.
    ///
    /// # Errors
    /// When one of its parts has not been rendered, with the number of that and the reason.
    pub fn image(
        &self,
        order: &Order,
        folder: &Path,
        checksums: &Checksums,
    ) -> Result<Merged, MergingError> {
        let pieces = pieces_of(order, self.parts)?;
        let (mut inputs, mut seconds) = (BTreeMap::new(), 0.0);
        let mut left = Vec::new();
        for piece in &pieces {
            match self.known.done(piece, folder, checksums).filter(|_| self.parts > 1) {
                Some(record) => {
                    inputs.extend(record.inputs.clone());
                    seconds += record.seconds;
                }
                None => left.push(piece),
            }
        }
        if !left.is_empty() {
            return Err(self.why_not(order, &left));
        }
        let paths: Vec<PathBuf> = pieces.into_iter().map(|piece| piece.output).collect();
        let (mut image, with_variance) = merge_as_asked_for(&paths)?;
        if !with_variance {
            image.drop_variance();
        }
        image.metadata.insert(0, ("parts".to_owned(), paths.len().to_string()));
        Ok(Merged { image, inputs, seconds })
    }

    /// Why there is no image of a job, by the pieces that are left.
    fn why_not(&self, order: &Order, left: &[&Order]) -> MergingError {
        let mut failed: Vec<(&str, Vec<String>)> = Vec::new();
        let mut missing = Vec::new();
        for piece in left {
            match self.known.error(piece).filter(|_| !self.known.was_done(piece)) {
                None => missing.push(self.why_missing(piece)),
                Some(error) => match failed.iter_mut().find(|(other, _)| *other == error) {
                    Some((_, names)) => names.push(name_of(piece)),
                    None => failed.push((error, vec![name_of(piece)])),
                },
            }
        }
        if let ([(error, names)], true) = (&failed[..], missing.is_empty())
            && names.len() == self.parts as usize
        {
            return MergingError::Failed((*error).to_owned());
        }
        let told =
            |(error, names): (&str, Vec<String>)| format!("{} failed: {error}", listed(names));
        let reasons = missing.into_iter().chain(failed.into_iter().map(told));
        let other = self.there.of_other_number(&order.output, self.parts);
        let advice = other.map_or(String::new(), |other| {
            format!(" (there is {}: is --parts what the tasks had?)", other.display())
        });
        MergingError::Missing(listed(reasons) + &advice)
    }

    fn why_missing(&self, piece: &Order) -> String {
        let (name, file) = (name_of(piece), &piece.output_name);
        if !piece.output.exists() {
            return format!("{name} is missing: there is no {file}");
        }
        match (self.known.tells_of(file), self.known.was_done(piece)) {
            (false, _) => {
                format!("{name}, {file}, is there, but no task has noted that it made it")
            }
            (true, true) => format!("{name}, {file}, is damaged, or its scene has changed"),
            (true, false) => {
                format!("{name}, {file}, is of other options or another build of the program")
            }
        }
    }
}

/// How a piece is called.
fn name_of(piece: &Order) -> String {
    piece.settings.part.map_or("the image".to_owned(), |part| format!("part {part}"))
}
