//! Edits of a scene file by name, before it is read: `KIND/NAME/KEY` and a value.
//!
//! The first and the last slash separate, so names may hold anything. `#3` in place of a name is
//! the object of that index, counted from zero as in the file. A key is one of the extension's, set
//! wherever it stands (or is put into `SUNSTONE_polarization`), or one of glTF's own, which starts
//! at the object; dots lead inwards, into lists by index.

use std::path::Path;

use serde_json::{Map, Value};

use super::document;
use super::extension::{CAMERA, EXTENSION, Keys, LIGHT, MATERIAL, MEDIUM, NODE, inner};
use crate::math::text::{excerpt, listed};
use crate::scene::error::{Findings, SceneError};

/// Most characters of a name in errors.
const NAME: usize = 60;

/// A value in place of that of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Which: `materials/analyzer/axis_deg`, `media/milk/milk.dilution`, `nodes/#3/translation`.
    pub target: String,
    /// What instead, as in the file.
    pub value: Value,
}

impl Edit {
    /// An edit.
    pub fn new(target: impl Into<String>, value: impl Into<Value>) -> Self {
        Self { target: target.into(), value: value.into() }
    }
}

/// The JSON of a scene file alone: what there is to be edited.
pub struct Editable(Value);

impl Editable {
    /// Reads the JSON of a .gltf or .glb file, and nothing that it refers to.
    ///
    /// # Errors
    /// When the file cannot be read, or is not JSON.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        document::read_json(path).map(Self).map_err(|error| error.in_file(path))
    }

    /// Checks that an edit would be of something that is there; its value is not looked at.
    ///
    /// # Errors
    /// When the kind, the name or the key is unknown, or the name is that of several; with what
    /// there is.
    pub fn check(&self, target: &str) -> Result<(), SceneError> {
        places_to_set(&self.0, target).map(drop)
    }

    /// Checks that edits do not contradict each other.
    ///
    /// # Errors
    /// When two are of one place.
    pub fn check_together<'a>(
        &self,
        targets: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), SceneError> {
        let mut taken = Taken::default();
        for target in targets {
            let places = places_to_set(&self.0, target)?;
            taken.add(target, &places)?;
        }
        Ok(())
    }
}

/// Makes edits, all or none.
pub fn apply(value: &mut Value, edits: &[Edit]) -> Result<(), SceneError> {
    for (places, edit) in found(value, edits)? {
        places.iter().for_each(|place| set(value, place, &edit.value));
    }
    Ok(())
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
        let places = places_to_set(value, &edit.target).and_then(|places| {
            taken.add(&edit.target, &places)?;
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

/// A step inwards.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    Key(String),
    Index(usize),
}

/// The way to a value from the root of the file.
pub type Place = Vec<Step>;

fn key(name: &str) -> Step {
    Step::Key(name.to_owned())
}

/// A kind of objects that edits are about.
pub struct Kind {
    /// What edits call it.
    pub name: &'static str,
    /// One of it.
    one: &'static str,
    /// Its keys in the extension.
    pub keys: &'static Keys,
    /// glTF's own keys that are read, with those of other extensions.
    pub own: &'static [&'static str],
    /// Whether the object itself is of the extension, with the keys in it.
    is_of_extension: bool,
    /// Where the lists of its objects stand that a scene may have; all that are there are alike.
    pub lists: fn(&Value) -> Vec<Place>,
}

/// All kinds.
pub const KINDS: [Kind; 5] = [
    Kind {
        name: "materials",
        one: "material",
        keys: &MATERIAL,
        own: &[
            "doubleSided",
            "emissiveFactor",
            "pbrMetallicRoughness.baseColorFactor",
            "pbrMetallicRoughness.metallicFactor",
            "pbrMetallicRoughness.roughnessFactor",
            "extensions.KHR_materials_emissive_strength.emissiveStrength",
            "extensions.KHR_materials_ior.ior",
            "extensions.KHR_materials_transmission.transmissionFactor",
            "extensions.KHR_materials_volume.attenuationColor",
            "extensions.KHR_materials_volume.attenuationDistance",
            "extensions.KHR_materials_volume.thicknessFactor",
        ],
        is_of_extension: false,
        lists: |_| vec![vec![key("materials")]],
    },
    Kind {
        name: "nodes",
        one: "node",
        keys: &NODE,
        own: &[
            "camera",
            "extensions.KHR_lights_punctual.light",
            "matrix",
            "mesh",
            "rotation",
            "scale",
            "translation",
        ],
        is_of_extension: false,
        lists: |_| vec![vec![key("nodes")]],
    },
    Kind {
        name: "lights",
        one: "light",
        keys: &LIGHT,
        own: &["color", "intensity", "spot.innerConeAngle", "spot.outerConeAngle", "type"],
        is_of_extension: false,
        lists: |_| vec![vec![key("extensions"), key("KHR_lights_punctual"), key("lights")]],
    },
    Kind {
        name: "cameras",
        one: "camera",
        keys: &CAMERA,
        own: &[
            "orthographic.xmag",
            "orthographic.ymag",
            "perspective.aspectRatio",
            "perspective.yfov",
            "type",
        ],
        is_of_extension: false,
        lists: |_| vec![vec![key("cameras")]],
    },
    Kind {
        name: "media",
        one: "medium",
        keys: &MEDIUM,
        own: &[],
        is_of_extension: true,
        lists: lists_of_media,
    },
];

/// Media stand in the default scene or at the root, in one of the forms of the extension.
fn lists_of_media(value: &Value) -> Vec<Place> {
    let scene = value["scene"].as_u64().unwrap_or(0) as usize;
    let owners = [vec![], vec![key("scenes"), Step::Index(scene)]];
    let lists = owners.into_iter().flat_map(|owner| forms(&owner, "media"));
    lists.filter(|list| at(value, list).is_some()).collect()
}

/// Where a key of the extension may stand in an object.
fn forms(object: &[Step], name: &str) -> [Place; 3] {
    [
        vec![key("extensions"), key(EXTENSION), key(name)],
        vec![key("extras"), key("sunstone"), key(name)],
        vec![key("extras"), Step::Key(format!("sunstone_{name}"))],
    ]
    .map(|form| object.iter().cloned().chain(form).collect())
}

/// What stands in a place.
pub fn at<'a>(value: &'a Value, place: &[Step]) -> Option<&'a Value> {
    place.iter().try_fold(value, |inner, step| match step {
        Step::Key(name) => inner.get(name),
        Step::Index(index) => inner.get(index),
    })
}

/// Puts a value into a place, with the objects around it that are not there.
pub fn set(value: &mut Value, place: &[Step], new: &Value) {
    let mut inner = value;
    for step in place {
        inner = match step {
            Step::Key(name) => {
                if !inner.is_object() {
                    *inner = Value::Object(Map::new());
                }
                &mut inner[name.as_str()]
            }
            Step::Index(index) => match inner.get_mut(*index) {
                Some(inner) => inner,
                // Places have been looked up in this value.
                None => return,
            },
        };
    }
    *inner = new.clone();
}

/// The places of what an edit is about, if it has an effect there.
fn places_to_set(value: &Value, target: &str) -> Result<Vec<Place>, SceneError> {
    let places = places(value, target)?;
    let refuse = |(problem, remedy): Wrong| SceneError::new(target, problem, remedy);
    places.iter().try_for_each(|place| refuse_without_effect(value, place)).map_err(refuse)?;
    Ok(places)
}

/// The places of what an edit is about.
pub fn places(value: &Value, target: &str) -> Result<Vec<Place>, SceneError> {
    let refuse = |problem: String, remedy: String| SceneError::new(target, problem, remedy);
    let parts = target.split_once('/').and_then(|(kind, rest)| {
        let (name, key) = rest.rsplit_once('/')?;
        Some((kind, name, key))
    });
    let kinds = || listed(KINDS.iter().map(|kind| kind.name));
    let Some((kind, name, path)) = parts else {
        let remedy = format!("write KIND/NAME/KEY; kinds are {}", kinds());
        return Err(refuse("is no edit".to_owned(), remedy));
    };
    let Some(kind) = KINDS.iter().find(|known| known.name == kind) else {
        let problem = format!("`{}` is no kind of object", excerpt(kind, NAME));
        return Err(refuse(problem, format!("kinds are {}", kinds())));
    };
    let lists = (kind.lists)(value);
    let objects = lists.first().and_then(|list| at(value, list)).and_then(Value::as_array);
    let objects = objects.map_or(&[][..], Vec::as_slice);
    let index =
        index_of(objects, kind, name).map_err(|(problem, remedy)| refuse(problem, remedy))?;
    let owners = lists.into_iter().map(|mut list| {
        list.push(Step::Index(index));
        list
    });
    let found = owners.map(|owner| places_of_key(value, kind, &owner, path));
    let found: Result<Vec<_>, _> = found.collect();
    found
        .map(|found| found.into_iter().flatten().collect())
        .map_err(|(problem, remedy)| refuse(problem, remedy))
}

/// What is wrong, and how to mend it.
type Wrong = (String, String);

/// The index of the object of a name, or of `#3`.
fn index_of(objects: &[Value], kind: &Kind, name: &str) -> Result<usize, Wrong> {
    let named = |index: &usize| objects[*index]["name"].as_str() == Some(name);
    let found: Vec<usize> = (0..objects.len()).filter(named).collect();
    match found[..] {
        [index] => return Ok(index),
        [] => {}
        _ => {
            let indices = listed(found.iter().map(|index| format!("#{index}")));
            let problem = format!("several {} are called so: {indices}", kind.name);
            let remedy = format!("write {}/#{}/...", kind.name, found[0]);
            return Err((problem, remedy));
        }
    }
    let index = name.strip_prefix('#').and_then(|index| index.parse().ok());
    if let Some(index) = index.filter(|index| *index < objects.len()) {
        return Ok(index);
    }
    let problem = format!("no {} is called `{}`", kind.one, excerpt(name, NAME));
    if objects.is_empty() {
        return Err((problem, format!("the scene has no {}", kind.name)));
    }
    let names = objects.iter().enumerate().map(|(index, object)| {
        let name = object["name"].as_str().unwrap_or("without a name");
        format!("#{index} {}", excerpt(name, NAME))
    });
    Err((problem, format!("the {} are {}", kind.name, listed(names))))
}

/// The places of a key in an object: one, or all where a key of the extension stands.
fn places_of_key(
    value: &Value,
    kind: &Kind,
    object: &[Step],
    path: &str,
) -> Result<Vec<Place>, Wrong> {
    let words: Vec<&str> = path.split('.').collect();
    if let Some((name, rest)) = of_extension(kind, &words) {
        let forms = match kind.is_of_extension {
            true => vec![object.iter().cloned().chain([key(name)]).collect()],
            false => forms(object, name).to_vec(),
        };
        let is_there = |form: &&Place| at(value, form).is_some();
        let mut found: Vec<Place> = forms.iter().filter(is_there).cloned().collect();
        if found.is_empty() {
            found.extend(forms.into_iter().take(1));
        }
        let keys = inner(kind.keys, name);
        return found.into_iter().map(|place| inwards(value, place, rest, keys)).collect();
    }
    let own = |known: &&&str| path == **known || path.strip_prefix(**known).is_some_and(is_inner);
    let Some(known) = kind.own.iter().find(own) else {
        let known = kind.keys.known.iter().filter(|key| **key != "name").chain(kind.own);
        let problem = format!("a {} has no key `{}`", kind.one, excerpt(path, NAME));
        return Err((
            problem,
            format!("keys are {}", known.copied().collect::<Vec<_>>().join(", ")),
        ));
    };
    if let Some(place) = translation_of_matrix(value, object, &words) {
        return Ok(vec![place]);
    }
    refuse_overruled(at(value, object), known)?;
    let depth = known.split('.').count();
    let place = object.iter().cloned().chain(words[..depth].iter().map(|word| key(word))).collect();
    Ok(vec![inwards(value, place, &words[depth..], None)?])
}

fn is_inner(rest: &str) -> bool {
    rest.starts_with('.')
}

/// Where a coordinate of a node's translation stands in its matrix, if it has one.
fn translation_of_matrix(value: &Value, object: &[Step], words: &[&str]) -> Option<Place> {
    const START: usize = 12;
    let ["translation", axis] = words else { return None };
    let axis = axis.parse().ok().filter(|axis: &usize| *axis < 3)?;
    let place = object.iter().cloned().chain([key("matrix"), Step::Index(START + axis)]);
    let place: Place = place.collect();
    at(value, &place).map(|_| place)
}

/// Refuses a place of a node that the file states in the other way.
fn refuse_overruled(node: Option<&Value>, name: &str) -> Result<(), Wrong> {
    const PARTS: [&str; 3] = ["translation", "rotation", "scale"];
    let has = |name: &str| node.is_some_and(|node| !node[name].is_null());
    let other = match name {
        "matrix" => PARTS.into_iter().find(|part| has(part)),
        part if PARTS.contains(&part) => Some("matrix").filter(|matrix| has(matrix)),
        _ => None,
    };
    let Some(other) = other else { return Ok(()) };
    let remedy = match name {
        "translation" => "edit `translation.0` to `translation.2`, or `matrix`".to_owned(),
        _ => format!("edit `{other}`"),
    };
    Err((format!("the node has a `{other}`, which says where it is"), remedy))
}

/// Refuses a key of glTF's that counts for nothing in a material whose `bsdf` says what it is.
fn refuse_without_effect(value: &Value, place: &[Step]) -> Result<(), Wrong> {
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
            let overruled =
                ["pbrMetallicRoughness", "KHR_materials_transmission", "KHR_materials_volume"];
            !overruled.iter().any(|part| name.contains(part))
        }
    };
    if counts {
        return Ok(());
    }
    let problem = format!("means nothing in this material, whose `bsdf` is `{model}`");
    Err((problem, "edit the keys of that, as `reflectance` or `ior`".to_owned()))
}

/// The extension's key that a path begins with, in any of its forms, and what follows.
pub fn of_extension<'a, 'b>(kind: &Kind, words: &'a [&'b str]) -> Option<(&'b str, &'a [&'b str])> {
    let (name, rest) = match words {
        ["extensions", EXTENSION, name, rest @ ..] | ["extras", "sunstone", name, rest @ ..] => {
            (*name, rest)
        }
        ["extras", name, rest @ ..] => (name.strip_prefix("sunstone_")?, rest),
        [name, rest @ ..] => (*name, rest),
        [] => return None,
    };
    (kind.keys.known.contains(&name) && name != "name").then_some((name, rest))
}

/// The place further inwards; `keys` are those of the object that stands there, if it has keys.
fn inwards(
    value: &Value,
    mut place: Place,
    words: &[&str],
    mut keys: Option<&'static Keys>,
) -> Result<Place, Wrong> {
    for word in words {
        let here = at(value, &place);
        if let Some(Value::Array(list)) = here {
            let Some(index) = word.parse().ok().filter(|index: &usize| *index < list.len()) else {
                let problem = format!("`{}` is no index into it", excerpt(word, NAME));
                return Err((problem, format!("its list has {} items, from 0 on", list.len())));
            };
            place.push(Step::Index(index));
            continue;
        }
        let is_object = here.is_none_or(|here| here.is_object() || here.is_null());
        let Some(known) = keys.filter(|known| is_object && known.known.contains(word)) else {
            let problem = format!("there is no `{}` in it", excerpt(word, NAME));
            let remedy = match keys {
                Some(keys) if is_object => format!("keys are {}", keys.known.join(", ")),
                _ => "set the whole of it".to_owned(),
            };
            return Err((problem, remedy));
        };
        place.push(key(word));
        keys = inner(known, word);
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn lab() -> Value {
        json!({
            "materials": [
                {"name": "a/b c", "extensions": {EXTENSION: {"bsdf": "diffuse"}}},
                {"name": "twin", "extras": {"sunstone_ior": 1.5, "sunstone": {"ior": 1.5}}},
                {"name": "twin"},
                {"name": "#1"},
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
        let mut lab = lab();
        apply(&mut lab, &[Edit::new(target, value)]).unwrap_or_else(|error| panic!("{error}"));
        lab
    }

    #[test]
    fn keys_are_set_where_they_stand() {
        let media = "/scenes/1/extensions/SUNSTONE_polarization/media";
        for (target, pointer) in [
            (
                "materials/a/b c/reflectance",
                "/materials/0/extensions/SUNSTONE_polarization/reflectance",
            ),
            ("materials/#1/bsdf", "/materials/3/extensions/SUNSTONE_polarization/bsdf"),
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
        let value = edited("materials/#1/reflectance", json!(0.5));
        assert_eq!(value["materials"][3]["extensions"][EXTENSION]["reflectance"], 0.5);
        let mut both = lab();
        both["materials"][2]["name"] = json!("other");
        for target in ["ior", "extras.sunstone.ior", "extras.sunstone_ior"] {
            let mut both = both.clone();
            let edit = Edit::new(format!("materials/twin/{target}"), 1.7);
            apply(&mut both, &[edit]).unwrap();
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
        let refused = |edits: &[Edit]| {
            let mut lab = lab();
            let error = apply(&mut lab, edits).unwrap_err().to_string();
            assert_eq!(lab, self::lab(), "nothing is edited");
            error
        };
        for (target, words) in [
            ("glass", "kinds are materials, nodes, lights, cameras, media"),
            ("shapes/a/b", "`shapes` is no kind of object"),
            ("materials/snow/ior", "the materials are #0 a/b c, #1 twin, #2 twin, #3 #1"),
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
}
