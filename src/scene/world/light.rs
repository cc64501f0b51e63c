//! Lights without a surface: punctual ones and the environment.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DQuat, Vec3};

use super::clear_sky::ClearSky;
use super::texture::Picture;

use super::Photometry;

use crate::image::texels::Coding;
use crate::math::elementary::tan;
use crate::math::{Fault, Range};
use crate::scene::panorama::{Panorama, brightness};
use crate::spectrum::Spectrum;

/// A light without extent, along the -z axis of its transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Punctual {
    /// Its shape.
    pub kind: PunctualKind,
    /// Radiant intensity in W/sr, or irradiance in W/m^2 if directional; not negative. Zero
    /// throughout emits nothing.
    pub intensity: Spectrum,
}

/// What a point emits by direction: that of the measurement times its own intensity. The axis from
/// which vertical angles are measured is the -z axis of its transform; horizontal ones turn
/// counter-clockwise about z from its x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Luminaire(pub Arc<Photometry>);

/// The picture that a spot throws: from left to right it takes up twice the spot's outer angle, and
/// from top to bottom what its shape makes of that. On a wall at a distance of 1 that faces it, the
/// irradiance is the spot's intensity times the texel, all over. It throws along the -z axis of its
/// transform; right in the picture is x, and up is y.
#[derive(Clone, Debug)]
pub struct Projection(pub Arc<Picture>);

impl PartialEq for Projection {
    /// Pictures are the same if their files are.
    fn eq(&self, other: &Self) -> bool {
        self.0.checksum == other.0.checksum
    }
}

/// Shapes of punctual lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// The same in all directions.
    Point,
    /// A cone.
    Spot {
        /// Half angle of full intensity in radians, at least 0.
        inner: f64,
        /// Half angle of the whole cone in radians, greater than 0, at most pi/2, not less than
        /// `inner`.
        outer: f64,
        /// How it falls off between them.
        falloff: Falloff,
    },
    /// Infinitely far away.
    Directional,
    /// The same, but a disk of the same radiance all over it, as the sun nearly is.
    Sun {
        /// The angle that it takes up in radians: greater than 0, less than pi.
        diameter: f64,
    },
}

/// How a spot falls off from its inner angle to its outer one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Falloff {
    /// With the square of a ramp in the cosine of the angle, as KHR_lights_punctual recommends.
    #[default]
    Cosine,
    /// Evenly with the angle, as Mitsuba has it.
    Angle,
}

impl Falloff {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Cosine, Self::Angle];

    /// What files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cosine => "cosine",
            Self::Angle => "angle",
        }
    }
}

/// The angle that the sun takes up, in radians: 0.533 degrees.
pub const SUN_DIAMETER: f64 = 0.533 * PI / 180.0;
/// The least of a sun: less is a direction.
const DIAMETER_MIN: f64 = 1e-5;

impl Punctual {
    /// The same radiant intensity in W/sr in all directions.
    pub fn point(intensity: impl Into<Spectrum>) -> Self {
        Self { kind: PunctualKind::Point, intensity: intensity.into() }
    }

    /// A cone: radiant intensity on its axis in W/sr, half angles of full intensity and of the
    /// whole in radians.
    pub fn spot(intensity: impl Into<Spectrum>, inner: f64, outer: f64) -> Self {
        let kind = PunctualKind::Spot { inner, outer, falloff: Falloff::Cosine };
        Self { kind, intensity: intensity.into() }
    }

    /// Parallel light: irradiance in W/m^2 on a plane that faces it.
    pub fn directional(irradiance: impl Into<Spectrum>) -> Self {
        Self { kind: PunctualKind::Directional, intensity: irradiance.into() }
    }

    /// A sun: irradiance in W/m^2 on a plane that faces it, and the angle that it takes up in
    /// radians ([`SUN_DIAMETER`] as seen from the earth).
    pub fn sun(irradiance: impl Into<Spectrum>, diameter: f64) -> Self {
        Self { kind: PunctualKind::Sun { diameter }, intensity: irradiance.into() }
    }

    /// Refuses what cannot shine.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.kind.check()?;
        self.intensity.check("intensity", Range::NOT_NEGATIVE)
    }
}

impl Luminaire {
    /// Refuses lights of another kind than points.
    pub(super) fn check(kind: Option<PunctualKind>) -> Result<(), Fault> {
        match kind {
            Some(PunctualKind::Point) => Ok(()),
            Some(
                PunctualKind::Spot { .. } | PunctualKind::Directional | PunctualKind::Sun { .. },
            )
            | None => {
                let problem = "is what points emit, and this is none";
                Err(Fault::new("ies", problem, "make the light a point"))
            }
        }
    }
}

impl Projection {
    /// Tangents of half the angles that a picture takes up, by the first of these.
    pub(in crate::scene) fn halves(picture: &Picture, half_angle: f64) -> [f64; 2] {
        let [width, height] = picture.texels().size().map(f64::from);
        let half = tan(half_angle);
        [half, half * height / width]
    }

    /// The mean intensity over all directions, relative to that on the axis through a texel of 1:
    /// that of the picture on the wall at a distance of 1.
    pub(in crate::scene) fn mean(picture: &Picture, half_angle: f64) -> f64 {
        let [x, y] = Self::halves(picture, half_angle);
        brightness(picture.mean(Coding::Srgb)) * x * y / PI
    }

    /// The mean of what a light throws.
    pub(in crate::scene) fn mean_of(&self, kind: PunctualKind) -> f64 {
        match kind {
            PunctualKind::Spot { outer, .. } => Self::mean(&self.0, outer),
            PunctualKind::Point | PunctualKind::Directional | PunctualKind::Sun { .. } => 1.0,
        }
    }

    /// Refuses lights of another kind than spots, and pictures that cannot be thrown.
    pub(super) fn check(&self, kind: Option<PunctualKind>) -> Result<(), Fault> {
        let fault = |problem: String, remedy: &str| Err(Fault::new("picture", problem, remedy));
        let outer = match kind {
            Some(PunctualKind::Spot { outer, .. }) => outer,
            Some(PunctualKind::Point | PunctualKind::Directional | PunctualKind::Sun { .. })
            | None => {
                let problem = "is what spots throw, and this is none";
                return fault(problem.into(), "make the light a spot");
            }
        };
        if !(HALF_ANGLE_MIN..=HALF_ANGLE_MAX).contains(&outer) {
            let problem = format!("is thrown into an outer angle of {outer} radians");
            return fault(problem, "make that 0.00001 to 1.55 (88.8 degrees)");
        }
        if self.0.is_polarized() {
            let problem = "is polarized itself, which projectors do not show";
            return fault(problem.into(), "use one without Stokes vectors; the light has `stokes`");
        }
        match Self::mean(&self.0, outer) {
            0.0 => fault("is black all over".into(), "use another, or remove the light"),
            mean if mean.is_finite() && mean <= f64::from(f32::MAX) => Ok(()),
            _ => fault("is too bright".into(), "scale it down, and the intensity up"),
        }
    }
}

/// The least and the largest half angle that a picture takes up, in radians.
const HALF_ANGLE_MIN: f64 = 1e-5;
const HALF_ANGLE_MAX: f64 = 1.55;

impl PunctualKind {
    /// Whether a sun may have a diameter in radians.
    pub(in crate::scene) fn is_diameter(diameter: f64) -> bool {
        (DIAMETER_MIN..PI).contains(&diameter)
    }

    fn check(&self) -> Result<(), Fault> {
        match *self {
            Self::Point | Self::Directional => Ok(()),
            Self::Sun { diameter } if Self::is_diameter(diameter) => Ok(()),
            Self::Sun { diameter } => {
                let problem = format!("is {diameter} radians");
                let remedy =
                    "from 0.00001 to less than pi (180 degrees); without, it is a direction";
                Err(Fault::new("angular_diameter", problem, remedy))
            }
            // Blender writes equal angles for a spot without soft edge, so that is fine.
            Self::Spot { inner, outer, .. }
                if inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 =>
            {
                Ok(())
            }
            Self::Spot { inner, outer, .. } => {
                // As files state them.
                let [inner, outer] = [inner, outer].map(|angle| angle as f32);
                let problem = format!(
                    "the inner cone angle of {inner} and the outer of {outer} radians do not fit"
                );
                Err(Fault::new("spot", problem, "give 0 <= inner <= outer <= pi/2 (90 degrees)"))
            }
        }
    }
}

/// Radiance from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Its mean in W/(m^2 sr); not negative. Zero throughout emits nothing. Where a picture says
    /// what comes from where, a number or a color, which that is multiplied by.
    pub radiance: Spectrum,
    /// A vector in world space, of length 1 at most: from the direction d comes the mean times
    /// 1 + d . gradient. Zero with a picture.
    pub gradient: Vec3,
    /// What comes from where, if a picture says so.
    pub backdrop: Option<Backdrop>,
}

/// A picture of all directions.
#[derive(Clone)]
pub struct Backdrop {
    /// The picture, equirectangular: its middle shows +x, right of that lies +z, and the upper edge
    /// is +y.
    pub picture: Arc<Picture>,
    /// What turns that to world space; of unit length.
    pub rotation: DQuat,
    /// What it was made of.
    pub source: BackdropSource,
}

/// What a picture of all directions was made of.
#[derive(Clone, Debug, PartialEq)]
pub enum BackdropSource {
    /// A file of this name, as the scene's file has it.
    File(String),
    /// Bytes.
    Memory,
    /// A model.
    ClearSky(ClearSky),
}

impl From<ClearSky> for Backdrop {
    fn from(sky: ClearSky) -> Self {
        let picture = Arc::new(sky.picture());
        Self { picture, rotation: DQuat::IDENTITY, source: BackdropSource::ClearSky(sky) }
    }
}

impl PartialEq for Backdrop {
    /// Pictures are the same if their files are.
    fn eq(&self, other: &Self) -> bool {
        self.picture.checksum == other.picture.checksum
            && (self.rotation, &self.source) == (other.rotation, &other.source)
    }
}

impl fmt::Debug for Backdrop {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Backdrop {:?} {:?} {:?}", self.picture, self.rotation, self.source)
    }
}

impl Backdrop {
    /// What makes one doubt that the picture shows all directions.
    pub(in crate::scene) fn doubt(&self) -> Option<&'static str> {
        let [width, height] = self.picture.texels().size();
        let may_show_all = width == 2 * height || [width, height] == [1, 1];
        (!may_show_all).then_some(
            "is not twice as wide as high: it is taken for an equirectangular picture all the same",
        )
    }
}

impl Environment {
    /// One that is the same from everywhere.
    pub fn constant(radiance: impl Into<Spectrum>) -> Self {
        Self { radiance: radiance.into(), gradient: Vec3::ZERO, backdrop: None }
    }

    /// Whether a picture says how it is polarized.
    pub fn is_polarized(&self) -> bool {
        self.backdrop.as_ref().is_some_and(|backdrop| backdrop.picture.is_polarized())
    }

    /// The fault of a state beside a picture that has them.
    pub(super) fn polarized_twice() -> Fault {
        let problem = "does not go with a picture that is polarized itself";
        Fault::new("stokes", problem, "take one of them away")
    }

    /// What comes from everywhere on the average.
    pub fn mean(&self) -> Spectrum {
        self.panorama().map_or_else(|| self.radiance.clone(), |it| Spectrum::Rgb(it.mean()))
    }

    /// What comes from where, if a picture says so.
    pub fn panorama(&self) -> Option<Panorama> {
        let backdrop = self.backdrop.as_ref()?;
        let factor = self.radiance.rgb()?;
        let to_world = DMat3::from_quat(backdrop.rotation).as_mat3();
        Some(Panorama::new(Arc::clone(&backdrop.picture), factor, to_world))
    }

    /// Refuses what cannot shine.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.radiance.check("radiance", Range::NOT_NEGATIVE)?;
        let length = self.gradient.length();
        if length.is_nan() || length > 1.0 + TOLERANCE {
            let problem = format!("its length must be at most 1, not {length}");
            return Err(Fault::new("gradient", problem, "no sky is darker than black"));
        }
        self.backdrop.as_ref().map_or(Ok(()), |backdrop| self.check_backdrop(backdrop))
    }

    fn check_backdrop(&self, backdrop: &Backdrop) -> Result<(), Fault> {
        if self.gradient != Vec3::ZERO {
            let problem = "does not go with a picture, which says what is brighter";
            return Err(Fault::new("gradient", problem, "take one of them away"));
        }
        if self.radiance.rgb().is_none() {
            let problem = "is a spectrum, and the colors are those of the picture";
            return Err(Fault::new("radiance", problem, "give a number or [red, green, blue]"));
        }
        let length = backdrop.rotation.length();
        let off = (length - 1.0).abs();
        if off.is_nan() || off > f64::from(TOLERANCE) {
            let problem = format!("its length must be 1, not {length}");
            return Err(Fault::new("rotation", problem, "give the quaternion of a rotation"));
        }
        if self.mean().values().iter().any(|value| !value.is_finite()) {
            let problem = "times the picture is beyond what single precision holds";
            return Err(Fault::new("radiance", problem, "make it smaller"));
        }
        Ok(())
    }
}

/// How much longer than 1 a vector may come out of rounding.
const TOLERANCE: f32 = 1e-5;
