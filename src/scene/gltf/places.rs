//! Where in a scene file that is which an edit names: kinds, names, keys, and the way inwards.

use serde_json::{Map, Value};

use super::extension::{CAMERA, EXTENSION, Keys, LIGHT, MATERIAL, MEDIUM, NODE, inner};
use crate::math::text::{excerpt, listed, number_of};
use crate::scene::error::SceneError;
use crate::scene::file::DEFINE;

/// Most characters of a name in errors.
const NAME: usize = 60;

/// A step inwards.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    Key(String),
    Index(usize),
}

/// The way to a value from the root of the file.
pub type Place = Vec<Step>;

pub fn key(name: &str) -> Step {
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
            "extensions.KHR_materials_specular.specularFactor",
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
pub fn forms(object: &[Step], name: &str) -> [Place; 3] {
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

/// Puts a value into a place, with the objects around it that are not there; null takes away what
/// stands there, with objects of which nothing is left.
pub fn put(value: &mut Value, place: &[Step], new: &Value) {
    if new.is_null() {
        return take_away(value, place);
    }
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

fn take_away(value: &mut Value, place: &[Step]) {
    let [first, rest @ ..] = place else {
        *value = Value::Null;
        return;
    };
    match first {
        Step::Index(index) => {
            // Places of items have something further inwards.
            if let (Some(inner), false) = (value.get_mut(*index), rest.is_empty()) {
                take_away(inner, rest);
            }
        }
        Step::Key(name) => {
            let Some(object) = value.as_object_mut() else { return };
            let Some(inner) = object.get_mut(name) else { return };
            if !rest.is_empty() {
                take_away(inner, rest);
            }
            if rest.is_empty() || inner.as_object().is_some_and(Map::is_empty) {
                object.remove(name);
            }
        }
    }
}

/// The objects that `KIND/NAME` names: one, or several forms of it.
pub fn objects_called(value: &Value, object: &str) -> Option<Vec<Place>> {
    let (kind, name) = object.split_once('/')?;
    let kind = KINDS.iter().find(|known| known.name == kind)?;
    let lists = (kind.lists)(value);
    let objects = lists.first().and_then(|list| at(value, list)).and_then(Value::as_array)?;
    let index = index_of(objects, kind, name).ok()?;
    let object = |mut list: Place| {
        list.push(Step::Index(index));
        list
    };
    Some(lists.into_iter().map(object).collect())
}

/// The places of what an edit is about, whether or not that has an effect.
pub fn places(value: &Value, target: &str) -> Result<Vec<Place>, SceneError> {
    let refuse = |problem: String, remedy: String| SceneError::new(target, problem, remedy);
    if target.starts_with(DEFINE) {
        let remedy = "they are .xml files'; edit what is in the scene by its name";
        return Err(refuse("glTF has no parameters".to_owned(), remedy.to_owned()));
    }
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
pub type Wrong = (String, String);

/// The index of the object of a name, or of `#3`, if only one of the two is meant.
fn index_of(objects: &[Value], kind: &Kind, name: &str) -> Result<usize, Wrong> {
    let name_of = |index: usize| objects[index]["name"].as_str();
    let named = |index: &usize| name_of(*index) == Some(name);
    let found: Vec<usize> = (0..objects.len()).filter(named).collect();
    let numbered = number_of(name).filter(|index| *index < objects.len());
    match (&found[..], numbered) {
        (&[index], None) => return Ok(index),
        (&[index], Some(other)) if index == other => return Ok(index),
        (&[index], Some(other)) => {
            let is_free = |word: &str| objects.iter().all(|object| object["name"] != *word);
            let (one, of, kind) = (kind.one, excerpt(name, NAME), kind.name);
            let problem = format!("`{of}` is the name of {one} {index}, and the index of another");
            let [first, second] = [index, other].map(|index| numbers(index).find(|it| is_free(it)));
            let [first, second] = [first, second].map(Option::unwrap_or_default);
            let remedy = format!(
                "write {kind}/{first}/... for the first, {kind}/{second}/... for the other"
            );
            return Err((problem, remedy));
        }
        ([], Some(index)) => return Ok(index),
        ([], None) => {}
        _ => {
            let indices = listed(found.iter().map(|index| format!("#{index}")));
            let problem = format!("several {} are called so: {indices}", kind.name);
            let remedy = format!("write {}/#{}/...", kind.name, found[0]);
            return Err((problem, remedy));
        }
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

/// The words that stand for an index: `#3`, `#03` and so on.
pub fn numbers(index: usize) -> impl Iterator<Item = String> {
    const ZEROS: usize = 100;
    (0..ZEROS).map(move |zeros| format!("#{}{index}", "0".repeat(zeros)))
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
