//! How light is polarized as it leaves its emitter.

use glam::Vec3;

use crate::scattering::Scene;
use crate::scene::emitter::EmitterModel;

use crate::scene::emitted::LampState;

use super::{incandescence, primitive};

impl<const N: usize> Scene<N> {
    /// Whether lamps emit polarized light.
    #[inline(always)]
    pub fn has_polarized_lamps(&self) -> bool {
        self.optics.states.any()
    }

    /// Whether lamps emit by their heat.
    #[inline(always)]
    pub fn has_incandescent_lamps(&self) -> bool {
        self.optics.states.has_incandescent
    }
}

/// Squared sine below which an axis counts as parallel to a direction: about 1e-4 radians.
pub const PARALLEL_SIN2: f32 = 1e-8;

/// A state of polarization of light as it leaves its emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittedState<const N: usize> {
    /// S1, S2 and S3 over S0 at every wavelength, in the frame of `x`.
    pub stokes: [[f32; 3]; N],
    /// The reference axis, perpendicular to the direction of the light; of any length.
    pub x: Vec3,
}

/// The state of the light that an emitter sends from `position` along `direction`; none if it is
/// unpolarized. Not for scenes without polarized lamps ([`Scene::has_polarized_lamps`]).
// Rare, and out of the loops of those who ask.
#[inline(never)]
pub fn emitted_state<const N: usize>(
    scene: &Scene<N>,
    row: usize,
    (position, direction): (Vec3, Vec3),
) -> Option<EmittedState<N>> {
    let emitter = &scene.optics.emitters[row];
    if let EmitterModel::Panorama(panorama) = &emitter.model
        && panorama.is_polarized()
    {
        let (stokes, x) = panorama.state(-direction, &scene.optics.carried)?;
        return Some(EmittedState { stokes, x });
    }
    let (stokes, axes) = match scene.optics.states.of(emitter.lamp)? {
        LampState::Same { stokes, axes } => (*stokes, *axes),
        LampState::Incandescent => {
            let normal = scene.shapes.geometric_normal(primitive(&emitter.model), position);
            return incandescence::state(scene, row, (normal, direction));
        }
    };
    let [axis, other] = axes.unwrap_or_else(|| {
        let surface = scene.shapes.surface_of(primitive(&emitter.model));
        let surface = &scene.shapes.surfaces[surface as usize];
        [surface.axis_x, surface.axis_y]
    });
    let across = |axis: Vec3| axis - direction * axis.dot(direction);
    let x = across(axis);
    let is_sound = x.length_squared() > PARALLEL_SIN2;
    Some(EmittedState { stokes, x: if is_sound { x } else { across(other) } })
}
