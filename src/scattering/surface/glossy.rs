//! Models that reflect light in any direction and polarize it, compiled into the stages once for
//! all of them: each is some hundreds of instructions, beside which a call and a choice cost
//! nothing, and a copy of every stage for every model, color and mode would be most of the program.

use super::blend::Blend;
use super::brushed::Brushed;
use super::facing::Facing;
use super::filmed::Filmed;
use super::layered::Layered;
use super::measured::Measured;
use super::metallic_roughness::MetallicRoughness;
use super::model::{Connecting, Drawn, LaneRows, ModelLanes, Surface};
use super::plastic::Plastic;
use super::rough_conductor::RoughConductor;
use super::rough_dielectric::RoughDielectric;
use super::{Surfaces, surface_models};
use crate::math::{F32s, Vector};
use crate::polarization::SpheroidBlock;
use crate::scattering::event::{Elements, Form, spheroids};
use crate::scattering::side::Side;
use crate::scattering::vertex::{DenseKernels, Kernels};

/// A glossy model.
pub trait Glossy<const N: usize>: Surface {
    /// Eight of them, of a table.
    type Lanes<'a>: Lobes<N>
    where
        Self: 'a;
    /// Whether light goes through.
    const TRANSMITS: bool = false;

    /// What their kernels are.
    const FORM: Form;

    /// Those of some rows.
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> Self::Lanes<'a>;
}

/// A glossy model with rows of other models for parts, in their tables.
pub trait Mixed<const N: usize>: Surface {
    /// Eight of them.
    type Lanes<'a>: Lobes<N>;
    /// Whether light may go through.
    const TRANSMITS: bool;
    /// What their kernels are.
    const FORM: Form;

    /// Those of some rows.
    fn lanes<'a>(tables: &'a Surfaces<N>, rows: &LaneRows) -> Self::Lanes<'a>;
}

/// Eight glossy surfaces; see [`Connecting`].
pub trait Lobes<const N: usize>: Copy {
    /// What the kernels are made of.
    type Kernel: Elements;

    /// The scattering function per steradian, between two directions away from the surface, for a
    /// path of the `side` that comes from `given`.
    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N];

    /// Density per steradian of [`Lobes::draw`].
    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s;

    /// Draws a direction by three numbers in [0, 1), for a path of the `side` that comes from
    /// `given`.
    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N>;

    /// The kernels for light that travels along `k_in` and then along `k_out`, and the x axis of
    /// their frames, a unit vector perpendicular to both.
    fn kernels(
        &self,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>);
}

macro_rules! declare {
    (
        ()
        ends $ends:tt
        specular $specular:tt
        connecting $connecting:tt
        glossy {
            $($glossy:ident { $($glossy_of:ident),* } => $glossy_table:ident: $glossy_model:ty,)*
        }
        mixed {
            $($mixed:ident { $($mixed_of:ident),* } => $mixed_table:ident: $mixed_model:ty,)*
        }
        either $either:tt
        straight_on $straight_on:tt
    ) => {
        /// The table of a glossy model.
        #[derive(Clone, Copy, Debug)]
        pub enum GlossyTable<'a, const N: usize> {
            $(#[doc = concat!("Of `SurfaceModel::", stringify!($glossy), "`.")]
            $glossy(&'a [$glossy_model]),)*
            $(#[doc = concat!("Of `SurfaceModel::", stringify!($mixed), "`: all tables.")]
            $mixed(&'a Surfaces<N>),)*
        }

        /// Eight surfaces of a glossy model.
        #[derive(Clone, Copy)]
        pub enum GlossyLanes<'a, const N: usize> {
            $(#[doc = concat!("Of `SurfaceModel::", stringify!($glossy), "`.")]
            $glossy(<$glossy_model as Glossy<N>>::Lanes<'a>),)*
            $(#[doc = concat!("Of `SurfaceModel::", stringify!($mixed), "`.")]
            $mixed(<$mixed_model as Mixed<N>>::Lanes<'a>),)*
        }

        impl<'a, const N: usize> Connecting<N> for GlossyTable<'a, N> {
            type Kernel = SpheroidBlock<F32s>;
            const ACHROMATIC: bool = false;
            const IS_EVEN: bool = false;
            const DECIDES: bool = true;
            type Lanes = GlossyLanes<'a, N>;

            #[inline(always)]
            fn factor(self, _rows: &LaneRows) -> [F32s; N] {
                [F32s::splat(1.0); N]
            }

            #[inline(never)]
            fn lanes(self, rows: &LaneRows) -> GlossyLanes<'a, N> {
                match self {
                    $(Self::$glossy(table) => GlossyLanes::$glossy(
                        <$glossy_model as Glossy<N>>::lanes(&ModelLanes::new(table, *rows)),
                    ),)*
                    $(Self::$mixed(tables) => GlossyLanes::$mixed(
                        <$mixed_model as Mixed<N>>::lanes(tables, rows),
                    ),)*
                }
            }

            #[inline(always)]
            fn passes(
                of: &GlossyLanes<N>,
                facing: &Facing,
                given: Vector<F32s>,
                drawn: Vector<F32s>,
            ) -> F32s {
                let transmits = match of {
                    $(GlossyLanes::$glossy(_) => <$glossy_model as Glossy<N>>::TRANSMITS,)*
                    $(GlossyLanes::$mixed(_) => <$mixed_model as Mixed<N>>::TRANSMITS,)*
                };
                match transmits {
                    true => facing.is_on_sides(given, drawn),
                    false => facing.reflects(given, drawn),
                }
            }

            #[inline(never)]
            fn shape(
                of: &GlossyLanes<'a, N>,
                facing: &Facing,
                given: Vector<F32s>,
                drawn: Vector<F32s>,
                side: Side,
            ) -> [F32s; N] {
                match of {
                    $(GlossyLanes::$glossy(of) => of.values(facing, given, drawn, side),)*
                    $(GlossyLanes::$mixed(of) => of.values(facing, given, drawn, side),)*
                }
            }

            #[inline(never)]
            fn pdf(
                of: &GlossyLanes<'a, N>,
                facing: &Facing,
                given: Vector<F32s>,
                drawn: Vector<F32s>,
            ) -> F32s {
                match of {
                    $(GlossyLanes::$glossy(of) => of.pdf(facing, given, drawn),)*
                    $(GlossyLanes::$mixed(of) => of.pdf(facing, given, drawn),)*
                }
            }

            #[inline(never)]
            fn draw(
                self,
                (_rows, of): (&LaneRows, &GlossyLanes<'a, N>),
                facing: &Facing,
                given: Vector<F32s>,
                u: [F32s; 3],
                side: Side,
            ) -> Drawn<N> {
                match of {
                    $(GlossyLanes::$glossy(of) => of.draw(facing, given, u, side),)*
                    $(GlossyLanes::$mixed(of) => of.draw(facing, given, u, side),)*
                }
            }

            #[inline(never)]
            fn kernels(
                of: &GlossyLanes<'a, N>,
                facing: &Facing,
                k_in: Vector<F32s>,
                k_out: Vector<F32s>,
            ) -> Kernels<N> {
                match of {
                    $(GlossyLanes::$glossy(of) => {
                        let (kernels, axis) = of.kernels(facing, k_in, k_out);
                        (spheroids(&kernels), axis)
                    })*
                    $(GlossyLanes::$mixed(of) => {
                        let (kernels, axis) = of.kernels(facing, k_in, k_out);
                        (spheroids(&kernels), axis)
                    })*
                }
            }

            #[inline(always)]
            fn is_dense(of: &GlossyLanes<'a, N>) -> bool {
                match of {
                    $(GlossyLanes::$glossy(_) => {
                        matches!(<$glossy_model as Glossy<N>>::FORM, Form::Dense)
                    })*
                    $(GlossyLanes::$mixed(_) => {
                        matches!(<$mixed_model as Mixed<N>>::FORM, Form::Dense)
                    })*
                }
            }

            #[inline(never)]
            fn dense_kernels(
                of: &GlossyLanes<'a, N>,
                facing: &Facing,
                k_in: Vector<F32s>,
                k_out: Vector<F32s>,
            ) -> DenseKernels<N> {
                match of {
                    $(GlossyLanes::$glossy(of) => {
                        let (kernels, axis) = of.kernels(facing, k_in, k_out);
                        (kernels.map(Elements::dense), axis)
                    })*
                    $(GlossyLanes::$mixed(of) => {
                        let (kernels, axis) = of.kernels(facing, k_in, k_out);
                        (kernels.map(Elements::dense), axis)
                    })*
                }
            }
        }
    };
}

surface_models!([declare]());
