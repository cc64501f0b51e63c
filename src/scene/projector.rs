//! Projectors: what a point throws through a picture.
//!
//! A wall that faces one shows its picture as it is: at a distance of 1 from the point, a texel of
//! 1 gives an irradiance of the light's intensity, all over. Between the middles of texels values
//! are interpolated linearly, and stay those of the outermost beyond these.
//!
//! Directions are drawn by the picture: most of them as light is thrown, the others by brightness
//! per steradian, for nearly all that a wide projector throws goes far off its axis.
//! What is interpolated is a sum of one tent for each texel, folded at the picture's edges: so a
//! texel is drawn by its share, and a place in its tent. Texels of small pictures are parted into
//! cells for that, an odd number along either edge, so that what is between their middles still is.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::painting::columns;
use super::panorama::brightness;
use super::pattern::turn_of;
use super::world::{Picture, Projection, Taps};
use crate::image::texels::Coding;
use crate::spectrum::{Carried, Role};

/// Integers are encoded as sRGB, as in all pictures of colors.
const CODING: Coding = Coding::Srgb;
/// Share of the directions that are drawn by what is seen per steradian.
const SEEN: f64 = 0.125;
/// Cells along either edge at least: over one of them the cosine to the axis hardly changes.
const CELLS: u32 = 128;

/// A projector in its place, over its mean.
#[derive(Clone, Debug)]
pub struct Projector {
    picture: Arc<Picture>,
    /// From the world to the node: it throws along -z, right in the picture is x, and up is y.
    to_node: DMat3,
    /// Tangents of half the angles that the picture takes up from left to right and from top to
    /// bottom.
    halves: [f64; 2],
    mean: f64,
    /// How many cells there are along the edges.
    cells: [usize; 2],
    /// How much each is drawn, row by row.
    weights: Vec<f32>,
    /// Of every row, the sums of the weights up to each; and of all rows up to each.
    along: Vec<f32>,
    down: Vec<f64>,
}

impl Projector {
    /// In a place whose axes are those of the columns; half the angle that the picture takes up
    /// from left to right is in radians.
    pub fn new(Projection(picture): &Projection, axes: DMat3, half_angle: f64) -> Self {
        let cells = picture.texels().size().map(|side| (side * parts_of(side)) as usize);
        let mut projector = Self {
            picture: Arc::clone(picture),
            to_node: turn_of(axes).transpose(),
            halves: Projection::halves(picture, half_angle),
            mean: Projection::mean(picture, half_angle),
            cells,
            weights: Vec::new(),
            along: Vec::new(),
            down: Vec::new(),
        };
        projector.weigh_cells();
        projector
    }

    /// Finds how much every cell is drawn.
    fn weigh_cells(&mut self) {
        let [width, height] = self.cells;
        let of_cell = |cell: usize| {
            let middle = [cell % width, cell / width].map(|at| at as f64 + 0.5);
            let [value] = self.taps(self.texel_at(middle)).mixed(|it| [brightness(it) as f32]);
            let [x, y] = self.across(middle);
            (f64::from(value), 1.0 / DVec3::new(x, y, 1.0).length().powi(3))
        };
        let of_cells: Vec<(f64, f64)> = (0..width * height).map(of_cell).collect();
        let thrown: f64 = of_cells.iter().map(|(value, _)| value).sum();
        let seen: f64 = of_cells.iter().map(|(value, per_area)| value * per_area).sum();
        let over = SEEN / (1.0 - SEEN) * thrown / seen;
        let weight = |(value, per_area): &(f64, f64)| value * (1.0 + per_area * over);
        self.weights = of_cells.iter().map(|cell| weight(cell) as f32).collect();
        let mut sum = 0.0;
        for row in self.weights.chunks(width) {
            let mut of_row = 0.0;
            for weight in row {
                of_row += f64::from(*weight);
                self.along.push(of_row as f32);
            }
            sum += of_row;
            self.down.push(sum);
        }
    }

    /// A place in cells as one in texels.
    fn texel_at(&self, place: [f64; 2]) -> [f64; 2] {
        let size = self.size();
        std::array::from_fn(|axis| place[axis] * size[axis] / self.cells[axis] as f64)
    }

    /// Tangents of the angles, to the right and down, of a place in cells.
    fn across(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis: usize| {
            (2.0 * place[axis] / self.cells[axis] as f64 - 1.0) * self.halves[axis]
        })
    }

    /// The mean over all directions of what others are relative to.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Where it throws to, and the cosine of the angle from there to the picture's corners.
    pub fn cone(&self) -> (Vec3, f32) {
        let [x, y] = self.halves;
        let axis = self.to_node.transpose() * DVec3::NEG_Z;
        (axis.as_vec3(), (1.0 / DVec3::new(x, y, 1.0).length()) as f32)
    }

    fn size(&self) -> [f64; 2] {
        self.picture.texels().size().map(f64::from)
    }

    /// Where a direction goes through the picture, in texels from its upper left corner, and the
    /// cosine to the axis; none if it misses.
    fn place(&self, direction: Vec3) -> Option<([f64; 2], f64)> {
        let local = self.to_node * direction.as_dvec3();
        let depth = -local.z;
        if depth <= 0.0 {
            return None;
        }
        let across = [local.x, -local.y];
        let shares: [f64; 2] =
            std::array::from_fn(|axis| 0.5 + 0.5 * across[axis] / (depth * self.halves[axis]));
        let is_in = shares.iter().all(|share| (0.0..=1.0).contains(share));
        let size = self.size();
        is_in.then(|| ([size[0] * shares[0], size[1] * shares[1]], depth / local.length()))
    }

    /// The texels about a place.
    fn taps(&self, place: [f64; 2]) -> Taps {
        let texels = self.picture.texels();
        let [(columns, across), (rows, down)] =
            [0, 1].map(|axis: usize| neighbors(place[axis], texels.size()[axis] as usize));
        let at = |column: usize, row: usize| texels.at(column as u32, row as u32, CODING);
        let [[left, right], [upper, lower]] = [columns, rows];
        let texels = [at(left, upper), at(right, upper), at(left, lower), at(right, lower)];
        Taps { texels, shares: [across, down].map(|share| share as f32) }
    }

    /// The intensity along a direction of world space over the mean, in the columns of a render.
    // Once for each number of columns, and not where it is asked for.
    #[inline(never)]
    pub fn share<const N: usize>(&self, direction: Vec3, carried: &Carried<N>) -> [f32; N] {
        let Some((place, cosine)) = self.place(direction) else { return [0.0; N] };
        let over = (1.0 / (cosine.powi(3) * self.mean)) as f32;
        let filtered = self.taps(place).mixed(|[red, green, blue, _]| {
            columns([red, green, blue], Some(Role::Coefficient), carried)
        });
        filtered.map(|value| value * over)
    }

    /// The density per steradian of drawing a direction.
    pub fn density(&self, direction: Vec3) -> f32 {
        let Some((place, cosine)) = self.place(direction) else { return 0.0 };
        let [width, height] = self.cells;
        let (size, shares) = (self.size(), [width, height].map(|count| count as f64));
        let [(columns, across), (rows, down)] = [0, 1].map(|axis: usize| {
            neighbors(place[axis] * shares[axis] / size[axis], self.cells[axis])
        });
        let of_row = |row: usize| {
            let [left, right] = columns.map(|column| f64::from(self.weights[row * width + column]));
            left + across * (right - left)
        };
        let [upper, lower] = rows.map(of_row);
        let weight = upper + down * (lower - upper);
        let area = 4.0 * self.halves[0] * self.halves[1] / (shares[0] * shares[1]);
        (weight / (self.down[height - 1] * area * cosine.powi(3))) as f32
    }

    /// Draws a direction by two numbers in [0, 1).
    pub fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let [width, height] = self.cells;
        let (row, v) = found(height, f64::from(v), |row| self.down[row]);
        let of_row = &self.along[row * width..][..width];
        let (column, u) = found(width, f64::from(u), |column| f64::from(of_row[column]));
        let middle = [column as f64 + 0.5, row as f64 + 0.5];
        let drawn = self.towards([
            folded(middle[0] + in_tent(u), width as f64),
            folded(middle[1] + in_tent(v), height as f64),
        ]);
        // At the very edge of a tent, rounding may lead out of it.
        if self.density(drawn) > 0.0 { drawn } else { self.towards(middle) }
    }

    /// The direction to a place in cells.
    fn towards(&self, place: [f64; 2]) -> Vec3 {
        let [x, y] = self.across(place);
        (self.to_node.transpose() * DVec3::new(x, -y, -1.0)).normalize().as_vec3()
    }
}

/// Into how many cells a texel is parted along an edge of so many.
fn parts_of(side: u32) -> u32 {
    CELLS.div_ceil(side) | 1
}

/// Between which two of so many middles a place is, and how far it has come from the first.
fn neighbors(place: f64, count: usize) -> ([usize; 2], f64) {
    let last = count - 1;
    let at = (place - 0.5).clamp(0.0, last as f64);
    let first = (at as usize).min(last);
    ([first, (first + 1).min(last)], at - first as f64)
}

/// Which of so many running sums is the first to be over a share of the last, and what is left of
/// the number, from 0 to 1.
fn found(count: usize, share: f64, sum_at: impl Fn(usize) -> f64) -> (usize, f64) {
    let target = share * sum_at(count - 1);
    let (mut low, mut high) = (0, count - 1);
    while low < high {
        let middle = usize::midpoint(low, high);
        if sum_at(middle) > target { high = middle } else { low = middle + 1 }
    }
    let before = if low == 0 { 0.0 } else { sum_at(low - 1) };
    (low, ((target - before) / (sum_at(low) - before)).clamp(0.0, 1.0))
}

/// A place in a tent over [-1, 1], by a number from 0 to 1.
fn in_tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

/// A place beyond an edge as far before it.
fn folded(place: f64, size: f64) -> f64 {
    let place = place.abs();
    if place > size { 2.0 * size - place } else { place }
}
