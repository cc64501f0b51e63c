//! Colors of metals and of panes, against Fresnel's equations.

use sunstone::glam::{DVec3, Vec3};
use sunstone::spectra::{index, metal};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::{
    Band, Color, Error, Integrator, Mode, Options, PlacedWorld, Spectral, Spectrum, World,
};

use crate::fresnel::reflectances;
use crate::measured::{Measured, images, mean, spectral};

/// Metals of all colors.
const METALS: [&str; 8] = ["Ag", "Al", "Au", "Cr", "Cu", "Fe", "Ti", "W"];
const ANGLES_DEG: [f64; 3] = [0.0, 45.0, 80.0];
/// From XYZ to linear sRGB: IEC 61966-2-1.
const SRGB: [[f64; 3]; 3] = [
    [3.240_625_5, -1.537_208, -0.498_628_6],
    [-0.968_930_7, 1.875_756_1, 0.041_517_5],
    [0.055_710_1, -0.204_021_1, 1.056_995_9],
];
/// The largest score: of about 50 normal numbers, one exceeds it in 1 of 30,000 cases.
const LIMIT: f64 = 5.0;

/// A sheet about the origin, seen along its plane of incidence at an angle to its normal, under a
/// sky; before a wall that emits, if any does.
pub fn sheet(bsdf: Bsdf, deg: f64, sky: Spectrum, wall: Option<Spectrum>) -> PlacedWorld {
    let world = || -> Result<World, Error> {
        let mut world = World::new("sheet");
        let sheet = world.add_material("sheet", Material::from(bsdf).two_sided())?;
        let here = Transform::IDENTITY;
        // Its normal is z.
        let quad = |z: f32, half: f32| Geometry::quad(Vec3::Z * z, Vec3::X * half, Vec3::Y * half);
        world.add_mesh("sheet", quad(0.0, 10.0), sheet, here)?;
        let behind = match wall {
            Some(glow) => Material::emitter(glow),
            None => Bsdf::Absorber.into(),
        };
        let behind = world.add_material("wall", behind)?;
        world.add_mesh("wall", quad(-0.1, 100.0), behind, here)?;
        world.set_environment(sky)?;
        let (sine, cosine) = deg.to_radians().sin_cos();
        let eye = DVec3::new(0.0, -sine, cosine) * 5.0;
        let lens = Lens::Orthographic { half_width: 0.1, half_height: 0.1 };
        // Up is in the plane of incidence, and right is across it.
        let up = DVec3::new(0.0, cosine, sine);
        world.set_camera("eye", lens, Transform::looking(eye, DVec3::ZERO, up))?;
        Ok(world)
    };
    PlacedWorld::new(world().expect("a sound world")).expect("a sound world")
}

/// Rows of a table of data, by the numbers of their cells.
fn rows(table: &str) -> Vec<Vec<f64>> {
    let lines = table.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
        .collect()
}

/// A table that is linear between rows of an even step.
fn linear(first: f64, step: f64, values: &[f64], nm: f64) -> f64 {
    let place = (nm - first) / step;
    let low = (place as usize).min(values.len() - 2);
    values[low] + (place - low as f64) * (values[low + 1] - values[low])
}

/// S0 and S1 in linear sRGB of daylight that something reflects, (1, 1, 1) of what reflects all:
/// `of` says how much of the light across the plane of incidence, and in it.
pub fn seen(of: impl Fn(f64) -> [f64; 2]) -> [[f64; 3]; 2] {
    const STEPS: usize = 400;
    let observer = rows(include_str!("../../src/spectrum/data/cie1931.csv"));
    let illuminants = include_str!("../../src/spectrum/data/illuminants.csv");
    let d65 = illuminants.lines().find_map(|line| line.strip_prefix("D65,"));
    let d65 = &rows(d65.expect("D65 is there"))[0];
    let matching =
        [1, 2, 3].map(|column| observer.iter().map(|row| row[column]).collect::<Vec<_>>());
    let (mut sums, mut white) = ([[0.0; 3]; 2], 0.0);
    for step in 0..STEPS {
        let nm = 380.0 + 400.0 * (step as f64 + 0.5) / STEPS as f64;
        let daylight = linear(d65[0], d65[1], &d65[2..], nm);
        let xyz = [0, 1, 2].map(|of| daylight * linear(360.0, 1.0, &matching[of], nm));
        let [s, p] = of(nm);
        white += xyz[1];
        for (sum, xyz) in (0..3).zip(xyz) {
            sums[0][sum] += 0.5 * (s + p) * xyz;
            sums[1][sum] += 0.5 * (s - p) * xyz;
        }
    }
    sums.map(|xyz| SRGB.map(|row| (0..3).map(|of| row[of] * xyz[of]).sum::<f64>() / white))
}

pub fn options(mode: Mode, samples: u32) -> Options {
    Options {
        integrator: Some(Integrator::Path),
        mode,
        samples,
        path_length_max: 2,
        width: Some(2),
        height: Some(2),
        ..Options::default()
    }
}

/// Within one percent of what a mirror without color shows.
#[test]
fn metals_have_their_colors() {
    let daylight = Spectrum::illuminant("D65").expect("it is tabulated");
    let samples = if cfg!(debug_assertions) { 128 } else { 512 };
    let mut worst = [0.0_f64; 2];
    for name in METALS {
        let (eta, k) = metal(name).expect("it is tabulated");
        let at = |of: &Spectrum, nm: f64| f64::from(of.at(nm as f32).expect("it covers that"));
        for deg in ANGLES_DEG {
            let cosine = deg.to_radians().cos();
            let expected = seen(|nm| reflectances([at(&eta, nm), at(&k, nm)], cosine));
            let bsdf = Bsdf::Conductor { eta: eta.clone(), k: k.clone() };
            let world = sheet(bsdf, deg, daylight.clone(), None);
            let options = Options {
                color: Color::Rgb,
                spectral: Some(Spectral::default()),
                ..options(Mode::Polarized, samples)
            };
            let image = &images(&world, &options, 1)[0];
            for (component, expected) in expected.iter().enumerate() {
                for (channel, expected) in expected.iter().enumerate() {
                    let off = mean(image, component, channel) - expected;
                    worst[component] = worst[component].max(off.abs());
                    assert!(off.abs() < 0.01, "{name}, {deg}, S{component}: {off}, {expected}");
                }
            }
            assert!(deg == 0.0 || expected[1][1] > 1e-3, "{name} polarizes");
        }
    }
    println!("colors are off by {:.1e} at most, S1 by {:.1e}", worst[0], worst[1]);
}

/// All reflections within a pane, of light across the plane of incidence and in it.
fn of_pane(n: f64, deg: f64) -> [f64; 2] {
    reflectances([n, 0.0], deg.to_radians().cos()).map(|r| 2.0 * r / (1.0 + r))
}

/// Panes reflect and transmit every wavelength by its own index, though none goes another way.
#[test]
fn panes_reflect_every_band_by_its_index() {
    const DEG: f64 = 65.0;
    // More than any glass disperses: the bands differ by far more than their errors.
    let steep = Spectrum::table(&[400.0, 700.0], &[2.2, 1.3]).expect("a sound table");
    let (flint, _) = index("N-SF11").expect("it is tabulated");
    for (name, ior) in [("steep", steep), ("flint", flint)] {
        let pane = Bsdf::thin_dielectric(ior.clone());
        let lit = [(1.0, None), (0.0, Some(1.0.into()))];
        for (is_wall, (sky, wall)) in lit.into_iter().enumerate() {
            let world = sheet(pane.clone(), DEG, Spectrum::from(sky), wall);
            for (mode, wavelengths) in
                [(Mode::Polarized, 8), (Mode::Polarized, 4), (Mode::Scalar, 8)]
            {
                let centers = [420.0, 500.0, 600.0, 680.0];
                let bands = centers.map(|nm| Band::new(nm as f32, 0.5)).to_vec();
                let options = Options { width: Some(8), height: Some(8), ..options(mode, 64) };
                let all = images(&world, &spectral(wavelengths, bands, options), 8);
                for (channel, nm) in centers.into_iter().enumerate() {
                    let n = f64::from(ior.at(nm as f32).expect("it covers that"));
                    let reflected = of_pane(n, DEG);
                    let [s, p] = if is_wall == 1 { reflected.map(|r| 1.0 - r) } else { reflected };
                    let expected = [0.5 * (s + p), 0.5 * (s - p)];
                    for (component, expected) in
                        expected.into_iter().take(mode.components()).enumerate()
                    {
                        let values: Vec<f64> =
                            all.iter().map(|image| mean(image, component, channel)).collect();
                        let found = Measured::of(&values);
                        let score = found.score(expected, 1e-4);
                        let what =
                            format!("{name}, wall {is_wall}, {mode:?}, {nm} nm, S{component}");
                        println!(
                            "{what}: {:.4} (error {:.1e}), {expected:.4}",
                            found.mean, found.error
                        );
                        assert!(score.abs() < LIMIT, "{what}: {found:?}, should be {expected}");
                    }
                }
            }
        }
    }
}

/// Bands of a color film agree with what a film of RGB integrates.
#[test]
fn a_mirror_without_color_shows_white() {
    let daylight = Spectrum::illuminant("D65").expect("it is tabulated");
    let world = sheet(Bsdf::Conductor { eta: 1.0.into(), k: 1e4.into() }, 30.0, daylight, None);
    let color = Color::Rgb;
    let spectral = Some(Spectral { wavelengths: 4, ..Spectral::default() });
    let image = &images(&world, &Options { color, spectral, ..options(Mode::Scalar, 256) }, 1)[0];
    for channel in 0..3 {
        assert!((mean(image, 0, channel) - 1.0).abs() < 0.01, "{}", mean(image, 0, channel));
    }
}
