//! How light is polarized as it leaves what emits it.

use crate::math::{Fault, Range};
use crate::spectrum::{Beyond, Carried, OutsideTable, RGB_WAVELENGTHS_NM, Role, Spectrum};

/// How much more than 1 a degree of polarization may come out of rounding.
const DEGREE_TOLERANCE: f32 = 1e-5;

/// What a component over S0 may be.
const COMPONENT: Range = Range::new("within [-1, 1]", |x| (-1.0..=1.0).contains(&x));

/// The state of polarization in which a material that emits, a light or the environment does; what
/// has none emits unpolarized light.
///
/// It is given for light along the unit vector k in the frame (x, k cross x, k), where x is the x
/// axis of the node (of the scene itself for the environment), less what of it is along k; the
/// node's y axis takes its place where the two are parallel, to 1e-4 radians. So S1 > 0 is along
/// the node's x axis, and S2 > 0 between that and k cross x: for light along the node's z axis the
/// y axis, and for lights, which shine along its -z axis, the -y axis.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedStokes {
    /// S1, S2 and S3 over S0: within a ball of radius 1 at every wavelength. Red, green and blue
    /// hold at the wavelengths that stand for the channels, as those of indices of refraction.
    pub stokes: [Spectrum; 3],
}

impl EmittedStokes {
    /// S1, S2 and S3 over S0.
    ///
    /// # Errors
    /// When light would be polarized more than wholly.
    pub fn new<S: Into<Spectrum>>(stokes: [S; 3]) -> Result<Self, Fault> {
        let stokes = Self { stokes: stokes.map(Into::into) };
        stokes.check().map(|()| stokes)
    }

    /// What is wrong with one where nothing is emitted.
    pub(crate) fn without_emission() -> Fault {
        Fault::new("stokes", "is the state of what is emitted, and nothing is", "add an emission")
    }

    /// Whether it is none at all.
    pub fn is_unpolarized(&self) -> bool {
        self.stokes.iter().all(|it| it.values().iter().all(|value| *value == 0.0))
    }

    /// Refuses light that is more than wholly polarized. All three are linear between the
    /// wavelengths at which it is looked for, and a ball holds what is between two of its points.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        for stokes in &self.stokes {
            stokes.check("stokes", COMPONENT)?;
        }
        let mut nm: Vec<f32> = self.stokes.iter().flat_map(Spectrum::knots_nm).collect();
        nm.extend(RGB_WAVELENGTHS_NM);
        for nm in nm {
            let at = Carried::at([nm]).beyond(Beyond::Held);
            let [state] = self.sampled(&at).unwrap_or_default();
            check_degree(state, || format!(" at {nm} nm"))?;
        }
        let of_channels = self.sampled(&Carried::RGB.beyond(Beyond::Held)).unwrap_or_default();
        let [red, green, blue] = of_channels.map(|state| check_degree(state, String::new));
        red.and(green).and(blue)
    }

    /// S1, S2 and S3 over S0 in the columns of a render.
    ///
    /// # Errors
    /// When a table does not cover them.
    pub(in crate::scene) fn sampled<const N: usize>(
        &self,
        carried: &Carried<N>,
    ) -> Result<[[f32; 3]; N], OutsideTable> {
        let mut states = [[0.0; 3]; N];
        for (component, spectrum) in self.stokes.iter().enumerate() {
            let values = spectrum.sample(carried, Role::Index)?;
            states.iter_mut().zip(values).for_each(|(state, value)| state[component] = value);
        }
        Ok(states)
    }
}

/// Refuses a state of more than the whole light.
fn check_degree([s1, s2, s3]: [f32; 3], place: impl Fn() -> String) -> Result<(), Fault> {
    let degree = (s1 * s1 + s2 * s2 + s3 * s3).sqrt();
    if degree <= 1.0 + DEGREE_TOLERANCE {
        return Ok(());
    }
    let place = place();
    let problem = format!("[{s1}, {s2}, {s3}]{place} has a degree of polarization of {degree}");
    let remedy = "give S1, S2 and S3 over S0, whose squares add up to 1 at most";
    Err(Fault::new("stokes", problem, remedy))
}
