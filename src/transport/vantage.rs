//! Vertices as those see them who choose emitters there.

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::emitter::tree::Vantage;
use crate::scene::baked::NONE;

/// The normals at eight vertices that have been reached along `direction`, on the side that light
/// comes from; zero where that may be any.
#[inline(always)]
pub fn towards<const N: usize>(
    surfaces: &SurfaceColumns,
    direction: Vector<F32s>,
    scene: &Scene<N>,
    row: usize,
) -> Vector<F32s> {
    let normal = Vector::load(&surfaces.geometric_normal, row);
    let behind = normal.dot(direction).simd_gt(F32s::splat(0.0));
    let normal = Vector::select(behind, -normal, normal);
    match scene.passes_any_way {
        true => one_sided(normal, surfaces, scene, row),
        false => normal,
    }
}

/// Those of surfaces that no light goes through.
#[cold]
fn one_sided<const N: usize>(
    normal: Vector<F32s>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    row: usize,
) -> Vector<F32s> {
    let is_one_sided = |lane: usize| {
        let primitive = surfaces.primitive.get(row + lane).copied().unwrap_or(NONE);
        scene.is_closed(primitive)
    };
    let mask = lanes::mask_of(lanes::each(is_one_sided));
    Vector::new(mask & normal.x, mask & normal.y, mask & normal.z)
}

/// Eight vertices that have been reached along `direction`.
#[inline(always)]
pub fn vantages<const N: usize>(
    surfaces: &SurfaceColumns,
    direction: Vector<F32s>,
    scene: &Scene<N>,
    row: usize,
) -> [Vantage; LANES] {
    let normal = towards(surfaces, direction, scene, row).to_rows();
    let position = Vector::load(&surfaces.position, row).to_rows();
    std::array::from_fn(|lane| Vantage {
        position: position[lane].into(),
        normal: normal[lane].into(),
    })
}
