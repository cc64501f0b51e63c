//! How much better a whole sequence is than its blocks tell.
//!
//! Blocks of a low-discrepancy sequence are stratified among each other: the error of the whole
//! falls faster than with the root of their number, and their spread overestimates it, by thousands
//! where pixels are smooth. How fast it falls shows in how far the whole is from its first half:
//! the mean square of that difference is the variance of the half less that of the whole. One pixel
//! says little of it, and pixels of one tile do not agree: along the edge of a lamp the error falls
//! fast, and next to it, in light that has been scattered, it does not. So a share of what blocks
//! say is found for pixels of a tile whose blocks say about the same.

use super::record::{Column, Fact, Record};

use crate::image::OutputError;

/// Edge of a tile in pixels.
pub const TILE: usize = 8;

/// Kinds of pixels in a tile, by the octaves of what blocks say: below the greatest variance, and
/// all that is less by many octaves is of one kind.
const KINDS: usize = 16;

/// Pixels that what the whole tile tells counts for, beside those of a kind.
const WEIGHT_OF_TILE: f64 = 1.0;

/// Pixels that the blocks themselves count for, beside those of a tile, so that no single pixel
/// takes all of what they say from itself.
const WEIGHT_OF_BLOCKS: f64 = 0.25;

/// The means after some numbers of iterations, each twice the last or more.
pub struct Halves {
    /// The latest last.
    latest: [Half; 2],
}

/// The means after so many iterations; none yet for zero.
struct Half {
    iterations: u64,
    mean: Vec<f32>,
}

impl Halves {
    /// None yet, of so many values.
    pub fn new(values: usize) -> Self {
        let half = || Half { iterations: 0, mean: vec![0.0; values] };
        Self { latest: [half(), half()] }
    }

    /// Takes notice of the means so far.
    pub fn keep(&mut self, mean: &[f64], iterations: u64) {
        if iterations < 2 * self.latest[1].iterations {
            return;
        }
        self.latest.swap(0, 1);
        let latest = &mut self.latest[1];
        latest.iterations = iterations;
        for (to, &from) in latest.mean.iter_mut().zip(mean) {
            *to = from as f32;
        }
    }

    /// Facts and columns from which [`Halves::restore`] makes the same.
    pub fn state(&self) -> (Vec<Fact>, Vec<(String, Column<'_>)>) {
        let facts = self.latest.iter().enumerate();
        let facts = facts.map(|(index, half)| (name_of(index), half.iterations.to_string()));
        let columns = self.latest.iter().enumerate();
        let columns =
            columns.map(|(index, half)| (name_of(index), Column::Singles(half.mean.as_slice())));
        (facts.collect(), columns.collect())
    }

    /// Becomes what has been recorded of others with so many values.
    ///
    /// # Errors
    /// When the record lacks something, or the system refuses.
    pub fn restore(&mut self, record: &mut Record, values: usize) -> Result<(), OutputError> {
        for (index, half) in self.latest.iter_mut().enumerate() {
            let name = name_of(index);
            half.iterations = u64::from(record.number(&name)?);
            half.mean = record.singles(&name, values)?;
        }
        Ok(())
    }

    /// What is left of the variances that blocks state of a plane of pixels, whose values are at
    /// `index_of` each among the means of `iterations`; nothing if no half tells.
    pub fn shares(
        &self,
        [width, height]: [usize; 2],
        (mean, iterations): (&[f64], u64),
        variance_of: impl Fn(usize) -> f32,
        index_of: impl Fn(usize) -> usize,
    ) -> Option<Shares> {
        let is_half = |half: &&Half| half.iterations > 0 && 2 * half.iterations <= iterations;
        let half = self.latest.iter().rev().find(is_half)?;
        // For an error that falls with the root of the iterations from there on.
        let scale = 1.0 / (iterations as f64 / half.iterations as f64 - 1.0);
        let mut shares = Shares { tiles: Vec::new(), of_kinds: Vec::new() };
        let mut noise = Vec::with_capacity(TILE * TILE);
        for (top, left) in tiles(width, height) {
            let lines = top..height.min(top + TILE);
            let pixels =
                lines.flat_map(|y| (left..width.min(left + TILE)).map(move |x| y * width + x));
            noise.clear();
            noise.extend(pixels.map(|pixel| {
                let index = index_of(pixel);
                let found = (mean[index] - f64::from(half.mean[index])).powi(2) * scale;
                Noise { stated: variance_of(pixel), found }
            }));
            shares.push(&noise);
        }
        shares.tiles.shrink_to_fit();
        shares.of_kinds.shrink_to_fit();
        Some(shares)
    }
}

/// The variance of a pixel.
struct Noise {
    /// As blocks tell it.
    stated: f32,
    /// As its half tells it.
    found: f64,
}

/// What is left of the variances that blocks state of a plane of pixels.
pub struct Shares {
    tiles: Vec<Tile>,
    /// Tile by tile, of the kinds that a tile has.
    of_kinds: Vec<f32>,
}

/// The kinds of pixels in a tile.
struct Tile {
    /// Where their shares begin.
    first: u32,
    /// The kinds there are, a bit each.
    kinds: u16,
    /// The octave of the first.
    octave: u8,
}

impl Shares {
    /// The share of a variance that blocks state in a tile, counted in rows from the top left.
    pub fn of(&self, tile: usize, stated: f32) -> f32 {
        let Tile { first, kinds, octave } = self.tiles[tile];
        let kind = kind_of(stated, octave);
        if kinds >> kind & 1 == 0 {
            return 1.0;
        }
        let before = (kinds & ((1 << kind) - 1)).count_ones();
        self.of_kinds[(first + before) as usize]
    }

    /// Finds those of the next tile.
    fn push(&mut self, pixels: &[Noise]) {
        let noisy = || pixels.iter().filter(|it| it.stated > 0.0 && it.stated.is_finite());
        let octave = noisy().map(|it| octave_of(it.stated)).max().unwrap_or(0);
        let mut tile = Evidence::default();
        let mut kinds = [Evidence::default(); KINDS];
        for noise in noisy() {
            tile.add(noise);
            kinds[kind_of(noise.stated, octave)].add(noise);
        }
        // In a tile few pixels may say all; in a kind, they say about the same.
        let few = tile.stated * tile.stated / tile.squares;
        let of_tile = tile.share(few, (1.0, WEIGHT_OF_BLOCKS));
        let first = self.of_kinds.len() as u32;
        let mut there = 0;
        for (kind, evidence) in kinds.iter().enumerate().filter(|(_, it)| it.pixels > 0.0) {
            there |= 1 << kind;
            let share = evidence.share(evidence.pixels, (of_tile, WEIGHT_OF_TILE));
            self.of_kinds.push(share as f32);
        }
        self.tiles.push(Tile { first, kinds: there, octave });
    }
}

/// Sums over pixels.
#[derive(Clone, Copy, Default)]
struct Evidence {
    pixels: f64,
    stated: f64,
    /// Of what is stated.
    squares: f64,
    found: f64,
}

impl Evidence {
    fn add(&mut self, noise: &Noise) {
        let stated = f64::from(noise.stated);
        self.pixels += 1.0;
        self.stated += stated;
        self.squares += stated * stated;
        self.found += noise.found;
    }

    /// The share that so many pixels tell, with what is known before and the pixels that counts
    /// for. One that noise may explain is drawn to 1, and all the more the less it differs: there
    /// blocks, which are more, know better (James and Stein 1961, "Estimation with quadratic
    /// loss").
    fn share(&self, pixels: f64, (before, weight): (f64, f64)) -> f64 {
        let share = (pixels * self.found / self.stated + weight * before) / (pixels + weight);
        // Half the variance of a mean of so many squares of normal numbers: all of it would leave
        // too much along edges, which are few pixels. Above 1 as at 1, or the mean would shrink.
        let noise = share.min(1.0).powi(2) / pixels;
        let difference = 1.0 - share;
        let is_noise = difference * difference <= noise;
        if is_noise || !share.is_finite() { 1.0 } else { share + noise / difference }
    }
}

/// The octave of a number that is not negative.
fn octave_of(number: f32) -> u8 {
    (number.to_bits() >> (f32::MANTISSA_DIGITS - 1)) as u8
}

/// The kind of a pixel in a tile, by what its blocks say and the octave of the first kind.
fn kind_of(stated: f32, octave: u8) -> usize {
    usize::from(octave.saturating_sub(octave_of(stated))).min(KINDS - 1)
}

/// What the column of a half is called, and the fact of its iterations.
fn name_of(index: usize) -> String {
    format!("half {index}")
}

/// The corners of all tiles.
fn tiles(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    let lefts = move |top| (0..width).step_by(TILE).map(move |left| (top, left));
    (0..height).step_by(TILE).flat_map(lefts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Film, Gauge, Variances};
    use crate::image::rows::Rows;
    use crate::math::hash::combine;
    use crate::spectrum::Color;

    const BLOCKS: u32 = 16;
    const FILMS: u32 = 100;

    /// Stated variances of one tile, film by film, whose every pixel has some value of a block.
    fn stated(value: impl Fn(u32, usize, u32) -> f32) -> Vec<Vec<f32>> {
        let size = [TILE as u32; 2];
        let mono = Color::Mono { wavelength_nm: 550.0 };
        let of_film = |number: u32| {
            let mut film =
                Film::new(size, mono.clone(), 1, (Variances::Blocks, Gauge::None), false);
            for block in 0..BLOCKS {
                for pixel in 0..TILE * TILE {
                    film.add(pixel, 0, &[value(number, pixel, block)]);
                }
                film.finish_block(1);
            }
            let image = film.developed().whole().into_owned();
            image.variance.expect("there are blocks").swap_remove(0)
        };
        (0..FILMS).map(of_film).collect()
    }

    /// Evenly distributed from 0 to 1, another for other arguments.
    fn random(film: u32, pixel: usize, block: u32) -> f32 {
        let bits = combine(combine(combine(7, film), pixel as u32), block);
        (f64::from(bits) / 4_294_967_296.0) as f32
    }

    /// Where blocks share the interval among them, and so does each half of them: pairs in random
    /// order.
    fn stratified(film: u32, pixel: usize, block: u32) -> f32 {
        let (pair, half) = (block % (BLOCKS / 2), block / (BLOCKS / 2));
        let is_swapped = random(film, pixel, BLOCKS + pair) < 0.5;
        let stratum = 2 * pair + (half ^ u32::from(is_swapped));
        (stratum as f32 + random(film, pixel, block)) / BLOCKS as f32
    }

    /// Stated over true variance of some pixels, and its standard error.
    fn ratio(films: &[Vec<f32>], pixels: std::ops::Range<usize>, truth: f64) -> (f64, f64) {
        let count = pixels.len() as f64;
        let of = |film: &Vec<f32>| {
            film[pixels.clone()].iter().map(|it| f64::from(*it)).sum::<f64>() / (count * truth)
        };
        let ratios: Vec<f64> = films.iter().map(of).collect();
        let films = ratios.len() as f64;
        let mean = ratios.iter().sum::<f64>() / films;
        let square = ratios.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / (films - 1.0);
        (mean, (square / films).sqrt())
    }

    /// The edge of a lamp across a tile takes nothing from the variance of the pixels beside it,
    /// but for the weight of a pixel that the tile has among those of a kind: 7 % here, at most.
    /// And nobody takes anything where all pixels are alike. With other random numbers, one run in
    /// 4,000 would fail.
    #[test]
    fn bright_edges_leave_the_noise_of_their_tile_as_it_is() {
        let edge = 0..TILE;
        let noise = TILE..TILE * TILE;
        let of_noise = 1.0 / 12.0 / f64::from(BLOCKS);
        let plain = stated(random);
        let with_edge = stated(|film, pixel, block| match edge.contains(&pixel) {
            true => 100.0 * stratified(film, pixel, block),
            false => random(film, pixel, block),
        });
        for films in [&plain, &with_edge] {
            let (ratio, error) = ratio(films, noise.clone(), of_noise);
            assert!((ratio - 1.0).abs() < 0.07 + 3.7 * error, "{ratio} +- {error}");
        }
        // Blocks say 272 times as much, and halves 7 times, as of anything smooth.
        let of_edge = 1e4 / 12.0 / f64::from(BLOCKS).powi(3);
        let (ratio, _) = ratio(&with_edge, edge, of_edge);
        assert!((1.0..9.0).contains(&ratio), "{ratio}");
    }

    /// A pixel that is alone with its noise is not believed to have none, whatever its half says.
    #[test]
    fn no_pixel_takes_its_variance_from_itself() {
        let alone = stated(|film, pixel, block| match pixel {
            0 => random(film, pixel, block),
            _ => 1.0,
        });
        let of_noise = 1.0 / 12.0 / BLOCKS as f32;
        for film in alone {
            assert!(film[0] > 0.05 * of_noise, "{}", film[0] / of_noise);
            assert!(film[1..].iter().all(|it| *it == 0.0));
        }
    }

    /// What is not a number has no kind, and harms no other pixel.
    #[test]
    fn pixels_without_a_number_are_left_out() {
        let broken = stated(|film, pixel, block| match pixel {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::MAX,
            _ => random(film, pixel, block),
        });
        let (ratio, _) = ratio(&broken, 3..TILE * TILE, 1.0 / 12.0 / f64::from(BLOCKS));
        assert!((0.8..1.2).contains(&ratio), "{ratio}");
    }
}
