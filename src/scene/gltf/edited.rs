//! A scene file after edits that were made one after the other, and what stands in it.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use serde_json::Value;

use super::edit::{Edit, applied, found, refuse_overruled};
use super::extension::{Keys, inner};
use super::places::{KINDS, Kind, Place, at, objects_called, of_extension, places, put};
use crate::math::text::{excerpt, listed, number_of};
use crate::scene::error::SceneError;
use crate::scene::file::{SceneFile, not_edited};
use crate::scene::view::View;
use crate::scene::world::World;

/// Most characters of a name in errors.
const NAME: usize = 60;
/// What the keys of the extension mean.
const SCHEMA: &str = include_str!("../../../scenes/sunstone.schema.json");

/// What glTF says of its own keys that are not there. What is not here has no default.
const DEFAULTS: [(&str, &str, &str); 23] = [
    ("cameras", "perspective.aspectRatio", "that of the film"),
    ("lights", "color", "[1, 1, 1]"),
    ("lights", "intensity", "1"),
    ("lights", "spot.innerConeAngle", "0"),
    ("lights", "spot.outerConeAngle", "pi / 4"),
    ("materials", "doubleSided", "false"),
    ("materials", "emissiveFactor", "[0, 0, 0]"),
    ("materials", "extensions.KHR_materials_emissive_strength.emissiveStrength", "1"),
    ("materials", "extensions.KHR_materials_ior.ior", "1.5"),
    ("materials", "extensions.KHR_materials_specular.specularFactor", "1"),
    ("materials", "extensions.KHR_materials_transmission.transmissionFactor", "0"),
    ("materials", "extensions.KHR_materials_volume.attenuationColor", "[1, 1, 1]"),
    ("materials", "extensions.KHR_materials_volume.attenuationDistance", "infinite"),
    ("materials", "extensions.KHR_materials_volume.thicknessFactor", "0"),
    ("materials", "pbrMetallicRoughness.baseColorFactor", "[1, 1, 1, 1]"),
    ("materials", "pbrMetallicRoughness.metallicFactor", "1"),
    ("materials", "pbrMetallicRoughness.roughnessFactor", "1"),
    ("nodes", "matrix", "that of translation, rotation and scale"),
    ("nodes", "mesh", "none"),
    ("nodes", "rotation", "[0, 0, 0, 1]"),
    ("nodes", "scale", "[1, 1, 1]"),
    ("nodes", "translation", "[0, 0, 0]"),
    ("nodes", "camera", "none"),
];

/// A scene file that is edited again and again: edits build on those before them, and of one place
/// the last counts. It is cheap to clone, and an edit makes another one.
///
/// ```
/// use std::sync::Arc;
/// use sunstone::{Edit, EditedFile, SceneFile, View};
///
/// let file = Arc::new(SceneFile::read("scenes/cornell.gltf".as_ref(), false)?);
/// let first = EditedFile::new(file).edit(vec![Edit::new("materials/white/reflectance", 0.2)])?;
/// let second = first.edit(vec![Edit::new("materials/white/reflectance", 0.3)])?;
/// assert_eq!(first.value("materials/white/reflectance")?, Some(0.2.into()));
/// assert_eq!(second.edits(), [Edit::new("materials/white/reflectance", 0.3)]);
/// let world = second.world(&View::default())?;
/// # assert!(world.find("white").is_some());
/// # Ok::<(), sunstone::SceneError>(())
/// ```
#[derive(Clone)]
pub struct EditedFile {
    file: Arc<SceneFile>,
    /// Those that count; no two are of one place.
    edits: Arc<Vec<Edit>>,
    /// The JSON with these.
    value: Arc<Value>,
}

impl EditedFile {
    /// The file as it stands.
    pub fn new(file: Arc<SceneFile>) -> Self {
        let value = Arc::new(json_of(&file).clone());
        Self { file, edits: Arc::default(), value }
    }

    /// Makes further edits, all or none. They are checked together with those before them, after
    /// the last; null takes away what is stated.
    ///
    /// # Errors
    /// When one is about nothing that is there, or two are of one place, or one has no effect
    /// beside the others.
    pub fn edit(&self, edits: Vec<Edit>) -> Result<Self, SceneError> {
        if self.file.gltf().is_none()
            && let Some(edit) = edits.first()
        {
            return Err(self.told(not_edited(&edit.target)));
        }
        let mut kept = (*self.edits).clone();
        for (places, edit) in found(&self.value, &edits).map_err(|error| self.told(error))? {
            if !self.add_within(&mut kept, edit, &places)? {
                self.drop_within(&mut kept, &places)?;
                kept.push(edit.clone());
            }
        }
        self.with(kept)
    }

    /// Takes back what was edited at places and further inwards, or of whole objects, `KIND/NAME`:
    /// what the file says holds again. None if nothing was.
    ///
    /// # Errors
    /// When there is no such place, or what is left does not go together.
    pub fn take_back(&self, targets: &[impl AsRef<str>]) -> Result<Option<Self>, SceneError> {
        let mut kept = (*self.edits).clone();
        for target in targets.iter().map(AsRef::as_ref) {
            let places = match (self.places(target), objects_called(&self.value, target)) {
                (Ok(places), _) => places,
                (Err(_), Some(objects)) => objects,
                (Err(error), None) => return Err(error),
            };
            self.drop_within(&mut kept, &places)?;
        }
        if kept.len() == self.edits.len() {
            return Ok(None);
        }
        self.with(kept).map(Some)
    }

    /// The same file with these edits, which are of a place each.
    fn with(&self, mut kept: Vec<Edit>) -> Result<Self, SceneError> {
        let original = json_of(&self.file);
        // What the file does not state need not be taken away.
        let is_stated = |edit: &Edit| {
            let places = places(original, &edit.target);
            places.map_or(true, |places| places.iter().any(|place| at(original, place).is_some()))
        };
        kept.retain(|edit| !edit.value.is_null() || is_stated(edit));
        let value = applied(original, &kept).map_err(|error| self.told(error))?;
        Ok(Self { file: Arc::clone(&self.file), edits: Arc::new(kept), value: Arc::new(value) })
    }

    /// The edits that count, in no order: each is of a place of its own.
    pub fn edits(&self) -> &[Edit] {
        &self.edits
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The value of a place, by the names of edits; none if the file does not state it.
    ///
    /// # Errors
    /// When there is no such place.
    pub fn value(&self, target: &str) -> Result<Option<Value>, SceneError> {
        let places = self.places(target)?;
        for place in &places {
            let refuse = |(problem, remedy)| SceneError::new(target, problem, remedy);
            refuse_overruled(&self.value, place).map_err(refuse).map_err(|it| self.told(it))?;
        }
        Ok(places.iter().find_map(|place| at(&self.value, place)).cloned())
    }

    /// In words, what holds where the file does not state the value of a place, if anything does.
    pub fn default_of(&self, target: &str) -> Option<String> {
        let (kind, rest) = target.split_once('/')?;
        let (_, path) = rest.rsplit_once('/')?;
        let kind = KINDS.iter().find(|known| known.name == kind)?;
        let words: Vec<&str> = path.split('.').collect();
        if let Some((name, rest)) = of_extension(kind, &words) {
            return default_in_schema(kind.keys, name, rest);
        }
        let is_it = |(of, key, _): &&(&str, &str, &str)| (*of, *key) == (kind.name, path);
        DEFAULTS.iter().find(is_it).map(|(.., words)| (*words).to_owned())
    }

    /// The objects that a name may mean, as `KIND/NAME`: all of this name, or the one that it is
    /// itself.
    ///
    /// # Errors
    /// When there are none.
    pub fn objects(&self, name: &str) -> Result<Vec<String>, SceneError> {
        if self.file.gltf().is_none() {
            return Err(self.told(not_edited(name)));
        }
        let is_called = |kind: &Kind, name: &str| {
            let objects = self.list(kind);
            let index = number_of(name);
            objects.iter().any(|object| object["name"].as_str() == Some(name))
                || index.is_some_and(|index| index < objects.len())
        };
        if let Some((of, inner)) = name.split_once('/')
            && KINDS.iter().any(|kind| kind.name == of && is_called(kind, inner))
        {
            return Ok(vec![name.to_owned()]);
        }
        let kinds = KINDS.iter().filter(|kind| is_called(kind, name));
        let found: Vec<String> = kinds.map(|kind| format!("{}/{name}", kind.name)).collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let names = KINDS.iter().flat_map(|kind| {
            let named = self.list(kind).iter().filter_map(|object| object["name"].as_str());
            named.map(|name| format!("{}/{}", kind.name, excerpt(name, NAME)))
        });
        let remedy = format!("write KIND/NAME/KEY, or one of {}", listed(names));
        let error = SceneError::new(excerpt(name, NAME), "nothing is called so", remedy);
        Err(error.in_file(self.path()))
    }

    /// The objects of a kind.
    fn list(&self, kind: &Kind) -> &[Value] {
        let list = (kind.lists)(&self.value).into_iter().next();
        let list = list.and_then(|list| at(&self.value, &list)?.as_array());
        list.map_or(&[], Vec::as_slice)
    }

    /// The default scene after the edits, as it is seen.
    ///
    /// # Errors
    /// As [`SceneFile::world`].
    pub fn world(&self, view: &View) -> Result<World, SceneError> {
        self.file.world(view, &self.edits)
    }

    fn places(&self, target: &str) -> Result<Vec<Place>, SceneError> {
        if self.file.gltf().is_none() {
            return Err(self.told(not_edited(target)));
        }
        places(&self.value, target).map_err(|error| self.told(error))
    }

    fn told(&self, error: SceneError) -> SceneError {
        error.in_file(self.path())
    }

    /// Makes an edit within the values of earlier ones, if it is of a place in these.
    fn add_within(
        &self,
        kept: &mut [Edit],
        edit: &Edit,
        new: &[Place],
    ) -> Result<bool, SceneError> {
        let mut is_within = false;
        for old in kept {
            let places = self.places(&old.target)?;
            let inner = new.iter().find_map(|new| {
                let is_around = |old: &&Place| old.len() < new.len() && new.starts_with(old);
                Some(&new[places.iter().find(is_around)?.len()..])
            });
            if let Some(inner) = inner {
                put(&mut old.value, inner, &edit.value);
                is_within = true;
            }
        }
        Ok(is_within)
    }

    /// Drops the edits of places and of what is in them.
    fn drop_within(&self, kept: &mut Vec<Edit>, outer: &[Place]) -> Result<(), SceneError> {
        let mut dropped = Vec::with_capacity(kept.len());
        for old in kept.iter() {
            let places = self.places(&old.target)?;
            dropped.push(places.iter().any(|old| outer.iter().any(|outer| old.starts_with(outer))));
        }
        let mut dropped = dropped.into_iter();
        kept.retain(|_| !dropped.next().unwrap_or(false));
        Ok(())
    }
}

/// The JSON of a file that is edited by name; nothing of one that is not.
fn json_of(file: &SceneFile) -> &Value {
    file.gltf().map_or(&Value::Null, |file| &file.document.value)
}

/// The keys that edits of a kind of objects may have; none of an unknown kind.
pub fn keys_of_kind(kind: &str) -> impl Iterator<Item = &'static str> {
    let kind = KINDS.iter().find(|known| known.name == kind);
    let keys = kind.into_iter().flat_map(|kind| kind.keys.known.iter().chain(kind.own));
    keys.copied().filter(|key| *key != "name")
}

/// What the schema says of a key of the extension that is not there.
fn default_in_schema(keys: &'static Keys, name: &str, rest: &[&str]) -> Option<String> {
    static DEFINITIONS: LazyLock<Value> = LazyLock::new(|| {
        // A test reads it.
        let schema: Value = serde_json::from_str(SCHEMA).unwrap_or_default();
        schema["$defs"].clone()
    });
    // Items of a list have the keys of the list.
    let mut words = rest.iter().filter(|word| word.parse::<usize>().is_err());
    let Some(word) = words.next() else {
        let property = &DEFINITIONS[keys.definition]["properties"][name];
        let described = property["description"].as_str().and_then(|text| {
            let (_, words) = text.split_once("Default: ")?;
            Some(excerpt(words.trim_end_matches('.'), NAME))
        });
        let stated = (!property["default"].is_null()).then(|| property["default"].to_string());
        return described.or(stated);
    };
    let within = inner(keys, name)?;
    let rest: Vec<&str> = words.copied().collect();
    default_in_schema(within, word, &rest)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::scene::load_from_memory;

    fn lab() -> EditedFile {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tank.gltf"));
        let file = SceneFile::read(path, false).unwrap_or_else(|error| panic!("{error}"));
        EditedFile::new(Arc::new(file))
    }

    fn edited(file: &EditedFile, edits: &[(&str, Value)]) -> EditedFile {
        let edits = edits.iter().map(|(target, value)| Edit::new(*target, value.clone())).collect();
        file.edit(edits).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The edits alone make the same of the file as all that was done.
    fn check(file: &EditedFile) {
        let again = EditedFile::new(Arc::clone(&file.file)).edit(file.edits().to_vec()).unwrap();
        assert_eq!(again.value, file.value);
    }

    #[test]
    fn of_one_place_the_last_counts() {
        let lab = lab();
        let milk = json!({"fat_percent": 1.0, "protein_percent": 3.0, "dilution": 0.5});
        let whole = edited(&lab, &[("media/#0/milk", milk.clone())]);
        let within = edited(&whole, &[("media/#0/milk.dilution", json!(0.25))]);
        let mut expected = milk.clone();
        expected["dilution"] = json!(0.25);
        assert_eq!(within.edits(), [Edit::new("media/#0/milk", expected)]);
        check(&within);
        let again = edited(&within, &[("media/#0/milk", milk.clone())]);
        assert_eq!(again.edits(), whole.edits());
        let inner = edited(&lab, &[("media/#0/milk.dilution", json!(0.1))]);
        let outer = edited(&inner, &[("media/#0/milk", milk)]);
        assert_eq!(outer.edits(), whole.edits());
        let mut turned = lab.clone();
        for index in 0..100 {
            turned = edited(&turned, &[("materials/#0/doubleSided", json!(index % 2 == 0))]);
        }
        assert_eq!(turned.edits().len(), 1);
        check(&turned);
    }

    #[test]
    fn what_is_taken_back_is_that_of_the_file() {
        let lab = lab();
        let before = lab.value("media/#0/milk.dilution").unwrap();
        let other = edited(&lab, &[("media/#0/milk.dilution", json!(0.1))]);
        assert_eq!(other.value("media/#0/milk.dilution").unwrap(), Some(json!(0.1)));
        let back = other.take_back(&["media/#0/milk"]).unwrap().unwrap();
        assert!(back.edits().is_empty());
        assert_eq!(back.value("media/#0/milk.dilution").unwrap(), before);
        assert!(back.take_back(&["media/#0/milk"]).unwrap().is_none());
        assert!(back.take_back(&["media/snow/milk"]).is_err());
    }

    #[test]
    fn what_goes_together_is_swapped_and_taken_back_at_once() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.gltf"));
        let file = SceneFile::read(path, false).unwrap_or_else(|error| panic!("{error}"));
        let lab = EditedFile::new(Arc::new(file));
        let [metal, eta, k] = ["metal", "eta", "k"].map(|key| format!("materials/gold/{key}"));
        let swap = [(&*metal, Value::Null), (&*eta, json!(0.2)), (&*k, json!(3.9))];
        let own = edited(&lab, &swap);
        check(&own);
        assert!(own.world(&View::default()).is_ok());
        assert_eq!((own.value(&metal).unwrap(), own.edits().len()), (None, 3));
        // One of them is told when the scene is read.
        let half = own.take_back(&[&eta]).unwrap().unwrap();
        assert!(half.world(&View::default()).is_err());
        for targets in [vec![&*metal, &*eta, &*k], vec!["materials/gold"]] {
            let back = own.take_back(&targets).unwrap().unwrap();
            assert!(back.edits().is_empty() && back.world(&View::default()).is_ok());
        }
        let other = [(&*metal, json!("Cu")), (&*eta, Value::Null), (&*k, Value::Null)];
        let back = edited(&own, &other);
        assert_eq!(back.edits(), [Edit::new(&*metal, "Cu")]);
        assert!(back.world(&View::default()).is_ok());
        // A key that was put into what was taken away.
        let film = "cameras/camera/film";
        let film = edited(&lab, &[(film, json!({"resolution": [8, 8]}))]);
        let none = edited(&film, &[("cameras/camera/film.resolution", Value::Null)]);
        let again = edited(&none, &[("cameras/camera/film.resolution", json!([9, 9]))]);
        for file in [&film, &none, &again] {
            check(file);
        }
        assert!(again.world(&View::default()).is_ok());
    }

    #[test]
    fn all_keys_are_documented() {
        let lab = lab();
        let default = |target: &str| lab.default_of(target);
        assert_eq!(default("materials/x/axis_deg").unwrap(), "0");
        assert_eq!(default("materials/x/ior").unwrap(), "KHR_materials_ior, else 1.5");
        assert_eq!(default("nodes/a/b/scale").unwrap(), "[1, 1, 1]");
        assert_eq!(default("media/x/particles.0.k").unwrap(), "0");
        assert_eq!(default("cameras/x/film.analyzer.axis_deg").unwrap(), "0");
        assert_eq!(default("materials/x/bsdf"), None);
        for kind in &KINDS {
            assert!(keys_of_kind(kind.name).count() >= kind.own.len());
        }
        for (kind, key, _) in DEFAULTS {
            assert!(keys_of_kind(kind).any(|known| known == key), "{kind}/{key}");
        }
    }

    #[test]
    fn names_may_be_of_several_objects() {
        let text = r#"{"asset": {"version": "2.0"}, "scenes": [{}], "scene": 0,
            "materials": [{"name": "a"}, {"name": "a/b"}], "nodes": [{"name": "a"}]}"#;
        let path = Path::new("names.gltf");
        assert!(load_from_memory(path, text.as_bytes()).is_err(), "there is no camera");
        let file = super::super::GltfFile::from_memory(path, text.as_bytes());
        let file = SceneFile::from(file.unwrap_or_else(|error| panic!("{error}")));
        let file = EditedFile::new(Arc::new(file));
        assert_eq!(file.objects("a").unwrap(), ["materials/a", "nodes/a"]);
        assert_eq!(file.objects("materials/a").unwrap(), ["materials/a"]);
        assert_eq!(file.objects("a/b").unwrap(), ["materials/a/b"]);
        assert_eq!(file.objects("#1").unwrap(), ["materials/#1"]);
        let error = file.objects("snow").unwrap_err().to_string();
        for words in ["names.gltf: snow: nothing is called so", "materials/a/b, nodes/a"] {
            assert!(error.contains(words), "{error}");
        }
        let error = file.edit(vec![Edit::new("materials/snow/ior", 1.0)]).map(|_| ()).unwrap_err();
        assert!(error.to_string().starts_with("names.gltf: materials/snow/ior"), "{error}");
    }
}
