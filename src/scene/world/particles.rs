//! Media of spheres: what is suspended, and in what.

use crate::math::{Fault, Range};
use crate::polarization::particles::Sizes;
use crate::spectrum::Spectrum;

/// Most kinds of particles in one medium.
const COMPONENTS_MAX: usize = 16;

/// Real parts of indices of refraction of particles and their host.
const INDEX: Range = Range::new("within [0.05, 20]", |x| (0.05..=20.0).contains(&x));
/// Extinction coefficients of particles and their host.
const EXTINCTION: Range = Range::new("within [0, 20]", |x| (0.0..=20.0).contains(&x));

/// Spheres in a host that absorbs but does not scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct Spheres {
    /// What is suspended; one to 16 kinds, together no more than the whole volume.
    pub components: Vec<Component>,
    /// Real part of the host's index of refraction n - i k, from 0.05 to 20.
    pub host_eta: Spectrum,
    /// Extinction coefficient of the host, from 0 to 20.
    pub host_k: Spectrum,
}

impl Spheres {
    /// Refuses what cannot be suspended.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        let count = self.components.len();
        if !(1..=COMPONENTS_MAX).contains(&count) {
            let problem = format!("has {count} kinds of particles");
            let remedy = format!("give one to {COMPONENTS_MAX}");
            return Err(Fault::new("components", problem, remedy));
        }
        for (index, component) in self.components.iter().enumerate() {
            let part = || format!("components[{index}]");
            component.check().map_err(|fault| fault.within(&part()))?;
        }
        let filled: f64 = self.components.iter().map(|component| component.volume_fraction).sum();
        if filled > 1.0 {
            let problem = format!("fill {filled} of the volume");
            return Err(Fault::new("components", problem, "lower the volume fractions"));
        }
        self.host_eta.check("host_eta", INDEX)?;
        self.host_k.check("host_k", EXTINCTION)
    }
}

/// Spheres of one substance.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Their sizes.
    pub sizes: Sizes,
    /// Real part of their index of refraction n - i k, from 0.05 to 20.
    pub eta: Spectrum,
    /// Extinction coefficient k, from 0 to 20.
    pub k: Spectrum,
    /// Share of the volume that they fill, within (0, 1].
    pub volume_fraction: f64,
}

impl Component {
    /// Refuses what cannot be suspended. Sizes have been checked when they were made.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        Range::FRACTION.check("volume_fraction", self.volume_fraction)?;
        self.eta.check("eta", INDEX)?;
        self.k.check("k", EXTINCTION)
    }
}
