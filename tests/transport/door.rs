//! What a program can do through the crate's door, and what is refused there.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::thread;

use rayon::prelude::*;
use sunstone::glam::{DVec3, Vec3};
use sunstone::particles::Milk;
use sunstone::world::{Bsdf, Geometry, Lens, Material, Phase, Transform};
use sunstone::{
    Color, Error, Integrator, Mode, Options, Photons, PlacedWorld, Renderer, Settings, StokesImage,
    Threads, White, World, load,
};

/// A room with a lamp, a glass sphere and a metal plate.
fn room() -> Result<World, Error> {
    let mut world = World::new("room");
    let wall = world.add_material("wall", Material::from(Bsdf::diffuse(0.7)).two_sided())?;
    let glass = world.add_material("glass", Bsdf::dielectric(1.5))?;
    let metal = world.add_material("plate", Bsdf::metal("Al")?)?;
    let glow = world.add_material("lamp", Material::emitter([20.0, 18.0, 15.0]).two_sided())?;
    let here = Transform::IDENTITY;
    world.add_mesh("walls", Geometry::cuboid(-Vec3::ONE, Vec3::ONE), wall, here)?;
    let lamp = Geometry::quad(Vec3::Y * 0.99, Vec3::X * 0.3, Vec3::Z * 0.3);
    world.add_mesh("lamp", lamp, glow, here)?;
    let plate = Geometry::quad(Vec3::Z * -0.9, Vec3::X * 0.5, Vec3::Y * 0.5);
    world.add_mesh("plate", plate, metal, here)?;
    world.add_sphere("ball", 0.4, glass, DVec3::new(0.2, -0.6, 0.0))?;
    let place = Transform::looking(DVec3::Z * 0.9, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(1.2), place)?;
    world.set_resolution([24, 16])?;
    Ok(world)
}

fn options() -> Options {
    let photons = Photons { per_iteration: Some(2000), samples: Some(4), ..Photons::default() };
    let integrator = Some(Integrator::Bdpt);
    Options { integrator, samples: 48, path_length_max: 6, photons, ..Options::default() }
}

fn done(world: &PlacedWorld, options: Options) -> StokesImage {
    let settings = Settings::new(options).expect("sound options");
    let mut renderer = Renderer::new(world, &settings).expect("a sound world");
    renderer.run(|_| ControlFlow::Continue(()));
    renderer.finish()
}

#[test]
fn a_room_is_made_rendered_stopped_and_read() -> Result<(), Error> {
    let settings = Settings::new(options())?;
    let mut renderer = Renderer::new(&PlacedWorld::new(room()?)?, &settings)?;
    let mut heard = Vec::new();
    renderer.run(|progress| {
        assert_eq!(progress.total, 48);
        assert!(progress.preview().planes[0].iter().any(|&value| value > 0.0));
        heard.push(progress.samples);
        if progress.samples < 32 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!(heard, [16, 32]);
    assert!(!renderer.is_done());
    let image = renderer.finish();
    assert_eq!(image.shape(), [16, 24, 3, 4]);
    assert_eq!(image.metadata("iterations"), Some("32"));
    assert_eq!(image.channel_names(), ["R", "G", "B"]);
    assert_eq!(image.component_names(), ["S0", "S1", "S2", "S3"]);
    let values = image.to_array();
    assert_eq!(values.len(), 16 * 24 * 3 * 4);
    for (component, channel, pixel) in [(0, 0, 0), (1, 2, 100), (3, 1, 16 * 24 - 1)] {
        let value = values[(pixel * 3 + channel) * 4 + component];
        assert_eq!(value, image.plane(component, channel)[pixel]);
    }
    // Glass and metal polarize.
    assert!(values.chunks_exact(4).any(|stokes| stokes[1..].iter().any(|s| s.abs() > 1e-3)));
    Ok(())
}

#[test]
fn an_unphysical_edit_of_a_loaded_scene_is_refused() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/reference/cornell.gltf");
    let mut world = load(&file).expect("a shipped scene");
    let diffuse = {
        let mut materials = world.entities().query::<(sunstone::hecs::Entity, &Bsdf)>();
        let is_diffuse = |(_, bsdf): &(_, &Bsdf)| matches!(bsdf, Bsdf::Diffuse { .. });
        materials.iter().find(is_diffuse).expect("walls").0
    };
    *world.entities_mut().get::<&mut Bsdf>(diffuse).expect("it is there") = Bsdf::diffuse(2.5);
    let error = PlacedWorld::new(world).err().expect("more than all light").to_string();
    for part in ["cornell.gltf", "reflectance", "2.5", "[0, 1]"] {
        assert!(error.contains(part), "{error} lacks {part}");
    }
}

/// A program's state: what is rendered, and the render at hand.
struct Viewer {
    world: PlacedWorld,
    renderer: Renderer,
}

#[test]
fn modes_alternate_on_one_scene() {
    let world = PlacedWorld::new(room().expect("sound")).expect("sound");
    let render = |mode| {
        let settings = Settings::new(Options { mode, ..options() }).expect("sound options");
        Renderer::new(&world, &settings).expect("a sound world")
    };
    let mut viewers = [Mode::Scalar, Mode::Polarized]
        .map(|mode| Viewer { world: world.clone(), renderer: render(mode) });
    for _ in 0..3 {
        viewers.iter_mut().for_each(|viewer| viewer.renderer.step());
    }
    for viewer in viewers {
        assert!(viewer.renderer.is_done());
        let mode = viewer.renderer.settings().mode;
        let alone = done(&viewer.world, Options { mode, ..options() });
        assert_eq!(viewer.renderer.finish().planes, alone.planes, "{mode:?}");
    }
}

#[test]
fn another_thread_stops_a_render() {
    let world = PlacedWorld::new(room().expect("sound")).expect("sound");
    let endless = Settings::new(Options { samples: 1 << 30, ..options() }).expect("sound options");
    let mut renderer = Renderer::new(&world, &endless).expect("a sound world");
    let (stop, mut waves) = (renderer.stop_handle(), 0);
    renderer.run(|_| {
        waves += 1;
        if waves == 2 {
            let stop = stop.clone();
            thread::spawn(move || stop.stop()).join().expect("it only stops");
        }
        ControlFlow::Continue(())
    });
    assert_eq!((waves, renderer.samples()), (2, 32));
    renderer.advance(16);
    assert_eq!(renderer.samples(), 32, "what is stopped stays so");
    let expected = done(&world, Options { samples: 32, ..options() });
    assert_eq!(renderer.finish().planes, expected.planes);
}

#[test]
fn neither_steps_nor_threads_change_a_bit() {
    let world = PlacedWorld::new(room().expect("sound")).expect("sound");
    let threads = Arc::new(Threads::start(Some(3)).expect("threads start"));
    for &integrator in Integrator::ALL {
        let options = Options { integrator: Some(integrator), ..options() };
        let whole = done(&world, options.clone());
        let settings = Settings::new(options).expect("sound options");
        let mut stepped = Renderer::new(&world, &settings).expect("sound").on(&threads);
        while !stepped.is_done() {
            stepped.step();
        }
        let mut advanced = Renderer::new(&world, &settings).expect("sound");
        advanced.advance(16);
        // With photons, up to the next whole iteration.
        advanced.advance(31 + u32::from(!integrator.shoots_photons()));
        assert_eq!(stepped.finish().planes, whole.planes, "{integrator:?}");
        assert_eq!(advanced.finish().planes, whole.planes, "{integrator:?}");
    }
}

/// A thread that waits for the tables of its render takes up others of the pool meanwhile, which
/// want the same tables.
#[test]
fn renders_of_one_pool_share_a_world() -> Result<(), Error> {
    let mut world = room()?;
    let milk = Milk { fat_percent: 0.0, protein_percent: 3.4, dilution: 0.01 };
    world.add_medium("milk", Phase::Milk(milk))?;
    let world = PlacedWorld::new(world)?;
    let options = Options { samples: 1, ..options() };
    let render = |_| done(&world, options.clone()).to_array();
    let images: Vec<Vec<f32>> =
        Threads::start(Some(2))?.run(|| (0..8).into_par_iter().map(render).collect());
    assert!(images.iter().all(|image| *image == images[0]));
    Ok(())
}

#[test]
fn settings_that_would_be_black_are_refused() {
    let ppm = Options { integrator: Some(Integrator::Ppm), ..options() };
    let with = |photons| Options { photons, ..ppm.clone() };
    let photons = ppm.photons;
    let cases = [
        (Options { samples: 0, ..options() }, "samples must be from 1"),
        (Options { replicates: 0, ..options() }, "replicates must be from 1 to 48"),
        (Options { replicates: 49, ..options() }, "replicates must be from 1 to 48"),
        (Options { path_length_max: 0, ..options() }, "path_length_max must be from 1"),
        (Options { width: Some(0), ..options() }, "width must be from 1"),
        (Options { height: Some(70_000), ..options() }, "height must be from 1"),
        (Options { color: Color::Mono { wavelength_nm: 0.0 }, ..options() }, "wavelength must"),
        (Options { rgb_white: Some(White::E), ..options() }, "rgb_white goes with"),
        (
            Options {
                color: Color::Mono { wavelength_nm: 900.0 },
                rgb_white: Some(White::D65),
                ..options()
            },
            "rgb_white d65 is known from 300 to 830 nanometers, not at 900",
        ),
        (Options { samples: 46, ..ppm.clone() }, "samples must be a multiple of the 4"),
        (Options { replicates: 13, ..ppm.clone() }, "replicates must be from 1 to 12"),
        (with(Photons { per_iteration: Some(0), ..photons }), "photons must be from 1"),
        (with(Photons { samples: Some(0), ..photons }), "samples_per_iteration must be from 1"),
        (with(Photons { alpha: 0.0, ..photons }), "alpha must be greater than 0"),
        (with(Photons { alpha: f32::NAN, ..photons }), "alpha must be greater than 0"),
        (with(Photons { radius: Some(0.0), ..photons }), "radius must be a length"),
    ];
    for (options, expected) in cases {
        let error = Settings::new(options).expect_err(expected).to_string();
        assert!(error.starts_with(expected), "{error} is not {expected}");
    }
    for count in [0, 100_000] {
        let error = Threads::start(Some(count)).err().expect("no such number").to_string();
        assert!(error.starts_with("threads must be from 1 to 4096, not"), "{error}");
    }
    let world = PlacedWorld::new(room().expect("sound")).expect("sound");
    let large = Options { width: Some(65_535), height: Some(65_535), ..options() };
    let error = Renderer::new(&world, &Settings::new(large).expect("each is"));
    let error = error.err().expect("too many pixels").to_string();
    assert!(error.contains("is too large"), "{error}");
}
