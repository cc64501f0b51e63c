//! Small worlds with gray materials, and with tabulated ones.

use sunstone::glam::{DVec3, Vec3};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Medium, Phase, Transform};
use sunstone::{Error, PlacedWorld, Spectrum, World};

/// The middle of the spheres.
const BALL: DVec3 = DVec3::new(0.4, -0.6, 0.3);

/// A room with a lamp, a plate, and a sphere of glass, of materials that reflect, emit and refract
/// so; in a medium, if there is one.
fn room(
    wall: impl Into<Spectrum>,
    glow: impl Into<Spectrum>,
    plate: [Spectrum; 2],
    (glass, air): (&[Bsdf], Option<Medium>),
) -> PlacedWorld {
    let world = || -> Result<World, Error> {
        let mut world = World::new("room");
        let wall = world.add_material("wall", Material::from(Bsdf::diffuse(wall)).two_sided())?;
        let [eta, k] = plate;
        let metal = world.add_material("plate", Bsdf::Conductor { eta, k })?;
        let glow = world.add_material("lamp", Material::emitter(glow).two_sided())?;
        let here = Transform::IDENTITY;
        world.add_mesh("walls", Geometry::cuboid(-Vec3::ONE, Vec3::ONE), wall, here)?;
        let lamp = Geometry::quad(Vec3::Y * 0.9, Vec3::X * 0.5, Vec3::Z * 0.5);
        world.add_mesh("lamp", lamp, glow, here)?;
        let tilted = Geometry::quad(Vec3::Z * -0.8, Vec3::X * 0.6, Vec3::new(0.0, 0.6, 0.3));
        world.add_mesh("plate", tilted, metal, here)?;
        for (index, (bsdf, radius)) in glass.iter().zip([0.3, 0.15]).enumerate() {
            let glass = world.add_material(&format!("glass {index}"), bsdf.clone())?;
            world.add_sphere(&format!("ball {index}"), radius, glass, BALL)?;
        }
        if let Some(air) = &air {
            let air = world.add_medium("air", air.clone())?;
            world.set_scene_medium(air)?;
        }
        let place = Transform::looking(DVec3::Z * 0.9, DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(1.2), place)?;
        world.set_resolution([16, 16])?;
        Ok(world)
    };
    let world = world().expect("a sound world");
    PlacedWorld::new(world).expect("a sound world")
}

/// That of materials and light that are the same at all wavelengths.
pub fn gray_room() -> PlacedWorld {
    gray(None)
}

/// The same in fog of small particles, or of large ones.
pub fn gray_fogs() -> [PlacedWorld; 2] {
    let dipoles = Medium::new(0.1, 0.4, Phase::Rayleigh { depolarization: 0.02 });
    let drops = Medium::new(0.05, 0.6, Phase::HenyeyGreenstein { g: 0.7.into() });
    [dipoles, drops].map(|fog| gray(Some(fog)))
}

fn gray(air: Option<Medium>) -> PlacedWorld {
    room(0.6, 5.0, [0.95.into(), 6.7.into()], (&[Bsdf::dielectric(1.5)], air))
}

/// Tabulated materials in tabulated fog.
pub fn tabulated_fog() -> PlacedWorld {
    let [absorbs, scatters] = [[0.3, 0.0, 0.1, 0.2], [0.8, 0.2, 0.5, 0.1]].map(table);
    let fog =
        Medium::new(absorbs, scatters, Phase::HenyeyGreenstein { g: table([0.8, 0.2, -0.3, 0.0]) });
    let [wall, glow, eta, k] = TABLES.map(table);
    room(wall, glow, [eta, k], (&[Bsdf::dielectric(1.5)], Some(fog)))
}

/// Where tables have their ends, and bend in between.
const KNOTS_NM: [f32; 4] = [400.0, 480.0, 590.0, 700.0];
/// Those of the walls, of the lamp, and of the plate's n and k.
const TABLES: [[f32; 4]; 4] =
    [[0.1, 0.7, 0.4, 0.6], [2.0, 8.0, 1.0, 5.0], [0.5, 0.6, 1.0, 1.8], [4.0, 5.0, 6.0, 8.0]];

/// A table with those ends.
pub fn table(values: [f32; 4]) -> Spectrum {
    Spectrum::table(&KNOTS_NM, &values).expect("a sound table")
}

/// That of such tables, with glass that is the same for all wavelengths.
pub fn tabulated_room() -> PlacedWorld {
    tabulated(&[Bsdf::dielectric(1.5)])
}

/// The same with tables that go on at both ends, and say the same there.
pub fn longer_tabulated_room() -> PlacedWorld {
    let [wall, glow, eta, k] = TABLES.map(|values| {
        let [first, .., last] = values;
        let values = [&[first], &values[..], &[last]].concat();
        let nm = [&[300.0], &KNOTS_NM[..], &[900.0]].concat();
        Spectrum::table(&nm, &values).expect("a sound table")
    });
    room(wall, glow, [eta, k], (&[Bsdf::dielectric(1.5)], None))
}

/// The same with glass that disperses light more than any does, around more glass, of which the
/// first is nested: light is refracted once, twice or four times, and reflected totally.
pub fn dispersive_room() -> PlacedWorld {
    tabulated(&nested_glass(table([1.9, 1.7, 1.55, 1.4])))
}

/// The same under another light, and with another index of the outer glass.
pub fn dispersive_room_under(glow: Spectrum, ior: Spectrum) -> PlacedWorld {
    tabulated_under(glow, &nested_glass(ior))
}

fn nested_glass(ior: Spectrum) -> [Bsdf; 2] {
    let outer = Bsdf::DispersiveDielectric { ior, exterior_ior: 1.0.into() };
    [outer, Bsdf::dielectric(1.33)]
}

fn tabulated(glass: &[Bsdf]) -> PlacedWorld {
    tabulated_under(table(TABLES[1]), glass)
}

/// That of tables but for the light.
fn tabulated_under(glow: Spectrum, glass: &[Bsdf]) -> PlacedWorld {
    let [wall, _, eta, k] = TABLES.map(table);
    room(wall, glow, [eta, k], (glass, None))
}
