//! Options of jobs, by the names that `render` gives them: a table becomes a command line of
//! `render` and is read as one, so that every range and every message is the same.

use std::collections::HashMap;
use std::path::Path;

use clap::{ArgAction, Args, Command, FromArgMatches};
use serde_json::{Map, Value};

use crate::batch::check::WrongOption;
use crate::batch::file::Job;
use crate::batch::order::Order;
use crate::integrators::Integrator;
use crate::math::text::excerpt;
use crate::render::Settings;
use crate::scene::world::Asked;
use crate::scene::{Edit, SceneFile, View, is_of_mitsuba};

use super::super::args::{CheckpointArguments as Checkpoints, RenderArguments};
use super::super::files::FileArguments;
use super::super::{CliError, job, numbers_may_be_negative, view};

/// Options that mean nothing for a job of many, and why.
const REFUSED: [(&str, &str); 11] = [
    ("allow_outside", "only who starts the batch can say so: sunstone batch --allow-outside"),
    ("checkpoint", "a batch that was stopped does what is left when it is started again"),
    ("checkpoint_every", "a batch that was stopped does what is left when it is started again"),
    ("help", "try `sunstone help batch`"),
    ("part", "the job file has `parts` in [farm], for `sunstone batch --task`"),
    ("quiet", "it is an option of the batch"),
    ("resume", "a batch that was stopped does what is left when it is started again"),
    ("stats", "results.jsonl tells the time of each job"),
    ("tev", "a job is short: look at what is done"),
    ("threads", "it is an option of the batch: all jobs share them"),
    ("update", "a job is short: look at what is done"),
];
/// Options that shoot photons.
const OF_PHOTONS: [&str; 4] = ["alpha", "photons", "radius", "samples_per_iteration"];
/// Most tables of options that are remembered.
const KNOWN_MAX: usize = 1000;
/// Most characters of a name in errors.
const NAME: usize = 60;

/// Reads options, and remembers which are good.
pub struct Reader {
    render: Command,
    /// Whether jobs may read files outside of the folder of their file.
    allow_outside: bool,
    /// Pairs of options that exclude each other.
    rivals: Vec<[String; 2]>,
    /// What has been read, by its options.
    known: HashMap<String, Result<RenderArguments, Vec<WrongOption>>>,
    /// What scenes ask for, by their files, parameters and cameras.
    asked: HashMap<String, Asked>,
}

impl Reader {
    /// Knows the options of `render`.
    pub fn new(allow_outside: bool) -> Self {
        let render = RenderArguments::augment_args(Command::new("render"));
        let key = |arg: &clap::Arg| arg.get_long().map(|long| long.replace('-', "_"));
        let rivals = |arg| {
            let others = render.get_arg_conflicts_with(arg).into_iter();
            others.filter_map(move |other| Some([key(arg)?, key(other)?]))
        };
        let rivals = render.get_arguments().flat_map(rivals).collect();
        let render = numbers_may_be_negative(render);
        Self { render, allow_outside, rivals, known: HashMap::new(), asked: HashMap::new() }
    }

    /// A job whose options are good.
    ///
    /// # Errors
    /// In words, all that is wrong with them.
    pub fn order(&mut self, job: &Job, folder: &Path) -> Result<Order, Vec<WrongOption>> {
        let mut options = job.options.clone();
        options.retain(|key, _| job.table.own.contains(key) || !self.is_moot(key, job));
        // Jobs that differ in these alone need not be read one by one.
        let seed =
            options.get("seed").and_then(Value::as_u64).and_then(|it| u32::try_from(it).ok());
        if seed.is_some() {
            options.remove("seed");
        }
        let text = Value::Object(options.clone()).to_string();
        if !self.known.contains_key(&text) {
            if self.known.len() == KNOWN_MAX {
                self.known.clear();
            }
            let read = self.read(&options);
            self.known.insert(text.clone(), read);
        }
        let arguments = self.known[&text].as_ref().map_err(Vec::clone)?;
        let mut arguments = arguments.clone();
        // No dot before what lies in the current folder.
        let at = |path: &Path| match folder == Path::new(".") {
            true => path.to_owned(),
            false => folder.join(path),
        };
        arguments.output = at(job.output.as_ref());
        for file in arguments.color.files() {
            self.check_place(file, folder).map_err(together)?;
            *file = at(file.as_ref()).to_string_lossy().into_owned();
        }
        arguments.seed = seed.or(arguments.seed);
        let view = view::view(&arguments).map_err(|error| together(told(&error)))?;
        let scene = at(&arguments.scene);
        let asked = self.asked(&scene, &view, &job.edits);
        // What is wrong with the options is told without the scene's.
        settings(&arguments).map_err(together)?;
        let (arguments, asked) = job::with_asked(&arguments, &asked);
        let settings = settings(&arguments).map_err(together)?;
        let asked = asked.map(|text| in_words_of_the_file(&text));
        Ok(Order {
            index: job.index,
            name: job.name.clone(),
            values: job.values.clone(),
            scene,
            scene_name: arguments.scene,
            view,
            edits: job.edits.clone(),
            asked,
            settings,
            output: arguments.output,
            output_name: job.output.clone(),
        })
    }

    /// What a scene asks for. One that cannot be read asks for nothing; who renders it tells why.
    fn asked(&mut self, scene: &Path, view: &View, edits: &[Edit]) -> Asked {
        if !is_of_mitsuba(scene) {
            return Asked::default();
        }
        let edits_told: Vec<_> =
            edits.iter().map(|edit| (&edit.target, edit.value.to_string())).collect();
        let key = format!("{scene:?} {view:?} {edits_told:?}");
        if self.asked.len() == KNOWN_MAX {
            self.asked.clear();
        }
        let allow_outside = self.allow_outside;
        let read = || SceneFile::read(scene, allow_outside)?.asked(view, edits);
        *self.asked.entry(key).or_insert_with(|| read().unwrap_or_default())
    }

    /// Refuses a file to be read that is outside of the folder of the job file, unless that is
    /// allowed. One that is not there is told by whoever reads it.
    fn check_place(&self, file: &str, folder: &Path) -> Result<(), String> {
        let real = |path: &Path| path.canonicalize().ok();
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let (Some(path), Some(home)) = (real(&folder.join(file)), real(folder)) else {
            return Ok(());
        };
        if self.allow_outside || path.starts_with(home) {
            return Ok(());
        }
        let file = excerpt(file, NAME);
        Err(format!("{file} is outside of the folder of the job file; allow it by --allow-outside"))
    }

    /// Whether a default does not go with what the job says itself.
    fn is_moot(&self, default: &str, job: &Job) -> bool {
        let own = &job.table.own;
        let says = |key: &str| own.get(key).and_then(|_| job.options.get(key)?.as_str());
        let is_rival = |[one, two]: &[String; 2]| {
            (one == default && own.contains(two)) || (two == default && own.contains(one))
        };
        let shoots_none =
            |name: &str| Integrator::ALL.iter().any(|it| it.name() == name && !it.shoots_photons());
        self.rivals.iter().any(is_rival)
            || of_other_color(default, says("color"))
            || of_other_film(default, |key| own.contains(key))
            || (OF_PHOTONS.contains(&default) && says("integrator").is_some_and(shoots_none))
    }

    /// The options one by one, so that each is told that is wrong, and then together.
    fn read(&self, options: &Map<String, Value>) -> Result<RenderArguments, Vec<WrongOption>> {
        let mut wrong = Vec::new();
        let mut words = Vec::new();
        let mut scene = None;
        for (key, value) in options {
            let word = match (key.as_str(), value) {
                ("scene", Value::String(path)) if !path.is_empty() => {
                    scene = Some(path);
                    continue;
                }
                ("scene", _) => Err("is not the path of a scene".to_owned()),
                _ => self.word(key, value),
            };
            let alone = word.and_then(|word| {
                self.parse("scene", word.iter())?;
                Ok(word)
            });
            match alone {
                Ok(word) => words.extend(word),
                Err(text) => {
                    let text = format!("{}: {text}", excerpt(key, NAME));
                    wrong.push(WrongOption { key: Some(key.clone()), text });
                }
            }
        }
        if !options.contains_key("scene") {
            let text = "has no `scene`; write, say, scene = \"lab.gltf\"".to_owned();
            wrong.push(WrongOption { key: None, text });
        }
        match scene {
            Some(scene) if wrong.is_empty() => self.parse(scene, words.iter()).map_err(together),
            _ => Err(wrong),
        }
    }

    /// The word of a command line that an option is, if it has to be there at all.
    fn word(&self, key: &str, value: &Value) -> Result<Option<String>, String> {
        if let Some((_, why)) = REFUSED.iter().find(|(refused, _)| *refused == key) {
            return Err(format!("cannot be set for a job; {why}"));
        }
        let is_it = |arg: &&clap::Arg| {
            arg.get_long().is_some_and(|long| long.replace('-', "_") == key) && key != "output"
        };
        let Some(arg) = self.render.get_arguments().find(is_it) else {
            return Err(format!("is not an option; options are {}", self.names()));
        };
        let long = key.replace('_', "-");
        let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
        match value {
            Value::Bool(is) if is_flag => Ok(is.then(|| format!("--{long}"))),
            _ if is_flag => Err("is true or false".to_owned()),
            Value::Number(number) => Ok(Some(format!("--{long}={number}"))),
            Value::String(word) => Ok(Some(format!("--{long}={word}"))),
            Value::Null | Value::Bool(_) | Value::Array(_) | Value::Object(_) => {
                Err("takes one number or word".to_owned())
            }
        }
    }

    /// All options that jobs may have.
    fn names(&self) -> String {
        let longs = self.render.get_arguments().filter_map(|arg| arg.get_long());
        let names = longs
            .map(|long| long.replace('-', "_"))
            .filter(|name| name != "output" && REFUSED.iter().all(|(refused, _)| refused != name));
        let mut names: Vec<String> = std::iter::once("scene".to_owned()).chain(names).collect();
        names.sort();
        names.join(", ")
    }

    fn parse<'a>(
        &self,
        scene: &str,
        words: impl Iterator<Item = &'a String>,
    ) -> Result<RenderArguments, String> {
        // An output of every format; which it is to be has been looked at elsewhere.
        let fixed = ["render", "--output=x.exr"].map(str::to_owned);
        let last = ["--", scene].map(str::to_owned);
        let line = fixed.into_iter().chain(words.cloned()).chain(last);
        let matches = self.render.clone().try_get_matches_from(line);
        let arguments = matches.and_then(|matches| RenderArguments::from_arg_matches(&matches));
        arguments.map_err(|error| {
            let text = error.to_string();
            let text = text.strip_prefix("error: ").unwrap_or(&text);
            let end = ["\n\nUsage:", "\n\nFor more", "\n\n  tip:"];
            let end = end.iter().filter_map(|end| text.find(end)).min().unwrap_or(text.len());
            let lines = text[..end].lines().map(str::trim).filter(|line| !line.is_empty());
            in_words_of_the_file(&lines.collect::<Vec<_>>().join(" "))
        })
    }
}

/// Whether an option goes with another color than the one that is said.
fn of_other_color(option: &str, color: Option<&str>) -> bool {
    let own: &[&str] = match option {
        "wavelength" => &["mono"],
        "bands" | "range" | "raw_response" | "responses" | "wavelengths" | "white_balance" => {
            &["spectral"]
        }
        "rgb_white" => &["mono", "spectral"],
        _ => return false,
    };
    color.is_some_and(|color| !own.contains(&color))
}

/// Whether an option goes with other films than one of which the job says something.
fn of_other_film(option: &str, says: impl Fn(&str) -> bool) -> bool {
    match option {
        "white_balance" => says("bands") || says("raw_response"),
        "raw_response" => says("bands") || says("white_balance"),
        _ => false,
    }
}

/// What is wrong with several options.
fn together(text: String) -> Vec<WrongOption> {
    vec![WrongOption { key: None, text }]
}

/// What is rendered; refuses what only `render` does.
fn settings(arguments: &RenderArguments) -> Result<Settings, String> {
    // A new option of `render` has to be thought of here.
    let RenderArguments {
        scene: _,
        files: FileArguments { allow_outside: _, define: _ },
        output: _,
        integrator: _,
        mode: _,
        color: _,
        max_path_length: _,
        roulette_after: _,
        sampling: _,
        spp: _,
        iterations: _,
        time_limit: _,
        update: None,
        tev: None,
        seed: _,
        variance: _,
        replicates: _,
        photons: _,
        width: _,
        height: _,
        film: _,
        camera: _,
        light: _,
        time: _,
        threads: None,
        part: None,
        checkpoints: Checkpoints { checkpoint: None, checkpoint_every: None, resume: false },
        stats: None,
        quiet: false,
    } = arguments
    else {
        return Err("asks for what jobs cannot have".to_owned());
    };
    job::settings(arguments).map_err(|error| told(&error))
}

/// An error about options, which the file calls by other names.
fn told(error: &CliError) -> String {
    if let CliError::Usage(text) = error {
        return in_words_of_the_file(text);
    }
    error.to_string()
}

/// The same text, with options as the file calls them.
fn in_words_of_the_file(text: &str) -> String {
    let mut words = text.split("--");
    let mut told = words.next().unwrap_or_default().to_owned();
    for word in words {
        let end = word.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(word.len());
        told.push_str(&word[..end].replace('-', "_"));
        told.push_str(&word[end..]);
    }
    told
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use serde_json::json;

    use super::*;
    use crate::batch::file::Place;
    use crate::batch::values::Values;

    fn order(options: Value) -> Result<Order, String> {
        let Value::Object(options) = options else { panic!("{options} is no table") };
        let job = Job {
            index: 3,
            name: "a".to_owned(),
            table: Arc::default(),
            options,
            output: "a.exr".to_owned(),
            edits: Vec::new(),
            values: Values::default(),
            is_whole: true,
        };
        read(&job)
    }

    fn read(job: &Job) -> Result<Order, String> {
        let words = |wrong: Vec<WrongOption>| {
            wrong.into_iter().map(|it| it.text).collect::<Vec<_>>().join("\n")
        };
        Reader::new(false).order(job, Path::new("here")).map_err(words)
    }

    /// What a job says itself goes before defaults that do not go with it.
    #[test]
    fn a_default_gives_way_to_its_rival() {
        let settings = |defaults: Value, own: Value| {
            let (Value::Object(mut options), Value::Object(own)) = (defaults, own) else {
                panic!("no tables")
            };
            let table = Place { own: own.keys().cloned().collect(), ..Place::default() };
            options.extend(own);
            options.insert("scene".to_owned(), json!("a.gltf"));
            let job = Job {
                index: 0,
                name: String::new(),
                table: Arc::new(table),
                options,
                output: "a.exr".to_owned(),
                edits: Vec::new(),
                values: Values::default(),
                is_whole: true,
            };
            read(&job).map(|order| order.settings.options())
        };
        let other = settings(json!({"spp": 16}), json!({"iterations": 8})).unwrap();
        assert_eq!((other.samples, other.iterations), (64, Some(8)));
        let other = settings(json!({"iterations": 8}), json!({"spp": 16})).unwrap();
        assert_eq!((other.samples, other.iterations), (16, None));
        let mono = json!({"color": "mono", "wavelength": 633});
        assert!(settings(mono.clone(), json!({"color": "rgb"})).is_ok());
        assert!(settings(mono, json!({"wavelength": 550})).is_ok());
        let by_d65 = json!({"color": "mono", "rgb_white": "d65"});
        assert!(settings(by_d65, json!({"color": "rgb"})).is_ok());
        let ppm = json!({"integrator": "ppm", "photons": 1000, "alpha": 0.5, "radius": 1,
                         "samples_per_iteration": 3});
        assert!(settings(ppm.clone(), json!({"integrator": "path"})).is_ok());
        assert!(settings(ppm.clone(), json!({"integrator": "auto", "spp": 3})).is_ok());
        // What the job says itself is told when it is wrong.
        let both = settings(ppm, json!({"integrator": "path", "photons": 3})).map(|_| ());
        assert!(both.unwrap_err().contains("photons goes with integrator ppm"));
        let both = settings(json!({}), json!({"spp": 3, "iterations": 3})).map(|_| ());
        assert!(both.unwrap_err().contains("cannot be used with"));
    }

    #[test]
    fn options_are_those_of_render() {
        let options = json!({
            "scene": "-lab.gltf", "integrator": "path", "spp": 8, "seed": 7, "width": 32,
            "max_path_length": 4, "variance": true, "color": "mono", "wavelength": 633.0,
        });
        let order = order(options).unwrap();
        assert_eq!(order.scene, Path::new("here/-lab.gltf"));
        let options = order.settings.options();
        assert_eq!((options.samples, options.seed, options.width), (8, 7, Some(32)));
        assert!(options.variance && options.path_length_max == 4);
    }

    #[test]
    fn what_is_wrong_is_said_by_its_key() {
        for (options, words) in [
            (json!({}), "has no `scene`"),
            (json!({"scene": "a", "sp": 3}), "sp: is not an option; options are alpha, bands"),
            (json!({"scene": "a", "spp": -3}), "spp: invalid value '-3' for 'spp <N>'"),
            (json!({"scene": "a", "spp": 0}), "spp must be from 1 to"),
            (json!({"scene": "a", "spp": 4, "iterations": 4}), "cannot be used with"),
            (json!({"scene": "a", "variance": 1}), "variance: is true or false"),
            (json!({"scene": "a", "spp": [1]}), "takes one number or word"),
            (json!({"scene": "a", "threads": 1}), "threads: cannot be set for a job"),
            (json!({"scene": "a", "allow_outside": true}), "only who starts the batch"),
            (json!({"scene": "a", "max_path_length": 0}), "max_path_length must be from 1"),
            (json!({"scene": "a", "mode": "x"}), "[possible values: scalar, intensity, polarized]"),
            (json!({"scene": 3}), "scene: is not the path"),
        ] {
            let error = order(options.clone()).map(|_| ()).unwrap_err();
            assert!(error.contains(words) && !error.contains("'--"), "{options}: {error}");
        }
        let both = order(json!({"scene": "a", "x": 1, "mode": "y"})).map(|_| ()).unwrap_err();
        assert_eq!(both.lines().count(), 2, "{both}");
    }
}
