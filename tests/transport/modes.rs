//! Both modes trace the same paths, and no number of threads changes a bit.

use std::sync::Arc;

use rayon::ThreadPoolBuilder;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons, Renderer, Settings};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::internals::transport::Sampling;

use crate::support::rendering::{
    MONO, image, in_package, light_mask, rendered, scene, settings, world,
};
use crate::support::scenes::depolarizers;
use crate::support::statistics::cells;

const INTEGRATORS: [Integrator; 4] =
    [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm];

fn reference_scene(name: &str) -> World {
    world(&in_package(&format!("scenes/reference/{name}.gltf")))
}

fn assert_same_bits(first: &[f32], second: &[f32], what: &str) {
    let differ = first.iter().zip(second).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    assert_eq!(differ, 0, "{what}: {differ} of {} values differ", first.len());
}

/// One image in each mode from the same random numbers, and of the same paths.
fn both_modes<const N: usize>(scene: &Arc<Scene<N>>, settings: &Options) -> [StokesImage; 2] {
    let settings = Options { sampling: Sampling::Intensity, ..settings.clone() };
    [Mode::Scalar, Mode::Polarized].map(|mode| image(scene, &Options { mode, ..settings.clone() }))
}

/// Without a polarizing event there is no carrier, and intensities are the same operations.
#[test]
fn depolarizers_give_the_same_bits_in_both_modes() {
    fn check<const N: usize>(color: Color) {
        let scene = scene::<N>(&depolarizers(), color.clone(), [40, 24]);
        for integrator in INTEGRATORS {
            let settings = settings(integrator, Mode::Scalar, color.clone(), 24, 6);
            // Roulette, too, must play alike.
            let [scalar, polarized] =
                both_modes(&scene, &Options { roulette_after: Some(3), ..settings.clone() });
            assert!(scalar.planes[0].iter().any(|&value| value > 0.0));
            for plane in 0..N {
                let what = format!("{integrator:?}, {N} wavelengths");
                assert_same_bits(&scalar.planes[plane], &polarized.planes[plane], &what);
            }
            for plane in &polarized.planes[N..] {
                assert!(plane.iter().all(|&value| value == 0.0), "{integrator:?} polarizes");
            }
        }
    }
    check::<1>(MONO);
    check::<3>(Color::Rgb);
}

/// Paths of two segments from pixels that see no sphere meet none.
#[test]
fn pixels_without_polarizing_events_have_the_same_bits_in_both_modes() {
    let scene = scene::<1>(&reference_scene("cornell"), MONO, [64, 64]);
    let mask = light_mask(&scene);
    assert!(mask.iter().filter(|&&clear| clear).count() > 2_000);
    for integrator in INTEGRATORS {
        let images = both_modes(&scene, &settings(integrator, Mode::Scalar, MONO, 32, 2));
        let [scalar, polarized] = images.map(|image| {
            let pixels = image.planes[0].iter().zip(&mask).filter(|(_, clear)| **clear);
            pixels.map(|(&value, _)| value).collect::<Vec<f32>>()
        });
        assert_same_bits(&scalar, &polarized, &format!("{integrator:?}"));
    }
}

/// The difference of the modes at one seed, and at two: the former is the effect of polarization
/// with hardly any noise, at most a tenth of the variance of the latter. Over means of 4 x 4
/// pixels and 32 pairs of seeds.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn modes_share_their_noise() {
    const PAIRS: u32 = 32;
    for (name, integrator) in [
        ("cornell", Integrator::Path),
        ("cornell", Integrator::Light),
        ("cornell", Integrator::Bdpt),
        ("mirror", Integrator::Path),
        ("mirror", Integrator::Bdpt),
        ("cornell", Integrator::Ppm),
        ("rayleigh", Integrator::Path),
        ("rayleigh", Integrator::Bdpt),
    ] {
        let scene = scene::<1>(&reference_scene(name), MONO, [32, 32]);
        let pairs: Vec<[StokesImage; 2]> = (0..PAIRS)
            .map(|pair| {
                let settings = settings(integrator, Mode::Scalar, MONO, 32, 8);
                both_modes(&scene, &Options { seed: settings.seed + pair, ..settings.clone() })
            })
            .collect();
        let (mut same, mut other) = (0.0, 0.0);
        for cell in cells(32, 32, 4, &[true; 32 * 32]) {
            let sum = |image: &StokesImage| {
                cell.iter().map(|&pixel| f64::from(image.planes[0][pixel])).sum::<f64>()
            };
            let next = |pair: usize| &pairs[(pair + 1) % pairs.len()];
            let differences = |partner: &dyn Fn(usize) -> f64| {
                (0..pairs.len()).map(|pair| sum(&pairs[pair][1]) - partner(pair)).collect()
            };
            same += spread(differences(&|pair| sum(&pairs[pair][0])));
            other += spread(differences(&|pair| sum(&next(pair)[0])));
        }
        println!("{name}, {integrator:?}: {:.1} times less variance", other / same);
        assert!(same > 0.0, "{name}: polarization has no effect");
        assert!(10.0 * same < other, "{name}, {integrator:?}: {same} against {other}");
    }
}

/// A film of intensities measures S0 of the polarized film: the same paths, and of every sum of
/// products those terms that reach the first row.
#[test]
fn intensity_is_the_first_stokes_component() {
    for name in ["cornell", "mirror", "tank", "rayleigh", "polarizers"] {
        let scene = scene::<3>(&reference_scene(name), Color::Rgb, [40, 24]);
        for integrator in INTEGRATORS {
            let settings = settings(integrator, Mode::Polarized, Color::Rgb, 16, 8);
            // Where rounding cannot choose another path.
            let settings = Options { sampling: Sampling::Intensity, ..settings.clone() };
            let polarized = image(&scene, &settings);
            let intensity = image(&scene, &Options { mode: Mode::Intensity, ..settings.clone() });
            assert_eq!((intensity.components, intensity.planes.len()), (1, 3));
            let scalar = image(&scene, &Options { mode: Mode::Scalar, ..settings.clone() });
            let brightest = polarized.planes[..3].iter().flatten().fold(0.0, |a: f32, b| a.max(*b));
            let mut effect = 0.0_f32;
            for plane in 0..3 {
                let pixels = polarized.planes[plane].iter().zip(&intensity.planes[plane]);
                for ((a, b), c) in pixels.zip(&scalar.planes[plane]) {
                    // Rounding: relative to the pixel, and to what cancels in it.
                    let most = 1e-5 * a.abs() + 1e-7 * brightest;
                    assert!((a - b).abs() <= most, "{name}, {integrator:?}: {a} {b}");
                    effect = effect.max((a - c).abs() / brightest);
                }
            }
            println!("{name}, {integrator:?}: polarization changes up to {effect:.1e}");
            // Light paths reach no sensor through glass or polarizers.
            assert!(integrator == Integrator::Light || effect > 1e-5, "{name}, {integrator:?}");
        }
    }
}

/// Sum of squared deviations from the mean.
fn spread(values: Vec<f64>) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

/// Sums over pixels have one owner and a fixed order. 40 x 24 pixels are tiles of three sizes,
/// and 39 iterations fill neither their chunks nor their waves; photons come in three batches.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn threads_change_no_bit() {
    for name in ["cornell", "mirror", "tank", "rayleigh"] {
        let scene = scene::<3>(&reference_scene(name), Color::Rgb, [40, 24]);
        for integrator in INTEGRATORS {
            for mode in [Mode::Scalar, Mode::Intensity, Mode::Polarized] {
                let settings = settings(integrator, mode, Color::Rgb, 39, 8);
                let photons = Photons {
                    per_iteration: Some(40_000),
                    samples: Some(13),
                    ..Photons::default()
                };
                let settings =
                    Options { replicates: 3, roulette_after: Some(4), photons, ..settings.clone() };
                let with_threads = |threads: usize| {
                    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
                    pool.expect("threads start").install(|| image(&scene, &settings))
                };
                let alone = with_threads(1);
                for threads in [2, 3, 8] {
                    let what = format!("{name}, {integrator:?}, {mode:?}, {threads} threads");
                    let together = with_threads(threads);
                    let planes = |image: &StokesImage| image.planes.concat();
                    assert_same_bits(&planes(&alone), &planes(&together), &what);
                    let variance = |image: &StokesImage| {
                        image.variance.as_ref().expect("three replicates").concat()
                    };
                    assert_same_bits(&variance(&alone), &variance(&together), &what);
                }
            }
        }
    }
}

/// A render that is stepped while another runs between its steps is the render in one go; and
/// photons are merged within the same radii in both modes.
#[test]
fn stepping_changes_no_bit() {
    let scene = scene::<3>(&world(&in_package("scenes/tank.gltf")), Color::Rgb, [24, 16]);
    let photons = Photons { per_iteration: Some(2000), samples: Some(4), ..Photons::default() };
    let sampling = Sampling::Intensity;
    for integrator in [Integrator::Ppm, Integrator::Bdpt] {
        // Three iterations of photons, or three waves without.
        let iterations = if integrator == Integrator::Ppm { 12 } else { 48 };
        let of = |mode| Options {
            photons,
            sampling,
            ..settings(integrator, mode, Color::Rgb, iterations, 8)
        };
        let both = [of(Mode::Scalar), of(Mode::Polarized)];
        let mut renderers = both.clone().map(|options| {
            let settings = Settings::new(options).expect("fit to each other");
            Renderer::of(Arc::clone(&scene), &settings)
        });
        let mut radii: Vec<Vec<f32>> = Vec::new();
        for _ in 0..3 {
            renderers.iter_mut().for_each(Renderer::step);
            let [scalar, polarized] = renderers.each_ref().map(Renderer::radii);
            assert_eq!(scalar, polarized, "{integrator:?}");
            radii.push(scalar.into_iter().flatten().collect());
        }
        let shrink = radii.windows(2).all(|pair| pair[0].iter().zip(&pair[1]).all(|(a, b)| a > b));
        assert!(shrink, "{radii:?}");
        assert_eq!(radii[0].len(), if integrator == Integrator::Ppm { 2 } else { 0 });
        for (stepped, options) in renderers.into_iter().zip(&both) {
            let whole = rendered(&scene, options);
            assert_eq!(stepped.samples(), whole.samples(), "{integrator:?}");
            let [profile, expected] = [stepped.profile(), whole.profile()];
            assert_eq!(profile.photons, expected.photons, "{integrator:?}");
            assert_eq!(profile.rays_closest, expected.rays_closest, "{integrator:?}");
            let (stepped, whole) = (stepped.finish(), whole.finish());
            for (stepped, whole) in stepped.planes.iter().zip(&whole.planes) {
                assert_same_bits(stepped, whole, &format!("{integrator:?}"));
            }
        }
    }
}
