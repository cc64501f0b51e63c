//! What paths know of the media they are in.

use super::{Channels, channels, gather, identifiers};

/// Columns that only scenes with media or boundaries of media have rows for.
pub struct MediaColumns<const N: usize> {
    /// The medium around the current segment's start: a row of the scene's media, or `NONE`.
    pub inside: Vec<u32>,
    /// Share of each wavelength in the density of the path. Distances and directions in media are
    /// drawn for one wavelength, chosen for the whole path; its weight counts that any of them
    /// could have been chosen (spectral multiple importance sampling: Wilkie et al. 2014, "Hero
    /// wavelength spectral sampling"). Without meaning for a single wavelength.
    pub share: Channels<N>,
}

impl<const N: usize> MediaColumns<N> {
    /// Columns for `capacity` rows; empty ones if nothing is `present`.
    pub fn new(capacity: usize, present: bool) -> Self {
        if present {
            return Self { inside: identifiers(capacity), share: channels(capacity) };
        }
        Self { inside: Vec::new(), share: std::array::from_fn(|_| Vec::new()) }
    }

    /// Whether there are columns at all.
    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.inside.is_empty()
    }

    /// The medium of a row, `NONE` without columns.
    #[inline(always)]
    pub fn inside(&self, row: usize) -> u32 {
        self.inside.get(row).copied().unwrap_or(crate::scene::baked::NONE)
    }

    /// Starts the rows `0..rows`; `inside` has been written.
    pub fn start(&mut self, rows: usize) {
        if self.present() {
            for share in &mut self.share {
                share[..rows].fill(1.0 / N as f32);
            }
        }
    }

    /// Takes the rows `order` of another table.
    pub fn gather(&mut self, from: &Self, order: &[u32]) {
        if !self.present() {
            return;
        }
        gather(&mut self.inside, &from.inside, order, 0);
        if N > 1 {
            for (to, from) in self.share.iter_mut().zip(&from.share) {
                gather(to, from, order, 0);
            }
        }
    }
}
