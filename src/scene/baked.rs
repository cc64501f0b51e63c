//! What `bake` makes of the world: dense, read-only tables in world space, one row per primitive,
//! surface, material and emitter. Everything here has been validated; nothing can fail later.
//!
//! Lengths are in scene units (meters in glTF), angles in radians, radiometry per channel.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::corners::Corners;
use super::emitted::EmittedStates;
use super::emitter::Emitter;
use super::instanced::Instanced;
use super::painting::Painting;
use super::pattern::Pattern;
use super::world::{Raster, SurfaceModel};
use crate::polarization::Analyzer;
use crate::spectrum::Carried;

/// Marks the absence of an index.
pub const NONE: u32 = u32::MAX;

/// In place of a medium: what crosses the surface to this side stays in the medium it is in.
pub const KEEP: u32 = u32::MAX - 1;

/// In place of a medium: the surface bounds what others cross, and what is beyond it hangs on where
/// it is crossed. See [`Body`].
pub const SOUGHT: u32 = u32::MAX - 2;

/// Least cosine between a shading normal and the geometric one.
pub const LEAST_COSINE: f32 = 1e-3;

/// How far off a surface rays start and end, relative to the largest coordinate involved: 64 times
/// the rounding error of a coordinate. A reconstructed hit point is off by about 4 of these and the
/// distances that the triangle test computes by about 5 more.
pub const RELATIVE_OFFSET: f64 = 32.0 / (1 << 24) as f64;

/// The whole scene for `N` wavelengths.
#[derive(Clone, Debug)]
pub struct BakedScene<const N: usize> {
    /// Where everything is.
    pub shapes: Shapes,
    /// What sees it.
    pub camera: Camera,
    /// What it does to light.
    pub optics: Optics<N>,
}

/// Where everything is that rays meet. The same for all wavelengths.
///
/// Primitive `p` is triangle `p` while `p < triangles.len()`, then sphere `p - triangles.len()`,
/// and behind the spheres a triangle of an instance.
#[derive(Clone, Debug)]
pub struct Shapes {
    /// World-space triangles of all meshes but those that are instanced.
    pub triangles: Vec<Triangle>,
    /// Shading normals at the three corners, world space, unit length, on the side of the
    /// geometric normal; empty when no mesh has normals that differ from the geometric ones,
    /// else one row per triangle.
    pub shading_normals: Vec<[Vec3; 3]>,
    /// What textures go by, as many rows; empty where no material has any.
    pub corners: Corners,
    /// Analytic spheres.
    pub spheres: Vec<Sphere>,
    /// Meshes that stand in several places, kept once. None emits.
    pub instanced: Instanced,
    /// For every triangle and sphere, its row in `surfaces`.
    pub surface_of_primitive: Vec<u32>,
    /// One row per mesh primitive of a node, or sphere.
    pub surfaces: Vec<Surface>,
    /// What closed surfaces bound.
    pub bodies: Vec<Body>,
    /// Whether boundaries overlap or touch: then the medium of a point is that of the smallest body
    /// around it. Else every surface knows its two sides.
    pub overlaps: bool,
    /// Whether bodies then say of every place what is there: outside of all is the scene's medium.
    pub are_bodies_all: bool,
    /// Closed bodies of glass or water that overlap or touch: what is refracted there hangs on
    /// which of them are on its two sides. Empty where all are apart.
    pub solids: Vec<Solid>,
    /// What is around all solids: a row in `media`, or [`NONE`]; [`KEEP`] where that is to be found
    /// out.
    pub around_solids: u32,
    /// The row in the media of what fills the scene outside all boundaries, or [`NONE`]: clear.
    pub scene_medium: u32,
    /// Where the scene's own space has the origin of these tables and of the camera: they are
    /// centered on what that sees.
    pub origin: DVec3,
    /// What of the scene is not rendered as it stands there, one sentence each.
    pub warnings: Vec<String>,
    /// Sphere about the bounding box of all primitives and of the punctual lights, larger than
    /// the smallest one by no more than rounding needs. The camera may be outside.
    pub bounds: Bounds,
}

/// What everything does to light at `N` wavelengths: baked anew for others.
#[derive(Clone, Debug)]
pub struct Optics<const N: usize> {
    /// Materials; row 0 always exists.
    pub materials: Vec<Material<N>>,
    /// Participating media.
    pub media: Vec<Medium<N>>,
    /// Everything that emits, the environment included; at least one row, none without power.
    /// Primitives come first, in their order, then punctual lights, suns last, then the
    /// environment.
    pub emitters: Arc<Vec<Emitter>>,
    /// What emitters emit, one row for all of one spectrum: radiance, radiant intensity or
    /// irradiance, as their models have it; not negative, finite. By materials first, then by
    /// punctual lights, then by environments.
    pub lamps: Vec<[f32; N]>,
    /// How what lamps emit is polarized.
    pub states: EmittedStates<N>,
    /// What some of them emit by direction.
    pub patterns: Arc<Vec<Pattern>>,
    /// For every triangle and sphere, its row in `emitters`, or [`NONE`].
    pub emitter_of_primitive: Arc<Vec<u32>>,
    /// The rows in `emitters` of what is infinitely far away and can be seen: suns and environment.
    pub skies: Range<u32>,
    /// What the columns carry.
    pub carried: Carried<N>,
    /// What of materials differs from place to place, if anything does.
    pub painting: Option<Arc<Painting<N>>>,
    /// Spectra that are held beyond their ends: whose, and over which wavelengths of the render,
    /// one sentence each.
    pub held: Vec<String>,
}

impl<const N: usize> Optics<N> {
    /// How much an emitter emits at every wavelength.
    #[inline(always)]
    pub fn radiance_of(&self, emitter: usize) -> [f32; N] {
        self.lamps[self.emitters[emitter].lamp as usize]
    }
}

impl Shapes {
    /// The row of a primitive in `surfaces`, or [`NONE`] if there is no such primitive.
    #[inline(always)]
    pub fn surface_of(&self, primitive: u32) -> u32 {
        match self.surface_of_primitive.get(primitive as usize) {
            Some(surface) => *surface,
            None => self.instanced.instance_of(primitive).map_or(NONE, |it| it.surface),
        }
    }

    /// Whether any shading normal differs from the geometric one.
    pub fn has_shading_normals(&self) -> bool {
        !self.shading_normals.is_empty() || self.instanced.has_shading_normals()
    }

    /// The unit geometric normal of a primitive at a point on it, to its front.
    pub fn geometric_normal(&self, primitive: u32, position: Vec3) -> Vec3 {
        if let Some(normal) = self.instanced.geometric_normal(primitive) {
            return normal;
        }
        match (primitive as usize).checked_sub(self.triangles.len()) {
            None => {
                let [a, b, c] = self.triangles[primitive as usize].corners;
                (b - a).cross(c - a).normalize()
            }
            Some(sphere) => (position - self.spheres[sphere].center).normalize(),
        }
    }
}

/// A triangle; its geometric normal is `(b - a) x (c - a)`, counter-clockwise from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners.
    pub corners: [Vec3; 3],
}

/// An analytic sphere; its geometric normal points outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Center.
    pub center: Vec3,
    /// Radius, greater than zero.
    pub radius: f32,
}

/// What the primitives of one mesh instance, or a sphere, share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Row in `materials`.
    pub material: u32,
    /// The row instead of that if the surface bounds one of `solids`: air in glass refracts.
    pub nested_material: u32,
    /// The node's x axis in world space, unit length: what `axis_deg` of polarizers and
    /// retarders is measured from, once projected into the surface.
    pub axis_x: Vec3,
    /// The node's y axis in world space, unit length: takes the place of `axis_x` where the
    /// surface is (nearly) perpendicular to that.
    pub axis_y: Vec3,
    /// The node's z axis in world space, unit length: from it textures on spheres start.
    pub axis_z: Vec3,
    /// What lies behind the surface, against its normal: a row in `media`, [`NONE`] (clear),
    /// [`KEEP`] or [`SOUGHT`].
    pub interior: u32,
    /// What lies before the surface: a row in `media`, [`NONE`] (clear), [`KEEP`] or [`SOUGHT`].
    pub exterior: u32,
    /// Whether interior and exterior are not stated. They are then those of the scene's medium,
    /// until a look around says better.
    pub unstated: [bool; 2],
    /// Whether nothing passes.
    pub is_opaque: bool,
    /// Whether it is of a dielectric that does not say what is before it.
    pub is_body: bool,
    /// Which of overlapping bodies counts: the higher one.
    pub priority: i32,
    /// The row of the first of the surfaces that bound one body together: of itself, if it does so
    /// alone.
    pub whole: u32,
    /// Its row in `solids`, or [`NONE`].
    pub solid: u32,
}

/// What a closed surface bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Row in `surfaces`, of the first if it is of several.
    pub surface: u32,
    /// What fills it: a row in `media` or [`NONE`].
    pub filling: u32,
    /// Of bodies around a point the highest counts.
    pub priority: i32,
    /// Volume of its box; of bodies of the same priority the smallest counts, hence the innermost.
    pub size: f32,
}

/// A closed body of a dielectric, which may be of several surfaces, among others.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Row in `materials`.
    pub material: u32,
    /// Of solids around a point the highest counts.
    pub priority: i32,
    /// Volume of its box; of solids of the same priority the smallest counts, hence the innermost.
    pub size: f32,
    /// The corners of its box.
    pub bounds: [Vec3; 2],
    /// A ball about it.
    pub ball: Bounds,
    /// Slabs that it lies between, along its faces.
    pub slabs: Vec<Slab>,
    /// How far off it rays may start.
    pub off: f32,
    /// The solids that may reach into it, or up to it.
    pub others: Vec<u32>,
    /// What fills it: a row in `media`, or [`NONE`]; [`KEEP`] where that is to be found out.
    pub filling: u32,
}

/// What is between two parallel planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Of the planes, unit length.
    pub normal: Vec3,
    /// The least and greatest distance from the origin along that.
    pub between: [f32; 2],
}

/// A material at the wavelengths of the render.
#[derive(Clone, Debug, PartialEq)]
pub struct Material<const N: usize> {
    /// How it scatters.
    pub model: SurfaceModel<[f32; N]>,
    /// Whether the back scatters like the front; if not, the back absorbs. Without meaning where
    /// the model transmits.
    pub two_sided: bool,
}

impl<const N: usize> Material<N> {
    /// A black, opaque material.
    pub fn absorber() -> Self {
        Self { model: SurfaceModel::Absorber, two_sided: true }
    }
}

/// A homogeneous participating medium. Coefficients are per scene unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium<const N: usize> {
    /// Absorption coefficient; not negative, finite.
    pub sigma_a: [f32; N],
    /// Scattering coefficient; not negative, finite.
    pub sigma_s: [f32; N],
    /// How it scatters.
    pub phase: Phase<N>,
}

impl<const N: usize> Medium<N> {
    /// Whether it scatters any light.
    pub fn scatters(&self) -> bool {
        self.sigma_s.iter().any(|&sigma_s| sigma_s > 0.0)
    }
}

/// A phase function.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase<const N: usize> {
    /// Henyey and Greenstein 1941, an ideal depolarizer; isotropic where the mean cosine `g`,
    /// within (-1, 1), is zero.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle, positive forwards.
        g: [f32; N],
    },
    /// A polarizing phase matrix.
    Table(PhaseTable<N>),
}

/// A phase matrix at scattering angles theta that are equally spaced from 0 to pi, ends included:
/// `[[1,a,0,0],[a,b,0,0],[0,0,c,s],[0,0,-s,d]] M00` between frames whose x axis is the normal of
/// the scattering plane (`polarization`).
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTable<const N: usize> {
    /// `sin^2(theta / 2) = (1 - cos theta) / 2` of each angle: from 0 to 1.
    pub half_sine2: Vec<f32>,
    /// Phase function M00 in 1/sr per angle and wavelength. Read as linear in `half_sine2` between
    /// the angles, it integrates to one over the sphere of directions.
    pub m00: Vec<[f32; N]>,
    /// Share of the light that is scattered by less than each angle: from 0 to 1.
    pub cdf: Vec<[f32; N]>,
    /// The elements a, b, c, d, s over M00, in this order, per angle and wavelength; read as
    /// linear in the angle.
    pub elements: Vec<[[f32; N]; 5]>,
    /// Whether b = 1 and d = c throughout, as for spheres.
    pub spheres: bool,
    /// Whether the elements are the same at all wavelengths (M00 may differ).
    pub achromatic: bool,
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole (`aperture_radius` 0) or thin lens.
    Perspective {
        /// Tangent of half the vertical angle of view.
        tan_half_y: f32,
        /// Tangent of half the horizontal angle of view that the film shows at least, by a larger
        /// vertical one if it is narrow; zero if the vertical angle counts alone.
        tan_half_x_min: f32,
        /// Width over height as the file states it; the film's own aspect where it does not.
        aspect: Option<f32>,
        /// Radius of the lens, 0 for a pinhole.
        aperture_radius: f32,
        /// Distance from the lens to the plane in focus, along the viewing direction.
        focus_distance: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width of the picture.
        half_width: f32,
        /// Half the height of the picture.
        half_height: f32,
    },
}

/// The camera, without the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Projection.
    pub projection: Projection,
    /// Position of the lens.
    pub position: Vec3,
    /// To the right in the image; unit length, as the next two, and perpendicular to them.
    pub right: Vec3,
    /// Up in the image.
    pub up: Vec3,
    /// The viewing direction.
    pub forward: Vec3,
    /// Film size in pixels that the scene asks for (width, height).
    pub resolution: Option<[u32; 2]>,
    /// How the pixels of that film see.
    pub raster: Raster,
    /// What stands before the film, in its frame.
    pub analyzer: Option<Analyzer>,
}

impl Camera {
    /// Width over height of what it shows, if the scene says so.
    pub fn aspect(&self) -> Option<f32> {
        match (self.resolution, self.projection) {
            (Some([width, height]), _) => {
                Some(width as f32 * self.raster.pixel_aspect / height as f32)
            }
            (None, Projection::Perspective { aspect, .. }) => aspect,
            (None, Projection::Orthographic { half_width, half_height }) => {
                Some(half_width / half_height)
            }
        }
    }
}

/// A bounding sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Center.
    pub center: Vec3,
    /// Radius, greater than zero.
    pub radius: f32,
}
