//! Finds what textures say of the surfaces that paths have met.

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::scattering::painting::{PaintedModels, paint};
use crate::scattering::{Scene, Side};

/// Gives every row on a painted surface a row of its own in the table of its model, and its shading
/// normal. Vertices of light paths may be kept, and with them their rows; those of sensor paths are
/// forgotten when the next have been met.
///
/// From: resolve_surfaces. To: weigh_arrival.
/// Writes: surfaces, models. Reads: hits, scene.
pub fn paint_surfaces<const N: usize>(
    surfaces: &mut SurfaceColumns,
    models: &mut PaintedModels<N>,
    hits: &HitColumns,
    scene: &Scene<N>,
    (side, count): (Side, usize),
) {
    if scene.is_painted() {
        paint(surfaces, models, hits, (0..count, side == Side::Light), scene);
    }
}
