//! The kernels that leave light one way only (or two): smooth conductors and dielectrics,
//! polarizers and retarders. Eight rows at a time, for either side of the transport.

use crate::math::{F32s, Vector};
use crate::polarization::fresnel;
use crate::scene::baked::{Material, MaterialKind};

/// The probability with which roulette lets a path go on from a material: what it scatters at
/// most (polarizers: of unpolarized light; conductors: at normal incidence), so that it looks at
/// neither the path's throughput nor its polarization.
pub fn survival<const N: usize>(material: &Material<N>) -> f32 {
    let strongest = |values: [f32; N]| values.into_iter().fold(0.0, f32::max);
    let scattered = match material.kind {
        MaterialKind::Absorber => 0.0,
        MaterialKind::Diffuse => strongest(material.reflectance),
        MaterialKind::Conductor => strongest(std::array::from_fn(|channel| {
            fresnel::conductor_reflectance(1.0, material.eta[channel], material.k[channel])
        })),
        MaterialKind::Polarizer => material.m00,
        MaterialKind::Dielectric | MaterialKind::Retarder | MaterialKind::Null => 1.0,
    };
    scattered.clamp(0.05, 1.0)
}

/// The mirrored direction of `direction` at `normal`.
#[inline(always)]
pub fn reflect(direction: Vector<F32s>, normal: Vector<F32s>) -> Vector<F32s> {
    normal.mul_add(direction.dot(normal) * F32s::splat(-2.0), direction)
}

/// The refracted direction of `direction` at `normal`, which points against it, for the cosines
/// of incidence and refraction and `eta`, the index behind over the index before.
#[inline(always)]
pub fn refract(
    direction: Vector<F32s>,
    normal: Vector<F32s>,
    cos_i: F32s,
    cos_t: F32s,
    eta: F32s,
) -> Vector<F32s> {
    let inverse = F32s::splat(1.0) / eta;
    (direction * inverse + normal * (cos_i * inverse - cos_t)).normalize()
}

/// `normal` turned against `direction`.
#[inline(always)]
pub fn against(normal: Vector<F32s>, direction: Vector<F32s>) -> Vector<F32s> {
    Vector::select(direction.dot(normal).simd_gt(F32s::splat(0.0)), -normal, normal)
}
