//! What points emit by direction: a file for each kind, all relative to the mean over directions.

use glam::{DMat3, Vec3};

use super::luminaire::Luminaire;
use super::projector::Projector;
use super::ramp::Ramp;
use crate::spectrum::Carried;

/// What a point emits by direction.
#[derive(Clone, Debug)]
pub enum Pattern {
    /// As it was measured.
    Measured(Luminaire),
    /// Through a picture.
    Projected(Projector),
    /// Falling off evenly with the angle from an axis.
    Ramp(Ramp),
}

impl Pattern {
    /// The mean over all directions, which others are relative to.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Measured(it) => it.mean(),
            Self::Projected(it) => it.mean(),
            Self::Ramp(it) => it.mean(),
        }
    }

    /// The axis and the cosine at the edge of a cone that holds all its light.
    pub fn cone(&self) -> (Vec3, f32) {
        match self {
            Self::Measured(_) => (Vec3::Z, -1.0),
            Self::Projected(it) => it.cone(),
            Self::Ramp(it) => it.cone(),
        }
    }

    /// The intensity along a direction of world space over the mean, in the columns of a render.
    pub fn share<const N: usize>(&self, direction: Vec3, carried: &Carried<N>) -> [f32; N] {
        match self {
            Self::Measured(it) => [it.share(direction); N],
            Self::Projected(it) => it.share(direction, carried),
            Self::Ramp(it) => [it.share(direction); N],
        }
    }

    /// Whether light goes along a direction.
    pub fn reaches(&self, direction: Vec3) -> bool {
        match self {
            Self::Measured(it) => it.share(direction) > 0.0,
            Self::Projected(it) => it.density(direction) > 0.0,
            Self::Ramp(it) => it.share(direction) > 0.0,
        }
    }

    /// The density per steradian of drawing a direction.
    pub fn density(&self, direction: Vec3) -> f32 {
        match self {
            Self::Measured(it) => it.density(direction),
            Self::Projected(it) => it.density(direction),
            Self::Ramp(it) => it.density(direction),
        }
    }

    /// Draws a direction by two numbers in [0, 1).
    pub fn direction(&self, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Measured(it) => it.direction(u),
            Self::Projected(it) => it.direction(u),
            Self::Ramp(it) => it.direction(u),
        }
    }
}

/// What turns from a node to the world, by the axes of its place: those without their lengths, and
/// at right angles if scales above the node have made them others. A place that mirrors still does.
pub fn turn_of(axes: DMat3) -> DMat3 {
    let z = axes.z_axis.normalize();
    let x = (axes.x_axis - z * axes.x_axis.dot(z)).normalize();
    let y = z.cross(x) * axes.determinant().signum();
    DMat3::from_cols(x, y, z)
}
