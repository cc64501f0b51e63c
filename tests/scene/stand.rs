//! `scenes/materials.glb`: every model stands there, and nothing of it is doubted.

use std::collections::HashSet;
use std::mem::discriminant;
use std::path::Path;

use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::{World, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Bsdf, Textures};

fn stand() -> World {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/materials.glb");
    load(&file).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_model_stands_there() {
    let world = stand();
    assert_eq!(world.warnings(), [] as [String; 0]);
    assert!(world.put_in().is_empty(), "it has a camera and lamps");
    let models: HashSet<_> = world.entities().query::<&Bsdf>().iter().map(discriminant).collect();
    // All but `measured`, whose table is a file beside the scene.
    assert_eq!(models.len(), 19);
    let painted = world.entities().query::<&Textures>().iter().count();
    assert!(painted >= 15, "{painted} materials have textures");
}

#[test]
fn milk_fog_and_colored_glass_fill_balls() {
    let baked: BakedScene<3> = bake(&stand(), &Carried::RGB).unwrap_or_else(|error| {
        panic!("{error}");
    });
    let scattering = baked.optics.media.iter().filter(|medium| medium.sigma_s[1] > 0.0).count();
    assert_eq!((baked.optics.media.len(), scattering), (3, 2));
}
