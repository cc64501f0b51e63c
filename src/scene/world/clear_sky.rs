//! The light of a clear sky, by models in closed form.
//!
//! How bright it is and of what color: A. J. Preetham, P. Shirley and B. Smits 1999 ("A practical
//! analytic model for daylight", appendix A.2), a fit to simulated skies in the form of R. Perez,
//! R. Seals and J. Michalsky 1993. How it is polarized: as air scatters sunlight once (Rayleigh),
//! D = D_max sin^2 g / (1 + cos^2 g) at the angle g from the sun, perpendicular to the plane of sun
//! and line of sight, which is what the analytic model of A. Wilkie, R. F. Ulbricht, R. F. Tobler,
//! G. Zotti and W. Purgathofer 2004 ("An analytical model for skylight polarisation") rests on.
//! Neutral points near sun and antisun, which multiple scattering makes, are not in it.
//!
//! Below the horizon nothing shines, nor does the sun itself.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::texture::{Picture, States, half_hash};
use crate::math::Fault;
use crate::math::elementary::{acos, cos, exp, sin_cos, tan};
use crate::spectrum::color_space::rgb_of_xyz;

/// Rows of the picture that it is made into; as many columns again.
const ROWS: usize = 256;
/// Lumens per watt, as for lights in candela and lux; and what a thousand candelas are.
const LUMENS_PER_WATT: f64 = 683.0;
const KILO: f64 = 1000.0;
/// What turbidities the fit is of, at the most.
const TURBIDITY: [f64; 2] = [1.7, 10.0];

/// A clear sky above the plane of x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearSky {
    /// To the sun, of any length; above the horizon (y > 0).
    pub sun: DVec3,
    /// How hazy it is, from 1.7 (mountains) and 2 (clear) to 10 (haze): all that dims the sun over
    /// what clean air does.
    pub turbidity: f64,
    /// The degree of polarization at a right angle to the sun, from 0 to 1; measured are up to
    /// 0.85.
    pub max_degree: f64,
}

impl ClearSky {
    /// The turbidity and the degree that are taken where nothing is said.
    pub const TURBIDITY: f64 = 3.0;
    /// See there.
    pub const MAX_DEGREE: f64 = 0.8;

    /// Refuses what the models are not of.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        let Self { sun, turbidity, max_degree } = *self;
        if !sun.try_normalize().is_some_and(|sun| sun.y > 0.0) {
            let problem = format!("{sun} is not above the horizon");
            return Err(Fault::new("sun_direction", problem, "give a vector with y > 0"));
        }
        let [least, most] = TURBIDITY;
        if !(least..=most).contains(&turbidity) {
            let problem = format!("{turbidity} is not known");
            let remedy = format!("from {least} (very clear) to {most} (haze)");
            return Err(Fault::new("turbidity", problem, remedy));
        }
        if !(0.0..=1.0).contains(&max_degree) {
            let problem = format!("{max_degree} must be within [0, 1]");
            return Err(Fault::new("max_degree", problem, ""));
        }
        Ok(())
    }

    /// A picture of it, equirectangular, of radiance in W/(m^2 sr): luminance over 683 lm/W.
    pub(in crate::scene) fn picture(&self) -> Picture {
        let sun = self.sun.normalize();
        let light = Daylight::new(acos(sun.y.min(1.0)), self.turbidity);
        let columns = 2 * ROWS;
        let (mut colors, mut states) = (Vec::new(), Vec::new());
        for texel in 0..columns * ROWS {
            let polar = PI * ((texel / columns) as f64 + 0.5) / ROWS as f64;
            let around = TAU * (((texel % columns) as f64 + 0.5) / columns as f64 - 0.5);
            let ((sine, y), (z, x)) = (sin_cos(polar), sin_cos(around));
            let at = DVec3::new(sine * x, y, sine * z);
            let is_above = polar < FRAC_PI_2;
            let cos_sun = at.dot(sun).clamp(-1.0, 1.0);
            colors.push(if is_above { light.color(y, cos_sun) } else { [0.0; 3] });
            states.push(if is_above { self.state(at, (sun, cos_sun)) } else { [[0.0; 3]; 3] });
        }
        let named = format!("{sun:?} {} {}", self.turbidity, self.max_degree);
        Picture::of_states((columns, colors), states, half_hash(named.as_bytes()))
    }

    /// How it is polarized in a direction, which is not straight up: in the frame of a picture.
    fn state(&self, at: DVec3, (sun, cos_sun): (DVec3, f64)) -> States {
        let right = DVec3::new(-at.z, 0.0, at.x).normalize();
        let up = right.cross(at);
        // Along what is perpendicular to both.
        let along = sun.cross(at);
        let (a, b) = (along.dot(right), along.dot(up));
        let sin2 = a * a + b * b;
        if sin2 == 0.0 {
            return [[0.0; 3]; 3];
        }
        let degree = self.max_degree * (1.0 - cos_sun * cos_sun) / (1.0 + cos_sun * cos_sun);
        let [s1, s2] = [(a * a - b * b) / sin2, 2.0 * a * b / sin2].map(|it| (degree * it) as f32);
        [[s1, s2, 0.0]; 3]
    }
}

/// Luminance and chromaticity by Preetham et al. 1999.
struct Daylight {
    /// At the zenith: luminance in thousands of candelas per square meter, x and y.
    zenith: [f64; 3],
    /// Perez's coefficients of each.
    shapes: [Perez; 3],
    /// What these say of the zenith.
    of_zenith: [f64; 3],
}

/// The five coefficients of a distribution over the sky.
struct Perez([f64; 5]);

impl Perez {
    /// Relative to others in directions with these cosines to the zenith and to the sun.
    fn at(&self, cos_zenith: f64, cos_sun: f64) -> f64 {
        let Self([a, b, c, d, e]) = *self;
        let about_sun = 1.0 + c * exp(d * acos(cos_sun)) + e * cos_sun * cos_sun;
        (1.0 + a * exp(b / cos_zenith)) * about_sun
    }
}

impl Daylight {
    /// With the sun at an angle from the zenith in radians.
    fn new(sun: f64, turbidity: f64) -> Self {
        let t = turbidity;
        let along = |rows: [[f64; 2]; 5]| Perez(rows.map(|[slope, at_zero]| slope * t + at_zero));
        let shapes = [
            along([
                [0.1787, -1.4630],
                [-0.3554, 0.4275],
                [-0.0227, 5.3251],
                [0.1206, -2.5771],
                [-0.0670, 0.3703],
            ]),
            along([
                [-0.0193, -0.2592],
                [-0.0665, 0.0008],
                [-0.0004, 0.2125],
                [-0.0641, -0.8989],
                [-0.0033, 0.0452],
            ]),
            along([
                [-0.0167, -0.2608],
                [-0.0950, 0.0092],
                [-0.0079, 0.2102],
                [-0.0441, -1.6537],
                [-0.0109, 0.0529],
            ]),
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * sun);
        let luminance = (4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192;
        let x = zenith_color(
            sun,
            t,
            [
                [0.001_66, -0.003_75, 0.002_09, 0.0],
                [-0.029_03, 0.063_77, -0.032_02, 0.003_94],
                [0.116_93, -0.211_96, 0.060_52, 0.258_86],
            ],
        );
        let y = zenith_color(
            sun,
            t,
            [
                [0.002_75, -0.006_10, 0.003_17, 0.0],
                [-0.042_14, 0.089_70, -0.041_53, 0.005_16],
                [0.153_46, -0.267_56, 0.066_70, 0.266_88],
            ],
        );
        let of_zenith = [0, 1, 2].map(|it: usize| shapes[it].at(1.0, cos(sun)));
        Self { zenith: [luminance.max(0.0), x, y], shapes, of_zenith }
    }

    /// Radiance in W/(m^2 sr) as linear red, green and blue, not negative.
    fn color(&self, cos_zenith: f64, cos_sun: f64) -> [f32; 3] {
        let [luminance, x, y] = [0, 1, 2].map(|it: usize| {
            let shape = self.shapes[it].at(cos_zenith, cos_sun);
            self.zenith[it] * shape / self.of_zenith[it]
        });
        let luminance = luminance.max(0.0) * KILO / LUMENS_PER_WATT;
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        rgb_of_xyz(xyz).to_array().map(|value| value.max(0.0) as f32)
    }
}

/// A chromaticity at the zenith: cubic in the sun's angle, quadratic in the turbidity.
fn zenith_color(sun: f64, t: f64, rows: [[f64; 4]; 3]) -> f64 {
    let [a, b, c] = rows.map(|[p, q, r, s]| ((p * sun + q) * sun + r) * sun + s);
    (a * t + b) * t + c
}
