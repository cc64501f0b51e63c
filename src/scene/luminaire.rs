//! Luminaires ready to be looked up and drawn from: what a point emits by direction.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Vec3};

use super::pattern::turn_of;
use super::world::Photometry;
use crate::math::elementary::{acos, atan2, cos, sin};

/// Cells of equal angles from the axis, and about it, that directions are drawn from.
const CELLS: [usize; 2] = [256, 64];
/// Places along either edge of a cell at which it is looked up.
const PLACES: usize = 3;
/// Share of directions that are drawn evenly: none is out of reach that a cell knows nothing of.
const EVENLY: f64 = 0.05;

/// A luminaire in its place, over its mean.
#[derive(Clone, Debug)]
pub struct Luminaire {
    photometry: Photometry,
    /// From the world to the node: its axis is -z, and the plane from which horizontal angles turn
    /// goes through x.
    to_node: DMat3,
    mean: f64,
    /// How likely a cell or one before is drawn, all around for every vertical angle.
    chances: Vec<f64>,
}

impl Luminaire {
    /// In a place whose axes are those of the columns.
    pub fn new(photometry: &Photometry, axes: DMat3) -> Self {
        let mut luminaire = Self {
            photometry: photometry.clone(),
            to_node: turn_of(axes).transpose(),
            mean: photometry.mean(),
            chances: Vec::new(),
        };
        let [rows, columns] = CELLS;
        let mut sum = 0.0;
        for cell in 0..rows * columns {
            sum += luminaire.power_of(cell);
            luminaire.chances.push(sum);
        }
        luminaire.chances.iter_mut().for_each(|chance| *chance /= sum);
        luminaire
    }

    /// The mean intensity over all directions, which others are relative to.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// What a cell emits, about.
    fn power_of(&self, cell: usize) -> f64 {
        let [vertical, horizontal] = Self::edges(cell);
        let inside = |[from, to]: [f64; 2], place: usize| {
            from + (to - from) * (place as f64 + 0.5) / PLACES as f64
        };
        let mut sum = 0.0;
        for place in 0..PLACES * PLACES {
            let (v, h) = (inside(vertical, place / PLACES), inside(horizontal, place % PLACES));
            sum += self.photometry.at(v.to_degrees(), h.to_degrees());
        }
        sum * Self::solid_angle(cell)
    }

    /// The vertical and the horizontal angles at the edges of a cell, in radians.
    fn edges(cell: usize) -> [[f64; 2]; 2] {
        let [rows, columns] = CELLS;
        let (row, column) = ((cell / columns) as f64, (cell % columns) as f64);
        let [v, h] = [PI / rows as f64, TAU / columns as f64];
        [[v * row, v * (row + 1.0)], [h * column, h * (column + 1.0)]]
    }

    fn solid_angle(cell: usize) -> f64 {
        let [[top, bottom], [from, to]] = Self::edges(cell);
        (cos(top) - cos(bottom)) * (to - from)
    }

    /// The angles of a direction from the axis and about it, in radians.
    fn angles(&self, direction: Vec3) -> [f64; 2] {
        let local = self.to_node * direction.as_dvec3();
        [
            acos((-local.z / local.length()).clamp(-1.0, 1.0)),
            atan2(local.y, local.x).rem_euclid(TAU),
        ]
    }

    /// The intensity along a direction of world space, over the mean.
    pub fn share(&self, direction: Vec3) -> f32 {
        let [vertical, horizontal] = self.angles(direction).map(f64::to_degrees);
        (self.photometry.at(vertical, horizontal) / self.mean) as f32
    }

    /// The density per steradian of drawing a direction.
    pub fn density(&self, direction: Vec3) -> f32 {
        let [rows, columns] = CELLS;
        let [vertical, horizontal] = self.angles(direction);
        let row = ((vertical / PI * rows as f64) as usize).min(rows - 1);
        let column = ((horizontal / TAU * columns as f64) as usize).min(columns - 1);
        let cell = row * columns + column;
        let before = if cell == 0 { 0.0 } else { self.chances[cell - 1] };
        let of_cell = (self.chances[cell] - before) / Self::solid_angle(cell);
        (EVENLY / (4.0 * PI) + (1.0 - EVENLY) * of_cell) as f32
    }

    /// Draws a direction by two numbers in [0, 1).
    pub fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (mut u, v) = (f64::from(u), f64::from(v));
        let (cosine, turn) = if u < EVENLY {
            u /= EVENLY;
            (1.0 - 2.0 * u, TAU * v)
        } else {
            u = (u - EVENLY) / (1.0 - EVENLY);
            let cell = self.chances.partition_point(|&chance| chance <= u);
            let cell = cell.min(self.chances.len() - 1);
            let before = if cell == 0 { 0.0 } else { self.chances[cell - 1] };
            // What is left of the number is the place in the cell.
            let place = ((u - before) / (self.chances[cell] - before)).clamp(0.0, 1.0);
            let [[top, bottom], [from, to]] = Self::edges(cell);
            let cosine = cos(top) + (cos(bottom) - cos(top)) * place;
            (cosine, from + (to - from) * v)
        };
        let radius = (1.0 - cosine * cosine).max(0.0).sqrt();
        let local = DVec3::new(radius * cos(turn), radius * sin(turn), -cosine);
        (self.to_node.transpose() * local).normalize().as_vec3()
    }
}
