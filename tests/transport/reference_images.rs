//! Whole polarized renders against images that another renderer made with known errors, and
//! against a closed form (`tests/data/images`): frames, signs, units and depth limits included.
//!
//! The references are the mean of 16 runs each, with standard errors from their spread; ours are
//! the mean of 16 replicates too. Scores allow for errors that are estimated from so few
//! (`support::statistics`), not for skewness: where one sample in thousands carries most of a
//! pixel's light, most replicates miss it, and the pixel's mean and its estimated error are too
//! small together (2,048 samples of `mirror`: rms 1.4 over pixels with a mean score of -0.3).
//! So the quick tests score cells of 4 x 4 pixels, where that has averaged out (rms 0.98), and
//! the full ones cells of 2 x 2, but for `mirror`: there `bdpt` sees light by way of two mirrors
//! and glass that only chance finds, and 8,192 samples are still too few (rms 1.3 over cells of
//! 2 x 2, though its mean agrees with that of `path` to one part in ten thousand).

use std::ops::Range;

use sunstone::internals::image::StokesImage;
use sunstone::internals::image::npy::{read_npy, read_npy_with_stderr};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};

use crate::support::evidence;
use crate::support::rendering::{MONO, in_package, light_mask, replicates, scene, settings, world};
use crate::support::statistics::{
    ROUNDING, cells, estimate, estimate_stated, mean_s0, rms, rms_limits, worst,
};

/// Replicates of ours.
const REPLICATES: u32 = 16;
/// Degrees of freedom of the standard errors of the references.
const REFERENCE_DEGREES: f64 = 15.0;
/// Edge of the blocks whose sums find faint bias.
const BLOCK: usize = 8;
/// What no block exceeds: the largest of all 4,000 block scores of this file does in 1 of 400.
const BLOCK_LIMIT: f64 = 5.0;

/// A reference image and how to render the like of it.
struct Case {
    name: &'static str,
    /// Most segments of a path, as the reference was made.
    path_length_max: u32,
    /// Components that have pixels without noise, and in how many pixels they must be equal.
    exact: (Range<usize>, usize),
    /// Rectangles (left, top, right, bottom) that are left out.
    ill_posed: &'static [[usize; 4]],
    /// How far from black pixels compared ones are, in pixels.
    margin: usize,
}

const CORNELL: Case =
    Case { name: "cornell", path_length_max: 12, exact: (0..4, 500), ill_posed: &[], margin: 0 };
const MIRROR: Case =
    Case { name: "mirror", path_length_max: 12, exact: (0..4, 5_000), ill_posed: &[], margin: 0 };
/// The closed form has no error but that of 8 x 8 points a pixel, far below our noise. Stratified
/// choices between reflection and transmission sometimes give all replicates the same S0, so only
/// S3, which is zero, is exact.
const BREWSTER: Case =
    Case { name: "brewster", path_length_max: 4, exact: (3..4, 4_096), ill_posed: &[], margin: 0 };
/// Inside the cells of the scene there is no noise at all. Two corners of the turned polarizer
/// lie in the plane of its neighbors and overlap them: which of two coplanar sheets comes first,
/// or whether both count, has no answer.
const POLARIZERS: Case = Case {
    name: "polarizers",
    path_length_max: 8,
    exact: (0..4, 60_000),
    ill_posed: &[[78, 12, 84, 23], [92, 44, 103, 51]],
    margin: 0,
};

/// Circular polarization comes from total reflection alone, seldom and much at a time.
const TANK: Case =
    Case { name: "tank", path_length_max: 40, exact: (0..4, 100), ill_posed: &[], margin: 0 };
const RAYLEIGH: Case =
    Case { name: "rayleigh", path_length_max: 20, exact: (0..4, 5_000), ill_posed: &[], margin: 0 };

/// Polarized plastic and rough metal, which light each other. Their facets are narrow: the wider
/// ones of Mitsuba are darker at grazing, as masking and shadowing are independent there.
const PLASTIC: Case =
    Case { name: "plastic", path_length_max: 5, exact: (0..4, 4_000), ill_posed: &[], margin: 0 };

/// Without the edges of the cloud, for photons.
const INSIDE_RAYLEIGH: Case = Case { exact: (0..4, 1_000), margin: 4, ..RAYLEIGH };

/// Renders and compares with cells of `edge` pixels.
fn check(case: &Case, integrator: Integrator, iterations: u32, edge: usize) {
    check_photons(case, integrator, iterations, edge, Photons::default());
}

/// [`check`] with photons.
fn check_photons(
    case: &Case,
    integrator: Integrator,
    iterations: u32,
    edge: usize,
    photons: Photons,
) {
    let reference = reference(case.name);
    let file = match case.name {
        "plastic" => "tests/data/images/plastic/scene.xml".to_owned(),
        name => format!("scenes/reference/{name}.gltf"),
    };
    let world = world(&in_package(&file));
    let size = [reference.width as u32, reference.height as u32];
    let scene = scene::<1>(&world, MONO, size);
    let settings = settings(integrator, Mode::Polarized, MONO, iterations, case.path_length_max);
    let settings = Options { photons, ..settings.clone() };
    let images = replicates(&scene, &settings, REPLICATES);
    let mut mask = match integrator {
        Integrator::Light => light_mask(&scene),
        _ if case.margin > 0 => away_from_darkness(&reference, case.margin),
        _ => vec![true; reference.width * reference.height],
    };
    for &[left, top, right, bottom] in case.ill_posed {
        (top..bottom).for_each(|y| mask[y * reference.width..][left..right].fill(false));
    }
    let mut complaints = Vec::new();
    for component in 0..4 {
        complaints.extend(noise_complaint(&images, &reference, &mask, component, edge));
    }
    complaints.extend(exact_complaint(&images, &reference, &mask, case));
    if !complaints.is_empty() {
        let test = format!("reference_images/{}-{integrator:?}", case.name);
        let folder = evidence::keep(&test, &evidence::mean(&images), &reference);
        panic!("{}\nsee {}", complaints.join("\n"), folder.display());
    }
}

/// Pixels from which no black pixel is near: along the edges of a medium, the kernel of photons
/// reaches out of it, and the bias of that falls slower than everywhere else.
fn away_from_darkness(reference: &StokesImage, margin: usize) -> Vec<bool> {
    let lit = |x: usize, y: usize| reference.planes[0][y * reference.width + x] > 0.0;
    let around = |at: usize, size: usize| at.saturating_sub(margin)..(at + margin + 1).min(size);
    let (width, height) = (reference.width, reference.height);
    let clear = |x, y| around(y, height).all(|y| around(x, width).all(|x| lit(x, y)));
    (0..width * height).map(|pixel| clear(pixel % width, pixel / width)).collect()
}

fn reference(name: &str) -> StokesImage {
    let folder = in_package("tests/data/images").join(name);
    let image = match name {
        "brewster" => read_npy(&folder.join("analytic.npy")),
        _ => read_npy_with_stderr(&folder.join("stokes.npy"), &folder.join("stderr.npy")),
    };
    image.expect("the data are whole")
}

/// What the scores of one component say, cells first, blocks next; both are printed.
fn noise_complaint(
    images: &[StokesImage],
    reference: &StokesImage,
    mask: &[bool],
    component: usize,
    edge: usize,
) -> Option<String> {
    let scores = |edge: usize| -> Vec<f64> {
        let cells = cells(reference.width, reference.height, edge, mask);
        let score = |cell: &Vec<usize>| {
            let theirs = estimate_stated(reference, component, cell, REFERENCE_DEGREES);
            let scale = scale_of(reference, cell);
            estimate(images, component, cell).score(&theirs, scale)
        };
        cells.iter().filter_map(score).collect()
    };
    let (of_cells, of_blocks) = (scores(edge), scores(BLOCK));
    if of_cells.is_empty() {
        return None;
    }
    let (rms, worst) = (rms(&of_cells), worst(&of_blocks));
    let [low, high] = rms_limits(of_cells.len());
    let found = format!(
        "S{component}: rms score {rms:.3} over {} cells ({low:.3} to {high:.3}), worst block \
         {worst:.2} (up to {BLOCK_LIMIT})",
        of_cells.len()
    );
    println!("{found}");
    ((rms < low || rms > high) || worst > BLOCK_LIMIT).then_some(found)
}

/// The intensity that rounding goes by: that of a cell, or of the image where the cell is darker.
fn scale_of(reference: &StokesImage, cell: &[usize]) -> f64 {
    estimate_stated(reference, 0, cell, REFERENCE_DEGREES).mean.max(mean_s0(reference))
}

/// Pixels where neither image has noise must be equal, and there must be as many as expected.
fn exact_complaint(
    images: &[StokesImage],
    reference: &StokesImage,
    mask: &[bool],
    case: &Case,
) -> Option<String> {
    let (components, count_min) = case.exact.clone();
    let (mut count, mut wrong) = (0, Vec::new());
    for component in components {
        for pixel in (0..mask.len()).filter(|&pixel| mask[pixel]) {
            let ours = estimate(images, component, &[pixel]);
            let theirs = estimate_stated(reference, component, &[pixel], REFERENCE_DEGREES);
            let scale = scale_of(reference, &[pixel]);
            if ours.score(&theirs, scale).is_some() {
                continue;
            }
            count += 1;
            // The references were summed in single precision: at sums of 45,000 a light of 7 is
            // rounded by up to 3e-4 of it, each time alike (3e-5 seen in the mean).
            let tolerance = if scale > 1.0 { 1e-4 * scale } else { ROUNDING };
            if (ours.mean - theirs.mean).abs() > tolerance {
                wrong.push((pixel, component, ours.mean, theirs.mean));
            }
        }
    }
    println!("{count} values without noise");
    match wrong.first() {
        Some(first) => Some(format!("{} exact values differ, first {first:?}", wrong.len())),
        None if count < count_min => Some(format!("only {count} values without noise")),
        None => None,
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_cornell() {
    check(&CORNELL, Integrator::Path, 256, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_mirror() {
    check(&MIRROR, Integrator::Path, 512, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_brewster() {
    check(&BREWSTER, Integrator::Path, 256, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_plastic() {
    check(&PLASTIC, Integrator::Path, 128, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_renders_plastic() {
    check(&PLASTIC, Integrator::Bdpt, 64, 4);
}

#[test]
fn path_renders_polarizers() {
    check(&POLARIZERS, Integrator::Path, 32, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_renders_cornell() {
    check(&CORNELL, Integrator::Bdpt, 192, 4);
}

#[test]
#[ignore = "a minute; quickly it is compared with `path`, see `agreement`"]
fn bdpt_renders_mirror() {
    check(&MIRROR, Integrator::Bdpt, 384, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_renders_brewster() {
    check(&BREWSTER, Integrator::Bdpt, 256, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_renders_polarizers() {
    check(&POLARIZERS, Integrator::Bdpt, 32, 4);
}

/// Over all pixels that do not see the spheres.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn light_renders_cornell() {
    check(&CORNELL, Integrator::Light, 192, 4);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_tank() {
    check(&TANK, Integrator::Path, 128, 8);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_renders_rayleigh() {
    check(&RAYLEIGH, Integrator::Path, 128, 4);
}

#[test]
#[ignore = "a minute; quickly it is compared with `path`, see `agreement`"]
fn bdpt_renders_tank() {
    check(&TANK, Integrator::Bdpt, 96, 8);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_renders_rayleigh() {
    check(&RAYLEIGH, Integrator::Bdpt, 96, 4);
}

/// One path in thirty meets the cloud.
#[test]
#[ignore = "half a minute; quickly it is compared with `path`, see `agreement`"]
fn light_renders_rayleigh() {
    check(&RAYLEIGH, Integrator::Light, 1024, 8);
}

/// Photons whose kernel does not shrink, but is small enough for its bias to drown in the noise.
fn photons(per_iteration: u32, radius: f32) -> Photons {
    Photons {
        per_iteration: Some(per_iteration),
        samples: Some(4),
        alpha: 1.0,
        radius: Some(radius),
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn ppm_renders_cornell() {
    check_photons(&CORNELL, Integrator::Ppm, 32, 8, photons(50_000, 0.01));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn ppm_renders_rayleigh() {
    check_photons(&INSIDE_RAYLEIGH, Integrator::Ppm, 16, 4, photons(400_000, 0.012));
}

#[test]
#[ignore = "four minutes: 512 million photons, to be run before a release"]
fn ppm_renders_media_at_full_length() {
    for (case, edge, radius) in [(&TANK, 4, 0.006), (&INSIDE_RAYLEIGH, 2, 0.01)] {
        println!("{}", case.name);
        // What is circularly polarized in the tank takes sensor paths rather than photons.
        let photons = Photons { samples: Some(256), ..photons(1_000_000, radius) };
        check_photons(case, Integrator::Ppm, 8192, edge, photons);
    }
}

#[test]
#[ignore = "minutes: 16,384 samples a pixel, to be run before a release"]
fn path_renders_all_at_full_length() {
    for (case, iterations, edge) in [
        (&CORNELL, 1024, 2),
        (&MIRROR, 1024, 4),
        (&BREWSTER, 1024, 2),
        (&POLARIZERS, 128, 2),
        (&TANK, 1024, 4),
        (&RAYLEIGH, 1024, 2),
    ] {
        println!("{}", case.name);
        check(case, Integrator::Path, iterations, edge);
    }
}

#[test]
#[ignore = "minutes: 8,192 samples a pixel, to be run before a release"]
fn bdpt_renders_all_at_full_length() {
    for (case, iterations, edge) in [
        (&CORNELL, 512, 2),
        (&MIRROR, 512, 4),
        (&BREWSTER, 512, 2),
        (&POLARIZERS, 128, 2),
        (&TANK, 512, 4),
        (&RAYLEIGH, 512, 2),
    ] {
        println!("{}", case.name);
        check(case, Integrator::Bdpt, iterations, edge);
    }
}

#[test]
#[ignore = "a minute: 16,384 samples a pixel, to be run before a release"]
fn light_renders_cornell_at_full_length() {
    check(&CORNELL, Integrator::Light, 1024, 2);
}
