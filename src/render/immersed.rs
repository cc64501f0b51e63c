//! What is in which medium, in words.

use std::collections::{BTreeMap, BTreeSet};

use crate::math::text::listed;
use crate::scattering::Scene;
use crate::scattering::immersion::Around;
use crate::scene::World;
use crate::scene::emitter::EmitterModel;

/// Most emitters that are listed one by one.
const EMITTERS: usize = 12;

/// The coefficients that media compute, in RGB, and the media that the camera and the emitters of
/// the same world are in, a line each.
pub fn immersed(world: &World, scene: &Scene<3>) -> String {
    let media = world.media_names();
    let mut lines = Vec::new();
    for ((name, is_computed), medium) in media.iter().zip(&scene.optics.media) {
        if *is_computed {
            let [sigma_a, sigma_s] = [medium.sigma_a, medium.sigma_s].map(in_words);
            lines.push(format!("{name} in RGB: sigma_a {sigma_a}, sigma_s {sigma_s}"));
        }
    }
    let name_of = |medium: u32| match media.get(medium as usize) {
        Some((name, _)) => name.clone(),
        None => "clear space".to_owned(),
    };
    lines.push(match scene.sensor_medium {
        Around::Same(medium) => format!("the camera is in {}", name_of(medium)),
        Around::Varies => "the camera is on both sides of a boundary".to_owned(),
    });
    let emitters = emitters(world, scene, name_of);
    for (name, around) in emitters.iter().take(EMITTERS) {
        lines.push(format!("{name} shines into {}", listed(around)));
    }
    if emitters.len() > EMITTERS {
        lines.push(format!("and {} emitters more", emitters.len() - EMITTERS));
    }
    lines.into_iter().map(|line| format!("  {line}\n")).collect()
}

/// The names of what has a place and shines, with a number of its own, by row of the emitters.
pub fn names_of_emitters<const N: usize>(
    world: &World,
    scene: &Scene<N>,
) -> Vec<Option<(usize, String)>> {
    let surfaces = world.surface_names();
    let mut lamps = world.lamp_names().into_iter();
    let mut name = |row: usize, model: &EmitterModel| {
        let of_primitive = |primitive: u32| {
            let surface = scene.shapes.surface_of(primitive) as usize;
            Some((surface, surfaces[surface].clone()))
        };
        match model {
            EmitterModel::Triangle(it) => of_primitive(it.primitive),
            EmitterModel::Sphere(it) => of_primitive(it.primitive),
            EmitterModel::Point(_) | EmitterModel::Patterned(_) | EmitterModel::Spot(_) => {
                lamps.next().map(|name| (surfaces.len() + row, name))
            }
            EmitterModel::Directional(_)
            | EmitterModel::Sun(_)
            | EmitterModel::Environment(_)
            | EmitterModel::Panorama(_) => None,
        }
    };
    let emitters = scene.optics.emitters.iter().enumerate();
    emitters.map(|(row, emitter)| name(row, &emitter.model)).collect()
}

/// What has a place and shines, and what is about it.
fn emitters(
    world: &World,
    scene: &Scene<3>,
    name_of: impl Fn(u32) -> String,
) -> Vec<(String, BTreeSet<String>)> {
    let mut found: BTreeMap<(usize, String), BTreeSet<String>> = BTreeMap::new();
    for (row, name) in names_of_emitters(world, scene).into_iter().enumerate() {
        let Some(key) = name else { continue };
        let media = found.entry(key).or_default();
        match scene.media_of_emitter(row) {
            Around::Same(around) => media.extend(around.map(&name_of)),
            Around::Varies => drop(media.insert("both sides of a boundary".to_owned())),
        }
    }
    found.into_iter().map(|((_, name), media)| (name, media)).collect()
}

fn in_words(values: [f32; 3]) -> String {
    let [red, green, blue] = values.map(|value| format!("{value:.4}"));
    format!("[{red}, {green}, {blue}]")
}
