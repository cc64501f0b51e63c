//! Scenes with instances look as if they held copies.

use std::sync::Arc;

use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scattering::Scene;
use sunstone::internals::spectrum::Color;

use crate::support::evidence;
use crate::support::gltf::Flock;
use crate::support::rendering::{replicates, scene, settings};
use crate::support::scenes::flock;
use crate::support::statistics::{Estimate, cells, rms, rms_limits, worst};

const SIZE: [u32; 2] = [24, 24];
const REPLICATES: u32 = 32;
/// About 3,000 numbers are compared, of which a normal one exceeds this with a chance of 4e-8.
const LIMIT: f64 = 5.5;

fn flock_of(kind: Flock) -> Arc<Scene<3>> {
    scene::<3>(&flock(kind), Color::Rgb, SIZE)
}

#[test]
fn one_mesh_in_many_places_is_kept_once() {
    let [shared, copied] = [Flock::Instances, Flock::Copies].map(flock_of);
    let [ours, theirs] = [&shared, &copied].map(|scene| scene.accelerator.statistics());
    assert_eq!((ours.objects, ours.instances), (2, 32));
    assert_eq!((theirs.objects, theirs.instances), (0, 0));
    let of_objects: usize =
        shared.shapes.instanced.objects().iter().map(|o| o.triangles.len()).sum();
    assert_eq!(theirs.triangles, ours.triangles + 16 * of_objects);
    assert!(ours.bytes < theirs.bytes / 12, "{} {}", ours.bytes, theirs.bytes);
    let [a, b] = [&shared, &copied].map(|scene| scene.shapes.bounds);
    assert!((a.center - b.center).length() < 1e-5 && (a.radius - b.radius).abs() < 1e-5);
}

/// Half of the instances are mirrored, and filled with fog: they are apart, so what is in them is
/// known without looking around.
#[test]
fn mirrored_instances_are_filled_as_copies_are() {
    let [shared, copied] = [Flock::Instances, Flock::Copies].map(flock_of);
    for scene in [&shared, &copied] {
        assert!(!scene.shapes.overlaps);
        assert_eq!(scene.shapes.bodies.len(), 16);
    }
    let fillings = |scene: &Scene<3>| -> Vec<u32> {
        scene.shapes.bodies.iter().map(|body| body.filling).collect()
    };
    assert_eq!(fillings(&shared), fillings(&copied));
}

/// Differences of images with the same seeds: their means are zero but for noise, and far less
/// noisy than with other seeds, since all but few of the paths are the same.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn instances_render_as_copies_do() {
    let [shared, copied] = [Flock::Instances, Flock::Copies].map(flock_of);
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        let settings = settings(integrator, Mode::Polarized, Color::Rgb, 16, 6);
        let photons = Photons { per_iteration: Some(10_000), samples: Some(4), ..settings.photons };
        let settings = Options { photons, ..settings.clone() };
        let ours = replicates(&shared, &settings, REPLICATES);
        let theirs = replicates(&copied, &settings, REPLICATES);
        let others =
            replicates(&copied, &Options { seed: 1 << 20, ..settings.clone() }, REPLICATES);
        let [same, other] = [&theirs, &others].map(|reference| differences(&ours, reference));
        let scores: Vec<f64> = same.iter().filter_map(score).collect();
        let [low, high] = rms_limits(scores.len() / 3);
        let (rms, worst) = (rms(&scores), worst(&scores));
        let noise = |all: &[Estimate]| all.iter().map(|it| it.variance).sum::<f64>();
        let gain = noise(&other) / noise(&same);
        println!(
            "{integrator:?}: rms {rms:.2} ({low:.2} to {high:.2}), worst {worst:.2}, {gain:.0}"
        );
        // Photons that rattle about in glass with smooth normals are seldom and much, and no two of
        // them the same once they differ in the last bit.
        let gain_least = if integrator == Integrator::Ppm { 0.0 } else { 100.0 };
        if !(rms < high && worst < LIMIT && gain > gain_least) {
            let test = format!("instances/{integrator:?}");
            let [ours, theirs] = [&ours, &theirs].map(|images| evidence::mean(images));
            panic!("see {}", evidence::keep(&test, &ours, &theirs).display());
        }
    }
}

/// Of all planes and cells of 4 x 4 pixels.
fn differences(ours: &[StokesImage], theirs: &[StokesImage]) -> Vec<Estimate> {
    let image = &ours[0];
    let cells = cells(image.width, image.height, 4, &vec![true; image.width * image.height]);
    let mean = |image: &StokesImage, plane: usize, cell: &[usize]| {
        cell.iter().map(|&pixel| f64::from(image.planes[plane][pixel])).sum::<f64>()
            / cell.len() as f64
    };
    let mut all = Vec::new();
    for plane in 0..image.planes.len() {
        for cell in &cells {
            let pairs = ours.iter().zip(theirs);
            let of_pairs = pairs.map(|(a, b)| mean(a, plane, cell) - mean(b, plane, cell));
            all.push(Estimate::of(&of_pairs.collect::<Vec<f64>>()));
        }
    }
    all
}

fn score(difference: &Estimate) -> Option<f64> {
    difference.score(&Estimate::exact(0.0), 1.0)
}
