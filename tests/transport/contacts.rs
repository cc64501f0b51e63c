//! Surfaces that let light straight on in the place of others: sheets laid on what they filter,
//! sheets on sheets, media that end where others begin. As with a gap of a millimeter, or by what
//! can be said without a render; which of two a ray meets first is not left to rounding.

use glam::{Vec3, vec3};
use serde_json::{Value, json};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::bake;
use sunstone::internals::spectrum::Carried;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, scene, settings};

/// Gaps that rays would not see: none, and less than they keep off surfaces.
const GAPS: [f32; 3] = [0.0, 1e-7, -1e-7];

/// Samples that leave no noise, as all that is seen emits; and those behind absorbing media, whose
/// light passes by chance: of 65,536 paths the error is at most 0.002, a fifth of what is allowed.
const CLEAR: (u32, f32) = (16, 2e-3);
const FOGGY: (u32, f32) = (4_096, 0.01);

/// The mean of the Stokes vectors of a 4 x 4 film.
fn stokes(document: Document, integrator: Integrator, samples: u32) -> [f32; 4] {
    let scene = scene::<1>(&document.load("contact"), MONO, [4, 4]);
    let image = image(&scene, &settings(integrator, Mode::Polarized, MONO, samples, 8));
    std::array::from_fn(|component| image.planes[component].iter().sum::<f32>() / 16.0)
}

fn expect(found: [f32; 4], expected: [f32; 4], most: f32, what: &str) {
    let differ =
        found.iter().zip(expected).any(|(found, expected)| (found - expected).abs() > most);
    assert!(!differ, "{found:?}, not {expected:?}: {what}");
}

/// A display that is seen from straight before, and sheets on it, the nearest first.
fn display(sheets: &[Value], gap: f32, scale: f32) -> Document {
    let mut scene = Document::default();
    let face = scene.material(json!({"bsdf": "absorber"}));
    let face = scene.emits(face, 1.0);
    scene.quad(Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale, face);
    for sheet in sheets {
        let sheet = scene.material(sheet.clone());
        scene.quad(Vec3::Z * gap * scale, Vec3::X * 0.9 * scale, Vec3::Y * 0.9 * scale, sheet);
    }
    scene.perspective(Vec3::Z * 3.0 * scale, Vec3::ZERO, 0.05, None);
    scene
}

#[test]
fn sheets_laid_on_a_display_filter_it() {
    let polarizer = json!({"bsdf": "polarizer", "axis_deg": 0});
    let plate = json!({"bsdf": "retarder", "axis_deg": 45, "retardance_deg": 90});
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        for (gap, scale) in GAPS.into_iter().flat_map(|gap| [(gap, 1.0), (gap, 0.01), (gap, 300.0)])
        {
            let what = format!("gap {gap}, scale {scale}, {integrator:?}");
            let one = display(std::slice::from_ref(&polarizer), gap, scale);
            expect(stokes(one, integrator, CLEAR.0), [0.5, 0.5, 0.0, 0.0], CLEAR.1, &what);
            let circular = display(&[polarizer.clone(), plate.clone()], gap, scale);
            let [s0, s1, s2, s3] = stokes(circular, integrator, CLEAR.0);
            expect([s0, s1, s2, s3.abs()], [0.5, 0.0, 0.0, 0.5], CLEAR.1, &what);
            let turned = display(&[plate.clone(), polarizer.clone()], gap, scale);
            expect(stokes(turned, integrator, CLEAR.0), [0.5, 0.5, 0.0, 0.0], CLEAR.1, &what);
        }
    }
}

/// Sheets that lie on nothing but each other: the first of the file is the first along the axis.
#[test]
fn sheets_in_one_place_stand_in_the_order_of_the_file() {
    let polarizer = json!({"bsdf": "polarizer", "axis_deg": 0});
    let plate = json!({"bsdf": "retarder", "axis_deg": 45, "retardance_deg": 90});
    for (sheets, eye, circular) in [
        ([&polarizer, &plate], 3.0, 0.5),
        ([&plate, &polarizer], 3.0, 0.0),
        ([&polarizer, &plate], -3.0, 0.0),
        ([&plate, &polarizer], -3.0, 0.5),
    ] {
        let mut scene = Document::default();
        scene.environment(1.0);
        for sheet in sheets {
            let sheet = scene.material(sheet.clone());
            scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, sheet);
        }
        scene.perspective(Vec3::Z * eye, Vec3::ZERO, 0.05, None);
        let [s0, s1, _, s3] = stokes(scene, Integrator::Path, CLEAR.0);
        let expected = [0.5, 0.5 - circular, 0.0, circular];
        expect([s0, s1.abs(), 0.0, s3.abs()], expected, CLEAR.1, &format!("{sheets:?} from {eye}"));
    }
}

/// Glass, of one mesh or of six, on a display: there is air between, and nothing gets under it.
#[test]
fn glass_stands_on_what_it_touches() {
    let gaps = GAPS.into_iter().chain([1e-6, 1e-5, 1e-3]);
    for (gap, is_first) in gaps.flat_map(|gap| [(gap, true), (gap, false)]) {
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            let mut scene = Document::default();
            let face = scene.material(json!({"bsdf": "absorber"}));
            let face = scene.emits(face, 1.0);
            let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
            let mut add = |is_glass: bool| {
                if is_glass {
                    let half = Vec3::new(0.8, 0.8, 0.25);
                    scene.cuboid(Vec3::Z * (0.25 + gap), half, glass);
                } else {
                    scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, face);
                }
            };
            for is_glass in [is_first, !is_first] {
                add(is_glass);
            }
            scene.perspective(Vec3::Z * 3.0, Vec3::ZERO, 0.05, None);
            // Of all reflections within a plate: (1 - R) / (1 + R).
            let expected = 2.0 * 1.5 / (1.5 * 1.5 + 1.0);
            let what = format!("gap {gap}, first {is_first}, {integrator:?}");
            // The error of 65,536 samples is 0.001.
            expect(stokes(scene, integrator, FOGGY.0), [expected, 0.0, 0.0, 0.0], 6e-3, &what);
        }
    }
}

/// Light through two bodies of fog side by side, one within the other, and in a box whose walls
/// they share: Bouguer's law.
#[test]
fn media_that_touch_end_where_the_others_begin() {
    let absorbing = |sigma: f64| json!({"phase": "isotropic", "sigma_a": sigma, "sigma_s": 0.0});
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        for (of_first, swapped) in [(0.5_f32, false), (0.5, true), (0.3, false)] {
            let mut scene = Document::default();
            let wall = scene.material(json!({"bsdf": "absorber"}));
            let wall = scene.emits(wall, 1.0);
            scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, wall);
            let media = [scene.medium(absorbing(1.0)), scene.medium(absorbing(2.0))];
            let mut boxes = [(media[0], [0.0, of_first]), (media[1], [of_first, 1.0])];
            if swapped {
                boxes.reverse();
            }
            for (medium, [low, high]) in boxes {
                scene.fog(medium, |scene, null| {
                    let center = Vec3::Z * 0.5 * (low + high);
                    scene.cuboid(center, Vec3::new(1.0, 1.0, 0.5 * (high - low)), null);
                });
            }
            scene.perspective(Vec3::Z * 3.0, Vec3::ZERO, 0.05, None);
            let expected = (-of_first - 2.0 * (1.0 - of_first)).exp();
            let what = format!("{of_first}, swapped {swapped}, {integrator:?}");
            expect(stokes(scene, integrator, FOGGY.0), [expected, 0.0, 0.0, 0.0], FOGGY.1, &what);
        }
    }
}

/// A spot in the face of a body of fog, and a camera in that of another: as a millimeter before.
#[test]
fn lamps_and_cameras_on_boundaries_are_before_them() {
    let shone = |above: f32, integrator: Integrator| {
        let mut scene = Document::default();
        let floor = scene.diffuse(0.8);
        scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, floor);
        let fog = json!({"phase": "isotropic", "sigma_a": 1.0, "sigma_s": 0.0});
        let fog = scene.medium(fog);
        scene.fog(fog, |scene, null| {
            scene.cuboid(Vec3::Z, Vec3::new(0.5, 0.5, 0.5), null);
        });
        let spot = json!({"type": "spot", "intensity": 10.0,
            "spot": {"innerConeAngle": 0.03, "outerConeAngle": 0.05}});
        scene.light(spot, Vec3::Z * (1.5 + above), Vec3::NEG_Z);
        scene.perspective(vec3(0.1, 0.0, 1.5 + above), Vec3::ZERO, 0.02, None);
        stokes(scene, integrator, FOGGY.0)[0]
    };
    let expected = shone(1e-3, Integrator::Path);
    assert!(expected > 0.1, "{expected}");
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Light] {
        let found = shone(0.0, integrator);
        // Of 65,536 paths one in seven comes through: that is one percent of noise.
        assert!((found / expected - 1.0).abs() < 0.05, "{found}, {expected}: {integrator:?}");
    }
}

/// Bodies of fog of six walls each, of which some are in the planes of others': an arm that ends
/// in the face of a plate, boxes that are stacked, and one in the corner of another.
#[test]
fn bodies_of_many_walls_hold_together() {
    type Body = (Vec3, Vec3, usize);
    let sigma = [1.0_f32, 2.0];
    let cases: [(&str, &[Body], f32); 4] = [
        (
            "an arm in a plate",
            &[
                (vec3(-0.4, -0.4, 0.5), vec3(0.4, 0.4, 2.0), 0),
                (vec3(-0.6, -0.6, 1.5), vec3(0.6, 0.6, 2.0), 1),
            ],
            1.0 * sigma[0] + 0.5 * sigma[1],
        ),
        (
            "stacked ones of one medium",
            &[
                (vec3(-0.5, -0.5, 0.0), vec3(0.5, 0.5, 0.5), 0),
                (vec3(-0.5, -0.5, 0.5), vec3(0.5, 0.5, 1.0), 0),
            ],
            sigma[0],
        ),
        (
            "three side by side on the floor",
            &[
                (vec3(-0.9, -0.5, 0.0), vec3(-0.3, 0.5, 0.5), 0),
                (vec3(-0.3, -0.5, 0.0), vec3(0.3, 0.5, 0.5), 0),
                (vec3(0.3, -0.5, 0.0), vec3(0.9, 0.5, 0.5), 0),
            ],
            0.5 * sigma[0],
        ),
        (
            "one in the corner of another",
            &[
                (vec3(-0.5, -0.5, 0.5), vec3(0.5, 0.5, 1.5), 0),
                (vec3(-0.5, -0.5, 0.5), vec3(0.2, 0.2, 0.75), 1),
            ],
            0.75 * sigma[0] + 0.25 * sigma[1],
        ),
    ];
    for (what, bodies, depth) in cases {
        for is_reversed in [false, true] {
            let mut scene = Document::default();
            let wall = scene.material(json!({"bsdf": "absorber"}));
            let wall = scene.emits(wall, 1.0);
            scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, wall);
            let absorbing =
                |sigma: f32| json!({"phase": "isotropic", "sigma_a": sigma, "sigma_s": 0.0});
            let media = sigma.map(|sigma| scene.medium(absorbing(sigma)));
            let mut bodies = bodies.to_vec();
            if is_reversed {
                bodies.reverse();
            }
            for (low, high, medium) in bodies {
                let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
                scene.fog(media[medium], |scene, null| scene.cuboid(center, half, null));
            }
            scene.perspective(Vec3::Z * 3.0, Vec3::ZERO, 0.05, None);
            let expected = [(-depth).exp(), 0.0, 0.0, 0.0];
            let found = stokes(scene, Integrator::Path, FOGGY.0);
            expect(found, expected, FOGGY.1, &format!("{what}, reversed {is_reversed}"));
        }
    }
}

/// A shell of fog on a ball of another: within a sphere as between planes.
#[test]
fn media_of_one_sphere_are_one_within_the_other() {
    let mut scene = Document::default();
    let wall = scene.material(json!({"bsdf": "absorber"}));
    let wall = scene.emits(wall, 1.0);
    scene.quad(Vec3::Z * -2.0, Vec3::X, Vec3::Y, wall);
    let fog = scene.medium(json!({"phase": "isotropic", "sigma_a": 1.0, "sigma_s": 0.0}));
    let matched = scene.material(json!({"bsdf": "thin_dielectric", "ior": 1.0}));
    scene.fog(fog, |scene, null| scene.sphere(Vec3::ZERO, 0.5, null));
    scene.sphere(Vec3::ZERO, 0.5, matched);
    scene.perspective(Vec3::Z * 3.0, Vec3::ZERO, 0.02, None);
    let expected = (-1.0_f32).exp();
    expect(
        stokes(scene, Integrator::Path, FOGGY.0),
        [expected, 0.0, 0.0, 0.0],
        FOGGY.1,
        "a ball of fog in a shell",
    );
}

/// What touches nothing, or only at its edges, stays where the file puts it, to the bit.
#[test]
fn what_lies_on_nothing_is_not_moved() {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    scene.quad(Vec3::ZERO, Vec3::X, Vec3::Y, floor);
    let polarizer = scene.material(json!({"bsdf": "polarizer"}));
    let places = [
        // A millimeter above, beside in the same plane, and standing on it.
        (Vec3::Z * 1e-3, Vec3::X, Vec3::Y),
        (Vec3::X * 2.0, Vec3::X, Vec3::Y),
        (Vec3::Z, Vec3::X, Vec3::Z),
    ];
    for (center, u, v) in places {
        scene.quad(center, u, v, polarizer);
    }
    scene.environment(1.0);
    scene.perspective(Vec3::Z * 3.0, Vec3::ZERO, 0.05, None);
    let shapes = bake(&scene.load("apart"), &Carried::at([550.0])).expect("a scene").shapes;
    for ((center, u, v), triangle) in places.iter().zip(shapes.triangles[2..].chunks(2)) {
        let corners = [*center - *u - *v, *center + *u + *v];
        for corner in corners {
            let all = triangle.iter().flat_map(|triangle| triangle.corners);
            assert!(all.into_iter().any(|there| there == corner), "{corner} is moved");
        }
    }
}
