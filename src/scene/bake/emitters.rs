//! Everything that emits, and how likely it is to start a path.

use glam::{DAffine3, DVec3, Vec3};

use super::beside::Passable;
use super::{Materials, outside_table};
use crate::math::elementary::cos;
use crate::scene::baked::{Material, NONE, Shapes};
use crate::scene::emitter::{self, Emitter, EmitterModel};
use crate::scene::error::SceneError;
use crate::scene::world::{
    Environment, Name, Punctual, PunctualKind, SurfaceModel, Transform, World,
};
use crate::spectrum::{Asked, Role};

/// Least difference of the cosines of a spot's two cones: as the glTF extension's formula has it.
const LEAST_CONE: f32 = 1e-3;

/// The table of emitters: see `Optics`.
pub struct Emitters<const N: usize> {
    pub rows: Vec<Emitter<N>>,
    pub emitter_of_primitive: Vec<u32>,
    pub environment: u32,
    /// Power of each row in W, averaged over the channels.
    powers: Vec<f64>,
}

/// Positions about `origin` of the lights without extent that have one.
pub fn positions(world: &World, origin: DVec3) -> Vec<Vec3> {
    let positions =
        world.in_order::<(&Transform, &Punctual), _>(|(place, light)| match light.kind {
            PunctualKind::Point | PunctualKind::Spot { .. } => {
                Some(place.about(origin).translation.as_vec3())
            }
            PunctualKind::Directional => None,
        });
    positions.into_iter().flatten().collect()
}

/// Primitives first, in their order, then punctual lights, then the environment. Rows without
/// power are left out, so every probability is greater than zero.
pub fn emitters<const N: usize>(
    world: &World,
    asked: Asked,
    materials: &Materials<N>,
    shapes: &Shapes,
) -> Result<Emitters<N>, SceneError> {
    let mut table = Emitters {
        rows: Vec::new(),
        emitter_of_primitive: Vec::new(),
        environment: NONE,
        powers: Vec::new(),
    };
    table.add_primitives(materials, shapes);
    let passable = Passable::at(&positions(world, shapes.origin), shapes);
    let lights = world.in_order::<(&Name, &Transform, &Punctual), _>(|(name, place, light)| {
        let intensity = light.intensity.sample(asked, Role::Emission);
        intensity
            .map(|intensity| {
                (punctual(light.kind, &place.about(shapes.origin), &passable), intensity)
            })
            .map_err(|error| outside_table(&name.0, error))
    });
    for light in lights {
        let (model, intensity) = light?;
        table.add(shapes, model, intensity);
    }
    let skies = world.in_order::<(&Name, &Environment), _>(|(name, sky)| {
        let radiance = sky.radiance.sample(asked, Role::Emission);
        radiance.map_err(|error| outside_table(&name.0, error))
    });
    for sky in skies {
        table.environment = table.add(shapes, emitter::Environment, sky?);
    }
    table.set_probabilities()?;
    Ok(table)
}

fn punctual(kind: PunctualKind, place: &DAffine3, passable: &Passable) -> EmitterModel {
    let position = || passable.before(place.translation.as_vec3());
    let direction = (-place.matrix3.z_axis.normalize()).as_vec3();
    match kind {
        PunctualKind::Point => emitter::Point { position: position() }.into(),
        PunctualKind::Directional => emitter::Directional { direction }.into(),
        PunctualKind::Spot { inner, outer } => {
            let cos_inner = cos(inner) as f32;
            let cos_outer = (cos(outer) as f32).min(cos_inner - LEAST_CONE);
            let position = position();
            emitter::Spot { position, direction, cos_inner, cos_outer }.into()
        }
    }
}

impl<const N: usize> Emitters<N> {
    /// Appends a row unless it is black; its index, or [`NONE`].
    fn add(&mut self, shapes: &Shapes, model: impl Into<EmitterModel>, radiance: [f32; N]) -> u32 {
        let model = model.into();
        let mean = radiance.iter().copied().map(f64::from).sum::<f64>() / N as f64;
        let power = mean * model.size(shapes);
        if power <= 0.0 {
            return NONE;
        }
        self.powers.push(power);
        self.rows.push(Emitter { model, radiance, probability: 0.0 });
        (self.rows.len() - 1) as u32
    }

    fn add_primitives(&mut self, materials: &Materials<N>, shapes: &Shapes) {
        for (primitive, &surface) in (0..).zip(&shapes.surface_of_primitive) {
            let material = shapes.surfaces[surface as usize].material as usize;
            let radiance = materials.radiance[material];
            let emitter = if radiance == [0.0; N] {
                NONE
            } else if (primitive as usize) < shapes.triangles.len() {
                let two_sided = materials.rows[material].two_sided;
                self.add(shapes, emitter::Triangle::new(shapes, primitive, two_sided), radiance)
            } else {
                let Material { ref model, two_sided } = materials.rows[material];
                let is_opaque = shapes.surfaces[surface as usize].is_opaque;
                let refracts = matches!(model, SurfaceModel::Dielectric { .. });
                let sides = [two_sided, !is_opaque && !refracts];
                self.add(shapes, emitter::Sphere::new(shapes, primitive, sides), radiance)
            };
            self.emitter_of_primitive.push(emitter);
        }
    }

    fn set_probabilities(&mut self) -> Result<(), SceneError> {
        let total: f64 = self.powers.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            let problem = if total > 0.0 {
                "the lights are too bright to add up"
            } else {
                "nothing in the scene emits light at the wavelengths of the render"
            };
            let remedy = "add a light, an emissive material or an environment";
            return Err(SceneError::new("lights", problem, remedy));
        }
        for (row, power) in self.rows.iter_mut().zip(&self.powers) {
            row.probability = (power / total) as f32;
        }
        Ok(())
    }
}
