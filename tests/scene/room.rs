//! A room that a program makes, and what is done to it.

use glam::{DVec3, Vec3};
use sunstone::internals::scene::world::{
    Bsdf, Geometry, Lens, Material, Medium, Phase, Punctual, Skin, Transform,
};
use sunstone::internals::scene::{SceneError, World, bake};
use sunstone::internals::spectrum::Carried;

/// A panel that shines, a ball of glass that holds fog, a lamp and a camera, in a clear sky.
pub fn room() -> World {
    let built = || -> Result<World, SceneError> {
        let mut world = World::new("room");
        let fog =
            world.add_medium("fog", Medium::new(0.25, [1.0, 2.0, 3.0], Phase::isotropic()))?;
        let glow = Material::from(Bsdf::diffuse(0.5)).emitting([1.0, 0.5, 0.25]);
        let glow = world.add_material("glow", glow)?;
        let panel = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        world.add_mesh("panel", panel, glow, Transform::IDENTITY)?;
        let glass = world.add_material("glass", Bsdf::dielectric(1.5))?;
        world.add_sphere("ball", 0.5, Skin::from(glass).interior(fog), DVec3::Z * 2.0)?;
        world.add_light("lamp", Punctual::point([1.0; 3]), DVec3::Y * 3.0)?;
        let lens = Lens::Perspective {
            yfov: f64::from(0.7_f32),
            aspect: Some(1.0),
            aperture_radius: 0.0,
            focus_distance: 1.0,
        };
        world.set_camera("eye", lens, DVec3::Z * 5.0)?;
        world.set_resolution([32, 32])?;
        world.set_environment(0.125)?;
        Ok(world)
    };
    built().unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
pub fn refusal(world: &World) -> String {
    bake(world, &Carried::RGB).map(|_| ()).expect_err("the edit was accepted").to_string()
}

#[track_caller]
pub fn has_all(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
}

/// The room after one edit: what baking it says.
#[track_caller]
pub fn edited(edit: impl FnOnce(&mut World)) -> String {
    let mut world = room();
    edit(&mut world);
    refusal(&world)
}

/// Replaces a component of a named entity.
pub fn insert(world: &mut World, name: &str, component: impl hecs::Component) {
    let entity = world.find(name).unwrap();
    world.entities_mut().insert_one(entity, component).unwrap();
}

pub fn remove<T: hecs::Component>(world: &mut World, name: &str) {
    let entity = world.find(name).unwrap();
    world.entities_mut().remove_one::<T>(entity).unwrap();
}

pub fn despawn(world: &mut World, name: &str) {
    let entity = world.find(name).unwrap();
    world.entities_mut().despawn(entity).unwrap();
}
