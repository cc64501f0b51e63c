//! Surface models, one file each, and the one list of them.
//!
//! Everything that tells the kinds apart follows from the list: the kinds themselves, which table
//! a material of the scene becomes a row of, the events that paths meet and their order, and which
//! code runs for which rows. A model that is missing in the list, or in a file that must know it,
//! does not compile. A new one is a variant of [`SurfaceModel`] with its answers there, a reader
//! and a description of it, a file here and a line in the list.

mod absorber;
mod blend;
mod brushed;
mod conductor;
mod crossed;
mod dielectric;
mod diffuse;
mod dispersive_dielectric;
mod element;
mod facing;
mod film;
mod filmed;
mod filmed_conductor;
mod filmed_dielectric;
mod glossy;
mod layered;
mod measured;
mod metallic_roughness;
pub mod model;
mod null;
mod parts;
mod plastic;
mod polarizer;
mod retarder;
mod rough;
mod rough_conductor;
mod rough_dielectric;
mod sheet;
mod tables;
mod thin_dielectric;

pub use crossed::Crossed;
pub use facing::Facing;
pub use glossy::{Glossy, GlossyTable, Mixed};
pub use model::{Connecting, ModelLanes, Specular, StraightOn, Surface};
pub use tables::SURVIVAL_MIN;

use absorber::Absorber;
use blend::Blend;
use brushed::Brushed;
use conductor::Conductor;
use dielectric::Dielectric;
use diffuse::Diffuse;
use dispersive_dielectric::DispersiveDielectric;
use filmed::Filmed;
use filmed_conductor::FilmedConductor;
use filmed_dielectric::FilmedDielectric;
use layered::Layered;
use measured::Measured;
use metallic_roughness::MetallicRoughness;
use null::Null;
use plastic::Plastic;
use polarizer::Polarizer;
use retarder::Retarder;
use rough_conductor::RoughConductor;
use rough_dielectric::RoughDielectric;
use sheet::Sheet;
use tables::{Added, append};
use thin_dielectric::ThinDielectric;

use super::event::{END, Elements, Event, Form, Met};
use crate::scene::world::SurfaceModel;

/// The list: for every model, the variant of [`SurfaceModel`] with the parameters that its `of`
/// takes, the name of its table, and its type. By sort: `ends` are models at which paths end (one
/// event for all of them), `specular`, `connecting` and `straight_on` the three sorts of `model`,
/// of which the last are no vertices of a path; `either` is specular and straight on, and `glossy`
/// are connecting models that stages take for one; `mixed` are such that have rows of other models
/// for parts. Rows are grouped in this order.
macro_rules! surface_models {
    ([$($then:tt)*] $arguments:tt) => {
        $($then)*! {
            $arguments
            ends {
                Absorber {} => absorber: Absorber,
            }
            specular {
                Conductor { eta, k } => conductor: Conductor<N>,
                Dielectric { ior, exterior_ior } => dielectric: Dielectric,
                DispersiveDielectric { ior, exterior_ior } =>
                    dispersive_dielectric: DispersiveDielectric<N>,
                FilmedConductor { eta, k, film } => filmed_conductor: FilmedConductor<N>,
                FilmedDielectric { ior, exterior_ior, film } =>
                    filmed_dielectric: FilmedDielectric<N>,
            }
            connecting {
                Diffuse { reflectance } => diffuse: Diffuse<N>,
            }
            glossy {
                RoughConductor { eta, k, alpha, distribution, multiple_scattering } =>
                    rough_conductor: RoughConductor<N>,
                RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering } =>
                    rough_dielectric: RoughDielectric<N>,
                MetallicRoughness { base_color, metallic, alpha, ior, specular } =>
                    metallic_roughness: MetallicRoughness<N>,
                Layered { layers } => layered: Layered<N>,
                Plastic { reflectance, coat } => plastic: Plastic<N>,
                Measured { table, places } => measured: Measured<N>,
                Filmed { of, film } => filmed: Filmed<N>,
            }
            mixed {
                Blend { parts, weight } => blend: Blend,
                Brushed { of, grain } => brushed: Brushed,
            }
            either {
                ThinDielectric { ior, exterior_ior } => thin_dielectric: ThinDielectric<N>,
            }
            straight_on {
                Null {} => null: Null,
                Polarizer { axis_deg, extinction_ratio } => polarizer: Polarizer,
                Retarder { axis_deg, retardance_deg } => retarder: Retarder,
                Sheet { axis_deg, action } => sheet: Sheet<N>,
            }
        }
    };
}

/// What paths do at surfaces of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// They end.
    Ends,
    /// They go on one way only, or two: connections find nothing there.
    Specular,
    /// They go on in any direction, and are connected.
    Connecting,
    /// They go straight on, and so do connections: no vertex.
    StraightOn,
    /// They go straight on, as connections do, or are scattered as at specular surfaces.
    Either,
}

macro_rules! declare {
    (
        ()
        ends { $($end:ident { $($end_of:ident),* } => $end_table:ident: $end_model:ty,)* }
        specular { $($one:ident { $($one_of:ident),* } => $one_table:ident: $one_model:ty,)* }
        connecting { $($any:ident { $($any_of:ident),* } => $any_table:ident: $any_model:ty,)* }
        glossy {
            $($glossy:ident { $($glossy_of:ident),* } => $glossy_table:ident: $glossy_model:ty,)*
        }
        mixed { $($mixed:ident { $($mixed_of:ident),* } => $mixed_table:ident: $mixed_model:ty,)* }
        either { $($both:ident { $($both_of:ident),* } => $both_table:ident: $both_model:ty,)* }
        straight_on {
            $($pass:ident { $($pass_of:ident),* } => $pass_table:ident: $pass_model:ty,)*
        }
    ) => {
        /// A kind of surface: which model scatters there.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum SurfaceKind {
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($end), "`].")] $end,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($one), "`].")] $one,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($any), "`].")] $any,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($glossy), "`].")] $glossy,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($mixed), "`].")] $mixed,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($both), "`].")] $both,)*
            $(#[doc = concat!("See [`SurfaceModel::", stringify!($pass), "`].")] $pass,)*
        }

        impl SurfaceKind {
            /// All kinds, in the order of the list.
            pub const ALL: &[Self] = &[
                $(Self::$end,)*
                $(Self::$one,)*
                $(Self::$both,)*
                $(Self::$any,)*
                $(Self::$glossy,)*
                $(Self::$mixed,)*
                $(Self::$pass,)*
            ];

            /// Those that let light straight on.
            pub const STRAIGHT_ON: &[Self] = &[$(Self::$both,)* $(Self::$pass,)*];

            /// Whether, of those that let light straight on, it changes light at all.
            #[inline(always)]
            pub const fn acts(self) -> bool {
                const N: usize = 1;
                match self {
                    $(Self::$end => false,)*
                    $(Self::$one => false,)*
                    $(Self::$any => false,)*
                    $(Self::$glossy => false,)*
                    $(Self::$mixed => false,)*
                    $(Self::$both => <$both_model as StraightOn<N>>::ACTS,)*
                    $(Self::$pass => <$pass_model as StraightOn<N>>::ACTS,)*
                }
            }

            /// Whether, of those that let light straight on, it does the same to the polarization
            /// of all wavelengths.
            #[inline(always)]
            pub const fn passes_alike(self) -> bool {
                const N: usize = 1;
                match self {
                    $(Self::$end => true,)*
                    $(Self::$one => true,)*
                    $(Self::$any => true,)*
                    $(Self::$glossy => true,)*
                    $(Self::$mixed => true,)*
                    $(Self::$both => <$both_model as StraightOn<N>>::ACHROMATIC,)*
                    $(Self::$pass => <$pass_model as StraightOn<N>>::ACHROMATIC,)*
                }
            }

            /// Whether light that is connected, or drawn any way, may go through it.
            #[inline(always)]
            pub const fn passes_any_way(self) -> bool {
                const N: usize = 1;
                match self {
                    $(Self::$glossy => <$glossy_model as Glossy<N>>::TRANSMITS,)*
                    $(Self::$mixed => <$mixed_model as Mixed<N>>::TRANSMITS,)*
                    $(Self::$end)|*
                    $(| Self::$one)*
                    $(| Self::$any)*
                    $(| Self::$both)*
                    $(| Self::$pass)* => false,
                }
            }

            /// The form of its kernel where it lets light straight on.
            #[inline(always)]
            pub const fn form_straight_on(self) -> Form {
                const N: usize = 1;
                match self {
                    $(Self::$end => Form::Depolarizer,)*
                    $(Self::$one => Form::Depolarizer,)*
                    $(Self::$any => Form::Depolarizer,)*
                    $(Self::$glossy => Form::Depolarizer,)*
                    $(Self::$mixed => Form::Depolarizer,)*
                    $(Self::$both => <$both_model as StraightOn<N>>::FORM,)*
                    $(Self::$pass => <$pass_model as StraightOn<N>>::FORM,)*
                }
            }

            /// Those with an event of their own.
            const MET: &[Self] = &[
                $(Self::$one,)*
                $(Self::$both,)*
                $(Self::$any,)*
                $(Self::$glossy,)*
                $(Self::$mixed,)*
            ];

            /// The kind of a model with parameters of any sort.
            pub fn of<S>(model: &SurfaceModel<S>) -> Self {
                match model {
                    $(SurfaceModel::$end { .. } => Self::$end,)*
                    $(SurfaceModel::$one { .. } => Self::$one,)*
                    $(SurfaceModel::$any { .. } => Self::$any,)*
                    $(SurfaceModel::$glossy { .. } => Self::$glossy,)*
                    $(SurfaceModel::$mixed { .. } => Self::$mixed,)*
                    $(SurfaceModel::$both { .. } => Self::$both,)*
                    $(SurfaceModel::$pass { .. } => Self::$pass,)*
                }
            }

            /// What paths do there.
            #[inline(always)]
            pub const fn sort(self) -> Sort {
                match self {
                    $(Self::$end => Sort::Ends,)*
                    $(Self::$one => Sort::Specular,)*
                    $(Self::$any => Sort::Connecting,)*
                    $(Self::$glossy => Sort::Connecting,)*
                    $(Self::$mixed => Sort::Connecting,)*
                    $(Self::$both => Sort::Either,)*
                    $(Self::$pass => Sort::StraightOn,)*
                }
            }

            /// The form of its kernel, and whether that is achromatic.
            const fn kernel(self) -> (Form, bool) {
                const N: usize = 1;
                match self {
                    $(Self::$end => (Form::Depolarizer, true),)*
                    $(Self::$one => (
                        <<$one_model as Specular<N>>::Kernel as Elements>::FORM,
                        <$one_model as Specular<N>>::ACHROMATIC,
                    ),)*
                    $(Self::$any => (
                        <<&[$any_model] as Connecting<N>>::Kernel as Elements>::FORM,
                        <&[$any_model] as Connecting<N>>::ACHROMATIC,
                    ),)*
                    $(Self::$glossy => (
                        <$glossy_model as Glossy<N>>::FORM,
                        <GlossyTable<'_, N> as Connecting<N>>::ACHROMATIC,
                    ),)*
                    $(Self::$mixed => (
                        <$mixed_model as Mixed<N>>::FORM,
                        <GlossyTable<'_, N> as Connecting<N>>::ACHROMATIC,
                    ),)*
                    $(Self::$both => (
                        <<$both_model as Specular<N>>::Kernel as Elements>::FORM,
                        <$both_model as Specular<N>>::ACHROMATIC,
                    ),)*
                    $(Self::$pass => (Form::Depolarizer, true),)*
                }
            }
        }

        /// The materials of a scene, and for every model the table of its parameters.
        #[derive(Clone, Debug, Default)]
        pub struct Surfaces<const N: usize> {
            materials: Vec<Material>,
            $($end_table: Vec<$end_model>,)*
            $($one_table: Vec<$one_model>,)*
            $($any_table: Vec<$any_model>,)*
            $($glossy_table: Vec<$glossy_model>,)*
            $($mixed_table: Vec<$mixed_model>,)*
            $($both_table: Vec<$both_model>,)*
            $($pass_table: Vec<$pass_model>,)*
        }

        impl<const N: usize> Surfaces<N> {
            /// Takes the rows of other tables, and no others.
            pub fn restart(&mut self, from: &Self) {
                $(self.$end_table.clone_from(&from.$end_table);)*
                $(self.$one_table.clone_from(&from.$one_table);)*
                $(self.$any_table.clone_from(&from.$any_table);)*
                $(self.$glossy_table.clone_from(&from.$glossy_table);)*
                $(self.$mixed_table.clone_from(&from.$mixed_table);)*
                $(self.$both_table.clone_from(&from.$both_table);)*
                $(self.$pass_table.clone_from(&from.$pass_table);)*
            }

            /// How many rows each table has, in the order of the list.
            pub fn lengths(&self) -> Vec<usize> {
                vec![
                    $(self.$end_table.len(),)*
                    $(self.$one_table.len(),)*
                    $(self.$any_table.len(),)*
                    $(self.$glossy_table.len(),)*
                    $(self.$mixed_table.len(),)*
                    $(self.$both_table.len(),)*
                    $(self.$pass_table.len(),)*
                ]
            }

            /// Leaves so many rows of each table, in this order.
            pub fn truncate(&mut self, lengths: &[usize]) {
                let mut lengths = lengths.iter().copied();
                let mut next = || lengths.next().unwrap_or(0);
                $(self.$end_table.truncate(next());)*
                $(self.$one_table.truncate(next());)*
                $(self.$any_table.truncate(next());)*
                $(self.$glossy_table.truncate(next());)*
                $(self.$mixed_table.truncate(next());)*
                $(self.$both_table.truncate(next());)*
                $(self.$pass_table.truncate(next());)*
            }

            /// Appends the material's parameters to the table of its model.
            fn add(&mut self, model: &SurfaceModel<[f32; N]>) -> Added {
                match model.clone() {
                    $(SurfaceModel::$end { $($end_of),* } => {
                        append(&mut self.$end_table, <$end_model>::of($($end_of),*))
                    })*
                    $(SurfaceModel::$one { $($one_of),* } => {
                        append(&mut self.$one_table, <$one_model>::of($($one_of),*))
                    })*
                    $(SurfaceModel::$any { $($any_of),* } => {
                        append(&mut self.$any_table, <$any_model>::of($($any_of),*))
                    })*
                    $(SurfaceModel::$glossy { $($glossy_of),* } => {
                        append(&mut self.$glossy_table, <$glossy_model>::of($($glossy_of),*))
                    })*
                    $(SurfaceModel::$mixed { $($mixed_of),* } => {
                        let row = <$mixed_model>::of(self, $($mixed_of),*);
                        append(&mut self.$mixed_table, row)
                    })*
                    $(SurfaceModel::$both { $($both_of),* } => {
                        append(&mut self.$both_table, <$both_model>::of($($both_of),*))
                    })*
                    $(SurfaceModel::$pass { $($pass_of),* } => {
                        append(&mut self.$pass_table, <$pass_model>::of($($pass_of),*))
                    })*
                }
            }

            $(
                /// The table of this model.
                #[inline(always)]
                pub fn $one_table(&self) -> &[$one_model] {
                    &self.$one_table
                }
            )*
            $(
                /// The table of this model.
                #[inline(always)]
                pub fn $any_table(&self) -> &[$any_model] {
                    &self.$any_table
                }
            )*
            /// The table of a glossy model.
            #[inline(always)]
            pub fn glossy(&self, kind: SurfaceKind) -> Option<GlossyTable<'_, N>> {
                match kind {
                    $(SurfaceKind::$glossy => {
                        Some(GlossyTable::$glossy(&self.$glossy_table))
                    })*
                    $(SurfaceKind::$mixed => Some(GlossyTable::$mixed(self)),)*
                    $(SurfaceKind::$end)|*
                    $(| SurfaceKind::$one)*
                    $(| SurfaceKind::$any)*
                    $(| SurfaceKind::$both)*
                    $(| SurfaceKind::$pass)* => None,
                }
            }

            $(
                /// The table of this model.
                #[inline(always)]
                pub fn $both_table(&self) -> &[$both_model] {
                    &self.$both_table
                }
            )*
            $(
                /// The table of this model.
                #[inline(always)]
                pub fn $pass_table(&self) -> &[$pass_model] {
                    &self.$pass_table
                }
            )*
        }
    };
}

surface_models!([declare]());

/// Compiles code for every model that scatters, by sort, and runs that of a kind on the table of
/// its model; `else` is for kinds that do not.
macro_rules! for_scattering {
    ($surfaces:expr, $kind:expr, $models:ident => {
        specular: $one:expr, connecting: $any:expr, else: $else:expr $(,)?
    }) => {
        $crate::scattering::surface::surface_models!([
            $crate::scattering::surface::dispatch_surface
        ](
            $surfaces, $kind, $models, $one, $any, $else
        ))
    };
}

macro_rules! dispatch_surface {
    (
        ($surfaces:expr, $kind:expr, $models:ident, $of_one:expr, $of_any:expr, $else:expr)
        ends { $($end:ident $end_of:tt => $end_table:ident: $end_model:ty,)* }
        specular { $($one:ident $one_of:tt => $one_table:ident: $one_model:ty,)* }
        connecting { $($any:ident $any_of:tt => $any_table:ident: $any_model:ty,)* }
        glossy { $($glossy:ident $glossy_of:tt => $glossy_table:ident: $glossy_model:ty,)* }
        mixed { $($mixed:ident $mixed_of:tt => $mixed_table:ident: $mixed_model:ty,)* }
        either { $($both:ident $both_of:tt => $both_table:ident: $both_model:ty,)* }
        straight_on { $($pass:ident $pass_of:tt => $pass_table:ident: $pass_model:ty,)* }
    ) => {
        match $kind {
            $($crate::scattering::surface::SurfaceKind::$one => {
                let $models = $surfaces.$one_table();
                $of_one
            })*
            $($crate::scattering::surface::SurfaceKind::$both => {
                let $models = $surfaces.$both_table();
                $of_one
            })*
            $($crate::scattering::surface::SurfaceKind::$any => {
                let $models = $surfaces.$any_table();
                $of_any
            })*
            $($crate::scattering::surface::SurfaceKind::$glossy)|*
            $(| $crate::scattering::surface::SurfaceKind::$mixed)* => {
                match $surfaces.glossy($kind) {
                    Some($models) => $of_any,
                    None => $else,
                }
            }
            $($crate::scattering::surface::SurfaceKind::$end)|*
            $(| $crate::scattering::surface::SurfaceKind::$pass)* => $else,
        }
    };
}

/// Compiles code for every model that lets light straight on, and runs that of a kind on the table
/// of its model.
macro_rules! for_straight_on {
    ($surfaces:expr, $kind:expr, $models:ident => $body:expr) => {
        $crate::scattering::surface::surface_models!([
            $crate::scattering::surface::dispatch_straight_on
        ]($surfaces, $kind, $models, $body))
    };
}

macro_rules! dispatch_straight_on {
    (
        ($surfaces:expr, $kind:expr, $models:ident, $body:expr)
        ends { $($end:ident $end_of:tt => $end_table:ident: $end_model:ty,)* }
        specular { $($one:ident $one_of:tt => $one_table:ident: $one_model:ty,)* }
        connecting { $($any:ident $any_of:tt => $any_table:ident: $any_model:ty,)* }
        glossy { $($glossy:ident $glossy_of:tt => $glossy_table:ident: $glossy_model:ty,)* }
        mixed { $($mixed:ident $mixed_of:tt => $mixed_table:ident: $mixed_model:ty,)* }
        either { $($both:ident $both_of:tt => $both_table:ident: $both_model:ty,)* }
        straight_on { $($pass:ident $pass_of:tt => $pass_table:ident: $pass_model:ty,)* }
    ) => {
        match $kind {
            $($crate::scattering::surface::SurfaceKind::$both => {
                let $models = $surfaces.$both_table();
                $body
            })*
            $($crate::scattering::surface::SurfaceKind::$pass => {
                let $models = $surfaces.$pass_table();
                $body
            })*
            $($crate::scattering::surface::SurfaceKind::$end)|*
            $(| $crate::scattering::surface::SurfaceKind::$one)*
            $(| $crate::scattering::surface::SurfaceKind::$any)*
            $(| $crate::scattering::surface::SurfaceKind::$glossy)*
            $(| $crate::scattering::surface::SurfaceKind::$mixed)* => {}
        }
    };
}

pub(crate) use {
    dispatch_straight_on, dispatch_surface, for_scattering, for_straight_on, surface_models,
};

impl SurfaceKind {
    /// How many kinds of events there are at surfaces: one for all that end paths, and none for
    /// what light passes straight on.
    pub const EVENTS: usize = 1 + Self::MET.len();

    /// Whether paths and connections go straight on through it, if only by chance.
    #[inline(always)]
    pub const fn is_straight_on(self) -> bool {
        matches!(self.sort(), Sort::StraightOn | Sort::Either)
    }

    /// Whether paths may be scattered there, in some way or other.
    #[inline(always)]
    pub const fn scatters(self) -> bool {
        self.connects() || self.is_specular()
    }

    /// Whether its vertices are connected, and merged with photons.
    #[inline(always)]
    pub const fn connects(self) -> bool {
        matches!(self.sort(), Sort::Connecting)
    }

    /// Whether it sends light on, but only one way or two, which connections do not find.
    #[inline(always)]
    pub const fn is_specular(self) -> bool {
        matches!(self.sort(), Sort::Specular | Sort::Either)
    }

    /// The place of its event among the scene's; what is no vertex is never met.
    #[inline(always)]
    pub fn event(self) -> usize {
        Self::MET.iter().position(|kind| *kind == self).map_or(END, |place| 1 + place)
    }

    /// The events at surfaces, [`END`] first.
    pub fn events() -> impl Iterator<Item = Event> {
        std::iter::once(&Self::ALL[END]).chain(Self::MET).map(|&kind| {
            let (form, achromatic) = kind.kernel();
            Event { met: Met::Surface(kind), form, achromatic }
        })
    }
}

/// A material as paths meet it.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// Which model scatters.
    pub kind: SurfaceKind,
    /// The row in the table of the model.
    pub row: u32,
    /// Whether the back scatters like the front; without meaning where the model transmits.
    pub two_sided: bool,
    /// The probability with which roulette lets a path go on.
    pub survival: f32,
    /// Where the peak about the mirrored direction ends; see [`Surface::peak`].
    pub peak: f32,
    /// Whether there are holes in it, or places that let some light straight on.
    pub has_holes: bool,
    /// Whether light that is connected, or drawn any way, may go through it somewhere.
    pub passes_any_way: bool,
}

#[cfg(test)]
mod tests;
