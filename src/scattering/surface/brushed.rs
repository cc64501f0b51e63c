//! Rough surfaces whose facets are stretched along a direction, as those of brushed metal.
//!
//! They are rough metal, rough glass or glTF's metallic-roughness with other facets: the slopes of
//! these are those of even ones, stretched along the direction and across it
//! ([`crate::polarization::Stretched`]). Each has a row in the table of its model, of facets of the
//! root mean square of both. What several facets scatter is that of even facets of this roughness,
//! at the cosine at which they hide each other as much: where one roughness is four times the
//! other, all light comes back from lossless metal to 4 % (GGX), or 7 % (Beckmann).

use super::facing::Facing;
use super::glossy::{Lobes, Mixed};
use super::metallic_roughness::MetallicRoughnesses;
use super::model::{Drawn, LaneRows, ModelLanes, Surface};
use super::parts::{Part, each_kind};
use super::rough_conductor::{RoughConductor, RoughConductors};
use super::rough_dielectric::{RoughDielectric, RoughDielectrics};
use super::tables::Added;
use super::{SurfaceKind, Surfaces};
use crate::math::{F32s, Real, Vector};
use crate::polarization::{Block, Facets, SpheroidBlock, Stretched};
use crate::scattering::event::{Elements, Form};
use crate::scattering::side::Side;
use crate::scattering::vertex::Kernels;
use crate::scene::world::{Grain, SurfaceModel};

/// One material, where it is.
#[derive(Clone, Copy, Debug)]
pub struct Brushed {
    part: Part<Base>,
    /// A unit vector along the surface.
    along: [f32; 3],
    /// The roughness along it and across.
    alpha: [f32; 2],
    scattered: f32,
    peak: f32,
}

/// What the facets are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Base {
    Metal,
    Glass,
    Mixed,
}

impl Brushed {
    /// Of a model, which is given a row in its table.
    #[allow(clippy::boxed_local, reason = "the list of models hands on what materials hold")]
    pub fn of<const N: usize>(
        tables: &mut Surfaces<N>,
        of: Box<SurfaceModel<[f32; N]>>,
        grain: Grain,
    ) -> Self {
        let mut model = *of;
        let alpha = grain.alphas(model.facets_alpha().copied().unwrap_or(1.0));
        if let Some(mean) = model.facets_alpha_mut() {
            *mean = (0.5 * (alpha[0] * alpha[0] + alpha[1] * alpha[1])).sqrt();
        }
        let Added { row, scattered, peak } = tables.add(&model);
        let own = SurfaceKind::of(&model);
        let bases = [
            (SurfaceKind::RoughConductor, Base::Metal),
            (SurfaceKind::RoughDielectric, Base::Glass),
            (SurfaceKind::MetallicRoughness, Base::Mixed),
        ];
        let base = bases.into_iter().find(|(kind, _)| *kind == own);
        let (_, kind) = base.expect("worlds are checked: no other model has such facets");
        let part = Part { kind, row: row as usize };
        Self { part, along: grain.place, alpha, scattered, peak }
    }
}

impl Brushed {
    /// The row in the table of the model that it is of.
    pub fn row(&self) -> u32 {
        self.part.row as u32
    }
}

impl Surface for Brushed {
    fn scattered(&self) -> f32 {
        self.scattered
    }

    fn peak(&self) -> f32 {
        self.peak
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct Brushes<'a, const N: usize> {
    tables: &'a Surfaces<N>,
    /// In the table of brushed models.
    rows: LaneRows,
    along: Vector<F32s>,
    alpha: [F32s; 2],
}

/// Compiles code for the models that there are, and runs that of a kind on eight of its rows.
macro_rules! with_lobes {
    ($self:expr, $kind:expr, $rows:expr, $of:ident => $body:expr) => {
        match $kind {
            Base::Metal => {
                let $of = $self.metal($rows);
                $body
            }
            Base::Glass => {
                let $of = $self.glass($rows);
                $body
            }
            Base::Mixed => {
                let $of = $self.mixed($rows);
                $body
            }
        }
    };
}

// What is asked of lobes is asked in several places: they are made out of line.
impl<const N: usize> Brushes<'_, N> {
    #[inline(never)]
    fn metal(&self, rows: &LaneRows) -> RoughConductors<N, Stretched> {
        let models = ModelLanes::new(&self.tables.rough_conductor, *rows);
        RoughConductors::new(&models, self.facets(RoughConductor::beckmann(&models)))
    }

    #[inline(never)]
    fn glass(&self, rows: &LaneRows) -> RoughDielectrics<N, Stretched> {
        let models = ModelLanes::new(&self.tables.rough_dielectric, *rows);
        RoughDielectrics::new(&models, self.facets(RoughDielectric::beckmann(&models)))
    }

    #[inline(never)]
    fn mixed(&self, rows: &LaneRows) -> MetallicRoughnesses<N, Stretched> {
        let models = ModelLanes::new(&self.tables.metallic_roughness, *rows);
        MetallicRoughnesses::new(&models, self.facets(F32s::ZERO))
    }

    #[inline(always)]
    fn facets(&self, beckmann: F32s) -> Facets<Stretched> {
        Facets::stretched(self.along, self.alpha, beckmann)
    }

    fn each(&self, each: impl FnMut(Base, &LaneRows, F32s)) {
        let all = F32s::ZERO.simd_eq(F32s::ZERO);
        each_kind(self.rows, |row| self.tables.brushed[row].part, all, each);
    }
}

impl<const N: usize> Lobes<N> for Brushes<'_, N> {
    type Kernel = SpheroidBlock<F32s>;

    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N] {
        let mut values = [F32s::ZERO; N];
        self.each(|kind, rows, mask| {
            let own = with_lobes!(self, kind, rows, of => {
                Lobes::<N>::values(&of, facing, given, drawn, side)
            });
            let mask = match kind {
                Base::Metal | Base::Mixed => mask & facing.reflects(given, drawn),
                Base::Glass => mask,
            };
            for (value, own) in values.iter_mut().zip(own) {
                *value = Real::select(mask, own, *value);
            }
        });
        values
    }

    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let mut pdf = F32s::ZERO;
        self.each(|kind, rows, mask| {
            let own = with_lobes!(self, kind, rows, of => {
                Lobes::<N>::pdf(&of, facing, given, drawn)
            });
            pdf = Real::select(mask, own, pdf);
        });
        pdf
    }

    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let direction = facing.shading_towards(given);
        let (pdf, weight, lost) = (F32s::ONE, [F32s::ZERO; N], F32s::ZERO);
        let mut drawn = Drawn { direction, pdf, weight, lost };
        self.each(|kind, rows, mask| {
            let own: Drawn<N> =
                with_lobes!(self, kind, rows, of => of.draw(facing, given, u, side));
            // What the list of models says of all of them is that light may go through.
            let mask_of_weight = match kind {
                Base::Metal | Base::Mixed => facing.reflects(given, own.direction),
                Base::Glass => mask,
            };
            drawn.direction = Vector::select(mask, own.direction, drawn.direction);
            drawn.pdf = Real::select(mask, own.pdf, drawn.pdf);
            drawn.lost = Real::select(mask, own.lost, drawn.lost);
            for (weight, own) in drawn.weight.iter_mut().zip(own.weight) {
                *weight = Real::select(mask, mask_of_weight & own, *weight);
            }
        });
        drawn
    }

    fn kernels(&self, facing: &Facing, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N> {
        let mut kernels = [Block::identity().spheroid(); N];
        let mut axis = k_in;
        self.each(|kind, rows, mask| {
            let (own, own_axis): Kernels<N> =
                with_lobes!(self, kind, rows, of => of.kernels(facing, k_in, k_out));
            axis = Vector::select(mask, own_axis, axis);
            for (kernel, own) in kernels.iter_mut().zip(own) {
                let select = |own: F32s, other: F32s| Real::select(mask, own, other);
                *kernel = SpheroidBlock {
                    a: select(own.a, kernel.a),
                    b: select(own.b, kernel.b),
                    c: select(own.c, kernel.c),
                    d: select(own.d, kernel.d),
                    s: select(own.s, kernel.s),
                };
            }
        });
        (kernels, axis)
    }
}

impl<const N: usize> Mixed<N> for Brushed {
    type Lanes<'a> = Brushes<'a, N>;
    const TRANSMITS: bool = true;
    const FORM: Form = Form::Spheroid;

    fn lanes<'a>(tables: &'a Surfaces<N>, rows: &LaneRows) -> Brushes<'a, N> {
        let models = ModelLanes::new(&tables.brushed, *rows);
        let [x, y, z] = [0, 1, 2].map(|axis| models.field(|it| it.along[axis]));
        let alpha = [0, 1].map(|side| models.field(|it| it.alpha[side]));
        Brushes { tables, rows: *rows, along: Vector::new(x, y, z), alpha }
    }
}

#[cfg(test)]
mod tests;
