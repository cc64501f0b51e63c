//! Surfaces as textures paint them: parameters of their models, shading normals, holes, and what
//! lamps emit. A value is found once for every point that a path meets, and whoever asks for it
//! there again finds the same.

use std::ops::{Deref, Range};

use glam::Vec3;

use crate::geometry::{HitColumns, RayColumns, SurfaceColumns};
use crate::math::elementary::sin_cos;
use crate::math::lanes::U32s;
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scene::baked::{NONE, Optics, Shapes};
use crate::scene::corners::Painted;
use crate::scene::emitter::{Emitter, EmitterModel, Panorama};
use crate::scene::painting::{Painting, coverage_at, normal_at};
use crate::scene::world::{SurfaceModel, Textures};

use super::Scene;
use super::emitter::{self, primitive};
use super::surface::model::LaneRows;
use super::surface::{Material, SurfaceKind, Surfaces};

/// A scene, with the tables of models that have a row for every painted point at hand.
pub struct SceneAt<'a, const N: usize> {
    /// The scene.
    pub scene: &'a Scene<N>,
    /// Its tables of models, or the same with more rows.
    pub surfaces: &'a Surfaces<N>,
}

impl<const N: usize> Clone for SceneAt<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<const N: usize> Copy for SceneAt<'_, N> {}

impl<const N: usize> Deref for SceneAt<'_, N> {
    type Target = Scene<N>;

    #[inline(always)]
    fn deref(&self) -> &Scene<N> {
        self.scene
    }
}

impl<'a, const N: usize> From<&'a Scene<N>> for SceneAt<'a, N> {
    /// Where nothing is painted.
    #[inline(always)]
    fn from(scene: &'a Scene<N>) -> Self {
        Self { scene, surfaces: &scene.surfaces }
    }
}

/// The tables of models of a scene, and behind their rows those of painted points. Empty where
/// nothing is painted.
#[derive(Debug, Default)]
pub struct PaintedModels<const N: usize> {
    tables: Surfaces<N>,
    /// Rows of each table that are needed still.
    kept: Vec<usize>,
}

impl<const N: usize> PaintedModels<N> {
    /// Takes the tables of a scene, and forgets all points.
    pub fn start(&mut self, scene: &Scene<N>) {
        if scene.has_models_by_place {
            self.tables.restart(&scene.surfaces);
            self.keep();
        }
    }

    /// Keeps the points so far.
    pub fn keep(&mut self) {
        self.kept = self.tables.lengths();
    }

    /// Forgets the points since those that are kept.
    fn forget(&mut self) {
        self.tables.truncate(&self.kept);
    }

    /// The scene with these.
    #[inline(always)]
    pub fn of<'a>(&'a self, scene: &'a Scene<N>) -> SceneAt<'a, N> {
        match scene.has_models_by_place {
            true => SceneAt { scene, surfaces: &self.tables },
            false => scene.into(),
        }
    }
}

/// Finds the models of surfaces where they have been hit that are not the same everywhere, and the
/// shading normals of painted ones: those have parameters by pictures, and rough glass that touches
/// other glass is between what is on its two sides there, for `paths` that have come by these rays
/// from inside these dielectrics. Points of earlier calls are forgotten but for those that are
/// kept, unless `adds`.
#[inline(never)]
pub fn paint<const N: usize>(
    surfaces: &mut SurfaceColumns,
    models: &mut PaintedModels<N>,
    (hits, paths): (&HitColumns, (&RayColumns, &[u32])),
    (rows, adds): (Range<usize>, bool),
    scene: &Scene<N>,
) {
    if !adds {
        models.forget();
    }
    for row in rows {
        let primitive = surfaces.primitive[row];
        surfaces.model[row] = NONE;
        if scene.shapes.surface_of(primitive) == NONE {
            continue;
        }
        let mut model = scene.optics.materials[scene.material_row(primitive)].model.clone();
        let painted = paint_row(&mut model, surfaces, hits, row, scene);
        let nested = nest(&mut model, surfaces, paths, row, scene);
        if comb(&mut model, surfaces, hits, row, scene) || nested || painted {
            let at = ([hits.u[row], hits.v[row]], position_of(surfaces, row));
            let added = models.tables.append(&model);
            if let Some(stain) = scene.stain_at(primitive, at) {
                models.tables.stain(&model, added, stain);
            }
            surfaces.model[row] = added;
        }
    }
}

/// Gives a model the parameters that pictures have where a row has been hit, and the row its
/// shading normal; whether the model has any such parameters.
fn paint_row<const N: usize>(
    model: &mut SurfaceModel<[f32; N]>,
    surfaces: &mut SurfaceColumns,
    hits: &HitColumns,
    row: usize,
    scene: &Scene<N>,
) -> bool {
    let Some(painting) = scene.optics.painting.as_deref() else { return false };
    let primitive = surfaces.primitive[row];
    let Some((textures, _)) = textures_at(scene, painting, primitive) else { return false };
    let feeds = textures.feed_model() || stains_rows(textures, model);
    let on = scene.shapes.painted(primitive).filter(|_| feeds);
    if let Some(on) = &on {
        let weights = on.weights([hits.u[row], hits.v[row]], position_of(surfaces, row));
        *model = painting.model_at(model.clone(), textures, (on, weights));
    }
    bend(surfaces, row, textures, hits, scene);
    on.is_some()
}

/// Whether a primitive is polished where it is met: see [`SurfaceModel::is_polished`].
pub fn is_polished_at<const N: usize>(scene: &Scene<N>, primitive: u32, point: Vec3) -> bool {
    if scene.shapes.surface_of(primitive) == NONE {
        return false;
    }
    let mut model = scene.optics.materials[scene.material_row(primitive)].model.clone();
    let painting = scene.optics.painting.as_deref();
    let textures = painting.and_then(|painting| textures_at(scene, painting, primitive));
    if let Some((painting, (textures, _))) = painting.zip(textures) {
        let on = scene.shapes.painted(primitive).filter(|_| textures.feed_model());
        if let Some(on) = &on {
            model = painting.model_at(model, textures, (on, on.weights_at(point)));
        }
    }
    model.is_polished()
}

/// Whether a model keeps in its rows a stain that differs from place to place.
fn stains_rows<S>(textures: &Textures, model: &SurfaceModel<S>) -> bool {
    SurfaceKind::of(model).connects() && textures.stain.differs()
}

/// Gives rough glass the index of refraction between what is on its two sides where a row has been
/// hit; whether it is a model that other glass changes.
fn nest<const N: usize>(
    model: &mut SurfaceModel<[f32; N]>,
    surfaces: &SurfaceColumns,
    paths: (&RayColumns, &[u32]),
    row: usize,
    scene: &Scene<N>,
) -> bool {
    if let SurfaceModel::Brushed { of, .. } = model {
        return nest(of, surfaces, paths, row, scene);
    }
    let SurfaceModel::RoughDielectric { ior, exterior_ior, .. } = model else { return false };
    let Some(interfaces) = &scene.interfaces else { return false };
    if scene.shapes.surfaces[surfaces.surface[row] as usize].solid == NONE {
        return false;
    }
    let met = scene.interfaces_at(interfaces, surfaces, paths, [row; LANES], &LaneRows::Same(0));
    let [of_interface, ..] = met.rows.numbers().to_array();
    *ior = scene.surfaces.ior_of_interface(of_interface as usize);
    *exterior_ior = [1.0; N];
    true
}

/// Gives facets that are stretched their direction where a row has been hit; whether there are any.
fn comb<const N: usize>(
    model: &mut SurfaceModel<[f32; N]>,
    surfaces: &SurfaceColumns,
    hits: &HitColumns,
    row: usize,
    scene: &Scene<N>,
) -> bool {
    if !model.has_grain() {
        return false;
    }
    let of = |columns| Vec3::from(lanes::row_of(columns, row));
    let normal = of(&surfaces.shading_normal);
    let shapes = &scene.shapes;
    let surface = &shapes.surfaces[surfaces.surface[row] as usize];
    let (on, weights) = (shapes.painted(surfaces.primitive[row]), [hits.u[row], hits.v[row]]);
    let triangle = on.filter(|on| matches!(on, Painted::Flat(_)));
    let stated = triangle.and_then(|on| on.frame((0, |place| place), weights, normal));
    let [right, up] = stated.unwrap_or_else(|| {
        let (x, y) = (surface.axis_x, surface.axis_y);
        // Spheres have a direction round them, but at their poles.
        let round = if triangle.is_none() { x.cross(y).cross(normal) } else { Vec3::ZERO };
        let along = [round, x, y].map(|axis| axis.reject_from_normalized(normal));
        let right = along.iter().find(|axis| axis.length_squared() > ALONG_MIN);
        let right = right.map_or(Vec3::X, |axis| axis.normalize());
        [right, normal.cross(right)]
    });
    model.for_each_grain(&mut |grain| {
        let (sine, cosine) = sin_cos(f64::from(grain.turn));
        let [x, y] = grain.direction;
        let [sine, cosine] = [sine as f32, cosine as f32];
        let along = right * (cosine * x - sine * y) + up * (sine * x + cosine * y);
        grain.place = along.try_normalize().unwrap_or(right).to_array();
    });
    true
}

/// Squared sine between an axis and a normal below which the axis says no direction.
const ALONG_MIN: f32 = 1e-6;

/// Finds the shading normals of painted surfaces where they have been hit.
pub fn paint_normals<const N: usize>(
    surfaces: &mut SurfaceColumns,
    hits: &HitColumns,
    rows: Range<usize>,
    scene: &Scene<N>,
) {
    let Some(painting) = scene.optics.painting.as_deref() else { return };
    for row in rows {
        if let Some((textures, _)) = textures_at(scene, painting, surfaces.primitive[row]) {
            bend(surfaces, row, textures, hits, scene);
        }
    }
}

/// The textures of a primitive, and the row of its material.
#[inline]
fn textures_at<'a, const N: usize>(
    scene: &Scene<N>,
    painting: &'a Painting<N>,
    primitive: u32,
) -> Option<(&'a Textures, usize)> {
    if scene.shapes.surface_of(primitive) == NONE {
        return None;
    }
    let material = scene.material_row(primitive);
    Some((painting.of(material)?, material))
}

/// The shading normal of a row.
fn bend<const N: usize>(
    surfaces: &mut SurfaceColumns,
    row: usize,
    textures: &Textures,
    hits: &HitColumns,
    scene: &Scene<N>,
) {
    let Some(relief) = &textures.relief else { return };
    let Some(on) = scene.shapes.painted(surfaces.primitive[row]) else { return };
    let of = |columns| Vec3::from(lanes::row_of(columns, row));
    let normals = [of(&surfaces.shading_normal), of(&surfaces.geometric_normal)];
    let weights = on.weights([hits.u[row], hits.v[row]], position_of(surfaces, row));
    let normal = normal_at(relief, (&on, weights), normals);
    for (column, value) in surfaces.shading_normal.iter_mut().zip(normal.to_array()) {
        column[row] = value;
    }
}

fn position_of(surfaces: &SurfaceColumns, row: usize) -> Vec3 {
    lanes::row_of(&surfaces.position, row).into()
}

impl<const N: usize> Scene<N> {
    /// Whether any material has textures.
    #[inline(always)]
    pub fn is_painted(&self) -> bool {
        self.optics.painting.is_some()
    }

    /// The row in the table of its model of a surface that has been hit.
    #[inline]
    pub fn model_row(&self, surfaces: &SurfaceColumns, row: usize) -> usize {
        match surfaces.model[row] {
            NONE => self.material_at(surfaces.primitive[row]).row as usize,
            model => model as usize,
        }
    }

    /// Of the surfaces that have been hit in some rows, the rows in the tables of their models, and
    /// the mask of those whose backs scatter too.
    // Out of line: every model's loops ask this once for eight vertices.
    #[inline(never)]
    pub fn models_of_hits(&self, surfaces: &SurfaceColumns, rows: &LaneRows) -> (LaneRows, F32s) {
        let material = |row: usize| self.material_row(surfaces.primitive[row]);
        let found = rows.words(|row| self.model_of_material[material(row)]);
        let rows = match (self.has_models_by_place, rows) {
            (true, rows) => rows.map(|row| self.model_row(surfaces, row)),
            (false, LaneRows::Same(_)) => LaneRows::Same((found.as_array()[0] & !BACK) as usize),
            (false, LaneRows::Each(_)) => {
                LaneRows::Each((found & U32s::splat(!BACK)).to_array().map(|row| row as usize))
            }
        };
        (rows, lanes::are_set(found, BACK))
    }

    /// What the stain of a primitive, if it has one, leaves of light that it reflects and of what
    /// goes through, where it has been hit.
    pub fn stain_at(
        &self,
        primitive: u32,
        (weights, position): ([f32; 2], Vec3),
    ) -> Option<[[f32; N]; 2]> {
        let painting = self.optics.painting.as_deref()?;
        let (textures, _) = textures_at(self, painting, primitive)?;
        let stain = Some(&textures.stain).filter(|stain| stain.is_some())?;
        let on = self.shapes.painted(primitive)?;
        Some(painting.stain(stain, (&on, on.weights(weights, position))))
    }

    /// The same at a point of it.
    pub fn stain_of_point(&self, primitive: u32, position: Vec3) -> Option<[[f32; N]; 2]> {
        let painting = self.optics.painting.as_deref()?;
        let (textures, _) = textures_at(self, painting, primitive)?;
        let stain = Some(&textures.stain).filter(|stain| stain.is_some())?;
        let on = self.shapes.painted(primitive)?;
        let weights = if stain.differs() { on.weights_at(position) } else { [0.0; 2] };
        Some(painting.stain(stain, (&on, weights)))
    }

    /// The share of a primitive that is there where it has been hit, by the weights of triangles
    /// and the point.
    pub fn coverage_at(&self, primitive: u32, (weights, position): ([f32; 2], Vec3)) -> f32 {
        let found = self.optics.painting.as_deref().and_then(|painting| {
            let (textures, _) = textures_at(self, painting, primitive)?;
            let coverage = textures.coverage.as_ref()?;
            let by_place = || {
                let on = self.shapes.painted(primitive)?;
                Some(coverage_at(coverage, (&on, on.weights(weights, position))))
            };
            coverage.even().or_else(by_place)
        });
        found.unwrap_or(1.0)
    }

    /// What a point of an emitter emits over what its lamp does, by textures; of one that is
    /// infinitely far away, what comes from a direction.
    pub fn tint(&self, emitter: usize, position: Vec3, direction: Vec3) -> [f32; N] {
        if let Some(panorama) = self.panorama(emitter) {
            let value = panorama.radiance(direction, &self.optics.carried);
            return over(value, self.optics.radiance_of(emitter));
        }
        let tint = || {
            let painting = self.optics.painting.as_deref()?;
            let primitive = primitive(&self.optics.emitters[emitter].model);
            let surface = self.shapes.surfaces.get(self.shapes.surface_of(primitive) as usize)?;
            let textures = painting.of(surface.material as usize)?;
            if !textures.differ_by_place() {
                return Some([textures.coverage.as_ref()?.even()?; N]);
            }
            let on = self.shapes.painted(primitive)?;
            let at = (&on, on.weights_at(position));
            let mut tint = [1.0; N];
            if let Some(paint) = &textures.emission {
                tint = over(painting.radiance(paint, at), self.optics.radiance_of(emitter));
            }
            if let Some(coverage) = &textures.coverage {
                let share = coverage_at(coverage, at);
                tint.iter_mut().for_each(|tint| *tint *= share);
            }
            Some(tint)
        };
        tint().unwrap_or([1.0; N])
    }

    /// Multiplies what arrives of points of eight emitters, or from directions, by their tints.
    #[cold]
    pub fn tint_lanes(
        &self,
        radiance: &mut [F32s; N],
        emitters: [usize; LANES],
        (points, directions): (Vector<F32s>, Vector<F32s>),
    ) {
        let skies = emitters.map(|emitter| self.panorama(emitter));
        let is_sky = skies.map(|sky| sky.is_some());
        let rows = [points, directions].map(Vector::to_rows);
        let mut tints = [[1.0; N]; LANES];
        for (lane, tint) in tints.iter_mut().enumerate().filter(|(lane, _)| !is_sky[*lane]) {
            let [point, direction] = rows.map(|rows| rows[lane].into());
            *tint = self.tint(emitters[lane], point, direction);
        }
        let of_lamps = |n: usize| F32s::from(lanes::each(|lane| tints[lane][n]));
        // There is one at most.
        let Some((sky, lane)) = skies.iter().zip(0..).find_map(|(sky, lane)| Some(((*sky)?, lane)))
        else {
            return radiance.iter_mut().enumerate().for_each(|(n, it)| *it *= of_lamps(n));
        };
        let (mask, lamp) = (lanes::mask_of(is_sky), self.optics.radiance_of(emitters[lane]));
        let shown = sky.radiances(directions, &self.optics.carried);
        for (n, radiance) in radiance.iter_mut().enumerate() {
            let of_sky =
                if lamp[n] > 0.0 { F32s::splat(1.0 / lamp[n]) * shown[n] } else { F32s::ZERO };
            *radiance *= Real::select(mask, of_sky, of_lamps(n));
        }
    }

    /// The picture of an emitter that is one of all directions.
    #[inline(always)]
    pub fn panorama(&self, emitter: usize) -> Option<&Panorama> {
        self.optics.emitters[emitter].model.panorama()
    }
}

/// The bit of [`of_model`] for the back.
const BACK: u32 = 1 << 31;

/// A material's row in the table of its model, and in the highest bit whether its back scatters
/// too.
pub(super) fn of_model(material: &Material) -> u32 {
    material.row | if material.two_sided { BACK } else { 0 }
}

/// Values over those of a lamp; nothing where that is black, as then the values are.
#[inline]
fn over<const N: usize>(value: [f32; N], lamp: [f32; N]) -> [f32; N] {
    std::array::from_fn(|n| if lamp[n] > 0.0 { value[n] / lamp[n] } else { 0.0 })
}

/// All textures of a scene's materials.
fn textures<const N: usize>(optics: &Optics<N>) -> impl Iterator<Item = &Textures> {
    let of =
        |painting| (0..optics.materials.len()).filter_map(move |row| Painting::of(painting, row));
    optics.painting.as_deref().into_iter().flat_map(of)
}

/// Whether some have models, or normals, that are of the place.
pub(super) fn has_models_by_place<const N: usize>(optics: &Optics<N>) -> bool {
    let Some(painting) = optics.painting.as_deref() else { return false };
    let mut rows = optics.materials.iter().enumerate();
    rows.any(|(row, material)| {
        painting.of(row).is_some_and(|textures| {
            let feeds = textures.feed_model() || textures.relief.is_some();
            feeds || stains_rows(textures, &material.model)
        })
    })
}

/// Whether some have a stain, or are panes with holes.
pub(super) fn has_stains<const N: usize>(optics: &Optics<N>) -> bool {
    let Some(painting) = optics.painting.as_deref() else { return false };
    optics.materials.iter().enumerate().any(|(row, material)| {
        let is_pane = SurfaceKind::of(&material.model).is_straight_on();
        let has = |of: &Textures| of.stain.is_some() || is_pane && of.coverage.is_some();
        painting.of(row).is_some_and(has)
    })
}

/// Whether some have shading normals by a picture.
pub(super) fn has_relief<const N: usize>(optics: &Optics<N>) -> bool {
    textures(optics).any(|textures| textures.relief.is_some())
}

/// Whether some say what emitters emit.
pub(super) fn has_painted_lamps<const N: usize>(shapes: &Shapes, optics: &Optics<N>) -> bool {
    let is_picture = |emitter: &Emitter| matches!(emitter.model, EmitterModel::Panorama(_));
    if optics.emitters.iter().any(is_picture) {
        return true;
    }
    let Some(painting) = optics.painting.as_deref() else { return false };
    optics.emitters.iter().any(|emitter| {
        let surface = shapes.surface_of(emitter::primitive(&emitter.model));
        let material = shapes.surfaces.get(surface as usize).map(|it| it.material as usize);
        let textures = material.and_then(|material| painting.of(material));
        textures.is_some_and(|it| it.emission.is_some() || it.coverage.is_some())
    })
}
