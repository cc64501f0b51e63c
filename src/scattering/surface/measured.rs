//! Measured polarimetric reflectance: a table of Mueller matrices by two directions
//! ([`crate::scene::world::MeasuredTable`]).
//!
//! Light goes the same way forth and back, but measurements of the two differ. What is here is
//! their mean: of the matrix M from i to o, and of the one from o to i with its rows as columns and
//! the y axis turned round, as the reciprocity of Jones matrices has it. So all integrators see the
//! same surface. Matrices that no surface has, by noise, are polarized a little less
//! ([`crate::polarization::physical`]).
//!
//! Directions are drawn by facets (GGX) as rough as the peak of the table is wide, and by the
//! cosine.

use super::facing::Facing;
use super::glossy::{Glossy, Lobes};
use super::model::{Drawn, ModelLanes, Surface};
use super::rough::{Mixture, peak};
use crate::math::elementary::atan2;
use crate::math::{F32s, LANES, Vector};
use crate::polarization::{Dense, Facets, physical, s_axis};
use crate::scattering::event::Form;
use crate::scattering::side::Side;
use crate::scene::world::MeasuredTable;

/// One material.
#[derive(Clone, Debug)]
pub struct Measured<const N: usize> {
    table: MeasuredTable,
    /// The wavelengths among those of the table.
    places: [f32; N],
}

impl<const N: usize> Measured<N> {
    /// By a table, with the wavelengths' places in it.
    pub fn of(table: MeasuredTable, places: [f32; N]) -> Self {
        Self { table, places }
    }

    /// What is reflected from `i` to `o`, both unit vectors away from the surface of the unit
    /// `normal`, over M00, about the axis across the two.
    fn matrices(&self, [normal, i, o]: [Vector<f32>; 3]) -> [[[f32; 4]; 4]; N] {
        let of = |i, o| self.table.at::<16, N>(angles(normal, i, o), &self.places);
        let (there, back) = (of(i, o), of(o, i));
        std::array::from_fn(|n| {
            let element = |r: usize, c: usize| {
                let turned = back[n][4 * c + r];
                let back = if (r == 2) == (c == 2) { turned } else { -turned };
                0.5 * f64::from(there[n][4 * r + c] + back)
            };
            let matrix = std::array::from_fn(|r| std::array::from_fn(|c| element(r, c)));
            physical(matrix).map(|row| row.map(|element| element as f32))
        })
    }

    /// What is reflected of unpolarized light.
    fn values(&self, [normal, i, o]: [Vector<f32>; 3]) -> [f32; N] {
        let of = |i, o| self.table.at::<1, N>(angles(normal, i, o), &self.places);
        let (there, back) = (of(i, o), of(o, i));
        std::array::from_fn(|n| (0.5 * (there[n][0] + back[n][0])).max(0.0))
    }
}

/// phi_d, theta_d and theta_h of light from `i` that leaves along `o`.
fn angles(normal: Vector<f32>, i: Vector<f32>, o: Vector<f32>) -> [f32; 3] {
    let half = (i + o).normalize();
    let across = normal.cross(half);
    let away = across.cross(half);
    let phi_d = atan2(i.dot(across), i.dot(away));
    let theta_d = atan2(half.cross(i).length(), half.dot(i));
    [phi_d, theta_d, atan2(across.length(), normal.dot(half))]
}

impl<const N: usize> Surface for Measured<N> {
    fn scattered(&self) -> f32 {
        self.table.lobe().albedo
    }

    fn peak(&self) -> f32 {
        peak(self.table.lobe().alpha)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct MeasuredLanes<'a, const N: usize> {
    models: [&'a Measured<N>; LANES],
    mixture: Mixture,
}

impl<const N: usize> MeasuredLanes<'_, N> {
    /// Calls `each` with the lanes in which both directions are above the surface, the model and
    /// the normal on the side of `i`, `i` and `o` there.
    fn above(
        &self,
        facing: &Facing,
        [i, o]: [Vector<F32s>; 2],
        mut each: impl FnMut(usize, &Measured<N>, [Vector<f32>; 3]),
    ) {
        let normal = facing.shading_towards(i);
        let [normal, i, o] = [normal, i, o].map(|v| v.to_rows());
        for lane in 0..LANES {
            let way = [normal[lane], i[lane], o[lane]].map(Vector::from);
            let [normal, i, o] = way;
            if i.dot(normal) > 0.0 && o.dot(normal) > 0.0 {
                each(lane, self.models[lane], way);
            }
        }
    }
}

impl<const N: usize> Lobes<N> for MeasuredLanes<'_, N> {
    type Kernel = Dense<F32s>;

    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        _side: Side,
    ) -> [F32s; N] {
        let mut values = [[0.0; LANES]; N];
        self.above(facing, [given, drawn], |lane, model, way| {
            let of_lane = model.values(way);
            values.iter_mut().zip(of_lane).for_each(|(values, value)| values[lane] = value);
        });
        values.map(F32s::from)
    }

    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        self.mixture.pdf(facing.shading_towards(given), given, drawn)
    }

    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let normal = facing.shading_towards(given);
        let (direction, pdf) = self.mixture.draw(normal, given, [u[0], u[1]]);
        let mut weight = self.values(facing, given, direction, side);
        let cos = direction.dot(normal);
        let scale = cos.fast_max(F32s::ZERO) / pdf;
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost: cos.simd_le(F32s::ZERO) }
    }

    fn kernels(
        &self,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>) {
        let mut elements = [[[[0.0; LANES]; 4]; 4]; N];
        self.above(facing, [-k_in, k_out], |lane, model, way| {
            for (elements, matrix) in elements.iter_mut().zip(model.matrices(way)) {
                let m00 = matrix[0][0];
                let scale = if m00 > 0.0 { 1.0 / m00 } else { 0.0 };
                let to = elements.as_flattened_mut().iter_mut();
                for (to, element) in to.zip(matrix.as_flattened()) {
                    to[lane] = scale * element;
                }
            }
        });
        let kernel = |of: [[[f32; LANES]; 4]; 4]| Dense(of.map(|row| row.map(F32s::from)));
        (elements.map(kernel), s_axis(k_out - k_in, k_in))
    }
}

impl<const N: usize> Glossy<N> for Measured<N> {
    type Lanes<'a> = MeasuredLanes<'a, N>;
    const FORM: Form = Form::Dense;

    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> MeasuredLanes<'a, N> {
        let alpha = models.field(|model| model.table.lobe().alpha);
        let chance = models.field(|model| model.table.lobe().share);
        let facets = Facets::new(alpha, F32s::ZERO);
        MeasuredLanes {
            models: models.each(),
            mixture: Mixture { facets, chance, grazing: F32s::ZERO },
        }
    }
}

#[cfg(test)]
mod tests;
