//! Phase functions, eight rows of one medium at a time: a file for each, behind the trait
//! [`Scatters`].
//!
//! Scattering angles come as `half_sine2 = sin^2(theta / 2)`, which two unit vectors give without
//! cancellation however close to forward they are: a quarter of the square of their difference.

mod henyey_greenstein;
mod table;

use crate::math::{F32s, LANES, Real, Vector, warp};
use crate::polarization::kernel::SpheroidBlock;
use crate::scattering::event::Form;
use crate::scene::baked;

pub use self::henyey_greenstein::HenyeyGreenstein;
pub use self::table::PhaseLookup;

/// What the stages ask of a phase function.
pub trait Scatters<const N: usize> {
    /// Whether what leaves can be polarized.
    const POLARIZES: bool;

    /// Which elements its phase matrix has, and whether these are the same at all wavelengths.
    fn kernel(&self) -> (Form, bool);

    /// Its mean cosine at a wavelength, and its mean square over the sphere relative to that of an
    /// even one: how many photons that arrive from anywhere count for as much as one.
    fn moments(&self, wavelength: usize) -> [f32; 2];

    /// The phase function at every wavelength, in 1/sr: also the density of [`Self::sample`].
    fn values(&self, half_sine2: F32s) -> [F32s; N];

    /// An angle distributed by the phase function of each lane's wavelength.
    fn sample(&self, wavelength: [u32; LANES], u: F32s) -> F32s;

    /// The phase matrix over its first element, at every wavelength; zero where it depolarizes.
    fn kernels(&self, half_sine2: F32s) -> [SpheroidBlock<F32s>; N];

    /// [`Self::values`] and [`Self::kernels`] by one look.
    fn values_and_kernels(&self, half_sine2: F32s) -> ([F32s; N], [SpheroidBlock<F32s>; N]);
}

/// The list: for every phase function its name, its type and its documentation.
macro_rules! phase_functions {
    ([$($then:tt)*] $arguments:tt) => {
        $($then)*! {
            $arguments
            /// Henyey and Greenstein, a depolarizer.
            HenyeyGreenstein: HenyeyGreenstein<N>,
            /// Tabulated, polarizing.
            Table: PhaseLookup<N>,
        }
    };
}

macro_rules! declare {
    (() $($(#[$doc:meta])* $name:ident: $model:ty,)*) => {
        /// A phase function, ready for look-ups.
        #[derive(Clone, Debug)]
        pub enum PhaseFunction<const N: usize> {
            $($(#[$doc])* $name($model),)*
        }
    };
}

phase_functions!([declare]());

/// Compiles code for every phase function, and runs that of the one at hand.
macro_rules! for_phase {
    ($phase:expr, $model:ident => $body:expr) => {
        $crate::scattering::phase::phase_functions!([$crate::scattering::phase::dispatch_phase](
            $phase, $model, $body
        ))
    };
}

macro_rules! dispatch_phase {
    (($phase:expr, $at:ident, $body:expr) $($(#[$doc:meta])* $name:ident: $model:ty,)*) => {
        match $phase {
            $($crate::scattering::phase::PhaseFunction::$name($at) => $body,)*
        }
    };
}

pub(crate) use {dispatch_phase, for_phase, phase_functions};

impl<const N: usize> PhaseFunction<N> {
    /// Whether it depolarizes, and is the same at all wavelengths; of tables nobody asks.
    pub fn is_gray(&self) -> bool {
        match self {
            Self::HenyeyGreenstein(HenyeyGreenstein { g }) => g.iter().all(|of| *of == g[0]),
            Self::Table(_) => N == 1,
        }
    }
}

impl<const N: usize> From<&baked::Phase<N>> for PhaseFunction<N> {
    fn from(phase: &baked::Phase<N>) -> Self {
        match phase {
            baked::Phase::HenyeyGreenstein { g } => {
                Self::HenyeyGreenstein(HenyeyGreenstein { g: *g })
            }
            baked::Phase::Table(table) => Self::Table(PhaseLookup::new(table)),
        }
    }
}

/// `sin^2(theta / 2)` of the angle between two unit vectors.
#[inline(always)]
pub fn half_sine2<F: Real>(from: Vector<F>, to: Vector<F>) -> F {
    let quarter = (to - from).length_squared() * F::splat(0.25);
    F::select(quarter.gt(F::one()), F::one(), quarter)
}

/// A unit vector at the angle `half_sine2` to the unit vector `axis`, turned by `turns` about it.
#[inline(always)]
pub fn deflect(axis: Vector<F32s>, half_sine2: F32s, turns: F32s) -> Vector<F32s> {
    let one = F32s::splat(1.0);
    let cosine = one - half_sine2 - half_sine2;
    let sine = F32s::splat(2.0) * (half_sine2 * (one - half_sine2)).max(F32s::splat(0.0)).sqrt();
    let (y, x) = warp::sin_cos_turns(turns);
    let tangent = axis.any_perpendicular();
    let bitangent = axis.cross(tangent);
    tangent.mul_add(x * sine, bitangent.mul_add(y * sine, axis * cosine)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes;
    use crate::polarization::rayleigh::rayleigh_depolarized;
    use crate::scene::baked::PhaseTable;

    /// The table of depolarized dipoles, made here so that nothing else is needed.
    fn dipoles() -> PhaseLookup<1> {
        const INTERVALS: usize = 1024;
        let angle = |i: usize| std::f64::consts::PI * i as f64 / INTERVALS as f64;
        let at = |i: usize| rayleigh_depolarized(angle(i).cos(), 0.03);
        let half_sine2: Vec<f64> =
            (0..=INTERVALS).map(|i| (0.5 * angle(i)).sin().powi(2)).collect();
        let mut cdf = vec![0.0];
        for i in 0..INTERVALS {
            let mean = 0.5 * (at(i).0 + at(i + 1).0);
            let step = half_sine2[i + 1] - half_sine2[i];
            cdf.push(cdf[i] + 4.0 * std::f64::consts::PI * mean * step);
        }
        let total = cdf[INTERVALS];
        let single = |value: f64| [value as f32];
        PhaseLookup::new(&PhaseTable {
            half_sine2: half_sine2.iter().map(|&x| x as f32).collect(),
            m00: (0..=INTERVALS).map(|i| single(at(i).0 / total)).collect(),
            cdf: cdf.iter().map(|&x| single(x / total)).collect(),
            elements: (0..=INTERVALS)
                .map(|i| {
                    let kernel = at(i).1;
                    [kernel.a, kernel.b, kernel.c, kernel.d, kernel.s].map(single)
                })
                .collect(),
            spheres: false,
            achromatic: true,
        })
    }

    #[test]
    fn tables_read_what_they_were_made_of() {
        let phase = dipoles();
        for step in 0..=1000 {
            let theta = std::f64::consts::PI * f64::from(step) / 1000.0;
            let v = F32s::splat((0.5 * theta).sin().powi(2) as f32);
            let (m00, expected) = rayleigh_depolarized(theta.cos(), 0.03);
            let found = f64::from(phase.values(v)[0].to_array()[0]);
            assert!((found / m00 - 1.0).abs() < 1e-5, "{theta}: {found}, {m00}");
            let [kernel] = phase.kernels(v);
            for (found, expected) in [
                (kernel.a, expected.a),
                (kernel.b, expected.b),
                (kernel.c, expected.c),
                (kernel.d, expected.d),
                (kernel.s, expected.s),
            ] {
                assert!((f64::from(found.to_array()[0]) - expected).abs() < 2e-5, "{theta}");
            }
        }
    }

    #[test]
    fn samples_follow_the_values() {
        check_samples(&dipoles());
        for g in [0.8, -0.3, 0.0] {
            check_samples(&HenyeyGreenstein { g: [g] });
        }
    }

    /// The share of samples below an angle is the integral up to it: 2^16 equal steps of the
    /// random number leave no noise.
    fn check_samples(phase: &impl Scatters<1>) {
        const COUNT: usize = 1 << 16;
        let mut samples = Vec::new();
        for first in (0..COUNT).step_by(LANES) {
            let u = lanes::each(|lane| ((first + lane) as f32 + 0.5) / COUNT as f32);
            samples.extend(phase.sample([0; LANES], F32s::from(u)).to_array());
        }
        let mut integral = 0.0;
        for step in 0..2048 {
            let middle = F32s::splat((step as f32 + 0.5) / 2048.0);
            let value = f64::from(phase.values(middle)[0].to_array()[0]);
            integral += value * 4.0 * std::f64::consts::PI / 2048.0;
            let edge = (step as f32 + 1.0) / 2048.0;
            let below = samples.iter().filter(|&&v| v < edge).count() as f64 / COUNT as f64;
            assert!((below - integral).abs() < 2e-3, "{edge}: {below}, {integral}");
        }
        assert!((integral - 1.0).abs() < 2e-3, "{integral}");
    }

    #[test]
    fn deflections_have_their_angle() {
        let axis = Vector::splat([0.6, 0.0, -0.8]);
        let angles = F32s::from([0.0, 1e-6, 1e-4, 0.01, 0.3, 0.7, 0.999, 1.0]);
        let found = half_sine2(axis, deflect(axis, angles, F32s::splat(0.3))).to_array();
        for (found, expected) in found.iter().zip(angles.to_array()) {
            assert!((found - expected).abs() < 1e-3 * expected.min(1e-3) + 1e-7);
        }
    }
}
