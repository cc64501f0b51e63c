//! Vertices as those see them who choose emitters there.

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector};
use crate::scattering::emitter::tree::Vantage;

/// The normal on the side of the direction `given`; zero where there is none.
#[inline(always)]
pub fn towards(normal: Vector<F32s>, given: Vector<F32s>) -> Vector<F32s> {
    let behind = normal.dot(given).simd_lt(F32s::splat(0.0));
    Vector::select(behind, -normal, normal)
}

/// Eight vertices that have been reached along `direction`.
#[inline(always)]
pub fn vantages(
    surfaces: &SurfaceColumns,
    direction: Vector<F32s>,
    row: usize,
) -> [Vantage; LANES] {
    let normal = towards(Vector::load(&surfaces.geometric_normal, row), -direction).to_rows();
    let position = Vector::load(&surfaces.position, row).to_rows();
    std::array::from_fn(|lane| Vantage {
        position: position[lane].into(),
        normal: normal[lane].into(),
    })
}
