//! A mixture of two models: of a share of the surface the one scatters, and of the rest the other.
//!
//! The scattering function is `(1 - w) f_1 + w f_2`, and so is the Mueller matrix, times M00; the
//! axes of the two are turned into one. Directions are drawn by one of the two, more often by the
//! one that scatters more, and have the density of both.
//!
//! The parts are rows in the tables of their models, whatever these are: they may be blends again.
//! What they are made of is looked up for every question. That is some of what a question costs,
//! and eight blends of all models at once would be more than all others have to be.

use super::facing::Facing;
use super::glossy::{Lobes, Mixed};
use super::model::{Connecting, Drawn, LaneRows, ModelLanes, Surface};
use super::parts::{Part, each_kind};
use super::rough::{PDF_MIN, TINY, choose};
use super::tables::{Added, SURVIVAL_MIN};
use super::{SurfaceKind, Surfaces, for_scattering};
use crate::math::{F32s, Real, Vector};
use crate::polarization::{Dense, Rotation, s_axis};
use crate::scattering::event::Form;
use crate::scattering::side::Side;
use crate::scattering::vertex::DenseKernels;
use crate::scene::world::SurfaceModel;

/// How many there are in one.
const PARTS: usize = 2;

/// One material.
#[derive(Clone, Copy, Debug)]
pub struct Blend {
    /// The share of the second part.
    weight: f32,
    /// The probability of drawing by it.
    chance: f32,
    parts: [Part<SurfaceKind>; PARTS],
    scattered: f32,
    peak: f32,
}

impl Blend {
    /// Of two models, which are given rows in their tables, with the share of the second.
    #[allow(clippy::boxed_local, reason = "the list of models hands on what materials hold")]
    pub fn of<const N: usize>(
        tables: &mut Surfaces<N>,
        parts: Box<[SurfaceModel<[f32; N]>; PARTS]>,
        weight: f32,
    ) -> Self {
        let mut scattered = [0.0; PARTS];
        let mut peaks = [0.0; PARTS];
        let mut place = 0;
        let parts = parts.map(|model| {
            let Added { row, scattered: share, peak } = tables.add(&model);
            (scattered[place], peaks[place]) = (share, peak);
            place += 1;
            Part { kind: SurfaceKind::of(&model), row: row as usize }
        });
        let mixed = |[first, second]: [f32; PARTS]| first + (second - first) * weight;
        // What scatters little on the whole may scatter more in some direction.
        let often = scattered.map(|share| share.max(SURVIVAL_MIN));
        Self {
            weight,
            chance: weight * often[1] / mixed(often),
            parts,
            scattered: mixed(scattered),
            peak: peaks[0].max(peaks[1]),
        }
    }
}

impl Surface for Blend {
    fn scattered(&self) -> f32 {
        self.scattered
    }

    fn peak(&self) -> f32 {
        self.peak
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct Blends<'a, const N: usize> {
    tables: &'a Surfaces<N>,
    /// In the table of blends.
    rows: LaneRows,
    weight: F32s,
    chance: F32s,
}

/// Two directions about a surface, away from it.
type Way = [Vector<F32s>; 2];

/// Compiles code for the models that parts may be of, and runs that of a kind on its table.
macro_rules! with_table {
    ($tables:expr, $kind:expr, $models:ident => $body:expr) => {
        for_scattering!($tables, $kind, $models => {
            specular: {
                let _ = $models;
                None
            },
            connecting: Some($body),
            else: None,
        })
    };
}

impl<const N: usize> Blends<'_, N> {
    /// Calls `each` with every kind that one of the parts is of in some of these lanes: see
    /// [`each_kind`].
    fn each_kind(
        &self,
        (place, among): (usize, F32s),
        each: impl FnMut(SurfaceKind, &LaneRows, F32s),
    ) {
        each_kind(self.rows, |row| self.tables.blend[row].parts[place], among, each);
    }

    /// The share of the surface that is of a part.
    fn share(&self, place: usize) -> F32s {
        if place == 0 { F32s::ONE - self.weight } else { self.weight }
    }

    /// The scattering function of a part, by its share.
    fn value(&self, place: usize, facing: &Facing, way: Way, side: Side) -> [F32s; N] {
        let mut values = [F32s::ZERO; N];
        let share = self.share(place);
        self.each_kind((place, share.simd_gt(F32s::ZERO)), |kind, rows, mask| {
            let own =
                with_table!(self.tables, kind, models => value(models, rows, facing, way, side));
            for (value, own) in values.iter_mut().zip(own.unwrap_or([F32s::ZERO; N])) {
                *value = Real::select(mask, share * own, *value);
            }
        });
        values
    }

    /// The kernels of a part between the axis and itself.
    fn kernel(
        &self,
        place: usize,
        facing: &Facing,
        (k_in, k_out): (Vector<F32s>, Vector<F32s>),
        axis: Vector<F32s>,
    ) -> [Dense<F32s>; N] {
        let mut kernels = [Dense([[F32s::ZERO; 4]; 4]); N];
        let lives = self.share(place).simd_gt(F32s::ZERO);
        self.each_kind((place, lives), |kind, rows, mask| {
            let own = with_table!(self.tables, kind, models => {
                dense(models, rows, facing, (k_in, k_out))
            });
            let Some((own, own_axis)) = own else { return };
            let arriving = Rotation::between(axis, own_axis, k_in);
            let leaving = Rotation::between(own_axis, axis, k_out);
            for (kernel, own) in kernels.iter_mut().zip(own) {
                let Dense(own) = own.turned(arriving, leaving);
                let elements = kernel.0.as_flattened_mut().iter_mut();
                for (element, &own) in elements.zip(own.as_flattened()) {
                    *element = Real::select(mask, own, *element);
                }
            }
        });
        kernels
    }
}

fn value<M: Connecting<N>, const N: usize>(
    models: M,
    rows: &LaneRows,
    facing: &Facing,
    [given, drawn]: Way,
    side: Side,
) -> [F32s; N] {
    let (factor, of) = (models.factor(rows), models.lanes(rows));
    let passes = M::passes(&of, facing, given, drawn);
    let mut values = M::shape(&of, facing, given, drawn, side);
    for (value, factor) in values.iter_mut().zip(factor) {
        *value = passes & (factor * *value);
    }
    values
}

fn pdf<M: Connecting<N>, const N: usize>(
    models: M,
    rows: &LaneRows,
    facing: &Facing,
    [given, drawn]: Way,
) -> F32s {
    M::pdf(&models.lanes(rows), facing, given, drawn)
}

fn draw<M: Connecting<N>, const N: usize>(
    models: M,
    rows: &LaneRows,
    facing: &Facing,
    given: Vector<F32s>,
    (u, side): ([F32s; 3], Side),
) -> (Vector<F32s>, F32s) {
    let of = models.lanes(rows);
    let Drawn { direction, lost, .. } = models.draw((rows, &of), facing, given, u, side);
    (direction, lost)
}

fn dense<M: Connecting<N>, const N: usize>(
    models: M,
    rows: &LaneRows,
    facing: &Facing,
    (k_in, k_out): (Vector<F32s>, Vector<F32s>),
) -> DenseKernels<N> {
    M::dense_kernels(&models.lanes(rows), facing, k_in, k_out)
}

impl<const N: usize> Lobes<N> for Blends<'_, N> {
    type Kernel = Dense<F32s>;

    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N] {
        let mut values = self.value(0, facing, [given, drawn], side);
        let second = self.value(1, facing, [given, drawn], side);
        values.iter_mut().zip(second).for_each(|(value, second)| *value += second);
        values
    }

    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let cosines = [given, drawn].map(|v| v.dot(facing.shading));
        let is_before = (cosines[0] * cosines[1]).simd_gt(F32s::ZERO);
        let mut sum = F32s::ZERO;
        for (place, chance) in [F32s::ONE - self.chance, self.chance].into_iter().enumerate() {
            self.each_kind((place, chance.simd_gt(F32s::ZERO)), |kind, rows, mask| {
                let way = [given, drawn];
                let own = with_table!(self.tables, kind, models => pdf(models, rows, facing, way));
                // What reflects alone may not know of directions behind it.
                let mask = if kind.passes_any_way() { mask } else { mask & is_before };
                sum += mask & (chance * own.unwrap_or(F32s::ZERO));
            });
        }
        sum
    }

    /// The first number chooses the part, too.
    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let (by_second, again) = choose(u[0], self.chance);
        let u = [again, u[1], u[2]];
        let (mut direction, mut lost) = (facing.shading_towards(given), F32s::ZERO);
        for (place, among) in [!by_second, by_second].into_iter().enumerate() {
            self.each_kind((place, among), |kind, rows, mask| {
                let drawn = with_table!(self.tables, kind, models => {
                    draw(models, rows, facing, given, (u, side))
                });
                let Some((drawn, is_lost)) = drawn else { return };
                direction = Vector::select(mask, drawn, direction);
                lost |= mask & is_lost;
            });
        }
        let pdf = self.pdf(facing, given, direction).fast_max(F32s::splat(PDF_MIN));
        let mut weight = self.values(facing, given, direction, side);
        let scale = !lost & (direction.dot(facing.shading).abs() / pdf);
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost }
    }

    fn kernels(
        &self,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>) {
        let axis = s_axis(k_out, k_in);
        let way = [-k_in, k_out];
        let values = [0, 1].map(|place| self.value(place, facing, way, Side::Light));
        let mut kernels = self.kernel(0, facing, (k_in, k_out), axis);
        let others = self.kernel(1, facing, (k_in, k_out), axis);
        for (n, (Dense(kernel), Dense(other))) in kernels.iter_mut().zip(others).enumerate() {
            let [first, second] = [0, 1].map(|place| values[place][n]);
            let scale = F32s::ONE / (first + second).fast_max(F32s::splat(TINY));
            let [first, second] = [first * scale, second * scale];
            let elements = kernel.as_flattened_mut().iter_mut().zip(other.as_flattened());
            for (element, &other) in elements {
                *element = first.mul_add(*element, second * other);
            }
            kernel[0][0] = F32s::ONE;
        }
        (kernels, axis)
    }
}

impl<const N: usize> Mixed<N> for Blend {
    type Lanes<'a> = Blends<'a, N>;
    const TRANSMITS: bool = true;
    const FORM: Form = Form::Dense;

    fn lanes<'a>(tables: &'a Surfaces<N>, rows: &LaneRows) -> Blends<'a, N> {
        let models = ModelLanes::new(&tables.blend, *rows);
        let [weight, chance] = [models.field(|it| it.weight), models.field(|it| it.chance)];
        Blends { tables, rows: *rows, weight, chance }
    }
}

#[cfg(test)]
pub mod tests;
