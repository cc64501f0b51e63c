//! Renders for tests: scenes by path or world, images by replicate, and which pixels the light
//! tracer can fill.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::math::{F32s, LANES, Vector};
use sunstone::internals::render::{
    Mode, Options, Photons, PlacedWorld, Renderer, Settings, Spectral,
};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scattering::emitter::is_delta;
use sunstone::internals::scattering::immersion::Around;
use sunstone::internals::scattering::painting::is_polished_at;
use sunstone::internals::scene::baked::{NONE, Surface};
use sunstone::internals::scene::emitter::{Emitter, EmitterModel};
use sunstone::internals::scene::{World, bake, load};
use sunstone::internals::spectrum::{Band, Bands, Carried, Color};

use glam::Vec3;

/// The wavelength of the reference images.
pub const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

/// Sides of the grid of primary rays that decide what a pixel sees.
const RAYS: usize = 8;

/// A file of the package.
pub fn in_package(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A scene that is shipped or kept for tests.
pub fn world(path: &Path) -> World {
    load(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Bakes a scene for a film of `width` times `height` pixels.
pub fn scene<const N: usize>(
    world: &World,
    color: Color,
    [width, height]: [u32; 2],
) -> Arc<Scene<N>> {
    let carried = Carried::<N>::of(&color).expect("as many wavelengths as channels");
    let tables = bake(world, &carried).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Scene::new(tables, width, height))
}

/// One randomization of `iterations` samples, without roulette. Integrators get seeds of their
/// own, for `path` and `bdpt` would otherwise share their sensor paths and with them their noise.
pub fn settings(
    integrator: Integrator,
    mode: Mode,
    color: Color,
    iterations: u32,
    path_length_max: u32,
) -> Options {
    let seed = match integrator {
        Integrator::Path => 0x1000_0000,
        Integrator::Light => 0x2000_0000,
        Integrator::Bdpt => 0x3000_0000,
        Integrator::Ppm => 0x4000_0000,
    };
    Options {
        integrator: Some(integrator),
        mode,
        color,
        samples: iterations,
        path_length_max,
        roulette_after: Some(path_length_max + 1),
        seed,
        // More than one chunk of them, few enough to be quick.
        photons: Photons { per_iteration: Some(2_000), samples: Some(1), ..Photons::default() },
        ..Options::default()
    }
}

/// One image.
pub fn image<const N: usize>(scene: &Arc<Scene<N>>, options: &Options) -> StokesImage {
    rendered(scene, options).finish()
}

/// A render that is done.
pub fn rendered<const N: usize>(scene: &Arc<Scene<N>>, options: &Options) -> Renderer {
    let settings = Settings::new(options.clone()).unwrap_or_else(|error| panic!("{error}"));
    let mut renderer = Renderer::of(Arc::clone(scene), &settings);
    renderer.run(|_| ControlFlow::Continue(()));
    renderer
}

/// `count` independent images of the same scene: their spread is the error of their mean, for
/// any sum over pixels too, whatever correlation there is between those.
pub fn replicates<const N: usize>(
    scene: &Arc<Scene<N>>,
    settings: &Options,
    count: u32,
) -> Vec<StokesImage> {
    let seeds = (0..count).into_par_iter().map(|replicate| settings.seed + replicate);
    seeds.map(|seed| image(scene, &Options { seed, ..settings.clone() })).collect()
}

/// The same of a film of bands, or of RGB that is measured as a spectrum is.
pub fn spectral_replicates(
    world: &PlacedWorld,
    settings: &Options,
    count: u32,
) -> Vec<StokesImage> {
    let image = |replicate| {
        let seed = settings.seed + replicate;
        let settings = Settings::new(Options { seed, ..settings.clone() });
        let settings = settings.unwrap_or_else(|error| panic!("{error}"));
        let renderer = Renderer::new(world, &settings);
        let mut renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
        renderer.run(|_| ControlFlow::Continue(()));
        renderer.finish()
    };
    (0..count).into_par_iter().map(image).collect()
}

/// Options of a film of bands, given by their middles and widths in nanometers.
pub fn in_bands(wavelengths: u32, bands: &[[f32; 2]], size: [u32; 2], options: Options) -> Options {
    let bands: Vec<Band> = bands.iter().map(|[nm, width]| Band::new(*nm, *width)).collect();
    let ends = |band: &Band| band.ends_nm().map(|nm| nm as f32);
    let range_nm = [ends(&bands[0])[0], ends(&bands[bands.len() - 1])[1]];
    let bands = Bands::new(bands).expect("sound bands");
    Options {
        color: Color::Bands(Arc::new(bands)),
        spectral: Some(Spectral { wavelengths, range_nm }),
        width: Some(size[0]),
        height: Some(size[1]),
        ..options
    }
}

/// Share of all directions that an emitter must take up, as seen from the edge of the scene, for
/// paths from the sensor to meet it often enough by chance: with 1,000 samples a cell and 32
/// replicates some 30 times. Where that is rarer, as in caustics of small lights, neither the mean
/// nor its estimated error can be trusted: most replicates know nothing of the light that others
/// have.
const CHANCE_MIN: f32 = 1e-3;

/// Whether unidirectional paths from the sensor can be trusted to find all light: yes without
/// specular surfaces, where connections find it; else only if all emitters are large. Not if a
/// point shines in a medium: connections to it from nearby have no finite variance.
pub fn path_finds_everything<const N: usize>(scene: &Scene<N>) -> bool {
    let is_point = |model: &EmitterModel| is_delta(model) && model.is_finite();
    let mut emitters = scene.optics.emitters.iter().enumerate();
    let immersed =
        |(index, emitter): (usize, &Emitter)| is_point(&emitter.model) && scene.is_immersed(index);
    if emitters.any(immersed) {
        return false;
    }
    if !scene.shapes.surfaces.iter().any(|surface| is_specular(scene, surface)) {
        return true;
    }
    let (shapes, optics) = (&scene.shapes, &scene.optics);
    let mut areas = vec![0.0; shapes.surfaces.len()];
    for emitter in &*optics.emitters {
        let (primitive, area) = match &emitter.model {
            EmitterModel::Triangle(triangle) => (triangle.primitive, triangle.area),
            EmitterModel::Sphere(sphere) => (sphere.primitive, sphere.area),
            EmitterModel::Environment(_) => continue,
            EmitterModel::Panorama(sky) if sky.spread() > f64::from(CHANCE_MIN) => continue,
            EmitterModel::Point(_)
            | EmitterModel::Patterned(_)
            | EmitterModel::Spot(_)
            | EmitterModel::Directional(_)
            | EmitterModel::Sun(_)
            | EmitterModel::Panorama(_) => {
                return false;
            }
        };
        areas[shapes.surface_of_primitive[primitive as usize] as usize] += area;
    }
    let all = 4.0 * std::f32::consts::PI * shapes.bounds.radius.powi(2);
    areas.iter().all(|&area| area == 0.0 || area / all >= CHANCE_MIN)
}

/// Whether connections to a surface have nothing to find.
fn is_specular<const N: usize>(scene: &Scene<N>, surface: &Surface) -> bool {
    scene.surfaces.materials()[surface.material as usize].kind.is_specular()
}

/// The pixels that connections of light paths to the sensor can fill: those, with their
/// neighbors, whose primary rays meet diffuse surfaces, rough ones, absorbers, or an emitter with
/// a direction of its own. Neighbors are asked because rays are few and edges thin. None at all
/// for a pinhole in a medium, as connections to it from nearby have no finite variance.
pub fn light_mask<const N: usize>(scene: &Scene<N>) -> Vec<bool> {
    if scene.sensor_medium != Around::Same(NONE) && scene.sensor.is_finite() {
        return vec![false; (scene.sensor.width * scene.sensor.height) as usize];
    }
    let [width, height] = [scene.sensor.width, scene.sensor.height].map(|size| size as i32);
    let mut clear = Vec::new();
    for y in 0..height {
        clear.extend((0..width).map(|x| sees_no_specular(scene, [x as f32, y as f32])));
    }
    let clear_at = |x: i32, y: i32| {
        let outside = x < 0 || y < 0 || x >= width || y >= height;
        outside || clear[(y * width + x) as usize]
    };
    let near = |x: i32, y: i32| (-1..=1).all(|dy| (-1..=1).all(|dx| clear_at(x + dx, y + dy)));
    (0..height).flat_map(|y| (0..width).map(move |x| near(x, y))).collect()
}

/// Whether all rays of a pixel, over its area and the lens, meet what light paths connect from.
fn sees_no_specular<const N: usize>(scene: &Scene<N>, [left, top]: [f32; 2]) -> bool {
    let stratum = |index: usize| (index as f32 + 0.5) / RAYS as f32;
    (0..RAYS * RAYS).step_by(LANES).all(|start| {
        let lane = |of: fn(usize) -> usize| {
            F32s::from(std::array::from_fn(|lane| stratum(of(start + lane))))
        };
        let [u, v] = [lane(|index| index % RAYS), lane(|index| index / RAYS)];
        // The lens in another order than the pixel, so that the two do not go together.
        let lens = [lane(|index| (index * 29 + 3) % RAYS), lane(|index| index * 37 / RAYS % RAYS)];
        let film = [F32s::splat(left) + u, F32s::splat(top) + v];
        let (origin, direction, _) = scene.sensor.rays(film, || lens);
        let row = |v: &Vector<F32s>, lane: usize| {
            Vec3::new(v.x.to_array()[lane], v.y.to_array()[lane], v.z.to_array()[lane])
        };
        (0..LANES).all(|lane| {
            let (origin, direction) = (row(&origin, lane), row(&direction, lane));
            let (hit, point) = first_in_the_way(scene, origin, direction);
            if hit == NONE {
                // Parallel rays have no direction to share with an environment.
                return scene.optics.skies.is_empty() || scene.sensor.is_finite();
            }
            !is_specular(scene, &scene.shapes.surfaces[scene.shapes.surface_of(hit) as usize])
                && !is_polished_at(scene, hit, point)
        })
    })
}

/// The first primitive that a ray meets which lets not all light straight on, or [`NONE`], and
/// where.
fn first_in_the_way<const N: usize>(
    scene: &Scene<N>,
    mut origin: Vec3,
    direction: Vec3,
) -> (u32, Vec3) {
    loop {
        let hit = scene.accelerator.closest(origin, direction, f32::INFINITY);
        let passes = scene.is_straight_on(hit.primitive)
            && !scene.material_at(hit.primitive).kind.is_specular();
        if !passes {
            return (hit.primitive, origin + hit.t * direction);
        }
        origin += direction * (hit.t + 1e-4);
    }
}
