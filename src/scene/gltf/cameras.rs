//! The camera: which node's, how it projects, and its film.

use gltf::json::Root;
use gltf::json::camera::{Camera, Orthographic, Perspective, Type};
use gltf::json::validation::Checked;
use serde_json::{Value, json};

use super::Import;
use super::document::Document;
use super::extension::{ANALYZER, Body, CAMERA, FILM};
use super::hierarchy::PlacedNode;
use crate::film::filter::Filter;
use crate::math::text::excerpt;
use crate::polarization::Analyzer;
use crate::scene::error::SceneError;
use crate::scene::view::{Seer, View};
use crate::scene::world::{Film, Lens, Name, Raster, Resolution};

/// Most characters of a name in errors.
const NAME: usize = 60;

impl Import<'_> {
    /// Adds the camera that is wanted, or takes note that one is to be put in.
    pub fn add_camera(&mut self, nodes: &[PlacedNode], view: &View) -> Result<(), SceneError> {
        let (document, root) = (self.document, &self.document.root);
        let cameras: Vec<(&PlacedNode, usize)> = nodes
            .iter()
            .filter_map(|placed| Some((placed, root.nodes[placed.node].camera?.value())))
            .collect();
        let seer = |camera: &_| Seer { names: names(root, camera), number: camera.1 };
        let seers: Vec<Seer> = cameras.iter().map(seer).collect();
        let refuse = |(problem, remedy)| SceneError::new("nodes", problem, remedy);
        let Some(place) = view.camera_of(&seers).map_err(refuse)? else {
            self.wants_frame = true;
            return Ok(());
        };
        let (placed, camera) = cameras[place];
        let node = document.label("nodes", placed.node);
        let place = placed.to_world;
        Lens::check_place(&place).map_err(|fault| SceneError::at(&node, fault))?;
        let label = format!("{node}, {}", document.label("cameras", camera));
        let (body, lens, film) = read_camera(document, camera, &label)?;
        if let (Some(Resolution([width, height])), Some(aspect)) = (film.resolution, aspect(&lens))
            && (width as f32 * film.raster.pixel_aspect / height as f32 / aspect - 1.0).abs() > 0.01
        {
            let text = format!(
                "the film of {width} x {height} pixels does not have the camera's aspect ratio \
                 {aspect}: the film's counts, and what is seen from top to bottom is kept"
            );
            self.warnings.add_like("film", &label, &text);
        }
        let put = self.world.put_camera(Name(label), lens, place, film);
        put.map(|_| ()).map_err(|fault| body.place(fault))
    }
}

/// The keys of a camera, and what they mean.
pub type Read<'a> = (Body<'a>, Lens, Film);

/// What the file says of a camera: its projection and its film.
pub fn read_camera<'a>(
    document: &'a Document,
    index: usize,
    label: &str,
) -> Result<Read<'a>, SceneError> {
    let body = Body::of(&document.value["cameras"][index], label, &CAMERA)?;
    let lens = lens(&document.root.cameras[index], &body)?;
    let film = match body.object("film", &FILM)? {
        Some(film) => Film {
            resolution: resolution(&film)?,
            raster: raster(&film)?,
            analyzer: analyzer(&film)?,
        },
        None => Film::default(),
    };
    Ok((body, lens, film))
}

/// The names of a camera: its node's and its own.
fn names<'a>(root: &'a Root, (placed, camera): &(&PlacedNode, usize)) -> Vec<&'a str> {
    let names = [&root.nodes[placed.node].name, &root.cameras[*camera].name];
    names.into_iter().flatten().map(String::as_str).collect()
}

fn resolution(film: &Body) -> Result<Option<Resolution>, SceneError> {
    let Some(sides) = film.counts("resolution") else { return Ok(None) };
    Resolution::of(&sides).map(Some).map_err(|fault| film.place(fault))
}

/// How the film's pixels see.
fn raster(film: &Body) -> Result<Raster, SceneError> {
    let mut raster = Raster::default();
    if let Some(name) = film.word("filter")? {
        let kind = Raster::filter_of(name).map_err(|fault| film.place(fault))?;
        raster.filter = Filter::of(kind);
    }
    if let Some(radius) = film.number("filter_radius")? {
        raster.filter.radius = radius as f32;
    }
    if let Some(aspect) = film.number("pixel_aspect")? {
        raster.pixel_aspect = aspect as f32;
    }
    if let Some(ends) = film.numbers("crop")? {
        let pixel = |end: f64| (end.fract() == 0.0 && end >= 0.0).then_some(end as u32);
        let ends: Option<Vec<u32>> = ends.into_iter().map(pixel).collect();
        let Some(Ok(ends)) = ends.map(<[u32; 4]>::try_from) else {
            let problem = "must be [x0, y0, x1, y1], whole numbers of pixels";
            return Err(SceneError::new(film.field("crop"), problem, ""));
        };
        raster.crop = Some(ends);
    }
    Ok(raster)
}

/// What stands before the film, if anything does.
fn analyzer(film: &Body) -> Result<Option<Analyzer>, SceneError> {
    let Some(body) = film.object("analyzer", &ANALYZER)? else { return Ok(None) };
    let kinds = "kind is linear, with axis_deg, or right_circular, left_circular or none";
    let Some(kind) = body.word("kind")? else { return Err(body.missing("kind", kinds)) };
    let analyzer = match kind {
        "linear" => {
            let axis_deg = body.number("axis_deg")?.unwrap_or(0.0);
            return Ok(Some(Analyzer::Linear { axis_deg }));
        }
        "right_circular" => Some(Analyzer::RightCircular),
        "left_circular" => Some(Analyzer::LeftCircular),
        "none" => None,
        _ => {
            let problem = format!("`{}` is no analyzer", excerpt(kind, NAME));
            return Err(SceneError::new(body.field("kind"), problem, kinds));
        }
    };
    if body.has("axis_deg") {
        let problem = format!("an analyzer of kind {kind} has no axis");
        return Err(SceneError::new(body.field("axis_deg"), problem, "remove it"));
    }
    Ok(analyzer)
}

/// Width over height that the projection asks for.
fn aspect(lens: &Lens) -> Option<f32> {
    match *lens {
        Lens::Perspective { aspect, .. } => aspect,
        Lens::Orthographic { half_width, half_height } => Some(half_width / half_height),
    }
}

fn lens(camera: &Camera, body: &Body) -> Result<Lens, SceneError> {
    let lens = match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            perspective_lens(perspective, body)?
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            orthographic_lens(orthographic, body)?
        }
        _ => {
            let remedy = "type is perspective or orthographic, with an object of that name";
            return Err(SceneError::new(body.label(), "has no projection", remedy));
        }
    };
    lens.check().map_err(|fault| match fault.field.as_str() {
        "yfov" => SceneError::at(body.label(), fault),
        "aspect" => SceneError::at(body.label(), fault.of("aspectRatio")),
        "half_width" => SceneError::at(body.label(), fault.of("xmag")),
        "half_height" => SceneError::at(body.label(), fault.of("ymag")),
        _ => body.place(fault),
    })?;
    Ok(lens)
}

fn perspective_lens(camera: &Perspective, body: &Body) -> Result<Lens, SceneError> {
    let aperture = body.number("aperture_radius")?.unwrap_or(0.0);
    let focus = body.number("focus_distance")?;
    if aperture > 0.0 && focus.is_none() {
        let problem = "needs `focus_distance` too";
        return Err(SceneError::new(body.field("aperture_radius"), problem, "add it"));
    }
    Ok(Lens::Perspective {
        yfov: f64::from(camera.yfov),
        aspect: camera.aspect_ratio,
        aperture_radius: aperture as f32,
        focus_distance: focus.unwrap_or(1.0) as f32,
    })
}

fn orthographic_lens(camera: &Orthographic, body: &Body) -> Result<Lens, SceneError> {
    for key in ["aperture_radius", "focus_distance"] {
        if body.has(key) {
            let problem = "an orthographic camera has no lens";
            return Err(SceneError::new(body.field(key), problem, "remove it"));
        }
    }
    Ok(Lens::Orthographic { half_width: camera.xmag, half_height: camera.ymag })
}

/// How the pixels of a film see; nothing where they are as others.
pub fn written_film(Raster { filter, crop, pixel_aspect }: Raster) -> Value {
    let mut film = json!({});
    if filter != Filter::PIXEL {
        film["filter"] = json!(filter.kind.name());
        film["filter_radius"] = json!(filter.radius);
    }
    if let Some(ends) = crop {
        film["crop"] = json!(ends);
    }
    if pixel_aspect != 1.0 {
        film["pixel_aspect"] = json!(pixel_aspect);
    }
    film
}
