//! The shipped scenes, baked: counts, places and cameras.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use sunstone::internals::scene::baked::{BakedScene, KEEP, NONE, Phase, Projection, Surface};
use sunstone::internals::scene::emitter::{self, Emitter, EmitterModel};
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;

const GREEN: Carried<1> = Carried::at([550.0]);

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

fn baked(name: &str) -> BakedScene<1> {
    let world = load(&scene(name)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(world.warnings(), [] as [String; 0], "{name}");
    bake(&world, &GREEN).unwrap_or_else(|error| panic!("{error}"))
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

#[track_caller]
fn assert_near(a: Vec3, b: Vec3) {
    assert!(near(a, b), "{a} is not {b}");
}

fn emitting_triangle(emitter: &Emitter) -> Option<emitter::Triangle> {
    let EmitterModel::Triangle(triangle) = emitter.model else { return None };
    Some(triangle)
}

/// The two triangles of every rectangle whose material has the wanted property, as corners.
fn emitting_corners(scene: &BakedScene<1>) -> Vec<Vec3> {
    let triangles = scene.optics.emitters.iter().filter_map(emitting_triangle);
    triangles.flat_map(|row| scene.shapes.triangles[row.primitive as usize].corners).collect()
}

fn normal(scene: &BakedScene<1>, triangle: usize) -> Vec3 {
    let [a, b, c] = scene.shapes.triangles[triangle].corners;
    (b - a).cross(c - a).normalize()
}

#[test]
fn cornell() {
    let scene = baked("reference/cornell.gltf");
    assert_eq!(
        (scene.shapes.triangles.len(), scene.shapes.spheres.len(), scene.shapes.surfaces.len()),
        (12, 2, 8)
    );
    assert!(scene.shapes.shading_normals.is_empty());
    assert_near(scene.shapes.spheres[0].center, Vec3::new(0.45, -0.6, 0.35));
    assert!((scene.shapes.spheres[0].radius - 0.38).abs() < 1e-6);
    assert_near(scene.shapes.spheres[1].center, Vec3::new(-0.42, -0.55, -0.25));
    let models: Vec<SurfaceModel<[f32; 1]>> =
        scene.optics.materials.iter().map(|material| material.model.clone()).collect();
    let diffuse = |reflectance| SurfaceModel::Diffuse { reflectance: [reflectance] };
    let glass = SurfaceModel::Dielectric { ior: 1.5, exterior_ior: 1.0 };
    let metal = SurfaceModel::Conductor { eta: [0.9586], k: [6.687] };
    let walls = [0.73, 0.60, 0.30].map(diffuse);
    assert_eq!(models, [&walls[..], &[SurfaceModel::Absorber, glass, metal]].concat());

    assert_eq!(scene.optics.emitters.len(), 2);
    let total: f32 = scene.optics.emitters.iter().map(|row| row.probability).sum();
    assert!((total - 1.0).abs() < 1e-6);
    for (index, row) in scene.optics.emitters.iter().enumerate() {
        let triangle = emitting_triangle(row).unwrap();
        assert_eq!((scene.optics.radiance_of(index), triangle.two_sided), ([6.0], false));
        assert!((triangle.area - 0.5).abs() < 1e-6);
        assert_near(normal(&scene, triangle.primitive as usize), Vec3::NEG_Y);
    }
    for corner in emitting_corners(&scene) {
        assert_near(corner.abs(), Vec3::new(0.5, 0.995, 0.5));
    }
    assert_eq!(scene.optics.emitter_of_primitive.iter().filter(|&&row| row != NONE).count(), 2);
    // All walls face the middle of the box.
    for (triangle, row) in scene.shapes.triangles.iter().enumerate().take(10) {
        assert!(normal(&scene, triangle).dot(-row.corners[0]) > 0.9);
    }
    assert!((scene.shapes.bounds.radius - 3f32.sqrt()).abs() < 1e-3);

    assert_near(scene.camera.position, Vec3::new(0.0, 0.0, 3.9));
    assert_eq!(scene.camera.forward, Vec3::NEG_Z);
    assert_eq!((scene.camera.right, scene.camera.up), (Vec3::X, Vec3::Y));
    assert_eq!(scene.camera.resolution, Some([64, 64]));
    let Projection::Perspective { tan_half_y, aspect, aperture_radius, .. } =
        scene.camera.projection
    else {
        panic!("not a perspective camera");
    };
    assert!((tan_half_y - 19.5f32.to_radians().tan()).abs() < 1e-6);
    assert_eq!((aspect, aperture_radius), (Some(1.0), 0.0));
}

#[test]
fn mirror() {
    let scene = baked("reference/mirror.gltf");
    // floor, wall, mirror and light of two triangles, two cubes of twelve.
    assert_eq!((scene.shapes.triangles.len(), scene.shapes.spheres.len()), (32, 3));
    assert!(scene.shapes.shading_normals.is_empty());
    let of = |triangle: usize| scene.shapes.surface_of_primitive[triangle] as usize;
    // The back wall looks towards -z, the plane mirror back at the big sphere.
    assert_near(normal(&scene, 2), Vec3::NEG_Z);
    assert_near(scene.shapes.triangles[2].corners[0].abs(), Vec3::new(14.0, 14.0, 12.0));
    let plane = normal(&scene, 28);
    let angle = (-140f32).to_radians();
    assert_near(plane, Vec3::new(angle.sin(), 0.0, angle.cos()));
    let material = &scene.optics.materials[scene.shapes.surfaces[of(28)].material as usize];
    assert!(matches!(material.model, SurfaceModel::Conductor { .. }) && !material.two_sided);
    // Cube 1: centered, outward normals.
    let center = Vec3::new(-2.5, -1.2, 7.5);
    for triangle in 4..16 {
        let out = scene.shapes.triangles[triangle].corners.iter().sum::<Vec3>() / 3.0 - center;
        assert!(normal(&scene, triangle).dot(out) > 0.79);
        for corner in scene.shapes.triangles[triangle].corners {
            assert!(((corner - center).length() - 0.8 * 3f32.sqrt()).abs() < 1e-5);
        }
    }
    for corner in emitting_corners(&scene) {
        assert!((corner.y - 6.0).abs() < 1e-6 && (3.0..=7.0).contains(&corner.z));
    }
    let forward = Vec3::new(0.0, -0.5, -6.5).normalize();
    assert_near(scene.camera.forward, forward);
    assert_near(scene.camera.right, Vec3::X);
    assert_near(scene.camera.up, Vec3::X.cross(forward));
}

#[test]
fn brewster() {
    let scene = baked("reference/brewster.gltf");
    assert_eq!((scene.shapes.triangles.len(), scene.shapes.spheres.len()), (4, 0));
    assert_near(normal(&scene, 0), Vec3::Y);
    let origin = Vec3::new(0.0, 6.656_402, -9.984_603);
    assert_near(normal(&scene, 2), -origin.normalize());
    let middle = emitting_corners(&scene).iter().sum::<Vec3>() / 6.0;
    assert!((middle - origin).length() < 5.0);
    let tangent = scene.camera.position.z / scene.camera.position.y;
    assert!((tangent - 1.5).abs() < 1e-6, "the camera sits at Brewster's angle");
    assert_near(scene.camera.forward, -scene.camera.position.normalize());
}

#[test]
fn polarizers() {
    let scene = baked("reference/polarizers.gltf");
    assert_eq!(scene.shapes.triangles.len(), 2 * (1 + 3 + 2 + 3 + 2 + 3 + 2 + 2));
    let Projection::Orthographic { half_width, half_height } = scene.camera.projection else {
        panic!("not an orthographic camera");
    };
    assert_eq!((half_width, half_height), (1.5, 1.5));
    assert_eq!(scene.camera.forward, Vec3::NEG_Z);
    assert_eq!(scene.camera.resolution, Some([128, 128]));
    let surface = |triangle: usize| {
        scene.shapes.surfaces[scene.shapes.surface_of_primitive[triangle] as usize]
    };
    let model =
        |triangle: usize| scene.optics.materials[surface(triangle).material as usize].model.clone();
    let polarizer = |axis_deg| {
        let extinction_ratio = f64::INFINITY;
        SurfaceModel::Polarizer { axis_deg, extinction_ratio }
    };
    assert_eq!(model(2), polarizer(0.0));
    // Mitsuba's 30 degrees are clockwise.
    assert_eq!(model(4), polarizer(-30.0));
    // The third is turned with its node.
    assert_eq!(model(6), polarizer(0.0));
    assert_near(surface(6).axis_x, Vec3::new(0.866_025_4, 0.5, 0.0));
    assert_near(surface(6).axis_y, Vec3::new(-0.5, 0.866_025_4, 0.0));
    assert_eq!(model(20), SurfaceModel::Retarder { axis_deg: 45.0, retardance_deg: 90.0 });
    // A stack is ordered towards the camera.
    assert!((scene.shapes.triangles[16].corners[0].z - 0.6).abs() < 1e-6);
}

/// The surface of a triangle.
fn surface<const N: usize>(scene: &BakedScene<N>, triangle: usize) -> Surface {
    scene.shapes.surfaces[scene.shapes.surface_of_primitive[triangle] as usize]
}

#[test]
fn rayleigh() {
    let scene = baked("reference/rayleigh.gltf");
    assert_eq!((scene.shapes.triangles.len(), scene.shapes.spheres.len()), (14, 0));
    for triangle in 0..12 {
        let surface = surface(&scene, triangle);
        assert_eq!((surface.interior, surface.exterior), (0, NONE));
        assert_eq!(scene.optics.materials[surface.material as usize].model, SurfaceModel::Null);
        for corner in scene.shapes.triangles[triangle].corners {
            assert_near(corner.abs(), Vec3::splat(0.5));
            assert!(normal(&scene, triangle).dot(corner) > 0.49);
        }
    }
    let medium = &scene.optics.media[0];
    assert_eq!((medium.sigma_a, medium.sigma_s, scene.shapes.scene_medium), ([0.0], [1.0], NONE));
    assert!(matches!(&medium.phase, Phase::Table(table) if table.spheres && table.achromatic));
    assert_near(normal(&scene, 12), Vec3::X);
    assert!(emitting_corners(&scene).iter().all(|corner| (corner.x + 3.0).abs() < 1e-6));
    assert_eq!(scene.optics.radiance_of(0), [10.0]);
    let eye = Vec3::new(0.8, 0.9, 4.0);
    assert_near(scene.camera.position, eye);
    assert_near(scene.camera.forward, -eye.normalize());
}

#[test]
fn tank_of_the_reference() {
    let scene = baked("reference/tank.gltf");
    assert_eq!(scene.shapes.triangles.len(), 12 + 2 + 2 + 3674 + 2);
    assert!(scene.shapes.shading_normals.is_empty(), "the bunny has facets");
    let glass = surface(&scene, 0);
    assert_eq!((glass.interior, glass.exterior), (0, NONE));
    let model = scene.optics.materials[glass.material as usize].model.clone();
    assert_eq!(model, SurfaceModel::Dielectric { ior: 1.5, exterior_ior: 1.0 });
    for corner in scene.shapes.triangles[..12].iter().flat_map(|triangle| triangle.corners) {
        assert_near(corner.abs(), Vec3::new(1.2, 0.9, 0.8));
    }
    let medium = &scene.optics.media[0];
    assert_eq!((medium.sigma_a, medium.sigma_s), ([0.012], [0.588]));
    assert_eq!(medium.phase, Phase::HenyeyGreenstein { g: [0.8] });
    for (triangle, reflectance, two_sided) in [(12, 0.7, true), (14, 0.7, true), (16, 0.5, false)] {
        let surface = surface(&scene, triangle);
        let row = scene.optics.materials[surface.material as usize].clone();
        let model = SurfaceModel::Diffuse { reflectance: [reflectance] };
        assert_eq!((row.model, row.two_sided), (model, two_sided));
        assert_eq!((surface.interior, surface.exterior), (KEEP, KEEP));
    }
    let bunny = scene.shapes.triangles[16..16 + 3674].iter().flat_map(|triangle| triangle.corners);
    let (low, high) = bunny.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| {
        (low.min(corner), high.max(corner))
    });
    assert!(near(low, Vec3::new(-0.595_847_5, -0.790_314_9, -0.372_983_3)), "{low}");
    assert!(near(high, Vec3::new(0.394_885, 0.175_474_8, 0.381_063_9)), "{high}");
}

/// Signed volume that the triangles of some surfaces enclose with the origin; the right one if
/// they are closed.
fn volume(scene: &BakedScene<3>, wanted: impl Fn(&Surface) -> bool) -> f64 {
    let triangles = (0..scene.shapes.triangles.len()).filter(|&row| wanted(&surface(scene, row)));
    triangles
        .map(|row| {
            let [a, b, c] = scene.shapes.triangles[row].corners.map(|corner| corner.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

#[test]
fn mirror_to_look_at() {
    let world = load(&scene("mirror.gltf")).unwrap_or_else(|error| panic!("{error}"));
    let scene = bake(&world, &Carried::RGB).unwrap();
    assert_eq!((scene.shapes.spheres.len(), scene.optics.emitters.len()), (3, 1));
    assert!(matches!(scene.optics.emitters[0].model, EmitterModel::Point(_)));
    assert_eq!(scene.optics.radiance_of(0), [46.0, 43.0, 37.0]);
    assert_eq!((world.warnings(), scene.camera.resolution), (&[][..], Some([512, 512])));
}

#[test]
fn tank_to_look_at() {
    let world = load(&scene("tank.gltf")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(world.warnings(), [] as [String; 0]);
    let scene = bake(&world, &Carried::RGB).unwrap();
    let model = |surface: &Surface| scene.optics.materials[surface.material as usize].model.clone();
    // 1 where it is no dielectric.
    let ior = |surface: &Surface| match model(surface) {
        SurfaceModel::Dielectric { ior, exterior_ior } => ior / exterior_ior,
        _ => 1.0,
    };
    let milk = |surface: &Surface| surface.interior == 0;
    // Milk and glass are closed, the glass where the milk bounds it too.
    let (x, z, wall) = (0.320, 0.220, 0.016);
    let of_milk = (x - wall) * (z - wall) * (0.175 - 0.008);
    assert!((volume(&scene, milk) / of_milk - 1.0).abs() < 1e-5);
    let glass = |surface: &Surface| ior(surface) != 1.0 && !milk(surface);
    let of_glass = x * z * 0.210 - (x - wall) * (z - wall) * (0.210 - 0.008);
    let wet = |surface: &Surface| milk(surface) && ior(surface) < 1.0;
    let found = volume(&scene, glass) - volume(&scene, wet);
    assert!((found / of_glass - 1.0).abs() < 1e-4, "{found} {of_glass}");
    let iors: Vec<f32> = scene.shapes.surfaces.iter().filter(|s| milk(s)).map(&ior).collect();
    assert_eq!(iors, [1.33 / 1.5, 1.33]);
    assert!(scene.shapes.surfaces.iter().all(|s| !milk(s) || s.exterior == NONE));
    let depth = (scene.optics.media[0].sigma_a[1] + scene.optics.media[0].sigma_s[1]) * 0.204;
    assert!((2.0..3.0).contains(&depth), "{depth} mean free paths");
    let inside = scene.shapes.triangles.iter().enumerate().filter(|(row, _)| {
        matches!(model(&surface(&scene, *row)), SurfaceModel::Diffuse { .. })
            && *row < scene.shapes.triangles.len() - 4
    });
    for corner in inside.flat_map(|(_, triangle)| triangle.corners) {
        assert!(corner.x.abs() < 0.15 && corner.z.abs() < 0.10, "{corner}");
        assert!((0.011..0.176).contains(&corner.y), "{corner}");
    }
}

#[test]
fn colored_scenes_bake_in_rgb_and_at_one_wavelength() {
    for name in ["cornell.gltf", "caustic_glass.gltf"] {
        let world = load(&scene(name)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.warnings(), [] as [String; 0]);
        let rgb = bake(&world, &Carried::RGB).unwrap();
        assert!(rgb.shapes.shading_normals.is_empty());
        assert_eq!(rgb.camera.resolution, Some([512, 512]));
        let radiance = rgb.optics.radiance_of(0);
        assert!(radiance[0] > radiance[1] && radiance[1] > radiance[2]);
        let mono = bake(&world, &GREEN).unwrap();
        // Between red and blue, where a smooth spectrum of a warm white is.
        let [green] = mono.optics.radiance_of(0);
        assert!((green / radiance[1] - 1.0).abs() < 0.1, "{green} {radiance:?}");
        assert!(world.describe().contains("smooth dielectric"));
    }
}

#[test]
fn the_files_are_what_the_generators_write() {
    for script in ["generate.py", "materials.py"] {
        let check = Command::new("python3").arg(scene(script)).arg("--check").output();
        // Machines without Python take the files as they are.
        if let Ok(output) = check {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
