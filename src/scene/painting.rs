//! What textures say at points of primitives, at the wavelengths of a render.

use glam::{Vec2, Vec3, Vec4Swizzles};

use super::baked::LEAST_COSINE;
use super::corners::Painted;
use super::world::{
    Coverage, Paint, Reads, Relief, ReliefFrame, ReliefOf, Stain, SurfaceModel, Taps, Textures,
};
use crate::spectrum::{Carried, Role, Spectrum, lit};

/// The textures of all materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Painting<const N: usize> {
    /// By row in the materials.
    of_material: Vec<Option<Textures>>,
    carried: Carried<N>,
}

impl<const N: usize> Painting<N> {
    /// Those of the materials in their order; nothing if none has any.
    pub fn new(of_material: Vec<Option<Textures>>, carried: &Carried<N>) -> Option<Self> {
        let carried = *carried;
        of_material.iter().any(Option::is_some).then_some(Self { of_material, carried })
    }

    /// The textures of a row in the materials.
    #[inline]
    pub fn of(&self, material: usize) -> Option<&Textures> {
        self.of_material.get(material)?.as_ref()
    }

    /// A model with parameters as they are at a point.
    pub fn model_at(
        &self,
        mut model: SurfaceModel<[f32; N]>,
        textures: &Textures,
        at: (&Painted, [f32; 2]),
    ) -> SurfaceModel<[f32; N]> {
        set_all(&mut model, textures, &|paint, role| self.value(paint, role, at));
        model
    }

    /// A model whose parameters are the means of their paints.
    pub fn mean_model(
        mut model: SurfaceModel<[f32; N]>,
        textures: &Textures,
        carried: &Carried<N>,
    ) -> SurfaceModel<[f32; N]> {
        set_all(&mut model, textures, &|paint, role| columns(paint.mean(), role, carried));
        model
    }

    /// What a material emits at a point.
    pub fn radiance(&self, paint: &Paint, at: (&Painted, [f32; 2])) -> [f32; N] {
        lit(self.value(paint, Some(Role::Coefficient), at), &self.carried)
    }

    /// What the stain of a material leaves of light that is reflected, and of what goes through.
    pub fn stain(&self, stain: &Stain, at: (&Painted, [f32; 2])) -> [[f32; N]; 2] {
        [&stain.reflected, &stain.transmitted].map(|paint| match paint {
            Some(paint) => self.value(paint, Some(Role::Reflectance), at),
            None => [1.0; N],
        })
    }

    /// About the mean of the same over all places.
    pub fn mean_stain(&self, stain: &Stain) -> [[f32; N]; 2] {
        [&stain.reflected, &stain.transmitted].map(|paint| match paint {
            Some(paint) => columns(paint.mean(), Some(Role::Reflectance), &self.carried),
            None => [1.0; N],
        })
    }

    fn value(&self, paint: &Paint, role: Option<Role>, at: (&Painted, [f32; 2])) -> [f32; N] {
        let columns = |rgb| columns(rgb, role, &self.carried);
        let mut value = taps(paint, at).mixed(|texel| columns(paint.color(texel)));
        if paint.by_vertices {
            let [a, b, c] = at.0.colors().map(|color| columns(paint.reads.of(color.to_array())));
            let [u, v] = at.1;
            for (n, value) in value.iter_mut().enumerate() {
                *value *= a[n] + (b[n] - a[n]) * u + (c[n] - a[n]) * v;
            }
        }
        match role {
            // Colors of vertices may be beyond one.
            Some(Role::Reflectance) => value.map(|value| value.clamp(0.0, 1.0)),
            Some(Role::Emission | Role::Coefficient | Role::Index | Role::Waves | Role::Spread)
            | None => value,
        }
    }
}

/// Gives a model, and the parts that it has, the values of paints.
fn set_all<const N: usize>(
    model: &mut SurfaceModel<[f32; N]>,
    textures: &Textures,
    value: &impl Fn(&Paint, Option<Role>) -> [f32; N],
) {
    for (parameter, paint) in &textures.parameters {
        model.set(*parameter, value(paint, parameter.role()));
    }
    if let SurfaceModel::Blend { parts, .. } = model {
        for (part, textures) in parts.iter_mut().zip(&textures.parts) {
            set_all(part, textures, value);
        }
    }
}

/// What red, green and blue stand for in the columns of a render.
#[inline]
pub fn columns<const N: usize>(
    rgb: [f32; 3],
    role: Option<Role>,
    carried: &Carried<N>,
) -> [f32; N] {
    match role {
        // Colors are known wherever the white is, which bake has asked for.
        Some(role) => Spectrum::Rgb(rgb).sample(carried, role).unwrap_or([0.0; N]),
        None => [rgb[0]; N],
    }
}

#[inline]
fn taps(paint: &Paint, (on, weights): (&Painted, [f32; 2])) -> Taps {
    match &paint.texture {
        Some(texture) => texture.taps(on.coordinates(texture.set, weights)),
        None => Taps::WHITE,
    }
}

/// The share of a surface that is there at a point.
#[inline]
pub fn coverage_at(coverage: &Coverage, (on, weights): (&Painted, [f32; 2])) -> f32 {
    let paint = &coverage.paint;
    let [mut alpha] = taps(paint, (on, weights)).mixed(|texel| [paint.color(texel)[0]]);
    if paint.by_vertices {
        let [a, b, c] = on.colors().map(|color| paint.reads.of(color.to_array())[0]);
        let [u, v] = weights;
        alpha *= a + (b - a) * u + (c - a) * v;
    }
    coverage.of(alpha)
}

/// The shading normal at a point where it is `shading` without a relief: of unit length, and to the
/// front of the geometric one.
pub fn normal_at(
    relief: &Relief,
    at: (&Painted, [f32; 2]),
    [shading, geometric]: [Vec3; 2],
) -> Vec3 {
    let own = match relief.of {
        ReliefOf::Normals(frame) => of_normals(relief, frame, at, shading),
        ReliefOf::Heights(reads) => of_heights(relief, reads, at, shading),
    };
    let Some(normal) = own.and_then(Vec3::try_normalize) else { return shading };
    let cosine = normal.dot(geometric);
    if cosine >= LEAST_COSINE {
        return normal;
    }
    (normal + geometric * (LEAST_COSINE - cosine)).try_normalize().unwrap_or(shading)
}

/// What a picture of normals says, of any length.
fn of_normals(
    relief: &Relief,
    frame: ReliefFrame,
    (on, weights): (&Painted, [f32; 2]),
    shading: Vec3,
) -> Option<Vec3> {
    let texture = &relief.texture;
    let place = |at: Vec2| match frame {
        ReliefFrame::Picture => texture.place(at),
        ReliefFrame::Mesh => at,
    };
    let [right, up] = on.frame((texture.set, place), weights, shading)?;
    let up = match frame {
        ReliefFrame::Picture => up,
        ReliefFrame::Mesh => shading.cross(right),
    };
    let texel = glam::Vec4::from(texture.at(on.coordinates(texture.set, weights)));
    let own = 2.0 * texel.xyz() - 1.0;
    let own = Vec3::new(own.x * relief.scale, own.y * relief.scale, own.z);
    Some(right * own.x + up * own.y + shading * own.z)
}

/// The normal of a surface that is raised by a picture of heights (Blinn 1978, "Simulation of
/// wrinkled surfaces"), of any length. What is curved about it is left out, as is common.
fn of_heights(
    relief: &Relief,
    reads: Reads,
    (on, weights): (&Painted, [f32; 2]),
    shading: Vec3,
) -> Option<Vec3> {
    let set = relief.texture.set;
    let ways = on.derivatives(set, shading)?;
    let slopes = relief.texture.slopes(on.coordinates(set, weights), reads);
    let raised = |axis: usize| {
        let flat = ways[axis].reject_from_normalized(shading);
        flat + shading * (relief.scale * slopes[axis])
    };
    let normal = raised(0).cross(raised(1));
    Some(if normal.dot(shading) < 0.0 { -normal } else { normal })
}

/// The mean over a primitive of what it emits, relative to the factor of the paint: what emitters
/// are chosen by. Greater than zero unless nothing of the picture is.
pub fn mean_share(textures: &Textures, on: &Painted) -> f64 {
    let Some(paint) = &textures.emission else { return 1.0 };
    let total = |rgb: [f32; 3]| f64::from(rgb[0]) + f64::from(rgb[1]) + f64::from(rgb[2]);
    let whole = total(paint.factor);
    if whole == 0.0 {
        return 0.0;
    }
    let places = on.spread(steps(paint, on));
    let mut sum = 0.0;
    for &weights in &places {
        let [color] = [taps(paint, (on, weights)).mixed(|texel| paint.color(texel))];
        let covered = textures.coverage.as_ref();
        let share = covered.map_or(1.0, |it| coverage_at(it, (on, weights)));
        sum += total(color) * f64::from(share);
    }
    // What no sample has met may shine all the same.
    (0.99 * sum / places.len() as f64 + 0.01 * total(paint.mean())) / whole
}

/// How many steps along an edge meet most texels of a primitive.
fn steps(paint: &Paint, on: &Painted) -> usize {
    const STEPS: [f32; 2] = [4.0, 64.0];
    let Some(texture) = &paint.texture else { return 1 };
    let texels = on.texels(texture.set, |at| texture.place(at), texture.picture.texels().size());
    texels.clamp(STEPS[0], STEPS[1]) as usize
}
