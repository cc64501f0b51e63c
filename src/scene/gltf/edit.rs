//! Edits of a scene file by name, before it is read: `KIND/NAME/KEY` and a value, or null to take
//! away what stands there.
//!
//! The first and the last slash separate, so names may hold anything. `#3` in place of a name is
//! the object of that index, counted from zero as in the file. A key is one of the extension's, set
//! wherever it stands (or is put into `SUNSTONE_polarization`), or one of glTF's own, which starts
//! at the object; dots lead inwards, into lists by index.
//!
//! Edits that are made at once are all made before any of them is checked.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::document;
use super::places::{Place, Step, Wrong, at, forms, places, put};
use crate::math::text::excerpt;
use crate::scene::error::{Findings, SceneError};
use crate::scene::file::is_of_mitsuba;
use crate::scene::mitsuba::MitsubaFile;

/// Most characters of a name in errors.
const NAME: usize = 60;
/// Arrays of a file that no edit is about.
const UNEDITED: [&str; 7] =
    ["accessors", "animations", "bufferViews", "buffers", "images", "meshes", "skins"];

/// A value in place of that of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Which: `materials/analyzer/axis_deg`, `media/milk/milk.dilution`, `nodes/#3/translation`.
    pub target: String,
    /// What instead, as in the file; null if nothing is to be stated.
    pub value: Value,
}

impl Edit {
    /// An edit.
    pub fn new(target: impl Into<String>, value: impl Into<Value>) -> Self {
        Self { target: target.into(), value: value.into() }
    }

    /// One that takes away what is stated, so that the default holds, or a key that excludes
    /// another.
    ///
    /// ```
    /// use sunstone::{Edit, SceneFile, View};
    ///
    /// // A metal has a name, or else indices of its own.
    /// let file = SceneFile::read("scenes/cornell.gltf".as_ref(), false)?;
    /// let metal = Edit::away("materials/gold/metal");
    /// let [eta, k] = [("eta", 0.2), ("k", 3.9)]
    ///     .map(|(key, value)| Edit::new(format!("materials/gold/{key}"), value));
    /// file.world(&View::default(), &[metal, eta.clone(), k])?;
    /// assert!(file.world(&View::default(), &[eta]).is_err());
    /// # Ok::<(), sunstone::SceneError>(())
    /// ```
    pub fn away(target: impl Into<String>) -> Self {
        Self::new(target, Value::Null)
    }

    /// Whether it states how many pixels a film has.
    pub fn is_of_film_size(&self) -> bool {
        let key = self.target.rsplit('/').next().unwrap_or_default();
        let words: Vec<&str> = key.split(['.', '_']).collect();
        match words[..] {
            [.., "film", "resolution"] | [.., "film", "resolution", _] => !self.value.is_null(),
            [.., "film"] => self.value.get("resolution").is_some_and(|size| !size.is_null()),
            _ => false,
        }
    }
}

/// A scene file alone: what there is to be edited.
pub struct Editable(Of);

enum Of {
    /// The JSON of glTF.
    Gltf(Value),
    /// The bytes of a scene of Mitsuba, whose parameters are edited.
    Mitsuba(PathBuf, Vec<u8>),
}

impl Editable {
    /// Reads a file, and nothing that a glTF refers to.
    ///
    /// # Errors
    /// When the file cannot be read, or is a .gltf or .glb that is not JSON.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        if is_of_mitsuba(path) {
            let bytes = document::bytes_of(path).map_err(|error| error.in_file(path))?;
            return Ok(Self(Of::Mitsuba(path.to_owned(), bytes)));
        }
        let mut value = document::read_json(path).map_err(|error| error.in_file(path))?;
        if let Some(root) = value.as_object_mut() {
            UNEDITED.iter().for_each(|name| drop(root.remove(*name)));
        }
        Ok(Self(Of::Gltf(value)))
    }

    /// Checks that an edit would be of something that is there; its value is not looked at.
    ///
    /// # Errors
    /// When the kind, the name or the key is unknown, or the name is that of several; with what
    /// there is.
    pub fn check(&self, target: &str) -> Result<(), SceneError> {
        match &self.0 {
            Of::Gltf(value) => places(value, target).map(drop),
            Of::Mitsuba(path, bytes) => {
                MitsubaFile::check_edits(path, bytes, &[Edit::new(target, "")])
            }
        }
    }

    /// Checks that edits do not contradict each other, and that none is without effect. Of values
    /// only words and nulls matter.
    ///
    /// # Errors
    /// When two are of one place, or a key means nothing beside others.
    pub fn check_together(&self, edits: &[Edit]) -> Result<(), SceneError> {
        match &self.0 {
            Of::Gltf(value) => applied(value, edits).map(drop),
            Of::Mitsuba(path, bytes) => MitsubaFile::check_edits(path, bytes, edits),
        }
    }
}

/// What edits that are made at once make of a file.
///
/// # Errors
/// When one is about nothing that is there, is of the place of another, or has no effect.
pub fn applied(value: &Value, edits: &[Edit]) -> Result<Value, SceneError> {
    let found = found(value, edits)?;
    let mut edited = value.clone();
    for (places, edit) in &found {
        places.iter().for_each(|place| put(&mut edited, place, &edit.value));
    }
    let mut findings = Findings::default();
    for (places, edit) in found.iter().filter(|(_, edit)| !edit.value.is_null()) {
        findings.note(refuse_without_effect(&edited, places, &edit.target));
    }
    findings.result()?;
    Ok(edited)
}

/// The places of edits that are made at once.
pub fn found<'a>(
    value: &Value,
    edits: &'a [Edit],
) -> Result<Vec<(Vec<Place>, &'a Edit)>, SceneError> {
    let mut findings = Findings::default();
    let mut taken = Taken::default();
    let mut found = Vec::with_capacity(edits.len());
    for edit in edits {
        let places = places(value, &edit.target).and_then(|places| {
            taken.add(&edit.target, &places)?;
            refuse_taking_item(edit, &places)?;
            Ok(places)
        });
        found.extend(findings.note(places).map(|places| (places, edit)));
    }
    findings.result()?;
    Ok(found)
}

/// Places that have been set, by what.
#[derive(Default)]
struct Taken<'a>(Vec<(&'a str, Place)>);

impl<'a> Taken<'a> {
    /// Refuses a second edit of one place.
    fn add(&mut self, target: &'a str, places: &[Place]) -> Result<(), SceneError> {
        for place in places {
            let is_same =
                |(_, other): &&(&str, Place)| place.iter().zip(other).all(|(a, b)| a == b);
            if let Some((other, _)) = self.0.iter().find(is_same) {
                let problem = format!("is of the same place as {}", excerpt(other, NAME));
                return Err(SceneError::new(target, problem, "set it once"));
            }
            self.0.push((target, place.clone()));
        }
        Ok(())
    }
}

/// Refuses to take an item out of a list: others would move to its place.
fn refuse_taking_item(edit: &Edit, places: &[Place]) -> Result<(), SceneError> {
    let is_item = |place: &Place| matches!(place.last(), Some(Step::Index(_)));
    if !(edit.value.is_null() && places.iter().any(is_item)) {
        return Ok(());
    }
    let problem = "is an item of a list, and cannot be taken away";
    Err(SceneError::new(&edit.target, problem, "set the whole list"))
}

/// Refuses an edit of places in which a value counts for nothing.
pub fn refuse_without_effect(
    value: &Value,
    places: &[Place],
    target: &str,
) -> Result<(), SceneError> {
    let refuse = |(problem, remedy): Wrong| SceneError::new(target, problem, remedy);
    let check = |place: &Place| {
        refuse_overruled(value, place)?;
        refuse_replaced(value, place)?;
        refuse_meaningless(value, place)
    };
    places.iter().try_for_each(check).map_err(refuse)
}

/// Refuses a place of a node that is stated in the other way.
pub fn refuse_overruled(value: &Value, place: &[Step]) -> Result<(), Wrong> {
    const PARTS: [&str; 3] = ["translation", "rotation", "scale"];
    let [Step::Key(list), Step::Index(_), Step::Key(name), ..] = place else { return Ok(()) };
    if list != "nodes" {
        return Ok(());
    }
    let node = at(value, &place[..2]);
    let has = |name: &str| node.is_some_and(|node| !node[name].is_null());
    let other = match name.as_str() {
        "matrix" => PARTS.into_iter().find(|part| has(part)),
        part if PARTS.contains(&part) => Some("matrix").filter(|matrix| has(matrix)),
        _ => None,
    };
    let Some(other) = other else { return Ok(()) };
    let remedy = match name.as_str() {
        "translation" => "edit `translation.0` to `translation.2`, or `matrix`".to_owned(),
        _ => format!("edit `{other}`"),
    };
    let remedy = format!("{remedy}, or take that away with the same edits");
    Err((format!("the node has a `{other}`, which says where it is"), remedy))
}

/// Refuses the color of what shines where the extension has a spectrum in its place.
fn refuse_replaced(value: &Value, place: &[Step]) -> Result<(), Wrong> {
    let index = place.iter().position(|step| matches!(step, Step::Index(_)));
    let Some(index) = index.filter(|index| *index > 0) else { return Ok(()) };
    let (list, color) = (&place[index - 1], place.get(index + 1));
    let (Step::Key(list), Some(Step::Key(color))) = (list, color) else { return Ok(()) };
    let colors = [("materials", "emissiveFactor"), ("lights", "color")];
    let is_stated = || {
        let mut forms = forms(&place[..=index], "emission").into_iter();
        forms.any(|form| at(value, &form).is_some())
    };
    if colors.contains(&(list, color)) && is_stated() {
        let problem = "means nothing beside `emission`, which stands in its place".to_owned();
        return Err((problem, "edit `emission`, or take that away with the same edits".to_owned()));
    }
    Ok(())
}

/// Refuses a key of glTF's that counts for nothing in a material whose `bsdf` says what it is.
fn refuse_meaningless(value: &Value, place: &[Step]) -> Result<(), Wrong> {
    let [Step::Key(list), Step::Index(_), rest @ ..] = place else { return Ok(()) };
    if list != "materials" {
        return Ok(());
    }
    let words = rest.iter().filter_map(|step| match step {
        Step::Key(word) => Some(word.as_str()),
        Step::Index(_) => None,
    });
    let (name, object) = (words.collect::<Vec<_>>().join("."), &place[..2]);
    let stated = |name: &str| forms(object, name).iter().find_map(|form| at(value, form));
    let Some(model) = stated("bsdf").and_then(Value::as_str) else { return Ok(()) };
    // What stands in for a key of the extension that is not given.
    let counts = match name.as_str() {
        "pbrMetallicRoughness.baseColorFactor" => {
            model == "diffuse" && stated("reflectance").is_none()
        }
        "extensions.KHR_materials_ior.ior" => {
            ["dielectric", "thin_dielectric"].contains(&model) && stated("ior").is_none()
        }
        name => {
            let overruled = [
                "pbrMetallicRoughness",
                "KHR_materials_specular",
                "KHR_materials_transmission",
                "KHR_materials_volume",
            ];
            !overruled.iter().any(|part| name.contains(part))
        }
    };
    if counts {
        return Ok(());
    }
    let problem = format!("means nothing in this material, whose `bsdf` is `{model}`");
    let remedy = "edit the keys of that, as `reflectance` or `ior`, and leave this one out";
    Err((problem, remedy.to_owned()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::extension::EXTENSION;
    use super::*;

    fn lab() -> Value {
        json!({
            "materials": [
                {"name": "a/b c", "extensions": {EXTENSION: {"bsdf": "diffuse"}}},
                {"name": "twin", "extras": {"sunstone_ior": 1.5, "sunstone": {"ior": 1.5}}},
                {"name": "twin"},
                {"name": "#3"},
            ],
            "nodes": [{"name": "still", "matrix": vec![1.0; 16]}, {"translation": [1.0, 2.0, 3.0]}],
            "scenes": [{}, {"extensions": {EXTENSION: {"media": [
                {"name": "milk", "phase": "mie", "milk": {"dilution": 0.1}},
                {"name": "beads", "particles": [
                    {"eta": 1.5},
                    {"eta": {"nm": [400.0], "value": [1.4]}},
                ]},
            ]}}}],
            "scene": 1,
        })
    }

    fn edited(target: &str, value: Value) -> Value {
        applied(&lab(), &[Edit::new(target, value)]).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn keys_are_set_where_they_stand() {
        let media = "/scenes/1/extensions/SUNSTONE_polarization/media";
        for (target, pointer) in [
            (
                "materials/a/b c/reflectance",
                "/materials/0/extensions/SUNSTONE_polarization/reflectance",
            ),
            ("materials/#3/bsdf", "/materials/3/extensions/SUNSTONE_polarization/bsdf"),
            ("materials/#2/emissiveFactor", "/materials/2/emissiveFactor"),
            (
                "materials/#2/pbrMetallicRoughness.baseColorFactor",
                "/materials/2/pbrMetallicRoughness/baseColorFactor",
            ),
            ("nodes/#1/translation.2", "/nodes/1/translation/2"),
            ("nodes/still/matrix.0", "/nodes/0/matrix/0"),
            ("nodes/still/translation.1", "/nodes/0/matrix/13"),
            ("media/milk/milk.dilution", &format!("{media}/0/milk/dilution")),
            ("media/beads/particles.0.eta", &format!("{media}/1/particles/0/eta")),
            ("media/beads/particles.1.eta.value.0", &format!("{media}/1/particles/1/eta/value/0")),
        ] {
            let value = edited(target, json!(7.0));
            assert_eq!(value.pointer(pointer), Some(&json!(7.0)), "{target}: {value:#}");
        }
        // In all its forms at once: they must not contradict each other.
        let value = edited("materials/#3/reflectance", json!(0.5));
        assert_eq!(value["materials"][3]["extensions"][EXTENSION]["reflectance"], 0.5);
        let mut both = lab();
        both["materials"][2]["name"] = json!("other");
        for target in ["ior", "extras.sunstone.ior", "extras.sunstone_ior"] {
            let edit = Edit::new(format!("materials/twin/{target}"), 1.7);
            let both = applied(&both, &[edit]).unwrap();
            let extras = &both["materials"][1]["extras"];
            assert_eq!(
                (&extras["sunstone_ior"], &extras["sunstone"]["ior"]),
                (&json!(1.7), &json!(1.7))
            );
            assert!(both["materials"][1].get("extensions").is_none());
        }
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        // This color stands in for a reflectance that is not given.
        edited("materials/#0/pbrMetallicRoughness.baseColorFactor", json!([1, 0, 0, 1]));
        let refused = |edits: &[Edit]| applied(&lab(), edits).unwrap_err().to_string();
        for (target, words) in [
            ("glass", "kinds are materials, nodes, lights, cameras, media"),
            ("shapes/a/b", "`shapes` is no kind of object"),
            ("materials/snow/ior", "the materials are #0 a/b c, #1 twin, #2 twin, #3 #3"),
            ("materials/twin/ior", "several materials are called so: #1, #2"),
            ("materials/#9/ior", "no material is called `#9`"),
            ("materials/#2/index", "a material has no key `index`"),
            ("materials/#2/name", "a material has no key `name`"),
            ("materials/#2/emissiveFactor.0", "set the whole of it"),
            ("materials/#0/extensions.KHR_materials_ior.ior", "whose `bsdf` is `diffuse`"),
            ("materials/#0/pbrMetallicRoughness.metallicFactor", "means nothing in this material"),
            ("media/milk/milk.fat", "keys are dilution, fat_percent, protein_percent"),
            ("media/beads/particles.2.eta", "its list has 2 items, from 0 on"),
            ("nodes/still/translation", "the node has a `matrix`"),
            ("nodes/#1/matrix", "the node has a `translation`"),
            ("lights/sun/intensity", "the scene has no lights"),
        ] {
            let error = refused(&[Edit::new(target, 1.0)]);
            assert!(error.contains(words) && error.contains(target), "{target}: {error}");
        }
        let twice =
            [Edit::new("media/milk/milk", json!({})), Edit::new("media/#0/milk.dilution", 1.0)];
        assert!(refused(&twice).contains("is of the same place as media/milk/milk"));
        // All of them at once.
        let several = [Edit::new("materials/x/ior", 1.0), Edit::new("media/x/g", 1.0)];
        assert!(refused(&several).starts_with("2 things are wrong"));
    }

    #[test]
    fn what_is_taken_away_is_not_stated() {
        let away = |target: &str| edited(target, Value::Null);
        // With the objects of which nothing is left, and in all forms.
        assert_eq!(away("materials/a/b c/bsdf")["materials"][0], json!({"name": "a/b c"}));
        assert_eq!(away("materials/#1/ior")["materials"][1], json!({"name": "twin"}));
        assert_eq!(away("nodes/#1/translation")["nodes"][1], json!({}));
        // What is not there may be taken away, and nothing else with it.
        assert_eq!(away("materials/#2/ior"), lab());
        assert_eq!(away("media/milk/milk.fat_percent"), lab());
        let error = applied(&lab(), &[Edit::away("nodes/still/matrix.3")]).unwrap_err();
        assert!(error.to_string().contains("an item of a list"), "{error}");
    }

    #[test]
    fn edits_at_once_are_checked_after_the_last_of_them() {
        let moved =
            [Edit::away("nodes/still/matrix"), Edit::new("nodes/still/scale", json!([2, 2, 2]))];
        for edits in [moved.clone(), [moved[1].clone(), moved[0].clone()]] {
            let value = applied(&lab(), &edits).unwrap();
            assert_eq!(value["nodes"][0], json!({"name": "still", "scale": [2, 2, 2]}));
        }
        assert!(applied(&lab(), &moved[1..]).is_err());
        let ior = Edit::new("materials/#0/extensions.KHR_materials_ior.ior", 1.3);
        let glass = Edit::new("materials/#0/bsdf", "dielectric");
        assert!(applied(&lab(), &[ior.clone(), glass]).is_ok());
        assert!(applied(&lab(), &[ior]).is_err());
        let color =
            Edit::new("materials/#0/pbrMetallicRoughness.baseColorFactor", json!([1, 1, 1, 1]));
        let both = [color, Edit::new("materials/#0/reflectance", 0.5)];
        let error = applied(&lab(), &both).unwrap_err().to_string();
        assert!(error.contains("baseColorFactor means nothing"), "{error}");
    }

    #[test]
    fn colors_beside_spectra_are_refused() {
        let spectrum = json!({"sunstone_emission": {"illuminant": "D65", "scale": 2}});
        let lights = json!([{"name": "sun", "extras": spectrum}]);
        let value = json!({
            "materials": [{"name": "lamp", "extras": spectrum}],
            "extensions": {"KHR_lights_punctual": {"lights": lights}},
        });
        let white = json!([1, 1, 1]);
        for target in ["materials/lamp/emissiveFactor", "lights/sun/color"] {
            let error = applied(&value, &[Edit::new(target, white.clone())]).unwrap_err();
            assert!(error.to_string().contains("means nothing beside `emission`"), "{error}");
            let (object, _) = target.rsplit_once('/').unwrap();
            let away = Edit::away(format!("{object}/emission"));
            assert!(applied(&value, &[Edit::new(target, white.clone()), away]).is_ok());
            let scale = Edit::new(format!("{object}/emission.scale"), 3);
            assert!(applied(&value, &[scale]).is_ok());
        }
        assert!(applied(&value, &[Edit::new("lights/sun/intensity", 3)]).is_ok());
    }

    #[test]
    fn sizes_of_films_are_known() {
        let size = json!([8, 8]);
        for (key, value, is_it) in [
            ("film.resolution", size.clone(), true),
            ("film.resolution.0", json!(8), true),
            ("film", json!({"resolution": [8, 8]}), true),
            ("extras.sunstone_film.resolution", size, true),
            ("extensions.SUNSTONE_polarization.film", json!({"resolution": [8, 8]}), true),
            ("film", json!({"analyzer": {"kind": "linear"}}), false),
            ("film.resolution", Value::Null, false),
            ("film.analyzer.axis_deg", json!(30), false),
        ] {
            let edit = Edit::new(format!("cameras/a.film.resolution/b/{key}"), value);
            assert_eq!(edit.is_of_film_size(), is_it, "{edit:?}");
        }
    }

    #[test]
    fn names_like_indices_of_others_are_refused() {
        let mut lab = lab();
        lab["materials"][3]["name"] = json!("#0");
        lab["materials"][2]["name"] = json!("#3");
        lab["materials"][1]["name"] = json!("#03");
        let of = |target: &str| applied(&lab, &[Edit::new(target, 0.5)]);
        let error = of("materials/#0/reflectance").unwrap_err().to_string();
        for words in [
            "name of material 3, and the index of another",
            "materials/#003/... for the first",
            "materials/#00/... for the other",
        ] {
            assert!(error.contains(words), "{error}");
        }
        let edited = |target: &str| of(target).unwrap_or_else(|error| panic!("{error}"));
        let value = edited("materials/#00/reflectance");
        assert_eq!(value["materials"][0]["extensions"][EXTENSION]["reflectance"], 0.5);
        let value = edited("materials/#003/reflectance");
        assert_eq!(value["materials"][3]["extensions"][EXTENSION]["reflectance"], 0.5);
        assert!(of("materials/#+0/reflectance").is_err());
    }
}
