//! Scene files of all formats: which one it is follows from the extension.

use std::path::{Path, PathBuf};

use super::error::SceneError;
use super::gltf::{Edit, GltfFile};
use super::mitsuba::MitsubaFile;
use super::view::View;
use super::world::{Asked, World};

/// What the files of Mitsuba 3 end in. All others are glTF.
const MITSUBA: &str = "xml";

/// How a scene file is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// What is seen of it.
    pub view: View,
    /// Whether it may read files outside its folder, as a stranger's scene should not.
    pub allow_outside: bool,
    /// Parameters of a Mitsuba scene and their values, in place of its own defaults.
    pub definitions: Vec<(String, String)>,
}

/// Loads a scene: the default one of a .gltf or .glb file, or that of an .xml file of Mitsuba 3,
/// seen by the first camera in it; by one that is put in if it has none, and under a neutral sky if
/// nothing emits ([`World::put_in`]).
///
/// # Errors
/// With the file's name, the object and field in it, and the remedy, whenever something in the
/// scene is missing, invalid, unphysical, or would silently render as something else.
pub fn load(path: &Path) -> Result<World, SceneError> {
    load_with(path, &Reading::default())
}

/// Like [`load`], with choices.
///
/// # Errors
/// As [`load`], and when there is no such camera or parameter, or nothing that moves in time.
pub fn load_with(path: &Path, reading: &Reading) -> Result<World, SceneError> {
    let Reading { view, allow_outside, definitions } = reading;
    SceneFile::read_with(path, *allow_outside, definitions)?.world(view, &[])
}

/// Like [`load`], from the contents of a file; `path` names it, and what it refers to lies beside
/// that.
///
/// # Errors
/// As [`load`].
pub fn load_from_memory(path: &Path, bytes: &[u8]) -> Result<World, SceneError> {
    let format = match is_of_mitsuba(path) {
        true => Format::Mitsuba(MitsubaFile::from_memory(path, bytes, false, &[])?),
        false => Format::Gltf(Box::new(GltfFile::from_memory(path, bytes)?)),
    };
    SceneFile { path: path.to_owned(), format }.world(&View::default(), &[])
}

/// Whether a path is that of a scene of Mitsuba 3.
pub fn is_of_mitsuba(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(MITSUBA))
}

/// A scene file that has been read, with its buffers: worlds are made of it, as it stands and after
/// edits. They share the meshes.
///
/// ```
/// use sunstone::{Edit, SceneFile, View};
///
/// let file = SceneFile::read("scenes/cornell.gltf".as_ref(), false)?;
/// let edits = [Edit::new("materials/white/reflectance", 0.2)];
/// let view = View::default();
/// let world = file.world(&view, &edits)?;
/// # assert!(world.find("white").is_some());
/// let error = file.world(&view, &[Edit::new("materials/snow/reflectance", 0.2)]);
/// let error = error.map(|_| ()).unwrap_err().to_string();
/// assert!(error.contains("materials/snow/reflectance: no material is called `snow`"), "{error}");
/// # Ok::<(), sunstone::SceneError>(())
/// ```
pub struct SceneFile {
    path: PathBuf,
    format: Format,
}

/// A file by its format.
enum Format {
    Gltf(Box<GltfFile>),
    Mitsuba(MitsubaFile),
}

impl SceneFile {
    /// Reads a scene file with its buffers, if need be (`allow_outside`) from outside its folder.
    ///
    /// # Errors
    /// When a file cannot be read, or is not of the format that its extension says.
    pub fn read(path: &Path, allow_outside: bool) -> Result<Self, SceneError> {
        Self::read_with(path, allow_outside, &[])
    }

    /// Like [`SceneFile::read`], with values of parameters of a Mitsuba scene.
    ///
    /// # Errors
    /// As [`SceneFile::read`], and when the scene has no such parameter.
    pub fn read_with(
        path: &Path,
        allow_outside: bool,
        definitions: &[(String, String)],
    ) -> Result<Self, SceneError> {
        let format = match is_of_mitsuba(path) {
            true => Format::Mitsuba(MitsubaFile::read(path, allow_outside, definitions)?),
            false => {
                if let Some((name, _)) = definitions.first() {
                    let problem = "glTF has no parameters";
                    let remedy = "they are .xml files'; `sunstone batch` edits glTF by name";
                    let place = format!("-D {name}");
                    return Err(SceneError::new(place, problem, remedy).in_file(path));
                }
                Format::Gltf(Box::new(GltfFile::read(path, allow_outside)?))
            }
        };
        Ok(Self { path: path.to_owned(), format })
    }

    /// The default scene after some edits, as it is seen.
    ///
    /// # Errors
    /// As [`load`], when there is no such camera, and when an edit is about nothing that is there:
    /// of scenes of Mitsuba, parameters alone are, as `define/NAME`.
    pub fn world(&self, view: &View, edits: &[Edit]) -> Result<World, SceneError> {
        let refuse = |rule| SceneError::new("time", rule, "leave it out").in_file(&self.path);
        view.check().map_err(refuse)?;
        match &self.format {
            Format::Gltf(file) => file.world(view, edits),
            Format::Mitsuba(file) => match edits {
                [] => file.world(&self.path, view),
                _ => file.redefined(&self.path, edits)?.world(&self.path, view),
            },
        }
    }

    /// How the scene asks to be rendered by a camera, after some edits, where nothing else is
    /// said; glTF asks for nothing.
    ///
    /// # Errors
    /// As [`SceneFile::world`], of what is looked at for that.
    pub fn asked(&self, view: &View, edits: &[Edit]) -> Result<Asked, SceneError> {
        match &self.format {
            Format::Gltf(_) => Ok(Asked::default()),
            Format::Mitsuba(file) => file.redefined(&self.path, edits)?.asked(view),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is edited by name; none of a format in which nothing is.
    pub(super) fn gltf(&self) -> Option<&GltfFile> {
        match &self.format {
            Format::Gltf(file) => Some(file),
            Format::Mitsuba(_) => None,
        }
    }
}

impl From<GltfFile> for SceneFile {
    fn from(file: GltfFile) -> Self {
        Self { path: file.path.clone(), format: Format::Gltf(Box::new(file)) }
    }
}

/// What edits of a parameter of a scene of Mitsuba begin with, before its name.
pub const DEFINE: &str = "define/";

/// The error that a scene is not edited by name.
pub fn not_edited(target: &str) -> SceneError {
    let remedy = "give it a parameter, <default name=\"...\" value=\"...\"/>, and set define/NAME, \
                  or use glTF";
    let problem = "scenes of Mitsuba cannot be edited by name, but for their parameters";
    SceneError::new(target, problem, remedy)
}
