//! Pictures of all directions: what light comes from where at infinity.
//!
//! They are equirectangular. In their own space the middle shows +x, right of that lies +z, and the
//! upper edge is +y, as in Blender (with its axes exchanged as glTF has them) and three.js. Between
//! the middles of texels values are interpolated linearly, around the picture too; beyond the
//! uppermost and lowest ones they are those of the edge.
//!
//! Directions are drawn by the picture ([`Directions`]): per steradian nearly in proportion to what
//! is seen, and zero only where that is.

mod directions;
mod places;

pub use directions::{Directions, brightness};

use std::sync::Arc;

use glam::{Mat3, Vec3};

use super::painting::columns;
use super::world::Picture;
use crate::image::texels::Coding;
use crate::math::{F32s, LANES, Vector};
use crate::spectrum::{Carried, Role, Shapes, lit};

use places::{Places, across};

/// Integers are encoded as sRGB, as in all pictures of this kind.
const CODING: Coding = Coding::Srgb;

/// A picture, and how it lies on the sphere of directions.
#[derive(Clone, Debug)]
pub struct Panorama {
    picture: Arc<Picture>,
    /// What linear red, green and blue are multiplied by.
    factor: [f32; 3],
    /// From the world's space to that of the picture: a rotation.
    turn: Mat3,
    /// The spectra of its texels, row by row, with the factor.
    spectra: Arc<Shapes>,
}

impl PartialEq for Panorama {
    /// Pictures are the same if they are one.
    fn eq(&self, other: &Self) -> bool {
        let Self { picture, factor, turn, spectra: _ } = self;
        Arc::ptr_eq(picture, &other.picture) && (factor, turn) == (&other.factor, &other.turn)
    }
}

impl Panorama {
    /// A picture with a factor, turned by a rotation from its own space to the world's.
    pub fn new(picture: Arc<Picture>, factor: [f32; 3], to_world: Mat3) -> Self {
        let [width, height] = picture.texels().size().map(|it| it as usize);
        let spectra = Arc::new(Shapes::new(width * height));
        Self { picture, factor, turn: to_world.transpose(), spectra }
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

    /// What comes from a direction, in the columns of a render, and the density per steradian with
    /// which it is drawn.
    // Once for each number of columns, and not where it is asked for.
    #[inline(never)]
    pub fn seen<const N: usize>(&self, direction: Vec3, carried: &Carried<N>) -> ([f32; N], f32) {
        let (places, own) = self.places_of(direction);
        let radiance = places.mixed(0, |column, row| self.texel(column, row, carried));
        let directions = self.picture.directions();
        (lit(radiance, carried), directions.density_of(&places, 0, across(own).to_array()[0]))
    }

    /// What comes from a direction, in the columns of a render.
    pub fn radiance<const N: usize>(&self, direction: Vec3, carried: &Carried<N>) -> [f32; N] {
        self.seen(direction, carried).0
    }

    /// What comes from eight directions.
    // Once for each number of columns, and not where it is asked for.
    #[inline(never)]
    pub fn radiances<const N: usize>(
        &self,
        directions: Vector<F32s>,
        carried: &Carried<N>,
    ) -> [F32s; N] {
        let places = Places::of(turned(&self.turn, directions), self.size());
        if !carried.is_rgb() {
            // What one waits for from memory, the others do at once.
            let numbers = (0..LANES).flat_map(|lane| {
                let ((rows, _), ([column, _], _)) = (places.rows(lane), places.columns(lane));
                rows.map(|row| self.number(column, row))
            });
            self.spectra.prefetch(carried.white(), numbers);
        }
        let mut lanes = [[0.0; LANES]; N];
        for lane in 0..LANES {
            let values = places.mixed(lane, |column, row| self.texel(column, row, carried));
            lanes.iter_mut().zip(values).for_each(|(lanes, value)| lanes[lane] = value);
        }
        let white = lit([1.0; N], carried);
        std::array::from_fn(|n| F32s::from(lanes[n]) * F32s::splat(white[n]))
    }

    /// Columns and rows.
    fn size(&self) -> [usize; 2] {
        self.picture.texels().size().map(|it| it as usize)
    }

    /// The number of a texel.
    #[inline(always)]
    fn number(&self, column: usize, row: usize) -> usize {
        self.picture.texels().size()[0] as usize * row + column
    }

    /// Where a direction of unit length is in the picture, in all lanes, and the direction there.
    fn places_of(&self, direction: Vec3) -> (Places, Vector<F32s>) {
        let own = Vector::splat((self.turn * direction).to_array());
        (Places::of(own, self.size()), own)
    }

    /// What a texel says in the columns of a render, but for the white.
    #[inline(always)]
    fn texel<const N: usize>(&self, column: usize, row: usize, carried: &Carried<N>) -> [f32; N] {
        let texels = self.picture.texels();
        let rgb = || {
            let texel = texels.at(column as u32, row as u32, CODING);
            std::array::from_fn(|n| self.factor[n] * texel[n])
        };
        if carried.is_rgb() {
            return columns(rgb(), Some(Role::Coefficient), carried);
        }
        self.spectra.values(
            self.number(column, row),
            (carried.white(), carried.wavelengths_nm()),
            rgb,
        )
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
        let (places, own) = self.places_of(direction);
        let (mut states, mut sums) = ([[0.0; 3]; N], [0.0; N]);
        for ([column, row], share) in places.corners(0) {
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
        let [own, ..] = own.to_rows().map(Vec3::from);
        let right = Vec3::new(-own.z, 0.0, own.x).try_normalize().unwrap_or(Vec3::Z);
        Some((states, self.turn.transpose() * right))
    }

    /// The directions, to where the light comes from, that eight pairs of numbers in [0, 1) draw,
    /// and their densities per steradian: greater than zero.
    pub fn draw_lanes(&self, u: [F32s; 2]) -> (Vector<F32s>, F32s) {
        let directions = self.picture.directions();
        let places = directions.draw(u);
        let (own, sines) = places.directions();
        let direction = turned(&self.turn.transpose(), own);
        let length = direction.dot(direction).sqrt();
        let direction =
            Vector::new(direction.x / length, direction.y / length, direction.z / length);
        (direction, directions.density(&places, sines))
    }

    /// That of one pair.
    pub fn draw(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (direction, density) = self.draw_lanes(u.map(F32s::splat));
        (Vec3::from(direction.to_rows()[0]), density.to_array()[0])
    }

    /// The density with which a direction of unit length is drawn, per steradian.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let (places, own) = self.places_of(direction);
        self.picture.directions().density_of(&places, 0, across(own).to_array()[0])
    }
}

/// Eight directions in another space.
#[inline(always)]
fn turned(turn: &Mat3, v: Vector<F32s>) -> Vector<F32s> {
    let rows = turn.to_cols_array_2d();
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let along = |column: usize| F32s::splat(rows[column][axis]);
        v.x * along(0) + v.y * along(1) + v.z * along(2)
    });
    Vector::new(x, y, z)
}
