//! How directions are drawn by an equirectangular picture.
//!
//! The density over the picture is the bilinear interpolation of brightness times the sine of the
//! polar angle at the middles of texels, zero at the poles: a sum of hats, one for every texel. A
//! number draws the row of a hat and how far down in that, by the sums of the rows, and another the
//! column, by running sums of that row: for every eighth column, and within these. Nearer numbers
//! draw nearer places, but for the width of a hat.

use std::array;
use std::f64::consts::{PI, TAU};
use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use super::CODING;
use super::places::Places;
use crate::math::elementary::{cos, sin, sin_cos};
use crate::math::{F32s, LANES, Real, lanes};
use crate::scene::world::Picture;

/// How directions of a picture are drawn. Nothing in it hangs on factors and rotations.
pub struct Directions {
    /// Columns and rows.
    size: [usize; 2],
    /// The weight of every texel.
    weights: Vec<f32>,
    /// Rows of as many blocks of columns as a row of texels fills: sums of the weights of a block
    /// up to every column. Behind the last column there are infinite ones.
    within: Vec<[f32; LANES]>,
    /// For every row, the sums of its weights before every block, and of all.
    before: Vec<f32>,
    /// The integrals over the hats of all rows before each, and over all.
    down: Vec<f64>,
    /// Means over all directions, and of the directions by their brightness.
    pub mean: [f64; 3],
    /// The mean of the directions by their brightness.
    pub middle: DVec3,
    /// About the share of all directions that light comes from.
    pub spread: f64,
}

impl fmt::Debug for Directions {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Directions of {:?}", self.size)
    }
}

/// What is to be known of a row.
struct RowSums {
    /// Of red, green and blue.
    colors: [f64; 3],
    /// Of brightness along the axes, and of its square.
    brightness: f64,
    across: [f64; 2],
    squares: f64,
}

impl Directions {
    /// Those of a picture in linear red, green and blue.
    pub fn new(picture: &Picture) -> Self {
        let texels = picture.texels();
        let [width, height] = texels.size().map(|it| it as usize);
        let brightness_at =
            |column: usize, row: usize| brightness(texels.at(column as u32, row as u32, CODING));
        let most = (0..height)
            .into_par_iter()
            .map(|row| (0..width).map(|column| brightness_at(column, row)).fold(0.0, f64::max))
            .reduce(|| 0.0, f64::max);
        let unit = if most > 0.0 { 1.0 / most } else { 0.0 };
        let turns: Vec<(f64, f64)> =
            (0..width).map(|column| sin_cos(azimuth(column as f64, width))).collect();
        let mut weights = vec![0.0_f32; width * height];
        let sums: Vec<RowSums> = weights
            .par_chunks_mut(width)
            .enumerate()
            .map(|(row, weights)| {
                let scale = unit * sin(polar_angle(row as f64, height));
                for (column, weight) in weights.iter_mut().enumerate() {
                    *weight = (scale * brightness_at(column, row)) as f32;
                }
                let texels = (0..width).map(|it| texels.at(it as u32, row as u32, CODING));
                RowSums::of(texels.zip(&turns))
            })
            .collect();
        let mut directions = Self {
            size: [width, height],
            within: weights.par_chunks(width).flat_map_iter(sums_within).collect(),
            before: weights.par_chunks(width).flat_map_iter(sums_before).collect(),
            down: vec![0.0],
            weights,
            mean: [0.0; 3],
            middle: DVec3::ZERO,
            spread: 1.0,
        };
        let mut sum = 0.0;
        for row in 0..height {
            let [above, below] = directions.sides(row);
            let whole = directions.sums_of_blocks(row).last().copied().unwrap_or_default();
            sum += (above + below) * f64::from(whole);
            directions.down.push(sum);
        }
        directions.add_up(&sums);
        directions
    }

    fn add_up(&mut self, sums: &[RowSums]) {
        let [width, height] = self.size;
        let (mut brightness, mut squares, mut middle) = (0.0, 0.0, DVec3::ZERO);
        // What light of a column that falls off to both its neighbors keeps of its direction.
        let half = PI / width as f64;
        let kept = (sin(half) / half).powi(2);
        for (row, of) in sums.iter().enumerate() {
            let share = 0.5 * row_integral(row, height) / width as f64;
            let (sine, cosine) = sin_cos(polar_angle(row as f64, height));
            for (mean, sum) in self.mean.iter_mut().zip(of.colors) {
                *mean += share * sum;
            }
            brightness += share * of.brightness;
            squares += share * of.squares;
            let [x, z] = of.across.map(|it| kept * it);
            middle += share * DVec3::new(sine * x, cosine * of.brightness, sine * z);
        }
        if brightness > 0.0 {
            self.middle = middle / brightness;
            self.spread = brightness * brightness / squares;
        }
    }

    /// Integrals over the hat of a row above and below its middle: to the poles it is half as
    /// wide.
    fn sides(&self, row: usize) -> [f64; 2] {
        let to_pole = |is_last: bool| if is_last { 0.25 } else { 0.5 };
        [to_pole(row == 0), to_pole(row + 1 == self.size[1])]
    }

    /// The sums of a row before every block of columns, and of all.
    #[inline(always)]
    fn sums_of_blocks(&self, row: usize) -> &[f32] {
        let count = self.before.len() / self.size[1];
        &self.before[row * count..][..count]
    }

    /// The places that eight pairs of numbers in [0, 1) draw.
    // Step by step in all lanes: what one waits for from memory, the others do at once.
    pub fn draw(&self, [u, v]: [F32s; 2]) -> Places {
        let [u, v] = [u, v].map(F32s::to_array);
        let rows = v.map(|v| self.draw_row(f64::from(v)));
        let blocks: [_; LANES] = array::from_fn(|lane| self.draw_block(rows[lane].0, u[lane]));
        let columns = blocks.map(|(block, left)| self.draw_column(block, left));
        let [height, width] = [self.size[1] as u32, self.size[0] as u32];
        let sides = rows.map(|(row, _)| self.sides(row).map(|side| side as f32));
        let side = |of: usize| F32s::from(sides.map(|sides| sides[of]));
        let down = hat([side(0), side(1)], F32s::from(rows.map(|(_, share)| share)));
        let across = hat([F32s::HALF; 2], F32s::from(columns.map(|(_, share)| share)));
        let [is_right, is_below] =
            [across, down].map(|place| place.simd_ge(F32s::ZERO).to_bitmask());
        let is = |mask: u32, lane: usize| mask >> lane & 1 == 1;
        let (mut cells, mut half_cells) = ([[0; LANES]; 2], [1.0; LANES]);
        for lane in 0..LANES {
            let (row, column) = (rows[lane].0 as u32, columns[lane].0 as u32);
            let left = if column == 0 { width - 1 } else { column - 1 };
            cells[0][lane] = if is(is_right, lane) { column } else { left };
            cells[1][lane] = row + u32::from(is(is_below, lane));
            if cells[1][lane] % height == 0 {
                half_cells[lane] = 2.0;
            }
        }
        // Cells at the poles are half as high, and are counted from and to these.
        let down = down * F32s::from(half_cells);
        let within =
            |place: F32s| Real::select(place.simd_ge(F32s::ZERO), place, F32s::ONE + place);
        Places::new(self.size, cells, [within(across), within(down)])
    }

    /// The row of a hat that a number in [0, 1) draws, and which share of that is before.
    #[inline(always)]
    fn draw_row(&self, v: f64) -> (usize, f32) {
        let height = self.size[1];
        let target = v * self.down[height];
        let row = self.down[1..height].partition_point(|&sum| sum <= target);
        let share = (target - self.down[row]) / (self.down[row + 1] - self.down[row]);
        (row, share as f32)
    }

    /// The block of columns in a row that a number in [0, 1) draws, among those of all rows, and
    /// how much of it is before.
    #[inline(always)]
    fn draw_block(&self, row: usize, u: f32) -> (usize, f32) {
        let before = self.sums_of_blocks(row);
        let blocks = before.len() - 1;
        let target = u * before[blocks];
        let block = before[1..blocks].partition_point(|&sum| sum <= target);
        (row * blocks + block, target - before[block])
    }

    /// The column of a hat in a block of all rows before which there is so much, and which share of
    /// that is before.
    #[inline(always)]
    fn draw_column(&self, block: usize, left: f32) -> (usize, f32) {
        let within = &self.within[block];
        let is_passed = F32s::from(*within).simd_le(F32s::splat(left)).to_bitmask();
        let place = is_passed.count_ones() as usize;
        let blocks = self.size[0].div_ceil(LANES);
        let column = LANES * (block % blocks) + place;
        // By rounding there may be nothing where a number leads.
        if place == LANES || within[place] == f32::INFINITY {
            return (self.nearest_with_light(block / blocks, column), 0.5);
        }
        let passed = if place == 0 { 0.0 } else { within[place - 1] };
        (column, (left - passed) / (within[place] - passed))
    }

    #[cold]
    fn nearest_with_light(&self, row: usize, column: usize) -> usize {
        let width = self.size[0];
        let weights = &self.weights[row * width..][..width];
        let column = column.min(width - 1);
        let is_lit = |column: &usize| weights[*column] > 0.0;
        let before = (0..=column).rev().find(is_lit);
        before.or_else(|| (column..width).find(is_lit)).unwrap_or(column)
    }

    /// The densities of places, per steradian, where these are the sines of the polar angles.
    #[inline(always)]
    pub fn density(&self, places: &Places, sines: F32s) -> F32s {
        let weights = lanes::each(|lane| self.weight(places, lane));
        F32s::from(weights) * F32s::splat(self.per_weight()) / sines
    }

    /// That of one of the places.
    #[inline(always)]
    pub fn density_of(&self, places: &Places, lane: usize, sine: f32) -> f32 {
        self.weight(places, lane) * self.per_weight() / sine
    }

    /// The density of a place over its weight, per area of the sphere over its sine.
    #[inline(always)]
    fn per_weight(&self) -> f32 {
        let [width, height] = self.size.map(|it| it as f64);
        let cell = TAU / width * (PI / height);
        (1.0 / (cell * self.down[self.size[1]])) as f32
    }

    #[inline(always)]
    fn weight(&self, places: &Places, lane: usize) -> f32 {
        let ([upper, lower], [above, below]) = places.rows(lane);
        let ([left, right], across) = places.columns(lane);
        let width = self.size[0];
        let at = |column: usize| {
            let [upper, lower] = [upper, lower].map(|row| self.weights[row * width + column]);
            above.mul_add(upper, below * lower)
        };
        let [left, right] = [at(left), at(right)];
        (right - left).mul_add(across, left)
    }
}

/// Where shares of hats are, whose two sides have these integrals: from -1, or half of that where
/// one is cut off, by way of 0 in the middle to 1. All sides have one slope.
#[inline(always)]
fn hat([before, behind]: [F32s; 2], share: F32s) -> F32s {
    let (two, one) = (F32s::splat(2.0), F32s::ONE);
    let whole = before + behind;
    let [left, right] = [share * whole, (one - share) * whole];
    let rise = |part: F32s, side: F32s| {
        let part = (part / side).fast_max(F32s::ZERO).fast_min(one);
        two * side * (one - part.sqrt())
    };
    Real::select(left.simd_lt(before), -rise(left, before), rise(right, behind))
}

/// For every block of a row's columns, the sums of their weights up to each.
fn sums_within(weights: &[f32]) -> impl Iterator<Item = [f32; LANES]> {
    weights.chunks(LANES).map(|block| {
        let mut sum = 0.0;
        let mut sums = [f32::INFINITY; LANES];
        for (of_column, weight) in sums.iter_mut().zip(block) {
            sum += f64::from(*weight);
            *of_column = sum as f32;
        }
        sums
    })
}

/// The sums of a row before every block of columns, and of all.
fn sums_before(weights: &[f32]) -> impl Iterator<Item = f32> {
    let mut sum = 0.0;
    let behind = weights.chunks(LANES).map(move |block| {
        sum += block.iter().map(|weight| f64::from(*weight)).sum::<f64>();
        sum as f32
    });
    std::iter::once(0.0).chain(behind)
}

impl RowSums {
    fn of<'a>(texels: impl Iterator<Item = ([f32; 4], &'a (f64, f64))>) -> Self {
        let mut sums = Self { colors: [0.0; 3], brightness: 0.0, across: [0.0; 2], squares: 0.0 };
        for (texel, (sine, cosine)) in texels {
            for (sum, value) in sums.colors.iter_mut().zip(texel) {
                *sum += f64::from(value);
            }
            let brightness = brightness(texel);
            sums.brightness += brightness;
            sums.squares += brightness * brightness;
            sums.across[0] += brightness * cosine;
            sums.across[1] += brightness * sine;
        }
        sums
    }
}

/// What counts of a texel where directions are drawn: the mean of the three, so that no channel
/// is much brighter than that.
pub fn brightness([red, green, blue, _]: [f32; 4]) -> f64 {
    (f64::from(red) + f64::from(green) + f64::from(blue)) / 3.0
}

/// The angle from +y of what is so many rows below the middle of the uppermost.
fn polar_angle(y: f64, height: usize) -> f64 {
    PI * (y + 0.5) / height as f64
}

/// The angle from +x towards +z of what is so many columns right of the middle of the first.
fn azimuth(x: f64, width: usize) -> f64 {
    TAU * ((x + 0.5) / width as f64 - 0.5)
}

/// The integral over the polar angle of its sine times what a row contributes to the values between
/// it and its neighbors. Those of all rows add up to two.
fn row_integral(row: usize, height: usize) -> f64 {
    let step = PI / height as f64;
    let middle = polar_angle(row as f64, height);
    // Of the sine times 1 - t, from an angle on, over t of 0 to 1.
    let falling =
        |from: f64, step: f64| cos(from) / step - (sin(from + step) - sin(from)) / (step * step);
    let to_pole = 1.0 - cos(0.5 * step);
    let above = if row == 0 { to_pole } else { step * falling(middle, -step) };
    let below = if row + 1 == height { to_pole } else { step * falling(middle, step) };
    above + below
}
