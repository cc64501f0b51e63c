//! Wavelengths fall into bands now more and now less often: the image does not show it.

use std::ops::ControlFlow;
use std::sync::Arc;

use sunstone::glam::{DVec3, Vec3};
use sunstone::world::{Geometry, Lens, Material, Transform};
use sunstone::{
    Bands, Color, Error, Integrator, Options, PlacedWorld, Renderer, Settings, Spectral, Spectrum,
    StokesImage, World,
};

/// What a camera sees of a lamp before it, which is all that it sees.
fn lamp(glow: Spectrum, options: Options) -> (StokesImage, Vec<usize>) {
    let world = || -> Result<World, Error> {
        let mut world = World::new("lamp");
        let glow = world.add_material("glow", Material::emitter(glow).two_sided())?;
        let wall = Geometry::quad(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0);
        world.add_mesh("wall", wall, glow, Transform::IDENTITY)?;
        let place = Transform::looking(DVec3::Z, DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.5), place)?;
        world.set_resolution([4, 4])?;
        Ok(world)
    };
    let world = PlacedWorld::new(world().expect("a sound world")).expect("a sound world");
    let settings = Settings::new(options).expect("sound options");
    let mut renderer = Renderer::new(&world, &settings).expect("a sound world");
    renderer.run(|_| ControlFlow::Continue(()));
    let [unmeasured, if_dispersed] = renderer.unmeasured();
    assert!(if_dispersed.is_empty(), "nothing disperses light here");
    (renderer.finish(), unmeasured)
}

fn options(samples: u32, seed: u32, replicates: u32) -> Options {
    let bands = Bands::evenly(400.0, 700.0, 31).expect("sound bands");
    Options {
        integrator: Some(Integrator::Path),
        color: Color::Bands(Arc::new(bands)),
        spectral: Some(Spectral { wavelengths: 8, range_nm: [395.0, 705.0] }),
        samples,
        seed,
        replicates,
        ..Options::default()
    }
}

/// Where all light is of one spectrum, nothing is left of how wavelengths were chosen.
#[test]
fn a_lamp_is_the_same_in_all_bands() {
    for (samples, replicates) in [(16, 1), (40, 1), (32, 4)] {
        for seed in 0..4 {
            let (image, unmeasured) = lamp(5.0.into(), options(samples, seed, replicates));
            assert!(unmeasured.is_empty(), "{unmeasured:?}");
            for band in 0..31 {
                let value = image.plane(0, band)[5];
                assert!((value - 5.0).abs() < 2e-5, "{samples} samples, band {band}: {value}");
            }
        }
    }
}

/// Of a spectrum that is a line, each band has what that is at its center: it changes by a tenth
/// over the first band, in which there are ten wavelengths or more.
#[test]
fn bands_of_a_slope_are_its_means() {
    let slope = Spectrum::table(&[390.0, 710.0], &[10.0, 42.0]).expect("a sound table");
    let (image, _) = lamp(slope, options(64, 3, 1));
    for band in 0..31 {
        let expected = (11 + band) as f32;
        let value = image.plane(0, band)[5];
        assert!((value / expected - 1.0).abs() < 5e-3, "band {band}: {value}, not {expected}");
    }
}

/// One iteration of eight wavelengths leaves 23 of 31 bands black, and says so.
#[test]
fn bands_without_wavelengths_are_told() {
    let (image, unmeasured) = lamp(5.0.into(), options(1, 0, 1));
    assert_eq!(unmeasured.len(), 23);
    for band in 0..31 {
        let value = image.plane(0, band)[5];
        let expected = if unmeasured.contains(&band) { 0.0 } else { 5.0 };
        assert!((value - expected).abs() < 2e-5, "band {band}: {value}");
    }
}
