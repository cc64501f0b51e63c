//! The scene as the user describes it: entities with components in a hecs world.
//!
//! | entity | components |
//! |---|---|
//! | material | [`Order`], [`Name`], [`Bsdf`], [`Sides`], [`Emission`] if it emits, |
//! | | [`Incandescent`] if it does by its heat, [`EmittedStokes`] if that is polarized,|
//! | | [`Textures`] if any of it differs from place to |
//! | | place |
//! | medium | [`Order`], [`Name`], [`Medium`], [`FillsScene`] if it does |
//! | part of a mesh instance | those of all shapes, [`Mesh`] |
//! | sphere | those of all shapes, [`Ball`] |
//! | all shapes | [`Order`], [`Name`], [`Transform`], [`MadeOf`], [`Boundary`] |
//! | punctual light | [`Order`], [`Name`], [`Transform`], [`Punctual`], [`Luminaire`] if it is |
//! | | measured, [`Projection`] if it throws a picture, |
//! | | [`EmittedStokes`] if its light is polarized |
//! | camera | [`Order`], [`Name`], [`Transform`], [`Lens`], [`Resolution`] if it asks for one, |
//! | | [`Raster`] if its pixels are unlike others, |
//! | | [`Analyzer`](crate::Analyzer) if it has one, [`Window`] if it has to show so much |
//! | environment | [`Order`], [`Name`], [`Environment`], [`EmittedStokes`] likewise |
//!
//! Each component knows what is wrong with it. Readers of files parse and add with the functions
//! of `builder`, as programs do, and these check what they add; `check` looks at the whole again
//! before it is baked, as a program may have edited it. `bake` adds what depends on the wavelengths
//! and on world space.

mod asked;
mod blend;
mod builder;
mod camera;
mod check;
mod clear_sky;
mod describe;
mod digest;
mod emitted;
mod frame;
mod grain;
mod incandescent;
mod layers;
mod light;
mod material;
mod measured;
mod medium;
mod mesh;
mod parameter;
mod particles;
mod pattern;
mod phase_matrix;
mod photometry;
mod plastic;
mod polish;
mod relief;
mod sampled;
mod shape;
mod sheet;
mod texture;
mod textures;
mod thin_film;
mod transform;

use std::collections::HashMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::Weak;

use hecs::Entity;

pub use self::asked::{Asked, Walk};
pub use self::blend::BLEND_DEPTH;
pub(in crate::scene) use self::camera::Film;
pub use self::camera::{Lens, Raster, Resolution};
pub use self::clear_sky::ClearSky;
pub use self::emitted::EmittedStokes;
pub use self::frame::{PutIn, Window};
pub(super) use self::frame::{SKY, SKY_GRADIENT};
pub use self::grain::{Along, Grain};
pub use self::incandescent::Incandescent;
pub(super) use self::incandescent::share as incandescent_share;
pub use self::layers::Layers;
pub use self::light::{
    Backdrop, BackdropSource, Environment, Falloff, Luminaire, Projection, Punctual, PunctualKind,
    SUN_DIAMETER,
};
pub(crate) use self::material::tabulated;
pub use self::material::{Bsdf, Emission, Material, Passage, Sides, SurfaceModel};
pub use self::measured::MeasuredTable;
pub(super) use self::medium::MEDIA_MAX;
pub use self::medium::{FillsScene, Medium, Phase};
pub use self::mesh::{Geometry, Mesh};
pub use self::parameter::Parameter;
pub use self::particles::{Component, Spheres};
pub use self::phase_matrix::TabulatedMatrix;
pub(super) use self::phase_matrix::{COLUMNS, check_wavelengths};
pub use self::photometry::Photometry;
pub use self::plastic::{Coat, InternalReflection};
pub use self::relief::{Relief, ReliefFrame, ReliefOf};
pub use self::shape::{Ball, Boundary, Filling, MadeOf, Skin};
pub use self::sheet::{Action, Delay, Grid, Hand};
pub(super) use self::texture::half_hash;
pub use self::texture::{Coverage, Filter, Paint, Picture, Reads, Taps, Texture, Wrap};
pub use self::textures::{Stain, Textures};
pub use self::thin_film::ThinFilm;
pub use self::transform::Transform;

/// A scene: made in code, or read from a file, and edited.
pub struct World {
    entities: hecs::World,
    pub(super) name: String,
    pub(super) file: PathBuf,
    pub(super) files: Vec<PathBuf>,
    pub(super) checksums: Vec<u128>,
    pub(super) warnings: Vec<String>,
    put_in: Vec<PutIn>,
    pub(super) asked: Asked,
    /// The [`Order`] of the last entity.
    order: u32,
    /// The geometries that have been checked, by address. Nobody can change them any more, as
    /// who wants a shared value with weak references for himself is given a copy, and no other
    /// will stand at the address, which they keep.
    checked: HashMap<usize, Weak<Geometry>>,
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.entities.len();
        write!(f, "World {:?} from {:?} of {count} entities", self.name, self.file)
    }
}

impl World {
    /// The entities; see the module's table for their components.
    pub fn entities(&self) -> &hecs::World {
        &self.entities
    }

    /// The entities, to be edited. Whatever is done to them is checked before the scene is baked:
    /// see [`World::check`].
    pub fn entities_mut(&mut self) -> &mut hecs::World {
        &mut self.entities
    }

    /// The first entity of a name: the whole of its [`Name`], or else what stands in that in
    /// quotes, which is what the file or the program calls it.
    pub fn find(&self, name: &str) -> Option<Entity> {
        let quoted = [format!("\"{name}\""), format!("`{name}`")];
        let found = self.in_order::<(Entity, &Name), _>(|(entity, Name(whole))| {
            let is_part = || quoted.iter().any(|part| whole.contains(part));
            (
                if whole == name {
                    0
                } else if is_part() {
                    1
                } else {
                    2
                },
                entity,
            )
        });
        let best = found.into_iter().min_by_key(|(rank, _)| *rank)?;
        (best.0 < 2).then_some(best.1)
    }

    /// The scene's own name, or the file's if it has none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The files that the scene was read from: itself, its buffers and tables. None for a world
    /// that was made in code.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// What tells whether the files still hold what was read of them: half the BLAKE3 of each.
    pub fn checksums(&self) -> &[u128] {
        &self.checksums
    }

    /// What the scene asks for and the renderer ignores, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// How the scene asks to be rendered where nothing else is said; a program's asks for nothing.
    pub fn asked(&self) -> &Asked {
        &self.asked
    }

    /// The names of what becomes the surfaces of the tables, in their order.
    pub(crate) fn surface_names(&self) -> Vec<String> {
        let parts = self.in_order::<(&Name, &Mesh), _>(|(name, _)| name.0.clone());
        let balls = self.in_order::<(&Name, &Ball), _>(|(name, _)| name.0.clone());
        [parts, balls].concat()
    }

    /// What their file calls the materials, and the shapes in the order of surfaces.
    pub(crate) fn own_names(&self) -> [Vec<String>; 2] {
        let own = |name: &Name| name.own().to_owned();
        let materials = self.in_order::<(&Name, &Bsdf), _>(|(name, _)| own(name));
        let parts = self.in_order::<(&Name, &Mesh), _>(|(name, _)| own(name));
        let balls = self.in_order::<(&Name, &Ball), _>(|(name, _)| own(name));
        [materials, [parts, balls].concat()]
    }

    /// The names of the media, in their order, and whether particles say their coefficients.
    pub(crate) fn media_names(&self) -> Vec<(String, bool)> {
        self.in_order::<(&Name, &Medium), _>(|(name, medium)| {
            (name.0.clone(), medium.sigma_a.is_none() || medium.sigma_s.is_none())
        })
    }

    /// The names of the lights that have a place and shine, in their order.
    pub(crate) fn lamp_names(&self) -> Vec<String> {
        let lamps = self.in_order::<(&Name, &Punctual), _>(|(name, light)| {
            let shines = light.intensity.values().iter().any(|value| *value > 0.0);
            let has_place = match light.kind {
                PunctualKind::Point | PunctualKind::Spot { .. } => true,
                PunctualKind::Directional | PunctualKind::Sun { .. } => false,
            };
            (shines && has_place).then(|| name.0.clone())
        });
        lamps.into_iter().flatten().collect()
    }

    /// Whether any surface refracts light of other wavelengths in other ways.
    pub(crate) fn disperses(&self) -> bool {
        self.entities.query::<&Bsdf>().iter().any(Bsdf::disperses)
    }

    /// Entities that match a query, in their order, each turned into what `f` makes of it.
    pub(super) fn in_order<Q: hecs::Query, T>(
        &self,
        f: impl for<'a> Fn(Q::Item<'a>) -> T,
    ) -> Vec<T> {
        let mut query = self.entities.query::<(&Order, Q)>();
        let found = query.iter().map(|(order, components)| (order.0, f(components)));
        let (orders, mut rows): (Vec<u32>, Vec<Option<T>>) =
            found.map(|(order, row)| (order, Some(row))).unzip();
        // Not the rows themselves, for whose types the program would hold a sort each.
        let places = places_in_order(&orders);
        places.into_iter().filter_map(|place| rows[place].take()).collect()
    }
}

/// The places of numbers, from the lowest on; of the same, the first before.
fn places_in_order(numbers: &[u32]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by_key(|place| numbers[*place]);
    places
}

/// Position in the file, or in the order of what was added: what makes the order of all tables a
/// function of the scene alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order(pub u32);

/// How errors and reports call the entity: its kind, with its index and name in a file as in
/// ``material 3 "glass"``, or as a program named it, as in ``material `glass` ``.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name(pub String);

impl Name {
    /// What is in quotes in it, which is what its file calls the thing, or else the whole.
    pub(crate) fn own(&self) -> &str {
        let quoted = |quote: char| {
            let (_, rest) = self.0.split_once(quote)?;
            rest.split_once(quote).map(|(inner, _)| inner)
        };
        quoted('"').or_else(|| quoted('`')).unwrap_or(&self.0)
    }
}
