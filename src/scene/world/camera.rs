//! The camera: how it projects, and how many pixels it asks for.

use std::f64::consts::PI;

use super::transform::Transform;
use crate::math::{Fault, Range};

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
