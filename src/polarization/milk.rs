//! Milk from its contents, after Frisvad, Christensen and Jensen 2007, "Computing the Scattering
//! Properties of Participating Media Using Lorenz-Mie Theory", section 6: fat globules and casein
//! micelles in water with riboflavin.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::particles::log_normal_parameters;
use super::particles::{Amount, Law, Particles, Sizes, Suspension};
use crate::math::{Fault, Range};

/// First wavelength of the tables and their step, in nanometers.
const FIRST_NM: f64 = 375.0;
const STEP_NM: f64 = 25.0;
const ROWS: usize = 17;

/// Index of refraction of water: Hale and Querry 1973.
const WATER_N: [f64; ROWS] = [
    1.341, 1.339, 1.338, 1.337, 1.336, 1.335, 1.334, 1.333, 1.333, 1.332, 1.332, 1.331, 1.331,
    1.331, 1.330, 1.330, 1.330,
];
/// Extinction coefficient of water: Pope and Fry 1997, Hale and Querry 1973.
const WATER_K: [f64; ROWS] = [
    3.393e-10, 2.110e-10, 1.617e-10, 3.302e-10, 4.309e-10, 8.117e-10, 1.742e-9, 2.473e-9, 3.532e-9,
    1.062e-8, 1.410e-8, 1.759e-8, 2.406e-8, 3.476e-8, 8.591e-8, 1.474e-7, 1.486e-7,
];
/// Index of refraction of milk fat: Michalski, Briard and Michel 2001.
const FAT_N: [f64; ROWS] = [
    1.480, 1.476, 1.473, 1.470, 1.468, 1.466, 1.464, 1.463, 1.462, 1.461, 1.460, 1.459, 1.458,
    1.457, 1.457, 1.456, 1.456,
];
/// Extinction coefficient of milk fat: as before.
const FAT_K: [f64; ROWS] = [
    4.0e-6, 6.4e-6, 8.6e-6, 1.14e-5, 1.10e-5, 1.00e-5, 4.7e-6, 4.6e-6, 4.7e-6, 4.9e-6, 5.0e-6,
    5.0e-6, 5.1e-6, 5.2e-6, 5.2e-6, 5.2e-6, 5.2e-6,
];
/// Absorbance of riboflavin: Du et al. 1998 (PhotochemCAD), where that at 266.5 nm is 0.25654.
const RIBOFLAVIN_ABSORBANCE: [f64; ROWS] = [
    0.07117, 0.05934, 0.07215, 0.08300, 0.06379, 0.01962, 0.00950, 0.00957, 0.01198, 0.01047,
    0.01046, 0.01061, 0.00671, 0.01034, 0.00589, 0.00886, 0.01015,
];
/// Molar absorption coefficient of riboflavin at 266.5 nm in 1/(M m), Koziol 1966, over the
/// absorbance there.
const RIBOFLAVIN_SCALE: f64 = 3.3e6 / 0.25654;
/// Riboflavin in milk in mol per 100 g: 0.17 mg (Fox and McSweeney 1998) of 376.3682 g/mol.
const RIBOFLAVIN_PER_100_G: f64 = 0.17e-3 / 376.3682;

/// Densities in g/ml.
const MILK_DENSITY: f64 = 1.030;
const FAT_DENSITY: f64 = 0.915;
const CASEIN_DENSITY: f64 = 1.11;
/// Share of casein in the proteins, by weight.
const CASEIN_IN_PROTEIN: f64 = 0.76;
/// Index of refraction of casein, as Frisvad et al. use it.
const CASEIN_N: f64 = 1.503;

/// Fat globules of homogenized milk: mean and standard deviation of the radius by volume, and the
/// range of radii, in micrometers.
const FAT_MEAN_UM: f64 = 0.475;
const FAT_SD_UM: f64 = 0.285;
const FAT_RANGE_UM: [f64; 2] = [0.005, 10.0];
/// Casein micelles have radii r up to 0.15 um, and `r / (0.15 um - r)` is log-normal by volume
/// with the mean of r = 0.043 um and this standard deviation.
const CASEIN_MAX_UM: f64 = 0.15;
const CASEIN_MEAN_UM: f64 = 0.043;
const CASEIN_SD: f64 = 0.23;

/// Shares by weight.
const PERCENT: Range = Range::new("within [0, 100]", |x| (0.0..=100.0).contains(&x));

/// Milk, or milk in water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Milk {
    /// Fat in the milk in percent by weight: 3.5 in whole milk, 0.1 in skimmed milk.
    pub fat_percent: f64,
    /// Protein in the milk in percent by weight: 3.4 in cow's milk.
    pub protein_percent: f64,
    /// Share of milk, by volume, in what is left of it after it was diluted with water: 1 is
    /// pure milk.
    pub dilution: f64,
}

/// What milk's water absorbs at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Serum {
    /// Absorption coefficient of riboflavin in 1/m.
    pub sigma_a_riboflavin: f64,
    /// Absorption coefficient of water in 1/m, as if nothing displaced it.
    pub sigma_a_water: f64,
}

/// The wavelengths in nanometers for which milk is known: those of the tables, and one step more
/// at the red end, where the last rows hold: indices are flat there, to 0.001 a step, and water has
/// a k of 1.25e-7 at 800 nm instead of 1.49e-7 (Hale and Querry 1973), 0.4 per meter less.
pub const MILK_WAVELENGTHS_NM: [f64; 2] = [FIRST_NM, FIRST_NM + STEP_NM * ROWS as f64];

impl Milk {
    /// Refuses what is no milk: percentages out of range, or that leave nothing that scatters, or
    /// no water.
    ///
    /// # Errors
    /// With the field and the remedy.
    pub fn check(&self) -> Result<(), Fault> {
        PERCENT.check("fat_percent", self.fat_percent)?;
        PERCENT.check("protein_percent", self.protein_percent)?;
        Range::FRACTION.check("dilution", self.dilution)?;
        let filled: f64 = self.volume_fractions().iter().sum();
        if filled > 1e-12 && filled < 1.0 {
            return Ok(());
        }
        let problem = format!("fat and casein would fill {filled} of the volume");
        Err(Fault::new("", problem, "give percentages by weight"))
    }

    /// Shares of the volume: fat, casein.
    pub fn volume_fractions(&self) -> [f64; 2] {
        let weight = self.dilution * MILK_DENSITY / 100.0;
        let casein_percent = CASEIN_IN_PROTEIN * self.protein_percent;
        [weight * self.fat_percent / FAT_DENSITY, weight * casein_percent / CASEIN_DENSITY]
    }

    /// Size parameter of the greatest particle at a wavelength in nanometers.
    pub fn size_parameter_max(&self, wavelength_nm: f64) -> f64 {
        let radius_um = if self.fat_percent > 0.0 { FAT_RANGE_UM[1] } else { CASEIN_MAX_UM };
        2.0 * PI * interpolate(&WATER_N, wavelength_nm) * radius_um / (1e-3 * wavelength_nm)
    }

    /// Fat and casein in water, at a wavelength within [`MILK_WAVELENGTHS_NM`]. Fat or protein, and
    /// the dilution, are greater than zero.
    pub fn suspension(&self, wavelength_nm: f64) -> Suspension<'static> {
        let at = |table: &[f64; ROWS]| interpolate(table, wavelength_nm);
        let [fat, casein] = &*SIZES;
        let [fat_fraction, casein_fraction] = self.volume_fractions();
        let (n, k) = (at(&FAT_N), at(&FAT_K));
        let mut particles = vec![
            Particles { sizes: fat, n, k, volume_fraction: fat_fraction },
            Particles { sizes: casein, n: CASEIN_N, k: 0.0, volume_fraction: casein_fraction },
        ];
        particles.retain(|particles| particles.volume_fraction > 0.0);
        Suspension { particles, host_n: at(&WATER_N), wavelength_nm }
    }

    /// What absorbs beside fat and casein, at a wavelength within [`MILK_WAVELENGTHS_NM`].
    pub fn serum(&self, wavelength_nm: f64) -> Serum {
        let wave_number = 2.0 * PI / (1e-9 * wavelength_nm);
        let at = |table: &[f64; ROWS]| interpolate(table, wavelength_nm);
        // Decadic molar absorption times moles per liter of milk.
        let riboflavin = at(&RIBOFLAVIN_ABSORBANCE) * RIBOFLAVIN_SCALE * std::f64::consts::LN_10;
        let concentration = RIBOFLAVIN_PER_100_G / (0.1 / MILK_DENSITY);
        Serum {
            sigma_a_riboflavin: self.dilution * riboflavin * concentration,
            sigma_a_water: 2.0 * wave_number * at(&WATER_K),
        }
    }
}

/// Those of all milk.
static SIZES: LazyLock<[Sizes; 2]> = LazyLock::new(sizes);

/// Radii of fat globules and casein micelles.
fn sizes() -> [Sizes; 2] {
    let fat = Sizes::log_normal(FAT_MEAN_UM, FAT_SD_UM, Amount::Volume, Some(FAT_RANGE_UM));
    let turned = |radius: f64| radius / (CASEIN_MAX_UM - radius);
    let parameters = log_normal_parameters(turned(CASEIN_MEAN_UM), CASEIN_SD);
    let range = [1e-2 * CASEIN_MAX_UM, (1.0 - 1e-9) * CASEIN_MAX_UM];
    let law = Law::LogNormalBelow { limit_um: CASEIN_MAX_UM, parameters };
    let casein = Sizes::new(law, Amount::Volume, range);
    // Both are constants with particles in their ranges; a unit test looks at them.
    [fat, casein].map(|sizes| sizes.unwrap_or_else(|_| Sizes::alone(FAT_MEAN_UM)))
}

fn interpolate(table: &[f64; ROWS], wavelength_nm: f64) -> f64 {
    let position = ((wavelength_nm - FIRST_NM) / STEP_NM).clamp(0.0, (ROWS - 1) as f64);
    let row = (position as usize).min(ROWS - 2);
    let share = position - row as f64;
    table[row] * (1.0 - share) + table[row + 1] * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_the_radii_that_were_measured() {
        let [fat, casein] = sizes();
        assert!((fat.mean_radius_um() - FAT_MEAN_UM).abs() < 1e-3, "{fat:?}");
        assert!(fat.radius_max_um() > 9.8 && casein.radius_max_um() > 0.148);
        assert!((casein.mean_radius_um() - CASEIN_MEAN_UM).abs() < 0.01, "{casein:?}");
    }

    #[test]
    fn tables_are_read_linearly_between_their_rows() {
        assert_eq!(interpolate(&WATER_N, 375.0), 1.341);
        assert_eq!(interpolate(&WATER_N, 550.0), 1.333);
        assert_eq!(interpolate(&WATER_N, 775.0), 1.330);
        assert!((interpolate(&FAT_N, 387.5) - 1.478).abs() < 1e-12);
    }
}
