//! A placed world: what is loaded or made, described and rendered.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sunstone::internals::render::doubts::doubts;
use sunstone::internals::scene::keys_of_kind;
use sunstone::{
    Edit, EditedFile, LightChoice, PlacedWorld, RenderError, Renderer, SceneError, SceneFile,
    Settings, StokesImage, Stop, View,
};

use crate::errors::{RENDER_ERROR, SCENE_ERROR, of_render, of_scene, of_settings, of_system};
use crate::image::{Parts, parts};
use crate::json::{edits, to_python};
use crate::options::{option, settings};
use crate::wait::wait_for;
use crate::words::in_python;

/// A world in its place, with its tree; it never changes.
#[pyclass(frozen, module = "sunstone._sunstone")]
pub struct Scene {
    placed: PlacedWorld,
    /// The file that it was read from.
    source: Option<Source>,
    users: Arc<Users>,
}

/// A file with what was edited, and what is seen of it.
#[derive(Clone)]
struct Source {
    file: EditedFile,
    view: View,
}

/// Who works with a scene. What they lock while they do is locked for ever in a process that is
/// forked meanwhile, where they do not exist.
#[derive(Default)]
struct Users {
    count: AtomicU32,
    process: AtomicU32,
}

/// One of them.
struct User(Arc<Users>);

impl User {
    /// Comes in, unless one is in who has been left behind in another process. The caller holds the
    /// interpreter's lock, as whoever forks does.
    fn enter(users: &Arc<Users>, _attached: Python) -> PyResult<Self> {
        let process = process::id();
        let is_inherited = users.count.load(Ordering::SeqCst) > 0
            && users.process.load(Ordering::SeqCst) != process;
        if is_inherited {
            return Err(RENDER_ERROR.says(
                "this process was forked while another thread rendered this scene, which is \
                 locked here since: load it anew",
            ));
        }
        users.process.store(process, Ordering::SeqCst);
        users.count.fetch_add(1, Ordering::SeqCst);
        Ok(Self(Arc::clone(users)))
    }
}

impl Drop for User {
    fn drop(&mut self) {
        self.0.count.fetch_sub(1, Ordering::SeqCst);
    }
}

/// What a render brings: an image with what there is to doubt about it.
struct Rendered {
    image: StokesImage,
    doubts: Vec<String>,
}

/// Loads a .gltf or .glb file, with edits, or an .xml file.
#[pyfunction]
pub fn load(
    py: Python,
    path: PathBuf,
    view: (Option<String>, String, Option<f64>),
    allow_outside: bool,
    define: Vec<(String, String)>,
    changes: &Bound<PyDict>,
) -> PyResult<Scene> {
    let (camera, light, time) = view;
    let lights = [LightChoice::Auto, LightChoice::None];
    let Some(light) = lights.into_iter().find(|known| known.name() == light) else {
        return Err(SCENE_ERROR.says("light is \"auto\" or \"none\""));
    };
    let view = View { camera, light, time };
    // The system's own word for a file that is not there, or may not be read.
    if let Err(error) = std::fs::File::open(&path) {
        return Err(of_system(&path, &error, format!("cannot read {}: {error}", path.display())));
    }
    let edits = edits(changes)?;
    let read = move || {
        let file = Arc::new(SceneFile::read_with(&path, allow_outside, &define)?);
        let file = EditedFile::new(file).edit(edits)?;
        let placed = PlacedWorld::new(file.world(&view)?)?;
        Ok(Scene { placed, source: Some(Source { file, view }), users: Arc::default() })
    };
    let nothing = Stop::default();
    let scene = wait_for(py, None, &nothing, |_| Ok(()), move |pool, _| pool.threads.run(read))?;
    scene.map_err(of_render)
}

#[pymethods]
impl Scene {
    /// What it is called.
    #[getter]
    fn name(&self) -> &str {
        self.placed.world().name()
    }

    /// The files it was read from.
    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.placed.world().files().to_vec()
    }

    /// What tells whether these files still hold what was read of them.
    #[getter]
    fn checksums(&self) -> Vec<String> {
        self.placed.world().checksums().iter().map(|sum| format!("{sum:032x}")).collect()
    }

    /// Whether the size of the film is edited.
    #[getter]
    fn has_film_size(&self) -> bool {
        let edits = self.source.iter().flat_map(|source| source.file.edits());
        edits.into_iter().any(Edit::is_of_film_size)
    }

    /// What of it is not rendered as it was described.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.placed.warnings().map(in_python).collect()
    }

    /// The same file with further edits.
    fn edit(&self, py: Python, changes: &Bound<PyDict>) -> PyResult<Self> {
        let edits = edits(changes)?;
        let edited = self.edited(py, move |file| file.edit(edits).map(Some))?;
        edited.ok_or_else(|| SCENE_ERROR.says("nothing has been edited"))
    }

    /// The same file without the edits of places and objects; none if there are no such edits.
    fn take_back(&self, py: Python, targets: Vec<String>) -> PyResult<Option<Self>> {
        self.edited(py, move |file| file.take_back(&targets))
    }

    /// The value of a place, and whether the file or an edit states it.
    fn value<'py>(
        &self,
        py: Python<'py>,
        target: &str,
    ) -> PyResult<(bool, Option<Bound<'py, PyAny>>)> {
        let value = self.source()?.file.value(target).map_err(of_scene)?;
        let is_stated = value.is_some();
        Ok((is_stated, value.map(|value| to_python(py, &value)).transpose()?))
    }

    /// What holds where the file does not state the value of a place, in words.
    fn default_of(&self, target: &str) -> PyResult<Option<String>> {
        Ok(self.source()?.file.default_of(target))
    }

    /// The objects that a name may mean, as KIND/NAME.
    fn objects(&self, name: &str) -> PyResult<Vec<String>> {
        self.source()?.file.objects(name).map_err(of_scene)
    }

    /// The edits that count.
    fn edits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let edits = PyDict::new(py);
        for edit in self.source()?.file.edits() {
            edits.set_item(&edit.target, to_python(py, &edit.value)?)?;
        }
        Ok(edits)
    }

    /// What is in it, in words.
    fn describe(&self, py: Python) -> PyResult<String> {
        let described = self.ask(py, None, |placed| {
            Ok::<_, SceneError>(placed.world().describe() + &placed.describe()?)
        })?;
        described.map(|text| in_python(&text)).map_err(of_scene)
    }

    /// Width and height of the film in pixels.
    fn film_size(&self, options: &Bound<PyDict>) -> PyResult<[u32; 2]> {
        self.placed.film_size(&self.settings(options)?.options()).map_err(of_settings)
    }

    /// What is to be known of a render before it begins.
    fn notes(&self, py: Python, options: &Bound<PyDict>) -> PyResult<Vec<String>> {
        let (settings, threads) = (self.settings(options)?, option(options, "threads")?);
        let notes = self.ask(py, threads, move |placed| placed.notes(&settings))?;
        notes.map(told).map_err(of_render)
    }

    /// Renders; returns the parts of the image and the doubts about it.
    fn render<'py>(
        &self,
        py: Python<'py>,
        options: &Bound<'py, PyDict>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(Parts<'py>, Vec<String>)> {
        let (settings, threads) = (self.settings(options)?, option(options, "threads")?);
        let (placed, stop) = (self.placed.clone(), Stop::default());
        let user = User::enter(&self.users, py)?;
        let is_heard = progress.is_some();
        let hear = |[done, total]: [u32; 2]| {
            let Some(progress) = &progress else { return Ok(()) };
            let answer = progress.call1((done, total))?;
            if answer.extract::<bool>().is_ok_and(|goes_on| !goes_on) {
                stop.stop();
            }
            Ok(())
        };
        let asked = stop.clone();
        let rendered = wait_for(py, threads, &stop, hear, move |pool, teller| {
            let _user = user;
            let renderer = pool.threads.run(|| Renderer::new(&placed, &settings))?;
            let lacks = pool.threads.run(|| placed.lacks(renderer.settings()))?;
            let renderer = renderer.on(&pool.threads).stopped_by(&asked);
            let tell = |progress| {
                if is_heard {
                    teller.tell(progress)
                }
            };
            Ok((lacks, render(renderer, &placed, &settings, tell)))
        })?;
        let (lacks, Rendered { image, doubts }) = rendered.map_err(of_render)?;
        Ok((parts(py, image)?, told(lacks.into_iter().chain(doubts))))
    }
}

impl Scene {
    /// A world in its place.
    pub fn of(placed: PlacedWorld) -> Self {
        Self { placed, source: None, users: Arc::default() }
    }

    fn settings(&self, options: &Bound<PyDict>) -> PyResult<Settings> {
        settings(options, self.placed.world().asked())
    }

    fn source(&self) -> PyResult<&Source> {
        let made = || SCENE_ERROR.says("the scene was made in code, and has no file");
        self.source.as_ref().ok_or_else(made)
    }

    /// The scene of a changed file, with the tree of this one if that is the same.
    fn edited(
        &self,
        py: Python,
        change: impl FnOnce(&EditedFile) -> Result<Option<EditedFile>, SceneError> + Send + 'static,
    ) -> PyResult<Option<Self>> {
        let Source { file, view } = self.source()?.clone();
        let edited = self.ask(py, None, move |placed| {
            let Some(file) = change(&file)? else { return Ok(None) };
            let placed = placed.beside(file.world(&view)?)?;
            Ok(Some((placed, Source { file, view })))
        })?;
        // They lock what they share, and so do those who use them.
        let of = |(placed, source)| Self {
            placed,
            source: Some(source),
            users: Arc::clone(&self.users),
        };
        Ok(edited.map_err(of_render)?.map(of))
    }

    /// A world that is made in code, with the tree of this one if that is the same.
    pub fn beside(&self, py: Python, world: sunstone::World) -> PyResult<Self> {
        let placed = self.ask(py, None, move |placed| placed.beside(world))?;
        let placed = placed.map_err(of_render)?;
        Ok(Self { placed, source: None, users: Arc::clone(&self.users) })
    }

    /// Asks the placed world something that takes threads.
    fn ask<T: Send + 'static>(
        &self,
        py: Python,
        threads: Option<usize>,
        question: impl FnOnce(&PlacedWorld) -> T + Send + 'static,
    ) -> PyResult<T> {
        let (placed, user) = (self.placed.clone(), User::enter(&self.users, py)?);
        wait_for(
            py,
            threads,
            &Stop::default(),
            |_| Ok(()),
            move |pool, _| {
                let _user = user;
                pool.threads.run(|| question(&placed))
            },
        )
    }
}

fn render(
    mut renderer: Renderer,
    placed: &PlacedWorld,
    settings: &Settings,
    tell: impl Fn([u32; 2]),
) -> Rendered {
    let start = Instant::now();
    renderer.run(|so_far| {
        tell([so_far.samples, so_far.total]);
        ControlFlow::Continue(())
    });
    let seconds = start.elapsed().as_secs_f64();
    let judged = doubts(&renderer, placed);
    let mut image = renderer.finish();
    if !settings.variance {
        image.variance = None;
    }
    let note = judged.note().map(str::to_owned);
    let doubts = note.into_iter().chain(judged.about(&image)).collect();
    let world = placed.world();
    let scene = match world.files().first() {
        Some(file) => file.display().to_string(),
        None => world.name().to_owned(),
    };
    let facts = [("scene", scene), ("seconds", format!("{seconds:.3}"))];
    image.metadata.splice(0..0, facts.map(|(key, value)| (key.to_owned(), value)));
    Rendered { image, doubts }
}

fn told(texts: impl IntoIterator<Item = String>) -> Vec<String> {
    texts.into_iter().map(|text| in_python(&text)).collect()
}

/// The keys that edits of a kind of objects may have.
#[pyfunction]
pub fn keys_of(kind: &str) -> Vec<&'static str> {
    keys_of_kind(kind).collect()
}

/// A world that is made in code, placed.
pub fn place(py: Python, world: sunstone::World) -> PyResult<Scene> {
    let placed: Result<PlacedWorld, RenderError> = wait_for(
        py,
        None,
        &Stop::default(),
        |_| Ok(()),
        move |pool, _| pool.threads.run(|| PlacedWorld::new(world)),
    )?;
    placed.map(Scene::of).map_err(of_render)
}
