//! Projectors: what a point throws through a picture.
//!
//! A wall that faces one shows its picture as it is: at a distance of 1 from the point, a texel of
//! 1 gives an irradiance of the light's intensity, all over. Between the middles of texels values
//! are interpolated linearly, and stay those of the outermost beyond these.
//!
//! Directions are drawn by the picture. What is interpolated is a sum of one tent for each texel,
//! folded at the picture's edges: so a texel is drawn by its brightness, and a place in its tent.

use std::f64::consts::PI;
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
    /// Of every row, the brightness of its texels up to each; and of all rows up to each.
    along: Vec<f32>,
    down: Vec<f64>,
}

impl Projector {
    /// In a place whose axes are those of the columns; half the angle that the picture takes up
    /// from left to right is in radians.
    pub fn new(Projection(picture): &Projection, axes: DMat3, half_angle: f64) -> Self {
        let halves = Projection::halves(picture, half_angle);
        let [width, height] = picture.texels().size();
        let (mut along, mut down) = (Vec::new(), Vec::new());
        let mut sum = 0.0;
        for row in 0..height {
            let mut of_row = 0.0;
            for column in 0..width {
                of_row += brightness(picture.texels().at(column, row, CODING));
                along.push(of_row as f32);
            }
            sum += of_row;
            down.push(sum);
        }
        let mean = Projection::mean(picture, half_angle);
        let picture = Arc::clone(picture);
        Self { picture, to_node: turn_of(axes).transpose(), halves, mean, along, down }
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
        let about = |axis: usize| {
            let last = texels.size()[axis] - 1;
            let at = (place[axis] - 0.5).clamp(0.0, f64::from(last));
            let first = (at as u32).min(last);
            ([first, (first + 1).min(last)], (at - f64::from(first)) as f32)
        };
        let ([left, right], across) = about(0);
        let ([upper, lower], down) = about(1);
        let at = |column: u32, row: u32| texels.at(column, row, CODING);
        let texels = [at(left, upper), at(right, upper), at(left, lower), at(right, lower)];
        Taps { texels, shares: [across, down] }
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
        let [value] = self.taps(place).mixed(|texel| [brightness(texel) as f32]);
        // Everything that is thrown is the mean in all directions.
        (f64::from(value) / (cosine.powi(3) * self.mean * 4.0 * PI)) as f32
    }

    /// Draws a direction by two numbers in [0, 1).
    pub fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let [width, height] = self.picture.texels().size().map(|it| it as usize);
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

    /// The direction to a place in texels.
    fn towards(&self, place: [f64; 2]) -> Vec3 {
        let size = self.size();
        let [x, y] =
            [0, 1].map(|axis: usize| (2.0 * place[axis] / size[axis] - 1.0) * self.halves[axis]);
        (self.to_node.transpose() * DVec3::new(x, -y, -1.0)).normalize().as_vec3()
    }
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
