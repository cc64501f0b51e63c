//! Vertices that can be connected to, eight at a time: on surfaces and in media alike.
//!
//! Stages ask with `for_scatterer!` for code that is compiled for what their rows have met, and
//! work on [`Scatterer`] and [`Vertices`] there.

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Real, U32s, Vector, lanes};
use crate::polarization::{Arrival, Dense, Kernel, LightCarrier, SpheroidBlock, Stokes, s_axis};

use super::Scene;
use super::event::{Elements, Form, spheroids};
use super::medium::Medium;
use super::phase::{Scatters, half_sine2};
use super::side::Side;
use super::surface::model::LaneRows;
use super::surface::{Connecting, Facing};

/// What rows have met: all surfaces of one model, or one medium.
pub trait Scatterer<const N: usize>: Copy {
    /// Eight vertices.
    type Vertices: Vertices<N>;
    /// Whether what leaves can be polarized.
    const POLARIZES: bool;

    /// The vertices in some rows.
    fn at(self, surfaces: &SurfaceColumns, rows: impl RowLanes) -> Self::Vertices;

    /// Light vertices that were kept; [`Vertices::factor`] is in their power.
    fn kept(self, kept: KeptLanes) -> Self::Vertices;
}

/// Eight vertices of a scatterer. Directions are unit vectors: `given`, to where the path comes
/// from, and `drawn` point away from the vertex, `k_in` and `k_out` along the light.
pub trait Vertices<const N: usize>: Copy {
    /// Whether what they do to photons is one for all directions but for the sides of surfaces.
    const IS_EVEN: bool;

    /// The part of the scattering function that no direction changes.
    fn factor(&self) -> [F32s; N];

    /// What light vertices keep besides their power.
    fn keep(&self) -> KeptLanes;

    /// The turn of a sensor path.
    fn turn(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N>;

    /// The turn of a light path: with shading normals, not the same.
    fn turn_of_light(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N>;

    /// What of a photon's power is scattered along `k_out`, over [`Self::per_photon`].
    fn merge(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> [F32s; N];

    /// What every photon's power is multiplied by.
    fn per_photon(&self) -> [F32s; N];

    /// The kernels, and the x axis of their frames.
    fn kernels(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N>;

    /// [`Self::merge`] and [`Self::kernels`] by one look; the axis may have any length.
    fn merge_polarized(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> ([F32s; N], Kernels<N>);

    /// Whether the kernels are dense: [`Self::kernels`] are not all of them, and light is to be
    /// given to [`Self::scatter`].
    #[inline(always)]
    fn is_dense(&self) -> bool {
        false
    }

    /// All elements of the kernels that there are.
    #[inline(always)]
    fn leaving(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Leaving<N> {
        Leaving::Blocks(self.kernels(k_in, k_out))
    }

    /// Light that arrives along `k_in` leaves along `k_out`.
    fn scatter(&self, k_in: Vector<F32s>, k_out: Vector<F32s>, light: &mut LightLanes<N>);
}

/// Eight rays of light at every wavelength.
#[derive(Clone, Copy, Debug)]
pub struct LightLanes<const N: usize> {
    /// Their states.
    pub stokes: [Stokes<F32s>; N],
    /// The reference axis, perpendicular to the light.
    pub x: Vector<F32s>,
}

impl<const N: usize> LightLanes<N> {
    /// The light after an event whose axis is `axis`; before, it travels along `k_in`.
    #[inline(always)]
    pub fn pass<K: Kernel<F32s>>(
        &mut self,
        k_in: Vector<F32s>,
        (kernels, axis): &([K; N], Vector<F32s>),
    ) {
        let arrival = Arrival::between(self.x, *axis, k_in);
        for (stokes, &kernel) in self.stokes.iter_mut().zip(kernels) {
            let light = LightCarrier { stokes: *stokes, x: self.x };
            *stokes = light.scatter(&arrival, kernel).stokes;
        }
        self.x = *axis;
    }
}

/// Kernels over M00 at every wavelength, and the x axis of their frames: perpendicular to the
/// light before and after.
pub type Kernels<const N: usize> = ([SpheroidBlock<F32s>; N], Vector<F32s>);

/// The same with all elements.
pub type DenseKernels<const N: usize> = ([Dense<F32s>; N], Vector<F32s>);

/// Kernels of some form.
// One of them at a time is on the stack.
#[allow(clippy::large_enum_variant, reason = "it is built, used and forgotten in one place")]
pub enum Leaving<const N: usize> {
    /// Blocks on the diagonal.
    Blocks(Kernels<N>),
    /// All elements.
    Dense(DenseKernels<N>),
}

/// Which rows of columns eight lanes hold.
pub trait RowLanes: Copy {
    /// The rows of the lanes.
    fn rows(self) -> LaneRows;

    /// Reads a column of vectors.
    fn vectors(self, columns: &[Vec<f32>; 3]) -> Vector<F32s>;
}

/// The rows from the first on; the second says how many are in use.
#[derive(Clone, Copy)]
pub struct Consecutive(pub usize, pub usize);

impl RowLanes for Consecutive {
    #[inline(always)]
    fn rows(self) -> LaneRows {
        LaneRows::Each(lanes::each(|lane| self.0 + lane.min(self.1 - 1)))
    }

    #[inline(always)]
    fn vectors(self, columns: &[Vec<f32>; 3]) -> Vector<F32s> {
        Vector::load(columns, self.0)
    }
}

/// One row in all lanes.
#[derive(Clone, Copy)]
pub struct Same(pub usize);

impl RowLanes for Same {
    #[inline(always)]
    fn rows(self) -> LaneRows {
        LaneRows::Same(self.0)
    }

    #[inline(always)]
    fn vectors(self, columns: &[Vec<f32>; 3]) -> Vector<F32s> {
        Vector::splat(lanes::row_of(columns, self.0))
    }
}

/// Any rows.
impl RowLanes for [usize; LANES] {
    #[inline(always)]
    fn rows(self) -> LaneRows {
        LaneRows::Each(self)
    }

    #[inline(always)]
    fn vectors(self, columns: &[Vec<f32>; 3]) -> Vector<F32s> {
        Vector::gather(|lane| lanes::row_of(columns, self[lane]))
    }
}

/// What eight vertices of one scatterer are found again by.
#[derive(Clone, Copy)]
pub struct KeptLanes {
    /// Their normals; zero in media, which have none.
    pub facing: Facing,
    /// The rows in the table of their model, else 0; so too in lanes that hold other vertices.
    pub rows: U32s,
}

/// What a vertex does to light between two directions.
#[derive(Clone, Copy)]
pub struct Turn<const N: usize> {
    /// Scattering function, times the cosine on a surface; zero where no light can pass.
    pub value: [F32s; N],
    /// Density per steradian of drawing the direction, averaged over the wavelengths.
    pub pdf: F32s,
    /// Density per steradian of drawing the given direction from the drawn one.
    pub pdf_reverse: F32s,
    /// What turns a density per steradian and inverse square of distance into one at the vertex,
    /// as far as strategies are weighed: the cosine, or the density of the medium. It stands for
    /// itself in all strategies, so that transmittance need not be known (any weights do that add
    /// up to one over the strategies of a path).
    pub measure: F32s,
}

impl<const N: usize> Turn<N> {
    /// No light, no way.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = F32s::splat(0.0);
        Self { value: [zero; N], pdf: zero, pdf_reverse: zero, measure: zero }
    }

    /// `if_true` where the mask holds, `if_false` elsewhere.
    #[inline(always)]
    pub fn select(mask: F32s, if_true: Self, if_false: Self) -> Self {
        let select = |a: F32s, b: F32s| Real::select(mask, a, b);
        let mut value = if_false.value;
        for (value, &chosen) in value.iter_mut().zip(&if_true.value) {
            *value = select(chosen, *value);
        }
        Self {
            value,
            pdf: select(if_true.pdf, if_false.pdf),
            pdf_reverse: select(if_true.pdf_reverse, if_false.pdf_reverse),
            measure: select(if_true.measure, if_false.measure),
        }
    }
}

/// Surfaces of one model.
#[derive(Clone, Copy)]
pub struct OnSurfaces<'a, M, const N: usize> {
    scene: &'a Scene<N>,
    /// The table of the model.
    pub models: M,
}

impl<'a, M: Connecting<N>, const N: usize> OnSurfaces<'a, M, N> {
    /// Those of the scene whose model has the table `models`.
    #[inline(always)]
    pub fn new(scene: &'a Scene<N>, models: M) -> Self {
        Self { scene, models }
    }

    /// The rows in the table of those in some rows, and their normals.
    #[inline(always)]
    pub fn load(self, surfaces: &SurfaceColumns, rows: impl RowLanes) -> (LaneRows, Facing) {
        let (models, two_sided) = self.scene.models_of_hits(surfaces, &rows.rows());
        let facing = Facing {
            geometric: rows.vectors(&surfaces.geometric_normal),
            shading: rows.vectors(&surfaces.shading_normal),
            two_sided,
        };
        (models, facing)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct SurfaceVertices<M: Connecting<N>, const N: usize> {
    kept: KeptLanes,
    factor: [F32s; N],
    lanes: M::Lanes,
}

impl<M: Connecting<N>, const N: usize> Scatterer<N> for OnSurfaces<'_, M, N> {
    type Vertices = SurfaceVertices<M, N>;
    const POLARIZES: bool = !matches!(M::Kernel::FORM, Form::Depolarizer);

    #[inline(always)]
    fn at(self, surfaces: &SurfaceColumns, rows: impl RowLanes) -> Self::Vertices {
        let (rows, facing) = self.load(surfaces, rows);
        let kept = KeptLanes { facing, rows: rows.numbers() };
        let Self { models, .. } = self;
        SurfaceVertices { kept, factor: models.factor(&rows), lanes: models.lanes(&rows) }
    }

    #[inline(always)]
    fn kept(self, kept: KeptLanes) -> Self::Vertices {
        let rows = LaneRows::Each(kept.rows.to_array().map(|row| row as usize));
        let lanes = self.models.lanes(&rows);
        SurfaceVertices { kept, factor: [F32s::splat(1.0); N], lanes }
    }
}

impl<M: Connecting<N>, const N: usize> SurfaceVertices<M, N> {
    /// The turn, where the cosine of the drawn direction comes with a factor.
    #[inline(always)]
    fn turned(
        &self,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        (side, scaled): (Side, impl FnOnce(F32s) -> F32s),
    ) -> Turn<N> {
        let facing = &self.kept.facing;
        let cosine = scaled(drawn.dot(facing.shading).abs());
        let passes = M::passes(&self.lanes, facing, given, drawn);
        let mut value = M::shape(&self.lanes, facing, given, drawn, side);
        for (value, &factor) in value.iter_mut().zip(&self.factor) {
            *value = passes & (factor * *value * cosine);
        }
        Turn {
            value,
            pdf: M::pdf(&self.lanes, facing, given, drawn),
            pdf_reverse: M::pdf(&self.lanes, facing, drawn, given),
            measure: drawn.dot(facing.geometric).abs(),
        }
    }
}

impl<M: Connecting<N>, const N: usize> Vertices<N> for SurfaceVertices<M, N> {
    const IS_EVEN: bool = M::IS_EVEN;

    #[inline(always)]
    fn factor(&self) -> [F32s; N] {
        self.factor
    }

    #[inline(always)]
    fn keep(&self) -> KeptLanes {
        self.kept
    }

    #[inline(always)]
    fn turn(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N> {
        self.turned(given, drawn, (Side::Sensor, |cosine| cosine))
    }

    #[inline(always)]
    fn turn_of_light(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N> {
        let adjoint = |cosine| self.kept.facing.adjoint(given, drawn) * cosine;
        self.turned(given, drawn, (Side::Light, adjoint))
    }

    /// Photons count by the geometric normal, and the integral asks for the shading normal.
    #[inline(always)]
    fn merge(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> [F32s; N] {
        let facing = &self.kept.facing;
        let passes = M::passes(&self.lanes, facing, k_out, -k_in);
        let ratio = k_in.dot(facing.shading) / k_in.dot(facing.geometric);
        let mut value = M::shape(&self.lanes, facing, k_out, -k_in, Side::Sensor);
        value.iter_mut().for_each(|value| *value = passes & (*value * ratio));
        value
    }

    #[inline(always)]
    fn per_photon(&self) -> [F32s; N] {
        self.factor
    }

    #[inline(always)]
    fn kernels(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N> {
        let (kernels, axis) = M::kernels(&self.lanes, &self.kept.facing, k_in, k_out);
        (spheroids(&kernels), axis)
    }

    #[inline(always)]
    fn merge_polarized(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> ([F32s; N], Kernels<N>) {
        (self.merge(k_in, k_out), self.kernels(k_in, k_out))
    }

    #[inline(always)]
    fn is_dense(&self) -> bool {
        M::is_dense(&self.lanes)
    }

    #[inline(always)]
    fn leaving(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Leaving<N> {
        match M::is_dense(&self.lanes) {
            true => Leaving::Dense(M::dense_kernels(&self.lanes, &self.kept.facing, k_in, k_out)),
            false => Leaving::Blocks(self.kernels(k_in, k_out)),
        }
    }

    #[inline(never)]
    fn scatter(&self, k_in: Vector<F32s>, k_out: Vector<F32s>, light: &mut LightLanes<N>) {
        light.pass(k_in, &M::dense_kernels(&self.lanes, &self.kept.facing, k_in, k_out));
    }
}

/// A medium with the phase function `P`; any vertex in it is like any other.
pub struct InMedium<'a, P, const N: usize> {
    /// What it is.
    pub medium: &'a Medium<N>,
    /// How it scatters.
    pub phase: &'a P,
}

impl<P, const N: usize> Clone for InMedium<'_, P, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P, const N: usize> Copy for InMedium<'_, P, N> {}

impl<P: Scatters<N>, const N: usize> Scatterer<N> for InMedium<'_, P, N> {
    type Vertices = Self;
    const POLARIZES: bool = P::POLARIZES;

    #[inline(always)]
    fn at(self, _surfaces: &SurfaceColumns, _rows: impl RowLanes) -> Self {
        self
    }

    #[inline(always)]
    fn kept(self, _kept: KeptLanes) -> Self {
        self
    }
}

impl<P: Scatters<N>, const N: usize> Vertices<N> for InMedium<'_, P, N> {
    const IS_EVEN: bool = false;

    #[inline(always)]
    fn factor(&self) -> [F32s; N] {
        [F32s::splat(1.0); N]
    }

    #[inline(always)]
    fn keep(&self) -> KeptLanes {
        KeptLanes { facing: Facing::none(), rows: U32s::splat(0) }
    }

    #[inline(always)]
    fn turn(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N> {
        let value = self.phase.values(half_sine2(-given, drawn));
        let pdf = mean(&value);
        Turn { value, pdf, pdf_reverse: pdf, measure: F32s::splat(self.medium.density) }
    }

    #[inline(always)]
    fn turn_of_light(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Turn<N> {
        self.turn(given, drawn)
    }

    #[inline(always)]
    fn merge(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> [F32s; N] {
        self.phase.values(half_sine2(k_in, k_out))
    }

    /// The power of photons counts scatterings: over the coefficient, it is fluence.
    #[inline(always)]
    fn per_photon(&self) -> [F32s; N] {
        let mut factors = [F32s::splat(0.0); N];
        for (factor, &sigma_s) in factors.iter_mut().zip(&self.medium.sigma_s) {
            *factor = F32s::splat(if sigma_s > 0.0 { 1.0 / sigma_s } else { 0.0 });
        }
        factors
    }

    #[inline(always)]
    fn kernels(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N> {
        (self.phase.kernels(half_sine2(k_in, k_out)), s_axis(k_in, k_out))
    }

    #[inline(always)]
    fn merge_polarized(&self, k_in: Vector<F32s>, k_out: Vector<F32s>) -> ([F32s; N], Kernels<N>) {
        let (values, kernels) = self.phase.values_and_kernels(half_sine2(k_in, k_out));
        // Where it vanishes, forwards, no turn is needed.
        (values, (kernels, k_in.cross(k_out)))
    }

    #[inline(never)]
    fn scatter(&self, k_in: Vector<F32s>, k_out: Vector<F32s>, light: &mut LightLanes<N>) {
        light.pass(k_in, &self.kernels(k_in, k_out));
    }
}

/// Compiles code for every connecting surface model and every phase function, and runs that of
/// what was met; `None` for surfaces that are not connected.
macro_rules! for_scatterer {
    ($scene:expr, $met:expr, $scatterer:ident => $body:expr) => {
        match $met {
            $crate::scattering::Met::Surface(kind) => {
                $crate::scattering::surface::for_scattering!($scene.surfaces, kind, models => {
                    specular: {
                        let _ = models;
                        None
                    },
                    connecting: {
                        let $scatterer =
                            $crate::scattering::vertex::OnSurfaces::new(&*$scene, models);
                        Some($body)
                    },
                    else: None,
                })
            }
            $crate::scattering::Met::Medium(medium) => {
                let medium = $scene.medium(medium);
                $crate::scattering::phase::for_phase!(&medium.phase, phase => {
                    let $scatterer = $crate::scattering::vertex::InMedium { medium, phase };
                    Some($body)
                })
            }
        }
    };
}

pub(crate) use for_scatterer;

/// The mean over the wavelengths.
#[inline(always)]
pub fn mean<const N: usize>(values: &[F32s; N]) -> F32s {
    let mut sum = values[0];
    for &value in &values[1..] {
        sum += value;
    }
    if N == 1 { sum } else { sum * F32s::splat(1.0 / N as f32) }
}
