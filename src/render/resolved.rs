//! What options left open, decided by the scene: nothing renders before that.

use std::ops::Deref;

use super::Mode;
use super::place::Groups;
use super::settings::{AUTO, Settings, SettingsError};
use crate::film::layout::Layout;
use crate::integrators::Integrator;
use crate::polarization::Analyzer;
use crate::scattering::{Look, Scene, Side};

/// With less than this probability ([`Look::chance`]), paths from the sensor find lamps by way of
/// mirrors and glass only by chance; and with so much more where glass hides all lamps.
const CHANCE_MIN: f64 = 0.02;
const CHANCE_MIN_HIDDEN: f64 = 0.1;
/// Share of light that glass hides ([`Look::hidden`]) from which on photons find the most. Where it
/// hides less, paths from emitters do, which connect to what the camera sees.
const MOSTLY_HIDDEN: f64 = 0.5;
/// The part of that probability below which other integrators than the chosen one are doubted.
const DOUBTED: f64 = 0.25;

/// Settings in which nothing is left open: by which integrator, of how many samples, with how many
/// photons. All of it is a function of the options and the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    settings: Settings,
    /// How light is found.
    pub integrator: Integrator,
    /// By which rule, if that was not asked for.
    pub rule: Option<Rule>,
    /// Samples per pixel in all.
    pub samples: u32,
    /// How photons are shot, if they are.
    pub passes: Option<Passes>,
    /// The samples of the part that was asked for, or all: from this one on,
    pub first_sample: u32,
    /// and before this one.
    pub end_sample: u32,
    /// The film: which of its pixels are rendered, and how they see.
    pub film: Layout,
    /// What stands before the film.
    pub analyzer: Option<Analyzer>,
    /// Spectra that are held beyond their ends, a sentence each.
    pub held: Vec<String>,
    /// What the scene does not state and has been put in: what it is, and what it is like.
    pub put_in: Vec<(&'static str, String)>,
}

/// How photons are shot: each iteration begins with a pass of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    /// Light paths a pass.
    pub light_paths: u32,
    /// Samples per pixel for every pass.
    pub samples: u32,
}

impl Resolved {
    /// Settings for a scene, with the film of that; of the whole image, if a part was asked for
    /// too.
    pub fn new<const N: usize>(settings: &Settings, scene: &Scene<N>) -> Self {
        let rule = match settings.integrator {
            Some(_) => None,
            None => Some(Rule::of(scene.look())),
        };
        let chosen = rule.map_or(Integrator::Path, Rule::integrator);
        let integrator = settings.integrator.unwrap_or(chosen);
        let film = [scene.sensor.width, scene.sensor.height];
        let passes = integrator.shoots_photons().then(|| Passes {
            light_paths: settings.photons.light_paths(film),
            samples: settings.samples_of_photons(),
        });
        let samples = settings.samples_by(integrator);
        let analyzer = scene.sensor.analyzer();
        let (first_sample, end_sample) = (0, samples);
        let (settings, held) = (settings.clone(), scene.optics.held.clone());
        Self {
            settings,
            integrator,
            rule,
            samples,
            passes,
            first_sample,
            end_sample,
            film: scene.sensor.layout,
            analyzer,
            held,
            put_in: Vec::new(),
        }
    }

    /// The same for the part that was asked for, if one was.
    ///
    /// # Errors
    /// When there are not so many.
    pub fn of_part(mut self) -> Result<Self, SettingsError> {
        if let Some(part) = self.part {
            let samples = self.groups().samples_of(part)?;
            (self.first_sample, self.end_sample) = (samples.start, samples.end);
        }
        Ok(self)
    }

    /// How the samples are grouped.
    pub fn groups(&self) -> Groups {
        Groups::new(&self.settings, self.samples, self.samples_per_iteration())
    }

    /// Stokes components that are measured: behind an analyzer one, of which all others follow.
    pub fn components(&self) -> usize {
        components(self.mode, self.analyzer)
    }

    /// Samples per pixel that come together: those of a pass of photons, or one.
    pub fn samples_per_iteration(&self) -> u32 {
        self.passes.map_or(1, |passes| passes.samples)
    }

    /// Path lengths from which on roulette plays, by [`Side`].
    pub fn roulette_of_sides(&self) -> [u32; 2] {
        let of = |side| {
            self.roulette_after.unwrap_or(match side {
                Side::Light => 1,
                Side::Sensor => self.integrator.roulette_after(),
            })
        };
        let mut after = [0; 2];
        for side in [Side::Light, Side::Sensor] {
            after[side as usize] = of(side);
        }
        after
    }

    /// Which integrator was chosen, and why, if none was asked for.
    pub fn choice_in_words(&self) -> Option<String> {
        self.rule.map(Rule::choice_in_words)
    }
}

/// Those that were asked for; what these left open is in the fields of [`Resolved`].
impl Deref for Resolved {
    type Target = Settings;
    fn deref(&self) -> &Settings {
        &self.settings
    }
}

/// Stokes components that are measured: behind an analyzer one, of which all others follow.
pub fn components(mode: Mode, analyzer: Option<Analyzer>) -> usize {
    if analyzer.is_some() { 1 } else { mode.components() }
}

/// What decides which integrator suits a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Points light what is specular, and the camera sees such.
    PointsSeen,
    /// Points light what is specular.
    Points,
    /// Points shine in media that scatter.
    PointsInMedia,
    /// Glass hides small lamps from most of what the camera sees, and it sees mirrors or glass.
    SmallHidden,
    /// Small lamps light what is specular.
    Small,
    /// Neither.
    Plain,
}

impl Rule {
    /// Of a scene that has been looked at.
    pub fn of(look: &Look) -> Self {
        let sees_specular = look.sees_specular > 0.0;
        let is_chance = look.chance < chance_min(look);
        let is_hidden = look.hidden > MOSTLY_HIDDEN && sees_specular;
        match (look.has_points, sees_specular) {
            (true, true) => Self::PointsSeen,
            (true, false) => Self::Points,
            (false, _) if look.has_points_in_media => Self::PointsInMedia,
            (false, _) if is_chance && is_hidden => Self::SmallHidden,
            (false, _) if is_chance => Self::Small,
            (false, true | false) => Self::Plain,
        }
    }

    /// What suits it.
    pub fn integrator(self) -> Integrator {
        match self {
            Self::PointsSeen | Self::SmallHidden => Integrator::Ppm,
            Self::Points | Self::PointsInMedia | Self::Small => Integrator::Bdpt,
            Self::Plain => Integrator::Path,
        }
    }

    /// What it chooses, and why.
    pub fn choice_in_words(self) -> String {
        format!("--integrator {AUTO} takes `{}`: {}", self.integrator().name(), self.text())
    }

    /// Why, in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::PointsSeen => {
                "points or directions light mirrors or glass, and the camera sees mirrors or glass"
            }
            Self::Points => "points or directions light mirrors or glass",
            Self::PointsInMedia => "points shine in media that scatter",
            Self::SmallHidden => {
                "glass hides small lamps from most of the view, and the camera sees such or mirrors"
            }
            Self::Small => "small lamps light mirrors or glass",
            Self::Plain => "neither points nor small lamps light mirrors or glass",
        }
    }
}

fn chance_min(look: &Look) -> f64 {
    CHANCE_MIN + CHANCE_MIN_HIDDEN * look.hidden
}

/// What an integrator does not find in a scene that has been looked at, or hardly ever: one
/// sentence; none if it finds all.
pub fn blindness(integrator: Integrator, look: &Look) -> Option<String> {
    let name = integrator.name();
    if !integrator.measures() {
        return unmeasured(name, look);
    }
    let sees_specular = look.sees_specular > 0.0;
    let lacks = match (integrator.shoots_photons(), integrator.splats()) {
        (true, _) => None,
        (false, true) => {
            sees_specular.then_some("what mirrors and glass show of their light there")
        }
        (false, false) => Some("what comes of their light by way of these"),
    };
    if let (Some(lacks), true) = (lacks, look.has_points) {
        return Some(format!(
            "points or directions light mirrors or glass: `{name}` does not find {lacks}, and the \
             image lacks it; --integrator {AUTO} finds it"
        ));
    }
    let does_better = Rule::of(look).integrator() != integrator;
    let is_doubted = does_better && look.chance < DOUBTED * chance_min(look);
    let lacks = lacks.filter(|_| is_doubted)?;
    Some(format!(
        "small lamps light mirrors or glass: `{name}` finds {lacks} only by chance; --integrator \
         {AUTO} does better"
    ))
}

/// What particle tracing does not see.
fn unmeasured(name: &str, look: &Look) -> Option<String> {
    let percent = |share: f64| format!("{:.0} % of the view", (100.0 * share).max(1.0));
    let mut missing = Vec::new();
    if look.sees_solid > 0.0 {
        missing.push(format!(
            "through solid glass or into mirrors, so these are black in its image ({})",
            percent(look.sees_solid)
        ));
    }
    if look.sees_panes > 0.0 {
        missing.push(format!("what panes mirror, which it lacks ({})", percent(look.sees_panes)));
    }
    if look.has_parallel_sky {
        missing.push(format!(
            "a sky by parallel rays, so that is black in its image ({})",
            percent(look.sees_nothing)
        ));
    }
    let mut said = Vec::new();
    if !missing.is_empty() {
        said.push(format!("cannot see {}", missing.join(", nor ")));
    }
    if look.sees_polished > 0.0 {
        said.push(format!(
            "finds what polished surfaces mirror and let through only by chance, as a few bright \
             dots ({})",
            percent(look.sees_polished)
        ));
    }
    if said.is_empty() {
        return None;
    }
    Some(format!(
        "the integrator `{name}` {}; `bdpt`, `path` and `ppm` show them",
        said.join(", and ")
    ))
}
