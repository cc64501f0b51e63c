//! Cloth: threads that stand off the surface, which scatter light most where they are seen along
//! it. It depolarizes: light has been about several threads of all directions.
//!
//! The normals of threads are distributed by a power of the sine to the normal of the surface
//! (Estevez and Kulla 2017, "Production friendly microfacet sheen BRDF"), and how they hide each
//! other is left to what keeps the whole bounded (Ashikhmin and Premoze 2007, "Distribution-based
//! BRDFs"), as glTF's KHR_materials_sheen has it:
//!
//! ```text
//! f = (2 + 1 / a) sin(h)^(1 / a) / (2 pi) / (4 (cos i + cos o - cos i cos o))
//! ```

use std::f32::consts::PI;

use crate::math::{F32s, Vector};

/// The least roughness that is computed with: threads of less stand straight up.
pub const ALPHA_MIN: f32 = 0.05;
/// Keeps logarithms and denominators off zero.
const TINY: f32 = 1e-12;

/// What white threads scatter per steradian between two directions away from a surface of the unit
/// `normal`; zero where they are not both above it. The same for both orders of the two.
#[inline(always)]
pub fn cloth(alpha: F32s, normal: Vector<F32s>, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let steep = one / alpha.fast_max(F32s::splat(ALPHA_MIN));
    let [cos_given, cos_drawn] = [given, drawn].map(|v| v.dot(normal));
    let sum = given + drawn;
    let length2 = sum.length_squared().fast_max(F32s::splat(TINY));
    let sin2 = (normal.cross(sum).length_squared() / length2).fast_max(F32s::splat(TINY));
    let power = (sin2.ln() * steep * F32s::splat(0.5)).exp();
    let threads = (steep + F32s::splat(2.0)) * power * F32s::splat(1.0 / (2.0 * PI));
    let seen = F32s::splat(4.0) * (cos_given + cos_drawn - cos_given * cos_drawn);
    let above = cos_given.simd_gt(zero) & cos_drawn.simd_gt(zero);
    above & (threads / seen.fast_max(F32s::splat(TINY)))
}
