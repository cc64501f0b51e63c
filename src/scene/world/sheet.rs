//! Sheets by what they do to light that goes straight on: real polarizers, retarders with
//! dispersion, both on each other, and given Mueller matrices.

use crate::math::{Fault, Range};
use crate::polarization::elements::{
    Matrix, circular, exact_sin_cos_deg, is_physical, polarizer_block, retarder_block,
};
use crate::spectrum::{RGB_WAVELENGTHS_NM, Role, Spectrum};

/// What a sheet does, from its front to its back, in the frame (x, y, k) whose x is the sheet's
/// axis. What it does the other way round follows from reciprocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action<S> {
    /// A polarizer whose axis is the sheet's.
    Polarizer(Grid<S>),
    /// A linear retarder whose fast axis is the sheet's.
    Retarder(Delay<S>),
    /// A polarizer at the front whose axis is the sheet's, and behind it a retarder whose fast axis
    /// is turned by 45 degrees from it: what passes to the back is circular, behind a quarter wave.
    Circular {
        /// The polarizer.
        polarizer: Grid<S>,
        /// The retarder.
        retarder: Delay<S>,
        /// The sense of what leaves the back.
        hand: Hand,
    },
    /// A Mueller matrix, row by row; its first element is the transmittance of unpolarized light.
    Matrix([S; 16]),
}

/// Transmittances of a polarizer, within [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<S> {
    /// Of light polarized along the axis.
    pub transmittance: S,
    /// Of light polarized across it.
    pub blocked: S,
}

/// By how much light polarized across the fast axis lags behind light polarized along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay<S> {
    /// In degrees.
    Degrees(S),
    /// By the difference of two indices of refraction over a length.
    Crystal {
        /// Slow index less fast index.
        birefringence: S,
        /// In nanometers in the world, in wavelengths in what is baked; not negative.
        thickness: S,
    },
}

/// A sense of circular polarization, as the receiver of the light sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hand {
    /// Clockwise: S3 > 0.
    #[default]
    Right,
    /// Counter-clockwise.
    Left,
}

impl Hand {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Right, Self::Left];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }

    /// The one of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|hand| hand.name() == name)
    }
}

impl<S> Grid<S> {
    fn sampled<T, E>(
        &self,
        sample: &mut impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<Grid<T>, E> {
        let transmittance = sample(&self.transmittance, "transmittance", Role::Reflectance)?;
        let blocked = sample(&self.blocked, "blocked", Role::Reflectance)?;
        Ok(Grid { transmittance, blocked })
    }
}

impl<S> Delay<S> {
    fn sampled<T, E>(
        &self,
        sample: &mut impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<Delay<T>, E> {
        Ok(match self {
            Self::Degrees(degrees) => {
                Delay::Degrees(sample(degrees, "retardance_deg", Role::Index)?)
            }
            Self::Crystal { birefringence, thickness } => {
                let birefringence = sample(birefringence, "birefringence", Role::Index)?;
                let thickness = sample(thickness, "thickness_um", Role::Waves)?;
                Delay::Crystal { birefringence, thickness }
            }
        })
    }
}

impl<S> Action<S> {
    /// The action with `sample` of its spectra, each by the name of its key and by what it is.
    ///
    /// # Errors
    /// Those of `sample`.
    pub(super) fn sampled<T, E>(
        &self,
        sample: &mut impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<Action<T>, E> {
        Ok(match self {
            Self::Polarizer(grid) => Action::Polarizer(grid.sampled(sample)?),
            Self::Retarder(delay) => Action::Retarder(delay.sampled(sample)?),
            Self::Circular { polarizer, retarder, hand } => {
                let (polarizer, retarder) = (polarizer.sampled(sample)?, retarder.sampled(sample)?);
                Action::Circular { polarizer, retarder, hand: *hand }
            }
            Self::Matrix(elements) => {
                let mut sampled = Vec::with_capacity(elements.len());
                for element in elements.iter() {
                    sampled.push(sample(element, "matrix", Role::Index)?);
                }
                match <[T; 16]>::try_from(sampled) {
                    Ok(elements) => Action::Matrix(elements),
                    Err(_) => unreachable!("16 elements were sampled"),
                }
            }
        })
    }
}

/// How much larger one of two values that are to be equal may be, relative to it: that by which
/// scaled and interpolated ones are off.
const ROUNDING: f32 = 1e-5;

impl Grid<Spectrum> {
    fn check(&self) -> Result<(), Fault> {
        self.transmittance.check("transmittance", Range::UNIT)?;
        self.blocked.check("blocked", Range::UNIT)?;
        let both = [&self.transmittance, &self.blocked];
        for nm in knots_of(both) {
            let [along, across] = both.map(|it| it.at(nm));
            // Wavelengths that one of them says nothing of are told where they are asked for.
            let (Ok(along), Ok(across)) = (along, across) else { continue };
            if across > along * (1.0 + ROUNDING) {
                let at = match both.iter().all(|it| it.is_flat()) {
                    true => String::new(),
                    false => format!(" at {nm} nm"),
                };
                let problem = format!("{across} is more than the transmittance, {along}{at}");
                let remedy = "exchange the two and turn `axis_deg` by 90";
                return Err(Fault::new("blocked", problem, remedy));
            }
        }
        Ok(())
    }
}

impl Delay<Spectrum> {
    fn check(&self) -> Result<(), Fault> {
        match self {
            Self::Degrees(degrees) => degrees.check("retardance_deg", Range::ANY),
            Self::Crystal { birefringence, thickness } => {
                birefringence.check("birefringence", Range::ANY)?;
                thickness.check("thickness_um", Range::NOT_NEGATIVE)
            }
        }
    }
}

impl Action<Spectrum> {
    /// Refuses what no sheet does.
    pub(super) fn check(&self) -> Result<(), Fault> {
        match self {
            Self::Polarizer(grid) => grid.check(),
            Self::Retarder(delay) => delay.check(),
            Self::Circular { polarizer, retarder, hand: _ } => {
                polarizer.check()?;
                retarder.check()
            }
            Self::Matrix(elements) => check_matrix(elements),
        }
    }
}

/// Wavelengths in nanometers that all of these spectra cover, and between which they are linear.
fn knots_of<'a>(spectra: impl IntoIterator<Item = &'a Spectrum>) -> Vec<f32> {
    let mut ends = [0.0, f32::INFINITY];
    let mut knots = RGB_WAVELENGTHS_NM.to_vec();
    for spectrum in spectra {
        if let Some([first, last]) = spectrum.ends_nm() {
            ends = [ends[0].max(first), ends[1].min(last)];
            knots.extend([first, last]);
        }
        knots.extend(spectrum.knots_nm());
    }
    knots.retain(|nm| (ends[0]..=ends[1]).contains(nm));
    knots
}

/// Refuses matrices that let more light leave than arrives, or more polarized than light can be, at
/// any wavelength: between knots the elements are linear, so that what holds there holds between.
fn check_matrix(elements: &[Spectrum; 16]) -> Result<(), Fault> {
    for element in elements {
        element.check("matrix", Range::ANY)?;
    }
    for nm in knots_of(elements) {
        let mut matrix = Matrix::default();
        for (index, element) in elements.iter().enumerate() {
            let found = element.at(nm).map_err(|error| {
                Fault::new("matrix", error.to_string(), "let all elements cover the same range")
            })?;
            matrix[index / 4][index % 4] = f64::from(found);
        }
        is_physical(&matrix).map_err(|problem| {
            let remedy = "scale all elements, or all but the first, down a little; measured ones \
                          may need the nearest matrix that is a mixture of Jones matrices";
            let at = if elements.iter().all(Spectrum::is_flat) {
                problem.to_owned()
            } else {
                format!("at {nm} nm {problem}")
            };
            Fault::new("matrix", at, remedy)
        })?;
    }
    Ok(())
}

impl<const N: usize> Grid<[f32; N]> {
    fn matrix(&self, n: usize) -> Matrix {
        let (along, across) = (self.transmittance[n], self.blocked[n]);
        let (m00, block) = polarizer_block(f64::from(along), f64::from(across));
        block.matrix().map(|row| row.map(|element| m00 * element))
    }
}

impl<const N: usize> Delay<[f32; N]> {
    fn degrees(&self, n: usize) -> f64 {
        match self {
            Self::Degrees(degrees) => f64::from(degrees[n]),
            Self::Crystal { birefringence, thickness } => {
                360.0 * f64::from(birefringence[n]) * f64::from(thickness[n])
            }
        }
    }
}

impl<const N: usize> Action<[f32; N]> {
    /// The Mueller matrix of a column, from front to back in the frame of the axis.
    pub fn matrix(&self, n: usize) -> Matrix {
        match self {
            Self::Polarizer(grid) => grid.matrix(n),
            Self::Retarder(delay) => retarder_block(delay.degrees(n)).matrix(),
            Self::Circular { polarizer, retarder, hand } => {
                let turned = match hand {
                    Hand::Right => 1.0,
                    Hand::Left => -1.0,
                };
                // Cosine and sine of twice 45 degrees.
                let (sin2, cos2) = exact_sin_cos_deg(turned * 90.0);
                let retarder = retarder_block(retarder.degrees(n)).matrix();
                circular(&polarizer.matrix(n), &retarder, [cos2, sin2])
            }
            Self::Matrix(elements) => {
                let mut matrix = Matrix::default();
                for (index, element) in elements.iter().enumerate() {
                    matrix[index / 4][index % 4] = f64::from(element[n]);
                }
                matrix
            }
        }
    }
}
