//! Participating media, and which of them lie on the two sides of a surface.

use hecs::Entity;

use super::extension::{Body, MEDIUM, SCENE};
use super::{Import, particles};
use crate::math::text::{excerpt, listed};
use crate::scene::error::{Findings, SceneError};
use crate::scene::world::{Boundary, Filling, MEDIA_MAX, Medium, Name, Phase};

/// Values of `phase`, with the keys that they take beside `COMMON_KEYS`.
const PHASES: [(&str, &[&str]); 5] = [
    ("hg", &["g"]),
    ("isotropic", &[]),
    ("mie", &["host", "milk", "particles"]),
    ("mueller_table", &["table"]),
    ("rayleigh", &["depolarization"]),
];
/// Most characters of a wrong value that an error quotes.
const CHARACTERS_MAX: usize = 60;
/// Keys of every medium.
const COMMON_KEYS: [&str; 4] = ["name", "phase", "sigma_a", "sigma_s"];

impl Import<'_> {
    /// Adds the media that the scene, or the root of the file, describes.
    pub fn add_media(&mut self, scene: usize) -> Result<(), SceneError> {
        let value = &self.document.value;
        let label = self.document.label("scenes", scene);
        let owners =
            [Body::of(&value["scenes"][scene], &label, &SCENE)?, Body::of(value, "root", &SCENE)?];
        for key in ["media", "medium"] {
            if owners.iter().all(|owner| owner.has(key)) {
                let problem = format!("is described twice, by {} too", owners[1].field(key));
                return Err(SceneError::new(owners[0].field(key), problem, "keep one of them"));
            }
        }
        let mut findings = Findings::default();
        for owner in &owners {
            let bodies = owner.objects("media", &MEDIUM)?.unwrap_or_default();
            if bodies.len() > MEDIA_MAX {
                let problem = format!("has {} media, more than {MEDIA_MAX}", bodies.len());
                return Err(SceneError::new(owner.field("media"), problem, "use fewer"));
            }
            for body in &bodies {
                let medium = self.add_medium(body);
                self.media.extend(findings.note(medium));
            }
        }
        // What refers to media by their number can be read only if all are there.
        findings.result()?;
        for owner in &owners {
            if let Some(Filling::Medium(medium)) = self.filling_of(owner, "medium")? {
                self.world.set_scene_medium(medium)?;
            }
        }
        Ok(())
    }

    fn add_medium(&mut self, body: &Body) -> Result<Entity, SceneError> {
        let medium = self.medium(body)?;
        let put = self.world.put_medium(Name(body.label().to_owned()), medium);
        put.map_err(|fault| body.place(fault))
    }

    fn medium(&mut self, body: &Body) -> Result<Medium, SceneError> {
        let names = || PHASES.map(|(name, _)| name).join(", ");
        let Some(model) = body.word("phase")? else {
            return Err(body.missing("phase", &format!("use one of {}", names())));
        };
        let Some((_, keys)) = PHASES.iter().find(|(name, _)| *name == model) else {
            let problem = format!("`{model}` is not a phase function");
            let remedy = format!("use one of {}", names());
            return Err(SceneError::new(body.field("phase"), problem, remedy));
        };
        let foreign = |key: &&str| !COMMON_KEYS.contains(key) && !keys.contains(key);
        if let Some(key) = body.keys().find(foreign) {
            let remedy = match keys.join(", ") {
                keys if keys.is_empty() => format!("{model} takes no keys"),
                keys => format!("{model} takes: {keys}"),
            };
            let problem = format!("means nothing for the phase function {model}");
            return Err(SceneError::new(body.field(key), problem, remedy));
        }
        body.word("name")?;
        let phase = self.phase(model, body)?;
        let (sigma_a, sigma_s) = (body.spectrum("sigma_a")?, body.spectrum("sigma_s")?);
        Ok(Medium { sigma_a, sigma_s, phase })
    }

    fn phase(&mut self, model: &str, body: &Body) -> Result<Phase, SceneError> {
        match model {
            "hg" => match body.spectrum("g")? {
                Some(g) => Ok(Phase::HenyeyGreenstein { g }),
                None => {
                    let remedy = "give the mean cosine of the scattering angle, within (-1, 1)";
                    Err(body.missing("g", remedy))
                }
            },
            "mie" => particles::phase(body),
            "mueller_table" => Ok(Phase::Table(self.phase_matrices(body)?)),
            "rayleigh" => {
                let depolarization = body.number("depolarization")?.unwrap_or(0.0);
                Ok(Phase::Rayleigh { depolarization })
            }
            _ => Ok(Phase::isotropic()),
        }
    }

    /// What a node says about the two sides of its surfaces.
    pub fn boundary(&self, node: &Body) -> Result<Boundary, SceneError> {
        Ok(Boundary {
            interior: self.filling_of(node, "interior")?,
            exterior: self.filling_of(node, "exterior")?,
            priority: node.integer("priority")?.unwrap_or(0),
        })
    }

    /// The medium that a key names by its index, or null or "none" for nothing of it.
    fn filling_of(&self, body: &Body, key: &str) -> Result<Option<Filling>, SceneError> {
        let Some((value, field)) = body.value(key) else { return Ok(None) };
        if value.is_null() || value.as_str() == Some("none") {
            return Ok(Some(Filling::Clear));
        }
        let known = value.as_u64().and_then(|index| self.media.get(usize::try_from(index).ok()?));
        if let Some(medium) = known {
            return Ok(Some(Filling::Medium(*medium)));
        }
        let (value, count) = (excerpt(&value.to_string(), CHARACTERS_MAX), self.media.len());
        let problem = format!("{value} is not an index into the file's {count} media");
        Err(SceneError::new(field, problem, self.advice_on_media()))
    }

    /// How media are named.
    fn advice_on_media(&self) -> String {
        let entities = self.world.entities();
        let name = |(index, medium): (usize, &Entity)| {
            let label = entities.get::<&Name>(*medium).map_or(String::new(), |it| it.0.clone());
            // Labels are those of errors, behind where the media stand.
            match label.split_once('"') {
                Some((_, name)) => format!("{index} for \"{name}"),
                None => index.to_string(),
            }
        };
        match self.media.is_empty() {
            true => "add `media` to the scene, of which the first is 0; or null for nothing".into(),
            false => {
                let names = listed(self.media.iter().enumerate().map(name));
                format!("give {names}; or null for nothing")
            }
        }
    }
}
