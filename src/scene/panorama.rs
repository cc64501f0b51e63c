//! Pictures of all directions: what light comes from where at infinity.
//!
//! They are equirectangular. In their own space the middle shows +x, right of that lies +z, and the
//! upper edge is +y, as in Blender (with its axes exchanged as glTF has them) and three.js. Between
//! the middles of texels values are interpolated linearly, around the picture too; beyond the
//! uppermost and lowest ones they are those of the edge.
//!
//! Directions are drawn by the picture: a point of it with a density that is the bilinear
//! interpolation of brightness times the sine of the polar angle at the middles of texels, zero at
//! the poles. Per steradian that is nearly in proportion to what is seen, and zero only where that
//! is. Running sums of the rows, blended as the rows are, give a point by two searches (the inverse
//! of a piecewise quadratic function each); in a row, those of every sixteenth column come first.

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};
use rayon::prelude::*;

use super::painting::columns;
use super::world::{Picture, Taps};
use crate::image::texels::{Coding, Texels};
use crate::math::elementary::{cos, sin, sin_cos};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::spectrum::{Carried, Role, lit};

/// Integers are encoded as sRGB, as in all pictures of this kind.
const CODING: Coding = Coding::Srgb;
/// How near to the edge of a cell points are, relative to its size: at an edge there may be none.
const EDGE: f64 = 1e-6;
/// Columns between two sums of a row.
const BLOCK: usize = 16;

/// A picture, and how it lies on the sphere of directions.
#[derive(Clone, Debug)]
pub struct Panorama {
    picture: Arc<Picture>,
    /// What linear red, green and blue are multiplied by.
    factor: [f32; 3],
    /// From the world's space to that of the picture: a rotation.
    turn: Mat3,
}

impl PartialEq for Panorama {
    /// Pictures are the same if they are one.
    fn eq(&self, other: &Self) -> bool {
        let Self { picture, factor, turn } = self;
        Arc::ptr_eq(picture, &other.picture) && (factor, turn) == (&other.factor, &other.turn)
    }
}

impl Panorama {
    /// A picture with a factor, turned by a rotation from its own space to the world's.
    pub fn new(picture: Arc<Picture>, factor: [f32; 3], to_world: Mat3) -> Self {
        Self { picture, factor, turn: to_world.transpose() }
    }

    /// Its mean over all directions: linear red, green and blue.
    pub fn mean(&self) -> [f32; 3] {
        let mean = self.picture.directions().mean;
        std::array::from_fn(|n| (mean[n] * f64::from(self.factor[n])) as f32)
    }

    /// The mean of all directions by how bright they are: of length 1 if one of them is all.
    pub fn middle(&self) -> Vec3 {
        self.turn.transpose() * self.picture.directions().middle.as_vec3()
    }

    /// About the share of all directions that its light takes up: one if all are as bright.
    pub fn spread(&self) -> f64 {
        self.picture.directions().spread
    }

    /// The texels about a direction of unit length to where the light comes from.
    fn taps(&self, direction: Vec3) -> Taps {
        let texels = self.picture.texels();
        let size = texels.size().map(|it| it as usize);
        Place::of(self.turn * direction, size).taps(texels)
    }

    /// What comes from a direction, in the columns of a render.
    // Once for each number of columns, and not where it is asked for.
    #[inline(never)]
    pub fn radiance<const N: usize>(&self, direction: Vec3, carried: &Carried<N>) -> [f32; N] {
        let factor = self.factor;
        let value = self.taps(direction).mixed(|[red, green, blue, _]| {
            let rgb = [factor[0] * red, factor[1] * green, factor[2] * blue];
            columns(rgb, Some(Role::Coefficient), carried)
        });
        lit(value, carried)
    }

    /// Whether its light is polarized.
    pub fn is_polarized(&self) -> bool {
        self.picture.is_polarized()
    }

    /// How the light from a direction is polarized, if it is: S1, S2 and S3 over S0 in the columns
    /// of a render, and the reference axis, to the right in the picture.
    // Once for each number of columns, and not where it is asked for.
    #[inline(never)]
    pub fn state<const N: usize>(
        &self,
        direction: Vec3,
        carried: &Carried<N>,
    ) -> Option<([[f32; 3]; N], Vec3)> {
        let texels = self.picture.texels();
        let own = self.turn * direction;
        let place = Place::of(own, texels.size().map(|it| it as usize));
        let (mut states, mut sums) = ([[0.0; 3]; N], [0.0; N]);
        for ([column, row], share) in place.corners() {
            let [red, green, blue, _] = texels.at(column as u32, row as u32, CODING);
            let [r, g, b] = self.factor;
            let of_texel = columns([r * red, g * green, b * blue], Some(Role::Emission), carried);
            let [red, green, blue] = self.picture.state_at(column, row)?;
            for component in 0..3 {
                let rgb = [red, green, blue].map(|state| state[component]);
                let shares = columns(rgb, Some(Role::Index), carried);
                for n in 0..N {
                    states[n][component] += share * of_texel[n] * shares[n];
                }
            }
            sums.iter_mut().zip(of_texel).for_each(|(sum, of_texel)| *sum += share * of_texel);
        }
        for (state, sum) in states.iter_mut().zip(sums) {
            let over = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            state.iter_mut().for_each(|value| *value *= over);
        }
        let right = Vec3::new(-own.z, 0.0, own.x).try_normalize().unwrap_or(Vec3::Z);
        Some((states, self.turn.transpose() * right))
    }

    /// The directions, to where the light comes from, that eight pairs of numbers in [0, 1) draw,
    /// and their densities per steradian: greater than zero.
    pub fn draw_lanes(&self, u: [F32s; 2]) -> (Vector<F32s>, F32s) {
        let directions = self.picture.directions();
        let [u, v] = u.map(F32s::to_array);
        let places: [Place; LANES] =
            std::array::from_fn(|lane| directions.draw([u[lane], v[lane]]));
        let (own, sines) = directions_of(&places);
        let rows = self.turn.transpose().to_cols_array_2d();
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let along = |column: usize| F32s::splat(rows[column][axis]);
            own.x * along(0) + own.y * along(1) + own.z * along(2)
        });
        let direction = Vector::new(x, y, z);
        let length = direction.dot(direction).sqrt();
        let sines = sines.to_array();
        let density = lanes::each(|lane| directions.density(&places[lane], sines[lane]));
        (Vector::new(x / length, y / length, z / length), F32s::from(density))
    }

    /// That of one pair.
    pub fn draw(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (direction, density) = self.draw_lanes(u.map(F32s::splat));
        (Vec3::from(direction.to_rows()[0]), density.to_array()[0])
    }

    /// The density with which a direction of unit length is drawn, per steradian.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let directions = self.picture.directions();
        let own = self.turn * direction;
        directions.density(&Place::of(own, directions.size), across(own))
    }
}

/// How the directions of a picture are drawn. Nothing in it hangs on factors and rotations.
pub struct Directions {
    /// Columns and rows.
    size: [usize; 2],
    /// The weight of every texel.
    weights: Vec<f32>,
    /// For every row, the integral of its weights from the middle of the first texel to that of
    /// every [`BLOCK`]th, and behind these over the whole turn.
    along: Vec<f32>,
    /// Integrals over all cells between rows, and between these and the poles, before each: one
    /// more than there are rows, and the whole behind them.
    down: Vec<f64>,
    /// Means over all directions, and of the directions by their brightness.
    mean: [f64; 3],
    middle: DVec3,
    spread: f64,
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

/// A point of a picture: in a cell between two rows, or a row and a pole, and two columns.
struct Place {
    size: [usize; 2],
    /// The cell: that behind so many rows and columns.
    cell: [usize; 2],
    /// Where in the cell: to the right and down, from 0 to 1.
    shares: [f64; 2],
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
        let along: Vec<f32> = weights.par_chunks(width).flat_map_iter(sums_along).collect();
        let ends = along.len() / height;
        let whole = |row: usize| f64::from(along[(row + 1) * ends - 1]);
        let mut down = vec![0.0, 0.25 * whole(0)];
        for row in 1..height {
            down.push(down[row] + 0.5 * (whole(row - 1) + whole(row)));
        }
        down.push(down[height] + 0.25 * whole(height - 1));
        let mut directions = Self {
            size: [width, height],
            weights,
            along,
            down,
            mean: [0.0; 3],
            middle: DVec3::ZERO,
            spread: 1.0,
        };
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

    /// The sums of a row: one for every block, and the whole.
    fn sums(&self, row: usize) -> &[f32] {
        let count = self.along.len() / self.size[1];
        &self.along[row * count..][..count]
    }

    /// The weights of a row.
    fn row(&self, row: usize) -> &[f32] {
        &self.weights[row * self.size[0]..][..self.size[0]]
    }

    /// The place that two numbers in [0, 1) draw.
    fn draw(&self, u: [f32; 2]) -> Place {
        let height = self.size[1];
        let [u, v] = u.map(f64::from);
        let target = v * self.down[height + 1];
        let cell = self.down[1..=height].partition_point(|&sum| sum <= target);
        let whole = |row: usize| self.sums(row).last().map_or(0.0, |sum| f64::from(*sum));
        // Cells at the poles are half as high.
        let (ends, high) = match cell {
            0 => ([0.0, whole(0)], 0.5),
            _ if cell == height => ([whole(height - 1), 0.0], 0.5),
            _ => ([whole(cell - 1), whole(cell)], 1.0),
        };
        let down = inverse(ends, (target - self.down[cell]) / high);
        let mut place = Place { size: self.size, cell: [0, cell], shares: [0.0, down] };
        let (column, share) = self.draw_column(&place, u);
        place.cell[0] = column;
        place.shares[0] = share;
        place
    }

    /// Where in its row a place is drawn by a number in [0, 1): behind which column, and how far.
    fn draw_column(&self, place: &Place, u: f64) -> (usize, f64) {
        let ([upper, lower], [above, below]) = place.rows();
        let mixed = |of: [&[f32]; 2], at: usize| {
            above * f64::from(of[0][at]) + below * f64::from(of[1][at])
        };
        let sums = [self.sums(upper), self.sums(lower)];
        let blocks = sums[0].len() - 1;
        let target = u * mixed(sums, blocks);
        let (mut low, mut high) = (0, blocks);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if mixed(sums, middle) <= target { low = middle } else { high = middle }
        }
        let rows = [self.row(upper), self.row(lower)];
        let width = self.size[0];
        let mut left = target - mixed(sums, low);
        let first = BLOCK * low;
        let mut found = (first, [0.0; 2], 0.0);
        let mut ends = [mixed(rows, first), 0.0];
        for column in first..(first + BLOCK).min(width) {
            ends[1] = mixed(rows, (column + 1) % width);
            let cell = 0.5 * (ends[0] + ends[1]);
            // By rounding something may be left behind the last cell that has light.
            if cell > 0.0 {
                found = (column, ends, left);
            }
            if left < cell {
                break;
            }
            left -= cell;
            ends[0] = ends[1];
        }
        let (column, ends, left) = found;
        (column, inverse(ends, left))
    }

    /// The density of a place, per steradian, where this is the sine of the polar angle.
    fn density(&self, place: &Place, sine: f32) -> f32 {
        let ([upper, lower], [above, below]) = place.rows();
        let [left, right] = place.columns().map(|column| {
            above * f64::from(self.row(upper)[column]) + below * f64::from(self.row(lower)[column])
        });
        let [width, height] = self.size.map(|it| it as f64);
        let weight = left + (right - left) * place.shares[0];
        let steradians = TAU / width * (PI / height) * f64::from(sine);
        (weight / (self.down[self.size[1] + 1] * steradians)) as f32
    }
}

/// The integral of a row's weights to every [`BLOCK`]th column, and over all of it.
fn sums_along(weights: &[f32]) -> impl Iterator<Item = f32> {
    let blocks = weights.len().div_ceil(BLOCK);
    let mut sum = 0.0;
    let between = move |block: usize| {
        for column in BLOCK * block..(BLOCK * (block + 1)).min(weights.len()) {
            let next = weights[(column + 1) % weights.len()];
            sum += 0.5 * (f64::from(weights[column]) + f64::from(next));
        }
        sum as f32
    };
    std::iter::once(0.0).chain((0..blocks).map(between))
}

/// The sine of the angle of a direction of unit length from +y.
fn across(direction: Vec3) -> f32 {
    direction.x.mul_add(direction.x, direction.z * direction.z).sqrt()
}

/// The directions of places, and the sines of their angles from +y.
fn directions_of(places: &[Place; LANES]) -> (Vector<F32s>, F32s) {
    let from_pole = F32s::from(lanes::each(|lane| places[lane].nearer_pole().0));
    let to_pole = F32s::from(lanes::each(|lane| places[lane].nearer_pole().1));
    let around = F32s::from(lanes::each(|lane| {
        let Place { size, cell, shares } = &places[lane];
        azimuth(cell[0] as f64 + shares[0], size[0]) as f32
    }));
    let (sine, cosine) = from_pole.sin_cos();
    let (z, x) = around.sin_cos();
    (Vector::new(sine * x, to_pole * cosine, sine * z), sine)
}

impl Place {
    /// That of a direction of unit length.
    fn of(direction: Vec3, size: [usize; 2]) -> Self {
        let [width, height] = size.map(|it| it as f64);
        // From the nearer pole, so that no digits are lost there.
        let ends = lanes::each(|lane| [direction.z, across(direction)][lane % 2]);
        let sides = lanes::each(|lane| [direction.x, direction.y.abs()][lane % 2]);
        let [around, from_pole, ..] = F32s::from(ends).atan2(F32s::from(sides)).to_array();
        let x = ((f64::from(around) / TAU + 0.5) * width + width - 0.5) % width;
        let column = (x as usize).min(size[0] - 1);
        // In rows.
        let from_pole = (f64::from(from_pole) / PI).clamp(0.0, 0.5) * height;
        let (cell, down) = match from_pole {
            it if it < 0.5 => (0, 2.0 * it),
            it => ((it + 0.5) as usize, (it + 0.5).fract()),
        };
        let (cell, down) = match direction.y < 0.0 {
            true => (size[1] - cell, 1.0 - down),
            false => (cell, down),
        };
        let shares = [x - column as f64, down].map(|share| share.clamp(EDGE, 1.0 - EDGE));
        Self { size, cell: [column, cell], shares }
    }

    /// The two rows about it, and their shares in the weight, which is zero at the poles.
    fn rows(&self) -> ([usize; 2], [f64; 2]) {
        let ([_, cell], down, height) = (self.cell, self.shares[1], self.size[1]);
        match cell {
            0 => ([0; 2], [0.0, down]),
            _ if cell == height => ([height - 1; 2], [1.0 - down, 0.0]),
            _ => ([cell - 1, cell], [1.0 - down, down]),
        }
    }

    /// The two columns about it.
    fn columns(&self) -> [usize; 2] {
        [self.cell[0], (self.cell[0] + 1) % self.size[0]]
    }

    /// In rows from the middle of the uppermost.
    fn y(&self) -> f64 {
        match self.cell[1] {
            0 => 0.5 * self.shares[1] - 0.5,
            cell if cell == self.size[1] => cell as f64 - 1.0 + 0.5 * self.shares[1],
            cell => cell as f64 - 1.0 + self.shares[1],
        }
    }

    /// Its angle from the nearer pole, and 1 or -1 for the upper and the lower one.
    fn nearer_pole(&self) -> (f32, f32) {
        let y = self.y();
        let below = self.size[1] as f64 - 1.0 - y;
        let (rows, pole) = if y <= below { (y, 1.0) } else { (below, -1.0) };
        (polar_angle(rows, self.size[1]) as f32, pole)
    }

    /// The columns and rows about it, and their shares.
    fn corners(&self) -> [([usize; 2], f32); 4] {
        let ([upper, lower], [_, down]) = self.rows();
        let [left, right] = self.columns();
        let [across, down] = [self.shares[0], down].map(|share| share as f32);
        [
            ([left, upper], (1.0 - across) * (1.0 - down)),
            ([right, upper], across * (1.0 - down)),
            ([left, lower], (1.0 - across) * down),
            ([right, lower], across * down),
        ]
    }

    /// The texels about it.
    fn taps(&self, texels: &Texels) -> Taps {
        let (rows, shares) = self.rows();
        let texel = |column: usize, row: usize| texels.at(column as u32, row as u32, CODING);
        let [left, right] = self.columns();
        let of_row = |row: usize| [texel(left, row), texel(right, row)];
        let ([first, second], [third, fourth]) = (of_row(rows[0]), of_row(rows[1]));
        // Between the middle of an edge's texels and the pole both rows are one.
        let shares = [self.shares[0] as f32, shares[1] as f32];
        Taps { texels: [first, second, third, fourth], shares }
    }
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
pub(super) fn brightness([red, green, blue, _]: [f32; 4]) -> f64 {
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

/// Where the integral of what is linear from the first to the second of two values over [0, 1] has
/// come to a sum; not quite at an end.
fn inverse([first, second]: [f64; 2], sum: f64) -> f64 {
    let sum = sum.clamp(0.0, 0.5 * (first + second));
    let root = (first * first + 2.0 * (second - first) * sum).max(0.0).sqrt();
    let share = if sum > 0.0 { 2.0 * sum / (first + root) } else { 0.0 };
    share.clamp(EDGE, 1.0 - EDGE)
}
