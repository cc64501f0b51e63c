//! A ball of water or glass in parallel light, by angle: the rainbow, whose intensity and
//! polarization are sums over rays (van de Hulst 1957, "Light Scattering by Small Particles",
//! section 12), and the bows of glass at every wavelength, whose angles follow from Snell's law.
//!
//! The camera is the sun: its rays are parallel, and by reciprocity what it sees of a lamp in some
//! directions is what the ball would send there of its light. There is a ring of lamps far away for
//! every bin of angles, each in a band of its own, so that a film of eight bands tells eight bins
//! apart, and a set of eight wavelengths has one for each.
//!
//! All azimuths are alike, so the camera sees a radius of the ball's disk alone. What leaves in a
//! bin comes through narrow zones of the disk: strips of that radius, which as many rays see as see
//! all the rest, where by the sums nothing comes from.
//!
//! A normal number exceeds the limit of 5 with a chance of 6e-7, and about 50 are looked at: noise
//! fails these tests in 1 of 30,000 changes of the random numbers.

use std::f64::consts::PI;

use sunstone::glam::{DVec3, Vec3};
use sunstone::spectra::{Line, LineShape};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::{Band, Error, Integrator, Mode, Options, PlacedWorld, Spectrum, StokesImage, World};

use crate::fresnel::{bk7, reflectances};
use crate::measured::{Measured, images, spectral};

/// Bins of a render.
const RINGS: usize = 8;
/// Their distance in radii of the ball: rays from it are parallel there to 6e-4 degrees.
const FAR: f64 = 1e5;
/// Corners of a ring, whose edges are in its angle to 5e-4 degrees.
const CORNERS: u32 = 512;
/// Width of bins in degrees.
const BIN_DEG: f64 = 0.1;
/// The film in pixels, along a radius of the disk and across it.
const FILM: [u32; 2] = [256, 4];
/// Strips of the radius in which sums over rays look for what is in some bins.
const STEPS: u32 = 1 << 16;
/// How much wider than found such a zone is at either side, in steps.
const MARGIN: u32 = 16;
/// Edge of the film that sees all of the ball, in pixels.
const EDGE: u32 = 64;
/// Chords of a ray in the ball, at most, and segments of its path.
const CHORDS: u32 = 5;
const LENGTH: u32 = 2 + CHORDS;
const LIMIT: f64 = 5.0;
/// The index of water that the reference has.
const WATER: f64 = 1.333;

/// A bin: its least angle in degrees, and the middle of its band in nanometers.
#[derive(Clone, Copy)]
struct Ring {
    from_deg: f64,
    nm: f64,
}

/// Those from an angle in degrees on, in bands over visible light.
fn rings_from(first_deg: f64) -> Vec<Ring> {
    let ring = |index: usize| Ring {
        from_deg: first_deg + BIN_DEG * index as f64,
        nm: 420.0 + 40.0 * index as f64,
    };
    (0..RINGS).map(ring).collect()
}

/// What a camera sees of the ball.
#[derive(Clone, Copy)]
enum Seen {
    Disk,
    /// Distances from the axis between two.
    Strip([f64; 2]),
}

/// A ball of radius 1 before the camera, and the lamps.
fn world(ball: Bsdf, rings: &[Ring], seen: Seen) -> PlacedWorld {
    let (middle, half_width, resolution) = match seen {
        Seen::Disk => (0.0, 1.0, [EDGE; 2]),
        Seen::Strip([from, to]) => (0.5 * (from + to), 0.5 * (to - from), FILM),
    };
    let half_height = half_width * f64::from(resolution[1]) / f64::from(resolution[0]);
    let world = || -> Result<World, Error> {
        let mut world = World::new("ball");
        let ball = world.add_material("ball", ball)?;
        world.add_sphere("ball", 1.0, ball, Transform::IDENTITY)?;
        for (index, ring) in rings.iter().enumerate() {
            // Wider than its band.
            let line = Line { center_nm: ring.nm, power: 4.0, width_nm: 4.0 };
            let light = Spectrum::lines(&[line], LineShape::Box)?;
            let name = format!("ring {index}");
            let glow = world.add_material(&name, Material::emitter(light).two_sided())?;
            world.add_mesh(&name, ring_of_lamps(ring.from_deg), glow, Transform::IDENTITY)?;
        }
        let middle = DVec3::X * middle;
        let place = Transform::looking(middle + DVec3::Z * 3.0, middle, DVec3::Y);
        let [half_width, half_height] = [half_width, half_height].map(|it| it as f32);
        let lens = Lens::Orthographic { half_width, half_height };
        world.set_camera("sun", lens, place)?;
        world.set_resolution(resolution)?;
        Ok(world)
    };
    PlacedWorld::new(world().expect("a sound world")).expect("a sound world")
}

/// All directions at an angle in degrees to those of the camera's rays, or up to a bin more.
fn ring_of_lamps(from_deg: f64) -> Geometry {
    let corner = |deg: f64, index: u32| -> Vec3 {
        let (sine, cosine) = deg.to_radians().sin_cos();
        let (y, x) = (2.0 * PI * f64::from(index) / f64::from(CORNERS)).sin_cos();
        (FAR * DVec3::new(sine * x, sine * y, -cosine)).as_vec3()
    };
    let corners = |index| [corner(from_deg, index), corner(from_deg + BIN_DEG, index)];
    let triangles = |index: u32| {
        let (here, next) = (2 * index, 2 * ((index + 1) % CORNERS));
        [[here, here + 1, next + 1], [here, next + 1, next]]
    };
    let positions = (0..CORNERS).flat_map(corners).collect();
    Geometry::new(positions, (0..CORNERS).flat_map(triangles).collect())
}

/// The share of the light on the ball that leaves in a bin by a zone of it, and the same of what is
/// polarized across the plane of scattering less that along it. Every column of the film sees a
/// ring.
fn measured(image: &StokesImage, channel: usize, [from, to]: [f64; 2]) -> [f64; 2] {
    let [height, width, ..] = image.shape();
    let mut sums = [0.0; 2];
    for column in 0..width {
        let distance = from + (to - from) * (column as f64 + 0.5) / width as f64;
        let mean = |component| {
            let plane = image.plane(component, channel);
            let rows = (0..height).map(|row| f64::from(plane[row * width + column]));
            rows.sum::<f64>() / height as f64
        };
        // The disk's area is pi.
        let area = 2.0 * distance * (to - from) / width as f64;
        sums[0] += area * mean(0);
        sums[1] -= area * mean(1);
    }
    sums
}

/// The angles in degrees at which a ray leaves that meets the ball at a distance from its axis, by
/// the number of its chords in it.
fn turns_deg(n: f64, distance: f64) -> impl Iterator<Item = (u32, f64)> {
    let (incidence, refraction) = (distance.asin(), (distance / n).asin());
    (0..=CHORDS).map(move |chords| {
        let turn =
            2.0 * (incidence - refraction) + (f64::from(chords) - 1.0) * (PI - 2.0 * refraction);
        (chords, turn.cos().acos().to_degrees())
    })
}

/// Zones of the disk that between them are all of it: those with what leaves in some degrees, and
/// those without.
fn zones(n: f64, deg: [f64; 2]) -> Vec<[f64; 2]> {
    let is_in = |step: u32| {
        let distance = (f64::from(step) + 0.5) / f64::from(STEPS);
        turns_deg(n, distance).any(|(_, turn)| (deg[0]..deg[1]).contains(&turn))
    };
    let found: Vec<u32> = (0..STEPS).filter(|step| is_in(*step)).collect();
    let mut zones: Vec<[u32; 2]> = Vec::new();
    for step in found {
        let [from, to] = [step.saturating_sub(MARGIN), (step + 1 + MARGIN).min(STEPS)];
        match zones.last_mut() {
            Some(last) if last[1] >= from => last[1] = to,
            _ => zones.push([from, to]),
        }
    }
    let mut ends: Vec<u32> = [0].into_iter().chain(zones.concat()).chain([STEPS]).collect();
    ends.dedup();
    ends.windows(2).map(|it| [it[0], it[1]].map(|end| f64::from(end) / f64::from(STEPS))).collect()
}

/// What rays find in some bins of a least angle in degrees: the same two numbers, summed over rays
/// that are evenly dense over the disk of the ball, with up to [`CHORDS`] chords in it.
fn summed(n: f64, from_deg: &[f64], rays: u32) -> Vec<[f64; 2]> {
    let mut bins = vec![[0.0; 2]; from_deg.len()];
    for ray in 0..rays {
        let distance = ((f64::from(ray) + 0.5) / f64::from(rays)).sqrt();
        let reflected = reflectances([n, 0.0], distance.asin().cos());
        for (chords, deg) in turns_deg(n, distance) {
            let [s, p] = reflected.map(|r| match chords {
                0 => r,
                _ => (1.0 - r).powi(2) * r.powi(chords as i32 - 1),
            });
            for (bin, from) in bins.iter_mut().zip(from_deg) {
                if (*from..from + BIN_DEG).contains(&deg) {
                    bin[0] += 0.5 * (s + p) / f64::from(rays);
                    bin[1] += 0.5 * (s - p) / f64::from(rays);
                }
            }
        }
    }
    bins
}

/// What is found in the bins, and what rays find.
struct Found {
    deg: f64,
    light: [Measured; 2],
    expected: [f64; 2],
}

/// Bins of the water's light from an angle in degrees on. Every zone of the disk is seen by as many
/// samples in each pixel of a replicate.
fn window(first_deg: f64, samples: u32, replicates: u32, rays: u32) -> Vec<Found> {
    let rings = rings_from(first_deg);
    let bands = rings.iter().map(|ring| Band::new(ring.nm as f32, 2.0)).collect();
    let options = Options {
        integrator: Some(Integrator::Path),
        mode: Mode::Polarized,
        samples,
        path_length_max: LENGTH,
        roulette_after: Some(LENGTH + 1),
        ..Options::default()
    };
    let options = spectral(8, bands, options);
    let n = f64::from(WATER as f32);
    let mut light = vec![[[0.0; 2]; RINGS]; replicates as usize];
    for zone in zones(n, [first_deg, first_deg + BIN_DEG * RINGS as f64]) {
        let world = world(Bsdf::dielectric(WATER as f32), &rings, Seen::Strip(zone));
        for (image, bins) in images(&world, &options, replicates).iter().zip(&mut light) {
            for (ring, bin) in bins.iter_mut().enumerate() {
                let more = measured(image, ring, zone);
                *bin = [bin[0] + more[0], bin[1] + more[1]];
            }
        }
    }
    let from_deg: Vec<f64> = rings.iter().map(|ring| ring.from_deg).collect();
    let expected = summed(n, &from_deg, rays);
    let found = |(ring, expected): (usize, [f64; 2])| {
        let values = |of: usize| light.iter().map(|bins| bins[ring][of]).collect::<Vec<_>>();
        let light = [0, 1].map(|of| Measured::of(&values(of)));
        let deg = from_deg[ring];
        let [s0, s1] = light;
        println!(
            "{deg:.1} degrees: {:.3e} of the light, {:+.2} % off (error {:.2} %); polarized \
             {:.4}, should be {:.4}",
            s0.mean,
            100.0 * (s0.mean / expected[0] - 1.0),
            100.0 * s0.error / s0.mean,
            s1.mean / s0.mean,
            expected[1] / expected[0]
        );
        Found { deg, light, expected }
    };
    expected.into_iter().enumerate().map(found).collect()
}

/// The angle in degrees at which rays that are reflected once in the ball turn back, from the
/// reference.
fn bow_deg() -> f64 {
    let table = include_str!("../data/rainbow/bow.csv");
    let primary = table.lines().find(|line| line.starts_with("1.333,1,"));
    let cell = primary.and_then(|line| line.split(',').nth(3));
    cell.and_then(|cell| cell.parse().ok()).expect("the primary bow")
}

/// The angle of least deviation of rays that are reflected once, by the index.
fn bow_of(n: f64) -> f64 {
    let incidence = ((n * n - 1.0) / 3.0).sqrt().acos();
    let refraction = (incidence.sin() / n).asin();
    (PI + 2.0 * incidence - 4.0 * refraction).to_degrees()
}

/// Every bin by the errors that the images have, and the bow where it belongs.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn the_primary_rainbow_is_where_and_what_rays_say() {
    assert!((bow_of(WATER) - bow_deg()).abs() < 1e-9);
    let found = window(137.6, 64, 16, 1_000_000);
    for Found { deg, light, expected } in &found {
        for (light, expected) in light.iter().zip(expected) {
            let score = light.score(*expected, 2e-3 * expected);
            assert!(score.abs() < LIMIT, "{deg}: {light:?}, should be {expected}");
        }
    }
    // The bins are half empty where the bow is, and dark before it.
    let before = found.iter().filter(|it| it.deg + BIN_DEG < bow_deg() - 0.1);
    let dark = before.map(|it| it.light[0].mean).fold(0.0, f64::max);
    let behind = found.iter().filter(|it| it.deg > bow_deg() - 0.1);
    let bright = behind.map(|it| it.light[0].mean).fold(f64::INFINITY, f64::min);
    assert!(dark < 0.1 * bright, "{dark}, {bright}");
}

/// One percent in bins of a tenth of a degree, of intensity and of the degree of polarization:
/// before the bow, where there is a hundredth of the light, behind it, and far from it.
#[test]
#[ignore = "minutes"]
fn rainbows_are_within_a_percent_of_sums_over_rays() {
    for first_deg in [130.0, 136.8, 138.0, 138.8, 150.0] {
        let found = window(first_deg, 512, 16, 20_000_000);
        let sum = |of: fn(&Found) -> f64| found.iter().map(of).sum::<f64>();
        let mean = sum(|it| it.light[0].mean);
        let all = Measured { mean, error: sum(|it| it.light[0].error.powi(2)).sqrt() };
        let expected = sum(|it| it.expected[0]);
        let (off, score) = (all.mean / expected - 1.0, all.score(expected, 0.0));
        println!("from {first_deg} degrees: all {:+.3} % off, a score of {score:.2}", 100.0 * off);
        assert!(score.abs() < LIMIT, "{first_deg}: {all:?}, should be {expected}");
        for Found { deg, light: [s0, s1], expected } in &found {
            assert!(s0.error < 2.5e-3 * s0.mean, "{deg}: too few samples for a percent");
            let off = s0.mean / expected[0] - 1.0;
            let polarized = s1.mean / s0.mean - expected[1] / expected[0];
            assert!(off.abs() < 0.01, "{deg}: {off}");
            assert!(polarized.abs() < 0.01, "{deg}: {polarized}");
            for (light, expected) in [s0, s1].into_iter().zip(expected) {
                let score = light.score(*expected, 5e-4 * expected);
                assert!(score.abs() < LIMIT, "{deg}: {light:?}, should be {expected}");
            }
        }
    }
}

/// A ring that has the bow of its wavelength in its middle gets light from one side of it. If the
/// bow were half a bin further, there would be all the light, or none.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bows_of_glass_are_where_snells_law_has_them_at_every_wavelength() {
    let ring = |index: usize| {
        let nm = 420.0 + 40.0 * index as f64;
        Ring { from_deg: bow_of(bk7(nm)) - 0.5 * BIN_DEG, nm }
    };
    let rings: Vec<Ring> = (0..RINGS).map(ring).collect();
    assert!(rings[RINGS - 1].from_deg - rings[0].from_deg < -1.0, "the bows are apart");
    let (ior, _) = sunstone::spectra::index("BK7").expect("it is tabulated");
    let ball = Bsdf::DispersiveDielectric { ior, exterior_ior: 1.0.into() };
    let world = world(ball, &rings, Seen::Disk);
    let bands = rings.iter().map(|ring| Band::new(ring.nm as f32, 0.2)).collect();
    let options = Options {
        integrator: Some(Integrator::Path),
        mode: Mode::Intensity,
        samples: 64,
        path_length_max: LENGTH,
        roulette_after: Some(LENGTH + 1),
        ..Options::default()
    };
    let images = images(&world, &spectral(8, bands, options), 16);
    for (channel, ring) in rings.iter().enumerate() {
        let light = |image: &StokesImage| {
            image.plane(0, channel).iter().map(|value| f64::from(*value)).sum::<f64>()
        };
        let share = 4.0 / (PI * f64::from(EDGE * EDGE));
        let all: Vec<f64> = images.iter().map(|image| share * light(image)).collect();
        let found = Measured::of(&all);
        // As if the bow were moved by half a bin, to either side, or not at all.
        let from = [0.5, 0.0, -0.5].map(|bins| ring.from_deg + bins * BIN_DEG);
        let expected = summed(bk7(ring.nm), &from, 1_000_000);
        let [most, same, least] = [0, 1, 2].map(|index| expected[index][0]);
        println!(
            "{} nm, bow at {:.3} degrees: {:.3e} (error {:.1e}), should be {same:.3e}, between \
             {least:.3e} and {most:.3e}",
            ring.nm,
            ring.from_deg + 0.5 * BIN_DEG,
            found.mean,
            found.error
        );
        assert!(found.mean - LIMIT * found.error > least, "{}: too little", ring.nm);
        assert!(found.mean + LIMIT * found.error < most, "{}: too much", ring.nm);
        assert!(most > 1.2 * same && same > 1.5 * least, "the test could not fail");
    }
}
