//! Models of emitters: the parameters of each, where it is and how much of it there is. What they
//! do with light is in `scattering::emitter`.

use std::f64::consts::PI;

use glam::Vec3;

use super::baked::{self, Shapes};
use crate::math::elementary::sin;

pub use super::panorama::Panorama;

/// Hands all models to a macro: the list from which everything else that knows them all is made.
macro_rules! for_all_emitters {
    ($then:ident) => {
        $then! {
            Triangle, Sphere, Point, Patterned, Spot, Directional, Sun, Environment, Panorama
        }
    };
}
pub(crate) use for_all_emitters;

/// Something that emits light; how that is polarized, its lamp says (`Optics::states`).
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Its model, with the parameters of that.
    pub model: EmitterModel,
    /// Row in the lamps: how much it emits at every wavelength.
    pub lamp: u32,
    /// That, averaged over the columns of the render, or over its range of wavelengths; greater
    /// than zero.
    pub brightness: f32,
    /// Probability to be chosen as the start of a light path: proportional to emitted power
    /// averaged likewise. All rows together sum to one. What vertices connect to is chosen
    /// by what it brings to them (`scattering::emitter::choice`).
    pub probability: f32,
}

/// What is to be known of a model for its place and its power.
pub trait Extent {
    /// Whether it is at a finite distance.
    const FINITE: bool;

    /// Power in W over radiance, intensity or irradiance: in m^2 sr, sr or m^2.
    fn size(&self, shapes: &Shapes) -> f64;

    /// The picture of all directions that it is, if it is one.
    fn panorama(&self) -> Option<&Panorama> {
        None
    }
}

/// One triangle; radiance leaves its front, or both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The primitive.
    pub primitive: u32,
    /// Both sides emit.
    pub two_sided: bool,
    /// Area in m^2.
    pub area: f32,
}

/// A whole sphere; radiance leaves its outside, or both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The primitive.
    pub primitive: u32,
    /// Both sides emit.
    pub two_sided: bool,
    /// Both do, and what is within is seen from outside, straight on.
    pub shows_inside: bool,
    /// Area in m^2.
    pub area: f32,
}

/// A point of the same radiant intensity, in W/sr, in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it is.
    pub position: Vec3,
}

/// A point of radiant intensities by direction, in W/sr on the average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patterned {
    /// Where it is.
    pub position: Vec3,
    /// Row in the scene's patterns.
    pub row: u32,
    /// The axis of a cone that holds all its light, unit length, and the cosine at its edge.
    pub cone: (Vec3, f32),
}

/// A point with a cone, of a radiant intensity on the axis in W/sr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where it is.
    pub position: Vec3,
    /// Axis of the cone, unit length.
    pub direction: Vec3,
    /// Cosine of the angle from the axis within which the intensity is full.
    pub cos_inner: f32,
    /// Cosine of the angle from the axis beyond which it is zero; less than `cos_inner` by 0.001
    /// at least. Between them it falls off as KHR_lights_punctual recommends.
    pub cos_outer: f32,
}

/// Infinitely far away, of an irradiance on a plane that faces it in W/m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Where the light travels, unit length.
    pub direction: Vec3,
}

/// A disk infinitely far away, of the same radiance all over it in W/(m^2 sr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Where the light of its middle travels, unit length.
    pub direction: Vec3,
    /// One less the cosine of its angular radius, which no `f32` tells from one: greater than zero,
    /// at most one.
    pub versine: f32,
}

/// Radiance from everywhere outside the scene: from a direction 1 + its projection on the gradient
/// times the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Where the sky is brighter, and by how much: of length 1 at most.
    pub gradient: Vec3,
}

macro_rules! emitter_models {
    ($($Model:ident),*) => {
        /// A model of an emitter, with its parameters.
        #[derive(Clone, Debug, PartialEq)]
        pub enum EmitterModel {
            $(#[doc = concat!("See [`", stringify!($Model), "`].")] $Model($Model),)*
        }

        impl EmitterModel {
            /// Whether it is at a finite distance.
            pub fn is_finite(&self) -> bool {
                match self {
                    $(Self::$Model(_) => <$Model as Extent>::FINITE,)*
                }
            }

            /// The picture of all directions that it is, if it is one.
            pub fn panorama(&self) -> Option<&Panorama> {
                match self {
                    $(Self::$Model(model) => model.panorama(),)*
                }
            }

            /// Power in W over radiance, intensity or irradiance: in m^2 sr, sr or m^2.
            pub fn size(&self, shapes: &Shapes) -> f64 {
                match self {
                    $(Self::$Model(model) => model.size(shapes),)*
                }
            }
        }

        $(impl From<$Model> for EmitterModel {
            fn from(model: $Model) -> Self {
                Self::$Model(model)
            }
        })*
    };
}
for_all_emitters!(emitter_models);

impl Triangle {
    /// The emitter that a triangle of the scene is.
    pub fn new(shapes: &Shapes, primitive: u32, two_sided: bool) -> Self {
        Self { primitive, two_sided, area: triangle_area(shapes, primitive) as f32 }
    }
}

fn triangle_area(shapes: &Shapes, primitive: u32) -> f64 {
    let [a, b, c] = shapes.triangles[primitive as usize].corners.map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a).length()
}

impl Extent for Triangle {
    const FINITE: bool = true;

    fn size(&self, shapes: &Shapes) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        PI * triangle_area(shapes, self.primitive) * sides
    }
}

impl Sphere {
    /// The emitter that a sphere of the scene is.
    pub fn new(shapes: &Shapes, primitive: u32, [two_sided, shows_inside]: [bool; 2]) -> Self {
        let area = sphere_area(shapes, primitive) as f32;
        Self { primitive, two_sided, shows_inside: two_sided && shows_inside, area }
    }

    /// The sphere itself.
    pub fn shape(&self, shapes: &Shapes) -> baked::Sphere {
        sphere(shapes, self.primitive)
    }
}

fn sphere(shapes: &Shapes, primitive: u32) -> baked::Sphere {
    shapes.spheres[primitive as usize - shapes.triangles.len()]
}

fn sphere_area(shapes: &Shapes, primitive: u32) -> f64 {
    4.0 * PI * f64::from(sphere(shapes, primitive).radius).powi(2)
}

impl Extent for Sphere {
    const FINITE: bool = true;

    fn size(&self, shapes: &Shapes) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        PI * sphere_area(shapes, self.primitive) * sides
    }
}

impl Extent for Point {
    const FINITE: bool = true;

    fn size(&self, _: &Shapes) -> f64 {
        4.0 * PI
    }
}

impl Extent for Patterned {
    const FINITE: bool = true;

    fn size(&self, _: &Shapes) -> f64 {
        4.0 * PI
    }
}

impl Extent for Spot {
    const FINITE: bool = true;

    fn size(&self, _: &Shapes) -> f64 {
        // The falloff is the square of a ramp in the cosine: its mean is a third.
        let ramp = f64::from(self.cos_inner - self.cos_outer) / 3.0;
        2.0 * PI * (f64::from(1.0 - self.cos_inner) + ramp)
    }
}

impl Extent for Directional {
    const FINITE: bool = false;

    fn size(&self, shapes: &Shapes) -> f64 {
        disk(shapes)
    }
}

impl Sun {
    /// One that takes up an angle in radians, between zero and half a turn.
    pub fn new(direction: Vec3, diameter: f64) -> Self {
        let sine = sin(0.25 * diameter);
        Self { direction, versine: (2.0 * sine * sine) as f32 }
    }

    /// Steradians that it takes up.
    pub fn solid_angle(&self) -> f64 {
        2.0 * PI * f64::from(self.versine)
    }

    /// The irradiance of a plane that faces its middle over its radiance, in sr.
    pub fn faced(&self) -> f64 {
        let versine = f64::from(self.versine);
        PI * versine * (2.0 - versine)
    }
}

impl Extent for Sun {
    const FINITE: bool = false;

    fn size(&self, shapes: &Shapes) -> f64 {
        self.solid_angle() * disk(shapes)
    }
}

impl Extent for Panorama {
    const FINITE: bool = false;

    fn size(&self, shapes: &Shapes) -> f64 {
        4.0 * PI * disk(shapes)
    }

    fn panorama(&self) -> Option<&Panorama> {
        Some(self)
    }
}

impl Extent for Environment {
    const FINITE: bool = false;

    fn size(&self, shapes: &Shapes) -> f64 {
        4.0 * PI * disk(shapes)
    }
}

/// Area of the disk through which parallel light enters the scene.
fn disk(shapes: &Shapes) -> f64 {
    PI * f64::from(shapes.bounds.radius).powi(2)
}
