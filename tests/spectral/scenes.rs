//! Small worlds with gray materials, and with tabulated ones.

use sunstone::glam::{DVec3, Vec3};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::{Error, PlacedWorld, Spectrum, World};

/// A room with a lamp, a sphere and a plate, of materials that reflect and emit so.
pub fn room(
    wall: impl Into<Spectrum>,
    glow: impl Into<Spectrum>,
    plate: [Spectrum; 2],
) -> PlacedWorld {
    let world = || -> Result<World, Error> {
        let mut world = World::new("room");
        let wall = world.add_material("wall", Material::from(Bsdf::diffuse(wall)).two_sided())?;
        let glass = world.add_material("glass", Bsdf::dielectric(1.5))?;
        let [eta, k] = plate;
        let metal = world.add_material("plate", Bsdf::Conductor { eta, k })?;
        let glow = world.add_material("lamp", Material::emitter(glow).two_sided())?;
        let here = Transform::IDENTITY;
        world.add_mesh("walls", Geometry::cuboid(-Vec3::ONE, Vec3::ONE), wall, here)?;
        let lamp = Geometry::quad(Vec3::Y * 0.9, Vec3::X * 0.5, Vec3::Z * 0.5);
        world.add_mesh("lamp", lamp, glow, here)?;
        let tilted = Geometry::quad(Vec3::Z * -0.8, Vec3::X * 0.6, Vec3::new(0.0, 0.6, 0.3));
        world.add_mesh("plate", tilted, metal, here)?;
        world.add_sphere("ball", 0.3, glass, DVec3::new(0.4, -0.6, 0.3))?;
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
    room(0.6, 5.0, [0.95.into(), 6.7.into()])
}

/// That of tables that have their ends at 400 and 700 nm, and bend in between.
pub fn tabulated_room() -> PlacedWorld {
    let table = |values: [f32; 4]| {
        Spectrum::table(&[400.0, 480.0, 590.0, 700.0], &values).expect("a sound table")
    };
    let glow = table([2.0, 8.0, 1.0, 5.0]);
    room(
        table([0.1, 0.7, 0.4, 0.6]),
        glow,
        [table([0.5, 0.6, 1.0, 1.8]), table([4.0, 5.0, 6.0, 8.0])],
    )
}
