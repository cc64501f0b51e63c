//! Parts of an image, merged, and renders that were stopped and taken up, have the bits of one that
//! was rendered in one go.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use sunstone::glam::{DVec3, Vec3};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::{
    Analyzer, Error, Integrator, Mode, Options, Part, Photons, PlacedWorld, Renderer, Settings,
    StokesImage, World, merge,
};

const SAMPLES: u32 = 24;

/// A room with a lamp, a glass sphere and a metal plate, that everybody sees something of.
fn room_world(wall: f32) -> Result<World, Error> {
    let mut world = World::new("room");
    let wall = world.add_material("wall", Material::from(Bsdf::diffuse(wall)).two_sided())?;
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
    world.set_resolution([20, 17])?;
    Ok(world)
}

fn room(wall: f32) -> PlacedWorld {
    let world = room_world(wall).expect("a sound world");
    PlacedWorld::new(world).expect("a sound world")
}

fn options(integrator: Integrator) -> Options {
    let photons = Photons { per_iteration: Some(500), samples: Some(2), ..Photons::default() };
    let integrator = Some(integrator);
    Options { integrator, samples: SAMPLES, path_length_max: 6, photons, ..Options::default() }
}

/// Without variances, from blocks of one sequence, and from replicates.
fn variants(integrator: Integrator) -> [Options; 3] {
    let plain = options(integrator);
    [
        plain.clone(),
        Options { variance: true, ..plain.clone() },
        Options { replicates: 5, ..plain.clone() },
    ]
}

fn renderer(world: &PlacedWorld, options: Options) -> Renderer {
    let settings = Settings::new(options).expect("sound options");
    Renderer::new(world, &settings).expect("a sound world")
}

fn done(world: &PlacedWorld, options: Options) -> StokesImage {
    let mut renderer = renderer(world, options);
    renderer.run(|_| ControlFlow::Continue(()));
    renderer.finish()
}

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("parts");
    std::fs::create_dir_all(&folder).expect("a folder for what is tested");
    folder.join(name)
}

/// Renders all of so many parts into files.
fn parts_of(world: &PlacedWorld, options: Options, of: u32, name: &str) -> Vec<PathBuf> {
    let part = |number| {
        let part = Some(Part::new(number, of).expect("there is such a part"));
        let mut renderer = renderer(world, Options { part, ..options.clone() });
        renderer.run(|_| ControlFlow::Continue(()));
        let path = file(&format!("{name}-{number}.part"));
        renderer.save(&path).expect("a file");
        path
    };
    (1..=of).map(part).collect()
}

#[track_caller]
fn assert_same_bits(image: &StokesImage, reference: &StokesImage, what: &str) {
    let bits = |planes: &[Vec<f32>]| -> Vec<u32> {
        planes.iter().flatten().map(|value| value.to_bits()).collect()
    };
    assert!(reference.planes[0].iter().any(|&value| value > 0.0), "{what}: it is black");
    assert!(bits(&image.planes) == bits(&reference.planes), "{what}: values differ");
    let variances = [image, reference].map(|image| image.variance.as_deref().map(bits));
    assert!(variances[0] == variances[1], "{what}: variances differ");
    assert_eq!(image.metadata, reference.metadata, "{what}");
}

#[test]
fn merged_parts_have_the_bits_of_one_render() {
    let world = room(0.7);
    for &integrator in Integrator::ALL {
        for (variant, options) in variants(integrator).into_iter().enumerate() {
            let whole = done(&world, options.clone());
            assert_eq!(whole.variance.is_some(), variant > 0);
            for of in [1, 2, 5] {
                let name = format!("{}-{variant}-{of}", integrator.name());
                let mut parts = parts_of(&world, options.clone(), of, &name);
                // Their order is of no account.
                parts.reverse();
                assert_same_bits(&merge(&parts).expect("all parts"), &whole, &name);
            }
        }
    }
}

/// Such films measure one number, of which the others are made when all parts are there.
#[test]
fn parts_behind_analyzers_merge() {
    for analyzer in [Analyzer::Linear { axis_deg: 22.5 }, Analyzer::LeftCircular] {
        let mut world = room_world(0.7).expect("a sound world");
        world.set_analyzer(Some(analyzer)).expect("a camera");
        let world = PlacedWorld::new(world).expect("a sound world");
        let options = Options { variance: true, ..options(Integrator::Path) };
        let parts = parts_of(&world, options.clone(), 3, "analyzed");
        let whole = done(&world, options);
        assert_same_bits(&merge(&parts).expect("all parts"), &whole, &analyzer.to_string());
    }
}

/// Stopped after waves of all kinds, written, and taken up by another renderer.
#[test]
fn renders_go_on_from_files() {
    let world = room(0.7);
    for &integrator in Integrator::ALL {
        for (variant, options) in variants(integrator).into_iter().enumerate() {
            let whole = done(&world, options.clone());
            let path = file(&format!("{}-{variant}.checkpoint", integrator.name()));
            let mut halves = vec![renderer(&world, options.clone())];
            for advance in [1, 5, 7] {
                let mut at_hand = halves.pop().expect("one is at hand");
                at_hand.advance(advance);
                at_hand.save(&path).expect("a file");
                let mut next = renderer(&world, options.clone());
                next.resume(&path).expect("what was saved");
                assert_eq!(next.samples(), at_hand.samples());
                halves.push(next);
            }
            let mut last = halves.pop().expect("one is at hand");
            last.run(|_| ControlFlow::Continue(()));
            let what = format!("{} {variant}", integrator.name());
            assert_same_bits(&last.finish(), &whole, &what);
        }
    }
}

/// A part may be stopped too.
#[test]
fn a_part_goes_on_from_a_file() {
    let world = room(0.7);
    for (variant, options) in variants(Integrator::Ppm).into_iter().enumerate() {
        let whole = done(&world, options.clone());
        let mut parts = parts_of(&world, options.clone(), 2, &format!("stopped-{variant}"));
        let part = Some(Part::new(2, 2).expect("there is such a part"));
        let mut first = renderer(&world, Options { part, ..options.clone() });
        first.advance(4);
        let path = file(&format!("stopped-{variant}.checkpoint"));
        first.save(&path).expect("a file");
        let error = merge(&[parts[0].clone(), path.clone()]).expect_err("it is not done");
        assert!(error.to_string().contains("has 4 of the 1"), "{error}");
        let mut second = renderer(&world, Options { part, ..options.clone() });
        second.resume(&path).expect("what was saved");
        second.run(|_| ControlFlow::Continue(()));
        parts[1] = file(&format!("stopped-{variant}.part"));
        second.save(&parts[1]).expect("a file");
        assert_same_bits(&merge(&parts).expect("all parts"), &whole, "a stopped part");
    }
}

/// Sums do not know how the samples came.
#[test]
fn waves_change_no_bit() {
    let world = room(0.7);
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        let whole = done(&world, options(integrator));
        let mut stepped = renderer(&world, options(integrator));
        for advance in [1, 2, 3, 5, 13] {
            stepped.advance(advance);
        }
        assert!(stepped.is_done());
        assert_same_bits(&stepped.finish(), &whole, integrator.name());
    }
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let (world, other) = (room(0.7), room(0.6));
    let options = options(Integrator::Path);
    let parts = parts_of(&world, options.clone(), 3, "refused");
    let refusal = |parts: &[&PathBuf]| {
        let parts: Vec<PathBuf> = parts.iter().map(|&part| part.clone()).collect();
        merge(&parts).expect_err("no image").to_string()
    };
    let [one, two, three] = [&parts[0], &parts[1], &parts[2]];
    assert_eq!(refusal(&[three, one]), "part 2/3 is missing, and without that there is no image");
    assert!(refusal(&[two]).starts_with("parts 1/3, 3/3 are missing"));
    assert!(refusal(&[one, two, two, three]).contains("have the same samples (parts 2/3 and 2/3)"));
    assert_eq!(refusal(&[]), "there are no parts to merge");

    let of_other = parts_of(&other, options.clone(), 3, "other-scene");
    assert!(refusal(&[one, &of_other[1], three]).contains("the scene (digest) of one is"));
    let reseeded = parts_of(&world, Options { seed: 1, ..options.clone() }, 3, "other-seed");
    let error = refusal(&[one, two, &reseeded[2]]);
    for part in ["refused-1.part", "other-seed-3.part", "the seed of one is 0, of the other 1"] {
        assert!(error.contains(part), "{error} lacks {part}");
    }

    let scalar = Options { mode: Mode::Scalar, ..options.clone() };
    let part = Some(Part::new(1, 3).expect("there is such a part"));
    let error =
        renderer(&world, Options { part, ..scalar.clone() }).resume(one).expect_err("another mode");
    assert!(error.to_string().contains("its mode is polarized, and here it is scalar"), "{error}");
    let error = renderer(&world, options).resume(one).expect_err("a part").to_string();
    assert!(error.contains("its part is 1/3, and here it is 1/1"), "{error}");

    let mut damaged = std::fs::read(two).expect("it is there");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 16;
    std::fs::write(two, damaged).expect("it can be written");
    assert!(refusal(&[one, two, three]).contains("refused-2.part is not a usable part file"));
}

#[test]
fn there_are_as_many_parts_as_iterations_or_blocks() {
    let world = room(0.7);
    let refused = |options: Options, of| {
        let part = Some(Part::new(1, of).expect("there is such a part"));
        let settings = Settings::new(Options { part, ..options.clone() }).expect("sound options");
        Renderer::new(&world, &settings).err().map(|error| error.to_string())
    };
    let [plain, blocks, replicates] = variants(Integrator::Path);
    for (options, most, what) in [
        (plain.clone(), 24, "iterations"),
        (blocks, 24, "blocks that its variances come from"),
        (replicates, 5, "blocks that its variances come from"),
        (options(Integrator::Ppm), 12, "iterations"),
    ] {
        assert_eq!(refused(options.clone(), most), None);
        let error = refused(options, most + 1).expect("too many");
        assert!(error.contains(&format!("has {most} {what}")), "{error}");
    }
    let limited = Options {
        time_limit: Some(std::time::Duration::from_secs(1)),
        part: Some(Part::new(1, 2).expect("there is such a part")),
        ..plain.clone()
    };
    assert!(Settings::new(limited).is_err());
}
