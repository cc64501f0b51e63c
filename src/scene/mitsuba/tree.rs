//! The objects of a file with their properties, after all that is text alone: parameters, includes,
//! aliases and references.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::math::text::{excerpt, listed};
use crate::scene::error::SceneError;

/// Most characters of a name that an error quotes.
pub const NAME: usize = 60;

/// What the elements of objects are called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tag {
    Bsdf,
    Emitter,
    Film,
    Filter,
    Integrator,
    Medium,
    Phase,
    Sampler,
    Scene,
    Sensor,
    Shape,
    /// A texture, or a spectrum with a type.
    Texture,
    Volume,
}

impl Tag {
    /// All with the names of their elements. A spectrum is a texture only if it has a type.
    const ALL: [(&str, Self); 14] = [
        ("bsdf", Self::Bsdf),
        ("emitter", Self::Emitter),
        ("film", Self::Film),
        ("rfilter", Self::Filter),
        ("integrator", Self::Integrator),
        ("medium", Self::Medium),
        ("phase", Self::Phase),
        ("sampler", Self::Sampler),
        ("scene", Self::Scene),
        ("sensor", Self::Sensor),
        ("shape", Self::Shape),
        ("texture", Self::Texture),
        ("volume", Self::Volume),
        ("spectrum", Self::Texture),
    ];

    /// The tag of an element, if it is that of an object.
    pub fn of(element: &str) -> Option<Self> {
        Self::ALL.iter().find(|(name, _)| *name == element).map(|(_, tag)| *tag)
    }

    /// The name of its element.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, tag)| *tag == self).map_or("", |(name, _)| name)
    }
}

/// Where something stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spot {
    /// The included file; empty in the scene's own.
    pub file: Arc<str>,
    /// Counted from 1.
    pub line: u32,
}

impl std::fmt::Display for Spot {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let separator = if self.file.is_empty() { "" } else { ", " };
        write!(f, "{}{separator}line {}", self.file, self.line)
    }
}

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Float(f64),
    Integer(i64),
    Boolean(bool),
    Text(String),
    /// A vector or a point.
    Vector(DVec3),
    Rgb([f64; 3]),
    Spectrum(Curve),
    Transform(DAffine3),
}

/// A spectrum as it is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// The same at all wavelengths.
    Uniform(f64),
    /// Wavelengths in nanometers and values.
    Table(Vec<[f64; 2]>),
}

impl Value {
    /// What it is called.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Float(_) => "float",
            Self::Integer(_) => "integer",
            Self::Boolean(_) => "boolean",
            Self::Text(_) => "string",
            Self::Vector(_) => "vector",
            Self::Rgb(_) => "rgb",
            Self::Spectrum(_) => "spectrum",
            Self::Transform(_) => "transform",
        }
    }
}

/// A value with its name.
#[derive(Clone, Debug)]
pub struct Property {
    pub name: String,
    pub spot: Spot,
    pub value: Value,
}

/// An object within another.
#[derive(Clone, Debug)]
pub struct Child {
    /// Empty if it has none.
    pub name: String,
    pub spot: Spot,
    pub target: Target,
}

/// Which object is meant.
#[derive(Clone, Debug)]
pub enum Target {
    /// By its number.
    Object(usize),
    /// By its id, until references are resolved.
    Id(String),
}

/// An object, as `<bsdf type="diffuse" id="white">`.
#[derive(Clone, Debug)]
pub struct Object {
    pub tag: Tag,
    /// The type.
    pub plugin: String,
    /// Empty if it has none.
    pub id: String,
    pub spot: Spot,
    pub properties: Vec<Property>,
    pub children: Vec<Child>,
}

impl Object {
    /// How errors and reports call it: `line 12, bsdf "white" (diffuse)`.
    pub fn label(&self) -> String {
        let id = match self.id.as_str() {
            "" => String::new(),
            id => format!(" \"{}\"", excerpt(id, NAME)),
        };
        let plugin = excerpt(&self.plugin, NAME);
        format!("{}, {}{id} ({plugin})", self.spot, self.tag.name())
    }
}

/// All objects. The first is the scene.
#[derive(Debug, Default)]
pub struct Tree {
    pub objects: Vec<Object>,
    /// Numbers of objects by id.
    pub ids: BTreeMap<String, usize>,
}

impl Tree {
    /// Resolves all references.
    pub fn resolve(&mut self) -> Vec<SceneError> {
        let mut errors = Vec::new();
        for index in 0..self.objects.len() {
            for child in 0..self.objects[index].children.len() {
                let Child { spot, target, .. } = &self.objects[index].children[child];
                let Target::Id(id) = target else { continue };
                match self.ids.get(id) {
                    Some(object) => {
                        self.objects[index].children[child].target = Target::Object(*object);
                    }
                    None => {
                        let place = format!("{spot}, ref");
                        let problem = format!("no object has the id `{}`", excerpt(id, NAME));
                        let known = match self.ids.is_empty() {
                            true => "the scene has no ids".to_owned(),
                            false => format!("the ids are {}", listed(self.ids.keys())),
                        };
                        errors.push(SceneError::new(place, problem, known));
                    }
                }
            }
        }
        if errors.is_empty() { self.cycle().into_iter().collect() } else { errors }
    }

    /// An object that is within itself, if there is one.
    fn cycle(&self) -> Option<SceneError> {
        const NEW: u8 = 0;
        const OPEN: u8 = 1;
        const DONE: u8 = 2;
        let mut states = vec![NEW; self.objects.len()];
        for start in 0..self.objects.len() {
            if states[start] != NEW {
                continue;
            }
            // Objects on the way down, each with the number of its next child.
            let mut stack = vec![(start, 0)];
            states[start] = OPEN;
            while let Some((index, next)) = stack.last_mut() {
                let object = &self.objects[*index];
                let Some(child) = object.children.get(*next) else {
                    states[*index] = DONE;
                    stack.pop();
                    continue;
                };
                *next += 1;
                let Target::Object(inner) = child.target else { continue };
                match states[inner] {
                    OPEN => {
                        let remedy = "no object can hold itself";
                        return Some(SceneError::new(object.label(), "is part of itself", remedy));
                    }
                    NEW => {
                        states[inner] = OPEN;
                        stack.push((inner, 0));
                    }
                    _ => {}
                }
            }
        }
        None
    }
}
