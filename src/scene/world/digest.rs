//! What tells one world from another.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt::{Debug, Write};
use std::sync::Arc;

use hecs::{Component, Entity};

use crate::polarization::Analyzer;

use super::incandescent::Incandescent;
use super::light::{Luminaire, Projection};
use super::{
    Ball, Boundary, Bsdf, Emission, EmittedStokes, Environment, FillsScene, Geometry, Lens, MadeOf,
    Medium, Mesh, Name, Order, Punctual, Raster, Resolution, Sides, Textures, Transform, Window,
    World, places_in_order,
};

/// The components that are digested as `Debug` says them, which names all fields, and numbers to
/// their last bit.
macro_rules! columns {
    ($($component:ty),* $(,)?) => {
        impl World {
            fn digest_columns(&self, digest: &mut Digest) {
                $(self.digest_column::<$component>(digest);)*
            }
        }

        #[cfg(test)]
        const DIGESTED: &[fn() -> std::any::TypeId] = &[$(std::any::TypeId::of::<$component>),*];
    };
}

columns! {
    Name, Bsdf, Sides, Emission, Textures, Medium, FillsScene, Ball, Transform, MadeOf, Boundary,
    Punctual, Lens, Resolution, Raster, Analyzer, Window, Environment, EmittedStokes,
    Incandescent, Luminaire, Projection,
}

impl World {
    /// A digest of all components of all entities, in 64 hexadecimal digits: worlds that differ in
    /// anything, names included, have others.
    pub(crate) fn digest(&self) -> String {
        let mut digest = Digest(blake3::Hasher::new());
        self.digest_columns(&mut digest);
        // Many meshes may share a geometry.
        let mut seen: HashMap<usize, usize> = HashMap::new();
        for mesh in self.in_order::<&Mesh, _>(|mesh| mesh.0.clone()) {
            let next = seen.len();
            match seen.entry(Arc::as_ptr(&mesh).addr()) {
                Entry::Occupied(first) => digest.say(format_args!("{}", first.get())),
                Entry::Vacant(place) => {
                    place.insert(next);
                    digest.geometry(&mesh);
                }
            }
        }
        digest.0.finalize().to_string()
    }

    /// The components of one type, with their entities.
    fn digest_column<C: Component + Debug>(&self, digest: &mut Digest) {
        digest.say(format_args!("{}", std::any::type_name::<C>()));
        let mut query = self.entities().query::<(&Order, Entity, &C)>();
        let rows: Vec<(&Order, Entity, &C)> = query.iter().collect();
        let orders: Vec<u32> = rows.iter().map(|(order, ..)| order.0).collect();
        for place in places_in_order(&orders) {
            digest.say(format_args!("{:?}", rows[place]));
        }
    }
}

/// A digest in the making.
struct Digest(blake3::Hasher);

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Digest {
    /// Adds text, and that it ends there.
    fn say(&mut self, text: std::fmt::Arguments) {
        let written = self.write_fmt(text).and_then(|()| self.write_char('\0'));
        written.expect("a digest takes all text");
    }

    /// Adds a geometry, which has too many numbers to be said.
    fn geometry(&mut self, geometry: &Geometry) {
        let Geometry { positions, normals, texture_coordinates, triangles, .. } = geometry;
        let Geometry { texture_coordinates_1, colors, tangents, .. } = geometry;
        let lengths = [positions.len(), normals.len(), texture_coordinates.len(), triangles.len()];
        let more = [texture_coordinates_1.len(), colors.len(), tangents.len()];
        self.say(format_args!("{lengths:?}{more:?}"));
        self.0.update(bytemuck::cast_slice(positions));
        self.0.update(bytemuck::cast_slice(normals));
        self.0.update(bytemuck::cast_slice(texture_coordinates));
        self.0.update(bytemuck::cast_slice(texture_coordinates_1));
        self.0.update(bytemuck::cast_slice(colors));
        self.0.update(bytemuck::cast_slice(tangents));
        self.0.update(bytemuck::cast_slice(triangles));
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::super::{Material, Phase};
    use super::*;

    /// A world with every kind of entity.
    fn world() -> World {
        let mut world = World::new("all");
        let wall = world.add_material("wall", Bsdf::diffuse(0.5)).unwrap();
        let lamp = world.add_material("lamp", Material::emitter(1.0)).unwrap();
        let here = Transform::IDENTITY;
        world.add_mesh("box", Geometry::cuboid(-Vec3::ONE, Vec3::ONE), wall, here).unwrap();
        world.add_sphere("ball", 0.5, lamp, DVec3::ZERO).unwrap();
        let sigmas = (Some(0.1.into()), Some(0.2.into()));
        world.set_emitted_stokes(lamp, EmittedStokes::new([1.0, 0.0, 0.0]).unwrap()).unwrap();
        let fog = Medium { sigma_a: sigmas.0, sigma_s: sigmas.1, phase: Phase::isotropic() };
        let medium = world.add_medium("fog", fog).unwrap();
        world.set_scene_medium(medium).unwrap();
        world.add_light("sun", Punctual::directional(1.0), here).unwrap();
        world.set_camera("eye", Lens::pinhole(1.0), here).unwrap();
        world.set_resolution([8, 8]).unwrap();
        world.set_analyzer(Some(Analyzer::RightCircular)).unwrap();
        world.set_environment(0.1).unwrap();
        for (_, camera) in world.in_order::<(&Lens, Entity), _>(|(_, camera)| ((), camera)) {
            world.insert(camera, Window { tan_half_x: 0.5 });
        }
        world
    }

    #[test]
    fn every_component_is_digested() {
        let world = world();
        let mut count = 0;
        for entity in world.entities().iter() {
            for component in entity.component_types() {
                let others = [std::any::TypeId::of::<Order>(), std::any::TypeId::of::<Mesh>()];
                let mut known = DIGESTED.iter().map(|id| id()).chain(others);
                assert!(known.any(|id| id == component), "{:?}", entity.get::<&Name>().unwrap().0);
                count += 1;
            }
        }
        assert!(count > 30, "{count}");
    }

    #[test]
    fn any_change_shows() {
        let first = world().digest();
        assert_eq!(first, world().digest());
        let mut changed = world();
        for lens in changed.entities_mut().query_mut::<&mut Lens>() {
            *lens = Lens::pinhole(1.0 + 1e-6);
        }
        assert_ne!(first, changed.digest());
        let mut changed = world();
        for mesh in changed.entities_mut().query_mut::<&mut Mesh>() {
            Arc::make_mut(&mut mesh.0).positions[0].x += 1e-6;
        }
        assert_ne!(first, changed.digest());
    }
}
