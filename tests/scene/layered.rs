//! Layers of what the camera sees first, against closed forms.

use std::io::Cursor;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use image::{ImageBuffer, ImageFormat, Rgba};
use sunstone::internals::image::StokesImage;
use sunstone::internals::image::layers::{LayerKind, plane};
use sunstone::internals::image::texels::{Coding, Texels};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Options, PlacedWorld, Renderer, Settings};
use sunstone::internals::scene::World;
use sunstone::world::{
    Bsdf, Filter, Geometry, Lens, Material, Medium, Paint, Parameter, Phase, Picture, Punctual,
    Reads, Skin, Texture, Textures, Wrap,
};

const SIZE: [u32; 2] = [24, 16];

fn options() -> Options {
    Options {
        integrator: Some(Integrator::Path),
        width: Some(SIZE[0]),
        height: Some(SIZE[1]),
        samples: 1,
        layers: LayerKind::ALL.to_vec(),
        ..Options::default()
    }
}

fn image(world: World, options: Options) -> StokesImage {
    let world = PlacedWorld::new(world).unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings::new(options).unwrap();
    let mut renderer = Renderer::new(&world, &settings).unwrap_or_else(|error| panic!("{error}"));
    renderer.step();
    renderer.finish()
}

fn of<'a>(image: &'a StokesImage, name: &str) -> &'a [f32] {
    plane(&image.layers, name).unwrap_or_else(|| panic!("no {name}"))
}

/// A pinhole at `eye` that looks along -z, and a lamp that nobody sees.
fn begun(eye: DVec3, yfov: f64) -> World {
    let mut world = World::new("layers");
    let place = DAffine3::from_translation(eye);
    world.set_camera("camera", Lens::pinhole(yfov), place).unwrap();
    world.add_light("lamp", Punctual::point(1.0), DAffine3::from_translation(eye)).unwrap();
    world
}

/// The ray of a pixel's center, by depth: x and y at depth 1.
fn slopes(pixel: usize, yfov: f64) -> [f64; 2] {
    let [width, height] = SIZE.map(f64::from);
    let [x, y] = [pixel % SIZE[0] as usize, pixel / SIZE[0] as usize].map(|it| it as f64 + 0.5);
    let half = (0.5 * yfov).tan();
    [(2.0 * x / width - 1.0) * half * width / height, (1.0 - 2.0 * y / height) * half]
}

/// A tilted plane, far from where the scene has its origin: z = -4 + x / 2 before the camera.
/// Means over a pixel are those at its center but for its curvature.
#[test]
fn a_plane_is_as_deep_as_it_is() {
    let eye = DVec3::new(1000.0, -2000.0, 500.0);
    let yfov = 0.7;
    let mut world = begun(eye, yfov);
    let red = world.add_material("red", Bsdf::diffuse([0.8, 0.2, 0.1])).unwrap();
    let quad = Geometry::quad(
        (eye + DVec3::new(0.0, 0.0, -4.0)).as_vec3(),
        Vec3::new(8.0, 0.0, 4.0),
        Vec3::new(0.0, 8.0, 0.0),
    );
    world.add_mesh("wall", quad, red, DAffine3::IDENTITY).unwrap();
    let image = image(world, options());
    let normal = DVec3::new(-0.5, 0.0, 1.0).normalize();
    for pixel in 0..(SIZE[0] * SIZE[1]) as usize {
        let [x, y] = slopes(pixel, yfov);
        // -depth = -4 + depth x / 2.
        let depth = 4.0 / (1.0 + 0.5 * x);
        let close = |name: &str, expected: f64, tolerance: f64| {
            let found = f64::from(of(&image, name)[pixel]);
            assert!((found - expected).abs() < tolerance, "{name} {pixel}: {found}, {expected}");
        };
        close("depth.Z", depth, 0.01);
        let position = eye + DVec3::new(x, y, -1.0) * depth;
        for (name, (expected, normal)) in
            ["X", "Y", "Z"].into_iter().zip(position.to_array().into_iter().zip(normal.to_array()))
        {
            close(&format!("position.{name}"), expected, 0.02);
            close(&format!("normal.{name}"), normal, 1e-5);
        }
        for (name, expected) in [("R", 0.8), ("G", 0.2), ("B", 0.1)] {
            close(&format!("albedo.{name}"), expected, 1e-6);
        }
        close("material.id", 1.0, 0.0_f64.next_up());
        close("object.id", 1.0, 0.0_f64.next_up());
    }
    assert_eq!(image.metadata("materials"), Some("[\"red\"]"));
    assert_eq!(image.metadata("objects"), Some("[\"wall\"]"));
}

/// A ball of glass in a ball of air, before nothing and before a wall: its own normals point to the
/// camera; a boundary that bends nothing is looked through; what is behind glass is not seen.
#[test]
fn a_ball_of_glass_is_seen_and_not_what_is_behind() {
    let yfov = 0.5;
    let mut world = begun(DVec3::ZERO, yfov);
    let air = world.add_material("air", Bsdf::Null).unwrap();
    let glass = Bsdf::Dielectric { ior: 1.5, exterior_ior: 1.0 };
    let glass = world.add_material("glass", glass).unwrap();
    let gold = world.add_material("gold", Bsdf::metal("Au").unwrap()).unwrap();
    let at = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
    let haze = Medium::new(0.0, 0.001, Phase::isotropic());
    let haze = world.add_medium("haze", haze).unwrap();
    world.add_sphere("shell", 1.5, Skin::from(air).interior(haze), at(-10.0)).unwrap();
    world.add_sphere("ball", 1.0, glass, at(-10.0)).unwrap();
    let wall = Geometry::quad(Vec3::new(-20.0, 0.0, -20.0), Vec3::X * 20.0, Vec3::Y * 40.0);
    world.add_mesh("wall", wall, gold, DAffine3::IDENTITY).unwrap();
    let image = image(world, options());
    let names = image.metadata("objects").unwrap();
    assert_eq!(names, "[\"wall\",\"shell\",\"ball\"]");
    let [mut balls, mut walls, mut nothing] = [0; 3];
    for pixel in 0..(SIZE[0] * SIZE[1]) as usize {
        let [x, y] = slopes(pixel, yfov);
        let ray = DVec3::new(x, y, -1.0).normalize();
        let center = DVec3::new(0.0, 0.0, -10.0);
        let along = ray.dot(center);
        let past = (center - ray * along).length();
        let normal =
            DVec3::from([0, 1, 2].map(|axis| {
                f64::from(of(&image, ["normal.X", "normal.Y", "normal.Z"][axis])[pixel])
            }));
        let value = |name: &str| of(&image, name)[pixel];
        // A pixel is 0.32 wide there; those on the rim are a mixture.
        match past {
            0.0..0.6 => {
                let hit = ray * (along - (1.0 - past * past).sqrt());
                assert!((normal - (hit - center)).length() < 0.08, "{pixel}: {normal}");
                assert!((f64::from(value("depth.Z")) + hit.z).abs() < 0.08);
                assert_eq!((value("object.id"), value("material.id")), (3.0, 2.0));
                assert_eq!(value("albedo.G"), 1.0);
                balls += 1;
            }
            1.3.. if x < -0.05 => {
                assert!((value("depth.Z") - 20.0).abs() < 1e-4, "{pixel}");
                assert_eq!((value("object.id"), value("material.id")), (1.0, 3.0));
                // Gold at normal incidence, red and blue: 0.97 and 0.37 or so.
                assert!(value("albedo.R") > 0.9 && value("albedo.B") < 0.5);
                walls += 1;
            }
            1.3.. if x > 0.05 => {
                assert_eq!(value("depth.Z"), f32::INFINITY);
                assert_eq!((normal, value("object.id")), (DVec3::ZERO, 0.0));
                assert_eq!(value("material.id") + value("albedo.R") + value("position.X"), 0.0);
                nothing += 1;
            }
            _ => {}
        }
    }
    assert!(balls > 6 && walls > 60 && nothing > 60, "{balls} {walls} {nothing}");
}

/// The reflectance by a picture of two texels, one of them black.
fn spotted() -> Textures {
    let image = ImageBuffer::from_fn(2, 1, |x, _| Rgba([255 * x as u8; 4]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let picture = Arc::new(Picture::new(Texels::decode(bytes.get_ref()).unwrap(), 0));
    let texture = Texture {
        picture,
        coding: Coding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Nearest,
        set: 0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let factor = [0.8, 0.6, 0.4];
    let paint = Paint { factor, texture: Some(texture), reads: Reads::Color, by_vertices: false };
    Textures { parameters: vec![(Parameter::Reflectance, paint)], ..Textures::default() }
}

/// Texture coordinates are those of the mesh at the center of a pixel, whatever the light is
/// carried at; a crop has the layers of its place; parallel rays have a depth, too.
#[test]
fn layers_are_those_of_the_place() {
    let mut world = World::new("uv");
    let white = world.add_material("white", Material::from(Bsdf::diffuse(0.5))).unwrap();
    world.set_textures(white, spotted()).unwrap();
    world.add_light("lamp", Punctual::point(1.0), DAffine3::IDENTITY).unwrap();
    let mut quad = Geometry::quad(Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 2.0);
    let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    quad.texture_coordinates = corners.map(glam::Vec2::from).to_vec();
    world.add_mesh("card", quad, white, DAffine3::IDENTITY).unwrap();
    let lens = Lens::Orthographic { half_width: 3.0, half_height: 2.0 };
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, 7.0));
    world.set_camera("camera", lens, place).unwrap();
    let placed = PlacedWorld::new(world).unwrap();
    let image = |options: Options| {
        let settings = Settings::new(options).unwrap();
        let mut renderer = Renderer::new(&placed, &settings).unwrap();
        renderer.step();
        renderer.finish()
    };
    let whole = image(options());
    for pixel in 0..(SIZE[0] * SIZE[1]) as usize {
        let [x, y] = [pixel % SIZE[0] as usize, pixel / SIZE[0] as usize];
        let expected = [x, y].map(|it| it as f32 + 0.5);
        let [u, v] = [of(&whole, "uv.U")[pixel], of(&whole, "uv.V")[pixel]];
        assert!((u - expected[0] / SIZE[0] as f32).abs() < 1e-5, "{pixel}: {u}");
        assert!((v - expected[1] / SIZE[1] as f32).abs() < 1e-5, "{pixel}: {v}");
        assert!((of(&whole, "depth.Z")[pixel] - 7.0).abs() < 1e-5);
        let green = if x < SIZE[0] as usize / 2 { 0.0 } else { 0.6 };
        assert!((of(&whole, "albedo.G")[pixel] - green).abs() < 1e-6, "{pixel}");
    }
    let color = sunstone::Color::Mono { wavelength_nm: 500.0 };
    let crop = "5,3,11,9".parse().ok();
    let part = image(Options { crop, color, ..options() });
    for (layer, of_whole) in part.layers.iter().zip(&whole.layers) {
        assert_eq!(layer.kind, of_whole.kind);
        for (plane, of_whole) in layer.planes.iter().zip(&of_whole.planes) {
            let row = |y: usize| &of_whole[y * SIZE[0] as usize + 5..][..6];
            let expected: Vec<f32> = (3..9).flat_map(row).copied().collect();
            assert_eq!(plane, &expected, "{:?}", layer.kind);
        }
    }
    let twice = vec![LayerKind::Uv, LayerKind::Uv];
    let error = Settings::new(Options { layers: twice, ..options() }).unwrap_err();
    assert_eq!(error.to_string(), "layers must be different ones");
    let part = "1/2".parse().ok();
    let error = Settings::new(Options { part, samples: 2, ..options() }).unwrap_err();
    assert!(error.to_string().starts_with("layers go without a part"), "{error}");
}
