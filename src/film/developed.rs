//! The image of a film: its numbers are worked out where they are asked for, so that the film alone
//! is in memory until it is written.
//!
//! Behind an ideal analyzer a film measures one number, twice what passes, so that unpolarized
//! light counts in full and nothing that draws or weighs paths has to know. All of that light is in
//! the state that the analyzer passes: each component is the first times a number, and its error
//! that error times the same.

use std::borrow::Cow;
use std::ops::Deref;

use rayon::prelude::*;

use super::halves::{Shares, TILE};
use super::{Block, Film, Finished, Gauge};
use crate::image::StokesImage;
use crate::image::layers::Layer;
use crate::image::rows::{Frame, Rows};
use crate::polarization::{Analyzer, Stokes};

/// Pixels of which all numbers are at hand at once.
const PIXELS: usize = 64;

/// The image of a film.
pub struct Developed<'a> {
    film: Source<'a>,
    count: Count,
    /// What is left of the variances that the blocks tell, of each plane; nothing is known of it
    /// without.
    shares: Option<Vec<Shares>>,
    has_variance: bool,
    /// Factors of the components, where the film measures what an analyzer lets pass.
    gains: Option<Vec<f32>>,
    /// What is known of pixels besides their light.
    pub layers: Vec<Layer>,
    /// What is known of its making.
    pub metadata: Vec<(String, String)>,
}

/// The film itself or a look at it.
enum Source<'a> {
    Own(Box<Film>),
    Other(&'a Film),
}

impl Deref for Source<'_> {
    type Target = Film;

    fn deref(&self) -> &Film {
        match self {
            Self::Own(film) => film,
            Self::Other(film) => film,
        }
    }
}

/// The iterations that count.
#[derive(Clone, Copy)]
enum Count {
    /// Those of the finished blocks.
    Finished,
    /// So many of the current block, too.
    SoFar(u32),
}

impl Film {
    /// The image of the finished blocks; with variances where there are two or more of them.
    pub fn developed(&self) -> Developed<'_> {
        match &self.finished {
            Finished::Blocks(blocks) => self.of_blocks(blocks).into_developed(),
            Finished::Sums | Finished::Means { .. } => Developed::finished(Source::Other(self)),
        }
    }

    /// The same image, with the film in it.
    pub fn into_developed(self) -> Developed<'static> {
        let film = match &self.finished {
            Finished::Blocks(blocks) => self.of_blocks(blocks),
            Finished::Sums | Finished::Means { .. } => self,
        };
        Developed::finished(Source::Own(Box::new(film)))
    }

    /// The image so far, without variances: the finished blocks and the current one, of which
    /// `iterations` have been added.
    pub fn so_far(&self, iterations: u32) -> Developed<'_> {
        Developed {
            film: Source::Other(self),
            count: Count::SoFar(iterations),
            shares: None,
            has_variance: false,
            gains: None,
            layers: Vec::new(),
            metadata: Vec::new(),
        }
    }

    /// The channels for which no iteration has had a wavelength so far.
    pub fn unmeasured(&self) -> Vec<usize> {
        let so_far = self.so_far(1);
        (0..self.color.channels()).filter(|channel| so_far.gauge(*channel) == Some(0.0)).collect()
    }

    /// A film that has nothing but some blocks of this one.
    fn of_blocks(&self, blocks: &[Block]) -> Self {
        let size = [self.width as u32, self.height as u32];
        let kinds = (self.variances, self.gauge);
        let mut film = Self::new(size, self.color.clone(), self.components, kinds, false);
        blocks.iter().for_each(|block| film.take_block(&block.sums, block.iterations));
        film
    }
}

impl<'a> Developed<'a> {
    fn finished(film: Source<'a>) -> Self {
        let has_deviations = matches!(film.finished, Finished::Means { .. });
        let mut developed = Self {
            has_variance: has_deviations && film.blocks > 1,
            film,
            count: Count::Finished,
            shares: None,
            gains: None,
            layers: Vec::new(),
            metadata: Vec::new(),
        };
        developed.shares = developed.shares();
        developed
    }

    /// The same image of so many Stokes components, if the film is behind an analyzer.
    #[must_use]
    pub fn behind(mut self, analyzer: Option<Analyzer>, components: usize) -> Self {
        self.gains = analyzer.map(|analyzer| {
            let Stokes(state) = analyzer.state();
            state[..components].iter().map(|share| (0.5 * share) as f32).collect()
        });
        self
    }

    /// Forgets the variances.
    pub fn drop_variance(&mut self) {
        self.has_variance = false;
    }

    /// What the halves leave of the variances, if they say so.
    fn shares(&self) -> Option<Vec<Shares>> {
        let film = &*self.film;
        let Finished::Means { mean, halves: Some(halves), .. } = &film.finished else {
            return None;
        };
        let stride = film.values_per_pixel();
        let of_plane = |plane: usize| {
            let place = film.place(plane);
            let index_of = |pixel: usize| pixel * stride + place;
            let variance_of = |pixel: usize| self.variance_at(index_of(pixel));
            let size = [film.width, film.height];
            halves.shares(size, (mean, film.iterations), variance_of, index_of)
        };
        if !self.has_variance {
            return None;
        }
        (0..stride).into_par_iter().map(of_plane).collect()
    }

    /// The squared standard error of a value as the blocks tell it.
    fn variance_at(&self, index: usize) -> f32 {
        let Finished::Means { deviations, .. } = &self.film.finished else { return 0.0 };
        // Blocks are of nearly equal size: the squared standard error of the weighted mean.
        let degrees = f64::from(self.film.blocks.max(2) - 1) * self.film.iterations.max(1) as f64;
        (deviations[index] * (1.0 / degrees)) as f32
    }

    /// The values of the film at some indices, not divided by its gauge.
    fn values(&self, indices: impl Iterator<Item = usize>, to: &mut [f32]) {
        let film = &*self.film;
        let of_block = match self.count {
            Count::Finished => 0,
            Count::SoFar(iterations) => iterations,
        };
        let all = (film.iterations + u64::from(of_block)).max(1) as f64;
        let share = film.iterations as f64 / all;
        let sums = &film.sums;
        match (&film.finished, self.count) {
            (Finished::Sums, _) => put(to, indices, |index| sums.get(index) / all),
            (Finished::Means { mean, .. }, Count::Finished) => {
                put(to, indices, |index| mean[index])
            }
            (Finished::Means { mean, .. }, Count::SoFar(_)) => {
                put(to, indices, |index| mean[index] * share + sums.get(index) / all);
            }
            (Finished::Blocks(blocks), _) => put(to, indices, |index| {
                let of_blocks: f64 = blocks.iter().map(|block| block.sums[index]).sum();
                of_blocks / all + sums.get(index) / all
            }),
        }
    }

    /// The variances that a plane of the film has of a row, from the pixel `left` on.
    fn variances(&self, plane: usize, (left, y): (usize, usize), to: &mut [f32]) {
        let tiles = self.film.width.div_ceil(TILE);
        let shares = self.shares.as_ref().map(|shares| &shares[plane]);
        for ((x, to), index) in (left..).zip(to).zip(self.indices(plane, (left, y))) {
            let stated = self.variance_at(index);
            let tile = y / TILE * tiles + x / TILE;
            *to = stated * shares.map_or(1.0, |shares| shares.of(tile, stated));
        }
    }

    /// What a channel has measured of a spectrum of which it should measure one, if that is known.
    fn gauge(&self, channel: usize) -> Option<f32> {
        let film = &*self.film;
        match film.gauge {
            Gauge::None => None,
            Gauge::Kept => {
                let mut found = [0.0];
                let first = film.width * film.height * film.values_per_pixel();
                let index = first + film.place(channel);
                self.values(std::iter::once(index), &mut found);
                Some(found[0])
            }
        }
    }

    /// What a plane of the image is of the channel of the film that it comes from, if it is
    /// anything but that.
    fn gain(&self, plane: usize) -> Option<f32> {
        let channels = self.film.color.channels();
        let of_analyzer = self.gains.as_ref().map(|gains| gains[plane / channels]);
        let gauge = self.gauge(plane % channels);
        // What has never been measured is black, which whoever renders is told.
        let of_gauge = gauge.map(|gauge| if gauge > 0.0 { gauge.recip() } else { 0.0 });
        match (of_analyzer, of_gauge) {
            (Some(one), Some(other)) => Some(one * other),
            (one, other) => one.or(other),
        }
    }

    /// Where the numbers of a row are in the tables of the film, from the pixel `left` on.
    fn indices(
        &self,
        plane: usize,
        (left, y): (usize, usize),
    ) -> impl Iterator<Item = usize> + use<> {
        let (width, stride) = (self.film.width, self.film.values_per_pixel());
        let place = self.film.place(plane);
        (left..width).map(move |x| (y * width + x) * stride + place)
    }

    /// The numbers that one plane of the image has of a row, from the pixel `left` on: values, or
    /// variances.
    fn plane_of_row(
        &self,
        plane: usize,
        (left, y): (usize, usize),
        of_variance: bool,
        to: &mut [f32],
    ) {
        let channels = self.film.color.channels();
        let of_film = if self.gains.is_some() { plane % channels } else { plane };
        let gain = self.gain(plane);
        let gain = match of_variance {
            true => {
                self.variances(of_film, (left, y), to);
                gain.map(|gain| gain * gain)
            }
            false => {
                self.values(self.indices(of_film, (left, y)), to);
                gain
            }
        };
        if let Some(gain) = gain {
            to.iter_mut().for_each(|value| *value *= gain);
        }
    }

    /// The numbers of a row, plane by plane: values, or variances.
    fn planes_of_row(&self, y: usize, of_variance: bool, to: &mut [&mut [f32]]) {
        let width = self.film.width;
        // A few pixels in all planes, and then the next: all of a pixel is in one place.
        for left in (0..width).step_by(PIXELS) {
            let span = left..width.min(left + PIXELS);
            for (plane, to) in to.iter_mut().enumerate() {
                self.plane_of_row(plane, (left, y), of_variance, &mut to[span.clone()]);
            }
        }
    }

    /// All planes: of values, or of variances.
    fn planes(&self, of_variance: bool) -> Vec<Vec<f32>> {
        let Frame { width, height, .. } = self.frame();
        let count = self.frame().planes();
        let mut planes: Vec<Vec<f32>> = (0..count).map(|_| vec![0.0; width * height]).collect();
        let mut rows: Vec<Vec<&mut [f32]>> =
            (0..height).map(|_| Vec::with_capacity(count)).collect();
        for plane in &mut planes {
            for (row, numbers) in rows.iter_mut().zip(plane.chunks_exact_mut(width)) {
                row.push(numbers);
            }
        }
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            self.planes_of_row(y, of_variance, row);
        });
        planes
    }
}

/// Rounds the values at some indices.
fn put(to: &mut [f32], indices: impl Iterator<Item = usize>, value_at: impl Fn(usize) -> f64) {
    to.iter_mut().zip(indices).for_each(|(to, index)| *to = value_at(index) as f32);
}

impl Rows for Developed<'_> {
    fn frame(&self) -> Frame {
        let &Film { width, height, ref color, .. } = &*self.film;
        let color = color.clone();
        let components = self.gains.as_ref().map_or(self.film.components, Vec::len);
        let layers = self.layers.iter().map(|layer| layer.kind).collect();
        Frame { width, height, color, components, has_variance: self.has_variance, layers }
    }

    fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    fn row(&self, y: usize, numbers: &mut [f32]) {
        let frame = self.frame();
        let mut planes: Vec<&mut [f32]> = numbers.chunks_exact_mut(frame.width).collect();
        let (light, layers) = planes.split_at_mut(frame.planes_of_light());
        let (values, variances) = light.split_at_mut(frame.planes());
        self.planes_of_row(y, false, values);
        self.planes_of_row(y, true, variances);
        let all = self.layers.iter().flat_map(|layer| &layer.planes);
        for (numbers, plane) in layers.iter_mut().zip(all) {
            numbers.copy_from_slice(&plane[y * frame.width..][..frame.width]);
        }
    }

    fn whole(&self) -> Cow<'_, StokesImage> {
        let Frame { width, height, color, components, has_variance, .. } = self.frame();
        Cow::Owned(StokesImage {
            width,
            height,
            color,
            components,
            planes: self.planes(false),
            variance: has_variance.then(|| self.planes(true)),
            layers: self.layers.clone(),
            metadata: self.metadata.clone(),
        })
    }

    fn fault(&self) -> Option<&'static str> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Variances;
    use crate::spectrum::Color;

    /// Half of what was measured, in the state that passes, with its variance.
    #[test]
    fn components_and_variances_follow_from_the_first() {
        let mono = Color::Mono { wavelength_nm: 550.0 };
        let mut film = Film::new([2, 1], mono, 1, (Variances::Replicates, Gauge::None), false);
        for values in [[3.0, 1.5], [5.0, 0.5]] {
            film.add(0, 0, &values[..1]);
            film.add(1, 0, &values[1..]);
            film.finish_block(1);
        }
        let left = film.developed().behind(Some(Analyzer::LeftCircular), 4);
        assert_eq!(left.whole().planes, [[2.0, 0.5], [0.0; 2], [0.0; 2], [-2.0, -0.5]]);
        let expected = [[0.25, 0.0625], [0.0; 2], [0.0; 2], [0.25, 0.0625]];
        assert_eq!(left.whole().variance.as_deref().expect("it was there"), expected);
        let linear = Some(Analyzer::Linear { axis_deg: 20.0 });
        let mut intensity = film.into_developed().behind(linear, 1);
        intensity.drop_variance();
        assert_eq!(intensity.whole().planes, [[2.0, 0.5]]);
        assert_eq!((intensity.whole().components, &intensity.whole().variance), (1, &None));
    }

    /// Row by row, or as a whole.
    #[test]
    fn rows_are_those_of_the_planes() {
        let (width, height) = (70, 21);
        for (variances, blocks) in
            [(Variances::None, 1), (Variances::Replicates, 3), (Variances::Blocks, 8)]
        {
            let size = [width as u32, height as u32];
            let mut film = Film::new(size, Color::Rgb, 4, (variances, Gauge::None), false);
            for block in 0..blocks {
                for pixel in 0..width * height {
                    for channel in 0..3 {
                        let value = |component: usize| {
                            let plane = component * 3 + channel;
                            (pixel * 31 + plane * 7 + block * 13) as f32 % 5.3
                        };
                        film.add(pixel, channel, &std::array::from_fn::<f32, 4, _>(value));
                    }
                }
                film.finish_block(1);
            }
            for image in [film.developed(), film.so_far(0)] {
                let whole = image.whole().into_owned();
                assert_eq!(image.frame(), whole.frame());
                let [mut row, mut expected] =
                    [0; 2].map(|_| vec![0.0; whole.frame().numbers_of_row()]);
                for y in 0..height {
                    image.row(y, &mut row);
                    whole.row(y, &mut expected);
                    assert_eq!(row, expected, "{variances:?}, row {y}");
                }
            }
        }
    }
}
