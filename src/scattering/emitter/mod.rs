//! Light sources, a file for each model, behind the trait [`Emits`]: as the start of light paths,
//! as what sensor paths meet, and as chosen from points of the scene (`direct`).
//!
//! Densities follow Georgiev et al. 2012: `direct` is that of choosing the point (or direction)
//! when connecting, `emission` that of starting a light path there; both include the probability
//! of choosing the emitter, each its own (`choice`). How light is polarized as it starts is known
//! apart from all that (`state`): nothing is drawn by it.

mod area;
mod directional;
mod environment;
mod infinity;
mod panorama;
mod patterned;
mod point;
mod sphere;
mod spherical;
mod spot;
mod sun;
mod triangle;

pub mod aim;
pub mod choice;
pub mod direct;
pub mod glimpse;
pub mod incandescence;
pub mod lamps;
pub mod state;
pub mod tree;

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, NONE, Shapes};
use crate::scene::emitter::{
    Directional, EmitterModel, Environment, Extent, Panorama, Patterned, Point, Sphere, Spot, Sun,
    Triangle, for_all_emitters,
};

use crate::scene::pattern::Pattern;
use crate::spectrum::Carried;

use super::Scene;

use self::aim::Line;
use self::direct::{DirectLanes, Own, OwnLanes, Tables};
use self::tree::{Outline, Vantage};

/// What the stages ask of a model of emitters.
pub trait Emits: Extent {
    /// Whether paths cannot meet it by chance: it has neither an area nor a solid angle.
    const DELTA: bool;

    /// What [`Self::choose`] is to know of an emitter that starts light paths with `probability`.
    fn record(&self, shapes: &Shapes, probability: f32) -> Own;

    /// Chooses a point of, or direction to, eight emitters from the points `reference`;
    /// `radiance` is theirs (or intensity, or irradiance) and `chance` the probability with which
    /// they have been chosen.
    fn choose<const N: usize>(
        own: (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N>;

    /// The density of what [`Self::choose`] chooses from `reference`, once it has been chosen: per
    /// area at `point`, which is seen along `direction`; per steradian of that at infinity; 1 for
    /// what has no choice.
    fn density(&self, shapes: &Shapes, reference: Vec3, point: Vec3, direction: Vec3) -> f32;

    /// How it looks from elsewhere, for a radiance of one.
    fn outline(&self, shapes: &Shapes) -> Outline;

    /// How many times as dense light paths are that are aimed at a ball as those that are aimed at
    /// the whole scene; none if they are not: the ball is not small as seen from the emitter, or
    /// gets no light. Of an area, about so many: each of its points has its own.
    fn gain_of_aim(&self, _shapes: &Shapes, _ball: &Bounds) -> Option<f32> {
        None
    }

    /// About the share of all directions that its light takes up, if it is infinitely far away and
    /// can be met.
    fn share_of_sky(&self) -> Option<f64> {
        None
    }

    /// Area of its surface in square scene units, if it has one.
    fn area(&self) -> Option<f32> {
        None
    }

    /// Sides that emit of an emitter with an area; zero for others.
    fn sides_of_area(&self) -> f32 {
        0.0
    }

    /// Starts a light path: its densities are those of paths that are aimed at the whole scene.
    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N>;

    /// What a ray along `direction` sees that has met the emitter at `position`; none if that does
    /// not emit towards it, or cannot be met.
    fn met<const N: usize>(
        &self,
        _source: &Source<N>,
        _position: Vec3,
        _direction: Vec3,
    ) -> Option<MetEmission<N>> {
        None
    }

    /// The largest coordinate of the emitter's primitive; zero without one.
    fn reach(&self, _shapes: &Shapes) -> f32 {
        0.0
    }

    /// Its primitive, if it has one; else [`NONE`].
    fn primitive(&self) -> u32 {
        NONE
    }

    /// Whether it shines to its back too.
    fn is_two_sided(&self) -> bool {
        false
    }

    /// Points all over it, with its front's normals, zero if it has no surface; none if it is
    /// infinitely far away.
    fn places(&self, _shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
        Vec::new()
    }
}

/// An emitter without its model, and the scene around it.
#[derive(Clone, Copy)]
pub struct Source<'a, const N: usize> {
    /// Its row in the scene's emitters.
    pub row: usize,
    /// Its radiance, intensity or irradiance.
    pub radiance: [f32; N],
    /// Probability of starting a light path at it.
    pub probability: f32,
    /// Where everything is.
    pub shapes: &'a Shapes,
    /// What some emit by direction.
    pub patterns: &'a [Pattern],
    /// What the columns carry.
    pub carried: &'a Carried<N>,
    /// What the light path is aimed at; if nothing, at the whole scene.
    pub aimed_at: Option<Bounds>,
}

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample<const N: usize> {
    /// Where it starts.
    pub position: Vec3,
    /// Geometric normal there; zero for emitters without a surface.
    pub normal: Vec3,
    /// Where it goes, unit length.
    pub direction: Vec3,
    /// Emitted radiance over `emission` density, cosine included.
    pub beta: [f32; N],
    /// Radiance along `direction`; per steradian intensity for points. Of incandescent surfaces
    /// that of a black body, the same in all directions.
    pub radiance: [f32; N],
    /// Density of starting here: per area, or per steradian of the direction (infinite emitters).
    pub start_pdf: f32,
    /// `emission` density.
    pub emission_pdf: f32,
    /// Cosine at the emitter, 1 where it has no surface.
    pub cos_at_light: f32,
    /// At a finite distance.
    pub finite: bool,
    /// Both sides of the surface emit.
    pub two_sided: bool,
    /// Paths cannot meet the emitter by chance.
    pub delta: bool,
    /// Its row in the scene's emitters.
    pub emitter: usize,
}

impl<const N: usize> EmissionSample<N> {
    /// The cosine at which the emitter is seen that sends light along `direction`, 1 at infinity;
    /// not above zero where nothing is sent there.
    pub fn cosine_seen(&self, direction: Vec3) -> f32 {
        match (self.finite, self.two_sided) {
            (false, _) => 1.0,
            (true, true) => direction.dot(self.normal).abs(),
            (true, false) => direction.dot(self.normal),
        }
    }
}

/// What a sensor path meets.
#[derive(Clone, Copy, Debug)]
pub struct MetEmission<const N: usize> {
    /// Radiance towards the sensor.
    pub radiance: [f32; N],
    /// What [`Emits::density`] says, if it is known already.
    pub density: Option<f32>,
    /// `emission` density of light paths that are aimed at all of the scene ([`aimed_pdf`]).
    pub emission_pdf: f32,
    /// Cosine at the emitter, 1 for the environment.
    pub cos_at_light: f32,
    /// The normal to its front; zero for the environment.
    pub normal: Vec3,
}

/// Starts a light path; `u_aim` says what it is aimed at, if paths are.
pub fn sample_emission<const N: usize>(
    scene: &Scene<N>,
    choice: [f32; 2],
    u_aim: f32,
    u_position: [f32; 2],
    u_direction: [f32; 2],
) -> EmissionSample<N> {
    let row = scene.choice.by_power(choice);
    let model = &scene.optics.emitters[row].model;
    let source = source(scene, row);
    let Some(aim) = &scene.aim else {
        return tinted(scene, emit(model, &source, u_position, u_direction));
    };
    let drawn = aim.draw(row, u_aim);
    let source = Source { aimed_at: drawn.map(|ball| aim.ball(ball)), ..source };
    let mut sample = emit(model, &source, u_position, u_direction);
    aim.weigh(&mut sample, drawn);
    tinted(scene, sample)
}

/// The same light as textures paint it and as it comes out of the surface.
#[inline]
fn tinted<const N: usize>(scene: &Scene<N>, mut sample: EmissionSample<N>) -> EmissionSample<N> {
    if scene.has_painted_lamps {
        let tint = scene.tint(sample.emitter, sample.position, -sample.direction);
        for (n, tint) in tint.into_iter().enumerate() {
            sample.beta[n] *= tint;
            sample.radiance[n] *= tint;
        }
    }
    if scene.has_incandescent_lamps() {
        let shares = scene.emissivity(sample.emitter, sample.normal, sample.direction);
        sample.beta.iter_mut().zip(shares).for_each(|(beta, share)| *beta *= share);
    }
    sample
}

/// What a ray along `direction` sees of an emitter that it has met, by the row of that; none if it
/// does not emit towards the ray. `position` is the point hit, or any point of the ray.
pub fn met_emission<const N: usize>(
    scene: &Scene<N>,
    row: usize,
    position: Vec3,
    direction: Vec3,
) -> Option<MetEmission<N>> {
    let mut met = met(&scene.optics.emitters[row].model, &source(scene, row), position, direction)?;
    // What comes from where a picture of all directions knows itself.
    if scene.has_painted_lamps && scene.panorama(row).is_none() {
        let tint = scene.tint(row, position, direction);
        met.radiance.iter_mut().zip(tint).for_each(|(radiance, tint)| *radiance *= tint);
    }
    if scene.has_incandescent_lamps() {
        let shares = scene.emissivity(row, met.normal, -direction);
        met.radiance.iter_mut().zip(shares).for_each(|(radiance, share)| *radiance *= share);
    }
    Some(met)
}

/// The `emission` density of what has been met: of light paths that are aimed, if they are.
pub fn aimed_pdf<const N: usize>(
    scene: &Scene<N>,
    emitter: usize,
    met: &MetEmission<N>,
    (point, direction): (Vec3, Vec3),
) -> f32 {
    let line = Line { emitter, point, normal: met.normal, direction: -direction };
    scene.aim.as_ref().map_or(1.0, |aim| aim.gain(line)) * met.emission_pdf
}

/// The `direct` density of a point of an emitter, seen along `direction`, or of the direction; of
/// what has been met there it may be `known` but for the choice.
pub fn direct_pdf<const N: usize>(
    scene: &Scene<N>,
    (row, known): (usize, Option<f32>),
    from: &Vantage,
    (point, direction): (Vec3, Vec3),
) -> f32 {
    let model = &scene.optics.emitters[row].model;
    let density = || density(model, &scene.shapes, from.position, (point, direction));
    chance_of_choice(scene, row, from) * known.unwrap_or_else(density)
}

/// The probability with which a vertex chooses an emitter to connect to.
pub fn chance_of_choice<const N: usize>(scene: &Scene<N>, row: usize, from: &Vantage) -> f32 {
    match scene.choice.depends_on_vantage() {
        true => scene.choice.chance(from, row),
        false => scene.optics.emitters[row].probability,
    }
}

fn source<const N: usize>(scene: &Scene<N>, row: usize) -> Source<'_, N> {
    let emitter = &scene.optics.emitters[row];
    let (radiance, probability) = (scene.optics.radiance_of(row), emitter.probability);
    let (shapes, patterns, carried) =
        (&*scene.shapes, &*scene.optics.patterns, &scene.optics.carried);
    Source { row, radiance, probability, shapes, patterns, carried, aimed_at: None }
}

/// What is made from the list of all models: their kinds, and the functions of [`Emits`] for
/// whichever model an emitter has.
macro_rules! dispatched {
    ($($Model:ident),*) => {
        /// Which model an emitter has, for loops that go by kind.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        enum Kind {
            $($Model,)*
        }

        impl Kind {
            const ALL: &[Self] = &[$(Self::$Model),*];

            fn of(model: &EmitterModel) -> Self {
                match model {
                    $(EmitterModel::$Model(_) => Self::$Model,)*
                }
            }

            /// [`Emits::choose`].
            #[inline(always)]
            fn choose<const N: usize>(
                self,
                own: (&OwnLanes, &Tables),
                reference: Vector<F32s>,
                radiance: [F32s; N],
                chance: F32s,
                u: [F32s; 2],
            ) -> DirectLanes<N> {
                match self {
                    $(Self::$Model => $Model::choose(own, reference, radiance, chance, u),)*
                }
            }
        }

        /// [`Emits::DELTA`].
        pub fn is_delta(model: &EmitterModel) -> bool {
            match model {
                $(EmitterModel::$Model(_) => $Model::DELTA,)*
            }
        }

        /// [`Emits::primitive`].
        pub fn primitive(model: &EmitterModel) -> u32 {
            match model {
                $(EmitterModel::$Model(model) => Emits::primitive(model),)*
            }
        }

        /// [`Emits::is_two_sided`].
        pub fn is_two_sided(model: &EmitterModel) -> bool {
            match model {
                $(EmitterModel::$Model(model) => model.is_two_sided(),)*
            }
        }

        /// [`Emits::places`].
        pub fn places(model: &EmitterModel, shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
            match model {
                $(EmitterModel::$Model(model) => model.places(shapes),)*
            }
        }

        /// [`Emits::reach`].
        pub fn reach(model: &EmitterModel, shapes: &Shapes) -> f32 {
            match model {
                $(EmitterModel::$Model(model) => model.reach(shapes),)*
            }
        }

        /// [`Emits::outline`].
        fn outline(model: &EmitterModel, shapes: &Shapes) -> Outline {
            match model {
                $(EmitterModel::$Model(model) => model.outline(shapes),)*
            }
        }

        /// [`Emits::density`].
        fn density(
            model: &EmitterModel,
            shapes: &Shapes,
            reference: Vec3,
            (point, direction): (Vec3, Vec3),
        ) -> f32 {
            match model {
                $(EmitterModel::$Model(model) => {
                    model.density(shapes, reference, point, direction)
                })*
            }
        }

        /// [`Emits::gain_of_aim`].
        fn gain_of_aim(model: &EmitterModel, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
            match model {
                $(EmitterModel::$Model(model) => model.gain_of_aim(shapes, ball),)*
            }
        }

        /// [`Emits::share_of_sky`].
        pub fn share_of_sky(model: &EmitterModel) -> Option<f64> {
            match model {
                $(EmitterModel::$Model(model) => model.share_of_sky(),)*
            }
        }

        /// [`Emits::area`].
        fn area(model: &EmitterModel) -> Option<f32> {
            match model {
                $(EmitterModel::$Model(model) => model.area(),)*
            }
        }

        /// [`Emits::sides_of_area`].
        fn sides_of_area(model: &EmitterModel) -> f32 {
            match model {
                $(EmitterModel::$Model(model) => model.sides_of_area(),)*
            }
        }

        fn record(model: &EmitterModel, shapes: &Shapes, probability: f32) -> Own {
            match model {
                $(EmitterModel::$Model(model) => model.record(shapes, probability),)*
            }
        }

        fn emit<const N: usize>(
            model: &EmitterModel,
            source: &Source<N>,
            u_position: [f32; 2],
            u_direction: [f32; 2],
        ) -> EmissionSample<N> {
            match model {
                $(EmitterModel::$Model(model) => model.emit(source, u_position, u_direction),)*
            }
        }

        fn met<const N: usize>(
            model: &EmitterModel,
            source: &Source<N>,
            position: Vec3,
            direction: Vec3,
        ) -> Option<MetEmission<N>> {
            match model {
                $(EmitterModel::$Model(model) => model.met(source, position, direction),)*
            }
        }
    };
}
for_all_emitters!(dispatched);
