//! The job file: a TOML file of defaults and jobs, or a job a line as JSON.
//!
//! Here it is unfolded into jobs, one for every combination of a sweep. What options and edits
//! mean is found out by others.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Number, Value};

use super::pattern::Pattern;
use super::sweep::{Axis, VALUES_MAX, unfold};
use super::unique::Unique;
use super::values::Values;
use crate::image::{extension, folder_of, read_bytes};
use crate::math::text::{excerpt, is_predicate};
use crate::scene::Edit;

/// Most bytes of a job file.
const BYTES_MAX: u64 = 1 << 30;
/// Most characters of a name in errors.
const NAME: usize = 60;
/// Keys of the file, and what a job may say beside options.
const KEYS: [&str; 4] = ["defaults", "farm", "jobs", "version"];
const KEYS_OF_FARM: [&str; 2] = ["parts", "tasks"];

/// The key of parameters of scenes of Mitsuba; the kind of their edits, too.
const DEFINE: &str = "define";

/// All that a file asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct JobFile {
    /// Where it is.
    pub path: PathBuf,
    /// What its paths are relative to.
    pub folder: PathBuf,
    /// The jobs in their order; of those that something is wrong with, what can be read.
    pub jobs: Vec<Job>,
    /// How a farm divides them.
    pub farm: Farm,
    /// In words, what is wrong with the file and its jobs, beside options and edits.
    pub wrong: Vec<String>,
}

/// How a farm divides a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Farm {
    /// Shares of the work, at least one.
    pub tasks: u32,
    /// Parts of each image, at least one.
    pub parts: u32,
}

/// One image.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Its place among all, from 0.
    pub index: usize,
    /// What it is called; jobs of a sweep share it.
    pub name: String,
    /// The table that it is of.
    pub table: Arc<Place>,
    /// Long options of `render`, with `_` for `-`; `scene` too. Those of the job and, beside them,
    /// the defaults.
    pub options: Map<String, Value>,
    /// Where the image goes, as the file has it.
    pub output: String,
    /// What is other than in the scene file.
    pub edits: Vec<Edit>,
    /// The values of the sweep, by the names of its axes.
    pub values: Values,
    /// Whether nothing was wrong with its table.
    pub is_whole: bool,
}

/// Where the table of a job is, and what it says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// Its place among all tables, from 0.
    pub number: usize,
    /// The line that it is, from 1, if the file has a job in each.
    pub line: Option<usize>,
    /// Whether it has a name of its own.
    pub is_named: bool,
    /// The options that it says itself, whatever the defaults are.
    pub own: BTreeSet<String>,
}

/// A table of the file that is one job or several.
type Table = Map<String, Value>;

impl JobFile {
    /// Reads a job file.
    ///
    /// # Errors
    /// In words, when nothing can be read of it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let cannot = |error: std::io::Error| format!("cannot read it: {error}");
        let bytes = read_bytes(path, BYTES_MAX).map_err(cannot)?;
        let text = String::from_utf8(bytes).map_err(|_| "is not text in UTF-8".to_owned())?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut wrong = Vec::new();
        let [mut defaults, mut farm] = [Table::new(), Table::new()];
        let tables = match extension(path).as_str() {
            "toml" => {
                let mut file = toml_table(text)?;
                defaults = table_of(&mut file, "defaults", &mut wrong);
                farm = table_of(&mut file, "farm", &mut wrong);
                tables_of(file, &mut wrong)
            }
            "jsonl" => lines_of(text, &mut wrong),
            _ => return Err("a job file ends in .toml or .jsonl".to_owned()),
        };
        for key in
            ["name", "set", "sweep", "unset"].into_iter().filter(|key| defaults.contains_key(*key))
        {
            wrong.push(format!("defaults: `{key}` belongs to a job"));
        }
        let farm = farm_of(&farm, &mut wrong);
        let mut jobs = Vec::new();
        for (number, (line, table)) in tables.into_iter().enumerate() {
            let (more, texts) = unfolded(&defaults, table, [number, jobs.len()], line);
            if jobs.len() + more.len() > VALUES_MAX {
                wrong.push(format!("asks for more than {VALUES_MAX} jobs"));
                break;
            }
            wrong.extend(texts.iter().map(|text| told(&more[0].label(), text)));
            jobs.extend(more);
        }
        if jobs.is_empty() && wrong.is_empty() {
            wrong.push("has no jobs; add a table [[jobs]]".to_owned());
        }
        Ok(Self { path: path.to_owned(), folder: folder_of(path), jobs, farm, wrong })
    }
}

fn toml_table(text: &str) -> Result<Table, String> {
    let table: toml::Table = toml::from_str(text).map_err(|error| error.to_string())?;
    match json_of(toml::Value::Table(table)).map_err(|error| format!("holds {error}"))? {
        Value::Object(table) => Ok(table),
        _ => Ok(Table::new()),
    }
}

/// The same as JSON, if JSON can say it.
fn json_of(value: toml::Value) -> Result<Value, String> {
    Ok(match value {
        toml::Value::String(text) => Value::String(text),
        toml::Value::Integer(number) => number.into(),
        toml::Value::Float(number) => Number::from_f64(number)
            .map(Value::Number)
            .ok_or_else(|| format!("the number {number}, which scenes and options do not take"))?,
        toml::Value::Boolean(is) => is.into(),
        toml::Value::Datetime(date) => return Err(format!("the date {date}: write it as a word")),
        toml::Value::Array(list) => list.into_iter().map(json_of).collect::<Result<_, _>>()?,
        toml::Value::Table(table) => {
            let json = |(key, value)| Ok::<_, String>((key, json_of(value)?));
            Value::Object(table.into_iter().map(json).collect::<Result<_, _>>()?)
        }
    })
}

/// A table of the file, empty if it is not there.
fn table_of(file: &mut Table, key: &str, wrong: &mut Vec<String>) -> Table {
    match file.remove(key) {
        Some(Value::Object(table)) => table,
        Some(_) => {
            wrong.push(format!("`{key}` is not a table: write [{key}]"));
            Table::new()
        }
        None => Table::new(),
    }
}

/// Tables of jobs, with the lines that they are if each is one.
type Tables = Vec<(Option<usize>, Table)>;

/// The tables of jobs in what is left of a TOML file.
fn tables_of(mut file: Table, wrong: &mut Vec<String>) -> Tables {
    match file.remove("version") {
        Some(version) if version.as_u64() == Some(1) => {}
        Some(version) => wrong.push(format!("version {version} is not known: this is version 1")),
        None => wrong.push("has no version; write `version = 1` at the top".to_owned()),
    }
    let tables = match file.remove("jobs") {
        Some(Value::Array(tables)) => tables,
        Some(_) => {
            wrong.push("`jobs` is not a list of tables: write [[jobs]]".to_owned());
            Vec::new()
        }
        None => Vec::new(),
    };
    for key in file.keys() {
        let (key, keys) = (excerpt(key, NAME), KEYS.join(", "));
        wrong.push(format!("`{key}` is not a key of a job file; keys are {keys}"));
    }
    let mut found = Vec::with_capacity(tables.len());
    for table in tables {
        match table {
            Value::Object(table) => found.push((None, table)),
            other => wrong.push(format!(
                "`jobs` holds {}, which is no table: write [[jobs]]",
                excerpt(&other.to_string(), NAME)
            )),
        }
    }
    found
}

/// The tables of jobs that stand in the lines of a text.
fn lines_of(text: &str, wrong: &mut Vec<String>) -> Tables {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        match serde_json::from_str(line).map(|Unique(value)| value) {
            Ok(Value::Object(table)) => found.push((Some(number), table)),
            Ok(_) => wrong.push(format!("line {number} is not an object")),
            Err(error) if error.is_data() => {
                let text = error.to_string();
                let text = text.split(" at line ").next().unwrap_or_default();
                wrong.push(format!("line {number}: {text}"));
            }
            Err(error) => wrong.push(format!("line {number} is not JSON: {error}")),
        }
    }
    found
}

fn farm_of(table: &Table, wrong: &mut Vec<String>) -> Farm {
    for key in table.keys().filter(|key| !KEYS_OF_FARM.contains(&key.as_str())) {
        let (key, keys) = (excerpt(key, NAME), KEYS_OF_FARM.join(", "));
        wrong.push(format!("farm: `{key}` is not known; keys are {keys}"));
    }
    let mut count = |key: &str| match table.get(key).map(Value::as_u64) {
        None => 1,
        Some(Some(count)) if (1..=VALUES_MAX as u64).contains(&count) => count as u32,
        Some(_) => {
            wrong.push(format!("farm: `{key}` must be a whole number from 1 to {VALUES_MAX}"));
            1
        }
    };
    Farm { tasks: count("tasks"), parts: count("parts") }
}

/// What a table says.
struct Asked {
    name: String,
    /// Options with the defaults.
    options: Table,
    /// Those that it says itself.
    own: BTreeSet<String>,
    /// Nothing if it cannot be read.
    output: Option<Pattern>,
    edits: Vec<Edit>,
    axes: Vec<Axis>,
}

/// The jobs of a table, at least one, and what is wrong with it; with the number of the table and
/// the index of its first job.
fn unfolded(
    defaults: &Table,
    mut table: Table,
    [number, first]: [usize; 2],
    line: Option<usize>,
) -> (Vec<Job>, Vec<String>) {
    let mut wrong = Vec::new();
    let is_named = table.get("name").is_some_and(Value::is_string);
    let Asked { name, options, own, output, edits, mut axes } =
        asked(defaults, &mut table, first, &mut wrong);
    let combinations = unfold(&axes).unwrap_or_else(|text| {
        wrong.push(format!("sweep: {text}"));
        axes.clear();
        vec![Vec::new()]
    });
    let place = Arc::new(Place { number, line, is_named, own });
    let short: Vec<Vec<Value>> = axes.iter().map(Axis::short_names).collect();
    let jobs = combinations.iter().zip(first..).map(|(indices, index)| {
        let mut job = Job {
            index,
            name: name.clone(),
            table: Arc::clone(&place),
            options: options.clone(),
            output: String::new(),
            edits: edits.clone(),
            values: Values::default(),
            is_whole: wrong.is_empty(),
        };
        let (mut in_names, mut in_short) = (Values::default(), Values::default());
        for ((axis, short), &at) in axes.iter().zip(&short).zip(indices) {
            job.set(&axis.key, axis.values[at].clone());
            job.values.insert(axis.name.clone(), axis.values[at].clone());
            in_names.insert(axis.name.clone(), axis.in_names(at));
            in_short.insert(axis.name.clone(), short[at].clone());
        }
        let own = Value::from(index);
        if job.options.get("seed").and_then(Value::as_str) == Some("job") {
            job.options.insert("seed".to_owned(), own.clone());
        }
        let (name, zero) = (Value::from(name.as_str()), Value::from(0));
        let filled = output.as_ref().map(|output| {
            output.fill(|field, is_rounded| match field {
                "name" => Some(&name),
                "index" => Some(&own),
                "seed" => Some(job.options.get("seed").unwrap_or(&zero)),
                axis if is_rounded => in_names.get(axis),
                axis => in_short.get(axis),
            })
        });
        job.output = filled.unwrap_or_default();
        job
    });
    (jobs.collect(), wrong)
}

/// What is wrong with jobs: of the key that it begins with, or of all of it.
pub fn told(label: &str, text: &str) -> String {
    let comma = if is_predicate(text) { "" } else { "," };
    format!("{label}{comma} {text}")
}

impl Job {
    /// How errors call it: by its index, and the line if it is one of the file's.
    pub fn label(&self) -> String {
        let Place { line, is_named, .. } = &*self.table;
        let line = line.map_or(String::new(), |line| format!("line {line}, "));
        let name = is_named.then(|| format!(" \"{}\"", excerpt(&self.name, NAME)));
        format!("{line}job {}{}", self.index, name.unwrap_or_default())
    }

    /// Sets an option, or adds an edit.
    fn set(&mut self, key: &str, value: Value) {
        match key.contains('/') {
            true => self.edits.push(Edit::new(key, value)),
            false => drop(self.options.insert(key.to_owned(), value)),
        }
    }
}

fn asked(defaults: &Table, table: &mut Table, first: usize, wrong: &mut Vec<String>) -> Asked {
    let name = match table.remove("name") {
        Some(Value::String(name)) => name,
        Some(_) => {
            wrong.push("`name` is not a word".to_owned());
            String::new()
        }
        None => format!("job{first}"),
    };
    let set = match table.remove("set") {
        Some(Value::Object(set)) => set,
        Some(_) => {
            wrong.push("`set` is not a table of edits".to_owned());
            Table::new()
        }
        None => Table::new(),
    };
    let unset = unset(table.remove("unset"), wrong);
    let mut defaults = defaults.clone();
    let common = definitions(defaults.remove(DEFINE), wrong);
    let define = definitions(table.remove(DEFINE), wrong);
    if let Some(key) = define.keys().find(|key| set.contains_key(*key)) {
        wrong.push(format!("`{}` is stated twice", excerpt(key, NAME)));
    }
    let set: Table = set.into_iter().chain(define).collect();
    let sweep = table.remove("sweep");
    let names = names_of_axes(sweep.as_ref());
    let axes = axes(sweep, wrong);
    let keys = set.keys().chain(&unset).chain(axes.iter().map(|axis| &axis.key));
    let mut own: BTreeSet<String> = table.keys().cloned().collect();
    for key in keys {
        if !own.insert(key.clone()) {
            wrong.push(format!("`{}` is stated twice", excerpt(key, NAME)));
        }
    }
    let mut options = defaults;
    options.append(table);
    let common = common.into_iter().filter(|(key, _)| !own.contains(key));
    let set: Table = common.chain(set).collect();
    let (edits, more): (Table, Table) = set.into_iter().partition(|(key, _)| key.contains('/'));
    options.extend(more);
    let edits = edits.into_iter().map(|(key, value)| Edit::new(key, value));
    let edits = edits.chain(unset.into_iter().map(Edit::away)).collect();
    let output = output(options.remove("output"), &names, wrong);
    Asked { name, options, own, output, edits, axes }
}

/// What axes are called, whatever else is wrong with them.
fn names_of_axes(sweep: Option<&Value>) -> Vec<String> {
    let axes = sweep.and_then(Value::as_array).into_iter().flatten();
    axes.filter_map(|axis| Some(axis.get("name")?.as_str()?.to_owned())).collect()
}

/// Parameters of a scene of Mitsuba, as edits of them.
fn definitions(define: Option<Value>, wrong: &mut Vec<String>) -> Table {
    match define {
        Some(Value::Object(define)) => {
            define.into_iter().map(|(name, value)| (format!("{DEFINE}/{name}"), value)).collect()
        }
        Some(_) => {
            wrong.push("`define` is not a table of parameters and their values".to_owned());
            Table::new()
        }
        None => Table::new(),
    }
}

/// What is taken away.
fn unset(unset: Option<Value>, wrong: &mut Vec<String>) -> Vec<String> {
    let target = |value: Value| match value {
        Value::String(target) if target.contains('/') => Some(target),
        _ => None,
    };
    let targets = match unset {
        Some(Value::Array(targets)) => targets.into_iter().map(target).collect(),
        Some(_) => None,
        None => Some(Vec::new()),
    };
    targets.unwrap_or_else(|| {
        wrong.push("`unset` is not a list of KIND/NAME/KEY".to_owned());
        Vec::new()
    })
}

fn axes(sweep: Option<Value>, wrong: &mut Vec<String>) -> Vec<Axis> {
    let tables = match sweep {
        Some(Value::Array(tables)) => tables,
        Some(_) => {
            wrong.push("`sweep` is not a list of axes".to_owned());
            return Vec::new();
        }
        None => return Vec::new(),
    };
    let mut axes: Vec<Axis> = Vec::new();
    for (number, table) in tables.iter().enumerate() {
        let called = match table.get("name").and_then(Value::as_str) {
            Some(name) => format!("\"{}\"", excerpt(name, NAME)),
            None => number.to_string(),
        };
        let mut refuse = |text: String| wrong.push(format!("sweep, axis {called}: {text}"));
        match Axis::parse(table) {
            Ok(axis) if axes.iter().any(|other| other.name == axis.name) => {
                refuse("another has this name".to_owned());
            }
            Ok(axis) if ["name", "index"].contains(&axis.name.as_str()) => {
                refuse(format!("{{{}}} means something else in names", axis.name));
            }
            Ok(axis) if (axis.name == "seed") != (axis.key == "seed") => {
                refuse("\"seed\" is the name of the axis of that key".to_owned());
            }
            Ok(axis) if axis.key == "output" => {
                refuse("`output` cannot be swept: write {NAME} of an axis into it".to_owned());
            }
            Ok(axis) if ["name", "set", "sweep"].contains(&axis.key.as_str()) => {
                refuse(format!("`{}` cannot be swept", axis.key));
            }
            Ok(axis) => axes.push(axis),
            Err(texts) => texts.into_iter().for_each(&mut refuse),
        }
    }
    axes
}

/// The name of the outputs, if its fields are those that there are.
fn output(output: Option<Value>, axes: &[String], wrong: &mut Vec<String>) -> Option<Pattern> {
    let text = match output {
        Some(Value::String(text)) => text,
        Some(_) => {
            wrong.push("`output` is not a path".to_owned());
            return None;
        }
        None => {
            wrong.push("has no `output`; write, say, output = \"out/{name}.exr\"".to_owned());
            return None;
        }
    };
    let pattern =
        Pattern::parse(&text).map_err(|text| wrong.push(format!("output: {text}"))).ok()?;
    let mut known = vec!["name", "index", "seed"];
    for axis in axes {
        if !known.contains(&axis.as_str()) {
            known.push(axis);
        }
    }
    for field in pattern.fields().filter(|field| !known.contains(field)) {
        let fields = known.iter().map(|name| format!("{{{name}}}")).collect::<Vec<_>>().join(", ");
        wrong
            .push(format!("output: {{{}}} is not known; there are {fields}", excerpt(field, NAME)));
    }
    Some(pattern)
}
