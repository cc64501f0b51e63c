//! Light sources as the start of light paths and as what sensor paths meet, with the densities
//! that weigh these against choosing a point of theirs (`direct`).
//!
//! Densities follow Georgiev et al. 2012: `direct` is that of choosing the point (or direction)
//! when connecting, `emission` that of starting a light path there; both include the probability
//! of choosing the emitter. All light starts unpolarized.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::scene::baked::{Bounds, Emitter, EmitterKind, NONE};

use super::Scene;

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample<const N: usize> {
    /// Where it starts.
    pub position: Vec3,
    /// Geometric normal there; zero for emitters without a surface.
    pub normal: Vec3,
    /// Where it goes, unit length.
    pub direction: Vec3,
    /// Emitted radiance over `emission` density, cosine included.
    pub beta: [f32; N],
    /// Radiance along `direction`; per steradian intensity for points.
    pub radiance: [f32; N],
    /// `direct` density, per area or per steradian (infinite emitters).
    pub direct_pdf: f32,
    /// `emission` density.
    pub emission_pdf: f32,
    /// Cosine at the emitter, 1 where it has no surface.
    pub cos_at_light: f32,
    /// At a finite distance.
    pub finite: bool,
    /// Both sides of the surface emit.
    pub two_sided: bool,
    /// Paths cannot meet the emitter by chance.
    pub delta: bool,
    /// Its row in the scene's emitters.
    pub emitter: usize,
}

/// What a sensor path meets.
#[derive(Clone, Copy, Debug)]
pub struct MetEmission<const N: usize> {
    /// Radiance towards the sensor.
    pub radiance: [f32; N],
    /// `direct` density, per area, or per steradian for the environment.
    pub direct_pdf: f32,
    /// `emission` density.
    pub emission_pdf: f32,
    /// Cosine at the emitter, 1 for the environment.
    pub cos_at_light: f32,
}

/// Starts a light path.
pub fn sample_emission<const N: usize>(
    scene: &Scene<N>,
    choice: f32,
    u_position: [f32; 2],
    u_direction: [f32; 2],
) -> EmissionSample<N> {
    let index = scene.choose_emitter(choice);
    let emitter = &scene.optics.emitters[index];
    let sample = match emitter.kind {
        EmitterKind::Triangle | EmitterKind::Sphere => {
            emit_from_area(scene, emitter, u_position, u_direction)
        }
        EmitterKind::Point | EmitterKind::Spot => emit_from_point(emitter, u_direction),
        EmitterKind::Directional => {
            emit_from_infinity(scene, emitter, emitter.direction, 1.0, u_position)
        }
        EmitterKind::Environment => {
            let direction = -sphere_direction(u_direction);
            emit_from_infinity(scene, emitter, direction, SPHERE_PDF, u_position)
        }
    };
    EmissionSample { emitter: index, ..sample }
}

/// What a ray along `direction` sees of the emitter of the primitive it hit ([`NONE`]: nothing);
/// none if that does not emit towards it. `position` is the point hit.
pub fn met_emission<const N: usize>(
    scene: &Scene<N>,
    primitive: u32,
    position: Vec3,
    direction: Vec3,
) -> Option<MetEmission<N>> {
    let index = scene.emitter_seen(primitive);
    if index == NONE {
        return None;
    }
    let emitter = &scene.optics.emitters[index as usize];
    if emitter.kind == EmitterKind::Environment {
        return Some(MetEmission {
            radiance: emitter.radiance,
            direct_pdf: emitter.probability * SPHERE_PDF,
            emission_pdf: emitter.probability * SPHERE_PDF * disk_pdf(&scene.shapes.bounds),
            cos_at_light: 1.0,
        });
    }
    let cosine = -direction.dot(scene.shapes.geometric_normal(primitive, position));
    let cos_at_light = facing(emitter, cosine)?;
    Some(MetEmission {
        radiance: emitter.radiance,
        direct_pdf: emitter.probability / emitter.area,
        emission_pdf: area_emission_pdf(emitter, cos_at_light),
        cos_at_light,
    })
}

/// Density per steradian of a uniform direction.
pub(super) const SPHERE_PDF: f32 = FRAC_1_PI / 4.0;

/// Density per area of a point on the disk through which parallel light enters the scene.
pub(super) fn disk_pdf(bounds: &Bounds) -> f32 {
    let radius = bounds.radius;
    FRAC_1_PI / (radius * radius)
}

fn sphere_direction(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(radius * cosine, radius * sine, z)
}

/// The cosine at which the emitter is seen, if it emits to that side.
fn facing<const N: usize>(emitter: &Emitter<N>, cosine: f32) -> Option<f32> {
    let seen = if emitter.two_sided { cosine.abs() } else { cosine };
    (seen > 0.0).then_some(seen)
}

/// Cosine-weighted emission from a uniform point, from either side if there are two.
fn area_emission_pdf<const N: usize>(emitter: &Emitter<N>, cos_at_light: f32) -> f32 {
    let sides = if emitter.two_sided { 2.0 } else { 1.0 };
    emitter.probability * cos_at_light * FRAC_1_PI / (emitter.area * sides)
}

fn point_on<const N: usize>(scene: &Scene<N>, emitter: &Emitter<N>, u: [f32; 2]) -> (Vec3, Vec3) {
    let primitive = emitter.primitive as usize;
    if emitter.kind == EmitterKind::Sphere {
        let sphere = scene.shapes.spheres[primitive - scene.shapes.triangles.len()];
        let normal = sphere_direction(u);
        return (sphere.center + normal * sphere.radius, normal);
    }
    let [a, b, c] = scene.shapes.triangles[primitive].corners;
    // Heitz 2019, as `math::warp::triangle`.
    let (v, w) =
        if u[0] > u[1] { (u[0] - 0.5 * u[1], 0.5 * u[1]) } else { (0.5 * u[0], u[1] - 0.5 * u[0]) };
    (a + (b - a) * v + (c - a) * w, (b - a).cross(c - a).normalize())
}

/// The share of the axial intensity that a point light sends along `direction`: 1 for a point,
/// for a spot the falloff of KHR_lights_punctual (squared, linear in the cosine).
fn spot_falloff<const N: usize>(emitter: &Emitter<N>, direction: Vec3) -> f32 {
    if emitter.kind == EmitterKind::Point {
        return 1.0;
    }
    let cosine = direction.dot(emitter.direction);
    let ramp = (cosine - emitter.cos_outer) / (emitter.cos_inner - emitter.cos_outer);
    let ramp = ramp.clamp(0.0, 1.0);
    ramp * ramp
}

/// Density per steradian of the direction in which a point light starts a path.
pub(super) fn cone_pdf<const N: usize>(emitter: &Emitter<N>) -> f32 {
    let cos_edge = if emitter.kind == EmitterKind::Point { -1.0 } else { emitter.cos_outer };
    0.5 * FRAC_1_PI / (1.0 - cos_edge)
}

fn emit_from_area<const N: usize>(
    scene: &Scene<N>,
    emitter: &Emitter<N>,
    u_position: [f32; 2],
    mut u_direction: [f32; 2],
) -> EmissionSample<N> {
    let (position, front) = point_on(scene, emitter, u_position);
    let mut normal = front;
    if emitter.two_sided {
        let back = u_direction[0] < 0.5;
        u_direction[0] = u_direction[0] * 2.0 - if back { 0.0 } else { 1.0 };
        normal = if back { -front } else { front };
    }
    let radius = u_direction[0].sqrt();
    let (sine, cosine) = (2.0 * PI * u_direction[1]).sin_cos();
    // Kept off the horizon, where the densities vanish.
    let cos_at_light = (1.0 - u_direction[0]).sqrt().max(1e-6);
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let direction =
        tangent * (radius * cosine) + bitangent * (radius * sine) + normal * cos_at_light;
    let emission_pdf = area_emission_pdf(emitter, cos_at_light);
    EmissionSample {
        position,
        normal: front,
        direction,
        beta: emitter.radiance.map(|radiance| radiance * cos_at_light / emission_pdf),
        radiance: emitter.radiance,
        direct_pdf: emitter.probability / emitter.area,
        emission_pdf,
        cos_at_light,
        finite: true,
        two_sided: emitter.two_sided,
        delta: false,
        emitter: 0,
    }
}

fn emit_from_point<const N: usize>(emitter: &Emitter<N>, u: [f32; 2]) -> EmissionSample<N> {
    let pdf = cone_pdf(emitter);
    let spread = 0.5 * FRAC_1_PI / pdf;
    let z = 1.0 - u[0] * spread;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
    let axis = if emitter.kind == EmitterKind::Point { Vec3::Z } else { emitter.direction };
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    let direction = tangent * (radius * cosine) + bitangent * (radius * sine) + axis * z;
    let falloff = spot_falloff(emitter, direction);
    let emission_pdf = emitter.probability * pdf;
    EmissionSample {
        position: emitter.position,
        normal: Vec3::ZERO,
        direction,
        beta: emitter.radiance.map(|intensity| intensity * falloff / emission_pdf),
        radiance: emitter.radiance.map(|intensity| intensity * falloff),
        direct_pdf: emitter.probability,
        emission_pdf,
        cos_at_light: 1.0,
        finite: true,
        two_sided: false,
        delta: true,
        emitter: 0,
    }
}

fn emit_from_infinity<const N: usize>(
    scene: &Scene<N>,
    emitter: &Emitter<N>,
    direction: Vec3,
    direction_pdf: f32,
    u: [f32; 2],
) -> EmissionSample<N> {
    let bounds = scene.shapes.bounds;
    let radius = bounds.radius * u[0].sqrt();
    let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
    let (tangent, bitangent) = direction.any_orthonormal_pair();
    let on_disk = tangent * (radius * cosine) + bitangent * (radius * sine);
    let direct_pdf = emitter.probability * direction_pdf;
    let emission_pdf = direct_pdf * disk_pdf(&scene.shapes.bounds);
    EmissionSample {
        position: bounds.center + on_disk - direction * bounds.radius,
        normal: Vec3::ZERO,
        direction,
        beta: emitter.radiance.map(|radiance| radiance / emission_pdf),
        radiance: emitter.radiance,
        direct_pdf,
        emission_pdf,
        cos_at_light: 1.0,
        finite: false,
        two_sided: false,
        delta: emitter.kind == EmitterKind::Directional,
        emitter: 0,
    }
}
