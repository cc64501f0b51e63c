//! From XML to the tree of objects: elements, parameters, includes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use roxmltree::{Document, Node, ParsingOptions};

use super::text::{Parameters, curve, curve_of_lines, number, numbers};
use super::transforms::transform;
use super::tree::{Child, NAME, Object, Property, Spot, Tag, Target, Tree, Value};
use crate::math::text::excerpt;
use crate::scene::error::{Findings, SceneError};
use crate::scene::gltf::files::Files;

/// Most bytes of a file of text.
const TEXT_MAX: u64 = 1 << 26;
/// Most elements of a file.
const ELEMENTS_MAX: u32 = 1 << 22;
/// Most objects within objects, and files within files.
const DEPTH_MAX: usize = 32;
/// Most files that are included in all.
const INCLUDES_MAX: usize = 1000;

/// Reads a scene, and what it includes.
pub fn read(
    bytes: &[u8],
    files: &Files,
    definitions: &[(String, String)],
) -> Result<(Tree, Paths), SceneError> {
    let mut reader = Reader::new(files, definitions);
    let root = reader.file(bytes, &Source::default())?;
    let first = reader.tree.objects.get(root);
    if first.is_some_and(|object| object.tag != Tag::Scene) {
        let remedy = "the outermost element is <scene>";
        reader.refuse(SceneError::new("line 1", "is no scene", remedy));
    }
    for error in reader.tree.resolve() {
        reader.refuse(error);
    }
    if let Some((problem, remedy)) = reader.parameters.unused() {
        reader.refuse(SceneError::new("-D", problem, remedy));
    }
    reader.findings.result()?;
    Ok((reader.tree, reader.paths))
}

/// Says if a scene has not all parameters that definitions are of; what else is wrong with it is
/// not told.
pub fn check_parameters(
    bytes: &[u8],
    files: &Files,
    definitions: &[(String, String)],
) -> Result<(), SceneError> {
    let mut reader = Reader::new(files, definitions);
    if reader.file(bytes, &Source::default()).is_err() || reader.findings.result().is_err() {
        return Ok(());
    }
    match reader.parameters.unused() {
        Some((problem, remedy)) => Err(SceneError::new("define", problem, remedy)),
        None => Ok(()),
    }
}

/// Folders in which files are looked for, relative to that of the scene: the last first.
#[derive(Clone, Debug, Default)]
pub struct Paths(Vec<PathBuf>);

impl Paths {
    /// The path of a file relative to the folder of the scene: where it is, or else beside the
    /// scene.
    pub fn of(&self, name: &str, files: &Files) -> String {
        let found = self.0.iter().rev().map(|folder| folder.join(name));
        let path = found.into_iter().find(|path| files.has(path));
        path.map_or_else(|| name.to_owned(), |path| path.to_string_lossy().into_owned())
    }
}

/// A file on its way in.
#[derive(Clone, Debug, Default)]
struct Source {
    /// Its name in errors; empty for the scene's own.
    name: Arc<str>,
    /// How many files it is within.
    depth: usize,
    /// Where lines begin.
    lines: Vec<usize>,
    /// Whether names are those of a version before 2.
    is_old: bool,
}

impl Source {
    fn spot(&self, node: Node) -> Spot {
        let line = self.lines.partition_point(|start| *start <= node.range().start);
        Spot { file: self.name.clone(), line: line as u32 }
    }
}

struct Reader<'a> {
    files: &'a Files,
    tree: Tree,
    parameters: Parameters,
    findings: Findings,
    paths: Paths,
    includes: usize,
}

impl<'a> Reader<'a> {
    fn new(files: &'a Files, definitions: &[(String, String)]) -> Self {
        Self {
            files,
            tree: Tree::default(),
            parameters: Parameters::new(definitions),
            findings: Findings::default(),
            paths: Paths::default(),
            includes: 0,
        }
    }
}

impl Reader<'_> {
    fn refuse(&mut self, error: SceneError) {
        self.findings.note::<()>(Err(error));
    }

    /// Reads a file; the number of its outermost object.
    fn file(&mut self, bytes: &[u8], source: &Source) -> Result<usize, SceneError> {
        let at = |line: u32| Spot { file: source.name.clone(), line }.to_string();
        let refuse = |problem: &str| SceneError::new(&*source.name, problem, "save it as UTF-8");
        let text = std::str::from_utf8(bytes).map_err(|_| refuse("is not UTF-8"))?;
        let options =
            ParsingOptions { allow_dtd: false, nodes_limit: ELEMENTS_MAX, ..Default::default() };
        let document = Document::parse_with_options(text, options).map_err(|error| {
            let place = at(error.pos().row);
            SceneError::new(place, format!("is not XML: {error}"), "")
        })?;
        let root = document.root_element();
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = std::iter::once(0).chain(ends.map(|(end, _)| end + 1)).collect();
        let mut source = Source { lines, ..source.clone() };
        source.is_old = is_old(root, &source.spot(root))?;
        self.object(root, &source, 0)
    }

    /// The attributes of an element, with their parameters put in; refuses what does not belong to
    /// it. Those that it must have end in `!`.
    fn attributes<'n>(
        &mut self,
        node: Node<'n, 'n>,
        known: &[&str],
        spot: &Spot,
    ) -> Result<Attributes, SceneError> {
        let element = node.tag_name().name();
        let mut values = Vec::new();
        for attribute in node.attributes() {
            let name = attribute.name();
            if !known.iter().any(|known| known.trim_end_matches('!') == name) {
                let problem = format!("has no attribute `{}`", excerpt(name, NAME));
                let names: Vec<&str> = known.iter().map(|it| it.trim_end_matches('!')).collect();
                let remedy = format!("it may have {}", names.join(", "));
                return Err(SceneError::new(format!("{spot}, {element}"), problem, remedy));
            }
            let value = self.parameters.put_into(attribute.value()).map_err(|problem| {
                let remedy = "say -D name=value, or <default name=\"...\" value=\"...\"/> before";
                SceneError::new(format!("{spot}, {element}, {name}"), problem, remedy)
            })?;
            values.push((name.to_owned(), value));
        }
        let attributes = Attributes { place: format!("{spot}, {element}"), values };
        for needed in known.iter().filter_map(|name| name.strip_suffix('!')) {
            attributes.needed(needed)?;
        }
        Ok(attributes)
    }

    /// Reads an object with all that is within; its number.
    fn object(&mut self, node: Node, source: &Source, depth: usize) -> Result<usize, SceneError> {
        let spot = source.spot(node);
        let element = node.tag_name().name();
        let Some(tag) = Tag::of(element) else {
            let problem = format!("<{}> is not known", excerpt(element, NAME));
            return Err(SceneError::new(spot.to_string(), problem, ""));
        };
        if depth > DEPTH_MAX {
            let problem = format!("more than {DEPTH_MAX} objects within each other");
            return Err(SceneError::new(spot.to_string(), problem, "use references"));
        }
        let is_root = node.parent().is_some_and(|parent| parent.is_root());
        let known: &[&str] = match is_root {
            true => &["version!", "type", "id", "name"],
            false => &["type!", "id", "name"],
        };
        let attributes = self.attributes(node, known, &spot)?;
        let plugin = attributes.get("type").unwrap_or("scene").to_owned();
        let id = attributes.get("id").unwrap_or_default().to_owned();
        let index = self.tree.objects.len();
        let object = Object {
            tag,
            plugin,
            id: id.clone(),
            spot,
            properties: Vec::new(),
            children: Vec::new(),
        };
        if !id.is_empty()
            && let Some(other) = self.tree.ids.insert(id, index)
        {
            let first = self.tree.objects[other].label();
            let problem = format!("has the id of another: {first}");
            self.refuse(SceneError::new(object.label(), problem, "give each its own id"));
        }
        self.tree.objects.push(object);
        for child in node.children().filter(Node::is_element) {
            let read = self.child(child, index, source, depth);
            self.findings.note(read);
        }
        Ok(index)
    }

    /// Reads what is within an object.
    fn child(
        &mut self,
        node: Node,
        parent: usize,
        source: &Source,
        depth: usize,
    ) -> Result<(), SceneError> {
        let spot = source.spot(node);
        let element = node.tag_name().name();
        let is_object = Tag::of(element).is_some()
            && !(element == "spectrum" && node.attribute("type").is_none());
        if is_object {
            let object = self.object(node, source, depth + 1)?;
            let name = self.name_of_child(node, source)?;
            let child = Child { name, spot, target: Target::Object(object) };
            self.tree.objects[parent].children.push(child);
            return Ok(());
        }
        if element != "transform"
            && let Some(inner) = node.children().find(Node::is_element)
        {
            let problem = format!("<{}> cannot be in it", excerpt(inner.tag_name().name(), NAME));
            return Err(SceneError::new(format!("{spot}, {element}"), problem, ""));
        }
        match element {
            "ref" => {
                let attributes = self.attributes(node, &["id!", "name"], &spot)?;
                let name = old_name(attributes.get("name").unwrap_or_default(), source);
                let target = Target::Id(attributes.needed("id")?.to_owned());
                self.tree.objects[parent].children.push(Child { name, spot, target });
                Ok(())
            }
            "default" => {
                let attributes = self.attributes(node, &["name!", "value!"], &spot)?;
                let (name, value) = (attributes.needed("name")?, attributes.needed("value")?);
                if name.is_empty() {
                    return Err(attributes.wrong("name", "is empty", ""));
                }
                self.parameters.default(name, value);
                Ok(())
            }
            "alias" => self.alias(node, &spot),
            "include" => self.include(node, parent, source),
            "path" => {
                let attributes = self.attributes(node, &["value!"], &spot)?;
                let folder = PathBuf::from(attributes.needed("value")?);
                let beside = folder_of(&source.name).join(&folder);
                let is_there = self.files.has(&beside);
                self.paths.0.push(if is_there { beside } else { folder });
                Ok(())
            }
            _ => self.property(node, parent, source),
        }
    }

    fn name_of_child(&mut self, node: Node, source: &Source) -> Result<String, SceneError> {
        let name = node.attribute("name").unwrap_or_default();
        let put = self.parameters.put_into(name);
        let name = put.map_err(|problem| {
            SceneError::new(format!("{}, name", source.spot(node)), problem, "")
        })?;
        Ok(old_name(&name, source))
    }

    fn alias(&mut self, node: Node, spot: &Spot) -> Result<(), SceneError> {
        let attributes = self.attributes(node, &["id!", "as!"], spot)?;
        let (id, other) = (attributes.needed("id")?, attributes.needed("as")?);
        let Some(object) = self.tree.ids.get(id).copied() else {
            let problem = format!("no object before it has the id `{}`", excerpt(id, NAME));
            return Err(attributes.wrong("id", &problem, ""));
        };
        if self.tree.ids.insert(other.to_owned(), object).is_some() {
            let problem = format!("`{}` is the id of an object", excerpt(other, NAME));
            return Err(attributes.wrong("as", &problem, "use another"));
        }
        Ok(())
    }

    /// Reads another file in place of an element: what is within its scene, or its one object.
    fn include(&mut self, node: Node, parent: usize, source: &Source) -> Result<(), SceneError> {
        let spot = source.spot(node);
        let attributes = self.attributes(node, &["filename!", "name"], &spot)?;
        let place = format!("{spot}, include");
        self.includes += 1;
        if source.depth >= DEPTH_MAX || self.includes > INCLUDES_MAX {
            let problem = "too many files are included";
            return Err(SceneError::new(place, problem, "does a file include itself?"));
        }
        let name = attributes.needed("filename")?;
        let beside = folder_of(&source.name).join(name);
        let path = match self.files.has(&beside) {
            true => beside.to_string_lossy().into_owned(),
            false => self.paths.of(name, self.files),
        };
        let bytes = self.files.named(&path, &place, TEXT_MAX)?;
        let depth = source.depth + 1;
        let root = self.file(&bytes, &Source { name: path.into(), depth, ..Source::default() })?;
        if self.tree.objects[root].tag == Tag::Scene {
            let within = std::mem::take(&mut self.tree.objects[root].children);
            self.tree.objects[parent].children.extend(within);
        } else {
            let name = old_name(attributes.get("name").unwrap_or_default(), source);
            let child = Child { name, spot, target: Target::Object(root) };
            self.tree.objects[parent].children.push(child);
        }
        Ok(())
    }

    /// Reads a property of an object.
    fn property(&mut self, node: Node, parent: usize, source: &Source) -> Result<(), SceneError> {
        let spot = source.spot(node);
        let (name, value) = self.value(node, source, &spot)?;
        let name = old_name(&name, source);
        let object = &mut self.tree.objects[parent];
        if object.properties.iter().any(|property| property.name == name) {
            let place = format!("{spot}, {}, {}", object.tag.name(), excerpt(&name, NAME));
            return Err(SceneError::new(place, "is stated twice", "remove one of them"));
        }
        object.properties.push(Property { name, spot, value });
        Ok(())
    }

    fn value(
        &mut self,
        node: Node,
        source: &Source,
        spot: &Spot,
    ) -> Result<(String, Value), SceneError> {
        const PLAIN: &[&str] = &["name!", "value!"];
        let element = node.tag_name().name();
        let known: &[&str] = match element {
            "float" | "integer" | "boolean" | "string" | "rgb" => PLAIN,
            "vector" | "point" => &["name!", "value", "x", "y", "z"],
            "spectrum" => &["name!", "value", "filename"],
            "transform" => &["name!"],
            other => {
                let problem = format!("<{}> is not known here", excerpt(other, NAME));
                return Err(SceneError::new(spot.to_string(), problem, ""));
            }
        };
        let attributes = self.attributes(node, known, spot)?;
        let name = attributes.needed("name")?.to_owned();
        let text = attributes.get("value").unwrap_or_default();
        let place = || format!("{spot}, {element} {}", excerpt(&name, NAME));
        let wrong = |problem: String| SceneError::new(place(), problem, "");
        let value = match element {
            "float" => Value::Float(number(text).map_err(wrong)?),
            "integer" => {
                let number = text.trim().parse();
                let problem = || format!("`{}` is not an integer", excerpt(text, NAME));
                Value::Integer(number.map_err(|_| wrong(problem()))?)
            }
            "boolean" => match text.trim().to_ascii_lowercase().as_str() {
                "true" => Value::Boolean(true),
                "false" => Value::Boolean(false),
                _ => return Err(wrong("must be true or false".to_owned())),
            },
            "string" => Value::Text(text.to_owned()),
            "rgb" => match numbers(text).map_err(wrong)?[..] {
                [grey] => Value::Rgb([grey; 3]),
                [red, green, blue] => Value::Rgb([red, green, blue]),
                _ => return Err(wrong("must be one number, or three".to_owned())),
            },
            "vector" | "point" => Value::Vector(vector(&attributes, None).map_err(wrong)?),
            "spectrum" => self.spectrum(&attributes, source, &place())?,
            _ => {
                let mut steps = Vec::new();
                for step in node.children().filter(Node::is_element) {
                    let spot = source.spot(step);
                    const KNOWN: &[&str] =
                        &["value", "x", "y", "z", "angle", "origin", "target", "up"];
                    steps.push((step.tag_name().name(), self.attributes(step, KNOWN, &spot)?));
                }
                Value::Transform(transform(&steps)?)
            }
        };
        Ok((name, value))
    }

    fn spectrum(
        &self,
        attributes: &Attributes,
        source: &Source,
        place: &str,
    ) -> Result<Value, SceneError> {
        let wrong = |problem: String| SceneError::new(place, problem, "");
        match (attributes.get("value"), attributes.get("filename")) {
            (Some(text), None) => curve(text).map(Value::Spectrum).map_err(wrong),
            (None, Some(name)) => {
                let beside = folder_of(&source.name).join(name);
                let path = match self.files.has(&beside) {
                    true => beside.to_string_lossy().into_owned(),
                    false => self.paths.of(name, self.files),
                };
                let bytes = self.files.named(&path, place, TEXT_MAX)?;
                let text = String::from_utf8_lossy(&bytes);
                let curve = curve_of_lines(&text);
                curve.map(Value::Spectrum).map_err(|problem| {
                    SceneError::new(format!("{place}, {}", excerpt(name, NAME)), problem, "")
                })
            }
            (_, _) => {
                let remedy = "give it a `value` or a `filename`";
                Err(SceneError::new(place, "does not say what it is", remedy))
            }
        }
    }
}

/// The attributes of an element.
#[derive(Debug)]
pub struct Attributes {
    /// Where it stands, and its name.
    pub place: String,
    values: Vec<(String, String)>,
}

impl Attributes {
    /// One that may be there.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// One that must be there.
    pub fn needed(&self, name: &str) -> Result<&str, SceneError> {
        self.get(name).ok_or_else(|| self.wrong(name, "is missing", "add this attribute"))
    }

    /// The error that something is wrong with one.
    pub fn wrong(&self, name: &str, problem: &str, remedy: &str) -> SceneError {
        SceneError::new(format!("{}, {name}", self.place), problem, remedy)
    }
}

/// A vector out of `value`, or of `x`, `y` and `z`, which may be missing if there is a default.
pub fn vector(attributes: &Attributes, default: Option<f64>) -> Result<DVec3, String> {
    let parts = ["x", "y", "z"].map(|name| attributes.get(name));
    if let Some(text) = attributes.get("value") {
        if parts.iter().any(Option::is_some) {
            return Err("has a value, and x, y or z too".to_owned());
        }
        return match numbers(text)?[..] {
            [one] => Ok(DVec3::splat(one)),
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err("must be one number, or three".to_owned()),
        };
    }
    let mut vector = [0.0; 3];
    for ((to, part), name) in vector.iter_mut().zip(parts).zip(["x", "y", "z"]) {
        *to = match (part, default) {
            (Some(text), _) => number(text)?,
            (None, Some(default)) => default,
            (None, None) => return Err(format!("has no {name}")),
        };
    }
    Ok(DVec3::from(vector))
}

/// Whether a file is of a version whose names are written otherwise; refuses what is none.
fn is_old(root: Node, spot: &Spot) -> Result<bool, SceneError> {
    const REMEDY: &str = "write <scene version=\"3.0.0\">";
    let place = format!("{spot}, version");
    let Some(version) = root.attribute("version") else {
        return Err(SceneError::new(place, "is missing", REMEDY));
    };
    let major = version.split('.').next().and_then(|major| major.trim().parse::<u32>().ok());
    match major {
        Some(major @ 0..=3) => Ok(major < 2),
        Some(_) | None => {
            let problem = format!("`{}` is not known: 0 to 3 are", excerpt(version, NAME));
            Err(SceneError::new(place, problem, REMEDY))
        }
    }
}

/// A name as it is written since version 2: `toWorld` was `to_world`.
fn old_name(name: &str, source: &Source) -> String {
    if !source.is_old {
        return name.to_owned();
    }
    let mut new = String::new();
    let mut was_lower = false;
    for c in name.chars() {
        if was_lower && c.is_uppercase() {
            new.push('_');
        }
        was_lower = c.is_lowercase();
        new.extend(c.to_lowercase());
    }
    new
}

/// The folder of an included file.
fn folder_of(name: &str) -> &Path {
    Path::new(name).parent().unwrap_or(Path::new(""))
}
