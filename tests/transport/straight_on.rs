//! Surfaces that let light straight on stand in nobody's way: connections go through them, and take
//! along what they do to light.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, scene, settings};

const SIZE: [u32; 2] = [12, 12];

/// A lamp and a camera beside it that look at a wall, so that all light is within 4 degrees of the
/// normal, and filters of these materials before lamp and camera.
struct Bench {
    is_area: bool,
    lamp: Vec<Value>,
    camera: Vec<Value>,
}

impl Bench {
    fn bare(is_area: bool) -> Self {
        Self { is_area, lamp: Vec::new(), camera: Vec::new() }
    }

    fn document(&self) -> Document {
        let mut bench = Document::default();
        let wall = bench.diffuse(0.8);
        bench.quad(Vec3::ZERO, Vec3::X, Vec3::Y, wall);
        let lamp = Vec3::new(0.0, 0.12, 2.0);
        if self.is_area {
            let panel = bench.material(json!({"bsdf": "absorber"}));
            let panel = bench.emits(panel, 40.0);
            bench.quad(lamp, Vec3::Y * 0.05, Vec3::X * 0.05, panel);
        } else {
            let light = json!({"type": "point", "intensity": 3.0});
            bench.light(light, lamp, Vec3::NEG_Z);
        }
        let eye = Vec3::Z * 2.0;
        for (filters, at, half) in [(&self.lamp, lamp, 0.09), (&self.camera, eye, 0.02)] {
            for (index, filter) in filters.iter().enumerate() {
                let material = bench.material(filter.clone());
                let center = at - Vec3::Z * (0.2 + 0.1 * index as f32 / filters.len() as f32);
                bench.quad(center, Vec3::X * half, Vec3::Y * half, material);
            }
        }
        bench.perspective(eye, Vec3::ZERO, 0.1, None);
        bench
    }

    fn image(&self, options: Options) -> StokesImage {
        let world = self.document().load("bench");
        image(&scene::<1>(&world, MONO, SIZE), &options)
    }
}

fn options(integrator: Integrator, mode: Mode) -> Options {
    // One segment from the wall to the camera and one from the lamp: filters count for none.
    settings(integrator, mode, MONO, 64, 2)
}

fn polarizer(axis_deg: f32) -> Value {
    json!({"bsdf": "polarizer", "axis_deg": axis_deg})
}

/// Largest difference of S0 to `factor` times that of `bare`, over the largest there.
fn error_of_s0(found: &StokesImage, bare: &StokesImage, factor: f32) -> f32 {
    let largest = bare.planes[0].iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.0, "the bare bench is black");
    let pairs = found.planes[0].iter().zip(&bare.planes[0]);
    pairs.map(|(found, bare)| (found - factor * bare).abs()).fold(0.0, f32::max)
        / (factor * largest)
}

const CONNECTING: [Integrator; 4] =
    [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm];

/// The wall depolarizes. Pairs of the same paths: nothing but rounding differs.
#[test]
fn filters_dim_by_what_they_absorb() {
    for is_area in [false, true] {
        for integrator in CONNECTING {
            for mode in [Mode::Scalar, Mode::Polarized] {
                let options = options(integrator, mode);
                let bare = Bench::bare(is_area).image(options.clone());
                let lamp = vec![polarizer(30.0)];
                let camera = vec![polarizer(60.0)];
                let one =
                    Bench { lamp: lamp.clone(), ..Bench::bare(is_area) }.image(options.clone());
                let both = Bench { lamp, camera, is_area }.image(options);
                let errors = [error_of_s0(&one, &bare, 0.5), error_of_s0(&both, &bare, 0.25)];
                let of = format!("{integrator:?}, {mode:?}, area {is_area}");
                assert!(errors.iter().all(|error| *error < 1e-4), "{errors:?}: {of}");
                if mode == Mode::Polarized {
                    let s1 =
                        both.planes[1].iter().sum::<f32>() / both.planes[0].iter().sum::<f32>();
                    assert!((s1 - (-0.5)).abs() < 1e-3, "S1 is {s1} of S0: {of}");
                }
            }
        }
    }
}

/// Each halves unpolarized light, and doubles what it passes relative to that: 2^150 is no `f32`.
#[test]
fn stacks_of_hundreds_stay_within_the_range_of_numbers() {
    for integrator in CONNECTING {
        let options = settings(integrator, Mode::Polarized, MONO, 8, 2);
        let bare = Bench::bare(true).image(options.clone());
        let stack = vec![polarizer(10.0); 150];
        let found = Bench { lamp: stack.clone(), camera: stack, is_area: true }.image(options);
        let error = error_of_s0(&found, &bare, 0.25);
        assert!(error < 1e-3, "{integrator:?}: {error}");
    }
}

/// Malus' law between two polarizers before the lamp; in scalar mode each takes a half.
#[test]
fn crossed_filters_before_a_lamp_obey_malus() {
    for integrator in CONNECTING {
        for (angle, mode, expected) in [
            (30.0_f32, Mode::Polarized, 0.375),
            (45.0, Mode::Polarized, 0.25),
            (90.0, Mode::Scalar, 0.25),
        ] {
            let options = options(integrator, mode);
            let bare = Bench::bare(false).image(options.clone());
            let lamp = vec![polarizer(0.0), polarizer(angle)];
            let found = Bench { lamp, ..Bench::bare(false) }.image(options);
            let mean = |image: &StokesImage| image.planes[0].iter().sum::<f32>();
            let ratio = mean(&found) / mean(&bare);
            // Slanted light sees the axes at other angles: some thousandths, as 4 degrees squared.
            assert!((ratio / expected - 1.0).abs() < 0.01, "{integrator:?}: {ratio}, {angle}");
        }
    }
}

#[test]
fn panes_of_the_index_around_them_are_not_there() {
    for integrator in CONNECTING {
        let options = options(integrator, Mode::Polarized);
        let bare = Bench::bare(false).image(options.clone());
        for model in ["dielectric", "thin_dielectric"] {
            let pane = json!({"bsdf": model, "ior": 1.2, "exterior_ior": 1.2});
            let (lamp, camera) = (vec![pane.clone()], vec![pane]);
            let found = Bench { lamp, camera, is_area: false }.image(options.clone());
            let error = error_of_s0(&found, &bare, 1.0);
            assert!(error < 1e-5, "{model}, {integrator:?}: {error}");
        }
    }
}

/// At normal incidence a pane of index 1.5 lets 12/13 pass, and a little less beside: the paths of
/// 4,096 samples agree with that to a hundredth.
#[test]
fn plain_gltf_glass_is_thin_unless_it_has_a_thickness() {
    let radiance = |volume: Option<Value>| {
        let mut window = Document::default();
        let wall = window.material(json!({"bsdf": "absorber"}));
        let wall = window.emits(wall, 1.0);
        window.quad(Vec3::Z * -1.0, Vec3::X, Vec3::Y, wall);
        let pane = window.plain_glass(volume);
        window.quad(Vec3::ZERO, Vec3::X, Vec3::Y, pane);
        window.perspective(Vec3::Z, Vec3::ZERO, 0.1, None);
        let scene = scene::<1>(&window.load("window"), MONO, [4, 4]);
        let options = settings(Integrator::Path, Mode::Polarized, MONO, 256, 4);
        image(&scene, &options).planes[0].iter().sum::<f32>() / 16.0
    };
    for thin in [None, Some(json!({"thicknessFactor": 0.0}))] {
        let found = radiance(thin);
        assert!((found - 12.0 / 13.0).abs() < 0.01, "{found}");
    }
    // Entrance into a solid: 0.96 of the power, in 1 / 1.5^2 of the angle; and 1 m of absorption.
    let solid = radiance(Some(json!({"thicknessFactor": 0.1})));
    assert!((solid - 0.96 / 2.25).abs() < 0.01, "{solid}");
    let dark = json!({"thicknessFactor": 0.1, "attenuationDistance": 1.0,
        "attenuationColor": [0.5, 0.5, 0.5]});
    let absorbed = radiance(Some(dark)) / solid;
    assert!((absorbed - 0.5).abs() < 0.01, "{absorbed}");
}
