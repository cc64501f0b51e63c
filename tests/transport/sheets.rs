//! Sheets by their transmittances, retardances and Mueller matrices: against closed forms, straight
//! on, and against the sheets that they are made of, from all sides.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::spectrum::Color;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, scene, settings};

/// A wall that shines, and sheets before it, the first nearest to it, whose fronts, or backs, look
/// at an orthographic camera: all light goes straight on.
struct Row {
    sheets: Vec<Value>,
    backs: bool,
}

impl Row {
    fn of(sheets: Vec<Value>) -> Self {
        Self { sheets, backs: false }
    }

    fn document(&self) -> Document {
        let mut row = Document::default();
        let wall = row.material(json!({"bsdf": "absorber"}));
        let wall = row.emits(wall, 1.0);
        row.quad(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0, wall);
        for (index, sheet) in self.sheets.iter().enumerate() {
            let material = row.material(sheet.clone());
            let center = Vec3::Z * (0.2 + 0.1 * index as f32);
            // What is seen from behind has its own x to the other side, by which angles are the
            // same for the light.
            let x = if self.backs { Vec3::NEG_X } else { Vec3::X };
            row.quad(center, x, Vec3::Y, material);
        }
        row.orthographic(Vec3::Z * 2.0, Vec3::ZERO, 0.2);
        row
    }

    /// The Stokes vector of a channel, the same all over the image.
    fn stokes<const N: usize>(&self, color: Color, integrator: Integrator) -> [[f32; 4]; N] {
        let world = self.document().load("row");
        let options = settings(integrator, Mode::Polarized, color.clone(), 4, 1);
        let image = image(&scene::<N>(&world, color, [2, 2]), &options);
        std::array::from_fn(|n| std::array::from_fn(|of| mean(&image, of, n)))
    }

    fn mono(&self) -> [f32; 4] {
        self.stokes::<1>(MONO, Integrator::Path)[0]
    }
}

fn mean(image: &StokesImage, component: usize, channel: usize) -> f32 {
    image.planes[component * image.color.channels() + channel].iter().sum::<f32>() / 4.0
}

#[track_caller]
fn assert_near(found: [f32; 4], expected: [f64; 4], of: &str) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() < 2e-6, "{of}: {found:?} is not {expected:?}");
    }
}

fn ideal(axis_deg: f64) -> Value {
    json!({"bsdf": "polarizer", "axis_deg": axis_deg})
}

fn real(axis_deg: f64, transmittance: Value, blocked: Value) -> Value {
    json!({"bsdf": "polarizer", "axis_deg": axis_deg, "transmittance": transmittance,
        "blocked": blocked})
}

/// Of unpolarized light, (t1 + b1)(t2 + b2)(1 + d1 d2 cos 2a) / 4 passes two polarizers at an angle
/// a, of diattenuations d = (t - b) / (t + b).
#[test]
fn real_polarizers_obey_malus() {
    for backs in [false, true] {
        for (angle, [t1, b1], [t2, b2]) in [
            (0.0_f64, [0.8, 0.01], [0.9, 0.1]),
            (90.0, [0.8, 0.01], [0.9, 0.1]),
            (120.0, [0.7, 0.2], [0.6, 0.1]),
            (77.0, [1.0, 0.0], [0.5, 0.5]),
            (45.0, [0.0, 0.0], [0.5, 0.3]),
        ] {
            let sheets =
                vec![real(20.0, json!(t1), json!(b1)), real(20.0 + angle, json!(t2), json!(b2))];
            let found = Row { sheets, backs }.mono();
            let over = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
            let (d1, d2) = (over(t1 - b1, t1 + b1), over(t2 - b2, t2 + b2));
            let cos = (2.0 * angle.to_radians()).cos();
            let expected = 0.25 * (t1 + b1) * (t2 + b2) * (1.0 + d1 * d2 * cos);
            assert!((f64::from(found[0]) - expected).abs() < 1e-6, "{found:?} {expected}");
        }
    }
}

/// In RGB every channel has its own.
#[test]
fn transmittances_are_of_channels() {
    let sheet = real(0.0, json!([0.9, 0.6, 0.3]), json!([0.1, 0.0, 0.3]));
    let found = Row::of(vec![sheet]).stokes::<3>(Color::Rgb, Integrator::Path);
    for (found, [t, b]) in found.iter().zip([[0.9, 0.1], [0.6, 0.0], [0.3, 0.3]]) {
        assert_near(*found, [0.5 * (t + b), 0.5 * (t - b), 0.0, 0.0], "a channel");
    }
}

/// What stands on the left is M00 times the numbers on the right.
#[test]
fn circular_polarizers_have_two_sides() {
    for (hand, sense) in [("right", 1.0), ("left", -1.0)] {
        let sheet = json!({"bsdf": "circular_polarizer", "axis_deg": 25, "handedness": hand});
        // To the back: light meets the polarizer first. The camera sees the back.
        let made = Row { sheets: vec![sheet.clone()], backs: true }.mono();
        assert_near(made, [0.5, 0.0, 0.0, 0.5 * sense], "made circular");
        // From the back: the retarder first, then the polarizer, at 25 degrees.
        let (sin, cos) = 50_f64.to_radians().sin_cos();
        let analyzed = Row::of(vec![sheet.clone()]).mono();
        assert_near(analyzed, [0.5, 0.5 * cos, 0.5 * sin, 0.0], "analyzed");
        // It lets pass back what it has made, and nothing of the other sense.
        for (other, passed) in [("right", sense), ("left", -sense)] {
            let maker = json!({"bsdf": "circular_polarizer", "axis_deg": 70, "handedness": other});
            let mut row = Row { sheets: vec![maker], backs: true }.document();
            let analyzer = row.material(sheet.clone());
            row.quad(Vec3::Z, Vec3::X, Vec3::Y, analyzer);
            let world = row.load("row");
            let options = settings(Integrator::Path, Mode::Polarized, MONO, 4, 1);
            let found = mean(&image(&scene::<1>(&world, MONO, [2, 2]), &options), 0, 0);
            let expected = 0.25 * (1.0 + passed);
            assert!((f64::from(found) - expected).abs() < 1e-6, "{hand} {other}: {found}");
        }
    }
}

/// Between crossed polarizers at 45 degrees, sin^2 of half the retardance of a half passes.
#[test]
fn retarders_disperse() {
    let plates = [
        json!({"retardance_deg": [150.0, 90.0, 20.0]}),
        json!({"birefringence": 0.009, "thickness_um": 40.0}),
        json!({"birefringence": {"nm": [400.0, 700.0], "value": [0.0095, 0.0089]},
            "thickness_um": 63.0}),
    ];
    // Of the wavelengths at which indices stand for the channels, and of those that tell lengths.
    let delays: [fn(f64, f64) -> f64; 3] = [
        |nm, _| {
            if nm > 600.0 {
                150.0
            } else if nm > 500.0 {
                90.0
            } else {
                20.0
            }
        },
        |_, waves_nm| 360.0 * 0.009 * 40_000.0 / waves_nm,
        |nm, waves_nm| 360.0 * (0.0095 - 0.0006 * (nm - 400.0) / 300.0) * 63_000.0 / waves_nm,
    ];
    for (mut plate, delay) in plates.into_iter().zip(delays) {
        plate["bsdf"] = json!("retarder");
        plate["axis_deg"] = json!(45);
        let row = Row::of(vec![ideal(0.0), plate, ideal(90.0)]);
        let found = row.stokes::<3>(Color::Rgb, Integrator::Path);
        for (found, [nm, waves_nm]) in
            found.iter().zip([[650.0, 605.0], [550.0, 542.0], [450.0, 455.0]])
        {
            let expected = 0.5 * (0.5 * delay(nm, waves_nm)).to_radians().sin().powi(2);
            // Retardances of thousands of degrees in single precision.
            assert!((f64::from(found[0]) - expected).abs() < 1e-4, "{found:?} {expected}");
        }
    }
}

/// Depolarizes half of the light, turns the rest by 90 degrees of S1 to S2, and of S2 to S3.
const MIXED: [[f64; 4]; 4] =
    [[0.6, 0.1, 0.0, 0.0], [0.0, 0.0, 0.0, 0.3], [0.1, 0.3, 0.0, 0.0], [0.0, 0.0, 0.3, 0.0]];

/// Light from behind sees the transposed matrix, with other signs in its third column and row.
#[test]
fn matrices_are_those_of_the_file() {
    let sheet = json!({"bsdf": "mueller", "matrix": MIXED});
    // Linear light of the axis 10 degrees to the right of x, from the front: the camera sees the
    // back.
    let states: [(f64, [f64; 4]); 3] = [
        (0.0, [0.5, 0.5, 0.0, 0.0]),
        (45.0, [0.5, 0.0, 0.5, 0.0]),
        (100.0, [0.5, 0.5 * 200_f64.to_radians().cos(), 0.5 * 200_f64.to_radians().sin(), 0.0]),
    ];
    for (axis, state) in states {
        // The polarizer's own back is seen too, and its angles are about its front's normal.
        let mut row = Row::of(vec![ideal(axis)]).document();
        let material = row.material(sheet.clone());
        row.quad(Vec3::Z, Vec3::NEG_X, Vec3::Y, material);
        let seen = |row: Document| {
            let options = settings(Integrator::Path, Mode::Polarized, MONO, 4, 1);
            let found = image(&scene::<1>(&row.load("row"), MONO, [2, 2]), &options);
            std::array::from_fn(|of| mean(&found, of, 0))
        };
        let expected = MIXED.map(|row| row.iter().zip(state).map(|(m, s)| m * s).sum::<f64>());
        assert_near(seen(row), expected, "from the front");

        let mut row = Row::of(vec![ideal(axis)]).document();
        let material = row.material(sheet.clone());
        row.quad(Vec3::Z, Vec3::X, Vec3::Y, material);
        let sign = |i: usize| if i == 2 { -1.0 } else { 1.0 };
        let expected = std::array::from_fn(|i| {
            (0..4).map(|j| sign(i) * sign(j) * MIXED[j][i] * state[j]).sum::<f64>()
        });
        assert_near(seen(row), expected, "from the back");
    }
}

fn at(mut sheet: Value, bsdf: &str, axis_deg: f64) -> Value {
    sheet["bsdf"] = json!(bsdf);
    sheet["axis_deg"] = json!(axis_deg);
    sheet
}

/// The same sheets as a model of their own and as dense matrices, seen aslant by all integrators on
/// the same paths: nothing but rounding differs.
#[test]
fn dense_sheets_are_the_sheets_that_they_stand_for() {
    let half = |m: [[f64; 4]; 4]| json!(m.map(|row| row.map(|of| 0.5 * of)));
    let polarizer = [[1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
    let quarter =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0]];
    let sorts: [[Vec<Value>; 2]; 3] = [
        [
            vec![ideal(20.0), at(json!({"retardance_deg": 90}), "retarder", 50.0)],
            vec![
                at(json!({"matrix": half(polarizer)}), "mueller", 20.0),
                at(json!({"matrix": quarter}), "mueller", 50.0),
            ],
        ],
        [
            vec![at(json!({"extinction_ratio": 8}), "polarizer", 33.0)],
            vec![real(33.0, json!(1.0), json!(0.125))],
        ],
        [
            vec![at(json!({"retardance_deg": 140}), "retarder", -10.0)],
            vec![at(json!({"retardance_deg": [140, 140, 140]}), "retarder", -10.0)],
        ],
    ];
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm] {
        for sheets in &sorts {
            let images = sheets.each_ref().map(|sheets| {
                let world = aslant(sheets).load("aslant");
                let options: Options = settings(integrator, Mode::Polarized, MONO, 8, 4);
                image(&scene::<1>(&world, MONO, [6, 6]), &options)
            });
            let largest = images[0].planes[0].iter().copied().fold(0.0, f32::max);
            assert!(largest > 0.0);
            for (a, b) in images[0].planes.iter().zip(&images[1].planes) {
                for (a, b) in a.iter().zip(b) {
                    let error = (a - b).abs() / largest;
                    assert!(error < 1e-5, "{integrator:?}: {error}, {a} {b}, {sheets:?}");
                }
            }
        }
    }
}

/// Metal and a wall in the light of a panel, all of it through the sheets, twice.
fn aslant(sheets: &[Value]) -> Document {
    let mut room = Document::default();
    let wall = room.diffuse(0.7);
    room.quad(Vec3::ZERO, Vec3::X, Vec3::Y, wall);
    let gold = room.material(json!({"bsdf": "conductor", "metal": "Au"}));
    room.quad(Vec3::new(0.3, 0.0, 0.4), Vec3::Y * 0.5, Vec3::new(0.2, 0.0, -0.3), gold);
    let panel = room.material(json!({"bsdf": "absorber"}));
    let panel = room.emits(panel, 10.0);
    room.quad(Vec3::new(-0.4, 0.5, 1.2), Vec3::X * 0.3, Vec3::NEG_Y * 0.3, panel);
    for (index, sheet) in sheets.iter().enumerate() {
        let material = room.material(sheet.clone());
        let z = 0.9 + 0.1 * index as f32;
        room.quad(Vec3::Z * z, Vec3::new(2.0, 0.0, 0.2), Vec3::new(0.0, 2.0, -0.1), material);
    }
    room.perspective(Vec3::new(0.5, -0.3, 2.0), Vec3::ZERO, 0.6, None);
    room
}
