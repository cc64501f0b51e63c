//! Vertices that can be connected to, eight at a time: diffuse surfaces and media alike.

use crate::math::{F32s, Vector, warp};

use super::diffuse::Facing;
use super::medium::{Medium, half_sine2};

/// Eight vertices of sensor paths that have met the same kind of event.
#[expect(clippy::large_enum_variant, reason = "it lives on the stack of one loop")]
pub enum VertexLanes<'a, const N: usize> {
    /// On Lambertian surfaces.
    Surface {
        /// Their normals.
        facing: Facing,
        /// Their BRDF, per steradian.
        brdf: [F32s; N],
    },
    /// In a medium.
    Volume(&'a Medium<N>),
}

/// What a vertex does to light between two directions.
#[derive(Clone, Copy)]
pub struct Turn<const N: usize> {
    /// Scattering function, times the cosine on a surface; zero where no light can pass.
    pub value: [F32s; N],
    /// Density per steradian of drawing the direction, averaged over the wavelengths.
    pub pdf: F32s,
    /// Density per steradian of drawing the given direction from the drawn one.
    pub pdf_reverse: F32s,
    /// What turns a density per steradian and inverse square of distance into one at the vertex,
    /// as far as strategies are weighed: the cosine, or the density of the medium. It stands for
    /// itself in all strategies, so that transmittance need not be known (any weights do that add
    /// up to one over the strategies of a path).
    pub measure: F32s,
}

impl<const N: usize> VertexLanes<'_, N> {
    /// The turn between the directions `given`, to where the path comes from, and `drawn`, both
    /// away from the vertex.
    #[inline(always)]
    pub fn turn(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N> {
        match self {
            Self::Surface { facing, brdf } => {
                let cosine = drawn.dot(facing.shading).abs();
                let reflects = facing.reflects(given, drawn);
                let mut value = *brdf;
                value.iter_mut().for_each(|value| *value = reflects & (*value * cosine));
                Turn {
                    value,
                    pdf: warp::cosine_pdf(cosine),
                    pdf_reverse: warp::cosine_pdf(given.dot(facing.shading).abs()),
                    measure: drawn.dot(facing.geometric).abs(),
                }
            }
            Self::Volume(medium) => {
                let value = medium.phase.values(half_sine2(-given, drawn));
                let pdf = mean(&value);
                Turn { value, pdf, pdf_reverse: pdf, measure: F32s::splat(medium.density) }
            }
        }
    }
}

/// The mean over the wavelengths.
#[inline(always)]
pub fn mean<const N: usize>(values: &[F32s; N]) -> F32s {
    let mut sum = values[0];
    for &value in &values[1..] {
        sum += value;
    }
    if N == 1 { sum } else { sum * F32s::splat(1.0 / N as f32) }
}
