//! What paths know of the media they are in.

use crate::math::columns::{Channels, Columns, columns};
use crate::math::elementary::exp;
use crate::math::{U32s, lanes};
use crate::scene::baked::NONE;

columns! {
    /// Columns that only scenes with media or boundaries of media have rows for.
    pub struct MediaColumns<const N: usize> {
        /// The medium around the current segment's start: a row of the scene's media, or `NONE`.
        pub inside: Vec<u32>,
        /// Share of each wavelength in the density of the path. Distances and directions in media
        /// are drawn for one wavelength, chosen for the whole path; its weight counts that any of
        /// them could have been chosen (spectral multiple importance sampling: Wilkie et al. 2014,
        /// "Hero wavelength spectral sampling"). Absent where they are one N-th for ever: for a
        /// single wavelength, and where all media are gray.
        pub share: Channels<N>,
    }
}

impl<const N: usize> MediaColumns<N> {
    /// Columns for `capacity` rows; none if nothing is `present`.
    pub fn if_any(capacity: usize, present: bool) -> Self {
        let all = if present { Self::new(capacity) } else { Self::absent() };
        Self { share: Columns::absent(), ..all }
    }

    /// Makes the columns of shares, unless there are, or lets them go.
    pub fn tell_wavelengths_apart(&mut self, are_told: bool) {
        if are_told != self.has_shares() {
            let rows = if are_told { self.inside.len() } else { 0 };
            self.share = std::array::from_fn(|_| vec![0.0; rows]);
        }
    }

    /// Whether there are columns of shares.
    #[inline(always)]
    pub fn has_shares(&self) -> bool {
        N > 1 && !self.share[0].is_empty()
    }

    /// Whether there are columns at all.
    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.inside.is_empty()
    }

    /// The medium of a row, `NONE` without columns.
    #[inline(always)]
    pub fn inside(&self, row: usize) -> u32 {
        self.inside.get(row).copied().unwrap_or(NONE)
    }

    /// [`Self::inside`] of the eight rows from `row` on.
    #[inline(always)]
    pub fn inside_of_lanes(&self, row: usize) -> U32s {
        match self.present() {
            true => lanes::load_u32(&self.inside, row),
            false => U32s::splat(NONE),
        }
    }

    /// What the throughput of a row is multiplied by where it has come through the optical depth
    /// `depth` without meeting a particle, `drawn` of it by chance: transmittance over density.
    pub fn reaching(&self, row: usize, depth: &[f32; N], drawn: &[f32; N]) -> [f32; N] {
        // Only ratios matter: the least depth is taken out, so that no sum underflows.
        let least = drawn.iter().copied().fold(f32::INFINITY, f32::min);
        let transmittance = depth.map(|depth| exp(least - depth));
        let densities = drawn.map(|drawn| exp(least - drawn));
        if !self.has_shares() {
            return transmittance.map(|of| of / densities[0]);
        }
        let shares = self.share.iter().map(|share| share[row]);
        let density: f32 = shares.zip(densities).map(|(share, of)| share * of).sum();
        transmittance.map(|of| of / density)
    }

    /// Starts the rows `0..rows`; `inside` has been written.
    pub fn start(&mut self, rows: usize) {
        for share in self.share.iter_mut().filter(|share| !share.is_empty()) {
            share[..rows].fill(1.0 / N as f32);
        }
    }
}
