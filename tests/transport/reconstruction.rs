//! Reconstruction filters, crops and the shape of pixels: against closed forms, by all integrators,
//! and against the whole.
//!
//! A z-test fails by chance where any of its scores exceeds 5.5, which a normal number does with a
//! chance of 4e-8; seeds are fixed. Each suite compares about 10,000 numbers, so that a change of
//! the random numbers is a false alarm in one of 2,500 cases.

use glam::{DAffine3, DVec3, Vec3};
use sunstone::internals::film::filter::{FilterKind, FilterSamples};
use sunstone::internals::film::layout::Crop;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, PlacedWorld};
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::world::{Bsdf, Geometry, Lens, Punctual};

use crate::support::rendering::{
    MONO, in_package, light_mask, scene, settings, spectral_replicates, world,
};
use crate::support::scenes::SCENES;
use crate::support::statistics::{Estimate, cells, estimate, mean_s0, rms, rms_limits, worst};

const LIMIT: f64 = 5.5;

/// The published formulas, up to a factor, where the library has its own tables.
fn formula(kind: FilterKind, radius: f64, x: f64) -> f64 {
    let x = x.abs();
    let pi = std::f64::consts::PI;
    if x >= radius {
        return 0.0;
    }
    let at = 2.0 * x / radius;
    match kind {
        FilterKind::Box => 1.0,
        FilterKind::Tent => radius - x,
        FilterKind::Gaussian => {
            let sigma = radius / 4.0;
            let of = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
            of(x) - of(radius)
        }
        FilterKind::Mitchell if at < 1.0 => 16.0 - 36.0 * at * at + 21.0 * at.powi(3),
        FilterKind::Mitchell => 32.0 - 60.0 * at + 36.0 * at * at - 7.0 * at.powi(3),
        FilterKind::CatmullRom if at < 1.0 => 2.0 - 5.0 * at * at + 3.0 * at.powi(3),
        FilterKind::CatmullRom => 4.0 - 8.0 * at + 5.0 * at * at - at.powi(3),
        FilterKind::Lanczos if x == 0.0 => 1.0,
        FilterKind::Lanczos => {
            let angle = 3.0 * pi * x / radius;
            3.0 * angle.sin() * (angle / 3.0).sin() / (angle * angle)
        }
    }
}

/// The share of a filter about `center` that lies before `edge`, by a sum over its formula, and its
/// magnitude there.
fn share_before(kind: FilterKind, radius: f64, center: f64, edge: f64) -> [f64; 2] {
    const STEPS: u32 = 20_000;
    let (mut before, mut all) = (0.0, 0.0);
    for step in 0..STEPS {
        let x = radius * ((2 * step + 1) as f64 / f64::from(STEPS) - 1.0);
        let value = formula(kind, radius, x);
        all += value;
        before += if center + x < edge { value } else { 0.0 };
    }
    let integral = all * 2.0 * radius / f64::from(STEPS);
    [before / all, formula(kind, radius, edge - center).abs() / integral]
}

const EDGE: u32 = 8;
/// Where the light ends, in pixels from the left and from the top; it begins beyond the film.
const ENDS: [f64; 2] = [3.3, 5.75];
const RADIANCE: f64 = 0.25;

/// A white sheet in parallel light before a black void, seen by parallel rays: a pixel is one unit.
fn sheet() -> PlacedWorld {
    let mut world = World::new("sheet");
    let white = world.add_material("white", Bsdf::diffuse(0.5)).unwrap();
    let half = f64::from(EDGE) / 2.0;
    let [right, bottom] = [ENDS[0] - half, half - ENDS[1]];
    let [left, top] = [-30.0, 30.0];
    let center = DVec3::new(0.5 * (left + right), 0.5 * (top + bottom), 0.0).as_vec3();
    let [u, v] = [0.5 * (right - left), 0.5 * (top - bottom)];
    let quad = Geometry::quad(center, Vec3::X * u as f32, Vec3::Y * v as f32);
    world.add_mesh("sheet", quad, white, DAffine3::IDENTITY).unwrap();
    let irradiance = (RADIANCE * std::f64::consts::PI / 0.5) as f32;
    world.add_light("sun", Punctual::directional(irradiance), DAffine3::IDENTITY).unwrap();
    let lens = Lens::Orthographic { half_width: half as f32, half_height: half as f32 };
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
    world.set_camera("camera", lens, place).unwrap();
    PlacedWorld::new(world).unwrap()
}

fn filtered(integrator: Integrator, mode: Mode, samples: u32, filter: FilterKind) -> Options {
    Options {
        width: Some(EDGE),
        height: Some(EDGE),
        filter: Some(filter),
        ..settings(integrator, mode, MONO, samples, 3)
    }
}

/// By all filters, of two widths, and all integrators, whether samples are shared or not: each
/// pixel is the share of its filter that the sheet covers, times its radiance. Light comes from
/// beyond the film, too.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn an_edge_is_convolved_with_the_filter() {
    const REPLICATES: u32 = 16;
    const SAMPLES: u32 = 64;
    const RARE: f64 = 0.01;
    let world = sheet();
    let mut scores = Vec::new();
    for kind in FilterKind::ALL {
        for radius in [kind.radius(), 1.25] {
            let share = |axis: usize, pixel: u32| {
                let center = f64::from(pixel) + 0.5;
                share_before(kind, f64::from(radius), center, ENDS[axis])
            };
            let [across, down] = [0, 1].map(|axis| (0..EDGE).map(|it| share(axis, it)).collect());
            let [across, down]: [Vec<[f64; 2]>; 2] = [across, down];
            let by_own = [None, Some(FilterSamples::Own)];
            let ways = Integrator::ALL.iter().flat_map(|it| by_own.map(|own| (it, own)));
            for (&integrator, filter_samples) in ways {
                let options = filtered(integrator, Mode::Scalar, SAMPLES, kind);
                let options = Options { filter_radius: Some(radius), filter_samples, ..options };
                let images = spectral_replicates(&world, &options, REPLICATES);
                for pixel in 0..(EDGE * EDGE) as usize {
                    let [x, y] = [pixel % EDGE as usize, pixel / EDGE as usize];
                    let ([of_x, at_x], [of_y, at_y]) = (across[x], down[y]);
                    let expected = RADIANCE * of_x * of_y;
                    let found = estimate(&images, 0, &[pixel]);
                    let way = format!("{integrator:?}, {filter_samples:?}");
                    let what = format!("{} {radius}, {way}, {x} {y}", kind.name());
                    // Paths from the lamp count for one pixel: where that is hardly ever this one,
                    // the spread of those that came says nothing of those that did not.
                    let is_rare = integrator.splats() && expected.abs() < RARE * RADIANCE;
                    // Samples that are shared lie in strata: that the edge is a sample farther
                    // may be rarer than these replicates are many. It weighs twice the filter
                    // there at most.
                    let is_shared = filter_samples.is_none();
                    let sample = RADIANCE / f64::from(SAMPLES);
                    let at_edge = 2.0 * sample * (at_x * of_y.abs() + at_y * of_x.abs());
                    let margin = if is_shared { at_edge } else { 0.0 };
                    let nearest = found.mean.clamp(expected - margin, expected + margin);
                    match found.score(&Estimate::exact(nearest), RADIANCE) {
                        Some(score) if !is_rare => {
                            assert!(score.abs() < LIMIT, "{what}: {found:?}, not {expected}");
                            scores.extend((!is_shared).then_some(score));
                        }
                        // All have met the edge alike, as strata do: to a sample, but for one
                        // case in 10,000.
                        Some(_) | None => {
                            let error = (found.mean - expected).abs();
                            assert!(
                                error < 1.5 * RADIANCE / f64::from(SAMPLES),
                                "{what}: {found:?} {expected}"
                            );
                        }
                    }
                }
            }
        }
    }
    let [least, most] = rms_limits(scores.len());
    println!("{} scores, rms {:.3}, worst {:.2}", scores.len(), rms(&scores), worst(&scores));
    assert!(rms(&scores) < most && rms(&scores) > 0.5 * least, "rms {}", rms(&scores));
}

/// In scenes of all kinds of lamps and lenses, with much light from beyond the film, all
/// integrators find the same, polarized and not, as do strategies that are weighed against each
/// other, and samples that are each pixel's own.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_by_any_filter() {
    const NAMES: [&str; 5] = [
        "one-sided panel, pinhole",
        "two-sided panel, lens",
        "spot light, lens",
        "environment, lens",
        "fog about a point light",
    ];
    const REPLICATES: u32 = 32;
    const CELL: usize = 2;
    let mut all = Vec::new();
    for (index, name) in NAMES.into_iter().enumerate() {
        let (_, make) = SCENES.iter().find(|(known, _)| *known == name).expect("it is there");
        let sees_all = light_mask(&scene::<1>(&make(), MONO, [EDGE; 2])).iter().all(|it| *it);
        let world = PlacedWorld::new(make()).unwrap();
        let kinds = [FilterKind::Mitchell, FilterKind::Gaussian, FilterKind::Lanczos];
        let (kind, mode) = (kinds[index % 3], [Mode::Polarized, Mode::Scalar][index % 2]);
        let of = |(integrator, filter_samples)| {
            let plain = filtered(integrator, mode, 32, kind);
            let options = Options { path_length_max: 5, filter_samples, ..plain };
            spectral_replicates(&world, &options, REPLICATES)
        };
        let [shared, own] = [None, Some(FilterSamples::Own)];
        let mut ways =
            vec![(Integrator::Path, shared), (Integrator::Bdpt, shared), (Integrator::Path, own)];
        if sees_all {
            ways.push((Integrator::Light, own));
        }
        let images: Vec<Vec<StokesImage>> = ways.iter().map(|it| of(*it)).collect();
        for (one, other) in [(0, 1), (0, 2), (0, 3), (1, 3)] {
            let (Some(one_of), Some(others)) = (images.get(one), images.get(other)) else {
                continue;
            };
            let what = format!("{name}, {:?} and {:?}", ways[one], ways[other]);
            let s0 = mean_s0(&one_of[0]);
            let mut scores = Vec::new();
            let cells = cells(EDGE as usize, EDGE as usize, CELL, &[true; (EDGE * EDGE) as usize]);
            for plane in 0..mode.components() {
                for cell in &cells {
                    let [one, other] = [one_of, others].map(|images| estimate(images, plane, cell));
                    scores.extend(one.score(&other, s0));
                }
            }
            println!("{what}: rms {:.3}, worst {:.2}", rms(&scores), worst(&scores));
            assert!(worst(&scores) < LIMIT, "{what}: {}", worst(&scores));
            all.extend(scores);
        }
    }
    let [least, most] = rms_limits(all.len());
    assert!((least..most).contains(&rms(&all)), "rms {} of {}", rms(&all), all.len());
}

/// By all integrators, filters with and without lobes, and modes: the pixels of a crop have the
/// bits that they have in the whole image.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn crops_are_parts_of_the_whole() {
    const SIZE: [u32; 2] = [36, 19];
    const ENDS: [u32; 4] = [7, 3, 35, 18];
    let (_, make) = SCENES.iter().find(|(name, _)| *name == "spot light, lens").unwrap();
    let world = PlacedWorld::new(make()).unwrap();
    for (index, &integrator) in Integrator::ALL.iter().enumerate() {
        for (kind, mode) in [
            (FilterKind::Box, Mode::Polarized),
            (FilterKind::Mitchell, Mode::Scalar),
            (FilterKind::Gaussian, Mode::Polarized),
        ] {
            let options = Options {
                width: Some(SIZE[0]),
                height: Some(SIZE[1]),
                filter: Some(kind),
                replicates: 1 + index as u32 % 2,
                ..settings(integrator, mode, MONO, 2, 3)
            };
            let whole = &spectral_replicates(&world, &options, 1)[0];
            let options = Options { crop: Some(Crop::Pixels(ENDS)), ..options };
            let crop = &spectral_replicates(&world, &options, 1)[0];
            let what = format!("{integrator:?}, {}", kind.name());
            let [x0, y0, x1, y1] = ENDS.map(|end| end as usize);
            assert_eq!([crop.width, crop.height], [x1 - x0, y1 - y0], "{what}");
            let cut_out = |planes: &[Vec<f32>]| -> Vec<Vec<f32>> {
                let row = |plane: &[f32], y: usize| plane[y * SIZE[0] as usize..][x0..x1].to_vec();
                let of = |plane: &Vec<f32>| (y0..y1).flat_map(|y| row(plane, y)).collect();
                planes.iter().map(of).collect()
            };
            assert_eq!(crop.planes, cut_out(&whole.planes), "{what}");
            assert!(crop.planes[0].iter().any(|it| *it != 0.0), "{what} is black");
            let of_whole = whole.variance.as_ref().map(|planes| cut_out(planes));
            assert_eq!(crop.variance, of_whole, "{what}");
            assert_eq!(crop.metadata("crop"), Some("7,3,35,18 of 36 x 19"), "{what}");
        }
    }
}

/// In scenes of media, glass and all materials, in RGB, too: what else is in a chunk changes no bit
/// of a path.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn crops_of_whole_scenes_are_parts_of_them() {
    const SIZE: [u32; 2] = [40, 30];
    const ENDS: [u32; 4] = [7, 11, 30, 25];
    for (name, integrators) in
        [("tank.gltf", Integrator::ALL), ("materials.glb", &[Integrator::Path][..])]
    {
        let world = PlacedWorld::new(world(&in_package("scenes").join(name))).unwrap();
        for &integrator in integrators {
            let options = Options {
                width: Some(SIZE[0]),
                height: Some(SIZE[1]),
                ..settings(integrator, Mode::Polarized, Color::Rgb, 16, 3)
            };
            let cropped = Options { crop: Some(Crop::Pixels(ENDS)), ..options.clone() };
            let [whole, crop] = [options, cropped]
                .map(|options| spectral_replicates(&world, &options, 1).swap_remove(0));
            let [x0, y0, x1, y1] = ENDS.map(|end| end as usize);
            for (plane, (whole, crop)) in whole.planes.iter().zip(&crop.planes).enumerate() {
                let rows = (y0..y1).map(|y| &whole[y * SIZE[0] as usize..][x0..x1]);
                let expected: Vec<f32> = rows.flatten().copied().collect();
                assert!(expected == *crop, "{name}, {integrator:?}, plane {plane}");
            }
        }
    }
}

/// A film of pixels twice as wide as high sees what one of square pixels sees: each of them two of
/// these. By rays, and by connections.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn wide_pixels_are_pairs_of_square_ones() {
    for name in ["spot light, lens", "fog fills the scene, orthographic"] {
        let (_, make) = SCENES.iter().find(|(known, _)| *known == name).unwrap();
        let world = PlacedWorld::new(make()).unwrap();
        for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Light] {
            let square = Options {
                width: Some(16),
                height: Some(8),
                ..settings(integrator, Mode::Scalar, MONO, 64, 4)
            };
            let seed = square.seed + 1000;
            let wide = Options { width: Some(8), pixel_aspect: Some(2.0), seed, ..square.clone() };
            let [square, wide] = [square, wide].map(|it| spectral_replicates(&world, &it, 24));
            let mut scores = Vec::new();
            for pixel in 0..64 {
                let [x, y] = [pixel % 8, pixel / 8];
                let pair = [16 * y + 2 * x, 16 * y + 2 * x + 1];
                let [one, other] = [estimate(&wide, 0, &[pixel]), estimate(&square, 0, &pair)];
                scores.extend(one.score(&other, mean_s0(&wide[0])));
            }
            println!("{name}, {integrator:?}: {} {:.2}", scores.len(), worst(&scores));
            assert!(worst(&scores) < LIMIT, "{name}, {integrator:?}: {}", worst(&scores));
            assert!(scores.len() > 20, "{name}, {integrator:?}: {} scores", scores.len());
            assert_eq!(wide[0].metadata("pixel aspect"), Some("2"));
        }
    }
}
