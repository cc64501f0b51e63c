//! The camera: which node's, how it projects, and its film.

use std::f32::consts::PI;

use gltf::json::camera::{Camera, Orthographic, Perspective, Type};
use gltf::json::validation::Checked;

use super::Import;
use super::extension::{Body, CAMERA, FILM, Range};
use super::hierarchy::{PlacedNode, is_orthogonal};
use crate::scene::error::SceneError;
use crate::scene::world::{Film, Lens, Transform};

impl Import<'_> {
    /// Adds the camera of the given name, or the first of the scene.
    pub fn add_camera(
        &mut self,
        nodes: &[PlacedNode],
        wanted: Option<&str>,
    ) -> Result<(), SceneError> {
        let document = self.document;
        let root = &document.root;
        let cameras: Vec<(&PlacedNode, usize)> = nodes
            .iter()
            .filter_map(|placed| Some((placed, root.nodes[placed.node].camera?.value())))
            .collect();
        let names = |placed: &PlacedNode, camera: usize| {
            let names = [&root.nodes[placed.node].name, &root.cameras[camera].name];
            names.into_iter().flatten()
        };
        let chosen = cameras.iter().find(|(placed, camera)| {
            wanted.is_none_or(|wanted| names(placed, *camera).any(|name| name == wanted))
        });
        let Some(&(placed, camera)) = chosen else {
            return Err(match wanted {
                None => SceneError::new("nodes", "the scene has no camera", "add one"),
                Some(wanted) => {
                    let known: Vec<&str> =
                        cameras.iter().flat_map(|(p, c)| names(p, *c)).map(|n| &**n).collect();
                    let remedy = format!("names of cameras: {}", known.join(", "));
                    SceneError::new("nodes", format!("no camera is called `{wanted}`"), remedy)
                }
            });
        };
        let node = document.label("nodes", placed.node);
        let to_world = placed.to_world;
        if !is_orthogonal(&to_world) || to_world.matrix3.determinant() < 0.0 {
            let problem = "the camera is sheared or mirrored";
            let remedy = "give it, and its parents, positive scales without rotation in between";
            return Err(SceneError::new(node, problem, remedy));
        }
        let label = format!("{node}, {}", document.label("cameras", camera));
        let body = Body::of(&document.value["cameras"][camera], &label, &CAMERA)?;
        let lens = lens(&root.cameras[camera], &body)?;
        let film = match body.object("film", &FILM)? {
            Some(film) => film.resolution("resolution")?,
            None => None,
        };
        if let (Some([width, height]), Some(aspect)) = (film, aspect(&lens))
            && (width as f32 / height as f32 / aspect - 1.0).abs() > 0.01
        {
            self.warn(format!(
                "{label}: the film of {width} x {height} pixels does not have the camera's \
                 aspect ratio {aspect}, so the picture is stretched"
            ));
        }
        let (order, name) = self.identity(label);
        let entity = self.entities.spawn((order, name, Transform(to_world), lens));
        if let Some(resolution) = film {
            // The entity has just been spawned, so this cannot fail.
            let _ = self.entities.insert_one(entity, Film { resolution });
        }
        Ok(())
    }
}

/// Width over height that the projection asks for.
fn aspect(lens: &Lens) -> Option<f32> {
    match *lens {
        Lens::Perspective { aspect, .. } => aspect,
        Lens::Orthographic { half_width, half_height } => Some(half_width / half_height),
    }
}

fn lens(camera: &Camera, body: &Body) -> Result<Lens, SceneError> {
    match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            perspective_lens(perspective, body)
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            orthographic_lens(orthographic, body)
        }
        _ => {
            let remedy = "type is perspective or orthographic, with an object of that name";
            Err(SceneError::new(body.label(), "has no projection", remedy))
        }
    }
}

fn perspective_lens(camera: &Perspective, body: &Body) -> Result<Lens, SceneError> {
    let label = body.label();
    if !(camera.yfov > 0.0 && camera.yfov < PI) {
        let problem = format!("{} must be greater than 0 and less than pi radians", camera.yfov);
        return Err(SceneError::new(format!("{label}, yfov"), problem, ""));
    }
    if let Some(aspect) = camera.aspect_ratio {
        Range::POSITIVE.check(f64::from(aspect), &format!("{label}, aspectRatio"))?;
    }
    let aperture = body.number("aperture_radius", Range::NOT_NEGATIVE)?.unwrap_or(0.0);
    let focus = body.number("focus_distance", Range::POSITIVE)?;
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
    let label = body.label();
    for key in ["aperture_radius", "focus_distance"] {
        if body.has(key) {
            let problem = "an orthographic camera has no lens";
            return Err(SceneError::new(body.field(key), problem, "remove it"));
        }
    }
    let half = |magnification: f32, field: &str| {
        Range::POSITIVE.check(f64::from(magnification), &format!("{label}, {field}"))
    };
    Ok(Lens::Orthographic {
        half_width: half(camera.xmag, "xmag")? as f32,
        half_height: half(camera.ymag, "ymag")? as f32,
    })
}
