//! A look at a scene before it is rendered: what mirrors and glass do in it. From where the camera
//! is, and from points all over what leaves light a single way, some rays are sent; what they find
//! is a function of the scene alone, the same for every film, mode and seed.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::Vec3;

use super::emitter::{is_delta, places};
use super::immersion::{Around, STEPS, spread};
use super::painting::is_polished_at;
use super::patches::{Patches, primitives_of_surfaces};
use super::{Scene, Sensor};
use crate::film::layout::Layout;
use crate::geometry::{Hit, offset_distance};
use crate::math::F32s;
use crate::scene::baked::NONE;
use crate::scene::emitter::EmitterModel;

/// Height of the film in pixels.
const EDGE: f32 = 1024.0;
/// Rays along an edge of the film.
const RAYS: usize = 64;
/// Points on all surfaces that leave light a single way, and the least of each.
const POINTS: usize = 512;
const POINTS_OF_SURFACE: usize = 8;
/// Primitives of a surface that points are taken from, at most.
const PRIMITIVES_OF_SURFACE: usize = 4096;
/// Emitters that are looked for from a point, at most.
const EMITTERS: usize = 64;
/// How far to an emitter one looks, so as not to meet it.
const ALMOST: f32 = 1.0 - 1e-4;
/// Surfaces that a ray goes straight through before it is given up.
const PASSED_MAX: usize = 256;

/// What a look finds. Mirrors and glass stand for all that leaves light a single way, and the
/// lamps of these are the emitters whose light comes there straight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Share of the camera's rays that meet mirrors or glass first.
    pub sees_specular: f64,
    /// Share of those that meet what lets no light straight on.
    pub sees_solid: f64,
    /// Share of the camera's rays that meet what mirrors some light, and lets the rest straight on.
    pub sees_panes: f64,
    /// Share of those that meet, behind panes too, polished coats, metals or rough glass first.
    pub sees_polished: f64,
    /// Share of the camera's rays that leave the scene.
    pub sees_nothing: f64,
    /// Whether those see a sky, by parallel rays: they share no direction with light that comes
    /// from it.
    pub has_parallel_sky: bool,
    /// Whether points, spots or directions are among the lamps of mirrors and glass: light that
    /// paths from the sensor do not find by way of these.
    pub has_points: bool,
    /// Whether points or spots shine in media that scatter: light is bright close to them, where
    /// paths from emitters begin and few of those from the sensor come.
    pub has_points_in_media: bool,
    /// Share of the light on what the camera sees that would come straight from emitters if there
    /// were no glass before them.
    pub hidden: f64,
    /// With which probability paths from mirrors and glass in random directions meet the lamps of
    /// these that can be met: the mean over what they bring; one if there are none.
    pub chance: f64,
}

impl Look {
    /// Looks at a scene.
    pub fn at<const N: usize>(scene: &Scene<N>) -> Self {
        let camera = &scene.camera;
        // The film's own edges are not of the scene.
        let [width, height] = [camera.aspect().unwrap_or(1.0) * EDGE, EDGE].map(|it| it as u32);
        let sensor = Sensor::new(camera, Layout::plain([width.max(1), height]));
        let mut places = Places::default();
        let view = View::of(scene, &sensor, &mut places);
        let [sees_specular, sees_solid, sees_panes, sees_polished, sees_nothing] =
            [view.specular, view.solid, view.panes, view.polished, view.nothing].map(View::share);
        let hidden = if view.hidden > 0.0 { view.hidden / (view.hidden + view.open) } else { 0.0 };
        let has_sky = !scene.optics.skies.is_empty() && sees_nothing > 0.0;
        let mut lamps = Lamps::default();
        for (index, (point, normal, step)) in specular_points(scene).into_iter().enumerate() {
            lamps.look(scene, &mut places, (point, normal, step), index);
        }
        let Lamps { has_points, brought, spread } = lamps;
        let chance = if spread > 0.0 { brought / spread } else { 1.0 };
        let has_parallel_sky = has_sky && !sensor.is_finite();
        Self {
            sees_specular,
            sees_solid,
            sees_panes,
            sees_polished,
            sees_nothing,
            has_parallel_sky,
            has_points,
            has_points_in_media: has_points_in_media(scene),
            hidden,
            chance,
        }
    }
}

/// Whether connections in media have points to go to.
fn has_points_in_media<const N: usize>(scene: &Scene<N>) -> bool {
    let scatters = |&medium: &u32| {
        scene.optics.media.get(medium as usize).is_some_and(|medium| medium.scatters())
    };
    let is_immersed = |row: usize| match scene.media_of_emitter(row) {
        Around::Same(media) => media.iter().any(scatters),
        Around::Varies => true,
    };
    scene.optics.emitters.iter().enumerate().any(|(row, emitter)| {
        is_delta(&emitter.model) && emitter.model.is_finite() && is_immersed(row)
    })
}

/// What the camera's rays meet.
#[derive(Default)]
struct View {
    /// Numbers of rays that meet mirrors or glass first, such as lets no light straight on, such as
    /// does, polished surfaces there or behind it, and nothing.
    specular: usize,
    solid: usize,
    panes: usize,
    polished: usize,
    nothing: usize,
    /// Irradiance of what they meet behind glass, that comes straight and that glass is before.
    open: f64,
    hidden: f64,
}

impl View {
    /// Of all that a camera sees.
    fn of<const N: usize>(scene: &Scene<N>, sensor: &Sensor, places: &mut Places) -> Self {
        let mut view = Self::default();
        let at =
            |index: usize, edge: u32| F32s::splat((index as f32 + 0.5) / RAYS as f32 * edge as f32);
        for pixel in 0..RAYS * RAYS {
            let film = [at(pixel % RAYS, sensor.width), at(pixel / RAYS, sensor.height)];
            let (origin, direction, _) = sensor.rays(film, || [F32s::splat(0.0); 2]);
            let [origin, direction] = [origin, direction].map(|it| Vec3::from(it.to_rows()[0]));
            view.meet(scene, origin, direction);
            view.look_for_emitters(scene, places, (origin, direction), pixel);
        }
        view
    }

    fn meet<const N: usize>(&mut self, scene: &Scene<N>, origin: Vec3, direction: Vec3) {
        let kind_of = |primitive: u32| scene.material_at(primitive).kind;
        let passes = |primitive: u32| {
            kind_of(primitive).is_straight_on() && !kind_of(primitive).is_specular()
        };
        let met = first_met(scene, origin, direction, passes).primitive;
        if met == NONE {
            self.nothing += 1;
            return;
        }
        self.specular += usize::from(kind_of(met).is_specular());
        self.panes += usize::from(kind_of(met).is_straight_on());
        let passes = |primitive: u32| kind_of(primitive).is_straight_on();
        let hit = first_met(scene, origin, direction, passes);
        if hit.primitive == NONE {
            return;
        }
        let is_first = hit.primitive == met;
        if kind_of(hit.primitive).is_specular() {
            self.solid += usize::from(is_first);
        } else if is_polished_at(scene, hit.primitive, origin + hit.t * direction) {
            self.polished += 1;
        }
    }

    /// Looks for an emitter from what a ray meets behind all glass.
    fn look_for_emitters<const N: usize>(
        &mut self,
        scene: &Scene<N>,
        places: &mut Places,
        (origin, direction): (Vec3, Vec3),
        index: usize,
    ) {
        let shapes = &scene.shapes;
        let is_opaque =
            |primitive: u32| shapes.surfaces[shapes.surface_of(primitive) as usize].is_opaque;
        let met = first_met(scene, origin, direction, |primitive| !is_opaque(primitive));
        if met.primitive == NONE || !scene.material_at(met.primitive).kind.connects() {
            return;
        }
        let point = origin + met.t * direction;
        let normal = shapes.geometric_normal(met.primitive, point);
        let step = STEPS * offset_distance(point.abs().max_element());
        let emitter = index % scene.optics.emitters.len();
        let Some(aim) = Aim::at(scene, places, emitter, (point, index)) else { return };
        if (aim.direction.dot(normal) > 0.0) != (direction.dot(normal) < 0.0) {
            return;
        }
        match aim.obstacle(scene, (point, normal, step)) {
            None => self.open += aim.seen.irradiance,
            Some(primitive) if is_opaque(primitive) => {}
            Some(_) => self.hidden += aim.seen.irradiance,
        }
    }

    /// A share of all rays.
    fn share(count: usize) -> f64 {
        count as f64 / (RAYS * RAYS) as f64
    }
}

/// The first that a ray meets of what it does not pass.
pub fn first_met<const N: usize>(
    scene: &Scene<N>,
    origin: Vec3,
    direction: Vec3,
    passes: impl Fn(u32) -> bool,
) -> Hit {
    let mut hit = scene.accelerator.closest(origin, direction, f32::INFINITY);
    for _ in 0..PASSED_MAX {
        if hit.primitive == NONE || !passes(hit.primitive) {
            break;
        }
        hit = scene.accelerator.next(origin, direction, hit);
    }
    hit
}

/// Points all over the surfaces that leave light a single way, with the normals there and how far
/// off them rays start.
fn specular_points<const N: usize>(scene: &Scene<N>) -> Vec<(Vec3, Vec3, f32)> {
    if !scene.has_specular_surfaces() {
        return Vec::new();
    }
    let (shapes, materials) = (&scene.shapes, scene.surfaces.materials());
    let is_specular =
        |row: &u32| materials[shapes.surfaces[*row as usize].material as usize].kind.is_specular();
    let surfaces: Vec<u32> = (0..shapes.surfaces.len() as u32).filter(is_specular).collect();
    // Of very many surfaces, some stand for all; so do some of very many triangles.
    let step = surfaces.len().div_ceil(POINTS / POINTS_OF_SURFACE).max(1);
    let some: Vec<u32> = surfaces.into_iter().step_by(step).collect();
    let primitives = primitives_of_surfaces(shapes, |row| some.binary_search(&row).is_ok());
    let count = POINTS / some.len();
    let of_surface = |row: u32| {
        let all = &primitives[row as usize];
        let step = all.len().div_ceil(PRIMITIVES_OF_SURFACE).max(1);
        let few: Vec<u32> = all.iter().copied().step_by(step).collect();
        let patches = Patches::new(shapes, &few);
        let step = patches.step();
        patches.points(count).into_iter().map(move |(point, normal)| (point, normal, step))
    };
    some.into_iter().flat_map(of_surface).collect()
}

/// The lamps of mirrors and glass.
#[derive(Default)]
struct Lamps {
    /// See [`Look::has_points`].
    has_points: bool,
    /// Sums over points of the squared irradiance, and of what the second moment of an estimate
    /// of it is that finds emitters by chance.
    brought: f64,
    spread: f64,
}

/// An emitter as a point sees it.
struct Seen {
    /// Its irradiance, of light that comes perpendicularly.
    irradiance: f64,
    /// The solid angle that it takes up, over that of all directions; zero for what cannot be met.
    share: f64,
}

impl Lamps {
    /// Looks for emitters from a point, the `index`-th of all.
    fn look<const N: usize>(
        &mut self,
        scene: &Scene<N>,
        places: &mut Places,
        from: (Vec3, Vec3, f32),
        index: usize,
    ) {
        let emitters = &scene.optics.emitters;
        // Others from every point, if there are too many.
        let stride = emitters.len().div_ceil(EMITTERS);
        let (mut irradiance, mut moment) = (0.0, 0.0);
        for (row, emitter) in emitters.iter().enumerate().skip(index % stride).step_by(stride) {
            let Some(aim) = Aim::at(scene, places, row, (from.0, index)) else { continue };
            if aim.obstacle(scene, from).is_some() {
                continue;
            }
            let seen = aim.seen;
            if is_delta(&emitter.model) {
                self.has_points = true;
            } else {
                irradiance += seen.irradiance;
                moment += seen.irradiance.powi(2) / seen.share;
            }
        }
        self.brought += irradiance * irradiance;
        self.spread += moment;
    }
}

/// Places of emitters, of each that was looked for.
#[derive(Default)]
struct Places(HashMap<usize, Vec<(Vec3, Vec3)>>);

impl Places {
    /// One of an emitter, with the normal there; another one for every index.
    fn of<const N: usize>(
        &mut self,
        scene: &Scene<N>,
        emitter: usize,
        index: usize,
    ) -> Option<(Vec3, Vec3)> {
        let all = || places(&scene.optics.emitters[emitter].model, &scene.shapes);
        let places = self.0.entry(emitter).or_insert_with(all);
        places.get(index % places.len().max(1)).copied()
    }
}

/// A way from a point to an emitter.
struct Aim {
    /// To the emitter, any length.
    direction: Vec3,
    /// How many lengths of that are in between.
    reach: f32,
    /// What is seen there, if nothing is in between.
    seen: Seen,
}

impl Aim {
    /// To some place of an emitter, from the `index`-th point; none to its dark side.
    fn at<const N: usize>(
        scene: &Scene<N>,
        places: &mut Places,
        row: usize,
        (point, index): (Vec3, usize),
    ) -> Option<Self> {
        let emitter = &scene.optics.emitters[row];
        let values = scene.optics.radiance_of(row).into_iter().map(f64::from);
        let radiance = values.sum::<f64>() / N as f64;
        let place = places.of(scene, row, index);
        let to_point = || {
            let to = place?.0 - point;
            let seen = Seen { irradiance: radiance / f64::from(to.length_squared()), share: 0.0 };
            Some(Self { direction: to, reach: ALMOST, seen })
        };
        let to_surface = |front_counts: bool, area: f32| {
            let (place, front) = place?;
            let to = place - point;
            let distance2 = f64::from(to.length_squared());
            let cosine = f64::from(-to.dot(front)) / distance2.sqrt();
            let cosine = if front_counts { cosine } else { cosine.abs() };
            let solid_angle = (f64::from(area) * cosine / distance2).min(2.0 * PI);
            let seen = Seen { irradiance: radiance * solid_angle, share: solid_angle / (4.0 * PI) };
            (solid_angle > 0.0).then_some(Self { direction: to, reach: ALMOST, seen })
        };
        let to_infinity = |direction: Vec3, irradiance: f64, share: f64| {
            let seen = Seen { irradiance, share };
            Some(Self { direction, reach: f32::INFINITY, seen })
        };
        match &emitter.model {
            EmitterModel::Triangle(it) => to_surface(!it.two_sided, it.area),
            EmitterModel::Sphere(it) => to_surface(!it.two_sided, it.area),
            EmitterModel::Point(_) => to_point(),
            EmitterModel::Patterned(it) => {
                let pattern = &scene.optics.patterns[it.row as usize];
                to_point().filter(|aim| pattern.reaches(-aim.direction.normalize()))
            }
            EmitterModel::Spot(it) => {
                to_point().filter(|aim| -aim.direction.normalize().dot(it.direction) > it.cos_outer)
            }
            EmitterModel::Directional(it) => to_infinity(-it.direction, radiance, 0.0),
            EmitterModel::Sun(it) => {
                let share = it.solid_angle() / (4.0 * PI);
                to_infinity(-it.direction, radiance * it.faced(), share)
            }
            EmitterModel::Environment(_) => {
                let direction = spread(POINTS).nth(index * 197 % POINTS)?;
                to_infinity(direction, radiance * 4.0 * PI, 1.0)
            }
            EmitterModel::Panorama(it) => {
                let place = index * 197 % POINTS;
                let u =
                    [place as f32 / POINTS as f32, (place * 55 % POINTS) as f32 / POINTS as f32];
                to_infinity(it.draw(u).0, radiance * 4.0 * PI, it.spread())
            }
        }
    }

    /// What is in between: what light does not pass straight on.
    fn obstacle<const N: usize>(
        &self,
        scene: &Scene<N>,
        (point, normal, step): (Vec3, Vec3, f32),
    ) -> Option<u32> {
        let side = if self.direction.dot(normal) < 0.0 { -step } else { step };
        let passes = |primitive: u32| scene.material_at(primitive).is_straight_on();
        let met = first_met(scene, point + side * normal, self.direction, passes);
        (met.t < self.reach).then_some(met.primitive)
    }
}
