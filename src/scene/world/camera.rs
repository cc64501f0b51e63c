//! The camera: how it projects, how many pixels it asks for, and how these see.

use std::f64::consts::PI;

use super::transform::Transform;
use crate::film::filter::{Filter, FilterKind};
use crate::film::layout::{Crop, check_pixel_aspect};
use crate::math::{Fault, Range};
use crate::polarization::Analyzer;

/// How the camera projects; it looks along the -z axis of its transform, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Pinhole or thin lens.
    Perspective {
        /// Vertical angle of view in radians, within (0, pi).
        yfov: f64,
        /// Width over height, if the scene states it; greater than zero.
        aspect: Option<f32>,
        /// Radius of the lens, not negative; 0 for a pinhole.
        aperture_radius: f32,
        /// Distance of the plane in focus, greater than zero.
        focus_distance: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width of the picture, greater than zero.
        half_width: f32,
        /// Half the height of the picture, greater than zero.
        half_height: f32,
    },
}

impl Lens {
    /// A pinhole of a vertical angle of view in radians, within (0, pi).
    pub fn pinhole(yfov: f64) -> Self {
        Self::Perspective { yfov, aspect: None, aperture_radius: 0.0, focus_distance: 1.0 }
    }

    /// Refuses what cannot project.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        match *self {
            Self::Perspective { yfov, aspect, aperture_radius, focus_distance } => {
                if !(yfov > 0.0 && yfov < PI) {
                    let problem = format!("{yfov} must be greater than 0 and less than pi radians");
                    return Err(Fault::new("yfov", problem, ""));
                }
                if let Some(aspect) = aspect {
                    Range::POSITIVE.check("aspect", aspect)?;
                }
                Range::NOT_NEGATIVE.check("aperture_radius", aperture_radius)?;
                Range::POSITIVE.check("focus_distance", focus_distance)
            }
            Self::Orthographic { half_width, half_height } => {
                Range::POSITIVE.check("half_width", half_width)?;
                Range::POSITIVE.check("half_height", half_height)
            }
        }
    }

    /// Refuses a place where a camera cannot stand.
    pub(crate) fn check_place(place: &Transform) -> Result<(), Fault> {
        place.check()?;
        if place.is_orthogonal() && place.0.matrix3.determinant() > 0.0 {
            return Ok(());
        }
        let remedy = "give it, and its parents, positive scales without rotation in between";
        Err(Fault::new("", "the camera is sheared or mirrored", remedy))
    }
}

/// The film size that the scene asks for: width and height in pixels, from 1 to 65,535.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution(pub [u32; 2]);

impl Resolution {
    /// From width and height.
    pub(crate) fn of(sides: &[u64]) -> Result<Self, Fault> {
        const SIDE_MAX: u64 = 65_535;
        match sides {
            &[width, height]
                if (1..=SIDE_MAX).contains(&width) && (1..=SIDE_MAX).contains(&height) =>
            {
                Ok(Self([width as u32, height as u32]))
            }
            _ => {
                let problem =
                    format!("must be [width, height], whole numbers from 1 to {SIDE_MAX}");
                Err(Fault::new("resolution", problem, ""))
            }
        }
    }

    /// Refuses what is no size.
    pub(crate) fn check(self) -> Result<(), Fault> {
        Self::of(&self.0.map(u64::from)).map(|_| ())
    }
}

/// What stands behind a lens, as a file says it.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::scene) struct Film {
    /// How many pixels it asks for.
    pub resolution: Option<Resolution>,
    /// How they see.
    pub raster: Raster,
    /// What stands before it.
    pub analyzer: Option<Analyzer>,
}

/// How the pixels of a film see where a render does not say it: their filter, which of them are
/// rendered, and their shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// How light about a pixel counts for it.
    pub filter: Filter,
    /// The part of the film that is rendered: left, top, right, bottom in pixels of the
    /// [`Resolution`], which has to be there; none is all of it. It keeps its place on films of
    /// other sizes.
    pub crop: Option<[u32; 4]>,
    /// Width of a pixel over its height, from 0.01 to 100.
    pub pixel_aspect: f32,
}

impl Default for Raster {
    /// Square pixels, all of them, that are means over their squares.
    fn default() -> Self {
        Self { filter: Filter::PIXEL, crop: None, pixel_aspect: 1.0 }
    }
}

impl Raster {
    /// Whether it says nothing.
    pub(crate) fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// The filter of a name.
    pub(crate) fn filter_of(name: &str) -> Result<FilterKind, Fault> {
        FilterKind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = FilterKind::ALL.map(FilterKind::name).join(", ");
            Fault::new("filter", "is no filter", format!("filters are {names}"))
        })
    }

    /// Refuses what no film of a resolution can be like.
    pub(crate) fn check(&self, resolution: Option<Resolution>) -> Result<(), Fault> {
        self.filter.check()?;
        check_pixel_aspect(self.pixel_aspect)?;
        let refuse = |problem| Fault::new("crop", problem, "");
        match (self.crop, resolution) {
            (Some(crop), Some(Resolution(film))) => {
                Crop::Pixels(crop).on(film).map(|_| ()).map_err(refuse)
            }
            (Some(_), None) => {
                let problem = "is in pixels of a film that has no resolution";
                Err(Fault::new("crop", problem, "state `resolution` too"))
            }
            (None, _) => Ok(()),
        }
    }
}
