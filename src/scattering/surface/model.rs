//! What a surface model is: a row of parameters, and functions of eight rows at a time.
//!
//! There are two sorts that paths are scattered by, and a third, [`StraightOn`], that they and
//! connections go through. A [`Specular`] model leaves light one way only
//! (or two), so that it can be drawn and nothing else. A [`Connecting`] model has a value and a
//! density between any two directions, so that its vertices are also connected to emitters, to
//! other vertices and to the sensor, and keep photons and gather them.

use crate::geometry::{RayColumns, SurfaceColumns};
use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::polarization::{Block, Dense};
use crate::scattering::Scene;
use crate::scattering::event::{Elements, Form};
use crate::scattering::side::Side;
use crate::scattering::vertex::DenseKernels;
use crate::scene::baked::{self, Shapes};

use super::facing::Facing;

/// A surface model with its parameters at the wavelengths of the render.
pub trait Surface: Clone {
    /// Whether other bodies may be on its two sides, so that its parameters are of the place: see
    /// [`crate::scattering::nesting`].
    const NESTS: bool = false;

    /// The largest share of light that it scatters, over the wavelengths: within [0, 1], or near
    /// enough to steer roulette by. It looks at neither the path's throughput nor its
    /// polarization (polarizers: of unpolarized light; conductors: at normal incidence).
    fn scattered(&self) -> f32;

    /// How far about the mirrored direction, as `half_sine2`, light is reflected so narrowly that
    /// hardly any photon comes along the right way: closer than this, none merge but paths go on.
    /// 0 where it is not.
    fn peak(&self) -> f32 {
        0.0
    }
}

/// The largest of the values.
pub fn strongest<const N: usize>(values: [f32; N]) -> f32 {
    values.into_iter().fold(0.0, f32::max)
}

/// A model that leaves light one way only, or two.
pub trait Specular<const N: usize>: Surface {
    /// What its kernels are made of.
    type Kernel: Elements;
    /// Whether its kernel is the same at all wavelengths.
    const ACHROMATIC: bool;
    /// Whether light may go on at one wavelength alone.
    const DISPERSES: bool = false;

    /// Sends light on. `choose` draws which way it goes where there are two. With `POLARIZED`, the
    /// kernel is wanted too, else it may be anything.
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        choose: impl FnOnce(OneOfTwo) -> Choice,
        side: Side,
    ) -> Scattered<N, Self::Kernel>;
}

/// The first of two ways that share all light.
pub struct OneOfTwo {
    /// The share of unpolarized light that goes it.
    pub share: F32s,
    /// Its diattenuation about [`Self::axis`].
    pub diattenuation: F32s,
    /// Perpendicular to the light.
    pub axis: Vector<F32s>,
}

/// Which of two ways rows go.
pub struct Choice {
    /// Mask of the rows that go the first one.
    pub first: F32s,
    /// The probability of that, over the share of unpolarized light that goes the same way.
    pub gain: F32s,
}

/// A new direction, what it costs, and what happens to polarization.
pub struct Scattered<const N: usize, K> {
    /// The new direction, unit length.
    pub direction: Vector<F32s>,
    /// What the throughput is multiplied by, but for shading normals; zero where nothing goes on.
    pub weight: [F32s; N],
    /// Kernels; of an achromatic model, the first alone counts.
    pub kernels: [K; N],
    /// The x axis of the kernels' frames, perpendicular to both directions.
    pub axis: Vector<F32s>,
    /// Mask of the rows that go on at the first wavelength alone, of models that disperse light.
    pub alone: F32s,
}

/// A model that lets light straight on, so that paths and connections cross it: no vertex.
pub trait StraightOn<const N: usize>: Surface {
    /// Whether it changes light at all.
    const ACTS: bool;
    /// Whether its kernel is the same at all wavelengths.
    const ACHROMATIC: bool = true;
    /// The form of its kernel: that of a block, or dense.
    const FORM: Form = Form::Block;

    /// Dense kernels, for light that goes from front to back, in the frame of the axis.
    fn matrices(&self) -> [Dense<f32>; N] {
        unreachable!("asked for dense kernels where blocks are")
    }

    /// What it does to light. With `POLARIZED`, the kernel is wanted too, else it may be anything.
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N>;
}

/// What a surface does to light that goes straight on.
pub struct Passage<const N: usize> {
    /// The share of unpolarized light that passes.
    pub transmittance: [F32s; N],
    /// The probability with which paths pass, the same both ways; with the rest they are scattered.
    pub chance: F32s,
    /// Kernels; of an achromatic model, the first alone counts, and of dense ones none.
    pub kernels: [Block<F32s>; N],
    /// The x axis of the kernels' frames, perpendicular to the light.
    pub axis: Vector<F32s>,
}

/// Models that can be connected to, as the stages see them: the table of all rows. The scattering
/// function is [`Connecting::factor`] times [`Connecting::shape`], per steradian, on the side that
/// the light comes from.
pub trait Connecting<const N: usize>: Copy {
    /// What their kernels are made of.
    type Kernel: Elements;
    /// Whether their kernel is the same at all wavelengths.
    const ACHROMATIC: bool;
    /// Whether the shape is one for all directions.
    const IS_EVEN: bool;
    /// Whether [`Connecting::draw`] takes a third number.
    const DECIDES: bool = false;
    /// What the shape depends on besides directions, at eight vertices.
    type Lanes: Copy;

    /// The part of the scattering function that no direction changes: light vertices keep it in
    /// their power.
    fn factor(self, rows: &LaneRows) -> [F32s; N];

    /// What [`Connecting::shape`] needs.
    fn lanes(self, rows: &LaneRows) -> Self::Lanes;

    /// Mask of those that let light go between two directions away from the surface.
    #[inline(always)]
    fn passes(
        _of: &Self::Lanes,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> F32s {
        facing.reflects(given, drawn)
    }

    /// The scattering function over its factor, between two directions away from the surface, for
    /// a path of the `side` that comes from `given`: on sensor paths, of radiance that arrives
    /// along `drawn`, and on light paths of power that leaves there. What stays on one side is the
    /// same for both orders of the two.
    fn shape(
        of: &Self::Lanes,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N];

    /// Density per steradian of [`Connecting::draw`] for the direction `drawn`.
    fn pdf(of: &Self::Lanes, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s;

    /// Draws a direction by three numbers in [0, 1), for a path of the `side` that comes from
    /// `given`, at those of the table's rows that have these lanes.
    fn draw(
        self,
        at: (&LaneRows, &Self::Lanes),
        facing: &Facing,
        given: Vector<F32s>,
        u: [F32s; 3],
        side: Side,
    ) -> Drawn<N>;

    /// The kernels for light that travels along `k_in` and then along `k_out`, and the x axis of
    /// their frames, a unit vector perpendicular to both.
    fn kernels(
        of: &Self::Lanes,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>);

    /// Whether their kernels are dense, which none but some glossy models' are: then
    /// [`Connecting::dense_kernels`] has all elements, and [`Connecting::kernels`] has not.
    #[inline(always)]
    fn is_dense(_of: &Self::Lanes) -> bool {
        false
    }

    /// [`Connecting::kernels`] with all elements.
    #[inline(always)]
    fn dense_kernels(
        of: &Self::Lanes,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> DenseKernels<N> {
        let (kernels, axis) = Self::kernels(of, facing, k_in, k_out);
        (kernels.map(Elements::dense), axis)
    }
}

/// A direction that was drawn.
pub struct Drawn<const N: usize> {
    /// Away from the surface, unit length.
    pub direction: Vector<F32s>,
    /// Its density per steradian.
    pub pdf: F32s,
    /// Scattering function times the shading normal's cosine, over the density; finite.
    pub weight: [F32s; N],
    /// Mask of those that the density does not count: they have been lost, and weigh nothing.
    pub lost: F32s,
}

/// Rows of a table that eight lanes look at.
#[derive(Clone, Copy)]
pub enum LaneRows {
    /// One of them.
    Same(usize),
    /// One each.
    Each([usize; LANES]),
}

impl LaneRows {
    /// A number for every lane.
    #[inline(always)]
    pub fn gather(&self, of: impl Fn(usize) -> f32) -> F32s {
        match self {
            Self::Same(row) => F32s::splat(of(*row)),
            Self::Each(rows) => F32s::from(lanes::each(|lane| of(rows[lane]))),
        }
    }

    /// The rows of another table that these lead to.
    #[inline(always)]
    pub fn map(&self, of: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::Same(row) => Self::Same(of(*row)),
            Self::Each(rows) => Self::Each(lanes::each(|lane| of(rows[lane]))),
        }
    }

    /// A word for every lane.
    #[inline(always)]
    pub fn words(&self, of: impl Fn(usize) -> u32) -> U32s {
        match self {
            Self::Same(row) => U32s::splat(of(*row)),
            Self::Each(rows) => U32s::from(lanes::each(|lane| of(rows[lane]))),
        }
    }

    /// The rows as numbers.
    #[inline(always)]
    pub fn numbers(&self) -> U32s {
        self.words(|row| row as u32)
    }
}

/// The parameters of one model at eight vertices.
pub struct ModelLanes<'a, M> {
    /// Their rows in the model's table.
    pub rows: LaneRows,
    models: Models<'a, M>,
}

/// What [`LaneRows`] lead to, looked up once for all parameters.
enum Models<'a, M> {
    Same(&'a M),
    Each([&'a M; LANES]),
}

impl<'a, M> ModelLanes<'a, M> {
    /// Those in the rows `rows` of the model's table.
    #[inline(always)]
    pub fn new(models: &'a [M], rows: LaneRows) -> Self {
        let of = match rows {
            LaneRows::Same(row) => Models::Same(&models[row]),
            LaneRows::Each(rows) => {
                let mut of = [&models[rows[0]]; LANES];
                for (of, row) in of.iter_mut().zip(rows) {
                    *of = &models[row];
                }
                Models::Each(of)
            }
        };
        Self { rows, models: of }
    }

    /// All of them.
    #[inline(always)]
    pub fn each(&self) -> [&'a M; LANES] {
        match self.models {
            Models::Same(model) => [model; LANES],
            Models::Each(models) => models,
        }
    }

    /// One parameter.
    #[inline(always)]
    pub fn field(&self, of: impl Fn(&M) -> f32) -> F32s {
        match self.models {
            Models::Same(model) => F32s::splat(of(model)),
            Models::Each(models) => F32s::from(lanes::each(|lane| of(models[lane]))),
        }
    }

    /// One parameter at every wavelength.
    #[inline(always)]
    pub fn spectrum<const N: usize>(&self, of: impl Fn(&M) -> &[f32; N]) -> [F32s; N] {
        match self.models {
            Models::Same(model) => of(model).map(F32s::splat),
            Models::Each(models) => {
                let mut rows = [of(models[0]); LANES];
                for (row, model) in rows.iter_mut().zip(models) {
                    *row = of(model);
                }
                by_wavelength(&rows)
            }
        }
    }
}

/// Eight spectra, wavelength by wavelength.
// Out of line: models have a dozen of them.
#[inline(never)]
fn by_wavelength<const N: usize>(rows: &[&[f32; N]; LANES]) -> [F32s; N] {
    let mut values = [F32s::splat(0.0); N];
    for (n, value) in values.iter_mut().enumerate() {
        *value = F32s::from(lanes::each(|lane| rows[lane][n]));
    }
    values
}

/// Eight rays that have met surfaces of one model.
pub struct Incidence<'a, M> {
    /// Where the rays go.
    pub direction: Vector<F32s>,
    /// Geometric normal, to the front.
    pub geometric: Vector<F32s>,
    /// Shading normal, against the ray.
    pub normal: Vector<F32s>,
    /// Cosine between the ray and the shading normal, 0 to 1.
    pub cos_i: F32s,
    /// Mask of the rows that come from the front.
    pub front: F32s,
    /// Mask of the rows that dispersion has sent on at one wavelength; none are known at first.
    pub collapsed: F32s,
    /// The model's parameters.
    pub models: ModelLanes<'a, M>,
    /// Mask of the rows whose back scatters too.
    pub two_sided: F32s,
    shapes: &'a Shapes,
    surface: [u32; LANES],
}

impl<'a, M: Surface> Incidence<'a, M> {
    /// The rows from `row` on, of which `live` are in use, with the `rays` that have come there.
    /// `models` is the table of the model.
    #[inline(always)]
    pub fn load<const N: usize>(
        scene: &'a Scene<N>,
        models: &'a [M],
        surfaces: &SurfaceColumns,
        rays: &RayColumns,
        (row, live): (usize, usize),
    ) -> Self {
        let direction = Vector::load(&rays.direction, row);
        let geometric = Vector::load(&surfaces.geometric_normal, row);
        let normal = against(Vector::load(&surfaces.shading_normal, row), direction);
        let used = |lane: usize| row + lane.min(live - 1);
        let of_lanes = LaneRows::Each(lanes::each(used));
        let (rows, two_sided) = scene.models_of_hits(surfaces, &of_lanes);
        Self {
            direction,
            geometric,
            normal,
            cos_i: (-direction.dot(normal)).min(F32s::splat(1.0)),
            front: direction.dot(geometric).simd_lt(F32s::splat(0.0)),
            collapsed: F32s::splat(0.0),
            models: ModelLanes::new(models, rows),
            two_sided,
            shapes: &scene.shapes,
            surface: lanes::each(|lane| surfaces.surface[used(lane)]),
        }
    }

    /// What the surfaces have in common where the rays have met them.
    #[inline(always)]
    pub fn surface(&self, lane: usize) -> &baked::Surface {
        &self.shapes.surfaces[self.surface[lane] as usize]
    }

    /// Mask of the rows that `drawn` keeps on the geometric side that they come from.
    #[inline(always)]
    pub fn stays(&self, drawn: Vector<F32s>) -> F32s {
        (drawn.dot(self.geometric) * self.direction.dot(self.geometric)).simd_lt(F32s::splat(0.0))
    }
}

/// The mirrored direction of `direction` at `normal`.
#[inline(always)]
pub fn reflect(direction: Vector<F32s>, normal: Vector<F32s>) -> Vector<F32s> {
    normal.mul_add(direction.dot(normal) * F32s::splat(-2.0), direction)
}

/// The refracted direction of `direction` at `normal`, which points against it, for the cosines
/// of incidence and refraction and `eta`, the index behind over the index before.
#[inline(always)]
pub fn refract(
    direction: Vector<F32s>,
    normal: Vector<F32s>,
    cos_i: F32s,
    cos_t: F32s,
    eta: F32s,
) -> Vector<F32s> {
    let inverse = F32s::splat(1.0) / eta;
    (direction * inverse + normal * (cos_i * inverse - cos_t)).normalize()
}

/// `normal` turned against `direction`.
#[inline(always)]
fn against(normal: Vector<F32s>, direction: Vector<F32s>) -> Vector<F32s> {
    Vector::select(direction.dot(normal).simd_gt(F32s::splat(0.0)), -normal, normal)
}
