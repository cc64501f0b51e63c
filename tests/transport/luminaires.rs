//! Luminaires: what is read of files, what they emit, and how light paths are drawn from them. That
//! all integrators agree before them is for `agreement`.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3, Vec3};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scene::luminaire::Luminaire;
use sunstone::internals::scene::{World, bake};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Bsdf, Geometry, Lens, Photometry, Punctual, Transform};

use crate::support::gltf::Document;
use crate::support::luminaires::{file, light};
use crate::support::random::Random;
use crate::support::rendering::{MONO, image, replicates, scene, settings};
use crate::support::statistics::estimate;

/// The multiplier and the ballast factor of the files.
const FACTOR: f64 = 0.4;

fn read(vertical: &[f64], horizontal: &[f64], candela: &[f64]) -> Photometry {
    Photometry::from_ies(&file(vertical, horizontal, candela)).unwrap()
}

/// Four that between them have every symmetry.
fn all() -> Vec<Photometry> {
    let vertical = [0.0, 30.0, 60.0, 90.0];
    let rows = |count: usize| -> Vec<f64> {
        (0..count * 4).map(|index| 1.0 + (index * 7 % 11) as f64).collect()
    };
    vec![
        read(&vertical, &[0.0], &rows(1)),
        read(&vertical, &[0.0, 45.0, 90.0], &rows(3)),
        read(&vertical, &[0.0, 20.0, 180.0], &rows(3)),
        read(&vertical, &[90.0, 180.0, 270.0], &rows(3)),
        read(&vertical, &[0.0, 100.0, 200.0, 360.0], &rows(4)),
    ]
}

#[test]
fn intensities_are_linear_between_angles_and_symmetric() {
    let read = all();
    // Of the first horizontal angle of the first: 1, 8, 4 and 11.
    for (degrees, expected) in [(0.0, 1.0), (15.0, 4.5), (60.0, 4.0), (75.0, 7.5), (90.0, 11.0)] {
        for around in [0.0, 77.0, 311.0] {
            let error = read[0].at(degrees, around) - FACTOR * expected;
            assert!(error.abs() < 1e-12, "{degrees} {around}: {error}");
        }
    }
    assert_eq!(read[0].at(91.0, 0.0), 0.0);
    let [quadrants, sides, across, whole] = &read[1..] else { panic!("five") };
    for around in [0.0, 10.0, 40.0, 89.0, 130.0] {
        let at = |of: &Photometry, degrees: f64| of.at(40.0, degrees);
        let same = |of: &Photometry, others: &[f64]| {
            others.iter().all(|other| (at(of, around) - at(of, *other)).abs() < 1e-9)
        };
        assert!(same(quadrants, &[-around, 180.0 - around, 180.0 + around, 360.0 + around]));
        assert!(same(sides, &[-around, 360.0 - around, around + 720.0]));
        assert!(same(across, &[180.0 - around, 540.0 - around, around - 360.0]));
        assert!(same(whole, &[around + 360.0, around - 720.0]));
    }
    // 1 + 7 * 8 % 11 and 1 + 7 * 4 % 11 on the axis of the third and the second one.
    assert!((whole.at(0.0, 150.0) - FACTOR * 0.5 * (7.0 + 2.0)).abs() < 1e-12);
}

/// Means by formula and by summing over many directions.
#[test]
fn the_mean_is_the_integral_over_directions() {
    for photometry in all() {
        let (rows, columns) = (720, 360);
        let mut sum = 0.0;
        for index in 0..rows * columns {
            let theta = (f64::from(index / columns) + 0.5) * PI / f64::from(rows);
            let phi = (f64::from(index % columns) + 0.5) * 360.0 / f64::from(columns);
            sum += photometry.at(theta.to_degrees(), phi) * theta.sin();
        }
        let mean = sum * (PI / f64::from(rows)) / (2.0 * f64::from(columns));
        let stated = photometry.mean();
        assert!((stated / mean - 1.0).abs() < 1e-4, "{stated}, not {mean}");
    }
}

fn turned() -> DMat3 {
    DMat3::from_quat(DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(1.2)) * 3.0
}

/// Directions come as dense as is said, and what they bring is the mean: two sums that have to be
/// one. Of ten numbers one is off by 5 standard errors with a chance of 6e-6.
#[test]
fn directions_are_drawn_by_their_density() {
    const DRAWS: u32 = 20_000;
    let mut random = Random(7);
    for photometry in all() {
        let luminaire = Luminaire::new(&photometry, turned());
        let (mut brought, mut squares, mut all_around) = (0.0, 0.0, 0.0);
        for _ in 0..DRAWS {
            let drawn = luminaire.direction([random.next(), random.next()]);
            assert!((drawn.length() - 1.0).abs() < 1e-5);
            let value = f64::from(luminaire.share(drawn) / luminaire.density(drawn)) / (4.0 * PI);
            brought += value;
            squares += value * value;
            // And against directions of no preference.
            let [u, v] = [random.next(), random.next()].map(f64::from);
            let (z, turn) = (1.0 - 2.0 * u, 2.0 * PI * v);
            let radius = (1.0 - z * z).sqrt();
            let any = DVec3::new(radius * turn.cos(), radius * turn.sin(), z).as_vec3();
            all_around += 4.0 * PI * f64::from(luminaire.density(any));
        }
        let count = f64::from(DRAWS);
        let error = ((squares / count - (brought / count).powi(2)).max(0.0) / count).sqrt();
        let off = (brought / count - 1.0).abs();
        assert!(off < 5.0 * error + 1e-4, "{} +- {error}", brought / count);
        // Densities are within 0.05 and some 20: the error of their mean is below 0.02.
        assert!((all_around / count - 1.0).abs() < 0.1, "{}", all_around / count);
        // Drawn by what is emitted: weights hardly differ.
        assert!(error * count.sqrt() < 0.3, "{}", error * count.sqrt());
    }
}

/// The axis is -z of the node, and horizontal angles turn about z from x.
#[test]
fn axes_are_those_of_the_node() {
    let vertical = [0.0, 90.0, 180.0];
    let lobe = read(
        &vertical,
        &[0.0, 90.0, 180.0, 270.0, 360.0],
        &[8.0, 1.0, 0.0, 8.0, 2.0, 0.0, 8.0, 3.0, 0.0, 8.0, 4.0, 0.0, 8.0, 1.0, 0.0],
    );
    let axes = turned();
    let luminaire = Luminaire::new(&lobe, axes);
    for (local, expected) in [
        (DVec3::NEG_Z, 8.0),
        (DVec3::Z, 0.0),
        (DVec3::X, 1.0),
        (DVec3::Y, 2.0),
        (DVec3::NEG_X, 3.0),
        (DVec3::NEG_Y, 4.0),
    ] {
        let direction = (axes * local).normalize().as_vec3();
        let found = f64::from(luminaire.share(direction)) * luminaire.mean();
        assert!((found - FACTOR * expected).abs() < 1e-4, "{local}: {found}, not {expected}");
    }
}

/// A floor under a luminaire that is the same all around: E = I(angle) cos^3 / h^2 on it, seen from
/// above, in candela times the intensity, by all integrators; of light paths on the average.
#[test]
fn floors_are_lit_by_the_intensity() {
    const HEIGHT: f64 = 2.0;
    /// Of a pixel, along its edge.
    const PLACES: usize = 16;
    let photometry = file(&[0.0, 20.0, 40.0], &[0.0], &[10.0, 25.0, 5.0]);
    let mut document = Document::default();
    let floor = document.diffuse(0.5);
    document.quad(Vec3::ZERO, 1.5 * Vec3::Z, 1.5 * Vec3::X, floor);
    document.light(light(&photometry, 3.0), Vec3::Y * HEIGHT as f32, Vec3::NEG_Y);
    document.up(Vec3::Z);
    document.orthographic(3.0 * Vec3::Y, Vec3::ZERO, 0.9);
    let world = document.load("floor");
    let scene = scene::<1>(&world, MONO, [9, 9]);
    let read = Photometry::from_ies(&photometry).unwrap();
    let expected = |column: usize, row: usize| {
        let at = |index: usize, place: usize| {
            (index as f64 - 4.5 + (place as f64 + 0.5) / PLACES as f64) * 0.2
        };
        let places = (0..PLACES * PLACES).map(|place| {
            let distance = at(column, place % PLACES).hypot(at(row, place / PLACES));
            let cosine = HEIGHT / HEIGHT.hypot(distance);
            let candela = read.at((distance / HEIGHT).atan().to_degrees(), 0.0);
            0.5 / PI * 3.0 * candela * cosine.powi(3) / HEIGHT.powi(2)
        });
        places.sum::<f64>() / (PLACES * PLACES) as f64
    };
    for &integrator in Integrator::ALL {
        let options = settings(integrator, Mode::Scalar, MONO, 64, 2);
        let images = replicates(&scene, &Options { samples: 64, ..options }, 8);
        for pixel in 0..81 {
            let (found, expected) =
                (estimate(&images, 0, &[pixel]), expected(pixel % 9, pixel / 9));
            let error = (found.mean - expected).abs();
            let most = 6.0 * found.variance.sqrt() + 2e-3 * expected;
            assert!(error < most, "{integrator:?}, {pixel}: {found:?}, not {expected}");
        }
    }
}

/// One that emits the same everywhere is a point light, but for rounding.
#[test]
fn an_even_luminaire_is_a_point() {
    let even = read(&[0.0, 180.0], &[0.0], &[2.5, 2.5]);
    let room = |luminaire: Option<Photometry>| {
        let mut world = World::new("room");
        let wall = world.add_material("wall", Bsdf::diffuse(0.7)).unwrap();
        let walls = Geometry::quad(Vec3::ZERO, Vec3::Z, Vec3::X);
        world.add_mesh("floor", walls, wall, Transform::IDENTITY).unwrap();
        let lamp =
            world.add_light("lamp", Punctual::point(2.0), DVec3::new(0.1, 0.8, 0.2)).unwrap();
        if let Some(luminaire) = luminaire {
            world.set_luminaire(lamp, luminaire).unwrap();
        }
        let place = Transform::looking(DVec3::new(0.3, 1.5, 2.0), DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.6), place).unwrap();
        scene::<1>(&world, MONO, [6, 6])
    };
    let (point, measured) = (room(None), room(Some(even)));
    let options = settings(Integrator::Path, Mode::Polarized, MONO, 8, 4);
    let [expected, found] = [&point, &measured].map(|scene| image(scene, &options));
    for (found, expected) in found.planes[0].iter().zip(&expected.planes[0]) {
        // 2.5 times the factor is 1.
        assert!((found - expected).abs() <= 1e-5 * expected, "{found}, not {expected}");
    }
}

#[test]
fn what_of_files_is_doubtful_is_told() {
    let good = file(&[0.0, 90.0], &[0.0, 360.0], &[1.0, 2.0, 1.0, 2.0]);
    let doubts = |from: &str, to: &str| {
        let read = Photometry::from_ies(&good.replacen(from, to, 1)).unwrap();
        read.doubts().join("; ")
    };
    for (from, to) in [
        ("", ""),
        ("TILT=NONE", "TILT=INCLUDE\n1 2 0 90 1 1"),
        ("0 360\r\n1 2\r\n1 2", "0 360\r\n1 2\r\n1 2.001"),
        ("0 360\r\n1 2\r\n1 2", "0 180\r\n1 2\r\n7 5"),
    ] {
        assert_eq!(doubts(from, to), "", "{to}");
    }
    for (from, to, words) in [
        ("TILT=NONE", "TILT=lamp.tlt", "names a file for TILT"),
        ("TILT=NONE", "TILT=", "names a file for TILT"),
        ("TILT=NONE", "TILT=INCLUDE\n1 2 0 90 1 0.9", "has factors of TILT"),
        ("1 2\r\n1 2\r\n", "1 2\r\n1 2\r\n3\r\n", "goes on behind its last candela value"),
        ("1 2\r\n1 2\r\n", "1 2\r\n1 2\r\nEND\r\n", "goes on behind its last candela value"),
        ("1 2\r\n1 2\r\n", "1 2\r\n1 3\r\n", "360 degrees than at 0"),
    ] {
        let found = doubts(from, to);
        assert!(found.contains(words) && !found.contains(';'), "{to}: {found}");
    }
    let mut world = World::new("lights");
    let lamp = world.add_light("lamp", Punctual::point(1.0), DVec3::Y).unwrap();
    let seam = Photometry::from_ies(&good.replacen("1 2\r\n1 2\r\n", "1 2\r\n1 3\r\n", 1));
    world.set_luminaire(lamp, seam.unwrap()).unwrap();
    let said = world.warnings().join("\n");
    assert!(said.contains("light `lamp`, ies has other intensities"), "{said}");
    // One angle spans nothing, whatever is at it.
    for only in [0.0, 45.0, 180.0] {
        let fault = Photometry::from_ies(&file(&[only], &[0.0], &[10.0])).unwrap_err();
        assert_eq!(fault.field, "vertical angles", "{fault}");
        assert!(fault.problem.contains("alone"), "{fault}");
    }
}

#[test]
fn files_that_are_not_so_are_refused() {
    let good = file(&[0.0, 90.0], &[0.0, 90.0], &[1.0, 2.0, 3.0, 4.0]);
    let with = |from: &str, to: &str| Photometry::from_ies(&good.replacen(from, to, 1));
    assert!(Photometry::from_ies(&good).is_ok());
    assert!(with("TILT=NONE", "TILT=INCLUDE\n1 2 0 90 1 1").is_ok());
    assert!(with("\r\n", "\n").is_ok() && with("1 2 0 0 0", "1,2,0,0,0").is_ok());
    for (from, to, part) in [
        ("TILT=NONE", "", "TILT"),
        ("1 2 0 0 0", "2 2 0 0 0", "photometric type"),
        ("3 4", "3", "candela values"),
        ("3 4", "3 -4", "candela values"),
        ("3 4", "3 nan", "candela values"),
        ("3 4", "3 four", "candela values"),
        ("0 90\r\n0 90", "90 0\r\n0 90", "vertical angles"),
        ("0 90\r\n0 90", "0 190\r\n0 90", "vertical angles"),
        ("0 90\r\n0 90", "0 90\r\n0 100", "horizontal angles"),
        ("0.5 2 2", "0.5 0 2", "number of vertical angles"),
        ("0.5 2 2", "0.5 2 1e9", "number of horizontal angles"),
        ("0.5 2 2", "0 2 2", "candela values"),
    ] {
        let fault = with(from, to).unwrap_err();
        assert_eq!(fault.field, part, "{to}: {fault}");
    }
    for text in ["", "IESNA:LM-63-2002", "TILT=NONE", "TILT=NONE\n1 1 1 1 1 1", "\0\u{fffd}"] {
        assert!(Photometry::from_ies(text).is_err());
    }
    let mut world = World::new("lights");
    let spot = world.add_light("spot", Punctual::spot(1.0, 0.1, 0.2), DVec3::Y).unwrap();
    let error = world.set_luminaire(spot, Photometry::from_ies(&good).unwrap()).unwrap_err();
    assert!(error.to_string().contains("light `spot`, ies"), "{error}");
    let mut document = Document::default();
    let mut broken = light(&good, 1.0);
    broken["type"] = "directional".into();
    document.light(broken, Vec3::Y, Vec3::NEG_Y);
    document.orthographic(Vec3::Z, Vec3::ZERO, 1.0);
    assert!(std::panic::catch_unwind(move || document.load("directional")).is_err());
    let mut document = Document::default();
    document.light(light(&good, 2.0), Vec3::Y, Vec3::NEG_Y);
    document.orthographic(Vec3::Z, Vec3::ZERO, 1.0);
    let world = document.load("point");
    assert!(world.describe().contains("measured"), "{}", world.describe());
    assert_eq!(bake(&world, &Carried::RGB).unwrap().optics.patterns.len(), 1);
}
