//! Variances that an image states of itself, against those between images of other seeds.

use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, in_package, replicates, scene, settings, world};

const SIZE: [u32; 2] = [24, 24];
const SEEDS: u32 = 64;

fn cornell() -> Arc<Scene<1>> {
    scene::<1>(&world(&in_package("scenes/cornell.gltf")), MONO, SIZE)
}

fn options(integrator: Integrator, samples: u32) -> Options {
    let photons = Photons { per_iteration: Some(2_000), samples: Some(1), ..Photons::default() };
    let settings = settings(integrator, Mode::Scalar, MONO, samples, 6);
    Options { photons, variance: true, ..settings }
}

/// Of every pixel, the variance between images.
fn between(images: &[StokesImage]) -> Vec<f64> {
    let count = images.len() as f64;
    let of = |pixel: usize| {
        let values = || images.iter().map(|image| f64::from(image.planes[0][pixel]));
        let mean = values().sum::<f64>() / count;
        values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)
    };
    (0..images[0].planes[0].len()).map(of).collect()
}

/// The median over the pixels of stated over true variance. Of 64 images, the latter is good to
/// 18 % in a pixel, hence to 1 % in the median of 576.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn stated_variances_are_true_ones() {
    let scene = cornell();
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        let counts: &[u32] = if integrator.shoots_photons() { &[64] } else { &[8, 64, 100] };
        for &samples in counts {
            let images = replicates(&scene, &options(integrator, samples), SEEDS);
            let stated = |pixel: usize| {
                let of =
                    |image: &StokesImage| f64::from(image.variance.as_ref().unwrap()[0][pixel]);
                images.iter().map(of).sum::<f64>() / f64::from(SEEDS)
            };
            let pixels = between(&images).into_iter().enumerate().filter(|(_, it)| *it > 0.0);
            let mut ratios: Vec<f64> = pixels.map(|(pixel, it)| stated(pixel) / it).collect();
            assert!(ratios.len() > 500, "{} pixels have noise", ratios.len());
            ratios.sort_by(f64::total_cmp);
            let ratio = ratios[ratios.len() / 2];
            eprintln!("{integrator:?}, {samples} samples: stated over true {ratio:.3}");
            assert!((0.9..1.5).contains(&ratio), "{integrator:?}, {samples} samples: {ratio}");
        }
    }
}

/// A lamp over a field under a dim sky, from above: pixels hold its edges or next to no noise.
fn field() -> World {
    let mut scene = Document::default();
    let ground = scene.diffuse(0.5);
    scene.quad(Vec3::ZERO, 20.0 * Vec3::Z, 20.0 * Vec3::X, ground);
    let glow = scene.material(json!({"bsdf": "absorber"}));
    let glow = scene.emits(glow, 100.0);
    scene.quad(Vec3::Y, 0.1 * Vec3::X, 0.1 * Vec3::Z, glow);
    scene.environment(0.02);
    scene.up(Vec3::Z);
    scene.perspective(3.0 * Vec3::Y, Vec3::ZERO, 0.3, None);
    scene.load("field")
}

/// Over the whole image: there the error of a sequence falls so fast that its blocks tell 20 times
/// the variance. What is left of that at most is twice, where noise may explain it. Of 64 images,
/// the sums are good to some percent.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn stated_variances_are_true_ones_where_pixels_are_smooth() {
    let scene = scene::<1>(&field(), MONO, SIZE);
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        let images = replicates(&scene, &options(integrator, 64), SEEDS);
        let of = |image: &StokesImage| {
            let variances = &image.variance.as_ref().unwrap()[0];
            variances.iter().map(|&variance| f64::from(variance)).sum::<f64>()
        };
        let stated = images.iter().map(of).sum::<f64>() / f64::from(SEEDS);
        let ratio = stated / between(&images).iter().sum::<f64>();
        eprintln!("{integrator:?}: stated over true {ratio:.3}");
        assert!((0.9..2.0).contains(&ratio), "{integrator:?}: {ratio}");
    }
}

/// The samples are the same, and only sums of them are rounded in another order.
#[test]
fn variances_cost_the_image_nothing() {
    let scene = cornell();
    for &integrator in Integrator::ALL {
        let with = image(&scene, &options(integrator, 24));
        let without = image(&scene, &Options { variance: false, ..options(integrator, 24) });
        assert!(without.variance.is_none());
        assert!(with.variance.is_some_and(|planes| planes[0].iter().any(|it| *it > 0.0)));
        for (a, b) in with.planes[0].iter().zip(&without.planes[0]) {
            assert!((a - b).abs() <= 1e-5 * b.abs(), "{integrator:?}: {a} {b}");
        }
    }
}
