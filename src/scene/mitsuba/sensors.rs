//! Cameras and their films: the types of `<sensor>`.

use glam::{DAffine3, DVec3};
use hecs::Entity;

use super::Import;
use super::fields::Fields;
use super::tree::{NAME, Tag};
use crate::math::elementary::{atan2, tan};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::view::{Seer, View};
use crate::scene::world::{Lens, Name, Resolution, Transform};

/// The projections, by type.
const TYPES: [(&str, Projection); 3] = [
    ("orthographic", Projection::Orthographic),
    ("perspective", Projection::Pinhole),
    ("thinlens", Projection::ThinLens),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Projection {
    Orthographic,
    Pinhole,
    ThinLens,
}

impl Import<'_> {
    /// Adds the camera that is wanted; none if one is to be put in.
    pub fn add_camera(
        &mut self,
        sensors: &[usize],
        view: &View,
    ) -> Result<Option<Entity>, SceneError> {
        let seer = |(number, sensor): (usize, &usize)| {
            let id = self.tree.objects[*sensor].id.as_str();
            Seer { names: Some(id).filter(|id| !id.is_empty()).into_iter().collect(), number }
        };
        let seers: Vec<Seer> = sensors.iter().enumerate().map(seer).collect();
        let refuse = |(problem, remedy)| SceneError::new("scene", problem, remedy);
        let Some(place) = view.camera_of(&seers).map_err(refuse)? else {
            // What fills the scene does so whoever sees it.
            if let Some(first) = sensors.first() {
                self.medium_of_camera(&Fields::of(self.tree, *first))?;
            }
            return Ok(None);
        };
        let fields = Fields::of(self.tree, sensors[place]);
        let plugin = fields.object.plugin.as_str();
        let Some((_, projection)) = TYPES.iter().find(|(name, _)| *name == plugin) else {
            let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
            let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
            return Err(fields.refuse(problem, format!("the types are {}", names.join(", "))));
        };
        let resolution = self.film(&fields)?;
        self.sampler(&fields)?;
        self.medium_of_camera(&fields)?;
        // There is no motion, and nothing before or behind the scene to be cut off.
        fields.ignore(&["shutter_open", "shutter_close"]);
        for name in ["near_clip", "far_clip"] {
            if fields.number(name)?.is_some() {
                let text = "near_clip and far_clip are ignored: everything is seen";
                self.warnings.add(&fields.label(), text);
            }
        }
        for name in ["principal_point_offset_x", "principal_point_offset_y"] {
            if fields.number(name)?.is_some_and(|offset| offset != 0.0) {
                return Err(fields.wrong(name, "only 0 is supported", "remove it"));
            }
        }
        let to_world = fields.transform("to_world")?;
        let focus = fields.number("focus_distance")?;
        let (lens, place) = match projection {
            Projection::Orthographic => orthographic(&fields, to_world, resolution)?,
            Projection::Pinhole => (perspective(&fields, resolution, (0.0, 1.0))?, to_world),
            Projection::ThinLens => {
                let Some(radius) = fields.number("aperture_radius")? else {
                    return Err(fields.wrong("aperture_radius", "is missing", "add it"));
                };
                let Some(focus) = focus else {
                    return Err(fields.wrong("focus_distance", "is missing", "add it"));
                };
                (perspective(&fields, resolution, (radius as f32, focus as f32))?, to_world)
            }
        };
        fields.finish()?;
        // Theirs look along z, with x to the left.
        let place = Transform(place * DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0)));
        let film = (Some(resolution), None);
        let put = self.world.put_camera(Name(fields.label()), lens, place, film);
        put.map(Some).map_err(|fault| {
            let name = if fault.field.is_empty() { "to_world" } else { "fov" };
            fields.wrong(name, fault.problem, fault.remedy)
        })
    }

    /// The size of the film.
    fn film(&mut self, sensor: &Fields) -> Result<Resolution, SceneError> {
        const SIZE: [u32; 2] = [768, 576];
        let Some(object) = sensor.only(Tag::Film)? else { return Ok(Resolution(SIZE)) };
        let fields = Fields::of(self.tree, object);
        if fields.object.plugin != "hdrfilm" {
            let problem = format!("`{}` is not supported", excerpt(&fields.object.plugin, NAME));
            return Err(fields.refuse(problem, "the only type is hdrfilm; colors are --color's"));
        }
        let mut size = SIZE;
        for (side, name) in size.iter_mut().zip(["width", "height"]) {
            *side = fields.count(name)?.unwrap_or(*side);
        }
        // Formats are those of the output's name.
        fields.ignore(&["file_format", "pixel_format", "component_format", "banner"]);
        fields.ignore(&["compensate", "sample_border"]);
        let crop = [("crop_width", size[0]), ("crop_height", size[1])];
        let crop = crop.into_iter().chain([("crop_offset_x", 0), ("crop_offset_y", 0)]);
        for (name, whole) in crop {
            if fields.count(name)?.is_some_and(|value| value != whole) {
                return Err(fields.wrong(name, "windows are not supported", "remove it"));
            }
        }
        self.filter(&fields)?;
        fields.finish()?;
        let resolution = Resolution(size);
        resolution.check().map_err(|fault| fields.fault(fault.of("width"), &[]))?;
        Ok(resolution)
    }

    /// Says that pixels are not filtered as the film asks for.
    fn filter(&mut self, film: &Fields) -> Result<(), SceneError> {
        let filter = film.only(Tag::Filter)?;
        if let Some(filter) = filter
            && self.tree.objects[filter].plugin == "box"
        {
            return Fields::of(self.tree, filter).finish();
        }
        let text = "pixels are means over their squares: the filter is ignored";
        let label = filter.map_or_else(|| film.label(), |filter| self.tree.objects[filter].label());
        self.warnings.add(&label, text);
        Ok(())
    }

    /// Samples per pixel and seed, as defaults of the command line.
    fn sampler(&mut self, sensor: &Fields) -> Result<(), SceneError> {
        let Some(object) = sensor.only(Tag::Sampler)? else { return Ok(()) };
        let fields = Fields::of(self.tree, object);
        // Ours is the same for all.
        fields.ignore(&["jitter"]);
        self.world.asked.samples = fields.count("sample_count")?;
        self.world.asked.seed = fields.count("seed")?;
        fields.finish()
    }

    /// The medium that a camera is in fills the scene, unless it is within a shape.
    fn medium_of_camera(&mut self, sensor: &Fields) -> Result<(), SceneError> {
        let Some(object) = sensor.only(Tag::Medium)? else { return Ok(()) };
        let is_inside = self.tree.objects.iter().filter(|it| it.tag == Tag::Shape).any(|shape| {
            let mut children = shape.children.iter();
            children.any(|it| it.name == "interior" && super::fields::object_of(it) == Some(object))
        });
        if is_inside {
            return Ok(());
        }
        let medium = self.medium(object)?;
        self.world.set_scene_medium(medium)
    }
}

/// A pinhole or thin lens of some radius and distance in focus.
fn perspective(
    fields: &Fields,
    Resolution([width, height]): Resolution,
    (aperture_radius, focus_distance): (f32, f32),
) -> Result<Lens, SceneError> {
    let aspect = f64::from(width) / f64::from(height);
    let tan_half_y = tan_half_x(fields, aspect)? / aspect;
    let yfov = 2.0 * atan2(tan_half_y, 1.0);
    Ok(Lens::Perspective { yfov, aspect: Some(aspect as f32), aperture_radius, focus_distance })
}

/// Tangent of half the horizontal angle of view.
fn tan_half_x(fields: &Fields, aspect: f64) -> Result<f64, SceneError> {
    /// Half the diagonal of a film of 36 by 24 mm.
    const HALF_DIAGONAL_MM: f64 = 21.633_307_652_783_937;
    let of_diagonal = |tangent: f64| tangent / (1.0 + 1.0 / (aspect * aspect)).sqrt();
    let axis = fields.text("fov_axis")?.unwrap_or("x").to_ascii_lowercase();
    let length = fields.text("focal_length")?;
    let Some(fov) = fields.number("fov")? else {
        let text = length.unwrap_or("50mm");
        let mm = super::text::number(text.strip_suffix("mm").unwrap_or(text));
        let mm = mm.map_err(|problem| fields.wrong("focal_length", problem, "write it as 50mm"))?;
        return Ok(of_diagonal(HALF_DIAGONAL_MM / mm));
    };
    if length.is_some() {
        return Err(fields.wrong("focal_length", "contradicts `fov`", "keep one of them"));
    }
    if !(fov > 0.0 && fov < 180.0) {
        let problem = format!("{fov} must be greater than 0 and less than 180 degrees");
        return Err(fields.wrong("fov", problem, ""));
    }
    let tangent = tan(0.5 * fov.to_radians());
    let is_wide = aspect > 1.0;
    match (axis.as_str(), is_wide) {
        ("x", _) | ("smaller", false) | ("larger", true) => Ok(tangent),
        ("y", _) | ("smaller", true) | ("larger", false) => Ok(tangent * aspect),
        ("diagonal", _) => Ok(of_diagonal(tangent)),
        (_, _) => {
            let remedy = "use x, y, diagonal, smaller or larger";
            Err(fields.wrong("fov_axis", "is no axis", remedy))
        }
    }
}

/// A parallel projection, and its place without scale.
fn orthographic(
    fields: &Fields,
    to_world: DAffine3,
    Resolution([width, height]): Resolution,
) -> Result<(Lens, DAffine3), SceneError> {
    let aspect = f64::from(width) / f64::from(height);
    let matrix = to_world.matrix3;
    let lengths = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length);
    if lengths.contains(&0.0) {
        return Err(fields.wrong("to_world", "its transform is singular", "use a scale"));
    }
    let place = to_world * DAffine3::from_scale(DVec3::from(lengths).recip());
    let half_width = lengths[0] as f32;
    let half_height = (lengths[1] / aspect) as f32;
    Ok((Lens::Orthographic { half_width, half_height }, place))
}
