//! Light scattered out of plane-parallel slabs, against published tables and other solvers
//! (`tests/data/slab`): all orders of scattering, Mueller matrices, frames, signs and units.
//!
//! Every row of a table is a direction in which light leaves a slab that the sun shines on. It is
//! rendered on its own, with all rays of the film in that direction, in replicates whose spread is
//! its error. Slabs are boxes of height 1 and half edge 400: the table's have no end, ours none
//! that light could reach.
//!
//! The quick tests score some 120 numbers. A normal number exceeds their limit of 5.5 with a chance
//! of 4e-8: noise fails them in 1 of 200,000 changes of the random numbers. The full one checks the
//! root mean square of 175 scores or more for S0 to S2, whose standard deviation is 0.05, so that
//! its limits, 0.8 and 1.2, are four of these away, and of 75 for S3 (elsewhere it is zero without
//! noise), where they are 2.4 away: 1 of 70 changes of the random numbers fails.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::fs;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::math::hash::combine;
use sunstone::internals::render::{Mode, Options, PlacedWorld};
use sunstone::internals::scene::World;
use sunstone::internals::transport::Sampling;

use crate::support::gltf::Document;
use crate::support::rendering::{
    MONO, in_bands, in_package, replicates, scene, settings, spectral_replicates,
};
use crate::support::statistics::{Estimate, ROUNDING, estimate, rms, worst};

const SIZE: [u32; 2] = [16, 16];
const REPLICATES: u32 = 16;
/// Longest path, of which hardly any light is left in the thickest slab.
const PATH_LENGTH_MAX: u32 = 4_096;
/// Half an edge of a slab.
const HALF_EDGE: f32 = 400.0;
/// The ground is this far below the slab, and the camera between them: far enough for the offsets
/// that keep rays off surfaces.
const GROUND: f32 = 0.02;
/// What no score exceeds.
const LIMIT: f64 = 5.5;

/// What scatters in the slabs of a table.
enum Phase {
    /// Small particles with a depolarization.
    Rayleigh(f64),
    /// A file of tabulated elements.
    Table(&'static str),
    /// Skimmed milk, by its contents.
    SkimmedMilk,
}

/// A file of directions.
struct Table {
    file: &'static str,
    phase: Phase,
    mode: Mode,
    /// How many times the iterations of the easiest tables it needs for the same error.
    effort: u32,
    /// The column of S0, and of what else is compared.
    columns: &'static [&'static str],
}

const STOKES: &[&str] = &["S0", "S1", "S2", "S3"];
const WITHOUT_V: &[&str] = &["S0_vector", "S1", "S2"];

const TABLES: [Table; 9] = [
    polarized("rayleigh_natraj2009", 1, Phase::Rayleigh(0.0), STOKES),
    polarized("rayleigh_natraj2011_thick", 2, Phase::Rayleigh(0.0), STOKES),
    polarized("iprt_a1_rayleigh_depol0.03", 1, Phase::Rayleigh(0.03), STOKES),
    polarized("iprt_a2_rayleigh_lambert0.3_depol0.03", 1, Phase::Rayleigh(0.03), STOKES),
    polarized("iprt_a3_mie_aerosol", 6, Phase::Table("iprt_a3_waso_phase"), STOKES),
    polarized("siewert2000_IIA", 4, Phase::Table("siewert2000_IIA_phase"), STOKES),
    polarized("milk_skim_550_sasktran2", 8, Phase::Table("milk_skim_550_phase"), STOKES),
    polarized("rayleigh_scalar_vs_vector_sasktran2", 1, Phase::Rayleigh(0.0), WITHOUT_V),
    Table {
        file: "rayleigh_scalar_vs_vector_sasktran2",
        phase: Phase::Rayleigh(0.0),
        mode: Mode::Scalar,
        effort: 1,
        columns: &["S0_scalar"],
    },
];

const fn polarized(
    file: &'static str,
    effort: u32,
    phase: Phase,
    columns: &'static [&'static str],
) -> Table {
    Table { file, phase, mode: Mode::Polarized, effort, columns }
}

/// The file's columns, and its cells by row.
struct Csv {
    columns: HashMap<String, usize>,
    rows: Vec<Vec<String>>,
}

impl Csv {
    fn read(name: &str) -> Self {
        let path = in_package(&format!("tests/data/slab/{name}.csv"));
        let text = fs::read_to_string(&path).expect("the data are whole");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
        let heads = lines.next().expect("a line of names");
        Self {
            columns: heads.enumerate().map(|(index, name)| (name, index)).collect(),
            rows: lines.map(Iterator::collect).collect(),
        }
    }

    fn word(&self, row: usize, column: &str) -> &str {
        &self.rows[row][self.columns[column]]
    }

    fn number(&self, row: usize, column: &str) -> f64 {
        self.word(row, column).parse().expect("a number")
    }

    /// A number that is the same in the whole file, if it is not in it.
    fn number_or(&self, row: usize, column: &str, default: f64) -> f64 {
        if self.columns.contains_key(column) { self.number(row, column) } else { default }
    }

    /// A column by its name in the extension.
    fn column(&self, column: &str) -> Vec<f64> {
        (0..self.rows.len()).map(|row| self.number(row, column)).collect()
    }

    /// `count` rows that have been picked at random, always the same.
    fn pick(&self, count: usize) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.rows.len()).collect();
        rows.sort_by_key(|&row| combine(0x51ab, row as u32));
        rows.truncate(count);
        rows
    }
}

impl Phase {
    fn medium(&self, extinction: f64, albedo: f64) -> Value {
        let mut medium = json!({
            "sigma_a": extinction * (1.0 - albedo), "sigma_s": extinction * albedo});
        match self {
            Phase::Rayleigh(depolarization) => {
                medium["phase"] = json!("rayleigh");
                medium["depolarization"] = json!(depolarization);
            }
            Phase::Table(file) => {
                let csv = Csv::read(file);
                medium["phase"] = json!("mueller_table");
                medium["table"] = json!({"theta_deg": csv.column("theta_deg")});
                for element in ["M00", "M01", "M11", "M22", "M23", "M33"] {
                    medium["table"][element.to_lowercase()] = json!(csv.column(element));
                }
            }
            Phase::SkimmedMilk => {
                let [fat_percent, protein_percent] = SKIMMED;
                medium["phase"] = json!("mie");
                medium["milk"] =
                    json!({"fat_percent": fat_percent, "protein_percent": protein_percent});
            }
        }
        medium
    }
}

/// What milk is made of in the tables of `tests/data/mie`.
const SKIMMED: [f64; 2] = [0.1, 3.4];

/// The slab of a row in the sun, and a camera that looks against the light that leaves it.
fn slab(table: &Table, csv: &Csv, row: usize) -> World {
    let number = |column: &str| csv.number(row, column);
    let mut scene = Document::default();
    let omega = csv.number_or(row, "omega", 1.0);
    let medium = scene.medium(table.phase.medium(number("tau"), omega));
    scene.fog(medium, |scene, null| {
        scene.cuboid(Vec3::Z * 0.5, Vec3::new(HALF_EDGE, HALF_EDGE, 0.5), null);
    });
    let albedo = number("albedo");
    if albedo > 0.0 {
        let ground = scene.diffuse(albedo as f32);
        scene.quad(Vec3::Z * -GROUND, Vec3::X * HALF_EDGE, Vec3::Y * HALF_EDGE, ground);
    }
    let sun = json!({"type": "directional", "intensity": 1.0});
    let sunlight = towards(number("mu0"), 0.0, -1.0);
    scene.light(sun, Vec3::ZERO, sunlight);
    let (surface, sign) = match csv.word(row, "level") {
        "toa_up" => (Vec3::Z, 1.0),
        "boa_down" => (Vec3::ZERO, -1.0),
        other => panic!("the level {other}"),
    };
    let light = towards(number("mu"), number("phi_deg"), sign);
    let eye = surface + light * (0.5 * GROUND / light.z.abs());
    scene.up(Vec3::Z);
    scene.orthographic(eye, eye - light, 1e-3);
    scene.load("slab")
}

/// The direction of the given cosine to the vertical, and azimuth, up or down.
fn towards(cosine: f64, azimuth_deg: f64, sign: f64) -> Vec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let (y, x) = azimuth_deg.to_radians().sin_cos();
    DVec3::new(sine * x, sine * y, sign * cosine).as_vec3()
}

/// What came out for one row.
struct Scored {
    /// By Stokes component, as far as they have noise.
    scores: Vec<(usize, f64)>,
    /// S0 over that of the table, less one.
    deviation: f64,
    /// The relative standard error of ours.
    error: f64,
}

/// Renders a row and scores it.
fn score(table: &Table, csv: &Csv, row: usize, integrator: Integrator, iterations: u32) -> Scored {
    let scene = scene::<1>(&slab(table, csv, row), MONO, SIZE);
    let settings = settings_of(table, row, integrator, iterations);
    score_images(table, csv, row, (&replicates(&scene, &settings, REPLICATES), 0))
}

fn settings_of(table: &Table, row: usize, integrator: Integrator, iterations: u32) -> Options {
    let settings = settings(integrator, table.mode, MONO, iterations, PATH_LENGTH_MAX);
    // Rows and modes have seeds of their own, or their noise would be the same.
    let name = combine(table.file.len() as u32, table.mode as u32);
    let first = combine(name, row as u32) & 0x00ff_ff00;
    Options { seed: settings.seed + first, ..settings }
}

/// Scores a channel of the images of a row.
fn score_images(
    table: &Table,
    csv: &Csv,
    row: usize,
    (images, channel): (&[StokesImage], usize),
) -> Scored {
    let channels = images[0].color.channels();
    let pixels: Vec<usize> = (0..(SIZE[0] * SIZE[1]) as usize).collect();
    let s0 = csv.number(row, table.columns[0]);
    let mut scores = Vec::new();
    let mut of_s0 = Estimate::exact(0.0);
    for (component, column) in table.columns.iter().enumerate() {
        let ours = estimate(images, component * channels + channel, &pixels);
        // Tables without errors are good to six digits.
        let error = csv.number_or(row, &format!("{column}_err"), 1e-6 * s0);
        let mean = csv.number(row, column);
        let theirs = Estimate { mean, variance: error * error, degrees: f64::from(u32::MAX) };
        match ours.score(&theirs, s0) {
            Some(score) => scores.push((component, score)),
            None => assert!((ours.mean - mean).abs() < ROUNDING * s0, "{column}: {ours:?}"),
        }
        if component == 0 {
            of_s0 = ours;
        }
    }
    Scored { scores, deviation: of_s0.mean / s0 - 1.0, error: of_s0.variance.sqrt() / s0 }
}

/// Prints a line for what has been found in a table.
fn report(table: &Table, found: &[Scored]) {
    let of = |component: usize| -> Vec<f64> {
        let scores = found.iter().flat_map(|scored| &scored.scores);
        scores.filter(|(of, _)| *of == component).map(|(_, score)| *score).collect()
    };
    let all: Vec<f64> = (0..4).flat_map(of).collect();
    let column = |component: usize| match of(component) {
        scores if scores.is_empty() => "    -".to_owned(),
        scores => format!("{:5.2}", rms(&scores)),
    };
    let deviations: Vec<f64> = found.iter().map(|scored| 100.0 * scored.deviation).collect();
    let errors: Vec<f64> = found.iter().map(|scored| 100.0 * scored.error).collect();
    println!(
        "{:38} {:9} {:3} rows, rms z of S0 to S3 {} {} {} {}, worst {:4.2}; S0 off by {:+.3} % \
         in the mean, {:.3} % at worst (standard errors of {:.3} %)",
        table.file,
        format!("{:?}", table.mode),
        found.len(),
        column(0),
        column(1),
        column(2),
        column(3),
        worst(&all),
        deviations.iter().sum::<f64>() / deviations.len() as f64,
        worst(&deviations),
        rms(&errors),
    );
}

/// Scores rows of all tables, and prints what it finds.
fn score_tables(integrator: Integrator, rows: usize, iterations: u32) -> Vec<Vec<Scored>> {
    let of_table = |table: &Table| {
        let csv = Csv::read(table.file);
        let rows = csv.pick(rows).into_iter();
        let found: Vec<Scored> = rows
            .map(|row| score(table, &csv, row, integrator, table.effort * iterations))
            .collect();
        report(table, &found);
        found
    };
    TABLES.iter().map(of_table).collect()
}

fn expect_scores_within_limit(found: &[Vec<Scored>]) {
    for (table, found) in TABLES.iter().zip(found) {
        let scores = found.iter().flat_map(|scored| &scored.scores);
        let worst = scores.fold(0.0_f64, |worst, (_, score)| worst.max(score.abs()));
        assert!(worst < LIMIT, "{}, {:?}: a score of {worst}", table.file, table.mode);
    }
}

/// Light that is scattered once is known in closed form, and paths of two segments have so little
/// noise that what boundaries take from the optical depth would show.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn light_scattered_once_is_as_the_closed_form_says() {
    let table = &TABLES[TABLES.len() - 1];
    let csv = Csv::read(table.file);
    for row in
        csv.pick(usize::MAX).into_iter().filter(|&row| csv.number(row, "albedo") == 0.0).take(4)
    {
        let scene = scene::<1>(&slab(table, &csv, row), MONO, SIZE);
        let images =
            replicates(&scene, &settings(Integrator::Path, table.mode, MONO, 256, 2), REPLICATES);
        let pixels: Vec<usize> = (0..(SIZE[0] * SIZE[1]) as usize).collect();
        let found = estimate(&images, 0, &pixels).mean;
        let number = |column: &str| csv.number(row, column);
        let (mu, mu0) = (number("mu"), number("mu0"));
        let sunlight = towards(mu0, 0.0, -1.0).as_dvec3();
        let cosine = sunlight.dot(towards(mu, number("phi_deg"), 1.0).as_dvec3());
        let phase = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
        let escapes = 1.0 - (-number("tau") * (1.0 / mu + 1.0 / mu0)).exp();
        let truth = phase * mu0 / (mu + mu0) * escapes;
        println!("mu {mu:4}, mu0 {mu0}: {found:.7}, should be {truth:.7}");
        assert_eq!(csv.word(row, "level"), "toa_up");
        assert!((found / truth - 1.0).abs() < 1e-4, "{found} {truth}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn path_finds_the_light_of_slabs() {
    expect_scores_within_limit(&score_tables(Integrator::Path, 2, 16));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bdpt_finds_the_light_of_slabs() {
    expect_scores_within_limit(&score_tables(Integrator::Bdpt, 1, 16));
}

/// Milk by its contents, whose phase matrix is read between computed ones, in the band of a
/// spectral render about the wavelength of the table.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn a_band_of_milk_finds_the_light_of_slabs() {
    let table = polarized("milk_skim_550_sasktran2", 8, Phase::SkimmedMilk, STOKES);
    let csv = Csv::read(table.file);
    let of_row = |row: usize| {
        let world = PlacedWorld::new(slab(&table, &csv, row)).expect("a sound world");
        let options = settings_of(&table, row, Integrator::Path, 16 * table.effort);
        let bands = [[450.0, 10.0], [550.0, 2.0], [650.0, 10.0]];
        let images = spectral_replicates(&world, &in_bands(8, &bands, SIZE, options), REPLICATES);
        score_images(&table, &csv, row, (&images, 1))
    };
    let found: Vec<Scored> = csv.pick(4).into_iter().map(of_row).collect();
    report(&table, &found);
    let scores = found.iter().flat_map(|scored| &scored.scores);
    let worst = scores.fold(0.0_f64, |worst, (_, score)| worst.max(score.abs()));
    assert!(worst < LIMIT, "a score of {worst}");
}

/// Polarization makes thick slabs hardly noisier: the error of a pixel is at most 1.5 times that of
/// scalar mode, where it grows without bound if directions are drawn as for unpolarized light. Of
/// 256 pixels and 16 replicates the ratio is known to 2 %.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn thick_slabs_are_no_noisier_with_polarization() {
    let table = &TABLES[1];
    let csv = Csv::read(table.file);
    let row = csv.pick(usize::MAX).into_iter().find(|&row| csv.number(row, "tau") == 16.0);
    let scene = scene::<1>(&slab(table, &csv, row.expect("a thick slab")), MONO, SIZE);
    let error = |mode: Mode, sampling: Sampling| {
        let settings = settings(Integrator::Path, mode, MONO, 16, PATH_LENGTH_MAX);
        let images = replicates(&scene, &Options { sampling, ..settings.clone() }, REPLICATES);
        let pixels = (0..(SIZE[0] * SIZE[1]) as usize).map(|pixel| {
            let Estimate { mean, variance, .. } = estimate(&images, 0, &[pixel]);
            (variance, mean)
        });
        let (variance, mean) = pixels.fold((0.0, 0.0), |sum, it| (sum.0 + it.0, sum.1 + it.1));
        variance.sqrt() / mean
    };
    let scalar = error(Mode::Scalar, Sampling::Stokes);
    let [stokes, intensity] = [Sampling::Stokes, Sampling::Intensity]
        .map(|sampling| error(Mode::Polarized, sampling) / scalar);
    println!("errors over scalar's: {stokes:.2}, drawn by intensity {intensity:.2}");
    assert!(stokes < 1.5, "{stokes}");
    assert!(intensity > 2.0 * stokes, "the test could not fail: {intensity}");
}

#[test]
#[ignore = "ten minutes: 1 to 8 million paths for each of 200 rows, to be run before a release"]
fn path_finds_the_light_of_slabs_at_full_length() {
    let found = score_tables(Integrator::Path, 25, 256);
    expect_scores_within_limit(&found);
    for component in 0..4 {
        let scores = found.iter().flatten().flat_map(|scored| &scored.scores);
        let scores: Vec<f64> =
            scores.filter(|(of, _)| *of == component).map(|(_, score)| *score).collect();
        let rms = rms(&scores);
        println!("S{component}: rms z {rms:.3} of {} rows", scores.len());
        assert!((0.8..1.2).contains(&rms), "S{component}: rms z {rms}");
    }
    let deviations = found.iter().flatten().map(|scored| scored.deviation.abs());
    let worst = deviations.fold(0.0, f64::max);
    assert!(worst < 0.005, "S0 is off by {worst}");
}
