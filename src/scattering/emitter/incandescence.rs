//! What comes out of hot surfaces (Kirchhoff): of a black body's light what they do not reflect,
//! polarized by Fresnel's equations in the plane of its direction and the normal.

use glam::Vec3;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::fresnel::{conductor, dielectric};
use crate::scattering::Scene;
use crate::scene::emitted::LampState;
use crate::scene::world::SurfaceModel;

use super::primitive;
use super::state::{EmittedState, PARALLEL_SIN2};

/// What of a black body's light leaves a surface at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exit {
    /// The share: the mean of those of s and p.
    emissivity: f32,
    /// S1 over S0, about the s axis.
    s1: f32,
}

impl Exit {
    /// Of metal of an index, at the cosine of the exit.
    fn of_conductor(cosine: f32, eta: f32, k: f32) -> Self {
        let (reflectance, block) = conductor(cosine, eta, k);
        let emissivity = 1.0 - reflectance;
        // Nothing leaves along the surface, and no state of it.
        let s1 = if emissivity > 0.0 { -reflectance * block.a / emissivity } else { 0.0 };
        Self { emissivity, s1: s1.clamp(-1.0, 1.0) }
    }

    /// Of a dielectric whose index is `eta` times that outside.
    fn of_dielectric(cosine: f32, eta: f32) -> Self {
        let face = dielectric(cosine, eta);
        Self { emissivity: face.transmittance, s1: face.transmission.a }
    }
}

/// What leaves an emitter at the cosine `cosine` to the normal of its front, below zero on the
/// back; none if it is not incandescent.
#[inline(never)]
fn exits<const N: usize>(scene: &Scene<N>, row: usize, cosine: f32) -> Option<[Exit; N]> {
    let emitter = &scene.optics.emitters[row];
    if scene.optics.states.of(emitter.lamp) != Some(&LampState::Incandescent) {
        return None;
    }
    let surface = scene.shapes.surface_of(primitive(&emitter.model));
    let material = scene.shapes.surfaces[surface as usize].material;
    let model = &scene.optics.materials[material as usize].model;
    let of_glass = |ior: f32, exterior_ior: f32| {
        let eta = if cosine < 0.0 { exterior_ior / ior } else { ior / exterior_ior };
        Exit::of_dielectric(cosine.abs(), eta)
    };
    let mut exits = [Exit { emissivity: 1.0, s1: 0.0 }; N];
    for (n, exit) in exits.iter_mut().enumerate() {
        if let SurfaceModel::Conductor { eta, k } = model {
            *exit = Exit::of_conductor(cosine.abs(), eta[n], k[n]);
        } else if let SurfaceModel::Dielectric { ior, exterior_ior } = model {
            *exit = of_glass(*ior, *exterior_ior);
        } else if let SurfaceModel::DispersiveDielectric { ior, exterior_ior } = model {
            *exit = of_glass(ior[n], exterior_ior[n]);
        }
    }
    Some(exits)
}

/// The state of what an incandescent emitter sends along `direction` from a place with this normal.
pub fn state<const N: usize>(
    scene: &Scene<N>,
    row: usize,
    (normal, direction): (Vec3, Vec3),
) -> Option<EmittedState<N>> {
    let exits = exits(scene, row, direction.dot(normal))?;
    let s_axis = normal.cross(direction);
    // Where it vanishes, so does S1.
    let is_sound = s_axis.length_squared() > PARALLEL_SIN2;
    let x = if is_sound { s_axis } else { direction.any_orthogonal_vector() };
    Some(EmittedState { stokes: exits.map(|exit| [exit.s1, 0.0, 0.0]), x })
}

impl<const N: usize> Scene<N> {
    /// The share of what a lamp would emit if it were black that leaves along `direction`, from a
    /// place with this normal to the front. Not for scenes without incandescent lamps.
    pub fn emissivity(&self, row: usize, normal: Vec3, direction: Vec3) -> [f32; N] {
        match exits(self, row, direction.dot(normal)) {
            Some(exits) => exits.map(|exit| exit.emissivity),
            None => [1.0; N],
        }
    }

    /// Multiplies what arrives from eight emitters against `towards` by those shares.
    #[cold]
    pub fn weigh_exits(
        &self,
        radiance: &mut [F32s; N],
        emitters: [usize; LANES],
        (normals, towards): (Vector<F32s>, Vector<F32s>),
    ) {
        let (normals, towards) = (normals.to_rows(), towards.to_rows());
        let mut shares = [[1.0; N]; LANES];
        for (lane, share) in shares.iter_mut().enumerate() {
            let direction = -Vec3::from(towards[lane]);
            *share = self.emissivity(emitters[lane], normals[lane].into(), direction);
        }
        for (n, radiance) in radiance.iter_mut().enumerate() {
            *radiance *= F32s::from(lanes::each(|lane| shares[lane][n]));
        }
    }
}
