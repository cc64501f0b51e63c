//! What Blender exports: custom properties, and lamps in watts.

use std::f32::consts::PI;
use std::path::Path;

use sunstone::internals::film::filter::{Filter, FilterKind};
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::emitter::EmitterModel;
use sunstone::internals::scene::world::{Ball, Bsdf, Name, Raster, Resolution, World};
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;

fn shipped() -> World {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/blender.gltf");
    load(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// All that `scenes/blender.py` sets as custom properties has arrived, and nothing is doubted.
#[test]
fn custom_properties_are_read() {
    let world = shipped();
    assert_eq!(world.warnings(), [] as [String; 0]);
    assert!(world.put_in().is_empty(), "it has a camera and lights");
    let mut found: Vec<(String, Bsdf)> = Vec::new();
    for (name, bsdf) in world.entities().query::<(&Name, &Bsdf)>().iter() {
        found.push((name.0.clone(), bsdf.clone()));
    }
    let of = |name: &str| {
        let (_, bsdf) = found.iter().find(|(known, _)| known.contains(name)).expect(name);
        bsdf
    };
    assert!(matches!(of("upright"), Bsdf::Polarizer { axis_deg: 90.0, .. }));
    assert!(matches!(of("level"), Bsdf::Polarizer { axis_deg: 0.0, .. }));
    let plate = of("half-wave plate");
    assert!(matches!(plate, Bsdf::Retarder { axis_deg: 45.0, retardance_deg: 180.0 }));
    assert!(matches!(of("glass"), Bsdf::Dielectric { .. }));
    assert!(matches!(of("gold"), Bsdf::Conductor { .. }));
    assert!(matches!(of("steel"), Bsdf::MetallicRoughness { .. }));
    let balls: Vec<f64> = world.entities().query::<&Ball>().iter().map(|it| it.radius).collect();
    assert_eq!(balls, [0.25; 2]);
    let raster = world.entities().query::<&Raster>().iter().next().copied().expect("it has one");
    assert_eq!(raster.filter, Filter::of(FilterKind::Gaussian));
    let size = world.entities().query::<&Resolution>().iter().next().copied();
    assert_eq!(size, Some(Resolution([480, 320])));
}

/// A lamp of P watts shines P / (4 pi) watts per steradian, and a panel of P watts and area A has
/// the radiance P / (pi A), on one side.
#[test]
fn watts_are_watts() {
    let baked: BakedScene<3> = bake(&shipped(), &Carried::RGB).unwrap();
    let [mut lamps, mut panels, mut skies] = [0; 3];
    let assert_near = |found: f32, expected: f32| {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    };
    for (row, emitter) in baked.optics.emitters.iter().enumerate() {
        let radiance = baked.optics.radiance_of(row);
        if matches!(emitter.model, EmitterModel::Point(_)) {
            lamps += 1;
            assert_near(radiance[1], 30.0 / (4.0 * PI));
        } else if matches!(emitter.model, EmitterModel::Triangle(_)) {
            panels += 1;
            assert_near(radiance[1], 40.0 / (PI * 0.64));
        } else {
            skies += usize::from(matches!(emitter.model, EmitterModel::Environment(_)));
            assert_near(radiance[1], 0.06);
        }
    }
    assert_eq!([lamps, panels, skies], [1, 2, 1]);
}
