//! Cameras and their films: the types of `<sensor>`.

use glam::{DAffine3, DVec3};
use hecs::Entity;

use super::Import;
use super::fields::Fields;
use super::tree::{NAME, Tag};
use crate::film::filter::{Filter, FilterKind};
use crate::math::elementary::{atan2, tan};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::view::{Seer, View};
use crate::scene::world::{Film, Lens, Name, Raster, Resolution, Transform};

/// Width and height of a film that does not say them.
const SIZE: [u32; 2] = [768, 576];
/// The filter of a film that has none.
const FILTER: Filter = Filter { kind: FilterKind::Gaussian, radius: 2.0 };

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
        let film = self.film(&fields)?;
        let resolution = film.resolution.unwrap_or(Resolution(SIZE));
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
        let put = self.world.put_camera(Name(fields.label()), lens, place, film);
        put.map(Some).map_err(|fault| {
            let name = if fault.field.is_empty() { "to_world" } else { "fov" };
            fields.wrong(name, fault.problem, fault.remedy)
        })
    }

    /// The film: its size, the part that is rendered, and the filter.
    fn film(&mut self, sensor: &Fields) -> Result<Film, SceneError> {
        let Some(object) = sensor.only(Tag::Film)? else {
            let raster = Raster { filter: FILTER, ..Raster::default() };
            return Ok(Film { resolution: Some(Resolution(SIZE)), raster, analyzer: None });
        };
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
        let crop = crop(&fields, size)?;
        let filter = self.filter(&fields)?;
        fields.finish()?;
        let resolution = Resolution(size);
        resolution.check().map_err(|fault| fields.fault(fault.of("width"), &[]))?;
        let raster = Raster { filter, crop, ..Raster::default() };
        raster.check(Some(resolution)).map_err(|fault| match fault.field.as_str() {
            "crop" => fields.wrong("crop_width", "the crop is not within the film", ""),
            _ => fields.fault(fault.of("the radius of rfilter"), &[]),
        })?;
        Ok(Film { resolution: Some(resolution), raster, analyzer: None })
    }

    /// The filter of the film's pixels.
    fn filter(&mut self, film: &Fields) -> Result<Filter, SceneError> {
        let Some(object) = film.only(Tag::Filter)? else { return Ok(FILTER) };
        let fields = Fields::of(self.tree, object);
        let plugin = fields.object.plugin.as_str();
        let Some(kind) = FilterKind::ALL.into_iter().find(|kind| kind.name() == plugin) else {
            let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
            let names = FilterKind::ALL.map(FilterKind::name).join(", ");
            return Err(fields.refuse(problem, format!("the types are {names}")));
        };
        let mut filter = Filter::of(kind);
        match kind {
            FilterKind::Tent => {
                filter.radius = fields.number("radius")?.map_or(filter.radius, |it| it as f32);
            }
            // Theirs ends at four standard deviations.
            FilterKind::Gaussian => {
                let deviation = fields.number("stddev")?;
                filter.radius = deviation.map_or(filter.radius, |it| (4.0 * it) as f32);
            }
            FilterKind::Mitchell => {
                for name in ["A", "B"] {
                    let is_other = |it: f64| (it - 1.0 / 3.0).abs() > 1e-3;
                    if fields.number(name)?.is_some_and(is_other) {
                        return Err(fields.wrong(name, "only 1/3 is supported", "remove it"));
                    }
                }
            }
            FilterKind::Lanczos => {
                let lobes = fields.count("lobes")?;
                if lobes.is_some_and(|lobes| lobes != 3) {
                    return Err(fields.wrong("lobes", "only 3 are supported", "remove it"));
                }
            }
            FilterKind::Box | FilterKind::CatmullRom => {}
        }
        fields.finish()?;
        Ok(filter)
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

/// The part of a film that is rendered, if it is not all: left, top, right, bottom.
fn crop(film: &Fields, size: [u32; 2]) -> Result<Option<[u32; 4]>, SceneError> {
    let [width, height] = [film.count("crop_width")?, film.count("crop_height")?];
    let [x, y] = [film.count("crop_offset_x")?, film.count("crop_offset_y")?];
    let [x, y] = [x.unwrap_or(0), y.unwrap_or(0)];
    let [width, height] = [width.unwrap_or(size[0]), height.unwrap_or(size[1])];
    let ends = [x, y, x.saturating_add(width), y.saturating_add(height)];
    Ok((ends != [0, 0, size[0], size[1]]).then_some(ends))
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
pub fn tan_half_x(fields: &Fields, aspect: f64) -> Result<f64, SceneError> {
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
