//! The vendor extension: which keys there are, and reading them with errors that name them.
//!
//! glTF has no words for polarization. What is missing goes into `SUNSTONE_polarization`, whose
//! body is also accepted as the object `extras.sunstone` and, key by key, as `extras.sunstone_*`,
//! the way Blender exports custom properties. `scenes/sunstone.schema.json` documents the keys;
//! a test compares it with the tables here. A key that is null is not there, as edits have it, but
//! where nothing is something to state.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::math::{Fault, Range};
use crate::scene::error::SceneError;

/// Name of the extension in glTF files.
pub const EXTENSION: &str = "SUNSTONE_polarization";

/// An object that the extension can describe, and the keys that it may have there.
pub struct Keys {
    /// Name of its definition in the schema.
    pub definition: &'static str,
    /// Keys that are understood.
    pub known: &'static [&'static str],
    /// Keys and values of the design that this version refuses by name.
    pub planned: &'static [&'static str],
}

/// Keys of a material.
pub const MATERIAL: Keys = Keys {
    definition: "material",
    known: &[
        "alpha",
        "alpha_texture",
        "alpha_u",
        "alpha_v",
        "axis_deg",
        "birefringence",
        "blocked",
        "bsdf",
        "bump_scale",
        "bump_texture",
        "coverage",
        "distribution",
        "emission",
        "eta",
        "exterior_ior",
        "extinction_ratio",
        "file",
        "film",
        "first",
        "handedness",
        "incandescent",
        "internal_reflection",
        "ior",
        "k",
        "matrix",
        "metal",
        "multiple_scattering",
        "one_sided",
        "reflectance",
        "reflected",
        "reflected_texture",
        "retardance_deg",
        "roughness",
        "second",
        "specular",
        "stokes",
        "thickness_um",
        "transmittance",
        "transmitted",
        "transmitted_texture",
        "weight",
        "weight_texture",
    ],
    planned: &[],
};
/// Keys of a node.
pub const NODE: Keys = Keys {
    definition: "node",
    known: &["exterior", "interior", "material", "priority", "shape", "sphere_radius"],
    planned: &[],
};
/// Keys of a camera.
pub const CAMERA: Keys = Keys {
    definition: "camera",
    known: &["aperture_radius", "film", "focus_distance"],
    planned: &[],
};
/// Keys of a camera's film.
pub const FILM: Keys = Keys {
    definition: "film",
    known: &["analyzer", "crop", "filter", "filter_radius", "pixel_aspect", "resolution"],
    planned: &[],
};
/// Keys of what stands before a film.
pub const ANALYZER: Keys =
    Keys { definition: "analyzer", known: &["axis_deg", "kind"], planned: &[] };
/// Keys of a punctual light.
pub const LIGHT: Keys = Keys {
    definition: "light",
    known: &["angular_diameter_deg", "emission", "falloff", "ies", "picture", "stokes", "units"],
    planned: &[],
};
/// Keys of a scene, or of the root of the file.
pub const SCENE: Keys =
    Keys { definition: "scene", known: &["environment", "media", "medium"], planned: &[] };
/// Keys of a medium.
pub const MEDIUM: Keys = Keys {
    definition: "medium",
    known: &[
        "depolarization",
        "g",
        "host",
        "milk",
        "name",
        "particles",
        "phase",
        "sigma_a",
        "sigma_s",
        "table",
    ],
    planned: &[],
};
/// Keys of the spheres of one substance in a medium.
pub const PARTICLES: Keys = Keys {
    definition: "particles",
    known: &["distribution", "eta", "k", "name", "volume_fraction"],
    planned: &[],
};
/// Keys of a distribution of radii.
pub const DISTRIBUTION: Keys = Keys {
    definition: "distribution",
    known: &["density", "kind", "mean_um", "of", "radii_um", "radius_um", "range_um", "sd_um"],
    planned: &[],
};
/// Keys of what particles are suspended in.
pub const HOST: Keys = Keys { definition: "host", known: &["eta", "k"], planned: &[] };
/// Keys of milk.
pub const MILK: Keys = Keys {
    definition: "milk",
    known: &["dilution", "fat_percent", "protein_percent"],
    planned: &[],
};
/// Keys of a tabulated phase matrix.
pub const MATRIX: Keys = Keys {
    definition: "phase_matrix",
    known: &["lambda_nm", "m00", "m01", "m11", "m22", "m23", "m33", "theta_deg"],
    planned: &[],
};
/// Keys of the environment.
pub const ENVIRONMENT: Keys = Keys {
    definition: "environment",
    known: &["gradient", "radiance", "rotation", "sky", "stokes", "uri"],
    planned: &[],
};
/// Keys of a clear sky.
pub const CLEAR_SKY: Keys = Keys {
    definition: "clear_sky",
    known: &["max_degree", "sun_direction", "turbidity"],
    planned: &[],
};
/// Keys of a tabulated spectrum.
pub const SPECTRUM: Keys =
    Keys { definition: "spectrum_table", known: &["nm", "value"], planned: &[] };
/// Keys of the real part of an index of refraction.
pub const INDEX: Keys =
    Keys { definition: "index", known: &["cauchy", "nm", "sellmeier", "value"], planned: &[] };
/// Keys of a film on a surface.
pub const THIN_FILM: Keys = Keys {
    definition: "thin_film",
    known: &[
        "eta",
        "k",
        "share",
        "share_texture",
        "thickness_black_nm",
        "thickness_nm",
        "thickness_texture",
    ],
    planned: &[],
};
/// Keys of Sellmeier's formula.
pub const SELLMEIER: Keys =
    Keys { definition: "sellmeier", known: &["b", "c_um2", "range_nm"], planned: &[] };
/// Keys of Cauchy's formula.
pub const CAUCHY: Keys =
    Keys { definition: "cauchy", known: &["a", "b_um2", "c_um4", "range_nm"], planned: &[] };
/// Keys of the spectrum of a lamp.
pub const EMISSION: Keys = Keys {
    definition: "emission",
    known: &["blackbody_k", "illuminant", "lines", "nm", "scale", "shape", "spd", "value"],
    planned: &[],
};

/// Keys of how much of a surface is there.
pub const COVERAGE: Keys =
    Keys { definition: "coverage", known: &["cutoff", "share", "texture"], planned: &[] };
/// Keys of a texture of the extension's: those of glTF.
pub const TEXTURE_INFO: Keys = Keys {
    definition: "texture_info",
    known: &["extensions", "extras", "index", "texCoord"],
    planned: &[],
};
/// Keys of any texture of a material.
pub const TEXTURE: Keys = Keys {
    definition: "texture",
    known: &["channel", "coding", "frame", "transform"],
    planned: &[],
};

/// A mesh can have none.
pub const MESH: Keys = Keys { definition: "mesh", known: &[], planned: &[] };

/// All that have keys: what the schema must define.
pub const ALL: [&Keys; 24] = [
    &MATERIAL,
    &COVERAGE,
    &TEXTURE_INFO,
    &TEXTURE,
    &NODE,
    &CAMERA,
    &FILM,
    &ANALYZER,
    &LIGHT,
    &SCENE,
    &ENVIRONMENT,
    &CLEAR_SKY,
    &MEDIUM,
    &PARTICLES,
    &DISTRIBUTION,
    &HOST,
    &MILK,
    &MATRIX,
    &SPECTRUM,
    &INDEX,
    &SELLMEIER,
    &CAUCHY,
    &THIN_FILM,
    &EMISSION,
];

/// Keys of which null says something: that nothing is there, and not that nobody said it.
const MAY_BE_NOTHING: [&str; 3] = ["exterior", "interior", "medium"];

/// The keys of what stands under a key of an object, if it is an object or a list of these: of a
/// table where a spectrum may stand.
pub fn inner(keys: &Keys, name: &str) -> Option<&'static Keys> {
    match (keys.definition, name) {
        ("camera", "film") => Some(&FILM),
        ("film", "analyzer") => Some(&ANALYZER),
        ("scene", "environment") => Some(&ENVIRONMENT),
        ("environment", "sky") => Some(&CLEAR_SKY),
        ("material", "film") => Some(&THIN_FILM),
        ("material", "coverage") => Some(&COVERAGE),
        ("coverage", "texture")
        | (
            "material",
            "alpha_texture"
            | "bump_texture"
            | "reflected_texture"
            | "transmitted_texture"
            | "weight_texture",
        ) => Some(&TEXTURE_INFO),
        ("medium", "host") => Some(&HOST),
        ("medium", "milk") => Some(&MILK),
        ("medium", "particles") => Some(&PARTICLES),
        ("medium", "table") => Some(&MATRIX),
        ("particles", "distribution") => Some(&DISTRIBUTION),
        ("environment", "radiance") | ("light" | "material", "emission") => Some(&EMISSION),
        ("host" | "material" | "particles" | "thin_film", "eta")
        | ("material", "exterior_ior" | "ior") => Some(&INDEX),
        ("index", "cauchy") => Some(&CAUCHY),
        ("index", "sellmeier") => Some(&SELLMEIER),
        ("environment" | "light" | "material", "stokes")
        | ("host" | "material" | "particles" | "thin_film", "k")
        | (
            "material",
            "birefringence" | "blocked" | "matrix" | "reflectance" | "retardance_deg"
            | "transmittance",
        )
        | ("medium", "g" | "sigma_a" | "sigma_s") => Some(&SPECTRUM),
        _ => None,
    }
}

/// The extension's keys of one object of the file.
pub struct Body<'a> {
    /// The object's name in errors.
    label: String,
    /// What stands before the name of a key that is not there.
    prefix: String,
    /// Value and field name in errors, by key.
    values: BTreeMap<&'a str, (&'a Value, String)>,
}

impl<'a> Body<'a> {
    /// Gathers the keys of a glTF object from its extension and its extras.
    pub fn of(object: &'a Value, label: &str, keys: &Keys) -> Result<Self, SceneError> {
        let prefix = format!("{label}, {EXTENSION}.");
        let mut body = Self { label: label.to_owned(), prefix, values: BTreeMap::new() };
        let extension = &object["extensions"][EXTENSION];
        body.add_object(extension, &format!("{label}, {EXTENSION}"), keys)?;
        let extras = &object["extras"];
        body.add_object(&extras["sunstone"], &format!("{label}, extras.sunstone"), keys)?;
        for (name, value) in extras.as_object().into_iter().flatten() {
            if let Some(key) = name.strip_prefix("sunstone_") {
                body.add(key, value, format!("{label}, extras.{name}"), keys)?;
            }
        }
        Ok(body)
    }

    /// The keys of an object within the extension.
    pub fn nested(object: &'a Value, label: String, keys: &Keys) -> Result<Self, SceneError> {
        let prefix = format!("{label}.");
        let mut body = Self { label: label.clone(), prefix, values: BTreeMap::new() };
        body.add_object(object, &label, keys)?;
        Ok(body)
    }

    fn add_object(&mut self, object: &'a Value, at: &str, keys: &Keys) -> Result<(), SceneError> {
        if object.is_null() {
            return Ok(());
        }
        let Some(map) = object.as_object() else {
            return Err(SceneError::new(at, "is not an object", keys.advice()));
        };
        for (key, value) in map {
            self.add(key, value, format!("{at}.{key}"), keys)?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        key: &'a str,
        value: &'a Value,
        field: String,
        keys: &Keys,
    ) -> Result<(), SceneError> {
        if keys.planned.contains(&key) {
            return Err(SceneError::new(field, "is not supported yet", "remove it"));
        }
        if !keys.known.contains(&key) {
            return Err(SceneError::new(field, "is not a key of the extension", keys.advice()));
        }
        if value.is_null() && !MAY_BE_NOTHING.contains(&key) {
            return Ok(());
        }
        if let Some((other, other_field)) = self.values.get(key)
            && !same(other, value)
        {
            let problem = format!("contradicts {other_field}");
            return Err(SceneError::new(field, problem, "state the value once"));
        }
        self.values.insert(key, (value, field));
        Ok(())
    }

    /// The object's name in errors.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Whether a key is there.
    pub fn has(&self, key: &str) -> bool {
        self.values.contains_key(key)
    }

    /// The keys that are there.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.values.keys().copied()
    }

    /// How errors call a key of this object.
    pub fn field(&self, key: &str) -> String {
        match self.values.get(key) {
            Some((_, field)) => field.clone(),
            None => format!("{}{key}", self.prefix),
        }
    }

    /// Where a fault is in the file: at the key of its field, or the object itself.
    pub fn place(&self, fault: Fault) -> SceneError {
        if fault.field.is_empty() {
            return SceneError::at(&self.label, fault);
        }
        SceneError::at(&self.field(&fault.field), fault.of(""))
    }

    /// A number.
    pub fn number(&self, key: &str) -> Result<Option<f64>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        let Some(number) = value.as_f64() else {
            return Err(SceneError::new(field, "is not a number", String::new()));
        };
        finite(number, field).map(Some)
    }

    /// A whole number that 32 bits hold.
    pub fn integer(&self, key: &str) -> Result<Option<i32>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        match value.as_i64().and_then(|number| i32::try_from(number).ok()) {
            Some(number) => Ok(Some(number)),
            None => {
                let problem = format!("{value} is not a whole number");
                Err(SceneError::new(field, problem, "give one, the higher the more it counts"))
            }
        }
    }

    /// An index into an array of the file.
    pub fn index(&self, key: &str, what: &str, len: usize) -> Result<Option<usize>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        match value.as_u64() {
            Some(index) if index < len as u64 => Ok(Some(index as usize)),
            _ => {
                let problem = format!("{value} is not an index into the file's {len} {what}");
                Err(SceneError::new(field, problem, String::new()))
            }
        }
    }

    /// Objects with keys of their own. Errors call them by their number, and their `name`.
    pub fn objects(&self, key: &str, keys: &Keys) -> Result<Option<Vec<Body<'a>>>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        let Some(array) = value.as_array() else {
            return Err(SceneError::new(field, "is not an array of objects", keys.advice()));
        };
        let object = |(index, value): (usize, &'a Value)| {
            let label = match value["name"].as_str() {
                Some(name) => format!("{field}[{index}] \"{name}\""),
                None => format!("{field}[{index}]"),
            };
            if !value.is_object() {
                return Err(SceneError::new(label, "is not an object", keys.advice()));
            }
            Body::nested(value, label, keys)
        };
        array.iter().enumerate().map(object).collect::<Result<_, _>>().map(Some)
    }

    /// Numbers.
    pub fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        let wrong = || SceneError::new(field, "is not an array of numbers", String::new());
        let number = |value: &Value| finite(value.as_f64().ok_or_else(wrong)?, field);
        let array = value.as_array().ok_or_else(wrong)?;
        array.iter().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Whether a key is there and holds an object.
    pub fn is_object(&self, key: &str) -> bool {
        self.values.get(key).is_some_and(|(value, _)| value.is_object())
    }

    /// The error of a key that has to be there.
    pub fn missing(&self, key: &str, remedy: &str) -> SceneError {
        SceneError::new(self.field(key), "is missing", remedy)
    }

    /// True or false.
    pub fn flag(&self, key: &str) -> Result<Option<bool>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        match value.as_bool() {
            Some(flag) => Ok(Some(flag)),
            None => Err(SceneError::new(field, format!("{value} is neither true nor false"), "")),
        }
    }

    /// A word.
    pub fn word(&self, key: &str) -> Result<Option<&'a str>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        match value.as_str() {
            Some(word) => Ok(Some(word)),
            None => Err(SceneError::new(field, "is not a string", String::new())),
        }
    }

    /// An object with keys of its own.
    pub fn object(&self, key: &str, keys: &Keys) -> Result<Option<Body<'a>>, SceneError> {
        let Some((value, field)) = self.values.get(key) else { return Ok(None) };
        Body::nested(value, field.clone(), keys).map(Some)
    }

    /// Whole numbers; none if anything else stands there.
    pub fn counts(&self, key: &str) -> Option<Vec<u64>> {
        let (value, _) = self.values.get(key)?;
        let counts = value.as_array()?.iter().map(Value::as_u64).collect::<Option<_>>();
        Some(counts.unwrap_or_default())
    }

    /// What stands under a key, and how errors call it.
    pub fn value(&self, key: &str) -> Option<(&'a Value, &str)> {
        self.values.get(key).map(|(value, field)| (*value, field.as_str()))
    }
}

impl Keys {
    fn advice(&self) -> String {
        if self.known.is_empty() {
            return format!("a {} has no keys: use its material or node", self.definition);
        }
        let known = self.known.join(", ");
        let article = if self.definition.starts_with(['a', 'e', 'i']) { "an" } else { "a" };
        let definition = self.definition;
        format!("the keys of {article} {definition} are {known} (see sunstone.schema.json)")
    }
}

/// The number, if it is finite as an `f32` too.
fn finite(number: f64, field: &str) -> Result<f64, SceneError> {
    Range::ANY.check("", number).map_err(|fault| SceneError::at(field, fault))?;
    Ok(number)
}

/// Equality that does not tell 1 from 1.0.
fn same(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}
