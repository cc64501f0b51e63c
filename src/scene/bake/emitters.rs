//! Everything that emits, and how likely it is to start a path.

use std::f64::consts::PI;

use glam::Vec3;

use super::{Materials, outside_table};
use crate::scene::baked::{Emitter, EmitterKind, NONE, Shapes};
use crate::scene::error::SceneError;
use crate::scene::world::{Environment, Name, Punctual, PunctualKind, Transform, World};
use crate::spectrum::Color;

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

/// Positions of the lights without extent that have one.
pub fn positions(world: &World) -> Vec<Vec3> {
    let positions = world.in_order::<(&Transform, &Punctual), _>(|(place, light)| {
        let placed = light.kind != PunctualKind::Directional;
        placed.then(|| place.0.translation.as_vec3())
    });
    positions.into_iter().flatten().collect()
}

/// Primitives first, in their order, then punctual lights, then the environment. Rows without
/// power are left out, so every probability is greater than zero.
pub fn emitters<const N: usize>(
    world: &World,
    color: Color,
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
    let disk = PI * f64::from(shapes.bounds.radius).powi(2);
    let lights = world.in_order::<(&Name, &Transform, &Punctual), _>(|(name, place, light)| {
        let intensity = light.intensity.sample(color);
        intensity
            .map(|intensity| punctual(light.kind, place, intensity, disk))
            .map_err(|error| outside_table(&name.0, error))
    });
    for light in lights {
        let (row, size) = light?;
        table.add(row, size);
    }
    let skies = world.in_order::<(&Name, &Environment), _>(|(name, sky)| {
        let radiance = sky.radiance.sample(color);
        radiance.map_err(|error| outside_table(&name.0, error))
    });
    for sky in skies {
        table.environment = table.add(blank(EmitterKind::Environment, sky?), 4.0 * PI * disk);
    }
    table.set_probabilities()?;
    Ok(table)
}

/// Everything that emits has power equal to its mean radiance, intensity or irradiance times a
/// size in m^2 sr, sr or m^2.
fn punctual<const N: usize>(
    kind: PunctualKind,
    place: &Transform,
    radiance: [f32; N],
    disk: f64,
) -> (Emitter<N>, f64) {
    let direction = -place.0.matrix3.z_axis.normalize();
    let (kind, size, [cos_inner, cos_outer]) = match kind {
        PunctualKind::Point => (EmitterKind::Point, 4.0 * PI, [1.0, 0.0]),
        PunctualKind::Directional => (EmitterKind::Directional, disk, [1.0, 0.0]),
        PunctualKind::Spot { inner, outer } => {
            let cos_inner = inner.cos() as f32;
            let cos_outer = (outer.cos() as f32).min(cos_inner - LEAST_CONE);
            // The falloff is the square of a ramp in the cosine: its mean is a third.
            let ramp = f64::from(cos_inner - cos_outer) / 3.0;
            let size = 2.0 * PI * (f64::from(1.0 - cos_inner) + ramp);
            (EmitterKind::Spot, size, [cos_inner, cos_outer])
        }
    };
    let position = place.0.translation.as_vec3();
    let direction = direction.as_vec3();
    (Emitter { position, direction, cos_inner, cos_outer, ..blank(kind, radiance) }, size)
}

fn blank<const N: usize>(kind: EmitterKind, radiance: [f32; N]) -> Emitter<N> {
    Emitter {
        kind,
        radiance,
        primitive: NONE,
        two_sided: false,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        cos_inner: 1.0,
        cos_outer: 0.0,
        area: 0.0,
        probability: 0.0,
    }
}

impl<const N: usize> Emitters<N> {
    /// Appends a row unless it is black; its index, or [`NONE`].
    fn add(&mut self, row: Emitter<N>, size: f64) -> u32 {
        let mean = row.radiance.iter().copied().map(f64::from).sum::<f64>() / N as f64;
        let power = mean * size;
        if power <= 0.0 {
            return NONE;
        }
        self.powers.push(power);
        self.rows.push(row);
        (self.rows.len() - 1) as u32
    }

    fn add_primitives(&mut self, materials: &Materials<N>, shapes: &Shapes) {
        for (index, &surface) in shapes.surface_of_primitive.iter().enumerate() {
            let material = shapes.surfaces[surface as usize].material as usize;
            let radiance = materials.radiance[material];
            let emitter = if radiance == [0.0; N] {
                NONE
            } else {
                let (kind, area, two_sided) = match shapes.triangles.get(index) {
                    Some(triangle) => {
                        let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
                        let area = 0.5 * (b - a).cross(c - a).length();
                        (EmitterKind::Triangle, area, materials.rows[material].two_sided)
                    }
                    None => {
                        let sphere = &shapes.spheres[index - shapes.triangles.len()];
                        let area = 4.0 * PI * f64::from(sphere.radius).powi(2);
                        (EmitterKind::Sphere, area, false)
                    }
                };
                let sides = if two_sided { 2.0 } else { 1.0 };
                let (primitive, size) = (index as u32, PI * area * sides);
                let area = area as f32;
                self.add(Emitter { primitive, two_sided, area, ..blank(kind, radiance) }, size)
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
