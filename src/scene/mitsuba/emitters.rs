//! Lights: the types of `<emitter>`.

use glam::{DAffine3, DVec3, Vec3};

use super::Import;
use super::fields::Fields;
use super::spectra::Kind;
use super::transforms::{looking, perpendicular};
use super::tree::{NAME, Tag};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{Emission, Environment, Name, Punctual, PunctualKind, Transform};

/// What shapes may have; the others stand by themselves.
const OF_SHAPES: &str = "area";

/// What reads a type, and adds it.
type Add = fn(&mut Import, &Fields) -> Result<(), SceneError>;

/// The lights that are no shape's, by type.
const TYPES: [(&str, Add); 4] =
    [("constant", constant), ("directional", directional), ("point", point), ("spot", spot)];

/// The emission of a shape.
pub fn area(fields: &Fields) -> Result<Emission, SceneError> {
    if fields.object.plugin != OF_SHAPES {
        let problem = "is not the light of a shape";
        return Err(fields.refuse(problem, "use an area emitter, or move it out of the shape"));
    }
    let radiance = fields.spectrum_or("radiance", Kind::Emission, 1.0)?;
    fields.ignore(&["sampling_weight"]);
    let emission = Emission { radiance };
    emission.check().map_err(|fault| fields.fault(fault, &[]))?;
    fields.finish()?;
    Ok(emission)
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

    /// Adds a light; `z` is where it shines to in its own space.
    fn put(&mut self, fields: &Fields, light: Punctual, place: DAffine3) -> Result<(), SceneError> {
        // Ours shine along -z.
        let turned = DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0));
        let put = self.world.put_light(Name(fields.label()), light, Transform(place * turned));
        put.map(|_| ()).map_err(|fault| fields.fault(fault, &[]))
    }
}

fn constant(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    let radiance = fields.spectrum_or("radiance", Kind::Emission, 1.0)?;
    fields.ignore(&["to_world"]);
    if import.has_environment {
        let remedy = "keep one of them";
        return Err(fields.refuse("is a second environment", remedy));
    }
    let sky = Environment { radiance, gradient: Vec3::ZERO };
    import.has_environment = true;
    if sky.radiance.values().iter().all(|value| *value == 0.0) {
        return Ok(());
    }
    let put = import.world.put_environment(Name(fields.label()), sky);
    put.map(|_| ()).map_err(|fault| fields.fault(fault, &[]))
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
    import.put(fields, light, DAffine3::from_translation(place))
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
    import.put(fields, Punctual { kind: PunctualKind::Directional, intensity }, place)
}

fn spot(import: &mut Import, fields: &Fields) -> Result<(), SceneError> {
    const CUTOFF_DEG: f64 = 20.0;
    let intensity = fields.spectrum_or("intensity", Kind::Emission, 1.0)?;
    let cutoff = fields.number("cutoff_angle")?.unwrap_or(CUTOFF_DEG);
    let beam = fields.number("beam_width")?.unwrap_or(cutoff * 0.75);
    if fields.has("texture") {
        return Err(fields.wrong("texture", "is not supported", "remove it"));
    }
    let place = fields.transform("to_world")?;
    let kind = PunctualKind::Spot { inner: beam.to_radians(), outer: cutoff.to_radians() };
    let light = Punctual { kind, intensity };
    light.check().map_err(|fault| fields.fault(fault.of("cutoff_angle"), &[]))?;
    if beam < cutoff {
        let text = "falls off from the beam to the cutoff with the square of the cosine's share, \
                    as in glTF, and not with the angle's";
        import.warnings.add(&fields.label(), text);
    }
    import.put(fields, light, place)
}
