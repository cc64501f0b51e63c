//! Lamps that emit polarized light: against laws of optics, and against lamps behind sheets. That
//! all integrators agree before them is for `agreement`.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::world::{Bsdf, EmittedStokes, Geometry, Lens, Material, Transform};
use sunstone::{Analyzer, Spectrum};

use crate::support::fields::reflected;
use crate::support::gltf::Document;
use crate::support::polarized::{floor_and_fog, under_a_panel};
use crate::support::rendering::{MONO, image, replicates, scene, settings};
use crate::support::statistics::{cells, estimate, mean_s0, rms, rms_limits, worst};

const SIZE: [u32; 2] = [5, 4];
/// What can see a lamp straight ahead, or in a mirror, by parallel rays.
const SEEING: [Integrator; 3] = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];
const RADIANCE: f32 = 2.0;

/// S1, S2 and S3 over S0: linear at an angle, elliptical, partly polarized, circular.
const STATES: [[f32; 3]; 4] =
    [[0.6, 0.8, 0.0], [-0.48, 0.36, 0.8], [0.1, -0.3, 0.2], [0.0, 0.0, -1.0]];

/// A lamp in a state, 1.2 by 1.2 about a place, that faces the origin from there and whose node has
/// its x axis along `right`.
fn world_with_lamp(place: DVec3, right: DVec3, stokes: [f32; 3]) -> World {
    let mut world = World::new("lamp");
    let lamp = world.add_material("lamp", Material::emitter(RADIANCE)).unwrap();
    world.set_emitted_stokes(lamp, EmittedStokes::new(stokes).unwrap()).unwrap();
    let towards = -place.normalize();
    let turn = DMat3::from_cols(right, towards.cross(right), towards);
    let quad = Geometry::quad(Vec3::ZERO, 0.6 * Vec3::X, 0.6 * Vec3::Y);
    let to_world = Transform(DAffine3::from_mat3_translation(turn, place));
    world.add_mesh("lamp", quad, lamp, to_world).unwrap();
    world
}

/// Has parallel rays look from a place at the origin.
fn seen_from(mut world: World, eye: DVec3) -> World {
    let lens = Lens::Orthographic { half_width: 0.4, half_height: 0.3 };
    world.set_camera("eye", lens, Transform::looking(eye, DVec3::ZERO, DVec3::Y)).unwrap();
    world
}

/// Every pixel of every integrator is one and the same Stokes vector.
fn shows(world: &World, expected: [f64; 4], what: &str) {
    let scene = scene::<1>(world, MONO, SIZE);
    for integrator in SEEING {
        let found = image(&scene, &settings(integrator, Mode::Polarized, MONO, 8, 3));
        for (plane, expected) in found.planes.iter().zip(expected) {
            for &value in plane {
                let error = f64::from(value) - expected;
                assert!(error.abs() < 2e-6, "{what}, {integrator:?}: {value}, not {expected}");
            }
        }
        for (mode, planes) in [(Mode::Intensity, 1), (Mode::Scalar, 1)] {
            let seen = image(&scene, &settings(integrator, mode, MONO, 8, 3));
            assert_eq!(seen.planes.len(), planes);
            let expected = if mode == Mode::Scalar { None } else { Some(&found.planes[0]) };
            assert!(expected.is_none_or(|plane| *plane == seen.planes[0]), "{what}, {mode:?}");
        }
    }
}

/// A state seen about an axis that is turned by an angle against its own: the other way round.
fn turned([s1, s2, s3]: [f32; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = (2.0 * angle).sin_cos();
    let [s1, s2, s3] = [s1, s2, s3].map(f64::from);
    [cos * s1 + sin * s2, cos * s2 - sin * s1, s3]
}

fn times(factor: f64, [s1, s2, s3]: [f64; 3]) -> [f64; 4] {
    [1.0, s1, s2, s3].map(|component| factor * component)
}

/// As it is stated if the node stands upright before the camera, and turned with the node.
#[test]
fn a_lamp_is_seen_in_its_state() {
    for stokes in STATES {
        for degrees in [0.0_f64, 30.0, -80.0, 180.0] {
            let angle = degrees.to_radians();
            let right = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let world = seen_from(world_with_lamp(-DVec3::Z, right, stokes), 3.0 * DVec3::Z);
            let expected = times(f64::from(RADIANCE), turned(stokes, -angle));
            shows(&world, expected, &format!("{stokes:?} turned by {degrees} degrees"));
        }
    }
}

/// The x axis of the frame is the node's, laid across the light: aslant too, and from the back.
#[test]
fn the_frame_follows_the_direction() {
    let (sin, cos) = 0.7_f64.sin_cos();
    for (eye, is_behind) in [(DVec3::new(sin, 0.0, cos), false), (DVec3::new(sin, 0.0, -cos), true)]
    {
        let mut world = world_with_lamp(-1e-3 * DVec3::Z, DVec3::X, STATES[1]);
        for (_, sides) in
            world.entities_mut().query_mut::<(hecs::Entity, &mut sunstone::world::Sides)>()
        {
            sides.two_sided = true;
        }
        let world = seen_from(world, 3.0 * eye);
        // The camera's right is the node's x, laid across, from before; from behind the other way,
        // which is the same axis.
        let [s1, s2, s3] = STATES[1].map(f64::from);
        shows(&world, times(f64::from(RADIANCE), [s1, s2, s3]), &format!("behind: {is_behind}"));
    }
}

/// Malus, by sheets and by analyzers: of light of degree p and angle b, (1 + p cos 2(a - b)) / 2
/// passes a polarizer at a; of circular light all or nothing one analyzer.
#[test]
fn malus() {
    for stokes in STATES {
        let [s1, s2, s3] = stokes.map(f64::from);
        for axis_deg in [0.0_f64, 20.0, 63.0, 110.0] {
            let axis = axis_deg.to_radians();
            let (sin, cos) = (2.0 * axis).sin_cos();
            let passes = 0.5 * f64::from(RADIANCE) * (1.0 + s1 * cos + s2 * sin);
            let lamp = || world_with_lamp(-DVec3::Z, DVec3::X, stokes);
            let mut sheet = lamp();
            let material = Bsdf::Polarizer { axis_deg, extinction_ratio: f64::INFINITY };
            let material = sheet.add_material("sheet", material).unwrap();
            let quad = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
            sheet.add_mesh("sheet", quad, material, Transform::IDENTITY).unwrap();
            let sheet = seen_from(sheet, 3.0 * DVec3::Z);
            let expected = times(passes, [cos, sin, 0.0]);
            shows(&sheet, expected, &format!("{stokes:?} behind a sheet at {axis_deg}"));
            let mut film = seen_from(lamp(), 3.0 * DVec3::Z);
            film.set_analyzer(Some(Analyzer::Linear { axis_deg })).unwrap();
            let scene = scene::<1>(&film, MONO, SIZE);
            for integrator in SEEING {
                let found = image(&scene, &settings(integrator, Mode::Polarized, MONO, 8, 3));
                for &value in &found.planes[0] {
                    assert!((f64::from(value) - passes).abs() < 2e-6, "{value}, not {passes}");
                }
            }
        }
        let mut film = seen_from(world_with_lamp(-DVec3::Z, DVec3::X, stokes), 3.0 * DVec3::Z);
        film.set_analyzer(Some(Analyzer::RightCircular)).unwrap();
        let found = image(
            &scene::<1>(&film, MONO, SIZE),
            &settings(Integrator::Path, Mode::Polarized, MONO, 8, 3),
        );
        let passes = 0.5 * f64::from(RADIANCE) * (1.0 + s3);
        assert!((f64::from(found.planes[0][0]) - passes).abs() < 2e-6);
    }
}

/// Reflected by glass, at Brewster's angle too, and by metal: as Fresnel has it.
#[test]
fn mirrors_reflect_states_as_fresnel_has_it() {
    const WHOLE: [[f32; 3]; 5] =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [-0.48, 0.36, 0.8], [0.0, 0.0, -1.0]];
    let mirrors = [(1.5, 0.0, 1.5_f64.atan()), (1.5, 0.0, 0.4), (0.4, 2.6, 1.1), (1.8, 3.0, 0.6)];
    for ((eta, k, angle), stokes) in
        mirrors.into_iter().flat_map(|mirror| WHOLE.map(|stokes| (mirror, stokes)))
    {
        let (sin, cos) = angle.sin_cos();
        let mut world = world_with_lamp(DVec3::new(0.0, cos, -sin) * 2.0, DVec3::X, stokes);
        let mirror = match k {
            0.0 => Bsdf::dielectric(eta as f32),
            k => Bsdf::Conductor { eta: (eta as f32).into(), k: (k as f32).into() },
        };
        let mirror = world.add_material("mirror", mirror).unwrap();
        let floor = Geometry::quad(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X);
        world.add_mesh("mirror", floor, mirror, Transform::IDENTITY).unwrap();
        let world = seen_from(world, DVec3::new(0.0, cos, sin) * 3.0);
        // The lamp's x is across the plane of incidence, as the film's.
        let expected = reflected(stokes.map(f64::from), cos, eta, k);
        let expected = expected.map(|component| f64::from(RADIANCE) * component);
        if k == 0.0 {
            shows_on_average(&world, expected, &format!("{stokes:?} by glass of {eta}"));
        } else {
            shows(&world, expected, &format!("{stokes:?} by metal of {eta} and {k}"));
        }
    }
}

/// The same where paths choose a way: over many samples. Nothing lies beyond.
fn shows_on_average(world: &World, expected: [f64; 4], what: &str) {
    let scene = scene::<1>(world, MONO, SIZE);
    for integrator in SEEING {
        let options = settings(integrator, Mode::Polarized, MONO, 64, 3);
        let images = replicates(&scene, &options, 16);
        let all: Vec<usize> = (0..20).collect();
        for (plane, expected) in expected.into_iter().enumerate() {
            let found = estimate(&images, plane, &all);
            let error = (found.mean - expected).abs();
            // One of some 240 numbers is off by more with a chance of 1e-3.
            let most = 5.0 * found.variance.sqrt() + 2e-6;
            assert!(error < most, "{what}, {integrator:?}: {found:?}, not {expected}");
        }
    }
}

/// A floor and fog of an even phase function do not know: nothing differs to the bit.
#[test]
fn depolarizers_forget_the_state() {
    let [plain, polarized] = [None, Some(json!([0.3, -0.6, 0.7]))].map(floor_and_fog);
    let [plain, polarized] = [plain, polarized].map(|world| scene::<3>(&world, Color::Rgb, [6, 6]));
    for &integrator in Integrator::ALL {
        let options = settings(integrator, Mode::Polarized, Color::Rgb, 4, 5);
        let [expected, found] = [&plain, &polarized].map(|scene| image(scene, &options));
        assert!(mean_s0(&expected) > 0.0);
        assert!(expected.planes == found.planes, "{integrator:?}");
        let options = Options { mode: Mode::Scalar, ..options };
        let [expected, found] = [&plain, &polarized].map(|scene| image(scene, &options));
        assert!(expected.planes == found.planes, "{integrator:?}, scalar");
    }
}

/// What a sheet lets through of a lamp is what a lamp in the state emits: every integrator and
/// component. Of some 900 numbers, one is off by more than 5 with a chance of 5e-4.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn a_lamp_in_a_state_is_a_lamp_behind_a_sheet() {
    const EDGE: u32 = 12;
    const COUNT: u32 = 24;
    let [state, sheet] =
        [false, true].map(|behind| scene::<1>(&under_a_panel(behind), MONO, [EDGE; 2]));
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        let options = settings(integrator, Mode::Polarized, MONO, 64, 5);
        let other = Options { seed: options.seed + 0x00ff_0000, ..options.clone() };
        let of = |scene: &Arc<Scene<1>>, options: &Options| replicates(scene, options, COUNT);
        let (found, expected) = (of(&state, &options), of(&sheet, &other));
        let scores = scores(&found, &expected, EDGE as usize);
        println!("{integrator:?}: {} scores, worst {:.2}", scores.len(), worst(&scores));
        assert!(scores.len() > 80 && worst(&scores) < 5.0);
        assert!(rms(&scores) < rms_limits(scores.len() / 4)[1], "{}", rms(&scores));
    }
}

fn scores(found: &[StokesImage], expected: &[StokesImage], edge: usize) -> Vec<f64> {
    let s0 = mean_s0(&expected[0]);
    let cells = cells(edge, edge, 2, &vec![true; edge * edge]);
    let of_cell = |cell: &Vec<usize>| {
        let score =
            |plane| estimate(found, plane, cell).score(&estimate(expected, plane, cell), s0);
        (0..4).filter_map(score).collect::<Vec<f64>>()
    };
    cells.iter().flat_map(of_cell).collect()
}

/// A state by wavelength is that of each channel and of each wavelength.
#[test]
fn states_depend_on_wavelength() {
    let table = |values: [f32; 2]| Spectrum::table(&[400.0, 700.0], &values).unwrap();
    let stokes = [table([0.6, -0.6]), Spectrum::Rgb([0.1, 0.3, -0.2]), Spectrum::Constant(0.2)];
    let mut world = seen_from(world_with_lamp(-DVec3::Z, DVec3::X, STATES[0]), 3.0 * DVec3::Z);
    let lamp = world.find("lamp").unwrap();
    world.set_emitted_stokes(lamp, EmittedStokes { stokes }).unwrap();
    let of = |nm: f64| 0.6 - 1.2 * (nm - 400.0) / 300.0;
    let options = settings(Integrator::Path, Mode::Polarized, Color::Rgb, 4, 3);
    let found = image(&scene::<3>(&world, Color::Rgb, SIZE), &options);
    let expected = [[650.0, 0.1], [550.0, 0.3], [450.0, -0.2]];
    for (channel, [nm, s2]) in expected.into_iter().enumerate() {
        let state = [1.0, of(nm), s2, 0.2];
        for (component, expected) in state.into_iter().enumerate() {
            let value = f64::from(found.planes[3 * component + channel][0]);
            let expected = f64::from(RADIANCE) * expected;
            assert!((value - expected).abs() < 2e-6, "{nm}: {value}, not {expected}");
        }
    }
    let color = Color::Mono { wavelength_nm: 500.0 };
    let options = Options { color: color.clone(), ..options };
    let found = image(&scene::<1>(&world, color, SIZE), &options);
    for (plane, expected) in [1.0, of(500.0), 0.05, 0.2].into_iter().enumerate() {
        let value = f64::from(found.planes[plane][0]) / f64::from(RADIANCE);
        assert!((value - expected).abs() < 2e-6, "{plane}: {value}, not {expected}");
    }
}

/// Parallel light along z in air of small particles, seen at a right angle to it and to S1's axis,
/// or along that: all or nothing arrives (Rayleigh). Circular light is seen linear, as unpolarized
/// light.
#[test]
fn rayleigh_scatters_across_the_field_alone() {
    let seen = |stokes: [f32; 3], eye: Vec3| {
        let mut document = Document::default();
        let light = json!({"type": "directional", "intensity": 100.0,
            "extensions": {"SUNSTONE_polarization": {"stokes": stokes}}});
        document.light(light, 5.0 * Vec3::Z, Vec3::NEG_Z);
        let air = document.medium(json!({"phase": "rayleigh", "sigma_a": 0.0, "sigma_s": 0.1}));
        document.fog(air, |document, null| document.cuboid(Vec3::ZERO, Vec3::splat(0.3), null));
        document.up(Vec3::Z);
        document.orthographic(eye, Vec3::ZERO, 0.25);
        let scene = scene::<1>(&document.load("beam"), MONO, [2, 2]);
        let seen = Integrator::ALL.iter().map(|&integrator| {
            let options = settings(integrator, Mode::Polarized, MONO, 64, 2);
            let found = image(&scene, &options);
            let mean = |plane: &Vec<f32>| plane.iter().map(|it| f64::from(*it)).sum::<f64>() / 4.0;
            let all: Vec<f64> = found.planes.iter().map(mean).collect();
            all
        });
        seen.collect::<Vec<Vec<f64>>>()
    };
    let along = [seen([1.0, 0.0, 0.0], 3.0 * Vec3::X), seen([-1.0, 0.0, 0.0], 3.0 * Vec3::Y)];
    let across = [seen([1.0, 0.0, 0.0], 3.0 * Vec3::NEG_Y), seen([-1.0, 0.0, 0.0], 3.0 * Vec3::X)];
    let circular = [seen([0.0, 0.0, 1.0], 3.0 * Vec3::X), seen([0.0, 0.0, 0.0], 3.0 * Vec3::X)];
    // Photons are found after two segments.
    for integrator in 0..4 {
        for (along, across) in along.iter().zip(&across) {
            let (along, across) = (&along[integrator], &across[integrator]);
            assert!(across[0] > 0.0 && along[0] < 1e-5 * across[0], "{along:?} {across:?}");
            // Across the light's way, which is upright in the image.
            assert!((across[1] / across[0] - 1.0).abs() < 1e-5, "{across:?}");
        }
        let [circular, plain] = circular.each_ref().map(|all| &all[integrator]);
        for (found, expected) in circular.iter().zip(plain) {
            assert!((found - expected).abs() < 1e-5 * plain[0], "{circular:?} {plain:?}");
        }
        let mean = 0.5 * (across[0][integrator][0] + along[0][integrator][0]);
        assert!((circular[0] / mean - 1.0).abs() < 0.1, "{circular:?} {mean}");
    }
}
