//! Spots whose intensity falls off evenly with the angle from their axis.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Vec3};

use super::pattern::turn_of;
use crate::math::elementary::{atan2, cos, sin, sin_cos};

/// One in its place, over its mean.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// From the node, where it shines along -z, to the world.
    to_world: DMat3,
    /// Angles from the axis in radians: of full intensity, and of none.
    inner: f64,
    outer: f64,
    mean: f64,
}

impl Ramp {
    /// In a place whose axes are those of the columns; angles from the axis are in radians.
    pub fn new(axes: DMat3, [inner, outer]: [f64; 2]) -> Self {
        Self { to_world: turn_of(axes), inner, outer, mean: Self::mean_of([inner, outer]) }
    }

    /// The mean over all directions, relative to full intensity.
    pub fn mean_of([inner, outer]: [f64; 2]) -> f64 {
        /// Below this angle the differences of sines are mostly rounding, and the next terms of
        /// their series less.
        const NARROW: f64 = 1e-3;
        if outer < NARROW {
            return (inner * inner + inner * outer + outer * outer) / 12.0;
        }
        let slope = match outer > inner {
            true => (sin(outer) - sin(inner)) / (outer - inner),
            false => cos(outer),
        };
        0.5 * (1.0 - slope)
    }

    /// The mean over all directions, which others are relative to.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The axis, and the cosine at the edge.
    pub fn cone(&self) -> (Vec3, f32) {
        (self.axis().as_vec3(), cos(self.outer) as f32)
    }

    fn axis(&self) -> DVec3 {
        -self.to_world.z_axis
    }

    fn angle(&self, direction: Vec3) -> f64 {
        let direction = direction.as_dvec3();
        atan2(self.axis().cross(direction).length(), self.axis().dot(direction))
    }

    /// The intensity along a direction of world space, over the mean.
    pub fn share(&self, direction: Vec3) -> f32 {
        let angle = self.angle(direction);
        let full = match angle {
            angle if angle <= self.inner => 1.0,
            angle if angle >= self.outer => 0.0,
            angle => (self.outer - angle) / (self.outer - self.inner),
        };
        (full / self.mean) as f32
    }

    /// One less the cosine of the outer angle.
    fn versine(&self) -> f64 {
        let sine = sin(0.5 * self.outer);
        2.0 * sine * sine
    }

    /// The density per steradian of drawing a direction: the same in all of the cone.
    pub fn density(&self, direction: Vec3) -> f32 {
        match self.angle(direction) < self.outer {
            true => (1.0 / (TAU * self.versine())) as f32,
            false => 0.0,
        }
    }

    /// Draws a direction by two numbers in [0, 1).
    pub fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let versine = f64::from(u) * self.versine();
        let radius = (versine * (2.0 - versine)).sqrt();
        let (sine, cosine) = sin_cos(2.0 * PI * f64::from(v));
        let local = DVec3::new(radius * cosine, radius * sine, versine - 1.0);
        (self.to_world * local).normalize().as_vec3()
    }
}
