//! `path`, `light` and `bdpt` find the same light in different ways, so they must agree, in both
//! modes, in every scene: shipped ones and those of `support::scenes`, of which the quick tests
//! compare every third one in scalar mode, too. So must every band of spectral renders, of these
//! scenes and of glass that disperses (`support::dispersive`).
//!
//! Each render is repeated 32 times, or 16; means over cells of pixels and over the image are
//! compared. `light` is compared where its connections to the sensor can reach. `path` is left out
//! where specular surfaces pass on the light of emitters that it meets seldom or never: it is blind
//! there, and does not know it. So is `bdpt`, for such light that is seen by way of specular
//! surfaces, and there `ppm` is not compared with it. The kernel of `ppm` is so small that its bias
//! drowns in the noise; in the shipped scenes with media too few photons would meet it (the
//! full-length reference images test those).
//!
//! About 3,500 independent numbers are compared. A normal number exceeds the limit of 5.5 with a
//! chance of 4e-8, so that noise fails the suite in 1 of 6,000 cases; seeds are fixed, so that
//! each change of the random numbers is one such case. The root mean square over cells finds what
//! is too faint for that.
//!
//! The noise of what hardly any photon or path meets is not normal: means of few such numbers, and
//! their errors, are mostly too small. A pair that exceeds a limit is therefore rendered again, by
//! other numbers and of eight times the iterations, and fails if it does so again: such noise is
//! less there, and a bias stands out by three times as many errors.

use std::fs;
use std::path::PathBuf;

use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons, PlacedWorld};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;

use crate::support::blends::BLENDS;
use crate::support::brushed::BRUSHED;
use crate::support::dispersive::DISPERSIVE;
use crate::support::evidence;
use crate::support::filmed::FILMED;
use crate::support::filters::FILTERS;
use crate::support::layers::LAYERED;
use crate::support::odd_lights::ODD_LIGHTS;
use crate::support::painted::PAINTED;
use crate::support::rendering::{
    MONO, in_bands, in_package, light_mask, path_finds_everything, replicates, scene, settings,
    spectral_replicates, world,
};
use crate::support::scenes::{CONTRADICTORY, Named, SCENES, two_sheets};
use crate::support::skies::SKIES;
use crate::support::statistics::{ROUNDING, cells, estimate, mean_s0, rms, rms_limits, worst};

const SIZE: [u32; 2] = [16, 16];
/// Images of each; of scenes that others compare with references, too, half as many.
const REPLICATES: u32 = 32;
/// Of each, as a rule.
const ITERATIONS: u32 = 64;
const PATH_LENGTH_MAX: u32 = 6;
/// Bands of spectral renders, by their middles and widths in nanometers.
const BANDS: [[f32; 2]; 4] = [[410.0, 20.0], [480.0, 60.0], [560.0, 2.0], [650.0, 40.0]];
/// Edge of a cell in pixels.
const CELL: usize = 4;
/// What no score exceeds.
const LIMIT: f64 = 5.5;
/// How many times the iterations what exceeds a limit is rendered again with.
const AGAIN: u32 = 8;

/// The images that one integrator makes of a scene, and where they hold.
struct Rendered {
    integrator: Integrator,
    images: Vec<StokesImage>,
    mask: Vec<bool>,
}

/// The images of some options.
type ImagesOf<'a> = &'a dyn Fn(&Options) -> Vec<StokesImage>;

/// How integrators are rendered: the mode and the color, iterations of an image, what makes images
/// of options, and what is added to seeds.
#[derive(Clone)]
struct Effort<'a> {
    looked_at: (Mode, Color),
    iterations: u32,
    images_of: ImagesOf<'a>,
    seed: u32,
}

impl Effort<'_> {
    /// More of it, by other numbers.
    fn again(&self) -> Self {
        Self { iterations: AGAIN * self.iterations, seed: 0x0200_0000, ..self.clone() }
    }

    fn render<const N: usize>(
        &self,
        scene: &Scene<N>,
        integrator: Integrator,
        mask: Vec<bool>,
    ) -> Rendered {
        let (mode, color) = self.looked_at.clone();
        let settings = settings(integrator, mode, color, self.iterations, PATH_LENGTH_MAX);
        // Roulette must not change any mean, so one side plays it.
        let roulette_after = if integrator == Integrator::Path { 3 } else { u32::MAX };
        // With other seeds than in scalar mode, where the same paths would prove nothing new.
        let of_mode = if mode == Mode::Polarized { 0x0100_0000 } else { 0 };
        let seed = settings.seed + of_mode + self.seed;
        // A kernel so small that its bias drowns in the noise. Where iterations are many it is
        // twice as wide: the noise of what hardly any photon meets is no normal one, and its score
        // says more of that than of the mean.
        let share = if scene.has_media() { 0.011 } else { 0.006 };
        let share = if self.iterations > ITERATIONS / 4 { 2.0 * share } else { share };
        let radius = Some(share * scene.shapes.bounds.radius);
        let photons = Photons { per_iteration: Some(10_000), samples: Some(4), alpha: 1.0, radius };
        let settings =
            Options { roulette_after: Some(roulette_after), seed, photons, ..settings.clone() };
        Rendered { integrator, images: (self.images_of)(&settings), mask }
    }
}

/// All integrators that apply, and where their images hold.
fn that_apply<const N: usize>(
    scene: &Scene<N>,
    photons_reach_media: bool,
) -> Vec<(Integrator, Vec<bool>)> {
    let everywhere = vec![true; (SIZE[0] * SIZE[1]) as usize];
    let mut all = vec![(Integrator::Bdpt, everywhere.clone())];
    if path_finds_everything(scene) {
        all.push((Integrator::Path, everywhere.clone()));
    }
    if !scene.has_media() || photons_reach_media {
        all.push((Integrator::Ppm, everywhere));
    }
    let mask = light_mask(scene);
    if mask.iter().any(|&seen| seen) {
        all.push((Integrator::Light, mask));
    }
    all
}

/// Compares all pairs of integrators in one mode; what is wrong in words.
fn disagreements<const N: usize>(
    name: &str,
    world: &World,
    (mode, color): (Mode, Color),
    effort: [u32; 2],
) -> Vec<String> {
    let scene = scene::<N>(world, color.clone(), SIZE);
    let [count, iterations] = effort;
    let images_of = |options: &Options| replicates(&scene, options, count);
    let looked_at = (mode, color);
    all_pairs(name, &scene, &Effort { looked_at, iterations, images_of: &images_of, seed: 0 })
}

/// The same in bands of a spectral render of so many wavelengths at a time.
fn disagreements_in_bands(
    name: &str,
    world: World,
    (mode, wavelengths): (Mode, u32),
    [count, iterations]: [u32; 2],
) -> Vec<String> {
    // What integrators find hangs on no wavelength.
    let scene = scene::<1>(&world, MONO, SIZE);
    let placed = PlacedWorld::new(world).unwrap_or_else(|error| panic!("{name}: {error}"));
    let images_of = |options: &Options| {
        let options = in_bands(wavelengths, &BANDS, SIZE, options.clone());
        spectral_replicates(&placed, &options, count)
    };
    let name = format!("{name}, {wavelengths} wavelengths");
    let looked_at = (mode, MONO);
    all_pairs(&name, &scene, &Effort { looked_at, iterations, images_of: &images_of, seed: 0 })
}

/// Compares all pairs of integrators by their images of a scene.
fn all_pairs<const N: usize>(name: &str, scene: &Scene<N>, effort: &Effort) -> Vec<String> {
    let is_small = !name.starts_with("scenes");
    let render = |(integrator, mask)| effort.render(scene, integrator, mask);
    let all: Vec<_> = that_apply(scene, is_small).into_iter().map(render).collect();
    let bdpt_finds_everything = path_finds_everything(scene);
    let mode = effort.looked_at.0;
    let mut complaints = Vec::new();
    for (index, second) in all.iter().enumerate() {
        for first in &all[..index] {
            let of_both = [first.integrator, second.integrator];
            if of_both == [Integrator::Bdpt, Integrator::Ppm] && !bdpt_finds_everything {
                continue;
            }
            let pair = format!("{name}, {mode:?}: {:?} and {:?}", of_both[0], of_both[1]);
            if said(&pair, &compare(first, second)) {
                let again =
                    |of: &Rendered| effort.again().render(scene, of.integrator, of.mask.clone());
                complaints.extend(complaint(&pair, &[first, second].map(again)));
            }
        }
    }
    complaints
}

/// Prints what has been found; whether it is wrong.
fn said(pair: &str, found: &Found) -> bool {
    println!("{pair}: {}", found.words);
    found.wrong
}

/// What is wrong with images of a pair, if it is.
fn complaint(pair: &str, [first, second]: &[Rendered; 2]) -> Option<String> {
    let found = compare(first, second);
    said(&format!("{pair}, again"), &found).then(|| {
        let [image, reference] = [second, first].map(|side| evidence::mean(&side.images));
        let folder = evidence::keep(&format!("agreement/{pair}"), &image, &reference);
        format!("{pair}: {}\nsee {}", found.words, folder.display())
    })
}

struct Found {
    words: String,
    wrong: bool,
}

/// Scores of all planes, cells and the whole masked image.
fn compare(first: &Rendered, second: &Rendered) -> Found {
    let mask: Vec<bool> = first.mask.iter().zip(&second.mask).map(|(a, b)| *a && *b).collect();
    let image = &first.images[0];
    let scale = mean_s0(&evidence::mean(&first.images)).max(f64::MIN_POSITIVE);
    let (mut of_cells, mut of_images, mut inexact) = (Vec::new(), Vec::new(), 0);
    for plane in 0..image.planes.len() {
        for (edge, scores) in [(CELL, &mut of_cells), (image.width, &mut of_images)] {
            for cell in cells(image.width, image.height, edge, &mask) {
                let [a, b] = [first, second].map(|side| estimate(&side.images, plane, &cell));
                match a.score(&b, scale) {
                    Some(score) => scores.push(score),
                    None => inexact += usize::from((a.mean - b.mean).abs() > ROUNDING * scale),
                }
            }
        }
    }
    if of_cells.is_empty() {
        return Found { words: format!("no noise, {inexact} differ"), wrong: inexact > 0 };
    }
    let (rms, worst_cell, worst_image) = (rms(&of_cells), worst(&of_cells), worst(&of_images));
    // Channels share their noise, and components behind a polarizer do: of the planes only one
    // counts as a source of chance.
    let [_, high] = rms_limits(of_cells.len().div_ceil(image.planes.len()));
    let words = format!(
        "rms {rms:.2} of {} cells (up to {high:.2}), worst {worst_cell:.2}, images \
         {worst_image:.2} (up to {LIMIT}), {inexact} inexact",
        of_cells.len(),
    );
    let wrong = rms > high || worst_cell > LIMIT || worst_image > LIMIT || inexact > 0;
    Found { words, wrong }
}

/// In both modes: one wavelength for intensities, three for Stokes vectors. The effort is how many
/// images, of how many iterations each; where these are few, two of three scenes are left to
/// polarized mode.
fn check(scenes: impl IntoIterator<Item = (String, World)>, effort: [u32; 2]) {
    let mut complaints = Vec::new();
    for ((name, world), index) in scenes.into_iter().zip(0..) {
        if effort[1] >= ITERATIONS || index % 3 == 0 {
            complaints.extend(disagreements::<1>(&name, &world, (Mode::Scalar, MONO), effort));
        }
        complaints.extend(disagreements::<3>(&name, &world, (Mode::Polarized, Color::Rgb), effort));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// Modes and numbers of wavelengths of spectral renders.
const WAYS: [(Mode, u32); 4] =
    [(Mode::Polarized, 8), (Mode::Scalar, 4), (Mode::Polarized, 4), (Mode::Scalar, 8)];

/// Every scene in bands, in so many of the ways: of one, those of both modes by turns.
fn check_bands(scenes: impl IntoIterator<Item = (String, Build)>, effort: [u32; 2], ways: usize) {
    let mut complaints = Vec::new();
    for (index, (name, build)) in scenes.into_iter().enumerate() {
        let first = if ways == 1 { index % 2 } else { 0 };
        for way in &WAYS[first..first + ways] {
            complaints.extend(disagreements_in_bands(&name, build(), *way, effort));
        }
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// Makes a scene.
type Build = Box<dyn Fn() -> World>;

fn built(scenes: &[Named]) -> impl Iterator<Item = (String, Build)> {
    scenes.iter().map(|&(name, build)| (name.to_owned(), Box::new(build) as Build))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_where_glass_disperses() {
    check_bands(built(&DISPERSIVE), [16, ITERATIONS / 8], 1);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_in_some_scenes() {
    let some = built(&SCENES).chain(built(&FILTERS)).step_by(7).chain(built(&PAINTED[..2]));
    check_bands(some, [16, ITERATIONS / 8], 1);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_per_band_where_glass_disperses_closely() {
    check_bands(built(&DISPERSIVE), [REPLICATES, ITERATIONS / 2], WAYS.len());
}

#[test]
#[ignore = "many minutes"]
fn integrators_agree_per_band_in_all_scenes() {
    let load = |path: PathBuf| {
        let name = path.strip_prefix(in_package("")).unwrap_or(&path).display().to_string();
        (name, Box::new(move || world(&path)) as Build)
    };
    let shipped = ["scenes", "scenes/reference"].into_iter().flat_map(paths).map(load);
    let small = built(&SCENES).chain(built(&FILTERS)).chain(built(&PAINTED)).chain(built(&SKIES));
    check_bands(shipped.chain(small), [REPLICATES, ITERATIONS / 2], 2);
}

fn shipped(folder: &str) -> Vec<(String, World)> {
    let named = |path: &PathBuf| {
        let name = path.strip_prefix(in_package("")).unwrap_or(path).display().to_string();
        (name, world(path))
    };
    paths(folder).iter().map(named).collect()
}

/// The scenes in a folder of the package.
fn paths(folder: &str) -> Vec<PathBuf> {
    let folder = in_package(folder);
    let files = fs::read_dir(&folder).expect("the scenes are there");
    let mut paths: Vec<_> = files.map(|file| file.expect("a readable entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|it| it == "gltf" || it == "glb"));
    paths.sort();
    assert!(!paths.is_empty(), "no scenes in {}", folder.display());
    paths
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_shipped_scenes() {
    check(shipped("scenes"), [REPLICATES / 2, ITERATIONS]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_reference_scenes() {
    check(shipped("scenes/reference"), [REPLICATES / 2, ITERATIONS]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_small_scenes() {
    check(small_scenes(), [REPLICATES, ITERATIONS / 4]);
}

/// Some 6,500 independent numbers: noise exceeds the limit in 1 of 4,000 cases.
#[test]
#[ignore = "minutes"]
fn integrators_agree_on_odd_lights() {
    check(built(&ODD_LIGHTS).map(|(name, build)| (name, build())), [REPLICATES, ITERATIONS]);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_small_scenes_closely() {
    check(small_scenes(), [REPLICATES, 2 * ITERATIONS]);
}

fn small_scenes() -> impl Iterator<Item = (String, World)> {
    SCENES.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_where_boundaries_contradict() {
    // Media that are sought where boundaries are crossed take their time.
    let scenes = CONTRADICTORY.into_iter().map(|(name, build)| (name.to_owned(), build()));
    check(scenes, [REPLICATES, ITERATIONS / 16]);
}

fn painted() -> impl Iterator<Item = (String, World)> {
    PAINTED.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_painted_surfaces() {
    check(painted(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_painted_surfaces_closely() {
    check(painted(), [REPLICATES, 2 * ITERATIONS]);
}

fn blends() -> impl Iterator<Item = (String, World)> {
    BLENDS.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_blends() {
    check(blends(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_on_blends() {
    check_bands(built(&BLENDS[..1]), [16, ITERATIONS / 8], 1);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_blends_closely() {
    check(blends(), [REPLICATES, 2 * ITERATIONS]);
}

fn brushed() -> impl Iterator<Item = (String, World)> {
    BRUSHED.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_brushed_surfaces() {
    check(brushed(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_brushed_surfaces_closely() {
    check(brushed(), [REPLICATES, 2 * ITERATIONS]);
}

fn filmed() -> impl Iterator<Item = (String, World)> {
    FILMED.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_films() {
    check(filmed(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_on_films() {
    check_bands(built(&FILMED[..1]), [16, ITERATIONS / 8], 1);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_films_closely() {
    check(filmed(), [REPLICATES, 2 * ITERATIONS]);
}

fn layered() -> impl Iterator<Item = (String, World)> {
    LAYERED.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_layers() {
    check(layered(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_on_layers() {
    check_bands(built(&LAYERED[..2]), [16, ITERATIONS / 8], 1);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_layers_closely() {
    check(layered(), [REPLICATES, 2 * ITERATIONS]);
}

fn filters() -> impl Iterator<Item = (String, World)> {
    FILTERS.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_filters() {
    check(filters().take(26), [REPLICATES, ITERATIONS / 8]);
}

/// The last of the filters.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_on_sheets_and_films() {
    check(filters().skip(26), [REPLICATES, ITERATIONS / 8]);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_on_filters_closely() {
    check(filters(), [REPLICATES, 4 * ITERATIONS]);
}

fn skies() -> impl Iterator<Item = (String, World)> {
    SKIES.into_iter().map(|(name, build)| (name.to_owned(), build()))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_under_skies() {
    check(skies(), [REPLICATES, ITERATIONS / 4]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn integrators_agree_per_band_under_skies() {
    check_bands(built(&SKIES[..3]), [16, ITERATIONS / 8], 1);
}

#[test]
#[ignore = "minutes"]
fn integrators_agree_under_skies_closely() {
    check(skies(), [REPLICATES, 2 * ITERATIONS]);
}

/// The panel is seen within 0.15 of the normal, where crossed sheets leak the fourth power of it.
#[test]
fn crossed_polarizers_are_black_for_all_integrators() {
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        let intensity = |axis_deg: f32| {
            let scene = scene::<1>(&two_sheets(axis_deg), MONO, SIZE);
            let settings = settings(integrator, Mode::Polarized, MONO, 576, 5);
            mean_s0(&evidence::mean(&replicates(&scene, &settings, 2)))
        };
        let [parallel, diagonal, crossed] = [0.0, 45.0, 90.0].map(intensity);
        assert!(parallel > 0.0, "{integrator:?} sees nothing");
        assert!(crossed < 2e-4 * parallel, "{integrator:?}: {crossed} of {parallel} leaks");
        // Malus: a half, to the noise of 300,000 paths.
        assert!((diagonal / parallel - 0.5).abs() < 0.02, "{integrator:?}: {diagonal}, {parallel}");
    }
}
