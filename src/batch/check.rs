//! What a job file asks for, looked at before anything is rendered.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::file::{Job, JobFile, told};
use super::known;
use super::order::Order;
use super::reals::Reals;
use crate::image::{self, atomic};
use crate::math::text::excerpt;
use crate::render::{Part, SettingsError, check_part};
use crate::scene::{Edit, Editable, SceneError};

/// Most characters of a name in errors.
const NAME: usize = 60;

/// All that is wrong, each said once.
#[derive(Default)]
struct Wrong {
    list: Vec<Trouble>,
    /// The places of these by the number of the table of their jobs, and what they are about.
    seen: HashMap<(Option<usize>, String), usize>,
}

struct Trouble {
    /// The job, if it is of one.
    label: Option<String>,
    text: String,
    /// How many more of its sweep have it.
    more: usize,
}

impl Wrong {
    /// Something about the file.
    fn add(&mut self, text: String) {
        self.push(None, text.clone(), text);
    }

    /// Something about a job.
    fn of(&mut self, job: &Job, text: &str) {
        self.alike(job, text, text);
    }

    /// Something about a job that others of its sweep may have by other names.
    fn alike(&mut self, job: &Job, about: &str, text: &str) {
        self.push(Some(job), about.to_owned(), text.to_owned());
    }

    /// An option of a job: if it is a default, it is no matter of the job.
    fn of_option(&mut self, job: &Job, option: &WrongOption) {
        match &option.key {
            Some(key) if !job.table.own.contains(key) => {
                self.add(format!("defaults, {}", option.text));
            }
            Some(_) | None => self.of(job, &option.text),
        }
    }

    fn push(&mut self, job: Option<&Job>, about: String, text: String) {
        let key = (job.map(|job| job.table.number), about);
        match self.seen.get(&key) {
            Some(place) => self.list[*place].more += 1,
            None => {
                self.seen.insert(key, self.list.len());
                self.list.push(Trouble { label: job.map(Job::label), text, more: 0 });
            }
        }
    }

    /// The list, in words.
    fn list(self) -> Vec<String> {
        let words = |Trouble { label, text, more }| match (label, more) {
            (None, _) => text,
            (Some(label), 0) => told(&label, &text),
            (Some(label), more) => told(&format!("{label} and {more} more of its sweep"), &text),
        };
        self.list.into_iter().map(words).collect()
    }
}

/// What is wrong with an option, or with several together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrongOption {
    /// The option, if it is one.
    pub key: Option<String>,
    /// In words, with its name.
    pub text: String,
}

/// Which files must not be replaced.
pub struct Inputs<'a> {
    /// The job file.
    pub jobs: &'a Path,
    /// Where the results go.
    pub results: &'a Path,
    /// Parts of each image.
    pub parts: u32,
}

/// What reads the options of a job, which is in this folder, or says in words all that is wrong
/// with them.
pub type ReadOptions<'a> = &'a mut dyn FnMut(&Job, &Path) -> Result<Order, Vec<WrongOption>>;

/// The orders of a job file.
///
/// # Errors
/// In words, all that is wrong with them.
pub fn orders(
    file: &JobFile,
    inputs: &Inputs,
    allow_outside: bool,
    read: ReadOptions,
) -> Result<Vec<Order>, Vec<String>> {
    let mut wrong = Wrong::default();
    file.wrong.iter().for_each(|text| wrong.add(text.clone()));
    let mut orders = Vec::with_capacity(file.jobs.len());
    for job in &file.jobs {
        match read(job, &file.folder) {
            Ok(order) if job.is_whole => orders.push((job, order)),
            Ok(_) => {}
            Err(options) => options.iter().for_each(|option| wrong.of_option(job, option)),
        }
    }
    if inputs.parts != 1 {
        check_parts(&orders, inputs.parts, &mut wrong);
    }
    check_edits(file, &mut wrong);
    let mut reals = Reals::default();
    let taken = check_outputs(&orders, file, inputs, (allow_outside, &mut reals), &mut wrong);
    check_others(&orders, &taken, (file, inputs), (read, &mut reals), &mut wrong);
    let wrong = wrong.list();
    if wrong.is_empty() {
        return Ok(orders.into_iter().map(|(_, order)| order).collect());
    }
    Err(wrong)
}

/// Checks that every image has so many parts, whatever its scene.
fn check_parts(orders: &[(&Job, Order)], parts: u32, wrong: &mut Wrong) {
    let last = match Part::new(parts, parts) {
        Ok(last) => last,
        Err(_) => return wrong.add(format!("parts must be from 1 on, not {parts}")),
    };
    for (job, order) in orders {
        if let Err(SettingsError { setting, rule }) = check_part(&order.settings, last) {
            wrong.of(job, &format!("{setting} {rule}"));
        }
    }
}

/// Checks that edits are of something that is there, and have an effect. A scene that cannot be
/// read is told by the jobs that it is of.
fn check_edits(file: &JobFile, wrong: &mut Wrong) {
    let mut by_scene: BTreeMap<&str, Vec<&Job>> = BTreeMap::new();
    for job in file.jobs.iter().filter(|job| !job.edits.is_empty()) {
        if let Some(scene) = job.options.get("scene").and_then(Value::as_str) {
            by_scene.entry(scene).or_default().push(job);
        }
        if let Some(text) = without_effect(job) {
            wrong.of(job, &text);
        }
    }
    for (scene, jobs) in by_scene {
        let Ok(editable) = Editable::read(&file.folder.join(scene)) else { continue };
        let mut known: HashMap<Vec<(&str, Option<&str>)>, Vec<String>> = HashMap::new();
        for job in jobs {
            let key = job.edits.iter().map(|edit| (edit.target.as_str(), word(&edit.value)));
            let texts = known.entry(key.collect()).or_insert_with(|| found(&editable, &job.edits));
            texts.iter().for_each(|text| wrong.of(job, text));
        }
    }
}

/// What of a value decides whether edits go together.
fn word(value: &Value) -> Option<&str> {
    match value {
        Value::Null => Some(""),
        Value::String(word) => Some(word),
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => None,
    }
}

/// What is wrong with edits of one job, by themselves and together.
fn found(editable: &Editable, edits: &[Edit]) -> Vec<String> {
    let in_line = |error: SceneError| error.to_string().replace("\n  help: ", "; ");
    let alone = edits.iter().filter_map(|edit| editable.check(&edit.target).err());
    let alone: Vec<String> = alone.map(in_line).collect();
    if !alone.is_empty() {
        return alone;
    }
    editable.check_together(edits).err().map(in_line).into_iter().collect()
}

/// Says if the size of a film is edited that options state.
fn without_effect(job: &Job) -> Option<String> {
    let is_stated = |key: &str| job.options.get(key).is_some_and(|value| !value.is_null());
    if !["width", "height"].into_iter().all(is_stated) {
        return None;
    }
    let edit = job.edits.iter().find(|edit| edit.is_of_film_size())?;
    let target = excerpt(&edit.target, NAME);
    Some(format!("{target}: means nothing where `width` and `height` are given; leave one out"))
}

/// Checks that every output has a place of its own, in the folder of the job file unless others
/// are allowed, that can be written. Returns the files of the outputs with the places of their
/// orders.
fn check_outputs(
    orders: &[(&Job, Order)],
    file: &JobFile,
    inputs: &Inputs,
    (allow_outside, reals): (bool, &mut Reals),
    wrong: &mut Wrong,
) -> HashMap<PathBuf, usize> {
    let scenes: HashSet<&Path> = orders.iter().map(|(_, order)| &*order.scene).collect();
    let results = reals.of(inputs.results);
    if scenes.iter().copied().chain([inputs.jobs]).any(|path| reals.of(path) == results) {
        let path = inputs.results.display();
        wrong.add(format!("results would go over {path}, which the batch needs; name another"));
    }
    let needed = scenes.into_iter().chain([inputs.jobs, inputs.results]);
    let needed: HashSet<PathBuf> = needed.map(|path| reals.of(path)).collect();
    let home = (!allow_outside).then(|| reals.of(&file.folder.join("image")));
    let home = home.as_deref().and_then(Path::parent);
    let mut taken: HashMap<PathBuf, usize> = HashMap::new();
    let mut folders = Folders::default();
    for (row, (job, order)) in orders.iter().enumerate() {
        let Ok(files) = image::files_of(&order.output) else { continue };
        let mut why_not = |path: &PathBuf| {
            let path = reals.of(path);
            if home.is_some_and(|home| !path.starts_with(home)) {
                let text = "is outside of the folder of the job file; allow it by --allow-outside";
                return Some(format!(" {text}"));
            }
            if needed.contains(&path) {
                return Some(" is a file that the batch needs".to_owned());
            }
            if let Some(text) = folders.why_not(&path) {
                return Some(format!(": {text}"));
            }
            match taken.get(&path) {
                Some(other) if *other == row => None,
                Some(other) => {
                    let (job, other) = &orders[*other];
                    Some(twice(order, (job.index, other)))
                }
                None => {
                    taken.insert(path, row);
                    None
                }
            }
        };
        let why_not = std::iter::once(&order.output).chain(&files).find_map(&mut why_not);
        if let Some(text) = why_not {
            wrong.of(job, &format!("output {}{text}", order.output_name));
        }
    }
    check_folders(orders, &taken, wrong);
    taken
}

/// Checks that no output is to lie in what is the file of another.
fn check_folders(orders: &[(&Job, Order)], taken: &HashMap<PathBuf, usize>, wrong: &mut Wrong) {
    let within = |(path, row): (&PathBuf, &usize)| {
        let file = path.ancestors().skip(1).find_map(|folder| taken.get(folder))?;
        Some((*row, *file))
    };
    let mut found: Vec<(usize, usize)> = taken.iter().filter_map(within).collect();
    found.sort_unstable();
    for (row, file) in found {
        let (job, order) = &orders[row];
        let (other, image) = (orders[file].0, &orders[file].1.output_name);
        let text = format!(
            "output {} would be in a folder {image}, which is the image of job {} {}",
            order.output_name,
            other.index,
            other.label()
        );
        wrong.of(job, &text);
    }
}

/// Checks that no other job file that the results tell of asks for one of these outputs, unless
/// for the same image.
fn check_others(
    orders: &[(&Job, Order)],
    taken: &HashMap<PathBuf, usize>,
    (file, inputs): (&JobFile, &Inputs),
    (read, reals): (ReadOptions, &mut Reals),
    wrong: &mut Wrong,
) {
    let own = reals.of(inputs.jobs);
    for (name, outputs) in known::job_files(inputs.results) {
        let path = file.folder.join(&name);
        // What is not there any more has been renamed, or given up.
        if !path.is_file() || reals.of(&path) == own {
            continue;
        }
        let Ok(other) = JobFile::read(&path) else {
            // Somebody may be at work on it: what it has made is its own as long as it is there.
            let rows = outputs.iter().filter_map(|it| taken.get(&reals.of(&file.folder.join(it))));
            for (job, order) in rows.map(|row| &orders[*row]) {
                let text = format!(
                    "output {} was made for {name}, which cannot be read now: mend that, write \
                     into another folder, or remove or rename {name} if it is not needed any more",
                    order.output_name
                );
                wrong.alike(job, &name, &text);
            }
            continue;
        };
        for theirs in &other.jobs {
            let output = file.folder.join(&theirs.output);
            let files = image::files_of(&output).unwrap_or_default();
            let mut all = std::iter::once(&output).chain(&files);
            let Some(row) = all.find_map(|path| taken.get(&reals.of(path))) else { continue };
            let (job, order) = &orders[*row];
            let mut is_same = || read(theirs, &file.folder).is_ok_and(|it| it.key() == order.key());
            if !theirs.is_whole || is_same() {
                continue;
            }
            let text = format!(
                "output {} is that of {} in {name} too, which makes another image of it: write \
                 into another folder, or remove or rename {name} if it is not needed any more",
                order.output_name,
                theirs.label()
            );
            wrong.alike(job, &format!("{name} {}", theirs.table.number), &text);
        }
    }
}

/// What is said of a second job with an output: what tells it from the other.
fn twice(order: &Order, (index, other): (usize, &Order)) -> String {
    let differs = |(axis, value): &(&str, &Value)| other.values.get(axis) != Some(*value);
    let axes = order.values.iter().filter(differs);
    let axes: Vec<String> = axes.map(|(axis, _)| format!("{{{axis}}}")).collect();
    let advice = match (axes.is_empty(), order.name == other.name) {
        (false, _) => format!("{}, whole, or {{index}}", axes.join(" and ")),
        (true, true) => "{index}".to_owned(),
        (true, false) => "{name} or {index}".to_owned(),
    };
    format!(" is that of job {index} {} too; write {advice} into it", other.label())
}

/// Folders that have been written into for a test, and why not.
#[derive(Default)]
struct Folders(HashMap<PathBuf, Option<String>>);

impl Folders {
    /// Why a file cannot be written, if so.
    fn why_not(&mut self, path: &Path) -> Option<String> {
        if let Err(error) = atomic::probe_name(path) {
            return Some(error.to_string());
        }
        // Folders that are not there are made when there is something for them.
        let folder = path.ancestors().skip(1).find(|folder| fs::metadata(folder).is_ok())?;
        let probe = || atomic::probe_writable(&folder.join("image")).err().map(|it| it.to_string());
        self.0.entry(folder.to_owned()).or_insert_with(probe).clone()
    }
}
