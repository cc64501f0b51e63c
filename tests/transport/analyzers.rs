//! Films behind ideal analyzers: against the Stokes film, against sheets before the lens, and
//! against closed forms.

use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use sunstone::Analyzer;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::internals::transport::Sampling;

use crate::support::filters::FILTERS;
use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, replicates, scene, settings};
use crate::support::scenes::SCENES;
use crate::support::statistics::{Estimate, cells, estimate, mean_s0, worst};

const ALL: [Analyzer; 5] = [
    Analyzer::Linear { axis_deg: 0.0 },
    Analyzer::Linear { axis_deg: 110.0 },
    Analyzer::Linear { axis_deg: 45.0 },
    Analyzer::RightCircular,
    Analyzer::LeftCircular,
];

fn analyzed(mut world: World, analyzer: Analyzer) -> World {
    world.set_analyzer(Some(analyzer)).expect("it has a camera and an axis");
    world
}

/// Every scene of the suite, whatever its camera, by two integrators, another pair in every second:
/// the image of the Stokes film
/// behind the analyzer, as the same paths are traced; and half of the scalar image, to the bit.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn a_film_behind_an_analyzer_is_the_stokes_film_behind_it() {
    const SIZE: [u32; 2] = [12, 8];
    let (mut polarized, mut renders) = (0, 0);
    let all = SCENES.iter().chain(&FILTERS).enumerate();
    for (index, (name, make)) in all {
        let analyzer = ALL[index % ALL.len()];
        let bare = scene::<3>(&make(), Color::Rgb, SIZE);
        let behind = scene::<3>(&analyzed(make(), analyzer), Color::Rgb, SIZE);
        for &integrator in Integrator::ALL.iter().skip(index % 2).step_by(2) {
            let options = Options {
                sampling: Sampling::Intensity,
                roulette_after: Some(3),
                ..settings(integrator, Mode::Polarized, Color::Rgb, 8, 6)
            };
            let what = format!("{name}, {integrator:?}, {analyzer}");
            let whole = image(&bare, &options);
            let film = image(&behind, &options);
            let expected = whole.behind(analyzer).expect("it has polarization");
            if integrator == Integrator::Bdpt {
                assert_alike_on_average((&behind, &bare), &options, analyzer, &what);
            } else {
                let differ = unlike(&film, &expected, &whole, &what);
                assert_eq!(differ, 0, "{what}");
            }
            polarized += u32::from(whole.planes[3..].iter().flatten().any(|it| *it != 0.0));
            renders += 1;
            let intensity = image(&behind, &Options { mode: Mode::Intensity, ..options.clone() });
            assert_eq!(intensity.planes, film.planes[..3], "{what}");
            let options = Options { mode: Mode::Scalar, ..options.clone() };
            let [half, scalar] = [&behind, &bare].map(|scene| image(scene, &options));
            let halved = |plane: &Vec<f32>| plane.iter().map(|it| 0.5 * it).collect();
            let expected: Vec<Vec<f32>> = scalar.planes.iter().map(halved).collect();
            assert_eq!(half.planes, expected, "{what}");
        }
    }
    println!("{renders} renders, {polarized} of polarized light");
    assert!(3 * polarized > renders);
}

/// How many values differ by more than rounding, relative to what reaches the film and cancels
/// there.
fn unlike(film: &StokesImage, expected: &StokesImage, whole: &StokesImage, what: &str) -> usize {
    assert_eq!(film.shape(), expected.shape(), "{what}");
    let brightest = whole.planes[..3].iter().flatten().fold(0.0, |a: f32, b| a.max(*b));
    let of_plane = |plane: usize| {
        let pixels = film.planes[plane].iter().zip(&expected.planes[plane]);
        let pixels = pixels.zip(&whole.planes[plane % 3]);
        let differs = |((found, expected), s0): &((&f32, &f32), &f32)| {
            (*found - *expected).abs() > 1e-5 * s0.abs() + 1e-7 * brightest
        };
        pixels.filter(differs).count()
    };
    (0..film.planes.len()).map(of_plane).sum()
}

/// Connections of `bdpt` that bring little are made as seldom as they bring less beside others,
/// which is another thing behind an analyzer: means over the film agree, paired by their seeds.
fn assert_alike_on_average(
    (behind, bare): (&Arc<Scene<3>>, &Arc<Scene<3>>),
    options: &Options,
    analyzer: Analyzer,
    what: &str,
) {
    const SEEDS: u32 = 8;
    let [films, wholes] = [behind, bare].map(|scene| replicates(scene, options, SEEDS));
    let s0 = mean_s0(&wholes[0]);
    let pairs = films.iter().zip(&wholes);
    let differences: Vec<f64> = pairs
        .map(|(film, whole)| mean_s0(film) - mean_s0(&whole.behind(analyzer).expect("polarized")))
        .collect();
    let score = Estimate::of(&differences).score(&Estimate::exact(0.0), s0).unwrap_or(0.0);
    assert!(score.abs() < 5.0, "{what}: {differences:?} of {s0}");
}

/// A lamp of radiance 2 behind filters, before an orthographic camera that looks along -z.
fn lamp_behind(filters: &[serde_json::Value]) -> World {
    let mut scene = Document::default();
    let lamp = scene.material(json!({"bsdf": "absorber"}));
    let lamp = scene.emits(lamp, 2.0);
    scene.quad(Vec3::ZERO, 2.0 * Vec3::X, 2.0 * Vec3::Y, lamp);
    for (index, filter) in filters.iter().enumerate() {
        let filter = scene.material(filter.clone());
        let center = Vec3::Z * (0.5 + 0.1 * index as f32);
        scene.quad(center, 2.0 * Vec3::X, 2.0 * Vec3::Y, filter);
    }
    scene.orthographic(3.0 * Vec3::Z, Vec3::ZERO, 0.9);
    scene.load("lamp behind filters")
}

/// Malus: of light polarized along b, cos^2(a - b) passes an analyzer at a, and it is polarized
/// along a. Of circular light of either hand, all or nothing passes one of them.
#[test]
fn malus() {
    let polarizer = json!({"bsdf": "polarizer", "axis_deg": 20});
    // The fast axis 45 degrees ahead of the light's: right circular, or left where it is behind.
    let plate =
        |axis_deg: f64| json!({"bsdf": "retarder", "axis_deg": axis_deg, "retardance_deg": 90});
    let linear = |axis_deg: f64| Analyzer::Linear { axis_deg };
    let share = |degrees: f64| degrees.to_radians().cos().powi(2);
    let straight = || lamp_behind(std::slice::from_ref(&polarizer));
    let circular = |axis_deg| lamp_behind(&[polarizer.clone(), plate(axis_deg)]);
    let cases = [
        (straight(), linear(20.0), 1.0),
        (straight(), linear(110.0), 0.0),
        (straight(), linear(50.0), share(30.0)),
        (straight(), linear(-55.0), share(75.0)),
        (straight(), Analyzer::RightCircular, 0.5),
        (circular(65.0), Analyzer::RightCircular, 1.0),
        (circular(65.0), Analyzer::LeftCircular, 0.0),
        (circular(-25.0), Analyzer::LeftCircular, 1.0),
        (circular(-25.0), linear(77.0), 0.5),
    ];
    for (world, analyzer, passes) in cases {
        let scene = scene::<1>(&analyzed(world, analyzer), MONO, [5, 4]);
        // What can see a lamp straight ahead by parallel rays.
        for integrator in [Integrator::Path, Integrator::Ppm, Integrator::Bdpt] {
            let image = image(&scene, &settings(integrator, Mode::Polarized, MONO, 16, 4));
            let state = analyzer.state().0;
            for (plane, state) in image.planes.iter().zip(state) {
                for &value in plane {
                    let error = f64::from(value) - passes * state;
                    assert!(error.abs() < 2e-6, "{integrator:?}, {analyzer}: {value} {passes}");
                }
            }
        }
    }
}

/// The bench of this file: balls of glass and metal under a panel, or thin air about a lamp, and
/// filters before a narrow pinhole, so that their axes are those of the film within 1e-3.
fn bench(is_air: bool, filters: &[serde_json::Value]) -> World {
    let mut scene = Document::default();
    if is_air {
        let lamp = json!({"type": "spot", "intensity": 40.0,
            "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.6}});
        scene.light(lamp, Vec3::new(0.3, 1.6, 0.0), Vec3::new(-0.2, -1.0, 0.1));
        let air = scene.medium(json!({"phase": "rayleigh", "sigma_a": 0.0, "sigma_s": 0.4}));
        scene.fog(air, |scene, null| scene.cuboid(Vec3::ZERO, 0.6 * Vec3::ONE, null));
    } else {
        let panel = scene.material(json!({"bsdf": "absorber"}));
        let panel = scene.emits(panel, 5.0);
        scene.quad(Vec3::new(0.5, 1.5, 0.5), 0.8 * Vec3::X, 0.8 * Vec3::Z, panel);
        let metal = scene.material(json!({"bsdf": "conductor", "eta": 1.5, "k": 2.0}));
        scene.sphere(Vec3::new(-0.12, 0.0, 0.0), 0.11, metal);
        let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
        scene.sphere(Vec3::new(0.12, -0.02, 0.0), 0.11, glass);
    }
    let wall = scene.diffuse(0.6);
    scene.quad(-Vec3::Z, 2.0 * Vec3::X, 2.0 * Vec3::Y, wall);
    for (index, filter) in filters.iter().enumerate() {
        let filter = scene.material(filter.clone());
        let center = Vec3::Z * (7.8 + 0.05 * index as f32);
        scene.quad(center, 0.1 * Vec3::X, 0.1 * Vec3::Y, filter);
    }
    scene.perspective(8.0 * Vec3::Z, Vec3::ZERO, 0.05, None);
    scene.load("bench")
}

/// A sheet, or a wave plate with a sheet, before the lens lets pass what the analyzer does: means
/// over cells agree within noise, drawn by Stokes vectors and from other seeds. Behind the sheet S0
/// alone is compared where the plate turns the frame of what is left.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn sheets_before_the_lens_pass_the_same() {
    const SIZE: [u32; 2] = [8, 8];
    const COUNT: u32 = 12;
    let sheet = |axis_deg: f64| json!({"bsdf": "polarizer", "axis_deg": axis_deg});
    let plate = json!({"bsdf": "retarder", "axis_deg": 0, "retardance_deg": 90});
    let cases = [
        (Analyzer::Linear { axis_deg: 30.0 }, vec![sheet(30.0)], 4),
        (Analyzer::Linear { axis_deg: 100.0 }, vec![sheet(100.0)], 4),
        (Analyzer::RightCircular, vec![plate.clone(), sheet(45.0)], 1),
        (Analyzer::LeftCircular, vec![plate, sheet(-45.0)], 1),
    ];
    let of_air = [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm];
    let of_balls = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];
    let mut scores = Vec::new();
    for (analyzer, filters, components) in cases {
        for (is_air, integrators) in [(true, &of_air[..]), (false, &of_balls)] {
            let film = scene::<1>(&analyzed(bench(is_air, &[]), analyzer), MONO, SIZE);
            let sheets = scene::<1>(&bench(is_air, &filters), MONO, SIZE);
            for &integrator in integrators {
                let options = settings(integrator, Mode::Polarized, MONO, 16, 6);
                let found = replicates(&film, &options, COUNT);
                let other = Options { seed: options.seed + 0x00ff_0000, ..options.clone() };
                let expected = replicates(&sheets, &other, COUNT);
                let s0 = mean_s0(&expected[0]);
                assert!(s0 > 0.0);
                for cell in cells(8, 8, 4, &[true; 64]) {
                    let of = |images: &[StokesImage], plane| estimate(images, plane, &cell);
                    let score = |plane| of(&found, plane).score(&of(&expected, plane), 50.0 * s0);
                    scores.extend((0..components).filter_map(score));
                }
            }
        }
    }
    println!("{} scores, the worst {:.2}", scores.len(), worst(&scores));
    assert!(scores.len() > 150 && worst(&scores) < 4.5);
}

/// The variance that an image states is that between images, of every component, and not what the
/// variances of the Stokes film would suggest.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn variances_are_those_behind_the_analyzer() {
    const COUNT: u32 = 96;
    let sum = |values: &[f32]| values.iter().map(|it| f64::from(*it)).sum::<f64>();
    for sampling in Sampling::ALL {
        let analyzer = Analyzer::Linear { axis_deg: 100.0 };
        let bare = scene::<1>(&bench(true, &[]), MONO, [6, 6]);
        let film = scene::<1>(&analyzed(bench(true, &[]), analyzer), MONO, [6, 6]);
        let of = |scene: &Arc<Scene<1>>| {
            let options = settings(Integrator::Bdpt, Mode::Polarized, MONO, 64, 6);
            let options = Options { replicates: 8, variance: true, sampling, ..options.clone() };
            replicates(scene, &options, COUNT)
        };
        let images = of(&film);
        let stated = |image: &StokesImage, plane: usize| {
            sum(&image.variance.as_ref().expect("there are replicates")[plane])
        };
        let between: f64 = (0..36)
            .map(|pixel| {
                let values = images.iter().map(|image| f64::from(image.planes[0][pixel]));
                let values: Vec<f64> = values.collect();
                let mean = values.iter().sum::<f64>() / f64::from(COUNT);
                let squares: f64 = values.iter().map(|it| (it - mean).powi(2)).sum();
                squares / f64::from(COUNT - 1)
            })
            .sum();
        let of_film = images.iter().map(|it| stated(it, 0)).sum::<f64>() / f64::from(COUNT);
        println!("{}: stated over true {:.3}", sampling.name(), of_film / between);
        assert!((of_film / between - 1.0).abs() < 0.15, "{of_film} {between}");
        let state = analyzer.state().0;
        for (plane, share) in state.into_iter().enumerate() {
            let ratio = stated(&images[0], plane) / stated(&images[0], 0);
            assert!((ratio - share * share).abs() < 1e-6, "{plane}: {ratio}");
        }
        let bare = of(&bare);
        let of_bare = |plane| bare.iter().map(|it| stated(it, plane)).sum::<f64>();
        let squares = state.into_iter().enumerate().map(|(i, share)| share * share * of_bare(i));
        let naive = squares.sum::<f64>() / 4.0 / f64::from(COUNT);
        println!("{}: as if independent {:.3}", sampling.name(), naive / between);
    }
}
