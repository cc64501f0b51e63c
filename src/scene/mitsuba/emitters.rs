//! Lights: the types of `<emitter>`.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use hecs::Entity;

use super::Import;
use super::fields::Fields;
use super::sensors::tan_half_x;
use super::spectra::Kind;
use super::textures::{Use, Wanted};
use super::transforms::{looking, perpendicular};
use super::tree::{NAME, Tag};
use crate::image::texels::{Coding, Texels};
use crate::math::elementary::{atan2, cbrt};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{
    Backdrop, BackdropSource, Emission, Environment, Falloff, Filter, Name, Picture, Projection,
    Punctual, PunctualKind, Texture, Transform, Wrap, half_hash,
};
use crate::spectrum::Spectrum;

/// What shapes may have; the others stand by themselves.
const OF_SHAPES: &str = "area";

/// What reads a type, and adds it.
type Add = fn(&mut Import, &Fields) -> Result<(), SceneError>;

/// The lights that are no shape's, by type.
const TYPES: [(&str, Add); 6] = [
    ("constant", constant),
    ("directional", directional),
    ("envmap", envmap),
    ("point", point),
    ("projector", projector),
    ("spot", spot),
];

/// The emission of a shape, and a picture of it.
pub fn area(fields: &Fields) -> Result<(Emission, Option<Wanted>), SceneError> {
    if fields.object.plugin != OF_SHAPES {
        let problem = "is not the light of a shape";
        return Err(fields.refuse(problem, "use an area emitter, or move it out of the shape"));
    }
    let wanted = fields.wanted("radiance", Use::Radiance);
    let radiance = match &wanted {
        Some(_) => Spectrum::Rgb([1.0; 3]),
        None => fields.spectrum_or("radiance", Kind::Emission, 1.0)?,
    };
    fields.ignore(&["sampling_weight"]);
    let emission = Emission { radiance };
    emission.check().map_err(|fault| fields.fault(fault, &[]))?;
    fields.finish()?;
    Ok((emission, wanted))
}

impl Import<'_> {
    /// Adds a light that is no shape's. One of a shape is looked at where that is.
    pub fn add_emitter(&mut self, object: usize) -> Result<(), SceneError> {
        let fields = Fields::of(self.tree, object);
        let plugin = fields.object.plugin.as_str();
        if plugin == OF_SHAPES {
            return Ok(());
        }
        let Some((_, add)) = TYPES.iter().find(|(name, _)| *name == plugin) else {
            let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
            let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
            let remedy = format!("the types are {OF_SHAPES}, {}", names.join(", "));
            return Err(fields.refuse(problem, remedy));
        };
        fields.ignore(&["sampling_weight"]);
        // Which medium a light is in follows from where it is.
        fields.objects(Tag::Medium);
        add(self, &fields)?;
        fields.finish()
    }

    /// Adds what is around the scene, of which there is one.
    fn put_sky(&mut self, fields: &Fields, sky: Environment) -> Result<(), SceneError> {
        if self.has_environment {
            let remedy = "keep one of them";
            return Err(fields.refuse("is a second environment", remedy));
        }
        self.has_environment = true;
        sky.check().map_err(|fault| fields.fault(fault, &[("radiance", "scale")]))?;
        if sky.mean().values().iter().all(|value| *value == 0.0) {
            return Ok(());
        }
        let put = self.world.put_environment(Name(fields.label()), sky);
        put.map(|_| ()).map_err(|fault| fields.fault(fault, &[]))
    }

    /// Adds a light; `z` is where it shines to in its own space.
    fn put(
        &mut self,
        fields: &Fields,
        light: Punctual,
        place: DAffine3,
    ) -> Result<Entity, SceneError> {
        // Ours shine along -z.
        let turned = DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0));
        let put = self.world.put_light(Name(fields.label()), light, Transform(place * turned));
        put.map_err(|fault| fields.fault(fault, &[]))
    }
}

fn constant(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let radiance = fields.spectrum_or("radiance", Kind::Emission, 1.0)?;
    fields.ignore(&["to_world"]);
    import.put_sky(fields, Environment::constant(radiance))
}

/// Its picture shows -z at its left edge, and +x right of that.
fn envmap(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let scale = fields.number("scale")?.unwrap_or(1.0);
    // It is of how Mitsuba draws directions.
    fields.ignore(&["mis_compensation"]);
    if fields.has("bitmap") {
        let remedy = "give the name of a file, `filename`";
        return Err(fields.wrong("bitmap", "is not supported", remedy));
    }
    let Some(name) = fields.text("filename")? else {
        return Err(fields.wrong("filename", "is missing", "add it"));
    };
    let rotation = rotation(fields)? * DQuat::from_rotation_y(-FRAC_PI_2);
    let source = import.paths.of(name, import.files);
    let place = format!("{}, filename", fields.label());
    let bytes = import.files.named(&source, &place, u64::MAX)?;
    let picture = Arc::new(Picture::around(&bytes, &place)?);
    let backdrop = Backdrop { picture, rotation, source: BackdropSource::File(source) };
    backdrop.doubt().into_iter().for_each(|text| import.warnings.add(&place, text));
    let backdrop = Some(backdrop);
    import.put_sky(fields, Environment { backdrop, ..Environment::constant(scale as f32) })
}

/// What `to_world` turns: directions have no place, and what stretches them is refused.
fn rotation(fields: &Fields) -> Result<DQuat, SceneError> {
    const TOLERANCE: f64 = 1e-6;
    let matrix = fields.transform("to_world")?.matrix3;
    let scale = cbrt(matrix.determinant());
    let turned = matrix * (1.0 / scale);
    let is_rotation = (turned * turned.transpose()).abs_diff_eq(DMat3::IDENTITY, TOLERANCE);
    if scale > 0.0 && is_rotation {
        return Ok(DQuat::from_mat3(&turned).normalize());
    }
    let problem = "mirrors or stretches the picture";
    Err(fields.wrong("to_world", problem, "only turn it, and mirror the file"))
}

fn point(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let intensity = fields.spectrum_or("intensity", Kind::Emission, 1.0)?;
    let place = match fields.vector("position")? {
        Some(_) if fields.has("to_world") => {
            let problem = "contradicts `to_world`";
            return Err(fields.wrong("position", problem, "keep one of them"));
        }
        Some(position) => position,
        None => fields.transform("to_world")?.translation,
    };
    let light = Punctual { kind: PunctualKind::Point, intensity };
    import.put(fields, light, DAffine3::from_translation(place)).map(drop)
}

fn directional(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let intensity = fields.spectrum_or("irradiance", Kind::Emission, 1.0)?;
    let place = match fields.vector("direction")? {
        Some(_) if fields.has("to_world") => {
            let problem = "contradicts `to_world`";
            return Err(fields.wrong("direction", problem, "keep one of them"));
        }
        Some(direction) => {
            let up = perpendicular(direction.normalize_or_zero());
            let place = looking(DVec3::ZERO, direction, up);
            place.map_err(|_| fields.wrong("direction", "is zero", ""))?
        }
        None => fields.transform("to_world")?,
    };
    let light = Punctual { kind: PunctualKind::Directional, intensity };
    import.put(fields, light, place).map(drop)
}

fn spot(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    const CUTOFF_DEG: f64 = 20.0;
    let intensity = fields.spectrum_or("intensity", Kind::Emission, 1.0)?;
    let cutoff = fields.number("cutoff_angle")?.unwrap_or(CUTOFF_DEG);
    let beam = fields.number("beam_width")?.unwrap_or(cutoff * 0.75);
    if fields.has("texture") {
        return Err(fields.wrong("texture", "is not supported", "remove it"));
    }
    if !(0.0 <= beam && beam <= cutoff && 0.0 < cutoff && cutoff <= 90.0) {
        let problem = format!("the beam_width {beam} and the cutoff_angle {cutoff} do not fit");
        let remedy = "degrees: 0 <= beam_width <= cutoff_angle <= 90";
        return Err(fields.wrong("cutoff_angle", problem, remedy));
    }
    let place = fields.transform("to_world")?;
    let (inner, outer) = (beam.to_radians(), cutoff.to_radians());
    // An edge is one, however it falls off.
    let falloff = if beam < cutoff { Falloff::Angle } else { Falloff::default() };
    let light = Punctual { kind: PunctualKind::Spot { inner, outer, falloff }, intensity };
    import.put(fields, light, place).map(drop)
}

/// The reciprocal of a pinhole camera: on a wall at a distance of 1 that faces it, a texel gives an
/// irradiance of pi times itself.
fn projector(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let scale = fields.number("scale")?.unwrap_or(1.0);
    let (picture, irradiance) = match fields.wanted("irradiance", Use::Radiance) {
        Some(Wanted { used, object }) => {
            let texture = import.texture(object, used)?;
            let picture = thrown(import, fields, texture)?;
            (picture, Spectrum::Constant(1.0))
        }
        None => {
            let white = Picture::new(Texels::of_colors(1, vec![[1.0; 3]]), half_hash(b"white"));
            let irradiance = fields.spectrum_or("irradiance", Kind::Emission, 1.0)?;
            (Arc::new(white), irradiance)
        }
    };
    let intensity = irradiance.scaled((PI * scale) as f32);
    let [width, height] = picture.texels().size().map(f64::from);
    let outer = atan2(tan_half_x(fields, width / height)?, 1.0);
    let place = fields.transform("to_world")?;
    if intensity.values().iter().all(|value| *value == 0.0) {
        return Ok(());
    }
    let kind = PunctualKind::Spot { inner: 0.0, outer, falloff: Falloff::default() };
    let light = import.put(fields, Punctual { kind, intensity }, place)?;
    let put = import.world.put_projection(light, Projection(picture));
    put.map_err(|fault| fields.fault(fault, &[("picture", "irradiance"), ("intensity", "scale")]))
}

/// The picture of a texture as ours throw them: as it lies, interpolated linearly, its outermost
/// texels beyond their middles.
fn thrown(
    import: &mut Import,
    fields: &Fields,
    texture: Texture,
) -> Result<Arc<Picture>, SceneError> {
    const PLAIN: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let Texture { picture, coding, wrap, filter, set: _, transform } = texture;
    if transform != PLAIN || filter != Filter::Linear {
        let problem = "is no picture as it lies, interpolated linearly";
        return Err(fields.wrong("irradiance", problem, "use a bitmap without to_uv"));
    }
    if wrap.contains(&Wrap::Repeat) {
        let text = "shows its outermost texels up to its edges, and not what lies beyond these";
        import.warnings.add(&fields.label(), text);
    }
    Ok(match coding {
        Coding::Srgb => picture,
        Coding::Linear => Arc::new(picture.linear()),
    })
}
