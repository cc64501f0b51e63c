//! Media of spheres: suspensions of particles, and milk.

use super::extension::{Body, DISTRIBUTION, HOST, MILK, PARTICLES};
use super::spectra::Part;
use crate::polarization::milk::Milk;
use crate::polarization::particles::{Amount, Sizes};
use crate::scene::error::SceneError;
use crate::scene::world::{Component, Phase, Spheres};
use crate::spectrum::{self, Spectrum};

/// Values of a distribution's `kind`, with the keys that they take.
const KINDS: [(&str, &[&str]); 4] = [
    ("gamma", &["mean_um", "of", "range_um", "sd_um"]),
    ("log_normal", &["mean_um", "of", "range_um", "sd_um"]),
    ("monodisperse", &["radius_um"]),
    ("table", &["density", "of", "radii_um"]),
];

/// What the phase function `mie` is made of: either `milk`, or `particles` in a `host`.
pub fn phase(body: &Body) -> Result<Phase, SceneError> {
    match (body.object("milk", &MILK)?, body.objects("particles", &PARTICLES)?) {
        (Some(milk), None) if !body.has("host") => Ok(Phase::Milk(self::milk(&milk)?)),
        (None, Some(particles)) => {
            let name = body.value("host").and_then(|(value, _)| value.as_str());
            if let Some(name) = name.filter(|name| spectrum::index(name).is_some()) {
                let remedy = format!("write {{\"eta\": \"{name}\"}}");
                return Err(SceneError::new(body.field("host"), "is not an object", remedy));
            }
            let Some(host) = body.object("host", &HOST)? else {
                let remedy = "give its index of refraction, {\"eta\": 1.33} for water";
                return Err(body.missing("host", remedy));
            };
            spheres(body, &particles, &host).map(Phase::Spheres)
        }
        _ => {
            let problem = "mie takes either `milk` or both `particles` and `host`";
            Err(SceneError::new(body.label(), problem, "state what scatters once"))
        }
    }
}

fn milk(body: &Body) -> Result<Milk, SceneError> {
    let part = |key: &str| {
        let percent = body.number(key)?;
        percent.ok_or_else(|| body.missing(key, "whole milk has 3.5 % fat and 3.4 % protein"))
    };
    let (fat_percent, protein_percent) = (part("fat_percent")?, part("protein_percent")?);
    let dilution = body.number("dilution")?.unwrap_or(1.0);
    let milk = Milk { fat_percent, protein_percent, dilution };
    milk.check().map_err(|fault| body.place(fault))?;
    Ok(milk)
}

fn spheres(medium: &Body, particles: &[Body], host: &Body) -> Result<Spheres, SceneError> {
    let components: Vec<Component> =
        particles.iter().map(component).collect::<Result<_, SceneError>>()?;
    let (host_eta, host_k) = index(host)?;
    let spheres = Spheres { components, host_eta, host_k };
    spheres.check().map_err(|fault| match fault.field.as_str() {
        "host_eta" => host.place(fault.of("eta")),
        "host_k" => host.place(fault.of("k")),
        _ => medium.place(fault.of("particles")),
    })?;
    Ok(spheres)
}

/// Index of refraction n - i k.
fn index(body: &Body) -> Result<(Spectrum, Spectrum), SceneError> {
    let Some(eta) = body.refraction("eta", Part::Real)? else {
        return Err(body.missing("eta", "give the real part of the index of refraction"));
    };
    let k = body.refraction("k", Part::Extinction)?;
    Ok((eta, k.unwrap_or(Spectrum::Constant(0.0))))
}

fn component(body: &Body) -> Result<Component, SceneError> {
    body.word("name")?;
    let Some(distribution) = body.object("distribution", &DISTRIBUTION)? else {
        return Err(body.missing("distribution", "give the sizes of the particles"));
    };
    let Some(volume_fraction) = body.number("volume_fraction")? else {
        let remedy = "give the share of the volume that the particles fill";
        return Err(body.missing("volume_fraction", remedy));
    };
    let (eta, k) = index(body)?;
    let component = Component { sizes: sizes(&distribution)?, eta, k, volume_fraction };
    component.check().map_err(|fault| body.place(fault))?;
    Ok(component)
}

fn sizes(body: &Body) -> Result<Sizes, SceneError> {
    let names = || KINDS.map(|(name, _)| name).join(", ");
    let Some(kind) = body.word("kind")? else {
        return Err(body.missing("kind", &format!("use one of {}", names())));
    };
    let Some((_, keys)) = KINDS.iter().find(|(name, _)| *name == kind) else {
        let problem = format!("`{kind}` is not a distribution");
        return Err(SceneError::new(
            body.field("kind"),
            problem,
            format!("use one of {}", names()),
        ));
    };
    if let Some(key) = body.keys().find(|key| *key != "kind" && !keys.contains(key)) {
        let problem = format!("means nothing for the distribution {kind}");
        let remedy = format!("{kind} takes: {}", keys.join(", "));
        return Err(SceneError::new(body.field(key), problem, remedy));
    }
    let radius = |key: &str| {
        let radius = body.number(key)?;
        radius.ok_or_else(|| body.missing(key, "give it in micrometers"))
    };
    let sizes = match kind {
        "monodisperse" => Sizes::monodisperse(radius("radius_um")?),
        "table" => {
            let column = |key: &str| {
                let column = body.numbers(key)?;
                column.ok_or_else(|| body.missing(key, "give the radii and the density at each"))
            };
            Sizes::table(&column("radii_um")?, &column("density")?, amount(body)?)
        }
        _ => {
            let (mean, sd) = (radius("mean_um")?, radius("sd_um")?);
            let (of, range) = (amount(body)?, range(body)?);
            match kind {
                "gamma" => Sizes::gamma(mean, sd, of, range),
                _ => Sizes::log_normal(mean, sd, of, range),
            }
        }
    };
    sizes.map_err(|fault| body.place(fault))
}

/// What the density counts.
fn amount(body: &Body) -> Result<Amount, SceneError> {
    match body.word("of")? {
        Some("number") => Ok(Amount::Number),
        Some("volume") => Ok(Amount::Volume),
        other => {
            let problem = match other {
                Some(other) => format!("`{other}` is not what a density counts"),
                None => "is missing".to_owned(),
            };
            Err(SceneError::new(body.field("of"), problem, "use \"number\" or \"volume\""))
        }
    }
}

/// Least and greatest radius.
fn range(body: &Body) -> Result<Option<[f64; 2]>, SceneError> {
    match body.numbers("range_um")?.as_deref() {
        None => Ok(None),
        Some(&[low, high]) => Ok(Some([low, high])),
        Some(_) => {
            let problem = "must be two radii in micrometers, the lesser first";
            Err(SceneError::new(body.field("range_um"), problem, ""))
        }
    }
}
