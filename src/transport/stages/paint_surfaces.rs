//! Finds what textures, and other glass, say of the surfaces that paths have met.

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::scattering::painting::{PaintedModels, paint};
use crate::scattering::{Scene, Side};
use crate::transport::tables::paths::AnyPaths;

/// Gives every row on a painted surface a row of its own in the table of its model, and its shading
/// normal; so too on rough glass that touches other glass. Vertices of light paths may be kept, and
/// with them their rows; those of sensor paths are forgotten when the next have been met.
///
/// From: resolve_surfaces. To: weigh_arrival.
/// Writes: surfaces, models. Reads: hits, paths (rays, nested), scene.
pub fn paint_surfaces<const N: usize>(
    surfaces: &mut SurfaceColumns,
    models: &mut PaintedModels<N>,
    (hits, paths): (&HitColumns, &AnyPaths<N>),
    scene: &Scene<N>,
    side: Side,
) {
    if scene.has_models_by_place {
        let by = (hits, (&paths.rays, paths.nested.inside.as_slice()));
        paint(surfaces, models, by, (0..paths.len, side == Side::Light), scene);
    }
}
