//! Where on which path events happen.

use std::any::Any;
use std::ops::Range;

use glam::Vec3;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, U32s, Vector, lanes};
use crate::scattering::{Event, Scene, Side};

use super::tables::paths::PathTable;

/// A vertex of a walk: what the stages that go on from there are told.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// Segments up to this vertex.
    pub path_length: u32,
    /// Which way the path is traced.
    pub side: Side,
    /// What directions are drawn by.
    pub sampling: Sampling,
}

/// What the directions of polarized paths are drawn by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Where polarization piles up, in media and at smooth interfaces: what the light that paths
    /// carry, or accept, does.
    #[default]
    Stokes,
    /// What unpolarized light would do: all modes trace the same paths.
    Intensity,
}

impl Sampling {
    /// All, the default first.
    pub const ALL: [Self; 2] = [Self::Stokes, Self::Intensity];

    /// What the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stokes => "stokes",
            Self::Intensity => "intensity",
        }
    }
}

/// Rows of a walk's paths that have met the same: what the stages that look for light there, or
/// leave some, are told.
pub struct Arrived<'a, const N: usize, C: ?Sized> {
    /// All paths.
    pub paths: &'a PathTable<N, C>,
    /// The surfaces at which they are.
    pub surfaces: &'a SurfaceColumns,
    /// What the rows have met.
    pub event: Event,
    /// The rows.
    pub rows: Range<usize>,
    /// Their segments so far.
    pub path_length: u32,
}

impl<const N: usize, C: 'static> Arrived<'_, N, C> {
    /// The same of [`AnyPaths`].
    pub fn of_any(&self) -> Arrived<'_, N, dyn Any> {
        let &Arrived { paths, surfaces, event, ref rows, path_length } = self;
        Arrived { paths, surfaces, event, rows: rows.clone(), path_length }
    }
}

impl<const N: usize, C: ?Sized> Arrived<'_, N, C> {
    /// The medium behind the surface of a row, for connections that go through it: where none do,
    /// the same as before it.
    pub fn beyond(&self, scene: &Scene<N>, row: usize) -> u32 {
        let inside = self.paths.media.inside(row);
        let may_pass = || self.event.met.passes_any_way() && scene.passes_any_way;
        if !(self.paths.media.present() && may_pass())
            || scene.is_closed(self.surfaces.primitive[row])
        {
            return inside;
        }
        let of = |columns| Vec3::from(lanes::row_of(columns, row));
        let along = of(&self.paths.rays.direction).dot(of(&self.surfaces.geometric_normal));
        scene.medium_beyond(self.surfaces, row, along > 0.0, (inside, None))
    }

    /// The media in which connections of the eight rows from `row` on start along these directions.
    #[inline(always)]
    pub fn inside_towards(&self, scene: &Scene<N>, direction: Vector<F32s>, row: usize) -> U32s {
        let inside = self.paths.media.inside_of_lanes(row);
        let may_pass = self.event.met.passes_any_way() && scene.passes_any_way;
        match may_pass && self.paths.media.present() {
            true => self.inside_beyond(scene, (inside, direction), row),
            false => inside,
        }
    }

    #[cold]
    fn inside_beyond(
        &self,
        scene: &Scene<N>,
        (inside, direction): (U32s, Vector<F32s>),
        row: usize,
    ) -> U32s {
        let normal = Vector::load(&self.surfaces.geometric_normal, row);
        let before = Vector::load(&self.paths.rays.direction, row);
        let passes = (before.dot(normal) * direction.dot(normal)).to_array();
        let inside = inside.to_array();
        U32s::from(lanes::each(|lane| {
            let is_used = row + lane < self.rows.end;
            match is_used && passes[lane] > 0.0 {
                true => self.beyond(scene, row + lane),
                false => inside[lane],
            }
        }))
    }
}
