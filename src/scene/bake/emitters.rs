//! Everything that emits, and how likely it is to start a path.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::beside::Passable;
use super::outside_table;
use crate::math::elementary::cos;
use crate::scene::baked::{NONE, Shapes};
use crate::scene::emitted::{EmittedStates, LampState};
use crate::scene::emitter::{self, Emitter, EmitterModel};
use crate::scene::error::SceneError;
use crate::scene::luminaire::Luminaire;
use crate::scene::painting::mean_share;
use crate::scene::pattern::Pattern;
use crate::scene::projector::Projector;
use crate::scene::ramp::Ramp;
use crate::scene::world::{
    self, Bsdf, Emission, EmittedStokes, Environment, Falloff, Incandescent, Name, Passage,
    Projection, Punctual, PunctualKind, Sides, Textures, Transform, World, incandescent_share,
};
use crate::spectrum::{Beyond, Carried, Role, Spectrum, White};

/// Least difference of the cosines of a spot's two cones: as the glTF extension's formula has it.
const LEAST_CONE: f32 = 1e-3;

/// The table of emitters: see `Optics`. No wavelength has a part in it.
#[derive(Clone, Debug)]
pub struct Emitters {
    /// Everything that emits.
    pub rows: Arc<Vec<Emitter>>,
    /// What some of them emit by direction.
    pub patterns: Arc<Vec<Pattern>>,
    /// For every triangle and sphere its row, or [`NONE`].
    pub emitter_of_primitive: Arc<Vec<u32>>,
    /// The rows of what is infinitely far away and can be seen.
    pub skies: Range<u32>,
}

/// What a light emits by direction.
type OfLight<'a> = (Option<&'a world::Luminaire>, Option<&'a Projection>);

/// That table in the making.
struct Table {
    rows: Vec<Emitter>,
    patterns: Vec<Pattern>,
    emitter_of_primitive: Vec<u32>,
    /// Power of each row in W, averaged over the wavelengths.
    powers: Vec<f64>,
}

/// Something that emits with a spectrum of its own, and what errors call it.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Its material, light or environment.
    pub name: String,
    /// Radiance, radiant intensity or irradiance.
    pub spectrum: Spectrum,
    /// How it is polarized, if it is.
    pub state: Option<State>,
}

/// How a lamp is polarized.
#[derive(Clone, Debug)]
pub enum State {
    /// [`LampState::Same`].
    Same {
        /// In its frame.
        stokes: EmittedStokes,
        /// What that goes by.
        axes: Option<[Vec3; 2]>,
    },
    /// [`LampState::Incandescent`].
    Incandescent,
}

impl State {
    /// The spectra that it is stated by.
    pub(super) fn spectra(&self) -> &[Spectrum] {
        match self {
            Self::Same { stokes, .. } => &stokes.stokes,
            Self::Incandescent => &[],
        }
    }

    /// Whether it is another at other wavelengths.
    fn is_chromatic(&self) -> bool {
        match self {
            Self::Same { stokes, .. } => !stokes.stokes.iter().all(Spectrum::is_flat),
            Self::Incandescent => true,
        }
    }

    /// Of a lamp in a place, if it is a surface in none.
    fn of(stokes: Option<&EmittedStokes>, place: Option<DAffine3>) -> Option<Self> {
        let stokes = stokes.filter(|stokes| !stokes.is_unpolarized())?.clone();
        let axes = place.map(|place| {
            let DAffine3 { matrix3, .. } = place;
            [matrix3.x_axis, matrix3.y_axis].map(|axis| axis.normalize().as_vec3())
        });
        Some(Self::Same { stokes, axes })
    }
}

impl Lamp {
    /// Whether it emits at no wavelength.
    pub(super) fn is_black(&self) -> bool {
        self.spectrum.values().iter().all(|value| *value == 0.0)
    }

    /// What it emits at wavelengths in nanometers, by a white; nothing if it is black.
    ///
    /// # Errors
    /// When its table does not cover them.
    pub fn emitted(
        &self,
        wavelengths_nm: &[f64],
        (white, beyond): (White, Beyond),
    ) -> Result<Vec<f64>, SceneError> {
        let at = |nm: &f64| {
            let [value] = self.sampled(&Carried::at([*nm as f32]).under(white).beyond(beyond))?;
            Ok(f64::from(value))
        };
        match self.is_black() {
            true => Ok(Vec::new()),
            false => wavelengths_nm.iter().map(at).collect(),
        }
    }

    fn sampled<const N: usize>(&self, carried: &Carried<N>) -> Result<[f32; N], SceneError> {
        if self.is_black() {
            return Ok([0.0; N]);
        }
        self.spectrum
            .sample(carried, Role::Emission)
            .map_err(|error| outside_table(&self.name, error))
    }
}

/// How much a lamp emits, averaged over wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightness {
    /// In double precision: what powers are made of.
    pub mean: f64,
    /// What choices by place are made of.
    pub rounded: f32,
}

impl Brightness {
    /// The mean over columns.
    pub fn of_columns<const N: usize>(columns: &[f32; N]) -> Self {
        let mean = columns.iter().copied().map(f64::from).sum::<f64>() / N as f64;
        Self { mean, rounded: columns.iter().sum::<f32>() / N as f32 }
    }
}

/// The lamps of a world in the order of `Optics::lamps`. What does not emit is black.
pub fn lamps(world: &World) -> Vec<Lamp> {
    let black = || Spectrum::Constant(0.0);
    let lamp = |name: &str, spectrum, state| Lamp { name: name.to_owned(), spectrum, state };
    type States<'a> = (Option<&'a EmittedStokes>, Option<&'a Incandescent>);
    type OfMaterial<'a> = (&'a Name, &'a Bsdf, Option<&'a Emission>, States<'a>);
    let mut lamps = world.in_order::<OfMaterial, _>(|(name, _, emission, (stokes, by_heat))| {
        let radiance = emission.map_or_else(black, |emission| emission.radiance.clone());
        let state = by_heat.map(|_| State::Incandescent).or_else(|| State::of(stokes, None));
        lamp(&name.0, radiance, state)
    });
    // Air among other bodies.
    lamps.push(lamp("air", black(), None));
    type Light<'a> =
        (&'a Name, &'a Transform, &'a Punctual, OfLight<'a>, Option<&'a EmittedStokes>);
    lamps.extend(world.in_order::<Light, _>(|(name, place, light, of_light, stokes)| {
        // Suns are said to have an irradiance, and are seen by their radiance.
        let faced = match light.kind {
            PunctualKind::Sun { diameter } => emitter::Sun::new(Vec3::Z, diameter).faced(),
            PunctualKind::Point | PunctualKind::Spot { .. } | PunctualKind::Directional => 1.0,
        };
        let mean = match of_light {
            (Some(luminaire), _) => luminaire.0.mean(),
            (None, Some(projection)) => projection.mean_of(light.kind),
            (None, None) => ramp_of(light.kind).map_or(1.0, Ramp::mean_of),
        };
        let intensity = light.intensity.clone().scaled((mean / faced) as f32);
        lamp(&name.0, intensity, State::of(stokes, Some(place.0)))
    }));
    type Sky<'a> = (&'a Name, &'a Environment, Option<&'a EmittedStokes>);
    lamps.extend(world.in_order::<Sky, _>(|(name, sky, stokes)| {
        lamp(&name.0, sky.mean(), State::of(stokes, Some(DAffine3::IDENTITY)))
    }));
    lamps
}

/// How what lamps emit is polarized at the wavelengths of the render, and whether it is a picture
/// that says so of the environment ([`has_polarized_picture`]).
///
/// # Errors
/// When a table does not cover them.
pub fn states<const N: usize>(
    lamps: &[Lamp],
    carried: &Carried<N>,
    by_picture: bool,
) -> Result<EmittedStates<N>, SceneError> {
    let is_polarized = |lamp: &&Lamp| lamp.state.is_some() && !lamp.is_black();
    if lamps.iter().find(is_polarized).is_none() {
        // Colors of pictures may differ in it.
        let is_chromatic = by_picture;
        return Ok(EmittedStates { is_chromatic, by_picture, ..EmittedStates::default() });
    }
    let of_lamp = |lamp: &Lamp| {
        Ok(match &lamp.state {
            None => None,
            Some(State::Incandescent) => Some(LampState::Incandescent),
            Some(State::Same { stokes, axes }) => {
                let sampled = stokes.sampled(carried);
                let stokes = sampled.map_err(|error| outside_table(&lamp.name, error))?;
                Some(LampState::Same { stokes, axes: *axes })
            }
        })
    };
    let of_lamps = lamps.iter().map(of_lamp).collect::<Result<_, SceneError>>()?;
    let all = || lamps.iter().filter_map(|lamp| lamp.state.as_ref());
    let is_chromatic = all().any(State::is_chromatic) || by_picture;
    let has_incandescent = all().any(|state| matches!(state, State::Incandescent));
    Ok(EmittedStates { of_lamps, is_chromatic, has_incandescent, by_picture })
}

/// Whether a picture says how the environment's light is polarized.
pub fn has_polarized_picture(world: &World) -> bool {
    world.in_order::<&Environment, _>(Environment::is_polarized).contains(&true)
}

/// What lamps emit at the wavelengths of the render.
///
/// # Errors
/// When a table does not cover them.
pub fn radiance<const N: usize>(
    lamps: &[Lamp],
    carried: &Carried<N>,
) -> Result<Vec<[f32; N]>, SceneError> {
    lamps.iter().map(|lamp| lamp.sampled(carried)).collect()
}

/// Positions about `origin` of the lights without extent that have one.
pub fn positions(world: &World, origin: DVec3) -> Vec<Vec3> {
    let positions =
        world.in_order::<(&Transform, &Punctual), _>(|(place, light)| match light.kind {
            PunctualKind::Point | PunctualKind::Spot { .. } => {
                Some(place.about(origin).translation.as_vec3())
            }
            PunctualKind::Directional | PunctualKind::Sun { .. } => None,
        });
    positions.into_iter().flatten().collect()
}

/// Primitives first, in their order, then punctual lights, suns last, then the environment, each as
/// bright as its lamp. Rows without power are left out, so every probability is greater than zero.
///
/// # Errors
/// When nothing has any.
pub fn emitters(
    world: &World,
    shapes: &Shapes,
    brightness: &[Brightness],
) -> Result<Emitters, SceneError> {
    let mut table = Table {
        rows: Vec::new(),
        patterns: Vec::new(),
        emitter_of_primitive: Vec::new(),
        powers: Vec::new(),
    };
    let lamp = table.add_primitives(world, shapes, brightness);
    let passable = Passable::at(&positions(world, shapes.origin), shapes);
    type Light<'a> = (&'a Name, &'a Transform, &'a Punctual, OfLight<'a>);
    let lights = world.in_order::<Light, _>(|(_, place, light, of_light)| {
        let place = place.about(shapes.origin);
        let pattern = pattern(light.kind, place.matrix3, of_light);
        (punctual(light.kind, &place, &passable), pattern)
    });
    let (mut skies, lamp_of_skies) = (Vec::new(), lamp + lights.len() as u32);
    for ((model, pattern), lamp) in lights.into_iter().zip(lamp..) {
        let model = match (model, pattern) {
            (
                EmitterModel::Point(emitter::Point { position })
                | EmitterModel::Spot(emitter::Spot { position, .. }),
                Some(pattern),
            ) => {
                let (row, cone) = (table.patterns.len() as u32, pattern.cone());
                table.patterns.push(pattern);
                emitter::Patterned { position, row, cone }.into()
            }
            (model, _) => model,
        };
        match model {
            EmitterModel::Sun(_) => skies.push((model, lamp)),
            model => drop(table.add(shapes, model, (lamp, brightness))),
        }
    }
    let environments = world.in_order::<(&Name, &Environment), _>(|(_, sky)| {
        let gradient = emitter::Environment { gradient: sky.gradient };
        sky.panorama().map_or_else(|| gradient.into(), EmitterModel::from)
    });
    skies.extend(environments.into_iter().zip(lamp_of_skies..));
    let first = table.rows.len() as u32;
    for (model, lamp) in skies {
        table.add(shapes, model, (lamp, brightness));
    }
    let skies = first..table.rows.len() as u32;
    table.set_probabilities()?;
    Ok(Emitters {
        rows: Arc::new(table.rows),
        patterns: Arc::new(table.patterns),
        emitter_of_primitive: Arc::new(table.emitter_of_primitive),
        skies,
    })
}

/// What a light emits by direction, if it says so, by the axes of its place.
fn pattern(kind: PunctualKind, axes: DMat3, of_light: OfLight) -> Option<Pattern> {
    match (of_light, kind) {
        ((Some(luminaire), _), _) => Some(Pattern::Measured(Luminaire::new(&luminaire.0, axes))),
        ((None, Some(projection)), PunctualKind::Spot { outer, .. }) => {
            Some(Pattern::Projected(Projector::new(projection, axes, outer)))
        }
        ((None, _), kind) => ramp_of(kind).map(|angles| Pattern::Ramp(Ramp::new(axes, angles))),
    }
}

/// The angles of a spot that falls off with the angle.
fn ramp_of(kind: PunctualKind) -> Option<[f64; 2]> {
    match kind {
        PunctualKind::Spot { inner, outer, falloff: Falloff::Angle } => Some([inner, outer]),
        PunctualKind::Spot { falloff: Falloff::Cosine, .. }
        | PunctualKind::Point
        | PunctualKind::Directional
        | PunctualKind::Sun { .. } => None,
    }
}

fn punctual(kind: PunctualKind, place: &DAffine3, passable: &Passable) -> EmitterModel {
    let position = || passable.before(place.translation.as_vec3());
    let direction = (-place.matrix3.z_axis.normalize()).as_vec3();
    match kind {
        PunctualKind::Point => emitter::Point { position: position() }.into(),
        PunctualKind::Directional => emitter::Directional { direction }.into(),
        PunctualKind::Sun { diameter } => emitter::Sun::new(direction, diameter).into(),
        PunctualKind::Spot { inner, outer, .. } => {
            let cos_inner = cos(inner) as f32;
            let cos_outer = (cos(outer) as f32).min(cos_inner - LEAST_CONE);
            let position = position();
            emitter::Spot { position, direction, cos_inner, cos_outer }.into()
        }
    }
}

impl Table {
    /// Appends a row for a lamp unless it is black; its index, or [`NONE`].
    fn add(
        &mut self,
        shapes: &Shapes,
        model: impl Into<EmitterModel>,
        (lamp, brightness): (u32, &[Brightness]),
    ) -> u32 {
        self.add_share(shapes, model, (lamp, brightness), 1.0)
    }

    /// [`Self::add`] of what emits a share of what its lamp does.
    fn add_share(
        &mut self,
        shapes: &Shapes,
        model: impl Into<EmitterModel>,
        (lamp, brightness): (u32, &[Brightness]),
        share: f64,
    ) -> u32 {
        let model = model.into();
        let Brightness { mean, rounded } = brightness[lamp as usize];
        let power = mean * model.size(shapes) * share;
        let brightness = rounded * share as f32;
        if power <= 0.0 || brightness <= 0.0 {
            return NONE;
        }
        self.powers.push(power);
        self.rows.push(Emitter { model, lamp, brightness, probability: 0.0 });
        (self.rows.len() - 1) as u32
    }

    /// Of all primitives; returns the first lamp that is none of a material.
    fn add_primitives(&mut self, world: &World, shapes: &Shapes, brightness: &[Brightness]) -> u32 {
        type Parts<'a> = (&'a Bsdf, &'a Sides, Option<&'a Textures>, Option<&'a Incandescent>);
        let materials = world.in_order::<(&Name, Parts), _>(|(_, parts)| {
            let (bsdf, sides, textures, by_heat) = parts;
            let bsdf = bsdf.clone().simplified();
            let refracts = bsdf.passage() == Passage::Body;
            let leaves = by_heat.and_then(|_| incandescent_share(&bsdf)).unwrap_or(1.0);
            (refracts, sides.two_sided, textures.cloned(), leaves)
        });
        for (primitive, &surface) in (0..).zip(&shapes.surface_of_primitive) {
            let surface = &shapes.surfaces[surface as usize];
            let lamp = (surface.material, brightness);
            let emitter = match materials.get(surface.material as usize) {
                Some(_) if brightness[surface.material as usize].mean == 0.0 => NONE,
                None => NONE,
                Some((refracts, two_sided, textures, leaves)) => {
                    let painted = textures.as_ref().zip(shapes.painted(primitive));
                    let share = painted.map_or(1.0, |(textures, on)| mean_share(textures, &on));
                    if (primitive as usize) < shapes.triangles.len() {
                        let model = emitter::Triangle::new(shapes, primitive, *two_sided);
                        self.add_share(shapes, model, lamp, share * leaves)
                    } else {
                        let sides = [*two_sided, !surface.is_opaque && !refracts];
                        let model = emitter::Sphere::new(shapes, primitive, sides);
                        self.add_share(shapes, model, lamp, share * leaves)
                    }
                }
            };
            self.emitter_of_primitive.push(emitter);
        }
        // That of air is the last of them.
        materials.len() as u32 + 1
    }

    fn set_probabilities(&mut self) -> Result<(), SceneError> {
        let total: f64 = self.powers.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            let [problem, remedy] = if total > 0.0 {
                ["the lights are too bright to add up", "give them less power"]
            } else {
                [
                    "nothing in the scene emits light at the wavelengths of the render",
                    "add a light, an emissive material or an environment",
                ]
            };
            return Err(SceneError::new("lights", problem, remedy));
        }
        for (row, power) in self.rows.iter_mut().zip(&self.powers) {
            row.probability = (power / total) as f32;
        }
        Ok(())
    }
}
